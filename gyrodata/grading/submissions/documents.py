"""The texts of a student as lines of plain text, and why a file cannot be read.

Of each line it is known whether a person who opens the file may not see it: an answer
there is a question.
"""

from __future__ import annotations

import csv
import html
import io
import re
import tomllib
import unicodedata
import zipfile
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec
from msgspec import Struct

from gyrodata import readings
from gyrodata.base.errors import GyroError
from gyrodata.grading.submissions import visible
from gyrodata.grading.submissions.archives import PDF, TABLES, WORKBOOKS, ending
from gyrodata.grading.submissions.portable import pdf_lines
from gyrodata.readings import workbook

_WORDS = tomllib.loads(
    Path(__file__).with_name("answers.toml").read_text(encoding="utf-8")
)
_STRUCK, _MARKUP, PLAIN = (_WORDS.pop(key) for key in ("struck", "markup", "plain"))
SAYS = {key: f"(?i:{''.join(text.splitlines())})" for key, text in _WORDS.items()}
"""Words of reports, as regular expressions."""
WORD = ".docx"
MOST_LINES, LONGEST_LINE = 1000, 20_000
NO_TEXT = "it contains no text, only pictures; a person must look"
"""Why a PDF cannot be read, such as a scan."""
NOT_READ = "it is a text of LibreOffice; a person must look, or hand in a PDF"


class Document(Struct, frozen=True):
    """A text of a student."""

    name: str  # to be shown
    lines: Sequence[str] = ()  # of plain text; the cells of a table are separated by |
    doubted: frozenset[int] = frozenset()  # numbers of lines that may be unseen
    problem: str = ""  # why it cannot be read; or ""


def read_document(name: str, data: bytes) -> Document:
    """Read a file as lines of plain text; never raises."""
    try:
        lines = _read_lines(name, data)
    except GyroError as error:
        return Document(name, problem=error.diagnostics[0].message)
    except RecursionError:
        return Document(name, problem="it has too many levels of brackets")
    except _DAMAGED as error:
        if str(error) in (NO_TEXT, NOT_READ):
            return Document(name, problem=str(error))
        why = f"{type(error).__name__}: {error}"[:_LONGEST_REASON]
        kind = ending(name) or "text"
        return Document(name, problem=f"it is damaged, or no {kind} file ({why})")
    doubted = {number for number, line in enumerate(lines, 1) if visible.DOUBT in line}
    plain = [without_marks(line) for line in lines]
    return Document(name, plain, frozenset(doubted))


def without_marks(line: str) -> str:
    """Return a line without characters that have no width."""
    if line.isascii():
        return line
    return "".join(c for c in line if unicodedata.category(c) not in ("Cf", "Co"))


_LONGEST_REASON = 80
_DAMAGED = (
    zipfile.BadZipFile,
    zlib.error,
    csv.Error,
    KeyError,
    OSError,
    RuntimeError,
    ValueError,
    AttributeError,
    TypeError,  # JSON that is not a notebook
)


def _read_lines(name: str, data: bytes) -> list[str]:
    """Read a file as lines of text, with bars between the cells of a table."""
    kind = ending(name)
    if kind in WORKBOOKS:
        sheets = workbook.read_sheets(data)
        return [line for one in sheets if not one.is_hidden for line in _rows_of(one)]
    if kind == PDF:
        lines = pdf_lines(data)
        if not any(map(str.strip, lines)):
            raise ValueError(NO_TEXT)
        return [visible.line_seen(line) for line in lines]
    text = _without_struck(_text_of(name, data, kind), kind)
    if kind not in TABLES:
        text = visible.latex_seen(text)
    if kind == ".md":
        text = visible.markdown_seen(text)
    text = _without_markup(text, kind)
    lines = [visible.line_seen(line) for line in readings.lablog.split_lines(text)]
    return in_cells(lines) if kind in TABLES else lines


def _text_of(name: str, data: bytes, kind: str) -> str:
    """Return a file as text, still with its markup."""
    if kind == ".odt":
        raise ValueError(NOT_READ)
    if kind == WORD and data.startswith(b"PK"):
        return _text_of_word(data)
    text = readings.decode(data, readings.Faults(name))[0]
    if kind == ".json":
        return _json_as_lines(text)
    if kind == ".ipynb":
        return "\n".join(_cell_texts(msgspec.json.decode(text)["cells"]))
    return text


def _json_as_lines(text: str) -> str:
    """Write JSON as people write values: ``± 0.1`` for ``"u": 0.1``."""
    uncertainty = r'(?i)"(?!units?")(?:u|d|unc|err|std|sigma|delta)\w*":'
    text = re.sub(uncertainty, "±", text)
    return " ".join(re.sub(r'"units?":|[{}"]|,(?!\d)', " ", text).split())


def _without_struck(text: str, kind: str) -> str:
    """Leave out what is crossed out, and comments; lines keep their numbers."""
    patterns = list(_STRUCK)
    if kind == ".tex":
        patterns.append(r"(?<!\\)%.*")
    elif kind not in TABLES:
        # In a table, a line behind % is a remark.
        patterns.append(r"(?m)^[ \t]*%.*")
    for pattern in patterns:
        text = re.sub(pattern, lambda found: "\n" * found[0].count("\n"), text)
    return text.partition(r"\end{document}")[0] if kind == ".tex" else text


_PAGES = (".html", ".htm")
_TAG = re.compile(r"(?i)</p>|<(?:br|sup)\b")


def _without_markup(text: str, kind: str) -> str:
    """Turn the page of a browser or a word processor into lines as they are shown."""
    if kind in _PAGES or (kind not in (".md", WORD) and _TAG.search(text)):
        text = visible.page_seen(text)
    if kind not in (*_PAGES, WORD) and not _TAG.search(text):
        return text
    for pattern, plain in _MARKUP:
        text = re.sub(pattern, plain, text)
    lines = map(str.strip, html.unescape(text).split("\n"))
    return "\n".join(filter(None, lines))


def _rows_of(sheet: workbook.Sheet) -> Iterator[str]:
    """Give the rows of a sheet as lines; cells that are not shown are doubted."""
    unseen = workbook.unseen_cells(sheet)
    for number, row in enumerate(sheet.rows, 1):
        cells = ["" if cell is None else str(cell) for cell in row]
        yield " | ".join(
            visible.doubted(cell) if (number, at) in unseen else cell
            for at, cell in enumerate(cells, 1)
        )


class Unseen(Struct, frozen=True):
    """The cells of a workbook that are not shown."""

    sheets: frozenset[str] = frozenset()  # names of hidden sheets
    cells: frozenset[str] = frozenset()  # texts of cells that are not shown


def unseen_in(name: str, data: bytes) -> Unseen:
    """Return what is hidden in a workbook; nothing if it is none, or cannot be read."""
    if ending(name) not in WORKBOOKS:
        return Unseen()
    try:
        sheets = workbook.read_sheets(data)
    except ValueError:
        return Unseen()
    cells = {
        str(sheet.rows[row - 1][column - 1])
        for sheet in sheets
        for row, column in workbook.unseen_cells(sheet)
    }
    titles = frozenset(sheet.title for sheet in sheets if sheet.is_hidden)
    return Unseen(titles, frozenset(cells))


def _text_of_word(data: bytes) -> str:
    """Return the XML of Word, without the text in it that is hidden."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        text = re.sub(r">\s+<", "><", _part(archive, "word/document.xml"))
        styles = _part(archive, _STYLES) if _STYLES in archive.namelist() else ""
    return visible.word_seen(text, styles)


_STYLES = "word/styles.xml"


def _part(archive: zipfile.ZipFile, name: str) -> str:
    with archive.open(name) as file:
        return file.read(readings.MAX_BYTES).decode("utf-8", "replace")


def _cell_texts(cells: Iterable[Mapping[str, Any]]) -> Iterator[str]:
    """Yield the texts of a notebook: the cells, and what they printed."""
    printed: list[str] = []
    for cell in cells:
        metadata = cell.get("metadata") or {}
        hidden = metadata.get("jupyter") or {}
        # "hide-input", "remove-cell", "remove_output": what a page of it leaves out.
        tags = " ".join(map(str, metadata.get("tags") or ()))
        mark = visible.doubted if re.search("(?i)hid|remove|exclu", tags) else str
        source = "".join(cell["source"])
        if cell.get("cell_type") == "markdown":
            source = visible.markdown_seen(source)
        if cell.get("cell_type") != "raw" and not hidden.get("source_hidden"):
            yield mark(source)
        if not hidden.get("outputs_hidden"):
            printed += [
                mark("".join(["\n", *one.get("text", [])]))
                for one in cell.get("outputs", [])
            ]
    yield from printed


def in_cells(table: Sequence[str], part: slice = slice(None)) -> list[str]:
    """Separate the cells of a table by ``|``.

    A line of prose, where a comma may be a decimal one, stays as it is.
    """
    sign = max("\t;,", key=lambda one: sum(line.count(one) > 1 for line in table))
    lines = table[part]
    rows = (csv.reader([line[:LONGEST_LINE]], delimiter=sign) for line in lines)
    return [
        line if re.search(SAYS["prose"], line) else " | ".join(*row)
        for line, row in zip(lines, rows, strict=True)
    ]


def as_log(name: str, data: bytes) -> bytes:
    """Return a file as `read_log` reads it.

    A report of a word processor becomes its text, with ``|`` between cells.
    """
    return (
        "\n".join(read_document(name, data).lines).encode()
        if ending(name) in (WORD, PDF)
        else b""
    ) or data
