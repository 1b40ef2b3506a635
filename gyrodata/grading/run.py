"""A class, from submissions to grades: each in a process of its own time, kept as soon as it is done.

The story: what the journal knows and what has not changed is taken from there → the rest goes to the workers, and
each grade into the journal as it comes → when all are there, the class is its own reference, and its logs are
compared. Nothing depends on the order, on the number of workers, or on how often the run was stopped. All grades of a
class are held in memory: 16 kB a student.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from gyrodata.errors import GyroError
from gyrodata.grading.classroom import ClassGrades
from gyrodata.grading.forensics import Exemptions, flag_class
from gyrodata.grading.grade import Grade, grade_submission, not_graded, one_copy, references_of, settle_one
from gyrodata.grading.journal import Basis, Entry, Journal, bases_of, why_again, write_whole
from gyrodata.grading.rubric import Rubric
from gyrodata.grading.submissions import Submission, Submissions
from gyrodata.workers import Failed, in_workers

LIMIT = 30.0
"""Time for one submission [s] unless another is given; an ordinary one takes a hundredth."""

Grader = Callable[[Submission, Rubric], Grade]


@dataclass(frozen=True)
class GradingOptions:
    """How a class is graded: processes, time, files; none of it changes a grade."""

    workers: int = 1
    """Processes."""
    limit: float = LIMIT
    """Time for one submission [s]."""
    journal: Journal | None = None
    """Where grades are kept, and known ones found; None: nowhere."""
    keep: bool = True
    """False where nothing is written, the journal neither."""
    figures: Path | None = None
    """Folder for each student's figures; None: none are drawn."""
    progress: Callable[[int], None] | None = None
    """Told how many are done."""
    grader: Grader = grade_submission
    """What makes a grade."""


@dataclass(frozen=True)
class _Work:
    """What is done with one submission, in a worker."""

    rubric: Rubric
    grader: Grader
    figures: bool

    def __call__(self, submission: Submission) -> tuple[str, dict[str, tuple[bytes, str]]]:
        """Grade it; give the grade as JSON, and each figure's file and words by its name."""
        grade = self.grader(submission, self.rubric)
        # Taken through JSON at once, so that a grade from the journal is the same to the last digit.
        content = json.dumps(grade.to_dict(), allow_nan=False)
        return content, _draw(submission) if self.figures and grade.own else {}


def grade_class(
    submissions: Submissions, rubric: Rubric, options: GradingOptions | None = None, exempt: Exemptions | None = None
) -> ClassGrades:
    """Grade a class.

    Gives: A submission that hangs, dies or breaks the tool is "not graded", with the reason, and is tried again in the
    next run.
    """
    options = options or GradingOptions()
    items = tuple(sorted(submissions.items, key=lambda item: item.student))
    entries, again = _entries(items, rubric, options)
    references = references_of((entry.grade for entry in entries.values()), rubric)
    made = {item.student: entries[item.student] for item in items}
    prints = {student: one.grade.fingerprint for student, one in made.items() if one.grade.fingerprint is not None}
    if options.journal is not None and options.keep and (again or options.journal.damaged):
        options.journal.replace(made.values())
    return ClassGrades(
        source=items[0].source.resolve().name,
        submissions=replace(submissions, items=items),
        rubric=rubric,
        grades=tuple(settle_one(replace(one.grade, fingerprint=None), rubric, references) for one in made.values()),
        references=references,
        flags=flag_class(prints, exempt),
        again=again,
        figures={student: one.figures for student, one in made.items() if one.figures},
    )


def _entries(
    items: Sequence[Submission], rubric: Rubric, options: GradingOptions
) -> tuple[dict[str, Entry], dict[str, str]]:
    """Take each student's entry from the journal or make it; and say of those that are made why."""
    entries: dict[str, Entry] = {}
    bases = bases_of(items, rubric)
    handed_in = {item.student: item for item in items}
    reasons = {student: why_again(None, basis) for student, basis in bases.items()}
    for entry in options.journal.read() if options.journal is not None else ():
        student = entry.grade.student
        if student in bases:
            reasons[student] = why_again(entry, bases[student]) or _why_figures(entry, handed_in[student], options)
            if not reasons[student]:
                entries[student] = entry
    again = {student: why for student, why in reasons.items() if why}
    done = len(items) - len(again)
    work = _Work(rubric, options.grader, options.figures is not None)
    waiting = (handed_in[student] for student in again)
    for item, answer in in_workers(work, waiting, options.workers, options.limit, ["gyrodata.grading.grade"]):
        entry = _entry(item, bases[item.student], answer, rubric, options)
        entries[item.student] = entry
        if options.journal is not None and options.keep:
            options.journal.add(entry)
        done += 1
        if options.progress is not None:
            options.progress(done)
    return entries, again


def _entry(
    item: Submission,
    basis: Basis,
    answer: tuple[str, Mapping[str, tuple[bytes, str]]] | Failed,
    rubric: Rubric,
    options: GradingOptions,
) -> Entry:
    """Make the line of the journal, the figures written before it, so that whatever it tells of is there."""
    if isinstance(answer, Failed):
        return Entry(basis, not_graded(item, rubric, f"{answer.why}; a person must look"), answer.why, {})
    content, figures = answer
    if options.figures is not None:
        for name, (data, _) in figures.items():
            write_whole(figure_path(options.figures, item, name), [data])
    return Entry(
        basis,
        Grade.from_dict(json.loads(content, object_hook=one_copy)),
        "",
        {name: words for name, (_, words) in figures.items()},
    )


# --- figures ------------------------------------------------------------------------------------------------


def figure_path(folder: Path, item: Submission, name: str) -> Path:
    """Say where a student's figure is."""
    return folder / item.feedback_stem.replace("/", "_") / f"{name}.png"


def _why_figures(entry: Entry, item: Submission, options: GradingOptions) -> str:
    """Say that a known grade lacks its figures; "" where it has them or none are asked for."""
    if options.figures is None or not entry.grade.own:
        return ""
    there = entry.figures and all(figure_path(options.figures, item, name).is_file() for name in entry.figures)
    return "" if there else "its figures are missing"


def _draw(submission: Submission) -> dict[str, tuple[bytes, str]]:
    """Draw the figures of a log that was analysed: file and words by name."""
    from gyrodata import plotting
    from gyrodata.analysis import analyze_readings
    from gyrodata.readings import read_log

    try:
        analysis = analyze_readings(read_log(submission.log(), name=submission.log_file))
    except GyroError:
        return {}  # it has changed since it was graded; the next run sees that
    figures = plotting.render(analysis, "png")
    return {name: (data, plotting.alt_text(analysis, name)) for name, data in figures.items()}
