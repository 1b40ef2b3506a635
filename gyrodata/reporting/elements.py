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
from typing import Any

from msgspec import Struct
from msgspec.structs import replace

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
    between: str = " ± "
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
    """Text in a style: "strong", "warn" (another colour), "quote" or "code"."""

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
"""Letters that mean a quantity in the texts of the tool."""

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


def join(
    sentence: Sentence,
    escape: Callable[[str], str],
    write: Callable[[Part], str | None],
) -> str:
    """Write a sentence: `write` gives the markup of a part, or None for text.

    Text is escaped up to the next markup.
    """
    done, text = "", ""
    for part in (*sentence, None):
        markup = "" if part is None else write(part)
        if markup is None:
            text += str(part)
            continue
        start = " " * text.startswith(" ")
        end = " " * (text.endswith(" ") and not text.isspace())
        done += f"{start}{escape(text)}{end}{markup}"
        text = ""
    return done.strip()


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
    compared: tuple[float, float] | None = None
    """A value and its u: the page draws each number of the column next to them."""
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
        numbers = [cell for cell in cells if isinstance(cell, Number)]
        if numbers:
            head = replace(head, scale=numbers[0].scale)
        kept_heads.append(head)
        columns.append([_in_column(cell, head) for cell in cells])
    kept_rows = list(zip(*columns, strict=True))
    return Table(kept_heads, kept_rows, caption, main, odd)


def _in_column(cell: Cell, head: Head) -> Sentence:
    """Write a cell; the head of its column contains the unit."""
    if isinstance(cell, Number):
        return (replace(cell, unit=False),)
    if isinstance(cell, str):
        return (cell,)
    return cell or NOTHING * bool(head.scale)


class Text(Struct, frozen=True):
    """Paragraphs, or the items of a list."""

    sentences: Sequence[Sentence]
    kind: str = ""
    """Lists are "list" and "numbered"; paragraphs can be "result", "small" or "task".
    """


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
    warnings: tuple[Sentence, ...]
    """Warnings that are no such reasons."""
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
    """

    def __init__(self, analysis: Analysis) -> None:
        self.analysis = analysis
        self.document = analysis.to_dict()
        self.record: Any = self.document["result"]
        self.above = ""
        self.inertia = values.inertia_scale(analysis.inertia.value, analysis.inertia.u)
        # One unit for all torques, so that they can be compared.
        largest = max(abs(run.torque) for run in analysis.run_table)
        self.torque = values.torque_scale(largest)
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
        self, place: str, show: Callable[..., Cell] | None = None, *scale: Scale
    ) -> Cell:
        """Show the value at a place, or with another method; None if it is null."""
        if self.find(place) is None:
            return None
        method: Callable[..., Cell] = show or self.value
        return method(place, *scale)

    def value(
        self,
        place: str,
        scale: Scale | None = None,
        u: bool = True,
        step: float = 0.0,
    ) -> Number:
        """Show the value at a place with its standard uncertainty.

        Without the uncertainty, the value is shown to the last digit that was read.

        Parameters
        ----------
        place : str
            A number in SI units; its standard uncertainty is next to it.
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
        record, _, name = place.rpartition(".")
        of_value = "u" if name in ("value", "exponent") else f"{name}_u"
        there = self.find(record) if record else self.record
        spread = there.get(of_value) if u else None
        if scale is None:
            unit = there.get("unit") or UNITS_OF_RUNS[name]
            scale = self.scales[unit]
        if not spread:
            text = values.reading_text(value, scale.size, step)
            return self.number(place, text, scale)
        *digits, exponent = values.rounded(value, spread, scale.size)
        above = self.above + place.removesuffix(name)
        places = above + name, above + of_value
        size = scale.size * 10.0**exponent
        return Number(tuple(digits), places, scale, size, exponent)

    def run(self, i: int) -> Numbers:
        """Return the numbers of a run."""
        return self.at(f"runs.{i}")

    def reading(self, i: int, role: str) -> Number:
        """Show the spin or the time of a run with the digits of the log."""
        run = self.run(i)
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
        """Show an uncertainty or a scatter, with two digits."""
        text = values.uncertainty_text(self.find(place), scale.size)
        return self.number(place, text, scale)

    def bound(self, place: str, scale: Scale) -> Number:
        """Show the size of an end of an interval, with two digits."""
        end = self.find(place)
        text = values.uncertainty_text(abs(end), scale.size)
        number = self.number(place, text, scale)
        return replace(number, size=math.copysign(scale.size, end))

    def interval(self) -> Number:
        """Show the 95 % interval of I_zz: "4.32 to 4.56"."""
        scale = self.inertia
        place = "inertia.interval_95"
        low, high = self.find(place)
        ends = values.interval_ends(low, high, scale.size)
        places = f"{place}.0", f"{place}.1"
        return Number(ends, places, scale, scale.size, between=" to ")

    def count(self, place: str, noun: str) -> Sentence:
        """Show a count with its noun: "10 runs"."""
        if self.find(place) != 1:
            noun += "s"
        return say("{} {}", self.number(place), noun)

    def percent(self, place: str, sign: bool = True) -> Number:
        """Show a relative size: "+0.03 %"."""
        text = values.percent_text(self.find(place)).removesuffix(" %")
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
        grams = values.mass_scale(self.find("mass"))
        mass = self.value("mass", grams, step=measured.mass_step[run])
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
        behind = analysis.measurements.day_words(runs[0])
        if all(analysis.run_table[i].left_out for i in runs):
            behind += ", left out"
        if torque.torque == 0:
            return say("{}no weight{}", mark, behind)
        if torque.mass is None or torque.position is None:
            size = here.value("torque")
            return say("{}a torque of {}{}", mark, size, behind)
        return say("{}{}{}", mark, here.hung(runs[0]), behind)
