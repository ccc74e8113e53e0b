"""States in bytes: exact, self-checking, refused with a sentence."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from aeroslosh.fmus.kit.state import State, StateError

RANDOM = np.random.default_rng(1)
SNAPSHOT: dict[str, Any] = {
    "field": RANDOM.standard_normal((7, 5, 4)),
    "fortran": np.asfortranarray(RANDOM.standard_normal((3, 4))),
    "strided": RANDOM.standard_normal((6, 6))[::2, ::3],
    "single": RANDOM.standard_normal(3).astype(np.float32),
    "complex": np.array([1.0 + 2.0j]),
    "mask": np.array([True, False]),
    "index": np.arange(4, dtype=np.int32),
    "empty": np.zeros((0, 3)),
    "special": np.array([np.nan, np.inf, -np.inf, -0.0, 5e-324]),
    "scalar": np.float64(0.1),
    "number": 0.1 + 0.2,
    "nan": float("nan"),
    "text": "ä",
    "none": None,
    "raw": b"\x00\xff",
    "nested": {"levels": [np.ones(2), (1, np.zeros(1))]},
}


def same(a: Any, b: Any) -> bool:
    """Compare bit by bit, type by type."""
    if type(a) is not type(b):
        return False
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same(a[key], b[key]) for key in a)
    if isinstance(a, list | tuple):
        return len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()
    return np.float64(a).tobytes() == np.float64(b).tobytes() if isinstance(a, float) else bool(a == b)


def test_round_trip_is_exact_to_the_bit() -> None:
    state = State("x", "hash", {"a": 0.1, "b": True, "c": ""}, {"time": 1 / 3}, SNAPSHOT)
    back = State.from_bytes(state.to_bytes(), "x", "hash")
    assert same(back.snapshot, SNAPSHOT)
    assert same(back.values, state.values)
    assert same(back.internals, state.internals)
    assert back.snapshot["fortran"].flags.f_contiguous
    back.snapshot["field"][0] = 1.0  # may be written to
    assert State.from_bytes(state.to_bytes(), "x", "hash").to_bytes() == state.to_bytes()


@pytest.mark.parametrize(
    ("component", "content", "words"),
    [
        ("y", "hash", "belongs to FMU 'x', not to 'y'"),
        ("x", "other", "version hash of FMU 'x', this is other"),
    ],
)
def test_state_of_another_fmu_or_version_is_refused(component: str, content: str, words: str) -> None:
    with pytest.raises(StateError, match=words) as caught:
        State.from_bytes(State("x", "hash").to_bytes(), component, content)
    assert "Remedy" in str(caught.value)


@pytest.mark.parametrize("place", [3, 40, -40, -1])
def test_a_flipped_bit_is_found(place: int) -> None:
    data = bytearray(State("x", "hash", snapshot={"a": np.ones(100)}).to_bytes())
    data[place] ^= 4
    with pytest.raises(StateError):
        State.from_bytes(bytes(data), "x", "hash")


@pytest.mark.parametrize("data", [b"", b"short", State("x", "hash").to_bytes()[:-1]])
def test_cut_off_bytes_are_refused(data: bytes) -> None:
    with pytest.raises(StateError):
        State.from_bytes(data, "x", "hash")


@pytest.mark.parametrize("value", [{1, 2}, object(), np.array(["a"], dtype=object), {1: 2.0}])
def test_what_cannot_be_saved_is_named(value: object) -> None:
    with pytest.raises(StateError, match=r"x\.snapshot\.level\.bad"):
        State("x", "hash", snapshot={"level": {"bad": value}}).to_bytes()
