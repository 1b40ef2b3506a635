"""Propose how to add a missing quantity: a guess from the log, and every other way."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from functools import cached_property

from msgspec import Struct

from gyrodata.quantities import units
from gyrodata.quantities.numerals import to_float
from gyrodata.readings import layout, roles
from gyrodata.readings.chosen import MOST_TURNS, Choice, Chosen
from gyrodata.readings.grid import is_bare
from gyrodata.readings.headers import counts_weights, is_part_of_mass, suggest_role
from gyrodata.readings.lablog import header_of, listing
from gyrodata.readings.remarks import SPHERE, WIDE
from gyrodata.readings.roles import kind_of_role
from gyrodata.readings.words import MAX_HEADER, PRECESSION

_NAMELESS = re.compile("column [0-9]+")
"""The name that a column without a header gets."""
_STATES_COUNT = re.compile(r"(?i)(?<!\w)[0-9]|half")
"""A header of a time that may state its turns."""
_QUOTED = re.compile(r'[",;\t]')


class Lack(Struct, frozen=True, dict=True):
    """A role that a log lacks, and the columns that may contain it."""

    role: str
    missing: tuple[str, ...]
    """All roles that the log lacks, this one included."""
    choice: Choice

    @property
    def unit(self) -> str:
        """Usual unit of the role."""
        return units.DISPLAY[kind_of_role(self.role)]

    @property
    def named(self) -> str:
        """Header that names the role."""
        return header_of(self.role, self.unit)

    @cached_property
    def columns(self) -> list[Chosen]:
        """Columns with a header that could not be placed."""
        return [
            column
            for column in self.choice.unplaced
            if len(column.text) <= MAX_HEADER and not is_nameless(column)
        ]

    @cached_property
    def timed(self) -> list[Chosen]:
        """Those in a unit of time."""
        return [column for column in self.columns if "time" in column.kinds]

    @cached_property
    def stating(self) -> list[Chosen]:
        """Those in a unit of time that may state their turns."""
        return [
            column
            for column in self.timed
            if column.header.turns or _STATES_COUNT.search(column.text)
        ]

    @cached_property
    def of_rod(self) -> list[Chosen]:
        """Those that may state turns of the rod."""
        return [one for one in self.stating if not one.header.is_of_the_spin]

    @cached_property
    def similar(self) -> list[Chosen]:
        """Those with a name that is nearly one of the role."""
        if self._is_only_gap():
            return self.columns
        near = [
            column
            for column in self.columns
            if len(column.text) > 3
            and suggest_role(column.text) == self.role
            and (not column.kinds or kind_of_role(self.role) in column.kinds)
        ]
        return list(filter(_may_be_turns, near)) if self.role == "turns" else near

    def _is_only_gap(self) -> bool:
        """Return whether one role is missing, and one column without a unit is left."""
        if self.role not in ("mass", "spin") or len(self.missing) > 1:
            return False
        return [column.header.unit for column in self.columns] == [None]

    @cached_property
    def fitting(self) -> list[tuple[str, Chosen]]:
        """Those whose unit fits the role, with the role to use."""
        likely = ["mass", "force"] if self.role == "mass" else [self.role]
        return [
            (role, column)
            for role in likely
            for column in self.choice.unplaced
            if kind_of_role(role) in column.kinds
        ]


def is_nameless(column: Chosen) -> bool:
    """Return whether a column has no header."""
    return _NAMELESS.fullmatch(column.text) is not None


def _may_be_turns(column: Chosen) -> bool:
    """Return whether a column has no unit of time, and no cell is too large for turns."""
    if "time" in column.kinds:
        return False
    numbers = [to_float(text) for text in column.texts if is_bare(text)]
    return max(numbers, default=0.0) <= MOST_TURNS


# One way to repair a log each: a hint, or "" if it does not apply


def _time_of_stated_turns(lack: Lack) -> str:
    if lack.role not in ("time", "turns") or len(lack.of_rod) != 1:
        return ""
    [column] = lack.of_rod
    turns = column.header.turns
    stated = f" --set turns={turns}?" if turns else ", with a column turns?"
    return f'is it --map time="{column.text}"{stated}'


def _period_of_one_turn(lack: Lack) -> str:
    whole = [
        column.text
        for column in lack.timed
        if suggest_role(column.text) == "precession_period"
    ]
    if lack.role != "time" or not whole:
        return ""
    return f'is it --map precession_period="{whole[0]}", the time of one whole turn?'


def _part_of_mass(lack: Lack) -> str:
    columns = lack.choice.unplaced
    parts = [one.text for one in columns if is_part_of_mass(one.text)]
    if lack.role != "mass" or not parts:
        return ""
    return (
        f'"{parts[0]}" is a part of the mass: write all that hangs on the rod, as '
        "20.3 or 2 x 10.15"
    )


def _number_of_weights(lack: Lack) -> str:
    counts = [one.text for one in lack.columns if counts_weights(one.header)]
    if lack.role != "mass" or not counts:
        return ""
    return (
        f'"{counts[0]}" counts weights: write their mass instead, in a column mass [g], '
        "as 40.3 or 2 x 20.15"
    )


def _time_of_ball(lack: Lack) -> str:
    of_ball = [one.text for one in lack.stating if one.header.is_of_the_spin]
    if lack.role != "spin" or not of_ball:
        return ""
    return (
        f'is it "{of_ball[0]}"? divide by the turns, and write spin_period [s] (or '
        "_start, _end)"
    )


def _named_after_ball(lack: Lack) -> str:
    named = [one.text for one in lack.columns if one.header.is_of_the_spin]
    if lack.role != "spin" or not named:
        return ""
    return (
        f'is it "{named[0]}"? Write "spin [rpm]" instead above rates, or "spin_period '
        '[s]" above times of one turn'
    )


def _diameter(lack: Lack) -> str:
    across = [one.text for one in lack.columns if WIDE.is_in(one.text)]
    if lack.role != "position" or not across:
        return ""
    return (
        f'"{across[0]}" is a diameter: write half of each number in a column '
        "position [cm]"
    )


def _count_of_parts(lack: Lack) -> str:
    """Ask what the only column of numbers without a unit counts."""
    counts = [one for one in lack.columns if _contains_numbers(one)]
    if lack.role != "turns" or len(counts) != 1:
        return ""
    [column] = counts
    cells = listing(list(dict.fromkeys(filter(None, column.texts))), 3)
    return (
        f'if "{column.text}" ({cells}) counts turns, write "turns" above it; if thirds, '
        '"thirds of a turn"; if percent, "turns [%]"; if degrees, "angle [deg]"'
    )


def _contains_numbers(column: Chosen) -> bool:
    texts = [text for text in column.texts if text]
    return column.header.unit is None and all(map(is_bare, texts))


def _from_ball(lack: Lack) -> str:
    if lack.role != "position" or not lack.similar:
        return ""
    header = lack.similar[0].text
    if not SPHERE.is_in(header):
        return ""
    return (
        f'"{header}": if it counts from the centre of the ball, write "{lack.named}" '
        'instead; if from its surface, write also the lines "# position_from: surface" '
        'and "# ball_diameter: 10.16 cm"'
    )


def _similar_name(lack: Lack) -> str:
    if not lack.similar:
        return ""
    if_unit = f", if it is in {lack.unit}" if lack.unit else ""
    return f'is it "{lack.similar[0].text}"? Write "{lack.named}" instead{if_unit}'


def _fitting_unit(lack: Lack) -> str:
    if lack.role == "turns" or len(lack.fitting) != 1:
        return ""
    [(role, column)] = lack.fitting
    return f'is it --map {role}="{column.text}"?'


def _column_without_header(lack: Lack) -> str:
    names = [one.text for one in lack.choice.unplaced if is_nameless(one)]
    if not names:
        return ""
    return f'is it {" or ".join(names)}, without a name? Write "{lack.named}" above it'


SUGGESTIONS: tuple[Callable[[Lack], str], ...] = (
    _time_of_stated_turns,
    _period_of_one_turn,
    _part_of_mass,
    _number_of_weights,
    _time_of_ball,
    _named_after_ball,
    _diameter,
    _from_ball,
    _similar_name,
    _count_of_parts,
    _fitting_unit,
    _column_without_header,
)
"""The first that applies is used: what a header says comes before a similar name, and
that before a unit alone."""


def _rate_of_precession(lack: Lack) -> str:
    """Return the column that may be the spin, because the lab sheet calls it a rotation."""
    rates = lack.choice.used.get("precession_rate")
    if lack.role != "spin" or not rates:
        return ""
    header = rates[0].text
    if re.search(PRECESSION, header):
        return ""
    return (
        f'is it "{header}", which is read as the rate of the precession? --map '
        f'spin="{header}"'
    )


def _suggestion(lack: Lack) -> str:
    """Return the best guess; "" if no column of the log may be the role."""
    if lack.choice.used.get("precession_rate") and lack.role == "spin":
        return _rate_of_precession(lack)
    if lack.role == "turns" and "time" in lack.missing:
        return ""
    return next(filter(None, (suggest(lack) for suggest in SUGGESTIONS)), "")


# The question


def question_of(missing: list[str], choice: Choice, header_row: str) -> tuple[str, str]:
    """Return one message about all missing roles, and what to type.

    If several are missing, the hint begins with the corrected header row.
    """
    lacks = [Lack(role, tuple(missing), choice) for role in missing]
    message = "; ".join(map(_what_is_missing, lacks))
    if choice.unplaced:
        texts = [column.text for column in choice.unplaced]
        message += f"; headers that could not be placed: {listing(texts)}"
    hints = [_how_to_add(lack) for lack in lacks]
    if header_row and len(lacks) + len(choice.corrected) > 1:
        hints = [f"write this header row, with the numbers: {header_row}", *hints]
    return message, "\n".join(hints)


def _what_is_missing(lack: Lack) -> str:
    meaning = roles.BY_NAME[lack.role].meaning
    return f"{lack.role} is missing" + (f" ({meaning})" if meaning else "")


def _how_to_add(lack: Lack) -> str:
    role, known = lack.role, roles.BY_NAME[lack.role]
    sample = known.sample or f"1 {lack.unit}"
    quoted = f'"{sample}"' if " " in sample else sample
    ways = [f"add a column {lack.named}"]
    if role != "time":
        ways += [f'or a line "# {role}: {sample}"', f"or --set {role}={quoted}"]
    ways.append(
        f"or --map {role}=HEADER to name the column that contains it{known.instead}"
    )
    return _joined(_suggestion(lack), "; ".join(ways))


def _joined(guess: str, ways: str) -> str:
    if not guess:
        return ways
    return f"{guess} {ways}" if guess.endswith("?") else f"{guess}; {ways}"


def likely_headers(missing: list[str], choice: Choice) -> dict[int, str]:
    """Return the header of each missing role above the column that may contain it."""
    headers: dict[int, str] = dict(choice.corrected)
    for role in missing:
        lack = Lack(role, tuple(missing), choice)
        likely = [*lack.similar, *(column for _, column in lack.fitting)]
        places = [column.at for column in likely if column.at not in headers]
        if places and len({column.at for column in likely}) == 1:
            headers[places[0]] = lack.named
    return headers


def header_row(
    table: layout.Layout, changes: Mapping[int, str], added: list[str]
) -> str:
    """Return the header row of a log with some headers changed and others added.

    "" if the headers are not in one line of the file.
    """
    typed = list(dict.fromkeys(table.cells))  # a derived column has the cell of another
    lines = {cell.place.line for cell in typed}
    if len(lines) > 1 or len({cell.place for cell in typed}) < len(typed):
        return ""
    headers = [changes.get(table.cells.index(cell), cell.text) for cell in typed]
    delimiter = table.grid.delimiter.strip() or ", "
    return delimiter.join(map(_as_cell, [*headers, *added]))


def _as_cell(header: str) -> str:
    return f'"{header}"' if _QUOTED.search(header) else header
