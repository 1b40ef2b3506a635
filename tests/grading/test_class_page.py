"""The page of a class and the desk: all that waits for a person is said, and what a person decides stays.

The page is whole and escaped, and says what the grades say.
"""

from __future__ import annotations

import csv
import html
import io
import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from browser import look_at, needs_browser
from grading.classes import make_folder
from grading.reports import RIGHT, STATED, Sheet, reported_line, sheet, three_logs
from msgspec.structs import astuple, replace
from pages import Structure
from typer.testing import CliRunner, Result

from gyrodata import schema
from gyrodata.cli import app
from gyrodata.grading import default_rubric_text

EVIL = ['<script>alert("x")</script>', "</title><b>", "{{ 7 * 7 }}", "\u202egnp.exe", "a\x1b[31m"]
BOOK = [
    *csv.reader(["Student,ID,SIS User ID,SIS Login ID,Section,Gyroscope lab (1)", "Points Possible,,,,,20.00"]),
    ["Adler, Nina", "1", "", "", "Mon A", "12"],
    ['O\'Brien "X", <b>Seán', "2", "", "", "Tue B", "25"],
    *([name, str(i), "", "", name, ""] for i, name in enumerate(EVIL, 3)),
    ["Gone", "9", "", "", "Mon A", ""],
]
HEAD = "student,what,value,by,why"


def as_csv(rows: Sequence[Sequence[str]]) -> str:
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows(rows)
    return out.getvalue()


class Lab:
    """A class, and the folder of its grades."""

    def __init__(self, home: Path, files: Mapping[str, str | bytes]) -> None:
        self.root, self.out = make_folder(home / "class", files), home / "grades"
        self.options: tuple[str, ...] = ("--workers", "1")

    def grade(self) -> Result:
        done = CliRunner().invoke(app, ["grade", str(self.root), "-o", str(self.out), *self.options])
        assert done.exit_code in (0, 1), done.stderr
        return done

    def decide(self, *lines: str, head: str = HEAD) -> str:
        (self.out / "desk.csv").write_text("\n".join([head, *lines, ""]), encoding="utf-8")
        return self.grade().stderr

    def read(self, name: str) -> str:
        return (self.out / name).read_text(encoding="utf-8")

    def graded(self, *students: str, what: str = "points") -> list[Any]:
        document = json.loads(self.read("grades.json"))
        jsonschema.validate(document, schema.grades_schema())
        return [one[what] for one in document["students"] if one["student"] in students]

    @property
    def todo(self) -> list[list[str]]:
        return list(csv.reader(io.StringIO(self.read("desk-todo.csv"))))[1:]

    @property
    def groups(self) -> dict[str, list[list[str]]]:
        """Cells of the lines to be copied, by what the page says of them."""
        found = {}
        for part in re.findall(r'<section class="group.*?</section>', self.read("class.html"), re.DOTALL):
            count, reason = re.findall(r'<span class="count">(\d+)</span> × <span class="k">(.*?)</span>', part)[0]
            codes = re.findall(r'<p class="desk">.*?<code>(.*?)</code></p>', part)
            found[html.unescape(reason)] = list(csv.reader(html.unescape(code) for code in codes))
            assert len(codes) == int(count)
        return found


def a_log(seed: int) -> str:
    rows = sheet(np.random.default_rng(seed), "mixed")
    return rows.log("# station: 3", reported_line(*RIGHT.inertia(rows, "with_constant")))


@pytest.fixture
def lab(tmp_path: Path) -> Lab:
    """A class of four, the third without an answer in its log."""
    logs = {f"s{i}/lab.csv": a_log(i) for i in range(4)}
    logs["s2/lab.csv"] = re.sub("# reported_inertia.*\n", "", logs["s2/lab.csv"])
    lab = Lab(tmp_path, {**logs, "s2/report.pdf": b"%PDF-1.4"})
    lab.grade()
    return lab


def full_lab(home: Path) -> Lab:
    """A class with something of everything, three logs that are one among it."""
    rows = [sheet(np.random.default_rng(i), "mixed") for i in range(7)]
    mixed = np.random.default_rng(1).permutation(len(rows[4].mass))
    rows[5] = Sheet(*(column[mixed] for column in astuple(rows[4])))
    logs = [one.log(reported_line(*RIGHT.inertia(one, "with_constant"))) for one in rows]
    value, u = RIGHT.inertia(rows[3], "with_constant")
    logs[1], logs[2], logs[3] = rows[1].log(), "", rows[3].log(reported_line(1.3 * value, u))
    files = {f"s{i}_{i}_{i}_lab.csv": log for i, log in enumerate([*logs, logs[4]]) if i}
    lab = Lab(home, files | {"s1_1_1_report.pdf": "%PDF-1.4"})
    (home / "book.csv").write_text(as_csv(BOOK), encoding="utf-8")
    (home / "rubric.toml").write_text(re.sub("title = .*", f"title = '{EVIL[0]}'", STATED, count=1), "utf-8")
    lab.options += ("--gradebook", str(home / "book.csv"), "--rubric", str(home / "rubric.toml"))
    lab.grade()
    return lab


@pytest.fixture(scope="module")
def full(tmp_path_factory: pytest.TempPathFactory) -> Lab:
    lab = full_lab(tmp_path_factory.mktemp("lab"))
    # Somebody sets points by hand, one of them more than there are.
    changed = re.sub(r"^(4,.*?graded),20.00", r"\1,13.50", lab.read("grades.csv"), flags=re.MULTILINE)
    changed = re.sub(r"^(6,.*?graded),20.00", r"\1,99", changed, flags=re.MULTILINE)
    (lab.out / "grades.csv").write_text(changed, encoding="utf-8")
    lab.grade()
    return lab


def test_structure_is_sound_and_nothing_comes_from_outside(full: Lab) -> None:
    page = full.read("class.html")
    tags = Structure(page).tags
    assert [tag for tag, _ in tags].count("h1") == 1
    assert all(attributes.get("scope") for tag, attributes in tags if tag == "th")
    links = {str(attributes["href"]) for tag, attributes in tags if tag == "a"}
    assert {link[1:] for link in links if link[0] == "#"} == {one["id"] for _, one in tags if "id" in one}
    assert {f"feedback/s{i}_{i}_{i}_lab.html" for i in range(1, 8)} < links
    assert not any(key.startswith("on") or key == "src" for _, attributes in tags for key in attributes)
    assert not re.search(r"https?://|url\(|@import", page)


def test_names_and_reasons_stay_text(full: Lab) -> None:
    page = full.read("class.html")
    for bad in ("<script>alert", "</title><b>", "\u202e", "\x1b", " 49 "):
        assert bad not in page
    assert '<bdi>O&#39;Brien &#34;X&#34;, &lt;b&gt;Seán</bdi></a> <span class="sec">Tue B</span>' in page
    assert page.count("{{ 7 * 7 }}") >= 2


def test_contrast_is_enough_in_every_theme(full: Lab) -> None:
    themes = re.findall(r":root \{(.*?)\}", full.read("class.html"))
    assert len(themes) == 3
    for theme in themes:
        light = {}
        for name, digits in re.findall(r"--([\w-]+): #(\w{6})", theme):
            parts = np.array([int(digits[i : i + 2], 16) / 255 for i in (0, 2, 4)])
            linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
            light[name] = linear @ [0.2126, 0.7152, 0.0722] + 0.05  # relative luminance (WCAG 2.2)
        for pair in ("ink paper", "soft paper", "mark paper", "ink warn-paper", "ink band", "soft warn-paper",
                     "mark warn-paper", "warn paper", "mark band"):  # fmt: skip
            low, high = sorted(light[name] for name in pair.split())
            assert high / low >= (3 if pair in ("warn paper", "mark band") else 4.5), pair


# --- what waits for a person, and what is decided -----------------------------------------------------------


def test_groups_and_counts_are_those_of_the_lines_that_wait(full: Lab) -> None:
    assert {reason: len(lines) for reason, lines in full.groups.items()} == {
        "grades.csv was changed by hand": 2,
        "other points stand in the gradebook": 2,
        "no grade: the log cannot be used": 1,
        "no grade: no I_zz is reported": 1,
        "the reported I_zz is … u from the student's own runs": 1,
        "flag: shared rows": 1,
    }
    lines = [line for group in full.groups.values() for line in group]
    assert sorted(" ".join(",".join(line[:5]).split()) for line in lines) == sorted(
        " ".join(",".join(line[:5]).split()) for line in full.todo
    )
    offered = {line[0]: line[2] for line in lines if line[1] == "total" and line[0] in "1246"}
    assert offered == {"1": "12.00", "2": "", "4": "13.50", "6": ""}, "25 and 99 of 20 points are told, and not offered"
    assert "s1_1_1_report.pdf" in full.read("class.html")


def test_what_the_desk_says_waits_no_longer(tmp_path: Path) -> None:
    lab = full_lab(tmp_path)
    lines = [line for group in lab.groups.values() for line in group]
    flagged = ["4 + 5 + 7", "flag", ""]
    assert [line[:3] for line in lines if line[1] == "flag"] == [flagged]
    assert lab.read("class.html").count('<table class="beside">') == 2, "each log that joins is shown once"
    decided = {"flag": "partners", "reported": "4.4e-3 kg m^2", "total": "9"}
    lab.decide(as_csv([[line[0], line[1], line[2] or decided[line[1]], "Ann", ""] for line in lines]))
    assert lab.todo == []
    assert "Nothing: all are graded, and nothing is flagged." in lab.read("class.html")
    assert 'class="flag"' not in lab.read("class.html"), "they are partners"
    for line in ("4,hold,,Ann,", "4,partner,5,Ann,"):
        lab.decide(line)
        assert [one[:3] for one in lab.todo if one[1] == "flag"] == [flagged], "the others still wait"
    lab.decide(*(f"{key},hold,,Ann," for key in "457"))
    assert not any(reason.startswith("flag") for reason in lab.groups)
    assert "has decided about (1)" in lab.read("class.html")


def test_resubmission_is_told_until_its_desk_line_changes(lab: Lab) -> None:
    lab.decide("s0,total,16,Ann,agreed")
    assert lab.graded("s0", what="look") == [[]]
    (lab.root / "s0" / "lab.csv").write_text(a_log(9))
    for _ in range(2):
        lab.grade()
        ((look,),) = lab.graded("s0", what="look")
        assert look.startswith("resubmitted since total 16 was set by hand")
        assert lab.graded("s0") == [16]
        assert "\ns0,total,,,resubmitted" in lab.read("desk-todo.csv")
    lab.decide("s0,total,16,Ann,agreed; still right")
    assert lab.graded("s0", what="look") == [[]]


def test_a_decision_that_is_taken_back_leaves_nothing(lab: Lab) -> None:
    first = {path: path.read_bytes() for path in lab.out.rglob("*") if path.is_file() and "published" not in str(path)}
    told = lab.decide("s0,total,16,,", "s2,reported,4.44e-3 ± 0.05e-3 kg m^2,,", "s3,station,9,,", "s1,hold,,,")
    assert "graded 1 (the desk changed): s2" in told
    assert lab.graded("s0", "s1", "s2", what="status") == ["graded", "on hold", "graded"]
    lab.decide()
    del first[lab.out / "journal.ndjson"]
    assert {path: path.read_bytes() for path in first} == first


def test_what_is_on_hold_shows_no_points(lab: Lab) -> None:
    assert "of 20 points" in lab.read("feedback/s1/feedback.md")
    lab.decide("s1,hold,,Ann,copied?", "s1,comment,Come and see me.,Ann,")
    assert "Your grade is on hold." in lab.read("feedback/s1/feedback.md")
    assert "Come and see me. (Ann)" in lab.read("feedback/s1/feedback.md")
    assert not any(word in lab.read("feedback/s1/feedback.md") for word in ("copied", "points", "20"))


def test_points_by_hand_complete_a_rubric_with_a_manual_part(lab: Lab, tmp_path: Path) -> None:
    (tmp_path / "rubric.toml").write_text(default_rubric_text("manual"), encoding="utf-8")
    lab.options += ("--rubric", str(tmp_path / "rubric.toml"))
    assert "3 so far, 1 not" in lab.grade().stdout
    assert lab.graded("s0") == [15]
    assert "15 of 20 points so far; to come: The report is clear (5)." in lab.read("feedback/s0/feedback.md")
    todo = lab.read("desk-todo.csv").splitlines()
    assert "s0,report,,,a person gives these points,s0,lab.csv" in todo
    assert any(line.startswith("s2,reported,,,no reported I_zz") and line.endswith("s2,report.pdf") for line in todo)
    lab.decide(*(f"s{i},report,{i + 1.5},Ann,clear" for i in range(3)))
    assert lab.graded("s0", "s2") == [16.5, None]
    assert "1.5 of 5 | Given by hand: clear (Ann)" in lab.read("feedback/s0/feedback.md")
    assert "s0," not in lab.read("desk-todo.csv")


def test_a_page_of_feedback_that_somebody_wrote_in_is_kept(lab: Lab) -> None:
    archive, page = lab.out / "feedback.zip", lab.out / "feedback" / "s0" / "feedback.md"
    archive.write_bytes(archive.read_bytes()[:-10])
    page.write_text(page.read_text(encoding="utf-8") + "well done\n", encoding="utf-8")
    told = lab.grade().stderr
    assert "feedback/s0/feedback.md was changed by hand; what it was is kept as published/feedback/" in told
    (kept,) = (lab.out / "published" / "feedback").rglob("*.md")
    assert kept.read_text(encoding="utf-8").endswith("well done\n")
    assert "was changed by hand" not in lab.decide("s0,total,3,,"), "gyro wrote it last"


def test_tables_as_a_spreadsheet_saves_them_are_read(lab: Lab) -> None:
    table = lab.out / "grades.csv"
    table.write_text(table.read_text().replace(".00,", ",").replace(",", ";"), encoding="utf-8")
    lab.decide("S0;total;12,5;x", ";;;", "s1;comment;'=1+1;", "s1;total;;", head="\ufeffStudent;What;Value;Look")
    assert lab.graded("s0", "s1") == [12.5, 20]
    assert "=1+1" in lab.read("feedback/s1/feedback.md")
    assert "set by hand" not in lab.read("desk-todo.csv")


# --- two logs side by side ----------------------------------------------------------------------------------


def test_marked_are_the_cells_that_are_equal_and_no_others(tmp_path: Path) -> None:
    random = np.random.default_rng(7)
    first, own = sheet(random, "mixed"), sheet(random, "mixed")
    half = random.permutation(len(first.mass)) < 6
    spin, time = np.where(half, first.spin, own.spin), np.where(half, first.time, own.time)
    logs = {"a": first, "b": replace(first, spin=spin, time=time)} | {f"c{i}": sheet(random, "mixed") for i in range(6)}
    lab = Lab(tmp_path, {f"{name}/lab.csv": rows.log() for name, rows in logs.items()})
    lab.grade()
    page = lab.read("class.html")
    (table,) = re.findall(r'<table class="beside">.*?<tbody>(.*?)</tbody>', page, re.DOTALL)
    shown, spins = [], 0
    for row in re.findall(r"<tr>(.*?)</tr>", table):
        marked = ["<mark>" in cell for cell in re.findall(r"<td>(.*?)</td>", row)]
        torque, *cells = [re.sub("<.*?>", "", cell) for cell in re.findall(r"<td>(.*?)</td>", row)]
        for name, (line, *numbers) in (("a", cells[:4]), ("b", cells[4:])):
            mass, position, *told = logs[name].log().splitlines()[int(line) - 1].split(",")
            assert told == numbers, "as typed"
            assert float(torque) == pytest.approx(float(mass) * 9.803 * float(position) / 100, rel=1e-3)
            shown.append((name, int(line)))
        for at in (1, 2):
            assert marked[1 + at] == marked[5 + at] == (cells[at] == cells[4 + at])
        spins += marked[2]
    assert sorted(shown) == [(name, line) for name in "ab" for line in range(3, 3 + len(first.mass))]
    assert spins >= 6
    assert f"{spins} of {len(first.mass)} spins" in page


# --- in a browser -------------------------------------------------------------------------------------------

PROBE = """<script>
addEventListener("load", async () => {
  const frame = document.querySelector("iframe"), view = frame.contentWindow, page = frame.contentDocument;
  const table = page.querySelector("table.everybody"), heads = [...table.tHead.rows[0].cells];
  const all = what => [...page.querySelectorAll(what)];
  const shown = () => [all(".group:not([hidden]) .count").map(e => Number(e.textContent)),
    [...table.tBodies[0].rows].filter(e => !e.hidden).map(e => e.cells[0].textContent),
    all(".people li:not([hidden])").map(e => e.firstChild.textContent)];
  const sort = i => { heads[i].querySelector("button").click(); return shown()[1]; };
  const [box, choice, told] = all(".filter input, .filter select, .filter output");
  const filter = (text, section = "") => {
    box.value = text; choice.value = section; box.dispatchEvent(new view.Event("input", {bubbles: true}));
    return shown();
  };
  const copied = [], clipboard = {writeText: async text => copied.push(text)};
  Object.defineProperty(view.navigator, "clipboard", {value: clipboard, configurable: true});
  const press = async what => { page.querySelector(what).click(); await new Promise(done => setTimeout(done, 50)); };
  const out = {
    wide: page.documentElement.scrollWidth, inner: frame.clientWidth,
    beyond: all("h1, h2, h3, h4, p, li, summary, svg, form *")
      .filter(e => e.getBoundingClientRect().right > frame.clientWidth).map(e => e.textContent),
    up: sort(2), down: sort(2), names: sort(0), aria: heads[0].getAttribute("aria-sort"), choices: choice.length,
    found: [filter(""), filter("  GÖÖD "), filter("flag shared"), filter("", "Tue B"), filter("slip", "Tue B"),
      filter("zzz"), filter("")], told: told.textContent,
    hidden: view.getComputedStyle(page.querySelector(".desk code")).display, copied: copied,
  };
  await press(".desk button"); await press("h3 button"); filter("second"); await press("h3 button");
  clipboard.writeText = async () => { throw new Error("not allowed"); };
  await press(".desk button");
  const area = page.querySelector("textarea"), place = document.createElement("pre");
  out.by_hand = area.value.slice(area.selectionStart, area.selectionEnd);
  place.id = "out"; place.textContent = JSON.stringify(out); document.body.append(place);
});
</script>"""


@needs_browser
def test_page_on_a_phone_filters_sorts_and_copies(tmp_path: Path) -> None:
    long = "Second <i>" + 30 * "long"
    good, slip, bad = three_logs().values()
    logs = {"g": good, "s": slip, "w": bad, "v": bad}
    lab = Lab(tmp_path, {f"{key}/lab.csv": log for key, log in logs.items()})
    people = [["g", "Gööd", "Mon A"], ["s", "Slip", "Tue B"], ["w", "Waiting", "Tue B"], ["v", long, "Mon A"]]
    people = [["student", "name", "section"], *people, ["x", "Gone, Ida", "Tue B"]]
    make_folder(tmp_path, {"roster.csv": as_csv(people), "rubric.toml": STATED})
    lab.options += ("--roster", str(tmp_path / "roster.csv"), "--rubric", str(tmp_path / "rubric.toml"))
    lab.grade()
    out = look_at(tmp_path, lab.read("class.html"), 390, PROBE)
    assert (out["up"], out["down"]) == (["Slip", "Gööd", long, "Waiting"], ["Gööd", "Slip", long, "Waiting"])
    names = ["Gööd", long, "Slip", "Waiting"]
    assert (out["names"], out["aria"], out["choices"], out["hidden"]) == (names, "ascending", 3, "none")
    everybody, pair = [[2, 1, 1], names, ["Gone, Ida"]], [[1], ["Gööd", "Slip"], []]
    of_section = [[[1, 1, 1], ["Slip", "Waiting"], ["Gone, Ida"]], [[1, 1], ["Slip"], []]]
    assert out["found"] == [everybody, pair, pair, *of_section, [[], [], []], everybody]
    assert out["told"] == "4 for you to decide, 4 of 4 students"
    one, both, after = out["copied"]
    assert [line[:2] for line in csv.reader(both.splitlines())] == [["v", "total"], ["w", "total"]]
    assert out["by_hand"] == one == after == both.splitlines(keepends=True)[0]
