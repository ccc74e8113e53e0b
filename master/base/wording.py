"""Numbers with their uncertainty, as people read them."""

from __future__ import annotations

from typing import Any


def plus_minus(value: float, uncertainty: float, digits: int = 5) -> str:
    """`value ± uncertainty`; a small uncertainty keeps one digit instead of becoming 0."""
    small = uncertainty < 0.5 * 10.0**-digits
    return f"{value:.{digits}f} ± " + (f"{uncertainty:.0e}" if small else f"{uncertainty:.{digits}f}")


def counted(n: int, noun: str) -> str:
    """`n` of something whose plural ends in s or, after ch, in es: "1 march", "3 marches"."""
    return f"{n} {noun}" if n == 1 else f"{n} {noun}{'es' if noun.endswith('ch') else 's'}"


def error_bar(crossing: dict[str, Any]) -> list[str]:
    """What a crossing's error bar is made of (its data from `outcome`), when more was asked for than the search tells by itself.

    Standard deviations bare, changes of V_f with their sign."""
    parts, missing, grids = crossing["uncertainty_parts"], crossing["uncertainty_missing"], crossing["richardson"]
    lines = []
    if missing or set(parts) & {"step", "amplitude", "mesh", "discretisation", "model"}:
        texts = [
            f"{name} {value:.4f}" if name in ("fit", "interpolation") else f"{name} {value:+.4f}" for name, value in parts.items()
        ]
        absent = f"; not in it: {', '.join(missing)}" if missing else ""
        lines.append(f"error bar of {crossing['V_f']:.4f}: {', '.join(texts)}{absent}")
    if grids is not None:
        values = ", ".join(f"{v:.4f} ({a} x {n})" for v, (a, n) in zip(grids["values"], grids["cells"], strict=True))
        order = grids["behaviour"] if grids["order"] is None else f"order {grids['order']:.2f}"
        used = f", used {grids['order_used']:.2f}" if grids["order_used"] != grids["order"] else ""
        gci = f"GCI {100.0 * grids['gci']:.2f} %"
        lines.append(f"meshes: V_f {values}: {order}{used}, extrapolated {grids['extrapolated']:.4f}, {gci}")
    return lines
