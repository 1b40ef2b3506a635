"""The journal: whole lines, or none; what stands in it comes back to the last digit."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from msgspec import convert
from msgspec.structs import asdict, replace

from gyrodata.errors import InputError
from gyrodata.grading import JOURNAL, Basis, Entry, Grade, Journal, find_unchanged, keep_run, why_again

EXPECTED = Path(__file__).parent / "expected"
BASIS = Basis("submission", "rubric", "reference", "1.0")


def an_entry(student: str, **changes: object) -> Entry:
    grade = convert(json.loads((EXPECTED / "slip.json").read_text(encoding="utf-8")), Grade)
    grade = replace(grade, student=student)
    entry = Entry(**asdict(BASIS), grade=grade, figures={"torque": "what it shows"})
    return replace(entry, **changes)  # type: ignore[arg-type]


@pytest.fixture
def journal(tmp_path: Path) -> Journal:
    return Journal(tmp_path / "grades" / "journal.ndjson")


def read(journal: Journal) -> dict[str, Entry]:
    return {entry.grade.student: entry for entry in journal.read()}


def test_no_journal_is_an_empty_one(journal: Journal) -> None:
    assert read(journal) == {}
    assert not journal.path.parent.exists()


@pytest.mark.parametrize("student", ["jane", "Żółć\u2028 \ud800 \n", ""])
def test_what_is_written_comes_back(student: str, journal: Journal) -> None:
    entry = an_entry(student)
    journal.add(entry)
    assert journal.path.read_bytes().count(b"\n") == 1
    assert read(journal) == {student: entry}
    assert journal.damaged == 0


def test_the_last_line_of_a_student_holds(journal: Journal) -> None:
    journal.add(an_entry("a", lost="it took over 30 s"))
    journal.add(an_entry("b"))
    journal.add(an_entry("a"))
    assert read(journal) == {"a": an_entry("a"), "b": an_entry("b")}


@pytest.mark.parametrize("cut", [1, 2, 500])
def test_a_torn_line_costs_itself_alone(cut: int, journal: Journal) -> None:
    journal.add(an_entry("a"))
    journal.add(an_entry("b"))
    journal.close()
    journal.path.write_bytes(journal.path.read_bytes()[:-cut])
    # Without its line end alone a line is whole.
    torn = cut > 1
    assert set(read(journal)) == ({"a"} if torn else {"a", "b"})
    assert journal.damaged == torn
    journal.add(an_entry("c"))
    assert set(read(journal)) == ({"a", "c"} if torn else {"a", "b", "c"})
    if torn:
        assert str(journal.torn()) == (
            "journal.ndjson: note G762: 1 line of the journal cannot be read; what stood there was graded again"
        )


@pytest.mark.parametrize(
    "line", ["[]", "7", "{}", "\x00\x00", '{"schema": "gyro.journal/1"}', '{"schema": "gyro.journal/2"}']
)
def test_what_is_no_line_of_a_journal_is_left_out(line: str, journal: Journal) -> None:
    journal.add(an_entry("a"))
    with journal.path.open("a", encoding="utf-8") as file:
        file.write(line + "\n")
    assert set(read(journal)) == {"a"}
    assert journal.damaged == 1


def test_a_grade_of_another_shape_is_made_anew(journal: Journal) -> None:
    content = json.loads(an_entry("a").to_line())
    del content["grade"]["marks"][0]["rule"]
    journal.path.parent.mkdir()
    journal.path.write_text(json.dumps(content) + "\n", encoding="utf-8")
    assert read(journal) == {}


def test_written_anew_it_has_a_line_for_each_entry(journal: Journal) -> None:
    for student in ("b", "a", "b"):
        journal.add(an_entry(student))
    journal.replace(entry for _, entry in sorted(read(journal).items()))
    lines = journal.path.read_text(encoding="utf-8").splitlines()
    assert [json.loads(line)["student"] for line in lines] == ["a", "b"]
    assert [path.name for path in journal.path.parent.iterdir()] == ["journal.ndjson"]


@pytest.mark.parametrize("make", [lambda path: path.write_text(""), lambda path: path.symlink_to("/nowhere/at/all")])
def test_a_folder_that_cannot_be_written_says_so(make: object, tmp_path: Path) -> None:
    make(tmp_path / "grades")  # type: ignore[operator]
    with pytest.raises(InputError, match=r"G763: .*grades\" cannot be written"):
        Journal(tmp_path / "grades" / "journal.ndjson").add(an_entry("a"))


@pytest.mark.parametrize(
    ("basis", "lost", "why"),
    [
        (BASIS, "", ""),
        (BASIS, "it took over 30 s", "lost last time: it took over 30 s"),
        (replace(BASIS, submission="x"), "", "the submission changed"),
        (replace(BASIS, rubric="x", reference="x"), "", "the rubric changed"),
        (replace(BASIS, reference="x"), "", "the reference changed"),
        (replace(BASIS, tool="0.9"), "", "gyrodata changed from 0.9 to 1.0"),
    ],
)
def test_why_a_grade_is_made_again(basis: Basis, lost: str, why: str) -> None:
    assert why_again(an_entry("a", **asdict(basis), lost=lost), BASIS) == why


def test_the_record_of_a_run_is_found_behind_a_journal_of_any_length(tmp_path: Path) -> None:
    journal = tmp_path / "grades" / JOURNAL
    journal.parent.mkdir()
    grades = b'{"a": 1}\n{"b": 2}\n'
    journal.write_bytes(grades)
    for asked in ("first", "second"):
        keep_run(journal, asked, {"text": "x" * 100})
        assert find_unchanged(journal, asked) == {"text": "x" * 100}
        assert find_unchanged(journal, "another") is None
    lines = journal.read_bytes().splitlines()
    assert len(lines) == 3, "the record of the run before goes"
    assert journal.read_bytes().startswith(grades)
    journal.write_bytes(b"")
    assert find_unchanged(journal, "second") is None
