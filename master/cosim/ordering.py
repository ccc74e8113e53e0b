"""The order of components in a Gauss–Seidel pass that leaves the fewest wires to predict."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from ..base.errors import AeroSloshError

EXACT = 7  # components up to which every order is tried


def derive(names: Sequence[str], links: Sequence[tuple[str, str]]) -> list[str]:
    """An order of `names` in which the fewest `links` (source, target; one a wire) go backwards.

    Every order is tried for up to 7 components; beyond that the heuristic of Eades, Lin and Smyth (Inf. Process. Lett. 47,
    1993, doi 10.1016/0020-0190(93)90079-O). Of equally good orders the one nearest to `names`."""
    links = [(a, b) for a, b in links if a != b]
    if len(names) > EXACT:
        return _greedy(list(names), links)
    best = min(itertools.permutations(names), key=lambda order: lagged(order, links))  # the first of the best: as given
    return list(best)


def lagged(order: Sequence[str], links: Sequence[tuple[str, str]]) -> int:
    """How many links go backwards."""
    place = {name: i for i, name in enumerate(order)}
    return sum(place[a] > place[b] for a, b in links)


def arrange(names: Sequence[str], links: Sequence[tuple[str, str]], given: Sequence[str]) -> list[str]:
    """`given` where it is an order of all `names`, the derived one where it is empty. Raises AeroSloshError."""
    if not given:
        return derive(names, links)
    if sorted(given) != sorted(names):
        raise AeroSloshError(
            f"coupling.order = {list(given)} is no order of the components",
            "coupling.order",
            f"name each once: {', '.join(names)}; or leave it out, then the fewest wires lag",
        )
    return list(given)


def _greedy(names: list[str], links: list[tuple[str, str]]) -> list[str]:
    front: list[str] = []
    back: list[str] = []
    left = list(names)
    while left:
        inside = [(a, b) for a, b in links if a in left and b in left]
        sink = next((n for n in reversed(left) if all(a != n for a, _ in inside)), None)
        source = next((n for n in left if all(b != n for _, b in inside)), None)
        if source is not None:
            front.append(source)
            left.remove(source)
        elif sink is not None:
            back.insert(0, sink)
            left.remove(sink)
        else:  # in a circle: where most goes out and least comes in
            chosen = max(left, key=lambda n: sum(a == n for a, _ in inside) - sum(b == n for _, b in inside))
            front.append(chosen)
            left.remove(chosen)
    return front + back
