"""Explain a text in the place of a number, and what was probably meant."""

from __future__ import annotations

import re

from gyrodata.base import diagnostics
from gyrodata.quantities import vocabulary
from gyrodata.quantities.numerals import fold_number, take_apart, without_name
from gyrodata.quantities.units import UnitError

_MISTYPED = str.maketrans(
    {
        "O": "0",
        "o": "0",
        "l": "1",
        "I": "1",
        "|": "1",
        "S": "5",
        "З": "3",
        "О": "0",
        "о": "0",
    }
)
"""Letters that are typed for digits."""

_MONTHS: dict[str, int] = {}
for _number, _words in vocabulary.MONTHS.items():
    _MONTHS |= dict.fromkeys(_words.split(), int(_number))


def explain(text: str, kind: str, otherwise: UnitError) -> UnitError:
    """Return an error that says what a text looks like, and what was probably meant.

    The result is `otherwise` if the text looks like nothing that is known.
    """
    plain = fold_number(text)
    for case in vocabulary.NO_NUMBER:
        if match := re.fullmatch(case["pattern"], plain, re.IGNORECASE):
            return fault(case["message"], match.expand(case["hint"]))
    pair = date_pair(text)
    day, _, _ = text[:10].partition(" ")
    if pair or any(_digits_of_date(day)):
        return _date(pair, kind)
    mended = _mend(plain)
    bare = take_apart(mended) if mended != plain else None
    if bare and bare.unit is None and bare.spread is None:
        return fault("is not a number", f"did you mean {mended}?")
    return otherwise


def fault(
    message: str, hint: str, code: str = diagnostics.CELL_IS_NO_NUMBER
) -> UnitError:
    """Return the error of a text that cannot be read as a number."""
    return UnitError(message, hint, code)


def is_mistyped_number(unit: str) -> bool:
    """Return whether a unit consists of digits and of letters typed for digits."""
    return unit.translate(_MISTYPED).isdigit()


def _mend(plain: str) -> str:
    """Return a text with the digits and the decimal sign that were probably meant."""
    digits = without_name(plain).translate(_MISTYPED)
    for sign in ".,":
        digits = digits.replace(sign * 2, sign)
    return digits.rstrip(".,;")


def _date(pair: tuple[int, int] | None, kind: str) -> UnitError:
    """Return the error of a date, into which a spreadsheet has made a number.

    If the comma is the decimal sign, 20.1 becomes the 20th of January.
    """
    if pair is None:
        hint = "write the number that was read. "
    elif kind == "number":
        hint = f"did you mean {min(pair)}/{max(pair)}? "
    else:
        hint = "did you mean {}.{}? ".format(*pair)
    hint += "A spreadsheet makes dates of such numbers: make the cells text first"
    return fault("is a date, not a number", hint, diagnostics.CELL_BECAME_A_DATE)


def date_pair(text: str) -> tuple[int, int] | None:
    """Return day and month of a date, in either order; None if a text is not a date."""
    parts = text.translate(_BETWEEN).split()
    names = list(filter(str.isalpha, parts))
    numbers = list(filter(str.isdecimal, parts))
    if len(names) == 1 and 1 <= len(numbers) == len(parts) - 1 <= 2:
        number = _month(names[0].lower())
        return (int(numbers[0]), number) if number else None
    first, month, last = _digits_of_date(text.removesuffix("00:00:00").rstrip(" T"))
    if len(first) == 4:
        return int(last), int(month)
    return (int(first), int(month)) if len(last) == 4 else None


_BETWEEN = str.maketrans(".-", "  ")


def _digits_of_date(day: str) -> list[str]:
    """Return the three numbers of 2024-01-15 or 3.1.2024; blank texts if there are none."""
    for sign in "./-":
        digits = day.split(sign)
        if list(map(str.isdecimal, digits)) == [True] * 3 and len(digits[1]) <= 2:
            return digits
    return [""] * 3


def _month(word: str) -> int | None:
    """Return the number of a month; its name may be shortened."""
    for name in (word, word[:4], word[:3]):
        if name in _MONTHS:
            return _MONTHS[name]
    return None
