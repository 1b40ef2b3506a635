"""What is still allowed, counted or told, and what is just past it: a grade may not hang on who wrote < for ≤."""

from __future__ import annotations

import json
import os
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from grading.classes import LOG, make_folder, make_zip
from grading.students import Course, Row, honest_class, prints_of
from grading.test_class_page import GOOD, a_class, page_of, tables_of
from grading.test_exports import a_grade, fill_gradebook, rows_of
from msgspec.structs import replace

from gyrodata.errors import InputError
from gyrodata.grading import (
    ClassGrades,
    Flag,
    GradingOptions,
    Slip,
    class_summary,
    find_submissions,
    flag_class,
    judge_lateness,
    read_rubric,
    read_sheet,
    results_json,
    settle,
    write_feedback,
    write_results,
)
from gyrodata.grading.classroom import share_of
from gyrodata.grading.journal import basis_of

CLASS = honest_class(np.random.default_rng(1), Course(), 30)
BY_HAND = """schema = 1
points = 20
criterion = [
  { id = "c0", check = "manual", points = 2 },
  { id = "c1", check = "manual", points = 6 },
  { id = "c2", check = "manual", points = 12 },
]
"""


# --- the class ----------------------------------------------------------------------------------------------


def slip(kind: str) -> Slip:
    return Slip(kind, f"{kind} it is", "look", 1.0, "recommended", None, 0.1)


def test_slips_are_told_the_commonest_first_and_by_name_where_as_many_made_them() -> None:
    made = {"a": "wide", "b": "odd", "c": "wide", "d": "near", "e": "mild"}
    found = a_class([replace(GOOD, student=student, slips=(slip(kind),)) for student, kind in made.items()])
    assert list(found.slips.items()) == [("wide", ["a", "c"]), ("mild", ["e"]), ("near", ["d"]), ("odd", ["b"])]


@pytest.mark.parametrize(
    ("student", "name", "label"),
    [("7", "7", "7"), ("7", "Ann (7)", "Ann (7)"), ("7", "Ann", "Ann (7)"), ("jdoe", "Doe", "Doe (jdoe)")],
)
def test_a_student_is_called_by_name_and_by_key_once(student: str, name: str, label: str) -> None:
    assert a_class([replace(GOOD, student=student, name=name)]).label(student) == label


@pytest.mark.parametrize("length", [27, 28, 29, 60])
def test_a_long_name_takes_28_places_of_the_table(length: int) -> None:
    name = "".join(chr(97 + at % 26) for at in range(length))
    (row,) = (row for row in class_summary(a_class([replace(GOOD, name=name)])) if "abcdefghi" in row)
    assert row.split()[0] == (name if length <= 28 else name[:27] + "…")


def a_class_of(names: list[str]) -> ClassGrades:
    found = a_class([replace(GOOD, student=f"s{at}", name=f"S{at}") for at in range(len(names))])
    items = tuple(replace(one, feedback_stem=name) for one, name in zip(found.submissions.items, names, strict=True))
    return replace(found, submissions=replace(found.submissions, items=items))


def files_of(folder: Path) -> list[str]:
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())


def test_feedback_of_one_name_is_numbered_from_two(tmp_path: Path) -> None:
    assert write_feedback(a_class_of(["doe", "Doe", "DOE"]), tmp_path, GradingOptions(0)) == ([], [])
    assert [path.name for path in sorted((tmp_path / "feedback").glob("*.md"))] == ["DOE-3.md", "Doe-2.md", "doe.md"]


def test_what_the_next_run_relies_on_outlasts_a_power_cut_and_all_is_the_graders_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    synced: set[int] = set()
    sync = os.fsync

    def noted(number: int) -> None:
        synced.add(os.fstat(number).st_ino)
        sync(number)

    monkeypatch.setattr(os, "fsync", noted)
    mask = os.umask(0o022)
    try:
        found = a_class_of(["doe"])
        for points in (11.5, 3.0):
            found = replace(found, grades=(replace(found.grades[0], points=points),))
            write_results(found, tmp_path, {})
            write_feedback(found, tmp_path, GradingOptions(0))
            (tmp_path / "feedback" / "doe.md").write_text("well done", encoding="utf-8")
            (tmp_path / "grades.csv").write_text("student,status,total\ns0,graded,4.00\n", encoding="utf-8")
        write_results(found, tmp_path, {})
        write_feedback(found, tmp_path, GradingOptions(0))
    finally:
        os.umask(mask)
    there = [path for path in tmp_path.rglob("*") if path.is_file()]
    kept = {path.relative_to(tmp_path).parts[0] for path in there if path.stat().st_ino in synced}
    # A number that is free again may be another file's: there may be more.
    assert kept >= {"published", "grades.csv", "feedback.zip"}
    assert all(path.stat().st_ino in synced for path in (tmp_path / "published").rglob("*.*"))
    assert [path for path in there if path.stat().st_mode & 0o077] == []


def test_what_the_new_table_says_too_waits_for_nobody(tmp_path: Path) -> None:
    found = a_class_of(["doe"])
    found = replace(found, grades=(replace(found.grades[0], points=17.25),))
    write_results(found, tmp_path, {})
    table = (tmp_path / "grades.csv").read_text(encoding="utf-8")
    (tmp_path / "grades.csv").write_text(table.replace(",17.25,", ",3,"), encoding="utf-8")
    agreed = replace(found, grades=(replace(found.grades[0], points=3.0),))
    assert [write_results(one, tmp_path, {}) for one in (found, agreed, found)] == [1, 0, 1]


def test_the_zip_of_feedback_does_not_tell_when_and_by_whom_it_was_made(tmp_path: Path) -> None:
    write_feedback(a_class_of(["doe", "roe"]), tmp_path, GradingOptions(0))
    with zipfile.ZipFile(tmp_path / "feedback.zip") as archive:
        entries = [(one.filename, one.date_time[0], oct(one.external_attr >> 16)) for one in archive.infolist()]
        assert {one.compress_type for one in archive.infolist()} == {zipfile.ZIP_DEFLATED}
    assert entries == [(f"{who}{end}", 1980, "0o644") for who in ("doe", "roe") for end in (".html", ".md")]


# --- files that are handed in -------------------------------------------------------------------------------


@pytest.mark.parametrize("make", [make_folder, make_zip])
def test_a_class_may_have_as_many_files_as_is_said(
    make: Callable[..., Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("gyrodata.grading.submissions.archives.MOST_FILES", 4)
    root = make(tmp_path / "few.zip", {f"s{at}.csv": LOG for at in range(4)})
    assert len(find_submissions(root).items) == 4
    with pytest.raises(InputError, match="more than 4 files"):
        find_submissions(make(tmp_path / "many.zip", {f"s{at}.csv": LOG for at in range(5)}))


def test_a_refusal_shows_no_sign_that_a_terminal_would_obey(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        find_submissions(make_zip(tmp_path / "class.zip", {"../\x1b[31mlab é.csv": LOG}))
    assert "../\ufffd[31mlab é.csv" in caught.value.diagnostics[0].message


def test_two_students_of_blackboard_without_receipts_are_told_by_what_their_files_do_not_share(tmp_path: Path) -> None:
    stem = "Gyro lab_{}_attempt_2026-03-09-14-05-59_lab.csv"
    root = make_folder(tmp_path / "class", {stem.format(user): LOG for user in ("j_doe", "b_roe")})
    assert [one.student for one in find_submissions(root, "blackboard").items] == ["b_roe", "j_doe"]


# --- what a grade rests on ----------------------------------------------------------------------------------


def test_other_files_matter_where_the_rubric_counts_them(tmp_path: Path) -> None:
    root = make_folder(tmp_path / "class", {"a/lab.csv": LOG, "a/plot.png": "x"})
    (item,) = find_submissions(root).items
    fewer = replace(item, members=item.members[:1])
    plain = read_rubric(BY_HAND.encode())
    files = 'check = "files", points = 2, full = "files >= 2", zero = "files <= 0" }'
    counting = read_rubric(BY_HAND.replace('check = "manual", points = 2 }', files).encode())
    assert basis_of(item, plain, "") == basis_of(fewer, plain, "")
    assert basis_of(item, counting, "") != basis_of(fewer, counting, "")


@pytest.mark.parametrize(
    ("count", "workers", "share"),
    [(0, 1, 1), (3, 1, 1), (4, 1, 1), (7, 1, 1), (8, 1, 2), (9, 0, 2), (15, 2, 1), (16, 2, 2), (127, 1, 31),
     (128, 1, 32), (132, 1, 32), (10_000, 4, 32)],
)  # fmt: skip
def test_each_worker_comes_round_four_times_with_at_most_32_students(count: int, workers: int, share: int) -> None:
    assert share_of(count, workers) == share


@pytest.mark.parametrize(
    ("ends", "fits"), [(("1e-6", "100"), True), (("1", "1.001"), True), (("1", "1"), False), (("2", "1"), False)]
)
def test_a_gate_has_a_lower_end_and_a_higher_one(ends: tuple[str, str], fits: bool) -> None:
    low, high = ends
    check = 'check = "uncertainty", points = 2, full = "stated >= 1", zero = "stated <= 0"'
    gate = f'{check}, gate = ["{low} kg m^2", "{high} kg m^2"] }}'
    rubric = BY_HAND.replace('check = "manual", points = 2 }', gate).encode()
    if fits:
        assert read_rubric(rubric).criteria[0].gate == (float(low), float(high))
    else:
        with pytest.raises(InputError, match="gate: the first is not below the second"):
            read_rubric(rubric)


# --- lateness -----------------------------------------------------------------------------------------------

LATE = """
[late]
due = 2026-03-09T12:00:00+01:00
grace = "10 min"
beyond = 9
marked = 3
[[late.tier]]
until = "1 h"
deduct = 1
[[late.tier]]
until = "1 day"
deduct = "20 %"
[[late.exception]]
student = "ann"
extra = "2 h"
[[late.exception]]
student = "bob"
waive = true
[[late.exception]]
student = "cem"
due = 2026-03-10T12:00:00+01:00
"""


@pytest.mark.parametrize(
    ("student", "late", "seconds", "submitted", "told"),
    [
        ("x", False, None, "2026-03-09T11:59:59+01:00", (0.0, 0.0, "", False)),
        ("x", False, None, "2026-03-09T12:00:00+01:00", (0.0, 0.0, "", False)),
        ("x", True, 7200.0, "2026-03-09T12:00:01+01:00",
         (1.0, 0.0, "1 s after the deadline, within the grace time", False)),
        ("x", False, None, "2026-03-09T12:10:00",
         (600.0, 0.0, "10 min after the deadline, within the grace time", False)),
        ("x", False, None, "2026-03-09T12:10:01", (601.0, 1.0, "10 min late", False)),
        ("x", False, None, "2026-03-09T12:00:00Z", (3600.0, 1.0, "1 h late", False)),
        ("x", False, None, "2026-03-09T13:00:01+01:00", (3601.0, 4.0, "1 h late", False)),
        ("x", False, None, "2026-03-10T12:00:00+01:00", (86400.0, 4.0, "1 day late", False)),
        ("x", False, None, "2026-03-10T12:00:01+01:00", (86401.0, 9.0, "1 day late", False)),
        ("x", False, None, None, (0.0, 0.0, "", False)),
        ("x", True, None, None, (None, 3.0, "marked late, without the time", False)),
        ("x", True, None, "yesterday", (None, 3.0, "marked late, without the time", False)),
        ("x", True, 59.0, None, (59.0, 0.0, "59 s after the deadline, within the grace time", False)),
        ("x", True, 4000.0, None, (4000.0, 4.0, "1 h 6 min late", False)),
        ("Ann", False, None, "2026-03-09T14:10:00+01:00",
         (600.0, 0.0, "10 min after the deadline, within the grace time", False)),
        ("Ann", False, None, "2026-03-09T14:10:01+01:00", (601.0, 1.0, "10 min late", False)),
        ("ann", True, 7200.0, None, (0.0, 0.0, "", False)),
        ("ann", True, None, None, (None, 0.0, "marked late, but nothing says by how much", True)),
        ("bob", True, 99.0, None, (99.0, 0.0, "lateness waived for you", False)),
        ("bob", True, None, None, (None, 0.0, "lateness waived for you", False)),
        ("bob", False, 0.0, None, (0.0, 0.0, "", False)),
        ("cem", True, 99.0, None, (None, 0.0, "marked late, but nothing says by how much", True)),
        ("cem", False, 99.0, None, (99.0, 0.0, "1 min after the deadline, within the grace time", False)),
        ("cem", True, 99.0, "2026-03-10T12:10:01+01:00", (601.0, 1.0, "10 min late", False)),
    ],
)  # fmt: skip
def test_lateness_to_the_second(
    student: str, late: bool, seconds: float | None, submitted: str | None, told: tuple[float | None, float, str, bool]
) -> None:
    found = judge_lateness(read_rubric((BY_HAND + LATE).encode()).late, {"id": student}, late, seconds, submitted)
    assert (found.seconds, found.deduct, found.reason, found.look) == told


@pytest.mark.parametrize(
    ("late", "seconds", "reason"),
    [(False, None, ""), (False, 0.0, ""), (True, 0.0, "marked late"), (True, None, "marked late"),
     (True, 7200.0, "2 h late"), (False, 60.0, "1 min late")],
)  # fmt: skip
def test_lateness_costs_nothing_where_no_rule_is(late: bool, seconds: float | None, reason: str) -> None:
    found = judge_lateness(None, {}, late, seconds, None)
    assert (found.seconds, found.deduct, found.reason, found.look) == (seconds, 0.0, reason, False)


# --- points -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("sheet", "out_of", "fits"), [
    ("20", 20.004, True), ("20", 20.006, False), ("20.004", 20.0, True), ("20.006", 20.0, False),
    ("19.99", 20.0, False),
])  # fmt: skip
def test_points_possible_are_the_same_to_the_hundredth(sheet: str, out_of: float, fits: bool) -> None:
    book = f"Student,ID,Gyro (7)\n    Points Possible,,{sheet}\nDoe,1,\n".encode()
    grades = [a_grade("1", out_of=out_of)]
    if fits:
        assert rows_of(fill_gradebook(book, grades=grades, ids={"1": {"canvas": "1"}}).data)[2][2] == "17.50"
    else:
        with pytest.raises(InputError):
            fill_gradebook(book, grades=grades, ids={"1": {"canvas": "1"}})


@pytest.mark.parametrize(("lines", "delimiter"), [(2, ";"), (3, ";"), (4, ","), (5, ",")])
def test_the_first_three_lines_of_a_sheet_tell_what_parts_its_cells(lines: int, delimiter: str) -> None:
    rows = ["a,b"] * 5
    rows[lines - 1] = "a;b;c;d;e;f"
    assert read_sheet("\n".join(rows).encode(), "sheet.csv").delimiter == delimiter


def test_where_nothing_is_uncertain_the_smallest_difference_counts() -> None:
    check = 'check = "reference", points = 2, full = "z <= 2", zero = "z >= 9" }'
    reference = '[reference.all]\ninertia = "4.4e-3 kg m^2"\nu = "0 kg m^2"\n'
    rubric = read_rubric((BY_HAND.replace('check = "manual", points = 2 }', check) + reference).encode())
    for value, points in ((4.4e-3, 2.0), (4.4e-3 * (1 + 1e-9), 2.0), (4.4e-3 * (1 + 1e-8), 0.0)):
        grade = a_grade("1", own={"recommended": {}})
        pending = replace(grade.marks[0], detail={"value": value, "u": 0.0})
        ((settled,), *_) = settle([replace(grade, marks=(pending, *grade.marks[1:]))], rubric)
        assert settled.marks[0].points == points
        assert settled.zeta == pytest.approx(abs(value / 4.4e-3 - 1) * 1e9, rel=1e-6)


def test_a_total_has_hundredths_and_is_never_below_nothing() -> None:
    rubric = read_rubric(BY_HAND.encode())
    for points, taken, total in (
        ((2.0, 4.5, 11.0), 1 / 3, 17.17),
        ((0.0, 0.5, 0.25), 0.7551, 0.0),
        ((0.0, 1.0, 0.0), 0.992, 0.01),
    ):
        grade = a_grade("1", points, late_deduction=taken, own={"recommended": {}})
        assert settle([grade], rubric)[0][0].points == total


def test_gradescope_is_told_hundredths_and_what_is_worth_a_point_is_not_met_without_one() -> None:
    grade = a_grade("1", (1 / 3, 0.0, 2.0), late_deduction=0.0)
    one, two, three = grade.marks
    compared = {"d": 1.0}
    marks = (one, replace(two, out_of=1.0, detail=compared), replace(three, out_of=2.0, detail=compared))
    told = json.loads(results_json(replace(grade, marks=marks)))
    assert told["score"] == 2.33
    assert told["output"].splitlines()[:3] == [
        "0.33 of 2 points in what is shown now.",
        "Criterion 1: not met. The points are shown after the due date.",
        "Criterion 2: met. The points are shown after the due date.",
    ]


# --- logs that are alike ------------------------------------------------------------------------------------


def few(count: int) -> dict[str, list[Row]]:
    return dict(list(CLASS.items())[:count])


@pytest.mark.parametrize(("copies", "more"), [(2, ""), (3, "; and 3 more like these")])
def test_three_pairs_of_a_ring_are_told_and_more_are_counted(copies: int, more: str) -> None:
    ring = {f"z{at}": CLASS["s00002"] for at in range(copies)}
    (flag,) = flag_class(prints_of(few(12) | ring))
    assert flag.evidence.count(" rows of ") == 3
    assert flag.evidence.partition("; and ")[1:] == (more[:6], more[6:])


@pytest.mark.parametrize(("turns", "told"), [("1", False), ("4/3", False), ("2", True), ("3", True)])
def test_the_last_digit_of_a_period_is_another_where_it_is_half_or_less(turns: str, told: bool) -> None:
    parts = {"1/3": 3.0, "2/3": 1.5, "1": 1.0, "4/3": 4 / 3, "2": 2.0, "3": 3.0}
    rows = [(m, x, spin, f"{parts[part] * float(time):.2f}", "1") for m, x, spin, time, part in CLASS["s00002"]]
    copy = [(m, x, spin, f"{parts[turns] * float(time):.2f}", turns) for m, x, spin, time, _ in rows]
    (flag,) = flag_class(prints_of(few(12) | {"s00002": rows, "zz": copy}))
    assert ("not typed to the same digit" in flag.evidence) == told


@pytest.mark.parametrize(
    ("mass", "kinds"), [("18", ["shared rows"]), ("17.9", []), ("22.2", ["shared rows"]), ("22.3", [])]
)
def test_rows_are_compared_where_their_weights_are_a_tenth_apart(mass: str, kinds: list[str]) -> None:
    rows = [("20", *row[1:]) for row in CLASS["s00002"]]
    copy = [(mass, *row[1:]) for row in rows]
    assert [flag.kind for flag in flag_class(prints_of(few(12) | {"s00002": rows, "zz": copy}))] == kinds


@pytest.mark.parametrize(("sharing", "flags"), [(9, 0), (8, 1)])
def test_spins_are_a_habit_where_more_than_a_share_of_the_class_has_them(
    sharing: int, flags: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("gyrodata.grading.forensics.copies.HABIT_SHARE", 0.27)
    same = {
        student: [(m, x, CLASS["s00001"][at][2], time, turns) for at, (m, x, _, time, turns) in enumerate(rows)]
        for student, rows in few(sharing).items()
    }
    assert len(flag_class(prints_of(CLASS | same))) == flags


# --- the page of the class ----------------------------------------------------------------------------------


@pytest.mark.parametrize(("expected", "words"), [
    (0.04, "about 1 in 20"), (0.003, "about 1 in 300"), (1.3e-6, "about 1 in 800000"), (1e-6, "about 1 in 1000000"),
    (0.99e-6, "fewer than 1 in a million"), (1e-12, "fewer than 1 in a million"),
])  # fmt: skip
def test_how_rare_a_flag_is_is_told_down_to_a_million(expected: float, words: str) -> None:
    pair = [replace(GOOD, student=student, name=student) for student in "ab"]
    page = page_of(a_class(pair, [Flag("same spins", ("a", "b"), "9 of 9 spins", 1e-15, expected)]))
    assert f"By chance, {words} honest classes would show this." in page


@pytest.mark.parametrize(("turns", "shown"), [
    ("1/3", "1/3"), ("0.3333333", "1/3"), ("0.333333", "0.3333"), ("0.6667", "0.6667"), ("11/12", "11/12"),
    ("1/13", "0.07692"), ("2", "2"), ("0.25", "1/4"),
])  # fmt: skip
def test_turns_are_shown_as_the_fraction_that_they_are(turns: str, shown: str) -> None:
    prints = prints_of({student: [(*row[:4], turns) for row in CLASS["s00001"]] for student in "ab"})
    flag = Flag("shared rows", ("a", "b"), "9 of 9 rows", 1e-9, 1e-8, pairs=(("a", "b"),))
    found = a_class([replace(GOOD, student=student, name=student) for student in prints], [flag])
    (table,) = tables_of(page_of(replace(found, compared=prints)))
    assert {cells[at][0] for cells in table for at in (4, 8)} == {shown}
