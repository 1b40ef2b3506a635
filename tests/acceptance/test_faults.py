"""What is nobody's log's fault: a fault of gyro costs one log, a full disk or a closed
stream a line; no traceback.
"""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from places import SAMPLES
from processes import started
from typer.testing import CliRunner

from gyrodata.cli import app
from gyrodata.readings import read_log

SAMPLE = SAMPLES / "air_gyroscope.csv"
posix = pytest.mark.skipif(os.name != "posix", reason="the streams of a POSIX shell")


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a log and a class of one."""
    (tmp_path / "class").mkdir()
    for name in ("log.csv", "class/doejane_1_2_log.csv"):
        shutil.copy(SAMPLE, tmp_path / name)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("command", ["analyze", "check"])
def test_fault_of_gyro_in_one_log_leaves_the_others(
    command: str, home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def breaking(source: Any, **options: Any) -> Any:
        if "broken" in str(source):
            raise KeyError("a fault planted by the test")
        return read_log(source, **options)

    names = ["a.csv", "broken.csv", "c.csv"]
    for name in names:
        shutil.copy(SAMPLE, name)
    monkeypatch.setattr("gyrodata.readings.read_log", breaking)
    done = CliRunner().invoke(app, [command, *names, "--format", "ndjson"])
    assert done.exit_code == 3
    found = [json.loads(line) for line in done.stdout.splitlines()]
    assert [one["input"]["name"] for one in found] == names
    (fault,) = found[1]["diagnostics"]
    assert (fault["code"], fault["severity"]) == ("G901", "error")
    assert fault["message"].startswith(
        "this is a fault of gyro, not of your log: KeyError in "
    )
    assert "GYRO_DEBUG=1" in fault["hint"]
    assert "planted" not in done.output
    assert "Traceback" not in done.output


def test_fault_in_any_command_ends_in_a_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gyrodata.cli.template_command.blank_log", lambda *_: 1 / 0)
    done = CliRunner().invoke(app, ["template"])
    assert (
        done.exit_code,
        "error G901" in done.output,
        "Traceback" in done.output,
    ) == (3, True, False)


def shell(line: str) -> subprocess.CompletedProcess[bytes]:
    """Run a line of shell in which ``gyro`` is this one."""
    head = f'gyro() {{ "{sys.executable}" -m gyrodata "$@"; }}\n'
    pipe = subprocess.PIPE
    with started(["bash", "-c", head + line], stdout=pipe, stderr=pipe) as run:
        out, errors = run.communicate(timeout=120)
    return subprocess.CompletedProcess(run.args, run.returncode, out, errors)


@posix
def test_report_and_grades_are_written_without_an_error_stream(home: Path) -> None:
    done = shell(
        "gyro analyze log.csv -o report 2>&- && gyro grade class --workers 0 "
        "--exit-zero 2>/dev/full"
    )
    assert done.returncode == 0
    assert (home / "report" / "report.html").is_file()
    assert (home / "class-grades" / "class.html").is_file()
