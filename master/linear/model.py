"""A linear model of one Mach number from small motions of its aero FMU, and every neutral V_f that follows from it.

Two sweeps in frequency, one of the plunge rate and one of pitch, are answered by the FMU and fitted by a rational model
(module `rational_fit`); a third motion, another sweep in both at once, tells how well the model predicts what it was not fitted
to. A sweep of finite amplitude gives the best linear model at that amplitude: where a shock makes the loads depend on it, sweep
as far as the marches swing (Pintelon and Schoukens, System Identification, 2nd ed., 2012, doi 10.1002/9781118287422). In fixed
air V_f changes the structure alone (module `case/scales`), so one model serves every V_f: the aeroelastic eigenvalues follow
from the structure's matrices and the model's, without a march.

Time is s = U t / b; x = (h/b, alpha, their derivatives, memory of the plunge rate, memory of pitch).
"""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..analysis import crossings as analysis_crossings
from ..case.case import Case
from ..case.fuel_tank import Liquid
from ..case.scales import scales
from ..flutter.setup import FlutterSetup
from ..flutter.statics import SteadySlopes
from . import rational_fit, root_loci
from .frequency_sweep import check_interface, chirp, drive, still
from .rational_fit import Rational
from .root_loci import Loci

STEP = 0.4  # half chords of travel a step, as in a march
SWEEP, REST = 240.0, 40.0  # length of a sweep and of the rest after it, half chords
LOWEST, BAND = 0.02, 1.0  # reduced frequencies swept
SLOWEST_KNOWN = LOWEST / 4.0  # reduced frequency of which a sweep and its rest hold less than a quarter of a period
CHECK = 150.0  # length of the motion that is not fitted
ORDER = 8  # poles
SLOWEST, FASTEST = 0.02, 2.0  # rates of the poles first guessed, per half chord
GRID = 160  # V_f values a range, evenly spread in their logarithm
NEAR = 0.3  # relative distance within which two models' crossings are one
PARTED = 3.0  # logarithm of the ratio of two modes at which one of them is seen alone
GOOD = 0.02  # a model that misses more of the unseen motion is said to


@dataclass(frozen=True)
class LinearCrossing:
    """A neutral V_f of the linear model, frequency over omega_alpha; `slope` is d(σ/ω_α)/dV_f.

    uncertainty  change of V_f under a model of two poles less; of a divergence, under slopes from the other side, or nan"""

    V_f: float
    frequency: float
    direction: str
    slope: float
    branch: int
    reduced_frequency: float
    uncertainty: float = 0.0

    @property
    def kind(self) -> str:
        """ "divergence" (static, frequency 0) or "flutter"."""
        return "flutter" if self.frequency else "divergence"

    @property
    def name(self) -> str:
        """What to call it: onset or recovery of flutter, or divergence."""
        return analysis_crossings.name(self.kind, self.direction)


@dataclass(frozen=True)
class LinearModel:
    """The aerodynamics of `case` at `mach`, linear about its steady flow.

    fit_error    rms missed over rms, of C_L and C_M, in the records fitted: (2,)
    check_error  the same in the motion not fitted: (2,); nan when none was made
    smaller      a model of two poles less: its neutral V_f differ by the model's own uncertainty; `aero` when none was made
    slopes       of the steady loads, from two steady solutions, which the models keep to; None where they could not be had
    other        the same from a steady solution further off on the other side: its divergence differs by what is not linear
    cpu          seconds: FMU and fit; steps: of the FMU
    note         what a user should know, or empty
    liquid       carried frozen by the section, whatever the slosh model; None when dry
    """

    case: Case
    mach: float
    amplitude_deg: float
    aero: Rational
    smaller: Rational
    fit_error: np.ndarray
    check_error: np.ndarray
    steps: int
    cpu: float
    wall: float
    note: str
    liquid: Liquid | None = None
    slopes: SteadySlopes | None = None
    other: SteadySlopes | None = None
    liquid_stiffness: float = 0.0  # at rest [N/rad per metre of span]

    def matrix(self, V_f: float) -> np.ndarray:
        """x' = A x of section and flow at `V_f`, per half chord of travel. Shape: (4 + 2 n, 4 + 2 n)."""
        return self._matrix(self.aero, V_f)

    def _matrix(self, aero: Rational, V_f: float) -> np.ndarray:
        return system_matrix(self.case, aero, V_f, *_carried(self.case, self.mach, self.liquid))

    def eigenvalues(self, V_f: float) -> np.ndarray:
        """Eigenvalues / omega_alpha with positive imaginary part, least damped first. Shape: (n,)."""
        values = np.linalg.eigvals(self.matrix(V_f)) * _per_omega_alpha(self.case, V_f)
        values = values[values.imag > 1e-6]
        return values[np.argsort(-values.real)]

    def spectrum(self, V_f: float) -> np.ndarray:
        """Eigenvalues / omega_alpha that what was swept can tell: no quicker than its highest frequency. Shape: (n,)."""
        values = np.linalg.eigvals(self.matrix(V_f))
        return values[np.abs(values) <= BAND] * _per_omega_alpha(self.case, V_f)

    def cycles(self, V_f: float) -> float:
        """Free cycles (periods 2 pi / omega_alpha) that a march at `V_f` needs until its two least damped oscillations can be
        told apart: half a beat, or until one of them is e^3 times smaller against the other than at the start."""
        values = self.spectrum(V_f)
        values = values[values.imag > 1e-6]
        if values.size < 2:
            return 0.0
        first, second = values[np.argsort(-values.real)][:2]
        beat = math.pi / max(abs(first.imag - second.imag), 1e-9)
        decay = PARTED / max(abs(first.real - second.real), 1e-9)
        return min(beat, decay) / (2.0 * math.pi)

    def real(self, V_f: float) -> float:
        """The largest real eigenvalue / omega_alpha; nan where all oscillate."""
        values = self.spectrum(V_f)
        values = values[np.abs(values.imag) <= 1e-6].real
        return float(values.max()) if values.size else math.nan

    def divergence(self, slopes: SteadySlopes | None = None) -> float:
        """The V_f of static divergence by the steady slopes (or `slopes`), else by the model's gain; inf where there is none."""
        slopes = slopes or self.slopes or SteadySlopes(*self.aero.steady)
        return slopes.divergence(scales(self.case, self.mach, self.case.flutter.V_f), self.liquid_stiffness)

    def loci(self, low: float, high: float) -> Loci:
        """All eigenvalues / omega_alpha over V_f in [low, high]."""
        return self._loci(self.aero, low, high)

    def _loci(self, aero: Rational, low: float, high: float) -> Loci:
        def matrix(V_f: float) -> np.ndarray:
            return self._matrix(aero, V_f) * _per_omega_alpha(self.case, V_f)

        return root_loci.follow(matrix, np.geomspace(low, high, GRID))

    def crossings(self, low: float, high: float) -> list[LinearCrossing]:
        """All neutral V_f in [low, high] at reduced frequencies that the model knows, in rising order.

        One below the lowest frequency swept counts when the smaller model has it too and it is not far below: else it is the
        fit's, not the flow's (beside divergence the slow poles of a fit make one)."""
        others = self._loci(self.smaller, low, high).neutral
        found = []
        for n in self.loci(low, high).neutral:
            k = n.frequency / _per_omega_alpha(self.case, n.value)
            alike = [o for o in others if o.direction == n.direction and abs(o.frequency - n.frequency) < 0.2 * n.frequency]
            same = [abs(o.value - n.value) for o in alike if abs(o.value / n.value - 1.0) < NEAR]
            if k <= BAND and (k >= LOWEST or (same and k >= SLOWEST_KNOWN)):
                doubt = min(same, default=self._unmatched(n.value, n.frequency, n.slope))
                found.append(LinearCrossing(n.value, n.frequency, n.direction, n.slope, n.branch, k, doubt))
        static = self.divergence()
        if low <= static <= high:
            step = 1e-3 * static
            slope = (self.real(static + step) - self.real(static - step)) / (2.0 * step)
            other = self.divergence(self.other) if self.other is not None else math.inf
            doubt = abs(other - static) if math.isfinite(other) else math.nan
            found.append(LinearCrossing(static, 0.0, "onset", slope, -1, 0.0, doubt))
        return sorted(found, key=lambda c: c.V_f)

    def _unmatched(self, V_f: float, frequency: float, slope: float) -> float:
        """Change of V_f under a model of two poles less that has no such crossing near: its growth rate there over the slope."""
        values = np.linalg.eigvals(self._matrix(self.smaller, V_f)) * _per_omega_alpha(self.case, V_f)
        nearest = values[np.argmin(np.abs(values - 1j * frequency))]
        return abs(float(nearest.real) / slope) if slope else math.nan


def identify(
    setup: FlutterSetup,
    amplitude_deg: float,
    say: Callable[[str], None] = lambda text: None,
    step: float = STEP,
    beside: LinearModel | None = None,
) -> LinearModel:
    """The linear model of the aero FMU of `setup`, from its saved steady flow, by motions of `amplitude_deg`.

    `step`: in half chords of travel. One `beside` another model takes its poles and does not tell an uncertainty of its own (a
    motion that is not fitted, a smaller model, steady slopes from the other side: half as much again). Raises ComponentError
    when the FMU fails, AeroSloshError when it lacks a variable or answers with no number."""
    begin = clock.perf_counter(), clock.process_time()
    check_interface(setup.aero)
    s = scales(setup.case, setup.mach, setup.case.flutter.V_f)  # speed and chord: V_f does not matter
    size = math.radians(amplitude_deg)
    sweep = chirp(size, 0.0, SWEEP, (LOWEST, BAND), 0.8)
    records = []
    for name, curves in (("plunge", (sweep, still)), ("pitch", (still, sweep))):
        say(f"  sweep in {name}, {amplitude_deg:g} degrees")
        records.append(drive(setup.aero, setup.steady, s, curves, step, SWEEP + REST))
    unseen = []
    if beside is None:
        say("  another motion, to check")
        both = chirp(size, 0.0, CHECK, (0.05, 0.4), 0.3), chirp(size, 0.0, CHECK, (0.08, 0.6), 1.3)
        unseen.append(drive(setup.aero, setup.steady, s, both, step, CHECK))
    slopes = setup.slopes()
    steady = np.array([slopes.C_L, slopes.C_M]) if slopes is not None else None
    if beside is None:
        aero = rational_fit.fit(records, ORDER, SLOWEST, FASTEST, steady)
        smaller = rational_fit.fit(records, ORDER - 2, SLOWEST, FASTEST, steady)
    else:
        aero = smaller = rational_fit.with_poles(records, beside.aero.poles, steady)
    liquid_stiffness = setup.tank.static_stiffness if setup.tank else 0.0
    diverges = slopes is not None and math.isfinite(slopes.divergence(s, liquid_stiffness))
    fit_error = np.max([aero.error(r) for r in records], axis=0)
    check_error = aero.error(unseen[0]) if unseen else np.full(2, math.nan)
    return LinearModel(
        setup.case,
        setup.mach,
        amplitude_deg,
        aero,
        smaller,
        fit_error,
        check_error,
        sum(r.s.size - 1 for r in [*records, *unseen]),
        clock.process_time() - begin[1],
        clock.perf_counter() - begin[0],
        _note(check_error),
        setup.tank.liquid if setup.tank else None,
        slopes,
        setup.other_slopes() if beside is None and diverges else None,
        liquid_stiffness,
    )


def _note(check_error: np.ndarray) -> str:
    """What is wrong with the model, if anything is known to be."""
    if not np.max(check_error) > GOOD:
        return ""
    return f"the linear model misses {100 * np.max(check_error):.1f} % of a motion it was not fitted to: the loads are not linear"


def _per_omega_alpha(case: Case, V_f: float) -> float:
    """What turns a rate per half chord into one over omega_alpha: U / (b omega_alpha) = V_f sqrt(mu)."""
    return V_f * math.sqrt(case.section.mass_ratio)


def _carried(case: Case, mach: float, liquid: Liquid | None) -> tuple[np.ndarray, np.ndarray]:
    """Mass and stiffness of the frozen liquid over (m, m b, m b²) and (m U²/b²) … (m U²). Shapes: (2, 2), (2, 2)."""
    if liquid is None:
        return np.zeros((2, 2)), np.zeros((2, 2))
    s = scales(case, mach, case.flutter.V_f)  # mass and speed: V_f does not matter
    M, K = liquid.matrices()
    b = np.array([1.0, s.half_chord])
    return M / (s.mass * np.outer(b, b)), K / (s.mass * (s.speed / s.half_chord) ** 2 * np.outer(b, b))


def system_matrix(case: Case, aero: Rational, V_f: float, liquid_mass: np.ndarray, liquid_stiffness: np.ndarray) -> np.ndarray:
    """Section and flow: x' = A x per half chord, x = (h/b, alpha, (h/b)', alpha', memory). Shape: (4 + 2 n, 4 + 2 n).

    m h'' + S alpha'' + … = −lift divided by m U²/b, and the pitch equation by m U²:
    loads enter as −C_L / (π μ) and 2 C_M / (π μ); the plunge rate w = (h/b)' is the first aerodynamic input. The liquid's
    matrices, (2, 2) each, are those of `_carried`."""
    section = case.section
    k_alpha = 1.0 / _per_omega_alpha(case, V_f)
    k_h = section.frequency_ratio * k_alpha
    x, r2 = section.x_alpha, section.r2_alpha
    load = np.array([-1.0, 2.0])[:, None] / (math.pi * section.mass_ratio)
    D0, D1, D2 = aero.feedthrough
    zero = np.zeros(2)
    M = np.array([[1.0, x], [x, r2]]) + liquid_mass - load * np.column_stack([D1[:, 0], D2[:, 1]])
    C = np.diag([2.0 * section.damping_ratio_h * k_h, 2.0 * section.damping_ratio_alpha * r2 * k_alpha])
    C = C - load * np.column_stack([D0[:, 0], D1[:, 1]])
    K = np.diag([k_h**2, r2 * k_alpha**2]) + liquid_stiffness - load * np.column_stack([zero, D0[:, 1]])
    memory, output = aero.states()
    n = memory.shape[0]
    A = np.zeros((4 + 2 * n, 4 + 2 * n))
    A[:2, 2:4] = np.eye(2)
    force = np.hstack([-K, -C, load * output[:, :, 0], load * output[:, :, 1]])
    A[2:4] = np.linalg.solve(M, force)
    A[4 : 4 + n, 4 : 4 + n] = A[4 + n :, 4 + n :] = memory
    A[4 : 4 + n, 2] = aero.entry  # driven by (h/b)'
    A[4 + n :, 1] = aero.entry  # driven by alpha
    return A
