"""Messages of several instances of one FMU in one process: each reaches its own component."""

from __future__ import annotations

from pathlib import Path

import pytest

from aeroslosh.master.base.errors import ComponentError
from aeroslosh.master.fmi.component import Component


def test_each_instance_keeps_its_own_messages(doubles: Path) -> None:
    first, second = (Component(doubles / "aero.fmu", "aero") for _ in range(2))
    for component, fails in ((first, 1), (second, 2)):
        component.set_all({"airfoil": f"FAIL {fails}"})
        component.initialize()
    with pytest.raises(ComponentError) as caught:
        first.step(1e-3)
    assert "Traceback" in caught.value.traceback and not second.messages
    first.close()
    second.step(1e-3)
    with pytest.raises(ComponentError) as later:
        second.step(1e-3)
    assert "Traceback" in later.value.traceback
    second.close()
    third = Component(doubles / "aero.fmu", "aero")  # after the others are gone, and their loggers with them
    third.set_all({"airfoil": "FAIL 1"})
    third.initialize()
    with pytest.raises(ComponentError) as last:
        third.step(1e-3)
    assert "Traceback" in last.value.traceback
    third.close()
