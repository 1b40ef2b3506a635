"""The content of the report of one analysis, for every format."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

from msgspec.structs import asdict

from gyrodata.fitting import Estimate
from gyrodata.judging import changes
from gyrodata.judging.blocks import DISAGREE
from gyrodata.judging.tables import UNLIKELY, Run, scatter_in_u, turn_words
from gyrodata.measurements import SOURCES
from gyrodata.physics import models
from gyrodata.readings import kind_of_role, listing
from gyrodata.reporting import elements, questions, values
from gyrodata.reporting.elements import (
    Head,
    Numbers,
    Picture,
    Section,
    Sentence,
    Styled,
    Text,
    paragraph,
    say,
    table,
)
from gyrodata.reporting.figures import ALL_FIGURES, FIGURES
from gyrodata.results import CONVENTIONS, NO_BALL, Analysis, is_wide

NOTICEABLE = 1.15
"""A factor on the errors of the runs that is worth a sentence [1]."""

FAR = 2.0
"""A run that is further from the others than this many u is worth repeating."""

FEW = 3
"""The terminal names at most this many runs."""

UNSEEN_BALANCE = 0.3
"""If the balance has a larger share of u² than this, the runs do not determine it [1].
"""

FIT_NAMES = questions.WORDS["fits"]
SOURCE_NAMES = {key: source.words for key, source in SOURCES.items()} | questions.WORDS[
    "sources"
]


def source_words(name: str) -> str:
    """Return a source of uncertainty for users, by its name in the JSON."""
    return SOURCE_NAMES.get(name) or models.source_words().get(name, name)


BYLINE = (
    "author",
    "authors",
    "name",
    "names",
    "student",
    "partner",
    "partners",
    "course",
    "group",
    "station",
    "date",
)
"""Keys of the lines of a log that the report shows below its title."""


def _wide_answer(n: Numbers) -> Sentence:
    """Write the 95 % interval; with one torque, first the answer of a balanced ball."""
    analysis = n.analysis
    interval = n.interval("inertia.interval_95", n.inertia)
    if analysis.if_balanced is None or analysis.measurements.balanced is False:
        return say("I_zz = {} (95 % interval)", interval)
    return say(
        "I_zz = {} (± u) if the ball was balanced as the sheet asks; if not, {} (95 % "
        "interval)",
        n.value("if_balanced.value", n.inertia),
        interval,
    )


def report(analysis: Analysis) -> elements.Report:
    """Put an analysis into sections, in the order in which they are read."""
    n = Numbers(analysis)
    size = say(
        "{}, {}", n.count("/input.rows", "run"), n.count("torques.length", "torque")
    )
    answer = say("I_zz = {}", n.value("inertia.value", n.inertia))
    if is_wide(analysis.inertia):
        answer = _wide_answer(n)
    is_worksheet = questions.is_worksheet(analysis)
    sections = (
        *questions.answer(n, answer, _agreement(n), _fit_quality(n)),
        Section("Runs", tuple(_runs(n)), "runs"),
        *([Section("Days and groups", _days(n), "days")] if analysis.blocks else []),
        Section("Uncertainty budget", tuple(_budget(n)), "uncertainty"),
        *(
            []
            if is_worksheet
            else [Section("How to improve the next lab", _advice(analysis), "advice")]
        ),
        Section("Sensitivity to assumptions", _sensitivity(n), "sensitivity", True),
        Section("Three fits side by side", tuple(_fits(n)), "fits", True),
        Section("Effects considered", _effects(n), "effects", True),
        questions.others(n),
        Section("Diagnostics", _diagnostics(n), "diagnostics", True),
        Section("Method and how to cite it", tuple(_method(n)), "method", True),
        Section("Provenance", _provenance(n), "provenance", True),
        Section("Conventions", (_pairs(CONVENTIONS),), "conventions", True),
    )
    known = {
        key.lower(): (key, text) for key, text in analysis.readings.metadata.items()
    }
    lines = [
        f"{key.capitalize()}: {text}"
        for key, text in (known[name] for name in BYLINE if name in known)
    ]
    return elements.Report(
        name=analysis.name,
        size=size,
        title=say(
            "Gyroscope lab {}: {}, {}",
            "worksheet" if is_worksheet else "report",
            analysis.name,
            size,
        ),
        byline=say("{}", " · ".join(lines)),
        read_as=_read_as(n),
        doubts=tuple(_doubts(n)),
        warnings=_warnings(n),
        answer=answer,
        top=tuple(_top(n)),
        brief=tuple(_brief(n)),
        sections=sections,
    )


# --- the first screen ---


def _read_as(n: Numbers) -> Sentence:
    """Describe the first run with a load: what was read, and what follows from it."""
    i, run = next((i, run) for i, run in enumerate(n.analysis.run_table) if run.torque)
    at = f"runs.{i}"
    torque = n.value(f"{at}.torque", n.torque)
    loaded = run.mass is not None and run.position is not None
    on_the_rod = (
        say("{} from the centre", n.hung(i, at))
        if loaded
        else say("a torque of {}", torque)
    )
    timed: Sentence = ()
    if n.analysis.measurements.timed:
        turns, noun = turn_words(run.turns).split(" ")
        timed = say(
            ", {} {} in {}",
            n.number(f"{at}.turns", turns),
            noun,
            n.reading(i, "time", values.SECOND),
        )
    return say(
        "Read as: run {}: {}, {}{}{}, one turn in {}.",
        n.number(f"{at}.run"),
        on_the_rod,
        n.reading(i, "spin", values.RPM),
        timed,
        say(": {}", torque) if run.mass is not None else (),
        n.value(f"{at}.period", values.SECOND),
    )


def _doubts(n: Numbers) -> Iterator[Sentence]:
    """List the reasons why the answer is not reliable, with their lines in the log."""
    diagnostics = n.analysis.diagnostics
    number_of = {finding.message: i for i, finding in enumerate(diagnostics)}
    for i, doubt in enumerate(n.analysis.doubts):
        start = Styled("Also: " if i else "Do not rely on this answer: ", "warn")
        place = _place(n, number_of[doubt.words])
        remedy = ""
        if i == 0:
            end = "" if doubt.remedy.endswith("?") else "."
            remedy = f" Find the cause: {doubt.remedy}{end}"
        yield say("{}{}{}.{}", start, doubt.words, place, remedy)


def _warnings(n: Numbers) -> tuple[Sentence, ...]:
    """List the warnings that are not reasons to doubt the answer, without remedies."""
    doubts = {doubt.words for doubt in n.analysis.doubts}
    return tuple(
        [
            say("{}{}: {}", Styled("Warning", "warn"), _place(n, i), finding.message)
            for i, finding in enumerate(n.analysis.diagnostics)
            if finding.severity != "note" and finding.message not in doubts
        ]
    )


def _top(n: Numbers) -> Iterator[elements.Block]:
    analysis = n.analysis
    if analysis.if_balanced is not None:
        yield Text(_on_balance(n))
    # If the interval is wide, it is the answer itself.
    if analysis.inertia.interval_95 is not None and not is_wide(analysis.inertia):
        k = n.number("inertia.k", f"{analysis.inertia.k or 0.0:.2f}")
        yield paragraph(
            "95 % interval: {} (k = {})",
            n.interval("inertia.interval_95", n.inertia),
            k,
        )
    yield paragraph(
        "Every ± is one standard uncertainty u, which includes the scatter of the runs.",
        kind="small",
    )


def _brief(n: Numbers) -> Iterator[Sentence]:
    """Write the sentences below the answer in the terminal."""
    analysis = n.analysis
    yield say("{}{}", _agreement(n), _largest_part(n))
    if analysis.if_balanced is not None:
        yield from _on_balance(n)
    if is_wide(analysis.inertia):
        words = (
            "Median and half of the 68 % interval: {}; the 95 % interval is much wider "
            "than ± 2 u."
        )
        yield say(words, n.value("inertia.value", n.inertia))
    elif analysis.inertia.interval_95 is not None:
        yield say(
            "95 % interval: {}; torque without a weight M0 = {} ({})",
            n.interval("inertia.interval_95", n.inertia),
            n.value("residual_torque.value", n.torque),
            "mean of the days" if analysis.blocks else "included in the fit",
        )
    if analysis.blocks:
        names = listing([block.name for block in analysis.blocks])
        yield say("{}: each has its own M0. {}", names, _days_agree(n))
    yield (NO_BALL,) if analysis.ball is None else questions.compare_with_ball(n)
    yield from _to_repeat(n)
    if analysis.advice and not analysis.doubts:
        yield say("To improve (optional): {}", analysis.advice[0])


def _to_repeat(n: Numbers) -> Iterator[Sentence]:
    """Name the suspected outliers, and the runs that are worth repeating."""
    runs = n.analysis.run_table
    odd = [i for i, run in enumerate(runs) if run.flagged]
    far = [i for i, run in enumerate(runs) if _is_far(run)]
    yield from _outliers(n, odd)
    if far:
        yield _worth_repeating(n, far)
    if not odd and not far:
        end = "." if n.analysis.doubts else "; you need not repeat any run."
        yield say(f"No suspected outliers{end}")


def _is_far(run: Run) -> bool:
    """Return whether an ordinary run is far from the prediction of the others."""
    return not run.flagged and abs(run.studentized_residual or 0.0) > FAR


def _outliers(n: Numbers, odd: Sequence[int]) -> Iterator[Sentence]:
    words = "Suspected outlier: {}, {}: {}. Check it, or repeat the run."
    for i in odd[:FEW]:
        reason = n.analysis.run_table[i].reason
        yield say(words, _run_place(n, i), _fate(n.analysis, i), reason)
    rest = len(odd) - FEW
    if rest > 0:
        yield say(f"{rest} more suspected outliers are marked in the table of runs.")


def _worth_repeating(n: Numbers, far: Sequence[int]) -> Sentence:
    names = [_run_place(n, i) for i in far[:FEW]]
    first, *others = names
    named = say("{}" + ", {}" * len(others), first, *others)
    them = "it is" if len(far) == 1 else "they are"
    words = "If you have time, repeat {}: {} over {} u away from the other runs' prediction."
    return say(words, named, them, f"{FAR:g}")


def _run_place(n: Numbers, i: int) -> Sentence:
    return say(
        "run {} (line {})", n.number(f"runs.{i}.run"), n.number(f"runs.{i}.line")
    )


def _fate(analysis: Analysis, i: int) -> str:
    if analysis.run_table[i].left_out:
        return "left out"
    return "kept, as asked" if analysis.options.keep_flagged else "kept"


def _agreement(n: Numbers) -> Sentence:
    """Say whether the runs agree, without a full stop."""
    analysis = n.analysis
    scatter = n.analysis.fit.widths.scatter
    runs = n.count("/input.rows", "run")
    left_out = any(run.left_out for run in analysis.run_table)
    runs = (
        say("Of the {}, those that were kept", runs)
        if left_out
        else say("The {}", runs)
    )
    if analysis.p is None:
        return say("There are as many unknowns as runs, so nothing shows if they agree")
    if analysis.runs_disagree:
        return say(
            "{} do not agree with one straight line within the stated uncertainties",
            runs,
        )
    if analysis.p >= UNLIKELY:
        better = ", better than stated" if analysis.p > 1 - UNLIKELY / 2 else ""
        return say("{} agree with one straight line{}", runs, better)
    if scatter < NOTICEABLE:
        return say("{} agree badly with one straight line", runs)
    timed = analysis.measurements.time_u is not None
    stated: elements.Part = (
        n.value("goodness.time_u", values.SECOND) if timed else "the log"
    )
    words = "{} scatter {} times as much as the timing uncertainty of {}; {}"
    return say(
        words,
        runs,
        n.scatter("goodness.scatter"),
        stated,
        scatter_in_u(analysis.constancy, analysis.measurements),
    )


def _largest_part(n: Numbers) -> Sentence:
    """Name the largest uncertainty component, and an undetermined balance."""
    sentence: Sentence = (".",)
    for i, share in enumerate(n.analysis.budget):
        part = n.number(f"budget.{i}.share", f"{100 * share.share:.0f}", values.PERCENT)
        is_balance = share.source == "residual_torque"
        if is_balance and (i == 0 or share.share > UNSEEN_BALANCE):
            largest = "the largest: " if i == 0 else ""
            words = (
                "{} These runs cannot show how well the ball is balanced. This "
                "uncertainty is {}{} of the variance."
            )
            sentence = say(words, sentence, largest, part)
        elif i == 0:
            sentence = _largest(n, part)
    return sentence


def _largest(n: Numbers, part: elements.Number) -> Sentence:
    """Name the largest component; `part` is its share of the variance."""
    source = n.analysis.budget[0].source
    shares = {share.source: share.share for share in n.analysis.budget}
    of_hand = {"time", "unexplained_scatter"}
    if source in of_hand and of_hand <= shares.keys():
        # The scatter above the stated uncertainties is most likely that of the hand.
        both = 100 * (shares["time"] + shares["unexplained_scatter"])
        return say(
            ". Largest uncertainty: the stopwatch readings with their unexplained "
            f"scatter ({both:.0f} % of the variance)."
        )
    # In a sentence, a clause needs its pronoun.
    name = source_words(source).replace(", differs", ", which differs")
    the = "" if name == "g" or name.startswith("each") else "the "
    return say(". Largest uncertainty: {}{} ({} of the variance).", the, name, part)


def _on_balance(n: Numbers) -> tuple[Sentence, ...]:
    """Name the assumption that I_zz depends on if all torques are equal."""
    measured = n.analysis.measurements
    by = (
        "the balance test"
        if measured.balance_test is not None
        else "the ball being balanced"
    )
    known = (measured.balance_test, measured.torque_unseen)
    if measured.balanced or any(each is not None for each in known):
        return (say(f"All torques are equal, so the answer depends on {by}."),)
    decide = (
        "All torques are equal, and a usual imbalance, 5 % of the torque, changes I_zz "
        "by 5 %. Time runs with one more weight; or write {}, add a balance test, or "
        "time a run without an added mass."
    )
    return (say(decide, Styled("# balanced: yes", "code")),)


def _fit_quality(n: Numbers) -> Sentence:
    chi2 = n.analysis.fit.chi2
    if n.analysis.p is None:
        return say(
            "Fit quality: not available, because there are no degrees of freedom"
        )
    return say(
        "Fit quality: {} (chi-square {} for {} of freedom; scatter {} times the stated one)",
        n.p("goodness.p"),
        n.number("goodness.chi2", f"{chi2:.3g}" if chi2 < 1000 else f"{chi2:.0f}"),
        n.count("goodness.dof", "degree"),
        n.scatter("goodness.scatter"),
    )


# --- runs, uncertainty, advice ---


def _runs(n: Numbers) -> Iterator[elements.Block]:
    analysis = n.analysis
    second = values.SECOND
    odd = [i for i, run in enumerate(analysis.run_table) if run.flagged]
    marked = "The remarks in the table explain the suspected outliers."
    yield paragraph(
        marked if odd else "No suspected outliers; all runs are in the fit."
    )
    yield Picture("residuals", FIGURES["residuals"].caption)
    group_of = {
        i: g for g, group in enumerate(analysis.measurements.by_torque) for i in group
    }
    rows: list[tuple[elements.Cell, ...]] = []
    for i, (run, note) in enumerate(
        zip(analysis.run_table, analysis.readings.notes, strict=True)
    ):
        at = f"runs.{i}"
        shift = None
        if run.studentized_residual is not None:
            shift = n.shift(f"{at}.studentized_residual")
        rows.append(
            (
                (n.number(f"{at}.run"),),
                n.number(f"{at}.line"),
                n.load(group_of[i]),
                n.reading(i, "spin", values.RPM),
                n.reading(i, "time", second),
                n.number(f"{at}.turns", turn_words(run.turns).split(" ")[0]),
                n.value(f"{at}.period", second),
                n.value(f"{at}.product", values.PRODUCT),
                shift,
                _remark(n, i, note) or None,
            )
        )
    number = values.NUMBER
    heads = (
        *(
            Head("run"),
            Head("line", number),
            Head("load"),
            Head("spin", values.RPM),
            Head("time", second),
        ),
        *(Head("turns", number), Head("period τ", second), Head("φ̇ψ̇", values.PRODUCT)),
        *(Head("residual", values.IN_U), Head("remark", wrap=0.2)),
    )
    caption = "The residual is the time minus the time that the other runs predict, in units of u"
    yield table(heads, rows, caption, odd=odd)


def _remark(n: Numbers, i: int, note: str) -> Sentence:
    """Explain why a run is an outlier, and quote its note."""
    run = n.analysis.run_table[i]
    parts: list[Sentence] = []
    if run.flagged:
        fate = Styled(_fate(n.analysis, i), "strong")
        parts.append(say("{}: {}", fate, run.reason))
    if note:
        parts.append(say("note: {}", Styled(note, "quote")))
    return say("; ".join(["{}"] * len(parts)), *parts)


def _budget(n: Numbers) -> Iterator[elements.Block]:
    budget = n.analysis.budget
    rows = [
        (
            say("{}", source_words(share.source)),
            n.number(
                f"budget.{i}.share",
                f"{100 * share.share:.1f}" if share.share >= 5e-4 else "< 0.1",
                values.PERCENT,
            ),
            n.scatter(f"budget.{i}.u_inertia", n.inertia),
            say("{}", share.shared_by if share.shared else "each run its own"),
        )
        for i, share in enumerate(budget)
    ]
    bars = tuple((share.share, 0.0) for share in budget)
    heads = (
        Head("component", wrap=0.28),
        Head("share of the variance", values.PERCENT, dots=bars),
        Head("u of I_zz", n.inertia),
        Head("shared by", wrap=0.25),
    )
    caption = (
        "Uncertainty components with their shares of the variance u² of I_zz, the "
        "largest first"
    )
    yield (
        table(heads, rows, caption)
        if rows
        else paragraph("The log states no uncertainty.")
    )
    if assumed := defaults_used(n.analysis):
        yield paragraph(
            "The log does not state these uncertainties, so default values are used:"
        )
        yield Text(tuple((Styled(line, "code"),) for line in assumed), "list")
    if questions.is_worksheet(n.analysis):
        yield questions.conclude(n, "budget")


def defaults_used(analysis: Analysis) -> list[str]:
    """List the uncertainties that the log does not state: "u_spin_scale 0.1 %"."""
    used = [
        f"u_{s.name} {s.usual}"
        for s in analysis.measurements.sources
        if s.default and s.usual != "0"
    ]
    if (
        analysis.measurements.timed
        and "u_time_bias" not in analysis.readings.uncertainties
    ):
        used.append(f"u_time_bias {SOURCES['time_bias'].usual}")
    return used


def _advice(analysis: Analysis) -> tuple[elements.Block, ...]:
    advice = tuple((item,) for item in analysis.advice)
    return (
        Text(advice, "numbered")
        if advice
        else paragraph("No single change would help much."),
    )


def _days(n: Numbers) -> tuple[elements.Block, ...]:
    """Compare the days or groups: each alone, and its M0 in the fit of all."""
    blocks = n.analysis.blocks
    rows: list[tuple[elements.Cell, ...]] = []
    for i, block in enumerate(blocks):
        at = f"blocks.{i}"
        alone: elements.Cell = say("not determined")
        if block.inertia:
            alone = n.value(f"{at}.inertia.value", n.inertia)
        m0 = n.value(f"{at}.residual_torque.value", n.torque)
        name = say("{}", block.name)
        rows.append((name, n.number(f"{at}.runs"), alone, m0))
    heads = (
        Head("day or group"),
        Head("runs", values.NUMBER),
        _drawn(n, [block.inertia for block in blocks]),
        Head("M0", n.torque),
    )
    caption = "I_zz from each day or group alone, and its M0 in the fit of all runs"
    return (
        Text((_days_agree(n),)),
        table(heads, rows, caption, main=0),
        Picture("days", ALL_FIGURES["days"].caption),
    )


def _days_agree(n: Numbers) -> Sentence:
    """Say whether the days or groups have one I_zz."""
    agreement = n.analysis.blocks_agreement
    if agreement is None:
        return say("The days or groups cannot be compared.")
    p = n.p("blocks_agreement.p")
    if agreement.p > DISAGREE:
        return say("The days or groups agree ({} if I_zz is the same).", p)
    return say("The days or groups disagree ({} if I_zz is the same).", p)


# --- details ---


def _drawn(n: Numbers, estimates: Iterable[Estimate | None]) -> Head:
    """Return the head of a column of estimates of I_zz.

    The estimates are drawn against the interval of the answer.
    """
    value = n.analysis.inertia.value
    u = n.analysis.inertia.u or 0.0
    dots = tuple(
        (estimate.value, estimate.u or 0.0) if estimate else None
        for estimate in estimates
    )
    return Head("I_zz", n.inertia, dots=dots, band=(value - u, value + u))


def _sensitivity(n: Numbers) -> tuple[elements.Block, ...]:
    cases = n.analysis.sensitivity
    rows: list[tuple[elements.Cell, ...]] = [
        (say("no change"), n.value("inertia.value", n.inertia), None)
    ]
    for i, case in enumerate(cases):
        value: elements.Cell = say("no answer")
        if case.inertia is not None:
            value = n.value(f"sensitivity.{i}.inertia.value", n.inertia)
        shift = (
            None if case.deviation is None else n.shift(f"sensitivity.{i}.deviation")
        )
        rows.append((say("{}", case.words), value, shift))
    drawn = _drawn(n, [n.analysis.inertia, *(case.inertia for case in cases)])
    heads = Head("if"), drawn, Head("shift", values.IN_U)
    caption = "I_zz after one change; the shift is in units of u"
    return (table(heads, rows, caption, main=0),) if cases else ()


def _fits(n: Numbers) -> Iterator[elements.Block]:
    fits = n.analysis.fits
    rows: list[tuple[elements.Cell, ...]] = []
    for i, fit in enumerate(fits):
        at = f"fits.{i}"
        away = None
        intercept = None
        if fit.deviation is not None and fit.difference is not None:
            away = say(
                "{} ({})", n.shift(f"{at}.deviation"), n.percent(f"{at}.difference")
            )
        if fit.inertia:
            intercept = (
                n.value(f"{at}.constant.value", n.torque)
                if fit.constant
                else say("assumed 0")
            )
        value = (
            n.value(f"{at}.inertia.value", n.inertia)
            if fit.inertia
            else say("not possible")
        )
        rows.append((say("{}", FIT_NAMES[fit.name]), value, intercept, away))
    heads = (
        Head("fit"),
        _drawn(n, [fit.inertia for fit in fits]),
        Head("intercept −M0", n.torque),
    )
    caption = "The recommended fit, and the lines of the textbook"
    yield table(
        (*heads, Head("from recommended", values.NUMBER)), rows, caption, main=0
    )
    yield Text(
        tuple(
            say("{}: {}", Styled(FIT_NAMES[fit.name], "strong"), fit.note)
            for fit in fits
        ),
        "list",
    )


def _effects(n: Numbers) -> tuple[elements.Block, ...]:
    model = n.analysis.model
    rows: list[tuple[elements.Cell, ...]] = []
    for i, effect in enumerate(n.analysis.effects):
        size = None
        if effect.size is not None:
            text = f"{effect.size:.2f}" if effect.size < 10 else f"{effect.size:.0f}"
            text = "< 0.01" if effect.size and text == "0.00" else text
            size = n.number(f"effects.{i}.size", text, values.IN_U)
        change = None if effect.bias is None else n.percent(f"effects.{i}.bias")
        name = changes.effect_words(effect.effect)
        rows.append(
            (
                say("{}", name),
                change,
                size,
                say(_verdict(effect)),
                say("{}", effect.reason),
            )
        )
    heads = (
        Head("effect", wrap=0.2),
        Head("change of I_zz", values.PERCENT),
        Head("size", values.IN_U),
        Head("verdict", wrap=0.12),
        Head("why", wrap=0.3, page_only=True),
    )
    choice = (
        ", as asked"
        if n.analysis.lab.asked
        else ", the simplest model that is sufficient here"
    )
    words = say(f"Model: {model.words}{choice}.")
    return (
        Text((words,)),
        table(
            heads,
            rows,
            "Change of I_zz if the effect is ignored, in % and in units of u",
        ),
    )


def _verdict(effect: changes.Effect) -> str:
    """Say what the fit does with an effect."""
    if effect.kept:
        return "in the model"
    if effect.in_u:
        return "in u"
    if (effect.size or 0.0) > changes.DROP_ONE:
        return "left out, and not small"
    return "left out"


def _diagnostics(n: Numbers) -> tuple[elements.Block, ...]:
    """List every message about the log, with its remedy."""
    lines = [_diagnostic(n, i) for i in range(len(n.analysis.diagnostics))]
    return (Text(tuple(lines), "list") if lines else paragraph("None."),)


def _diagnostic(n: Numbers, i: int) -> Sentence:
    diagnostic = n.analysis.diagnostics[i]
    code = Styled(
        f"{diagnostic.severity} {diagnostic.code}",
        "strong" if diagnostic.severity == "note" else "warn",
    )
    return say(
        "{}{}: {}{}",
        code,
        _place(n, i),
        diagnostic.message,
        f"; {diagnostic.hint}" if diagnostic.hint else "",
    )


def _place(n: Numbers, i: int) -> Sentence:
    """Write the place of a diagnostic in the log: " (line 5, column 3)"."""
    finding = n.analysis.diagnostics[i]
    at = f"/diagnostics.{i}"
    if not finding.line:
        return ()
    column = say(", column {}", n.number(f"{at}.column")) if finding.column else ()
    return say(" (line {}{})", n.number(f"{at}.line"), column)


def _method(n: Numbers) -> Iterator[elements.Block]:
    left_out = any(run.left_out for run in n.analysis.run_table)
    fitted = say(
        "I_zz, the residual torque M0 and the timing bias b were fitted to all "
        "readings of the {}{} at once, by "
        f"{n.analysis.model.words}: least squares with errors in "
        f"every reading (Gauss-Helmert "
        "model). An error that runs share, for example of the ruler, is one unknown "
        "for all of them. Unknown sizes of "
        "errors are marginalised: the factor by which the runs scatter more or less "
        "than stated, and the imbalance of "
        "the ball. I_zz is the median of the posterior distribution, u is half of its "
        "68.3 % interval, and the 95 % "
        "interval goes from its 2.5 % to its 97.5 % quantile.",
        n.count("/input.rows", "run"),
        ", without those marked as left out," if left_out else "",
    )
    cite = say(
        (
            "{}gyrodata, version {}: moment of inertia of an air gyroscope from its "
            "precession; log {} with its SHA-256."
        ),
        Styled("To cite: ", "strong"),
        n.number("/tool.version"),
        n.number("/input.name"),
    )
    pages = (
        Styled(f"gyro explain {page}", "code") for page in ("statistics", "theory")
    )
    yield Text((fitted, cite, say("More: {} and {}; and in:", *pages)))
    yield Text(tuple((line,) for line in questions.WORDS["references"]["list"]), "list")


def _provenance(n: Numbers) -> tuple[elements.Block, ...]:
    analysis = n.analysis
    units = {
        "acceleration": values.FREE_FALL,
        "angle": values.Scale("deg", r"\degree", math.radians(1)),
        "length": values.METRE,
        "mass": values.KILOGRAM,
    }
    facts: dict[str, elements.Part] = {
        "gyrodata": n.number("/tool.version"),
        "log": analysis.name,
    }
    facts["SHA-256 of the log"] = Styled(analysis.sha256, "code")
    for key, option in asdict(analysis.options).items():
        if option:
            pairs = (
                ", ".join(f"{name} = {text}" for name, text in option.items())
                if isinstance(option, Mapping)
                else ""
            )
            facts[f"option {key}"] = pairs or ("yes" if option is True else option)
    for key, value in n.find("constants").items():
        scale = units[kind_of_role(key)]
        facts[f"constant {key}"] = n.number(
            f"constants.{key}", f"{value / scale.size:.6g}", scale
        )
    facts |= {
        f"# {key}": Styled(value, "quote")
        for key, value in analysis.readings.metadata.items()
    }
    return (_pairs(facts),)


def _pairs(facts: Mapping[str, elements.Part]) -> Text:
    return Text(
        tuple(
            say("{}: {}", key.replace("_", " "), value) for key, value in facts.items()
        ),
        "list",
    )
