"""Two readings that make one quantity: start and stop of a clock, "412 - 398", turns of the ball with their time."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from decimal import Decimal, DecimalException

from msgspec.structs import replace

from gyrodata.diagnostics import HEADER_READ_AS
from gyrodata.quantities import fold_number
from gyrodata.readings.headers import Header, clock_word, parse_header
from gyrodata.readings.lablog import Faults
from gyrodata.readings.layout import Layout
from gyrodata.readings.source import Row

_PAIR = re.compile(r"([0-9]+(?:[.,][0-9]+)?)\s*(?:-|->|→|/|to|bis|à|до)\s*([0-9]+(?:[.,][0-9]+)?)")
_CLOCK = re.compile(r"(?:([0-9]{1,2}):)?([0-9]{1,2}):([0-9]{2}(?:[.,][0-9]+)?)|([0-9]+(?:[.,][0-9]+)?)")


def combine(layout: Layout, faults: Faults) -> Layout:
    """Add the columns that two readings make, each with a note.

    Parameters
    ----------
    layout : Layout
        A table of runs.
    faults : Faults
        Takes the notes.

    Returns
    -------
    Layout
        The same table if there is no such pair.
    """
    return _turns_of_the_ball(_difference(_two_spins(layout, faults), faults), faults)


def _two_spins(layout: Layout, faults: Faults) -> Layout:
    """Read "412 - 398" as the spin at the start and at the end of the run."""
    for at, header in enumerate(layout.headers):
        pairs = [_PAIR.fullmatch(fold_number(row.texts[at])) if at < len(row.texts) else None for row in layout.rows]
        if header.roles == ("spin",) and all(pairs):
            message = f'"{header.text}" has two readings in each cell: the spin at the start and at the end'
            faults.add(HEADER_READ_AS, message, "if they are not, write them in columns of their own", layout.cells[at])
            for name, part in (("spin_start", 1), ("spin_end", 2)):
                texts = [pair[part] for pair in pairs if pair]
                layout = _with_column(layout, at, replace(header, roles=(name,)), texts, {at})
            break
    return layout


def _difference(layout: Layout, faults: Faults) -> Layout:
    """Take the difference of a clock's readings at the start and at the stop of each run as its time."""
    if any({"time", "precession_period"}.intersection(header.roles) for header in layout.headers):
        return layout
    clocks = {clock_word(header.text): at for at, header in enumerate(layout.headers) if _is_clock(header)}
    if not {"start", "stop"} <= set(clocks):
        return layout
    start, stop = clocks["start"], clocks["stop"]
    texts = _computed(layout, (start, stop), lambda early, late: late - early, _seconds)
    if not texts or any(text.startswith("-") for text in texts):
        return layout
    names = f'"{layout.cells[stop].text}" minus "{layout.cells[start].text}"'
    message = f"{names} is read as the time of each run, in s"
    faults.add(HEADER_READ_AS, message, "if it is not, write a column time [s]", layout.cells[start])
    return _with_column(layout, stop, parse_header("time [s]"), texts, {start, stop})


def _turns_of_the_ball(layout: Layout, faults: Faults) -> Layout:
    """Read the times of several turns of the ball, before and after a run, as periods of the spin."""
    places = {header.text.partition("[")[0].strip(" ("): at for at, header in enumerate(layout.headers)}
    turns = next((at for at, header in enumerate(layout.headers) if header.roles == ("spin_turns",)), None)
    if turns is None or not {"spin_time_start", "spin_time_end"} <= set(places):
        return layout
    for end in ("start", "end"):
        at = places[f"spin_time_{end}"]
        texts, unit = _computed(layout, (turns, at), lambda count, time: time / count, _number), layout.headers[at].unit
        if not texts or unit is None:
            return layout
        message = f'"{layout.cells[at].text}" over "{layout.cells[turns].text}" is read as the time of one turn'
        faults.add(HEADER_READ_AS, message, "", layout.cells[at])
        layout = _with_column(layout, at, parse_header(f"spin_period_{end} [{unit}]"), texts, {turns, at})
    return layout


_Operation = Callable[[Decimal, Decimal], Decimal]
_Reader = Callable[[str], Decimal]


def _is_clock(header: Header) -> bool:
    return header.unit in (None, "s") and not any(role.startswith("spin_") for role in header.roles)


def _number(text: str) -> Decimal:
    return Decimal(fold_number(text).replace(",", "."))


def _seconds(text: str) -> Decimal:
    match = _CLOCK.fullmatch(fold_number(text))
    if match is None:
        raise DecimalException(text)
    if match[4]:
        return _number(match[4])
    return 3600 * int(match[1] or 0) + 60 * int(match[2]) + _number(match[3])


def _computed(layout: Layout, places: tuple[int, int], operation: _Operation, read: _Reader) -> list[str]:
    """Compute a number from two cells of each row; nothing if a cell cannot be read."""
    texts = []
    for row in layout.rows:
        try:
            value = operation(*(read(row.texts[at]) for at in places))
        except (DecimalException, IndexError):
            return []
        texts.append(f"{value:f}" if len(value.as_tuple().digits) < 9 else f"{value:.5f}")
    return texts


def _with_column(layout: Layout, at: int, header: Header, texts: Sequence[str], used: set[int]) -> Layout:
    """Add a column made of `used`, whose cells are at the places of another column."""
    rows, places = [], (*range(len(layout.cells)), at)
    for row, text in zip(layout.rows, texts, strict=True):
        written = [row.texts[k] if k < len(row.texts) else "" for k in places]
        rows.append(Row(row.line, [*written[:-1], text], tuple(row.spot(k) for k in places)))
    headers = [*layout.headers, replace(header, text=layout.headers[at].text)]
    cells = [*layout.cells, layout.cells[at]]
    return replace(layout, cells=cells, headers=headers, rows=rows, combined=layout.combined | used)
