"""Cases in which methods of students or of other programs fail, each with a solution.

Formulas and motions are compared by the relative error of their answer; fits by the
coverage, the fraction of simulated labs in which the 95 % interval contains the true
I_zz.
"""

from __future__ import annotations

import math
from decimal import Decimal
from typing import Literal

import numpy as np
from msgspec import Struct

from gyrodata import physics
from gyrodata.physics import RPM, motion
from gyrodata.quantities.units import Uncertainty
from gyrodata.trials.benchmark.estimators import LabScene, draw_labs, try_fit
from gyrodata.trials.benchmark.motions import INERTIA, TOP, Clock, Effort, runge_kutta
from gyrodata.trials.simulation import EXACT, Design


class Failure(Struct, frozen=True):
    """One case in which a method fails."""

    case: str
    measure: Literal["relative error", "coverage"]
    """Relative error of the rate or of e3, or the coverage of the 95 % interval."""
    fails: str
    """The method that fails."""
    wrong: float
    """Error or coverage of the method that fails [1]."""
    solution: str
    right: float
    """Error or coverage of the solution [1]."""
    why: str


def find_failures(effort: Effort, clock: Clock, seed: int = 1) -> list[Failure]:
    """Compute every case."""
    return [
        *_formulas(),
        _near_vertical(),
        _no_steady_precession(),
        *_fits(effort, clock, seed),
    ]


# --- formulas and motions ---


def _formulas() -> list[Failure]:
    """Compute eq. (8) for a nearly level rod and for a tilted rod.

    The mean of a falling spin is computed as well.
    """
    level = 1e-14
    spin = 400 * RPM
    tilted = math.radians(45)
    start = 400 * RPM
    end = 200 * RPM
    mean = 1 / float(
        np.mean(1 / (start * (end / start) ** ((np.arange(100_000) + 0.5) / 100_000)))
    )
    return [
        Failure(
            "cosθ → 0: nearly level rod",
            "relative error",
            "eq. (8), (−b + √D)/2a",
            _off(textbook_root(level, spin), true_rate(level, spin)),
            "eq. (8), 2c/(b + √D)",
            _off(_rate(level, spin), true_rate(level, spin)),
            "the textbook root is a difference of nearly equal numbers",
        ),
        Failure(
            "rod tilted by 45°, 100 rpm",
            "relative error",
            "eq. (9)",
            _off(TOP.torque / (INERTIA * 100 * RPM), true_rate(tilted, 100 * RPM)),
            "eq. (8)",
            _off(_rate(tilted, 100 * RPM), true_rate(tilted, 100 * RPM)),
            "eq. (9) is for a level rod",
        ),
        Failure(
            "spin falls by half in a run",
            "relative error",
            "arithmetic mean",
            _off((start + end) / 2, mean),
            "harmonic mean",
            _off(float(physics.harmonic_mean_spin(start, end)), mean),
            "the precession is fastest when the spin is low",
        ),
    ]


def _off(found: float, true: float) -> float:
    return abs(found / true - 1)


def _rate(pitch: float, spin: float) -> float:
    """Compute the slow rate of eq. (8) like the tool [rad/s]."""
    return float(
        physics.precession_rate(
            TOP.torque, spin, INERTIA, TOP.transverse_inertia, pitch
        )
    )


def textbook_root(pitch: float, spin: float) -> float:
    """Compute the slow rate of eq. (8) by (−b + √D)/2a [rad/s]."""
    a = (INERTIA - TOP.transverse_inertia) * math.sin(pitch)
    b = INERTIA * spin
    return float((-b + math.sqrt(b * b + 4 * a * TOP.torque)) / (2 * a))


def true_rate(pitch: float, spin: float) -> float:
    """Compute the slow rate of eq. (8) with 28 digits [rad/s].

    The value of cosθ is the same as in the formulas.
    """
    a = (Decimal(INERTIA) - Decimal(TOP.transverse_inertia)) * Decimal(math.sin(pitch))
    b = Decimal(INERTIA) * Decimal(spin)
    return float(
        2 * Decimal(TOP.torque) / (b + (b * b + 4 * a * Decimal(TOP.torque)).sqrt())
    )


PASSING = motion.State(
    np.array([0.6, 0.0, 0.8]), np.array([0.02 / 3 + 2e-4, 0.04, 0.02])
)
"""A rod that moves towards the vertical and misses it by 0.2 degrees."""


def _near_vertical() -> Failure:
    """Integrate the motion past the vertical for a second, in steps of a millisecond by RK4."""
    true = motion.integrate(TOP, PASSING, [1.0], rtol=1e-13, atol=1e-15)[0].axis[0]
    row = [*PASSING.axis.tolist(), *PASSING.momentum.tolist()]
    vectors = runge_kutta(motion.vector_rates(TOP), row, 1e-3, 1000)[:3]
    across = TOP.transverse_inertia
    along = float(PASSING.axis @ PASSING.momentum)

    def rates(
        theta: float, nodding: float, _azimuth: float, turning: float
    ) -> tuple[float, ...]:
        """Compute eqs. (7a) and (7b) for θ, θ̇, φ and φ̇."""
        sine = math.sin(theta)
        cosine = math.cos(theta)
        falling = (
            (across * turning**2 * cosine - along * turning + TOP.torque)
            * sine
            / across
        )
        return (
            nodding,
            falling,
            turning,
            (along - 2 * across * turning * cosine) * nodding / (across * sine),
        )

    x, y, z = PASSING.axis
    nodding = (
        -float(np.cross(PASSING.momentum, PASSING.axis)[2]) / across / math.hypot(x, y)
    )
    turning = (float(PASSING.momentum[2]) - along * z) / across / (x * x + y * y)
    theta, _, azimuth, _ = runge_kutta(
        rates, [math.acos(z), nodding, math.atan2(y, x), turning], 1e-3, 1000
    )
    angles = [
        math.sin(theta) * math.cos(azimuth),
        math.sin(theta) * math.sin(azimuth),
        math.cos(theta),
    ]
    return Failure(
        "sinθ → 0: 0.2° past the vertical",
        "relative error",
        "RK4, Euler angles",
        float(np.linalg.norm(angles - true)),
        "RK4, vectors e3 and H",
        float(np.linalg.norm(vectors - true)),
        "eqs. (7) in Euler angles contain a division by sinθ, the vectors do not",
    )


def _no_steady_precession() -> Failure:
    """Compute the motion of a rod that points upwards and spins too slowly.

    Eq. (8) has no real root for this rod.
    """
    pitch = math.radians(45)
    spin = 40 * RPM
    period = motion.nutation(TOP, spin, pitch).period
    path, _ = motion.integrate(
        TOP, motion.released(TOP, spin, pitch), np.linspace(0, period, 200), rtol=1e-11
    )
    swept = float(np.unwrap(np.arctan2(path.axis[:, 1], path.axis[:, 0]))[-1])
    return Failure(
        "no real root: 45° up, 40 rpm",
        "relative error",
        "eq. (9)",
        _off(TOP.torque / (INERTIA * spin) * period, swept),
        "mean rate of the whole motion",
        _off(float(motion.mean_precession_rate(TOP, spin, pitch)) * period, swept),
        "D < 0: such a rod falls and swings, and eq. (9) does not show this",
    )


# --- fits ---

_OWN = {
    "u_time": Uncertainty(0.01),
    "u_spin": Uncertainty(0.0, 1e-4),
    "u_time_bias": Uncertainty(1e-3),
}
_SHARED = {**EXACT, **_OWN, "u_spin_scale": Uncertainty(0.0, 0.01)}

CASES: tuple[tuple[LabScene, str, str], ...] = (
    (
        LabScene("balance", "ball not balanced: M0 = 10 %", imbalance=0.1),
        "line through the origin",
        "the line does not go through the origin",
    ),
    (
        LabScene("one torque", "one torque only", Design(masses=(0.040,), repeats=3)),
        "line with intercept",
        "one torque does not determine M0; the recommended interval includes this",
    ),
    (
        LabScene("shared", "shared errors only", Design(repeats=3), _SHARED),
        "York's line",
        "errors that all runs share do not average out",
    ),
    (
        LabScene("miscount", "wrong turn count in one run", miscounts=1),
        "line, full covariance",
        "one run with half of the turns changes the line",
    ),
)
"""Simulated labs, the fit that fails, and the reason."""


def _fits(effort: Effort, clock: Clock, seed: int) -> list[Failure]:
    failures = []
    for scene, fails, why in CASES:
        labs = draw_labs(scene, effort.labs // 2, seed)
        wrong, right = (
            try_fit(name, labs, clock) for name in (fails, "recommended fit")
        )
        failures.append(
            Failure(
                scene.title,
                "coverage",
                fails,
                wrong.coverage,
                "recommended fit",
                right.coverage,
                why,
            )
        )
    return failures
