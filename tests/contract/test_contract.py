"""Every case of cases_*.py on each of the five FMUs: calls in any order, bad values, states, many instances."""

from __future__ import annotations

import ast
from collections.abc import Callable
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parent
COMPONENTS = ("structure", "aero", "slosh_vof", "slosh_ems", "slosh_rbf")


def _cases() -> list[tuple[str, str]]:
    """(module, case) of all cases, read without importing: the modules belong to processes of their own."""
    return [
        (path.stem, node.name)
        for path in sorted(HERE.glob("cases_*.py"))
        for node in ast.parse(path.read_text(encoding="utf-8")).body
        if isinstance(node, ast.FunctionDef) and node.name.startswith("case_")
    ]


@pytest.mark.parametrize("component", COMPONENTS)
@pytest.mark.parametrize(("module", "case"), _cases(), ids=lambda text: text.removeprefix("case_").removeprefix("cases_"))
def test_contract(contract: Callable[[str, str, str], str], component: str, module: str, case: str) -> None:
    problem = contract(component, module, case)
    assert not problem, problem
