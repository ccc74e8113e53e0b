"""The neutral V_f of a case's Mach numbers: a setup a Mach number, the strategy the case names, every march watched."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from ..case.case import Case
from ..cosim.loop import Watcher
from ..flutter import ensemble
from ..flutter.march import March
from ..flutter.setup import FlutterSetup
from . import strategy as boundary_strategy
from .search import BoundaryPoint, Limits, Marcher, boundary


def solve(
    case: Case,
    fmus: dict[str, Path],
    say: Callable[[str], None],
    on_point: Callable[[BoundaryPoint], None] = lambda point: None,
    on_march: Callable[[FlutterSetup, March], None] = lambda setup, march: None,
    before_march: Callable[[FlutterSetup, float], Watcher | None] = lambda setup, V_f: None,
    on_setup: Callable[[FlutterSetup], None] = lambda setup: None,
    section_file: Callable[[], Path | None] = lambda: None,
    start: tuple[float, float | None] | None = None,
) -> list[BoundaryPoint]:
    """All Mach numbers of `case.boundary`; a search without a linear model begins at `start`, V_f and dσ/dV_f, or at the
    case's V_f.

    `on_setup` sees each setup, `before_march` gives the watcher of a march's steps, `on_march` and `on_point` see what
    is done; `section_file` says where a setup writes its section for a picture. Raises AeroSloshError
    (not ComponentError: a failing component is an outcome of its Mach number)."""
    setups: dict[float, FlutterSetup] = {}

    def open_setup(of: Case, mach: float, section: Path | None = None) -> FlutterSetup:
        return FlutterSetup(of, fmus, mach, None, say, section)

    def marcher_at(mach: float) -> tuple[Marcher, Any]:
        setups.clear()
        setup = setups[mach] = open_setup(case, mach, section_file())
        on_setup(setup)

        def marcher(V_f: float) -> March:
            march = ensemble.march(setup, V_f, lambda: before_march(setup, V_f))
            on_march(setup, march)
            return march

        return marcher, setup.close

    def found(point: BoundaryPoint) -> None:
        point.case = case
        on_point(point)

    b = case.boundary
    strategy = boundary_strategy.Confirm(case, setups.__getitem__, open_setup, say, b.method == "both")
    limits = Limits(b.V_f_range[0], b.V_f_range[1], b.tolerance, b.max_marches)
    guess, slope = start or (case.flutter.V_f, None)
    # the matrices are small: a second thread of BLAS spins for nothing, and ten times as long beside another process
    with threadpool_limits(1, "blas"):
        return boundary(marcher_at, b.mach, guess, limits, found, strategy, slope)
