"""A shell completes commands, options, their choices, and what `gyro explain` knows; files it completes itself."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from gyrodata.diagnostics import CODES
from gyrodata.docs import PAGES

ROOT = Path(__file__).parent.parent
START = "import sys; sys.argv[0] = 'gyro'; from gyrodata.__main__ import main; main()"


def completed(line: str, shell: str = "bash") -> list[str]:
    """Ask as a shell does, with the cursor at the end of the line."""
    words = line.split(" ")
    asked = {"_GYRO_COMPLETE": f"complete_{shell}", "COMP_WORDS": line, "COMP_CWORD": str(len(words) - 1)}
    asked |= {"_TYPER_COMPLETE_ARGS": line, "_TYPER_COMPLETE_FISH_ACTION": "get-args"}
    environment = {**os.environ, "PYTHONPATH": str(ROOT)} | asked
    done = subprocess.run([sys.executable, "-c", START], env=environment, capture_output=True, text=True, check=False)
    assert "Traceback" not in done.stderr
    return done.stdout.splitlines()


@pytest.mark.parametrize(
    ("line", "found"),
    [
        ("gyro se", ["selfcheck"]),
        ("gyro predict ti", ["tip"]),
        ("gyro analyze log.csv --fo", ["--format"]),
        ("gyro analyze --format nd", ["ndjson"]),
        ("gyro grade --lms m", ["moodle"]),
        ("gyro explain G45", [code for code in sorted(CODES) if code.startswith("G45")]),
        ("gyro explain ", [*PAGES, *sorted(CODES)]),
        ("gyro explain theory sta", ["statistics"]),
        # The shell's own files come where there is nothing to say.
        ("gyro analyze lo", []),
        ("gyro check log.csv --config ", []),
    ],
)
def test_bash(line: str, found: list[str]) -> None:
    assert [one for one in completed(line) if one] == found


def test_fish_shows_what_a_code_means() -> None:
    assert completed("gyro explain G454", "fish") == [f"G454\t{CODES['G454'].title}"]


@pytest.mark.skipif(shutil.which("bash") is None, reason="no bash here")
def test_bash_takes_what_is_to_be_installed() -> None:
    told = subprocess.run(
        [sys.executable, "-c", START, "--show-completion", "bash"],
        # Else the shell is the one that started all this, and there may be none.
        env={**os.environ, "PYTHONPATH": str(ROOT), "_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION": "1"},
        capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip
    assert "complete -o default -F _gyro_completion gyro" in told
    subprocess.run(["bash", "-n"], input=told, text=True, check=True)
