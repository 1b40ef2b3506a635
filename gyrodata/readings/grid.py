"""Split the text of a log into rows of cells, and say what each row is.

Lines that begin with # are not rows: they are keys with values, or comments.
"""

from __future__ import annotations

import csv
import itertools
import re
from collections import Counter
from collections.abc import Iterator, Sequence

from msgspec import Struct
from msgspec.structs import replace

from gyrodata.quantities import numerals, vocabulary
from gyrodata.quantities.units import kinds_of
from gyrodata.readings import roles
from gyrodata.readings.ball import constants_in
from gyrodata.readings.headers import parse_header
from gyrodata.readings.lablog import BLANKS, Faults, Place, Text
from gyrodata.readings.names import MAX_HEADER, SPHERE, reported_key, station_in
from gyrodata.readings.reported import read_reported
from gyrodata.readings.settings import YES_OR_NO
from gyrodata.readings.turns import turns_in
from gyrodata.readings.workbook import MAX_COLUMNS, MAX_ROWS

MAX_CELL = 10_000
MAX_NOTE = 2_000
"""Characters of a line that begins with #."""
MAX_PROSE = 300_000
"""Characters in lines that begin with #, in rows without a digit and in cells that are
longer than any header."""
_LEAST_NOTE = 30
"""Characters that a shorter note counts."""
HEADERS_LOOKED_AT = 60
"""Rows in which a header is looked for."""


class Row(Struct, frozen=True):
    """One row of a table."""

    line: int
    """Line of the file in which it begins."""
    texts: list[str]
    """Its cells, without quotes and without blanks around them; blank ones at the end
    are cut off."""
    origin: tuple[int, ...] = ()
    """Number of each cell in the file, if the cells are not those of this line."""

    def spot(self, at: int) -> int:
        """Return the number of a cell in the file."""
        if at < len(self.origin):
            return self.origin[at]
        return self.line * MAX_COLUMNS + at

    def filled(self) -> list[str]:
        """Return the cells that are not blank."""
        return [text for text in self.texts if text]

    def cells(self, places: Sequence[int]) -> Row:
        """Return a row with some of the cells; those beyond its end are blank."""
        texts = ["".join(self.texts[at : at + 1]) for at in places]
        return Row(self.line, texts, tuple(map(self.spot, places)))


class Grid(Struct, frozen=True):
    """The rows of a table, and the ``# key: value`` lines around it."""

    lines: list[str]
    """Lines of the file."""
    delimiter: str
    rows: list[Row]
    """Rows that are neither comments nor blank."""
    metadata: list[tuple[str, Text]]
    """Keys with their values, in the order of the file."""
    comments: list[Text]
    """``#`` lines without a ``key: value``."""
    floats: frozenset[int] = frozenset()
    """Columns of floats of a DataFrame: floats do not contain the digits that were
    read."""
    sha256: str = ""
    """Hash of the bytes that were read."""

    def cell(self, row: Row, at: int) -> Text:
        """Return one cell with its place, which only a fault needs."""
        return Text(row.texts[at], self.place_of(row.spot(at)))

    def place_of(self, spot: int) -> Place:
        """Return the place of a cell, by its number."""
        return find_place(self.lines, self.delimiter, spot)

    def remarks(self) -> list[Text]:
        """Return the "key: value" lines with other keys than those of gyro."""
        return [
            replace(text, text=f"{key.replace('_', ' ')}: {text.text}")
            for key, text in self.metadata
            if not roles.is_key(key)
        ]

    def first_cell(self, row: Row) -> Text:
        """Return the first cell of a row that is not blank."""
        return self.cell(row, filled_at(row)[0])


# --- Kinds of rows ---


def is_number(text: str) -> bool:
    """Return whether a cell begins like a number."""
    return text[:1].isdecimal() or (text[:1] in "+-−.,(" and text[1:2].isdecimal())


def is_bare(text: str) -> bool:
    """Return whether a cell is a number and nothing else."""
    return bool(numerals.PLAIN.fullmatch(numerals.fold_number(text)))


def filled_at(row: Row) -> list[int]:
    """Return the places of the cells of a row that are not blank."""
    return [at for at, text in enumerate(row.texts) if text]


def has_numbers(row: Row) -> bool:
    """Return whether a cell of a row begins like a number."""
    return any(map(is_number, row.texts))


def count_of_numbers(texts: Sequence[str]) -> int:
    """Return how many cells begin like numbers and name no quantity."""
    return sum(is_number(text) and not parse_header(text).roles for text in texts)


def is_head(row: Row) -> bool:
    """Return whether a row is a header: two names, one of them of a quantity."""
    filled = row.filled()
    if len(list(itertools.filterfalse(_SIGNS.issuperset, filled))) < 2:
        return False  # the rows of a long log
    named = list(filter(None, (parse_header(text).roles for text in filled)))
    if not any(map(roles.TEXTS.isdisjoint, named)):
        return False
    several = len(set(named)) > 1 or _are_repeats(len(named), row.texts)
    if not several or count_of_numbers(row.texts) * 2 >= len(filled):
        return False
    # "rpm", "t/s", "turns" are names, although each is a unit as well.
    return 2 < len(filled) == len(named) or not units_of_row(row.texts)


def _are_repeats(count: int, texts: Sequence[str]) -> bool:
    """Return whether several cells name one quantity.

    "t", "time for a quarter turn" explains a symbol, and "position", "10.8", "cm",
    "distance from the centre" gives a value.
    """
    has_value = any(map(turns_in, texts)) or any(map(is_bare, texts))
    return count > 1 and not has_value


_SIGNS = frozenset("0123456789.,/+-− ")
"""The signs of a number, a blank included."""


def units_of_row(texts: Sequence[str]) -> list[str]:
    """Return the units of a row of units, in brackets or not; [] for another row."""
    units = [text.strip("[]()").strip() for text in texts]
    is_row = any(map(_is_unit, units)) and all(map(_may_be_unit, texts))
    return units if is_row else []


def _may_be_unit(text: str) -> bool:
    """Return whether a text is blank, 1, a unit, or an unknown unit in brackets."""
    is_none = text in BLANKS or text == "1"
    return is_none or text[0] in "[(" or _is_unit(text)


def _is_unit(text: str) -> bool:
    if text == "%":
        return True
    is_number = numerals.PLAIN.fullmatch(text) is not None
    return not is_number and bool(kinds_of(text))


# --- From lines to rows ---


_COMMENT = (
    r'[ "\t]*#(?!(?:N/A|DIV/0!|VALUE!|REF!|NAME\?|NUM!|NULL!)'
    r"|\s*[;,\t|]|\s?of\b|\s{2,}\S.*?\S\s{2,})"
)
"""The sign # of a comment: a spreadsheet program writes #DIV/0! into a cell, and "# of
turns" is a header."""
_SIGNS_IN_KEY = frozenset("_ .()/-")
_LONGEST_KEY = 40
_RULE = frozenset("|+:=-")
"""Signs of a line of a Markdown table that only draws a line."""
_MOST_LINES_OF_A_CELL = 100
_MOST_CELLS_OF_KEY = 5
"""Cells of a row that states a value for the whole log: "I_zz", "4.4e-3", "±", "1e-4",
"kg m^2"."""


def make_grid(
    faults: Faults,
    delimiter: str = "",
    floats: frozenset[int] = frozenset(),
    sha256: str = "",
) -> Grid:
    """Split a log into cells; `delimiter` is given if gyro wrote the text itself."""
    typed = "\n".join(faults.lines)
    usual = _in_usual_signs(typed)
    lines = usual.split("\n")
    grid = Grid(lines, delimiter, [], [], [], floats, sha256)
    body = _take_notes(grid, faults)
    count = len(body) - 1  # without the header
    if count > MAX_ROWS:
        raise faults.refuse("too_many_rows", count=count)
    if body and not grid.delimiter:
        sign = _find_delimiter(lines, body)
        grid = replace(grid, delimiter=sign)
    for row in _split_lines(grid, body, faults):
        if len(row.filled()) > _MOST_CELLS_OF_KEY or not _take_key(row, grid, faults):
            grid.rows.append(row)
    if max(sum(map(len, lines)), _LEAST_NOTE * len(lines)) > MAX_PROSE:
        _check_prose(grid, faults)
    return grid


def _in_usual_signs(text: str) -> str:
    """Write the digits of all scripts as 0 to 9, and their decimal signs as points."""
    if text.isascii():
        return text
    digits = {ord(sign): str(int(sign)) for sign in set(text) if sign.isdecimal()}
    return text.translate({**digits, ord("．"): ".", ord("٫"): "."})


def _take_notes(grid: Grid, faults: Faults) -> list[int]:
    """Read the lines that begin with #; return the indices of the others."""
    body = []
    for index, line in enumerate(grid.lines):
        if line[:100].lstrip(' "\t').startswith("#") and len(line) > MAX_NOTE:
            raise faults.refuse("note_too_long", Place(index + 1, 1), most=MAX_NOTE)
        if re.match(_COMMENT, line):
            _take_note(grid, index, line)
        elif not _RULE.issuperset("".join(line.split())):
            body.append(index)
    return body


def _take_note(grid: Grid, index: int, line: str) -> None:
    """Add a line that begins with # to the keys or to the comments."""
    start = line.index("#") + 1
    content = line[start:].rstrip(" \t,;")
    # A spreadsheet may have put the line in quotes or added delimiters.
    if line.lstrip().startswith('"'):
        content = content.rstrip('"').replace('""', '"')
    place = Place(index + 1, start)
    key, value = _key_and_value(content)
    is_one_value = key in roles.KEYS and "," not in value and ";" not in value
    if SPHERE.is_in(content) and not is_one_value and (pairs := constants_in(content)):
        grid.metadata.extend((name, Text(text, place)) for name, text in pairs)
    elif key:
        name = "_".join(key.replace("-", " ").split())
        place = Place(index + 1, start + len(content) - len(value) + 1)
        grid.metadata.append((name, Text(value.strip(), place)))
    elif len(content) <= _SHORT_LINE and (station := station_in(content)):
        grid.metadata.append(("station", Text(station, place)))
    else:
        grid.comments.append(Text(content.strip(), place))


def _key_and_value(line: str, signs: str = ":=") -> tuple[str, str]:
    """Split "key: value" at the first of some signs; blank texts for another line."""
    ends = [at for at in map(line.find, signs) if at >= 0]
    end = min(ends, default=0)
    key = line[:end].strip()
    letters = [sign for sign in key if sign not in _SIGNS_IN_KEY]
    is_key = key[:1].isalpha() and all(map(str.isalnum, letters))
    if not is_key or len(key) > _LONGEST_KEY:
        return "", ""
    return key, line[end + 1 :].lstrip()


_SHORT_LINE = 30
"""Characters of a line that may be nothing but "Station 2"."""


def _find_delimiter(lines: list[str], body: list[int]) -> str:
    """Return the delimiter that gives most lines the same number of cells.

    Cells that are separated by blanks get tabs.
    """
    # A comma between digits separates cells only if no other sign does.
    without_decimals = _shares_of_delimiters(lines, body, with_decimals=False)
    shares = _shares_of_delimiters(lines, body)
    best_without = max(without_decimals.values())
    best = max(shares.values())
    blanks = sum(" " in lines[index].strip() for index in body)
    if min(best_without, best) < 1 and 2 * blanks > len(body):
        from gyrodata.readings import aligned

        if aligned.write_tabs(lines, body, best_without, best):
            return "\t"
    if best_without > 0.6:
        shares = without_decimals
        best = best_without
    good = [sign for sign, share in shares.items() if share and share >= best - 0.3]
    return good[0] if good else "\t"


def _shares_of_delimiters(
    lines: list[str], body: list[int], with_decimals: bool = True
) -> dict[str, float]:
    """Return the share of the lines in which a sign has its most common count."""
    quoted = r'"(?:[^\S\t]|[,;|])*+[^"\s,;|][^"\t]*"'
    bare = [re.sub(quoted, "", lines[index][: 4 * MAX_CELL]) for index in body[:30]]
    shares = {}
    for sign in "\t;,|":
        numbers = [line.count(sign) for line in bare]
        if sign == "," and not with_decimals:
            numbers = list(map(_commas_between_cells, bare))
        counts = Counter(filter(None, numbers))
        shares[sign] = max(counts.values(), default=0) / len(bare)
    return shares


def _commas_between_cells(line: str) -> int:
    """Count the commas that are not between two digits."""
    cells = line.split(",")
    pairs = itertools.pairwise(cells)
    return sum(not (a[-1:].isdecimal() and b[:1].isdecimal()) for a, b in pairs)


# Marks of order and width that a copy from a web page or a chat brings along, and that
# no editor shows.
_UNSEEN = (
    "\ufeff\u200b\u200c\u200d\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2060 \u00a0"
)
_WITHOUT_WIDTH = dict.fromkeys(range(0x200B, 0x2010))


def _split_lines(grid: Grid, body: list[int], faults: Faults) -> Iterator[Row]:
    """Split the lines of a table into cells."""
    until = -1  # last line of a quoted cell that goes over several lines
    for index in body:
        if index <= until:
            continue
        place = Place(index + 1, 1)
        line = grid.lines[index]
        if '"' in line:
            line = grid.lines[index] = _without_lone_quotes(grid, index)
        if len(line) > MAX_CELL < max(map(len, line.split(grid.delimiter))):
            raise faults.refuse("cell_too_long", place)
        texts, until = _split_line(grid, index, faults)
        while texts and not texts[-1]:
            texts.pop()
        if len(texts) > MAX_COLUMNS:
            raise faults.refuse("too_many_columns", place, count=len(texts))
        if texts:
            yield Row(place.line, texts)


def _without_lone_quotes(grid: Grid, index: int) -> str:
    """Return a line in which a lone quote, as a sign for "the same", quotes nothing."""
    line = grid.lines[index]
    cells = line.split(grid.delimiter)
    lone = [cell for cell in cells if cell.strip(" ") == '"']
    if len(lone) == line.count('"'):
        return line.replace('"', "″")
    return line


def _split_line(grid: Grid, index: int, faults: Faults) -> tuple[list[str], int]:
    """Return the cells of a line, and the index of the last line that they go over."""
    reader = csv.reader(
        _lines_from(grid.lines, index), delimiter=grid.delimiter, skipinitialspace=True
    )
    try:
        texts = [_plain(text) for text in next(reader)]
    except csv.Error:
        place = Place(index + 1, grid.lines[index].rfind('"') + 1)
        raise faults.refuse("quote_never_closed", place) from None
    return texts, index + reader.line_num - 1


def _lines_from(lines: list[str], index: int) -> Iterator[str]:
    for number in range(index, len(lines)):
        yield lines[number] + " "
    raise csv.Error  # a quote is never closed


def _plain(text: str) -> str:
    """Return a cell without signs that no editor shows, and without outer blanks."""
    if text.isascii():
        return text.strip()
    return text.translate(_WITHOUT_WIDTH).strip(_UNSEEN + "\n")


def find_place(lines: list[str], delimiter: str, spot: int) -> Place:
    """Return the place of a cell, by its number."""
    line, at = divmod(spot, MAX_COLUMNS)
    rest = "\n".join(lines[line - 1 : line + _MOST_LINES_OF_A_CELL])
    text = rest
    for _ in range(at):
        end = _end_of_quotes(rest)
        first, found, behind = rest[end:].partition(delimiter)
        if not found or "\n" in first:
            return Place(line, 1)
        rest = behind
    content = rest.lstrip(_UNSEEN)
    is_quoted = content[:1] == '"' and content[1:2] not in ("", '"', "\n", delimiter)
    if content[:1] in ("", "\n", delimiter):
        content = rest
    before = text[: len(text) - len(content) + is_quoted]
    return Place(line + before.count("\n"), len(before) - before.rfind("\n"))


def _end_of_quotes(text: str) -> int:
    """Return where the quotes of a first cell end; 0 if it is not in quotes."""
    start = len(text) - len(text.lstrip(" "))
    if text[start : start + 1] != '"':
        return 0
    end = text.find('"', start + 1)
    while end > 0 and text[end + 1 : end + 2] == '"':
        end = text.find('"', end + 2)
    return end + 1 if end > 0 else len(text)


# --- Keys without the sign #, and limits ---


def _take_key(row: Row, grid: Grid, faults: Faults) -> bool:
    """Move I_zz or a constant to the ``#`` lines; return whether the row states one.

    Examples are "g = 9.81", and "Ball diameter", "101.6", "mm".
    """
    cells = row.filled()
    station = station_in("\t".join(cells))
    stated = [("station", station)] if station else _values_of_log(cells)
    cell = grid.first_cell(row)
    for key, value in stated:
        grid.metadata.append((key, replace(cell, text=value)))
        if key != "I_zz":
            faults.add("line_read_as_key", cell, line=[row.line], key=key, value=value)
    return stated != []


def _values_of_log(cells: list[str]) -> list[tuple[str, str]]:
    """Return the keys and the values that a row states for the whole log."""
    if SPHERE.is_in(cells[0]):
        constants = constants_in(", ".join(cells)) or constants_in(" ".join(cells))
        if constants:
            return constants
    value = _value_of_log(cells)
    return [value] if value else []


def _value_of_log(cells: list[str]) -> tuple[str, str] | None:
    """Return the key and the value of a row with one value.

    An example is "u_time", "0.2", "s".
    """
    name, value = _key_and_value("\t".join(cells), ":=\t")
    # A row of several cells ends with a unit.
    ends_with_number = len(cells) > 2 and is_number(cells[-1])
    if not name or not value or ends_with_number:
        return None
    key = "_".join(name.replace("_", " ").split()).lower()
    if reported_key(name) == "inertia":
        return _answer(_with_u(value))
    return (key, _with_u(value)) if _is_value_of(key, value) else None


def _is_value_of(key: str, value: str) -> bool:
    """Return whether a text is a value, or a word, that a key can have."""
    form = vocabulary.LINES.get(key, {})
    if form and "sample" not in form:
        return value.lower() in form.get("words", YES_OR_NO)
    first = value.lstrip("-+(.")[:1]
    return (form != {} or key in _CONSTANTS) and first.isdecimal()


def _with_u(value: str) -> str:
    """Join the cells of a value; of two numbers, the second one is the uncertainty."""
    cells = value.split("\t")
    if len(cells) > 2 and all(map(is_bare, cells[:2])):
        cells.insert(1, "±")
    return " ".join(cells)


def _answer(text: str) -> tuple[str, str] | None:
    """Return the key and the value of a result; None for a text that is none."""
    if read_reported("inertia", text).fault:
        return None
    return "I_zz", text


_CONSTANTS = frozenset((*roles.CONSTANTS, "ball_radius", *roles.UNCERTAINTIES))


def _check_prose(grid: Grid, faults: Faults) -> None:
    """Refuse a file with more text than a log has.

    The time to understand a sentence grows with its length.
    """
    notes = [text.text for text in grid.comments]
    notes += [f"{key}: {text.text}" for key, text in grid.metadata]
    for row in grid.rows:
        least = MAX_HEADER * any(map(numerals.has_digit, row.texts))
        notes += [text for text in row.texts if len(text) > least]
    size = sum(max(len(note), _LEAST_NOTE) for note in notes)
    if size > MAX_PROSE:
        raise faults.refuse("too_much_text", count=size, most=MAX_PROSE)


def decimal_signs(grid: Grid, by_delimiter: bool = True) -> set[str]:
    """Return the signs in a table's first numbers that cannot separate thousands."""
    signs: set[str] = set()
    for row in grid.rows[:50]:
        signs.update(*map(_decimal_sign, row.texts))
    # If a spreadsheet separates the cells with semicolons, the comma is the decimal
    # sign.
    if not signs and by_delimiter and grid.delimiter == ";":
        return {","}
    return signs


def _decimal_sign(text: str) -> str:
    """Return the sign of a decimal number that cannot separate thousands; else ""."""
    for sign in ".,":
        whole, _, decimals = text.lstrip("-+−").partition(sign)
        are_digits = whole.isdecimal() and decimals.isdecimal()
        if are_digits and (len(decimals) != 3 or whole[0] == "0"):
            return sign
    return ""
