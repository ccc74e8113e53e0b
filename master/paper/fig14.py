"""Figure 14: the paper's surrogate on its excitation, in its measure, and what that measure is worth."""

from __future__ import annotations

import time
from typing import Any, NamedTuple

import numpy as np

from ..pictures import canvas, look
from .claims import Claim, at_most
from .outcome import Outcome, Table
from .surrogate import (
    SAMPLES,
    SHOWN,
    SIZES,
    STEP,
    TRAINED,
    WALLS,
    WEIGHT,
    Feedback,
    Samples,
    chosen,
    motion,
    nrmse,
    percent,
    prediction_seconds,
    predictions,
    records,
    train,
)
from .work import Work

ERROR = 8.0  # [%], section IV C
STYLES = {"one step": (look.ORANGE, "-"), "free run": (look.PURPLE, "--")}


class Row(NamedTuple):
    """Errors of the wall forces on samples 901 to 1000, mean over both walls and all seeds [%]."""

    variant: str
    model: str
    mode: str
    percent: float
    nrmse: float


def make(work: Work) -> Outcome:
    """Networks of three seeds, linear feedback, and what needs no model, on two excitations."""
    samples = records(work)
    sizes = work.pick(SIZES, (30,))
    begin = time.process_time()
    nets = {key: chosen(s, key[1], sizes) for key, s in samples.items()}
    training = (time.process_time() - begin) / len(nets)
    rows = compared(samples, nets)
    first = next(iter(samples))
    costs = {"flow": samples[first].cpu / SAMPLES, "training": training}
    costs["surrogate"] = prediction_seconds(nets[first]["one step"], samples[first], work.pick(200, 3)) / (SAMPLES - TRAINED)
    work.shared("surrogate_costs", lambda: costs)
    claims = [judged(rows)]
    size = np.abs(WEIGHT * samples[first].loads[TRAINED:, WALLS])
    one = {r.model: r for r in rows if r.variant == SHOWN[0]}
    remarks = [
        f"the measure says little: a constant (the mean of samples 1 to 900) scores {one['mean load'].percent:.2g} % in pitch, "
        f"for the force of {size.mean():.1f} N/m, mostly hydrostatic, is in the denominator and its standard deviation is "
        f"{size.std(axis=0).mean():.1f} N/m",
        *(f"{r.variant}: {r.model}, {r.mode}: {r.percent:.2g} % in the paper's measure, NRMSE {r.nrmse:.3g} %" for r in rows),
        "a flutter march needs the free run, which the paper does not show",
    ]
    conditions = [
        "our two-phase tank (100 x 30 cells, water) for the paper's; amplitudes of our Fig. 11 (a): 0.636° and, where both "
        "move, 10.2 mm; N = 2 samples of 0.02 s; a change of level takes a sample (at rest) or half a period of 100 rad/s "
        "(moving)",
        "5 and 3 delays; size, spread and ridge by samples 801 to 900; three seeds; the picture is of pitch, seed 1",
    ]
    tables = {"errors": Table(Row._fields, rows), "walls": walls(samples[first], nets[first])}
    return Outcome(claims, conditions, tables, lambda: draw(samples[first], nets[first], first), remarks)


def judged(rows: list[Row]) -> Claim:
    """The paper's sentence on its error: pitch, one step ahead."""
    found = next(r.percent for r in rows if (r.variant, r.model, r.mode) == (SHOWN[0], "rbf", "one step"))
    what = "mean |error/force| on both walls, one step ahead, samples 901 to 1000"
    return at_most(what, "section IV C, Fig. 14", ERROR, found, "", " %")


def compared(samples: dict[tuple[str, int], Samples], nets: dict[tuple[str, int], dict[str, Feedback]]) -> list[Row]:
    """Rows by excitation, model and mode."""
    single: dict[tuple[str, str, str], list[tuple[float, float]]] = {}
    for (variant, seed), s in samples.items():
        y = s.loads
        found = {("rbf", mode): predictions(net, s.u, y)[mode] for mode, net in nets[variant, seed].items()}
        found |= {("arx", mode): loads for mode, loads in predictions(train(s), s.u, y).items()}
        found["last load", "one step"] = np.vstack([y[:1], y[:-1]])
        found["mean load", "free run"] = np.tile(y[:TRAINED].mean(axis=0), (SAMPLES, 1))
        true = y[TRAINED:, WALLS]
        for (model, mode), loads in found.items():
            mine = loads[TRAINED:, WALLS]
            errors = float(np.mean(percent(mine, true))), float(np.mean(nrmse(mine, true)))
            single.setdefault((variant, model, mode), []).append(errors)
    return [Row(*key, *(float(v) for v in np.mean(values, axis=0))) for key, values in single.items()]


def walls(s: Samples, nets: dict[str, Feedback]) -> Table:
    """Forces on both walls, by the flow and the network [N/m]."""
    found = {mode: WEIGHT * predictions(net, s.u, s.loads)[mode][:, WALLS] for mode, net in nets.items()}
    header = ("sample", "pitch [rad]", "west [N/m]", "east [N/m]", *(f"{w}, {m} [N/m]" for m in found for w in ("west", "east")))
    columns = [s.u[:, 1], *(WEIGHT * s.loads[:, WALLS]).T, *(c for f in found.values() for c in f.T)]
    return Table(header, [(k + 1, *(float(c[k]) for c in columns)) for k in range(SAMPLES)])


def draw(s: Samples, nets: dict[str, Feedback], key: tuple[str, int]) -> Any:
    """As the paper's: input, forces on both walls, and the last 100 samples with their errors."""
    y, k, moved = s.loads, np.arange(1, SAMPLES + 1), motion(*key)
    found = {mode: predictions(net, s.u, y)[mode] for mode, net in nets.items()}
    figure, axes = canvas.subplots(5, 1, figsize=(10, 13), layout="constrained")
    axes[0].plot(moved.times / STEP + 1, np.degrees(moved.motions[:, 3]), color=look.INK, lw=0.7)
    axes[0].set(ylabel="pitch, nose-up [deg]", title="(a) the tank's motion", xlim=(0, SAMPLES))
    for whole, zoom, column, wall in ((1, 3, 1, "east"), (2, 4, 0, "west")):
        for place in (whole, zoom):
            axis, thin = axes[place], place == whole
            axis.plot(k, WEIGHT * y[:, column], color=look.SKY, lw=1.0 if thin else 2.2, label="two-phase flow")
            for mode, (colour, line) in STYLES.items():
                axis.plot(
                    k, WEIGHT * found[mode][:, column], line, color=colour, lw=0.7 if thin else 1.2, label=f"network, {mode}"
                )
            axis.set(ylabel=f"force on the {wall} wall [N/m]")
        axes[whole].set(title=f"({'abc'[whole]}) {wall} wall: trained on the first {TRAINED} samples (dotted)", xlim=(0, SAMPLES))
        axes[whole].axvline(TRAINED + 0.5, color=look.GREY, lw=1, ls=":")
        last, mean_load = y[TRAINED:, column], y[:TRAINED, column].mean()
        known = {mode: found[mode][TRAINED:, column] for mode in STYLES} | {"a constant": np.full(len(last), mean_load)}
        words = ", ".join(f"{name} {percent(f, last).mean():.2f} %" for name, f in known.items())
        axes[zoom].set(title=f"({'abcde'[zoom]}) {wall} wall, mean |error/force|: {words}", xlim=(TRAINED + 1, SAMPLES))
        span = last.max() - last.min()
        axes[zoom].set_ylim(WEIGHT * (last.min() - 0.3 * span), WEIGHT * (last.max() + 0.3 * span))
    axes[-1].set_xlabel("sample of 0.02 s [–]")
    figure.suptitle("Fig. 14: two-phase slosh and the paper's surrogate, tank in pitch alone", fontsize=11)
    canvas.legend(figure, axes[1])
    return figure
