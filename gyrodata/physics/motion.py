"""The complete motion of the top, eqs. (7), and of a rod released from rest.

Splitting alternates two exact motions: without torque H is constant and e3 turns about
it at |H|/I; without rotation H grows by dt M Z × e3. So |e3|, H·Z and H·e3 are constant
to rounding, and the energy does not drift for any step (a Lie–Poisson integrator). Use
at least four steps per nutation: with fewer steps the answer is wrong, without a
warning.

A rod that is released from rest nods between its start and a turning point. All
constants are divided by I. If the torque is negative, the frame is turned upside down,
so that β = |M|/I is never negative. With a = H·e3/I, u0 = cosθ at the start and the
depth w = u0 − cosθ, which is 0 at the start and w1 at the turning point,

    ẇ² = 2β w (w1 − w)(w + w3),    φ̇ = a w/((1 − u0 + w)(1 + u0 − w)),

in which every factor is a sum of positive terms. With w = w1/(1 + e^−x) the nutation
from the start to the turning point is −∞ < x < ∞. The integrands in x have no
singularity within π of the real axis and decrease exponentially, so that the
trapezoidal rule has an error near the last digit also for rods close to the vertical
(Trefethen & Weideman, SIAM Review 56, 385, 2014).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import ArrayLike

from gyrodata.physics import Floats, precession_rate


class Top(Struct, frozen=True, eq=False, kw_only=True):
    """A symmetric body with one fixed point and a torque from gravity.

    Arrays describe many tops and are broadcast.
    """

    inertia: Any
    """I_zz, the moment of inertia about the rod [kg*m^2], above 0."""
    transverse_inertia: Any
    """I about an axis across the rod through the fixed point [kg*m^2], above 0; may be
    below or equal to I_zz."""
    torque: Any
    """h m g, the torque with the rod horizontal [N*m]; negative for a weight on the
    other side of the centre."""

    def __post_init__(self) -> None:
        for name in ("inertia", "transverse_inertia", "torque"):
            values = np.asarray(getattr(self, name), dtype=float)
            if not np.isfinite(values).all():
                raise ValueError(f"{name} is not a finite number")
            if name != "torque" and not (values > 0).all():
                raise ValueError(f"{name} must be above 0")


class State(Struct, frozen=True, eq=False):
    """Direction of the rod and angular momentum.

    The angle of the spin is not included, because nothing depends on it. Euler angles
    would fail at the vertical.
    """

    axis: Floats
    """e3, the unit vector along the rod, in the fixed frame X, Y, Z with Z upwards [1];
    shape (..., 3)."""
    momentum: Floats
    """H, the angular momentum about the fixed point, in the fixed frame [kg*m^2/s];
    shape (..., 3)."""


def steady(top: Top, spin: ArrayLike, pitch: ArrayLike = 0.0) -> State:
    """Return the state in steady slow precession, eq. (8), at azimuth 0.

    Raises
    ------
    ValueError
        If there is no steady precession: the rod points upwards and the spin is too
        low.
    """
    across = top.transverse_inertia
    rate = precession_rate(top.torque, spin, top.inertia, across, pitch)
    if not np.isfinite(rate).all():
        raise ValueError(
            "no steady precession exists at this spin and pitch; "
            "use a faster spin or a lower rod"
        )
    # ω3 = ψ̇ + φ̇ cosθ, eq. (2); H = I (Ω − Ω3 e3) + I_zz ω3 e3, eq. (3).
    height = np.sin(pitch)
    along = rate * height
    of_total_spin = np.multiply(top.inertia, spin + along)
    of_precession = np.multiply(across, along)
    about_rod = of_total_spin - of_precession
    state = _along_axis(about_rod, pitch, np.shape(rate))
    state.momentum[..., 2] += np.multiply(across, rate)
    return state


def released(top: Top, spin: ArrayLike, pitch: ArrayLike = 0.0) -> State:
    """Return the state of a rod at rest at azimuth 0 when it is released.

    The ball is spinning.
    """
    momentum = np.multiply(top.inertia, spin)
    shape = np.broadcast(momentum, pitch, top.torque).shape
    return _along_axis(momentum, pitch, shape)


def _along_axis(momentum: ArrayLike, pitch: ArrayLike, shape: tuple[int, ...]) -> State:
    """Return the state at azimuth 0 with all angular momentum along the rod.

    The vectors have the shape (*shape, 3).
    """
    axis = np.zeros((*shape, 3))
    axis[..., 0] = np.cos(pitch)
    axis[..., 2] = np.sin(pitch)
    size = np.asarray(momentum)[..., None]
    return State(axis, size * axis)


# --- in steps ---

_A1 = 0.07534696026989289
_A2 = 0.5179168546882568
_B1 = 0.19022593937367662
_B2 = 0.8465240704435263
_A3 = 1 / 2 - _A1 - _A2
_B3 = 1 - 2 * (_B1 + _B2)

_STRANG = (1 / 2, 1 / 2), (1.0,)
_ABA84 = (_A1, _A2, _A3, _A3, _A2, _A1), (_B1, _B2, _B3, _B2, _B1)

METHODS: dict[str, tuple[tuple[float, ...], tuple[float, ...]]] = {
    "strang": _STRANG,
    "aba84": _ABA84,
}
"""The turns and the kicks between them, in parts of a step. For a small torque of
relative size ε:

strang: order 2, error ε dt² after a given time. aba84: order 4, error ε dt⁸ + ε² dt⁴
(ABA(8,4) of Blanes, Casas, Farrés, Laskar, Makazaga and Murua, Applied Numerical
Mathematics 68, 58, 2013; the last digits follow from the order conditions). """


def split(
    top: Top, state: State, time: float, steps: int, method: str = "aba84"
) -> State:
    """Compute the state of one top after a time [s], of either sign, by equal steps.

    The method is one of `METHODS`.
    """
    step = time / steps
    turn_parts, kick_parts = METHODS[method]
    turns = [float(part * step / top.transverse_inertia) for part in turn_parts]
    kicks = [float(part * step * top.torque) for part in kick_parts]
    # The last turn of a step and the first turn of the next one are about the same H,
    # so they are combined.
    after_kicks = [*turns[1:-1], turns[-1] + turns[0]]
    pairs = list(zip(kicks, after_kicks, strict=True))
    # Python's floats are ten times faster than arrays of three numbers.
    hx, hy, hz = state.momentum.tolist()
    axis = _turned(state.axis.tolist(), (hx, hy, hz), turns[0])
    for _ in range(steps):
        for kick, turn in pairs:
            hx = hx - kick * axis[1]
            hy = hy + kick * axis[0]
            axis = _turned(axis, (hx, hy, hz), turn)
    axis = _turned(axis, (hx, hy, hz), -turns[0])
    return State(np.array(axis), np.array([hx, hy, hz]))


def _turned(
    axis: Sequence[float], momentum: Sequence[float], turn: float
) -> tuple[float, float, float]:
    """Turn e3 about H by |H| times `turn`.

    The formula is that of Rodrigues, with half angles for small turns.
    """
    x, y, z = axis
    hx, hy, hz = momentum
    size = math.sqrt(hx * hx + hy * hy + hz * hz) + 1e-300
    nx = hx / size
    ny = hy / size
    nz = hz / size
    angle = size * turn
    half = angle / 2
    sine = math.sin(half)
    across = 2 * sine * math.cos(half)
    along = 2 * sine * sine
    # e + sin α (n × e) + (1 − cos α) n × (n × e)
    cx = ny * z - nz * y
    cy = nz * x - nx * z
    cz = nx * y - ny * x
    turned_x = x + across * cx + along * (ny * cz - nz * cy)
    turned_y = y + across * cy + along * (nz * cx - nx * cz)
    turned_z = z + across * cz + along * (nx * cy - ny * cx)
    return turned_x, turned_y, turned_z


def integrate(
    top: Top,
    state: State,
    time: ArrayLike,
    *,
    method: str = "DOP853",
    rtol: float = 1e-9,
    atol: float = 1e-12,
) -> tuple[State, int]:
    """Integrate the motion of one top under gravity, in the vectors e3 and H.

    Parameters
    ----------
    top : Top
    state : State
        At time 0.
    time : array_like, shape (n,)
        Times that rise from 0 [s], finite.
    method : str
        A method of `scipy.integrate.solve_ivp`; the equations are not stiff.
    rtol, atol : float
        Tolerances; `atol` is for e3, and for H it is relative to |H| at the start, or
        to √(I |M|) if this is larger. A rod without spin and torque stays at rest. With
        `rtol` above 1e-6 the answer can be worse than eq. (9).

    Returns
    -------
    State
        With vectors of shape (n, 3).
    int
        The number of evaluations of the right-hand side.

    Raises
    ------
    ValueError
        If the times are not finite or do not rise from 0, or if the integration fails.
    """
    from scipy.integrate import solve_ivp

    times = np.asarray(time, dtype=float)
    steps = np.diff(times, prepend=0.0)
    if not times.size or not (np.isfinite(times) & (steps >= 0)).all():
        raise ValueError(
            "the times must be finite and rise from 0; give them in seconds"
        )
    rates = vector_rates(top)
    of_spin = float(np.linalg.norm(state.momentum))
    of_torque = math.sqrt(abs(top.torque) * top.transverse_inertia)
    # An error is compared with this size, so that it must not be 0.
    size = max(of_spin, of_torque, _SPECK)
    solution = solve_ivp(
        # Python's floats are ten times faster here than arrays.
        lambda _, row: rates(row.tolist()),
        (0.0, times[-1]),
        np.concatenate([state.axis, state.momentum]),
        method=method,
        t_eval=times,
        rtol=rtol,
        atol=atol * np.repeat([1.0, size], 3),
    )
    if not solution.success:
        raise ValueError(f"the integration failed: {solution.message}")
    return State(solution.y[:3].T, solution.y[3:].T), solution.nfev


Rates = Callable[[Iterable[Any]], tuple[Any, ...]]
"""The time derivatives of the six components of e3 and H, as a function of these."""


def vector_rates(
    top: Top, drag: Floats | float = 0.0, pace: Floats | float = 1.0
) -> Rates:
    """Return the right-hand side by components, floats or arrays, with linear drag.

    Times are divided by `pace`.
    """
    transverse = top.transverse_inertia / pace
    weight = top.torque * pace
    slowing = drag * pace / top.transverse_inertia
    # ω = H/I + (1/I_zz − 1/I)(H·e3) e3.
    difference = 1 / top.inertia - 1 / top.transverse_inertia
    along = drag * pace * difference

    def rates(components: Iterable[Any]) -> tuple[Any, ...]:
        x, y, z, hx, hy, hz = components
        spin = along * (hx * x + hy * y + hz * z)
        rate_x = (hy * z - hz * y) / transverse
        rate_y = (hz * x - hx * z) / transverse
        rate_z = (hx * y - hy * x) / transverse
        rate_hx = -weight * y - slowing * hx - spin * x
        rate_hy = weight * x - slowing * hy - spin * y
        rate_hz = -slowing * hz - spin * z
        return rate_x, rate_y, rate_z, rate_hx, rate_hy, rate_hz

    return rates


# --- a rod that is released from rest ---

_STEP = 0.3
_X = np.arange(-260, 261) * _STEP
"""The points of the integrals."""

_MANY = 1000
"""Number of rods whose integrals are computed at once."""

CONVERGED = 1e-8
"""After a relative step below this, the next one is below 1e-11 [1]."""

_TINY = 1e-300
_SPECK = 1e-60
"""A divisor instead of 0, and the smallest β [rad²/s²] and a [rad/s] that count."""


class _Nod(Struct, frozen=True, eq=False):
    """The constants of the motion, and the integrands at `_X`.

    The constants have the shape (..., 1), and the integrands have the shape (..., n).
    """

    flip: Any
    """+1, or −1 if the frame is upside down [1]."""
    about_rod: Any
    """a [rad/s]"""
    depth: Any
    """w1 [1]"""
    upper: Any
    """1 − u0 [1]"""
    lower: Any
    """1 + cosθ at the turning point [1]"""
    weight: Any
    """Time that belongs to each point [s]: dt/dx times the step."""

    def sunk(self, x: Any) -> Any:
        """Compute the depth w [1] at x."""
        return self.depth / (1 + np.exp(-x))

    def poles(self, x: Any) -> tuple[Any, Any]:
        """Compute 1 − cosθ and 1 + cosθ [1] at x, without cancellation."""
        above_turning_point = self.depth / (1 + np.exp(x))
        return self.upper + self.sunk(x), self.lower + above_turning_point

    def rate(self, x: Any) -> Any:
        """Compute φ̇ in the frame [rad/s] at x; it grows with the depth."""
        upper, lower = self.poles(x)
        return self.about_rod * self.sunk(x) / (upper * lower)

    def excess(self) -> Any:
        """Compute the mean of φ̇ cosθ over one nutation [rad/s], shape (...)."""
        upper, _ = self.poles(_X)
        level = self.rate(_X) * (1 - upper)
        return self.mean(level)

    def mean(self, values: Any) -> Any:
        """Compute the mean over one nutation of values at `_X`, shape (...)."""
        weighted = values * self.weight
        duration = self.weight.sum(axis=-1)
        return weighted.sum(axis=-1) / duration

    def swept(self, x: Any) -> tuple[Any, Any]:
        """Compute the time [s] and the azimuth in the frame [rad] from the start to x.

        The argument x is an array of shape (..., 1).

        These are the integrals of the cardinal series through the points.
        """
        from scipy.special import sici

        sine_integral, _ = sici(np.pi / _STEP * (x - _X))
        part = self.weight * (0.5 + sine_integral / np.pi)
        angle = part * self.rate(_X)
        return part.sum(axis=-1, keepdims=True), angle.sum(axis=-1, keepdims=True)


def _nod(top: Top, spin: ArrayLike, pitch: ArrayLike) -> _Nod:
    """Compute the constants and the integrands; all arguments are broadcast."""
    arguments = top.inertia, top.transverse_inertia, top.torque, spin, pitch
    columns = np.array(np.broadcast_arrays(*arguments), dtype=float)[..., None]
    inertia, across, torque, spin, pitch = columns
    flip = np.copysign(1.0, torque)
    rates = np.array([2 * np.abs(torque), inertia * spin]) / across
    # Rates below _SPECK are 0, so that squares do not underflow.
    is_speck = np.abs(rates) < _SPECK
    pull, about_rod = np.where(is_speck, 0.0, rates)
    height = flip * np.sin(pitch)
    level = np.cos(pitch)
    level2 = level**2
    # 1 − u0 as sin²θ/(1 + u0) does not lose digits near the vertical.
    near_vertical = level2 / (1 + np.abs(height))
    upper = np.where(height > 0, near_vertical, 1 - height)
    upper = np.maximum(upper, _TINY)
    # w1 and −w3 are the roots of 2β w² + 2 half w − 2β sin²θ.
    half = about_rod**2 / 2 - pull * height
    root = np.hypot(half, pull * np.sqrt(level2))
    half_size = np.abs(half)
    large = half_size + root
    with np.errstate(divide="ignore", invalid="ignore"):
        far = np.where(half > 0, large, pull**2 * level2 / large)
        depth = np.where(half > 0, pull * level2 / large, large / pull)
    far = np.fmax(far, _TINY)
    depth = np.where(pull > 0, depth, 0.0)
    lower = about_rod**2 * level2 / (far * (upper + depth))
    lower = np.maximum(lower, _TINY)
    nod = _Nod(flip, about_rod, depth, upper, lower, None)
    speed = np.sqrt(far + pull * nod.sunk(_X))
    weight = _STEP / (2 * np.cosh(_X / 2) * speed)
    return replace(nod, weight=weight)


def mean_precession_rate(top: Top, spin: ArrayLike, pitch: ArrayLike = 0.0) -> Any:
    """Compute the mean rate of precession [rad/s].

    It is the azimuth that is swept in one nutation, over the period of the nutation.
    """
    fields = np.broadcast_arrays(
        top.inertia, top.transverse_inertia, top.torque, spin, pitch
    )
    if fields[0].ndim and len(fields[0]) > _MANY:
        # In parts, because the integrands of all runs would need much memory.
        rates = []
        for start in range(0, len(fields[0]), _MANY):
            part = [values[start : start + _MANY] for values in fields]
            inertia, transverse_inertia, torque, *motion = part
            tops = Top(
                inertia=inertia, transverse_inertia=transverse_inertia, torque=torque
            )
            rates.append(mean_precession_rate(tops, *motion))
        return np.concatenate(rates)
    nod = _nod(top, spin, pitch)
    mean = nod.mean(nod.rate(_X))
    return nod.flip[..., 0] * mean


def spin_excess(top: Top, spin: ArrayLike, pitch: ArrayLike = 0.0) -> Any:
    """Compute the mean of φ̇ cosθ of rods that are released from rest [rad/s].

    It is their total spin minus the mean of ψ̇.

    It is negative if the rod sags.
    """
    return _nod(top, spin, pitch).excess()


def total_spin(top: Top, spin: ArrayLike, pitch: ArrayLike = 0.0) -> Any:
    """Compute the total spin of rods that are released from rest [rad/s].

    It is conserved. It is computed from the mean of ψ̇ > 0.
    """
    # Secant steps of the excess as a function of the total spin; the first slope is 0.
    total = np.asarray(spin, dtype=float)
    slope = before = previous = np.zeros_like(total)
    for turn in range(6):
        excess = spin_excess(top, total, pitch)
        if turn:
            moved = total - previous
            rise = excess - before
            slope = np.divide(rise, moved, out=np.zeros_like(rise), where=moved != 0)
        safe_slope = np.clip(slope, 0.0, 0.9)
        step = (spin + excess - total) / (1 - safe_slope)
        before = excess
        previous = total
        # A rod that falls far has no such motion; half of the spin is a limit for the
        # steps.
        total = np.maximum(total + step, np.multiply(0.5, spin))
        relative_step = np.abs(step) / total
        if np.max(relative_step) < CONVERGED:
            break
    return total


class Nutation(Struct, frozen=True):
    """The nutation of a rod that is released from rest."""

    period: float
    """Time from one moment of rest to the next [s]."""
    mean_sag: float
    """Mean angle below the start [rad]; negative if the rod rises."""
    greatest_sag: float
    """Largest angle below the start [rad]."""
    sideways: float
    """Mean of φ̇ sinθ, the sideways rate of the rod's direction [rad/s]."""
    lead: float
    """Largest time by which the azimuth is before or after uniform precession [s]; NaN
    without precession."""


def nutation(top: Top, spin: float, pitch: float = 0.0) -> Nutation:
    """Compute the nutation of a rod released from rest, to about 1e-11."""
    nod = _nod(top, spin, pitch)
    share = nod.weight / nod.weight.sum()
    rates = nod.rate(_X)
    mean = float(share @ rates)

    def sag(x: Any) -> Any:
        """Compute the angle from the start, by half angles without cancellation."""
        upper, lower = nod.poles(x)
        upper0, lower0 = nod.poles(_X[0])
        sum_sine = np.sqrt(upper * lower0) + np.sqrt(lower * upper0)
        sine = 2 * nod.sunk(x) / sum_sine
        cosine = np.sqrt(lower * lower0) + np.sqrt(upper * upper0)
        return 2 * np.arctan2(sine, cosine)

    # The azimuth is farthest from uniform precession at the moment at which the rate is
    # the mean one.
    x = find_crossing(lambda x: np.abs(nod.rate(x)) - abs(mean), _X[:1], _X[-1:])
    time, azimuth = nod.swept(x)
    across = np.sqrt(np.multiply(*nod.poles(_X)))
    flip = nod.flip[0]
    return Nutation(
        period=2 * float(nod.weight.sum()),
        mean_sag=float(flip * (share @ sag(_X))),
        greatest_sag=float((flip * sag(_X[-1]))[0]),
        sideways=float(flip * (share @ (rates * across))),
        lead=float(np.abs(azimuth / mean - time)[0]) if mean else np.nan,
    )


def time_to_turn(top: Top, spin: ArrayLike, pitch: ArrayLike, angle: ArrayLike) -> Any:
    """Compute the time at which the rod has swept an angle first [s].

    Infinite if it never does.
    """
    nod = _nod(top, spin, pitch)
    half_time = nod.weight.sum(axis=-1, keepdims=True)
    half_angle = (nod.weight * nod.rate(_X)).sum(axis=-1, keepdims=True)
    target = np.asarray(angle, dtype=float)[..., None] * nod.flip
    is_other_sense = np.sign(target) != np.sign(half_angle)
    never = (target != 0) & is_other_sense
    half_angle = np.where(never | (half_angle == 0), np.inf, half_angle)
    halves = target / half_angle
    # In every second half the rod moves back to its height at the start, as in a film
    # that runs backwards.
    whole = np.floor(halves)
    rest = np.mod(halves, 1)
    back = whole % 2 == 1
    rest = np.where(back, 1 - rest, rest)
    x = find_crossing(
        lambda x: nod.swept(x)[1] / half_angle - rest,
        np.full(rest.shape, _X[0]),
        _X[-1],
    )
    time, _ = nod.swept(x)
    time_in_half = np.where(back, half_time - time, time)
    whole_time = half_time * whole
    time = whole_time + time_in_half
    time = np.where(halves == 0, 0.0, time)
    return np.where(never, np.inf, time)[..., 0]


def find_crossing(
    function: Callable[[Any], Any], early: ArrayLike, late: ArrayLike
) -> Any:
    """Find by bisection where each function rises through 0.

    The zero is between `early` and `late`, and is found to the last digit.

    Without a zero between them, return `late` if the function is below 0 everywhere,
    and the number next to `early` if it is above 0. A NaN counts as above 0. Newton's
    method fails at times when a precessing rod is at rest.
    """
    low, high = np.broadcast_arrays(
        np.asarray(early, dtype=float), np.asarray(late, dtype=float)
    )
    while True:
        middle = low + (high - low) / 2
        is_between = (low < middle) & (middle < high)
        if not is_between.any():
            return high
        below = function(middle) < 0
        low = np.where(below, middle, low)
        high = np.where(below, high, middle)
