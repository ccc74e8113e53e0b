"""`ae.amplitude` and `aeroslosh amplitude` on the thin-airfoil double, which is linear: its eigenvalues, no limit cycle."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import aeroslosh as ae
from aeroslosh.master import cli
from aeroslosh.master.analysis.envelopes import Envelope
from aeroslosh.master.api import amplitude
from aeroslosh.master.base.errors import AeroSloshError, ExitCode
from aeroslosh.master.case.case import Case
from support import theory

MACH = 0.3


def test_rates_are_those_of_the_eigenvalues(flutter_fmus: Path, tmp_path: Path) -> None:
    found = ae.amplitude(
        ae.Case.isogai_a(),
        mach=MACH,
        V_f=[0.6, 2.4],
        starts_deg=[0.1, 1.0],
        free_cycles=8,
        fmus=flutter_fmus,
        folder=tmp_path / "a",
    )
    for row in found.data["speeds"]:
        truth = theory.eigenvalues(Case(), MACH, row["V_f"])[0].real
        rates = np.array([p["growth_rate"] for p in row["curve"]])
        assert row["cycles"] == [] and np.all(np.sign(rates) == np.sign(truth))
        assert rates[-1] == pytest.approx(truth, abs=max(2e-3, 0.1 * abs(truth)))
    again = ae.open(tmp_path / "a")
    assert isinstance(again, amplitude.Amplitude) and repr(again) == repr(found) and again.data["speeds"] == found.data["speeds"]
    assert (tmp_path / "a" / "amplitude.png").is_file() and "decay" in repr(found) and "grow" in repr(found)


def test_command(flutter_fmus: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = [
        "amplitude",
        "isogai_a",
        "--mach",
        str(MACH),
        "--vf",
        "0.6",
        "--from",
        "1",
        "--cycles",
        "8",
        "--json",
        "--no-pictures",
    ]
    assert cli.run([*words, "--out", str(tmp_path / "run"), "--fmus", str(flutter_fmus)]) == ExitCode.OK
    data = json.loads(capsys.readouterr().out)
    assert data["speeds"][0]["V_f"] == 0.6 and data["speeds"][0]["curve"]
    assert json.loads((tmp_path / "run" / "result.json").read_text())["speeds"] == data["speeds"]


def test_marches_too_short_to_read_give_no_verdict(
    flutter_fmus: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["amplitude", "isogai_a", "--mach", str(MACH), "--vf", "0.6", "--from", "1", "--cycles", "2", "--no-pictures"]
    assert cli.run([*words, "--out", str(tmp_path / "run"), "--fmus", str(flutter_fmus)]) == ExitCode.UNDETERMINED
    assert "more free cycles" in capsys.readouterr().out


def test_starts_that_cannot_be_are_refused() -> None:
    with pytest.raises(AeroSloshError, match="starts_deg"):
        ae.amplitude("isogai_a", mach=MACH, V_f=0.6, starts_deg=[-1.0])


@pytest.mark.parametrize(
    ("last", "rate", "comes"), [(2.0, 0.01, True), (2.0, -0.01, False), (8.0, -0.01, True), (8.0, 0.01, False), (5.1, 0.01, True)]
)
def test_a_motion_comes_to_a_cycle_from_either_side(last: float, rate: float, comes: bool) -> None:
    motion = Envelope(np.array([3.0, last]), np.array([rate, rate]))
    assert amplitude._comes(motion, 5.0) is comes
