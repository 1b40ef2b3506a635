"""The roster: names, sections, stations and partners reach table and page, and so do
those who handed in nothing.
"""

import csv
import io
import json
import zipfile
from pathlib import Path

import pytest
from classes.class_cells import gyro
from grading.classes import make_folder
from grading.students_reports import a_log
from schemas import assert_valid

CANVAS = """Student,ID,SIS User ID,SIS Login ID,Section,Gyroscope lab (123456)
    Points Possible,,,,,20.00
"Adler, Nina",7,,,Mon A,
"Baker, Tom",8,,,Tue B,
"Cole, Ida",9,,,Mon A,
"Student, Test",10,,0f3b,Mon A,
"""
OWN = (
    "student;name;section;station;partner\nadlernina;Nina Adler;Mon;4;bakertom\n"
    "bakertom;Tom;Tue;5;\ncole;;Mon;;\n"
)


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """Two who have the same data, one without a station."""
    files = {
        "adlernina_7_1_lab.csv": a_log(1),
        "bakertom_8_2_lab.csv": a_log(1, "# station: 3"),
    }
    (tmp_path / "book.csv").write_text(CANVAS, encoding="utf-8")
    (tmp_path / "roster.csv").write_text(OWN, encoding="utf-8")
    return make_folder(tmp_path / "class", files)


def grade(
    root: Path, *options: str | Path
) -> tuple[dict[str, dict[str, str]], str, str]:
    """Give the table by student, the page, and what is printed."""
    out = root.parent / "grades"
    done = gyro("grade", root, "-o", out, "--workers", "0", *options)
    assert done.exit_code == 0, done.stderr
    document = json.loads((out / "grades.json").read_text(encoding="utf-8"))
    assert_valid(document, "grades")
    table = csv.DictReader(
        io.StringIO((out / "grades.csv").read_text(encoding="utf-8"))
    )
    return (
        {row["student"]: row for row in table},
        (out / "class.html").read_text(encoding="utf-8"),
        done.output,
    )


@pytest.mark.slow
def test_gradebook_gives_names_sections_and_who_is_absent(root: Path) -> None:
    book = ("--gradebook", root.parent / "book.csv")
    grade(root)
    rows, page, told = grade(root, *book)
    assert "kept 2 as graded before" in told, "a name is no reason to grade anew"
    assert "2 graded, 0 not, 1 handed in nothing" in told
    found = {
        key: [row[name] for name in ("name", "section", "status", "total")]
        for key, row in rows.items()
    }
    assert set(found) == {"points possible", "7", "8", "9"}
    assert found["7"] == ["Adler, Nina", "Mon A", "graded", "20.00"]
    assert found["9"] == ["Cole, Ida", "Mon A", "nothing handed in", ""]
    assert [
        one for one in ("<h3>Mon A (1)</h3>", "<bdi>Cole, Ida</bdi>") if one not in page
    ] == []
    assert "Student, Test" not in told
    grades = root.parent / "grades"
    (grades / "desk.csv").write_text(
        'student,what,value\n"Baker, Tom",total,3\n"Cole, Ida",total,0\n',
        encoding="utf-8",
    )
    rows, page, told = grade(root, *book)
    assert told.count("by hand: ") == told.count("by hand: total") == 2
    assert page.count('href="feedback/') > 0
    assert 'href="feedback/9' not in page
    assert rows["8"]["total"] == "3.00", "a person is known by the roster's name too"
    assert rows["9"]["total"] == "0.00"
    with zipfile.ZipFile(grades / "feedback.zip") as archive:
        owners = {name.split("_")[0] for name in archive.namelist()}
    assert owners == {"adlernina", "bakertom"}, "no page for those without a submission"


@pytest.mark.slow
def test_table_of_ones_own_gives_stations_and_partners(root: Path) -> None:
    assert grade(root)[0]["7"]["flags"]
    rows, _, _ = grade(root, "--roster", root.parent / "roster.csv")
    assert rows["7"]["flags"] == rows["8"]["flags"] == ""
    document = json.loads(
        (root.parent / "grades" / "grades.json").read_text(encoding="utf-8")
    )
    stations = {one["student"]: one["station"] for one in document["students"]}
    assert stations == {"7": "4", "8": "3"}, "what the log says goes before"
    assert document["absent"] == [{"student": "cole", "name": "cole", "section": "Mon"}]


@pytest.mark.slow
def test_rows_of_one_name_are_a_question_unless_the_number_tells(
    tmp_path: Path,
) -> None:
    files = {
        f"Wei Li_{number}_assignsubmission_file_/lab.csv": a_log(number)
        for number in (11, 12)
    }
    for cell, looks in (("", [True, True]), ("11", [False, False])):
        (tmp_path / "roster.csv").write_text(
            f"student,name,identifier\ns1,Wei Li,{cell}\ns2,Wei Li,\n", encoding="utf-8"
        )
        rows = grade(
            make_folder(tmp_path / "class", files), "--roster", tmp_path / "roster.csv"
        )[0]
        assert set(rows) == {"11", "12", "points possible"}
        assert ["whose row" in rows[key]["look"] for key in ("11", "12")] == looks


@pytest.mark.slow
def test_number_in_the_name_of_a_folder_is_that_of_the_roster(tmp_path: Path) -> None:
    partners = {"doe_jane_253316": "Max Roe", "roe_max_256796": "Doe, Jane"}
    files = {
        f"{folder}/lab.csv": a_log(1, f"# partner: {name}")
        for folder, name in partners.items()
    }
    (tmp_path / "roster.csv").write_text(
        "name,id\nJane Doe,253316\nMax Roe,256796\nIda Poe,111111\n", encoding="utf-8"
    )
    rows, _, told = grade(
        make_folder(tmp_path / "class", files), "--roster", tmp_path / "roster.csv"
    )
    assert "2 graded, 0 not, 1 handed in nothing" in told
    assert [row["flags"] for key, row in rows.items() if "_" in key] == ["", ""]
