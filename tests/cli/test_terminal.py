"""What a terminal shows: lines that end between words, and the answer at the end."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from unicodedata import combining

import pytest
from analyzed_once import analyzed_once
from places import SAMPLES
from streams import on_terminal
from typer.testing import CliRunner

from gyrodata.cli import app
from gyrodata.cli.documentation import for_terminal, page_text

LONG = "a note about this run that nobody can read in one line of a small terminal"
HEAD = "# ball_mass: 5.2 kg\n# ball_diameter: 101.6 mm\n"


@pytest.fixture(scope="module", autouse=True)
def analyses_are_kept() -> Iterator[None]:
    """Only how they are shown is tested."""
    with analyzed_once():
        yield


@pytest.fixture
def lab(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("TERM", "dumb")
    sample = (SAMPLES / "air_gyroscope.csv").read_text(encoding="utf-8")
    # A ball that is too heavy, and a time with a misplaced point.
    lines = re.sub(r"(?m)^# ball_.*\n", "", sample).replace(",13.06,", ",130.6,")
    Path("wrong.csv").write_text(HEAD + lines, encoding="utf-8")
    Path("sample.csv").write_text(sample, encoding="utf-8")
    return tmp_path


COMMANDS = (
    "analyze wrong.csv --no-report",
    "analyze sample.csv --no-report -v",
    "check wrong.csv",
    "check sample.csv",
    "analyze missing.csv",
    "analyze sample.csv --modle released",
    "predict precession --log sample.csv",
    "explain G454",
    "explain u_time",
    "explain settings",
    "simulate --help",
    "analyze --help",
)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("command", "width"),
    [(command, 80) for command in COMMANDS] + [(COMMANDS[0], 100), (COMMANDS[2], 100)],
)
def test_no_line_is_broken_inside_a_word(
    command: str, width: int, lab: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", str(width))
    shown = on_terminal(command, "utf-8").decode()
    assert len(shown.splitlines()) > 1
    for line in shown.splitlines():
        # The terminal breaks a line that is too long, wherever its end is. A dot above
        # a letter takes no place.
        places = sum(not combining(sign) for sign in line)
        assert places <= width or len(line.split()) == 1, line


@pytest.mark.slow
@pytest.mark.parametrize("width", [80, 120])
@pytest.mark.parametrize("page", ["first-timer", "log-format"])
def test_page_has_whole_lines_on_a_terminal(
    page: str, width: int, lab: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", str(width))
    expected = for_terminal(page_text(page), width)
    assert on_terminal(f"explain {page}", "utf-8").decode() == expected


@pytest.mark.slow
def test_the_answer_and_the_number_of_warnings_are_on_a_small_screen(
    lab: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    shown = on_terminal("analyze wrong.csv --no-report", "utf-8").decode()
    warnings = len(re.findall(r"warning G\d+", shown))
    assert warnings > 1
    screen = "\n".join(shown.splitlines()[-5:])
    assert f"{warnings} warnings above; I_zz = " in screen
    quiet = on_terminal("analyze sample.csv --no-report -q", "utf-8").decode()
    assert "above; " not in quiet


@pytest.mark.slow
def test_terminal_shows_tables_with_a_rule_and_progress(
    lab: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("TERM", "xterm")
    line = "plan sample.csv --minutes 10"
    assert re.search(r"\n  ─+\n", on_terminal(line, "utf-8").decode())
    assert "─" not in CliRunner().invoke(app, line.split()).output
    line = "selfcheck sample.csv --labs 10"
    assert "100%" in on_terminal(line, "utf-8").decode()
    assert "100%" not in CliRunner().invoke(app, line.split()).output
