"""Speed against accuracy, and where methods break: measured on the machine at hand.

`motion` tries the motion models and integrators, `trials` the `estimators` on simulated labs with a known truth;
`roots`, `steppers`, `upright` and `breakdowns` map where methods lose digits, die, or give nonsense, each beside one
that holds. `results` runs all of it, `tables` and `reading` write it down; the figures are in `gyrodata.plotting`.
The clock is passed in: all but the times is the same on every run.
"""

from __future__ import annotations

from gyrodata.benchmark.effort import FULL, QUICK, Effort
from gyrodata.benchmark.reading import reading
from gyrodata.benchmark.results import Benchmark, run_benchmark
from gyrodata.benchmark.tables import csv_tables

__all__ = ["FULL", "QUICK", "Benchmark", "Effort", "csv_tables", "reading", "run_benchmark"]
