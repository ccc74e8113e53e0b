"""Figure 13: error of the paper's network over its input and output delays, one step ahead and in free run.

`python -m paper.rbf_delays [--records FOLDER] [--csv FILE] [--picture FILE]`. Records and networks of `paper.rbf_experiment`: two
of its excitations, three seeds, Gaussians of one kind, fitted on samples 1 to 900, judged on the wall forces of 901 to 1000.
"""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .rbf_experiment import DELAYS, SEEDS, TRAINED, WALLS, Samples, arguments, nrmse, predictions, records, train, write

STUDIED = ("pitch, at rest", "both, moving")
INPUT_DELAYS, OUTPUT_DELAYS = range(11), range(9)
CENTRES, FACTOR, RIDGE = 100, 8.0, 1e-12
"""Of the networks here: near what validation chooses at delays 5 and 3."""
CURVES = {("rbf", "one step"): "C3o-", ("rbf", "free run"): "C1o--", ("arx", "one step"): "C0.-", ("arx", "free run"): "C4.--"}


class Row(NamedTuple):
    """Errors of both walls, mean over the seeds: of |error/force|, and NRMSE [%]."""

    variant: str
    model: str
    mode: str
    input_delay: int
    output_delay: int
    percent: float
    nrmse: float


def errors(s: Samples, delays: tuple[int, int], seed: int) -> dict[tuple[str, str], tuple[float, float]]:
    """Mean |error/force| and NRMSE [%] by model and mode."""
    out = {}
    true = s.loads[TRAINED:, WALLS]
    for model, net in (("rbf", train(s, delays, seed, CENTRES, FACTOR, RIDGE)), ("arx", train(s, delays))):
        for mode, found in predictions(net, s.u, s.loads).items():
            walls = found[TRAINED:, WALLS]
            out[model, mode] = float(np.mean(100.0 * np.abs(walls / true - 1.0))), float(np.mean(nrmse(walls, true)))
    return out


def study(samples: dict[tuple[str, int], Samples]) -> list[Row]:
    """All delays, variants and models."""
    rows = []
    for variant in STUDIED:
        for delays in itertools.product(INPUT_DELAYS, OUTPUT_DELAYS):
            found = [errors(samples[variant, seed], delays, seed) for seed in SEEDS]
            for model, mode in CURVES:
                values = np.mean([e[model, mode] for e in found], axis=0)
                rows.append(Row(variant, model, mode, *delays, float(values[0]), float(values[1])))
    return rows


def summary(rows: list[Row]) -> None:
    """Print where the least error is, and what the paper's delays give."""
    print("| excitation | network | paper's delays (5, 3): NRMSE | least NRMSE | at |\n|---|---|---|---|---|")
    for variant, (model, mode) in itertools.product(STUDIED, CURVES):
        mine = [row for row in rows if (row.variant, row.model, row.mode) == (variant, model, mode)]
        best = min(mine, key=lambda row: row.nrmse)
        own = next(row for row in mine if (row.input_delay, row.output_delay) == DELAYS)
        place = f"({best.input_delay}, {best.output_delay})"
        print(f"| {variant} | {model}, {mode} | {own.nrmse:.3g} % | {best.nrmse:.3g} % | {place} |")


def draw(rows: list[Row], path: Path) -> None:
    """As the paper's Fig. 13, a row of panels an excitation: over one delay, the other being the paper's."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(len(STUDIED), 2, figsize=(10, 7), layout="constrained", sharey="row")
    for variant, pair in zip(STUDIED, panels, strict=True):
        for side, (axis, name) in enumerate(zip(pair, ("input", "output"), strict=True)):
            for (model, mode), style in CURVES.items():
                mine = [
                    ((row.input_delay, row.output_delay)[side], row.nrmse)
                    for row in rows
                    if (row.variant, row.model, row.mode) == (variant, model, mode)
                    and (row.input_delay, row.output_delay)[1 - side] == DELAYS[1 - side]
                ]
                # a linear network whose own feedback grows has no free run
                x, y = np.array(mine).T
                axis.plot(x, np.where(y < 1e4, y, np.nan), style, mfc="none", label=f"{model}, {mode}")
            axis.axvline(DELAYS[side], color="0.5", lw=1, ls=":")
            other = ("output", "input")[side]
            axis.set(xlabel=f"{name} delay ({other} delay {DELAYS[1 - side]}; dotted: the paper's)", yscale="log", title=variant)
            axis.grid(alpha=0.3, which="both")
        pair[0].set_ylabel("NRMSE of the wall forces [%]")
    panels[0, 0].legend(fontsize=8)
    figure.savefig(path, dpi=100)
    plt.close(figure)
    print(f"picture: {path}")


def main() -> None:
    """Study, table, data, picture."""
    options = arguments().parse_args()
    rows = study(records(options.records, options.fmus))
    summary(rows)
    if options.csv:
        write(options.csv, rows, Row._fields)
    if options.picture:
        draw(rows, options.picture)


if __name__ == "__main__":
    main()
