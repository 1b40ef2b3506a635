"""The fits: I_zz from raw readings, with errors that runs share.

`Measurements` go in, and a `FitResult` comes out: I_zz, the residual torque M0 and the
timing bias b with their uncertainties. Runs without a solution raise `NoFit`. Nothing
here reads a log, or chooses the runs: the caller says which ones are left out, and asks
whether the answer is credible.

`fit` fits the given runs of one log, and `screen` finds the runs that do not agree with
the others; `recommend` of `judging` uses both. `TEXTBOOK` contains the textbook fits
for comparison. `fit_line` fits a line to points with errors in both variables.
`adjustment` contains the equation that is fitted.
"""

# ruff: noqa: I001 - the lists below are packed
from gyrodata.fitting.adjustment import (
    MAD_TO_SD,
    MANY,
    NEGLIGIBLE,
    NoFit,
    lightest_torque,
    median,
    sample,
)
from gyrodata.fitting.adjustment import (
    rough_inertia,
    torques_differ,
    transverse_inertia,
)
from gyrodata.fitting.inertia import (
    AS_STATED,
    UNLIKELY,
    Estimate,
    FitResult,
    Outlier,
    Share,
    Widths,
    balance_scale,
    fit,
    fit_model,
    integrate_at,
    relative_u,
    timed_runs,
    times_stated,
    top_of,
)
from gyrodata.fitting.lines import LineFit, fit_line
from gyrodata.fitting.posterior import (
    chi2_tail,
    doubt_of_widths,
)
from gyrodata.fitting.screening import (
    TEXTBOOK,
    insist_on_lines,
    ordinary_line,
    screen,
)
from gyrodata.measurements import DEFAULT_TRANSVERSE_RATIO
