"""The roster: names, sections, stations and partners reach table and page, and so do those who handed in nothing."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from grading.classes import make_folder
from grading.reports import RIGHT, reported_line, sheet
from typer.testing import CliRunner

from gyrodata import schema
from gyrodata.cli import app

CANVAS = """Student,ID,SIS User ID,SIS Login ID,Section,Gyroscope lab (123456)
    Points Possible,,,,,20.00
"Adler, Nina",7,,,Mon A,
"Baker, Tom",8,,,Tue B,
"Cole, Ida",9,,,Mon A,
"Student, Test",,,,Mon A,
"""
OWN = "student;name;section;station;partner\nadlernina;Nina Adler;Mon;4;bakertom\nbakertom;Tom;Tue;5;\ncole;;Mon;;\n"


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """Two who have the same data, one without a station."""
    rows = sheet(np.random.default_rng(1), "mixed")
    report = reported_line(*RIGHT.inertia(rows, "with_constant"))
    files = {"adlernina_7_1_lab.csv": rows.log(report), "bakertom_8_2_lab.csv": rows.log("# station: 3", report)}
    return make_folder(tmp_path / "class", files)


def grade(root: Path, *options: str | Path) -> tuple[dict[str, dict[str, str]], str, str]:
    """Give the table by student, the page, and what is printed."""
    out = root.parent / "grades"
    done = CliRunner().invoke(app, ["grade", str(root), "-o", str(out), "--workers", "1", *map(str, options)])
    assert done.exit_code == 0, done.stderr
    document = json.loads((out / "grades.json").read_text(encoding="utf-8"))
    jsonschema.validate(document, schema.grades_schema())
    table = csv.DictReader(io.StringIO((out / "grades.csv").read_text(encoding="utf-8")))
    return {row["student"]: row for row in table}, (out / "class.html").read_text(encoding="utf-8"), done.output


def test_gradebook_gives_names_sections_and_who_is_absent(root: Path, tmp_path: Path) -> None:
    book = tmp_path / "book.csv"
    book.write_text(CANVAS, encoding="utf-8")
    grade(root)
    rows, page, told = grade(root, "--gradebook", book)
    assert "kept 2 as graded before" in told, "a name is no reason to grade anew"
    assert (rows["7"]["name"], rows["7"]["section"], rows["7"]["total"]) == ("Adler, Nina", "Mon A", "20.00")
    assert (rows["9"]["name"], rows["9"]["status"], rows["9"]["total"]) == ("Cole, Ida", "nothing handed in", "")
    assert rows["9"]["section"] == "Mon A"
    assert set(rows) == {"points possible", "7", "8", "9"}
    assert "2 graded, 0 not, 1 handed in nothing" in told
    assert "Nothing handed in" in page
    assert "<h3>Mon A (1)</h3>" in page
    assert "<bdi>Cole, Ida</bdi>" in page
    assert '<td class="sec">Tue B</td>' in page
    (root.parent / "grades" / "desk.csv").write_text('student,what,value\n"Baker, Tom",total,3\n', encoding="utf-8")
    assert grade(root, "--gradebook", book)[0]["8"]["total"] == "3.00", "a person is known by the roster's name too"


def test_a_table_of_ones_own_gives_stations_and_partners(root: Path, tmp_path: Path) -> None:
    own = tmp_path / "roster.csv"
    own.write_text(OWN, encoding="utf-8")
    assert grade(root)[0]["7"]["flags"]
    rows, _, _ = grade(root, "--roster", own)
    assert rows["7"]["flags"] == rows["8"]["flags"] == ""
    document = json.loads((root.parent / "grades" / "grades.json").read_text(encoding="utf-8"))
    stations = {one["student"]: one["station"] for one in document["students"]}
    assert stations == {"7": "4", "8": "3"}, "what the log says goes before"
    assert document["absent"] == [{"student": "cole", "name": "cole", "section": "Mon"}]
