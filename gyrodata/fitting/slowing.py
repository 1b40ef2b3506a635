"""How much slower runs go than in steady precession at one spin: let go from rest, the spin falling, the Earth turning.

The fit multiplies the angle of each run by `Measurements.slowing`. All of it depends on I_zz and M0 a little, so that
whoever corrects for it does so again with the fit that comes out.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gyrodata import physics
from gyrodata.fitting.conditions import transverse_inertia
from gyrodata.fitting.estimates import FitResult
from gyrodata.measurements import TRANSVERSE_U, Measurements, Source
from gyrodata.physics import Floats

OF_RELEASE = ("nutation", "release")
"""Sources of error that only a rod let go from rest has."""


def unslowed(measured: Measurements) -> Measurements:
    """Give the runs as they were read, taken for steady precession at their mean spin."""
    kept = tuple(source for source in measured.sources if source.name not in OF_RELEASE)
    return replace(measured, slowing=None, sources=kept)


def slowed(
    measured: Measurements, fit: FitResult, inertia: float, tilted: bool, released: bool, followed: bool = False
) -> Measurements:
    """Work out how much slower each run is than steady precession at its mean spin, for an I_zz [kg*m^2].

    A rod let go from rest gets its mean rate, and two more sources of error: the phase of the nutation at the last
    click, and I. With `followed` it is followed exactly from the start of the clock to the last click. Where the phase
    has a standard uncertainty σ, the most likely delay is e^(−σ²/2) of the computed one, and what is left of it is
    spread as (1 − e^(−σ²))/(2 ω_n²).
    """
    across = transverse_inertia(measured)
    total = measured.torque + fit.imbalance.value
    lean = (across, measured.pitch) if tilted else (0.0, 0.0)
    # The weight spins along.
    whole = inertia + measured.added
    with np.errstate(divide="ignore", invalid="ignore"):
        steady = physics.precession_rate(total, measured.spin, whole, *lean)
        if not released:
            return replace(measured, slowing=steady / _mean_rate_of_decay(measured, total, whole, across))
    from gyrodata import motion

    top = motion.Top(whole, across, total)
    state = motion.released(top, measured.spin, measured.pitch)
    mean = motion.mean_precession_rate(top, state)
    ratio = steady / mean
    known = np.zeros(len(total))
    if followed:
        known = phase_known(measured, whole)
        angle = np.sign(mean) * 2 * np.pi * measured.turns
        # What the rod has swept by the time that was read, not the time that the count would take: the phase is
        # then free of the torque.
        time = measured.time - fit.timing_bias.value
        ahead = motion.precession_angle(top, state, time) - mean * time
        ratio = ratio - known * ahead * steady / (mean * angle)
    click = physics.click_error(measured.spin, whole, across)
    own, every = tuple(range(len(total))), (0,) * len(total)
    nothing = np.zeros(len(total))
    spread = click * np.sqrt((1 - known**2) / 2)
    # The delay of the mean goes with the square of I.
    doubt = 2 * _transverse_u(measured) * np.abs(steady / mean - 1)
    more = (
        Source("nutation", "time", own, spread, nothing, "", True, "its phase at the last click"),
        Source("release", "turns", every, nothing, doubt, "all runs", True, "the doubt about I in the mean rate"),
    )
    return replace(measured, slowing=ratio, sources=(*measured.sources, *more))


def against_stars(measured: Measurements, sense: Floats, vertical_rate: float) -> Measurements:
    """Count each run's angle against the stars: the floor turns by Ω sin(latitude) [rad/s] while it is timed.

    `sense` is that of the precession seen from above, +1 for counter-clockwise, shape (n,).
    """
    share = sense * vertical_rate * measured.time / (2 * np.pi * measured.turns)
    return replace(measured, slowing=(1.0 if measured.slowing is None else measured.slowing) * (1 + share))


def phase_known(measured: Measurements, inertia: Floats | float) -> Floats:
    """How well the phase of the nutation at the last click is known, 0 to 1: e^(−σ²/2) of its uncertainty σ [rad]."""
    click = physics.click_error(measured.spin, inertia, transverse_inertia(measured))
    own = sum((s.relative**2 for s in measured.sources if s.quantity == "spin"), start=np.zeros(len(measured.runs)))
    known: Floats = np.exp(-0.5 * (measured.time / click) ** 2 * (_transverse_u(measured) ** 2 + own))
    return known


def _transverse_u(measured: Measurements) -> float:
    """Relative standard uncertainty of I [1]."""
    stated = (float(source.relative.max()) for source in measured.sources if source.quantity == "transverse")
    return next(stated, TRANSVERSE_U)


def _mean_rate_of_decay(measured: Measurements, total: Floats, inertia: Floats | float, across: Floats) -> Floats:
    """Mean of eq. (8)'s rate over a viscous fall of the spin [rad/s], by Gauss-Legendre in time."""
    assert measured.spin_start is not None
    assert measured.spin_end is not None
    points, weights = np.polynomial.legendre.leggauss(8)
    decay = np.log(measured.spin_end / measured.spin_start)
    spins = measured.spin_start * np.exp(0.5 * (points[:, None] + 1) * decay)
    # What is read at half time too has another harmonic mean than a viscous fall.
    spins *= measured.spin / physics.harmonic_mean_spin(measured.spin_start, measured.spin_end)
    rates = physics.precession_rate(total, spins, inertia, across, measured.pitch)
    return np.asarray(0.5 * weights @ rates)
