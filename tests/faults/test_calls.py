"""Calls to the system that fail: some of each command here, all of them by ``python tests/faults``."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from faults.calls import WAYS
from faults.scenes import Promise, scene_of

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="each call fails in a child of its own")


@pytest.fixture(autouse=True)
def _as_it_was(monkeypatch: pytest.MonkeyPatch) -> None:
    """See that what is remembered of a log is for these tests only."""
    import gyrodata.analysis
    import gyrodata.reporting

    monkeypatch.setattr(gyrodata.analysis, "analyze_readings", gyrodata.analysis.analyze_readings)
    monkeypatch.setattr(gyrodata.reporting, "report_files", gyrodata.reporting.report_files)


@pytest.mark.parametrize(
    ("name", "tries"),
    [("analyze again", 16), ("analyze -o FILE", 8), ("check", 4), ("watch", 4), ("grade again", 16)],
)
def test_a_call_that_fails_tears_and_loses_nothing(name: str, tries: int, tmp_path: Path) -> None:
    promise = Promise(scene_of(name, tmp_path, size=4), tmp_path)
    wrong = [told for at, way in chosen(len(promise.calls), tries) for told in promise.break_at(at, way)]
    assert wrong == []


def chosen(calls: int, tries: int) -> Iterator[tuple[int, str]]:
    """Take calls from the first to the last, and the ways in turn."""
    for number in range(tries):
        yield 1 + number * (calls - 1) // (tries - 1), WAYS[number % len(WAYS)]
