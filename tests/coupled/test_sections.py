"""Everyone's section: random ones on the thin-airfoil double, whose eigenvalues are known exactly. No verdict may be wrong.

A few of them; two thousand, and every neutral V_f of two hundred, in `make validate`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from aeroslosh.master.flutter.setup import find_fmus
from support import sections

POINTS, BOUNDARIES, MANY = 40, 8, 2000


@pytest.fixture(scope="module")
def fmus(flutter_fmus: Path) -> dict[str, Path]:
    return find_fmus(flutter_fmus)


def test_no_verdict_is_wrong(fmus: dict[str, Path]) -> None:
    said = [sections.point(fmus, seed) for seed in range(POINTS)]
    assert [s for s in said if s.wrong] == []
    assert sum(s.verdict == "undetermined" for s in said) <= 0.02 * POINTS


def test_every_crossing_is_found_and_no_other(fmus: dict[str, Path]) -> None:
    said = [sections.boundary(fmus, seed) for seed in range(BOUNDARIES)]
    assert [s for s in said if s.missed or s.invented] == []
    assert all(s.worst < 0.005 for s in said)
    assert all(s.marches <= 3 * max(1, s.marched) for s in said), said


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        # axis, x_alpha, r2, frequency ratio, mass ratio → the lowest neutral V_f's name
        ((0.35, 0.25, 0.75, 1.0, 75.0), "onset"),
        ((0.2, 0.25, 0.75, 1.0, 75.0), "onset"),
        ((0.35, 0.1, 0.25, 0.9, 40.0), "onset"),
        ((0.4, -0.1, 0.25, 0.5, 20.0), "divergence"),
        ((0.3, 0.05, 0.25, 0.8, 40.0), "onset"),
        ((0.5, 0.0, 1.04, 0.646, 700.0), "onset"),
    ],
)
def test_sections_that_once_had_no_boundary(fmus: dict[str, Path], changes: tuple[float, ...], expected: str) -> None:
    case = sections.named(*changes)
    said = sections.bounded(fmus, case)
    assert not said.missed and not said.invented and said.worst < 0.005
    assert said.names[0] == expected


@pytest.mark.validation
def test_verdicts_of_two_thousand_sections(fmus: dict[str, Path]) -> None:
    said = [sections.point(fmus, seed) for seed in range(MANY)]
    wrong = [s for s in said if s.wrong]
    undetermined = [s for s in said if s.verdict == "undetermined"]
    errors = np.abs([s.error for s in said if np.isfinite(s.error) and s.verdict == s.exact and s.exact != "divergence"])
    print(f"{len(wrong)} wrong, {len(undetermined)} undetermined of {MANY}; growth rate off by {np.median(errors):.1e} (median)")
    assert wrong == []
    assert len(undetermined) <= 0.02 * MANY


@pytest.mark.validation
def test_every_crossing_of_two_hundred_sections(fmus: dict[str, Path]) -> None:
    said = [sections.boundary(fmus, seed) for seed in range(MANY // 10)]
    crossings, marches = sum(s.marched for s in said), sum(s.marches for s in said)
    print(f"{crossings} crossings marched with {marches} marches, worst V_f {max(s.worst for s in said):.2%} off")
    assert [s for s in said if s.missed or s.invented] == []
