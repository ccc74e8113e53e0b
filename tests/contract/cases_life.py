"""Life of an instance: calls in every order, steps of any size and from any time, start and stop times, logging, what is not
supported.
"""

from __future__ import annotations

import ctypes as c
import itertools
import math

import raw
from cheap import STEP, drive, march, prepared, start_up, started
from raw import DISCARD, ERROR, OK, Raw

MODES = ("created", "initializing", "running", "terminated")


def case_calls_in_every_order(folder: str) -> None:
    """All orders of five calls: allowed ones work, forbidden ones fail until a reset, which makes a fresh instance."""
    one = Raw(folder)
    length = 3 if one.description.modelName == "aero" else 4
    fresh = start_up(Raw(folder))
    drive(fresh, 0)
    assert fresh.step(0.0, STEP) == OK
    wanted = fresh.outputs()
    for order in itertools.product(("enter", "leave", "step", "terminate", "reset"), repeat=length):
        prepared(one)
        mode, well, time = "created", True, 0.0
        for call in order:
            said = f"{call} of {order}"
            allowed = well and (call, mode) in (("enter", "created"), ("leave", "initializing"), ("step", "running"))
            if call == "step":
                if well and mode == "running":
                    drive(one, 0)
                assert one.step(time, STEP) == (OK if allowed else ERROR), said
                if allowed and time == 0.0:
                    assert one.outputs() == wanted, said
                time += STEP if allowed else 0.0
            else:
                allowed |= call in ("reset", "terminate")
                assert getattr(one, call)() == (OK if allowed else ERROR), said
            if call == "reset":
                mode, well, time = "created", True, 0.0
                prepared(one)
            elif call == "terminate":
                mode = "terminated"
            elif allowed:
                mode = {"enter": "initializing", "leave": "running", "step": "running"}[call]
            else:
                well = False
            assert one.failed is not well, said
            if not well:
                one.assert_failed()
        assert one.reset() == OK


def case_forbidden_calls_say_what_to_do(folder: str) -> None:
    for calls, words in (
        (("leave",), "asked to leave initialisation mode while created. Remedy: enter initialisation mode first"),
        (("enter", "enter"), "asked to enter initialisation mode while initializing. Remedy: leave initialisation mode first"),
        (("enter", "setup"), "asked to set up an experiment while initializing"),
        (("enter", "leave", "enter"), "asked to enter initialisation mode while running. Remedy: step, or reset"),
        (("enter", "leave", "leave"), "asked to leave initialisation mode while running"),
        (("terminate", "enter"), "while terminated. Remedy: reset this instance to start anew, or restore a state"),
    ):
        one = prepared(Raw(folder))
        *allowed, last = calls
        for call in allowed:
            assert getattr(one, call)() == OK
        assert getattr(one, last)() == ERROR
        one.assert_failed(words)
        one.free()
    for mode, words in zip(MODES, ("enter initialisation mode", "leave initialisation mode", "", "reset"), strict=True):
        one = brought(folder, mode)
        assert one.step(STEP if mode == "terminated" else 0.0, STEP) == (OK if mode == "running" else ERROR)
        if words:
            one.assert_failed(f"asked to step while {mode}. Remedy: {words}")


def brought(folder: str, mode: str) -> Raw:
    """A new instance in a mode; where terminated, after a step."""
    one = prepared(Raw(folder))
    if mode != "created":
        assert (one.setup(), one.enter()) == (OK, OK)
    if mode in ("running", "terminated"):
        assert one.leave() == OK
    if mode == "terminated":
        assert (one.step(0.0, STEP), one.terminate()) == (OK, OK)
    return one


def case_reset_in_every_mode_gives_a_fresh_instance(folder: str) -> None:
    wanted = march(started(folder, "calm"), 0, 3)
    for mode in MODES:
        for ruin in (False, True):
            one = brought(folder, mode)
            if mode == "running":
                march(one, 0, 2, share=1.5)
            if ruin:
                one.get("Real", [9999])
                one.assert_failed()
            assert one.reset() == OK
            fresh = Raw(folder)
            assert all(one[name] == fresh[name] or one[name] != one[name] for name in one.variables), f"reset while {mode}"
            start_up(one)
            assert march(one, 0, 3) == wanted, f"reset while {mode}"


def case_terminated_instances_keep_their_outputs(folder: str) -> None:
    one = started(folder)
    march(one, 0, 2)
    last = one.outputs()
    for _ in range(3):
        assert one.terminate() == OK
        assert one.outputs() == last
        one.assert_well()
    assert one.step(2 * STEP, STEP) == ERROR
    one.assert_failed("while terminated")


def case_steps_of_no_use_are_refused(folder: str) -> None:
    one = started(folder)
    march(one, 0, 2)
    state = one.state()
    wanted = march(one, 2, 2)
    for size in (0.0, -0.0, -STEP, -1e308, math.nan, math.inf, -math.inf, 5e-324, 1e-300):
        one.take(state)
        assert one.step(2 * STEP, size) == ERROR, size
        one.assert_failed("Remedy: give a")
        start = start_up(Raw(folder, "start")) if size in (5e-324, 1e-300) else None  # time 0 resolves any step
        if start:
            assert start.step(0.0, size) == ERROR, size
            start.assert_failed("at least 1e-100 s")
        one.take(state)
        assert march(one, 2, 2) == wanted, size
    for time in (0.0, STEP, 3 * STEP, -2 * STEP, 1e308, -1e308, math.nan, math.inf, -math.inf):
        one.take(state)
        assert one.step(time, STEP) == ERROR, time
        one.assert_failed("this instance stands at 0.002 s", "restore the state of that time")
        one.take(state)
        assert march(one, 2, 2) == wanted, time


def case_huge_steps_end_soon_with_numbers_or_a_failure(folder: str) -> None:
    one = started(folder)
    march(one, 0, 2)
    state = one.state()
    wanted = march(one, 2, 2)
    for size, share in itertools.product((1e308, 1e200, 1e30, 1e18, 1e12, 1e9, 1e7), (1.0, 0.0)):
        one.take(state)
        drive(one, 2, share)
        status = one.step(2 * STEP, size)
        if status == OK:
            one.assert_well()
            assert all(math.isfinite(v) for v in one.outputs()), size
        else:
            assert status == ERROR
            one.assert_failed()
        one.take(state)
        assert march(one, 2, 2) == wanted, size


def case_start_times(folder: str) -> None:
    wanted = march(started(folder, "calm"), 0, 3)
    for start in (1024.0, -4.0, 1.7e9):
        one = started(folder, start=start)
        assert march(one, 0, 3, start=start) == wanted, start
        one.free()
    for start in (math.nan, math.inf, -math.inf):
        one = prepared(Raw(folder))
        assert (one.setup(start), one.enter(), one.leave()) == (ERROR, ERROR, ERROR)
        one.assert_failed("start time", "is not finite")
        assert one.step(0.0, STEP) == ERROR


def case_stop_times(folder: str) -> None:
    wanted = march(started(folder, "calm"), 0, 3)
    one = prepared(Raw(folder))
    assert (one.setup(0.0, 3 * STEP, 1e-6), one.enter(), one.leave()) == (OK, OK, OK)
    assert march(one, 0, 3) == wanted
    last = one.state()
    assert one.step(3 * STEP, STEP) == ERROR
    one.assert_failed("goes past the stop time 0.003 s")
    one.take(last)
    one.assert_well()
    for stop in (math.nan, -1.0, -math.inf):
        one = prepared(Raw(folder))
        assert (one.setup(0.0, stop), one.enter(), one.leave()) == (ERROR, ERROR, ERROR)
        one.assert_failed("stop time")
    for tolerance in (0.0, -1.0, math.nan, math.inf):  # of no meaning here: these steps have no error control of their own
        one = prepared(Raw(folder))
        assert (one.setup(0.0, math.inf, tolerance), one.enter(), one.leave()) == (OK, OK, OK)
        assert march(one, 0, 3) == wanted


def case_both_kinds_of_step(folder: str) -> None:
    wanted = march(started(folder, "calm"), 0, 4)
    one, rows = started(folder), []
    for step in range(4):
        drive(one, step)
        assert one.step(step * STEP, STEP, no_set_before=step % 2 == 0) == OK
        rows.append(raw.bits(one.outputs()))
    assert rows == wanted


def case_what_is_not_supported_says_so_and_changes_nothing(folder: str) -> None:
    wanted = march(started(folder, "calm"), 0, 3)
    one = started(folder)
    march(one, 0, 1)
    n, reference, order, number = c.c_size_t(1), (c.c_uint * 1)(0), (c.c_int * 1)(1), (c.c_double * 1)(0.5)
    whole, text = c.c_int(-1), c.c_char_p()
    assert one.call("GetDirectionalDerivative", reference, n, reference, n, number, number) == ERROR
    assert one.call("SetRealInputDerivatives", reference, n, order, number) == ERROR
    assert one.call("GetRealOutputDerivatives", reference, n, order, number) == ERROR
    assert one.call("CancelStep") == ERROR
    for kind in range(-1, 5):
        assert one.call("GetStatus", kind, c.byref(whole)) == DISCARD
        assert one.call("GetIntegerStatus", kind, c.byref(whole)) == DISCARD
        assert one.call("GetStringStatus", kind, c.byref(text)) == DISCARD
        assert one.call("GetBooleanStatus", kind, c.byref(whole)) == (OK if kind == 3 else DISCARD)
    assert whole.value == 0  # fmi2Terminated: never of its own accord
    assert one.call("GetRealStatus", 2, number) == OK
    assert number[0] == STEP  # last successful time
    assert one.call("GetRealStatus", 0, number) == DISCARD
    one.assert_well()
    assert march(one, 1, 2) == wanted[1:]
    assert one.lib.fmi2GetVersion() == b"2.0"
    assert one.lib.fmi2GetTypesPlatform() == b"default"


def case_the_log_tells_what_failed_where_it_is_wanted(folder: str) -> None:
    categories = {category.name for category in raw.description(folder).logCategories}
    one = prepared(Raw(folder, "told"))
    raw.LOG.clear()
    one.step(0.0, STEP)
    ((name, status, category, text), *_) = raw.LOG
    assert (name, status) == ("told", ERROR)
    assert category in categories
    assert "asked to step while created. Remedy: enter" in text
    assert "Traceback" in text
    silent = prepared(Raw(folder, "silent", logging=False))
    raw.LOG.clear()
    for _ in range(50):
        silent.step(0.0, STEP)
    ((_, status, _, text),) = raw.LOG  # why it failed, in one line, once
    assert status == ERROR and "asked to step while created. Remedy: enter" in text and "\n" not in text
    assert silent.call("SetDebugLogging", 1, c.c_size_t(0), None) == OK
    silent.step(0.0, STEP)
    assert len(raw.LOG) == 2, "messages of the time without a log were kept"
    for names, told in (((b"logStatusError", b"no such category"), 1), ((b"logStatusWarning",), 0), ((b"logAll",), 1)):
        raw.LOG.clear()
        assert silent.call("SetDebugLogging", 1, c.c_size_t(len(names)), (c.c_char_p * len(names))(*names)) == OK
        silent.step(0.0, STEP)
        assert len(raw.LOG) == told, names
    raw.LOG.clear()
    assert silent.call("SetDebugLogging", 0, c.c_size_t(0), None) == OK
    silent.step(0.0, STEP)
    assert not raw.LOG
    silent.assert_failed()
    assert silent.reset() == OK
    silent.step(0.0, STEP)
    assert len(raw.LOG) == 1


def case_names_of_instances(folder: str) -> None:
    wanted = march(started(folder, "calm"), 0, 2)
    for name in ("", " ", "%s%n%s%n", "Tank ä 航空", "a/b\\c", "x" * 10_000, "line\nline"):
        one = started(folder, name)
        assert march(one, 0, 2) == wanted, name[:20]
        one.step(0.0, STEP)
        one.assert_failed()
        one.free()


def case_looking_at_outputs_while_initializing_changes_nothing(folder: str) -> None:
    """Outputs read for other inputs and parameters on the way to the start leave no trace in it."""
    parameter = {"structure": "omega_h", "aero": "mach", "slosh_ems": "gravity"}.get(
        raw.description(folder).modelName, "liquid_density"
    )
    direct = prepared(Raw(folder, "direct"))
    assert (direct.setup(), direct.enter()) == (OK, OK)
    drive(direct, 0)
    assert direct.leave() == OK
    first = raw.bits(direct.outputs())
    wanted = march(direct, 0, 3)
    one = prepared(Raw(folder))
    assert (one.setup(), one.enter()) == (OK, OK)
    good = one[parameter]
    for step, value in ((5, good), (9, 0.9 * good), (0, 0.95 * good), (0, good)):
        drive(one, step)
        one[parameter] = value
        shown = raw.bits(one.outputs())
        assert (shown == first) is (step == 0 and value == good)
        assert raw.bits(one.outputs()) == shown
    assert one.leave() == OK
    assert raw.bits(one.outputs()) == first
    assert march(one, 0, 3) == wanted
