"""`aeroslosh boundary`: the neutral V_f of the case's Mach numbers."""

from __future__ import annotations

import argparse
import json
import sys
import time as clock
from pathlib import Path
from typing import Any

from ..base import disk, interrupts
from ..base.errors import AeroSloshError, ExitCode, InternalError, show
from ..base.wording import plus_minus
from ..boundary import modes, solve
from ..boundary.search import BoundaryPoint
from ..case import fuel_tank
from ..case.case import Case
from ..cosim.progress import Progress
from ..flutter import march as flutter_march
from ..flutter.march import March
from ..flutter.setup import FlutterRig, find_fmus
from ..results import by_value, trust
from ..results import summary as results_summary
from ..results.run_folder import RunFolder, provenance, write_history
from . import common

GRAVITY = (ExitCode.OK, ExitCode.UNDETERMINED, ExitCode.INPUT, ExitCode.INCOMPLETE, ExitCode.COMPONENT, ExitCode.INTERNAL)
PUBLISHED = Path(__file__).resolve().parents[1] / "boundary" / "published.csv"


def register(commands: Any) -> None:
    """The command line."""
    text = "find the neutral V_f of the case's Mach numbers"
    sub = commands.add_parser("boundary", help=text, description=text)
    common.add_case(sub)
    sub.add_argument("--mach", type=float, metavar="M", nargs="+", help="instead of boundary.mach")
    sub.add_argument("--vf", type=float, metavar="V", help="where to start, instead of flutter.V_f")
    sub.add_argument("--method", metavar="WORD", help="linear, march or both, instead of boundary.method")
    sub.add_argument("--uncertainty", action="store_true", help="step, amplitude and mesh into the error bars (3 more marches)")
    sub.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Every Mach number's neutral V_f."""
    changes = {
        "boundary.mach": options.mach or None,
        "flutter.V_f": options.vf,
        "boundary.method": options.method,
        "boundary.uncertainty": "true" if options.uncertainty else None,
    }
    case = common.load_case(options, "boundary", changes)
    progress = Progress(options.quiet or options.json)
    fmus = find_fmus(options.fmus, case.slosh.model, case.slosh.predictor)
    common.check_fmus(options, case, fmus)
    with RunFolder(common.run_folder(options, case.name)) as folder:
        folder.write_case(case)
        told = common.tell(options, [case], "boundary", folder.log)
        kept = Kept(case, folder, told)
        try:
            points = _solve(case, fmus, kept, progress)
        except OSError as error:
            raise kept.unwritable(error) from None
        except KeyboardInterrupt as stop:
            stop.add_note(kept.told())
            raise
        data = kept.data()
        summary = results_summary.boundary_summary(data["points"])
        folder.log("\n" + summary)
        spent = f"{data['cost']['wall_seconds']:.1f} s wall, {data['cost']['cpu_seconds']:.1f} s CPU"
        label = fuel_tank.LABEL[case.slosh.model]
        if case.boundary.method == "linear" and case.slosh.model not in ("none", "frozen"):
            label += ", carried frozen by the linear method"
        section = [results_summary.airfoil_line(kept.airfoil)] if kept.airfoil else []
        text = "\n".join([f"Flutter boundary of {case.name}, {label}", summary, *section, f"  cost         {spent}"])
        with common.printed(options, data, text, folder):
            if case.output.pictures:
                from ..pictures import boundary as pictures_boundary
                from ..pictures import modes

                published = PUBLISHED if case.name.startswith("isogai_a") and case.slosh.model == "none" else None
                pictures_boundary.draw(points, folder.path / "boundary.png", published, case.slosh.model)
                common.draw_airfoil(case, folder, kept.airfoil)
                for p in points:
                    modes.draw(p, *kept.range, folder.path / f"vg_M{p.mach:g}.png")
        return _exit_code(points)


class Kept:
    """The results of the Mach numbers so far, on the disk after each of them: `result.json`, and the histories of its marches.

    The folder has its own name from the first one on; what comes later changes nothing of what is there."""

    def __init__(self, case: Case, folder: RunFolder, told: dict[str, Any]) -> None:
        self.case, self.folder, self.hashes, self._told = case, folder, dict[str, str](), told
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
        about = provenance(self.hashes)
        self.folder.write_result(self.data() | {"provenance": about})
        self._written = self._finished
        self.folder.publish()
        for march in point.marches:
            name = f"history_M{point.mach:g}_Vf{march.scales.V_f:.4f}.nc"
            write_history(self.folder.path / name, march, about)
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
        return disk.explained(error, self.folder.target, f"free space, or give another folder with --out; {self.told()}")


def _row(point: BoundaryPoint) -> dict[str, Any]:
    """The data of a point; of one that cannot be told, which from then on has failed, that it cannot."""
    try:
        row = results_summary.point_data(point)
        json.dumps(row, allow_nan=False)
    except Exception as error:
        point.failure, point.converged = InternalError(error, f"Mach {point.mach:g}"), False
        point.outcome = f"failed: {point.failure.what}"
        return results_summary.point_data(BoundaryPoint(point.mach, [], [], point.outcome, False))
    return row


def _solve(case: Case, fmus: dict[str, Path], kept: Kept, progress: Progress) -> list[BoundaryPoint]:
    """The points; each march said as it ends, each point kept."""
    folder = kept.folder

    def before_march(rig: FlutterRig, V_f: float) -> flutter_march.Watcher:
        progress.start(f"M {rig.mach:g} V_f {V_f:.4g}")
        return progress.watch

    def on_march(rig: FlutterRig, march: March) -> None:
        fit, s = march.fit, march.scales
        rate = f"growth rate {plus_minus(fit.growth_rate, fit.growth_rate_uncertainty)}" if fit else march.reason
        worst = trust.validity(march)
        rate += "" if worst is None or fuel_tank.holds(worst) else f", {fuel_tank.broken(worst)}"
        common.say(f"  Mach {s.mach:g}, V_f {s.V_f:.4f}: {rate}, {march.cost.wall:.1f} s", folder, progress)
        common.log_messages(rig.system.components, folder)

    def on_point(found: BoundaryPoint) -> None:
        common.say(f"Mach {found.mach:g}: {results_summary.point_data(found)['outcome']}", folder, progress)
        if found.failure is not None:
            folder.log(f"{found.failure}\n{found.failure.traceback}")
        kept.add(found)

    def say(text: str) -> None:
        common.say(text, folder, progress)

    def on_rig(rig: FlutterRig) -> None:
        kept.hashes.update(rig.hashes())
        kept.airfoil = rig.airfoil_summary

    def section_file() -> Path | None:
        return common.section_file(folder) if case.output.pictures else None  # the folder's name changes with the first point

    return solve.solve(case, fmus, say, on_point, on_march, before_march, on_rig, section_file)


def _exit_code(points: list[BoundaryPoint]) -> int:
    """What scripts learn; failures are shown, the gravest decides."""
    codes = [ExitCode.OK if all(trust.decided(p) for p in points) else ExitCode.UNDETERMINED]
    for p in points:
        if p.failure is not None and p.converged:  # a march failed, the search went round it: its log tells more
            print(f"note: Mach {p.mach:g}: {p.failure.what}", file=sys.stderr)
        elif p.failure is not None:
            show(p.failure)
            codes.append(p.failure.code)
    return max(codes, key=GRAVITY.index)
