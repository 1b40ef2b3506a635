"""Patterns in the residuals: errors that are not random, each with its likely cause.

Each test asks whether the fit needs one more unknown: a balance that drifts, or a shared error that is free of its
prior. With c the change of the runs' conditions by that unknown, r their residuals and H the fit's hat matrix,
z = cᵀr/√(cᵀ(1 − H)c) is standard normal if nothing is wrong, for any design; for a shared error it is its *pull*, the
adjusted value over √(prior² − posterior²). The scatter of the runs is known only roughly: the probability is averaged
over the factors s on their own errors that agree with the residuals without the pattern.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata import fitting
from gyrodata.fitting import FitResult
from gyrodata.measurements import Measurements
from gyrodata.physics import Floats
from gyrodata.tables import load_words

CHANCE = 0.015
"""A pattern is reported if its probability, corrected for the number of tests, is below this."""

TOLD_APART = 0.02
"""An unknown is tested if at least this part of its effect, squared, cannot be produced by the others."""

MOST_RUNS, MOST_SHARED = 1000, 60
"""Larger logs are not tested."""

LOGARITHMS = np.linspace(math.log(0.2), math.log(20.0), 24)
FACTORS = np.exp(LOGARITHMS)
"""Factors s on the own errors of each run."""


class Pattern(Struct, frozen=True):
    """One pattern that was tested in the residuals."""

    name: str
    """"order", "spin" or "torque" that the residuals go with, or a shared error: "time_bias", "position_zero", "mass",
    "position", "force", "applied_torque"; or "agreement", the lower tail of chi-square."""
    of: str
    """Which weight or position, in words; "" if there is only one."""
    statistic: float
    """Standard normal if there is no such pattern; for "agreement", chi-square over its degrees of freedom."""
    size: float | None
    """What the pattern would be: a torque from the first run to the last [N*m], an exponent [1], an error [s or m] or a
    share of the weight or position [1]; null of the agreement."""
    p: float
    """Probability of a pattern at least as large, of this test alone."""
    p_corrected: float
    """The same, corrected for all tests by Holm's method."""


NEAR = 0.15
"""A mass with two exchanged digits is named if it agrees with the size of the pattern within this part of it."""

SHARED = ("mass", "position", "force", "torque", "position_zero")
"""Sources of error that are tested for a pull."""


def pattern_values(pattern: Pattern) -> dict[str, Any]:
    """Return the values of the message about a pattern; the message has its name."""
    size = pattern.size or 0.0
    off, digits = abs(size), ""
    if pattern.name == "mass" and " g" in pattern.of:
        written = f"{float(pattern.of.split()[0]):#.4g}"
        for meant in exchanged_digits(written):
            if abs(float(meant) / float(written) - (1 - size)) < NEAR * off:
                digits += f": is it {float(meant):g} g, and two digits are exchanged?"
    # If the reading is too large, the true value is smaller.
    more, late = ("less", "later") if size > 0 else ("more", "earlier")
    values = {"of": pattern.of, "statistic": pattern.statistic, "digits": digits, "more": more, "late": late}
    return values | {"size": off, "twice": 2 * off, "milli": 1e3 * off, "percent": 100 * off}


def look_for_patterns(measured: Measurements, fit: FitResult) -> tuple[Pattern, ...]:
    """Test the residuals of a log for patterns, the least probable first; none if the log is too large or too small."""
    if fit.dof < 2 or len(measured.runs) > MOST_RUNS or fit.adjusted.problem.shared_count > MOST_SHARED:
        return ()
    unknowns = _extra_unknowns(measured, fit)
    found = _tested(measured, fit, unknowns) if unknowns else []
    if measured.own_relative.all():
        low = max(1 - fitting.chi2_tail(fit.chi2, fit.dof), 0.0)
        found.append(Pattern("agreement", "", fit.chi2 / fit.dof, None, low, low))
    # Rounding must not decide the order of equal values, such as those of the only position and the zero of the ruler.
    found.sort(key=lambda pattern: float(f"{pattern.p:.9g}"))
    corrected, least = [], 0.0
    for at, pattern in enumerate(found):
        least = max(least, min(1.0, (len(found) - at) * pattern.p))
        corrected.append(replace(pattern, p_corrected=least))
    return tuple(corrected)


class _Extra(Struct, frozen=True):
    """An unknown that the runs may need."""

    name: str
    of: str
    column: Floats
    """Change of the weighted conditions by one unit of it, shape (n,)."""
    unit: float
    """Size of that unit."""
    adjusted: float = 0.0
    """Its adjusted value, in those units; 0 if the fit has no such unknown."""


def _extra_unknowns(measured: Measurements, fit: FitResult) -> list[_Extra]:
    """List a drift, a trend with the spin and one with the torque, and the errors that runs share."""
    adjusted = fit.adjusted
    rows, problem, count = adjusted.rows, adjusted.problem, len(measured.runs)
    spin, loads = np.log(measured.spin), np.abs(measured.torque)
    load = np.log(np.where(loads > 0, loads, 1.0) / loads.max()) * (loads > 0)
    extra = [
        _Extra("order", "", rows[:, 1] * (np.arange(count) / (count - 1) - 0.5), float(adjusted.scale[1])),
        _Extra("spin", "", rows[:, 0] * (spin - np.add.reduce(spin) / count), 1.0),
        _Extra("torque", "", rows[:, 0] * load, 1.0),
    ]
    if measured.timing_bias_u > 0:
        bias = float(adjusted.unknowns[2] / adjusted.scale[2])
        extra.append(_Extra("time_bias", "", rows[:, 2], measured.timing_bias_u, bias))
    members = zip(problem.from_source.tolist(), problem.from_run.tolist(), strict=True)
    for column, (s, run) in dict(zip(problem.to_column.tolist(), members, strict=True)).items():
        source = problem.sources[s]
        if source.name not in SHARED:
            continue
        # The ruler's zero has an absolute error [m], all others have relative ones.
        name, of, unit = source.name, "", source.absolute[run]
        if name != "position_zero":
            name = "applied_torque" if name == "torque" else name
            reading = measured.given_torque if name == "applied_torque" else getattr(measured, name)
            if not reading[run]:
                continue  # an error of a position of 0 cm cannot be given as a share of it
            of, unit = load_words(measured, run), source.relative[run] + unit / abs(reading[run])
        extra.append(_Extra(name, of, rows[:, 3 + column], float(unit), float(adjusted.shared[column])))
    return [one for one in extra if np.count_nonzero(one.column)]


def _tested(measured: Measurements, fit: FitResult, extra: list[_Extra]) -> list[Pattern]:
    """Test each of E unknowns by itself, for each of the factors s on the errors that each run has alone.

    I_zz, which has no prior, is taken out of the runs. With what is left turned by the singular vectors of all other
    unknowns, each s costs no fit: it only divides every turned row by its own 1 + value²/s².
    """
    adjusted = fit.adjusted
    # Relative to the centres of their priors.
    scale = np.where(adjusted.scale[1:] > 0, adjusted.scale[1:], 1.0)
    left = adjusted.rows[:, 1:] @ np.concatenate([adjusted.unknowns[1:] / scale, adjusted.shared]) - adjusted.weighted
    rows = np.concatenate([adjusted.rows, np.array([*[one.column for one in extra], left]).T], axis=1)
    others = adjusted.rows.shape[1] - 1
    if rows.shape[0] > rows.shape[1]:
        # For many runs, the triangular factor contains the same information.
        rows = np.asarray(np.linalg.qr(rows, mode="r"))
    along_inertia = rows[:, 0] / math.sqrt(rows[:, 0] @ rows[:, 0])
    size = np.add.reduce(rows[:, 1 + others : -1] ** 2, axis=0)
    rows = rows[:, 1:] - np.outer(along_inertia, along_inertia @ rows[:, 1:])
    turn, values, _ = np.linalg.svd(rows[:, :others], full_matrices=rows.shape[0] > others)
    turned = turn.T @ rows[:, others:]
    columns, left = turned[:, :-1], turned[:, -1:]
    wider = ((fit.widths.scatter / FACTORS) ** 2)[:, None]
    prior = np.ones((len(FACTORS), len(turned)))
    prior[:, : len(values)] += wider * values**2
    # Each unknown's column, its part orthogonal to the others, and its projection on the residuals, shape (24, E).
    free, whole = wider / prior, wider * size
    apart = np.maximum(free @ columns**2, 1e-12 * whole)
    along = free @ (columns * left)
    # Probability of each factor without the pattern: as in the posterior, with both determinants.
    rest = free @ left**2 - along**2 / apart
    before = fitting.scatter_prior(LOGARITHMS, fitting.times_stated(measured))
    before = before - (float(adjusted.kept.sum()) - 1) * LOGARITHMS - 0.5 * np.add.reduce(np.log(prior), axis=1)
    likely = before[:, None] - 0.5 * (np.log(apart) + rest)
    weight = np.exp(likely - np.maximum.reduce(likely, axis=0))
    weight = weight / np.add.reduce(weight, axis=0)
    z = along / np.sqrt(apart)
    found = []
    for k, (one, at) in enumerate(zip(extra, weight.argmax(axis=0).tolist(), strict=True)):
        if apart[at, k] >= TOLD_APART * whole[at, k]:
            p = float(weight[:, k] @ [math.erfc(abs(each) / math.sqrt(2)) for each in z[:, k].tolist()])
            # A prior made the error smaller; this is the error without the prior.
            size_of = one.unit * (float(along[at, k] / apart[at, k]) + one.adjusted)
            found.append(Pattern(one.name, one.of, float(z[at, k]), size_of, p, p))
    return found


def exchanged_digits(number: str) -> Iterator[str]:
    """List a number with each two neighbouring digits exchanged, except numbers that begin with 0."""
    digits = [at for at, sign in enumerate(number) if sign.isdigit()]
    for one, other in pairwise(digits):
        signs = [*number]
        signs[one], signs[other] = number[other], number[one]
        if signs[digits[0]] != "0" and signs != [*number]:
            yield "".join(signs)
