"""Numbers as text: the form is that of the rounded number."""

from __future__ import annotations

import pytest
from pages import LOG

from gyrodata import analyze
from gyrodata.reporting.elements import Numbers
from gyrodata.reporting.values import duration_text


@pytest.mark.parametrize(
    ("share", "text"),
    [
        (0.9996, "+100 %"),
        (-0.9951, "-100 %"),
        (0.994, "+99 %"),
        (1.234, "+123 %"),
        (0.00031, "+0.031 %"),
        (0.0, "0 %"),
        (3e-6, "< 0.001 %"),
    ],
)
def test_per_cent(share: float, text: str) -> None:
    numbers = Numbers(analyze(LOG))
    numbers.record = {"share": share}
    assert str(numbers.percent("share")) == text


def test_uncertainties_and_durations_at_a_limit() -> None:
    numbers = Numbers(analyze(LOG))
    numbers.record = {"u": [99.4, 99.6, 123.0, 0.5]}
    shown = [str(numbers.scatter(f"u.{i}")) for i in range(4)]
    assert shown == ["99", "100", "123", "0.50"]
    assert [duration_text(s) for s in (59.2, 59.7, 61)] == ["59 s", "1 min", "1 min"]
