"""Values: starts, every variable set and read in every mode, ranges, what is not finite, wrong references, strings.

`raw.Raw` calls the library as a host in C does; `cheap` holds cheap parameters and a drive.
"""

from __future__ import annotations

import ctypes as c
import math
from typing import Any

from cheap import PARAMETERS, STEP, drive, march, prepared, start_up, started
from raw import DISCARD, ERROR, OK, Raw, kind

TYPES = ("Real", "Integer", "Boolean", "String")
NONE = {"Real": math.nan, "Integer": 0, "Boolean": 0, "String": b""}  # what a failed instance answers


def start_of(variable: Any) -> Any:
    """The start value that the description tells."""
    convert = {"Real": float, "Integer": int, "Boolean": lambda text: int(text == "true"), "String": str}[kind(variable)]
    return convert(variable.start)


def another(variable: Any) -> Any:
    """A valid value that is not the start value."""
    start, kind_ = start_of(variable), kind(variable)
    if kind_ == "String":
        return "a path/with öddities %s"
    if kind_ == "Boolean":
        return 1 - start
    if variable.type == "Enumeration":
        return 1 if start == 0 else 0
    step: float = 1 if kind_ == "Integer" else 0.03125
    low, high = bounds(variable)
    return start + step if start + step <= high else start - step if start - step >= low else 0.5 * (low + high)


def bounds(variable: Any) -> tuple[float, float]:
    """Smallest and largest value that the description allows."""
    if variable.type == "Enumeration":
        return 0, len(variable.declaredType.items) - 1
    convert = float if variable.type == "Real" else int
    return (
        convert(variable.min) if variable.min is not None else -math.inf,
        convert(variable.max) if variable.max is not None else math.inf,
    )


def settable(one: Raw) -> list[Any]:
    """Parameters and inputs."""
    return one.named("parameter") + one.named("input")


def case_start_values_are_those_of_the_description(folder: str) -> None:
    one = Raw(folder)
    for variable in settable(one):
        assert one[variable.name] == start_of(variable), variable.name
    for variable in one.named("output", "Real"):
        assert math.isnan(one[variable.name]), f"{variable.name} before initialisation"
    one.assert_well()


def case_every_variable_is_set_and_read_before_initialisation(folder: str) -> None:
    for initializing in (False, True):
        one = Raw(folder)
        if initializing:
            assert (one.setup(), one.enter()) == (OK, OK)
        for variable in settable(one):
            one[variable.name] = another(variable)
            assert one[variable.name] == another(variable), variable.name
        for variable in settable(one):
            assert one[variable.name] == another(variable), f"{variable.name}, after the others"
        one.assert_well()


def case_every_variable_is_read_in_every_mode(folder: str) -> None:
    one = prepared(Raw(folder))
    assert (one.setup(), one.enter()) == (OK, OK)
    seen = {"initializing": read(one)}
    assert one.leave() == OK
    seen["started"] = read(one)
    assert one.step(0.0, STEP) == OK
    seen["running"] = read(one)
    assert one.terminate() == OK
    seen["terminated"] = read(one)
    for mode, values in seen.items():
        assert all(math.isfinite(v) for v in values.values() if isinstance(v, float)), f"{mode}: {values}"
    assert seen["initializing"] == seen["started"]
    assert seen["terminated"] == seen["running"]


def read(one: Raw) -> dict[str, Any]:
    """All variables."""
    return {name: one[name] for name in one.variables}


def case_a_value_just_outside_its_range_is_refused_until_a_good_one(folder: str) -> None:
    count = 0
    one = Raw(folder)
    for variable in settable(one):
        if kind(variable) not in ("Real", "Integer"):
            continue
        start, (low, high) = one[variable.name], bounds(variable)
        for bound, way in ((low, -math.inf), (high, math.inf)):
            if math.isinf(bound):
                continue
            count += 1
            one[variable.name] = bound
            one.assert_well()  # the bound itself is allowed
            one[variable.name] = start
            outside = math.nextafter(bound, way) if kind(variable) == "Real" else int(bound + math.copysign(1, way))
            assert one.put(variable.name, outside) == DISCARD
            assert one[variable.name] == start, f"{variable.name}: a refused value was applied"
            one.assert_failed(f"'{variable.name}'", "Remedy: give")
            one[variable.name] = start
            one.assert_well()
    assert count > 2
    start_up(one)


def case_what_is_not_finite_is_refused_before_the_start(folder: str) -> None:
    for initializing in (False, True):
        one = prepared(Raw(folder))
        if initializing:
            assert (one.setup(), one.enter()) == (OK, OK)
        for variable in settable(one):
            for bad in (math.nan, math.inf, -math.inf) if kind(variable) == "Real" else ():
                before = one[variable.name]
                assert one.put(variable.name, bad) == DISCARD
                assert one[variable.name] == before
                one.assert_failed(f"'{variable.name}'", "is not a finite number")
                one[variable.name] = before
                one.assert_well()
    variable = one.named("parameter", "Real")[0]
    assert one.put(variable.name, math.nan) == DISCARD
    assert one.leave() == ERROR
    one.assert_failed(f"'{variable.name}'")
    assert one.step(0.0, STEP) == ERROR


def case_an_input_that_is_not_finite_stops_the_run_until_a_good_one(folder: str) -> None:
    wanted = march(started(folder, "calm"), 0, 4)
    one = started(folder)
    assert march(one, 0, 2) == wanted[:2]
    drive(one, 2)
    for variable in one.named("input", "Real"):
        good = one[variable.name]
        for bad in (math.nan, math.inf, -math.inf):
            assert one.put(variable.name, bad) == DISCARD
            one.assert_failed(f"'{variable.name}'", "is not a finite number")
            assert one.step(2 * STEP, STEP) == ERROR
            one[variable.name] = good
            one.assert_well()
    assert march(one, 2, 2) == wanted[2:]


def case_unknown_references(folder: str) -> None:
    for one in (Raw(folder), started(folder)):
        state, last = one.state(), max(v.valueReference for v in one.variables.values())
        for type_ in TYPES:
            known = [v.valueReference for v in one.named("input") if kind(v) == type_][:1]
            for unknown in (last + 1, 2**31 - 1, 2**31, 2**32 - 1):
                refused(one, state, type_, [*known, unknown], unknown)


def case_references_of_another_type(folder: str) -> None:
    for one in (Raw(folder), started(folder)):
        state = one.state()
        for type_ in TYPES:
            for other in TYPES:
                references = [v.valueReference for v in one.variables.values() if kind(v) == other]
                if other != type_ and references:
                    refused(one, state, type_, references[:1], references[0])


def refused(one: Raw, state: c.c_void_p, type_: str, references: list[int], culprit: int) -> None:
    """Get and set references that this type has not: it fails, and `state` cures it."""
    value = {"Real": 0.5, "Integer": 1, "Boolean": 1, "String": b"x"}[type_]
    for getting in (False, True):
        if getting:
            status, values = one.get(type_, references)
            assert status == ERROR
            assert all(v == NONE[type_] or (v != v and type_ == "Real") for v in values), values
        else:
            assert one.set(type_, references, [value] * len(references)) == ERROR
        one.assert_failed(f"no {type_} variable with value reference {culprit}.", "modelDescription.xml")
        assert one.step(0.0, STEP) == ERROR
        assert one.take(state) == OK
        one.assert_well()


def case_empty_calls_do_nothing(folder: str) -> None:
    wanted = march(started(folder, "calm"), 0, 3)
    one = prepared(Raw(folder))

    def nothing() -> None:
        for type_ in TYPES:
            assert one.call(f"Get{type_}", None, c.c_size_t(0), None) == OK
            assert one.call(f"Set{type_}", None, c.c_size_t(0), None) == OK
        one.assert_well()

    nothing()
    assert (one.setup(), one.enter()) == (OK, OK)
    nothing()
    assert one.leave() == OK
    nothing()
    assert march(one, 0, 3) == wanted
    assert one.terminate() == OK
    nothing()


def case_outputs_cannot_be_set(folder: str) -> None:
    value = {"Real": 1.0, "Integer": 1, "Boolean": 1, "String": "x"}
    for variable in Raw(folder).named("output"):
        one = Raw(folder)
        assert one.put(variable.name, value[kind(variable)]) == ERROR
        one.assert_failed(f"output '{variable.name}' cannot be set")
        one.free()


def case_parameters_are_fixed_after_the_start(folder: str) -> None:
    wanted = march(started(folder, "calm"), 0, 2)
    one = started(folder)
    march(one, 0, 1)
    for variable in one.named("parameter"):
        value, new = one[variable.name], another(variable)
        one[variable.name] = value  # no change
        one.assert_well()
        assert one.put(variable.name, new if new != value else start_of(variable)) == ERROR
        one.assert_failed(f"parameter '{variable.name}' is fixed")
        one[variable.name] = value
        one.assert_well()
    assert march(one, 1, 1) == wanted[1:]


def case_nothing_is_set_after_terminate(folder: str) -> None:
    one = started(folder)
    assert one.terminate() == OK
    state = one.state()
    for name in [v.name for v in settable(one)]:
        assert one.put(name, one[name]) == ERROR
        one.assert_failed(f"'{name}'", "while terminated", "reset")
        assert one.take(state) == OK
        one.assert_well()


def case_whole_numbers_and_truths_at_the_ends_of_their_types(folder: str) -> None:
    one = Raw(folder)
    for variable in settable(one):
        if kind(variable) == "Integer":
            for value in (-(2**31), 2**31 - 1):
                before = one[variable.name]
                assert one.put(variable.name, value) == DISCARD
                one.assert_failed(f"'{variable.name}' = {value}")
                one[variable.name] = before
        if kind(variable) == "Boolean":
            for value in (2, -1, 2**31 - 1):
                one[variable.name] = value
                assert one[variable.name] == 1
            one[variable.name] = 0
            assert one[variable.name] == 0
    one.assert_well()


def case_bytes_that_are_no_text(folder: str) -> None:
    """In the code page of some machine, cut off, or half of a surrogate pair: any of them would end the process."""
    one = started(folder)
    state, references = one.state(), [v.valueReference for v in one.variables.values() if kind(v) == "String"]
    for bad in (b"\xff", b"caf\xe9", b"\xed\xa0\x80", b"\xf0\x9f"):
        assert one.set("String", references, [b"text"] * (len(references) - 1) + [bad]) == ERROR
        one.assert_failed("UTF-8")
        assert one.take(state) == OK
        one.assert_well()
        assert one.set("String", references[-1:], [None]) == ERROR  # an output
        one.assert_failed()
        assert one.take(state) == OK


def case_strings(folder: str) -> None:
    for variable in [v for v in settable(Raw(folder)) if kind(v) == "String"]:
        one, reference = prepared(Raw(folder)), [variable.valueReference]
        for text in ("", " ", "ünïcödé 航空 🛢", "%s%n%d%%", "../..//x", "line\nline", "a" * 1_000_000):
            one[variable.name] = text
            assert one[variable.name] == text
            one.assert_well()
        assert one.set("String", reference, [None]) == DISCARD
        one.assert_failed(f"'{variable.name}' is no string")
        one[variable.name] = PARAMETERS[one.description.modelName].get(variable.name, start_of(variable))
        one.assert_well()
        start_up(one)
