"""Back to a file: `Readings` as a canonical CSV log that reads back equal, and a blank log to fill in."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from itertools import pairwise

from msgspec import Struct
from msgspec.structs import replace

from gyrodata.diagnostics import TEMPLATE_VALUE_CANNOT_BE_READ
from gyrodata.errors import InputError
from gyrodata.quantities import Quantity, parse_quantity
from gyrodata.readings.cells import PREFIX, CellError, read_cell
from gyrodata.readings.lablog import Column, Readings, header_of
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
    return _sheet(readings, "").text()


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
    sheet = _sheet(readings, "?")
    readings = _joined(readings)
    errors = [one for one in readings.diagnostics if one.severity == "error"]
    if not errors:
        return sheet.text(), ()
    left = [one.message for one in errors if one.line is None]
    wrong = {one.line for one in errors}
    for number, line in enumerate(readings.source_text.splitlines(), 1):
        if number in wrong and line.startswith("#"):
            sheet.head.append(line)
            left.append(f"the line {line}")
    for header, texts in readings.unread:
        sheet.columns.append((header, [texts[row[0]] for row in sheet.rows]))
        left.append(f'the column "{header}": its name, or its unit')
    repeated = any(len(row) > 1 for row in sheet.rows)
    for row in sheet.rows:
        for role, column in readings.columns.items():
            for k, run in enumerate(row if role == "time" else row[:1], 1):
                reading, name = column.readings[run], f"time_{k}" if role == "time" and repeated else role
                if reading.text and reading.value is None:
                    written = f', written "{reading.text}"'
                    left.append(f"{name} of run {_label(readings, row)}{written}")
    return sheet.text(), tuple(left or [one.message for one in errors])


class _Sheet(Struct):
    """The parts of a log."""

    head: list[str]
    """The lines above the table."""
    columns: list[tuple[str, list[str]]]
    """Header and cells."""
    rows: list[list[int]]
    """The runs of each row."""

    def text(self) -> str:
        lines = [[header for header, _ in self.columns], *zip(*(texts for _, texts in self.columns), strict=True)]
        return "\n".join([*self.head, *(",".join(map(_quoted, line)) for line in lines)]) + "\n"


def _sheet(readings: Readings, unread: str) -> _Sheet:
    """Write each part of a log; `unread` is for a cell that was not read, if a blank one would repeat another."""
    readings = _joined(readings)
    rows = _rows(readings)
    head = _head(readings)
    columns: list[tuple[str, list[str]]] = []
    for role in sorted(readings.columns, key=ROLES.index):
        column = readings.columns[role]
        if role == "time":
            most = max((len(row) for row in rows), default=1)
            for k in range(most):
                texts = [_cell_text(column, row[k]) if k < len(row) else "" for row in rows]
                columns.append((header_of("time" if most == 1 else f"time_{k + 1}", column.unit), texts))
        else:
            mark = "" if readings.ok or role not in FILLED_DOWN else unread
            texts, shared = _column_texts(column, rows, mark)
            head += [f"# {role}: {shared}"] if shared else []
            columns += [(header_of(role, column.unit), texts)] if any(texts) or not shared else []
        texts = _uncertainty_texts(readings, column, rows)
        columns += [(header_of(f"u_{role}", SI[kind_of_role(role)]), texts)] if any(texts) else []
    columns.append(("run", [_label(readings, row) for row in rows]))
    if any(readings.notes):
        columns.append(("note", [readings.notes[row[0]] for row in rows]))
    return _Sheet(head, columns, rows)


def _head(readings: Readings) -> list[str]:
    """Write the lines above the table, for what holds for the whole log."""
    lines: dict[str, str | None] = {**readings.metadata}
    lines |= {f"{PREFIX}{key}": reported.text for key, reported in readings.reported.items()}
    lines |= {key: f"{value!r} {SI[kind_of_role(key)]}" for key, value in readings.constants.items()}
    lines |= {key: _uncertainty_text(u, kind_of_role(key)) for key, u in readings.uncertainties.items()}
    if readings.balance_tilt is not None:
        lines["balance_tilt"] = "{!r} rad in {!r} s".format(*readings.balance_tilt)
    if readings.balance_drift is not None:
        lines["balance_drift"] = "{!r} rad in {!r} s at {!r} rad/s".format(*readings.balance_drift)
    words = {None: None, True: "yes", False: "no"}
    lines |= {"motion": readings.motion, "balanced": words[readings.balanced], "position_from": readings.position_from}
    # The digits with which the length is written say how well it is known, and they are lost above.
    key, factor = ("u_rod_length", 1) if readings.position_from == "tip" else ("u_ball_diameter", 2)
    if readings.origin_u and key not in lines:
        lines[key] = f"{factor * readings.origin_u!r} m"
    return [f"# {key}: {value}" for key, value in lines.items() if value is not None]


def _joined(readings: Readings) -> Readings:
    """Put the runs in which the rod did not move behind the others."""
    last = readings.unmoved
    if last is None:
        return readings
    columns = {}
    for role, column in readings.columns.items():
        more = last.columns[role]
        columns[role] = replace(column, readings=column.readings + more.readings, spots=column.spots + more.spots)
    unread = tuple((head, texts + more) for (head, texts), (_, more) in zip(readings.unread, last.unread, strict=True))
    runs, lines, notes = readings.runs + last.runs, readings.lines + last.lines, readings.notes + last.notes
    return replace(readings, runs=runs, lines=lines, notes=notes, columns=columns, unread=unread, unmoved=None)


def _rows(readings: Readings) -> list[list[int]]:
    """Group the runs that were repeats of one row (``3.1``, ``3.2``)."""
    rows: list[list[int]] = []
    turns = readings.columns.get("turns")
    for run, label in enumerate(readings.runs):
        base, _, number = label.rpartition(".")
        first = rows[-1][0] if rows else run
        of_one_row = (readings.runs[first], readings.lines[first]) == (f"{base}.1", readings.lines[run])
        # Times of other turns are no repeats of one setting.
        alike = turns is None or turns.values[first] == turns.values[run]
        if rows and of_one_row and alike and number == str(len(rows[-1]) + 1):
            rows[-1].append(run)
        else:
            rows.append([run])
    return rows


def _label(readings: Readings, row: list[int]) -> str:
    label = readings.runs[row[0]]
    return label.rpartition(".")[0] if len(row) > 1 else label


def _read(text: str, column: Column) -> Quantity | None:
    """Read a text as a cell of a column; "none" is a weight, and no number."""
    try:
        return read_cell(text, kind_of_role(column.role), column.unit or None)
    except CellError:
        return None


def _cell_text(column: Column, run: int) -> str:
    """Give what was typed, with a decimal point; a number without a text (from a simulation) is written in full."""
    value, text = column.readings[run].value, column.readings[run].text
    if value is None:
        return ""
    if text:
        # Between other commas, a decimal comma may be taken for one that parts thousands.
        with_point = text.replace(",", ".")
        if with_point != text and (read := _read(with_point, column)) and read.value == value:
            return with_point
        # A header may count halves or thirds of a turn, and the new one does not.
        read = _read(text, column) if column.role in COUNTS else None
        if read is None or math.isclose(read.value, value):
            return text
    return repr(from_si(value, column.unit, kind_of_role(column.role)) if column.unit else value)


def _column_texts(column: Column, rows: list[list[int]], mark: str) -> tuple[list[str], str]:
    """Write the cells of a column, with a mark where one was not read, and the text that all blank ones share."""
    ids = [column.spots[row[0]] for row in rows]
    # What was merged is merged again; what one line gave for the whole log becomes one line again.
    fills = column.role in FILLED_DOWN and column.role not in COUNTS and not column.header.startswith(("#", "--"))
    if BY_NAME[column.role].part == "spin" and 2 * sum(one == next_one for one, next_one in pairwise(ids)) < len(ids):
        fills = False  # a blank cell is an error if nearly every run has its own spin
    shared = _shared(ids, fills, [column.readings[row[0]].value is not None for row in rows])
    texts: list[str] = []
    for i, row in enumerate(rows):
        reading = column.readings[row[0]]
        if ids[i] == shared or (i > 0 and fills and shared is None and ids[i] == ids[i - 1]):
            texts.append("")
        else:
            texts.append(mark if mark and reading.text and reading.value is None else _cell_text(column, row[0]))
    if shared is None:
        return texts, ""
    return texts, _line_text(_cell_text(column, rows[ids.index(shared)][0]), column)


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


def _uncertainty_texts(readings: Readings, column: Column, rows: list[list[int]]) -> list[str]:
    """Write the uncertainty of each reading that stands neither in its cell nor above the table."""
    common = stated_u(column.role, readings.uncertainties)
    texts: list[str] = []
    for reading in (column.readings[row[0]] for row in rows):
        own = _read(reading.text, column) if reading.u else None
        told = reading.u is None or reading.u == common or (own is not None and reading.u == own.uncertainty)
        texts.append("" if told or reading.u is None else _uncertainty_text(reading.u, kind_of_role(column.role)))
    return texts


def _uncertainty_text(uncertainty: Uncertainty, kind: str) -> str:
    # The shortest percentage that gives exactly this share when it is read.
    percent = uncertainty.relative * 100
    short = round(percent, 12)
    share = f"{short if short / 100 == uncertainty.relative else percent!r} %"
    absolute = f"{uncertainty.absolute!r} {SI[kind]}".strip()
    if not uncertainty.absolute:
        return share
    return f"{share} + {absolute}" if uncertainty.relative else absolute


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
    masses = _shown(weights, "mass", "g", "--weights", 2)
    [arm] = _shown([position], "length", "cm", "--position", 1)
    aims = _shown(spins, "rate", "rpm", "--spins", 0)
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


def _shown(texts: Sequence[str], kind: str, unit: str, option: str, digits: int) -> list[str]:
    """Write the values of an option in one unit, with at least so many digits."""
    code, shown = TEMPLATE_VALUE_CANNOT_BE_READ, []
    if not texts:
        example = "20g,40g,60g" if kind == "mass" else "200,400,600rpm"
        raise InputError.of(code, f"{option}: nothing is given", f"for example {option} {example}")
    for text in dict.fromkeys(texts):
        try:
            value = from_si(parse_quantity(text, kind), unit, kind)
        except UnitError as error:
            several = "" if kind == "length" else "; part several with commas"
            raise InputError.of(code, f"{option}: {error}", f"{error.hint}{several}") from None
        if kind != "length" and value <= 0:
            hint = "the run without a weight is in every log" if kind == "mass" else "write it without its sign"
            raise InputError.of(code, f'{option}: "{text}" is not above zero', hint)
        short = f"{value:.10g}"
        shown.append(short if len(short.partition(".")[2]) >= digits else f"{value:.{digits}f}")
    return shown
