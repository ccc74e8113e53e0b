"""# A road tanker brakes

A half full tank truck brakes from 15 m/s. The liquid runs forward: how much load does it throw onto the front axle, what is left
on the rear one, and what do baffles change? Four answers from two FMUs of aeroslosh, in plain FMPy and nothing else:

- the cargo frozen: what a textbook does,
- `slosh_ems`: linear waves, milliseconds,
- `slosh_vof`: two-phase flow, without and with two baffles: waves break, the liquid hits the roof.

    .venv/bin/python examples/road_tanker.py [--fmus dist/fmus] [--out runs/road_tanker] [--quick]

The cells below (`# %%`) run one by one in an editor that knows them. What is special about these FMUs in a host of your own:

1. Inputs are the motion at the END of the step: set x, x_dot, x_ddot of the new time, then step.
2. A load depends on the acceleration of the same instant. The outputs `force_x_residual` … are the load less that of the same
   liquid frozen. Carry the frozen liquid on your own left side (`liquid_mass`), feed the residual, and one pass a step is stable
   although the liquid is as heavy as the truck.
3. Look at the status of each call: what cannot be done returns fmi2Error, a value out of its range fmi2Discard; `error` says why.
"""

from __future__ import annotations

import argparse
import base64
import json
import shutil
import sys
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import fmpy
import matplotlib
import numpy as np
from fmpy.fmi2 import FMU2Slave

matplotlib.use("Agg")
from matplotlib import pyplot

# %% The truck. x points aft, so that it drives towards -x and braking is an acceleration of +x. Everything in SI units.
GRAVITY = 9.81
MASS, CENTRE, HEIGHT = 8000.0, -0.8, 1.0  # of the empty truck [kg]; its centre of mass aft of and above the reference point [m]
FRONT, REAR = 3.0, 2.4  # axles, distance before and behind the reference point [m], which lies on the road
SPEED, GRIP = 15.0, 0.4  # at the start [m/s]; braking force over the weight of truck and cargo
PEDAL = 0.4  # time in which the brake is applied [s]
STEP, END = 0.01, 10.0  # [s]

TANK = {
    "tank_length": 5.0, "tank_height": 1.5, "tank_width": 2.3, "tank_x": 0.0, "tank_y": 1.9, "fill_level": 0.5,
    "liquid_density": 840.0, "liquid_viscosity": 4e-6,  # diesel
}  # fmt: skip
VOF = {"cells_x": 120, "cells_y": 36, "max_step": 0.01}
STYLES = {"frozen cargo": ("#1B2733", "--"), "linear waves": ("#D55E00", ":"), "two-phase flow": ("#0072B2", "-")}
QUICK = {"cells_x": 48, "cells_y": 16, "max_step": 0.01}  # for a first look
SLOSH_INPUTS = ("x", "x_dot", "x_ddot")
SLOSH_OUTPUTS = ("force_x", "force_y", "moment", "force_x_residual", "wave_height_west")


# %% One FMU in FMPy: variables by name. Nothing here is special to these FMUs.
class Instance:
    """An FMU that was unzipped, instantiated, given parameters and initialised."""

    def __init__(self, path: Path, parameters: dict[str, Any]) -> None:
        self.folder = fmpy.extract(str(path))
        description = fmpy.read_model_description(self.folder)
        self.variables = {variable.name: variable for variable in description.modelVariables}
        self.fmu = FMU2Slave(
            guid=description.guid,
            unzipDirectory=self.folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=path.stem,
        )
        self.fmu.instantiate()
        for name, value in parameters.items():
            self[name] = value
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        if "failed" in self.variables and self["failed"]:
            raise SystemExit(f"{path.name}: {self['error']}")

    def __setitem__(self, name: str, value: Any) -> None:
        variable = self.variables[name]
        if variable.type == "Real":
            self.fmu.setReal([variable.valueReference], [value])
        elif variable.type == "Boolean":
            self.fmu.setBoolean([variable.valueReference], [value])
        elif variable.type == "String":
            self.fmu.setString([variable.valueReference], [value])
        else:
            self.fmu.setInteger([variable.valueReference], [value])

    def __getitem__(self, name: str) -> Any:
        variable = self.variables[name]
        if variable.type == "Real":
            return self.fmu.getReal([variable.valueReference])[0]
        if variable.type == "Boolean":
            return bool(self.fmu.getBoolean([variable.valueReference])[0])
        if variable.type == "String":
            return self.fmu.getString([variable.valueReference])[0].decode()
        return self.fmu.getInteger([variable.valueReference])[0]

    def close(self) -> None:
        """Terminate, free, remove the unzipped folder."""
        self.fmu.terminate()
        self.fmu.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)


# %% The truck on the road: one equation for its way, two for its axles.
def acceleration(total: float, residual: float, speed: float, time: float) -> float:
    """Acceleration aft [m/s2] of truck and frozen cargo, `total` [kg], under the brake and the residual force [N].

    The brake gives up to GRIP times the weight, and no more than stops the truck within this step; a truck that stands is
    held as long as the brake is strong enough.
    """
    most = GRIP * total * GRAVITY * min(1.0, time / PEDAL)
    wanted = total * speed / STEP - residual  # the force that makes the speed 0 at the end of the step
    return (float(np.clip(wanted, -most, most)) + residual) / total


def axle_loads(a: float, force_y: float, moment: float) -> tuple[float, float]:
    """Vertical loads of front and rear axle [N]: weights, d'Alembert's force of the truck, and the liquid's force and moment."""
    upward = MASS * GRAVITY - force_y
    turning = CENTRE * MASS * GRAVITY - HEIGHT * MASS * a + moment  # nose-up, about the reference point
    front = (REAR * upward - turning) / (FRONT + REAR)
    return front, upward - front


# %% Drive: the motion at the end of the step goes in, the FMU steps, the loads come out.
def brake(path: Path, parameters: dict[str, Any], frozen: bool = False, fields: Path | None = None) -> dict[str, np.ndarray]:
    """Brake to a stop and stand; returns time, way, speed, axle loads, force and wave over time. Shape of each: (n_steps + 1,).

    frozen: leave the residual out, the cargo is a solid. fields: where slosh_vof writes its fields twice a second.
    """
    extra = {"field_folder": str(fields)} if fields else {}
    tank = Instance(path, {**parameters, **extra})
    liquid = tank["liquid_mass"]
    total = MASS + liquid
    x, speed, residual = 0.0, SPEED, 0.0
    rest = tank["static_force_y"], tank["static_moment"]
    level = TANK["tank_y"] - 0.5 * TANK["tank_height"] * (1.0 - TANK["fill_level"])  # of a solid's centre of mass
    rows = [[0.0, x, speed, *axle_loads(0.0, *rest), 0.0, 0.0]]
    for k in range(round(END / STEP)):
        a = acceleration(total, residual, speed, (k + 1) * STEP)
        speed -= a * STEP
        x -= speed * STEP
        for name, value in zip(SLOSH_INPUTS, (x, -speed, a), strict=True):
            tank[name] = value
        if fields:
            tank["write_fields"] = k % 50 == 49
        tank.fmu.doStep(k * STEP, STEP)
        force, force_y, moment, residual, wave = (tank[name] for name in SLOSH_OUTPUTS)
        if frozen:
            force, force_y, moment, residual, wave = -liquid * a, rest[0], rest[1] - level * liquid * a, 0.0, 0.0
        rows.append([(k + 1) * STEP, x, speed, *axle_loads(a, force_y, moment), force, wave])
    validity = tank["validity"] if "validity" in tank.variables and not frozen else 0.0
    tank.close()
    names = ("time", "x", "speed", "front", "rear", "force", "wave")
    return {**dict(zip(names, np.array(rows).T, strict=True)), "validity": np.array(validity), "liquid": np.array(liquid)}


def summary(run: dict[str, np.ndarray]) -> dict[str, float]:
    """What an engineer asks for. Loads [N], way [m], time [s]."""
    moving = np.flatnonzero(run["speed"] > 1e-9)
    stop = moving[-1] + 1
    return {
        "stopping_time": float(run["time"][stop]),
        "stopping_distance": float(-run["x"][stop]),
        "front_axle_max": float(run["front"].max()),
        "rear_axle_min": float(run["rear"].min()),
        "force_forward_max": float(-run["force"].min()),
        "impulse": float(-np.trapezoid(run["force"], run["time"]) / (run["liquid"] * SPEED)),  # 1 once the liquid is at rest
        "validity": float(run["validity"]),
    }


# %% A look into the tank: the fields that slosh_vof writes are VTK files (ParaView opens them); one array needs six lines.
def read_field(path: Path, name: str) -> np.ndarray:
    """The values of DataArray `name`. Shape: (n_values,) or (n_values, 3)."""
    array = next(item for item in ElementTree.parse(path).iter("DataArray") if item.get("Name") == name)
    raw = base64.b64decode(array.text or "")[8:]
    values = np.frombuffer(raw, dtype="<f8" if array.get("type") == "Float64" else "<f4")
    return values.reshape(-1, 3) if array.get("NumberOfComponents") == "3" else values


def draw_tank(axis: Any, path: Path, cells: dict[str, Any]) -> None:
    """Liquid in blue, in axes of the truck."""
    nx, ny = cells["cells_x"], cells["cells_y"]
    share = read_field(path, "volume_fraction").reshape(ny, nx)
    points = read_field(path, "points").reshape(ny + 1, nx + 1, 3)
    corner = points[0, 0]
    axis.pcolormesh(points[..., 0] - corner[0], points[..., 1] - corner[1], share, cmap="Blues", vmin=0.0, vmax=1.3)
    axis.set_aspect("equal")
    axis.set_xticks([])
    axis.set_yticks([])


def draw(runs: dict[str, dict[str, np.ndarray]], target: Path) -> None:
    """Axle loads, wave and speed over time."""
    figure, axes = pyplot.subplots(2, 2, figsize=(11.0, 7.0), sharex=True, layout="constrained")
    panels = (("front", 1e-3, "front axle [kN]"), ("rear", 1e-3, "rear axle [kN]"), ("wave", 1.0, "liquid at the front wall [m]"),
              ("speed", 1.0, "speed [m/s]"))  # fmt: skip
    for axis, (name, factor, label) in zip(axes.flat, panels, strict=True):
        for title, run in runs.items():
            # colours that people tell apart whatever their colour vision (Okabe and Ito), dashes say it a second time
            colour, dash = STYLES.get(title, ("#56B4E9", "-."))
            axis.plot(run["time"], factor * run[name], dash, color=colour, lw=1.3, label=title)
        axis.set_ylabel(label)
        axis.grid(alpha=0.25)
        axis.spines[["top", "right"]].set_visible(False)
    axes[0, 0].set_ylim(0, 1.1e-3 * max(run["front"].max() for run in runs.values()))
    signs, titles = axes[0, 0].get_legend_handles_labels()
    figure.legend(signs, titles, loc="outside lower center", ncols=4, frameon=False)
    for axis in axes[1]:
        axis.set_xlabel("time [s]")
    figure.suptitle(f"A road tanker brakes from {SPEED:g} m/s with {GRIP:g} g, tank half full")
    figure.savefig(target, dpi=150)
    pyplot.close(figure)


def draw_film(folders: dict[str, Path], cells: dict[str, Any], target: Path) -> None:
    """The tank at six times, one column a run. The truck drives to the left."""
    shown = (1.0, 1.5, 2.5, 4.0, 4.5, 6.0)
    figure, axes = pyplot.subplots(len(shown), len(folders), figsize=(9.0, 9.5), layout="constrained")
    for column, (title, folder) in enumerate(folders.items()):
        for row, time in enumerate(shown):
            draw_tank(axes[row, column], folder / f"fields_{round(time / STEP):06d}.vts", cells)
            axes[row, column].set_ylabel(f"{time:g} s")
        axes[0, column].set_title(f"{title} (front on the left)", fontsize=10)
    figure.savefig(target, dpi=120)
    pyplot.close(figure)


# %% All four, pictures and a table
def main(arguments: list[str] | None = None) -> int:
    """Run, print, draw; returns the exit code."""
    parser = argparse.ArgumentParser(description="A road tanker brakes: four models of its cargo.")
    parser.add_argument("--fmus", type=Path, default=Path("dist/fmus"))
    parser.add_argument("--out", type=Path, default=Path("runs/road_tanker"))
    parser.add_argument("--quick", action="store_true", help="a coarse grid")
    options = parser.parse_args(arguments)
    ems, vof = options.fmus / "slosh_ems.fmu", options.fmus / "slosh_vof.fmu"
    for path in (ems, vof):
        if not path.is_file():
            parser.error(f"{path} is not there; build the FMUs with `make fmus`, or name their folder with --fmus")
    options.out.mkdir(parents=True, exist_ok=True)
    cells = QUICK if options.quick else VOF
    fluid = {**TANK, **cells}
    folders = {name: (options.out / name.replace(" ", "_")).absolute() for name in ("two-phase flow", "with two baffles")}
    baffles = {"baffle_count": 2, "baffle_bottom": 0.1, "baffle_top": 0.7}
    runs = {
        "frozen cargo": brake(ems, TANK, frozen=True),
        "linear waves": brake(ems, TANK),
        "two-phase flow": brake(vof, fluid, fields=folders["two-phase flow"]),
        "with two baffles": brake(vof, {**fluid, **baffles}, fields=folders["with two baffles"]),
    }
    found = {name: summary(run) for name, run in runs.items()}
    print(f"{'':18s}{'stop after':>12s}{'way':>9s}{'front axle':>13s}{'rear axle':>12s}{'validity':>10s}")
    for name, s in found.items():
        print(
            f"{name:18s}{s['stopping_time']:10.2f} s{s['stopping_distance']:7.2f} m{s['front_axle_max'] / 1e3:10.1f} kN"
            f"{s['rear_axle_min'] / 1e3:9.1f} kN{s['validity']:10.2g}"
        )
    draw(runs, options.out / "loads.png")
    draw_film(folders, cells, options.out / "tank.png")
    (options.out / "summary.json").write_text(json.dumps(found, indent=2) + "\n", encoding="utf-8")
    print(f"pictures: {options.out / 'loads.png'}, {options.out / 'tank.png'}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
