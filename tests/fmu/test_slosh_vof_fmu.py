"""The slosh_vof FMU through FMPy: the Python interface's numbers, communication steps, rollback, bad input, fields."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from zipfile import ZipFile

import numpy as np
from fmpy.validation import validate_fmu

from aeroslosh.fmus.slosh_vof.flow import Flow, Fluids, Numerics
from aeroslosh.fmus.slosh_vof.grid import Grid
from aeroslosh.fmus.slosh_vof.probes import Probe
from aeroslosh.fmus.tank import faraday
from aeroslosh.fmus.tank.liquid import Tank
from aeroslosh.fmus.tank.modes import modes
from aeroslosh.fmus.tank.motion import SectionMotion
from aeroslosh.master.base import vtk

Fmu = Callable[[str], Path]
Host = Callable[..., Any]
ERROR = 3  # fmi2Error
BOX = {"cells_x": 32, "cells_y": 16}
LOADS = ["force_x", "force_y", "moment"]
RESIDUAL = [f"{name}_residual" for name in LOADS]
PITCH = {"alpha": [math.pi / 180, 3.14, 0.0]}


def test_description_has_no_problems_and_the_shared_interface(fmu: Fmu) -> None:
    assert validate_fmu(str(fmu("slosh_vof"))) == []
    with ZipFile(fmu("slosh_vof")) as archive:
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    kinds: dict[str, dict[str, str | None]] = {"input": {}, "output": {}, "parameter": {}}
    for scalar in root.iter("ScalarVariable"):
        kinds[str(scalar.get("causality"))][str(scalar.get("name"))] = scalar[0].get("unit") or scalar[0].tag
    motion = {"h": "m", "h_dot": "m/s", "h_ddot": "m/s2", "alpha": "rad", "alpha_dot": "rad/s", "alpha_ddot": "rad/s2",
              "x": "m", "x_dot": "m/s", "x_ddot": "m/s2", "write_fields": "Boolean"}  # fmt: skip
    loads = {"force_x": "N/m", "force_y": "N/m", "moment": "N", "force_x_residual": "N/m", "force_y_residual": "N/m",
             "moment_residual": "N", "static_force_y": "N/m", "static_moment": "N", "liquid_mass": "kg/m",
             "liquid_static_moment": "kg", "liquid_inertia": "kg.m", "liquid_stiffness": "N/rad", "force_x_tank": "N/m",
             "force_y_tank": "N/m", "force_west": "N/m", "force_east": "N/m", "liquid_volume": "m3", "wave_height_west": "m",
             "wave_height_east": "m", "work": "J/m", "wave_growth": "1", "time_step": "s", "steps": "Integer",
             "iterations": "Integer",
             "residual": "1", "converged": "Boolean", "failed": "Boolean", "error": "String"}  # fmt: skip
    loads |= {f"probe{n}_{name}": "Pa" for n in range(1, 7) for name in ("pressure", "pressure_area", "pressure_mean")}
    loads |= {f"gauge{n}_height": "m" for n in range(1, 5)}
    wanted = {"tank_length", "tank_height", "tank_width", "fill_level", "tank_x", "tank_y", "liquid_density", "gas_density",
              "liquid_viscosity", "gas_viscosity", "gravity", "cells_x", "cells_y", "cfl", "tolerance", "max_step",
              "wall_slip", "wall_layer", "motion_prediction", "surface_tension",
              "initial_wave", "baffle_count", "baffle_bottom", "baffle_top", "field_folder", "probe_count",
              "probe_window", "gauge_count", "side_wall_omega",
              "initial_column", "initial_spectrum", "initial_seed", "initial_file", "ribs", "gas_pressure",
              "gas_gamma"}  # fmt: skip
    wanted |= {f"probe{n}_{name}" for n in range(1, 7) for name in ("x", "y", "extent")} | {f"gauge{n}_x" for n in range(1, 5)}
    assert kinds["input"] == motion
    assert kinds["output"] == loads
    assert set(kinds["parameter"]) == wanted


def test_rest_is_static_load_and_no_residual_gas_included(fmu: Fmu, host: Host) -> None:
    """Half a metre by 0.15 m by 2 m, 30 % full of kerosene under nitrogen at 20 bar: 23 kg/m3, 9 % of the weight."""
    tank = {"tank_width": 2.0, "fill_level": 0.3, "liquid_density": 800.0, "gas_density": 23.0, "tank_x": 0.4, "tank_y": -0.1}
    rest = {"h": [0.0, 1.0, 0.0]}
    names = [
        *LOADS,
        *RESIDUAL,
        "static_force_y",
        "static_moment",
        "liquid_mass",
        "liquid_static_moment",
        "liquid_volume",
        "residual",
    ]
    run = np.array(host("vof_steps", str(fmu("slosh_vof")), {**BOX, **tank}, rest, [[0.01, 10]], names)[0])
    volume = 0.5 * 0.15 * 2.0
    liquid, gas = 800.0 * 0.3 * volume, 23.0 * 0.7 * volume
    weight = (liquid + gas) * 9.81
    np.testing.assert_allclose(run[:, 6:8], [[-weight, 0.4 * weight]] * 11, rtol=1e-12)
    np.testing.assert_allclose(run[:, 8:10], [[liquid, 0.4 * liquid]] * 11, rtol=1e-12)
    np.testing.assert_allclose(run[:, :3], [[0.0, -weight, 0.4 * weight]] * 11, rtol=0.0, atol=1e-7 * weight)
    np.testing.assert_allclose(run[:, 3:6], 0.0, atol=1e-7 * weight)
    np.testing.assert_allclose(run[0, 3:6], 0.0, atol=1e-9 * weight)
    np.testing.assert_allclose(run[:, 10], 0.3 * volume, rtol=1e-12)


def test_initial_inputs_tilt_and_push_the_tank(fmu: Fmu, host: Host) -> None:
    tank = Tank(0.5, 0.15, x=0.4, y=0.1)
    gas = 1.2 * 0.5 * 0.075
    names = [*LOADS, *RESIDUAL, "wave_height_west", "wave_height_east"]
    place = {"tank_x": 0.4, "tank_y": 0.1}
    finer = {"cells_x": 64, "cells_y": 32, "gas_density": 0.01}
    falling, tilted, pushed, turned = host(
        "vof_starts", str(fmu("slosh_vof")),
        [{**place, "h_ddot": 3.0}, {**place, "alpha": 0.1}, {**finer, "x_ddot": 2.0}, {"alpha_ddot": 5.0}], names,
    )  # fmt: skip
    # in a lift: less weight; the structure carries the liquid's inertia, that of the gas remains
    weight = (tank.mass + gas) * (9.81 - 3.0)
    np.testing.assert_allclose(falling[:6], [0.0, -weight, 0.4 * weight, 0.0, 3.0 * gas, -0.4 * 3.0 * gas], atol=1e-8 * weight)
    # level surface in a tilted tank: the centre of a trapezium, hydrostatics alone
    slope = math.tan(0.1)
    along = 0.4 + 0.5**2 * slope / (12 * 0.075)
    up = 0.1 - 0.0375 + 0.5**2 * slope**2 / (24 * 0.075)
    liquid, all_gas = (1000.0 - 1.2) * 0.0375, 1.2 * 0.075
    moment = 9.81 * (
        liquid * (along * math.cos(0.1) + up * math.sin(0.1)) + all_gas * (0.4 * math.cos(0.1) + 0.1 * math.sin(0.1))
    )
    np.testing.assert_allclose(tilted[:2], [0.0, -(tank.mass + gas) * 9.81], atol=1e-4)
    np.testing.assert_allclose(tilted[2], moment, rtol=2e-4)
    # the last column's middle lies half a cell before the wall
    np.testing.assert_allclose(tilted[6:], [-slope * 0.5 * 31 / 64, slope * 0.5 * 31 / 64], rtol=2e-3)
    # a push: only the liquid that cannot slosh takes part (1.0 % off on these cells, 0.2 % on 200 x 60)
    level = Tank(0.5, 0.15)
    np.testing.assert_allclose(pushed[0], -2.0 * modes(level, 200, "high").fixed_mass, rtol=0.015)
    np.testing.assert_allclose(pushed[3], pushed[0] + 2.0 * level.mass, rtol=1e-12)
    # a start of turning: the surface is level still, the moment nose-down
    assert turned[2] < -1.0
    np.testing.assert_allclose(turned[6:], 0.0, atol=1e-12)


def test_residual_and_carried_load_are_the_whole(fmu: Fmu, host: Host) -> None:
    """What a structure carries on its left side, written out here: m, S, I, k and the static load."""
    waves = {"h": [2e-3, 31.0, 0.2], "alpha": [0.05, 6.0, 0.4], "x": [1e-3, 7.0, 1.0]}
    names = [*LOADS, *RESIDUAL, "static_force_y", "static_moment", "liquid_mass", "liquid_static_moment", "liquid_inertia",
             "liquid_stiffness"]  # fmt: skip
    values = {**BOX, "tank_x": 0.4, "tank_y": 0.1}
    run = np.array(host("vof_steps", str(fmu("slosh_vof")), values, waves, [[0.01, 30]], names)[0])
    t = 0.01 * np.arange(31)
    position = {name: size * np.sin(omega * t + phase) for name, (size, omega, phase) in waves.items()}
    h, alpha, x = (-(waves[name][1] ** 2) * position[name] for name in ("h", "alpha", "x"))
    force_x, force_y, moment, rest_x, rest_y, rest_m, static_y, static_m, m, S, I, k = run.T
    centre = 0.1 - 0.075 + 0.0375
    np.testing.assert_allclose(force_x, -m * (x + centre * alpha) + rest_x, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(force_y, static_y + m * h + S * alpha + rest_y, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(moment, static_m - S * h - I * alpha - k * position["alpha"] + rest_m, rtol=0.0, atol=1e-9)
    assert np.ptp(rest_m) > 1.0


def test_communication_steps_do_not_matter(fmu: Fmu, host: Host) -> None:
    """Pitch of one degree over 0.2 s in steps of 1e-4 to 0.1 s, over 0.01 s in steps of 1e-5 s; differences over the swing.

    What communication steps change is the internal steps alone, and the load at the first ones, where the pressure still lies
    within its tolerance and no iteration is made.
    """
    path, end = str(fmu("slosh_vof")), 0.2
    names = ["force_x", "moment", "force_x_residual", "moment_residual"]

    def runs(sizes: list[float], duration: float, **values: float) -> list[np.ndarray]:
        steps = [[h, round(duration / h)] for h in sizes]
        return [np.array(run) for run in host("vof_steps", path, {**BOX, "max_step": 2e-3, **values}, PITCH, steps, names)]

    def differ(one: np.ndarray, other: np.ndarray, what: str) -> np.ndarray:
        error = np.abs(one - other[:: (len(other) - 1) // (len(one) - 1)]) / swing
        print(f"{what}: {error.max():.1e}")
        return error

    for tolerance, limit in ((1e-6, 3e-4), (1e-7, 8e-5)):
        fine, short, long, longest = runs([1e-4, 1e-3, 1e-2, 1e-1], end, tolerance=tolerance)
        swing = np.ptp(fine, axis=0)
        # the same internal steps of 2 ms: what is left is how well quintics follow a sine
        assert differ(longest, long, "0.1 s against 0.01 s").max() < 1e-7
        for run, name in ((long, "0.01"), (longest, "0.1"), (short, "0.001")):
            error = differ(run, fine, f"{name} s against 1e-4 s, tolerance {tolerance:g}")
            assert error.max() < 5e-3
            assert error[len(error) // 20 :].max() < limit
        (same,) = runs([1e-2], end, tolerance=tolerance, max_step=1e-3)
        assert differ(same, short, "0.01 s against 0.001 s, internal steps of 1 ms").max() < 1e-6
        tiny, short = runs([1e-5, 1e-3], 0.01, tolerance=tolerance)
        assert differ(short, tiny, f"0.001 s against 1e-5 s, tolerance {tolerance:g}").max() < (
            5e-3 if tolerance > 5e-7 else 5e-5
        )


def test_instruments_read_what_the_python_interface_reads(fmu: Fmu, host: Host) -> None:
    """Probes and gauges in use; those out of use read nothing, wherever they are."""
    values = {**BOX, "probe_count": 2, "probe1_y": 0.05, "probe1_extent": 0.02, "probe2_x": 0.2, "probe2_y": 0.01,
              "probe3_x": 0.9, "probe_window": 0.05, "gauge_count": 1, "gauge1_x": 0.05, "gauge2_x": 9.0}  # fmt: skip
    kinds = ("pressure", "pressure_area", "pressure_mean")
    names = [f"probe{n}_{kind}" for n in (1, 2) for kind in kinds]
    unused = [f"probe{n}_{kind}" for n in (3, 6) for kind in kinds] + ["gauge2_height", "gauge4_height"]
    run = np.array(host("vof_steps", str(fmu("slosh_vof")), values, PITCH, [[0.01, 20]], [*names, "gauge1_height", *unused])[0])
    flow = Flow(Grid(Tank(0.5, 0.15), 32, 16), sensors=(Probe(0.0, 0.05, 0.02), Probe(0.2, 0.01)), window=0.05)
    size, omega, _ = PITCH["alpha"]
    t = 0.01 * np.arange(21)
    alpha = np.array([size * np.sin(omega * t), size * omega * np.cos(omega * t), -size * omega**2 * np.sin(omega * t)]).T
    steps = [SectionMotion(0.0, 0.0, 0.0, *row) for row in alpha.tolist()]
    flow.start(steps[0])
    rows = [[*np.ravel(flow.pressures()), *flow.heights(np.array([0.05]))]]
    for k in range(20):
        flow.advance(steps[k], steps[k + 1], 0.01)
        rows.append([*np.ravel(flow.pressures()), *flow.heights(np.array([0.05]))])
    np.testing.assert_allclose(run[:, :7], rows, rtol=1e-6, atol=1e-6)
    assert np.ptp(run[:, 0]) > 5.0
    assert not run[:, 7:].any()


def test_work_is_the_integral_of_load_times_velocity(fmu: Fmu, host: Host) -> None:
    """By trapezia between communication steps; plunge is positive down, the force positive up."""
    waves = {"h": [2e-3, 31.0, 0.2], "alpha": [0.05, 6.0, 0.4], "x": [1e-3, 7.0, 1.0]}
    run = np.array(host("vof_steps", str(fmu("slosh_vof")), {**BOX, "tank_x": 0.4}, waves, [[5e-3, 60]], [*LOADS, "work"])[0])
    t = 5e-3 * np.arange(61)
    h, alpha, x = (waves[n][0] * waves[n][1] * np.cos(waves[n][1] * t + waves[n][2]) for n in ("h", "alpha", "x"))
    power = run[:, 0] * x - run[:, 1] * h + run[:, 2] * alpha
    work = np.concatenate([[0.0], np.cumsum(0.5 * 5e-3 * (power[1:] + power[:-1]))])
    np.testing.assert_allclose(run[:, 3], work, rtol=0.0, atol=1e-12 * np.abs(work).max())
    assert np.abs(work).max() > 1.0


def test_simulate_fmu_gives_the_numbers_of_the_python_interface(fmu: Fmu, host: Host) -> None:
    """FMPy applies a table's row at the start of the step that leaves it: the motion arrives one step late, here too."""
    names = ["h", "h_dot", "h_ddot", "alpha", "alpha_dot", "alpha_ddot", "x", "x_dot", "x_ddot"]
    step_size, size, omega = 5e-3, np.array([2e-3, 0.05, 1e-3]), np.array([31.0, 6.0, 7.0])
    times = step_size * np.arange(41)
    s, c = np.sin(omega * times[:, None]), np.cos(omega * times[:, None])
    motion = np.stack([size * s, size * omega * c, -size * omega**2 * s], axis=2).reshape(41, 9)
    wanted = [*LOADS, "force_x_tank", "force_y_tank", "force_west", "force_east", "liquid_volume", "wave_height_west",
              "wave_height_east", "time_step", "steps", "iterations", "residual"]  # fmt: skip
    parameters = {**BOX, "fill_level": 0.4, "tank_x": 0.3, "tank_y": 0.1, "gas_density": 2.0, "surface_tension": 0.07,
                  "wall_slip": True, "initial_wave": 0.01, "max_step": 1.5e-3}  # fmt: skip
    table = np.column_stack([times, motion]).tolist()
    found = np.array(host("vof_simulate", str(fmu("slosh_vof")), parameters, table, names, wanted))
    np.testing.assert_allclose(found[:, 0], times, rtol=1e-14)
    grid = Grid(Tank(0.5, 0.15, fill_level=0.4, x=0.3, y=0.1), 32, 16)
    flow = Flow(grid, Fluids(gas_density=2.0, surface_tension=0.07), Numerics(wall_slip=True, max_step=1.5e-3))
    steps = [SectionMotion(*row) for row in motion.tolist()]
    report = flow.start(steps[0], 0.01)
    rows = []
    for k in range(41):
        now = steps[max(k - 1, 0)]
        if k:
            report = flow.advance(steps[max(k - 2, 0)], now, step_size)
        rows.append([*flow.loads(now), flow.volume, *flow.wave_heights, report.step_size, report.steps, report.iterations,
                     report.residual])  # fmt: skip
    np.testing.assert_array_equal(found[:, 1:], np.array(rows))
    assert np.ptp(found[:, 1]) > 5.0


def test_rollback_and_restart_in_a_new_process_are_exact_to_the_bit(fmu: Fmu, host: Host, tmp_path: Path) -> None:
    kept, path = str(tmp_path / "state"), str(fmu("slosh_vof"))
    values = {"cells_x": 40, "cells_y": 20, "fill_level": 0.4, "tank_x": 0.3, "baffle_count": 1, "surface_tension": 0.07}
    seen = host("vof_rollback", path, values, 5e-3, kept)
    first, second, third = seen["runs"]
    assert first == second == third
    assert first[0] != first[-1]
    assert seen["now"] == seen["before"][: len(seen["now"])]
    assert host("vof_resume", path, 5e-3, kept) == first


def test_ribs_are_part_of_the_state(fmu: Fmu, host: Host, tmp_path: Path) -> None:
    """A compartment and a slotted rib, carried by the bytes into an instance that never heard of them."""
    kept, path = str(tmp_path / "state"), str(fmu("slosh_vof"))
    values = {"cells_x": 40, "cells_y": 20, "tank_x": 0.3, "ribs": "x=-0.05; x=0.1 open=0:0.02,0.13:0.15"}
    seen = host("vof_rollback", path, values, 5e-3, kept)
    assert seen["runs"][0] == seen["runs"][1] == seen["runs"][2]
    assert host("vof_resume", path, 5e-3, kept) == seen["runs"][0]


def test_ribs_make_the_loads_of_their_flow(fmu: Fmu, host: Host) -> None:
    """Closed in the middle: the waves of half tanks, calmer than those of the whole; wave growth by the shorter lengths."""
    waves = {"h": [2e-3, 20.0, 0.0], "alpha": [0.02, 6.0, 0.0]}
    names = ["force_x", "moment_residual", "work", "wave_growth", "force_west"]
    runs = [
        np.array(host("vof_steps", str(fmu("slosh_vof")), {**BOX, "ribs": text}, waves, [[0.01, 60]], names)[0])
        for text in ("", "x=0 open=0:0.15", "x=0", "x=0.07; x=-0.1")
    ]
    np.testing.assert_array_equal(runs[0], runs[1])
    assert np.ptp(runs[2][:, 1]) < 0.5 * np.ptp(runs[0][:, 1])
    assert np.abs(runs[3][:, 0] - runs[2][:, 0]).max() > 0.01 * np.ptp(runs[2][:, 0])
    half = Tank(0.25, 0.15, gravity=9.81)
    waves_of_half, grown, growth = faraday.waves(half, 1e-6), faraday.still(), []
    for k in range(60):
        change = [
            faraday.gravity_change(half, SectionMotion(0.0, 0.0, -2e-3 * 20.0**2 * math.sin(20.0 * t), alpha, 0.0, 0.0))
            for t in (0.01 * k, 0.01 * (k + 1))
            for alpha in (0.02 * math.sin(6.0 * t),)
        ]
        growth.append(faraday.grow(grown, *change, 0.01, waves_of_half))
    np.testing.assert_allclose(runs[2][1:, 3], growth, rtol=0.02, atol=1e-4)
    assert np.abs(runs[2][:, 3] - runs[0][:, 3]).max() > 1e-3


def test_tanks_of_one_process_do_not_disturb_each_other_and_a_baffle_counts(fmu: Fmu, host: Host) -> None:
    shallow, deep, baffled, alone = host("vof_family", str(fmu("slosh_vof")))
    assert shallow == alone
    assert abs(baffled[0] - deep[0]) > 0.05 * abs(deep[0]) > 0.1
    assert shallow != deep


def test_two_hundred_instances(fmu: Fmu, host: Host) -> None:
    assert host("many_flows", str(fmu("slosh_vof")), 200, BOX) == 200


def test_bad_parameters_are_clear_errors(fmu: Fmu, host: Host) -> None:
    cases: list[tuple[dict[str, Any], list[str]]] = [
        ({"fill_level": 0.0}, ["'fill_level' = 0.0", "at least 1e-06"]),
        ({"fill_level": 1.2}, ["'fill_level' = 1.2", "at most 1.0"]),
        ({"cells_x": 3, "cells_y": 3}, ["'cells_x' = 3", "at least 16", "'cells_y' = 3"]),
        ({"tank_length": -1.0}, ["'tank_length' = -1.0 m"]),
        ({"gas_density": 0.0}, ["gas_density = 0", "Remedy: above 0"]),
        ({"liquid_density": math.nan}, ["'liquid_density' = nan"]),
        ({"cfl": 0.9}, ["'cfl' = 0.9", "at most 0.5"]),
        ({"initial_wave": 0.1}, ["initial_wave = 0.1 m leaves the tank", "Remedy"]),
        ({"initial_column": 0.1}, ["initial_column = 0.1 m", "Remedy: from 0.25 to 0.5 m"]),
        ({"initial_column": 0.3, "initial_spectrum": 0.01}, ["more than one shape"]),
        ({"initial_file": "nowhere.csv"}, ["nowhere.csv cannot be read", "Remedy"]),
        ({"baffle_count": 10}, ["10 baffles in 32 cells", "at least 44"]),
        ({"baffle_count": 1, "baffle_top": 0.0}, ["baffles from 0 to 0", "Remedy"]),
        ({"baffle_count": 1, "baffle_top": 1.0}, ["from floor to roof", "Remedy"]),
        ({"ribs": "x=0.3"}, ["x=0.3 m lies outside the tank", "Remedy"]),
        ({"ribs": "x=0; x=0.001"}, ["x=0 and x=0.001 m stand on one cell face", "Remedy"]),
        ({"ribs": "x=0 open=0:0.004"}, ["lower than a cell", "cells_y = 38"]),
        ({"ribs": "x=0", "baffle_count": 1}, ["a baffle and a rib on one cell face"]),
        ({"ribs": "middle"}, ["'middle'", "Remedy"]),
        ({"probe_count": 7}, ["'probe_count' = 7", "at most 6"]),
        ({"probe_count": 2, "probe2_x": 0.6}, ["probe2_x = 0.6 m lies outside", "from 0 to 0.5 m"]),
        ({"probe_count": 1, "probe1_y": 0.2}, ["probe1_y = 0.2 m lies outside", "Remedy"]),
        ({"gauge_count": 1, "gauge1_x": 0.51}, ["gauge1_x = 0.51 m lies outside", "Remedy"]),
        ({"write_fields": True}, ["field_folder is empty", "Remedy"]),
    ]
    seen = host("vof_bad_starts", str(fmu("slosh_vof")), [values for values, _ in cases])
    for (values, words), one in zip(cases, seen, strict=True):
        assert one["failed"] is True, values
        assert one["status"] == ERROR
        for word in words:
            assert word in one["error"], one["error"]


def test_inputs_no_tank_survives_are_refused_and_the_instance_lives_on(fmu: Fmu, host: Host) -> None:
    cases = [
        ("h_ddot", 1e6, "'h_ddot' = 1000000.0 m/s2", "at most 100000.0"),
        ("x_ddot", -1e6, "'x_ddot' = -1000000.0 m/s2", "at least -100000.0"),
        ("alpha_ddot", 1e7, "'alpha_ddot' = 10000000.0 rad/s2", "at most 1000000.0"),
        ("alpha_dot", 1e5, "'alpha_dot' = 100000.0 rad/s", "at most 1000.0"),
        ("alpha", None, "'alpha' = nan", "not a finite number"),
        ("h", 1e300, "'h' = 1e+300 m", "at most 1000000000.0"),
    ]
    seen = host("vof_bad_inputs", str(fmu("slosh_vof")), [case[:2] for case in cases])
    for (_, _, what, remedy), one in zip(cases, seen["seen"], strict=True):
        assert one["status"] == ERROR
        assert what in one["error"]
        assert remedy in one["error"]
        assert one["force_x"] == "nan"
        assert one["again"] == 0
    assert seen["failed"] is False
    # no trace of the refused values
    assert seen["loads"][0] == seen["loads"][1]


def test_fields_are_written_on_request(fmu: Fmu, host: Host, tmp_path: Path) -> None:
    seen = host("vof_fields", str(fmu("slosh_vof")), str(tmp_path / "fields"))
    assert seen["files"] == ["fields_000000.vts", "fields_000002.vts"]
    assert seen["status"] == ERROR
    assert "field_folder" in seen["error"]
    start, later = (vtk.read(tmp_path / "fields" / name) for name in seen["files"])
    assert start.whole["TimeValue"] == [0.0]
    np.testing.assert_allclose(later.whole["TimeValue"], [2e-3], rtol=1e-12)
    # at rest: hydrostatics below half the height, pressure 0 at the roof
    gap, dy = 1.2 * 9.81 * 0.075, 0.15 / 16
    depths = (7.5 - np.arange(8)) * dy
    np.testing.assert_allclose(start.cells["pressure"][:8], np.tile(gap + 9810.0 * depths, (32, 1)).T, rtol=1e-5)
    np.testing.assert_allclose(start.cells["density"][[0, -1]], [[1000.0] * 32, [1.2] * 32], rtol=1e-6)
    for field in (start, later):
        np.testing.assert_allclose(field.cells["volume_fraction"].sum() * dy * 0.5 / 32, seen["volume"], rtol=1e-6)
    # second step: down by 1 cm, aft by 10 cm, nose-up by 0.02 rad about the elastic axis
    c, s = math.cos(0.02), math.sin(0.02)
    x, y = 0.05, -0.075
    np.testing.assert_allclose([later.x[0, 0], later.y[0, 0]], [0.1 + x * c + y * s, -0.01 - x * s + y * c], atol=1e-7)
    foot, tip, rib_foot, rib_tip = later.whole["baffles"]
    np.testing.assert_allclose(tip[:2] - foot[:2], [0.075 * s, 0.075 * c], atol=1e-12)
    np.testing.assert_allclose(foot[:2], [0.1 + 0.3 * c + y * s, -0.01 - 0.3 * s + y * c], atol=1e-12)
    # a rib 0.125 m aft of the tank's centre, with a slot on the roof
    np.testing.assert_allclose(rib_foot[:2], [0.1 + 0.425 * c + y * s, -0.01 - 0.425 * s + y * c], atol=1e-12)
    np.testing.assert_allclose(rib_tip[:2] - rib_foot[:2], [0.15 * 12 / 16 * s, 0.15 * 12 / 16 * c], atol=1e-12)
    assert later.cells["velocity"].shape == (16, 32, 3)
    assert 0.0 < np.abs(later.cells["velocity"]).max() < 100.0
