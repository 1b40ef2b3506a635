"""Logs that mean the same give the same I_zz and u; ``python tests/acceptance/gates
--only relations`` takes more logs.

The fit is enough here: the judgement of a fit changes neither I_zz nor u
(`test_judgement_keeps_the_answer_of_the_fit`), and takes ten times as long. The gate
analyses the logs completely.
"""

import pytest
from simulated_labs import analyze_briefly

import gyrodata
from relations import RELATIONS
from relations.comparison import differences
from relations.log_tables import bases

SLOW = ("heidelberg_ball", "salort_one_torque", "two_days", "contradicting")


@pytest.mark.parametrize("relation", RELATIONS)
def test_logs_that_mean_the_same_give_the_same_answer(relation: str) -> None:
    (wrong,) = differences(relation, most=1, analyze=analyze_briefly, slow=SLOW)
    assert not wrong


def test_judgement_keeps_the_answer_of_the_fit() -> None:
    for table in [*bases().values()][::3]:
        whole = gyrodata.analyze(table.text.encode())
        assert whole.inertia == analyze_briefly(table.text.encode()).inertia
