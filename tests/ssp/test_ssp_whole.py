"""What a user would try: `aeroslosh point` and the archive of the same case in every tool, the whole march, nothing made easy."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from aeroslosh.master.results import history_file

sys.path.insert(0, str(Path(__file__).parent))
from ssp_marches import ROOT, Fmu, Host, difference, files, small

JACOBI = ["--set", "coupling.scheme=jacobi", "--set", "coupling.predictor_order=1"]  # as the FMUs extrapolate
SIGNALS = {
    "structure.h": "h", "structure.h_dot": "h_dot", "structure.h_ddot": "h_ddot", "structure.alpha": "alpha",
    "structure.alpha_dot": "alpha_dot", "structure.alpha_ddot": "alpha_ddot", "aero.lift": "lift", "aero.moment": "moment",
    "slosh.force_x": "slosh_force_x", "slosh.force_y": "slosh_force_y", "slosh.moment_residual": "slosh_moment_residual",
}  # fmt: skip


@pytest.fixture(scope="module")
def run(fmu: Fmu, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, float], np.ndarray]:
    """The archive, what the export says of it, and the recorded history of `aeroslosh point`. Shape: (steps + 1, signals)."""
    folder = tmp_path_factory.mktemp("whole")
    (folder / "fmus").mkdir()
    for name, path in files(fmu, small("ems")).items():
        (folder / "fmus" / f"{name}.fmu").symlink_to(path)
    words = [str(ROOT / "cases" / "paper_s.toml"), "--slosh", "ems", "--fmus", str(folder / "fmus"), *JACOBI]

    def command(*arguments: str) -> str:
        done = subprocess.run([sys.executable, "-m", "aeroslosh", *arguments], capture_output=True, text=True, cwd=ROOT)
        assert done.returncode in (0, 4), done.stderr  # 4: linear slosh does not hold at 1 degree, the numbers are the same
        return done.stdout

    command("point", *words, "--no-pictures", "--quiet", "--out", str(folder / "point"))
    said = json.loads(command("export", "ssp", *words, "--out", str(folder / "wing.ssp"), "--json"))
    (record,) = history_file.read(folder / "point" / "history.nc")
    return folder / "wing.ssp", said, np.array([record.values[name] for name in SIGNALS.values()]).T


def test_the_archive_has_the_steps_of_the_march(run: tuple[Path, dict[str, float], np.ndarray]) -> None:
    _, said, march = run
    assert said["steps"] == len(march) - 1
    assert said["stop"] == pytest.approx(said["steps"] * said["step"], rel=1e-15)
    assert said["step"] == round(said["step"] * 1e9) / 1e9


@pytest.mark.parametrize("tool", ["fmpy", "libcosim", "ecos"])
def test_every_tool_marches_to_the_bit_what_the_master_marches(
    run: tuple[Path, dict[str, float], np.ndarray], host: Host, tool: str
) -> None:
    """All motion and loads, forced and free, 602 steps on the case's own mesh and tolerance. The first sample is the start."""
    archive, said, march = run
    found = host(tool, archive, said["step"], int(said["steps"]), list(SIGNALS))
    assert difference(found, march[1:]) == 0.0
