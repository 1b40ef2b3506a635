"""Where methods fail: for each failure a method that students or other programs use, and a solution.

Formulas and motions are compared by the relative error of their answer, fits by how often their 95 % interval contains
the true I_zz in simulated labs.
"""

from __future__ import annotations

import math
from decimal import Decimal, localcontext
from typing import Literal

import numpy as np
from msgspec import Struct

from gyrodata import motion, physics
from gyrodata.benchmark.effort import Clock, Effort
from gyrodata.benchmark.estimators import LabScene, draw_labs, try_fit
from gyrodata.benchmark.orders import INERTIA, TOP, runge_kutta
from gyrodata.physics import RPM
from gyrodata.simulation import EXACT, Design
from gyrodata.units import Uncertainty


class Failure(Struct, frozen=True):
    """One case in which a method fails."""

    case: str
    measure: Literal["relative error", "coverage"]
    """Of the rate or of e3; or the part of the labs in which the 95 % interval contains the true I_zz [1]."""
    fails: str
    """The method that fails."""
    wrong: float
    """Its error or its coverage [1]."""
    solution: str
    right: float
    """Error or coverage of the solution [1]."""
    why: str


def find_failures(effort: Effort, clock: Clock, seed: int = 1) -> list[Failure]:
    """Try every case."""
    return [*_formulas(), _near_vertical(), _no_steady_precession(), *_fits(effort, clock, seed)]


# --- formulas and motions ---------------------------------------------------------------------------------------


def _formulas() -> list[Failure]:
    """Eq. (8) for a rod that is nearly level and for a tilted one, and the mean of a spin that falls."""
    level, spin = 1e-14, 400 * RPM
    tilted = math.radians(45)
    start, end = 400 * RPM, 200 * RPM
    times = (np.arange(100_000) + 0.5) / 100_000
    mean = 1 / float(np.mean(1 / (start * (end / start) ** times)))
    return [
        Failure(
            "cosθ → 0: nearly level rod", "relative error",
            "eq. (8), (−b + √D)/2a", _off(textbook_root(level, spin), true_rate(level, spin)),
            "eq. (8), 2c/(b + √D)", _off(_rate(level, spin), true_rate(level, spin)),
            "the textbook root is a difference of nearly equal numbers",
        ),
        Failure(
            "rod tilted by 45°, 100 rpm", "relative error",
            "eq. (9)", _off(TOP.torque / (INERTIA * 100 * RPM), true_rate(tilted, 100 * RPM)),
            "eq. (8)", _off(_rate(tilted, 100 * RPM), true_rate(tilted, 100 * RPM)),
            "eq. (9) is for a level rod",
        ),
        Failure(
            "spin falls by half in a run", "relative error",
            "arithmetic mean", _off((start + end) / 2, mean),
            "harmonic mean", _off(float(physics.harmonic_mean_spin(start, end)), mean),
            "the precession is fastest when the spin is low",
        ),
    ]  # fmt: skip


def _off(found: float, true: float) -> float:
    return abs(found / true - 1)


def _rate(pitch: float, spin: float) -> float:
    """Slow rate of eq. (8) as the tool computes it [rad/s]."""
    return float(physics.precession_rate(TOP.torque, spin, INERTIA, TOP.transverse_inertia, pitch))


def textbook_root(pitch: float, spin: float) -> float:
    """Slow rate of eq. (8) by (−b + √D)/2a [rad/s]."""
    a, b = (INERTIA - TOP.transverse_inertia) * math.sin(pitch), INERTIA * spin
    return float((-b + math.sqrt(b * b + 4 * a * TOP.torque)) / (2 * a))


def true_rate(pitch: float, spin: float) -> float:
    """Slow rate of eq. (8) with 50 digits, of the same cosθ as the formulas [rad/s]."""
    with localcontext() as context:
        context.prec = 50
        a = (Decimal(INERTIA) - Decimal(TOP.transverse_inertia)) * Decimal(math.sin(pitch))
        b = Decimal(INERTIA) * Decimal(spin)
        return float(2 * Decimal(TOP.torque) / (b + (b * b + 4 * a * Decimal(TOP.torque)).sqrt()))


PASSING = motion.State(np.array([0.6, 0.0, 0.8]), np.array([0.02 / 3 + 2e-4, 0.04, 0.02]))
"""A rod that is on its way to the vertical and misses it by 0.2 degrees."""


def _near_vertical() -> Failure:
    """Follow a rod past the vertical for a second, in steps of a millisecond by RK4."""
    true = motion.exact(TOP, PASSING, 1.0).axis
    row = [*PASSING.axis.tolist(), *PASSING.momentum.tolist()]
    vectors = runge_kutta(motion.vector_rates(TOP), row, 1e-3, 1000)[:3]
    across, along = TOP.transverse_inertia, float(PASSING.axis @ PASSING.momentum)

    def rates(theta: float, nodding: float, _azimuth: float, turning: float) -> tuple[float, ...]:
        """Eqs. (7a) and (7b) for θ, θ̇, φ and φ̇."""
        sine, cosine = math.sin(theta), math.cos(theta)
        falling = (across * turning**2 * cosine - along * turning + TOP.torque) * sine / across
        return nodding, falling, turning, (along - 2 * across * turning * cosine) * nodding / (across * sine)

    x, y, z = PASSING.axis
    nodding = -float(np.cross(PASSING.momentum, PASSING.axis)[2]) / across / math.hypot(x, y)
    turning = (float(PASSING.momentum[2]) - along * z) / across / (x * x + y * y)
    theta, _, azimuth, _ = runge_kutta(rates, [math.acos(z), nodding, math.atan2(y, x), turning], 1e-3, 1000)
    angles = [math.sin(theta) * math.cos(azimuth), math.sin(theta) * math.sin(azimuth), math.cos(theta)]
    return Failure(
        "sinθ → 0: 0.2° past the vertical", "relative error",
        "RK4, Euler angles", float(np.linalg.norm(angles - true)),
        "RK4, vectors e3 and H", float(np.linalg.norm(vectors - true)),
        "eqs. (7) in Euler angles divide by sinθ, the vectors divide by nothing",
    )  # fmt: skip


def _no_steady_precession() -> Failure:
    """The rod points up and spins too slowly for eq. (8), which then has no real root."""
    pitch, spin = math.radians(45), 40 * RPM
    rest = motion.released(TOP, spin, pitch)
    period = motion.nutation(TOP, spin, pitch).period
    path = motion.integrate(TOP, rest, np.linspace(0, period, 200), rtol=1e-11)
    swept = float(np.unwrap(np.arctan2(path.axis[:, 1], path.axis[:, 0]))[-1])
    return Failure(
        "no real root: 45° up, 40 rpm", "relative error",
        "eq. (9)", _off(TOP.torque / (INERTIA * spin) * period, swept),
        "mean rate of the whole motion", _off(float(motion.mean_precession_rate(TOP, rest)) * period, swept),
        "D < 0: such a rod falls and swings, and eq. (9) does not say so",
    )  # fmt: skip


# --- fits -------------------------------------------------------------------------------------------------------

_OWN = {"u_time": Uncertainty(0.01), "u_spin": Uncertainty(0.0, 1e-4), "u_time_bias": Uncertainty(1e-3)}
_SHARED = {**EXACT, **_OWN, "u_spin_scale": Uncertainty(0.0, 0.01)}

CASES: tuple[tuple[LabScene, str, str], ...] = (
    (LabScene("balance", "ball not balanced: M0 = 10 %", imbalance=0.1), "line through the origin",
     "the line does not go through the origin"),
    (LabScene("one torque", "one torque only", Design(masses=(0.040,), repeats=3)), "line with a constant",
     "one torque cannot tell M0 from I_zz; the recommended interval is as wide as it must be"),
    (LabScene("shared", "shared errors only", Design(repeats=3), _SHARED),
     "York's line", "an error that all runs share does not average out"),
    (LabScene("miscount", "wrong turn count in one run", miscounts=1), "line, full covariance",
     "a run of half the turns pulls the line"),
)  # fmt: skip
"""Simulated labs, the fit that fails there, and why."""


def _fits(effort: Effort, clock: Clock, seed: int) -> list[Failure]:
    failures = []
    for scene, fails, why in CASES:
        labs = draw_labs(scene, effort.labs // 2, seed)
        wrong, right = (try_fit(name, labs, clock) for name in (fails, "recommended fit"))
        failures.append(Failure(scene.title, "coverage", fails, wrong.coverage, "recommended fit", right.coverage, why))
    return failures
