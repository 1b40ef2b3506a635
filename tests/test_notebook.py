"""The notebook in sample_data/ runs in a new kernel and shows what is stored; ``python tests/make_notebook.py``."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any

import pytest
from documents import Steady
from make_notebook import NOTEBOOK, executed

STORED: dict[str, Any] = json.loads(NOTEBOOK.read_text(encoding="utf-8"))


def joined(outputs: Iterable[dict[str, Any]]) -> list[dict[str, Any]]:
    """Put together what is printed: under load a kernel sends it in several pieces."""
    whole: list[dict[str, Any]] = []
    for output in outputs:
        kind = output["output_type"], output.get("name")
        if whole and kind == (whole[-1]["output_type"], whole[-1].get("name")) and kind[0] == "stream":
            whole[-1] = {**output, "text": "".join([*whole[-1]["text"], *output["text"]])}
        else:
            whole.append(output)
    return whole


def shown(notebook: dict[str, Any]) -> list[tuple[str, str, dict[str, str]]]:
    """List what every cell shows: words and numbers, and of a drawing that there is one."""
    told = []
    for cell in notebook["cells"]:
        for output in joined(cell.get("outputs", ())):
            parts = {**output.get("data", {}), output.get("name", "error"): output.get("text", "")}
            texts = {kind: "" if kind == "image/svg+xml" else Steady("".join(text)) for kind, text in parts.items()}
            told.append((cell["id"], output["output_type"], texts))
    return told


def test_what_is_stored_is_what_comes() -> None:
    pytest.importorskip("nbclient")
    assert shown(executed(NOTEBOOK)) == shown(STORED)


def test_what_comes_in_pieces_is_one_text() -> None:
    pieces = [{"output_type": "stream", "name": "stdout", "text": text} for text in (["a\n", "b"], "c\n", "\n")]
    other = {"output_type": "stream", "name": "stderr", "text": "d"}
    assert joined([*pieces, other]) == [{**pieces[0], "text": "a\nbc\n\n"}, other]


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
