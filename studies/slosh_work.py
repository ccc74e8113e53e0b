"""Work a cycle that a tank takes out of a violent pitch motion, on several meshes.

`python -m studies.slosh_work [--cells 50x16 100x30 …] [--cycles N] [--members N] [--gas-pressure PA]`: the preset's tank (0.5 x
0.15 m, half full, 1.8 m behind the axis), water under air, pitch of one degree at 41 rad/s, about seven g at the tank; cycles
from the sixth on. The flow is chaotic: single cycles scatter, and so do runs; members start from a spectrum of waves of 0.01 mm,
their seeds 1 to N.
"""

from __future__ import annotations

import argparse
import math

import numpy as np
from numpy.typing import NDArray

from aeroslosh.fmus.slosh_vof.flow import Flow, Fluids
from aeroslosh.fmus.slosh_vof.grid import Grid
from aeroslosh.fmus.slosh_vof.shape import Shape, fractions
from aeroslosh.fmus.tank.liquid import Tank
from aeroslosh.fmus.tank.motion import SectionMotion

TANK = Tank(0.5, 0.15, x=1.8)
OMEGA, AMPLITUDE = 41.0, math.radians(1.0)
STEPS = 100  # communication steps a cycle; ten times more move a cycle by 1.5 J/m, their mean by 0.4
SKIPPED = 5  # cycles before the motion and the flow have settled
RISE = 2 * 2 * math.pi / OMEGA  # [s]
PERTURBATION = 1e-5  # [m]
MESHES = ("50x16", "100x30", "200x60")


def pitch(t: float) -> SectionMotion:
    """amplitude · (10 s³ − 15 s⁴ + 6 s⁵) · sin ωt, s = t/rise up to 1."""
    s = min(t / RISE, 1.0)
    r, r1 = 10 * s**3 - 15 * s**4 + 6 * s**5, 30 * s**2 * (1 - s) ** 2 / RISE
    r2 = 60 * s * (1 - s) * (1 - 2 * s) / RISE**2
    sin, cos = math.sin(OMEGA * t), math.cos(OMEGA * t)
    rate, acceleration = r1 * sin + r * OMEGA * cos, r2 * sin + 2 * r1 * OMEGA * cos - r * OMEGA**2 * sin
    return SectionMotion(alpha=AMPLITUDE * r * sin, alpha_dot=AMPLITUDE * rate, alpha_ddot=AMPLITUDE * acceleration)


def work_a_cycle(nx: int, ny: int, cycles: int, seed: int, gas_pressure: float = 0.0) -> NDArray[np.float64]:
    """Work [J/m] taken out of the motion in each cycle from the sixth on, shape (cycles,): minus that of the liquid on the tank.

    gas_pressure [Pa]: of gas that can be compressed, 0 for one that cannot. Raises FlowError where the flow cannot be advanced.
    """
    flow, step = Flow(Grid(TANK, nx, ny), Fluids(gas_pressure=gas_pressure)), 2 * math.pi / OMEGA / STEPS
    now = pitch(0.0)
    flow.start_from(fractions(Shape(spectrum=PERTURBATION, seed=seed), flow.grid, 0.0), now)
    power, found = flow.loads(now).moment * now.alpha_dot, []
    for cycle in range(SKIPPED + cycles):
        work = 0.0
        for k in range(STEPS):
            end = pitch((cycle * STEPS + k + 1) * step)
            flow.advance(now, end, step)
            before, power, now = power, flow.loads(end).moment * end.alpha_dot, end
            work += 0.5 * step * (before + power)
        found.append(-work)
    return np.array(found[SKIPPED:])


def main() -> None:
    """Print a line a mesh."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--cells", nargs="+", default=MESHES, metavar="NXxNY")
    parser.add_argument("--cycles", type=int, default=30)
    parser.add_argument("--members", type=int, default=4)
    parser.add_argument("--gas-pressure", type=float, default=0.0, metavar="PA", help="gas that can be compressed")
    arguments = parser.parse_args()
    for cells in arguments.cells:
        nx, ny = (int(count) for count in cells.split("x"))
        seeds = range(1, arguments.members + 1)
        work = np.array([work_a_cycle(nx, ny, arguments.cycles, seed, arguments.gas_pressure) for seed in seeds])
        print(
            f"{cells}: {work.mean():.1f} J/m a cycle; members {np.round(work.mean(axis=1), 1)}, sd of single cycles "
            f"{work.std(axis=1, ddof=1).mean():.1f} ({arguments.cycles} each)",
            flush=True,
        )


if __name__ == "__main__":
    main()
