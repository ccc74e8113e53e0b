"""OpenFOAM's interFoam on a two-dimensional rectangular tank: a peer to measure the project's own two-phase solver against.

The case is written here whole (`write`), run as a process of its own (`run`), and given back as forces on the walls. Frame:
x to the east, y up, origin at the centre of the tank (not at the water level); theta counter-clockwise, in rad. Everything is
per metre of depth into the page. Written for OpenFOAM v1912 (the release of openfoam.com, Debian's package `openfoam`).
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

Array = NDArray[np.float64]

GRAVITY = 9.81  # m/s²
LIQUID = (1000.0, 1e-6)  # density kg/m³, kinematic viscosity m²/s
GAS = (1.2, 1.48e-5)
PROJECT = Path("/usr/share/openfoam")  # Debian's package sets no environment, and the programs look for etc/ there by it
PROGRAMS = ("blockMesh", "interFoam")
LOG_LINES = 15  # of a failed run, shown in the exception
SPARE = 4  # samples of the motion table after the end of the run, since the last step may pass it by half of itself
CENTRE = "constant/centre.txt"  # our own file: where the tank's centre is, to move the moments there
FORCES = "postProcessing/forces"
COLUMNS = 64  # in each cell, for the area of liquid under the initial interface


class InterFoamError(RuntimeError):
    """interFoam or blockMesh is not installed, stopped with an error, or left forces that cannot be read."""


@dataclass(frozen=True, eq=False)
class Motion:
    """Prescribed motion of the tank, rigid, as a table: arrays of one shape (n,), n >= 4, times rising from t[0] <= 0.

    t: s; surge (+x) and heave (+y) of the tank's centre: m; theta about it: rad, counter-clockwise. All three are zero at t = 0.
    """

    t: Array
    surge: Array
    heave: Array
    theta: Array

    def __post_init__(self) -> None:
        """Raises ValueError for a table that is not as described in the class."""
        columns = (self.t, self.surge, self.heave, self.theta)
        if self.t.ndim != 1 or self.t.size < 4 or any(column.shape != self.t.shape for column in columns):
            raise ValueError("motion table: four arrays of one shape (n,), n >= 4, are needed")
        if not all(np.isfinite(column).all() for column in columns):
            raise ValueError("motion table: not all values are finite")
        if not (np.diff(self.t) > 0.0).all() or self.t[0] > 0.0 or self.t[-1] <= 0.0:
            raise ValueError("motion table: the times must rise, from zero or earlier to after zero")
        if np.abs(self.at(np.zeros(1))).max() > 1e-9:  # the mesh would jump there within the first step
            raise ValueError("motion table: surge, heave and theta must be zero at t = 0")

    def at(self, t: Array) -> Array:
        """Surge, heave (m) and theta (rad), shape (n, 3), at the times t (n,) in s, at most a step or two outside the table.

        Cubic spline, so that a coarse table gives no jumps of acceleration, which are jumps of pressure.
        """
        table = np.column_stack((self.surge, self.heave, self.theta))
        return np.asarray(CubicSpline(self.t, table)(t), dtype=np.float64)


@dataclass(frozen=True)
class Case:
    """A tank length x height (m), filled to `depth` (m), on a uniform mesh of cells_x x cells_y, run for `duration` (s).

    The interface starts at depth + amplitude cos(pi (x + length / 2) / length) above the floor (amplitude in m, crest at the west
    wall), all at rest. Steps are at most max_step (s), shorter where the Courant number would pass max_courant. motion: None for
    a tank that stands still.
    """

    length: float
    height: float
    depth: float
    cells_x: int
    cells_y: int
    duration: float
    amplitude: float = 0.0
    motion: Motion | None = None
    max_step: float = 2e-3
    max_courant: float = 0.5

    def __post_init__(self) -> None:
        """Raises ValueError for sizes that are no tank, a run of less than a step, or a motion table that ends before the run."""
        if min(self.length, self.height, self.duration, self.max_step, self.max_courant) <= 0.0:
            raise ValueError("length, height, duration, max_step and max_courant must be positive")
        if self.duration < self.max_step:
            raise ValueError(f"the duration, {self.duration} s, is less than a step, {self.max_step} s")
        if min(self.cells_x, self.cells_y) < 2:
            raise ValueError("two cells at least are needed each way")
        if not abs(self.amplitude) < min(self.depth, self.height - self.depth):
            raise ValueError(f"the interface, {self.depth} ± {self.amplitude} m, must lie within the height {self.height} m")
        if self.motion is not None and self.motion.t[-1] < self.duration * (1.0 - 1e-9):
            raise ValueError(f"the motion table ends at {self.motion.t[-1]} s, the run at {self.duration} s")

    @property
    def cells(self) -> int:
        """Number of cells of the mesh."""
        return self.cells_x * self.cells_y


@dataclass(frozen=True, eq=False)
class Result:
    """What a run gave. Arrays (steps,), one entry a time step, at its end; the start is not among them.

    time: s; steps differ in length, and the last ends within half a step of the duration. fx, fy (N/m) and mz (N m/m): by the
    fluid on the walls, weight included, in inertial axes, mz about the tank's centre where it then is, counter-clockwise.
    viscous: the part of fx, fy, mz by shear, shape (steps, 3). cpu_seconds: user and system time of the interFoam process alone,
    its start included.
    """

    cpu_seconds: float
    steps: int
    time: Array
    fx: Array
    fy: Array
    mz: Array
    viscous: Array


def smooth_start(t: Array, rise: float) -> Array:
    """0 to 1 within `rise` s, first and second derivative zero at both ends: 10 s³ - 15 s⁴ + 6 s⁵, s = t / rise."""
    s = np.clip(t / rise, 0.0, 1.0)
    return s**3 * (10.0 - 15.0 * s + 6.0 * s**2)


def pitch_motion(duration: float, pitch: float, omega: float, rise: float, heave: float = 0.0, spacing: float = 1e-3) -> Motion:
    """Pitch (rad) and heave (m) in phase, each its amplitude x smooth_start(t, rise) x sin(omega t), with omega in rad/s.

    The table has a sample about every `spacing` s from 0 to `duration`.
    """
    t = np.linspace(0.0, duration, max(4, round(duration / spacing) + 1), dtype=np.float64)
    shape = smooth_start(t, rise) * np.sin(omega * t)
    return Motion(t, np.zeros_like(t), heave * shape, pitch * shape)


def _half_full(cells: tuple[int, int], duration: float, amplitude: float, motion: Motion | None) -> Case:
    return Case(0.5, 0.15, 0.075, cells[0], cells[1], duration, amplitude, motion)


def case_a(cells: tuple[int, int], duration: float = 6.0) -> Case:
    """Free sloshing of the tank 0.5 m x 0.15 m, half full: first mode of 2 mm; cells: (x, y)."""
    return _half_full(cells, duration, 2e-3, None)


def case_b(cells: tuple[int, int], duration: float = 10.0) -> Case:
    """The same tank pitched by 1 degree at 3.14 rad/s, smooth start in 1 s; cells: (x, y)."""
    return _half_full(cells, duration, 0.0, pitch_motion(duration, np.radians(1.0), 3.14, 1.0))


def case_c06(cells: tuple[int, int], duration: float = 4.0) -> Case:
    """The same tank pitched by 4 degrees and heaved by 7.5 mm at 6.28 rad/s, smooth start in 0.5 s; cells: (x, y).

    The liquid hits the roof after about 2 s: from there on two meshes differ by some 9 %, and no closer agreement means anything.
    """
    return _half_full(cells, duration, 0.0, pitch_motion(duration, np.radians(4.0), 6.28, 0.5, heave=7.5e-3))


def available() -> bool:
    """Whether the programs of OpenFOAM that `run` needs are in the PATH."""
    return all(shutil.which(program) for program in PROGRAMS)


def liquid_fraction(case: Case) -> Array:
    """Share of each cell filled with liquid at the start, shape (cells_y, cells_x), rows from the floor up."""
    dx, dy = case.length / case.cells_x, case.height / case.cells_y
    x = (np.arange(case.cells_x * COLUMNS) + 0.5) * dx / COLUMNS  # from the west wall
    level = case.depth + case.amplitude * np.cos(np.pi * x / case.length)
    floor = np.arange(case.cells_y)[:, None] * dy
    filled = np.clip((level - floor) / dy, 0.0, 1.0)
    return np.asarray(filled.reshape(case.cells_y, case.cells_x, COLUMNS).mean(axis=2))


Entry = str | float | Mapping[str, "Entry"]


def _entries(entries: Mapping[str, Entry], indent: str = "") -> str:
    lines = []
    for key, value in entries.items():
        if isinstance(value, Mapping):
            lines.append(f"{indent}{key}\n{indent}{{\n{_entries(value, indent + '    ')}{indent}}}\n")
        else:
            lines.append(f"{indent}{key} {value};\n")
    return "".join(lines)


def _save(folder: Path, name: str, entries: Mapping[str, Entry], kind: str = "dictionary") -> None:
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    header: dict[str, Entry] = {"FoamFile": {"version": "2.0", "format": "ascii", "class": kind, "object": path.name}}
    path.write_text(_entries(header | dict(entries)), encoding="ascii")


def _vector(x: float, y: float, z: float = 0.0) -> str:
    return f"({x!r} {y!r} {z!r})"


def _mesh(case: Case) -> dict[str, Entry]:
    x, y = case.length / 2.0, case.height / 2.0
    corners = [(-x, -y), (x, -y), (x, y), (-x, y)]
    vertices = " ".join(_vector(*corner, z) for z in (-0.5, 0.5) for corner in corners)
    patches = {"west": "(0 4 7 3)", "east": "(1 2 6 5)", "floor": "(0 1 5 4)", "roof": "(3 7 6 2)"}
    walls = "".join(f"{name} {{ type wall; faces ({face}); }}\n" for name, face in patches.items())
    return {
        "vertices": f"({vertices})",
        "blocks": f"(hex (0 1 2 3 4 5 6 7) ({case.cells_x} {case.cells_y} 1) simpleGrading (1 1 1))",
        "boundary": f"({walls}page {{ type empty; faces ((0 3 2 1) (4 5 6 7)); }})",
    }


def _control(case: Case) -> dict[str, Entry]:
    return {
        "application": "interFoam",
        "startFrom": "startTime",
        "startTime": 0,
        "stopAt": "endTime",
        "endTime": case.duration,
        "deltaT": case.max_step,
        "writeControl": "timeStep",
        "writeInterval": 1_000_000_000,  # no fields: the forces are all that is asked, and the disk is no part of the cost
        "writeFormat": "ascii",
        "writePrecision": 12,
        "timePrecision": 10,
        "runTimeModifiable": "no",
        "adjustTimeStep": "yes",
        "maxCo": case.max_courant,
        "maxAlphaCo": case.max_courant,
        "maxDeltaT": case.max_step,
        "functions": {
            "forces": {
                "type": "forces",
                "libs": "(forces)",
                "writeControl": "timeStep",
                "writeInterval": 1,
                "log": "no",
                "patches": "(west east floor roof)",
                "rho": "rho",
                "CofR": "(0 0 0)",
            }
        },
    }


def _schemes() -> dict[str, Entry]:
    return {
        "ddtSchemes": {"default": "Euler"},
        "gradSchemes": {"default": "Gauss linear"},
        "divSchemes": {
            "div(rhoPhi,U)": "Gauss linearUpwind grad(U)",
            "div(phi,alpha)": "Gauss vanLeer",
            "div(phirb,alpha)": "Gauss linear",
            "div(((rho*nuEff)*dev2(T(grad(U)))))": "Gauss linear",
        },
        "laplacianSchemes": {"default": "Gauss linear orthogonal"},
        "interpolationSchemes": {"default": "linear"},
        "snGradSchemes": {"default": "orthogonal"},
    }


def _solution(case: Case) -> dict[str, Entry]:
    # GAMG costs the same as PCG with DIC on 100 x 30 cells, and a third less on 200 x 60 that move. A hundred times closer
    # tolerances move Fx and Mz by at most 0.03 % of their standard deviation.
    pressure: dict[str, Entry] = {"solver": "GAMG", "smoother": "DIC", "mergeLevels": 2, "tolerance": 1e-7, "relTol": 0.05}
    return {
        "solvers": {
            '"alpha.water.*"': {
                "nAlphaCorr": 1,
                "nAlphaSubCycles": 1,
                "cAlpha": 1,
                "MULESCorr": "yes",
                "nLimiterIter": 3,
                "solver": "smoothSolver",
                "smoother": "symGaussSeidel",
                "tolerance": 1e-8,
                "relTol": 0,
            },
            '"pcorr.*"': pressure | {"relTol": 0},
            "p_rgh": pressure,
            "p_rghFinal": pressure | {"relTol": 0},
        },
        "PIMPLE": {
            "momentumPredictor": "no",
            "nOuterCorrectors": 1,
            "nCorrectors": 3,
            "nNonOrthogonalCorrectors": 0,
            "correctPhi": "no",  # the mesh moves as one body, so the fluxes relative to it stay free of divergence
            "pRefCell": case.cells - (case.cells_x + 1) // 2,  # the middle of the top row: gas, unless the liquid hits the roof
            "pRefValue": 0,
        },
    }


def _sampled(case: Case, motion: Motion) -> Array:
    """The motion as OpenFOAM gets it, shape (n, 4): t, surge, heave, theta; every half of the largest step.

    So fine because OpenFOAM's own interpolation is only once differentiable. It goes past the end, since a time outside the table
    is an error there.
    """
    spacing = 0.5 * case.max_step
    t = spacing * np.arange(round(case.duration / spacing) + 1 + SPARE, dtype=np.float64)
    return np.column_stack((t, motion.at(t)))


def _motion_table(samples: Array) -> str:
    rows = "".join(
        f"({t!r} (({surge!r} {heave!r} 0) (0 0 {degrees!r})))\n"
        for t, surge, heave, degrees in (samples * (1.0, 1.0, 1.0, 180.0 / np.pi)).tolist()
    )
    return f"{len(samples)}\n(\n{rows})\n"


def write(case: Case, folder: Path) -> None:
    """Writes the complete OpenFOAM case into `folder`, made where it is missing; files of the same names there are replaced."""
    _save(folder, "system/blockMeshDict", _mesh(case))
    _save(folder, "system/controlDict", _control(case))
    _save(folder, "system/fvSchemes", _schemes())
    _save(folder, "system/fvSolution", _solution(case))

    gravity: dict[str, Entry] = {"dimensions": "[0 1 -2 0 0 0 0]", "value": _vector(0.0, -GRAVITY)}
    _save(folder, "constant/g", gravity, "uniformDimensionedVectorField")
    phases: dict[str, Entry] = {"phases": "(water air)", "sigma": 0}
    for name, (density, viscosity) in (("water", LIQUID), ("air", GAS)):
        phases[name] = {"transportModel": "Newtonian", "nu": viscosity, "rho": density}
    _save(folder, "constant/transportProperties", phases)
    _save(folder, "constant/turbulenceProperties", {"simulationType": "laminar"})

    samples = np.zeros((2, 4))  # a tank that stands still
    if case.motion is None:
        mesh: dict[str, Entry] = {"dynamicFvMesh": "staticFvMesh"}
    else:
        samples = _sampled(case, case.motion)
        (folder / "constant/6DoF.dat").write_text(_motion_table(samples), encoding="ascii")
        mesh = {
            "dynamicFvMesh": "dynamicMotionSolverFvMesh",
            "motionSolver": "solidBody",
            "solidBodyMotionFunction": "tabulated6DoFMotion",
            "CofG": "(0 0 0)",
            "timeDataFileName": '"<constant>/6DoF.dat"',
        }
    _save(folder, "constant/dynamicMeshDict", mesh)
    np.savetxt(folder / CENTRE, samples[:, :3], header="t surge heave", fmt="%.17g")

    fraction = "\n".join(map(repr, liquid_fraction(case).ravel().tolist()))
    fields: dict[str, tuple[str, str, str, dict[str, Entry]]] = {
        "alpha.water": (
            "volScalarField",
            "[0 0 0 0 0 0 0]",
            f"nonuniform List<scalar>\n{case.cells}\n(\n{fraction}\n)",
            {"type": "zeroGradient"},
        ),
        "U": (
            "volVectorField",
            "[0 1 -1 0 0 0 0]",
            "uniform (0 0 0)",
            {"type": "noSlip"} if case.motion is None else {"type": "movingWallVelocity", "value": "uniform (0 0 0)"},
        ),
        "p_rgh": ("volScalarField", "[1 -1 -2 0 0 0 0]", "uniform 0", {"type": "fixedFluxPressure", "value": "uniform 0"}),
    }
    for name, (kind, dimensions, start, walls) in fields.items():
        boundary: dict[str, Entry] = {"page": {"type": "empty"}, '"(west|east|floor|roof)"': walls}
        _save(folder, f"0/{name}", {"dimensions": dimensions, "internalField": start, "boundaryField": boundary}, kind)


def _process(program: str, folder: Path) -> tuple[float, str]:
    """CPU seconds and log of one program run on the case in `folder`; raises InterFoamError where it is missing or fails."""
    found = shutil.which(program)
    if found is None:
        raise InterFoamError(f"{program} is not in the PATH: install OpenFOAM (Debian: apt-get install openfoam)")
    environment = os.environ | {"PWD": str(folder.resolve())}
    if PROJECT.is_dir():
        environment.setdefault("WM_PROJECT_DIR", str(PROJECT))
    path = folder / f"log.{program}"
    with path.open("wb") as log:
        process = subprocess.Popen(
            [found], cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT
        )
        try:
            # the usage of this very child: RUSAGE_CHILDREN would count any other child that ends meanwhile
            _, status, usage = os.wait4(process.pid, 0)
        except BaseException:
            process.kill()
            process.wait()
            raise
        process.returncode = os.waitstatus_to_exitcode(status)
    text = path.read_text(encoding="utf-8", errors="replace")
    if process.returncode != 0:
        last = "\n".join(text.splitlines()[-LOG_LINES:])
        raise InterFoamError(f"{program} in {folder} ended with {process.returncode}; the log's last lines:\n{last}")
    return usage.ru_utime + usage.ru_stime, text


def _columns(folder: Path, name: str) -> Array:
    """Table of the forces function object, shape (steps, 10): time, then three vectors: total, by pressure, by shear."""
    path = folder / FORCES / "0" / name
    try:
        text = path.read_text(encoding="ascii").replace("(", " ").replace(")", " ")
        table = np.array([line.split() for line in text.splitlines() if not line.startswith("#")], dtype=np.float64)
    except (OSError, ValueError) as error:
        raise InterFoamError(f"no forces to read in {path}: {error}") from error
    if table.ndim != 2 or table.shape[1] != 10:
        raise InterFoamError(f"{path}: shape {table.shape}, not (steps, 10)")
    return table


def run(folder: Path) -> Result:
    """Meshes and runs the case that `write` made in `folder`, on one core; an earlier run's forces there are deleted.

    Raises InterFoamError where OpenFOAM is missing or fails, or `folder` holds no case; the logs are left there as log.blockMesh
    and log.interFoam.
    """
    if not (folder / CENTRE).is_file():
        raise InterFoamError(f"{folder} holds no case: write one there first")
    shutil.rmtree(folder / FORCES, ignore_errors=True)
    _process("blockMesh", folder)
    cpu_seconds, log = _process("interFoam", folder)
    force, moment = _columns(folder, "force.dat"), _columns(folder, "moment.dat")
    steps = len(re.findall(r"^Time = ", log, re.MULTILINE))
    if not force.shape == moment.shape == (steps, 10):
        raise InterFoamError(f"{folder}: {steps} steps, but {len(force)} rows of force and {len(moment)} of moment")

    time = force[:, 0]
    t, surge, heave = np.loadtxt(folder / CENTRE).T
    x, y = np.interp(time, t, surge), np.interp(time, t, heave)
    total, viscous = (
        np.column_stack((force[:, at], force[:, at + 1], moment[:, at + 2] - x * force[:, at + 1] + y * force[:, at]))
        for at in (1, 7)
    )
    return Result(cpu_seconds, steps, time, total[:, 0], total[:, 1], total[:, 2], viscous)


def to_section(position: Array) -> Array:
    """Motion of the tank's centre (…, 3: surge, heave, theta) as (h, alpha, x) of a section whose axis is the tank's centre.

    The frame here has y up and theta counter-clockwise; a section's plunge h is positive down and alpha nose-up, which with x aft
    is clockwise. The same holds for rates and accelerations.
    """
    surge, heave, theta = np.moveaxis(np.asarray(position, dtype=float), -1, 0)
    return np.stack([-heave, -theta, surge], axis=-1)


def from_section(loads: Array) -> Array:
    """Loads (…, 3: force_x, force_y, moment nose-up) of a section as (fx, fy, mz counter-clockwise) of this module."""
    return np.asarray(loads, dtype=float) * np.array([1.0, 1.0, -1.0])
