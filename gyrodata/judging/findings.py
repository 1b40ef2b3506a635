"""The list of all checks of a log, and of advice for the next one.

A check uses a log and its fit (`Seen`) and returns findings: diagnostics with a code, a
severity, a place, words and a remedy. A finding with a kind of `doubt` means that the
answer is not safe to quote. Terminal, page, `gyro check`, grading and JSON select from
these findings and make none of their own.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from itertools import chain
from typing import Any, NamedTuple

import numpy as np
from msgspec.structs import replace

from gyrodata import fitting
from gyrodata.base.errors import Diagnostic
from gyrodata.fitting import Estimate, Outlier, relative_u
from gyrodata.judging import changes, mistakes
from gyrodata.judging.blocks import DISAGREE, Block, BlockAgreement
from gyrodata.judging.changes import DROP_ONE, Effect, Lab
from gyrodata.judging.corrections import timing_role
from gyrodata.judging.explanations import ONE_BALANCE, Explanation
from gyrodata.judging.tables import (
    Ball,
    Constancy,
    Exponent,
    load_words,
    outlier_reason,
    scatter_in_u,
)
from gyrodata.measurements import BALANCE_CHANGE, Measurements, Source, spin_columns
from gyrodata.measurements.checks import unit_within
from gyrodata.measurements.sources import Drag
from gyrodata.physics import RPM, Floats, models
from gyrodata.physics.models import MODELS, MotionModel
from gyrodata.quantities.numerals import take_apart
from gyrodata.quantities.units import from_si, parse_unit
from gyrodata.readings import Column, Readings, kind_of_role, to_display
from gyrodata.readings.lablog import MOST_OF_ONE_CODE, Text, listing

# --- the checks ---


class Seen(Lab, frozen=True, kw_only=True):
    """A log and its fit, with all that the checks need."""

    readings: Readings
    outliers: tuple[Outlier, ...]
    without_outliers: Estimate | None
    """I_zz without any outlier [kg*m^2], if one is kept."""
    explanations: tuple[Explanation, ...]
    """Mistakes with which the runs would agree, the most probable first."""
    p: float | None
    """Probability of a larger chi-square; None without degrees of freedom."""
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

    @property
    def contradicts_itself(self) -> bool:
        """Whether the runs scatter so much that other findings mean nothing."""
        return self.fit.widths.scatter > CONTRADICTING


def _outliers(seen: Seen) -> Iterator[Diagnostic]:
    """Name each outlier, unless an explanation says more."""
    if seen.outliers and not _is_explained(seen):
        yield from _say_outliers(seen)


def _say_outliers(seen: Seen) -> Iterator[Diagnostic]:
    """Say for each outlier what was done with it, and what it does to the answer."""
    readings = seen.readings
    without = seen.without_outliers
    kept = ""
    if without:
        kept = f"; without the suspected outliers I_zz = {without.value:.4g} kg·m²"
    for outlier in seen.outliers[:MOST_OF_ONE_CODE]:
        is_out = outlier.index in seen.left_out
        yield readings.say(
            "outlier_left_out" if is_out else "outlier_kept",
            _cell_of(readings, outlier),
            run=seen.measured.runs[outlier.index],
            reason=outlier_reason(seen.measured, outlier),
            without=kept,
        )
    more = len(seen.outliers) - MOST_OF_ONE_CODE
    if more > 0:
        yield readings.say("more_outliers", count=more)


def _cell_of(readings: Readings, outlier: Outlier) -> Text | None:
    """Return the cell of an outlier that its correction is about, or its time."""
    timing = readings.columns[timing_role(readings)]
    # "position 15.4 cm would fit" is about the position.
    first_word = "".join(outlier.cells[:1]).partition(" ")[0]
    about = readings.columns.get(first_word.replace("fits", "turns"), timing)
    return about.cell(outlier.index) or timing.cell(outlier.index)


CONTRADICTING = 10.0
"""Runs with this many times the stated scatter contradict each other."""

OTHER_LAW = 4.0
"""An exponent at least this many u from 1 means another law; its u includes the
remaining scatter of the runs."""

EXPLAINED = 0.01
"""Another motion explains the scatter if chi-square is more probable than this with it.
"""

NO_ACCIDENT = 0.001
"""If the scatter of the runs has a smaller probability, they do not follow the law
within their uncertainties."""


def _other_motion(seen: Seen) -> str:
    """Return the beginning of a hint about another motion of the rod.

    The result is "" unless this motion explains how the runs deviate.
    """
    measured = seen.measured
    motion = seen.motion
    if seen.p is None or seen.p > NO_ACCIDENT or seen.asked:
        return ""
    for model in models.starts():
        if measured.motion == model.start:
            continue
        with suppress(fitting.NoFit):
            other = motion.started_as(model)
            _, fit = fitting.fit_model(
                measured, other, seen.left_out, fitting.AS_STATED
            )
            p = fitting.chi2_tail(fit.chi2, fit.dof)
            if p > EXPLAINED:
                return (
                    f"if the rod {model.start_words}, the runs agree (p = {p:.1g}): "
                    f'write "# motion: {model.start}". If not, '
                )
    return ""


def _causes_of_scatter(seen: Seen) -> str:
    """Name the runs that were perhaps stopped late, or another motion of the rod."""
    if not seen.fit.late:
        return _other_motion(seen)
    names = [seen.measured.runs[run] for run in seen.fit.late]
    runs = f"run{'s' * (len(names) > 1)} {listing(names)}"
    return (
        f"the clock of {runs} was perhaps stopped late, and the answer hardly depends on "
        f"them: repeat them; "
    )


MUCH_SCATTER = 2.0
"""With a smaller scatter the weights disagree, and not their runs."""


def _is_balance_change(seen: Seen) -> bool:
    """Return whether a balance that differs between weights explains the scatter."""
    is_change = seen.fit.chance_of_one_balance < ONE_BALANCE
    return is_change and seen.fit.widths.scatter < MUCH_SCATTER


def _scatter(seen: Seen) -> Iterator[Diagnostic]:
    """Say that the runs scatter more than stated, or contradict each other."""
    fit = seen.fit
    if seen.contradicts_itself:
        factor = fit.widths.scatter
        yield seen.readings.say("runs_contradict_each_other", scatter=factor)
        return
    # If there are as many unknowns as runs, the runs can still contradict what is
    # expected of M0.
    p = seen.p or fitting.chi2_tail(fit.chi2, max(fit.dof, 1))
    if p < NO_ACCIDENT and not (_is_balance_change(seen) or _is_explained(seen)):
        yield _say_scatter(seen)


def _say_scatter(seen: Seen) -> Diagnostic:
    """Say that the runs scatter more than stated, or are not on one line."""
    measured = seen.measured
    fit = seen.fit
    scatter = fit.widths.scatter
    values = {"scatter": scatter, "u_time": scatter * (measured.time_u or 0.14)}
    motion = _causes_of_scatter(seen)
    widest = fitting.doubt_of_widths(fitting.times_stated(measured))
    if fitting.chi2_tail(fit.chi2 / widest**2, max(fit.dof, 1)) < NO_ACCIDENT:
        return seen.readings.say("not_one_line", **values, motion=motion)
    return seen.readings.say(
        "scatter_too_large",
        **values,
        stated=_stated_scatter(measured),
        in_u=scatter_in_u(seen.constancy, measured),
        motion=motion,
    )


def _stated_scatter(measured: Measurements) -> str:
    """Return the stated uncertainty of every time, or "stated" if the times differ."""
    times = [source for source in measured.sources if source.quantity == "time"]
    if not times or times[0].relative.any() or np.ptp(times[0].absolute):
        return "stated"
    return f"{float(times[0].absolute[0]):.2g} s"


TELLING = 4
"""Smallest number of weights that can show which one of them is different."""


def _weights_disagree(seen: Seen) -> Iterator[Diagnostic]:
    """Report that M0 differs between weights, and the weight that differs.

    This is a test of lack of fit: the scatter between the weights is compared with that
    within each weight, whose size is uncertain.
    """
    chance = seen.fit.chance_of_one_balance
    kinds = [each.kind for each in seen.explanations]
    if (
        seen.contradicts_itself
        or chance >= ONE_BALANCE
        or kinds not in ([], ["balance"])
    ):
        return
    yield seen.readings.say(
        "weights_disagree",
        percent=100 * (1 - chance),
        level=1e3 * seen.fit.widths.level,
        which=_odd_weight(seen),
    )


def _odd_weight(seen: Seen) -> str:
    """Name the weight whose M0 differs most, if the log has enough weights for it."""
    weights = [
        runs for runs in seen.measured.by_weight if seen.measured.torque[runs[0]]
    ]
    if len(weights) < TELLING:
        return "so few weights cannot show which one is different"
    run = int(np.abs(seen.fit.error_of(BALANCE_CHANGE)).argmax())
    return f"M0 differs most with {load_words(seen.measured, run)}"


def _blocks_disagree(seen: Seen) -> Iterator[Diagnostic]:
    """Report days or groups that do not have the same I_zz."""
    agreement = seen.agreement
    if seen.contradicts_itself or agreement is None or agreement.p > DISAGREE:
        return
    alone = [block for block in seen.blocks if block.inertia]
    values = [
        f"{1e3 * block.inertia.value:.4g} ± {1e3 * (block.inertia.u or 0.0):.2g}"
        for block in alone
        if block.inertia
    ]
    names = listing([block.name for block in seen.blocks])
    yield seen.readings.say(
        "blocks_disagree", names=names, p=agreement.p, values=listing(values)
    )


OTHER_MESSAGES = ("runs", "balance")
"""Kinds of explanations that have a message of their own if they are certain."""


def _is_explained(seen: Seen) -> bool:
    """Return whether `_explanations` says why the runs do not agree."""
    several = seen.explanations
    is_certain = len(several) == 1 and several[0].kind not in OTHER_MESSAGES
    return is_certain or len(several) > 1


def _explanations(seen: Seen) -> Iterator[Diagnostic]:
    """Name the mistake with which the runs would agree, or the probable ones."""
    if not _is_explained(seen):
        return
    if len(seen.explanations) > 1:
        yield _list_explanations(seen)
        return
    only = seen.explanations[0]
    name = "weight_wrong" if only.kind == "weight" else "shared_error"
    yield seen.readings.say(name, words=only.words, remedy=only.remedy)


def _list_explanations(seen: Seen) -> Diagnostic:
    """List several probable mistakes, the most probable first."""
    several = seen.explanations
    listed = "; or ".join(
        f"({number}) {each.words} (I_zz = {each.inertia.value:.4g} kg·m²)"
        for number, each in enumerate(several, start=1)
    )
    of_runs = all(each.kind == "runs" for each in several)
    name = "either_run_wrong" if of_runs else "several_explanations"
    return seen.readings.say(name, listed=listed)


def _deviations(seen: Seen) -> Iterator[Diagnostic]:
    """Report a period that is not in proportion to the spin."""
    fit = seen.fit
    exponent = seen.exponent
    if seen.contradicts_itself or _is_explained(seen):
        return
    if exponent is None or fit.dof < 2:
        return
    # The period of a tilted or nutating rod is not a power of the spin; then chi-square
    # of the fit decides.
    other_law = fit.adjusted.problem.tilted or seen.measured.slowing is not None
    if other_law and (seen.p or 0.0) > NO_ACCIDENT:
        return
    rest = (fit.chi2 - exponent.deviation**2) / (fit.dof - 1)
    far = exponent.deviation / math.sqrt(max(rest, 1.0))
    if abs(far) > OTHER_LAW:
        yield _say_other_law(seen, exponent, far)


def _say_other_law(seen: Seen, exponent: Exponent, far: float) -> Diagnostic:
    """Report that an exponent is `far` standard uncertainties from 1."""
    cause = "a spin that was not read at the midpoint of the run, or wrong turns in the long runs"
    if far < 0:
        cause = (
            "a stopwatch that is late in every run, or wrong turns in the short runs"
        )
    return seen.readings.say(
        "period_not_in_proportion",
        power=round(exponent.value, 2) + 0.0,
        far=abs(far),
        cause=cause,
        motion=_other_motion(seen),
    )


TOO_GOOD = 0.003
"""Runs that agree better than stated are reported if this is less probable."""


def _agreement(seen: Seen) -> Iterator[Diagnostic]:
    """Report runs that agree much better than their stated uncertainties allow."""
    fit = seen.fit
    if fit.dof < 2 or not seen.measured.own_relative.all():
        return
    low = max(1 - fitting.chi2_tail(fit.chi2, fit.dof), 0.0)
    if low < TOO_GOOD:
        p = f"p = {low:.1g}" if low > 1e-6 else "p < 1e-6"
        yield seen.readings.say("agreement", statistic=fit.chi2 / fit.dof, p=p)


def _balance(seen: Seen) -> Iterator[Diagnostic]:
    """Report a balance test that the runs contradict.

    Runs that cannot separate M0 from I_zz are reported as well.
    """
    measured = seen.measured
    fit = seen.fit
    test = seen.measured.balance_test_from
    if fit.contradicted_balance is not None:
        m0 = 1e3 * fit.residual_torque.value
        allowed = 1e3 * fit.contradicted_balance
        yield seen.readings.say(
            "balance_test_contradicted", m0=m0, allowed=allowed, test=test
        )
    if measured.torque_unseen is None and not fitting.torques_differ(measured.torque):
        ways = "" if measured.balanced else BALANCED
        yield seen.readings.say("single_torque", ways=ways)


BALANCED = ', or write "# balanced: yes" or "# balance_drift: 5 deg in 60 s at 400 rpm"'
"""How a log with one torque can say that M0 is small."""


WORTH = 0.95
"""gyro advises a change only if it reduces u of I_zz to at most this part of its value.
"""


def _direction(seen: Seen) -> Iterator[Diagnostic]:
    """Name the runs that have neither a weight nor a direction."""
    is_bare = (seen.measured.sense == 0) & (seen.fit.adjusted.kept > 0)
    if is_bare.any():
        yield from _missing_direction(seen, np.flatnonzero(is_bare).tolist())


def _missing_direction(seen: Seen, bare: list[int]) -> Iterator[Diagnostic]:
    """Ask for the direction of some runs if it would reduce u of I_zz."""
    measured = seen.measured
    now = seen.fit.inertia
    answers = changes.answers(seen, "direction")
    then = answers[0][1].inertia if answers else None
    if then is None or (then.u or 0.0) > WORTH * (now.u or 0.0):
        return
    runs = f"run{'s' * (len(bare) > 1)} {', '.join(measured.runs[i] for i in bare)}"
    place = seen.readings.place(bare[0])
    u = {"now": 100 * relative_u(now), "then": 100 * relative_u(then)}
    yield seen.readings.say("direction_missing", place, runs=runs, **u)


POOR_BALANCE = 0.2
"""A balanced ball has an M0 below this part of the smallest torque."""

FELL_MORE = 4.0
"""If a spin falls this many times as fast as in the middle run …"""

FELL_BY = 0.03
"""… and by this much more [1], then something rubbed, or the spin was read wrongly."""


def _poor_balance(seen: Seen) -> str:
    """Describe an M0 that is too large for a balanced ball; otherwise return ""."""
    m0 = seen.fit.residual_torque
    lightest = fitting.lightest_torque(seen.measured, seen.fit.adjusted.kept)
    uncertain = min(2 * (m0.u or 0.0), 2 * lightest)
    is_small = abs(m0.value) <= max(POOR_BALANCE * lightest, uncertain)
    if seen.measured.balanced is False or is_small:
        return ""
    share = f"{100 * abs(m0.value) / lightest:.0f} % of the lightest torque"
    return f"M0 = {1e3 * m0.value:.2g} mN·m is {share}, too large for a balanced ball"


def _large_residual_torque(seen: Seen) -> Iterator[Diagnostic]:
    """Report an M0 that is too large for a balanced ball, and its possible causes."""
    poor = _poor_balance(seen)
    if poor and not seen.contradicts_itself:
        yield seen.readings.say("balance_poor", poor=poor, hanger=_hanger(seen))


def _hanger(seen: Seen) -> str:
    """Ask about a hanger whose torque is M0, or about other masses on the rod."""
    measured = seen.measured
    arms = np.unique(measured.position[measured.torque != 0]).tolist()
    missing = seen.fit.residual_torque.value / (measured.g * arms[0])
    if len(arms) == 1 and missing > 0:
        grams = f"{1e3 * missing:.2g} g"
        return f"if a hanger of {grams} is missing from the masses, add it to each; "
    return "add to the masses what else hung on the rod, such as a clip; "


def _falling_spin(seen: Seen) -> Iterator[Diagnostic]:
    """Report a spin that fell alone, and whether friction is negligible."""
    has_ends = seen.measured.spin_start is not None
    if has_ends and len(seen.measured.runs) >= 4:
        yield from _spins_that_fell_alone(seen)
    if seen.measured.drag is not None and seen.readings.spin_down:
        yield _friction(seen, seen.measured.drag)


def _spins_that_fell_alone(seen: Seen) -> Iterator[Diagnostic]:
    """Name the runs in which the spin fell much faster than in the middle run.

    If more than a quarter of the runs would be named, none is.
    """
    measured = seen.measured
    assert measured.spin_start is not None
    assert measured.spin_end is not None
    fall = np.log(measured.spin_start / measured.spin_end)
    usual = max(float(np.sort(fall / measured.time)[len(fall) // 2]), 0.0)
    share = usual * measured.time
    is_far = (fall > FELL_MORE * share) & (fall - share > FELL_BY)
    far = np.flatnonzero(is_far).tolist()
    if len(far) > len(fall) / 4:
        return
    for run in far:
        yield seen.readings.say(
            "spin_fell_alone",
            spin_columns(seen.readings)[-1].place(run),
            run=measured.runs[run],
            percent=-100 * np.expm1(-fall[run]),
            more=FELL_MORE,
        )


def _friction(seen: Seen, drag: Drag) -> Diagnostic:
    """Report the torque of friction, and whether it is negligible."""
    measured = seen.measured
    inertia = seen.fit.inertia
    longest = int(np.argmax(measured.time))
    lost = float(drag.at(measured.spin)[longest]) * float(measured.time[longest])
    size = lost**2 / 24
    hint = "friction is not negligible: read the spin at start and end too"
    if size < DROP_ONE * relative_u(inertia):
        hint = "friction is negligible here"
    return seen.readings.say(
        "spin_falls",
        time=1 / drag.rate,
        spin=drag.spin / RPM,
        torque=1e3 * inertia.value * drag.rate * drag.spin,
        percent=100 * lost,
        size=100 * size,
        hint=hint,
    )


def _other_measurements(seen: Seen) -> Iterator[Diagnostic]:
    """Report I_zz from a falling mass, and I over I_zz from the nutation."""
    if seen.readings.falling_mass:
        yield _of_falling_mass(seen, seen.readings.falling_mass)
    ratio = seen.measured.nutation_ratio
    if ratio is not None:
        yield seen.readings.say("nutation", ratio=float(np.nanmedian(ratio)))


def _of_falling_mass(seen: Seen, falling: Sequence[float]) -> Diagnostic:
    """Report I_zz from a mass that falls on a thread, and turns the ball."""
    mass, radius, height, time, friction = falling
    inertia = seen.fit.inertia
    # The thread pulls with m (g − a), less the friction.
    pull = (mass - friction) * seen.measured.g
    found = radius**2 * (pull * time**2 / (2 * height) - mass)
    off = 100 * (found / inertia.value - 1)
    u = 100 * relative_u(inertia)
    return seen.readings.say("falling_mass", inertia=found, off=off, u=u)


MOST_ROUNDING = 0.5
"""If the rounding of one column makes so much of u(I_zz), a quarter of u², one more
digit is worth writing."""


def _digits(seen: Seen) -> Iterator[Diagnostic]:
    """Report each column whose rounding makes a large part of u(I_zz)."""
    u = seen.fit.inertia.u or 1.0
    parts = {share.source: share.u_inertia / u for share in seen.fit.budget}
    for source in seen.measured.sources:
        is_read = source.name in ROUNDED and source.name in seen.readings.columns
        part = parts.get(source.name, 0.0)
        # The rounding is only a part of the error of a reading.
        if is_read and source.default and part >= MOST_ROUNDING:
            shares = _shares_of_rounding(seen, source)
            rounding = math.sqrt(np.mean(shares[source.groups >= 0] ** 2)) * part
            if rounding >= MOST_ROUNDING:
                yield _say_too_few_digits(seen, source, shares, rounding)


ROUNDED = ("mass", "position", "time", "spin")
"""Columns whose digits are compared with u(I_zz)."""


def _shares_of_rounding(seen: Seen, source: Source) -> Floats:
    """Return the share of the rounding in the error of each reading [1], shape (n,).

    It is zero for readings that are stated as exact, or that have no error.
    """
    column = seen.readings.columns[source.name]
    values = np.abs(getattr(seen.measured, source.name))
    size = source.absolute + source.relative * values
    steps = np.array(column.steps) / math.sqrt(12)
    steps[[run for run, _ in column.stated]] = 0.0
    is_known = (source.groups >= 0) & (size > 0)
    shares: Floats = np.zeros_like(size)
    np.divide(steps, size, out=shares, where=is_known)
    return shares


def _say_too_few_digits(
    seen: Seen, source: Source, shares: Floats, rounding: float
) -> Diagnostic:
    """Report a column with too few digits, and u with one more digit.

    `rounding`: what the rounding makes of u(I_zz) [1].
    """
    column = seen.readings.columns[source.name]
    run = int(np.argmax(shares))
    now = 100 * relative_u(seen.fit.inertia)
    return seen.readings.say(
        "digits_too_few",
        column.cell(run),
        **_one_more_digit(seen.readings, column, run),
        percent=100 * rounding**2,
        now=now,
        # A step of a tenth has a hundredth of the variance.
        then=now * math.sqrt(max(1 - 0.99 * rounding**2, 0.01)),
    )


def _one_more_digit(readings: Readings, column: Column, run: int) -> dict[str, Any]:
    """Return the words about a reading with too few digits, and an example to type."""
    kind = kind_of_role(column.role)
    reading = column.readings[run]
    value = from_si(reading.value or 0.0, column.unit, kind)
    step = from_si(reading.step or 0.0, column.unit, kind)
    if column.role == "position":
        typed = take_apart(reading.text)
        # The number that was typed may count from the surface of the ball.
        value = typed.value if typed and not typed.unit else value
    # One digit more, and at least as many as give a step of 1 %.
    fewest = math.ceil(2 - math.log10(abs(value)))
    digits = max(0, 1 - round(math.log10(step)), fewest)
    factor = parse_unit(column.unit, kind).factor
    half, unit = to_display(0.5 * 10.0**-digits * factor, column.role)
    is_workbook = readings.name.lower().endswith(".xlsx")
    return {
        "role": column.role,
        "text": reading.text,
        "low": value - step / 2,
        "high": f"{value + step / 2:.4g} {column.unit}".rstrip(),
        "example": f"{value:.{digits}f}",
        # A spreadsheet removes zeros at the end of a number.
        "how": " (by a number format that shows it)" if is_workbook else "",
        "u": half,
        "unit": unit,
    }


def _transverse_inertia(seen: Seen) -> Iterator[Diagnostic]:
    """Report the estimate of a transverse inertia if its uncertainty matters."""
    measured = seen.measured
    fit = seen.fit
    for share in fit.budget:
        if share.source == "transverse_inertia" and share.share > DROP_ONE**2:
            across = fitting.transverse_inertia(measured)
            size = 100 * share.u_inertia / abs(fit.inertia.value)
            taken = {
                "low": across.min(),
                "high": across.max(),
                "middle": np.median(across),
            }
            yield seen.readings.say(
                "transverse_inertia_not_given", **taken, percent=size
            )


def _model(seen: Seen) -> Iterator[Diagnostic]:
    """Report what the log does not say of the motion, and how much it matters."""
    readings = seen.readings
    measured = seen.measured
    if measured.transverse_inertia is None:
        yield from _transverse_inertia(seen)
    if "pitch" in readings.columns:
        unused = _uncertainties_of(MODELS) - _uncertainties_of(seen.motion.models)
        for key, place in readings.stated_at.items():
            if key in unused:
                yield readings.say("u_of_pitch_not_used", place, key=key)
    runs = fitting.timed_runs(measured)
    silent = {model.effect: model for model in MODELS if model.is_silent(runs)}
    for effect in seen.effects:
        if effect.effect == "tachometer" and _matters(seen, effect):
            direction = "lower" if (effect.bias or 0.0) > 0 else "higher"
            off = 100 * abs(effect.bias or 0.0)
            yield readings.say("tachometer_not_told", off=off, direction=direction)
        elif effect.effect in silent and not seen.asked:
            yield from _silent_motion(seen, effect, silent[effect.effect])


def _uncertainties_of(many: Iterable[MotionModel]) -> set[str]:
    """Return the keys of the uncertainties that only these models of motion use."""
    return set(chain.from_iterable([model.uncertainties for model in many]))


def _matters(seen: Seen, effect: Effect) -> bool:
    """Return whether an effect of a consistent log is too large to be left out."""
    return (effect.size or 0.0) > DROP_ONE and not seen.contradicts_itself


def _silent_motion(
    seen: Seen, effect: Effect, model: MotionModel
) -> Iterator[Diagnostic]:
    """Report a motion of a silent log: assumed, or not used although it matters."""
    if effect.bias is None or model.messages is None:
        return
    is_assumed, is_not_used = model.messages
    direction = "high" if effect.bias > 0 else "low"
    off = 100 * abs(effect.bias)
    if effect.kept:
        yield seen.readings.say(is_assumed, off=off, direction=direction)
    elif _matters(seen, effect):
        yield seen.readings.say(is_not_used, off=off, direction=direction)


BY_HAND = (60 * RPM, 2000 * RPM)
"""Range of spins of a ball that is spun by hand [rad/s], with a margin."""

NO_MOTOR = 0.7
"""A rotor with less angular momentum than this has no motor: published ones with a
motor have 1 to 2 [kg*m^2/s]."""

LONG_TURN, SHORT_ARM, LONG_LEVER, NEARLY_AS_FAST = 600.0, 0.05, 10.0, 0.15
"""Bounds of the time of a turn with a weight [s], the arm [m], m x²/I_zz [1], and
precession over spin [1]."""


class Question(NamedTuple):
    """A question about a column whose readings are possible but not usual."""

    name: str
    """Of its message."""
    role: str
    usual: tuple[float, float]
    """Range of the readings in this lab [SI unit]."""
    is_asked: bool
    is_doubt: bool = False
    """Whether no lab has such readings, so that the answer is not safe to quote."""


def _unusual(seen: Seen) -> Iterator[Diagnostic]:
    """Ask about columns that are possible but not usual, one question for each column.

    All published logs are within the bounds.
    """
    measured = seen.measured
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
    odd_spin = fastest < 80 * RPM or (by_hand and fastest > 1800 * RPM)
    is_as_fast = float((rate / spin).min()) > NEARLY_AS_FAST
    times = (1.0, LONG_TURN)
    arms = (SHORT_ARM, 0.6)
    is_heavy = lever > LONG_LEVER and arm < arms[1]
    questions = (
        Question("spin_not_usual", "spin", BY_HAND, odd_spin),
        Question("turn_not_usual", "time", times, turn > LONG_TURN),
        Question("turn_too_fast", "time", times, is_as_fast, is_doubt=True),
        Question("arm_not_usual", "position", arms, arm < SHORT_ARM),
        Question("weight_too_large", "spin", BY_HAND, is_heavy, is_doubt=True),
    )
    values = {
        "rpm": fastest / RPM,
        "minutes": turn / 60,
        "turn": turn,
        "arm": 100 * arm,
        "lever": lever,
    }
    roles: set[str] = set()
    for question in questions:
        if question.is_asked and question.role not in roles:
            roles.add(question.role)
            yield _ask(seen, question, values)


def _ask(seen: Seen, question: Question, values: Mapping[str, float]) -> Diagnostic:
    """Ask about the largest reading of a column, and propose another unit."""
    readings = seen.readings
    measured = seen.measured
    role = question.role
    column = readings.columns.get(role)
    unit = unit_within(readings, role, question.usual) if column else ""
    hint = "check the unit in the header of each column; if it is right, leave it"
    if unit:
        hint = (
            f'if the numbers are in {unit}, write the header as "{role} [{unit}]"; if it '
            f"is right, add # ball_mass and # ball_diameter: gyro then compares I_zz with "
            f"the ball instead"
        )
    place = None
    if column is not None:
        sizes = {"position": measured.position, "spin": measured.spin}
        size = np.abs(sizes.get(role, np.zeros(len(measured.runs))))
        place = column.place(int(np.argmax(np.where(measured.torque, size, 0.0))))
    asked = readings.say(question.name, place, **values, hint=hint)
    # If another unit makes the column usual, the answer is not safe to quote either.
    return replace(asked, doubt="size" if unit or question.is_doubt else "")


INERTIA_RANGE = (1e-6, 1.0)
"""Range of I_zz of a body that is spun on a table [kg*m^2]."""

FAR_BELOW_BALL, FAR_ABOVE_BALL, FAR_IN_U = -0.05, 0.1, 5.0
"""A difference from the ball outside these limits [1], over this many u, needs a cause;
a bore increases I_zz."""


DIFFERS = 2.0
"""A difference from a well known ball of more than this many standard uncertainties is
reported."""

ARM_BY = (0.001, 0.02)
"""Smallest and largest error of an arm [m] that is proposed as a cause: the size of a
weight."""

MASS_BY = 0.2
"""Largest relative error of all masses that is proposed as a cause."""


def _well_known(ball: Ball, inertia: Estimate) -> bool:
    """Return whether the ball is better known than the runs measure."""
    return ball.mass is not None and (ball.inertia_u or 0.0) < 0.5 * (inertia.u or 0.0)


def _causes_of_difference(seen: Seen, ball: Ball) -> str:
    """List the causes that can make I_zz differ from the value for the ball or disk.

    The most likely cause is first.
    """
    measured = seen.measured
    share = abs(ball.relative)
    is_high = ball.relative > 0
    causes = []
    if is_high and not ball.bore:
        causes.append(
            "a bore along the rod, or a rod or a disk that the log does not describe"
        )
    by = share * float(np.mean(np.abs(measured.position[measured.torque != 0])))
    if ARM_BY[0] < by < ARM_BY[1]:
        edge, side = ("far", "long") if is_high else ("near", "short")
        origin = f"to the middle of the weight, not to its {edge} edge"
        causes.append(
            f"positions {1e3 * by:.1f} mm too {side}: measure from the centre of the ball {origin}"
        )
    if is_high and measured.delay_factor is not None and measured.drag is None:
        causes.append(
            'a spin that falls fast and was read late: add "# spin_down: 612 rpm '
            'to 540 rpm in 120 s"'
        )
    causes.append("a ball whose balance changed when the weights were changed")
    if "mass" in seen.readings.columns and share < MASS_BY:
        causes.append(
            f"masses {100 * share:.1f} % too {'large' if is_high else 'small'}"
        )
    body = "ball" if ball.mass is not None else "disk"
    causes.append(f"the mass or the diameter of the {body} in the log")
    return "; ".join(
        f"({number}) {cause}" for number, cause in enumerate(causes, start=1)
    )


def _ball_differs(seen: Seen, ball: Ball) -> Iterator[Diagnostic]:
    """Report an I_zz that is near the value for a well known ball, but differs from it.

    The value for the ball is not within the uncertainty.
    """
    deviation = ball.deviation or 0.0
    if abs(deviation) < DIFFERS or not _well_known(ball, seen.fit.inertia):
        return
    side = "above" if deviation > 0 else "below"
    sizes = {
        "percent": 100 * abs(ball.relative),
        "side": side,
        "expected": ball.inertia,
        "far": abs(deviation),
    }
    yield seen.readings.say(
        "ball_differs", **sizes, causes=_causes_of_difference(seen, ball)
    )


def _ball_disagrees(seen: Seen, ball: Ball) -> Diagnostic:
    """Report an I_zz that is far from the value for the ball or disk.

    The report also names the mistakes that explain this I_zz.
    """
    value = abs(seen.fit.inertia.value)
    body = "the ball" if ball.mass is not None else "the disk"
    ratio = value / ball.inertia
    part = f"{ratio:.3g} times" if ratio > 0.5 else f"1/{1 / ratio:.3g} of"
    slips = mistakes.explaining_mistakes(
        seen.readings, seen.measured, value, ball.inertia
    )
    if slips:
        cause = "it would be " + "; or ".join(
            f"{after:.4g} if {kind.log}" for kind, after in slips
        )
        hint = "; or else: ".join(kind.remedy for kind, _ in slips)
    else:
        cause = "no common mistake explains this"
        hint = (
            f"look for a cause in this order: {_causes_of_difference(seen, ball)}; a "
            f"unit in a header"
        )
    sizes = {"inertia": value, "ratio": part, "body": body, "expected": ball.inertia}
    return seen.readings.say("ball_disagrees", **sizes, cause=cause, hint=hint)


def _body(seen: Seen) -> Iterator[Diagnostic]:
    """Report an I_zz that is impossible for the ball or disk, or in this lab."""
    ball = seen.ball
    if ball is not None and _is_far(ball):
        yield _ball_disagrees(seen, ball)
    elif _is_unusual(seen):
        low, high = INERTIA_RANGE
        value = abs(seen.fit.inertia.value)
        yield seen.readings.say("inertia_unusual", inertia=value, low=low, high=high)


def _other_body(seen: Seen) -> Iterator[Diagnostic]:
    """Report an I_zz that differs from the ball, or columns that are not usual."""
    ball = seen.ball
    if (ball is not None and _is_far(ball)) or _is_unusual(seen):
        return
    if ball is not None and not seen.contradicts_itself:
        yield from _ball_differs(seen, ball)
    # With a ball in the log, I_zz itself is checked.
    elif not seen.unusual_sizes and seen.readings.constants.get("ball_mass") is None:
        yield from _unusual(seen)


def _is_far(ball: Ball) -> bool:
    """Return whether I_zz is impossible for a ball, and not only by its uncertainty."""
    if FAR_BELOW_BALL <= ball.relative <= FAR_ABOVE_BALL:
        return False
    return abs(ball.deviation or math.inf) > FAR_IN_U


def _is_unusual(seen: Seen) -> bool:
    """Return whether no lab with an air bearing has such an I_zz."""
    low, high = INERTIA_RANGE
    return not seen.unusual_sizes and not low <= abs(seen.fit.inertia.value) <= high


Check = Callable[[Seen], Iterable[Diagnostic]]

CHECKS: tuple[Check, ...] = (
    _outliers,
    _scatter,
    _weights_disagree,
    _blocks_disagree,
    _balance,
    _explanations,
    _deviations,
    _agreement,
    _large_residual_torque,
    _falling_spin,
    _other_measurements,
    _direction,
    _digits,
    _model,
    _body,
    _other_body,
)
"""Every check of a log that has been fitted, in the order in which the findings are
shown."""

OF_FIT = tuple([check for check in CHECKS if check not in (_deviations, _other_body)])
"""The checks that a grade shows: not those of the law of the period, and of columns that
are possible but not usual."""
