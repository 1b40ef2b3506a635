"""The elements of a report: parts of sentences, blocks and sections. Each format has its own writer.

Text is plain here, whatever it holds: each form escapes it. Each number names its place in results.json, which the page
shows with it. What is `full` is left out of the short summary.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from msgspec import Struct

from gyrodata.measurements import torque_groups
from gyrodata.reporting.values import (
    CENTIMETRE,
    Scale,
    interval_text,
    mass_scale,
    number_text,
    p_text,
    percent_text,
    reading_text,
    uncertainty_text,
    value_text,
)
from gyrodata.results import Analysis

AGREES = 2.0
"""Two numbers agree that lie no further apart than this many standard uncertainties of their difference."""

UNLIKELY = 0.05
"""A scatter with a smaller chance than this is more than the stated uncertainties explain."""


class Value(Struct, frozen=True):
    """A value to be written with its unit; in a table the column's head has the unit."""

    value: float
    """[SI unit]"""
    u: float | None
    """Standard uncertainty [SI unit]; None for a reading."""
    scale: Scale
    place: str
    """In results.json, below "result"."""
    is_u: bool = False
    """True if the value is an uncertainty or a scatter itself: two digits are enough."""
    step: float = 0.0
    """One step of the last digit of a reading [SI unit]; 0 where it is not known."""

    @property
    def without_u(self) -> str:
        """Write it alone, without its unit."""
        if self.is_u:
            return uncertainty_text(self.value, self.scale.size)
        return reading_text(self.value, self.scale.size, self.step)


class Interval(Struct, frozen=True):
    """An interval to be written with its unit."""

    low: float
    """[SI unit]"""
    high: float
    """[SI unit]"""
    scale: Scale
    place: str


class Number(Struct, frozen=True):
    """A number or a name of the log, written alike in every form."""

    text: str
    place: str
    """In results.json, below "result"; from the top with a leading "/"."""
    size: float = 1.0
    """What a shown 1 is worth in the unit of results.json."""


class Styled(Struct, frozen=True):
    """Text that a form with styles sets apart: "strong", "warn" (strong, and in another colour), "quote", "code"."""

    text: str
    style: str


class Mark(Struct, frozen=True):
    """The mark of a torque in the figures; nothing in a form without colours."""

    group: int
    """Index of the torque."""
    torque: float
    """By which a table is sorted [N*m]."""


SYMBOLS = re.compile(r"(?<![\w&#])(?:b(?!\))|[knpuM]|m g x|m r(?=²))(?=[²ⁿ]|[^\w;']|$)")
"""Letters that stand for a quantity in what the tool says itself."""

Part = str | Value | Interval | Number | Styled | Mark
Sentence = tuple[Part, ...]
Cell = Value | Sentence | None
"""None where there is nothing to say."""


class Head(Struct, frozen=True):
    """The head of a column."""

    words: str
    scale: Scale | None = None
    """Unit of the column's values."""
    wrap: float = 0.0
    """Part of the line that a column of long text may take; 0 for a column as wide as its cells."""
    full: bool = False


class Picture(Struct, frozen=True):
    """A drawing next to the numbers of one column: dots on an axis, or bars from 0 to 1."""

    column: str
    """Words of its head."""
    values: tuple[tuple[float, float] | None, ...]
    """Value and standard uncertainty of each row."""
    band: tuple[float, float] | None
    """Drawn behind all dots, as a line where both are equal; None for bars."""
    caption: str = ""
    """What is added to the table's caption."""
    reach: float | None = None
    """What lies further from the band than so many times its width is cut off; None: nothing is."""


class Table(Struct, frozen=True):
    """A table with one row of heads."""

    heads: tuple[Head, ...]
    rows: tuple[tuple[Cell, ...], ...]
    caption: str
    picture: Picture | None = None
    main: int | None = None
    """The row that counts most."""
    odd: tuple[int, ...] = ()
    """Rows that do not go with the others."""
    sortable: bool = False
    short: tuple[int, ...] | None = None
    """Rows of the summary; None for all."""
    full: bool = False


class Text(Struct, frozen=True):
    """Paragraphs, or the items of a list."""

    sentences: tuple[Sentence, ...]
    kind: str = ""
    """"list", "numbered", or of paragraphs: "result", "small"."""
    full: bool = False


class Fact(Struct, frozen=True):
    """A line of what is known: "timing bias b = 0.006 ± 0.047 s", "tool: gyrodata"."""

    words: str
    says: Sentence
    symbol: str = ""
    remark: Sentence = ()
    full: bool = False

    @property
    def lead(self) -> str:
        """The words before it, in a line of text."""
        return f"{self.words} {self.symbol} = " if self.symbol else f"{self.words}: "

    @property
    def sentence(self) -> Sentence:
        """Write it as a line of text."""
        return (self.lead, *self.says, *((" (", *self.remark, ")") if self.remark else ()))


class Facts(Struct, frozen=True):
    """A list of facts."""

    facts: tuple[Fact, ...]
    full: bool = False


class Figure(Struct, frozen=True):
    """Where a form with figures shows one of them."""

    name: str
    caption: str
    full: bool = True


Block = Text | Facts | Table | Figure


class Section(Struct, frozen=True):
    """A heading with its blocks in order."""

    title: str
    blocks: tuple[Block, ...]
    anchor: str = ""
    """Where links lead."""
    link: str = ""
    """Words of the link in a table of contents."""
    level: int = 2


class Report(Struct, frozen=True):
    """All that is said of one analysis."""

    name: str
    size: Sentence
    """Of the log: "10 runs, 4 torques"."""
    read_as: Sentence
    """One run in words, so that a wrong unit or origin is seen."""
    doubts: tuple[Sentence, ...]
    """What stands before an answer that not even its u can save; nothing where all is well."""
    answer: Sentence
    brief: tuple[Sentence, ...]
    """What a screen has room for below the answer: whether the runs agree, odd runs, what to repeat, what to do."""
    sections: tuple[Section, ...]
    """The first, below the answer, has no title."""

    @property
    def title(self) -> Sentence:
        """Name the report."""
        return (f"Gyroscope lab report: {self.name}, ", *self.size)


def lines(block: Block, short: bool = False) -> tuple[Sentence, ...]:
    """Give the lines of text of a block, or those of the summary; a table and a figure have none."""
    if isinstance(block, Facts):
        return tuple(fact.sentence for fact in block.facts if not (short and fact.full))
    return block.sentences if isinstance(block, Text) else ()


def is_list(block: Block) -> bool:
    """Tell whether its lines are the items of a list."""
    return isinstance(block, Facts) or (isinstance(block, Text) and block.kind in ("list", "numbered"))


# --- parts as text -----------------------------------------------------------------------------------------------


def sentence_text(sentence: Sentence) -> str:
    """Write a sentence as text."""
    return "".join(map(part_text, sentence))


def part_text(part: Part) -> str:
    """Write a part of a sentence as text."""
    if isinstance(part, Value):
        if part.step:
            return f"{part.without_u} {part.scale.unit}"
        return value_text(part.value, part.u, part.scale)
    if isinstance(part, Interval):
        times = " × " if part.scale.exponent else " "
        return f"{interval_text(part.low, part.high, part.scale.size)}{times}{part.scale}"
    if isinstance(part, Mark):
        return ""
    return part if isinstance(part, str) else part.text


def head_text(head: Head) -> str:
    """Write the head of a column as text: "I_zz [10⁻³ kg·m²]"."""
    unit = str(head.scale or "")
    return f"{head.words} [{unit}]" if unit else head.words


def cell_text(cell: Value | Sentence) -> str:
    """Write a cell of a table as text; the head of the column has the unit."""
    if isinstance(cell, tuple):
        return sentence_text(cell)
    if cell.u:
        return number_text(cell.value, cell.u, cell.scale.size)
    return cell.without_u


# --- what several sections say ------------------------------------------------------------------------------------


def load(analysis: Analysis, group: int, torque: Scale) -> Sentence:
    """Name what is on the rod as the log does: "20.00 g at 15.0 cm"; where it does not say, the torque."""
    found, place = analysis.torques[group], f"torques.{group}"
    mark = Mark(group, found.torque)
    runs = torque_groups(analysis.measurements)[group]
    told = (", left out",) if all(analysis.run_table[i].left_out for i in runs) else ()
    if found.torque == 0:
        return (mark, "no weight", *told)
    if found.mass is None or found.position is None:
        return (mark, "a torque of ", Value(found.torque, None, torque, f"{place}.torque"), *told)
    return (mark, *hung(analysis, runs[0], place), *told)


def hung(analysis: Analysis, run: int, place: str) -> Sentence:
    """Name the mass and the position of a run, with the digits that they were read to."""
    measured = analysis.measurements
    mass, position = float(measured.mass[run]), float(measured.position[run])
    of_mass, of_position = measured.steps_of_load(run)
    shown = Value(mass, None, mass_scale(mass), f"{place}.mass", step=of_mass)
    return (shown, " at ", Value(position, None, CENTIMETRE, f"{place}.position", step=of_position))


def agrees(deviation: float | None) -> bool:
    """Return whether two numbers agree whose difference is `deviation` standard uncertainties."""
    return deviation is not None and abs(deviation) <= AGREES


def count(number: int, noun: str, place: str) -> Sentence:
    """Write a count with its noun: "10 runs"."""
    return (Number(str(number), place), f" {noun}{'' if number == 1 else 's'}")


def percent(value: float, place: str, signed: bool = True) -> Sentence:
    """Write a relative size in per cent: "+0.03 %"."""
    text = percent_text(value).removesuffix(" %")
    return (Number(text if signed else text.removeprefix("+"), place, 0.01), " %")


def chance(p: float, place: str) -> Sentence:
    """Write a probability: "p = 0.32"."""
    text = p_text(p).removeprefix("p ").removeprefix("= ")
    return ("p " if text[0] in "<>" else "p = ", Number(text, place))


def signed(size: float) -> str:
    """Write a size in standard uncertainties: "-2.5"."""
    text = f"{size:+.1f}" if abs(size) < 10 else f"{size:+.0f}"
    return text[1:] if float(text) == 0 else text


def filled(
    heads: tuple[Head, ...],
    rows: Iterable[tuple[Cell, ...]],
    caption: str,
    picture: Picture | None = None,
    main: int | None = None,
) -> Table:
    """Leave out the columns in which no row has anything."""
    rows = tuple(rows)
    told = [i for i in range(len(heads)) if any(row[i] is not None for row in rows)]
    kept = tuple(tuple(row[i] for i in told) for row in rows)
    return Table(tuple(heads[i] for i in told), kept, caption, picture, main, full=True)
