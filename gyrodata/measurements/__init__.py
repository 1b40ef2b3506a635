"""Measured values in SI, and every uncertainty component with the runs that share it.

`Readings` go in, and `Measurements` come out: a timed interval, a mean spin and a torque
for each run, and a list of `Source`s. Nothing here is fitted, and no run is left out.

`Readings` contain the text of a log; `Measurements` contain its meaning. A source is
one independent cause of error, such as the reading of one weight or the zero of the
ruler. Runs that share it have the same group number, so no covariance matrix is needed.
If a reading is written in several runs, it is one reading: equal weights share their
error, and so do equal positions.
"""

from gyrodata.measurements.blocks import (
    BALANCE_CHANGE,
    DAY_BALANCE,
    DAY_BIAS,
    PLACED,
    balance_sources,
    contrast_sources,
    contrasts,
    share_of_mean,
)
from gyrodata.measurements.measured import (
    Measurements,
    measure,
    select,
    total_spin_excess,
)
from gyrodata.measurements.sources import REVOLUTION, Source, as_spin, spin_columns
from gyrodata.quantities.error_sources import (
    DEFAULT_TRANSVERSE_RATIO,
    SOURCES,
    TRANSVERSE_U,
    WHOLE,
)
