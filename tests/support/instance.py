"""One FMU instance with variables by name, and what the FMUs logged."""

from __future__ import annotations

import tempfile
from ctypes import byref
from typing import Any

import fmpy
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.logging import addLoggerProxy

LOG: list[tuple[int, str, str]] = []


class Instance:
    """One FMU instance with variables by name."""

    def __init__(self, path: str, name: str = "test", folder: str | None = None) -> None:
        if folder is None:
            folder = tempfile.mkdtemp(prefix="fmu_")
            fmpy.extract(path, folder)
        self.folder = folder
        description = fmpy.read_model_description(folder)
        self.variables = {v.name: v for v in description.modelVariables}
        self.fmu = FMU2Slave(
            guid=description.guid,
            unzipDirectory=folder,
            instanceName=name,
            modelIdentifier=description.coSimulation.modelIdentifier,
        )
        self.callbacks = fmi2CallbackFunctions()
        self.callbacks.logger = fmi2CallbackLoggerTYPE(
            lambda _env, _name, status, category, message: LOG.append((status, category.decode(), message.decode()))
        )
        self.callbacks.allocateMemory = fmpy.fmi2.defaultCallbacks.allocateMemory
        self.callbacks.freeMemory = fmpy.fmi2.defaultCallbacks.freeMemory
        addLoggerProxy(byref(self.callbacks))
        self.fmu.instantiate(callbacks=self.callbacks, loggingOn=True)

    def __getitem__(self, name: str) -> Any:
        variable = self.variables[name]
        reference = [variable.valueReference]
        if variable.type == "Real":
            return self.fmu.getReal(reference)[0]
        if variable.type == "Boolean":
            return bool(self.fmu.getBoolean(reference)[0])
        if variable.type == "String":
            return self.fmu.getString(reference)[0].decode()
        return self.fmu.getInteger(reference)[0]

    def __setitem__(self, name: str, value: Any) -> None:
        variable = self.variables[name]
        reference = [variable.valueReference]
        setter = {"Real": self.fmu.setReal, "Boolean": self.fmu.setBoolean, "String": self.fmu.setString}.get(
            variable.type, self.fmu.setInteger
        )
        self._note(setter, reference, [value])

    def start(self, **values: Any) -> Instance:
        """Set `values`, go through initialisation."""
        for name, value in values.items():
            self[name] = value
        self._note(self.fmu.setupExperiment, startTime=0.0)
        self._note(self.fmu.enterInitializationMode)
        self._note(self.fmu.exitInitializationMode)
        return self

    def take(self, state: Any) -> int:
        """Set a state and return the FMI status."""
        return self._note(self.fmu.setFMUstate, state)

    def step(self, time: float, step_size: float) -> int:
        """Step and return the FMI status."""
        return self._note(self.fmu.doStep, time, step_size)

    def _note(self, call: Any, *arguments: Any, **more: Any) -> int:
        """The status of a call, which a host should look at and this one only keeps, in `last`: a scenario looks at `failed`."""
        try:
            call(*arguments, **more)
            self.last = 0
        except FMICallException as error:
            self.last = int(error.status)
        return self.last
