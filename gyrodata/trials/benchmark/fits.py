"""Programs that fit a lab: cost against error and coverage, over the same labs.

Error: 68 % of the labs have a smaller one; so one lab with a gross mistake does not
decide. Coverage: the part of all labs whose 95 % interval contains the true I_zz; a lab
without an answer is not covered.
"""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from gyrodata import fitting
from gyrodata.analysis import analyze_readings
from gyrodata.base.errors import LogError
from gyrodata.fitting import Estimate
from gyrodata.measurements import Measurements
from gyrodata.physics import Floats
from gyrodata.readings import read_log
from gyrodata.trials.benchmark import programs
from gyrodata.trials.benchmark.labs import (
    LabScene,
    lab_of,
    measured_lab,
)
from gyrodata.trials.benchmark.programs import NORMAL_95

if TYPE_CHECKING:
    import pandas as pd

GYRO_FIT = "gyro, one fit"
GYRO = "gyro analyze"

CLOSER = 0.68
"""Part of the labs whose error is smaller than the error of a program [1]."""

STATED = 0.95
"""The coverage that every interval states [1]."""

REPEATS = 3
"""Number of processes whose cost is measured."""

Row = dict[str, Any]
"""One line of a table."""

Answer = tuple[float, float, float, bool]
"""I_zz, the ends of its 95 % interval [kg*m^2], and whether the program warns."""


def fit_lab(scene: LabScene, seed: int) -> list[Row]:
    """Apply all programs to one lab."""
    log = scene.draw(seed)
    measured = measured_lab(log)
    lab = lab_of(measured)
    tasks: dict[str, Callable[[], Any]] = {
        name: partial(fit, lab) for name, fit in programs.installed().items()
    }
    tasks[GYRO_FIT] = partial(fit_once, measured)
    tasks[GYRO] = partial(analyze, log)
    rows = timed_answers(tasks, scene.truth.inertia)
    return [{"scene": scene.title, **row} for row in rows]


def timed_answers(
    tasks: Mapping[str, Callable[[], Any]], truth: float
) -> Iterator[Row]:
    """Do fits; yield the answer of each over the true I_zz, and its CPU time [s]."""
    for name, task in tasks.items():
        begun = time.process_time()
        value, low, high, *warned = answer_of(task)
        yield {
            "program": name,
            "value": value / truth,
            "low": low / truth,
            "high": high / truth,
            "warned": any(warned),
            "seconds": time.process_time() - begun,
        }


def answer_of(task: Callable[[], Any]) -> Any:
    """Do a fit; NaN and a warning if it gives no answer."""
    with warnings.catch_warnings():
        # A warning does not change the answer, which is what is compared.
        warnings.simplefilter("ignore")
        try:
            return task()
        except (LogError, fitting.NoFit, ValueError, RuntimeError):
            return math.nan, math.nan, math.nan, True


def fit_once(measured: Measurements) -> Answer:
    """Fit all runs once."""
    return answer(fitting.fit(measured).inertia, False)


def analyze(log: str) -> Answer:
    """Do all that the command does, without writing a report."""
    analysis = analyze_readings(read_log(log.encode()))
    return answer(analysis.fit.inertia, bool(analysis.doubts))


def answer(inertia: Estimate, warned: bool) -> Answer:
    """Return an answer of gyro as those of the other programs."""
    low, high = inertia.interval_95 or (math.nan, math.nan)
    return inertia.value, low, high, warned


def summary(rows: pd.DataFrame, keys: list[str]) -> pd.DataFrame:
    """Compare the answers with the truth, in one row for each value of some columns."""
    import pandas as pd

    groups = rows.groupby(keys, sort=False)
    return pd.DataFrame(
        [dict(zip(keys, key, strict=True)) | score(group) for key, group in groups]
    )


def score(answers: pd.DataFrame) -> Row:
    """Compare the answers of one program with the true I_zz, which is 1.

    The interval of the error and of the coverage is the one of 95 %, from the number of
    labs. "length" is the stated half length of the intervals over the needed one, which
    contains 95 % of the errors, and "bias" the mean error over the stated u.
    """
    value, low, high = answers[["value", "low", "high"]].to_numpy().T
    covered = (low <= 1) & (high >= 1)
    coverage_low, coverage_high = wilson(float(covered.mean()), len(value))
    errors = value[np.isfinite(value)] - 1
    middle, error_low, error_high = quantile(np.abs(errors), CLOSER)
    half_length = float(np.nanmedian(high - low)) / 2
    return {
        "labs": len(value),
        "error": middle,
        "error_low": error_low,
        "error_high": error_high,
        "coverage": float(covered.mean()),
        "coverage_low": coverage_low,
        "coverage_high": coverage_high,
        "length": half_length / float(np.quantile(np.abs(errors), STATED)),
        "bias": float(errors.mean()) / half_length * NORMAL_95,
        "refused": len(value) - len(errors),
        "warned": float(answers["warned"].mean()),
        "seconds": float(answers["seconds"].median()),
    }


def quantile(values: Floats, part: float) -> Any:
    """Return a quantile of values and its 95 % interval, by the order of the values."""
    spread = NORMAL_95 * math.sqrt(part * (1 - part) / len(values))
    parts = np.clip([part, part - spread, part + spread], 0, 1)
    return np.quantile(values, parts).tolist()


def wilson(part: float, count: int) -> tuple[float, float]:
    """Return Wilson's 95 % interval of a probability, from a part of the labs [1]."""
    square = NORMAL_95**2 / count
    middle = (part + square / 2) / (1 + square)
    half = math.sqrt(part * (1 - part) * square + square**2 / 4) / (1 + square)
    # The interval contains the part, also where it is rounded.
    return min(max(middle - half, 0.0), part), max(min(middle + half, 1.0), part)


# --- the cost of a whole process ---


def process_cost(name: str, log: str) -> list[Row]:
    """Measure the CPU time of a process that fits one lab [s], the median of some."""
    measured = measured_lab(log)
    words = [programs.__file__, name]
    text = json.dumps(lab_of(measured))
    if name == GYRO:
        words = ["-m", "gyrodata", "analyze", "--no-report", "-"]
        text = log
    path = os.pathsep.join(filter(None, sys.path))
    costs = []
    for _ in range(REPEATS):
        before = os.times()
        subprocess.run(
            [sys.executable, *words],
            input=text.encode(),
            capture_output=True,
            check=True,
            env={**os.environ, "PYTHONPATH": path},
        )
        after = os.times()
        user = after.children_user - before.children_user
        costs.append(user + after.children_system - before.children_system)
    return [{"program": name, "process": float(np.median(costs))}]
