"""Aero kernels, 168 x 48 = 8,064 cells, one thread: nanoseconds a cell."""

from __future__ import annotations

import numpy as np

from aeroslosh.fmus.aero.march import Flow
from aeroslosh.fmus.aero.mesh import o_mesh

from .timing import cpu


def run() -> None:
    """Print residual, line solve, factorisation and mesh."""
    mesh = o_mesh("64A010", 168, 48, 200.0)
    cells = mesh.volume.size
    flow = Flow(mesh, 0.8, -0.5)
    flow.start(0.01)
    flow.evaluate()
    factors = flow.linearised(3.0, 20.0)
    x = np.zeros_like(flow.q)
    rows = {
        "residual (float64)": cpu(flow.evaluate, inner=200),
        "line solve (float32 factors)": cpu(lambda: factors.solve(flow.out, x), inner=200),
        "linearise and factorise": cpu(lambda: flow.linearised(3.0, 20.0)),
        "mesh": cpu(lambda: o_mesh("64A010", 168, 48, 200.0)),
    }
    for name, seconds in rows.items():
        print(f"  {name:30s} {1e9 * seconds / cells:8.1f} ns a cell {1e3 * seconds:9.3f} ms")
