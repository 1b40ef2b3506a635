"""`gyro check --hand-in`: what a student is told is what the grader reads, and advice that is followed is enough."""

from __future__ import annotations

import io
import json
import re
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import jsonschema
import openpyxl
import pytest
from classes.drawn import draw
from classes.typed import HABITS, plain
from grading.classes import make_folder, make_zip
from typer.testing import CliRunner, Result

from gyrodata import schema
from gyrodata.cli import app

STUDENT = draw(3, 5)
ANSWER = plain(*STUDENT.answer())
LOG = STUDENT.log()


def gyro(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, [str(one) for one in arguments], prog_name="gyro")


def told(*paths: Path) -> tuple[dict[str, Any], int]:
    done = gyro("check", "--hand-in", "--format", "json", *paths)
    document = json.loads(done.stdout)
    jsonschema.validate(document, schema.check_schema())
    return document, done.exit_code


def test_what_is_told_is_what_is_graded(tmp_path: Path) -> None:
    hands = {f"s{i:02d}": HABITS[habit](STUDENT, ANSWER) for i, habit in enumerate(HABITS)}
    # What is typed into a field comes as a text.
    people = {
        who: {name.replace("receipt", "receipt.txt"): data for name, data in files.items()}
        for who, files in hands.items()
    }
    root = make_folder(
        tmp_path / "class", {f"{who}/{name}": data for who, files in people.items() for name, data in files.items()}
    )
    done = gyro("grade", root, "--format", "json", "--workers", "1", "--quiet")
    graded = {one["student"]: one for one in json.loads(done.stdout)["students"]}
    for who, habit in zip(people, HABITS, strict=True):
        document, code = told(root / who)
        assert told(*sorted((root / who).iterdir()))[0]["hand_in"] == document["hand_in"], habit
        read = document["hand_in"]
        assert (read["inertia"], read["u"]) == tuple(graded[who]["reported"].get(key) for key in ("value", "u")), habit
        assert (read["inertia"] is None) == (habit == "PDF"), habit
        assert code == (habit == "PDF"), habit


@pytest.mark.parametrize(
    ("files", "place"),
    [
        ({"lab.csv": LOG + f"I_zz,{ANSWER}\n"}, "lab.csv, line 12"),
        ({"lab.csv": LOG, "report.txt": f"Our report.\n\nI_zz = {ANSWER}\n"}, "report.txt, line 3"),
        ({"lab.csv": LOG, "jdoe_answers.toml": f'\ninertia = "{ANSWER}"\n'}, "jdoe_answers.toml, line 2"),
        ({"lab.csv": LOG, "text.html": f"<div><p>Hello.</p>\n\n<p>I_zz = {ANSWER}</p></div>"}, "text.html, line 2"),
    ],
)
def test_the_place_is_told(files: Mapping[str, str], place: str, tmp_path: Path) -> None:
    done = gyro("check", "--hand-in", make_folder(tmp_path / "mine", files))
    value, u = re.findall(r"[\d.]+(?=e-3)", ANSWER)
    assert f"I_zz = ({value} ± {u}) × 10⁻³ kg·m², read from {place}; station: 4" in done.stdout
    assert done.stdout.endswith("lab.csv: 9 runs, with an answer (1 note)\n")
    assert done.exit_code == 0


def test_what_is_not_stated_is_told(tmp_path: Path) -> None:
    root = make_folder(tmp_path / "mine", {"lab.csv": STUDENT.log("# I_zz = 4.4e-3")})
    line = next(line for line in gyro("check", "--hand-in", root).stdout.splitlines() if "read from" in line)
    assert "no uncertainty is found with it" in line
    assert "has no unit" in line


def workbook(log: str) -> bytes:
    book = openpyxl.Workbook()
    for line in log.splitlines():
        cells = [line] if line.startswith("#") else line.split(",")
        book.active.append([float(cell) if re.fullmatch(r"[\d.]+", cell) else cell for cell in cells])
    out = io.BytesIO()
    book.save(out)
    return out.getvalue()


GERMAN = LOG.replace(",", ";").replace(".", ",")
LACKING = {
    "none": {"lab.csv": LOG},
    "decimal commas": {"lab.csv": GERMAN},
    "workbook": {"lab.xlsx": workbook(LOG)},
    "a PDF": {"lab.csv": LOG, "report.pdf": b"%PDF-1.4\n"},
    "two in reports": {"lab.csv": LOG, "a.txt": "I_zz = 4.4e-3 kg m^2", "b.md": "I_zz = 4.5e-3 kg m^2"},
    "two in the log": {"lab.csv": "# I_zz = 4.4e-3 kg m^2\n# I_zz: 4.5e-3 kg m^2\n" + LOG},
    "given twice": {
        "lab.csv": "# reported_inertia: 4.4e-3 kg m^2\n# reported_inertia: 4.5e-3 kg m^2\n# balanced: yes\n" + LOG
    },
    "no number": {"lab.csv": "# reported_inertia: see below\n" + LOG},
}


@pytest.mark.parametrize("what", LACKING)
def test_the_advice_carried_out_is_enough(what: str, tmp_path: Path) -> None:
    root = make_folder(tmp_path / "mine", LACKING[what])
    document, code = told(root)
    assert code == 1
    found = next(one for one in document["diagnostics"] if one["code"] == "G719")
    assert ("two values" in found["message"] or "twice" in found["message"]) == (what.startswith(("two", "given")))
    assert ("not read: report.pdf" in found["message"]) == (what == "a PDF")
    hint = found["hint"]
    assert hint in gyro("check", "--hand-in", root).stdout
    file = re.search(r"table of (\S+),", hint)
    assert file
    path = root / file[1]
    line = hint.partition("value: ")[2].partition(", and take")[0]
    if path.suffix == ".xlsx":
        path.write_bytes(workbook(f"{line}\n{LOG}"))
    else:
        kept = path.read_text(encoding="utf-8").splitlines(keepends=True)
        if "take its other lines with an I_zz out" in hint:
            kept = [one for one in kept if not re.match("# (?:I_zz|reported_inertia)", one)]
        path.write_text("".join([f"{line}\n", *kept]), encoding="utf-8")
    document, code = told(root)
    assert (code, document["hand_in"]["inertia"], document["hand_in"]["u"]) == (0, 4.4e-3, 0.1e-3)


def test_a_zip_and_the_other_formats(tmp_path: Path) -> None:
    files = {"lab.csv": LOG, "report.txt": f"\nI_zz = {ANSWER}\n"}
    packed, root = make_zip(tmp_path / "mine.zip", files), make_folder(tmp_path / "mine", files)
    whole = told(root)[0]
    assert told(packed)[0] == whole
    (line,) = gyro("check", "--hand-in", root, "--format", "ndjson").stdout.splitlines()
    assert json.loads(line) == whole
    paths = [root / name for name in files]
    (notice,) = gyro("check", "--hand-in", *paths, "--format", "github").stdout.splitlines()
    assert notice.startswith(f"::notice file={root / 'report.txt'},line=2,title=G718::I_zz = ")


@pytest.mark.parametrize(
    ("files", "given", "says"),
    [
        ({"report.pdf": b"%PDF"}, ("",), "no log: only report.pdf"),
        ({"a.csv": LOG, "b.csv": LOG + "\n"}, ("a.csv", "b.csv"), "several files that read as logs: a.csv, b.csv"),
        ({"lab.csv": LOG}, ("", "lab.csv"), "not all of them are files"),
        ({"lab.csv": LOG}, ("lab.csv", "report.txt"), "there is no file"),
        ({"lab.csv": "no table"}, ("lab.csv",), "no delimiter"),
    ],
)
def test_what_cannot_be_a_hand_in_is_told(
    files: Mapping[str, str], given: tuple[str, ...], says: str, tmp_path: Path
) -> None:
    root = make_folder(tmp_path / "mine", files)
    done = gyro("check", "--hand-in", *(root / name for name in given))
    assert done.exit_code == 2
    assert says in done.stdout


def test_a_log_by_itself_is_checked_without_the_grader() -> None:
    sample = Path(__file__).parents[2] / "sample_data" / "air_gyroscope.csv"
    code = (
        "import sys; from gyrodata.cli import app\n"
        f"try: app(['check', {str(sample)!r}])\n"
        "finally: print([name for name in sys.modules if name.startswith('gyrodata.grading')])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.stdout.splitlines()[-1] == "[]"
