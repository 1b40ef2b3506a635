"""What the equation of a log's model has to be corrected by.

The models are eq. (9) for a level rod, eq. (8) for a tilted one, and the mean rate of the whole motion for a rod let go
from rest; `effects` says which of them a log needs. A rod let go from rest nutates, and goes a little slower on
average; a tilted one whose spin falls has a mean rate that is not the one at the mean spin; the floor turns with the
Earth. The fit multiplies the angle of each run by `Measurements.slowing`. All of it depends on I_zz and M0 a little, so
that fit and correction are iterated together.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import Literal

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata import physics
from gyrodata.fitting.adjustment import assume_sense
from gyrodata.fitting.conditions import transverse_inertia
from gyrodata.fitting.inertia import AS_STATED, FitResult, Widths, fit
from gyrodata.measurements import SOURCES, TRANSVERSE_U, Measurements, Source
from gyrodata.physics import Floats

Model = Literal["auto", "horizontal", "steady", "released"]


class ChosenModel(Struct, frozen=True):
    """The model that a log is fitted with."""

    tilted: bool
    """Eq. (8) with each run's pitch, not eq. (9)."""
    released: bool
    """The mean rate of a rod let go from rest, not that of steady precession."""
    asked: bool
    """True if the caller chose it."""
    earth: bool = False
    """The precession against the stars, not against the turning floor."""

    @property
    def name(self) -> Literal["horizontal", "steady", "released"]:
        """Name of the model, as ``--model`` takes it."""
        if self.released:
            return "released"
        return "steady" if self.tilted else "horizontal"


OF_RELEASE = ("nutation", "release")
"""Sources of error that only a rod let go from rest has."""

MAX_ROUNDS = 20
"""The corrections and the fit agree after a few rounds."""


def unslowed(measured: Measurements) -> Measurements:
    """Give the runs as they were read, taken for steady precession at their mean spin."""
    kept = tuple(source for source in measured.sources if source.name not in OF_RELEASE)
    return replace(measured, slowing=None, sources=kept)


def slowed(
    measured: Measurements, inertia: float, residual_torque: float, tilted: bool, released: bool
) -> Measurements:
    """Compute how much slower each run is than steady precession at its mean spin, for I_zz [kg*m^2] and M0 [N*m].

    A rod that is released from rest gets its mean rate, and two more sources of error: the phase of the nutation at the
    last click, and I.
    """
    across = transverse_inertia(measured)
    total = measured.torque + residual_torque
    lean = (across, measured.pitch) if tilted else (0.0, 0.0)
    # The weight spins along.
    whole = inertia + measured.added
    with np.errstate(divide="ignore", invalid="ignore"):
        steady = physics.precession_rate(total, measured.spin, whole, *lean)
        if not released:
            return replace(measured, slowing=steady / _mean_rate_of_decay(measured, total, whole, across))
    from gyrodata import motion

    top = motion.Top(whole, across, total)
    mean = motion.mean_precession_rate(top, motion.released(top, measured.spin, measured.pitch))
    # Without any torque neither rate is above zero, and the rod stands still.
    ratio = np.divide(steady, mean, out=np.ones_like(mean), where=mean != 0)
    click = physics.click_error(measured.spin, whole, across)
    own, every = np.arange(len(total)), np.zeros(len(total), dtype=int)
    nothing = np.zeros(len(total))
    # The delay of the mean goes with the square of I.
    doubt = 2 * _transverse_u(measured) * np.abs(ratio - 1)
    more = (
        Source("nutation", "time", own, click / math.sqrt(2), nothing, "", True, "its phase at the last click"),
        Source("release", "turns", every, nothing, doubt, "all runs", True, "the doubt about I in the mean rate"),
    )
    return replace(measured, slowing=ratio, sources=(*measured.sources, *more))


def _transverse_u(measured: Measurements) -> float:
    """Relative standard uncertainty of I [1]."""
    stated = (float(source.relative.max()) for source in measured.sources if source.quantity == "transverse")
    # A log that says neither pitch nor "released" has no such source, though it may give I.
    given = measured.transverse_inertia is not None
    return next(stated, SOURCES["transverse_inertia"].default.relative if given else TRANSVERSE_U)


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


def is_corrected(measured: Measurements, chosen: ChosenModel) -> bool:
    """Say whether a model corrects the runs by what their fit gives."""
    return chosen.earth or is_unsteady(measured, chosen)


def is_unsteady(measured: Measurements, chosen: ChosenModel) -> bool:
    """Say whether a model's rate is not that of steady precession at one spin."""
    return chosen.released or (chosen.tilted and measured.spin_start is not None)


def corrected(measured: Measurements, near: FitResult, chosen: ChosenModel) -> Measurements:
    """Correct the runs for a model, with the I_zz and M0 of a fit of them."""
    inertia, residual_torque = near.inertia.value, near.residual_torque.value
    runs = measured
    if is_unsteady(measured, chosen):
        runs = slowed(measured, inertia, residual_torque, chosen.tilted, chosen.released)
    if chosen.earth:
        # The floor turns while a run is timed: count its angle against the stars.
        steady = 1.0 if runs.slowing is None else runs.slowing
        return replace(runs, slowing=steady * (1 + turn_of_floor(measured, residual_torque)))
    return runs


def turn_of_floor(measured: Measurements, residual_torque: float) -> Floats:
    """Angle that the floor turns by while a run is timed, over that of the run; at a pole without a latitude."""
    vertical = physics.EARTH_ROTATION * math.sin(math.pi / 2 if measured.latitude is None else measured.latitude)
    # Seen from above, counterclockwise is +1.
    usual = assume_sense(measured, math.copysign(1.0, residual_torque))
    sense = usual if measured.precession_sense is None else measured.precession_sense
    return np.where(sense == 0, usual, sense) * vertical * measured.time / (2 * np.pi * measured.turns)


def earth_is_told(measured: Measurements) -> bool:
    """Say whether the log gives the latitude, and which way each run went: then the Earth can be corrected for."""
    return (
        measured.latitude is not None
        and measured.precession_sense is not None
        and bool(measured.precession_sense.all())
    )


def fit_model(
    measured: Measurements,
    chosen: ChosenModel,
    left_out: Collection[int] = (),
    widths: Widths | None = None,
    near: FitResult | None = None,
) -> tuple[Measurements, FitResult]:
    """Fit a log with a model: correct the runs by what the fit gives, until both agree.

    Parameters
    ----------
    measured : Measurements
        The runs; earlier corrections are removed first.
    chosen : ChosenModel
        The model.
    left_out, widths, near
        As for `fit`.

    Returns
    -------
    Measurements
        The corrected runs; of a released rod, with two more sources of error.
    FitResult

    Raises
    ------
    NoFit
        If there is no solution.
    """
    runs = unslowed(measured)

    def fitted(widths: Widths | None) -> FitResult:
        return fit(runs, widths, tilted=chosen.tilted, left_out=left_out, near=near)

    if not is_corrected(runs, chosen):
        return runs, fitted(widths)
    bare, on_the_way = runs, AS_STATED if near is None else near.widths
    result, close = (fitted(AS_STATED), 1e-10) if near is None else (near, 1e-7)
    for _round in range(MAX_ROUNDS):
        before, runs = runs.slowing, corrected(bare, result, chosen)
        result = fitted(on_the_way)
        if before is not None and runs.slowing is not None and np.allclose(before, runs.slowing, rtol=close, atol=0):
            break
    return runs, result if widths == on_the_way else fitted(widths)
