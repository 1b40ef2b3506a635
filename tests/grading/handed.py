"""Classes of files, sheets of grades and desks of every kind, as they come in: the golden text of what they become."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from grading.classes import LOG, make_folder, make_zip
from grading.test_exports import GRADE_CENTER, GRADEBOOK, WORKSHEET, a_grade
from msgspec.structs import replace

from gyrodata.errors import InputError
from gyrodata.grading import (
    Grade,
    default_rubric,
    fill_book,
    find_submissions,
    read_answers,
    read_desk,
)

OTHER = LOG + "60,15.0,406,4.4,1/3\n"
Files = dict[str, str | bytes]


def attempt(work: Callable[[], Iterator[str]]) -> Iterator[str]:
    """What is made of something, or why it is refused."""
    try:
        yield from list(work())
    except InputError as error:
        for one in error.diagnostics:
            yield f"refused {one.code} {one.file}:{one.line} {one.message} | {one.hint}"


# --- sheets -------------------------------------------------------------------------------------------------

CANVAS = (
    "Student,ID,SIS Login ID,Section,Gyro (7)\n    Points Possible,,,,{}\nDoe,1,jd,a,{}\nRoe,2,br,a,{}\nTest,9,,,\n"
)
SEMICOLONS = "Student;ID;Section;Gyro (7)\n    Points Possible;;;20,00\nDoe;1;a;{}\nRoe;2;a;{}\n"
MOODLE = (
    "Identifiant;Nom complet;Groupe;Note;Note maximale;Peut être modifiée;"
    "Modifiée (travail);Modifiée (note);Remarques\n"
    "Participant 1;Zoé Doe;{};{};{};{};-;-;{}\nParticipant 2;Bob Roe;{};{};{};{};-;-;{}\nFin;;;;;;;;\n"
)
TWO = (a_grade("1"), a_grade("2", (2.0, 6.0, 12.0)))


def books() -> Iterator[tuple[str, str, str | bytes, list[Grade], dict[str, Any]]]:
    """Sheets by platform, what is put into each, and the other options."""
    one, two = TWO
    waiting, so_far = a_grade("2", (2.0, None, None)), replace(two, status="so far")
    held = replace(two, status="on hold", points=None)
    for left, right in (
        ("", "-"),
        ("17.5", "20"),
        ('"17,50"', "3"),
        (" ex ", "N/A"),
        ("Exempted", "junk"),
        ("0", "-3"),
    ):
        for ours in (None, {}, {"1": {"17.50"}, "2": {"3.00"}}, {"1": None, "2": None}):
            yield f"canvas {left}|{right}, {ours}", "canvas", CANVAS.format("20", left, right), [*TWO], {"ours": ours}
    for most in ("20.00", "20,00", "20.004", "20.006", "1,020.00", "", "lots", "(read only)", "20 (read-only)"):
        text = CANVAS.format(f'"{most}"', "", "")
        yield f"canvas of {most}", "canvas", text, [*TWO], {"ids": {"1": {"canvas": "2"}}}
    wide = b"\xff\xfe" + CANVAS.format(20, "", "").replace(",", "\t").encode("utf-16-le")
    for other in (waiting, so_far, held, replace(two, points=0.0), replace(two, points=25.0)):
        sheet = CANVAS.format(20, "", "3")
        yield f"canvas, {other.status} {other.points}", "canvas", sheet, [one, other], {"ours": {"2": {"5.00"}}}
    yield "canvas with semicolons", "canvas", SEMICOLONS.format("", "17,50"), [*TWO], {}
    yield (
        "canvas with tabs, UTF-16",
        "canvas",
        wide,
        [*TWO],
        {},
    )
    yield "canvas, big-endian", "canvas", b"\xfe\xff" + CANVAS.format(20, "é", "").encode("utf-16-be"), [*TWO], {}
    remarks = CANVAS.format(20, "", "").replace("Roe", "Roe;;;;;;;;;;;;;;;;;;;;;;;;;")
    yield "canvas with semicolons in the fourth line", "canvas", remarks, [*TWO], {}
    logins = {"x": {"username": "JD"}, "y": {"email": "br", "sid": "1"}, "1": {"moodle": "1"}}
    yield "canvas, by login", "canvas", CANVAS.format(20, "", ""), [a_grade(name) for name in "xy1"], {"ids": logins}
    several = "Student,ID,Section,Gyro (7),Gyro (8),Quiz (9)\n    Points Possible,,,20,20,20\nDoe,1,a,,,\n"
    for wanted in (None, "7", " gyro (8) ", "gyro", "QUIZ", "10"):
        yield f"canvas, column {wanted}", "canvas", several, [one], {"assignment": wanted}
    for text in (
        "Student,ID,Gyro (7)\n",
        "Student,ID\nDoe,1\n",
        "LastName,FirstName,ID,Gyro (7)\n",
        "Student,Name\n",
        "",
    ):
        yield f"canvas: {text}", "canvas", text, [one], {}
    for bytes_ in (b"\x00", b"PK\x03\x04\x00", b" \n", b"\xff\xfeabc", b"Student,ID,\xff,Gyro (7)\nDoe,1,a,\n"):
        yield f"canvas: {bytes_!r}", "canvas", bytes_, [one], {}
    for column in ("11", "12", "13", "14", None):
        people = [a_grade(name) for name in ("jdoe", "0014", "zoe", "alee")]
        yield f"blackboard, column {column}", "blackboard", GRADE_CENTER, people, {"assignment": column}
    yield "blackboard as Canvas's", "blackboard", GRADEBOOK, [one], {}
    people = [a_grade(name) for name in ("101", "102", "103", "104", "105", "106")]
    comments = {"101": "One\n\nTwo <b>\nThree", "103": " x ", "105": "<p>", "106": "y"}
    yield "moodle", "moodle", WORKSHEET, people, {"comments": comments}
    yield "moodle again", "moodle", WORKSHEET, people, {"comments": {"105": "old", "104": "old"}, "ours": {}}
    most = WORKSHEET.replace("20.00", "18.00", 1)
    yield "moodle, other maxima", "moodle", most, [replace(one, out_of=18.0) for one in people], {}
    yield "moodle as Canvas's", "moodle", GRADEBOOK, [one], {}
    for cells in (
        ("", "", "20,00", "Oui", "", "", "", "20,00", "Oui", ""),
        ("A", "17,50", "20,00", "Oui", "<p>", "B", "3", "20,00", "Nein", "x"),
        ("Lab", "", "20", "Oui", "-", "lab", "", "20", "hayır", "-"),
        ("", "", "20", "Oui", "3 mars", "", "", "10", "Oui", "4 mars"),
        ("1", "5", "0", "Oui", "", "1", "5", "0", "Oui", ""),
        ("7", "", "20", "Oui", "", "7", "", "20", "Oui", "<p>a</p>"),
    ):
        yield f"moodle {cells}", "moodle", MOODLE.format(*cells), [*TWO], {"comments": {"1": "Bien", "2": "a"}}
    bare = "Identifiant;Nom complet;Note;Note maximale;Modifiable;Modifiée\nParticipant 1;Zoé;;20;Oui;\n"
    yield "moodle without comments", "moodle", bare, [one], {"comments": {"1": "Bien"}}
    group = [replace(one, name="LAB"), two]
    text = MOODLE.format("Lab", "", "20", "Oui", "", "lab", "", "20", "Oui", "")
    yield "moodle, a group", "moodle", text, group, {"ids": {"1": {"moodle": "2"}, "2": {"moodle": "2"}}}


def book_text(lms: str, data: str | bytes, grades: list[Grade], **options: Any) -> Iterator[str]:
    """Tell what becomes of a sheet."""
    given = data if isinstance(data, bytes) else data.encode()
    filled = fill_book(lms, given, "book.csv", grades, **options)
    yield repr(filled.data) if filled.data != given else "the sheet as it was"
    yield f"filled {filled.filled} changed {filled.changed} by hand {filled.by_hand}"
    yield from (f"skipped {student}: {why}" for student, why in filled.skipped)


# --- classes of files ---------------------------------------------------------------------------------------

STEM = "Lab_2_{}_attempt_2026-03-{:02d}-14-05-59"
YAML = """---
submission_7:
  :submitters:
  - :name: Zoe
    :sid: s2
  - :name: Ann
    :sid: ''
    :email: ann@x
  :created_at: 2026-03-09 14:05:59.1 -08:00
submission_8:
  :submitters: []
  :created_at: never
submission_9:
  :submitters:
  - :name: Zoe
    :sid: s2
  :created_at: 2026-03-09 14:05:59 Z
x: {}
"""
LIVE = {
    "id": 5, "created_at": "2026-03-10T12:00:00+00:00",
    "users": [
        {"name": "Ann", "sid": 17, "assignment": {"due_date": "2026-03-10T11:00:00+00:00"}},
        {"name": "Bob", "email": "b@x", "assignment": {"due_date": "2026-03-10T11:30:00+00:00"}},
    ],
    "assignment": {"due_date": "2026-03-09T11:00:00+00:00"},
    "previous_submissions": [{"autograder_error": True}, {"autograder_error": False}, {}],
}  # fmt: skip


def live(**changes: Any) -> Files:
    content = {key: value for key, value in (LIVE | changes).items() if value is not None}
    return {"submission_metadata.json": json.dumps(content), "submission/lab.csv": LOG}


def each(folder: str, *names: str) -> Files:
    return {f"{folder}/{name}": LOG if name.endswith((".csv", ".tsv")) else "x" for name in names}


CLASSES: Mapping[str, tuple[Files, dict[str, Any]]] = {
    "folders": (
        each("a", "lab.csv", "b.toml") | each("b", "x.txt", "y.md") | each("c", "p.png") | {"d/": "", "e.csv": LOG},
        {},
    ),
    "deep folders": (
        each("top/a", "in/lab.csv", "n.html") | each("top/b", "lab.csv.gz") | {"top/c/": "", "top/i.md": ""},
        {},
    ),
    "one folder": (each("top", "a.csv", "b.csv"), {}),
    "one student": (each("a", "part/lab.csv", "notes.txt"), {}),
    "flat": (
        {f"{name}.csv": LOG for name in ("ann", "bob (1)", "cy-1", "d_answers", "e.report", "f Report")}
        | {
            "ann_answers.toml": "",
            "bob.csv": "",
            "x.md": "",
            "y.json": "",
            "g.toml.txt": "",
            "h.csv.gz": "",
            ".i.csv": "",
        },
        {},
    ),
    "no logs": ({"a.pdf": "", "b/c.pdf": ""}, {}),
    "tables before texts": (
        each("a", "l.txt", "l.tsv") | each("b", "l.log", "m.dat") | each("c", "l.xlsx", "z.7z"),
        {},
    ),
    "again and again": (
        each("a", "lab.csv", "lab-1.csv", "lab-12.csv")
        | each("b", "lab (2).csv", "lab(3).csv", "Lab.csv")
        | each("c", "lab-1.csv", "other-2.csv")
        | each("d", "lab-1.csv", "lab(1).csv")
        | each("e", "lab-123.csv", "lab.csv"),
        {},
    ),
    "the first of them": (
        each("a", "lab.csv", "lab-1.csv", "lab-12.csv") | each("b", "lab (2).csv", "lab(3).csv"),
        {"attempts": "oldest"},
    ),
    "which reads as a log": (
        {
            "a/u.csv": LOG,
            "a/v.csv": OTHER,
            "b/u.csv": "x",
            "b/v.csv": LOG,
            "c/u.csv": "x",
            "c/v.csv": "y",
            "d/u.csv": "",
            "d/v.csv": LOG,
            "e/u.csv": LOG,
            "e/v.csv": LOG,
            "e/w.csv": "z",
            "f/u.csv": "",
        },
        {},
    ),
    "canvas": (
        {
            f"{name}.csv": LOG
            for name in (
                "doejane_1_11_lab",
                "doejane_1_12_lab-1",
                "roe_LATE_2_13_lab",
                "poe_late_3_14_x_y",
                "late_4_15_lab",
                "LATE_anon_Ab1_16_lab",
                "anon_Cd2_17_lab",
                "foo_6_18_7_19_lab",
            )
        }
        | {"roe_2_text.html": "<p>x", "kim_8_link.html": "", "kim_8_20_a.toml": "", "notes.txt": "", "a.b": ""},
        {},
    ),
    "canvas within": (
        {f"sub/{name}": LOG for name in ("doe_1_11_lab.csv", "doe_2_12_lab.csv", "doe_3_1.csv", "q.csv")},
        {},
    ),
    "half of canvas": ({"doe_1_11_lab.csv": LOG, "other.csv": LOG}, {}),
    "less than half": ({"doe_1_11_lab.csv": LOG, "other.csv": LOG, "third.csv": LOG}, {}),
    "less than half, asked for": ({"doe_1_11_lab.csv": LOG, "other.csv": LOG, "third.csv": LOG}, {"lms": "canvas"}),
    "none, asked for": ({"other.csv": LOG, "third.csv": LOG}, {"lms": "moodle"}),
    "no such platform": ({"other.csv": LOG}, {"lms": "modle"}),
    "moodle": (
        each("Ann_1_assignsubmission_file", "lab.csv", "more/n.txt")
        | each("Ann_1_assignsubmission_onlinetext", "o.html")
        | each("Ann_2_assignsubmission_file_", "lab.csv")
        | each("Participant_3_assignsubmission_file", "lab.csv")
        | {
            "Bob_4_assignsubmission_file_lab.csv": LOG,
            "Bob_4_assignsubmission_file_n.txt": "",
            "_5_assignsubmission_file_/lab.csv": LOG,
        },
        {},
    ),
    "blackboard": (
        {
            STEM.format("j_doe", 9) + ".txt": "Name: Jane (j_doe)\nx",
            STEM.format("j_doe", 9) + "_lab.csv": LOG,
            STEM.format("j_doe", 11) + "_my_lab.csv": OTHER,
            STEM.format("bob", 10) + ".txt": "Name: Eve (j_doe)\n",
            STEM.format("bob", 10) + "_lab.csv": LOG,
            STEM.format("kim", 10) + ".txt": "Nom:  Kim K (kim)  \r\n",
        },
        {},
    ),
    "blackboard, one": ({STEM.format("j_doe", 9) + "_lab.csv": LOG}, {}),
    "gradescope": (
        {
            "submission_metadata.yml": YAML,
            **each("submission_7", "lab.csv"),
            **each("submission_8", "lab.csv"),
            **each("submission_9", "lab.csv", "s.md"),
            **each("submission_10", "lab.csv"),
            "notes.txt": "",
        },
        {},
    ),
    "gradescope, no list": ({"submission_metadata.yml": "a: {}", **each("submission_7", "lab.csv")}, {}),
    "running": (live(), {}),
    "running, alone": (live(users=[{"name": "Ann"}], previous_submissions=None), {}),
    "running, early": (live(users=None, assignment={"due_date": "2026-03-11T11:00:00+00:00"}), {}),
    "running, no date": (live(users=[{"sid": "s1"}], assignment=None, created_at=None), {"lms": "gradescope"}),
    "pattern": (
        {"x/lab_ann_late.csv": LOG, "lab_bob.csv": LOG, "lab_bob_2.csv": OTHER, "q.csv": LOG},
        {"pattern": r"lab_(?P<student>[a-z]+)(?:_(?P<attempt>\d))?(?P<late>_late)?"},
    ),
    "pattern, more": (
        {"1 Ann 2026.csv": LOG, "2 Bob 2025.csv": LOG, "n.csv": LOG},
        {"pattern": r"(?P<student>\d) (?P<name>\w+) (?P<submitted>\d+)"},
    ),
    "pattern of nothing": ({"a.csv": LOG}, {"pattern": "(?P<student>zzz)"}),
    "pattern, broken": ({"a.csv": LOG}, {"pattern": "(?P<student>"}),
    "pattern without a student": ({"a.csv": LOG}, {"pattern": "a"}),
    "empty": ({"a/": ""}, {"lms": "canvas"}),
    "strewn": (
        {"a/lab.csv": LOG, "a/~$lab.csv": "", "a/.x/y.csv": "", "Thumbs.db": "", "b/desktop.ini": "", "b/l.csv": LOG},
        {},
    ),
}


def class_text(root: Path, options: Mapping[str, Any]) -> Iterator[str]:
    """Tell whose submissions a class holds."""
    found = find_submissions(root, **options)
    yield f"{found.lms} {found.aliases}"
    for one in found.items:
        told = {name: getattr(one, name) for name in one.__struct_fields__ if name != "source"}
        kept = (f"{name} {value!r}" for name, value in told.items() if value not in (None, (), {}, False, ""))
        yield f"{', '.join(kept)}, feedback {one.feedback_name('.md')}"
    yield from (f"told {one.code} {one.message} | {one.hint}" for one in found.diagnostics)


# --- desks, rosters, answers --------------------------------------------------------------------------------

STUDENTS = {"7": {"7"}, "doe, jane": {"7"}, "doejane": {"7"}, "8": {"8"}, "roe": {"8"}, "9": {"9"}}
HEAD = "student,what,value,by,why\n"
DESKS = (
    "", HEAD, f"{HEAD}7,total,,,\n7,hold,,,\n8,comment,,,\n8,log,,,\n",
    (f"{HEAD}7,total,12,Kim,late bus\n7,inertia,\"1,5\",,\n8,hold,,Kim,\nroe,excuse,ill,,flu\n"
     "9,comment,a,,\n9,comment,b,,\n"),
    (f"{HEAD}7,Total,20,,\n7,inertia,6,,\n7,inertia,6,Kim,\n8,station, Bench  B ,,\n"
     "8,partner,doejane,,\n8,partner,9,,\n"),
    f"{HEAD}7,total,20.01,,\n7,inertia,-0.5,,\n7,total,1.2.3,,\n8,reported,4.4e-3 kg m^2,,\n9,reported,4 apples,,\n",
    f"{HEAD}7,total,12,,\n\n8,total,0,,\n8,total,1,,\nDOEJANE,total,13,,\n9,partner,9,,\n9,partner,nobody,,\n",
    f"{HEAD}doejan,total,12,,\nzzzz,total,12,,\n7,totl,1,,\n7,xyz,1,,\n7,inertai,2,,\n",
    "student,what\n7,total\n", "a;b\n", "student;what;value\n7;total;3,5\n",
    "student\twhat\tvalue\twhy\n'8\ttotal\t'4\t'=x\n", 'student,what,value\n7,total,"1\n',
    b"student,what,value\n7,total,1\n8,\xff,2\n", HEAD + '7,comment,"two\nlines",,\n8,totl,3,,\n',
)  # fmt: skip
TEXTS = {
    "a.txt": "reported_inertia: 4.4e-3 ± 0.1e-3 kg m^2\n", "b.md": "x\ny\nI_zz = 4.4 ± 0.1 g m^2\n",
    "c.html": "<h1>Lab</h1><p>I_zz =<b> 4.4e-3</b>&nbsp;kg m^2<br>x</p>", "d.toml": 'inertia = "4.4e-3 kg m^2"\n',
    "e.txt": "I_zz = about 4\n", "f.txt": "nothing here\n", "g.txt": b"\x00\x01",
    "h.htm": "<table><tr><td>I_zz = 3 g m^2</td></tr>",
    "i.txt": "\n" * 1000 + "I_zz = 3 g m^2\n", "j.txt": "\n" * 999 + "I_zz = 3 g m^2\n",
    "k.txt": "I_zz = 3 g m^2\nI_zz = 4 g m^2\n",
}  # fmt: skip


def desk_text(data: bytes) -> Iterator[str]:
    """Tell what a desk decides."""
    desk = read_desk(data, STUDENTS, default_rubric())
    yield from (f"{student}: {line!r} {line}" for student, lines in desk.lines.items() for line in lines)
    yield f"left {sorted(desk.left)}, partners {[sorted(one) for one in desk.partners]}"
    asked = [(student, what) for student in "789" for what in ("total", "hold", "comment", "inertia")]
    yield " ".join(f"{student}/{what}" for student, what in asked if desk.decides(student, what))
    yield " ".join(f"{student}/{what}={desk.value(student, what)}" for student, what in asked)


def applied_text() -> Iterator[str]:
    """Tell what grades become by each desk that can be used, for the submission it was written for and another."""
    grades = [a_grade("7"), a_grade("8", (2.0, None, 3.0)), a_grade("9", look=("look here",), late_deduction=1.5)]
    names = ("inertia", "reference", "log")
    grades = [
        replace(one, marks=tuple(replace(mark, criterion=name) for mark, name in zip(one.marks, names, strict=True)))
        for one in grades
    ]
    for text in DESKS[3:5]:
        desk = read_desk(str(text).encode(), STUDENTS, default_rubric())
        for grade in grades:
            for seen in (desk.first_seen(grade, {}), dict.fromkeys(desk.first_seen(grade, {}), "another")):
                made = desk.applied(desk.with_station(grade), seen)
                points = [(mark.criterion, mark.points, mark.reason) for mark in made.marks]
                yield f"{made.student} {made.status} {made.points} {made.why} {made.station} {points}"
                yield f"  {made.late_deduction} {made.look} {made.by_hand} {made.digest == grade.digest}"


def sheets() -> Iterator[str]:
    """Every sheet of grades, filled."""
    for name, lms, data, grades, options in books():
        lines = attempt(lambda: book_text(lms, data, grades, **options))  # noqa: B023
        yield "".join(f"{line}\n" for line in (f"== {name!r}", *lines))


def classes(folder: Path) -> Iterator[str]:
    """Every class of files, as a folder and as a zip."""
    for at, (name, (files, options)) in enumerate(CLASSES.items()):
        found = []
        for make, root in ((make_folder, folder / f"{at}" / "class"), (make_zip, folder / f"{at}.zip")):
            made = make(root, files)
            lines = attempt(lambda: class_text(made, options))  # noqa: B023
            found.append([line.replace(made.name, "CLASS") for line in lines])
        zipped = ["as a zip:", *found[1]] if found[0] != found[1] else []
        yield "".join(f"{line}\n" for line in (f"== {name}", *found[0], *zipped))


def desks() -> Iterator[str]:
    """Every desk, and every text in which an answer may stand."""
    for data in DESKS:
        given = data if isinstance(data, bytes) else data.encode()
        yield "".join(f"{line}\n" for line in (f"== desk {data!r}", *attempt(lambda: desk_text(given))))  # noqa: B023
    yield "".join(f"{line}\n" for line in ("== desks applied", *applied_text()))
    for names in ([name] for name in TEXTS):
        reports = [
            (name, text if isinstance(text, bytes) else text.encode()) for name in names if (text := TEXTS[name])
        ]
        yield f"== text {names}\n{told_answers(reports)}\n"
    every = [(name, text.encode()) for name, text in TEXTS.items() if isinstance(text, str)]
    yield f"== all texts\n{told_answers(every)}\n{told_answers(every[:2])}\n{told_answers(every[1:3])}\n"


def told_answers(reports: list[tuple[str, bytes]]) -> str:
    found = read_answers(None, reports)
    told = [(one.code, one.message, one.hint) for one in found.diagnostics]
    one = found.inertia
    return f"{one and (one.text, one.value, one.u, one.line, one.problem)} {found.file} {told}"
