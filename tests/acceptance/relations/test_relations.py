"""Logs that mean the same give the same I_zz and u; ``python tests/acceptance/gates
--only relations`` takes more logs.
"""

import pytest

from relations import RELATIONS
from relations.comparison import differences


@pytest.mark.parametrize("relation", RELATIONS)
def test_logs_that_mean_the_same_give_the_same_answer(relation: str) -> None:
    wrong = [line for line in differences(relation, most=2) if line]
    assert not wrong, "\n".join(wrong)
