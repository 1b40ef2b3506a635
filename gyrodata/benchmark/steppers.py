"""Integrators that the tool does not use, in the vectors e3 and H: what splitting is measured against.

`rk4` and `midpoint` are textbook methods with a fixed step; `lie` turns e3 by rotations alone, as splitting does, but
of fourth order by a Runge-Kutta scheme on the group; `tsit5` is a pair with adaptive steps for `scipy`. All go through
one top in Python's floats, or through a stack of them in arrays.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from gyrodata import motion

if TYPE_CHECKING:
    from scipy.integrate import OdeSolver

_CLOSE_ENOUGH = 1e-15
"""Change of e3 at which the equation of the midpoint is solved: the next change would be a thousandth of it."""

_MOST_TURNS = 50

Row = list[Any]
"""Six components, of e3 and of H."""


def _rk4(row: Row, top: motion.Top, drag: ArrayLike, step: Any, steps: int) -> tuple[Row, int]:
    """Take steps of the classical Runge-Kutta method, order 4."""
    rates = motion.vector_rates(top, drag, step)
    for _ in range(steps):
        a = rates(*row)
        b = rates(*[y + k / 2 for y, k in zip(row, a, strict=True)])
        c = rates(*[y + k / 2 for y, k in zip(row, b, strict=True)])
        d = rates(*[y + k for y, k in zip(row, c, strict=True)])
        row = [y + (ka + 2 * (kb + kc) + kd) / 6 for y, ka, kb, kc, kd in zip(row, a, b, c, d, strict=True)]
    return row, 4 * steps


def _midpoint(row: Row, top: motion.Top, drag: ArrayLike, step: Any, steps: int) -> tuple[Row, int]:
    """Take steps of the implicit midpoint rule, order 2; it knows of no drag.

    It keeps all that is quadratic, here |e3|, H·e3 and the energy. Given H at the midpoint, e3 there is e3 turned by
    Cayley's transform, so that only H is sought by iteration.
    """
    if np.any(drag):
        raise ValueError("the midpoint rule here knows of no drag")
    turn, kick = step / (2 * top.transverse_inertia), step * top.torque / 2
    x, y, z, hx, hy, hz = row
    count = 0
    for _ in range(steps):
        mx, my, mz = x, y, z
        for _turn in range(_MOST_TURNS):
            count += 1
            ax, ay, az = turn * (hx - kick * my), turn * (hy + kick * mx), turn * hz
            along = ax * x + ay * y + az * z
            share = 1 / (1 + ax * ax + ay * ay + az * az)
            nx = share * (x + ay * z - az * y + along * ax)
            ny = share * (y + az * x - ax * z + along * ay)
            mz = share * (z + ax * y - ay * x + along * az)
            change = abs(nx - mx) + abs(ny - my)
            mx, my = nx, ny
            if np.all(change < _CLOSE_ENOUGH) if np.ndim(change) else change < _CLOSE_ENOUGH:
                break
        x, y, z = 2 * mx - x, 2 * my - y, 2 * mz - z
        hx, hy = hx - 2 * kick * my, hy + 2 * kick * mx
    return [x, y, z, hx, hy, hz], count


def _lie(row: Row, top: motion.Top, drag: ArrayLike, step: Any, steps: int) -> tuple[Row, int]:
    """Take steps of the method of Runge, Kutta and Munthe-Kaas, order 4: e3 is only ever turned, H added to.

    Munthe-Kaas, Applied Numerical Mathematics 29, 115, 1999, on turns of e3 and shifts of H.
    """
    torque = motion.vector_rates(top, drag, step)
    per = step / top.transverse_inertia
    functions = np if any(np.ndim(part) for part in row) or np.ndim(per) else math

    def slope(at: Row) -> Row:
        return [per * at[3], per * at[4], per * at[5], *torque(*at)[3:]]

    def moved(by: Row) -> Row:
        x, y, z, hx, hy, hz = row
        turned = motion.turned(x, y, z, by[0], by[1], by[2], 1.0, functions)
        return [*turned, hx + by[3], hy + by[4], hz + by[5]]

    for _ in range(steps):
        a = slope(row)
        b = slope(moved([k / 2 for k in a]))
        c = slope(moved([k / 2 - bent / 8 for k, bent in zip(b, _bracket(a, b), strict=True)]))
        d = slope(moved(c))
        row = moved(
            [
                (ka + 2 * (kb + kc) + kd - bent / 2) / 6
                for ka, kb, kc, kd, bent in zip(a, b, c, d, _bracket(a, d), strict=True)
            ]
        )
    return row, 4 * steps


def _bracket(a: Row, b: Row) -> Row:
    """Commutator of two turns; shifts commute."""
    turn = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    return [*turn, 0.0, 0.0, 0.0]


STEPPERS: dict[str, Callable[[Row, motion.Top, ArrayLike, Any, int], tuple[Row, int]]] = {
    "RK4": _rk4,
    "implicit midpoint": _midpoint,
    "RKMK4": _lie,
}
"""Methods with a fixed step, by name."""


def march(
    method: str, top: motion.Top, state: motion.State, time: ArrayLike, steps: int, drag: ArrayLike = 0.0
) -> motion.Path:
    """Follow a top, or each of a stack, for a time [s] in equal steps by one of `STEPPERS` or of `motion.METHODS`."""
    if method in motion.METHODS:
        if np.any(drag):
            raise ValueError("splitting knows of no drag")
        end = motion.split(top, state, time, steps, method)
        return motion.Path(end.axis, end.momentum, steps * len(motion.METHODS[method][1]))
    step: Any = np.asarray(time, dtype=float)[()] / steps
    rows: Row = [vector[..., i] for vector in (state.axis, state.momentum) for i in range(3)]
    if not (np.ndim(step) or np.ndim(top.torque) or np.ndim(rows[0])):
        # Python's own floats are ten times faster one at a time.
        rows, step = [float(part) for part in rows], float(step)
        top = motion.Top(float(top.inertia), float(top.transverse_inertia), float(top.torque))
    found, evaluations = STEPPERS[method](rows, top, drag, step, steps)
    shape = np.broadcast_shapes(*map(np.shape, found))
    whole = np.stack([np.broadcast_to(part, shape) for part in found], axis=-1)
    return motion.Path(whole[..., :3], whole[..., 3:], evaluations)


def tsit5() -> type[OdeSolver]:
    """The pair of Tsitouras, order 5(4), as a method for `motion.integrate`, with the steps that scipy's RK45 chooses.

    Computers & Mathematics with Applications 62, 770, 2011.
    """
    from scipy.integrate import RK45

    class Tsit5(RK45):  # type: ignore[misc]
        """Tsitouras' coefficients in the place of Dormand and Prince's."""

        C = np.array([0, 0.161, 0.327, 0.9, 0.9800255409045097, 1])
        A = np.array(
            [
                [0, 0, 0, 0, 0],
                [0.161, 0, 0, 0, 0],
                [-0.008480655492356989, 0.335480655492357, 0, 0, 0],
                [2.8971530571054935, -6.359448489975075, 4.3622954328695815, 0, 0],
                [5.325864828439257, -11.748883564062828, 7.4955393428898365, -0.09249506636175525, 0],
                [5.86145544294642, -12.92096931784711, 8.159367898576159, -0.071584973281401, -0.028269050394068383],
            ]
        )
        B = np.array(
            [
                0.09646076681806523, 0.01, 0.4798896504144996, 1.379008574103742, -3.290069515436081,
                2.324710524099774,
            ]
        )  # fmt: skip
        E = np.array(
            [
                -0.00178001105222577714, -0.0008164344596567469, 0.007880878010261995, -0.1447110071732629,
                0.5823571654525552, -0.45808210592918697, 1 / 66,
            ]
        )  # fmt: skip
        # The polynomial between two steps: a column a power, the first is the time itself.
        P = np.array(
            [
                [1, -2.763706197274826, 2.9132554618219126, -1.0530884977290216],
                [0, 0.1317, -0.2234, 0.1017],
                [0, 3.9302962368947516, -5.941033872131505, 2.490627285651253],
                [0, -12.411077166933676, 30.33818863028232, -16.548102889244902],
                [0, 37.50931341651104, -88.1789048947664, 47.37952196281928],
                [0, -27.896526289197286, 65.09189467479366, -34.87065786149661],
                [0, 1.5, -4, 2.5],
            ]
        )

    return Tsit5
