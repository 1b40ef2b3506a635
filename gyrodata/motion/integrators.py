"""The motion step by step: by geometric splitting, or by an integrator that takes drag and other torques too.

Splitting: exact turns of the rod about H, and kicks of H by the torque, one after the other. The energy is that of the
free body plus the potential. Each alone is solved exactly: without torque H is fixed and e3 turns about it at |H|/I;
without motion H grows by dt M Z × e3. So |e3|, H·Z and H·e3 stay what they are to rounding, and the energy does not
drift, whatever the step (a Lie–Poisson integrator). Take four steps a nutation at least: with fewer the answer is wrong
without any sign of it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gyrodata.motion.orbits import State, Top
from gyrodata.physics import Floats

_ROOT30 = math.sqrt(30)
_INNER, _OUTER = math.sqrt(525 - 70 * _ROOT30) / 70, math.sqrt(525 + 70 * _ROOT30) / 70
_SMALL, _LARGE = 1 / 4 - _ROOT30 / 72, 1 / 4 + _ROOT30 / 72
_A1, _A2, _B1, _B2 = 0.07534696026989289, 0.5179168546882568, 0.19022593937367662, 0.8465240704435263
_A3, _B3 = 1 / 2 - _A1 - _A2, 1 - 2 * (_B1 + _B2)

METHODS: dict[str, tuple[tuple[float, ...], tuple[float, ...]]] = {
    "strang": ((1 / 2, 1 / 2), (1.0,)),
    "saba4": (
        (1 / 2 - _OUTER, _OUTER - _INNER, 2 * _INNER, _OUTER - _INNER, 1 / 2 - _OUTER),
        (_SMALL, _LARGE, _LARGE, _SMALL),
    ),
    "aba84": ((_A1, _A2, _A3, _A3, _A2, _A1), (_B1, _B2, _B3, _B2, _B1)),
}
"""The turns and the kicks between them, in parts of a step. For a torque that is small, of relative size ε:

strang: order 2, error ε dt² after a given time. saba4: order 2, error ε dt⁸ + ε² dt², its kicks at the places of
Gauss and Legendre (Laskar and Robutel, Celestial Mechanics and Dynamical Astronomy 80, 39, 2001). aba84: order 4,
error ε dt⁸ + ε² dt⁴ (Blanes, Casas, Farrés, Laskar, Makazaga and Murua, Applied Numerical Mathematics 68, 58,
2013, their ABA(8,4); its last digits here are from the order conditions).
"""


def split(top: Top, state: State, time: ArrayLike, steps: int, method: str = "aba84") -> State:
    """The state after a time [s], of either sign, by equal steps; the method is one of `METHODS`."""
    if method not in METHODS:
        raise ValueError(f"there is no method {method!r}; choose one of {', '.join(METHODS)}")
    if steps < 1:
        raise ValueError(f"{steps} steps lead nowhere; take 1 at least")
    turns, kicks = METHODS[method]
    step = np.asarray(time, dtype=float) / steps
    turning, kicking = step / top.transverse_inertia, step * top.torque
    shape = np.broadcast_shapes(np.shape(turning), np.shape(kicking), state.axis.shape[:-1], state.momentum.shape[:-1])
    axis, momentum = np.broadcast_to(state.axis, (*shape, 3)), np.broadcast_to(state.momentum, (*shape, 3))
    if shape:
        start = [axis[..., i] for i in range(3)] + [momentum[..., i] for i in range(3)]
        end = _run(start, [part * turning for part in turns], [part * kicking for part in kicks], steps, np)
    else:
        # Python's own floats are ten times faster one at a time.
        start = [*axis.tolist(), *momentum.tolist()]
        rate, push = float(turning), float(kicking)
        end = _run(start, [part * rate for part in turns], [part * push for part in kicks], steps, math)
    return State(np.stack(end[:3], axis=-1), np.stack(end[3:], axis=-1))


def _run(start: list[Any], turns: list[Any], kicks: list[Any], steps: int, functions: Any) -> list[Any]:
    """Step along. The turn that ends a step and the one that begins the next are about the same H, so they are one."""
    pairs = list(zip(kicks, [*turns[1:-1], turns[-1] + turns[0]], strict=True))
    x, y, z, hx, hy, hz = start
    x, y, z = _turned(x, y, z, hx, hy, hz, turns[0], functions)
    for _ in range(steps):
        for kick, turn in pairs:
            hx, hy = hx - kick * y, hy + kick * x
            x, y, z = _turned(x, y, z, hx, hy, hz, turn, functions)
    x, y, z = _turned(x, y, z, hx, hy, hz, -turns[0], functions)
    return [x, y, z, hx, hy, hz]


def _turned(x: Any, y: Any, z: Any, hx: Any, hy: Any, hz: Any, turn: Any, functions: Any) -> tuple[Any, Any, Any]:
    """The vector (x, y, z) turned about H by |H| times `turn` (Rodrigues, with half angles for small turns)."""
    size = functions.sqrt(hx * hx + hy * hy + hz * hz) + 1e-300
    nx, ny, nz = hx / size, hy / size, hz / size
    half = size * turn / 2
    sine = functions.sin(half)
    across, along = 2 * sine * functions.cos(half), 2 * sine * sine
    # e + sin α (n × e) + (1 − cos α) n × (n × e)
    cx, cy, cz = ny * z - nz * y, nz * x - nx * z, nx * y - ny * x
    return (
        x + across * cx + along * (ny * cz - nz * cy),
        y + across * cy + along * (nz * cx - nx * cz),
        z + across * cz + along * (nx * cy - ny * cx),
    )


Torque = Callable[[float, Floats, Floats], Sequence[float] | Floats]
"""A torque [N*m], shape (3,), from the time [s], e3 and H in the fixed frame."""


class Path(State, frozen=True, eq=False):
    """The state of one top at a number of times, axis and momentum of shape (n, 3), or (3,) for one time."""

    evaluations: int
    """How often the right-hand side was asked for."""


def integrate(
    top: Top,
    state: State,
    time: ArrayLike,
    *,
    drag: float | Torque = 0.0,
    method: str = "DOP853",
    rtol: float = 1e-9,
    atol: float = 1e-12,
) -> Path:
    """The motion of one top, in the vectors e3 and H, with drag or another torque besides gravity's.

    The times [s] rise from 0, or fall from 0. `drag` is c [N*m*s] of a torque −c ω, the same about every axis, or any
    torque of the time, e3 and H, added to gravity's. Nothing here is stiff. With `rtol` above 1e-6 the answer may be no
    better than eq. (9); `atol` is that of e3, and for H as much of |H| at the start, or of √(I |M|) if that is more.
    """
    from scipy.integrate import solve_ivp

    values = (top.inertia, top.transverse_inertia, top.torque)
    if any(np.ndim(value) for value in values) or np.shape(state.axis) != (3,) or np.shape(state.momentum) != (3,):
        raise ValueError("one top at a time can be integrated; call it for each, or use split or exact")
    if not (callable(drag) or math.isfinite(drag)):
        raise ValueError("the drag is not a finite number")
    times = np.atleast_1d(np.asarray(time, dtype=float))
    steps = np.diff(times, prepend=0.0)
    if not ((steps >= 0).all() or (steps <= 0).all()):
        raise ValueError("the times must rise from 0, or fall from 0")
    start = np.concatenate([state.axis, state.momentum])
    if times[-1] == 0:
        return Path(*_parted(np.tile(start, (len(times), 1)), np.shape(time)), evaluations=0)
    # The integrator takes each time once.
    sense = np.copysign(1.0, times[-1])
    distinct, again = np.unique(sense * times, return_inverse=True)
    size = max(float(np.linalg.norm(state.momentum)), float(np.sqrt(abs(top.torque) * top.transverse_inertia)))
    done = solve_ivp(
        _rates(top, drag),
        (0.0, times[-1]),
        start,
        method=method,
        t_eval=sense * distinct,
        rtol=rtol,
        atol=[atol] * 3 + [atol * size] * 3,
    )
    if not done.success:
        raise ValueError(f"the integrator gave up: {done.message}")
    return Path(*_parted(done.y.T[again], np.shape(time)), evaluations=done.nfev)


def _parted(values: Floats, shape: tuple[int, ...]) -> tuple[Floats, Floats]:
    """e3 and H out of rows of six, in the shape of the times asked for."""
    return values[:, :3].reshape(*shape, 3), values[:, 3:].reshape(*shape, 3)


def _rates(top: Top, drag: float | Torque) -> Callable[[float, Floats], list[float]]:
    """How fast e3 and H change, as a function of time and the two in a row."""
    transverse, weight = float(top.transverse_inertia), float(top.torque)
    extra = drag if callable(drag) else None
    # ω = H/I + (1/I_zz − 1/I)(H·e3) e3.
    slowing = 0.0 if callable(drag) else drag / transverse
    along = 0.0 if callable(drag) else drag / float(top.inertia) - slowing

    def rates(time: float, row: Floats) -> list[float]:
        x, y, z, hx, hy, hz = row.tolist()
        spin = along * (hx * x + hy * y + hz * z)
        torque_x = -weight * y - slowing * hx - spin * x
        torque_y = weight * x - slowing * hy - spin * y
        torque_z = -slowing * hz - spin * z
        if extra is not None:
            more = extra(time, row[:3], row[3:])
            # A step to nowhere would be halved for ever.
            if not all(map(math.isfinite, more)):
                raise ValueError(f"the torque at {time} s is not a finite number")
            torque_x, torque_y, torque_z = torque_x + more[0], torque_y + more[1], torque_z + more[2]
        turned = ((hy * z - hz * y) / transverse, (hz * x - hx * z) / transverse, (hx * y - hy * x) / transverse)
        return [*turned, torque_x, torque_y, torque_z]

    return rates
