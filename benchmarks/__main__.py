"""Runs every benchmark and prints its table."""

from __future__ import annotations

import os
import sys

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the command does; before numpy is loaded

from . import border, exchange, flutter_point, kernels, slosh_vof, sweep

if __name__ == "__main__":
    for benchmark in (kernels, border, exchange, flutter_point, slosh_vof, sweep):
        print(f"\n{benchmark.__doc__.splitlines()[0] if benchmark.__doc__ else benchmark.__name__}")
        benchmark.run()
    sys.stdout.flush()
    os._exit(0)  # the trivial FMUs are pythonfmu's own, which may not survive an ordinary end
