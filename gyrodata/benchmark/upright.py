"""Orbits that pass near the vertical, sinθ → 0: which way of writing the motion loses digits there, or dies.

The rod swings from 43° off the vertical to a smallest angle θ_min and back, as a top that nods. Eqs. (7) in Euler
angles divide by sinθ, their form reduced by the two conserved momenta by sin²θ; the vectors e3 and H divide by nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from gyrodata import motion
from gyrodata.benchmark.effort import Effort, Progress
from gyrodata.benchmark.maps import ACROSS, INERTIA, TORQUE
from gyrodata.physics import RPM, Floats

LOW = math.radians(43)
"""θ at the lower turning point [rad]."""

SPIN = 300 * RPM
"""ω3 [rad/s]; such a top sleeps."""

TIME = 10.0
"""[s]"""

_TOLERANCE = 1e-9


@dataclass(frozen=True, slots=True)
class Passage:
    """One way of writing the motion, on an orbit that passes the vertical at one distance."""

    method: str
    closest: float
    """θ_min [rad]; 0 for a rod that is started at the vertical."""
    error: float | None
    """Distance of e3 from the true one at its worst in `TIME` [1]; None where it gives no number."""
    evaluations: int | None
    """Of the right-hand side; None for the exact motion."""


METHODS = ("eqs. (7), Euler angles", "reduced to θ", "vectors e3, H", "splitting aba84", "exact motion")
"""Ways of writing the motion, the failing ones first."""


def pass_upright(effort: Effort, progress: Progress | None = None) -> list[Passage]:
    """Follow orbits that pass ever nearer to the vertical, and one that starts there, by all `METHODS`.

    Errors are distances from the exact motion; its own is from the vectors at a tolerance of 1e-13, mostly theirs.
    """
    distances = [*(float(d) for d in np.geomspace(0.3, 1e-8, effort.swings)), 0.0]
    passages = []
    for i, closest in enumerate(distances):
        passages += _pass_once(closest)
        if progress is not None:
            progress((i + 1) / len(distances))
    return passages


def _pass_once(closest: float) -> list[Passage]:
    top = motion.Top(INERTIA, ACROSS, TORQUE)
    state = nodding(closest)
    times = np.linspace(0, TIME, 41)[1:]
    true = motion.exact(top, state, times).axis
    found = []
    for method, follow in ((METHODS[0], follow_euler), (METHODS[1], follow_reduced)):
        axis, evaluations = follow(state, times)
        found.append(Passage(method, closest, _worst(axis, true), evaluations))
    path = motion.integrate(top, state, times, rtol=_TOLERANCE)
    found.append(Passage(METHODS[2], closest, _worst(path.axis, true), path.evaluations))
    steps, kicks = 2000, len(motion.METHODS["aba84"][1])
    split = motion.split(top, state, times[-1], steps).axis
    found.append(Passage(METHODS[3], closest, _worst(split[None], true[-1:]), steps * kicks))
    tight = motion.integrate(top, state, times, rtol=1e-13, atol=1e-15)
    return [*found, Passage(METHODS[4], closest, _worst(tight.axis, true), None)]


def _worst(axis: Floats | None, true: Floats) -> float | None:
    if axis is None:
        return None
    return float(np.max(np.linalg.norm(axis - true, axis=-1)))


def nodding(closest: float) -> motion.State:
    """The state at the lower turning point, `LOW`, of an orbit whose upper one is at an angle from the vertical.

    At both turning points (H·Z − H3 cosθ)²/(2 I sin²θ) + h m g cosθ is the same. With H·Z = H3 cosθ_min +
    q sinθ_min this is a quadratic in q that stays regular as θ_min → 0.
    """
    along = INERTIA * SPIN
    below, above = math.sin(LOW), math.sin(closest)
    # cosθ_min − cosθ_low, without cancellation.
    rise = 2 * math.sin((LOW + closest) / 2) * math.sin((LOW - closest) / 2)
    drop = along * rise
    a, b = 1 - (above / below) ** 2, above * drop / below**2
    c = (drop / below) ** 2 - 2 * ACROSS * TORQUE * rise
    q = (b + math.sqrt(b * b + a * c)) / a
    if closest == 0:
        return motion.State(np.array([0.0, 0.0, 1.0]), np.array([q, 0.0, along]))
    across = (drop + q * above) / below
    axis = np.array([below, 0.0, math.cos(LOW)])
    return motion.State(axis, along * axis + across * np.array([-math.cos(LOW), 0.0, below]))


# --- the ways that fail -------------------------------------------------------------------------------------


def follow_euler(state: motion.State, times: Floats, tolerance: float = _TOLERANCE) -> tuple[Floats | None, int]:
    """Follow the rod by eqs. (7) in the Euler angles: e3 at the times, None without a number; and evaluations."""
    along = float(state.axis @ state.momentum)

    def rates(_time: float, row: Floats) -> Sequence[float]:
        angle, turning, nodding, _ = row.tolist()
        sine, cosine = math.sin(angle), math.cos(angle)
        falling = (ACROSS * turning**2 * cosine - along * turning + TORQUE) * sine / ACROSS
        return [nodding, (along - 2 * ACROSS * turning * cosine) * nodding / (ACROSS * sine), falling, turning]

    try:
        angle, turning = _start(state)
    except ZeroDivisionError:
        return None, 0
    return _followed(rates, [angle, turning, 0.0, 0.0], times, tolerance, (0, 3))


def follow_reduced(state: motion.State, times: Floats, tolerance: float = _TOLERANCE) -> tuple[Floats | None, int]:
    """Follow the rod by the equation of θ alone that the conserved H·Z and H·e3 leave: as `follow_euler`."""
    along, upwards = float(state.axis @ state.momentum), float(state.momentum[2])

    def rates(_time: float, row: Floats) -> Sequence[float]:
        angle, nodding, _ = row.tolist()
        sine, cosine = math.sin(angle), math.cos(angle)
        turning = (upwards - along * cosine) / (ACROSS * sine**2)
        falling = (ACROSS * turning**2 * cosine - along * turning + TORQUE) * sine / ACROSS
        return [nodding, falling, turning]

    return _followed(rates, [math.acos(state.axis[2]), 0.0, 0.0], times, tolerance, (0, 2))


def _start(state: motion.State) -> tuple[float, float]:
    """θ [rad] and φ̇ [rad/s] at the start."""
    sine = float(np.hypot(state.axis[0], state.axis[1]))
    across = float(state.momentum[2] - state.axis[2] * (state.axis @ state.momentum))
    return math.atan2(sine, float(state.axis[2])), across / (ACROSS * sine**2)


def _followed(
    rates: Callable[[float, Floats], Sequence[float]],
    start: list[float],
    times: Floats,
    tolerance: float,
    places: tuple[int, int],
) -> tuple[Floats | None, int]:
    from scipy.integrate import solve_ivp

    count = 0

    def counted(time: float, row: Floats) -> Sequence[float]:
        nonlocal count
        count += 1
        return rates(time, row)

    try:
        done = solve_ivp(counted, (0, times[-1]), start, "DOP853", times, rtol=tolerance, atol=1e-12)
    except (ZeroDivisionError, OverflowError):
        return None, count
    angle, azimuth = (done.y[place] for place in places)
    if not done.success or not np.isfinite(done.y).all():
        return None, count
    return np.stack([np.sin(angle) * np.cos(azimuth), np.sin(angle) * np.sin(azimuth), np.cos(angle)], axis=-1), count
