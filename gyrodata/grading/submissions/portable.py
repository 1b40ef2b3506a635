"""The text of a PDF that a person who opens it sees, as lines by pypdf.

Text that is white, tiny, transparent, not painted or beside the page is left out, and so
is the text that a scanner adds behind a picture: nobody can see whether it is right.
"""

from __future__ import annotations

import io
import logging
import math
from collections.abc import Mapping, Sequence
from itertools import islice
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pypdf import PageObject

MOST_PAGES = 100
SMALLEST = 3.0  # height of letters that a person can read [points]
FAINTEST = 0.2  # opacity of text that a person can read
WHITE = 0.9  # share of white in the colour of text that a person cannot read

_SHOWING = (b"Tj", b"TJ", b"'", b'"')
_NOT_PAINTED = (3, 7)  # modes in which letters are neither filled nor drawn
_MATRIX, _COLOUR = b"Tm", b"g"
_SAME = dict.fromkeys((b"BT", b"Td", b"TD"), _MATRIX)
_SAME |= dict.fromkeys((b"rg", b"k", b"cs", b"sc", b"scn"), _COLOUR)
"""Operators that change what another one sets."""


def pdf_lines(data: bytes) -> tuple[list[str], list[str]]:
    """Return the lines of a PDF that a person sees, and those that nobody sees.

    Raises ValueError if it cannot be read.
    """
    from pypdf import PdfReader

    logging.getLogger("pypdf").setLevel(logging.CRITICAL)
    seen: list[str] = []
    unseen: list[str] = []
    try:
        for page in islice(PdfReader(io.BytesIO(data)).pages, MOST_PAGES):
            whole = page.extract_text(extraction_mode="layout").splitlines()
            lines = whole
            if _leaves_out_unseen(page):
                lines = page.extract_text(extraction_mode="layout").splitlines()
            seen += lines
            unseen += [line for line in whole if line not in lines]
    except Exception as error:
        # pypdf raises errors of many kinds for a file that is damaged on purpose.
        raise ValueError(f"{type(error).__name__}: {error}") from None
    return seen, unseen


def _leaves_out_unseen(page: PageObject) -> bool:
    """Remove the text of a page that a person does not see; return whether it has any."""
    from pypdf import Transformation
    from pypdf.generic import NameObject

    content = page.get_contents()
    if content is None:
        return False
    same = Transformation()
    ink = {b"cm": same, _MATRIX: same, b"gs": 1.0, b"Tr": [0], _COLOUR: [0]}
    outer = []
    kept = []
    for operands, operator in content.operations:
        if operator == b"q":
            outer.append(ink.copy())
        elif operator == b"Q" and outer:
            ink = outer.pop()
        elif operator not in _SHOWING:
            ink[_SAME.get(operator, operator)] = _set(ink, operator, operands, page)
        elif not _is_seen(ink, page):
            continue
        kept.append((operands, operator))
    if len(kept) == len(content.operations):
        return False
    content.operations = kept
    page[NameObject("/Contents")] = content
    return True


def _set(
    ink: Mapping[bytes, Any], operator: bytes, operands: Any, page: PageObject
) -> Any:
    """Return what an operator of a page sets for the text behind it."""
    from pypdf import Transformation

    if operator == b"cm":
        return Transformation(operands).transform(ink[operator])
    if operator in (b"BT", b"Tm"):
        return Transformation(operands or (1, 0, 0, 1, 0, 0))
    if operator in (b"Td", b"TD"):
        return Transformation().translate(*operands).transform(ink[_MATRIX])
    if operator == b"gs":
        resources: Any = page["/Resources"]
        return resources["/ExtGState"][operands[0]].get("/ca", ink[operator])
    return operands


def _is_seen(ink: Mapping[bytes, Any], page: PageObject) -> bool:
    """Return whether a person sees text with such a place, size, colour and opacity."""
    whole = ink[_MATRIX].transform(ink[b"cm"])
    x, y = whole.apply_on((0, 0))
    box = page.mediabox
    is_on_page = box.left <= x <= box.right and box.bottom <= y <= box.top
    height = ink[b"Tf"][1] * math.hypot(*whole.matrix[1][:2])
    is_painted = ink[b"Tr"][0] not in _NOT_PAINTED and not _is_white(ink[_COLOUR])
    is_inked = is_painted and ink[b"gs"] > FAINTEST
    return is_inked and is_on_page and height >= SMALLEST


def _is_white(colour: Sequence[Any]) -> bool:
    """Return whether a colour of one, three or four parts is white."""
    try:
        parts = [float(part) for part in colour]
    except (TypeError, ValueError):
        return False  # the name of a pattern
    if len(parts) == 4:
        return max(parts) <= 1 - WHITE
    return bool(parts) and min(parts) >= WHITE
