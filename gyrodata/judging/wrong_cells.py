"""Wrong cells: the content of one cell with which an odd run would agree with the others.

Each change is made in the log's own readings; the run is then compared with what the
fit of the other runs predicts.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from decimal import Decimal
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from msgspec.structs import replace

from gyrodata import fitting
from gyrodata.fitting import FitResult, Outlier
from gyrodata.judging.changes import Lab
from gyrodata.judging.tables import turn_words
from gyrodata.measurements import (
    Measurements,
    as_spin,
    mean_spin,
    measure,
    spin_columns,
)
from gyrodata.measurements.checks import other_units
from gyrodata.measurements.sources import load_role
from gyrodata.quantities.numerals import PLAIN
from gyrodata.quantities.units import from_si, parse_unit
from gyrodata.readings import Column, Readings, kind_of_role
from gyrodata.readings.roles import TIMINGS

MOST_RUNS, MOST_ODD, MOST_TOLD = 1000, 12, 3
"""Larger logs, and more odd runs, are not searched for a wrong cell; at most this many
corrections are printed."""

FITS = 2.5
"""A correction fits if the run is then off by less than this many standard
uncertainties …"""

NEAR = 0.15
"""… of those that bring the time so near to the predicted one, as a difference of
logarithms."""

WIDER, UNUSUAL = 1.25, 2
"""A correction has rank 0 if it is a likely slip. The rank changes by `UNUSUAL` if the
new, or the old, value is outside the range of the other runs by the factor `WIDER`."""

FROM_OTHERS = 5
"""Rank of a value that was computed from the other runs: it explains nothing."""


def explain(
    readings: Readings, lab: Lab, outliers: Sequence[Outlier], others: FitResult
) -> tuple[Outlier, ...]:
    """Return odd runs with the corrections that fit, the most likely first.

    `others`: the fit without these runs.
    """
    measured = lab.measured
    odd = [outlier.index for outlier in outliers]
    kept = others.adjusted.kept > 0
    typical = max(
        1.0, fitting.MAD_TO_SD * fitting.median(np.abs(others.deviations[kept]))
    )
    explained = []
    for number, outlier in enumerate(outliers):
        i, found = outlier.index, []
        # A number of turns is likely that is usual, that other runs have, or that is
        # off by one or a half.
        likely_turns = {
            *fitting.USUAL_COUNTS,
            *measured.turns,
            *(measured.turns[i] + np.array([-1, -0.5, 0.5, 1])),
        }
        if (
            outlier.turns is not None
            and np.isclose(outlier.turns, [*likely_turns], rtol=1e-9, atol=0).any()
        ):
            words = (
                f"fits {turn_words(outlier.turns)}, not "
                f"{turn_words(measured.turns[i]).split(' ')[0]}"
            )
            alike = measured.turns[kept & (measured.torque == measured.torque[i])]
            # The count that all other runs of this weight have is more likely than
            # another count.
            found.append(
                (
                    0 if len(alike) and np.allclose(alike, outlier.turns) else 1,
                    FITS,
                    words,
                )
            )
        if number < MOST_ODD and len(measured.runs) <= MOST_RUNS:
            for rank, words, changed in _changes(readings, measured, others, i):
                with suppress(fitting.NoFit):
                    runs = fitting.corrected(measure(changed), others, lab.motion)
                    fit = fitting.fit(
                        runs, fitting.AS_STATED, tilted=lab.motion.tilted, left_out=odd
                    )
                    off = abs(float(fit.deviations[i])) / typical
                    if off < FITS:
                        found.append((rank, off, words))
        found.sort()
        likely = [
            words
            for rank, _, words in found
            if rank <= min(found[0][0] + 1, FROM_OTHERS - 1)
        ]
        maybe = [words for rank, _, words in found if rank == FROM_OTHERS]
        if not outlier.slip:
            # A run that is not clearly wrong may be odd by chance; then several
            # corrections may fit, or none.
            slips = [words for rank, _, words in found if rank <= 0]
            likely, maybe = [], slips if len(slips) == 1 else []
        # The deviation of a run that is left out is from the recommended fit, as in the
        # table of runs.
        deviation = (
            float(lab.fit.deviations[i]) if i in lab.left_out else outlier.deviation
        )
        told = replace(
            outlier,
            cells=tuple(likely[:MOST_TOLD]),
            maybe="" if likely else "".join(maybe),
        )
        explained.append(
            replace(told, deviation=deviation, expected=float(others.fitted_time[i]))
        )
    return tuple(explained)


class Cell(NamedTuple):
    """One possible content of a cell."""

    rank: int
    text: str
    """The number as it would be written."""
    words: str
    """The words after the number; {old} is the number that was written."""
    value: float
    """[SI unit]"""


def _changes(
    readings: Readings, measured: Measurements, others: FitResult, index: int
) -> Iterator[tuple[int, str, Readings]]:
    """List the changes of one cell with which the other runs predict about this time.

    Each change has a rank, words, and the changed readings.
    """
    bias, imbalance, torque = (
        others.timing_bias.value,
        others.residual_torque.value,
        measured.torque[index],
    )
    need = float((measured.time[index] - bias) / (others.fitted_time[index] - bias))
    if not 0 < need < math.inf:
        return
    timing = next(role for role in TIMINGS if role in readings.columns)
    spins = [column.role for column in spin_columns(readings)]
    load = load_role(readings.columns)
    loads = [load, *["position"] * (load != "torque")] if torque else []
    for role in (timing, *spins, *loads):
        column = readings.columns[role]
        old, spot = column.values[index], column.spots[index]
        if spot < 0 or not old:
            continue
        rest = np.abs(
            [column.values[k] or math.nan for k in np.flatnonzero(others.adjusted.kept)]
        )
        low, high = np.nanmin(rest) / WIDER, np.nanmax(rest) * WIDER
        cells = (
            list(_of_neighbours(column, index, role in loads)) if role != timing else []
        )
        # A value that another run has too is not a typing mistake.
        if role not in loads or abs(old) not in rest:
            cells += _of_slips(
                column, index, readings.position_from if role == "position" else None
            )
        if spins == [role] == ["spin"]:
            cells += _that_fits(column, index, old * need)
        seen = {0.0, float(f"{old:.6g}")}
        for rank, text, words, value in cells:
            rounded = float(f"{value:.6g}")
            if rounded in seen:
                continue
            # If the cell also counts for blank cells below it, their runs change too.
            spots = zip(column.readings, column.spots, strict=True)
            cell = [
                replace(reading, value=value) if own == spot else reading
                for reading, own in spots
            ]
            changed = replace(
                readings,
                columns={
                    **readings.columns,
                    role: replace(column, readings=tuple(cell)),
                },
            )
            # The ratio of the time and the predicted time after the change.
            if role in spins:
                spin = [as_spin(one)[[index]] for one in spin_columns(changed)]
                after = need * float(
                    measured.spin[index]
                    / (mean_spin(spin) if len(spin) > 1 else spin[0])[0]
                )
            elif role == timing:
                after = need * (
                    old / value if role == "precession_rate" else value / old
                )
            elif measured.slowing is None:
                after = need * abs(
                    (torque * value / old + imbalance) / (torque + imbalance)
                )
            else:
                # The mean rate of a nutating rod depends on its moment of inertia too.
                after = 1.0
            if not after > 0 or abs(math.log(after)) > NEAR:
                continue
            seen.add(rounded)
            unusual = int(not low < abs(value) < high) - int(not low < abs(old) < high)
            if rank != FROM_OTHERS:
                rank += max(0, unusual) if role == timing else UNUSUAL * unusual
            unit = f" {column.unit}" if column.unit else ""
            yield (
                rank,
                f"{role.replace('_', ' ')} {text}{unit}{words.format(old=_written(column, index))}",
                changed,
            )


def _written(column: Column, index: int) -> str:
    """Return the number of a cell as it was typed.

    If it is not a plain number, its value in the unit of the column.
    """
    text, value = column.readings[index].text, column.values[index] or 0.0
    if PLAIN.fullmatch(text):
        return text
    return f"{from_si(value, column.unit, kind_of_role(column.role)) if column.unit else value:.6g}"


def _of_neighbours(column: Column, index: int, single: bool) -> Iterator[Cell]:
    """List the values of the runs before and after.

    `single`: also if only one of them has the value.
    """
    values, spots = column.values, column.spots
    elsewhere = [k for k in range(len(spots)) if spots[k] != spots[index]]
    nearest = [
        *[k for k in elsewhere if k < index][-1:],
        *[k for k in elsewhere if k > index][:1],
    ]
    around = {k: value for k in nearest if (value := values[k])}
    rest = [values[k] for k in elsewhere]
    steps = sum(one != other for one, other in pairwise(rest))
    # If one weight is used after the other, the runs around a run nearly always have
    # its weight.
    run, value = next(iter(around.items()), (0, 0.0))
    if (
        steps < len(set(rest))
        and set(around.values()) == {value}
        and rest.count(value) > 1
    ):
        place = "other runs" if len(set(rest)) == 1 else "runs around it"
        yield Cell(
            0,
            _written(column, run),
            f", as in the {place}, would fit, not {{old}}",
            value,
        )
        return
    for run, value in around.items():
        if single and value != values[index]:
            place = "before" if run < index else "after"
            yield Cell(
                1,
                _written(column, run),
                f", as in the run {place}, would fit, not {{old}}",
                value,
            )


def _of_slips(column: Column, index: int, origin: str | None) -> Iterator[Cell]:
    """List the number with another decimal point, exchanged digits, or another unit."""
    text, value = _written(column, index), column.values[index] or 0.0
    number, shifted = Decimal(text.replace(",", ".")), origin in ("surface", "tip")
    factor = (
        parse_unit(column.unit, kind_of_role(column.role)).factor
        if column.unit
        else 1.0
    )
    if not number or not (
        shifted or math.isclose(factor * float(number), value, rel_tol=1e-6)
    ):
        return
    guesses = [
        (0, number.scaleb(power), "is the decimal point misplaced?")
        for power in (-1, 1, -2, 2)
    ]
    guesses += [
        (0, Decimal(new.replace(",", ".")), "are two digits exchanged?")
        for new in exchanged_digits(text)
    ]
    if column.role == "time" and column.unit == "s":
        guesses += [
            (1, number + 60, "is a minute missing?"),
            (1, number - 60, "is it a minute less?"),
        ]
        guesses += [(2, number + step, "is a digit wrong?") for step in (-10, 10)]
    for rank, new, why in guesses:
        # A position with another origin changes by as much as the number.
        moved = factor * float(new - number) * (-1 if origin == "tip" else 1)
        yield Cell(
            rank,
            _like(f"{new:f}", text),
            f" would fit, not {{old}} ({why})",
            value + moved,
        )
    if not column.unit or shifted:
        return
    for unit, times in other_units(column):
        there = value * times
        yield Cell(
            2,
            f"{there / factor:.5g}",
            f" would fit, not {{old}} (is it in {unit}?)",
            there,
        )


def exchanged_digits(number: str) -> Iterator[str]:
    """List the numbers that result if two neighbouring digits are exchanged.

    Numbers that begin with 0 are left out.
    """
    digits = [at for at, sign in enumerate(number) if sign.isdigit()]
    for one, other in pairwise(digits):
        signs = [*number]
        signs[one], signs[other] = number[other], number[one]
        if signs[digits[0]] != "0" and signs != [*number]:
            yield "".join(signs)


def _that_fits(column: Column, index: int, value: float) -> Iterator[Cell]:
    """List the reading that the other runs predict, with as many digits as were typed."""
    step = column.readings[index].step or 0.0
    factor = parse_unit(column.unit, kind_of_role(column.role)).factor
    places = max(0, -math.floor(math.log10(step / factor * 1.000001))) if step else 1
    text = f"{value / factor:.{places}f}"
    yield Cell(
        FROM_OTHERS,
        _like(text, _written(column, index)),
        " would fit",
        float(text) * factor,
    )


def _like(number: str, written: str) -> str:
    """Return a number with the decimal sign of another number."""
    return number.replace(".", ",") if "," in written else number
