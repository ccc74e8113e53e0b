"""Aero kernels, 168 x 48 = 8,064 cells, one thread: nanoseconds a cell, and how many the machine's memory alone would take.

The triad a = b + s c streams arrays as large as the line solver's factors: what a kernel's bytes would take at that pace says
whether its memory or its arithmetic is what it waits for."""

from __future__ import annotations

import numpy as np

from aeroslosh.fmus.aero.implicit import Factors
from aeroslosh.fmus.aero.march import Flow
from aeroslosh.fmus.aero.mesh import o_mesh
from aeroslosh.fmus.kit.compiled import jit

from .timing import cpu

FIELD = 4 * 8  # bytes of four variables of a cell


@jit
def _triad(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> None:
    for i in range(a.size):
        a[i] = b[i] + 3.0 * c[i]


def run() -> None:
    """Print residual, line solve, factorisation and mesh."""
    mesh = o_mesh("64A010", 168, 48, 200.0)
    cells = mesh.volume.size
    flow = Flow(mesh, 0.8, -0.5)
    flow.start(0.01)
    flow.evaluate()
    factors = flow.linearised(3.0, 20.0)
    x = np.zeros_like(flow.q)
    a, b, c = (np.ones(_bytes(factors) // 24) for _ in range(3))  # together as large as the factors
    a_byte = cpu(lambda: _triad(a, b, c), inner=200) / (3 * a.nbytes)
    print(f"  triad over {3e-6 * a.nbytes:.1f} MB: {1e-9 / a_byte:.0f} GB/s")
    rows = {
        # flow, metrics of two families of faces, fluxes
        "residual (float64)": (cpu(flow.evaluate, inner=200), 4 * FIELD),
        "residual (float32)": (cpu(lambda: flow.evaluate(np.float32), inner=200), 3 * FIELD),
        "line solve (packed factors)": (cpu(lambda: factors.solve(flow.out, x), inner=200), _bytes(factors) / cells + 2 * FIELD),
        "linearise and factorise": (cpu(lambda: flow.linearised(3.0, 20.0)), 0),
        "mesh": (cpu(lambda: o_mesh("64A010", 168, 48, 200.0)), 0),
    }
    for name, (seconds, size) in rows.items():
        pace = f"   its {size:.0f} bytes by the triad: {1e9 * size * a_byte:.1f} ns" if size else ""
        print(f"  {name:30s} {1e9 * seconds / cells:8.1f} ns a cell {1e3 * seconds:9.3f} ms{pace}")


def _bytes(factors: Factors) -> int:
    """Of the factors that a solve reads."""
    return factors._around.nbytes + factors._across.nbytes
