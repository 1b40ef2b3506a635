"""The fits: I_zz from raw readings, with errors carried by what they are shared by.

`fit` is the recommended one and `screen` finds the runs that do not go with the others; `TEXTBOOK`
has the fits of the textbook, to compare with, and `fit_line` one for points with errors in both variables. Read
`conditions` for what is fitted and `adjustment` for how.
"""

from gyrodata.fitting.adjustment import NoFit, sample
from gyrodata.fitting.conditions import MAD_TO_SD, MANY, NEGLIGIBLE, torques_differ, transverse_inertia
from gyrodata.fitting.corrections import (
    ChosenModel,
    Model,
    corrected,
    earth_is_told,
    fit_model,
    is_corrected,
)
from gyrodata.fitting.inertia import (
    AS_STATED,
    Estimate,
    FitResult,
    Outlier,
    Share,
    Widths,
    balance_scale,
    fit,
    lightest_torque,
    times_stated,
)
from gyrodata.fitting.lines import (
    TEXTBOOK,
    LineFit,
    chi2_lower_tail,
    chi2_tail,
    fit_line,
    insist_on_lines,
    mean_of_ratios,
    ordinary_line,
)
from gyrodata.fitting.posterior import K_95, doubt_of_widths, scatter_prior
from gyrodata.fitting.screening import USUAL_COUNTS, explaining_counts, rivals, screen
from gyrodata.measurements import DEFAULT_TRANSVERSE_RATIO
