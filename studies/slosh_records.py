"""Records of the two-phase tank for the surrogate: the standard plan of fmus/slosh_rbf/training/plan.py through slosh_vof.fmu.

`python -m studies.slosh_records FOLDER [--fmu dist/fmus/slosh_vof.fmu] [--workers 1] [--fill 0.5] [--split train ...]`. Goes on
where an earlier call was stopped.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from aeroslosh.fmus.slosh_rbf.training.dataset import DatasetError, Progress, generate
from aeroslosh.fmus.slosh_rbf.training.plan import TANK, standard
from aeroslosh.fmus.tank.liquid import Tank
from aeroslosh.master.base.errors import AeroSloshError
from aeroslosh.master.training.tank_records import Drive


def main() -> int:
    """Make the records; exit code 2 where they cannot be made."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0] if __doc__ else "")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--fmu", type=Path, default=Path("dist/fmus/slosh_vof.fmu"))
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--fill", type=float, default=TANK.fill_level)
    parser.add_argument("--split", nargs="*", default=["train", "validation", "test", "breakup"])
    arguments = parser.parse_args()
    plan = [
        entry for entry in standard(Tank(TANK.length, TANK.height, fill_level=arguments.fill)) if entry.split in arguments.split
    ]
    try:
        drive = Drive.of(arguments.fmu)
        paths = generate(plan, arguments.folder, drive, drive.model, arguments.workers, show, say)
    except (AeroSloshError, DatasetError) as error:
        say(str(error))
        return 2
    say(f"{len(paths)} records in {arguments.folder}")
    return 0


def show(progress: Progress) -> None:
    """One line a record."""
    say(f"{progress.done}/{progress.total}  {progress.name}  {progress.cpu:.1f} s CPU  {progress.left:.0f} s left")


def say(text: str) -> None:
    """On standard error."""
    print(text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
