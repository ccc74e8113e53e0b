"""What a run left behind, again as the objects that computing it gives."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from ..base.errors import AeroSloshError
from ..results import past_run
from . import datasets
from .amplitude import Amplitude
from .boundary import Boundary
from .case import Case
from .point import Point
from .sweep import dataset

if TYPE_CHECKING:
    import xarray as xr


def open_run(path: str | os.PathLike[str]) -> Point | Boundary | Amplitude | xr.Dataset:
    """A run folder of `point` (→ Point), `boundary` (→ Boundary), `amplitude` (→ Amplitude), `run` (→ Dataset of its history), a
    sweep folder (→ Dataset over the swept keys), or one history file (→ Dataset).

    Raises AeroSloshError for anything else."""
    place = Path(path).absolute()
    if place.name in ("result.json", "case.toml", "ledger.sqlite"):
        place = place.parent
    if (place / "ledger.sqlite").is_file():
        return dataset(place)
    if place.is_file():
        found = datasets.of_file(place)
        if len(found) != 1:
            raise AeroSloshError(f"The file holds {len(found)} histories", str(place), "open the sweep's folder instead")
        return found[0]
    run = past_run.load(place)
    if run.kind == "run":
        return datasets.of_file(place / "history.nc")[0]
    case = Case.load(place / "case.toml") if (place / "case.toml").is_file() else None
    if run.kind == "boundary":
        return Boundary(case, run.result, place)
    if run.kind == "amplitude":
        return Amplitude(case, run.result, place)
    if run.kind == "point":
        return Point(case, run.result, place)
    raise AeroSloshError(
        "The sweep's ledger is gone", str(place), "the same sweep, called again there, makes it from the points' files"
    )
