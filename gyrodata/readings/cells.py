"""Read the cells of one column as quantities, each with its uncertainty.

Dashes and colons are replaced first by the quantities that they mean.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from fractions import Fraction

from msgspec import Struct

from gyrodata.base import diagnostics
from gyrodata.quantities import misreadings, notation, numerals, units
from gyrodata.quantities.notation import Quantity, read_cell
from gyrodata.quantities.numerals import fold_number, has_digit, to_float
from gyrodata.quantities.units import Uncertainty, UnitError, kinds_of
from gyrodata.readings import layout, roles
from gyrodata.readings.grid import is_number
from gyrodata.readings.lablog import BLANKS, UNKNOWN, Faults, Text
from gyrodata.readings.layout import MOST_TURNS, Chosen
from gyrodata.readings.names import NAMES, Header, fold_name, word_set, words_of
from gyrodata.readings.notes import altered_role
from gyrodata.readings.roles import kind_of_role
from gyrodata.readings.turns import MARK, mark_turns, turns_in, words_of_turns

_REMARK = re.compile(r"([-+]?[.,]?[0-9][^()]*?)(?:(?<!\s)\s+)?\([^\W\d][^()\d=±%]*\)")
"""A number with a remark: "8.83 (maybe late)"."""
_NO_WEIGHT = word_set("no_weight")

_TURN_BEHIND = re.compile(rf"(?i)(.*?)(?:(?<!\s)\s+)?(?:of\s+)?(?:an?\s+)?{MARK}\w*\.?")
_PARTS = frozenset({f"1/{n}" for n in range(2, 10)} | {"2/3", "3/4"})
"""Parts of a turn that a column can count."""
_PERCENT = "1/100"
_TOO_LARGE: dict[tuple[str, str | None], float] = {
    ("time", "min"): 600.0,
    ("angle", "rad"): 60.0,
    ("turns", ""): MOST_TURNS,
}
"""Value [SI] that is too large for one run, by role and unit."""
_COUNTED = (*roles.COUNTS, "spin_turns")
_IN_WORDS = ("mass", "turns", "spin_turns")
"""Roles whose numbers may be written in words."""


# The meaning of a text


def number_in_words(text: str, role: str) -> str:
    """Return the number that a cell writes in words; else "".

    Examples are "none" of a mass, and "one third" or "120°" of turns.
    """
    if role != "mass":
        return fraction_of_date(text) or _turns_in_words(text) or _turns_of_angle(text)
    return "0 g" if fold_name(text) in _NO_WEIGHT else ""


def _turns_in_words(text: str) -> str:
    """Read "one third", "1/3 of a turn" or "turn"."""
    match = _TURN_BEHIND.fullmatch(mark_turns(text))
    if match is None:
        return words_of_turns(text, whole=True)
    bare = match[1]
    if words := words_of_turns(bare, whole=True):
        return words
    if not bare:
        return "1"
    if numerals.take_apart(bare) is None:
        return ""
    return bare


def _turns_of_angle(text: str) -> str:
    written = numerals.take_apart(text)
    if written is None or written.spread is not None:
        return ""
    if kinds_of(written.unit or "") == {"angle"}:
        return turns_in(text)
    return ""


def fraction_of_date(text: str) -> str:
    """Return the fraction of which a spreadsheet made a date; "" for other texts.

    "3-Jan" and "01. Mrz" are 1/3.
    """
    low, high = sorted(misreadings.date_pair(text) or (0, 0))
    is_one_part = low == 1 and high <= 12
    if is_one_part or (low, high) == (2, 3):
        return f"{low}/{high}"
    return ""


def rounded_turns(text: str, value: float) -> tuple[str, float]:
    """Return the fraction that was rounded to 0.33 or 0.7; `value`: the turns.

    The function also returns half of the rounding's width. The result is ("", 0) for
    other numbers.

    The screws of the ball are a third of a turn apart; a run without a weight takes a
    twelfth.
    """
    if not numerals.PLAIN.fullmatch(text):
        return "", 0.0
    place = numerals.last_place(text)
    typed = to_float(text)
    if math.isclose(typed, 100 * value):
        place -= 2  # 33.3 %
    elif not math.isclose(typed, value):
        return "", 0.0  # a count of thirds
    # Whole turns are meant as written.
    if place >= 0:
        return "", 0.0
    step = float(f"1e{place}")
    twelfths = round(value * 12)
    change = abs(value - twelfths / 12)
    # Quarters have few digits: they are meant as written. 2/3 cut off at 0.66 is wrong
    # by nearly a whole step.
    if twelfths % 3 == 0 or change >= step:
        return "", 0.0
    return str(Fraction(twelfths, 12)), step / math.sqrt(3)


def part_counted(header: Header) -> str:
    """Return the part of a turn that a column of turns counts; "" for whole turns.

    It is "1/3" for "number of thirds", "1/2" for "half turns", and "1/100" for "%".
    """
    if header.unit == "%" or "%" in header.text:
        return _PERCENT
    if not header.turns and header.text.lower() in NAMES:
        return ""
    stated = header.turns or words_of_turns(header.text)
    if stated:
        return stated if stated in _PARTS else ""
    words = words_of(header.text)
    named = {words_of_turns(word, whole=True) for word in words} & _PARTS
    if len(named) == 1:
        return named.pop()
    return ""


# Dashes and colons

_DASHES = BLANKS - UNKNOWN - {""}
_MOST_DASHES = 0.25
"""If a larger share of the cells has a dash, it means "as above" [1]."""


def meant_texts(
    column: Chosen,
    unit: str | None,
    table: layout.Layout,
    positions: tuple[str, ...],
    faults: Faults,
) -> list[str]:
    """Return the texts of a column, as the quantities that they mean."""
    texts = list(column.texts)
    if column.role in roles.TIMINGS:
        if any(map(is_number, texts)):
            # Words between numbers, such as "aborted", are left out.
            texts = [text if has_digit(text) else "" for text in texts]
    elif column.role == "mass" and not _DASHES.isdisjoint(texts):
        texts = _with_zero_for_dashes(texts, positions)
    if column.header.unit == "s" and ":" in fold_number(" ".join(texts)):
        _ask_for_colons(column, texts, table, faults)
    return texts


def _with_zero_for_dashes(texts: list[str], positions: tuple[str, ...]) -> list[str]:
    """Read a dash without a position as "no weight"; in many rows it is "as above"."""
    dashed = {
        i
        for i, text in enumerate(texts)
        if text in _DASHES and (not positions or positions[i] in BLANKS)
    }
    if len(dashed) > _MOST_DASHES * len(texts):
        return texts
    return ["0" if i in dashed else text for i, text in enumerate(texts)]


def _ask_for_colons(
    column: Chosen, texts: list[str], table: layout.Layout, faults: Faults
) -> None:
    """Ask whether 10:06 below a header in seconds is 10.06 s or ten minutes.

    "mm:ss" in the header says what its cells are.
    """
    clocks = list(filter(_is_clock, texts))
    if not clocks or ":" in column.header.text:
        return
    first = clocks[0]
    row = texts.index(first)
    cell = table.cell_of(column, row)
    name = column.header.text.partition("[")[0].strip()
    meant = ".".join(first.rsplit(":", 1))
    faults.add("colon", cell, role=column.role, name=name, first=first, meant=meant)


def _is_clock(text: str) -> bool:
    """Return whether a text is two or three whole numbers with colons: 13:06."""
    *parts, last = fold_number(text).split(":")
    are_digits = all(part.isdecimal() and len(part) <= 3 for part in (*parts, last))
    return are_digits and len(parts) in (1, 2) and len(last) == 2


# The cells of a column


class Wrong(Struct, frozen=True):
    """The fault of a text, and the text to type instead."""

    code: str
    fault: UnitError | str
    hint: str


class DecimalSigns(Struct, frozen=True):
    """The decimal signs of a table."""

    typed: set[str]
    """Those of its numbers that cannot separate thousands."""
    expected: set[str]
    """Those that the delimiter allows as well."""

    def may_separate_thousands(self, text: str) -> bool:
        """Return whether the comma or the point in "1,284" may separate thousands."""
        if numerals.may_have_thousands(text):
            return self.expected != {","}
        return self.typed == {","} and numerals.may_have_thousands(text, ".")


class CellReader:
    """Reads each text of a column once."""

    def __init__(
        self, column: Chosen, unit: str | None, signs: DecimalSigns, faults: Faults
    ) -> None:
        self.column = column
        self.unit = unit
        self.signs = signs
        self.faults = faults
        self.role = column.role
        self.kind = kind_of_role(column.role)
        self.read: dict[str, Quantity] = {}
        """Quantity of each text that can be read."""
        self.wrong: dict[str, Wrong] = {}
        """What is wrong with each other text."""
        self.lacks_unit = False
        """Whether neither the header nor a cell has a unit."""
        self.finest: dict[str, float] = {}
        """Finest step of a digit of each unit [SI unit of the role].

        A spreadsheet drops zeros at the end: the finest digit in the column shows how
        all were read."""

    def read_all(self, texts: list[str]) -> None:
        """Read all texts."""
        for text in dict.fromkeys(texts):
            if text not in BLANKS and not self.lacks_unit:
                self._read_one(text)
        if self.role in _COUNTED and (part := part_counted(self.column.header)):
            self._count_parts(part)
        large = self._too_large()
        if large and large[0] not in self.wrong:
            self._ask_for_likelier_unit(large)
        for quantity in self.read.values():
            if quantity.step is not None:
                finest = self.finest.get(quantity.unit, math.inf)
                self.finest[quantity.unit] = min(quantity.step, finest)

    def _read_one(self, text: str) -> None:
        try:
            quantity = self._quantity(text)
        except UnitError as error:
            self.lacks_unit = error.code == diagnostics.UNIT_MISSING
            is_word = not any(map(str.isdigit, text))
            missed = "; or put # before the line of a run that was not measured"
            hint = error.hint + missed * is_word
            self.wrong[text] = Wrong(error.code, error, hint)
            return
        self.read[text] = quantity
        fault, hint = roles.check_value(self.role, quantity.value)
        if fault:
            self.wrong[text] = Wrong(diagnostics.NUMBER_IMPOSSIBLE, fault, hint)

    def _quantity(self, text: str) -> Quantity:
        ask = self.signs.may_separate_thousands(text)
        if ask:
            # Raises an error that asks; `read_cell` asks about commas alone.
            read_cell(text.replace(".", ","), self.kind, self.unit, doubt_comma=True)
        is_word = self.role in _IN_WORDS and not _is_number_or_fraction(text)
        number = number_in_words(text, self.role) if is_word else ""
        try:
            return read_cell(number or text, self.kind, self.unit, ask)
        except UnitError:
            without = self._without_remark(text)
            if not without:
                raise
            try:
                return read_cell(without, self.kind, self.unit, ask)
            except UnitError:
                pass  # the fault of the whole text says more
            raise

    def _without_remark(self, text: str) -> str:
        """Return a number without the remark behind it; "" if this may change it."""
        remark = _REMARK.fullmatch(text)
        if remark is None or turns_in(text):
            return ""
        return "" if altered_role(f"{self.role}: {text}") else remark[1]

    def _count_parts(self, part: str) -> None:
        """Read whole numbers below "half turns" as halves, and below "%" as percent.

        Fractions are turns already.
        """
        if not self.read:
            return
        if part == _PERCENT:
            are_counts = all(map(numerals.PLAIN.fullmatch, self.read))
        else:
            values = [quantity.value for quantity in self.read.values()]
            are_counts = all(map(float.is_integer, values))
        if not are_counts:
            return
        shown = []
        for text, quantity in self.read.items():
            turns = _times(part, quantity.value)
            shown.append(f"{text} is {turns}")
            self.read[text] = read_cell(turns, "number", "")
        said = "; ".join(shown[:4])
        self.faults.add("parts_of_turns", self.column.cell, said=said)

    def _too_large(self) -> list[str]:
        """Return the numbers without a unit of their own that no run reaches."""
        most = _TOO_LARGE.get((self.role, self.unit), math.inf)
        return [
            text
            for text, quantity in self.read.items()
            if quantity.value > most and numerals.PLAIN.fullmatch(text)
        ]

    def _ask_for_likelier_unit(self, large: list[str]) -> None:
        """Ask for the unit of numbers that are too large in the unit of the header.

        Seconds below "min" and degrees below "rad" make an answer that looks
        impossible, so a warning is enough. Degrees or percent below turns may not: this
        is an error, unless the header names turns itself.
        """
        cell = self.column.cell
        first = large[0]
        if self.role != "turns":
            likely = "s" if self.role == "time" else "deg"
            values = {"role": self.role, "unit": self.unit, "likely": likely}
            self.faults.add("unit_unlikely", cell, text=first, **values)
        elif all(map(_may_be_degrees, large)):
            part = str(Fraction(int(first), 360))
            self.faults.add("turns_or_degrees", cell, text=first, part=part)
        elif self.column.header.roles != ("turns",):
            self.faults.add("turns_unlikely", cell, text=first)

    def fractions_of_dates(self) -> list[str]:
        """Return the texts read as fractions of which a program made dates."""
        if self.kind != "number":
            return []
        return list(filter(fraction_of_date, self.read))


def _is_number_or_fraction(text: str) -> bool:
    """Return whether a text is a number, or a fraction such as 1/3."""
    above, slash, below = text.partition("/")
    is_fraction = slash and above.isdecimal() and below.isdecimal()
    return bool(is_fraction) or numerals.PLAIN.fullmatch(text) is not None


def _may_be_degrees(text: str) -> bool:
    return text.isdecimal() and int(text) % 15 == 0


def _times(part: str, count: float) -> str:
    if part == _PERCENT:
        return f"{count / 100:.9g}"
    return str(Fraction(part) * int(count))


class Uncertainties(Struct, frozen=True):
    """The ``u_…`` columns of a table, and the ``u_…`` of the log."""

    table: layout.Layout
    columns: Mapping[str, list[Chosen]]
    """Columns in use, by role."""
    of_log: Mapping[str, Uncertainty]
    """Uncertainty of each ``u_…`` that is valid for the whole log."""

    def of_role(
        self, role: str, column: Chosen | None, unit: str | None, faults: Faults
    ) -> list[Uncertainty | None]:
        """Return the u of each reading.

        It is that of its ``u_…`` column, else the ± of the header, else the ``u_…`` of
        the log.
        """
        common = roles.stated_u(role, self.of_log)
        if column and column.header.spread:
            common = _read(column, column.header.spread, unit or "", faults)
        spreads = [common] * len(self.table.rows)
        keys = [key for key in roles.u_keys(role) if key in self.columns]
        if keys:
            own = self.columns[keys[0]][0]
            is_same_kind = kind_of_role(own.role) == kind_of_role(role)
            unit = own.header.unit or (unit if is_same_kind else None)
            self._read_column(own, role, unit, spreads, faults)
        return spreads

    def _read_column(
        self,
        column: Chosen,
        role: str,
        unit: str | None,
        spreads: list[Uncertainty | None],
        faults: Faults,
    ) -> None:
        """Replace the uncertainties of the readings that have their own in a column."""
        if unit is None and kind_of_role(column.role) != "number":
            ask_for_unit(column, faults)
            return
        percent = " %" if unit == "%" else ""
        unit = "" if percent else unit or ""
        if _read(column, f"0{percent}", unit, faults) is None:
            return
        for i, text in enumerate(column.texts):
            if text in BLANKS:
                continue
            cell = self.table.cell_of(column, i)
            typed = text if "%" in text else text + percent
            u = _read(column, typed, unit, faults, cell)
            spreads[i] = u and roles.as_u_of(role, column.role, u)


def _read(
    column: Chosen,
    text: str,
    unit: str,
    faults: Faults,
    cell: Text | None = None,
) -> Uncertainty | None:
    """Read one uncertainty; None, with an error at its cell or header, if it fails."""
    try:
        kind = kind_of_role(column.role)
        return notation.parse_uncertainty(text, kind, unit, doubt_comma=False)
    except UnitError as error:
        values = {"role": column.role, "header": column.text, "error": error}
        faults.add("uncertainty", cell or column.cell, **values)
        return None


def ask_for_unit(column: Chosen, faults: Faults) -> None:
    """Ask for the unit of a column of which neither the header nor a cell has one."""
    kind = kind_of_role(column.role)
    role = column.role
    examples = units.KINDS[kind].examples
    if role == "mass":
        examples += ", N for a weight"
    filled = column.filled()
    are_digits = all(len(text) == 1 and text.isdigit() for text in filled)
    is_numbered = are_digits and role in ("mass", "position")
    name = "no_unit_but_numbers" if is_numbered else "no_unit"
    values = {"text": column.header.text[:60], "role": role, "units": examples}
    faults.add(name, column.cell.place, kind=units.KINDS[kind], **values)
