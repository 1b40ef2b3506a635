"""What a person decides by hand, in ``desk.csv`` beside the grades: whether it is kept, and said.

The interface: columns ``student, what, value, by, why``; ``what`` is a criterion, ``total``, ``reported``, ``station``,
``partner``, ``comment``, ``hold`` or ``excuse``.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from grading.reports import reported_line
from msgspec import Struct

from classes.cost import grade_killed
from classes.drawn import Student, draw, with_rows
from classes.graded import Number, gyro, on_disk, rows_of
from classes.typed import Files
from gyrodata.grading import default_rubric_text

DESK, TABLE = "desk.csv", "grades.csv"
BY = "Ann"


class Edit(Struct, frozen=True):
    """One line of the desk, and how its effect is seen in the row of the table and the student of the document."""

    who: int
    what: str
    value: str
    why: str
    seen: Callable[[dict[str, str], dict[str, Any]], bool]

    @property
    def key(self) -> str:
        return str(1000 + self.who)


EDITS = (
    Edit(0, "inertia", "4.5", "worked out on paper", lambda row, _: row["inertia"] == "4.50"),
    Edit(1, "total", "12", "agreed in the office hour", lambda row, _: row["total"] == "12.00"),
    Edit(2, "reported", "4.44e-3 ± 0.05e-3 kg m^2", "stands in the PDF", lambda row, _: row["status"] == "graded"),
    Edit(3, "station", "7", "the label was wrong", lambda _, student: student["station"] == "7"),
    Edit(4, "partner", "1005", "one bench, two students", lambda row, _: not row["flags"]),
    Edit(6, "comment", "Read the ruler at eye level.", "seen in the lab", lambda row, student: True),
    Edit(7, "hold", "", "to be talked over", lambda row, _: row["total"] == ""),
    Edit(8, "excuse", "", "a doctor's note", lambda row, _: row["total"] == "" and "excuse" in str(row).lower()),
)
"""What is decided of a class of ten; the student after the fourth has the fourth's data, and the second no report."""


def students() -> list[Student]:
    class_of_ten = [draw(i, 10) for i in range(10)]
    class_of_ten[5] = with_rows(class_of_ten[4], class_of_ten[4].rows, 5)
    return class_of_ten


def a_class() -> Files:
    return {
        f"{one.stem}_lab.csv": one.log(*([] if one.number == 2 else [reported_line(*one.answer())]))
        for one in students()
    }


def desk_of(*lines: tuple[str, str, str, str, str]) -> str:
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows([("student", "what", "value", "by", "why"), *lines])
    return out.getvalue()


GIVEN = desk_of(*((edit.key, edit.what, edit.value, BY, edit.why) for edit in EDITS))


def run(root: Path, out: Path, *options: str | Path) -> None:
    done = gyro("grade", root, "--out", out, "--workers", "1", "--quiet", *options)
    if done.exit_code > 1:
        raise RuntimeError(done.output)


def other_rubric(out: Path, slip: int) -> Path:
    """Write a rubric that grades everybody anew, beside the folder of the grades."""
    path = out.parent / f"rubric{slip}.toml"
    path.write_text(default_rubric_text().replace('slip = "50 %"', f'slip = "{slip} %"'), encoding="utf-8")
    return path


def state(out: Path, resubmitted: str = "") -> dict[str, bool]:
    """Tell for each edit whether it holds and is said; a resubmission after it must be said too."""
    rows = rows_of(out / TABLE)
    document = json.loads((out / "grades.json").read_text(encoding="utf-8"))
    people = {student["student"]: student for student in document["students"]}
    feedback = {path.name: path.read_text(encoding="utf-8") for path in (out / "feedback").glob("*.md")}
    same = (out / DESK).read_text(encoding="utf-8") == GIVEN
    kept = {}
    for edit in EDITS:
        row, student = rows[edit.key], people[edit.key]
        own = "".join(text for name, text in feedback.items() if f"_{edit.key}_" in name)
        words = own + json.dumps(student, ensure_ascii=False) + str(row)
        told = edit.value in own if edit.what == "comment" else edit.why in words
        if edit.key == resubmitted:
            told = told and "resubmitted" in f"{row['look']} {student['look']}"
        kept[edit.what] = same and edit.seen(row, student) and told
    return kept


@cache
def events() -> dict[str, dict[str, bool]]:
    """What is left of the desk after all that happens to a class."""
    found = {}
    with on_disk(a_class()) as (root, out):
        run(root, out)
        (out / DESK).write_text(GIVEN, encoding="utf-8")
        run(root, out)
        found["first run"] = state(out)
        run(root, out)
        found["rerun"] = state(out)
        run(root, out, "--rubric", other_rubric(out, 40))
        found["other rubric"] = state(out)
        grade_killed(root, out, 3, "--rubric", other_rubric(out, 30))
        run(root, out, "--rubric", other_rubric(out, 30))
        found["kill"] = state(out)
        for path in root.iterdir():
            path.write_text("# again\n" + path.read_text(encoding="utf-8"), encoding="utf-8")
        run(root, out, "--rubric", other_rubric(out, 30))
        found["resubmission"] = state(out, resubmitted=EDITS[1].key)
    return found


def kept(event: str) -> Callable[[int, int], Number]:
    """Count the edits that hold and are said after an event."""

    def measure(size: int, seed: int) -> Number:
        found = events()
        lost = ", ".join(what for what, holds in found[event].items() if not holds)
        there = found["first run"]["total"]
        value = sum(found[event].values()) if there else None
        return Number(value, low=len(EDITS), of=len(EDITS), told=f"lost: {lost}" if there and lost else "")

    return measure


FAULTS = {
    "unknown student": (("9999", "total", "12", BY, "x"),),
    "unknown criterion": (("1000", "inertai", "4", BY, "x"),),
    "two that contradict": (("1001", "total", "12", BY, "x"), ("1001", "total", "13", BY, "x")),
    "value out of range": (("1000", "inertia", "60", BY, "x"),),
    "no number": (("1000", "total", "good", BY, "x"),),
}


def refused(size: int, seed: int) -> Number:
    """Count the desks with a fault that are told with file and line, and change nothing."""
    good = 0
    missed = []
    with on_disk(a_class()) as (root, out):
        run(root, out)
        for name, lines in FAULTS.items():
            (out / DESK).write_text(desk_of(("1003", "total", "11", BY, "good line"), *lines), encoding="utf-8")
            before = {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}
            done = gyro("grade", root, "--out", out, "--workers", "1", "--quiet")
            same = before == {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}
            told = DESK in done.stderr and any(f"{mark}{2 + len(lines)}" in done.stderr for mark in (":", "line "))
            if done.exit_code == 2 and same and told:
                good += 1
            else:
                missed.append(name)
    words = f"not: {', '.join(missed)}" if good and missed else ""
    return Number(good or None, low=len(FAULTS), of=len(FAULTS), told=words)


CELLS = {
    "kept after a rerun": kept("rerun"),
    "kept under another rubric": kept("other rubric"),
    "kept after a kill": kept("kill"),
    "kept after a resubmission": kept("resubmission"),
    "faults told, nothing changed": refused,
}
