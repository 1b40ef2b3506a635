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

    Operations = list[tuple[Any, bytes]]
    """Operators of a page with their operands."""

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
_RISE, _FONT = b"Ts", b"Tf"

SMALLER, RAISED = 0.9, (0.15, 0.9)
"""A superscript has a smaller size than the text in front of it, and a baseline that is
higher by a part of the height of this text."""


def pdf_lines(data: bytes) -> tuple[list[str], list[str]]:
    """Return the lines of a PDF that a person sees, and those that nobody sees.

    Raises ValueError if it cannot be read.
    """
    from pypdf import PdfReader

    logging.getLogger("pypdf").setLevel(logging.CRITICAL)
    texts: list[str] = []
    unseen: list[str] = []
    try:
        for page in islice(PdfReader(io.BytesIO(data)).pages, MOST_PAGES):
            lines, hidden = _lines_of(page)
            texts += lines
            unseen += hidden
    except Exception as error:
        # pypdf raises errors of many kinds for a file that is damaged on purpose.
        raise ValueError(str(error)) from None
    return texts, unseen


def _lines_of(page: PageObject) -> tuple[list[str], list[str]]:
    """Return the lines of a page that a person sees, and those that nobody sees."""
    content = page.get_contents()
    if content is None:
        return [], []
    whole, shown = _operations(page, content.operations)
    if whole != content.operations:
        _replace(page, whole)
    lines = page.extract_text(extraction_mode="layout").splitlines()
    if len(shown) == len(whole):
        return lines, []
    _replace(page, shown)
    kept = page.extract_text(extraction_mode="layout").splitlines()
    return kept, [line for line in lines if line not in kept]


def _operations(
    page: PageObject, operations: Operations
) -> tuple[Operations, Operations]:
    """Return the operations of a page, and those of its text that a person sees.

    In both, ^ is in front of a superscript: "kg m2" may be another unit.
    """
    from pypdf import Transformation

    same = Transformation()
    ink = {b"cm": same, _MATRIX: same, b"gs": 1.0}
    ink |= {operator: [0] for operator in (b"Tr", _COLOUR, _RISE)}
    outer = []
    whole: Operations = []
    shown: Operations = []
    last = (0.0, 0.0)
    for operands, operator in operations:
        step = [(operands, operator)]
        is_visible = True
        if operator == b"q":
            outer.append(ink.copy())
        elif operator == b"Q" and outer:
            ink = outer.pop()
        elif operator in _SHOWING:
            is_visible = _is_visible(ink, page)
            before, last = last, _baseline(ink)
            step = [*_caret(page, ink[_FONT], _is_superscript(last, before)), *step]
        else:
            ink[_SAME.get(operator, operator)] = _set(ink, operator, operands, page)
        if operator != _RISE:
            # pypdf puts raised text into a line of its own.
            whole += step
            shown += step if is_visible else []
    return whole, shown


def _baseline(ink: Mapping[bytes, Any]) -> tuple[float, float]:
    """Return the height of text on the page, and that of its baseline [points]."""
    whole = ink[_MATRIX].transform(ink[b"cm"])
    stretch = math.hypot(*whole.matrix[1][:2])
    height = ink[_FONT][1] * stretch
    _, y = whole.apply_on((0, ink[_RISE][0]))
    return height, y


def _is_superscript(text: tuple[float, float], before: tuple[float, float]) -> bool:
    """Return whether text is a superscript, by its `_baseline` and the one before."""
    (height, y), (height_before, y_before) = text, before
    low, high = (share * height_before for share in RAISED)
    is_raised = low <= y - y_before <= high
    return is_raised and height <= SMALLER * height_before


def _caret(page: PageObject, font: Any, is_superscript: bool) -> Operations:
    """Return the operations that show ^ before a superscript.

    They use a font of their own, because that of the page may have no ^.
    """
    from pypdf.generic import ByteStringObject, DictionaryObject, NameObject

    if not is_superscript:
        return []
    resources: Any = page["/Resources"]
    name = NameObject("/GyroCaret")
    keys = {"Type": "Font", "Subtype": "Type1", "BaseFont": "Courier"}
    pairs = {NameObject(f"/{key}"): NameObject(f"/{keys[key]}") for key in keys}
    resources["/Font"][name] = DictionaryObject(pairs)
    show = ([ByteStringObject(b"^")], b"Tj")
    return [([name, font[1]], _FONT), show, (font, _FONT)]


def _replace(page: PageObject, operations: Operations) -> None:
    """Replace the operations of a page."""
    from pypdf.generic import NameObject

    content: Any = page.get_contents()
    content.operations = operations
    page[NameObject("/Contents")] = content


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


def _is_visible(ink: Mapping[bytes, Any], page: PageObject) -> bool:
    """Return whether a person sees text with such a place, size, colour and opacity."""
    height, y = _baseline(ink)
    x, _ = ink[_MATRIX].transform(ink[b"cm"]).apply_on((0, 0))
    box = page.mediabox
    is_across = box.left <= x <= box.right
    is_on_page = is_across and box.bottom <= y <= box.top
    is_painted = ink[b"Tr"][0] not in _NOT_PAINTED
    is_painted = is_painted and not _is_white(ink[_COLOUR])
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
