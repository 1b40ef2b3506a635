"""Speed against accuracy, and where methods break: measured on the machine at hand.

`motion_cost` tries the motion models and integrators, `orders` the latter by themselves, among them the
`steppers` that the tool does not use; `trials` the `estimators` on simulated labs with a known truth and on logs that
break them, `fit_curves` while labs become worse; `stability` shows where methods lose digits or die, each beside one
that holds. `timing` says how times are taken. `report` runs all of it and writes it down; the charts are in
`gyrodata.plotting`. The clocks are passed in: all but the times is the same on every run.
"""

from __future__ import annotations

from gyrodata.benchmark.effort import FULL, QUICK, Effort
from gyrodata.benchmark.estimators import TAKE_BALANCE
from gyrodata.benchmark.fit_curves import FitCurve
from gyrodata.benchmark.motion_cost import BATCH, MotionPanel, MotionPoint
from gyrodata.benchmark.orders import Drift, Order
from gyrodata.benchmark.report import Benchmark, csv_tables, percent_text, reading, run_benchmark, time_text
from gyrodata.benchmark.stability import METHODS, MOST_DIGITS, DigitCurve, DigitMap, MapPair, Passage
from gyrodata.benchmark.timing import describe_machine
from gyrodata.benchmark.trials import CHARTED, HONEST, TIE, Breakdown, Trial, TrialPanel, Verdict
