"""A network with output feedback in a tank: the same loads as its free run, its own step alone, in a file and in an FMU."""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import numpy as np
import pytest

from aeroslosh.fmus.slosh_rbf import feedback
from aeroslosh.fmus.slosh_rbf.body import from_load
from aeroslosh.fmus.slosh_rbf.feedback import Feedback, columns, free_run
from aeroslosh.fmus.slosh_rbf.feedback_tank import FeedbackSurrogate, in_tank, read
from aeroslosh.fmus.slosh_rbf.network import NetworkError, untrained
from aeroslosh.fmus.slosh_rbf.surrogate import Record, Surrogate, inputs, tabulate
from aeroslosh.fmus.slosh_rbf.training.feedback_fit import fit
from aeroslosh.fmus.tank.liquid import Tank

TANK = Tank(0.5, 0.15)
STEP = 2e-3
UNIT = STEP / math.sqrt(0.5 / 9.81)


def swing(n: int, omega: float) -> np.ndarray:
    """Plunge and pitch from rest, shape (n, 9)."""
    t, out = STEP * np.arange(n), np.zeros((n, 9))
    for column, size, w in ((0, 1e-3, omega), (3, 5e-3, 0.7 * omega)):
        out[:, column] = size * (1.0 - np.cos(w * t))
        out[:, column + 1] = size * w * np.sin(w * t)
        out[:, column + 2] = size * w**2 * np.cos(w * t)
    return out


@pytest.fixture(scope="module", params=["motion", "drive"])
def net(request: pytest.FixtureRequest) -> Feedback:
    """Gaussians taught by the bilinear equations on one swing."""
    base = Surrogate(untrained("bilinear", True), TANK, 1e-6, 1.2)
    motions = swing(600, 50.0)
    whole = tabulate(base, Record(STEP, motions, base.run(motions, STEP))).whole
    u = columns(request.param, inputs(base, motions), motions, 0.5)
    return fit("taught", request.param, (5, 3), UNIT, [(u, whole)], 0.15, 0.3, 30, ridge=1e-6)


def test_step_by_step_is_the_free_run(net: Feedback) -> None:
    """Each load follows from the motions and loads before it as the network says (1e-9: sums in another order)."""
    surrogate = FeedbackSurrogate(net, TANK, 1e-6, 1.2)
    motions = swing(300, 60.0)
    state = surrogate.start(motions[0])
    loads = [state.answer[:3]]
    for a, b in itertools.pairwise(motions):
        state = surrogate.advance(state, a, b, STEP)
        loads.append(state.answer[:3])
    found = np.array(loads)
    own = from_load(found[:, 0], found[:, 1], found[:, 2], TANK, motions[:, 3])
    u = columns(net.inputs, inputs(surrogate.base, motions), motions, 0.5)
    # the input stood at u[0] before: the same as a free run whose first samples are what the delays hold
    X = np.array([np.concatenate([u[k - np.arange(6)].ravel(), own[k - 1 - np.arange(3)].ravel()]) for k in range(6, 300)])
    assert own[6:] == pytest.approx(feedback.one_step(net, X), rel=1e-9, abs=1e-9)
    assert state.answer.extrapolation > 0.0 and len(state.lags) == 5 * u.shape[1] + 9


def test_another_step_and_another_tank_are_refused(net: Feedback) -> None:
    surrogate = FeedbackSurrogate(net, TANK, 1e-6, 1.2)
    motions = swing(2, 50.0)
    with pytest.raises(NetworkError, match=r"steps of 0\.002 s alone"):
        surrogate.advance(surrogate.start(motions[0]), motions[0], motions[1], 1e-3)
    with pytest.raises(NetworkError, match="depth/length"):
        FeedbackSurrogate(net, Tank(0.5, 0.15, 1.0, 0.3), 1e-6, 1.2)


def test_in_a_file(net: Feedback, tmp_path: Path) -> None:
    feedback.save(net, tmp_path / "net.npz")
    again = read(tmp_path / "net.npz")
    assert isinstance(again, Feedback) and isinstance(in_tank(again, TANK, 1e-6, 1.2), FeedbackSurrogate)
    u = np.zeros((50, 2 if net.inputs == "motion" else 4))
    assert (free_run(again, u, np.zeros(3)) == free_run(net, u, np.zeros(3))).all()
    (tmp_path / "bad.npz").write_bytes(b"no")
    with pytest.raises(NetworkError):
        read(tmp_path / "bad.npz")


def test_the_shipped_networks_are_read() -> None:
    folder = Path(feedback.__file__).parent / "weights"
    names = {p.stem for p in folder.glob("*.npz") if read(p)}
    assert {"default", "quadratic"} <= names
