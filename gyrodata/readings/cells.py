"""One value: from what was typed to SI, its last digit, and what it says of its own uncertainty.

A reading stands in a cell or a ``# key: value`` line, and what cannot be read is refused. A value that a student
reports, ``# reported_inertia: 4.4e-3 ± 0.1e-3 kg m^2``, is an answer, not a reading: a malformed one is no fault of the
log, and what is wrong with it is kept beside what can still be read of it, for whoever grades it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from fractions import Fraction
from functools import lru_cache
from typing import Literal

from msgspec import Struct
from msgspec.structs import replace

from gyrodata import vocabulary
from gyrodata.diagnostics import (
    CELL_BECAME_A_DATE,
    CELL_IS_NO_NUMBER,
    PER_SECOND_IS_AMBIGUOUS,
    UNIT_MISSING,
    UNIT_UNKNOWN,
)
from gyrodata.quantities import (
    NUMBER,
    PLAIN,
    Quantity,
    Written,
    doubtful_comma,
    fold_number,
    in_si,
    last_place,
    take_apart,
    to_float,
)
from gyrodata.readings.headers import name_roles, turns_in, words_of_turns
from gyrodata.readings.roles import BY_NAME, kind_of_role
from gyrodata.units import KINDS, LIMITS, SI, Uncertainty, UnitError, kinds_of, parse_unit

BLANKS = frozenset({"", "-", "–", "—", "−", "--", "~", "‐", "‑", "n/a", "N/A", "n.a.", "#N/A", "NA"})
"""What stands where nothing was measured."""


class CellError(ValueError):
    """A cell that cannot be read."""

    def __init__(self, message: str, hint: str = "", code: str = CELL_IS_NO_NUMBER) -> None:
        super().__init__(message)
        self.code = code
        self.hint = hint

    @property
    def joint(self) -> str:
        """What parts the cell from the message: nothing before a colon."""
        return "" if str(self).startswith(":") else " "


_CLOCK = r"(?:([0-9]{1,2}):)?([0-9]{1,3}):([0-9]{2}(?:[.,][0-9]+)?)"

LONG = 600.0
"""So long a time [s] written as 00:20:13 is more likely one of 20.13 s."""

_MISTYPED = str.maketrans({"O": "0", "o": "0", "l": "1", "I": "1", "|": "1", "S": "5"})
_MONTHS = {word: int(number) for number, words in vocabulary.MONTHS.items() for word in words.split()}
_DATE_DIGITS = r"[0-9]{1,4}[./-][0-9]{1,2}[./-][0-9]{1,4}(?:[ T].*)?"
_DOTTED_CLOCK = r"([0-9]{1,2})\.([0-5][0-9])\.([0-9]{2})"
_DATES = (
    r"(?P<day>[0-9]{1,4})[.\s-]*(?P<month>[^\W\d_]{3,9})\.?(?:[\s-]*[0-9]{2,4})?",
    r"(?P<month>[^\W\d_]{3,9})\.?[\s-]*(?P<day>[0-9]{1,4})",
    r"[0-9]{4}[./-](?P<day>[0-9]{1,2})[./-](?P<month>[0-9]{1,2})(?:[ T]00:00:00)?",
    r"(?P<day>[0-9]{1,2})([./-])(?P<month>[0-9]{1,2})\2(?:19|20)[0-9]{2}",
)
_SPOKEN_CLOCK = r"([0-9]{1,3})\s*(?:'|m|min|мин)\.?\s*([0-9]{1,2}(?:[.,][0-9]+)?)\s*(?:\"|''|s|sec|c|сек)?\.?"
_NO_WEIGHT = frozenset(vocabulary.words("no_weight").split())
_TURN_BEHIND = (
    r"(?i)(.*?)\s*(?:of\s+)?(?:an?\s+)?(?:turn|rev|revolution|rotation|lap|round|circle|cycle|Umdrehung|Umlauf|tour|"
    r"оборот|об|vuelta|volta|obrót|obrot|圈|转)\w*\.?"
)
_SEVERAL = r"([1-9][0-9]?)\s*[x×*·](?!\s*10\s*[\^*⁻⁰-⁹-])\s*(.+)"
_SENSES = {
    **dict.fromkeys(("ccw", "counterclockwise", "anticlockwise", "+", "+1", "1"), 1.0),
    **dict.fromkeys(("cw", "clockwise", "-1"), -1.0),
}


@lru_cache(maxsize=16384)
def read_cell(text: str, kind: str, unit: str | None, ask: bool = False) -> Quantity:
    """Understand one cell that is not blank; with `ask`, refuse a comma that may part thousands."""
    plain = fold_number(text)
    if kind == "sign":
        sense = _SENSES.get(plain.lower().replace(" ", "").replace("-c", "c"))
        if sense is None:
            raise CellError("is no sense of rotation", "write ccw (or +1) or cw (or -1)")
        return Quantity(sense, None, None, "")
    if kind in ("mass", "force") and (several := re.fullmatch(_SEVERAL, text)):
        one = read_cell(several[2], kind, unit, ask)
        count = int(several[1])
        u = None if one.uncertainty is None else Uncertainty(count * one.uncertainty.absolute, one.uncertainty.relative)
        return Quantity(count * one.value, None if one.step is None else count * one.step, u, one.unit)
    if clock := re.fullmatch(_CLOCK, plain):
        return _read_clock(clock, kind, unit)
    if kind == "time" and (said := re.fullmatch(_SPOKEN_CLOCK, plain.lower())):
        return read_cell(f"{said[1]}:{'0' * (not said[2][1:2].isdigit())}{said[2]}", kind, unit, ask)
    if kind != "number" and re.fullmatch(r"[1-9][0-9]{0,2}(?:[ \u00a0\u202f][0-9]{3})+", text):
        text = "".join(text.split())  # "1 198 rpm"
    written = take_apart(text)
    if written is None or written.named:
        raise _not_a_number(text, written, kind)
    alone = written.unit and written.spread is None and "/" not in written.number
    if alone and (not kinds_of(written.unit or "") or (written.unit or "").translate(_MISTYPED).isdigit()):
        raise _not_a_number(text, written, kind)
    _check_size(written)
    if kind != "number" and re.fullmatch(r"[0-9]{2,}\s*/\s*[0-9]{2,}", written.number):
        raise two_readings(kind)
    if ask and (ways := doubtful_comma(written, kind, unit)):
        raise CellError(f"can mean {ways}", f"write {ways}, without marks between the thousands")
    own = written.unit or unit
    if own is None and kind != "number":
        raise CellError("has no unit", f"write one behind it: {KINDS[kind].examples}", UNIT_MISSING)
    try:
        quantity = in_si(written, kind, unit)
    except UnitError as error:
        code = PER_SECOND_IS_AMBIGUOUS if error.reason == "ambiguous" else UNIT_UNKNOWN
        raise CellError(f": {error}", error.hint, code) from None
    if math.isinf(quantity.value) and written.value == 0:
        raise CellError(f': "{own}" is a time, not a rotation rate', "no turn takes no time", UNIT_UNKNOWN)
    uncertainty = quantity.uncertainty
    if uncertainty is not None and uncertainty.absolute > LIMITS.get(kind, (0.0, math.inf))[1]:
        raise CellError("has an uncertainty that is far too large")
    exact = quantity.value == 0 and set(text) <= set("+-−0")
    return replace(quantity, step=None) if exact else quantity


def two_readings(kind: str) -> CellError:
    """Name "412/398" and "412 - 398", the spin at the start and at the end."""
    ways = "in two columns, spin_start [rpm] and spin_end [rpm]" if kind == "rate" else "in two rows"
    return CellError("is no number, but looks like two readings", f"write them {ways}")


SPOKEN = ("mass", "turns", "spin_turns")
"""Roles whose numbers are also said in words."""


@lru_cache(maxsize=4096)
def said_otherwise(text: str, role: str) -> str:
    """Give the number that a cell says in another way: "none" of a mass, "one third" or "120°" of turns."""
    if role == "mass":
        return "0 g" if re.sub(r"[\s.\-]+", "", text).lower() in _NO_WEIGHT else ""
    if fraction := fraction_of_date(text):
        return fraction
    match = re.fullmatch(_TURN_BEHIND, text)
    bare = match[1] if match else text
    if words := words_of_turns(bare, whole=True):
        return words
    if bare != text and (bare == "" or take_apart(bare) is not None):
        return bare or "1"
    written = take_apart(text)
    angle = written is not None and written.spread is None and kinds_of(written.unit or "") == {"angle"}
    return turns_in(text) if angle else ""


def fraction_of_date(text: str) -> str:
    """Undo what a spreadsheet makes of 1/3 and 2/3: "3-Jan", "01. Mrz", "2026-01-03 00:00:00"; "" if it is none."""
    pair = _date_pair(text)
    if pair is None or not (min(pair) == 1 or sorted(pair) == [2, 3]) or max(pair) > 12:
        return ""
    return f"{min(pair)}/{max(pair)}"


def rounded_turns(text: str) -> tuple[str, float]:
    """Find the part of a turn that 0.33 or 0.7 was rounded from, and half of what the rounding leaves open; "", 0 else.

    The screws of the ball stand a third of a turn apart; a twelfth is what a run without a weight takes.
    """
    # Whole turns, however many, are meant as written.
    if not PLAIN.fullmatch(text) or last_place(text) >= 0:
        return "", 0.0
    value, step = to_float(text), float(f"1e{last_place(text)}")
    twelfths = round(value * 12)
    # Quarters have few digits: they are meant as written. Who cuts 2/3 off at 0.66 is off by nearly a whole step.
    if twelfths % 3 == 0 or abs(value - twelfths / 12) >= step:
        return "", 0.0
    return str(Fraction(twelfths, 12)), step / math.sqrt(3)


def _date_pair(text: str) -> tuple[int, int] | None:
    """Give day and month of a date, in either order."""
    match = next(filter(None, (re.fullmatch(date, text) for date in _DATES)), None)
    if match is None:
        return None
    word = match["month"].lower()
    month = int(word) if word.isdigit() else _MONTHS.get(word) or _MONTHS.get(word[:4]) or _MONTHS.get(word[:3])
    return (int(match["day"]), month) if month is not None else None


def _check_size(written: Written) -> None:
    """Refuse what divides by zero, or what a number of sixteen digits cannot hold."""
    if math.isinf(written.value) and "/" in written.number:
        raise CellError("divides by zero")
    for number in (written.number, written.spread):
        if number is None or "/" in number:
            continue
        value = to_float(number)
        if math.isinf(value):
            raise CellError("is too large for a number", "write the value as it was read")
        if value == 0 and any(c in "123456789" for c in re.split("[eE]", number)[0]):
            raise CellError("is too small for a number", "write the value as it was read")


def _read_clock(match: re.Match[str], kind: str, unit: str | None) -> Quantity:
    if kind != "time":
        raise CellError("is a clock time, not a number")
    if unit not in (None, "s", "min"):
        raise CellError(f': a clock time under the unit "{unit}"', "write the column's unit as s", UNIT_UNKNOWN)
    hours, minutes, seconds = match.groups()
    late = to_float(seconds)
    if late >= 60 or (hours and int(minutes) >= 60):
        short = "" if hours or not seconds.isdigit() else f"{minutes}.{seconds} for seconds and hundredths, "
        message = "is not a clock time: its seconds or minutes are above 59"
        raise CellError(message, f"write {short}mm:ss.cc for minutes")
    value = int(hours or 0) * 3600 + int(minutes) * 60 + late
    if hours and len(hours) == 2 and seconds.isdigit() and value >= LONG:
        short, long = f"{hours}:{minutes}.{seconds}", f"{int(hours) * 60 + int(minutes)}:{seconds}"
        hint = f"write {short} for minutes, seconds and hundredths; or {long} for minutes and seconds"
        raise CellError("can be h:mm:ss or mm:ss:hundredths", hint)
    return Quantity(value, float(f"1e{last_place(seconds)}"), None, "s")


def _not_a_number(text: str, written: Written | None, kind: str) -> CellError:
    """Say what it looks like instead, and what was probably meant."""
    plain = fold_number(text)
    lower = plain.lower()
    if kind == "rate" and re.fullmatch(rf"{NUMBER}\s*(?:-|–|—|->|→|to|bis|à|a|до)\s*{NUMBER}\s*\S*", plain):
        return two_readings(kind)
    if lower in ("nan", "na", "n/a", "#n/a", "none", "null", "inf", "-inf", "infinity", "#div/0!", "#value!"):
        hint = "write the number, 0 for no weight; or put # before the line of a run that was not measured"
        return CellError("is not a number", hint)
    pair = _date_pair(text)
    if pair or re.fullmatch(_DATE_DIGITS, text):
        if clock := re.fullmatch(_DOTTED_CLOCK, text):
            hint = f"write it as {clock[1]}:{clock[2]}.{clock[3]}: minutes:seconds.hundredths"
            return CellError("is not a number", hint)
        meant, cause = "", "fractions"
        if pair and kind == "number":
            meant = f"did you mean {min(pair)}/{max(pair)}? "
        elif pair:
            # Where a comma is the decimal sign, 20.1 becomes the 20th of January.
            meant, cause = f"did you mean {pair[0]}.{pair[1]}? ", "numbers with a point"
        hint = f"{meant}A spreadsheet does that to {cause}: make the cells text first"
        return CellError("is a date, not a number", hint, CELL_BECAME_A_DATE)
    mended = plain.translate(_MISTYPED)
    number = re.sub(r"^(?:~|≈|ca\.?|about|approx\.?)\s*", "", plain)
    for candidate in (number, mended, mended.rstrip(".,;"), re.sub(r"([.,])[.,]+", r"\1", mended)):
        bare = take_apart(candidate) if candidate != plain else None
        if bare and bare.unit is None and bare.spread is None:
            return CellError("is not a number", f"did you mean {candidate}?")
    if kind == "mass" and re.fullmatch(r"[A-ZА-Я][1-9]?|[mM]_?[1-9]", text):
        hint = f'write in each row the mass that it stands for, with its unit: if "{text}" is 20.1 g, write 20.1 g'
        return CellError("is not a number, but the name of a weight", hint)
    if re.fullmatch(r"[-+]?[0-9]{1,3}(?:[ .,'][0-9]{3})+(?:[.,][0-9]*)?", plain):
        return CellError("is not a number", "write it without marks between the thousands")
    if re.fullmatch(r"[0-9]+\s*(?:a|o|st|nd|rd|th|er|e|ème|ой|ый|я)\.?", lower) or "ª" in text or "º" in text:
        return CellError("is an ordinal, not a number", "write how many, as 1, 2.5 or 1/3")
    closer = plain.replace(" (", "(")
    if closer != plain and (bracket := take_apart(closer)) and bracket.spread:
        return CellError("is not a number", f"write {closer} if the bracket is its uncertainty")
    if written is not None and written.unit and not written.named:
        return CellError(f'is not a number with a unit: "{written.unit}" is no unit known here')
    return CellError("is not a number")


@lru_cache(maxsize=16384)
def check_value(role: str, value: float) -> tuple[str, str]:
    """Say what is wrong with a number that cannot be, and what to type; two empty texts if nothing is."""
    if not math.isfinite(value):
        return "is too large", ""
    bound = BY_NAME[role].bound if role in BY_NAME else ""
    broken = {
        "above zero": (value <= 0, "is not above zero"),
        "not zero": (value == 0, "is zero"),
        "not below zero": (value < 0, "is below zero"),
        "below 90 degrees": (abs(value) >= math.pi / 2, "is not between -90 and 90 degrees"),
    }
    wrong, fault = broken.get(bound, (False, ""))
    if wrong:
        return fault, BY_NAME[role].bound_hint
    kind = kind_of_role(role)
    low, high = LIMITS.get(kind, (0.0, math.inf))
    if value == 0 or low <= abs(value) <= high:
        return "", ""
    fault = f"is too {'large' if abs(value) > high else 'small'} for {KINDS[kind].words} in a lab"
    return fault, f"is its unit the one written? Read are {low:g} to {high:g} {SI[kind]}".rstrip()


PREFIX = "reported_"
REPORTED_KINDS = {"inertia": "inertia", "imbalance": "torque", "timing_bias": "time", "exponent": "number"}
"""Kind of quantity of what a lab's report usually states; of anything else, the unit written tells it."""

Fault = Literal["unreadable", "no unit", "wrong unit", "given twice"]


class Reported(Struct, frozen=True):
    """One value that a student reports, as far as it can be read.

    Attributes
    ----------
    key : str
        What it is: ``inertia``, ``imbalance``, …
    text : str
        As written.
    value : float or None
        [SI unit of its kind]; where no unit is written, the number taken as SI. None where the number or its unit
        cannot be read.
    u : float or None
        Its standard uncertainty [SI unit of its kind], that is what is stated divided by a k written behind it; None
        where none is stated.
    number : float or None
        The number as written, before any unit.
    unit : str or None
        As written; None where there is none.
    digits : int or None
        Significant digits of the value; zeros at its end count behind the point, where they say something.
    u_digits : int or None
        Those of the uncertainty.
    step : float or None
        One step of the value's last digit [SI unit of its kind].
    u_step : float or None
        One step of the uncertainty's last digit [SI unit of its kind]; None where it is stated in %.
    fault : {"unreadable", "no unit", "wrong unit", "given twice"} or None
        What is wrong, in a word.
    problem : str or None
        What is wrong, in a sentence; None exactly where `fault` is.
    line : int or None
        Where it stands in its file, 1-based.
    """

    key: str
    text: str
    value: float | None = None
    u: float | None = None
    number: float | None = None
    unit: str | None = None
    digits: int | None = None
    u_digits: int | None = None
    step: float | None = None
    u_step: float | None = None
    fault: Fault | None = None
    problem: str | None = None
    line: int | None = None


_LARGEST = 1e100


def canonical_key(key: str) -> str:
    """Name what is reported: ``reported_I_zz`` and ``reported_moment_of_inertia`` are ``inertia``."""
    bare = key[len(PREFIX) :] if key.lower().startswith(PREFIX) else key
    return "inertia" if name_roles(bare)[0] == ("inertia",) else bare.lower()


def read_reported(key: str, text: str, line: int | None = None, ask: bool = True) -> Reported:
    """Read one reported value: ``4.4e-3 ± 0.1e-3 kg m^2``, ``(4.4 ± 0.1) × 10⁻³ kg m²`` or ``4.4(1) g m^2``."""
    read = Reported(canonical_key(key), text.strip(), line=line)
    written = take_apart(read.text)
    if written is None:
        return replace(read, fault="unreadable", problem=f'"{read.text[:60]}" is not a number with its unit')
    spread = None if written.spread is None else to_float(written.spread)
    if not max(abs(written.value), abs(spread or 0.0)) <= _LARGEST:
        return replace(read, fault="unreadable", problem=f'"{read.text[:60]}" is too large for a number')
    read = replace(
        read,
        number=written.value,
        unit=written.unit and _as_written(written.unit, read.text),
        digits=None if written.step is None else _digits(written.number),
        u_digits=_digits(written.spread) if written.spread else None,
    )
    if spread is not None and spread < 0:
        return replace(read, fault="unreadable", problem="the uncertainty is negative")
    kind = REPORTED_KINDS.get(read.key) or next((kind for kind in SI if kind in kinds_of(written.unit or "")), None)
    if kind is None and written.unit is not None:
        return read  # nothing that this tool knows; the text says it all
    kind = kind or "number"
    if ask and (ways := doubtful_comma(written, kind, SI[kind])):
        return replace(read, fault="unreadable", problem=f'"{read.text[:60]}" can mean {ways}')
    try:
        quantity = in_si(written, kind, SI[kind])
        factor = parse_unit(written.spread_unit or written.unit or SI[kind], kind).factor
    except UnitError as error:
        return replace(read, fault="wrong unit", problem=str(error))
    u = None if quantity.uncertainty is None else quantity.uncertainty.at(quantity.value)
    u_step = None if written.spread is None or written.percent else 10.0 ** last_place(written.spread) * factor
    read = replace(read, value=quantity.value, u=u, step=quantity.step, u_step=u_step)
    if written.unit is None and SI[kind]:
        problem = f'"{read.text[:60]}" has no unit: write one behind it, such as {KINDS[kind].examples}'
        return replace(read, fault="no unit", problem=problem)
    return read


_HUGE = 1e30  # a number above this, or below one over it, is no moment of inertia [kg*m^2]


def usable_inertia(reported: Reported | None) -> Reported | None:
    """Take the number of a report without a usable unit as kg·m²: the unit is judged once, by itself."""
    if reported is None:
        return None
    if reported.value is None and reported.unit:
        again = read_reported("inertia", reported.text.replace(reported.unit, "kg*m^2"))
        reported = replace(reported, value=again.value, u=again.u, step=again.step, u_step=again.u_step)
    sizes = [abs(size) for size in (reported.value, reported.u) if size]
    if reported.value is None or all(1 / _HUGE <= size <= _HUGE for size in sizes):
        return reported
    return replace(reported, value=None, problem=f'"{reported.text[:60]}" is far from any moment of inertia')


_ANSWER_FOLLOWS = r"(?i)(?:[=:≈|\t]|\bis\b)\s*(?=[-+(~≈\s]*[.\d]|(?:about|ca\.?|approx\S*)\s)"
_OF_OTHERS = r"(?i)theor|liter|manual|expect|nominal|refer|textbook|accept|true|given|simulat"
_CUTS = r"[,;.)|]?\s+|[.,;|]*$"
_LONGEST_ANSWER = 300
_PLAIN_WORDS = str.maketrans("_", " ", "{}*$`")


def find_inertia(line: str) -> str:
    """Find I_zz in a line of a report, ``Our result: I_zz = 4.4e-3 ± 0.1e-3 kg m^2``; "" where there is none.

    Its name must stand before it, and its unit behind it; "I_zz" and "moment of inertia" alone do without.
    """
    if len(line) > _LONGEST_ANSWER or not re.search(r"\d", line):
        return ""
    for mark in re.finditer(_ANSWER_FOLLOWS, line):
        before, rest = line[: mark.start()], line[mark.end() :]
        if re.search(_OF_OTHERS, before):
            return ""
        if unit := re.search(r"[\[(]([^\])]*)[\])][\s*_`$]*$", before):
            before = before[: unit.start()]
        words = re.findall(r"[^\W\d][\w'’]*", before.translate(_PLAIN_WORDS))
        names = (" ".join(words[-count:]) for count in (3, 2, 1) if len(words) >= count)
        name, roles = next(((name, roles) for name in names if (roles := name_roles(name)[0])), ("", ()))
        if roles != ("inertia",):
            continue
        whole = rest.strip(" \t*_`$|")
        if unit and kinds_of(unit[1]) and (plain := take_apart(whole)) and not plain.unit:
            whole = f"{whole} {unit[1]}"
        for cut in reversed(list(re.finditer(_CUTS, whole))):
            answer = whole[: cut.start()].rstrip(" *`$_")
            if read_reported("inertia", answer).fault is None:
                return answer
        if len(name) > 1 and read_reported("inertia", whole).fault == "no unit":
            return whole
    return ""


def find_in_row(cells: Sequence[str]) -> tuple[int, str] | None:
    """Find I_zz in a row of a table, "I_zz", "4.4e-3 ± 0.1e-3 kg m^2" or both in one cell: where, and the value."""
    for at, cell in enumerate(cells):
        if cell[:1].isalpha():
            alone = "=" in cell or ":" in cell
            if not alone and at == len(cells) - 1:
                break
            if answer := find_inertia(cell if alone else f"{cell}: {' '.join(filter(None, cells[at + 1 :]))}"):
                return at, answer
    return None


def one_inertia(found: list[tuple[str, Reported]]) -> tuple[str, Reported] | None:
    """Take what all places of a report, each named, give for I_zz; two that differ are no answer."""
    # The one that says most of it, where several give one value.
    places = sorted(found, key=lambda one: (one[1].u is None, one[1].fault is not None))
    if not places:
        return None
    place, first = places[0]
    for other, reported in places[1:]:
        if (reported.value, reported.u or first.u) != (first.value, first.u):
            problem = f'two values are found: "{first.text}" in {place} and "{reported.text}" in {other}'
            return place, Reported("inertia", first.text, fault="given twice", problem=problem, line=first.line)
    return place, first


def _as_written(unit: str, text: str) -> str:
    """Find how the student spelled a unit that was read in folded letters."""
    # A unit behind the last part is behind the whole.
    ends = re.split(r"±|\+\s?/\s?-|\+-", text)[::-1]
    return next((end[i:].strip() for end in ends for i in range(len(end)) if fold_number(end[i:]) == unit), unit)


def _digits(number: str) -> int:
    """Count significant digits, those of ``0.0044`` as of ``4.4e-3``; zeros before the point may only fill up."""
    mantissa = re.split("[eE]", number)[0]
    digits = re.sub("[^0-9]", "", mantissa).lstrip("0")
    return len(digits if re.search("[.,]", mantissa) else digits.rstrip("0")) or 1
