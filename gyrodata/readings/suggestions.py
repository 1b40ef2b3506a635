"""Propose how to add a missing quantity: a guess from the log, and every other way."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from functools import cached_property
from itertools import chain

from msgspec import Struct

from gyrodata.quantities import units
from gyrodata.readings import layout, roles
from gyrodata.readings.captions import quoted, turns_stated
from gyrodata.readings.grid import is_bare
from gyrodata.readings.headers import counts_weights, unused_words
from gyrodata.readings.lablog import Faults, header_of, listing
from gyrodata.readings.layout import Choice, Chosen
from gyrodata.readings.names import DIAMETER, PRECESSION, numbered
from gyrodata.readings.roles import kind_of_role
from gyrodata.readings.unnamed import suggest_role

_QUOTED = frozenset('",;\t')
"""Signs of a cell that is written in quotes."""


class Lack(Struct, frozen=True, dict=True):
    """A role that a log lacks, and the columns that may contain it."""

    role: str
    missing: tuple[str, ...]
    """All roles that the log lacks, this one included."""
    choice: Choice
    stated: Collection[str] = ()
    """Turns that sentences of the log state, if the turns are missing."""

    @property
    def unit(self) -> str:
        """Usual unit of the role."""
        return units.DISPLAY[kind_of_role(self.role)]

    @property
    def known(self) -> roles.Role:
        """Facts about the role."""
        return roles.BY_NAME[self.role]

    @property
    def question(self) -> str:
        """The role and its meaning."""
        question = f"{self.role} is missing"
        if self.known.meaning:
            question += f" ({self.known.meaning})"
        return question

    def named(self, column: Chosen | None = None) -> str:
        """Return the header that names the role, with a column's unit if it fits."""
        if column and kind_of_role(self.role) in column.kinds:
            return header_of(self.role, column.header.unit)
        return header_of(self.role, self.unit)

    @cached_property
    def likely(self) -> list[Chosen]:
        """Columns without a role that may contain it, by name or else by unit."""
        # The start of a clock is not a reading.
        unplaced = [
            column for column in self.choice.unplaced if not column.header.moment
        ]
        named = [each for each in unplaced if not is_nameless(each)]
        if self._is_only_gap(named):
            return named
        fitting = [each for each in unplaced if kind_of_role(self.role) in each.kinds]
        nameless = list(filter(is_nameless, unplaced))
        return self._similar(named) or fitting or nameless

    @cached_property
    def instead(self) -> str:
        """What to write instead of a diameter, or of numbers of weights; else ""."""
        headers = [column.header for column in self.likely]
        if self.role == "mass" and any(map(counts_weights, headers)):
            return "the mass of all the weights that hang there"
        is_diameter = any(DIAMETER.is_in(header.text) for header in headers)
        return "half of it" if self.role == "position" and is_diameter else ""

    def _similar(self, named: list[Chosen]) -> list[Chosen]:
        """Return the columns whose name is nearly one of the role."""
        kind = kind_of_role(self.role)
        fitting = [column for column in named if kind in (column.kinds or (kind,))]
        similar = [each for each in fitting if suggest_role(each.text) == self.role]
        if self.role == "turns":
            return list(filter(_may_be_turns, similar or named))
        return similar

    def _is_only_gap(self, named: list[Chosen]) -> bool:
        """Return whether one role is missing, and one column without a unit is left."""
        if self.role not in ("mass", "spin") or len(self.missing) > 1:
            return False
        return [column.header.unit for column in named] == [None]


def is_nameless(column: Chosen) -> bool:
    """Return whether a column has no header."""
    return column.text.removeprefix("column ").isdecimal()


def _may_be_turns(column: Chosen) -> bool:
    """Return whether a column contains numbers without a unit."""
    texts = column.filled()
    return column.header.unit is None and all(map(is_bare, texts))


# A guess


def _guess(lack: Lack) -> str:
    """Say which column may be the role; "" if no column of the log may be it."""
    rates = lack.choice.columns("precession_rate")
    if lack.role == "spin" and rates:
        return _may_be_spin(rates[0].text)
    no_time = lack.role == "turns" and "time" in lack.missing
    if len(lack.likely) != 1 or no_time:
        return _start_and_stop(lack)
    [column] = lack.likely
    if lack.role == "turns":
        return _what_it_counts(column)
    if words := _timed_turns(lack):
        return _time_of_turns(column.text, words)
    if lack.instead:
        return f'for each "{column.text}" write {lack.instead}, below "{lack.named()}"'
    meaning = lack.known.meaning
    more = FROM_SURFACE * (lack.role == "position")
    return (
        f'if "{column.text}" is {meaning}, write "{lack.named(column)}" above it '
        f'instead, or type --map {lack.role}="{column.text}"{more}'
    )


def _may_be_spin(header: str) -> str:
    """Ask if a rate of precession is the spin: the lab sheet calls it a rotation."""
    if PRECESSION.is_in(header):
        return ""
    return (
        f'is it "{header}", which is read as the rate of the precession? --map '
        f'spin="{header}"'
    )


def _time_of_turns(header: str, words: str) -> str:
    """Say how the header of a time states its turns."""
    return (
        f'"{header}" contains "{words}": if it is the time of a part of a turn, or of '
        'several turns, write "time for 1/2 turn [s]" above it, with the number of its '
        "turns; if it is the sum of several times, write their mean"
    )


def _timed_turns(lack: Lack) -> str:
    """Return the number in a time's header that gyro does not understand; else ""."""
    headers = [column.header for column in lack.likely if lack.role == "time"]
    # "T_P_1" is the first of several times.
    headers = [header for header in headers if numbered(header.name)[1] is None]
    return " ".join(chain.from_iterable(map(unused_words, headers)))


def _start_and_stop(lack: Lack) -> str:
    """Say what to write for the start and the stop of a clock; "" without both."""
    clocks = [column for column in lack.choice.unplaced if "time" in column.kinds]
    texts = {column.header.moment: column.text for column in clocks}
    if lack.role != "time" or not texts.keys() >= {"start", "end"}:
        return ""
    difference = f'"{texts["end"]}" minus "{texts["start"]}"'
    return f'write {difference} in a column "{lack.named()}"'


FROM_SURFACE = (
    '; if it is from the surface of the ball, write also the lines "# position_from: '
    'surface" and "# ball_diameter: 10.16 cm"'
)


def _what_it_counts(column: Chosen) -> str:
    """Ask what the only column of numbers without a unit counts."""
    cells = listing(list(dict.fromkeys(column.filled())), 3)
    return (
        f'if "{column.text}" ({cells}) counts turns, write "turns" above it; '
        'if thirds, "thirds of a turn"; if percent, "turns [%]"; '
        'if degrees, "angle [deg]"'
    )


# The question


def ask_for(
    missing: list[str], choice: Choice, table: layout.Layout, faults: Faults
) -> None:
    """Ask for all missing roles in one message.

    If several are missing, the hint begins with the corrected header row.
    """
    stated = {"turns": turns_stated(table.statements)}
    lacks = [
        Lack(role, tuple(missing), choice, stated.get(role, ())) for role in missing
    ]
    message = "; ".join(lack.question for lack in lacks)
    if choice.unplaced:
        texts = [column.text for column in choice.unplaced]
        message += f"; headers that could not be placed: {listing(texts)}"
    message += quoted(set(map(kind_of_role, missing)), table.statements)
    hints = list(map(_how_to_add, lacks))
    row = _corrected_row(lacks, choice, table)
    if row and len(lacks) + len(choice.corrected) > 1:
        hints = [f"write this header row, with the numbers: {row}", *hints]
    faults.add("missing", message=message, hint="\n".join(hints))


def _corrected_row(lacks: list[Lack], choice: Choice, table: layout.Layout) -> str:
    """Return the header row with each missing role above the column that may be it."""
    if any(map(_timed_turns, lacks)):
        return ""  # the header of the time has to state its turns
    headers = dict(choice.corrected)
    for lack in lacks:
        if len(lack.likely) == 1 and not lack.instead:
            [column] = lack.likely
            headers.setdefault(column.at, lack.named(column))
    usual = [lack.named() for lack in lacks]
    added = [header for header in usual if header not in headers.values()]
    return header_row(table, headers, added)


def _how_to_add(lack: Lack) -> str:
    role = lack.role
    known = lack.known
    sample = [*lack.stated, known.sample or f"1 {lack.unit}"][0]
    quoted = f'"{sample}"' if " " in sample else sample
    ways = [f"add a column {lack.named()}"]
    # Several numbers of turns need a column.
    if role != "time" and len(lack.stated) < 2:
        ways.append(f'or a line "# {role}: {sample}"')
        ways.append(f"or --set {role}={quoted}")
    ways.append(
        f"or --map {role}=HEADER to name the column that contains it{known.instead}"
    )
    return "; ".join(filter(None, [_guess(lack), *ways]))


def header_row(
    table: layout.Layout, changes: Mapping[int, str], added: list[str]
) -> str:
    """Return the header row of a log with some headers changed and others added.

    "" if the headers are not in one line of the file.
    """
    typed = list(dict.fromkeys(table.cells))
    lines = {cell.place.line for cell in typed}
    places = {cell.place for cell in typed}
    if len(lines) > 1 or len(places) < len(typed):
        return ""
    headers = [changes.get(table.cells.index(cell), cell.text) for cell in typed]
    return table.grid.delimiter.join(
        header if _QUOTED.isdisjoint(header) else f'"{header}"'
        for header in [*headers, *added]
    )
