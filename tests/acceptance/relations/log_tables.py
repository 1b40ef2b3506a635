"""A log as a table that can be rewritten, the logs that are rewritten, and the list of
relations.

A relation is a function from a `LogTable` to a `Rewriting` of it that means the same,
or to None if it does not apply."""

from __future__ import annotations

import csv
import io
import math
import random
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, NamedTuple

from gates.drawn_logs import Bench, typed
from gates.stored import read
from places import ROOT

Rows = list[list[str]]
Cells = list[str]


class Heading(NamedTuple):
    role: str
    unit: str = ""

    def __str__(self) -> str:
        return f"{self.role} [{self.unit}]" if self.unit else self.role


@dataclass(frozen=True)
class LogTable:
    """A log: its ``# key: value`` lines, the headings of its columns, and its rows as
    they were typed.
    """

    constants: tuple[tuple[str, str], ...]
    headings: tuple[Heading, ...]
    rows: tuple[tuple[str, ...], ...]

    @property
    def roles(self) -> list[str]:
        return [heading.role for heading in self.headings]

    def unit(self, role: str) -> str:
        return self.headings[self.roles.index(role)].unit

    def cells(self, role: str) -> Cells:
        at = self.roles.index(role)
        return [row[at] for row in self.rows]

    def with_column(
        self,
        heading: Heading,
        cells: Iterable[str],
        *,
        instead_of: str = "",
        at: int = -1,
    ) -> LogTable:
        """Write a column in place of another one, or add it at the right or at a place."""
        columns = list(zip(self.headings, zip(*self.rows, strict=True), strict=True))
        column = (heading, tuple(cells))
        if instead_of:
            columns[self.roles.index(instead_of)] = column
        else:
            columns.insert(at if at >= 0 else len(columns), column)
        return self.of_columns(columns)

    def of_columns(self, columns: Iterable[tuple[Heading, Iterable[str]]]) -> LogTable:
        headings, cells = zip(*columns, strict=True)
        return replace(self, headings=headings, rows=tuple(zip(*cells, strict=True)))

    def without(self, *roles: str) -> LogTable:
        columns = zip(self.headings, zip(*self.rows, strict=True), strict=True)
        return self.of_columns(
            [column for column in columns if column[0].role not in roles]
        )

    def with_cells(self, role: str, change: Callable[[str], str]) -> LogTable:
        """Change each cell of a column that is not blank."""
        cells = [change(cell) if cell else "" for cell in self.cells(role)]
        return self.with_column(
            self.headings[self.roles.index(role)], cells, instead_of=role
        )

    def stating(self, **constants: str) -> LogTable:
        """State constants, in place of what the log says of them."""
        kept = tuple(pair for pair in self.constants if pair[0] not in constants)
        return replace(self, constants=kept + tuple(constants.items()))

    @property
    def grid(self) -> Rows:
        """The header and the rows."""
        return [[str(heading) for heading in self.headings], *map(list, self.rows)]

    @property
    def above(self) -> str:
        """The constants as lines."""
        return "".join(f"# {key}: {value}\n" for key, value in self.constants)

    @property
    def text(self) -> str:
        return self.above + separated(self.grid)


class Rewriting(NamedTuple):
    """What a log became, and the log that means the same with the same digits, if it is
    not the log itself.

    A tolerance is the largest relative difference that the digits explain, of I_zz and
    of u."""

    log: Any
    same_as: LogTable | None = None
    settings: Mapping[str, str] | None = None
    mapping: Mapping[str, str] | None = None
    tolerance: tuple[float, float] = (1e-6, 1e-6)


Relation = Callable[[LogTable], Rewriting | None]
RELATIONS: dict[str, Relation] = {}


def relation(function: Relation) -> Relation:
    """Put a function on the list of relations."""
    return named(function.__name__.replace("_", " "), function)


def named(name: str, function: Relation) -> Relation:
    assert name not in RELATIONS, name
    RELATIONS[name] = function
    return function


def text_relation(function: Callable[[LogTable], str | bytes | None]) -> Relation:
    """Put a function that writes a log in another form on the list."""

    def rewriting(table: LogTable) -> Rewriting | None:
        log = function(table)
        return None if log is None else Rewriting(log)

    return named(function.__name__.replace("_", " "), rewriting)


def separated(
    grid: Rows, delimiter: str = ",", quoting: int = csv.QUOTE_MINIMAL
) -> str:
    out = io.StringIO()
    csv.writer(
        out, delimiter=delimiter, quoting=quoting, lineterminator="\n"
    ).writerows(grid)
    return out.getvalue()


def is_number(cell: str) -> bool:
    try:
        return math.isfinite(float(cell))
    except ValueError:
        return False


def shuffled(items: Iterable[Any], seed: int = 1) -> list[Any]:
    items = list(items)
    random.Random(seed).shuffle(items)
    return items


def parse(text: str) -> LogTable:
    """Read a log of the plain form: lines with #, a header ``role [unit]``, rows with
    commas.
    """
    lines = text.splitlines()
    said = [
        line.removeprefix("# ").split(": ", 1) for line in lines if line.startswith("#")
    ]
    constants = tuple(
        (key, value) for key, value in said if key.isidentifier() and key != "noise"
    )
    head, *rows = csv.reader(line for line in lines if not line.startswith("#"))
    headings = (name.removesuffix("]").partition(" [") for name in head)
    columns = tuple(Heading(role, unit) for role, _, unit in headings)
    return LogTable(constants, columns, tuple(map(tuple, rows)))


@cache
def bases() -> dict[str, LogTable]:
    """Give eleven logs that differ in what was measured, and in what they state."""
    stored = read("logs.txt")
    readme = (
        (ROOT / "README.md")
        .read_text(encoding="utf-8")
        .partition("```csv\n")[2]
        .partition("```")[0]
    )
    texts = {
        **{
            path.stem: path.read_text(encoding="utf-8")
            for path in sorted((ROOT / "sample_data").glob("*.csv"))
        },
        "README": readme,
        "nine runs": typed(Bench(), 5).decode(),
        "thirds": typed(Bench(thirds=True), 5).decode(),
        "rod at 30 deg": typed(Bench(spins=(400, 600), pitch=30.0), 5).decode(),
        **{
            name: stored[name]
            for name in ("unloaded", "falling", "contradicting", "rates")
        },
    }
    return {name: parse(text) for name, text in texts.items()}


BASES = tuple(bases())
