"""From the settings of a case to a coupling scheme, and what its steps took."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..base.errors import AeroSloshError
from ..fmi.component import Component
from . import acceleration, ordering
from .coupling_settings import Coupling
from .implicit import Criteria, Implicit
from .scheme import GaussSeidel, Jacobi, Scheme, StepEnd, StepReport
from .substeps import Pace
from .system import System, Wire

KEPT = 20  # unconverged steps that are listed one by one
PREDICTIONS = ("load_prediction", "motion_prediction")  # parameters by which our FMUs extrapolate their inputs themselves


def make(settings: Coupling) -> Scheme:
    """The scheme of the table [coupling]. Raises AeroSloshError for settings that it has no use for."""
    if settings.scheme != Implicit.name and (settings.tolerance_of or settings.absolute_tolerance_of):
        raise AeroSloshError(
            f'Tolerances of single quantities have no effect with coupling.scheme = "{settings.scheme}"',
            "coupling.tolerance_of, coupling.absolute_tolerance_of",
            'leave them out, or take coupling.scheme = "implicit"',
        )
    if settings.scheme == Jacobi.name:
        return Jacobi(settings.extrapolated)
    if settings.scheme == GaussSeidel.name:
        return GaussSeidel(settings.extrapolated)
    criteria = Criteria(
        settings.tolerance,
        settings.absolute_tolerance,
        settings.tolerance_of,
        settings.absolute_tolerance_of,
        settings.max_iterations,
        settings.stall_iterations,
        settings.retries,
    )
    faster = acceleration.make(settings.acceleration, settings.relaxation, settings.reuse_steps, settings.filter)
    return Implicit(settings.extrapolated, criteria, faster)


def assemble(
    components: Sequence[Component], connections: Sequence[Wire], settings: Coupling, surrogates: Mapping[str, Component]
) -> System:
    """The system in the order and at the paces of the table [coupling]. Raises AeroSloshError for names of no component."""
    names = [c.name for c in components]
    for table in ("substeps", "waveform"):
        for name in getattr(settings, table):
            if name not in names:
                raise AeroSloshError(
                    f"coupling.{table}: there is no component '{name}'",
                    f"coupling.{table}",
                    f"components are: {', '.join(names)}",
                )
    _refuse_double_prediction(components, settings)
    links = [(wire.source.split(".")[0], wire.target.split(".")[0]) for wire in connections]
    known = [(a, b) for a, b in links if a in names and b in names]  # others: the system refuses them, with a remedy
    order = ordering.arrange(names, known, settings.order)
    paces = {}
    for name in names:
        substeps = settings.substeps.get(name, 1)
        # where none is named, the inputs of substeps run linearly
        paces[name] = Pace(substeps, settings.waveform.get(name, "linear" if substeps > 1 else "hold"))
    return System([components[names.index(name)] for name in order], connections, paces, surrogates)


def _refuse_double_prediction(components: Sequence[Component], settings: Coupling) -> None:
    """An FMU that extrapolates its inputs takes them as values of the start of the step: only a Jacobi of order 0 gives those."""
    if settings.scheme == Jacobi.name and settings.extrapolated == 0:
        return
    for component in components:
        for name in PREDICTIONS:
            if component.given.get(name):
                raise AeroSloshError(
                    f"{component.name}.{name} = 1: the FMU extrapolates its inputs, and so does the master (coupling.scheme = "
                    f'"{settings.scheme}", predictor_order = {settings.extrapolated})',
                    "coupling.predictor_order",
                    f'leave {name} out, or take coupling.scheme = "jacobi" with predictor_order = 0',
                )


class Statistics:
    """Counts over the steps of a march."""

    def __init__(self) -> None:
        self.steps = self.passes = self.most = self.retried = 0
        self.outcomes: Counter[StepEnd] = Counter()
        self.unconverged: list[dict[str, Any]] = []

    @property
    def failed(self) -> int:
        """Steps that did not converge."""
        return self.steps - self.outcomes[StepEnd.CONVERGED]

    def note(self, report: StepReport, time: float) -> None:
        """One step, which ended at `time` [s]."""
        self.steps += 1
        self.passes += report.passes
        self.most = max(self.most, report.passes)
        self.outcomes[report.outcome] += 1
        self.retried += report.attempts > 1
        if not report.converged and len(self.unconverged) < KEPT:
            change = report.change if np.isfinite(report.change) else None
            entry = {"time": time, "outcome": report.outcome, "change": change, "worst": report.worst}
            self.unconverged.append(entry | {"passes": report.passes})

    def data(self) -> dict[str, Any]:
        """For the JSON result."""
        return {
            "steps": self.steps,
            "passes": self.passes,
            "passes_mean": self.passes / self.steps if self.steps else None,
            "passes_max": self.most,
            "retried_steps": self.retried,
            "outcomes": {str(k): n for k, n in self.outcomes.items()},
            "unconverged": self.unconverged,
        }

    def restore(self, data: Mapping[str, Any]) -> None:
        """Go on counting from `data` of an earlier part of the march."""
        self.steps, self.most, self.retried = data["steps"], data["passes_max"], data["retried_steps"]
        self.passes = data["passes"]
        self.outcomes, self.unconverged = Counter({StepEnd(k): n for k, n in data["outcomes"].items()}), list(data["unconverged"])
