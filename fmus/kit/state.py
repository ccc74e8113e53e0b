"""The state of an FMU: what a rollback restores and what a restart file holds, to the last bit.

A component hands out its state as a dictionary of NumPy arrays and scalars (`Slave.save`), by reference: no
array in it may be modified in place later (assign a new array, or save a copy). Taking a state then costs
microseconds.

In bytes (no pickle): magic, length of the header, header in JSON, raw bytes of the arrays, BLAKE2 checksum of
all before it. The header holds the hash of the component's sources: a state of another version is refused.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, field
from typing import Any

import numpy as np

MAGIC = b"aeroslosh state 1\n"
CHECKSUM = 32  # bytes


class StateError(ValueError):
    """A state that cannot be written or must not be used; its text says why and what to do."""


@dataclass
class State:
    """One saved state.

    Attributes:
        component: name of the FMU.
        content_hash: hash of the sources that made it.
        values: every declared variable by name.
        internals: time, mode and messages of the slave base class.
        snapshot: what the component's `save` returned.
        problem: why this state cannot be used, or "".
    """

    component: str
    content_hash: str
    values: dict[str, Any] = field(default_factory=dict)
    internals: dict[str, Any] = field(default_factory=dict)
    snapshot: dict[str, Any] = field(default_factory=dict)
    problem: str = ""
    packed: bytes | None = None  # the host asks for the size and then for the bytes: packed once

    def to_bytes(self) -> bytes:
        """Return the state as bytes.

        Raises:
            StateError: the snapshot holds something else than numbers, strings, bytes, arrays and
                dictionaries, lists or tuples of these.
        """
        if self.packed is None:
            blobs: list[bytes] = []
            tree = {"values": self.values, "internals": self.internals, "snapshot": self.snapshot}
            header = json.dumps(
                {
                    "component": self.component,
                    "content_hash": self.content_hash,
                    "problem": self.problem,
                    "tree": _encode(tree, blobs, self.component),
                    "sizes": [len(blob) for blob in blobs],
                }
            ).encode()
            body = b"".join([MAGIC, len(header).to_bytes(8, "little"), header, *blobs])
            self.packed = body + hashlib.blake2b(body, digest_size=CHECKSUM).digest()
        return self.packed

    @classmethod
    def from_bytes(cls, data: bytes, component: str, content_hash: str) -> State:
        """Return the state in `data`, made by `to_bytes` of the same component and sources.

        Raises:
            StateError: the bytes are damaged, of another component or of another version of its sources.
        """
        body, checksum = data[:-CHECKSUM], data[-CHECKSUM:]
        if not data.startswith(MAGIC):
            raise StateError("these bytes are no aeroslosh state. Remedy: give the bytes of fmi2SerializeFMUstate")
        if hashlib.blake2b(body, digest_size=CHECKSUM).digest() != checksum:
            raise StateError("the state is damaged (wrong checksum). Remedy: restart from an earlier state")
        start = len(MAGIC) + 8
        end = start + int.from_bytes(data[len(MAGIC) : start], "little")
        header = json.loads(data[start:end])
        check(header["component"], header["content_hash"], component, content_hash)
        blobs = []
        for size in header["sizes"]:
            blobs.append(data[end : end + size])
            end += size
        tree = _decode(header["tree"], blobs)
        return cls(component, content_hash, **tree, problem=header["problem"], packed=data)


def check(component: str, content_hash: str, wanted_component: str, wanted_hash: str) -> None:
    """Raise StateError unless a state of (component, content_hash) fits the wanted ones."""
    if component != wanted_component:
        raise StateError(
            f"the state belongs to FMU '{component}', not to '{wanted_component}'. Remedy: give each FMU its own state"
        )
    if content_hash != wanted_hash:
        raise StateError(
            f"the state was made by version {content_hash or '(source tree)'} of FMU '{component}', "
            f"this is {wanted_hash or '(source tree)'}. Remedy: continue with the FMU file that made "
            "it, or start anew"
        )


def _encode(value: Any, blobs: list[bytes], path: str) -> Any:
    """Return `value` as a JSON node [kind, ...]; array bytes go to `blobs`."""
    if value is None or (isinstance(value, bool | int | float | str) and not isinstance(value, np.generic)):
        return ["v", value]
    if isinstance(value, bytes):
        blobs.append(value)
        return ["b", len(blobs) - 1]
    if isinstance(value, np.ndarray | np.generic):
        array = np.asarray(value)
        if array.dtype.kind not in "biufc":
            raise StateError(f"{path}: an array of type {array.dtype} cannot be saved. Remedy: use numbers")
        # Fortran order is kept: the memory order decides the order of sums in the next step
        fortran = array.flags.f_contiguous and not array.flags.c_contiguous
        blobs.append(array.tobytes(order="F" if fortran else "C"))
        kind = "s" if isinstance(value, np.generic) else "f" if fortran else "a"
        return [kind, len(blobs) - 1, array.dtype.str, list(array.shape)]
    if isinstance(value, dict):
        if not all(isinstance(key, str) for key in value):
            raise StateError(f"{path}: the keys of a dictionary in the state must be strings")
        return ["d", {key: _encode(item, blobs, f"{path}.{key}") for key, item in value.items()}]
    if isinstance(value, list | tuple):
        nodes = [_encode(item, blobs, f"{path}[{i}]") for i, item in enumerate(value)]
        return ["l" if isinstance(value, list) else "t", nodes]
    raise StateError(f"{path}: a {type(value).__name__} cannot be saved. Remedy: give arrays and scalars in save()")


def _decode(node: Any, blobs: list[bytes]) -> Any:
    kind, content = node[0], node[1]
    if kind == "v":
        return content
    if kind == "b":
        return blobs[content]
    if kind == "d":
        return {key: _decode(item, blobs) for key, item in content.items()}
    if kind in "lt":
        items = [_decode(item, blobs) for item in content]
        return items if kind == "l" else tuple(items)
    array = np.frombuffer(blobs[content], dtype=np.dtype(node[2])).copy()
    if kind == "s":
        return array[0]
    return array.reshape(node[3], order="F" if kind == "f" else "C")
