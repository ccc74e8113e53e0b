"""What a network reads out of the memory, all dimensionless, split by the mirror symmetry of a tank.

Seen in a mirror at the tank's middle, f_x, alpha'', every s_n and S_n change sign, and so do the force along the tank and the
moment; gamma, alpha'² and the force up its axis do not. Odd features may enter along and moment alone, even ones up alone: the
symmetry holds by construction.
"""

from __future__ import annotations

import numpy as np

from ..kit.compiled import jit
from .body import Body
from .memory import FX, GAMMA, MODES, RATE, SECOND, SPIN, Array, Complex

LINEAR = 9  # f_x/g, (l/2)alpha''/g, forces of modes 1 to 4, of all the others, velocities of modes 1 and 2
ODD = 2 * LINEAR + 6  # linear, gamma times linear, forces of S_1 to S_3, (l/2)alpha'²/g times the first three
EVEN = 2 + LINEAR * (LINEAR + 1) // 2  # gamma, (l/2)alpha'²/g, products of two linear ones; nothing of them at rest
SPACE = 9  # coordinates of the radial basis functions
MIRROR = np.array([-1.0, -1.0, 1.0, -1.0, -1.0, -1.0, -1.0, -1.0, 1.0])
"""Signs of the coordinates in the mirror: f_x, alpha'', gamma, modes 1, 2, all others, velocity of mode 1, S_1, alpha'²."""


@jit
def features(w: Complex, rows: Array, body: Body, odd: Array, even: Array, space: Array) -> None:
    """Fill odd (ODD,), even (EVEN,) and space (SPACE,) from the memory and the drive of one instant."""
    gamma, square = rows[GAMMA], rows[RATE]
    odd[0], odd[1], odd[6] = rows[FX], rows[SPIN], 0.0
    for n in range(MODES):
        force = body.spring[n] * w[n].imag * body.place[n]
        if n < 4:
            odd[2 + n] = force
        else:
            odd[6] += force
    for n in range(2):
        # springs and dampers in one unit: velocity over omega, that is w.real/omega with place = 1/imag(rate)
        odd[7 + n] = body.spring[n] * (w[n].real + body.decay[n] * w[n].imag) * body.place[n]
    for i in range(LINEAR):
        odd[LINEAR + i] = gamma * odd[i]
    for n in range(3):
        odd[2 * LINEAR + n] = body.spring[n] * w[MODES + n].imag * body.place[n]
        odd[2 * LINEAR + 3 + n] = square * odd[n]
    even[0], even[1] = gamma, square
    k = 2
    for i in range(LINEAR):
        for j in range(i, LINEAR):
            even[k] = odd[i] * odd[j]
            k += 1
    space[0], space[1], space[2], space[3], space[4] = odd[0], odd[1], gamma, odd[2], odd[3]
    space[5], space[6], space[7], space[8] = odd[6], odd[7], odd[2 * LINEAR], square


assert SECOND >= 3  # modes with a correction that are read out
