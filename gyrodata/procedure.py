"""Steps of the lab procedure that are missing in a log, each with its reason in numbers.

The procedure: at least three weights, each with at least three well-spread spins; one run without a weight; times
over 6 s; the spin at start and end if it falls much. Students should check this before they leave the lab.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator

import numpy as np

from gyrodata import diagnostics as codes
from gyrodata import effects, physics
from gyrodata.analysis import analyze_readings
from gyrodata.errors import Diagnostic, LogError
from gyrodata.findings import DIRECTION, WORTH, percent_u, place_of
from gyrodata.measurements import Measurements, measure, torque_groups
from gyrodata.physics import RPM, Integers
from gyrodata.readings import Readings
from gyrodata.results import Analysis
from gyrodata.tables import load_words

SHORT = 6.0
"""A time below this [s] is short: the usual error of a hand, 0.14 s, is over 2 % of it."""

SPREAD = 2.0
"""The spins of a weight are well spread if the largest is at least this many times the smallest."""

USUAL_SPINS = np.array([200.0, 400.0, 600.0])
"""Spins that the procedure asks for [rpm]."""

FALL = 0.10
"""If the spin falls by more than this part, the decay law matters."""


def check_log(readings: Readings) -> tuple[Analysis | None, tuple[Diagnostic, ...]]:
    """Analyse a log and list what is missing: the analysis, or None if the log has no answer, and all diagnostics."""
    try:
        analysis = analyze_readings(readings)
    except LogError as error:
        measured = measure(readings) if readings.ok else None
        lacking = what_lacks(readings, measured, None) if measured is not None and measured.torque.any() else []
        return None, (*error.diagnostics, *lacking)
    return analysis, (*analysis.diagnostics, *what_lacks(readings, analysis.measurements, analysis))


PROCEDURE = (
    codes.TOO_FEW_WEIGHTS, codes.TOO_FEW_RUNS, codes.SPINS_TOO_CLOSE, codes.NO_UNLOADED_RUN, codes.TIMES_TOO_SHORT,
    codes.SPIN_FALLS_TOO_MUCH,
)  # fmt: skip
"""Steps of the procedure, each as the diagnostic that reports a missing step."""

ADVICE = {*PROCEDURE, codes.DIGITS_TOO_FEW, codes.DIRECTION_MISSING, codes.SINGLE_TORQUE, codes.RELEASE_NOT_TOLD}
"""Diagnostics about better measurements; the answer is correct without them."""


def what_lacks(
    readings: Readings, measured: Measurements, analysis: Analysis | None, asked: Collection[str] = PROCEDURE
) -> list[Diagnostic]:
    """List the missing steps among those asked for; without an analysis, only those that need none."""
    found = list(_weights_and_spins(readings, measured))
    if analysis and codes.NO_UNLOADED_RUN in asked:
        found += _unloaded(readings, analysis)
    found += _times_and_falls(readings, measured)
    return [one for one in found if one.code in asked]


def _weights_and_spins(readings: Readings, measured: Measurements) -> Iterator[Diagnostic]:
    """Ask for three weights, and for three spins of each that are far enough apart."""
    groups = [group for group in torque_groups(measured) if measured.torque[group[0]] != 0]
    if len(groups) < 3:
        torques = " and ".join(f"{1e3 * measured.torque[group[0]]:.3g}" for group in groups)
        one = len(groups) == 1
        why = "one point does not determine a line" if one else "a line through two points always fits"
        words = f"{_counted(len(groups), 'torque')} ({torques} mN·m), and the lab sheet asks for three: {why}"
        yield readings.diagnose(codes.TOO_FEW_WEIGHTS, words, "add runs with another weight")
    for group in groups:
        name, place = load_words(measured, group[0]), place_of(readings, group[-1])
        spins, lacking = np.sort(measured.spin[group]), 3 - len(group)
        have = spins / RPM
        if lacking > 0:
            # The usual spins that differ most from the spins so far.
            away = np.abs(np.log(USUAL_SPINS[:, None] / have)).min(axis=1)
            wanted = np.sort(USUAL_SPINS[np.argsort(-away, kind="stable")[:lacking]])
            words = f"{name}: {_counted(len(group), 'run')}, and the lab sheet asks for three spins"
            hint = f"add {_counted(lacking, 'run')}, for example at {' and '.join(f'{rpm:.0f}' for rpm in wanted)} rpm"
            yield readings.diagnose(codes.TOO_FEW_RUNS, words, hint, place)
        elif spins[-1] < SPREAD * spins[0]:
            only = f"from {have[0]:.0f} to {have[-1]:.0f} rpm only, a factor of {have[-1] / have[0]:.2f}"
            words = f"{name}: the spins go {only}, which is too narrow to show how the period depends on the spin"
            hint = "spread them, for example 200, 400 and 600 rpm"
            yield readings.diagnose(codes.SPINS_TOO_CLOSE, words, hint, place)


def _unloaded(readings: Readings, analysis: Analysis) -> Iterator[Diagnostic]:
    """Ask for a run without a weight, if u of I_zz would be smaller with one."""
    signs = set(np.sign(analysis.measurements.torque).tolist())
    if 0.0 in signs or len(signs) > 1 or readings.unmoved:
        return
    now = percent_u(analysis.fit.inertia)
    inertia = next((outcome.inertia for outcome in effects.answers(analysis.lab, "unloaded_run")), None)
    if inertia is not None and (then := percent_u(inertia)) <= WORTH * now:
        gain = f"u of I_zz from {now:.2g} % to {then:.2g} %, because it measures the residual torque M0"
        words = f"no run without a weight: adding one would reduce {gain}"
        hint = (
            "remove the weight, spin to about 400 rpm, and time a part of a turn (about 3 min), or write 0 turns if "
            f"the rod does not move. Note the direction: {DIRECTION}"
        )
        yield readings.diagnose(codes.NO_UNLOADED_RUN, words, hint)


def _times_and_falls(readings: Readings, measured: Measurements) -> Iterator[Diagnostic]:
    """Ask for longer times, and for shorter ones if the spin falls much."""
    short = np.flatnonzero(measured.time < SHORT)
    if measured.timed and len(short):
        worst = int(short[np.argmin(measured.time[short])])
        time = measured.time[worst]
        hand = f"in the shortest, {time:.3g} s, the 0.14 s of a hand are {100 * 0.14 / time:.2g} %"
        words = f"{_counted(len(short), 'time')} under {SHORT:g} s ({_named(measured, short)}): {hand}"
        hint, place = "time more of a turn, or a whole one", place_of(readings, worst)
        yield readings.diagnose(codes.TIMES_TOO_SHORT, words, hint, place)
    if measured.spin_start is None or measured.spin_end is None:
        return
    fall = 1 - measured.spin_end / measured.spin_start
    far = np.flatnonzero(fall > FALL)
    if len(far):
        worst = int(far[np.argmax(fall[far])])
        doubt = float(np.abs(physics.decay_law_doubt(measured.spin_start[worst], measured.spin_end[worst])))
        most = f"by {100 * fall[worst]:.0f} % in run {measured.runs[worst]}"
        law = f"where the unknown decay law changes I_zz by {100 * doubt:.2g} %"
        words = f"the spin falls by more than 10 % in {_named(measured, far)}; {most}, {law}"
        place = place_of(readings, worst)
        yield readings.diagnose(codes.SPIN_FALLS_TOO_MUCH, words, "time a shorter part of a turn", place)


def _named(measured: Measurements, indices: Integers) -> str:
    """Return the names of runs: "runs 2, 5"."""
    names = ", ".join(measured.runs[i] for i in indices[:8]) + (", …" if len(indices) > 8 else "")
    return f"run{'s' if len(indices) > 1 else ''} {names}"


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
