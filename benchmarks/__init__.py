"""Benchmarks: `python -m benchmarks` (make bench). Medians of CPU time of several runs in one process."""

import master  # noqa: F401  one thread for linear algebra, as in the command line
