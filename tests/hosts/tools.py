"""One FMU in another tool: `python tools.py TOOL JSON` prints its outputs after each step as JSON, floats in hexadecimal.

JSON: {"fmu": path, "parameters": {name: value}, "inputs": {name: [value at each communication point]}, "step": s, "outputs": []}
Each tool has a process of its own, and what it imports: the test process stays clean of foreign libraries.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
from typing import Any

Job = dict[str, Any]


def points(job: Job) -> int:
    """Communication points, the start among them."""
    return len(next(iter(job["inputs"].values())))


def direct(job: Job, at_end: bool) -> list[list[float]]:
    """FMI calls through FMPy's classes; a step gets the inputs of its end (as ours mean them) or of its start (as tools do)."""
    import fmpy
    from fmpy.fmi2 import FMU2Slave

    folder = tempfile.mkdtemp(prefix="fmu_")
    fmpy.extract(job["fmu"], folder)
    description = fmpy.read_model_description(folder)
    variables = {v.name: v for v in description.modelVariables}
    model = description.coSimulation.modelIdentifier
    fmu = FMU2Slave(guid=description.guid, unzipDirectory=folder, instanceName="direct", modelIdentifier=model)
    fmu.instantiate()
    for name, value in job["parameters"].items():
        kind = {"Real": fmu.setReal, "Boolean": fmu.setBoolean, "String": fmu.setString}.get(variables[name].type, fmu.setInteger)
        kind([variables[name].valueReference], [value])
    fmu.setupExperiment(startTime=0.0)
    references = [variables[name].valueReference for name in job["inputs"]]

    def feed(point: int) -> None:
        fmu.setReal(references, [values[point] for values in job["inputs"].values()])

    feed(0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    rows = []
    for i in range(points(job) - 1):
        feed(i + 1 if at_end else i)
        fmu.doStep(i * job["step"], job["step"])
        rows.append(fmu.getReal([variables[name].valueReference for name in job["outputs"]]))
    assert not fmu.getBoolean([variables["failed"].valueReference])[0]
    return rows


def direct_end(job: Job) -> list[list[float]]:
    """See `direct`."""
    return direct(job, at_end=True)


def direct_start(job: Job) -> list[list[float]]:
    """See `direct`."""
    return direct(job, at_end=False)


def fmpy(job: Job) -> list[list[float]]:
    """FMPy's simulate_fmu with a table of the inputs."""
    import numpy as np
    from fmpy import simulate_fmu

    n = points(job)
    table = np.zeros(n, dtype=[("time", float)] + [(name, float) for name in job["inputs"]])
    table["time"] = np.arange(n) * job["step"]
    for name, values in job["inputs"].items():
        table[name] = values
    result = simulate_fmu(
        job["fmu"],
        stop_time=(n - 1) * job["step"],
        output_interval=job["step"],
        start_values=job["parameters"],
        input=table,
        output=job["outputs"],
    )
    assert len(result) == n
    return [[float(row[name]) for name in job["outputs"]] for row in result[1:]]


def libcosim(job: Job) -> list[list[float]]:
    """libcosimpy: a fixed-step execution, inputs through an override manipulator, outputs through an observer."""
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimManipulator import CosimManipulator
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    execution = CosimExecution.from_step_size(step_size=round(job["step"] * 1e9))
    slave = execution.add_local_slave(CosimLocalSlave(fmu_path=job["fmu"], instance_name="one"))
    assert slave >= 0, "libcosim did not take the FMU"
    references = {v.name.decode(): v.reference for v in execution.slave_variables(slave)}
    for name, value in job["parameters"].items():
        kind = {float: execution.real_initial_value, bool: execution.boolean_initial_value, str: execution.string_initial_value}
        assert kind.get(type(value), execution.integer_initial_value)(slave, references[name], value)
    override, observer = CosimManipulator.create_override(), CosimObserver.create_last_value()
    assert execution.add_manipulator(override) and execution.add_observer(observer)
    rows = []
    for i in range(points(job) - 1):
        override.slave_real_values(
            slave, [references[n] for n in job["inputs"]], [values[i] for values in job["inputs"].values()]
        )
        assert execution.step()
        rows.append(list(observer.last_real_values(slave, [references[name] for name in job["outputs"]])))
    return rows


def ecos(job: Job) -> list[list[float]]:
    """ecospy: a simulation structure with a parameter set; `prefix` in the job names how the FMU is run."""
    from ecospy import EcosSimulation, EcosSimulationStructure
    from ecospy.lib import EcosLib

    EcosLib.set_log_level("info")
    structure = EcosSimulationStructure()
    structure.add_model("one", job.get("prefix", "") + job["fmu"])
    structure.add_parameter_set("initialValues", {f"one::{name}": value for name, value in job["parameters"].items()})
    simulation = EcosSimulation(structure=structure, step_size=job["step"])
    simulation.init(parameter_set="initialValues")
    rows = []
    for i in range(points(job) - 1):
        for name, values in job["inputs"].items():
            simulation.set_real(f"one::{name}", values[i])
        simulation.step()
        rows.append([simulation.get_real(f"one::{name}") for name in job["outputs"]])
    simulation.terminate()
    return rows


TOOLS = {tool.__name__: tool for tool in (direct_start, direct_end, fmpy, libcosim, ecos)}

if __name__ == "__main__":
    task = json.loads(sys.argv[2])
    found = TOOLS[sys.argv[1]](task)
    print(json.dumps([[value.hex() for value in row] for row in found]), flush=True)
    if task.get("end") != "ordinary":
        os._exit(0)  # whatever the FMU does at an ordinary end, which has a test of its own
