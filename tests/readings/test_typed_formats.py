"""A hundred logs in formats that somebody typed who did not know gyro, and twenty traps.

`typed_formats.txt` contains them: simulated labs of 6 to 12 runs, with 0.1 s of noise in
the times and 0.2 % in the spins. The line above each log says its encoding, and the
I_zz that was simulated [kg*m^2], or "must ask" if the log lacks something. A log may be
refused with a question. But what is read must be right, and a trap is never answered
wrongly without a warning.
"""

from __future__ import annotations

from typing import NamedTuple

import pytest
from places import DATA
from simulated_labs import analyze_briefly, kinds_of_doubts

import gyrodata
from gyrodata.results import FittedLog

pytestmark = pytest.mark.slow

ASKED = {
    "011_note_half.csv": "half a turn in a sentence with words that are not known",
    "026_battery.csv": 'laps with a "lap time total"',
    "028_uncert_cols.csv": '"dspin" beside "spin"',
    "032_hdr_symbols.csv": "a legend in one sentence",
    "044_ratio_cols.csv": '"[#]" for a number',
    "069_nihongo.csv": "a word for precession that is not known",
    "047_kugelkreisel.csv": "a legend of two spins",
    "076_transposed.csv": "the names are at the side",
    "077_transponowana.csv": "the names are at the side",
    "082_ten_revs.csv": '"ball revolutions" that are timed',
    "086_spalten.json": '"Drehzahl_U_min", with two parts behind the name',
    "088_sentences.txt": "runs in sentences",
    "090_side_by_side.csv": "tables side by side",
    "089_keyvalue.txt": "one quantity in each line",
    "087_nested.json": "lists inside of lists",
    "091_pivot.csv": "a crossed table, with weights in the header",
    "094_clock_start_stop.csv": "start and stop of a clock",
    "096_utf16.txt": "a unit in Turkish",
    "099_vecka.csv": "words for before and after in Swedish",
}
"""Logs that are asked about although nothing is missing, with the reason."""


class Typed(NamedTuple):
    """A log of `typed_formats.txt`."""

    name: str
    data: bytes
    inertia: str
    comment: str

    def analyze(self) -> gyrodata.Analysis:
        return gyrodata.analyze(self.data, name=self.name)

    def fit(self) -> FittedLog | None:
        """Return the fit; None if the log is refused with an error."""
        try:
            return analyze_briefly(self.data, name=self.name)
        except gyrodata.GyroError:
            return None

    def is_right(self, analysis: FittedLog) -> bool:
        """Return whether I_zz is within 3 u or 3 % of the simulated one."""
        truth = float(self.inertia)
        allowed = max(3 * analysis.inertia.u, 0.03 * truth)
        return abs(analysis.inertia.value - truth) <= allowed


def typed(kind: str) -> list[Typed]:
    """Read the logs, or the traps."""
    text = (DATA / "typed_formats.txt").read_text(encoding="utf-8")
    logs = []
    for record in text.split("===== ")[1:]:
        head, _, log = record.partition("\n")
        name, encoding, inertia, comment = head.split(" | ", 3)
        if name.startswith(f"{kind} "):
            data = log.rstrip("\n").encode(encoding)
            logs.append(Typed(name.removeprefix(f"{kind} "), data, inertia, comment))
    return logs


LOGS, TRAPS = typed("log"), typed("trap")


def name_of(log: Typed) -> str:
    return log.name


@pytest.mark.filterwarnings("ignore::gyrodata.GyroWarning")
@pytest.mark.parametrize("log", LOGS, ids=name_of)
def test_an_honest_log_is_read_rightly_or_asked_about(log: Typed) -> None:
    fit = log.fit()
    if log.inertia == "must ask":
        assert fit is None
    elif fit is None:
        assert log.name in ASKED
    else:
        assert log.is_right(fit)
        assert [found for found in fit.diagnostics if found.doubt] == []
        # The doubts about the ball and the exponent take the complete analysis: that
        # of each log with a ball, and of one in fifty of the others.
        if fit.readings.constants.get("ball_mass") or LOGS.index(log) % 50 == 0:
            assert log.analyze().doubts == ()


@pytest.mark.filterwarnings("ignore::gyrodata.GyroWarning")
@pytest.mark.parametrize("trap", TRAPS, ids=name_of)
def test_a_trap_is_not_answered_wrongly_in_silence(trap: Typed) -> None:
    fit = trap.fit()
    if fit and not trap.is_right(fit) and not kinds_of_doubts(fit):
        # Some doubts are only found by the complete analysis.
        assert trap.analyze().doubts


def test_there_are_a_hundred_logs_and_twenty_traps() -> None:
    assert (len(LOGS), len(TRAPS)) == (100, 20)
    assert set(ASKED) <= {log.name for log in LOGS}
