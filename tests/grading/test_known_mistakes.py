"""Known mistakes: each is found in reports that students would write, and no honest
report is ever given one.
"""

import numpy as np
import pytest
from grading.students_reports import RIGHT, sheet

from gyrodata.analysis import analyze_readings
from gyrodata.grading.rubric import ACCEPTED
from gyrodata.grading.yardsticks import find_slips, own_runs
from gyrodata.readings import read_log
from gyrodata.results import Analysis

TEXTBOOK = ("through_origin", "with_constant", "mean_of_ratios")
ROWS = sheet(np.random.default_rng(3), turns="mixed", imbalance=0.0006, bias=0.03)


def analyzed(text: str) -> Analysis:
    return analyze_readings(read_log(text.encode(), name="log.csv"))


def kinds(analysis: Analysis, *values: float, step: float) -> list[str]:
    own = own_runs(analysis, ACCEPTED)
    found = [
        find_slips(one, step, own, analysis.readings, analysis.measurements)
        for one in values
    ]
    return [slip.kind for slips in found for slip in slips]


@pytest.mark.slow
def test_own_fits_agree_with_least_squares_by_numpy() -> None:
    own = {
        value.name: value for value in own_runs(analyzed(ROWS.log()), ACCEPTED).values
    }
    for fit in TEXTBOOK:
        assert (own[fit].value, own[fit].u) == pytest.approx(
            RIGHT.inertia(ROWS, fit), rel=1e-9
        )
