"""What the README shows is what happens."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
BIN = Path(sys.executable).parent


def run(command: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run a line of shell with this environment's ``gyro`` and ``python`` first on the path."""
    environment = {**os.environ, "PATH": f"{BIN}{os.pathsep}{os.environ['PATH']}", "PYTHONPATH": str(ROOT)}
    if shutil.which("gyro", path=str(BIN)) is None:
        command = re.sub(r"(^|\| )gyro ", rf"\1{shlex.quote(sys.executable)} -m gyrodata ", command)
    return subprocess.run(
        command, shell=True, cwd=folder, env=environment, capture_output=True, text=True, encoding="utf-8", check=False
    )


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    shutil.copytree(ROOT / "sample_data", tmp_path / "sample_data")
    return tmp_path


CONSOLE = re.findall(r"```console\n\$ (.*?)\n(.*?)```", README, re.DOTALL)


@pytest.mark.parametrize(("command", "output"), CONSOLE, ids=[command.split("|")[0].strip() for command, _ in CONSOLE])
def test_console(command: str, output: str, copy: Path) -> None:
    done = run(command, copy)
    assert done.returncode == 0, done.stderr
    assert done.stdout.rstrip() == output.rstrip()


def test_python(copy: Path) -> None:
    code, output = re.findall(r"```python\n(.*?)```\n\n```text\n(.*?)```", README, re.DOTALL)[0]
    assert len([line for line in code.splitlines() if line.strip()]) <= 6
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=copy,
        env={**os.environ, "PYTHONPATH": str(ROOT), "PYTHONIOENCODING": "utf-8"},
        capture_output=True,
        text=True,
        encoding="utf-8",
        check=True,
    )
    assert done.stdout.rstrip() == output.rstrip()


def commands() -> list[str]:
    return re.findall(r"^python3 -m venv .*$", README, re.MULTILINE)


def test_two_commands_that_do_their_own_set_up() -> None:
    main, tests = commands()
    assert "pip install" in main
    assert "sample_data/" in main
    assert tests.endswith("-m pytest")


def test_the_main_command_does_what_it_says(copy: Path) -> None:
    last = commands()[0].split("&&")[-1].strip().replace(".venv/bin/gyro", "gyro")
    done = run(last, copy)
    assert done.returncode == 0, done.stderr
    shown = {path.name for path in (copy / "air_gyroscope-report").iterdir()}
    figures = {f"{name}.png" for name in ("period", "product", "torque", "residuals")}
    assert shown == {"report.html", "results.json", "runs.csv", *figures}
    assert done.stdout.startswith(CONSOLE[0][1].rstrip())


def test_the_example_log_reads(copy: Path) -> None:
    (log,) = re.findall(r"```csv\n(.*?)```", README, re.DOTALL)
    (copy / "log.csv").write_text(log, encoding="utf-8")
    assert run("gyro analyze log.csv --no-report", copy).returncode == 0
