"""What coupling schemes do to a section with liquid: artificial damping, stability limits, observed orders.

`python -m studies.coupling_study [--fmus DIR] [--csv FILE] [--picture FILE [--draw-again]]` marches structure and slosh_ems FMU
through the master, without air, and compares with the continuous system. Two motions: plunge with a full tank, whose liquid is a
rigid mass (nothing may damp it), and pitch with a half-full tank above its waves' frequencies. mu is the frozen liquid's mass
(inertia) over the section's.

Theory: a load that arrives as f times the true one leaves D_structure(s) + f(s dt) D_liquid(s) = 0 for motions e^{st}: f = 1 is
exact, e^{-s dt} a step late, 2 e^{-s dt} − e^{-2 s dt} extrapolated linearly. To first order a whole load of effective ratio eps
that is d steps late damps by eps/(1 + eps)/2 omega d dt. The structure FMU takes loads as linear within a step: a factor
2 (cosh(s dt) − 1)/(s dt)².
"""

from __future__ import annotations

import argparse
import csv
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import newton

from aeroslosh.fmus.tank.frozen import constants
from aeroslosh.fmus.tank.liquid import Tank
from aeroslosh.fmus.tank.modes import modes
from aeroslosh.master.analysis.exponentials import Poles, refine
from aeroslosh.master.base.errors import ComponentError
from aeroslosh.master.case import fuel_tank
from aeroslosh.master.cosim.acceleration import QuasiNewton
from aeroslosh.master.cosim.implicit import Criteria, Implicit
from aeroslosh.master.cosim.scheme import GaussSeidel, Jacobi, Scheme
from aeroslosh.master.cosim.system import System, wires
from aeroslosh.master.fmi.component import Component

ROOT = Path(__file__).resolve().parents[1]
OMEGA = 50.0  # about that of the motion [rad/s]
DAMPING, MODES = 0.005, 3
RATIOS = (0.1, 0.3, 1.0, 3.0, 10.0)
HIGHEST = 50.0  # mass ratio tried in the search of a stability limit
STEPS = (25, 50, 100, 200, 400)  # a period
FLOOR = 1e-9  # below this a damping ratio is rounding
BLOWN = 1e3  # times its first amplitude: unstable; negative damping alone grows to 50 at most here
Late = Callable[[complex], complex]  # s dt → the part of the true load that arrives


@dataclass(frozen=True)
class Way:
    """A coupling scheme with the split it is used with, and its theory."""

    name: str
    make: Callable[[], Scheme]
    split: str
    late: Late


def once(z: complex) -> complex:
    """A step late."""
    return np.exp(-z)


def ahead(z: complex) -> complex:
    """Extrapolated linearly."""
    return 2.0 * np.exp(-z) - np.exp(-2.0 * z)


WAYS = (
    Way("Jacobi", lambda: Jacobi(0), "none", lambda z: np.exp(-2.0 * z)),
    Way("Gauss–Seidel, lagged", lambda: GaussSeidel(0), "none", once),
    Way("Gauss–Seidel, extrapolated", lambda: GaussSeidel(1), "none", ahead),
    Way("frozen split, lagged", lambda: GaussSeidel(0), "frozen", once),
    Way("frozen split, extrapolated", lambda: GaussSeidel(1), "frozen", ahead),
    Way("implicit", lambda: Implicit(1, Criteria(1e-9, max_iterations=60), QuasiNewton()), "none", lambda z: 1.0),
    Way("implicit, frozen split", lambda: Implicit(1, Criteria(1e-9, max_iterations=60), QuasiNewton()), "frozen", lambda z: 1.0),
)


@dataclass(frozen=True)
class Setup:
    """A section of unit mass and inertia with a tank of `ratio` times that, in "plunge" or "pitch"."""

    motion: str
    ratio: float
    tank: Tank = field(init=False)

    def __post_init__(self) -> None:
        fill = 1.0 if self.motion == "plunge" else 0.5
        one = Tank(0.5, 0.15, fill_level=fill, density=1.0)
        per_density = one.mass if self.motion == "plunge" else one.inertia
        object.__setattr__(self, "tank", Tank(0.5, 0.15, fill_level=fill, density=self.ratio / per_density))

    @property
    def spring(self) -> float:
        """That of the section: with the frozen liquid the frequency is OMEGA."""
        return (1.0 + self.ratio) * OMEGA**2

    def structure(self) -> dict[str, float]:
        """Parameters of the structure FMU; the other motion is kept far away."""
        w = math.sqrt(self.spring)
        if self.motion == "plunge":
            return {"mass": 1.0, "inertia": 1e3, "static_imbalance": 0.0, "omega_h": w, "omega_alpha": 1.0, "initial_h": 0.01}
        return {"mass": 1e3, "inertia": 1.0, "static_imbalance": 0.0, "omega_h": 1.0, "omega_alpha": w, "initial_alpha": 0.01}

    def liquid(self) -> dict[str, float | int]:
        """Parameters of the slosh FMU."""
        t = self.tank
        own: dict[str, float | int] = {"damping_ratio": DAMPING, "modes": MODES}
        return own | {"fill_level": t.fill_level, "liquid_density": t.density}

    def frozen(self, s: complex) -> complex:
        """Dynamic stiffness of the frozen liquid."""
        return self.tank.mass * s**2 if self.motion == "plunge" else self.tank.inertia * s**2 + self.tank.stiffness

    def sloshing(self, s: complex) -> complex:
        """Dynamic stiffness of the liquid that sloshes: fixed part and modal masses."""
        if self.motion == "plunge":
            return self.frozen(s)
        t, m = self.tank, modes(self.tank, MODES)
        y = t.centre_y + m.height
        inertia = m.fixed_inertia + m.fixed_mass * (t.centre_y + m.fixed_height) ** 2 + float(m.mass @ y**2)
        drive = m.mass * (y * s**2 - t.gravity)
        waves = np.sum(drive**2 / (m.mass * (s**2 + 2.0 * DAMPING * m.omega * s + m.omega**2)))
        return complex(inertia * s**2 - (t.mass * t.centre_y + m.rest_tilt) * t.gravity - waves)

    def pole(self, split: str = "none", late: Late = lambda z: 1.0, dt: float = 0.0) -> complex:
        """The motion's eigenvalue [rad/s]; with late = 1 and dt = 0 that of the continuous system."""

        def remainder(s: complex) -> complex:
            z = s * dt
            linear = 2.0 * (np.cosh(z) - 1.0) / z**2 if dt else 1.0
            carried = self.frozen(s) if split == "frozen" else 0.0
            return complex(s**2 + self.spring + carried + late(z) * linear * (self.sloshing(s) - carried))

        return complex(newton(remainder, 1.05j * OMEGA, tol=1e-11, maxiter=200))


@dataclass(frozen=True)
class Row:
    """One march: artificial damping ratio and relative error of the frequency, measured and by theory; nan: unstable."""

    scheme: str
    motion: str
    mass_ratio: float
    steps: int
    damping: float
    damping_theory: float
    frequency_error: float
    passes: float


def march(fmus: Path, setup: Setup, way: Way, dt: float, steps: int) -> tuple[np.ndarray, float]:
    """Free motion of the coordinate over its start, (steps + 1,) or shorter where it blows up; passes a step."""
    structure, liquid = Component(fmus / "structure.fmu", "structure"), Component(fmus / "slosh_ems.fmu", "slosh")
    system, scheme = System([structure, liquid], wires(fuel_tank.wiring(way.split))), way.make()
    values, passes = [1.0], 0
    try:
        liquid.set_all(setup.liquid())
        structure.set_all(setup.structure())
        if way.split == "frozen":
            structure.set_all({name: value for name, value in constants(setup.tank).items() if name in fuel_tank.CARRIED})
        else:  # the weight is the trim's
            structure.set_all({"trim_lift": -setup.tank.mass * setup.tank.gravity})
        system.initialize()
        scheme.reset(system)
        column = structure.output_index["h" if setup.motion == "plunge" else "alpha"]
        for _ in range(steps):
            passes += scheme.step(system, dt).passes
            values.append(structure.outputs.values[column] / 0.01)
            if not abs(values[-1]) < BLOWN:
                break
    except ComponentError:  # numbers beyond all bounds
        values.append(math.inf)
    finally:
        system.close()
    return np.array(values), passes / max(1, len(values) - 1)


def measure(fmus: Path, setup: Setup, way: Way, steps: int) -> Row:
    """March 30 periods and fit the motion's pole; the waves are fitted beside it."""
    exact = setup.pole()
    dt = 2.0 * math.pi / exact.imag / steps
    periods = 12 if setup.motion == "plunge" else 30
    with np.errstate(all="ignore"):
        values, passes = march(fmus, setup, way, dt, periods * steps)
    if not abs(values[-1]) < BLOWN:
        return Row(way.name, setup.motion, setup.ratio, steps, math.nan, math.nan, math.nan, passes)
    expected = setup.pole(way.split, way.late, dt)
    first, sample = 2 * steps, max(1, steps // 25)
    guess = [[expected.real / exact.imag, expected.imag / exact.imag]]
    if setup.motion == "pitch":
        waves = modes(setup.tank, MODES).omega / exact.imag
        guess += [[-DAMPING * w, w] for w in waves]
    tau = exact.imag * dt * np.arange(first, values.size, sample)
    fit = refine(tau, values[None, first::sample], Poles(np.array(guess), np.zeros(0), constant=True))
    assert fit is not None, (way.name, setup, steps)
    poles = fit.poles.oscillations
    sigma, omega = poles[np.argmin(np.abs(poles[:, 1] - 1.0))]
    at_rest = exact.real / exact.imag
    damping, theory = at_rest - sigma / omega, at_rest - expected.real / expected.imag
    return Row(way.name, setup.motion, setup.ratio, steps, damping, theory, omega - 1.0, passes)


def limit(fmus: Path, motion: str, way: Way, steps: int, low: float = 0.05, high: float = HIGHEST) -> float:
    """Largest mass ratio that is stable for 20 periods, to 2 %; inf above `high`."""

    def stable(ratio: float) -> bool:
        setup = Setup(motion, ratio)
        with np.errstate(all="ignore"):
            values, _ = march(fmus, setup, way, 2.0 * math.pi / setup.pole().imag / steps, 20 * steps)
        return abs(values[-1]) < BLOWN

    if stable(high):
        return math.inf
    while high / low > 1.02:
        middle = math.sqrt(low * high)
        low, high = (middle, high) if stable(middle) else (low, middle)
    return low


def order(rows: list[Row], name: str) -> float:
    """Slope of log |error| over log dt among the two finest steps above rounding; nan without."""
    found = sorted(((r.steps, abs(getattr(r, name))) for r in rows if abs(getattr(r, name)) > FLOOR), reverse=True)[:2]
    return math.log(found[1][1] / found[0][1]) / math.log(found[0][0] / found[1][0]) if len(found) == 2 else math.nan


def main() -> None:
    """March all, write the data, print the tables, draw."""
    command = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    command.add_argument("--fmus", type=Path, default=ROOT / "dist" / "fmus")
    command.add_argument("--csv", type=Path, default=ROOT / "docs" / "data" / "coupling.csv")
    command.add_argument("--picture", type=Path)
    command.add_argument("--draw-again", action="store_true", help="only the picture, from the data that --csv holds")
    options = command.parse_args()
    if options.draw_again:
        draw(read(options.csv), options.picture)
        return
    rows = []
    for motion in ("plunge", "pitch"):
        for way in WAYS:
            for ratio in RATIOS:
                # iterations are costly and their error is small: coarse steps tell it
                for steps in STEPS[:3] if way.name.startswith("implicit") else STEPS:
                    rows.append(measure(options.fmus, Setup(motion, ratio), way, steps))
                    print(rows[-1], flush=True)
    with options.csv.open("w", newline="", encoding="utf-8") as stream:
        table = csv.writer(stream, lineterminator="\n")
        table.writerow(Row.__dataclass_fields__)
        table.writerows([f"{v:.6g}" if isinstance(v, float) else v for v in vars(r).values()] for r in rows)
    report(rows, options.fmus)
    if options.picture:
        draw(rows, options.picture)


def read(path: Path) -> list[Row]:
    """The rows that an earlier study wrote."""
    with path.open(newline="", encoding="utf-8") as stream:
        return [
            Row(**{name: TYPES[str(kind.type)](told[name]) for name, kind in Row.__dataclass_fields__.items()})
            for told in csv.DictReader(stream)
        ]


TYPES: dict[str, Callable[[str], Any]] = {"str": str, "int": int, "float": float}


def report(rows: list[Row], fmus: Path) -> None:
    """The tables of docs/coupling.md."""
    for motion in ("plunge", "pitch"):
        print(f"\n{motion}: artificial damping ratio at 100 steps a period; orders at mu 0.1; stable up to mu (25 / 100 steps)\n")
        ratios = " | ".join(f"μ = {r:g}" for r in RATIOS)
        print(f"| scheme | {ratios} | order of damping / frequency | stable up to μ | passes |")
        print("|---|" + "---|" * (len(RATIOS) + 3))
        for way in WAYS:
            mine = [r for r in rows if r.scheme == way.name and r.motion == motion]
            at = {r.mass_ratio: r for r in mine if r.steps == 100}
            values = [_word(at[r].damping) for r in RATIOS]
            fine = [r for r in mine if r.mass_ratio == RATIOS[0]]
            orders = " / ".join(f"{order(fine, name):.1f}" for name in ("damping", "frequency_error")).replace("nan", "exact")
            if way.name.startswith("implicit"):
                edges = f"> {RATIOS[-1]:g}"
            else:
                found = [limit(fmus, motion, way, n) for n in (25, 100)]
                edges = " / ".join(f"> {HIGHEST:g}" if math.isinf(e) else f"{e:.2g}" for e in found)
            passes = max(r.passes for r in at.values())
            print(f"| {way.name} | {' | '.join(values)} | {orders} | {edges} | {passes:.1f} |", flush=True)


def _word(damping: float) -> str:
    """A damping ratio for the table."""
    if math.isnan(damping):
        return "unstable"
    return f"{damping:+.1e}" if abs(damping) > FLOOR else "0"


def draw(rows: list[Row], path: Path) -> None:
    """Damping over step at one mass ratio, and over mass ratio at 100 steps, for both motions."""
    from aeroslosh.master.pictures import canvas, look

    colours = (look.BLUE, look.ORANGE, look.PURPLE, look.SKY, look.GREY, look.INK, look.ORANGE)
    with canvas.rc_context(look.STYLE):
        figure, axes = canvas.subplots(2, 2, figsize=(10, 8), layout="constrained", sharey=True)
        for pair, motion in zip(axes, ("plunge", "pitch"), strict=True):
            for way, colour, mark in zip(WAYS, colours, "os^Dv+x", strict=True):
                mine = [r for r in rows if r.scheme == way.name and r.motion == motion and not math.isnan(r.damping)]
                for axis, chosen, x in (
                    (pair[0], [r for r in mine if r.mass_ratio == 0.3], [r.steps for r in mine if r.mass_ratio == 0.3]),
                    (pair[1], [r for r in mine if r.steps == 100], [r.mass_ratio for r in mine if r.steps == 100]),
                ):
                    marched, theory = ([max(abs(v), FLOOR) for v in values] for values in
                                       ([r.damping for r in chosen], [r.damping_theory for r in chosen]))  # fmt: skip
                    axis.loglog(x, marched, mark, color=colour, mfc="none", ms=5, ls="", label=way.name)
                    axis.loglog(x, theory, "-", color=colour, lw=0.9)
            pair[0].set(title=f"{motion}, mass ratio 0.3", xlabel="steps a period [–]", ylabel="|artificial damping ratio| [–]")
            pair[1].set(title=f"{motion}, 100 steps a period", xlabel="mass ratio of liquid and section [–]")
            pair[0].set_xticks(STEPS, [str(n) for n in STEPS])
            pair[0].minorticks_off()
            for axis in pair:
                axis.axhline(5e-4, color=look.GREY, lw=0.8, ls="--")
                axis.set_ylim(0.4 * FLOOR, 1.0)
        canvas.legend(figure, *axes.flat, columns=4)
        figure.suptitle(
            "Artificial damping: marched (marks), theory (lines); missing: unstable; at the bottom: none", fontsize=11
        )
        figure.savefig(path)
    print(f"picture: {path}")


if __name__ == "__main__":
    main()
