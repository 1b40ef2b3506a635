"""What a log still lacks against the lab's procedure, each with its reason in numbers.

The procedure: at least three weights, each with at least three well-spread spins; one run without a weight; times
over 6 s; the spin at start and end where it falls much. Meant to be asked before leaving the lab.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from gyrodata import diagnostics as codes
from gyrodata import effects, physics
from gyrodata.analysis import analyze_readings
from gyrodata.errors import Diagnostic, LogError
from gyrodata.findings import DIRECTION, WORTH
from gyrodata.measurements import Measurements, measure, torque_groups
from gyrodata.physics import RPM, Floats
from gyrodata.readings import TIMINGS, Place, Readings
from gyrodata.results import Analysis
from gyrodata.tables import load_words

SHORT = 6.0
"""A time below this [s] is short for a hand that is wrong by 0.14 s: over 2 %."""

SPREAD = 2.0
"""Ratio of the largest to the smallest spin of a weight below which its spins are not well spread."""

FALL = 0.10
"""Relative fall of the spin above which the law by which it falls begins to matter."""


def check_log(readings: Readings) -> tuple[Analysis | None, tuple[Diagnostic, ...]]:
    """Analyse a log and find what it lacks: the analysis, None if the log has no answer, and all diagnostics.

    Doubts are in the analysis.
    """
    try:
        analysis = analyze_readings(readings)
    except LogError as error:
        measured = measure(readings) if readings.ok else None
        lacking = what_lacks(readings, measured, None) if measured is not None and measured.torque.any() else []
        return None, (*error.diagnostics, *lacking)
    return analysis, (*analysis.diagnostics, *what_lacks(readings, analysis.measurements, analysis))


PROCEDURE = (
    codes.TOO_FEW_WEIGHTS,
    codes.TOO_FEW_RUNS,
    codes.SPINS_TOO_CLOSE,
    codes.NO_UNLOADED_RUN,
    codes.TIMES_TOO_SHORT,
    codes.SPIN_FALLS_TOO_MUCH,
)
"""What the procedure asks for, by the diagnostic of a log that lacks it."""

ADVICE = {*PROCEDURE, codes.DIGITS_TOO_FEW, codes.DIRECTION_MISSING, codes.SINGLE_TORQUE, codes.RELEASE_NOT_TOLD}
"""Diagnostics that say how to measure better; the answer is correct without them."""


def what_lacks(
    readings: Readings, measured: Measurements, analysis: Analysis | None, asked: Collection[str] = PROCEDURE
) -> list[Diagnostic]:
    """Find what a log lacks of what is asked for, of `PROCEDURE`; without an analysis, what needs none."""
    groups = [group for group in torque_groups(measured) if measured.torque[group[0]] != 0]
    found = [*_weights(readings, measured, groups), *_spins(readings, measured, groups)]
    if analysis and codes.NO_UNLOADED_RUN in asked:
        found += _unloaded(readings, analysis)
    found += [*_short_times(readings, measured), *_falling_spin(readings, measured)]
    return [one for one in found if one.code in asked]


def _weights(readings: Readings, measured: Measurements, groups: list[list[int]]) -> list[Diagnostic]:
    if len(groups) >= 3:
        return []
    torques = " and ".join(f"{1e3 * measured.torque[group[0]]:.3g}" for group in groups)
    why = "I_zz then rests on one point of the line" if len(groups) == 1 else "a line through two points fits always"
    return [
        readings.diagnose(
            codes.TOO_FEW_WEIGHTS,
            f"{_counted(len(groups), 'torque')} ({torques} mN·m), and the lab asks for three: {why}",
            "add runs with another weight",
        )
    ]


def _spins(readings: Readings, measured: Measurements, groups: list[list[int]]) -> list[Diagnostic]:
    found = []
    for group in groups:
        name = load_words(measured, group[0])
        spins = np.sort(measured.spin[group])
        if len(group) < 3:
            found.append(
                readings.diagnose(
                    codes.TOO_FEW_RUNS,
                    f"{name}: {_counted(len(group), 'run')}, and the lab asks for three spins",
                    f"add {_counted(3 - len(group), 'run')}, for example at {_missing_spins(spins)} rpm",
                    _place(readings, group[-1]),
                )
            )
        elif spins[-1] < SPREAD * spins[0]:
            low, high = spins[0] / RPM, spins[-1] / RPM
            found.append(
                readings.diagnose(
                    codes.SPINS_TOO_CLOSE,
                    f"{name}: the spins go from {low:.0f} to {high:.0f} rpm only, a factor of {high / low:.2f}: "
                    "that tells little of how the period goes with the spin",
                    "spread them, for example 200, 400 and 600 rpm",
                    _place(readings, group[-1]),
                )
            )
    return found


def _missing_spins(spins: Floats) -> str:
    """Which of 200, 400 and 600 rpm is farthest from all spins so far."""
    have = spins / RPM
    wanted = sorted((200.0, 400.0, 600.0), key=lambda rpm: -np.min(np.abs(np.log(rpm / have))))
    return " and ".join(f"{rpm:.0f}" for rpm in sorted(wanted[: 3 - len(have)]))


def _unloaded(readings: Readings, analysis: Analysis) -> list[Diagnostic]:
    signs = set(np.sign(analysis.measurements.torque).tolist())
    if 0.0 in signs or len(signs) > 1 or readings.unmoved:
        return []
    outcome = next(effects.answers(analysis.lab, "unloaded_run"), None)
    if outcome is None or outcome.inertia is None:
        return []
    now, then = (100 * (one.u or 0.0) / one.value for one in (analysis.fit.inertia, outcome.inertia))
    if then > WORTH * now:
        return []
    return [
        readings.diagnose(
            codes.NO_UNLOADED_RUN,
            "no run without a weight: u of I_zz is "
            f"{now:.2g} % and would be {then:.2g} % with one, because it tells the residual torque",
            "take the weight off, spin to about 400 rpm, and time a part of a turn (about 3 min), or 0 turns if the "
            f"rod does not move. Watch which way it goes: {DIRECTION}",
        )
    ]


def _short_times(readings: Readings, measured: Measurements) -> list[Diagnostic]:
    short = np.flatnonzero(measured.time < SHORT)
    if not measured.timed or not len(short):
        return []
    worst = int(short[np.argmin(measured.time[short])])
    runs = ", ".join(measured.runs[i] for i in short[:8]) + (", …" if len(short) > 8 else "")
    return [
        readings.diagnose(
            codes.TIMES_TOO_SHORT,
            f"{_counted(len(short), 'time')} under {SHORT:g} s (run{'s' if len(short) > 1 else ''} {runs}): in the "
            f"shortest, {measured.time[worst]:.3g} s, a hand's 0.14 s is {100 * 0.14 / measured.time[worst]:.2g} %",
            "time more of a turn, or a whole one",
            _place(readings, worst),
        )
    ]


def _falling_spin(readings: Readings, measured: Measurements) -> list[Diagnostic]:
    if measured.spin_start is None or measured.spin_end is None:
        return []
    fall = 1 - measured.spin_end / measured.spin_start
    far = np.flatnonzero(fall > FALL)
    if not len(far):
        return []
    worst = int(far[np.argmax(fall[far])])
    doubt = float(np.abs(physics.decay_law_doubt(measured.spin_start[worst], measured.spin_end[worst])))
    runs = ", ".join(measured.runs[i] for i in far[:8]) + (", …" if len(far) > 8 else "")
    return [
        readings.diagnose(
            codes.SPIN_FALLS_TOO_MUCH,
            f"the spin falls by more than 10 % in run{'s' if len(far) > 1 else ''} {runs}; "
            f"by {100 * fall[worst]:.0f} % in run {measured.runs[worst]}, where the law by which "
            f"it falls then moves I_zz by {100 * doubt:.2g} %",
            "time a shorter part of a turn",
            _place(readings, worst),
        )
    ]


def _place(readings: Readings, index: int) -> Place | None:
    return next(readings.columns[role].place(index) for role in TIMINGS if role in readings.columns)


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
