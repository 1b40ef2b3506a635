"""The questions of the lab sheet.

They are the plots and laws of question 3, one run by hand, and commands for the other
questions.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

from gyrodata.judging.tables import UNLIKELY, Ball, turn_words
from gyrodata.reporting import elements, values
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
from gyrodata.reporting.figures import FIGURES
from gyrodata.results import Analysis, is_wide

AGREES = 2.0
"""Two numbers agree if they differ by at most this many standard uncertainties of their
difference."""

BORED = 0.2
"""The bore of a ball explains no larger relative difference from a solid ball than this
[1]."""

WORDS = tomllib.loads(
    Path(__file__).with_name("words.toml").read_text(encoding="utf-8")
)
"""Names and questions in the report, by section and key."""


def is_worksheet(analysis: Analysis) -> bool:
    """Return whether the report asks questions in the place of conclusions."""
    return analysis.options.worksheet or (
        analysis.readings.metadata.get("worksheet") == "yes"
    )


def conclude(n: Numbers, task: str, *sentences: Sentence) -> Text:
    """Return a conclusion; in a worksheet, return the question that leads to it."""
    if is_worksheet(n.analysis):
        return paragraph(WORDS["tasks"][task], kind="task")
    return Text(sentences)


def answer(
    n: Numbers, inertia: Sentence, agreement: Sentence, quality: Sentence
) -> Iterator[Section]:
    """Answer question 3 from the data.

    Parameters
    ----------
    n : Numbers
        Of the analysis.
    inertia : Sentence
        I_zz with its uncertainty, or its interval if that is wide.
    agreement, quality : Sentence
        Whether the runs agree with one line.

    Yields
    ------
    Section
        In the order of the lab sheet.
    """
    slope = _slope(n, inertia, agreement, quality)
    sections = (
        ("Precession period against spin", "3 a", _period(n), "period"),
        ("How the period depends on the spin", "3 b", _exponents(n), "exponent"),
        ("The product φ̇ψ̇ at one torque", "3 c", _product(n), "product"),
        ("Torque against φ̇ψ̇: the slope", "3 d", slope, "torque"),
        ("The meaning of the slope", "3 e", _meaning(n), "meaning"),
    )
    for words, number, blocks, anchor in sections:
        yield Section(
            f"{words}{_number(n, f'question {number}')}", tuple(blocks), anchor
        )
    yield Section("One run by hand", tuple(_by_hand(n)), "byhand")


def others(n: Numbers) -> Section:
    """Name the commands for the other questions."""
    options = n.analysis.options
    values = (
        " (add the --set and --map that you gave)" if options.set or options.map else ""
    )
    words = (
        "The log does not contain what you saw and felt. These commands show what "
        "theory predicts; --log takes I_zz "
        f"and the fastest spin from this log{values}:"
    )
    # A shell would not read other names as one word.
    log = n.analysis.name if re.fullmatch(r"[\w.][\w.+/-]*", n.analysis.name) else "LOG"
    items = [
        say(
            f"{asked}{_number(n, number)}: {{}}",
            Styled(
                f"gyro predict {part}"
                + f" --log {log}" * (part not in ("twist", "platform")),
                "code",
            ),
        )
        for part, (asked, number) in WORDS["others"].items()
    ]
    return Section(
        "The other questions",
        (paragraph(words), Text(tuple(items), "list")),
        "others",
        True,
    )


def _number(n: Numbers, number: str) -> str:
    """Write the number of a question on the lab sheet, unless the lab has none."""
    return (
        ""
        if n.analysis.readings.metadata.get("question_numbers") == "no"
        else f" ({number})"
    )


def _balance(n: Numbers) -> Sentence:
    """Say what M0 shows of the balance of the ball, as the end of a sentence."""
    m0 = n.analysis.residual_torque
    if is_wide(n.analysis.inertia):
        return (". These runs cannot show whether the ball is balanced.",)
    if not m0.u or m0.interval_95 is None:
        return (".",)
    if not _agrees(m0.value / m0.u):
        return (". The ball was not perfectly balanced.",)
    low, high = m0.interval_95
    larger = "interval_95.0" if -low > high else "interval_95.1"
    bound = n.bound(f"residual_torque.{larger}", n.torque)
    return say(". The imbalance is smaller than {} (95 %).", bound)


def _agrees(deviation: float | None) -> bool:
    return deviation is not None and abs(deviation) <= AGREES


def _slope(
    n: Numbers, inertia: Sentence, agreement: Sentence, quality: Sentence
) -> Iterator[elements.Block]:
    """Show the torque against φ̇ψ̇, whose slope is the answer."""
    analysis = n.analysis
    yield Picture("torque", FIGURES["torque"].caption)
    yield paragraph("M + M0 = I_zz φ̇ψ̇ with {}", inertia, kind="result")
    yield conclude(n, "line", say("{}.", agreement))
    yield paragraph("{}.", quality)
    balance = _balance(n)
    words = (
        "The torque is a linear function of φ̇ψ̇. M0 shifts the line but does not "
        "change its slope{}"
    )
    if analysis.runs_disagree:
        words = "These runs do not show a linear relation between torque and φ̇ψ̇{}"
        balance = (".",)
    yield conclude(n, "balance", say(words, balance))
    facts = residual_torque(n)
    if analysis.centre_of_mass is not None:
        words = (
            "{} Divided by the weight of the ball, it gives the distance of the centre "
            "of mass from the centre of the "
            "ball: {}, along the rod towards the weight."
        )
        facts = say(words, facts, n.value("centre_of_mass.value", values.MICROMETRE))
    origin = analysis.fits[1]
    if origin.inertia is not None and origin.deviation is not None:
        slope = n.value("fits.1.inertia.value", n.inertia)
        away = n.shift("fits.1.deviation")
        facts = say(
            "{} A line without an intercept has the slope {}, {} away.",
            facts,
            slope,
            away,
        )
    if analysis.timing_bias.u:
        facts = say(
            "{} The timing bias b of the stopwatch is {}.",
            facts,
            n.value("timing_bias.value", values.SECOND),
        )
    yield Text((facts,))


def residual_torque(n: Numbers) -> Sentence:
    """Write the residual torque."""
    return say(
        "The residual torque M0 is {}.", n.value("residual_torque.value", n.torque)
    )


def _period(n: Numbers) -> Iterator[elements.Block]:
    """Answer (a): the period against the spin."""
    words = (
        "No torque has runs at two different spins, so the runs do not show how the "
        "period depends on the spin."
    )
    if n.analysis.exponent:
        words = (
            "At each torque the period increases with the spin, but not "
            "proportionally, as the next section shows."
        )
        if _agrees(n.analysis.exponent.deviation):
            words = (
                "At each torque the period is proportional to the spin: the runs are "
                "on a straight line through zero. "
                "A smaller torque gives a steeper line."
            )
    yield conclude(n, "period", say(words))
    yield Picture("period", FIGURES["period"].caption)
    per_spin = values.Scale(
        "s per 100 rpm", r"s/(100\,rpm)", 1 / (100 * values.RPM.size)
    )
    rows = [
        (
            n.load(i),
            n.value(f"torques.{i}.torque", n.torque),
            n.number(f"torques.{i}.runs"),
            n.value(f"torques.{i}.period_per_spin.value", per_spin),
        )
        for i in range(len(n.analysis.torques))
    ]
    heads = (
        Head("load"),
        Head("torque M", n.torque),
        Head("runs", values.NUMBER),
        Head("τ/ψ̇", per_spin),
    )
    yield table(heads, rows, "The period for each 100 rpm of spin")


def _exponents(n: Numbers) -> Iterator[elements.Block]:
    """Answer (b): the exponent of the period against the spin."""
    whole = n.analysis.exponent
    laws = n.analysis.power_law
    if whole is None:
        words = (
            "No torque has runs at two different spins, so the log does not determine "
            "the exponent n of τ ∝ ψ̇ⁿ."
        )
        yield paragraph(words)
        return
    everything = n.value("exponent.value")
    yield paragraph("The runs give τ ∝ ψ̇ⁿ with n = {}", everything, kind="result")
    rows: list[tuple[elements.Cell, ...]] = []
    for i, law in enumerate(laws):
        known = law.exponent is not None
        value = n.value(f"power_law.{i}.exponent") if known else None
        rows.append((n.load(i), value, None if known else say("{}", law.reason)))
    rows.append((say("all together"), everything, None))
    dots = [
        None if law.exponent is None else (law.exponent, law.u or 0.0) for law in laws
    ]
    dots.append((whole.value, whole.u or 0.0))
    exponents = Head("exponent n", values.NUMBER, dots=tuple(dots), band=(1.0, 1.0))
    caption = "Exponent of each torque, and one for all"
    yield table(
        (Head("load"), exponents, Head("remark", wrap=0.45)),
        rows,
        caption,
        main=len(rows) - 1,
    )
    agrees = (
        "The exponent agrees with 1 ({} away): at one torque the period is "
        "proportional to the spin."
    )
    if not _agrees(whole.deviation):
        agrees = (
            "The exponent does not agree with 1 ({} away). Check each torque, and the "
            "suspected outliers."
        )
    reason = (
        "Eq. (9) gives n = 1: it says I_zz φ̇ψ̇ = M + M0, and one turn of precession "
        "takes τ = 2π/φ̇, so "
        "τ = 2π I_zz ψ̇ / (M + M0)."
    )
    yield conclude(
        n, "exponent", say(agrees, n.shift("exponent.deviation")), say(reason)
    )


def _product(n: Numbers) -> Iterator[elements.Block]:
    """Answer (c): φ̇ψ̇ at one torque."""
    constancy = n.analysis.constancy
    if constancy is None:
        yield paragraph(
            "No torque has two runs, so the log does not show if φ̇ψ̇ is constant at one torque."
        )
    else:
        constant = (
            "constant within the"
            if constancy.p >= UNLIKELY
            else "not constant within the stated"
        )
        yield conclude(
            n, "product", say(f"At one torque φ̇ψ̇ is {constant} uncertainties.")
        )
        yield paragraph(
            (
                "The runs scatter about the mean of their torque by {}; {} is expected "
                "from timing and spin ({})."
            ),
            n.percent("constancy.scatter", sign=False),
            n.percent("constancy.expected", sign=False),
            n.p("constancy.p"),
        )
    yield Picture("product", FIGURES["product"].caption)
    rows = [
        (
            n.load(i),
            n.value(f"torques.{i}.product.value", values.PRODUCT),
            None
            if group.product.spread is None
            else n.scatter(f"torques.{i}.product.spread", values.PRODUCT),
            None if group.product.p is None else n.p(f"torques.{i}.product.p"),
            None
            if group.without is None
            else n.value(f"torques.{i}.without.value", n.inertia),
        )
        for i, group in enumerate(n.analysis.torques)
    ]
    heads = (
        Head("load"),
        Head("mean φ̇ψ̇", values.PRODUCT),
        Head("scatter", values.PRODUCT),
        Head("p", values.NUMBER),
        Head("I_zz without these runs", n.inertia),
    )
    caption = (
        "For each torque: the weighted mean, the standard deviation of the runs, the "
        "probability p of a scatter at "
        "least as large, and I_zz without these runs"
    )
    yield table(heads, rows, caption)


def _meaning(n: Numbers) -> Iterator[elements.Block]:
    """Answer (e): what the slope is, and what the dimensions of the ball give."""
    words = (
        "The slope is the moment of inertia I_zz about the rod of everything that "
        "spins: ball, rod and weight. "
        "L = I_zz ψ̇ is the angular momentum along the rod. The torque is "
        "perpendicular to L, so it changes the "
        "direction of L but not its length: M + M0 = L φ̇. This is why the rod moves "
        "sideways and does not fall. With a "
        "larger I_zz the same spin gives a larger L, and the same torque turns the rod more slowly."
    )
    yield conclude(n, "meaning", say(words))
    runs = n.analysis.run_table
    fastest = max(range(len(runs)), key=lambda i: runs[i].spin)
    momentum = n.value("angular_momentum.value", values.ANGULAR_MOMENTUM)
    spin = n.reading(fastest, "spin", values.RPM)
    yield paragraph(
        "At the fastest spin, {}, L = I_zz ψ̇ = {}.", spin, momentum, kind="result"
    )
    yield from _ball(n)


def _ball(n: Numbers) -> Iterator[elements.Block]:
    """Compare I_zz with what the dimensions of the ball give."""
    ball = n.analysis.ball
    if ball is None:
        ask = (
            "With the ball's mass and diameter in the log ({}, {}) gyro compares I_zz "
            "with 2/5 m r². Without them gyro "
            "cannot detect a wrong unit in a whole column."
        )
        lines = (
            Styled(f"# ball_{line}", "code")
            for line in ("mass: 4.10 ± 0.01 kg", "diameter: 10.16 ± 0.01 cm")
        )
        yield paragraph(ask, *lines, kind="small")
        return
    yield Text((_described(n, ball),))
    yield conclude(n, "ball", compare_with_ball(n))
    names = {
        "solid": "solid ball",
        "bore": "bore, for the same mass",
        "rod": "rod",
        "disk": "disk",
    }
    keys = [key for key in names if n.find(f"ball.{key}")]
    if len(keys) > 1:
        items = [
            say("{}: {}", names[key], n.value(f"ball.{key}", n.inertia)) for key in keys
        ]
        yield Text(tuple(items), "list")


def _described(n: Numbers, ball: Ball) -> Sentence:
    """Write what the dimensions of the ball or disk give."""
    exact = (
        " (assumed exact: the log gives no uncertainty)"
        if ball.inertia_u is None
        else ""
    )
    whole = n.value("ball.inertia", values.inertia_scale(ball.inertia, ball.inertia_u))
    if ball.mass is None:
        return say("The disk that the log describes has ½ m r² = {}{}.", whole, exact)
    parts = (
        ("its bore", ball.bore),
        ("its rod", ball.rod),
        ("the disk", ball.disk),
    )
    added = " and ".join(name for name, part in parts if part)
    return say(
        (
            f"A ball of {{}} and {{}} has 2/5 m "
            f"r²{' with ' if added else ''}{added} = {{}}{exact}."
        ),
        n.value("ball.mass", values.mass_scale(ball.mass)),
        n.value("ball.diameter", values.CENTIMETRE),
        whole,
    )


def compare_with_ball(n: Numbers) -> Sentence:
    """Say if the measured I_zz agrees with the value for the ball or disk."""
    ball = n.analysis.ball
    assert ball is not None
    body = "disk" if ball.mass is None else "ball"
    relative = n.percent("ball.relative")
    if ball.deviation is None:
        words = (
            "I_zz differs from the value for the {} by {}; without an uncertainty this "
            "cannot be judged."
        )
        return say(words, body, relative)
    if ball.relative > 1:
        words = (
            "I_zz does not agree with the value for the {}: the difference is {} times "
            "the value for the {}."
        )
        return say(words, body, n.number("ball.relative", f"{ball.relative:.3g}"), body)
    close = _agrees(ball.deviation)
    bore = ""
    if (
        not close
        and ball.mass is not None
        and not ball.bore
        and abs(ball.relative) < BORED
    ):
        bore = (
            " A bore along the rod removes mass near the axis, so a ball of the same "
            "mass has a little more than "
            "2/5 m r²; the rod and the weights add to it."
        )
    return say(
        f"I_zz {'agrees' if close else 'does not agree'} with the value for the "
        f"{body}, {{}}: the difference is {{}} "
        f"({{}} of the difference).{bore}",
        n.value("ball.inertia", values.inertia_scale(ball.inertia, None), u=False),
        relative,
        n.shift("ball.deviation"),
    )


def _by_hand(n: Numbers) -> Iterator[elements.Block]:
    """Compute I_zz from the first run that has a load and is in the fit.

    The result shows the calculation step by step in SI units.
    """
    analysis = n.analysis
    measured = n.analysis.measurements
    i = min(
        (run.left_out, i) for i, run in enumerate(analysis.run_table) if run.torque
    )[1]
    run = analysis.run_table[i]
    at = f"runs.{i}"
    moment = n.value(f"{at}.torque", values.NEWTON_METRE)
    product = n.value(f"{at}.product", values.PRODUCT)
    rate = n.value(f"{at}.precession_rate", values.RATE)
    spin = n.value(f"{at}.spin", values.RATE)
    torque = say("M = {}, as the log gives it", moment)
    if run.mass is not None and run.position is not None:
        torque = say(
            "M = m g x = {} × {} × {} = {}",
            n.value(f"{at}.mass", values.KILOGRAM, step=measured.mass_step[i]),
            n.value("constants.g", values.FREE_FALL),
            n.value(f"{at}.position", values.METRE, step=measured.position_step[i]),
            moment,
        )
    turning = say("φ̇ = {}, as the log gives it", rate)
    if measured.timed:
        turns = turn_words(run.turns).split(" ")[0]
        # The rod turns the other way if the weight is on the other side.
        sign = "−" if run.precession_rate < 0 else ""
        turning = say(
            f"φ̇ = {sign}2π × {'({})' if '/' in turns else '{}'} / {{}} = {{}}",
            n.number(f"{at}.turns", turns),
            n.reading(i, "time", values.SECOND),
            rate,
        )
    mean = ", the mean of what was read" if measured.spin_readings > 1 else ""
    steps = (
        torque,
        turning,
        say(
            "ψ̇ = {} × (2π rad)/(60 s) = {}{}",
            n.reading(i, "spin", values.RPM),
            spin,
            mean,
        ),
        say("φ̇ψ̇ = {} × {} = {}", rate, spin, product),
        say(
            "I_zz = M/(φ̇ψ̇) = {} / ({}) = {}",
            moment,
            product,
            n.value(f"{at}.inertia", n.inertia),
        ),
    )
    first = "Run {} (line {}), the first with a load that is in the fit, by eq. (9):"
    yield paragraph(first, n.number(f"{at}.run"), n.number(f"{at}.line"))
    yield Text(steps, "list")
    last = (
        "A single run is affected by its reading errors, by M0 and by b. The fit uses "
        "all runs together, by "
        f"{analysis.model.words}, and determines M0 and b together with I_zz = {{}}."
    )
    yield paragraph(last, n.value("inertia.value", n.inertia))
