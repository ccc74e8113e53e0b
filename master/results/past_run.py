"""What a run left behind, read back: settings, provenance, numbers and histories of a run folder, or of one of its files."""

from __future__ import annotations

import json
import re
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..base import settings, texts, toml_text
from ..base.errors import AeroSloshError
from . import history_file, point_file
from .point_file import Record

GUARDS = ("point", "content_sha256")  # a sweep's own, with cost and dates in them
PROVENANCE = ("versions", "fmu_sha256", "command", "date", "host", "cpu")
UNIT = re.compile(r"  # .*\[([^\[\]]+)\]$")  # as `settings.dump_table` writes it


@dataclass(frozen=True)
class PastRun:
    """A run read back.

    kind        "point", "boundary", "amplitude", "sweep", "run", or "history" for a lone file of them; only runs of one kind
                compare
    settings    of the resolved case: table.key → value; `units`: table.key → unit, where it has one
    provenance  name → value, one level: "versions.numpy", "fmu_sha256.aero", "command", …
    result      the numbers, as in result.json less the provenance
    histories   name → file of one or more
    points      of a sweep: "flow.mach = 0.8, …" → its record, with its file among `histories` under the same name
    """

    path: Path
    kind: str
    settings: dict[str, Any] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)
    provenance: dict[str, Any] = field(default_factory=dict)
    result: dict[str, Any] = field(default_factory=dict)
    histories: dict[str, Path] = field(default_factory=dict)
    points: dict[str, Record] = field(default_factory=dict)


def load(path: Path) -> PastRun:
    """Read a run folder, a sweep folder, a result.json or a history. Raises AeroSloshError for anything else."""
    if path.is_dir():
        return _folder(path)
    if path.suffix == ".json" and path.is_file():
        result, provenance = _result(path)
        return PastRun(path, _kind(result), provenance=provenance, result=result)
    if path.is_file():
        attributes = history_file.attributes(path)
        about = {name: value for name, value in attributes.items() if name in PROVENANCE}
        result = {name: value for name, value in attributes.items() if name not in (*about, *GUARDS)}
        return PastRun(path, "history", provenance=flat(about), result=result, histories={"history": path})
    raise AeroSloshError("There is no such run", str(path), "give a run folder, a result.json or a history (.nc)")


def flat(data: Any, prefix: str = "") -> dict[str, Any]:
    """Nested tables and lists as one table: {"a": {"b": [1, 2]}} → {"a.b[0]": 1, "a.b[1]": 2}."""
    if isinstance(data, dict):
        return {k: v for name, value in data.items() for k, v in flat(value, f"{prefix}.{name}" if prefix else name).items()}
    if isinstance(data, list):
        return {k: v for i, value in enumerate(data) for k, v in flat(value, f"{prefix}[{i}]").items()}
    return {prefix: data}


def _folder(path: Path) -> PastRun:
    if (path / "points").is_dir():
        return _sweep(path)
    result_file = path / "result.json"
    if not result_file.is_file():
        raise AeroSloshError("The folder holds no result.json", str(path), "give the folder that a run wrote, whole")
    result, provenance = _result(result_file)
    values, units = _settings(path / "case.toml") if (path / "case.toml").is_file() else ({}, {})
    return PastRun(
        path, _kind(result), values, units, provenance, result, {file.stem: file for file in sorted(path.glob("*.nc"))}
    )


def _sweep(path: Path) -> PastRun:
    """A sweep by its points' files: they hold all that its ledger does."""
    files = sorted((path / "points").glob("*.nc"))
    if not files:
        raise AeroSloshError("The sweep has no finished point", str(path / "points"), "finish it: aeroslosh sweep … --resume")
    records = [point_file.read(file) for file in files]
    names = [", ".join(f"{k} = {toml_text.literal(v)}" for k, v in sorted(r.overrides.items())) for r in records]
    twice = Counter(names)  # a folder may keep points of an earlier case with the same overrides
    names = [f"{name} ({r.id})" if twice[name] > 1 else name for name, r in zip(names, records, strict=True)]
    values, units = _settings(path / "case.toml") if (path / "case.toml").is_file() else ({}, {})
    about = flat({name: value for name, value in history_file.attributes(files[0]).items() if name in PROVENANCE})
    histories, points = dict(zip(names, files, strict=True)), dict(zip(names, records, strict=True))
    return PastRun(path, "sweep", values, units, about, {}, histories, points)


def _kind(result: dict[str, Any]) -> str:
    if isinstance(result.get("points"), list):
        return "boundary"
    if isinstance(result.get("speeds"), list):
        return "amplitude"
    return "point" if "verdict" in result else "run"


def _result(path: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """The numbers and the provenance of a result.json."""
    try:
        data = json.loads(texts.read(path, "result"))
    except (OSError, ValueError) as error:
        raise AeroSloshError(f"The result cannot be read: {error}", str(path), "give what a run wrote, whole") from None
    if not isinstance(data, dict):
        raise AeroSloshError("The file holds no result of a run", str(path), "give a result.json that a run wrote")
    kept = {k: v for k, v in data.items() if k not in ("provenance", "defaults")}  # the settings tell all values
    return kept, flat(data.get("provenance", {}))


def _settings(path: Path) -> tuple[dict[str, Any], dict[str, str]]:
    """Values and units of a resolved case: table.key → …, whatever tables it has."""
    data, lines = settings.read(path, "resolved case", "case.toml of a run folder")
    text = texts.read(path, "resolved case").splitlines()
    values = {f"{table}.{key}": value for table, keys in data.items() if isinstance(keys, dict) for key, value in keys.items()}
    values |= {key: value for key, value in data.items() if not isinstance(value, dict)}
    units = {f"{table}.{key}": m[1] for (table, key), line in lines.items() if key and (m := UNIT.search(text[line - 1]))}
    return values, units
