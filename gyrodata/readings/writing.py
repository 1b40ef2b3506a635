"""Write `Readings` as a canonical CSV log."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from itertools import pairwise

from msgspec.structs import replace

from gyrodata.quantities.notation import Quantity, read_cell
from gyrodata.quantities.units import SI, Uncertainty, UnitError, from_si
from gyrodata.readings.lablog import Column, Readings, form_of, header_of
from gyrodata.readings.roles import (
    BY_NAME,
    COUNTS,
    ORIGIN_LENGTHS,
    REPORTED,
    ROLES,
    TEXTS,
    kind_of_role,
    parse_header,
    stated_u,
)

SIMULATED = "Simulated, not measured"
"""What the first line of every simulated log says."""

_Columns = list[tuple[str, list[str]]]
"""Header and cells of each column."""


def write_log(readings: Readings) -> str:
    """Write a log in its canonical form: ``#`` lines, one header row, one row for each setting.

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
    readings = _joined(readings)
    head, columns = _parts(readings)
    return _text(head, columns + _unread(readings))


def fixed_log(readings: Readings) -> tuple[str, tuple[str, ...]]:
    """Write a log as it was understood, and list what was not understood.

    Parameters
    ----------
    readings : Readings
        What to write; it may contain errors.

    Returns
    -------
    text : str
        CSV text like that of `write_log`. A cell that could not be read is ``?``. If
        the log contains an error, ``#`` lines that were not understood are as in the
        file.
    left : tuple of str
        What the author of the log has to correct; empty if the log contains no error.
    """
    readings = _joined(readings)
    head, columns = _parts(readings)
    columns += _unread(readings)
    errors = [one for one in readings.diagnostics if one.severity == "error"]
    if not errors:
        return _text(head, columns), ()
    left = [one.message for one in errors if one.line is None]
    wrong = {one.line for one in errors}
    lines = [
        line
        for at, line in enumerate(readings.source_text.splitlines(), 1)
        if at in wrong and line[:1] == "#"
    ]
    left += [f"the line {line}" for line in lines]
    unread = [
        header
        for header, _ in readings.unread
        if TEXTS.isdisjoint(parse_header(header).roles)
    ]
    left += [f'the column "{header}": its name, or its unit' for header in unread]
    for role, column in readings.columns.items():
        for run, text in enumerate(
            _without_repeats([one.text for one in column.readings], column.spots)
        ):
            if text and column.readings[run].value is None:
                left.append(f'{role} of run {readings.runs[run]}, written "{text}"')
    return _text([*head, *lines], columns), tuple(
        left or [one.message for one in errors]
    )


def _text(head: list[str], columns: _Columns) -> str:
    lines = [
        [header for header, _ in columns],
        *zip(*(texts for _, texts in columns), strict=True),
    ]
    needs_quotes = re.compile(r'[",;\t]|^[\s#]|\s$').search
    cells = [
        [
            '"' + cell.replace('"', '""') + '"' if needs_quotes(cell) else cell
            for cell in line
        ]
        for line in lines
    ]
    return "\n".join([*head, *map(",".join, cells)]) + "\n"


def _without_repeats(texts: Sequence[str], cells: Sequence[int]) -> list[str]:
    """Replace a text by a blank one if it is from the same cell as the text above."""
    return [
        "" if cell == above else text
        for text, (above, cell) in zip(texts, pairwise([None, *cells]), strict=True)
    ]


def _unread(readings: Readings) -> _Columns:
    """Return the columns that were not understood, as in the file."""
    return [
        (header, _without_repeats(texts, readings.lines))
        for header, texts in readings.unread
    ]


def _parts(readings: Readings) -> tuple[list[str], _Columns]:
    """Write the lines above the table, and its columns."""
    head = _head(readings)
    columns: _Columns = []
    for role in sorted(readings.columns, key=ROLES.index):
        column, kind, part = (
            readings.columns[role],
            kind_of_role(role),
            BY_NAME[role].part,
        )
        texts = [_cell_text(column, run) for run in range(len(readings.runs))]
        once = _without_repeats(texts, column.spots)
        if -1 in column.spots:
            # A value from a line for the whole log becomes a line again.
            alone = texts[column.spots.index(-1)]
            head.append(
                (
                    f"# {role}: "
                    f"{alone if _read(alone, kind, None) else f'{alone} {column.unit}'}"
                ).rstrip()
            )
            texts = [
                "" if spot == -1 else text
                for spot, text in zip(column.spots, texts, strict=True)
            ]
        elif part == "load" or (part == "spin" and 2 * once.count("") >= len(texts)):
            # One cell becomes one cell again; if nearly every run has its own spin, a
            # blank one is an error.
            texts = once
        columns += (
            [(header_of(role, column.unit), texts)]
            if any(texts) or -1 not in column.spots
            else []
        )
        common = stated_u(role, readings.uncertainties)
        texts = []
        for reading in column.readings:
            read = _read(reading.text, kind, column.unit or None)
            known = reading.u is None or reading.u in (
                common,
                read and read.uncertainty,
            )
            texts.append(
                "" if known else uncertainty_text(reading.u or Uncertainty(), kind)
            )
        columns += [(header_of(f"u_{role}", SI[kind]), texts)] if any(texts) else []
    columns.append(("run", [*readings.runs]))
    columns += [("note", [*readings.notes])] if any(readings.notes) else []
    return head, columns


def _head(readings: Readings) -> list[str]:
    """Write the lines above the table, with the values for the whole log."""
    lines: dict[str, str | None] = {**readings.metadata}
    lines |= {
        f"{REPORTED}{key}": reported.text for key, reported in readings.reported.items()
    }
    lines |= {
        key: f"{value!r} {SI[kind_of_role(key)]}"
        for key, value in readings.constants.items()
    }
    lines |= {
        key: uncertainty_text(u, kind_of_role(key))
        for key, u in readings.uncertainties.items()
    }
    for key in ("balance_tilt", "balance_drift", "falling_mass", "spin_down"):
        form, kinds = form_of(key)
        values = getattr(readings, key) or ()
        # Only a spin-down may have several lines.
        if values and key != "spin_down":
            values = (values,)
        for numbers in values:
            text = form.format(
                *(
                    f"{number!r} {SI[kind]}"
                    for number, kind in zip(numbers, kinds, strict=True)
                )
            )
            lines[key] = f"{lines[key]}; {text}" if key in lines else text
    words = {None: None, True: "yes", False: "no"}
    lines["tachometer"] = readings.tachometer
    lines |= {
        "motion": readings.motion,
        "balanced": words[readings.balanced],
        "balance": readings.balance,
        "position_from": readings.position_from,
    }
    # The digits with which the length is written say how well it is known, and they are
    # lost above.
    key, share, _ = ORIGIN_LENGTHS.get(readings.position_from or "", ("", 1.0, ""))
    if readings.origin_u and f"u_{key}" not in lines:
        lines[f"u_{key}"] = f"{readings.origin_u / share!r} m"
    return [f"# {key}: {value}" for key, value in lines.items() if value is not None]


def _joined(readings: Readings) -> Readings:
    """Add the runs in which the rod did not move behind the others."""
    last = readings.unmoved
    if last is None:
        return readings
    columns = {}
    for role, column in readings.columns.items():
        more = last.columns[role]
        columns[role] = replace(
            column,
            readings=column.readings + more.readings,
            spots=column.spots + more.spots,
        )
    unread = tuple(
        (head, texts + more)
        for (head, texts), (_, more) in zip(readings.unread, last.unread, strict=True)
    )
    runs, lines, notes = (
        readings.runs + last.runs,
        readings.lines + last.lines,
        readings.notes + last.notes,
    )
    return replace(
        readings,
        runs=runs,
        lines=lines,
        notes=notes,
        columns=columns,
        unread=unread,
        unmoved=None,
    )


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
    value, text = column.readings[run].value, column.readings[run].text
    if value is None:
        return "?" if text else ""
    kind, unit = kind_of_role(column.role), column.unit or None
    read = _read(text, kind, unit)
    # A header may count halves or thirds of a turn, and the new one does not.
    if text and (
        read is None or column.role not in COUNTS or math.isclose(read.value, value)
    ):
        # Between other commas, a decimal comma may look like a mark between thousands.
        pointed = _read(text.replace(",", "."), kind, unit)
        return (
            text.replace(",", ".")
            if read and pointed and read.value == pointed.value
            else text
        )
    return repr(from_si(value, unit, kind) if unit else value)


def uncertainty_text(u: Uncertainty, kind: str) -> str:
    """Write an uncertainty: "0.1 % + 0.01 s"."""
    # The shortest percentage that gives exactly this share when it is read.
    percent = next(
        (
            short
            for short in (round(u.relative * 100, 12),)
            if short / 100 == u.relative
        ),
        u.relative * 100,
    )
    terms = [f"{percent!r} %"] * (u.relative > 0 or not u.absolute)
    return " + ".join(
        [*terms, *[f"{u.absolute!r} {SI[kind]}".strip()] * (u.absolute > 0)]
    )
