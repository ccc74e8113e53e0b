"""Each figure's module on a reduced size: it computes, draws, tells its conditions, and judges what it computed."""

from __future__ import annotations

import csv
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from aeroslosh.master.paper import combined, fig8, fig10, fig20, fig23, run, tank
from aeroslosh.master.paper.catalogue import FIGURES
from aeroslosh.master.paper.outcome import read
from aeroslosh.master.paper.work import MODELS, Work
from support.once import once


@pytest.fixture(scope="module")
def work(fmu: Callable[[str], Path], tmp_path_factory: pytest.TempPathFactory) -> Work:
    """Reduced size, the product's FMUs, one folder for all figures of this module: they share what they share."""

    def fill(folder: Path) -> None:
        for name in MODELS:
            shutil.copy(fmu(name), folder)

    return Work(tmp_path_factory.mktemp("paper"), once(tmp_path_factory, "paper_fmus", fill), small=True, workers=1)


@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_on_a_reduced_size(work: Work, name: str) -> None:
    row = run.run(work, [name])[0]
    assert not row.cause, row.cause
    found = read(work.out / name)
    assert found is not None and found["claims"] and found["conditions"] and found["verdict"] == row.verdict
    assert (work.out / name / "picture.png").stat().st_size > 10_000
    for file in found["files"][1:]:
        with (work.out / name / file).open(newline="", encoding="utf-8") as stream:
            header, *rows = csv.reader(stream)
        assert rows and {len(row) for row in rows} == {len(header)}


def test_spectra_meet_their_theory() -> None:
    """Figure 8: held and kept levels, within a tenth on average."""
    for hold, keep in ((1, 0.0), (2, 0.0), (2, 0.5)):
        omega, power = fig8.density(fig8.signal(hold, keep, 1000.0)[1])
        inside = slice(2, round(0.8 * len(omega)))
        assert np.mean(power[inside] / fig8.theory(omega, hold, keep)[inside]) == pytest.approx(1.0, abs=0.1)


def test_order_and_index_of_a_made_up_convergence() -> None:
    """Figure 10: values 1 + c h² on meshes of ratio 2 have the order 2 and Roache's index 1.25 times the error."""
    coarse, middle, fine = (1.0 + 0.01 * h**2 for h in (4.0, 2.0, 1.0))
    p = fig10.order(coarse, middle, fine, 2.0)
    assert p == pytest.approx(2.0) and np.isnan(fig10.order(1.0, 2.0, 1.0, 2.0))
    assert fig10.index(middle, fine, 2.0, p) == pytest.approx(1.25 * 0.04 / 1.01, rel=1e-6)
    assert np.isnan(fig10.index(middle, fine, 2.0, float("nan")))


def test_peaks_and_what_is_not_at_the_forcing_frequency() -> None:
    t = np.linspace(0.0, 20 * 2 * np.pi, 20 * 60 + 1)
    both = np.sin(t) + 0.5 * np.sin(3 * t) + 0.01 * np.sin(5 * t)
    loads = tank.Loads(t, both, both, both, both, t >= 4 * np.pi - 1e-9)
    at, size = tank.spectrum(loads, both, 1.0)
    assert tank.peaks(size) == 2  # the third is below a tenth
    assert tank.beyond_first(at, size) == pytest.approx(0.5 / np.sqrt(1.25), rel=1e-3)
    at, size = tank.spectrum(loads, np.sin(t), 1.0)
    assert tank.peaks(size) == 1 and tank.beyond_first(at, size) < 1e-6


def test_departure_from_a_line() -> None:
    assert fig23.departure([1.0, 2.0, 3.0], [2.0, 4.0, 6.0]) == pytest.approx(0.0, abs=1e-10)
    assert fig23.departure([1.0, 2.0], [1.0, 1.0]) == pytest.approx(100.0 * (1.0 / 0.6 - 1.0))


def test_spikes_are_found_where_they_are() -> None:
    omega = np.linspace(0.5, 20.0, 2000)
    natural = np.array([5.0, 12.0])
    force = sum(1.0 / (0.01 + np.abs(omega - w)) for w in (5.2, 12.0))
    assert fig20.spikes(omega, np.asarray(force), natural) == pytest.approx([5.2, 12.0], abs=0.02)


def test_slow_tilt_gives_the_weight_along_the_walls(work: Work) -> None:
    """A surface that stays level: the force along the tank is m g sin(alpha), the vertical one hardly changes."""
    loads = tank.driven(work, "slosh_ems", 0.3, 4, alpha=0.01)
    box = tank.tank(work)
    assert tank.amplitude(loads.lateral[loads.settled]) == pytest.approx(box.mass * box.gravity * 0.01, rel=0.02)
    assert tank.amplitude(loads.aft[loads.settled]) < 0.05 * box.mass * box.gravity * 0.01
    assert len(combined.LOADS) == 3
