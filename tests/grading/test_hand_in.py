"""`gyro check --hand-in`: what a student is told is what the grader reads, and advice
that is followed is enough.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from classes.class_cells import grade
from classes.drawn import draw
from classes.typed import HABITS, plain
from grading.classes import make_folder
from grading.test_pdf_reports import scanned
from schemas import assert_valid
from typer.testing import CliRunner

import gyrodata
from gyrodata.cli import app

STUDENT = draw(3, 5)
ANSWER = plain(*STUDENT.answer())
LOG = STUDENT.log()


def check(*arguments: str | Path) -> tuple[str, int]:
    done = CliRunner().invoke(
        app, ["check", "--hand-in", *map(str, arguments)], prog_name="gyro"
    )
    return done.stdout, done.exit_code


def told(*paths: Path) -> tuple[dict[str, Any], int]:
    text, code = check("--format", "json", *paths)
    document = json.loads(text)
    assert_valid(document, "check")
    return document, code


@pytest.mark.slow
def test_what_is_told_is_what_is_graded(tmp_path: Path) -> None:
    # What is typed into a field comes as a text.
    files = {
        f"s{i:02d}/{name.replace('receipt', 'receipt.txt')}": data
        for i, habit in enumerate(HABITS)
        for name, data in HABITS[habit](STUDENT, ANSWER).items()
    }
    root, graded = make_folder(tmp_path / "class", files), grade(files)["students"]
    for i, habit in enumerate(HABITS):
        folder = root / f"s{i:02d}"
        document, code = told(folder)
        read = document["hand_in"]
        assert told(*sorted(folder.iterdir()))[0]["hand_in"] == read, habit
        reported = graded[folder.name]["reported"]
        assert (read["inertia"], read["u"]) == (
            reported.get("value"),
            reported.get("u"),
        ), habit
        assert (read["inertia"] is None) == (habit == "PDF") == bool(code), habit


def test_an_answer_in_a_report_of_gyro_alone_is_a_warning(tmp_path: Path) -> None:
    page = gyrodata.analyze(LOG.encode())._repr_markdown_()
    files = {"lab.csv": LOG, "report.md": page}
    document, code = told(make_folder(tmp_path / "mine", files))
    (note,) = (one for one in document["diagnostics"] if one["code"] == "G719")
    assert (note["severity"], code) == ("warning", 1)
    assert "only a report of gyro analyze contains an answer" in note["message"]


@pytest.mark.parametrize(
    ("files", "place"),
    [
        ({"lab.csv": LOG + f"I_zz,{ANSWER}\n"}, "lab.csv, line 12"),
        (
            {"lab.csv": LOG, "report.txt": f"Our report.\n\nI_zz = {ANSWER}\n"},
            "report.txt, line 3",
        ),
    ],
)
def test_the_place_of_the_answer_is_told(
    files: Mapping[str, str], place: str, tmp_path: Path
) -> None:
    text, code = check(make_folder(tmp_path / "mine", files))
    value, u = re.findall(r"[\d.]+(?=e-3)", ANSWER)
    assert f"I_zz = ({value} ± {u}) × 10⁻³ kg·m², read from {place}; station: 4" in text
    assert text.endswith("lab.csv: 9 runs, with an answer (1 note)\n")
    assert code == 0


LACKING = {
    "none": {"lab.csv": LOG},
    "a PDF": {"lab.csv": LOG, "report.pdf": scanned()},
    "two in the log": {
        "lab.csv": "# I_zz = 4.4e-3 kg m^2\n# I_zz: 4.5e-3 kg m^2\n" + LOG
    },
    "no number": {"lab.csv": "# reported_inertia: see below\n" + LOG},
}


@pytest.mark.slow
@pytest.mark.parametrize("what", LACKING)
def test_the_advice_carried_out_is_enough(what: str, tmp_path: Path) -> None:
    root = make_folder(tmp_path / "mine", LACKING[what])
    document, code = told(root)
    assert code == 1
    found = next(one for one in document["diagnostics"] if one["code"] == "G719")
    assert ("two values" in found["message"]) == what.startswith("two")
    hint = found["hint"]
    assert hint in check(root)[0]
    path = root / re.findall(r"table of (\S+),", hint)[0]
    line = hint.partition("value: ")[2].partition(", and take")[0]
    text = path.read_text(encoding="utf-8")
    if "take its other lines with an I_zz out" in hint:
        text = re.sub("(?m)^# (?:I_zz|reported_inertia).*\n", "", text)
    path.write_text(f"{line}\n{text}", encoding="utf-8")
    document, code = told(root)
    assert (code, document["hand_in"]["inertia"], document["hand_in"]["u"]) == (
        0,
        4.4e-3,
        0.1e-3,
    )


@pytest.mark.parametrize(
    ("files", "given", "says"),
    [
        ({"report.pdf": b"%PDF"}, ("",), "no log: only report.pdf"),
        (
            {"a.csv": LOG, "b.csv": LOG.replace("20", "21")},
            ("a.csv", "b.csv"),
            "several files that read as logs",
        ),
        ({"lab.csv": LOG}, ("", "lab.csv"), "not all of them are files"),
        ({"lab.csv": LOG}, ("lab.csv", "report.txt"), "there is no file"),
    ],
)
def test_what_cannot_be_a_hand_in_is_told(
    files: Mapping[str, str], given: tuple[str, ...], says: str, tmp_path: Path
) -> None:
    root = make_folder(tmp_path / "mine", files)
    text, code = check(*(root / name for name in given))
    assert (code, says in text) == (2, True)


@pytest.mark.slow
@pytest.mark.parametrize(
    "says",
    [
        "All times are for 1/3 turn.",
        "All times are for ⅓ of a turn.",
        "时间是三分之一圈",
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "latin-1", "utf-16"])
def test_what_the_log_lacks_is_read_from_the_text_beside_it(
    says: str, encoding: str
) -> None:
    runs = [
        (mass, spin, 6.633 * spin / mass / 10)
        for mass in (20, 40, 60)
        for spin in (200, 400, 600)
    ]
    text = "mass [g],position [cm],spin [rpm],time [s]\n" + "".join(
        f"{m},15.0,{s},{t:.2f}\n" for m, s, t in runs
    )
    log = f"# Müller\n{text}".encode(encoding)
    files = {
        "jane/lab.csv": log,
        "jane/answer.txt": f"{says}\nI_zz = (4.45 ± 0.03)e-3 kg m^2\n",
    }
    assert grade(files | {"max/lab.csv": log})["students"]["max"]["status"] != "graded"
    found = grade(files)["students"]["jane"]
    assert found["points"] == 20
    assert says in str(found["diagnostics"])
