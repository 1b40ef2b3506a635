"""Whose submission each file is, on classes written as each platform names its files."""

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from grading.classes import LOG, find_submissions, make_folder, make_zip
from places import DATA

from gyrodata.grading.submissions import Submission

Class = dict[str, Any]
CLASSES: dict[str, Class] = tomllib.loads(
    (DATA / "names_of_platforms.toml").read_text("utf-8")
)
TEX = (
    r"\begin{tabular}{ccccc}"  # noqa: ISC003
    + "\n"
    + LOG.replace(",", " & ").replace("\n", " \\\\\n")
    + r"\end{tabular}"
)
STEM = "Gyro lab_1_{}_attempt_2026-03-{:02d}-14-05-59"


def files_of(found: Class) -> dict[str, str]:
    return found["files"] | dict.fromkeys(found["logs"], LOG)


def stored(value: object) -> object:
    """Give a value as the table has it."""
    return (
        "None" if value is None else list(value) if isinstance(value, tuple) else value
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "make"),
    [
        *((name, make_folder) for name in CLASSES),
        *((name, make_zip) for name in CLASSES),
    ],
)
def test_files_of_a_platform_are_given_to_their_students(
    name: str, make, tmp_path: Path
) -> None:
    known = CLASSES[name]
    found = find_submissions(make(tmp_path / "class.zip", files_of(known)))
    assert (found.lms, [one.code for one in found.diagnostics]) == (
        known["lms"],
        known["codes"],
    )
    people = {one.student: one for one in found.items}
    assert list(people) == list(known["people"])
    for key, person in known["people"].items():
        assert {name: stored(getattr(people[key], name)) for name in person} == person
    assert [
        one.student
        for one in found.items
        if one.problem is None and LOG.encode() not in one.log()
    ] == []


def one_of(tmp_path: Path, files: Mapping[str, str], **options: str) -> Submission:
    return find_submissions(make_folder(tmp_path / ("class"), files), **options).items[
        0
    ]  # type: ignore[arg-type]


def test_folders_that_look_alike_are_of_different_students(tmp_path: Path) -> None:
    folders = (
        "ann",
        "ann ",
        "ann\u200b",
        "bo ",
        "bo  ",
        "cy ",
        "e\u0301va",
        "\u00e9va",
    )
    root = make_folder(tmp_path / "c", {f"{folder}/lab.csv": LOG for folder in folders})
    items = {item.student: item for item in find_submissions(root).items}
    names = ["ann", "ann (2)", "ann (3)", "bo", "bo (2)", "cy", "\u00e9va"]
    assert [*items] == names
    assert items["ann"].members == ("ann/lab.csv",)
    assert items["ann (2)"].feedback_stem == "ann (2)"


def test_oldest_attempt_is_taken_where_that_is_asked_for(tmp_path: Path) -> None:
    jane = {
        name: data
        for name, data in files_of(CLASSES["Blackboard"]).items()
        if "j_doe" in name
    }
    oldest = one_of(tmp_path, jane, attempts="oldest")
    assert (oldest.submitted, oldest.log_file) == ("2026-03-09T14:05:59", "lab.csv")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("files", "log", "problem"),
    [
        ({"lab.csv": LOG, "notes.txt": "x"}, "lab.csv", None),
        ({"lab.xlsx": "x", "lab.tsv": LOG}, "lab.tsv", None),
        ({"data.csv": LOG, "fit.csv": "slope,u\n1,2\n"}, "data.csv", None),
        ({"lab (2).csv": LOG, "lab (1).csv": "", "lab.csv": ""}, "lab (2).csv", None),
        (
            {"a.csv": LOG, "b.csv": LOG.replace("406", "410")},
            None,
            "several files that read as logs: a.csv, b.csv",
        ),
        ({"a_old.csv": LOG, "a_v2.csv": LOG.replace("406", "410")}, "a_v2.csv", None),
        ({"log": LOG, "plot.png": ""}, "log", None),
        ({"a.tex": TEX}, None, "no log: only a.tex"),
        (
            {"a.png": "", "b.txt": "I_zz = 4.4e-3 kg m^2"},
            None,
            "no log: only a.png, b.txt",
        ),
        (
            {"a.xlsx": "PK\3\4"},
            None,
            "a.xlsx is damaged, such as a file that was not uploaded to its end; hand it in again",
        ),
        ({"lab.csv": ""}, None, "lab.csv is empty"),
        ({"lab.rar": "x"}, None, "no log: only lab.rar"),
        ({"a.png": "", "b.docx": ""}, None, "no log: only a.png, b.docx"),
    ],
)
def test_log_among_several_files_is_found_or_its_lack_told(
    files: dict[str, str], log: str | None, problem: str | None, tmp_path: Path
) -> None:
    one = one_of(
        tmp_path,
        {f"ann/{name}": content for name, content in files.items()},
        lms="folder",
    )
    assert (one.log_name, one.problem) == (log and f"ann/{log}", problem)


@pytest.mark.parametrize(
    ("file", "feedback"),
    [
        ("doejane_LATE_9876_55501_lab.csv", "doejane_LATE_9876_55501_lab.html"),
        (
            "Zoë Ö_12_assignsubmission_file_/sub/lab.csv",
            "Zoë Ö_12_assignsubmission_file_/feedback.html",
        ),
        (STEM.format("jdoe", 9) + "_lab.csv", STEM.format("jdoe", 9) + "_lab.html"),
        ("submission_7/lab.csv", "submission_7/feedback.html"),
        ("jdoe.csv", "jdoe/feedback.html"),
    ],
)
def test_feedback_has_the_name_that_the_platform_takes_back(
    file: str, feedback: str, tmp_path: Path
) -> None:
    assert f"{one_of(tmp_path, {file: LOG}).feedback_name}.html" == feedback
