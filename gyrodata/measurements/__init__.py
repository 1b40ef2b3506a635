"""Measured values in SI, and every uncertainty component with the runs that share it.

`Readings` say what stands in the log; `Measurements` say what it means: a timed interval, a mean spin and a
torque for each run, and a list of `Source`s. A source is one independent cause of error (the reading of one
weight, the zero of the one ruler); runs that share it carry the same group number, so no covariance matrix is
ever typed or built by hand. Readings that stand in several runs are one reading: equal weights share their
error, equal positions share theirs, a spin read once for the whole log is read once.
"""

from gyrodata.error_sources import DEFAULT_TRANSVERSE_RATIO, SOURCES, TRANSVERSE_U, WHOLE
from gyrodata.measurements.measured import Measurements, measure, select, torque_groups, total_spin_excess
from gyrodata.measurements.sources import (
    Source,
    as_spin,
    mean_spin,
    spin_columns,
)
