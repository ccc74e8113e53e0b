"""The verdict on a march, so far and at its end."""

from __future__ import annotations

import dataclasses

import numpy as np

from ..analysis.damping import analyse
from ..analysis.verdict import MORE_CYCLES, Judgement, Verdict, judge
from ..cosim.loop import End, Stop
from .setup import FlutterSetup
from .span import PERIODS, Span, slower_frequency

FEWEST = 24  # samples that a motion which grew out of reach is fitted on
TIMES_LARGER = 3.0  # a motion that outgrew max_alpha_deg by this factor since its release grows


def judged(table: dict[str, np.ndarray], span: Span, V_f: float, setup: FlutterSetup, enough: int = 0) -> Judgement:
    """Fit and verdict of the free part, if there are `enough` samples of it."""
    tau, free = table["tau"][span.release :], np.vstack([table["h_over_b"], table["alpha"]])[:, span.release :]
    if tau.size < enough:
        return Judgement(Verdict.UNDETERMINED, "the free response is shorter than one period", False, None, MORE_CYCLES)
    said = judge(tau, free, analyse(tau, free), setup.case.flutter.neutral_band, setup.stiffness(V_f))
    if span.release + tau.size - 1 >= span.least or said.verdict in (Verdict.FLUTTER, Verdict.DIVERGENCE, Verdict.UNDETERMINED):
        return said
    slower = f"{PERIODS:g} periods of the slower natural mode ({slower_frequency(setup.case):.3f} omega_alpha)"
    return Judgement(Verdict.UNDETERMINED, f"the free response is shorter than {slower}", False, said.fit, MORE_CYCLES)


def seen_frequency(table: dict[str, np.ndarray], release: int) -> float | None:
    """Frequency of the critical mode in the free motion so far, over omega_alpha; None where none is seen, or none oscillates."""
    fit = analyse(table["tau"][release:], np.vstack([table["h_over_b"], table["alpha"]])[:, release:])
    return fit.frequency if fit is not None and fit.frequency > 0.0 else None


def checked(
    said: Judgement, table: dict[str, np.ndarray], release: int, stop: Stop | None, failed: int, steps: int, stiffness: float
) -> Judgement:
    """`said` in the light of how the march ended: `stop`, and `failed` of `steps` steps whose coupling did not converge."""
    if failed > 0.05 * max(1, steps):
        reason = f"the coupling iteration did not converge in {failed} steps"
        return Judgement(Verdict.UNDETERMINED, reason, False, said.fit, "coupling.max_iterations, or smaller steps")
    unstable = said.verdict in (Verdict.FLUTTER, Verdict.DIVERGENCE)
    if stop is not None and stop.end is End.NOT_FINITE and said.verdict is Verdict.UNDETERMINED:
        return dataclasses.replace(said, remedy=stop.end.value)
    if stop is None or stop.end is not End.TOO_LARGE or unstable:
        return said
    alpha = np.abs(table["alpha"][release:])
    first = float(np.max(alpha[: max(2, alpha.size // 3)])) if alpha.size else 0.0
    forced = float(np.max(np.abs(table["alpha"][: release + 1])))
    if alpha.size and alpha[-1] > TIMES_LARGER * max(forced, 1e-300) and alpha[-1] > 1.05 * first:
        # the largest motion so far, on one side since it was half as large: it does not oscillate any more
        small = np.flatnonzero(alpha < 0.5 * alpha[-1])
        late = table["alpha"][release + (int(small[-1]) if small.size else 0) :]
        static = stiffness < 0.0 and bool(np.all(late > 0.0) or np.all(late < 0.0))
        verdict = Verdict.DIVERGENCE if static else Verdict.FLUTTER
        how = "without oscillating" if static else "out of reach"
        return Judgement(verdict, f"the motion grows {how}: {stop.text}", True, said.fit)
    return Judgement(Verdict.UNDETERMINED, stop.text, False, said.fit, stop.end.value)
