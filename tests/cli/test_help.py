"""The help of every command is whole and has an example that works, and a shell
completes what is typed.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import typer
from analyzed_once import analyzed_once
from documents import ROOT
from typer.testing import CliRunner

from gyrodata.base.diagnostics import explanations
from gyrodata.cli import app
from gyrodata.cli.documentation import PAGES


@pytest.fixture(scope="module", autouse=True)
def analyses_are_kept() -> Iterator[None]:
    """Most examples show the analysis of one log."""
    with analyzed_once():
        yield


def commands(command: Any, name: str = "gyro") -> Iterator[tuple[str, Any]]:
    yield name, command
    for sub, one in getattr(command, "commands", {}).items():
        yield from commands(one, f"{name} {sub}")


COMMANDS = dict(commands(typer.main.get_command(app)))
ALONE = [
    name
    for name, one in COMMANDS.items()
    if not hasattr(one, "commands") and not one.hidden
]


def help_of(name: str) -> str:
    return str(
        COMMANDS[name].get_help(
            COMMANDS[name].context_class(COMMANDS[name], info_name=name)
        )
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", COMMANDS)
@pytest.mark.parametrize("width", [60, 80])
def test_help_is_whole(name: str, width: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", str(width))
    command, shown = COMMANDS[name], help_of(name)
    lines, flowing = shown.splitlines(), " ".join(shown.split())
    assert max(map(len, lines)) <= width
    # Terminals of Windows may show nothing else.
    assert shown.isascii()
    assert [
        line
        for line in lines
        if re.search(r"…|-$|(?<!\])\.\.\.$", line) and not line.startswith("Usage")
    ] == []
    for param in command.params:
        if param.param_type_name == "option" and not param.hidden:
            assert param.help, param.name
            assert " ".join((param.help or "").split()) in flowing
            assert all(
                re.search(rf"(?<![\w-]){re.escape(option)}(?![\w-])", shown)
                for option in param.opts
            )
    for sub, one in getattr(command, "commands", {}).items():
        assert one.hidden or f"{sub} {one.short_help}" in flowing
    assert name not in ALONE or f"  Example:  {name}" in "".join(lines[-4:])
    if name in ("gyro analyze", "gyro check", "gyro grade"):
        assert len(examples_of(name)) == 3


def examples_of(name: str) -> list[str]:
    """Return the commands at the foot of a help, each in one line."""
    foot = help_of(name).partition("Example:")[2].replace("\\\n", " ")
    return [" ".join(line.split()) for line in foot.splitlines() if line.strip()]


@pytest.mark.slow
@pytest.mark.parametrize("name", ALONE)
def test_the_examples_at_the_foot_work(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    if name != "gyro demo":
        shutil.copy(ROOT / "sample_data" / "air_gyroscope.csv", "demo.csv")
    shutil.copytree(ROOT / "sample_data" / "class", "class")
    # The benchmark takes a minute, and 1,000 labs 5 s: of the first, only the options
    # are read.
    more = {"gyro benchmark": ["--help"], "gyro selfcheck": ["--labs", "20"]}
    for example in examples_of(name):
        command, _, file = example.partition(" > ")
        _, *words = shlex.split(command)
        done = CliRunner().invoke(app, [*words, *more.get(name, [])])
        if file:
            Path(file).write_text(done.stdout, encoding="utf-8")
        # The sample's class has three that cannot be graded.
        is_class = name == "gyro grade" and not file
        assert done.exit_code == (1 if is_class else 0), example
        assert "error" not in done.stderr, example


START = [
    sys.executable,
    "-c",
    "import sys; sys.argv[0] = 'gyro'; from gyrodata.__main__ import main; main()",
]
OURS = {**os.environ, "PYTHONPATH": str(ROOT)}


def completed(line: str) -> list[str]:
    """Ask as a shell does, with the cursor at the end of the line."""
    asked = {
        "_GYRO_COMPLETE": "complete_bash",
        "COMP_WORDS": line,
        "COMP_CWORD": str(line.count(" ")),
    }
    done = subprocess.run(
        START, env=OURS | asked, capture_output=True, text=True, check=False
    )
    assert "Traceback" not in done.stderr
    return [one for one in done.stdout.splitlines() if one]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("line", "found"),
    [
        ("gyro se", ["selfcheck"]),
        ("gyro analyze log.csv --fo", ["--format"]),
        ("gyro analyze --format nd", ["ndjson"]),
        ("gyro explain ", [*PAGES, *sorted(explanations())]),
        # The shell's own files come where there is nothing to say.
        ("gyro analyze lo", []),
    ],
)
def test_bash_completes(line: str, found: list[str]) -> None:
    assert completed(line) == found
