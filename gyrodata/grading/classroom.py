"""A class, from submissions to grades: each in a process of its own time, kept as soon as it is done.

The story: what the journal knows and what has not changed is taken from there → the rest goes to the workers, and
each grade into the journal as it comes → when all are there, the class is its own reference, and its logs are
compared. Nothing depends on the order, on the number of workers, or on how often the run was stopped. All grades of a
class are held in memory: less than 20 kB a student.
"""

from __future__ import annotations

import os
import statistics
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property, partial
from pathlib import Path

from msgspec import Struct
from msgspec.structs import asdict, replace

from gyrodata.diagnostics import GRADES_FOLDER_CANNOT_BE_WRITTEN, SUBMITTED_FILE_CANNOT_BE_READ
from gyrodata.disk import file_name, telling, write_whole
from gyrodata.errors import GyroError, insist_on_type
from gyrodata.grading.exports import class_summary, grades_csv
from gyrodata.grading.forensics import Fingerprint, Flag, flag_class
from gyrodata.grading.grade import Grade, from_json, grade_submission, not_graded, reconsider, settle
from gyrodata.grading.journal import Basis, Entry, Journal, basis_of, why_again
from gyrodata.grading.ledger import NO_DESK, Desk
from gyrodata.grading.roster import Roster
from gyrodata.grading.rubric import Rubric, default_rubric, read_rubric
from gyrodata.grading.submissions import Submission, Submissions, find_submissions
from gyrodata.grading.yardsticks import BenchScatter, Reference, at_bench, scatter_words
from gyrodata.workers import Failed, in_workers

LIMIT = 30.0  # time for one submission [s] unless another is given; an ordinary one takes a hundredth

PRELOAD = ("gyrodata.grading.grade", "gyrodata.grading.feedback", "gyrodata.analysis", "gyrodata.procedure")
"""What is loaded once for all processes."""

NOBODY = Roster()

Grader = Callable[[Submission, Rubric, str | None], Grade]


class GradingOptions(Struct, frozen=True):
    """How a class is graded: processes, time, files; none of it changes a grade."""

    workers: int = 1  # processes
    limit: float = LIMIT  # time for one submission [s]
    journal: Journal | None = None  # where grades are kept, and known ones found; None: nowhere
    keep: bool = True  # False where nothing is written, the journal neither
    figures: Path | None = None  # folder for each student's figures; None: none are drawn
    progress: Callable[[int], None] | None = None  # told how many are done
    grader: Grader = grade_submission  # what makes a grade


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
        If there is no submission, or the rubric is none.
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
    entries, again, unseen = _entries(items, rubric, options, desk)
    made = {item.student: entries[item.student] for item in items}
    placed = [desk.with_station(roster.named(replace(one.grade, fingerprint=None))) for one in made.values()]
    settled, references, scatters = settle(placed, rubric)
    settled = tuple(
        reconsider(one, replace(item), rubric, references, scatters, desk.value(item.student, "reported"))
        for one, item in zip(settled, items, strict=True)
    )
    prints = {student: one.grade.fingerprint for student, one in made.items() if one.grade.fingerprint is not None}
    flags = flag_class(prints, [*roster.partners, *desk.partners], previous)
    compared = {key for flag in flags for pair in flag.pairs for key in pair}
    journal = options.journal
    if journal is not None and options.keep and (again or unseen or journal.damaged or journal.outdated):
        journal.replace(made.values(), unseen)
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
        lost=any(one.lost for one in made.values()),
        compared={key: one for key, one in {**previous, **prints}.items() if key in compared},
    )


def _entries(
    items: Sequence[Submission], rubric: Rubric, options: GradingOptions, desk: Desk
) -> tuple[dict[str, Entry], dict[str, str], set[str]]:
    """Take each student's entry from the journal or make it; say why, and for whom the desk has grown."""
    entries: dict[str, Entry] = {}
    seen: dict[str, Mapping[str, str]] = {}
    reported = {item.student: desk.value(item.student, "reported") or "" for item in items}
    handed_in = {item.student: item for item in items}
    reasons = dict.fromkeys(handed_in, "new")
    for entry in options.journal.read() if options.journal is not None else ():
        student = entry.grade.student
        if item := handed_in.get(student):
            seen[student] = entry.seen
            basis = basis_of(replace(item), rubric, reported[student])  # without its texts, which are held with it
            reasons[student] = why_again(entry, basis) or _why_figures(entry, item, options)
            if not reasons[student]:
                entries[student] = replace(entry, seen=desk.first_seen(entry.grade, entry.seen))
    again = {student: why for student, why in reasons.items() if why}
    done = len(items) - len(again)
    unseen = {student for student, entry in entries.items() if entry.seen != seen[student]}
    # What tells the progress stays here.
    work = partial(_grade_one, rubric, replace(options, journal=None, progress=None), reported)
    waiting = [handed_in[student] for student in again]
    for item, answer in in_workers(
        work, waiting, options.workers, options.limit, PRELOAD, share_of(len(again), options.workers)
    ):
        if isinstance(answer, Failed):
            lost, answer = answer.why, (basis_of(replace(item), rubric, reported[item.student]), "", {})
            grade = not_graded(item, rubric, f"{lost}; a person must look")
        else:
            lost, grade = "", from_json(answer[1], Grade)
            unread = {one["message"] for one in grade.diagnostics if one["code"] == SUBMITTED_FILE_CANNOT_BE_READ}
            # What a disk refuses for a moment must not stand in the journal for ever.
            if unread and unread - {one.message for one in replace(item).unread}:
                lost = "it could not be read for a moment"
        basis, content, figures = answer
        # They are written first, so that whatever the journal tells of is there.
        for name, (data, _) in figures.items():
            folder = options.figures or Path()
            with telling(folder, GRADES_FOLDER_CANNOT_BE_WRITTEN):
                # That a figure is there is all that the next run looks for.
                write_whole(figure_path(folder, item, name), [data], private=True, sync=True)
        told = {name: words for name, (_, words) in figures.items()}
        first = desk.first_seen(grade, seen.get(item.student, {}))
        entries[item.student] = Entry(**asdict(basis), grade=grade, lost=lost, figures=told, seen=first)
        if options.journal is not None and options.keep:
            options.journal.add(entries[item.student], content)
        done += 1
        if options.progress is not None:
            options.progress(done)
    return entries, again, unseen


MOST_AT_ONCE = 32  # students that a worker is given together


def share_of(count: int, workers: int) -> int:
    """Say how many students a worker is given together, so that each comes round several times."""
    return max(1, min(MOST_AT_ONCE, count // (4 * max(1, workers))))


def _grade_one(
    rubric: Rubric, options: GradingOptions, reported: Mapping[str, str], submission: Submission
) -> tuple[Basis, str, dict[str, tuple[bytes, str]]]:
    """Grade one submission, in a worker; give what it rests on, the grade as JSON, and each figure's file and words."""
    submission = replace(submission)  # its texts go when it is done
    basis = basis_of(submission, rubric, reported[submission.student])
    grade = options.grader(submission, rubric, basis.desk or None)
    # Taken through JSON at once, so that a grade from the journal is the same to the last digit.
    return basis, grade.to_json(), _draw(submission, rubric) if options.figures is not None and grade.own else {}


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
    references: Mapping[str, Reference]  # what I_zz was held against, by station; "all" for every other
    flags: tuple[Flag, ...]
    again: Mapping[str, str]  # why each student was graded in this run, by key; the others' grades were known
    figures: Mapping[str, Mapping[str, str]]
    """What each drawn figure shows, in words, by student and name of the figure."""
    lost: bool = False  # True: the run itself lost some (a time limit, a process that died), who are tried again
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
        """Who made which known slip, by its kind; the commonest first."""
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
        """What a terminal shows."""
        return "".join(class_summary(self))

    @cached_property
    def bench(self) -> str:
        """What constancy is judged by, in words; "" where that is as usual."""
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
        """What platforms know each student by."""
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
