"""The notebook in sample_data/ runs in a new kernel and shows what is stored; ``python
tests/make_notebook.py``.
"""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path
from typing import Any

import pytest
from documents import Steady
from make_notebook import NOTEBOOK, executed

STORED: dict[str, Any] = json.loads(NOTEBOOK.read_text(encoding="utf-8"))


def shown(notebook: dict[str, Any]) -> list[Any]:
    """List what every cell shows: words and numbers, and of a drawing that there is
    one.
    """
    told = []
    for cell in notebook["cells"]:
        texts: dict[str, str] = {}
        for output in cell.get("outputs", ()):
            # Under load a kernel sends what is printed in several pieces.
            for kind, text in {
                **output.get("data", {}),
                output.get("name", "error"): output.get("text", ""),
            }.items():
                texts[kind] = texts.get(kind, "") + (
                    "" if kind == "image/svg+xml" else "".join(text)
                )
        told.append({kind: Steady(text) for kind, text in texts.items()})
    return [texts for texts in told if texts]


def test_what_is_stored_is_what_comes(tmp_path: Path) -> None:
    pytest.importorskip("nbclient")
    shutil.copy(NOTEBOOK.with_name("air_gyroscope.csv"), tmp_path)
    notebook = tmp_path / NOTEBOOK.name
    # With fewer labs the last cell shows another share.
    text = NOTEBOOK.read_text(encoding="utf-8").replace("labs=400", "labs=20")
    notebook.write_text(text, encoding="utf-8")
    *stored, stored_share = shown(STORED)
    *come, share = shown(executed(notebook))
    assert len(stored) > 3
    assert come == stored
    assert share["stdout"].words == stored_share["stdout"].words


def test_nothing_stored_is_of_one_machine() -> None:
    text = NOTEBOOK.read_text(encoding="utf-8")
    assert len(text) < 160_000
    assert (
        re.findall(
            r"/(?:tmp|home|root|usr)\b|site-packages|Users| object at 0x|\"stderr\"",
            text,
        )
        == []
    )
    counts = [
        cell["execution_count"]
        for cell in STORED["cells"]
        if cell["cell_type"] == "code"
    ]
    assert counts == list(range(1, len(counts) + 1))
