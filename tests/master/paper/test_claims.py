"""The verdict of a figure, on made-up numbers that agree and that differ."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aeroslosh.fmus.tank.liquid import Tank
from aeroslosh.fmus.tank.modes import modes
from aeroslosh.master.paper import (
    fig8,
    fig10,
    fig11,
    fig12,
    fig13,
    fig14,
    fig15,
    fig16,
    fig17,
    fig18,
    fig19,
    fig20,
    fig21,
    fig22,
    fig23,
    fig24,
    fig25,
    listed,
    table1,
)
from aeroslosh.master.paper.boundaries import Onset
from aeroslosh.master.paper.claims import Claim, at_least, at_most, between, verdict, within, word
from aeroslosh.master.paper.combined import Answer
from aeroslosh.master.paper.fig12 import Crossing
from aeroslosh.master.paper.replay import Replay


def test_a_claim_agrees_up_to_its_tolerance_and_not_beyond() -> None:
    assert within("x", "", 1.0, 1.1, 0.11).agrees and not within("x", "", 1.0, 1.12, 0.11).agrees
    assert between("x", "", 1.0, 2.0, 2.0).agrees and not between("x", "", 1.0, 2.0, 2.1).agrees
    assert at_most("x", "", 1.0, 1.0).agrees and not at_most("x", "", 1.0, 1.01).agrees
    assert at_least("x", "", 1.0, 1.0).agrees and not at_least("x", "", 1.0, 0.99).agrees
    assert word("x", "", "damped", "damped").agrees and not word("x", "", "damped", "flutter").agrees
    assert word("x", "", "going into flutter", "limit cycle", ("flutter", "limit cycle")).agrees


def test_what_is_not_a_number_agrees_with_nothing() -> None:
    nan = math.nan
    claims = [
        within("x", "", 1.0, nan, 9.0),
        between("x", "", 0.0, 2.0, nan),
        at_most("x", "", 9.0, nan),
        at_least("x", "", 0.0, nan),
    ]
    assert not any(c.agrees for c in claims)


def test_the_verdict_names_every_claim_that_differs_and_why() -> None:
    good, bad = Claim("lift", "s", "1", "1", True, "unused"), Claim("drag", "s", "2", "3", False, "another mesh")
    assert verdict([good]) == "agrees"
    assert verdict([good, bad]) == "differs: drag: 3, paper 2 (another mesh)"
    with pytest.raises(ValueError, match="no claim"):
        verdict([])


def onset(V_f: float, doubt: float = 0.001, mach: float = 0.8) -> dict[float, Onset]:
    """A boundary of one Mach number."""
    return {mach: Onset("x", mach, V_f, doubt, 0.9, math.nan, 2, 1.0)}


def shown(verdict_: str) -> Replay:
    """A march of that verdict."""
    return Replay(np.zeros(1), np.zeros((1, 6)), [], verdict_, "", 2.0, -0.5)


def few(lateral: float, peaks: int = 1) -> dict[str, Answer]:
    """Answers of the three loads."""
    return {"vertical": Answer(1, 0.0), "lateral": Answer(peaks, lateral), "moment": Answer(1, 0.0)}


GOOD_SPECTRA = {"white": 0.4, "p0": 0.2, "p0.25": 0.19, "p0.5": 0.1, "p0.75": 0.05}
PAPERS = [
    Crossing(0.80, "onset", 0.81, 0.0, 1.0), Crossing(0.825, "onset", 0.60, 0.0, 1.0), Crossing(0.85, "onset", 0.51, 0.0, 1.0),
    Crossing(0.875, "onset", 0.55, 0.0, 1.0), Crossing(0.875, "recovery", 1.9, 0.0, 1.0), Crossing(0.875, "onset", 2.5, 0.0, 1.0),
]  # fmt: skip


def delays(at_five: float, at_three: float) -> list[fig13.Row]:
    """A curve over the input delay with its least error at 5 or at 3."""
    return [fig13.Row(fig13.SHOWN[0], "rbf", "one step", i, 3, e, e) for i, e in ((3, at_three), (5, at_five))]


@pytest.mark.parametrize(
    ("agreeing", "differing"),
    [
        (fig8.judged(GOOD_SPECTRA), fig8.judged(GOOD_SPECTRA | {"p0": 0.5})),
        ([fig10.judged(0.0015)], [fig10.judged(0.0019)]),
        ([fig11.judged(fig11.PANELS[0], -7.0, 0.9)], [fig11.judged(fig11.PANELS[0], 11.0, 1.1)]),
        ([fig11.judged(fig11.PANELS[1], -50.0, 0.5)], [fig11.judged(fig11.PANELS[1], 50.0, 1.5)]),
        ([fig11.judged(fig11.PANELS[2], 50.0, 1.5)], [fig11.judged(fig11.PANELS[2], math.nan, 0.5)]),
        (fig12.judged(PAPERS), fig12.judged([Crossing(0.80, "onset", 0.9, 0.0, 1.0)])),
        (fig12.judged(PAPERS), fig12.judged([*PAPERS[:4], Crossing(0.875, "recovery", 1.3, 0.0, 1.0)])),
        ([fig13.judged(delays(1.0, 1.2), 0)], [fig13.judged(delays(1.2, 1.0), 0)]),
        ([fig14.judged([fig14.Row(fig14.SHOWN[0], "rbf", "one step", 7.9, 0.0)])],
         [fig14.judged([fig14.Row(fig14.SHOWN[0], "rbf", "one step", 8.1, 0.0)])]),
        ([fig15.judged(shown("flutter"))], [fig15.judged(shown("damped"))]),
        (fig16.judged([("a", "", 0, 0.5, 0.0, 0.0), ("b", "", 0, 0.5, 0.3, 0.1)]),
         fig16.judged([("a", "", 0, 0.5, 0.0, 0.0), ("b", "", 0, 0.5, 0.01, 0.1)])),
        (fig17.judged(onset(0.81), onset(0.90), onset(0.91)), fig17.judged(onset(0.81), onset(0.80), onset(0.81))),
        (fig17.judged(onset(0.81), onset(0.90), onset(0.91)), fig17.judged(onset(0.81), onset(0.90), onset(0.95))),
        ([fig19.judged({"slow sway": 1.10}, {"slow sway": 0.99})[1]], fig19.judged({"slow sway": 0.61}, {"slow sway": 0.99})),
        ([fig20.judged(1, 5.2, 5.21, 0.01)], [fig20.judged(1, 5.2, 5.3, 0.01)]),
        (fig21.judged(onset(0.75), onset(0.90)), fig21.judged(onset(0.899), onset(0.90))),
        ([fig22.judged(0.6)], [fig22.judged(0.4)]),
        ([fig23.judged(9.0)], [fig23.judged(11.0)]),
        ([fig24.judged({"(d)": few(0.1, 2)})], [fig24.judged({"(d)": few(0.1, 3)})]),
        (fig25.judged({"(a)": few(0.1), "(b)": few(0.2, 4)}), fig25.judged({"(a)": few(0.3), "(b)": few(0.2, 4)})),
        (listed.judged(0.8, "damped"), listed.judged(0.4, "flutter")),
        ([table1.judged(table1.saved(table1.PAPER) + 0.01)], [table1.judged(90.0)]),
    ],
)  # fmt: skip
def test_every_figure_tells_what_agrees_from_what_differs(agreeing: list[Claim], differing: list[Claim]) -> None:
    assert verdict(agreeing) == "agrees"
    assert verdict(differing).startswith("differs: ")


def test_equations_as_they_should_be_agree_and_as_printed_differ() -> None:
    """Fig. 18: the printed masses and springs are replaced by the right ones, which the same claims then take."""
    box = Tank(0.5, 0.15)
    m = modes(box, 8)
    assert verdict(fig18.judged(m, box, m.mass / box.mass, m.stiffness / box.mass)) == "agrees"
    n = m.omega * 0 + range(1, 9)
    found = fig18.judged(m, box, fig18.printed_mass(box, n), fig18.printed_spring(box, n))
    assert [c.agrees for c in found] == [True, True, False, False]


def test_the_papers_own_savings_and_break_even() -> None:
    """Table 1: 94.98 % is what it prints; training pays after 924 steps by its figures."""
    assert table1.saved(table1.PAPER) == pytest.approx(94.98, abs=0.015)
    assert round(table1.pays(table1.PAPER)) == 924
