"""Check the readings of a log before its fit.

The checks are about contradictions, copies, sizes, and stated errors without an effect.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from operator import attrgetter

import numpy as np
from msgspec import Struct

from gyrodata.base.errors import Diagnostic
from gyrodata.measurements import sources as parts
from gyrodata.measurements.measured import Measurements, timing_column, without_loads
from gyrodata.measurements.sources import spin_columns, values_of
from gyrodata.physics import RPM, Floats
from gyrodata.quantities.error_sources import WHOLE
from gyrodata.quantities.units import Uncertainty, from_si, parse_unit
from gyrodata.readings import Column, Place, Readings, roles

STEADIEST = 0.06
"""Standard uncertainty of a time that the steadiest hand stops [s]."""

NO_ACCIDENT = 0.05, 0.005
"""Rows are called identical if chance makes as many with less than this probability:
one pair, or several."""


def check(readings: Readings, measured: Measurements) -> list[Diagnostic]:
    """Make every check of the readings of a log."""
    readings = without_loads(readings)
    timing = timing_column(readings.columns)
    return [
        *_find_contradictions(readings, measured),
        *_find_unheard(readings, measured, timing),
        *_find_copies(readings, measured, timing),
    ]


def _find_contradictions(
    readings: Readings, measured: Measurements
) -> Iterator[Diagnostic]:
    """Name the rows in which a derived column disagrees.

    A derived column is a period, rate, torque, inertia or second spin.

    If most runs precess faster than they spin, two columns are exchanged, or a unit is
    wrong.
    """
    torque = np.abs(measured.torque)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        rate = 2 * np.pi * measured.turns / measured.time
        expected = {
            "mass": measured.mass,
            "position": np.abs(measured.position),
            "torque": torque,
            "spin": measured.spin,
            "force": torque / np.abs(measured.position),
            "time": measured.time,
            "turns": measured.turns,
            "angle": 2 * np.pi * measured.turns,
            "precession_period": measured.time / measured.turns,
            "precession_rate": rate,
            "spin_period": 2 * np.pi / measured.spin,
            "inertia": torque / (rate * measured.spin),
        }
    for column in (*readings.columns.values(), *readings.others):
        # These columns are always the readings themselves, unless there are two of
        # them.
        of_runs = column.role in (
            "mass",
            "position",
            "time",
        ) and column is readings.columns.get(column.role)
        if of_runs or column.role not in expected:
            continue
        # A row disagrees if it deviates by more than 5 % and two last digits.
        meant = np.abs(expected[column.role])
        with np.errstate(invalid="ignore"):
            gap = np.abs(np.abs(values_of(column)) - meant)
            wrong = (gap > np.maximum(0.05 * meant, 2 * np.array(column.steps))) & (
                meant > 0
            )
        if not wrong.any():
            continue
        # A reading that is used for several runs is compared once.
        there = np.flatnonzero(np.isfinite(gap))
        _, at = np.unique(np.array(column.spots)[there], return_index=True)
        once = np.sort(there[at])
        off = once[wrong[once]].tolist()
        if not off:
            continue
        ratio = abs(column.readings[off[0]].value or math.nan) / meant[off[0]]
        hint = "check the turns, the units and the arithmetic of this column"
        used = readings.columns.get(column.role)
        if used is not None and used.header != column.header:
            hint = (
                f'if this column is the {column.role}, and not "{used.header}": --map '
                f'{column.role}="{column.header}"'
            )
        names = ", ".join([readings.runs[i] for i in off[:6]]) + (
            ", …" if len(off) > 6 else ""
        )
        values = {
            "header": column.header,
            "ratio": ratio,
            "runs": f"run{'s' if len(off) > 1 else ''} {names}",
        }
        yield readings.say(
            "derived_column_disagrees", column.cell(off[0]), **values, hint=hint
        )
    fast = np.flatnonzero(np.abs(rate) > measured.spin)
    if 2 * len(fast) > len(measured.runs):
        column = spin_columns(readings)[0]
        values = {
            "header": column.header,
            "fast": len(fast),
            "runs": len(measured.runs),
        }
        yield readings.say(
            "precession_faster_than_spin", column.cell(int(fast[0])), **values
        )


def _find_unheard(
    readings: Readings, measured: Measurements, timing: Column
) -> list[Diagnostic]:
    """Name every stated ``u_…`` that has no effect, with the reason, unless it is zero."""
    columns, load, spins = (
        readings.columns,
        parts.load_role(readings.columns),
        spin_columns(readings),
    )
    no_mass = None if load == "mass" else f"the {load} is given, and no mass"
    no_law = "the log does not show how the spin falls, or the spin is read three times in each run"
    shows_law = len(spins) == 2 or (
        parts.read_once(spins) and measured.drag is not None
    )
    if parts.read_once(spins):
        no_delay = None
    elif len(spins) > 1:
        no_delay = "the spin is read more than once in each run"
    else:
        no_delay = "one spin is given for the whole log"
    has_ball = (
        "ball_mass" in readings.constants and "ball_diameter" in readings.constants
    )
    no_ball = None if has_ball else "ball_mass and ball_diameter are not both given"
    silent = {
        **_without_shared_runs(measured),
        "u_time_bias": "rates are given, not times of a stopwatch"
        if timing.role == "precession_rate"
        else None,
        "u_mass_scale": no_mass,
        "u_g": no_mass,
        "u_position_zero": None
        if load != "torque" and "position" in columns
        else "no position is read",
        "u_spin_delay": no_delay,
        "u_decay_exponent": None if shows_law else no_law,
        "u_ball_mass": no_ball,
        "u_ball_diameter": None if readings.position_from == "surface" else no_ball,
        "u_rod_length": None
        if readings.position_from == "tip"
        else "no position counts from the tip of the rod",
    }
    of_runs = *spins, *parts.told_by_period(columns, timing)
    read = {load, timing.role, "pitch", *map(attrgetter("role"), of_runs)}
    read |= {"position"} if load != "torque" else set()
    if timing.role == "time":
        read.add("turns" if "turns" in columns else "angle")
    read |= {"weight_diameter"} if load == "mass" else set()
    read |= {"spin_turns"} if spins[0].role == "spin_time" else set()
    if "pitch" in columns or readings.motion == "released":
        read |= {
            "transverse_inertia"
            if "transverse_inertia" in columns
            else "nutation_period"
        }
    read &= set(columns)
    whole_turns, found = (
        not (np.abs(measured.turns - np.round(measured.turns)) > WHOLE).any(),
        [],
    )
    for key, place in readings.stated_at.items():
        u = readings.uncertainties[key]
        base = key.removeprefix("u_")
        whole, is_read = timing.role == "time" and whole_turns and not u.relative, False
        for role in read:
            is_read |= (
                key in roles.u_keys(role)
                and roles.as_u_of(role, key, u) in dict(columns[role].stated).values()
            )
        if key in roles.SHARED_UNCERTAINTIES:
            why = silent.get(key)
        elif base in ("turns", "angle") and whole:
            why = "whole turns end where they began, so no mark is sighted"
        elif is_read:
            why = None
        elif base in read:
            why = f"every {base} has an uncertainty of its own"
        else:
            why = _why_not_read(base, columns, timing)
        if why is not None and u != Uncertainty():
            found.append(readings.say("uncertainty_not_used", place, key=key, why=why))
    return found


def _without_shared_runs(measured: Measurements) -> dict[str, str]:
    """Return why an error that runs share has no effect, if the log has no such runs."""
    reasons = {
        "position_set": 'the log does not say "# position_set: each run"',
        "screw_angle": "no run covers a part of a turn between two screws",
    }
    used = {source.name for source in measured.sources}
    return {f"u_{name}": why for name, why in reasons.items() if name not in used}


def _find_copies(
    readings: Readings, measured: Measurements, timing: Column
) -> list[Diagnostic]:
    """Warn of identical rows, unless the times are so coarse that they can agree by chance."""
    settings = list(
        zip(
            *[
                column.values
                for column in readings.columns.values()
                if column is not timing
            ],
            strict=True,
        )
    )
    if not measured.timed or len(set(zip(settings, timing.values, strict=True))) == len(
        settings
    ):
        return []
    runs_of: dict[int, list[int]] = {}
    for run, line in enumerate(measured.lines):
        runs_of.setdefault(line, []).append(run)
    alike: dict[object, dict[object, list[int]]] = {}
    for line, runs in runs_of.items():
        times = alike.setdefault(tuple(settings[run] for run in runs), {})
        times.setdefault(tuple(timing.values[run] for run in runs), []).append(line)
    copied = [
        lines for times in alike.values() for lines in times.values() if len(lines) > 1
    ]
    rows = [sum(map(len, times.values())) for times in alike.values()]
    copies, pairs = (
        sum(len(lines) - 1 for lines in copied),
        sum(n * (n - 1) // 2 for n in rows),
    )
    # Two readings of one time agree in their last digit with this chance, by the
    # steadiest hand.
    step = float(np.median(timing.steps))
    u = next(
        float(np.median(source.absolute))
        for source in measured.sources
        if source.name == "time"
    )
    chance = step / (
        2 * math.sqrt(math.pi) * math.hypot(min(u, STEADIEST), step / math.sqrt(12))
        or 1.0
    )
    if not step or copies <= pairs * chance or chance >= 1:
        return []
    # Chernoff's bound of the probability of this many among these pairs.
    others = pairs - copies
    power = copies * math.log(copies / (pairs * chance))
    power += others * math.log(others / (pairs * (1 - chance))) if others else 0.0
    if math.exp(-power) > NO_ACCIDENT[pairs > 1]:
        return []
    shown = "; ".join(
        f"lines {' and '.join(map(str, lines))}" for lines in copied[:6]
    ) + "; …" * (len(copied) > 6)
    return [readings.say("rows_identical", Place(copied[0][1], 1), lines=shown)]


def _why_not_read(role: str, columns: Mapping[str, Column], timing: Column) -> str:
    """Return the reason why the readings of a role, or their uncertainties, are not used."""
    if role == "inertia":
        return "I_zz is the result, and so is its uncertainty"
    if role in ("turns", "angle"):
        if timing.role != "time":
            return f"the log contains the {timing.role.replace('_', ' ')}, so no angle is sighted"
        return "the log also states the other one of u_turns and u_angle"
    if role == "transverse_inertia" and role in columns:
        return "the rod is level and steady, so the transverse inertia does not matter"
    if role in columns:
        return f"{role} is only compared with the readings"
    return f"there is no {role} in this log"


# --- the sizes of this lab ---


class Size(Struct, frozen=True):
    """Range of the readings of one role in this lab [SI unit]."""

    role: str
    possible: tuple[float, float]
    """A reading outside is impossible in this lab; all published logs are inside."""
    usual: tuple[float, float]
    """Nearly all logs are inside: gyro proposes the unit that brings a column into this
    range."""
    units: tuple[str, ...]


SPIN = Size(
    "spin",
    (10 * RPM, 60_000 * RPM),
    (60 * RPM, 10_000 * RPM),
    ("rpm", "Hz", "rad/s", "deg/s"),
)
TIME = Size("time", (0.3, 1800.0), (1.0, 600.0), ("s", "min", "ms"))
SIZES = (
    Size("mass", (8e-4, 5.0), (1e-3, 1.0), ("g", "kg", "mg", "oz")),
    Size("force", (8e-3, 20.0), (0.01, 10.0), ("N", "mN")),
    Size("position", (2e-3, 1.0), (0.02, 0.6), ("cm", "mm", "m")),
    SPIN,
    TIME,
)


def unit_within(readings: Readings, role: str, usual: tuple[float, float]) -> str:
    """Return another unit that brings a column into a usual range [SI unit].

    All readings of the column must be in the range. The result is "" if there is no
    such unit.
    """
    values = [abs(value) for value in readings.columns[role].values if value]
    for unit, factor in other_units(readings.columns[role]):
        if usual[0] <= factor * min(values) and factor * max(values) <= usual[1]:
            return unit
    return ""


def meant_in(readings: Readings, size: Size, run: int) -> tuple[str, float] | None:
    """Return the unit in which a reading equals that of another run, and its value.

    The value is in the [SI unit]. The result is None if there is no such unit.
    """
    values = [abs(value or 0.0) for value in readings.columns[size.role].values]
    for unit, factor in other_units(readings.columns[size.role]):
        value = factor * values[run]
        if any(math.isclose(value, other, rel_tol=0.02) for other in values if other):
            return unit, value
    return None


def other_units(column: Column) -> Iterator[tuple[str, float]]:
    """List the other units that a column may have in this lab.

    Each unit is listed with the factor on the values of the column.
    """
    kind = roles.kind_of_role(column.role)
    own = parse_unit(column.unit, kind).factor if column.unit else 1.0
    for unit in next((size.units for size in SIZES if size.role == column.role), ()):
        factor = parse_unit(unit, kind).factor / own
        if not math.isclose(factor, 1.0):
            yield unit, factor


def exchanged(readings: Readings, measured: Measurements) -> bool:
    """Return whether spin and time are possible only if the two columns are exchanged."""
    spins, times = readings.columns.get("spin"), readings.columns.get("time")
    if (
        spins is None
        or times is None
        or spins.unit != "rpm"
        or times.unit != "s"
        or not measured.torque.any()
    ):
        return False
    if min(spins.spots) < 0 or min(times.spots) < 0:
        return False
    spin, time = np.abs(values_of(spins)), np.abs(values_of(times))
    for size, values in ((SPIN, RPM * time), (TIME, 1 / RPM * spin)):
        if not ((size.usual[0] <= values) & (values <= size.usual[1])).all():
            return False
    loaded = measured.torque != 0
    each = np.abs(measured.torque / measured.product)[loaded]
    other = each * (measured.spin / RPM / measured.time)[loaded] ** 2
    odd = np.sum((spin < SPIN.possible[0]) | (spin > SPIN.possible[1])) > 1
    return spread(other) < (
        spread(each) + SCATTERS if odd else min(spread(each) / 4, 2 * SCATTERS)
    )


INSIDE = 0.04
"""A weight at such a distance from the centre is inside the ball [m]."""

SCATTERS = 0.03
"""A correction is rejected if the runs scatter by this much more after it [1]."""


def spread(each: Floats) -> float:
    """Return the relative spread of I_zz of the single runs [1], robust against one odd run."""
    logs = np.log(each)
    return float(np.median(np.abs(logs - np.median(logs))))


def check_sizes(readings: Readings, measured: Measurements) -> list[Diagnostic]:
    """Report readings that are impossible in this lab, and exchanged columns of spin and time."""
    if exchanged(readings, measured):
        spin, time = readings.columns["spin"], readings.columns["time"]
        told = {
            "first": spin.header,
            "second": time.header,
            "one": "spin [rpm]",
            "other": "time [s]",
        }
        return [readings.say("columns_exchanged", spin.place(0), **told)]
    found = []
    for size in SIZES:
        column, kind = readings.columns.get(size.role), roles.kind_of_role(size.role)
        values = np.abs(values_of(column)) if column else np.zeros(0)
        odd = np.flatnonzero(
            (values > 0)
            & ~((size.possible[0] <= values) & (values <= size.possible[1]))
        )
        if column is None or not len(odd):
            continue
        run, mass = int(odd[0]), readings.columns.get("mass")
        if size.role == "position" and mass and (mass.unit, column.unit) == ("g", "cm"):
            # 1 g is 1e-3 kg, and 1 cm is 1e-2 m. Positions in mm are as large, but none
            # is inside the ball.
            swapped = (
                (SIZES[0].usual, 0.1 * values),
                (size.usual, 10 * np.abs(values_of(mass))),
            )
            possible = all(
                ((low <= each) & (each <= high)).all() for (low, high), each in swapped
            )
            if possible and len(odd) > 1 and values.min() < 10 * INSIDE:
                names = {
                    "first": mass.header,
                    "second": column.header,
                    "one": "mass [g]",
                    "other": "position [cm]",
                }
                found.append(
                    readings.say("columns_exchanged", column.cell(run), **names)
                )
                continue
        unit = unit_within(readings, size.role, size.usual)
        own = column.unit or roles.to_display(1.0, size.role)[1]
        meant, there = (
            (unit, 0.0) if unit else meant_in(readings, size, run) or ("", 0.0)
        )
        sizes = float(values[run]), *size.possible, there
        value, low, high, near = [f"{from_si(si, own, kind):.4g} {own}" for si in sizes]
        words = {
            "role": size.role,
            "value": value,
            "low": low,
            "high": high,
            "unit": meant,
            "there": near,
        }
        if unit:
            name = "size_of_column"
        elif meant:
            name = "size_of_cell"
        else:
            name = "size_unusual"
        found.append(readings.say(name, column.cell(run), **words))
    if not 0.01 <= (diameter := readings.constants.get("ball_diameter", 0.1)) <= 0.5:
        words = {
            "role": "ball_diameter",
            "value": f"{100 * diameter:.4g} cm",
            "low": "1 cm",
            "high": "50 cm",
        }
        found.append(
            readings.say(
                "size_unusual", readings.stated_at.get("ball_diameter"), **words
            )
        )
    return found
