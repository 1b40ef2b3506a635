"""Tables of an OpenDocument spreadsheet and of a saved web page, as rows of values."""

from __future__ import annotations

import html.parser
import io
import re
import zipfile
from collections.abc import Iterator
from typing import Any
from xml.etree import ElementTree

Rows = list[tuple[Any, ...]]

_OFFICE = "{urn:oasis:names:tc:opendocument:xmlns:office:1.0}"
_TABLE = "{urn:oasis:names:tc:opendocument:xmlns:table:1.0}"
_TEXT = "{urn:oasis:names:tc:opendocument:xmlns:text:1.0}"


def opendocument_sheets(data: bytes, most_rows: int, most_columns: int) -> list[tuple[str, Rows]]:
    """Read the filled sheets of an OpenDocument file.

    Parameters
    ----------
    data : bytes
        The file, a zip archive with ``content.xml``.
    most_rows, most_columns : int
        Rows and columns at most; a file says "this cell 16,384 times" in one line.

    Returns
    -------
    list of (str, list of tuple)
        Name and rows of each sheet. A number is the text that the sheet shows, if this contains all its digits.
    """
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        content = archive.read("content.xml")
    if b"<!DOCTYPE" in content:
        raise ValueError("it declares entities")
    filled = []
    for sheet in ElementTree.fromstring(content).iter(f"{_TABLE}table"):
        rows: Rows = []
        for row in sheet.iter(f"{_TABLE}table-row"):
            cells: list[Any] = []
            for cell in row:
                times = int(cell.get(f"{_TABLE}number-columns-repeated", "1"))
                cells += [_value(cell)] * min(times, most_columns - len(cells))
            while cells and not cells[-1]:
                cells.pop()
            rows += [tuple(cells)] * min(int(row.get(f"{_TABLE}number-rows-repeated", "1")), most_rows - len(rows))
        while rows and not rows[-1]:
            rows.pop()
        if rows:
            filled.append((sheet.get(f"{_TABLE}name", ""), rows))
    return filled


def _value(cell: ElementTree.Element) -> str:
    shown = " ".join("".join(part.itertext()) for part in cell.iter(f"{_TEXT}p"))
    number = cell.get(f"{_OFFICE}value", "") if cell.get(f"{_OFFICE}value-type") == "float" else ""
    plain = shown.replace(",", ".")
    same = number and re.fullmatch(r"-?[0-9]+\.?[0-9]*", plain) and float(plain) == float(number)
    return plain if same else number or shown


class _Page(html.parser.HTMLParser):
    """Collects the tables of a page."""

    def __init__(self) -> None:
        super().__init__()
        self.tables: list[list[list[str]]] = []
        self.inside = False
        """Whether what comes next is the text of a cell."""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag == "table":
            self.tables.append([])
        elif tag == "tr" and self.tables:
            self.tables[-1].append([])
        elif tag in ("td", "th") and self.tables and self.tables[-1]:
            self.tables[-1][-1].append("")
        self.inside = tag in ("td", "th") or (self.inside and tag not in ("table", "tr", "script", "style"))

    def handle_endtag(self, tag: str) -> None:
        self.inside = self.inside and tag not in ("td", "th", "tr", "table")

    def handle_data(self, data: str) -> None:
        if self.inside and self.tables and self.tables[-1] and self.tables[-1][-1]:
            self.tables[-1][-1][-1] += data


def web_page_tables(text: str) -> Iterator[tuple[str, ...]]:
    """Give the rows of all tables of a web page, one table after the other.

    Parameters
    ----------
    text : str
        The page.

    Yields
    ------
    tuple of str
        The cells of a row, with single blanks in them.
    """
    page = _Page()
    page.feed(text)
    for table in page.tables:
        for row in table:
            yield tuple(" ".join(cell.split()) for cell in row)
