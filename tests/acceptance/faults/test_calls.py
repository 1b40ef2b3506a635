"""Calls to the system that fail, and kills: some of each command here, all of them by
``python tests/acceptance/faults``.
"""

import os
from pathlib import Path

import pytest
from analyzed_once import analyzed_once

from faults.calls import WAYS
from faults.scenes import Promise, try_kills

pytestmark = pytest.mark.skipif(
    not hasattr(os, "fork"), reason="each call fails in a child of its own"
)


@pytest.mark.parametrize(
    ("name", "tries"),
    [("analyze again", 2), ("analyze -o FILE", 4), ("grade again", 4)],
)
def test_call_that_fails_tears_and_loses_nothing(
    name: str, tries: int, tmp_path: Path
) -> None:
    wrong = []
    # Each child has the analysis and the figures of the first run: what it writes is
    # tested.
    with analyzed_once():
        promise = Promise(name, tmp_path)
        for number in range(tries):
            at = 1 + number * (len(promise.calls) - 1) // (tries - 1)
            wrong += promise.break_at(at, WAYS[number % len(WAYS)])
    assert wrong == []


def test_killed_run_is_finished_by_the_next(tmp_path: Path) -> None:
    assert list(try_kills(tmp_path, 1, seed=1, size=5)) == []
