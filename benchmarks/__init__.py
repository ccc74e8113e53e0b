"""Benchmarks: `python -m benchmarks` (make bench). Medians of CPU time of several runs in one process."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the command line does, before numpy is loaded
