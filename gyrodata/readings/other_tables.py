"""Tables of an OpenDocument spreadsheet and of a saved web page, as rows of texts."""

from __future__ import annotations

import io
import re
import zipfile
from html.parser import HTMLParser
from xml.etree import ElementTree

_OFFICE = "{urn:oasis:names:tc:opendocument:xmlns:office:1.0}"
_TABLE = "{urn:oasis:names:tc:opendocument:xmlns:table:1.0}"
_TEXT = "{urn:oasis:names:tc:opendocument:xmlns:text:1.0}"


def opendocument_rows(data: bytes, most_rows: int, most_columns: int) -> dict[str, list[list[str]]]:
    """Read the sheets of an OpenDocument file.

    Parameters
    ----------
    data : bytes
        The file, a zip archive with ``content.xml``.
    most_rows, most_columns : int
        Rows and columns at most; a file says "this cell 16,384 times" in one line.

    Returns
    -------
    dict of str to list of list of str
        Rows by the name of the sheet. A number is the text that the sheet shows, if this contains all its digits.
    """
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        content = archive.read("content.xml")
    if b"<!DOCTYPE" in content:
        raise ValueError("it declares entities")
    sheets = {}
    for sheet in ElementTree.fromstring(content).iter(f"{_TABLE}table"):
        rows: list[list[str]] = []
        for row in sheet.iter(f"{_TABLE}table-row"):
            cells: list[str] = []
            for cell in row:
                times = int(cell.get(f"{_TABLE}number-columns-repeated", "1"))
                cells += [_shown(cell)] * min(times, most_columns - len(cells))
            rows += [cells] * min(int(row.get(f"{_TABLE}number-rows-repeated", "1")), most_rows - len(rows))
        sheets[sheet.get(f"{_TABLE}name", "")] = rows
    return sheets


def _shown(cell: ElementTree.Element) -> str:
    shown = " ".join("".join(part.itertext()) for part in cell.iter(f"{_TEXT}p"))
    number = cell.get(f"{_OFFICE}value", "") if cell.get(f"{_OFFICE}value-type") == "float" else ""
    plain = shown.replace(",", ".")
    same = number and re.fullmatch(r"-?[0-9]+\.?[0-9]*", plain) and float(plain) == float(number)
    return plain if same else number or shown


class _Page(HTMLParser):
    """Collects the cells of all tables of a page."""

    def __init__(self) -> None:
        super().__init__()
        self.rows: list[list[str]] = []
        self.inside = False
        """Whether what comes next is the text of a cell."""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag == "tr":
            self.rows.append([])
        elif tag in ("td", "th") and self.rows:
            self.rows[-1].append("")
        self.inside = bool(self.rows and self.rows[-1]) and (tag in ("td", "th") or self.inside)

    def handle_endtag(self, tag: str) -> None:
        self.inside = self.inside and tag not in ("td", "th", "tr", "table")

    def handle_data(self, data: str) -> None:
        if self.inside:
            self.rows[-1][-1] += data


def web_page_rows(text: str) -> list[list[str]]:
    """Give the rows of all tables of a web page, one table after the other."""
    page = _Page()
    page.feed(text)
    return [[" ".join(cell.split()) for cell in row] for row in page.rows]
