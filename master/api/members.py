"""The members of one point in worker processes, while its first member is marched here."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import Any

from ..analysis.members import Ensemble, Member
from ..analysis.verdict import Verdict
from ..base.cores import usable_cores
from ..case.case import Case
from ..flutter import ensemble
from ..fmi import unpack
from ..sweeps.jobs import Job, Product
from ..sweeps.workers import LocalPool

TRIES = 2  # times a member is given to a worker that dies over it
FOREVER = 1 << 30


class Members:
    """Use as a context manager; `gathered` waits for all. Nothing is started where the case asks for one member."""

    def __init__(self, case: Case, fmus: dict[str, Path], say: Callable[[str], None]) -> None:
        self._seeds, self._say = ensemble.seeds(case), say
        self._found: dict[int, Member] = {}
        self._tries: dict[str, int] = {}
        others = self._seeds[1:]
        self._pool = LocalPool[Job, Product](min(usable_cores(), max(1, len(others))), FOREVER)
        files = {name: (path, unpack.sha256(path)) for name, path in fmus.items()}
        for seed in others:
            self._pool.add(Job(str(seed), "point", ensemble.member(case, seed), {}, files))

    def __enter__(self) -> Members:
        self._hear(0.0)
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._pool.close()

    def gathered(self, first: Member) -> Ensemble:
        """All members; a member that fails has no growth rate, and is said. Raises AeroSloshError when workers cannot start."""
        self._found[first.seed] = first
        while len(self._found) < len(self._seeds):
            self._hear(1.0)
        return Ensemble(tuple(self._found[seed] for seed in self._seeds))

    def _hear(self, seconds: float) -> None:
        if len(self._seeds) == 1:
            return
        events = self._pool.wait(seconds)
        for job, cause in events.lost:
            self._tries[job.id] = self._tries.get(job.id, 0) + 1
            if self._tries[job.id] < TRIES:
                self._pool.add(job)
            else:
                self._take(int(job.id), None, cause)
        for product in events.products:
            self._take(int(product.record.id), product.record.result, product.record.cause)

    def _take(self, seed: int, data: dict[str, Any] | None, cause: str) -> None:
        if data is None or cause:
            self._say(f"note: the member of seed {seed} failed: {cause}")
            self._found[seed] = Member(seed, math.nan, math.nan, math.nan, Verdict.UNDETERMINED)
            return
        rate, std, frequency = (
            math.nan if data[key] is None else float(data[key]) for key in ("growth_rate", "growth_rate_uncertainty", "frequency")
        )
        self._found[seed] = Member(seed, rate, std, frequency, Verdict(data["verdict"]))
        self._say(f"member of seed {seed}: growth rate {rate:+.5f}, {data['verdict']}")
