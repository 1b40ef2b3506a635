"""Tasks in processes of their own: one that ends its process costs only itself."""

from __future__ import annotations

import os
from concurrent.futures import ProcessPoolExecutor

from gyrodata.base.workers import Failed, in_workers


def _work(number: int) -> int:
    if number == 2:
        os._exit(7)
    return 10 * number


def test_a_task_that_ends_its_process_costs_only_itself() -> None:
    for workers in (1, 2):
        answers = dict(in_workers(_work, [1, 2, 3], workers, 20.0))
        assert isinstance(answers.pop(2), Failed)
        assert answers == {1: 10, 3: 30}


def test_tasks_that_a_cluster_loses_are_not_done_in_this_process() -> None:
    with ProcessPoolExecutor(2) as cluster:
        answers = dict(in_workers(_work, [1, 2, 3], 0, 20.0, cluster))
    assert isinstance(answers.pop(2), Failed)
    assert answers == {1: 10, 3: 30}
