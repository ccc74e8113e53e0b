"""Error of the paper's network over all pairs of input and output delays; `aeroslosh paper fig13` varies one at a time.

`python -m studies.rbf_delays [--records FOLDER] [--csv FILE]`. Records of `studies.rbf_experiment`: two of its excitations, three
seeds, Gaussians of one kind, fitted on samples 1 to 900, judged on the wall forces of 901 to 1000.
"""

from __future__ import annotations

import itertools

from aeroslosh.master.paper.fig13 import CURVES, INPUT_DELAYS, OUTPUT_DELAYS, Row, study
from aeroslosh.master.paper.surrogate import DELAYS, SHOWN

from .rbf_experiment import arguments, records, write


def summary(rows: list[Row]) -> None:
    """Print where the least error is, and what the paper's delays give."""
    print("| excitation | network | paper's delays (5, 3): NRMSE | least NRMSE | at |\n|---|---|---|---|---|")
    for variant, (model, mode) in itertools.product(SHOWN, CURVES):
        mine = [row for row in rows if (row.variant, row.model, row.mode) == (variant, model, mode)]
        best = min(mine, key=lambda row: row.nrmse)
        own = next(row for row in mine if (row.input_delay, row.output_delay) == DELAYS)
        place = f"({best.input_delay}, {best.output_delay})"
        print(f"| {variant} | {model}, {mode} | {own.nrmse:.3g} % | {best.nrmse:.3g} % | {place} |")


def main() -> None:
    """Study, table, data."""
    options = arguments().parse_args()
    samples = {key: s for key, (s, _) in records(options.records, options.fmus).items() if key[0] in SHOWN}
    rows = study(samples, itertools.product(INPUT_DELAYS, OUTPUT_DELAYS))
    summary(rows)
    if options.csv:
        write(options.csv, rows, Row._fields)


if __name__ == "__main__":
    main()
