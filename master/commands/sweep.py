"""`aeroslosh sweep`: many points from one case, resumable."""

from __future__ import annotations

import argparse
import json
import sys
import time as clock
from pathlib import Path
from typing import Any

from ..api import sweep as api
from ..base.cores import usable_cores
from ..base.errors import AeroSloshError, ExitCode
from ..case import airfoils
from ..case import case as cases
from ..case.case import Case
from ..sweeps import estimate, plan, sweep
from ..sweeps.jobs import Job, Product
from ..sweeps.parameters import Parameter, from_case, from_words
from ..sweeps.plan import Plan
from ..sweeps.progress import SweepProgress
from ..sweeps.sweep import Store
from ..sweeps.workers import LocalPool
from . import HELP, common, sweep_report

FLAGS = {"grid": "grid", "list": "list", "hypercube": "latin-hypercube"}


def register(commands: Any) -> None:
    """The command line."""
    text = HELP["sweep"]
    sub = commands.add_parser("sweep", help=text, description=text)
    common.add_case(sub)
    sub.add_argument("--boundary", action="store_true", help='every point searches its neutral V_f (sweep.command = "boundary")')
    keys = sub.add_argument_group("what is swept, instead of the case's [sweep.parameters]")
    keys.add_argument(
        "--grid", action="append", metavar="KEY=VALUES", help="flow.mach=0.7,0.8 or slosh.fill_level=0.1:0.9:5[:log]"
    )
    keys.add_argument("--list", action="append", metavar="KEY=VALUES", help="values that go together, as many of every key")
    keys.add_argument("--hypercube", action="append", metavar="KEY=LOW:HIGH", help="ranges that --samples are drawn from")
    keys.add_argument("--samples", type=int, metavar="N", help="points of the Latin hypercube")
    keys.add_argument("--seed", type=int, metavar="N", help="of the Latin hypercube")
    sub.add_argument("--workers", type=int, metavar="N", help="worker processes (default: one for each usable core)")
    sub.add_argument("--scheduler", metavar="URL", help="compute on a Dask cluster, e.g. tcp://host:8786")
    sub.add_argument("--resume", action="store_true", help="go on with the sweep in the folder")
    sub.add_argument("--retry-failed", action="store_true", help="with --resume: compute failed points again")
    sub.add_argument(
        "--recycle",
        type=int,
        default=api.RECYCLE,
        metavar="N",
        help=f"points after which a worker is replaced (default {api.RECYCLE})",
    )
    sub.add_argument("--dry-run", action="store_true", help="points and their cost, from a few steps; nothing is written")
    sub.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Plan, compute, report."""
    workers = usable_cores() if options.workers is None else options.workers
    if workers < 1 or options.recycle < 1:
        what = f"--workers {workers}" if workers < 1 else f"--recycle {options.recycle}"
        raise AeroSloshError(what, "command line", "a whole number, at least 1")
    if options.retry_failed and not options.resume:
        raise AeroSloshError("--retry-failed without --resume", "command line", "failed points of a sweep are retried with both")
    case, parameters = _case(options)
    if options.resume:
        _airfoil_as_begun(options, case)
    wanted = plan.make(case, parameters, options.fmus, str(options.case))
    folder = common.run_folder(options, case.name).absolute()
    progress = SweepProgress(options.quiet or options.json)
    if wanted.repeated:
        progress.say(f"{wanted.repeated} points of the sweep are asked for twice: each is computed once")
    if options.dry_run:
        return _dry_run(options, wanted, folder, workers, progress)
    api.make_folder(folder, options.resume)
    with sweep.locked(folder):
        if not options.resume and sweep.begun(folder):
            remedy = "go on with it: --resume; start anew: another folder with --out, or remove it"
            raise AeroSloshError("The folder holds a sweep already", str(folder), remedy)
        return _alone(options, case, wanted, folder, workers, progress)


def _alone(options: argparse.Namespace, case: Case, wanted: Plan, folder: Path, workers: int, progress: SweepProgress) -> int:
    """The sweep, by the one master of its folder."""

    def say(text: str) -> None:
        progress.say(text)
        sweep.log(folder, text)

    begin = clock.perf_counter()
    told = common.tell(options, [p.case for p in wanted.points], wanted.kind, lambda text: sweep.log(folder, text))
    store = Store.open(folder, say)
    settings = api.Settings(workers, options.recycle, options.scheduler, options.resume, options.retry_failed)
    try:
        api.run(case, wanted, store, settings, progress, say)
        return sweep_report.conclude(options, wanted, store, clock.perf_counter() - begin, told)
    except KeyboardInterrupt as stop:
        kept = len(wanted.points) - len(store.left(wanted))
        said = f"interrupted; {kept} of {len(wanted.points)} points are finished and kept, --resume goes on"
        print(f"\naeroslosh: {said}", file=sys.stderr)
        return getattr(stop, "code", ExitCode.INTERRUPTED)
    finally:
        store.close()


def _case(options: argparse.Namespace) -> tuple[Case, list[Parameter]]:
    """The case with what the command line changes in it, and what is swept."""
    case = common.load_case(options)
    if options.boundary:
        cases.apply_override(case, "sweep.command=boundary")
    flags = [flag for flag in FLAGS if getattr(options, flag)]
    if len(flags) > 1:
        raise AeroSloshError(f"--{flags[0]} and --{flags[1]} together", "command line", "a sweep has one mode: take one of them")
    for name in ("samples", "seed"):
        if getattr(options, name) is not None:
            if not options.hypercube and case.sweep.mode != "latin-hypercube":
                raise AeroSloshError(f"--{name} has no effect on a {case.sweep.mode}", "command line", "--hypercube KEY=LOW:HIGH")
            cases.apply_override(case, f"sweep.{name}={getattr(options, name)}")
    if not flags:
        return case, from_case(case, options.case)
    cases.apply_override(case, f'sweep.mode="{FLAGS[flags[0]]}"')
    parameters = [from_words(text, f"--{flags[0]}") for text in getattr(options, flags[0])]
    case.sweep.parameters = {p.name: p.written for p in parameters}  # so that the folder's case.toml says it all
    return case, parameters


def _airfoil_as_begun(options: argparse.Namespace, case: Case) -> None:
    """A relative coordinate file of --set that is not there from here is the one that the sweep in the folder began with."""
    word, begun = case.flow.airfoil, common.run_folder(options, case.name) / "case.toml"
    if airfoils.is_file(word) or Path(word).is_absolute() or not airfoils.is_file(begun):
        return
    kept = Path(cases.load(begun).flow.airfoil)
    if kept.is_absolute() and airfoils.is_file(kept) and kept.parts[-len(Path(word).parts) :] == Path(word).parts:
        case.flow.airfoil = str(kept)


def _dry_run(options: argparse.Namespace, wanted: Plan, folder: Path, workers: int, progress: SweepProgress) -> int:
    """What there is to do and what it costs."""
    finished = {path.stem for path in folder.glob("points/*.nc")}
    left = [Job(p.id, wanted.kind, p.case, p.overrides, p.files) for p in wanted.points if p.id not in finished]
    tried = estimate.to_probe(left)
    pool = LocalPool[Job, Product](1, options.recycle)
    try:
        probes = pool.prepare(tried) if tried else []
    finally:
        pool.close()
    for job, probe in zip(tried, probes, strict=True):
        if probe.error:
            progress.say(f"note: {estimate.label(job)}: a few steps could not be made: {probe.error}")
    found = estimate.cost(left, tried, probes)
    data = {"points": len(wanted.points), "finished": len(wanted.points) - len(left)} | estimate.data(found, workers)
    print(json.dumps(data) if options.json else estimate.summary(data, wanted))
    return ExitCode.OK
