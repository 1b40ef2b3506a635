"""One cell: from what was typed to an SI value, its last digit, and what it says of its own uncertainty."""

from __future__ import annotations

import math
import re
from functools import lru_cache
from typing import NamedTuple

from gyrodata.diagnostics import (
    CELL_BECAME_A_DATE,
    CELL_IS_NO_NUMBER,
    PER_SECOND_IS_AMBIGUOUS,
    UNIT_MISSING,
    UNIT_UNKNOWN,
)
from gyrodata.quantities import (
    PLAIN,
    Written,
    doubtful_comma,
    fold_number,
    in_si,
    last_place,
    take_apart,
    to_float,
)
from gyrodata.readings.roles import BY_NAME, kind_of_role
from gyrodata.units import LIMITS, SI, Uncertainty, UnitError, examples, kind_in_words, kinds_of, parse_unit

_LOG = "mass [g],position [cm],spin [rpm],time [s],turns\n"
BLANKS = frozenset({"", "-", "–", "—", "−", "--", "~", "‐", "‑"})
"""What stands where nothing was measured."""


class CellError(ValueError):
    """A cell that cannot be read.

    Parameters
    ----------
    code : str
        Diagnostic code.
    message : str
        What is wrong, to stand after the role and the cell.
    hint : str
        What to type.
    """

    def __init__(self, code: str, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.code = code
        self.hint = hint

    @property
    def joint(self) -> str:
        """What parts the cell from the message: nothing before a colon."""
        return "" if str(self).startswith(":") else " "


class Cell(NamedTuple):
    """A number as it was typed."""

    value: float
    """[SI unit of the role]"""
    step: float | None
    """One step of the last digit typed [SI unit of the role]; None for a fraction or a plain 0."""
    uncertainty: Uncertainty | None
    """From a ± or a bracket in the cell itself."""
    unit: str
    """Unit that was used, the cell's own or the column's."""


_CLOCK = re.compile(r"(?:([0-9]{1,2}):)?([0-9]{1,3}):([0-9]{2}(?:[.,][0-9]+)?)")

_MISTYPED = str.maketrans({"O": "0", "o": "0", "l": "1", "I": "1", "|": "1", "S": "5"})
_MONTHS = {
    abbreviation: number
    for number, names in enumerate(
        (
            "jan jän ene янв sty janv",
            "feb фев lut fev févr fév",
            "mar mrz mär мар mars",
            "apr abr апр kwi avr",
            "may mai mei май maj мая",
            "jun июн cze juin",
            "jul июл lip juil",
            "aug ago авг sie août aoû",
            "sep сен wrz set sept",
            "oct okt окт paź out",
            "nov ноя lis",
            "dec dez dic дек gru déc",
        ),
        start=1,
    )
    for abbreviation in names.split()
}
_DATE_DIGITS = re.compile(r"[0-9]{1,4}[./-][0-9]{1,2}[./-][0-9]{1,4}(?:[ T].*)?")
_DAY_MONTH = re.compile(r"([0-9]{1,4})[.\s-]*([^\W\d_]{3,9})\.?(?:[\s-]*[0-9]{2,4})?")
_MONTH_DAY = re.compile(r"([^\W\d_]{3,9})\.?[\s-]*([0-9]{1,4})")
_SPOKEN_CLOCK = re.compile(
    r"([0-9]{1,3})\s*(?:'|m|min|мин)\.?\s*([0-9]{1,2}(?:[.,][0-9]+)?)\s*(?:\"|''|s|sec|c|сек)?\.?"
)
_SENSES = {
    "ccw": 1.0,
    "counterclockwise": 1.0,
    "anticlockwise": 1.0,
    "+": 1.0,
    "+1": 1.0,
    "1": 1.0,
    "cw": -1.0,
    "clockwise": -1.0,
    "-1": -1.0,
}


def is_blank(text: str) -> bool:
    """Tell whether a cell says that nothing was measured."""
    return text in BLANKS


@lru_cache(maxsize=16384)
def read_cell(text: str, kind: str, unit: str | None, ask: bool = False) -> Cell:
    """Understand one cell that is not blank.

    Parameters
    ----------
    text : str
        As typed, without blanks around it.
    kind : str
        Kind of quantity of its column.
    unit : str or None
        Unit of its column, already known to be of that kind; None if the column has none.
    ask : bool
        Refuse a comma that may part thousands; in a column, it is a decimal comma.

    Raises
    ------
    CellError
        It is no number, or its unit does not fit or is missing.
    """
    if kind == "sign":
        return _read_sense(text)
    if unit is not None and not ask and PLAIN.fullmatch(text) and 0 < abs(value := to_float(text)) < math.inf:
        # Nearly every cell; what follows reads it as well, in twice the time.
        try:
            known = parse_unit(unit, kind)
            return Cell(value * known.factor, float(f"1e{last_place(text)}") * known.factor, None, known.text)
        except UnitError:
            pass  # said below, in the words for a cell
    if (":" in text or not text.isascii()) and (clock := _CLOCK.fullmatch(fold_number(text))):
        return _read_clock(clock, text, kind, unit)
    written = take_apart(text)
    plain = written is not None and written.spread is None and "/" not in written.number
    if written is None or written.named or (plain and written.unit and not _is_unit(written.unit)):
        raise _not_a_number(text, written)
    _check_size(written)
    if ask and (ways := doubtful_comma(written, kind, unit)):
        raise CellError(CELL_IS_NO_NUMBER, f"can mean {ways}", "write it without marks between the thousands")
    return _convert(written, kind, unit, text)


def _is_unit(text: str) -> bool:
    return bool(kinds_of(text)) and not text.translate(_MISTYPED).isdigit()


def _check_size(written: Written) -> None:
    """Refuse what divides by zero, or what a number of sixteen digits cannot hold."""
    if math.isinf(written.value) and "/" in written.number:
        raise CellError(CELL_IS_NO_NUMBER, "divides by zero")
    if written.spread is None and written.value and math.isfinite(written.value):
        return
    for number in (written.number, written.spread):
        if number is None or "/" in number:
            continue
        value = to_float(number)
        if math.isinf(value):
            raise CellError(CELL_IS_NO_NUMBER, "is too large for a number", "write the value as it was read")
        if value == 0 and any(c in "123456789" for c in re.split("[eE]", number)[0]):
            raise CellError(CELL_IS_NO_NUMBER, "is too small for a number", "write the value as it was read")


def _convert(written: Written, kind: str, unit: str | None, text: str) -> Cell:
    """Bring a number into SI with its last digit and its ±."""
    own = written.unit or unit
    if own is None and kind != "number":
        raise CellError(UNIT_MISSING, "has no unit", f"write one behind it: {examples(kind)}")
    try:
        value, step, uncertainty, known = in_si(written, kind, unit)
    except UnitError as error:
        raise CellError(
            PER_SECOND_IS_AMBIGUOUS if error.reason == "ambiguous" else UNIT_UNKNOWN, f": {error}", error.hint
        ) from None
    if math.isinf(value) and written.value == 0:
        raise CellError(UNIT_UNKNOWN, f': "{own}" is a time, not a rotation rate', "no turn takes no time")
    if uncertainty is not None and uncertainty.absolute > LIMITS.get(kind, (0.0, math.inf))[1]:
        raise CellError(CELL_IS_NO_NUMBER, "has an uncertainty that is far too large")
    exact = value == 0 and set(text) <= set("+-−0")
    return Cell(value, None if exact else step, uncertainty, known)


def _read_clock(match: re.Match[str], text: str, kind: str, unit: str | None) -> Cell:
    if kind != "time":
        raise CellError(CELL_IS_NO_NUMBER, "is a clock time, not a number")
    if unit not in (None, "s", "min"):
        raise CellError(UNIT_UNKNOWN, f': a clock time under the unit "{unit}"', "write the column's unit as s")
    hours, minutes, seconds = match.groups()
    late = to_float(seconds)
    if late >= 60 or (hours and int(minutes) >= 60):
        raise CellError(CELL_IS_NO_NUMBER, "is no clock time: 60 and more belong to the place before", "write mm:ss.cc")
    step = float(f"1e{last_place(seconds)}")
    return Cell(int(hours or 0) * 3600 + int(minutes) * 60 + late, step, None, "s")


def _read_sense(text: str) -> Cell:
    key = fold_number(text).lower().replace(" ", "").replace("-c", "c")
    if key not in _SENSES:
        raise CellError(CELL_IS_NO_NUMBER, "is no sense of rotation", "write ccw (or +1) or cw (or -1)")
    return Cell(_SENSES[key], None, None, "")


def _not_a_number(text: str, written: Written | None) -> CellError:
    """Say what it looks like instead, and what was probably meant."""
    plain = fold_number(text)
    lower = plain.lower()
    if lower in ("nan", "na", "n/a", "#n/a", "none", "null", "inf", "-inf", "infinity", "#div/0!", "#value!"):
        return CellError(CELL_IS_NO_NUMBER, "is not a number", "leave the cell blank where nothing was measured")
    date = _read_as_date(text)
    if date is not None:
        return date
    mended = plain.translate(_MISTYPED)
    for candidate in (mended, mended.rstrip(".,;"), re.sub(r"([.,])[.,]+", r"\1", mended)):
        if candidate != plain and _is_bare(candidate):
            return CellError(CELL_IS_NO_NUMBER, "is not a number", f"did you mean {candidate}?")
    if re.fullmatch(r"[-+]?[0-9]{1,3}(?:[ .,'][0-9]{3})+(?:[.,][0-9]*)?", plain):
        return CellError(CELL_IS_NO_NUMBER, "is not a number", "write it without marks between the thousands")
    if re.fullmatch(r"[0-9]+\s*(?:a|o|st|nd|rd|th|er|e|ème|ой|ый|я)\.?", lower) or "ª" in text or "º" in text:
        return CellError(CELL_IS_NO_NUMBER, "is an ordinal, not a number", "write how many, as 1, 2.5 or 1/3")
    clock = _SPOKEN_CLOCK.fullmatch(lower)
    if clock:
        return CellError(CELL_IS_NO_NUMBER, "is not a number", f"write it as {int(clock[1]):02d}:{clock[2].zfill(2)}")
    if (closer := take_apart(plain.replace(" (", "("))) and closer.spread and " (" in plain:
        hint = f"write {plain.replace(' (', '(')} if the bracket is its uncertainty"
        return CellError(CELL_IS_NO_NUMBER, "is not a number", hint)
    if written is not None and written.unit and not written.named:
        return CellError(CELL_IS_NO_NUMBER, f'is not a number with a unit: "{written.unit}" is no unit known here')
    return CellError(CELL_IS_NO_NUMBER, "is not a number")


def _is_bare(text: str) -> bool:
    """Tell whether it is a number or a fraction without a unit."""
    written = take_apart(text)
    return written is not None and written.unit is None and written.spread is None


def _read_as_date(text: str) -> CellError | None:
    day_month = _DAY_MONTH.fullmatch(text)
    month_day = _MONTH_DAY.fullmatch(text)
    pair: tuple[int, int] | None = None
    if day_month:
        pair = _date_numbers(day_month[1], day_month[2])
    elif month_day:
        pair = _date_numbers(month_day[2], month_day[1])
    elif not _DATE_DIGITS.fullmatch(text):
        return None
    if pair is None and not _DATE_DIGITS.fullmatch(text):
        return None
    meant = f"did you mean {min(pair)}/{max(pair)}? " if pair else ""
    return CellError(
        CELL_BECAME_A_DATE,
        "is a date, not a number",
        meant + "A spreadsheet does that to fractions: make the cells text first",
    )


def _date_numbers(day: str, month: str) -> tuple[int, int] | None:
    word = month.lower()
    number = _MONTHS.get(word) or _MONTHS.get(word[:4]) or _MONTHS.get(word[:3])
    return None if number is None else (int(day), number)


@lru_cache(maxsize=16384)
def check_value(role: str, value: float) -> tuple[str, str]:
    """Say what is wrong with a number that cannot be, and what to type; two empty texts if nothing is.

    Parameters
    ----------
    role : str
        What it measures.
    value : float
        [SI unit of the role]
    """
    fault = hint = ""
    bound = BY_NAME[role].bound if role in BY_NAME else ""
    if not math.isfinite(value):
        fault = "is too large"
    elif bound == "above zero" and value <= 0:
        fault = "is not above zero"
    elif bound == "not zero" and value == 0:
        fault = "is zero"
    elif bound == "not below zero" and value < 0:
        fault = "is below zero"
    elif bound == "below 90 degrees" and abs(value) >= math.pi / 2:
        fault = "is not between -90 and 90 degrees"
    if fault and math.isfinite(value):
        hint = BY_NAME[role].bound_hint
    kind = kind_of_role(role)
    if not fault and value and kind in LIMITS:
        low, high = LIMITS[kind]
        if not low <= abs(value) <= high:
            fault = f"is too {'large' if abs(value) > high else 'small'} for {kind_in_words(kind)} in a lab"
            hint = f"is its unit the one written? Read are {low:g} to {high:g} {SI[kind]}".rstrip()
    return fault, hint
