"""Compare second columns, and lines for the whole log, with the columns that are used."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from gyrodata.readings import roles
from gyrodata.readings.chosen import Chosen
from gyrodata.readings.headers import parse_header
from gyrodata.readings.lablog import Column, Faults, Reading
from gyrodata.readings.origins import origin_in
from gyrodata.readings.settings import Given
from gyrodata.readings.unnamed import may_number
from gyrodata.readings.words import squeeze

CONSTANT = -1
"""Number of the cell of a value that is valid for the whole log."""
_SAME = 0.01
"""Largest difference of two columns of one quantity that makes no difference to the
answer, as a share."""


def differ(used: Reading, other: Reading) -> bool:
    """Return whether two readings of one quantity differ clearly.

    The difference is larger than their last digits and larger than a percent.
    """
    if used.value is None or other.value is None:
        return False
    # A whole number of turns is exact.
    steps = [reading.step or 0.0 for reading in (used, other)]
    digits = sum(step for step in steps if step < 1)
    gap = abs(abs(used.value) - abs(other.value))
    return gap > max(_SAME * abs(used.value), digits)


def leave_out(column: Chosen, used: Chosen, faults: Faults) -> bool:
    """Return whether a second column cannot be compared; if so, add a message."""
    role = column.role
    if role == "time" and (used.header.unit, column.header.unit) == ("min", "s"):
        faults.add("minutes_and_seconds", column.cell, header=used.header.text)
        return True
    origins = [origin_in(one.header.text) for one in (used, column)]
    from_elsewhere = role == "position" and origins[1] not in ("", origins[0])
    if role not in roles.TEXTS and not role.startswith("u_") and not from_elsewhere:
        return False
    why = f'is not used: {role} is read from "{used.header.text}"'
    faults.add("not_used", column.cell, why=why)
    return True


def ask_which(
    columns: Mapping[str, Column],
    others: Collection[Column],
    decided: Collection[str],
    faults: Faults,
) -> None:
    """Ask which of two columns contains a quantity, if the answer depends on it.

    `decided` are the roles that need no answer.
    """
    for other in others:
        used = columns.get(other.role)
        if used is None or other.role in decided or not roles.BY_NAME[other.role].part:
            continue
        if CONSTANT in used.spots or _is_something_else(other, used):
            continue
        pairs = enumerate(zip(used.readings, other.readings, strict=True))
        different = [run for run, pair in pairs if differ(*pair)]
        if different:
            run = different[0]
            values = {"role": other.role, "used": used.header, "other": other.header}
            values["says"] = used.readings[run].text
            values["otherwise"] = other.readings[run].text
            faults.add("two_columns", other.cell(run), **values)


def _is_something_else(other: Column, used: Column) -> bool:
    """Return whether a second column contains means, numbers of runs or hours of the day.

    Examples are "n", and "Time" next to "time [s]".
    """
    header = parse_header(other.header)
    if header.is_of_means or may_number(header):
        return True
    is_bare = other.role == "time" and header.unit is None
    return is_bare and parse_header(used.header).unit is not None


def compare_with_line(column: Column, given: Given, faults: Faults) -> None:
    """Ask which is right, if a line of the log gives another value than a whole column.

    A column with the name of the quantity itself replaces a line, and so does any
    column for a file of the bench.
    """
    if given.cell is None or CONSTANT in column.spots:
        return
    stated = given.reading(None)
    readings = enumerate(column.readings)
    different = [run for run, reading in readings if differ(stated, reading)]
    if not different:
        return
    name = squeeze(parse_header(column.header).name).lower()
    is_named = name == squeeze(column.role)
    if given.place is None or is_named or not roles.BY_NAME[column.role].part:
        faults.add("line_not_used", given.place, given=given, header=column.header)
        return
    run = different[0]
    values = {"role": column.role, "given": given, "header": column.header}
    says = column.readings[run].text
    faults.add("line_and_column", column.cell(run), says=says, **values)
