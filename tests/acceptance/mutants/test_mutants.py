"""A mutant that a test notices is killed, and one that no test notices has survived."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = (
    "STEP = 2\ndef area(r):\n    return 3 * r * r\ndef never(r):\n    return r + 1\n"
    "def near(r):\n    return r < STEP\n"
)
WARNING = "class Warned(UserWarning):\n    pass\n"
SETTINGS = """\
[tool.pytest.ini_options]
filterwarnings = ["error", "ignore::gyrodata.Warned"]
"""
TESTS = """\
import warnings
from gyrodata import Warned, physics
warnings.warn("while the tests are collected", Warned)
def test_area():
    assert physics.area(2) == 12
def test_near():
    assert physics.near(1) and physics.near(2.5) is False
"""


def test_a_mutant_that_is_noticed_is_killed(tmp_path: Path) -> None:
    pytest.importorskip("coverage")
    shutil.copytree(
        Path(__file__).parent, tmp_path / "tests" / "acceptance" / "mutants"
    )
    (tmp_path / "tests" / "area").mkdir()
    (tmp_path / "tests" / "area" / "test_area.py").write_text(TESTS)
    (tmp_path / "gyrodata").mkdir()
    (tmp_path / "pyproject.toml").write_text(SETTINGS)
    (tmp_path / "gyrodata" / "__init__.py").write_text(WARNING)
    (tmp_path / "gyrodata" / "physics.py").write_text(PACKAGE)
    rooms = "rooms.clear(); rooms['physics'] = ('physics.py', 'area')"
    code = f"from mutants.__main__ import ROOMS as rooms, main; {rooms}; main()"
    environment = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith("PYTEST")
    }
    environment["PYTHONPATH"] = str(tmp_path / "tests" / "acceptance")
    line = [sys.executable, "-c", code, "--count", "99"]
    done = subprocess.run(
        line, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True
    )
    *told, share = done.stdout.splitlines()
    assert share == "seed 1: 71.4% of 7 mutants killed, of 7 that there are"
    assert {tuple(one.split(maxsplit=1)) for one in told} == {
        ("killed", "physics.py:1: 2 -> 3"),
        ("killed", "physics.py:3: 3 * r * r -> 3 * r / r"),
        ("killed", "physics.py:3: 3 * r -> 3 / r"),
        ("killed", "physics.py:3: 3 -> 4"),
        ("SURVIVED", "physics.py:5: r + 1 -> r - 1"),
        ("SURVIVED", "physics.py:5: 1 -> 2"),
        ("killed", "physics.py:7: r < STEP -> r >= STEP"),
    }
