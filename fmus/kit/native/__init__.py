"""The shared library of the FMUs: `fmi2.c`, compiled by `compile`, and `find_python.py`, which it asks a Python to run."""

from pathlib import Path

HERE = Path(__file__).resolve().parent
SOURCE = HERE / "fmi2.c"
LIBRARY = HERE / "linux64" / "fmi2.so"
RECORD = HERE / "linux64" / "built.json"
ASKED = HERE / "find_python.py"
