# %% [markdown]
# # Does this section flutter, and what does fuel change?
# Cells for Jupyter (jupytext), VS Code or plain Python: `python examples/first_flutter.py`. The mesh is small, so that it takes
# seconds; leave out the line `aero=…` for results.

# %%
import numpy as np

import aeroslosh as ae

case = ae.Case.isogai_a().replace(
    flow={"mach": 0.8},
    aero={"cells_around": 96, "cells_normal": 24},
    flutter={"free_cycles": 3.0},
)
print(case.name, case["flow.airfoil"], case["section.mass_ratio"])

# %% One point: a verdict, and the history as an xarray.Dataset with units
point = ae.point(case, V_f=0.9)
print(point)
print(point.history.alpha.attrs, float(abs(point.history.alpha).max()), "rad at most")
figure = point.plot()

# %% The boundary: every neutral V_f as a table, and the modes of the linear model over V_f
curve = ae.boundary(case, mach=[0.7, 0.8])
print(curve.crossings[["mach", "V_f", "V_f_uncertainty", "name"]])
print(curve.modes(V_f=0.8, mach=0.8))
figure = curve.plot()

# %% A sweep: a Dataset over the swept keys. With folder="runs/map" it can be interrupted, goes on, and opens again: ae.open
fuel = ae.Case.load("paper_s").replace(flow={"mach": 0.8}, aero={"cells_around": 96, "cells_normal": 24})
grid = ae.sweep(fuel, {"flutter.V_f": [0.7, 0.78, 0.9], "slosh.model": ["none", "frozen"]}, workers=2)
print(grid.growth_rate.sel({"slosh.model": "none"}).values)
print(grid.verdict.to_pandas())

# %% One FMU alone, driven by a table of its inputs
time = np.linspace(0.0, 2.0, 401)
loads = ae.simulate("slosh_ems", {"time": time, "x": 0.005 * np.sin(5.0 * time)}, parameters={"tank_length": 0.5})
print(f"largest force {float(abs(loads.force_x).max()):.2f} {loads.force_x.units}")

# %% Any system of FMUs
ride = ae.System.load("tank_on_springs").run()
print(ride.attrs["outcome"], float(ride["stand.alpha"][-1]))
