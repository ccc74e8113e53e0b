"""The order of components that leaves the fewest wires to predict, against every order tried."""

from __future__ import annotations

import itertools
import random

import pytest

from aeroslosh.master.base.errors import AeroSloshError
from aeroslosh.master.cosim import ordering

Links = list[tuple[str, str]]


def fewest(names: list[str], links: Links) -> int:
    """The fewest links that go backwards, over all orders: by the best order of every subset (Held and Karp's way)."""
    place = {name: i for i, name in enumerate(names)}
    pairs = [(place[a], place[b]) for a, b in links if a != b]
    best = [0] + [len(pairs)] * (2 ** len(names) - 1)
    for subset in range(1, 2 ** len(names)):
        for last in (i for i in range(len(names)) if subset >> i & 1):
            before = subset & ~(1 << last)
            late = sum(a == last and before >> b & 1 for a, b in pairs)  # `last` feeds one that is stepped before it
            best[subset] = min(best[subset], best[before] + late)
    return best[-1]


def drawn(n: int, wires: int, seed: int) -> tuple[list[str], Links]:
    """A random system of n components."""
    dice = random.Random(seed)
    names = [f"c{i}" for i in range(n)]
    return names, [(dice.choice(names), dice.choice(names)) for _ in range(wires)]


def test_a_chain_given_backwards() -> None:
    assert ordering.derive(["c", "b", "a"], [("a", "b"), ("b", "c")]) == ["a", "b", "c"]


def test_what_fits_stays_as_given() -> None:
    """No wires, a ring (any of its rotations lags once) and a wire of a component to itself change nothing."""
    names = ["x", "y", "z"]
    for links in ([], [("x", "y"), ("y", "z"), ("z", "x")], [("y", "y"), ("x", "z")]):
        assert ordering.derive(names, links) == names
    assert ordering.derive(["a"], []) == ["a"] and ordering.derive([], []) == []


def test_the_lighter_side_of_a_loop_lags() -> None:
    """Three wires one way, one back: the one lags, whatever the order in the file."""
    links = [("b", "a")] * 3 + [("a", "b")]
    assert ordering.derive(["a", "b"], links) == ["b", "a"]
    assert ordering.lagged(["b", "a"], links) == 1 and ordering.lagged(["a", "b"], links) == 3


@pytest.mark.parametrize("names", list(itertools.permutations(["structure", "aero", "slosh"])))
def test_the_flutter_rig(names: tuple[str, ...]) -> None:
    """Six motions to each fluid, two loads back: structure first, the four loads lag; the fluids in the order given."""
    motion = [("structure", fluid) for fluid in ("aero", "slosh") for _ in range(6)]
    loads = [(fluid, "structure") for fluid in ("aero", "slosh") for _ in range(2)]
    found = ordering.derive(names, motion + loads)
    assert found == ["structure", *(n for n in names if n != "structure")]
    assert ordering.lagged(found, motion + loads) == 4


@pytest.mark.parametrize("n", [2, 3, 4, 5, 6, 7])
@pytest.mark.parametrize("seed", range(4))
def test_up_to_seven_components_none_is_better(n: int, seed: int) -> None:
    names, links = drawn(n, 3 * n, seed)
    found = ordering.derive(names, links)
    assert sorted(found) == sorted(names)
    assert ordering.lagged(found, links) == fewest(names, links)


@pytest.mark.parametrize("seed", range(20))
def test_beyond_seven_components(seed: int) -> None:
    """9 components: no more than half of the wires less a sixth of the components (the heuristic's bound for pairs wired one
    way), and close to the best order: one wire in five away at most, in these systems."""
    names, links = drawn(9, 18, seed)
    links = [(a, b) for a, b in links if a != b and (b, a) not in links]
    found = ordering.derive(names, links)
    assert sorted(found) == sorted(names)
    assert fewest(names, links) <= ordering.lagged(found, links) <= fewest(names, links) + len(links) // 5
    simple = list(dict.fromkeys(links))
    assert ordering.lagged(ordering.derive(names, simple), simple) <= len(simple) / 2 - len(names) / 6


@pytest.mark.parametrize("seed", range(10))
def test_nine_without_a_loop_lag_nowhere(seed: int) -> None:
    names, links = drawn(9, 25, seed)
    forward = [(min(a, b), max(a, b)) for a, b in links if a != b]
    random.Random(seed).shuffle(names)
    assert ordering.lagged(ordering.derive(names, forward), forward) == 0


def test_a_given_order_is_taken() -> None:
    assert ordering.arrange(["a", "b"], [("a", "b")], ["b", "a"]) == ["b", "a"]
    assert ordering.arrange(["b", "a"], [("a", "b")], []) == ["a", "b"]


@pytest.mark.parametrize("given", [["a"], ["a", "a"], ["a", "b", "c"], ["a", "B"]])
def test_a_wrong_order_is_refused(given: list[str]) -> None:
    with pytest.raises(AeroSloshError) as caught:
        ordering.arrange(["a", "b"], [], given)
    assert "is no order of the components" in caught.value.what and "name each once: a, b" in caught.value.remedy
