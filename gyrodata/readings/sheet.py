"""Make one table of runs of a sheet with titles, several tables, means and notes.

A row of a sheet is a header, a row of units, a run, a summary or text. A sheet is read
as a teaching assistant reads it: rows that are not runs are left out, a caption is
valid for the runs below it, and a note says each of these things.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from itertools import chain, pairwise
from operator import attrgetter

from msgspec import Struct
from msgspec.structs import replace

from gyrodata.base.errors import InputError
from gyrodata.quantities.units import kinds_of
from gyrodata.readings import roles
from gyrodata.readings.captions import Statements, statements_in
from gyrodata.readings.grid import (
    Grid,
    Row,
    filled_at,
    is_head,
    is_number,
    units_of_row,
)
from gyrodata.readings.headers import names_timing, parse_header
from gyrodata.readings.lablog import BLANKS, Faults, Text, listing
from gyrodata.readings.layout import (
    NOT_USED,
    HeaderCell,
    Layout,
    check_names,
    columns_of_head,
    ends_with_means,
    find_head,
    lacking_roles,
    layout_of,
)
from gyrodata.readings.names import (
    MEAN_WORDS,
    SUMMARY_WORDS,
    Header,
    Phrases,
    contains_word,
    fold_name,
    squeeze,
    words_of,
)
from gyrodata.readings.turns import turns_in
from gyrodata.readings.workbook import MAX_COLUMNS

_NOT_MEASURED = Phrases("not_measured")
_WORDS = re.compile(r"[^\W\d_]{3}\W+[^\W\d_]{3}|_")
"""Of "2 reflective strips" and "14_A": they are not numbers with their units."""
_FILLING = {*roles.FILLED_DOWN, *roles.TIMINGS} - {"torque"}


def find_layout(grid: Grid, faults: Faults) -> Layout | None:
    """Find the header and the rows; None, with diagnostics, without such a table."""
    try:
        head = find_head(grid, faults)
        grid = _with_captions(grid, head)
        sheet = _Sheet(grid, faults)
        first = grid.rows.index(head)
        sheet.words += grid.rows[:first]
        sheet.begin(head)
        for row in grid.rows[first + 1 :]:
            sheet.take(row)
        return sheet.finish()
    except InputError:
        return None


def _with_captions(grid: Grid, head: Row) -> Grid:
    """Add the comments that give a quantity without a column to the rows, at the top.

    An example is "# each time is for one full turn". Several comments may be the
    captions of several tables: each is at its own line.
    """
    lacking = lacking_roles(_headers_in(grid) or map(parse_header, head.texts), grid)
    if not lacking:
        return grid
    lines = [*grid.comments, *grid.remarks()]
    rows = [Row(text.place.line, [f"# {text.text}"]) for text in lines]
    added = [row for row in rows if lacking.intersection(statements_in(row))]
    rows = [*added, *grid.rows]
    if len(added) > 1 and sum(map(is_head, grid.rows)) > 1:
        rows.sort(key=attrgetter("line"))
    return replace(grid, rows=rows)


def _headers_in(grid: Grid) -> list[Header]:
    """Return what the headers of all tables say."""
    heads = filter(is_head, grid.rows)
    texts = chain.from_iterable(row.texts for row in heads)
    return list(map(parse_header, texts))


class _Run(Struct, frozen=True):
    """A row of readings."""

    row: Row
    given: Statements
    """What captions give."""


class _Table(Struct):
    """The table whose rows are read."""

    head: Row
    columns: list[HeaderCell]
    is_apart: bool
    """Whether a blank column separates the table from what is on its right."""
    given: Statements = {}
    """What captions give for its next run."""
    is_new: bool = True
    """Whether it has no row yet."""
    is_skipped: bool = False
    """Whether its rows are not runs."""

    @property
    def first_cell(self) -> Text:
        """Return the first cell of the header row."""
        return self.columns[0][0]

    @property
    def headers(self) -> list[Header]:
        """Return what each header says."""
        return [header for _, header in self.columns]


class _Sheet:
    """Goes down the rows of a sheet, and makes one table of all runs."""

    def __init__(self, grid: Grid, faults: Faults) -> None:
        self.grid = grid
        self.faults = faults
        self.columns: list[HeaderCell] = []
        """Columns of the first table, which are those of all tables."""
        self.runs: list[_Run] = []
        self.tables: list[int] = []
        """Number of the first run of each table."""
        self.words: list[Row] = []
        """Rows of text above the next run."""
        self.sentences: list[Row] = []
        """All rows of text above the last run."""
        self.left_out: dict[str, list[tuple[Row, int]]] = {
            name: [] for name in ("title", "beside", "taken_out", "summary")
        }
        """Rows that are not runs, with the cell that shows it."""
        self.given: Statements = {}
        """What captions gave last: a position or turns are valid until others are
        given."""
        self.captions: list[tuple[Text, str]] = []
        """Each caption, and what was read of it."""
        self.any_timed = any(map(_is_timing, _headers_in(grid)))
        """Whether a header of the sheet names a time or turns."""
        self.only_means = False
        """Whether the first table contains means."""
        self.served: set[str] = set()
        """Parts of a run in the first table."""

    def begin(self, head: Row) -> None:
        """Begin a table with its header row."""
        width = len(head.texts)
        beside = [row.texts[width : width + 1] for row in self.grid.rows]
        is_apart = not any(map(any, beside))
        columns = columns_of_head(self.grid, head)
        self.table = _Table(head, columns, is_apart)

    def take(self, row: Row) -> None:
        """Read the next row."""
        table = self.table
        is_taken_out = _is_taken_out(row)
        row = self._without_remark(row)
        if not any(row.texts):
            return
        if is_head(row) or row.texts == table.head.texts:
            if table.is_new:
                # "time of one turn, x from the centre" above the names
                self.words.append(table.head)
            self.begin(row)
        elif units := self._units_of(row):
            self._take_units(units)
        elif is_taken_out:
            self._leave_out("taken_out", row)
        elif _is_summary(row, table.headers):
            self._leave_out("summary", row)
        elif _is_text(row, table.headers):
            self._take_text(row)
        else:
            self._take_run(row)

    def _without_remark(self, row: Row) -> Row:
        """Leave out texts on the right of the table, and all behind a blank column."""
        width = len(self.table.columns)
        beyond = [at for at in filled_at(row) if at >= width]
        if not beyond:
            return row
        has_number = any(is_number(row.texts[at]) for at in beyond)
        is_longer = has_number or is_head(row)
        if is_longer and not self.table.is_apart:
            return row
        self.left_out["beside"].append((row, beyond[0]))
        return replace(row, texts=row.texts[:width])

    def _units_of(self, row: Row) -> list[str]:
        """Return the units of a row below the names; [] if it is another row."""
        has_units = any(header.unit for header in self.table.headers)
        is_below = self.table.is_new or not has_units
        if not is_below:
            return []
        return units_of_row(row.texts)

    def _take_units(self, units: list[str]) -> None:
        """Give the headers the units of a row of units."""
        columns = self.table.columns
        left = ""
        pairs = zip(units, list(columns), strict=False)
        for at, (unit, (cell, header)) in enumerate(pairs):
            # Minutes and seconds are below one "time".
            left = header.text or left
            has_unit = bool(header.kinds)  # "Drehzahl (Mitte)" has a remark
            if unit not in BLANKS and unit != "1" and not has_unit:
                parsed = parse_header(f"{left} [{unit}]")
                columns[at] = cell, replace(parsed, text=left)

    def _take_text(self, row: Row) -> None:
        """Keep a row of text for the run below it.

        "I_zz (kg m^2), uncertainty (kg m^2)": the numbers below are results.
        """
        self.words.append(row)
        has_names = len(row.filled()) > 1
        if self.runs and has_names and any(map(_is_inertia, row.texts)):
            self.begin(row)
            self.table.is_skipped = True
            self.table.is_new = False

    def _leave_out(self, why: str, row: Row) -> None:
        self.left_out[why].append((row, filled_at(row)[0]))

    # --- Runs ---

    def _take_run(self, row: Row) -> None:
        table = self.table
        is_first = table.is_new
        table.is_new = False
        if is_first:
            self._begin_runs()
        if table.is_skipped:
            self._leave_out_words(set())
            return
        there: set[str] = set()
        for header, text in zip(table.headers, row.texts, strict=False):
            if text:
                there.update(header.roles)
        table.given = _only(table.given.keys() - there, table.given)
        if self.words:
            self._read_words(is_first, there)
        self.given |= table.given
        if is_first:
            self._begin_table(there)
        self.runs.append(_Run(row, table.given))

    def _read_words(self, is_first: bool, there: set[str]) -> None:
        """Add what the rows of text above a run give to it and to the runs below it."""
        lacking = lacking_roles(self.table.headers)
        if not is_first:
            # "moved to 10.0 cm" between the runs is valid for the blank cells below it,
            # until another value is typed.
            lacking |= {"mass", "position"} - there
        captioned = self.table.given | self._read_captions(lacking)
        if captioned.keys().isdisjoint({"mass", "position", "spin"}):
            lacking &= {"turns"}
        self.table.given = _only(lacking, self.given) | captioned

    def _begin_table(self, there: set[str]) -> None:
        """Note where the runs of a table begin, and check that nothing is missing."""
        table = self.table
        lacking = lacking_roles(table.headers) & {"position", "turns"}
        table.given = _only(lacking, self.given) | table.given
        there = there | table.given.keys()
        if not self.tables:
            self.served = there & _FILLING
        self.tables.append(len(self.runs))
        lost = self.served - there
        # A position is blank in a run without a weight.
        if any("position" in header.roles for header in table.headers):
            lost.discard("position")
        if lost:
            line = [table.head.line]
            lacks = roles.BY_NAME[min(lost)]
            cell = table.first_cell
            raise self.faults.refuse("lacks_in_first_row", cell, line=line, lacks=lacks)

    def _begin_runs(self) -> None:
        """Refuse a table of runs whose columns are not those of the first one.

        They are in one order, and the last ones, such as notes, may be missing.
        """
        table = self.table
        means = self._are_means()
        if why := self._why_skipped(means):
            table.is_skipped = True
            self.faults.add(why, table.first_cell, line=[table.head.line])
            return
        self.only_means |= means and not self.runs
        check_names(table.columns, self.faults)
        if not self.columns:
            self.columns = table.columns
        names = [cell.text for cell, _ in self.columns]
        row = self.grid.delimiter.join(names)
        for at, (cell, header) in enumerate(table.columns):
            old = self.columns[at] if at < len(names) else None
            if old is None or not _are_same(old, (cell, header)):
                line = [table.head.line]
                raise self.faults.refuse("other_columns", cell, line=line, row=row)

    def _why_skipped(self, means: bool) -> str:
        """Return the name of the note if the rows of a table are not runs; else ""."""
        if self.any_timed and not any(map(_is_timing, self.table.headers)):
            return "untimed_table"
        if self._is_not_measured():
            return "table_not_measured"
        return "table_of_means" if means and self.runs and not self.only_means else ""

    def _is_not_measured(self) -> bool:
        """Return whether the title of one of several tables says "not measured"."""
        titles = [text for text in self._texts_of_words() if len(text) < 60]
        is_unused = any(map(_NOT_MEASURED.is_in, titles))
        return is_unused and sum(map(is_head, self.grid.rows)) > 1

    def _texts_of_words(self) -> Iterator[str]:
        return chain.from_iterable(row.texts for row in self.words)

    def _are_means(self) -> bool:
        """Return whether a table contains means, by its title or its headers."""
        title = " ".join(self._texts_of_words())
        if contains_word(title, MEAN_WORDS) and not turns_in(title):
            return True
        timings = [header for header in self.table.headers if names_timing(header)]
        return bool(timings) and all(header.is_of_means for header in timings)

    # --- Captions ---

    def _read_captions(self, lacking: set[str]) -> Statements:
        """Return what the rows of text above a run say of what is lacking in it."""
        captioned: Statements = {}
        lacking = lacking & lacking_roles([], self.grid)
        used: set[int] = set()
        for row in self.words:
            of_row = _only(lacking, statements_in(row))
            if not of_row:
                continue
            words = [f"{role} {text}" for role, (text, _) in of_row.items()]
            self.captions.append((self.grid.first_cell(row), ", ".join(words)))
            spots = map(row.spot, range(len(row.texts)))
            used.update(spot // MAX_COLUMNS for spot in spots)
            for role, (text, at) in of_row.items():
                captioned[role] = text, row.spot(at)
        self._leave_out_words(used)
        return captioned

    def _leave_out_words(self, used: set[int]) -> None:
        """Leave out the rows of text above a run, without those of some lines."""
        used = used.union(dict(self.faults.sheets))
        for row in self.words:
            if row.line not in used:
                self._leave_out("title", row)
        self.sentences += self.words
        self.words = []

    # --- The whole table ---

    def finish(self) -> Layout:
        """Return all runs as one table; note captions and what was left out."""
        self._leave_out_words(set())
        self.width = len(self.columns)
        self._add_captioned_columns()
        rows = [self._joined(run) for run in self.runs]
        bounds = pairwise([*self.tables, len(rows)])
        parts = [rows[start:end] for start, end in bounds]
        for part in parts:
            if ends_with_means(part, self.columns):
                self._leave_out("summary", part.pop())
        self._note_left_out()
        for cell, words in self.captions:
            line = cell.place.line
            self.faults.add("caption", cell, line=[line], said=words)
            self.faults.take_back("remark", line)
        self._check_parts(parts)
        rows = list(chain.from_iterable(parts))
        return layout_of(self.grid, self.columns, rows, self.sentences, self.faults)

    def _add_captioned_columns(self) -> None:
        """Add a column for each role that captions give."""
        captioned: dict[str, int] = {}
        for run in self.runs:
            captioned |= {role: spot for role, (_, spot) in run.given.items()}
        there = {header.roles for _, header in self.columns}
        for role, spot in captioned.items():
            if (role,) not in there:
                header = Header(role, (role,))
                self.columns.append((Text(role, self.grid.place_of(spot)), header))

    def _joined(self, run: _Run) -> Row:
        """Return a run with what captions give for it."""
        end = len(run.row.texts)
        added = [end] * (len(self.columns) - self.width)
        places = [*range(self.width), *added, *range(self.width, end)]
        row = run.row.cells(places)
        spots = list(row.origin)
        names = [header.roles for _, header in self.columns]
        for role, (text, spot) in run.given.items():
            at = names.index((role,))
            row.texts[at] = text
            spots[at] = spot
        return replace(row, origin=tuple(spots))

    def _note_left_out(self) -> None:
        captioned = {cell.place.line for cell, _ in self.captions}
        for why, rows in self.left_out.items():
            left = [(row, at) for row, at in rows if row.line not in captioned]
            if left:
                texts = listing([row.texts[at] for row, at in left], 4)
                lines = sorted({row.line for row, _ in left})
                first = self.grid.cell(*left[0])
                self.faults.add(why, first, lines=lines, texts=texts)

    def _check_parts(self, parts: list[list[Row]]) -> None:
        """Name several tables; refuse one that contains two rows of another one."""
        if len(parts) < 2:
            return
        rows_before: set[tuple[str, ...]] = set()
        spans: list[str] = []
        for part in parts:
            rows = [tuple(row.texts[: self.width]) for row in part]
            if sum(row in rows_before for row in rows) > 1:
                cell = self.grid.first_cell(part[0])
                line = [part[0].line]
                raise self.faults.refuse("repeated_table", cell, line=line)
            rows_before.update(rows)
            spans.append(self.faults.span(sorted({row.line for row in part})))
        cell = self.columns[0][0]
        lines = ", ".join(spans)
        self.faults.add("tables_joined", cell, count=len(parts), lines=lines)


# --- Kinds of headers ---


def _is_timing(header: Header) -> bool:
    return names_timing(header) or header.turns != ""


def _are_same(old: HeaderCell, new: HeaderCell) -> bool:
    """Return whether columns of two tables contain one quantity."""
    (old_cell, old_header), (cell, header) = old, new
    if (old_header.turns, old_header.unit) != (header.turns, header.unit):
        return False
    if squeeze(old_cell.text) == squeeze(cell.text):
        return True
    if header.roles != old_header.roles or header.number != old_header.number:
        return False
    return len(header.roles) == 1


def _only(names: Collection[str], statements: Statements) -> Statements:
    return {role: item for role, item in statements.items() if role in names}


# --- Kinds of rows ---


def _is_taken_out(row: Row) -> bool:
    """Return whether a run is behind a # in its own cell, or a note excludes it."""
    if row.texts[0] == "#":
        return True
    texts = [text for text in row.texts if not is_number(text)]
    count = len(row.texts)
    has_number = len(texts) < count
    return has_number and any(map(NOT_USED.is_in, texts))


def _is_summary(row: Row, headers: list[Header]) -> bool:
    """Return whether a row begins with a word for means, deviations or sums."""
    first = filled_at(row)[0]
    if first < len(headers) and "note" in headers[first].roles:
        return False
    text = row.texts[first]
    word, *_ = [*filter(None, words_of(text)), text]
    return not SUMMARY_WORDS.isdisjoint(
        (fold_name(word), fold_name(text.strip("()=: ")))
    )


def _is_inertia(text: str) -> bool:
    """Return whether a header has the unit of a moment of inertia."""
    return "inertia" in kinds_of(parse_header(text).unit or text)


def _is_text(row: Row, headers: list[Header]) -> bool:
    """Return whether a row is a title or a note, but not a remark on a run.

    Or quantities without a column.
    """
    filled = filled_at(row)
    texts = {at: row.texts[at] for at in filled}
    numbers = {at for at, text in texts.items() if _is_only_number(text)}
    if numbers:
        return _are_quantities(row, numbers, headers)
    columns = [(at, headers[at]) for at in filled if at < len(headers)]
    if any(_is_remark(at, header) for at, header in columns):
        return False
    return BLANKS.isdisjoint(texts.values())


def _is_only_number(text: str) -> bool:
    return is_number(text) and not _WORDS.search(text)


def _are_quantities(row: Row, numbers: set[int], headers: list[Header]) -> bool:
    """Return whether the numbers of a row are quantities without a column.

    "Part B: mass 40.3 g, r = 15.0 cm, 1/3 turn" is not a run of the table above.
    """
    statements = statements_in(row) if len(numbers) < 4 else {}
    places = {at for _, at in statements.values()}
    if not statements or not numbers <= places:
        return False
    return numbers < places or lacking_roles(headers).issuperset(statements)


def _is_remark(at: int, header: Header) -> bool:
    """Return whether a text in a column may be a remark on a run."""
    kinds = set(map(roles.kind_of_role, header.roles))
    return "sign" in kinds or ("text" in kinds and at > 0)
