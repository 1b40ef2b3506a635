"""The tables beside the answer: other fits, what it hangs on, the report's laws, each torque, each run, the ball."""

from __future__ import annotations

from gyrodata.comparisons.doubts import CHANCE, Pattern, look_for_patterns, pattern_words
from gyrodata.comparisons.tables import (
    Ball,
    Constancy,
    Exponent,
    NamedFit,
    PowerLaw,
    Run,
    Torque,
    compare_with_ball,
    constancy,
    load_words,
    named_fits,
    outlier_reason,
    overall_exponent,
    power_laws,
    run_table,
    torque_table,
    turn_words,
)

__all__ = [
    "CHANCE",
    "Ball",
    "Constancy",
    "Exponent",
    "NamedFit",
    "Pattern",
    "PowerLaw",
    "Run",
    "Torque",
    "compare_with_ball",
    "constancy",
    "load_words",
    "look_for_patterns",
    "named_fits",
    "outlier_reason",
    "overall_exponent",
    "pattern_words",
    "power_laws",
    "run_table",
    "torque_table",
    "turn_words",
]
