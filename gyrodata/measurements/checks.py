"""Check the readings of a log before its fit.

The checks are about contradictions, copies, sizes, and stated errors without an effect.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata.base.errors import Diagnostic
from gyrodata.measurements import sources as parts
from gyrodata.measurements.measured import Measurements, without_loads
from gyrodata.measurements.sources import Source, spin_columns, timing_column, values_of
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
        *_find_fast_precession(readings, measured),
        *_find_unheard(readings, measured),
        *_find_copies(readings, measured, timing),
    ]


# --- derived columns ---

DERIVED: Mapping[str, Callable[[Measurements], Any]] = {
    "mass": lambda runs: runs.mass,
    "position": lambda runs: runs.position,
    "torque": lambda runs: runs.torque,
    "force": lambda runs: runs.torque / runs.position,
    "spin": lambda runs: runs.spin,
    "spin_period": lambda runs: 2 * np.pi / runs.spin,
    "time": lambda runs: runs.time,
    "turns": lambda runs: runs.turns,
    "angle": lambda runs: 2 * np.pi * runs.turns,
    "precession_period": lambda runs: runs.time / runs.turns,
    "precession_rate": lambda runs: runs.precession_rate,
    "inertia": lambda runs: runs.single_inertia,
}
"""Columns that also follow from other readings: their values [SI unit of the role],
shape (n,)."""


def _find_contradictions(
    readings: Readings, measured: Measurements
) -> Iterator[Diagnostic]:
    """Name the rows in which a column next to the readings disagrees with them.

    Such a column is a period, rate, torque, inertia or second spin.
    """
    # The mean spin is corrected; another reading agrees with itself.
    used = spin_columns(readings)
    for column in (*readings.columns.values(), *readings.others):
        is_used = any(column is each for each in used)
        if column.role in DERIVED and not is_used:
            yield from _compare(readings, measured, column)


def _compare(
    readings: Readings, measured: Measurements, column: Column
) -> Iterator[Diagnostic]:
    """Compare a column with the value that follows from the readings."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        meant = np.abs(DERIVED[column.role](measured))
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


def _find_fast_precession(
    readings: Readings, measured: Measurements
) -> Iterator[Diagnostic]:
    """Report most runs precessing faster than they spin: columns or units are wrong."""
    fast = np.flatnonzero(np.abs(measured.product) > measured.spin**2)
    if 2 * len(fast) > len(measured.runs):
        column = spin_columns(readings)[0]
        yield readings.say(
            "precession_faster_than_spin",
            column.cell(int(fast[0])),
            header=column.header,
            fast=len(fast),
            runs=len(measured.runs),
        )


# --- uncertainties without an effect ---


def _find_unheard(readings: Readings, measured: Measurements) -> Iterator[Diagnostic]:
    """Name every stated ``u_…`` without an effect and its reason, if not zero."""
    of_whole_log = _used_of_whole_log(readings, measured)
    for key, place in readings.stated_at.items():
        if key in roles.SHARED_UNCERTAINTIES:
            is_used = key in of_whole_log
        else:
            is_used = _changes_errors(key, readings, measured)
        if not is_used and readings.uncertainties[key] != Uncertainty():
            why = _why_not_used(key, readings)
            yield readings.say("uncertainty_not_used", place, key=key, why=why)


def _used_of_whole_log(readings: Readings, measured: Measurements) -> set[str]:
    """Return the keys that are used, of a source of error or of something else."""
    used = {f"u_{source.name}" for source in measured.sources} | {"u_imbalance"}
    if "mass" in readings.columns:
        used.add("u_g")
    if measured.timed:
        used.add("u_time_bias")
    if {"ball_mass", "ball_diameter"} <= readings.constants.keys():
        used |= {"u_ball_mass", "u_ball_diameter"}
    if readings.position_from in roles.ORIGIN_LENGTHS:
        length, *_ = roles.ORIGIN_LENGTHS[readings.position_from]
        used.add(f"u_{length}")
    return used


def _changes_errors(key: str, readings: Readings, measured: Measurements) -> bool:
    """Return whether the errors of a log depend on the uncertainty of a key."""
    columns = dict(readings.columns)
    for role, column in readings.columns.items():
        if key in roles.u_keys(role):
            u = roles.as_u_of(role, key, readings.uncertainties[key])
            cells = [replace(r, u=None) if r.u == u else r for r in column.readings]
            columns[role] = replace(column, readings=tuple(cells))
    others = parts.list_sources(replace(readings, columns=columns), measured)
    return _sizes_of_errors(others) != _sizes_of_errors(measured.sources)


def _sizes_of_errors(sources: Iterable[Source]) -> dict[str, Any]:
    """Return the sizes of the errors of a log by their names, for a comparison."""
    return {
        source.name: (source.default, *source.absolute, *source.relative)
        for source in sources
    }


WHY_NOT_USED = {
    "u_inertia": "I_zz is the result, and so is its uncertainty",
    "u_time_bias": "rates are given, not times of a stopwatch",
    "u_mass_scale": "the force or the torque is given, and no mass",
    "u_g": "the force or the torque is given, and no mass",
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
    "u_ball_mass": "ball_mass and ball_diameter are not both given",
    "u_ball_diameter": "ball_mass and ball_diameter are not both given",
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
    rows = _rows(readings, measured, timing)
    lines_of: dict[object, list[int]] = {}
    for line, row in rows.items():
        lines_of.setdefault(row, []).append(line)
    if measured.timed and len(lines_of) < len(rows):
        alike = Counter([settings for settings, _ in rows.values()])
        pairs = sum([math.comb(count, 2) for count in alike.values()])
        chance = _chance_of_equal_times(measured, timing)
        if _is_no_accident(len(rows) - len(lines_of), pairs, chance):
            yield _say_copied(readings, lines_of.values())


Row = tuple[tuple[Any, ...], tuple[float | None, ...]]
"""The settings of all runs of a line, and their times."""


def _rows(readings: Readings, measured: Measurements, timing: Column) -> dict[int, Row]:
    """Return the settings and times by line: it may contain repeats of one setting."""
    columns = readings.columns.values()
    others = [column.values for column in columns if column is not timing]
    settings = list(zip(*others, strict=True))
    runs_of: dict[int, list[int]] = {}
    for run, line in enumerate(measured.lines):
        runs_of.setdefault(line, []).append(run)
    rows: dict[int, Row] = {}
    for line, runs in runs_of.items():
        times = tuple([timing.values[run] for run in runs])
        rows[line] = (tuple([settings[run] for run in runs]), times)
    return rows


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
    if chance >= 1 or copies <= pairs * chance:
        return False
    others = pairs - copies
    power = copies * math.log(copies / (pairs * chance))
    if others:
        power += others * math.log(others / (pairs * (1 - chance)))
    return math.exp(-power) <= NO_ACCIDENT[pairs > 1]


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
MASS = Size("mass", (8e-4, 5.0), (1e-3, 1.0), ("g", "kg", "mg", "oz"))
FORCE = Size("force", (8e-3, 20.0), (0.01, 10.0), ("N", "mN"))
POSITION = Size("position", (2e-3, 1.0), (0.02, 0.6), ("cm", "mm", "m"))
SIZES = (MASS, FORCE, POSITION, SPIN, TIME)


def possible_range(role: str) -> tuple[float, float]:
    """Return the smallest and the largest possible reading of a role [SI unit]."""
    for size in SIZES:
        if size.role == role:
            return size.possible
    return -math.inf, math.inf


def unit_within(readings: Readings, role: str, usual: tuple[float, float]) -> str:
    """Return another unit that brings a column into a usual range [SI unit].

    Each reading must be possible, and nine in ten must be in the range; all of them if
    that is so already without another unit. The result is "" if there is no such unit.
    """
    values = sorted(abs(value) for value in readings.columns[role].values if value)
    few = len(values) // 10
    least = values[few]
    most = values[-1 - few]
    is_usual = usual[0] <= least and most <= usual[1]
    low, high = usual if is_usual else possible_range(role)
    for unit, factor in other_units(readings.columns[role]):
        is_possible = low <= factor * values[0] and factor * values[-1] <= high
        if is_possible and usual[0] <= factor * least and factor * most <= usual[1]:
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
    for unit in next((size.units for size in SIZES if size.role == column.role), ()):
        factor = parse_unit(unit, kind).factor / unit_size(column)
        if not math.isclose(factor, 1.0):
            yield unit, factor


def unit_size(column: Column) -> float:
    """Return one unit of a column [SI unit]; 1 for a column of numbers."""
    kind = roles.kind_of_role(column.role)
    return parse_unit(column.unit, kind).factor if column.unit else 1.0


def exchanged(readings: Readings) -> bool:
    """Return whether spin and time are possible only if they are exchanged."""
    if not _are_usual_exchanged(readings, SPIN, TIME):
        return False
    spins = readings.columns["spin"]
    times = readings.columns["time"]
    # A value of the whole log is in no column.
    is_stated = min(*spins.spots, *times.spots) < 0
    # In a minute a ball turns more often than a rod needs seconds for a timed angle.
    is_slow = np.abs(values_of(spins)) / RPM < np.abs(values_of(times))
    return bool(is_slow.all()) and not is_stated


def _are_usual_exchanged(readings: Readings, first: Size, second: Size) -> bool:
    """Return whether two columns in usual units have usual values if exchanged."""
    for size, other in ((first, second), (second, first)):
        column = readings.columns.get(size.role)
        if column is None or column.unit != size.units[0]:
            return False
        meant = parse_unit(other.units[0], roles.kind_of_role(other.role)).factor
        values = np.abs(values_of(column)) / unit_size(column) * meant
        low, high = other.usual
        if not ((low <= values) & (values <= high)).all():
            return False
    return True


INSIDE = 0.04
"""A weight at such a distance from the centre is inside the ball [m]."""


def check_sizes(readings: Readings) -> list[Diagnostic]:
    """Report readings that are impossible in this lab, and exchanged columns."""
    if exchanged(readings):
        spin = readings.columns["spin"]
        time = readings.columns["time"]
        return [_say_exchanged(readings, spin.place(0), spin, time)]
    questions = []
    for size in SIZES:
        column = readings.columns.get(size.role)
        if column is not None:
            sizes = np.abs(values_of(column))
            low, high = size.possible
            odd = np.flatnonzero((sizes > 0) & ~((low <= sizes) & (sizes <= high)))
            if len(odd):
                questions.append(_say_size(readings, size, column, odd.tolist()))
    return questions


def _say_exchanged(
    readings: Readings, place: Any, first: Column, second: Column
) -> Diagnostic:
    """Say that two columns are exchanged; their headers have usual units."""
    return readings.say(
        "columns_exchanged",
        place,
        first=first.header,
        second=second.header,
        one=f"{first.role} [{first.unit}]",
        other=f"{second.role} [{second.unit}]",
    )


def _say_size(
    readings: Readings, size: Size, column: Column, odd: list[int]
) -> Diagnostic:
    """Say that some readings of a column are impossible, and propose another unit."""
    run = odd[0]
    if size.role == "position" and len(odd) > 1 and _is_mass(readings, column):
        mass = readings.columns["mass"]
        return _say_exchanged(readings, column.cell(run), mass, column)
    name = "size_unusual"
    meant = ""
    there = 0.0
    unit = unit_within(readings, size.role, size.usual)
    if unit:
        name = "size_of_column"
        meant = unit
    elif in_unit := meant_in(readings, size, run):
        name = "size_of_cell"
        meant, there = in_unit
    values = abs(column.values[run] or 0.0), *size.possible, there
    value, low, high, near = [
        f"{value / unit_size(column):.4g} {column.unit}" for value in values
    ]
    return readings.say(
        name,
        column.cell(run),
        role=size.role,
        value=value,
        low=low,
        high=high,
        unit=meant,
        there=near,
    )


def _is_mass(readings: Readings, positions: Column) -> bool:
    """Return whether positions [cm] and masses [g] are possible if they are exchanged.

    Positions in mm are as large, but none is inside the ball.
    """
    is_inside = np.abs(values_of(positions)).min() < 10 * INSIDE
    return bool(is_inside) and _are_usual_exchanged(readings, MASS, POSITION)
