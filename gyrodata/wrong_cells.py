"""Wrong cells: what an odd run would have in one cell if it agreed with the others.

Each change is made in the log's own readings; the run is then compared with what the fit of the other runs predicts.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from decimal import Decimal
from itertools import pairwise

import numpy as np
from msgspec.structs import replace

from gyrodata import fitting
from gyrodata.fitting import ChosenModel, FitResult, Outlier
from gyrodata.known_slips import SIZES
from gyrodata.measurements import Measurements, as_spin, mean_spin, measure, spin_columns
from gyrodata.quantities import PLAIN, exchanged_digits
from gyrodata.readings import TIMINGS, Column, Readings, kind_of_role
from gyrodata.tables import turn_words
from gyrodata.units import UnitError, from_si, parse_unit

MOST_RUNS, MOST_ODD, MOST_TOLD = 1000, 12, 3
"""Larger logs, and more odd runs, are not searched for a wrong cell; so many corrections of one run are told."""

FITS = 2.5
"""A correction fits if the run is then off by less than this many standard uncertainties …"""

NEAR = 0.15
"""… of those that bring the time so near to the predicted one, as a difference of logarithms."""

WIDER, UNUSUAL = 1.25, 2
"""The rank of a correction is 0 for a likely slip, and so much more or less if the value is, or was, so many times
larger or smaller than in any other run."""

FROM_OTHERS = 5
"""Rank of a value that was worked out from the other runs: it explains nothing."""


def explain(
    readings: Readings, measured: Measurements, chosen: ChosenModel, outliers: Sequence[Outlier], others: FitResult
) -> tuple[Outlier, ...]:
    """Give odd runs with the corrections that fit, the likeliest first; `others` is the fit without these runs."""
    odd = [outlier.index for outlier in outliers]
    says = others.adjusted.kept > 0
    typical = max(1.0, fitting.MAD_TO_SD * float(np.median(np.abs(others.deviations[says]))))
    explained = []
    for number, outlier in enumerate(outliers):
        i, found = outlier.index, []
        if outlier.turns is not None and _is_usual(measured, i, outlier.turns):
            words = f"fits {turn_words(outlier.turns)}, not {turn_words(measured.turns[i]).split(' ')[0]}"
            alike = measured.turns[says & (measured.torque == measured.torque[i])]
            # What all other runs of this weight have is likelier than a count of its own.
            found.append((0 if len(alike) and np.allclose(alike, outlier.turns) else 1, FITS, words))
        if number < MOST_ODD and len(measured.runs) <= MOST_RUNS:
            for rank, words, column in _changes(readings, measured, others, i):
                off = _off_after(readings, column, chosen, others, odd, i) / typical
                if off < FITS:
                    found.append((rank, off, words))
        found.sort()
        likely = [words for rank, _, words in found if rank <= min(found[0][0] + 1, FROM_OTHERS - 1)]
        maybe = [words for rank, _, words in found if rank == FROM_OTHERS]
        if not outlier.slip:
            # One that is merely odd may be so by chance, and then several corrections may fit, or none.
            slips = [words for rank, _, words in found if rank <= 0]
            likely, maybe = [], slips if len(slips) == 1 else []
        explained.append(
            replace(
                outlier,
                expected=float(others.fitted_time[i]),
                cells=tuple(likely[:MOST_TOLD]),
                maybe="" if likely else "".join(maybe),
            )
        )
    return tuple(explained)


def _is_usual(measured: Measurements, index: int, turns: float) -> bool:
    """Say whether labs, or other runs of this log, time so many turns, or the written count is off by one or a half."""
    written = float(measured.turns[index])
    usual = [
        *fitting.USUAL_COUNTS,
        *np.unique(measured.turns).tolist(),
        *(written + step for step in (-1, -0.5, 0.5, 1)),
    ]
    return any(math.isclose(turns, count) for count in usual)


def _off_after(
    readings: Readings, column: Column, chosen: ChosenModel, others: FitResult, odd: Collection[int], index: int
) -> float:
    """Work out how far a run is from what the others predict once a column is changed [u of the difference]."""
    changed = measure(replace(readings, columns={**readings.columns, column.role: column}))
    try:
        runs = fitting.corrected(changed, others, chosen)
        fit = fitting.fit(runs, fitting.AS_STATED, tilted=chosen.tilted, left_out=odd)
        return abs(float(fit.deviations[index]))
    except fitting.NoFit:
        return math.inf


def _changes(
    readings: Readings, measured: Measurements, others: FitResult, index: int
) -> Iterator[tuple[int, str, Column]]:
    """List the changes of one cell that bring a run near to what the others predict: rank, words, changed column."""
    bias, imbalance = others.timing_bias.value, others.residual_torque.value
    need = float((measured.time[index] - bias) / (others.fitted_time[index] - bias))
    if not 0 < need < math.inf:
        return
    torque = float(measured.torque[index])
    timing = next(role for role in TIMINGS if role in readings.columns)
    spins = [column.role for column in spin_columns(readings)]
    load = next(role for role in ("mass", "force", "torque") if role in readings.columns)
    loads = [role for role in (load, "position") if role in readings.columns and torque]
    if load == "torque":
        loads = [load]

    def left(role: str, ratio: float) -> float:
        """What the time is over the predicted one, after a change."""
        if role == timing:
            return need / ratio if role == "precession_rate" else need * ratio
        if role in loads:
            if measured.slowing is not None:
                # The mean rate of a rod that nods depends on its moment of inertia too.
                return 1.0
            return need * abs((torque * ratio + imbalance) / (torque + imbalance))
        faster = 1 / ratio if role.startswith(("spin_period", "spin_time")) else ratio
        after = [
            as_spin(column)[[index]] * (faster if column.role == role else 1.0) for column in spin_columns(readings)
        ]
        return need * float(measured.spin[index] / (mean_spin(after) if len(after) > 1 else after[0])[0])

    for role in (timing, *spins, *loads):
        column = readings.columns[role]
        old = column.values[index]
        if column.spots[index] < 0 or not old:
            continue
        cells = list(_of_slips(column, index, readings.position_from if role == "position" else None))
        rest = np.abs([column.values[k] or math.nan for k in np.flatnonzero(others.adjusted.kept)])
        low, high = np.nanmin(rest) / WIDER, np.nanmax(rest) * WIDER

        def farther(value: float, old: float = old, low: float = low, high: float = high) -> int:
            """Say whether a value is outside those of the other runs, and the old one was not, or the reverse."""
            return int(not low < abs(value) < high) - int(not low < abs(old) < high)

        if role == timing:
            cells = [(rank + max(0, farther(value)), text, why, value) for rank, text, why, value in cells]
        else:
            # What another weight or place has as well is no slip of the pen.
            cells = [] if role in loads and abs(old) in rest else cells
            cells = [
                (rank + UNUSUAL * farther(value), text, why, value)
                for rank, text, why, value in (*_of_neighbours(column, index, role in loads), *cells)
            ]
        if spins == [role] and role == "spin":
            cells += _that_fits(column, index, old * need)
        seen = {f"{old:.6g}"}
        for rank, text, why, value in cells:
            if not value:
                continue
            after = left(role, value / old)
            if f"{value:.6g}" in seen or not after > 0 or abs(math.log(after)) > NEAR:
                continue
            seen.add(f"{value:.6g}")
            unit = f" {column.unit}" if column.unit else ""
            where, asked = ("", why) if why.startswith(" (") else (why, "")
            words = f"{role.replace('_', ' ')} {text}{unit}{where} would fit{why and ', not '}"
            # The runs below one cell that is filled down have it too.
            spot = column.spots[index]
            changed = [
                replace(reading, value=value) if own == spot else reading
                for reading, own in zip(column.readings, column.spots, strict=True)
            ]
            words += (why and _written(column, index)) + asked
            yield rank, words, replace(column, readings=tuple(changed))


Cell = tuple[int, str, str, float]
"""Rank, number as it would be written, how it may have come to be wrong, and the value [SI]."""


def _written(column: Column, index: int) -> str:
    """Give the number of a cell as it was typed; of anything but a plain number, its value in the column's unit."""
    text = column.readings[index].text
    if PLAIN.fullmatch(text):
        return text
    value = column.values[index] or 0.0
    return f"{from_si(value, column.unit, kind_of_role(column.role)) if column.unit else value:.6g}"


def _of_neighbours(column: Column, index: int, single: bool) -> Iterator[Cell]:
    """Give what the runs before and after have; `single`: also if only one of them has it."""
    spots, values = column.spots, column.values
    before = next((k for k in range(index - 1, -1, -1) if spots[k] != spots[index]), None)
    after = next((k for k in range(index + 1, len(spots)) if spots[k] != spots[index]), None)
    around = {k: value for k in (before, after) if k is not None and (value := values[k])}
    rest = [value for k, value in enumerate(values) if spots[k] != spots[index]]
    steps = sum(one != other for one, other in pairwise(rest))
    # Where one weight is used after the other, the runs around a run nearly always have its weight.
    run, value = next(iter(around.items()), (0, 0.0))
    if steps < len(set(rest)) and set(around.values()) == {value} and rest.count(value) > 1:
        where = "other runs" if len(set(rest)) == 1 else "runs around it"
        yield 0, _written(column, run), f", as in the {where},", value
        return
    for run, value in around.items():
        if single and value != values[index]:
            yield 1, _written(column, run), f", as in the run {'before' if run < index else 'after'},", value


def _of_slips(column: Column, index: int, origin: str | None) -> Iterator[Cell]:
    """Give what the number would be without a slip of the pen: its point, its digits, its unit."""
    text, value, kind = _written(column, index), column.values[index] or 0.0, kind_of_role(column.role)
    comma = "," in text
    number = Decimal(text.replace(",", "."))
    try:
        factor = parse_unit(column.unit, kind).factor if column.unit else 1.0
    except UnitError:
        return
    shifted = origin in ("surface", "tip")
    if not number or not (shifted or math.isclose(factor * float(number), value, rel_tol=1e-6)):
        return

    def cell(rank: int, new: Decimal, why: str) -> Cell:
        # A position that counts from elsewhere is moved by as much as the number is.
        moved = factor * float(new - number) * (-1 if origin == "tip" else 1)
        return rank, f"{new:f}".replace(".", "," if comma else "."), why, value + moved

    for power in (-1, 1, -2, 2):
        yield cell(0, number.scaleb(power), " (is the decimal point misplaced?)")
    for new in exchanged_digits(text):
        yield cell(0, Decimal(new.replace(",", ".")), " (are two digits exchanged?)")
    if column.role == "time" and column.unit == "s":
        yield cell(1, number + 60, " (is a minute missing?)")
        yield cell(1, number - 60, " (is it a minute less?)")
        yield cell(2, number - 10, " (is a digit wrong?)")
        yield cell(2, number + 10, " (is a digit wrong?)")
    for size in SIZES:
        for unit in size.units if size.role == column.role and column.unit and not shifted else ():
            in_unit = value / factor * parse_unit(unit, kind).factor / factor
            yield 2, f"{in_unit:.5g}", f" (is it in {unit}?)", in_unit * factor


def _that_fits(column: Column, index: int, value: float) -> Iterator[Cell]:
    """Give the reading that the other runs predict, with as many digits as were typed."""
    step = column.readings[index].step or 0.0
    factor = parse_unit(column.unit, kind_of_role(column.role)).factor
    places = max(0, -math.floor(math.log10(step / factor * 1.000001))) if step else 1
    text = f"{value / factor:.{places}f}"
    yield FROM_OTHERS, text.replace(".", "," if "," in _written(column, index) else "."), "", float(text) * factor
