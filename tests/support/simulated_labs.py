"""Simulated labs with a known truth, as `Measurements`, with any size of each error."""

from __future__ import annotations

from typing import Any

import numpy as np

from gyrodata import analysis
from gyrodata.measurements import Measurements, Source
from gyrodata.physics.models import ModelName
from gyrodata.readings import read_log
from gyrodata.results import FittedLog, Options

INERTIA = 4.44e-3
G = 9.803
RPM = np.pi / 30


def analyze_briefly(log: Any, model: ModelName = "auto", **given: Any) -> FittedLog:
    """Analyse a log without what only a report shows: the same I_zz, odd runs and
    refusals in a tenth of the time.
    """
    fitted = analysis.fit_log(read_log(log, **given), Options(model=model))
    return analysis.check_fit(fitted)


def kinds_of_doubts(found: FittedLog) -> list[str]:
    """List the doubts about an answer, but for those that only a report looks for."""
    return [one.doubt for one in found.diagnostics if one.doubt]


def lab(
    random: np.random.Generator,
    *,
    weights: tuple[float, ...] = (0.020, 0.040, 0.060),
    positions: tuple[float, ...] = (0.150,),
    rpm: tuple[float, ...] = (200.0, 400.0, 600.0),
    repeats: int = 1,
    turns: float = 1.0,
    imbalance: float = 0.0,
    bias: float = 0.0,
    noise: float = 1.0,
    u_time: float = 0.14,
    u_spin: float = 0.002,
    u_spin_scale: float = 0.001,
    u_mass: float = 0.002,
    u_zero: float = 0.0005,
) -> Measurements:
    """Draw one lab; ``noise=0`` gives exact readings with the same stated
    uncertainties.
    """
    rows = [
        (w, x, s * RPM)
        for w in weights
        for x in positions
        for s in rpm
        for _ in range(repeats)
    ]
    mass, position, spin = (np.array(column) for column in zip(*rows, strict=True))
    count = len(mass)

    def normal(size: int | None = None) -> np.ndarray:
        return noise * random.standard_normal(size)

    total = mass * G * position + imbalance
    time = (
        2 * np.pi * turns * INERTIA * spin / np.abs(total)
        + bias
        + u_time * normal(count)
    )
    read_spin = spin * (1 + u_spin_scale * normal()) * (1 + u_spin * normal(count))
    different, groups = np.unique(mass, return_inverse=True)
    weighed = mass * np.array([1 + u_mass * normal() for _ in different])[groups]
    measured_position = position + u_zero * normal()
    own, every = np.arange(count), np.zeros(count, dtype=int)
    ones, zeros, nothing = np.ones(count), np.zeros(count), np.full(count, np.nan)
    return Measurements(
        runs=tuple(str(i + 1) for i in range(count)),
        lines=tuple(range(2, count + 2)),
        time=time,
        turns=np.full(count, turns),
        spin=read_spin,
        mass=weighed,
        position=measured_position,
        force=nothing,
        given_torque=nothing,
        torque=weighed * measured_position * G,
        sense=np.sign(total),
        pitch=zeros,
        transverse_inertia=None,
        spin_start=None,
        spin_end=None,
        g=G,
        timed=True,
        timing_bias_u=0.05,
        balance_test=None,
        balance_test_from="",
        day=every,
        diagnostics=(),
        mass_step=zeros,
        position_step=zeros,
        sources=(
            Source("time", "time", own, u_time * ones, zeros, "", True, ""),
            Source("spin", "spin", own, zeros, u_spin * ones, "", True, ""),
            Source(
                "spin_scale",
                "spin",
                every,
                zeros,
                u_spin_scale * ones,
                "all runs",
                True,
                "",
            ),
            Source(
                "mass",
                "mass",
                groups,
                zeros,
                u_mass * ones,
                "runs with the same weight",
                True,
                "",
            ),
            Source(
                "position_zero",
                "position",
                every,
                u_zero * ones,
                zeros,
                "all runs",
                True,
                "",
            ),
        ),
    )
