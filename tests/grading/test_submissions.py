"""Whose submission each file is, on classes written as each platform names its files."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from grading.classes import LOG, make_folder, make_zip

from gyrodata.grading import Submission, find_submissions

STEM = "Gyro lab_1_{}_attempt_2026-03-{:02d}-14-05-59"
RECEIPT = "Name: {} ({})\r\nAssignment: Gyro lab_1\r\nDate Submitted: Monday, March 9, 2026 2:05:59 PM EDT\r\n"
EXPORT = """---
submission_101:
  :submitters:
  - :name: Jane Doe
    :sid: '0012'
    :email: jane@uni.example
  :created_at: 2026-03-09 14:05:59.123456789 -08:00
  :results:
    tests:
    - name: ":name: Mallory"
      output: |-
        :created_at: never
        submission_999:
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
LIVE = """{"id": 123, "created_at": "2026-03-10T01:00:00.365935-08:00",
 "assignment": {"due_date": "2026-03-09T23:00:00.000000-08:00", "late_due_date": null, "total_points": "20.0"},
 "users": [{"email": "jane@uni.example", "id": 77, "name": "Jane Doe"}],
 "previous_submissions": [{"score": 0.0, "autograder_error": true}, {"score": 3.0, "autograder_error": false}]}"""
ANSWER = 'inertia = "4.4 g m^2"'

Person = dict[str, Any]

FOLDERS = {
    "jdoe/lab.csv": LOG, "jdoe/answers.toml": ANSWER, "jdoe/report.pdf": "x", "Doe, Jane_2/lab.csv": LOG,
    "李雷/sub/folder/data.csv": LOG, "Иван Ёлкин/lab.csv": LOG, "שרה כהן/lab.csv": LOG, "photographer/photo.png": "x",
    "grades.csv": "of last year",
}  # fmt: skip
IN_FOLDERS: dict[str, Person] = {
    "Doe, Jane_2": {},
    "jdoe": {
        "log_name": "jdoe/lab.csv", "report_names": ("jdoe/answers.toml",),
        "members": ("jdoe/answers.toml", "jdoe/lab.csv", "jdoe/report.pdf"),
    },
    "photographer": {"problem": "no log: only photo.png"},
    "Иван Ёлкин": {}, "שרה כהן": {},
    "李雷": {"log_file": "sub/folder/data.csv", "report_names": ()},
}  # fmt: skip

FLAT = {
    "jdoe.csv": LOG, "jdoe_answers.toml": "", "o'neil.CSV": LOG, "o'neil.toml": "", "lee.csv.gz": LOG,
    "kim (1).csv": LOG, "kim.csv": "", "zoe.pdf": "x", "README.md": "x",
}  # fmt: skip
IN_FLAT: dict[str, Person] = {
    "jdoe": {"report_names": ("jdoe_answers.toml",)},
    "kim": {"log_name": "kim (1).csv"},
    "lee": {},
    "o'neil": {"report_names": ("o'neil.toml",)},
    "zoe": {"problem": "no log: only zoe.pdf"},
}

CANVAS = {
    "doejane_9876_55501_lab.csv": LOG, "doejane_9876_55502_answers.toml": ANSWER,
    "ёлкиниван_LATE_9877_55503_my lab_1_2.csv": LOG, "late_9878_55504_lab.csv": LOG, "o_neil_9879_55505_lab.csv": LOG,
    "李雷_9880_text.html": "<p>", "LATE_anon_Ab1dE_55507_lab.csv": LOG,
    "kim_9881_55508_lab.csv": LOG, "kim_9881_55599_lab-1.csv": LOG + "\n", "labgroup3_9882_55510_lab.csv": LOG,
}  # fmt: skip
IN_CANVAS: dict[str, Person] = {
    "9876": {
        "name": "doejane", "ids": {"canvas": "9876"}, "late": False, "log_file": "lab.csv",
        "report_names": ("doejane_9876_55502_answers.toml",), "feedback_stem": "doejane_9876_55501_lab",
    },
    "9877": {"name": "ёлкиниван", "late": True, "late_seconds": None, "log_file": "my lab_1_2.csv"},
    "9878": {"name": "late", "late": False},  # a surname, not a mark
    "9879": {"name": "o_neil"},
    "9880": {"problem": "no log: only text.html"},
    "9881": {"log_file": "lab-1.csv"},
    "9882": {},
    "anon_Ab1dE": {"late": True, "ids": {"canvas_anonymous": "Ab1dE"}},
}  # fmt: skip

FILE = "_assignsubmission_file"
MOODLE = {
    "Jane Doe_1234567_assignsubmission_onlinetext/onlinetext.html": "<p>",
    **dict.fromkeys(
        [
            f"Jane Doe_1234567{FILE}/lab.csv", f"Jane Doe_1234568{FILE}/sub/lab.csv",
            f"Doe, John Jr._1234569{FILE}_/lab.csv", f"李 雷_1234570{FILE}_/lab_1.csv",
            f"Participant_1234571{FILE}/lab.csv", f"שרה כהן_1234572{FILE}_my_lab.csv", f"Lab group 3_88{FILE}/lab.csv",
        ],
        LOG,
    ),
}  # fmt: skip
IN_MOODLE: dict[str, Person] = {
    "1234567": {"name": "Jane Doe (1234567)", "feedback_stem": f"Jane Doe_1234567{FILE}"},  # two have this name
    "1234568": {"log_file": "sub/lab.csv"},
    "1234569": {"name": "Doe, John Jr.", "feedback_stem": f"Doe, John Jr._1234569{FILE}_"},
    "1234570": {"log_file": "lab_1.csv"},
    "1234571": {"name": "Participant 1234571"},
    "1234572": {"log_file": "my_lab.csv", "feedback_stem": f"שרה כהן_1234572{FILE}_my_lab"},
    "88": {"ids": {"moodle": "88", "folder": f"Lab group 3_88{FILE}"}},
}

BLACKBOARD = {
    STEM.format("j_doe", 9) + ".txt": RECEIPT.format("Jane (Doe)", "j_doe"),
    STEM.format("j_doe", 9) + "_lab.csv": LOG,
    STEM.format("j_doe", 11) + ".txt": RECEIPT.format("Jane (Doe)", "j_doe"),
    STEM.format("j_doe", 11) + "_my_lab.csv": LOG,
    STEM.format("bob", 10) + ".txt": "Name: Mallory (j_doe)\nan odd receipt\n",
    STEM.format("bob", 10) + "_lab.csv": LOG,
    STEM.format("k_im", 10) + "_lab(1).csv": LOG,
    STEM.format("zoe", 10) + ".txt": RECEIPT.format("Zoë Ö", "zoe"),
}
IN_BLACKBOARD: dict[str, Person] = {
    "bob": {"name": "bob"},  # a receipt in another's name is not believed
    "j_doe": {
        "name": "Jane (Doe)", "ids": {"username": "j_doe"}, "submitted": "2026-03-11T14:05:59", "attempt": 2,
        "log_file": "my_lab.csv",
    },
    "k_im": {},
    "zoe": {"name": "Zoë Ö", "problem": "no files"},
}  # fmt: skip

OUTER = "assignment_42_export"
GRADESCOPE = {
    f"{OUTER}/submission_metadata.yml": EXPORT,
    f"{OUTER}/submission_102/submission_metadata.yml": EXPORT.replace("Zo", "Mallory"),
    **{f"{OUTER}/submission_{number}/lab.csv": LOG for number in (101, 102, 103, 104)},
}
IN_GRADESCOPE: dict[str, Person] = {
    "0012": {
        "name": "Jane Doe", "submitted": "2026-03-09T14:05:59-08:00", "late_seconds": None,
        "ids": {"gradescope": "101", "sid": "0012", "email": "jane@uni.example", "folder": "submission_101"},
    },
    "104": {"submitted": None},
    "bob@uni.example+s7": {
        "name": "Bob O'Neil: =1+1, Zoë \"Z\" O'Neil", "members_of_group": ("bob@uni.example", "s7"),
        "feedback_stem": "submission_102",
    },
    "李雷": {},
}  # fmt: skip

AUTOGRADER = {
    "submission_metadata.json": LIVE, "submission/lab.csv": LOG, "source/setup.sh": "x", "results/stdout": "",
}  # fmt: skip
IN_AUTOGRADER: dict[str, Person] = {
    "jane@uni.example": {
        "name": "Jane Doe", "submitted": "2026-03-10T01:00:00-08:00", "late": True, "late_seconds": 7200.365935,
        "attempt": 2,  # an attempt that failed on the platform's side does not count
    }
}  # fmt: skip


CLASSES: dict[str, tuple[str, Mapping[str, str], dict[str, Person], list[str]]] = {
    "a folder for each": ("folder", FOLDERS, IN_FOLDERS, ["G707"]),
    "a file for each": ("folder", FLAT, IN_FLAT, ["G707", "G708"]),
    "one folder around": ("folder", {"lab 3/ann/lab.csv": LOG, "lab 3/bob/lab.csv": LOG}, {"ann": {}, "bob": {}}, []),
    "Canvas": ("canvas", CANVAS, IN_CANVAS, ["G708"]),
    "Moodle": ("moodle", MOODLE, IN_MOODLE, []),
    "Blackboard": ("blackboard", BLACKBOARD, IN_BLACKBOARD, ["G708"]),
    "Gradescope": ("gradescope", GRADESCOPE, IN_GRADESCOPE, []),
    "Gradescope, running": ("gradescope", AUTOGRADER, IN_AUTOGRADER, []),
}
"""The platform that is recognised, files, what is known of each student, and the codes of what is told."""


@pytest.mark.parametrize(
    ("name", "make"), [*((name, make_folder) for name in CLASSES), *((name, make_zip) for name in list(CLASSES)[:-1])]
)  # An autograder runs in a folder only.
def test_files_of_a_platform_are_given_to_their_students(name: str, make, tmp_path: Path) -> None:
    lms, files, people, codes = CLASSES[name]
    found = find_submissions(make(tmp_path / "class.zip", files))
    assert (found.lms, [one.code for one in found.diagnostics]) == (lms, codes)
    assert [one.student for one in found.items] == list(people)
    assert {one.student: {key: getattr(one, key) for key in people[one.student]} for one in found.items} == people
    assert [one.student for one in found.items if one.problem is None and LOG.encode() not in one.log()] == []


def one_of(tmp_path: Path, files: Mapping[str, str], **options: str) -> Submission:
    return find_submissions(make_folder(tmp_path / "class", files), **options).items[0]  # type: ignore[arg-type]


def test_oldest_attempt_is_taken_where_that_is_asked_for(tmp_path: Path) -> None:
    jane = {name: data for name, data in BLACKBOARD.items() if "j_doe" in name}
    oldest = one_of(tmp_path, jane, attempts="oldest")
    assert (oldest.submitted, oldest.attempt, oldest.log_file) == ("2026-03-09T14:05:59", 1, "lab.csv")


PACKED = "is an archive within the submission and is not opened; unpack it"


@pytest.mark.parametrize(
    ("files", "log", "problem"),
    [
        ({"lab.csv": LOG, "notes.txt": "x"}, "lab.csv", None),
        ({"lab.xlsx": "x", "lab.tsv": LOG}, "lab.tsv", None),
        ({"data.csv": LOG, "fit.csv": "slope,u\n1,2\n"}, "data.csv", None),
        ({"lab (2).csv": LOG, "lab (1).csv": "", "lab.csv": ""}, "lab (2).csv", None),
        ({"a.csv": LOG, "b.csv": LOG + "\n"}, None, "several files that read as logs: a.csv, b.csv"),
        ({"lab.csv": ""}, None, "lab.csv is empty"),
        ({"lab.zip": "PK"}, None, f"no log: lab.zip {PACKED}"),
        ({"a.png": "", "b.docx": ""}, None, "no log: only a.png, b.docx"),
    ],
)
def test_log_among_several_files_is_found_or_its_lack_told(
    files: dict[str, str], log: str | None, problem: str | None, tmp_path: Path
) -> None:
    one = one_of(tmp_path, {f"ann/{name}": content for name, content in files.items()}, lms="folder")
    assert (one.log_name, one.problem) == (log and f"ann/{log}", problem)


def test_pattern_of_ones_own_names_student_attempt_and_lateness(tmp_path: Path) -> None:
    names = ["week3-jdoe-try1.csv", "week3-jdoe-try2.csv", "week3-kim-try1-late.csv", "other.csv"]
    pattern = r"week3-(?P<student>\w+)-try(?P<attempt>\d+)(?P<late>-late)?\.csv"
    found = find_submissions(make_folder(tmp_path / "class", dict.fromkeys(names, LOG)), pattern=pattern)
    assert [(one.student, one.attempt, one.late) for one in found.items] == [("jdoe", 2, False), ("kim", 1, True)]
    assert (found.lms, [one.code for one in found.diagnostics]) == ("pattern", ["G707", "G708"])


@pytest.mark.parametrize(
    ("file", "feedback"),
    [
        ("doejane_LATE_9876_55501_lab.csv", "doejane_LATE_9876_55501_lab.html"),
        ("Zoë Ö_12_assignsubmission_file_/sub/lab.csv", "Zoë Ö_12_assignsubmission_file_/feedback.html"),
        (STEM.format("jdoe", 9) + "_lab.csv", STEM.format("jdoe", 9) + "_lab.html"),
        ("submission_7/lab.csv", "submission_7/feedback.html"),
        ("jdoe.csv", "jdoe/feedback.html"),
    ],
)
def test_feedback_has_the_name_that_the_platform_takes_back(file: str, feedback: str, tmp_path: Path) -> None:
    assert one_of(tmp_path, {file: LOG}).feedback_name(".html") == feedback
