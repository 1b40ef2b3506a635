"""The content of the report of one analysis, for every format: answer, evidence and advice."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from msgspec.structs import asdict

from gyrodata import __version__
from gyrodata.diagnostics import DIGITS_TOO_FEW, SIZE_NOT_USUAL
from gyrodata.errors import Diagnostic
from gyrodata.fitting import Estimate
from gyrodata.measurements import torque_groups
from gyrodata.plotting import FIGURES
from gyrodata.readings import kind_of_role
from gyrodata.reporting import values
from gyrodata.reporting.phrases import EFFECT_NAMES, FIT_NAMES, MODEL_NAMES, SOURCE_NAMES, defaults_used, effect_verdict
from gyrodata.reporting.questions import answer_questions, beside
from gyrodata.reporting.tree import (
    UNLIKELY,
    Block,
    Cell,
    Fact,
    Facts,
    Figure,
    Head,
    Interval,
    Number,
    Part,
    Picture,
    Report,
    Section,
    Sentence,
    Styled,
    Table,
    Text,
    Value,
    chance,
    count,
    hung,
    load,
    percent,
    signed,
)
from gyrodata.results import CONVENTIONS, NO_BALL, Analysis
from gyrodata.tables import Run, turn_words

WIDE = 3.0
"""Coverage factor k above which the answer is an interval, because ± 2 u is far from the 95 % interval."""

NOTICEABLE = 1.15
"""A factor on the errors of the runs that is worth a word [1]."""

WEIGHTS = 5
"""Of so many weights, those that move the answer most, the summary tells what it would be without them."""

FAR = 2.0
"""From how many standard uncertainties on a run is worth repeating that does not yet look odd."""

FIRST = {DIGITS_TOO_FEW, SIZE_NOT_USUAL}
"""Diagnostics that are not doubts, and that the page shows on its first screen."""

FEW = 3
"""Of runs or of advice, so many are told on the first screen."""

UNTOLD = 0.3
"""A balance with a larger share of u² than this is not told by the design [1]."""

REFERENCES = (
    "JCGM 100:2008 and JCGM 101:2008, Guide to the expression of uncertainty in measurement, and its Supplement 1",
    "York and others, on the best straight line, Am. J. Phys. 72, 367 (2004)",
    "Thompson and Ellison, Dark uncertainty, Accred. Qual. Assur. 16, 483 (2011)",
    "Goldstein, Classical Mechanics, on the heavy symmetrical top, for eqs. (8) and (9)",
)
"""What the method rests on."""


# --- the tree ----------------------------------------------------------------------------------------------------


def report(analysis: Analysis) -> Report:
    """Put an analysis into sections, in the order in which they are read."""
    inertia = analysis.inertia
    scale = values.inertia_scale(inertia.value, inertia.u)
    torque = common_torque_scale(analysis)
    found = (
        Section("", tuple(_summary(analysis, scale, torque))),
        Section("Sensitivity to assumptions", _sensitivity(analysis, scale), "sensitivity", "Sensitivity"),
        Section("Three fits side by side", tuple(_fits(analysis, scale, torque)), "fits", "Fits"),
        *answer_questions(analysis, scale, torque),
        Section("Runs", _runs(analysis, torque), "runs", "Runs"),
        Section("Effects considered", _effects(analysis), "effects", "Effects"),
        Section("Uncertainty budget", tuple(_budget(analysis, scale)), "uncertainty", "Uncertainty"),
        Section("How to improve the next lab", _advice(analysis), "advice", "Next time"),
        Section("Diagnostics", _diagnostics(analysis), "diagnostics", "Diagnostics"),
        Section("Method and how to cite it", tuple(_method(analysis)), "method", "Method"),
        Section("Provenance", (_provenance(analysis),), "provenance", "Provenance"),
        Section("Conventions", (_conventions(),), "conventions", "", 3),
    )
    answer: Sentence = ("I_zz = ", Value(inertia.value, inertia.u, scale, "inertia.value"))
    if inertia.interval_95 is not None and (inertia.k or 0.0) > WIDE:
        answer = ("I_zz = ", Interval(*inertia.interval_95, scale, "inertia.interval_95"))
    brief = tuple(_brief(analysis, scale, torque))
    return Report(analysis.name, _size(analysis), _read_as(analysis, torque), _doubts(analysis), answer, brief, found)


def common_torque_scale(analysis: Analysis) -> values.Scale:
    """Choose one unit for every torque of a log, so that they can be compared at a glance."""
    return values.torque_scale(max(abs(run.torque) for run in analysis.run_table))


def residual_torque(analysis: Analysis, scale: values.Scale) -> Fact:
    """Give the residual torque."""
    found = analysis.residual_torque
    value = Value(found.value, found.u, scale, "residual_torque.value")
    return Fact("residual torque", (value,), "M0", ("net torque = applied torque + M0",))


def _size(analysis: Analysis) -> Sentence:
    runs, torques = len(analysis.run_table), len(analysis.torques)
    return (*count(runs, "run", "/input.rows"), ", ", *count(torques, "torque", "torques.length"))


def _summary(analysis: Analysis, scale: values.Scale, torque: values.Scale) -> Iterator[Block]:
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
        yield Text((("95 % interval: ", interval, " (", *found, ")"),))
    facts = [residual_torque(analysis, torque)]
    if bias.u:
        facts.append(Fact("timing bias", (Value(bias.value, bias.u, values.SECOND, "timing_bias.value"),), "b"))
    facts.append(_goodness(analysis))
    # The summary names them where it lists them.
    flagged = [Number(run.run, f"runs.{i}.run") for i, run in enumerate(analysis.run_table) if run.flagged]
    names = tuple(part for name in flagged[:6] for part in (", ", name))[1:] + ((" and more",) * (len(flagged) > 6))
    yield Facts((*facts, Fact("suspected outliers", names or ("none",), full=True)))
    yield Text(
        (("Every ± is one standard uncertainty u, which includes the scatter of the runs.",),),
        "small",
        full=True,
    )


def _read_as(analysis: Analysis, torque: values.Scale) -> Sentence:
    """Say one run in words, the first with a load: what was read, and what was made of it."""
    i, run = next((i, run) for i, run in enumerate(analysis.run_table) if run.torque)
    at, measured = f"runs.{i}", analysis.measurements
    if run.mass is None or run.position is None:
        on_the_rod: Sentence = ("a torque of ", Value(run.torque, None, torque, f"{at}.torque"))
    else:
        on_the_rod = (*hung(analysis, i, at), " from the centre")
    spin = Value(run.spin, None, values.RPM, f"{at}.spin")
    count, turns = turn_words(run.turns).split(" ")
    time = Value(run.time, None, values.SECOND, f"{at}.time")
    timed: Sentence = (", ", Number(count, f"{at}.turns"), f" {turns} in ", time) if measured.timed else ()
    made: Sentence = (": ", Value(run.torque, None, torque, f"{at}.torque")) if run.mass is not None else ()
    period = Value(run.period, None, values.SECOND, f"{at}.period")
    return ("Read as: run ", Number(run.run, f"{at}.run"), ": ", *on_the_rod, ", ", spin, *timed, *made,
            ", one turn in ", period, ".")  # fmt: skip


def _doubts(analysis: Analysis) -> tuple[Sentence, ...]:
    """Return the reasons why the answer is not reliable, if u does not include what is wrong."""
    if not analysis.doubts:
        return ()
    first, *others = analysis.doubts
    end = "" if first.remedy.endswith("?") else "."
    more = tuple((Styled("Also: ", "warn"), f"{other.words}.") for other in others)
    return (
        (Styled("Do not rely on this answer: ", "warn"), f"{first.words}. Find the cause: {first.remedy}{end}"),
        *more,
    )


def _brief(analysis: Analysis, scale: values.Scale, torque: values.Scale) -> Iterator[Sentence]:
    """Say what fits on a screen."""
    yield _verdict(analysis)
    if analysis.if_balanced is not None:
        yield from _on_balance(analysis, analysis.if_balanced, scale)
    inertia, m0 = analysis.inertia, analysis.residual_torque
    if inertia.interval_95 is not None and (inertia.k or 0.0) > WIDE:
        value = Value(inertia.value, inertia.u, scale, "inertia.value")
        yield ("Median and half of the 68 % interval: ", value, "; the 95 % interval is much wider than ± 2 u.")
    elif inertia.interval_95 is not None:
        yield (
            "95 % interval: ", Interval(*inertia.interval_95, scale, "inertia.interval_95"),
            "; torque without a weight M0 = ", Value(m0.value, m0.u, torque, "residual_torque.value"),
            " (included in the fit)",
        )  # fmt: skip
    yield (NO_BALL,) if analysis.ball is None else beside(analysis)
    yield from _to_repeat(analysis)
    for advice in analysis.advice[:1] if not analysis.doubts else ():
        yield (f"To improve (optional): {advice}",)


def _to_repeat(analysis: Analysis) -> Iterator[Sentence]:
    """Name the suspected outliers, and the runs that are worth repeating."""
    table = analysis.run_table
    odd = [i for i, run in enumerate(table) if run.flagged]
    far = [
        i
        for i, run in enumerate(table)
        if i not in odd and run.studentized_residual is not None and abs(run.studentized_residual) > FAR
    ]
    for i in odd[:FEW]:
        fate = "left out" if table[i].left_out else "kept"
        yield (
            "Suspected outlier: ",
            *_run_place(analysis, i),
            f", {fate}: {table[i].reason}. Check it, or repeat the run.",
        )
    if len(odd) > FEW:
        yield (f"{len(odd) - FEW} more suspected outliers are marked in the table of runs.",)
    if far:
        named = [part for i in far[:FEW] for part in (", ", *_run_place(analysis, i))][1:]
        them = "it is" if len(far) == 1 else "they are"
        yield ("If you have time, repeat ", *named, f": {them} over {FAR:g} u away from the other runs' prediction.")
    if not odd and not far:
        yield ("No suspected outliers." if analysis.doubts else "No suspected outliers; you need not repeat any run.",)


def _run_place(analysis: Analysis, i: int) -> Sentence:
    run = analysis.run_table[i]
    return ("run ", Number(run.run, f"runs.{i}.run"), " (line ", Number(str(run.line), f"runs.{i}.line"), ")")


def _verdict(analysis: Analysis) -> Sentence:
    """Say in one sentence whether the runs agree, and what the largest part of u is."""
    return (*_agreement(analysis), *_largest_part(analysis))


def _agreement(analysis: Analysis) -> Sentence:
    scatter, time_u = analysis.fit.scatter, analysis.measurements.time_u
    the_runs: Sentence = ("The ", *count(len(analysis.run_table), "run", "/input.rows"))
    if any(run.left_out for run in analysis.run_table):
        the_runs = ("Of the ", *the_runs[1:], ", those that were kept")
    if analysis.p is None:
        return ("There are as many unknowns as runs, so nothing shows if they agree",)
    if analysis.runs_disagree:
        return (*the_runs, " do not agree with one straight line within the stated uncertainties")
    if analysis.p >= UNLIKELY:
        better = ", better than stated" if analysis.p > 1 - UNLIKELY / 2 else ""
        return (*the_runs, f" agree with one straight line{better}")
    if scatter < NOTICEABLE:
        return (*the_runs, " agree badly with one straight line")
    stated: Part = "the log" if time_u is None else Value(time_u, None, values.SECOND, "goodness.time_u")
    times = Number(values.uncertainty_text(scatter), "goodness.scatter")
    return (*the_runs, " scatter ", times, " times as much as the timing uncertainty of ", stated,
            "; u already includes this")  # fmt: skip


def _largest_part(analysis: Analysis) -> Iterator[Part]:
    """Name the largest uncertainty component, and a balance that these runs do not determine."""
    if not analysis.budget:
        yield "."
        return
    largest = analysis.budget[0]
    if largest.source != "residual_torque":
        name = SOURCE_NAMES.get(largest.source, largest.source)
        name = name if name == "g" or name.startswith("each") else f"the {name}"
        shares = {share.source: share.share for share in analysis.budget}
        scatter, of = shares.get("unexplained_scatter", 0.0), _share(largest.share, 0)
        if scatter and largest.source in ("time", "unexplained_scatter") and "time" in shares:
            # The scatter above the stated uncertainties is most likely that of the hand.
            name, of = (
                "the stopwatch readings with their unexplained scatter",
                (f"{100 * (scatter + shares['time']):.0f} %",),
            )
        yield from (f". Largest uncertainty: {name} (", *of, " of the variance).")
    for at, share in enumerate(analysis.budget):
        if share.source == "residual_torque" and (at == 0 or share.share > UNTOLD):
            yield "." * (at == 0)
            words = " These runs cannot show how well the ball is balanced. This uncertainty is "
            yield from (words, "the largest: " * (at == 0), *_share(share.share, at), " of the variance.")


def _share(share: float, at: int) -> Sentence:
    return (Number(f"{100 * share:.0f}", f"budget.{at}.share", 0.01), " %")


def _on_balance(analysis: Analysis, balanced: Estimate, scale: values.Scale) -> tuple[Sentence, ...]:
    """Say which assumption I_zz depends on if all torques are equal."""
    measured = analysis.measurements
    if measured.torque_unseen is not None:
        return (("All torques are equal, so the answer depends on the run without a weight.",),)
    if measured.balanced or measured.balance_test is not None:
        by = "the balance test" if measured.balance_test is not None else "the ball being balanced"
        return ((f"All torques are equal, so the answer depends on {by}.",),)
    value, line = Value(balanced.value, balanced.u, scale, "if_balanced.value"), Styled("# balanced: yes", "code")
    usual = "; a usual imbalance, 5 % of the torque, changes it by 5 %."
    return (
        ("If the ball is balanced as in step 2, I_zz = ", value, usual),
        (
            "All torques are equal. To decide, write ",
            line,
            ", add a balance test, or time a run without an added mass.",
        ),
    )


def _sensitivity(analysis: Analysis, scale: values.Scale) -> tuple[Block, ...]:
    """Show I_zz, and its value after one change of the assumptions."""
    if not analysis.sensitivity:
        return ()
    answer, u = analysis.inertia, analysis.inertia.u or 0.0
    rows: list[tuple[Cell, ...]] = [(("no change",), Value(answer.value, answer.u, scale, "inertia.value"), None)]
    dots: list[tuple[float, float] | None] = [(answer.value, u)]
    for i, case in enumerate(analysis.sensitivity):
        at, found = f"sensitivity.{i}", case.inertia
        away = None if case.deviation is None else (Number(signed(case.deviation), f"{at}.deviation"), " u")
        value = ("no answer",) if found is None else Value(found.value, found.u, scale, f"{at}.inertia.value")
        rows.append(((case.words,), value, away))
        dots.append(None if found is None else (found.value, found.u or 0.0))
    heads = (Head("if"), Head("I_zz", scale), Head("shift", values.NUMBER))
    band = (answer.value - u, answer.value + u)
    picture = Picture("I_zz", tuple(dots), band, "the bars are ± u, the band is that of the answer", reach=5.0)
    weights = [i for i, case in enumerate(analysis.sensitivity, 1) if case.name == "without"]
    weights.sort(key=lambda i: -abs(analysis.sensitivity[i - 1].deviation or 0.0))
    short = tuple(i for i in range(len(rows)) if i not in weights[WEIGHTS:])
    return (
        Table(heads, tuple(rows), "I_zz after one change; the shift is in units of u", picture, main=0, short=short),
    )


def _goodness(analysis: Analysis) -> Fact:
    fit = analysis.fit
    if analysis.p is None:
        return Fact("fit quality", ("not available: no degrees of freedom",))
    chi2 = Number(f"{fit.chi2:.3g}", "goodness.chi2")
    scatter = Number(values.uncertainty_text(fit.scatter), "goodness.scatter")
    dof = count(fit.dof, "degree", "goodness.dof")
    return Fact(
        "fit quality",
        chance(analysis.p, "goodness.p"),
        remark=("chi-square ", chi2, " for ", *dof, " of freedom; scatter ", scatter, " times the stated one"),
    )


def _fits(analysis: Analysis, scale: values.Scale, torque: values.Scale) -> Iterator[Block]:
    rows: list[tuple[Cell, ...]] = []
    for i, fit in enumerate(analysis.fits):
        at, value, m0 = f"fits.{i}", fit.inertia, fit.constant
        away: Cell = None
        if fit.deviation is not None and fit.difference is not None:
            relative = percent(fit.difference, f"{at}.difference")
            away = (Number(signed(fit.deviation), f"{at}.deviation"), " u (", *relative, ")")
        rows.append(
            (
                (FIT_NAMES[fit.name],),
                Value(value.value, value.u, scale, f"{at}.inertia.value") if value else ("not possible",),
                Value(-m0.value, m0.u, torque, f"{at}.constant.value") if m0 else ("assumed 0",) if value else None,
                away,
            )
        )
    best, u = analysis.inertia.value, analysis.inertia.u or 0.0
    dots = tuple(None if fit.inertia is None else (fit.inertia.value, fit.inertia.u or 0.0) for fit in analysis.fits)
    words = "the bars are ± u, the band is that of the recommended fit"
    yield Table(
        (Head("fit"), Head("I_zz", scale), Head("M0", torque), Head("from recommended", values.NUMBER)),
        tuple(rows),
        "The recommended fit, and the two straight lines of the textbook",
        Picture("I_zz", dots, (best - u, best + u), words),
        main=0,
    )
    impossible = {fit.name for fit in analysis.fits if fit.inertia is None}
    for short in (False, True):
        notes = [fit for fit in analysis.fits if (fit.name in impossible) == short]
        items = tuple((Styled(FIT_NAMES[fit.name], "strong"), f": {fit.note}") for fit in notes)
        if items:
            yield Text(items, "list", full=not short)


def _runs(analysis: Analysis, torque: values.Scale) -> tuple[Block, ...]:
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
                Value(run.spin, None, values.RPM, f"{at}.spin"),
                Value(run.time, None, values.SECOND, f"{at}.time"),
                (Number(turn_words(run.turns).split(" ")[0], f"{at}.turns"),),
                Value(run.period, None, values.SECOND, f"{at}.period"),
                Value(run.product, None, values.PRODUCT, f"{at}.product"),
                None if off is None else (Number(signed(off), f"{at}.studentized_residual"),),
                remark or None,
            )
        )
    heads = (
        Head("run"),
        Head("line", values.NUMBER),
        Head("load"),
        Head("spin", values.RPM),
        Head("time", values.SECOND),
        Head("turns", values.NUMBER),
        Head("period τ", values.SECOND),
        Head("φ̇ψ̇", values.PRODUCT),
        Head("residual", values.Scale("u", "u")),
        Head("remark", wrap=0.2),
    )
    caption = "The residual is the time minus the time that the other runs predict, in units of u"
    looks = Text((("Suspected outliers:",),)) if odd else Text((("No suspected outliers; all runs are in the fit.",),))
    return (
        looks,
        *([Text(items, "list")] if odd else []),
        Figure("residuals", FIGURES["residuals"].caption),
        Table(heads, tuple(rows), caption, odd=odd, sortable=True, full=True),
    )


def _effects(analysis: Analysis) -> tuple[Block, ...]:
    choice = ", as asked" if analysis.model.asked else ", the simplest model that is sufficient here"
    rows: list[tuple[Cell, ...]] = []
    for i, effect in enumerate(analysis.effects):
        size = "" if effect.size is None else f"{effect.size:.2f}" if effect.size < 10 else f"{effect.size:.0f}"
        size = "< 0.01" if effect.size and size == "0.00" else size
        rows.append(
            (
                (EFFECT_NAMES.get(effect.effect, effect.effect),),
                None if effect.bias is None else percent(effect.bias, f"effects.{i}.bias"),
                (Number(size, f"effects.{i}.size"), " u") if size else None,
                (effect_verdict(effect),),
                (effect.reason,),
            )
        )
    heads = (
        Head("effect", wrap=0.2),
        Head("change of I_zz", values.NUMBER),
        Head("size", values.NUMBER),
        Head("verdict", wrap=0.12),
        Head("why", wrap=0.3, full=True),
    )
    caption = "Change of I_zz if the effect is ignored, in % and in units of u"
    short = tuple(i for i, row in enumerate(rows) if row[1] is not None)
    model = Text(((f"Model: {MODEL_NAMES[analysis.model.name]}{choice}.",),))
    return (model, Table(heads, tuple(rows), caption, short=short))


def _budget(analysis: Analysis, scale: values.Scale) -> Iterator[Block]:
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
        Head("component"),
        Head("share of the variance", values.NUMBER),
        Head("u of I_zz", scale, full=True),
        Head("shared by", wrap=0.35),
    )
    bars = Picture("share of the variance", tuple((share.share, 0.0) for share in analysis.budget), None)
    short = tuple(i for i, share in enumerate(analysis.budget) if share.share >= 0.01)
    caption = "Uncertainty components with their shares of the variance u² of I_zz, the largest first"
    yield Table(heads, rows, caption, bars, short=short) if rows else Text((("The log states no uncertainty.",),))
    if defaults := defaults_used(analysis):
        yield Text((("The log does not state these uncertainties, so default values are used:",),))
        yield Text(tuple((Styled(line, "code"),) for line in defaults), "list")


def _advice(analysis: Analysis) -> tuple[Block, ...]:
    if not analysis.advice:
        return (Text((("No single change would help much.",),), full=True),)
    words = Text((("Each line is computed for this log, the largest gain first.",),), full=True)
    return (words, Text(tuple((advice,) for advice in analysis.advice), "numbered"))


def _diagnostics(analysis: Analysis) -> tuple[Block, ...]:
    if not analysis.diagnostics:
        return (Text((("None.",),), full=True),)
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


def _method(analysis: Analysis) -> Iterator[Block]:
    """Say in a paragraph how the answer was found, and what to write of it elsewhere."""
    left_out = any(run.left_out for run in analysis.run_table)
    the_runs: Sentence = ("the ", *count(len(analysis.run_table), "run", "/input.rows"))
    the_runs = (*the_runs, ", without those marked as left out,") if left_out else the_runs
    words = (
        f" at once, by {MODEL_NAMES[analysis.model.name]}: least squares with errors in every reading (Gauss-Helmert "
        "model; its simplest case is a straight line with errors in both coordinates, York and others 2004). An error "
        "that runs share, such as that of the ruler or of the hand, is one unknown for all of them. Unknown "
        "sizes of errors are marginalised: the factor by which the runs scatter more or less than stated "
        "(Thompson and Ellison 2011), and the imbalance of the ball. I_zz is the median of the posterior "
        "distribution, u is half of its 68.3 % interval, and the 95 % interval goes from its 2.5 % to its 97.5 % "
        "quantile. The terms are those of the GUM."
    )
    version, does = Number(__version__, "/tool.version"), ": moment of inertia of an air gyroscope from its precession"
    fitted: Sentence = ("I_zz, the residual torque M0 and the timing bias b were fitted to all readings of ", *the_runs)
    cite: Sentence = (Styled("To cite: ", "strong"), "gyrodata, version ", version, does, ", method as above; log ",
                      Number(analysis.name, "/input.name"), ", its SHA-256 as below.")  # fmt: skip
    pages = (Styled("gyro explain statistics", "code"), " and ", Styled("gyro explain theory", "code"))
    yield Text(((*fitted, words), cite, ("More: ", *pages, "; and in:")), full=True)
    yield Text(tuple((line,) for line in REFERENCES), "list", full=True)


def _provenance(analysis: Analysis) -> Block:
    units = {
        "acceleration": ("m/s²", 1.0),
        "angle": ("deg", math.radians(1)),
        "length": ("m", 1.0),
        "mass": ("kg", 1.0),
    }
    constants = {"g": analysis.measurements.g, **analysis.readings.constants}
    facts = [
        Fact("tool", ("gyrodata ", Number(__version__, "/tool.version"))),
        Fact("log", (analysis.name,)),
        Fact("SHA-256 of the log", (Styled(analysis.sha256, "code"),)),
        *(
            Fact(f"option {key.replace('_', ' ')}", (_option(value),))
            for key, value in asdict(analysis.options).items()
        ),
        *(
            Fact(f"constant {key}", (Number(f"{value / size:.6g}", f"constants.{key}", size), f" {unit}"))
            for key, value in constants.items()
            for unit, size in (units[kind_of_role(key)],)
        ),
        *(Fact(f"# {key}", (Styled(value, "quote"),)) for key, value in analysis.readings.metadata.items()),
    ]
    return Facts(tuple(facts), full=True)


def _conventions() -> Block:
    return Facts(tuple(Fact(key.replace("_", " "), (says,)) for key, says in CONVENTIONS.items()), full=True)


def _option(value: object) -> str:
    if isinstance(value, Mapping):
        return ", ".join(f"{key} = {item}" for key, item in value.items()) or "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return "none" if value is None else str(value)
