"""The fits: I_zz from raw readings, with errors carried by what they are shared by.

`fit` is the recommended one and `screen` finds the runs that do not go with the others; `TEXTBOOK`
has the fits of the textbook, to compare with, and `fit_line` one for points with errors in both variables. Read
`conditions` for what is fitted and `adjustment` for how.
"""

from gyrodata.fitting.conditions import MAD_TO_SD, torques_differ, transverse_inertia
from gyrodata.fitting.design import Design, design_of, expected_u
from gyrodata.fitting.estimates import Estimate, FitResult, NoFit, Outlier, Share, insist_on_solution
from gyrodata.fitting.inertia import (
    Otherwise,
    balance_scale,
    fit,
    fit_as_stated,
    fit_otherwise,
    if_balanced,
    lightest_torque,
    refit,
    times_stated,
)
from gyrodata.fitting.lines import LineFit, chi2_tail, fit_line
from gyrodata.fitting.many import ManyFits, fit_many
from gyrodata.fitting.posterior import K_95, doubt_of_widths, scatter_prior
from gyrodata.fitting.screening import OUTLIER, TURN_COUNTS, explaining_counts, screen
from gyrodata.fitting.slowing import against_stars, phase_known, slowed, unslowed
from gyrodata.fitting.start import sample
from gyrodata.fitting.textbook import (
    TEXTBOOK,
    Line,
    insist_on_lines,
    mean_of_ratios,
    ordinary_line,
    through_origin,
    with_constant,
)
from gyrodata.measurements import DEFAULT_TRANSVERSE_RATIO

__all__ = [
    "DEFAULT_TRANSVERSE_RATIO",
    "K_95",
    "MAD_TO_SD",
    "OUTLIER",
    "TEXTBOOK",
    "TURN_COUNTS",
    "Design",
    "Estimate",
    "FitResult",
    "Line",
    "LineFit",
    "ManyFits",
    "NoFit",
    "Otherwise",
    "Outlier",
    "Share",
    "against_stars",
    "balance_scale",
    "chi2_tail",
    "design_of",
    "doubt_of_widths",
    "expected_u",
    "explaining_counts",
    "fit",
    "fit_as_stated",
    "fit_line",
    "fit_many",
    "fit_otherwise",
    "if_balanced",
    "insist_on_lines",
    "insist_on_solution",
    "lightest_torque",
    "mean_of_ratios",
    "ordinary_line",
    "phase_known",
    "refit",
    "sample",
    "scatter_prior",
    "screen",
    "slowed",
    "through_origin",
    "times_stated",
    "torques_differ",
    "transverse_inertia",
    "unslowed",
    "with_constant",
]
