"""What is published: what the wheel and the source contain, and the versions of its
libraries.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest
from places import ROOT

PACKAGE = {
    path.relative_to(ROOT).as_posix()
    for path in (ROOT / "gyrodata").rglob("*")
    if path.is_file() and "__pycache__" not in path.parts
}


def test_the_wheel_and_the_source_contain_what_they_should(tmp_path: Path) -> None:
    pytest.importorskip("hatchling")
    line = [sys.executable, "-m", "hatchling", "build", "--directory", str(tmp_path)]
    subprocess.run(line, cwd=ROOT, check=True, capture_output=True)
    with zipfile.ZipFile(next(tmp_path.glob("*.whl"))) as wheel:
        assert {
            name for name in wheel.namelist() if ".dist-info/" not in name
        } == PACKAGE
    with tarfile.open(next(tmp_path.glob("*.tar.gz"))) as source:
        names = {
            member.name.partition("/")[2]
            for member in source.getmembers()
            if member.isfile()
        }
    beside = {
        "README.md",
        "pyproject.toml",
        ".github/CONTRIBUTING.md",
        ".github/START-HERE.md",
        ".github/RECIPES.md",
        ".ci/run",
        ".gitignore",
        "PKG-INFO",
    }
    assert {
        name
        for name in names
        if not name.startswith(("gyrodata/", "tests/", "sample_data/"))
    } == beside
    assert names >= {
        *PACKAGE,
        "tests/acceptance/test_packaging.py",
        "tests/data/promises.toml",
        "sample_data/notebook.ipynb",
    }


def test_the_top_level_contains_nothing_else() -> None:
    listed = subprocess.run(
        ["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    if listed.returncode != 0:
        pytest.skip("this copy is not a repository of git")
    top_level = {name.partition("/")[0] for name in listed.stdout.splitlines()}
    assert {name for name in top_level if not name.startswith(".")} == {
        "README.md",
        "gyrodata",
        "pyproject.toml",
        "sample_data",
        "tests",
    }


def test_every_library_has_a_lower_limit_and_none_has_an_upper_limit() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))[
        "project"
    ]
    named = [*project["dependencies"], *project["optional-dependencies"]["test"]]
    assert [one for one in named if not re.fullmatch(r"[\w-]+>=[\d.]+", one)] == []
