"""The page of a class: whole, escaped, saying what the grades say, and with every line that waits for a person."""

from __future__ import annotations

import csv
import html
import io
import re
import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from browser import look_at, needs_browser
from grading.classes import make_folder
from grading.reports import RIGHT as RIGHT_FORMULA
from grading.reports import Sheet, reported_line, sheet, three_grades
from grading.test_feedback import Page
from msgspec.structs import replace
from typer.testing import CliRunner, Result

from gyrodata.cli import app
from gyrodata.grading import (
    DESK,
    TODO,
    ClassGrades,
    Decision,
    Desk,
    Flag,
    Grade,
    Person,
    Reference,
    Roster,
    Submission,
    Submissions,
    default_rubric,
    read_desk,
    write_results,
)

GOOD, SLIP, WAITING = three_grades().values()
REFERENCE = Reference(4.44e-3, 0.02e-3, "the rubric")
EVIL = '<script>alert("x")</script>'


def a_class(grades: Sequence[Grade], flags: Sequence[Flag] = ()) -> ClassGrades:
    items = tuple(
        Submission(one.student, one.name, {"canvas": one.student}, Path("class"), feedback_stem=one.student)
        for one in grades
    )
    return ClassGrades(
        "class", Submissions("canvas", items), default_rubric(), tuple(grades), {"all": REFERENCE}, tuple(flags), {}, {}
    )


def three() -> ClassGrades:
    grades = [replace(GOOD, student="g", name="Good"), replace(SLIP, student="s", name="Slip"),
              replace(WAITING, student="w", name="Waiting")]  # fmt: skip
    return a_class(grades, [Flag("shared rows", ("g", "s"), "9 of 9 rows", 1e-9, 1e-8)])


def todo_of(folder: Path) -> list[list[str]]:
    return list(csv.reader(io.StringIO((folder / TODO).read_text(encoding="utf-8"))))[1:]


def page_of(found: ClassGrades) -> str:
    with tempfile.TemporaryDirectory() as folder:
        write_results(found, Path(folder), {})
        return (Path(folder) / "class.html").read_text(encoding="utf-8")


def seen(page: str) -> str:
    """The words of a page."""
    text = re.sub(r"<(style|script).*?</\1>", "", page, flags=re.DOTALL)
    return " ".join(html.unescape(re.sub(r"<[^>]+>", " ", text)).split())


def test_structure_is_sound_and_nothing_comes_from_outside() -> None:
    page = page_of(three())
    tags = Page(page).tags
    assert [tag for tag, _ in tags].count("h1") == 1
    assert all(attributes.get("scope") for tag, attributes in tags if tag == "th")
    links = {str(attributes["href"]) for tag, attributes in tags if tag == "a"}
    within = {f"#{attributes['id']}" for _, attributes in tags if "id" in attributes}
    assert links == within | {"feedback/g.html", "feedback/s.html", "feedback/w.html"}
    assert not any(key.startswith("on") or key == "src" for _, attributes in tags for key in attributes)
    assert not re.search(r"https?://|url\(|@import", page)


@pytest.mark.parametrize("evil", [EVIL, "</title><b>", "{{ 7 * 7 }}", "\u202egnp.exe", "a\x00b\x1b[31m"])
def test_names_and_reasons_stay_text(evil: str) -> None:
    grades = [
        replace(
            GOOD,
            student=evil,
            name=evil,
            title=evil,
            late_reason=evil,
            look=(evil,),
            section=evil,
            by_hand=(Decision("comment", evil, evil, evil),),
        ),
        replace(WAITING, student="w", name=evil, why=evil),
    ]
    found = a_class(grades, [Flag("shared rows", (evil, "w"), evil, 1e-9, 1e-8, (evil,))])
    people = Roster({evil: Person(evil, evil, evil, evil, ())}, (Person(evil, evil, evil, "", ()),))
    desk = Desk({evil: grades[0].by_hand})
    page = page_of(replace(found, source=evil, roster=people, desk=desk))
    Page(page)
    for bad in ("<script>alert", "</title><b>", "\u202e", "\x00", "\x1b", " 49 "):
        assert bad not in page


def brightness(colour: str) -> float:
    """Relative luminance (WCAG 2.2)."""
    parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def test_contrast_in_both_themes() -> None:
    themes = re.findall(r":root \{(.*?)\}", page_of(three()))
    assert len(themes) == 3
    for theme in themes:
        colours = {name: brightness(colour) for name, colour in re.findall(r"--([\w-]+): (#\w{6})", theme)}
        pairs = [("ink", "paper", 4.5), ("soft", "paper", 4.5), ("mark", "paper", 4.5), ("ink", "warn-paper", 4.5),
                 ("ink", "band", 4.5), ("soft", "warn-paper", 4.5),
                 ("mark", "warn-paper", 4.5), ("warn", "paper", 3),
                 ("mark", "band", 3)]  # fmt: skip
        for one, other, least in pairs:
            low, high = sorted((colours[one], colours[other]))
            assert (high + 0.05) / (low + 0.05) >= least, (one, other)


# --- the class in numbers -----------------------------------------------------------------------------------


# --- what waits for a person --------------------------------------------------------------------------------


class Group(NamedTuple):
    """What the page says of one reason."""

    reason: str
    count: int
    lines: list[list[str]]  # cells of the lines to be copied


def groups_of(page: str) -> list[Group]:
    found = []
    for part in re.findall(r'<section class="group.*?</section>', page, re.DOTALL):
        head = re.search(r'<span class="count">(\d+)</span> × <span class="k">(.*?)</span>', part)
        assert head
        codes = re.findall(r'<p class="desk">.*?<code>(.*?)</code></p>', part)
        lines = list(csv.reader(html.unescape(code) for code in codes))
        found.append(Group(html.unescape(head[2]), int(head[1]), lines))
    return found


def squeezed(lines: Sequence[Sequence[str]]) -> Counter[tuple[str, ...]]:
    return Counter(tuple(" ".join(cell.split()) for cell in line[:5]) for line in lines)


BOOK = """Student,ID,SIS User ID,SIS Login ID,Section,Gyroscope lab (1)
    Points Possible,,,,,20.00
"Adler, Nina",1,,,Mon A,12
"O'Brien ""X"", <b>Seán",2,,,Tue B,25
"Müller, Zoë",3,,,Mon A,
Four,4,,,Tue B,
Five,5,,,Mon A,
Six,6,,,Tue B,
Gone,9,,,Mon A,
"""


class Lab:
    """A class with something of everything, three logs that are one among it; the folder of its grades."""

    def __init__(self, home: Path) -> None:
        self.root, self.out = home / "class", home / "grades"
        rows = [sheet(np.random.default_rng(i), "mixed") for i in range(7)]
        mixed = np.random.default_rng(1).permutation(len(rows[4].mass))
        rows[5] = Sheet(*(column[mixed] for column in (rows[4].mass, rows[4].position, rows[4].spin, rows[4].time,
                                                       rows[4].turns)))  # fmt: skip
        self.rows = rows
        logs = [one.log(reported_line(*RIGHT_FORMULA.inertia(one, "with_constant"))) for one in rows]
        value, u = RIGHT_FORMULA.inertia(rows[3], "with_constant")
        logs[1], logs[2] = rows[1].log(), ""
        logs[3] = rows[3].log(reported_line(1.3 * value, u))
        make_folder(self.root, {f"s{i}_{i}_{i}_lab.csv": log for i, log in enumerate(logs) if i})
        make_folder(self.root, {"s1_1_1_report.pdf": b"%PDF-1.4", "s7_7_7_lab.csv": logs[4]})
        self.book = home / "book.csv"
        self.book.write_text(BOOK, encoding="utf-8")

    def grade(self, *options: str | Path) -> Result:
        given = ("grade", self.root, "-o", self.out, "--workers", "1", "--gradebook", self.book, *options)
        done = CliRunner().invoke(app, list(map(str, given)))
        assert done.exit_code in (0, 1), done.stderr
        return done

    def desk(self, lines: Sequence[Sequence[str]]) -> None:
        with (self.out / DESK).open("w", encoding="utf-8", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([["student", "what", "value", "by", "why"], *lines])

    @property
    def page(self) -> str:
        return (self.out / "class.html").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Lab]:
    lab = Lab(tmp_path_factory.mktemp("lab"))
    lab.grade()
    table = lab.out / "grades.csv"
    # Somebody sets points by hand, one of them more than there are.
    changed = re.sub(r"^(4,.*?graded),20.00", r"\1,13.50", table.read_text(encoding="utf-8"), flags=re.MULTILINE)
    table.write_text(re.sub(r"^(6,.*?graded),20.00", r"\1,99", changed, flags=re.MULTILINE), encoding="utf-8")
    lab.grade()
    return lab


def test_groups_and_counts_are_those_of_the_lines_that_wait(lab: Lab) -> None:
    groups = groups_of(lab.page)
    assert {group.reason: group.count for group in groups} == {
        "grades.csv was changed by hand": 2,
        "other points stand in the gradebook": 2,
        "no grade: the log cannot be used": 1,
        "no grade: no I_zz is reported": 1,
        "the reported I_zz is … u from the student's own runs": 1,
        "flag: shared rows": 1,
    }
    assert all(group.count == len(group.lines) for group in groups)
    assert squeezed([line for group in groups for line in group.lines]) == squeezed(todo_of(lab.out))
    assert "s1_1_1_report.pdf" in lab.page
    assert '<bdi>O&#39;Brien &#34;X&#34;, &lt;b&gt;Seán</bdi></a> <span class="sec">Tue B</span>' in lab.page


def test_every_line_can_be_put_on_the_desk(lab: Lab) -> None:
    lines = [line for group in groups_of(lab.page) for line in group.lines]
    students = {str(i): {str(i)} for i in range(1, 8)}
    for line in lines:
        out = io.StringIO()
        csv.writer(out).writerows([["student", "what", "value", "by", "why"], line])
        read_desk(out.getvalue().encode(), students, default_rubric())
    assert ["2", "total", ""] in [line[:3] for line in lines], "25 of 20 points are told, and not offered"
    assert ["6", "total", ""] in [line[:3] for line in lines]
    assert ["1", "total", "12.00"] in [line[:3] for line in lines]
    assert ["4", "total", "13.50"] in [line[:3] for line in lines]


# --- two logs side by side ----------------------------------------------------------------------------------

Cells = list[tuple[str, bool]]  # text of each cell, and whether it is marked


def tables_of(page: str) -> list[list[Cells]]:
    tables = re.findall(r'<table class="beside">.*?<tbody>(.*?)</tbody>', page, re.DOTALL)
    return [
        [
            [(re.sub("<.*?>", "", cell), "<mark>" in cell) for cell in re.findall(r"<td>(.*?)</td>", row)]
            for row in re.findall(r"<tr>(.*?)</tr>", table)
        ]
        for table in tables
    ]


def test_marked_are_the_cells_that_are_equal_and_no_others(tmp_path: Path) -> None:
    random = np.random.default_rng(7)
    first = sheet(random, "mixed")
    own = sheet(random, "mixed")
    half = random.permutation(len(first.mass)) < 6
    second = replace(
        own, spin=np.where(half, first.spin, own.spin), time=np.where(half, first.time, own.time),
        mass=first.mass, position=first.position, turns=first.turns,
    )  # fmt: skip
    logs = {"a": first, "b": second} | {f"c{i}": sheet(random, "mixed") for i in range(6)}
    make_folder(tmp_path / "class", {f"{name}/lab.csv": rows.log() for name, rows in logs.items()})
    CliRunner().invoke(app, ["grade", str(tmp_path / "class"), "-o", str(tmp_path / "out"), "--workers", "1"])
    page = (tmp_path / "out" / "class.html").read_text(encoding="utf-8")
    (table,) = tables_of(page)
    lines = [dict(enumerate(logs[name].log().splitlines(), 1)) for name in "ab"]
    shown = [set(), set()]
    for torque, *cells in table:
        sides = cells[:4], cells[4:]
        for side, typed, numbers in zip(sides, lines, shown, strict=True):
            (line, _), (spin, _), (time, _), (turns, _) = side
            mass, position, *told = typed[int(line)].split(",")
            assert told == [spin, time, turns], "as typed"
            assert float(torque[0]) == pytest.approx(float(mass) * 9.803 * float(position) / 100, rel=1e-3)
            numbers.add(int(line))
        for at in (1, 2):
            equal = sides[0][at][0] == sides[1][at][0]
            assert (sides[0][at][1], sides[1][at][1]) == (equal, equal)
    assert shown[0] == shown[1] == set(range(3, 3 + len(first.mass)))
    assert sum(cells[2][1] for cells in table) >= 6
    assert f"{sum(cells[2][1] for cells in table)} of {len(table)} spins" in page


# --- in a browser -------------------------------------------------------------------------------------------

PROBE = """<script>
addEventListener("load", async () => {
  const frame = document.querySelector("iframe"), view = frame.contentWindow, page = frame.contentDocument;
  const table = page.querySelector("table.everybody"), heads = [...table.tHead.rows[0].cells];
  const shown = () => [
    [...page.querySelectorAll(".group:not([hidden]) .count")].map(e => Number(e.textContent)),
    [...table.tBodies[0].rows].filter(e => !e.hidden).map(e => e.cells[0].textContent),
    [...page.querySelectorAll(".people li:not([hidden])")].map(e => e.firstChild.textContent)];
  const sort = i => { heads[i].querySelector("button").click(); return shown()[1]; };
  const [box, choice, told] = page.querySelectorAll(".filter input, .filter select, .filter output");
  const filter = (text, section = "") => {
    box.value = text;
    choice.value = section;
    box.dispatchEvent(new view.Event("input", {bubbles: true}));
    return shown();
  };
  const copied = [], clipboard = {writeText: async text => copied.push(text)};
  Object.defineProperty(view.navigator, "clipboard", {value: clipboard, configurable: true});
  const press = async what => { page.querySelector(what).click(); await new Promise(done => setTimeout(done, 50)); };
  const out = {
    wide: page.documentElement.scrollWidth, inner: frame.clientWidth,
    beyond: [...page.querySelectorAll("h1, h2, h3, h4, p, li, summary, svg, form *")]
      .filter(e => e.getBoundingClientRect().right > frame.clientWidth).map(e => e.textContent),
    up: sort(2), down: sort(2), names: sort(0),
    aria: heads.map(h => h.getAttribute("aria-sort")).slice(0, 2),
    choices: [...choice.options].map(one => one.value), all: filter(""), told: told.textContent,
    name: filter("  GÖÖD "), reason: filter("flag shared"), section: filter("", "Tue B"), both: filter("slip", "Tue B"),
    nobody: filter("zzz"), again: filter(""),
    hidden: view.getComputedStyle(page.querySelector(".desk code")).display,
  };
  await press(".desk button");
  await press("h3 button");
  filter("second");
  await press("h3 button");
  clipboard.writeText = async () => { throw new Error("not allowed"); };
  await press(".desk button");
  const area = page.querySelector("textarea");
  out.copied = copied;
  out.by_hand = area.value.slice(area.selectionStart, area.selectionEnd);
  const place = document.createElement("pre");
  place.id = "out"; place.textContent = JSON.stringify(out); document.body.append(place);
});
</script>"""


@needs_browser
def test_page_on_a_phone_filters_sorts_and_copies(tmp_path: Path) -> None:
    found = three()
    sections = {"g": "Mon A", "s": "Tue B", "w": "Tue B", "v": "Mon A"}
    grades = [
        replace(GOOD, student="g", name="Gööd"),
        *found.grades[1:],
        replace(WAITING, student="v", name="Second <i>" + 30 * "long"),
    ]
    grades = [replace(one, section=sections[one.student]) for one in grades]
    people = {one.student: Person(one.student, one.name, one.section, "", ()) for one in grades}
    roster = Roster(people, (Person("x", "Gone, Ida", "Tue B", "", ()),))
    whole = replace(a_class(grades, found.flags), roster=roster)
    out = look_at(tmp_path, page_of(whole), 390, PROBE)
    long = grades[3].name
    assert out["up"] == ["Slip", "Gööd", "Waiting", long], "blank ones last"
    assert out["down"] == ["Gööd", "Slip", "Waiting", long]
    assert out["names"] == ["Gööd", long, "Slip", "Waiting"]
    assert out["aria"] == ["ascending", None]

    assert out["choices"] == ["", "Mon A", "Tue B"]
    assert out["all"] == out["again"] == [[2, 1, 1], out["names"], ["Gone, Ida"]]
    assert out["told"] == "4 for you to decide, 4 of 4 students"
    assert out["name"] == [[1], ["Gööd", "Slip"], []], "the pair, and both of it"
    assert out["reason"] == [[1], ["Gööd", "Slip"], []]
    assert out["section"] == [[1, 1, 1], ["Slip", "Waiting"], ["Gone, Ida"]]
    assert out["both"] == [[1, 1], ["Slip"], []]
    assert out["nobody"] == [[], [], []]

    assert out["hidden"] == "none"
    why = str(WAITING.why).replace('"', '""')
    lines = [f'{key},total,,,"{why}"\n' for key in ("w", "v")]
    assert out["copied"] == [lines[0], "".join(lines), lines[1]]
    assert out["by_hand"] == lines[0]


def test_what_the_desk_says_waits_no_longer(tmp_path: Path) -> None:
    lab = Lab(tmp_path)
    lab.grade()
    lines = [line for group in groups_of(lab.page) for line in group.lines]
    flagged = ["4 + 5 + 7", "flag", ""]
    assert [line[:3] for line in lines if line[1] == "flag"] == [flagged]
    assert len(tables_of(lab.page)) == 2, "each log that joins is shown once"
    decided = {"flag": "partners", "reported": "4.4e-3 kg m^2", "total": "9"}
    lab.desk([[line[0], line[1], line[2] or decided[line[1]], "Ann", ""] for line in lines])
    lab.grade()
    assert todo_of(lab.out) == []
    assert "Nothing: all are graded, and nothing is flagged." in seen(lab.page)
    assert 'class="flag"' not in lab.page, "they are partners"
    for line in (["4", "hold", "", "Ann", ""], ["4", "partner", "5", "Ann", ""]):
        lab.desk([line])
        lab.grade()
        assert [one[:3] for one in todo_of(lab.out) if one[1] == "flag"] == [flagged], "the others still wait"
    lab.desk([[key, "hold", "", "Ann", ""] for key in "457"])
    lab.grade()
    assert not any(group.reason.startswith("flag") for group in groups_of(lab.page))
    assert "Flags that desk.csv has decided about (1) shared rows: Four , Five , s7 : 9 of 9 rows" in seen(lab.page)
