"""The command `aeroslosh`: `point` marches one V_f, `boundary` finds the neutral V_f of several Mach numbers, `drive` runs one
FMU alone, `animate` draws the liquid in a tank."""

from __future__ import annotations

import argparse
import json
import os
import sys
import time as clock
import traceback
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from master import case as cases
from master import confirm, drive, flutter, outcome, slosh
from master.boundary import BoundaryPoint, Marcher, boundary
from master.case import Case
from master.component import Component
from master.errors import AeroSloshError, ComponentError, ExitCode
from master.progress import Progress
from master.record import RunFolder, provenance, write_history
from master.rig import FlutterRig, find_fmus
from master.verdict import Verdict
from master.wording import plus_minus

PUBLISHED = Path(__file__).with_name("published.csv")


def main(arguments: Sequence[str] | None = None) -> None:
    """Run and end the process with the exit code of `errors.ExitCode`.

    `os._exit`: pythonfmu's wrapper releases its interpreter state twice at a normal exit, which can abort."""
    code: int = ExitCode.OK
    try:
        code = run(arguments)
    except SystemExit as stop:  # argparse: 0 after --help, 2 after a bad command line
        code = stop.code if isinstance(stop.code, int) else ExitCode.INPUT
    except AeroSloshError as error:
        show(error)
        code = error.code
    except KeyboardInterrupt:
        print("\naeroslosh: interrupted; the unfinished run folder was removed", file=sys.stderr)
        code = ExitCode.INTERRUPTED
    except BrokenPipeError:  # the reader of our output went away
        code = ExitCode.INPUT
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115
    except Exception:  # a fault of ours: say so, with everything needed to report it
        traceback.print_exc()
        print("aeroslosh: internal error (above); please report it with the case file", file=sys.stderr)
        code = 1
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            code = code or ExitCode.INPUT
    os._exit(int(code))


def show(error: AeroSloshError) -> None:
    """An error on standard error; a component's with its own traceback."""
    print(f"aeroslosh: {error}", file=sys.stderr)
    if isinstance(error, ComponentError) and error.traceback:
        print(f"  {error.component} says:", file=sys.stderr)
        for line in error.traceback.strip().splitlines():
            print(f"    | {line}", file=sys.stderr)


def run(arguments: Sequence[str] | None = None) -> int:
    """Parse, run, report; returns the exit code."""
    options = parser().parse_args(arguments)
    if options.command == "drive":
        return drive_command(options)
    if options.command == "animate":
        return animate_command(options)
    case = cases.load(options.case, options.set)
    if options.slosh is not None:
        cases.apply_override(case, f"slosh.model={options.slosh}")
    if options.no_pictures:
        case.output.pictures = case.output.fields = False
    progress = Progress(options.quiet or options.json)
    fmus = find_fmus(options.fmus, case.slosh.model)
    command = point if options.command == "point" else boundary_command
    liquid = f"_{options.slosh}" if options.slosh is not None else ""
    target = options.out or Path("runs") / f"{case.name}_{options.command}{liquid}"
    with RunFolder(target) as folder:
        return command(case, fmus, options, folder, progress)


def drive_command(options: argparse.Namespace) -> int:
    """One FMU alone, driven by a table; CSV and picture of what comes out."""
    table = drive.read(options.input)
    if options.step is not None:
        if not options.step > 0.0:
            raise AeroSloshError(f"--step {options.step:g}", "command line", "a step above 0 [s]")
        table = table.resampled(options.step)
    if not options.fmu.is_file():
        raise AeroSloshError("There is no such FMU", str(options.fmu), "build the FMUs with `make fmus`")
    component = Component(options.fmu, options.fmu.stem)
    drive.set_parameters(component, options.set)
    table, derived = drive.completed(table, component.input_index)
    if derived:
        print(f"note: {', '.join(derived)} not in the table, taken from splines", file=sys.stderr)
    target = options.out or options.input.with_name(f"{options.input.stem}_{options.fmu.stem}.csv")
    if options.fields is not None and options.fields < 1:
        raise AeroSloshError(f"--fields {options.fields}", "command line", "a number of rows, at least 1")
    folder = drive.prepare_fields(component, target.parent / "fields") if options.fields else None
    columns = drive.run(component, table, options.fields or 0)
    drive.write(target, columns)
    files = [str(target)]
    if folder is not None:
        files.append(os.path.relpath(folder))
    if not options.no_pictures:
        picture = target.with_suffix(".png")
        drive.draw(picture, table, columns, {name: v.unit or "" for name, v in component.variables.items()})
        files.append(str(picture))
    steps = table.times.size - 1
    if options.json:
        print(json.dumps({"steps": steps, "cpu_seconds": component.cpu, "files": files}))
    else:
        print(f"{options.fmu.stem}: {steps} steps, {component.cpu:.2f} s CPU\n  " + "\n  ".join(files))
    return ExitCode.OK


def animate_command(options: argparse.Namespace) -> int:
    """Pictures and an animation of the liquid in a tank."""
    from master import animation  # matplotlib takes half a second to import

    fields = animation.find(options.folder)
    out = options.out or options.folder / "animation.gif"
    files = animation.animate(fields, out, options.fps, out.with_suffix("") if options.pictures else None)
    if options.json:
        print(json.dumps({"frames": len(fields), "files": [str(path) for path in files]}))
    else:
        print(
            f"{len(fields)} frames\n  {files[0]}" + (f"\n  {len(files) - 1} pictures in {files[1].parent}" if files[1:] else "")
        )
    return ExitCode.OK


def point(case: Case, fmus: dict[str, Path], options: argparse.Namespace, folder: RunFolder, progress: Progress) -> int:
    """One march."""
    if options.mach is not None:
        cases.apply_override(case, f"flow.mach={options.mach!r}")
    if options.vf is not None:
        cases.apply_override(case, f"flutter.V_f={options.vf!r}")
    folder.write_case(case)
    mach, V_f = case.flow.mach, case.flutter.V_f
    fields = None
    if case.output.fields:
        fields = folder.path / "fields"
        fields.mkdir()
    with FlutterRig(case, fmus, mach, fields, lambda text: _say(text, folder, progress)) as rig:
        about = provenance(rig.hashes())
        for loop in rig.system.loops:
            folder.log(f"algebraic loop, closed by the coupling scheme {case.coupling.scheme}: {' '.join(loop)}")
        _say(f"march at Mach {mach:g}, V_f {V_f:g}", folder, progress)
        progress.start(f"M {mach:g} V_f {V_f:.4g}")
        march = flutter.march(rig, V_f, fields, progress.watch)
        data = outcome.march_data(march, rig.steady_cpu)
        _log_messages(rig, folder)
    folder.keep()  # a failed march's history is worth keeping
    folder.log(outcome.march_summary(data))
    write_history(folder.path / "history.nc", march, about)
    _draw_point(case, march, folder, progress)
    folder.write_result(data | {"provenance": about})
    _print(options, data, outcome.march_summary(data), folder)
    if march.failure is not None:
        folder.log(f"{march.failure}\n{march.failure.traceback}")
        show(march.failure)
        return ExitCode.COMPONENT
    return ExitCode.UNDETERMINED if march.verdict is Verdict.UNDETERMINED else ExitCode.OK


def boundary_command(
    case: Case, fmus: dict[str, Path], options: argparse.Namespace, folder: RunFolder, progress: Progress
) -> int:
    """Every Mach number's neutral V_f."""
    if options.mach:
        cases.apply_override(case, f"boundary.mach=[{', '.join(repr(m) for m in options.mach)}]")
    if options.vf is not None:
        cases.apply_override(case, f"flutter.V_f={options.vf!r}")
    if options.method is not None:
        cases.apply_override(case, f"boundary.method={options.method}")
    if options.uncertainty:
        cases.apply_override(case, "boundary.uncertainty=true")
    folder.write_case(case)
    hashes: dict[str, str] = {}
    rigs: dict[float, FlutterRig] = {}
    begin = clock.perf_counter(), clock.process_time()

    def open_rig(of: Case, mach: float) -> FlutterRig:
        return FlutterRig(of, fmus, mach, None, lambda text: _say(text, folder, progress))

    def marcher_at(mach: float) -> tuple[Marcher, Any]:
        rig = open_rig(case, mach)
        rigs[mach] = rig
        hashes.update(rig.hashes())

        def marcher(V_f: float) -> flutter.March:
            progress.start(f"M {mach:g} V_f {V_f:.4g}")
            march = flutter.march(rig, V_f, None, progress.watch)
            fit = march.fit
            rate = f"growth rate {plus_minus(fit.growth_rate, fit.growth_rate_uncertainty)}" if fit else march.reason
            _say(f"  Mach {mach:g}, V_f {V_f:.4f}: {rate}, {march.cost.wall:.1f} s", folder, progress)
            _log_messages(rig, folder)
            return march

        return marcher, rig.close

    def on_point(found: BoundaryPoint) -> None:
        _say(f"Mach {found.mach:g}: {found.outcome}", folder, progress)
        for march in found.marches:
            name = f"history_M{found.mach:g}_Vf{march.scales.V_f:.4f}.nc"
            write_history(folder.path / name, march, provenance(hashes))

    b = case.boundary
    strategy = None
    if b.method != "march":
        strategy = confirm.Confirm(
            case, rigs.__getitem__, open_rig, lambda text: _say(text, folder, progress), b.method == "both"
        )
    points = boundary(
        marcher_at,
        b.mach,
        case.flutter.V_f,
        (b.V_f_range[0], b.V_f_range[1]),
        b.tolerance,
        b.max_marches,
        on_point,
        strategy,
    )
    folder.keep()
    rows = [{"slosh": case.slosh.model} | outcome.point_data(p) for p in points]
    data: dict[str, Any] = {
        "slosh": case.slosh.model,
        "points": rows,
        "cost": {
            "wall_seconds": clock.perf_counter() - begin[0],
            "cpu_seconds": clock.process_time() - begin[1],
        },
    }
    if case.output.pictures:
        from master import boundary_plot

        published = PUBLISHED if case.name.startswith("isogai_a") and case.slosh.model == "none" else None
        boundary_plot.draw(points, folder.path / "boundary.png", published, case.slosh.model)
    folder.write_result(data | {"provenance": provenance(hashes)})
    summary = outcome.boundary_summary(rows)
    folder.log("\n" + summary)
    cost = data["cost"]
    spent = f"{cost['wall_seconds']:.1f} s wall, {cost['cpu_seconds']:.1f} s CPU"
    label = slosh.LABEL[case.slosh.model]
    if case.boundary.method == "linear" and case.slosh.model not in ("none", "frozen"):
        label += ", carried frozen by the linear method"
    text = f"Flutter boundary of {case.name}, {label}\n{summary}\n  cost         {spent}"
    _print(options, data, text, folder)
    for p in points:
        if p.failure is not None and p.converged:  # a march failed, the search went round it: its log tells more
            print(f"note: Mach {p.mach:g}: {p.failure.what}", file=sys.stderr)
        elif p.failure is not None:
            show(p.failure)
    if any(p.failure is not None and not p.converged for p in points):
        return ExitCode.COMPONENT
    return ExitCode.OK if all(p.converged for p in points) else ExitCode.UNDETERMINED


def parser() -> argparse.ArgumentParser:
    """The command line."""
    top = argparse.ArgumentParser(
        prog="aeroslosh",
        description="Aeroelastic flutter by co-simulation of FMUs.",
        epilog="exit codes: 0 ok, 2 bad input, 3 a component failed, 4 no verdict or tolerance not met",
    )
    commands = top.add_subparsers(dest="command", required=True, metavar="point | boundary | drive | animate")
    for name, text in (
        ("point", "march one Mach number and V_f: does it flutter?"),
        ("boundary", "find the neutral V_f of the case's Mach numbers"),
    ):
        sub = commands.add_parser(name, help=text, description=text)
        sub.add_argument("case", type=Path, metavar="CASE", help="a TOML case, e.g. cases/isogai_a.toml")
        if name == "point":
            sub.add_argument("--mach", type=float, metavar="M", help="instead of flow.mach")
        else:
            sub.add_argument("--mach", type=float, metavar="M", nargs="+", help="instead of boundary.mach")
            sub.add_argument("--method", metavar="WORD", help="linear, march or both, instead of boundary.method")
            sub.add_argument(
                "--uncertainty", action="store_true", help="step, amplitude and mesh into the error bars (3 more marches)"
            )
        sub.add_argument("--vf", type=float, metavar="V", help="instead of flutter.V_f (boundary: where to start)")
        sub.add_argument("--slosh", metavar="MODEL", help="none, frozen, ems, rbf or vof, instead of slosh.model")
        sub.add_argument("--set", action="append", default=[], metavar="TABLE.KEY=VALUE", help="change any key of the case")
        sub.add_argument("--out", type=Path, metavar="DIR", help="run folder (default runs/<case>_<command>[_<slosh>])")
        sub.add_argument("--fmus", type=Path, metavar="DIR", default=_default_fmus(), help="folder of the FMUs")
        sub.add_argument("--json", action="store_true", help="JSON on standard output, nothing else")
        sub.add_argument("--quiet", action="store_true", help="no progress")
        sub.add_argument("--no-pictures", action="store_true", help="no pictures and no flow fields")
    text = "drive one FMU alone with a table of its inputs"
    alone = commands.add_parser("drive", help=text, description=text)
    alone.add_argument("fmu", type=Path, metavar="FMU", help="e.g. dist/fmus/aero.fmu")
    alone.add_argument("--input", type=Path, required=True, metavar="CSV", help="column time [s], and inputs of the FMU by name")
    alone.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="a parameter of the FMU")
    alone.add_argument("--step", type=float, metavar="S", help="communication step [s] (default: the table's rows)")
    alone.add_argument(
        "--fields",
        type=int,
        metavar="N",
        help="write fields for ParaView and `animate` at the first row and every N-th, to the FMU's field_folder or "
        "fields beside --out; an earlier run's fields there are removed",
    )
    alone.add_argument("--out", type=Path, metavar="CSV", help="outputs (default <input>_<fmu>.csv, picture beside it)")
    alone.add_argument("--json", action="store_true", help="JSON on standard output, nothing else")
    alone.add_argument("--no-pictures", action="store_true", help="no picture")
    text = "draw the liquid in a tank from the fields that a slosh FMU wrote, as an animation"
    film = commands.add_parser("animate", help=text, description=text)
    film.add_argument("folder", type=Path, metavar="FOLDER", help="with files fields_<number>.vts (`drive --fields` writes them)")
    film.add_argument("--out", type=Path, metavar="GIF", help="the animation (default FOLDER/animation.gif)")
    film.add_argument("--fps", type=int, default=20, metavar="N", help="pictures a second, 1 to 50 (default 20)")
    film.add_argument("--pictures", action="store_true", help="each picture as PNG too, in a folder named like the animation")
    film.add_argument("--json", action="store_true", help="JSON on standard output, nothing else")
    return top


def _default_fmus() -> Path:
    """AEROSLOSH_FMUS, or dist/fmus beside the checkout."""
    return Path(os.environ.get("AEROSLOSH_FMUS") or Path(__file__).resolve().parent.parent / "dist" / "fmus")


def _say(text: str, folder: RunFolder, progress: Progress) -> None:
    folder.log(text)
    progress.say(text)


def _log_messages(rig: FlutterRig, folder: RunFolder) -> None:
    """The FMUs' log messages into run.log, each once."""
    for component in rig.system.components:
        for status, text in component.messages:
            folder.log(f"{component.name} (status {status}): {text}")
        component.messages.clear()


def _draw_point(case: Case, march: flutter.March, folder: RunFolder, progress: Progress) -> None:
    if not case.output.pictures:
        return
    from master import plots  # matplotlib takes half a second to import

    progress.say("pictures")
    plots.histories(march, folder.path / "histories.png")
    plots.phase(march, folder.path / "phase.png")
    if march.fields:
        plots.mach_field(march, folder.path / "mach_field.png", case.section.chord, case.section.elastic_axis)


def _print(options: argparse.Namespace, data: dict[str, Any], summary: str, folder: RunFolder) -> None:
    if options.json:
        print(json.dumps(data, allow_nan=False))
    else:
        print(f"{summary}\n  run folder   {os.path.relpath(folder.target)}")


if __name__ == "__main__":
    main()
