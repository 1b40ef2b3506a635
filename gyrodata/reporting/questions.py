"""The questions of the lab sheet: one run by hand, question 3 (a) to (e), and commands for the others."""

from __future__ import annotations

import re
from collections.abc import Iterator

from msgspec.structs import replace

from gyrodata.plotting import FIGURES
from gyrodata.reporting import tree, values
from gyrodata.reporting.phrases import MODEL_NAMES
from gyrodata.results import Analysis
from gyrodata.tables import turn_words

_WHEEL = " (of the ball; add --wheel-inertia and --wheel-spin of the wheel that you held)"

BORED = 0.2
"""The bore of a ball explains no larger difference than this from a solid one [1]."""

ANSWERS = (
    ("question 1, steps 3 to 5, a force on the tip of the rod", "tip"),
    ("question 1, steps 4 and 6, precession at any spin and pitch", "precession"),
    (f"question 1, step 9, a bicycle wheel twisted in your hands{_WHEEL}", "twist"),
    ("question 2, gyroscopes above the turning Earth", "earth"),
    (f"question 4, a wheel turned over on the platform{_WHEEL}", "platform"),
)
"""Questions that the data do not answer, with the part of `gyro predict` for each."""


def answer_questions(analysis: Analysis, scale: values.Scale, torque: values.Scale) -> Iterator[tree.Section]:
    """Answer question 3 from the data, and name the commands for the others."""
    yield tree.Section("One run by hand", _by_hand(analysis, scale), "byhand", "By hand")
    yield tree.Section("Question 3: results from the data", (), "q3")
    yield tree.Section("(a) Precession period against spin", _period(analysis, torque), "q3a", "3 (a)", 3)
    yield tree.Section("(b) How the period depends on the spin", _exponents(analysis, torque), "q3b", "(b)", 3)
    yield tree.Section("(c) The product φ̇ψ̇ at one torque", _product(analysis, scale, torque), "q3c", "(c)", 3)
    words = "(d) Torque against φ̇ψ̇: the slope"
    yield tree.Section(words, _constant(analysis, scale, torque), "q3d", "(d)", 3)
    yield tree.Section("(e) The meaning of the slope", tuple(_meaning(analysis, scale)), "q3e", "(e)", 3)
    yield tree.Section("The other questions", _others(analysis), "others", "Other questions")


def _by_hand(analysis: Analysis, scale: values.Scale) -> tuple[tree.Block, ...]:
    """Work out I_zz from the first run that has a load and is in the fit, step by step in SI units."""
    table, measured = analysis.run_table, analysis.measurements
    i = min((i for i, run in enumerate(table) if run.torque), key=lambda i: (table[i].left_out, i))
    run, at = table[i], f"runs.{i}"
    moment = tree.Value(run.torque, None, values.NEWTON_METRE, f"{at}.torque")
    rate = tree.Value(run.precession_rate, None, values.RATE, f"{at}.precession_rate")
    spin = tree.Value(run.spin, None, values.RATE, f"{at}.spin")
    product = tree.Value(run.product, None, values.PRODUCT, f"{at}.product")
    torque: tree.Sentence = ("M = ", moment, ", as the log gives it")
    if run.mass is not None and run.position is not None:
        of_mass, of_arm = measured.steps_of_load(i)
        mass = tree.Value(run.mass, None, values.KILOGRAM, f"{at}.mass", step=of_mass)
        arm = tree.Value(run.position, None, values.METRE, f"{at}.position", step=of_arm)
        torque = (
            "M = m g x = ",
            mass,
            " × ",
            tree.Value(measured.g, None, values.FREE_FALL, "constants.g"),
            " × ",
            arm,
            " = ",
            moment,
        )
    turning: tree.Sentence = ("φ̇ = ", rate, ", as the log gives it")
    if measured.timed:
        turns = turn_words(run.turns).split(" ")[0]
        part: tree.Sentence = (tree.Number(turns, f"{at}.turns"),)
        part = ("(", *part, ")") if "/" in turns else part
        # The other way round than a weight on the tip's side makes it go.
        sign = "−" if run.precession_rate < 0 else ""
        turning = (
            f"φ̇ = {sign}2π × ",
            *part,
            " / ",
            tree.Value(run.time, None, values.SECOND, f"{at}.time"),
            " = ",
            rate,
        )
    mean = ", the mean of what was read" if measured.spin_readings > 1 else ""
    spinning: tree.Sentence = (
        "ψ̇ = ", tree.Value(run.spin, None, values.RPM, f"{at}.spin"), " × (2π rad)/(60 s) = ", spin, mean,
    )  # fmt: skip
    steps: tuple[tree.Sentence, ...] = (
        torque,
        turning,
        spinning,
        ("φ̇ψ̇ = ", rate, " × ", spin, " = ", product),
        (
            "I_zz = M/(φ̇ψ̇) = ",
            moment,
            " / (",
            product,
            ") = ",
            tree.Value(run.inertia or 0.0, None, scale, f"{at}.inertia"),
        ),
    )
    inertia = analysis.inertia
    first: tree.Sentence = (
        "Run ", tree.Number(run.run, f"{at}.run"), " (line ", tree.Number(str(run.line), f"{at}.line"),
        "), the first with a load that is in the fit, by eq. (9):",
    )  # fmt: skip
    words = (
        "A single run is affected by its reading errors, by M0 and by b. The fit uses all runs together, by "
        f"{MODEL_NAMES[analysis.model.name]}, and determines M0 and b together with I_zz = "
    )
    last: tree.Sentence = (words, tree.Value(inertia.value, inertia.u, scale, "inertia.value"), ".")
    return (tree.Text((first,), full=True), tree.Text(steps, "list", full=True), tree.Text((last,), full=True))


def _others(analysis: Analysis) -> tuple[tree.Block, ...]:
    given = " (add the --set and --map that you gave)" if analysis.options.set or analysis.options.map else ""
    words = (
        "Questions 1, 2 and 4 ask what you saw and felt, so this report cannot answer them. These commands show what "
        f"theory predicts; --log takes I_zz and the fastest spin from this log{given}:"
    )
    # A name that a shell would take apart is not written into a command.
    log = analysis.name if re.fullmatch(r"[\w.][\w.+/-]*", analysis.name) else "LOG"
    items = tuple((f"{asked}: ", tree.Styled(f"gyro predict {part} --log {log}", "code")) for asked, part in ANSWERS)
    return (tree.Text(((words,),), full=True), tree.Text(items, "list", full=True))


def _period(analysis: Analysis, torque: values.Scale) -> tuple[tree.Block, ...]:
    words = "No torque has runs at two different spins, so the runs do not show how the period depends on the spin."
    if analysis.exponent:
        words = (
            "At each torque the period is proportional to the spin: the runs are on a straight line through zero. "
            "A smaller torque gives a steeper line."
            if tree.agrees(analysis.exponent.deviation)
            else "At each torque the period increases with the spin, but not proportionally, as (b) shows."
        )
    # τ/ψ̇ in seconds for each 100 rpm.
    steepness = values.Scale("s per 100 rpm", r"s/(100\,rpm)", 1 / (100 * values.RPM.size))
    rows = tuple(
        (
            tree.load(analysis, i, torque),
            tree.Value(group.torque, None, torque, f"torques.{i}.torque"),
            (tree.Number(str(group.runs), f"torques.{i}.runs"),),
            tree.Value(slope.value, slope.u, steepness, f"torques.{i}.period_per_spin.value"),
        )
        for i, group in enumerate(analysis.torques)
        for slope in (group.period_per_spin,)
    )
    heads = (
        tree.Head("load"),
        tree.Head("torque M", torque),
        tree.Head("runs", values.NUMBER),
        tree.Head("τ/ψ̇", steepness),
    )
    return (
        tree.Text(((words,),), full=True),
        tree.Figure("period", FIGURES["period"].caption),
        tree.Table(heads, rows, "The period for each 100 rpm of spin", full=True),
    )


def _exponents(analysis: Analysis, torque: values.Scale) -> tuple[tree.Block, ...]:
    whole = analysis.exponent
    derived: tuple[tree.Sentence, ...] = (
        ("Eq. (9) says I_zz φ̇ψ̇ = M + M0, and one turn of precession takes τ = 2π/φ̇.",),
        ("So τ = 2π I_zz ψ̇ / (M + M0): at one torque the period is proportional to the spin, τ ∝ ψ̇ⁿ with n = 1.",),
    )
    if whole is None:
        words = "No torque has runs at two different spins, so the log does not determine the exponent n of τ ∝ ψ̇ⁿ."
        return (tree.Text((*derived, (words,)), full=True),)
    away = tree.Number(tree.signed(whole.deviation), "exponent.deviation")
    agree: tree.Sentence = (
        "The exponent agrees with 1 (",
        away,
        " u away): the period is proportional to the spin, as in eq. (9).",
    )
    if not tree.agrees(whole.deviation):
        advice = "Check each torque, and the suspected outliers"
        agree = ("The exponent does not agree with 1 (", away, f" u away), the value of eq. (9). {advice}.")
    everything = tree.Value(whole.value, whole.u, values.NUMBER, "exponent.value")
    rows: list[tuple[tree.Cell, ...]] = [
        (
            tree.load(analysis, i, torque),
            None if law.exponent is None else tree.Value(law.exponent, law.u, values.NUMBER, f"power_law.{i}.exponent"),
            None if law.exponent is not None else (law.reason,),
        )
        for i, law in enumerate(analysis.power_law)
    ]
    rows.append((("all together",), everything, None))
    laws = [None if law.exponent is None else (law.exponent, law.u or 0.0) for law in analysis.power_law]
    dots = (*laws, (whole.value, whole.u or 0.0))
    heads = (tree.Head("load"), tree.Head("exponent n", values.NUMBER), tree.Head("remark", wrap=0.45))
    picture = tree.Picture("exponent n", dots, (1.0, 1.0), "the bars are ± u, the line is n = 1")
    table = tree.filled(heads, rows, "Exponent of each torque, and one for all", picture, main=len(rows) - 1)
    return (
        tree.Text(derived, full=True),
        tree.Text((("τ ∝ ψ̇ⁿ with n = ", everything),), "result", True),
        tree.Text((agree,), full=True),
        table,
    )


def _product(analysis: Analysis, scale: values.Scale, torque: values.Scale) -> tuple[tree.Block, ...]:
    found = analysis.constancy
    sentence: tree.Sentence = ("No torque has two runs, so the log does not show if φ̇ψ̇ is constant at one torque.",)
    if found is not None:
        constant, where = (
            ("constant within the uncertainties", ", and ")
            if found.p >= tree.UNLIKELY
            else ("not constant within the stated uncertainties", ", but ")
        )
        sentence = (
            f"At one torque φ̇ψ̇ is {constant}: the runs scatter about the mean of their torque by ",
            *tree.percent(found.scatter, "constancy.scatter", signed=False), where,
            *tree.percent(found.expected, "constancy.expected", signed=False), " is expected from timing and spin (",
            *tree.chance(found.p, "constancy.p"), ").",
        )  # fmt: skip
    rows: list[tuple[tree.Cell, ...]] = []
    for i, group in enumerate(analysis.torques):
        at, product, without = f"torques.{i}.product", group.product, group.without
        rows.append(
            (
                tree.load(analysis, i, torque),
                tree.Value(product.value, product.u, values.PRODUCT, f"{at}.value"),
                None
                if product.spread is None
                else tree.Value(product.spread, None, values.PRODUCT, f"{at}.spread", is_u=True),
                None if product.p is None else tree.chance(product.p, f"{at}.p"),
                None if without is None else tree.Value(without.value, without.u, scale, f"torques.{i}.without.value"),
            )
        )
    heads = (
        tree.Head("load"),
        tree.Head("mean φ̇ψ̇", values.PRODUCT),
        tree.Head("scatter", values.PRODUCT),
        tree.Head("p", values.NUMBER),
        tree.Head("I_zz without these runs", scale),
    )
    caption = (
        "For each torque: the weighted mean, the standard deviation of the runs, the probability p of a scatter at "
        "least as large, and I_zz without these runs"
    )
    figure = tree.Figure("product", FIGURES["product"].caption)
    return (tree.Text((sentence,), full=True), figure, tree.filled(heads, rows, caption))


def _constant(analysis: Analysis, scale: values.Scale, torque: values.Scale) -> tuple[tree.Block, ...]:
    inertia, m0, origin = analysis.inertia, analysis.residual_torque, analysis.fits[1]
    law: tree.Sentence = ("M + M0 = I_zz φ̇ψ̇ with I_zz = ", tree.Value(inertia.value, inertia.u, scale, "inertia.value"))
    balance = ""
    if m0.u:
        balance = (
            ": the ball shows no imbalance" if tree.agrees(m0.value / m0.u) else ": the ball was not perfectly balanced"
        )
    value = tree.Value(m0.value, m0.u, torque, "residual_torque.value")
    words: tree.Sentence = (
        "The torque is a linear function of φ̇ψ̇. Its residual torque is ",
        value,
        f", which shifts the line but does not change its slope{balance}.",
    )
    if analysis.runs_disagree:
        unsaid = "These runs do not show a linear relation between torque and φ̇ψ̇: they do not agree with one line."
        words = (
            f"{unsaid} If they did, the residual torque would be ",
            value,
            ", and the slope I_zz as above.",
        )
    if origin.inertia is not None and origin.deviation is not None:
        slope = tree.Value(origin.inertia.value, origin.inertia.u, scale, "fits.1.inertia.value")
        away = tree.Number(tree.signed(origin.deviation), "fits.1.deviation")
        words = (*words, " A line without an intercept has the slope ", slope, ", ", away, " u away.")
    figure = tree.Figure("torque", FIGURES["torque"].caption)
    return (tree.Text((law,), "result", True), tree.Text((words,), full=True), figure)


def _meaning(analysis: Analysis, scale: values.Scale) -> Iterator[tree.Block]:
    words = (
        "The slope is the moment of inertia about the rod of everything that spins: ball, rod and weight. A mass "
        "resists a change of its speed; in the same way I_zz resists a change of the spin. The larger I_zz is, the "
        "slower the same torque turns the axis."
    )
    yield tree.Text(((words,),), full=True)
    ball, inertia = analysis.ball, analysis.inertia
    if ball is None:
        lines = (
            tree.Styled("# ball_mass: 4.10 ± 0.01 kg", "code"),
            tree.Styled("# ball_diameter: 10.16 ± 0.01 cm", "code"),
        )
        ask: tree.Sentence = (
            "With the ball's mass and diameter in the log (",
            lines[0],
            ", ",
            lines[1],
            ") gyro compares I_zz with 2/5 m r². Without them gyro cannot detect a wrong unit in a whole column.",
        )
        yield tree.Text((ask,), "small", full=True)
        return
    exact = " (assumed exact: the log gives no uncertainty). " if ball.inertia_u is None else ". "
    whole = tree.Value(ball.inertia, ball.inertia_u, values.inertia_scale(ball.inertia, ball.inertia_u), "ball.inertia")
    described: tree.Sentence = ("The disk that the log describes has ½ m r² = ", whole, exact)
    if ball.mass is not None and ball.diameter is not None:
        parts = (("its bore", ball.bore), ("its rod", ball.rod), ("the disk", ball.disk))
        added = " and ".join(words for words, part in parts if part)
        described = (
            "A ball of ", tree.Value(ball.mass, ball.mass_u, values.mass_scale(ball.mass), "ball.mass"), " and ",
            tree.Value(ball.diameter, ball.diameter_u, values.CENTIMETRE, "ball.diameter"),
            f" has 2/5 m r²{' with ' if added else ''}{added} = ", whole, exact,
        )  # fmt: skip
    yield tree.Text(((*described, *beside(analysis)),), full=True)
    rows: list[tuple[tree.Cell, ...]] = [(("measured",), tree.Value(inertia.value, inertia.u, scale, "inertia.value"))]
    for words, part, key in (
        ("solid ball, 2/5 m r²", ball.solid, "solid"),
        ("its bore, for the same mass", ball.bore, "bore"),
        ("rod, ½ m r²", ball.rod, "rod"),
        ("disk, ½ m r²", ball.disk, "disk"),
    ):
        # One part is all of it, and has its u there.
        if part and part != ball.inertia:
            rows.append(((words,), tree.Value(part, None, scale, f"ball.{key}")))
    between = len(rows) - 1
    all_of_it = "solid ball, 2/5 m r²" if ball.solid == ball.inertia else "all parts in the log"
    rows.append(((all_of_it,), replace(whole, scale=scale)))
    rows.append((("difference",), tree.Value(ball.difference, ball.difference_u, scale, "ball.difference")))
    own = (inertia.value, inertia.u or 0.0)
    dots = (own, *(None for _ in range(between)), (ball.inertia, ball.inertia_u or 0.0), None)
    band = (own[0] - own[1], own[0] + own[1])
    picture = tree.Picture("value", dots, band, "the bars are ± u, the band is that of the measured value")
    heads = (tree.Head("moment of inertia"), tree.Head("value", scale))
    yield tree.Table(
        heads,
        tuple(rows),
        "The measured value, and the value from the dimensions in the log",
        picture,
        main=0,
        full=True,
    )


def beside(analysis: Analysis) -> tree.Sentence:
    """Say if the measured I_zz agrees with the value for the ball or disk."""
    ball = analysis.ball
    assert ball is not None
    body = "ball" if ball.mass is not None else "disk"
    relative = tree.percent(ball.relative, "ball.relative")
    if ball.deviation is None:
        return (
            f"I_zz differs from the value for the {body} by ",
            *relative,
            "; without an uncertainty this cannot be judged.",
        )
    if ball.relative > 1:
        times = tree.Number(f"{ball.relative:.3g}", "ball.relative")
        return (f"I_zz does not agree with the value for the {body}: the difference is ", times,
                f" times the value for the {body}.")  # fmt: skip
    away = tree.Number(tree.signed(ball.deviation), "ball.deviation")
    scale = values.inertia_scale(ball.inertia, None)
    whole = tree.Value(ball.inertia, None, scale, "ball.inertia")
    close = tree.agrees(ball.deviation)
    bore = ""
    if not close and ball.mass is not None and not ball.bore and abs(ball.relative) < BORED:
        bore = (
            " A bore along the rod removes mass near the axis, so a ball of the same mass has a little more than "
            "2/5 m r²; the rod and the weights add to it."
        )
    verdict = "agrees" if close else "does not agree"
    return (
        f"I_zz {verdict} with the value for the {body}, ", whole, ": the difference is ", *relative, " (", away,
        f" u of the difference).{bore}",
    )  # fmt: skip
