"""Check the readings of a log before its fit.

The checks are about contradictions, copies, sizes, and stated errors without an effect.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata.base.errors import Diagnostic
from gyrodata.measurements.measured import Measurements, without_loads
from gyrodata.measurements.sources import (
    REVOLUTION,
    list_sources,
    spin_columns,
    timing_column,
    values_of,
)
from gyrodata.physics import RPM, Floats, Integers
from gyrodata.quantities.units import Uncertainty, parse_unit
from gyrodata.readings import Column, Place, Readings, roles
from gyrodata.readings.lablog import Faults, listing


def check(readings: Readings, measured: Measurements) -> list[Diagnostic]:
    """Make every check of the readings of a log."""
    readings = without_loads(readings)
    timing = timing_column(readings.columns)
    return [
        *_find_contradictions(readings, measured),
        *_find_unused_uncertainties(readings, measured),
        *_find_copies(readings, measured, timing),
    ]


# --- derived columns ---


@np.errstate(divide="ignore", invalid="ignore", over="ignore")
def derived_values(runs: Measurements) -> dict[str, Floats]:
    """Return what columns contain that also follow from other readings, by their role.

    The values [SI unit of the role] have the shape (n,).
    """
    return {
        "mass": runs.mass,
        "position": runs.position,
        "torque": runs.torque,
        "force": runs.torque / runs.position,
        "spin": runs.spin,
        "spin_period": REVOLUTION / runs.spin,
        "time": runs.time,
        "turns": runs.turns,
        "angle": REVOLUTION * runs.turns,
        "precession_period": runs.time / runs.turns,
        "precession_rate": runs.precession_rate,
        "inertia": runs.single_inertia,
    }


def _find_contradictions(
    readings: Readings, measured: Measurements
) -> Iterator[Diagnostic]:
    """Name the rows in which a column next to the readings disagrees with them.

    Such a column is a period, rate, torque, inertia or second spin.
    """
    # The mean spin is corrected; another reading agrees with itself.
    used = spin_columns(readings)
    values = derived_values(measured)
    for column in (*readings.columns.values(), *readings.others):
        is_used = any(column is each for each in used)
        if column.role in values and not is_used:
            yield from _compare(readings, measured, column, values[column.role])


def _compare(
    readings: Readings, measured: Measurements, column: Column, derived: Floats
) -> Iterator[Diagnostic]:
    """Compare a column with the values that follow from the readings, shape (n,)."""
    meant = np.abs(derived)
    first, mean = _means_of_cells(column, measured, meant)
    values = np.abs(values_of(column))[first]
    limit = np.maximum(0.05 * mean, 2 * np.array(column.steps)[first])
    wrong = np.flatnonzero(np.abs(values - mean) > limit)
    if not len(wrong):
        return
    yield readings.say(
        "derived_column_disagrees",
        column.cell(int(first[wrong[0]])),
        header=column.header,
        ratio=(values / mean)[wrong[0]],
        lines=[measured.lines[run] for run in first[wrong]],
        role=column.role,
    )


def _means_of_cells(
    column: Column, measured: Measurements, meant: Floats
) -> tuple[Integers, Floats]:
    """Return the first run of each cell in each row, and the mean of `meant` there.

    A cell has several runs in a row with repeats: the mean of t1, t2 and t3.
    """
    compared = np.flatnonzero(np.isfinite(meant) & (meant > 0))
    places = np.array([column.spots, measured.lines])[:, compared]
    _, first, cells = np.unique(places, axis=1, return_index=True, return_inverse=True)
    cells = cells.ravel()
    return compared[first], np.bincount(cells, meant[compared]) / np.bincount(cells)


# --- uncertainties without an effect ---


def _find_unused_uncertainties(
    readings: Readings, measured: Measurements
) -> Iterator[Diagnostic]:
    """Name every stated ``u_…`` without an effect and its reason, if not zero."""
    used = _used_without_source(readings, measured)
    sizes = _sizes_of_errors(readings, measured)
    for key, place in readings.stated_at.items():
        if key in used or readings.uncertainties[key] == Uncertainty():
            continue
        if _sizes_of_errors(_without(key, readings), measured) == sizes:
            why = _why_not_used(key, readings)
            yield readings.say("uncertainty_not_used", place, key=key, why=why)


def _used_without_source(readings: Readings, measured: Measurements) -> set[str]:
    """Return the keys that are used, but not for a source of error."""
    used = {"u_imbalance"}
    if measured.timed:
        used.add("u_time_bias")
    if {"ball_mass", "ball_diameter"} <= readings.constants.keys():
        used |= {"u_ball_mass", "u_ball_diameter"}
    if readings.position_from in roles.ORIGIN_LENGTHS:
        length, *_ = roles.ORIGIN_LENGTHS[readings.position_from]
        used.add(f"u_{length}")
    return used


def _without(key: str, readings: Readings) -> Readings:
    """Return a log that does not state the uncertainty of a key."""
    columns = dict(readings.columns)
    for role, column in readings.columns.items():
        if key in roles.u_keys(role):
            u = roles.as_u_of(role, key, readings.uncertainties[key])
            cells = [replace(r, u=None) if r.u == u else r for r in column.readings]
            columns[role] = replace(column, readings=tuple(cells))
    uncertainties = dict(readings.uncertainties)
    del uncertainties[key]
    return replace(readings, columns=columns, uncertainties=uncertainties)


def _sizes_of_errors(readings: Readings, measured: Measurements) -> list[Any]:
    """Return the names and sizes of the errors of a log, for a comparison."""
    return [
        (source.name, source.default, *source.absolute, *source.relative)
        for source in list_sources(readings, measured)
    ]


NO_MASS = "the force or the torque is given, and no mass"
NO_BALL = "ball_mass and ball_diameter are not both given"

WHY_NOT_USED = {
    "u_inertia": "I_zz is the result, and so is its uncertainty",
    "u_time_bias": "rates are given, not times of a stopwatch",
    "u_mass_scale": NO_MASS,
    "u_g": NO_MASS,
    "u_turns": "no part of a turn is timed, or the log states u_angle",
    "u_angle": "no part of a turn is timed, or the log states u_turns",
    "u_spin_delay": "the spin is read more than once in each run, or one spin is given "
    "for the whole log",
    "u_transverse_inertia": "the rod is level and steady, so the transverse inertia "
    "does not matter",
    "u_position_zero": "no position is read",
    "u_screw_angle": "no run covers a part of a turn between two screws",
    "u_decay_exponent": "the log does not show how the spin falls, or the spin is read "
    "three times in each run",
    "u_ball_mass": NO_BALL,
    "u_ball_diameter": NO_BALL,
    "u_rod_length": "no position counts from the tip of the rod",
    "u_position_set": 'the log does not say "# position_set: each run"',
}
"""Why a stated uncertainty can be without an effect, if it is not the usual reason."""


def _why_not_used(key: str, readings: Readings) -> str:
    """Return the reason why a stated uncertainty has no effect."""
    role = key.removeprefix("u_")
    if key in WHY_NOT_USED:
        return WHY_NOT_USED[key]
    if role not in readings.columns:
        return f"there is no {role} in this log"
    if len(readings.columns[role].stated) < len(readings.runs):
        return f"{role} is only compared with the readings"
    return f"every {role} has an uncertainty of its own"


# --- copies ---

STEADIEST = 0.06
"""Standard uncertainty of a time that the steadiest hand stops [s]."""

NO_ACCIDENT = 0.05, 0.005
"""Rows are called identical if chance makes as many with less than this probability:
one pair, or several."""


def _find_copies(
    readings: Readings, measured: Measurements, timing: Column
) -> Iterator[Diagnostic]:
    """Warn of identical rows, unless coarse times can agree by chance."""
    if not measured.timed:
        return
    columns = readings.columns.values()
    others = [column.values for column in columns if column is not timing]
    # A row can contain repeats of one setting.
    settings: defaultdict[int, tuple[Any, ...]] = defaultdict(tuple)
    times: defaultdict[int, tuple[Any, ...]] = defaultdict(tuple)
    cells = zip(measured.lines, timing.values, *others, strict=True)
    for line, time, *setting in cells:
        settings[line] += (*setting,)
        times[line] += (time,)
    lines_of: defaultdict[object, list[int]] = defaultdict(list)
    for line in settings:
        lines_of[settings[line], times[line]].append(line)
    copies = len(settings) - len(lines_of)
    alike = Counter(settings.values())
    pairs = sum([math.comb(count, 2) for count in alike.values()])
    chance = _chance_of_equal_times(measured, timing)
    if copies and _is_no_accident(copies, pairs, chance):
        yield _say_copied(readings, lines_of.values())


def _say_copied(readings: Readings, groups: Iterable[list[int]]) -> Diagnostic:
    """Name the lines of identical rows."""
    copied = [lines for lines in groups if len(lines) > 1]
    # Of joined logs, it names each line in its own file.
    where = Faults(readings.name, sheets=readings.sheets)
    shown = [where.span(lines).replace(", ", " and ") for lines in copied]
    place = Place(copied[0][1], 1)
    return readings.say("rows_identical", place, lines=listing(shown))


def _chance_of_equal_times(measured: Measurements, timing: Column) -> float:
    """Return the probability that a steady hand reads the same time twice [1]."""
    step = float(np.median(timing.steps))
    u = min(measured.time_u or STEADIEST, STEADIEST)
    spread = math.hypot(u, step / math.sqrt(12))
    # Without digits nobody knows how coarse the times are: they may all be equal.
    if step:
        return step / (2 * math.sqrt(math.pi) * spread)
    return 1.0


def _is_no_accident(copies: int, pairs: int, chance: float) -> bool:
    """Return whether as many equal pairs are improbable if each is so with a chance.

    The probability is limited by Chernoff's bound.
    """
    expected = pairs * chance
    if chance >= 1 or copies <= expected:
        return False
    power = copies * math.log(copies / expected)
    if others := pairs - copies:
        power += others * math.log(others / (pairs - expected))
    return math.exp(-power) <= NO_ACCIDENT[pairs > 1]


# --- the sizes of this lab ---


class Size(Struct, frozen=True):
    """Range of the readings of one role in this lab [SI unit]."""

    possible: tuple[float, float]
    """A reading outside is impossible in this lab; all published logs are inside."""
    usual: tuple[float, float]
    """Nearly all logs are inside: gyro proposes the unit that brings a column into this
    range."""
    units: tuple[str, ...]


SPIN = Size(
    (10 * RPM, 60_000 * RPM), (60 * RPM, 10_000 * RPM), ("rpm", "Hz", "rad/s", "deg/s")
)
TIME = Size((0.3, 1800.0), (1.0, 600.0), ("s", "min", "ms"))
SIZES: Mapping[str, Size] = {
    "mass": Size((8e-4, 5.0), (1e-3, 1.0), ("g", "kg", "mg", "oz")),
    "force": Size((8e-3, 20.0), (0.01, 10.0), ("N", "mN")),
    "position": Size((2e-3, 1.0), (0.02, 0.6), ("cm", "mm", "m")),
    "spin": SPIN,
    "time": TIME,
}
"""The ranges by role."""


def possible_range(role: str) -> tuple[float, float]:
    """Return the smallest and the largest possible reading of a role [SI unit]."""
    return SIZES[role].possible if role in SIZES else (-math.inf, math.inf)


def unit_within(readings: Readings, role: str, usual: tuple[float, float]) -> str:
    """Return another unit that brings a column into a usual range [SI unit].

    Each reading must be possible, and nine in ten must be in the range; all of them if
    that is so already without another unit. The result is "" if there is no such unit.
    """
    values = sorted(abs(value) for value in readings.columns[role].values if value)
    few = len(values) // 10
    least = values[few]
    most = values[-1 - few]
    is_usual = _is_within(usual, np.array([least, most]))
    limits = usual if is_usual else possible_range(role)
    for unit, factor in other_units(readings.columns[role]):
        all_values = factor * np.array(values)
        most_values = factor * np.array([least, most])
        if _is_within(limits, all_values) and _is_within(usual, most_values):
            return unit
    return ""


def other_units(column: Column) -> Iterator[tuple[str, float]]:
    """List the other units that a column may have in this lab.

    Each unit is listed with the factor on the values of the column.
    """
    kind = roles.kind_of_role(column.role)
    units = SIZES[column.role].units if column.role in SIZES else ()
    for unit in units:
        factor = parse_unit(unit, kind).factor / unit_size(column)
        if not math.isclose(factor, 1.0):
            yield unit, factor


def unit_size(column: Column) -> float:
    """Return one unit of a column [SI unit]; 1 for a column of numbers."""
    kind = roles.kind_of_role(column.role)
    return parse_unit(column.unit, kind).factor if column.unit else 1.0


def exchanged(readings: Readings) -> bool:
    """Return whether spin and time are possible only if they are exchanged."""
    spins = readings.columns.get("spin")
    times = readings.columns.get("time")
    if spins is None or times is None or (spins.unit, times.unit) != ("rpm", "s"):
        return False
    # A value of the whole log is in no column.
    is_stated = min(*spins.spots, *times.spots) < 0
    seconds = np.abs(values_of(spins)) / RPM
    rpm = np.abs(values_of(times))
    # In a minute a ball turns more often than a rod needs seconds for a timed angle.
    is_slow = (seconds < rpm).all()
    are_usual = _is_within(TIME.usual, seconds) and _is_within(SPIN.usual, rpm * RPM)
    return bool(is_slow) and are_usual and not is_stated


def _is_within(limits: tuple[float, float], values: Floats) -> bool:
    """Return whether all values are between two limits."""
    low, high = limits
    return bool(((low <= values) & (values <= high)).all())


def check_sizes(readings: Readings) -> list[Diagnostic]:
    """Report readings that are impossible in this lab, and exchanged columns."""
    if exchanged(readings):
        spin = readings.columns["spin"]
        time = readings.columns["time"]
        say = readings.say(
            "columns_exchanged", spin.place(0), first=spin.header, second=time.header
        )
        return [say]
    questions = []
    for role, size in SIZES.items():
        column = readings.columns.get(role)
        if column is not None:
            sizes = np.abs(values_of(column))
            low, high = size.possible
            odd = np.flatnonzero((sizes > high) | (sizes > 0) & (sizes < low))
            if len(odd):
                questions.append(_say_size(readings, column, size, int(odd[0])))
    return questions


def _say_size(readings: Readings, column: Column, size: Size, run: int) -> Diagnostic:
    """Say that a reading of a column is impossible, and propose another unit."""
    unit = unit_within(readings, column.role, size.usual)
    values = abs(column.values[run] or 0.0), *size.possible
    value, low, high = [
        f"{value / unit_size(column):.4g} {column.unit}" for value in values
    ]
    return readings.say(
        "size_of_column" if unit else "size_unusual",
        column.cell(run),
        role=column.role,
        value=value,
        low=low,
        high=high,
        unit=unit,
    )
