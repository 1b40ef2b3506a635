"""Programs that fit a lab: cost against error and coverage, over the same labs.

Error: 68 % of the labs have a smaller one; so one lab with a gross mistake does not
decide. Coverage: the part of all labs whose 95 % interval contains the true I_zz; a lab
without an answer is not covered.
"""

from __future__ import annotations

import math
import os
import pickle
import subprocess
import sys
import time
import warnings
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from gyrodata import fitting
from gyrodata.analysis import analyze_readings
from gyrodata.base.errors import GyroError
from gyrodata.fitting import Estimate
from gyrodata.measurements import Measurements
from gyrodata.readings import read_log
from gyrodata.trials.benchmark import programs
from gyrodata.trials.benchmark.labs import LabScene, lab_of, measured_lab
from gyrodata.trials.benchmark.programs import NORMAL_95

if TYPE_CHECKING:
    import pandas as pd

GYRO_FIT = "one fit of gyro"
GYRO = "gyro analyze"

CLOSER = 0.68
"""Part of the labs whose error is smaller than the error of a program [1]."""

STATED = 0.95
"""The coverage that every interval states [1]."""

WARM = 0.25
"""Part of the labs that take less time than the stated one [1]."""

Answer = tuple[float, float, float, bool]
"""I_zz, the ends of its 95 % interval [kg*m^2], and whether the program reacts to the
log, such as by a warning."""


def fit_lab(scene: LabScene, seed: int) -> list[dict[str, Any]]:
    """Apply all programs to one lab."""
    log = scene.draw(seed)
    measured = measured_lab(log)
    lab = lab_of(measured)
    tasks: dict[str, Callable[[], Any]] = {
        name: partial(fit, lab) for name, fit in programs.installed().items()
    }
    tasks[GYRO_FIT] = partial(fit_once, measured)
    tasks[GYRO] = partial(analyze, log)
    return timed_answers(tasks, scene.truth.inertia, scene=scene.title)


def timed_answers(
    tasks: Mapping[str, Callable[[], Any]], truth: float, **where: Any
) -> list[dict[str, Any]]:
    """Do fits; return the answer of each over the true I_zz, and its CPU time [s].

    A fit without an answer is NaN, and a reaction.
    """
    refusals = GyroError, fitting.NoFit, ValueError, RuntimeError
    rows = []
    for name, task in tasks.items():
        begun = time.process_time()
        value, low, high, *reacts = math.nan, math.nan, math.nan, True
        # A warning does not change the answer, which is what is compared.
        with suppress(*refusals), warnings.catch_warnings(action="ignore"):
            value, low, high, *reacts = task()
        answered = {
            "method": name,
            "value": value / truth,
            "low": low / truth,
            "high": high / truth,
            "reacts": any(reacts),
            "seconds": time.process_time() - begun,
        }
        rows.append(where | answered)
    return rows


def fit_once(measured: Measurements) -> Answer:
    """Fit all runs once."""
    return answer(fitting.fit(measured).inertia, False)


def analyze(log: str) -> Answer:
    """Do all that the command does, without writing a report."""
    analysis = analyze_readings(read_log(log.encode()))
    return answer(analysis.fit.inertia, bool(analysis.doubts))


def answer(inertia: Estimate, reacts: bool) -> Answer:
    """Return an answer of gyro as those of the other programs."""
    low, high = inertia.interval_95 or (math.nan, math.nan)
    return inertia.value, low, high, reacts


def process_cost(name: str, log: str) -> list[dict[str, Any]]:
    """Measure the CPU time of a whole process that fits a lab [s]."""
    words = [programs.__file__, name]
    data = pickle.dumps(lab_of(measured_lab(log)))
    if name == GYRO:
        words = ["-m", "gyrodata", "analyze", "--no-report", "-"]
        data = log.encode()
    before = children_time()
    command = [sys.executable, *words]
    subprocess.run(command, input=data, capture_output=True, check=True)
    return [{"method": name, "process": children_time() - before}]


def children_time() -> float:
    """Return the CPU time of all processes that this one has started [s]."""
    times = os.times()
    return times.children_user + times.children_system


def summary(rows: pd.DataFrame, *where: str) -> pd.DataFrame:
    """Compare the answers of each method with the truth, in each place of a chart."""
    import pandas as pd

    keys = [*where, "method"]
    groups = rows.groupby(keys, sort=False)
    return pd.DataFrame(
        [dict(zip(keys, key, strict=True)) | score(group) for key, group in groups]
    )


def score(answers: pd.DataFrame) -> dict[str, Any]:
    """Compare the answers of one method with the true I_zz, which is 1.

    The error and the coverage have a 95 % interval, from the number of labs. "length" is
    the stated half length of the intervals over the needed one, which contains 95 % of
    the errors, and "bias" the mean error over the stated u.
    """
    from scipy.stats import binomtest, quantile_test

    value, low, high = answers[["value", "low", "high"]].to_numpy().T
    covered = int(np.sum((low <= 1) & (high >= 1)))
    coverage = binomtest(covered, len(value)).proportion_ci(method="wilson")
    errors = value[np.isfinite(value)] - 1
    refused = len(value) - len(errors)
    if refused == len(value):
        errors = np.array([math.nan])
    sizes = np.abs(errors)
    error, largest = np.quantile(sizes, [CLOSER, STATED]).tolist()
    near = quantile_test(sizes, p=CLOSER).confidence_interval()
    half_length = answers["high"].sub(low).median() / 2
    return {
        "labs": len(value),
        "error": error,
        "error_low": float(near.low),
        "error_high": float(near.high),
        "coverage": covered / len(value),
        "coverage_low": float(coverage.low),
        "coverage_high": float(coverage.high),
        "length": half_length / largest,
        "bias": float(errors.mean()) / half_length * NORMAL_95,
        "refused": refused,
        "reacts": float(answers["reacts"].mean()),
        # The slowest calls also import their program.
        "seconds": float(answers["seconds"].quantile(WARM)),
    }


def title(scores: pd.DataFrame) -> str:
    """Name the programs that are correct most often, and the cheapest in each kind."""
    is_correct = scores["coverage_low"].le(STATED) & scores["coverage_high"].ge(STATED)
    counts = is_correct.groupby(scores["method"], sort=False).sum()
    most = counts.max()
    best = " and ".join(counts[counts == most].index) if most else "no program"
    kinds = scores["scene"].nunique()
    head = f"A correct 95 % interval in {most} of {kinds} kinds of labs: {best}"
    return "\n".join([head, "The cheapest correct one:", *cheapest(scores, is_correct)])


def cheapest(points: pd.DataFrame, is_good: pd.Series) -> list[str]:
    """Name the good method that needs the least time in each scene, with its time."""
    lines = []
    for scene, rows in points.groupby("scene", sort=False):
        good = rows[is_good[rows.index]].sort_values("seconds")
        words = "none"
        if len(good):
            best = good.iloc[0]
            milliseconds = float(f"{1e3 * best['seconds']:.1g}")
            words = f"{best['method']}, {milliseconds:g} ms"
        lines.append(f"{scene}: {words}")
    return lines
