"""What is said of one analysis, whatever its form: a title, the answer, and sections of text, facts, tables, figures.

Text is plain here, whatever it holds: each form escapes it, and writes values and their units, in its own way. Each
number names its place in results.json, which the page shows with it. What is `full` is left out of the short summary.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping

from msgspec import Struct
from msgspec.structs import asdict, replace

from gyrodata import __version__
from gyrodata.comparisons import Run, turn_words
from gyrodata.diagnostics import BALL_DISAGREES, COLUMNS_EXCHANGED, DIGITS_TOO_FEW, INERTIA_UNUSUAL, SIZE_UNUSUAL
from gyrodata.errors import Diagnostic
from gyrodata.fitting import Estimate
from gyrodata.measurements import torque_groups
from gyrodata.reporting.phrases import EFFECT_NAMES, FIT_NAMES, MODEL_NAMES, SOURCE_NAMES, defaults_used, effect_verdict
from gyrodata.reporting.values import (
    CENTIMETRE,
    NUMBER,
    PRODUCT,
    RPM,
    SECOND,
    Scale,
    Writing,
    inertia_scale,
    interval_text,
    mass_scale,
    number_text,
    p_text,
    percent_text,
    reading_text,
    torque_scale,
    uncertainty_text,
    value_text,
)
from gyrodata.results import CONVENTIONS, Analysis

AGREES = 2.0
"""Two numbers agree that lie no further apart than this many standard uncertainties of their difference."""

UNLIKELY = 0.05
"""A scatter with a smaller chance than this is more than the stated uncertainties explain."""

NOTICEABLE = 1.15
"""A factor on the errors of the runs that is worth a word [1]."""

WEIGHTS = 5
"""Of so many weights, those that move the answer most, the summary tells what it would be without them."""

FAR = 2.0
"""From how many standard uncertainties on a run is worth repeating that does not yet look odd."""

FIRST = {BALL_DISAGREES, COLUMNS_EXCHANGED, DIGITS_TOO_FEW, INERTIA_UNUSUAL, SIZE_UNUSUAL}
"""Diagnostics that the page tells on its first screen."""

FEW = 3
"""Of runs or of advice, so many are told on the first screen."""

UNTOLD = 0.3
"""A balance with a larger share of u² than this is not told by the design [1]."""


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
    """How a form with pictures draws one column beside its numbers: dots on an axis, or bars from 0 to 1."""

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
        """What stands before it, in a line of text."""
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
    """A heading with what stands below it, in this order."""

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


def sentence_text(sentence: Sentence, writing: Writing) -> str:
    """Write a sentence as text."""
    return "".join(part_text(part, writing) for part in sentence)


def part_text(part: Part, writing: Writing) -> str:
    """Write a part of a sentence as text."""
    if isinstance(part, Value):
        return value_text(part.value, part.u, part.scale, writing)
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


def cell_text(cell: Value | Sentence, writing: Writing) -> str:
    """Write a cell of a table as text: its unit stands in the column's head."""
    if isinstance(cell, tuple):
        return sentence_text(cell, writing)
    if cell.u:
        return number_text(cell.value, cell.u, cell.scale.size, writing)
    return (uncertainty_text if cell.is_u else reading_text)(cell.value, cell.scale.size)


# --- the tree ----------------------------------------------------------------------------------------------------


def report(analysis: Analysis) -> Report:
    """Put an analysis into sections, in the order in which they are read."""
    inertia = analysis.inertia
    scale = inertia_scale(inertia.value, inertia.u)
    torque = common_torque_scale(analysis)
    found = (
        Section("", tuple(_summary(analysis, scale, torque))),
        Section("What the answer hangs on", _hangs_on(analysis, scale), "hangs", "What it hangs on"),
        Section("Three fits side by side", tuple(_fits(analysis, scale, torque)), "fits", "Fits"),
        Section("Question 3: what the data show", (), "q3"),
        Section("(a) Precession period against spin", _period(analysis, torque), "q3a", "3 (a)", 3),
        Section("(b) How the period depends on the spin", _exponents(analysis, torque), "q3b", "(b)", 3),
        Section("(c) The product φ̇ψ̇ at one torque", _product(analysis, scale, torque), "q3c", "(c)", 3),
        Section(
            "(d) Torque against φ̇ψ̇: the constant of proportionality",
            _constant(analysis, scale, torque),
            "q3d",
            "(d)",
            3,
        ),
        Section("(e) What the constant means", tuple(_meaning(analysis, scale)), "q3e", "(e)", 3),
        Section("Runs", _runs(analysis, torque), "runs", "Runs"),
        Section("Effects considered", _effects(analysis), "effects", "Effects"),
        Section("Where the uncertainty comes from", tuple(_budget(analysis, scale)), "uncertainty", "Uncertainty"),
        Section("What to do better next time", _advice(analysis), "advice", "Next time"),
        Section("Diagnostics", _diagnostics(analysis), "diagnostics", "Diagnostics"),
        Section("Provenance", (_provenance(analysis),), "provenance", "Provenance"),
        Section("Conventions", (_conventions(),), "conventions", "", 3),
    )
    answer: Sentence = ("I_zz = ", Value(inertia.value, inertia.u, scale, "inertia.value"))
    brief = tuple(_brief(analysis, scale, torque))
    return Report(analysis.name, _size(analysis), _read_as(analysis, torque), _doubts(analysis), answer, brief, found)


def common_torque_scale(analysis: Analysis) -> Scale:
    """Choose one unit for every torque of a log, so that they can be compared at a glance."""
    return torque_scale(max(abs(run.torque) for run in analysis.run_table))


def residual_torque(analysis: Analysis, scale: Scale) -> Fact:
    """Give the residual torque."""
    found = analysis.residual_torque
    value = Value(found.value, found.u, scale, "residual_torque.value")
    return Fact("residual torque", (value,), "M0", ("torque at work = applied + M0",))


def load(analysis: Analysis, group: int, torque: Scale) -> Sentence:
    """Name what is on the rod as the log does: "20 g at 15 cm"; where it does not say, the torque."""
    found, place = analysis.torques[group], f"torques.{group}"
    mark = Mark(group, found.torque)
    if found.torque == 0:
        return (mark, "no weight")
    if found.mass is None or found.position is None:
        return (mark, "a torque of ", Value(found.torque, None, torque, f"{place}.torque"))
    mass = Value(found.mass, None, mass_scale(found.mass), f"{place}.mass")
    return (mark, mass, " at ", Value(found.position, None, CENTIMETRE, f"{place}.position"))


def _size(analysis: Analysis) -> Sentence:
    runs, torques = len(analysis.run_table), len(analysis.torques)
    return (*_count(runs, "run", "/input.rows"), ", ", *_count(torques, "torque", "torques.length"))


def _summary(analysis: Analysis, scale: Scale, torque: Scale) -> Iterator[Block]:
    inertia, bias = analysis.inertia, analysis.timing_bias
    first = [_diagnostic(i, found) for i, found in enumerate(analysis.diagnostics) if found.code in FIRST]
    if first:
        yield Text(tuple(first), full=True)
    yield Text((_verdict(analysis),))
    if analysis.if_balanced is not None:
        yield Text(_on_balance(analysis, analysis.if_balanced, scale))
    if inertia.interval_95 is not None:
        interval = Interval(*inertia.interval_95, scale, "inertia.interval_95")
        found: Sentence = ("k = ", Number(f"{inertia.k or 0.0:.2f}", "inertia.k"))
        yield Text((("95 % interval ", interval, " (", *found, ")"),))
    facts = [residual_torque(analysis, torque)]
    if bias.u:
        facts.append(Fact("timing bias", (Value(bias.value, bias.u, SECOND, "timing_bias.value"),), "b"))
    facts.append(_goodness(analysis))
    # The summary names them where it lists them.
    odd = [Number(run.run, f"runs.{i}.run") for i, run in enumerate(analysis.run_table) if run.flagged]
    names = tuple(part for name in odd[:6] for part in (", ", name))[1:] + ((" and more",) if len(odd) > 6 else ())
    yield Facts((*facts, Fact("flagged runs", names or ("none",), full=True)))
    yield Text(
        (("Every value stands with one standard uncertainty u, which holds how the runs scatter too.",),),
        "small",
        full=True,
    )


def _read_as(analysis: Analysis, torque: Scale) -> Sentence:
    """Say one run in words, the first with a load: what was read, and what was made of it."""
    i, run = next((i, run) for i, run in enumerate(analysis.run_table) if run.torque)
    at, measured = f"runs.{i}", analysis.measurements
    if run.mass is None or run.position is None:
        on_the_rod: Sentence = ("a torque of ", Value(run.torque, None, torque, f"{at}.torque"))
    else:
        mass = Value(run.mass, None, mass_scale(run.mass), f"{at}.mass")
        on_the_rod = (mass, " at ", Value(run.position, None, CENTIMETRE, f"{at}.position"), " from the centre")
    spin = Value(run.spin, None, RPM, f"{at}.spin")
    count, turns = turn_words(run.turns).split(" ")
    time = Value(run.time, None, SECOND, f"{at}.time")
    timed: Sentence = (", ", Number(count, f"{at}.turns"), f" {turns} in ", time) if measured.timed else ()
    made: Sentence = (": ", Value(run.torque, None, torque, f"{at}.torque")) if run.mass is not None else ()
    period = Value(run.period, None, SECOND, f"{at}.period")
    return ("Read as: run ", Number(run.run, f"{at}.run"), ": ", *on_the_rod, ", ", spin, *timed, *made,
            ", one turn in ", period, ".")  # fmt: skip


def _doubts(analysis: Analysis) -> tuple[Sentence, ...]:
    """Say why the answer is not to be relied on, where not even u holds what is wrong."""
    if not analysis.doubts:
        return ()
    first, *others = analysis.doubts
    more = tuple((Styled("Besides: ", "warn"), f"{other.words}.") for other in others)
    return ((Styled("Do not rely on this answer: ", "warn"), f"{first.words}. Find the cause: {first.remedy}."), *more)


def _brief(analysis: Analysis, scale: Scale, torque: Scale) -> Iterator[Sentence]:
    """Say what fits on a screen."""
    yield _verdict(analysis)
    if analysis.if_balanced is not None:
        yield from _on_balance(analysis, analysis.if_balanced, scale)
    inertia, m0 = analysis.inertia, analysis.residual_torque
    if inertia.interval_95 is not None:
        yield (
            "95 % interval ", Interval(*inertia.interval_95, scale, "inertia.interval_95"),
            "; residual torque M0 = ", Value(m0.value, m0.u, torque, "residual_torque.value"),
        )  # fmt: skip
    if analysis.ball is not None:
        yield _beside(analysis)
    yield from _to_repeat(analysis)
    for advice in analysis.advice[:1] if not analysis.doubts else ():
        yield (f"next time: {advice}",)


def _to_repeat(analysis: Analysis) -> Iterator[Sentence]:
    """Name the odd runs, and those that are worth another look."""
    table = analysis.run_table
    odd = [i for i, run in enumerate(table) if run.flagged]
    far = [
        i
        for i, run in enumerate(table)
        if i not in odd and run.studentized_residual is not None and abs(run.studentized_residual) > FAR
    ]
    for i in odd[:FEW]:
        fate = "left out" if table[i].left_out else "kept"
        yield ("odd: ", *_run_place(analysis, i), f", {fate}: {table[i].reason}; look at it, or time it again")
    if len(odd) > FEW:
        yield (f"odd: {len(odd) - FEW} more, marked in the table of runs",)
    if far:
        named = [part for i in far[:FEW] for part in (", ", *_run_place(analysis, i))][1:]
        yield ("to repeat if there is time: ", *named, f", over {FAR:g} u from what the others say")
    if not odd and not far:
        yield ("odd runs: none; nothing has to be repeated",)


def _run_place(analysis: Analysis, i: int) -> Sentence:
    run = analysis.run_table[i]
    return ("run ", Number(run.run, f"runs.{i}.run"), " (line ", Number(str(run.line), f"runs.{i}.line"), ")")


def _verdict(analysis: Analysis) -> Sentence:
    """Say in one sentence whether the runs agree, and what the largest part of u is."""
    return (*_agreement(analysis), *_largest_part(analysis))


def _agreement(analysis: Analysis) -> Sentence:
    scatter, time_u = analysis.fit.scatter, analysis.measurements.time_u
    the_runs: Sentence = ("The ", *_count(len(analysis.run_table), "run", "/input.rows"))
    if any(run.left_out for run in analysis.run_table):
        the_runs = ("Of the ", *the_runs[1:], " those that are kept")
    if analysis.p is None:
        return ("There are as many unknowns as runs, so nothing tells whether they agree",)
    if analysis.doubts:
        return (*the_runs, " do not agree with one line within what the log states")
    if analysis.p >= UNLIKELY:
        better = ", better than stated" if analysis.p > 1 - UNLIKELY / 2 else ""
        return (*the_runs, f" agree with one line{better}")
    if scatter < NOTICEABLE:
        return (*the_runs, " agree badly with one line")
    stated: Part = "stated" if time_u is None else Value(time_u, None, SECOND, "goodness.time_u")
    times = Number(uncertainty_text(scatter), "goodness.scatter")
    return (*the_runs, " scatter about one line ", times, " times as much as ", stated, ", which u holds")


def _largest_part(analysis: Analysis) -> Iterator[Part]:
    """Name the largest part of u, and a balance that the design does not tell."""
    if not analysis.budget:
        yield "."
        return
    largest = analysis.budget[0]
    if largest.source != "residual_torque":
        name = SOURCE_NAMES.get(largest.source, largest.source)
        name = name if name == "g" or name.startswith("each") else f"the {name}"
        yield from (f"; the largest uncertainty is {name}, ", *_share(largest.share, 0), " of u².")
    for at, share in enumerate(analysis.budget):
        if share.source == "residual_torque" and (at == 0 or share.share > UNTOLD):
            yield "." * (at == 0)
            words = " These runs do not tell how well the ball is balanced, and that is "
            yield from (words, "the largest part of u², " * (at == 0), *_share(share.share, at), ".")


def _share(share: float, at: int) -> Sentence:
    return (Number(f"{100 * share:.0f}", f"budget.{at}.share", 0.01), " %")


def _on_balance(analysis: Analysis, balanced: Estimate, scale: Scale) -> tuple[Sentence, ...]:
    """Say what I_zz from one torque rests on."""
    measured = analysis.measurements
    if measured.balanced or measured.imbalance_u is not None:
        by = "the balance test" if measured.imbalance_u is not None else "the ball being balanced"
        return ((f"All torques are equal, so the answer rests on {by}.",),)
    value, line = Value(balanced.value, balanced.u, scale, "if_balanced.value"), Styled("# balanced: yes", "code")
    usual = "; the usual imbalance, 5 % of the torque, moves it by 5 %."
    return (
        ("If the ball is balanced as in step 2, I_zz = ", value, usual),
        (
            "All torques are equal: to settle it, write ",
            line,
            ", add a balance test, or time a run without a weight.",
        ),
    )


def _hangs_on(analysis: Analysis, scale: Scale) -> tuple[Block, ...]:
    """Show I_zz as it is, and as it would be if one thing were otherwise."""
    if not analysis.sensitivity:
        return ()
    answer, u = analysis.inertia, analysis.inertia.u or 0.0
    rows: list[tuple[Cell, ...]] = [(("as it is",), Value(answer.value, answer.u, scale, "inertia.value"), None)]
    dots: list[tuple[float, float] | None] = [(answer.value, u)]
    for i, case in enumerate(analysis.sensitivity):
        at, found = f"sensitivity.{i}", case.inertia
        away = None if case.deviation is None else (Number(_signed(case.deviation), f"{at}.deviation"), " u")
        value = ("no answer",) if found is None else Value(found.value, found.u, scale, f"{at}.inertia.value")
        rows.append(((case.words,), value, away))
        dots.append(None if found is None else (found.value, found.u or 0.0))
    heads = (Head("if"), Head("I_zz", scale), Head("moved by", NUMBER))
    band = (answer.value - u, answer.value + u)
    picture = Picture("I_zz", tuple(dots), band, "the bars are ± u, the band is that of the answer", reach=5.0)
    weights = [i for i, case in enumerate(analysis.sensitivity, 1) if case.name == "without"]
    weights.sort(key=lambda i: -abs(analysis.sensitivity[i - 1].deviation or 0.0))
    short = tuple(i for i in range(len(rows)) if i not in weights[WEIGHTS:])
    return (Table(heads, tuple(rows), "I_zz if one thing is otherwise", picture, main=0, short=short),)


def _goodness(analysis: Analysis) -> Fact:
    fit = analysis.fit
    if analysis.p is None:
        return Fact("goodness", ("not available: no degrees of freedom left",))
    chi2 = Number(f"{fit.chi2:.3g}", "goodness.chi2")
    scatter = Number(uncertainty_text(fit.scatter), "goodness.scatter")
    dof = _count(fit.dof, "degree", "goodness.dof")
    return Fact(
        "goodness",
        _chance(analysis.p, "goodness.p"),
        remark=("chi-square ", chi2, " for ", *dof, " of freedom; scatter ", scatter, " times as stated"),
    )


def _fits(analysis: Analysis, scale: Scale, torque: Scale) -> Iterator[Block]:
    rows: list[tuple[Cell, ...]] = []
    for i, fit in enumerate(analysis.fits):
        at, value, m0 = f"fits.{i}", fit.inertia, fit.constant
        away: Cell = None
        if fit.deviation is not None and fit.difference is not None:
            relative = _percent(fit.difference, f"{at}.difference")
            away = (Number(_signed(fit.deviation), f"{at}.deviation"), " u (", *relative, ")")
        rows.append(
            (
                (FIT_NAMES[fit.name],),
                Value(value.value, value.u, scale, f"{at}.inertia.value") if value else ("not possible",),
                Value(-m0.value, m0.u, torque, f"{at}.constant.value") if m0 else ("taken as 0",) if value else None,
                away,
            )
        )
    best, u = analysis.inertia.value, analysis.inertia.u or 0.0
    dots = tuple(None if fit.inertia is None else (fit.inertia.value, fit.inertia.u or 0.0) for fit in analysis.fits)
    words = "the bars are ± u, the band is that of the recommended fit"
    yield Table(
        (Head("fit"), Head("I_zz", scale), Head("M0", torque), Head("from recommended", NUMBER)),
        tuple(rows),
        "The recommended fit and the two of the textbook",
        Picture("I_zz", dots, (best - u, best + u), words),
        main=0,
    )
    impossible = {fit.name for fit in analysis.fits if fit.inertia is None}
    for short in (False, True):
        notes = [fit for fit in analysis.fits if (fit.name in impossible) == short]
        items = tuple((Styled(FIT_NAMES[fit.name], "strong"), f": {fit.note}") for fit in notes)
        if items:
            yield Text(items, "list", full=not short)


def _period(analysis: Analysis, torque: Scale) -> tuple[Block, ...]:
    words = (
        "At no torque are there two different spins, so the runs alone do not show how the period grows with the spin."
    )
    if analysis.exponent:
        words = (
            "At each torque the period grows in proportion to the spin: the runs lie on a straight line through zero, "
            "the steeper the smaller the torque."
            if _agrees(analysis.exponent.deviation)
            else "At each torque the period grows with the spin, though not in proportion within the uncertainties, "
            "as (b) shows."
        )
    # τ/ψ̇ in seconds for each 100 rpm.
    steepness = Scale("s per 100 rpm", r"s/(100\,rpm)", 1 / (100 * RPM.size))
    rows = tuple(
        (
            load(analysis, i, torque),
            Value(group.torque, None, torque, f"torques.{i}.torque"),
            (Number(str(group.runs), f"torques.{i}.runs"),),
            Value(group.period_per_spin, group.period_per_spin_u, steepness, f"torques.{i}.period_per_spin.value"),
        )
        for i, group in enumerate(analysis.torques)
    )
    heads = (Head("on the rod"), Head("torque M", torque), Head("runs", NUMBER), Head("τ/ψ̇", steepness))
    return (
        Text(((words,),), full=True),
        Figure("period", "Period τ against spin ψ̇, with the fitted law of each torque."),
        Table(heads, rows, "The period for each 100 rpm of spin", full=True),
    )


def _exponents(analysis: Analysis, torque: Scale) -> tuple[Block, ...]:
    whole = analysis.exponent
    if whole is None:
        words = "No torque has runs at two different spins, so the log does not tell the exponent n of τ ∝ ψ̇ⁿ."
        return (Text(((words,),), full=True),)
    law = "τ = 2π I_zz ψ̇ / |M + M0|"
    away = Number(_signed(whole.deviation), "exponent.deviation")
    agree: Sentence = (
        "The exponent agrees with 1 (",
        away,
        f" u from it): the period is proportional to the spin, {law}.",
    )
    if not _agrees(whole.deviation):
        advice = "look at the torques one by one, and at the flagged runs"
        agree = ("The exponent does not agree with 1 (", away, f" u from it), where eq. (9) has {law}: {advice}.")
    everything = Value(whole.value, whole.u, NUMBER, "exponent.value")
    rows: list[tuple[Cell, ...]] = [
        (
            load(analysis, i, torque),
            None if law.exponent is None else Value(law.exponent, law.u, NUMBER, f"power_law.{i}.exponent"),
            None if law.exponent is not None else (law.reason,),
        )
        for i, law in enumerate(analysis.power_law)
    ]
    rows.append((("all together",), everything, None))
    laws = [None if law.exponent is None else (law.exponent, law.u or 0.0) for law in analysis.power_law]
    dots = (*laws, (whole.value, whole.u))
    heads = (Head("on the rod"), Head("exponent n", NUMBER), Head("remark", wrap=0.45))
    picture = Picture("exponent n", dots, (1.0, 1.0), "the bars are ± u, the line is n = 1")
    table = _filled(heads, rows, "Exponent of each torque, and one for all", picture, main=len(rows) - 1)
    return (Text((("τ ∝ ψ̇ⁿ with n = ", everything),), "result", True), Text((agree,), full=True), table)


def _product(analysis: Analysis, scale: Scale, torque: Scale) -> tuple[Block, ...]:
    found = analysis.constancy
    sentence: Sentence = ("No torque has two runs, so the log does not tell whether φ̇ψ̇ is constant at one torque.",)
    if found is not None:
        constant, where = (
            ("constant within the uncertainties", ", and ")
            if found.p >= UNLIKELY
            else ("not constant within the stated uncertainties", ", where ")
        )
        sentence = (
            f"At one torque φ̇ψ̇ is {constant}: the runs scatter about the mean of their torque by ",
            *_percent(found.scatter, "constancy.scatter", signed=False), where,
            *_percent(found.expected, "constancy.expected", signed=False), " is expected from timing and spin (",
            *_chance(found.p, "constancy.p"), ").",
        )  # fmt: skip
    rows: list[tuple[Cell, ...]] = []
    for i, group in enumerate(analysis.torques):
        at, spread, without = f"torques.{i}.product", group.product_spread, group.without
        rows.append(
            (
                load(analysis, i, torque),
                Value(group.product, group.product_u, PRODUCT, f"{at}.value"),
                None if spread is None else Value(spread, None, PRODUCT, f"{at}.spread", is_u=True),
                None if group.product_p is None else _chance(group.product_p, f"{at}.p"),
                None if without is None else Value(without.value, without.u, scale, f"torques.{i}.without.value"),
            )
        )
    heads = (Head("on the rod"), Head("mean φ̇ψ̇", PRODUCT), Head("scatter", PRODUCT), Head("chance of it", NUMBER),
             Head("I_zz without", scale))  # fmt: skip
    caption = (
        "The weighted mean at each torque, the standard deviation of the single runs and the chance of one as large, "
        "and what I_zz would be without these runs"
    )
    figure = Figure("product", "φ̇ψ̇ against spin, with the mean of each torque and its band, ± 2 u.")
    return (Text((sentence,), full=True), figure, _filled(heads, rows, caption))


def _constant(analysis: Analysis, scale: Scale, torque: Scale) -> tuple[Block, ...]:
    inertia, m0, origin = analysis.inertia, analysis.residual_torque, analysis.fits[1]
    law: Sentence = ("M + M0 = I_zz φ̇ψ̇ with I_zz = ", Value(inertia.value, inertia.u, scale, "inertia.value"))
    balance = ""
    if m0.u:
        balance = ": no sign of an imperfect balance" if _agrees(m0.value / m0.u) else ": the balance was not perfect"
    value = Value(m0.value, m0.u, torque, "residual_torque.value")
    words: Sentence = (
        "The torque grows in proportion to φ̇ψ̇, but for a residual torque of ",
        value,
        f", which shifts the line and leaves its slope alone{balance}.",
    )
    if analysis.doubts:
        unsaid = "Whether the torque grows in proportion to φ̇ψ̇ these runs do not show: they do not follow one line."
        words = (
            f"{unsaid} If they did, the residual torque would be ",
            value,
            ", and the slope I_zz as above.",
        )
    if origin.inertia is not None and origin.deviation is not None:
        slope = Value(origin.inertia.value, origin.inertia.u, scale, "fits.1.inertia.value")
        away = Number(_signed(origin.deviation), "fits.1.deviation")
        words = (*words, " A line forced through the origin has the slope ", slope, ", ", away, " u from it.")
    caption = "Torque M against φ̇ψ̇ with the recommended line and its 95 % band; dashed, the line through the origin."
    return (Text((law,), "result", True), Text((words,), full=True), Figure("torque", caption))


def _meaning(analysis: Analysis, scale: Scale) -> Iterator[Block]:
    words = (
        "The constant is the moment of inertia of all that spins, ball, rod and weight, about the rod: as a mass "
        "resists a change of its speed, I_zz resists a change of the spin, and the larger it is, the slower the same "
        "torque turns the axis."
    )
    yield Text(((words,),), full=True)
    ball, inertia = analysis.ball, analysis.inertia
    if ball is None:
        lines = Styled("# ball_mass: 4.10 ± 0.01 kg", "code"), Styled("# ball_diameter: 10.16 ± 0.01 cm", "code")
        ask: Sentence = (
            "With the ball's mass and diameter in the log (",
            lines[0],
            ", ",
            lines[1],
            ") it is compared with 2/5 m r² here.",
        )
        yield Text((ask,), "small", full=True)
        return
    exact = " (taken as exact: the log gives no uncertainty). " if ball.inertia_u is None else ". "
    whole = Value(ball.inertia, ball.inertia_u, inertia_scale(ball.inertia, ball.inertia_u), "ball.inertia")
    described: Sentence = ("The disk that the log describes has ½ m r² = ", whole, exact)
    if ball.mass is not None and ball.diameter is not None:
        parts = (("its bore", ball.bore), ("its rod", ball.rod), ("the disk", ball.disk))
        added = " and ".join(words for words, part in parts if part)
        described = (
            "A ball of ", Value(ball.mass, ball.mass_u, mass_scale(ball.mass), "ball.mass"), " and ",
            Value(ball.diameter, ball.diameter_u, CENTIMETRE, "ball.diameter"),
            f" has 2/5 m r²{' with ' if added else ''}{added} = ", whole, exact,
        )  # fmt: skip
    yield Text(((*described, *_beside(analysis)),), full=True)
    rows: list[tuple[Cell, ...]] = [(("measured, I_zz",), Value(inertia.value, inertia.u, scale, "inertia.value"))]
    for words, part, key in (
        ("solid ball, 2/5 m r²", ball.solid, "solid"),
        ("its bore, for the same mass", ball.bore, "bore"),
        ("rod, ½ m r²", ball.rod, "rod"),
        ("disk, ½ m r²", ball.disk, "disk"),
    ):
        # One part is all of it, and has its u there.
        if part and part != ball.inertia:
            rows.append(((words,), Value(part, None, scale, f"ball.{key}")))
    between = len(rows) - 1
    all_of_it = "solid ball, 2/5 m r²" if ball.solid == ball.inertia else "all of it as the log describes it"
    rows.append(((all_of_it,), replace(whole, scale=scale)))
    rows.append((("difference",), Value(ball.difference, ball.difference_u, scale, "ball.difference")))
    own = (inertia.value, inertia.u or 0.0)
    dots = (own, *(None for _ in range(between)), (ball.inertia, ball.inertia_u or 0.0), None)
    band = (own[0] - own[1], own[0] + own[1])
    picture = Picture("value", dots, band, "the bars are ± u, the band is that of the measured value")
    heads = (Head("moment of inertia"), Head("value", scale))
    yield Table(heads, tuple(rows), "Measured, and as the log describes what spins", picture, main=0, full=True)


def _beside(analysis: Analysis) -> Sentence:
    """Say whether the measured value agrees with that of the ball or disk."""
    ball = analysis.ball
    assert ball is not None
    body = "ball" if ball.mass is not None else "disk"
    relative = _percent(ball.relative, "ball.relative")
    if ball.deviation is None:
        return (
            f"The measured value differs from that of the {body} by ",
            *relative,
            "; without an uncertainty nothing says whether that is much.",
        )
    away = Number(_signed(ball.deviation), "ball.deviation")
    agrees = _agrees(ball.deviation)
    bore = ""
    if not agrees and ball.mass is not None and not ball.bore:
        bore = (
            " A bore along the rod takes mass from near the axis, so that a ball of the same mass has a little more "
            "than 2/5 m r², and the rod and the weights on it add theirs."
        )
    return (
        f"The measured value {'agrees' if agrees else 'does not agree'} with that of the {body}: the difference is ",
        *relative, ", or ", away, f" u of the difference.{bore}",
    )  # fmt: skip


def _runs(analysis: Analysis, torque: Scale) -> tuple[Block, ...]:
    table = analysis.run_table
    odd = tuple(i for i, run in enumerate(table) if run.flagged)
    kept = "kept, as asked" if analysis.options.keep_flagged else "kept"
    group_of = {i: g for g, group in enumerate(torque_groups(analysis.measurements)) for i in group}

    def fate(run: Run) -> str:
        return "left out" if run.left_out else kept

    items = tuple(
        (
            Styled("run ", "warn"), Number(table[i].run, f"runs.{i}.run"), " (line ",
            Number(str(table[i].line), f"runs.{i}.line"), f"), {fate(table[i])}: {table[i].reason}",
        )
        for i in odd
    )  # fmt: skip
    rows = []
    for i, (run, note) in enumerate(zip(table, analysis.readings.notes, strict=True)):
        at, off = f"runs.{i}", run.studentized_residual
        remark: Sentence = (Styled(fate(run), "strong"), f": {run.reason}") if run.flagged else ()
        if note:
            remark += ("; note: " if remark else "", Styled(note, "quote"))
        rows.append(
            (
                (Number(run.run, f"{at}.run"),),
                (Number(str(run.line), f"{at}.line"),),
                load(analysis, group_of[i], torque),
                Value(run.spin, None, RPM, f"{at}.spin"),
                Value(run.time, None, SECOND, f"{at}.time"),
                (Number(turn_words(run.turns).split(" ")[0], f"{at}.turns"),),
                Value(run.period, None, SECOND, f"{at}.period"),
                Value(run.product, None, PRODUCT, f"{at}.product"),
                None if off is None else (Number(_signed(off), f"{at}.studentized_residual"),),
                remark or None,
            )
        )
    heads = (
        Head("run"), Head("line", NUMBER), Head("on the rod"), Head("spin", RPM), Head("time", SECOND),
        Head("turns", NUMBER), Head("period τ", SECOND), Head("φ̇ψ̇", PRODUCT), Head("residual", Scale("u", "")),
        Head("remark", wrap=0.2),
    )  # fmt: skip
    caption = "The residual is the time minus what the other runs predict, in standard uncertainties"
    looks = Text((("These runs are flagged:",),)) if odd else Text((("No run is flagged or left out.",),))
    return (
        looks,
        *([Text(items, "list")] if odd else []),
        Figure("residuals", "Each run's time against what the other runs predict, in standard uncertainties."),
        Table(heads, tuple(rows), caption, odd=odd, sortable=True, full=True),
    )


def _effects(analysis: Analysis) -> tuple[Block, ...]:
    choice = ", as asked" if analysis.model.asked else ", the simplest that is good enough here"
    rows: list[tuple[Cell, ...]] = []
    for i, effect in enumerate(analysis.effects):
        size = "" if effect.size is None else f"{effect.size:.2f}" if effect.size < 10 else f"{effect.size:.0f}"
        size = "< 0.01" if effect.size and size == "0.00" else size
        rows.append(
            (
                (EFFECT_NAMES.get(effect.effect, effect.effect),),
                None if effect.bias is None else _percent(effect.bias, f"effects.{i}.bias"),
                (Number(size, f"effects.{i}.size"), " u") if size else None,
                (effect_verdict(effect),),
                (effect.reason,),
            )
        )
    heads = (Head("effect", wrap=0.2), Head("change of I_zz", NUMBER), Head("size", NUMBER), Head("verdict", wrap=0.12),
             Head("why", wrap=0.3, full=True))  # fmt: skip
    caption = "What I_zz would change by if the effect were left out of the model, in per cent and in its u"
    short = tuple(i for i, row in enumerate(rows) if row[1] is not None)
    model = Text(((f"Model: {MODEL_NAMES[analysis.model.name]}{choice}.",),))
    return (model, Table(heads, tuple(rows), caption, short=short))


def _budget(analysis: Analysis, scale: Scale) -> Iterator[Block]:
    rows = tuple(
        (
            (SOURCE_NAMES.get(share.source, share.source),),
            (Number(f"{100 * share.share:.1f}" if share.share >= 5e-4 else "< 0.1", f"budget.{i}.share", 0.01), " %"),
            Value(share.u_inertia, None, scale, f"budget.{i}.u_inertia", is_u=True),
            (share.shared_by,) if share.shared else ("each run its own",),
        )
        for i, share in enumerate(analysis.budget)
    )
    heads = (
        Head("source"),
        Head("share of u²", NUMBER),
        Head("u of I_zz", scale, full=True),
        Head("shared by", wrap=0.35),
    )
    bars = Picture("share of u²", tuple((share.share, 0.0) for share in analysis.budget), None)
    short = tuple(i for i, share in enumerate(analysis.budget) if share.share >= 0.01)
    caption = "Shares of the variance u² of I_zz, the largest first"
    yield Table(heads, rows, caption, bars, short=short) if rows else Text((("No source of uncertainty was stated.",),))
    if defaults := defaults_used(analysis):
        yield Text((("Not stated in the log, and taken by default:",),))
        yield Text(tuple((Styled(line, "code"),) for line in defaults), "list")


def _advice(analysis: Analysis) -> tuple[Block, ...]:
    if not analysis.advice:
        return (Text((("No single change stands out.",),), full=True),)
    words = Text((("Each computed for this log, the largest gain first.",),), full=True)
    return (words, Text(tuple((advice,) for advice in analysis.advice), "numbered"))


def _diagnostics(analysis: Analysis) -> tuple[Block, ...]:
    if not analysis.diagnostics:
        return (Text((("None: the log was read without a remark.",),), full=True),)
    return (Text(tuple(_diagnostic(i, found) for i, found in enumerate(analysis.diagnostics)), "list", full=True),)


def _diagnostic(index: int, found: Diagnostic) -> Sentence:
    place: Sentence = ()
    if found.line:
        place = (" (line ", Number(str(found.line), f"/diagnostics.{index}.line"))
        if found.column:
            place += (", column ", Number(str(found.column), f"/diagnostics.{index}.column"))
        place += (")",)
    code = Styled(f"{found.severity} {found.code}", "strong" if found.severity == "note" else "warn")
    return (code, *place, f": {found.message}", f"; {found.hint}" if found.hint else "")


def _provenance(analysis: Analysis) -> Block:
    units = {
        "g": ("m/s²", 1.0),
        "latitude": ("deg", math.radians(1)),
        "ball_mass": ("kg", 1.0),
        **dict.fromkeys(("ball_diameter", "bore_diameter", "bore_depth", "rod_diameter", "disk_diameter"), ("m", 1.0)),
        **dict.fromkeys(("rod_mass", "disk_mass"), ("kg", 1.0)),
    }
    constants = {"g": analysis.measurements.g, **analysis.readings.constants}
    facts = [
        Fact("tool", (f"gyrodata {__version__}",)),
        Fact("log", (analysis.name,)),
        Fact("its SHA-256", (Styled(analysis.sha256, "code"),)),
        *(
            Fact(f"option {key.replace('_', ' ')}", (_option(value),))
            for key, value in asdict(analysis.options).items()
        ),
        *(
            Fact(f"constant {key}", (Number(f"{value / size:.6g}", f"constants.{key}", size), f" {unit}"))
            for key, value in constants.items()
            for unit, size in (units[key],)
        ),
        *(Fact(f"# {key}", (Styled(value, "quote"),)) for key, value in analysis.readings.metadata.items()),
    ]
    return Facts(tuple(facts), full=True)


def _conventions() -> Block:
    return Facts(tuple(Fact(key.replace("_", " "), (says,)) for key, says in CONVENTIONS.items()), full=True)


# --- numbers -----------------------------------------------------------------------------------------------------


def _agrees(deviation: float | None) -> bool:
    return deviation is not None and abs(deviation) <= AGREES


def _count(number: int, noun: str, place: str) -> Sentence:
    return (Number(str(number), place), f" {noun}{'' if number == 1 else 's'}")


def _percent(value: float, place: str, signed: bool = True) -> Sentence:
    text = percent_text(value).removesuffix(" %")
    return (Number(text if signed else text.removeprefix("+"), place, 0.01), " %")


def _chance(p: float, place: str) -> Sentence:
    text = p_text(p).removeprefix("p ").removeprefix("= ")
    return ("p " if text[0] in "<>" else "p = ", Number(text, place))


def _signed(size: float) -> str:
    """Write a size in standard uncertainties: "-2.5"."""
    text = f"{size:+.1f}" if abs(size) < 10 else f"{size:+.0f}"
    return text[1:] if float(text) == 0 else text


def _option(value: object) -> str:
    if isinstance(value, Mapping):
        return ", ".join(f"{key} = {item}" for key, item in value.items()) or "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return "none" if value is None else str(value)


def _filled(
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
