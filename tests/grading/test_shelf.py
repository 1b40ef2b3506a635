"""A shelf: what was put on it comes back, nothing of it is held, and where there is no room it says so."""

from __future__ import annotations

import errno
import tempfile
import tracemalloc
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from grading import mishaps
from grading.classes import make_folder, make_zip
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

from gyrodata.cli import app
from gyrodata.errors import InputError
from gyrodata.grading.exports.summary import class_summary
from gyrodata.grading.folder import changes_in, write_results
from gyrodata.grading.handback import write_feedback
from gyrodata.grading.journal import Journal
from gyrodata.grading.rubric import default_rubric
from gyrodata.grading.run import Way, grade_class
from gyrodata.grading.shelf import Shelf
from gyrodata.grading.submissions import find_submissions

THINGS = st.lists(st.tuples(st.text(max_size=3), st.none() | st.floats(allow_nan=False) | st.text()), max_size=20)


@settings(max_examples=50, deadline=None, derandomize=True)
@given(THINGS)
def test_it_gives_back_what_a_mapping_would(things: list[tuple[str, object]]) -> None:
    shelf: Shelf[object] = Shelf()
    held: dict[str, object] = {}
    for key, thing in things:
        shelf.put(key, thing)
        held[key] = thing
        assert shelf[key] == thing
    assert dict(shelf) == held
    assert list(shelf.values()) == list(held.values())
    assert (len(shelf), "no such key" in shelf) == (len(held), False)
    with pytest.raises(KeyError):
        shelf["no such key"]


def test_nothing_of_it_is_held() -> None:
    shelf: Shelf[bytes] = Shelf()
    tracemalloc.start()
    for number in range(50):
        shelf.put(str(number), bytes(100_000))
    held, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert held < 300_000


class _Full:
    """A file on a disk that is full."""

    def seek(self, place: int) -> int:
        return place

    def write(self, data: bytes) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    def close(self) -> None:
        pass


def test_a_full_disk_is_told() -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tempfile, "TemporaryFile", lambda prefix: _Full())
        shelf: Shelf[int] = Shelf()
    with pytest.raises(InputError, match="G768: there is no room for temporary files: No space left on device"):
        shelf.put("a", 1)


def test_where_no_temporary_file_can_be_made_the_command_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def none(prefix: str) -> None:
        raise FileNotFoundError(errno.ENOENT, "No usable temporary directory found")

    root = make_folder(tmp_path / "class", {"ann/lab.csv": "", "bob/lab.csv": "x"})
    monkeypatch.setattr(tempfile, "TemporaryFile", none)
    done = CliRunner().invoke(app, ["grade", str(root), "--out", str(tmp_path / "grades")])
    assert done.exit_code == 2
    assert "error G768: there is no room for temporary files: No usable temporary directory found" in done.stderr
    assert "TMPDIR" in done.stderr


# --- a whole class ------------------------------------------------------------------------------------------

LEAST, MORE = 20, 100
"""Students of two classes."""

MOST = 10_000
"""What one student more may take at the peak [byte]: most of it are tuples that Python keeps for reuse, up to a limit
that so small a class does not reach."""


@contextmanager
def measured(peaks: list[int]) -> Iterator[None]:
    tracemalloc.start()
    try:
        yield
        peaks.append(tracemalloc.get_traced_memory()[1])
    finally:
        tracemalloc.stop()


def grade_all(root: Path, folder: Path) -> None:
    """Grade a class into a folder, as the command does."""
    way = Way(2, journal=Journal(folder / "journal.ndjson"), grader=mishaps.quick)
    found = grade_class(find_submissions(root), default_rubric(), way)
    changes_in(folder, found)
    write_results(found, folder, {})
    assert write_feedback(found, folder, way) == ()
    assert sum(1 for _ in class_summary(found)) > len(found.grades)


def test_a_larger_class_hardly_takes_more_memory(tmp_path: Path) -> None:
    # Out of zips: a file in a folder is read into room for the largest, beside which nothing else would be seen.
    grade_all(make_zip(tmp_path / "few.zip", {"s1/lab.csv": "1", "s2/lab.csv": "2"}), tmp_path / "first")
    peaks: list[int] = []
    again: list[int] = []
    for count in (LEAST, MORE):
        root = make_zip(tmp_path / f"{count}.zip", {f"s{number:04}/lab.csv": "x" for number in range(count)})
        with measured(peaks):
            grade_all(root, tmp_path / f"{count}-grades")
        with measured(again):
            grade_all(root, tmp_path / f"{count}-grades")
    assert (peaks[1] - peaks[0]) / (MORE - LEAST) < MOST
    assert (again[1] - again[0]) / (MORE - LEAST) < MOST
