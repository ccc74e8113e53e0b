"""From the rows of a coordinate file to one loop around the section, whatever the order they are written in.

Understood are a loop in either sense that begins anywhere (Selig order begins at the trailing edge), and two sides one after
the other, each in either sense, the upper or the lower one first, with or without counts (Lednicer order).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .airfoil_text import Rows, refuse

Array = NDArray[np.float64]

FEWEST = 20
_JUMP = 0.5
"""Two points in a row that are this far apart [chords] belong to different sides."""
_GAP = 0.35
"""Two neighbours that are farther apart than this [chords] have points missing between them."""
_SAME = 1e-9
"""Two points in a row that are closer [chords] are one."""
_REMEDY = "Selig order (trailing edge, upper side, nose, lower side) or Lednicer order with counts"


@dataclass(frozen=True)
class Loop:
    """points: shape (n, 2), anticlockwise, each once, in chords with the least x at 0 and the greatest at 1; lines: (n,) of the
    file; chord, start: length and least x in the file's units; step: the file's resolution [chords]; count: points read;
    repeated: whether the file's last point is its first; notes: what was done."""

    points: Array
    lines: NDArray[np.int64]
    chord: float
    start: float
    step: float
    count: int
    repeated: bool
    notes: tuple[str, ...]


def loop(rows: Rows, path: Path) -> Loop:
    """The loop that the rows of `path` make. Raises AirfoilError where they make none."""
    points, lines, notes = rows.points, rows.lines, list(rows.notes)
    if len(points) < FEWEST:
        refuse(path, f"{len(points)} points", f"{FEWEST} or more, 60 to 200 for good accuracy")
    points, lines, split = _without_counts(points, lines, path)
    for line, value in rows.singles[1:] if rows.singles and rows.singles[0][0] == 1 else rows.singles:
        if value != len(points):
            refuse(path, f"a single number, {value}, where {len(points)} points follow", "a title begins with a letter", line)
    count, start, chord = len(points), float(points[:, 0].min()), float(np.ptp(points[:, 0]))
    if not chord > 0 or np.ptp(points[:, 1]) > 0.8 * chord:
        refuse(path, f"{chord:g} long in x and {np.ptp(points[:, 1]):g} in y: no section along x",
               "x from the nose to the trailing edge, y across, both in the same unit")  # fmt: skip
    scaled = np.column_stack([(points[:, 0] - start) / chord, points[:, 1] / chord])
    order, said = _order(scaled, lines, path, split)
    scaled, lines = scaled[order], lines[order]
    repeated = bool(np.linalg.norm(scaled[0] - scaled[-1]) < _SAME)
    keep = np.linalg.norm(scaled - np.roll(scaled, 1, axis=0), axis=1) >= _SAME
    scaled, lines = scaled[keep], lines[keep]
    if len(scaled) < FEWEST:
        refuse(path, f"{len(scaled)} different points", f"{FEWEST} or more, 60 to 200 for good accuracy")
    area = 0.5 * np.sum(scaled[:, 0] * np.roll(scaled[:, 1], -1) - np.roll(scaled[:, 0], -1) * scaled[:, 1])
    if area < 0:
        scaled, lines, said = scaled[::-1], lines[::-1], said or "lower side first"
    if said:
        notes.append(said)
    _check_ends(scaled, path)
    return Loop(scaled, lines, chord, start, rows.step / chord, count, repeated, tuple(notes))


def _without_counts(points: Array, lines: NDArray[np.int64], path: Path) -> tuple[Array, NDArray[np.int64], int]:
    """Points and lines without a first row that counts the points of both sides, and the first count (0 without)."""
    first, rest = points[0], points[1:]
    if first.min() >= 2 and np.all(first == np.round(first)):
        if len(rest) == first.sum():
            return rest, lines[1:], int(first[0])
        if rest[0, 0] <= rest[:, 0].min() + 0.02 * np.ptp(rest[:, 0]):  # the nose follows: these are counts
            refuse(path, f"its counts {first[0]:g} + {first[1]:g} do not match its {len(rest)} points", "correct the counts",
                   int(lines[0]))  # fmt: skip
    low, high = rest.min(axis=0), rest.max(axis=0)
    if np.any(first < low - (high - low).max()) or np.any(first > high + (high - low).max()):
        refuse(path, f"'{first[0]:g} {first[1]:g}' is no point of the section that follows",
               "a title begins with a letter", int(lines[0]))  # fmt: skip
    return points, lines, 0


def _order(points: Array, lines: NDArray[np.int64], path: Path, split: int) -> tuple[NDArray[np.int64], str]:
    """The order in which the rows run around the section, and how it was found (empty: as written)."""
    jumps = np.nonzero(np.linalg.norm(np.diff(points, axis=0), axis=1) > _JUMP)[0] + 1
    every = np.arange(len(points))
    if not split and not len(jumps):
        return every, ""
    if len(jumps) > 1:
        refuse(path, f"the points jump by more than half a chord {len(jumps)} times", _REMEDY, int(lines[jumps[1]]))
    at = split or int(jumps[0])
    if len(jumps) and jumps[0] != at:
        refuse(path, f"the counts say that the second side begins {at} points on, it begins {jumps[0]} points on",
               "correct the counts", int(lines[jumps[0]]))  # fmt: skip
    first, second = every[:at], every[at:]
    for side in (first, second):
        if np.ptp(points[side, 0]) < 0.7:
            refuse(path, f"of the two sides one is {np.ptp(points[side, 0]):.2f} chords long only", _REMEDY, int(lines[side[0]]))
    if points[first[0], 0] < points[first[-1], 0]:
        first = first[::-1]
    if points[second[0], 0] > points[second[-1], 0]:
        second = second[::-1]
    return np.concatenate([first, second]), "the two sides one after the other"


def _check_ends(points: Array, path: Path) -> None:
    """Refuse a loop that does not close, one with a gap and one whose nose is behind."""
    following = np.roll(points, -1, axis=0)
    length = np.linalg.norm(following - points, axis=1)
    usual = np.maximum(np.roll(length, 1), np.roll(length, -1))
    ends = points[0], points[-1]
    if min(ends[0][0], ends[1][0]) < 0.98 and length[-1] > 0.02 and (length[-1] > 2.5 * usual[-1] or length[-1] > 0.3):
        refuse(path, f"the first and last points are at x/c {ends[0][0]:.3f} and {ends[1][0]:.3f}, not at the trailing edge "
               f"both or side by side", _REMEDY)  # fmt: skip
    fore, aft = (np.ptp(points[(points[:, 0] > a) & (points[:, 0] < b), 1]) if np.any((points[:, 0] > a) & (points[:, 0] < b))
                 else 0.0 for a, b in ((-1.0, 0.12), (0.88, 2.0)))  # fmt: skip
    if aft > 1.5 * fore and aft > 0.03:
        refuse(path, f"{fore:.3f} chords high at its low-x end and {aft:.3f} at the other: the nose seems to be behind",
               "x from the nose to the trailing edge")  # fmt: skip


def check_gaps(chain: Loop, path: Path) -> None:
    """Refuse a loop with a gap that no curve through the points can fill."""
    following = np.roll(chain.points, -1, axis=0)
    length = np.linalg.norm(following - chain.points, axis=1)
    worst = int(np.argmax(length))
    if length[worst] > _GAP:
        between = f"x/c {chain.points[worst, 0]:.3f} (line {chain.lines[worst]}) and {following[worst, 0]:.3f}"
        refuse(path, f"no points between {between}", "add the points missing")


def apart(chain: Loop) -> Loop:
    """The loop from its aftmost point on, without points closer than eight times the file's resolution (1e-6 chords at least):
    there its rounding, not the section, decides which way the surface runs."""
    apart_by = max(8 * chain.step, 1e-6)
    points, lines = chain.points, chain.lines
    end = np.nonzero(points[:, 0] > 1 - apart_by)[0]
    inner = np.setdiff1d(end, end[[int(np.argmax(points[end, 1])), int(np.argmin(points[end, 1]))]])  # of a base but its corners
    points, lines = np.delete(points, inner, axis=0), np.delete(lines, inner)
    tail = int(np.argmax(points[:, 0]))
    points, lines = np.roll(points, -tail, axis=0), np.roll(lines, -tail)
    least = np.full(len(points) + 1, apart_by)
    keep = far_enough(np.vstack([points, points[:1]]), int(np.argmin(points[:, 0])), least)[:-1]
    return replace(chain, points=points[keep], lines=lines[keep])


def far_enough(points: Array, nose: int, least: Array) -> NDArray[np.bool_]:
    """Which points of a closed contour, shape (n, 2), first = last, to keep so that they are `least` apart, shape (n,): counted
    on both sides from the trailing edge to the nose, which stay."""
    n = len(points)
    keep = np.zeros(n, dtype=bool)
    keep[[0, nose, n - 1]] = True
    x, y, limit = points[:, 0].tolist(), points[:, 1].tolist(), least.tolist()
    for side in (range(1, nose), range(n - 2, nose, -1)):
        last = 0
        for k in side:
            far = math.hypot(x[k] - x[last], y[k] - y[last]) >= limit[k]
            if far and math.hypot(x[k] - x[nose], y[k] - y[nose]) >= limit[k]:
                keep[k], last = True, k
    return keep
