"""A linear model from records in time: common poles by time-domain vector fitting, residues by least squares.

The answer of channel c to the inputs u_j(s) is  y_c = Σ_j [D0_cj u_j + D1_cj u_j' + D2_cj u_j'' + Σ_p R_pcj x_pj],
x_pj' = p x_pj + u_j: quasi-steady and apparent-mass terms, and the memory of wake, waves and shocks by poles p (real, or in
conjugate pairs). Vector fitting: Gustavsen and Semlyen, IEEE Trans. Power Delivery 14(3), 1999, doi 10.1109/61.772353; in
time: Grivet-Talocia, IEEE Microwave and Wireless Components Letters 13(11), 2003, doi 10.1109/LMWC.2003.819378. The poles
are then refined by variable projection (Golub and Pereyra, doi 10.1088/0266-5611/19/2/201).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import lfilter

from .frequency_sweep import NODES, QUADRATURE, Record

ROUNDS = 12  # of pole relocation
FASTEST = 2.0  # poles quicker than this times 1/ds are the feed-through's
STEADY_WEIGHT = 10.0  # of the steady gain, where it is known, beside a record's 1
TERMS = ((0, 1), (0, 1, 2))  # derivatives of w and of alpha that feed through


@dataclass(frozen=True)
class Rational:
    """The linear model. Frequencies per half chord travelled.

    poles        (n_p,) complex; of a conjugate pair the one with positive imaginary part, real ones with imaginary part 0
    residues     (n_p, 2, 2) complex: load (C_L, C_M), input (w, alpha); real for real poles
    feedthrough  (3, 2, 2): order of the derivative, load, input
    """

    poles: np.ndarray
    residues: np.ndarray
    feedthrough: np.ndarray

    def response(self, k: np.ndarray) -> np.ndarray:
        """The transfer function at the reduced frequencies `k` = omega b / U. Shape: (n, 2, 2), complex."""
        z = 1j * np.asarray(k, dtype=float)[:, None, None]
        total = sum(self.feedthrough[i] * z**i for i in range(3)).astype(complex)
        for p, r in zip(self.poles, self.residues, strict=True):
            total = total + r / (z - p) + (np.conj(r) / (z - np.conj(p)) if p.imag else 0.0)
        return total

    @property
    def steady(self) -> np.ndarray:
        """C_L and C_M over a steady pitch angle [1/rad]. Shape: (2,)."""
        return self.response(np.zeros(1))[0, :, 1].real

    def predict(self, record: Record) -> np.ndarray:
        """The loads that the model expects in `record`. Shape: (2, n)."""
        total = np.zeros_like(record.loads)
        for j in range(2):
            for i in range(3):
                total += np.outer(self.feedthrough[i, :, j], record.motion[j, 1 + i])
            for p, r in zip(self.poles, self.residues[:, :, j], strict=True):
                x = memory(record, j, p)
                total += (r[:, None] * x).real * (2.0 if p.imag else 1.0)
        return total

    def error(self, record: Record) -> np.ndarray:
        """rms of what the model misses in `record`, over the rms of the loads. Shape: (2,)."""
        return np.sqrt(np.mean((self.predict(record) - record.loads) ** 2, axis=1) / np.mean(record.loads**2, axis=1))

    def states(self) -> tuple[np.ndarray, np.ndarray]:
        """Real matrices (A, C) of the memory: x_j' = A x_j + entry u_j and loads C[:, :, j] x_j for input j.

        A has shape (n, n), C (2, n, 2); `entry` (n,) is the property below."""
        blocks, outputs = [], []
        for p, r in zip(self.poles, self.residues, strict=True):
            if p.imag:
                blocks.append(np.array([[p.real, p.imag], [-p.imag, p.real]]))
                outputs.append(np.stack([2.0 * r.real, 2.0 * r.imag], axis=1))
            else:
                blocks.append(np.array([[p.real]]))
                outputs.append(r.real[:, None, :])
        n = sum(len(block) for block in blocks)
        A, C, at = np.zeros((n, n)), np.zeros((2, n, 2)), 0
        for block, output in zip(blocks, outputs, strict=True):
            m = len(block)
            A[at : at + m, at : at + m] = block
            C[:, at : at + m] = output
            at += m
        return A, C

    @property
    def entry(self) -> np.ndarray:
        """Where the input enters the memory's states: 1 for each real pole, (1, 0) for each pair. Shape: (n,)."""
        return np.concatenate([[1.0, 0.0] if p.imag else [1.0] for p in self.poles])


def memory(record: Record, j: int, pole: complex) -> np.ndarray:
    """x' = pole x + u_j from rest, u_j taken as the function it is. Shape: (n,), complex."""
    ds = record.ds
    forcing = np.zeros(record.s.size, dtype=complex)
    forcing[1:] = (ds * QUADRATURE * np.exp(pole * ds * (1.0 - NODES))) @ record.between[j]
    return lfilter([1.0], [1.0, -np.exp(pole * ds)], forcing)


def _memory_slope(record: Record, j: int, pole: complex) -> np.ndarray:
    """The derivative of `memory` by the pole. Shape: (n,), complex."""
    ds = record.ds
    e = np.exp(pole * ds)
    forcing = np.zeros(record.s.size, dtype=complex)
    forcing[1:] = (ds * QUADRATURE * ds * (1.0 - NODES) * np.exp(pole * ds * (1.0 - NODES))) @ record.between[j]
    forcing[1:] += ds * e * memory(record, j, pole)[:-1]
    return lfilter([1.0], [1.0, -e], forcing)


def _filtered(y: np.ndarray, ds: float, pole: complex) -> np.ndarray:
    """x' = pole x + y from rest for samples `y` (…, n), linear between them."""
    z = pole * ds
    e = np.exp(z)
    old, new = ds * (e * (z - 1.0) + 1.0) / z**2, ds * (e - 1.0 - z) / z**2
    forcing = new * y.astype(complex)
    forcing[..., 1:] += old * y[..., :-1]
    return lfilter([1.0], [1.0, -e], forcing, axis=-1)


def fit(records: Sequence[Record], order: int, slowest: float, fastest: float, steady: np.ndarray | None = None) -> Rational:
    """The model with `order` poles that fits `records` best; first guesses are spread over [slowest, fastest].

    Each record moves one input alone, or both; together they must move both. Loads are weighed by their rms in all records.
    `steady` (2,), where it is known: C_L and C_M over a steady angle of attack [1/rad], which no sweep reaches."""
    weight = _weight(records)
    poles = _first_poles(order, slowest, fastest)
    for _ in range(ROUNDS):
        poles = _relocated(records, poles, weight, slowest)
    poles = _refined(records, poles, weight, slowest, steady)
    return _solve(records, poles, weight, steady)[0]


def with_poles(records: Sequence[Record], poles: np.ndarray, steady: np.ndarray | None = None) -> Rational:
    """The model with these `poles` that fits `records` best; the rest as for `fit`. Linear in the loads: it differs from another
    model of the same poles by what the loads differ by, not by where two fits came to rest."""
    return _solve(records, poles, _weight(records), steady)[0]


def _weight(records: Sequence[Record]) -> np.ndarray:
    """One over the rms of each load in all records. Shape: (2,)."""
    return 1.0 / np.sqrt(np.mean([np.mean(r.loads**2, axis=1) for r in records], axis=0))


def _first_poles(order: int, slowest: float, fastest: float) -> np.ndarray:
    """Real poles spread evenly in their logarithm."""
    return -np.geomspace(slowest, fastest, order).astype(complex)


def _columns(record: Record, j: int, poles: np.ndarray) -> np.ndarray:
    """Real basis of the answer to input j: its feed-through terms, then the memory of each pole. Shape: (m, n)."""
    rows = [record.motion[j, 1 + i] for i in TERMS[j]]
    for p in poles:
        rows += _pair(memory(record, j, p), p)
    return np.array(rows)


def _relocated(records: Sequence[Record], poles: np.ndarray, weight: np.ndarray, slowest: float) -> np.ndarray:
    """One round of vector fitting: the zeros of the common denominator become the poles."""
    rights, targets = [], []
    for record in records:
        basis = np.vstack([_columns(record, j, poles) for j in range(2) if np.any(record.motion[j, 1])])
        q = np.linalg.qr(basis.T / np.maximum(np.linalg.norm(basis, axis=1), 1e-300))[0]
        y = record.loads * weight[:, None]
        scale = 1.0 / np.sqrt(record.s.size)
        for c in range(2):
            rows: list[np.ndarray] = []
            for p in poles:
                x = _filtered(y[c], record.ds, p)
                rows += _pair(-x, p)
            block = np.array(rows).T
            rights.append(scale * (block - q @ (q.T @ block)))
            targets.append(scale * (y[c] - q @ (q.T @ y[c])))
    matrix, target = np.vstack(rights), np.concatenate(targets)
    norm = np.maximum(np.linalg.norm(matrix, axis=0), 1e-300)
    c = np.linalg.lstsq(matrix / norm, target, rcond=1e-12)[0] / norm
    A, entry = _modal(poles)
    # σ(s) = 1 + Σ c_p/(s − p): its zeros are the eigenvalues of A − b c
    out = np.concatenate([[2 * c[i], 2 * c[i + 1]] if p.imag else [c[i]] for i, p in zip(_starts(poles), poles, strict=True)])
    return _stable(np.linalg.eigvals(A - np.outer(entry, out)), slowest, FASTEST / records[0].ds)


def _starts(poles: np.ndarray) -> list[int]:
    """First column of each pole."""
    return [int(n) for n in np.concatenate([[0], np.cumsum([2 if p.imag else 1 for p in poles])[:-1]])]


def _modal(poles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Block-diagonal real A and entry vector of `poles`."""
    empty = Rational(poles, np.zeros((poles.size, 2, 2), dtype=complex), np.zeros((3, 2, 2)))
    return empty.states()[0], empty.entry


def _stable(values: np.ndarray, slowest: float, fastest: float) -> np.ndarray:
    """Poles in the left half plane, pairs by their upper half; rates between the slowest and the fastest."""
    upper = values[values.imag >= 0.0]
    rate = np.clip(np.abs(upper.real), 0.3 * slowest, fastest)
    return np.sort_complex(-rate + 1j * np.where(upper.imag > 1e-9, upper.imag, 0.0))


def _refined(
    records: Sequence[Record], poles: np.ndarray, weight: np.ndarray, slowest: float, steady: np.ndarray | None
) -> np.ndarray:
    """Variable projection: least squares on the poles alone, the rest eliminated."""
    pair = poles.imag > 0.0
    limit = FASTEST / records[0].ds
    target = _target(records, weight, steady)

    def unpack(v: np.ndarray) -> np.ndarray:
        p = -np.exp(v[: poles.size]).astype(complex)
        p[pair] += 1j * np.exp(v[poles.size :])
        return p

    def missed(v: np.ndarray) -> np.ndarray:
        return _Projection(_matrix(records, unpack(v), weight, steady), target).rest.ravel()

    def slopes(v: np.ndarray) -> np.ndarray:
        p = unpack(v)
        made = _Projection(_matrix(records, p, weight, steady), target)
        # of each pole by its parameters: the logarithms of its rate and, in a pair, of its frequency
        moves = [(n, complex(p[n].real)) for n in range(p.size)] + [(n, 1j * p[n].imag) for n in np.flatnonzero(pair)]
        return np.stack([made.outside(_change(records, p, int(n), by, made.weights, steady)).ravel() for n, by in moves], axis=1)

    first = np.concatenate([np.log(-poles.real), np.log(poles.imag[pair])])
    low = np.concatenate([np.full(poles.size, np.log(0.25 * slowest)), np.full(int(pair.sum()), np.log(1e-3))])
    high = np.full(first.size, np.log(1.05 * limit))
    first = np.clip(first, low + 1e-6, high - 1e-6)
    try:
        found = least_squares(missed, first, jac=slopes, bounds=(low, high), max_nfev=30, xtol=1e-6)
    except (np.linalg.LinAlgError, ValueError):
        return poles
    return unpack(found.x)


class _Projection:
    """Least squares of matrix·weights = target, (n, m), (m, 2), (n, 2): `weights`, and the `rest` matrix·weights − target."""

    def __init__(self, matrix: np.ndarray, target: np.ndarray) -> None:
        norm = np.maximum(np.linalg.norm(matrix, axis=0), 1e-300)
        u, size, v = np.linalg.svd(matrix / norm, full_matrices=False)
        kept = size > 1e-13 * size[0]
        self._basis = u[:, kept]
        inside = self._basis.T @ target
        self.weights = (v[kept].T @ (inside / size[kept, None])) / norm[:, None]
        self.rest = self._basis @ inside - target

    def outside(self, columns: np.ndarray) -> np.ndarray:
        """What of `columns` (n, 2) the matrix cannot make: how the rest changes with them (Kaufman's approximation)."""
        return columns - self._basis @ (self._basis.T @ columns)


def _matrix(records: Sequence[Record], poles: np.ndarray, weight: np.ndarray, steady: np.ndarray | None) -> np.ndarray:
    """Basis functions in the records, a column each (feed-through and memory of w, then of alpha); below them what is known of
    the steady gain: that both inputs have the same, since a steady plunge rate is an angle of attack, and that of alpha."""
    m = sum(2 if p.imag else 1 for p in poles)
    sizes = [len(terms) + m for terms in TERMS]
    rows = []
    for record in records:
        parts = [
            _columns(record, j, poles) if np.any(record.motion[j, 1]) else np.zeros((sizes[j], record.s.size)) for j in range(2)
        ]
        rows.append(np.vstack(parts).T / np.sqrt(record.s.size))
    gain = [np.concatenate([[1.0], np.zeros(len(t) - 1), *[_pair(-1.0 / p, p) for p in poles]]) for t in TERMS]
    return np.vstack([*rows, *_steady_rows(records, gain[0], gain[1], steady)])


def _steady_rows(records: Sequence[Record], w: np.ndarray, alpha: np.ndarray, steady: np.ndarray | None) -> list[np.ndarray]:
    """Rows (1, m) for the steady gains of both inputs' basis functions, as heavy as a record's."""
    typical = np.mean([np.max(np.abs(r.motion[:, 1])) for r in records])
    rows = [0.3 * typical * np.concatenate([w, -alpha])[None, :]]
    if steady is not None:
        rows.append(STEADY_WEIGHT * typical * np.concatenate([0.0 * w, alpha])[None, :])
    return rows


def _target(records: Sequence[Record], weight: np.ndarray, steady: np.ndarray | None) -> np.ndarray:
    """What the basis functions are to make: weighted loads, then the steady gains. Shape: (n, 2)."""
    typical = np.mean([np.max(np.abs(r.motion[:, 1])) for r in records])
    rows = [(r.loads * weight[:, None]).T / np.sqrt(r.s.size) for r in records] + [np.zeros((1, 2))]
    if steady is not None:
        rows.append(STEADY_WEIGHT * typical * (steady * weight)[None, :])
    return np.vstack(rows)


def _change(
    records: Sequence[Record], poles: np.ndarray, n: int, by: complex, weights: np.ndarray, steady: np.ndarray | None
) -> np.ndarray:
    """How matrix·weights changes when pole `n` changes by `by`, to first order. Shape: (rows, 2)."""
    p, wide = poles[n], 2 if poles[n].imag else 1
    m = sum(2 if q.imag else 1 for q in poles)
    at = _starts(poles)[n]
    starts = len(TERMS[0]) + at, len(TERMS[0]) + m + len(TERMS[1]) + at
    rows = []
    for record in records:
        total = np.zeros((record.s.size, 2))
        for j, start in enumerate(starts):
            if np.any(record.motion[j, 1]):
                total += np.array(_pair(by * _memory_slope(record, j, p), p)).T @ weights[start : start + wide]
        rows.append(total / np.sqrt(record.s.size))
    gain = [np.zeros(len(t) + m) for t in TERMS]
    for j, terms in enumerate(TERMS):
        gain[j][len(terms) + at : len(terms) + at + wide] = _pair(by / p**2, p)
    return np.vstack([*rows, *(row @ weights for row in _steady_rows(records, gain[0], gain[1], steady))])


def _solve(
    records: Sequence[Record], poles: np.ndarray, weight: np.ndarray, steady: np.ndarray | None = None
) -> tuple[Rational, np.ndarray]:
    """Residues and feed-through by least squares for given poles, and the weighted residual."""
    made = _Projection(_matrix(records, poles, weight, steady), _target(records, weight, steady))
    c = made.weights / weight
    residues = np.zeros((poles.size, 2, 2), dtype=complex)
    feed = np.zeros((3, 2, 2))
    at = 0
    for j, terms in enumerate(TERMS):
        for i in terms:
            feed[i, :, j] = c[at]
            at += 1
        for n, p in enumerate(poles):
            residues[n, :, j] = c[at] + 1j * c[at + 1] if p.imag else c[at]
            at += 2 if p.imag else 1
    return Rational(poles, residues, feed), made.rest.ravel()


def _pair(x: Any, p: complex) -> list[Any]:
    """Real basis functions of a pole from its complex one: two of a pair, one of a real pole."""
    return [2.0 * x.real, -2.0 * x.imag] if p.imag else [x.real]
