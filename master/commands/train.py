"""`aeroslosh train`: a surrogate of one tank, from records of the two-phase solver to a network with a report."""

from __future__ import annotations

import argparse
import dataclasses
import json
import os
import time as clock
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..base.errors import AeroSloshError, ExitCode
from ..case import builtin
from ..cosim.progress import Progress
from ..fmi import installed
from ..results.provenance import provenance
from ..results.run_folder import RunFolder
from ..training import case as training_case
from ..training import report as training_report
from ..training import tank_records
from ..training.case import TrainingCase
from . import HELP, common, train_violent

CALM = 0.75  # D: well below where gravity vanishes anywhere on the surface
QUICK = (
    "training.seeds=[0]",
    "training.centres=[20]",
    "training.spreads=[6.0]",
    "training.second_grid=false",
    "training.tuning=0",
)


def register(commands: Any) -> None:
    """The command line."""
    text = HELP["train"]
    sub = commands.add_parser("train", help=text, description=text)
    known = "a training file, or a built-in one: slosh_rbf, slosh_violent"
    sub.add_argument("case", type=builtin.case_path, metavar="CASE", help=known)
    sub.add_argument("--set", action="append", default=[], metavar="TABLE.KEY=VALUE", help="change any key of the file")
    sub.add_argument("--quick", action="store_true", help="fewer networks, one seed, no second grid: minutes")
    sub.add_argument(
        "--records", type=Path, metavar="DIR", help="where records are kept and found again (default runs/<case>_records)"
    )
    sub.add_argument("--workers", type=int, metavar="N", default=len(os.sched_getaffinity(0)), help="processes (default: cores)")
    sub.add_argument("--fmus", type=Path, metavar="DIR", default=installed.folder(), help="folder of the FMUs")
    common.add_output(sub, "run folder (default runs/<case>_train)")
    sub.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Records, networks, tests, report."""
    from ...fmus.slosh_rbf import feedback  # what a user of the other commands need not load
    from ...fmus.slosh_rbf.network import NetworkError, untrained
    from ...fmus.slosh_rbf.training import (
        dataset,  # what a user of the other commands need not load
        study,  # what a user of the other commands need not load
    )

    installed.ensure(options.fmus)
    case = training_case.load(options.case, [*(QUICK if options.quick else ()), *options.set])
    if case.violent.train:
        return train_violent.execute(case, options)
    if case.training.tuning and not _has_torch():
        raise AeroSloshError(
            "training.tuning needs torch, which is not installed",
            str(options.case),
            "pip install 'aeroslosh[train]', or tuning = 0",
        )
    progress, t = Progress(options.quiet or options.json), case.training
    folder_of_records = options.records or Path("runs") / f"{case.name}_records"
    with RunFolder(options.out or Path("runs") / f"{case.name}_train") as folder:
        folder.write_settings(training_case.dump(case))

        def say(text: str) -> None:
            common.say(text, folder, progress)

        begin = clock.process_time()
        try:
            found, spent = _records(case, options, folder_of_records, say)
            data = study.arrange(found)
        except dataset.DatasetError as error:
            what, _, rest = str(error).partition("\n")
            raise AeroSloshError(what, rest.strip(), "", ExitCode.COMPONENT) from None
        source = provenance({"slosh_vof": tank_records.Drive.of(options.fmus / "slosh_vof.fmu").sha256})
        about = {**source, "tank": dataclasses.asdict(data.tank)}
        models = {
            "ems": study.modal(untrained("ems", False), data),
            "bilinear": study.modal(untrained("bilinear", True), data),
        }
        reports: list[dict[str, Any]] = []
        for place, seed in enumerate(t.seeds):
            say(f"seed {seed}")
            try:
                network, tail, report = study.train(data, _settings(case, seed), t.largest_D, say, about)
            except dataset.DatasetError as error:
                raise AeroSloshError(str(error).split("\n")[0], str(options.case), "raise training.largest_D") from None
            if place == 0:
                models["quadratic"] = study.modal(tail, data)
                dataclasses.replace(network, name=case.name).save(folder.path / f"{case.name}.npz")
                tail.save(folder.path / "quadratic.npz")
            models["rbf" if place == 0 else f"rbf, seed {seed}"] = study.modal(network, data)
            reports.append(report)
        for name, centres in (("arx", 0), ("rbf with output feedback", t.feedback_centres)):
            try:
                net, models[name] = study.with_feedback(data, t.largest_D, centres)
            except NetworkError as error:  # a feedback that grows: an outcome of its records
                say(f"  {error}")
                continue
            feedback.save(net, folder.path / f"{net.name}.npz")
        rows = {split: study.evaluate(models, data, split) for split in ("test", "breakup")}
        folder.keep()
        result = {
            "calm": study.summary(rows["test"], CALM),
            "whole": study.summary(rows["test"]),
            "breakup": study.summary(rows["breakup"], float("inf")),
            "seeds": reports,
            "rows": rows,
            "records_cpu_s": spent,
            "training_cpu_s": sum(r["training_cpu_s"] for r in reports),
            "cost": {"cpu_seconds": clock.process_time() - begin},
        }
        folder.write_result(result | {"provenance": source})
        page = training_report.write(folder.path / "report.md", case.name, result)
        folder.log(page)
        if options.json:
            print(
                json.dumps(
                    {k: result[k] for k in ("calm", "whole", "breakup", "records_cpu_s", "training_cpu_s")}, allow_nan=False
                )
            )
        else:
            print(training_report.table(result["whole"]))
            print(f"  network      {case.name}.npz\n  run folder   {os.path.relpath(folder.target)}")
    return ExitCode.OK


def _records(case: TrainingCase, options: argparse.Namespace, folder: Path, say: Any) -> tuple[list[Any], float]:
    """The records of the standard plan, computed where they are not there yet, and the CPU seconds they cost."""
    from ...fmus.slosh_rbf.training import dataset, plan
    from ...fmus.tank.liquid import Tank

    s, t = case.slosh, case.training
    tank = Tank(s.tank_length, s.tank_height, s.tank_width, s.fill_level, 0.0, 0.0, s.liquid_density, s.gravity)
    cells = (t.cells_x, t.cells_y)
    fine = (2 * t.cells_x, 2 * t.cells_y) if t.second_grid else None
    drive = tank_records.Drive.of(options.fmus / "slosh_vof.fmu")

    def told(now: Any) -> None:
        if now.done % 10 == 0 or now.done == now.total:
            say(f"  records {now.done}/{now.total}, {now.left:.0f} s left")

    fluids = {"liquid_viscosity": s.liquid_viscosity, "gas_viscosity": s.gas_viscosity}
    fluids |= {n: v for n in ("wall_slip", "surface_tension") if (v := getattr(s, n)) != "auto"}
    planned = plan.standard(tank, t.step, cells, fine, s.gas_density, fluids)
    paths = dataset.generate(planned, folder, drive, drive.model, options.workers, told, say)
    found = [dataset.read(path) for path in paths]
    return found, sum(float(_cpu(r.attributes)) for r in found)


def _cpu(attributes: Mapping[str, Any]) -> float:
    """What a record cost [s]."""
    return float(attributes.get("cpu_s", 0.0))


def _settings(case: TrainingCase, seed: int) -> Any:
    from ...fmus.slosh_rbf.training.fit import Settings

    t = case.training
    return Settings(tuple(t.centres), tuple(t.spreads), tuple(t.ridges), t.tuning, seed)


def _has_torch() -> bool:
    from importlib.util import find_spec

    return find_spec("torch") is not None
