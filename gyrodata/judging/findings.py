"""The list of all checks of a log, and of advice for the next one.

A check uses a log and its fit (`JudgedLab`) and returns findings: diagnostics with a code, a
severity, a place, words and a remedy. A finding with a kind of `doubt` means that the
answer is not safe to quote. Terminal, page, `gyro check`, grading and JSON select from
these findings and make none of their own.

One cause has many symptoms: `SILENCED_BY`, at the end, lists for each check the causes
with which it is silent. `gyrodata.analysis` calls `run_checks`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from typing import Any, TypeGuard

import numpy as np
from msgspec.structs import replace

from gyrodata import fitting
from gyrodata.base.errors import Diagnostic
from gyrodata.fitting import Estimate, Outlier
from gyrodata.judging import changes, mistakes
from gyrodata.judging.blocks import DISAGREE, Block, BlockAgreement
from gyrodata.judging.changes import DROP_ONE, Effect, Lab
from gyrodata.judging.corrections import written
from gyrodata.judging.explanations import MESSAGES, ONE_BALANCE, Explanation
from gyrodata.judging.tables import (
    Ball,
    Constancy,
    Exponent,
    load_words,
    outlier_reason,
    scatter_in_u,
)
from gyrodata.measurements.checks import unit_size, unit_within
from gyrodata.measurements.sources import timing_column, values_of
from gyrodata.physics import RPM
from gyrodata.physics.models import MODELS
from gyrodata.readings import Place, Readings, to_display
from gyrodata.readings.lablog import MOST_OF_ONE_CODE, Text, listing

# --- the checks ---


class JudgedLab(Lab, frozen=True, kw_only=True):
    """A log and its fit, with all that the checks need."""

    readings: Readings
    outliers: tuple[Outlier, ...]
    without_outliers: Estimate | None
    """I_zz without any outlier [kg*m^2], if one is kept."""
    explanations: tuple[Explanation, ...]
    """Mistakes with which the runs would agree, the most probable first."""
    constancy: Constancy | None
    """How φ̇ψ̇ scatters within each torque; None if no torque has two runs."""
    blocks: tuple[Block, ...]
    """The days or groups; empty if there is only one."""
    agreement: BlockAgreement | None
    """Whether they have one I_zz."""
    exponent: Exponent | None
    ball: Ball | None
    unusual_sizes: tuple[Diagnostic, ...]
    """Questions about readings, asked before the fit."""

    def say(
        self, name: str, place: Text | Place | None = None, /, **values: Any
    ) -> Diagnostic:
        """Fill in a message about a place of the log."""
        return self.readings.say(name, place, **values)


def _outliers(lab: JudgedLab) -> Iterator[Diagnostic]:
    """Name each outlier."""
    without = lab.without_outliers
    kept = ""
    if without:
        kept = f"; without the suspected outliers I_zz = {without.value:.4g} kg·m²"
    for outlier in lab.outliers[:MOST_OF_ONE_CODE]:
        name = "outlier_kept"
        if outlier.index in lab.left_out:
            name = "outlier_left_out"
        cell = _cell_of(lab.readings, outlier)
        run = lab.measured.runs[outlier.index]
        reason = outlier_reason(lab.measured, outlier)
        yield lab.say(name, cell, run=run, reason=reason, without=kept)
    more = len(lab.outliers) - MOST_OF_ONE_CODE
    if more > 0:
        yield lab.say("more_outliers", count=more)


def _cell_of(readings: Readings, outlier: Outlier) -> Text | None:
    """Return the cell of an outlier that its correction is about, or its time."""
    timing = timing_column(readings.columns)
    # "spin start 420 rpm would fit" is about the column spin_start, "position 15.4 cm
    # would fit" about the position, and "fits 2 turns" about the turns or the angle.
    words = "".join(outlier.cells[:1]).split()
    names = ["_".join(words[:count]) for count in (3, 2, 1)]
    if words[:1] == ["fits"]:
        names = ["turns", "angle"]
    for name in names:
        column = readings.columns.get(name, timing)
        if column is not timing:
            return column.cell(outlier.index) or timing.cell(outlier.index)
    return timing.cell(outlier.index)


CONTRADICTING = 10.0
"""Runs with this many times the stated scatter contradict each other."""

OTHER_LAW = 4.0
"""An exponent at least this many u from 1 means another law; its u includes the
remaining scatter of the runs."""


def _causes_of_scatter(lab: JudgedLab) -> str:
    """Name the runs that were perhaps stopped late."""
    late = lab.fit.late
    if not late:
        return ""
    them = "it" if len(late) == 1 else "them"
    return (
        f"the clock of {lab.measured.run_words(late)} was perhaps stopped late, "
        f"and the answer hardly depends on {them}: repeat {them}; "
    )


MUCH_SCATTER = 2.0
"""With a smaller scatter the weights disagree, and not their runs."""


def _is_balance_change(lab: JudgedLab) -> bool:
    """Return whether a balance that differs between weights explains the scatter."""
    is_change = lab.fit.chance_of_one_balance < ONE_BALANCE
    return is_change and lab.fit.widths.scatter < MUCH_SCATTER


def _contradicts_itself(lab: JudgedLab) -> bool:
    """Return whether the runs scatter so much that other findings mean nothing."""
    return lab.fit.widths.scatter > CONTRADICTING


def _contradiction(lab: JudgedLab) -> Iterator[Diagnostic]:
    """Say that the runs contradict each other."""
    if _contradicts_itself(lab):
        yield lab.say("runs_contradict_each_other", scatter=lab.fit.widths.scatter)


def _scatter(lab: JudgedLab) -> Iterator[Diagnostic]:
    """Say that the runs scatter more than stated."""
    # If there are as many unknowns as runs, the runs can still contradict what is
    # expected of M0.
    if lab.fit.p < fitting.UNLIKELY:
        yield _say_scatter(lab)


def _say_scatter(lab: JudgedLab) -> Diagnostic:
    """Say that the runs scatter more than stated, or are not on one line."""
    measured = lab.measured
    fit = lab.fit
    scatter = fit.widths.scatter
    time_u = measured.time_u
    late = _causes_of_scatter(lab)
    of_time = scatter * (time_u or 0.14)
    values = {"scatter": scatter, "u_time": of_time, "late": late}
    widest = fitting.doubt_of_widths(fitting.times_stated(measured))
    if fitting.chi2_tail(fit.chi2 / widest**2, max(fit.dof, 1)) < fitting.UNLIKELY:
        return lab.say("not_one_line", **values)
    stated = "stated"
    if time_u is not None:
        stated = f"{time_u:.2g} s"
    in_u = scatter_in_u(lab.constancy, measured)
    return lab.say("scatter_too_large", **values, stated=stated, in_u=in_u)


EVEN = 0.5
"""Weights disagree if M0 is more probably different than the same. With two weights, or
with one run of each, the priors of M0 and of the scatter decide too much for that."""

ONE_IN_FIVE = 0.2
"""With a smaller probability of one M0, nobody should rely on the answer: of 150
simulated labs with one M0, 15 have a smaller one than `EVEN`, and 2 than this."""

TELLING = range(4, 13)
"""Numbers of weights that can show which one of them is different; more of them take
too long."""


def _weights_disagree(lab: JudgedLab) -> Iterator[Diagnostic]:
    """Report that M0 differs between weights, and the weight that differs.

    This is a test of lack of fit: the scatter between the weights is compared with that
    within each weight, whose size is uncertain.
    """
    chance = lab.fit.chance_of_one_balance
    limit = EVEN if _can_show_weights(lab) else ONE_BALANCE
    if chance >= limit:
        return
    level = f"{1e3 * lab.fit.widths.level:.2g}"
    values = {"level": "", "u": ""}
    if float(level) > 0:
        by = f", by about {level} mN·m,"
        values = {"level": by, "u": "; u includes this"}
    percent = 100 * (1 - chance)
    which = _odd_weight(lab)
    disagree = lab.say("weights_disagree", percent=percent, which=which, **values)
    # u includes a difference that may be chance.
    yield replace(disagree, doubt="") if chance > ONE_IN_FIVE else disagree


def _can_show_weights(lab: JudgedLab) -> bool:
    """Return whether there are three weights or more, and repeated runs of one."""
    weights = lab.measured.by_weight
    return len(weights) > 2 and max(map(len, weights)) > 1


def _odd_weight(lab: JudgedLab) -> str:
    """Name the weight without which the others have one M0, if it is clear."""
    weights = lab.measured.by_weight
    odd = []
    if len(weights) in TELLING:
        odd = [runs for runs in weights if _chance_without(lab, runs) > ONE_BALANCE]
    if len(odd) != 1:
        return "the runs cannot show which one is different"
    return f"without {load_words(lab.measured, odd[0][0])} the others agree"


def _chance_without(lab: JudgedLab, runs: Sequence[int]) -> float:
    """Compute the probability that the weights of the other runs have one M0."""
    left_out = {*lab.left_out, *runs}
    with suppress(fitting.NoFit):
        fit = fitting.fit(lab.measured, tilted=lab.motion.tilted, left_out=left_out)
        return fit.chance_of_one_balance
    return 0.0


def _blocks_disagree(lab: JudgedLab) -> Iterator[Diagnostic]:
    """Report days or groups that do not have the same I_zz."""
    agreement = lab.agreement
    if agreement is None or agreement.p > DISAGREE:
        return
    values = {
        block.name: f"{1e3 * inertia.value:.4g} ± {1e3 * (inertia.u or 0.0):.2g}"
        for block in lab.blocks
        if (inertia := block.inertia)
    }
    yield lab.say(
        "blocks_disagree",
        names=listing([*values]),
        p=agreement.p,
        values=listing([*values.values()]),
    )


OTHER_MESSAGES = ("runs", "balance")
"""Kinds of explanations that have a message of their own if they are certain."""


def _is_explained(lab: JudgedLab) -> bool:
    """Return whether `_explanations` says why the runs do not agree."""
    kinds = [each.kind for each in lab.explanations]
    return len(kinds) > 1 or bool({*kinds}.difference(OTHER_MESSAGES))


def _is_not_the_balance(lab: JudgedLab) -> bool:
    """Return whether something else than the balance explains the runs."""
    kinds = [each.kind for each in lab.explanations]
    return bool(kinds) and "balance" not in kinds


def _explanations(lab: JudgedLab) -> Iterator[Diagnostic]:
    """Name the mistake with which the runs would agree, or the probable ones."""
    if len(lab.explanations) > 1:
        yield _list_explanations(lab)
    elif _is_explained(lab):
        only = lab.explanations[0]
        name = MESSAGES.get(only.kind, "shared_error")
        yield lab.say(name, words=only.words, remedy=only.remedy)


def _list_explanations(lab: JudgedLab) -> Diagnostic:
    """List several probable mistakes, the most probable first."""
    several = lab.explanations
    listed = "; or ".join(
        f"({number}) {each.words} (I_zz = {each.inertia.value:.4g} kg·m²)"
        for number, each in enumerate(several, start=1)
    )
    of_runs = all(each.kind == "runs" for each in several)
    name = "either_run_wrong" if of_runs else "several_explanations"
    return lab.say(name, listed=listed)


def _deviations(lab: JudgedLab) -> Iterator[Diagnostic]:
    """Report a period that is not in proportion to the spin."""
    fit = lab.fit
    exponent = lab.exponent
    if exponent is None or fit.dof < 2:
        return
    # The period of a tilted or nutating rod is not a power of the spin; then chi-square
    # of the fit decides.
    other_law = lab.motion.tilted or np.any(lab.measured.slowing != 1)
    if other_law and fit.p > fitting.UNLIKELY:
        return
    rest = (fit.chi2 - exponent.deviation**2) / (fit.dof - 1)
    far = exponent.deviation / math.sqrt(max(rest, 1.0))
    if abs(far) > OTHER_LAW:
        yield _say_other_law(lab, exponent, far)


def _say_other_law(lab: JudgedLab, exponent: Exponent, far: float) -> Diagnostic:
    """Report that an exponent is `far` standard uncertainties from 1."""
    cause = "a spin that was not read at half time"
    if far < 0:
        cause = "a stopwatch that is late in every run"
    return lab.say(
        "period_not_in_proportion",
        power=round(exponent.value, 2) + 0.0,
        far=abs(far),
        cause=f"{cause}, or wrong turns in some runs",
    )


TOO_GOOD = 0.003
"""Runs that agree better than stated are reported if this is less probable."""


def _agreement(lab: JudgedLab) -> Iterator[Diagnostic]:
    """Report runs that agree much better than their stated uncertainties allow."""
    fit = lab.fit
    if fit.dof < 2 or not lab.measured.own_relative.all():
        return
    low = max(1 - fitting.chi2_tail(fit.chi2, fit.dof), 0.0)
    if low < TOO_GOOD:
        p = f"p = {low:.1g}" if low > 1e-6 else "p < 1e-6"
        yield lab.say("agreement", statistic=fit.chi2 / fit.dof, p=p)


CONTRADICTED = 3.0
"""Number of standard uncertainties by which the runs must contradict a balance test."""


def _balance(lab: JudgedLab) -> Iterator[Diagnostic]:
    """Report a balance test that the runs contradict.

    Runs that cannot separate M0 from I_zz are reported as well.
    """
    measured = lab.measured
    fit = lab.fit
    if measured.balance_test is not None:
        allowed = measured.balance_test.at(fit.inertia.value)
        _, below, m0, above, _ = fitting.integrate_at(fit, tested=False).quantiles(1)
        if abs(m0) > CONTRADICTED * math.hypot(allowed, (above - below) / 2):
            yield lab.say(
                "balance_test_contradicted",
                m0=1e3 * m0,
                allowed=1e3 * allowed,
                test=measured.balance_test_from,
            )
    if measured.torque_unseen is None and not fitting.torques_differ(measured.torque):
        ways = "" if measured.balanced else BALANCED
        yield lab.say("single_torque", ways=ways)


BALANCED = ', or write "# balanced: yes" or "# balance_drift: 5 deg in 60 s at 400 rpm"'
"""How a log with one torque can say that M0 is small."""


def _direction(lab: JudgedLab) -> Iterator[Diagnostic]:
    """Ask for the direction of the runs without a weight, if this reduces u of I_zz."""
    for _, now, then in changes.gains(lab, "direction"):
        bare = (lab.measured.sense == 0) & (lab.fit.adjusted.kept > 0)
        runs = np.flatnonzero(bare).tolist()
        names = lab.measured.run_words(runs)
        place = lab.readings.place(runs[0])
        yield lab.say("direction_missing", place, runs=names, now=now, then=then)


POOR_BALANCE = 0.2
"""A balanced ball has an M0 below this part of the smallest torque."""

NO_BALANCE = 0.5
"""With an M0 above this part of the smallest torque the answer is not safe to quote."""


def _large_residual_torque(lab: JudgedLab) -> Iterator[Diagnostic]:
    """Report an M0 that is too large for a balanced ball, and its possible causes."""
    # Each day has its own M0.
    m0 = max(lab.fit.balances.tolist(), key=abs)
    u = lab.fit.residual_torque.u or 0.0
    lightest = fitting.lightest_torque(lab.measured, lab.fit.adjusted.kept)
    uncertain = min(2 * u, 2 * lightest)
    is_small = abs(m0) <= max(POOR_BALANCE * lightest, uncertain)
    if lab.measured.balanced is False or is_small:
        return
    share = abs(m0) / lightest
    poor = lab.say(
        "balance_poor", m0=1e3 * m0, percent=100 * share, hanger=_hanger(lab)
    )
    # Wrong masses or arms can look like an M0 that no ball has.
    yield replace(poor, doubt="size") if share > NO_BALANCE else poor


def _hanger(lab: JudgedLab) -> str:
    """Ask about a hanger whose torque is M0, or about other masses on the rod."""
    measured = lab.measured
    arms = measured.position[measured.torque != 0]
    missing = 1e3 * lab.fit.residual_torque.value / (measured.g * arms[0])
    if missing > 0 and not np.ptp(arms):
        return (
            f"if a hanger of {missing:.2g} g is missing from the masses, "
            "add it to each; "
        )
    return "add to the masses what else hung on the rod, such as a clip; "


def _falling_mass(lab: JudgedLab) -> Iterator[Diagnostic]:
    """Report I_zz from a mass that falls on a thread, and turns the ball."""
    if not lab.readings.falling_mass:
        return
    mass, radius, height, time, friction = lab.readings.falling_mass
    inertia = lab.fit.inertia
    # The thread pulls with m (g − a), less the friction.
    pull = (mass - friction) * lab.measured.g
    measured_inertia = radius**2 * (pull * time**2 / (2 * height) - mass)
    off = 100 * (measured_inertia / inertia.value - 1)
    u = 100 * lab.relative_u
    yield lab.say("falling_mass", inertia=measured_inertia, off=off, u=u)


def _digits(lab: JudgedLab) -> Iterator[Diagnostic]:
    """Report each column with which one more digit would make u(I_zz) much smaller.

    Show a number of it with enough digits.
    """
    for role, now, then in changes.gains(lab, "one_more_digit", MUCH_BETTER):
        column = lab.readings.columns[role]
        size = np.abs(values_of(column))
        size[[run for run, _ in column.stated]] = 0.0
        run = int(np.where(size > 0, size, np.inf).argmin())
        # A position may count from the surface of the ball: the number is as it was
        # typed.
        value = float(written(column, run).replace(",", "."))
        step = column.steps[run] / unit_size(column)
        high = value + step / 2
        digits = max(0, 1 - round(math.log10(step)))
        half, unit = to_display(column.steps[run] / 20, role)
        yield lab.say(
            "digits_too_few",
            column.cell(run),
            role=role,
            text=column.readings[run].text,
            low=value - step / 2,
            high=f"{high:.4g} {column.unit}".rstrip(),
            example=f"{value:.{digits}f}",
            u=half,
            unit=unit,
            now=now,
            then=then,
        )


MUCH_BETTER = 0.88
"""One more digit is worth writing if it reduces u of I_zz to this part of its value:
the rounding is then a quarter of u²."""


def _unused_effects(lab: JudgedLab) -> Iterator[Diagnostic]:
    """Report effects of a silent log that are too large to be left out, but are."""
    for effect, (_, name) in _effects_of_silence(lab):
        if not effect.kept and (effect.size or 0.0) > DROP_ONE:
            yield _say_effect(lab, effect, name)


def _assumed_effects(lab: JudgedLab) -> Iterator[Diagnostic]:
    """Report effects of a silent log that the fit assumes."""
    for effect, (name, _) in _effects_of_silence(lab):
        if effect.kept:
            yield _say_effect(lab, effect, name)


def _effects_of_silence(lab: JudgedLab) -> Iterator[tuple[Effect, tuple[str, str]]]:
    """List what the log does not say of the motion, with the names of two messages.

    They are for an effect that is assumed, and for one that is not used.
    """
    # The tachometer belongs to no model.
    messages = {"tachometer": ("", "tachometer_not_told")}
    for model in MODELS:
        if model.messages and model.is_silent(lab.timed_runs) and not lab.asked:
            messages[model.effect] = model.messages
    for effect in lab.effects:
        if effect.bias and effect.effect in messages:
            yield effect, messages[effect.effect]


def _say_effect(lab: JudgedLab, effect: Effect, name: str) -> Diagnostic:
    """Report an effect, and how much it changes I_zz; `name` is that of the message."""
    bias = effect.bias or 0.0
    direction = "high" if bias > 0 else "low"
    return lab.say(name, off=100 * abs(bias), direction=direction)


NO_MOTOR = 0.7
"""A rotor with less angular momentum than this has no motor: published ones with a
motor have 1 to 2 [kg*m^2/s]."""

LONG_TURN = 600.0
SHORT_ARM = 0.05
LONG_LEVER = 10.0
NEARLY_AS_FAST = 0.15
"""Bounds of the time of a turn with a weight [s], the arm [m], m x²/I_zz [1], and
precession over spin [1]."""

LONGEST_ARM = 0.6
"""An arm is usually shorter [m]."""

USUAL = {
    "spin": (60 * RPM, 2000 * RPM),
    "time": (1.0, LONG_TURN),
    "position": (SHORT_ARM, LONGEST_ARM),
}
"""Range of the readings of a ball that is spun by hand, with a margin [SI unit]."""


def _unusual(lab: JudgedLab) -> Iterator[Diagnostic]:
    """Ask about columns that are possible but not usual, one question for each column.

    All published logs are within the bounds.
    """
    measured = lab.measured
    loaded = measured.torque != 0
    spin = measured.spin[loaded]
    rate = np.abs(measured.product[loaded]) / spin
    turn = fitting.median(2 * np.pi / rate)
    arm = float(np.abs(measured.position[loaded]).max())
    # These do not depend on the unit of the spin, or of the mass: L = M/φ̇, and m
    # x²/I_zz = x φ̇ψ̇/g.
    momentum = fitting.median(np.abs(measured.torque[loaded]) / rate)
    lever = arm * fitting.median(rate * spin) / measured.g
    fastest = float(spin.max())
    by_hand = fastest > 1.2 * spin.min() and momentum < NO_MOTOR
    if fastest < 80 * RPM or (by_hand and fastest > 1800 * RPM):
        yield _ask(lab, "spin_not_usual", "spin", fastest / RPM)
    elif lever > LONG_LEVER and arm < LONGEST_ARM:
        yield _ask(lab, "weight_too_large", "spin", lever)
    if turn > LONG_TURN:
        yield _ask(lab, "turn_not_usual", "time", turn / 60)
    elif (rate / spin).min() > NEARLY_AS_FAST:
        yield _ask(lab, "turn_too_fast", "time", turn)
    if arm < SHORT_ARM:
        yield _ask(lab, "arm_not_usual", "position", 100 * arm)


def _ask(lab: JudgedLab, name: str, role: str, value: float) -> Diagnostic:
    """Ask about the readings of a column, and propose another unit.

    `name` is that of the message.
    """
    column = lab.readings.columns.get(role)
    if column is None:
        return lab.say(name, value=value, hint="")
    first = int(np.flatnonzero(lab.measured.torque)[0])
    place = column.place(first)
    unit = unit_within(lab.readings, role, USUAL[role])
    if not unit:
        return lab.say(name, place, value=value, hint="")
    header = f"{role} [{unit}]"
    hint = f'if it is in {unit}, write the header as "{header}"; '
    asked = lab.say(name, place, value=value, hint=hint)
    # If another unit makes the column usual, the answer is not safe to quote.
    return replace(asked, doubt="size")


INERTIA_RANGE = (1e-6, 1.0)
"""Range of I_zz of a body that is spun on a table [kg*m^2]."""

FAR_BELOW_BALL = -0.05
FAR_ABOVE_BALL = 0.1
FAR_IN_U = 5.0
"""A difference from the ball outside these limits [1], over this many u, needs a cause;
a bore increases I_zz."""


DIFFERS = 2.0
"""A difference from a well known ball of more than this many standard uncertainties is
reported."""

ARM_BY = (0.001, 0.02)
"""Smallest and largest error of an arm [m] that is proposed as a cause: the size of a
weight."""


def _well_known(ball: Ball, inertia: Estimate) -> bool:
    """Return whether the ball is better known than the runs measure."""
    return ball.mass is not None and (ball.inertia_u or 0.0) < 0.5 * (inertia.u or 0.0)


def _causes_of_difference(lab: JudgedLab, ball: Ball) -> str:
    """List the causes that make I_zz larger or smaller than the value for the ball."""
    measured = lab.measured
    is_high = ball.relative > 0
    causes = []
    if is_high and not ball.bore:
        causes.append(
            "a bore along the rod, or a rod or a disk that the log does not describe"
        )
    arms = np.abs(measured.position[measured.torque != 0])
    by = abs(ball.relative) * float(np.mean(arms))
    if ARM_BY[0] < by < ARM_BY[1]:
        edge, side = ("far", "long") if is_high else ("near", "short")
        causes.append(
            f"positions {1e3 * by:.1f} mm too {side}: measure from the centre "
            f"of the ball to the middle of the weight, not to its {edge} edge"
        )
    if is_high and measured.delay_factor is not None and measured.drag is None:
        causes.append(
            "a spin that falls fast and was read late: "
            'add "# spin_down: 612 rpm to 540 rpm in 120 s"'
        )
    return "".join([f"{cause}; " for cause in causes])


def _ball_differs(lab: JudgedLab) -> Iterator[Diagnostic]:
    """Report an I_zz that is near the value for a well known ball, but differs from it.

    The value for the ball is not within the uncertainty.
    """
    ball = lab.ball
    if ball is None or not _well_known(ball, lab.fit.inertia):
        return
    deviation = ball.deviation or 0.0
    if abs(deviation) < DIFFERS:
        return
    side = "above" if deviation > 0 else "below"
    percent = 100 * abs(ball.relative)
    sizes = {"percent": percent, "expected": ball.inertia, "far": abs(deviation)}
    causes = _causes_of_difference(lab, ball)
    yield lab.say("ball_differs", **sizes, side=side, causes=causes)


def _ball_disagrees(lab: JudgedLab, ball: Ball) -> Diagnostic:
    """Report an I_zz that is far from the value for the ball or disk.

    The report also names the mistakes that explain this I_zz.
    """
    value = abs(lab.fit.inertia.value)
    body = "the ball" if ball.mass is not None else "the disk"
    ratio = value / ball.inertia
    part = f"{ratio:.3g} times"
    if not ratio > 0.5:
        part = f"1/{1 / ratio:.3g} of"
    slips = mistakes.explaining_mistakes(
        lab.readings, lab.measured, value, ball.inertia
    )
    without = [f"{after:.4g} if {kind.log}" for kind, after in slips]
    cause = "it would be " + "; or ".join(without)
    hint = "; or else: ".join([kind.remedy for kind, _ in slips])
    if not slips:
        cause = "no common mistake explains this"
        causes = _causes_of_difference(lab, ball)
        hint = f"look for a cause in this order: {causes}a wrong unit"
    sizes = {"inertia": value, "ratio": part, "body": body, "expected": ball.inertia}
    return lab.say("ball_disagrees", **sizes, cause=cause, hint=hint)


def _body(lab: JudgedLab) -> Iterator[Diagnostic]:
    """Report an I_zz that is impossible for the ball or disk, or in this lab."""
    ball = lab.ball
    if _is_far(ball):
        yield _ball_disagrees(lab, ball)
    elif _is_unusual(lab):
        low, high = INERTIA_RANGE
        value = abs(lab.fit.inertia.value)
        yield lab.say("inertia_unusual", inertia=value, low=low, high=high)


def _is_far(ball: Ball | None) -> TypeGuard[Ball]:
    """Return whether I_zz is impossible for a ball, and not only by its uncertainty."""
    if ball is None or FAR_BELOW_BALL <= ball.relative <= FAR_ABOVE_BALL:
        return False
    return abs(ball.deviation or math.inf) > FAR_IN_U


def _is_unusual(lab: JudgedLab) -> bool:
    """Return whether no lab with an air bearing has such an I_zz."""
    low, high = INERTIA_RANGE
    return not lab.unusual_sizes and not low <= abs(lab.fit.inertia.value) <= high


def _is_odd_body(lab: JudgedLab) -> bool:
    """Return whether I_zz is impossible, so that `_body` reports it."""
    return _is_far(lab.ball) or _is_unusual(lab)


def _is_known_body(lab: JudgedLab) -> bool:
    """Return whether I_zz itself can be compared with that of a ball or disk."""
    has_ball = lab.readings.constants.get("ball_mass") is not None
    return has_ball or (lab.ball is not None and not _contradicts_itself(lab))


def _has_odd_sizes(lab: JudgedLab) -> bool:
    """Return whether a question about sizes was asked before the fit."""
    return bool(lab.unusual_sizes)


Check = Callable[[JudgedLab], Iterable[Diagnostic]]

CHECKS: tuple[Check, ...] = (
    _outliers,
    _contradiction,
    _scatter,
    _weights_disagree,
    _blocks_disagree,
    _balance,
    _explanations,
    _deviations,
    _agreement,
    _large_residual_torque,
    _falling_mass,
    _direction,
    _digits,
    _unused_effects,
    _assumed_effects,
    _body,
    _ball_differs,
    _unusual,
)
"""Every check of a log that has been fitted, in the order in which the findings are
shown."""

NOT_OF_FIT = (_deviations, _ball_differs, _unusual)

OF_FIT = tuple([check for check in CHECKS if check not in NOT_OF_FIT])
"""The checks that a grade shows: not those of the law of the period, of a small
difference from the ball, and of columns that are possible but not usual."""

Cause = Callable[[JudgedLab], bool]

SILENCED_BY: Mapping[Check, tuple[Cause, ...]] = {
    _outliers: (_is_explained,),
    _scatter: (_contradicts_itself, _is_explained, _is_balance_change),
    _weights_disagree: (_contradicts_itself, _is_not_the_balance),
    _blocks_disagree: (_contradicts_itself,),
    _deviations: (_contradicts_itself, _is_explained),
    _large_residual_torque: (_contradicts_itself,),
    _unused_effects: (_contradicts_itself,),
    _ball_differs: (_contradicts_itself, _is_odd_body),
    _unusual: (_is_known_body, _is_odd_body, _has_odd_sizes),
}
"""The causes with which a check is silent, because another finding is about them."""


def run_checks(lab: JudgedLab, checks: Iterable[Check]) -> list[Diagnostic]:
    """List the findings of some checks, without those that a cause silences."""
    findings: list[Diagnostic] = []
    for check in checks:
        causes = SILENCED_BY.get(check, ())
        if not any(cause(lab) for cause in causes):
            findings += check(lab)
    return findings
