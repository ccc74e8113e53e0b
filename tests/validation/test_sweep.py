"""A thousand points in one worker's life: what it holds in memory stays the same."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from aeroslosh.master.case import case as cases
from aeroslosh.master.sweeps import parameters, plan
from aeroslosh.master.sweeps.jobs import Job
from aeroslosh.master.sweeps.workers import Worker
from support.paths import CASES

pytestmark = pytest.mark.validation
CASE = CASES / "paper_s.toml"
SHORT = (
    "aero.cells_around=64", "aero.cells_normal=16", "flutter.forced_cycles=0.5", "flutter.free_cycles=1.5",
    "flutter.steps_per_cycle=24",
)  # fmt: skip


@pytest.mark.parametrize(
    "swept",
    [["flutter.V_f=0.3:0.9:1000"], ["flow.mach=0.4:0.7:500", "flutter.V_f=0.5,0.6"]],
    ids=["one setup", "500 setups"],
)
def test_memory_is_flat_over_a_thousand_points(fmu: Callable[[str], Path], tmp_path: Path, swept: list[str]) -> None:
    """Resident memory after 100 and after 1,000 points, real FMUs with slosh: within 5 %."""
    for name in ("structure", "aero", "slosh_ems"):
        shutil.copy(fmu(name), tmp_path)
    points = plan.make(cases.load(CASE, SHORT), [parameters.from_words(w, "--grid") for w in swept], tmp_path, str(CASE)).points
    worker = Worker("memory")
    memory = []
    try:
        for point in points:
            answer = worker.ask("compute", Job(point.id, "point", point.case, point.overrides, point.files))
            assert answer.product is not None and answer.product.record.status == "done"
            memory.append(answer.memory / 2**20)
    finally:
        worker.end()
    print(f"\n  {' '.join(swept)}: {memory[99]:.1f} MiB after 100 points, {memory[-1]:.1f} MiB after {len(memory)}")
    assert len(memory) == 1000 and memory[-1] == pytest.approx(memory[99], rel=0.05)
