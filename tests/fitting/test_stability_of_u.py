"""Uncertainties that are too small, or pull the value, and the recommended fit of the
same labs.
"""

from __future__ import annotations

import math
from itertools import product
from typing import Any

import numpy as np
import pytest
from simulated_labs import INERTIA, RPM, analyze_briefly, lab

from gyrodata import LineFit, fit_line
from gyrodata.fitting import fit
from gyrodata.measurements import Measurements
from gyrodata.physics import STANDARD_GRAVITY


def drawn(count: int, **options: Any) -> list[Measurements]:
    return [lab(np.random.default_rng((7, k)), **options) for k in range(count)]


def york(measured: Measurements, intercept: bool = False) -> LineFit:
    """Fit a line that takes all errors for each run's own."""
    x, y, time, spin = measured.product, measured.torque, *measured.sources[:2]
    u_x = x * np.hypot(time.absolute / measured.time, spin.relative)
    return fit_line(x, y, u_x**2, (0.002 * y) ** 2, intercept=intercept)


def coverage(labs: list[Measurements], intercept: bool = False) -> float:
    """How often the 95 % interval of the line contains the truth."""
    lines = [york(measured, intercept) for measured in labs]
    return float(
        np.mean([abs(line.slope - INERTIA) < 1.96 * line.u_slope for line in lines])
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "most", "least"),
    [({"repeats": 3}, 0.75, 0.9), ({"imbalance": 1e-3}, 0.1, 0.88)],
    ids=["one scale and ruler for 27 runs", "no constant with an M0"],
)
def test_a_line_is_too_sure_and_the_recommended_fit_is_not(
    options: dict[str, Any], most: float, least: float
) -> None:
    labs = drawn(80, **options)
    assert coverage(labs) < most
    ends = np.array([fit(measured).inertia.interval_95 for measured in labs])
    assert np.mean((ends[:, 0] < INERTIA) & (ends[:, 1] > INERTIA)) > least


@pytest.mark.slow
def test_peelle_shared_scale_errors_pull_a_plain_fit_down() -> None:
    labs = drawn(150, u_spin=0.05, u_spin_scale=0.03, u_time=0.02)

    def bias(fitted: bool) -> float:
        means = []
        for measured in labs:
            ratio = measured.torque / measured.product
            size = np.full(len(ratio), ratio.mean()) if fitted else ratio
            covariance = np.diag((0.05 * size) ** 2) + 0.03**2 * np.outer(size, size)
            weight = np.linalg.solve(covariance, np.ones(len(ratio)))
            means.append(weight @ ratio / weight.sum())
        return float(np.mean(means) / INERTIA - 1)

    # The standard error of the mean of so many labs is 0.3 %; that of the difference is
    # much less.
    assert bias(fitted=False) - bias(fitted=True) < -0.009
    assert (
        abs(np.mean([fit(measured).inertia.value for measured in labs]) / INERTIA - 1)
        < 0.01
    )


@pytest.mark.slow
def test_a_hand_that_is_always_late_is_no_scatter() -> None:
    # 0.15 s, three times the prior of 0.05 s that a log gets if it states none.
    labs = drawn(80, bias=0.15, turns=1 / 3)
    assert coverage(labs, intercept=True) < 0.75
    assert np.mean([fit(measured).timing_bias.value for measured in labs]) > 0.02


def long_log(runs: int, seed: int) -> str:
    """Type a log in which only the times err, by 0.14 s; I_zz = 4.440e-3 kg*m^2, and
    the log states nothing.
    """
    index = np.arange(runs)
    mass, rpm = (
        np.array([20, 40, 60])[index % 3],
        np.array([200, 400, 600])[index // 3 % 3],
    )
    time = 2 * np.pi * INERTIA * rpm * RPM / (1e-3 * mass * STANDARD_GRAVITY * 0.15)
    time = time + 0.14 * np.random.default_rng(seed).standard_normal(runs)
    rows = "".join(
        f"{m}.00,15.00,{s}.0,{t:.2f},1\n"
        for m, s, t in zip(mass, rpm, time, strict=True)
    )
    return f"mass [g],position [cm],spin [rpm],time [s],turns\n{rows}"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("runs", "seed", "line"),
    # Without the line the fit is repeated for other motions of the rod, which takes five
    # times as long.
    [(300, 0, ""), (5_000, 1, "# motion: steady\n")],
)
def test_a_long_log_does_not_drift(runs: int, seed: int, line: str) -> None:
    inertia = analyze_briefly(f"{line}{long_log(runs, seed)}".encode()).inertia
    # The spin does not fall here, and a silent log is corrected for 2 s in 1000 s.
    assert inertia.value == pytest.approx(
        INERTIA / math.exp(2 / 1000), abs=0.15 * inertia.u
    )


LINES = ("# u_spin_scale: 1 %", "# u_mass_scale: 1 %", "# u_g: 1 %")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("runs", "line"), [*product((9, 300), LINES), (2_000, LINES[0])]
)
def test_a_shared_error_that_the_runs_do_not_determine_only_widens_u(
    runs: int, line: str
) -> None:
    key = line.partition(":")[0]
    log = f"# motion: steady\n{long_log(runs, 3)}"
    exact, wide = (
        analyze_briefly(f"{text}\n{log}".encode()).inertia
        for text in (f"{key}: 0 %", line)
    )
    assert wide.u > exact.u
    assert wide.value == pytest.approx(exact.value, abs=0.02 * exact.u)
