"""The page of a class: whole, escaped, saying what the grades say, and with every line that waits for a person."""

from __future__ import annotations

import csv
import html
import io
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from browser import look_at, needs_browser
from grading.classes import make_folder
from grading.reports import RIGHT, STATED, Sheet, reported_line, sheet, three_logs
from grading.test_feedback import Page
from msgspec.structs import astuple, replace
from typer.testing import CliRunner, Result

from gyrodata.cli import app

EVIL = ['<script>alert("x")</script>', "</title><b>", "{{ 7 * 7 }}", "\u202egnp.exe", "a\x1b[31m"]
HEAD = ["student", "what", "value", "by", "why"]
BOOK = [
    *csv.reader(["Student,ID,SIS User ID,SIS Login ID,Section,Gyroscope lab (1)", "Points Possible,,,,,20.00"]),
    ["Adler, Nina", "1", "", "", "Mon A", "12"],
    ['O\'Brien "X", <b>Seán', "2", "", "", "Tue B", "25"],
    *([name, str(i), "", "", name, ""] for i, name in enumerate(EVIL, 3)),
    ["Gone", "9", "", "", "Mon A", ""],
]


def write_csv(path: Path, rows: Sequence[Sequence[str]]) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(rows)


def seen(page: str) -> str:
    """The words of a page."""
    text = re.sub(r"<(style|script).*?</\1>", "", page, flags=re.DOTALL)
    return " ".join(html.unescape(re.sub(r"<[^>]+>", " ", text)).split())


class Lab:
    """A class with something of everything, three logs that are one among it; the folder of its grades."""

    def __init__(self, home: Path) -> None:
        self.root, self.out, self.home = home / "class", home / "grades", home
        rows = [sheet(np.random.default_rng(i), "mixed") for i in range(7)]
        mixed = np.random.default_rng(1).permutation(len(rows[4].mass))
        rows[5] = Sheet(*(column[mixed] for column in astuple(rows[4])))
        logs = [one.log(reported_line(*RIGHT.inertia(one, "with_constant"))) for one in rows]
        value, u = RIGHT.inertia(rows[3], "with_constant")
        logs[1], logs[2], logs[3] = rows[1].log(), "", rows[3].log(reported_line(1.3 * value, u))
        make_folder(self.root, {f"s{i}_{i}_{i}_lab.csv": log for i, log in enumerate([*logs, logs[4]]) if i})
        make_folder(self.root, {"s1_1_1_report.pdf": b"%PDF-1.4"})
        write_csv(home / "book.csv", BOOK)
        (home / "rubric.toml").write_text(re.sub("title = .*", f"title = '{EVIL[0]}'", STATED, count=1), "utf-8")

    def grade(self) -> Result:
        given = ("--workers", "1", "--gradebook", self.home / "book.csv", "--rubric", self.home / "rubric.toml")
        done = CliRunner().invoke(app, list(map(str, ("grade", self.root, "-o", self.out, *given))))
        assert done.exit_code in (0, 1), done.stderr
        return done

    def desk(self, lines: Sequence[Sequence[str]]) -> None:
        write_csv(self.out / "desk.csv", [HEAD, *lines])
        self.grade()

    @property
    def page(self) -> str:
        return (self.out / "class.html").read_text(encoding="utf-8")

    @property
    def todo(self) -> list[list[str]]:
        return list(csv.reader(io.StringIO((self.out / "desk-todo.csv").read_text(encoding="utf-8"))))[1:]

    @property
    def groups(self) -> dict[str, list[list[str]]]:
        """Cells of the lines to be copied, by what the page says of them."""
        found = {}
        for part in re.findall(r'<section class="group.*?</section>', self.page, re.DOTALL):
            count, reason = re.findall(r'<span class="count">(\d+)</span> × <span class="k">(.*?)</span>', part)[0]
            codes = re.findall(r'<p class="desk">.*?<code>(.*?)</code></p>', part)
            found[html.unescape(reason)] = list(csv.reader(html.unescape(code) for code in codes))
            assert len(codes) == int(count)
        return found


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Lab:
    lab = Lab(tmp_path_factory.mktemp("lab"))
    lab.grade()
    table = lab.out / "grades.csv"
    # Somebody sets points by hand, one of them more than there are.
    changed = re.sub(r"^(4,.*?graded),20.00", r"\1,13.50", table.read_text(encoding="utf-8"), flags=re.MULTILINE)
    table.write_text(re.sub(r"^(6,.*?graded),20.00", r"\1,99", changed, flags=re.MULTILINE), encoding="utf-8")
    lab.grade()
    return lab


def test_structure_is_sound_and_nothing_comes_from_outside(lab: Lab) -> None:
    tags = Page(lab.page).tags
    assert [tag for tag, _ in tags].count("h1") == 1
    assert all(attributes.get("scope") for tag, attributes in tags if tag == "th")
    links = {str(attributes["href"]) for tag, attributes in tags if tag == "a"}
    assert {link[1:] for link in links if link[0] == "#"} == {one["id"] for _, one in tags if "id" in one}
    assert {f"feedback/s{i}_{i}_{i}_lab.html" for i in range(1, 8)} < links
    assert not any(key.startswith("on") or key == "src" for _, attributes in tags for key in attributes)
    assert not re.search(r"https?://|url\(|@import", lab.page)


def test_names_and_reasons_stay_text(lab: Lab) -> None:
    for bad in ("<script>alert", "</title><b>", "\u202e", "\x1b", " 49 "):
        assert bad not in lab.page
    assert '<bdi>O&#39;Brien &#34;X&#34;, &lt;b&gt;Seán</bdi></a> <span class="sec">Tue B</span>' in lab.page
    assert seen(lab.page).count("{{ 7 * 7 }}") >= 2


def brightness(colour: str) -> float:
    """Relative luminance (WCAG 2.2)."""
    parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def test_contrast_in_every_theme(lab: Lab) -> None:
    themes = re.findall(r":root \{(.*?)\}", lab.page)
    assert len(themes) == 3
    for theme in themes:
        colours = {name: brightness(colour) for name, colour in re.findall(r"--([\w-]+): (#\w{6})", theme)}
        for pair in ("ink paper", "soft paper", "mark paper", "ink warn-paper", "ink band", "soft warn-paper",
                     "mark warn-paper", "warn paper", "mark band"):  # fmt: skip
            low, high = sorted(colours[name] for name in pair.split())
            assert (high + 0.05) / (low + 0.05) >= (3 if pair in ("warn paper", "mark band") else 4.5), pair


# --- what waits for a person --------------------------------------------------------------------------------


def test_groups_and_counts_are_those_of_the_lines_that_wait(lab: Lab) -> None:
    assert {reason: len(lines) for reason, lines in lab.groups.items()} == {
        "grades.csv was changed by hand": 2,
        "other points stand in the gradebook": 2,
        "no grade: the log cannot be used": 1,
        "no grade: no I_zz is reported": 1,
        "the reported I_zz is … u from the student's own runs": 1,
        "flag: shared rows": 1,
    }
    lines = [line for group in lab.groups.values() for line in group]
    assert sorted(" ".join(",".join(line[:5]).split()) for line in lines) == sorted(
        " ".join(",".join(line[:5]).split()) for line in lab.todo
    )
    offered = {line[0]: line[2] for line in lines if line[1] == "total" and line[0] in "1246"}
    assert offered == {"1": "12.00", "2": "", "4": "13.50", "6": ""}, "25 and 99 of 20 points are told, and not offered"
    assert "s1_1_1_report.pdf" in lab.page


def test_what_the_desk_says_waits_no_longer(tmp_path: Path) -> None:
    lab = Lab(tmp_path)
    lab.grade()
    lines = [line for group in lab.groups.values() for line in group]
    flagged = ["4 + 5 + 7", "flag", ""]
    assert [line[:3] for line in lines if line[1] == "flag"] == [flagged]
    assert lab.page.count('<table class="beside">') == 2, "each log that joins is shown once"
    decided = {"flag": "partners", "reported": "4.4e-3 kg m^2", "total": "9"}
    lab.desk([[line[0], line[1], line[2] or decided[line[1]], "Ann", ""] for line in lines])
    assert lab.todo == []
    assert "Nothing: all are graded, and nothing is flagged." in seen(lab.page)
    assert 'class="flag"' not in lab.page, "they are partners"
    for line in (["4", "hold", "", "Ann", ""], ["4", "partner", "5", "Ann", ""]):
        lab.desk([line])
        assert [one[:3] for one in lab.todo if one[1] == "flag"] == [flagged], "the others still wait"
    lab.desk([[key, "hold", "", "Ann", ""] for key in "457"])
    assert not any(reason.startswith("flag") for reason in lab.groups)
    assert "Flags that desk.csv has decided about (1) shared rows: " in seen(lab.page)


# --- two logs side by side ----------------------------------------------------------------------------------


def test_marked_are_the_cells_that_are_equal_and_no_others(tmp_path: Path) -> None:
    random = np.random.default_rng(7)
    first, own = sheet(random, "mixed"), sheet(random, "mixed")
    half = random.permutation(len(first.mass)) < 6
    spin, time = np.where(half, first.spin, own.spin), np.where(half, first.time, own.time)
    logs = {"a": first, "b": replace(first, spin=spin, time=time)} | {f"c{i}": sheet(random, "mixed") for i in range(6)}
    make_folder(tmp_path / "class", {f"{name}/lab.csv": rows.log() for name, rows in logs.items()})
    CliRunner().invoke(app, ["grade", str(tmp_path / "class"), "-o", str(tmp_path / "out"), "--workers", "1"])
    page = (tmp_path / "out" / "class.html").read_text(encoding="utf-8")
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
def test_page_on_a_phone_filters_sorts_and_copies(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    long = "Second <i>" + 30 * "long"
    good, slip, bad = three_logs().values()
    logs = {"g": good, "s": slip, "w": bad, "v": bad}
    make_folder(tmp_path, {"rubric.toml": STATED} | {f"class/{key}/lab.csv": log for key, log in logs.items()})
    people = ["student,name,section", "g,Gööd,Mon A", "s,Slip,Tue B", "w,Waiting,Tue B", f"v,{long},Mon A",
              'x,"Gone, Ida",Tue B']  # fmt: skip
    (tmp_path / "roster.csv").write_text("\n".join(people), encoding="utf-8")
    words = ["grade", "class", "-o", "grades", "--workers", "0", "--roster", "roster.csv", "--rubric", "rubric.toml"]
    monkeypatch.chdir(tmp_path)
    CliRunner().invoke(app, words)
    out = look_at(tmp_path, (tmp_path / "grades" / "class.html").read_text(encoding="utf-8"), 390, PROBE)
    assert out["up"] == ["Slip", "Gööd", long, "Waiting"], "blank ones last"
    assert out["down"] == ["Gööd", "Slip", long, "Waiting"]
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
    lines = list(csv.reader(out["copied"][1].splitlines()))
    assert [line[:2] for line in lines] == [["v", "total"], ["w", "total"]]
    assert out["by_hand"] == out["copied"][0] == out["copied"][1].splitlines(keepends=True)[0]
    assert out["copied"][2:] == [out["copied"][0]]
