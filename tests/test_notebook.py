"""The notebook in sample_data/ runs in a new kernel and shows what is stored; ``python tests/make_notebook.py``."""

from __future__ import annotations

import json
from typing import Any

import pytest
from golden import Steady
from make_notebook import NOTEBOOK, executed

STORED: dict[str, Any] = json.loads(NOTEBOOK.read_text(encoding="utf-8"))


def shown(notebook: dict[str, Any]) -> list[tuple[str, str, dict[str, str]]]:
    """List what every cell shows: words and numbers, and of a drawing that there is one."""
    told = []
    for cell in notebook["cells"]:
        for output in cell.get("outputs", ()):
            parts = {**output.get("data", {}), output.get("name", "error"): output.get("text", "")}
            texts = {kind: "" if kind == "image/svg+xml" else Steady("".join(text)) for kind, text in parts.items()}
            told.append((cell["id"], output["output_type"], texts))
    return told


def test_what_is_stored_is_what_comes() -> None:
    pytest.importorskip("nbclient")
    assert shown(executed(NOTEBOOK)) == shown(STORED)


def test_nothing_stored_is_of_one_machine() -> None:
    text = NOTEBOOK.read_text(encoding="utf-8")
    assert len(text) < 150_000
    for told in ("/tmp", "/home", "/root", "/usr", "site-packages", "Users", " object at 0x"):
        assert told not in text
    assert STORED["metadata"]["language_info"] == {"name": "python"}
    counts = [cell["execution_count"] for cell in STORED["cells"] if cell["cell_type"] == "code"]
    assert counts == list(range(1, len(counts) + 1))
    for cell in STORED["cells"]:
        assert not cell["metadata"]
        assert all(one["output_type"] != "error" and one.get("name") != "stderr" for one in cell.get("outputs", ()))
