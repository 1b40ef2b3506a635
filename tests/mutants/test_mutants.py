"""Mutants are what they are meant to be: each another program, at one place; a test of two lines misses some."""

from __future__ import annotations

import ast
from pathlib import Path
from typing import Any

import pytest

from mutants import __main__ as mutants


@pytest.mark.parametrize("room", mutants.ROOMS)
def test_each_is_another_program(room: str) -> None:
    found = list(mutants.places(room))
    assert len(found) > 200
    for path, node, other in found[:: len(found) // 12]:
        text, _ = mutants.written(path, node, other)
        before = ast.dump(ast.parse(path.read_text(encoding="utf-8")))
        assert ast.dump(ast.parse(text)) != before


def test_one_that_is_noticed_and_one_that_is_not(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package, tests = tmp_path / "gyrodata", tmp_path / "tests"
    package.mkdir()
    tests.mkdir()
    (package / "physics.py").write_text("def area(r):\n    return 3 * r * r\n\ndef never(r):\n    return r + 1\n")
    (tests / "test_area.py").write_text(
        "import importlib.util\nspec = importlib.util.spec_from_file_location('p', 'gyrodata/physics.py')\n"
        "p = importlib.util.module_from_spec(spec)\nspec.loader.exec_module(p)\n"
        "def test_area():\n    assert p.area(2) == 12\n"
    )
    monkeypatch.setattr(mutants, "ROOT", tmp_path)
    monkeypatch.setattr(mutants, "ROOMS", {"physics": ["test_area.py"]})
    lives: dict[str, Any] = {}
    for path, node, other in list(mutants.places("physics")):
        whole = path.read_text()
        text, new = mutants.written(path, node, other)
        path.write_text(text)
        lives[f"{ast.unparse(node)} -> {new}"] = mutants.survives(tmp_path, "physics", 60.0)
        path.write_text(whole)
    assert lives == {
        "3 * r * r -> (3 * r / r)": False, "3 * r -> (3 / r)": False, "3 -> (4)": False,
        "r + 1 -> (r - 1)": True, "1 -> (2)": True,
    }  # fmt: skip
