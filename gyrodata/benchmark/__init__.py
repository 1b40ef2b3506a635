"""Speed against accuracy, and where methods fail: measured on the machine at hand.

There are four parts, with a chart each. `motion_cost` tries models of the motion in labs as they are, `orders`
integrators by themselves, `estimators` the fits on simulated labs with a known truth, and `failures` shows for each
failure of a method a solution. `report` runs all of it and writes it down; the charts are in `gyrodata.plotting`. The
clock is passed in: everything except the times is the same on every run with the same seed.
"""

from __future__ import annotations

from gyrodata.benchmark.effort import FULL, QUICK, Effort
from gyrodata.benchmark.estimators import HONEST, TrialPanel
from gyrodata.benchmark.failures import Failure
from gyrodata.benchmark.motion_cost import MotionPanel
from gyrodata.benchmark.orders import METHODS, Order, cheapest
from gyrodata.benchmark.report import Benchmark, csv_tables, describe_machine, power, reading, run_benchmark
