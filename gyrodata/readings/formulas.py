"""Find the formulas of a workbook whose values were never calculated.

A spreadsheet program stores the value of each formula beside it. Other programs write
the formula alone, or with the value 0 (XlsxWriter). Such a cell is not blank, and it
does not contain 0.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping

from msgspec import Struct, field

Cell = tuple[str, int, int]
"""Title of the sheet, row and column of a cell; both count from 1."""

MAX_TEXT = 1_000
"""Inputs are looked for in the first characters of a formula."""
MAX_AREA = 500
"""Cells of the largest area that is looked at as an input, such as A1:B200."""

_SHEET = r"(?:('[^'!]{1,31}'|\w{1,31})!)?"
_CELL = r"\$?([A-Z]{1,3})\$?([0-9]{1,7})"
_INPUT = re.compile(rf"{_SHEET}{_CELL}(?::{_CELL})?(?![\w(])")
"""A cell, or an area from one cell to another, also of another sheet: ``'Data
1'!$A$1:B9``."""


class Formula(Struct, frozen=True):
    """One formula of a workbook."""

    cell: Cell
    text: str
    """As a spreadsheet program shows it: ``=B$4+0.3``."""
    value: str | None
    """Stored value; None if there is none."""

    @property
    def has_result(self) -> bool:
        """Whether the stored value is neither 0 nor a blank text."""
        if self.value is None:
            return False
        try:
            return float(self.value) != 0
        except ValueError:
            return bool(self.value.strip())

    @property
    def may_lack_result(self) -> bool:
        """Whether the stored value is 0 or a blank text.

        A formula that contains a text can have a blank result.
        """
        if self.value is None or self.has_result:
            return False
        return bool(self.value.strip()) or '"' not in self.text


class Content(Struct, frozen=True):
    """The numbers and the formulas of a workbook."""

    numbers: dict[Cell, float | None] = field(default_factory=dict)
    """Stored number of each filled cell, also of those with a formula; None if the cell
    contains a text."""
    formulas: list[Formula] = field(default_factory=list)
    arrays: list[tuple[Formula, int, int]] = field(default_factory=list)
    """Formulas that fill an area; each with the number of rows and of columns of its
    area."""
    to_calculate: bool = False
    """Whether the workbook says that its formulas have to be calculated when it is
    opened."""


def without_value(content: Content) -> dict[Cell, Formula]:
    """Return the formula of each cell whose value was not calculated.

    These are the formulas without a stored value. A stored 0 is not a result either, if
    the workbook asks for a calculation, or if none of its formulas has another value
    although this one has an input that is not 0.
    """
    lacking = {one.cell: one for one in content.formulas if one.value is None}
    zeros = [formula for formula in content.formulas if formula.may_lack_result]
    if content.to_calculate:
        return lacking | {formula.cell: formula for formula in zeros}
    if any(formula.has_result for formula in content.formulas):
        return lacking
    for formula in zeros:
        # A program writes the formulas from the top to the bottom, so that a formula
        # comes after its inputs.
        if _has_input(formula, content, lacking):
            lacking[formula.cell] = formula
    return lacking


def _has_input(
    formula: Formula, content: Content, lacking: Mapping[Cell, Formula]
) -> bool:
    """Return whether an input of a formula is not 0, or was not calculated."""
    inputs = inputs_of(formula)
    return any(cell in lacking or content.numbers.get(cell) for cell in inputs)


def inputs_of(formula: Formula) -> Iterator[Cell]:
    """Return the cells in the text of a formula."""
    from openpyxl.utils import column_index_from_string

    for match in _INPUT.finditer(formula.text[:MAX_TEXT]):
        sheet, left, top, right, bottom = match.groups()
        title = (sheet or formula.cell[0]).strip("'")
        columns = range(
            column_index_from_string(left), column_index_from_string(right or left) + 1
        )
        rows = range(int(top), int(bottom or top) + 1)
        if len(rows) * len(columns) <= MAX_AREA:
            yield from ((title, row, column) for row in rows for column in columns)
