"""The user's environment costs no answer and no grade: matplotlibrc, MPLBACKEND, and
JSON that a terminal obeys.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from forked import run_script
from grading.classes import make_folder
from grading.students_reports import a_log
from msgspec.structs import replace
from places import ROOT, SAMPLES
from typer.testing import CliRunner

from gyrodata import analyze
from gyrodata.cli import app
from gyrodata.reporting.figures import ALL_FIGURES, FIGURES

SAMPLE = SAMPLES / "air_gyroscope.csv"
RC = b"""text.usetex: true
path.sketch: 1, 100, 2
savefig.dpi: 7
savefig.bbox: tight
savefig.format: xyz
savefig.transparent: True
font.family: Nonsense Sans
font.size: 100000
axes.titlesize: 90
axes.facecolor: red
axes.prop_cycle: cycler("color", ["r"])
axes.formatter.use_mathtext: True
interactive: True
backend: nonsense
figure.autolayout: True
figure.constrained_layout.use: True
lines.linestyle: nonsense
image.cmap: nonsense
svg.fonttype: none
no.such.key: 1
nonsense
"""


GYRO_TWICE = f"""
import sys
from contextlib import suppress
from gyrodata.__main__ import main

sys.argv[1:] = ["analyze", {str(SAMPLE)!r}, "--out", "log-report"]
with suppress(SystemExit):
    main()
sys.argv[1:] = ["grade", "class", "--exit-zero", "--workers", "0"]
main()
"""
"""Analyses a log and grades a class."""


def drawn(home: Path, in_fork: bool = False, **environment: str) -> dict[str, bytes]:
    """Run `GYRO_TWICE` in a new process, or in a fork of this one; return I_zz, and what
    is drawn.
    """
    for name in ("log-report", "class-grades"):
        shutil.rmtree(home / name, ignore_errors=True)
    make_folder(home / "class", {"ann.csv": SAMPLE.read_bytes()})

    script = home / "twice.py"
    script.write_text(GYRO_TWICE, encoding="utf-8")
    if in_fork:
        done = run_script(script, home)
    else:
        done = subprocess.run(
            [sys.executable, script],
            cwd=home,
            env={**os.environ, "PYTHONPATH": str(ROOT), **environment},
            capture_output=True,
            encoding="utf-8",
            check=False,
        )
    assert (done.returncode, "the tool broke" in done.stdout) == (0, False), done.stderr
    files = {
        path.name: path.read_bytes()
        for path in sorted((home / "log-report").glob("*.svg"))
    }
    pages = {
        path.name: path.read_bytes()
        for path in (home / "class-grades" / "feedback").rglob("*.html")
    }
    answer = re.findall(r"I_zz = .*", done.stdout)[0].encode()
    return {"answer": answer, **files, **pages}


def test_no_matplotlibrc_and_no_backend_changes_an_answer_or_a_figure(
    tmp_path: Path,
) -> None:
    usual = drawn(tmp_path, in_fork=True)
    assert [name.endswith(".svg") for name in usual].count(True) == len(FIGURES)
    (tmp_path / "matplotlibrc").write_bytes(RC)
    assert drawn(tmp_path, MPLBACKEND="nonsense") == usual


def test_without_a_matplotlib_that_can_be_loaded_there_are_an_answer_and_a_grade(
    tmp_path: Path,
) -> None:
    (tmp_path / "matplotlibrc").write_bytes(b"\xff\xfe")
    without = drawn(tmp_path)
    page = without.pop("feedback.html")
    assert (list(without), b"<figure" in page) == (["answer"], False)


def test_a_figure_that_fails_is_a_warning(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(*_: object) -> None:
        raise RuntimeError("a fault planted by the test")

    broken = replace(ALL_FIGURES["torque"], panels=(fails,))
    monkeypatch.setitem(ALL_FIGURES, "torque", broken)  # type: ignore[arg-type]
    done = CliRunner().invoke(
        app, ["analyze", str(SAMPLE), "--out", str(tmp_path / "report")]
    )
    assert (done.exit_code, "I_zz = " in done.stdout) == (0, True)
    assert (
        "warning G611: matplotlib cannot draw torque: RuntimeError: a fault planted by the test\n"
        in done.stderr
    )
    written = {path.name for path in (tmp_path / "report").iterdir()}
    assert {"report.html", "period.svg"} <= written
    assert "torque.svg" not in written
    assert analyze(SAMPLE)._repr_html_().count("<img") == 0


BARE = re.compile("[\x7f-\x9f\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069]")
"""What an 8-bit terminal obeys, or what turns a line around."""
NAMES = "\x9b31m \x7f \u061c \u200e\u200f \u202e \u2066"


def test_json_for_other_programs_contains_no_bare_control(tmp_path: Path) -> None:
    """A name from a roster is shown as it is, and a name of a file without them."""
    folder = make_folder(
        tmp_path / "class", {"ann/lab.csv": a_log(1), f"{NAMES}/{NAMES}.csv": a_log(2)}
    )
    roster = tmp_path / "roster.csv"
    roster.write_text(
        f"identifier,name,section\nann,{NAMES},{NAMES}\n", encoding="utf-8"
    )
    words = [
        "grade",
        str(folder),
        "--roster",
        str(roster),
        "--workers",
        "0",
        "--exit-zero",
    ]
    grades = tmp_path / "grades"
    CliRunner().invoke(app, [*words, "--out", str(grades)])
    desk = f"student,what,value,by,why\nann,comment,{NAMES},TA,{NAMES}\n"
    (grades / "desk.csv").write_text(desk, encoding="utf-8")
    CliRunner().invoke(app, [*words, "--out", str(grades)])
    texts = [(grades / "grades.json").read_text(encoding="utf-8")]
    texts += [
        CliRunner().invoke(app, [*words, "--format", form]).stdout
        for form in ("json", "ndjson")
    ]
    for text in texts:
        assert BARE.search(text) is None
        contents = (
            [json.loads(text)]
            if text[:2] == "{\n"
            else [json.loads(one) for one in text.splitlines()]
        )
        assert NAMES.strip() in json.dumps(contents, ensure_ascii=False).replace(
            r"\u007f", "\x7f"
        )
    journal = (grades / "journal.ndjson").read_text(encoding="utf-8")
    analysed = (
        CliRunner()
        .invoke(
            app, ["analyze", str(folder / NAMES / f"{NAMES}.csv"), "--format", "json"]
        )
        .stdout
    )
    assert [BARE.search(text) for text in (journal, analysed)] == [None, None]
