"""The flutter boundary: every Mach number's neutral V_f, kept as it is found, and what a program gets of it."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
import time as clock
from collections.abc import Sequence
from dataclasses import dataclass
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base import disk, files, interrupts, notices
from ..base.errors import AeroSloshError, InternalError
from ..base.wording import plus_minus
from ..boundary import modes, solve
from ..boundary.search import BoundaryPoint
from ..case import case as cases
from ..case import fuel_tank
from ..cosim.loop import Watcher
from ..flutter.march import March
from ..flutter.setup import FlutterSetup, find_fmus
from ..fmi import kernels
from ..results import boundary_table, by_value, summary, trust
from ..results.history_writer import write_history
from ..results.provenance import provenance
from ..results.run_folder import RunFolder
from . import datasets, plots, side_by_side
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

        Empty where the boundary was searched by marches alone. Raises AeroSloshError for a Mach number that was not searched."""
        for name, value in (("V_f", V_f), ("mach", mach)):
            if value is not None and not isinstance(value, Real):
                raise AeroSloshError(f"{name} = {value!r}", "Boundary.modes", "one number, or None for all")
        searched = [p["mach"] for p in self.data["points"]]
        if mach is not None and mach not in searched:
            raise AeroSloshError(f"mach = {mach:g}", "Boundary.modes", f"one of those searched: {', '.join(map(str, searched))}")
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
    workers: int | None = None,
    progress: bool | Callback = False,
) -> Boundary:
    """Every neutral V_f of the Mach numbers `mach` (or of boundary.mach).

    V_f, method, uncertainty  instead of flutter.V_f (where to start), boundary.method, boundary.uncertainty
    workers  processes that search Mach numbers side by side (default: one for each usable core); the results are the same.
             With method "march" each Mach number begins where the one before it crossed: one process, whatever is given
    slosh, folder, fmus, progress  as in `point`

    A Mach number at which something fails is a point with that outcome. A callback that returns False ends the search: what was
    finished is returned, `unfinished` names the rest. Raises AeroSloshError, KeyboardInterrupt (a folder keeps what was done)."""
    machs = None if mach is None else _numbers(mach)
    changes = {"boundary.mach": machs, "flutter.V_f": V_f, "slosh.model": slosh}
    core = with_changes(case, changes | {"boundary.method": method, "boundary.uncertainty": uncertainty}, "boundary")
    count = side_by_side.wanted(workers, f"workers = {workers!r}", "ae.boundary")
    found = find_fmus(fmu_folder(fmus), core.slosh.model, core.slosh.predictor)
    check_fmus(core, found)
    report, said = reporter(progress), warned([core], "boundary")
    with interruptible(), notices.to(report.say):
        if folder is None:
            kept = Kept(core, None, said)
            _until_cancelled(core, found, kept, report, count)
            return Boundary(Case(core), kept.data())
        with RunFolder(Path(folder)) as run:
            run.write_case(core)
            kept = Kept(core, run, said)
            points = _until_cancelled(core, found, kept, report, count)
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
        self.cpu: dict[int, float] = {}  # seconds that worker processes have taken
        self._rows: dict[int, dict[str, Any]] = {}  # by the place of the Mach number in the case
        self._finished = set[int]()
        self._written = set[int]()
        self._begin = clock.perf_counter(), clock.process_time()

    def data(self) -> dict[str, Any]:
        """For JSON; `unfinished` names the Mach numbers that are still to be computed."""
        wall, own = clock.perf_counter() - self._begin[0], clock.process_time() - self._begin[1]
        rows = [row for _, row in sorted(self._rows.items())]
        return {
            "slosh": self.case.slosh.model,
            "airfoil_summary": self.airfoil or None,
            "points": rows,
            "matched": by_value.matched(rows),
            "unfinished": self._left(self._finished),
            "cost": {"wall_seconds": wall, "cpu_seconds": own + sum(self.cpu.values())},
        } | self._told

    def _left(self, done: set[int]) -> list[float]:
        """The Mach numbers that are not `done`."""
        return [m for n, m in enumerate(self.case.boundary.mach) if n not in done]

    def add(self, point: BoundaryPoint) -> None:
        """A Mach number is done, or interrupted with some marches. Raises OSError; what was kept before stays."""
        with interrupts.held():
            self._add(point)

    def _add(self, point: BoundaryPoint) -> None:
        place = next(n for n, m in enumerate(self.case.boundary.mach) if m == point.mach and n not in self._rows)
        if not point.interrupted:
            self._finished.add(place)
        self._rows[place] = {"slosh": self.case.slosh.model} | _row(point)
        if self.folder is None:
            return
        about = provenance(self.hashes)
        self.folder.write_result(self.data() | {"provenance": about})
        files.write(self.folder.path / "boundary.csv", boundary_table.as_csv([row for _, row in sorted(self._rows.items())]))
        self._written = set(self._finished)
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
        left = self._left(self._written)
        more = f"; the others: --mach {' '.join(f'{m:g}' for m in left)}" if left else ""
        return f"{len(self._written)} of {len(self.case.boundary.mach)} Mach numbers are finished and kept{more}"

    def unwritable(self, error: OSError) -> AeroSloshError:
        """What a user is told when the disk does not take a result."""
        place = self.folder.target if self.folder is not None else ""
        return disk.explained(error, place, f"free space, or give another folder with --out; {self.told()}")


def compute(case: cases.Case, fmus: dict[str, Path], kept: Kept, report: Reporter, workers: int = 1) -> list[BoundaryPoint]:
    """The points; each march said as it ends, each point kept. By `workers` processes where Mach numbers do not depend on one
    another, that is with a linear model; in this one with marches alone."""
    told = _Told(case, kept, report)
    count = min(workers, len(case.boundary.mach))
    if count > 1 and case.boundary.method != "march":
        return _side_by_side(case, fmus, told, count)

    def before_march(setup: FlutterSetup, V_f: float) -> Watcher:
        report.start(f"M {setup.mach:g} V_f {V_f:.4g}")
        return report.watch

    def on_march(setup: FlutterSetup, march: March) -> None:
        told.march(march)
        if told.folder is not None:
            told.folder.log_messages(setup.system.components)

    def on_point(point: BoundaryPoint) -> None:
        kept.add(point)  # before anything that may cancel
        told.outcome(point)

    def on_setup(setup: FlutterSetup) -> None:
        told.setup(setup.hashes(), setup.airfoil_summary)

    def section() -> Path | None:  # the folder's name changes with the first point
        return section_file(told.folder) if told.folder is not None and case.output.pictures else None

    return solve.solve(case, fmus, told.say, on_point, on_march, before_march, on_setup, section)


@dataclass(frozen=True)
class _Told:
    """What is said of a boundary, on the terminal and in the log."""

    case: cases.Case
    kept: Kept
    report: Reporter

    @property
    def folder(self) -> RunFolder | None:
        """Where the log is."""
        return self.kept.folder

    def say(self, text: str) -> None:
        """A line."""
        if self.folder is not None:
            self.folder.log(text)
        self.report.say(text)

    def setup(self, hashes: dict[str, str], airfoil: str) -> None:
        """The FMUs of a Mach number, and what the aero FMU says of its section."""
        self.kept.hashes.update(hashes)
        self.kept.airfoil = airfoil

    def march(self, march: March) -> None:
        """A march is done."""
        fit, s = march.fit, march.scales
        rate = f"growth rate {plus_minus(fit.growth_rate, fit.growth_rate_uncertainty)}" if fit else march.reason
        worst = trust.validity(march)
        rate += "" if worst is None or trust.stands(march) else f", {fuel_tank.broken(worst, trust.edge(march))}"
        self.say(f"  Mach {s.mach:g}, V_f {s.V_f:.4f}: {rate}, {march.cost.wall:.1f} s")

    def outcome(self, point: BoundaryPoint) -> None:
        """A Mach number is done."""
        self.say(f"Mach {point.mach:g}: {summary.point_data(point)['outcome']}")
        if point.failure is not None and self.folder is not None:
            self.folder.log(f"{point.failure}\n{point.failure.traceback}")


def _side_by_side(case: cases.Case, fmus: dict[str, Path], told: _Told, workers: int) -> list[BoundaryPoint]:
    """The points, by worker processes. The aero FMUs' tables of the section go through a folder of their own: the run's folder
    changes its name meanwhile."""
    kernels.prepare_all(fmus.values())
    with tempfile.TemporaryDirectory(prefix="aeroslosh_boundary_") as temporary:

        def section(place: int) -> Path | None:
            return Path(temporary) / f"airfoil_{place}.csv" if told.folder is not None and case.output.pictures else None

        def on_setup(place: int, hashes: dict[str, str], airfoil: str) -> None:
            told.setup(hashes, airfoil)
            written = section(place)
            if written is not None and written.is_file() and told.folder is not None:
                shutil.move(written, section_file(told.folder))

        def on_march(march: March, messages: Sequence[tuple[str, int, str]]) -> None:
            told.march(march)
            if told.folder is not None:
                told.folder.log_lines(messages)

        heard = side_by_side.Listener(
            told.say, on_march, on_setup, told.kept.add, told.outcome, told.report.beside, told.kept.cpu.__setitem__
        )
        return side_by_side.SideBySide(case, fmus, workers, heard, section).run()


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


def _until_cancelled(case: cases.Case, fmus: dict[str, Path], kept: Kept, report: Reporter, workers: int) -> list[BoundaryPoint]:
    """The points; none where a callback cancelled: `kept` has what was finished."""
    try:
        return compute(case, fmus, kept, report, workers)
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
