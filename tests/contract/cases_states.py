"""States: taken and set in every mode, rolled back to the bit, resumed in a new process, refused where they do not belong."""

from __future__ import annotations

import ctypes as c
import gc
import hashlib
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from cheap import PARAMETERS, STEP, drive, march, start_up, started
from raw import DISCARD, ERROR, OK, Raw

CHECKSUM = 32


def case_states_in_every_mode(folder: str) -> None:
    """Taken in one mode, set in each other, plain and as bytes: the run goes on as it would have."""
    wanted = march(started(folder, "calm"), 0, 4)
    modes = ("created", "initializing", "started", "stepped", "terminated")
    source = Raw(folder, "source")
    kept: dict[str, tuple[c.c_void_p, bytes]] = {}
    for mode in modes:
        to_next(source, mode)
        state = source.state()
        kept[mode] = state, source.pack(state)
    for mode in modes:
        one = Raw(folder, "one")
        for own in modes:
            to_next(one, own)
            before = one.state()
            for state in (kept[mode][0], one.unpack(kept[mode][1])):
                assert one.take(state) == OK
                one.assert_well()
                go_on(one, mode, wanted)
                assert one.take(before) == OK
                one.assert_well()
            assert one.drop(before) == OK
        one.free()


def to_next(one: Raw, mode: str) -> None:
    """Bring an instance that stands in the mode before into `mode`."""
    if mode == "created":
        for name, value in PARAMETERS[one.description.modelName].items():
            one[name] = value
    elif mode == "initializing":
        assert (one.setup(), one.enter()) == (OK, OK)
    elif mode == "started":
        assert one.leave() == OK
    elif mode == "stepped":
        march(one, 0, 2)
    else:
        assert one.terminate() == OK


def go_on(one: Raw, mode: str, wanted: list[str]) -> None:
    """From a restored mode through to two more steps, as in an undisturbed run."""
    if mode == "created":
        assert (one.setup(), one.enter()) == (OK, OK)
    if mode in ("created", "initializing"):
        assert one.leave() == OK
    if mode == "terminated":
        assert one.step(2 * STEP, STEP) == ERROR
        one.assert_failed("while terminated")
    else:
        first = 2 if mode == "stepped" else 0
        assert march(one, first, 2) == wanted[first : first + 2], mode


def case_rollback_to_the_bit_after_any_divergence(folder: str) -> None:
    one = started(folder)
    march(one, 0, 3)
    state = one.state()
    packed = one.pack(state)
    wanted = march(one, 3, 4)
    for ruin in (
        "other motion",
        "longer steps",
        "not a number",
        "unknown reference",
        "wrong time",
        "terminate",
        "reset",
        "bytes",
    ):
        if ruin == "other motion":
            march(one, 7, 5, share=-3.0)
        elif ruin == "longer steps":
            one.step(7 * STEP, 7.3 * STEP)
        elif ruin == "not a number":
            one.set("Real", [one.named("input", "Real")[0].valueReference], [float("nan")])
            one.step(0.0, STEP)
        elif ruin == "unknown reference":
            one.get("String", [12345])
        elif ruin == "wrong time":
            one.step(-1.0, STEP)
        elif ruin == "terminate":
            one.terminate()
        elif ruin == "reset":
            one.reset()
        else:
            one.take(one.unpack(packed[:-1]))
            one.assert_failed()
        gc.collect()
        assert one.take(state) == OK
        one.assert_well()
        assert march(one, 3, 4) == wanted, ruin
        assert one.pack(state) == packed, f"{ruin}: the state itself has changed"


def case_taking_states_changes_nothing(folder: str) -> None:
    wanted = march(started(folder, "calm"), 0, 4)
    one, rows = started(folder), []
    for step in range(4):
        state = one.state()
        assert one.pack(state) == one.pack(state)
        assert one.drop(one.unpack(one.pack(state))) == OK
        rows += march(one, step, 1)
        assert one.drop(state) == OK
    assert rows == wanted


def case_a_state_outlives_the_instance_and_fits_one_with_other_parameters(folder: str) -> None:
    first = started(folder, "first")
    march(first, 0, 2)
    state, packed = first.state(), first.pack(first.state())
    wanted = march(first, 2, 2)
    first.free()
    gc.collect()
    parameter = {"structure": "omega_h", "aero": "mach", "slosh_ems": "gravity"}.get(
        Raw(folder).description.modelName, "liquid_density"
    )
    other = Raw(folder, "other")
    other_value = 0.9 * other[parameter]
    start_up(other, **{parameter: other_value})
    march(other, 0, 1)
    for again in (state, other.unpack(packed)):
        assert other.take(again) == OK
        assert other[parameter] != other_value
        assert march(other, 2, 2) == wanted


def case_a_failed_state_tells_its_failure_where_it_is_set(folder: str) -> None:
    one = started(folder)
    good = one.state()
    one.step(7.0, STEP)
    bad = one.state()
    assert one.take(good) == OK
    one.assert_well()
    for state in (bad, one.unpack(one.pack(bad))):
        assert one.take(state) == OK
        one.assert_failed("stands at 0.0 s")
        assert one.step(0.0, STEP) == ERROR
        assert one.take(good) == OK
        one.assert_well()
    name = one.named("input", "Real")[0].name
    assert one.put(name, float("inf")) == DISCARD
    refused = one.unpack(one.pack(one.state()))
    assert one.take(good) == OK
    assert one.take(refused) == OK
    one.assert_failed(f"'{name}'", "not a finite number")
    one[name] = 0.0
    one.assert_well()


def case_damaged_bytes_are_refused(folder: str) -> None:
    one = started(folder)
    march(one, 0, 2)
    state = one.state()
    packed = one.pack(state)
    wanted = march(one, 2, 2)
    n = len(packed)
    places = {0, 1, 17, 18, 19, 25, 26, 30, n // 3, n // 2, n - CHECKSUM - 1, n - CHECKSUM, n - 1}
    bad = [packed[:k] + bytes([packed[k] ^ 1]) + packed[k + 1 :] for k in sorted(places)]
    bad += [packed[:k] for k in (0, 1, 17, 18, 25, 26, 27, n // 2, n - CHECKSUM, n - 1)]
    bad += [
        packed + b"\0",
        packed + packed,
        b"\0" * n,
        b"\xff" * 40,
        packed[:18] + b"\xff" * 8 + packed[26:],
        b"{}",
        packed[::-1],
    ]
    bad += [signed(packed[:18] + size.to_bytes(8, "little") + packed[26:-CHECKSUM]) for size in (0, 1, 2**63, n, n - 59)]
    for data in bad:
        assert one.take(one.unpack(data)) == ERROR
        one.assert_failed("state")
        assert one.step(2 * STEP, STEP) == ERROR
        assert one.take(state) == OK
        one.assert_well()
    assert march(one, 2, 2) == wanted


def signed(body: bytes) -> bytes:
    """Bytes with the checksum that belongs to them."""
    return body + hashlib.blake2b(body, digest_size=CHECKSUM).digest()


def case_states_of_another_version_are_refused(folder: str) -> None:
    one = started(folder)
    march(one, 0, 2)
    state = one.state()
    packed = one.pack(state)
    wanted = march(one, 2, 2)
    size = int.from_bytes(packed[18:26], "little")
    header = json.loads(packed[26 : 26 + size])
    for change, words in (
        ({"content_hash": "0123456789ab"}, "was made by version 0123456789ab"),
        ({"content_hash": ""}, "was made by version (source tree)"),
        ({"component": "slosh_sph"}, "belongs to FMU 'slosh_sph'"),
    ):
        text = json.dumps({**header, **change}).encode()
        data = signed(packed[:18] + len(text).to_bytes(8, "little") + text + packed[26 + size : -CHECKSUM])
        assert one.take(one.unpack(data)) == ERROR
        one.assert_failed(words)
        assert one.take(state) == OK
        assert march(one, 2, 2) == wanted, change


def case_states_of_another_fmu_are_refused(folder: str, folders: dict[str, str]) -> None:
    one = started(folder)
    march(one, 0, 2)
    own = one.state()
    wanted = march(one, 2, 2)
    for name in ("structure", "slosh_ems"):
        if folders[name] == folder:
            continue
        other = started(folders[name], "other")
        state = other.state()
        for foreign, words in ((state, "there is no such state"), (one.unpack(other.pack(state)), f"belongs to FMU '{name}'")):
            assert one.take(foreign) == ERROR
            one.assert_failed(words)
            assert one.take(own) == OK
            assert march(one, 2, 2) == wanted
        assert other.take(own) == ERROR
        other.assert_failed("there is no such state")


def case_bytes_resume_in_a_new_process_to_the_bit(folder: str) -> None:
    one = started(folder)
    march(one, 0, 3)
    drive(one, 3)  # inputs are part of a state
    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / "state"
        path.write_bytes(one.pack(one.state()))
        wanted = march(one, 3, 5)
        done = subprocess.run([sys.executable, __file__, folder, str(path)], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == wanted


def resume(folder: str, path: str) -> None:
    """Continue from a file's bytes in an instance that never was initialised; prints the rows."""
    one = Raw(folder, "resumed")
    assert one.take(one.unpack(Path(path).read_bytes())) == OK
    one.assert_well()
    print(*march(one, 3, 5), sep="\n", flush=True)


if __name__ == "__main__":
    resume(*sys.argv[1:])
    os._exit(0)
