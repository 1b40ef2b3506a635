"""A spin that falls while it is timed: the mean that eq. (9) needs, and what another mean does to I_zz.

Drag is ψ̈ = −c ψ̇^p: p = 0 dry friction, p = 1 viscous (an air film), p = 2 turbulent. The angle precessed is
∫ M/(I_zz ψ̇) dt, so the mean that belongs in eq. (9) is the harmonic one in time. With start a, end b,
d = ln(a/b), the geometric mean G = √(ab) and sinhc(x) = sinh(x)/x it is G sinhc((1 − p)d/2)/sinhc(p d/2).
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from gyrodata.physics.tilt import tilt_bias

VISCOUS = 1.0
"""Exponent of the drag of an air film."""

SpinRule = Literal["start", "half_time", "arithmetic", "geometric", "logarithmic", "viscous"]
"""A spin that may be put into eq. (9); "viscous" is the harmonic mean in time for p = 1."""


def _sinhc(x: Any) -> Any:
    """sinh(x)/x; its series where that is 0/0."""
    near = np.abs(x) < 1e-4
    safe = np.where(near, 1.0, x)
    return np.where(near, 1 + x * x / 6, np.sinh(safe) / safe)[()]


def harmonic_mean_spin(start: ArrayLike, end: ArrayLike, exponent: ArrayLike = VISCOUS) -> Any:
    """Mean in time of a decaying spin, as eq. (9) needs it: the harmonic one.

    Parameters
    ----------
    start, end : array_like
        Spin at the start and the end of the interval [rad/s], of equal sign, not zero.
    exponent : array_like
        Exponent p of the drag [1]; viscous unless given.

    Returns
    -------
    ndarray or float
        Mean spin [rad/s]: G²/L for viscous drag, with the geometric mean G and the logarithmic mean L of both
        readings; G for p = 1/2; L for dry friction; 2ab/(a + b) for p = 2.

    Notes
    -----
    The law hardly matters for a small decay: mean/G = 1 + (1 − 2p) d²/24 + …, see `decay_law_doubt`.
    """
    half = np.log(np.divide(start, end)) / 2
    share = np.multiply(exponent, half)
    return np.multiply(start, np.exp(-half)) * _sinhc(half - share) / _sinhc(share)


def harmonic_mean_spin_slopes(start: ArrayLike, end: ArrayLike) -> tuple[Any, Any]:
    """Derivatives of `harmonic_mean_spin`, for viscous drag, with respect to the start and the end.

    Parameters
    ----------
    start, end : array_like
        Spin at the start and the end of the interval [rad/s].

    Returns
    -------
    tuple of two ndarray or float
        Derivatives [1]; both 1/2 where the spin does not change. They satisfy
        start·s₁ + end·s₂ = mean, because the mean scales with the readings.
    """
    start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    decay = np.log(start / end)
    # f(d) = d/(e^d − 1); mean = start f(d); f' is a difference of near-equal numbers below |d| ~ 1e-3.
    near = np.abs(decay) < 1e-3
    safe = np.where(near, 1.0, decay)
    value = np.where(near, 1 - decay / 2 + decay**2 / 12, safe / np.expm1(safe))
    slope = np.where(
        near,
        -0.5 + decay / 6 - decay**3 / 180,
        (np.expm1(safe) - safe * np.exp(safe)) / np.expm1(safe) ** 2,
    )
    return value + slope, -slope * start / end


def drag_exponent(start: ArrayLike, half: ArrayLike, end: ArrayLike) -> Any:
    """Exponent p of the drag law that three readings of the spin lie on.

    Parameters
    ----------
    start, half, end : array_like
        Spin at the start, at half time and at the end [rad/s], of equal sign, not zero.

    Returns
    -------
    ndarray or float
        p [1]; NaN where the spin did not change, or where the middle reading does not lie between the others.

    Notes
    -----
    At half time half^(1−p) is the mean of start^(1−p) and end^(1−p). Badly determined by small decays: a
    relative error r of the middle reading moves p by 8 r/d², which is 1.4 for 0.2 % and a fall of 10 %.
    """
    decay = np.log(np.divide(start, end))
    with np.errstate(divide="ignore", invalid="ignore"):
        return 1 - 2 * _power_argument(start, half, end) / decay


def harmonic_mean_spin_of_three(start: ArrayLike, half: ArrayLike, end: ArrayLike) -> Any:
    """Harmonic mean in time of a spin read at the start, at half time and at the end, whatever the drag law.

    Parameters
    ----------
    start, half, end : array_like
        As for `drag_exponent`.

    Returns
    -------
    ndarray or float
        Mean spin [rad/s], exact for the law ψ̈ = −c ψ̇^p that passes through all three. The common value where
        they are equal; NaN where the middle one does not lie between the others.
    """
    quarter = np.log(np.divide(start, end)) / 2
    argument = np.where(np.equal(start, end) & np.equal(start, half), 0.0, _power_argument(start, half, end))
    return np.multiply(start, np.exp(-quarter)) * _sinhc(argument) / _sinhc(quarter - argument)


def simpson_mean_spin(start: ArrayLike, half: ArrayLike, end: ArrayLike) -> Any:
    """Harmonic mean in time of a spin read at the start, at half time and at the end, by Simpson's rule for 1/ψ̇.

    Parameters
    ----------
    start, half, end : array_like
        As for `drag_exponent`.

    Returns
    -------
    ndarray or float
        Mean spin [rad/s]; smooth in the readings, so that their noise does no harm where the spin hardly falls.

    Notes
    -----
    6/(1/start + 4/half + 1/end); for a viscous decay low by d⁴/2880 of itself with d = ln(start/end), which is
    8e-5 for a spin that falls by half, and as good for any other smooth decay.
    """
    return 6 / (np.divide(1, start) + np.divide(4, half) + np.divide(1, end))


def _power_argument(start: ArrayLike, half: ArrayLike, end: ArrayLike) -> Any:
    """Give y = (1 − p)d/2, by which ln(half/G) = (d/2) ln(cosh y)/y; NaN where there is none."""
    decay = np.log(np.divide(start, end))
    with np.errstate(divide="ignore", invalid="ignore"):
        level = (np.log(np.divide(half, start)) + np.log(np.divide(half, end))) / decay
    size = np.abs(level)
    valid = size < 1
    target = np.where(valid, size, 0.0)
    # ln(cosh y)/y is y/2 for small y and 1 − ln2/y for large, and lies below both curves' inverses: between
    # these bounds Newton's steps settle.
    low, high = 2 * target, np.log(2) / (1 - target)
    y = low / (1 - target) * (1 - (1 - np.log(2) / 2) * target)
    for _ in range(8):
        safe = np.where(y == 0, 1.0, y)
        value = _log_cosh(safe) / safe
        slope = np.where(safe < 1e-3, 0.5, (np.tanh(safe) - value) / safe)
        y = np.clip(np.where(y == 0, 0.0, y - (value - target) / slope), low, high)
    return np.where(valid, np.copysign(y, level), np.nan)[()]


def _log_cosh(y: Any) -> Any:
    """ln(cosh y), accurate for small and finite for large y >= 0."""
    small = np.minimum(y, 1.0)
    return np.where(y < 1, np.log1p(2 * np.sinh(small / 2) ** 2), y + np.log1p(np.exp(-2 * y)) - np.log(2))


def mean_spin_bias(start: ArrayLike, end: ArrayLike, rule: SpinRule, exponent: ArrayLike = VISCOUS) -> Any:
    """Relative bias of I_zz when a spin by `rule` stands in the place of the harmonic mean in time.

    Parameters
    ----------
    start, end : array_like
        Spin at the start and the end [rad/s], of equal sign, not zero.
    rule : {"start", "half_time", "arithmetic", "geometric", "logarithmic", "viscous"}
        Which spin is used: the reading at the start or at half time, or a mean of start and end.
    exponent : array_like
        Exponent p of the drag by which the spin really falls [1].

    Returns
    -------
    ndarray or float
        I_zz estimated over true, minus 1; exact. To lowest order, in units of d²/24: half time p − 2, arithmetic
        −2 − 2p, geometric 1 − 2p, logarithmic −2p, viscous 2 − 2p. The start alone: −d/2.
    """
    return harmonic_mean_spin(start, end, exponent) / _spin_by(rule, start, end, exponent) - 1


def _spin_by(rule: SpinRule, start: ArrayLike, end: ArrayLike, exponent: ArrayLike) -> Any:
    decay = np.log(np.divide(start, end))
    middle = np.multiply(start, np.exp(-decay / 2))
    match rule:
        case "start":
            return np.asarray(start, dtype=float)
        case "half_time":
            return _half_time_spin(middle, decay, exponent)
        case "arithmetic":
            return np.add(start, end) / 2
        case "geometric":
            return middle
        case "logarithmic":
            return middle * _sinhc(decay / 2)
        case "viscous":
            return middle / _sinhc(decay / 2)


def _half_time_spin(middle: Any, decay: Any, exponent: ArrayLike) -> Any:
    """Spin at half time: ψ̇^(1−p) falls steadily, so it is the power mean of start and end to 1 − p."""
    y = np.abs(np.subtract(1.0, exponent) * decay / 2)
    safe = np.where(y == 0, 1.0, y)
    level = np.where(y == 0, 0.0, _log_cosh(safe) / safe)
    sign = np.copysign(1.0, np.subtract(1.0, exponent))
    return middle * np.exp(sign * np.abs(decay) / 2 * level)


def arithmetic_mean_bias(start: ArrayLike, end: ArrayLike) -> Any:
    """Relative bias of I_zz when the plain mean (start + end)/2 of a viscously decaying spin is used.

    Parameters
    ----------
    start, end : array_like
        Spin at the start and the end [rad/s].

    Returns
    -------
    ndarray or float
        I_zz estimated over true, minus 1; −d²/6 for a small decay d = ln(start/end).
    """
    return mean_spin_bias(start, end, "arithmetic")


def decay_law_doubt(start: ArrayLike, end: ArrayLike) -> Any:
    """Relative change of I_zz if the spin fell by dry friction instead of viscously: −d²/12.

    Parameters
    ----------
    start, end : array_like
        Spin at the start and the end [rad/s].

    Returns
    -------
    ndarray or float
        Logarithmic mean (dry friction) in the place of `harmonic_mean_spin`, as a ratio minus 1,
        taken as the change of I_zz that goes with it (the inertia goes as 1/spin).
    """
    return mean_spin_bias(start, end, "logarithmic")


def late_reading_bias(delay: ArrayLike, time_constant: ArrayLike) -> Any:
    """Relative bias of I_zz when the half-time reading of a viscously decaying spin is late: e^(delay/τ) − 1.

    Parameters
    ----------
    delay : array_like
        How late the tachometer was read [s]; negative for early.
    time_constant : array_like
        τ in which the spin falls to 1/e [s].

    Returns
    -------
    ndarray or float
        I_zz estimated over what a reading in time gives, minus 1.
    """
    return np.expm1(np.divide(delay, time_constant))


def sink_rate(
    precession_rate: ArrayLike,
    spin: ArrayLike,
    inertia: ArrayLike,
    transverse_inertia: ArrayLike,
    time_constant: ArrayLike,
) -> Any:
    """Rate at which a level precessing rod sinks under the drag of the air film: (1 + I/I_zz) φ̇/(τ ψ̇).

    Parameters
    ----------
    precession_rate, spin : array_like
        φ̇ and ψ̇ [rad/s].
    inertia, transverse_inertia : array_like
        I_zz and I [kg*m^2].
    time_constant : array_like
        τ in which the spin falls to 1/e [s], by a drag −(I_zz/τ) ω, the same about every axis.

    Returns
    -------
    ndarray or float
        θ̇ [rad/s]: under a fixed drag the vertical angular momentum, and with it the height, falls. For drag slow
        against the precession.
    """
    ratio = np.divide(transverse_inertia, inertia)
    return (1 + ratio) * np.divide(precession_rate, spin) / time_constant


def sink_bias(
    precession_rate: ArrayLike,
    spin: ArrayLike,
    inertia: ArrayLike,
    transverse_inertia: ArrayLike,
    time_constant: ArrayLike,
    time: ArrayLike,
) -> Any:
    """Relative bias of I_zz when a rod that sinks under drag is taken for level: ((I/I_zz)² − 1)(φ̇/ψ̇)² t/2τ.

    Parameters
    ----------
    precession_rate, spin, inertia, transverse_inertia, time_constant
        As for `sink_rate`.
    time : array_like
        For which it is timed, from level on [s].

    Returns
    -------
    ndarray or float
        I_zz estimated over true, minus 1: the bias of a tilt half as deep as the rod has sunk at the end. Beside it
        the spin's harmonic mean is needed. For a sink of a few degrees.
    """
    sunk = sink_rate(precession_rate, spin, inertia, transverse_inertia, time_constant) * np.asarray(time)
    return tilt_bias(precession_rate, spin, -sunk / 2, inertia, transverse_inertia)
