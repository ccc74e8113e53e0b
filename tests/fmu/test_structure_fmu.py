"""The structure FMU through FMPy: exact rollback, restart in a new process, free motion against theory."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.linalg import eigh

Fmu = Callable[[str], Path]
Host = Callable[..., Any]


@pytest.fixture(scope="module")
def run_and_rollback(fmu: Fmu, host: Host) -> dict[str, Any]:
    """Forty steps from a saved state, twice, over the release; the state in bytes."""
    return dict(host("rollback", str(fmu("structure"))))


def test_rollback_is_exact_to_the_bit(run_and_rollback: dict[str, Any]) -> None:
    assert run_and_rollback["released"]
    assert run_and_rollback["first"] == run_and_rollback["second"]
    assert run_and_rollback["first"][-1] != run_and_rollback["before"][-1]


def test_restart_in_a_new_process_is_exact_to_the_bit(fmu: Fmu, host: Host, run_and_rollback: dict[str, Any]) -> None:
    assert host("resume", str(fmu("structure")), run_and_rollback["state"]) == run_and_rollback["first"]


def test_damaged_state_is_refused(fmu: Fmu, host: Host, run_and_rollback: dict[str, Any]) -> None:
    seen = host("damaged", str(fmu("structure")), run_and_rollback["state"])
    assert seen["failed"] is True
    assert "damaged" in seen["error"]
    assert seen["h"] == "nan"


def test_free_motion_in_the_fmu_is_that_of_the_modes(fmu: Fmu, host: Host) -> None:
    start = {"initial_h": 0.01, "initial_alpha": -0.02, "initial_h_dot": 0.5, "initial_alpha_dot": 1.0}
    step_size, steps = 2e-3, 100
    rows = np.array(host("free_decay", str(fmu("structure")), start, step_size, steps))
    M = np.array([[57.73, 51.957], [51.957, 50.2251]])
    K = np.diag([57.73, 50.2251]) * 100.0**2
    squares, modes = eigh(K, M)  # modes' M modes = 1
    w = np.sqrt(squares)
    q, rate = (modes.T @ M @ np.array([start[f"initial_h{s}"], start[f"initial_alpha{s}"]]) for s in ("", "_dot"))
    t = step_size * np.arange(steps + 1)[:, None]
    exact = (q * np.cos(w * t) + rate / w * np.sin(w * t)) @ modes.T
    np.testing.assert_allclose(rows, exact, rtol=0.0, atol=1e-12)
