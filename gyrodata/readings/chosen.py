"""The nouns of the choice: a column with its role, and the columns of all roles."""

from __future__ import annotations

from msgspec import Struct, field
from msgspec.structs import replace

from gyrodata.quantities.units import kinds_of
from gyrodata.readings import layout, roles
from gyrodata.readings.headers import Header
from gyrodata.readings.lablog import Text

MOST_TURNS = 50
"""Larger numbers are not turns of the rod."""


class Chosen(Struct, frozen=True):
    """A column with its role."""

    at: int
    """Number of the column, from 0."""
    cell: Text
    header: Header
    role: str
    number: int | None = None
    """Number of a repeat (``time_2``: 2)."""
    turns: str = ""
    """Turns of each time, if the header states them: "1/3"."""
    texts: tuple[str, ...] = ()
    """Its cells, one for each row."""

    @property
    def text(self) -> str:
        """Text of the header."""
        return self.cell.text

    @property
    def kinds(self) -> frozenset[str]:
        """Kinds of quantity that the unit of the header can measure."""
        return kinds_of(self.header.unit or "")


def columns_of(table: layout.Layout) -> list[Chosen]:
    """Return all columns of a table, still without a role."""
    return [
        Chosen(at, table.cells[at], header, "", texts=cells_of(table, at))
        for at, header in enumerate(table.headers)
    ]


def cells_of(table: layout.Layout, at: int) -> tuple[str, ...]:
    """Return the texts of one column of a table."""
    return tuple([row.texts[at] for row in table.rows])


class Choice(Struct):
    """The column of each role."""

    there: set[str]
    """Roles that have a column, or one value for the whole log."""
    used: dict[str, list[Chosen]] = field(default_factory=dict)
    """One column for each role; several for repeats of the time."""
    others: list[Chosen] = field(default_factory=list)
    """Further columns of a role, and ``inertia``."""
    unplaced: list[Chosen] = field(default_factory=list)
    """Columns whose headers name no role."""
    asked: set[str] = field(default_factory=set)
    """Roles that a header may mean, if the log's author has to decide."""
    corrected: dict[int, str] = field(default_factory=dict)
    """Header with a unit of each column that lacks one."""
    mapped: set[str] = field(default_factory=set)
    """Roles whose columns --map names."""

    def serve(self, column: Chosen) -> None:
        """Use a column for its role, or put it with the others."""
        present = self.used.get(column.role, [])
        if column.role == "inertia" or (present and not is_repeat(column, present)):
            self.others.append(column)
        else:
            self.used[column.role] = [*present, column]
            self.there.add(column.role)

    def place(self, column: Chosen, role: str, number: int | None = None) -> None:
        """Use a column without a known name for a role."""
        self.unplaced = [other for other in self.unplaced if other.at != column.at]
        self.serve(replace(column, role=role, number=number))

    def rename(self, role: str, new: str) -> None:
        """Use the columns of one role for another one."""
        columns = self.used.pop(role)
        self.used[new] = [replace(column, role=new) for column in columns]
        self.there = self.there - {role} | {new}

    def times(self) -> list[Chosen]:
        """Return the columns of the stopwatch."""
        return self.used.get("time", [])

    def gives_spin(self) -> bool:
        """Return whether the spin is known."""
        return any(self.there.issuperset(names) for names in roles.SPIN_SETS)

    def gives_turns(self) -> bool:
        """Return whether the turns of each time are known, or none are needed."""
        return not self.there.isdisjoint((*roles.COUNTS, *roles.ONE_TURN))


def is_repeat(column: Chosen, present: list[Chosen]) -> bool:
    """Return whether a column repeats readings of other columns of its role."""
    numbers = {other.number for other in present}
    return column.number is not None and numbers.isdisjoint({None, column.number})
