"""Sweeps through the command, with real worker processes: kills, full disks, damage; nothing is lost and nothing repeated."""

from __future__ import annotations

import csv
import json
import os
import shutil
import signal
import socket
import subprocess
from pathlib import Path

import pytest
from scipy.io import netcdf_file

from aeroslosh.master import cli
from aeroslosh.master.base.errors import AeroSloshError
from aeroslosh.master.results import point_file
from support.processes import COMMAND, QUICK, started, until
from support.swept import alive, children, ledger, numbers, run, sweep, times

LONG = ("--set", "flutter.free_cycles=12.0")  # a point takes long enough to be killed in


@pytest.fixture(scope="module")
def finished(flutter_fmus: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished sweep of 12 points; tests copy it."""
    out = tmp_path_factory.mktemp("finished") / "sweep"
    run(out, flutter_fmus, *QUICK, "--grid", "flutter.V_f=0.4:1.5:12", "--workers", "2")
    return out


@pytest.fixture
def copied(finished: Path, tmp_path: Path) -> Path:
    """A copy of it with the files' times."""
    return Path(shutil.copytree(finished, tmp_path / "copy"))


def test_boundaries_are_points_too(flutter_fmus: Path, tmp_path: Path) -> None:
    settings = ("sweep.command=boundary", "boundary.method=march", "flutter.V_f=2.3", "boundary.tolerance=0.03")
    words = [word for setting in settings for word in ("--set", setting)]
    run(tmp_path / "s", flutter_fmus, *QUICK[2:], *words, "--grid", "flow.mach=0.3,0.5", "--workers", "2")
    with (tmp_path / "s" / "sweep.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["mach"] for row in rows] == ["0.3", "0.5"] and all(row["converged"] == "True" for row in rows)
    assert float(rows[0]["V_f"]) == pytest.approx(2.387, rel=0.05)
    with netcdf_file(str(tmp_path / "s" / "points" / rows[0]["file"]), "r", mmap=False) as file:
        assert {"m01_alpha", "m02_alpha"} <= set(file.variables)


# kills


def test_kill_of_the_master_loses_nothing_and_repeats_nothing(flutter_fmus: Path, tmp_path: Path) -> None:
    out = tmp_path / "s"
    words = (*QUICK, *LONG, "--grid", "flutter.V_f=0.4:0.8:7", "--workers", "2")
    with started(sweep(out, flutter_fmus, *words)) as master:
        until(lambda: len(times(out)) >= 3 if out.exists() else 0)
        workers = children(master.pid)
        assert len(workers) == 2
        os.kill(master.pid, signal.SIGKILL)
        until(lambda: not any(map(alive, workers)), 10.0)  # in the middle of their points
    before = times(out)
    assert 3 <= len(before) < 7
    again = run(out, flutter_fmus, *words, "--resume")
    assert "7 of 7 points done" in again.stdout
    assert {label: stamp for label, stamp in times(out).items() if label in before} == before
    rows = ledger(out)
    assert all(rows[label]["attempts"] == 1 for label in before)
    assert all(row["status"] == "done" for row in rows.values()) and sum(row["attempts"] - 1 for row in rows.values()) <= 2


def test_kill_of_a_worker_repeats_its_point_alone(flutter_fmus: Path, tmp_path: Path) -> None:
    out = tmp_path / "s"
    with started(sweep(out, flutter_fmus, *QUICK, *LONG, "--grid", "flutter.V_f=0.4:0.8:6", "--workers", "2")) as master:
        until(lambda: len(times(out)) >= 2 if out.exists() else 0)
        os.kill(children(master.pid)[0], signal.SIGKILL)
        output, said = master.communicate(timeout=120)
    assert master.returncode == 0 and "6 of 6 points done, 0 failed" in output
    assert "worker ended by signal 9" in said
    assert sorted(row["attempts"] for row in ledger(out).values()) == [1] * 5 + [2]


def test_a_point_that_kills_its_worker_twice_has_failed(flutter_fmus: Path, tmp_path: Path) -> None:
    out = tmp_path / "s"
    words = (*QUICK, "--set", "flutter.free_cycles=1000", "--grid", "flutter.V_f=0.4", "--workers", "1")
    with started(sweep(out, flutter_fmus, *words)) as master:
        for attempt in (1, 2):
            until(lambda: (out / "ledger.sqlite").exists() and [r["attempts"] for r in ledger(out).values()] == [attempt])  # noqa: B023
            os.kill(until(lambda: children(master.pid))[0], signal.SIGKILL)
        output, _ = master.communicate(timeout=60)
    assert master.returncode == 3 and "worker ended by signal 9 (SIGKILL) twice" in output
    row = next(iter(ledger(out).values()))
    assert row["status"] == "failed" and row["attempts"] == 2
    assert "signal 9" in point_file.read(out / "points" / row["file"]).cause


def test_interrupted_it_goes_on_with_resume(flutter_fmus: Path, tmp_path: Path) -> None:
    out = tmp_path / "s"
    words = (*QUICK, *LONG, "--grid", "flutter.V_f=0.4:0.8:5", "--workers", "1")
    with started(sweep(out, flutter_fmus, *words)) as master:
        until(lambda: len(times(out)) >= 1 if out.exists() else 0)
        workers = children(master.pid)
        master.send_signal(signal.SIGINT)
        _, said = master.communicate(timeout=20)
    assert master.returncode == 130 and "points are finished and kept, --resume goes on" in said and "Traceback" not in said
    assert not any(map(alive, workers))
    assert "5 of 5 points done" in run(out, flutter_fmus, *words, "--resume").stdout


def test_a_second_master_is_refused_and_the_first_unharmed(flutter_fmus: Path, tmp_path: Path) -> None:
    out = tmp_path / "s"
    words = (*QUICK, *LONG, "--grid", "flutter.V_f=0.4:0.8:5", "--workers", "1")
    with started(sweep(out, flutter_fmus, *words)) as master:
        until(lambda: len(times(out)) >= 1 if out.exists() else 0)
        second = run(out, flutter_fmus, *words, "--resume", code=2)
        assert f"Another sweep is at work in this folder: process {master.pid} on {socket.gethostname()}" in second.stderr
        output, _ = master.communicate(timeout=120)
    assert master.returncode == 0 and "5 of 5 points done" in output
    assert {row["attempts"] for row in ledger(out).values()} == {1}


# disks and damage


def test_a_full_disk_ends_it_with_everything_kept(flutter_fmus: Path, tmp_path: Path) -> None:
    """On a file system of 400 KiB where the user may mount one, else with a limit on the size of a file."""
    words = [*QUICK, "--grid", "flutter.V_f=0.4:1.5:12", "--workers", "1"]
    probe = subprocess.run(["unshare", "-Urm", "mount", "-t", "tmpfs", "-o", "size=400k", "none", str(tmp_path)])
    if probe.returncode == 0:
        out = tmp_path / "disk" / "s"
        first, second = (" ".join(sweep(out, flutter_fmus, *words, *more)) for more in ((), ("--resume",)))
        (tmp_path / "disk").mkdir()
        script = (
            f"mount -t tmpfs -o size=400k none {out.parent} && {first}; echo code $?; ls {out}/points | wc -l; "
            f"mount -o remount,size=8m {out.parent} && {second}; echo code $?; "
            f'sqlite=$(cat {out}/sweep.csv); echo "$sqlite"; ls -A {out}/points'
        )
        print("full disk: a tmpfs of 400 KiB")
        done = subprocess.run(["unshare", "-Urm", "sh", "-c", script], capture_output=True, text=True)
        assert "code 5" in done.stdout and "code 0" in done.stdout, (done.stdout, done.stderr)
        kept = int(done.stdout.split("code 5\n")[1].split()[0])
        assert 0 < kept < 12 and ".part" not in done.stdout
        assert "The disk is full" in done.stderr or "database or disk is full" in done.stderr
        assert (
            f"{kept} of 12 points are finished and kept" in done.stderr and "free space, then go on with --resume" in done.stderr
        )
        assert f"{12 - kept} of 12 points to compute" in done.stderr  # none of those kept a second time
        return
    print("full disk: RLIMIT_FSIZE, no file system can be mounted here")
    limited = ["prlimit", "--fsize=40000", *sweep(tmp_path / "s", flutter_fmus, *words)]
    done = subprocess.run(limited, capture_output=True, text=True)
    assert done.returncode == 5 and "points are finished and kept" in done.stderr
    run(tmp_path / "s", flutter_fmus, *words, "--resume")


def test_a_damaged_page_of_the_ledger_costs_no_point(copied: Path, flutter_fmus: Path) -> None:
    path, before = copied / "ledger.sqlite", times(copied)
    content = bytearray(path.read_bytes())
    middle = len(content) // 2
    content[middle : middle + 4096] = os.urandom(4096)
    path.write_bytes(content)
    done = run(copied, flutter_fmus, *QUICK, "--grid", "flutter.V_f=0.4:1.5:12", "--resume")
    assert "The ledger is damaged" in done.stderr and "moved to ledger.corrupt-001.sqlite" in done.stderr
    assert "12 finished points entered from their files" in done.stderr and "to compute" not in done.stderr
    assert times(copied) == before and {row["attempts"] for row in ledger(copied).values()} == {1}


def test_a_damaged_point_is_computed_again_with_the_same_numbers(copied: Path, finished: Path, flutter_fmus: Path) -> None:
    before = times(copied)
    label = sorted(before)[5]
    path = copied / "points" / f"{label}.nc"
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 0x10
    path.write_bytes(content)
    done = run(copied, flutter_fmus, *QUICK, "--grid", "flutter.V_f=0.4:1.5:12", "--resume")
    assert f"point {label}: its file is damaged; it is computed again" in done.stderr
    assert {name for name, stamp in times(copied).items() if stamp != before[name]} == {label}
    assert numbers(copied) == numbers(finished)


# failures and refusals


def test_failed_points_are_data_with_a_cause(flutter_fmus: Path, tmp_path: Path) -> None:
    out = tmp_path / "s"
    words = (*QUICK, "--grid", "flow.airfoil=NACA 0012,FAIL 100,UNSTEADY 1,NAN 90", "--workers", "1")
    done = run(out, flutter_fmus, *words, code=3)
    assert "2 of 4 points done, 2 failed, 1 without a verdict" in done.stdout and "told to fail" in done.stdout
    rows = {json.loads(row["overrides"])["flow.airfoil"]: row for row in ledger(out).values()}
    assert [rows[name]["status"] for name in ("NACA 0012", "FAIL 100", "UNSTEADY 1", "NAN 90")] == [
        "done",
        "failed",
        "failed",
        "done",
    ]
    assert "Traceback" in rows["FAIL 100"]["traceback"] and "did not converge" in rows["UNSTEADY 1"]["cause"]
    with netcdf_file(str(out / "points" / rows["FAIL 100"]["file"]), "r", mmap=False) as file:
        assert file.variables["alpha"].shape == (100,)  # the history so far
    before = times(out)
    assert "to compute" not in run(out, flutter_fmus, *words, "--resume", code=3).stderr
    again = run(out, flutter_fmus, *words, "--resume", "--retry-failed", code=3)
    assert "2 failed points are computed again" in again.stderr
    changed = {label for label, stamp in times(out).items() if stamp != before[label]}
    assert changed == {rows[name]["id"] for name in ("FAIL 100", "UNSTEADY 1")}
    assert all(ledger(out)[label]["attempts"] == 2 for label in changed)


def test_what_cannot_be_is_refused_with_the_remedy(copied: Path, flutter_fmus: Path, tmp_path: Path) -> None:
    def refused(out: Path, fmus: Path, *arguments: str) -> str:
        """The message, in this process: no worker is started."""
        with pytest.raises(AeroSloshError) as caught:
            cli.run(sweep(out, fmus, *arguments)[len(COMMAND) :])
        assert caught.value.code == 2
        return str(caught.value)

    words = (*QUICK, "--grid", "flutter.V_f=0.4:1.5:12")
    stamp = (copied / "ledger.sqlite").stat().st_mtime_ns
    assert "holds a sweep already" in refused(copied, flutter_fmus, *words)
    changed = refused(copied, flutter_fmus, *words, "--resume", "--set", "section.mass_ratio=61")
    assert "section.mass_ratio 60.0 → 61.0" in changed and "--out" in changed
    other = tmp_path / "other_fmus"
    shutil.copytree(flutter_fmus, other)
    with (other / "structure.fmu").open("ab") as file:
        file.write(b"\0")
    assert "structure.fmu is another" in refused(copied, other, *words, "--resume")
    assert (copied / "ledger.sqlite").stat().st_mtime_ns == stamp
    assert "no sweep to resume" in refused(tmp_path / "none", flutter_fmus, *words, "--resume")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.txt").write_text("do not lose")
    assert "something else than a sweep" in refused(tmp_path / "mine", flutter_fmus, *words)
    message = refused(tmp_path / "none", flutter_fmus, *QUICK, "--grid", "flow.mach=0.5,3")
    assert "--grid flow.mach=0.5,3" in message and "out of range" in message
    assert not (tmp_path / "none").exists()


def test_a_dry_run_tells_the_cost_and_writes_nothing(copied: Path, flutter_fmus: Path) -> None:
    before = {path: path.stat().st_mtime_ns for path in copied.rglob("*")}
    words = (*QUICK, "--grid", "flutter.V_f=0.4:1.6:13", "--resume", "--dry-run", "--workers", "4", "--json")
    data = json.loads(run(copied, flutter_fmus, *words).stdout)
    assert data["points"] == 13 and data["finished"] >= 1
    assert data["marches"] == data["points"] - data["finished"] and data["steps"] == 6 * 72 * data["marches"]
    assert data["wall_seconds"] == pytest.approx(data["cpu_seconds"] / 4) and data["cpu_seconds"] > 0.0
    assert {path: path.stat().st_mtime_ns for path in copied.rglob("*")} == before


def test_an_fmu_that_changes_meanwhile_ends_the_sweep(flutter_fmus: Path, tmp_path: Path) -> None:
    fmus, out = tmp_path / "fmus", tmp_path / "s"
    shutil.copytree(flutter_fmus, fmus)
    with started(sweep(out, fmus, *QUICK, *LONG, "--grid", "flutter.V_f=0.4:0.8:4", "--workers", "1")) as master:
        until(lambda: len(times(out)) >= 1 if out.exists() else 0)
        with (fmus / "structure.fmu").open("ab") as file:
            file.write(b"\0")
        _, said = master.communicate(timeout=60)
    assert master.returncode == 2 and "structure.fmu has changed since the sweep began" in said
    assert f"{len(times(out))} of 4 points are finished and kept" in said
