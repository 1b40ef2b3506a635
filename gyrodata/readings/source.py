"""Read a log from a file, bytes, a DataFrame or a workbook.

The result is its text, and rows of cells.
"""

from __future__ import annotations

import csv
import difflib
import gzip
import hashlib
import html
import io
import os
import re
import sys
import zlib
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, TextIO

from msgspec import Struct, field
from msgspec.structs import replace

from gyrodata.base.errors import printable
from gyrodata.quantities import vocabulary
from gyrodata.quantities.units import kinds_of
from gyrodata.readings import roles, workbook
from gyrodata.readings.lablog import Faults, Place, Text, listing
from gyrodata.readings.names import is_word, reported_key
from gyrodata.readings.reported import read_reported
from gyrodata.readings.settings import YES_OR_NO
from gyrodata.readings.words import MAX_HEADER
from gyrodata.readings.workbook import MAX_COLUMNS, MAX_ROWS

if TYPE_CHECKING:
    import pandas as pd

    Source = str | os.PathLike[str] | bytes | BinaryIO | TextIO | pd.DataFrame

MAX_BYTES = 10 * 1000 * 1000
MAX_CELL = 10_000
MAX_NOTE = 2_000
"""Characters of a line that begins with #."""
MAX_NOTES = 10_000
"""Lines that begin with #."""
MAX_TEXT_ROWS = 5_000
"""Rows without a digit; a long log has one header, and a few captions."""
MAX_PROSE = 300_000
"""Characters in lines that begin with #, in rows without a digit and in cells that are
longer than any header."""

_OTHER_FILES = {
    "a picture": rb"\x89PNG|\xff\xd8\xff|GIF8",
    "a PDF": rb"%PDF",
    "a rich-text document": rb"\{\\rtf",
    "an old Office file (.xls or .doc)": rb"\xd0\xcf\x11\xe0",
    "an archive (gyro grade reads the zip of a class)": rb"PK\x03\x04|7z\xbc\xaf|Rar!",
    "a web page": rb"(?i:\s*(?:<!doctype|<html|<\?xml|<svg|<(?:p|div|table)\b))",
    "JSON": rb'(?:\xef\xbb\xbf)?\s*(?:\{\s*"|\[\s*[\[{])',
}
"""Beginnings of files that are not tables."""
_PROGRAM = (
    r"[=:]\s*(?:[\w.]+\()*\[\s*(?:[\n\[(]|(?:[-+]?[0-9./]+[,;\s]\s*){2})|=\s*"
    r"(?:[\w.]*\()*(?:\"\"\"|''')|(?:<-|=)\s*c\("
)
"""The beginning of a list, of rows or of a long string in a program."""
_CODE_PAGES = (
    "cp1252 cp1251 cp1250 cp1254 cp1253 cp1255 cp1256 cp1257 cp1258 cp874 cp932 "
    "gb18030 cp949 big5 euc_jp"
)
_CODE_PAGES += " koi8_r iso8859_2 mac_roman"
"""Encodings of spreadsheets and editors that do not write UTF-8; of several that fit
equally, the first is used."""


def load(source: Source, name: str | None) -> tuple[Grid, Faults]:
    """Read and decode a log, and split it into cells."""
    if type(source).__module__.partition(".")[0] == "pandas" and hasattr(
        source, "columns"
    ):
        text, floats = _frame_text(source)
        return _grid(
            hashlib.sha256(text.encode()).hexdigest(),
            Faults(name or "<table>", text),
            "\t",
            floats,
        )
    shown, data = _read(source, name)
    faults = Faults(shown)
    digest = hashlib.sha256(data).hexdigest()
    if data.startswith(b"\x1f\x8b"):
        try:  # up to the limit: a small file can unpack to anything
            data = gzip.GzipFile(fileobj=io.BytesIO(data)).read(MAX_BYTES + 1)
        except (OSError, EOFError, zlib.error):
            raise faults.refuse("damaged_gz") from None
    if len(data) > MAX_BYTES:
        raise faults.refuse("file_too_large")
    if data.startswith(b"PK\x03\x04") and (
        b"xl/workbook.xml" in data or b"content.xml" in data
    ):
        return _grid(digest, _load_workbook(data, shown), "\t")
    is_page = re.match(_OTHER_FILES["a web page"], data) and re.search(
        rb"(?i)<t[dh]\b|\A\s*<(?:p|div)\b", data
    )
    is_table = is_page or re.match(_OTHER_FILES["JSON"], data)
    if not is_table and (
        kind := next(
            (kind for kind, start in _OTHER_FILES.items() if re.match(start, data)), ""
        )
    ):
        raise faults.refuse("other_kind", kind=kind)
    text, page = decode(data, faults)
    if not text.strip():
        raise faults.refuse("empty")
    if is_page:
        text = _text_of_page(text)
    elif is_table or re.search(_PROGRAM, text):
        from gyrodata.readings import program

        try:
            text = program.table_of(text)
        except program.KeyTwiceError as error:
            raise faults.refuse("json_key_twice", key=str(error)) from None
        except program.NoTableError as error:
            raise faults.refuse("json_no_table", why=str(error)) from None
        except (
            ValueError,
            KeyError,
            TypeError,
            AttributeError,
            StopIteration,
            IndexError,
        ):
            raise faults.refuse("other_kind", kind="JSON") from None
    faults = Faults(shown, text)
    if page:
        faults.add("code_page", page=page)
    return _grid(digest, faults)


def _read(source: Any, name: str | None) -> tuple[str, bytes]:
    """Return the name and the bytes of a source.

    Of an endless one, only a little more than the limit is read.
    """
    if isinstance(source, bytes | bytearray | memoryview):
        return name or "<bytes>", bytes(source)
    if isinstance(source, str) and source == "-":
        return name or "<stdin>", sys.stdin.buffer.read(MAX_BYTES + 1)
    if isinstance(source, str) and ("\n" in source or "\r" in source):
        return name or "<text>", source.encode("utf-8", "surrogatepass")
    if hasattr(source, "read"):
        data = source.read(MAX_BYTES + 1)
        own = getattr(source, "name", None)
        shown = name or (Path(own).name if isinstance(own, str) else "<stream>")
        return shown, data.encode("utf-8", "surrogatepass") if isinstance(
            data, str
        ) else bytes(data)
    if not isinstance(source, str | os.PathLike):
        what = f"{type(source).__name__} ({source!r:.60})"
        raise TypeError(
            f"a log is a path, its text or bytes, an open file or a DataFrame, not {what}"
        )
    path = Path(source)
    shown = name or path.name or str(path)
    shown = shown if shown.isascii() else printable(shown)
    try:
        with path.open("rb") as file:
            return shown, file.read(MAX_BYTES + 1)
    except FileNotFoundError:
        names = sorted(entry.name for entry in path.parent.glob("*"))[:2000]
        close = difflib.get_close_matches(path.name, names, n=3)
        hint = f"did you mean {listing(close)}?" if close else ""
        raise Faults(shown).refuse(
            "file_not_found", path=str(path), hint=hint
        ) from None
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", "") or error
        raise Faults(shown).refuse(
            "cannot_be_opened", path=str(path), why=why
        ) from None


def decode(data: bytes, faults: Faults) -> tuple[str, str]:
    """Decode by byte-order mark, as UTF-8, or in the code page with most known words.

    Return the text and that page.
    """
    page = ""
    try:
        text = data.decode(
            "utf-16" if data.startswith((b"\xff\xfe", b"\xfe\xff")) else "utf-8-sig"
        )
    except UnicodeDecodeError:
        page = max(
            _CODE_PAGES.split(),
            key=lambda page: _known_letters(data[:20_000].decode(page, "replace")),
        )
        text = data.decode(page, "replace")
    if "\x00" in text:
        raise faults.refuse("not_text", at=data.index(0) + 1)
    return text, page


def _known_letters(text: str) -> int:
    """Count the letters beyond ASCII in words of the vocabulary.

    A single letter of an alphabet is not a word.
    """
    words = {word for word in re.findall(r"[^\W\d_]+", text) if not word.isascii()}
    words = {
        word
        for word in words
        if not (re.search("[A-Za-z]", word) and re.search("[\u0370-\u04ff]", word))
    }
    known = [
        word for word in words if (len(word) > 1 or word > "\u2e80") and is_word(word)
    ]
    return sum(map(len, known)) - 5 * text[:-1].count("\ufffd")


# --- tables that are not text: web pages, DataFrames, workbooks ---


def _text_of_page(page: str) -> str:
    """Return the text that a web page shows, with tabs between the cells of a table."""
    text = re.sub(
        r"(?is)<(script|style|head)\b.*?(?:</\1>|\Z)|<!--.*?(?:-->|\Z)|\s+", " ", page
    )
    rows = re.split(r"(?i)(?=<tr\b)", text)
    left = MAX_ROWS
    for at, row in enumerate(rows):
        for span in re.findall(
            r"(?i)<tr[^<>]*>\s*<t[dh]\b[^<>]*rowspan=\W?([0-9]{1,3})", row
        ):
            end = min(at + int(span), len(rows), at + 1 + left)
            left -= max(end - at - 1, 0)
            for below in range(at + 1, end):
                rows[below] = re.sub(
                    r"(?i)(<tr\b[^<>]*>)", r"\1<td></td>", rows[below]
                )  # merged cells at the left
    text = "".join(rows)
    text = re.sub(r"(?i)<(?:tr|table|caption|p|div|li|h[1-6]|br)\b[^<>]*>", "\n", text)
    text = html.unescape(
        re.sub(r"<[^<>]*>", "", re.sub(r"(?i)<t[dh]\b[^<>]*>", "\t", text))
    )
    return (
        "\n".join(
            line.strip(" ").removeprefix("\t")
            for line in text.split("\n")
            if line.strip()
        )
        + "\n"
    )


def _frame_text(frame: Any) -> tuple[str, frozenset[int]]:
    """Write a DataFrame as tab-separated text; return the numbers of its columns of floats too."""
    units = frame.attrs.get("units", {})
    keys = {
        key: value
        for key, value in frame.attrs.items()
        if not isinstance(value, Mapping | list | tuple)
    }
    lines = [
        f"# {key}: {value_text(value)}".replace("\n", " ")
        for key, value in keys.items()
    ]
    if any(
        name is not None for name in frame.index.names
    ):  # as `to_csv` writes them too
        frame = frame.reset_index(allow_duplicates=True)
    headers, floats = [], set()
    for at, column in enumerate(frame.columns):
        name, unit = (
            column if isinstance(column, tuple) and len(column) == 2 else (column, "")
        )
        unit = unit or (units.get(name) if isinstance(units, Mapping) else "")
        headers.append(f"{name} [{unit}]" if unit else name)
        numbers = (
            getattr(value, "magnitude", value) for value in frame.iloc[:, at]
        )  # of pint
        if any(
            isinstance(number, float) and number == number for number in numbers
        ):  # a blank cell is NaN
            floats.add(at)
    rows = [headers, *frame.itertuples(index=False, name=None)]
    return "\n".join([*lines, *_table_lines(rows)]) + "\n", frozenset(floats)


def _table_lines(rows: Iterable[Iterable[Any]]) -> Iterator[str]:
    """Write rows of Python values as tab-separated lines."""
    for row in rows:
        texts = [re.sub(r"[\t\r\n]", " ", value_text(value)) for value in row]
        yield "\t".join(
            '"' + text.replace('"', '""') + '"' if text[:1] == '"' else text
            for text in texts
        ).rstrip("\t")


def value_text(value: Any) -> str:
    """Return a cell of a spreadsheet or DataFrame, or a setting, as a student would type it."""
    kind = type(value).__name__
    if hasattr(value, "magnitude") and hasattr(value, "units"):  # of pint
        number = value.magnitude
        return (
            f"{number if isinstance(number, float) else value_text(number)} "
            f"{value.units:~}"
        ).rstrip()
    if hasattr(value, "nominal_value") and hasattr(
        value, "std_dev"
    ):  # of uncertainties
        return f"{value_text(value.nominal_value)} ± {value_text(value.std_dev)}"
    if (
        value is None or kind in ("NAType", "NaTType") or value != value
    ):  # NaN is not itself
        return ""
    if kind == "Timedelta":  # of pandas
        return f"{value.total_seconds()!r} s"
    whole = kind.startswith("float") and float(value).is_integer() and abs(value) < 1e15
    return str(int(value)) if whole else str(value)


def _load_workbook(data: bytes, shown: str) -> Faults:
    """Read a workbook as text, with its faults so far.

    Raise InputError if a formula has no value.
    """
    sheets = _sheets_of(data, Faults(shown))
    faults = Faults(shown, *_text_of_sheets(sheets, Faults(shown)))
    hidden = [part for sheet in sheets for part in workbook.hidden_parts(sheet)]
    if hidden:
        faults.add("hidden_cells", where="; ".join(hidden))
    lacking = [
        (sheet, row, column) for sheet in sheets for row, column in sheet.without_value
    ]
    if not lacking:
        return faults
    sheet, row, column = lacking[0]
    others = [workbook.cell_name(*cell, within=sheet) for cell in lacking[1:]]
    above, _ = faults.sheets[sheets.index(sheet)]
    before = faults.lines[above + row - 1].split("\t")[: column - 1]
    start = sum(len(cell) + 1 for cell in before)
    more = (
        ": the stored 0 is not its result"
        if sheet.without_value[row, column].value
        else ""
    )
    more += f" (also {listing(others)})" if others else ""
    raise faults.refuse(
        "formula_without_value", Place(above + row, start + 1), more=more
    )


def workbook_text(
    data: bytes, faults: Faults
) -> tuple[str, tuple[tuple[int, str], ...]]:
    """Write the filled sheets of a workbook as tab-separated text.

    Return the line above each and its name too.
    """
    return _text_of_sheets(_sheets_of(data, faults), faults)


def sheet_rows(data: bytes) -> dict[str, list[list[Any]]]:
    """Return the rows of each sheet of a workbook, with cells as they were typed.

    ValueError if it cannot be read.
    """
    return {sheet.title: sheet.rows for sheet in workbook.read_sheets(data)}


def _sheets_of(data: bytes, faults: Faults) -> list[workbook.Sheet]:
    """Return the filled sheets of a workbook, with the formula in each cell that has no value."""
    try:
        sheets = workbook.read_sheets(data)
    except workbook.TooLargeError as error:
        raise faults.refuse("workbook_too_large", why=str(error)) from None
    except ValueError as error:
        raise faults.refuse("workbook", why=str(error)) from None
    for sheet in sheets:
        workbook.write_formulas(sheet)
    return [
        sheet
        for sheet in sheets
        if any(cell not in (None, "") for row in sheet.rows for cell in row)
    ]


def _text_of_sheets(
    sheets: list[workbook.Sheet], faults: Faults
) -> tuple[str, tuple[tuple[int, str], ...]]:
    """Write sheets as tab-separated text; return the line above each and its name too."""
    if not sheets:
        raise faults.refuse("workbook_empty")
    lines: list[str] = []
    places = []
    for sheet in sheets:
        # The name of a sheet is a title of what is on it.
        lines += [f"sheet {sheet.title}"] if len(sheets) > 1 else []
        places.append((len(lines), workbook.quoted(sheet.title)))
        lines += "\n".join(_table_lines(sheet.rows)).rstrip("\n").split("\n")
    return "\n".join(lines) + "\n", tuple(places)


# --- from text to rows of cells: delimiter, quotes, # lines and limits ---


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
        return (
            self.origin[at] if at < len(self.origin) else self.line * MAX_COLUMNS + at
        )


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
    dittos: set[int] = field(default_factory=set)
    """Numbers of the cells with a ditto mark: they are blank in the rows, and yet say
    that the value above is valid."""

    def cell(self, row: Row, at: int) -> Text:
        """Return one cell with its place, which only a fault needs."""
        return Text(row.texts[at], self.place_of(row.spot(at)))

    def place_of(self, spot: int) -> Place:
        """Return the place of a cell, by its number."""
        return find_place(self.lines, self.delimiter, spot)


# Marks of order and width that a copy from a web page or a chat brings along, and that
# no editor shows.
_UNSEEN = (
    "\ufeff\u200b\u200c\u200d\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2060 \u00a0"
)
_WITHOUT_WIDTH = dict.fromkeys(range(0x200B, 0x2010))
_EMPHASIS = re.compile(r"([*_`]{1,3})(?=\S)(.+?)\1|[“„«](.+)[”“»]")
"""A cell of Markdown in bold or italic type, or as code; or a cell in the quotes of a
word processor."""
_FOOTNOTES = ("*", "†", "‡")
_FOOTNOTE = re.compile(r"(?<=[0-9]) ?[*†‡]+$")
_DECIMAL = re.compile(r"[-+−]?[0-9]+([.,])([0-9]+)")
_ERROR_VALUE = r"(?:N/A|DIV/0!|VALUE!|REF!|NAME\?|NUM!|NULL!)"
"""What a spreadsheet program writes behind # in a cell whose formula failed."""
_NO_COMMENT = r"\s*[;,\t|]|\s?of\b|\s{2,}\S.*?\S\s{2,}"
"""What follows the sign # if it is a header, and not the beginning of a comment."""
_COMMENT = rf'[ "\t]*#(?!{_ERROR_VALUE}|{_NO_COMMENT})'
_DITTO = frozenset(("''", '"', "″", "“", "”", "〃", "ditto", "dito", "dtto", "idem"))
"""Marks for "the same as above"; a blank cell means the same."""
_KEY = re.compile(r"\s*([^\W\d][\w .()/\-]{0,39}?)\s*[:=]\s*(.*)", re.DOTALL)
_MOST_LINES_OF_A_CELL = 100


def _grid(
    sha256: str,
    faults: Faults,
    delimiter: str = "",
    floats: frozenset[int] = frozenset(),
) -> tuple[Grid, Faults]:
    """Split a log into cells; `delimiter` is given if this module wrote the text."""
    # The digits of all scripts are read.
    text = re.sub(
        r"(?![0-9])\d", lambda digit: str(int(digit[0])), "\n".join(faults.lines)
    ).replace("٫", ".")
    # The point of wide digits, and the marks of a quoted mail.
    text = re.sub(r"(?<=[0-9])．(?=[0-9])", ".", text)
    text = re.sub(r"(?m)^>[> ]*(?=\S)", lambda sign: sign[0].replace(">", " "), text)
    # Students of LaTeX and MATLAB write % in front of a remark.
    lines = [
        re.sub(r"^([\s\"]*)%(?=\s+[^\W\d_]{2})", r"\1#", one) if "%" in one else one
        for one in text.split("\n")
    ]
    grid = Grid(lines, delimiter, [], [], [], floats, sha256)
    body: list[int] = []  # indices of the table's lines
    for index, line in enumerate(lines):
        is_note = line[:100].lstrip(' "\t').startswith("#")
        if is_note and len(line) > MAX_NOTE:
            raise faults.refuse("note_too_long", Place(index + 1, 1), most=MAX_NOTE)
        if re.match(_COMMENT, line):
            # A spreadsheet may have put the line in quotes or added delimiters.
            start = line.index("#") + 1
            content = line[start:].rstrip(" \t,;")
            content = (
                content.rstrip('"').replace('""', '"')
                if line.lstrip().startswith('"')
                else content
            )
            if match := _KEY.fullmatch(content):
                key = re.sub(r"[\s\-]+", "_", match[1].strip())
                grid.metadata.append(
                    (
                        key,
                        Text(
                            match[2].strip(),
                            Place(index + 1, start + match.start(2) + 1),
                        ),
                    )
                )
            else:
                grid.comments.append(Text(content.strip(), Place(index + 1, start)))
        elif re.search(
            r"[^\s|+:=\-]", line
        ):  # not a line of a Markdown table that only draws a line
            body.append(index)
    if sum("&" in lines[index] and "\\\\" in lines[index] for index in body) > 2:
        body, delimiter = _without_latex(lines, body), "&"
        grid = replace(grid, delimiter=delimiter)
    if len(body) - 1 > MAX_ROWS:  # without the header
        raise faults.refuse("too_many_rows", count=len(body) - 1)
    slashes, often = (
        Counter(lines[index].count(" / ") for index in body).most_common(1)[0]
        if body
        else (0, 0)
    )
    if slashes > 2 and 2 * often > len(body):
        for index in body:
            lines[index] = lines[index].replace(" / ", " \t ")
    if body and not delimiter:
        grid = replace(grid, delimiter=_find_delimiter(lines, body))
    rows = _split_rows(grid, body, faults)
    grid.rows.extend(
        row for row in rows if row.texts[0] == "#" or not _read_key(row, grid, faults)
    )
    _check_prose(grid, faults)
    return grid, faults


def _check_prose(grid: Grid, faults: Faults) -> None:
    """Refuse a file with more text than a log has.

    The time to understand a sentence grows with its length.
    """
    notes = [text.text for text in grid.comments] + [
        f"{key}: {text.text}" for key, text in grid.metadata
    ]
    if len(notes) > MAX_NOTES:
        raise faults.refuse("too_many_notes", count=len(notes), most=MAX_NOTES)
    rows = [
        row
        for row in grid.rows
        if not any(re.search("[0-9]", text) for text in row.texts)
    ]
    if len(rows) > MAX_TEXT_ROWS:
        raise faults.refuse(
            "too_many_text_rows",
            grid.cell(rows[-1], 0),
            count=len(rows),
            most=MAX_TEXT_ROWS,
        )
    cells = [text for row in grid.rows for text in row.texts if len(text) > MAX_HEADER]
    size = sum(
        map(len, (*notes, *cells, *(text for row in rows for text in row.texts)))
    )
    if size > MAX_PROSE:
        raise faults.refuse("too_much_text", count=size, most=MAX_PROSE)


_LATEX = re.compile(r"\\\\(?s:.*)|\\([a-zA-Z]+)|\\[,;: %]|[${}~]")
"""The end of a row of LaTeX, its commands, and signs that it does not print; units keep
their names."""
_WRITTEN = {
    "\\pm": "±",
    "\\per": "/",
    "\\centi": "centi",
    "\\milli": "milli",
    "\\kilo": "kilo",
    "\\degree": "deg",
}
_WRITTEN |= {
    "\\omega": "ω",
    "\\Omega": "Ω",
    "\\tau": "τ",
    "\\psi": "ψ",
    "\\varphi": "φ",
    "\\phi": "φ",
}


def _without_latex(lines: list[str], body: list[int]) -> list[int]:
    """Keep only the text of a table in LaTeX, at its place if possible.

    Return the indices of its rows and captions.
    """
    for index in body:
        line = lines[index].replace("{,}", ",")
        for way, usual in vocabulary.WAYS["latex"]:
            line = re.sub(way, usual, line)
        lines[index] = _LATEX.sub(
            lambda sign: _WRITTEN.get(
                sign[0], sign[1] if kinds_of(sign[1] or "") else ""
            ),
            line,
        )
    return [
        index
        for index in body
        if "&" in lines[index]
        or re.search(r"(?:(?<![^\W\d_])[^\W\d_]{2,}+\W++){3}", lines[index])
    ]


def _read_key(row: Row, grid: Grid, faults: Faults) -> bool:
    """Move I_zz and constants to the ``#`` lines.

    Examples are "g = 9.81", and "Ball diameter", "101.6", "mm".

    The function returns whether the row contained nothing else.
    """
    for at, text in (
        (at, text) for at, text in enumerate(row.texts) if text[:1].isalpha()
    ):
        name, _, value = text.replace("=", ":").partition(":")
        value = (value or " ".join(row.texts[at + 1 :])).strip()
        is_inertia = reported_key(name.strip()) == "inertia"
        if is_inertia and read_reported("inertia", value).fault is None:
            grid.metadata.append(("I_zz", replace(grid.cell(row, at), text=value)))
            del row.texts[at:]
            while row.texts and not row.texts[-1]:
                row.texts.pop()
            return not row.texts
    filled = [text for text in row.texts if text]
    stated = _stated(filled)
    if stated is None:
        return False
    key, value = stated
    cell = grid.cell(row, row.texts.index(filled[0]))
    grid.metadata.append((key, replace(cell, text=value)))
    faults.add("line_read_as_key", cell, line=[row.line], key=key, value=value)
    return True


def _stated(cells: list[str]) -> tuple[str, str] | None:
    """Return the key and the value that a row states for the whole log.

    An example is "u_time", "0.2", "s".
    """
    if len(cells) > 3:
        return None
    match = re.fullmatch(
        r"([^\W\d]\w*+(?: ++\w++)*+)\s*[:=\t]\s*(.+)", "\t".join(cells)
    )
    if match is None:
        return None
    key, value = re.sub(r"[\s_]+", "_", match[1]).lower(), match[2]
    form = vocabulary.LINES.get(key, {})
    if form and "sample" not in form:
        return (key, value) if value.lower() in form.get("words", YES_OR_NO) else None
    if not form and key not in (*roles.CONSTANTS, "ball_radius", *roles.UNCERTAINTIES):
        return None
    is_column = key in roles.UNCERTAINTIES and re.match(r"[-+.\d]", "".join(cells[2:]))
    if is_column or not re.match(r"[-+(]?[.\d]", value):
        return None
    value = re.split(r"\.\s|\s\([^\d()]*\)$", value.replace("\t", " "))[0]
    # "9,81 m/s² verwendet."
    value = re.sub(
        r"(?<!\s)\s+([^\W\d]{4,})\.?$",
        lambda word: word[0] if kinds_of(word[1]) else "",
        value,
    )
    return key, value


def decimal_signs(grid: Grid, by_delimiter: bool = True) -> set[str]:
    """Return the decimal signs of a table's first numbers that cannot separate thousands."""
    numbers = (_DECIMAL.fullmatch(text) for row in grid.rows[:50] for text in row.texts)
    signs = {
        match[1]
        for match in numbers
        if match and (len(match[2]) != 3 or match[0][0] == "0")
    }
    # If a spreadsheet separates the cells with semicolons, the comma is the decimal
    # sign.
    return signs or ({","} if by_delimiter and grid.delimiter == ";" else set())


def _find_delimiter(lines: list[str], body: list[int]) -> str:
    """Return the delimiter that gives most lines the same number of cells.

    Aligned blanks become a tab.
    """
    bare = [
        re.sub(r'"(?:[^\S\t]|[,;|])*+[^"\s,;|][^"\t]*"', "", lines[i][: 4 * MAX_CELL])
        for i in body[:30]
    ]
    # A comma between digits separates cells only if no other sign does.
    found: list[dict[str, float]] = []
    for some in ([re.sub(r"(?<=[0-9]),(?=[0-9])", "", line) for line in bare], bare):
        signs = (
            (sign, Counter(filter(None, (line.count(sign) for line in some))))
            for sign in "\t;,|"
        )
        # The share of the lines in which a sign has its most common count.
        found.append(
            {sign: max(count.values(), default=0) / len(some) for sign, count in signs}
        )
    without_decimals, shares = found
    for gap, least, others in ((r"\s{2,}", 2, without_decimals), (r"\s+", 4, shares)):
        rival = max(others.values())
        counts = Counter(
            len(re.split(gap, lines[i].strip())) for i in body if rival < 1
        )
        usual, often = counts.most_common(1)[0] if counts else (0, 0)
        if (
            MAX_COLUMNS >= usual >= least
            and often > rival * len(body)
            and (least < 4 or (rival < 0.5 and often > 0.4 * len(body)))
        ):
            cells = {
                i: list(
                    re.finditer(r"\S+" if least == 4 else r"\S+(?: \S+)*", lines[i])
                )
                for i in body
            }
            counts = Counter(map(len, cells.values()))
            usual = max(
                (count for count, often in counts.items() if often > 1),
                default=max(counts),
            )
            columns = list(
                zip(*(row for row in cells.values() if len(row) == usual), strict=True)
            )
            spans = [
                (min(one.start() for one in many), max(one.end() for one in many))
                for many in columns
            ]
            for i, row in cells.items():
                text, at, end = "", 0, 0
                for number, cell in enumerate(row):
                    # Of a row with blank cells, each cell belongs to the column above
                    # or below it.
                    far = [
                        max(start - cell.end(), cell.start() - stop)
                        for start, stop in spans
                    ]
                    first, last = at + (number > 0), usual - len(row) + number
                    to = (
                        min(range(first, last + 1), key=far.__getitem__)
                        if last > first
                        else first
                    )
                    text += ("\t" * (to - at)).ljust(cell.start() - end) + cell[0]
                    at, end = to, cell.end()
                lines[i] = text
            return "\t"
    shares = without_decimals if max(without_decimals.values()) > 0.6 else shares
    best = max(shares.values())
    return next(
        (
            delimiter
            for delimiter, share in shares.items()
            if share and share >= best - 0.3
        ),
        "\t",
    )


def _split_rows(grid: Grid, body: list[int], faults: Faults) -> Iterator[Row]:
    """Split the lines of a table into cells."""
    until = -1  # last line of a quoted cell that goes over several lines
    mark = re.escape(grid.delimiter)
    lone = re.compile(rf'((?:^|{mark})[^\S\t]*)"(?=[^\S\t]*(?:{mark}|$))')
    for index in body:
        if index <= until:
            continue
        # Ditto marks: no text in quotes has its quotes alone in the cells of a whole
        # row.
        if (
            '"' in grid.lines[index]
            and (bare := lone.sub(r"\1〃", grid.lines[index]))
            and '"' not in bare
        ):
            grid.lines[index] = bare
        reader = csv.reader(
            _lines_from(grid.lines, index),
            delimiter=grid.delimiter,
            skipinitialspace=True,
        )
        if (
            len(grid.lines[index]) > MAX_CELL
            and max(map(len, grid.lines[index].split(grid.delimiter))) > MAX_CELL
        ):
            raise faults.refuse("cell_too_long", Place(index + 1, 1))
        try:
            texts = [
                text.translate(_WITHOUT_WIDTH).strip(_UNSEEN + "\n")
                for text in next(reader)
            ]
            texts = [
                match[2] or match[3] if (match := _EMPHASIS.fullmatch(text)) else text
                for text in texts
            ]
            texts = [
                _FOOTNOTE.sub("", text) if text[-1:] in _FOOTNOTES else text
                for text in texts
            ]
        except csv.Error:
            raise faults.refuse(
                "quote_never_closed", Place(index + 1, grid.lines[index].rfind('"') + 1)
            ) from None
        until = index + reader.line_num - 1
        first = (index + 1) * MAX_COLUMNS
        grid.dittos.update(
            first + at for at, text in enumerate(texts) if text in _DITTO
        )
        texts = ["" if text in _DITTO else text for text in texts]
        if (
            "~~" in grid.lines[index]
            and sum(text.startswith("~~") for text in texts) > 1
        ):
            texts = ["#", *texts[1:]]  # a row that is struck out
        while texts and not texts[-1]:
            texts.pop()
        if len(texts) > MAX_COLUMNS:
            raise faults.refuse(
                "too_many_columns", Place(index + 1, 1), count=len(texts)
            )
        if texts:
            yield Row(index + 1, texts)


def _lines_from(lines: list[str], index: int) -> Iterator[str]:
    for number in range(index, len(lines)):
        yield lines[number] + " "
    raise csv.Error  # a quote is never closed


def find_place(lines: list[str], delimiter: str, spot: int) -> Place:
    """Return the place of a cell, by its number."""
    line, at = divmod(spot, MAX_COLUMNS)
    text = "\n".join(lines[line - 1 : line + _MOST_LINES_OF_A_CELL])
    mark = re.escape(delimiter)
    cell = re.compile(rf'(?> *(?:"(?:[^"]|"")*(?:"|\Z))?[^{mark}\n]*){mark}')
    end = 0
    for _ in range(at):
        found = cell.match(text, end)
        if not found:
            return Place(line, 1)
        end = found.end()
    first = re.compile(rf'[{_UNSEEN}]*"?(?=[^{mark}{_UNSEEN}"\n])').match(text, end)
    before = text[: first.end() if first else end]
    return Place(line + before.count("\n"), len(before) - before.rfind("\n"))
