"""What a figure's module is given: the size of the task, the FMUs, and what figures share."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from ..base import files
from ..fmi import unpack
from ..results.provenance import source_hash

T = TypeVar("T")
MODELS = ("structure", "aero", "slosh_ems", "slosh_vof", "slosh_rbf")


@dataclass
class Work:
    """out      folder of all figures; what several of them need lies in `shared` below it
    fmus        folder of the FMUs
    small       coarse meshes, few points: to see that everything runs; verdicts mean little
    workers     processes that search Mach numbers side by side
    fresh       compute anew what is there
    say         told of what begins"""

    out: Path
    fmus: Path
    small: bool = False
    workers: int | None = None
    fresh: bool = False
    say: Callable[[str], None] = lambda text: None
    _made: set[str] = field(default_factory=set)

    def pick(self, full: T, small: T) -> T:
        """One of two sizes of a task."""
        return small if self.small else full

    def fmu(self, name: str) -> Path:
        """The file of an FMU."""
        return self.fmus / f"{name}.fmu"

    @property
    def key(self) -> dict[str, Any]:
        """What a result depends on: size of the task, content of the FMUs, and the master's own source."""
        paths = [self.fmu(name) for name in MODELS]
        whole = "".join(unpack.sha256(path) if path.is_file() else "missing" for path in paths)
        fmus = hashlib.sha256(whole.encode()).hexdigest()
        return {"small": self.small, "fmus": fmus[:16], "master": source_hash()[:16]}

    def shared(self, name: str, compute: Callable[[], Any]) -> Any:
        """What `compute` gives (made of what JSON holds), computed once for all figures and kept; an interrupt loses what was
        at work alone. Raises what `compute` raises."""
        path = self.out / "shared" / f"{name}.json"
        if path.is_file() and (not self.fresh or name in self._made):
            found = json.loads(path.read_text(encoding="utf-8"))
            if found["key"] == self.key:
                return found["data"]
        self.say(f"  {name}")
        data = json.loads(json.dumps(compute()))
        path.parent.mkdir(parents=True, exist_ok=True)
        files.write(path, (json.dumps({"key": self.key, "data": data}, indent=1) + "\n").encode())
        self._made.add(name)
        return data

    def folder(self, name: str) -> Path:
        """A folder in `shared` for a computation that keeps its own files there; emptied once where all is to be fresh."""
        path = self.out / "shared" / name / self.key["fmus"]
        if self.fresh and name not in self._made:
            shutil.rmtree(path, ignore_errors=True)
        self._made.add(name)
        path.mkdir(parents=True, exist_ok=True)
        return path


def cpu_seconds() -> float:
    """CPU time of this process and of those it has waited for [s]."""
    t = os.times()
    return t.user + t.system + t.children_user + t.children_system
