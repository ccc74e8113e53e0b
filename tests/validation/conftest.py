"""A flutter march or boundary through the FMUs and the master, as a user runs them."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from support.processes import command

Run = Callable[..., dict[str, Any]]


@pytest.fixture(scope="session")
def aeroslosh(tmp_path_factory: pytest.TempPathFactory, fmu: Callable[[str], Path]) -> Run:
    """Return a function: command line of aeroslosh on the Isogai A case -> its JSON, with the run's folder."""
    fmus = tmp_path_factory.mktemp("fmus_of_runs")
    for name in ("structure", "aero"):
        shutil.copy(fmu(name), fmus)

    def run(*arguments: str) -> dict[str, Any]:
        folder = tmp_path_factory.mktemp("run") / "out"
        common = ("--json", "--no-pictures", "--out", folder, "--fmus", fmus)
        done = command(arguments[0], "cases/isogai_a.toml", *arguments[1:], *common)
        assert done.returncode in (0, 4), done.stderr
        return {**json.loads(done.stdout), "folder": folder}

    return run
