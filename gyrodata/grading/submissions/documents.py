"""The texts of a student as lines of plain text, and why a file cannot be read.

Of each text it is known whether a person who opens the file may not see a part of it:
an answer there is a question.
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
_SHARED: Mapping[str, str] = _WORDS.pop("words")


def _pattern(words: str | Mapping[str, str]) -> str:
    """Return words of `answers.toml`, or a table of them, as one regular expression."""
    text = words if isinstance(words, str) else "|".join(words.values())
    for name, shared in _SHARED.items():
        text = text.replace(f"{{{name}}}", shared)
    return f"(?i:{''.join(text.splitlines())})"


SAYS = {key: _pattern(words) for key, words in _WORDS.items()}
"""Words of reports, as regular expressions."""
WORD = ".docx"
MOST_LINES, LONGEST_LINE = 1000, 20_000
NO_TEXT = "it contains no text, only pictures; a person must look"
"""Why a PDF cannot be read, such as a scan."""
NOT_READ = "it is a text of LibreOffice; a person must look at it, or the student hands in a PDF"


class Document(Struct, frozen=True):
    """A text of a student."""

    name: str  # to be shown
    lines: Sequence[str] = ()  # of plain text; the cells of a table are separated by |
    doubt: bool = False  # whether a person may not see a part of it
    unseen: Sequence[str] = ()  # lines that nobody sees, which are not read
    problem: str = ""  # why it cannot be read; or ""


def read_document(name: str, data: bytes) -> Document:
    """Read a file as lines of plain text; never raises."""
    unseen: list[str] = []
    try:
        if ending(name) == PDF:
            doubt = False
            lines, unseen = pdf_lines(data)
            if not any(map(str.strip, lines)):
                raise ValueError(NO_TEXT)
        else:
            lines, doubt = _read_lines(name, data)
    except GyroError as error:
        return Document(name, problem=error.diagnostics[0].message)
    except RecursionError:
        return Document(name, problem="it has too many levels of brackets")
    except _DAMAGED as error:
        if str(error) in (NO_TEXT, NOT_READ):
            return Document(name, problem=str(error))
        kind = ending(name) or "text"
        todo = "a person must look at it, or the student hands it in again"
        return Document(name, problem=f"it is damaged, or no {kind} file; {todo}")
    plain = [without_marks(visible.of_line(line)) for line in lines]
    return Document(name, plain, doubt, unseen)


def without_marks(line: str) -> str:
    """Return a line without characters that have no width."""
    if line.isascii():
        return line
    return "".join(c for c in line if unicodedata.category(c) != "Cf")


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


def _read_lines(name: str, data: bytes) -> tuple[list[str], bool]:
    """Read a file as lines of text, with bars between the cells of a table.

    Also return whether a person may not see a part of it.
    """
    kind = ending(name)
    if kind in WORKBOOKS:
        return _lines_of_workbook(data)
    text, doubt = _text_of(name, data, kind)
    text = _without_struck(text, kind)
    if kind == ".tex":
        text = _with_macros(text)
    if kind in TABLES:
        return in_cells(readings.lablog.split_lines(text)), doubt
    text = visible.of_text(text)
    if kind == ".md":
        doubt = visible.has_answer_above(text)
        text = visible.of_markdown(text)
    if kind not in _PAGES:
        doubt = doubt or visible.may_be_unseen(text)
    text, is_hiding = _without_markup(text, kind)
    return readings.lablog.split_lines(text), doubt or is_hiding


def _lines_of_workbook(data: bytes) -> tuple[list[str], bool]:
    """Return the rows of the shown sheets, and whether one of them hides cells."""
    sheets = [sheet for sheet in workbook.read_sheets(data) if not sheet.is_hidden]
    lines = [line for sheet in sheets for line in _rows_of(sheet)]
    return lines, any(map(workbook.unseen_cells, sheets))


def _text_of(name: str, data: bytes, kind: str) -> tuple[str, bool]:
    """Return a file as text, still with its markup, and whether cells are hidden."""
    if kind == ".odt":
        raise ValueError(NOT_READ)
    if kind == WORD and data.startswith(b"PK"):
        return _text_of_word(data)
    text = readings.decode(data, readings.Faults(name))[0]
    if kind == ".json":
        return _json_as_lines(text), False
    if kind == ".ipynb":
        return _notebook_text(msgspec.json.decode(text)["cells"])
    return text, False


def _text_of_word(data: bytes) -> tuple[str, bool]:
    """Return the XML of Word with the styles that it uses.

    Also return whether such a style hides text.
    """
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        text = _part(archive, "word/document.xml")
        styles = ""
        if _STYLES in archive.namelist():
            styles = _part(archive, _STYLES)
    names = re.findall(r'<w:(?:[pr]Style|basedOn)\s+w:val="([^"]*)"', text + styles)
    used = ""
    for style in re.split(r"(?=<w:style\b)", styles):
        if not {*re.findall(r'w:styleId="([^"]*)"', style)}.isdisjoint(names):
            used += style
    hides = re.search('<w:vanish(?: w:val="(?:true|on|1)")?\\s*/>', used)
    return text + used, hides is not None


_STYLES = "word/styles.xml"


def _part(archive: zipfile.ZipFile, name: str) -> str:
    text = archive.open(name).read(readings.MAX_BYTES).decode("utf-8", "replace")
    return re.sub(r">\s+<", "><", text)


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
        text = re.sub(pattern, lambda match: "\n" * match[0].count("\n"), text)
    if kind == ".tex":
        text = text.partition(r"\end{document}")[0]
    return text


_NEW_MACRO = re.compile(
    r"\\(?:re)?newcommand\*?\{?\\([a-zA-Z]{1,40})\}?\{((?:[^{}\n]|\{[^{}\n]*\}){1,200}+)\}"
)
"""A macro of LaTeX without arguments: its name and its text."""
_MACRO = re.compile(r"\\([a-zA-Z]+)(?:\{\})?")
_MOST_MACROS = 1000
"""This many are replaced: with more, a short file could become very long."""


def _with_macros(text: str) -> str:
    """Write the text of each macro of LaTeX in its places; lines keep their numbers."""
    macros = dict(_NEW_MACRO.findall(text))
    if not macros:
        return text
    rest = _NEW_MACRO.sub("", text)
    return _MACRO.sub(
        lambda macro: macros.get(macro[1], macro[0]), rest, count=_MOST_MACROS
    )


_PAGES = (".html", ".htm")
_TAG = re.compile(r"(?i)</p>|<(?:br|sup)\b")


def _without_markup(text: str, kind: str) -> tuple[str, bool]:
    """Turn the page of a browser or a word processor into lines as they are shown.

    Also return whether a style of the page may hide some.
    """
    doubt = False
    is_page = kind in (*_PAGES, ".md")
    if is_page or (kind != WORD and _TAG.search(text)):
        text, doubt = visible.of_page(text)
    if kind not in (*_PAGES, WORD) and not _TAG.search(text):
        return text, doubt
    for pattern, plain in _MARKUP:
        text = re.sub(pattern, plain, text)
    lines = map(str.strip, html.unescape(text).split("\n"))
    return "\n".join(filter(None, lines)), doubt


def _rows_of(sheet: workbook.Sheet) -> Iterator[str]:
    """Give the rows of a sheet as lines."""
    for row in sheet.rows:
        texts = ["" if cell is None else str(cell) for cell in row]
        yield " | ".join(texts)


def hides_cells(name: str, data: bytes) -> bool:
    """Return whether a log has sheets, cells or a part of a line that nobody sees."""
    if ending(name) not in WORKBOOKS:
        return _WIDE.search(data) is not None
    try:
        sheets = workbook.read_sheets(data)
    except ValueError:
        return False
    return any(sheet.is_hidden or workbook.unseen_cells(sheet) for sheet in sheets)


_WIDE = re.compile(rb"[ \t]{200}(?=[^\s])")


def _notebook_text(cells: Iterable[Mapping[str, Any]]) -> tuple[str, bool]:
    """Return the text of a notebook: the cells, and what they printed.

    Also return whether a page of it leaves some out.
    """
    sources = []
    printed = []
    tags = []
    for cell in cells:
        metadata = cell.get("metadata", {})
        hidden = metadata.get("jupyter", {})
        tags += metadata.get("tags", ())
        source = "".join(cell["source"])
        if cell.get("cell_type") == "markdown":
            source, _ = visible.of_page(visible.of_markdown(source))
        if cell.get("cell_type") != "raw" and not hidden.get("source_hidden"):
            sources.append(source)
        if not hidden.get("outputs_hidden"):
            printed += [output.get("text", []) for output in cell.get("outputs", [])]
    # "hide-input", "remove-cell", "remove_output"
    names = " ".join(map(str, tags)).lower()
    doubt = any(word in names for word in ("hid", "remove", "exclu"))
    outputs = ["".join(["\n", *text]) for text in printed]
    return "\n".join([*sources, *outputs]), doubt


def in_cells(lines: Sequence[str]) -> list[str]:
    """Separate the cells of a table by ``|``: "4,5,6" becomes "4 | 5 | 6".

    A line of prose such as "I = 4,5 g m²", where a comma may be a decimal one, stays as
    it is.
    """
    sign = max(
        "\t;,", key=lambda delimiter: sum(line.count(delimiter) > 1 for line in lines)
    )
    rows = (csv.reader([line[:LONGEST_LINE]], delimiter=sign) for line in lines)
    in_bars = []
    for line, row in zip(lines, rows, strict=True):
        is_prose = re.search(SAYS["prose"], line) is not None
        in_bars.append(line if is_prose else " | ".join(*row))
    return in_bars


def as_log(name: str, data: bytes) -> bytes:
    """Return a file as `read_log` reads it.

    A report of a word processor becomes its text, with ``|`` between cells.
    """
    if ending(name) not in (WORD, PDF):
        return data
    text = "\n".join(read_document(name, data).lines)
    return text.encode() or data
