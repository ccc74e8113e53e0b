"""Ribs: their text, compartments as tanks of their own, nothing across closed faces, slots between the limits."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from aeroslosh.fmus.slosh_vof.flow import Flow, Fluids, Numerics
from aeroslosh.fmus.slosh_vof.grid import Baffles, Grid, GridError
from aeroslosh.fmus.slosh_vof.probes import Probe
from aeroslosh.fmus.slosh_vof.ribs import Rib, RibError, faces, parse, segments
from aeroslosh.fmus.slosh_vof.shape import Shape, ShapeError, fractions
from aeroslosh.fmus.slosh_vof.surface import flat
from aeroslosh.fmus.tank.liquid import Tank
from aeroslosh.fmus.tank.motion import SectionMotion
from support.momentum import momentum_gap
from support.motions import REST, Course, harmonic, march

TANK = Tank(0.5, 0.15)
SLOTS = "x=0 open=0:0.03,0.12:0.15"
VIOLENT = harmonic(25.0, 0.05, pitch=math.radians(4.0), plunge=0.0075)


def divided(text: str, nx: int = 64, ny: int = 24, tank: Tank = TANK) -> Grid:
    return Grid(tank, nx, ny, ribs=parse(text))


def test_the_text() -> None:
    assert parse("") == parse("  ; ") == ()
    assert parse("x=0.10 open=0.00:0.02,0.13:0.15;\n x=-0.1") == (Rib(0.1, ((0.0, 0.02), (0.13, 0.15))), Rib(-0.1))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("0.1", ["'0.1'", 'Remedy: ribs = "x=0.10']),
        ("open=0:0.1", ["'open=0:0.1' has no x"]),
        ("x=0.1 x=0.2", ["'x=0.2'"]),
        ("x=aft", ["'aft' in 'x=aft' is no number"]),
        ("x=inf", ["'inf'"]),
        ("x=0.1 open=0.02", ["open=0.02", "is no from:to"]),
        ("x=0.1 open=0:0.1,", ["is no from:to"]),
        ("x=0.25", ["x=0.25 m lies outside the tank", "between -0.25 and 0.25 m"]),
        ("x=-0.3", ["x=-0.3 m lies outside the tank"]),
        ("x=0.24", ["stands 1 cells from a wall", "4 cells = 0.04 m"]),
        ("x=0.1; x=0.103", ["x=0.1 and x=0.103 m stand on one cell face"]),
        ("x=0.1; x=0.13", ["stand 3 cells apart", "more cells_x"]),
        ("x=0.1 open=0.1:0.16", ["open=0.1:0.16 of x=0.1 m leaves the tank", "from 0 to 0.15 m"]),
        ("x=0.1 open=-0.1:0.1", ["leaves the tank"]),
        ("x=0.1 open=0.1:0.104", ["lower than a cell", "the finest opening of cells_y = 20 is 0.0075 m, or cells_y = 38"]),
        ("x=0.1 open=0.1:0.05", ["lower than a cell"]),
    ],
)
def test_what_no_tank_can_have_is_refused(text: str, words: list[str]) -> None:
    with pytest.raises(RibError) as error:
        faces(parse(text), TANK, 50, 20)
    for word in [*words, "Remedy"]:
        assert word in str(error.value)


def test_places_on_the_nearest_faces() -> None:
    (west, closed), (east, slotted) = faces(parse("x=0.104 open=0.0:0.0081,0.0074:0.02,0.139:0.15; x=-0.096"), TANK, 50, 20)
    assert (west, east) == (14, 34) and closed.all()
    assert segments(closed) == [(0, 20)]
    assert segments(slotted) == [(3, 19)]
    grid = divided("x=0.104 open=0:0.02; x=-0.096; x=0 open=0:0.15", 50, 20)
    assert grid.rooms == [(0, 15), (15, 50)]
    assert grid.bays == [(0, 15), (15, 35), (35, 50)]
    assert grid.inner(grid.open_x)[:, 14].sum() == 0.0 and grid.inner(grid.open_x)[:, 34].sum() == 3.0
    assert grid.inner(grid.open_x)[:, 24].sum() == 20.0
    with pytest.raises(GridError, match=r"a baffle and a rib on one cell face, x=0 m\. Remedy"):
        Grid(TANK, 50, 20, Baffles(1), parse("x=0"))


MOTIONS = {
    "surge": (harmonic(9.0, 0.2, surge=2e-3), 0.0),
    "tension": (harmonic(9.0, 0.2, pitch=0.02, plunge=0.005), 0.07),
    "violent": (VIOLENT, 0.0),
}


@pytest.mark.parametrize("name", MOTIONS)
@pytest.mark.parametrize(("text", "edges"), [("x=0", (0, 32, 64)), ("x=-0.09; x=0.116", (0, 20, 47, 64))])
def test_compartments_are_tanks_of_their_own(name: str, text: str, edges: tuple[int, ...]) -> None:
    """Loads, ribs' included, and surfaces against separate tanks of the compartments' size and place: to the pressure's
    tolerance, which the datum of no compartment enters."""
    motion, sigma = MOTIONS[name]
    fluids, numerics = Fluids(surface_tension=sigma), Numerics(wall_slip=True, tolerance=1e-11)
    tank = Tank(0.5, 0.15, x=0.1, y=0.05)
    flows = [Flow(divided(text, tank=tank), fluids, numerics)]
    for first, last in pairwise(edges):
        length, centre = (last - first) * 0.5 / 64, 0.5 * (first + last) * 0.5 / 64 - 0.25
        flows.append(Flow(Grid(replace(tank, length=length, x=0.1 + centre), last - first, 24), fluids, numerics))
    found = []
    for flow in flows:
        flow.start(motion(0.0))
        found.append(march(flow, motion, 0.3, 0.01)[1][:, :5])
    separate = np.sum(found[1:], axis=0)
    gaps = np.abs(found[0] - separate).max(axis=0) / np.ptp(separate, axis=0)
    print(f"{name}, {text}: loads {gaps.max():.1e}")
    assert (np.ptp(separate, axis=0) > 1e-3).all()
    assert gaps.max() < 1e-8
    surfaces = np.concatenate([flow.fractions for flow in flows[1:]], axis=1)
    assert np.abs(flows[0].fractions - surfaces).max() < 1e-8


def test_a_shift_of_a_compartments_pressure_moves_no_load() -> None:
    flow = Flow(divided("x=0.065"))
    motion = SectionMotion(alpha=0.1, h_ddot=2.0)
    flow.start(motion)
    before = flow.loads(motion)
    q = flow.grid.inner(flow.state[5])
    for first, last in flow.grid.rooms:
        gas = 1.0 - flow.fractions[:, first:last]
        assert (q[:, first:last] * gas).sum() / gas.sum() == pytest.approx(0.0, abs=1e-12)
    q[:, : flow.grid.rooms[0][1]] += 7.0  # 7 kPa
    after = flow.loads(motion)
    np.testing.assert_allclose(after[:5], before[:5], rtol=1e-9, atol=1e-8)
    assert abs(after.force_east - before.force_east) > 1000.0  # the datum lies in the middle of the roof, west of the rib


def test_nothing_crosses_a_closed_rib_in_violent_motion() -> None:
    """Different fills, a column at the west wall beside an empty compartment: volumes to round-off."""
    grid = divided("x=0.025; x=0.15", 60, 20)
    flow = Flow(grid)
    flow.start_from(fractions(Shape(column=0.26), grid, 0.0), VIOLENT(0.0))
    before = [flow.fractions[:, first:last].sum() for first, last in grid.rooms]
    assert before[0] > 500.0 and before[1:] == [0.0, 0.0]
    march(flow, VIOLENT, 1.0, 0.02)
    after = [flow.fractions[:, first:last].sum() for first, last in grid.rooms]
    assert after[0] == pytest.approx(before[0], rel=1e-13)
    assert np.abs(after[1:]).max() == 0.0
    assert flow.fractions.max() < 1.0 + 1e-4
    assert np.ptp(flow.fractions[:, :33].sum(axis=0)) > 1.0


def test_a_rib_open_from_floor_to_roof_is_none() -> None:
    """To the bit, baffles and probes beside it."""
    rows = []
    for text in ("", "x=0.05 open=0:0.15", "x=0.05 open=0:0.06,0.06:0.15; x=-0.05 open=0:0.15"):
        grid = Grid(TANK, 40, 16, Baffles(1, 0.0, 0.4), parse(text))
        flow = Flow(grid, sensors=(Probe(0.1, 0.02),), window=0.02)
        assert flow.ribs is None
        flow.start(VIOLENT(0.0), 0.005)
        loads = march(flow, VIOLENT, 0.2, 0.01)[1]
        rows.append([value.hex() for value in loads.ravel().tolist()] + [value.hex() for value in flow.pressures()[0]])
    assert rows[0] == rows[1] == rows[2]


@pytest.mark.parametrize("text", ["x=0.065; x=-0.1", SLOTS])
@pytest.mark.parametrize("degrees", [5.0, 20.0])
def test_liquid_at_rest_stays_at_rest(text: str, degrees: float) -> None:
    """Each compartment level with the same fill; through openings one level."""
    grid = divided(text, 50, 20)
    flow = Flow(grid, numerics=Numerics(tolerance=1e-12))
    motion = SectionMotion(alpha=math.radians(degrees))
    flow.start(motion)
    flow.advance(motion, motion, 0.5)
    assert np.abs(flow.state[1:3]).max() < 1e-9
    loads = flow.loads(motion)
    assert loads.force_x == pytest.approx(0.0, abs=1e-7)
    assert loads.force_y == pytest.approx(-9.81 * 0.0375 * (1000.0 + 1.2), rel=1e-9)
    for first, last in grid.rooms:
        assert flow.fractions[:, first:last].mean() == pytest.approx(0.5, rel=1e-12)
        alone = flat(Grid(replace(TANK, length=(last - first) * 0.01), last - first, 20), motion.alpha)
        np.testing.assert_allclose(flow.fractions[:, first:last], alone, atol=1e-9)


def test_waves_leave_each_compartment_its_fill() -> None:
    grid = divided("x=0.065; x=-0.1 open=0:0.03", 50, 20)
    shapes = [Shape(wave=0.01), Shape(spectrum=0.01, seed=3), Shape(wave=0.004, spectrum=0.004, seed=5)]
    for shape in shapes:
        shares = fractions(shape, grid, 0.02)
        assert np.ptp(shares.sum(axis=0)) > 0.5
        for first, last in grid.rooms:
            assert shares[:, first:last].mean() == pytest.approx(0.5, rel=1e-12)
    with pytest.raises(ShapeError, match="in compartments half of it"):
        fractions(Shape(wave=0.05), grid, 0.0)
    fractions(Shape(wave=0.05), divided("", 50, 20), 0.0)


@pytest.mark.parametrize("text", ["x=0.06; x=-0.06", SLOTS])
def test_the_mirrored_motion_gives_the_mirrored_loads(text: str) -> None:
    """Surge and pitch, both ways, in a tank that is its own mirror image."""
    loads = []
    for sign in (1.0, -1.0):
        motion = harmonic(9.0, 0.2, pitch=sign * 0.03, surge=sign * 5e-3, plunge=3e-3)
        flow = Flow(divided(text, 50, 20), numerics=Numerics(tolerance=1e-11))
        flow.start(motion(0.0))
        loads.append(march(flow, motion, 0.5, 0.01)[1])
    for column, sign in ((0, -1.0), (1, 1.0), (2, -1.0), (3, -1.0), (4, 1.0)):
        one, two = loads[0][:, column], sign * loads[1][:, column]
        assert np.abs(one - two).max() < 1e-6 * np.ptp(one)
    np.testing.assert_allclose(loads[0][:, 5], -loads[1][:, 6], atol=1e-6 * np.ptp(loads[0][:, 5]))


@pytest.mark.parametrize("text", ["x=0.065", SLOTS])
def test_a_steady_speed_changes_nothing(text: str) -> None:
    runs = []
    for speed in (0.0, 30.0):
        flow = Flow(divided(text, 50, 20), numerics=Numerics(tolerance=1e-11))

        def motion(t: float, speed: float = speed) -> SectionMotion:
            own = VIOLENT(t)
            return own._replace(x=speed * t, x_dot=speed, h=own.h - speed * t, h_dot=own.h_dot - speed)

        flow.start(motion(0.0))
        runs.append(march(flow, motion, 0.2, 0.01)[1])
    assert np.abs(runs[1] - runs[0]).max() < 1e-6 * np.abs(runs[0]).max()


@pytest.mark.parametrize(
    ("motion", "h", "most"),
    [(harmonic(4.0, 0.5, surge=1e-3), 1e-3, 1e-3), (harmonic(25.0, 0.05, pitch=math.radians(4.0)), 5e-4, 0.02)],
    ids=["gentle", "violent"],
)
@pytest.mark.parametrize("text", ["x=0.065", SLOTS])
def test_walls_and_ribs_carry_the_change_of_momentum(text: str, motion: Course, h: float, most: float) -> None:
    flow = Flow(divided(text, 100, 30), numerics=Numerics(max_step=h, wall_slip=True))
    gap = momentum_gap(flow, motion, 1.0, h)
    print(f"{text}: wall against momentum: x {gap[0]:.1e}, y {gap[1]:.1e}")
    assert gap[0] < most


def test_probes_and_gauges_keep_to_their_side_of_a_rib() -> None:
    """A tilted tank at rest: levels, and pressures above each compartment's own gas, differ across the rib."""
    sensors = (Probe(0.249, 0.01), Probe(0.251, 0.01), Probe(0.0, 0.01))
    flow = Flow(divided("x=0", 50, 20), Fluids(gas_density=1e-3), Numerics(tolerance=1e-12), sensors)
    motion = SectionMotion(alpha=0.1)
    flow.start(motion)
    slope = math.tan(0.1)
    west, east, wall = (row[0] for row in flow.pressures())
    drop = 9810.0 * math.cos(0.1)
    for seen, x in ((west, 0.249 - 0.125), (east, 0.251 - 0.375), (wall, -0.125)):
        assert seen == pytest.approx(drop * (0.065 + slope * x), abs=0.05)
    np.testing.assert_allclose(flow.heights(np.array([0.2449, 0.25, 0.26])), slope * np.array([0.1199, -0.12, -0.115]), atol=2e-5)
    assert flow.heights(np.array([0.2499]))[0] == pytest.approx(slope * 0.12, abs=1e-6)
    np.testing.assert_allclose(flow.heights(np.array([0.0, 0.5])), flow.wave_heights, rtol=1e-12)


def test_slots_lie_between_an_open_and_a_closed_tank() -> None:
    """Slots on floor and roof: the wider they are the nearer the first mode's turn comes to that of the undivided tank."""
    turns = []
    for opening in (0.15, 0.075, 0.03):
        text = "" if opening == 0.15 else f"x=0 open=0:{0.5 * opening},{0.15 - 0.5 * opening}:0.15"
        flow = Flow(divided(text, 50, 20))
        flow.start(REST, 0.002)
        times, loads = march(flow, lambda t: REST, 1.0, 0.01)
        turns.append(times[np.nonzero(np.diff(np.sign(loads[:, 2])))[0][0]])
    assert 1.02 * turns[0] < turns[1] and 1.1 * turns[1] < turns[2]


def test_a_snapshot_repeats_to_the_bit() -> None:
    flow = Flow(divided(SLOTS + "; x=0.1", 40, 16))
    flow.start(VIOLENT(0.0))
    march(flow, VIOLENT, 0.1, 0.01)
    kept, runs = flow.save(), []
    for again in (flow, flow, Flow(divided(SLOTS + "; x=0.1", 40, 16))):
        again.restore(kept)
        for k in range(10, 20):
            again.advance(VIOLENT(0.01 * k), VIOLENT(0.01 * (k + 1)), 0.01)
        runs.append([value.hex() for value in again.loads(VIOLENT(0.2))])
    assert runs[0] == runs[1] == runs[2]


def test_an_opening_under_the_surface_alone_lets_nothing_through() -> None:
    """Two fluids that cannot be compressed: what liquid goes must come back as gas. With a slot on the roof it does."""
    motion = harmonic(6.0, 0.2, surge=0.01)
    swings = []
    for text in ("x=0 open=0:0.03", SLOTS):
        flow = Flow(divided(text, 50, 20))
        flow.start(motion(0.0))
        aft = []
        for k in range(60):
            flow.advance(motion(0.01 * k), motion(0.01 * (k + 1)), 0.01)
            aft.append(flow.fractions[:, 25:].mean())
        swings.append(np.ptp(aft))
    assert swings[0] < 1e-6 and swings[1] > 0.01
