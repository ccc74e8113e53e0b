"""Random typical sections, as wide as an engineer meets them, for properties that must hold for every one."""

from __future__ import annotations

import numpy as np

from master.case import Case


def draw(seed: int) -> Case:
    """Section number `seed`: axis at 0.2 to 0.6, x_alpha −0.3 to 0.5, r2 0.1 to 1, frequency ratio 0.1 to 2, mass ratio 5 to 300,
    structural damping 0 to 3 %; V_f 0.1 to 3, half of the time within 20 % of the flutter of a quasi-steady guess."""
    rng = np.random.default_rng([14, seed])
    case = Case(name=f"section_{seed}")
    s = case.section
    while True:
        s.elastic_axis = float(rng.uniform(0.2, 0.6))
        s.x_alpha = float(rng.uniform(-0.3, 0.5))
        s.r2_alpha = float(rng.uniform(0.1, 1.0))
        if s.r2_alpha > s.x_alpha**2 + 0.02:
            break
    s.frequency_ratio = float(rng.uniform(0.1, 2.0))
    s.mass_ratio = float(np.exp(rng.uniform(np.log(5.0), np.log(300.0))))
    s.damping_ratio_h, s.damping_ratio_alpha = (float(x) for x in rng.uniform(0.0, 0.03, 2))
    case.flow.mach = 0.3
    case.flutter.V_f = float(np.exp(rng.uniform(np.log(0.1), np.log(3.0))))
    case.boundary.V_f_range = [0.1, 3.0]
    case.output.pictures = case.output.fields = False
    return case
