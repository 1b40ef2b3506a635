"""A mutant that a test notices is killed, and one that no test notices has survived."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from mutants import __main__ as mutants

PACKAGE = """\
STEP = 2
UNUSED = 5

def area(r):
    return 3 * r * r

def never(r):
    return r + 1

def near(r):
    return r < STEP
"""
TESTS = """\
from gyrodata import physics

def test_area():
    assert physics.area(2) == 12

def test_near():
    assert physics.near(1) and physics.near(2.5) is False
"""


def test_those_that_are_noticed_and_those_that_are_not(tmp_path: Path) -> None:
    pytest.importorskip("coverage")
    for folder in ("gyrodata", "tests"):
        (tmp_path / folder).mkdir()
    (tmp_path / "gyrodata" / "__init__.py").touch()
    (tmp_path / "gyrodata" / "physics.py").write_text(PACKAGE)
    (tmp_path / "tests" / "test_area.py").write_text(TESTS)
    shutil.copytree(Path(mutants.__file__).parent, tmp_path / "tests" / "mutants")
    rooms = "rooms.clear(); rooms['physics'] = (['physics.py'], ['test_area.py'])"
    code = (
        f"import sys; sys.path.insert(0, 'tests'); from mutants.__main__ import ROOMS as rooms, main; {rooms}; main()"
    )
    line = [sys.executable, "-c", code, "--count", "99", "--budget", "1"]
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST")}
    environment["PYTHONPATH"] = str(tmp_path / "tests")
    done = subprocess.run(line, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True)
    share = "seed 1: 50.0% of 8 mutants killed, of 8 that there are: physics 4 of 8"
    assert done.stdout.splitlines()[-1] == share
    told = {tuple(one.split(maxsplit=1)) for one in done.stdout.splitlines() if "physics.py:" in one}
    assert told == {
        ("killed", "physics.py:1: : 2 -> 3"),
        ("SURVIVED", "physics.py:2: : 5 -> 6"),
        ("killed", "physics.py:5: area: 3 * r * r -> 3 * r / r"),
        ("killed", "physics.py:5: area: 3 * r -> 3 / r"),
        ("killed", "physics.py:5: area: 3 -> 4"),
        ("SURVIVED", "physics.py:8: never: r + 1 -> r - 1"),
        ("SURVIVED", "physics.py:8: never: 1 -> 2"),
        ("SURVIVED", "physics.py:11: near: r < STEP -> r <= STEP"),
    }
