"""`aeroslosh point`: march one Mach number and V_f."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ..analysis.verdict import Verdict
from ..base import pvd
from ..base.errors import ExitCode, show
from ..case import case as cases
from ..case import fuel_tank
from ..case.case import Case
from ..cosim import checkpoint
from ..cosim.progress import Progress
from ..flutter import march as flutter_march
from ..flutter.setup import FlutterRig, find_fmus
from ..fmi import unpack
from ..results import summary as results_summary
from ..results import trust
from ..results.run_folder import RunFolder, provenance, write_history
from . import common

# what may differ from the checkpoint's: a march may grow
FREE = ("flutter.free_cycles", "flutter.max_free_cycles", "output.pictures", "output.fields")


def register(commands: Any) -> None:
    """The command line."""
    text = "march one Mach number and V_f: does it flutter?"
    sub = commands.add_parser("point", help=text, description=text)
    common.add_case(sub)
    sub.add_argument("--mach", type=float, metavar="M", help="instead of flow.mach")
    sub.add_argument("--vf", type=float, metavar="V", help="instead of flutter.V_f")
    common.add_checkpoint(sub)
    sub.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """One march."""
    case = common.load_case(options, "point", {"flow.mach": options.mach, "flutter.V_f": options.vf})
    progress = Progress(options.quiet or options.json)
    fmus = find_fmus(options.fmus, case.slosh.model, case.slosh.predictor)
    common.check_fmus(options, case, fmus)
    files, settings = _files(case, fmus), cases.flat(case)
    hashes = {name: unpack.sha256(path) for name, path in files.items()}
    # all this before the steady flow, which may take minutes
    keeper, start = common.keeper(options, settings, hashes), common.restart(options, settings, hashes, FREE)
    if keeper is not None:
        checkpoint.check_files({name: path for name, path in files.items() if (name, case.slosh.model) != ("slosh", "frozen")})
    with RunFolder(common.run_folder(options, case.name)) as folder:
        folder.write_case(case)
        told = common.tell(options, [case], "point", folder.log)
        mach, V_f = case.flow.mach, case.flutter.V_f
        fields = None
        if start is not None and case.output.fields and not start.about["case"]["output.fields"]:
            common.say("no flow fields: the march to go on with began without a folder for them", folder, progress)
        elif case.output.fields:
            fields = folder.path / "fields"
            fields.mkdir()
        section = common.section_file(folder) if case.output.pictures else None
        with FlutterRig(case, fmus, mach, fields, lambda text: common.say(text, folder, progress), section) as rig:
            airfoil = rig.airfoil_summary
            about = provenance(hashes)
            for loop in rig.system.loops:
                folder.log(f"algebraic loop, closed by the coupling scheme {case.coupling.scheme}: {' '.join(loop)}")
            common.say(f"march at Mach {mach:g}, V_f {V_f:g}", folder, progress)
            progress.start(f"M {mach:g} V_f {V_f:.4g}")
            march = flutter_march.march(rig, V_f, fields, progress.watch, keeper, start)
            data = results_summary.march_data(march, rig.steady_cpu) | told | {"airfoil_summary": airfoil or None}
            common.log_messages(rig.system.components, folder)
        folder.keep()  # a failed march's history is worth keeping
        summary = results_summary.march_summary(data)
        folder.log(summary)
        if march.failure is not None:
            folder.log(f"{march.failure}\n{march.failure.traceback}")
        with common.printed(options, data, summary, folder):
            write_history(folder.path / "history.nc", march, about)
            folder.write_result(data | {"provenance": about})
            if fields is not None and march.fields:
                pvd.write_beside(fields, {pvd.number(path): tau / march.scales.omega_alpha for tau, path in march.fields})
            _draw(case, march, folder, progress)
            common.draw_airfoil(case, folder, airfoil)
        if march.failure is not None:
            show(march.failure)
            return ExitCode.COMPONENT
        return ExitCode.UNDETERMINED if trust.verdict(march) is Verdict.UNDETERMINED else ExitCode.OK


def _files(case: Case, fmus: dict[str, Path]) -> dict[str, Path]:
    """The FMU of each component."""
    files = {"structure": fmus["structure"], "aero": fmus["aero"]}
    liquid = {"slosh": case.slosh.model, "slosh_predictor": case.slosh.predictor}
    return files | {name: fmus[fuel_tank.FMU[model]] for name, model in liquid.items() if model in fuel_tank.FMU}


def _draw(case: Case, march: flutter_march.March, folder: RunFolder, progress: Progress) -> None:
    if not case.output.pictures:
        return
    from ..pictures import march as pictures_march  # matplotlib takes half a second to import

    progress.say("pictures")
    pictures_march.histories(march, folder.path / "histories.png")
    pictures_march.phase(march, folder.path / "phase.png")
    if march.fields:
        pictures_march.mach_field(march, folder.path / "mach_field.png", case.section.chord, case.section.elastic_axis)
