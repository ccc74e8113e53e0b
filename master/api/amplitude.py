"""The boundary over amplitude: which motions at a V_f grow, which decay, and the limit cycles between them."""

from __future__ import annotations

import csv
import dataclasses
import io
import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..analysis.envelopes import Cycle, Envelope, curve, cycles, envelope
from ..base import notices
from ..base.errors import AeroSloshError
from ..case import case as cases
from ..flutter import march as flutter_march
from ..flutter.march import March
from ..flutter.setup import FlutterSetup, find_fmus
from ..fmi import unpack
from ..results.amplitude_text import said
from ..results.provenance import provenance
from ..results.run_folder import RunFolder
from .case import Case
from .point import check_fmus, files, fmu_folder, warned, with_changes
from .progress import Callback, Reporter, interruptible, reporter

START_DEG = (0.1, 0.3, 1.0, 3.0)  # forced amplitudes
FREE_CYCLES = 20.0
BESIDE = (0.6, 1.6)  # of a limit cycle's amplitude: marches that confirm it from below and from above
MOST_DEG = 20.0  # of the forced pitch
THERE = 0.1  # of ln amplitude from a limit cycle: as good as on it
TURNED = 3  # last windows of a march that tell where it goes


@dataclass
class Amplitude:
    """Growth rates over amplitude at several V_f.

    data    `speeds`: one a V_f with its marches (start, end and rate there), `curve` (amplitude in degrees, growth rate, standard
            error) and `cycles` (amplitude, std, stable, confirmed from "below", "above", "both" or "")
    folder  the run folder, None where nothing was written"""

    case: Case | None
    data: dict[str, Any]
    folder: Path | None = None

    def __repr__(self) -> str:
        return "Amplitude(" + "; ".join(said(row) for row in self.data["speeds"]) + ")"


def amplitude(
    case: Case | str | os.PathLike[str],
    *,
    mach: float | None = None,
    V_f: Sequence[float] | float | None = None,
    starts_deg: Sequence[float] = START_DEG,
    slosh: str | None = None,
    free_cycles: float = FREE_CYCLES,
    folder: str | os.PathLike[str] | None = None,
    fmus: str | os.PathLike[str] | None = None,
    progress: bool | Callback = False,
) -> Amplitude:
    """Limit cycles and their stability at each `V_f` of a Mach number.

    starts_deg   amplitudes of the forced pitch [deg] from which marches of `free_cycles` begin; each limit cycle found is then
                 marched at from below and from above
    slosh, folder, fmus, progress  as in `point`

    Claims hold for amplitudes between the smallest and the largest marched, over `free_cycles` periods of omega_alpha.
    Raises AeroSloshError, ComponentError when an FMU fails."""
    cycles_asked = {"flutter.free_cycles": free_cycles, "flutter.max_free_cycles": free_cycles}
    core = with_changes(case, {"flow.mach": mach, "slosh.model": slosh, **cycles_asked}, "point")
    speeds = [core.flutter.V_f] if V_f is None else [float(v) for v in np.atleast_1d(np.asarray(V_f, dtype=float))]
    starts = checked_starts(starts_deg, f"starts_deg = {list(starts_deg)}", "ae.amplitude")
    found = find_fmus(fmu_folder(fmus), core.slosh.model, core.slosh.predictor)
    check_fmus(core, found)
    report, told = reporter(progress), warned([core], "point")
    with interruptible(), notices.to(report.say):
        if folder is None:
            return Amplitude(Case(core), compute(core, found, speeds, starts, report) | told)
        with RunFolder(Path(folder)) as run:
            run.write_case(core)
            data = compute(core, found, speeds, starts, report, run) | told
            write(core, data, run, found)
        return Amplitude(Case(core), data, run.target)


def checked_starts(given: Sequence[float], what: str, where: str) -> list[float]:
    """Amplitudes of the forced pitch [deg], rising. Raises AeroSloshError."""
    if not given or not all(math.isfinite(a) and 0.0 < a <= MOST_DEG for a in given):
        raise AeroSloshError(what, where, f"amplitudes above 0 and at most {MOST_DEG:g} degrees")
    return sorted(float(a) for a in given)


def compute(
    case: cases.Case,
    fmus: dict[str, Path],
    speeds: Sequence[float],
    starts: Sequence[float],
    report: Reporter,
    folder: RunFolder | None = None,
) -> dict[str, Any]:
    """Rows of `Amplitude.data`; what is done is in the folder's result after each V_f. Raises ComponentError."""
    data: dict[str, Any] = {
        "mach": case.flow.mach,
        "slosh": case.slosh.model,
        "free_cycles": case.flutter.free_cycles,
        "speeds": [],
    }

    def say(text: str) -> None:
        if folder is not None:
            folder.log(text)
        report.say(text)

    with FlutterSetup(case, fmus, case.flow.mach, None, say) as setup:
        for V_f in speeds:
            data["speeds"].append(_at_speed(setup, case, V_f, starts, report))
            say(said(data["speeds"][-1]))
            if folder is not None:
                folder.write_result(data)
                folder.publish()
    return data


def _at_speed(setup: FlutterSetup, case: cases.Case, V_f: float, starts: Sequence[float], report: Reporter) -> dict[str, Any]:
    """Marches from all starts, and beside each limit cycle that they show."""
    marches: list[dict[str, Any]] = []
    envelopes: list[Envelope] = []
    released: list[float] = []  # amplitude after the release over that of the forced pitch

    def go(forced_deg: float) -> Envelope:
        report.start(f"V_f {V_f:.4g} from {forced_deg:.3g} deg")
        setup.case = dataclasses.replace(case, flutter=dataclasses.replace(case.flutter, forced_amplitude_deg=forced_deg))
        march = flutter_march.march(setup, V_f, None, report.watch)
        if march.failure is not None:
            raise march.failure
        of_it = _envelope(march)
        envelopes.append(of_it)
        marches.append(_march_data(forced_deg, march, of_it))
        if of_it.amplitude.size:
            released.append(float(of_it.amplitude[0]) / forced_deg)
        return of_it

    try:
        for forced in starts:
            go(forced)
        confirmed = []
        for c in cycles(envelopes):
            sides = []
            for share, name in zip(BESIDE, ("below", "above"), strict=True):
                forced = share * c.amplitude / float(np.median(released))
                if forced <= MOST_DEG:
                    of_it = go(forced)
                    if of_it.amplitude.size and _comes(of_it, c.amplitude) == c.stable:
                        sides.append(name)
            confirmed.append((c, "both" if len(sides) == 2 else "".join(sides)))
    finally:
        setup.case = case
    again = cycles(envelopes)  # with what the confirming marches added
    return {
        "V_f": V_f,
        "marches": marches,
        "curve": [dict(zip(("amplitude_deg", "growth_rate", "standard_error"), row, strict=True)) for row in _rows(envelopes)],
        "cycles": [_cycle_data(c, confirmed) for c in again],
    }


def _comes(e: Envelope, size: float) -> bool:
    """Whether a motion comes to the amplitude `size`: it ends there, or on its way there."""
    last = float(e.amplitude[-1])
    return abs(math.log(last / size)) < THERE or (float(np.median(e.rate[-TURNED:])) > 0.0) == (last < size)


def _envelope(march: March) -> Envelope:
    """Of the pitch after the release [rad], at the frequency of the critical oscillation."""
    mode = march.fit.oscillation if march.fit is not None else None
    frequency = mode.frequency if mode is not None else _counted(march)
    return envelope(march.tau[march.release :], march.history["alpha"][march.release :], frequency)


def _counted(march: March) -> float:
    """The frequency over omega_alpha by counting zeros, for a motion that nothing was fitted to; 0 where it has hardly any."""
    tau, alpha = march.tau[march.release :], march.history["alpha"][march.release :]
    turns = np.flatnonzero(np.diff(np.sign(alpha - np.mean(alpha))))
    return math.pi * (turns.size - 1) / float(tau[turns[-1]] - tau[turns[0]]) if turns.size > 3 else 0.0


def _march_data(forced_deg: float, march: March, of_it: Envelope) -> dict[str, Any]:
    known = of_it.amplitude.size > 0
    return {
        "forced_deg": forced_deg,
        "first_deg": math.degrees(of_it.amplitude[0]) if known else None,
        "last_deg": math.degrees(of_it.amplitude[-1]) if known else None,
        "last_rate": float(np.median(of_it.rate[-TURNED:])) if known else None,
        "verdict": str(march.verdict),
        "cpu_seconds": march.cost.total_cpu,
    }


def _rows(envelopes: Sequence[Envelope]) -> list[tuple[float, float, float]]:
    return [(math.degrees(a), float(r), float(e)) for a, r, e in zip(*curve(envelopes), strict=True)]


def _cycle_data(c: Cycle, confirmed: Sequence[tuple[Cycle, str]]) -> dict[str, Any]:
    near = [name for other, name in confirmed if other.stable == c.stable and abs(math.log(other.amplitude / c.amplitude)) < 0.3]
    return {
        "amplitude_deg": math.degrees(c.amplitude),
        "std_deg": math.degrees(c.std),
        "stable": c.stable,
        "slope": c.slope,
        "confirmed": near[0] if near else "",
    }


def write(case: cases.Case, data: dict[str, Any], folder: RunFolder, fmus: dict[str, Path]) -> None:
    """result.json, amplitude.csv and the pictures. Raises OSError."""
    hashes = {name: unpack.sha256(path) for name, path in files(case, fmus).items()}
    folder.write_result(data | {"provenance": provenance(hashes)})
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(["V_f", "amplitude_deg", "growth_rate", "standard_error"])
    for row in data["speeds"]:
        table.writerows([row["V_f"], p["amplitude_deg"], p["growth_rate"], p["standard_error"]] for p in row["curve"])
    (folder.path / "amplitude.csv").write_text(text.getvalue(), encoding="utf-8")
    if case.output.pictures:
        from ..pictures import amplitude as pictures  # matplotlib takes half a second to import

        pictures.draw(data, folder.path / "amplitude.png")
