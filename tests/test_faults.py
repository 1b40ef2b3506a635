"""What is nobody's log's fault: a fault of gyro costs one log, a full disk or a closed stream a line; no traceback."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from gyrodata.cli import app
from gyrodata.diagnostics import CODES
from gyrodata.readings import read_log

SAMPLE = Path(__file__).parent.parent / "sample_data" / "air_gyroscope.csv"
posix = pytest.mark.skipif(os.name != "posix", reason="the streams of a POSIX shell")


@pytest.fixture
def logs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Three logs, and a gyro that breaks on the second."""
    for name in ("a", "broken", "c"):
        (tmp_path / f"{name}.csv").write_bytes(SAMPLE.read_bytes())
    monkeypatch.chdir(tmp_path)

    def breaking(source: Any, **options: Any) -> Any:
        if "broken" in str(source):
            raise KeyError("a fault planted by the test")
        return read_log(source, **options)

    monkeypatch.setattr("gyrodata.readings.read_log", breaking)
    return tmp_path


@pytest.mark.parametrize("command", ["analyze", "check"])
class TestOneBrokenLog:
    def test_the_others_go_on(self, command: str, logs: Path) -> None:
        done = CliRunner().invoke(app, [command, "a.csv", "broken.csv", "c.csv", "--format", "ndjson"])
        assert done.exit_code == 3
        found = [json.loads(line) for line in done.stdout.splitlines()]
        assert [one["input"]["name"] for one in found] == ["a.csv", "broken.csv", "c.csv"]
        (fault,) = found[1]["diagnostics"]
        assert fault["code"] == "G901"
        assert fault["severity"] == CODES["G901"].severity == "error"
        assert fault["message"].startswith("this is a fault of gyro, not of your log: KeyError in gyrodata.cli.")
        assert "GYRO_DEBUG=1" in fault["hint"]
        assert "planted" not in done.output

    def test_in_words_too(self, command: str, logs: Path) -> None:
        done = CliRunner().invoke(
            app, [command, "a.csv", "broken.csv", "c.csv", *(["-q", "--no-report"] * (command == "analyze"))]
        )
        assert done.exit_code == 3
        assert "broken.csv: error G901: this is a fault of gyro" in done.output
        assert "Traceback" not in done.output
        assert done.stdout.count(".csv: 10 runs") == 2


def test_any_command_ends_in_a_line(monkeypatch: pytest.MonkeyPatch) -> None:
    def breaking(*_: Any) -> str:
        raise RuntimeError

    monkeypatch.setattr("gyrodata.readings.blank_log", breaking)
    done = CliRunner().invoke(app, ["template"])
    assert done.exit_code == 3
    assert "error G901" in done.output
    assert "Traceback" not in done.output


def shell(line: str, folder: Path) -> subprocess.CompletedProcess[bytes]:
    """Run a line of shell in which ``gyro`` is this one."""
    head = f'gyro() {{ "{sys.executable}" -m gyrodata "$@"; }}\n'
    return subprocess.run(["bash", "-c", head + line], cwd=folder, capture_output=True, timeout=120, check=False)


@posix
@pytest.mark.parametrize(
    "line",
    [
        "gyro analyze log.csv --no-report > /dev/full",
        "gyro check log.csv > /dev/full",
        "gyro --help > /dev/full",
        "gyro check log.csv >&-",
        "gyro --version >&-",
        "gyro analyze - <&-",
    ],
)
def test_a_stream_that_cannot_be_used(line: str, tmp_path: Path) -> None:
    if "/dev/full" in line and not Path("/dev/full").exists():
        pytest.skip("no full device here")
    (tmp_path / "log.csv").write_bytes(SAMPLE.read_bytes())
    done = shell(line, tmp_path)
    assert done.returncode == 2
    assert b"error G606: " in done.stdout + done.stderr
    assert b"Traceback" not in done.stderr
    assert b"Exception ignored" not in done.stderr


@posix
@pytest.mark.parametrize("stream", ["2>&-", "2>/dev/full"])
def test_nor_does_it_where_a_report_or_a_class_is_written(stream: str, tmp_path: Path) -> None:
    (tmp_path / "class").mkdir()
    (tmp_path / "class" / "doejane_1_2_log.csv").write_bytes(SAMPLE.read_bytes())
    analyzed = f"gyro analyze class/doejane_1_2_log.csv -o report {stream}"
    done = shell(f"{analyzed} && gyro grade class --workers 0 --exit-zero {stream}", tmp_path)
    assert done.returncode == 0
    assert (tmp_path / "report" / "report.html").is_file()
    assert (tmp_path / "class-grades" / "class.html").is_file()


@posix
@pytest.mark.parametrize(
    ("line", "code"),
    [
        ("analyze log.csv -o log.csv/x", "G603"),
        ("analyze log.csv -f latex -o log.csv", "G638"),
        ("predict earth -o log.csv/x", "G603"),
        ("benchmark --quick -o log.csv/x", "G603"),
        ("simulate --truth log.csv/x.json", "G637"),
        ("grade class -o log.csv/x", "G763"),
    ],
)
def test_a_place_that_cannot_be_written(line: str, code: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "log.csv").write_bytes(SAMPLE.read_bytes())
    (tmp_path / "class").mkdir()
    (tmp_path / "class" / "doejane_1_2_log.csv").write_bytes(SAMPLE.read_bytes())
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(app, line.split())
    assert done.exit_code == 2
    assert f"error {code}: " in done.stderr
    assert "Traceback" not in done.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == ["class", "log.csv"]


@posix
def test_a_reader_of_the_help_may_go_away(tmp_path: Path) -> None:
    # The reader is gone before anything is written.
    line = "{ sleep 0.3; gyro --help; echo $? >&2; } | true"
    assert shell(line, tmp_path).stderr.split() == [b"0"]


@posix
def test_a_file_name_that_is_no_utf_8(tmp_path: Path) -> None:
    try:
        (tmp_path / os.fsdecode(b"n\xff.csv")).write_bytes(SAMPLE.read_bytes())
    except OSError:
        pytest.skip("this file system wants UTF-8")
    done = shell("gyro analyze $'n\\xff.csv'", tmp_path)
    assert done.returncode == 0
    assert done.stdout.startswith(b"n?.csv: 10 runs")
    assert (
        json.loads((tmp_path / os.fsdecode(b"n\xff-report") / "results.json").read_bytes())["input"]["name"] == "n?.csv"
    )
    told = shell("gyro analyze $'n\\xff.csv' --format json", tmp_path).stdout
    assert json.loads(told.decode("utf-8"))["input"]["name"] == "n?.csv"
    assert shell("gyro check $'n\\xff.csv' --format github", tmp_path).returncode == 0
    missing = shell("gyro analyze $'o\\xff.csv' --format ndjson", tmp_path)
    assert missing.returncode == 2
    assert json.loads(missing.stdout.decode("utf-8"))["input"]["name"] == "o?.csv"


@pytest.mark.parametrize(("encoding", "form"), [("cp1252", "text"), ("cp437", "csv"), ("ascii", "markdown")])
def test_what_goes_into_a_file_is_utf_8_on_every_system(encoding: str, form: str) -> None:
    line = [sys.executable, "-m", "gyrodata", "analyze", str(SAMPLE), "--no-report", "--format", form]
    done = subprocess.run(line, capture_output=True, env={**os.environ, "PYTHONIOENCODING": encoding}, check=True)
    assert done.stdout.decode("utf-8") == CliRunner().invoke(app, line[3:]).stdout
