"""A top with a fixed point, and its motion in steps: by geometric splitting, or by a general integrator.

Splitting alternates two exact motions: without torque H is constant and e3 turns about it at |H|/I; without rotation H
grows by dt M Z × e3. So |e3|, H·Z and H·e3 are constant to rounding, and the energy does not drift for any step (a
Lie–Poisson integrator). Use at least four steps per nutation: with fewer steps the answer is wrong, without a warning.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from msgspec import Struct
from numpy.typing import ArrayLike

from gyrodata.physics import Floats, precession_rate


class Top(Struct, frozen=True, eq=False):
    """A symmetric body with one fixed point and a torque from gravity; arrays describe many tops and are broadcast."""

    inertia: Any
    """I_zz, the moment of inertia about the rod [kg*m^2], above 0."""
    transverse_inertia: Any
    """I about an axis across the rod through the fixed point [kg*m^2], above 0; may be below or equal to I_zz."""
    torque: Any
    """h m g, the torque with the rod horizontal [N*m]; negative for a weight on the other side of the centre."""

    def __post_init__(self) -> None:
        for name in ("inertia", "transverse_inertia", "torque"):
            values = np.asarray(getattr(self, name), dtype=float)
            if not np.isfinite(values).all():
                raise ValueError(f"{name} is not a finite number")
            if name != "torque" and not (values > 0).all():
                raise ValueError(f"{name} must be above 0")


class State(Struct, frozen=True, eq=False):
    """Direction of the rod and angular momentum.

    The angle of the spin is not included, because nothing depends on it. Euler angles would fail at the vertical.
    """

    axis: Floats
    """e3, the unit vector along the rod, in the fixed frame X, Y, Z with Z upwards [1]; shape (..., 3)."""
    momentum: Floats
    """H, the angular momentum about the fixed point, in the fixed frame [kg*m^2/s]; shape (..., 3)."""


def steady(top: Top, spin: ArrayLike, pitch: ArrayLike = 0.0) -> State:
    """Return the state in steady slow precession, eq. (8), at azimuth 0.

    Raises
    ------
    ValueError
        If there is no steady precession: the rod points upwards and the spin is too low.
    """
    rate = precession_rate(top.torque, spin, top.inertia, top.transverse_inertia, pitch)
    if not np.isfinite(rate).all():
        raise ValueError("no steady precession exists at this spin and pitch; use a faster spin or a lower rod")
    # ω3 = ψ̇ + φ̇ cosθ, eq. (2); H = I (Ω − Ω3 e3) + I_zz ω3 e3, eq. (3).
    along = rate * np.sin(pitch)
    about_rod = np.multiply(top.inertia, spin + along) - np.multiply(top.transverse_inertia, along)
    state = _along_axis(about_rod, pitch, np.shape(rate))
    state.momentum[..., 2] += np.multiply(top.transverse_inertia, rate)
    return state


def released(top: Top, spin: ArrayLike, pitch: ArrayLike = 0.0) -> State:
    """Return the state of a rod at rest at azimuth 0, with the ball spinning, when the rod is released."""
    momentum = np.multiply(top.inertia, spin)
    return _along_axis(momentum, pitch, np.broadcast_shapes(np.shape(momentum), np.shape(pitch), np.shape(top.torque)))


def _along_axis(momentum: ArrayLike, pitch: ArrayLike, shape: tuple[int, ...]) -> State:
    """Return the state at azimuth 0 with all angular momentum along the rod, with vectors of shape (*shape, 3)."""
    axis = np.zeros((*shape, 3))
    axis[..., 0], axis[..., 2] = np.cos(pitch), np.sin(pitch)
    return State(axis, np.asarray(momentum)[..., None] * axis)


# --- in steps ---------------------------------------------------------------------------------------------------

_A1, _A2, _B1, _B2 = 0.07534696026989289, 0.5179168546882568, 0.19022593937367662, 0.8465240704435263
_A3, _B3 = 1 / 2 - _A1 - _A2, 1 - 2 * (_B1 + _B2)

METHODS: dict[str, tuple[tuple[float, ...], tuple[float, ...]]] = {
    "strang": ((1 / 2, 1 / 2), (1.0,)),
    "aba84": ((_A1, _A2, _A3, _A3, _A2, _A1), (_B1, _B2, _B3, _B2, _B1)),
}
"""The turns and the kicks between them, in parts of a step. For a small torque of relative size ε:

strang: order 2, error ε dt² after a given time. aba84: order 4, error ε dt⁸ + ε² dt⁴ (ABA(8,4) of Blanes, Casas,
Farrés, Laskar, Makazaga and Murua, Applied Numerical Mathematics 68, 58, 2013; the last digits follow from the order
conditions).
"""


def split(top: Top, state: State, time: float, steps: int, method: str = "aba84") -> State:
    """Compute the state of one top after a time [s], of either sign, by equal steps; the method is one of `METHODS`."""
    step = time / steps
    turns = [float(part * step / top.transverse_inertia) for part in METHODS[method][0]]
    kicks = [float(part * step * top.torque) for part in METHODS[method][1]]
    # The last turn of a step and the first turn of the next one are about the same H, so they are combined.
    pairs = list(zip(kicks, [*turns[1:-1], turns[-1] + turns[0]], strict=True))
    # Python's floats are ten times faster than arrays of three numbers.
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


def integrate(
    top: Top, state: State, time: ArrayLike, *, method: str = "DOP853", rtol: float = 1e-9, atol: float = 1e-12
) -> tuple[State, int]:
    """Integrate the motion of one top under gravity, in the vectors e3 and H.

    Parameters
    ----------
    top : Top
    state : State
        At time 0.
    time : array_like, shape (n,)
        Times that rise from 0 [s].
    method : str
        A method of `scipy.integrate.solve_ivp`; the equations are not stiff.
    rtol, atol : float
        Tolerances; `atol` is for e3, and for H it is relative to |H| at the start, or to √(I |M|) if this is larger.
        With `rtol` above 1e-6 the answer can be worse than eq. (9).

    Returns
    -------
    State
        With vectors of shape (n, 3).
    int
        The number of evaluations of the right-hand side.

    Raises
    ------
    ValueError
        If the times do not rise from 0, or if the integration fails.
    """
    from scipy.integrate import solve_ivp

    times = np.asarray(time, dtype=float)
    rates = vector_rates(top)
    size = max(float(np.linalg.norm(state.momentum)), math.sqrt(abs(top.torque) * top.transverse_inertia))
    done = solve_ivp(
        # Python's floats are ten times faster here than arrays.
        lambda _, row: rates(*row.tolist()),
        (0.0, times[-1]),
        np.concatenate([state.axis, state.momentum]),
        method=method,
        t_eval=times,
        rtol=rtol,
        atol=atol * np.repeat([1.0, size], 3),
    )
    if not done.success:
        raise ValueError(f"the integration failed: {done.message}")
    return State(done.y[:3].T, done.y[3:].T), done.nfev


Rates = Callable[[Any, Any, Any, Any, Any, Any], tuple[Any, Any, Any, Any, Any, Any]]
"""Time derivatives of e3 and H as a function of their components."""


def vector_rates(top: Top, drag: ArrayLike = 0.0, pace: ArrayLike = 1.0) -> Rates:
    """Return the right-hand side by components, floats or arrays, with linear drag; times are divided by `pace`."""
    drag, inertia, across = np.multiply(drag, pace), np.asarray(top.inertia), np.asarray(top.transverse_inertia)
    # ω = H/I + (1/I_zz − 1/I)(H·e3) e3.
    fields = across / pace, np.multiply(top.torque, pace), drag / across, drag * (1 / inertia - 1 / across)
    # 0-d arrays are slower than Python's floats.
    transverse, weight, slowing, along = (float(value) if np.ndim(value) == 0 else value for value in fields)

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
