"""What the tests keep of a log is not taken for another one."""

from __future__ import annotations

import pytest
from places import SAMPLES

from gyrodata import LogError, analysis, read_log
from gyrodata.results import FittedLog, Options

LOG = (SAMPLES / "air_gyroscope.csv").read_text(encoding="utf-8")


def fitted(log: str = LOG, name: str = "a.csv", **options: object) -> FittedLog:
    readings = read_log(log.encode(), name=name)
    return analysis.fit_log(readings, Options(**options))  # type: ignore[arg-type]


def test_another_byte_name_or_option_is_another_fit() -> None:
    first = fitted()
    assert fitted() is first
    others = [
        fitted(LOG + "# a note\n"),
        fitted(LOG.replace(",15.00,", ",15.10,", 1)),
        fitted(name="b.csv"),
        fitted(keep_flagged=True),
    ]
    assert all(other is not first for other in others)
    assert others[1].inertia != first.inertia
    assert others[2].name == "b.csv"


def test_a_refusal_is_raised_again() -> None:
    refused = LOG.replace("[g]", "[t]")
    messages = set()
    for _ in range(2):
        with pytest.raises(LogError) as caught:
            fitted(refused)
        messages.add(str(caught.value))
    assert len(messages) == 1


def test_logs_that_are_analysed_together_are_not_kept() -> None:
    other = LOG.replace(",15.00,", ",15.10,")
    lab = analysis.analyze([LOG.encode(), other.encode()], together=True)
    runs = len(analysis.analyze(LOG.encode()).run_table)
    assert len(lab.run_table) == 2 * runs
