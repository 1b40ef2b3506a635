"""Predictions of theory for given numbers: the answers of ``gyro predict``, and their text.

The answers are in SI units, with None for what is not; ``reason`` says in words why what is None is None, and is ""
where nothing is. ``why`` answers in words for people. The text has rpm, seconds and degrees, with the SI unit beside.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

import msgspec
import numpy as np
from msgspec import Struct

from gyrodata import __version__, motion, physics
from gyrodata.physics import RPM

SCHEMA = "gyro.prediction/2"

ROUGH = 0.01
"""A closed form that is off by more than this [1] is told to be."""


# --- the rod under a weight ------------------------------------------------------------------------------------


class Released(Struct, frozen=True):
    """A rod let go from rest, by the exact motion."""

    mean_rate: float | None
    """Of precession [rad/s]."""
    sag: float
    """Angle below the start, mean over time [rad]; negative if the rod rises."""
    greatest_sag: float
    """The same at most [rad]."""
    nutation_rate: float | None
    """2π over the time from one moment of rest to the next [rad/s]."""
    click_error_s: float | None
    """How far ahead of its mean course the rod gets, or behind, at most [s]."""
    reason: str


class Sleeping(Struct, frozen=True):
    """An upright rod, the spin being the total one."""

    stable: bool
    critical_spin: float
    """Least spin to stay upright [rad/s]."""
    growth_rate: float
    """Of a small tilt [1/s]."""


class Precession(Struct, frozen=True):
    """Steady precession, what a rod let go from rest does instead, and whether an upright one stays."""

    why: str
    slow: float | None
    """Slow root of eq. (8) [rad/s]."""
    fast: float | None
    """Fast root of eq. (8) [rad/s]."""
    horizontal: float | None
    """Eq. (9) [rad/s]."""
    exists: bool
    critical_spin: float
    """Least spin for steady precession at this pitch [rad/s]."""
    period: float | None
    """Of the slow root [s]."""
    reason: str
    released: Released
    sleeping: Sleeping


def predict_precession(
    torque: float, spin: float, inertia: float, transverse_inertia: float, pitch: float = 0.0
) -> Precession:
    """Both roots of eq. (8), eq. (9), the rod let go from rest, and the upright one."""
    top = inertia, transverse_inertia, pitch
    slow = _finite(physics.precession_rate(torque, spin, *top))
    fast = _finite(physics.fast_precession_rate(torque, spin, *top))
    horizontal = _finite(physics.precession_rate(torque, spin, inertia))
    critical = float(physics.least_spin(torque, *top))
    sleeping = float(physics.sleeping_spin(torque, inertia, transverse_inertia))
    return Precession(
        why=_precession_why(torque, spin, slow is not None),
        slow=slow,
        fast=fast,
        horizontal=horizontal,
        exists=slow is not None,
        critical_spin=critical,
        period=2 * math.pi / abs(slow) if slow else None,
        reason=_why_none(slow, fast, horizontal, critical, inertia == transverse_inertia),
        released=_released(torque, spin, *top),
        sleeping=Sleeping(
            stable=abs(spin) > sleeping or torque < 0,
            critical_spin=sleeping,
            growth_rate=float(physics.sleeping_growth(torque, spin, inertia, transverse_inertia)),
        ),
    )


def _precession_why(torque: float, spin: float, steady: bool) -> str:
    if torque == 0:
        return "Without a torque the angular momentum stays as it is, and the rod stays where it points."
    if spin == 0:
        return "Without spin there is no angular momentum to turn aside: the rod swings like a pendulum."
    sense = "counterclockwise" if torque * spin > 0 else "clockwise"
    moves = "falls" if torque > 0 else "rises"
    never = "" if steady else " At this pitch the spin is too slow for a steady precession."
    return (
        "The torque is level and at right angles to the rod. The angular momentum of the spin lies along the rod, and "
        f"it changes the way the torque points: sideways. So the rod goes round, {sense} seen from above, instead of "
        f"following the weight.{never} Let go from rest, it first {moves}, gets its speed sideways from that, and "
        "comes back to rest at the height of its start, again and again: it nutates."
    )


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


def _released(torque: float, spin: float, inertia: float, across: float, pitch: float) -> Released:
    top = motion.Top(inertia, across, torque)
    nods = motion.nutation(top, spin, pitch)
    mean = motion.mean_precession_rate(top, spin, pitch) if torque and spin else 0.0
    reason = ""
    if spin == 0:
        reason = "mean_rate, nutation_rate, click_error_s: without spin it swings and does not precess"
    elif torque == 0:
        reason = "click_error_s: without a torque the rod stays where it points"
    return Released(
        mean_rate=_finite(mean) if spin else None,
        sag=nods.mean_sag + 0.0,
        greatest_sag=nods.greatest_sag + 0.0,
        nutation_rate=2 * math.pi / nods.period if spin else None,
        click_error_s=None if reason else nods.lead,
        reason=reason,
    )


# --- the Earth that turns below --------------------------------------------------------------------------------


class Direction(Struct, frozen=True):
    """Where a rod points at one time."""

    hours: float
    """Of the clock, since the start."""
    sidereal_hours: float
    azimuth_deg: float | None
    """From north through east; null straight up or down."""
    altitude_deg: float
    reason: str


class Earth(Struct, frozen=True):
    """Where two balanced gyroscopes point as the Earth turns under them."""

    why: str
    sidereal_day_hours: float
    pole: str
    """Pole of the sky above the horizon, "north" or "south", at which the first rod is pointed."""
    axis: tuple[Direction, ...]
    """Started along the Earth's axis."""
    east: tuple[Direction, ...]
    """Started level, towards the east."""
    drift_torque: float | None
    """Torque left over from the balance under which a level rod precesses as fast as the Earth turns [N*m]; null
    where inertia and spin are not given."""


def predict_earth(
    latitude: float, times: Sequence[float], inertia: float | None = None, spin: float | None = None
) -> Earth:
    """Two balanced gyroscopes at clock times since the start [s]."""
    pole, azimuth = ("north", 0.0) if latitude >= 0 else ("south", math.pi)
    return Earth(
        why=_earth_why(math.degrees(abs(latitude)), pole),
        sidereal_day_hours=physics.SIDEREAL_DAY / 3600,
        pole=pole,
        axis=_directions(azimuth, abs(latitude), latitude, times),
        east=_directions(math.pi / 2, 0.0, latitude, times),
        drift_torque=None if inertia is None or spin is None else inertia * abs(spin) * physics.EARTH_ROTATION,
    )


def _earth_why(latitude: float, pole: str) -> str:
    """Say which stars the rods follow; the latitude is in degrees, without its sign."""
    star = "the pole star" if pole == "north" else "the south pole of the sky, near which no bright star stands"
    side = "south" if pole == "north" else "north"
    top = round(90 - latitude, 1)
    level = (
        f"is highest after 6 sidereal hours, {f'in the {side} at {top:g}°' if top < 90 else 'straight overhead'}, sets "
        "in the west after 12, and is back in the east after 24, which are 23 h 56 min of the clock. From the 12th to "
        "the 24th hour it points below the horizon, where the cup is in the way of a real rod."
        if top
        else f"goes round the horizon by way of the {side}, once in 23 h 56 min."
    )
    return (
        "No torque acts on a balanced gyroscope. So its angular momentum, and the rod with it, keeps its direction "
        f"among the stars, while the ground turns. The first rod points along the Earth's axis, at {star}. That place "
        "in the sky does not move, and neither does the rod. The second rod points at a star on the eastern horizon "
        f"and follows it over the sky: it {level}"
    )


def _directions(azimuth: float, altitude: float, latitude: float, times: Sequence[float]) -> tuple[Direction, ...]:
    bearings, heights = physics.balanced_direction(azimuth, altitude, latitude, np.asarray(times, dtype=float))
    return tuple(
        Direction(
            hours=time / 3600,
            sidereal_hours=24 * time / physics.SIDEREAL_DAY,
            azimuth_deg=_finite(math.degrees(bearing)),
            altitude_deg=math.degrees(height),
            reason="azimuth_deg: it points straight up or down" if math.isnan(bearing) else "",
        )
        for time, bearing, height in zip(times, bearings.tolist(), heights.tolist(), strict=True)
    )


# --- a wheel in the hands --------------------------------------------------------------------------------------


class Platform(Struct, frozen=True):
    """A turntable at rest, on which someone tips a spinning wheel."""

    why: str
    rate: float
    """Of the platform, positive in the sense that the wheel has with its axle up [rad/s]."""
    period: float | None
    """Of the platform [s]."""
    momentum_before: float
    """Of the wheel about the vertical [kg*m^2/s]."""
    momentum_after: float
    """The same, after [kg*m^2/s]."""
    momentum_platform: float
    """Of the platform with all on it, after [kg*m^2/s]."""
    reason: str


def predict_platform(
    wheel_inertia: float, wheel_spin: float, platform_inertia: float, start: float, end: float
) -> Platform:
    """Tip the axle from one angle above the horizontal to another [rad]."""
    rate = float(physics.platform_rate(wheel_inertia, wheel_spin, platform_inertia, start, end)) + 0.0
    wheel = wheel_inertia * wheel_spin
    return Platform(
        why=_platform_why(rate, wheel),
        rate=rate,
        period=2 * math.pi / abs(rate) if rate else None,
        momentum_before=wheel * math.sin(start) + 0.0,
        momentum_after=wheel * math.sin(end) + 0.0,
        momentum_platform=platform_inertia * rate,
        reason="" if rate else "period: the platform stays at rest",
    )


def _platform_why(rate: float, wheel: float) -> str:
    if wheel == 0:
        return "A wheel that does not spin has no angular momentum to pass on, so the platform stays at rest."
    if rate == 0:
        return (
            "The wheel has the same angular momentum about the vertical before and after, so there is none left for "
            "the platform, and it stays at rest."
        )
    return (
        "To tip the axle, your hands put a torque on the wheel, and this changes the wheel's angular momentum about "
        "the vertical. The wheel puts the opposite torque on your hands, and so on you and on the platform. About the "
        "vertical no other torque acts, because the platform turns freely: all angular momentum together stays the "
        "same, and the platform gains what the wheel loses."
    )


class Twist(Struct, frozen=True):
    """Predict the torque of a spinning wheel, level in both hands, that is turned over at a steady rate."""

    why: str
    twist_rate: float
    """[rad/s]"""
    torque: float
    """Of the hands on the wheel, its size [N*m]."""
    force: float
    """At each hand, one the opposite of the other [N]."""
    momentum_change: float
    """Of the wheel, once it is turned over [kg*m^2/s]."""
    turn_left: str
    """What the hands do to turn the axle counterclockwise seen from above."""
    right_end_up: str
    """What they do to tip it, the right end up."""


def predict_twist(wheel_inertia: float, wheel_spin: float, time: float, handles: float) -> Twist:
    """Turn the wheel over in a time [s], the hands so far apart [m].

    The spin is positive counterclockwise for who looks from the right hand at the wheel.
    """
    rate = math.pi / time
    # Eq. (4) for the axle along e3, which turns about e2. I across the axle has no say at a steady rate.
    body, frame = np.array([0.0, rate, wheel_spin]), np.array([0.0, rate, 0.0])
    change = physics.momentum_change(body, np.zeros(3), frame, wheel_inertia, wheel_inertia)
    torque = float(np.linalg.norm(change))
    turned, tipped = "nothing lasting", "nothing lasting"
    if wheel_spin:
        low, high = ("right", "left") if wheel_spin > 0 else ("left", "right")
        turned = f"the {low} hand pushes down, the {high} hand up"
        tipped = f"the {low} hand pushes forward, the {high} hand back"
    return Twist(
        why=_twist_why(wheel_spin),
        twist_rate=rate,
        torque=torque,
        force=torque / handles,
        momentum_change=2 * wheel_inertia * abs(wheel_spin),
        turn_left=turned,
        right_end_up=tipped,
    )


def _twist_why(spin: float) -> str:
    if spin == 0:
        return (
            "A wheel that does not spin has no angular momentum to turn: only to start it and to stop it do the hands "
            "push, and along the way they go."
        )
    return (
        "The angular momentum of the wheel, I ω, lies along the axle. Turned with the axle at a rate Ω, it changes at "
        "right angles to itself, and that takes a torque Ω × I ω from your hands. So they push at right angles to the "
        "way the axle goes, and you feel the wheel push back. Twice the spin or twice the speed of the twist is twice "
        "the force; the other sense of either turns it round. A turn about the axle itself takes none."
    )


# --- a force on the tip ----------------------------------------------------------------------------------------


class Tip(Struct, frozen=True):
    """Predict the motion of the rod's tip under a constant force; the rod is at rest at first, across the force.

    For a balanced ball, by the exact motion, which is that of a rod under a weight.
    """

    why: str
    speed: float | None
    """Of the tip, at right angles to rod and force, mean over a nutation [m/s]."""
    turning_rate: float | None
    """How fast the rod goes round the direction of the force, mean over a nutation [rad/s]."""
    torque: float
    """[N*m]"""
    angle_deg: float
    """From the force to the way the tip goes, counterclockwise for who looks from the tip at the ball."""
    direction: str
    yields: float | None
    """Angle by which the rod gives way to the force, mean over a nutation [rad]."""
    greatest_yield: float
    """The same at most [rad]."""
    nutation_rate: float | None
    """[rad/s]"""
    acceleration: float
    """Of the tip at the start, along the force, F L²/I [m/s^2]."""
    estimate: float | None
    """F L²/(I_zz ω), which is the speed where the spin is fast [m/s]."""
    estimate_error: float | None
    """By how much that is too high [1]."""
    reason: str


def predict_tip(force: float, length: float, inertia: float, spin: float, transverse_inertia: float) -> Tip:
    """Pull across the rod; the spin is positive counterclockwise for who looks from the tip at the ball."""
    torque = force * length
    top = motion.Top(inertia, transverse_inertia, torque)
    # The force in the place of gravity: the rod is level where it is across the force.
    nods = motion.nutation(top, spin)
    acceleration = torque * length / transverse_inertia
    if spin == 0:
        return Tip(
            why="Without spin the rod has no angular momentum. What the torque of the force gives to it points across "
            "rod and force, so the rod turns the way it is pulled, faster and faster. Any force moves it, however "
            "small; without one a balanced rod keeps pointing where it points.",
            speed=None,
            turning_rate=None,
            torque=torque,
            angle_deg=0.0,
            direction="along the force",
            yields=None,
            greatest_yield=nods.greatest_sag,
            nutation_rate=None,
            acceleration=acceleration,
            estimate=None,
            estimate_error=None,
            reason="speed, turning_rate, yields, nutation_rate, estimate, estimate_error: without spin it follows the "
            "force",
        )
    speed = length * abs(nods.sideways)
    estimate = length * abs(float(physics.horizontal_precession_rate(torque, spin, inertia)))
    error = estimate / speed - 1
    slow = "" if error <= ROUGH else " The spin here is too slow for that: the rod also follows the force, far."
    return Tip(
        why="The force has a torque about the ball's centre, L F, at right angles to rod and force. The angular "
        "momentum I_zz ω lies along the rod and changes the way the torque points. So the tip goes at right angles to "
        "the force. Twice the force moves it twice as fast; twice the spin, half as fast: what spins fast is hard to "
        f"turn, and that is why gyroscopes for navigation are set spinning.{slow}",
        speed=speed,
        turning_rate=abs(float(motion.mean_precession_rate(top, spin))),
        torque=torque,
        angle_deg=math.copysign(90.0, spin),
        direction="along the torque: across the force, a quarter turn ahead of it in the sense of the spin"
        if nods.greatest_sag < math.pi / 4
        else "across the force and far along it: so slow a spin does not hold the rod",
        yields=nods.mean_sag,
        greatest_yield=nods.greatest_sag,
        nutation_rate=2 * math.pi / nods.period,
        acceleration=acceleration,
        estimate=estimate,
        estimate_error=error,
        reason="",
    )


# --- as JSON and as text ---------------------------------------------------------------------------------------

Answer = Precession | Earth | Platform | Twist | Tip

ANSWERS: dict[str, type[Struct]] = {
    "earth": Earth,
    "platform": Platform,
    "tip": Tip,
    "precession": Precession,
    "twist": Twist,
}
"""What each subcommand answers with."""


def document(name: str, options: Mapping[str, Any], notes: Sequence[str], answer: Answer) -> dict[str, Any]:
    """Put an answer into the object that is written out."""
    return {
        "schema": SCHEMA,
        "tool": {"name": "gyrodata", "version": __version__},
        "prediction": name,
        "options": dict(options),
        "notes": list(notes),
        **msgspec.to_builtins(answer),
    }


def prediction_text(options: Mapping[str, Any], notes: Sequence[str], answer: Answer) -> str:
    """Write a prediction as text: what is asked, the answer in words, and the numbers."""
    match answer:
        case Precession():
            first, *lines = _precession_text(options, answer)
        case Earth():
            first, *lines = _earth_text(options, answer)
        case Platform():
            first, *lines = _platform_text(options, answer)
        case Twist():
            first, *lines = _twist_text(options, answer)
        case Tip():
            first, *lines = _tip_text(options, answer)
    words = textwrap.wrap(answer.why, 76, initial_indent="  ", subsequent_indent="  ")
    taken = ["", "not given, so taken:", *(f"  {note}" for note in notes)] if notes else []
    return "\n".join([first, *words, "", *lines, *taken]) + "\n"


def _rate(value: float) -> str:
    return f"{value / RPM:.4g} rpm ({value:.4g} rad/s)"


def _angle(value: float) -> str:
    return f"{math.degrees(value):.3g}° ({value:.3g} rad)"


def _line(label: str, text: str) -> str:
    return f"  {label:<16}{text}"


def _precession_text(options: Mapping[str, Any], told: Precession) -> list[str]:
    pitch, spin = f"{math.degrees(options['pitch']):.4g}°", _rate(options["spin"])
    lines = [f"steady precession at pitch {pitch}, spin {spin}, torque {options['torque']:.4g} N·m"]
    if told.slow is not None:
        turn = f", one turn in {told.period:.4g} s" if told.period else ""
        lines.append(_line("slow, eq. (8)", _rate(told.slow) + turn))
    if told.fast is not None:
        lines.append(_line("fast, eq. (8)", _rate(told.fast)))
    if told.horizontal is not None:
        lines.append(_line("level, eq. (9)", _rate(told.horizontal)))
    lines.append(_line("least spin", f"{_least(told.critical_spin)} for steady precession at this pitch"))
    lines += _lacking(told.reason)
    return [*lines, "", *_released_text(told.released), "", *_sleeping_text(told.sleeping)]


def _released_text(told: Released) -> list[str]:
    lines = ["let go from rest"]
    if told.mean_rate is not None:
        lines.append(_line("mean rate", _rate(told.mean_rate)))
    moves, size = ("rises by", -1) if told.greatest_sag < 0 else ("sags by", 1)
    sag = f"{_angle(size * told.sag)} on average, {_angle(size * told.greatest_sag)} at most"
    lines.append(_line(moves, sag))
    if told.nutation_rate is not None:
        lines.append(_line("nutates at", _rate(told.nutation_rate)))
    if told.click_error_s is not None:
        lines.append(_line("click error", f"up to {told.click_error_s:.2g} s, by the phase of the nutation"))
    return [*lines, *_lacking(told.reason)]


def _lacking(reason: str) -> list[str]:
    """Say what is None, and why."""
    return [
        f"  no {clause.replace('click_error_s', 'click error').replace('_', ' ')}"
        for clause in reason.split("; ")
        if clause
    ]


def _sleeping_text(told: Sleeping) -> list[str]:
    lines = ["rod upright, at this spin"]
    if told.stable:
        lines.append(_line("stays", "a small tilt does not grow"))
    elif told.growth_rate:
        lines.append(_line("falls", f"a small tilt grows e-fold in {1 / told.growth_rate:.3g} s"))
    else:
        lines.append(_line("drifts", "nothing holds it"))
    return [*lines, _line("least spin", f"{_least(told.critical_spin)} to stay")]


def _least(spin: float) -> str:
    return _rate(spin) if spin else "any"


def _earth_text(options: Mapping[str, Any], told: Earth) -> list[str]:
    latitude = math.degrees(options["latitude"])
    lines = [f"balanced gyroscopes at latitude {latitude:.4g}°, from the ground, which turns under them"]
    if told.drift_torque is not None:
        lines.append("A torque left over from the balance that turns a level rod as fast as the Earth turns:")
        lines += [_line("torque", f"{1e3 * told.drift_torque:.3g} mN·m at a spin of {_rate(options['spin'])}"), ""]
    axis, east = f"{told.pole}: azimuth", "east: azimuth"
    lines += [
        f"{told.pole}: started along the Earth's axis; east: started level. Azimuth: from north through east.",
        f"  {'hours':>8}{'sidereal':>10}{axis:>17}{'altitude':>10}{east:>16}{'altitude':>10}",
    ]
    for one, other in zip(told.axis, told.east, strict=True):
        cells = f"  {one.hours:>8.4f}{one.sidereal_hours:>10.4f}"
        cells += f"{_bearing(one):>17}{_height(one):>10}{_bearing(other):>16}{_height(other):>10}"
        lines.append(cells)
    return lines


def _bearing(row: Direction) -> str:
    return "-" if row.azimuth_deg is None else f"{round(row.azimuth_deg, 2) % 360:.2f}°"


def _height(row: Direction) -> str:
    # No "-0.00".
    return f"{round(row.altitude_deg, 2) + 0.0:.2f}°"


def _platform_text(options: Mapping[str, Any], told: Platform) -> list[str]:
    start, end = (math.degrees(options[name]) for name in ("from", "to"))
    lines = [f"axle tipped from {start:.4g}° to {end:.4g}° above the horizontal, the platform at rest before"]
    if told.period:
        sense = "in" if told.rate * options["wheel_spin"] > 0 else "against"
        lines.append(_line("platform", f"{_rate(abs(told.rate))}, one turn in {told.period:.4g} s"))
        lines.append(_line("sense", f"{sense} that of the wheel when its axle points up"))
    else:
        lines.append(_line("platform", "stays at rest"))
    lines.append(_line("inertia", f"{options['platform_inertia']:.4g} kg·m² of platform, person and wheel"))
    lines.append("")
    lines.append("angular momentum about the vertical, which stays the same [kg·m²/s]")
    lines.append(_line("before", f"wheel {told.momentum_before:.4g}"))
    after = f"wheel {told.momentum_after:.4g}, platform {told.momentum_platform:.4g}"
    return [*lines, _line("after", after)]


def _twist_text(options: Mapping[str, Any], told: Twist) -> list[str]:
    seen = "counterclockwise" if options["wheel_spin"] >= 0 else "clockwise"
    spin = f"{_rate(abs(options['wheel_spin']))} {seen} seen from your right hand"
    return [
        f"a level wheel, {spin}, turned over in {options['time']:.4g} s",
        _line("twist", f"{_rate(told.twist_rate)}, half a turn"),
        _line("torque", f"{told.torque:.4g} N·m"),
        _line("force", f"{told.force:.4g} N at each hand, {100 * options['handles']:.4g} cm apart"),
        _line("body turns left", told.turn_left),
        _line("right end up", told.right_end_up),
        _line("I ω changes by", f"{told.momentum_change:.4g} kg·m²/s in all, however fast"),
    ]


def _tip_text(options: Mapping[str, Any], told: Tip) -> list[str]:
    at = f"{100 * options['length']:.4g} cm from the centre, spin {_rate(options['spin'])}"
    lines = [f"a force of {options['force']:.4g} N across the rod, {at}"]
    if told.speed is not None:
        lines.append(_line("tip", f"{100 * told.speed:.4g} cm/s ({told.speed:.4g} m/s)"))
    lines.append(_line("direction", told.direction))
    if told.turning_rate is not None:
        lines.append(_line("rod turns at", _rate(told.turning_rate)))
    lines.append(_line("torque", f"{told.torque:.4g} N·m"))
    if told.yields is not None and told.nutation_rate is not None:
        lines.append(_line("gives way by", f"{_angle(told.yields)} on average, {_angle(told.greatest_yield)} at most"))
        lines.append(_line("nutates at", _rate(told.nutation_rate)))
    lines.append(_line("at first", f"{told.acceleration:.4g} m/s² along the force, F L²/I, whatever the spin"))
    if told.estimate is not None and told.estimate_error is not None:
        speed, error = f"{100 * told.estimate:.4g} cm/s", told.estimate_error
        judged = f"{speed}, {100 * error:.2g} % too high"
        if error > ROUGH:
            judged = f"{speed}: not for so slow a spin, {_times(error)}"
        lines.append(_line("F L²/(I_zz ω)", judged))
    return lines


def _times(error: float) -> str:
    return f"{100 * error:.2g} % too high" if error < 1 else f"{1 + error:.3g} times too high"
