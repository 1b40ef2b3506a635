"""JSON for readers that know no capitals: PowerShell, and tables of a database with the keys joined by _."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from gyrodata.cli import app
from gyrodata.grading import JOURNAL

SAMPLES = Path(__file__).parent.parent / "sample_data"
LOGS = [str(path) for path in sorted(SAMPLES.glob("*.csv"))]
CLASS = str(SAMPLES / "class")

LINES = [
    ["analyze", *LOGS, "--format", "ndjson"],
    ["analyze", LOGS[0], "--format", "json"],
    ["analyze", LOGS[0], "--set", "speed=1", "--map", "Time=t", "--format", "json"],
    ["check", *LOGS, "--format", "ndjson"],
    ["check", "--hand-in", CLASS, "--format", "json"],
    ["grade", CLASS, "--workers", "0", "--format", "json"],
    ["grade", CLASS, "--workers", "0", "--format", "ndjson"],
    ["selfcheck", LOGS[0], "--labs", "20", "--format", "json"],
    *(["predict", what, "--log", LOGS[0], "--format", "json"] for what in ("precession", "earth", "twist", "tip")),
    ["predict", "platform", "--log", LOGS[0], "--format", "json"],
    *(["schema", *what] for what in ([], ["--check"], ["--grades"], ["--predictions"], ["--selfcheck"], ["--rubric"])),
    ["schema", "--diagnostics", "--json"],
]  # fmt: skip


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[list[tuple[str, Any]]]]:
    """Every JSON that gyro writes, each object as its pairs."""
    folder = tmp_path_factory.mktemp("json")
    texts = {" ".join(line): CliRunner().invoke(app, line).stdout for line in LINES}
    CliRunner().invoke(app, ["simulate", "--truth", str(folder / "truth.json")])
    CliRunner().invoke(app, ["grade", CLASS, "--workers", "0", "-o", str(folder / "grades")])
    texts["truth"] = (folder / "truth.json").read_text(encoding="utf-8")
    texts[JOURNAL] = (folder / "grades" / JOURNAL).read_text(encoding="utf-8")
    found = {}
    for name, text in texts.items():
        parts = text.splitlines() if "ndjson" in name else [text]
        found[name] = [json.loads(part, object_pairs_hook=Pairs) for part in parts]
    return found


class Pairs(list[tuple[str, Any]]):
    """An object of JSON as it stands, with any key that comes twice."""


def objects(value: Any) -> Iterator[Pairs]:
    if isinstance(value, Pairs):
        yield value
        for _, inside in value:
            yield from objects(inside)
    elif isinstance(value, list):
        for inside in value:
            yield from objects(inside)


def columns(found: Pairs, before: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    """Give what becomes a column: a list is one, an object one for each of its own."""
    for key, value in found:
        path = (*before, key)
        if isinstance(value, Pairs) and value:
            yield from columns(value, path)
        else:
            yield path


def test_no_two_keys_of_an_object_differ_by_capitals_only(written: dict[str, Any]) -> None:
    for name, documents in written.items():
        assert documents, name
        for found in objects(documents):
            keys = [key.casefold() for key, _ in found]
            assert len(set(keys)) == len(keys), (name, keys)
            assert "" not in keys, name


def test_no_two_columns_are_called_the_same(written: dict[str, Any]) -> None:
    for name, documents in written.items():
        called: dict[str, tuple[str, ...]] = {}
        for document in documents:
            for path in columns(document):
                joined = "_".join(path).casefold()
                assert called.setdefault(joined, path) == path, name
        assert len(called) > 0


def test_two_settings_that_differ_by_capitals_only_are_refused() -> None:
    done = CliRunner().invoke(app, ["analyze", LOGS[0], "--set", "g=9.8 m/s^2", "--set", "G=9.8 m/s^2", "-f", "json"])
    assert done.exit_code == 2
    assert done.stdout == ""
    assert "error G601: --set has g and G, which differ by capitals only" in done.stderr
