"""What a written report holds, before it is Markdown or LaTeX: sections of sentences, tables and lists.

Text is plain here, whatever it holds: each form escapes it in its own way. Values keep their unit, so that each
form can write them in its own way too.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from gyrodata import __version__
from gyrodata.comparisons import Run, turn_words
from gyrodata.errors import Diagnostic
from gyrodata.reporting.phrases import (
    EFFECT_NAMES,
    FIT_NAMES,
    MODEL_NAMES,
    SOURCE_NAMES,
    common_torque_scale,
    defaults_used,
    difference_text,
    effect_verdict,
    goodness_text,
    interval_kind,
    option_text,
    shared_text,
    size_of_log,
    size_text,
)
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
    uncertainty_text,
    value_text,
)
from gyrodata.results import CONVENTIONS, Analysis


@dataclass(frozen=True, slots=True)
class Value:
    """A value to be written with its unit; in a table the column's head has the unit."""

    value: float
    """[SI unit]"""
    u: float | None
    """Standard uncertainty [SI unit]; None for a reading."""
    scale: Scale
    is_u: bool = False
    """True if the value is an uncertainty or a scatter itself: two digits are enough."""


@dataclass(frozen=True, slots=True)
class Interval:
    """An interval to be written with its unit."""

    low: float
    """[SI unit]"""
    high: float
    """[SI unit]"""
    scale: Scale


Sentence = tuple[str | Value | Interval, ...]
Cell = str | Value | None
"""None where there is nothing to say."""


@dataclass(frozen=True, slots=True)
class Head:
    """The head of a column."""

    words: str
    scale: Scale | None = None
    """Unit of the column's values."""
    wrap: float = 0.0
    """Part of the line that a column of long text may take; 0 for a column as wide as its cells."""


@dataclass(frozen=True, slots=True)
class Table:
    """A table with one row of heads."""

    heads: tuple[Head, ...]
    rows: tuple[tuple[Cell, ...], ...]


@dataclass(frozen=True, slots=True)
class Section:
    """A heading with what stands below it, in this order."""

    title: str
    sentences: tuple[Sentence, ...] = ()
    table: Table | None = None
    items: tuple[Sentence, ...] = ()


def part_text(part: str | Value | Interval, writing: Writing) -> str:
    """Write a part of a sentence as text."""
    if isinstance(part, Value):
        return value_text(part.value, part.u, part.scale, writing)
    if isinstance(part, Interval):
        times = " × " if part.scale.exponent else " "
        return f"{interval_text(part.low, part.high, part.scale.size)}{times}{part.scale}"
    return part


def head_text(head: Head) -> str:
    """Write the head of a column as text: "I_zz [10⁻³ kg·m²]"."""
    unit = str(head.scale or "")
    return f"{head.words} [{unit}]" if unit else head.words


def cell_text(cell: str | Value, writing: Writing) -> str:
    """Write a cell of a table as text: its unit stands in the column's head."""
    if isinstance(cell, str):
        return cell
    if cell.u:
        return number_text(cell.value, cell.u, cell.scale.size, writing)
    return (uncertainty_text if cell.is_u else reading_text)(cell.value, cell.scale.size)


def title(analysis: Analysis) -> str:
    """Name the report."""
    return f"Gyroscope lab: {analysis.name}, {size_of_log(analysis)}"


def answer(analysis: Analysis) -> Sentence:
    """Give the answer in one line."""
    inertia = analysis.inertia
    return ("I_zz = ", Value(inertia.value, inertia.u, inertia_scale(inertia.value, inertia.u)))


def sections(analysis: Analysis) -> tuple[Section, ...]:
    """Put an analysis into sections, in the order in which they are read; the first, below the answer, has no title."""
    scale = inertia_scale(analysis.inertia.value, analysis.inertia.u)
    torque = common_torque_scale(analysis)
    found = (
        _summary(analysis, scale, torque),
        _fits(analysis, scale, torque),
        _exponents(analysis, torque),
        _torques(analysis, scale, torque),
        _meaning(analysis),
        _runs(analysis, torque),
        _effects(analysis),
        _budget(analysis, scale),
        Section("Next time", items=tuple((advice,) for advice in analysis.advice)),
        Section("Remarks on the log", items=tuple((_remark(found),) for found in analysis.diagnostics)),
        Section("Conventions", items=tuple((f"{key.replace('_', ' ')}: {says}",) for key, says in CONVENTIONS.items())),
        _provenance(analysis),
    )
    return tuple(section for section in found if section.sentences or section.table or section.items)


def brief(analysis: Analysis) -> tuple[Section, ...]:
    """Put what a person reads first into sections: the answer, and the tables in fewer words."""
    scale = inertia_scale(analysis.inertia.value, analysis.inertia.u)
    torque = common_torque_scale(analysis)
    inertia, residual, bias = analysis.inertia, analysis.residual_torque, analysis.timing_bias
    sentences = [answer(analysis)]
    if inertia.interval_95 is not None:
        interval = Interval(*inertia.interval_95, scale)
        sentences.append(("       95 % interval ", interval, f" ({interval_kind(inertia)})"))
    m0 = Value(residual.value, residual.u, torque)
    sentences.append(("residual torque M0 = ", m0, " (torque at work = applied + M0)"))
    if bias.u:
        sentences.append(("timing bias b = ", Value(bias.value, bias.u, SECOND)))
    sentences.append((goodness_text(analysis),))
    fits = tuple(row for row in _fit_rows(analysis, scale, torque) if row[1] is not None)
    heads = (Head("fit"), Head("I_zz", scale), Head("M0", torque), Head("from recommended"))
    impossible = tuple((f"{FIT_NAMES[fit.name]}: {fit.note}",) for fit in analysis.fits if fit.inertia is None)
    shares: tuple[tuple[Cell, ...], ...] = tuple(
        (SOURCE_NAMES.get(share.source, share.source), f"{100 * share.share:.0f} %", shared_text(share))
        for share in analysis.budget
        if share.share >= 0.01
    )
    odd = tuple(
        (f"run {run.run} (line {run.line}): {run.reason}{'; left out' if run.left_out else '; kept'}",)
        for run in analysis.run_table
        if run.flagged
    )
    effects = tuple(row[:4] for row in _effect_rows(analysis) if row[1] is not None)
    model = f"what leaving it out does to I_zz (model: {MODEL_NAMES[analysis.model.name]}):"
    defaults = tuple((item,) for item in defaults_used(analysis))
    return (
        Section("", tuple(sentences)),
        Section("", table=Table(heads, fits), items=impossible),
        *([Section("where u² of I_zz comes from:", table=Table((Head(""),) * 3, shares))] if shares else []),
        Section("looks odd:", odd) if odd else Section("no run looks odd; none is left out"),
        Section(model, table=Table((Head(""), Head(""), Head("", NUMBER), Head("")), effects)),
        *([Section("uncertainties not in the log, taken by default:", defaults)] if defaults else []),
    )


def _summary(analysis: Analysis, scale: Scale, torque: Scale) -> Section:
    inertia, residual, bias = analysis.inertia, analysis.residual_torque, analysis.timing_bias
    sentences: list[Sentence] = []
    if inertia.interval_95 is not None:
        meaning = "every value stands with one standard uncertainty u, from the stated uncertainties."
        interval = Interval(*inertia.interval_95, scale)
        sentences.append(("The 95 % interval is ", interval, f" ({interval_kind(inertia)}); {meaning}"))
    meaning = "; the torque at work is the applied torque plus M0."
    sentences.append(("Residual torque M0 = ", Value(residual.value, residual.u, torque), meaning))
    if bias.u:
        sentences.append(("Timing bias b = ", Value(bias.value, bias.u, SECOND), "."))
    goodness = goodness_text(analysis)
    sentences.append((f"{goodness[0].upper()}{goodness[1:]}.",))
    return Section("", tuple(sentences))


def _fits(analysis: Analysis, scale: Scale, torque: Scale) -> Section:
    heads = (Head("fit"), Head("I_zz", scale), Head("M0", torque), Head("from recommended", NUMBER))
    notes = tuple((f"{FIT_NAMES[fit.name]}: {fit.note}",) for fit in analysis.fits)
    return Section("Three fits side by side", table=_filled(heads, _fit_rows(analysis, scale, torque)), items=notes)


def _fit_rows(analysis: Analysis, scale: Scale, torque: Scale) -> tuple[tuple[Cell, ...], ...]:
    return tuple(
        (
            FIT_NAMES[fit.name],
            Value(fit.inertia.value, fit.inertia.u, scale) if fit.inertia else None,
            Value(-fit.constant.value, fit.constant.u, torque) if fit.constant else None,
            difference_text(analysis, fit) or None,
        )
        for fit in analysis.fits
    )


def _exponents(analysis: Analysis, torque: Scale) -> Section:
    rows = tuple(
        (
            Value(law.torque, None, torque),
            None if law.exponent is None else Value(law.exponent, law.u, NUMBER),
            law.reason,
        )
        for law in analysis.power_law
    )
    sentences: list[Sentence] = [("A power law τ ∝ ψ̇ⁿ through the runs of one torque; eq. (9) says n = 1.",)]
    if (whole := analysis.exponent) is not None:
        away = f", {abs(whole.deviation):.1f} u from 1."
        sentences.append(("With one exponent for all torques n = ", Value(whole.value, whole.u, NUMBER), away))
    return Section(
        "Period against spin",
        tuple(sentences),
        Table((Head("torque M", torque), Head("exponent n", NUMBER), Head("remark", wrap=0.55)), rows),
    )


def _torques(analysis: Analysis, scale: Scale, torque: Scale) -> Section:
    mass = mass_scale(max((group.mass or 0.0 for group in analysis.torques), default=0.0))
    rows = tuple(
        (
            _reading(group.mass, mass),
            _reading(group.position if group.torque else None, CENTIMETRE),
            Value(group.torque, None, torque),
            str(group.runs),
            Value(group.product, group.product_u, PRODUCT),
            _reading(group.product_spread, PRODUCT, is_u=True),
            None if group.without is None else Value(group.without.value, group.without.u, scale),
        )
        for group in analysis.torques
    )
    heads = (
        Head("mass", mass),
        Head("position", CENTIMETRE),
        Head("torque M", torque),
        Head("runs", NUMBER),
        Head("mean φ̇ψ̇", PRODUCT),
        Head("scatter", PRODUCT),
        Head("I_zz without", scale),
    )
    words = (
        "For each torque: the weighted mean of precession rate times spin, the standard deviation of the single runs, "
        "and what I_zz would be without these runs."
    )
    sentences: list[Sentence] = [(words,)]
    if (constancy := analysis.constancy) is not None:
        scatter, expected = f"{100 * constancy.scatter:.2g} %", f"{100 * constancy.expected:.2g} %"
        chance = f"{p_text(constancy.p)} if the product is constant"
        sentences.append(
            (f"About these means the runs scatter by {scatter}; timing and spin make {expected} likely ({chance}).",)
        )
    return Section("Precession rate times spin", tuple(sentences), _filled(heads, rows))


def _meaning(analysis: Analysis) -> Section:
    """Compare with the solid ball where the log gives it."""
    ball = analysis.ball
    if ball is None:
        return Section("What the constant means")
    away = "" if ball.deviation is None else f", {abs(ball.deviation):.1f} standard uncertainties of the difference"
    sentence: Sentence = (
        "A solid ball of ",
        Value(ball.mass, ball.mass_u, mass_scale(ball.mass)),
        " and ",
        Value(ball.diameter, ball.diameter_u, CENTIMETRE),
        " has 2/5 m r² = ",
        Value(ball.inertia, ball.inertia_u, inertia_scale(ball.inertia, ball.inertia_u)),
        f". The measured I_zz is {percent_text(ball.relative)} from it{away}.",
    )
    return Section("What the constant means", (sentence,))


def _runs(analysis: Analysis, torque: Scale) -> Section:
    heads = (
        Head("run"),
        Head("line", NUMBER),
        Head("torque M", torque),
        Head("spin", RPM),
        Head("time", SECOND),
        Head("turns", NUMBER),
        Head("period τ", SECOND),
        Head("φ̇ψ̇", PRODUCT),
        Head("residual", SECOND),
        Head("remark", wrap=0.2),
    )
    rows = tuple(
        (
            run.run,
            str(run.line),
            Value(run.torque, None, torque),
            Value(run.spin, None, RPM),
            Value(run.time, None, SECOND),
            turn_words(run.turns).split(" ")[0],
            Value(run.period, None, SECOND),
            Value(run.product, None, PRODUCT),
            Value(run.residual, run.residual_u, SECOND),
            _run_remark(run, note) or None,
        )
        for run, note in zip(analysis.run_table, analysis.readings.notes, strict=True)
    )
    words = "The residual is the time minus the fitted time, with the spread expected of it."
    return Section("Runs", ((words,),), _filled(heads, rows))


def _run_remark(run: Run, note: str) -> str:
    flag = f"{'left out' if run.left_out else 'kept'}: {run.reason}" if run.flagged else ""
    return "; ".join(part for part in (flag, note) if part)


def _effects(analysis: Analysis) -> Section:
    heads = (Head("effect", wrap=0.2), Head("I_zz", NUMBER), Head("size", NUMBER), Head("model", wrap=0.12),
             Head("why", wrap=0.35))  # fmt: skip
    words = f"What leaving each one out would do to I_zz. The model is {MODEL_NAMES[analysis.model.name]}."
    return Section("Effects considered", ((words,),), _filled(heads, _effect_rows(analysis)))


def _effect_rows(analysis: Analysis) -> tuple[tuple[Cell, ...], ...]:
    return tuple(
        (
            EFFECT_NAMES.get(effect.effect, effect.effect),
            None if effect.bias is None else percent_text(effect.bias),
            None if effect.size is None else size_text(effect.size),
            effect_verdict(effect),
            effect.reason,
        )
        for effect in analysis.effects
    )


def _budget(analysis: Analysis, scale: Scale) -> Section:
    rows = tuple(
        (
            SOURCE_NAMES.get(share.source, share.source),
            f"{100 * share.share:.1f} %" if share.share >= 0.0005 else "< 0.1 %",
            Value(share.u_inertia, None, scale, is_u=True),
            shared_text(share),
        )
        for share in analysis.budget
    )
    heads = (Head("source"), Head("share of u²", NUMBER), Head("u of I_zz", scale), Head("shared by", wrap=0.35))
    defaults = defaults_used(analysis)
    assumed = (("Not stated in the log and taken by default: " + "; ".join(defaults) + ".",),)
    table = Table(heads, rows) if rows else None
    return Section("Where the uncertainty comes from", assumed if defaults else (), table)


def _remark(found: Diagnostic) -> str:
    place = f" (line {found.line})" if found.line else ""
    return f"{found.severity} {found.code}{place}: {found.message}" + (f"; {found.hint}" if found.hint else "")


def _provenance(analysis: Analysis) -> Section:
    told = {
        "tool": f"gyrodata {__version__}",
        "log": analysis.name,
        "its SHA-256": analysis.sha256,
        **{f"option {key.replace('_', ' ')}": option_text(value) for key, value in vars(analysis.options).items()},
        **{f"# {key}": value for key, value in analysis.readings.metadata.items()},
    }
    return Section("Provenance", items=tuple((f"{key}: {value}",) for key, value in told.items()))


def _reading(value: float | None, scale: Scale, is_u: bool = False) -> Value | None:
    return None if value is None else Value(value, None, scale, is_u)


def _filled(heads: tuple[Head, ...], rows: Iterable[tuple[Cell, ...]]) -> Table:
    """Leave out the columns in which no row has anything."""
    rows = tuple(rows)
    told = [i for i in range(len(heads)) if any(row[i] is not None for row in rows)]
    return Table(tuple(heads[i] for i in told), tuple(tuple(row[i] for i in told) for row in rows))
