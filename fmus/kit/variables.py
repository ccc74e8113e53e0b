"""Declaration of the variables of an FMU: one line each, checked when the module is imported.

The type follows from the start value (`1.0` Real, `1` Integer, `True` Boolean, `"x"` String): write `0.0`,
not `0`, for a Real. Parameters and inputs are plain attributes of the slave (`self.mass`); outputs are
attributes that the face assigns in `initialize` and `step`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from . import units

LARGEST = 1.7976931348623157e308
Value = float | int | bool | str
TYPES: dict[type, str] = {bool: "Boolean", int: "Integer", float: "Real", str: "String"}
UNSET: dict[str, Value] = {"Real": math.nan, "Integer": 0, "Boolean": False, "String": ""}


@dataclass(frozen=True)
class Variable:
    """One scalar variable of the face.

    Attributes:
        name: the name in the FMU and the attribute of the slave.
        causality: "parameter", "input" or "output".
        type: "Real", "Integer", "Boolean" or "String"; an enumeration is an Integer with `items`.
        start: start value; None for outputs.
        unit: name in `units.BASE`; Reals only.
        min, max: inclusive range, or None for no bound.
        nominal: typical magnitude, or None.
        quantity: what is measured ("Length"), or "".
        items: of an enumeration, each item's name and description, numbered from 0.
        depends: of an output, the parameters and inputs that its initial value is made of. There is no other dependency: an input
            is read by the next step, and moves no output where the instance stands.
        tunable: whether a parameter may be set between steps.
    """

    name: str
    causality: str
    type: str
    description: str
    start: Value | None = None
    unit: str = ""
    min: float | None = None
    max: float | None = None
    nominal: float | None = None
    quantity: str = ""
    items: tuple[tuple[str, str], ...] = ()
    depends: tuple[str, ...] = ()
    tunable: bool = False

    def __post_init__(self) -> None:
        if not self.name.isidentifier():
            raise ValueError(f"Variable name '{self.name}' is no identifier")
        if self.type == "Real":
            units.base(self.unit)
        if self.causality != "output" and (problem := self.problem(self.start)):
            raise ValueError(f"Start value: {problem}")

    @property
    def low(self) -> float:
        """Smallest value allowed; the most negative finite number where no bound is declared."""
        return -LARGEST if self.min is None else self.min

    @property
    def high(self) -> float:
        """Largest value allowed; the largest finite number where no bound is declared."""
        return LARGEST if self.max is None else self.max

    def problem(self, value: Value | None) -> str:
        """Say in one sentence why `value` is refused, or return "" if it is allowed."""
        if self.type == "String":
            return "" if isinstance(value, str) else f"{self.causality} '{self.name}' is no string. Remedy: give one"
        if self.type == "Boolean":
            return ""
        if not isinstance(value, float | int) or (isinstance(value, float) and not math.isfinite(value)):
            return f"{self.causality} '{self.name}' = {value} is not a finite number. Remedy: {self._remedy()}"
        if self.low <= value <= self.high:
            return ""
        unit = f" {self.unit}" if self.unit not in ("", "1") else ""
        return f"{self.causality} '{self.name}' = {value}{unit} is outside its range. Remedy: {self._remedy()}"

    def _remedy(self) -> str:
        if self.items:
            return "give one of " + ", ".join(f"{i} ({name})" for i, (name, _) in enumerate(self.items))
        unit = f" {self.unit}" if self.unit not in ("", "1") else ""
        bounds = [] if self.min is None else [f"at least {self.min}"]
        bounds += [] if self.max is None else [f"at most {self.max}"]
        if not bounds:
            within = f" in{unit}" if unit else ""
            return f"give a finite value{within}; look at what drives it for a diverged value"
        return f"give a value of {' and '.join(bounds)}{unit}"


def parameter(
    name: str,
    start: Value,
    unit: str,
    description: str,
    *,
    min: float | None = None,
    max: float | None = None,
    nominal: float | None = None,
    quantity: str = "",
    tunable: bool = False,
) -> Variable:
    """Declare a parameter, fixed after initialisation unless `tunable`. `unit` is used for Reals only."""
    return Variable(
        name,
        "parameter",
        TYPES[type(start)],
        description,
        start,
        _unit(start, unit),
        min,
        max,
        nominal,
        quantity,
        tunable=tunable,
    )


def choice(name: str, start: str, items: Mapping[str, str], description: str) -> Variable:
    """Declare a parameter that is one of named `items` (name -> description), numbered from 0.

    The attribute of the slave is the number; `start` is the name.
    """
    pairs = tuple(items.items())
    number = list(items).index(start)
    return Variable(name, "parameter", "Integer", description, number, min=0, max=len(pairs) - 1, items=pairs)


def input_(
    name: str,
    start: Value,
    unit: str,
    description: str,
    *,
    min: float | None = None,
    max: float | None = None,
    nominal: float | None = None,
    quantity: str = "",
) -> Variable:
    """Declare an input: the value at the end of the communication step (see docs/design.md)."""
    return Variable(name, "input", TYPES[type(start)], description, start, _unit(start, unit), min, max, nominal, quantity)


def output(
    name: str,
    unit: str,
    description: str,
    *,
    depends: Iterable[str] = (),
    type: type = float,
    nominal: float | None = None,
    quantity: str = "",
) -> Variable:
    """Declare an output of Python `type` float, int, bool or str.

    `depends` names the parameters and inputs that its initial value is made of: what `prepare` and `initialize` read for it.
    """
    return Variable(
        name,
        "output",
        TYPES[type],
        description,
        unit=unit if type is float else "",
        nominal=nominal,
        quantity=quantity,
        depends=tuple(dict.fromkeys(depends)),
    )


def _unit(start: Value, unit: str) -> str:
    return unit if type(start) is float else ""
