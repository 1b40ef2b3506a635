"""Geometric splitting: exact turns of the rod about H, and kicks of H by the torque, one after the other.

The energy is that of the free body plus the potential. Each alone is solved exactly: without torque H is fixed and
e3 turns about it at |H|/I; without motion H grows by dt M Z × e3. So |e3|, H·Z and H·e3 stay what they are to
rounding, and the energy does not drift, whatever the step (a Lie–Poisson integrator). Take four steps a nutation
at least: with fewer the answer is wrong without any sign of it.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gyrodata.motion.states import State, Top

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
    """The state after a time, by equal steps.

    Parameters
    ----------
    top : Top
    state : State
        At time 0.
    time : array_like
        [s], of either sign, broadcast with `top` and `state`.
    steps : int
        Number of steps from 0 to `time`.
    method : str
        "strang", "saba4" or "aba84": see `METHODS`.

    Returns
    -------
    State

    Raises
    ------
    ValueError
        If the method is none of these, or there is no step to take.
    """
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
