"""The FMUs' shared library `fmi2.c`, compiled by `compile`, and what goes with it.

`find_python.py` is what the library asks a Python to run; `try_fmu.c` is a program that is no Python and tries an FMU.
"""

from pathlib import Path

HERE = Path(__file__).resolve().parent
SOURCE, LIBRARY = HERE / "fmi2.c", HERE / "linux64" / "fmi2.so"
TRIED, TRY = HERE / "try_fmu.c", HERE / "linux64" / "try_fmu"
RECORD = HERE / "linux64" / "built.json"
ASKED = HERE / "find_python.py"
