"""Make one table of runs of a sheet with titles, several tables, means and notes.

A row of a sheet is a header, a row of units, a run, a summary or text. A sheet is read
as a teaching assistant reads it: rows that are not runs are left out, a caption is
valid for the runs below it, and a note says each of these things.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterable
from itertools import pairwise

from msgspec import Struct, field
from msgspec.structs import replace

from gyrodata.base.errors import InputError
from gyrodata.quantities import numerals
from gyrodata.quantities.units import kinds_of
from gyrodata.readings import captions, roles
from gyrodata.readings.captions import Given, said_in
from gyrodata.readings.grid import (
    HEADERS_LOOKED_AT,
    Grid,
    Row,
    count_of_numbers,
    filled_at,
    find_place,
    is_bare,
    is_head,
    is_number,
    units_of_row,
)
from gyrodata.readings.headers import (
    Header,
    are_turns,
    counts_weights,
    hinted,
    is_of_the_spin,
    parse_header,
)
from gyrodata.readings.lablog import BLANKS, Faults, Text, listing
from gyrodata.readings.turns import turns_in
from gyrodata.readings.words import (
    COUNTER_WORDS,
    MEAN_WORDS,
    SUMMARY_WORDS,
    UNSURE_WORDS,
    Phrases,
    squeeze,
)
from gyrodata.readings.workbook import MAX_COLUMNS

NOT_USED = Phrases("not_used")
"""Words of a note on a run that is not valid."""
_NOT_MEASURED = Phrases("not_measured")
_TWO_WORDS = re.compile(r"[^\W\d_]{3}\W+[^\W\d_]{3}")
"""Of "2 reflective strips": it is not a number with its unit."""
_COUNTS_UP = re.compile(r"[^\W\d]|(?i:count)")
"""Headers of columns that may number the runs, such as N."""


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


_Column = tuple[Text, Header]


def find_layout(
    grid: Grid, faults: Faults, decided: Collection[str] = ()
) -> Layout | None:
    """Find the header and the rows; None, with diagnostics, if there is no such table.

    An option gives the roles in `decided`, or names the headers in it.
    """
    try:
        head = _find_head(grid, faults)
        _name_counters(grid, head, decided)
        _split_rows(grid.rows, len(head.texts))
        grid = _with_captions(grid, head)
        sheet = _Sheet(grid, decided, faults)
        first = grid.rows.index(head)
        sheet.words += grid.rows[:first]
        sheet.begin(head)
        for row in grid.rows[first + 1 :]:
            sheet.take(row)
        return sheet.finish()
    except InputError:
        return None


# --- The header row ---


def _find_head(grid: Grid, faults: Faults) -> Row:
    """Return the header row of the first table."""
    if not grid.rows:
        raise faults.refuse("no_table")
    heads = list(filter(is_head, grid.rows))
    if not heads and max(len(row.texts) for row in grid.rows) == 1:
        raise faults.refuse("no_delimiter", grid.cell(grid.rows[0], 0))
    rows = grid.rows[:HEADERS_LOOKED_AT]
    head = next(filter(is_head, rows), None) or _first_of_usual_width(rows)
    if 2 * count_of_numbers(head.texts) >= max(1, len(filled_at(head))):
        raise faults.refuse("no_header_row", grid.cell(head, 0))
    if early := next(filter(_is_of_numbers, rows[: rows.index(head)]), None):
        cell, lines = grid.cell(early, 0), [early.line]
        line = [head.line]
        raise faults.refuse("numbers_above_header", cell, early=lines, line=line)
    return head


def _is_of_numbers(row: Row) -> bool:
    """Return whether most cells of a row are numbers.

    "turns:", "1", "", "1" is a caption of tables beside each other.
    """
    bare = sum(map(is_bare, row.texts))
    return bare > 2 and 2 * bare > len(filled_at(row)) and row.texts[0][-1:] != ":"


def _first_of_usual_width(rows: list[Row]) -> Row:
    """Return the first row that is as wide as most rows."""
    widths = Counter(len(row.texts) for row in rows if len(filled_at(row)) > 1)
    usual = max(widths, key=widths.__getitem__, default=0)
    return next((row for row in rows if len(row.texts) == usual), rows[0])


def _name_counters(grid: Grid, head: Row, decided: Collection[str]) -> None:
    """Call a column such as "Lap" or "N" run if its cells are 1, 2, 3, ….

    They may repeat if a text states turns.
    """
    may_repeat = any(map(turns_in, captions.texts_of(grid)))
    for at, text in enumerate(head.texts):
        is_lap = at == 0 and _is_lap(head)
        if text in decided or not (is_lap or _may_count(text)):
            continue
        cells = _cells_below(grid, head, at)
        is_once = cells.count("1") == 1 or (may_repeat and not is_lap)
        if is_once and _count_up(cells):
            head.texts[at] = "run"


def _may_count(name: str) -> bool:
    is_word = squeeze(name).lower() in COUNTER_WORDS
    return is_word or _COUNTS_UP.fullmatch(name) is not None


def _is_lap(head: Row) -> bool:
    """Return whether the first column is called turns, and another header states turns."""
    is_turns = parse_header(head.texts[0]).roles == ("turns",)
    return is_turns and any(map(turns_in, head.texts))


def _cells_below(grid: Grid, head: Row, at: int) -> list[str]:
    """Return the filled cells of a column, in rows that may be runs."""
    rows = [row for row in grid.rows if row.line > head.line]
    texts = [row.texts[at : at + 1] for row in rows if count_of_numbers(row.texts) > 1]
    return list(filter(None, map("".join, texts)))


def _count_up(cells: list[str]) -> bool:
    """Return whether cells are 1, 2, 3, …, perhaps several times from 1 on."""
    numbers = [int(cell) if cell.isdigit() else 0 for cell in cells]
    steps = [after in (1, before + 1) for before, after in pairwise([0, *numbers])]
    return len(cells) > 3 and max(numbers) > 1 and all(steps)


def _split_rows(rows: list[Row], width: int) -> None:
    """Split the rows that were typed with another delimiter than the header."""
    if width < 3:
        return
    for row in rows:
        if len(row.texts) > 1:
            continue
        for sign in ",;\t":
            parts = row.texts[0].split(sign)
            if len(parts) == width and all(map(is_number, parts)):
                row.texts[:] = parts


def _with_captions(grid: Grid, head: Row) -> Grid:
    """Add the lines behind # that give a quantity without a column to the rows.

    An example is "# each time is for one full turn".
    """
    heads = list(filter(is_head, grid.rows)) or [head]
    lacking = lacking_roles(_headers_of(heads), grid)
    lines = {row.line for row in grid.rows}
    added = [
        Row(note.place.line, [f"# {note.text}"])
        for note in grid.notes()
        if lacking and note.place.line not in lines
    ]
    added = [row for row in added if lacking.intersection(said_in(row))]
    rows = sorted([*grid.rows, *added], key=lambda row: row.line)
    return replace(grid, rows=rows) if added else grid


def _headers_of(rows: Iterable[Row]) -> list[Header]:
    return [parse_header(text) for row in rows for text in row.texts]


def lacking_roles(headers: list[Header], grid: Grid | None = None) -> set[str]:
    """Return the roles that no column of a table contains.

    No "# key: value" line of the grid contains them either, so a caption may give them.
    """
    there = {key.lower() for key, _ in grid.metadata} if grid else set()
    for header in headers:
        there |= _roles_served(header)
    if "angle" in there:
        there.add("turns")
    if "torque" in there:
        there |= {"mass", "position"}
    if "force" in there:
        there.add("mass")
    return {"mass", "position", "spin", "turns"} - there


def _roles_served(header: Header) -> set[str]:
    """Return the roles that a column contains, or may contain."""
    served = set(header.roles)
    if turns_in(header.text):
        served.add("turns")
    if counts_weights(header):
        served.add("mass")
    if served and all(role.startswith("spin") for role in header.roles):
        served.add("spin")
    if not header.roles:
        # "mass without hanger [g]" is a mass, although gyro has to ask which; "gap
        # [cm]" may be the position, and "disks [g]" the mass.
        served |= hinted(header)
        kinds = kinds_of(header.unit or "") & {"length", "mass"}
        served |= {captions.SAID_KINDS[kind] for kind in kinds}
    return served


def is_of_means(header: str) -> bool:
    """Return whether a column contains means, by its name."""
    words = re.split(r"[\s_,;()\[\]\-]+", header)
    return any(squeeze(word).lower() in MEAN_WORDS for word in words)


# --- Headers that other texts explain ---


def _with_numbered_spins(columns: list[_Column], faults: Faults) -> list[_Column]:
    """Read "rpm1" and "rpm2" as the spin before and after.

    Their mean is right for two readings at one time too.
    """
    texts = [cell.text for cell, _ in columns]
    for at, text in enumerate(texts):
        before = parse_header(text.replace("1", " start", 1))
        second, third = (text.replace("1", digit, 1) for digit in "23")
        is_pair = text != second and second in texts and third not in texts
        if is_pair and before.roles == ("spin_start",):
            after = parse_header(text.replace("1", " end", 1))
            behind = texts.index(second)
            columns[at] = columns[at][0], replace(before, text=text)
            columns[behind] = columns[behind][0], replace(after, text=second)
            faults.add("numbered_spins", columns[at][0], second=second)
    return columns


def _explained(column: _Column, legends: dict[str, str]) -> _Column:
    """Return a column with what a legend says of its header."""
    if not legends:
        return column
    cell, header = column
    name = header.name if header.unit else cell.text
    words = legends.get(squeeze(name), "")
    if not words:
        return column
    explained = parse_header(words)
    gives_unit = explained.unit and header.unit is None
    if gives_unit or _says_more(explained, header):
        names = explained.roles or header.roles
        unit = explained.unit or header.unit
        return replace(cell, text=words), replace(explained, roles=names, unit=unit)
    return _with_turns_of_legend(column, words)


def _says_more(explained: Header, header: Header) -> bool:
    """Return whether a legend names a role, or the moment of the role that a header has."""
    if len(header.roles) != 1 or len(explained.roles) != 1:
        return bool(explained.roles) and not header.roles
    return explained.roles[0].startswith(f"{header.roles[0]}_")


def _with_turns_of_legend(column: _Column, words: str) -> _Column:
    """Return the column of a time with the turns that a legend states."""
    cell, header = column
    is_time = "time" in kinds_of(header.unit or "")
    timed = parse_header(f"{words} [{header.unit}]")
    states_turns = turns_in(words) and not turns_in(cell.text)
    if is_time and states_turns and "time" in timed.roles:
        return replace(cell, text=words), timed
    return column


def _with_uncertainties(columns: list[_Column]) -> list[_Column]:
    """Read "±" or "error" as the uncertainty of the column on its left."""
    for at, ((_, left), (cell, header)) in enumerate(pairwise(columns), 1):
        name = header.name.strip()
        is_sign = name in ("±", "+/-", "+-")
        if len(left.roles) == 1 and (is_sign or squeeze(name).lower() in UNSURE_WORDS):
            role, unit = f"u_{left.roles[0]}", header.unit or left.unit
            header = replace(header, roles=(role,), unit=unit)
            columns[at] = replace(cell, text=f"u({left.text})"), header
    return columns


def _with_numbered_times(columns: list[_Column], faults: Faults) -> list[_Column]:
    """Number the times if several have the same header."""
    times = [at for at, (_, header) in enumerate(columns) if header.roles == ("time",)]
    if len({columns[at][1] for at in times}) < len(times):
        for number, at in enumerate(times, 1):
            cell, header = columns[at]
            columns[at] = cell, replace(header, number=number)
        faults.add("same_times", columns[times[-1]][0])
    return columns


# --- From row to row ---


class _Run(Struct, frozen=True):
    """A row of readings."""

    row: Row
    places: list[int]
    """Number of the column of each cell, among those of all tables."""
    given: Given
    """What captions give."""


class _Table(Struct):
    """The table whose rows are read."""

    head: Row
    columns: list[_Column]
    named: list[_Column]
    """The columns without what a row of units says."""
    is_apart: bool
    """Whether a blank column separates the table from what is on its right."""
    given: Given
    """What captions give for its next run."""
    is_new: bool = True
    """Whether it has no row yet."""
    is_skipped: bool = False
    """Whether its rows are not runs."""
    has_ended: bool = False
    """Whether the next rows are results."""
    places: list[int] = field(default_factory=list)
    """Number of each column among those of all tables."""

    @property
    def headers(self) -> list[Header]:
        """Return what each header says."""
        return [header for _, header in self.columns]


class _Sheet:
    """Goes down the rows of a sheet, and makes one table of all runs."""

    def __init__(self, grid: Grid, decided: Collection[str], faults: Faults) -> None:
        self.grid, self.decided, self.faults = grid, decided, faults
        self.columns: list[_Column] = []
        """Columns of all tables."""
        self.runs: list[_Run] = []
        self.tables: list[int] = []
        """Number of the first run of each table."""
        self.words: list[Row] = []
        """Rows of text above the next run."""
        self.left_out: dict[str, list[tuple[Row, int]]] = {
            name: [] for name in ("title", "taken_out", "summary")
        }
        """Rows that are not runs, with the cell that shows it."""
        self.general: Given = {}
        """What captions say of all tables."""
        self.earlier: Given = {}
        """What captions gave last: a position or turns are valid until others are
        given."""
        self.captions: list[tuple[Text, str, str]] = []
        """Each caption, whether its runs are below or above it, and what was read of
        it."""
        self.legends = captions.legends_of(grid)
        headers = _headers_of(filter(is_head, grid.rows))
        self.any_timed = any(map(_states_timing, headers))
        """Whether a header of the sheet names a time or turns."""
        self.only_means = False
        """Whether the first table contains means."""
        self.served: set[str] = set()
        """Parts of a run in the first table."""

    def begin(self, head: Row) -> None:
        """Begin a table with its header row."""
        columns = [
            (self.grid.cell(head, at), parse_header(text))
            for at, text in enumerate(head.texts)
        ]
        columns = _with_numbered_spins(columns, self.faults)
        columns = [_explained(column, self.legends) for column in columns]
        columns = _with_uncertainties(columns)
        columns = _with_numbered_times(columns, self.faults)
        beyond = len(head.texts)
        beside = [row.texts[beyond : beyond + 1] for row in self.grid.rows]
        is_apart = not any(map(any, beside))
        given = dict(self.general)
        self.table = _Table(head, columns, list(columns), is_apart, given)

    def take(self, row: Row) -> None:
        """Read the next row."""
        table = self.table
        row = self._without_cells_beside(row)
        if not any(row.texts):
            return
        if is_head(row) or row.texts == table.head.texts:
            self._begin_next(row)
        elif table.is_new and (units := units_of_row(row.texts)):
            self._take_units(units)
        elif row.texts[0] == "#":  # a # that a spreadsheet put into a cell of its own
            self._leave_out("taken_out", row)
        elif _is_summary(row, table.headers):
            self._leave_out("summary", row)
            # "slope", "intercept" above numbers
            table.has_ended |= _count_of_summaries(row) > 1
        elif _is_text(row, table.headers):
            self.words.append(row)
            # "I_zz (kg m^2), uncertainty (kg m^2)": the numbers below are results.
            is_title = len(filled_at(row)) < 2
            table.has_ended = bool(self.runs) and _names_inertia(row) and not is_title
        else:
            self._take_numbers(row)

    def _begin_next(self, head: Row) -> None:
        """Begin another table; a header without runs below it is a row of text."""
        if self.table.is_new:
            # "time of one turn, x from the centre" above the names
            self.words.append(self.table.head)
        self.begin(head)

    def _without_cells_beside(self, row: Row) -> Row:
        """Leave out the cells that a blank column separates from the table."""
        width = len(self.table.columns)
        beside = [at for at in filled_at(row) if at >= width]
        if not beside or not self.table.is_apart:
            return row
        self.left_out["title"].append((row, beside[0]))
        return replace(row, texts=row.texts[:width])

    def _take_units(self, units: list[str]) -> None:
        """Give the headers the units of a row of units."""
        table = self.table
        if not all(_unit_fits(header) for header in table.headers):
            # The first row, such as "S, t, N", contains symbols.
            table.columns = list(table.named)
        left = ""
        for at, (unit, (cell, header)) in enumerate(
            zip(units, list(table.columns), strict=False)
        ):
            # Minutes and seconds are below one "time".
            text = header.text or left
            left = table.columns[at][1].text
            if unit in BLANKS or unit == "1" or header.unit is not None:
                continue
            words = ""
            if not kinds_of(unit):
                unit, _, words = unit.replace(",", " ").partition(" ")
            text = f"{text} {words.strip()}".rstrip() if words else text
            parsed = replace(parse_header(f"{text} [{unit}]"), text=text)
            cell = replace(cell, text=text) if words else cell
            table.columns[at] = cell, parsed
            left = text

    def _leave_out(self, why: str, row: Row) -> None:
        self.left_out[why].append((row, filled_at(row)[0]))

    def _take_numbers(self, row: Row) -> None:
        """Read a row of numbers: a run, one that was taken out, or a result."""
        table = self.table
        texts = [text for text in row.texts if not is_number(text)]
        is_note = _begins_with_note(row, table.headers)
        if any(map(NOT_USED.is_in, texts)):
            self._leave_out("taken_out", row)
        elif not is_note and self._is_below_runs(row):
            self._leave_out("summary", row)
        else:
            self._take_run(row)

    def _is_below_runs(self, row: Row) -> bool:
        """Return whether a row is a result: it begins with a text, and has no time."""
        if self.table.has_ended or _names_inertia(row):
            return True
        if not self.runs or not _is_label(row.filled()[0]):
            return False
        headers = self.table.headers
        timed = {at for at, header in enumerate(headers) if _is_timing(header)}
        first, *others = filled_at(row)
        # "standard error" may be in the column of the times.
        is_mostly_blank = 2 * len(row.filled()) < len(headers)
        may_be_time = first in timed and not is_mostly_blank
        return bool(timed) and timed.isdisjoint(others) and not may_be_time

    def _take_run(self, row: Row) -> None:
        table = self.table
        is_first, table.is_new = table.is_new, False
        if is_first:
            self._begin_runs()
        typed = [
            (header, text)
            for header, text in zip(table.headers, row.texts, strict=False)
            if text
        ]
        there = {role for header, _ in typed for role in header.roles}
        table.given = {
            role: item for role, item in table.given.items() if role not in there
        }
        if self.words:
            self._read_words(is_first, typed, there)
        self.earlier |= table.given
        if table.is_skipped:
            return
        if is_first:
            self._begin_table(there)
        row = self._without_remark(row)
        self.runs.append(_Run(row, table.places, table.given))

    def _read_words(
        self, is_first: bool, typed: list[tuple[Header, str]], there: set[str]
    ) -> None:
        """Add what the rows of text above a run give to it and to the runs below it."""
        lacking = lacking_roles(self.table.headers)
        if not is_first:
            # "moved to 10.0 cm" between the runs is valid for the blank cells below it,
            # until another value is typed.
            lacking |= {"mass", "position"} - there
        if any(are_turns(header, [text]) for header, text in typed):
            lacking.discard("turns")
        given = self.table.given | self._read_captions(lacking)
        new = given.keys() - self.general.keys()
        if new.isdisjoint({"mass", "position", "spin"}):
            lacking &= {"turns"}
        kept = {role: self.earlier[role] for role in self.earlier if role in lacking}
        self.table.given = kept | given

    def _begin_table(self, there: set[str]) -> None:
        """Note where the runs of a table begin, and check that nothing is missing."""
        table = self.table
        lacking = lacking_roles(table.headers) & {"position", "turns"}
        kept = {role: self.earlier[role] for role in self.earlier if role in lacking}
        table.given = kept | table.given
        there = there | table.given.keys()
        if not self.tables:
            parts = {*roles.FILLED_DOWN, *roles.TIMINGS} - {"torque"}
            self.served = there & parts
        self.tables.append(len(self.runs))
        lost = self.served - there
        # A position is blank in a run without a weight.
        if any("position" in header.roles for header in table.headers):
            lost.discard("position")
        if lost:
            line, lacks = [table.head.line], roles.BY_NAME[min(lost)]
            cell = table.columns[0][0]
            raise self.faults.refuse("lacks_in_first_row", cell, line=line, lacks=lacks)

    def _without_remark(self, row: Row) -> Row:
        """Leave out the texts on the right of the table."""
        width = len(self.table.places)
        beyond = [at for at in filled_at(row) if at >= width]
        if not beyond or any(is_number(row.texts[at]) for at in beyond):
            return row
        self.left_out["title"].append((row, beyond[0]))
        return Row(row.line, row.texts[:width], row.origin)

    def _begin_runs(self) -> None:
        """Give the columns of a table their places among all columns.

        This is not done if the rows of the table are not runs.
        """
        table = self.table
        means = self._are_means()
        if why := self._why_skipped(means):
            table.is_skipped = True
            self.faults.add(why, table.columns[0][0], line=[table.head.line])
            return
        if not self.runs:
            self.only_means = means
        self._check_names()
        for column in table.columns:
            table.places.append(self._place_of(column))

    def _why_skipped(self, means: bool) -> str:
        """Return the name of the note if the rows of a table are not runs; else ""."""
        names_turns = any(turns_in(cell.text) for cell, _ in self.table.columns)
        if self.any_timed and not names_turns and not self._timings():
            return "untimed_table"
        if self._is_not_measured():
            return "table_not_measured"
        is_calculated = means and self.runs and not self.only_means
        return "table_of_means" if is_calculated else ""

    def _timings(self) -> list[str]:
        """Return the headers of the times of a table.

        Next to a table of times, one of rates is calculated.
        """
        timings = set(roles.TIMINGS)
        if any("time" in header.roles for _, header in self.columns):
            timings.discard("precession_rate")
        headers = self.table.headers
        return [header.text for header in headers if timings & {*header.roles}]

    def _are_means(self) -> bool:
        """Return whether a table contains means, by its title or its headers."""
        words = [text for row in self.words for text in row.texts if text[:1] != "#"]
        title = " ".join(words)
        if is_of_means(title) and not turns_in(title):
            return True
        timings = self._timings()
        return bool(timings) and all(map(is_of_means, timings))

    def _is_not_measured(self) -> bool:
        """Return whether the title of one of several tables says that it is not measured."""
        if sum(map(is_head, self.grid.rows)) < 2:
            return False
        titles = [text for row in self.words for text in row.texts if len(text) < 60]
        return any(
            _NOT_MEASURED.is_in(title) and not re.search(captions.TIMED, title)
            for title in titles
        )

    def _check_names(self) -> None:
        """Refuse two columns of one name."""
        seen = set()
        for cell, header in self.table.columns:
            if cell.text and (cell.text, header) in seen:
                name = "same_spins" if header.roles == ("spin",) else "same_names"
                raise self.faults.refuse(name, cell)
            seen.add((cell.text, header))

    def _place_of(self, column: _Column) -> int:
        """Return the number of a column among those of all tables; add it if it is new."""
        cell, header = column
        for place, old in enumerate(self.columns):
            if place not in self.table.places and _are_same(old, column):
                if old[1].unit != header.unit and header.roles:
                    line, first = [cell.place.line], old[0].text
                    raise self.faults.refuse("other_unit", cell, line=line, first=first)
                return place
        self.columns.append(column)
        return len(self.columns) - 1

    # --- Captions ---

    def _read_captions(self, lacking: set[str], where: str = "below") -> Given:
        """Return what the rows of text above a run say of what is lacking in it.

        Above the first table the last row that says something is of this table; those
        before it are of all tables.
        """
        given: Given = {}
        lacking = lacking & lacking_roles([], self.grid)
        used = set(dict(self.faults.sheets))
        for row in self.words:
            said = {
                role: (text, row.spot(at))
                for role, (text, at) in self._said_in(row).items()
                if role in lacking
            }
            if not said:
                continue
            self._note_caption(row, where, said)
            used |= {row.spot(at) // MAX_COLUMNS for at in range(len(row.texts))}
            if not self.runs and given:
                self.general = dict(given)
            two = _contradictions(given, said) if where == "above" else set()
            given = {
                role: item for role, item in (given | said).items() if role not in two
            }
            lacking = lacking - two
        self._leave_out_words(used)
        return given

    def _leave_out_words(self, used: set[int]) -> None:
        """Leave out the rows of text above a run, without those of some lines."""
        for row in self.words:
            if row.line not in used and not row.texts[0].startswith("#"):
                self._leave_out("title", row)
        self.words = []

    def _said_in(self, row: Row) -> Given:
        """Return what a row of text says; warn if a header states other turns."""
        said = said_in(row)
        is_legend = any(captions.is_legend(text, self.legends) for text in row.texts)
        if "turns" in said and "turns" not in self.decided and not is_legend:
            self._compare_with_headers(row, said["turns"][0])
        return said

    def _note_caption(self, row: Row, where: str, said: Given) -> None:
        words = ", ".join(f"{role} {text}" for role, (text, _) in said.items())
        self.captions.append((self.grid.first_cell(row), where, words))

    def _compare_with_headers(self, caption: Row, turns: str) -> None:
        """Warn of each header of times that states other turns than a caption."""
        for cell, header in self.table.columns:
            stated = turns_in(cell.text)
            of_others = is_of_the_spin(cell.text) or header.roles == ("turns",)
            if turns and stated not in ("", turns) and not of_others:
                other = caption.texts[filled_at(caption)[0]]
                self._warn_of_turns(cell, cell.text, stated, other, turns)

    def _compare_with_captions(self, turns: str, spot: int) -> None:
        """Warn of each row below the tables that states other turns than a caption."""
        for row in self.words:
            says = said_in(row).get("turns", ("", 0))[0]
            if says not in ("", turns):
                cell = self.grid.first_cell(row)
                caption = self.grid.lines[spot // MAX_COLUMNS - 1].strip()
                self._warn_of_turns(cell, caption, turns, cell.text, says)

    def _warn_of_turns(
        self, cell: Text, header: str, turns: str, other: str, says: str
    ) -> None:
        self.faults.add(
            "turns_contradict_header",
            cell,
            header=header,
            turns=turns,
            other=other,
            says=says,
        )

    # --- The whole table ---

    def finish(self) -> Layout:
        """Return all runs as one table.

        The function adds notes on everything that was left out, and on everything that
        was read from captions.
        """
        self._read_captions_below()
        self._add_given_columns()
        rows = [self._joined(run) for run in self.runs]
        parts = [rows[start:end] for start, end in pairwise([*self.tables, len(rows)])]
        headers = [header for _, header in self.columns]
        for part in parts:
            if _ends_with_means(part, headers):
                self._leave_out("summary", part.pop())
        self._note_left_out()
        self._note_captions()
        if not self.runs:
            raise self.faults.refuse("no_runs")
        self._check_repeated(parts)
        cells = [
            cell if cell.text else replace(cell, text=f"column {n}")
            for n, (cell, _) in enumerate(self.columns, 1)
        ]
        self._note_parts(parts, cells[0])
        rows = [row for part in parts for row in part]
        self._check_split_header(rows)
        return Layout(self.grid, cells, headers, rows)

    def _read_captions_below(self) -> None:
        """Read the rows of text below the last run."""
        if not self.words:
            return
        lacking = self._lacking_roles()
        above = {run.given["turns"] for run in self.runs if "turns" in run.given}
        if len(above) == 1 and "turns" not in self.decided:
            self._compare_with_captions(*min(above))
        below = self._read_captions(lacking, "above")
        if below:
            self.runs = [replace(run, given=below | run.given) for run in self.runs]

    def _lacking_roles(self) -> set[str]:
        """Return the roles that neither columns nor captions give."""
        lacking = lacking_roles([header for _, header in self.columns])
        for run in self.runs:
            lacking -= run.given.keys()
        if any(map(self._are_turns, range(len(self.columns)))):
            lacking.discard("turns")  # a column with an unknown name counts them
        return lacking

    def _are_turns(self, place: int) -> bool:
        cells = [
            run.row.texts[run.places.index(place)]
            for run in self.runs
            if place in run.places[: len(run.row.texts)]
        ]
        return are_turns(self.columns[place][1], cells)

    def _add_given_columns(self) -> None:
        """Add a column for each role that captions give."""
        given = {
            role: spot for run in self.runs for role, (_, spot) in run.given.items()
        }
        there = {header.roles for _, header in self.columns}
        for role, spot in given.items():
            if (role,) not in there:
                place = find_place(self.grid.lines, self.grid.delimiter, spot)
                header = Header(role, (role,), None, "")
                self.columns.append((Text(role, place), header))

    def _joined(self, run: _Run) -> Row:
        """Return a run with each cell at the place of its column, and what captions give."""
        row, width = run.row, len(self.columns)
        if not run.given and run.places == list(range(width)):
            blank = [""] * (width - len(row.texts))
            return replace(row, texts=[*row.texts, *blank])
        names = [header.roles for _, header in self.columns]
        cells = {names.index((role,)): item for role, item in run.given.items()}
        beyond = range(width, width + len(row.texts))
        for at, place in zip(
            range(len(row.texts)), [*run.places, *beyond], strict=False
        ):
            if row.texts[at]:
                cells[place] = row.texts[at], row.spot(at)
        last = max([width - 1, *cells])
        filled = [cells.get(at, ("", row.spot(0))) for at in range(last + 1)]
        spots = tuple(spot for _, spot in filled)
        return Row(row.line, [text for text, _ in filled], spots)

    def _note_left_out(self) -> None:
        captioned = {cell.place.line for cell, *_ in self.captions}
        for why, rows in self.left_out.items():
            left = [(row, at) for row, at in rows if row.line not in captioned]
            if left:
                texts = listing([row.texts[at] for row, at in left], 4)
                lines = sorted({row.line for row, _ in left})
                self.faults.add(why, self.grid.cell(*left[0]), lines=lines, texts=texts)

    def _note_captions(self) -> None:
        for cell, where, said in self.captions:
            line = [cell.place.line]
            self.faults.add("caption", cell, line=line, where=where, said=said)
            self.faults.take_back("remark", line)

    def _check_repeated(self, parts: list[list[Row]]) -> None:
        """Refuse a table that contains two rows of another one."""
        width = len(self.runs[0].places)
        seen: set[tuple[str, ...]] = set()
        for part in parts:
            rows = [tuple(row.texts[:width]) for row in part]
            if sum(row in seen for row in rows) > 1:
                cell, line = self.grid.first_cell(part[0]), [part[0].line]
                raise self.faults.refuse("repeated_table", cell, line=line)
            seen.update(rows)

    def _note_parts(self, parts: list[list[Row]], cell: Text) -> None:
        lines = [sorted({row.line for row in part}) for part in parts]
        if len(parts) > 1:
            spans = ", ".join(map(self.faults.span, lines))
            self.faults.add("tables_joined", cell, count=len(parts), lines=spans)

    def _check_split_header(self, rows: list[Row]) -> None:
        """Refuse a header that is split at its own comma: "period [s], 5 turns"."""
        for at, ((cell, left), (behind, right)) in enumerate(pairwise(self.columns), 1):
            turns = turns_in(behind.text)
            may_be_split = cell.text and turns and not (left.unit and right.unit)
            if may_be_split and not any(row.texts[at] for row in rows):
                header = cell.text
                raise self.faults.refuse(
                    "header_split", behind, header=header, turns=turns
                )


# --- Kinds of rows ---


def _states_timing(header: Header) -> bool:
    return not set(roles.TIMINGS).isdisjoint(header.roles) or bool(
        turns_in(header.text)
    )


def _is_timing(header: Header) -> bool:
    is_time = "time" in kinds_of(header.unit or "")
    return is_time or not set(roles.TIMINGS).isdisjoint(header.roles)


def _begins_with_note(row: Row, headers: list[Header]) -> bool:
    first = filled_at(row)[0]
    return first < len(headers) and "note" in headers[first].roles


def _is_summary(row: Row, headers: list[Header]) -> bool:
    """Return whether a row begins with a word for means, deviations or sums."""
    text = row.texts[filled_at(row)[0]]
    start = (re.split(r"[\s_:,;(=]+", text)[0], re.sub(r"[()=:]", "", text))
    words = {squeeze(word).lower() for word in start}
    is_note = _begins_with_note(row, headers)
    return not is_note and not SUMMARY_WORDS.isdisjoint(words)


def _count_of_summaries(row: Row) -> int:
    return sum(squeeze(text).lower() in SUMMARY_WORDS for text in row.texts)


def _names_inertia(row: Row) -> bool:
    """Return whether a cell names a moment of inertia, by its unit."""
    texts = [text for text in row.texts if not is_number(text)]
    return any("inertia" in kinds_of(parse_header(text).unit or text) for text in texts)


def _is_text(row: Row, headers: list[Header]) -> bool:
    """Return whether a row is a title or a note, but not a remark on a run.

    Or quantities without a column.
    """
    filled = filled_at(row)
    numbers = {at for at in filled if _is_quantity(row.texts[at])}
    if numbers:
        return _are_quantities(row, numbers, headers)
    columns = [(at, headers[at]) for at in filled if at < len(headers)]
    if any(_is_remark(at, header) for at, header in columns):
        return False
    return BLANKS.isdisjoint(row.texts[at] for at in filled)


def _is_quantity(text: str) -> bool:
    return is_number(text) and not _TWO_WORDS.search(text)


def _are_quantities(row: Row, numbers: set[int], headers: list[Header]) -> bool:
    """Return whether the numbers of a row are quantities without a column.

    "Part B: mass 40.3 g, r = 15.0 cm, 1/3 turn" is not a run of the table above.
    """
    said = said_in(row) if len(numbers) < 4 else {}
    places = {at for _, at in said.values()}
    if not said or not numbers <= places:
        return False
    return numbers < places or lacking_roles(headers).issuperset(said)


def _is_remark(at: int, header: Header) -> bool:
    """Return whether a text in a column may be a remark on a run."""
    kinds = set(map(roles.kind_of_role, header.roles))
    return "sign" in kinds or ("text" in kinds and at > 0)


def _is_label(text: str) -> bool:
    """Return whether a cell is no number, or has a unit that gyro does not know."""
    if text in BLANKS:
        return False
    written = numerals.take_apart(text)
    return written is None or bool(written.unit and not kinds_of(written.unit))


def _unit_fits(header: Header) -> bool:
    """Return whether the unit of a header can measure one of its roles."""
    if not header.unit or not header.roles:
        return True
    kinds = set(map(roles.kind_of_role, header.roles))
    return not kinds.isdisjoint(kinds_of(header.unit))


def _are_same(old: _Column, new: _Column) -> bool:
    """Return whether columns of two tables contain one quantity."""
    (old_cell, old_header), (cell, header) = old, new
    if turns_in(old_cell.text) != turns_in(cell.text):
        return False
    if squeeze(old_cell.text) == squeeze(cell.text) != "":
        return True
    content = (header.roles, header.number)
    return len(header.roles) == 1 and (old_header.roles, old_header.number) == content


def _contradictions(given: Given, said: Given) -> set[str]:
    """Return the roles of which two captions give different texts."""
    return {
        role
        for role, (text, _) in said.items()
        if role in given and given[role][0] != text
    }


def _ends_with_means(part: list[Row], headers: list[Header]) -> bool:
    """Return whether the last row of a table contains the means of those above it."""
    if len(part) < 3 or not _is_mean(part, headers, "time"):
        return False
    *above, last = part
    if len(filled_at(last)) < min(len(filled_at(row)) for row in above):
        return True
    return last.line > above[-1].line + 1 and _is_mean(part, headers, "spin")


def _is_mean(rows: list[Row], headers: list[Header], role: str) -> bool:
    """Return whether the last row contains the mean of each column of a role above it."""
    places = [at for at, header in enumerate(headers) if role in header.roles]
    for at in places:
        try:
            *above, last = (numerals.to_float(row.texts[at]) for row in rows)
        except (ValueError, IndexError):
            return False
        if abs(sum(above) - len(above) * last) >= 1e-3 * abs(sum(above) or 1):
            return False
    return bool(places)
