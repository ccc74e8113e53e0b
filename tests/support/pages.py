"""The pages whose snippets run, and running one."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

from .processes import supported
from .snippets import RUN as LANGUAGES
from .snippets import blocks, missing

ROOT = Path(__file__).parents[2]
FMUS = ("structure", "aero", "slosh_ems", "slosh_rbf", "slosh_vof")
RUN = [
    "README.md",
    "docs/python.md",
    *sorted(str(p.relative_to(ROOT)) for folder in ("tutorials", "howto") for p in (ROOT / "docs" / folder).glob("*.md")),
]


def run(page: str, folder: Path, fmu: Callable[[str], Path], programs: Path | None = None, slow: bool = False) -> None:
    """Run the blocks of a page in `folder`, whose dist/fmus holds the FMUs; slow ones too where `slow`.

    programs: a folder to be first on the path (`warm_command.served`)"""
    work = folder / "work"
    (work / "dist" / "fmus").mkdir(parents=True)
    for name in FMUS:
        (work / "dist" / "fmus" / f"{name}.fmu").symlink_to(fmu(name))
    found = [b for b in blocks(ROOT / page, page) if b.kind != "skip" and (slow or not b.slow)]
    steps, results = folder / "steps.json", folder / "results.json"
    steps.write_text(json.dumps([{"kind": b.kind, "text": b.text, "place": b.place, "name": b.name} for b in found]))
    first = [] if programs is None else [str(programs)]
    bin_folder = os.pathsep.join([*first, str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    environment = supported(AEROSLOSH_FMUS=str(work / "dist" / "fmus"), PATH=bin_folder, MPLBACKEND="Agg")
    words = [sys.executable, "-m", "support.run_page", str(steps), str(results)]
    done = subprocess.run(words, cwd=work, env=environment, capture_output=True, text=True, timeout=3600)
    assert results.is_file(), f"exit code {done.returncode}\n{done.stdout}\n{done.stderr}"
    for block, result in zip(found, json.loads(results.read_text()), strict=False):
        assert result["well"], f"{block.place} ended badly:\n{result['printed']}\n{done.stderr}"
        if block.shown is not None and block.kind in LANGUAGES:
            line = missing(block.shown, result["printed"])
            assert line is None, f"{block.place} does not print\n{line}\nbut\n{result['printed']}"
