"""What theory says for given numbers, as the dictionaries that ``gyro predict`` gives out, and as text for people.

The dictionaries are in SI units, with None for what is not; each carries ``reason``: in words, why what is None is
None, "" where nothing is. The text has rpm, seconds and degrees, with the SI unit beside.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gyrodata import __version__, motion, physics
from gyrodata.physics import RPM

SCHEMA = "gyro.prediction/1"

SMALL_SAG = 0.15
"""Mean sag of a released rod [rad] beyond which its lowest order is a tenth off."""


def document(name: str, options: Mapping[str, Any], notes: Sequence[str], answer: Mapping[str, Any]) -> dict[str, Any]:
    """Put an answer into the object that is written out."""
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

    "slow" and "fast" root of eq. (8) and "horizontal", eq. (9) [rad/s]; "critical_spin" is the least spin for steady
    precession at this pitch [rad/s], "period" that of the slow root [s].
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
    """Where two balanced gyroscopes point as the Earth turns under them, at clock times since the start [s].

    "north": started along the Earth's axis, towards the north; "east": started level, towards the east. The azimuth is
    from north through east, None straight up or down; hours are of the clock.
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
    """A turntable at rest, on which someone tips a spinning wheel from one angle above the horizontal to another.

    "rate" of the platform is positive in the sense that the wheel has with its axle up [rad/s]; "momentum_before" of
    the wheel about the vertical, "momentum_after" of the wheel and "momentum_platform" [kg*m^2/s].
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

    The spin is positive counterclockwise for who looks from the tip at the ball; "angle_deg" is from the force to the
    velocity, seen the same way. "speed" of the tip [m/s]; "turning_rate" of the rod [rad/s]; "torque" [N*m].
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


def prediction_text(document: Mapping[str, Any]) -> str:
    """Write a prediction as text."""
    writers = {"precession": _precession_text, "earth": _earth_text, "platform": _platform_text, "tip": _tip_text}
    lines = writers[document["prediction"]](document)
    if document["notes"]:
        lines += ["", "taken by default:", *(f"  {note}" for note in document["notes"])]
    return "\n".join(lines) + "\n"


def _rate(value: float) -> str:
    return f"{value / RPM:.4g} rpm ({value:.4g} rad/s)"


def _angle(value: float) -> str:
    return f"{math.degrees(value):.3g}° ({value:.3g} rad)"


def _line(label: str, text: str) -> str:
    return f"  {label:<16}{text}"


def _precession_text(told: Mapping[str, Any]) -> list[str]:
    options = told["options"]
    pitch, spin = f"{math.degrees(options['pitch']):.4g}°", _rate(options["spin"])
    lines = [f"steady precession at pitch {pitch}, spin {spin}, torque {options['torque']:.4g} N*m"]
    if told["slow"] is not None:
        turn = f", one turn in {told['period']:.4g} s" if told["period"] else ""
        lines.append(_line("slow, eq. (8)", _rate(told["slow"]) + turn))
    if told["fast"] is not None:
        lines.append(_line("fast, eq. (8)", _rate(told["fast"])))
    if told["horizontal"] is not None:
        lines.append(_line("level, eq. (9)", _rate(told["horizontal"])))
    lines.append(_line("least spin", f"{_least(told['critical_spin'])} for steady precession at this pitch"))
    lines += _lacking(told)
    return [*lines, "", *_released_text(told["released"]), "", *_sleeping_text(told["sleeping"])]


def _released_text(told: Mapping[str, Any]) -> list[str]:
    lines = ["let go from rest"]
    if told["mean_rate"] is not None:
        lines.append(_line("mean rate", _rate(told["mean_rate"])))
    sag = f"{_angle(told['sag'])} on average, " if told["sag"] is not None else ""
    lines.append(_line("sags by", f"{sag}{_angle(told['greatest_sag'])} at most"))
    if told["nutation_rate"] is not None:
        lines.append(_line("nutates at", _rate(told["nutation_rate"])))
        lines.append(_line("click error", f"up to {told['click_error_s']:.2g} s, by the phase of the nutation"))
    return [*lines, *_lacking(told)]


def _lacking(told: Mapping[str, Any]) -> list[str]:
    """Say what is None, and why."""
    return [
        f"  no {clause.replace('click_error_s', 'click error').replace('_', ' ')}"
        for clause in told["reason"].split("; ")
        if clause
    ]


def _sleeping_text(told: Mapping[str, Any]) -> list[str]:
    lines = ["rod upright, at this spin"]
    if told["stable"]:
        lines.append(_line("stays", "a small tilt does not grow"))
    elif told["growth_rate"]:
        lines.append(_line("falls", f"a small tilt grows e-fold in {1 / told['growth_rate']:.3g} s"))
    else:
        lines.append(_line("drifts", "nothing holds it"))
    return [*lines, _line("least spin", f"{_least(told['critical_spin'])} to stay")]


def _least(spin: float) -> str:
    return _rate(spin) if spin else "any"


def _earth_text(told: Mapping[str, Any]) -> list[str]:
    latitude = math.degrees(told["options"]["latitude"])
    lines = [
        f"balanced gyroscopes at latitude {latitude:.4g}°, from the ground, which turns under them",
        "  north: started along the Earth's axis; east: started level. Azimuth is from north through east.",
        "",
        f"  {'hours':>8}{'sidereal':>10}{'north: azimuth':>17}{'altitude':>10}{'east: azimuth':>16}{'altitude':>10}",
    ]
    for north, east in zip(told["north"], told["east"], strict=True):
        cells = f"  {north['hours']:>8.4f}{north['sidereal_hours']:>10.4f}"
        cells += f"{_bearing(north):>17}{_height(north):>10}{_bearing(east):>16}{_height(east):>10}"
        lines.append(cells)
    return lines


def _bearing(row: Mapping[str, Any]) -> str:
    return "-" if row["azimuth_deg"] is None else f"{round(row['azimuth_deg'], 2) % 360:.2f}°"


def _height(row: Mapping[str, Any]) -> str:
    # No "-0.00".
    return f"{round(row['altitude_deg'], 2) + 0.0:.2f}°"


def _platform_text(told: Mapping[str, Any]) -> list[str]:
    start, end = (math.degrees(told["options"][name]) for name in ("from", "to"))
    lines = [f"axle tipped from {start:.4g}° to {end:.4g}° above the horizontal, the platform at rest before"]
    if told["period"]:
        sense = "in" if told["rate"] * told["options"]["wheel_spin"] > 0 else "against"
        lines.append(_line("platform", f"{_rate(abs(told['rate']))}, one turn in {told['period']:.4g} s"))
        lines.append(_line("sense", f"{sense} that of the wheel when its axle points up"))
    else:
        lines.append(_line("platform", "stays at rest"))
    lines.append("")
    lines.append("angular momentum about the vertical, which stays the same [kg*m^2/s]")
    lines.append(_line("before", f"wheel {told['momentum_before']:.4g}"))
    after = f"wheel {told['momentum_after']:.4g}, platform {told['momentum_platform']:.4g}"
    return [*lines, _line("after", after)]


def _tip_text(told: Mapping[str, Any]) -> list[str]:
    speed, options = told["speed"], told["options"]
    return [
        f"a force of {options['force']:.4g} N across the rod, {100 * options['length']:.4g} cm from the centre",
        _line("tip", f"{100 * speed:.4g} cm/s ({speed:.4g} m/s)"),
        _line("direction", told["direction"]),
        _line("rod turns at", _rate(told["turning_rate"])),
        _line("torque", f"{told['torque']:.4g} N*m"),
    ]
