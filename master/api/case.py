"""`Case`: every setting of a flutter study, from a file, by name, or changed in a program."""

from __future__ import annotations

import copy
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

    def replace(self, **tables: Mapping[str, Any]) -> Case:
        """A copy with keys changed: `replace(flow={"mach": 0.8}, slosh={"model": "vof"})`.

        Raises AeroSloshError for an unknown table or key and for a value outside its range."""
        changes: dict[str, Any] = {}
        for table, keys in tables.items():
            if table not in cases.TABLES:
                raise AeroSloshError(
                    f"Unknown table '{table}'", "Case.replace", settings.nearest(table, list(cases.TABLES), "the tables are")
                )
            changes |= {f"{table}.{name}": value for name, value in keys.items()}
        return self.changed(changes)

    def changed(self, changes: Mapping[str, Any]) -> Case:
        """The same with keys as a sweep has them: `changed({"flow.mach": 0.8})`."""
        for dotted in changes:
            if dotted not in self.settings:
                raise AeroSloshError(
                    f"Unknown key '{dotted}'", "Case.changed", settings.nearest(dotted, list(self.settings), "the keys are")
                )
        plain = {key: _plain(value) for key, value in changes.items()}
        return Case(cases.changed(self._core, plain, "Case.replace"))

    @property
    def name(self) -> str:
        """The stem of the file it came from."""
        return self._core.name

    @property
    def settings(self) -> dict[str, Any]:
        """Every key with its value: {"flow.mach": 0.825, …}."""
        return cases.flat(self._core)

    def __getitem__(self, key: str) -> Any:
        """One value by "table.key". Raises KeyError."""
        return self.settings[key]

    @property
    def core(self) -> cases.Case:
        """A copy of what the master works with."""
        return copy.deepcopy(self._core)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write it as a TOML file, every key with value, unit and meaning."""
        files.write(Path(path), cases.dump(self._core).encode())

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


def _plain(value: Any) -> Any:
    """numpy's numbers as Python's."""
    return value.item() if hasattr(value, "item") and getattr(value, "ndim", 0) == 0 else value
