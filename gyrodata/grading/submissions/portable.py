"""The text of a PDF that a person who opens it sees, as lines by pypdf.

Text that is white, tiny, transparent, not painted or beside the page is left out, and so
is the text that a scanner adds behind a picture: nobody can see whether it is right.
"""

from __future__ import annotations

import io
import logging
from collections.abc import Sequence
from itertools import islice
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata.physics import Floats

if TYPE_CHECKING:
    from pypdf import PageObject

MOST_PAGES = 100
SMALLEST = 3.0  # height of letters that a person can read [points]
FAINTEST = 0.2  # opacity of text that a person can read
WHITE = 0.9  # share of white in the colour of text that a person cannot read

_SHOWING = (b"Tj", b"TJ", b"'", b'"')
_COLOURS = (b"g", b"rg", b"k", b"cs", b"sc", b"scn")
_PAINTED = (0, 1, 2, 4, 5, 6)  # modes in which letters are filled or drawn


def pdf_lines(data: bytes) -> list[str]:
    """Return the lines of a PDF; raise ValueError if it cannot be read."""
    from pypdf import PdfReader

    logging.getLogger("pypdf").setLevel(logging.CRITICAL)
    try:
        reader = PdfReader(io.BytesIO(data))
        lines = []
        for page in islice(reader.pages, MOST_PAGES):
            _leave_out_unseen(page)
            lines += page.extract_text(extraction_mode="layout").splitlines()
    except Exception as error:
        # pypdf raises errors of many kinds for a file that is damaged on purpose.
        raise ValueError(f"{type(error).__name__}: {error}") from None
    return lines


class _Ink(Struct, frozen=True):
    """How text is painted."""

    place: Floats  # matrix of the page, shape (3, 3)
    text: Floats  # matrix of the text, shape (3, 3)
    size: float = 1.0  # of the font
    is_white: bool = False
    is_painted: bool = True
    opacity: float = 1.0

    def is_seen(self, page: PageObject) -> bool:
        """Return whether a person sees text that is painted so."""
        whole = self.text @ self.place
        height = self.size * np.hypot(whole[1, 0], whole[1, 1])
        x, y = whole[2, :2]
        box = page.mediabox
        is_on_page = box.left <= x <= box.right and box.bottom <= y <= box.top
        is_inked = self.is_painted and not self.is_white and self.opacity > FAINTEST
        return bool(is_inked and is_on_page and height >= SMALLEST)


def _leave_out_unseen(page: PageObject) -> None:
    """Remove the text of a page that a person does not see."""
    from pypdf.generic import NameObject

    content = page.get_contents()
    if content is None:
        return
    ink = _Ink(np.eye(3), np.eye(3))
    outer: list[_Ink] = []
    kept = []
    for operands, operator in content.operations:
        if operator == b"q":
            outer.append(ink)
        elif operator == b"Q" and outer:
            ink = outer.pop()
        elif operator not in _SHOWING:
            ink = _with_operator(ink, operator, operands, page)
        if operator not in _SHOWING or ink.is_seen(page):
            kept.append((operands, operator))
    content.operations = kept
    page[NameObject("/Contents")] = content


def _with_operator(
    ink: _Ink, operator: bytes, operands: Sequence[Any], page: PageObject
) -> _Ink:
    """Return how text is painted after an operator of the page."""
    change: dict[str, Any] = {}
    if operator == b"cm":
        change["place"] = _matrix(operands) @ ink.place
    elif operator in (b"BT", b"Tm", b"Td", b"TD"):
        change["text"] = _text_matrix(ink.text, operator, operands)
    elif operator == b"Tf":
        change["size"] = float(operands[1])
    elif operator == b"Tr":
        change["is_painted"] = int(operands[0]) in _PAINTED
    elif operator in _COLOURS:
        change["is_white"] = _is_white(operands)
    elif operator == b"gs":
        resources: Any = page["/Resources"]
        state = resources["/ExtGState"][operands[0]]
        change["opacity"] = float(state.get("/ca", ink.opacity))
    return replace(ink, **change)


def _text_matrix(text: Floats, operator: bytes, operands: Sequence[Any]) -> Floats:
    """Return the matrix of the text at its beginning, or after it moves."""
    if operator == b"BT":
        return np.eye(3)
    if operator == b"Tm":
        return _matrix(operands)
    return _matrix([1, 0, 0, 1, *operands]) @ text


def _matrix(numbers: Sequence[Any]) -> Floats:
    a, b, c, d, e, f = map(float, numbers)
    return np.array([[a, b, 0.0], [c, d, 0.0], [e, f, 1.0]])


def _is_white(colour: Sequence[Any]) -> bool:
    """Return whether a colour of one, three or four parts is white."""
    try:
        parts = [float(part) for part in colour]
    except (TypeError, ValueError):
        return False  # the name of a pattern
    if len(parts) == 4:
        return max(parts) <= 1 - WHITE
    return bool(parts) and min(parts) >= WHITE
