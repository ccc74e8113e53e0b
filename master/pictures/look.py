"""How every picture looks: colours, line widths, words of axes and titles.

Colours are those of Okabe and Ito (https://jfly.uni-koeln.de/color/), which people tell apart whatever their colour vision: what
is damped is blue, what grows vermilion, what diverges statically purple; shape or dash says it a second time. Maps of values
rise evenly in lightness (CIE L*): viridis, and for signed values `signed`, blue below zero and orange above, white at zero."""

from __future__ import annotations

from typing import Any

import numpy as np

BLUE, ORANGE, PURPLE, SKY, GREY, INK = "#0072B2", "#D55E00", "#8E4C9E", "#56B4E9", "#6B6B6B", "#1B2733"
VERDICTS = {
    "damped": BLUE, "flutter": ORANGE, "divergence": PURPLE, "neutral": INK, "limit cycle": SKY, "undetermined": GREY,
}  # fmt: skip
MARKS = {"damped": "o", "flutter": "s", "divergence": "^", "neutral": "D", "limit cycle": "P", "undetermined": "v"}
CROSSINGS = {"onset": ORANGE, "recovery": BLUE, "divergence": PURPLE, "end of divergence": PURPLE}  # of what is above it
CROSSING_MARKS = {"onset": "o", "recovery": "D", "divergence": "^", "end of divergence": "v"}
EVEN = "viridis"  # of values without a sign
STYLE: dict[Any, Any] = {
    "font.size": 10,
    "axes.labelsize": 10.5,
    "axes.titlesize": 11,
    "legend.fontsize": 9,
    "figure.dpi": 150,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.alpha": 0.25,
    "lines.linewidth": 1.3,
    "savefig.bbox": "tight",
    "legend.frameon": False,
    "axes.axisbelow": True,
}
MACH, SPEED_INDEX = "Mach number [–]", "flutter speed index $V_f = U/(b\\,\\omega_\\alpha\\sqrt{\\mu})$ [–]"
GROWTH, FREQUENCY = "growth rate $\\sigma/\\omega_\\alpha$ [–]", "frequency $\\omega/\\omega_\\alpha$ [–]"
ENDS = ((34.0, 10.0, -44.0), (97.0, 0.0, 0.0), (34.0, 36.0, 42.0))  # CIE L*a*b* of lowest, zero, highest value, all inside sRGB


def signed(n: int = 255) -> np.ndarray:
    """Colours from -1 to 1: blue, nearly white, brown-orange, straight lines in CIE L*a*b*. Shape: (n, 3), sRGB 0 to 1."""
    places = np.linspace(-1.0, 1.0, n)
    lab = np.stack([np.interp(places, (-1.0, 0.0, 1.0), [end[i] for end in ENDS]) for i in range(3)], axis=1)
    return np.clip(_srgb(lab), 0.0, 1.0)


def plain_decades(axis: Any) -> None:
    """Ticks of a logarithmic axis at 1, 2, 5 of each decade, as plain numbers."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def signed_map() -> Any:
    """`signed` as matplotlib takes it."""
    from matplotlib.colors import ListedColormap

    return ListedColormap(signed(), name="signed")


def words(name: str) -> str:
    """A key of a case as an axis names it: `slosh.fill_level` → "fill level (depth over tank height) [–]"."""
    from ..case.case import TABLES

    plain = SPOKEN.get(name)
    table, _, key = name.partition(".")
    if plain is None and table in TABLES and key in TABLES[table].__dataclass_fields__:
        rule = TABLES[table].__dataclass_fields__[key].metadata
        unit = "–" if rule.get("unit", "1") == "1" else rule["unit"]
        plain = f"{key.removesuffix('_deg').replace('_', ' ')} [{unit}]"
    return plain or f"{key.rpartition('.')[2].replace('_', ' ') or name}"


SPOKEN = {
    "mach": MACH,
    "flow.mach": MACH,
    "flutter.V_f": "flutter speed index $V_f$ [–]",
    "V_f": "flutter speed index $V_f$ [–]",
    "slosh.fill_level": "fill level (depth over tank height) [–]",
    "slosh.tank_x": "tank's centre aft of the elastic axis [m]",
    "slosh.tank_y": "tank's centre above the elastic axis [m]",
    "section.mass_ratio": "mass ratio $\\mu$ [–]",
    "flutter.forced_amplitude_deg": "amplitude of the forced pitch [deg]",
    "flow.altitude": "pressure altitude [m]",
    "slosh.model": "slosh model",
}


def _srgb(lab: np.ndarray) -> np.ndarray:
    """CIE L*a*b* (D65) → sRGB (IEC 61966-2-1), shapes (n, 3)."""
    f = np.stack([(lab[:, 0] + 16.0) / 116.0] * 3, axis=1)
    f[:, 0] += lab[:, 1] / 500.0
    f[:, 2] -= lab[:, 2] / 200.0
    xyz = np.where(f > 6.0 / 29.0, f**3, 3.0 * (6.0 / 29.0) ** 2 * (f - 4.0 / 29.0)) * (0.95047, 1.0, 1.08883)
    to_rgb = np.array(
        [[3.2404542, -1.5371385, -0.4985314], [-0.9692660, 1.8760108, 0.0415560], [0.0556434, -0.2040259, 1.0572252]]
    )
    linear = np.clip(xyz @ to_rgb.T, 0.0, None)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)


def even(n: int) -> list[Any]:
    """`n` colours of the even map, its lightest end left out: it does not show on white."""
    import matplotlib

    return [matplotlib.colormaps[EVEN](float(x)) for x in np.linspace(0.0, 0.85, max(1, n))]
