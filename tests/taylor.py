"""The motion of a top to more digits than a float has, by Taylor series of the vector equations in whole numbers.

ė3 = (H × e3)/I and Ḣ = M Z × e3 are products of two unknowns at most, so each coefficient of the series follows
from the earlier ones by sums of products. No angles, energies or elliptic functions are used here.
"""

from __future__ import annotations

from fractions import Fraction
from operator import mul

import numpy as np
from numpy.typing import NDArray

BITS, ORDER = 150, 44
Vector = list[int]


def fixed(value: Fraction | float) -> int:
    return round(Fraction(value) * (1 << BITS))


def taylor(
    transverse: float, torque: float, axis: NDArray[np.float64], momentum: NDArray[np.float64], time: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """e3 and H after a time, from floats taken to be exact; right to the last digit of the floats given back."""
    rate = float(np.linalg.norm(momentum)) / transverse + 4 * float(np.sqrt(abs(torque) / transverse))
    steps = max(1, int(np.ceil(rate * abs(time))))
    step = fixed(Fraction(time) / steps)
    gravity = fixed(Fraction(torque) / Fraction(transverse)) * step >> BITS
    e = [fixed(float(component)) for component in axis]
    h = [fixed(Fraction(float(component)) / Fraction(transverse)) for component in momentum]
    for _ in range(steps):
        e, h = one_step(e, h, step, gravity)
    scale = 1 << BITS
    return (
        np.array([float(Fraction(component, scale)) for component in e]),
        np.array([float(Fraction(component, scale) * Fraction(transverse)) for component in h]),
    )


def one_step(e: Vector, h: Vector, step: int, gravity: int) -> tuple[Vector, Vector]:
    x, y, z = [e[0]], [e[1]], [e[2]]
    hx, hy = [h[0]], [h[1]]
    for k in range(ORDER):
        # The vertical part of H never changes.
        turned_x = sum(map(mul, hy, reversed(z))) - h[2] * y[k]
        turned_y = h[2] * x[k] - sum(map(mul, hx, reversed(z)))
        turned_z = sum(map(mul, hx, reversed(y))) - sum(map(mul, hy, reversed(x)))
        hx.append((-gravity * y[k] >> BITS) // (k + 1))
        hy.append((gravity * x[k] >> BITS) // (k + 1))
        x.append((turned_x >> BITS) * step // (k + 1) >> BITS)
        y.append((turned_y >> BITS) * step // (k + 1) >> BITS)
        z.append((turned_z >> BITS) * step // (k + 1) >> BITS)
    return [sum(x), sum(y), sum(z)], [sum(hx), sum(hy), h[2]]
