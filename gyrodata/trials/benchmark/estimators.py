"""Textbook fits and the recommended fit, compared on simulated labs with a known I_zz.

Each fit returns I_zz and its 95 % interval from the `Measurements` of a log. P is φ̇ψ̇
and M the torque; eq. (9) is M = I_zz P. Fits whose uncertainty comes from the scatter
use Student's factor, so that a small number of runs is not the reason for a poor
coverage.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np
from msgspec import Struct

from gyrodata import fitting
from gyrodata.fitting import K_95
from gyrodata.measurements import Measurements, measure
from gyrodata.physics import Floats
from gyrodata.quantities.units import Uncertainty
from gyrodata.readings import read_log
from gyrodata.trials.benchmark.motions import Clock, Effort, time_of
from gyrodata.trials.simulation import TYPICAL, Design, Truth, simulate

HONEST = 0.92, 0.98
"""Coverage of a 95 % interval that is called honest [1]; below it the interval is too
short, above it too long."""

Answer = tuple[float, float, float]
"""I_zz and the ends of its 95 % interval [kg*m^2]; NaN without an interval."""


# --- the fits ---


def textbook(measured: Measurements, name: str) -> Answer:
    """Apply a textbook fit, with an uncertainty from the scatter."""
    from scipy.special import stdtrit

    value, u = map(float, fitting.TEXTBOOK[name](measured.product, measured.torque))
    half = (
        float(
            stdtrit(len(measured.runs) - (2 if name == "with_constant" else 1), 0.975)
        )
        * u
    )
    return value, value - half, value + half


def line_with_errors(measured: Measurements, independent: bool) -> Answer:
    """Fit a line with errors in both variables.

    The errors are independent (York), or have all covariances (ISO/TS 28037).
    """
    of_product, of_torque = (
        np.diag(one) if independent else one for one in covariances(measured)
    )
    line = fitting.fit_line(measured.product, measured.torque, of_product, of_torque)
    return (
        line.slope,
        line.slope - K_95 * line.u_slope,
        line.slope + K_95 * line.u_slope,
    )


def covariances(measured: Measurements) -> tuple[Floats, Floats]:
    """Compute the covariances of P and of M from the stated errors, each of shape (n, n)."""
    count = len(measured.runs)
    # The timing bias is the same in all runs.
    late = measured.product / measured.time * measured.timing_bias_u
    product = np.outer(late, late)
    torque = np.zeros((count, count))
    for whole, covariance, quantities in (
        (measured.product, product, ("time", "spin", "turns")),
        (measured.torque, torque, ("mass", "position", "g")),
    ):
        for source in (one for one in measured.sources if one.quantity in quantities):
            part = np.broadcast_to(getattr(measured, source.quantity), count)
            spread = (
                whole
                / part
                * (source.absolute + source.relative * part)
                * (source.groups >= 0)
            )
            covariance += np.outer(spread, spread) * np.equal.outer(
                source.groups, source.groups
            )
    return product, torque


def recommended(measured: Measurements) -> Answer:
    """Fit like `gyro analyze`: without runs with wrong turn counts, and with shared errors."""
    slips = [outlier.index for outlier in fitting.screen(measured)[0] if outlier.slip]
    inertia = fitting.fit(measured, left_out=slips).inertia
    return inertia.value, *(inertia.interval_95 or (math.nan, math.nan))


ESTIMATORS: Mapping[str, Callable[[Measurements], Answer]] = {
    "mean of ratios": partial(textbook, name="mean_of_ratios"),
    "line through the origin": partial(textbook, name="through_origin"),
    "line with intercept": partial(textbook, name="with_constant"),
    "York's line": partial(line_with_errors, independent=True),
    "line, full covariance": partial(line_with_errors, independent=False),
    "recommended fit": recommended,
}
"""The fits by their names in the charts."""


# --- the labs ---


class LabScene(Struct, frozen=True):
    """A kind of lab: its design, its true errors, and the errors that its log states."""

    name: str
    title: str
    design: Design = Design()
    noise: Mapping[str, Uncertainty] = {}
    """True uncertainties that differ from `TYPICAL`."""
    stated: Mapping[str, str] = {}
    """Uncertainties that the log states instead of the true ones."""
    imbalance: float = 0.025
    """M0 over the smallest torque [1]; published balls have a median of 0.025."""
    miscounts: int = 0
    """Number of runs for which only half of the turns are written down."""

    def draw(self, seed: int) -> Measurements:
        """Simulate a lab and read its log."""
        lightest = (
            min(self.design.masses) * min(map(abs, self.design.positions)) * Truth().g
        )
        made = simulate(
            Truth(imbalance=self.imbalance * lightest),
            self.design,
            {**TYPICAL, **self.noise},
            seed,
        )
        lines = made.log.splitlines()
        for row in np.random.default_rng(seed).permutation(len(made.readings.runs))[
            : self.miscounts
        ]:
            # The last two cells are the turns and the number of the run.
            lines[-1 - row] = re.sub(r",1(,\d+)$", r",1/2\1", lines[-1 - row])
        return measure(read_log("\n".join(lines).encode(), settings=self.stated))


SCENES = (
    LabScene("usual", "stated correctly"),
    LabScene(
        "threefold",
        "stopwatch 3 times worse than stated",
        noise={"u_time": Uncertainty(0.42)},
        stated={"u_time": "0.14 s"},
    ),
    LabScene(
        "third",
        "stopwatch 3 times better than stated",
        noise={"u_time": Uncertainty(0.14 / 3)},
        stated={"u_time": "0.14 s"},
    ),
)
"""Nine runs: three weights at three spins, on one side of a ball that is not exactly
balanced."""


class Trial(Struct, frozen=True):
    """One fit in one kind of lab."""

    estimator: str
    rmse: float
    """Root mean square of the relative error of I_zz [1]."""
    bias: float
    """Mean of the relative error of I_zz [1]."""
    bias_u: float
    """Standard error of the bias [1]."""
    coverage: float
    """Fraction of the labs whose 95 % interval contains the true I_zz [1]."""
    half: float
    """Mean half width of the interval over the true I_zz [1]; NaN without intervals."""
    seconds: float
    """CPU time of one fit, in Python [s]."""
    labs: int
    failed: int
    """Number of labs without an answer; they count as not covered."""

    @property
    def honest(self) -> bool:
        """Whether the coverage is `HONEST`, within two standard errors."""
        low, high = HONEST
        chance = 2 * math.sqrt(low * (1 - low) / self.labs)
        return low - chance <= self.coverage <= high + chance


class TrialPanel(Struct, frozen=True):
    """All fits in one kind of lab."""

    scene: LabScene
    trials: tuple[Trial, ...]
    """In the order of `ESTIMATORS`."""


def run_trials(effort: Effort, clock: Clock, seed: int = 1) -> list[TrialPanel]:
    """Apply every fit to every kind of lab."""
    panels = []
    for scene in SCENES:
        labs = draw_labs(scene, effort.labs, seed)
        panels.append(
            TrialPanel(
                scene,
                tuple(
                    try_fit(name, labs, clock, effort.repeats) for name in ESTIMATORS
                ),
            )
        )
    return panels


def draw_labs(scene: LabScene, count: int, seed: int) -> list[Measurements]:
    """Simulate labs of one kind."""
    return [
        scene.draw(one)
        for one in np.random.default_rng(seed).integers(2**31, size=count).tolist()
    ]


def try_fit(
    name: str, labs: Sequence[Measurements], clock: Clock, repeats: int = 1
) -> Trial:
    """Apply one fit to labs and compare its answers with the truth."""
    truth = Truth().inertia
    answers = []
    for lab in labs:
        try:
            answers.append(ESTIMATORS[name](lab))
        except (ValueError, fitting.NoFit):
            answers.append((math.nan,) * 3)
    value, low, high = np.array(answers).T / truth
    off = value[np.isfinite(value)] - 1
    half = (high - low)[np.isfinite(high - low)] / 2
    return Trial(
        estimator=name,
        rmse=math.sqrt(float(np.mean(off**2))),
        bias=float(off.mean()),
        bias_u=float(off.std()) / math.sqrt(len(off)),
        coverage=float(np.mean((low <= 1) & (high >= 1))),
        half=float(half.mean()) if len(half) else math.nan,
        seconds=time_of(partial(ESTIMATORS[name], labs[0]), clock, repeats),
        labs=len(labs),
        failed=len(labs) - len(off),
    )
