"""Work a cycle that the preset's tank takes out of a pitch of one degree at 41 rad/s: small ensembles on two meshes."""

from __future__ import annotations

import numpy as np
import pytest

from studies.slosh_work import work_a_cycle

pytestmark = pytest.mark.validation


@pytest.mark.parametrize("cells", [(50, 16), (100, 30)])
def test_work_a_cycle(cells: tuple[int, int]) -> None:
    """57 J/m with an eighth to spare; single cycles scatter by a sixth."""
    members = np.array([work_a_cycle(*cells, 20, seed) for seed in (1, 2)])
    scatter = float(members.std(axis=1, ddof=1).mean())
    runs = np.round(members.mean(axis=1), 1)
    print(f"{cells[0]}x{cells[1]}: {members.mean():.1f} J/m a cycle, runs {runs}, single cycles sd {scatter:.1f}")
    assert members.mean() == pytest.approx(57.0, rel=0.125)
    assert 5.0 < scatter < 13.0
    assert np.abs(members[0] - members[1]).max() > 1.0  # a spectrum of a hundredth of a millimetre makes another run


def test_a_gas_cushion_leaves_the_work() -> None:
    """Air at sea level against air that cannot be compressed: no more apart than two small ensembles are."""
    rigid, air = (np.array([work_a_cycle(50, 16, 25, seed, p).mean() for seed in range(1, 9)]) for p in (0.0, 101325.0))
    error = float(np.hypot(rigid.std(ddof=1), air.std(ddof=1)) / np.sqrt(8))
    print(f"{rigid.mean():.1f} J/m, with air at sea level {air.mean():.1f}; standard error of the difference {error:.1f}")
    assert 0.5 < error < 3.0
    assert abs(air.mean() - rigid.mean()) < 3.0 * error
