"""The page on which a person decides: what is decided there is what gyro reads.

In a real browser; the names, answers and files of the class try to run scripts.
"""

from __future__ import annotations

import csv
import io
import json
import re
from pathlib import Path

import pytest
from browser import look_at, needs_browser
from grading.students_reports import a_log
from grading.test_class_page import Lab, make_folder
from places import DATA

from gyrodata.grading.rubric import default_rubric_text

PROBE = (DATA / "probe_of_review.html").read_text(encoding="utf-8")
SCRIPT = "<script>window.ran=1</script></script><!--<img src=x onerror=ran=1>"


def hostile_lab(home: Path) -> Lab:
    """A class of eight with a copy, three logs without an answer, and an empty one."""
    logs = {f"s{i}/lab.csv": a_log(i, "# station: 3") for i in range(6)}
    for i in (2, 3, 4):
        logs[f"s{i}/lab.csv"] = re.sub(
            "# reported_inertia.*\n", "", logs[f"s{i}/lab.csv"]
        )
    logs["s5/lab.csv"] += f"# note: {SCRIPT}\n# {SCRIPT}: {SCRIPT}\n"
    logs["s6/lab.csv"] = logs["s1/lab.csv"]
    logs["=s7/lab.csv"] = ""
    logs["=s7/<img src=x onerror=ran=1>.txt"] = SCRIPT
    lab = Lab(home, logs)
    people = [["student", "name", "section", "ta"]]
    people += [[f"s{i}", f"{SCRIPT} {i}", SCRIPT, "Ann"] for i in range(7)]
    text = io.StringIO()
    csv.writer(text).writerows(people)
    make_folder(home, {"roster.csv": text.getvalue()})
    lab.options += ("--roster", str(home / "roster.csv"))
    lab.out.mkdir()
    return lab


@pytest.mark.slow
@needs_browser
def test_decisions_of_the_page_are_read_by_the_next_run(tmp_path: Path) -> None:
    lab = hostile_lab(tmp_path)
    kept = 's0,comment,"a, ""b""\nc",Bob,\'=1+1,"last year, too"'
    lab.decide(
        kept, "s5,regrade,,,=please look; -1", head="student,what,value,by,why,x"
    )
    page = lab.read("class.html")
    wide, out = (look_at(tmp_path, page, width, PROBE) for width in (1280, 390))
    for shown in ("ran", "seen", "told", "refused", "unlabelled", "actions", "added"):
        assert wide[shown] == out[shown]
    assert out["ran"] == 0
    assert [what for _, what, _ in out["seen"]].count("reported") == 3
    assert {what for _, what, _ in out["seen"]} == {
        "total",
        "reported",
        "regrade",
        "flag",
    }
    assert all(tag in ("INPUT", "TEXTAREA", "BUTTON") for *_, tag in out["seen"])
    assert out["told"].startswith("No question is open")
    assert out["refused"] == ["write a number of points from 0 to 20", "true"]
    assert out["unlabelled"] == 0
    assert not out["sent_on"], "the Enter behind the name decides nothing"
    # The name and Enter; a word and Enter for a total; three words for I_zz, and for the answer.
    assert out["actions"] == 1 + 1 + 2 + 3 * 4 + 4 + 1
    first, last = out["files"]
    (lab.out / "desk.csv").write_text(first, encoding="utf-8")
    lab.grade()
    assert lab.todo == []
    assert lab.graded("=s7", "s2", "s3", "s4", what="status") == ["graded"] * 4
    assert lab.graded("=s7") == [12.5]
    asked = "You asked: =please look; -1. Answer: =1+1"
    told = f'{asked}, "no" it &lt;i&gt;stays&lt;/i&gt;. (Ann)'
    assert told in lab.read("feedback/s5/feedback.md")
    (lab.out / "desk.csv").write_text(last, encoding="utf-8")
    lab.grade()
    comments = [
        one["value"]
        for student in lab.graded(*(f"s{i}" for i in range(7)), "=s7", what="by_hand")
        for one in student
        if one["what"] == "comment"
    ]
    assert out["added"] == "Added: 2 lines."
    assert 'a, "b"\nc' in comments
    assert "=other" in comments
    assert lab.graded("s1", what="late_deduction") == [0.5]
    assert lab.graded("=s7") == [12.5], "what is decided here goes before a file"
    assert '-1 point; =cmd, "quoted"\nnext line' in comments
    lines = list(csv.DictReader(io.StringIO(lab.read("desk.csv").lstrip("\ufeff"))))
    assert "last year, too" in [one["x"] for one in lines]
    assert "R 1" in [one["room"] for one in lines]


@pytest.mark.slow
def test_policy_allows_this_style_and_this_script_only(tmp_path: Path) -> None:
    lab = hostile_lab(tmp_path)
    lab.grade()
    page = lab.read("class.html")
    assert "unsafe" not in page
    assert page.count("sha256-") == 2
    assert page.count("</script>") == page.count("<script") == 2
    island = page.partition('id="data">')[2].partition("</script>")[0]
    assert not set("<\u202e") & set(island)
    assert {one["id"] for one in json.loads(island)["students"]} == {
        "=s7",
        *(f"s{i}" for i in range(7)),
    }
    lab.grade()
    assert lab.read("class.html") == page


QUESTIONS = """<script>
addEventListener("load", () => {
  const frame = document.querySelector("iframe"), view = frame.contentWindow;
  const page = frame.contentDocument, told = page.getElementById("told");
  const press = field => field.dispatchEvent(
    new view.KeyboardEvent("keydown", {key: "Enter", bubbles: true, cancelable: true}));
  const who = () => page.getElementById("who").textContent;
  const by = page.getElementById("by");
  [...page.querySelectorAll("button")].find(e => /^Previous/.test(e.textContent)).click();
  const out = {first: who(), wide: page.documentElement.scrollWidth,
    inner: frame.clientWidth, beyond: []};
  by.value = "Ann";
  by.focus();
  press(by);
  out.next = who();
  out.labels = [...page.querySelectorAll("#questions label")].map(e => e.textContent);
  out.buttons = [...page.querySelectorAll("#questions button")].map(e => e.textContent);
  press([...page.querySelectorAll("#questions .why")].find(e => !e.form));
  out.told = told.textContent;
  const place = document.createElement("pre");
  place.id = "out";
  place.textContent = JSON.stringify(out);
  document.body.append(place);
});
</script>"""


@pytest.mark.slow
@needs_browser
def test_the_name_leads_to_a_question_and_questions_say_what_is_asked(
    tmp_path: Path,
) -> None:
    logs: dict[str, str | bytes] = {f"s{i}/lab.csv": a_log(i) for i in range(6)}
    lab = Lab(tmp_path, {**logs, "s6/lab.csv": a_log(1)})
    (tmp_path / "rubric.toml").write_text(
        default_rubric_text("manual"), encoding="utf-8"
    )
    lab.options += ("--rubric", str(tmp_path / "rubric.toml"))
    lab.out.mkdir()
    lab.decide("s0,report,3,Ann,clear")
    out = look_at(tmp_path, lab.read("class.html"), 1280, QUESTIONS)
    assert [out["first"], out["next"]] == ["s0", "s1"]
    assert "The report is clear (0 to 5) " in out["labels"]
    assert "Keep gyro's result" not in out["buttons"]
    assert (
        out["told"] == "Press one of the buttons: partners, copied, invented, cleared."
    )
