"""Every other door at which something comes in or goes out: what is given to it, and what has to hold of it.

A door is a function of a seed. It gives what became of the input, "taken" or "refused"; it raises where something
does not hold, and lets any other fault of the tool through.
"""

from __future__ import annotations

import csv
import gzip
import io
import json
import os
import random
import re
import shlex
import tempfile
import warnings
import zipfile
from collections.abc import Callable, Iterable
from functools import lru_cache
from pathlib import Path
from typing import Any

import jsonschema
import openpyxl
import typer
from typer.testing import CliRunner

import gyrodata
from fuzz.grammar import JUNK, KEYS, draw_input
from gyrodata import reporting, schema
from gyrodata.cli import app
from gyrodata.errors import Diagnostic, GyroError
from gyrodata.grading import (
    ClassGrades,
    Decision,
    Flag,
    Grade,
    Mark,
    Roster,
    Rubric,
    Submission,
    Submissions,
    class_page,
    class_summary,
    default_rubric_text,
    feedback_html,
    feedback_markdown,
    fill_book,
    find_submissions,
    grade_submission,
    grades_csv,
    grades_document,
    read_desk,
    read_roster,
    read_rubric,
    read_sheet,
)
from gyrodata.readings import read_log, write_log

HOSTILE = (
    "\x1b[2J\x1b]0;x\x07", "\u202eDNA\u202c", "a\u2066b\u2069", "=1+1", "@SUM(A1)", "+1", "<script>alert(1)</script>",
    "\"><img src=x onerror=1>", "</title>", "\\input{/etc/passwd}", "$\\end{document}", "%", "#_^~&", "`x`", "| a | b",
    "[x](javascript:1)", "a\nb", "a\r\nb", "\x85\x9b31m", "\u2028", "\ud800", "Ёлка 山", "a" * 300, "", "'", '"',
    "::error::x", "{{ 7*7 }}", "\x7f", "\u200b", "e\u0301", "\x00",
)  # fmt: skip
NAMES = ("Jane Doe", "doejane", "Анна", "O'Neil, Kim", "jdoe", "Participant 7", *HOSTILE)

BARE = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")
"""What a terminal obeys, or what turns a line around."""


def clean(text: str) -> None:
    """See that a terminal can show a text."""
    found = BARE.search(text)
    assert found is None, f"{found[0]!r} in {text[max(0, found.start() - 40) : found.end() + 20]!r}"


def refused(error: GyroError) -> str:
    """See that a refusal is in words, which a terminal can show."""
    assert any(found.severity == "error" and found.message for found in error.diagnostics)
    clean(str(error))
    return "refused"


def mutated(rng: random.Random, text: str, delimiters: str = ",;\t") -> bytes:
    """Do to a text what editors and tired hands do, and what nobody would."""
    for _ in range(rng.choice((0, 1, 1, 2, 3, 6))):
        lines = text.split("\n")
        at = rng.randrange(len(lines))
        line, junk = lines[at], rng.choice((*JUNK, *HOSTILE))
        kind = rng.randrange(9)
        if kind == 0:
            cells = re.split(f"([{delimiters}])", line)
            cells[rng.randrange(0, len(cells), 2)] = junk
            lines[at] = "".join(cells)
        elif kind == 1:
            lines.insert(at, rng.choice((junk, lines[rng.randrange(len(lines))])))
        elif kind == 2:
            del lines[at]
        elif kind == 3:
            cut = rng.randrange(len(line) + 1)
            lines[at] = line[:cut] + junk + line[cut + rng.randrange(3) :]
        elif kind == 4:
            lines[at] = line[: rng.randrange(len(line) + 1)]
        elif kind == 5:
            tokens = re.findall(r"\w+|\W", line) or [""]
            one, other = rng.randrange(len(tokens)), rng.randrange(len(tokens))
            tokens[one], tokens[other] = tokens[other], tokens[one]
            lines[at] = "".join(tokens)
        elif kind == 6:
            lines[at] = re.sub(r"-?\d+(\.\d+)?", lambda _: rng.choice(("0", "-1", "1e9", "nan", "1e400", "7")), line)
        elif kind == 7:
            lines[at], other = lines[rng.randrange(len(lines))], line
        else:
            lines[at] = line.replace('"', "", 1) if '"' in line else f'"{line}'
        text = "\n".join(lines) or " "
    if rng.random() < 0.2:
        text = text.replace("\n", rng.choice(("\r\n", "\r")))
    data = text.encode(
        rng.choice(("utf-8",) * 6 + ("utf-8-sig", "utf-16", "utf-16-le", "cp1251", "latin-1")), "replace"
    )
    return damaged(rng, data) if rng.random() < 0.1 else data


def damaged(rng: random.Random, data: bytes) -> bytes:
    """Change, drop or add a few bytes."""
    spoiled = bytearray(data)
    for _ in range(rng.randrange(1, 6)):
        at = rng.randrange(len(spoiled) + 1)
        kind = rng.randrange(3)
        if kind == 0 and at < len(spoiled):
            spoiled[at] = rng.randrange(256)
        elif kind == 1:
            del spoiled[at : at + rng.choice((1, 4, 100))]
        else:
            spoiled[at:at] = rng.randbytes(rng.choice((1, 4)))
    return bytes(spoiled)


# --- the reader ---------------------------------------------------------------------------------------------


def reader(seed: int) -> str:
    """A log, as text or packed: read twice it is the same, and what is written of it is read without an error."""
    rng = random.Random(seed)
    data = draw_input(seed)[0]
    if rng.random() < 0.1:
        data = damaged(rng, gzip.compress(data)) if rng.random() < 0.7 else gzip.compress(data)
    elif rng.random() < 0.06:
        book = openpyxl.Workbook()
        for row in csv.reader(data.decode("utf-8", "replace").splitlines()):
            book.active.append([re.sub(r"[\x00-\x1f]", "", cell) for cell in row])
        out = io.BytesIO()
        book.save(out)
        data = damaged(rng, out.getvalue()) if rng.random() < 0.7 else out.getvalue()
    return try_reader(data)


def try_reader(data: bytes) -> str:
    """Read a log twice, write it, and read that."""
    try:
        readings = read_log(data)
        again = read_log(data)
    except GyroError as error:
        return refused(error)
    for found in readings.diagnostics:
        clean(str(found))
    assert list(map(str, readings.diagnostics)) == list(map(str, again.diagnostics))
    if not readings.ok:
        return "refused"
    text = write_log(readings)
    assert text == write_log(again)
    # What the tool has written itself it takes.
    told = [str(one) for one in read_log(text.encode()).diagnostics if one.severity == "error"]
    assert not told, told
    return "taken"


# --- grades, and what is written of them --------------------------------------------------------------------


@lru_cache(maxsize=8)
def rubric_of(kind: str) -> Rubric:
    """Give a rubric that comes with the tool."""
    return read_rubric(default_rubric_text(kind).encode(), "rubric.toml")  # type: ignore[arg-type]


@lru_cache(maxsize=1)
def true_grades() -> tuple[Grade, ...]:
    """Grade the sample class."""
    found = find_submissions(Path(__file__).parents[2] / "sample_data" / "class")
    return tuple(grade_submission(item, rubric_of("full")) for item in found.items)


def hostile_grade(rng: random.Random, number: int) -> Grade:
    """Make a grade whose texts are somebody else's."""
    grade = rng.choice(true_grades())
    marks = tuple(
        Mark(one.criterion, text(rng, one.title), one.check, one.points, one.out_of, text(rng, one.reason), one.detail,
             text(rng, one.rule)) for one in grade.marks
    )  # fmt: skip
    told = tuple(
        {**one, "message": text(rng, one["message"]), "hint": text(rng, one["hint"])} for one in grade.diagnostics
    )
    hands = (Decision("comment", text(rng, "well"), text(rng, "Ann"), text(rng, "why")),) if rng.random() < 0.3 else ()
    fields = {name: getattr(grade, name) for name in grade.__struct_fields__}
    return Grade(**fields | {
        "student": f"{number}{text(rng, 's')}", "name": text(rng, "Jane"), "marks": marks, "diagnostics": told,
        "why": None if grade.why is None else text(rng, grade.why), "look": (text(rng, "look"),), "by_hand": hands,
        "late_reason": text(rng, "late"), "section": text(rng, "A"), "title": text(rng, "Lab"),
        "station": text(rng, "3"),
        "reported": {**grade.reported, "text": text(rng, "4.4e-3")} if grade.reported else grade.reported,
    })  # fmt: skip


def text(rng: random.Random, usual: str) -> str:
    """Give what is usual, or what somebody hopes will be taken for more than a text."""
    return usual if rng.random() < 0.6 else rng.choice((rng.choice(HOSTILE), usual + rng.choice(HOSTILE)))


@lru_cache(maxsize=4)
def validator(kind: str) -> Any:
    """Give what holds a document against its schema."""
    return jsonschema.Draft202012Validator(getattr(schema, f"{kind}_schema")())


FOREIGN = re.compile(r"<(?:script|img|iframe|object|svg)\b[^>]*(?:src|onerror|onload|href)\s*=", re.IGNORECASE)


def writers(seed: int) -> str:
    """Grades and reports with the texts of others in them: tables, pages, feedback, JSON by its schema."""
    rng = random.Random(seed)
    if seed % 20 == 0:
        return reports(rng)
    grades = tuple(hostile_grade(rng, number) for number in range(rng.randrange(1, 4)))
    flag = Flag("shared rows", (grades[0].student,), text(rng, "7 of 9"), 1e-9, 1e-8, (text(rng, "old"),))
    items = tuple(
        Submission(one.student, one.name, {"canvas": text(rng, "9")}, Path("class"), feedback_stem=text(rng, "x"))
        for one in grades
    )
    told = (Diagnostic.of("G704", text(rng, "left out"), text(rng, "hint"), text(rng, "f")),)
    found = ClassGrades(
        text(rng, "class"), Submissions("canvas", items, told), rubric_of("full"), grades, {}, (flag,), {}, {},
        roster=Roster({}, ()),
    )  # fmt: skip
    clean("".join(class_summary(found)))
    table = grades_csv(grades, (flag,))
    clean(table)
    rows = list(csv.reader(io.StringIO(table)))
    assert {len(row) for row in rows} == {len(rows[0])}
    assert not any(cell[:1] in tuple("=+@\t\r") for row in rows for cell in row)
    document = json.loads("".join(grades_document(found)))
    validator("grades").validate(document)
    grade = grades[0]
    page = feedback_html(grade)
    clean(page.replace("\t", " "))
    assert not FOREIGN.search(page)
    clean(feedback_markdown(grade))
    if seed % 4 == 0:
        whole = class_page(found, lambda _: "x", (), {})
        assert not FOREIGN.search(whole)
    return "taken"


def reports(rng: random.Random) -> str:
    """Analyse a log with notes of others, and write its report in every form."""
    notes = [text(rng, "good").replace("\n", " ").replace("\r", " ") for _ in range(9)]
    rows = [f'{mass},15.0,{spin},{13.06 * spin / 406:.2f},{turns},"{notes.pop().replace(chr(34), "")}"'
            for mass, turns in ((20, "1/3"), (40, "2/3"), (60, "1")) for spin in (206, 406, 611)]  # fmt: skip
    head = [f"# {text(rng, 'experimenter')}: {text(rng, 'Ann')}".replace("\n", " "), f"# station: {text(rng, '3')}"]
    data = "\n".join([*head, "mass [g],position [cm],spin [rpm],time [s],turns,note", *rows]).encode("utf-8", "replace")
    try:
        lab = gyrodata.analyze(data)
    except GyroError as error:
        return refused(error)
    for written in (
        reporting.summary(lab), reporting.runs_csv(lab), reporting.markdown_report(lab), reporting.latex_report(lab),
    ):  # fmt: skip
        clean(written)
    document = reporting.json_text(lab.to_dict())
    validator("analysis").validate(json.loads(document))
    return "taken"


# --- rubrics and what is decided by hand --------------------------------------------------------------------


@lru_cache(maxsize=4)
def short_rubric(kind: str) -> str:
    """Give a rubric without its remarks."""
    return "\n".join(line for line in default_rubric_text(kind).splitlines() if line and not line.startswith("#"))  # type: ignore[arg-type]


def rubric(seed: int) -> str:
    """A rubric with something wrong in it: read twice it is the same."""
    rng = random.Random(seed)
    data = mutated(rng, short_rubric(rng.choice(("simple", "full", "manual"))), "=,[]{}")
    try:
        read = read_rubric(data, "rubric.toml")
    except GyroError as error:
        return refused(error)
    assert read.digest == read_rubric(data, "rubric.toml").digest
    assert 0 <= read.points < float("inf")
    return "taken"


def desk(seed: int) -> str:
    """What a person decides: all of it holds or none, and points stay within those that can be had."""
    rng = random.Random(seed)
    grades = {grade.student: grade for grade in true_grades()}
    whats = (*(one.id for one in rubric_of("full").criteria), "total", "reported", "station", "partner", "flag")
    lines = ["student,what,value,by,why"]
    for _ in range(rng.randrange(1, 6)):
        value = rng.choice(
            ("1", "2.5", "", "4.4e-3 ± 0.1e-3 kg m^2", "cleared", rng.choice(sorted(grades)), *HOSTILE[3:5])
        )
        line = [rng.choice(sorted(grades)), rng.choice((*whats, "hold", "excuse")), value, "Ann", text(rng, "talked")]
        lines.append(",".join(f'"{cell.replace(chr(34), chr(34) * 2)}"' if "," in cell else cell for cell in line))
    data = mutated(rng, "\n".join(lines) + "\n")
    try:
        read = read_desk(data, {student.casefold(): {student} for student in grades}, rubric_of("full"))
    except GyroError as error:
        return refused(error)
    for student in read.lines:
        grade = read.applied(grades[student], {})
        assert grade.points is None or 0 <= grade.points <= grade.out_of
        clean(feedback_markdown(grade))
    return "taken"


# --- gradebooks and rosters ---------------------------------------------------------------------------------


def quoted(rng: random.Random, rows: Iterable[Iterable[str]]) -> str:
    """Write a table as one of those that platforms and spreadsheets write."""
    out = io.StringIO()
    quoting = rng.choice((csv.QUOTE_MINIMAL, csv.QUOTE_MINIMAL, csv.QUOTE_ALL, csv.QUOTE_NONNUMERIC))
    delimiter = rng.choice((",", ",", ",", ";", "\t"))
    csv.writer(out, delimiter=delimiter, quoting=quoting, lineterminator=rng.choice(("\n", "\r\n"))).writerows(rows)
    return out.getvalue()


def canvas_book(rng: random.Random) -> list[list[str]]:
    """Draw a gradebook of Canvas."""
    head = ["Student", "ID", "SIS User ID", "SIS Login ID", "Section", "Gyroscope (5511)", "Final Score"]
    rows = [head]
    if rng.random() < 0.3:
        rows.append(["", "", "", "", "", "Manual Posting", "(read only)"])
    rows.append(["    Points Possible", "", "", "", "", "20.0", "(read only)"])
    for number, grade in enumerate(true_grades()[: rng.randrange(1, 8)]):
        rows.append(
            [rng.choice(NAMES), grade.student, f"00{number}", f"u{number}", "A", rng.choice(("", "7", "EX")), "1"]
        )
    return rows


def moodle_book(rng: random.Random) -> list[list[str]]:
    """Draw a grading worksheet of Moodle."""
    head = ["Identifier", "Full name", "Email address", "Status", "Grade", "Maximum Grade", "Grade can be changed"]
    rows = [[*head, "Last modified (submission)", "Last modified (grade)", "Feedback comments"]]
    for grade in true_grades()[: rng.randrange(1, 8)]:
        row = [
            f"Participant {grade.student}",
            rng.choice(NAMES),
            "a@b.c",
            "Submitted",
            rng.choice(("", "7.00", "7,00")),
        ]
        rows.append([*row, "20.00", rng.choice(("Yes", "No")), "-", "-", rng.choice(("", "<p>so</p>"))])
    return rows


def blackboard_book(rng: random.Random) -> list[list[str]]:
    """Draw a gradebook of Blackboard."""
    head = ["Last Name", "First Name", "Username", "Student ID", "Last Access", "Availability"]
    rows = [[*head, "Gyroscope [Total Pts: 20 Score] |5511"]]
    rows += [
        [
            *(rng.choice(NAMES), "Kim", grade.student, "00123", "2026-03-09 14:05:59", "Yes"),
            rng.choice(("", "7.00", "Needs Grading(3.00)", "Exempt")),
        ]
        for grade in true_grades()[: rng.randrange(1, 8)]
    ]
    return rows


def gradebooks(seed: int) -> str:
    """A sheet of a platform: filled, it differs where it should alone; the same sheet as a roster."""
    rng = random.Random(seed)
    lms = rng.choice(("canvas", "moodle", "blackboard"))
    rows = {"canvas": canvas_book, "moodle": moodle_book, "blackboard": blackboard_book}[lms](rng)
    whole = quoted(rng, rows)
    data = mutated(rng, whole) if rng.random() < 0.7 else whole.encode("utf-8", "replace")
    if rng.random() < 0.03:
        data = workbook(rng, rows)
    grades = true_grades()
    items = tuple(Submission(one.student, one.name, {}, Path("class")) for one in grades)
    try:
        people = read_roster(data, "roster.csv", Submissions("folder", items))
        for person in people.people.values():
            assert person.student in {one.student for one in grades}
    except GyroError as error:
        refused(error)
    try:
        filled = fill_book(lms, data, "book.csv", grades, comments={one.student: text(rng, "Well.") for one in grades})
    except GyroError as error:
        return refused(error)
    before, after = (read_sheet(one, "book.csv").rows for one in (data, filled.data))
    assert [len(row) for row in before] == [len(row) for row in after]
    changed = {
        at
        for old, new in zip(before, after, strict=True)
        for at, pair in enumerate(zip(old, new, strict=True))
        if len(set(pair)) > 1
    }
    assert len(changed) <= 2, "only points and comments change"
    assert fill_book(lms, filled.data, "book.csv", grades).changed == (), "what is there is not filled again"
    return "taken"


def workbook(rng: random.Random, rows: list[list[str]]) -> bytes:
    """Save a table as a workbook, perhaps damaged."""
    book = openpyxl.Workbook()
    for row in rows:
        book.active.append([re.sub("[\x00-\x1f\ud800]", "", cell) for cell in row])
    out = io.BytesIO()
    book.save(out)
    return damaged(rng, out.getvalue()) if rng.random() < 0.5 else out.getvalue()


# --- zips ---------------------------------------------------------------------------------------------------

PATHS = (
    "doejane_{n}_5432_lab.csv", "Jane Doe_{n}_assignsubmission_file/lab.csv", "submission_{n}/lab.csv", "s{n}.csv",
    "Gyroscope lab_jdoe{n}_attempt_2026-03-09-14-05-59_lab.csv", "s{n}/report.md", "s{n}/lab.csv", "s{n}/answers.toml",
    "submission_metadata.yml", "../up{n}.csv", "/abs{n}.csv", "C:\\x{n}.csv", "a\\..\\b{n}.csv", "__MACOSX/._{n}",
    "s{n}/{h}", "{h}_{n}_7_lab.csv", "s{n}.zip", "s{n}/lab.csv.gz", "s{n}/lab.xlsx", "a/b/c/d/{n}.csv",
    "x" * 250 + "{n}.csv",
    "Gyroscope lab_jdoe{n}_attempt_2026-03-09-14-05-59.txt", "s{n}/", "_", "con{n}.csv", "LATE_anon_{n}_lab.csv",
)  # fmt: skip


def zips(seed: int) -> str:
    """The zip of a class: names, sizes, zips in zips, bytes that are damaged."""
    rng = random.Random(seed)
    data = packed(rng, rng.randrange(1, 6), 2)
    if rng.random() < 0.35:
        data = damaged(rng, data)
    with tempfile.NamedTemporaryFile(suffix=".zip") as file:
        file.write(data)
        file.flush()
        try:
            found = find_submissions(Path(file.name))
        except GyroError as error:
            return refused(error)
        for told in found.diagnostics:
            clean(str(told))
        assert len({item.student for item in found.items}) == len(found.items)
        for item in found.items:
            try:
                readings, answers = item.read()
            except GyroError as error:
                refused(error)
            except OSError:
                pass  # told as such by whoever grades
            else:
                assert readings.name
                list(map(str, answers.diagnostics))
            name = item.feedback_name(".html")
            assert ".." not in name.split("/")
            assert not name.startswith("/")
            assert "\x00" not in name
    return "taken"


METADATA = """:submission_1:
  :submitters:
  - :name: Jane
    :sid: '0012'
    :email: a@b.c
  :created_at: 2026-03-09 14:05:59.0 Z
"""


def packed(rng: random.Random, files: int, depth: int) -> bytes:
    """Zip a few files, some of them zips."""
    out = io.BytesIO()
    with (
        warnings.catch_warnings(),
        zipfile.ZipFile(out, "w", rng.choice((zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED))) as archive,
    ):
        warnings.simplefilter("ignore")
        for number in range(files):
            shape = rng.choice(PATHS[:9] if rng.random() < 0.6 else PATHS)
            name = shape.format(n=100 + number, h=rng.choice(HOSTILE).replace("\x00", "").replace("\ud800", "") or "x")
            if name.endswith(".zip") and depth:
                content = packed(rng, 2, depth - 1)
            elif name.endswith(".yml"):
                content = mutated(rng, METADATA)
            elif name.endswith(".toml"):
                content = mutated(rng, 'inertia = "4.4e-3 ± 0.1e-3 kg m^2"\n')
            elif name.endswith(".md"):
                content = mutated(rng, "# Lab\nI_zz = (4.40 ± 0.10) × 10⁻³ kg·m²\n")
            else:
                content = draw_input(rng.randrange(2**31))[0] if rng.random() < 0.3 else LOG
            entry = zipfile.ZipInfo(name)
            if rng.random() < 0.03:
                entry.external_attr = rng.choice((0o120777, 0o060644, 0o040755)) << 16
            archive.writestr(entry, content)
    return out.getvalue()


LOG = b"mass [g],position [cm],spin [rpm],time [s],turns\n20,15.0,406,13.06,1/3\n40,15.0,406,6.53,1/3\n"


# --- options of the command line ----------------------------------------------------------------------------

COMMANDS = ("analyze", "check", "simulate", "template", "predict", "grade", "schema", "explain")
NEVER = {"--watch", "--workers", "--install-completion", "--show-completion", "--help"}
"""Options that wait for ever, or start processes."""


@lru_cache(maxsize=1)
def known_options() -> dict[tuple[str, ...], list[Any]]:
    """List the parameters of each command and of the commands below it."""
    door = typer.main.get_command(app)
    found: dict[tuple[str, ...], list[Any]] = {}

    def look(names: tuple[str, ...], command: Any) -> None:
        below = getattr(command, "commands", None)
        if below is None:
            found[names] = [one for one in command.params if not NEVER.intersection(one.opts)]
            return
        for name in below:
            look((*names, name), below[name])

    for name in COMMANDS:
        look((name,), door.commands[name])  # type: ignore[attr-defined]
    return found


def value_of(rng: random.Random, parameter: Any) -> str:
    """Draw a value: one that is asked for, one of another option, or junk."""
    kind = rng.random()
    if kind < 0.3 and hasattr(parameter.type, "choices"):
        return str(rng.choice(list(parameter.type.choices)))
    if kind < 0.65:
        key = rng.choice(sorted(KEYS))
        return rng.choice((
            "log.csv", "class", "rubric.toml", "book.csv", "out", "-", "7", "0.5", "15cm", "20g,40g", "200,400rpm",
            "1/3", "4.44e-3 kg m^2", "42.5 deg", "3 s", f"{key}={rng.choice(KEYS[key])}", rng.choice(KEYS[key]), key,
            "mass=m", "all", "json", "steady", "0", "100000000000", "1:3", "2,,3", "1e-3..2e-3 kg m^2",
        ))  # fmt: skip
    return rng.choice((*JUNK, *HOSTILE)).replace("\x00", "")


def options(seed: int) -> str:
    """A line of the shell: an answer or words, an exit code that is promised, and nothing that a terminal obeys."""
    rng = random.Random(seed)
    names, parameters = rng.choice(sorted(known_options().items(), key=lambda one: one[0]))
    line = list(names)
    for parameter in rng.sample(parameters, min(len(parameters), rng.choice((0, 1, 1, 2, 3, 5)))):
        if parameter.param_type_name == "argument":
            line.append(value_of(rng, parameter))
            continue
        flag = rng.choice([*parameter.opts, *parameter.secondary_opts])
        flag = flag[:-1] if rng.random() < 0.02 else flag
        if getattr(parameter, "is_flag", False):
            line.append(flag)
        elif rng.random() < 0.9:
            line += [flag, value_of(rng, parameter)]
        else:
            line.append(f"{flag}={value_of(rng, parameter)}")
    if names == ("analyze",):
        line.append("--no-report")
    if names == ("grade",):
        line += ["--workers", "0"]
    if rng.random() < 0.5:
        line += [rng.choice(("log.csv", "class"))]
    line = [one.encode("utf-8", "replace").decode() for one in line]
    home = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            Path("log.csv").write_bytes(LOG)
            Path("class").mkdir()
            Path("class/ann.csv").write_bytes(LOG)
            Path("rubric.toml").write_text(short_rubric("simple"), encoding="utf-8")
            Path("book.csv").write_text("Student,ID,Lab (5)\n    Points Possible,,20\nAnn,ann,\n", encoding="utf-8")
            done = CliRunner().invoke(app, line, input=LOG.decode())
        finally:
            os.chdir(home)
    fault = done.exception
    said = shlex.join(line)
    if fault is not None and not isinstance(fault, SystemExit):
        raise AssertionError(f"gyro {said}: {type(fault).__name__}: {fault}") from fault
    assert done.exit_code in (0, 1, 2, 3), f"gyro {said}: exit code {done.exit_code}"
    assert "Traceback" not in done.output, said
    try:
        clean(done.output)
    except AssertionError as error:
        raise AssertionError(f"gyro {said}: {error}") from None
    return "taken" if done.exit_code < 2 else "refused"


DOORS: dict[str, Callable[[int], str]] = {
    door.__name__: door for door in (reader, writers, rubric, desk, gradebooks, zips, options)
}
"""All of them but the analysis, by name."""
