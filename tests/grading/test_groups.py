"""Students who work together: one log and several reports, each with its own points."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np
import pytest
from classes.class_cells import gyro
from grading.classes import make_folder
from grading.students_reports import RIGHT, SLIPS, a_log, reported_line, sheet

ROWS = sheet(np.random.default_rng(1), "mixed")
LOG = ROWS.log()
ANSWER = reported_line(*RIGHT.inertia(ROWS, "with_constant")).removeprefix("# ")
SLIP = reported_line(*SLIPS["rpm_as_rad_s"].inertia(ROWS, "with_constant"))[2:]
OTHERS = {f"s{seed}/lab.csv": a_log(seed) for seed in range(10, 13)}


def graded(
    home: Path,
    files: dict[str, str | bytes],
    desk: str = "",
    roster: str = "",
) -> dict[str, dict[str, str]]:
    """Grade a class with six more students; return the rows of the table by student."""
    root, out = home / "class", home / "grades"
    if not root.exists():
        make_folder(root, {**OTHERS, **files})
    out.mkdir(exist_ok=True)
    (out / "desk.csv").write_text(f"student,what,value,by,why\n{desk}")
    (home / "roster.csv").write_text(roster or "student,name\ns10,Sue Ten\n")
    options = ("--roster", home / "roster.csv", "--workers", "0", "--exit-zero")
    done = gyro("grade", root, "-o", out, *options)
    assert done.exit_code == 0, done.stderr
    table = (out / "grades.csv").read_text(encoding="utf-8-sig")
    return {row["student"]: row for row in csv.DictReader(io.StringIO(table))}


NAMED = f"# partner: b\n{LOG}"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("log", "desk", "roster"),
    [
        (LOG, "b,partner,a,Ann,one log\n", ""),
        (LOG, "a,partner,b,Ann,one log\n", ""),
        (LOG, "", "student,name,partner\na,Ann Lee,b\nb,Bob Ray,\n"),
        (LOG, "", "student,name,partner\na,Ann Lee,\nb,Bob Ray,Ann Lee\n"),
        (NAMED, "", ""),
    ],
    ids=["desk", "desk of the other", "roster", "roster of the other", "log"],
)
def test_partner_without_a_log_is_graded_on_the_log_of_the_other(
    log: str, desk: str, roster: str, tmp_path: Path
) -> None:
    files: dict[str, str | bytes] = {
        "a/lab.csv": f"# {ANSWER}\n{log}",
        "b/report.txt": SLIP,
    }
    rows = graded(tmp_path, files, desk, roster)
    assert (rows["a"]["total"], rows["b"]["total"]) == ("20.00", "17.00")
    assert "rpm_as_rad_s" in rows["b"]["slips"], "each report has its own points"
    assert [rows[key]["flags"] + rows[key]["look"] for key in "ab"] == ["", ""]
    page = (tmp_path / "grades" / "class.html").read_text(encoding="utf-8")
    assert "<h2>Groups</h2>" in page
    first = (tmp_path / "grades" / "grades.csv").read_bytes()
    graded(tmp_path, files, desk, roster)
    assert (tmp_path / "grades" / "grades.csv").read_bytes() == first


@pytest.mark.slow
def test_the_log_of_somebody_who_does_not_agree_is_a_question(tmp_path: Path) -> None:
    rows = graded(
        tmp_path,
        {"a/lab.csv": f"# {ANSWER}\n{LOG}", "b/report.txt": f"partner: a\n{ANSWER}"},
    )
    assert rows["b"]["total"] == "20.00"
    assert "only b says that they are partners" in rows["b"]["look"]
    rows = graded(tmp_path, {}, desk="b,partner,a,Ann,they said so\n")
    assert rows["b"]["look"] == ""


@pytest.mark.slow
def test_a_partner_does_not_get_the_answer_of_the_other(tmp_path: Path) -> None:
    """Only a person can decide that one hand-in is of both."""
    files: dict[str, str | bytes] = {
        "a/lab.csv": f"# {ANSWER}\n{NAMED}",
        "b/plot.png": b"\x89PNG\r\n\x1a\n",
    }
    rows = graded(tmp_path, files)
    assert (rows["b"]["status"], rows["b"]["total"]) == ("not graded", "")
    assert "no I_zz is reported" in rows["b"]["why_not_graded"]
    rows = graded(tmp_path, files, desk="b,partner,a,Ann,one hand-in\n")
    assert rows["b"]["total"] == rows["a"]["total"] == "20.00"


@pytest.mark.slow
def test_student_who_handed_in_nothing_gets_points_by_the_desk_alone(
    tmp_path: Path,
) -> None:
    roster = "student,name,partner\na,Ann Lee,z\nz,Zoe Zed,a\n"
    files: dict[str, str | bytes] = {"a/lab.csv": f"# {ANSWER}\n{LOG}"}
    assert graded(tmp_path, files, roster=roster)["z"]["status"] == "nothing handed in"
    desk = "z,partner,a,Ann,they were ill\n"
    assert graded(tmp_path, files, desk, roster)["z"]["total"] == "20.00"


@pytest.mark.slow
def test_partners_with_different_logs_are_a_question(tmp_path: Path) -> None:
    files: dict[str, str | bytes] = {
        "a/lab.csv": NAMED,
        "b/report.txt": ANSWER,
        "c/lab.csv": a_log(7, "# partner: b"),
    }
    why = graded(tmp_path, files)["b"]["why_not_graded"]
    assert "its partners have different logs: a, c" in why
    desk = "b,partner,a,Ann,asked them\n"
    assert graded(tmp_path, files, desk)["b"]["total"] == "20.00"


@pytest.mark.slow
def test_third_student_who_copies_the_log_of_a_group_is_flagged(
    tmp_path: Path,
) -> None:
    files: dict[str, str | bytes] = {
        "a/lab.csv": f"# {ANSWER}\n{NAMED}",
        "b/report.txt": ANSWER,
        "c/lab.csv": f"# {ANSWER}\n{LOG}",
    }
    rows = graded(tmp_path, files)
    assert [bool(rows[key]["flags"]) for key in "abc"] == [True, True, True]
    assert "b" not in rows["a"]["flags"].partition("shared rows")[0]


FOLDERS = {
    "files": ("ann+bob/ann_report.txt", "ann+bob/bob_report.txt"),
    "folders": ("ann+bob/ann/report.txt", "ann+bob/bob/report.txt"),
    "words": ("ann and bob/Report of Ann.txt", "ann and bob/Bob, report.txt"),
}


@pytest.mark.slow
@pytest.mark.parametrize("form", FOLDERS)
def test_reports_in_the_folder_of_a_group_have_their_own_points(
    form: str, tmp_path: Path
) -> None:
    first, second = FOLDERS[form]
    group = first.partition("/")[0]
    files: dict[str, str | bytes] = {f"{group}/lab.csv": LOG, first: ANSWER}
    rows = graded(tmp_path, {**files, second: SLIP})
    totals = [rows[f"{group}/{one}"]["total"] for one in ("ann", "bob")]
    assert totals == ["20.00", "17.00"]
    assert [rows[f"{group}/{one}"]["flags"] for one in ("ann", "bob")] == ["", ""]
    pages = (tmp_path / "grades" / "feedback" / group).rglob("*.html")
    assert len(list(pages)) == 2


@pytest.mark.slow
@pytest.mark.parametrize(
    "files",
    [
        {"ann+bob/report.txt": ANSWER},
        {"ann/report.txt": ANSWER, "ann/code/fit.py": "print(1)"},
        {"lab_report/report.txt": ANSWER, "lab_report/lab.md": "notes"},
    ],
    ids=["one report", "one student", "words that are no names"],
)
def test_folder_with_one_report_is_one_submission(
    files: dict[str, str | bytes], tmp_path: Path
) -> None:
    folder = next(iter(files)).partition("/")[0]
    rows = graded(tmp_path, {f"{folder}/lab.csv": LOG, **files})
    assert {key for key in rows if not key.startswith("s1")} == {
        folder,
        "points possible",
    }
    assert rows[folder]["total"] == "20.00"


@pytest.mark.slow
def test_log_of_a_group_counts_once_for_the_reference(tmp_path: Path) -> None:
    """A group of six with a log that is far off must not become the reference."""
    off = sheet(np.random.default_rng(5), "mixed").log().replace(",406", ",812")
    members = {f"m{n}": f"m{n}/report.txt" for n in range(8)}
    names = "".join(f"# partner: {one}\n" for one in members)
    files: dict[str, str | bytes] = {
        "lead/lab.csv": f"{names}# {ANSWER}\n{off}",
        **dict.fromkeys(members.values(), ANSWER),
    }
    with_group = graded(tmp_path / "group", files)
    alone = graded(tmp_path / "alone", {"lead/lab.csv": files["lead/lab.csv"]})
    assert with_group["s10"]["z"] == alone["s10"]["z"]


@pytest.mark.slow
def test_a_lent_log_does_not_reopen_the_flag_of_its_owner(tmp_path: Path) -> None:
    files: dict[str, str | bytes] = {
        "a/lab.csv": f"# {ANSWER}\n{LOG}",
        "b/report.txt": ANSWER,
        "c/lab.csv": f"# {ANSWER}\n{LOG}",
    }
    verdict = "a + c,flag,copied,Ann,both were asked\n"
    todo = tmp_path / "grades" / "desk-todo.csv"
    graded(tmp_path, files, "b,partner,a,Ann,one log\n")
    assert "a + b + c,flag," in todo.read_text(encoding="utf-8-sig")
    graded(tmp_path, files, f"{verdict}b,partner,a,Ann,one log\n")
    assert " + c,flag," not in todo.read_text(encoding="utf-8-sig")
