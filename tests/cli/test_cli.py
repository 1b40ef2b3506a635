"""The commands as a shell sees them: output, exit codes, pipes, files, bad input."""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import openpyxl
import pytest
from analyzed_once import analyzed_once
from forked import run_gyro
from places import ROOT
from typer.testing import CliRunner, Result

import gyrodata
from gyrodata.cli import app
from gyrodata.reporting.figures import FIGURES

SAMPLE = ROOT / "sample_data" / "air_gyroscope.csv"
HEAD = "# g: 9.803 m/s^2\nmass [g],position [cm],spin [rpm],time [s],turns\n"
OURS = {**os.environ, "PYTHONPATH": str(ROOT)}
FILES = {
    "report.html",
    "results.json",
    "runs.csv",
    *(f"{name}.svg" for name in FIGURES),
}


@pytest.fixture(scope="module", autouse=True)
def analyses_are_kept() -> Iterator[None]:
    """Most commands here show the analysis of one log."""
    with analyzed_once():
        yield


def gyro(
    *words: str | Path, folder: Path, stdin: bytes = b""
) -> subprocess.CompletedProcess[bytes]:
    line = [sys.executable, "-m", "gyrodata", *map(str, words)]
    return subprocess.run(
        line, cwd=folder, input=stdin, env=OURS, capture_output=True, check=False
    )


@pytest.mark.slow
def test_the_report_is_written_beside_you(tmp_path: Path) -> None:
    done = gyro("analyze", SAMPLE, folder=tmp_path)
    assert done.returncode == 0
    assert {p.name for p in (tmp_path / "air_gyroscope-report").iterdir()} == FILES
    assert "report: air_gyroscope-report" in done.stderr.decode()
    words = ["analyze", str(SAMPLE), "--out", str(tmp_path / "second")]
    again = CliRunner().invoke(app, words)
    assert again.stdout == done.stdout.decode()
    for name in FILES:
        first, second = (
            (tmp_path / d / name).read_bytes()
            for d in ("air_gyroscope-report", "second")
        )
        assert first == second, f"{name} is not the same twice"


@pytest.mark.slow
def test_a_closed_pipe_is_silent(tmp_path: Path) -> None:
    line = f"{sys.executable} -m gyrodata analyze {SAMPLE} --format json | head -1"
    done = subprocess.run(
        line, shell=True, cwd=tmp_path, env=OURS, capture_output=True, check=False
    )
    assert (done.stdout, done.stderr) == (b"{\n", b"")


BAD = [
    (None, 2, "there is no file"),
    (b"", 2, "empty"),
    (bytes(range(256)) * 4, 2, "not text"),
    (b"mass [g],position [cm],spin [rpm],time [s]\n20,15,206,7\n", 1, "# turns: 1"),
    (f"{HEAD}20,15.0,fast,13.06,1/3\n".encode(), 1, "log.csv:3:9: error G203"),
    (f"{HEAD}20,15.0,206,0,1/3\n".encode(), 1, "log.csv:3:13: error"),
    (f"{HEAD}0,,400,160.2,1/3\n".encode(), 1, "no run has a torque"),
]


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="the command is run in a fork")
@pytest.mark.parametrize(("content", "code", "said"), BAD)
def test_a_bad_log_is_refused_in_words_and_json(
    content: bytes | None, code: int, said: str, tmp_path: Path
) -> None:
    if content is not None:
        (tmp_path / "log.csv").write_bytes(content)
    before = set(tmp_path.iterdir())
    done = run_gyro(["analyze", "log.csv"], tmp_path)
    text = done.stderr
    assert (done.returncode, done.stdout) == (code, ""), text
    assert said in text
    assert "Traceback" not in text
    assert set(tmp_path.iterdir()) == before, "nothing is left half-written"
    machine = CliRunner().invoke(
        app, ["analyze", str(tmp_path / "log.csv"), "--format", "json", "--exit-zero"]
    )
    assert machine.exit_code == (0 if code == 1 else 2)
    assert json.loads(machine.stdout)["result"] is None


def test_a_file_of_constants_that_is_not_there_is_named() -> None:
    done = CliRunner().invoke(app, ["analyze", str(SAMPLE), "--config", "none.toml"])
    assert (done.exit_code, "none.toml" in done.stderr) == (2, True), done.output


@pytest.mark.slow
def test_the_first_screen_has_a_dozen_lines_and_a_run_in_words() -> None:
    shown = [
        CliRunner().invoke(app, ["analyze", str(SAMPLE), "--no-report", *more]).stdout
        for more in ([], ["-v"])
    ]
    lines = shown[0].splitlines()
    assert len(lines) <= 12
    assert lines[1].startswith(
        "  Read as: run 1: 20.00 g at 15.00 cm from the centre, 205.0 rpm, 1/3 turn in 6.74 s: "
    )
    assert lines[3].startswith("  I_zz = ")
    assert lines[4].startswith("  The 10 runs agree with one straight line")
    assert ["Sensitivity to assumptions" in one for one in shown] == [False, True]
    assert lines[-1] == "  More: the same command with -v", "there is no report"


# --- the first ten minutes ---


@pytest.fixture
def typed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Result]:
    """Run commands in a folder that contains the log of ``gyro demo``."""
    monkeypatch.chdir(tmp_path)
    Path("demo.csv").write_bytes(SAMPLE.read_bytes())
    return lambda line: CliRunner().invoke(app, shlex.split(line), prog_name="gyro")


@pytest.mark.slow
def test_demo_writes_a_log_and_keeps_another_file(typed: Callable[..., Result]) -> None:
    Path("demo.csv").unlink()
    assert typed("demo").stdout.startswith("demo.csv: 10 runs")
    assert Path("demo.csv").read_bytes() == SAMPLE.read_bytes()
    assert Path("demo-report/report.html").is_file()
    Path("demo.csv").write_text("mine")
    assert "error G603: demo.csv exists already" in typed("demo").stderr
    assert Path("demo.csv").read_text() == "mine"


SAME = {
    "demo.csv --no-report": "analyze demo.csv --no-report",
    "--no-report demo.csv": "analyze demo.csv --no-report",
    "fit demo.csv --no-report": "analyze demo.csv --no-report",
    "plot demo.csv -f csv": "analyze demo.csv -f csv",
    "help check": "check --help",
    "help": "--help",
    "-h": "--help",
    "": "--help",
    "version": "--version",
    "docs theory": "explain theory",
    # As a word processor writes two minus signs.
    "analyze demo.csv –no-report": "analyze demo.csv --no-report",
}


@pytest.mark.slow
@pytest.mark.parametrize("line", SAME)
def test_word_that_users_try_runs_the_command_that_is_meant(
    line: str, typed: Callable[..., Result]
) -> None:
    expected = typed(SAME[line])
    assert (typed(line).output, expected.exit_code) == (expected.output, 0)


@pytest.mark.parametrize(
    ("line", "message", "hint"),
    [
        ("anal demo.csv", "no such command 'anal'", "did you mean analyze?"),
        (
            "analyze",
            "missing argument 'LOG'",
            "for example: gyro analyze demo.csv; all options: gyro analyze --help",
        ),
        (
            "analyze demo.csv --json",
            "no such option: --json",
            "did you mean --format json?",
        ),
        (
            "check demo.csv -f JSON",
            "invalid value for '--format' / '-f': 'JSON' is not one of 'text', 'json', 'ndjson'",
            "did you mean --format json?",
        ),
        (
            "check demo.csv -fix",
            "invalid value for '--format' / '-f': 'ix' is not one of 'text', 'json', 'ndjson'",
            "did you mean --fix?",
        ),
        (
            "template log.xlsx",
            "got unexpected extra argument(s) (log.xlsx)",
            (
                "for example: gyro template --weights 20g,40g,60g --position 15cm --spins "
                "200,400,600rpm --out log.xlsx; all options: gyro template --help"
            ),
        ),
        (
            "check demo.csv --loud",
            "no such option: --loud",
            "for example: gyro check demo.csv; all options: gyro check --help",
        ),
        (
            "analyze demo.csv -o",
            "option '-o' requires an argument",
            "see: gyro analyze --help",
        ),
    ],
)
def test_usage_error_has_a_code_and_a_hint(
    line: str, message: str, hint: str, typed: Callable[..., Result]
) -> None:
    done = typed(line)
    assert (done.exit_code, done.stdout, done.stderr) == (
        2,
        "",
        f"error G610: {message}\n   {hint}\n",
    )


@pytest.mark.parametrize("name", ["log.xlsx", "log.csv"])
def test_template_in_a_file_is_read_back(
    name: str, typed: Callable[..., Result]
) -> None:
    assert typed(f"template --out {name}").exit_code == 0
    assert "exists already" in typed(f"template --weights 9g --out {name}").stderr
    if name == "log.csv":
        return
    book = openpyxl.load_workbook(name)
    keys = {row[0].value: row for row in book.active if str(row[0].value).endswith(":")}
    keys["# ball_mass:"][1].value = "4.31 kg"
    for row in book.active.iter_rows(min_row=len(keys) + 1):
        if isinstance(row[0].value, int):
            row[2].value, row[3].value, row[4].value = (
                400,
                794 / (row[0].value or 50),
                "1",
            )
            row[5].value = "ccw"
    book.save(name)
    readings = gyrodata.read_log(Path(name))
    assert (
        readings.diagnostics,
        len(readings.runs),
        readings.constants["ball_mass"],
    ) == ((), 11, 4.31)
    assert readings.columns["mass"].readings[0].step == pytest.approx(1e-5)


@pytest.mark.slow
def test_open_shows_the_report_in_the_browser(
    typed: Callable[..., Result], monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    assert typed("demo.csv --open").exit_code == 0
    assert opened == [Path("demo-report/report.html").resolve().as_uri()]
    assert "error G604" in typed("demo.csv --open --no-report").stderr


@pytest.mark.slow
def test_constants_of_the_apparatus_are_next_to_the_log(
    typed: Callable[..., Result],
) -> None:
    # The log states g itself, so that only the uncertainty of the file is used.
    Path("gyro.toml").write_text('g = "9.7 m/s^2"\nu_spin = "3 %"\n')
    given, found = (
        typed(f"analyze demo.csv -f csv {more}") for more in ("--set u_spin=3%", "")
    )
    assert "constants of the apparatus: gyro.toml" in found.stderr
    assert (
        found.stdout
        == given.stdout
        != typed("analyze demo.csv -f csv --set g=9.7m/s^2").stdout
    )
    assert (
        json.loads(typed("analyze demo.csv -f json").stdout)["options"]["config"]
        == "gyro.toml"
    )


# --- outputs that would replace data, and names of outputs ---


@pytest.mark.parametrize(
    ("line", "log"),
    [
        ("analyze {log} -f csv -o {log}", "log.csv"),
        ("analyze demo.csv {log} -f csv -o {log}", "log.csv"),
        ("analyze {log} -f json -o ./{log}", "log.json"),
        ("analyze {log} -o .", "runs.csv"),
        ("analyze {log} -o d", "d/runs.csv"),
        ("analyze demo.csv -o d", "d/runs.csv"),
        ("analyze demo.csv -f markdown -o d", "d/results.json"),
    ],
)
def test_output_never_replaces_a_log(
    line: str, log: str, typed: Callable[..., Result]
) -> None:
    Path(log).parent.mkdir(exist_ok=True)
    Path(log).write_bytes(SAMPLE.read_bytes())
    before = sorted(Path().rglob("*"))
    done = typed(line.format(log=log))
    assert (done.exit_code, done.stdout) == (2, "")
    assert "error G603" in done.stderr
    assert "so that your data are not lost" in done.stderr
    assert Path(log).read_bytes() == SAMPLE.read_bytes()
    assert sorted(Path().rglob("*")) == before


@pytest.mark.slow
def test_report_replaces_an_older_report(typed: Callable[..., Result]) -> None:
    for _ in range(2):
        assert typed("analyze demo.csv -o report").exit_code == 0
    done = typed("analyze report/runs.csv -o report")
    assert "report/runs.csv exists already" in done.stderr


TABLES = ("template", "plan demo.csv --minutes 5", "plan --minutes 5")


@pytest.mark.slow
@pytest.mark.parametrize("command", TABLES)
def test_table_has_the_format_of_its_name(
    command: str, typed: Callable[..., Result]
) -> None:
    text = typed(f"{command} --out -").stdout
    assert "mass [g],position [cm]" in text
    assert not Path("-").exists()
    for name in ("table.csv", "table.TXT"):
        assert typed(f"{command} --out {name}").exit_code == 0
        assert Path(name).read_text(encoding="utf-8") == text
    assert typed(f"{command} --out table.xlsx").exit_code == 0
    sheet = openpyxl.load_workbook("table.xlsx").active
    assert sheet.max_row == len(text.splitlines())
    for name in ("table", "table.ods", "table.json"):
        done = typed(f"{command} --out {name}")
        assert (done.exit_code, Path(name).exists()) == (2, False)
        assert "error G638" in done.stderr


@pytest.mark.parametrize(
    ("line", "code", "words"),
    [
        ("analyze ''", "G610", "a word of the command is empty"),
        ("grade ''", "G610", "give it a value"),
        ("plan demo.csv --out ''", "G610", "a word of the command is empty"),
        ("analyze demo.csv --no-report -o x", "G604", "leave --out or --no-report out"),
        ("simulate --out x.csv", "G610", "> log.csv"),
        ("simulate -o x.csv", "G610", "> log.csv"),
        ("plan demo.csv demo.csv", "G610", "gyro plan --help"),
        ("analyze demo.csv --set g=9.8 --set g=9.9", "G601", "keep the value"),
        ("analyze demo.csv --map time=a --map time=b", "G601", "keep the value"),
    ],
)
def test_use_that_contradicts_itself_is_refused(
    line: str, code: str, words: str, typed: Callable[..., Result]
) -> None:
    before = sorted(Path().rglob("*"))
    done = typed(line)
    assert (done.exit_code, done.stdout) == (2, "")
    assert f"error {code}: " in done.stderr
    assert words in done.stderr
    assert sorted(Path().rglob("*")) == before
