"""Predictions of theory for given numbers: the answers of ``gyro predict``, and their text.

The answers are in SI units. A value that does not exist is None, and ``reason`` contains the cause.
"""

from __future__ import annotations

import math
import string
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
from msgspec import Struct
from msgspec.structs import asdict

from gyrodata import motion, physics
from gyrodata.physics import RPM
from gyrodata.results import Tool

SLOW = 0.01
"""The formula for a fast spin is called unsuitable if its relative error exceeds this value [1]."""


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


# --- the rod under a weight ------------------------------------------------------------------------------------


class Released(Struct, frozen=True):
    """A rod that is released from rest, by the exact motion."""

    mean_rate: float | None
    """Mean precession rate [rad/s]."""
    sag: float
    """Angle below the start, mean over time [rad]; negative if the rod rises."""
    greatest_sag: float
    """Largest angle below the start [rad]; negative if the rod rises."""
    nutation_rate: float | None
    """2π over the time from one moment of rest to the next [rad/s]."""
    click_error_s: float | None
    """Largest time by which the rod is ahead of its mean motion, or behind it [s]."""
    reason: str
    """Names of the values that are null, with the cause."""


class Sleeping(Struct, frozen=True):
    """An upright rod with this total spin."""

    stable: bool
    critical_spin: float
    """Minimum spin to stay upright [rad/s]."""
    growth_rate: float
    """Growth rate of a small tilt [1/s]."""


class Precession(Prediction, frozen=True, kw_only=True):
    """Steady precession, the motion of a rod that is released from rest, and the stability of an upright rod."""

    prediction: Literal["precession"] = "precession"
    slow: float | None
    """Slow root of eq. (8) [rad/s]."""
    fast: float | None
    """Fast root of eq. (8) [rad/s]."""
    horizontal: float | None
    """Eq. (9) [rad/s]."""
    exists: bool
    """True if steady precession is possible."""
    critical_spin: float
    """Minimum spin for steady precession at this pitch [rad/s]."""
    period: float | None
    """Period of the slow root [s]."""
    released: Released
    sleeping: Sleeping


def predict_precession(
    torque: float, spin: float, inertia: float, transverse_inertia: float, pitch: float
) -> Precession:
    """Compute both roots of eq. (8), eq. (9), the motion after a release from rest, and the upright rod."""
    top = inertia, transverse_inertia, pitch
    slow = _finite(physics.precession_rate(torque, spin, *top))
    fast = _finite(physics.fast_precession_rate(torque, spin, *top))
    horizontal = _finite(physics.precession_rate(torque, spin, inertia))
    critical = float(physics.least_spin(torque, *top))
    upright = float(physics.sleeping_spin(torque, inertia, transverse_inertia))
    reasons = []
    if slow is None:
        cause = (
            f"the spin is below the minimum of {critical / RPM:.4g} rpm" if critical else "without spin the rod falls"
        )
        reasons.append(f"slow, fast, period: {cause}")
    elif fast is None:
        which = "with I = I_zz" if inertia == transverse_inertia else "that is level"
        reasons.append(f"fast: a rod {which} has only the slow precession")
    if slow == 0:
        reasons.append("period: without a torque the rod keeps its direction")
    if horizontal is None:
        reasons.append("horizontal: a level rod that does not spin falls")
    return Precession(
        why=_precession_why(torque, spin, slow is not None),
        reason="; ".join(reasons),
        slow=slow,
        fast=fast,
        horizontal=horizontal,
        exists=slow is not None,
        critical_spin=critical,
        period=2 * math.pi / abs(slow) if slow else None,
        released=_released(torque, spin, *top),
        sleeping=Sleeping(
            stable=abs(spin) > upright or torque < 0,
            critical_spin=upright,
            growth_rate=float(physics.sleeping_growth(torque, spin, inertia, transverse_inertia)),
        ),
    )


def _precession_why(torque: float, spin: float, steady: bool) -> str:
    if torque == 0:
        return "Without a torque the angular momentum does not change, and the rod keeps its direction."
    if spin == 0:
        return "Without spin the rod has no angular momentum along its axis: it swings like a pendulum."
    sense = "counterclockwise" if torque * spin > 0 else "clockwise"
    never = "" if steady else "At this pitch the spin is too slow for steady precession. "
    return (
        "The torque is horizontal and at right angles to the rod. The angular momentum of the spin points along the "
        f"rod, and the torque changes it sideways. So the rod goes round, {sense} seen from above, instead of "
        f"following the weight. {never}If the rod is released from rest, it first {'falls' if torque > 0 else 'rises'} "
        "and gains speed sideways. Then it returns to the height of its start, again and again: it nutates."
    )


def _finite(value: Any) -> float | None:
    """Return a number without the sign of zero; None if theory has no number."""
    return float(value) + 0.0 if math.isfinite(value) else None


def _released(torque: float, spin: float, inertia: float, across: float, pitch: float) -> Released:
    top = motion.Top(inertia, across, torque)
    nutation = motion.nutation(top, spin, pitch)
    mean = motion.mean_precession_rate(top, spin, pitch) if torque and spin else 0.0
    reason = ""
    if spin == 0:
        reason = "mean_rate, nutation_rate, click_error_s: without spin the rod swings and does not precess"
    elif torque == 0:
        reason = "click_error_s: without a torque the rod keeps its direction"
    return Released(
        mean_rate=_finite(mean) if spin else None,
        sag=nutation.mean_sag + 0.0,
        greatest_sag=nutation.greatest_sag + 0.0,
        nutation_rate=2 * math.pi / nutation.period if spin else None,
        click_error_s=None if reason else nutation.lead,
        reason=reason,
    )


# --- the rotation of the Earth ---------------------------------------------------------------------------------


class Direction(Struct, frozen=True):
    """The direction of a rod at one time."""

    hours: float
    """Time of the clock since the start [h]."""
    sidereal_hours: float
    azimuth_deg: float | None
    """From north through east; null straight up or down."""
    altitude_deg: float
    reason: str


class Earth(Prediction, frozen=True, kw_only=True):
    """The directions of two balanced gyroscopes while the Earth rotates below them."""

    prediction: Literal["earth"] = "earth"
    sidereal_day_hours: float
    pole: str
    """Pole of the sky above the horizon, "north" or "south", to which the first rod points."""
    axis: tuple[Direction, ...]
    """Started along the Earth's axis."""
    east: tuple[Direction, ...]
    """Started level, towards the east."""
    drift_torque: float | None
    """Residual torque that turns a level rod as fast as the Earth rotates [N*m]."""


def predict_earth(latitude: float, times: Sequence[float], inertia: float, spin: float) -> Earth:
    """Compute the directions of two balanced gyroscopes at clock times since the start [s]."""
    pole, azimuth = ("north", 0.0) if latitude >= 0 else ("south", math.pi)
    return Earth(
        why=_earth_why(math.degrees(abs(latitude)), pole),
        sidereal_day_hours=physics.SIDEREAL_DAY / 3600,
        pole=pole,
        axis=_directions(azimuth, abs(latitude), latitude, times),
        east=_directions(math.pi / 2, 0.0, latitude, times),
        drift_torque=inertia * abs(spin) * physics.EARTH_ROTATION,
    )


def _earth_why(latitude: float, pole: str) -> str:
    """Describe the paths of the rods; the latitude is in degrees, without its sign."""
    star = "the pole star" if pole == "north" else "the south pole of the sky"
    side = "south" if pole == "north" else "north"
    top = round(90 - latitude, 1)
    path = f"goes round the horizon by way of the {side}, once in 23 h 56 min."
    if top:
        highest = f"in the {side} at {top:g}°" if top < 90 else "straight overhead"
        path = (
            f"is highest after 6 sidereal hours, {highest}. It sets in the west after 12 hours and returns to the east "
            "after 24, which are 23 h 56 min of the clock. From the 12th to the 24th hour it points below the horizon, "
            "where the cup stops a real rod."
        )
    return (
        "No torque acts on a balanced gyroscope. So its angular momentum, and the rod with it, keeps its direction "
        "among the stars, while the ground turns. The first rod points along the Earth's axis, to "
        f"{star}. That place in the sky does not move, so the rod does not move either. The second rod points to a "
        f"star on the eastern horizon and follows it over the sky: it {path}"
    )


def _directions(azimuth: float, altitude: float, latitude: float, times: Sequence[float]) -> tuple[Direction, ...]:
    bearings, heights = physics.balanced_direction(azimuth, altitude, latitude, np.asarray(times, dtype=float))
    return tuple(
        Direction(
            hours=time / 3600,
            sidereal_hours=24 * time / physics.SIDEREAL_DAY,
            azimuth_deg=_finite(math.degrees(bearing)),
            altitude_deg=math.degrees(height),
            reason="azimuth_deg: the rod points straight up or down" if math.isnan(bearing) else "",
        )
        for time, bearing, height in zip(times, bearings.tolist(), heights.tolist(), strict=True)
    )


def _earth_table(earth: Earth) -> str:
    axis, east = f"{earth.pole}: azimuth", "east: azimuth"
    lines = [f"  {'hours':>7}{'sidereal':>10}{axis:>17}{'altitude':>10}{east:>16}{'altitude':>10}"]
    for row, other in zip(earth.axis, earth.east, strict=True):
        line = f"  {row.hours:>7.2f}{row.sidereal_hours:>10.3f}"
        for one, width in ((row, 17), (other, 16)):
            # No "360.00" and no "-0.00".
            azimuth = "-" if one.azimuth_deg is None else f"{round(one.azimuth_deg, 2) % 360:.2f}°"
            line += f"{azimuth:>{width}}{round(one.altitude_deg, 2) + 0.0:>9.2f}°"
        lines.append(line)
    return "\n".join(lines)


# --- a wheel in the hands --------------------------------------------------------------------------------------


class Platform(Prediction, frozen=True, kw_only=True):
    """A turntable at rest on which a person tips a spinning wheel."""

    prediction: Literal["platform"] = "platform"
    rate: float
    """Of the platform, counterclockwise seen from above is positive [rad/s]."""
    period: float | None
    """Of the platform [s]."""
    momentum_before: float
    """Angular momentum of the wheel about the vertical, before [kg*m^2/s]."""
    momentum_after: float
    """Angular momentum of the wheel about the vertical, after [kg*m^2/s]."""
    momentum_platform: float
    """Angular momentum of the platform with everything on it, after [kg*m^2/s]."""


def predict_platform(
    wheel_inertia: float, wheel_spin: float, platform_inertia: float, start: float, end: float
) -> Platform:
    """Tip the axle from one angle above the horizontal to another [rad]."""
    rate = float(physics.platform_rate(wheel_inertia, wheel_spin, platform_inertia, start, end)) + 0.0
    wheel = wheel_inertia * wheel_spin
    why = (
        "To tip the axle, your hands exert a torque on the wheel, and this changes the wheel's angular momentum about "
        "the vertical. The wheel exerts the opposite torque on your hands, and so on you and the platform. There is no "
        "other torque about the vertical, because the platform turns freely. So the total angular momentum does not "
        "change, and the platform gains what the wheel loses."
    )
    if wheel == 0:
        why = "A wheel that does not spin has no angular momentum, so the platform stays at rest."
    elif rate == 0:
        why = "The wheel's angular momentum about the vertical does not change, so the platform stays at rest."
    return Platform(
        why=why,
        reason="" if rate else "period: the platform stays at rest",
        rate=rate,
        period=2 * math.pi / abs(rate) if rate else None,
        momentum_before=wheel * math.sin(start) + 0.0,
        momentum_after=wheel * math.sin(end) + 0.0,
        momentum_platform=platform_inertia * rate,
    )


class Twist(Prediction, frozen=True, kw_only=True):
    """The torque of a spinning wheel with a level axle that both hands turn over at a steady rate."""

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


def predict_twist(wheel_inertia: float, wheel_spin: float, time: float, handles: float) -> Twist:
    """Turn the wheel over in a time [s], with the hands at this distance from each other [m].

    The spin is positive if it is counterclockwise, seen from the right hand.
    """
    rate = math.pi / time
    # Eq. (4) for the axle along e3, which turns about e2. I across the axle has no effect at a steady rate.
    body, frame = np.array([0.0, rate, wheel_spin]), np.array([0.0, rate, 0.0])
    change = physics.momentum_change(body, np.zeros(3), frame, wheel_inertia, wheel_inertia)
    torque = float(np.linalg.norm(change))
    low, high = ("right", "left") if wheel_spin > 0 else ("left", "right")
    why = (
        "The angular momentum of the wheel, I ω, points along the axle. If the axle turns at a rate Ω, the angular "
        "momentum changes at right angles to itself, and this needs a torque Ω × I ω from your hands. So they push at "
        "right angles to the motion of the axle, and you feel that the wheel pushes back. With twice the spin, or a "
        "twist that is twice as fast, the force is twice as large. If one of the two is reversed, the force is "
        "reversed. A rotation about the axle itself needs no torque."
    )
    if wheel_spin == 0:
        why = (
            "A wheel that does not spin has no angular momentum along the axle. Your hands push only to start and to "
            "stop the axle, in the direction in which it moves."
        )
    return Twist(
        why=why,
        twist_rate=rate,
        torque=torque,
        force=torque / handles,
        momentum_change=2 * wheel_inertia * abs(wheel_spin),
        turn_left=f"the {low} hand pushes down, the {high} hand up" if wheel_spin else "no steady push",
        right_end_up=f"the {low} hand pushes forward, the {high} hand back" if wheel_spin else "no steady push",
    )


# --- a force on the tip ----------------------------------------------------------------------------------------


class Tip(Prediction, frozen=True, kw_only=True):
    """The motion of the rod's tip under a constant force at right angles to a rod that is at rest at the start.

    The ball is balanced. The motion is exact: it is that of a rod under a weight.
    """

    prediction: Literal["tip"] = "tip"
    speed: float | None
    """Of the tip, at right angles to rod and force, mean over a nutation [m/s]."""
    turning_rate: float | None
    """Rate at which the rod goes round the direction of the force, mean over a nutation [rad/s]."""
    torque: float
    """[N*m]"""
    angle_deg: float
    """From the force to the motion of the tip, counterclockwise if you look from the tip at the ball."""
    direction: str
    yields: float | None
    """Angle by which the rod follows the force, mean over a nutation [rad]."""
    greatest_yield: float
    """Largest angle by which the rod follows the force [rad]."""
    nutation_rate: float | None
    """[rad/s]"""
    acceleration: float
    """Of the tip at the start, along the force, F L²/I [m/s^2]."""
    estimate: float | None
    """F L²/(I_zz ω), the speed for a fast spin [m/s]."""
    estimate_error: float | None
    """Relative error of the estimate [1]."""


def predict_tip(force: float, length: float, inertia: float, spin: float, transverse_inertia: float) -> Tip:
    """Pull the tip; the spin is positive if it is counterclockwise, seen from the tip."""
    torque = force * length
    top = motion.Top(inertia, transverse_inertia, torque)
    # The force replaces gravity: the rod is level if it is at right angles to the force.
    nutation = motion.nutation(top, spin)
    speed = estimate = error = None
    if spin:
        speed = length * abs(nutation.sideways)
        estimate = length * abs(float(physics.horizontal_precession_rate(torque, spin, inertia)))
        error = estimate / speed - 1
    why = (
        "The force exerts a torque about the ball's centre, L F, at right angles to rod and force. The angular "
        "momentum I_zz ω points along the rod and changes in the direction of the torque. So the tip moves at right "
        "angles to the force. With twice the force it moves twice as fast, with twice the spin half as fast. This is "
        "why gyroscopes for navigation spin fast: they are hard to turn."
    )
    direction = "along the torque: at right angles to the force"
    if spin == 0:
        direction = "along the force"
        why = (
            "Without spin the rod has no angular momentum along its axis. The angular momentum that it gains from the "
            "torque is at right angles to rod and force, so the rod moves along the force, faster and faster. Any "
            "force moves it, however small. Without a force a balanced rod keeps its direction."
        )
    elif error is not None and error > SLOW:
        why += " Here the spin is too slow for this rule: the rod also follows the force, far."
        direction = "at right angles to the force and also far along it: the spin is slow"
    return Tip(
        why=why,
        reason=""
        if spin
        else "speed, turning_rate, yields, nutation_rate, estimate, estimate_error: without spin "
        "the rod follows the force",
        speed=speed,
        turning_rate=abs(float(motion.mean_precession_rate(top, spin))) if spin else None,
        torque=torque,
        angle_deg=math.copysign(90.0, spin) if spin else 0.0,
        direction=direction,
        yields=nutation.mean_sag if spin else None,
        greatest_yield=nutation.greatest_sag,
        nutation_rate=2 * math.pi / nutation.period if spin else None,
        acceleration=torque * length / transverse_inertia,
        estimate=estimate,
        estimate_error=error,
    )


# --- as text ---------------------------------------------------------------------------------------------------

TEXTS = {
    "precession": """\
Steady precession at a pitch of {pitch:angle}, a spin of {spin:rate} and a torque of {torque:.4g} N·m
{why}

  slow, eq. (8)   {slow:rate}, one turn in {period:.4g} s
  fast, eq. (8)   {fast:rate}
  level, eq. (9)  {horizontal:rate}
  minimum spin    {critical_spin:rate} for steady precession at this pitch
  no value        {reason}

Released from rest
  mean rate       {released.mean_rate:rate}
  sag             {released.sag:angle} on average, {released.greatest_sag:angle} at most; negative: the rod rises
  nutation        {released.nutation_rate:rate}
  click error     up to {released.click_error_s:.2g} s, depending on the phase of the nutation
  no value        {released.reason}

Upright rod with this spin
  minimum spin    {sleeping.critical_spin:rate} to stay upright
  growth          a small tilt grows at a rate of {sleeping.growth_rate:.3g} per second
""",
    "earth": """\
Balanced gyroscopes at latitude {latitude:angle}, seen from the ground
{why}

  residual torque {drift_torque:small_torque} turns a level rod as fast as the Earth rotates, at {spin:rate}

{pole}: started along the Earth's axis; east: started level. Azimuth: from north through east.
{table}
""",
    "platform": """\
A wheel on a platform at rest is tipped from {from:angle} to {to:angle} above the horizontal
{why}

  platform        {rate:rate}, one turn in {period:.4g} s; positive: counterclockwise seen from above
  no value        {reason}
  inertia         {platform_inertia:.4g} kg·m² of platform, person and wheel

Angular momentum about the vertical
  before          wheel {momentum_before:.4g} kg·m²/s
  after           wheel {momentum_after:.4g} kg·m²/s, platform {momentum_platform:.4g} kg·m²/s
""",
    "twist": """\
A level wheel is turned over in {time:.4g} s; seen from your right hand its counterclockwise spin is {wheel_spin:rate}
{why}

  twist           {twist_rate:rate}, half a turn
  torque          {torque:.4g} N·m
  force           {force:.4g} N at each hand, {handles:.4g} m apart
  body turns left {turn_left}
  right end up    {right_end_up}
  I ω changes by  {momentum_change:.4g} kg·m²/s in total, at any rate of the twist
""",
    "tip": """\
A force of {force:.4g} N at right angles to the rod, {length:.4g} m from the centre, with a spin of {spin:rate}
{why}

  tip             {speed:.4g} m/s
  direction       {direction}
  rod turns at    {turning_rate:rate}
  torque          {torque:.4g} N·m
  follows force   {yields:angle} on average, {greatest_yield:angle} at most
  nutation        {nutation_rate:rate}
  at first        {acceleration:.4g} m/s² along the force, F L²/I, with any spin
  F L²/(I_zz ω)   {estimate:.4g} m/s, {estimate_error:percent} too high
  no value        {reason}
""",
}
"""The text of each prediction. A line is left out if one of its values does not exist."""


class _Quantities(string.Formatter):
    """Formats of quantities for people, such as ``{spin:rate}`` and ``{pitch:angle}``."""

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
    """Write a prediction as text: the question, the answer in words, and the numbers."""
    quantities, lines = _Quantities(), []
    values = {**answer.options, **asdict(answer)}
    values["why"] = textwrap.fill(answer.why, 76, initial_indent="  ", subsequent_indent="  ")
    values["table"] = _earth_table(answer) if isinstance(answer, Earth) else None
    for line in TEXTS[answer.prediction].splitlines():
        fields = [name for _, name, _, _ in quantities.parse(line) if name]
        if all(quantities.get_field(name, (), values)[0] not in (None, "") for name in fields):
            lines.append(quantities.vformat(line, (), values))
    if answer.notes:
        lines += ["", "Not given, so assumed:", *(f"  {note}" for note in answer.notes)]
    return "\n".join(lines) + "\n"
