"""Predictions of theory: the answers of ``gyro predict``, and their text.

The answers are in SI units. A value that does not exist is None, and ``reason``
contains the cause. The words are in `prediction.toml`.
"""

from __future__ import annotations

import math
import string
import textwrap
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
from msgspec import Struct
from msgspec.structs import asdict, replace

from gyrodata.base.tool import Tool
from gyrodata.physics import (
    EARTH_ROTATION,
    RPM,
    SIDEREAL_DAY,
    balanced_direction,
    fast_precession_rate,
    horizontal_precession_rate,
    least_spin,
    motion,
    platform_rate,
    precession_rate,
    sleeping_growth,
    sleeping_spin,
)
from gyrodata.physics.motion import Top, mean_precession_rate

SLOW = 0.01
"""The formula for a fast spin is called unsuitable if its relative error exceeds this
value [1]."""


class Prediction(Struct, frozen=True, kw_only=True):
    """The keys that every prediction has."""

    schema: Literal["gyro.prediction/2"] = "gyro.prediction/2"
    tool: Tool = Tool()
    options: Mapping[str, float] = {}
    """The numbers that the prediction is for [SI units]."""
    notes: tuple[str, ...] = ()
    """The numbers that were not given as options, and where they come from."""
    why: str
    """The answer in words."""
    reason: str = ""
    """Names of the values that are null, with the cause."""


_FILE = Path(__file__).with_suffix(".toml")

TEXTS = tomllib.loads(_FILE.read_text(encoding="utf-8"))
"""The words of each prediction, by case, and its text."""


def _say(question: str, case: str, **parts: str) -> str:
    """Return the words for a case of a question, in one line."""
    text = TEXTS[question][case].format(**parts)
    return " ".join(text.split())


def _finite(value: Any) -> float | None:
    """Return a number without the sign of zero; None if theory has no number."""
    return float(value) + 0.0 if math.isfinite(value) else None


# --- the rod under a weight ---


class Released(Struct, frozen=True, kw_only=True):
    """A rod that is released from rest, by the exact motion."""

    mean_rate: float | None = None
    """Mean precession rate [rad/s]."""
    sag: float
    """Angle below the start, mean over time [rad]; negative if the rod rises."""
    greatest_sag: float
    """Largest angle below the start [rad]; negative if the rod rises."""
    nutation_rate: float | None = None
    """2π over the time from one moment of rest to the next [rad/s]."""
    click_error_s: float | None = None
    """Largest time by which the rod is ahead of its mean motion, or behind it [s]."""
    reason: str = ""
    """Names of the values that are null, with the cause."""


class Sleeping(Struct, frozen=True):
    """An upright rod with this total spin."""

    stable: bool
    critical_spin: float
    """Minimum spin to stay upright [rad/s]."""
    growth_rate: float
    """Growth rate of a small tilt [1/s]."""


class Precession(Prediction, frozen=True, kw_only=True):
    """Steady precession, the motion after a release from rest, and the upright rod.

    For the upright rod, the record describes the stability.
    """

    prediction: Literal["precession"] = "precession"
    slow: float | None = None
    """Slow root of eq. (8) [rad/s]."""
    fast: float | None = None
    """Fast root of eq. (8) [rad/s]."""
    horizontal: float | None = None
    """Eq. (9) [rad/s]."""
    exists: bool
    """True if steady precession is possible."""
    critical_spin: float
    """Minimum spin for steady precession at this pitch [rad/s]."""
    period: float | None = None
    """Period of the slow root [s]."""
    released: Released
    sleeping: Sleeping


def predict_precession(
    torque: float, spin: float, inertia: float, transverse_inertia: float, pitch: float
) -> Precession:
    """Compute both roots of eq. (8), and eq. (9).

    The motion after a release from rest and the upright rod are computed as well.
    """
    body = inertia, transverse_inertia, pitch
    top = Top(inertia=inertia, transverse_inertia=transverse_inertia, torque=torque)
    slow = _finite(precession_rate(torque, spin, *body))
    never = ""
    if slow is None:
        never = "At this pitch the spin is too slow for steady precession. "
    case = "turns"
    if torque == 0:
        case = "no_torque"
    elif spin == 0:
        case = "no_spin"
    sense = "counterclockwise" if torque * spin > 0 else "clockwise"
    moves = "falls" if torque > 0 else "rises"
    precession = Precession(
        why=_say("precession", case, sense=sense, never=never, moves=moves),
        slow=slow,
        fast=_finite(fast_precession_rate(torque, spin, *body)),
        horizontal=_finite(precession_rate(torque, spin, inertia)),
        exists=slow is not None,
        critical_spin=float(least_spin(torque, *body)),
        period=_period(slow) if slow else None,
        released=_released(top, spin, pitch),
        sleeping=_sleeping(top, spin),
    )
    reasons = _reasons(precession, inertias_agree=inertia == transverse_inertia)
    return replace(precession, reason="; ".join(reasons))


def _reasons(precession: Precession, inertias_agree: bool) -> Iterator[str]:
    """Say why values are null; `inertias_agree`: I is equal to I_zz."""
    minimum = precession.critical_spin
    if precession.slow is None:
        cause = "without spin the rod falls"
        if minimum:
            cause = f"the spin is below the minimum of {minimum / RPM:.4g} rpm"
        yield f"slow, fast, period: {cause}"
    elif precession.fast is None:
        which = "with I = I_zz" if inertias_agree else "that is level"
        yield f"fast: a rod {which} has only the slow precession"
    if precession.slow == 0:
        yield "period: without a torque the rod keeps its direction"
    if precession.horizontal is None:
        yield "horizontal: a level rod that does not spin falls"


def _period(rate: float) -> float:
    """Return the time of one turn [s]."""
    return 2 * math.pi / abs(rate)


def _sleeping(top: Top, spin: float) -> Sleeping:
    inertia, transverse, torque = top.inertia, top.transverse_inertia, top.torque
    upright = float(sleeping_spin(torque, inertia, transverse))
    growth = float(sleeping_growth(torque, spin, inertia, transverse))
    return Sleeping(abs(spin) > upright or torque < 0, upright, growth)


def _released(top: Top, spin: float, pitch: float) -> Released:
    nutation = motion.nutation(top, spin, pitch)
    # No "-0.0".
    sag = nutation.mean_sag + 0.0
    greatest_sag = nutation.greatest_sag + 0.0
    released = Released(sag=sag, greatest_sag=greatest_sag)
    if spin == 0:
        cause = "without spin the rod swings and does not precess"
        reason = f"mean_rate, nutation_rate, click_error_s: {cause}"
        return replace(released, reason=reason)
    mean = _finite(mean_precession_rate(top, spin, pitch))
    nutation_rate = 2 * math.pi / nutation.period
    released = replace(released, mean_rate=mean, nutation_rate=nutation_rate)
    if top.torque == 0:
        reason = "click_error_s: without a torque the rod keeps its direction"
        return replace(released, reason=reason)
    return replace(released, click_error_s=nutation.lead)


# --- the rotation of the Earth ---


class Direction(Struct, frozen=True, kw_only=True):
    """The direction of a rod at one time."""

    hours: float
    """Time of the clock since the start [h]."""
    sidereal_hours: float
    azimuth_deg: float | None = None
    """From north through east; null straight up or down."""
    altitude_deg: float
    reason: str = ""


class Earth(Prediction, frozen=True, kw_only=True):
    """The directions of two balanced gyroscopes while the Earth rotates below them."""

    prediction: Literal["earth"] = "earth"
    sidereal_day_hours: float
    pole: str
    """Pole of the sky above the horizon, "north" or "south", to which the first rod
    points."""
    axis: tuple[Direction, ...]
    """Started along the Earth's axis."""
    east: tuple[Direction, ...]
    """Started level, towards the east."""
    drift_torque: float | None = None
    """Residual torque that turns a level rod as fast as the Earth rotates [N*m]."""


def predict_earth(
    latitude: float, times: Sequence[float], inertia: float, spin: float
) -> Earth:
    """Compute the directions of two balanced gyroscopes at times [s]."""
    height = round(90 - math.degrees(abs(latitude)), 1)
    pole, azimuth, star, side = "north", 0.0, "the pole star", "south"
    if latitude < 0:
        pole = "south"
        azimuth = math.pi
        star = "the south pole of the sky"
        side = "north"
    highest = f"in the {side} at {height:g}°" if height < 90 else "straight overhead"
    case = "highest" if height else "at_pole"
    path = _say("earth", case, highest=highest, side=side)
    return Earth(
        why=_say("earth", "why", star=star, path=path),
        sidereal_day_hours=SIDEREAL_DAY / 3600,
        pole=pole,
        axis=_directions(azimuth, abs(latitude), latitude, times),
        east=_directions(math.pi / 2, 0.0, latitude, times),
        drift_torque=inertia * abs(spin) * EARTH_ROTATION,
    )


def _directions(
    azimuth: float, altitude: float, latitude: float, times: Sequence[float]
) -> tuple[Direction, ...]:
    bearings, heights = balanced_direction(
        azimuth, altitude, latitude, np.asarray(times, dtype=float)
    )
    directions = []
    for time, bearing, height in zip(times, bearings, heights, strict=True):
        reason = ""
        if math.isnan(bearing):
            reason = "azimuth_deg: the rod points straight up or down"
        direction = Direction(
            hours=time / 3600,
            sidereal_hours=24 * time / SIDEREAL_DAY,
            azimuth_deg=_finite(math.degrees(bearing)),
            altitude_deg=math.degrees(height),
            reason=reason,
        )
        directions.append(direction)
    return tuple(directions)


def _earth_table(earth: Earth) -> str:
    axis = f"{earth.pole}: azimuth"
    east = "east: azimuth"
    head = f"  {'hours':>7}{'sidereal':>10}"
    lines = [f"{head}{axis:>17}{'altitude':>10}{east:>16}{'altitude':>10}"]
    for row, other in zip(earth.axis, earth.east, strict=True):
        line = f"  {row.hours:>7.2f}{row.sidereal_hours:>10.3f}"
        for position, width in ((row, 17), (other, 16)):
            # No "360.00" and no "-0.00".
            azimuth = "-"
            if position.azimuth_deg is not None:
                azimuth = f"{round(position.azimuth_deg, 2) % 360:.2f}°"
            altitude = round(position.altitude_deg, 2) + 0.0
            line += f"{azimuth:>{width}}{altitude:>9.2f}°"
        lines.append(line)
    return "\n".join(lines)


# --- a wheel in the hands ---


class Platform(Prediction, frozen=True, kw_only=True):
    """A turntable at rest on which a person tips a spinning wheel."""

    prediction: Literal["platform"] = "platform"
    rate: float
    """Of the platform, counterclockwise seen from above is positive [rad/s]."""
    period: float | None = None
    """Of the platform [s]."""
    momentum_before: float
    """Angular momentum of the wheel about the vertical, before [kg*m^2/s]."""
    momentum_after: float
    """Angular momentum of the wheel about the vertical, after [kg*m^2/s]."""
    momentum_platform: float
    """Angular momentum of the platform with everything on it, after [kg*m^2/s]."""


def predict_platform(
    wheel_inertia: float,
    wheel_spin: float,
    platform_inertia: float,
    start: float,
    end: float,
) -> Platform:
    """Tip the axle from one angle above the horizontal to another [rad]."""
    exact = platform_rate(wheel_inertia, wheel_spin, platform_inertia, start, end)
    rate = float(exact) + 0.0  # no "-0.0"
    wheel = wheel_inertia * wheel_spin
    if wheel == 0:
        case = "no_spin"
    elif rate:
        case = "turns"
    else:
        case = "no_change"
    return Platform(
        why=_say("platform", case),
        reason="" if rate else "period: the platform stays at rest",
        rate=rate,
        period=_period(rate) if rate else None,
        momentum_before=wheel * math.sin(start) + 0.0,
        momentum_after=wheel * math.sin(end) + 0.0,
        momentum_platform=platform_inertia * rate,
    )


class Twist(Prediction, frozen=True, kw_only=True):
    """The torque of a wheel with a level axle that both hands turn over steadily.

    The wheel is spinning, and is turned over at a steady rate.
    """

    prediction: Literal["twist"] = "twist"
    twist_rate: float
    """Rate at which the axle turns [rad/s]."""
    torque: float
    """Size of the torque of the hands on the wheel [N*m]."""
    force: float
    """Force of each hand; the two forces are opposite [N]."""
    momentum_change: float
    """Change of the wheel's angular momentum when it is turned over [kg*m^2/s]."""
    turn_left: str
    """What the hands do to turn the axle counterclockwise, seen from above."""
    right_end_up: str
    """What the hands do to raise the right end of the axle."""


def predict_twist(
    wheel_inertia: float, wheel_spin: float, time: float, handles: float
) -> Twist:
    """Turn the wheel over in a time [s], with hands at a distance [m].

    The spin is positive if it is counterclockwise, seen from the right hand.
    """
    rate = math.pi / time
    # Eq. (4) for an axle that turns at a steady rate: Ω × H. I across the axle has no
    # effect.
    torque = rate * (wheel_inertia * abs(wheel_spin))
    low, high = ("right", "left") if wheel_spin > 0 else ("left", "right")
    turn_left = right_end_up = "no steady push"
    if wheel_spin:
        turn_left = f"the {low} hand pushes down, the {high} hand up"
        right_end_up = f"the {low} hand pushes forward, the {high} hand back"
    return Twist(
        why=_say("twist", "turns" if wheel_spin else "no_spin"),
        twist_rate=rate,
        torque=torque,
        force=torque / handles,
        momentum_change=2 * wheel_inertia * abs(wheel_spin),
        turn_left=turn_left,
        right_end_up=right_end_up,
    )


# --- a force on the tip ---


class Tip(Prediction, frozen=True, kw_only=True):
    """The motion of the rod's tip under a constant force on a rod at rest.

    The force is at right angles to the rod, which is at rest at the start.

    The ball is balanced. The motion is exact: it is that of a rod under a weight.
    """

    prediction: Literal["tip"] = "tip"
    speed: float | None = None
    """Of the tip, at right angles to rod and force, mean over a nutation [m/s]."""
    turning_rate: float | None = None
    """Rate at which the rod goes round the direction of the force, mean over a nutation
    [rad/s]."""
    torque: float
    """[N*m]"""
    angle_deg: float
    """From the force to the motion of the tip, counterclockwise if you look from the
    tip at the ball."""
    direction: str
    yields: float | None = None
    """Angle by which the rod follows the force, mean over a nutation [rad]."""
    greatest_yield: float
    """Largest angle by which the rod follows the force [rad]."""
    nutation_rate: float | None = None
    """[rad/s]"""
    acceleration: float
    """Of the tip at the start, along the force, F L²/I [m/s^2]."""
    estimate: float | None = None
    """F L²/(I_zz ω), the speed for a fast spin [m/s]."""
    estimate_error: float | None = None
    """Relative error of the estimate [1]."""


def predict_tip(
    force: float, length: float, inertia: float, spin: float, transverse_inertia: float
) -> Tip:
    """Pull the tip; a counterclockwise spin, seen from the tip, is positive."""
    torque = force * length
    top = Top(inertia=inertia, transverse_inertia=transverse_inertia, torque=torque)
    # The force replaces gravity: the rod is level if it is at right angles to the
    # force.
    nutation = motion.nutation(top, spin)
    missing = "speed, turning_rate, yields, nutation_rate, estimate, estimate_error"
    tip = Tip(
        torque=torque,
        greatest_yield=nutation.greatest_sag,
        acceleration=torque * length / transverse_inertia,
        why=_say("tip", "no_spin"),
        reason=f"{missing}: without spin the rod follows the force",
        angle_deg=0.0,
        direction="along the force",
    )
    if spin == 0:
        return tip
    speed = length * abs(nutation.sideways)
    fast_rate = float(horizontal_precession_rate(torque, spin, inertia))
    estimate = length * abs(fast_rate)
    error = estimate / speed - 1
    why = _say("tip", "turns")
    direction = "along the torque: at right angles to the force"
    if error > SLOW:
        why = f"{why} {_say('tip', 'slow')}"
        direction = (
            "at right angles to the force and also far along it: the spin is slow"
        )
    turning_rate = float(mean_precession_rate(top, spin))
    return replace(
        tip,
        why=why,
        reason="",
        speed=speed,
        turning_rate=abs(turning_rate),
        angle_deg=math.copysign(90.0, spin),
        direction=direction,
        yields=nutation.mean_sag,
        nutation_rate=2 * math.pi / nutation.period,
        estimate=estimate,
        estimate_error=error,
    )


# --- as text ---


class _Quantities(string.Formatter):
    """Formats of quantities, such as ``{spin:rate}`` and ``{pitch:angle}``."""

    def format_field(self, value: Any, format_spec: str) -> str:
        if format_spec == "rate":
            return f"{value / RPM:.4g} rpm ({value:.4g} rad/s)"
        if format_spec == "angle":
            return f"{math.degrees(value):.4g}° ({value:.3g} rad)"
        if format_spec == "small_torque":
            return f"{1e3 * value:.3g} mN·m"
        if format_spec == "percent":
            return f"{100 * value:.2g} %"
        return format(value, format_spec)


def prediction_text(answer: Precession | Earth | Platform | Twist | Tip) -> str:
    """Write a prediction as text: question, answer in words, and numbers."""
    quantities = _Quantities()
    lines = []
    values = {**answer.options, **asdict(answer)}
    values["why"] = textwrap.fill(
        answer.why, 76, initial_indent="  ", subsequent_indent="  "
    )
    values["table"] = _earth_table(answer) if isinstance(answer, Earth) else None
    for line in TEXTS[answer.prediction]["text"].splitlines():
        names = [name for _, name, _, _ in quantities.parse(line) if name]
        fields = [quantities.get_field(name, (), values)[0] for name in names]
        if None not in fields and "" not in fields:
            lines.append(quantities.vformat(line, (), values))
    if answer.notes:
        lines += ["", "Not given, so assumed:"]
        lines += [f"  {note}" for note in answer.notes]
    text = "\n".join(lines) + "\n"
    for name, words in TEXTS["names"].items():
        text = text.replace(name, words)
    return text
