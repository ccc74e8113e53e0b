"""The trailing edge of a section from a file: where its sides end, and how a blunt base is closed.

A base may be written in many ways: open (two corners), closed by repeating a corner, begun in its middle, pinched to one
point, with a corner missing. All mean the same two corners. They are found from the two sides alone: a segment that turns away
from its side by more than 30 degrees is base; a last point that lies off the parabola through the points ahead of it belongs
to the base, or to the other side; a side that ends short of the trailing edge is carried on along that parabola.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .airfoil_order import Loop
from .airfoil_text import refuse

Array = NDArray[np.float64]

MAX_BASE = 0.02
"""Thickest base [chords] that is closed: above it the section is another section."""
_TURN = np.radians(30.0)
_NEAR = 0.9
"""The base is sought behind this x/c."""
_CURVED = 0.004
"""Least distance [chords] of the points that a parabola is laid through: closer ones carry the rounding of the file."""
UP, DOWN = np.array([1.0, 1.0]), np.array([1.0, -1.0])
_CLOSE = 0.03
"""Last points farther apart than this [chords] do not tell a base from a curved side."""
_DOUBT = 4e-4
"""A last point that the file calls the trailing edge is believed unless it lies this far [chords] off its side."""
_ROUND = 0.003
"""A base that is rounded begins no farther from the trailing edge than this [chords]."""
_SEEN = 2e-4
"""A base thinner than this [chords] is not worth a word."""


@dataclass(frozen=True)
class Sides:
    """The two sides, each of shape (n, 2) from the nose to x = 1, in chords; base: thickness there; said: how they were found."""

    upper: Array
    lower: Array
    base: float
    said: str


def sides(loop: Loop, path: Path) -> Sides:
    """The sides of a loop. Raises AirfoilError where it cannot be told how they end."""
    points = loop.points
    tail = int(np.argmax(points[:, 0]))
    points = np.roll(points, -tail, axis=0)
    nose = int(np.argmin(points[:, 0]))
    whole = points[nose::-1], np.vstack([points[nose:], points[:1]])  # both from the nose to the same last point
    if min(len(side) for side in whole) < 7:
        refuse(path, f"{min(len(side) for side in whole)} points on one side", "7 or more a side, 30 to 100 for good accuracy")
    bare = [_without_base(side) for side in whole]
    given = float(bare[0][-1, 1] - bare[1][-1, 1])
    corners = given > 0 and min(side[-1, 0] for side in bare) > 1 - 1e-4
    told = _DOUBT if loop.repeated or corners else 0.0  # where the file says how it ends, the points must contradict it clearly
    ends = [sign * _straight_end(sign * side, loop.step, told) for side, sign in zip(bare, (UP, DOWN), strict=True)]
    if corners:  # what is off their sides by little is theirs
        off = [abs(float(side[-1, 1]) - _parabola(_stencil(end), side[-1, 0])) if len(end) < len(side) else 0.0
               for side, end in zip(bare, ends, strict=True)]  # fmt: skip
        ends = bare if max(off) < 0.6 * given else ends
    if all(len(end) == len(side) for end, side in zip(ends, whole, strict=True)) and not loop.repeated:
        _check_shared(whole, loop, path)
    upper, lower = _to_the_end(ends[0], ends[1], path)
    base = float(upper[-1, 1] - lower[-1, 1])
    if loop.repeated and (base < 0 or base > _thickness(ends)):  # sides that would cross or part: sharp, as the file says
        ends, (upper, lower), base = list(whole), whole, 0.0
    _check_base(whole, (upper, lower), base, path)
    said = [f"its {name} side carried on by {1 - end[-1, 0]:.4f} chords"
            for name, end in zip(("upper", "lower"), ends, strict=True) if end[-1, 0] < 1 - 1e-4]  # fmt: skip
    return Sides(upper, lower, max(base, 0.0), " and ".join(said) if base > _SEEN else "")


def _thickness(ends: list[Array]) -> float:
    """Thickness where the shorter side ends; no limit where both reach the trailing edge."""
    x = min(end[-1, 0] for end in ends)
    if x > 1 - 1e-4:
        return float(np.inf)
    return float(np.interp(x, *ends[0].T) - np.interp(x, *ends[1].T))


def _straight_end(side: Array, step: float, told: float) -> Array:
    """An upper side (or a lower one turned over) without a last point that turns towards the other side, off its parabola by
    more than `told`; of a rounded base without several."""
    near = _NEAR
    while len(side) > 7 and side[-1, 0] > near and side[-1, 0] - side[-2, 0] <= _CLOSE and _off(side, step) < -told:
        side, near = side[:-1], 1 - _ROUND
    return side


def _check_shared(whole: tuple[Array, Array], loop: Loop, path: Path) -> None:
    """Refuse a last point that the file gives once, where the points ahead of it say that one side does not end there."""
    for name, side, sign in zip(("upper", "lower"), whole, (UP, DOWN), strict=True):
        points = np.vstack([_stencil(sign * side[:-1]), sign * side[-1:]])
        if _parabola(points[:-1], points[-1, 0]) - points[-1, 1] > 5e-5 + 8 * loop.step:
            refuse(path, f"its trailing edge at x/c {side[-1, 0]:.4f} is given once and lies off the {name} side, whose last "
                   f"point is at x/c {side[-2, 0]:.4f}: sharp, or a base without a corner",
                   "the corners of both sides, or a sharp trailing edge as first and as last point")  # fmt: skip


def _without_base(side: Array) -> Array:
    """A side without the segments at its end that turn away from it by more than 30 degrees, or run forward."""
    x, y = side[:, 0], side[:, 1]
    behind = max(int(np.searchsorted(np.maximum.accumulate(x), _NEAR - 0.05)), 1)
    last = max(int(np.searchsorted(np.maximum.accumulate(x), 0.97)) - 1, behind + 1)
    last = min(last, len(side) - 2) if len(side) - 2 > behind else behind + 1
    along = np.arctan2(y[last] - y[behind], x[last] - x[behind])
    end = len(side)
    while end > 3 and x[end - 2] > _NEAR:
        dx, dy = x[end - 1] - x[end - 2], y[end - 1] - y[end - 2]
        if abs((np.arctan2(dy, dx) - along + np.pi) % (2 * np.pi) - np.pi) <= _TURN:
            break
        end -= 1
    return side[:end]


def _stencil(side: Array) -> Array:
    """The last six points of a side that are at least _CURVED apart, the last one included, in order of x."""
    chosen = [len(side) - 1]
    for index in range(len(side) - 2, -1, -1):
        if side[chosen[-1], 0] - side[index, 0] >= _CURVED or (len(chosen) == 1 and side[chosen[0], 0] > side[index, 0]):
            chosen.append(index)
        if len(chosen) == 6:
            break
    return side[chosen[::-1]]


def _parabola(points: Array, x: float) -> float:
    """y at x of the parabola through three points (Lagrange)."""
    (a, b, c), (ya, yb, yc) = points[-3:, 0], points[-3:, 1]
    return float(
        ya * (x - b) * (x - c) / ((a - b) * (a - c))
        + yb * (x - a) * (x - c) / ((b - a) * (b - c))
        + yc * (x - a) * (x - b) / ((c - a) * (c - b))
    )


def _off(side: Array, step: float) -> float:
    """How far the last point lies above the parabola through the points ahead of it; 0 within four times what such a parabola
    misses by the third derivative of the points ahead (Lagrange's remainder), and what the file's rounding makes of it."""
    points = np.vstack([_stencil(side[:-1]), side[-1:]])
    x = points[:, 0]
    miss = [float(points[k, 1] - _parabola(points[:k], x[k])) for k in range(3, len(points))]
    reach = [float(abs(np.prod(x[k] - x[k - 3 : k]))) for k in range(3, len(points))]
    bend = max((abs(m) / r for m, r in zip(miss[:-1], reach[:-1], strict=True)), default=np.inf)
    return miss[-1] if abs(miss[-1]) > 4 * bend * reach[-1] + 8 * step + 1e-6 else 0.0


def _to_the_end(upper: Array, lower: Array, path: Path) -> tuple[Array, Array]:
    """Both sides carried on to x = 1 along their parabolas.

    Where one side reaches it and the other falls short at a station of the first, the other takes over what the first one's
    parabola misses: for a symmetric section the corner is then exactly the mirror image.
    """
    found = []
    for side, other in ((upper, lower), (lower, upper)):
        end = side[-1, 0]
        if end >= 1.0 - 1e-9:
            found.append(side)
            continue
        if 1.0 - end > max(min(2.0 * (end - side[-2, 0]), 0.03), 0.004):
            refuse(path, f"one side ends at x/c {end:.4f}, {1 - end:.4f} ahead of the trailing edge: its base cannot be told",
                   "the points of both sides up to the base")  # fmt: skip
        y = _parabola(_stencil(side), 1.0)
        ahead = other[other[:, 0] <= end + 1e-6]
        if other[-1, 0] >= 1.0 - 1e-9 and abs(ahead[-1, 0] - end) <= 1e-6:
            y -= other[-1, 1] - _parabola(_stencil(ahead), 1.0)
        found.append(np.vstack([side, [1.0, y]]))
    return found[0], found[1]


def _check_base(whole: tuple[Array, Array], ends: tuple[Array, Array], base: float, path: Path) -> None:
    """Refuse a base that is too thick, upside down, or a step outside the sides (a flap of Gurney's)."""
    if base > MAX_BASE or base < -1e-4:
        refuse(path, f"trailing edge open by {base:.4f} chords", f"at most {MAX_BASE}, upper side above lower")
    for side, sign in zip(whole, (1.0, -1.0), strict=True):
        behind = side[side[:, 0] > ends[0][-2, 0]]
        edge = ends[0] if sign > 0 else ends[1]
        over = sign * (behind[:, 1] - np.interp(behind[:, 0], edge[-4:, 0], edge[-4:, 1]))
        if len(over) and over.max() > max(0.1 * base, 5e-4):
            refuse(path, f"a step of {over.max():.4f} chords out of the section at its trailing edge",
                   "a section without flap or tab there")  # fmt: skip


def closed(found: Sides, path: Path) -> tuple[Array, str]:
    """The contour in Selig order with a sharp trailing edge, shape (n, 2), chords, and how the base was closed.

    A wedge over the whole chord keeps nose and curvature, and is usual. Where it would take most of what a thin tail has, or
    more, the base is closed over the last twentieth of the chord or four base thicknesses (a parabola that begins there).
    """
    points = np.vstack([found.upper[::-1], found.lower[1:]])
    if found.base == 0.0:
        points[0] = points[-1] = 0.5 * (points[0] + points[-1])
        return points, ""
    sign = np.where(np.arange(len(points)) < len(found.upper) - 1, -1.0, 1.0)
    x = points[:, 0]
    share, over = x, "by a wedge over the chord"
    if not _leaves_enough(found):
        reach = max(0.05, 4 * found.base)
        share, over = np.maximum(x - (1 - reach), 0.0) ** 2 / reach**2, f"over the last {reach:.0%} of the chord"
    middle = 0.5 * (points[0] + points[-1])
    points = points + np.column_stack([np.zeros(len(points)), sign * 0.5 * found.base * share])
    points[0] = points[-1] = middle
    return points, over


def _leaves_enough(found: Sides) -> bool:
    """Whether a wedge over the whole chord leaves a fifth of the thickness up to x/c 0.95, a quarter of a wedge behind that."""
    (xu, yu), (xl, yl) = found.upper.T, found.lower.T
    x = np.union1d(np.union1d(xu, xl), [0.95])
    x = x[(x > 0.3) & (x < 1)]
    thickness = np.interp(x, xu, yu) - np.interp(x, xl, yl)
    left = thickness - found.base * x
    fore = x <= 0.95
    straight = left[x == 0.95][0] * (1 - x) / 0.05
    return bool(np.all(left[fore] > 0.2 * thickness[fore]) and np.all(left[~fore] > 0.25 * straight[~fore]))
