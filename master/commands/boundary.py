"""`aeroslosh boundary`: the neutral V_f of the case's Mach numbers."""

from __future__ import annotations

import argparse
import sys
import time as clock
from pathlib import Path
from typing import Any

from master import boundary_case, flutter, outcome, slosh
from master import case as cases
from master.boundary import BoundaryPoint
from master.case import Case
from master.commands import common
from master.errors import ExitCode
from master.flutter import March
from master.progress import Progress
from master.record import RunFolder, provenance, write_history
from master.rig import FlutterRig, find_fmus
from master.wording import plus_minus

PUBLISHED = Path(__file__).resolve().parents[1] / "published.csv"


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
    case = common.load_case(options)
    if options.mach:
        cases.apply_override(case, f"boundary.mach=[{', '.join(repr(m) for m in options.mach)}]")
    if options.vf is not None:
        cases.apply_override(case, f"flutter.V_f={options.vf!r}")
    if options.method is not None:
        cases.apply_override(case, f"boundary.method={options.method}")
    if options.uncertainty:
        cases.apply_override(case, "boundary.uncertainty=true")
    progress = Progress(options.quiet or options.json)
    fmus = find_fmus(options.fmus, case.slosh.model, case.slosh.predictor)
    common.check_airfoil(options, case, fmus["aero"])
    with RunFolder(common.run_folder(options, case.name)) as folder:
        folder.write_case(case)
        begin = clock.perf_counter(), clock.process_time()
        points, hashes, airfoil = _solve(case, fmus, folder, progress)
        folder.keep()
        cost = {"wall_seconds": clock.perf_counter() - begin[0], "cpu_seconds": clock.process_time() - begin[1]}
        rows = [{"slosh": case.slosh.model} | outcome.point_data(p) for p in points]
        data: dict[str, Any] = {"slosh": case.slosh.model, "airfoil_summary": airfoil or None, "points": rows, "cost": cost}
        if case.output.pictures:
            from master import boundary_plot

            published = PUBLISHED if case.name.startswith("isogai_a") and case.slosh.model == "none" else None
            boundary_plot.draw(points, folder.path / "boundary.png", published, case.slosh.model)
        common.draw_airfoil(case, folder, airfoil)
        folder.write_result(data | {"provenance": provenance(hashes)})
        summary = outcome.boundary_summary(rows)
        folder.log("\n" + summary)
        spent = f"{cost['wall_seconds']:.1f} s wall, {cost['cpu_seconds']:.1f} s CPU"
        label = slosh.LABEL[case.slosh.model]
        if case.boundary.method == "linear" and case.slosh.model not in ("none", "frozen"):
            label += ", carried frozen by the linear method"
        section = [outcome.airfoil_line(airfoil)] if airfoil else []
        text = "\n".join([f"Flutter boundary of {case.name}, {label}", summary, *section, f"  cost         {spent}"])
        common.print_result(options, data, text, folder)
        return _exit_code(points)


def _solve(
    case: Case, fmus: dict[str, Path], folder: RunFolder, progress: Progress
) -> tuple[list[BoundaryPoint], dict[str, str], str]:
    """The points, the hashes of the FMUs used, and what the aero FMU says of its section; each march said as it ends, each
    point's histories written."""
    hashes: dict[str, str] = {}
    said: list[str] = []

    def before_march(rig: FlutterRig, V_f: float) -> flutter.Watcher:
        progress.start(f"M {rig.mach:g} V_f {V_f:.4g}")
        return progress.watch

    def on_march(rig: FlutterRig, march: March) -> None:
        fit, s = march.fit, march.scales
        rate = f"growth rate {plus_minus(fit.growth_rate, fit.growth_rate_uncertainty)}" if fit else march.reason
        common.say(f"  Mach {s.mach:g}, V_f {s.V_f:.4f}: {rate}, {march.cost.wall:.1f} s", folder, progress)
        common.log_messages(rig.system.components, folder)

    def on_point(found: BoundaryPoint) -> None:
        common.say(f"Mach {found.mach:g}: {found.outcome}", folder, progress)
        for march in found.marches:
            name = f"history_M{found.mach:g}_Vf{march.scales.V_f:.4f}.nc"
            write_history(folder.path / name, march, provenance(hashes))

    def say(text: str) -> None:
        common.say(text, folder, progress)

    def on_rig(rig: FlutterRig) -> None:
        hashes.update(rig.hashes())
        said.append(rig.airfoil_summary)

    section = common.section_file(folder) if case.output.pictures else None
    points = boundary_case.solve(case, fmus, say, on_point, on_march, before_march, on_rig, section)
    return points, hashes, said[0] if said else ""


def _exit_code(points: list[BoundaryPoint]) -> int:
    """What scripts learn; failures are shown."""
    for p in points:
        if p.failure is not None and p.converged:  # a march failed, the search went round it: its log tells more
            print(f"note: Mach {p.mach:g}: {p.failure.what}", file=sys.stderr)
        elif p.failure is not None:
            common.show(p.failure)
    if any(p.failure is not None and not p.converged for p in points):
        return ExitCode.COMPONENT
    return ExitCode.OK if all(p.converged for p in points) else ExitCode.UNDETERMINED
