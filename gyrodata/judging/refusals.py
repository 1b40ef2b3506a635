"""The reasons why a log has no answer.

They are wrong counts of turns, a rod that falls, no common I_zz, or a useless interval.
"""

from __future__ import annotations

import math

import numpy as np

from gyrodata import fitting, physics
from gyrodata.base.errors import Diagnostic
from gyrodata.fitting import FitResult
from gyrodata.judging.tables import load_words
from gyrodata.measurements import Measurements, select
from gyrodata.physics import RPM, Floats
from gyrodata.physics.models import FALLEN, RELEASED, STEEP, Motion, conserved_spin
from gyrodata.physics.motion import Top
from gyrodata.readings import Readings
from gyrodata.readings.lablog import listing


def fall_findings(readings: Readings, measured: Measurements) -> list[Diagnostic]:
    """Name the released run with the largest sag, if the sag is too large for a fit."""
    loaded = select(measured, np.flatnonzero(measured.torque).tolist())
    runs = fitting.timed_runs(loaded)
    of_run = loaded.single_inertia
    # If a rod falls far, eq. (9) gives a too large I_zz, and therefore a too small sag.
    # The mean rate of the exact motion gives a better one. If no I_zz agrees, it would
    # become smaller without limit.
    inertia = of_run
    for _round in range(8):
        slowing, _ = Motion((RELEASED,)).correction(_tops(loaded, inertia), runs)
        inertia = np.fmax(of_run / slowing, of_run / 10)
    usual = fitting.median(inertia)
    top = _tops(loaded, np.full(len(of_run), usual))
    spin = conserved_spin(top, runs)
    across = top.transverse_inertia
    sag = physics.sag_size(top.torque, spin, usual, across, loaded.pitch)
    # An I that is far from I_zz shows a wrong unit, which `refusal` names.
    ratio = fitting.transverse_inertia(loaded) / fitting.rough_inertia(loaded)
    if sag.max() < FALLEN or ratio.min() < 1 / 3 or ratio.max() > 10:
        return []
    worst = int(sag.argmax())
    spins = physics.spin_of_sag(STEEP, top.torque, usual, across, loaded.pitch)
    least = float(spins[worst]) / RPM
    with_weight = np.flatnonzero(measured.torque).tolist()
    place = readings.place(with_weight[worst])
    values = {
        "spin": spin[worst] / RPM,
        "sag": math.degrees(sag[worst]),
        "least": 5 * math.ceil(least / 5),
    }
    run = loaded.runs[worst]
    load = load_words(loaded, worst)
    return [readings.say("release_falls", place, run=run, load=load, **values)]


def _tops(measured: Measurements, inertia: Floats) -> Top:
    """Return the tops of runs with this I_zz and without a residual torque."""
    transverse = measured.transverse_inertia
    if transverse is None:
        load = np.nan_to_num(measured.mass * measured.position**2)
        transverse = fitting.DEFAULT_TRANSVERSE_RATIO * inertia + load
    return Top(inertia=inertia, transverse_inertia=transverse, torque=measured.torque)


def refusal(
    readings: Readings, measured: Measurements, why: str, keep_flagged: bool
) -> Diagnostic:
    """Make the error of a log without an answer: the reason, and what to check."""
    if keep_flagged:
        return readings.say("no_inertia_with_flagged", why=why)
    groups = [group for group in measured.by_torque if measured.torque[group[0]]]
    of_run = measured.single_inertia
    low = of_run[of_run > 0].min()
    high = of_run.max()
    across = np.median(fitting.transverse_inertia(measured))
    is_stated = measured.transverse_inertia is not None
    if is_stated and not low / 3 < across < 10 * high:
        return readings.say(
            "no_inertia_with_transverse", why=why, across=across, low=low, high=high
        )
    if high < 1.5 * low:
        return readings.say(
            "no_inertia_with_uncertainties", why=why, low=low, high=high
        )
    each = [
        f"{load_words(measured, group[0])}: {_range_text(of_run[group])}"
        for group in groups
    ]
    clock = RUNNING_CLOCK * _times_grow(measured)
    shown = listing(each, 6)
    return readings.say("no_inertia_fits", why=why, clock=clock, each=shown)


def _range_text(values: Floats) -> str:
    """Write the lowest and the highest value, or one number if they are the same."""
    low = f"{values.min():.2g}"
    high = f"{values.max():.2g}"
    return low if low == high else f"{low} to {high}"


RUNNING_CLOCK = (
    "each time is longer than the one before it: if the clock was not set to zero "
    "between the runs, write the differences; "
)


def _times_grow(measured: Measurements) -> bool:
    """Return whether each of several times is longer than the one before it."""
    is_growing = bool((np.diff(measured.time) > 0).all())
    return measured.timed and is_growing and len(measured.runs) >= TELLING


TELLING = 4
"""So few times can grow by chance."""


def not_measured(
    readings: Readings, fit: FitResult, low: float, high: float
) -> Diagnostic:
    """Make the error of a log whose interval of I_zz [kg*m^2] is not usable.

    The interval includes zero, or is nearly as wide as I_zz.
    """
    widest = fit.budget[0].source if fit.budget else "time"
    names = {
        "residual_torque": "not_measured_for_m0",
        "unexplained_scatter": "not_measured_for_scatter",
    }
    fault = "includes zero" if low <= 0 else "is too wide"
    name = names.get(widest, "not_measured")
    return readings.say(name, low=low, high=high, fault=fault, widest=widest)
