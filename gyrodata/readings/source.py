"""From whatever holds a log (file, standard input, bytes, DataFrame, workbook) to its text, and to rows of cells."""

from __future__ import annotations

import codecs
import csv
import difflib
import gzip
import hashlib
import io
import os
import re
import sys
import zipfile
import zlib
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from datetime import time, timedelta
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, TextIO

from msgspec import Struct
from msgspec.structs import replace

from gyrodata.diagnostics import (
    CELL_TOO_LONG,
    CODE_PAGE_GUESSED,
    COMPRESSED_FILE_DAMAGED,
    FILE_CANNOT_BE_OPENED,
    FILE_NOT_FOUND,
    FILE_TOO_LARGE,
    LINE_READ_AS_KEY,
    LOG_IS_EMPTY,
    NO_DELIMITER,
    NOT_TEXT,
    OTHER_KIND_OF_FILE,
    QUOTE_NEVER_CLOSED,
    ROW_TAKEN_OUT,
    TOO_MANY_COLUMNS,
    TOO_MANY_ROWS,
    WORKBOOK_CANNOT_BE_READ,
)
from gyrodata.errors import printable
from gyrodata.readings import other_tables
from gyrodata.readings.cells import find_in_row
from gyrodata.readings.lablog import Faults, Place, Text, listing, span
from gyrodata.readings.roles import CONSTANTS, is_word

if TYPE_CHECKING:
    import pandas as pd

    Source = str | os.PathLike[str] | bytes | BinaryIO | TextIO | pd.DataFrame

MAX_BYTES = 10 * 1000 * 1000
MAX_ROWS = 100_000
MAX_COLUMNS = 200
MAX_CELL = 10_000
_MAX_UNPACKED = 100 * 1000 * 1000

_SAVE_AS = "save the table as CSV (in a spreadsheet: File, Save as, CSV UTF-8) and give that file"
_SMALL = "a lab log has a few kilobytes; is this the one?"
_JSON = (
    "write a table: a first row mass [g],position [cm],spin [rpm],time [s],turns, and one row for each run; in Python, "
    "for a list of runs: pandas.read_json(FILE).to_csv('log.csv', index=False)"
)
_OTHER_FILES = {
    "a picture": rb"\x89PNG|\xff\xd8\xff|GIF8|(?:BM|RIFF)(?=.{0,60}\x00)|II\*\x00|MM\x00\*",
    "a PDF": rb"%PDF|%!PS",
    "a rich-text document": rb"\{\\rtf",
    "an old Office file (.xls or .doc)": rb"\xd0\xcf\x11\xe0",
    "an archive": rb"7z\xbc\xaf|Rar!|BZh|\xfd7zXZ",
    "a database": rb"SQLite format",
    "a web page": rb"(?i:\s*(?:<!doctype|<html|<\?xml|<svg))",
    "JSON": rb'(?:\xef\xbb\xbf)?\s*(?:\{\s*"|\[\s*[\[{])',
}
"""How files begin that are no tables."""


class Document(Struct, frozen=True):
    """A log as text, before anything in it is understood."""

    name: str
    sha256: str
    text: str
    faults: Faults
    delimiter: str | None = None
    """Known beforehand where this module wrote the text itself."""
    floats: frozenset[int] = frozenset()
    """Columns of a DataFrame whose numbers are floats: these do not contain the digits that were read."""


def load(source: Source, name: str | None) -> Document:
    """Read and decode a log."""
    if is_frame(source):
        shown = name or "<table>"
        text, floats = _frame_text(source)
        return Document(shown, hashlib.sha256(text.encode()).hexdigest(), text, Faults(shown, text), "\t", floats)
    shown, data = _read(source, name)
    faults = Faults(shown)
    digest = hashlib.sha256(data).hexdigest()
    if len(data) > MAX_BYTES:
        raise faults.refuse(FILE_TOO_LARGE, "the file is larger than 10 MB", _SMALL)
    if data.startswith(b"\x1f\x8b"):
        data = _decompress(data, faults)
    if data.startswith(b"PK\x03\x04"):
        text = _workbook_text(data, faults)
        return Document(shown, digest, text, Faults(shown, text), "\t")
    for kind, start in _OTHER_FILES.items():
        if re.match(start, data, re.DOTALL):
            if kind == "a web page" and any(rows := list(other_tables.web_page_tables(decode(data, faults)[0]))):
                text = "\n".join(_table_text(rows)) + "\n"
                return Document(shown, digest, text, Faults(shown, text), "\t")
            hint = _JSON if kind == "JSON" else _SAVE_AS
            raise faults.refuse(OTHER_KIND_OF_FILE, f"this is {kind}, not a table", hint)
    text, encoding = decode(data, faults)
    if not text.strip():
        raise faults.refuse(LOG_IS_EMPTY, "the log is empty", "write a blank log to fill in with: gyro template")
    faults = Faults(shown, text)
    if encoding:
        message = f"the file is not UTF-8; it was read as {encoding}"
        faults.add(CODE_PAGE_GUESSED, message, "save it as UTF-8 to be sure")
    return Document(shown, digest, text, faults)


def _read(source: Any, name: str | None) -> tuple[str, bytes]:
    """Get at most a little more than the limit, so that nothing endless is read to its end."""
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
        return shown, data.encode("utf-8", "surrogatepass") if isinstance(data, str) else bytes(data)
    path = Path(source)
    shown = printable(name or path.name or str(path))
    faults = Faults(shown)
    try:
        with path.open("rb") as file:
            return shown, file.read(MAX_BYTES + 1)
    except FileNotFoundError:
        raise faults.refuse(FILE_NOT_FOUND, f"there is no file {str(path)!r}", _neighbours(path)) from None
    except IsADirectoryError:
        message = f"{str(path)!r} is a folder, not a log"
        raise faults.refuse(FILE_CANNOT_BE_OPENED, message, "give the file in it") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", "") or str(error)
        raise faults.refuse(FILE_CANNOT_BE_OPENED, f"{str(path)!r} cannot be opened: {reason}") from None


def _neighbours(path: Path) -> str:
    """Propose files of the same folder with a similar name."""
    try:
        names = sorted(entry.name for entry in path.parent.iterdir() if entry.is_file())
    except (OSError, ValueError):
        return f"there is no folder {str(path.parent)!r} either"
    close = difflib.get_close_matches(path.name, names[:2000], n=3, cutoff=0.6)
    return f"did you mean {listing(close)}?" if close else ""


def _decompress(data: bytes, faults: Faults) -> bytes:
    """Unpack .gz up to the limit: a small file can unpack to anything."""
    try:
        text = gzip.GzipFile(fileobj=io.BytesIO(data)).read(MAX_BYTES + 1)
    except (OSError, EOFError, zlib.error) as error:
        message = f"the .gz file {'ends too early' if isinstance(error, EOFError) else 'is damaged'}"
        raise faults.refuse(COMPRESSED_FILE_DAMAGED, message, "make it again, or give the CSV itself") from None
    if len(text) > MAX_BYTES:
        raise faults.refuse(FILE_TOO_LARGE, "the file unpacks to more than 10 MB", _SMALL)
    return text


_MARKS = {
    codecs.BOM_UTF8: "utf-8-sig",
    codecs.BOM_UTF32_LE: "utf-32",
    codecs.BOM_UTF32_BE: "utf-32",
    codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16",
}
"""Byte-order marks; one of UTF-32 begins like one of UTF-16."""
_CODE_PAGES = ("cp1252", "cp1251", "cp1250", "cp932", "gb18030", "cp949")
"""What Excel writes as CSV in the West, with Cyrillic letters, in the East of Europe, in Japan, China and Korea."""


def decode(data: bytes, faults: Faults) -> tuple[str, str]:
    """Decode by byte-order mark, as UTF-8, or in the code page that fits best, whose name is given too."""
    encoding = next((encoding for mark, encoding in _MARKS.items() if data.startswith(mark)), "")
    guessed = ""
    try:
        text = data.decode(encoding, "replace") if encoding else data.decode("utf-8")
    except UnicodeDecodeError:
        guessed = max(_CODE_PAGES, key=lambda page: _fit(data[:20_000].decode(page, "replace")))
        text = data.decode(guessed, "replace")
    if "\x00" in text:
        hint = "it looks like UTF-16 without its mark; " * (data[:40].count(0) > 8) + _SAVE_AS
        raise faults.refuse(NOT_TEXT, f"this is not text: byte {data.index(0) + 1} is a NUL", hint)
    return text, guessed


def _fit(text: str) -> float:
    """Tell how much a text looks like what students write: words that are known, and letters of one script in each."""
    score = -5.0 * text[:-1].count("\ufffd")
    for word in set(re.findall(r"[^\W\d_]+", text)):
        if not word.isascii():
            score += 3.0 * len(word) * is_word(word)
            score -= (len({ord(c) >= 0x370 for c in word}) > 1) + (word[1:] != word[1:].lower())
    return score - sum(ord(c) > 127 and not c.isalpha() and c not in "°±·²³µ×–—−№\xa0½¼¾º" for c in text)


def is_frame(source: object) -> bool:
    """Know a DataFrame without importing pandas."""
    return type(source).__module__.partition(".")[0] == "pandas" and hasattr(source, "columns")


def _frame_text(frame: Any) -> tuple[str, frozenset[int]]:
    """Write a DataFrame as the tab-separated text that it would have been read from; give its columns of floats."""
    units = frame.attrs.get("units", {})
    plain = {key: value for key, value in frame.attrs.items() if not isinstance(value, Mapping | list | tuple)}
    lines = [f"# {key}: {value_text(value)}" for key, value in plain.items()]
    if any(name is not None for name in frame.index.names):  # as `to_csv` has them too
        frame = frame.reset_index(allow_duplicates=True)
    rows = [tuple(_header(name, units) for name in frame.columns), *frame.itertuples(index=False, name=None)]
    floats = frozenset(
        at
        for at, dtype in enumerate(frame.dtypes)
        if dtype.kind == "f" or (dtype.kind == "O" and any(map(_is_float, frame.iloc[:, at])))
    )
    return "\n".join([*(line.replace("\n", " ") for line in lines), *_table_text(rows)]) + "\n", floats


def _is_float(value: Any) -> bool:
    number = getattr(value, "magnitude", value)  # of pint
    return isinstance(number, float) and number == number  # a blank cell is NaN


def _header(name: Any, units: Any) -> str:
    """Write the name of a column, (name, unit) or one whose unit stands in ``attrs["units"]``, as a header."""
    name, unit = name if isinstance(name, tuple) and len(name) == 2 else (name, "")
    if not unit and isinstance(units, Mapping):
        unit = units.get(name, "")
    return f"{name} [{unit}]" if unit else str(name)


def _table_text(rows: Iterable[Iterable[Any]]) -> Iterator[str]:
    """Write rows of Python values as tab-separated lines."""
    for row in rows:
        texts = ["" if value is None else re.sub(r"[\t\r\n]", " ", value_text(value)) for value in row]
        yield "\t".join('"' + text.replace('"', '""') + '"' if text[:1] == '"' else text for text in texts).rstrip("\t")


def value_text(value: Any) -> str:
    """Write a cell of a spreadsheet or DataFrame, or a setting, as a student would have typed it."""
    if hasattr(value, "magnitude") and hasattr(value, "units"):  # of pint
        number = value.magnitude
        return f"{number if isinstance(number, float) else value_text(number)} {value.units:~}".rstrip()
    if hasattr(value, "nominal_value") and hasattr(value, "std_dev"):  # of uncertainties
        return f"{value_text(value.nominal_value)} ± {value_text(value.std_dev)}"
    kind = type(value).__name__
    if value is None or kind in ("NAType", "NaTType") or value != value:  # NaN is not itself
        return ""
    if kind == "Timedelta":  # of pandas
        return f"{value.total_seconds()!r} s"
    if isinstance(value, float) or kind.startswith("float"):
        number = float(value)
        return str(int(number)) if number.is_integer() and abs(number) < 1e15 else str(value)
    return str(value)


def _workbook_text(data: bytes, faults: Faults) -> str:
    """Write the filled sheets of a workbook below each other as tab-separated text."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            names = archive.namelist()
            unpacked = sum(info.file_size for info in archive.infolist())
    except Exception:  # a damaged archive can fail in any way inside the library
        message = "this is a damaged zip archive, not a table"
        raise faults.refuse(OTHER_KIND_OF_FILE, message, "give the CSV itself") from None
    if {"xl/workbook.xml", "content.xml"}.isdisjoint(names):
        hint = "save the table as CSV and give that file; gyro grade reads a zip of a whole class"
        raise faults.refuse(OTHER_KIND_OF_FILE, "this is a zip archive, not a table", hint)
    if unpacked > _MAX_UNPACKED:
        raise faults.refuse(FILE_TOO_LARGE, "the workbook unpacks to more than 100 MB", _SMALL)
    try:
        sheets = _sheets(data) if "xl/workbook.xml" in names else _opendocument(data)
    except Exception as error:  # so can a damaged workbook
        message = f"the workbook cannot be read ({f'{type(error).__name__}: {error}'[:80]})"
        raise faults.refuse(WORKBOOK_CANNOT_BE_READ, message, "save the table as CSV") from None
    if not sheets:
        raise faults.refuse(WORKBOOK_CANNOT_BE_READ, "the workbook is empty", "save the log's sheet as CSV")
    # The name of a sheet is a title of what stands on it.
    return "\n".join(text if len(sheets) == 1 else f"sheet {name}\n{text}" for name, text in sheets.items()) + "\n"


def _sheets(data: bytes) -> dict[str, str]:
    """Give the text of each filled sheet by its name."""
    openpyxl = import_module("openpyxl")  # not at the start-up of every command
    sheets = {}
    for sheet in openpyxl.load_workbook(io.BytesIO(data), read_only=True, data_only=True).worksheets:
        # One stray cell at the far corner makes a sheet of 17 thousand million cells.
        rows = sheet.iter_rows(max_row=MAX_ROWS + 10, max_col=MAX_COLUMNS + 10)
        # A row that is struck out is left out as one that begins with #.
        values = (
            ["#"] * _is_struck(row) + [None if cell.value is None else _plain(cell) for cell in row] for row in rows
        )
        sheets[sheet.title] = "\n".join(_table_text(values)).rstrip("\n")
    return {name: text for name, text in sheets.items() if text}


def _opendocument(data: bytes) -> dict[str, str]:
    """Give the text of each filled sheet of an OpenDocument file by its name."""
    sheets = other_tables.opendocument_sheets(data, MAX_ROWS + 10, MAX_COLUMNS + 10)
    return {name: "\n".join(_table_text(rows)) for name, rows in sheets}


def _is_struck(row: tuple[Any, ...]) -> bool:
    filled = [cell for cell in row if cell.value is not None]
    return bool(filled) and all(cell.font.strike for cell in filled)


def _plain(cell: Any) -> Any:
    """Undo what Excel makes of a cell: 03:36.26 is stored as a time of the day, and 15.0 as 15, shown with a digit."""
    value = cell.value
    if type(value) in (int, float) and (shown := re.fullmatch(r"0\.(0+)", cell.number_format or "")):
        text = f"{value:.{len(shown[1])}f}"
        # Digits that the sheet does not show were typed too.
        return text if float(text) == value else value
    if isinstance(value, time):
        if value.hour:
            return f"{value:%H:%M:%S} (a time of the day)"  # "3:36" typed: three hours, or three minutes?
        return f"{value.minute:02d}:{value.second + value.microsecond / 1e6:05.2f}"
    if isinstance(value, timedelta):
        minutes, seconds = divmod(value.total_seconds(), 60)
        return f"{int(minutes):02d}:{seconds:05.2f}"
    return value


# --- from text to rows of cells: delimiter, quotes, # lines and limits -------------------------------------------


class Row(Struct, frozen=True):
    """One row of a table."""

    line: int
    """Where it begins."""
    texts: list[str]
    """Its cells, without quotes and without blanks around them; blank ones at the end are cut off."""
    origin: tuple[tuple[int, int], ...] | None = None
    """Line and number of each cell in the file, where they are not those of this row."""

    def spot(self, at: int) -> int:
        """Number a cell of the file."""
        line, column = self.origin[at] if self.origin is not None and at < len(self.origin) else (self.line, at)
        return line * MAX_COLUMNS + column


class Grid(Struct, frozen=True):
    """The rows of a table, and the ``# key: value`` lines around it."""

    lines: list[str]
    """Of the file."""
    delimiter: str
    rows: list[Row]
    """Rows that are neither comments nor blank."""
    metadata: list[tuple[str, Text]]
    """Keys with their values, in the order of the file."""
    comments: list[Text]
    """``#`` lines that say no ``key: value``."""
    floats: frozenset[int] = frozenset()
    """As in `Document`."""

    def cell(self, row: Row, at: int) -> Text:
        """Give one cell with its place, which only a fault asks for."""
        return Text(row.texts[at], *find_place(self.lines, self.delimiter, row.spot(at)))


# Marks of order and width that a copy from a web page or a chat brings along, and that no editor shows.
_UNSEEN = "\ufeff\u200b\u200c\u200d\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2060 \u00a0"
_DECIMAL = re.compile(r"[-+−]?[0-9]+([.,])([0-9]+)")
_SPACED = re.compile(r" *[-+.0-9/eE]+(?: +[-+.0-9/eE]+)+ *")
"""A row of numbers that only blanks part."""
_LONE_QUOTE = r'((?:^|{0})\s*)"(?=\s*(?:{0}|$))'
_DITTO = frozenset(("''", '"', "″", "“", "”", "〃", "ditto", "dito", "idem"))
"""Marks for "the same as above", as a blank cell says it too."""
_KEY = re.compile(r"\s*([^\W\d][\w .()/\-]{0,39}?)\s*[:=]\s*(.*)", re.DOTALL)


def make_grid(document: Document) -> Grid:
    """Split a log into cells."""
    faults = document.faults
    grid = Grid(list(faults.lines), ",", [], [], [], document.floats)
    lines = grid.lines
    body: list[int] = []  # indices of the table's lines
    forced = document.delimiter
    for index, line in enumerate(lines):
        if not line or line.isspace():
            continue
        if line[0] in '# "\t' and re.match(r'[ "\t]*#(?!\s*[;,\t])', line):
            _read_comment(line, index + 1, grid, faults)
        elif index == 0 and re.fullmatch(r"sep=[;,\t]\s*", line):
            forced = line[4]  # what Excel writes for itself
        else:
            body.append(index)
    if len(body) - 1 > MAX_ROWS:  # without the header
        message = f"{len(body) - 1} rows; at most 100 000 are read"
        raise faults.refuse(TOO_MANY_ROWS, message, "a lab log has some dozens")
    forced = forced or _from_markup(lines, body)
    delimiter = forced or _find_delimiter([lines[i] for i in body[:30]]) or _from_blanks(lines, body)
    if delimiter is None and body:
        first = next((i for i in body if _SPACED.fullmatch(lines[i])), body[0])
        hint = "put a comma, a semicolon or a tab between the columns"
        cell = Text(lines[first], first + 1, 1)
        raise faults.refuse(NO_DELIMITER, "no delimiter between the columns was found", hint, cell)
    grid = replace(grid, delimiter=delimiter or ",")
    grid.rows.extend(row for row in _split_rows(grid, body, faults) if not _read_key(row, grid, faults))
    width = len(grid.rows[0].texts) if grid.rows else 0
    commented = (c for c in grid.comments if width > 2 and c.text.count(grid.delimiter) == width - 1)
    if hidden := [c.line for c in commented if c.text[:1].isdigit()]:
        faults.add(ROW_TAKEN_OUT, f"{span(hidden)}: begins with # and is left out", "", Place(hidden[0], 1))
    return grid


def _read_key(row: Row, grid: Grid, faults: Faults) -> bool:
    """Take I_zz and "g = 9.81", or "Ball diameter", "101.6", "mm", out of the rows, as if it stood in a ``#`` line.

    Tell whether the row held nothing else.
    """
    if row.texts[0] == "#":
        return False  # the reader of the rows says that it is left out
    if found := find_in_row(row.texts):
        at, answer = found
        grid.metadata.append(("I_zz", replace(grid.cell(row, at), text=answer)))
        del row.texts[at:]
        while row.texts and not row.texts[-1]:
            row.texts.pop()
    filled = [text for text in row.texts if text]
    if len(filled) > 3 or not filled:
        return not filled
    match = _KEY.fullmatch(" ".join(filled)) or re.fullmatch(r"([^\W\d][\w ]*?)\t(.*)", "\t".join(filled))
    key = re.sub(r"[\s_\-]+", "_", match[1].strip()).lower() if match else ""
    if match is None or key not in CONSTANTS or not re.match(r"[-+(]?[.\d]", match[2]):
        return False
    cell = grid.cell(row, row.texts.index(filled[0]))
    value = replace(cell, text=match[2].replace("\t", " "))
    grid.metadata.append((key, value))
    faults.add(LINE_READ_AS_KEY, f'line {row.line} is read as "# {key}: {value.text}"', "", cell)
    return True


def decimal_signs(grid: Grid, by_delimiter: bool = True) -> set[str]:
    """Give the decimal signs of a table's first numbers, as far as no mark between thousands looks like them."""
    signs = {
        match[1]
        for row in grid.rows[:50]
        for text in row.texts
        if (match := _DECIMAL.fullmatch(text)) and (len(match[2]) != 3 or text[0] == "0")
    }
    # Where a spreadsheet parts the cells with semicolons, the comma is the decimal sign.
    return signs or ({","} if by_delimiter and grid.delimiter == ";" else set())


def _read_comment(line: str, number: int, grid: Grid, faults: Faults) -> None:
    """Read ``# key: value``; a spreadsheet may have quoted the line or hung delimiters on it."""
    start = line.index("#") + 1
    content = line[start:].rstrip(" \t,;")
    if line.lstrip().startswith('"'):
        content = content.rstrip('"').replace('""', '"')
    if match := _KEY.fullmatch(content):
        key = re.sub(r"[\s\-]+", "_", match[1].strip())
        grid.metadata.append((key, Text(match[2].strip(), number, start + match.start(2) + 1)))
        return
    comment = Text(content.strip(), number, start)
    match = re.fullmatch(r"(\w+)\s+([-+]?[0-9].*)", comment.text)
    if match and match[1].lower() in CONSTANTS:  # "# latitude 48.1 deg" lacks its colon
        grid.metadata.append((match[1].lower(), replace(comment, text=match[2])))
        message = f'"# {comment.text[:60]}" is read as "# {match[1].lower()}: {match[2][:60]}"'
        faults.add(LINE_READ_AS_KEY, message, "", comment)
    else:
        grid.comments.append(comment)


_RULE = re.compile(r"[\s|+:=\-]*\|[\s|+:=\-]*|[\s+:=\-]*[+\-=]{3,}[\s+:=\-]*|\s*\\[a-zA-Z]+.*")
"""A line that only draws a line in a Markdown table, or a command of LaTeX."""


def _from_markup(lines: list[str], body: list[int]) -> str | None:
    """Blank what frames the cells of a table in Markdown or LaTeX, and give its delimiter; None if it is neither.

    The cells stay at their places.
    """
    framed = sum(lines[i].count("|") > 1 for i in body)
    tex = sum("&" in lines[i] and "\\\\" in lines[i] for i in body)
    if 2 * max(framed, tex) <= len(body) or max(framed, tex) < 2:
        return None
    body[:] = [i for i in body if not _RULE.fullmatch(lines[i])]
    for i in body:
        frame = r"\\\\.*$|[$~]|\\[,;: ]" if tex > framed else r"^\s*\||\|\s*$"
        lines[i] = re.sub(frame, lambda mark: " " * len(mark[0]), lines[i])
    return "&" if tex > framed else "|"


def _from_blanks(lines: list[str], body: list[int]) -> str | None:
    """Part columns that only blanks align: a tab takes the place of the first blank between two cells."""
    for gap in (" {2,}", " +") if body else ():
        counts = Counter(len(re.split(gap, lines[i].strip())) for i in body)
        width, often = counts.most_common(1)[0]
        rows = [i for i in body if len(re.split(gap, lines[i].strip())) == width]
        # Single blanks part columns only if each name of a column has its unit.
        named = gap == " {2,}" or sum(bool(re.search(r"[\[(]", name)) for name in lines[rows[0]].split()) > 2
        if width >= 4 and 3 * often > 2 * len(body) and len(rows) > 2 and named:
            for i in body:
                start = len(lines[i]) - len(lines[i].lstrip())
                lines[i] = lines[i][:start] + re.sub(
                    gap, lambda blanks: "\t" + " " * (len(blanks[0]) - 1), lines[i][start:].rstrip()
                )
            return "\t"
    return None


def _find_delimiter(lines: list[str]) -> str | None:
    """Take the delimiter that cuts most rows into equally many cells."""
    best, best_share = None, 0.0
    if lines and 2 * sum(map(bool, map(_SPACED.fullmatch, lines))) >= len(lines):
        return None  # the comma of a title above parts no columns
    bare = [re.sub(r'"[^"]*"', "", line[: 4 * MAX_CELL]) for line in lines]
    for delimiter in "\t;,":
        counts = [line.count(delimiter) for line in bare]
        often = Counter(filter(None, counts))
        # Titles may stand above the header, and a row may lack the delimiters of its blank cells.
        share = max(often[max(counts[:2])], often.most_common(1)[0][1]) / len(counts) if often else 0.0
        if share > best_share + 0.3 * (best is not None):
            best, best_share = delimiter, share
    return best


def _split_rows(grid: Grid, body: list[int], faults: Faults) -> Iterator[Row]:
    """Split the lines of a table into cells."""
    lines, delimiter = grid.lines, grid.delimiter
    width = 0  # delimiters of the row above
    until = -1  # last line of a quoted cell that goes over several lines
    for index in body:
        if index <= until:
            continue
        line = lines[index]
        if '"' in line and width:
            # Ditto marks: no text in quotes has its quotes alone in the cells of a whole row.
            bare = re.sub(_LONE_QUOTE.format(re.escape(delimiter)), r"\1 ", line)
            if '"' not in bare and bare.count(delimiter) == width:
                lines[index] = line = bare
        line = line.rstrip(delimiter + " ")
        columns = line.count(delimiter) + 1
        if columns <= MAX_COLUMNS and '"' in line:
            texts, until = _split_quoted(grid, index, faults)
            columns = len(texts)
        elif columns <= MAX_COLUMNS:
            texts = line.split(delimiter)
            width = lines[index].count(delimiter)
        if columns > MAX_COLUMNS:
            message = f"{columns} columns; at most {MAX_COLUMNS} are read"
            hint = "a lab log has about ten; is this another table?"
            raise faults.refuse(TOO_MANY_COLUMNS, message, hint, Place(index + 1, 1))
        texts = [text.strip().strip(_UNSEEN).strip() for text in texts]
        if long := [at for at, text in enumerate(texts) if len(text) > MAX_CELL]:
            message = f"a cell of {len(texts[long[0]])} characters; at most 10 000 are read"
            place = find_place(lines, delimiter, Row(index + 1, texts).spot(long[0]))
            raise faults.refuse(CELL_TOO_LONG, message, "", place)
        if not _DITTO.isdisjoint(texts):
            texts = ["" if text in _DITTO else text for text in texts]
        while texts and not texts[-1]:
            texts.pop()
        if texts:
            yield Row(index + 1, texts)


def _split_quoted(grid: Grid, index: int, faults: Faults) -> tuple[list[str], int]:
    """Split a row with quoted cells, one of which may go on in the next lines; give the index of its last line too."""

    def lines() -> Iterator[str]:
        for number in range(index, len(grid.lines)):
            yield grid.lines[number] + " "
        raise csv.Error

    reader = csv.reader(lines(), delimiter=grid.delimiter, skipinitialspace=True)
    try:
        return next(reader), index + reader.line_num - 1
    except csv.Error:
        message, hint = "a quoted cell begins here and is never closed", 'close it with ", or take the quote away'
        opened = list(re.finditer(rf'(?:^|{re.escape(grid.delimiter)})\s*"', grid.lines[index]))
        place = Place(index + 1, opened[-1].end() if opened else 1)
        raise faults.refuse(QUOTE_NEVER_CLOSED, message, hint, place) from None


_MOST_LINES_OF_A_CELL = 100


def find_place(lines: list[str], delimiter: str, spot: int) -> Place:
    """Find where a cell stands by its number."""
    line, at = divmod(spot, MAX_COLUMNS)
    text = "\n".join(lines[line - 1 : line + _MOST_LINES_OF_A_CELL])
    mark = re.escape(delimiter)
    cell = rf'(?> *(?:"(?:[^"]|"")*(?:"|\Z))?[^{mark}\n]*){mark}'
    match = re.match(rf'(?:{cell}){{{at}}}(?:[{_UNSEEN}]*"?(?=[^{mark}{_UNSEEN}"\n]))?', text)
    before = text[: match.end()] if match else ""
    return Place(line + before.count("\n"), len(before) - before.rfind("\n"))
