"""The elements of a report: numbers, sentences, tables, figures and sections.

Each format has its own writer.

The text in them is plain, whatever it contains: each writer escapes it. Each number
names its place in results.json.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from copy import copy
from string import Formatter
from typing import Any, Literal

from msgspec import Struct
from msgspec.structs import replace

from gyrodata.base.errors import shown
from gyrodata.fitting.inertia import Estimate
from gyrodata.reporting import values
from gyrodata.reporting.values import NUMBER, Scale
from gyrodata.results import UNITS_OF_RUNS, Analysis, is_wide


class Number(Struct, frozen=True):
    """A number of results.json as it is shown: a value, a value ± u, or an interval.

    Or a name from the log.
    """

    shown: tuple[str, ...]
    """The digits: one text, or two for ± and for an interval."""
    places: tuple[str, ...]
    """Place of each in results.json, below "result"; a place with a leading "/" starts
    at the top."""
    scale: Scale = NUMBER
    size: float = 1.0
    """The value of a displayed 1 in the unit of results.json."""
    exponent: int = 0
    """Power of ten after the digits, in addition to that of the scale."""
    between: Literal[" ± ", " to "] = " ± "
    """An interval is "4.32 to 4.56"."""
    unit: bool = True
    """False in a cell: the head of the column contains the unit."""

    def write(self, texts: Sequence[str]) -> str:
        """Join the digits, as they are written in one format, and the unit."""
        text = self.between.join(texts)
        if self.exponent:
            text = f"({text}) × {values.ten_to(self.exponent)}"
        return values.with_unit(text, self.scale) if self.unit else text

    def __str__(self) -> str:
        return self.write(self.shown)


class Styled(Struct, frozen=True):
    """Text in a style: "strong", "warn" (another colour), "code", "quote" or "typed".

    Text from the log is "typed", or a "quote", which has quotation marks on the page:
    in the name "team b", the letter is no symbol.
    """

    text: str
    style: str

    def __str__(self) -> str:
        return self.text


class Mark(Struct, frozen=True):
    """The marker of a torque in the figures; formats without colours omit it."""

    group: int
    """Index of the torque."""

    def __str__(self) -> str:
        return ""


SYMBOLS = re.compile(
    r"(?<![\w&#])(?:b(?!\))|[knpuLM]|m g x|m r(?=²))(?=[²ⁿ]|[^\w;']|$)"
)
"""Letters that mean a quantity in the words of the tool: the "M" and the "u" of "M0
moves M by 2 u". A format may set them in italics. Texts from the log are `Styled`."""

Part = str | Number | Styled | Mark
Sentence = tuple[Part, ...]
NOTHING: Sentence = ("–",)
"""An empty cell in a column of numbers."""
Cell = Number | Sentence | str | None
"""What a column contains in one row; None if it has nothing to say."""


def say(words: str, *parts: Part | Sentence, **named: Part | Sentence) -> Sentence:
    """Return a sentence with the parts in the places of "{}" or "{name}".

    A text from a log is always a part.
    """
    unnamed = list(parts)
    sentence: list[Part] = []
    for text, name, _, _ in Formatter().parse(words):
        sentence.append(text)
        # There is no name after the last placeholder.
        if name is not None:
            part = named[name] if name else unnamed.pop(0)
            sentence += part if isinstance(part, tuple) else (part,)
    assert not unnamed, words
    return tuple(part for part in sentence if part != "")


def join_sentences(sentences: Iterable[Sentence], between: str = " ") -> Sentence:
    """Return sentences as one, with a text between them."""
    joined: list[Part] = []
    for sentence in sentences:
        joined += [between, *sentence] if joined else sentence
    return tuple(joined)


def plain(sentence: Sentence) -> str:
    """Write a sentence as text."""
    return "".join(map(str, sentence))


def message_words(message: str) -> Sentence:
    """Return a message of the tool; what it quotes from the log stays as typed."""
    pieces = message.split('"')
    if len(pieces) % 2 == 0:
        # A single quotation mark does not show what is quoted.
        return (Styled(message, "typed"),)
    parts: list[Part] = list(pieces)
    parts[1::2] = [Styled(f'"{quoted}"', "typed") for quoted in pieces[1::2]]
    return tuple(parts)


def one_line(text: str) -> str:
    """Return a text as `shown`, with a blank at each end that has one."""
    # The bars keep the blanks.
    return shown(f"|{text}|")[1:-1]


class Head(Struct, frozen=True):
    """The head of a column."""

    words: str
    scale: Scale | None = None
    """Unit of the numbers in the column; None for a column of texts. The first cell
    that is a number sets it."""
    wrap: float = 0.0
    """Part of the line that a column of long texts may use; 0 for a column as wide as
    its cells."""
    bars: bool = False
    """True if the page draws the values, from 0 to 1, as bars next to the column."""
    compared: Estimate | None = None
    """The page draws each number of the column next to this one."""
    page_only: bool = False
    """True if the column is too wide for a terminal."""

    def __str__(self) -> str:
        unit = str(self.scale or "")
        return f"{self.words} [{unit}]" if unit else self.words


class Table(Struct, frozen=True):
    """A table with one row of heads."""

    heads: Sequence[Head]
    rows: Sequence[Sequence[Sentence]]
    caption: str
    main: int | None = None
    """The most important row."""
    odd: Sequence[int] = ()
    """Rows of suspected outliers."""


def table(
    heads: Sequence[Head | str],
    rows: Iterable[Sequence[Cell]],
    caption: str,
    main: int | None = None,
    odd: Sequence[int] = (),
) -> Table:
    """Return a table without the columns that are empty in every row.

    The head of a column contains the unit.
    """
    kept_heads = []
    columns = []
    for words, *cells in zip(heads, *rows, strict=True):
        if cells.count(None) == len(cells):
            continue
        head = words if isinstance(words, Head) else Head(words)
        scales = (cell.scale for cell in cells if isinstance(cell, Number))
        head = replace(head, scale=next(scales, head.scale))
        kept_heads.append(head)
        columns.append([_in_column(cell, head) for cell in cells])
    kept_rows = list(zip(*columns, strict=True))
    return Table(kept_heads, kept_rows, caption, main, odd)


def _in_column(cell: Cell, head: Head) -> Sentence:
    """Write a cell; the head of its column contains the unit."""
    if isinstance(cell, Number):
        return (replace(cell, unit=False),)
    empty = NOTHING if head.scale else ()
    return say("{}", cell or empty)


class Text(Struct, frozen=True):
    """Paragraphs, or the items of a list."""

    sentences: Sequence[Sentence]
    kind: str = ""
    """Lists are "list" and "numbered"; paragraphs can be "result", "small", "task"
    or "warning"."""


def paragraph(
    words: str, *parts: Part | Sentence, kind: str = "", **named: Part | Sentence
) -> Text:
    """Return a paragraph of one sentence; see `say`."""
    return Text((say(words, *parts, **named),), kind)


class Picture(Struct, frozen=True):
    """One of the figures, in formats that show figures."""

    name: str
    caption: str


Block = Text | Table | Picture


class Section(Struct, frozen=True):
    """A heading with its blocks in order."""

    title: str
    blocks: tuple[Block, ...]
    anchor: str
    """The target of links."""
    folded: bool = False
    """True for details that the page shows after a click."""


class Report(Struct, frozen=True):
    """Everything that is said of one analysis."""

    numbers: Numbers
    size: Sentence
    """Of the log: "10 runs, 4 torques"."""
    title: Sentence
    byline: Sentence
    """Author, partners, course and date, if the log gives them."""
    read_as: Sentence
    """One run in words, which shows a wrong unit or origin."""
    doubts: tuple[Sentence, ...]
    """Reasons not to rely on the answer."""
    answer: Sentence
    top: tuple[Block, ...]
    """Below the answer, before the first section."""
    sections: tuple[Section, ...]


class Numbers:
    """The numbers of an analysis, as the report shows them.

    Parameters
    ----------
    analysis : Analysis
        Its JSON is the source of every number.

    Attributes
    ----------
    is_worksheet : bool
        Whether the report asks questions in the place of conclusions.
    """

    def __init__(self, analysis: Analysis) -> None:
        self.analysis = analysis
        of_log = analysis.readings.metadata.get("worksheet")
        self.is_worksheet = analysis.options.worksheet or of_log == "yes"
        self.document = analysis.to_dict()
        self.record: Any = self.document["result"]
        self.above = ""
        self.inertia = values.inertia_scale(analysis.inertia.value, analysis.inertia.u)
        # One unit for all torques, so that they can be compared.
        largest = max(abs(run.torque) for run in analysis.run_table)
        self.torque = values.MICRONEWTON_METRE
        if largest >= 10:
            self.torque = values.NEWTON_METRE
        elif largest >= 1e-4:
            self.torque = values.MILLINEWTON_METRE
        self.scales = {
            "kg*m^2": self.inertia,
            "N*m": self.torque,
            "rad^2/s^2": values.PRODUCT,
            "kg*m^2/s": values.ANGULAR_MOMENTUM,
            "rad/s": values.RATE,
            "s": values.SECOND,
            "1": NUMBER,
        }

    def at(self, place: str) -> Numbers:
        """Return the numbers of one record, with their places below it."""
        numbers = copy(self)
        numbers.record = self.find(place)
        numbers.above = f"{self.above}{place}."
        return numbers

    def each(self, place: str) -> Iterator[Numbers]:
        """Yield the numbers of each record of a list."""
        for i in range(len(self.find(place))):
            yield self.at(f"{place}.{i}")

    def find(self, place: str) -> Any:
        """Return what results.json contains at a place; "length" counts a list.

        The parts of null are null too.
        """
        value: Any = self.document if place.startswith("/") else self.record
        for key in place.removeprefix("/").split("."):
            if key == "length":
                return len(value)
            if value is None:
                return None
            value = value[int(key) if isinstance(value, list) else key]
        return value

    def cell(
        self, place: str, show: Callable[..., Cell] | None = None, *how: str | Scale
    ) -> Cell:
        """Show the value at a place, or with another method; None if it is null."""
        if self.find(place) is None:
            return None
        method: Callable[..., Cell] = show or self.value
        return method(place, *how)

    def value(
        self,
        place: str,
        scale: Scale | None = None,
        u: bool = True,
        step: float = 0.0,
    ) -> Number:
        """Show the value at a place with its standard uncertainty: "4.42 ± 0.03 mm".

        The standard uncertainty is the neighbour "u" of a "value" or an "exponent", and
        "mass_u" of "mass". A value without it is shown to the last digit that was read.

        Parameters
        ----------
        place : str
            A number in SI units.
        scale : Scale, optional
            The unit to use; by default that of the estimate or of the column of runs.
        u : bool
            False to omit the standard uncertainty.
        step : float
            One step of the last digit of a reading [SI unit]; 0 if it is unknown.

        Returns
        -------
        Number
        """
        value = self.find(place)
        record, dot, name = place.rpartition(".")
        estimate = self.find(record) if record else self.record
        name_of_u = "u" if name in ("value", "exponent") else f"{name}_u"
        spread = estimate.get(name_of_u) if u else None
        if scale is None:
            unit = estimate.get("unit") or UNITS_OF_RUNS[name]
            scale = self.scales[unit]
        if not spread:
            text = values.reading_text(value, scale.size, step)
            return self.number(place, text, scale)
        *digits, exponent = values.rounded(value, spread, scale.size)
        place_of_u = f"{record}{dot}{name_of_u}"
        places = self.above + place, self.above + place_of_u
        size = scale.size * 10.0**exponent
        return Number(tuple(digits), places, scale, size, exponent)

    def reading(self, i: int, role: str) -> Number:
        """Show the spin or the time of a run with the digits of the log."""
        run = self.at(f"runs.{i}")
        column = self.analysis.readings.columns.get(role)
        step = 0.0
        if column is not None:
            cell = column.values[i] or 0.0
            # A mean of several readings has no digits of its own.
            # The numbers of the JSON have 12 digits.
            if math.isclose(cell, run.find(role), rel_tol=1e-11):
                step = column.steps[i]
        scale = values.RPM if role == "spin" else values.SECOND
        return run.value(role, scale, step=step)

    def number(
        self, place: str, text: str | None = None, scale: Scale = NUMBER
    ) -> Number:
        """Show the number or name at a place as a text; as it is without a text."""
        if text is None:
            text = str(self.find(place))
        return Number((text,), (self.above + place,), scale, scale.size)

    def scatter(self, place: str, scale: Scale = NUMBER) -> Number:
        """Show the size of a scatter or of an uncertainty that is not next to its value.

        It has two digits, and all digits before the point.
        """
        size = abs(self.find(place)) / scale.size
        text = f"{size:#.2g}".rstrip(".")
        if 99.5 <= size < 1e9:
            text = f"{size:.0f}"
        return self.number(place, text, scale)

    def bound(self, place: str, scale: Scale) -> Number:
        """Show the size of an end of an interval, with two digits."""
        number = self.scatter(place, scale)
        size = math.copysign(scale.size, self.find(place))
        return replace(number, size=size)

    def interval(self) -> Number:
        """Show the 95 % interval of I_zz: "4.32 to 4.56"."""
        scale = self.inertia
        place = "inertia.interval_95"
        low, high = [end / scale.size for end in self.find(place)]
        half = (high - low) / 2
        # Two digits of the half.
        decimals = max(0, 1 - values.exponent_of(half)) if half > 0 else 4
        ends = f"{low:.{decimals}f}", f"{high:.{decimals}f}"
        places = f"{place}.0", f"{place}.1"
        return Number(ends, places, scale, scale.size, between=" to ")

    def count(self, place: str, noun: str) -> Sentence:
        """Show a count with its noun: "10 runs"."""
        if self.find(place) != 1:
            noun += "s"
        return say("{} {}", self.number(place), noun)

    def percent(self, place: str, sign: bool = True) -> Number:
        """Show a relative size with two digits: "+0.03 %"."""
        percent = 100 * self.find(place)
        text = f"{percent:+.2g}"
        if percent == 0:
            text = "0"
        elif abs(percent) < 0.001:
            text = "< 0.001"
        elif abs(percent) >= 99.5:
            text = f"{percent:+.0f}"
        if not sign:
            text = text.removeprefix("+")
        return self.number(place, text, values.PERCENT)

    def p(self, place: str) -> Sentence:
        """Show a probability: "p = 0.32"."""
        text = values.p_text(self.find(place))
        sign = "p = " if text.startswith("p = ") else "p "
        number = self.number(place, text.removeprefix(sign))
        return say("{}{}", sign, number)

    def shift(self, place: str) -> Number:
        """Show a difference in standard uncertainties: "-2.5 u"."""
        size = self.find(place)
        decimals = 1 if abs(size) < 10 else 0
        text = f"{size:+.{decimals}f}"
        if float(text) == 0:
            # Zero has no sign.
            text = text[1:]
        return self.number(place, text, values.IN_U)

    def answer(self) -> Sentence:
        """Show I_zz ± u, or its 95 % interval if that is wide.

        With one torque, the answer of a balanced ball is before the interval.
        """
        analysis = self.analysis
        if not is_wide(analysis.inertia):
            return say("I_zz = {}", self.value("inertia.value"))
        interval = self.interval()
        if analysis.if_balanced is None or analysis.measurements.balanced is False:
            return say("I_zz = {} (95 % interval)", interval)
        balanced = self.value("if_balanced.value")
        words = (
            "I_zz = {} (± u) if the ball was balanced as the sheet asks; if not, {} "
            "(95 % interval)"
        )
        return say(words, balanced, interval)

    def hung(self, run: int) -> Sentence:
        """Show the mass and the position of a record with the digits of a run's log.

        An example is "20.00 g at 15.0 cm".
        """
        measured = self.analysis.measurements
        scale = values.KILOGRAM if self.find("mass") >= 1 else values.GRAM
        mass = self.value("mass", scale, step=measured.mass_step[run])
        step = measured.position_step[run]
        arm = self.value("position", values.CENTIMETRE, step=step)
        return say("{} at {}", mass, arm)

    def load(self, group: int) -> Sentence:
        """Show the load of a torque, or the torque if the log gives no load."""
        analysis = self.analysis
        here = self.at(f"torques.{group}")
        torque = analysis.torques[group]
        runs = analysis.measurements.by_torque[group]
        mark = Mark(group)
        day = Styled(analysis.measurements.day_words(runs[0]), "typed")
        left_out = ""
        if all(analysis.run_table[i].left_out for i in runs):
            left_out = ", left out"
        if torque.torque == 0:
            return say("{}no weight{}{}", mark, day, left_out)
        if torque.mass is None or torque.position is None:
            size = here.value("torque")
            return say("{}a torque of {}{}{}", mark, size, day, left_out)
        return say("{}{}{}{}", mark, here.hung(runs[0]), day, left_out)
