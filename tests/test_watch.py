"""``gyro analyze --watch``: when a file is read again, and what is said of a lab half-way."""

from __future__ import annotations

import io
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from gyrodata import read_log
from gyrodata.analysis import analyze_readings
from gyrodata.cli import watching
from gyrodata.cli.watching import PATIENCE, contents
from gyrodata.procedure import check_log
from gyrodata.reporting import watch_text

ROOT = Path(__file__).parent.parent
EXPECTED = Path(__file__).parent / "expected"
HEAD = "# g: 9.803 m/s^2\nmass [g],position [cm],spin [rpm],time [s],turns\n"
LIGHT = "20.00,15.0,206,20.4,1\n20.00,15.0,407,40.4,1\n20.00,15.0,601,59.6,1\n"
MIDDLE = "40.00,15.0,203,10.1,1\n40.00,15.0,405,20.1,1\n"
FAST = "40.00,15.0,607,30.1,1\n"
HEAVY = "60.00,15.0,201,6.8,1\n60.00,15.0,404,13.4,2\n"

Step = Callable[[], object]


class StoppedError(Exception):
    """The script of a test is at its end."""


def script(*steps: Step) -> Callable[[float], None]:
    """A sleep that does one step of a story each time, and then stops the watcher."""
    left = iter(steps)

    def sleep(seconds: float) -> None:
        assert 0 < seconds <= 1
        step = next(left, None)
        if step is None:
            raise StoppedError
        step()

    return sleep


def nothing() -> None:
    pass


def seen(path: Path, *steps: Step) -> list[bytes | None]:
    """What is read of a file in the course of a story."""
    found = []
    try:
        for data in contents(path, script(*steps)):
            found.append(data)  # noqa: PERF402  (the story ends with an exception)
    except StoppedError:
        return found
    raise AssertionError("the watcher stopped by itself")


def saying(path: Path, text: str) -> Step:
    return lambda: path.write_text(text, encoding="utf-8")


@pytest.fixture
def log(tmp_path: Path) -> Path:
    path = tmp_path / "log.csv"
    path.write_text("one", encoding="utf-8")
    return path


# --- when a file is read -----------------------------------------------------------------------------------


def test_a_change_is_read_once_it_has_come_to_rest(log: Path) -> None:
    assert seen(log, nothing, nothing) == [b"one"]
    assert seen(log, saying(log, "two"), nothing, nothing, nothing) == [b"one", b"two"]


def test_a_file_that_is_being_written_is_not_read_half_way(log: Path) -> None:
    steps = [saying(log, "th"), saying(log, "thr"), saying(log, "thre"), saying(log, "three"), nothing, nothing]
    assert seen(log, *steps) == [b"one", b"three"]


def test_a_file_that_never_rests_is_read_all_the_same(log: Path) -> None:
    steps = [saying(log, "x" * length) for length in range(1, PATIENCE + 3)]
    assert len(seen(log, *steps)) == 2


def test_saving_by_rename_and_by_delete_is_a_change_like_any_other(log: Path) -> None:
    new = log.with_name("new.tmp")

    def rename() -> None:
        new.write_text("two", encoding="utf-8")
        new.replace(log)

    def recreate() -> None:
        log.unlink()
        log.write_text("six", encoding="utf-8")

    assert seen(log, rename, nothing, recreate, nothing, nothing) == [b"one", b"two", b"six"]


def test_a_file_that_is_gone_for_a_moment_is_not_missed(log: Path) -> None:
    assert seen(log, log.unlink, saying(log, "two"), nothing, nothing) == [b"one", b"two"]
    log.write_text("one", encoding="utf-8")
    gone = seen(log, log.unlink, nothing, nothing, nothing, saying(log, "new"), nothing, nothing)
    assert gone == [b"one", None, b"new"]


def test_saving_the_same_again_is_no_change(log: Path) -> None:
    assert seen(log, saying(log, "one"), nothing, nothing) == [b"one"]
    assert seen(log, log.touch, nothing, nothing) == [b"one"]


# --- what is printed ---------------------------------------------------------------------------------------


def printed(path: Path, *steps: Step, output: io.StringIO, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.setattr(sys, "stdout", output)
    with pytest.raises(StoppedError):
        watching.watch(
            path,
            lambda data: read_log(data, name=path.name),
            lambda readings: analyze_readings(readings),
            "plain",
            script(*steps),
        )
    return output.getvalue()


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_one_block_for_each_change(log: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log.write_text(HEAD + LIGHT, encoding="utf-8")
    half, whole = saying(log, HEAD + LIGHT + "40.00,15.0,2x3"), saying(log, HEAD + LIGHT + MIDDLE)
    steps = (half, nothing, whole, nothing, log.unlink, nothing, nothing)
    text = printed(log, *steps, output=io.StringIO(), monkeypatch=monkeypatch)
    blocks = text.split("-" * 72 + "\n")
    assert [block.splitlines()[0] for block in blocks] == [
        "log.csv: 3 runs, 1 torque",
        "log.csv: no answer yet",
        "log.csv: 5 runs, 2 torques",
        "log.csv: cannot be read now",
    ]
    assert "log.csv:6:12: error" in blocks[1]
    assert "\033" not in text


@pytest.mark.parametrize("name", ["expected/half_way.csv", "../sample_data/air_gyroscope.csv"])
def test_every_state_of_a_log_that_is_being_typed_has_an_answer_or_a_reason(name: str) -> None:
    whole = (Path(__file__).parent / name).read_text(encoding="utf-8")
    for end in range(0, len(whole), 7):
        said_of_it = watching.state("log", whole[:end].encode(), read_log, lambda read: analyze_readings(read), "plain")
        assert said_of_it.startswith(("log: no answer yet\n\n<bytes>", "<bytes>: ")), end


def test_a_terminal_is_cleared(log: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log.write_text(HEAD + LIGHT, encoding="utf-8")
    monkeypatch.setenv("TERM", "xterm")
    change = saying(log, HEAD + LIGHT + MIDDLE)
    text = printed(log, change, nothing, output=Terminal(), monkeypatch=monkeypatch)
    assert text.count("\033[H\033[2J") == 2
    assert text.endswith("watching log.csv; Ctrl-C ends it\n")
    monkeypatch.setenv("TERM", "dumb")
    assert "\033" not in printed(log, nothing, output=Terminal(), monkeypatch=monkeypatch)


@pytest.mark.skipif(os.name == "nt", reason="signals are another thing there")
def test_ctrl_c_is_the_way_out(log: Path) -> None:
    log.write_text(HEAD + LIGHT, encoding="utf-8")
    command = [sys.executable, "-m", "gyrodata", "analyze", str(log), "--watch"]
    with subprocess.Popen(
        command, cwd=log.parent, env={**os.environ, "PYTHONPATH": str(ROOT)}, text=True, encoding="utf-8",
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    ) as running:  # fmt: skip
        assert running.stdout is not None
        assert running.stdout.readline() == "log.csv: 3 runs, 1 torque\n"
        running.send_signal(signal.SIGINT)
        _, complaints = running.communicate(timeout=30)
    assert running.returncode == 130
    assert complaints == ""
    assert list(log.parent.iterdir()) == [log], "no report is written"


def test_a_name_that_is_wrong_is_refused_at_once(tmp_path: Path) -> None:
    from typer.testing import CliRunner

    from gyrodata.cli import app

    done = CliRunner().invoke(app, ["analyze", str(tmp_path / "none.csv"), "--watch"])
    assert done.exit_code == 2
    assert "there is no file" in done.stderr


# --- what is said ------------------------------------------------------------------------------------------


def said(log: str) -> str:
    readings = read_log(log.encode(), name="half_way.csv")
    return watch_text(analyze_readings(readings), check_log(readings)[1])


def part(text: str, title: str) -> list[str]:
    """Lines below a title."""
    return next(block for block in text.split("\n\n") if block.startswith(title)).splitlines()[1:]


def test_golden_half_way() -> None:
    text = said((EXPECTED / "half_way.csv").read_text(encoding="utf-8"))
    assert text == (EXPECTED / "half_way.txt").read_text(encoding="utf-8")


def test_an_odd_run_is_repeated_before_its_weight_comes_off() -> None:
    text = said(HEAD + LIGHT + MIDDLE + FAST + HEAVY)
    assert part(text, "with 60.00 g at 15.0 cm on the rod")[0] == "  repeat run 8 (line 10): fits 1 turn, not 2"
    unloaded = said(HEAD + LIGHT + MIDDLE + FAST + HEAVY + "0,,400,160,1/12\n")
    assert part(unloaded, "still open")[0] == "  repeat run 8 (line 10), with 60.00 g at 15.0 cm: fits 1 turn, not 2"


def test_what_the_weight_on_the_rod_lacks_stands_with_it() -> None:
    text = said(HEAD + LIGHT + MIDDLE)
    assert "add 1 run, for example at 600 rpm" in "".join(part(text, "with 40.00 g at 15.0 cm on the rod"))
    assert not any("600 rpm" in line for line in part(text, "still open"))
    assert any("no run without a weight" in line for line in part(text, "still open"))


def test_a_run_that_is_far_off_is_worth_repeating() -> None:
    heavy = "60.00,15.0,201,6.8,1\n60.00,15.0,404,13.4,1\n60.00,15.0,603,20.0,1\n"
    scattered = HEAD + LIGHT + heavy + MIDDLE + "40.00,15.0,607,30.8,1\n"
    assert any("u from what the other runs say" in line for line in part(said(scattered), "with 40.00 g at 15.0 cm"))


def test_a_complete_lab_is_told_what_would_gain_most() -> None:
    text = said((ROOT / "sample_data" / "air_gyroscope.csv").read_text(encoding="utf-8"))
    assert "with no weight on the rod:\n  1 run, and nothing is missing\n" in text
    assert "nothing else is open" in text
    assert "three times the turns in every run: u of I_zz from" in part(text, "what would gain most")[0]


def test_a_weight_that_lacks_nothing_names_the_run_that_counts_most() -> None:
    assert "3 runs, and nothing is missing; if there is time, repeat run" in said(HEAD + LIGHT)


def test_loads_without_a_mass_have_a_name() -> None:
    log = "torque [N*m],spin [rpm],time [s],turns\n0.05,400,24.0,1\n0.1,400,12.0,1\n"
    assert "with a torque of 100 mN·m on the rod:" in said(log)
