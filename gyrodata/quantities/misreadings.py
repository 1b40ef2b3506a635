"""Explain a text in the place of a number, and what was probably meant."""

from __future__ import annotations

import re

from gyrodata.base import diagnostics
from gyrodata.quantities import vocabulary
from gyrodata.quantities.numerals import IN_FRONT, NUMBER, fold_number, take_apart
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
_DATES = (
    r"(?P<day>[0-9]{1,4})[.\s-]*(?P<month>[^\W\d_]{3,9})\.?(?:[\s-]*[0-9]{2,4})?",
    r"(?P<month>[^\W\d_]{3,9})\.?[\s-]*(?P<day>[0-9]{1,4})",
    r"[0-9]{4}[./-](?P<month>[0-9]{1,2})[./-](?P<day>[0-9]{1,2})(?:[ T]00:00:00)?",
    r"(?P<day>[0-9]{1,2})([./-])(?P<month>[0-9]{1,2})\2(?:19|20)[0-9]{2}",
)
_DATE_DIGITS = r"[0-9]{1,4}[./-][0-9]{1,2}[./-][0-9]{1,4}(?:[ T].*)?"
_TWO_NUMBERS = rf"{NUMBER}\s*(?:-|–|—|->|→|to|bis|à|a|до)\s*{NUMBER}\s*\S*"


def explain(text: str, kind: str, otherwise: UnitError) -> UnitError:
    """Return an error that says what a text looks like, and what was probably meant.

    The result is `otherwise` if the text looks like nothing that is known.
    """
    plain = fold_number(text)
    if kind == "rate" and re.fullmatch(_TWO_NUMBERS, plain):
        return two_numbers()
    for case in vocabulary.NO_NUMBER:
        if match := re.fullmatch(case["pattern"], plain, re.IGNORECASE):
            return fault(case["message"], match.expand(case["hint"]))
    pair = date_pair(text)
    if pair or re.fullmatch(_DATE_DIGITS, text):
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


def two_numbers() -> UnitError:
    """Return the error of a text that looks like two readings."""
    return fault(
        "is not one number, but looks like two readings",
        "write their mean; or write them in two columns, such as spin_start [rpm] and "
        "spin_end [rpm], or in two rows",
    )


def is_mistyped_number(unit: str) -> bool:
    """Return whether a unit consists of digits and of letters typed for digits."""
    return unit.translate(_MISTYPED).isdigit()


def _mend(plain: str) -> str:
    """Return a text with the digits and the decimal sign that were probably meant."""
    digits = re.sub(IN_FRONT, "", plain).translate(_MISTYPED)
    return re.sub(r"([.,])[.,]+", r"\1", digits).rstrip(".,;")


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
    for date in _DATES:
        match = re.fullmatch(date, text)
        if match is None:
            continue
        month = _month(match["month"].lower())
        return None if month is None else (int(match["day"]), month)
    return None


def _month(word: str) -> int | None:
    """Return the number of a month; its name may be shortened."""
    if word.isdigit():
        return int(word)
    for name in (word, word[:4], word[:3]):
        if name in _MONTHS:
            return _MONTHS[name]
    return None
