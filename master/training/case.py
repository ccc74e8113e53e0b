"""A training file: which tank, which records, which networks. TOML, read and written like a case."""

from __future__ import annotations

import dataclasses
import typing
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..base import settings
from ..base.errors import AeroSloshError
from ..base.settings import key, rule
from ..case import checks, plausible
from ..case.case import Slosh

RESERVED = ("quadratic", "arx", "rbf_feedback", "ems", "bilinear")  # the other networks of a training, and the equations
REQUIRED = ("slosh.tank_length", "slosh.tank_height", "slosh.fill_level", "slosh.liquid_density", "slosh.liquid_viscosity")
USED = ("training.cells_x", "training.cells_y", "training.step")  # keys of [training] that a violent training reads
FILL = "slosh.fill_level"
IDLE = (
    "model",
    "predictor",
    "split",
    "tank_x",
    "tank_y",
    "modes",
    "damping_ratio",
    "parametric",
    "network",
    "cells_x",
    "cells_y",
    "parameters",
)


@dataclass
class Training:
    """Records and networks."""

    cells_x: int = key(100, "cells along the tank", low=16, high=2048)
    cells_y: int = key(30, "cells over its height", low=16, high=2048)
    second_grid: bool = key(True, "test records on twice the cells each way too: what the flow solver itself is worth")
    step: float = key(2e-3, "step of the records", "s", above=0.0, high=5e-3)
    largest_D: float = key(1.5, "records with running D above this are left out of training", above=0.0, high=10.0)
    centres: list[int] = field(default_factory=lambda: [20, 40], metadata=rule("numbers of Gaussians tried", low=1, high=1000))
    spreads: list[float] = field(default_factory=lambda: [3.0, 6.0], metadata=rule("their spreads, in scales", above=0.0))
    ridges: list[float] = field(default_factory=lambda: [1e-6, 1e-4, 1e-2], metadata=rule("ridges tried on them", above=0.0))
    tuning: int = key(0, "steps of the search for better centres (needs torch, extra train)", low=0, high=100000)
    seeds: list[int] = field(default_factory=lambda: [0, 1, 2], metadata=rule("seeds; the first one's network is kept", low=0))
    feedback_centres: int = key(60, "Gaussians of the network with output feedback that stands beside", low=1, high=1000)


@dataclass
class Violent:
    """Records of breaking surfaces and the branch of a network for them."""

    train: int = key(0, "records to train on; above 0 a violent branch is trained, and nothing else", low=0, high=100000)
    marches: int = key(150, "more of them, as flutter marches move the tank", low=1, high=100000)
    validation: int = key(32, "records to choose by", low=4, high=10000)
    test: int = key(40, "records to measure by, each with a twin", low=4, high=10000)
    fills: list[float] = field(
        default_factory=lambda: [0.3, 0.7], metadata=rule("least and most fill of the records", low=0.05, high=0.95)
    )
    test_fills: list[float] = field(
        default_factory=lambda: [0.5, 0.5, 0.4, 0.6, 0.35], metadata=rule("fills of the tests, in turn", low=0.05, high=0.95)
    )
    centres: list[int] = field(default_factory=lambda: [120], metadata=rule("numbers of Gaussians tried", low=1, high=1000))
    spreads: list[float] = field(
        default_factory=lambda: [1.2, 1.4], metadata=rule("their spreads, in distances of neighbouring centres", above=0.0)
    )
    ridges: list[float] = field(default_factory=lambda: [1e-3, 1e-2, 1e-1], metadata=rule("ridges tried", above=0.0))
    work: float = key(3.0, "weight of the work of a cycle against a sample of the force", low=0.0, high=1e3)
    thin: int = key(4, "every so many samples are used", low=1, high=1000)
    seed: int = key(0, "of centres and sampling", low=0)


@dataclass
class TrainingCase:
    """A training file. `name` is the file's stem, and the network's."""

    name: str = "slosh_rbf"
    slosh: Slosh = field(default_factory=Slosh)
    training: Training = field(default_factory=Training)
    violent: Violent = field(default_factory=Violent)


TABLES: dict[str, Any] = {n: h for n, h in typing.get_type_hints(TrainingCase).items() if dataclasses.is_dataclass(h)}


def load(path: Path, overrides: Sequence[str] = ()) -> TrainingCase:
    """Read a training file and apply `table.key=value` overrides. Raises AeroSloshError (file, line, key, remedy)."""
    data, lines = settings.read(path, "training file", "cases/slosh_rbf.toml")
    case = TrainingCase(path.stem)
    settings.fill(case, TABLES, data, lines, path)
    given = {f"{table}.{name}" for table, content in data.items() for name in content}
    for override in overrides:
        settings.override(case, TABLES, override)
        given.add(override.partition("=")[0].strip())
    breaks = case.violent.train > 0
    checks.require(case, [n for n in REQUIRED if not (breaks and n == FILL)], given, str(path), "a training")
    if breaks:
        _check_violent(case, given, path)
    plausible.refuse_liquid(case, str(path))
    if case.slosh.fill_level == 1.0:
        raise AeroSloshError(
            "slosh.fill_level = 1: the liquid of a full tank does not slosh, there is nothing to learn",
            str(path),
            'give a fill below 1; slosh.model = "ems" carries the mass and inertia of a full tank',
        )
    if case.name in RESERVED:
        raise AeroSloshError(
            f"A network cannot be called '{case.name}'", str(path), f"another file name than {', '.join(RESERVED)}"
        )
    usual = Slosh()
    idle = [name for name in IDLE if getattr(case.slosh, name) != getattr(usual, name)]
    if idle:
        raise AeroSloshError(
            f"slosh.{idle[0]} has no effect on a training",
            str(path),
            "leave it out: records are made on the axis, on training.cells_*",
        )
    return case


def _check_violent(case: TrainingCase, given: set[str], path: Path) -> None:
    """What a violent training has no use for, and fills that make no sense."""
    idle = sorted(n for n in given if n == FILL or (n.startswith("training.") and n not in USED))
    if idle:
        raise AeroSloshError(f"{idle[0]} has no effect on a violent training", str(path), "leave it out; fills are violent.fills")
    fills = case.violent.fills
    if len(fills) != 2 or not fills[0] < fills[1]:
        raise AeroSloshError(
            f"violent.fills = {fills}", str(path), "give the least and the largest fill, for instance [0.3, 0.7]"
        )
    for name in ("test_fills", "centres", "spreads", "ridges"):
        if not getattr(case.violent, name):
            raise AeroSloshError(f"violent.{name} is empty", str(path), "give at least one value")


def dump(case: TrainingCase) -> str:
    """The resolved training file."""
    return f"# resolved training {case.name}: every key with its value, unit and meaning\n{settings.dump(case, TABLES)}"
