"""The questions of the lab sheet.

They are the plots and laws of question 3, one run by hand, and commands for the other
questions.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from msgspec.structs import replace

from gyrodata.judging.tables import UNLIKELY, turn_words
from gyrodata.reporting import elements, values
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
    CENTIMETRE,
    FREE_FALL,
    KILOGRAM,
    METRE,
    MICROMETRE,
    NEWTON_METRE,
    NUMBER,
    PRODUCT,
    RPM,
    Scale,
)
from gyrodata.reporting.words import WORDS
from gyrodata.results import is_wide

AGREES = 2.0
"""Two numbers agree if they differ by at most this many standard uncertainties of their
difference."""

BORED = 0.2
"""The bore of a ball explains no larger relative difference from a solid ball than this
[1]."""

ANSWERS = WORDS["answers"]

PER_SPIN = Scale("s per 100 rpm", r"s/(100\,rpm)", 0.01 / RPM.size)


def conclude(n: Numbers, task: str, *sentences: Sentence) -> Text:
    """Return a conclusion; in a worksheet, return the question that leads to it."""
    if n.is_worksheet:
        return paragraph(WORDS["tasks"][task], unlikely=str(UNLIKELY), kind="task")
    return Text(sentences)


def question_3(n: Numbers, agreement: Sentence) -> Iterator[Section]:
    """Answer question 3 from the data.

    Parameters
    ----------
    n : Numbers
        Of the analysis.
    agreement : Sentence
        Whether the runs agree with one line.

    Yields
    ------
    Section
        In the order of the lab sheet.
    """
    sections = (
        ("Precession period against spin", "3 a", _period(n), "period"),
        ("How the period depends on the spin", "3 b", _exponents(n), "exponent"),
        ("The product φ̇ψ̇ at one torque", "3 c", _product(n), "product"),
        ("Torque against φ̇ψ̇: the slope", "3 d", _slope(n, agreement), "torque"),
        ("The meaning of the slope", "3 e", _meaning(n), "meaning"),
    )
    for words, number, blocks, anchor in sections:
        title = words + _number(n, f"question {number}")
        yield Section(title, tuple(blocks), anchor)
    yield Section("One run by hand", tuple(_by_hand(n)), "byhand")


def other_questions(n: Numbers) -> Iterator[elements.Block]:
    """Name the commands for the other questions."""
    options = n.analysis.options
    more = ""
    if options.set or options.map:
        more = " (add the --set and --map that you gave)"
    # A shell would not read other names as one word.
    log = n.analysis.name
    if not re.fullmatch(r"[\w.][\w.+/-]*", log):
        log = "LOG"
    items = []
    for part, (asked, number) in WORDS["others"].items():
        command = f"gyro predict {part}"
        if part not in ("twist", "platform"):
            command += f" --log {log}"
        title = asked + _number(n, number)
        items.append(say("{}: {}", title, Styled(command, "code")))
    yield paragraph(ANSWERS["others"], more=more)
    yield Text(items, "list")


def _number(n: Numbers, number: str) -> str:
    """Write the number of a question on the lab sheet, unless the lab has none."""
    if n.analysis.readings.metadata.get("question_numbers") == "no":
        return ""
    return f" ({number})"


def _balance(n: Numbers) -> Sentence:
    """Say what M0 shows of the balance of the ball, as the end of a sentence."""
    m0 = n.analysis.residual_torque
    if is_wide(n.analysis.inertia):
        return (". These runs cannot show whether the ball is balanced.",)
    if not m0.u or m0.interval_95 is None:
        return (".",)
    if abs(m0.value / m0.u) > AGREES:
        return (". The ball was not perfectly balanced.",)
    low, high = m0.interval_95
    larger = 0 if -low > high else 1
    bound = n.bound(f"residual_torque.interval_95.{larger}", n.torque)
    return say(". The imbalance is smaller than {} (95 %).", bound)


def _slope(n: Numbers, agreement: Sentence) -> Iterator[elements.Block]:
    """Answer (d): the torque against φ̇ψ̇, whose slope is I_zz."""
    analysis = n.analysis
    yield PICTURES["torque"]
    yield paragraph("M + M0 = I_zz φ̇ψ̇ with {}", n.answer(), kind="result")
    yield conclude(n, "line", say("{}.", agreement))
    if analysis.p is None:
        yield paragraph(ANSWERS["no_quality"])
    else:
        chi2 = analysis.fit.chi2
        digits = f"{chi2:.0f}" if chi2 >= 1000 else f"{chi2:.3g}"
        yield paragraph(
            ANSWERS["quality"],
            p=n.p("goodness.p"),
            chi2=n.number("goodness.chi2", digits),
            dof=n.count("goodness.dof", "degree"),
            scatter=n.scatter("goodness.scatter"),
        )
    relation = say(ANSWERS["linear"], balance=_balance(n))
    if analysis.runs_disagree:
        relation = say(ANSWERS["not_linear"])
    yield conclude(n, "balance", relation)
    facts = [say("The residual torque M0 is {}.", n.value("residual_torque.value"))]
    if analysis.centre_of_mass is not None:
        distance = n.value("centre_of_mass.value", MICROMETRE)
        facts.append(say(ANSWERS["centre_of_mass"], distance=distance))
    if analysis.fits[1].deviation is not None:
        slope = n.value("fits.1.inertia.value")
        away = n.shift("fits.1.deviation")
        facts.append(say(ANSWERS["without_intercept"], slope=slope, away=away))
    if analysis.timing_bias.u:
        bias = n.value("timing_bias.value")
        facts.append(say("The timing bias b of the stopwatch is {}.", bias))
    yield Text((join_sentences(facts),))


def _period(n: Numbers) -> Iterator[elements.Block]:
    """Answer (a): the period against the spin."""
    yield PICTURES["period"]
    exponent = n.analysis.exponent
    case = "period_unknown"
    if exponent:
        is_proportional = abs(exponent.deviation) <= AGREES
        case = "period_proportional" if is_proportional else "period_increases"
    yield conclude(n, "period", say(ANSWERS[case]))
    rows = []
    for i, here in enumerate(n.each("torques")):
        torque = here.value("torque")
        per_spin = here.value("period_per_spin.value", PER_SPIN)
        rows.append((n.load(i), torque, here.number("runs"), per_spin))
    heads = "load", "torque M", "runs", "τ/ψ̇"
    yield table(heads, rows, "The period for each 100 rpm of spin")


def _exponents(n: Numbers) -> Iterator[elements.Block]:
    """Answer (b): the exponent of the period against the spin."""
    whole = n.analysis.exponent
    if whole is None:
        yield paragraph(ANSWERS["exponent_unknown"])
        return
    everything = n.value("exponent.value")
    yield paragraph("The runs give τ ∝ ψ̇ⁿ with n = {}", everything, kind="result")
    rows: list[tuple[elements.Cell, ...]] = []
    for i, here in enumerate(n.each("power_law")):
        exponent = here.cell("exponent", here.value, NUMBER)
        reason = None if exponent else message_words(here.find("reason"))
        rows.append((n.load(i), exponent, reason))
    rows.append(("all together", everything, None))
    proportional = replace(whole, value=1.0)
    heads = (
        "load",
        Head("exponent n", compared=proportional),
        Head("remark", wrap=0.45),
    )
    caption = "Exponent of each torque, and one for all"
    yield table(heads, rows, caption, main=len(rows) - 1)
    agrees = abs(whole.deviation) <= AGREES
    case = "exponent_agrees" if agrees else "exponent_differs"
    deviation = n.shift("exponent.deviation")
    verdict = say(ANSWERS[case], deviation=deviation)
    reason = say(ANSWERS["exponent_reason"])
    yield conclude(n, "exponent", verdict, reason)


def _product(n: Numbers) -> Iterator[elements.Block]:
    """Answer (c): φ̇ψ̇ at one torque."""
    yield PICTURES["product"]
    constancy = n.analysis.constancy
    if constancy is None:
        yield paragraph(ANSWERS["product_unknown"])
    else:
        is_constant = constancy.p >= UNLIKELY
        case = "product_constant" if is_constant else "product_varies"
        yield conclude(n, "product", say(ANSWERS[case]))
        yield paragraph(
            ANSWERS["product_scatter"],
            scatter=n.percent("constancy.scatter", sign=False),
            expected=n.percent("constancy.expected", sign=False),
            p=n.p("constancy.p"),
        )
    rows = []
    for i, here in enumerate(n.each("torques")):
        mean = here.value("product.value")
        spread = here.cell("product.spread", here.scatter, PRODUCT)
        p_of_group = here.cell("product.p", here.p)
        without = here.cell("without.value")
        rows.append((n.load(i), mean, spread, p_of_group, without))
    heads = (
        "load",
        "mean φ̇ψ̇",
        "scatter",
        Head("p", NUMBER),
        "I_zz without these runs",
    )
    yield table(heads, rows, ANSWERS["product_table"])


def _meaning(n: Numbers) -> Iterator[elements.Block]:
    """Answer (e): what the slope is, and what the dimensions of the ball give."""
    yield conclude(n, "meaning", say(ANSWERS["meaning"]))
    spins = [run.spin for run in n.analysis.run_table]
    fastest = spins.index(max(spins))
    momentum = n.value("angular_momentum.value")
    spin = n.reading(fastest, "spin")
    fastest_words = "At the fastest spin, {}, L = I_zz ψ̇ = {}."
    yield paragraph(fastest_words, spin, momentum, kind="result")
    ball = n.analysis.ball
    if ball is None:
        mass = Styled("# ball_mass: 4.10 ± 0.01 kg", "code")
        diameter = Styled("# ball_diameter: 10.16 ± 0.01 cm", "code")
        words = ANSWERS["no_ball"]
        yield paragraph(words, mass=mass, diameter=diameter, kind="small")
        return
    exact = ""
    if ball.inertia_u is None:
        exact = " (assumed exact: the log gives no uncertainty)"
    scale = values.inertia_scale(ball.inertia, ball.inertia_u)
    whole = n.value("ball.inertia", scale)
    if ball.mass is None:
        words = "The disk that the log describes has ½ m r² = {}{}."
        yield paragraph(words, whole, exact)
    else:
        parts = {"its bore": ball.bore, "its rod": ball.rod, "the disk": ball.disk}
        names = [name for name, part in parts.items() if part]
        added = f" with {' and '.join(names)}" if names else ""
        yield paragraph(
            "A ball of {} and {} has 2/5 m r²{} = {}{}.",
            n.value("ball.mass", KILOGRAM),
            n.value("ball.diameter", CENTIMETRE),
            added,
            whole,
            exact,
        )
    yield conclude(n, "ball", compare_with_ball(n))


def compare_with_ball(n: Numbers) -> Sentence:
    """Say if the measured I_zz agrees with the value for the ball or disk."""
    ball = n.analysis.ball
    assert ball is not None
    body = "disk" if ball.mass is None else "ball"
    difference = n.percent("ball.relative")
    if ball.deviation is None:
        return say(ANSWERS["ball_without_u"], body=body, difference=difference)
    if ball.relative > 1:
        factor = n.number("ball.relative", f"{ball.relative:.3g}")
        return say(ANSWERS["ball_far"], body=body, factor=factor)
    close = abs(ball.deviation) <= AGREES
    is_solid = ball.mass is not None and not ball.bore
    bore = ""
    if is_solid and not close and abs(ball.relative) < BORED:
        bore = ANSWERS["bore"]
    of_ball = values.inertia_scale(ball.inertia, None)
    return say(
        ANSWERS["ball"],
        agrees="agrees" if close else "does not agree",
        body=body,
        inertia=n.value("ball.inertia", of_ball, u=False),
        difference=difference,
        deviation=n.shift("ball.deviation"),
        bore=bore,
    )


# --- one run by hand ---


def _by_hand(n: Numbers) -> Iterator[elements.Block]:
    """Compute I_zz from the first run that has a load and is in the fit.

    The result shows the calculation step by step in SI units.
    """
    runs = n.analysis.run_table
    measured = n.analysis.measurements
    loaded = [i for i, run in enumerate(runs) if run.torque]
    i = min(loaded, key=lambda i: runs[i].left_out)
    run = runs[i]
    here = n.at(f"runs.{i}")
    torque = here.value("torque", NEWTON_METRE)
    of_torque = say("M = {}, as the log gives it", torque)
    if run.mass is not None and run.position is not None:
        mass = here.value("mass", KILOGRAM, step=measured.mass_step[i])
        arm = here.value("position", METRE, step=measured.position_step[i])
        g = n.value("constants.g", FREE_FALL)
        of_torque = say("M = m g x = {} × {} × {} = {}", mass, g, arm, torque)
    rate = here.value("precession_rate")
    of_rate = say("φ̇ = {}, as the log gives it", rate)
    if measured.timed:
        turns, _ = turn_words(run.turns).split(" ")
        words = (
            "φ̇ = {}2π × ({}) / {} = {}" if "/" in turns else "φ̇ = {}2π × {} / {} = {}"
        )
        # The rod turns the other way if the weight is on the other side.
        sign = "−" if run.precession_rate < 0 else ""
        number = here.number("turns", turns)
        of_rate = say(words, sign, number, n.reading(i, "time"), rate)
    read = n.reading(i, "spin")
    spin = here.value("spin")
    mean = ""
    if measured.spin_start is not None:
        mean = ", the mean of what was read"
    product = here.value("product")
    inertia = here.value("inertia")
    words = "Run {} (line {}), the first with a load that is in the fit, by eq. (9):"
    yield paragraph(words, here.number("run"), here.number("line"))
    steps = (
        of_torque,
        of_rate,
        say("ψ̇ = {} × (2π rad)/(60 s) = {}{}", read, spin, mean),
        say("φ̇ψ̇ = {} × {} = {}", rate, spin, product),
        say("I_zz = M/(φ̇ψ̇) = {} / ({}) = {}", torque, product, inertia),
    )
    yield Text(steps, "list")
    fitted = n.value("inertia.value")
    method = n.analysis.model.words
    yield paragraph(ANSWERS["single_run"], method=method, inertia=fitted)
