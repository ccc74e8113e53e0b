"""Whoever computes a point, the numbers stay the same: the command `point`, one worker, several, a cluster that loses one."""

from __future__ import annotations

import json
import shutil
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from scipy.io import netcdf_file

from support.paths import CASES
from support.processes import command, started, until
from support.swept import alive, children, ledger, numbers, run, sweep, times, without_cost

SMALL = (
    "--set", "aero.cells_around=64", "--set", "aero.cells_normal=16", "--set", "flutter.steps_per_cycle=72",
    "--set", "flutter.forced_cycles=1.0", "--set", "flutter.free_cycles=2.0", "--no-pictures",
    "--set", "flutter.companion=false",
)  # fmt: skip


@pytest.fixture(scope="module")
def real_fmus(fmu: Callable[[str], Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with the product's own FMUs."""
    folder = tmp_path_factory.mktemp("real_fmus")
    for name in ("structure", "aero", "slosh_ems"):
        shutil.copy(fmu(name), folder)
    return folder


GENTLE = ("--set", "flutter.forced_amplitude_deg=0.01")  # linear slosh holds
REAL = (*SMALL, *GENTLE, "--grid", "slosh.fill_level=0.3,0.6", "--grid", "flutter.V_f=0.6,0.7,0.8")


@pytest.fixture(scope="module")
def local(real_fmus: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Six points of real FMUs on one worker: setups are used again."""
    out = tmp_path_factory.mktemp("local") / "sweep"
    run(out, real_fmus, *REAL, "--workers", "1", case="paper_s")
    return out


def test_a_sweep_computes_what_point_computes_to_the_last_bit(local: Path, real_fmus: Path, tmp_path: Path) -> None:
    """The last point of the sweep, on a setup that marched two others before, beside `aeroslosh point` alone."""
    label = list(ledger(local))[-1]
    words = ["--vf", "0.8", "--set", "slosh.fill_level=0.6", "--fmus", str(real_fmus), "--out", str(tmp_path / "run"), "--json"]
    done = command("point", CASES / "paper_s.toml", *SMALL, *GENTLE, *words)
    assert done.returncode == 0, done.stderr
    result, histories = numbers(local)[label]
    alone = {key: value for key, value in json.loads(done.stdout).items() if key not in ("defaults", "warnings")}
    assert without_cost(alone) == result
    with netcdf_file(str(tmp_path / "run" / "history.nc"), "r", mmap=False) as file:
        assert {name: np.array(v[:]).tobytes() for name, v in file.variables.items()} == histories


def test_workers_and_recycling_change_no_bit(local: Path, real_fmus: Path, tmp_path: Path) -> None:
    run(tmp_path / "s", real_fmus, *REAL, "--workers", "2", "--recycle", "3", case="paper_s")
    assert numbers(tmp_path / "s") == numbers(local)
    assert len({row["worker"] for row in ledger(tmp_path / "s").values()}) >= 3


# the cluster


def free_port() -> int:
    """A port nobody listens on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@contextmanager
def cluster(folder: Path, workers: int) -> Iterator[tuple[str, list[subprocess.Popen[str]]]]:
    """A Dask scheduler and workers of one thread on loopback: its address, their processes."""
    address = f"tcp://127.0.0.1:{free_port()}"
    dask = [sys.executable, "-m", "dask"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "text": True}
    place = address.removeprefix("tcp://").split(":")
    processes = [
        subprocess.Popen([*dask, "scheduler", "--host", place[0], "--port", place[1], "--no-dashboard"], **quiet)  # type: ignore[call-overload]
    ]
    try:
        for n in range(workers):
            words = ["--nthreads", "1", "--no-nanny", "--no-dashboard", "--local-directory", str(folder / f"worker{n}")]
            processes.append(subprocess.Popen([*dask, "worker", address, *words], **quiet))  # type: ignore[call-overload]
        yield address, processes[1:]
    finally:
        for process in processes:
            process.kill()
            process.wait()


def test_a_cluster_loses_a_worker_and_computes_the_same_bits(local: Path, real_fmus: Path, tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    out = tmp_path / "s"
    with (
        cluster(tmp_path, 2) as (address, workers),
        started(sweep(out, real_fmus, *REAL, "--scheduler", address, case="paper_s")) as m,
    ):
        until(lambda: len(times(out)) >= 1 if out.exists() else 0)
        own = children(workers[0].pid)
        workers[0].kill()
        output, said = m.communicate(timeout=120)
        assert m.returncode == 0 and "6 of 6 points done, 0 failed" in output, (output, said)
        until(lambda: not any(map(alive, own)), 10.0)
    assert numbers(out) == numbers(local)


def test_no_scheduler_is_a_clear_message(flutter_fmus: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed")
    from aeroslosh.master.sweeps import cluster

    monkeypatch.setattr(cluster, "PATIENCE", 0.5)
    with pytest.raises(cluster.AeroSloshError) as caught:
        cluster.DaskPool(f"tcp://127.0.0.1:{free_port()}", [], 1, print)
    assert caught.value.code == 2 and "No Dask scheduler answers" in str(caught.value) and "dask scheduler" in str(caught.value)


def test_another_version_on_a_worker_is_refused() -> None:
    pytest.importorskip("distributed")
    from aeroslosh.master.sweeps import cluster

    what, content = cluster.task(None, cluster.versions() | {"numpy": "1.0"}, 1)  # type: ignore[arg-type]
    assert what == "refused" and "numpy" in content[0] and "(master: 1.0)" in content[0] and content[2]
