"""Numbers as text: the form is that of the rounded number."""

from __future__ import annotations

import pytest

from gyrodata.reporting.values import duration_text, percent_text, uncertainty_text


@pytest.mark.parametrize(
    ("share", "text"),
    [
        (0.9996, "+100 %"),
        (-0.9951, "-100 %"),
        (0.994, "+99 %"),
        (1.234, "+123 %"),
        (0.00031, "+0.031 %"),
        (0.0, "0 %"),
    ],
)
def test_per_cent(share: float, text: str) -> None:
    assert percent_text(share) == text


def test_uncertainties_and_durations_at_a_limit() -> None:
    assert [uncertainty_text(u) for u in (99.4, 99.6, 123.0)] == ["99", "100", "123"]
    assert [duration_text(s) for s in (59.2, 59.7, 61)] == ["59 s", "1 min", "1 min"]
