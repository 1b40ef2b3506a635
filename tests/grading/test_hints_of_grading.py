"""Hints of the commands and of a class are promises: each is carried out as it is
written, and what comes out is right.

A class of three is graded; ann and bob made no mistake, and cat misspelt a key of her
log."""

from __future__ import annotations

import csv
import io
import itertools
import json
import re
import shlex
import subprocess
import sys
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from classes.class_cells import gyro
from cli.test_options_hints import CARRIED_OUT as OF_A_LOG
from cli.test_options_hints import LOG, TRUTH, WITHOUT_TURNS, log
from grading.classes import make_folder, packed
from grading.students_reports import a_log
from grading.test_fair_grades import CARRIED_OUT as OF_A_CLASS
from places import DATA, SAMPLES
from typer.testing import Result

import gyrodata
from gyrodata.base.diagnostics import explanations
from gyrodata.base.disk import alone_in
from gyrodata.base.errors import InputError
from gyrodata.grading.rubric import read_rubric
from gyrodata.grading.submissions.answers import read_answers
from gyrodata.readings import read_log


def hint_of(done: Result, code: str) -> str:
    """Give what is below the first message of a code."""
    lines = iter(done.stderr.splitlines())
    assert any(
        re.search(rf"\b{explanations()[code].severity} {code}: ", line)
        for line in lines
    ), done.stderr
    return "\n".join(
        line.strip()
        for line in itertools.takewhile(lambda one: one.startswith("   "), lines)
    )


def found(pattern: str, text: str) -> str:
    match = re.search(pattern, text)
    assert match, (pattern, text)
    return match[1] if match.re.groups else match[0]


TABLE = DATA / "hints_of_grading.toml"
HINTS = tomllib.loads(TABLE.read_text(encoding="utf-8"))


def test_the_hint_of_every_code_is_followed() -> None:
    here = set(
        re.findall(
            r'"(G[567]\d\d)"',
            Path(__file__).read_text("utf-8") + TABLE.read_text("utf-8"),
        )
    )
    assert OF_A_LOG | OF_A_CLASS | here == {
        code for code in explanations() if code[1] in "567"
    }
    assert all(explanations()[code].remedy for code in here)


# --- options of a command ---

SAMPLE = SAMPLES / "air_gyroscope.csv"


@pytest.fixture
def lab(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with logs of a known truth."""
    monkeypatch.chdir(tmp_path)
    return make_folder(
        tmp_path, {"log.csv": LOG, "again.csv": LOG, "short.csv": WITHOUT_TURNS}
    )


def assert_fine(words: list[str]) -> None:
    """See that a command is done, and that a log gives its own truth, where it has
    weights and times.
    """
    done = gyro(*words)
    assert (done.exit_code, done.stderr) == (0, "")
    if words[0] == "simulate" and "0g" not in words:
        inertia = gyrodata.analyze(done.stdout.encode()).inertia
        assert abs(inertia.value - 4.44e-3) < 4 * (inertia.u or 0.0)
    if {"json", "ndjson"} & set(words):
        for line in done.stdout.splitlines() if "ndjson" in words else [done.stdout]:
            inertia = json.loads(line)["result"]["inertia"]
            assert abs(inertia["value"] - TRUTH) < 4 * inertia["u"]


@pytest.mark.slow
@pytest.mark.parametrize(("code", "typed", "says", "mended"), HINTS["commands"])
def test_a_command_mended_by_a_person(
    code: str,
    typed: str,
    says: str,
    mended: str,
    lab: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(
        "gyrodata.cli.analyze_command.states", lambda path: iter([True])
    )
    """A + adds to what was typed."""
    typed, mended = (words.replace("SAMPLE", str(SAMPLE)) for words in (typed, mended))
    done = gyro(*shlex.split(typed))
    assert (done.exit_code, done.stdout) == (2, "")
    assert says in hint_of(done, code)
    assert_fine(shlex.split(mended if mended[0] != "+" else typed + mended[1:]))


def test_a_hand_in_is_read_as_it_is(lab: Path) -> None:
    """`test_hand_in` follows the other hints of "G719"."""
    (lab / "mine.csv").write_text(log(), encoding="utf-8")
    assert "leave these out" in hint_of(
        gyro("check", "mine.csv", "--hand-in", "--set", "g=9.8 m/s^2"), "G608"
    )
    line = found(
        r"with your value: (# .+)", gyro("check", "mine.csv", "--hand-in").stdout
    )
    (lab / "mine.csv").write_text(
        f"# g: 9.8 m/s^2\n{line}\n{log(top='')}", encoding="utf-8"
    )
    done = gyro("check", "mine.csv", "--hand-in")
    assert (done.exit_code, "G718" in done.stdout) == (0, True)


@pytest.mark.slow
def test_a_folder_in_use_or_another_one(lab: Path) -> None:
    words = ("analyze", str(SAMPLE), "--out")
    with alone_in(lab / "new"):
        assert "or choose another folder with --out" in hint_of(
            gyro(*words, "new"), "G609"
        )
        assert gyro(*words, "other").exit_code == 0
    assert gyro(*words, "new").exit_code == 0


@pytest.mark.slow
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no full device here")
def test_a_stream_that_cannot_be_used(lab: Path) -> None:
    def shell(line: str) -> str:
        line = f'gyro() {{ "{sys.executable}" -m gyrodata "$@"; }}\n{line}'
        return subprocess.run(
            ["bash", "-c", line], capture_output=True, text=True, check=False
        ).stdout

    full, closed = (
        shell("gyro --version 2>&1 > /dev/full; echo $?"),
        shell("gyro check - 2>&1 <&-; echo $?"),
    )
    assert "write to another file" in full
    for code, told in (("G606", full), ("G103", closed)):
        assert (code in told, told[-2:]) == (True, "2\n")
        assert not re.search("Traceback|Exception ignored", told)


# --- a class ---


PEOPLE = {"ann": a_log(1), "bob": a_log(5), "cat": a_log(3, "# u_tme: 0.2 s")}
CLASS = {f"class/{name}/lab.csv": text for name, text in PEOPLE.items()}
POINTS = ["20.00", "20.00", "19.50"]
"""A misspelt key costs cat half a point."""
Files = Mapping[str, str | bytes | None]


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the class."""
    monkeypatch.chdir(tmp_path)
    return make_folder(tmp_path, CLASS)


def put(files: Files) -> None:
    """Write files; None takes one away."""
    make_folder(
        Path(), {name: data for name, data in files.items() if data is not None}
    )
    for name in (name for name, data in files.items() if data is None):
        Path(name).unlink()


def grade(words: str) -> tuple[Result, list[str]]:
    """Grade, and give the points; files are only written where a folder is named."""
    typed = shlex.split(words)
    folder = next(
        (typed[i + 1] for i, word in enumerate(typed) if word in ("-o", "--out")), ""
    )
    done = gyro(
        "grade",
        *typed,
        "--workers",
        "0",
        *(() if folder else ("-o", "grades", "--dry-run", "-f", "csv")),
    )
    table = Path(folder, "grades.csv")
    text = (
        table.read_text(encoding="utf-8") if folder and table.is_file() else done.stdout
    )
    rows = csv.DictReader(io.StringIO(text))
    return done, [
        row["total"]
        for row in rows
        if row.get("student", "points possible") != "points possible"
    ]


RUBRIC = """schema = 1
points = 10
[[criterion]]
id = "log"
check = "log"
points = 4
full = "warnings <= 0"
zero = "warnings >= 4"
[[criterion]]
id = "inertia"
check = "own_data"
points = 6
full = "d <= 0.3"
zero = "d >= 3"
"""


MORE = [
    ("G723", "RUBRIC", "", "write schema = 1", ""),
    ("G723", "", "[[late]]\ngrace = '1 h'", "--print-rubric", "[late]\ngrace = '1 h'"),
    (
        "G723",
        "",
        "[late.tier]\nuntil='1 h'\ndeduct=0",
        "--print-rubric",
        "[[late.tier]]\nuntil='1 h'\ndeduct=0",
    ),
    (
        "G723",
        "",
        "[bench]\nu_time = 0.3",
        "--print-rubric",
        "[bench]\nu_time = '0.3 s'",
    ),
]


@pytest.mark.parametrize(
    ("code", "part", "wrong", "says", "right"), [*HINTS["rubrics"], *MORE]
)
def test_a_rubric_mended_by_a_person(
    code: str, part: str, wrong: str, says: str, right: str
) -> None:
    part = RUBRIC if part == "RUBRIC" else part

    def text(new: str) -> bytes:
        return (RUBRIC.replace(part, new, 1) if part else f"{RUBRIC}{new}\n").encode()

    with pytest.raises(InputError) as caught:
        read_rubric(text(wrong))
    assert says in next(
        one.hint for one in caught.value.diagnostics if one.code == code
    )
    read_rubric(text(right or part))


# --- what is graded ---


ZIP = packed(CLASS)
CANVAS = {
    f"named/{student}_{i}_5432_lab.csv": text
    for i, (student, text) in enumerate(PEOPLE.items())
}
SCOPE = {
    "scope/submission_metadata.yml": "<html>",
    "scope/submission_1/lab.csv": PEOPLE["ann"],
}
METADATA = (
    "submission_1:\n  :submitters:\n  - :name: Ann Lee\n    :sid: ann\n    :email: "
    "a@uni.example\n"
)
DESK, BOB = "grades/desk.csv", ["20.00", "12.00", "19.50"]


def desk(lines: str) -> Files:
    return {DESK: f"student,what,value\n{lines}\n"}


TWELVE = desk("bob,total,12")

LATE = RUBRIC + '[late]\n[[late.exception]]\nstudent = "{}"\nextra = "2 days"\n'

CASES: list[Any] = [
    ("G701", "clas", {}, "check its name", "class", {}),
    (
        "G702",
        "c.zip",
        {"c.zip": ZIP[:-10]},
        "download it again",
        "c.zip",
        {"c.zip": ZIP},
    ),
    (
        "G703",
        "c.zip",
        {"c.zip": packed(CLASS | {"../evil.csv": "x"})},
        "take that file out",
        "c.zip",
        {"c.zip": ZIP},
    ),
    (
        "G705",
        "class --lms canvas",
        {},
        "canvas names files such as doejane_9876_5432_lab.csv",
        "named --lms canvas",
        CANVAS,
    ),
    (
        "G707",
        "named",
        CANVAS | {"named/notes.txt": "x"},
        "canvas names files such as doejane_9876_5432_lab.csv",
        "named",
        {"named/notes.txt": None},
    ),
    (
        "G708",
        "class",
        {"class/ann/lab-1.csv": PEOPLE["cat"]},
        "",
        "class",
        {"class/ann/lab-1.csv": None},
    ),
    (
        "G709",
        "scope",
        SCOPE,
        "students are named by their submission's number",
        "scope",
        {"scope/submission_metadata.yml": METADATA},
        POINTS[:1],
    ),
    (
        "G714",
        "c.zip",
        {"c.zip": packed(CLASS | {"class/ann/./lab.csv": PEOPLE["ann"]})},
        "take one of the two out",
        "c.zip",
        {"c.zip": ZIP},
    ),
    (
        "G744",
        "class --roster r.csv",
        {"r.csv": "mass [g]\n20\n"},
        "first line is student,name,section,station,partner",
        "class --roster r.csv",
        {"r.csv": "student,name,section,station,partner\nann,Ann,Mon,3,\n"},
    ),
    ("G744", "class --roster c.zip", {"c.zip": ZIP}, "give a gradebook", "class", {}),
    (
        "G745",
        "class --rubric r.toml",
        {"r.toml": LATE.format("anna")},
        "did you mean ann?",
        "class --rubric r.toml",
        {"r.toml": LATE.format("ann")},
        ["10.00", "10.00", "9.00"],
    ),
    (
        "G763",
        "class -o file",
        {"file": ""},
        "choose another folder with --out",
        "class -o new",
        {},
    ),
    ("G764", "", {}, "give the class, a folder or a zip", "class", {}),
    (
        "G765",
        "class --rubric rubirc.toml",
        {"rubric.toml": RUBRIC},
        "check its name",
        "class --rubric rubric.toml",
        {},
        ["10.00", "10.00", "9.00"],
    ),
    (
        "G766",
        "class -o class/g",
        {},
        "write next to it: --out class-grades",
        "class --out class-grades",
        {},
    ),
    (
        "G769",
        "class --cluster tcp://localhost:1",
        {},
        "as tcp://HOST:8786",
        "class",
        {},
    ),
    (
        "G771",
        "class",
        {DESK: "bob,total,12\n"},
        "first line is student,what,value,by,why",
        "class",
        {DESK: "student,what,value,by,why\nbob,total,12\n"},
        BOB,
    ),
    (
        "G771",
        "class",
        {"grades/desk.xlsx": "PK"},
        "the first line is",
        "class",
        {"grades/desk.xlsx": None},
    ),
    ("G772", "class", desk("bbo,total,12"), "did you mean bob?", "class", TWELVE, BOB),
    ("G773", "class", desk("bob,totl,12"), "did you mean total?", "class", TWELVE, BOB),
    (
        "G773",
        "class",
        desk("bob,total,-8"),
        "write bonus,-8",
        "class",
        desk("bob,bonus,-8"),
        BOB,
    ),
    (
        "G773",
        "class",
        desk("bob,bonus,inf"),
        "write the points to add",
        "class",
        TWELVE,
        BOB,
    ),
    *(
        ("G773", "class", desk(f"bob,total,12\n{line}"), hint, "class", TWELVE, BOB)
        for line, hint in (
            ("bob,bonus,1.3.2026", "write the points to add"),
            ("bob,bonus,2026", "write the points to add"),
            ("bob,hold,no", "leave the value empty"),
            ("Bob + bob,flag,cleared", "this student alone"),
        )
    ),
    (
        "G774",
        "class",
        desk("bob,total,12\nbob,total,13"),
        "remove the other",
        "class",
        TWELVE,
        BOB,
    ),
]
"""Code, words, files, what the hint says; and what a person makes of that: words,
files, and points unless `POINTS`."""


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES, ids=[f"{case[0]} {case[1]}" for case in CASES])
def test_a_class_mended_by_a_person(case: Any, home: Path) -> None:
    code, typed, files, says, mended, better, *points = case
    put({name: data for name, data in files.items() if data is not None})
    before = set(home.rglob("*"))
    done, _ = grade(typed)
    assert says in hint_of(done, code)
    assert done.exit_code < 2 or (set(home.rglob("*")), done.stdout) == (before, ""), (
        "nothing is written"
    )
    put(better)
    done, found = grade(mended)
    assert (done.exit_code, found) == (0, points[0] if points else POINTS), done.stderr
    assert code not in done.stderr


@pytest.mark.slow
def test_built_in_rubric_is_given_by_its_name(home: Path) -> None:
    put({"r.toml": gyro("grade", "--print-rubric", "simple").stdout})
    assert (
        grade("class --rubric simple")[1]
        == grade("class --rubric r.toml")[1]
        == ["13.00"] * 3
    )


def test_one_week_of_a_term_is_graded(
    home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("gyrodata.grading.submissions.archives.MOST_FILES", 10)
    put({f"all/week{n}/{name}": text for n in range(4) for name, text in CLASS.items()})
    assert "of one assignment" in hint_of(grade("all")[0], "G704")
    assert grade("all/week2/class")[1] == POINTS


def test_what_is_damaged_in_a_zip_costs_one_student(home: Path) -> None:
    """The hint of "G713" is followed with the zip of "G702"."""
    put({"c.zip": ZIP[:90] + bytes([ZIP[90] ^ 1]) + ZIP[91:]})
    done, points = grade("c.zip")
    assert (done.exit_code, points, "damaged in the zip" in done.stdout) == (
        1,
        ["", *POINTS[1:]],
        True,
    )


def test_an_answer_beside_the_log() -> None:
    note = found("(# I_zz.*)", explanations()["G717"].remedy)
    told = read_answers(None, [("report.txt", note[2:].encode())])
    written = read_answers(read_log(f"{note}\n{LOG}".encode()))
    for answers, codes in ((told, ["G717"]), (written, [])):
        assert answers.inertia
        assert (answers.inertia.value, [one.code for one in answers.diagnostics]) == (
            4.4e-3,
            codes,
        )


@pytest.mark.slow
def test_lost_lines_of_the_journal_are_graded_again(home: Path) -> None:
    grade("class -o grades")
    journal = home / "grades" / "journal.ndjson"
    journal.write_bytes(journal.read_bytes()[:-300] + b"\n[]\n7\n{}\n\0\0\n")
    done, points = grade("class -o grades")
    assert (
        "note G762: 5 lines of the journal cannot be read" in done.stderr,
        points,
    ) == (True, POINTS)
    assert explanations()["G762"].remedy.startswith("Do nothing: ")
    assert "G762" not in grade("class -o grades")[0].stderr


@pytest.mark.slow
def test_a_gradebook_needs_a_folder(home: Path) -> None:
    book = HINTS["books"]["canvas"]["book"].replace("Homework (111),", "")
    (home / "book.csv").write_text(book.replace("10.00,", ""), encoding="utf-8")
    words = ("grade", "class", "--format", "json", "--gradebook", "book.csv")
    assert hint_of(gyro(*words), "G767").startswith("add --out ")
    assert grade(f"{shlex.join(words[1:])} --out new")[1] == POINTS


def test_an_autograder(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    words = ("grade", "--gradescope", "autograder", "--rubric", "rubric.toml")
    printed = found(r"\(gyro (.*?) > rubric.toml", hint_of(gyro(*words[:3]), "G768"))
    text = gyro(*printed.split()).stdout
    put({"rubric.toml": text})
    lines = found(
        r': (\[reference.all\], .*"); or', hint_of(gyro(*words), "G768")
    ).split(", ")
    put({"rubric.toml": text.replace('[reference]\nfrom = "class"', "\n".join(lines))})
    with monkeypatch.context() as patch:
        # As from a folder of the sources alone.
        patch.setattr("importlib.metadata.Distribution.discover", lambda **_: iter(()))
        assert hint_of(gyro(*words), "G768").startswith(
            "install it with python3 -m pip install . in its folder"
        )
    assert not Path("autograder").exists()
    assert gyro(*words).exit_code == 0


BOOK = ("column", "book", "named", "faulty")
# --- gradebooks ---


@pytest.mark.slow
@pytest.mark.parametrize("lms", HINTS["books"])
def test_book_is_filled_once_its_hint_is_followed(lms: str, home: Path) -> None:
    column, text, named, faulty = (HINTS["books"][lms][key] for key in BOOK)
    words = "class -o new --gradebook book.csv"
    if not named:
        Path("class").rename("people")
        files = enumerate(PEOPLE.values(), 1)
        put({f"class/{i}_{i}_assignsubmission_file/lab.csv": log for i, log in files})

    def assert_filled(words: str, points: list[str]) -> None:
        done, graded = grade(words)
        assert (done.exit_code, graded) == (0, points), done.stderr
        rows = list(
            csv.reader(
                io.StringIO(Path("new", f"{lms}.csv").read_text(encoding="utf-8"))
            )
        )
        assert [row[column] for row in rows[-3:]] == points

    put({"book.csv": text})
    given = words
    if named:
        done, _ = grade(words)
        assert hint_of(done, "G753").startswith(
            "give the number after its title with --assignment"
        )
        given += f" --assignment {found(named, done.stderr)}"
    assert_filled(given, POINTS)
    for fault, code, says in faulty:
        put({"book.csv": fault})
        done, _ = grade(given)
        assert (done.exit_code, says in hint_of(done, code)) == (2, True)
    # The last had ten points.
    put({"rubric.toml": RUBRIC})
    assert_filled(f"{given} --rubric rubric.toml", ["10.00", "10.00", "9.00"])


@pytest.mark.slow
def test_a_figure_is_drawn_once_matplotlib_can_draw_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """To install matplotlib again is not carried out: only its fault is planted, and
    taken away.
    """
    (tmp_path / "log.csv").write_text(LOG, encoding="utf-8")
    words = ("analyze", tmp_path / "log.csv", "--out", tmp_path / "report")
    with monkeypatch.context() as damaged:
        damaged.setattr("matplotlib.figure.Figure.savefig", lambda *_, **__: 1 / 0)
        assert "pip install --force-reinstall matplotlib" in hint_of(
            gyro(*words), "G611"
        )
    assert "G611" not in gyro(*words).stderr
    assert (tmp_path / "report" / "torque.svg").is_file()
