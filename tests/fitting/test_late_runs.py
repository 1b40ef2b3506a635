"""Runs whose clock was stopped late: they hardly count in the answer.

All logs are simulated: 9 runs at 15 cm, true I_zz 4.44e-3 kg·m², seeds 0 to 3.
"""

from __future__ import annotations

import numpy as np
import pytest
from simulated_labs import analyze_briefly

from gyrodata.results import FittedLog

TRUTH = 4.44e-3
TORQUE = 9.80665 * 0.15
RPM = 2 * np.pi / 60


def log(seed: int, late: dict[int, float]) -> bytes:
    """Draw a lab with a press of 0.14 s; some runs are late by some seconds."""
    random = np.random.default_rng([69, seed])
    rows = ["# motion: steady", "mass [g],position [cm],spin [rpm],time [s],turns"]
    for run in range(9):
        mass, spin = 20 * (1 + run // 3), 200 * (1 + run % 3)
        time = 2 * np.pi * TRUTH * spin * RPM / (1e-3 * mass * TORQUE)
        time += 0.14 * random.standard_normal() + late.get(run, 0.0)
        read = spin * (1 + 0.002 * random.standard_normal())
        rows.append(f"{mass}.0,15.0,{read:.1f},{time:.2f},1")
    return "\n".join([*rows, ""]).encode()


@pytest.mark.filterwarnings("ignore")
def analyze(seed: int, late: dict[int, float]) -> FittedLog:
    return analyze_briefly(log(seed, late), name="lab.csv")


def half(found: FittedLog) -> float:
    low, high = found.inertia.interval_95
    return float(high - low) / 2


def hints(found: FittedLog) -> str:
    return " ".join(one.hint for one in found.diagnostics if one.code == "G411")


@pytest.mark.parametrize("seed", range(4))
def test_a_late_run_hardly_counts(seed: int) -> None:
    clean, late = analyze(seed, {}), analyze(seed, {4: 1.4})
    assert abs(late.inertia.value - clean.inertia.value) < 0.7 * clean.inertia.u
    assert half(late) < 1.5 * half(clean)
    assert "5 was perhaps stopped late" in hints(late)
    assert len(late.run_table) == 9
    assert not any(run.left_out for run in late.run_table)


def test_a_clock_is_never_stopped_seconds_early() -> None:
    early = analyze(0, {4: -1.4})
    assert "stopped late" not in hints(early)
    assert half(early) > half(analyze(0, {4: 1.4}))


def test_a_lab_as_assumed_has_no_late_run() -> None:
    for seed in range(4):
        assert hints(analyze(seed, {})) == ""


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_the_interval_contains_the_truth_if_runs_are_late() -> None:
    inside = []
    for seed in range(8):
        random = np.random.default_rng([70, seed])
        runs = np.flatnonzero(random.random(9) < 0.2).tolist()
        late = {run: float(random.uniform(1, 3)) for run in runs}
        low, high = analyze(seed, late).inertia.interval_95
        inside.append(low <= TRUTH <= high)
    assert np.mean(inside) >= 0.85
