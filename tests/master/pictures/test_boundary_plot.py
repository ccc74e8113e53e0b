"""Crossings joined over Mach for the picture."""

from __future__ import annotations

from aeroslosh.master.linear.model import LinearCrossing
from aeroslosh.master.pictures.boundary import branches


def crossing(V_f: float, frequency: float, direction: str = "onset") -> LinearCrossing:
    return LinearCrossing(V_f, frequency, direction, 1.0, 0, 0.1)


def test_branches_join_like_with_like() -> None:
    """An onset over three Mach numbers; a recovery and a second mode's onset that appear at the second."""
    rows = [
        (0.80, [crossing(0.8, 0.97)]),
        (0.85, [crossing(0.6, 0.85), crossing(2.2, 2.0, "recovery"), crossing(2.3, 4.5)]),
        (0.88, [crossing(0.55, 0.82), crossing(1.8, 1.6, "recovery"), crossing(2.4, 4.6)]),
    ]
    found = sorted(branches(rows), key=lambda b: b[0][1].V_f)
    assert [[m for m, _ in b] for b in found] == [[0.80, 0.85, 0.88], [0.85, 0.88], [0.85, 0.88]]
    assert all(len({c.direction for _, c in b}) == 1 for b in found)


def test_a_gap_ends_a_branch() -> None:
    found = branches([(0.8, [crossing(0.8, 1.0)]), (0.85, []), (0.9, [crossing(0.8, 1.0)])])
    assert [len(b) for b in found] == [1, 1]
