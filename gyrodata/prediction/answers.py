"""What theory says for given numbers, as the dictionaries that ``gyro predict`` gives out: SI, None for what is not.

Each answer carries ``reason``: in words, why what is None is None; "" where nothing is.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gyrodata import __version__, motion, physics

SCHEMA = "gyro.prediction/1"

RPM = math.pi / 30
"""One revolution per minute [rad/s]."""

SMALL_SAG = 0.15
"""Mean sag of a released rod [rad] beyond which its lowest order is a tenth off."""


def document(name: str, options: Mapping[str, Any], notes: Sequence[str], answer: Mapping[str, Any]) -> dict[str, Any]:
    """Put an answer into the object that is written out.

    Parameters
    ----------
    name : str
        "precession", "earth", "platform" or "tip".
    options : mapping
        The numbers it is for, in SI units.
    notes : sequence of str
        What was taken by default.
    answer : mapping
        From one of the functions below.

    Returns
    -------
    dict
        The answer's keys stand beside "schema", "tool", "prediction", "options" and "notes".
    """
    return {
        "schema": SCHEMA,
        "tool": {"name": "gyrodata", "version": __version__},
        "prediction": name,
        "options": dict(options),
        "notes": list(notes),
        **answer,
    }


def predict_precession(
    torque: float, spin: float, inertia: float, transverse_inertia: float, pitch: float = 0.0
) -> dict[str, Any]:
    """Steady precession, what a rod let go from rest does instead, and whether an upright one stays.

    Parameters
    ----------
    torque : float
        h m g, the torque with the rod horizontal [N*m].
    spin : float
        ψ̇ relative to the frame that follows the rod [rad/s].
    inertia, transverse_inertia : float
        I_zz and I [kg*m^2].
    pitch : float
        Angle of the rod above the horizontal, between -π/2 and π/2 [rad].

    Returns
    -------
    dict
        "slow" and "fast" root of eq. (8) and "horizontal", eq. (9) [rad/s]; "exists"; "critical_spin", the least
        spin for steady precession at this pitch [rad/s]; "period" of the slow root [s]; "released" and "sleeping".
    """
    top = inertia, transverse_inertia, pitch
    slow = _finite(physics.precession_rate(torque, spin, *top))
    fast = _finite(physics.fast_precession_rate(torque, spin, *top))
    horizontal = _finite(physics.precession_rate(torque, spin, inertia))
    critical = float(physics.least_spin(torque, *top))
    return {
        "slow": slow,
        "fast": fast,
        "horizontal": horizontal,
        "exists": slow is not None,
        "critical_spin": critical,
        "period": 2 * math.pi / abs(slow) if slow else None,
        "reason": _why_none(slow, fast, horizontal, critical, inertia == transverse_inertia),
        "released": _released(torque, spin, *top),
        "sleeping": _sleeping(torque, spin, inertia, transverse_inertia),
    }


def _why_none(
    slow: float | None, fast: float | None, horizontal: float | None, critical: float, round_body: bool
) -> str:
    """Say why there is no such rate: clauses, parted by semicolons."""
    clauses = []
    if slow is None:
        low = (
            f"no steady precession at this pitch below the least spin, {critical:.4g} rad/s = {critical / RPM:.4g} rpm"
        )
        clauses.append(f"slow, fast, period: {low if critical else 'without spin the rod just falls'}")
    elif fast is None:
        which = "with I = I_zz" if round_body else "that is level"
        clauses.append(f"fast: a rod {which} has only the slow precession")
    if slow == 0:
        clauses.append("period: without a torque the rod stays where it points")
    if horizontal is None:
        clauses.append("horizontal: a level rod that does not spin falls")
    return "; ".join(clauses)


def _finite(value: Any) -> float | None:
    """A number, or None for what theory has no number for; zero without a sign."""
    return float(value) + 0.0 if math.isfinite(value) else None


def _released(torque: float, spin: float, inertia: float, across: float, pitch: float) -> dict[str, Any]:
    """A rod let go from rest; its mean rate from the exact motion."""
    lowest = float(physics.greatest_sag(torque, spin, inertia, across, pitch)) + 0.0
    small_only = "sag, nutation_rate, click_error_s"
    if spin == 0:
        why = f"mean_rate, {small_only}: without spin it swings and does not precess"
        return {
            "mean_rate": None,
            "sag": None,
            "greatest_sag": lowest,
            "nutation_rate": None,
            "click_error_s": None,
            "reason": why,
        }
    top = motion.Top(inertia, across, torque)
    # Without a torque the rod stays, to the last bit.
    mean = _finite(motion.mean_precession_rate(top, motion.released(top, spin, pitch))) if torque else 0.0
    sag = float(physics.mean_sag(torque, spin, inertia, across, pitch)) + 0.0
    small = abs(sag) <= SMALL_SAG
    return {
        "mean_rate": mean,
        "sag": sag if small else None,
        "greatest_sag": lowest,
        "nutation_rate": float(physics.nutation_rate(spin, inertia, across)) if small else None,
        "click_error_s": float(physics.click_error(spin, inertia, across)) if small else None,
        "reason": "" if small else f"{small_only}: it falls too far for small nutations",
    }


def _sleeping(torque: float, spin: float, inertia: float, across: float) -> dict[str, Any]:
    """An upright rod, the spin being the total one."""
    critical = float(physics.sleeping_spin(torque, inertia, across))
    return {
        "stable": abs(spin) > critical or torque < 0,
        "critical_spin": critical,
        "growth_rate": float(physics.sleeping_growth(torque, spin, inertia, across)),
    }


def predict_earth(latitude: float, times: Sequence[float]) -> dict[str, Any]:
    """Where two balanced gyroscopes point as the Earth turns under them.

    Parameters
    ----------
    latitude : float
        North positive [rad].
    times : sequence of float
        Clock times since the start [s].

    Returns
    -------
    dict
        "north": started along the Earth's axis, towards the north; "east": started level, towards the east. Each a
        list of rows with "hours" (of the clock), "sidereal_hours", "azimuth_deg" (from north through east; None
        straight up or down), "altitude_deg" and "reason". "sidereal_day_hours": clock hours of a turn of the Earth.
    """
    return {
        "sidereal_day_hours": physics.SIDEREAL_DAY / 3600,
        "north": _directions(0.0, latitude, latitude, times),
        "east": _directions(math.pi / 2, 0.0, latitude, times),
    }


def _directions(azimuth: float, altitude: float, latitude: float, times: Sequence[float]) -> list[dict[str, Any]]:
    bearings, heights = physics.balanced_direction(azimuth, altitude, latitude, np.asarray(times, dtype=float))
    return [
        {
            "hours": time / 3600,
            "sidereal_hours": 24 * time / physics.SIDEREAL_DAY,
            "azimuth_deg": _finite(math.degrees(bearing)),
            "altitude_deg": math.degrees(height),
            "reason": "azimuth_deg: it points straight up or down" if math.isnan(bearing) else "",
        }
        for time, bearing, height in zip(times, bearings.tolist(), heights.tolist(), strict=True)
    ]


def predict_platform(
    wheel_inertia: float, wheel_spin: float, platform_inertia: float, start: float, end: float
) -> dict[str, Any]:
    """A turntable at rest, on which someone tips a spinning wheel.

    Parameters
    ----------
    wheel_inertia : float
        Of the wheel about its axle [kg*m^2].
    wheel_spin : float
        [rad/s]
    platform_inertia : float
        Of turntable, person and wheel about the vertical [kg*m^2].
    start, end : float
        Angle of the axle above the horizontal [rad].

    Returns
    -------
    dict
        "rate" of the platform, positive in the sense that the wheel has with its axle up [rad/s]; "period" of a
        turn [s]; "momentum_before" of the wheel about the vertical, "momentum_after" of the wheel and
        "momentum_platform" [kg*m^2/s].
    """
    rate = float(physics.platform_rate(wheel_inertia, wheel_spin, platform_inertia, start, end)) + 0.0
    wheel = wheel_inertia * wheel_spin
    return {
        "rate": rate,
        "period": 2 * math.pi / abs(rate) if rate else None,
        "momentum_before": wheel * math.sin(start) + 0.0,
        "momentum_after": wheel * math.sin(end) + 0.0,
        "momentum_platform": platform_inertia * rate,
        "reason": "" if rate else "period: the platform stays at rest",
    }


def predict_tip(force: float, length: float, inertia: float, spin: float) -> dict[str, Any]:
    """How the rod's tip yields to a steady force across it.

    Parameters
    ----------
    force : float
        At right angles to the rod, above 0 [N].
    length : float
        From the centre of the ball to the tip [m].
    inertia : float
        I_zz [kg*m^2].
    spin : float
        Not 0; positive is counterclockwise for who looks from the tip at the ball [rad/s].

    Returns
    -------
    dict
        "speed" of the tip [m/s]; "turning_rate" of the rod [rad/s]; "torque" [N*m]; "angle_deg" from the force to
        the velocity, counterclockwise for who looks from the tip at the ball; "direction" in words.
    """
    # Looking from the tip at the ball: the rod towards the eye, the force to the right.
    velocity = physics.tip_velocity([force, 0.0, 0.0], [0.0, 0.0, 1.0], length, inertia, spin)
    speed = float(np.linalg.norm(velocity))
    return {
        "speed": speed,
        "turning_rate": speed / length,
        "torque": force * length,
        "angle_deg": math.degrees(math.atan2(velocity[1], velocity[0])),
        "direction": "along the torque: across the force, a quarter turn ahead of it in the sense of the spin",
    }
