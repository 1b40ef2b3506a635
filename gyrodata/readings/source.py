"""From whatever holds a log (file, standard input, bytes, DataFrame, workbook) to its text, and to rows of cells."""

from __future__ import annotations

import difflib
import hashlib
import io
import os
import re
import sys
import zlib
from collections import Counter
from collections.abc import Iterable, Mapping
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
from gyrodata.readings.cells import find_in_row
from gyrodata.readings.lablog import Faults, Place, Text, listing, span

if TYPE_CHECKING:
    import pandas as pd

    Source = str | os.PathLike[str] | bytes | BinaryIO | TextIO | pd.DataFrame

MAX_BYTES = 10 * 1000 * 1000
MAX_ROWS = 100_000
MAX_COLUMNS = 200


_SIGNATURES: tuple[tuple[bytes, str], ...] = (
    (b"\x89PNG", "a PNG picture"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"GIF8", "a GIF picture"),
    (b"BM", "a BMP picture"),
    (b"RIFF", "a picture or a sound"),
    (b"II*\x00", "a TIFF picture"),
    (b"MM\x00*", "a TIFF picture"),
    (b"%PDF", "a PDF"),
    (b"%!PS", "a PostScript file"),
    (b"{\\rtf", "a rich-text document"),
    (b"\xd0\xcf\x11\xe0", "an old Office file (.xls or .doc)"),
    (b"7z\xbc\xaf", "a 7z archive"),
    (b"Rar!", "a RAR archive"),
    (b"BZh", "a bzip2 archive"),
    (b"\xfd7zXZ", "an xz archive"),
    (b"SQLite format", "a database"),
)
_MARKUP = re.compile(rb"\s*(?:<!doctype|<html|<\?xml|<svg)", re.IGNORECASE)
_SAVE_AS = "save the table as CSV (in a spreadsheet: File, Save as, CSV UTF-8) and give that file"


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
        return Document(shown, _digest(text.encode()), text, Faults(shown, text), "\t", floats)
    shown, data = _read(source, name)
    faults = Faults(shown)
    digest = _digest(data)
    if len(data) > MAX_BYTES:
        raise faults.refuse(
            FILE_TOO_LARGE, "the file is larger than 10 MB", "a lab log has a few kilobytes; is this the one?"
        )
    if data.startswith(b"\x1f\x8b"):
        data = _decompress(data, faults)
    if data.startswith(b"PK\x03\x04"):
        text = _workbook_text(data, faults)
        return Document(shown, digest, text, _with_text(faults, text), "\t")
    _refuse_other_files(data, faults)
    text, encoding = decode(data, faults)
    if not text.strip():
        raise faults.refuse(LOG_IS_EMPTY, "the log is empty", "write a blank log to fill in with: gyro template")
    faults = _with_text(faults, text)
    if encoding:
        faults.add(
            CODE_PAGE_GUESSED, f"the file is not UTF-8; it was read as {encoding}", "save it as UTF-8 to be sure"
        )
    return Document(shown, digest, text, faults)


def _with_text(faults: Faults, text: str) -> Faults:
    fresh = Faults(faults.name, text)
    fresh.found.extend(faults.found)
    return fresh


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


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
    return _read_path(source, name)


def _read_path(source: str | os.PathLike[str], name: str | None) -> tuple[str, bytes]:
    path = Path(source)
    shown = printable(name or path.name or str(path))
    faults = Faults(shown)
    try:
        with path.open("rb") as file:
            return shown, file.read(MAX_BYTES + 1)
    except FileNotFoundError:
        raise faults.refuse(FILE_NOT_FOUND, f"there is no file {str(path)!r}", _neighbours(path)) from None
    except IsADirectoryError:
        raise faults.refuse(
            FILE_CANNOT_BE_OPENED, f"{str(path)!r} is a folder, not a log", "give the file in it"
        ) from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
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
    text = b""
    while True:  # a file may hold several parts, one behind the other
        unpacker = zlib.decompressobj(wbits=31)
        try:
            text += unpacker.decompress(data, MAX_BYTES + 1 - len(text))
        except zlib.error:
            raise faults.refuse(
                COMPRESSED_FILE_DAMAGED, "the .gz file is damaged", "make it again, or give the CSV itself"
            ) from None
        if len(text) > MAX_BYTES:
            raise faults.refuse(FILE_TOO_LARGE, "the file unpacks to more than 10 MB", "a lab log has a few kilobytes")
        if not unpacker.eof:
            raise faults.refuse(
                COMPRESSED_FILE_DAMAGED, "the .gz file ends too early", "make it again, or give the CSV itself"
            )
        data = unpacker.unused_data.lstrip(b"\x00")
        if not data:
            break
    return text


def _refuse_other_files(data: bytes, faults: Faults) -> None:
    for signature, kind in _SIGNATURES:
        # "BM" and "RIFF" may also begin a word of a text.
        if data.startswith(signature) and (signature not in (b"BM", b"RIFF") or b"\x00" in data[:64]):
            raise faults.refuse(OTHER_KIND_OF_FILE, f"this is {kind}, not a table", _SAVE_AS)
    if _MARKUP.match(data):
        raise faults.refuse(OTHER_KIND_OF_FILE, "this is a web page, not a table", _SAVE_AS)
    if re.match(rb'(?:\xef\xbb\xbf)?\s*(?:\{\s*"|\[\s*[\[{])', data):
        hint = "write a table: a first row mass [g],position [cm],spin [rpm],time [s],turns, and one row for each run"
        hint += "; in Python, for a list of runs: pandas.read_json(FILE).to_csv('log.csv', index=False)"
        raise faults.refuse(OTHER_KIND_OF_FILE, "this is JSON, not a table", hint)


def decode(data: bytes, faults: Faults) -> tuple[str, str]:
    """Decode by byte-order mark, as UTF-8, or in the one-byte code page that fits best."""
    for mark, encoding in (
        (b"\xef\xbb\xbf", "utf-8"),
        (b"\xff\xfe\x00\x00", "utf-32"),
        (b"\x00\x00\xfe\xff", "utf-32"),
        (b"\xff\xfe", "utf-16"),
        (b"\xfe\xff", "utf-16"),
    ):
        if data.startswith(mark):
            body = data[3:] if encoding == "utf-8" else data
            return _without_nul(body.decode(encoding, "replace"), faults), ""
    if b"\x00" in data:
        at = data.index(b"\x00")
        looks_wide = data[1:40:2].count(0) > 8 or data[0:40:2].count(0) > 8
        hint = "it looks like UTF-16 without its mark; " + _SAVE_AS if looks_wide else _SAVE_AS
        raise faults.refuse(NOT_TEXT, f"this is not text: byte {at + 1} is a NUL", hint)
    try:
        return data.decode("utf-8"), ""
    except UnicodeDecodeError:
        encoding = _guess_code_page(data)
        return data.decode(encoding, "replace"), encoding


def _without_nul(text: str, faults: Faults) -> str:
    if "\x00" in text:
        raise faults.refuse(NOT_TEXT, "this is not text: it holds NUL characters", _SAVE_AS)
    return text


_CODE_PAGES = ("cp1252", "cp1251", "cp1250", "koi8-r", "cp866", "cp1253")
_WIDE_CODE_PAGES = ("cp932", "gb18030", "cp949")
"""What Excel writes as CSV in Japan, China and Korea: two bytes a character."""
_WORD = r"[^\W\d_]+"


def _guess_code_page(data: bytes) -> str:
    """Take the code page in which the words beyond ASCII are words that students write."""
    from gyrodata.readings.roles import is_word

    sample = data[:20_000]
    best, best_score = _CODE_PAGES[0], -1e9
    for encoding in (*_CODE_PAGES, *_WIDE_CODE_PAGES):
        text = sample.decode(encoding, "replace")
        if encoding in _WIDE_CODE_PAGES and "\ufffd" in text[:-1]:
            continue
        score = -5.0 * text.count("\ufffd")
        for word in sorted(set(re.findall(_WORD, text))):
            if word.isascii():
                continue
            score += len(word) * (3.0 if is_word(word) else 0.0)
            # One script in a word is how people write; capitals come first in it.
            score -= 1.0 if len({ord(c) >= 0x370 for c in word}) > 1 else 0.0
            score -= 1.0 if word[1:] != word[1:].lower() else 0.0
        score -= sum(1.0 for c in text if ord(c) > 127 and not c.isalpha() and c not in "°±·²³µ×–—−№\xa0½¼¾º")
        if score > best_score:
            best, best_score = encoding, score
    return best


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
    return "\n".join([*(line.replace("\n", " ") for line in lines), *table_text(rows)]) + "\n", floats


def _is_float(value: Any) -> bool:
    number = getattr(value, "magnitude", value)  # of pint
    return isinstance(number, float) and number == number  # a blank cell is NaN


def _header(name: Any, units: Any) -> str:
    """Write the name of a column, (name, unit) or one whose unit stands in ``attrs["units"]``, as a header."""
    name, unit = name if isinstance(name, tuple) and len(name) == 2 else (name, "")
    if not unit and isinstance(units, Mapping):
        unit = units.get(name, "")
    return f"{name} [{unit}]" if unit else str(name)


def table_text(rows: Iterable[tuple[Any, ...]]) -> Iterable[str]:
    """Write rows of Python values as tab-separated lines."""
    for row in rows:
        yield "\t".join(_quoted(value_text(value)) for value in row)


def _quoted(text: str) -> str:
    text = text.replace("\t", " ").replace("\r", " ").replace("\n", " ")
    return '"' + text.replace('"', '""') + '"' if text.startswith('"') else text


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


_MAX_UNPACKED = 100 * 1000 * 1000


def _workbook_text(data: bytes, faults: Faults) -> str:
    """Write the filled sheets of a workbook below each other as tab-separated text."""
    import struct
    import zipfile

    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            names = archive.namelist()
            unpacked = sum(info.file_size for info in archive.infolist())
    except (zipfile.BadZipFile, NotImplementedError, struct.error, OSError, ValueError):
        raise faults.refuse(
            OTHER_KIND_OF_FILE, "this is a damaged zip archive, not a table", "give the CSV itself"
        ) from None
    if "xl/workbook.xml" not in names:
        kind = "an OpenDocument file" if "content.xml" in names else "a zip archive"
        hint = "save the table as CSV and give that file; gyro grade reads a zip of a whole class"
        raise faults.refuse(OTHER_KIND_OF_FILE, f"this is {kind}, not a table", hint)
    if unpacked > _MAX_UNPACKED:
        raise faults.refuse(FILE_TOO_LARGE, "the workbook unpacks to more than 100 MB", "a lab log has a few kilobytes")
    try:
        sheets = _sheets(data)
    except Exception as error:  # a damaged workbook can fail in any way inside the library
        reason = f"{type(error).__name__}: {error}"[:80]
        raise faults.refuse(
            WORKBOOK_CANNOT_BE_READ, f"the workbook cannot be read ({reason})", "save the table as CSV"
        ) from None
    if not sheets:
        raise faults.refuse(WORKBOOK_CANNOT_BE_READ, "the workbook is empty", "save the log's sheet as CSV")
    if len(sheets) == 1:
        return "\n".join(table_text(sheets[0][1])) + "\n"
    # The name of a sheet is a title of what stands on it.
    rows = [row for name, cells in sheets for row in ((f"sheet {name}",), *cells)]
    return "\n".join(table_text(rows)) + "\n"


def _sheets(data: bytes) -> list[tuple[str, list[tuple[Any, ...]]]]:
    """Give the name and the rows of each filled sheet."""
    openpyxl = import_module("openpyxl")  # not at the start-up of every command
    book = openpyxl.load_workbook(io.BytesIO(data), read_only=True, data_only=True)
    filled = []
    for sheet in book.worksheets:
        # One stray cell at the far corner makes a sheet of 17 thousand million cells.
        cells = sheet.iter_rows(max_row=MAX_ROWS + 10, max_col=MAX_COLUMNS + 10)
        rows = [_row(row) for row in cells]
        while rows and not any(value is not None for value in rows[-1]):
            rows.pop()
        if rows:
            filled.append((sheet.title, rows))
    return filled


def _row(cells: tuple[Any, ...]) -> tuple[Any, ...]:
    end = len(cells)
    while end and cells[end - 1].value is None:
        end -= 1
    return tuple(_plain(cell) for cell in cells[:end])


def _plain(cell: Any) -> Any:
    """Undo what Excel makes of a cell: 03:36.26 is stored as a time of the day, and 15.0 as 15, shown with a digit."""
    from datetime import time, timedelta

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


MAX_CELL = 10_000


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

    def cells(self, row: Row) -> list[Text]:
        """Give the cells of one row with their places."""
        return [self.cell(row, at) for at in range(len(row.texts))]


# Marks of order and width that a copy from a web page or a chat brings along, and that no editor shows.
_UNSEEN = "\ufeff\u200b\u200c\u200d\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2060 \u00a0"
_DECIMAL = re.compile(r"[-+−]?[0-9]+([.,])([0-9]+)")
_DELIMITERS = ("\t", ";", ",")
_SPACED = re.compile(r" *[-+.0-9/eE]+(?: +[-+.0-9/eE]+)+ *")
"""A row of numbers that only blanks part."""
_LONE_QUOTE = r'((?:^|{0})\s*)"(?=\s*(?:{0}|$))'
_DITTO = frozenset(("''", '"', "″", "“", "”", "〃", "ditto", "dito", "idem"))
"""Marks for "the same as above", as a blank cell says it too."""
_KEY = re.compile(r"\s*([^\W\d][\w .()/\-]{0,39}?)\s*[:=]\s*(.*)", re.DOTALL)


def make_grid(document: Document) -> Grid:
    """Split a log into cells."""
    faults = document.faults
    lines = list(faults.lines)
    body: list[int] = []  # indices of the table's lines
    metadata: list[tuple[str, Text]] = []
    comments: list[Text] = []
    forced = document.delimiter
    for index, line in enumerate(lines):
        if not line or line.isspace():
            continue
        if line[0] in '# "\t' and re.match(r'[ "\t]*#(?!\s*[;,\t])', line):
            _read_comment(line, index + 1, metadata, comments)
        elif index == 0 and re.fullmatch(r"sep=[;,\t]\s*", line):
            forced = line[4]  # what Excel writes for itself
        else:
            body.append(index)
    if len(body) - 1 > MAX_ROWS:  # without the header
        raise faults.refuse(
            TOO_MANY_ROWS, f"{len(body) - 1} rows; at most 100 000 are read", "a lab log has some dozens"
        )
    forced = forced or _from_markup(lines, body)
    delimiter = forced or find_delimiter([lines[i] for i in body[:30]]) or _from_blanks(lines, body)
    if delimiter is None and body:
        first = next((i for i in body if _SPACED.fullmatch(lines[i])), body[0])
        hint = "put a comma, a semicolon or a tab between the columns"
        raise faults.refuse(
            NO_DELIMITER, "no delimiter between the columns was found", hint, Place(first + 1, 1), len(lines[first])
        )
    rows = _split_rows(lines, body, delimiter or ",", faults)
    rows = _without_answers(rows, lines, delimiter or ",", metadata)
    rows = _without_constants(rows, lines, delimiter or ",", metadata, faults)
    comments = _without_lost_colons(comments, metadata, faults)
    width = len(rows[0].texts) if rows else 0
    hidden = [
        c.line
        for c in comments
        if delimiter and width > 2 and c.text.count(delimiter) == width - 1 and c.text[:1].isdigit()
    ]
    if hidden:
        faults.add(ROW_TAKEN_OUT, f"{span(hidden)}: begins with # and is left out", "", Place(hidden[0], 1))
    return Grid(lines, delimiter or ",", rows, metadata, comments, document.floats)


def _without_answers(rows: list[Row], lines: list[str], delimiter: str, metadata: list[tuple[str, Text]]) -> list[Row]:
    """Take I_zz out of a table below or beside which it is written, as if it stood in a ``#`` line."""
    kept: list[Row] = []
    for row in rows:
        if found := find_in_row(row.texts):
            at, answer = found
            metadata.append(("I_zz", Text(answer, *find_place(lines, delimiter, row.spot(at)))))
            left = row.texts[:at]
            while left and not left[-1]:
                left.pop()
            row = replace(row, texts=left)
        if row.texts:
            kept.append(row)
    return kept


def _without_constants(
    rows: list[Row], lines: list[str], delimiter: str, metadata: list[tuple[str, Text]], faults: Faults
) -> list[Row]:
    """Take "g = 9.81", or "Ball diameter", "101.6", "mm", out of the rows, as if it stood in a ``#`` line."""
    from gyrodata.readings.roles import CONSTANTS

    kept: list[Row] = []
    for row in rows:
        filled = [text for text in row.texts if text]
        match = _KEY.fullmatch(" ".join(filled)) or re.fullmatch(r"([^\W\d][\w ]*?)\t(.*)", "\t".join(filled))
        key = re.sub(r"[\s_\-]+", "_", match[1].strip()).lower() if match and len(filled) <= 3 else ""
        if match is None or key not in CONSTANTS or not re.match(r"[-+(]?[.\d]", match[2]):
            kept.append(row)
            continue
        at = next(at for at, text in enumerate(row.texts) if text)
        place = find_place(lines, delimiter, row.spot(at))
        value = match[2].replace("\t", " ")
        metadata.append((key, Text(value, *place)))
        faults.add(LINE_READ_AS_KEY, f'line {row.line} is read as "# {key}: {value}"', "", place, len(row.texts[at]))
    return kept


def _without_lost_colons(comments: list[Text], metadata: list[tuple[str, Text]], faults: Faults) -> list[Text]:
    """Read "# latitude 48.1 deg", which lacks its colon, if it is a constant and nothing else."""
    from gyrodata.readings.roles import CONSTANTS

    kept: list[Text] = []
    for comment in comments:
        match = re.fullmatch(r"(\w+)\s+([-+]?[0-9].*)", comment.text)
        if match and match[1].lower() in CONSTANTS:
            metadata.append((match[1].lower(), replace(comment, text=match[2])))
            message = f'"# {comment.text[:60]}" is read as "# {match[1].lower()}: {match[2][:60]}"'
            faults.add(LINE_READ_AS_KEY, message, "", comment)
        else:
            kept.append(comment)
    return kept


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


def _read_comment(line: str, number: int, metadata: list[tuple[str, Text]], comments: list[Text]) -> None:
    """Read ``# key: value``; a spreadsheet may have quoted the line or hung delimiters on it."""
    start = line.index("#") + 1
    content = line[start:].rstrip(" \t,;")
    if line.lstrip().startswith('"'):
        content = content.rstrip('"').replace('""', '"')
    match = _KEY.fullmatch(content)
    if match is None:
        comments.append(Text(content.strip(), number, start))
        return
    key = re.sub(r"[\s\-]+", "_", match[1].strip())
    metadata.append((key, Text(match[2].strip(), number, start + match.start(2) + 1)))


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
        line = lines[i]
        if tex > framed:
            line = re.sub(r"\\\\.*$", lambda end: " " * len(end[0]), line)
            line = re.sub(r"[$~]|\\[,;: ]", lambda mark: " " * len(mark[0]), line)
        else:
            line = re.sub(r"^\s*\||\|\s*$", lambda edge: " " * len(edge[0]), line)
        lines[i] = line
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


def find_delimiter(lines: list[str]) -> str | None:
    """Take the delimiter that cuts most rows into equally many cells."""
    best, best_share = None, 0.0
    if lines and 2 * sum(map(bool, map(_SPACED.fullmatch, lines))) >= len(lines):
        return None  # the comma of a title above parts no columns
    for delimiter in _DELIMITERS:
        counts = [_count(line[: 4 * MAX_CELL], delimiter) for line in lines]
        often = Counter(count for count in counts if count)
        if not often:
            continue
        # Titles may stand above the header, and a row may lack the delimiters of its blank cells.
        share = max(often[max(counts[:2])], often.most_common(1)[0][1]) / len(counts)
        if best is None or share > best_share + 0.3:
            best, best_share = delimiter, share
    return best


def _count(line: str, delimiter: str) -> int:
    if '"' in line:
        line = re.sub(r'"[^"]*"', "", line)
    return line.count(delimiter)


def _split_rows(lines: list[str], body: list[int], delimiter: str, faults: Faults) -> list[Row]:
    rows: list[Row] = []
    width = 0  # delimiters of the row above
    until = -1  # last line of a quoted cell that goes over several lines
    for index in body:
        if index <= until:
            continue
        line = lines[index]
        if '"' in line and rows:
            # Ditto marks: no text in quotes has its quotes alone in the cells of a whole row.
            bare = re.sub(_LONE_QUOTE.format(re.escape(delimiter)), r"\1 ", line)
            if '"' not in bare and bare.count(delimiter) == width:
                lines[index] = line = bare
        if '"' in line:
            cells, until = _split_quoted(lines, index, delimiter, faults)
            texts = [cell.text for cell in cells]
        else:
            texts = [part.strip() for part in line.split(delimiter)]
            width = len(texts) - 1
            if not line.isascii():
                texts = [text.strip(_UNSEEN).strip() for text in texts]
            if len(line) > MAX_CELL or len(texts) > MAX_COLUMNS:
                _check_sizes(line, index + 1, delimiter, faults)
        if not _DITTO.isdisjoint(texts):
            texts = ["" if text in _DITTO else text for text in texts]
        while texts and not texts[-1]:
            texts.pop()
        if len(texts) > MAX_COLUMNS:
            raise _too_many_columns(len(texts), index + 1, faults)
        if texts:
            rows.append(Row(index + 1, texts))
    return rows


def _check_sizes(line: str, number: int, delimiter: str, faults: Faults) -> None:
    if line.count(delimiter) > MAX_COLUMNS and line.rstrip(delimiter + " ").count(delimiter) >= MAX_COLUMNS:
        raise _too_many_columns(line.count(delimiter) + 1, number, faults)
    for at, part in enumerate(line.split(delimiter)):
        if len(part) > MAX_CELL:
            raise _long_cell(len(part), find_cell(faults.lines, delimiter, number, at), faults)


def _too_many_columns(count: int, line: int, faults: Faults) -> Exception:
    hint = "a lab log has about ten; is this another table?"
    return faults.refuse(TOO_MANY_COLUMNS, f"{count} columns; at most {MAX_COLUMNS} are read", hint, Place(line, 1))


def _long_cell(length: int, cell: Text, faults: Faults) -> Exception:
    return faults.refuse(CELL_TOO_LONG, f"a cell of {length} characters; at most 10 000 are read", "", cell.place)


def find_cell(lines: list[str], delimiter: str, line: int, at: int) -> Text:
    """Find the place of one cell of the row that begins in a line."""
    whole = lines[line - 1]
    if '"' in whole:
        return _split_quoted(lines, line - 1, delimiter, Faults(""))[0][at]
    parts = whole.split(delimiter)
    text = parts[at].strip()
    text = text if whole.isascii() else text.strip(_UNSEEN).strip()
    before = sum(len(part) + 1 for part in parts[:at])
    return Text(text, line, 1 + before + (parts[at].index(text) if text else 0))


def find_place(lines: list[str], delimiter: str, spot: int) -> Place:
    """Find where a cell stands by its number."""
    line, at = divmod(spot, MAX_COLUMNS)
    return find_cell(lines, delimiter, line, at).place


def _split_quoted(lines: list[str], index: int, delimiter: str, faults: Faults) -> tuple[list[Text], int]:
    """Split a line with quoted cells; one of them may go on in the next lines."""
    row: list[Text] = []
    line, position = lines[index], 0
    while True:
        start = position
        while start < len(line) and line[start] in " \u00a0":
            start += 1
        if line.startswith('"', start):
            place = Place(index + 1, start + 1)
            text, index, position = _read_quoted(lines, index, start + 1, place, faults)
            line = lines[index]
            end = line.find(delimiter, position)
            end = len(line) if end < 0 else end
            row.append(Text((text + line[position:end]).strip(), place.line, place.column + 1))
        else:
            end = line.find(delimiter, position)
            end = len(line) if end < 0 else end
            text = line[position:end].strip()
            row.append(Text(text, index + 1, min(start, end) + 1))
        if len(row[-1].text) > MAX_CELL:
            raise _long_cell(len(row[-1].text), row[-1], faults)
        if end >= len(line):
            return row, index
        if len(row) > MAX_COLUMNS * 2:
            raise _too_many_columns(line.count(delimiter) + 1, index + 1, faults)
        position = end + 1


def _read_quoted(lines: list[str], index: int, position: int, opened: Place, faults: Faults) -> tuple[str, int, int]:
    """Read up to the closing quote; give the text, and the line and position behind the quote."""
    parts: list[str] = []
    length = 0
    while True:
        line = lines[index]
        end = line.find('"', position)
        if end < 0:
            parts.append(line[position:] + " ")
            length += len(line) - position + 1
            index, position = index + 1, 0
        elif line.startswith('""', end):
            parts.append(line[position : end + 1])
            length += end + 1 - position
            position = end + 2
        else:
            parts.append(line[position:end])
            return "".join(parts), index, end + 1
        if index >= len(lines) or length > MAX_CELL:
            message = "a quoted cell begins here and is never closed"
            raise faults.refuse(QUOTE_NEVER_CLOSED, message, 'close it with ", or take the quote away', opened)
