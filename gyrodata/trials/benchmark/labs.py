"""The simulated labs of the benchmark: logs as students type them, of a known I_zz."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata.measurements import Measurements, measure, select
from gyrodata.physics import Floats
from gyrodata.quantities.units import Uncertainty
from gyrodata.readings import read_log
from gyrodata.results import FittedLog
from gyrodata.trials.simulation import NOISE_KEYS, TYPICAL, Design, Truth, simulate

POSITION = 0.15
"""Position of the weights of a log without positions [m]."""


class LabScene(Struct, frozen=True):
    """A kind of lab: its design, its true errors, and those that its log states."""

    title: str = ""
    design: Design = Design()
    noise: Mapping[str, Uncertainty] = {}
    """True uncertainties that differ from `TYPICAL`."""
    stated: Mapping[str, str] = {}
    """Uncertainties that the log states instead of the true ones."""
    imbalance: float = 0.025
    """Standard deviation of M0 over the smallest torque [1]; published balls have a
    median of 0.025."""
    miscounted: float = 0.0
    """Part of the labs in which a run has half of the turns written down [1]."""
    push: tuple[float, float] = (0.0, 1.0)
    """Smallest and largest push of the hand, over the rate of steady precession [1]."""
    truth: Truth = Truth()

    def draw(self, seed: int) -> str:
        """Simulate a lab, and return its log."""
        random = np.random.default_rng([seed, 1])
        truth = self.truth
        if truth.imbalance is None:
            lightest = min(self.design.masses) * min(self.design.positions) * truth.g
            residual = self.imbalance * lightest * random.standard_normal()
            truth = replace(truth, imbalance=residual)
        log = simulate(truth, self.design, {**TYPICAL, **self.noise}, seed).log
        for key, text in self.stated.items():
            before, line, after = log.partition(f"# {key}: ")
            log = before + line + text + after[after.index("\n") :]
        if random.random() < self.miscounted:
            # The last two cells of a run are its turns and its number.
            run = random.integers(1, log.count(",1,"))
            log = log.replace(f",1,{run}\n", f",1/2,{run}\n")
        return log


SCENES = (
    LabScene("as the sheet asks"),
    LabScene(
        "messy: times worse than stated, large M0, miscounted turns",
        noise={"u_time": Uncertainty(0.42)},
        stated={"u_time": "0.14 s"},
        imbalance=0.1,
        miscounted=0.25,
    ),
    LabScene(
        "weights that disagree: M0 differs by 5 % of a torque",
        # 5 % of the lightest of the weights, in each of them.
        noise={"u_mass": Uncertainty(0.001)},
        stated={"u_mass": "0.2 %"},
    ),
)
"""Nine runs each: three weights at three spins, on one side of the ball."""


def scene_of(log: FittedLog) -> LabScene:
    """Return the lab of a log: its runs, its fitted values, its stated u."""
    measured = log.measurements
    # A weight with the same torque, also if the log contains forces or torques.
    position = np.copysign(POSITION, measured.torque)
    mass = measured.torque / position / measured.g
    columns = np.array([mass, position, measured.pitch, measured.spin, measured.turns])
    noise = {
        key: u for key, u in log.readings.uncertainties.items() if key in NOISE_KEYS
    }
    truth = Truth(
        inertia=log.fit.inertia.value, imbalance=log.fit.residual_torque.value
    )
    design = Design(runs=columns.T.tolist())
    push = (0.0, 0.0) if measured.motion == "released" else (0.0, 1.0)
    return LabScene("your log", design, noise, push=push, truth=truth)


def measured_lab(log: str) -> Measurements:
    """Read a log."""
    return measure(read_log(log.encode()))


def points_of(measured: Measurements) -> dict[str, Any]:
    """Return the readings as the other programs take them; see `programs`."""
    return {
        "angle": 2 * np.pi * measured.turns * measured.corrected_spin,
        "time": measured.time,
        "torque": measured.torque,
    }


def lab_of(measured: Measurements) -> dict[str, Any]:
    """Return the readings and their stated errors as the other programs take them.

    They do not get runs without a weight, whose times they cannot predict.
    """
    measured = select(measured, np.flatnonzero(measured.torque).tolist())
    # The timing bias is the same in all runs.
    late = measured.product / measured.time * measured.timing_bias_u
    times = covariance(measured, measured.time, "time")
    product = covariance(measured, measured.product, "time", "spin", "turns")
    return points_of(measured) | {
        "time_u": np.sqrt(np.diag(times)),
        "product_cov": product + np.outer(late, late),
        "torque_cov": covariance(measured, measured.torque, "mass", "position", "g"),
    }


def covariance(measured: Measurements, whole: Floats, *factors: str) -> Floats:
    """Compute the covariance of a product of quantities from the errors of its factors.

    `whole` is the product in each run, shape (n,).
    """
    total = np.zeros((len(whole), len(whole)))
    for source in measured.sources:
        if source.quantity in factors:
            size = source.absolute / getattr(measured, source.quantity)
            spread = whole * (size + source.relative) * (source.groups >= 0)
            same = np.equal.outer(source.groups, source.groups)
            total += np.outer(spread, spread) * same
    return total
