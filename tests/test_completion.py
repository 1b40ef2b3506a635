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

START = [sys.executable, "-c", "import sys; sys.argv[0] = 'gyro'; from gyrodata.__main__ import main; main()"]
OURS = {**os.environ, "PYTHONPATH": str(Path(__file__).parent.parent)}


def completed(line: str) -> list[str]:
    """Ask as a shell does, with the cursor at the end of the line."""
    asked = {"_GYRO_COMPLETE": "complete_bash", "COMP_WORDS": line, "COMP_CWORD": str(line.count(" "))}
    done = subprocess.run(START, env=OURS | asked, capture_output=True, text=True, check=False)
    assert "Traceback" not in done.stderr
    return [one for one in done.stdout.splitlines() if one]


@pytest.mark.parametrize(
    ("line", "found"),
    [
        ("gyro se", ["selfcheck"]),
        ("gyro analyze log.csv --fo", ["--format"]),
        ("gyro analyze --format nd", ["ndjson"]),
        ("gyro explain ", [*PAGES, *sorted(CODES)]),
        # The shell's own files come where there is nothing to say.
        ("gyro analyze lo", []),
    ],
)
def test_bash_completes(line: str, found: list[str]) -> None:
    assert completed(line) == found


@pytest.mark.skipif(shutil.which("bash") is None, reason="no bash here")
def test_bash_takes_what_is_to_be_installed() -> None:
    # Else the shell is the one that started all this, and there may be none.
    alone = OURS | {"_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION": "1"}
    done = subprocess.run([*START, "--show-completion", "bash"], env=alone, capture_output=True, text=True, check=True)
    assert "complete -o default -F _gyro_completion gyro" in done.stdout
    subprocess.run(["bash", "-n"], input=done.stdout, text=True, check=True)
