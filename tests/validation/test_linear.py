"""The linear model's neutral V_f against marched ones, at the amplitude of the march. Prints the figures it judges."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

pytestmark = pytest.mark.validation
Run = Callable[..., dict[str, Any]]


@pytest.mark.parametrize(
    ("mach", "amplitude_deg"),
    [(0.5, 1.0), (0.75, 1.0), (0.8, 1.0), (0.8, 0.1), (0.8, 0.02), (0.825, 1.0), (0.825, 0.02), (0.85, 1.0)],
)
def test_linear_neutral_V_f_is_the_marched_one(aeroslosh: Run, mach: float, amplitude_deg: float) -> None:
    """Without a shock the amplitude does not matter; with one the sweep has the march's.

    At Mach 0.825 and 0.1 degrees, where the shock moves by about a cell, they differ by 0.6 percent (docs/boundary.md)."""
    settings = ["boundary.tolerance=0.002", f"flutter.forced_amplitude_deg={amplitude_deg}", "boundary.V_f_range=[0.3,2.2]"]
    words = [word for setting in settings for word in ("--set", setting)]
    [point] = aeroslosh("boundary", "--mach", str(mach), "--method", "both", *words)["points"]
    model = point["linear"]
    [linear] = model["crossings"]
    print(
        f"\nMach {mach}, {amplitude_deg}°: V_f linear {linear['V_f']:.4f} ± {linear['V_f_uncertainty']:.4f}, "
        f"marched {point['V_f']:.4f} ± {point['V_f_uncertainty']:.4f} ({linear['V_f'] / point['V_f'] - 1:+.2%}); "
        f"frequency {linear['frequency']:.4f}, {point['frequency']:.4f}; {len(point['marches'])} marches; "
        f"linear {model['cost']['cpu_seconds']:.1f} s CPU, unseen motion missed by {100 * max(model['check_error']):.2f} %"
    )
    assert linear["state"] == "confirmed"
    assert linear["V_f"] == pytest.approx(point["V_f"], rel=5e-3)
    assert linear["frequency"] == pytest.approx(point["frequency"], rel=5e-3)
    assert len(point["marches"]) <= 4
    assert max(model["check_error"]) < 0.02
