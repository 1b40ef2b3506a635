"""The fits: I_zz from raw readings, with errors carried by what they are shared by.

`fit` is the recommended one and `screen` finds the runs that do not go with the others; `ordinary_line` is the
line of the textbook, to compare with, and `fit_line` one for points with errors in both variables. Read
`conditions` for what is fitted and `adjustment` for how.
"""

from gyrodata.fitting.chi_square import chi2_tail
from gyrodata.fitting.conditions import DEFAULT_TRANSVERSE_RATIO, transverse_inertia
from gyrodata.fitting.counts import explaining_counts
from gyrodata.fitting.design import Design, design_of, expected_u
from gyrodata.fitting.inertia import DEFAULT_IMBALANCE_U, fit
from gyrodata.fitting.lines import LineFit, fit_line
from gyrodata.fitting.many import ManyFits, fit_many
from gyrodata.fitting.profile import profile_interval
from gyrodata.fitting.results import Estimate, FitResult, NoFit, Outlier, Share
from gyrodata.fitting.screening import OUTLIER, TURN_COUNTS, screen
from gyrodata.fitting.start import torques_differ
from gyrodata.fitting.textbook import Line, ordinary_line
from gyrodata.fitting.trust import insist_on_lines, insist_on_solution

__all__ = [
    "DEFAULT_IMBALANCE_U",
    "DEFAULT_TRANSVERSE_RATIO",
    "OUTLIER",
    "TURN_COUNTS",
    "Design",
    "Estimate",
    "FitResult",
    "Line",
    "LineFit",
    "ManyFits",
    "NoFit",
    "Outlier",
    "Share",
    "chi2_tail",
    "design_of",
    "expected_u",
    "explaining_counts",
    "fit",
    "fit_line",
    "fit_many",
    "insist_on_lines",
    "insist_on_solution",
    "ordinary_line",
    "profile_interval",
    "screen",
    "torques_differ",
    "transverse_inertia",
]
