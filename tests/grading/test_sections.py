"""Sections and graders are compared, names can be hidden, and comments arrive."""

from __future__ import annotations

import csv
import json
import re
import statistics
from pathlib import Path

import pytest
from grading.classes import make_folder
from grading.students_reports import a_log
from grading.test_class_page import Lab
from scipy.stats import mannwhitneyu

from gyrodata.grading.sections import _probability

FIRST = ("Ada", "Bela", "Cem", "Dora", "Emil", "Fia", "Gero", "Hana", "Ilja", "Jana")
LAST = ("Ångström", "Bernoulli")


def two_sections(home: Path, factor: float) -> Lab:
    """A class of twenty, in whose second section the answers are too large."""
    logs = {}
    people = ["student,name,section,TA"]
    for number in range(20):
        log = a_log(number, "# station: 3")
        if number >= 10:
            found = re.search("# reported_inertia: (\\S+)", log)
            assert found is not None
            value = float(found[1])
            log = log.replace(found[1], f"{factor * value:.3e}")
        logs[f"n{number:02d}/lab.csv"] = log
        name = f"{FIRST[number % 10]} {LAST[number // 10]}"
        section = "AB"[number // 10]
        people.append(f"n{number:02d},{name},{section},{['Kim', 'Lee'][number % 2]}")
    lab = Lab(home, logs)
    make_folder(home, {"roster.csv": "\n".join(people)})
    lab.options += ("--roster", str(home / "roster.csv"))
    return lab


@pytest.mark.slow
@pytest.mark.parametrize(("factor", "differs"), [(1.0, False), (1.3, True)])
def test_a_section_with_other_points_is_named(
    tmp_path: Path, factor: float, differs: bool
) -> None:
    lab = two_sections(tmp_path, factor)
    told = lab.grade().stdout
    document = json.loads(lab.read("grades.json"))
    figures = {(one["kind"], one["name"]): one for one in document["sections"]}
    assert list(figures) == [
        ("section", "A"),
        ("section", "B"),
        ("grader", "Kim"),
        ("grader", "Lee"),
    ]
    for (kind, name), one in figures.items():
        mine = [
            student["points"]
            for at, student in enumerate(document["students"])
            if name in ("AB"[at // 10], ["Kim", "Lee"][at % 2])
        ]
        assert one["graded"] == len(mine) == 10, kind
        assert one["mean"] == pytest.approx(statistics.fmean(mine), abs=1e-4)
        assert one["median"] == statistics.median(mine)
        assert one["spread"] == pytest.approx(statistics.stdev(mine), abs=1e-4)
        assert one["full"] == sum(points == 20 for points in mine) / 10
    points = [one["points"] for one in document["students"]]
    by_section = points[:10], points[10:]
    p = 1.0
    if len(set(points)) > 1:
        options = {"method": "asymptotic", "use_continuity": False}
        p = min(1.0, 2 * mannwhitneyu(*by_section, **options).pvalue)
    assert figures["section", "A"]["p"] == pytest.approx(p, rel=1e-9)
    notes = [f"{kind} {name} has other points" for kind, name in figures]
    for text in (told, lab.read("class.html").casefold()):
        shown = [note.casefold() in text.casefold() for note in notes]
        assert shown == [differs, differs, False, False]


@pytest.mark.slow
def test_anonymous_pages_contain_no_name(tmp_path: Path) -> None:
    lab = two_sections(tmp_path, 1.0)
    lab.options += ("--anonymous",)
    lab.out.mkdir()
    head = "student,what,value,by,why,name"
    lab.decide("n07,comment,Good.,Ann,,Hana Ångström", head=head)
    lab.grade()
    pages = [lab.read("class.html")]
    pages += [page.read_text("utf-8") for page in lab.out.glob("feedback/*/*.*")]
    assert len(pages) == 41
    names = [*FIRST, "Ångström", "ngstr", "Bernoulli"]
    assert not any(re.search(rf"\b{name}", page) for name in names for page in pages)
    assert "n07" in pages[0]
    assert "Hana Ångström" in lab.read("grades.csv")


@pytest.mark.slow
def test_comments_and_answers_are_in_feedback_and_gradebook(tmp_path: Path) -> None:
    lab = Lab(tmp_path, {f"{number}/lab.csv": a_log(number) for number in (101, 102)})
    lab.grade()
    lab.decide("101,regrade,,,Is my unit wrong?", "102,regrade,,Ann,Why 20?")
    assert [line[:3] for line in lab.todo] == [
        ["101", "regrade", ""],
        ["102", "regrade", ""],
    ]
    assert "You asked" not in lab.read("feedback/101/feedback.md")
    book = [
        ["Identifier", "Name", "Grade", "Maximum Grade", "Can be changed", "Comments"],
        ["Participant 101", "A", "", "20.00", "Yes", ""],
        ["Participant 102", "B", "", "20.00", "Yes", ""],
    ]
    (tmp_path / "sheet.csv").write_text("\n".join(map(",".join, book)), "utf-8")
    lab.options += ("--gradebook", str(tmp_path / "sheet.csv"))
    lab.decide(
        "101,regrade,It is right.,Ann,Is my unit wrong?",
        "101,comment,Nice plot.,Ann,",
        "101,units,2,Ann,well written",
        "102,late,1.5,Ann,a day late",
        "102,regrade,You have all.,Ann,Why 20?",
    )
    assert lab.todo == []
    answer = "You asked: Is my unit wrong? Answer: It is right. (Ann)"
    rows = list(csv.reader(lab.read("moodle.csv").splitlines()))
    texts = {
        "101": [answer, "Nice plot. (Ann)", "well written (Ann)"],
        "102": ["a day late (Ann)", "You asked: Why 20? Answer: You have all. (Ann)"],
    }
    for row in rows[1:]:
        student = row[0].split()[1]
        feedback = lab.read(f"feedback/{student}/feedback.md")
        assert all(text in row[5] and text in feedback for text in texts[student])


@pytest.mark.parametrize("sizes", [(5, 12), (6, 20), (7, 7)])
def test_sections_with_equal_points_do_not_differ(sizes: tuple[int, int]) -> None:
    mine, others = ([10.0] * size for size in sizes)
    assert _probability(mine, others, 2) == 1.0
