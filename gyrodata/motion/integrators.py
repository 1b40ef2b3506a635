"""The motion step by step: by geometric splitting, or by an integrator that takes drag too.

Splitting: exact turns of the rod about H, and kicks of H by the torque, one after the other. The energy is that of the
free body plus the potential. Each alone is solved exactly: without torque H is fixed and e3 turns about it at |H|/I;
without motion H grows by dt M Z × e3. So |e3|, H·Z and H·e3 stay what they are to rounding, and the energy does not
drift, whatever the step (a Lie–Poisson integrator). Take at least four steps in a nutation: with fewer the answer is
wrong without any sign of it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gyrodata.motion.orbits import State, Top

_A1, _A2, _B1, _B2 = 0.07534696026989289, 0.5179168546882568, 0.19022593937367662, 0.8465240704435263
_A3, _B3 = 1 / 2 - _A1 - _A2, 1 - 2 * (_B1 + _B2)

METHODS: dict[str, tuple[tuple[float, ...], tuple[float, ...]]] = {
    "strang": ((1 / 2, 1 / 2), (1.0,)),
    "aba84": ((_A1, _A2, _A3, _A3, _A2, _A1), (_B1, _B2, _B3, _B2, _B1)),
}
"""The turns and the kicks between them, in parts of a step. For a torque that is small, of relative size ε:

strang: order 2, error ε dt² after a given time. aba84: order 4, error ε dt⁸ + ε² dt⁴ (Blanes, Casas, Farrés, Laskar,
Makazaga and Murua, Applied Numerical Mathematics 68, 58, 2013, their ABA(8,4); its last digits here are from the order
conditions).
"""


def split(top: Top, state: State, time: float, steps: int, method: str = "aba84") -> State:
    """Follow one top for a time [s], of either sign, by equal steps; the method is one of `METHODS`."""
    if method not in METHODS:
        raise ValueError(f"there is no method {method!r}; choose one of {', '.join(METHODS)}")
    if steps < 1:
        raise ValueError(f"{steps} steps lead nowhere; take 1 at least")
    step = time / steps
    turns = [float(part * step / top.transverse_inertia) for part in METHODS[method][0]]
    kicks = [float(part * step * top.torque) for part in METHODS[method][1]]
    # The turn that ends a step and the one that begins the next are about the same H, so they are one.
    pairs = list(zip(kicks, [*turns[1:-1], turns[-1] + turns[0]], strict=True))
    # Python's own floats are ten times faster than arrays of three.
    (x, y, z), (hx, hy, hz) = state.axis.tolist(), state.momentum.tolist()
    x, y, z = _turned(x, y, z, hx, hy, hz, turns[0])
    for _ in range(steps):
        for kick, turn in pairs:
            hx, hy = hx - kick * y, hy + kick * x
            x, y, z = _turned(x, y, z, hx, hy, hz, turn)
    return State(np.array(_turned(x, y, z, hx, hy, hz, -turns[0])), np.array([hx, hy, hz]))


def _turned(x: float, y: float, z: float, hx: float, hy: float, hz: float, turn: float) -> tuple[float, float, float]:
    """Turn the vector (x, y, z) about H by |H| times `turn` (Rodrigues, with half angles for small turns)."""
    size = math.sqrt(hx * hx + hy * hy + hz * hz) + 1e-300
    nx, ny, nz = hx / size, hy / size, hz / size
    half = size * turn / 2
    sine = math.sin(half)
    across, along = 2 * sine * math.cos(half), 2 * sine * sine
    # e + sin α (n × e) + (1 − cos α) n × (n × e)
    cx, cy, cz = ny * z - nz * y, nz * x - nx * z, nx * y - ny * x
    return (
        x + across * cx + along * (ny * cz - nz * cy),
        y + across * cy + along * (nz * cx - nx * cz),
        z + across * cz + along * (nx * cy - ny * cx),
    )


class Path(State, frozen=True, eq=False):
    """The state of one top at a number of times, axis and momentum of shape (n, 3), or (3,) for one time."""

    evaluations: int
    """How often the right-hand side was asked for."""


def integrate(
    top: Top,
    state: State,
    time: ArrayLike,
    *,
    drag: float = 0.0,
    method: str = "DOP853",
    rtol: float = 1e-9,
    atol: float = 1e-12,
) -> Path:
    """Follow one top in the vectors e3 and H, with gravity and a linear drag.

    The times [s] rise from 0, or fall from 0. `drag` is c [N*m*s] of a torque −c ω, the same about every axis. `method`
    is one that `scipy.integrate.solve_ivp` takes; nothing here is stiff. With `rtol` above 1e-6 the answer may be no
    better than eq. (9); `atol` is that of e3, and for H as much of |H| at the start, or of √(I |M|) if that is more.
    """
    from scipy.integrate import solve_ivp

    if not np.isfinite(drag):
        raise ValueError("the drag is not a finite number")
    times = np.asarray(time, dtype=float)
    ends = np.atleast_1d(times)
    steps = np.diff(ends, prepend=0.0)
    if not ((steps >= 0).all() or (steps <= 0).all()):
        raise ValueError("the times must rise from 0, or fall from 0")
    start, evaluations = np.concatenate([state.axis, state.momentum]), 0
    rows = np.tile(start, (ends.size, 1))
    if times.any():
        rates = vector_rates(top, drag)
        size = max(float(np.linalg.norm(state.momentum)), math.sqrt(abs(top.torque) * top.transverse_inertia))
        # The integrator takes each time once.
        sense = np.copysign(1.0, ends[-1])
        distinct, again = np.unique(sense * ends, return_inverse=True)
        done = solve_ivp(
            # Python's own floats are ten times faster one at a time.
            lambda _, row: rates(*row.tolist()),
            (0.0, ends[-1]),
            start,
            method=method,
            t_eval=sense * distinct,
            rtol=rtol,
            atol=atol * np.repeat([1.0, size], 3),
        )
        if not done.success:
            raise ValueError(f"the integrator gave up: {done.message}")
        rows, evaluations = done.y.T[again], done.nfev
    rows = rows.reshape(*times.shape, 6)
    return Path(rows[..., :3], rows[..., 3:], evaluations)


Rates = Callable[[Any, Any, Any, Any, Any, Any], tuple[Any, Any, Any, Any, Any, Any]]
"""How fast e3 and H change, as a function of their components."""


def vector_rates(top: Top, drag: ArrayLike = 0.0, pace: ArrayLike = 1.0) -> Rates:
    """The right-hand side by components, floats or arrays: gravity and linear drag, in a time `pace` times as fast."""
    # 0-d arrays would be slower than Python's floats.
    transverse, weight, slowing, along = (
        float(value) if np.ndim(value) == 0 else value
        for value in (
            np.divide(top.transverse_inertia, pace),
            np.multiply(top.torque, pace),
            np.multiply(drag, pace) / top.transverse_inertia,
            # ω = H/I + (1/I_zz − 1/I)(H·e3) e3.
            np.multiply(drag, pace) * (1 / np.asarray(top.inertia) - 1 / np.asarray(top.transverse_inertia)),
        )
    )

    def rates(x: Any, y: Any, z: Any, hx: Any, hy: Any, hz: Any) -> tuple[Any, Any, Any, Any, Any, Any]:
        spin = along * (hx * x + hy * y + hz * z)
        return (
            (hy * z - hz * y) / transverse,
            (hz * x - hx * z) / transverse,
            (hx * y - hy * x) / transverse,
            -weight * y - slowing * hx - spin * x,
            weight * x - slowing * hy - spin * y,
            -slowing * hz - spin * z,
        )

    return rates
