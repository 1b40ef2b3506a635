"""The tables beside the answer: other fits, the laws of the report, each torque, each run, the solid ball."""

from __future__ import annotations

from gyrodata.comparisons.ball import Ball, compare_with_ball
from gyrodata.comparisons.fits import NamedFit, named_fits
from gyrodata.comparisons.laws import Constancy, Exponent, PowerLaw, constancy, overall_exponent, power_laws
from gyrodata.comparisons.runs import Run, load_words, outlier_reason, run_table, turn_words
from gyrodata.comparisons.torques import Torque, torque_table

__all__ = [
    "Ball",
    "Constancy",
    "Exponent",
    "NamedFit",
    "PowerLaw",
    "Run",
    "Torque",
    "compare_with_ball",
    "constancy",
    "load_words",
    "named_fits",
    "outlier_reason",
    "overall_exponent",
    "power_laws",
    "run_table",
    "torque_table",
    "turn_words",
]
