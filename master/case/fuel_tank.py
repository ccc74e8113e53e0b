"""The liquid in the flutter set-up: which FMU computes it, its settings, and how its load reaches the structure.

Two ways lead to the same equations of motion. split "frozen": the structure carries the frozen liquid on its left side
(`liquid_*`) and takes the residual loads, which are small: one pass is enough. split "none": a dry structure takes the whole
loads; their inertia part must be lagged or iterated. The model "frozen" is the left side alone: the liquid's constants come from
the slosh FMU at rest, which is then not stepped. Whatever load the liquid has at rest is trimmed out, like the steady lift.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from ..base.errors import AeroSloshError
from ..fmi.component import Component
from . import case as cases
from . import fmu_parameters

FMU = fmu_parameters.FMU
LABEL = {"none": "dry", "frozen": "frozen liquid", "ems": "linear slosh (EMS)", "rbf": "slosh (RBF)", "vof": "slosh (VOF)"}
LOADS = {"frozen": ("force_y_residual", "moment_residual"), "none": ("force_y", "moment")}  # split → outputs that are wired
MOTION = ("h", "h_dot", "h_ddot", "alpha", "alpha_dot", "alpha_ddot")
CARRIED = ("liquid_mass", "liquid_static_moment", "liquid_inertia", "liquid_stiffness")
SHAPES = ("initial_wave", "initial_spectrum", "initial_column", "initial_file")  # parameters that raise the surface at the start
PERTURBATION = 1e-5  # [m] largest rise of the waves by which members of an ensemble differ
EDGE = 1.0  # of a slosh FMU's output `validity`: above it the model does not hold, unless its `validity_edge` says another
# keys of the table [slosh] that are no parameters of an FMU
CASE_ONLY = ("model", "predictor", "split", "members", "seed", fmu_parameters.KEY)


def needed(models: Sequence[str]) -> tuple[str, ...]:
    """The FMUs that models of the liquid need beside structure and aero."""
    return tuple(FMU[model] for model in models if model in FMU)


def holds(validity: float | None, edge: float = EDGE) -> bool:
    """Whether a model with this validity holds; one that tells nothing (dry, frozen, two-phase flow) is taken to."""
    return validity is None or validity <= edge


def broken(validity: float, edge: float = EDGE) -> str:
    """What a validity above the edge means, in words."""
    return f"the slosh model does not hold (validity {validity:.3g}, edge {edge:g})"


def averaged(validity: float, edge: float) -> str:
    """What a validity between EDGE and another edge means, in words."""
    return f"loads of a breaking surface on average, single runs scatter about them (validity {validity:.3g}, edge {edge:g})"


def wiring(split: str) -> list[str]:
    """Wires between the components `structure` and `slosh`."""
    force, moment = LOADS[split]
    back = [f"slosh.{force} -> structure.slosh_force_y", f"slosh.{moment} -> structure.slosh_moment"]
    return [f"structure.{name} -> slosh.{name}" for name in MOTION] + back


def parameters(settings: cases.Slosh, known: dict[str, Any]) -> dict[str, float | int | bool | str]:
    """The FMU's parameters among the keys of [slosh] and [slosh.parameters]: those it has (`known`: name → FMPy's variable), but
    "auto" leaves its own value."""
    values = {f.name: getattr(settings, f.name) for f in dataclasses.fields(settings) if f.name not in CASE_ONLY}
    found = {name: value for name, value in values.items() if value != "auto" and name in known}
    return found | fmu_parameters.values(settings.parameters, known)


@dataclass(frozen=True)
class Liquid:
    """The frozen liquid per metre of span, about the elastic axis."""

    mass: float  # [kg/m]
    static_moment: float  # [kg]
    inertia: float  # [kg m]
    stiffness: float  # [N/rad]

    def matrices(self) -> tuple[np.ndarray, np.ndarray]:
        """Mass and stiffness matrix of (h, alpha) [kg/m, kg, kg m; N/rad]. Shapes: (2, 2), (2, 2)."""
        M = np.array([[self.mass, self.static_moment], [self.static_moment, self.inertia]])
        return M, np.diag([0.0, self.stiffness])


class Tank:
    """The slosh FMU of a case. `model` may not be "none".

    liquid   what the structure carries, or would carry frozen
    carried  parameters of the structure: `liquid_*`, or none with split "none"
    rest     (force up [N/m], moment nose-up [N]) of the wired loads at rest, to be trimmed out
    moving   the component to step, named "slosh"; None for the model "frozen"
    surrogate  the cheaper model that predicts it, named "slosh_predictor"; None without
    validity   what the FMU tells of its validity at rest; None where it tells none
    edge       of its validity
    Raises ComponentError when the FMU fails, AeroSloshError when it is none of a slosh model."""

    def __init__(self, settings: cases.Slosh, fmus: dict[str, Path]) -> None:
        path, self._settings = fmus[FMU[settings.model]], settings
        self.moving: Component | None = None
        self.surrogate: Component | None = None
        try:
            self._open(settings, fmus, path)
        except BaseException:
            self.close()
            raise

    def _open(self, settings: cases.Slosh, fmus: dict[str, Path], path: Path) -> None:
        """The instances, and what the liquid says of itself at rest."""
        component = self.moving = Component(path, "slosh")
        missing = [name for name in (*CARRIED, *LOADS["none"], *LOADS["frozen"]) if name not in component.output_index]
        if missing:
            raise AeroSloshError(
                f"{path.name} has no Real output {', '.join(missing)}", str(path), "give an FMU of a slosh model"
            )
        self._parameters = parameters(settings, component.variables)
        component.set_all(self._parameters)
        component.initialize()
        self.liquid = Liquid(*(component.get(name) for name in CARRIED))
        split = "frozen" if settings.model == "frozen" else settings.split
        self.carried = {name: component.get(name) for name in CARRIED} if split == "frozen" else {}
        force, moment = LOADS[split]
        self.rest = (component.get(force), component.get(moment))
        # where the surface is not level at the start what is trimmed out is the level one
        if any(self._parameters.get(name) for name in SHAPES):
            names = ("static_force_y", "static_moment")
            self.rest = (0.0, 0.0) if split == "frozen" else (component.get(names[0]), component.get(names[1]))
        tells = settings.model != "frozen" and "validity" in component.output_index
        self.validity = component.get("validity") if tells else None
        self.edge = component.get("validity_edge") if "validity_edge" in component.output_index else EDGE
        self.sha256 = component.sha256
        if settings.predictor != "none" and settings.model != "frozen":
            self.surrogate = Component(fmus[FMU[settings.predictor]], "slosh_predictor")
            self._surrogate_parameters = parameters(settings, self.surrogate.variables)
            self.surrogate.set_all(self._surrogate_parameters)
        if settings.model == "frozen":  # its constants are all there is to it: the load at rest is the weight, held by the trim
            component.close()
            self.moving, self.rest = None, (0.0, 0.0)

    @property
    def static_stiffness(self) -> float:
        """Pitch stiffness of the liquid at rest [N/rad per metre of span]; one that moves keeps its surface level, which takes
        rho g L^3 w / 12 of it, as in a ship's tank; baffles from the bottom through the surface and ribs without openings make
        shorter tanks of it."""
        s, baffles = self._settings, self._parameters
        level = 0.0 if s.model == "frozen" else s.liquid_density * s.gravity * s.tank_length**3 * s.tank_width / 12.0
        parted = baffles.get("baffle_bottom", 0.0) == 0.0 and float(baffles.get("baffle_top", 0.5)) >= s.fill_level
        level /= (int(baffles.get("baffle_count", 0)) + 1) ** 2 if parted else 1
        # the FMU has read the text, and refused what it cannot: "x=0.1 open=0:0.02; x=-0.1", closed where nothing is open
        ribs = [part for part in str(baffles.get("ribs", "")).split(";") if part.strip() and "open=" not in part]
        closed = sorted(float(part.strip().removeprefix("x=")) / s.tank_length for part in ribs)
        if closed:
            level *= sum((east - west) ** 3 for west, east in pairwise([-0.5, *closed, 0.5]))
        return self.liquid.stiffness - level

    def _disturbance(self, seed: int) -> dict[str, Any]:
        """Parameters of the waves by which a member of an ensemble differs; the case's own spectrum takes another seed."""
        if not seed or self._settings.model != "vof":
            return {}
        return {"initial_spectrum": self._parameters.get("initial_spectrum") or PERTURBATION, "initial_seed": seed}

    def close(self) -> None:
        """Free the instances."""
        for component in (self.moving, self.surrogate):
            if component is not None:
                component.close()

    def restart(self, seed: int) -> None:
        """A liquid at rest, to be initialised with the section; `seed`: slosh.seed of the member."""
        if self.moving is not None:
            self.moving.restart()
            self.moving.set_all(self._parameters | self._disturbance(seed))
        if self.surrogate is not None:
            self.surrogate.restart()
            self.surrogate.set_all(self._surrogate_parameters)
