"""Whose submission each file is, on classes written as each platform names its files."""

from collections.abc import Mapping
from pathlib import Path

import pytest
from grading.classes import LOG, make_folder, make_zip

from gyrodata.grading import Submission, Submissions, find_submissions

BOTH = pytest.mark.parametrize("make", [make_folder, make_zip])


def by_student(found: Submissions) -> dict[str, Submission]:
    return {item.student: item for item in found.items}


def codes(found: Submissions) -> list[str]:
    return [diagnostic.code for diagnostic in found.diagnostics]


def submissions(tmp_path: Path, files: Mapping[str, str | bytes], **options: str) -> Submissions:
    return find_submissions(make_folder(tmp_path / "class", files), **options)  # type: ignore[arg-type]


# --- folders ------------------------------------------------------------------------------------------------


@BOTH
def test_a_folder_for_each_student(tmp_path: Path, make) -> None:
    files = {
        "jdoe/lab.csv": LOG,
        "jdoe/answers.toml": 'inertia = "4.4 g m^2"',
        "jdoe/report.pdf": "x",
        "Doe, Jane_2/lab.csv": LOG,
        "李雷/sub/folder/data.csv": LOG,
        "Иван Ёлкин/lab.csv": LOG,
        "שרה כהן/lab.csv": LOG,
        "photographer/photo.png": "x",
        "grades.csv": "of last year",
    }
    found = find_submissions(make(tmp_path / "class.zip", files))
    people = by_student(found)
    assert found.lms == "folder"
    assert sorted(people) == sorted(["jdoe", "Doe, Jane_2", "李雷", "Иван Ёлкин", "שרה כהן", "photographer"])
    assert list(people) == sorted(people)
    jane = people["jdoe"]
    assert (jane.log_name, jane.report_names) == ("jdoe/lab.csv", ("jdoe/answers.toml",))
    assert jane.members == ("jdoe/answers.toml", "jdoe/lab.csv", "jdoe/report.pdf")
    assert (jane.log(), list(jane.reports())) == (LOG.encode(), [("answers.toml", b'inertia = "4.4 g m^2"')])
    assert people["李雷"].log_file == "sub/folder/data.csv"
    assert list(people["李雷"].reports()) == []
    assert people["photographer"].problem == "no log: only photo.png"
    assert codes(found) == ["G707"]
    assert "grades.csv" in found.diagnostics[0].message


@BOTH
def test_a_flat_folder_has_a_file_for_each_student(tmp_path: Path, make) -> None:
    files = {
        "jdoe.csv": LOG,
        "jdoe_answers.toml": "",
        "o'neil.CSV": LOG,
        "o'neil.toml": "",
        "lee.csv.gz": LOG,
        "kim (1).csv": LOG,
        "kim.csv": "",
        "zoe.pdf": "x",
        "README.md": "x",
    }
    found = find_submissions(make(tmp_path / "class", files))
    people = by_student(found)
    assert list(people) == ["jdoe", "kim", "lee", "o'neil", "zoe"]
    assert people["jdoe"].report_names == ("jdoe_answers.toml",)
    assert people["o'neil"].report_names == ("o'neil.toml",)
    assert people["kim"].log_name == "kim (1).csv"
    assert people["zoe"].problem == "no log: only zoe.pdf"


@BOTH
@pytest.mark.parametrize(
    "files",
    [
        {"lab 3/ann/lab.csv": LOG, "lab 3/bob/lab.csv": LOG},
        {"lab 3/__MACOSX/x": "", "lab 3/ann/lab.csv": LOG, "lab 3/bob/lab.csv": LOG, ".DS_Store": ""},
    ],
)
def test_one_folder_around_the_class_is_seen_through(tmp_path: Path, make, files: dict[str, str]) -> None:
    assert list(by_student(find_submissions(make(tmp_path / "class", files)))) == ["ann", "bob"]


# --- which file is the log ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("files", "log"),
    [
        ({"lab.csv": LOG, "notes.txt": "x"}, "lab.csv"),
        ({"lab.txt": LOG}, "lab.txt"),
        ({"lab.xlsx": "x", "lab.tsv": LOG}, "lab.tsv"),
        ({"data.csv": LOG, "fit.csv": "slope,u\n1,2\n"}, "data.csv"),
        ({"lab.csv": LOG, "copy of lab.csv": LOG}, "copy of lab.csv"),
        ({"lab.csv": "", "lab-1.csv": LOG}, "lab-1.csv"),
        ({"lab (2).csv": LOG, "lab (1).csv": "", "lab.csv": ""}, "lab (2).csv"),
    ],
)
def test_the_log_among_several_files(tmp_path: Path, files: dict[str, str], log: str) -> None:
    found = submissions(tmp_path, {f"ann/{name}": content for name, content in files.items()})
    assert (found.items[0].log_file, found.items[0].problem) == (log, None)


PACKED = "is an archive within the submission and is not opened; unpack it"


@pytest.mark.parametrize(
    ("files", "problem"),
    [
        ({"a.csv": LOG, "b.csv": LOG + "\n"}, "several files that read as logs: a.csv, b.csv"),
        ({"a.csv": "x", "b.csv": "y"}, "several files and none of them reads as a log: a.csv, b.csv"),
        ({"lab.csv": ""}, "lab.csv is empty"),
        ({"lab.zip": "PK"}, f"no log: lab.zip {PACKED}"),
        ({"lab.tar.gz": "x", "a.png": ""}, f"no log: lab.tar.gz {PACKED}"),
        ({"a.png": "", "b.docx": ""}, "no log: only a.png, b.docx"),
        ({"answers.toml": ""}, "no log: only answers.toml"),
    ],
)
def test_why_there_is_no_log(tmp_path: Path, files: dict[str, str], problem: str) -> None:
    found = submissions(tmp_path, {f"ann/{name}": content for name, content in files.items()}, lms="folder")
    assert (found.items[0].log_name, found.items[0].problem) == (None, problem)


# --- Canvas -------------------------------------------------------------------------------------------------

CANVAS = {
    "doejane_9876_55501_lab.csv": LOG,
    "doejane_9876_55502_answers.toml": 'inertia = "4.4 g m^2"',
    "ёлкиниван_LATE_9877_55503_my lab_1_2.csv": LOG,
    "late_9878_55504_lab.csv": LOG,
    "o_neil_9879_55505_lab.csv": LOG,
    "李雷_9880_text.html": "<p>",
    "LATE_anon_Ab1dE_55507_lab.csv": LOG,
    "kim_9881_55508_lab.csv": LOG,
    "kim_9881_55599_lab-1.csv": LOG + "\n",
    "labgroup3_9882_55510_lab.csv": LOG,
}


@BOTH
def test_canvas(tmp_path: Path, make) -> None:
    found = find_submissions(make(tmp_path / "submissions.zip", CANVAS))
    people = by_student(found)
    assert found.lms == "canvas"
    assert list(people) == ["9876", "9877", "9878", "9879", "9880", "9881", "9882", "anon_Ab1dE"]
    jane = people["9876"]
    assert (jane.name, jane.ids, jane.late) == ("doejane", {"canvas": "9876"}, False)
    assert (jane.log_file, jane.report_names) == ("lab.csv", ("doejane_9876_55502_answers.toml",))
    assert jane.feedback_stem == "doejane_9876_55501_lab", "Canvas finds the student by the two numbers"
    ivan = people["9877"]
    assert (ivan.name, ivan.late, ivan.late_seconds) == ("ёлкиниван", True, None)
    assert ivan.log_file == "my lab_1_2.csv"
    assert (people["9878"].name, people["9878"].late) == ("late", False), "a surname, not a mark"
    assert people["9879"].name == "o_neil"
    assert people["9880"].problem == "no log: only text.html"
    assert people["anon_Ab1dE"].late
    assert people["anon_Ab1dE"].ids == {"canvas_anonymous": "Ab1dE"}
    assert people["9881"].log_file == "lab-1.csv"
    assert codes(found) == ["G708"]


# --- Moodle -------------------------------------------------------------------------------------------------


@BOTH
def test_moodle(tmp_path: Path, make) -> None:
    files = {
        "Jane Doe_1234567_assignsubmission_file/lab.csv": LOG,
        "Jane Doe_1234567_assignsubmission_onlinetext/onlinetext.html": "<p>",
        "Jane Doe_1234568_assignsubmission_file/sub/lab.csv": LOG,
        "Doe, John Jr._1234569_assignsubmission_file_/lab.csv": LOG,
        "李 雷_1234570_assignsubmission_file_/lab_1.csv": LOG,
        "Participant_1234571_assignsubmission_file/lab.csv": LOG,
        "שרה כהן_1234572_assignsubmission_file_my_lab.csv": LOG,
        "Lab group 3_88_assignsubmission_file/lab.csv": LOG,
    }
    found = find_submissions(make(tmp_path / "moodle.zip", files))
    people = by_student(found)
    assert (found.lms, found.diagnostics) == ("moodle", ())
    assert list(people) == ["1234567", "1234568", "1234569", "1234570", "1234571", "1234572", "88"]
    assert people["1234567"].name == "Jane Doe (1234567)", "there are two of this name"
    assert people["1234567"].feedback_stem == "Jane Doe_1234567_assignsubmission_file"
    assert people["1234568"].log_file == "sub/lab.csv"
    assert people["1234569"].name == "Doe, John Jr."
    assert people["1234569"].feedback_stem == "Doe, John Jr._1234569_assignsubmission_file_"
    assert people["1234570"].log_file == "lab_1.csv"
    assert people["1234571"].name == "Participant 1234571"
    assert people["1234572"].log_file == "my_lab.csv"
    assert people["1234572"].feedback_stem == "שרה כהן_1234572_assignsubmission_file_my_lab"
    assert people["88"].ids == {"moodle": "88", "folder": "Lab group 3_88_assignsubmission_file"}


# --- Blackboard ---------------------------------------------------------------------------------------------

STEM = "Gyro lab_1_{}_attempt_2026-03-{:02d}-14-05-59"
RECEIPT = "Name: {} ({})\r\nAssignment: Gyro lab_1\r\nDate Submitted: Monday, March 9, 2026 2:05:59 PM EDT\r\n"


@BOTH
def test_blackboard(tmp_path: Path, make) -> None:
    files = {
        STEM.format("j_doe", 9) + ".txt": RECEIPT.format("Jane (Doe)", "j_doe"),
        STEM.format("j_doe", 9) + "_lab.csv": LOG,
        STEM.format("j_doe", 11) + ".txt": RECEIPT.format("Jane (Doe)", "j_doe"),
        STEM.format("j_doe", 11) + "_my_lab.csv": LOG,
        STEM.format("bob", 10) + ".txt": "Name: Mallory (j_doe)\nan odd receipt\n",
        STEM.format("bob", 10) + "_lab.csv": LOG,
        STEM.format("k_im", 10) + "_lab(1).csv": LOG,
        STEM.format("zoe", 10) + ".txt": RECEIPT.format("Zoë Ö", "zoe"),
    }
    found = find_submissions(make(tmp_path / "gradebook.zip", files))
    people = by_student(found)
    assert found.lms == "blackboard"
    assert list(people) == ["bob", "j_doe", "k_im", "zoe"]
    jane = people["j_doe"]
    assert (jane.name, jane.ids) == ("Jane (Doe)", {"username": "j_doe"})
    assert (jane.submitted, jane.attempt, jane.log_file) == ("2026-03-11T14:05:59", 2, "my_lab.csv")
    assert people["bob"].name == "bob", "a receipt in another's name is not believed"
    assert people["zoe"].problem == "no files"
    assert people["zoe"].name == "Zoë Ö"
    assert codes(found) == ["G708"]
    oldest = by_student(find_submissions(tmp_path / "gradebook.zip", attempts="oldest"))["j_doe"]
    assert (oldest.submitted, oldest.attempt, oldest.log_file) == ("2026-03-09T14:05:59", 1, "lab.csv")


# --- Gradescope ---------------------------------------------------------------------------------------------

EXPORT = """---
submission_101:
  :submitters:
  - :name: Jane Doe
    :sid: '0012'
    :email: jane@uni.example
  :created_at: 2026-03-09 14:05:59.123456789 -08:00
  :score: 10.0
  :status: processed
  :results:
    tests:
    - name: ":name: Mallory"
      output: |-
        :created_at: never
        submission_999:
  :history:
  - :id: 99
    :created_at: 2026-03-01 00:00:00.000000000 Z
    :submitters:
    - :name: Mallory
submission_102:
  :submitters:
  - :name: "Zo\\xEB \\"Z\\" O'Neil"
    :sid: &1 s7
    :email: zoe@uni.example
  - :name: 'Bob O''Neil: =1+1'
    :sid: ''
    :email: bob@uni.example
  :created_at: 2026-03-09 22:05:59.000000000 Z
submission_103:
  :submitters:
  - :name: !binary |-
      5p2O6Zu3
    :sid: ~
    :email:
  :created_at:
"""


@BOTH
def test_gradescope(tmp_path: Path, make) -> None:
    outer = "assignment_42_export/"
    files = {
        f"{outer}submission_metadata.yml": EXPORT,
        f"{outer}submission_101/lab.csv": LOG,
        f"{outer}submission_102/lab.csv": LOG,
        f"{outer}submission_102/submission_metadata.yml": EXPORT.replace("Zo", "Mallory"),
        f"{outer}submission_103/lab.csv": LOG,
        f"{outer}submission_104/lab.csv": LOG,
    }
    found = find_submissions(make(tmp_path / "export.zip", files))
    people = by_student(found)
    assert (found.lms, found.diagnostics) == ("gradescope", ())
    assert list(people) == ["0012", "104", "bob@uni.example+s7", "李雷"]
    jane = people["0012"]
    assert (jane.name, jane.submitted, jane.late_seconds) == ("Jane Doe", "2026-03-09T14:05:59-08:00", None)
    assert jane.ids == {"gradescope": "101", "sid": "0012", "email": "jane@uni.example", "folder": "submission_101"}
    group = people["bob@uni.example+s7"]
    assert group.name == "Bob O'Neil: =1+1, Zoë \"Z\" O'Neil"
    assert group.members_of_group == ("bob@uni.example", "s7")
    assert group.feedback_stem == "submission_102"
    assert people["104"].submitted is None


LIVE = """{"id": 123, "created_at": "2026-03-10T01:00:00.365935-08:00",
 "assignment": {"due_date": "2026-03-09T23:00:00.000000-08:00", "late_due_date": null, "total_points": "20.0"},
 "submission_method": "upload",
 "users": [{"email": "jane@uni.example", "id": 77, "name": "Jane Doe"}],
 "previous_submissions": [{"score": 0.0, "autograder_error": true}, {"score": 3.0, "autograder_error": false}]}"""


def test_a_running_autograder(tmp_path: Path) -> None:
    root = make_folder(tmp_path / "autograder", {
        "submission_metadata.json": LIVE, "submission/lab.csv": LOG, "source/setup.sh": "x", "results/stdout": "",
    })  # fmt: skip
    found = find_submissions(root)
    (jane,) = found.items
    assert found.lms == "gradescope"
    assert (jane.student, jane.name, jane.ids["gradescope"]) == ("jane@uni.example", "Jane Doe", "123")
    assert jane.submitted == "2026-03-10T01:00:00-08:00"
    assert (jane.late, jane.late_seconds) == (True, 7200.365935)
    assert jane.attempt == 2, "an attempt that failed on the platform's side does not count"
    assert jane.log() == LOG.encode()


# --- a pattern of one's own ---------------------------------------------------------------------------------


def test_a_pattern_of_ones_own(tmp_path: Path) -> None:
    files = {
        "week3-jdoe-try1.csv": LOG,
        "week3-jdoe-try2.csv": LOG,
        "week3-kim-try1-late.csv": LOG,
        "other.csv": LOG,
    }
    pattern = r"week3-(?P<student>\w+)-try(?P<attempt>\d+)(?P<late>-late)?\.csv"
    found = submissions(tmp_path, files, pattern=pattern)
    people = by_student(found)
    assert found.lms == "pattern"
    assert list(people) == ["jdoe", "kim"]
    assert (people["jdoe"].log_name, people["jdoe"].attempt) == ("week3-jdoe-try2.csv", 2)
    assert people["kim"].late
    assert codes(found) == ["G707", "G708"]


# --- nothing there ------------------------------------------------------------------------------------------


# --- feedback -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("file", "feedback"),
    [
        ("doejane_LATE_9876_55501_lab.csv", "doejane_LATE_9876_55501_lab.html"),
        ("Zoë Ö_12_assignsubmission_file_/sub/lab.csv", "Zoë Ö_12_assignsubmission_file_/feedback.html"),
        ("Zoë Ö_12_assignsubmission_file_lab.csv", "Zoë Ö_12_assignsubmission_file_lab.html"),
        (STEM.format("jdoe", 9) + "_lab.csv", STEM.format("jdoe", 9) + "_lab.html"),
        ("submission_7/lab.csv", "submission_7/feedback.html"),
        ("jdoe/lab.csv", "jdoe/feedback.html"),
        ("jdoe.csv", "jdoe/feedback.html"),
    ],
)
def test_feedback_is_named_so_that_the_platform_takes_it_back(tmp_path: Path, file: str, feedback: str) -> None:
    assert submissions(tmp_path, {file: LOG}).items[0].feedback_name(".html") == feedback


# --- what holds for all -------------------------------------------------------------------------------------
