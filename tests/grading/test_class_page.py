"""The page of a class and the desk: all that waits for a person is said, and what a
person decides stays.

The page is whole and escaped, and says what the grades say.
"""

from __future__ import annotations

import csv
import html
import io
import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import look_at, needs_browser
from grading.classes import make_folder
from grading.students_reports import (
    RIGHT,
    STATED,
    Sheet,
    a_log,
    reported_line,
    sheet,
    three_logs,
)
from msgspec.structs import astuple
from pages import Structure
from places import DATA, SAMPLES
from schemas import assert_valid
from typer.testing import CliRunner, Result

import gyrodata
from gyrodata.cli import app
from gyrodata.grading.rubric import default_rubric_text

EVIL = ['<script>alert("x")</script>', "{{ 7 * 7 }}", "\u202egnp.exe"]
BOOK = [
    *csv.reader(
        [
            "Student,ID,SIS User ID,SIS Login ID,Section,Gyroscope lab (1)",
            "Points Possible,,,,,20.00",
        ]
    ),
    ["Adler, Nina", "1", "", "", "Mon A", "12"],
    ['O\'Brien "X", <b>Seán', "2", "", "", "Tue B", "25"],
    *([name, str(i), "", "", name, ""] for i, name in enumerate(EVIL, 3)),
]
HEAD = "student,what,value,by,why"


def as_csv(rows: Sequence[Sequence[str]]) -> str:
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows(rows)
    return out.getvalue()


class Lab:
    """A class, and the folder of its grades."""

    def __init__(self, home: Path, files: Mapping[str, str | bytes]) -> None:
        self.root, self.out = make_folder(home / "class", files), home / "grades"
        self.options: tuple[str, ...] = ("--workers", "0")

    def grade(self) -> Result:
        done = CliRunner().invoke(
            app, ["grade", str(self.root), "-o", str(self.out), *self.options]
        )
        assert done.exit_code in (0, 1), done.stderr
        return done

    def decide(self, *lines: str, head: str = HEAD) -> str:
        (self.out / "desk.csv").write_text(
            "\n".join([head, *lines, ""]), encoding="utf-8"
        )
        return self.grade().stderr

    def read(self, name: str) -> str:
        return (self.out / name).read_text(encoding="utf-8")

    def graded(self, *students: str, what: str = "points") -> list[Any]:
        document = json.loads(self.read("grades.json"))
        assert_valid(document, "grades")
        return [one[what] for one in document["students"] if one["student"] in students]

    @property
    def todo(self) -> list[list[str]]:
        return list(csv.reader(io.StringIO(self.read("desk-todo.csv"))))[1:]

    @property
    def groups(self) -> dict[str, list[list[str]]]:
        """Cells of the lines to be copied, by what the page says of them."""
        found = {}
        for part in re.findall(
            r'<section class="group.*?</section>', self.read("class.html"), re.DOTALL
        ):
            count, reason = re.findall(
                r'<span class="count">(\d+)</span> × <span class="k">(.*?)</span>', part
            )[0]
            codes = re.findall(r'<p class="desk">.*?<code>(.*?)</code></p>', part)
            found[html.unescape(reason)] = list(
                csv.reader(html.unescape(code) for code in codes)
            )
            assert len(codes) == int(count)
        return found


@pytest.fixture
def lab(tmp_path: Path) -> Lab:
    """A class of four, the third without an answer in its log."""
    logs = {f"s{i}/lab.csv": a_log(i, "# station: 3") for i in range(4)}
    logs["s2/lab.csv"] = re.sub("# reported_inertia.*\n", "", logs["s2/lab.csv"])
    lab = Lab(tmp_path, {**logs, "s2/report.pdf": b"%PDF-1.4"})
    lab.grade()
    return lab


def full_lab(home: Path) -> Lab:
    """A class with something of everything, three logs that are one among it."""
    rows = [sheet(np.random.default_rng(i), "mixed") for i in range(7)]
    mixed = np.random.default_rng(1).permutation(len(rows[4].mass))
    rows[5] = Sheet(*(column[mixed] for column in astuple(rows[4])))
    logs = [
        one.log(reported_line(*RIGHT.inertia(one, "with_constant"))) for one in rows
    ]
    value, u = RIGHT.inertia(rows[3], "with_constant")
    logs[1], logs[2], logs[3] = (
        rows[1].log(),
        "",
        rows[3].log(reported_line(1.3 * value, u)),
    )
    files = {
        f"s{i}_{i}_{i}_lab.csv": log for i, log in enumerate([*logs, logs[4]]) if i
    }
    lab = Lab(home, files | {"s1_1_1_report.pdf": "%PDF-1.4"})
    (home / "book.csv").write_text(as_csv(BOOK), encoding="utf-8")
    (home / "rubric.toml").write_text(
        re.sub("title = .*", f"title = '{EVIL[0]}'", STATED, count=1), "utf-8"
    )
    lab.options += (
        "--gradebook",
        str(home / "book.csv"),
        "--rubric",
        str(home / "rubric.toml"),
    )
    lab.grade()
    return lab


@pytest.fixture(scope="module")
def full(tmp_path_factory: pytest.TempPathFactory) -> Lab:
    return full_lab(tmp_path_factory.mktemp("lab"))


@pytest.mark.slow
def test_structure_is_sound_and_nothing_comes_from_outside(full: Lab) -> None:
    page = full.read("class.html")
    tags = Structure(page).tags
    assert [tag for tag, _ in tags].count("h1") == 1
    links = {str(attributes["href"]) for tag, attributes in tags if tag == "a"}
    assert {link[1:] for link in links if link[0] == "#"} <= {
        one["id"] for _, one in tags if "id" in one
    }
    assert {f"feedback/s{i}_{i}_{i}_lab.html" for i in range(1, 8)} < links
    assert not any(
        key.startswith("on") or key == "src"
        for _, attributes in tags
        for key in attributes
    )
    assert not re.search(r"https?://|url\(|@import", page)


@pytest.mark.slow
def test_names_and_reasons_stay_text(full: Lab) -> None:
    page = full.read("class.html")
    assert not any(bad in page for bad in ("<script>alert", "\u202e", " 49 "))
    assert (
        '<bdi>O&#39;Brien &#34;X&#34;, &lt;b&gt;Seán</bdi></a> <span class="sec">Tue B</span>'
        in page
    )


# --- what waits for a person, and what is decided ---


def test_groups_and_counts_are_those_of_the_lines_that_wait(full: Lab) -> None:
    assert {reason: len(lines) for reason, lines in full.groups.items()} == {
        "other points are in the gradebook": 2,
        "no grade: lab.csv is empty": 1,
        "no grade: no I_zz is reported": 1,
        "the reported I_zz is … u from the student's own runs": 1,
        "flag: shared rows": 1,
    }
    lines = [line for group in full.groups.values() for line in group]
    assert sorted(line[:2] for line in lines) == sorted(line[:2] for line in full.todo)
    offered = {
        line[0]: line[2] for line in lines if line[1] == "total" and line[0] in "12"
    }
    assert offered == {"1": "12.00", "2": ""}, (
        "25 of 20 points are told, and not offered"
    )
    assert '<a href="../class/s1_1_1_report.pdf">' in full.read("class.html")


@pytest.mark.slow
def test_counts_of_full_and_of_no_points_are_those_of_the_marks(tmp_path: Path) -> None:
    logs = three_logs()
    logs["wrong"] = re.sub(
        "(# reported_inertia:).*", r"\1 7.1e-3 ± 0.1e-3 kg m^2", logs["good"]
    )
    lab = Lab(tmp_path, {f"{name}/lab.csv": log for name, log in logs.items()})
    rubric = make_folder(tmp_path, {"rubric.toml": STATED}) / "rubric.toml"
    lab.options += ("--rubric", str(rubric))
    lab.grade()
    document = json.loads(lab.read("grades.json"))
    counts = {
        row["id"]: (row["judged"], row["full"], row["none"])
        for row in document["criteria"]
    }
    points: dict[str, list[float]] = {}
    for student in document["students"]:
        for mark in student["marks"]:
            if mark["points"] is not None:
                points.setdefault(mark["criterion"], []).append(mark["points"])
    out_of = {row["id"]: row["out_of"] for row in document["criteria"]}
    assert counts == {
        key: (len(values), values.count(out_of[key]), values.count(0))
        for key, values in points.items()
    }
    # The student without a mistake has all points in each criterion.
    assert min(full for _, full, _ in counts.values()) >= 1
    assert max(none for _, _, none in counts.values()) >= 1


@pytest.mark.slow
def test_what_the_desk_says_waits_no_longer(tmp_path: Path) -> None:
    lab = full_lab(tmp_path)
    lines = [line for group in lab.groups.values() for line in group]
    flagged = ["4 + 5 + 7", "flag", ""]
    assert [line[:3] for line in lines if line[1] == "flag"] == [flagged]
    assert "9 of 9 rows of 4" in lab.read("class.html")
    decided = {"flag": "partners", "reported": "4.4e-3 kg m^2", "total": "9"}
    lab.decide(
        as_csv(
            [
                [line[0], line[1], line[2] or decided[line[1]], "Ann", ""]
                for line in lines
            ]
        )
    )
    assert lab.todo == []
    assert "Nothing: all are graded, and nothing is flagged." in lab.read("class.html")
    assert 'class="flag"' not in lab.read("class.html"), "they are partners"
    for line in ("4,hold,,Ann,", "4,partner,5,Ann,"):
        lab.decide(line)
        assert [one[:3] for one in lab.todo if one[1] == "flag"] == [flagged], (
            "the others still wait"
        )
    lab.decide(*(f"{key},hold,,Ann," for key in "457"))
    assert not any(reason.startswith("flag") for reason in lab.groups)
    assert "has decided about (1)" in lab.read("class.html")


@pytest.mark.slow
def test_a_decision_that_is_taken_back_leaves_nothing(lab: Lab) -> None:
    names = (
        "grades.csv",
        "grades.json",
        "class.html",
        "desk-todo.csv",
        "flags.csv",
        "feedback/s2/feedback.md",
    )
    first = {name: lab.read(name) for name in names}
    told = lab.decide(
        "s0,total,16,,",
        "s2,reported,4.44e-3 ± 0.05e-3 kg m^2,,",
        "s3,station,9,,",
        "s1,hold,,,",
    )
    assert "graded 1 (the desk changed): s2" in told
    assert lab.graded("s0", "s1", "s2", what="status") == [
        "graded",
        "on hold",
        "graded",
    ]
    lab.decide()
    assert {name: lab.read(name) for name in names} == first


@pytest.mark.slow
def test_points_by_hand_complete_a_rubric_with_a_manual_part(
    lab: Lab, tmp_path: Path
) -> None:
    (tmp_path / "rubric.toml").write_text(
        default_rubric_text("manual"), encoding="utf-8"
    )
    lab.options += ("--rubric", str(tmp_path / "rubric.toml"))
    assert "3 so far, 1 not" in lab.grade().stdout
    assert lab.graded("s0") == [15]
    assert "15 of 20 points so far; to come: The report is clear (5)." in lab.read(
        "feedback/s0/feedback.md"
    )
    todo = lab.read("desk-todo.csv").splitlines()
    assert "s0,report,,,a person gives these points,s0,lab.csv" in todo
    assert any(
        line.startswith('s2,reported,,,"no I_zz is reported')
        and line.endswith("s2,report.pdf")
        for line in todo
    )
    lab.decide("s0,report,,Ann,")
    assert "s0,report," in lab.read("desk-todo.csv"), "nobody gives these points"
    lab.decide("s0,report,2,Ann,")
    assert "2 of 5 | Given by hand (Ann)." in lab.read("feedback/s0/feedback.md")
    lab.decide(*(f"s{i},report,{i + 1.5},Ann,clear" for i in range(3)))
    assert lab.graded("s0", "s2") == [16.5, None]
    assert "1.5 of 5 | Given by hand: clear (Ann)" in lab.read(
        "feedback/s0/feedback.md"
    )
    assert "s0," not in lab.read("desk-todo.csv")


@pytest.mark.slow
def test_tables_as_a_spreadsheet_saves_them_are_read(lab: Lab) -> None:
    table = lab.out / "grades.csv"
    table.write_text(
        table.read_text().replace(".00,", ",").replace(",", ";"), encoding="utf-8"
    )
    told = lab.decide(
        "S0;total;12,5;x",
        ";;;",
        "s1;comment;'=1+1;",
        "s1;total;;",
        head="\ufeffStudent;What;Value;Look",
    )
    assert lab.graded("s0", "s1") == [12.5, 20]
    assert "=1+1" in lab.read("feedback/s1/feedback.md")
    assert "grades.csv changes for 4; " in told


# --- in a browser ---


PROBE = (DATA / "probe_of_class_page.html").read_text(encoding="utf-8")


@pytest.mark.slow
@needs_browser
def test_page_on_a_phone_filters_and_sorts(tmp_path: Path) -> None:
    good, slip, bad = three_logs().values()
    lab = Lab(tmp_path, {"g/lab.csv": good, "s/lab.csv": slip, "w/lab.csv": bad})
    people = "student,name,section\ng,Gööd,Mon A\ns,Slip,Tue B\nw,Waiting,Tue B\n"
    make_folder(tmp_path, {"roster.csv": people, "rubric.toml": STATED})
    lab.options += (
        "--roster",
        str(tmp_path / "roster.csv"),
        "--rubric",
        str(tmp_path / "rubric.toml"),
    )
    lab.grade()
    out = look_at(tmp_path, lab.read("class.html"), 390, PROBE)
    names, pair = ["Gööd", "Slip", "Waiting"], ["Gööd", "Slip"]
    assert (out["up"], out["down"], out["names"]) == (
        ["Slip", "Gööd", "Waiting"],
        names,
        names,
    )
    assert out["found"] == [pair, pair, ["Slip", "Waiting"], [], names]


@pytest.mark.slow
def test_a_notebook_shows_the_grades_as_text() -> None:
    shown = gyrodata.grade(SAMPLES / "class")._repr_html_()
    assert shown.startswith("<pre")
    assert "14 submissions, 11 graded" in shown
