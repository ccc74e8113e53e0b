"""The shipped violent branch against the two-phase solver: records that it has not seen, and flutter marches."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import aeroslosh as ae
from aeroslosh.fmus.slosh_rbf import violent_network
from aeroslosh.fmus.slosh_rbf.training import dataset, violent_fit, violent_plan, violent_study
from aeroslosh.fmus.tank.liquid import Tank
from aeroslosh.master.training.tank_records import Drive
from studies.violent_boundary import slope
from support.paths import ROOT
from support.processes import command

pytestmark = pytest.mark.validation
BRANCH = violent_network.load(ROOT / "fmus" / "slosh_rbf" / "weights" / "branches" / "default.npz")


@pytest.fixture(scope="module")
def tests(tmp_path_factory: pytest.TempPathFactory) -> list[violent_fit.Table]:
    """The test records of the violent plan on 100 x 30 cells, without their twins."""
    drive = Drive.of(ROOT / "dist" / "fmus" / "slosh_vof.fmu")
    fluids = {"liquid_viscosity": 1e-6, "gas_viscosity": 1.48e-5}
    planned = [
        p
        for p in violent_plan.violent(Tank(0.5, 0.15), violent_plan.Sizes(0, 0, 0, 40), more=fluids)
        if not p.motion.name.endswith(violent_study.TWIN)
    ]
    folder = tmp_path_factory.mktemp("violent")
    paths = dataset.generate(planned, folder, drive, drive.model, 2)
    return violent_study.tables([dataset.read(path) for path in paths])["test"]


def test_loss_factors_on_records_never_seen(tests: list[violent_fit.Table]) -> None:
    """Asked: rms 0.035, bias 0.005 over all cycles of 1 g and more; fills 0.4, 0.6 and 0.35 are in no training record."""
    found = violent_fit.measure(tests, [violent_fit.predict(BRANCH.weights, t) for t in tests])
    assert found["cycles"] > 200
    assert found["loss_rms"] <= 0.035 and abs(found["loss_bias"]) <= 0.005
    assert found["R2"] > 0.65


def test_the_deviation_told_is_that_found(tests: list[violent_fit.Table]) -> None:
    """Rms of what single runs leave over the deviation that the branch tells: 1 within a quarter."""
    left, told = 0.0, 0.0
    for t in tests:
        whole = t.share > 0.5
        sigma = t.share * t.Q * (violent_fit.gaussians(BRANCH.weights, t.space) @ BRANCH.weights.noise)
        left += float((((t.r - violent_fit.predict(BRANCH.weights, t)) / t.Q)[whole] ** 2).sum())
        told += float(((sigma / t.Q)[whole] ** 2).sum())
    assert np.sqrt(left / told) == pytest.approx(1.0, abs=0.25)


def march(model: str, amplitude: float, out: Path, mach: float = 0.8, V_f: float = 0.75) -> dict[str, object]:
    """A point of preset S with its mean growth rate."""
    words = ["point", "cases/paper_s.toml", "--slosh", model, "--mach", mach, "--vf", V_f, "--json", "--quiet", "--no-pictures"]
    done = command(*words, "--out", out, "--set", f"flutter.forced_amplitude_deg={amplitude}")
    assert done.returncode in (0, 4), done.stderr
    point = ae.open(out)
    assert isinstance(point, ae.Point)
    return {**json.loads(done.stdout), "mean": slope(point)}


@pytest.mark.parametrize(("amplitude", "limit"), [(0.2, 2e-5), (0.5, 2e-3), (1.0, 2e-3), (2.0, 2e-3), (3.0, 2e-3)])
def test_mean_growth_over_amplitude(amplitude: float, limit: float, tmp_path: Path) -> None:
    """Mach 0.80, V_f 0.75, five free cycles. Single marches of the flow scatter by 0.0003 to 0.0016."""
    rbf, vof = (march(model, amplitude, tmp_path / model) for model in ("rbf", "vof"))
    assert rbf["mean"] == pytest.approx(vof["mean"], abs=limit)
    if amplitude >= 0.5:
        assert 1.0 < rbf["slosh_validity"] <= 2.0 and rbf["slosh_holds"] and rbf["verdict"] != "undetermined"
