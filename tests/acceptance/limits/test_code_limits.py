"""Code that is hard to read cannot land: by a branch, a table of lambdas, or a text."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest
from places import PACKAGE

HERE = Path(__file__).parent
TWELVE = range(12)
BRANCHES = "def new(x):\n" + "".join(
    f"    if x == {at}:\n        return {at + 1}\n" for at in TWELVE
)
LAMBDAS = (
    "NEW = (\n"
    + "".join(f"    lambda x: {at} if x else None,\n" for at in TWELVE)
    + ")\n"
)
EVALUATED = f"def new(x):\n    return eval({' + '.join('x' * 12)!r}, {{'x': x}})\n"
EXECUTED = f"def new(x):\n    exec({BRANCHES!r})\n"


def checked(package: Path) -> tuple[int, str]:
    """Run the two checks of the continuous integration on a package."""
    ruff = [sys.executable, "-m", "ruff", "check", "--select", "S102,S307"]
    ruff += ["--isolated", str(package)]
    limits = [sys.executable, str(HERE), str(package)]
    found = ""
    code = 0
    for command in (ruff, limits):
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        code = code or done.returncode
        found += done.stdout + done.stderr
    return code, found


@pytest.fixture
def package(tmp_path: Path) -> Path:
    shutil.copytree(
        PACKAGE / "physics",
        tmp_path / "gyrodata" / "physics",
        ignore=shutil.ignore_patterns("__pycache__"),
    )
    return tmp_path / "gyrodata"


def test_package_keeps_its_limits() -> None:
    assert checked(PACKAGE) == (0, "All checks passed!\nall limits are kept\n")


HARD_TO_READ = (
    ("closed_forms", BRANCHES, "closed_forms.py:new: decisions 12, a new one"),
    ("motion", LAMBDAS, "motion.py:(module): decisions 12, a new one"),
    ("models", EVALUATED, "S307"),
    ("prediction", EXECUTED, "S102"),
    ("__init__", f"WORDS = {' '.join(['word'] * 6000)!r}\n", "physics has grown"),
)
"""A module of `physics`, code that is added to it, and what is then found."""


def test_code_that_is_hard_to_read_fails(package: Path) -> None:
    for module, code, _ in HARD_TO_READ:
        place = package / "physics" / f"{module}.py"
        place.write_text(place.read_text("utf-8") + "\n\n" + code, encoding="utf-8")
    status, found = checked(package)
    assert status == 1
    for _, _, words in HARD_TO_READ:
        assert words in found


def test_a_function_of_the_list_may_not_get_worse() -> None:
    code = """
        from limits.__main__ import new_complexity
        from limits.measures import Measures

        functions = {"decisions": {"a.py:better": 11, "a.py:worse": 13}}
        listed = {"decisions": {"a.py:better": 12, "a.py:worse": 12}}
        print(*new_complexity(Measures(functions, {}, {}), listed))
    """
    assert printed(code) == (
        "a.py:worse: decisions 13, more than the 12 of the list: "
        "let each function do one thing\n"
    )


def test_growth_of_a_room_needs_a_reason() -> None:
    code = """
        from limits.__main__ import allowed_size

        growth = [{"nodes": 120, "why": "a new model"}, {"nodes": 50, "why": " "}]
        print(allowed_size({"size": 1000, "growth": growth}))
    """
    assert printed(code) == "1120\n"


def printed(code: str) -> str:
    """Run some code next to the limits, and return what it prints."""
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(code)],
        env={**os.environ, "PYTHONPATH": str(HERE.parent)},
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout
