"""The flutter boundary: every Mach number's neutral V_f, kept as it is found, and what a program gets of it."""

from __future__ import annotations

import json
import os
import time as clock
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base import disk, interrupts
from ..base.errors import AeroSloshError, InternalError
from ..base.wording import plus_minus
from ..boundary import modes, solve
from ..boundary.search import BoundaryPoint
from ..case import case as cases
from ..case import fuel_tank
from ..cosim.loop import Watcher
from ..flutter.march import March
from ..flutter.setup import FlutterSetup, find_fmus
from ..results import by_value, summary, trust
from ..results.history_writer import write_history
from ..results.provenance import provenance
from ..results.run_folder import RunFolder
from . import datasets, plots
from .case import Case
from .point import check_fmus, draw_section, fmu_folder, section_file, warned, with_changes
from .progress import Callback, Cancelled, Reporter, interruptible, reporter

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

PUBLISHED = Path(__file__).resolve().parents[1] / "boundary" / "published.csv"
CROSSING = (
    "mach", "V_f", "V_f_uncertainty", "frequency", "kind", "direction", "name", "source", "tolerance_met", "slope",
)  # fmt: skip
MARCH = ("mach", "V_f", "verdict", "growth_rate", "growth_rate_uncertainty", "frequency", "free_cycles", "settled", "reason")


@dataclass
class Boundary:
    """Neutral V_f of several Mach numbers.

    data    the numbers, as in result.json: `points` (one a Mach number), `unfinished` (Mach numbers not computed)
    folder  the run folder, None where nothing was written"""

    case: Case | None
    data: dict[str, Any]
    folder: Path | None = None

    @property
    def crossings(self) -> pd.DataFrame:
        """Every neutral V_f, a row each: mach, V_f, its standard deviation, frequency (over omega_alpha), kind ("flutter" or
        "divergence"), direction ("onset" or "recovery"), name, source ("march" or "linear"), tolerance_met, slope."""
        rows = []
        for p in self.data["points"]:
            for c in p["crossings"]:
                name = "divergence" if c["kind"] == "divergence" else c["direction"]
                rows.append({"mach": p["mach"], "name": name} | c)
        return datasets.table(rows, CROSSING)

    @property
    def outcomes(self) -> dict[float, str]:
        """Mach number → what was found, in words."""
        return {p["mach"]: p["outcome"] for p in self.data["points"]}

    @property
    def marches(self) -> pd.DataFrame:
        """Every march of the search: mach, V_f, verdict, growth rate and its standard deviation, frequency, …"""
        return datasets.table([m for p in self.data["points"] for m in p["marches"]], MARCH)

    @property
    def finished(self) -> bool:
        """Whether every Mach number was computed."""
        return not self.data.get("unfinished")

    def modes(self, V_f: float | None = None, mach: float | None = None) -> pd.DataFrame:
        """Growth rate, frequency (over omega_alpha) and damping g of every mode of the linear model over V_f, a row each: mach,
        mode, V_f, growth_rate, frequency, damping; at one `V_f` by linear interpolation, at one `mach` where it is given.

        Empty where the boundary was searched by marches alone."""
        columns = ("mach", "mode", "V_f", "growth_rate", "frequency", "damping")
        rows = []
        for p in self.data["points"]:
            if mach is not None and p["mach"] != mach:
                continue
            for number, mode in enumerate((p["linear"] or {}).get("modes", []), start=1):
                arrays = {k: np.array([np.nan if x is None else x for x in v], dtype=float) for k, v in mode.items()}
                places = arrays["V_f"] if V_f is None else np.array([V_f])
                inside = (places >= arrays["V_f"][0]) & (places <= arrays["V_f"][-1])
                found = {k: np.interp(places, arrays["V_f"], v) for k, v in arrays.items()}
                for i in np.flatnonzero(inside & ~np.isnan(found["growth_rate"])):
                    rows.append({"mach": p["mach"], "mode": number} | {k: float(v[i]) for k, v in found.items()})
        return datasets.table(rows, columns)

    def plot(self) -> Figure:
        """Neutral V_f over Mach number."""
        return plots.crossings(self.crossings, f"Flutter boundary, {fuel_tank.LABEL[self.data['slosh']]}")

    def __repr__(self) -> str:
        return "Boundary(" + "; ".join(f"Mach {mach:g}: {text}" for mach, text in self.outcomes.items()) + ")"


def boundary(
    case: Case | str | os.PathLike[str],
    *,
    mach: Sequence[float] | float | None = None,
    V_f: float | None = None,
    slosh: str | None = None,
    method: str | None = None,
    uncertainty: bool | None = None,
    folder: str | os.PathLike[str] | None = None,
    fmus: str | os.PathLike[str] | None = None,
    progress: bool | Callback = False,
) -> Boundary:
    """Every neutral V_f of the Mach numbers `mach` (or of boundary.mach).

    V_f, method, uncertainty  instead of flutter.V_f (where to start), boundary.method, boundary.uncertainty
    slosh, folder, fmus, progress  as in `point`

    A Mach number at which something fails is a point with that outcome. A callback that returns False ends the search: what was
    finished is returned, `unfinished` names the rest. Raises AeroSloshError, KeyboardInterrupt (a folder keeps what was done)."""
    machs = None if mach is None else _numbers(mach)
    changes = {"boundary.mach": machs, "flutter.V_f": V_f, "slosh.model": slosh}
    core = with_changes(case, changes | {"boundary.method": method, "boundary.uncertainty": uncertainty}, "boundary")
    found = find_fmus(fmu_folder(fmus), core.slosh.model, core.slosh.predictor)
    check_fmus(core, found)
    report, said = reporter(progress), warned([core], "boundary")
    with interruptible():
        if folder is None:
            kept = Kept(core, None, said)
            _until_cancelled(core, found, kept, report)
            return Boundary(Case(core), kept.data())
        with RunFolder(Path(folder)) as run:
            run.write_case(core)
            kept = Kept(core, run, said)
            points = _until_cancelled(core, found, kept, report)
            draw(core, points, kept, run)
            run.write_result(kept.data() | {"provenance": provenance(kept.hashes)})
        return Boundary(Case(core), kept.data(), run.target)


class Kept:
    """The results of the Mach numbers so far; with a `folder` on the disk after each of them: `result.json`, the histories of its
    marches and the table of its modes.

    The folder has its own name from the first one on; what comes later changes nothing of what is there. `told`: further data."""

    def __init__(self, case: cases.Case, folder: RunFolder | None = None, told: dict[str, Any] | None = None) -> None:
        self.case, self.folder, self.hashes, self._told = case, folder, dict[str, str](), told or {}
        self.airfoil = ""  # what the aero FMU says of its section
        self._rows: list[dict[str, Any]] = []
        self._finished = self._written = 0
        self._begin = clock.perf_counter(), clock.process_time()

    def data(self) -> dict[str, Any]:
        """For JSON; `unfinished` names the Mach numbers that are still to be computed."""
        cost = {"wall_seconds": clock.perf_counter() - self._begin[0], "cpu_seconds": clock.process_time() - self._begin[1]}
        return {
            "slosh": self.case.slosh.model,
            "airfoil_summary": self.airfoil or None,
            "points": self._rows,
            "matched": by_value.matched(self._rows),
            "unfinished": self.case.boundary.mach[self._finished :],
            "cost": cost,
        } | self._told

    def add(self, point: BoundaryPoint) -> None:
        """A Mach number is done, or interrupted with some marches. Raises OSError; what was kept before stays."""
        with interrupts.held():
            self._add(point)

    def _add(self, point: BoundaryPoint) -> None:
        self._finished += not point.interrupted
        self._rows.append({"slosh": self.case.slosh.model} | _row(point))
        if self.folder is None:
            return
        about = provenance(self.hashes)
        self.folder.write_result(self.data() | {"provenance": about})
        self._written = self._finished
        self.folder.publish()
        for march in point.marches:
            write_history(self.folder.path / f"history_M{point.mach:g}_Vf{march.scales.V_f:.4f}.nc", march, about)
        modes.write(point, *self.range, self.folder.path / f"modes_M{point.mach:g}.csv")

    @property
    def range(self) -> tuple[float, float]:
        """The V_f searched."""
        low, high = self.case.boundary.V_f_range
        return low, high

    def told(self) -> str:
        """How much is kept, and how to go on."""
        left = self.case.boundary.mach[self._written :]
        more = f"; the others: --mach {' '.join(f'{m:g}' for m in left)}" if left else ""
        return f"{self._written} of {len(self.case.boundary.mach)} Mach numbers are finished and kept{more}"

    def unwritable(self, error: OSError) -> AeroSloshError:
        """What a user is told when the disk does not take a result."""
        place = self.folder.target if self.folder is not None else ""
        return disk.explained(error, place, f"free space, or give another folder with --out; {self.told()}")


def compute(case: cases.Case, fmus: dict[str, Path], kept: Kept, report: Reporter) -> list[BoundaryPoint]:
    """The points; each march said as it ends, each point kept."""
    folder = kept.folder

    def say(text: str) -> None:
        if folder is not None:
            folder.log(text)
        report.say(text)

    def before_march(setup: FlutterSetup, V_f: float) -> Watcher:
        report.start(f"M {setup.mach:g} V_f {V_f:.4g}")
        return report.watch

    def on_march(setup: FlutterSetup, march: March) -> None:
        fit, s = march.fit, march.scales
        rate = f"growth rate {plus_minus(fit.growth_rate, fit.growth_rate_uncertainty)}" if fit else march.reason
        worst = trust.validity(march)
        rate += "" if worst is None or fuel_tank.holds(worst) else f", {fuel_tank.broken(worst)}"
        say(f"  Mach {s.mach:g}, V_f {s.V_f:.4f}: {rate}, {march.cost.wall:.1f} s")
        if folder is not None:
            folder.log_messages(setup.system.components)

    def on_point(found: BoundaryPoint) -> None:
        kept.add(found)  # before anything that may cancel
        say(f"Mach {found.mach:g}: {summary.point_data(found)['outcome']}")
        if found.failure is not None and folder is not None:
            folder.log(f"{found.failure}\n{found.failure.traceback}")

    def on_setup(setup: FlutterSetup) -> None:
        kept.hashes.update(setup.hashes())
        kept.airfoil = setup.airfoil_summary

    def section() -> Path | None:  # the folder's name changes with the first point
        return section_file(folder) if folder is not None and case.output.pictures else None

    return solve.solve(case, fmus, say, on_point, on_march, before_march, on_setup, section)


def draw(case: cases.Case, points: list[BoundaryPoint], kept: Kept, folder: RunFolder) -> None:
    """The pictures of a boundary: V_f over Mach, the V-g and V-f curves of each Mach number, the section."""
    if not case.output.pictures:
        return
    from ..pictures import boundary as pictures  # matplotlib takes half a second to import
    from ..pictures import modes as curves

    published = PUBLISHED if case.name.startswith("isogai_a") and case.slosh.model == "none" else None
    if points:
        pictures.draw(points, folder.path / "boundary.png", published, case.slosh.model)
    draw_section(folder, kept.airfoil)
    for p in points:
        curves.draw(p, *kept.range, folder.path / f"vg_M{p.mach:g}.png")


def _numbers(mach: Any) -> list[float]:
    """Mach numbers, one or several. Raises AeroSloshError."""
    try:
        return [float(m) for m in (mach if np.ndim(mach) == 1 else np.asarray(mach, dtype=float).reshape(1))]
    except (TypeError, ValueError):
        raise AeroSloshError(f"mach = {mach!r}", "ae.boundary", "a number, or a list of numbers") from None


def _until_cancelled(case: cases.Case, fmus: dict[str, Path], kept: Kept, report: Reporter) -> list[BoundaryPoint]:
    """The points; none where a callback cancelled: `kept` has what was finished."""
    try:
        return compute(case, fmus, kept, report)
    except Cancelled:
        return []


def _row(point: BoundaryPoint) -> dict[str, Any]:
    """The data of a point; of one that cannot be told, which from then on has failed, that it cannot."""
    try:
        row = summary.point_data(point)
        json.dumps(row, allow_nan=False)
    except Exception as error:
        point.failure, point.converged = InternalError(error, f"Mach {point.mach:g}"), False
        point.outcome = f"failed: {point.failure.what}"
        return summary.point_data(BoundaryPoint(point.mach, [], [], point.outcome, False))
    return row
