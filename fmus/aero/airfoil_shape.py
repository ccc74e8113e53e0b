"""What a contour is like: thickness, camber, nose radius, chord line; and whether it is a simple closed curve."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_PAIRS = 1_000_000
"""Pairs of segments that are compared at a time."""


@dataclass(frozen=True)
class Shape:
    """Largest thickness and camber [chords] with their x/c, radius of the leading edge [chords], incidence of the chord line
    to the x axis [rad], positive nose-up, and thickness across x at the stations x/c 0.02 to 0.98."""

    thickness: float
    thickness_at: float
    camber: float
    camber_at: float
    nose_radius: float
    chord_line: float
    least: float
    least_at: float


def shape(contour: Array) -> Shape:
    """Measures of a contour of shape (n, 2) in Selig order, chords."""
    nose = int(np.argmin(contour[:, 0]))
    upper, lower = contour[nose::-1], contour[nose:]
    x = np.linspace(0.005, 0.995, 1981)
    above, below = np.interp(x, *upper.T), np.interp(x, *lower.T)
    thick, mean = above - below, 0.5 * (above + below)
    line = contour[nose, 1] + (contour[0, 1] - contour[nose, 1]) * x
    bow = mean - line
    most, curved = int(np.argmax(thick)), int(np.argmax(np.abs(bow)))
    inside = (x > 0.02) & (x < 0.98)
    least = int(np.argmin(np.where(inside, thick, np.inf)))
    far = int(np.argmax(np.hypot(*(contour - contour[0]).T)))
    slope = float(np.arctan2(contour[far, 1] - contour[0, 1], contour[0, 0] - contour[far, 0]))
    return Shape(float(thick[most]), float(x[most]), float(bow[curved]), float(x[curved]), nose_radius(contour, nose), slope,
                 float(thick[least]), float(x[least]))  # fmt: skip


def nose_radius(contour: Array, nose: int) -> float:
    """Radius [chords] of curvature at the nose: x as a polynomial of fourth degree in y, fitted to what lies ahead of x/c 0.01;
    of second degree through five points where these are fewer than eight."""
    near, degree = contour[:, 0] < 0.01, 4
    if near.sum() < 8:
        near[:], degree = False, 2
        near[max(nose - 2, 0) : nose + 3] = True
    x, y = contour[near].T
    middle, scale = contour[nose, 1], np.ptp(y)
    c = np.polynomial.polynomial.polyfit((y - middle) / scale, x, degree)
    return float(scale**2 * (1 + (c[1] / scale) ** 2) ** 1.5 / max(2 * c[2], 1e-12))


def crossing(points: Array) -> tuple[int, int] | None:
    """Indices of two segments of an open chain of points, shape (n, 2), that cross or touch, or None.

    Neighbours share a point and may; so may the first and the last segment of a closed chain. Only segments whose extents in x
    overlap are compared, a million pairs at a time: 20,000 points need a few MB.
    """
    start, end = points[:-1], points[1:]
    low, high = np.minimum(start, end), np.maximum(start, end)
    order = np.argsort(low[:, 0], kind="stable")
    last = np.searchsorted(low[order, 0], high[order, 0], side="right")
    partners = last - np.arange(len(order)) - 1
    total = np.concatenate([[0], np.cumsum(partners)])
    closed = bool(np.all(points[0] == points[-1]))
    for first in range(0, int(total[-1]), _PAIRS):
        pair = np.arange(first, min(first + _PAIRS, int(total[-1])))
        a = np.searchsorted(total, pair, side="right") - 1
        i, j = order[a], order[a + 1 + pair - total[a]]
        i, j = np.minimum(i, j), np.maximum(i, j)
        apart = (j - i > 1) & (low[i, 1] <= high[j, 1]) & (low[j, 1] <= high[i, 1])
        if closed:
            apart &= ~((i == 0) & (j == len(start) - 1))
        i, j = i[apart], j[apart]
        met = _opposite(start[i], end[i], start[j], end[j]) & _opposite(start[j], end[j], start[i], end[i])
        if np.any(met):
            k = np.lexsort((j[met], i[met]))[0]
            return int(i[met][k]), int(j[met][k])
    return None


def _opposite(a: Array, b: Array, c: Array, d: Array) -> NDArray[np.bool_]:
    """Whether c and d lie on different sides of the line through a and b, or one of them on it."""

    def side(p: Array) -> Array:
        return (b[:, 0] - a[:, 0]) * (p[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (p[:, 0] - a[:, 0])

    return np.asarray(side(c) * side(d) <= 0)
