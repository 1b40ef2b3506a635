"""The notebook in sample_data/ runs in a new kernel and shows what is stored; ``python tests/make_notebook.py``."""

from __future__ import annotations

import json
from typing import Any

import pytest
from documents import Steady
from make_notebook import NOTEBOOK, executed

STORED: dict[str, Any] = json.loads(NOTEBOOK.read_text(encoding="utf-8"))


def shown(notebook: dict[str, Any]) -> list[Any]:
    """List what every cell shows: words and numbers, and of a drawing that there is one."""
    told: list[Any] = []
    for cell in notebook["cells"]:
        for output in cell.get("outputs", ()):
            parts = {**output.get("data", {}), output.get("name", "error"): output.get("text", "")}
            texts = {kind: "" if kind == "image/svg+xml" else "".join(text) for kind, text in parts.items()}
            # Under load a kernel sends what is printed in several pieces.
            if told and told[-1][0] == cell["id"] and told[-1][1].keys() == texts.keys() == {"stdout"}:
                told[-1][1]["stdout"] += texts["stdout"]
            else:
                told.append((cell["id"], texts))
    return [(name, {kind: Steady(text) for kind, text in texts.items()}) for name, texts in told]


def test_what_is_stored_is_what_comes() -> None:
    pytest.importorskip("nbclient")
    assert len(shown(STORED)) > 3
    assert shown(executed(NOTEBOOK)) == shown(STORED)


def test_nothing_stored_is_of_one_machine() -> None:
    text = NOTEBOOK.read_text(encoding="utf-8")
    assert len(text) < 150_000
    places = ("/tmp", "/home", "/root", "/usr", "site-packages", "Users", " object at 0x")
    assert [place for place in places if place in text] == []
    assert STORED["metadata"]["language_info"] == {"name": "python"}
    counts = [cell["execution_count"] for cell in STORED["cells"] if cell["cell_type"] == "code"]
    assert counts == list(range(1, len(counts) + 1))
    for cell in STORED["cells"]:
        assert not cell["metadata"]
        assert all(one["output_type"] != "error" and one.get("name") != "stderr" for one in cell.get("outputs", ()))
