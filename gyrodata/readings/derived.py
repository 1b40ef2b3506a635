"""Add the columns that follow from others: a time from two clock readings, or a period.

The columns "spin_turns" with "spin_time_start" and "spin_time_end" are usual for a
large disk.
"""

from __future__ import annotations

from collections.abc import Iterator
from decimal import Decimal, DecimalException

from msgspec import Struct
from msgspec.structs import replace

from gyrodata.quantities.numerals import fold_number
from gyrodata.readings import layout, roles
from gyrodata.readings.chosen import cells_of
from gyrodata.readings.grid import Row
from gyrodata.readings.headers import Header, parse_header
from gyrodata.readings.lablog import Faults
from gyrodata.readings.words import squeeze

_TIME = "time [s]"
"""End of a run in the name of a role, by the word of a clock."""


class Derived(Struct, frozen=True):
    """A column that follows from a column and the texts of another one."""

    name: str
    """Its header."""
    at: int
    """Number of the first column."""
    second: str
    """Header of the second column, or what replaces it."""
    seconds: tuple[str, ...]
    """Texts of the second column."""

    @property
    def sign(self) -> str:
        """Return what is done with both columns, in words."""
        return "minus" if self.name == _TIME else "over"

    def texts(self, table: layout.Layout) -> list[str] | None:
        """Return the new cells; None if one of them cannot be calculated."""
        pairs = zip(cells_of(table, self.at), self.seconds, strict=True)
        try:
            texts = [self._text(_seconds(one), _seconds(other)) for one, other in pairs]
        except DecimalException:
            return None
        return None if any(text.startswith("-") for text in texts) else texts

    def _text(self, one: Decimal, other: Decimal) -> str:
        return f"{one - other:f}" if self.sign == "minus" else f"{one / other:.7g}"


def with_derived_columns(table: layout.Layout, faults: Faults) -> layout.Layout:
    """Add the columns that follow from others, until one cannot be calculated."""
    for derived in derived_columns(table):
        texts = derived.texts(table)
        if texts is None:
            return table
        cell = table.cells[derived.at]
        values = {"sign": derived.sign, "second": derived.second}
        faults.add("read_as", cell, name=derived.name, **values)
        table = _with_column(table, derived, texts)
    return table


def derived_columns(table: layout.Layout) -> list[Derived]:
    """Return the derived columns of a table; none if its own columns are complete."""
    names = [role for header in table.headers for role in header.roles]
    is_timed = not set(roles.TIMINGS).isdisjoint(names)
    is_plain = len(set(names)) == len(names) and "spin_turns" not in names
    if is_timed and is_plain:
        return []
    return [*([] if is_timed else _elapsed_time(table)), *_spin_periods(table)]


def _elapsed_time(table: layout.Layout) -> Iterator[Derived]:
    """Yield the time between the start and the stop of a running clock."""
    clocks = {
        header.moment: at
        for at, header in enumerate(table.headers)
        if _may_be_clock(table, at)
    }
    if {"start", "end"} <= clocks.keys():
        start = clocks["start"]
        second = table.cells[start].text
        yield Derived(_TIME, clocks["end"], second, cells_of(table, start))


def _may_be_clock(table: layout.Layout, at: int) -> bool:
    """Return whether a column contains times of a clock; frames of a video are none."""
    header = table.headers[at]
    if header.roles or header.unit not in (None, "s"):
        return False
    return header.unit == "s" or any(":" in text for text in cells_of(table, at))


def _spin_periods(table: layout.Layout) -> Iterator[Derived]:
    """Yield the periods of a ball whose turns are timed before and after each run."""
    for end in ("start", "end"):
        yield from _period_of_counted_turns(table, end)
        for at, header in enumerate(table.headers):
            # "Time of 10 rotations of the disk, before [s]"
            of_ball = header.is_of_the_spin
            turns = header.turns
            if of_ball and turns and header.moment == end:
                texts = (turns,) * len(table.rows)
                yield Derived(f"spin_period_{end} [s]", at, turns, texts)


def _period_of_counted_turns(table: layout.Layout, end: str) -> Iterator[Derived]:
    """Yield the period at one end, if a column or a line counts the turns of the ball."""
    names = [_name(header) for header in table.headers]
    if f"spintime{end}" not in names:
        return
    at, name = names.index(f"spintime{end}"), f"spin_period_{end} [s]"
    stated = {key.lower(): text.text for key, text in table.grid.metadata}
    counts = [n for n, one in enumerate(table.headers) if "spin_turns" in one.roles]
    if counts:
        second = table.cells[counts[0]].text
        yield Derived(name, at, second, cells_of(table, counts[0]))
    elif "spin_turns" in stated:
        texts = (stated["spin_turns"],) * len(table.rows)
        yield Derived(name, at, "spin_turns", texts)


def _name(header: Header) -> str:
    return squeeze(header.name).lower()


def _seconds(text: str) -> Decimal:
    """Read the time of a clock, "12:01:10.25" or "1:10", or a plain number."""
    plain = fold_number(text.partition(" (")[0]).replace(",", ".")
    total = Decimal()
    for part in plain.split(":"):
        total = 60 * total + Decimal(part)
    return total


def _with_column(
    table: layout.Layout, derived: Derived, texts: list[str]
) -> layout.Layout:
    """Return a table with one more column, whose cells have the places of the first."""
    width, at = len(table.cells), derived.at
    rows = []
    for row, text in zip(table.rows, texts, strict=True):
        spots = (*map(row.spot, range(width)), row.spot(at))
        rows.append(Row(row.line, [*row.texts[:width], text], spots))
    header = replace(parse_header(derived.name), text=table.headers[at].text)
    cells = [*table.cells, table.cells[at]]
    return layout.Layout(table.grid, cells, [*table.headers, header], rows)
