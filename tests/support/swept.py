"""Sweeps through the command: their lines, their ledgers and numbers, the processes at work."""

from __future__ import annotations

import sqlite3
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import netcdf_file

from aeroslosh.master.results import point_file

from .paths import CASES
from .processes import COMMAND, Done, called


def sweep(out: Path, fmus: Path, *arguments: str, case: str = "isogai_a") -> list[str]:
    """The command line."""
    return [*COMMAND, "sweep", str(CASES / f"{case}.toml"), "--out", str(out), "--fmus", str(fmus), *arguments]


def run(out: Path, fmus: Path, *arguments: str, code: int = 0, case: str = "isogai_a") -> Done:
    """Run it to its end, its master in this process."""
    done = called(*sweep(out, fmus, *arguments, case=case)[len(COMMAND) :])
    assert done.returncode == code, (done.returncode, done.stdout, done.stderr)
    return done


def ledger(out: Path) -> dict[str, dict[str, Any]]:
    """Rows of the ledger by id."""
    base = sqlite3.connect(f"file:{out / 'ledger.sqlite'}?mode=ro", uri=True)
    base.row_factory = sqlite3.Row
    rows = {row["id"]: dict(row) for row in base.execute("SELECT * FROM points ORDER BY number")}
    base.close()
    return rows


def times(out: Path) -> dict[str, int]:
    """When each point's file was written [ns]."""
    return {path.stem: path.stat().st_mtime_ns for path in (out / "points").glob("*.nc")}


def numbers(out: Path) -> dict[str, Any]:
    """Everything computed, by point: results without costs, histories bit by bit."""
    found = {}
    for path in sorted((out / "points").glob("*.nc")):
        with netcdf_file(str(path), "r", mmap=False) as file:
            histories = {name: np.array(v[:]).tobytes() for name, v in file.variables.items()}
        found[path.stem] = without_cost(point_file.read(path).result), histories
    return found


def without_cost(data: Any) -> Any:
    """`data` without its seconds."""
    if isinstance(data, dict):
        return {key: without_cost(value) for key, value in data.items() if key != "cost"}
    return [without_cost(value) for value in data] if isinstance(data, list) else data


def children(pid: int) -> list[int]:
    """Processes started by `pid`."""
    try:
        return [int(word) for word in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
    except OSError:
        return []


def alive(pid: int) -> bool:
    """Whether a process is there and no zombie."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False
