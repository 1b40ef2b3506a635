"""Read a log from a file, bytes, a DataFrame or a workbook: text, in rows of cells."""

from __future__ import annotations

import difflib
import gzip
import hashlib
import io
import os
import re
import sys
import zlib
from collections import defaultdict
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, TextIO

from gyrodata.base.errors import printable
from gyrodata.readings import conversion
from gyrodata.readings.grid import Grid, make_grid
from gyrodata.readings.lablog import Faults, listing
from gyrodata.readings.names import LETTERS, is_word

if TYPE_CHECKING:
    import pandas as pd

    Source = str | os.PathLike[str] | bytes | BinaryIO | TextIO | pd.DataFrame

MAX_BYTES = 10_000_000
_OTHER_FILES = {
    "a picture": rb"\x89PNG|\xff\xd8\xff|GIF8",
    "a PDF": rb"%PDF",
    "a rich-text document": rb"\{\\rtf",
    "an old Office file (.xls or .doc)": rb"\xd0\xcf\x11\xe0",
    "an OpenDocument file, such as .ods": rb"PK\x03\x04(?s:.{26})"
    rb"mimetypeapplication/vnd.oa",
    "an archive (gyro grade reads the zip of a class)": rb"PK\x03\x04|7z\xbc\xaf|Rar!",
    "a web page": rb"(?i:\s*(?:<!doctype|<html|<\?xml|<svg|<(?:p|div|table)\b))",
    "JSON": rb'(?:\xef\xbb\xbf)?\s*(?:\{\s*"|\[\s*[\[{])',
}
"""Beginnings of files that are not tables."""
_LIST_OF_PROGRAM = re.compile(r"(?:=|<-)\s*(?:[\w.]+\()*(?:\[|c\()\s*[-\d.\[(\"']")
"""The beginning of a list in a program: ``m = np.array([20.1``."""
_CODE_PAGES = (
    "cp1252 cp1251 cp1250 cp1254 cp1253 cp1255 cp1256 cp1257 cp1258 cp874 cp932 "
    "gb18030 cp949 big5 euc_jp"
)
_CODE_PAGES += " koi8_r iso8859_2 mac_roman"
"""Encodings of spreadsheets and editors that do not write UTF-8; of several that fit
equally, the first is used."""


def load(source: Source, name: str | None) -> tuple[Grid, Faults]:
    """Read and decode a log, and split it into cells."""
    if _is_frame(source):
        text, floats = conversion.frame_text(source)
        faults = Faults(name or "<table>", text)
        sha256 = hashlib.sha256(text.encode()).hexdigest()
        return make_grid(faults, "\t", floats, sha256), faults
    shown, data = _read(source, name)
    sha256 = hashlib.sha256(data).hexdigest()
    data = _unpacked(data, Faults(shown))
    if data.startswith(b"PK\x03\x04") and b"xl/workbook.xml" in data:
        faults = conversion.faults_of_workbook(data, shown)
        return make_grid(faults, "\t", sha256=sha256), faults
    faults = _read_text(data, shown)
    return make_grid(faults, sha256=sha256), faults


def _is_frame(source: Any) -> bool:
    module = type(source).__module__
    package = module.partition(".")[0]
    return package == "pandas" and hasattr(source, "columns")


def _unpacked(data: bytes, faults: Faults) -> bytes:
    """Return the content of a .gz file, and other bytes as they are."""
    if data.startswith(b"\x1f\x8b"):
        try:  # up to the limit: a small file can unpack to anything
            data = gzip.GzipFile(fileobj=io.BytesIO(data)).read(MAX_BYTES + 1)
        except (OSError, EOFError, zlib.error):
            raise faults.refuse("damaged_gz") from None
    if len(data) > MAX_BYTES:
        raise faults.refuse("file_too_large")
    return data


def _read_text(data: bytes, shown: str) -> Faults:
    """Decode a log, write JSON as a table; return the faults so far, and its text."""
    faults_of_file = Faults(shown)
    kinds = [kind for kind, start in _OTHER_FILES.items() if re.match(start, data)]
    kind = "".join(kinds[:1])
    if kind not in ("", "JSON"):
        raise faults_of_file.refuse("other_kind", kind=kind)
    text, page = decode(data, faults_of_file)
    if not text.strip():
        raise faults_of_file.refuse("empty")
    if kind == "JSON":
        text = _table_of_json(text, faults_of_file)
    elif _LIST_OF_PROGRAM.search(text):
        raise faults_of_file.refuse("other_kind", kind="a program")
    elif text.count("\\\\") > 2 and text.count("&") > 2:
        raise faults_of_file.refuse("other_kind", kind="LaTeX source")
    faults = Faults(shown, text)
    if page:
        faults.add("code_page", page=page)
    return faults


def _table_of_json(text: str, faults: Faults) -> str:
    from gyrodata.readings import json_table

    try:
        return json_table.table_of(text)
    except json_table.NoTableError as error:
        raise faults.refuse("json_no_table", why=str(error)) from None
    except RecursionError:
        why = "it contains too many brackets inside of brackets"
        raise faults.refuse("json_no_table", why=why) from None
    except ValueError:
        raise faults.refuse("other_kind", kind="JSON") from None


_ENDS_OF_LINES = frozenset("\n\r")


def _read(source: Any, name: str | None) -> tuple[str, bytes]:
    """Return the name and the bytes of a source.

    Of an endless one, only a little more than the limit is read.
    """
    if isinstance(source, bytes | bytearray | memoryview):
        return name or "<bytes>", bytes(source)
    is_text = isinstance(source, str)
    if is_text and not _ENDS_OF_LINES.isdisjoint(source):
        return name or "<text>", _encoded(source)
    if is_text and source == "-":
        return _read_stream(sys.stdin.buffer, name or "<stdin>")
    if isinstance(source, str | os.PathLike):
        return _read_file(Path(source), name)
    if hasattr(source, "read"):
        return _read_stream(source, name)
    what = f"{type(source).__name__} ({source!r:.60})"
    raise TypeError(
        f"a log is a path, its text or bytes, an open file or a DataFrame, not {what}"
    )


def _read_stream(stream: Any, name: str | None) -> tuple[str, bytes]:
    own = getattr(stream, "name", None)
    shown = Path(own).name if isinstance(own, str) else "<stream>"
    return name or shown, _encoded(stream.read(MAX_BYTES + 1))


def _encoded(text: str | bytes) -> bytes:
    if isinstance(text, str):
        return text.encode("utf-8", "surrogatepass")
    return bytes(text)


def _read_file(path: Path, name: str | None) -> tuple[str, bytes]:
    """Return the name and the bytes of a file."""
    shown = name or path.name or str(path)
    shown = shown if shown.isascii() else printable(shown)
    try:
        with path.open("rb") as file:
            return shown, file.read(MAX_BYTES + 1)
    except FileNotFoundError:
        raise _no_file(path, shown) from None
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", "") or error
        raise Faults(shown).refuse(
            "cannot_be_opened", path=str(path), why=why
        ) from None


def _no_file(path: Path, shown: str) -> Exception:
    names = sorted(entry.name for entry in path.parent.glob("*"))[:2000]
    # An ending such as .csv, which most names share, does not make two names similar.
    by_stem = defaultdict(list)
    for other in names:
        by_stem[Path(other).stem.lower()].append(other)
    near = difflib.get_close_matches(path.stem.lower(), by_stem, n=3)
    close = list(chain.from_iterable(by_stem[stem] for stem in near))
    name = "file_misspelt" if close else "file_not_found"
    return Faults(shown).refuse(name, path=str(path), names=listing(close))


def decode(data: bytes, faults: Faults) -> tuple[str, str]:
    """Decode by byte-order mark, as UTF-8, or in the code page with most known words.

    Return the text and that page.
    """
    page = ""
    is_utf16 = data.startswith((b"\xff\xfe", b"\xfe\xff"))
    try:
        text = data.decode("utf-16" if is_utf16 else "utf-8-sig")
    except UnicodeDecodeError:
        # The encoding in which the beginning has most known words
        pages = _CODE_PAGES.split()
        start = data[:20_000]
        page = max(
            pages, key=lambda name: _known_letters(start.decode(name, "replace"))
        )
        text = data.decode(page, "replace")
    if "\x00" in text:
        raise faults.refuse("not_text", at=data.index(0) + 1)
    return text, page


def _known_letters(text: str) -> int:
    """Count the letters beyond ASCII in words of the vocabulary."""
    words = set(LETTERS.findall(text))
    not_ascii = [word for word in words if not word.isascii()]
    known = sum(len(word) for word in not_ascii if _is_known(word))
    return known - 5 * text[:-1].count("\ufffd")


def _is_known(word: str) -> bool:
    """Return whether a word is in the vocabulary, with letters of one alphabet."""
    is_mixed = any(map(str.isascii, word)) and any(
        "\u0370" <= sign <= "\u04ff" for sign in word
    )
    # A single letter of an alphabet is not a word.
    is_long = len(word) > 1 or word > "\u2e80"
    return is_long and not is_mixed and is_word(word)
