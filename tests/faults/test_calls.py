"""Calls to the system that fail, and kills: some of each command here, all of them by ``python tests/faults``."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from faults.calls import WAYS
from faults.kills import try_kills
from faults.scenes import Promise

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="each call fails in a child of its own")


@pytest.mark.parametrize(
    ("name", "tries"), [("analyze again", 16), ("analyze -o FILE", 8), ("check", 4), ("grade again", 12)]
)
def test_call_that_fails_tears_and_loses_nothing(name: str, tries: int, tmp_path: Path) -> None:
    promise, wrong = Promise(name, tmp_path), []
    for number in range(tries):
        at = 1 + number * (len(promise.calls) - 1) // (tries - 1)
        wrong += promise.break_at(at, WAYS[number % len(WAYS)])
    assert wrong == []


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="workers are found in /proc")
def test_kill_of_driver_or_worker_loses_nothing(tmp_path: Path) -> None:
    assert list(try_kills(tmp_path, 2, seed=1)) == []
