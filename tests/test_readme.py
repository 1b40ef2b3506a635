"""What the README and the pages of `gyro explain` show is what happens."""

from __future__ import annotations

import os
import re
import shutil
from pathlib import Path

import pytest
from documents import BIN, DOCUMENTS, INSTALLS, ROOT, blocks, run, typed

import gyrodata

README = (ROOT / "README.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: path.stem)
def test_what_is_typed_gives_what_is_shown(path: Path, tmp_path: Path) -> None:
    examples = list(typed(path.read_text(encoding="utf-8"), tmp_path))
    assert len(examples) > 0
    assert [f"{command}: {wrong}" for command, _, _, wrong in examples if wrong] == []
    for command, shown, came, _ in examples:
        assert not shown.strip() or came.rstrip() == shown.rstrip(), command


def test_every_block_is_of_a_kind_that_is_tried() -> None:
    for path in DOCUMENTS:
        kinds = {block.kind for block in blocks(path.read_text(encoding="utf-8"))}
        assert kinds <= {"console", "sh", "powershell", "python", "text", "csv", "toml", "table", "make"}, path.name


def commands() -> list[str]:
    return re.findall(r"^python3 -m venv .*$", README, re.MULTILINE)


def test_two_commands_that_do_their_own_set_up() -> None:
    main, tests = commands()
    assert "pip install" in main
    assert "sample_data/" in main
    assert tests.endswith("-m pytest")


def test_the_main_command_does_what_it_says(tmp_path: Path) -> None:
    shutil.copytree(ROOT / "sample_data", tmp_path / "sample_data")
    last = commands()[0].split("&&")[-1].strip().replace(".venv/bin/gyro", "gyro")
    done = run(last, tmp_path)
    assert done.returncode == 0, done.stderr
    shown = {path.name for path in (tmp_path / "air_gyroscope-report").iterdir()}
    figures = {f"{name}.png" for name in ("period", "product", "torque", "residuals")}
    assert shown == {"report.html", "results.json", "runs.csv", *figures}


def test_windows_types_the_same() -> None:
    (windows,) = (block.body for block in blocks(README) if block.kind == "powershell")
    unix = commands()[0].replace(".venv/bin/", "").replace(" --quiet", "").split(" && ")
    typed_there = windows.replace("py -m", "python3 -m").replace("\\", "/").splitlines()
    assert typed_there == [unix[0], ".venv/Scripts/Activate.ps1", *unix[1:]]


(WITH_OTHERS,) = (block.body.splitlines() for block in blocks(README) if block.mark == "tools")


@pytest.mark.parametrize("line", WITH_OTHERS)
def test_another_tool_takes_it(line: str, tmp_path: Path) -> None:
    tool = (line.split(" | ")[1] if line.startswith("gyro") else line).split()[0]
    for needed in (tool, "gyro"):
        if shutil.which(needed, path=f"{BIN}{os.pathsep}{os.environ['PATH']}") is None:
            pytest.skip(f"{needed} is not installed here")
    shutil.copytree(ROOT / "sample_data", tmp_path / "sample_data")
    for block in blocks(README):
        if block.mark == "file":
            (tmp_path / block.told).write_text(block.body, encoding="utf-8")
    done = run(line, tmp_path)
    assert done.returncode == 0, done.stderr
    if tool == "sqlite-utils":
        done = run("sqlite-utils rows labs.db logs", tmp_path)
    if (made := tmp_path / "sample_data" / "air_gyroscope.json").exists():
        told = made.read_text(encoding="utf-8")
    else:
        told = done.stdout
    # pandas shows six digits.
    right = f"{gyrodata.analyze(tmp_path / 'sample_data' / 'air_gyroscope.csv').inertia.value:.6f}"
    assert right in told or right in re.sub(r"(0\.\d{6})\d+", lambda found: f"{float(found[0]):.6f}", told)


def test_a_line_for_each_tool_that_is_named() -> None:
    (named,) = re.findall(r"a line for each of (.*?)\.", " ".join(README.split()))
    tools = {"jq": "jq", "Miller": "mlr", "sqlite-utils": "sqlite-utils", "pandas": "pandas", "PowerShell": "pwsh"}
    listed = [tools.get(name, name) for name in re.split(", | and ", named)]
    assert len(listed) == len(WITH_OTHERS)
    assert [tool for tool, line in zip(listed, WITH_OTHERS, strict=True) if tool not in line] == []


def test_what_is_not_tried_sets_a_machine_up() -> None:
    tried = [b.body for b in blocks(README) if b.kind == "sh" and b.mark != "tools"]
    left = [line for body in tried for line in body.splitlines() if line.startswith(INSTALLS)]
    assert {line.split()[0] for line in left} == {"python3", "source", "pipx", "uv", "hyperfine"}
