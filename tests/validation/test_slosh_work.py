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
