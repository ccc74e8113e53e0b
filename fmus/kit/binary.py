"""Value references of one type, as a host hands them in: what is none says so."""

from __future__ import annotations

from typing import Any

from .failure import StepError


class ByReference(dict[int, Any]):
    """What belongs to the variables of one type, by value reference."""

    def __init__(self, type_: str) -> None:
        self.type = type_

    def __missing__(self, reference: int) -> Any:
        raise StepError(
            f"there is no {self.type} variable with value reference {reference}. "
            "Remedy: take references and types from modelDescription.xml of this very FMU"
        )
