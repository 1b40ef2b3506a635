"""What a simplification does to I_zz, in closed form: I_zz estimated over true, minus 1,
of one run [1]. Arguments in SI, as in `gyrodata.physics`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike


def tilt_bias(
    precession_rate: ArrayLike,
    spin: ArrayLike,
    pitch: ArrayLike,
    inertia: ArrayLike,
    transverse_inertia: ArrayLike,
) -> Any:
    """Bias of eq. (9) for a tilted rod: (1 − I/I_zz)(φ̇/ψ̇) sin(pitch), exact for steady
    precession.
    """
    shape = 1.0 - np.divide(transverse_inertia, inertia)
    rates = np.divide(precession_rate, spin)
    return shape * rates * np.sin(pitch)


def release_bias(
    torque: ArrayLike,
    spin: ArrayLike,
    inertia: ArrayLike,
    transverse_inertia: ArrayLike,
) -> Any:
    """Bias of a released rod that is treated as steady: 2δ², with δ = I M/(I_zz ψ̇)².

    Lowest order in δ, for a level rod and its total spin ψ̇; too high by 3 % of itself
    at δ = 0.07, by 15 % at 0.17.
    """
    pull = np.multiply(transverse_inertia, torque)
    momentum = np.multiply(inertia, spin)
    return 2 * (pull / momentum**2) ** 2
