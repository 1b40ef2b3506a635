"""Known slips: what a mistake in a unit, an origin, a count or a column does to I_zz; and the sizes of this lab.

One table for both who make them: `gyro grade` looks for a slip in the arithmetic behind a reported value, and
`gyro analyze` for one in the log itself, where the ball says what I_zz should be.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from msgspec import Struct

from gyrodata.measurements import Measurements
from gyrodata.physics import RPM, Floats
from gyrodata.readings import Readings, kind_of_role
from gyrodata.units import parse_unit


class Kind(Struct, frozen=True):
    """One slip, applied to a log of n runs: what it makes of φ̇ψ̇ and M."""

    kind: str
    words: str = ""
    """What happened in the arithmetic, in words; "" where only a log can have it."""
    check: str = ""
    """How to check it, in words."""
    product: float | Floats = 1.0
    """What it multiplies φ̇ψ̇ of each run by, a number or shape (n,)."""
    torque: float | Floats = 1.0
    """What it multiplies M by."""
    forgets: str = ""
    """The quantity whose conversion was forgotten: two such make a likely pair; "" for the others."""
    rank: int = 0
    """0 for a common one that the log's own units allow, 1 for a rarer one, 2 for a plain power of ten."""
    log: str = ""
    """What happened in the log, in words; "" where only arithmetic can have it, or the log's units do not allow it."""
    remedy: str = ""
    """What to type in the log then."""


_SLOWEST = 30.0  # no rod is spun more slowly [rpm]

_FROM_CENTRE = "measure from the centre of the ball to the middle of the weight, and write that"


def _header(role: str, unit: str) -> str:
    return f'write the header as "{role} [{unit}]"'


# --- the table -------------------------------------------------------------------------------------------------


def list_kinds(readings: Readings, measured: Measurements, inertia: float) -> Iterator[Kind]:
    """All single slips that this log, and its I_zz [kg*m^2], allow."""
    yield from _of_rates(readings)
    if "mass" in readings.columns:
        yield from _of_loads(readings, measured.g)
    yield from _of_turns(measured)
    yield from _of_logs(readings, measured)
    yield Kind(
        "answer_in_g_cm2", "the answer is in g·cm², written as kg·m²",
        "1 g·cm² is 10⁻⁷ kg·m²", torque=1e7, rank=1,
    )  # fmt: skip
    for power in (-3, -2, -1, 1, 2, 3):
        yield Kind(
            f"power_of_ten_{power}", f"the decimal point is off by {abs(power)} place{'s' if abs(power) > 1 else ''}",
            "look at each power of ten on the way to the answer, and at the answer's own exponent",
            torque=10.0**power, rank=2,
        )  # fmt: skip
    yield from _of_answers(readings, measured, inertia)


def _of_rates(readings: Readings) -> Iterator[Kind]:
    unit = next((c.unit for role, c in readings.columns.items() if role.startswith("spin") and c.unit), "rpm")
    in_rpm, in_turns = unit == "rpm", unit in ("Hz", "rps")
    yield Kind(
        "rpm_as_rad_s", "the spin in rpm was used as if it were in rad/s",
        "ψ̇ [rad/s] = 2π/60 × rpm: 400 rpm are 41.9 rad/s", product=1 / RPM, forgets="spin", rank=0 if in_rpm else 1,
        log="the spins are in rpm, and the header says rad/s" * (unit == "rad/s"),
        remedy=_header("spin", "rpm"),
    )  # fmt: skip
    yield Kind(
        "rad_s_as_rpm", "the spin was turned from rpm into rad/s twice",
        "multiply rpm by 2π/60 once: 400 rpm are 41.9 rad/s", product=RPM, rank=0 if unit in ("rpm", "rad/s") else 1,
        log="the spins are in rad/s, and the header says rpm" * in_rpm, remedy=_header("spin", "rad/s"),
    )  # fmt: skip
    yield Kind(
        "minutes_as_seconds", "the spin was not divided by the 60 seconds of a minute",
        "ψ̇ [rad/s] = 2π/60 × rpm: 400 rpm are 41.9 rad/s", product=60.0, rank=0 if in_rpm else 1,
        log="the spins are in rpm, and the header says revolutions a second" * in_turns, remedy=_header("spin", "rpm"),
    )  # fmt: skip
    yield Kind(
        "two_pi_missing", "2π is missing: one of the two rates is in turns per second, not in rad/s",
        "φ̇ = 2π × turns/time, and ψ̇ [rad/s] = 2π × turns per second",
        product=1 / (2 * math.pi), forgets="" if in_turns else "precession",
        log="the spins are in revolutions a second, and the header says rad/s" * (unit == "rad/s"),
        remedy=_header("spin", "Hz"),
    )  # fmt: skip
    yield Kind(
        "two_pi_twice", "there is one 2π too many: a rate was multiplied by it twice",
        "φ̇ = 2π × turns/time, and ψ̇ [rad/s] = 2π/60 × rpm; each 2π once", product=2 * math.pi,
        log="the spins are in rad/s, and the header says revolutions a second" * in_turns,
        remedy=_header("spin", "rad/s"),
    )  # fmt: skip
    yield Kind(
        "two_pi_missing_in_both", "both rates are in turns per second, not in rad/s",
        "φ̇ = 2π × turns/time, and ψ̇ [rad/s] = 2π × turns per second", product=(2 * math.pi) ** -2,
    )  # fmt: skip
    yield Kind(
        "both_in_rpm", "both rates are in rpm, not in rad/s",
        "φ̇ and ψ̇ are needed in rad/s: 1 rpm is 2π/60 rad/s", product=RPM**-2, rank=0 if in_rpm else 1,
    )  # fmt: skip


def _of_loads(readings: Readings, g: float) -> Iterator[Kind]:
    mass_unit = readings.columns["mass"].unit
    yield Kind(
        "g_as_kg", "the masses in grams were used as kilograms",
        "a weight of 20 g is 0.020 kg", torque=1000.0, forgets="mass", rank=0 if mass_unit == "g" else 1,
        log="the masses are in grams, and the header says kg" * (mass_unit == "kg"), remedy=_header("mass", "g"),
    )  # fmt: skip
    yield Kind(
        "kg_as_g", "the masses were divided by 1000 once too often",
        "a weight of 20 g is 0.020 kg", torque=1e-3, rank=0 if mass_unit == "kg" else 1,
        log="the masses are in kilograms, and the header says g" * (mass_unit == "g"), remedy=_header("mass", "kg"),
    )  # fmt: skip
    length_unit = readings.columns["position"].unit if "position" in readings.columns else "cm"
    for unit, name in (("cm", "centimetres"), ("mm", "millimetres")):
        factor = 1 / parse_unit(unit, "length").factor
        yield Kind(
            f"{unit}_as_m", f"the positions in {name} were used as metres",
            f"15 {unit} are {15 / factor:g} m",
            torque=factor, forgets="position" if length_unit == unit else "", rank=0 if length_unit == unit else 1,
            log=f"the positions are in {name}, and the header says m" * (length_unit == "m"),
            remedy=_header("position", unit),
        )  # fmt: skip
    for kind, words, factor, rank in (
        ("mm_as_cm", "the positions in millimetres were used as centimetres", 10.0, 0 if length_unit == "mm" else 1),
        ("cm_as_mm", "the positions in centimetres were used as millimetres", 0.1, 1),
    ):
        read_as, meant = ("cm", "mm") if kind == "mm_as_cm" else ("mm", "cm")
        yield Kind(
            kind, words, "15 cm are 150 mm are 0.15 m", torque=factor, rank=rank,
            log=f"the positions are in {meant}, and the header says {read_as}" * (length_unit == read_as),
            remedy=_header("position", meant),
        )  # fmt: skip
    yield Kind(
        "missing_g", f"g is missing: m·x was used as the torque, without {g:.4g} m/s²",
        "M = m g x, in N·m", torque=1 / g, forgets="g",
    )  # fmt: skip
    yield Kind(
        "diameter_for_radius", "the arm is twice as long as it is: a whole length taken for half of it",
        "x goes from the centre of the ball to the weight", torque=2.0,
        log="the arm is written twice as long as it is", remedy=_FROM_CENTRE,
    )  # fmt: skip
    yield Kind(
        "radius_halved", "the arm is half as long as it is",
        "x goes from the centre of the ball to the weight, and is not halved", torque=0.5, rank=1,
        log="the arm is written half as long as it is", remedy=_FROM_CENTRE,
    )  # fmt: skip


def _of_turns(measured: Measurements) -> Iterator[Kind]:
    if np.all(measured.turns == 1):
        return
    yield Kind(
        "turns_forgotten", "the time was taken for a whole turn, whatever part of a turn was timed",
        "φ̇ = 2π × turns/time: 1/3 of a turn in 7 s is a period of 21 s", product=1 / measured.turns, forgets="turns",
    )  # fmt: skip
    yield Kind(
        "turns_upside_down", "the time was multiplied by the turns instead of divided by them",
        "the period is time/turns: 1/3 of a turn in 7 s is a period of 21 s", product=measured.turns**-2,
    )  # fmt: skip


def _of_answers(readings: Readings, measured: Measurements, inertia: float) -> Iterator[Kind]:
    """Slips that only the arithmetic can have: of an answer or a constant, after all conversions, or of two columns."""
    yield Kind(
        "sign", "there is a minus sign too many, and a moment of inertia is positive",
        "torque, spin and precession each have a sense; use magnitudes, or all three with their signs", torque=-1.0,
    )  # fmt: skip
    yield Kind(
        "degrees_per_second", "a rate is in degrees a second, not in rad/s",
        "a turn is 2π rad: φ̇ = 2π × turns/time", product=180 / math.pi,
    )  # fmt: skip
    yield Kind(
        "g_in_cm_s2", "g was taken in cm/s², 981, and all else in SI",
        "g is 9.81 m/s²", torque=100.0,
    )  # fmt: skip
    yield Kind(
        "cm2_as_m2", "the answer is in g·cm² (cgs), written as g·m², or in kg·cm², written as kg·m²",
        "1 cm² is 10⁻⁴ m²", torque=1e4, rank=1,
    )  # fmt: skip
    exponent = -math.floor(math.log10(abs(inertia)))
    if exponent:
        yield Kind(
            "exponent_lost", "the exponent of the answer is lost: the number stands without its power of ten",
            "write the power of ten behind the number, and the unit behind that", torque=10.0**exponent,
        )  # fmt: skip
        yield Kind(
            "exponent_sign_lost", "the sign of the exponent of the answer is lost",
            f"I_zz in kg·m² is {'below' if exponent > 0 else 'above'} 1: its exponent is "
            f"{'negative' if exponent > 0 else 'positive'}", torque=100.0**exponent,
        )  # fmt: skip
    if (_unit(readings, "spin"), _unit(readings, "time")) == ("rpm", "s"):
        spin, time = measured.spin / RPM, measured.time
        if np.all((spin < time) & (time > _SLOWEST)):
            yield Kind(
                "columns_exchanged", "the columns of time and spin are exchanged: each stands under the other's header",
                "a spin of some hundred rpm, a time of some seconds: put the two headers right",
                product=(time / spin) ** 2,
            )  # fmt: skip


INVERSE_SLOPE = Kind(
    "inverse_slope", "it is the inverse, 1/I_zz: the slope of φ̇ψ̇ over M",
    "plot M over φ̇ψ̇, or take one over the slope; its unit tells: 1/(kg·m²) is no moment of inertia",
)  # fmt: skip
"""The one that no factor makes of I_zz."""


def _of_logs(readings: Readings, measured: Measurements) -> Iterator[Kind]:
    """Slips that only a log can have."""
    spin, time, mass, position = (_unit(readings, role) for role in ("spin", "time", "mass", "position"))
    yield Kind(
        "counted_twice", product=2.0,
        log="every turn of the ball is counted twice, as with two strips of tape, or half turns of the rod are "
        "written as whole ones",
        remedy="look at the tape and at what was timed, then halve the spins or the turns",
    )  # fmt: skip
    yield Kind(
        "counted_half", product=0.5, rank=1,
        log="the tachometer misses every second turn, or two turns of the rod are written as one",
        remedy="look at the tape and at what was timed, then double the spins or the turns",
    )  # fmt: skip
    for role, own, unit, meant, factor in (
        ("spin", spin, "rpm", "Hz", 1 / 60),
        ("spin", spin, "rpm", "deg/s", 6.0),
        ("spin", spin, "deg/s", "rpm", 1 / 6),
        ("spin", spin, "Hz", "deg/s", 360.0),
        ("time", time, "s", "min", 60.0),
        ("time", time, "s", "ms", 1e-3),
        ("time", time, "min", "s", 1 / 60),
    ):
        if own == unit:
            words = f"the {role}s are in {meant}, and the header says {unit}"
            rank = int(role == "time")  # times in another unit are rarer, and of another size
            yield Kind(f"{meant}_as_{unit}", product=factor, log=words, remedy=_header(role, meant), rank=rank)
    for role, own, unit, meant in (
        ("mass", mass, "g", "mg"),
        ("mass", mass, "g", "oz"),
        ("mass", mass, "kg", "lb"),
        ("position", position, "cm", "m"),
        ("position", position, "mm", "m"),
        ("position", position, "cm", "inch"),
    ):
        if own == unit:
            kind = kind_of_role(role)
            # What is written is larger by this than what is meant.
            factor = parse_unit(unit, kind).factor / parse_unit(meant, kind).factor
            words = f"the {role}{'e' * (role == 'mass')}s are in {meant}, and the header says {unit}"
            yield Kind(f"{meant}_as_{unit}", torque=factor, log=words, remedy=_header(role, meant), rank=1)
    if mass == "kg":
        yield Kind(
            "N_as_kg", torque=measured.g, log="the weights are in newtons, and the header says kg",
            remedy='write the header as "force [N]"',
        )  # fmt: skip
    yield from _of_origin(readings, measured)
    yield from _of_counts(measured)
    if spin == "rpm" and time == "s":
        yield Kind(
            "exchanged", product=(measured.spin / RPM / measured.time) ** 2,
            log="the columns of spin and time are exchanged", remedy="exchange the headers of the two columns",
        )  # fmt: skip
    if "ball_diameter" in readings.constants:
        diameter = 100 * readings.constants["ball_diameter"]
        for kind, factor, is_, meant in (
            ("ball_radius", 0.25, "radius", "twice"),
            ("ball_twice", 4.0, "double", "half"),
        ):
            yield Kind(
                kind, product=factor, rank=1, log=f"what is written as the ball's diameter is its {is_}",
                remedy=f"write {meant} of it: # ball_diameter: {diameter / math.sqrt(factor):.5g} cm",
            )  # fmt: skip


def _of_origin(readings: Readings, measured: Measurements) -> Iterator[Kind]:
    """Arms measured from another point than the centre."""
    arm, diameter = np.abs(measured.position), readings.constants.get("ball_diameter")
    with np.errstate(all="ignore"):
        if diameter is not None:
            radius, shown = diameter / 2, f"{50 * diameter:.4g} cm"
            yield Kind(
                "arm_from_surface", "the arm was measured from the ball's surface, not from its centre",
                f"x goes from the centre of the ball to the weight: add the ball's radius, {shown}, to an arm that is "
                "measured from its surface",
                torque=np.where(measured.torque == 0, 1.0, np.where(arm > radius, (arm - radius) / arm, np.nan)),
            )  # fmt: skip
            yield Kind(
                "from_surface", torque=arm / (arm + radius),
                log="the arm is measured from the ball's surface, not from its centre",
                remedy=f"add the ball's radius, {shown}, to every position",
            )  # fmt: skip
            yield Kind(
                "radius_twice", torque=np.where(arm > radius, arm / (arm - radius), np.nan), rank=1,
                log="the ball's radius is added to an arm that is measured from its centre",
                remedy=f"take the ball's radius, {shown}, from every position",
            )  # fmt: skip
            yield Kind(
                "from_far_side", torque=np.where(arm > 2 * radius, arm / (arm - radius), np.nan), rank=2,
                log="the arm is measured from the far side of the ball",
                remedy=f"take the ball's radius, {shown}, from every position",
            )  # fmt: skip
        length = readings.constants.get("rod_length")
        if length is not None:
            from_tip = length + (diameter or 0.0) / 2 - arm
            yield Kind(
                "from_tip", torque=np.where(from_tip > 0, arm / from_tip, np.nan),
                log="the arm is measured from the rod's tip, not from the centre of the ball",
                remedy=_FROM_CENTRE,
            )  # fmt: skip


def _of_counts(measured: Measurements) -> Iterator[Kind]:
    """Turns that were written as something else."""
    if not measured.timed:
        return
    turns = measured.turns
    if np.all(turns > 20):
        yield Kind(
            "degrees_as_turns", product=360.0, log="the turns are degrees",
            remedy='write the header as "angle [deg]"',
        )  # fmt: skip
    if np.all(turns >= 2):
        yield Kind(
            "upside_down", product=turns**2, log="the turns are upside down: 1/3 of a turn is written as 3",
            remedy="write the part of a turn, such as 1/3",
        )  # fmt: skip
    for part, words in ((1 / 3, "1/3"), (2 / 3, "2/3")):
        if np.all(turns == 1):
            yield Kind(
                f"{words}_as_1", product=1 / part, log=f"{words} of a turn is timed, and the log says a whole one",
                remedy=f"write the turns as {words}", rank=int(part > 0.5),
            )  # fmt: skip
        if np.allclose(turns, part):
            yield Kind(
                f"1_as_{words}", product=part, log=f"whole turns are timed, and the log says {words}",
                remedy="write the turns as 1", rank=int(part > 0.5),
            )  # fmt: skip
    if np.allclose(turns, 1 / 3):
        yield Kind("2/3_as_1/3", product=0.5, log="2/3 of a turn is timed, and the log says 1/3",
                   remedy="write the turns as 2/3", rank=1)  # fmt: skip


def _unit(readings: Readings, role: str) -> str:
    column = readings.columns.get(role)
    return column.unit if column else ""


# --- what explains a log ---------------------------------------------------------------------------------------

CLOSE = 0.06
"""A slip explains a log if without it I_zz is nearer to what it should be than this share."""

SCATTERS = 0.03
"""A slip is none that leaves the runs scattered by so much more than they were [1]."""

MOST = 3
"""Slips that are told."""

START_SPIN = (0.75, 0.96)
"""I_zz over its true value [1] if the spin was read at the start of each run instead of at half time."""


def explaining_slips(
    readings: Readings, measured: Measurements, inertia: float, expected: float
) -> tuple[tuple[Kind, float], ...]:
    """Name the slips in a log that explain an I_zz, the likeliest first, with I_zz without each [kg*m^2].

    `inertia`, `expected`: I_zz as the log has it, and as it should be [kg*m^2].
    """
    loaded = measured.torque != 0
    each = np.abs(measured.torque / measured.product)[loaded]
    before = _scatter(each)
    found = []
    for kind in list_kinds(readings, measured, inertia):
        if not kind.log:
            continue
        factor = np.broadcast_to(np.asarray(kind.torque) / np.asarray(kind.product), measured.torque.shape)[loaded]
        mended = each / factor
        if not np.isfinite(mended).all() or _scatter(mended) > before + SCATTERS:
            continue
        value = inertia * float(np.median(mended) / np.median(each))
        away = abs(math.log(value / expected))
        if away < CLOSE:
            # Of two that are as near, the commoner one.
            found.append((away + 0.01 * kind.rank, kind, value))
    if START_SPIN[0] < inertia / expected < START_SPIN[1] and "spin" in readings.columns:
        words = f"the spin was read at the start, and was {100 * (1 - inertia / expected):.0f} % lower at half time"
        remedy = 'write spins read at half time, or the spin at start and end in columns "spin_start", "spin_end"'
        found.append((CLOSE, Kind("start_spin", log=words, remedy=remedy), expected))
    found.sort(key=lambda item: item[0])
    return tuple((kind, value) for _, kind, value in found[:MOST])


def _scatter(each: Floats) -> float:
    """Spread of I_zz of single runs as a share, robust against one that is odd."""
    logs = np.log(each)
    return float(np.median(np.abs(logs - np.median(logs))))


# --- the sizes of this lab --------------------------------------------------------------------------------------

INERTIA_RANGE = (1e-6, 1.0)
"""I_zz of what is spun on a table [kg*m^2]."""


class Size(Struct, frozen=True):
    """How large a reading of this lab is [SI unit]."""

    role: str
    possible: tuple[float, float]
    """What lies outside is not of this lab: every published log lies within."""
    usual: tuple[float, float]
    """Where nearly all logs lie: the unit that brings a column here is proposed."""
    units: tuple[str, ...]


SIZES = (
    Size("mass", (1e-4, 5.0), (1e-3, 1.0), ("g", "kg", "mg")),
    Size("position", (2e-3, 1.0), (0.02, 0.6), ("cm", "mm", "m")),
    Size("spin", (10 * RPM, 60_000 * RPM), (60 * RPM, 10_000 * RPM), ("rpm", "Hz", "rad/s", "deg/s")),
    Size("time", (0.3, 1800.0), (1.0, 600.0), ("s", "min", "ms")),
)


def far_off(readings: Readings, size: Size) -> tuple[int, str] | None:
    """Find the first run whose reading is not of this lab, and the unit that it would be in; None if all are."""
    column = readings.columns.get(size.role)
    if column is None:
        return None
    sizes = np.abs(np.array(column.values, dtype=float))
    sizes = np.where(sizes > 0, sizes, np.nan)
    far = np.flatnonzero((sizes < size.possible[0]) | (sizes > size.possible[1])).tolist()
    if not far:
        return None
    return far[0], unit_within(readings, size.role, size.usual)


def unit_within(readings: Readings, role: str, usual: tuple[float, float]) -> str:
    """Find the other unit that brings all readings of a column into a usual range [SI unit]; "" if none does."""
    column, kind = readings.columns[role], kind_of_role(role)
    values = [abs(value) for value in column.values if value]
    own = parse_unit(column.unit, kind).factor if column.unit else 1.0
    for unit in next(size.units for size in SIZES if size.role == role):
        factor = parse_unit(unit, kind).factor / own
        if unit != column.unit and usual[0] <= factor * min(values) and factor * max(values) <= usual[1]:
            return unit
    return ""


def meant_in(readings: Readings, size: Size, run: int) -> tuple[str, float] | None:
    """Find the unit in which a reading is what other runs read, and that [SI unit]; None where there is none."""
    column, kind = readings.columns[size.role], kind_of_role(size.role)
    others = [abs(value) for value in column.values if value]
    for unit in size.units:
        factor = parse_unit(unit, kind).factor / (parse_unit(column.unit, kind).factor if column.unit else 1.0)
        value = factor * abs(column.values[run] or 0.0)
        if not math.isclose(factor, 1.0) and any(math.isclose(value, other, rel_tol=0.02) for other in others):
            return unit, value
    return None


def exchanged(readings: Readings, measured: Measurements) -> bool:
    """Tell whether the numbers of spin and time make sense only the other way round."""
    if _unit(readings, "spin") != "rpm" or _unit(readings, "time") != "s" or not measured.torque.any():
        return False
    spins, times = (readings.columns[role] for role in ("spin", "time"))
    if min(spins.spots) < 0 or min(times.spots) < 0:
        return False
    sizes = {size.role: size for size in SIZES}
    for role, factor, values in (("spin", RPM, times.values), ("time", 1 / RPM, spins.values)):
        low, high = sizes[role].usual
        if not all(value and low <= factor * abs(value) <= high for value in values):
            return False
    each = np.abs(measured.torque / measured.product)[measured.torque != 0]
    other = each / (measured.spin / RPM / measured.time)[measured.torque != 0] ** -2
    low, high = sizes["spin"].possible
    odd = any(not low <= abs(value or 0.0) <= high for value in spins.values)
    return _scatter(other) < (_scatter(each) + SCATTERS if odd else _scatter(each) / 4)
