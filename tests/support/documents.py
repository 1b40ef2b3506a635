"""The README and the pages of `gyro explain`, and what a reader does who types their
examples one after the other.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from forked import run_gyro, run_script
from msgspec import Struct
from places import ROOT
from typer.testing import CliRunner

BIN = Path(sys.executable).parent
PAGES = sorted((ROOT / "gyrodata" / "docs").glob("*.md"))
DOCUMENTS = [ROOT / "README.md", *PAGES]

INSTALLS = ("python3 -m venv", "source .venv", "pipx ", "uv ", "hyperfine ")
"""What begins so sets a machine up, and is run by `.ci/run` or by nobody."""

EXAMPLE = "python example.py"
"""Runs an example of Python, which is the file `example.py` then. Examples load the
same code: all but the first one of all pages are run in a fork."""

OF_A_SHELL = re.compile(r"[|<>;&$*?~`#\\]")
"""Signs in a line that a shell does something with. All commands of gyro without them,
but the first one, are run in a fork, too."""

BEGUN: set[str] = set()
"""Programs that were begun in a new process."""

_BLOCK = re.compile(
    r"(?:<!-- (?P<mark>\w+): (?P<told>[^>]*) -->\n)?"
    r"(?:^```(?P<kind>\w+)\n(?P<body>.*?)^```$|(?P<table>(?:^\|[^\n]*\|\n)+))",
    re.MULTILINE | re.DOTALL,
)


class Block(Struct, frozen=True):
    """A fenced block, or a table, with what a comment before it says of it."""

    kind: str
    body: str
    mark: str
    told: str


def blocks(text: str) -> list[Block]:
    """List the blocks of a document."""
    return [
        Block(
            m["kind"] or "table",
            m["body"] or m["table"] or "",
            m["mark"] or "",
            m["told"] or "",
        )
        for m in _BLOCK.finditer(text)
    ]


def cells(table: str) -> list[list[str]]:
    """Split a table into its rows, the line below the header left out."""
    rows = [
        [cell.strip() for cell in line.strip("|\n").split("|")]
        for line in table.splitlines()
    ]
    return [rows[0], *rows[2:]]


def run(
    command: str, folder: Path, *, in_fork: bool = False
) -> subprocess.CompletedProcess[str]:
    """Run a line of shell with this environment's ``gyro`` and ``python`` first on the
    path; or, in a fork, the example of Python, or a command of gyro.
    """
    environment = {**os.environ, "PATH": f"{BIN}{os.pathsep}{os.environ['PATH']}"}
    # The examples run on the installed package.
    environment.pop("PYTHONPATH", None)
    environment |= {"COLUMNS": "80", "PYTHONIOENCODING": "utf-8"}
    if in_fork and hasattr(os, "fork"):
        if command == EXAMPLE:
            return run_script(folder / "example.py", folder, environment)
        _load_code()
        return run_gyro(shlex.split(command)[1:], folder, environment)
    if shutil.which("gyro", path=str(BIN)) is None:
        command = re.sub(
            r"(^|\| )gyro ", rf"\1{shlex.quote(sys.executable)} -m gyrodata ", command
        )
    return subprocess.run(
        command,
        shell=True,
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        encoding="utf-8",
        check=False,
    )


@cache
def _load_code() -> None:
    """Let gyro load what each fork, and each of its workers, would load for itself."""
    from gyrodata.cli import app

    with TemporaryDirectory() as folder:
        (log,) = (ROOT / "sample_data" / "class").glob("adlernina*")
        Path(folder, "class").mkdir()
        shutil.copy(log, Path(folder, "class"))
        words = ["grade", f"{folder}/class", "--out", f"{folder}/grades"]
        done = CliRunner().invoke(app, [*words, "--workers", "0"])
    assert done.exit_code == 0, done.output


def cropped(came: str, shown: str) -> str:
    """Leave lines out of an output as a document does with lines "…".

    What is between two of them is found by its first line.
    """
    whole, parts = (
        came.rstrip().split("\n"),
        [part.strip("\n").split("\n") for part in shown.split("…\n")],
    )
    if len(parts) == 1:
        return came.rstrip()
    first, *middle, last = [[] if part == [""] else part for part in parts]
    starts = [whole.index(part[0]) if part[0] in whole else 0 for part in middle]
    kept = [
        whole[start : start + len(part)]
        for start, part in zip(starts, middle, strict=True)
    ]
    kept = [whole[: len(first)], *kept, whole[len(whole) - len(last) :]]
    return "\n…\n".join("\n".join(part) for part in kept).strip("\n")


def typed(text: str, folder: Path) -> Iterator[tuple[str, str, str, str]]:
    """Type a document's examples in their order: what was typed, what is shown, what
    came, and what went wrong.
    """
    shutil.copytree(ROOT / "sample_data", folder / "sample_data")
    listed = blocks(text)
    for block, below in pairwise([*listed, None]):
        commands: list[tuple[str, str, str]] = []
        if block.mark == "file":
            (folder / block.told).write_text(block.body, encoding="utf-8")
        elif block.mark == "workbook":
            _workbook(cells(block.body), folder / block.told)
        elif block.kind == "console":
            shown = re.findall(
                r"^\$ (.*)\n((?:(?!\$ ).*\n)*)", block.body, re.MULTILINE
            )
            commands = [(command, command, came) for command, came in shown]
        elif block.kind == "sh" and block.mark != "tools":
            lines = re.sub(r"\\\n\s*", "", block.body).splitlines()
            commands = [
                (line, line, "") for line in lines if not line.startswith(INSTALLS)
            ]
        elif block.kind == "python" and below:
            (folder / "example.py").write_text(block.body, encoding="utf-8")
            commands = [(EXAMPLE, block.body, below.body)]
        for line, said, came in commands:
            program = line.split()[0]
            is_plain = line == EXAMPLE or program == "gyro"
            in_fork = is_plain and program in BEGUN and not OF_A_SHELL.search(line)
            BEGUN.add(program)
            done = run(line, folder, in_fork=in_fork)
            right = done.returncode == int(
                (block.kind == "console" and block.told) or 0
            )
            yield (
                said,
                came,
                done.stdout,
                "" if right else f"exit {done.returncode}: {done.stderr}",
            )


def _workbook(rows: list[list[str]], path: Path) -> None:
    """Type a table into a spreadsheet: what looks like a number is one, and shows the
    digits that are typed.
    """
    import openpyxl

    book = openpyxl.Workbook()
    sheet = book.active
    assert sheet is not None
    # The first row has the letters of the columns, and the first column the numbers of
    # the rows.
    for row in rows[1:]:
        sheet.append(
            [
                float(cell) if re.fullmatch(r"[\d.]+", cell) else cell or None
                for cell in row[1:]
            ]
        )
        for cell, text in zip(sheet[sheet.max_row], row[1:], strict=True):
            if re.fullmatch(r"\d+\.\d+", text):
                cell.number_format = "0." + "0" * len(text.partition(".")[2])
    book.save(path)


NUMBER = re.compile(r"\d+(?:\.\d+)?(?:e[-+]?\d+)?")


class Steady:
    """A text that equals another of the same words and the same numbers, to ten digits;
    figures by their names.
    """

    def __init__(self, text: str) -> None:
        text = re.sub(
            r"data:image/(?:png|svg\+xml);base64,[A-Za-z0-9+/=]+", "FIGURE", text
        )
        self.words, self.numbers = (
            NUMBER.sub("№", text),
            [float(number) for number in NUMBER.findall(text)],
        )

    def __eq__(self, other: object) -> bool:
        # What is left when two numbers cancel has fewer digits.
        return (
            isinstance(other, Steady)
            and self.words == other.words
            and other.numbers == pytest.approx(self.numbers, rel=2e-10, abs=1e-12)
        )

    def __repr__(self) -> str:
        numbers = iter(self.numbers)
        return re.sub("№", lambda _: f"{next(numbers):.10g}", self.words)
