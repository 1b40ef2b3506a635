"""``gyro analyze --watch``: when a file is read again, and what is said of a lab
half-way.
"""

from __future__ import annotations

import os
import re
import signal
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest
from places import ROOT
from processes import started
from typer.testing import CliRunner

from gyrodata.cli import app

HEAD = "# g: 9.803 m/s^2\nmass [g],position [cm],spin [rpm],time [s],turns\n"
LIGHT = "20.00,15.0,206,20.4,1\n20.00,15.0,407,40.4,1\n20.00,15.0,601,59.6,1\n"
MIDDLE = "40.00,15.0,203,10.1,1\n40.00,15.0,405,20.1,1\n"
FAST = "40.00,15.0,607,30.1,1\n"
HEAVY = "60.00,15.0,201,6.8,1\n60.00,15.0,404,13.4,{}\n"
SLIP = HEAD + LIGHT + MIDDLE + FAST + HEAVY.format(2)
pytestmark = pytest.mark.skipif(
    os.name == "nt", reason="signals are another thing there"
)


def watched(path: Path, *steps: tuple[str, Callable[[], object]]) -> str:
    """Watch a file: wait for a line of each step, do what it says, and stop with Ctrl-C
    behind the last one.
    """
    command = [sys.executable, "-m", "gyrodata", "analyze", path.name, "--watch"]
    ours = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONUTF8": "1"}
    shown, seen, begun = path.with_name("shown.txt"), 0, time.monotonic()
    with (
        shown.open("wb") as out,
        started(command, cwd=path.parent, env=ours, stdout=out, stderr=out) as run,
    ):
        for line, step in steps:
            while (at := shown.read_text("utf-8").find(line, seen)) < 0:
                assert time.monotonic() - begun < 60, (line, shown.read_text("utf-8"))
                time.sleep(0.05)
            seen = at + len(line)
            step()
        time.sleep(0.3)
        run.send_signal(signal.SIGINT)
        assert run.wait(30) == 130
    assert {one.name for one in path.parent.iterdir()} <= {path.name, shown.name}, (
        "no report is written"
    )
    return shown.read_text("utf-8")


@pytest.mark.slow
def test_each_change_of_the_file_is_one_block(tmp_path: Path) -> None:
    log, new = tmp_path / "log.csv", tmp_path / "new.tmp"
    log.write_text(HEAD + LIGHT)

    def save_by_rename() -> None:
        new.write_text(HEAD + LIGHT + MIDDLE)
        new.replace(log)

    text = watched(
        log,
        (": 3 runs, ", partial(log.write_text, HEAD + LIGHT + "40.00,15.0,2x3")),
        (": 3 runs, 1 error", save_by_rename),
        (": 5 runs, ", log.unlink),
        (
            "log.csv: cannot be read now",
            partial(log.write_text, HEAD + LIGHT + MIDDLE + FAST),
        ),
        (": 6 runs, ", lambda: None),
    )
    before, *blocks = text.split("watching log.csv; Ctrl-C ends it\n")
    assert before == ""
    runs = [re.findall(r"(?m)^log\.csv: (\d+) runs, ", block) for block in blocks]
    assert runs == [["3"], ["3"], ["5"], [], ["6"]]
    answers = [block.count("\nI_zz = ") for block in blocks]
    assert answers == [1, 0, 1, 0, 1]
    assert "log.csv:6:12: error" in text
    assert "\033" not in text


def test_a_file_that_is_not_there_is_refused_at_once(tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["analyze", str(tmp_path / "none.csv"), "--watch"])
    assert (done.exit_code, "one file that exists" in done.stderr) == (2, True)


@pytest.mark.slow
def test_lab_half_way_shows_the_answer_and_what_check_says(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text(SLIP, encoding="utf-8")
    text = watched(tmp_path / "log.csv", ("I_zz = ", lambda: None))
    _, *findings, answer = text.splitlines()
    assert answer.startswith("I_zz = ")
    checked = CliRunner().invoke(app, ["check", str(tmp_path / "log.csv")]).stdout
    assert findings == checked.splitlines()
    assert "run 8: fits 1 turn, not 2" in text


@pytest.mark.slow
def test_pipe_in_the_place_of_the_log_does_not_block(tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    log.write_text(HEAD + LIGHT)

    def replace_by_a_pipe() -> None:
        log.unlink()
        os.mkfifo(log)

    def replace_by_a_file() -> None:
        log.unlink()
        log.write_text(HEAD + LIGHT + MIDDLE)

    text = watched(
        log,
        (": 3 runs, ", replace_by_a_pipe),
        ("log.csv: cannot be read now", replace_by_a_file),
        (": 5 runs, ", lambda: None),
    )
    assert "Traceback" not in text


def test_pipe_is_not_watched(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "log.csv")
    done = CliRunner().invoke(app, ["analyze", str(tmp_path / "log.csv"), "--watch"])
    assert (done.exit_code, "--watch" in done.output) == (2, True)
