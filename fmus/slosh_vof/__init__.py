"""Two-phase flow in a moving tank: volume of fluid on a staggered grid, plain physics; `fmu.py` is its face."""
