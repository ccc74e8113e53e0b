"""The S of the transonic boundary: several neutral V_f at one Mach number, found without being told where they are."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

pytestmark = pytest.mark.validation
Run = Callable[..., dict[str, Any]]


def test_every_crossing_at_mach_0_875(aeroslosh: Run) -> None:
    """Onset, recovery, and the onset of the second mode; the paper's diverging point, V_f 1.42, lies in the growing part."""
    [point] = aeroslosh("boundary", "--mach", "0.875", "--method", "both")["points"]
    for c in point["linear"]["crossings"]:
        print(f"\nlinear {c['direction']} {c['V_f']:.4f}, frequency {c['frequency']:.4f}: {c['state']}, {c['text']}", end="")
    for c in point["crossings"]:
        print(f"\nmarched {c['direction']} {c['V_f']:.4f} ± {c['V_f_uncertainty']:.4f}, frequency {c['frequency']:.4f}", end="")
    onset, recovery = point["crossings"][:2]
    assert (onset["direction"], recovery["direction"]) == ("onset", "recovery")
    assert 0.5 < onset["V_f"] < 0.6 and 1.7 < recovery["V_f"] < 2.0
    assert onset["V_f"] < 1.42 < recovery["V_f"]


def test_the_dip_and_the_end_of_flutter(aeroslosh: Run) -> None:
    """The linear model alone: V_f falls to its least between Mach 0.84 and 0.90; at Mach 0.92 nothing flutters below V_f 2.5."""
    points = aeroslosh(
        "boundary", "--mach", "0.7", "0.8", "0.85", "0.92", "--method", "linear", "--set", "boundary.V_f_range=[0.3,2.5]"
    )["points"]
    for p in points:
        print(f"\nMach {p['mach']}: {p['outcome']}", end="")
    values = [p["V_f"] for p in points[:3]]
    assert values[0] > values[1] > values[2] and 0.50 < values[2] < 0.53
    assert not points[3]["crossings"]


@pytest.mark.parametrize(("mach", "V_f"), [("0.6", 1.7092), ("0.825", 0.5906)])
@pytest.mark.parametrize("guess", ["0.2", "0.612", "3.0"])
def test_marches_alone_need_no_prior_knowledge(aeroslosh: Run, mach: str, V_f: float, guess: str) -> None:
    """Half a percent in six marches; V_f as with a linear model (docs/boundary.md)."""
    [point] = aeroslosh("boundary", "--mach", mach, "--method", "march", "--vf", guess)["points"]
    print(f"\nMach {mach} from V_f {guess}: {point['outcome']}", end="")
    assert point["converged"] and point["cost"]["marches"] == len(point["marches"]) <= 6
    assert point["V_f"] == pytest.approx(V_f, rel=5e-3)


@pytest.mark.parametrize("mach", ["0.7", "0.85"])
def test_a_march_or_two_confirm_a_predicted_crossing(aeroslosh: Run, mach: str) -> None:
    [point] = aeroslosh("boundary", "--mach", mach, "--method", "both")["points"]
    print(f"\nMach {mach}: {point['outcome']}", end="")
    assert point["converged"] and point["cost"]["marches"] <= 2 * len(point["crossings"])
