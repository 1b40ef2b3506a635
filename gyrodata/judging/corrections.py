"""Corrections of single runs: what one cell, or two, may have been meant to contain.

Each correction is made in the log's own readings and measured again. `Prediction`
compares the time with that of the other runs.
"""

from __future__ import annotations

import math
import string
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from decimal import Decimal
from itertools import pairwise, product

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata import fitting
from gyrodata.judging.tables import turn_words
from gyrodata.measurements import Measurements, measure, spin_columns
from gyrodata.measurements.checks import other_units, possible_range, unit_size
from gyrodata.measurements.sources import load_role, timing_column, values_of
from gyrodata.quantities.numerals import PLAIN, as_read
from gyrodata.readings import Column, Reading, Readings
from gyrodata.readings.roles import TIMINGS

COMMON: Mapping[str, float] = {
    "count of the weight": 1e-2,
    "count": 3e-3,
    "value of the runs around": 2e-2,
    "value of a neighbour": 1e-3,
    "point": 2e-3,
    "two places": 5e-4,
    "digits": 2e-3,
    "doubled digit": 2e-3,
    "missing digit": 3e-4,
    "minutes and seconds": 2e-3,
    "minute": 5e-4,
    "unit": 3e-4,
    "strip": 1e-3,
    "exchanged cells": 2e-3,
    "exchanged runs": 3e-4,
}
"""Probability of each mistake in one run [1]. Only the ratios matter: a miscount is the
most common mistake in this lab."""

WIDER = 1.25
UNUSUAL = 0.05
"""A correction is less probable by the factor `UNUSUAL` if the new value is outside the
range of the other runs by the factor `WIDER`, and the old one is not."""

FEW_COUNTS = (-1, -0.5, 0.5, 1)
"""Differences of a miscount from the true count."""


USUAL_COUNTS = (1 / 3, 1 / 2, 2 / 3, 1.0, 2.0, 3.0)
"""Usual numbers of revolutions."""


class Correction(Struct, frozen=True):
    """Other contents of one or two cells."""

    runs: tuple[int, ...]
    """The runs in which a cell changes."""
    words: str
    common: float
    """Probability of this mistake [1]."""
    measured: Measurements
    """The log after it."""
    is_certain: bool = False
    """Whether a run that agrees after it is certainly wrong: the agreement with another
    count, or of two exchanged cells, does not happen by chance."""
    log_density: float = -math.inf
    """Log of the probability density of the times after it, times how common it is."""


class Cell(Struct, frozen=True):
    """One possible content of a cell."""

    kind: str
    """In `COMMON`."""
    text: str
    """The number as it would be written."""
    words: str
    """The words after the number; {old} is the number that was written."""
    value: float
    """[SI unit]"""


def of_run(
    readings: Readings, measured: Measurements, kept: Sequence[int], index: int
) -> Iterator[Correction]:
    """List the corrections of a run; `kept` are runs that agree with each other."""
    yield from _other_counts(measured, kept, index)
    yield from _exchanged_in_run(readings, index)
    loads = load_roles(readings) if measured.torque[index] else []
    spins = [column.role for column in spin_columns(readings)]
    timing = timing_column(readings.columns).role
    for role in (timing, *spins, *loads):
        column = readings.columns[role]
        if column.spots[index] < 0 or not column.values[index]:
            continue
        usual = _range_of(column, kept)
        reading = column.readings[index]
        for cell in _distinct(_cells(readings, column, index), column, index):
            words = f"{role.replace('_', ' ')} {cell.text} {column.unit}".rstrip()
            changed = {(role, index): replace(reading, value=cell.value)}
            yield Correction(
                (index,),
                words + cell.words.format(old=written(column, index)),
                COMMON[cell.kind] * _rarity(column, usual, index, cell.value),
                measure(_with_readings(readings, changed)),
            )


def of_pair(readings: Readings, first: int, second: int) -> Iterator[Correction]:
    """List the corrections that exchange cells of two runs."""
    runs = (first, second)
    timing = timing_column(readings.columns).role
    spins = [column.role for column in spin_columns(readings)]
    counts = [role for role in ("turns", "angle") if role in readings.columns]
    names = f"runs {readings.runs[first]} and {readings.runs[second]}"
    for roles, words, kind in (
        (spins, "the spins", "exchanged cells"),
        ([timing], "the times", "exchanged cells"),
        ([timing, *counts], "the times and turns", "exchanged runs"),
        ([*spins, timing, *counts], "the weights", "exchanged runs"),
    ):
        columns = [readings.columns[role] for role in roles]
        if changed := _exchanged_cells(columns, first, second):
            text = f"are {words} of {names} exchanged? Then both would fit"
            after = measure(_with_readings(readings, changed))
            yield Correction(runs, text, COMMON[kind], after, is_certain=True)


def _exchanged_cells(
    columns: Sequence[Column], first: int, second: int
) -> dict[tuple[str, int], Reading]:
    """Exchange cells of two runs; none if they are equal or hold for the whole log."""
    changed = {}
    for column in columns:
        if min(column.spots[first], column.spots[second]) < 0:
            return {}
        changed[column.role, first] = column.readings[second]
        changed[column.role, second] = column.readings[first]
    differ = [column.values[first] != column.values[second] for column in columns]
    return changed if any(differ) else {}


def load_roles(readings: Readings) -> list[str]:
    """Return the roles of the columns that give the torque."""
    load = load_role(readings.columns)
    return [load] if load == "torque" else [load, "position"]


def _other_counts(
    measured: Measurements, kept: Sequence[int], index: int
) -> Iterator[Correction]:
    """List other numbers of turns that are likely.

    They are the usual ones, those of other runs, and those that are off by one or a
    half.
    """
    turns = float(measured.turns[index])
    alike = {
        float(measured.turns[run])
        for run in kept
        if measured.torque[run] == measured.torque[index]
    }
    likely = {*USUAL_COUNTS, *measured.turns.tolist()}
    likely |= {turns + step for step in FEW_COUNTS}
    written = turn_words(turns).split(" ")[0]
    for count in sorted(likely):
        if count <= 0 or math.isclose(count, turns):
            continue
        counts = measured.turns.copy()
        counts[index] = count
        is_of_weight = len(alike) == 1 and math.isclose(count, *alike)
        kind = "count of the weight" if is_of_weight else "count"
        yield Correction(
            (index,),
            f"fits {turn_words(count)}, not {written}",
            COMMON[kind],
            replace(measured, turns=counts, slowing=1.0),
            is_certain=True,
        )


def _exchanged_in_run(readings: Readings, index: int) -> Iterator[Correction]:
    """Suppose that the numbers of spin and time of a run are exchanged."""
    columns = readings.columns
    if not {"spin", "time"} <= columns.keys():
        return
    changed = {}
    for role, other in (("spin", "time"), ("time", "spin")):
        column = columns[other]
        # A value that holds for the whole log is in no cell.
        if column.spots[index] < 0:
            return
        reading = column.readings[index]
        number = (reading.value or 0.0) / unit_size(column)
        value = number * unit_size(columns[role])
        changed[role, index] = replace(reading, value=value)
    after = measure(_with_readings(readings, changed))
    words = "are time and spin exchanged? Then it would fit"
    yield Correction((index,), words, COMMON["exchanged cells"], after)


def _with_readings(
    readings: Readings, changed: Mapping[tuple[str, int], Reading]
) -> Readings:
    """Change cells, by role and run, also for the blank cells that they fill."""
    columns = dict(readings.columns)
    for (role, run), reading in changed.items():
        column = columns[role]
        cells = list(column.readings)
        for other, spot in enumerate(column.spots):
            if spot == column.spots[run]:
                cells[other] = reading
        columns[role] = replace(column, readings=tuple(cells))
    return replace(readings, columns=columns)


# --- other contents of a cell ---


def _cells(readings: Readings, column: Column, index: int) -> Iterator[Cell]:
    """List other contents of a cell, without those that are the same number."""
    role = column.role
    is_load = column.role in load_roles(readings)
    if role not in TIMINGS:
        yield from _of_neighbours(column, index, is_load)
    others = {
        abs(value)
        for value, spot in zip(column.values, column.spots, strict=True)
        if value and spot != column.spots[index]
    }
    # A value that another run has too is not a typing mistake.
    if not is_load or abs(column.values[index] or 0.0) not in others:
        yield from of_typing(column, index)


def _distinct(cells: Iterator[Cell], column: Column, index: int) -> Iterator[Cell]:
    """Leave out cells with a number that is there already, or that is impossible."""
    low, high = possible_range(column.role)
    listed = {0.0, float(f"{column.values[index]:.6g}")}
    for cell in cells:
        rounded = float(f"{cell.value:.6g}")
        if low <= cell.value <= high and rounded not in listed:
            listed.add(rounded)
            yield cell


def _range_of(column: Column, kept: Sequence[int]) -> tuple[float, float]:
    """Return the range of the values of the other runs, a little wider."""
    values = [abs(value) for run in kept if (value := column.values[run])]
    return min(values, default=0.0) / WIDER, max(values, default=math.inf) * WIDER


def _rarity(
    column: Column, usual: tuple[float, float], index: int, value: float
) -> float:
    """Return the factor on the probability of a value for its size: `UNUSUAL` or 1.

    It is the inverse if the value that was written is the unusual one.
    """
    low, high = usual
    before = abs(column.values[index] or 0.0)
    is_out = not low < abs(value) < high
    was_out = not low < before < high
    if column.role in TIMINGS:
        was_out = False
    return UNUSUAL ** (int(is_out) - int(was_out))


def written(column: Column, index: int) -> str:
    """Return the number of a cell as it was typed.

    If it is not a plain number, its value in the unit of the column.
    """
    text = column.readings[index].text
    if PLAIN.fullmatch(text):
        return text
    return f"{(column.values[index] or 0.0) / unit_size(column):.6g}"


def _of_neighbours(column: Column, index: int, is_load: bool) -> Iterator[Cell]:
    """List the values of the nearest runs before and after with another cell.

    If only one of them has a value, only a load may be copied from it.
    """
    spots = np.array(column.spots)
    has_value = np.nan_to_num(values_of(column)) != 0
    others = np.flatnonzero((spots != spots[index]) & has_value)
    at = int(np.searchsorted(others, index))
    near = others[max(at - 1, 0) : at + 1].tolist()
    rest = [column.values[run] for run in others]
    kind = "value of a neighbour"
    if _are_common([column.values[run] for run in near], rest):
        kind = "value of the runs around"
    elif not is_load:
        return
    for run in near:
        words = ", as in the runs around it, would fit, not {old}"
        yield Cell(kind, written(column, run), words, column.values[run] or 0.0)


def _are_common(near: Sequence[float | None], rest: Sequence[float | None]) -> bool:
    """Return whether the nearest values agree, as those of runs that follow each other.

    A weight is used in such runs: the values around a run are then nearly always its
    own.
    """
    steps = sum(value != other for value, other in pairwise(rest))
    is_in_order = steps < len(set(rest))
    is_one = len(set(near)) == 1
    return is_in_order and is_one and rest.count(near[0]) > 1


def of_typing(column: Column, index: int) -> Iterator[Cell]:
    """List the number with another decimal point, exchanged digits, or another unit.

    A position that does not count from the centre is not its number in a unit: nothing
    is listed for it.
    """
    text = written(column, index)
    value = column.values[index] or 0.0
    number = Decimal(text.replace(",", "."))
    factor = unit_size(column)
    if not number or not math.isclose(factor * float(number), value, rel_tol=1e-6):
        return
    for kind, new, why in _guesses(column, text, number):
        shown = f"{new:f}"
        if "," in text:
            shown = shown.replace(".", ",")
        words = f" would fit, not {{old}} ({why})"
        yield Cell(kind, shown, words, factor * float(new))
    for unit, times in other_units(column):
        words = f" would fit, not {{old}} (is it in {unit}?)"
        yield Cell("unit", f"{value * times / factor:.5g}", words, value * times)


def _guesses(
    column: Column, text: str, number: Decimal
) -> Iterator[tuple[str, Decimal, str]]:
    """List other numbers that may be meant: the mistake, the number, and why."""
    for power in (-1, 1, -2, 2):
        kind = "point" if abs(power) == 1 else "two places"
        yield kind, number.scaleb(power), "is the decimal point misplaced?"
    step = column.steps[0] / unit_size(column)
    # A spreadsheet writes 43 for 43.0.
    digits = as_read(float(number), step) if step and text.isdigit() else text
    for kind, new, why in _other_digits(digits.replace(",", ".")):
        yield kind, Decimal(new), why
    if column.role in ("spin", "spin_start", "spin_end"):
        yield "strip", number / 2, "are two strips of tape on the ball?"
    if column.role == "time" and column.unit == "s":
        yield from _other_times(text.replace(",", "."), number)


def _other_times(text: str, number: Decimal) -> Iterator[tuple[str, Decimal, str]]:
    """List other numbers of seconds, as `_guesses`."""
    minutes, _, seconds = text.partition(".")
    if len(seconds) == 2 and seconds < "60" and 0 < int(minutes or 0) < 30:
        meant = 60 * Decimal(minutes) + Decimal(seconds)
        why = f"is it {minutes} min {seconds} s? Then write {minutes}:{seconds}"
        yield "minutes and seconds", meant, why
    yield "minute", number + 60, "is a minute missing?"
    yield "minute", number - 60, "is it a minute less?"


def _other_digits(number: str) -> Iterator[tuple[str, str, str]]:
    """List the numbers whose digits may be mistyped like this, as `_guesses`.

    Exchanged digits that begin with 0 are left out, if no point follows it.
    """
    digits = [at for at, sign in enumerate(number) if sign.isdigit()]
    for first, second in pairwise(digits):
        signs = [*number]
        signs[first] = number[second]
        signs[second] = number[first]
        new = "".join(signs)
        unsigned = new[digits[0] :]
        if number[first] == number[first + 1]:
            single = number[:first] + number[second:]
            yield "doubled digit", single, "is a digit doubled?"
        elif unsigned[0] != "0" or unsigned.startswith("0."):
            yield "digits", new, "are two digits exchanged?"
    whole, point, _ = number.partition(".")
    # A digit missing behind a whole number is a misplaced point.
    ends = len(whole + point) if whole.isdigit() else 0
    for at, digit in product(range(ends), string.digits):
        new = number[:at] + digit + number[at:]
        yield "missing digit", new, "is a digit missing?"


# --- how well a corrected run agrees with the others ---


class Prediction(Struct, frozen=True):
    """Predictions of the fit of some runs for the times of the others."""

    measured: Measurements
    """The log."""
    others: fitting.FitResult
    """A fit of it without some runs."""

    def agreeing(
        self, tried: Iterable[Correction], odd: Collection[int]
    ) -> Iterator[Correction]:
        """Yield the corrections after which their runs agree with the others.

        A run that is not odd agreed before: the density of its time is divided by that.
        """
        for correction in tried:
            density = math.log(correction.common)
            for run in correction.runs:
                density += self._log_density(correction.measured, run)
                if run not in odd:
                    density -= self._log_density(self.measured, run)
            if math.isfinite(density):
                yield replace(correction, log_density=density)

    def _log_density(self, changed: Measurements, run: int) -> float:
        """Return the log of the probability density of ln T of a run of a changed log.

        −inf if the run then deviates by more than `FITS` standard uncertainties.
        """
        bias = float(self.others.adjusted.unknowns[2])
        time = float(changed.time[run]) - bias
        fitted = float(self.others.fitted_time[run]) - bias
        longer = self._slowness(changed, run) / self._slowness(self.measured, run)
        predicted = fitted * longer
        if not (time > 0 and 0 < predicted < math.inf):
            return -math.inf
        u = self._relative_u(changed, run, predicted)
        off = (time / predicted - 1) / u
        if abs(off) > FITS:
            return -math.inf
        return -0.5 * off**2 - math.log(u) - HALF_LOG_2PI

    def _net_torque(self, measured: Measurements, run: int) -> float:
        """Return the net torque of a run [N*m]."""
        residual_torque = self.others.adjusted.unknowns[1]
        torque = float(measured.torque[run] + residual_torque)
        return abs(torque) or math.nan

    def _slowness(self, measured: Measurements, run: int) -> float:
        """Return the time of a run over 2π I_zz, by eq. (9) [s/(kg*m^2)]."""
        angle = measured.turns[run] * measured.corrected_spin[run]
        return float(angle) / self._net_torque(measured, run)

    def _relative_u(self, changed: Measurements, run: int, time: float) -> float:
        """Return the relative u of the difference of a time from its prediction [1]."""
        inertia = float(self.others.adjusted.unknowns[0])
        torque = self._net_torque(changed, run)
        slope = np.array([1 / inertia, -1 / torque, 0.0])
        variance = slope @ self.others.covariance @ slope
        # A time that is much too small is not as uncertain as its own size says.
        times = changed.time.copy()
        times[run] = time
        own = float(replace(changed, time=times).own_relative[run])
        return math.sqrt(max(variance, 0.0) + own**2)


FITS = 3.0
"""A correction fits if the run is then off by less than this many standard
uncertainties."""

HALF_LOG_2PI = 0.5 * math.log(2 * math.pi)
