"""aeroslosh: does fuel sloshing in a wing tank make the wing flutter earlier or later?

    import aeroslosh as ae

    case = ae.Case.isogai_a().replace(flow={"mach": 0.8})
    ae.point(case, V_f=0.9)                                 # verdict, growth rate, history as an xarray.Dataset
    ae.boundary(case, mach=[0.7, 0.8]).crossings            # neutral V_f as a DataFrame
    ae.sweep(case, {"flutter.V_f": [0.8, 0.9, 1.0]})        # an xarray.Dataset over the swept keys
    ae.amplitude(case, V_f=[0.9, 1.0])                      # limit cycles and damping over amplitude
    ae.open("runs/map")                                     # any run or sweep folder, again as these objects
    ae.report("runs/map")                                   # the same as one HTML page that can be sent
    ae.simulate("slosh_vof", {"time": t, "x": x})           # one FMU
    ae.System.load("tank_on_springs").run()                 # any system of FMUs

Everything is loaded when it is first asked for."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .master.analysis.verdict import Verdict
    from .master.api.amplitude import Amplitude, amplitude
    from .master.api.boundary import Boundary, boundary
    from .master.api.case import Case
    from .master.api.opened import open_run as open
    from .master.api.point import Point, point
    from .master.api.progress import Cancelled, Update
    from .master.api.report import report
    from .master.api.simulate import System, simulate
    from .master.api.sweep import sweep
    from .master.base.errors import AeroSloshError, ComponentError

__all__ = [
    "AeroSloshError", "Amplitude", "Boundary", "Cancelled", "Case", "ComponentError", "Point", "System", "Update", "Verdict",
    "__version__", "amplitude", "boundary", "open", "point", "report", "simulate", "sweep",
]  # fmt: skip
_PLACES = {
    "AeroSloshError": ("base.errors", "AeroSloshError"),
    "Amplitude": ("api.amplitude", "Amplitude"),
    "Boundary": ("api.boundary", "Boundary"),
    "Cancelled": ("api.progress", "Cancelled"),
    "Case": ("api.case", "Case"),
    "ComponentError": ("base.errors", "ComponentError"),
    "Point": ("api.point", "Point"),
    "System": ("api.simulate", "System"),
    "Update": ("api.progress", "Update"),
    "Verdict": ("analysis.verdict", "Verdict"),
    "amplitude": ("api.amplitude", "amplitude"),
    "boundary": ("api.boundary", "boundary"),
    "open": ("api.opened", "open_run"),
    "point": ("api.point", "point"),
    "report": ("api.report", "report"),
    "simulate": ("api.simulate", "simulate"),
    "sweep": ("api.sweep", "sweep"),
}


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib import metadata

        return metadata.version("aeroslosh")
    if name not in _PLACES:
        raise AttributeError(f"module 'aeroslosh' has no attribute '{name}'")
    module, own = _PLACES[name]
    value = getattr(importlib.import_module(f".master.{module}", __name__), own)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
