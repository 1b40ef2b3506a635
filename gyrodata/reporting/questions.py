"""The questions of the lab sheet: the plots and laws of question 3, one run by hand, and commands for the others."""

from __future__ import annotations

import re
from collections.abc import Iterator

from gyrodata.plotting import FIGURES
from gyrodata.reporting import elements, values
from gyrodata.reporting.elements import Head, Numbers, Picture, Section, Sentence, Styled, Text, paragraph, say, table
from gyrodata.results import Analysis
from gyrodata.tables import turn_words

AGREES = 2.0
"""Two numbers agree if they differ by at most this many standard uncertainties of their difference."""

UNLIKELY = 0.05
"""The stated uncertainties do not explain a scatter whose p is below this."""

BORED = 0.2
"""The bore of a ball explains no larger relative difference from a solid ball than this [1]."""

MODEL_NAMES = {
    "horizontal": "eq. (9), a level rod",
    "steady": "eq. (8), a tilted rod",
    "released": "the mean rate of a rod released from rest",
}

_WHEEL = " (of the ball; add --wheel-inertia and --wheel-spin of the wheel that you held)"

OTHERS = (
    ("question 1, steps 3 to 5, a force on the tip of the rod", "tip"),
    ("question 1, steps 4 and 6, precession at any spin and pitch", "precession"),
    (f"question 1, step 9, a bicycle wheel twisted in your hands{_WHEEL}", "twist"),
    ("question 2, gyroscopes above the turning Earth", "earth"),
    (f"question 4, a wheel turned over on the platform{_WHEEL}", "platform"),
)
"""Questions that the data do not answer, with the part of `gyro predict` for each."""


def answer(n: Numbers, agreement: Sentence, quality: Sentence) -> Iterator[Section]:
    """Answer question 3 from the data.

    Parameters
    ----------
    n : Numbers
        Of the analysis.
    agreement, quality : Sentence
        Whether the runs agree with one line.

    Yields
    ------
    Section
        The torque against φ̇ψ̇ first, because its slope is the answer.
    """
    yield Section("Torque against φ̇ψ̇: the slope (question 3 d)", tuple(_slope(n, agreement, quality)), "torque")
    yield Section("Precession period against spin (question 3 a)", tuple(_period(n)), "period")
    yield Section("How the period depends on the spin (question 3 b)", tuple(_exponents(n)), "exponent")
    yield Section("The product φ̇ψ̇ at one torque (question 3 c)", tuple(_product(n)), "product")
    yield Section("The meaning of the slope (question 3 e)", tuple(_meaning(n)), "meaning")
    yield Section("One run by hand", tuple(_by_hand(n)), "byhand")


def others(analysis: Analysis) -> Section:
    """Name the commands for the other questions."""
    given = " (add the --set and --map that you gave)" if analysis.options.set or analysis.options.map else ""
    words = say(
        "Questions 1, 2 and 4 ask what you saw and felt, so this report cannot answer them. These commands show what "
        f"theory predicts; --log takes I_zz and the fastest spin from this log{given}:"
    )
    # A shell would not read other names as one word.
    log = analysis.name if re.fullmatch(r"[\w.][\w.+/-]*", analysis.name) else "LOG"
    items = tuple(say("{}: {}", asked, Styled(f"gyro predict {part} --log {log}", "code")) for asked, part in OTHERS)
    return Section("The other questions", (Text((words,)), Text(items, "list")), "others", True)


def _agrees(deviation: float | None) -> bool:
    return deviation is not None and abs(deviation) <= AGREES


def _slope(n: Numbers, agreement: Sentence, quality: Sentence) -> Iterator[elements.Block]:
    """Answer (d): the slope of the torque against φ̇ψ̇."""
    analysis, m0 = n.analysis, n.analysis.residual_torque
    yield Picture("torque", FIGURES["torque"].caption)
    yield paragraph("M + M0 = I_zz φ̇ψ̇ with I_zz = {}", n.value("inertia.value", n.inertia), kind="result")
    balance = ""
    if m0.u:
        shown = "shows no imbalance" if _agrees(m0.value / m0.u) else "was not perfectly balanced"
        balance = f": the ball {shown}"
    words = (
        "The torque is a linear function of φ̇ψ̇. Its residual torque is {}, which shifts the line but does not change "
        f"its slope{balance}."
    )
    if analysis.runs_disagree:
        words = (
            "These runs do not show a linear relation between torque and φ̇ψ̇: they do not agree with one line. If they "
            "did, the residual torque would be {}, and the slope I_zz as above."
        )
    law = say(words, n.value("residual_torque.value", n.torque))
    origin = analysis.fits[1]
    if origin.inertia is not None and origin.deviation is not None:
        slope, away = n.value("fits.1.inertia.value", n.inertia), n.shift("fits.1.deviation")
        law = say("{} A line without an intercept has the slope {}, {} away.", law, slope, away)
    yield Text((say("{} {}.", agreement, quality), law))


def _period(n: Numbers) -> Iterator[elements.Block]:
    """Answer (a): the period against the spin."""
    words = "No torque has runs at two different spins, so the runs do not show how the period depends on the spin."
    if n.analysis.exponent:
        words = "At each torque the period increases with the spin, but not proportionally, as the next section shows."
        if _agrees(n.analysis.exponent.deviation):
            words = (
                "At each torque the period is proportional to the spin: the runs are on a straight line through zero. "
                "A smaller torque gives a steeper line."
            )
    yield paragraph(words)
    yield Picture("period", FIGURES["period"].caption)
    per_spin = values.Scale("s per 100 rpm", r"s/(100\,rpm)", 1 / (100 * values.RPM.size))
    rows = [
        (
            n.load(i),
            n.value(f"torques.{i}.torque", n.torque),
            n.number(f"torques.{i}.runs"),
            n.value(f"torques.{i}.period_per_spin.value", per_spin),
        )
        for i in range(len(n.analysis.torques))
    ]
    heads = (Head("load"), Head("torque M", n.torque), Head("runs", values.NUMBER), Head("τ/ψ̇", per_spin))
    yield table(heads, rows, "The period for each 100 rpm of spin")


def _exponents(n: Numbers) -> Iterator[elements.Block]:
    """Answer (b): the exponent of the period against the spin."""
    whole, laws = n.analysis.exponent, n.analysis.power_law
    derived = say(
        "Eq. (9) says I_zz φ̇ψ̇ = M + M0, and one turn of precession takes τ = 2π/φ̇. So τ = 2π I_zz ψ̇ / (M + M0): at "
        "one torque the period is proportional to the spin, τ ∝ ψ̇ⁿ with n = 1."
    )
    yield Text((derived,))
    if whole is None:
        words = "No torque has runs at two different spins, so the log does not determine the exponent n of τ ∝ ψ̇ⁿ."
        yield paragraph(words)
        return
    everything = n.value("exponent.value")
    yield paragraph("τ ∝ ψ̇ⁿ with n = {}", everything, kind="result")
    words = "The exponent agrees with 1 ({} away): the period is proportional to the spin, as in eq. (9)."
    if not _agrees(whole.deviation):
        words = (
            "The exponent does not agree with 1 ({} away), the value of eq. (9). Check each torque, and the suspected "
            "outliers."
        )
    yield paragraph(words, n.shift("exponent.deviation"))
    rows: list[tuple[elements.Cell, ...]] = []
    for i, law in enumerate(laws):
        known = law.exponent is not None
        value = n.value(f"power_law.{i}.exponent") if known else None
        rows.append((n.load(i), value, None if known else say("{}", law.reason)))
    rows.append((say("all together"), everything, None))
    dots = [None if law.exponent is None else (law.exponent, law.u or 0.0) for law in laws]
    dots.append((whole.value, whole.u or 0.0))
    exponents = Head("exponent n", values.NUMBER, dots=tuple(dots), band=(1.0, 1.0))
    caption = "Exponent of each torque, and one for all"
    yield table((Head("load"), exponents, Head("remark", wrap=0.45)), rows, caption, main=len(rows) - 1)


def _product(n: Numbers) -> Iterator[elements.Block]:
    """Answer (c): φ̇ψ̇ at one torque."""
    found = n.analysis.constancy
    sentence = say("No torque has two runs, so the log does not show if φ̇ψ̇ is constant at one torque.")
    if found is not None:
        constant, but = ("constant within the uncertainties", "and")
        if found.p < UNLIKELY:
            constant, but = ("not constant within the stated uncertainties", "but")
        sentence = say(
            f"At one torque φ̇ψ̇ is {constant}: the runs scatter about the mean of their torque by {{}}, {but} {{}} is "
            "expected from timing and spin ({}).",
            n.percent("constancy.scatter", sign=False),
            n.percent("constancy.expected", sign=False),
            n.p("constancy.p"),
        )
    yield Text((sentence,))
    yield Picture("product", FIGURES["product"].caption)
    rows: list[tuple[elements.Cell, ...]] = []
    for i, group in enumerate(n.analysis.torques):
        at = f"torques.{i}.product"
        rows.append(
            (
                n.load(i),
                n.value(f"{at}.value", values.PRODUCT),
                None if group.product.spread is None else n.scatter(f"{at}.spread", values.PRODUCT),
                None if group.product.p is None else n.p(f"{at}.p"),
                None if group.without is None else n.value(f"torques.{i}.without.value", n.inertia),
            )
        )
    heads = (
        Head("load"),
        Head("mean φ̇ψ̇", values.PRODUCT),
        Head("scatter", values.PRODUCT),
        Head("p", values.NUMBER),
        Head("I_zz without these runs", n.inertia),
    )
    caption = (
        "For each torque: the weighted mean, the standard deviation of the runs, the probability p of a scatter at "
        "least as large, and I_zz without these runs"
    )
    yield table(heads, rows, caption)


def _meaning(n: Numbers) -> Iterator[elements.Block]:
    """Answer (e): what the slope is, and what the dimensions of the ball give."""
    words = (
        "The slope is the moment of inertia about the rod of everything that spins: ball, rod and weight. A mass "
        "resists a change of its speed; in the same way I_zz resists a change of the spin. The larger I_zz is, the "
        "slower the same torque turns the axis."
    )
    yield paragraph(words)
    ball = n.analysis.ball
    if ball is None:
        ask = (
            "With the ball's mass and diameter in the log ({}, {}) gyro compares I_zz with 2/5 m r². Without them gyro "
            "cannot detect a wrong unit in a whole column."
        )
        lines = (Styled(f"# ball_{one}", "code") for one in ("mass: 4.10 ± 0.01 kg", "diameter: 10.16 ± 0.01 cm"))
        yield paragraph(ask, *lines, kind="small")
        return
    exact = " (assumed exact: the log gives no uncertainty)" if ball.inertia_u is None else ""
    whole = n.value("ball.inertia", values.inertia_scale(ball.inertia, ball.inertia_u))
    described = say("The disk that the log describes has ½ m r² = {}{}. ", whole, exact)
    if ball.mass is not None:
        parts = (("its bore", ball.bore), ("its rod", ball.rod), ("the disk", ball.disk))
        added = " and ".join(name for name, part in parts if part)
        described = say(
            f"A ball of {{}} and {{}} has 2/5 m r²{' with ' if added else ''}{added} = {{}}{exact}. ",
            n.value("ball.mass", values.mass_scale(ball.mass)),
            n.value("ball.diameter", values.CENTIMETRE),
            whole,
        )
    yield Text(((*described, *compare_with_ball(n)),))
    names = {"solid": "solid ball", "bore": "bore, for the same mass", "rod": "rod", "disk": "disk"}
    found = [key for key in names if n.find(f"ball.{key}")]
    if len(found) > 1:
        items = [say("{}: {}", names[key], n.value(f"ball.{key}", n.inertia)) for key in found]
        yield Text(tuple(items), "list")


def compare_with_ball(n: Numbers) -> Sentence:
    """Say if the measured I_zz agrees with the value for the ball or disk."""
    ball = n.analysis.ball
    assert ball is not None
    body = "disk" if ball.mass is None else "ball"
    relative = n.percent("ball.relative")
    if ball.deviation is None:
        return say(
            f"I_zz differs from the value for the {body} by {{}}; without an uncertainty this cannot be judged.",
            relative,
        )
    if ball.relative > 1:
        times = n.number("ball.relative", f"{ball.relative:.3g}")
        words = (
            f"I_zz does not agree with the value for the {body}: the difference is {{}} times the value for the {body}."
        )
        return say(words, times)
    close, bore = _agrees(ball.deviation), ""
    if not close and ball.mass is not None and not ball.bore and abs(ball.relative) < BORED:
        bore = (
            " A bore along the rod removes mass near the axis, so a ball of the same mass has a little more than "
            "2/5 m r²; the rod and the weights add to it."
        )
    return say(
        f"I_zz {'agrees' if close else 'does not agree'} with the value for the {body}, {{}}: the difference is {{}} "
        f"({{}} of the difference).{bore}",
        n.value("ball.inertia", values.inertia_scale(ball.inertia, None), u=False),
        relative,
        n.shift("ball.deviation"),
    )


def _by_hand(n: Numbers) -> Iterator[elements.Block]:
    """Compute I_zz from the first run that has a load and is in the fit, step by step in SI units."""
    analysis, measured = n.analysis, n.analysis.measurements
    i = min(
        (i for i, run in enumerate(analysis.run_table) if run.torque), key=lambda i: (analysis.run_table[i].left_out, i)
    )
    run, at = analysis.run_table[i], f"runs.{i}"
    moment, product = n.value(f"{at}.torque", values.NEWTON_METRE), n.value(f"{at}.product", values.PRODUCT)
    rate, spin = n.value(f"{at}.precession_rate", values.RATE), n.value(f"{at}.spin", values.RATE)
    torque = say("M = {}, as the log gives it", moment)
    if run.mass is not None and run.position is not None:
        of_mass, of_arm = measured.steps_of_load(i)
        torque = say(
            "M = m g x = {} × {} × {} = {}",
            n.value(f"{at}.mass", values.KILOGRAM, step=of_mass),
            n.value("constants.g", values.FREE_FALL),
            n.value(f"{at}.position", values.METRE, step=of_arm),
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
            n.value(f"{at}.time", values.SECOND),
            rate,
        )
    mean = ", the mean of what was read" if measured.spin_readings > 1 else ""
    steps = (
        torque,
        turning,
        say("ψ̇ = {} × (2π rad)/(60 s) = {}{}", n.value(f"{at}.spin", values.RPM), spin, mean),
        say("φ̇ψ̇ = {} × {} = {}", rate, spin, product),
        say("I_zz = M/(φ̇ψ̇) = {} / ({}) = {}", moment, product, n.value(f"{at}.inertia", n.inertia)),
    )
    first = "Run {} (line {}), the first with a load that is in the fit, by eq. (9):"
    yield paragraph(first, n.number(f"{at}.run"), n.number(f"{at}.line"))
    yield Text(steps, "list")
    last = (
        "A single run is affected by its reading errors, by M0 and by b. The fit uses all runs together, by "
        f"{MODEL_NAMES[analysis.model.name]}, and determines M0 and b together with I_zz = {{}}."
    )
    yield paragraph(last, n.value("inertia.value", n.inertia))
