"""Records of a tank: kept whole, not computed twice, the same bits from any number of processes."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from aeroslosh.fmus.slosh_rbf.training.dataset import LOADS, DatasetError, Planned, Progress, generate, load, read
from aeroslosh.fmus.slosh_rbf.training.excitation import aprbs
from aeroslosh.fmus.slosh_rbf.training.plan import settings
from aeroslosh.fmus.slosh_rbf.training.signals import instants
from aeroslosh.fmus.tank.frozen import frozen_load
from aeroslosh.fmus.tank.liquid import Tank
from aeroslosh.fmus.tank.motion import SectionMotion
from aeroslosh.master.base.errors import AeroSloshError
from aeroslosh.master.results.history_file import read as read_history
from aeroslosh.master.training.tank_records import LINEAR_LOADS, Drive
from support import record_doubles
from support.processes import supported
from support.record_doubles import TIMES, fragile, fragile_plan, plan, weigh

MODEL = {"is": "a double"}


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Six records, by one process."""
    folder = tmp_path_factory.mktemp("made")
    generate(plan(), folder, weigh, MODEL)
    return folder


def test_a_record_holds_motion_loads_and_provenance(made: Path) -> None:
    records = load(made)
    assert len(records) == 6 and load(made, "train") and not load(made, "test")
    for record, entry in zip(records, plan(), strict=True):
        assert np.array_equal(record.motion.motions, entry.motion.motions) and np.array_equal(record.motion.times, TIMES)
        assert (record.motion.name, record.motion.kind, record.motion.seed) == (entry.motion.name, "aprbs", entry.motion.seed)
        assert record.motion.parameters == entry.motion.parameters and record.parameters == {"gain": 2.0}
        assert record.split == "train" and record.path == made / f"{entry.motion.name}.nc"
        loads = weigh(entry.parameters, TIMES, entry.motion.motions)
        for name, values in loads.items():
            np.testing.assert_allclose(record.loads[name], values, rtol=1e-12, atol=1e-12)
        about = record.attributes
        assert about["model"] == MODEL and about["versions"]["numpy"] == np.__version__ and about["cpu_s"] > 0.0
    # the same file is a history for the master's own commands
    (history,) = read_history(records[0].path)
    assert history.units["alpha_ddot"] == "rad/s2" and history.units["force_y"] == "N/m" and history.units["moment"] == "N"
    assert not list(made.glob(".*"))


def test_parallel_equals_serial_to_the_bit(made: Path, tmp_path: Path) -> None:
    generate(plan(), tmp_path, weigh, MODEL, workers=3)
    for one, other in zip(load(made), load(tmp_path), strict=True):
        assert one.motion.name == other.motion.name
        assert one.attributes["data_sha256"] == other.attributes["data_sha256"]


def test_what_is_there_is_not_computed_again(made: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def no_process(*_: object, **__: object) -> None:
        raise AssertionError("a process was started")

    before = {path: path.stat().st_mtime_ns for path in made.iterdir()}
    steps: list[Progress] = []
    monkeypatch.setattr("multiprocessing.process.BaseProcess.start", no_process)
    paths = generate(plan(), made, weigh, MODEL, progress=steps.append)
    assert paths == [made / f"aprbs_{k}.nc" for k in range(1, 7)] and not steps
    assert {path: path.stat().st_mtime_ns for path in made.iterdir()} == before


def test_damaged_and_other_records_are_computed_again(tmp_path: Path) -> None:
    generate(plan(4), tmp_path, weigh, MODEL)
    cut, flipped, other, whole = sorted(tmp_path.glob("*.nc"))
    good = {path: read(path).attributes["data_sha256"] for path in (cut, flipped, other, whole)}
    cut.write_bytes(cut.read_bytes()[:5000])
    data = bytearray(flipped.read_bytes())
    data[-2000] ^= 1
    flipped.write_bytes(bytes(data))
    generate(plan(4, gain=3.0)[2:3], tmp_path, weigh, MODEL, say=lambda _: None)
    (tmp_path / f".{cut.name}.part-99").write_text("half")
    with pytest.raises(DatasetError, match="remedy"):
        load(tmp_path)
    said: list[str] = []
    steps: list[Progress] = []
    before = whole.stat().st_mtime_ns
    generate(plan(4), tmp_path, weigh, MODEL, progress=steps.append, say=said.append)
    assert len(said) == 3 and "cannot be read" in said[0] and "not those that were written" in said[1] and "others now" in said[2]
    assert [(step.done, step.total) for step in steps] == [(2, 4), (3, 4), (4, 4)] and steps[-1].left == 0.0
    assert {record.path: record.attributes["data_sha256"] for record in load(tmp_path)} == good
    assert whole.stat().st_mtime_ns == before and not list(tmp_path.glob(".*"))
    # another model is another record, a smaller plan leaves strangers
    said.clear()
    generate(plan(3), tmp_path, weigh, {"is": "another"}, say=said.append)
    assert "aprbs_4.nc" in said[0] and sum("computed again" in text for text in said) == 3


def test_goes_on_after_kill_9(tmp_path: Path) -> None:
    process = subprocess.Popen([sys.executable, "-m", "support.record_doubles", str(tmp_path)], env=supported())
    deadline = time.monotonic() + 30.0
    while len(list(tmp_path.glob("*.nc"))) < 2 and time.monotonic() < deadline:
        time.sleep(0.01)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    # its workers find the pipe closed and end
    pids = [int(path.name.split("-")[1]) for path in tmp_path.glob("worker-*")]
    while any(_alive(pid) for pid in pids) and time.monotonic() < deadline:
        time.sleep(0.02)
    assert len(pids) >= 2 and not any(_alive(pid) for pid in pids)
    kept = {path: path.stat().st_mtime_ns for path in tmp_path.glob("*.nc")}
    assert 2 <= len(kept) < 6
    for path in kept:
        read(path)
    done: list[str] = []
    whole = plan(6, folder=str(tmp_path))
    generate(whole, tmp_path, record_doubles.slowly, {"is": "slow"}, workers=2, progress=lambda step: done.append(step.name))
    assert len(done) == 6 - len(kept) and len(load(tmp_path)) == 6
    assert {path: path.stat().st_mtime_ns for path in kept} == kept


def _alive(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def test_failures_cost_their_record_alone(tmp_path: Path) -> None:
    with pytest.raises(DatasetError) as caught:
        generate(fragile_plan(), tmp_path, fragile, MODEL, workers=2)
    text = str(caught.value)
    assert "3 of 4 records failed" in text and "remedy" in text
    assert "h2: ValueError: the roof is gone" in text and "h3: force_x is not finite from instant 0" in text
    assert "h4: its process ended by exit code 9" in text
    assert [record.motion.name for record in load(tmp_path)] == ["h1"]


def test_refusals_name_the_remedy(tmp_path: Path) -> None:
    with pytest.raises(DatasetError, match="remedy: give each motion a name of its own"):
        generate([*plan(1), *plan(1)], tmp_path, weigh, MODEL)
    with pytest.raises(DatasetError, match="remedy: name motions with letters"):
        generate([replace(plan(1)[0], motion=replace(plan(1)[0].motion, name="../up"))], tmp_path, weigh, MODEL)
    with pytest.raises(DatasetError, match="remedy"):
        load(tmp_path / "nowhere")
    (tmp_path / "file").touch()
    with pytest.raises(DatasetError, match="remedy"):
        generate(plan(1), tmp_path / "file", weigh, MODEL)


def test_the_two_phase_tank(fmu: Callable[[str], Path], tmp_path: Path) -> None:
    """A record through slosh_vof.fmu: weight and vertical inertia are the liquid's, and an FMU takes the place of another."""
    tank = Tank(0.5, 0.15)
    times = instants(0.3, 2e-3)
    motion = aprbs(1, times, 1e-3, 2e-3, ramp=0.1)
    drive = Drive.of(fmu("slosh_vof"))
    generate([Planned(motion, settings(tank, (32, 16)), "test")], tmp_path, drive, drive.model)
    (record,) = load(tmp_path)
    assert set(record.loads) == set(LOADS) and record.attributes["model"]["fmu_sha256"] == drive.sha256
    assert record.parameters["cells_x"] == 32 and record.parameters["liquid_density"] == 1000.0
    gas = 1.2 * 0.075 * 0.5 * 9.81
    frozen = np.array([frozen_load(tank, SectionMotion(*row)) for row in motion.motions])
    swing = np.std(frozen[:, 1])
    assert np.std(record.loads["force_y"] + gas - frozen[:, 1]) < 0.03 * swing
    np.testing.assert_allclose(record.loads["force_x_tank"], record.loads["force_west"] + record.loads["force_east"], atol=2.0)
    linear = Drive.of(fmu("slosh_ems"), LINEAR_LOADS)
    generate([Planned(motion, settings(tank, None), "test")], tmp_path / "ems", linear, linear.model)
    (other,) = load(tmp_path / "ems")
    assert np.std(other.loads["force_y"] - frozen[:, 1]) < 0.03 * swing
    # what an FMU does not know is refused in its own words, in the caller's process
    with pytest.raises(DatasetError, match="has no variable 'cells_x'"):
        generate([Planned(motion, settings(tank, (32, 16)), "test")], tmp_path / "no", linear, linear.model)
    with pytest.raises(AeroSloshError, match="missing"):
        Drive.of(tmp_path / "none.fmu")
