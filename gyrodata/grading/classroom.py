"""A class, from submissions to grades: each in a process of its own time, kept as soon as it is done.

The story: what the journal contains and has not changed is taken from there → the rest goes to the workers, and
each grade into the journal as it comes → when all are there, the class is its own reference, and its logs are
compared. Nothing depends on the order, on the number of workers, or on how often the run was stopped. All grades of a
class are in memory: less than 20 kB a student.
"""

from __future__ import annotations

import os
import statistics
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from functools import cached_property, partial
from importlib import import_module
from pathlib import Path

from msgspec import Struct
from msgspec.structs import asdict, replace

from gyrodata.diagnostics import GRADES_FOLDER_CANNOT_BE_WRITTEN
from gyrodata.disk import file_name, telling, write_whole
from gyrodata.errors import GyroError, insist_on_type
from gyrodata.grading.exports import class_summary, grades_csv
from gyrodata.grading.forensics import Fingerprint, Flag, flag_class
from gyrodata.grading.grade import Grade, from_json, grade_submission, not_graded, reconsider, settle, to_json
from gyrodata.grading.journal import Basis, Entry, Journal, basis_of
from gyrodata.grading.ledger import NO_DESK, Desk
from gyrodata.grading.roster import Roster
from gyrodata.grading.rubric import Rubric, default_rubric, read_rubric
from gyrodata.grading.submissions import Submission, Submissions, find_submissions
from gyrodata.grading.yardsticks import BenchScatter, Reference, at_bench, scatter_words
from gyrodata.workers import Failed, in_workers

LIMIT = 30.0  # time for one submission [s] unless another is given; an ordinary one takes a hundredth

FEW = 8  # fewer submissions than this are graded by one process: to start another costs more

NOBODY = Roster()


class GradingOptions(Struct, frozen=True):
    """How a class is graded: processes, time, files; none of it changes a grade."""

    workers: int = 1  # processes
    limit: float = LIMIT  # time for one submission [s]
    cluster: Executor | None = None  # grades instead, on other machines
    journal: Journal | None = None  # where grades are kept, and known ones found; None: nowhere
    keep: bool = True  # False where nothing is written, the journal neither
    figures: Path | None = None  # folder for each student's figures; None: none are drawn
    progress: Callable[[int], None] | None = None  # receives the number that are done


def grade(
    source: str | os.PathLike[str], rubric: str | os.PathLike[str] | None = None, *, workers: int = 0
) -> ClassGrades:
    """Grade a class as ``gyro grade`` does, and write nothing.

    Parameters
    ----------
    source : path
        A folder with a folder or file for each student, what a platform hands out, or its zip.
    rubric : path, optional
        The rubric, TOML; the built-in one if none is given.
    workers : int
        Processes; with 0 all is done in this one, where nothing stops a submission that hangs.

    Returns
    -------
    ClassGrades
        ``grades`` has each student's marks with their reasons, ``flags`` the logs that look copied.

    Raises
    ------
    InputError
        If there is no submission, or if the rubric is invalid.
    OSError
        If the rubric cannot be read.
    TypeError
        If an argument is nothing that it can be.
    """
    insist_on_type("source", source, str | os.PathLike, "the path of a folder or a zip")
    insist_on_type("rubric", rubric, str | os.PathLike | None, "the path of a rubric")
    insist_on_type("workers", workers, int, "a number of processes")
    judged = default_rubric() if rubric is None else read_rubric(Path(rubric).read_bytes(), Path(rubric).name)
    return grade_class(find_submissions(Path(source)), judged, GradingOptions(workers=workers))


def grade_class(
    submissions: Submissions,
    rubric: Rubric,
    options: GradingOptions | None = None,
    previous: Mapping[str, Fingerprint] = {},
    desk: Desk = NO_DESK,
    roster: Roster = NOBODY,
) -> ClassGrades:
    """Grade a class.

    `previous`: Logs of earlier years, by what they are called, with which those of the class are compared. `desk`: What
    a person decided; it goes before what is found here. `roster`: Who is in it.

    Gives: A submission that hangs, dies or breaks the tool is "not graded", with the reason, and is tried again in the
    next run.
    """
    options = options or GradingOptions()
    items = tuple(sorted(submissions.items, key=lambda item: item.student))
    made, again = _entries(items, rubric, options, desk)
    placed = [desk.with_station(roster.named(replace(one.grade, fingerprint=None))) for one in made.values()]
    settled, references, scatters = settle(placed, rubric)
    settled = tuple(
        reconsider(one, replace(item), rubric, references, scatters, desk.value(item.student, "reported"))
        for one, item in zip(settled, items, strict=True)
    )
    prints = {student: one.grade.fingerprint for student, one in made.items() if one.grade.fingerprint is not None}
    flags = flag_class(prints, [*roster.partners, *desk.partners], previous)
    compared = {key for flag in flags for pair in flag.pairs for key in pair}
    return ClassGrades(
        source=items[0].source.resolve().name,
        submissions=replace(submissions, items=items),
        rubric=rubric,
        grades=tuple(desk.applied(grade, made[grade.student].seen) for grade in settled),
        references=references,
        scatters=scatters,
        flags=flags,
        again=again,
        desk=desk,
        roster=roster,
        figures={student: one.figures for student, one in made.items() if one.figures},
        compared={key: one for key, one in {**previous, **prints}.items() if key in compared},
    )


def _entries(
    items: Sequence[Submission], rubric: Rubric, options: GradingOptions, desk: Desk
) -> tuple[dict[str, Entry], dict[str, str]]:
    """Take each student's entry from the journal or make it, and say why it is made."""
    journal, keep = options.journal, options.keep
    known = journal.read() if journal is not None else {}
    entries: dict[str, Entry] = {}
    again: dict[str, str] = {}
    waiting: list[tuple[Submission, str]] = []
    for item in items:
        reported, before = desk.value(item.student, "reported") or "", known.get(item.student)
        if before is None:
            why = "new"
        else:
            # The texts of a submission are kept with it: those of a copy are gone with the copy.
            why = before.why_again(basis_of(replace(item), rubric, reported)) or _why_figures(before, item, options)
        if why:
            again[item.student] = why
            waiting.append((item, reported))
        elif before is not None:
            entries[item.student] = replace(before, seen=desk.first_seen(before.grade, before.seen))
    if waiting:
        # Loaded here, it need not be loaded by each process that is forked from this one.
        import_module("gyrodata.analysis")
    work = partial(_grade_one, rubric, options.figures is not None)
    workers = options.workers if len(waiting) >= FEW else min(1, options.workers)
    drawn: dict[str, tuple[bytes, str]]
    for (item, reported), answer in in_workers(work, waiting, workers, options.limit, options.cluster):
        if isinstance(answer, Failed):
            lost, basis, drawn = answer.why, basis_of(replace(item), rubric, reported), {}
            grade = not_graded(item, rubric, f"{lost}; a person must look")
        else:
            lost, (basis, grade, drawn) = "", answer
        # They are written first, so that everything in the journal exists.
        for name, (data, _) in drawn.items():
            folder = options.figures or Path()
            with telling(folder, GRADES_FOLDER_CANNOT_BE_WRITTEN):
                write_whole(figure_path(folder, item, name), [data], private=True)
        figures = {name: words for name, (_, words) in drawn.items()}
        seen = desk.first_seen(grade, known[item.student].seen if item.student in known else {})
        entries[item.student] = Entry(**asdict(basis), grade=grade, lost=lost, figures=figures, seen=seen)
        if journal is not None and keep:
            journal.add(entries[item.student])
        if options.progress is not None:
            options.progress(len(entries))
    entries = {item.student: entries[item.student] for item in items}
    if journal is not None and keep and (journal.lines != len(items) or list(known.items()) != list(entries.items())):
        journal.replace(entries.values())
    return entries, again


def _grade_one(
    rubric: Rubric, draws: bool, task: tuple[Submission, str]
) -> tuple[Basis, Grade, dict[str, tuple[bytes, str]]]:
    """Grade one submission, in a worker; give what it rests on, the grade, and each figure's file and words."""
    submission, reported = replace(task[0]), task[1]
    basis = basis_of(submission, rubric, reported)
    grade = grade_submission(submission, rubric, reported or None)
    # Taken through JSON at once, so that a grade from the journal is the same to the last digit.
    return basis, from_json(to_json(grade), Grade), _draw(submission, rubric) if draws and grade.own else {}


# --- figures ------------------------------------------------------------------------------------------------


def figure_path(folder: Path, item: Submission, name: str) -> Path:
    """Say where a student's figure is."""
    return folder / file_name(item.feedback_stem) / f"{name}.png"


def _why_figures(entry: Entry, item: Submission, options: GradingOptions) -> str:
    """Say that a known grade lacks its figures; "" where it has them or none are asked for."""
    if options.figures is None or not entry.grade.own:
        return ""
    there = entry.figures and all(figure_path(options.figures, item, name).is_file() for name in entry.figures)
    return "" if there else "its figures are missing"


def _draw(submission: Submission, rubric: Rubric) -> dict[str, tuple[bytes, str]]:
    """Draw the figures of a log that was analysed: file and words by name."""
    from gyrodata import plotting
    from gyrodata.analysis import analyze_readings

    try:
        analysis = analyze_readings(at_bench(submission, rubric.bench)[0])
    except GyroError:
        return {}  # it has changed since it was graded; the next run sees that
    figures = plotting.render(analysis, "png")
    return {name: (data, plotting.alt_text(analysis, name)) for name, data in figures.items()}


# --- a class that has been graded --------------------------------------------------------------------------


class CriterionFigures(Struct, frozen=True):
    """How a class did in one criterion."""

    id: str
    title: str
    out_of: float
    judged: int  # students for whom it could be judged
    full: int  # students with all of its points
    none: int  # students with none
    mean: float | None  # mean points of those judged; None for nobody


class ClassGrades(Struct, frozen=True, dict=True):
    """All that a run found out."""

    source: str  # name of the folder or zip, without where it is
    submissions: Submissions
    rubric: Rubric
    grades: Sequence[Grade]  # in the order of `submissions`, settled
    references: Mapping[str, Reference]  # the reference of I_zz, by station; "all" for every other
    flags: tuple[Flag, ...]
    again: Mapping[str, str]  # why each student was graded in this run, by key; the others' grades were known
    figures: Mapping[str, Mapping[str, str]]
    """What each drawn figure shows, in words, by student and name of the figure."""
    desk: Desk = NO_DESK  # what a person decided
    roster: Roster = NOBODY
    scatters: Mapping[str, BenchScatter] = {}  # how far the readings scatter, by station; none where that is not asked
    compared: Mapping[str, Fingerprint] = {}  # the logs of the pairs that are flagged, by key

    def __repr__(self) -> str:
        return f"<ClassGrades of {self.source[:200]}: {self.tally}>"

    @cached_property
    def totals(self) -> list[float]:
        """Points of those who are graded, in the order of the grades."""
        return [grade.points for grade in self.grades if grade.status == "graded" and grade.points is not None]

    def count(self, status: str) -> int:
        """Count the grades of one status."""
        return sum(grade.status == status for grade in self.grades)

    @cached_property
    def tally(self) -> str:
        """How many are graded, and how many not, in words."""
        told = [f"{self.count(one)} {one}" for one in ("so far", "on hold", "excused") if self.count(one)]
        absent = [f"{len(self.roster.absent)} handed in nothing"] if self.roster.absent else []
        return ", ".join([f"{len(self.totals)} graded", *told, f"{self.count('not graded')} not", *absent])

    @cached_property
    def slips(self) -> Mapping[str, list[str]]:
        """Return the students with each common mistake, the most common first."""
        found: dict[str, list[str]] = {}
        for grade in self.grades:
            for slip in grade.slips:
                found.setdefault(slip.kind, []).append(grade.student)
        return dict(sorted(found.items(), key=lambda item: (-len(item[1]), item[0])))

    @cached_property
    def table(self) -> str:
        """``grades.csv``."""
        return grades_csv(self.grades, self.flags, self.roster.absent)

    @cached_property
    def summary(self) -> str:
        """Return the text for a terminal."""
        return "".join(class_summary(self))

    @cached_property
    def bench(self) -> str:
        """Return the scatter that constancy is compared with, in words; "" for the usual one."""
        return scatter_words(self.scatters)

    @property
    def mean(self) -> float | None:
        """Mean of the points; None where nobody is graded."""
        return round(statistics.fmean(self.totals), 4) if self.totals else None

    @property
    def median(self) -> float | None:
        """Median of the points; None where nobody is graded."""
        return statistics.median(self.totals) if self.totals else None

    @cached_property
    def ids(self) -> Mapping[str, Mapping[str, str]]:
        """Return the platform's identifiers of each student."""
        return {item.student: item.ids for item in self.submissions.items}

    @cached_property
    def names(self) -> Mapping[str, str]:
        """How each student is shown."""
        return {grade.student: grade.name for grade in self.grades}

    def label(self, student: str) -> str:
        """Call a student by name, with the key where that is another."""
        name = self.names.get(student, student)
        return name if name == student or student in name else f"{name} ({student})"

    @cached_property
    def flags_of(self) -> Mapping[str, tuple[Flag, ...]]:
        """The flags that each flagged student is in."""
        found: dict[str, list[Flag]] = {}
        for flag in self.flags:
            for student in flag.students:
                found.setdefault(student, []).append(flag)
        return {student: tuple(flags) for student, flags in found.items()}

    def criteria(self) -> Iterator[CriterionFigures]:
        """Tell how the class did in each criterion, in the rubric's order."""
        for at, criterion in enumerate(self.rubric.criteria):
            marks = (grade.marks[at].points for grade in self.grades)
            judged = [points for points in marks if points is not None]
            yield CriterionFigures(
                criterion.id,
                criterion.title,
                criterion.points,
                len(judged),
                sum(one >= criterion.points for one in judged),
                sum(one <= 0 for one in judged),
                round(statistics.fmean(judged), 4) if judged else None,
            )
