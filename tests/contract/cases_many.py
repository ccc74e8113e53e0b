"""Many: instances at once and one after another, failures in a row, threads."""

from __future__ import annotations

import gc
import resource
from concurrent.futures import ThreadPoolExecutor
from threading import Barrier
from typing import Any

from cheap import STEP, drive, march, start_up, started
from raw import DISCARD, ERROR, OK, Raw

SHARES = (0.5, 1.0, -1.0, 1.5)


def alone(folder: str, steps: int) -> list[list[str]]:
    """The run of each share in an instance of its own, one after another."""
    rows = []
    for share in SHARES:
        one = started(folder, "alone")
        rows.append(march(one, 0, steps, share=share))
        one.free()
    return rows


def case_two_hundred_instances_with_numbers_of_their_own(folder: str) -> None:
    wanted = alone(folder, 2)
    assert len({rows[-1] for rows in wanted}) == len(SHARES)
    first = started(folder, "first")
    state = first.state()
    instances = [Raw(folder, f"i{i}") for i in range(200)]
    for one in instances:  # a state saves 200 steady flows of aero
        assert one.take(state) == OK
    rows: list[list[str]] = [[] for _ in instances]
    for step in range(2):
        for i, one in enumerate(instances):
            rows[i] += march(one, step, 1, share=SHARES[i % len(SHARES)])
    for i, one in enumerate(instances):
        assert rows[i] == wanted[i % len(SHARES)], f"instance {i}"
        one.assert_well()
    for one in instances[::2]:
        one.free()
    gc.collect()
    for i in range(1, 200, 2):
        instances[i].assert_well()
        if i % 20 == 1:
            march(instances[i], 2, 1)
        instances[i].free()


def case_twenty_exceptions_in_a_row(folder: str) -> None:
    """Failures of every kind with the collector between them, in one instance and in one beside it that must not notice."""
    wanted = march(started(folder, "calm"), 0, 22)
    one, calm = started(folder), started(folder, "beside")
    state = one.state()
    packed = one.pack(state)
    rows = []
    kinds = (
        lambda: one.get("Integer", [4321]),
        lambda: one.set("Boolean", [4321], [1]),
        lambda: one.step(float("nan"), STEP),
        lambda: one.take(one.unpack(packed[:-5])),
        lambda: one.enter(),
    )
    for k in range(20):
        status = kinds[k % 5]()
        assert (status[0] if isinstance(status, tuple) else status) == ERROR
        gc.collect()
        one.assert_failed()
        assert one.step(0.0, STEP) == ERROR
        assert (one.reset() if k % 2 else one.take(state)) == OK
        if k % 2:
            start_up(one)
        one.assert_well()
        rows += march(calm, k, 1)
    assert rows == wanted[:20]
    assert march(one, 0, 22) == wanted


def case_violent_inputs_give_no_number_or_a_failure(folder: str) -> None:
    """Inputs as large as floating-point numbers get: what fails inside the component is a failure too, and is cured."""
    one = started(folder)
    march(one, 0, 2)
    state = one.state()
    wanted = march(one, 2, 3)
    inputs = one.named("input", "Real")
    failures = 0
    for variable in inputs:
        for value in (1e308, -1e308, 1e160, 1e20, -1e9, 5e-324):
            one.take(state)
            drive(one, 2)
            assert one.put(variable.name, value) in (OK, DISCARD)  # slosh_vof declares ranges
            status = one.step(2 * STEP, STEP)
            if status == OK:
                assert not one.failed
                numbers = one.outputs()
                assert all(abs(v) < float("inf") for v in numbers), numbers
            else:
                assert status == ERROR
                failures += 1
                one.assert_failed()
            one.take(state)
            assert march(one, 2, 3) == wanted, f"{variable.name} = {value}"
    assert failures


def case_instances_in_threads_at_once(folder: str) -> None:
    wanted = alone(folder, 20)
    instances = [started(folder, f"t{i}") for i in range(len(SHARES))]
    together = Barrier(len(SHARES))

    def run(i: int) -> list[str]:
        together.wait()
        return march(instances[i], 0, 20, share=SHARES[i])

    with ThreadPoolExecutor(len(SHARES)) as pool:
        for _ in range(2):
            assert list(pool.map(run, range(len(SHARES)))) == wanted
            for one in instances:
                one.reset()
                start_up(one)


def case_a_whole_life_in_each_of_many_threads(folder: str) -> None:
    wanted = alone(folder, 4)

    def live(i: int) -> list[str]:
        one = started(folder, f"life{i}")
        rows = march(one, 0, 2, share=SHARES[i % 4])
        state = one.state()
        one.step(-1.0, STEP)
        one.assert_failed()
        one.take(one.unpack(one.pack(state)))
        rows += march(one, 2, 2, share=SHARES[i % 4])
        one.drop(state)
        one.terminate()
        one.free()
        return rows

    with ThreadPoolExecutor(4) as pool:
        for i, rows in enumerate(pool.map(live, range(16))):
            assert rows == wanted[i % 4], i


def case_one_instance_from_many_threads_in_turn(folder: str) -> None:
    wanted = march(started(folder, "calm"), 0, 12)
    one: Any = None
    rows: list[str] = []
    for step in range(12):
        with ThreadPoolExecutor(1) as thread:  # a new thread each time
            if step == 0:
                one = thread.submit(started, folder).result()
            rows += thread.submit(march, one, step, 1).result()
    assert rows == wanted
    with ThreadPoolExecutor(1) as thread:
        thread.submit(one.free).result()


def case_memory_is_given_back(folder: str) -> None:
    """Instances, failures, states and messages nobody reads leave nothing behind."""

    def once() -> None:
        one = started(folder, "memory")
        march(one, 0, 2)
        for _ in range(5):
            state = one.state()
            one.drop(one.unpack(one.pack(state)))
            one.drop(state)
        one.step(-1.0, STEP)
        one.terminate()
        one.free()

    def many() -> float:
        for _ in range(12):
            once()
        gc.collect()
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0  # MB, largest so far

    many()
    before = many()
    after = many()
    assert after - before < 4.0, f"12 instances left {after - before:.1f} MB"
