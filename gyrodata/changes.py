"""What would I_zz be if …? One list of changes, one way to answer: fit the changed table.

A change makes one or several cases of a log: its runs, their errors or its model after the change. `effects` chooses
the model of each case, and fits it exactly as the log itself is fitted. So a report's "without this weight" is what
``gyro analyze`` gives if the rows are deleted from the file.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from typing import Any, Literal

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata import fitting, physics
from gyrodata.fitting import ChosenModel, FitResult, Widths
from gyrodata.measurements import SOURCES, WHOLE, Measurements, Source, measure, select, total_spin_excess
from gyrodata.physics import Floats
from gyrodata.readings import Readings
from gyrodata.tables import load_words

WATCHED = 180.0
"""Duration of a run without a weight [s]."""

DRIFT = (math.radians(5.0), 60.0, 400 * physics.RPM)
"""A balance test that is easy to pass: 5° [rad] in a minute [s] at 400 rpm [rad/s]."""

LATE = 0.1
"""How late or early the hand is in the changes "hand_late" and "hand_early" [s]."""

LEVEL_TO = math.radians(2.0)
"""How far from level [rad] a rod may be if nobody measured it: the default standard uncertainty of a pitch."""

MOST_WEIGHTS = 12
"""With more torques than this, none is left out."""

MOST_RUNS = 500
"""Of a longer log nothing is asked: each answer is a fit of all runs."""

MOST_ROUNDING = 0.5
"""If the rounding of one column makes so much of u(I_zz), a quarter of u², one more digit is worth writing."""


class Lab(Struct, frozen=True):
    """A log and its fit, from which each change starts."""

    readings: Readings | None
    """None for a simulated lab: nothing then changes in the text of a log."""
    measured: Measurements
    """Its n runs, as they were fitted."""
    fit: FitResult
    chosen: ChosenModel
    left_out: tuple[int, ...] = ()
    release: float | None = None
    """Size of the release in standard uncertainties of I_zz [1]; None if it is not computed."""

    @property
    def kept(self) -> list[int]:
        """Runs that are used."""
        runs: list[int] = np.delete(np.arange(len(self.measured.runs)), list(self.left_out)).tolist()
        return runs

    def case(self, words: str = "", changed: Mapping[str, Any] | None = None, **how: Any) -> Case:
        """Give this lab with other fields of its measurements, and with other fields of the case."""
        runs = replace(self.measured, **changed) if changed else self.measured
        return replace(Case(words, runs, self.chosen, self.left_out), **how)


class Case(Struct, frozen=True):
    """A lab after one change."""

    words: str
    """What is different, if the change has several cases: "20 g at 15 cm"; of an effect, why it is kept or dropped."""
    measured: Measurements | None
    """None: there is nothing to fit."""
    chosen: ChosenModel
    left_out: tuple[int, ...] = ()
    widths: Widths | None = None
    """Fixed widths; None: integrate over them as for the log."""
    torque: int | None = None
    """Number of the torque that is left out, in the order of the log."""
    kept: bool = False
    """Of an effect: whether the model of the log takes it into account."""
    without: bool = True
    """Of an effect: whether the case leaves it out, or adds it."""
    sized: bool = True
    """Of an effect: whether its size decides if it is kept."""
    in_u: bool = False
    """Of an effect: whether u of I_zz contains the doubt about it."""


Use = Literal["effect", "sensitivity", "advice", "digits", "direction"]


class Change(Struct, frozen=True):
    """One question "what would I_zz be if …?"."""

    name: str
    """Its name in the JSON."""
    words: str
    """What is different, for users; "{}" is replaced by the words of each case."""
    use: Use
    """Which table it belongs to."""
    cases: Callable[[Lab], Iterable[Case]]
    """Makes the changed tables; none if the change does not apply to a log."""


# --- effects: each simplification -------------------------------------------------------------------------------------


def _residual_torque(lab: Lab) -> Iterator[Case]:
    """Fit with M0 = 0; a run without a weight then stands still, and is not used."""
    widths, kept = lab.fit.widths, lab.fit.adjusted.kept
    prior = fitting.balance_scale(lab.measured, lab.fit.inertia.value, fitting.lightest_torque(lab.measured, kept))
    words = f"its size is unknown beforehand, so M0 is a parameter with prior width {prior:.2g} N·m, with wide tails"
    assert widths.residual_torque is not None
    none = replace(widths, residual_torque=fitting.NEGLIGIBLE * widths.residual_torque)
    left_out = tuple({*lab.left_out, *np.flatnonzero(lab.measured.torque == 0).tolist()})
    yield lab.case(words, kept=True, sized=False, left_out=left_out, widths=none)


def _timing_bias(lab: Lab) -> Iterator[Case]:
    width = lab.measured.timing_bias_u
    if width:
        words = f"its size is unknown beforehand, so b is a parameter with prior width {width:g} s"
        yield lab.case(words, {"timing_bias_u": 0.0}, kept=True, sized=False)
    else:
        yield lab.case("not a stopwatch's time, or u_time_bias is 0", sized=False)


def _plain_mean_spin(lab: Lab) -> Iterator[Case]:
    start, end = lab.measured.spin_start, lab.measured.spin_end
    if start is None or end is None:
        words = "one reading of the spin in each run; at the midpoint its error is 0.05 % for a fall of 10 %"
        yield lab.case(words, sized=False, measured=None)
    else:
        readings = "start and end" if lab.measured.spin_readings == 2 else "start, midpoint and end"
        words = f"the harmonic mean in time of {readings} is used, because it costs nothing"
        yield lab.case(words, {"spin": (start + end) / 2}, kept=True, sized=False)


def _dry_friction(lab: Lab) -> Iterator[Case]:
    start, end, drag = lab.measured.spin_start, lab.measured.spin_end, lab.measured.drag
    if lab.measured.spin_readings == 2 and start is not None and end is not None:
        law, exponent = "a viscous decay is assumed, as of an air film", physics.VISCOUS
        if drag is not None:
            exponent = drag.exponent
            law = f"the readings give the exponent {exponent:.1f} ± {drag.u_exponent:.1f}"
        in_u = any(one.name == "decay_exponent" and one.relative.any() for one in lab.measured.sources)
        words = f"{law}; this is for dry friction{'; u includes the uncertainty of the law' if in_u else ''}"
        dry, mean = (physics.harmonic_mean_spin(start, end, power) for power in (0.0, exponent))
        yield lab.case(words, {"spin": lab.measured.spin * dry / mean}, sized=not in_u, in_u=in_u)


def _tilt(lab: Lab) -> Iterator[Case]:
    tilted, other = lab.chosen.tilted, replace(lab.chosen, tilted=not lab.chosen.tilted)
    if lab.measured.pitch.any():
        words = f"{'eq. (8)' if tilted else 'eq. (9)'} is used{', as asked' if lab.chosen.asked else ''}"
        yield lab.case(words, kept=tilted, without=tilted, chosen=other)
    else:
        pitch = np.full(len(lab.measured.runs), LEVEL_TO)
        yield lab.case("no pitch in the log; this is for 2° off level", {"pitch": pitch}, without=False, chosen=other)


def _tachometer(lab: Lab) -> Iterator[Case]:
    measured = lab.measured
    if measured.tachometer is None and measured.pitch.any():
        words = 'it follows the rod; this is for one that stands still ("# tachometer: still" in the log)'
        spin = measured.spin - total_spin_excess(lab.fit.sense, measured.turns, measured.time, measured.pitch)
        yield lab.case(words, {"spin": spin}, without=False)


def _release(lab: Lab) -> Iterator[Case]:
    released, told = lab.chosen.released, lab.measured.motion
    if told == "steady":
        words = "steady, as the log says; this is for a rod released from rest"
    elif told is None and released and not lab.chosen.asked:
        words = "a release with a light push is assumed, because the log does not say how the rod was started"
    elif told is None and not released:
        words = 'assumed steady; this is for a rod released from rest ("# motion: released" in the log)'
    else:
        words = "the mean rate of a rod released from rest is used" if released else "assumed steady"
        words += ", as asked" if lab.chosen.asked else ""
    other = replace(lab.chosen, released=not released)
    changed = {} if released else {"motion": "released"}
    yield lab.case(words, changed, kept=released, without=released, chosen=other)


def _earth(lab: Lab) -> Iterator[Case]:
    earth = lab.chosen.earth
    if fitting.earth_is_told(lab.measured):
        words = "the angles are counted against the stars" if earth else "at the log's latitude"
    else:
        words = "at most, at a pole" if lab.measured.latitude is None else "at the log's latitude, its sign unknown"
    yield lab.case(words, kept=earth, without=earth, chosen=replace(lab.chosen, earth=not earth))


# --- sensitivity: what the answer depends on --------------------------------------------------------------------------


def _scaled(measured: Measurements, name: str, factor: float) -> tuple[Source, ...]:
    """Sources with the errors of one of them `factor` times as large."""
    return tuple(
        replace(one, absolute=factor * one.absolute, relative=factor * one.relative) if one.name == name else one
        for one in measured.sources
    )


def _times_twice_as_uncertain(lab: Lab) -> Iterator[Case]:
    if lab.measured.timed:
        yield lab.case("", {"sources": _scaled(lab.measured, "time", 2.0)})


def _hand(lab: Lab, late: float) -> Iterator[Case]:
    if lab.measured.timing_bias_u:
        yield lab.case("", {"time": lab.measured.time - late, "timing_bias_u": 0.0})


def _balanced(lab: Lab) -> Iterator[Case]:
    if not lab.measured.balanced:
        yield lab.case("", {"balanced": True})


def _balance_free(lab: Lab) -> Iterator[Case]:
    measured = lab.measured
    if measured.balanced or measured.balance_test is not None:
        unknown = {"balanced": None, "balance_test": None, "torque_unseen": None}
        yield lab.case("balance unknown", unknown)
    elif measured.balanced is None and measured.torque_unseen is None:
        yield lab.case('ball not balanced ("# balanced: no")', {"balanced": False})


def _without_each_weight(lab: Lab) -> Iterator[Case]:
    groups, used = lab.measured.by_torque, set(lab.kept)
    if not 1 < len(groups) <= MOST_WEIGHTS:
        return
    for number, group in enumerate(groups):
        rest = np.delete(np.arange(len(lab.measured.runs)), group).tolist()
        left_out = tuple([at for at, i in enumerate(rest) if i not in used])
        if used & set(group) and lab.measured.torque[[i for i in rest if i in used]].any():
            words = load_words(lab.measured, group[0]) if lab.measured.torque[group[0]] else "the unloaded runs"
            yield lab.case(words, measured=select(lab.measured, rest), left_out=left_out, torque=number)


# --- advice: what would make the next lab better ----------------------------------------------------------------------


def _unloaded_run(lab: Lab) -> Iterator[Case]:
    """Add a run without a weight at the middle spin, with its direction written down."""
    measured, fit = lab.measured, lab.fit
    if not measured.torque.all():
        return
    # The gain does not depend on how large M0 is; but without a residual torque the rod stands still.
    least = 0.005 * np.abs(measured.torque).min()
    torque = math.copysign(max(abs(fit.residual_torque.value), least), fit.residual_torque.value or 1.0)
    spin = float(np.sort(measured.spin)[len(measured.spin) // 2])
    turns = WATCHED * abs(physics.horizontal_precession_rate(torque, spin, fit.inertia.value)) / (2 * np.pi)
    run = {
        "time": WATCHED + fit.timing_bias.value, "turns": turns, "spin": spin, "mass": 0.0, "position": 0.0,
        "force": 0.0, "given_torque": 0.0, "torque": 0.0, "sense": math.copysign(1.0, torque), "pitch": 0.0,
    }  # fmt: skip
    # In the rest, the new run is like the last one.
    more = select(measured, [*range(len(measured.runs)), len(measured.runs) - 1])
    for name, value in run.items():
        values = getattr(more, name)
        values[-1] = np.nan if np.isnan(values).all() else value
    for one in more.sources:
        shared, touched = one.shared_by.startswith("all runs"), one.quantity in ("time", "spin", "turns", "g")
        one.groups[-1] = 0 if shared else one.groups.max() + 1 if touched else -1
        one.absolute[-1], one.relative[-1] = one.absolute.max(), one.relative.max()
    names = {"runs": (*measured.runs, "unloaded"), "lines": (*measured.lines, 0)}
    words = "one run without a weight, with the direction of its precession (column precession_sense: ccw or cw)"
    yield lab.case(words, measured=replace(more, **names))


def _each_source_halved(lab: Lab) -> Iterator[Case]:
    for share in lab.fit.budget:
        if share.share > 0.05 and share.source in SOURCES and SOURCES[share.source].better:
            adjusted = lab.fit.adjusted
            factor = np.array([0.5 if one.name == share.source else 1.0 for one in adjusted.problem.sources])
            variances = (adjusted.slopes * adjusted.problem.independent) ** 2
            # Readings with a smaller error of their own scatter less about the fit.
            smaller = np.sqrt(factor**2 @ variances / np.maximum(variances.sum(axis=0), 1e-300))
            time, fitted = lab.measured.time, lab.fit.fitted_time
            time = time - (time - fitted) * np.where(smaller > 0, 1 - smaller, 0.0)
            changed = {"sources": _scaled(lab.measured, share.source, 0.5), "time": time}
            yield lab.case(SOURCES[share.source].better, changed)


def balance_test(inertia: float) -> float:
    """Standard uncertainty of M0 [N*m] after a balance test with no more drift than `DRIFT`."""
    angle, seconds, spin = DRIFT
    return inertia * spin * angle / seconds


def _balance_test(lab: Lab) -> Iterator[Case]:
    residual_torque = lab.fit.residual_torque
    # Only if the ball can pass it, by what the runs say of M0.
    limit = 2 * math.hypot(residual_torque.u or 0.0, balance_test(lab.fit.inertia.value))
    if lab.measured.balance_test is None and abs(residual_torque.value) < limit:
        words = 'a balance test in the log, "# balance_drift: 5 deg in 60 s at 400 rpm" or better'
        yield lab.case(words, {"balance_test": balance_test})


def _three_times_the_turns(lab: Lab) -> Iterator[Case]:
    measured, off = lab.measured, lab.fit.timing_bias.value + (lab.measured.time - lab.fit.fitted_time)
    if not measured.timed:
        return
    turns = 3 * measured.turns
    # Whole turns end where they began: no mark has to be sighted.
    part = np.abs(turns - np.round(turns)) > WHOLE
    sources = tuple(
        replace(one, absolute=np.where(part, one.absolute, 0.0)) if one.name == "angle" and one.default else one
        for one in measured.sources
    )
    yield lab.case("", {"time": 3 * (measured.time - off) + off, "turns": turns, "sources": sources})


# --- digits -----------------------------------------------------------------------------------------------------------


def rounding(lab: Lab, role: str) -> tuple[Floats, float] | None:
    """Share of the rounding in the error of each reading, shape (n,), and in u(I_zz); None if the log states u.

    Both are ratios of standard uncertainties [1].
    """
    share = next((share for share in lab.fit.budget if share.source == role), None)
    source = next((source for source in lab.measured.sources if source.name == role), None)
    if lab.readings is None or share is None or source is None or not source.default:
        return None
    column, touched = lab.readings.columns.get(role), source.groups >= 0
    if column is None:
        return None
    size = np.where(touched, source.absolute + source.relative * np.abs(getattr(lab.measured, role)), 1.0)
    steps = np.array(column.steps) / math.sqrt(12)
    for i, _ in column.stated:
        steps[i] = 0.0
    # A reading may be stated as exact.
    ratio = np.divide(steps, size, out=np.zeros_like(size), where=touched & (size > 0))
    used = ratio[touched]
    return ratio, math.sqrt(used @ used / len(used)) * share.u_inertia / (lab.fit.inertia.u or 1.0)


def _one_more_digit(lab: Lab) -> Iterator[Case]:
    """Write every reading of a coarse column with one more digit, a zero."""
    for role in ("mass", "position", "time", "spin"):
        found = rounding(lab, role)
        if lab.readings is not None and found is not None and found[1] >= MOST_ROUNDING:
            column = lab.readings.columns[role]
            finer = tuple(replace(one, step=(one.step or 0.0) / 10) for one in column.readings)
            columns = {**lab.readings.columns, role: replace(column, readings=finer)}
            yield lab.case(role, measured=measure(replace(lab.readings, columns=columns)))


def _direction(lab: Lab) -> Iterator[Case]:
    """Write the direction of the runs without a weight, if M0 may have either sign without it."""
    if lab.fit.two_signs:
        yield lab.case("", {"sense": lab.fit.sense})


CHANGES = (
    Change("residual_torque", "imperfect balance", "effect", _residual_torque),
    Change("timing_bias", "timing bias of the hand", "effect", _timing_bias),
    Change("spin_decay", "falling spin, plain mean of start and end", "effect", _plain_mean_spin),
    Change("decay_law", "law by which the spin falls", "effect", _dry_friction),
    Change("tilt", "tilted rod, eq. (9) for eq. (8)", "effect", _tilt),
    Change("tachometer", "tilted rod, total spin taken for ψ̇", "effect", _tachometer),
    Change("release", "nutation after letting go", "effect", _release),
    Change("earth", "the Earth's rotation", "effect", _earth),
    Change("u_time_twice", "times twice as uncertain", "sensitivity", _times_twice_as_uncertain),
    Change("hand_late", f"times {LATE:g} s too long", "sensitivity", partial(_hand, late=LATE)),
    Change("hand_early", f"times {LATE:g} s too short", "sensitivity", partial(_hand, late=-LATE)),
    Change("balanced", 'ball balanced ("# balanced: yes")', "sensitivity", _balanced),
    Change("balance_free", "{}", "sensitivity", _balance_free),
    Change("without", "without {}", "sensitivity", _without_each_weight),
    Change("unloaded_run", "{}", "advice", _unloaded_run),
    Change("half_the_error", "{}", "advice", _each_source_halved),
    Change("balance_test", "{}", "advice", _balance_test),
    Change("three_times", "time three times as many turns of the rod in every run", "advice", _three_times_the_turns),
    Change("one_more_digit", "{}", "digits", _one_more_digit),
    Change("direction", "the direction of each run without a weight", "direction", _direction),
)  # fmt: skip
"""Every change, in the order of the tables."""
