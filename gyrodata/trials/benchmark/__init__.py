"""The benchmark: speed against accuracy, and cases in which methods fail.

There are four parts with one chart each. `motions` compares models and integrators of
the motion, `estimators` compares fits of simulated labs with a known truth, and
`failures` shows for each failure of a method a solution. `report` runs all parts and
writes tables. The clock is an argument: everything except times is the same for the
same seed.
"""

from gyrodata.trials.benchmark.estimators import HONEST, TrialPanel
from gyrodata.trials.benchmark.failures import Failure
from gyrodata.trials.benchmark.motions import (
    FULL,
    METHODS,
    QUICK,
    Effort,
    MotionPanel,
    Order,
    cheapest,
)
from gyrodata.trials.benchmark.report import (
    Benchmark,
    csv_tables,
    describe_machine,
    power,
    reading,
    run_benchmark,
)
