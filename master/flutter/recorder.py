"""The history of a march: which channels, and how they are collected step by step."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..case.scales import Scales
from .setup import FlutterSetup

REALS = {  # history channel: (component, output, unit, long name)
    "h": ("structure", "h", "m", "plunge of the elastic axis, positive down"),
    "h_dot": ("structure", "h_dot", "m s-1", "plunge rate"),
    "h_ddot": ("structure", "h_ddot", "m s-2", "plunge acceleration"),
    "alpha": ("structure", "alpha", "rad", "pitch about the mean, nose-up"),
    "alpha_dot": ("structure", "alpha_dot", "rad s-1", "pitch rate"),
    "alpha_ddot": ("structure", "alpha_ddot", "rad s-2", "pitch acceleration"),
    "lift": ("aero", "lift", "N m-1", "lift per span, positive up"),
    "moment": ("aero", "moment", "N", "moment per span about the elastic axis, nose-up"),
    "C_L": ("aero", "C_L", "1", "lift coefficient"),
    "C_M": ("aero", "C_M", "1", "moment coefficient about the elastic axis, nose-up"),
    "C_D": ("aero", "C_D", "1", "drag coefficient"),
    "residual": ("aero", "residual", "1", "residual of the last subiteration"),
    "slosh_force_x": ("slosh", "force_x", "N m-1", "force of the liquid on the tank, positive aft"),
    "slosh_force_y": ("slosh", "force_y", "N m-1", "force of the liquid on the tank, weight included, positive up"),
    "slosh_moment": ("slosh", "moment", "N", "moment of the liquid about the elastic axis, weight included, nose-up"),
    "slosh_force_y_residual": ("slosh", "force_y_residual", "N m-1", "slosh_force_y less that of the frozen liquid"),
    "slosh_moment_residual": ("slosh", "moment_residual", "N", "slosh_moment less that of the frozen liquid"),
    "wave_height_west": ("slosh", "wave_height_west", "m", "surface above its level at rest at the fore wall"),
    "wave_height_east": ("slosh", "wave_height_east", "m", "surface above its level at rest at the aft wall"),
    "slosh_wave_growth": ("slosh", "wave_growth", "1", "logarithm of the growth of waves that gravity's changes feed (Faraday)"),
    "slosh_validity": ("slosh", "validity", "1", "above 1 the slosh model does not hold (largest since the start)"),
    "slosh_validity_edge": ("slosh", "validity_edge", "1", "up to this slosh_validity the work of the slosh loads holds"),
}


class History:
    """Collects the channels step by step into preallocated arrays."""

    def __init__(self, setup: FlutterSetup, n: int) -> None:
        self._rig = setup
        running = {c.name: c.output_index for c in setup.system.components}
        # a slosh model tells what it has; the other components always have a column
        columns = [n for n, (c, out, _, _) in REALS.items() if c in running and (c != "slosh" or out in running[c])]
        self.values = {name: np.zeros(n) for name in columns}
        self.values |= {"subiterations": np.zeros(n), "passes": np.zeros(n)}
        self._places = [
            (
                name,
                setup.system[component].outputs.values,
                setup.system[component].output_index[output],
            )
            for name, (component, output, _, _) in REALS.items()
            if name in self.values and output in running[component]
        ]
        self._reals = [(self.values[name], outputs, position) for name, outputs, position in self._places]
        whole = setup.aero.whole
        self._subiterations = whole.names.index("subiterations") if "subiterations" in whole.names else None
        self._converged = [
            (c.name, c.truth, c.truth.names.index("converged")) for c in setup.system.components if "converged" in c.truth.names
        ]

    def take(self, i: int, passes: int = 0) -> list[str]:
        """Note sample `i`; returns the names of the components that say they did not converge."""
        for column, outputs, position in self._reals:
            column[i] = outputs[position]
        self.values["passes"][i] = passes
        if self._subiterations is not None:
            self._rig.aero.whole.get()
            self.values["subiterations"][i] = self._rig.aero.whole.values[self._subiterations]
        for _, truth, _ in self._converged:
            truth.get()
        return [name for name, truth, place in self._converged if not truth.values[place]]

    def extend(self, n: int) -> None:
        """Room for `n` samples in all."""
        for name, column in self.values.items():
            self.values[name] = np.concatenate([column, np.zeros(n - column.size)])
        self._reals = [(self.values[name], outputs, position) for name, outputs, position in self._places]

    def restore(self, values: Mapping[str, np.ndarray]) -> None:
        """Samples of an earlier part of the march, each (n,)."""
        for name, column in values.items():
            self.values[name][: column.size] = column

    def finish(self, n: int, s: Scales) -> dict[str, np.ndarray]:
        """The first `n` samples with time, tau and h/b."""
        time = np.arange(n) * s.dt
        table = {"time": time, "tau": time * s.omega_alpha, "h_over_b": self.values["h"][:n] / s.half_chord}
        return table | {name: column[:n].copy() for name, column in self.values.items()}
