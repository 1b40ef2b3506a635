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
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from gyrodata.motion.orbits import State, Top
from gyrodata.physics import Floats

if TYPE_CHECKING:
    from scipy.integrate import OdeSolver

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
    x, y, z = turned(x, y, z, hx, hy, hz, turns[0], functions)
    for _ in range(steps):
        for kick, turn in pairs:
            hx, hy = hx - kick * y, hy + kick * x
            x, y, z = turned(x, y, z, hx, hy, hz, turn, functions)
    x, y, z = turned(x, y, z, hx, hy, hz, -turns[0], functions)
    return [x, y, z, hx, hy, hz]


def turned(x: Any, y: Any, z: Any, hx: Any, hy: Any, hz: Any, turn: Any, functions: Any) -> tuple[Any, Any, Any]:
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
    """The state of one top at a number of times, axis and momentum of shape (n, 3), or (3,) for one time.

    For a stack of tops it is the state of each at its time, of shape (*stack, 3).
    """

    evaluations: int
    """How often the right-hand side was asked for, once for all of a stack."""


def integrate(
    top: Top,
    state: State,
    time: ArrayLike,
    *,
    drag: ArrayLike | Torque = 0.0,
    method: str | type[OdeSolver] = "DOP853",
    rtol: float = 1e-9,
    atol: float = 1e-12,
) -> Path:
    """The motion of one top, or of a stack, in the vectors e3 and H, with drag or another torque besides gravity's.

    The times [s] of one top rise from 0, or fall from 0; a stack takes one time, or one for each top. `drag` is
    c [N*m*s] of a torque −c ω, the same about every axis, or for one top any torque of the time, e3 and H, added to
    gravity's. `method` is one that `scipy.integrate.solve_ivp` takes; nothing here is stiff. With `rtol` above 1e-6 the
    answer may be no better than eq. (9); `atol` is that of e3, and for H as much of |H| at the start, or of √(I |M|)
    if that is more. A stack takes as many steps as its busiest top, each in parts of its own time, and the tolerances
    hold for the root mean square of the stack; Radau, BDF and LSODA solve equations as large as the stack.
    """
    if not (callable(drag) or np.isfinite(drag).all()):
        raise ValueError("the drag is not a finite number")
    numbers = (top.inertia, top.transverse_inertia, top.torque, drag)
    vectors = (state.axis, state.momentum)
    stack = np.broadcast_shapes(*map(np.shape, numbers), *(np.shape(vector)[:-1] for vector in vectors))
    times = np.asarray(time, dtype=float)
    if stack:
        if callable(drag):
            raise ValueError("a torque of your own takes one top at a time; call it for each")
        if times.shape not in ((), stack):
            raise ValueError("a stack of tops takes one time, or one for each top")
        # Each top goes through its own time, and all arrive at once.
        rates, ends = vector_rates(top, drag, np.broadcast_to(times, stack)), np.ones(1)
    else:
        steps = np.diff(np.atleast_1d(times), prepend=0.0)
        if not ((steps >= 0).all() or (steps <= 0).all()):
            raise ValueError("the times must rise from 0, or fall from 0")
        rates, ends = vector_rates(top, drag), np.atleast_1d(times)
    start = np.stack([np.broadcast_to(vector, (*stack, 3))[..., i] for vector in vectors for i in range(3)])
    if not times.any():
        return Path(*_parted(np.repeat(start[..., None], ends.size, axis=-1), stack or times.shape), evaluations=0)
    # The integrator takes each time once.
    sense = np.copysign(1.0, ends[-1])
    distinct, again = np.unique(sense * ends, return_inverse=True)
    size = np.linalg.norm(state.momentum, axis=-1)
    size = np.maximum(size, np.sqrt(np.abs(top.torque) * np.asarray(top.transverse_inertia)))
    scales = np.stack([np.broadcast_to(part, stack) for part in (1.0, 1.0, 1.0, size, size, size)])
    values, evaluations = _solved(rates, start, sense * distinct, drag, method, rtol, atol * scales)
    return Path(*_parted(values[..., again], stack or times.shape), evaluations=evaluations)


def _solved(
    rates: Rates,
    start: Floats,
    times: Floats,
    drag: ArrayLike | Torque,
    method: str | type[OdeSolver],
    rtol: float,
    atol: Floats,
) -> tuple[Floats, int]:
    """The six components at the times, their shape and then that of the times, and the count of evaluations."""
    from scipy.integrate import solve_ivp

    stacked = start.ndim > 1

    def alone(time: float, row: Floats) -> list[float]:
        # Python's own floats are ten times faster one at a time.
        change = rates(*row.tolist())
        if not callable(drag):
            return list(change)
        more = drag(time, row[:3], row[3:])
        # A step to nowhere would be halved for ever.
        if not all(map(math.isfinite, more)):
            raise ValueError(f"the torque at {time} s is not a finite number")
        return [*change[:3], *(own + other for own, other in zip(change[3:], more, strict=True))]

    def together(_: float, row: Floats) -> Floats:
        return np.array(rates(*row.reshape(start.shape))).ravel()

    done = solve_ivp(
        together if stacked else alone,
        (0.0, times[-1]),
        start.ravel(),
        method=method,
        t_eval=times,
        rtol=rtol,
        atol=atol.ravel(),
    )
    if not done.success:
        raise ValueError(f"the integrator gave up: {done.message}")
    return done.y.reshape(*start.shape, times.size), done.nfev


def _parted(values: Floats, shape: tuple[int, ...]) -> tuple[Floats, Floats]:
    """e3 and H out of six components, in the shape of the stack or of the times asked for."""
    rows = np.moveaxis(values, 0, -1).reshape(*shape, 6)
    return rows[..., :3], rows[..., 3:]


Rates = Callable[[Any, Any, Any, Any, Any, Any], tuple[Any, Any, Any, Any, Any, Any]]
"""How fast e3 and H change, as a function of their components."""


def vector_rates(top: Top, drag: ArrayLike | Torque = 0.0, pace: ArrayLike = 1.0) -> Rates:
    """The right-hand side by components, floats or arrays: gravity and linear drag, in a time `pace` times as fast."""

    def plain(value: ArrayLike) -> Any:
        return np.asarray(value, dtype=float)[()] if np.ndim(value) else float(value)  # type: ignore[arg-type]

    with np.errstate(divide="ignore"):
        transverse, weight = plain(top.transverse_inertia / np.asarray(pace)), plain(np.multiply(top.torque, pace))
    # ω = H/I + (1/I_zz − 1/I)(H·e3) e3.
    linear = 0.0 if callable(drag) else np.multiply(drag, pace)
    slowing = plain(linear / np.asarray(top.transverse_inertia))
    along = plain(linear / np.asarray(top.inertia) - slowing)
    free = not np.any(linear)

    def rates(x: Any, y: Any, z: Any, hx: Any, hy: Any, hz: Any) -> tuple[Any, Any, Any, Any, Any, Any]:
        turned = ((hy * z - hz * y) / transverse, (hz * x - hx * z) / transverse, (hx * y - hy * x) / transverse)
        if free:
            return (*turned, -weight * y, weight * x, 0.0 * z)
        spin = along * (hx * x + hy * y + hz * z)
        return (
            *turned,
            -weight * y - slowing * hx - spin * x,
            weight * x - slowing * hy - spin * y,
            -slowing * hz - spin * z,
        )

    return rates
