"""Compare what headers, lines and second columns state with the columns in use."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from itertools import pairwise

from gyrodata.quantities.notation import read_cell
from gyrodata.quantities.units import Uncertainty, UnitError, kinds_of, parse_unit
from gyrodata.readings import layout, roles
from gyrodata.readings.captions import ROLE_OF_KIND
from gyrodata.readings.cells import part_counted, rounded_turns
from gyrodata.readings.grid import Row
from gyrodata.readings.headers import may_number, parse_header
from gyrodata.readings.lablog import Column, Faults, Reading, Text
from gyrodata.readings.layout import Chosen, note_unused
from gyrodata.readings.names import (
    COUNTER_WORDS,
    TOKENS,
    fold_name,
    is_of_the_spin,
    origin_in,
    squeeze,
)
from gyrodata.readings.notes import CORRECTED
from gyrodata.readings.settings import Setting
from gyrodata.readings.turns import turns_in
from gyrodata.readings.unusual_headers import IN

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
    two_units = (used.header.unit, column.header.unit)
    if role == "time" and two_units == ("min", "s"):
        faults.add("minutes_and_seconds", column.cell, header=used.header.text)
        return True
    usual_origin = origin_in(used.header.text)
    origin = origin_in(column.header.text)
    from_elsewhere = role == "position" and origin not in ("", usual_origin)
    if role not in roles.TEXTS and not role.startswith("u_") and not from_elsewhere:
        return False
    why = f'is not used: {role} is read from "{used.header.text}"'
    note_unused(column, why, faults)
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
        is_of_run = roles.BY_NAME[other.role].part != ""
        if used is None or other.role in decided or not is_of_run:
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
    """Return whether a second column has means, numbers of runs or hours of the day.

    Examples are "n", and "Time" next to "time [s]".
    """
    header = parse_header(other.header)
    if header.is_of_means or may_number(header):
        return True
    is_bare = other.role == "time" and header.unit is None
    return is_bare and parse_header(used.header).unit is not None


def compare_with_line(column: Column, setting: Setting, faults: Faults) -> None:
    """Ask which is right, if a line of the log gives another value than a whole column.

    A column with the name of the quantity itself replaces a line, and so does any
    column for a file of the bench.
    """
    if setting.cell is None or CONSTANT in column.spots:
        return
    stated = setting.reading(None)
    readings = enumerate(column.readings)
    different = [run for run, reading in readings if differ(stated, reading)]
    if not different:
        return
    header = parse_header(column.header)
    name = fold_name(header.name)
    is_named = name == squeeze(column.role)
    if setting.place is None or is_named or not roles.BY_NAME[column.role].part:
        faults.add("line_not_used", setting.place, given=setting, header=column.header)
        return
    run = different[0]
    values = {"role": column.role, "given": setting, "header": column.header}
    says = column.readings[run].text
    faults.add("line_and_column", column.cell(run), says=says, **values)


_SMALL_DOUBT = 0.002
"""Error of rounded turns, as a share of them, that is too small for a warning."""
_AGREE = 0.02
"""Largest difference of turns that agree."""
# --- Turns ---


def counted_turns(columns: Mapping[str, Column]) -> Column | None:
    """Return the column of the turns or of the swept angle; None without one."""
    return columns.get("turns") or columns.get("angle")


def use_turns_of_headers(
    columns: dict[str, Column],
    runs: list[Chosen],
    table: layout.Layout,
    u: Uncertainty | None,
    faults: Faults,
) -> None:
    """Give each run the turns that the header of its time states.

    `runs` are the columns of the time of each run. Report other turns of a column.
    """
    stating = list({run.at: run for run in runs if run.turns}.values())
    stated = {"": Reading()}
    for time in stating:
        turns = _read_turns(time.turns, time.cell, faults)
        if turns is None:
            return
        stated[time.turns] = Reading(turns, None, u, time.turns)
    counted = counted_turns(columns)
    readings = [stated[run.turns] for run in runs]
    headers = [run.text for run in runs]
    if counted is None:
        row = Row(table.cells[0].place.line, [])
        spots = tuple([row.spot(run.at) for run in runs])
        header = stating[0].text
        find = table.grid.place_of
        columns["turns"] = Column(
            "turns", header, "", tuple(readings), spots, find=find
        )
        said = "; ".join(
            f'turns is {each.turns} by the header "{each.text}"' for each in stating
        )
        faults.add("turns_in_header", stating[0].cell, said=said)
    else:
        _compare_turns(counted, readings, headers, faults)


def compare_turns_with_angle(turns: Column, angle: Column, faults: Faults) -> None:
    """Report the first run whose turns and swept angle contradict each other."""
    swept = turns_of(angle)
    readings = [Reading(turns, text=f"{turns:.4g}") for turns in swept]
    _compare_turns(turns, readings, [angle.header] * len(swept), faults)


def _compare_turns(
    counted: Column, stated: list[Reading], headers: list[str], faults: Faults
) -> None:
    """Report the first run whose turns differ from those that a header states.

    Turns that an option gives are decided.
    """
    if counted.header.startswith("--"):
        return
    for run, (turns, reading) in enumerate(zip(turns_of(counted), stated, strict=True)):
        if not turns or not reading.value:
            continue
        if abs(turns - reading.value) > _AGREE * reading.value:
            values = {"header": headers[run], "turns": reading.text}
            values |= {"other": counted.header, "says": counted.readings[run].text}
            faults.add("turns_contradict_header", counted.place(run), **values)
            return


def compare_turns_with_texts(
    columns: Mapping[str, Column], table: layout.Layout, faults: Faults
) -> None:
    """Report each sentence that states turns with which no run agrees."""
    counted = counted_turns(columns) or columns.get("precession_period")
    if counted is None or counted.header.startswith("--"):
        return
    known = turns_of(counted)
    for sentence in table.sentences:
        turns = _turns_in(sentence, faults)
        if not turns:
            continue
        gaps = [abs(count - turns) for count in known]
        if min(gaps) >= _AGREE:
            _report_sentence(sentence, counted, table, faults)


def _turns_in(sentence: Text, faults: Faults) -> float | None:
    """Return the turns of the rod that a sentence states, if they are above 0."""
    stated = turns_in(sentence.text)
    # A run without a weight has 0 turns.
    if stated in ("", "0") or is_of_the_spin(sentence.text):
        return None
    return _read_turns(stated, sentence, faults)


def _report_sentence(
    sentence: Text, counted: Column, table: layout.Layout, faults: Faults
) -> None:
    """Report a sentence with other turns than all runs.

    It is an error if a header or another sentence states the turns of the runs, or if
    their column may number them.
    """
    place = counted.place(0)
    lines = {row.line for row in table.rows}
    is_line = counted.header.startswith("#")
    is_typed = is_line or place is None or place.line in lines
    if not is_typed or _may_number_runs(counted):
        values = {"header": counted.header, "turns": counted.readings[0].text}
        values |= {"other": sentence.text, "says": turns_in(sentence.text)}
        faults.add("turns_contradict_header", sentence, **values)
        return
    role = "time" if counted.role == "precession_period" else "number of turns"
    faults.add("note", sentence, note=sentence.text, role=role)


def _may_number_runs(turns: Column) -> bool:
    """Return whether a column of turns has a name such as "Lap", "N" or "count"."""
    is_counter = fold_name(turns.header) in COUNTER_WORDS
    return is_counter or may_number(parse_header(turns.header))


def ask_if_runs_are_counted(
    turns: Column, sentences: list[Text], faults: Faults
) -> None:
    """Ask whether a column numbers the runs, if it counts 1, 2, 3, ….

    It may begin again at 1 if a sentence states turns.
    """
    if not _may_number_runs(turns):
        return
    counts = [value or 0.0 for value in turns.values]
    if len(counts) < 4 or max(counts) <= 1:
        return
    steps = pairwise([0, *counts])
    if not all(after in (1, before + 1) for before, after in steps):
        return
    is_stated = any(turns_in(sentence.text) for sentence in sentences)
    if is_stated or counts.count(1) == 1:
        faults.add("turns_or_runs", turns.cell(0), header=turns.header)


def turns_of(counted: Column) -> list[float]:
    """Return the turns of each run by turns, angles or periods; 0 if unknown."""
    if counted.role == "precession_period":
        return [1.0] * len(counted.readings)
    full = 2 * math.pi if counted.role == "angle" else 1.0
    return [(value or 0.0) / full for value in counted.values]


def _read_turns(turns: str, cell: Text | None, faults: Faults) -> float | None:
    """Read the turns that a line or a header states.

    None, with an error, for an impossible number.
    """
    try:
        count = read_cell(turns, "number", "").value
    except UnitError as error:
        faults.add("stated_turns", cell, turns=turns, fault=error, hint=error.hint)
        return None
    fault, hint = roles.check_value("turns", count)
    if fault:
        faults.add("stated_turns", cell, turns=turns, fault=fault, hint=hint)
    return None if fault else count


def warn_of_rounded_turns(turns: Column, faults: Faults) -> None:
    """Warn of turns such as 0.33, which are not exactly a third."""
    if part_counted(parse_header(turns.header)):
        return
    texts = [reading.text if reading.u is None else "" for reading in turns.readings]
    values = {reading.text: reading.value or 0.0 for reading in turns.readings}
    for text in dict.fromkeys(texts):
        if "." not in text and "," not in text:
            continue
        meant, doubt = rounded_turns(text, values[text])
        if meant and doubt > _SMALL_DOUBT * values[text]:
            run = texts.index(text)
            place = turns.place(run)
            faults.add("rounded", place, text=text, doubt=doubt, meant=meant)


# Sentences about the readings


def warn_of_units(
    sentences: Iterable[Text], columns: Mapping[str, Column], faults: Faults
) -> None:
    """Warn of each sentence that names another unit than a header.

    A sentence that may change a reading for another reason is a doubt already.
    """
    doubts = {fault.line for fault in faults.diagnostics if fault.doubt == "note"}
    for sentence in sentences:
        if sentence.place.line in doubts:
            continue
        for kind, factors in _units_in(sentence.text).items():
            column = columns.get(ROLE_OF_KIND[kind])
            if column is None or not column.unit:
                continue
            if parse_unit(column.unit, kind).factor not in factors:
                note = sentence.text
                faults.add("unit_in_note", sentence, note=note, column=column)


def _units_in(note: str) -> dict[str, set[float]]:
    """Return the size of the units in a note, as "x is in inches, not cm", by kind."""
    units: dict[str, set[float]] = {}
    words = [word.strip(".:!?'\"=") for word in TOKENS.split(note.lower())]
    for before, word in pairwise(["", *words]):
        kind = "".join(kinds_of(word))
        # "per minute" and "m" are not units of a column.
        is_sure = before in IN or (len(word) > 2 and kind != "time")
        if kind in ROLE_OF_KIND and word != "in" and is_sure and before not in _NOT:
            units.setdefault(kind, set()).add(parse_unit(word, kind).factor)
    return {} if CORRECTED.is_in(note) else units


_NOT = ("not", "nicht", "pas", "no", "non")
