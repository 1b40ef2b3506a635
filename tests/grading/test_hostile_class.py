"""Submissions that stop or break a program cost only their own student, and are never
opened in the main process.
"""

from __future__ import annotations

import csv
import io
import os
import shutil
import sys
from pathlib import Path
from typing import IO, Any

import pytest
from grading.classes import make_folder, packed
from grading.students_reports import a_log
from typer.testing import CliRunner, Result

from gyrodata.cli import app
from gyrodata.grading.submissions import archives

SPREADSHEET = (
    '<office:document-content xmlns:office="urn:oasis:names:tc:opendocument:xmlns:office:1.0"'
    ' xmlns:table="urn:oasis:names:tc:opendocument:xmlns:table:1.0"'
    ' xmlns:text="urn:oasis:names:tc:opendocument:xmlns:text:1.0"><office:body><office:spreadsheet>'
    '<table:table table:name="a">{}</table:table></office:spreadsheet></office:body>'
    "</office:document-content>"
)
ROW = (
    '<table:table-row table:number-rows-repeated="1048576"><table:table-cell '
    'table:number-columns-repeated="16384">'
    "<text:p>1</text:p></table:table-cell></table:table-row>"
)


def bombs() -> dict[str, dict[str, bytes | str]]:
    """Make the files of each hostile student."""
    cells = {
        "mimetype": "application/vnd.oasis.opendocument.spreadsheet",
        "content.xml": SPREADSHEET.format(ROW),
    }
    names = {f"{number:05}{'n' * 40}": b"" for number in range(4_000)}
    return {
        "x_cells": {"lab.ods": packed(cells)},
        "x_names": {"lab.zip": packed(names)},
        "x_list": {"lab.json": "[" * 2000},
        "x_object": {"lab.json": '{"a":' * 2000},
        "x_notebook": {"lab.ipynb": '{"cells":' + "[" * 2000},
        "x_blanks": {"README": ("I_zz =" + " " * 20_000 + "x\n") * 20},
        "x_hashes": {"lab.csv": "#" * 3_000_000},
        "x_rows": {"lab.csv": "a & b \\\\\n" * 50_000},
        "x_markup": {"lab.docx": packed({"word/document.xml": "<s>" * 200_000})},
        "x_partners": {
            "lab.csv": "# partner: "
            + " & ".join(f"Ann{n} Lee" for n in range(20_000))
            + "\n"
        },
    }


GOOD: dict[str, bytes | str] = {f"s{seed}/lab.csv": a_log(seed) for seed in range(4)}


def graded(folder: Path, *options: str) -> tuple[Result, dict[str, dict[str, str]]]:
    """Grade a class; return what the command did, and the rows of grades.csv."""
    out = folder.parent / f"{folder.name}-grades"
    words = ["grade", str(folder), "--out", str(out), "--workers", "2", *options]
    done = CliRunner().invoke(app, words, catch_exceptions=False)
    table = (out / "grades.csv").read_text(encoding="utf-8")
    return done, {row["student"]: row for row in csv.DictReader(io.StringIO(table))}


@pytest.mark.slow
@pytest.mark.skipif(
    sys.platform != "linux",
    reason="a worker that is not forked does not see the replaced function",
)
def test_hostile_submissions_cost_nobody_else_anything(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    main, read = os.getpid(), archives.open_file

    def reading(*where: Any) -> IO[bytes]:
        assert os.getpid() != main, f"the main process opens {where[1]}"
        return read(*where)

    monkeypatch.setattr(archives, "open_file", reading)
    _, alone = graded(make_folder(tmp_path / "good", GOOD))
    hostile = {
        f"{student}/{name}": data
        for student, files in bombs().items()
        for name, data in files.items()
    }
    done, rows = graded(
        make_folder(tmp_path / "class", {**GOOD, **hostile}), "--timeout", "2"
    )
    assert done.exit_code == 1
    for student in ("s0", "s1", "s2", "s3"):
        assert rows[student]["total"] == "20.00"
        assert rows[student] == alone[student]
    for student, files in bombs().items():
        assert (rows[student]["status"], rows[student]["total"]) == ("not graded", "")
        why = rows[student]["why_not_graded"]
        beginnings = ("the log cannot be", "no log: only 00000nnn")
        assert any(name in why for name in files) or why.startswith(beginnings), why
        assert len(why) < 1000
    # What is lost is tried again: of the others, once is enough.
    for student in bombs():
        if student != "x_markup":
            shutil.rmtree(tmp_path / "class" / student)
    again, _ = graded(tmp_path / "class", "--timeout", "1")
    assert "(new)" not in again.stderr
    assert (
        "lost last time: the file lab.docx: it took over 2 s): x_markup\n"
        in again.stderr
    )


@pytest.mark.slow
def test_a_zip_of_a_class_is_opened_and_the_zips_in_it_only_by_workers(
    tmp_path: Path,
) -> None:
    inner = packed({"lab.csv": b"0" * 20_000_000})
    bomb = packed({f"{number}.zip": inner for number in range(300)})
    files = {"doeann_1_2_lab.csv": a_log(1), "roebob_3_4_lab.zip": bomb}
    files["poecy_5_6_lab.zip"] = packed({"lab.csv": a_log(2)})
    (tmp_path / "class.zip").write_bytes(packed(files))
    done, rows = graded(tmp_path / "class.zip", "--timeout", "2")
    assert done.exit_code == 1
    assert [rows[student]["total"] for student in ("1", "3", "5")] == [
        "20.00",
        "",
        "20.00",
    ]
    assert "roebob_3_4_lab.zip" in rows["3"]["why_not_graded"]


@pytest.mark.slow
def test_the_log_that_a_person_corrected_is_graded_with_the_other_files(
    tmp_path: Path,
) -> None:
    answer = next(
        line for line in a_log(1).splitlines() if "inertia" in line or "I_zz" in line
    )
    without = a_log(1).replace(f"{answer}\n", "")
    files = {
        "ann/lab.csv": without.replace("time [s]", "nonsense"),
        "ann/README.txt": answer.lstrip("# "),
    }
    folder = make_folder(tmp_path / "class", files)
    done, rows = graded(folder)
    assert (done.exit_code, rows["ann"]["status"]) == (1, "not graded")
    grades = make_folder(tmp_path / "class-grades", {"fixed.csv": without})
    (grades / "desk.csv").write_text(
        "student,what,value,by,why\nann,log,fixed.csv,TA,\n", encoding="utf-8"
    )
    done, rows = graded(folder)
    assert (done.exit_code, rows["ann"]["total"]) == (0, "20.00")


@pytest.mark.slow
def test_a_line_of_the_desk_for_a_lost_submission_is_asked_again_if_the_files_change(
    tmp_path: Path,
) -> None:
    folder = make_folder(
        tmp_path / "class", {"ann/lab.json": "[" * 2000, "s1/lab.csv": a_log(1)}
    )
    done, _ = graded(folder)
    assert done.exit_code == 1
    desk = tmp_path / "class-grades" / "desk.csv"
    desk.write_text(
        "student,what,value,by,why\nann,total,0,TA,no log\n", encoding="utf-8"
    )
    for _ in range(2):
        done, rows = graded(folder)
        assert (done.exit_code, rows["ann"]["total"]) == (0, "0.00")
        assert "resubmitted" not in rows["ann"]["look"]
    (folder / "ann" / "lab.json").unlink()
    make_folder(folder, {"ann/lab.csv": a_log(2)})
    assert (
        "resubmitted since total 0 was set by hand" in graded(folder)[1]["ann"]["look"]
    )
