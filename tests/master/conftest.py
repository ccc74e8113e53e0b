"""Run folders made by the real writers from made-up marches: what comparisons and exports are tried on."""

from __future__ import annotations

import copy
import itertools
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from aeroslosh.master.analysis import envelopes
from aeroslosh.master.analysis.damping import analyse
from aeroslosh.master.analysis.envelopes import Envelope
from aeroslosh.master.analysis.verdict import Verdict
from aeroslosh.master.api import amplitude
from aeroslosh.master.case import case as cases
from aeroslosh.master.case.case import Case
from aeroslosh.master.case.scales import scales
from aeroslosh.master.cosim.loop import Cost
from aeroslosh.master.flutter.march import March
from aeroslosh.master.results import point_file, summary
from aeroslosh.master.results.history_writer import write_history
from aeroslosh.master.results.provenance import provenance
from aeroslosh.master.results.run_folder import RunFolder

HASHES = {"structure": "a" * 64, "aero": "b" * 64}


def march(
    V_f: float = 0.6, growth: float = -0.01, frequency: float = 0.9, cycles: int = 6, steps_per_cycle: int = 80, cpu: float = 1.0
) -> March:
    """A free response alpha = exp(growth tau) cos(frequency tau) degrees, its plunge behind it; fitted as a march is."""
    case = Case()
    case.flutter.steps_per_cycle = steps_per_cycle
    s = scales(case, 0.3, V_f)
    time = np.arange(cycles * steps_per_cycle + 1) * s.dt
    tau = time * s.omega_alpha
    alpha = np.radians(1.0) * np.exp(growth * tau) * np.cos(frequency * tau)
    h = 0.01 * np.exp(growth * tau) * np.sin(frequency * tau)
    history = {"time": time, "tau": tau, "h_over_b": h / s.half_chord, "h": h, "alpha": alpha, "lift": 4000.0 * alpha}
    history |= {"subiterations": np.full(tau.size, 3.0), "passes": np.ones(tau.size)}
    cost = Cost({"structure": 0.1 * cpu, "aero": 0.9 * cpu}, cpu, cpu, tau.size - 1)
    fit = analyse(tau, np.vstack([h / s.half_chord, alpha]))
    verdict = Verdict.DAMPED if growth < 0 else Verdict.FLUTTER
    return March(s, history, 0, fit, verdict, f"made up, growth {growth:g}", cost, unconverged={"coupling": 0, "aero": 0})


@pytest.fixture
def made_up() -> Callable[..., March]:
    """The function `march`."""
    return march


@pytest.fixture
def point_run(tmp_path: Path) -> Callable[..., Path]:
    """Return a function that writes the folder of a point: name, its march, overrides of the case, changes of the provenance."""

    def write(name: str, of: March, overrides: Sequence[str] = (), about: dict[str, Any] | None = None) -> Path:
        case = Case()
        for override in overrides:
            cases.apply_override(case, override)
        told = provenance(HASHES) | (about or {})
        with RunFolder(tmp_path / name) as folder:
            folder.write_case(case)
            write_history(folder.path / "history.nc", of, told)
            folder.write_result(summary.march_data(of) | {"provenance": told})
        return tmp_path / name

    return write


@pytest.fixture
def boundary_run(tmp_path: Path) -> Callable[..., Path]:
    """Return a function that writes the folder of a boundary: name, Mach number → crossings (V_f, uncertainty, direction)."""

    def write(name: str, found: dict[float, list[tuple[float, float, str]]], marches: Sequence[March] = ()) -> Path:
        points = []
        for mach, crossings in found.items():
            rows = [
                {"V_f": v, "V_f_uncertainty": u, "frequency": 0.8, "direction": d, "slope": 0.1, "uncertainty_parts": {"fit": u}}
                for v, u, d in crossings
            ]
            data = [summary.march_data(m) for m in marches]
            cost = {"wall_seconds": 1.0, "cpu_seconds": 2.0, "marches": len(data)}
            points.append(
                {"mach": mach, "verdict": "neutral", "outcome": "", "converged": True, "crossings": rows, "linear": None}
                | {"marches": data, "cost": cost}
            )
        with RunFolder(tmp_path / name) as folder:
            folder.write_case(Case())
            for m in marches:
                write_history(folder.path / f"history_Vf{m.scales.V_f:.4f}.nc", m, provenance(HASHES))
            folder.write_result(
                {"slosh": "none", "points": points, "cost": {"wall_seconds": 1.0}, "provenance": provenance(HASHES)}
            )
        return tmp_path / name

    return write


@pytest.fixture
def amplitude_run(tmp_path: Path) -> Callable[..., Path]:
    """Return a function that writes the folder of an amplitude: name, V_f → `rate` of an amplitude [deg] (σ/ω_α)."""

    def write(
        name: str, rates: dict[float, Callable[[float], float]], sizes: Sequence[float] = (0.1, 0.3, 1.0, 3.0, 9.0)
    ) -> Path:
        speeds = []
        for V_f, rate in rates.items():
            motions = [
                Envelope(np.radians(np.array(pair)), np.array([rate(a) for a in pair])) for pair in itertools.pairwise(sizes)
            ]
            marches = [
                {"forced_deg": a, "first_deg": a, "last_deg": b, "last_rate": rate(b), "verdict": "flutter", "cpu_seconds": 2.0}
                for a, b in itertools.pairwise(sizes)
            ]
            curve = [{"amplitude_deg": a, "growth_rate": rate(a), "standard_error": 1e-4} for a in sizes]
            found = [amplitude._cycle_data(c, [(c, "both")] if c.stable else []) for c in envelopes.cycles(motions)]
            speeds.append({"V_f": V_f, "marches": marches, "curve": curve, "cycles": found})
        case = Case()
        with RunFolder(tmp_path / name) as folder:
            folder.write_case(case)
            data = {"mach": 0.3, "slosh": "none", "free_cycles": 20.0, "speeds": speeds}
            folder.write_result(data | {"provenance": provenance(HASHES)})
        return tmp_path / name

    return write


@pytest.fixture
def sweep_run(tmp_path: Path) -> Callable[..., Path]:
    """Return a function that writes the points of a sweep: name, V_f → march (None: the point failed before its first step)."""

    def write(name: str, marches: dict[float, March | None]) -> Path:
        folder = tmp_path / name / "points"
        folder.mkdir(parents=True)
        for n, (V_f, of) in enumerate(marches.items()):
            record = point_file.Record(
                id=f"{n:016x}", kind="point", overrides={"flutter.V_f": V_f},
                status="done" if of else "failed", determined=bool(of),
                result=summary.march_data(of) if of else None, cause="" if of else "made to fail", traceback="", attempts=1,
                worker="w", cpu_seconds=1.0 + n, wall_seconds=1.0, started=0.0, finished=1.0,
            )  # fmt: skip
            content = point_file.pack(record, [of] if of else [], provenance(HASHES))
            (folder / f"{record.id}.nc").write_bytes(content)
        return tmp_path / name

    return write


@pytest.fixture
def nudged() -> Callable[..., March]:
    """Return a function: a copy of a march with `by` added to a channel from sample `start` on."""

    def nudge(of: March, channel: str, start: int, by: float) -> March:
        other = copy.deepcopy(of)
        other.history[channel] = other.history[channel].copy()
        other.history[channel][start:] += by
        return other

    return nudge
