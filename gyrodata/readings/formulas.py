"""Find the formulas of a workbook whose values were never calculated.

A spreadsheet program stores the value of each formula beside it. Other programs write the formula alone, or with the
value 0 (XlsxWriter). Such a cell is not blank, and it does not contain 0.
"""

from __future__ import annotations

import math
import re
import statistics
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from msgspec import Struct, field

Cell = tuple[str, int, int]
"""Title of the sheet, row and column of a cell; both count from 1."""

MAX_FORMULAS = 2_000
"""Formulas with the value 0 or a blank text that are calculated again."""
MAX_TOKENS = 60
"""Parts of a formula; longer formulas are not calculated."""
MAX_TEXT = 1_000
"""Characters of a formula; longer formulas are not calculated."""
MAX_AREA = 500
"""Cells of an area in a formula, such as A1:B200."""


class Formula(Struct, frozen=True):
    """One formula of a workbook."""

    cell: Cell
    text: str
    """As a spreadsheet program shows it: ``=B$4+0.3``."""
    value: str | None
    """Stored value; None if there is none."""


class Content(Struct, frozen=True):
    """The numbers and the formulas of a workbook."""

    numbers: dict[Cell, float | None] = field(default_factory=dict)
    """Stored number of each filled cell, also of those with a formula; None if the cell contains a text."""
    formulas: list[Formula] = field(default_factory=list)
    arrays: list[tuple[Formula, int, int]] = field(default_factory=list)
    """Formulas that fill an area; each with the number of rows and of columns of its area."""
    to_calculate: bool = False
    """Whether the workbook says that its formulas have to be calculated when it is opened."""


def without_value(content: Content) -> dict[Cell, Formula]:
    """Return the formula of each cell whose value was not calculated.

    These are formulas without a stored value, formulas with a stored 0 that is not their result, and formulas of such
    cells. A formula that cannot be calculated here (IF, VLOOKUP) keeps its 0, except in a workbook that asks for a
    calculation.
    """
    lacking = {one.cell: one for one in content.formulas if one.value is None}
    doubtful = [one for one in content.formulas if one.value is not None and not _says_something(one.value)]
    dependents: dict[Cell, list[Formula]] = {}
    for number, formula in enumerate(doubtful):
        expression = _Expression(formula, content.numbers) if number < MAX_FORMULAS else None
        for cell in expression.cells if expression else ():
            dependents.setdefault(cell, []).append(formula)
        result = expression.result() if expression else None
        if content.to_calculate if result is None else result != 0:
            lacking[formula.cell] = formula
    waiting = list(lacking)
    while waiting:
        for formula in dependents.pop(waiting.pop(), ()):
            if formula.cell not in lacking:
                lacking[formula.cell] = formula
                waiting.append(formula.cell)
    return lacking


def _says_something(value: str) -> bool:
    """Return whether a stored value is neither 0 nor a blank text."""
    try:
        return float(value) != 0
    except ValueError:
        return bool(value.strip())


class _NotKnownError(Exception):
    """A formula contains something that is not calculated here."""


def _flat(values: list[Any]) -> list[float]:
    """Return all numbers of the arguments of a function; areas are lists."""
    return [number for value in values for number in (value if isinstance(value, list) else [value])]


_FUNCTIONS: dict[str, Callable[[list[float]], float]] = {
    "SUM": math.fsum,
    "AVERAGE": statistics.fmean,
    "MEDIAN": statistics.median,
    "MIN": min,
    "MAX": max,
    "PRODUCT": math.prod,
    "PI": lambda _: math.pi,
    "ABS": lambda values: abs(values[0]),
    "SQRT": lambda values: math.sqrt(values[0]),
    "RADIANS": lambda values: math.radians(values[0]),
    "ROUND": lambda values: round(values[0], int(values[1])),
}
"""Functions of the numbers in their arguments; other functions are not calculated."""


class _Expression:
    """A formula of numbers, cells, + − * / ^ % and the functions above; it is calculated by recursive descent."""

    def __init__(self, formula: Formula, numbers: Mapping[Cell, float | None]) -> None:
        self._tokens = _tokens_of(formula.text)
        self._sheet, self._numbers, self._at = formula.cell[0], numbers, 0
        self._largest = 0.0
        self.cells = [cell for token in self._tokens if token.subtype == "RANGE" for cell in self._cells(token.value)]

    def result(self) -> float | None:
        """Calculate the formula; None if it contains something else."""
        try:
            result = _number(self._sum())
        except (_NotKnownError, ArithmeticError, ValueError, IndexError):
            return None
        if self._at < len(self._tokens) or not math.isfinite(result):
            return None
        # A difference of equal lengths may be 1e-17 here, and 0 in a spreadsheet program.
        return 0.0 if abs(result) <= 1e-9 * self._largest else result

    def _next(self, kind: str, *values: str) -> str | None:
        """Return the text of the next token and move behind it, if it is of this kind; else None."""
        token = self._tokens[self._at] if self._at < len(self._tokens) else None
        if token is None or f"{token.type} {token.subtype}".strip() != kind:
            return None
        if values and token.value not in values:
            return None
        self._at += 1
        return str(token.value)

    def _sum(self) -> Any:
        result = self._product()
        while sign := self._next("OPERATOR-INFIX", "+", "-"):
            right = self._product()
            result = _number(result) + (_number(right) if sign == "+" else -_number(right))
        return result

    def _product(self) -> Any:
        result = self._power()
        while sign := self._next("OPERATOR-INFIX", "*", "/"):
            right = self._power()
            result = _number(result) * _number(right) if sign == "*" else _number(result) / _number(right)
        return result

    def _power(self) -> Any:
        result = self._signed()
        while self._next("OPERATOR-INFIX", "^"):
            result = math.pow(_number(result), _number(self._signed()))
        return result

    def _signed(self) -> Any:
        if sign := self._next("OPERATOR-PREFIX"):
            return _number(self._signed()) * (-1 if sign == "-" else 1)
        result = self._operand()
        while self._next("OPERATOR-POSTFIX"):
            result = _number(result) / 100
        return result

    def _operand(self) -> Any:
        if number := self._next("OPERAND NUMBER"):
            return float(number)
        if area := self._next("OPERAND RANGE"):
            return self._area(area)
        if self._next("PAREN OPEN"):
            return self._until_closed("PAREN CLOSE")[0]
        if name := self._next("FUNC OPEN"):
            function = _FUNCTIONS.get(name.removesuffix("(").upper())
            if function is None:
                raise _NotKnownError
            return function(_flat(self._until_closed("FUNC CLOSE")))
        raise _NotKnownError

    def _until_closed(self, end: str) -> list[Any]:
        """Return the values up to a closing bracket."""
        values: list[Any] = []
        while self._next(end) is None:
            values.append(self._sum())
            if self._next("SEP ARG") is None and self._at == len(self._tokens):
                raise _NotKnownError
        return values or [[]]

    def _area(self, text: str) -> Any:
        """Return the number of a cell, or the numbers of an area; a blank cell counts as 0, but not in an area."""
        cells = list(self._cells(text))
        if not cells:
            raise _NotKnownError
        numbers = [number for cell in cells if (number := self._numbers.get(cell)) is not None]
        self._largest = max([self._largest, *map(abs, numbers)])
        if ":" in text:
            return numbers
        if not numbers and cells[0] in self._numbers:
            raise _NotKnownError  # a text, which may look like a number
        return numbers[0] if numbers else 0.0

    def _cells(self, text: str) -> Iterator[Cell]:
        """Return the cells of an area: ``B4``, ``$B$4:B9``, ``'Sheet 2'!B4``; none if it is a name or too large."""
        from openpyxl.utils import range_boundaries

        sheet, _, area = text.rpartition("!")
        if not re.fullmatch(r"\$?[A-Z]{1,3}\$?[0-9]{1,7}(:\$?[A-Z]{1,3}\$?[0-9]{1,7})?", area):
            return
        left, top, right, bottom = range_boundaries(area)
        if (right - left + 1) * (bottom - top + 1) > MAX_AREA:
            return
        title = sheet.strip("'").replace("''", "'") or self._sheet
        yield from ((title, row, column) for row in range(top, bottom + 1) for column in range(left, right + 1))


def _tokens_of(text: str) -> list[Any]:
    """Return the parts of a formula; none if it is too long, or not a formula."""
    from openpyxl.formula import Tokenizer
    from openpyxl.formula.tokenizer import TokenizerError

    try:
        tokens = Tokenizer(text).items if len(text) <= MAX_TEXT else []
    except (TokenizerError, IndexError):
        return []
    tokens = [token for token in tokens if token.type != "WHITE-SPACE"]
    return tokens if len(tokens) <= MAX_TOKENS else []


def _number(value: Any) -> float:
    """Return a number; raise _NotKnownError for an area."""
    if isinstance(value, list):
        raise _NotKnownError
    return float(value)
