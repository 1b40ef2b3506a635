"""Many logs in one call: one bad log does not stop the others, and the memory does not grow with their number."""

from __future__ import annotations

import gc
import json
import os
import subprocess
import sys
import tracemalloc
from pathlib import Path

import pytest
from typer.testing import CliRunner

from gyrodata.cli import app

ROOT = Path(__file__).parent.parent
SAMPLE = (ROOT / "sample_data" / "air_gyroscope.csv").read_text(encoding="utf-8")


def logs(folder: Path, count: int) -> list[str]:
    for i in range(count):
        (folder / f"{i}.csv").write_text(
            SAMPLE.replace("1,20.00,15.00,205.0", f"1,20.00,15.00,{205 + i % 10}"), "utf-8"
        )
    return [str(folder / f"{i}.csv") for i in range(count)]


def environment() -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(ROOT)}


@pytest.mark.parametrize("count", [5, 60], ids=["one after the other", "in worker processes"])
def test_a_bad_log_does_not_stop_the_others(count: int, tmp_path: Path) -> None:
    names = logs(tmp_path, count)
    (tmp_path / "1.csv").write_bytes(bytes(range(256)))
    (tmp_path / "2.csv").write_text("mass [g]\n20\n", encoding="utf-8")
    (tmp_path / "3.csv").unlink()
    done = subprocess.run(
        [sys.executable, "-m", "gyrodata", "analyze", "--format", "ndjson", "--quiet", *names],
        cwd=tmp_path, env=environment(), capture_output=True, check=False,
    )  # fmt: skip
    documents = [json.loads(line) for line in done.stdout.splitlines()]
    assert done.returncode == 2
    assert [document["input"]["name"] for document in documents] == [f"{i}.csv" for i in range(count)]
    assert [i for i, document in enumerate(documents) if document["result"] is None] == [1, 2, 3]
    assert all(document["diagnostics"] for document in documents[1:4])
    assert b"Traceback" not in done.stderr


def test_the_memory_does_not_grow_with_the_number_of_logs(tmp_path: Path) -> None:
    names = logs(tmp_path, 60)

    def left_after(some: list[str]) -> int:
        assert CliRunner().invoke(app, ["analyze", "--format", "ndjson", *some]).exit_code == 0
        gc.collect()
        return tracemalloc.get_traced_memory()[0] if tracemalloc.is_tracing() else 0

    # What is kept on purpose, words and units that were understood, is then there.
    left_after(names[:20])
    tracemalloc.start()
    try:
        first, second = left_after(names[20:40]), left_after(names[40:])
    finally:
        tracemalloc.stop()
    assert second - first < 20 * 1000, "one analysis alone is larger than this"
