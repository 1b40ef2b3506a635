"""Two doubts about an answer: what the runs that it leaves over look like, and what it hangs on.

Patterns in what is left over are errors that a lab does not make by chance, each with its likely cause. Each test asks
whether the runs want one more unknown: a balance that drifts, a shared error that is free of its prior. With c the
change of the runs' conditions by that unknown, r their residuals and H the fit's hat matrix, z = cᵀr/√(cᵀ(1 − H)c) is
standard normal where nothing is wrong, for any design; of a shared error it is its *pull*, the adjusted value over
√(prior² − posterior²). How much the runs scatter is known only roughly: the chance is averaged over the factors s on
their own errors that what is left without the pattern allows.

The other doubt: I_zz as it would be if one thing were otherwise, and all else as in the fit.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata import fitting
from gyrodata.fitting import FitResult
from gyrodata.measurements import Measurements, Source
from gyrodata.physics import Floats
from gyrodata.quantities import exchanged_digits
from gyrodata.tables import load_words

CHANCE = 0.015
"""A pattern is told where its chance, corrected for how many were looked for, is below this."""

TOLD_APART = 0.02
"""An unknown is looked for where so large a part of what it does, squared, can be done by no other."""

MOST_RUNS, MOST_SHARED = 1000, 60
"""Larger logs are not searched."""

LOGARITHMS = np.linspace(math.log(0.2), math.log(20.0), 24)
FACTORS = np.exp(LOGARITHMS)
"""Factors s on the errors that each run has alone."""


class Pattern(Struct, frozen=True):
    """One pattern that was looked for among the residuals."""

    name: str
    """"order", "spin" or "torque" that the residuals go with, or a shared error: "time_bias", "position_zero", "mass",
    "position", "force", "applied_torque"; or "agreement", the lower tail of chi-square."""
    of: str
    """Which weight or position, in words; "" where there is one only."""
    statistic: float
    """Standard normal where there is no such pattern; of the agreement chi-square over its degrees of freedom."""
    size: float | None
    """What the pattern would be: a torque from the first run to the last [N*m], an exponent [1], an error [s or m] or a
    share of the weight or position [1]; null of the agreement."""
    p: float
    """Chance of one at least as large, by itself."""
    p_corrected: float
    """The same among all that were looked for, by Holm's rule."""


class PatternKind(Struct, frozen=True):
    """What is said of a pattern."""

    words: str
    hint: str


KINDS = {
    "order": PatternKind(
        "time minus fit goes with the order of the runs, as where the balance drifts, here by {milli:.2g} mN·m from "
        "the first run to the last",
        "fix the balance weight, check step 2 again, and repeat the first run at the end",
    ),
    "spin": PatternKind(
        "time minus fit goes with the spin, as where the spin is read late, or a drag or a nutation goes with it",
        "read the spin at half time of each run, and write how the rod was started: # motion: steady, or # motion: "
        "released",
    ),
    "torque": PatternKind(
        "time minus fit goes with the torque, and not along a line, as where the rod sinks or the turns of a weight "
        "are wrong",
        "write the pitch of each run, and count the turns of each weight again",
    ),
    "time_bias": PatternKind(
        "short times are off more than long ones, as where the hand is {late} than stated, here by about {size:.2g} s",
        "state what your hand can do, for example # u_time_bias: {twice:.1g} s, or time more turns",
    ),
    "position_zero": PatternKind(
        "the runs go together only if every position is {off:.2g} mm {more}, as where the arm was measured from "
        "another point than the centre of the ball",
        "measure the arm from the centre of the ball, or state # u_position_zero: {off:.1g} mm",
    ),
    "mass": PatternKind(
        "the runs of {of} go together with the others only if its mass is {percent:.2g} % {more}, as where a label is "
        "wrong",
        "weigh it",
    ),
    "position": PatternKind(
        "the runs at {of} go together with the others only if the position is {percent:.2g} % {more}, as where it was "
        "read wrongly",
        "measure it again",
    ),
    "force": PatternKind(
        "the runs of {of} go together with the others only if its force is {percent:.2g} % {more}",
        "measure it again",
    ),
    "applied_torque": PatternKind(
        "the runs of {of} go together with the others only if the torque is {percent:.2g} % {more}",
        "measure it again",
    ),
    "agreement": PatternKind(
        "the runs agree better than the stated uncertainties: chi-square is {statistic:.2g} of what it should be",
        "state what your hand can do, for example # u_time: 0.05 s; and write the times as they were read",
    ),
}
"""What is said of each pattern, by its name."""

NEAR = 0.15
"""A mass with two digits exchanged is named if it differs so much as the runs say, but for this share of that."""

SHARED = {"mass": "mass", "position": "position", "force": "force", "torque": "applied_torque",
          "position_zero": "position_zero"}  # fmt: skip
"""Sources of error whose pulls are looked at, and the patterns that they are told as."""


def pattern_words(pattern: Pattern) -> tuple[str, str]:
    """Say what a pattern is and what to do about it."""
    size = pattern.size or 0.0
    values = {
        "of": pattern.of,
        "statistic": pattern.statistic,
        "size": abs(size),
        "twice": 2 * abs(size),
        "late": "later" if size > 0 else "earlier",
        "milli": 1e3 * abs(size),
        "off": 1e3 * abs(size),
        "percent": 100 * abs(size),
        # An error that the reading has too much is one that the truth has less.
        "more": "less" if size > 0 else "more",
    }
    kind = KINDS[pattern.name]
    hint = kind.hint.format(**values)
    if pattern.name == "mass" and " g" in pattern.of:
        written = f"{float(pattern.of.split()[0]):#.4g}"
        for meant in exchanged_digits(written):
            if abs(float(meant) / float(written) - (1 - size)) < NEAR * abs(size):
                hint += f": is it {float(meant):g} g, and two digits are exchanged?"
    return kind.words.format(**values), hint


def look_for_patterns(measured: Measurements, fit: FitResult) -> tuple[Pattern, ...]:
    """Look for patterns in the residuals of a log, the least likely one first; none in a log too large or too small."""
    problem = fit.adjusted.problem
    if fit.dof < 2 or len(measured.runs) > MOST_RUNS or problem.shared_count > MOST_SHARED:
        return ()
    unknowns = _extra_unknowns(measured, fit)
    found = _tested(measured, fit, unknowns) if unknowns else []
    if measured.own_relative.all():
        low = max(1 - fitting.chi2_tail(fit.chi2, fit.dof), 0.0)
        found.append(Pattern("agreement", "", fit.chi2 / fit.dof, None, low, low))
    # A tie, as of the one position and the ruler's zero, is not to be broken by rounding.
    found.sort(key=lambda pattern: float(f"{pattern.p:.9g}"))
    corrected, least = [], 0.0
    for at, pattern in enumerate(found):
        least = max(least, min(1.0, (len(found) - at) * pattern.p))
        corrected.append(replace(pattern, p_corrected=least))
    return tuple(corrected)


class _Extra(Struct, frozen=True):
    """An unknown that the runs may want."""

    name: str
    of: str
    column: Floats
    """What one unit of it changes the weighted conditions by, shape (n,)."""
    unit: float
    """Size of that unit."""
    prior: float | None
    """Its adjusted value, in those units; None where the fit has no such unknown."""


def _extra_unknowns(measured: Measurements, fit: FitResult) -> list[_Extra]:
    adjusted = fit.adjusted
    rows, problem = adjusted.rows, adjusted.problem
    count = len(measured.runs)
    order = np.arange(count) / (count - 1) - 0.5
    spin = np.log(measured.spin)
    spin -= np.add.reduce(spin) / count
    loads = np.abs(measured.torque)
    load = np.log(np.where(loads > 0, loads, 1.0) / loads.max()) * (loads > 0)
    extra = [
        _Extra("order", "", rows[:, 1] * order, float(adjusted.scale[1]), None),
        _Extra("spin", "", rows[:, 0] * spin, 1.0, None),
        _Extra("torque", "", rows[:, 0] * load, 1.0, None),
    ]
    if measured.timing_bias_u > 0:
        extra.append(
            _Extra("time_bias", "", rows[:, 2], measured.timing_bias_u, float(adjusted.unknowns[2] / adjusted.scale[2]))
        )
    members = zip(problem.from_source.tolist(), problem.from_run.tolist(), problem.to_column.tolist(), strict=True)
    for column, (s, run) in {column: (s, run) for s, run, column in members}.items():
        source = problem.sources[s]
        if source.name in SHARED:
            of = "" if source.name == "position_zero" else load_words(measured, run)
            unit, pulled = _unit(measured, source, run), float(adjusted.shared[column])
            extra.append(_Extra(SHARED[source.name], of, rows[:, 3 + column], unit, pulled))
    return [one for one in extra if np.count_nonzero(one.column)]


def _unit(measured: Measurements, source: Source, run: int) -> float:
    """Standard uncertainty of a shared error: absolute of the ruler's zero [m], else relative [1]."""
    if source.name == "position_zero":
        return float(source.absolute[run])
    value = {"mass": measured.mass, "position": measured.position, "force": measured.force}.get(
        source.name, measured.given_torque
    )
    return float(source.relative[run] + source.absolute[run] / abs(value[run]))


def _tested(measured: Measurements, fit: FitResult, extra: list[_Extra]) -> list[Pattern]:
    """Test each unknown by itself, for every factor on the errors that each run has alone."""
    adjusted = fit.adjusted
    # Counted from where their priors are centred.
    moved = np.concatenate([adjusted.unknowns[1:] / np.where(adjusted.scale[1:] > 0, adjusted.scale[1:], 1.0),
                            adjusted.shared])  # fmt: skip
    left = adjusted.rows[:, 1:] @ moved - adjusted.weighted
    told = np.concatenate([adjusted.rows, np.array([*(one.column for one in extra), left]).T], axis=1)
    says = float(adjusted.kept.sum())
    of_factor = _chance_of_factors(fitting.times_stated(measured)) - (says - 1) * LOGARITHMS
    apart, whole, along, weight = _turned(told, len(extra), fit.scatter, of_factor)
    z = along / np.sqrt(apart)
    typical, scaled = weight.argmax(axis=0).tolist(), (np.abs(z) / math.sqrt(2)).T.tolist()
    found = []
    for k, (one, at) in enumerate(zip(extra, typical, strict=True)):
        if apart[at, k] < TOLD_APART * whole[at, k]:
            continue
        p = float(weight[:, k] @ list(map(math.erfc, scaled[k])))
        free_of_prior = float(along[at, k] / apart[at, k])
        # A prior pulled the error back: what it would be without.
        size_of = one.unit * (free_of_prior + (one.prior or 0.0))
        found.append(Pattern(one.name, one.of, float(z[at, k]), size_of, p, p))
    return found


def _turned(told: Floats, extra: int, scatter: float, of_factor: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """What each extra unknown has for itself, as a whole, with what is left, and the weight of each factor; (F, E).

    I_zz, which has no prior, is taken out of the runs. With what is left turned by the singular vectors of all other
    unknowns, each s costs no fit: it only divides every turned row by its own 1 + value²/s².
    """
    rows, others = told, told.shape[1] - extra - 2
    if rows.shape[0] > rows.shape[1]:
        # Many runs say no more than the triangle of their products.
        rows = np.asarray(np.linalg.qr(rows, mode="r"))
    along_inertia = rows[:, 0] / math.sqrt(rows[:, 0] @ rows[:, 0])
    size = np.add.reduce(rows[:, 1 + others : -1] ** 2, axis=0)
    rows = rows[:, 1:] - np.outer(along_inertia, along_inertia @ rows[:, 1:])
    turn, values, _ = np.linalg.svd(rows[:, :others], full_matrices=rows.shape[0] > others)
    turned = turn.T @ rows[:, others:]
    columns, left = turned[:, :-1], turned[:, -1:]
    wider = ((scatter / FACTORS) ** 2)[:, None]
    prior = np.ones((len(FACTORS), len(turned)))
    prior[:, : len(values)] += wider * values**2
    free, whole = wider / prior, wider * size
    apart = np.maximum(free @ columns**2, 1e-12 * whole)
    along = free @ (columns * left)
    # How likely each factor is once the pattern is taken out: as in the posterior, with both determinants.
    rest = free @ left**2 - along**2 / apart
    chance = of_factor - 0.5 * np.add.reduce(np.log(prior), axis=1)
    likely = chance[:, None] - 0.5 * (np.log(apart) + rest)
    weight = np.exp(likely - np.maximum.reduce(likely, axis=0))
    return apart, whole, along, weight / np.add.reduce(weight, axis=0)


@cache
def _chance_of_factors(stated: bool) -> Floats:
    """Logarithm of the chance of each factor before the runs are looked at."""
    return fitting.scatter_prior(LOGARITHMS, stated)
