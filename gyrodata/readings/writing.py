"""Write `Readings` as a canonical CSV log."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

from msgspec.structs import replace

from gyrodata.base.errors import Diagnostic
from gyrodata.quantities.notation import Quantity, read_cell
from gyrodata.quantities.units import SI, Uncertainty, UnitError, from_si
from gyrodata.readings.headers import parse_header
from gyrodata.readings.lablog import Column, Readings, header_of, split_lines
from gyrodata.readings.roles import (
    BY_NAME,
    COUNTS,
    ORIGIN_LENGTHS,
    REPORTED,
    ROLES,
    TEXTS,
    kind_of_role,
    stated_u,
)
from gyrodata.readings.settings import form_of

SIMULATED = "Simulated, not measured"
"""What the first line of every simulated log says."""

_CONSTANT = -1
"""Number of the cell of a value that is valid for the whole log."""
_PLACES = ("position_set", "position_from")
_Columns = list[tuple[str, list[str]]]
"""Header and cells of each column."""


def write_log(readings: Readings) -> str:
    """Write a log in its canonical form: ``#`` lines, one header, one row per setting.

    Parameters
    ----------
    readings : Readings
        What to write. A second column of a role (`Readings.others`) is left out.

    Returns
    -------
    str
        CSV text; `read_log` gives the same runs, columns, constants and uncertainties
        for it (places, lines and headers are those of the new file). Columns that were
        not understood (`Readings.unread`) are behind the others, as they were written.
    """
    return fixed_log(readings)[0]


def fixed_log(readings: Readings) -> tuple[str, tuple[str, ...]]:
    """Write a log as it was understood, and list what was not understood.

    Parameters
    ----------
    readings : Readings
        What to write; it may contain errors.

    Returns
    -------
    text : str
        CSV text like that of `write_log`. A cell that could not be read is ``?``, and a
        row without a time is behind ``# left out``. If the log contains an error, ``#``
        lines that were not understood are as in the file.
    left : tuple of str
        What the author of the log has to correct, the rows without a time included.
    """
    readings = _joined(readings)
    head, columns = _parts(readings)
    columns += _unread(readings)
    untimed = list(map("line {}: it has no time".format, readings.untimed))
    head += _rows_without_time(readings)
    errors = _errors_in(readings)
    if not errors:
        return _text(head, columns), tuple(untimed)
    lines = _lines_with_errors(readings, errors)
    left = [error.message for error in errors if error.line is None]
    left += [f"the line {line}" for line in lines]
    for header, _ in readings.unread:
        if TEXTS.isdisjoint(parse_header(header).roles):
            left.append(f'the column "{header}": its name, or its unit')
    left += _unread_cells(readings)
    left += untimed
    left = left or [error.message for error in errors]
    return _text([*head, *lines], columns), tuple(left)


def _errors_in(readings: Readings) -> list[Diagnostic]:
    return [fault for fault in readings.diagnostics if fault.severity == "error"]


def _rows_without_time(readings: Readings) -> list[str]:
    """Return the rows without a time as ``#`` lines."""
    source = split_lines(readings.source_text)
    return [f"# left out: {source[line - 1]}" for line in readings.untimed]


def _lines_with_errors(readings: Readings, errors: list[Diagnostic]) -> list[str]:
    """Return the ``#`` lines that were not understood."""
    wrong = {error.line for error in errors}
    lines = enumerate(split_lines(readings.source_text), 1)
    wrong_lines = [line for number, line in lines if number in wrong]
    return [line for line in wrong_lines if line.startswith("#")]


def _unread_cells(readings: Readings) -> Iterator[str]:
    for role, column in readings.columns.items():
        typed = [reading.text for reading in column.readings]
        for run, text in enumerate(_without_repeats(typed, column.spots)):
            if text and column.readings[run].value is None:
                yield f'{role} of run {readings.runs[run]}, written "{text}"'


def _text(head: list[str], columns: _Columns) -> str:
    whole = [(header, *texts) for header, texts in columns]
    rows = zip(*whole, strict=True)
    lines = [",".join(map(_quoted, row)) for row in rows]
    return "\n".join([*head, *lines]) + "\n"


def _quoted(cell: str) -> str:
    """Write a cell, in quotes if a reader of CSV would change it."""
    is_plain = cell.strip() == cell and not cell.startswith("#")
    if is_plain and not set(cell) & set('",;\t'):
        return cell
    return '"' + cell.replace('"', '""') + '"'


def _without_repeats(texts: Sequence[str], cells: Sequence[int]) -> list[str]:
    """Replace a text by a blank one if it is from the same cell as the text above."""
    without = list(texts)
    for at, (above, cell) in enumerate(pairwise(cells), 1):
        if cell == above:
            without[at] = ""
    return without


def _unread(readings: Readings) -> _Columns:
    """Return the columns that were not understood, as in the file."""
    return [
        (header, _without_repeats(texts, readings.lines))
        for header, texts in readings.unread
    ]


# Columns


def _parts(readings: Readings) -> tuple[list[str], _Columns]:
    """Write the lines above the table, and its columns."""
    head = _head(readings)
    columns: _Columns = []
    for role in sorted(readings.columns, key=ROLES.index):
        column = readings.columns[role]
        if _CONSTANT in column.spots:
            head.append(_constant_line(column))
        texts = _column_texts(column)
        if any(texts) or _CONSTANT not in column.spots:
            columns.append((header_of(role, column.unit), texts))
        spreads = _spread_texts(column, stated_u(role, readings.uncertainties))
        if any(spreads):
            header = header_of(f"u_{role}", SI[kind_of_role(role)])
            columns.append((header, spreads))
    columns.append(("run", [*readings.runs]))
    others = {"note": readings.notes, "screw": readings.screws, "day": readings.blocks}
    for header, cells in others.items():
        if any(cells):
            columns.append((header, [*cells]))
    return head, columns


def _constant_line(column: Column) -> str:
    """Write a value for the whole log as a line again."""
    text = _cell_text(column, column.spots.index(_CONSTANT))
    if _read(text, kind_of_role(column.role), None) is None:
        text = f"{text} {column.unit}"
    return f"# {column.role}: {text}".rstrip()


def _column_texts(column: Column) -> list[str]:
    """Write the cells of a column.

    One cell becomes one cell again. But if nearly every run has its own weight or spin,
    a blank one is an error for the reader (`filling`), so that all are written.
    """
    texts = [_cell_text(column, run) for run in range(len(column.readings))]
    if _CONSTANT in column.spots:
        pairs = zip(column.spots, texts, strict=True)
        return ["" if spot == _CONSTANT else text for spot, text in pairs]
    part = BY_NAME[column.role].part
    once = _without_repeats(texts, column.spots)
    blank = once.count("")
    are_weights = part == "load" and 8 * blank >= len(texts)
    are_spins = part == "spin" and 2 * blank >= len(texts)
    return once if are_weights or are_spins else texts


def _spread_texts(column: Column, common: Uncertainty | None) -> list[str]:
    """Write the uncertainties that neither a cell nor the whole log states."""
    kind = kind_of_role(column.role)
    texts = []
    for reading in column.readings:
        read = _read(reading.text, kind, column.unit or None)
        known = (None, common, read and read.uncertainty)
        u = None if reading.u in known else reading.u
        texts.append(uncertainty_text(u, kind) if u else "")
    return texts


def _head(readings: Readings) -> list[str]:
    """Write the lines above the table, with the values for the whole log."""
    lines: dict[str, str | None] = {**readings.metadata}
    for key, reported in readings.reported.items():
        lines[f"{REPORTED}{key}"] = reported.text
    for key, value in readings.constants.items():
        lines[key] = f"{value!r} {SI[kind_of_role(key)]}"
    for key, u in readings.uncertainties.items():
        lines[key] = uncertainty_text(u, kind_of_role(key))
    lines["balance_tilt"] = _several(readings.balance_tilt, "balance_tilt")
    lines["balance_drift"] = _several(readings.balance_drift, "balance_drift")
    lines["falling_mass"] = _several(readings.falling_mass, "falling_mass")
    falls = [_several(fall, "spin_down") or "" for fall in readings.spin_down]
    lines["spin_down"] = "; ".join(falls) or None
    words = {True: "yes", False: "no"}
    for key in ("tachometer", "motion", "balanced", "balance", *_PLACES):
        value = getattr(readings, key)
        lines[key] = words.get(value, value)
    if readings.origin_u:
        # The digits with which the length is written say how well it is known, and they
        # are lost above.
        key, share, _ = ORIGIN_LENGTHS[str(readings.position_from)]
        lines.setdefault(f"u_{key}", f"{readings.origin_u / share!r} m")
    return [f"# {key}: {value}" for key, value in lines.items() if value is not None]


def _several(numbers: tuple[float, ...] | None, key: str) -> str | None:
    """Write a line of several quantities; None if there are none."""
    if not numbers:
        return None
    form, kinds = form_of(key)
    pairs = zip(numbers, kinds, strict=True)
    texts = [f"{number!r} {SI[kind]}" for number, kind in pairs]
    return form.format(*texts)


def _joined(readings: Readings) -> Readings:
    """Add the runs in which the rod did not move behind the others."""
    last = readings.unmoved
    if last is None:
        return readings
    columns = {}
    for role, column in readings.columns.items():
        more = last.columns[role]
        both = column.readings + more.readings
        columns[role] = replace(column, readings=both, spots=column.spots + more.spots)
    unread = []
    for first, second in zip(readings.unread, last.unread, strict=True):
        header, texts = first
        unread.append((header, texts + second[1]))
    return replace(
        readings,
        runs=readings.runs + last.runs,
        lines=readings.lines + last.lines,
        notes=readings.notes + last.notes,
        screws=readings.screws + last.screws,
        blocks=readings.blocks + last.blocks,
        columns=columns,
        unread=tuple(unread),
        unmoved=None,
    )


# Numbers


def _read(text: str, kind: str, unit: str | None) -> Quantity | None:
    """Read a text as a cell; None for a text that is not a number."""
    try:
        return read_cell(text, kind, unit) if text else None
    except UnitError:
        return None


def _cell_text(column: Column, run: int) -> str:
    """Return what was typed, with a decimal point.

    A number without a text (from a simulation) is written in full.
    """
    value = column.readings[run].value
    text = column.readings[run].text
    if value is None:
        return "?" if text else ""
    kind = kind_of_role(column.role)
    unit = column.unit or None
    read = _read(text, kind, unit)
    is_count = column.role in COUNTS
    # A header may count halves or thirds of a turn, and the new one does not.
    is_part = is_count and read and not math.isclose(read.value, value)
    if not text or is_part:
        return repr(from_si(value, unit, kind) if unit else value)
    return _with_point(text, kind, unit)


def _with_point(text: str, kind: str, unit: str | None) -> str:
    """Write a decimal comma as a point.

    Between other commas, it may look like a mark between thousands.
    """
    pointed = text.replace(",", ".")
    read = _read(text, kind, unit)
    other = _read(pointed, kind, unit)
    if read is None or other is None or other.value != read.value:
        return text
    return pointed


def uncertainty_text(u: Uncertainty, kind: str) -> str:
    """Write an uncertainty: "0.1 % + 0.01 s"."""
    # The shortest percentage that gives exactly this share when it is read.
    percent = 100 * u.relative
    short = round(percent, 12)
    share = f"{short if short / 100 == u.relative else percent!r} %"
    absolute = f"{u.absolute!r} {SI[kind]}".strip()
    if not u.absolute:
        return share
    return f"{share} + {absolute}" if u.relative > 0 else absolute
