"""The journal: whole lines, or none; what is in it comes back to the last digit."""

from __future__ import annotations

from pathlib import Path

import pytest
from grading.reports import three_grades
from msgspec.structs import asdict, replace

from gyrodata.grading import Basis, Entry, Journal

BASIS = Basis("submission", "rubric", "reference", "1.0")


def an_entry(student: str, lost: str = "") -> Entry:
    return Entry(**asdict(BASIS), grade=replace(three_grades()["slip"], student=student), lost=lost)


def read(journal: Journal) -> dict[str, Entry]:
    return {entry.grade.student: entry for entry in journal.read()}


@pytest.mark.parametrize("student", ["jane", "Żółć\u2028 \ud800 \n", ""])
def test_entry_comes_back_and_the_last_of_a_student_counts(student: str, tmp_path: Path) -> None:
    journal = Journal(tmp_path / "grades" / "journal.ndjson")
    assert read(journal) == {}
    assert list(tmp_path.iterdir()) == []
    journal.add(an_entry(student, lost="it took over 30 s"))
    journal.add(an_entry("b"))
    journal.add(an_entry(student))
    assert journal.path.read_bytes().count(b"\n") == 3
    assert read(journal) == {student: an_entry(student), "b": an_entry("b")}
    assert journal.damaged == 0


@pytest.mark.parametrize(
    "line", ["[]", "7", "{}", "\x00\x00", '{"schema": "gyro.journal/1"}', an_entry("b").to_line()[:-500]]
)
def test_damaged_line_is_counted_and_costs_itself_alone(line: str, tmp_path: Path) -> None:
    journal = Journal(tmp_path / "journal.ndjson")
    journal.add(an_entry("a"))
    journal.close()
    with journal.path.open("a", encoding="utf-8") as file:
        file.write(line)
    assert set(read(journal)) == {"a"}
    assert journal.damaged == 1
    journal.add(an_entry("c"))
    assert set(read(journal)) == {"a", "c"}
    assert "note G762: 1 line of the journal cannot be read" in str(journal.torn())
