"""A class through worker processes: nothing that one submission does reaches another, and nothing is done twice."""

from __future__ import annotations

import errno
import os
import re
import signal
import subprocess
import sys
import time
import tracemalloc
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from grading import mishaps
from grading.classes import make_folder, make_zip
from grading.reports import RIGHT, reported_line, sheet
from msgspec.structs import replace
from typer.testing import CliRunner

from gyrodata.cli import app
from gyrodata.diagnostics import SUBMITTED_FILE_CANNOT_BE_READ
from gyrodata.grading import (
    LIMIT,
    ClassGrades,
    GradingOptions,
    Journal,
    changes_in,
    class_summary,
    default_rubric,
    default_rubric_text,
    find_submissions,
    grade_class,
    read_rubric,
    write_feedback,
    write_results,
)
from gyrodata.grading import journal as journal_module
from gyrodata.workers import Failed, in_workers

ROOT = Path(__file__).parent.parent.parent
RUBRIC = default_rubric()


def a_log(seed: int) -> str:
    rows = sheet(np.random.default_rng(seed), "mixed")
    return rows.log("# station: 3", reported_line(*RIGHT.inertia(rows, "with_constant")))


def a_class(root: Path, *students: str) -> Path:
    return make_folder(root, {f"{student}/lab.csv": a_log(seed) for seed, student in enumerate(students)})


def table(found: ClassGrades) -> str:
    return found.table


@pytest.fixture
def honest(tmp_path: Path) -> Path:
    return a_class(tmp_path / "class", *(f"s{number}" for number in range(4)))


def run(root: Path, options: GradingOptions) -> ClassGrades:
    return grade_class(find_submissions(root), RUBRIC, options)


# --- workers ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("together", [1, 4])
def test_whatever_goes_wrong_is_one_row(tmp_path: Path, together: int) -> None:
    once = f"once {tmp_path / 'mark'}"
    tasks = ["fine 1", "hang", "exit", "kill", "memory", "deep", "raise x", once, "fine 2"]
    done = dict(in_workers(mishaps.work, tasks, workers=3, limit=1.5, at_once=together))
    assert sorted(done) == sorted(tasks)
    assert (done["fine 1"], done["fine 2"], done[once]) == ("fine 1 done", "fine 2 done", f"{once} done")
    reasons = {task: answer.why for task, answer in done.items() if isinstance(answer, Failed)}
    assert reasons.pop("deep").startswith("the tool broke on it (RecursionError")
    assert reasons == {
        "hang": "it took over 1.5 s",
        "exit": "its process ended (exit code 3)",
        "kill": "its process was killed (SIGKILL), perhaps for want of memory",
        "memory": "it needs more memory than 2 GB",
        "raise x": "the tool broke on it (KeyError: 'x')",
    }


@pytest.mark.parametrize("together", [1, 5])
def test_a_worker_that_is_killed_from_outside_takes_nothing_along(together: int) -> None:
    tasks = [f"sleep 0.0{number % 3}" for number in range(60)]
    tasks = [f"{task}{'0' * number}1" for number, task in enumerate(tasks)]
    done = []
    for number, (task, answer) in enumerate(in_workers(mishaps.work, tasks, workers=2, limit=20.0, at_once=together)):
        done.append(task)
        assert answer == f"{task} done"
        if number % 12 == 5:
            os.kill(next(iter(children())), signal.SIGKILL)  # one that works, or one that starts
    assert sorted(done) == sorted(tasks)


def test_what_lacks_memory_beside_others_is_done_alone() -> None:
    tasks = [f"crowd {number}" for number in range(3)]
    done = dict(in_workers(mishaps.work, tasks, workers=1, limit=20.0, at_once=3))
    assert done == {task: f"{task} done" for task in tasks}


def test_tasks_are_asked_for_shortly_before_they_are_given_out() -> None:
    asked: list[str] = []

    def tasks() -> Iterator[str]:
        for number in range(50):
            asked.append(f"fine {number}")
            yield asked[-1]

    done = 0
    for _, answer in in_workers(mishaps.work, tasks(), workers=2, limit=20.0):
        done += 1
        assert not isinstance(answer, Failed)
        assert len(asked) <= done + 4, "two at work, and two that wait"
    assert done == 50


def children() -> list[int]:
    """Processes that serve this one."""
    from multiprocessing import active_children

    return [child.pid for child in active_children() if child.pid is not None]


def test_leaving_early_leaves_nobody_behind() -> None:
    for _, answer in in_workers(mishaps.work, ["fine", "hang", "hang again"], workers=2, limit=60.0):
        assert answer == "fine done"
        break
    assert children() == []


def test_where_no_process_can_be_started_the_work_is_done_all_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    tasks = [f"fine {number}" for number in range(5)]
    # They die while they start, or there are none to be had.
    assert dict(in_workers(_OnlyHere(), tasks, workers=3, limit=5.0)) == {task: f"{task} done" for task in tasks}

    def none(*_: object) -> None:
        raise BlockingIOError(11, "Resource temporarily unavailable")

    monkeypatch.setattr("gyrodata.workers._Worker", none)
    done = dict(in_workers(mishaps.work, ["hang", *tasks], workers=3, limit=0.3))
    assert done.pop("hang") == Failed("it took over 0.3 s")
    assert done == {task: f"{task} done" for task in tasks}


def test_where_only_one_process_can_be_started_it_does_all_the_work(tmp_path: Path) -> None:
    tasks = [f"sleep 0.{number + 1:02}" for number in range(20)]
    done = dict(in_workers(_ForOne(tmp_path / "mark"), tasks, workers=3, limit=20.0))
    assert done == {task: f"{task} done" for task in tasks}


class _ForOne:
    """Work that one worker takes in, and no other."""

    def __init__(self, mark: Path) -> None:
        self.mark = mark

    def __reduce__(self) -> tuple[Callable[[Path], object], tuple[Path]]:
        return mishaps.first_alone, (self.mark,)

    def __call__(self, task: str) -> str:
        raise AssertionError(task)


class _OnlyHere:
    """Work that no worker can take in."""

    def __reduce__(self) -> tuple[Callable[[int], object], tuple[int]]:
        return signal.raise_signal, (signal.SIGTERM,)

    def __call__(self, task: str) -> str:
        return mishaps.work(task)


# --- a class ------------------------------------------------------------------------------------------------


def test_mishaps_are_rows_that_say_why_and_are_tried_again(tmp_path: Path) -> None:
    root = a_class(tmp_path / "class", "exit", "fine", "hang", "kill", "memory", "not", "raise")
    journal = Journal(tmp_path / "journal")
    found = run(root, GradingOptions(3, 5.0, journal, grader=mishaps.grade))
    assert [grade.status for grade in found.grades].count("graded") == 1
    for grade in found.grades:
        if grade.student != "fine":
            assert grade.points is None, "never a zero"
            assert all(mark.points is None for mark in grade.marks)
    reasons = {grade.student: grade.why for grade in found.grades}
    assert reasons["hang"] == "it took over 5 s; a person must look"
    assert (reasons["not"] or "").startswith("the tool broke on it (ValueError: Out of range float values")
    again = run(root, GradingOptions(2, LIMIT, journal))
    assert [grade.status for grade in again.grades] == ["graded"] * 7
    assert "fine" not in again.again
    assert again.again["hang"] == "lost last time: it took over 5 s"
    assert run(root, GradingOptions(2, LIMIT, journal, grader=mishaps.fail)).again == {}


@pytest.mark.parametrize("name", ["lab.csv", "report.txt"])
def test_what_a_disk_refuses_for_a_moment_is_read_by_the_next_run(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    log = a_log(1).replace("# reported_inertia: ", "# note: ")
    root = make_folder(tmp_path / "class", {"a/lab.csv": log, "a/report.txt": "I_zz = 4.43e-3 ± 0.05e-3 kg m^2"})
    whole = run(root, GradingOptions())
    assert whole.grades[0].status == "graded"
    opened, options = Path.open, GradingOptions(0, journal=Journal(tmp_path / "journal"))
    refused: list[Path] = []

    def refusing(path: Path, *given: Any, **named: Any) -> Any:
        if path.name == name and not refused:
            refused.append(path)
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        return opened(path, *given, **named)

    monkeypatch.setattr(Path, "open", refusing)
    found = run(root, options)
    assert refused
    assert found.lost, "so that nobody takes it for the last word"
    told = [one["message"] for one in found.grades[0].diagnostics if one["code"] == SUBMITTED_FILE_CANNOT_BE_READ]
    assert told == [f'"{name}" cannot be read: Input/output error']
    again = run(root, options)
    assert again.grades == whole.grades
    assert not again.lost
    assert run(root, options).again == {}


def test_a_report_that_is_too_large_is_told_and_is_no_accident(tmp_path: Path) -> None:
    report = "I_zz = 4.43e-3 ± 0.05e-3 kg m^2\n" + "x" * 1_000_000
    root = make_folder(tmp_path / "class", {"a/lab.csv": a_log(1), "a/report.txt": report})
    found = run(root, GradingOptions(0, journal=Journal(tmp_path / "journal")))
    assert [one["message"] for one in found.grades[0].diagnostics if one["severity"] == "error"] == [
        '"report.txt" cannot be read: it is larger than 1 MB'
    ]
    assert found.grades[0].status == "graded"
    assert not found.lost


def test_nothing_depends_on_workers_or_order(honest: Path, tmp_path: Path) -> None:
    submissions = find_submissions(honest)
    turned = replace(submissions, items=submissions.items[::-1])
    one = table(grade_class(submissions, RUBRIC, GradingOptions(1)))
    assert table(grade_class(turned, RUBRIC, GradingOptions(4))) == one
    journal = Journal(tmp_path / "journal")
    assert table(grade_class(turned, RUBRIC, GradingOptions(2, journal=journal))) == one
    assert table(grade_class(submissions, RUBRIC, GradingOptions(1, journal=journal, grader=mishaps.fail))) == one


@pytest.mark.parametrize("after", [1, 3])
def test_a_run_that_is_stopped_goes_on_where_it_was(after: int, honest: Path, tmp_path: Path) -> None:
    whole = table(run(honest, GradingOptions(2)))
    journal = Journal(tmp_path / "journal")

    def stop(done: int) -> None:
        if done == after:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(honest, GradingOptions(2, journal=journal, progress=stop))
    assert len(list(journal.read())) == after
    torn = journal.path.read_bytes()
    journal.path.write_bytes(torn[:-40])
    found = run(honest, GradingOptions(2, journal=journal))
    assert len(found.again) == 4 - after + 1
    assert table(found) == whole
    assert journal.path.read_bytes().count(b"\n") == len(list(journal.read())) == 4


def test_a_dry_run_writes_nothing(honest: Path, tmp_path: Path) -> None:
    journal = Journal(tmp_path / "grades" / "journal")
    found = run(honest, GradingOptions(2, journal=journal, keep=False))
    assert len(found.again) == 4
    assert list(tmp_path.iterdir()) == [honest]


def test_only_what_changed_is_graded_again_and_why_is_told(
    honest: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    options = GradingOptions(2, journal=Journal(tmp_path / "journal"))
    assert set(run(honest, options).again.values()) == {"new"}
    (honest / "s1" / "lab.csv").write_text(a_log(77))
    (honest / "s2").rename(honest / "t2")
    assert run(honest, options).again == {"s1": "the submission changed", "t2": "new"}
    text = default_rubric_text()
    other = read_rubric(text.replace('slip = "50 %"', 'slip = "25 %"').encode())
    assert set(grade_class(find_submissions(honest), other, options).again.values()) == {"the rubric changed"}
    stated = text.replace('[reference]\nfrom = "class"', '[reference.all]\ninertia="4.4e-3 kg m^2"\nu="1 %"')
    run(honest, options)
    found = grade_class(find_submissions(honest), read_rubric(stated.encode()), options)
    assert set(found.again.values()) == {"the reference changed"}
    run(honest, options)
    monkeypatch.setattr(journal_module, "__version__", "99.0")
    reasons = run(honest, options).again.values()
    assert {re.sub(r"from \S+", "from …", why) for why in reasons} == {"gyrodata changed from … to 99.0"}


def test_figures_are_drawn_once_and_again_where_they_are_gone(tmp_path: Path) -> None:
    root = a_class(tmp_path / "class", "a")
    options = GradingOptions(1, journal=Journal(tmp_path / "journal"), figures=tmp_path / "figures")
    run(root, replace(options, figures=None))
    found = run(root, options)
    assert found.again == {"a": "its figures are missing"}
    drawn = sorted((tmp_path / "figures" / "a").iterdir())
    assert [path.stem for path in drawn] == sorted(found.figures["a"])
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in drawn)
    assert run(root, replace(options, grader=mishaps.fail)).again == {}
    drawn[0].unlink()
    (why,) = run(root, replace(options, grader=mishaps.fail)).again.values()
    assert why == "its figures are missing"


def test_a_kill_loses_nothing(honest: Path, tmp_path: Path) -> None:
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    command = ["grade", str(honest), "--workers", "2", "-o"]
    CliRunner().invoke(app, [*command, str(whole)], catch_exceptions=False)
    first = subprocess.Popen(
        [sys.executable, "-m", "gyrodata", *command, killed],
        env={**os.environ, "PYTHONPATH": str(ROOT)}, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    journal = killed / "journal.ndjson"
    while first.poll() is None and not (journal.exists() and journal.read_bytes().count(b"\n") >= 2):
        time.sleep(0.005)
    first.kill()
    first.wait()
    kept = journal.read_bytes().count(b"\n")
    second = CliRunner().invoke(app, [*command, str(killed)], catch_exceptions=False)
    assert f"kept {kept} as graded before" in second.stderr
    names = sorted(path.relative_to(whole) for path in whole.rglob("*") if path.is_file())
    assert Path("grades.csv") in names
    for name in names:
        assert (killed / name).read_bytes() == (whole / name).read_bytes(), name


def test_a_journal_of_a_run_that_was_killed_before_it_put_it_in_order(honest: Path, tmp_path: Path) -> None:
    options = GradingOptions(journal=Journal(tmp_path / "journal.ndjson"))
    run(honest, options)
    journal = tmp_path / "journal.ndjson"
    whole = journal.read_bytes()
    journal.write_bytes(b"".join(reversed(whole.splitlines(keepends=True))))
    assert run(honest, options).again == {}
    assert journal.read_bytes() == whole


# --- memory ---------------------------------------------------------------------------------------------------

LEAST, MORE = 10, 50
"""Students of two classes."""

MOST = 20_000
"""What one student more may take at the peak [byte]."""


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
    options = GradingOptions(2, journal=Journal(folder / "journal.ndjson"), grader=mishaps.quick)
    found = grade_class(find_submissions(root), default_rubric(), options)
    changes_in(folder, found)
    write_results(found, folder, {})
    assert write_feedback(found, folder, options) == ([], [])
    assert sum(1 for _ in class_summary(found)) > len(found.grades)


def test_what_a_student_takes_in_memory(tmp_path: Path) -> None:
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
