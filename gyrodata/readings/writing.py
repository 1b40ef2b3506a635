"""Back to a file: `Readings` as a canonical CSV log that reads back equal, and a blank log to fill in."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from contextlib import suppress
from itertools import pairwise

from msgspec.structs import replace

from gyrodata.diagnostics import TEMPLATE_VALUE_CANNOT_BE_READ
from gyrodata.errors import Diagnostic, InputError
from gyrodata.quantities import parse_quantity
from gyrodata.readings.cells import PREFIX, CellError, read_cell
from gyrodata.readings.lablog import TOLD_BLANK, Column, Readings
from gyrodata.readings.roles import BY_NAME, COUNTS, FILLED_DOWN, ROLES, kind_of_role, stated_u
from gyrodata.units import SI, Uncertainty, UnitError, from_si


def write_log(readings: Readings) -> str:
    """Write a log in its canonical form: ``#`` lines, one header row, one row for each setting.

    Parameters
    ----------
    readings : Readings
        What to write. Columns that are only compared (`Readings.others`) are left out.

    Returns
    -------
    str
        CSV text; `read_log` gives the same runs, columns, constants and uncertainties for it (places, lines and
        headers are those of the new file).
    """
    return _text(*_parts(readings, ""))


def fixed_log(readings: Readings) -> tuple[str, tuple[str, ...]]:
    """Write a log as it was understood, with blanks where it was not, and list these.

    Parameters
    ----------
    readings : Readings
        What to write; it may contain errors.

    Returns
    -------
    text : str
        CSV text, as `write_log` gives it. A cell that could not be read is blank, or ``?`` if a blank cell would
        repeat the one above. Columns and ``#`` lines that were not understood are as in the file if the log contains
        an error; else such columns are left out.
    left : tuple of str
        What is left for the author of the log; empty if the log contains no error.
    """
    if readings.unmoved is not None:
        readings = _joined(readings, readings.unmoved)
    head, headers, cells, rows = _parts(readings, "?")
    errors = [one for one in readings.diagnostics if one.severity == "error"]
    left = [one.message for one in errors if one.line is None]
    wrong = {one.line for one in errors}
    for number, line in enumerate(readings.source_text.splitlines(), 1):
        if number in wrong and line.startswith("#"):
            head.append(line)
            left.append(f"the line {line}")
    # Without an error nobody needs them, and under the new headers they may mean something else.
    for header, texts in readings.unread if errors else ():
        headers.append(header)
        cells.append([texts[row[0]] for row in rows])
        left.append(f'the column "{header}": its name, or its unit')
    repeated = any(len(row) > 1 for row in rows)
    for row in rows if errors else []:
        for role, column in readings.columns.items():
            for k, run in enumerate(row if role == "time" else row[:1], 1):
                reading, name = column.readings[run], f"time_{k}" if role == "time" and repeated else role
                if reading.text and reading.value is None:
                    written = f', written "{reading.text}"' if reading.text != TOLD_BLANK else ""
                    left.append(f"{name} of run {_label(readings, row)}{written}")
    return _text(head, headers, cells, rows), tuple(left or [one.message for one in errors])


Parts = tuple[list[str], list[str], list[list[str]], list[list[int]]]
"""The lines above the table, the headers, the cells of each column, and the runs of each row."""


def _text(head: list[str], headers: list[str], cells: list[list[str]], rows: list[list[int]]) -> str:
    lines = [headers, *([column[i] for column in cells] for i in range(len(rows)))]
    return "\n".join([*head, *(",".join(map(_quoted, line)) for line in lines)]) + "\n"


def _parts(readings: Readings, unread: str) -> Parts:
    """Write each part of a log; `unread` is for a cell that was not read, if a blank one would repeat another."""
    if readings.unmoved is not None:
        readings = _joined(readings, readings.unmoved)
    rows = _rows(readings)
    head = [f"# {key}: {value}" for key, value in readings.metadata.items()]
    head += [f"# {PREFIX}{key}: {reported.text}" for key, reported in readings.reported.items()]
    head += [f"# {key}: {value!r} {SI[kind_of_role(key)]}" for key, value in readings.constants.items()]
    head += [f"# {key}: {_uncertainty_text(u, kind_of_role(key))}" for key, u in readings.uncertainties.items()]
    if readings.balance_tilt is not None:
        head.append("# balance_tilt: {!r} rad in {!r} s".format(*readings.balance_tilt))
    if readings.balance_drift is not None:
        head.append("# balance_drift: {!r} rad in {!r} s at {!r} rad/s".format(*readings.balance_drift))
    if readings.motion is not None:
        head.append(f"# motion: {readings.motion}")
    if readings.balanced is not None:
        head.append(f"# balanced: {'yes' if readings.balanced else 'no'}")
    if readings.position_from is not None:
        head.append(f"# position_from: {readings.position_from}")
        key, factor = {"tip": ("u_rod_length", 1), "surface": ("u_ball_diameter", 2)}.get(
            readings.position_from, ("", 0)
        )
        if key and key not in readings.uncertainties:
            # The digits with which the length is written say how well it is known, and they are lost above.
            head.append(f"# {key}: {factor * readings.origin_u!r} m")
    headers: list[str] = []
    cells: list[list[str]] = []
    for role in sorted(readings.columns, key=ROLES.index):
        column = readings.columns[role]
        if role == "time":
            _add_times(column, rows, headers, cells)
        else:
            mark = "" if readings.ok or role not in FILLED_DOWN else unread
            shared = _add_column(column, rows, headers, cells, mark)
            head += [f"# {role}: {shared}"] if shared else []
        _add_uncertainties(readings, column, rows, headers, cells)
    headers.append("run")
    cells.append([_label(readings, row) for row in rows])
    if any(readings.notes):
        headers.append("note")
        cells.append([readings.notes[row[0]] for row in rows])
    return head, headers, cells, rows


def _joined(first: Readings, last: Readings) -> Readings:
    """Put the runs of two parts of one log together again."""
    columns = {
        role: replace(
            column,
            readings=column.readings + last.columns[role].readings,
            spots=column.spots + last.columns[role].spots,
        )
        for role, column in first.columns.items()
    }
    return replace(
        first, runs=first.runs + last.runs, lines=first.lines + last.lines, notes=first.notes + last.notes,
        columns=columns, unmoved=None,
        unread=tuple(
            (header, texts + more)
            for (header, texts), (_, more) in zip(first.unread, last.unread, strict=True)
        ),
    )  # fmt: skip


def _rows(readings: Readings) -> list[list[int]]:
    """Group the runs that were repeats of one row (``3.1``, ``3.2``)."""
    rows: list[list[int]] = []
    for run, label in enumerate(readings.runs):
        base, _, number = label.rpartition(".")
        if rows and number.isdigit() and int(number) == len(rows[-1]) + 1 and int(number) > 1:
            first = rows[-1][0]
            # Times of other turns are no repeats of one setting.
            if "turns" in readings.columns and len({readings.columns["turns"].values[i] for i in (first, run)}) > 1:
                rows.append([run])
                continue
            if readings.runs[first] == f"{base}.1" and readings.lines[first] == readings.lines[run]:
                rows[-1].append(run)
                continue
        rows.append([run])
    return rows


def _label(readings: Readings, row: list[int]) -> str:
    label = readings.runs[row[0]]
    return label.rpartition(".")[0] if len(row) > 1 else label


def _header(role: str, unit: str) -> str:
    return f"{role} [{unit}]" if unit else role


def _cell_text(column: Column, run: int) -> str:
    """Give what was typed, with a decimal point; a number without a text (from a simulation) is written in full."""
    value, text = column.readings[run].value, column.readings[run].text
    if value is None or text:
        return _with_point(text, value, column) if value is not None else ""
    return _number(value, column)


def _number(value: float, column: Column) -> str:
    return repr(from_si(value, column.unit, kind_of_role(column.role)) if column.unit else value)


def _with_point(text: str, value: float, column: Column) -> str:
    """Write a decimal comma as a point: between other commas it may be taken for one that parts thousands."""
    changed = text.replace(",", ".")
    if changed != text:
        with suppress(CellError):
            if read_cell(changed, kind_of_role(column.role), column.unit or None).value == value:
                return changed
    if column.role in COUNTS:
        with suppress(CellError):
            # Its header counts halves or thirds of a turn, and the new one does not.
            if not math.isclose(read_cell(text, kind_of_role(column.role), None).value or 0.0, value):
                return _number(value, column)
    return text


def _add_times(column: Column, rows: list[list[int]], headers: list[str], cells: list[list[str]]) -> None:
    most = max((len(row) for row in rows), default=1)
    for k in range(most):
        headers.append(_header("time" if most == 1 else f"time_{k + 1}", column.unit))
        cells.append([_cell_text(column, row[k]) if k < len(row) else "" for row in rows])


def _add_column(column: Column, rows: list[list[int]], headers: list[str], cells: list[list[str]], mark: str) -> str:
    """Add one column, with a mark in cells that were not read; give the text that all blank cells share, if any."""
    ids = [column.spots[row[0]] for row in rows]
    # What was merged is merged again; what one line gave for the whole log becomes one line again.
    fills = column.role in FILLED_DOWN and column.role not in COUNTS and not column.header.startswith(("#", "--"))
    if BY_NAME[column.role].part == "spin" and 2 * sum(one == next_one for one, next_one in pairwise(ids)) < len(ids):
        fills = False  # a blank cell is an error if nearly every run has its own spin
    shared = _shared(ids, fills, [column.readings[row[0]].value is not None for row in rows])
    texts: list[str] = []
    for i, row in enumerate(rows):
        repeated = i > 0 and fills and shared is None and ids[i] == ids[i - 1]
        lost = mark and column.readings[row[0]].value is None and column.readings[row[0]].text
        text = mark if lost else _cell_text(column, row[0])
        texts.append("" if repeated or ids[i] == shared else text)
    if any(texts) or shared is None:
        headers.append(_header(column.role, column.unit))
        cells.append(texts)
    if shared is None:
        return ""
    return _line_text(_cell_text(column, rows[ids.index(shared)][0]), column)


def _line_text(text: str, column: Column) -> str:
    """Write a cell's text so that it stands by itself: with its unit, and without a comma that may part thousands."""
    with_point = text.replace(",", ".")
    for line in (text, f"{text} {column.unit}", with_point):
        try:
            read_cell(line, kind_of_role(column.role), None, ask=True)
        except CellError:
            continue
        return line
    return f"{with_point} {column.unit}"


def _shared(ids: list[int], fills: bool, there: list[bool]) -> int | None:
    """Find the reading that stands in rows which filling down cannot reach."""
    last: dict[int, int] = {}
    for i, identity in enumerate(ids):
        if identity in last and there[i] and (not fills or last[identity] != i - 1):
            return identity
        last[identity] = i
    return None


def _add_uncertainties(
    readings: Readings, column: Column, rows: list[list[int]], headers: list[str], cells: list[list[str]]
) -> None:
    """Add a ``u_…`` column where a reading's uncertainty is neither in its cell nor the log's."""
    role, kind = column.role, kind_of_role(column.role)
    common = stated_u(role, readings.uncertainties)
    texts: list[str] = []
    for row in rows:
        spread, text = column.readings[row[0]].u, column.readings[row[0]].text
        own = None
        with suppress(CellError):  # "none" is a weight, and no number; what was simulated has no text
            own = read_cell(text, kind, column.unit or None).uncertainty
        texts.append("" if spread is None or spread in (own, common) else _uncertainty_text(spread, kind))
    if any(texts):
        headers.append(_header(f"u_{role}", SI[kind]))
        cells.append(texts)


def _uncertainty_text(uncertainty: Uncertainty, kind: str) -> str:
    parts = []
    if uncertainty.relative or not uncertainty.absolute:
        parts.append(f"{_percent(uncertainty.relative)} %")
    if uncertainty.absolute:
        parts.append(f"{uncertainty.absolute!r} {SI[kind]}".strip())
    return " + ".join(parts)


def _percent(share: float) -> str:
    """Find the percentage that gives exactly this share when it is read, the shortest first."""
    percent = share * 100
    short = round(percent, 12)
    return repr(short if short / 100 == share else percent)


def _quoted(text: str) -> str:
    if re.search(r'[",;\t]|^[\s#]|\s$', text):
        return '"' + text.replace('"', '""') + '"'
    return text


def blank_log(weights: Sequence[str], position: str, spins: Sequence[str]) -> str:
    """Write a log to fill in: each weight with each spin, a run without a weight, and the first run once more.

    The weights take turns, so that a balance that drifts during the session is no slope in the torque.

    Parameters
    ----------
    weights : sequence of str
        Masses with their units, such as ``20 g``; repeats are kept once.
    position : str
        Where the weights sit, such as ``15 cm``.
    spins : sequence of str
        Spins to aim at, such as ``400 rpm``. They go into the notes: what is read off goes into the column.

    Returns
    -------
    str
        CSV text that `read_log` reads without a diagnostic once spin, time and turns are filled in.

    Raises
    ------
    InputError
        A value cannot be read.
    """
    # With the digits that a scale and a ruler show: what is left to be written is seen to be.
    masses = [_shown(text, "mass", "g", "--weights", 2) for text in dict.fromkeys(weights)]
    arm = _shown(position, "length", "cm", "--position", 1)
    aims = [_shown(text, "rate", "rpm", "--spins") for text in dict.fromkeys(spins)]
    for option, values, example in (("--weights", masses, "20g,40g,60g"), ("--spins", aims, "200,400,600rpm")):
        if not values:
            hint = f"for example {option} {example}"
            raise InputError([Diagnostic(TEMPLATE_VALUE_CANNOT_BE_READ, "error", f"{option}: nothing is given", hint)])
    lines = [
        "# station: ",
        "# ball_mass: ",
        "# ball_diameter: ",
        "# latitude: ",
        "# balanced: ",
        "# Write balanced yes if the ball, without weight or spin, stays where it is put (step 2); else no.",
        "# Write the ball's mass and diameter and your latitude with a unit, such as 4.31 kg, 10.16 cm, 52.5 deg.",
        "# Fill in spin, time and turns of each run: the spin as read at half time, the turns as 1/3, 2/3 or 1.",
        "# Keep this order: the weights take turns, so that a balance that drifts meets all of them alike.",
        "# Write masses and positions anew, with every digit that the scale and the ruler show.",
        "# Positions count from the centre of the ball to the middle of the weight.",
        "# Write ccw or cw, seen from above, in the row without a weight and in one with a weight.",
        "# If the rod does not move without a weight, time 2 minutes and write 0 turns.",
        "# More runs: more rows. A run that was not timed: leave its time blank.",
        "# A row that is filled in: 20.05,14.9,203,20.31,1,ccw,",
        "mass [g],position [cm],spin [rpm],time [s],turns,precession_sense,note",
    ]
    taken = [0] * len(masses)
    order = _in_turn(len(masses), len(aims))
    for place, weight in enumerate(order, 1):
        if weight is None:
            lines.append(f"0,,,,,,no weight on the rod; aim at {aims[len(aims) // 2]} rpm")
            continue
        # Each weight begins with another spin, so that the spins take turns too.
        aim = aims[(weight + taken[weight]) % len(aims)]
        taken[weight] += 1
        again = "the first run once more; " if place == len(order) else ""
        lines.append(f"{masses[weight]},{arm},,,,,{again}aim at {aim} rpm")
    return "\n".join(lines) + "\n"


def _in_turn(weights: int, times: int) -> list[int | None]:
    """Order the runs: each weight so many times, none (None) in the middle, the first once more at the end.

    No weight comes twice in a row, and the mean place of each is the middle, as nearly as that can be.
    """
    count = weights * times + 2
    middle = count // 2
    order: list[int | None] = [0] * count
    order[middle] = None
    late = [0.0] * weights
    todo = set(range(1, weights))
    for place in (place for place in range(1, count - 1) if place != middle):
        todo = todo or set(range(weights))
        weight = max(todo - {order[place - 1]} or todo, key=lambda one: (late[one], -one))
        order[place] = weight
        late[weight] += place - (count - 1) / 2
        todo.discard(weight)
    return order


def _shown(text: str, kind: str, unit: str, option: str, digits: int = 0) -> str:
    try:
        value = from_si(parse_quantity(text, kind), unit, kind)
    except UnitError as error:
        several = "" if kind == "length" else "; part several with commas"
        raise InputError(
            [Diagnostic(TEMPLATE_VALUE_CANNOT_BE_READ, "error", f"{option}: {error}", f"{error.hint}{several}")]
        ) from None
    if kind != "length" and value <= 0:
        hint = "the run without a weight is in every log" if kind == "mass" else "write it without its sign"
        message = f'{option}: "{text}" is not above zero'
        raise InputError([Diagnostic(TEMPLATE_VALUE_CANNOT_BE_READ, "error", message, hint)])
    short = f"{value:.10g}"
    return short if len(short.partition(".")[2]) >= digits else f"{value:.{digits}f}"
