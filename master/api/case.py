"""`Case`: every setting of a flutter study, from a file, by name, or changed in a program."""

from __future__ import annotations

import copy
import dataclasses
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..base import files, settings
from ..base.errors import AeroSloshError
from ..case import builtin
from ..case import case as cases


class Case:
    """A flutter case. Immutable: `replace` gives a changed copy. All keys are listed in docs/cases.md and by `print(case)`.

    >>> case = Case.isogai_a().replace(flow={"mach": 0.8}, slosh={"model": "ems"})
    >>> case["flow.mach"]
    0.8
    """

    def __init__(self, _core: cases.Case) -> None:
        self._core = _core

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Case:
        """The case in a TOML file, or a built-in one by its name (`Case.names()`).

        Raises AeroSloshError naming file, line, key and remedy."""
        return cls(cases.load(builtin.resolve(Path(path))))

    @classmethod
    def isogai_a(cls) -> Case:
        """Isogai's case A (AIAA J. 17(7), 1979, doi 10.2514/3.61226), dry, NACA 64A010."""
        return cls.load("isogai_a")

    @staticmethod
    def names() -> list[str]:
        """The built-in cases."""
        return builtin.names()

    @classmethod
    def of(cls, case: Case | str | os.PathLike[str]) -> Case:
        """`case` itself, or the one of that file or name. Raises AeroSloshError."""
        if isinstance(case, Case):
            return case
        if not isinstance(case, str | os.PathLike):
            raise AeroSloshError(
                f"{case!r} is no case", "ae.Case", "give an ae.Case, the path of a case, or a built-in one's name"
            )
        return cls.load(case)

    def replace(self, **tables: Mapping[str, Any]) -> Case:
        """A copy with keys changed: `replace(flow={"mach": 0.8}, slosh={"model": "vof"})`; None leaves a key out again.

        Raises AeroSloshError for an unknown table or key and for a value outside its range."""
        changes: dict[str, Any] = {}
        for table, keys in tables.items():
            if table not in cases.TABLES:
                raise AeroSloshError(
                    f"Unknown table '{table}'", "Case.replace", settings.nearest(table, list(cases.TABLES), "the tables are")
                )
            if not isinstance(keys, Mapping):
                raise AeroSloshError(f"{table} = {keys!r} is no table", "Case.replace", f'write {table}={{"key": value}}')
            changes |= {f"{table}.{name}": value for name, value in keys.items()}
        return self.changed(changes)

    def changed(self, changes: Mapping[str, Any]) -> Case:
        """The same with keys as a sweep has them: `changed({"flow.mach": 0.8, "slosh.parameters.baffle_count": 2})`."""
        core, given = self.core, {}
        for dotted, value in changes.items():
            table, _, name = str(dotted).partition(".")
            own = {f.name: f for f in dataclasses.fields(cases.TABLES[table])} if table in cases.TABLES else {}
            if name.partition(".")[0] not in own or ("." in name and not name.startswith("parameters.")):
                known = [f"{t}.{f.name}" for t, kind in cases.TABLES.items() for f in dataclasses.fields(kind)]
                raise AeroSloshError(
                    f"Unknown key '{dotted}'", "Case.changed", settings.nearest(str(dotted), known, "the keys are")
                )
            if value is not None:
                given[dotted] = plain(value)
                continue
            if "." in name:
                getattr(core, table).parameters.pop(name.partition(".")[2], None)
            else:
                setattr(getattr(core, table), name, getattr(cases.TABLES[table](), name))
            core.given.discard(dotted)
        return Case(cases.changed(core, given, "Case.replace"))

    @property
    def name(self) -> str:
        """The stem of the file it came from."""
        return self._core.name

    @property
    def settings(self) -> dict[str, Any]:
        """Every key with its value: {"flow.mach": 0.825, …}."""
        return copy.deepcopy(cases.flat(self._core))

    def __getitem__(self, key: str) -> Any:
        """One value by "table.key", of an FMU's parameter by "table.parameters.name". Raises KeyError."""
        head, parameters, name = key.partition(".parameters.")
        return self.settings[f"{head}.parameters"][name] if parameters else self.settings[key]

    @property
    def core(self) -> cases.Case:
        """A copy of what the master works with."""
        return copy.deepcopy(self._core)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write it as a TOML file, every key with value, unit and meaning. Raises AeroSloshError."""
        try:
            files.write(Path(path), cases.dump(self._core).encode())
        except OSError as error:
            raise AeroSloshError(f"The case cannot be written: {error.strerror}", str(path), "name another file") from None

    def __str__(self) -> str:
        return cases.dump(self._core)

    def __repr__(self) -> str:
        s = self.settings
        return (
            f"Case({self.name}: Mach {s['flow.mach']:g}, V_f {s['flutter.V_f']:g}, {s['flow.airfoil']}, slosh {s['slosh.model']})"
        )

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Case) and self.settings == other.settings

    def __hash__(self) -> int:
        return hash(repr(sorted(self.settings.items(), key=lambda item: item[0])))


def plain(value: Any) -> Any:
    """numpy's numbers and arrays, tuples and paths as a case file has them."""
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if hasattr(value, "tolist"):
        return value.tolist()
    return [plain(entry) for entry in value] if isinstance(value, tuple | list) else value
