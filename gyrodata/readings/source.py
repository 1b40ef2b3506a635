"""From whatever holds a log (file, standard input, bytes, DataFrame, workbook) to its text."""

from __future__ import annotations

import difflib
import hashlib
import io
import os
import re
import sys
import zlib
from collections.abc import Iterable
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, NamedTuple, TextIO

from gyrodata.diagnostics import (
    CODE_PAGE_GUESSED,
    COMPRESSED_FILE_DAMAGED,
    FILE_CANNOT_BE_OPENED,
    FILE_NOT_FOUND,
    FILE_TOO_LARGE,
    LOG_IS_EMPTY,
    NOT_TEXT,
    OTHER_KIND_OF_FILE,
    WORKBOOK_CANNOT_BE_READ,
)
from gyrodata.errors import printable
from gyrodata.readings.lablog import Faults, listing

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


class Document(NamedTuple):
    """A log as text, before anything in it is understood."""

    name: str
    sha256: str
    text: str
    faults: Faults
    delimiter: str | None = None
    """Known beforehand where this module wrote the text itself."""


def load(source: Source, name: str | None) -> Document:
    """Read and decode a log."""
    if _is_frame(source):
        shown = name or "<table>"
        text = _frame_text(source)
        return Document(shown, _digest(text.encode()), text, Faults(shown, text), "\t")
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
        names = sorted(entry.name for entry in path.parent.iterdir() if entry.name != path.name)
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
_WORD = re.compile(r"[^\W\d_]+")


def _guess_code_page(data: bytes) -> str:
    """Take the code page in which the words beyond ASCII are words that students write."""
    from gyrodata.readings.roles import is_word

    sample = data[:20_000]
    best, best_score = _CODE_PAGES[0], -1e9
    for encoding in _CODE_PAGES:
        text = sample.decode(encoding, "replace")
        score = -5.0 * text.count("\ufffd")
        for word in sorted(set(_WORD.findall(text))):
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


def _is_frame(source: object) -> bool:
    """Know a DataFrame without importing pandas."""
    return type(source).__module__.partition(".")[0] == "pandas" and hasattr(source, "columns")


def _frame_text(frame: Any) -> str:
    """Write a DataFrame as the tab-separated text that it would have been read from."""
    lines = [f"# {key}: {value}" for key, value in frame.attrs.items() if isinstance(value, str | int | float)]
    rows = [tuple(frame.columns), *frame.itertuples(index=False, name=None)]
    return "\n".join([*(line.replace("\n", " ") for line in lines), *table_text(rows)]) + "\n"


def table_text(rows: Iterable[tuple[Any, ...]]) -> Iterable[str]:
    """Write rows of Python values as tab-separated lines."""
    for row in rows:
        yield "\t".join(_quoted(value_text(value)) for value in row)


def _quoted(text: str) -> str:
    text = text.replace("\t", " ").replace("\r", " ").replace("\n", " ")
    return '"' + text.replace('"', '""') + '"' if text.startswith('"') else text


def value_text(value: Any) -> str:
    """Write one cell of a spreadsheet or DataFrame as a student would have typed it."""
    if value is None or value != value or type(value).__name__ in ("NAType", "NaTType"):  # NaN is not itself
        return ""
    if isinstance(value, float) or type(value).__name__.startswith("float"):
        number = float(value)
        return str(int(number)) if number.is_integer() and abs(number) < 1e15 else repr(number)
    return str(value)


_MAX_UNPACKED = 100 * 1000 * 1000


def _workbook_text(data: bytes, faults: Faults) -> str:
    """Write the only table of a workbook as tab-separated text, and what another sheet says of I_zz behind it."""
    import zipfile

    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            names = archive.namelist()
            unpacked = sum(info.file_size for info in archive.infolist())
    except (zipfile.BadZipFile, OSError, ValueError):
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
        openpyxl = import_module("openpyxl")
    except ImportError:
        hint = 'pip install "gyrodata[xlsx]" reads it; or save the table as CSV'
        raise faults.refuse(WORKBOOK_CANNOT_BE_READ, "this is an Excel workbook", hint) from None
    try:
        sheets = _sheets(openpyxl, data)
    except Exception as error:  # a damaged workbook can fail in any way inside the library
        reason = f"{type(error).__name__}: {error}"[:80]
        raise faults.refuse(
            WORKBOOK_CANNOT_BE_READ, f"the workbook cannot be read ({reason})", "save the table as CSV"
        ) from None
    tables = [rows for _, rows in sheets if len(sheets) == 1 or sum(map(_is_run, rows)) > 1]
    if len(tables) != 1:
        found = listing([name for name, _ in sheets]) or "none"
        raise faults.refuse(
            WORKBOOK_CANNOT_BE_READ, f"one filled sheet is needed; found: {found}", "save the log's sheet as CSV"
        )
    lines = list(table_text(tables[0]))
    if len(sheets) > 1:
        from gyrodata.readings.cells import find_in_row

        others = [row for _, rows in sheets if rows is not tables[0] for row in rows]
        answers = [find_in_row([value_text(value).strip() for value in row])[1] for row in others]
        lines += [f"# I_zz: {answer}" for answer in answers if answer]
    return "\n".join(lines) + "\n"


def _is_run(row: tuple[Any, ...]) -> bool:
    """Tell a run from a row of results, by its three numbers."""
    return sum(isinstance(value, int | float) for value in row) > 2


def _sheets(openpyxl: Any, data: bytes) -> list[tuple[str, list[tuple[Any, ...]]]]:
    book = openpyxl.load_workbook(io.BytesIO(data), read_only=True, data_only=True)
    filled = []
    for sheet in book.worksheets:
        # One stray cell at the far corner makes a sheet of 17 thousand million cells.
        values = sheet.iter_rows(values_only=True, max_row=MAX_ROWS + 10, max_col=MAX_COLUMNS + 10)
        rows = [_row(row) for row in values]
        while rows and not any(value is not None for value in rows[-1]):
            rows.pop()
        if rows:
            filled.append((sheet.title, rows))
    return filled


def _row(values: tuple[Any, ...]) -> tuple[Any, ...]:
    end = len(values)
    while end and values[end - 1] is None:
        end -= 1
    return tuple(_plain(value) for value in values[:end])


def _plain(value: Any) -> Any:
    """Undo what Excel makes of a stopwatch time: 03:36.26 is stored as a time of the day."""
    from datetime import time, timedelta

    if isinstance(value, time):
        if value.hour:
            return f"{value:%H:%M:%S} (a time of the day)"  # "3:36" typed: three hours, or three minutes?
        return f"{value.minute:02d}:{value.second + value.microsecond / 1e6:05.2f}"
    if isinstance(value, timedelta):
        minutes, seconds = divmod(value.total_seconds(), 60)
        return f"{int(minutes):02d}:{seconds:05.2f}"
    return value
