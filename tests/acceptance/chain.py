"""A Markov chain of the model that `statistics.md` describes: ``python
tests/acceptance/chain.py``.

For each log it prints the median of I_zz in the chain and that of `gyrodata`, their
difference over u, and the ratio of the two u. The chain does not linearise: each state
is a set of I_zz, M0, b, ln s and all shared errors, and the spin is late by its own
delay in a spin that falls with its own decay time. Only the readings and their sources
of error are taken from the package.

Method: an ensemble of walkers with moves along the difference of two others (C. J. F.
ter Braak, Statistics and Computing 16, 239 (2006)), so that no step needs a derivative
or a width."""

from __future__ import annotations

import argparse
import math
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from msgspec.structs import replace

sys.path += [
    str(Path(__file__).parents[1] / room) for room in ("acceptance", "support", "")
]

from gates.drawn_logs import Bench, draw, write

import gyrodata
from gyrodata.fitting import (
    AS_STATED,
    balance_scale,
    fit,
    lightest_torque,
    times_stated,
)
from gyrodata.measurements import Measurements, Source, measure, select
from gyrodata.readings import read_log

WALKERS, STEPS, BURNT = 120, 10_000, 2_500

DELAY, DELAY_U = 2.0, 1.7
"""How late the spin is read [s]."""

DECAY_TIME, DECAY_SPREAD = 1000.0, math.log(2)
"""Time in which the spin falls by 1/e [s], and the standard deviation of its logarithm.
"""

SHAPE = 4
"""Number of unknowns before the shared errors: ln I_zz, M0, b and ln s."""


class Chain:
    """The logarithm of the posterior density of one log, for many walkers at once."""

    def __init__(self, measured: Measurements) -> None:
        self.measured = measured
        start = fit(measured, AS_STATED)
        self.inertia = start.inertia.value
        kept = np.ones(len(measured.runs))
        lightest = lightest_torque(measured, kept)
        self.m0_scale = balance_scale(measured, self.inertia, lightest)
        self.m0 = start.residual_torque.value
        self.stated = times_stated(measured)
        self.is_delayed = any(
            source.name == "spin_delay" and source.default
            for source in measured.sources
        )
        self.is_delayed &= measured.delay_factor is not None
        sources = [
            one
            for one in measured.sources
            if not (one.name == "spin_delay" and self.is_delayed)
        ]
        parts = [divided(one) for one in sources]
        self.own = [own for own, _ in parts if (own.groups >= 0).any()]
        self.shared = [shared for _, shared in parts if (shared.groups >= 0).any()]
        self.sizes = [int(one.groups.max()) + 1 for one in self.shared]
        self.count = SHAPE + 2 * self.is_delayed + sum(self.sizes)

    def begin(self, random: np.random.Generator) -> np.ndarray:
        """Draw the first walkers, shape (walkers, unknowns)."""
        walkers = random.standard_normal((WALKERS, self.count))
        walkers[:, 0] = math.log(self.inertia) + 0.01 * walkers[:, 0]
        walkers[:, 1] = self.m0 + 0.1 * self.m0_scale * walkers[:, 1]
        walkers[:, 2] *= self.measured.timing_bias_u
        walkers[:, 3] *= 0.3
        return walkers

    def density(self, walkers: np.ndarray) -> np.ndarray:
        """Compute the logarithm of the density of each walker, shape (walkers,)."""
        measured = self.measured
        log_inertia, m0, bias, log_factor = walkers[:, :SHAPE].T
        standard = walkers[:, SHAPE:]
        factors, shifts = self.errors_that_runs_share(standard)
        reading = measured.spin if self.is_delayed else measured.corrected_spin
        spin = (reading - shifts["spin"]) / factors["spin"]
        if self.is_delayed:
            late = DELAY + DELAY_U * standard[:, 0]
            rate = np.exp(DECAY_SPREAD * standard[:, 1]) / DECAY_TIME
            spin = spin * np.exp(late * rate)[:, None]
        turns = (measured.turns - shifts["turns"]) / factors["turns"]
        torque = self.torque(factors, shifts) + m0[:, None]
        whole = np.exp(log_inertia)[:, None] + measured.added
        predicted = 2 * np.pi * turns * whole * spin / np.abs(torque) + bias[:, None]
        variance = np.exp(2 * log_factor)[:, None] * self.variance_of_one_run(
            predicted, torque, m0
        )
        chi2 = (measured.time - predicted) ** 2 / variance
        total = -0.5 * np.sum(chi2 + np.log(variance), axis=1)
        # I_zz is flat, so that its logarithm has the density I_zz.
        total += log_inertia + scatter_prior(log_factor, self.stated)
        total -= np.log1p((m0 / self.m0_scale) ** 2)
        if measured.timing_bias_u:
            total -= 0.5 * (bias / measured.timing_bias_u) ** 2
        return total - 0.5 * np.sum(standard**2, axis=1)

    def errors_that_runs_share(
        self, standard: np.ndarray
    ) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
        """Return by quantity the product of all relative errors, and the sum of all
        absolute ones, (walkers, n).
        """
        count = len(self.measured.runs)
        names = (
            "time",
            "spin",
            "turns",
            "mass",
            "position",
            "force",
            "torque",
            "g",
            "added",
        )
        factors = {name: np.ones((len(standard), count)) for name in names}
        shifts = {name: np.zeros((len(standard), count)) for name in names}
        at = 2 * self.is_delayed
        for source, size in zip(self.shared, self.sizes, strict=True):
            errors = np.column_stack(
                [standard[:, at : at + size], np.zeros(len(standard))]
            )[:, source.groups]
            factors[source.quantity] *= 1 + source.relative * errors
            shifts[source.quantity] += source.absolute * errors
            at += size
        return factors, shifts

    def torque(
        self, factors: dict[str, np.ndarray], shifts: dict[str, np.ndarray]
    ) -> np.ndarray:
        """Compute the torque of the weights without their shared errors [N*m], shape
        (walkers, n).
        """
        measured = self.measured

        def true(name: str, reading: np.ndarray | float) -> np.ndarray:
            return (reading - shifts[name]) / factors[name]

        if not np.isnan(measured.mass).all():
            return (
                true("mass", measured.mass)
                * true("g", measured.g)
                * true("position", measured.position)
            )
        if not np.isnan(measured.force).all():
            return true("force", measured.force) * true("position", measured.position)
        return true("torque", measured.given_torque)

    def variance_of_one_run(
        self, predicted: np.ndarray, torque: np.ndarray, m0: np.ndarray
    ) -> np.ndarray:
        """Compute the variance of each time by the errors of this run alone [s²], shape
        (walkers, n).
        """
        measured, variance = self.measured, np.zeros_like(predicted)
        share = (torque - m0[:, None]) / torque
        for source in self.own:
            reading = {
                "time": measured.time,
                "spin": measured.spin,
                "turns": measured.turns,
                "mass": measured.mass,
                "position": measured.position,
                "force": measured.force,
                "torque": measured.given_torque,
            }[source.quantity]
            relative = source.relative + source.absolute / np.where(
                reading == 0, np.inf, np.abs(reading)
            )
            if source.quantity == "time":
                relative = source.relative + source.absolute / predicted
            slope = (
                share
                if source.quantity in ("mass", "position", "force", "torque")
                else 1.0
            )
            variance += (
                slope * predicted * np.where(source.groups < 0, 0.0, relative)
            ) ** 2
        return variance


def divided(source: Source) -> tuple[Source, Source]:
    """Divide a source into the errors of single runs, and those that several runs
    share.
    """
    count = np.bincount(source.groups + 1)[source.groups + 1]
    is_own = (count == 1) & (source.groups >= 0)
    is_shared = (count > 1) & (source.groups >= 0)
    _, numbers = np.unique(source.groups[is_shared], return_inverse=True)
    shared = np.full(len(count), -1)
    shared[is_shared] = numbers
    return replace(source, groups=np.where(is_own, source.groups, -1)), replace(
        source, groups=shared
    )


def scatter_prior(log_factor: np.ndarray, stated: bool) -> np.ndarray:
    """Compute the logarithm of the prior of ln s: normal, with the tails of a Cauchy
    distribution.
    """
    spread, tail = math.log(2.5 if stated else 3.75), math.log(5)
    near = (
        0.95
        * np.exp(-0.5 * (log_factor / spread) ** 2)
        / (spread * math.sqrt(2 * math.pi))
    )
    return np.log(near + 0.05 / (math.pi * tail * (1 + (log_factor / tail) ** 2)))


def sample(chain: Chain, seed: int) -> np.ndarray:
    """Draw I_zz from the posterior [kg*m^2]."""
    random = np.random.default_rng(seed)
    walkers = chain.begin(random)
    density = chain.density(walkers)
    half, step = WALKERS // 2, 2.38 / math.sqrt(2 * chain.count)
    kept = []
    for turn in range(STEPS):
        for moving, others in (
            (slice(half), slice(half, None)),
            (slice(half, None), slice(half)),
        ):
            pair = random.integers(half, size=(2, half))
            towards = walkers[others][pair[0]] - walkers[others][pair[1]]
            # Sometimes a whole step, to jump between separate maxima.
            size = 1.0 if turn % 10 == 0 else step
            new = (
                walkers[moving]
                + size * towards
                + 1e-8 * random.standard_normal(towards.shape) * walkers[moving]
            )
            with np.errstate(all="ignore"):
                there = chain.density(new)
            goes = np.log(random.random(half)) < np.nan_to_num(
                there - density[moving], nan=-np.inf
            )
            walkers[moving] = np.where(goes[:, None], new, walkers[moving])
            density[moving] = np.where(goes, there, density[moving])
        if turn >= BURNT and turn % 10 == 0:
            kept.append(np.exp(walkers[:, 0]))
    return np.array(kept)


BENCHES = {
    "base": Bench(time_constant=1000, delay=2),
    "hand 0.3 s": Bench(hand=0.3, time_constant=1000, delay=2),
    "M0 20 %": Bench(imbalance=0.2, time_constant=1000, delay=2),
    "3 runs": Bench(spins=(400,), time_constant=1000, delay=2),
}


def labs() -> Iterator[tuple[str, Measurements]]:
    """Draw three labs of each kind."""
    for at, (name, bench) in enumerate(BENCHES.items()):
        for seed in range(3):
            readings = read_log(write(draw(bench, 100 * at + seed)).encode())
            yield f"{name}, seed {100 * at + seed}", measure(readings)


def main() -> None:
    """Compare the chain with `gyrodata` for logs, or for simulated labs if none is
    given.
    """
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("log", nargs="*", type=Path)
    parser.add_argument("--map", action="append", default=[], metavar="ROLE=HEADER")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    options = parser.parse_args()
    warnings.simplefilter("ignore", gyrodata.GyroWarning)
    mapping, settings = (
        dict(text.split("=", 1) for text in texts)
        for texts in (options.map, options.set)
    )
    jobs = labs()
    if options.log:
        # As the log was fitted: without the runs that were left out, and with the model
        # that it needs.
        jobs = (
            (path.name, _as_fitted(path, mapping, settings)) for path in options.log
        )
    away = []
    for name, measured in jobs:
        drawn, inertia = sample(Chain(measured), 1), fit(measured).inertia
        low, middle, high = np.quantile(drawn, [0.158655, 0.5, 0.841345])
        first, second = (np.median(part) for part in np.array_split(drawn, 2))
        away.append((inertia.value - middle) / inertia.u)
        print(
            f"{name}: gyro {inertia.value:.6g} ± {inertia.u:.2g}, chain {middle:.6g} ± "
            f"{(high - low) / 2:.2g}, "
            f"gyro - chain {away[-1]:+.3f} u, u of the chain over u "
            f"{(high - low) / 2 / inertia.u:.3f}, "
            f"halves differ by {abs(first - second) / inertia.u:.3f} u",
            flush=True,
        )
    print(f"mean of {len(away)}: {np.mean(away):+.3f} u")


def _as_fitted(
    path: Path, mapping: dict[str, str], settings: dict[str, str]
) -> Measurements:
    """Return the runs of a log that are in its fit."""
    analysis = gyrodata.analyze(path, mapping=mapping, settings=settings)
    return select(
        analysis.measurements, np.flatnonzero(analysis.fit.adjusted.kept).tolist()
    )


if __name__ == "__main__":
    main()
