"""Compare the turns that headers, lines and notes state with those of the table."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

from gyrodata.quantities.notation import read_cell, to_float
from gyrodata.quantities.units import UnitError
from gyrodata.readings import layout, roles, source
from gyrodata.readings.cells import part_counted, rounded_turns
from gyrodata.readings.chosen import Chosen
from gyrodata.readings.lablog import Column, Faults, Reading, Text
from gyrodata.readings.roles import turns_in
from gyrodata.readings.settings import Settings

_SMALL_DOUBT = 0.002
"""Error of rounded turns, as a share of them, that is too small for a warning."""
_AGREE = 0.02
"""Largest difference of turns that agree."""
TIMES_OF = {"turns": "time", "spin_turns": "spin_time"}
"""Time whose header may state turns, by the role of these turns."""


def add_stated_turns(
    columns: dict[str, Column],
    role: str,
    times: list[Chosen],
    runs: list[Chosen],
    settings: Settings,
    table: layout.Layout,
    faults: Faults,
) -> None:
    """Give each run the turns that the header of its time states.

    `times` are the columns of the times, and `runs` the one of each run. Report other
    turns of a column.
    """
    stating = [time for time in times if time.turns]
    counts = {time.turns: read_turns(time.turns, time.cell, faults) for time in stating}
    if not runs or None in counts.values():
        return
    u = roles.stated_u(role, settings.uncertainties)
    readings = [
        Reading(counts[time.turns], None, u, time.turns) if time.turns else Reading()
        for time in runs
    ]
    given = _given_turns(columns, role)
    if given is not None:
        if role == "turns":
            _compare_with_headers(given, readings, runs, faults)
        return
    headers = source.Row(table.cells[0].place.line, [])
    spots = [headers.spot(time.at) for time in runs]
    columns[role] = Column(
        role,
        stating[0].text,
        "",
        tuple(readings),
        tuple(spots),
        find=table.grid.place_of,
    )
    said = [f'{role} is {one.turns} by the header "{one.text}"' for one in stating]
    faults.add("turns_in_header", times[0].cell, said="; ".join(said))


def _given_turns(columns: Mapping[str, Column], role: str) -> Column | None:
    if role in columns or role != "turns":
        return columns.get(role)
    return columns.get("angle")


def _compare_with_headers(
    given: Column, stated: list[Reading], runs: list[Chosen], faults: Faults
) -> None:
    """Report the first run whose turns differ from those of its header."""
    if given.header.startswith("--"):
        return
    for run, (turns, reading) in enumerate(zip(_turns_of(given), stated, strict=True)):
        if not turns or not reading.value:
            continue
        if abs(turns - reading.value) > _AGREE * reading.value:
            values = {"header": runs[run].text, "turns": reading.text}
            values |= {"other": given.header, "says": given.readings[run].text}
            faults.add("turns_contradict_header", given.place(run), **values)
            return


def _turns_of(counted: Column) -> list[float]:
    """Return the turns of each run in a column of turns or of angles; 0 if not known."""
    full = 2 * math.pi if counted.role == "angle" else 1.0
    return [(value or 0.0) / full for value in counted.values]


def read_turns(turns: str, cell: Text | None, faults: Faults) -> float | None:
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


def compare_with_texts(
    columns: Mapping[str, Column],
    settings: Settings,
    table: layout.Layout,
    faults: Faults,
) -> None:
    """Report each line that states turns with which no run agrees.

    It is an error if the column of turns may number the runs.
    """
    names = [
        role for role in ("turns", "angle", "precession_period") if role in columns
    ]
    if not names or columns[names[0]].header.startswith("--"):
        return
    counted = columns[names[0]]
    is_counter = roles.squeeze(counted.header).lower() in roles.COUNTER_WORDS
    is_period = counted.role == "precession_period"
    lines = _lines_with_turns(table)
    if is_counter and (given := settings.roles.get("turns")):
        lines[f"{given.label}: {given.text}"] = given.text, None
    values = [1.0] if is_period else _turns_of(counted)
    for line, (turns, cell) in lines.items():
        count = read_turns(turns, cell, faults)
        if count is None or any(abs(value - count) < _AGREE for value in values):
            continue
        if is_counter:
            said = {"line": line, "turns": turns, "header": counted.header}
            says = counted.readings[0].text
            faults.add("turns_contradict_line", counted.place(0), says=says, **said)
        else:
            role = "time" if is_period else "number of turns"
            faults.add("note", note=line, role=role)


def _lines_with_turns(table: layout.Layout) -> dict[str, tuple[str, Text | None]]:
    """Return the turns and the place of each text that states how many were timed."""
    heads = [cell.text for cell in table.cells]
    lines: dict[str, tuple[str, Text | None]] = {}
    for cell in layout.places_of(table.grid):
        is_header = all(head in cell.text for head in heads)
        turns = "" if is_header else turns_in(cell.text)
        # A run without a weight has 0 turns.
        if turns not in ("", "0") and _is_about_times(cell.text):
            lines[cell.text] = turns, cell
    return lines


def _is_about_times(text: str) -> bool:
    if re.search(layout.TIMED, text):
        return True
    words = {word.rstrip("s") for word in roles.squeezed_words(text)}
    if not layout.TIME_WORDS.isdisjoint(words):
        return True
    return "turns" in layout.said_in(source.Row(1, [text]))


def warn_of_rounded_turns(turns: Column, faults: Faults) -> None:
    """Warn of turns such as 0.33, which are not exactly a third."""
    if part_counted(roles.parse_header(turns.header)):
        return
    texts = [reading.text if reading.u is None else "" for reading in turns.readings]
    for text in dict.fromkeys(texts):
        if not re.search("[.,]", text):
            continue
        meant, doubt = rounded_turns(text)
        if meant and doubt > _SMALL_DOUBT * to_float(text):
            place = turns.place(texts.index(text))
            faults.add("rounded", place, text=text, doubt=doubt, meant=meant)
