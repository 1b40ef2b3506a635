"""What every student gets back: feedback files named so that the platform takes them, and a zip of all."""

from __future__ import annotations

import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from gyrodata.grading.classroom import ClassGrades
from gyrodata.grading.feedback import feedback_html, feedback_markdown
from gyrodata.grading.grade import Grade
from gyrodata.grading.journal import cannot_write, write_changed
from gyrodata.grading.run import Way, figure_path
from gyrodata.grading.submissions import Submission
from gyrodata.grading.workers import Lost, in_workers

FOLDER = "feedback"
ARCHIVE = "feedback.zip"
ENDINGS = (".html", ".md")


@dataclass(frozen=True, slots=True)
class _Task:
    """One student's feedback to be written."""

    grade: Grade
    submission: Submission
    figures: Mapping[str, str]
    """What each figure shows, by name; empty where the feedback has none."""


@dataclass(frozen=True)
class _Work:
    """How it is written, in a worker."""

    figures: Path | None

    def __call__(self, task: _Task) -> tuple[str, str]:
        """Give the page and the Markdown."""
        drawn = {}
        if self.figures is not None:
            drawn = {name: figure_path(self.figures, task.submission, name).read_bytes() for name in task.figures}
        return feedback_html(task.grade, drawn, task.figures), feedback_markdown(task.grade)


def feedback_names(found: ClassGrades) -> dict[str, str]:
    """Name each student's feedback below `FOLDER`, without its ending, as the platform names it.

    Gives: By student. Two that would be called the same, which only a pattern of one's own can bring about, get
    numbers.
    """
    names: dict[str, str] = {}
    taken: set[str] = set()
    for item in found.submissions.items:
        plain = item.feedback_name("")
        name, number = plain, 1
        while name.casefold() in taken:
            number += 1
            name = f"{plain}-{number}"
        taken.add(name.casefold())
        names[item.student] = name
    return names


def write_feedback(
    found: ClassGrades, folder: Path, way: Way, progress: Callable[[int], None] | None = None
) -> tuple[str, ...]:
    """Write the feedback of a class into a folder and a zip.

    `folder`: Of the grades; the files go below ``feedback/`` in it. Gives: Why the feedback of some could not be
    written.
    """
    names = feedback_names(found)
    figures = found.figures if way.figures is not None else {}
    tasks = (
        _Task(grade, item, figures.get(grade.student, {}))
        for grade, item in zip(found.grades, found.submissions.items, strict=True)
    )
    lost: list[str] = []
    written: list[str] = []
    for task, answer in in_workers(_Work(way.figures), tasks, way.workers, way.limit):
        if isinstance(answer, Lost):
            lost.append(f"no feedback for {task.grade.name}: {answer.why}")
        else:
            name = names[task.grade.student]
            for ending, text in zip(ENDINGS, answer, strict=True):
                write_changed(folder / FOLDER / f"{name}{ending}", text.encode("utf-8", "replace"))
            written.append(name)
        if progress is not None:
            progress(len(written) + len(lost))
    _write_archive(folder, sorted(written))
    return tuple(sorted(lost))


def _write_archive(folder: Path, names: list[str]) -> None:
    """Zip the feedback of this class, and of nobody else; the same files give the same bytes."""
    target = folder / ARCHIVE
    unfinished = target.with_name(f".{ARCHIVE}.part")
    try:
        with zipfile.ZipFile(unfinished, "w", zipfile.ZIP_DEFLATED, compresslevel=6) as archive:
            for name in (f"{name}{ending}" for name in names for ending in ENDINGS):
                entry = zipfile.ZipInfo(name)  # of 1980: a zip's bytes should not tell the time
                entry.compress_type = zipfile.ZIP_DEFLATED
                entry.external_attr = 0o644 << 16
                archive.writestr(entry, (folder / FOLDER / name).read_bytes())
        unfinished.replace(target)
    except OSError as error:
        raise cannot_write(folder, error) from None
