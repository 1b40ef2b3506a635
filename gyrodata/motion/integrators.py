"""The motion by a general integrator, for what has no closed form: drag, and any other torque."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from gyrodata.motion.states import State, Top
from gyrodata.physics import Floats

Torque = Callable[[float, Floats, Floats], Sequence[float] | Floats]
"""A torque [N*m], shape (3,), from the time [s], e3 and H in the fixed frame."""


@dataclass(frozen=True, eq=False)
class Path(State):
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

    Parameters
    ----------
    top : Top
        One top: three numbers.
    state : State
        At time 0; shapes (3,).
    time : array_like
        When the state is wanted [s]: one time, or several that rise from 0 or fall from 0.
    drag : float or callable
        c [N*m*s] of the torque −c ω of an air film, the same about every axis; or any torque of the time, e3 and H,
        added to gravity's.
    method : str
        A method of `scipy.integrate.solve_ivp`. Nothing here is stiff.
    rtol : float
        Relative tolerance of a step [1]. Above 1e-6 the answer may be no better than eq. (9).
    atol : float
        Absolute tolerance of e3 [1]; that of H is as much of |H| at the start, or of √(I |M|) if that is more.

    Returns
    -------
    Path

    Raises
    ------
    ValueError
        If there is more than one top, the times do not rise or fall from 0, a torque or the drag is not a finite
        number, or the integrator gives up.
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
