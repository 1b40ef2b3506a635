"""What the README and the pages of `gyro explain` show is what happens."""

from __future__ import annotations

import os
import re
import shutil
from functools import cache
from pathlib import Path

import pytest
from documents import BIN, DOCUMENTS, INSTALLS, ROOT, blocks, cells, cropped, run, typed
from simulated_labs import analyze_briefly

README = (ROOT / "README.md").read_text(encoding="utf-8")
MAIN, TESTS = re.findall(r"^python3 -m venv .*$", README, re.MULTILINE)


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: path.stem)
def test_what_is_typed_gives_what_is_shown(path: Path, tmp_path: Path) -> None:
    examples = list(typed(path.read_text(encoding="utf-8"), tmp_path))
    assert len(examples) > 0
    assert [f"{command}: {wrong}" for command, _, _, wrong in examples if wrong] == []
    for command, shown, came, _ in examples:
        assert not shown.strip() or cropped(came, shown) == shown.rstrip(), command


def test_the_main_commands_install_and_analyse_or_test() -> None:
    assert "pip install" in MAIN
    assert MAIN.endswith(" && .venv/bin/gyro analyze sample_data/air_gyroscope.csv")
    assert TESTS.endswith("-m pytest")


PIPELINES = (ROOT / "gyrodata" / "docs" / "pipelines.md").read_text(encoding="utf-8")
(WITH_OTHERS,) = (
    block.body.splitlines() for block in blocks(PIPELINES) if block.mark == "tools"
)


@cache
def sample_value() -> float:
    sample = ROOT / "sample_data" / "air_gyroscope.csv"
    return float(analyze_briefly(sample).inertia.value)


@pytest.mark.parametrize("line", WITH_OTHERS)
def test_another_tool_takes_it(line: str, tmp_path: Path) -> None:
    tool = (line.split(" | ")[1] if line.startswith("gyro") else line).split()[0]
    for needed in (tool, "gyro"):
        if shutil.which(needed, path=f"{BIN}{os.pathsep}{os.environ['PATH']}") is None:
            pytest.skip(f"{needed} is not installed here")
    shutil.copytree(ROOT / "sample_data", tmp_path / "sample_data")
    for block in blocks(PIPELINES):
        if block.mark == "file":
            (tmp_path / block.told).write_text(block.body, encoding="utf-8")
    done = run(line, tmp_path)
    assert done.returncode == 0, done.stderr
    if tool == "sqlite-utils":
        done = run("sqlite-utils rows labs.db logs", tmp_path)
    made = tmp_path / "sample_data" / "air_gyroscope.json"
    told = made.read_text(encoding="utf-8") if made.exists() else done.stdout
    # pandas shows six digits.
    right = f"{sample_value():.6f}"
    assert right in re.sub(
        r"(0\.\d{6})\d+", lambda found: f"{float(found[0]):.6f}", told
    )


def test_what_is_not_tried_sets_a_machine_up() -> None:
    lines = [
        line
        for b in blocks(README + PIPELINES)
        if b.kind == "sh"
        for line in b.body.splitlines()
    ]
    left = {line.split()[0] for line in lines if line.startswith(INSTALLS)}
    assert left == {"python3", "source", "hyperfine"}


def test_first_answer_and_length_of_the_readme() -> None:
    prose = re.sub(r"```.*?```", "", README, flags=re.DOTALL)
    assert len(README.split("I_zz = (")[0].split()) <= 90
    assert len(README.split()) <= 750
    assert len(prose.split()) <= 600


def test_readme_and_first_timer_have_the_same_first_log() -> None:
    rows = [
        line.split(",")
        for b in blocks(README)
        if b.mark == "file"
        for line in b.body.splitlines()
    ]
    page = (ROOT / "gyrodata" / "docs" / "first-timer.md").read_text(encoding="utf-8")
    (table,) = (cells(block.body) for block in blocks(page) if block.mark == "workbook")
    assert [[cell for cell in row[1:] if cell] for row in table[1:]] == rows


def test_commands_of_the_readme_run_in_every_shell() -> None:
    typed = "".join(
        block.body for block in blocks(README) if block.kind in ("console", "sh")
    )
    assert re.findall(r"\b(?:sed|head|tail|grep)\b|2>", typed) == []
