"""``gyro analyze --watch``: when a file is read again, and what is said of a lab
half-way.
"""

from __future__ import annotations

import os
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

SAMPLE = (ROOT / "sample_data" / "air_gyroscope.csv").read_text(encoding="utf-8")
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
        ("3 runs, 1 torque", partial(log.write_text, HEAD + LIGHT + "40.00,15.0,2x3")),
        ("log.csv: no answer yet", save_by_rename),
        ("5 runs, 2 torques", log.unlink),
        (
            "log.csv: cannot be read now",
            partial(log.write_text, HEAD + LIGHT + MIDDLE + FAST),
        ),
        ("6 runs, 2 torques", log.touch),
        ("", partial(log.write_text, HEAD + LIGHT + MIDDLE + FAST)),
    )
    blocks = [
        block.splitlines()[0].removeprefix("log.csv: ")
        for block in text.split("-" * 72 + "\n")
    ]
    answers = [
        "3 runs, 1 torque",
        "no answer yet",
        "5 runs, 2 torques",
        "cannot be read now",
        "6 runs, 2 torques",
    ]
    assert blocks == answers
    assert "log.csv:6:12: error" in text
    assert "\033" not in text


def test_a_file_that_is_not_there_is_refused_at_once(tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["analyze", str(tmp_path / "none.csv"), "--watch"])
    assert (done.exit_code, "there is no file" in done.stderr) == (2, True)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("log", "title", "words"),
    [
        # An odd run is repeated before its weight comes off.
        (
            SLIP,
            "while 60.00 g at 15.0 cm is on the rod",
            "repeat run 8 (line 10): fits 1 turn, not 2",
        ),
        (
            SLIP + "0,,400,160,1/12\n",
            "still to do",
            "repeat run 8 (line 10), with 60.00 g at 15.0 cm: fits 1 turn",
        ),
        # What the weight on the rod lacks is said of it.
        (
            HEAD + LIGHT + MIDDLE,
            "while 40.00 g at 15.0 cm is on the rod",
            "add 1 run, so that the spins are about 200, 400 and 600 rpm",
        ),
        (HEAD + LIGHT + MIDDLE, "still to do", "no run without a weight"),
        (
            HEAD + LIGHT,
            "while 20.00 g",
            "3 runs, and nothing is missing; if you have time, repeat run",
        ),
        (
            SAMPLE,
            "what would reduce u most",
            "time three times as many turns of the rod in every run: u of I_zz from",
        ),
    ],
)
def test_a_lab_half_way_is_told_what_to_do_next(
    log: str, title: str, words: str, tmp_path: Path
) -> None:
    (tmp_path / "log.csv").write_text(log, encoding="utf-8")
    text = watched(tmp_path / "log.csv", ("torque", lambda: None))
    part = next(block for block in text.split("\n\n") if block.startswith(title))
    assert words in " ".join(part.split())


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
        ("3 runs, 1 torque", replace_by_a_pipe),
        ("log.csv: cannot be read now", replace_by_a_file),
        ("5 runs, 2 torques", lambda: None),
    )
    assert "Traceback" not in text


def test_pipe_is_not_watched(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "log.csv")
    done = CliRunner().invoke(app, ["analyze", str(tmp_path / "log.csv"), "--watch"])
    assert (done.exit_code, "--watch" in done.output) == (2, True)
