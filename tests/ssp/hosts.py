"""Runs an SSP archive in one of the tools, in a process of its own: `hosts.py TOOL ARCHIVE DT STEPS SIGNALS(JSON) OUT.npz`.

Each function takes the archive, the step [s], the number of steps and names like "structure.alpha", and returns one row a step
and one column a name, values at the end of each step. The process ends by os._exit: pythonfmu releases its interpreter twice at
a normal exit."""

from __future__ import annotations

import json
import os
import sys
import traceback
from pathlib import Path
from typing import Any

import numpy as np


def run_fmpy(archive: str, dt: float, steps: int, signals: list[str], started: bool = False) -> np.ndarray:
    """FMPy's `simulate_ssp`. It reads the parameter sets but leaves it to its caller to pass them on, by "component.name" and,
    but for Reals, as values: it would take the text "false" for true. `started`: see `run_fmpy_started`."""
    from fmpy.ssp import simulation
    from fmpy.ssp.ssd import Parameter, ParameterSet, find_components, read_ssd

    if started:
        instantiate = simulation.instantiate_fmu

        def with_start_values(component: Any, *rest: Any) -> None:
            instantiate(component, *rest)
            for connector in component.connectors:
                if connector.kind == "input":
                    connector.value = simulation.get_value(component, connector.name)

        simulation.instantiate_fmu = with_start_values

    convert: dict[str, Any] = {"Real": float, "Integer": int, "Boolean": lambda text: text == "true", "String": str}
    given = ParameterSet(name="all")
    for component in find_components(read_ssd(archive).system):
        for binding in component.parameterBindings:
            for found in binding.parameterValues:
                for p in found.parameters:
                    name, value = f"{component.name}.{p.name}", convert[p.type](p.value)
                    given.parameters.append(Parameter(name=name, type=p.type, value=value, unit=p.unit))
    # half a step short: its time is a running sum, which may end just below the last step's start
    rows = simulation.simulate_ssp(archive, stop_time=(steps - 0.5) * dt, step_size=dt, parameter_set=given)
    return np.column_stack([rows[name] for name in signals])


def run_fmpy_started(archive: str, dt: float, steps: int, signals: list[str]) -> np.ndarray:
    """FMPy again, but the first step gets the inputs' start values: FMPy itself gives 0 to every input in the first step."""
    return run_fmpy(archive, dt, steps, signals, started=True)


def run_libcosim(archive: str, dt: float, steps: int, signals: list[str]) -> np.ndarray:
    """libcosim, step and parameters from the archive; `dt` is only checked."""
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimObserver import CosimObserver

    log_output_level(CosimLogLevel.WARNING)
    execution = CosimExecution.from_ssp_file(archive)
    observer = CosimObserver.create_last_value()
    assert execution.add_observer(observer)
    places = []
    for signal in signals:
        component, _, name = signal.partition(".")
        index = execution.slave_index_from_instance_name(component)
        reference = next(v.reference for v in execution.slave_variables(index) if v.name.decode() == name)
        places.append((index, reference))
    rows = []
    for step in range(1, steps + 1):
        assert execution.step(), f"step {step} failed"
        assert execution.status().current_time == step * round(dt * 1e9), "the archive's step is not dt"
        rows.append([observer.last_real_values(index, [reference])[0] for index, reference in places])
    return np.array(rows)


def run_ecos(archive: str, dt: float, steps: int, signals: list[str]) -> np.ndarray:
    """ecos, its instances in this process; the step is given by its caller, the parameter set by name."""
    from ecospy import EcosSimulation

    with EcosSimulation(ssp_path=archive, step_size=dt) as simulation:
        assert simulation.init(parameter_set="initialValues")
        rows = []
        for _ in range(steps):
            simulation.step()
            rows.append([simulation.get_real(signal.replace(".", "::")) for signal in signals])
        simulation.terminate()
    return np.array(rows)


TOOLS = {"fmpy": run_fmpy, "fmpy_started": run_fmpy_started, "libcosim": run_libcosim, "ecos": run_ecos}


def main() -> int:
    tool, archive, dt, steps, signals, out = sys.argv[1:]
    try:
        values = TOOLS[tool](archive, float(dt), int(steps), json.loads(signals))
        np.savez(Path(out), values=values)
    except BaseException:
        traceback.print_exc()
        return 1
    return 0


if __name__ == "__main__":
    code = main()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)
