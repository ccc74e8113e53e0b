"""The notebook in cells, on real FMUs: every cell runs, and says what it should."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

from support.paths import ROOT
from support.processes import supported

SCRIPT = ROOT / "examples" / "first_flutter.py"


def test_every_cell_runs(fmu: Callable[[str], Path], tmp_path: Path) -> None:
    for name in ("structure", "aero", "slosh_ems"):
        (tmp_path / f"{name}.fmu").symlink_to(fmu(name))
    done = subprocess.run(
        [sys.executable, str(SCRIPT)], capture_output=True, text=True, cwd=tmp_path, timeout=500,
        env=supported(AEROSLOSH_FMUS=str(tmp_path), OPENBLAS_NUM_THREADS="1"),
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert re.search(r"Point\(Mach 0\.8, V_f 0\.9: flutter; growth rate \+0\.0", done.stdout)
    assert re.search(r"onset", done.stdout) and "'units': 'rad'" in done.stdout
    # fuel of 13 % of the mass brings flutter forward: at 0.78 only the section with fuel flutters
    assert re.search(r"0\.70?\s+damped\s+damped", done.stdout) and re.search(r"0\.78\s+damped\s+flutter", done.stdout)
    assert re.search(r"largest force [\d.]+ N/m", done.stdout) and "completed" in done.stdout


def test_the_cells_are_those_that_a_notebook_reads() -> None:
    text = SCRIPT.read_text(encoding="utf-8")
    assert text.startswith("# %% [markdown]\n# # ") and text.count("\n# %%") >= 5
