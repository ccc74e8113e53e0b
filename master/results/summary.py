"""Results as data: the JSON that other programs read, and the summary that people read."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..analysis.damping import Mode
from ..analysis.verdict import Verdict
from ..base.wording import counted, error_bar, plus_minus
from ..boundary import modes as boundary_modes
from ..boundary.search import BoundaryPoint
from ..case.fuel_tank import EDGE, LABEL, averaged, broken
from ..flutter.coarse_marches import PARTS, Change
from ..flutter.march import March
from . import by_value, trust, wave_growth


def number(value: float | None) -> float | None:
    """JSON has no nan or infinity."""
    return None if value is None or not math.isfinite(value) else float(value)


def march_data(march: March, steady_cpu: float | None = None, change: Change | None = None) -> dict[str, Any]:
    """One march. Growth rate and frequency in units of omega_alpha; cost in seconds. `change`: of the coarse
    marches by which the error bars of `march` were widened, their cost and what they could not tell."""
    s, fit, cost = march.scales, march.fit, march.cost
    # a divergence that the steady flow tells and no fit shows yet: the rate of an oscillation beside it would say stable
    read = fit if fit is not None and not (march.verdict is Verdict.DIVERGENCE and fit.frequency) else None
    validity, edge, stands = trust.validity(march), trust.edge(march), trust.stands(march)
    change = change or Change()
    data: dict[str, Any] = {
        "mach": s.mach,
        "V_f": s.V_f,
        "slosh": march.slosh,
        "slosh_validity": number(validity),
        **({} if edge == EDGE else {"slosh_validity_edge": edge}),
        "slosh_holds": None if validity is None else stands,
        "verdict": str(trust.verdict(march)),
        "motion_verdict": str(march.verdict),
        "reason": march.reason if validity is None or stands else f"{broken(validity, edge)}: {march.reason}",
        "remedy": (march.remedy or None) if stands else trust.remedy(march),
        "growth_rate": number(read.growth_rate) if read else None,
        "growth_rate_uncertainty": number(read.growth_rate_uncertainty) if read else None,
        "frequency": number(read.frequency) if read else None,
        "frequency_uncertainty": number(read.frequency_uncertainty) if read else None,
        "damping_ratio": number(-read.growth_rate / read.frequency) if read and read.frequency else None,
        "settled": march.settled,
        "free_cycles": max(0, march.tau.size - 1 - march.release) / s.steps_per_cycle,
        "modes": [_mode_data(m) for m in (fit.modes if fit else [])],
        "real_poles": [_mode_data(m) for m in (fit.reals if fit else [])],
        "static_stiffness": number(march.stiffness),
        "limit_cycle_amplitude_deg": limit_cycle_amplitude_deg(march),
        "fit_residual": number(fit.residual) if fit else None,
        "fit_forecast": number(fit.forecast) if fit else None,
        "uncertainty_parts": fit.contributions if fit else {},
        "uncertainty_missing": list(change.missing),
        "waves": wave_growth.of_march(march),
        "ensemble": march.ensemble.as_data() if march.ensemble is not None else None,
        "omega_alpha": s.omega_alpha,
        "speed": s.speed,
        "by_value": by_value.of_march(s),
        "steps": cost.steps,
        "steps_per_cycle": s.steps_per_cycle,
        "unconverged_steps": march.unconverged,
        "scheme": march.scheme,
        "stopped": march.stopped or None,
        "note": march.note or None,
        "failure": march.failure.what if march.failure else None,
        "cost": {
            "wall_seconds": cost.wall,
            "cpu_seconds": cost.total_cpu,
            "cpu_seconds_by_component": cost.cpu,
            "master_share": cost.master_share,
        },
    }
    if steady_cpu is not None:
        data["cost"]["steady_cpu_seconds"] = steady_cpu
    if change.marches:
        data["cost"]["companion_cpu_seconds"] = change.steady_cpu + sum(m.cost.total_cpu for m in change.marches)
    return data


def _mode_data(mode: Mode) -> dict[str, float]:
    return {"growth_rate": mode.growth_rate, "frequency": mode.frequency, "share": mode.share}


def limit_cycle_amplitude_deg(march: March) -> float | None:
    """Half the pitch from peak to peak in the last period of a march that ends in a limit cycle, else None. [deg]"""
    if march.verdict is not Verdict.LIMIT_CYCLE or march.fit is None or not march.fit.frequency:
        return None
    last = march.history["alpha"][march.tau > march.tau[-1] - 2.0 * math.pi / march.fit.frequency]
    return number(math.degrees(0.5 * float(np.ptp(last))))


def linear_data(point: BoundaryPoint) -> dict[str, Any] | None:
    """The linear model of a Mach number with its crossings and what became of them; None without one."""
    model = point.linear
    if model is None:
        return None
    return {
        "amplitude_deg": model.amplitude_deg,
        "fit_error": [number(float(e)) for e in model.fit_error],
        "check_error": [number(float(e)) for e in model.check_error],
        "note": model.note or None,
        "liquid": "none" if model.liquid is None else "frozen",
        "steps": model.steps,
        "steady_slopes": None if model.slopes is None else {"C_L": model.slopes.C_L, "C_M": model.slopes.C_M},
        "modes": boundary_modes.as_data(model, *model.case.boundary.V_f_range),
        "cost": {"wall_seconds": model.wall, "cpu_seconds": model.cpu},
        "crossings": [
            {
                "V_f": p.crossing.V_f,
                "V_f_uncertainty": number(p.crossing.uncertainty),
                "frequency": p.crossing.frequency,
                "kind": p.crossing.kind,
                "direction": p.crossing.direction,
                "slope": p.crossing.slope,
                "reduced_frequency": p.crossing.reduced_frequency,
                "state": p.state,
                "marched_V_f": p.marched.V_f if p.marched else None,
                "text": p.text,
            }
            for p in point.predictions
        ],
    }


def point_data(point: BoundaryPoint) -> dict[str, Any]:
    """One Mach number of a boundary. `V_f`, `frequency` are the lowest onset's (or the lowest crossing's)."""
    first = min(point.crossings, key=lambda c: (c.direction != "onset", c.V_f), default=None)
    validity, stands = trust.of_point(point.crossings, point.marches), trust.point_stands(point)
    edge = trust.largest_edge(point.marches)
    return {
        "mach": point.mach,
        "V_f": number(first.V_f) if first else None,
        "V_f_uncertainty": number(first.uncertainty) if first else None,
        "growth_rate": 0.0 if first else None,
        "frequency": number(first.frequency) if first else None,
        "verdict": "neutral" if first and stands else "undetermined",
        "kind": first.kind if first else None,
        "by_value": by_value.of_point(point, first.V_f if first else None),
        "static_divergence_V_f": number(point.divergence),
        "outcome": point.outcome if validity is None or stands else f"{point.outcome}; {broken(validity, edge)}",
        "converged": point.converged,
        "slosh_validity": number(validity),
        **({} if edge == EDGE else {"slosh_validity_edge": edge}),
        "slosh_holds": None if validity is None else stands,
        "crossings": [
            {
                "V_f": c.V_f,
                "V_f_uncertainty": number(c.uncertainty),
                "frequency": c.frequency,
                "kind": c.kind,
                "direction": c.direction,
                "slope": c.slope,
                "bracketed": c.bracketed,
                "source": c.source,
                "uncertainty_parts": c.parts,
                "uncertainty_missing": list(c.missing),
                "tolerance_met": c.met,
                "slosh_validity": number(trust.of_crossing(c, point.marches)) if c.source == "march" else None,
                "richardson": c.grids.as_data() if c.grids else None,
                "by_value": by_value.of_crossing(point, c.V_f),
            }
            for c in point.crossings
        ],
        "linear": linear_data(point),
        "marches": [march_data(m) for m in point.marches],
        "cost": {
            "wall_seconds": point.wall,
            "cpu_seconds": sum(m.cost.total_cpu for m in [*point.marches, *point.checks])
            + (point.linear.cpu if point.linear else 0.0),
            "marches": len(point.marches),
            "uncertainty_marches": len(point.checks),
        },
    }


def march_summary(data: dict[str, Any]) -> str:
    """What a person wants to know of one march."""
    lines = [
        f"Mach {data['mach']:g}, V_f {data['V_f']:g}, {LABEL[data['slosh']]}: {data['verdict'].upper()}",
        f"  {data['reason']}",
    ]
    if data["remedy"]:
        lines.append(f"  remedy       {data['remedy']}")
    if data["growth_rate"] is not None:
        ratio = f"   (damping ratio {data['damping_ratio']:+.5f})" if data["damping_ratio"] is not None else ""
        lines.append(f"  growth rate  {plus_minus(data['growth_rate'], data['growth_rate_uncertainty'])}  omega_alpha{ratio}")
        hertz = f"   ({data['frequency'] * data['omega_alpha'] / (2 * math.pi):.3f} Hz)"
        lines.append(
            f"  frequency    {plus_minus(data['frequency'], data['frequency_uncertainty'])}  omega_alpha{hertz}"
            if data["frequency"]
            else "  frequency    0 (static)"
        )
    lines += _error_bar(data)
    if data["ensemble"] is not None and data["ensemble"]["sd"] is not None:
        e = data["ensemble"]
        lines.append(
            f"  members      {len(e['seeds'])} of seeds {e['seeds'][0]} to {e['seeds'][-1]}: one march is ± {e['sd']:.5f}"
        )
    if data["fit_residual"] is not None:
        forecast = f"{100 * data['fit_forecast']:.2g} %" if data["fit_forecast"] is not None else "none"
        poles = f"{counted(len(data['modes']), 'oscillation')} and {counted(len(data['real_poles']), 'real pole')}"
        missed = f"missed {100 * data['fit_residual']:.2g} %, forecast of the last part off by {forecast}"
        lines.append(f"  rests on     {poles} over {data['free_cycles']:.3g} free cycles; {missed}")
    lines += by_value.march_lines(data["by_value"], data["slosh"] != "none")
    lines += wave_growth.lines(data)
    if data["static_stiffness"] is not None:
        lines.append(f"  statics      the steady flow leaves {100 * data['static_stiffness']:.3g} % of the pitch stiffness")
    for kind, count in data["unconverged_steps"].items():
        if count:
            lines.append(f"  note: {kind} iteration not converged in {count} of {data['steps']} steps")
    if data["slosh_holds"] is False:
        lines.append(f"  the motion as computed: {data['motion_verdict']}")
    elif data["slosh_validity"] is not None and data["slosh_validity"] > EDGE:
        lines.append(f"  slosh        {averaged(data['slosh_validity'], data['slosh_validity_edge'])}")
    if data["note"]:
        lines.append(f"  note: {data['note']}")
    if data["stopped"]:
        lines.append(f"  note: {data['stopped']}")
    if data.get("airfoil_summary"):
        lines.append(airfoil_line(data["airfoil_summary"]))
    cost = data["cost"]
    shares = ", ".join(f"{name} {seconds:.2f} s" for name, seconds in cost["cpu_seconds_by_component"].items())
    steady = f", steady start {cost['steady_cpu_seconds']:.1f} s" if "steady_cpu_seconds" in cost else ""
    if "companion_cpu_seconds" in cost:
        steady += f", error bar {cost['companion_cpu_seconds']:.1f} s"
    lines.append(
        f"  cost         {cost['wall_seconds']:.1f} s wall, {cost['cpu_seconds']:.1f} s CPU for "
        f"{data['steps']} steps ({shares}, master {100 * cost['master_share']:.1f} %{steady})"
    )
    return "\n".join(lines)


def _error_bar(data: dict[str, Any]) -> list[str]:
    """What the growth rate's error bar is made of; nothing where no more was asked for than the fit's."""
    told = {name: data["uncertainty_parts"][name] for name in PARTS if name in data["uncertainty_parts"]}
    missing = data["uncertainty_missing"]
    if data["growth_rate"] is None or not (told or missing):
        return []
    fitted = math.hypot(*(value for name, value in data["uncertainty_parts"].items() if name not in PARTS))
    texts = [f"fit {fitted:.1g}", *(f"{name} {value:+.5f}" for name, value in told.items())]
    absent = f"; not in it: {', '.join(missing)}" if missing else ""
    lines = [f"  error bar    {', '.join(texts)}{absent}"]
    if abs(data["growth_rate"]) <= data["growth_rate_uncertainty"]:
        lines.append("  note: the growth rate is within its error bar of 0: growth or decay is not certain here")
    return lines


def airfoil_line(summary: str) -> str:
    """The line that tells of the section."""
    return f"  airfoil      {summary}"


def boundary_summary(points: list[dict[str, Any]]) -> str:
    """The boundary as a table."""
    lines = ["  Mach    V_f              frequency  marches  wall"]  # a divergence has frequency 0
    for p in points:
        if p["slosh_holds"] is False:
            worst = math.inf if p["slosh_validity"] is None else p["slosh_validity"]
            lines.append(f"  {p['mach']:<6.3f}  UNDETERMINED: {broken(worst, p.get('slosh_validity_edge', EDGE))}; as computed:")
        if p["V_f"] is None:
            lines += [f"  {p['mach']:<6.3f}  {p['outcome']}", *by_value.point_lines(p), *_static_lines(p)]
            continue
        value = plus_minus(p["V_f"], p["V_f_uncertainty"], 4)
        lines.append(
            f"  {p['mach']:<6.3f}  {value:<16} {p['frequency']:.4f}     {p['cost']['marches']:<7}  "
            f"{p['cost']['wall_seconds']:.1f} s" + ("" if p["converged"] else "   (tolerance not met)")
        )
        if len(p["crossings"]) > 1:
            lines.append(f"          all: {p['outcome']}")
        lines += [f"          {line}" for c in p["crossings"] for line in error_bar(c)]
        lines += by_value.point_lines(p)
        for c in (p["linear"] or {}).get("crossings", []):
            if c["state"] == "contradicted":
                lines.append(f"          {c['text']}")
        lines += _static_lines(p)
        if (p["linear"] or {}).get("note"):
            lines.append(f"          note: {p['linear']['note']}")
    return "\n".join([*lines, *by_value.matched_lines(points)])


def _static_lines(p: dict[str, Any]) -> list[str]:
    """What two steady solutions alone say of static divergence, and how the other ways agree."""
    V_f = p["static_divergence_V_f"]
    if V_f is None:
        return []
    said = f"          statics: divergence at V_f = {V_f:.4f} by two steady solutions"
    static = [c for c in (p["linear"] or {}).get("crossings", []) if c["kind"] == "divergence"]
    sweeps = [f"± {c['V_f_uncertainty']:.4f}" for c in static]
    marched = [c["V_f"] / V_f - 1.0 for c in p["crossings"] if c["kind"] == "divergence" and c["source"] == "march"]
    said = " ".join([said, *sweeps])
    return ["; ".join([said, *(f"marches {change:+.1%}" for change in marched)])]
