"""What would I_zz be if …? One list of changes, one way to answer: fit the changed log.

A change is a log after it: its runs, their errors or its model. It is fitted exactly as
the log itself is fitted, with the model that it needs. So a report's "without this
weight" is what ``gyro analyze`` gives if the rows are deleted from the file.

An effect, such as a tilted rod or a release from rest, can be left out: its size is
I_zz of the fit without it, compared with the fit with it. An effect below 0.2 of the
standard uncertainty is left out, the smallest first, if all of these together stay
below 0.3 and if the single runs do not deviate because of it. `choose_model` keeps the
others. Effects of unknown size (M0, b) are parameters of every model.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import suppress
from functools import cache
from operator import itemgetter
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata import fitting, physics
from gyrodata.fitting import Estimate, FitResult, Widths
from gyrodata.judging.tables import load_words
from gyrodata.measurements import (
    BALANCE_CHANGE,
    SOURCES,
    WHOLE,
    Measurements,
    Source,
    select,
    total_spin_excess,
)
from gyrodata.measurements.sources import list_sources
from gyrodata.physics import Floats, models
from gyrodata.physics.models import AUTO, MODELS, Motion, MotionModel, TimedRuns
from gyrodata.quantities.error_sources import DECAY_TIME
from gyrodata.quantities.units import Uncertainty
from gyrodata.readings import Readings

WATCHED = 180.0
"""Duration of a run without a weight [s]."""

EASY_TEST = 400 * physics.RPM * math.radians(5.0) / 60.0
"""u of M0 over I_zz [rad²/s²] after a balance test that is easy to pass: 5° in a minute
at 400 rpm."""

LATE = 0.1
"""How late or early the hand is in the changes "hand_late" and "hand_early" [s]."""

MOST_WEIGHTS = 12
"""With more torques than this, none is left out, or searched for a mistake."""

MOST_RUNS = 500
"""Of a longer log nothing is asked, and no mistake is looked for: each answer is a fit of
all runs."""


class Lab(Struct, frozen=True):
    """A log and its fit, from which each change starts."""

    readings: Readings | None
    """None for a simulated lab: nothing then changes in the text of a log."""
    measured: Measurements
    """Its n runs, as they were fitted."""
    fit: FitResult
    motion: Motion
    """How the rods moved, according to this fit."""
    left_out: tuple[int, ...] = ()
    effects: tuple[Effect, ...] = ()
    """The effects of `list_effects`, if they were listed."""
    asked: bool = False
    """True if the user chose the model."""

    @property
    def relative_u(self) -> float:
        """Standard uncertainty of I_zz over I_zz [1]."""
        return fitting.relative_u(self.fit.inertia)

    @property
    def timed_runs(self) -> TimedRuns:
        """The readings that a model of motion needs."""
        return fitting.timed_runs(self.measured)

    @property
    def is_long(self) -> bool:
        """Whether nothing is asked of this log, because each answer takes too long."""
        return len(self.measured.runs) > MOST_RUNS

    def change(
        self,
        name: str,
        words: str,
        changed: Mapping[str, Any] | None = None,
        **how: Any,
    ) -> Change:
        """Return a change of this lab with other fields of its measurements.

        The keywords `how` replace other fields of the change.
        """
        runs = replace(self.measured, **changed) if changed else self.measured
        return replace(Change(name, words, runs, left_out=self.left_out), **how)


class Change(Struct, frozen=True):
    """One question "what would I_zz be if …?": a lab after one change."""

    name: str
    """Its name in the JSON."""
    words: str
    """What is different, for users; of an effect, what is known of it."""
    measured: Measurements
    motion: Motion | None = None
    """None: the model that the changed log needs."""
    left_out: tuple[int, ...] = ()
    widths: Widths | None = None
    """Fixed widths; None: integrate over them as for the log."""
    torque_number: int | None = None
    """Number of the torque that is left out, in the order of the log."""
    is_always_advised: bool = False
    """Of advice: whether it is given even if u becomes only a little smaller."""
    kept: bool = False
    """Of an effect: whether the model of the log takes it into account, and the change
    leaves it out; if not, the change adds it."""
    in_u: bool = False
    """Of an effect: whether u of I_zz contains the doubt about it."""
    model: MotionModel | None = None
    """Of an effect of the motion: the model that takes it into account."""


# --- effects ---

EFFECTS = {
    "residual_torque": "imperfect balance",
    BALANCE_CHANGE: "balance, differs between weights",
    "timing_bias": "timing bias of the hand",
    "spin_decay": "falling spin, plain mean of start and end",
    "spin_delay": "spin read late",
    "tachometer": "tilted rod, total spin taken for ψ̇",
}
"""The effects that do not belong to a model of motion, by their name in the JSON, in
words."""


UNTOUCHED: Mapping[str, Any] = {"balance": "untouched"}
"""What a log says if nobody touched the balance between two weights."""


def effect_words(name: str) -> str:
    """Return an effect for users, by its name in the JSON."""
    model = models.of_effects().get(name)
    return EFFECTS.get(name, name) if model is None else model.effect_words


def _effects(lab: Lab) -> Iterator[Change]:
    """List all effects: each is in the fit and is left out here, or is added here."""
    yield _residual_torque(lab)
    yield from _errors_of_all_runs(lab)
    for model in models.of_effects().values():
        is_used = lab.motion.of_effect(model.effect)
        if is_used or model.is_listed(lab.timed_runs):
            yield _effect_of_model(lab, model)
        if model.tilted:
            yield from _total_spin_read(lab)


def _residual_torque(lab: Lab) -> Change:
    """Suppose that M0 is zero: a run without a weight then is not used."""
    widths = lab.fit.widths
    assert widths.residual_torque is not None
    nearly_zero = fitting.NEGLIGIBLE * widths.residual_torque
    unloaded = np.flatnonzero(lab.measured.torque == 0).tolist()
    return lab.change(
        "residual_torque",
        "unknown beforehand: M0 has a prior with wide tails",
        kept=True,
        left_out=tuple({*lab.left_out, *unloaded}),
        widths=replace(widths, residual_torque=nearly_zero, level=0.0),
    )


def _errors_of_all_runs(lab: Lab) -> Iterator[Change]:
    """Leave out what the fit supposes of the balance, the hand and the spin."""
    measured = lab.measured
    if measured.balance_differs:
        # M0 is the same with every weight.
        width = lab.fit.widths.level
        words = f"unknown beforehand: its width is estimated as {width:.2g} N·m"
        yield lab.change(BALANCE_CHANGE, words, UNTOUCHED, kept=True, in_u=True)
    if measured.timing_bias_u:
        words = f"unknown beforehand, ± {measured.timing_bias_u:g} s"
        yield lab.change("timing_bias", words, {"timing_bias_u": 0.0}, kept=True)
    start = measured.spin_start
    end = measured.spin_end
    if start is not None and end is not None:
        words = "the harmonic mean in time is used, because it costs nothing"
        plain = {"spin": (start + end) / 2}
        yield lab.change("spin_decay", words, plain, kept=True)
    if measured.delay_factor is not None:
        # The spin had already fallen when it was read.
        law = "as the log shows"
        if measured.drag is None:
            law = "as usual, because the log has no spin-down"
        words = f"the spin is corrected for its fall during the delay, {law}"
        changed = {"delay_factor": None}
        yield lab.change("spin_delay", words, changed, kept=True, in_u=True)


def _effect_of_model(lab: Lab, model: MotionModel) -> Change:
    """Leave out the effect of a model of motion, or add it to a log without it."""
    runs = lab.timed_runs
    # Without a reading for the effect, its size is that of a typical rod.
    supposed = model.supposed(runs)
    used = lab.motion.of_effect(model.effect)
    as_asked = ", as asked" if lab.asked else ""
    if used is None or supposed:
        words = model.reason(runs, False, as_asked)
        other = lab.motion.including(model)
        return lab.change(model.effect, words, supposed, motion=other, model=model)
    words = used.reason(runs, True, as_asked)
    other = lab.motion.without(model.effect)
    return lab.change(model.effect, words, kept=True, motion=other, model=used)


def _total_spin_read(lab: Lab) -> Iterator[Change]:
    """Suppose that a fixed tachometer reads the total spin of a tilted rod."""
    measured = lab.measured
    if not measured.pitch.any() or measured.tachometer is not None:
        return
    words = (
        'it follows the rod; this is for one that stands still ("# tachometer: '
        'still" in the log)'
    )
    spin = measured.spin - total_spin_excess(
        lab.fit.sense, measured.turns, measured.time, measured.pitch
    )
    yield lab.change("tachometer", words, {"spin": spin})


# --- sensitivity: what the answer depends on ---


def _sensitivity(lab: Lab) -> Iterator[Change]:
    """List other times, another balance, and each weight left out."""
    measured = lab.measured
    if measured.timed:
        sources = _scaled(measured, ("time",), 2.0)
        yield lab.change(
            "u_time_twice", "times twice as uncertain", {"sources": sources}
        )
    if measured.timing_bias_u:
        for name, late, how in (
            ("hand_late", LATE, "long"),
            ("hand_early", -LATE, "short"),
        ):
            changed = {"time": measured.time - late, "timing_bias_u": 0.0}
            yield lab.change(name, f"times {LATE:g} s too {how}", changed)
    yield from _other_balance_lines(lab)
    yield from _without_each_weight(lab)


def _without_each_weight(lab: Lab) -> Iterator[Change]:
    """Leave out one torque after the other."""
    measured = lab.measured
    groups = measured.by_torque
    if not 1 < len(groups) <= MOST_WEIGHTS:
        return
    kept = lab.fit.adjusted.kept > 0
    for number, group in enumerate(groups):
        rest = np.delete(np.arange(len(measured.runs)), group)
        if not (kept[group].any() and measured.torque[rest[kept[rest]]].any()):
            continue
        words = "the unloaded runs"
        if measured.torque[group[0]]:
            words = load_words(measured, group[0])
        yield lab.change(
            "without",
            f"without {words}",
            measured=select(measured, rest.tolist()),
            left_out=tuple(np.flatnonzero(~kept[rest]).tolist()),
            torque_number=number,
        )


def _other_balance_lines(lab: Lab) -> Iterator[Change]:
    """Suppose that the log has another line about the balance: "# balanced: yes"."""
    measured = lab.measured
    if not measured.balanced:
        yield lab.change(
            "balanced", 'ball balanced ("# balanced: yes")', {"balanced": True}
        )
    if measured.balanced or measured.balance_test is not None:
        unknown = {"balanced": None, "balance_test": None, "torque_unseen": None}
        yield lab.change("balance_free", "balance unknown", unknown)
    elif measured.balanced is None and measured.torque_unseen is None:
        yield lab.change(
            "balance_free", 'ball not balanced ("# balanced: no")', {"balanced": False}
        )
    if measured.balance_differs:
        words = 'balance not touched between the weights ("# balance: untouched")'
        yield lab.change("balance_untouched", words, UNTOUCHED)


def _scaled(
    measured: Measurements, names: Collection[str], factor: Any
) -> tuple[Source, ...]:
    """Return the sources, the errors of some of them `factor` times as large."""
    sources = []
    for source in measured.sources:
        if source.name in names:
            absolute = factor * source.absolute
            relative = factor * source.relative
            source = replace(source, absolute=absolute, relative=relative)
        sources.append(source)
    return tuple(sources)


# --- advice: what would make the next lab better ---


def _unloaded_run(lab: Lab) -> Iterator[Change]:
    """Add a run without a weight at the middle spin, with its direction."""
    measured = lab.measured
    if not measured.torque.all():
        return
    # In the rest, the new run is like the last one.
    count = len(measured.runs)
    more = select(measured, [*range(count), count - 1])
    for name, value in _reading_without_weight(lab).items():
        values = getattr(more, name)
        if not np.isnan(values).all():
            values[-1] = value
    for source in more.sources:
        if source.quantity not in ("time", "spin", "turns", "g"):
            source.groups[-1] = -1
        elif source.shared_by.startswith("all runs"):
            source.groups[-1] = 0
        else:
            source.groups[-1] = source.groups.max() + 1
        source.absolute[-1] = source.absolute.max()
        source.relative[-1] = source.relative.max()
    words = (
        "one run without a weight, with the direction of its precession (column "
        "precession_sense: ccw or cw)"
    )
    runs = (*measured.runs, "unloaded")
    lines = (*measured.lines, 0)
    more = replace(more, runs=runs, lines=lines)
    yield lab.change("unloaded_run", words, measured=more)


def _reading_without_weight(lab: Lab) -> dict[str, float]:
    """Return the readings of a run without a weight, by field of `Measurements`."""
    measured = lab.measured
    fit = lab.fit
    # The gain does not depend on how large M0 is; but without a residual torque the rod
    # stands still.
    m0 = fit.residual_torque.value
    least = 0.005 * np.abs(measured.torque).min()
    torque = math.copysign(max(abs(m0), least), m0)
    spin = float(np.sort(measured.spin)[len(measured.spin) // 2])
    rate = physics.horizontal_precession_rate(torque, spin, fit.inertia.value)
    nothing = ("mass", "position", "force", "given_torque", "torque", "pitch")
    return {
        **dict.fromkeys(nothing, 0.0),
        "time": WATCHED + fit.timing_bias.value,
        "turns": WATCHED * abs(rate) / (2 * np.pi),
        "spin": spin,
        "sense": math.copysign(1.0, torque),
    }


WORN = 1 / 150
"""Relative fall of the spin in a second with a worn cup or little air [1/s]."""

SHIFTS = 0.5
"""A worn cup matters if it changes I_zz by this many standard uncertainties."""


def _bad_air(lab: Lab) -> str:
    """Say what a spin that falls fast and is read late would do; "" if little.

    It is known if the log shows how the spin falls.
    """
    measured = lab.measured
    if measured.drag is not None or measured.delay_factor is None:
        return ""
    bias = float(np.max(np.abs(measured.delay_factor - 1))) * WORN * DECAY_TIME
    if bias < SHIFTS * lab.relative_u:
        return ""
    return f" (with little air, as in a worn cup, I_zz is {100 * bias:.2g} % too large)"


def _better_readings(lab: Lab) -> Iterator[Change]:
    """Halve each error that makes a part of u, or that is in doubt, if possible."""
    bad_air = _bad_air(lab)
    for share in lab.fit.budget:
        why = bad_air if share.source == "spin_delay" else ""
        better = SOURCES[share.source].better if share.source in SOURCES else ""
        if better and (share.share > 0.05 or why):
            changed = {"sources": _scaled(lab.measured, (share.source,), 0.5)}
            yield lab.change(
                "half_the_error", better + why, changed, is_always_advised=bool(why)
            )


def _advice(lab: Lab) -> Iterator[Change]:
    """List what the next lab can do better."""
    yield from _unloaded_run(lab)
    yield from _better_readings(lab)
    measured = lab.measured
    fit = lab.fit
    # Only if the ball can pass it, by what the runs say of M0.
    m0 = fit.residual_torque
    limit = 2 * math.hypot(m0.u or 0.0, EASY_TEST * fit.inertia.value)
    if measured.balance_test is None and abs(m0.value) < limit:
        words = (
            "a balance test in the log, "
            '"# balance_drift: 5 deg in 60 s at 400 rpm" or better'
        )
        test = Uncertainty(relative=EASY_TEST)
        yield lab.change("balance_test", words, {"balance_test": test})
    if measured.timed:
        off = fit.timing_bias.value + (measured.time - fit.fitted_time)
        time = 3 * (measured.time - off)
        turns = 3 * measured.turns
        # Whole turns end where they began: no mark has to be sighted.
        part = np.abs(turns - np.round(turns)) > WHOLE
        sources = _scaled(measured, ("angle", "screw_angle"), part)
        changed = {"time": time + off, "turns": turns, "sources": sources}
        words = "time three times as many turns of the rod in every run"
        yield lab.change("three_times", words, changed)


def _direction(lab: Lab) -> Iterator[Change]:
    """Write the direction of runs without a weight, if M0 may have either sign."""
    if lab.fit.two_signs:
        words = "the direction of each run without a weight"
        yield lab.change("direction", words, {"sense": lab.fit.sense})


ROUNDED = ("mass", "position", "time", "spin")
"""Columns whose digits can be too few."""

MUCH_ROUNDING = 0.2
"""Smallest share of u² of a reading that may have too few digits [1]."""


def _one_more_digit(lab: Lab) -> Iterator[Change]:
    """Write one more digit in each column that makes a large part of u.

    The words of the change are the role of the column.
    """
    readings = lab.readings
    shares = {share.source: share.share for share in lab.fit.budget}
    for role in ROUNDED:
        is_large = shares.get(role, 0.0) >= MUCH_ROUNDING
        if readings is None or not is_large or role not in readings.columns:
            continue
        column = readings.columns[role]
        # A fit is only worth its time if rounding is a large part of the error.
        rounding = np.array(column.steps) / math.sqrt(12)
        [source] = [each for each in lab.measured.sources if each.name == role]
        of_reading = source.relative * np.abs(getattr(lab.measured, role))
        if (rounding < 0.5 * (source.absolute + of_reading)).all():
            continue
        finer = [
            replace(reading, step=reading.step and reading.step / 10)
            for reading in column.readings
        ]
        columns = {**readings.columns, role: replace(column, readings=tuple(finer))}
        changed = replace(readings, columns=columns)
        sources = tuple(list_sources(changed, lab.measured))
        yield lab.change("one_more_digit", role, {"sources": sources})


CHANGES: Mapping[str, Callable[[Lab], Iterator[Change]]] = {
    "effect": _effects,
    "sensitivity": _sensitivity,
    "advice": _advice,
    "unloaded_run": _unloaded_run,
    "direction": _direction,
    "one_more_digit": _one_more_digit,
}
"""The changes by the table to which they belong, each in the order of its table; none
that does not apply to a log."""


# --- the size of an effect ---

WORTH = 0.95
"""gyro advises a change only if it reduces u of I_zz to at most this part of its value.
"""

DROP_ONE = 0.2
"""An effect below this many standard uncertainties of I_zz may be left out …"""

DROP_ALL = 0.3
"""… as long as all that are left out stay below this many together."""

CLEARLY_SMALL = 0.05
"""An effect below this many standard uncertainties does not change how the runs
scatter."""


class Effect(Struct, frozen=True):
    """An effect, such as a tilted rod: how much I_zz changes if it is left out."""

    effect: str
    bias: float | None
    """I_zz without it over I_zz with it, minus 1; None if it cannot be computed."""
    size: float | None
    """The same without its sign, in standard uncertainties of I_zz."""
    kept: bool
    """True if the fit of the log takes it into account. False, too, if the log has no
    reading for it, such as a pitch, so that its size is that of a typical rod."""
    in_u: bool
    """True if u of I_zz contains its uncertainty."""
    reason: str


def _bias(lab: Lab, change: Change) -> float | None:
    """Compute I_zz without an effect over I_zz with it, minus 1; None if impossible."""
    motion = change.motion or lab.motion
    change = replace(change, motion=motion)
    is_same = change.measured is lab.measured and motion == lab.motion
    if is_same and not change.widths:
        return 0.0
    try:
        ratio = _ratio_of_inertia(lab, change)
    except fitting.NoFit:
        return None
    # Of an effect that the fit contains, the change removes it; else it adds it.
    return ratio - 1 if change.kept else 1 / ratio - 1


def _ratio_of_inertia(lab: Lab, change: Change) -> float:
    """Return I_zz of a changed log over that of the log."""
    # With the widths held, the fit gives no posterior: so the adjusted values of both
    # fits are compared, and not the means of their posterior distributions.
    fit = lab.fit
    widths = change.widths or fit.widths
    at_widths = _fit_of(lab, replace(change, widths=widths))
    ratio = at_widths.inertia.value / float(fit.adjusted.unknowns[0])
    is_small = abs(ratio - 1) <= CLEARLY_SMALL * lab.relative_u
    if is_small or change.widths or fit.posterior is None:
        return ratio
    # A large effect changes how the runs scatter, and so the widths.
    changed = _fit_of(lab, change).inertia
    return changed.value / fit.inertia.value


def list_effects(lab: Lab, names: Collection[str] | None = None) -> tuple[Effect, ...]:
    """List the effects that a log can have, with their sizes and the decisions.

    With `names`, only the effects with these names are listed; none of a long log.
    """
    if lab.is_long or (names is not None and not names):
        return ()
    effects = CHANGES["effect"](lab)
    return tuple(
        [_size_up(lab, each) for each in effects if names is None or each.name in names]
    )


def _size_up(lab: Lab, change: Change) -> Effect:
    """Return an effect with its size."""
    bias = _bias(lab, change)
    if bias is None:
        reason = f"{change.words}: without a fit that could be compared"
        return Effect(change.name, None, None, change.kept, change.in_u, reason)
    if _has_unknown_sign(lab, change):
        bias = abs(bias)
    u = lab.relative_u
    size = None
    if u:
        size = abs(bias) / u
    return Effect(change.name, bias, size, change.kept, change.in_u, change.words)


def _has_unknown_sign(lab: Lab, change: Change) -> bool:
    """Return whether an effect is in every log, in a sense that it does not say."""
    if change.model is None or not change.model.always:
        return False
    return not change.model.is_stated(lab.timed_runs)


def _biases(lab: Lab, model: MotionModel) -> Floats:
    """Compute the relative bias of I_zz of each run without an effect [1], shape (n,).

    It is that of the first model of the effect, by which the models are chosen. The
    table of effects shows that of the model in the fit, if there is one.
    """
    top = fitting.top_of(lab.measured, lab.fit)
    first = models.of_effects()[model.effect]
    return Motion((first,)).bias_if_left_out(top, lab.timed_runs)


def size_of_model(lab: Lab, model: MotionModel) -> float:
    """Compute the change of I_zz without a model of motion, in its u [1].

    It is the sum of the changes of the single runs, which is right for a small effect;
    NaN without a steady precession.
    """
    u = lab.relative_u
    change = float(lab.fit.response @ _biases(lab, model))
    return abs(change) / u if u else math.inf


NEARLY = 0.7
"""An effect about which the log is silent is reported only if its size without a fit is
above this part of `DROP_ONE`."""


def assumed_effects(lab: Lab) -> tuple[str, ...]:
    """Return the effects of a silent log that are used or may matter."""
    runs = lab.timed_runs
    effects = []
    for model in MODELS:
        if not model.is_silent(runs):
            continue
        is_small = size_of_model(lab, model) < NEARLY * DROP_ONE
        if model in lab.motion.models or not is_small:
            effects.append(model.effect)
    return tuple(effects)


# --- answers ---


class Sensitivity(Struct, frozen=True):
    """I_zz if one thing were different."""

    name: str
    """"u_time_twice", "hand_late", "hand_early", "balanced", "balance_free",
    "balance_untouched" or "without"."""
    words: str
    """What is different: "without 20 g at 15 cm"."""
    inertia: Estimate | None
    """[kg*m^2]; None if the changed log has no answer: an interval that contains zero.
    """
    deviation: float | None
    """Its distance from I_zz in standard uncertainties of I_zz."""


FEW = 50
"""Of a log with more runs, a changed log has the model of the log itself: another
choice takes a second."""


def answers(lab: Lab, table: str) -> list[tuple[Change, Sensitivity]]:
    """Answer every question of a table of `CHANGES` that applies to a lab."""
    if lab.is_long:
        return []
    answer = lab.fit.inertia
    answered_changes = []
    for change in CHANGES[table](lab):
        inertia = deviation = None
        with suppress(fitting.NoFit):
            fitted = _fit_of(lab, change).inertia
            # An interval that includes zero is not an answer.
            if (fitted.interval_95 or (1.0, 1.0))[0] > 0:
                inertia = fitted
                off = fitted.value - answer.value
                deviation = off / answer.u if answer.u else None
        answered = Sensitivity(change.name, change.words, inertia, deviation)
        answered_changes.append((change, answered))
    return answered_changes


def gains(
    lab: Lab, table: str, worth: float = WORTH
) -> Iterator[tuple[str, float, float]]:
    """List the changes of a table that reduce u of I_zz to at most this part.

    Each is listed by its words, with u of I_zz now and after it [%].
    """
    now = 100 * lab.relative_u
    for change, answer in answers(lab, table):
        if answer.inertia:
            then = 100 * fitting.relative_u(answer.inertia)
            if then <= worth * now or change.is_always_advised:
                yield change.words, now, then


Fits = Callable[[Motion], Lab]
"""The fits of one log with several motions, each made once."""


def _fits(
    measured: Measurements,
    left_out: tuple[int, ...] = (),
    near: FitResult | None = None,
    widths: Widths | None = None,
) -> Fits:
    """Return a function that fits a log with a motion, or raises `NoFit`.

    The corrections start from those of `near`, a fit of nearly the same log.
    """

    @cache
    def lab(motion: Motion) -> Lab:
        runs, fit = fitting.fit_model(measured, motion, left_out, widths, near)
        return Lab(None, runs, fit, motion, left_out)

    return lab


def _fit_of(lab: Lab, change: Change) -> FitResult:
    """Fit a changed log with the model that it needs."""
    measured = change.measured
    fits = _fits(measured, change.left_out, lab.fit, change.widths)
    motion = change.motion or lab.motion
    if not (change.motion or lab.asked) and len(measured.runs) <= FEW:
        # As for the log itself, the models are chosen with all runs: `fits` has fewer.
        motion = choose_model(measured, fits=None if change.left_out else fits)
    return fits(motion).fit


# --- the model of a log ---


def choose_model(
    measured: Measurements, model: str = AUTO, fits: Fits | None = None
) -> Motion:
    """Choose the requested model, or the simplest that are good enough.

    A model is offered if the log states its motion, or if the log is silent and the
    motion may have happened. It is needed if its effect is too large to be left out. A
    model about which the log is silent is given up again if the runs clearly contradict
    it.

    Parameters
    ----------
    measured : Measurements
        The runs.
    model : str
        The name of a model, or `AUTO`.
    fits : Fits, optional
        Known fits of this log.

    Returns
    -------
    Motion
        The models.
    """
    fits = fits or _fits(measured)
    runs = fitting.timed_runs(measured)
    stated = models.stated_or_asked(model, runs)
    is_silent = any(each.is_silent(runs) for each in MODELS)
    if model != AUTO or not (stated.models or is_silent):
        return stated
    try:
        lab = fits(Motion())
        top = fitting.top_of(lab.measured, lab.fit)
    except fitting.NoFit:
        # It is unknown what could be left out.
        return stated
    motion = needed_models(lab, models.offered(stated, top, runs))
    for each in motion.models:
        if each.is_silent(runs) and _is_contradicted(fits, motion, each, measured):
            motion = motion.without(each.effect)
    return motion


def needed_models(lab: Lab, offered: Motion) -> Motion:
    """Return those of the offered models whose effects are too large to be left out.

    The smallest is left out first, as long as it and the sum of all that are left out
    stay below their limits. What the log states is also needed if the single runs show
    it; what it does not state is assumed for its effect on I_zz only.
    """
    runs = lab.timed_runs
    sizes = {model: size_of_model(lab, model) for model in offered.models}
    dropped = 0.0
    for model, size in sorted(sizes.items(), key=itemgetter(1)):
        dropped += size
        # An effect of unknown size, NaN, is not left out.
        if not (size <= DROP_ONE and dropped <= DROP_ALL):
            break
        is_seen = model.is_stated(runs) and _seen_in_scatter(lab, model)
        if not is_seen:
            offered = offered.without(model.effect)
    return offered


CLEARLY = math.log(200.0)
"""One motion is clearly better than another if it makes the times 200 times as likely.
"""


def _is_contradicted(
    fits: Fits, motion: Motion, model: MotionModel, measured: Measurements
) -> bool:
    """Return whether the runs are clearly more likely without a model than with it.

    If there are very many runs, a sample of them is used.
    """
    if len(measured.runs) > fitting.MANY:
        every = np.ones(len(measured.runs))
        fits = _fits(select(measured, fitting.sample(measured, every)))
    with suppress(fitting.NoFit):
        without = fits(motion.without(model.effect)).fit.log_evidence
        return without - fits(motion).fit.log_evidence > CLEARLY
    return False


def _seen_in_scatter(lab: Lab, model: MotionModel) -> bool:
    """Return whether an effect that cancels in I_zz is visible in the single runs.

    An example is the effect of a rod that is tilted up and down.
    """
    in_u = _biases(lab, model) * lab.measured.time / lab.fit.time_u
    return float(np.sqrt(np.mean(in_u**2))) > DROP_ALL
