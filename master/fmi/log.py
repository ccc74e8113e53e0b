"""The log messages of FMUs, each to the component it is of.

FMPy's proxy, which formats the standard's variadic messages, hands the messages of all instances of a process to the logger set
last. So there is one, which looks the instance up by its name, and every living instance has a name of its own."""

from __future__ import annotations

import ctypes
from collections.abc import MutableSequence
from typing import Any, Protocol
from weakref import WeakValueDictionary

from fmpy import fmi2
from fmpy.logging import addLoggerProxy


class Owner(Protocol):
    """Who keeps messages: (status, text)."""

    @property
    def messages(self) -> MutableSequence[tuple[int, str]]:
        """The messages so far."""
        ...


_owners: WeakValueDictionary[str, Any] = WeakValueDictionary()


def register(name: str, owner: Owner) -> str:
    """The instance name for `owner`: `name`, or with a number behind it while another one lives."""
    unique, n = name, 1
    while unique in _owners:
        n += 1
        unique = f"{name}_{n}"
    _owners[unique] = owner
    return unique


def _log(_environment: Any, instance: bytes, status: int, _category: bytes, message: bytes) -> None:
    owner = _owners.get(instance.decode("utf-8", "replace") if instance else "")
    if owner is not None:
        owner.messages.append((status, message.decode("utf-8", "replace") if message else ""))


def _make() -> Any:
    made = fmi2.fmi2CallbackFunctions()
    made.logger = fmi2.fmi2CallbackLoggerTYPE(_log)
    made.allocateMemory = fmi2.defaultCallbacks.allocateMemory
    made.freeMemory = fmi2.defaultCallbacks.freeMemory
    addLoggerProxy(ctypes.byref(made))
    return made


callbacks = _make()  # as long as the process: instances hold it
