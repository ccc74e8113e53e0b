"""The programs in docs/ssp.md run as they stand."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from aeroslosh.master.ssp import archive, system

sys.path.insert(0, str(Path(__file__).parent))
from ssp_marches import ROOT, Fmu, files, small

BLOCKS = re.findall(r"```python\n(.*?)```", (ROOT / "docs" / "ssp.md").read_text(encoding="utf-8"), re.DOTALL)


@pytest.fixture(scope="module")
def folder(fmu: Fmu, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with wing.ssp, on a coarse mesh."""
    case = small("ems")
    place = tmp_path_factory.mktemp("docs")
    archive.write(system.from_case(case, files(fmu, case)), place / "wing.ssp")
    return place


@pytest.mark.parametrize("block", BLOCKS, ids=["fmpy", "libcosim", "ecos"])
def test_program(block: str, folder: Path) -> None:
    """It ends well and prints a time and a pitch that has moved."""
    paths = [str(Path(sys.prefix) / "lib"), os.environ.get("LD_LIBRARY_PATH", "")]
    done = subprocess.run(
        [sys.executable, "-c", block + "\nimport os, sys\nsys.stdout.flush()\nos._exit(0)"],
        cwd=folder,
        text=True,
        capture_output=True,
        env={**os.environ, "LD_LIBRARY_PATH": os.pathsep.join(p for p in paths if p)},
        timeout=120,
    )
    assert done.returncode == 0, f"{done.stdout}\n{done.stderr}"
    time, alpha = (float(word.strip("[],")) for word in done.stdout.splitlines()[-1].split())
    assert time >= 0.09 and 1e-5 < abs(alpha) < 0.1
