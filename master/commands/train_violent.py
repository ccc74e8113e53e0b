"""The violent branch of `aeroslosh train`: records of breaking surfaces, one ridge solve, a report."""

from __future__ import annotations

import argparse
import dataclasses
import json
import os
import time as clock
from pathlib import Path
from typing import Any

from ..base.errors import AeroSloshError, ExitCode
from ..cosim.progress import Progress
from ..results.provenance import provenance
from ..results.run_folder import RunFolder
from ..training import case as training_case
from ..training import tank_records, violent_report
from ..training.case import TrainingCase
from . import common


def execute(case: TrainingCase, options: argparse.Namespace) -> int:
    """Records, branch, tests, report."""
    from ...fmus.slosh_rbf.training import dataset, violent_study  # what a user of the other commands need not load
    from ...fmus.slosh_rbf.training.violent_fit import Settings

    progress, v = Progress(options.quiet or options.json), case.violent
    with RunFolder(options.out or Path("runs") / f"{case.name}_train") as folder:
        folder.write_settings(training_case.dump(case))

        def say(text: str) -> None:
            common.say(text, folder, progress)

        begin = clock.process_time()
        drive = tank_records.Drive.of(options.fmus / "slosh_vof.fmu")
        source = provenance({"slosh_vof": drive.sha256})
        every = [
            Settings(centres, spread, tuple(v.ridges), v.work, v.thin, v.seed) for centres in v.centres for spread in v.spreads
        ]
        try:
            found = _records(case, options, drive, say)
            data = violent_study.tables(found)
            start = clock.process_time()
            made, report = violent_study.train(data, case.name, every, say, source)
        except dataset.DatasetError as error:
            what, _, rest = str(error).partition("\n")
            raise AeroSloshError(what, rest.strip(), "", ExitCode.COMPONENT) from None
        report |= {
            "fit_cpu_s": clock.process_time() - start,
            "records_cpu_s": sum(float(r.attributes.get("cpu_s", 0.0)) for r in found),
            "simulated_s": sum(float(r.motion.times[-1]) for r in found),
            "records": len(found),
        }
        kept = {**made.about, **{k: report[k] for k in ("splits", "fit_cpu_s", "records_cpu_s", "simulated_s", "records")}}
        dataclasses.replace(made, about=kept).save(folder.path / f"{case.name}.npz")
        folder.keep()
        folder.write_result({**report, "provenance": source, "cost": {"cpu_seconds": clock.process_time() - begin}})
        page = violent_report.write(folder.path / "report.md", case.name, report)
        folder.log(page)
        if options.json:
            print(json.dumps({k: v for k, v in report.items() if k != "tried"}, allow_nan=False))
        else:
            print(violent_report.table(report["splits"]))
            print(f"  branch       {case.name}.npz\n  run folder   {os.path.relpath(folder.target)}")
    return ExitCode.OK


def _records(case: TrainingCase, options: argparse.Namespace, drive: tank_records.Drive, say: Any) -> list[Any]:
    """The records of the violent plan, computed where they are not there yet."""
    from ...fmus.slosh_rbf.training import dataset, violent_plan
    from ...fmus.tank.liquid import Tank

    s, t, v = case.slosh, case.training, case.violent
    tank = Tank(s.tank_length, s.tank_height, s.tank_width, 0.5, 0.0, 0.0, s.liquid_density, s.gravity)
    sizes = violent_plan.Sizes(v.train, v.marches, v.validation, v.test, (v.fills[0], v.fills[1]), tuple(v.test_fills))
    fluids = {"liquid_viscosity": s.liquid_viscosity, "gas_viscosity": s.gas_viscosity}
    fluids |= {n: value for n in ("wall_slip", "surface_tension") if (value := getattr(s, n)) != "auto"}

    def told(now: Any) -> None:
        if now.done % 10 == 0 or now.done == now.total:
            say(f"  records {now.done}/{now.total}, {now.left:.0f} s left")

    planned = violent_plan.violent(tank, sizes, t.step, (t.cells_x, t.cells_y), s.gas_density, fluids)
    folder = options.records or Path("runs") / f"{case.name}_records"
    return [dataset.read(path) for path in dataset.generate(planned, folder, drive, drive.model, options.workers, told, say)]
