"""The tables beside the answer: other fits, the laws of the report, each torque, each run, the solid ball."""

from __future__ import annotations

from gyrodata.comparisons.fits import NamedFit, Torque, named_fits, torque_table
from gyrodata.comparisons.laws import Constancy, Exponent, PowerLaw, constancy, overall_exponent, power_laws
from gyrodata.comparisons.runs import Ball, Run, compare_with_ball, load_words, outlier_reason, run_table, turn_words

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
