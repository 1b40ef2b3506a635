"""The content of the report of one analysis, for every format."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from msgspec.structs import asdict

from gyrodata.judging import changes
from gyrodata.judging.blocks import DISAGREE
from gyrodata.judging.tables import UNLIKELY, scatter_in_u, turn_words
from gyrodata.measurements import SOURCES
from gyrodata.readings import kind_of_role, listing
from gyrodata.reporting import elements, questions
from gyrodata.reporting.elements import (
    Head,
    Numbers,
    Section,
    Sentence,
    Styled,
    Text,
    join_sentences,
    message_words,
    paragraph,
    say,
    table,
)
from gyrodata.reporting.figures import PICTURES
from gyrodata.reporting.values import (
    FREE_FALL,
    IN_U,
    KILOGRAM,
    METRE,
    NUMBER,
    PERCENT,
    SECOND,
    Scale,
)
from gyrodata.reporting.words import WORDS, source_words
from gyrodata.results import CONVENTIONS, NO_BALL, Analysis, is_wide

NOTICEABLE = 1.15
"""A factor on the errors of the runs that is worth a sentence [1]."""

FAR = 2
"""A run that is further from the others than this many u is worth repeating."""

FEW = 3
"""The terminal names at most this many runs."""

UNSEEN_BALANCE = 0.3
"""If the balance has a larger share of u² than this, the runs do not determine it [1].
"""

FIT_NAMES = WORDS["fits"]
SENTENCES = WORDS["sentences"]

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


def report(analysis: Analysis) -> elements.Report:
    """Put an analysis into sections, in the order in which they are read."""
    n = Numbers(analysis)
    runs = n.count("/input.rows", "run")
    size = say("{}, {}", runs, n.count("torques.length", "torque"))
    kind = "worksheet" if n.is_worksheet else "report"
    name = Styled(analysis.name, "typed")
    known = {key.lower(): text for key, text in analysis.readings.metadata.items()}
    lines = [
        say("{}: {}", key.capitalize(), Styled(known[key], "typed"))
        for key in BYLINE
        if key in known
    ]
    return elements.Report(
        numbers=n,
        size=size,
        title=say("Gyroscope lab {}: {}, {}", kind, name, size),
        byline=join_sentences(lines, " · "),
        read_as=_read_as(n),
        doubts=tuple(_doubts(n)),
        answer=n.answer(),
        top=tuple(_top(n)),
        sections=tuple(_sections(n)),
    )


def _sections(n: Numbers) -> Iterator[Section]:
    analysis = n.analysis
    yield from questions.question_3(n, _agreement(n))
    yield Section("Runs", tuple(_runs(n)), "runs")
    if analysis.blocks:
        yield Section("Days and groups", tuple(_days(n)), "days")
    yield Section("Uncertainty budget", tuple(_budget(n)), "uncertainty")
    if not n.is_worksheet:
        advice = Text([*map(message_words, analysis.advice)], "numbered")
        if not analysis.advice:
            advice = paragraph("No single change would help much.")
        yield Section("How to improve the next lab", (advice,), "advice")
    details = (
        ("Sensitivity to assumptions", _sensitivity(n), "sensitivity"),
        ("Three fits side by side", _fits(n), "fits"),
        ("Effects considered", _effects(n), "effects"),
        ("The other questions", questions.other_questions(n), "others"),
        ("Diagnostics", _diagnostics(n), "diagnostics"),
        ("Method and how to cite it", _method(n), "method"),
        ("Provenance", _provenance(n), "provenance"),
        ("Conventions", _pairs(CONVENTIONS), "conventions"),
    )
    for title, blocks, anchor in details:
        yield Section(title, tuple(blocks), anchor, folded=True)


# --- the first screen ---


def _read_as(n: Numbers) -> Sentence:
    """Describe the first run with a load: what was read, and what follows from it."""
    i, run = next((i, run) for i, run in enumerate(n.analysis.run_table) if run.torque)
    here = n.at(f"runs.{i}")
    torque = here.value("torque")
    load = say("a torque of {}", torque)
    follows: Sentence = ()
    if run.mass is not None:
        follows = say(": {}", torque)
        if run.position is not None:
            load = say("{} from the centre", here.hung(i))
    timed: Sentence = ()
    if n.analysis.measurements.timed:
        digits, noun = turn_words(run.turns).split(" ")
        turns = here.number("turns", digits)
        time = n.reading(i, "time")
        timed = say(", {} {} in {}", turns, noun, time)
    spin = n.reading(i, "spin")
    period = here.value("period")
    words = "Read as: run {}: {}, {}{}{}, one turn in {}."
    return say(words, here.number("run"), load, spin, timed, follows, period)


def _doubts(n: Numbers) -> Iterator[Sentence]:
    """List the reasons why the answer is not reliable, with their lines in the log."""
    start = "Do not rely on this answer: "
    numbers = {finding.message: i for i, finding in enumerate(n.analysis.diagnostics)}
    for doubt in n.analysis.doubts:
        place = _place(n, numbers[doubt.words])
        words = message_words(doubt.words)
        sentence = say("{}{}{}.", Styled(start, "warn"), words, place)
        if doubt is n.analysis.doubts[0]:
            end = "" if doubt.remedy.endswith("?") else "."
            remedy = message_words(doubt.remedy)
            sentence = say("{} Find the cause: {}{}", sentence, remedy, end)
        yield sentence
        start = "Also: "


def _top(n: Numbers) -> Iterator[elements.Block]:
    """Show the warnings that are not reasons to doubt the answer, and its interval."""
    analysis = n.analysis
    doubts = {doubt.words for doubt in analysis.doubts}
    start = Styled("Warning", "warn")
    for i, finding in enumerate(analysis.diagnostics):
        if finding.severity != "note" and finding.message not in doubts:
            message = message_words(finding.message)
            words = "{}{}: {}"
            yield paragraph(words, start, _place(n, i), message, kind="warning")
    if analysis.if_balanced is not None:
        yield Text(_on_balance(n))
    inertia = analysis.inertia
    # If the interval is wide, it is the answer itself.
    if inertia.interval_95 is not None and not is_wide(inertia):
        interval = n.interval()
        k = n.number("inertia.k", f"{inertia.k or 0.0:.2f}")
        yield paragraph("95 % interval: {} (k = {})", interval, k)
    yield paragraph(SENTENCES["every_u"], kind="small")
    if n.is_worksheet:
        yield paragraph(SENTENCES["answer_here"])


def brief(n: Numbers) -> Iterator[Sentence]:
    """Write the sentences below the answer in the terminal."""
    analysis = n.analysis
    yield say("{}{}", _agreement(n), _largest_part(n))
    if analysis.if_balanced is not None:
        yield from _on_balance(n)
    inertia = n.value("inertia.value")
    if is_wide(analysis.inertia):
        yield say(SENTENCES["median"], inertia=inertia)
    elif analysis.inertia.interval_95 is not None:
        interval = n.interval()
        m0 = n.value("residual_torque.value")
        of_m0 = "included in the fit"
        if analysis.blocks:
            of_m0 = "mean of the days"
        words = "95 % interval: {}; torque without a weight M0 = {} ({})"
        yield say(words, interval, m0, of_m0)
    if analysis.blocks:
        names = listing([block.name for block in analysis.blocks])
        yield say("{}: each has its own M0. {}", names, _days_agree(n))
    if analysis.ball is None:
        yield (NO_BALL,)
    else:
        yield questions.compare_with_ball(n)
    yield from _to_repeat(n)
    if analysis.advice and not analysis.doubts:
        yield say("To improve (optional): {}", analysis.advice[0])


def _to_repeat(n: Numbers) -> Iterator[Sentence]:
    """Name the suspected outliers, and the runs that are worth repeating."""
    runs = n.analysis.run_table
    odd = [i for i, run in enumerate(runs) if run.flagged]
    for i in odd[:FEW]:
        place = _run_place(n, i)
        fate = _fate(n.analysis, i)
        words = "Suspected outlier: {}, {}: {}. Check it, or repeat the run."
        yield say(words, place, fate, runs[i].reason)
    if len(odd) > FEW:
        more = str(len(odd) - FEW)
        yield say("{} more suspected outliers are marked in the table of runs.", more)
    far = _worth_repeating(n)
    if far:
        yield far
    if not odd and not far:
        end = "." if n.analysis.doubts else "; you need not repeat any run."
        yield say(f"No suspected outliers{end}")


def _worth_repeating(n: Numbers) -> Sentence:
    """Name the ordinary runs that are far from the prediction of the others, if any."""
    far = [
        i
        for i, run in enumerate(n.analysis.run_table)
        if abs(run.studentized_residual or 0.0) > FAR and not run.flagged
    ]
    if not far:
        return ()
    places = [_run_place(n, i) for i in far[:FEW]]
    return say(
        SENTENCES["worth_repeating"],
        runs=join_sentences(places, ", "),
        distance=str(FAR),
    )


def _run_place(n: Numbers, i: int) -> Sentence:
    here = n.at(f"runs.{i}")
    return say("run {} (line {})", here.number("run"), here.number("line"))


def _fate(analysis: Analysis, i: int) -> str:
    if analysis.run_table[i].left_out:
        return "left out"
    return "kept, as asked" if analysis.options.keep_flagged else "kept"


def _agreement(n: Numbers) -> Sentence:
    """Say whether the runs agree, without a full stop."""
    analysis = n.analysis
    count = n.count("/input.rows", "run")
    runs = say("The {}", count)
    if any(run.left_out for run in analysis.run_table):
        runs = say("Of the {}, those that were kept", count)
    if analysis.p is None:
        return say(SENTENCES["no_freedom"])
    if analysis.runs_disagree:
        # A different M0 of each weight can explain all scatter.
        is_scatter = analysis.p < UNLIKELY
        reason = (
            "within the stated uncertainties" if is_scatter else "for the reason above"
        )
        return say("{} do not agree with one straight line {}", runs, reason)
    if analysis.p >= UNLIKELY:
        is_better = analysis.p > 1 - UNLIKELY / 2
        better = ", better than stated" if is_better else ""
        return say("{} agree with one straight line{}", runs, better)
    if analysis.fit.widths.scatter < NOTICEABLE:
        return say("{} agree badly with one straight line", runs)
    stated: elements.Part = "the log"
    if analysis.measurements.time_u is not None:
        stated = n.value("goodness.time_u", SECOND)
    scatter = n.scatter("goodness.scatter")
    in_u = scatter_in_u(analysis.constancy, analysis.measurements)
    words = "{} scatter {} times as much as the timing uncertainty of {}; {}"
    return say(words, runs, scatter, stated, in_u)


def _largest_part(n: Numbers) -> Sentence:
    """Name the largest uncertainty component, and an undetermined balance."""
    sentence: Sentence = (".",)
    for i, share in enumerate(n.analysis.budget):
        percent = f"{100 * share.share:.0f}"
        part = n.number(f"budget.{i}.share", percent, PERCENT)
        is_balance = share.source == "residual_torque"
        if is_balance and (i == 0 or share.share > UNSEEN_BALANCE):
            largest = "the largest: " if i == 0 else ""
            sentence = say(
                SENTENCES["unseen_balance"],
                before=sentence,
                largest=largest,
                share=part,
            )
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
        both = shares["time"] + shares["unexplained_scatter"]
        return say(SENTENCES["hand_and_scatter"], percent=f"{100 * both:.0f}")
    # In a sentence, a clause needs its pronoun.
    name = source_words(source).replace(", differs", ", which differs")
    the = "" if name == "g" or name.startswith("each") else "the "
    return say(". Largest uncertainty: {}{} ({} of the variance).", the, name, part)


def _on_balance(n: Numbers) -> tuple[Sentence, ...]:
    """Name the assumption that I_zz depends on if all torques are equal."""
    measured = n.analysis.measurements
    tested = measured.balance_test is not None
    if tested or measured.balanced or measured.torque_unseen is not None:
        by = "the balance test" if tested else "the ball being balanced"
        return (say("All torques are equal, so the answer depends on {}.", by),)
    balanced = Styled("# balanced: yes", "code")
    return (say(SENTENCES["usual_imbalance"], balanced=balanced),)


# --- runs, uncertainty, advice ---


def _runs(n: Numbers) -> Iterator[elements.Block]:
    analysis = n.analysis
    odd = [i for i, run in enumerate(analysis.run_table) if run.flagged]
    yield PICTURES["residuals"]
    yield paragraph(SENTENCES["outliers_marked" if odd else "no_outliers"])
    if far := _worth_repeating(n):
        yield Text((far,))
    heads = (
        "run",
        "line",
        "load",
        "spin",
        "time",
        "turns",
        "period τ",
        "φ̇ψ̇",
        "residual",
        Head("remark", wrap=0.2),
    )
    rows: list[tuple[elements.Cell, ...]] = [()] * len(analysis.run_table)
    for group, members in enumerate(analysis.measurements.by_torque):
        for i in members:
            rows[i] = _row_of_run(n, i, n.load(group))
    yield table(heads, rows, SENTENCES["residual"], odd=odd)


def _row_of_run(n: Numbers, i: int, load: Sentence) -> tuple[elements.Cell, ...]:
    """Show a run; the remark explains why it is an outlier, and quotes its note."""
    run = n.analysis.run_table[i]
    note = n.analysis.readings.notes[i]
    remarks: list[Sentence] = []
    if run.flagged:
        fate = Styled(_fate(n.analysis, i), "strong")
        remarks.append(say("{}: {}", fate, message_words(run.reason)))
    if note:
        remarks.append(say("note: {}", Styled(note, "quote")))
    here = n.at(f"runs.{i}")
    turns, _ = turn_words(run.turns).split(" ")
    return (
        (here.number("run"),),
        here.number("line"),
        load,
        n.reading(i, "spin"),
        n.reading(i, "time"),
        here.number("turns", turns),
        here.value("period"),
        here.value("product"),
        here.cell("studentized_residual", here.shift),
        join_sentences(remarks, "; ") or None,
    )


def _budget(n: Numbers) -> Iterator[elements.Block]:
    rows = []
    for here in n.each("budget"):
        share = here.find("share")
        percent = f"{100 * share:.1f}"
        if share < 5e-4:
            percent = "< 0.1"
        part = here.number("share", percent, PERCENT)
        u = here.scatter("u_inertia", n.inertia)
        runs = here.find("shared_by")
        if not here.find("shared"):
            runs = "each run its own"
        name = source_words(here.find("source"))
        rows.append((name, part, u, runs))
    heads = (
        Head("component", wrap=0.28),
        Head("share of the variance", bars=True),
        "u of I_zz",
        Head("shared by", wrap=0.25),
    )
    if rows:
        yield table(heads, rows, SENTENCES["budget"])
    else:
        yield paragraph("The log states no uncertainty.")
    if assumed := defaults_used(n.analysis):
        yield paragraph(SENTENCES["defaults"])
        lines = [(Styled(line, "code"),) for line in assumed]
        yield Text(lines, "list")
    if n.is_worksheet:
        yield questions.conclude(n, "budget")


def defaults_used(analysis: Analysis) -> list[str]:
    """List the uncertainties that the log does not state: "u_spin_scale 0.1 %"."""
    sources = analysis.measurements.sources
    assumed = [source for source in sources if source.default and source.usual != "0"]
    used = [f"u_{source.name} {source.usual}" for source in assumed]
    states_bias = "u_time_bias" in analysis.readings.uncertainties
    if analysis.measurements.timed and not states_bias:
        used.append(f"u_time_bias {SOURCES['time_bias'].usual}")
    return used


def _days(n: Numbers) -> Iterator[elements.Block]:
    """Compare the days or groups: each alone, and its M0 in the fit of all."""
    rows: list[tuple[elements.Cell, ...]] = []
    for here in n.each("blocks"):
        alone = here.cell("inertia.value")
        m0 = here.value("residual_torque.value")
        inertia = alone or "not determined"
        name = (Styled(here.find("name"), "typed"),)
        rows.append((name, here.number("runs"), inertia, m0))
    heads = "day or group", "runs", Head("I_zz", compared=n.analysis.inertia), "M0"
    caption = "I_zz from each day or group alone, and its M0 in the fit of all runs"
    yield PICTURES["days"]
    yield Text((_days_agree(n),))
    yield table(heads, rows, caption)


def _days_agree(n: Numbers) -> Sentence:
    """Say whether the days or groups have one I_zz."""
    agreement = n.analysis.blocks_agreement
    if agreement is None:
        return say("The days or groups cannot be compared.")
    p = n.p("blocks_agreement.p")
    agree = "agree" if agreement.p > DISAGREE else "disagree"
    return say("The days or groups {} ({} if I_zz is the same).", agree, p)


# --- details ---


def _sensitivity(n: Numbers) -> Iterator[elements.Block]:
    fitted = n.value("inertia.value")
    rows: list[tuple[elements.Cell, ...]] = [("no change", fitted, None)]
    for here in n.each("sensitivity"):
        inertia = here.cell("inertia.value")
        shift = here.cell("deviation", here.shift)
        change = message_words(here.find("words"))
        rows.append((change, inertia or "no answer", shift))
    heads = "if", Head("I_zz", compared=n.analysis.inertia), "shift"
    caption = "I_zz after one change; the shift is in units of u"
    if len(rows) > 1:
        yield table(heads, rows, caption, main=0)


def _fits(n: Numbers) -> Iterator[elements.Block]:
    rows: list[tuple[elements.Cell, ...]] = []
    notes = []
    for here in n.each("fits"):
        name = FIT_NAMES[here.find("name")]
        value = here.cell("inertia.value")
        intercept = here.cell("constant.value")
        if value and not intercept:
            intercept = "assumed 0"
        away: elements.Cell = None
        if here.find("deviation") is not None:
            difference = here.percent("difference")
            away = say("{} ({})", here.shift("deviation"), difference)
        rows.append((name, value or "not possible", intercept, away))
        notes.append(say("{}: {}", Styled(name, "strong"), here.find("note")))
    heads = (
        "fit",
        Head("I_zz", compared=n.analysis.inertia),
        "intercept −M0",
        Head("from recommended", NUMBER),
    )
    caption = "The recommended fit, and the lines of the textbook"
    yield table(heads, rows, caption, main=0)
    yield Text(notes, "list")


def _effects(n: Numbers) -> Iterator[elements.Block]:
    rows: list[tuple[elements.Cell, ...]] = []
    for effect, here in zip(n.analysis.effects, n.each("effects"), strict=True):
        change = here.cell("bias", here.percent)
        size = effect.size or 0.0
        digits = f"{size:.2f}" if size < 10 else f"{size:.0f}"
        if 0 < size < 0.005:
            digits = "< 0.01"
        in_u = here.cell("size", here.number, digits, IN_U)
        verdict = "left out"
        if effect.kept:
            verdict = "in the model"
        elif effect.in_u:
            verdict = "in u"
        elif size > changes.DROP_ONE:
            verdict = "left out, and not small"
        name = changes.effect_words(effect.effect)
        rows.append((name, change, in_u, verdict, effect.reason))
    heads = (
        Head("effect", wrap=0.2),
        "change of I_zz",
        "size",
        Head("verdict", wrap=0.12),
        Head("why", wrap=0.3, page_only=True),
    )
    choice = "the simplest model that is sufficient here"
    if n.analysis.lab.asked:
        choice = "as asked"
    caption = "Change of I_zz if the effect is ignored, in % and in units of u"
    yield paragraph("Model: {}, {}.", n.analysis.model.words, choice)
    yield table(heads, rows, caption)


def _diagnostics(n: Numbers) -> Iterator[elements.Block]:
    """List every message about the log, with its remedy."""
    lines = []
    for i, finding in enumerate(n.analysis.diagnostics):
        style = "strong" if finding.severity == "note" else "warn"
        code = Styled(f"{finding.severity} {finding.code}", style)
        text = finding.message
        if finding.hint:
            text += f"; {finding.hint}"
        lines.append(say("{}{}: {}", code, _place(n, i), message_words(text)))
    if lines:
        yield Text(lines, "list")
    else:
        yield paragraph("None.")


def _place(n: Numbers, i: int) -> Sentence:
    """Write the place of a diagnostic in the log: " (line 5, column 3)"."""
    here = n.at(f"/diagnostics.{i}")
    if not here.find("line"):
        return ()
    column: Sentence = ()
    if here.find("column"):
        column = say(", column {}", here.number("column"))
    return say(" (line {}{})", here.number("line"), column)


def _method(n: Numbers) -> Iterator[elements.Block]:
    left_out = ""
    if any(run.left_out for run in n.analysis.run_table):
        left_out = ", without those marked as left out,"
    fitted = say(
        SENTENCES["method"],
        runs=n.count("/input.rows", "run"),
        left_out=left_out,
        model=n.analysis.model.words,
    )
    cite = say(
        SENTENCES["cite"],
        start=Styled("To cite: ", "strong"),
        version=n.number("/tool.version"),
        log=n.number("/input.name"),
    )
    statistics = Styled("gyro explain statistics", "code")
    theory = Styled("gyro explain theory", "code")
    more = say("More: {} and {}; and in:", statistics, theory)
    yield Text((fitted, cite, more))
    references = WORDS["references"]["list"]
    yield Text([(line,) for line in references], "list")


UNITS_OF_CONSTANTS = {
    "acceleration": FREE_FALL,
    "angle": Scale("deg", r"\degree", math.radians(1)),
    "length": METRE,
    "mass": KILOGRAM,
}


def _provenance(n: Numbers) -> Iterator[elements.Block]:
    """List the version, the log, the options and the constants."""
    analysis = n.analysis
    facts: dict[str, elements.Part] = {
        "gyrodata": n.number("/tool.version"),
        "log": Styled(analysis.name, "typed"),
        "SHA-256 of the log": Styled(analysis.sha256, "code"),
    }
    for key, option in asdict(analysis.options).items():
        if isinstance(option, Mapping):
            pairs = [f"{name} = {text}" for name, text in option.items()]
            option = ", ".join(pairs)
        if option:
            text = "yes" if option is True else str(option)
            facts[f"option {key}"] = Styled(text, "typed")
    for key, value in n.find("constants").items():
        scale = UNITS_OF_CONSTANTS[kind_of_role(key)]
        text = f"{value / scale.size:.6g}"
        facts[f"constant {key}"] = n.number(f"constants.{key}", text, scale)
    for key, text in analysis.readings.metadata.items():
        facts[f"# {key}"] = Styled(text, "quote")
    return _pairs(facts)


def _pairs(facts: Mapping[str, elements.Part]) -> Iterator[elements.Block]:
    lines = []
    for key, fact in facts.items():
        name = Styled(key.replace("_", " "), "typed")
        lines.append(say("{}: {}", name, fact))
    yield Text(lines, "list")
