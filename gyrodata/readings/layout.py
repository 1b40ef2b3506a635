"""The table of a log: its header, one row for each run, and its columns with roles."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable
from itertools import chain, pairwise

from msgspec import Struct
from msgspec.structs import replace

from gyrodata.quantities import numerals
from gyrodata.readings import captions, roles
from gyrodata.readings.grid import (
    HEADERS_LOOKED_AT,
    Grid,
    Row,
    count_of_numbers,
    filled_at,
    is_bare,
    is_head,
    is_number,
    units_of_row,
)
from gyrodata.readings.headers import counts_weights, parse_header
from gyrodata.readings.lablog import Faults, Text
from gyrodata.readings.names import (
    LETTERS,
    Header,
    Phrases,
    measures,
    name_roles,
    squeeze,
)
from gyrodata.readings.notes import altered_role
from gyrodata.readings.turns import turns_in

NOT_USED = Phrases("not_used")
"""Words of a note on a run that is not valid."""

_DIGITS = frozenset("0123456789")

HeaderCell = tuple[Text, Header]
"""A cell of the header row, and what it says."""


class Layout(Struct, frozen=True):
    """A table of runs: its headers, and the rows below them."""

    grid: Grid
    """For the places of cells."""
    cells: list[Text]
    """The header row."""
    headers: list[Header]
    """Content of each header, with the unit of a second header row."""
    rows: list[Row]
    """The runs; each row has at least as many cells as the header."""
    sentences: list[Text]
    """The comments, and the rows of text above, between and below the runs."""

    def cell_of(self, column: Chosen, row: int) -> Text:
        """Return the cell of a column in a row."""
        return self.grid.cell(self.rows[row], column.at)

    @property
    def statements(self) -> list[Text]:
        """The sentences, and the "key: value" lines whose keys gyro does not know."""
        return [*self.sentences, *self.grid.remarks()]


# --- The header row ---


def find_head(grid: Grid, faults: Faults) -> Row:
    """Return the header row of the first table."""
    if not grid.rows:
        raise faults.refuse("no_table")
    rows = grid.rows[:HEADERS_LOOKED_AT]
    head = next(filter(is_head, rows), None)
    if head is None and max(len(row.texts) for row in grid.rows) == 1:
        raise faults.refuse("no_delimiter", grid.cell(grid.rows[0], 0))
    head = head or _first_of_usual_width(rows)
    if again := _start_of_second_table(head.filled()):
        at = filled_at(head)[again]
        raise faults.refuse("side_by_side", grid.cell(head, at))
    filled = len(filled_at(head))
    if 2 * count_of_numbers(head.texts) >= max(1, filled):
        raise faults.refuse("no_header_row", grid.cell(head, 0))
    early = next(filter(_is_of_numbers, rows[: rows.index(head)]), None)
    if early:
        lines = {"early": [early.line], "line": [head.line]}
        raise faults.refuse("numbers_above_header", grid.cell(early, 0), **lines)
    return head


def _first_of_usual_width(rows: list[Row]) -> Row:
    """Return the first row that is as wide as most rows; or units without names."""
    for before, row in pairwise(rows):
        is_below_names = len(before.filled()) == len(row.filled())
        if len(units_of_row(row.texts)) > 1 and not is_below_names:
            return row
    wide = [row for row in rows if len(filled_at(row)) > 1]
    widths = Counter(len(row.texts) for row in wide)
    usual = max(widths, key=widths.__getitem__, default=0)
    usual_rows = [row for row in rows if len(row.texts) == usual]
    return usual_rows[0] if usual_rows else rows[0]


def _is_of_numbers(row: Row) -> bool:
    """Return whether most cells of a row are numbers.

    "turns:", "1", "", "1" is a caption of tables next to each other.
    """
    bare = sum(map(is_bare, row.texts))
    is_caption = row.texts[0].endswith(":")
    return bare > 2 and 2 * bare > len(filled_at(row)) and not is_caption


def columns_of_head(grid: Grid, head: Row) -> list[HeaderCell]:
    """Return what each cell of a header row says."""
    headers = map(parse_header, head.texts)
    return [(grid.cell(head, at), header) for at, header in enumerate(headers)]


def check_names(columns: list[HeaderCell], faults: Faults) -> None:
    """Refuse two columns of one name."""
    names_before = set()
    for cell, header in columns:
        if cell.text and (cell.text, header) in names_before:
            names = {"spin": "same_spins", "time": "same_times"}
            role = "".join(header.roles)
            raise faults.refuse(names.get(role, "same_names"), cell)
        names_before.add((cell.text, header))


def _start_of_second_table(texts: list[str]) -> int:
    """Return the number of the name at which all names repeat; 0 if they do not."""
    if any(map(is_number, texts)):
        return 0
    names = [squeeze(re.sub(_COPY, "", text)) for text in texts]
    # A column on the left may number the rows of all tables.
    for left in (0, 1):
        for size in range(2, (len(names) - left) // 2 + 1):
            second = left + size
            first_names = names[left:second]
            if first_names == names[second : second + size]:
                return second
    return 0


_COPY = r"(?i)(?:\.|(?<!\s)\s+run\s?#?\s?)[0-9]{1,3}$"
"""What a spreadsheet or a data logger writes behind names that repeat."""


# --- A table without anything else around it ---


def is_plain(grid: Grid) -> bool:
    """Return whether each row below a header at the top is a run of numbers.

    Each header names one quantity in words, and nothing else.
    """
    if len(grid.rows) < 2 or not is_head(grid.rows[0]):
        return False
    names, *runs = grid.rows
    if len(set(names.texts)) < len(names.texts) or not all(map(_is_name, names.texts)):
        return False
    if lacking_roles(map(parse_header, names.texts)):
        return False
    return all(_is_run_of_numbers(row, len(names.texts)) for row in runs)


def _is_name(text: str) -> bool:
    """Return whether a header is a word of several letters without a number."""
    header = parse_header(text)
    words = len(header.name) > 1 and _DIGITS.isdisjoint(text)
    return words and len(header.roles) == 1 and not header.turns


def _is_run_of_numbers(row: Row, width: int) -> bool:
    """Return whether a row begins with three numbers, and no remark is about it."""
    texts = row.filled()
    begins = len(texts) > 2 and all(map(is_bare, texts[:3]))
    return begins and len(row.texts) <= width and not any(map(NOT_USED.is_in, texts))


def plain_layout(grid: Grid) -> Layout:
    """Return a table whose rows are all runs."""
    head, *runs = grid.rows
    width = len(head.texts)
    rows = [
        replace(row, texts=[*row.texts, *[""] * (width - len(row.texts))])
        for row in runs
    ]
    cells = [grid.cell(head, at) for at in range(width)]
    headers = list(map(parse_header, head.texts))
    return Layout(grid, cells, headers, rows, grid.comments)


# --- Other tables ---


def layout_of(
    grid: Grid,
    columns: list[HeaderCell],
    rows: list[Row],
    words: list[Row],
    faults: Faults,
) -> Layout:
    """Return a table; refuse one without runs, or with a wrong header.

    `words` are the rows of text around the runs.
    """
    if not rows:
        raise faults.refuse("no_runs")
    _check_header(columns, rows, faults)
    cells = [
        cell if cell.text else replace(cell, text=f"column {number}")
        for number, (cell, _) in enumerate(columns, 1)
    ]
    texts = [Text(", ".join(row.filled()), grid.cell(row, 0).place) for row in words]
    headers = [header for _, header in columns]
    return Layout(grid, cells, headers, rows, [*grid.comments, *texts])


def _check_header(columns: list[HeaderCell], rows: list[Row], faults: Faults) -> None:
    """Refuse a blank header above numbers, and one that a comma splits.

    The first column may be that of a program. Others may be below a merged cell, or
    above a second row of names. An example of the second is "period [s], 5 turns".
    """
    for at, (before, (cell, header)) in enumerate(pairwise(columns), 1):
        texts = [row.texts[at] for row in rows if row.texts[at]]
        number = next(filter(is_number, texts), "")
        if number and not header.text:
            raise faults.refuse("blank_header", cell, number=number)
        if not texts and _is_split(before, header):
            values = {"header": before[0].text, "turns": header.turns}
            raise faults.refuse("header_split", cell, **values)


def _is_split(before: HeaderCell, header: Header) -> bool:
    """Return whether a header may be the end of the one before it."""
    has_units = before[1].unit and header.unit
    return bool(header.turns and before[0].text and not has_units)


def ends_with_means(rows: list[Row], columns: list[HeaderCell]) -> bool:
    """Return whether the last row of a table contains the means of those above it."""
    if len(rows) < 3 or not _is_mean(rows, columns, "time"):
        return False
    *above, last = rows
    least = min(len(filled_at(row)) for row in above)
    if len(filled_at(last)) < least:
        return True
    is_apart = last.line > above[-1].line + 1
    return is_apart and _is_mean(rows, columns, "spin")


def _is_mean(rows: list[Row], columns: list[HeaderCell], role: str) -> bool:
    """Return whether the last row contains the mean of each column of a role."""
    places = [at for at, (_, header) in enumerate(columns) if role in header.roles]
    for at in places:
        try:
            *above, last = (numerals.to_float(row.texts[at]) for row in rows)
        except (ValueError, IndexError):
            return False
        total = sum(above)
        gap = abs(total - len(above) * last)
        if gap >= 1e-3 * abs(total or 1):
            return False
    return bool(places)


# --- Roles that a table lacks ---


def lacking_roles(headers: Iterable[Header], grid: Grid | None = None) -> set[str]:
    """Return the roles that no column of a table contains.

    No "# key: value" line of the grid contains them either, so a caption may give them.
    """
    there = {key.lower() for key, _ in grid.metadata} if grid else set()
    for header in headers:
        there |= _roles_served(header)
    # A sentence with turns contradicts a period, which is that of one turn.
    there = there.difference(roles.ONE_TURN)
    missing = roles.missing_roles(there, there)
    return {"mass", "position", "spin", "turns"}.intersection(missing)


def _roles_served(header: Header) -> set[str]:
    """Return the roles that a column contains, or may contain."""
    served = set(header.roles)
    if turns_in(header.text):
        served.add("turns")
    if served and all(role.startswith("spin") for role in header.roles):
        served.add("spin")
    if header.roles:
        return served
    if counts_weights(header):
        served.add("mass")
    # "mass without hanger [g]" is a mass, although gyro has to ask which; "gap [cm]"
    # may be the position, and "disks [g]" the mass.
    kinds = header.kinds & {"length", "mass"}
    return served | hinted(header) | {captions.ROLE_OF_KIND[kind] for kind in kinds}


def hinted(header: Header) -> set[str]:
    """Return the roles that one word of a header names.

    The unit of the header can measure them, or the header says that the reading is
    "without" something.
    """
    if header.unit is None:
        return {altered_role(header.text)}
    words = [word for word in LETTERS.findall(header.text) if len(word) > 1]
    named = chain.from_iterable(name_roles(word)[0] for word in words)
    return {role for role in named if measures(header.unit, role)}


# --- Columns with roles ---

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
        return self.header.kinds

    def filled(self) -> list[str]:
        """Return the cells that are not blank."""
        return [text for text in self.texts if text]


def columns_of(table: Layout) -> list[Chosen]:
    """Return all columns of a table, still without a role."""
    columns = zip(*(row.texts for row in table.rows), strict=False)
    return [
        Chosen(at, table.cells[at], header, "", texts=texts)
        for at, (header, texts) in enumerate(zip(table.headers, columns, strict=False))
    ]


class Choice(Struct):
    """The column of each role."""

    there: set[str]
    """Roles that have a column, or one value for the whole log."""
    used: dict[str, list[Chosen]] = {}
    """One column for each role; several for repeats of the time."""
    others: list[Chosen] = []
    """Further columns of a role, and ``inertia``."""
    unplaced: list[Chosen] = []
    """Columns whose headers name no role."""
    asked: set[str] = set()
    """Roles that a header may mean, if the log's author has to decide."""
    corrected: dict[int, str] = {}
    """Header with a unit of each column that lacks one."""
    mapped: set[str] = set()
    """Roles whose columns --map names."""

    def columns(self, role: str) -> list[Chosen]:
        """Return the columns of a role."""
        return self.used.get(role, [])

    def first(self, role: str) -> Chosen:
        """Return the first column of a role that has one."""
        return self.used[role][0]

    def serve(self, column: Chosen) -> None:
        """Use a column for its role, or put it with the others."""
        present = self.columns(column.role)
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
        self.there.discard(role)
        self.there.add(new)

    def times(self) -> list[Chosen]:
        """Return the columns of the stopwatch."""
        return self.columns("time")

    def states_turns(self) -> bool:
        """Return whether the header of a time states its turns."""
        return any(time.turns for time in self.times())

    def next_repeat(self) -> int:
        """Return the first number that no column of the stopwatch has."""
        taken = {time.number for time in self.times()}
        number = 1
        while number in taken:
            number += 1
        return number

    def gives_spin(self) -> bool:
        """Return whether the spin is known."""
        return any(self.there.issuperset(names) for names in roles.SPIN_SETS)

    def gives_turns(self) -> bool:
        """Return whether the turns of each time are known, or none are needed."""
        return not self.there.isdisjoint((*roles.COUNTS, *roles.ONE_TURN))


def note_unused(column: Chosen, why: str, faults: Faults) -> None:
    """Say that a column is not used, or only compared."""
    faults.add("not_used", column.cell, why=why)


def is_repeat(column: Chosen, present: list[Chosen]) -> bool:
    """Return whether a column repeats readings of other columns of its role."""
    numbers = {other.number for other in present}
    return column.number is not None and numbers.isdisjoint({None, column.number})
