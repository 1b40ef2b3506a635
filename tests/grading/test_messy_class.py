"""Classes as they are: zips and Word files, partners, absent students, and all words of
the desk.
"""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

import openpyxl
import pytest
from classes.class_cells import gyro
from grading.classes import LOG, find_submissions, make_folder, packed
from grading.students_reports import a_log

import gyrodata
from gyrodata.grading.ledger import forms_of
from gyrodata.grading.submissions.answers import partners_in, read_answers
from gyrodata.readings import read_log

WORD = (
    "<w:p><w:r><w:t>Result: (4.43 ± "
    "0.05)·10</w:t></w:r><w:r><w:t>-3</w:t></w:r><w:r><w:t> kg m²</w:t></w:r></w:p>"
)
WORD += "<w:p><w:r><w:rPr><w:strike/></w:rPr><w:t>Result: (4.5 ± 0.1) g m²</w:t></w:r></w:p>"


def test_zip_and_word_file_in_a_submission_are_read(tmp_path: Path) -> None:
    inner = packed(
        {
            "lab/lab.csv": LOG,
            "__MACOSX/lab/._lab.csv": "x",
            "report.docx": packed({"word/document.xml": WORD}),
        }
    )
    three = packed({"2.zip": packed({"3.zip": packed({"lab.csv": LOG})})})
    files = {
        "ann/1.zip": inner,
        "bob/1.zip": packed({"2.zip": inner}),
        "cat/1.zip": three,
        "dan/1.zip": inner[:-9],
    }
    items = find_submissions(
        make_folder(
            tmp_path / "class", {**files, "eve/1.zip": packed({"../lab.csv": LOG})}
        )
    ).items
    read = [item.read()[1].inertia for item in items[:2]]
    assert [(one.value, one.u) for one in read if one] == [
        (pytest.approx(4.43e-3), pytest.approx(5e-5))
    ] * 2
    problems = [item.problem or "" for item in items]
    assert problems[:3] == ["", "", "no log: only 1.zip, 3.zip"]
    assert ["damaged" in problems[3], "leads out" in problems[4]] == [True, True]


def test_newest_attempt_of_a_brightspace_download_is_graded(tmp_path: Path) -> None:
    names = [
        f"7-9 - Jane Doe - {stamp}/lab.csv"
        for stamp in ("Mar 9, 2026 1105 PM", "Mar 10, 2026 905 AM")
    ]
    found = find_submissions(
        make_folder(tmp_path / "class", {**dict.fromkeys(names, LOG), "index.html": ""})
    )
    (one,) = found.items
    assert (found.lms, one.student, one.name, one.log_name) == (
        "brightspace",
        "7",
        "Jane Doe",
        names[1],
    )
    assert [note.code for note in found.diagnostics] == ["G708"]


@pytest.mark.slow
@pytest.mark.parametrize(
    "row",
    [
        ["Result", "4.4e-3 kg m^2"],
        ["slope", 0.0044],
        ["theory", 0.0044],
        ["station", 3],
    ],
)
def test_rows_below_the_runs_of_a_workbook_do_no_harm(row: list[object]) -> None:
    book, out = openpyxl.Workbook(), io.BytesIO()
    for cells in (
        *csv.reader(LOG.splitlines()),
        row,
        ["I_zz =", "4.4e-3 ± 0.1e-3 kg m^2"],
    ):
        book.worksheets[0].append(cells)
    book.create_sheet("Plot").append(["x", "y"])
    book.save(out)
    log = read_log(out.getvalue(), name="lab.xlsx")
    answer = read_answers(log).inertia
    assert (log.ok, len(log.runs), answer and answer.value) == (True, 2, 4.4e-3)


PEOPLE = {"p1": "Patel, Dev", "p2": "Lee, Ann", "p3": "Roe, Max", "p9": "Ahmed, Sara"}
ROSTER = "student;name;email\n" + "".join(
    f"{key};{name};{key}@uni.example\n" for key, name in PEOPLE.items()
)


class Room:
    """A class with a roster: two partners with one log, a third student, and one who is
    absent.
    """

    def __init__(self, folder: Path) -> None:
        partners = {
            "p1": "# partner: Ann Lee",
            "p2": "# names: Ann Lee and Patel, Dev",
            "p3": "# partner: Max Nobody",
        }
        files = {
            f"class/{key}/lab.csv": a_log(key == "p3", head)
            for key, head in partners.items()
        }
        self.home = make_folder(folder, {**files, "roster.csv": ROSTER})
        self.out = folder / "grades"

    def grade(
        self, desk: str | bytes = "", name: str = "desk.csv", code: int = 0
    ) -> dict[str, dict[str, str]]:
        if desk:
            self.out.mkdir(exist_ok=True)
            (self.out / name).write_bytes(
                desk.encode() if isinstance(desk, str) else desk
            )
        done = gyro(
            "grade",
            self.home / "class",
            "-o",
            self.out,
            "--roster",
            self.home / "roster.csv",
            "--workers",
            "0",
        )
        assert done.exit_code == code, done.stderr
        self.told = done.stderr
        table = csv.DictReader(
            io.StringIO((self.out / "grades.csv").read_text(encoding="utf-8"))
        )
        return {row["student"]: row for row in table}


@pytest.fixture
def room(tmp_path: Path) -> Room:
    return Room(tmp_path)


@pytest.mark.slow
def test_partners_who_name_each_other_are_not_flagged(room: Room) -> None:
    rows = room.grade()
    assert [rows[key]["flags"] for key in ("p1", "p2", "p3")] == [""] * 3
    (room.home / "class" / "p2" / "lab.csv").write_text(a_log(0), encoding="utf-8")
    assert room.grade()["p1"]["flags"] == "shared rows with p2", (
        "only one names the other"
    )
    assert [
        "find the partner, Max Nobody" in rows[key]["look"]
        for key in ("p1", "p2", "p3")
    ] == [False, False, True]
    (room.home / "class" / "p2" / "answer.txt").write_text(
        "I did this lab together with Dev Patel.", encoding="utf-8"
    )
    (room.home / "class" / "p3" / "lab.csv").write_text(
        a_log(1, "# partner: none, I worked alone"), encoding="utf-8"
    )
    rows = room.grade()
    assert [
        rows[key][what] for key in ("p1", "p2", "p3") for what in ("flags", "look")
    ] == [""] * 6


TOGETHER = [
    "Messpartner: {}",
    "Authors: Ann Lee, {}, Dev Patel",
    "Team {} & Dev Patel",
    "We measured with {} as agreed.",
    "Partner: {}, same data",
]


@pytest.mark.slow
@pytest.mark.parametrize("words", TOGETHER)
def test_partners_are_found_by_their_full_names_in_any_words(
    room: Room, words: str
) -> None:
    for key, other in (("p1", "Ann Lee"), ("p2", "Dev Patel")):
        (room.home / "class" / key / "lab.csv").write_text(a_log(0), encoding="utf-8")
        (room.home / "class" / key / "note.txt").write_text(
            words.format(other), encoding="utf-8"
        )
    rows = room.grade()
    assert [rows[key]["flags"] for key in ("p1", "p2")] == ["", ""]
    assert "same data" not in (room.out / "desk-todo.csv").read_text("utf-8")


def test_accents_in_names_do_not_matter() -> None:
    assert set(forms_of("Lucía Ibáñez")) >= set(forms_of("Lucia Ibanez")) - {
        "lucia ibanez"
    }


SECOND = [
    "I_zz = (4.90 ± 0.05)e-3 kg m^2",
    "Our result: (4.90 ± 0.05) x 10^-3 kg m^2 for I_zz",
]


@pytest.mark.slow
@pytest.mark.parametrize("text", SECOND)
@pytest.mark.parametrize(
    ("name", "looks"), [("report.md", True), ("report_draft.md", False)]
)
def test_second_answer_in_another_file_is_shown_to_a_person(
    room: Room, text: str, name: str, looks: bool
) -> None:
    (room.home / "class" / "p3" / name).write_text(text, encoding="utf-8")
    row = room.grade()["p3"]
    assert (row["status"], "two answers" in row["look"]) == ("graded", looks)


ANSWERS = {
    "results.csv": "quantity,value,uncertainty,unit\nI_zz,0.00440,0.00005,kg m^2\nR^2,0.997,,\n",
    "result.json": '{"I_zz": 0.00440, "uncertainty": 5e-05, "unit": "kg m^2"}',
    "row.csv": "I_zz,0.00440,0.00005,kg m^2\n",
    "analysis.R": "I <- m * x\n# So I_zz = (4.40 +/- 0.05)e-3 kg m^2\n",
    "power.txt": "I_zz = 4.40 +- 0.05 (10^-3 kg m^2)",
    "title.txt": "Theory and experiment\nI_zz = (4.40 ± 0.05)e-3 kg m^2",
    "about.txt": (
        "Our best value is I_zz = 0.00440 kg m² and I think it is good to about "
        "0.00005 kg m²."
    ),
    "words.txt": "I_zz is 0.00440 kilogram metre squared, give or take 0.00005",
    "other.txt": "I_zz = 4.40 ± 0.05 g m^2 (i.e. 0.00440 kg m^2)",
    "printed.ipynb": json.dumps(
        {
            "cells": [
                {
                    "source": ["print(answer)"],
                    "outputs": [
                        {
                            "output_type": "stream",
                            "text": ["I_zz = 44000 ± 500 g cm^2\n"],
                        }
                    ],
                }
            ]
        }
    ),
    "README": "The moment of inertia is (44000 +/- 500) g*cm^2.",
    "blank.txt": "J'obtiens I = (4.40 ± 0.05) 10-3 kg.m².",
    "siunitx.tex": r"Il momento d'inerzia è \SI{4,400(50)e-3}{\kilo\gram\square\metre}.",
    "percent.csv": "a;b;c\n1;2;3\n% Il momento d'inerzia è 44000 ± 500 g cm².\n",
    "ja.txt": "慣性モーメントは 4.40×10^-3 kg m^2、不確かさは 0.05×10^-3 kg m^2 です。",
    "cs.txt": "Moment setrvačnosti je 4,40·10^-3 kg m² s chybou 0,05·10^-3 kg m².",
}


@pytest.mark.parametrize("name", ANSWERS)
def test_answer_in_another_kind_of_file_is_read(name: str) -> None:
    text = ANSWERS[name]
    found = read_answers(
        None, [(name, text.encode() if isinstance(text, str) else text)]
    ).inertia
    assert found is not None
    assert (found.value, found.u, found.fault) == (
        pytest.approx(4.4e-3),
        pytest.approx(5e-5),
        None,
    )


OTHERS = {
    "the rod": (
        "I_zz = 4.40(5)e-3 kg m2.\nThe rod on its own only has 1.9(1)e-4 kg m2, so we "
        "neglected it."
    ),
    "a cross check": "The falling mass gave 4.7(3)e-3 kg m^2, which is\ntoo rough. "
    "The precession yields 4.40(5)e-3 kg m^2.",
    "the next group": "El momento de inercia es 0,00440 kg m2 con un error relativo del 1,136 %.\n"
    "El grupo de al lado obtuvo 0,00435 kg m2.",
    "an exercise": (
        "Suppose you measure 4.5e-3 kg m^2 ± 2 %.\nOur result is I_zz = (4.40 ± "
        "0.05)e-3 kg m^2."
    ),
}


@pytest.mark.parametrize("whose", OTHERS)
def test_value_of_something_else_beside_the_answer_is_not_taken(whose: str) -> None:
    found = read_answers(None, [("a.txt", OTHERS[whose].encode())]).inertia
    assert found is not None
    assert (found.value, found.u) == (
        pytest.approx(4.4e-3),
        pytest.approx(5e-5, rel=1e-3),
    )


OTHER_UNITS = [
    "(4.40 ± 0.05) x 10^-3 kg/m^2",
    "4.40e-3 ± 0.05e-3 kg m^3",
    "0.00440 ± 0.00005 kg·m²/rad",
    "0.00440 ± 0.00005",
]


@pytest.mark.parametrize("text", OTHER_UNITS)
def test_answer_with_a_wrong_unit_or_without_one_is_an_answer(text: str) -> None:
    for name in ("I_zz", "I"):
        found = read_answers(None, [("a.txt", f"{name} = {text}".encode())]).inertia
        assert found is not None
        assert (found.value, found.u) == (pytest.approx(4.4e-3), pytest.approx(5e-5))
        assert found.fault in ("wrong unit", "no unit")


def test_text_field_and_comment_of_blackboard_are_read(tmp_path: Path) -> None:
    said = {
        "field": "<p>I_zz is 0.00440 kg m^2 plus or minus 0.00005 kg m^2.</p>",
        "comment": "none",
    }
    said = {**said, "comment": "I worked with Ann Lee."}
    receipt = (
        "Name: Dev Patel (p1)\nAssignment: Lab\n\nSubmission Field:\n{field}\n\n"
        "Comments:\n{comment}\n"
    )
    stem = "Lab_p1_attempt_2026-03-09-14-05-59"
    folder = make_folder(
        tmp_path / "class",
        {f"{stem}_lab.csv": LOG, f"{stem}.txt": receipt.format(**said)},
    )
    (item,) = find_submissions(folder).items
    log, answers = item.read()
    assert answers.inertia is not None
    assert (answers.inertia.value, answers.inertia.u) == (4.4e-3, 5e-5)
    assert "Ann Lee" in partners_in(log, item.reports())


def test_answer_in_a_text_without_an_ending_is_read(tmp_path: Path) -> None:
    files = {
        "ann/lab.csv": LOG,
        "ann/README": "We get (44000 ± 500) g cm^2 for the moment of inertia.",
    }
    (item,) = find_submissions(make_folder(tmp_path / "class", files)).items
    found = item.read()[1]
    assert (found.file, found.inertia and found.inertia.value) == (
        "README",
        pytest.approx(4.4e-3),
    )


@pytest.mark.slow
def test_workbook_and_a_text_that_says_what_it_lacks_are_read(tmp_path: Path) -> None:
    book, out = openpyxl.Workbook(), io.BytesIO()
    for row in (
        ["mass [g]", "spin [rpm]", "time [s]"],
        [20.1, 400, 41.1],
        [40.3, 400, 20.5],
        [40.3, 200, 10.3],
    ):
        book.worksheets[0].append(row)
    book.save(out)
    said = "r = 14.8 cm from the centre of the ball. All times are for one full turn.\n"
    folder = make_folder(
        tmp_path / "class", {"ann/lab.xlsx": out.getvalue(), "ann/notes.txt": said}
    )
    (item,) = find_submissions(folder).items
    assert (item.log_file, item.read()[0].ok) == ("lab.xlsx", True)


def test_log_in_the_text_field_of_a_platform_is_asked_for_as_a_file(
    tmp_path: Path,
) -> None:
    rows = "".join(f"<p>{row}</p>" for row in LOG.strip().splitlines())
    name = "Ann Lee_1234567_assignsubmission_onlinetext_/onlinetext.html"
    folder = make_folder(tmp_path, {name: f"{rows}<p>I_zz = (4.4 ± 0.1)e-3 kg m^2</p>"})
    (item,) = find_submissions(folder).items
    with pytest.raises(gyrodata.InputError, match=r"no log: only onlinetext\.html"):
        item.read()


def test_origin_in_another_text_is_used(tmp_path: Path) -> None:
    files = {
        "ann/lab.csv": LOG,
        "ann/notes.txt": (
            "The position is measured from the surface of the ball (diameter 101.6 mm)."
        ),
    }
    (item,) = find_submissions(make_folder(tmp_path / "class", files)).items
    assert item.read()[0].position_from == "surface"
    # Without the diameter the log is refused rather than read as if the positions
    # counted from the centre.
    files["ann/notes.txt"] = "The position is measured from the surface of the ball."
    (item,) = find_submissions(make_folder(tmp_path / "other", files)).items
    assert [
        one.code for one in item.read()[0].diagnostics if one.severity == "error"
    ] == ["G340"]


def test_notebook_alone_is_no_log(tmp_path: Path) -> None:
    code = 'df = pd.DataFrame({"mass_g": [20, 40], "time_s": [20.5, 20.6]})'
    cells = [{"cell_type": "code", "source": [code]}]
    folder = make_folder(tmp_path, {"ann/lab.ipynb": json.dumps({"cells": cells})})
    (item,) = find_submissions(folder).items
    assert item.problem == "no log: only lab.ipynb"


@pytest.mark.slow
def test_every_word_of_the_desk_does_what_is_documented(room: Room) -> None:
    full = room.grade()["p1"]["total"]
    make_folder(room.out, {"mended.csv": a_log(5)})
    lines = [
        "Dev Patel,total,12",
        "p1@uni.example,bonus,2.5",
        "Ann Lee,bonus,-1",
        "Lee Ann,late,3",
    ]
    lines += ["p3,log,mended.csv", "Sara Ahmed,excuse,"]
    rows = room.grade("\n".join(["student,what,value", *lines]))
    assert [rows[key]["total"] for key in ("p1", "p2", "p3")] == [
        "14.50",
        f"{float(full) - 4:.2f}",
        full,
    ]
    assert (rows["p9"]["status"], rows["p9"]["name"], rows["p3"]["flags"]) == (
        "excused",
        "Ahmed, Sara",
        "",
    )
    assert (
        room.grade("student,what,value\nSara Ahmed,total,11")["p9"]["total"] == "11.00"
    )
    hints = {
        "p1,total,+2": "write bonus,2",
        "p1,log,no.csv": "write the corrected log into the folder of the grades",
        "p1,late,99": "from 0 to 20",
    }
    for line, hint in hints.items():
        room.grade(f"student,what,value\n{line}", code=2)
        assert hint in room.told
    words = gyro("explain", "desk").stdout
    assert [
        word
        for word in ("bonus", "late", "log", "hold", "excuse", "partner", "flag")
        if word not in words
    ] == []


@pytest.mark.slow
def test_workbook_with_decisions_is_read(room: Room) -> None:
    rows = room.grade("student;what;value\nPatel, Dev;total;12,5\np2;total;\n")
    assert (rows["p1"]["total"], rows["p2"]["by_hand"]) == ("12.50", "")
    book, out = openpyxl.Workbook(), io.BytesIO()
    for cells in (["what", "student", "Value"], ["total", "p2", 13]):
        book.worksheets[0].append(cells)
    book.save(out)
    room.grade(out.getvalue(), "desk.xlsx", code=2)
    assert "both desk.csv and desk.xlsx" in room.told
    (room.out / "desk.csv").unlink()
    assert room.grade()["p2"]["total"] == "13.00"
    (room.out / "desk.xlsx").unlink()
    copy = room.out / "desk (1).csv"
    copy.write_text("student,what,value\np1,total,3\n")
    room.grade(code=2)
    assert '"desk (1).csv"' in room.told
    copy.unlink()
    room.grade("student,what,value\np1,totl,3\n", code=2)
    assert "did you mean total?" in room.told


@pytest.mark.slow
@pytest.mark.parametrize(
    "other",
    [
        "Question 2: the other one turns with the stars (15 deg per hour).",
        "It passes 30 degrees in an hour.\nQuestion 3: half a turn takes 12 hours.",
    ],
)
def test_turns_beside_the_log_are_used_whatever_else_the_text_says(
    other: str, tmp_path: Path
) -> None:
    head, *rows = LOG.splitlines()
    cells = [row.rpartition(",")[0] for row in (head, *rows)]
    readme = f"{other}\nAll times are for 1/3 turn.\nI_zz = (4.4 ± 0.1)e-3 kg m^2\n"
    files: dict[str, str | bytes] = {
        "ann/lab.csv": "\n".join(cells),
        "ann/README.txt": readme,
    }
    (item,) = find_submissions(make_folder(tmp_path / "class", files)).items
    log, _ = item.read()
    assert log.ok
    assert log.columns["turns"].values == pytest.approx([1 / 3] * 2)
