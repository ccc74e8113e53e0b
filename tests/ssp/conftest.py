"""Tools that load archives, each run in a process of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))
from ssp_marches import Host


@pytest.fixture(scope="session")
def host(tmp_path_factory: pytest.TempPathFactory) -> Host:
    """`host(tool, archive, dt, steps, signals)` runs hosts.py: values after each step. Shape: (steps, signals)."""
    folder, script = tmp_path_factory.mktemp("hosts"), Path(__file__).with_name("hosts.py")

    def run(tool: str, archive: Path, dt: float, steps: int, signals: Sequence[str]) -> np.ndarray:
        out = folder / "values.npz"
        out.unlink(missing_ok=True)
        # ecos needs oneTBB, which pip puts into the environment's lib folder, where no loader looks
        paths = [str(Path(sys.prefix) / "lib"), os.environ.get("LD_LIBRARY_PATH", "")]
        done = subprocess.run(
            [sys.executable, str(script), tool, str(archive), repr(dt), str(steps), json.dumps(list(signals)), str(out)],
            text=True,
            capture_output=True,
            env={**os.environ, "LD_LIBRARY_PATH": os.pathsep.join(p for p in paths if p)},
            timeout=300,
        )
        assert done.returncode == 0, f"{tool}: exit code {done.returncode}\n{done.stdout}\n{done.stderr}"
        return np.asarray(np.load(out)["values"])

    return run
