"""A class, from submissions to grades; the journal keeps each grade at once.

The story: grades whose inputs have not changed are taken from the journal. Workers make
the others, and each is written into the journal as it comes. When all are there, the
class is its own reference, and its logs are compared. Nothing depends on the order, on
the number of workers, or on how often the run was stopped.
"""

from __future__ import annotations

import hashlib
import os
import statistics
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import closing
from functools import cached_property, partial
from html import escape
from pathlib import Path
from typing import Literal, TypeVar

from msgspec import Struct, ValidationError, field
from msgspec.structs import replace

from gyrodata.base import disk
from gyrodata.base.errors import Diagnostic, count_text, insist_on_type
from gyrodata.base.version import __version__
from gyrodata.base.workers import Failed, in_workers
from gyrodata.grading import exports, yardsticks
from gyrodata.grading.examples import examples_for, flag_simulated
from gyrodata.grading.exports.pages import environment
from gyrodata.grading.forensics import Fingerprint, Flag, flag_class, in_order
from gyrodata.grading.grade import (
    Grade,
    Standard,
    find_disagreement,
    grade_submission,
    not_graded,
    reconsider,
    standard_of,
)
from gyrodata.grading.ledger import (
    BETWEEN,
    DESK,
    NO_DESK,
    Desk,
    Offer,
    find_offers,
)
from gyrodata.grading.roster import (
    EVERYBODY,
    Partners,
    Roster,
    find_partners,
    partners_by_log,
)
from gyrodata.grading.rubric import BUILT_IN, Rubric, default_rubric_text, read_rubric
from gyrodata.grading.sections import SectionFigures, section_figures
from gyrodata.grading.stations import StationFigures, each_log_once, station_figures
from gyrodata.grading.submissions import (
    Submission,
    Submissions,
    choose,
    list_submissions,
    unread,
)
from gyrodata.grading.submissions.answers import partners_in
from gyrodata.grading.submissions.log_choice import NO_LOG
from gyrodata.grading.yardsticks import grouped
from gyrodata.readings import listing
from gyrodata.results import decode, encode

JOURNAL = "journal.ndjson"  # in the folder of the grades

# what is to be done with a submission that gyro could not open or grade
LOOK = "a person must look"

OTHER_VERSION = "gyrodata changed"  # first words of a reason to grade again

Item = TypeVar("Item")
Made = TypeVar("Made")


class GradingOptions(Struct, frozen=True):
    """How a class is graded; no option changes a grade."""

    workers: int = 1  # processes
    limit: float = (
        30.0  # time for one submission [s]; an ordinary one takes a hundredth
    )
    cluster: Executor | None = None  # grades on other machines instead
    journal: Path | None = None  # the file of earlier grades and of those of this run
    keep: bool = True  # False: the journal is only read
    progress: Callable[[int], None] | None = (
        None  # receives the number of grades that are made
    )

    def run(
        self, work: Callable[[Item], Made], items: Sequence[Item]
    ) -> closing[Generator[tuple[Item, Made | Failed], None, None]]:
        """Do the work for each item in workers, which are closed if this one stops."""
        answers = in_workers(work, items, self.workers, self.limit, self.cluster)
        return closing(answers)


def grade(
    source: str | os.PathLike[str],
    rubric: str | os.PathLike[str] | None = None,
    *,
    workers: int = 0,
) -> ClassGrades:
    """Grade a class as ``gyro grade`` does, and write nothing.

    Parameters
    ----------
    source : path
        A folder with a folder or file for each student, or the folder or zip that a
        platform gives.
    rubric : path, optional
        The rubric, TOML, or the name of a built-in one: "full", the usual one, "simple"
        or "manual".
    workers : int
        Processes; with 0 everything is done in this one, and nothing stops a submission
        that hangs.

    Returns
    -------
    ClassGrades
        ``grades`` has each student's marks with their reasons, ``flags`` the logs that
        look copied.

    Raises
    ------
    InputError
        If there is no submission, or if the rubric is invalid.
    OSError
        If the rubric cannot be read.
    TypeError
        If an argument has the wrong type.
    """
    insist_on_type("source", source, str | os.PathLike, "the path of a folder or a zip")
    insist_on_type("rubric", rubric, str | os.PathLike | None, "the path of a rubric")
    insist_on_type("workers", workers, int, "a number of processes")
    if workers < 0:
        raise ValueError(f"workers is {workers}; it must be 0 or more")
    kind = "full"
    if rubric:
        kind = str(rubric)
    is_built_in = kind in BUILT_IN
    text = (
        default_rubric_text(kind).encode() if is_built_in else Path(kind).read_bytes()
    )
    return grade_class(
        list_submissions(Path(source)),
        read_rubric(text, Path(kind).name),
        GradingOptions(workers=workers),
    )


def grade_class(
    submissions: Submissions,
    rubric: Rubric,
    options: GradingOptions | None = None,
    *,
    previous: Mapping[str, Fingerprint] = {},
    desk: Desk = NO_DESK,
    roster: Roster = EVERYBODY,
) -> ClassGrades:
    """Grade a class.

    Parameters
    ----------
    submissions, rubric, options
        The class, how it is judged, and how the work is done.
    previous : mapping
        Logs of earlier years by their names, to find copies of them.
    desk : Desk
        The decisions of a person, which replace those of gyro.
    roster : Roster
        The students of the class.

    Returns
    -------
    ClassGrades
        A submission that hangs, ends its process or breaks the tool is "not graded",
        with the reason, and is tried again in the next run.
    """
    options = options or GradingOptions()
    extra = _decided_without_hand_in(submissions, desk, roster)
    listed = sorted([*submissions.items, *extra], key=lambda item: item.student)
    items, notes = _chosen([desk.corrected(item) for item in listed], options)
    roster = roster.with_submissions(submission.student for submission in extra)
    meant = roster.who_is_meant(items)
    work = _Work.begun(rubric, options, desk)
    work.grade([item for item in items if item.log_name is not None])
    partners = find_partners(_texts_on_partners(items, work), roster, meant)
    items = _with_shared_logs(items, partners, desk)
    work.grade([item for item in items if item.student not in work.entries])
    work.write(items)
    groups = [*partners.groups, *partners_by_log(items)]
    declared = [*groups, *desk.partners]
    prints = work.prints
    flags = flag_class(prints, declared, previous, examples_for(prints))
    flags = in_order([*flags, *flag_simulated(prints)])
    same_data = [*declared, *desk.alike(flags)]
    settled, standard = _settled(items, roster, work, same_data)
    looks = {**partners.looks, **_looks_of_shared_logs(items, partners)}
    grades = []
    for grade, item in zip(settled, items, strict=True):
        more = filter(None, [looks.get(item.student)])
        grade = replace(grade, look=(*grade.look, *more))
        entry = work.entries[item.student]
        grades.append(desk.applied(grade, item, entry.subjects))
    diagnostics = (*submissions.diagnostics, *notes)
    submissions = replace(submissions, items=items, diagnostics=diagnostics)
    different_logs = each_log_once(settled, same_data)
    return ClassGrades(
        source=items[0].source.resolve().name,
        submissions=submissions,
        rubric=rubric,
        grades=tuple(grades),
        references=standard.references,
        scatters=standard.scatters,
        flags=flags,
        stations=tuple(station_figures(different_logs)),
        again=work.again,
        damaged=work.damaged,
        desk=desk,
        roster=roster,
        partners=groups,
        prints=prints,
    )


def _texts_on_partners(items: Iterable[Submission], work: _Work) -> dict[str, str]:
    """Return what each student says about partners, by student."""
    texts = {item.student: item.partner for item in items}
    return texts | {key: entry.grade.partner for key, entry in work.entries.items()}


def _decided_without_hand_in(
    submissions: Submissions, desk: Desk, roster: Roster
) -> list[Submission]:
    """Return students who handed in nothing, if a person decides about them."""
    source = submissions.items[0].source
    why = "nothing is handed in"
    return [
        Submission(
            absentee.student, absentee.name or absentee.student, {}, source, problem=why
        )
        for absentee in roster.absent
        if absentee.student in desk.lines or absentee.student in desk.requests
    ]


def _settled(
    items: Sequence[Submission],
    roster: Roster,
    work: _Work,
    same_data: Iterable[Iterable[str]],
) -> tuple[list[Grade], Standard]:
    """Compare the grades with the class, and look for mistakes in doubtful logs."""
    desk = work.desk
    named = []
    for item in items:
        grade = replace(work.entries[item.student].grade, fingerprint=None)
        named.append(roster.named(grade, desk.value(item.student, "station")))
    standard = standard_of(named, work.rubric, same_data)
    doubts = []
    for grade, item in zip(named, items, strict=True):
        typed = desk.value(item.student, "reported")
        doubts.append((standard.settled(grade), item, typed))
    return _reconsidered(doubts, standard, work.options), standard


# --- students without a log of their own ---


def _with_shared_logs(
    items: Sequence[Submission], partners: Partners, desk: Desk
) -> tuple[Submission, ...]:
    """Give the log of a partner to each student who has none."""
    with_log = {item.student: item for item in items if item.log_name is not None}
    completed = []
    for item in items:
        if item.student not in with_log:
            item = _with_shared_log(item, with_log, partners, desk)
        completed.append(item)
    return tuple(completed)


def _with_shared_log(
    item: Submission, with_log: Mapping[str, Submission], partners: Partners, desk: Desk
) -> Submission:
    """Give a student the log of the partner; say so if the partners have several."""
    decided = desk.partners_of(item.student)
    if not decided and not (item.problem or "").startswith(NO_LOG):
        return item
    own_partners = decided or partners.of(item.student)
    known = sorted(own_partners & with_log.keys())
    logs = {with_log[key].log_digest: with_log[key] for key in reversed(known)}
    if not logs:
        return item
    if len(logs) > 1:
        names = listing(known)
        problem = f"{item.problem}; its partners have different logs: {names}"
        return replace(item, problem=problem, known_digest="")
    (lender,) = logs.values()
    shared = repr((item.digest, lender.log_digest, bool(decided)))
    digest = hashlib.sha256(shared.encode()).hexdigest()
    item = replace(item, shares_answer=bool(decided), known_digest=digest, problem=None)
    return replace(
        item,
        log_name=lender.log_name,
        log_file=lender.log_file,
        log_of=lender.student,
    )


def _looks_of_shared_logs(
    items: Iterable[Submission], partners: Partners
) -> dict[str, str]:
    """Ask about each log that only the student without one says is shared."""
    looks = {}
    for item in items:
        is_confirmed = partners.lends(item.log_of, item.student)
        if item.log_of and not item.shares_answer and not is_confirmed:
            looks[item.student] = (
                f"graded on the log of {item.log_of}, but only {item.student} says "
                f"that they are partners: confirm it with a line partner in {DESK}"
            )
    return looks


# --- the work that needs the files of a submission: it is done in workers, where time
# and memory are limited --------


def _chosen(
    listed: Sequence[Submission], options: GradingOptions
) -> tuple[tuple[Submission, ...], list[Diagnostic]]:
    """Choose the log of each submission; also return notes on the choices."""
    chosen = {}
    with options.run(_choose_log_of, listed) as answers:
        for item, answer in answers:
            if isinstance(answer, Failed):
                answer = unread(item, str(answer)), []
            chosen[item.student] = answer
    sorted_again = [chosen[item.student] for item in listed]
    notes = [note for _, some in sorted_again for note in some]
    return tuple(item for item, _ in sorted_again), notes


def _choose_log_of(item: Submission) -> tuple[Submission, list[Diagnostic]]:
    """Choose the log of a submission, and the digest of all that its grade needs."""
    made, choice = choose(item)
    if item.log_name is not None:
        # A person corrected the log: a new log of the student must be noticed.
        own, _ = choose(replace(item, log_name=None, log_file=None))
        made = replace(made, original_digest=own.digest)
    if made.log_name is None:
        made = replace(made, partner=partners_in(None, made.documents))
    digest = made.digest
    log = made.texts.get(made.log_name or "")
    log_digest = ""
    if isinstance(log, bytes):
        log_digest = hashlib.sha256(log).hexdigest()
    notes = []
    if choice:
        words = f"{made.name}: {choice}"
        notes.append(Diagnostic.named("one_of_logs", item.source.name, choice=words))
    return replace(made, known_digest=digest, log_digest=log_digest), notes


def _load_analysis() -> None:
    """Load the code of the workers before they are forked from this process."""
    import uncertainties  # noqa: F401

    from gyrodata import analysis  # noqa: F401
    from gyrodata.judging import procedure  # noqa: F401
    from gyrodata.quantities import units

    units.load()


Doubt = tuple[Grade, Submission, str | None]
"""A settled grade, its submission, and I_zz typed in by a person."""


def _reconsidered(
    doubts: Sequence[Doubt], standard: Standard, options: GradingOptions
) -> list[Grade]:
    """Look for mistakes in logs that are far from the reference.

    Return all grades in the same order.
    """
    grades = {doubted.student: doubted for doubted, _, _ in doubts}
    waiting = [
        doubt for doubt in doubts if find_disagreement(doubt[0], standard.references)
    ]
    if waiting:
        _load_analysis()
    work = partial(_reconsider_grade, standard)
    with options.run(work, waiting) as answers:
        for (grade, _, _), answer in answers:
            if isinstance(answer, Failed):
                look = f"gyro could not look for a mistake in the log: {answer}"
                answer = replace(grade, look=(*grade.look, look))
            grades[grade.student] = answer
    return list(grades.values())


def _reconsider_grade(standard: Standard, doubt: Doubt) -> Grade:
    """Look for a mistake in one log."""
    grade, item, typed = doubt
    # Only a copy keeps the texts that are read.
    return reconsider(grade, replace(item), standard, typed)


# --- the journal: a line for each grade, with its inputs ---


class Entry(Struct, frozen=True, kw_only=True):
    """One line: a grade before the class was compared, and its inputs."""

    schema: Literal["gyro.journal/2"] = "gyro.journal/2"
    inputs: Mapping[
        str, str
    ]  # as `_inputs_of` returned them; none of a grade that was lost
    grade: Grade
    lost: str = ""
    """Why the run lost the grade (a time limit, a process that died), so that it is
    tried again; else ""."""
    subjects: Mapping[str, str] = field(default={}, name="seen")
    """For each line of the desk, the digest of the submission for which it was
    written."""


def read_journal(data: bytes) -> tuple[dict[str, Entry], int]:
    """Return the last entry of each student, and the number of damaged lines.

    A damaged line cannot be read, for example after a power cut.
    """
    entries = dict[str, Entry]()
    damaged = 0
    for line in filter(None, data.splitlines()):
        try:
            entry = decode(line, Entry)
            entries[entry.grade.student] = entry
        except (ValueError, ValidationError, RecursionError):
            damaged += 1
    return entries, damaged


def _inputs_of(item: Submission, rubric: Rubric, reported: str) -> dict[str, str]:
    """Return digests of all that a grade depends on.

    `reported` is the value that a person typed in.
    """
    ids = sorted(item.ids.items())
    text = repr((item.digest, item.name, ids, item.members))
    digest = hashlib.sha256(text.encode("utf-8", "replace")).hexdigest()
    # The rubric without its references is compared first.
    about = {"submission": digest, "rubric": rubric.judged, "reference": rubric.digest}
    return {**about, "desk": reported, "tool": __version__}


def _why_again(
    known: Entry | None, item: Submission, rubric: Rubric, reported: str
) -> str:
    """Say why a submission is graded again; "" if the known grade is still right."""
    if known is None or known.lost:
        return f"lost last time: {known.lost}" if known else "new"
    for name, value in _inputs_of(item, rubric, reported).items():
        before = known.inputs.get(name)
        if before != value and name == "tool":
            return f"{OTHER_VERSION} from {before} to {value}"
        if before != value:
            return f"the {name} changed"
    return ""


class _Work(Struct):
    """The grades of a class, as they are taken from the journal or made."""

    rubric: Rubric
    options: GradingOptions
    desk: Desk
    journal: bytes
    """The file before this run."""
    known: Mapping[str, Entry]
    damaged: int
    """Number of lines of the journal that cannot be read."""
    entries: dict[str, Entry]
    again: dict[str, str]
    """Why the grades of this run are made, by student."""

    @classmethod
    def begun(cls, rubric: Rubric, options: GradingOptions, desk: Desk) -> _Work:
        """Read the journal."""
        path = options.journal
        journal = b""
        if path is not None and path.is_file():
            journal = path.read_bytes()
        known, damaged = read_journal(journal)
        return cls(rubric, options, desk, journal, known, damaged, {}, {})

    @property
    def writes(self) -> Path | None:
        """The journal, if it is written."""
        return self.options.journal if self.options.keep else None

    def grade(self, items: Sequence[Submission]) -> None:
        """Take each grade from the journal, or make it in a worker."""
        waiting: list[tuple[Submission, str]] = []
        for item in items:
            reported = self.desk.value(item.student, "reported") or ""
            entry = self.known.get(item.student)
            why = _why_again(entry, item, self.rubric, reported)
            if entry is not None and not why:
                self.entries[item.student] = entry
                continue
            self.again[item.student] = why
            if item.lost:
                self._keep(item, Failed(item.lost))
            else:
                waiting.append((item, reported))
        if waiting:
            _load_analysis()
        work = partial(_grade_student, self.rubric)
        # Closed at once if Ctrl-C stops this process, so that no worker goes on.
        with self.options.run(work, waiting) as answers:
            for (item, _), answer in answers:
                self._keep(item, answer)

    def _keep(self, item: Submission, answer: bytes | Failed) -> None:
        """Keep a grade that was made, also if the run is stopped afterwards.

        A submission that stopped its worker, or cannot be opened, is not graded.
        """
        if isinstance(answer, Failed):
            grade = not_graded(item, self.rubric, f"{answer}; {LOOK}")
            answer = encode(Entry(inputs={}, grade=grade, lost=str(answer)))
        # The grade goes through JSON at once, so that a grade from the journal is the
        # same to the last digit.
        entry = decode(answer, Entry)
        before = self.known.get(item.student)
        if before is not None:
            entry = replace(entry, subjects=before.subjects)
        self.entries[item.student] = entry
        if self.writes:
            # The last line may have no end, if a run was stopped.
            disk.add_to(self.writes, b"\n%b\n" % encode(entry))
        if self.options.progress is not None:
            self.options.progress(len(self.entries))

    @property
    def prints(self) -> dict[str, Fingerprint]:
        """The rows of each log that can be analysed, by student."""
        prints = {key: entry.grade.fingerprint for key, entry in self.entries.items()}
        return {key: log for key, log in prints.items() if log is not None}

    def write(self, items: Iterable[Submission]) -> None:
        """Write the entries into the journal, in the order of the items.

        With them are the digests for which the lines of the desk were written.
        """
        lines = []
        for item in items:
            entry = self.entries[item.student]
            subjects = self.desk.first_seen(entry.grade, item, entry.subjects)
            entry = replace(entry, subjects=subjects)
            self.entries[item.student] = entry
            lines.append(encode(entry) + b"\n")
        if self.writes and (self.again or b"".join(lines) != self.journal):
            disk.write_whole(self.writes, lines, private=True, sync=True)


def _grade_student(rubric: Rubric, task: tuple[Submission, str]) -> bytes:
    """Grade one submission in a worker, with I_zz as a person typed it, or ""."""
    item, reported = task
    # Only a copy keeps the texts that are read.
    grade = grade_submission(replace(item), rubric, reported or None)
    inputs = _inputs_of(item, rubric, reported)
    return encode(Entry(inputs=inputs, grade=grade))


# --- a class that has been graded ---


class ClassGrades(Struct, frozen=True, dict=True):
    """All results of a run."""

    source: str
    """Name of the folder or zip, without its path."""
    submissions: Submissions
    rubric: Rubric
    grades: Sequence[Grade]
    """The grade of each student: points, status, and the reason of each criterion."""
    references: Mapping[
        str, yardsticks.Reference
    ]  # of I_zz, by station; "all" for every other station
    flags: tuple[Flag, ...]
    """Logs that may be copies."""
    again: Mapping[
        str, str
    ]  # why students were graded in this run, by key; the other grades were known
    damaged: int  # lines of the journal that could not be read
    desk: Desk = NO_DESK  # decisions of a person
    roster: Roster = EVERYBODY
    partners: Sequence[frozenset[str]] = ()  # declared in logs and in the roster
    scatters: Mapping[
        str, yardsticks.BenchScatter
    ] = {}  # of the readings, by station, if the rubric asks for it
    prints: Mapping[str, Fingerprint] = {}
    """The rows of each log that can be analysed, by student."""
    stations: tuple[StationFigures, ...] = ()
    """Of the stations whose logs are of several days."""

    def __repr__(self) -> str:
        return f"<ClassGrades of {self.source[:200]}: {self.tally}>"

    def _repr_html_(self) -> str:
        """Return what a notebook shows."""
        return f'<pre style="white-space: pre-wrap">{escape(self.summary)}</pre>'

    @cached_property
    def totals(self) -> list[float]:
        """Points of the graded students, in the order of the grades."""
        graded = [grade for grade in self.grades if grade.status == "graded"]
        points = [grade.points for grade in graded]
        return [total for total in points if total is not None]

    def count(self, status: str) -> int:
        """Count the grades with a status."""
        return sum(grade.status == status for grade in self.grades)

    @cached_property
    def tally(self) -> str:
        """The number of grades with each status, in words."""
        counts = {
            state: self.count(state) for state in ("so far", "on hold", "excused")
        }
        absent = {"handed in nothing": len(self.roster.absent)}
        parts = {"graded": len(self.totals), **counts}
        parts |= {"not": self.count("not graded"), **absent}
        shown = ("graded", "not")
        kept = {name: count for name, count in parts.items() if count or name in shown}
        return ", ".join(f"{count} {name}" for name, count in kept.items())

    @cached_property
    def slips(self) -> Mapping[str, list[str]]:
        """The students with each common mistake, the most common first."""
        with_slip = [grade for grade in self.grades if grade.slips]
        students = grouped((grade.slips[0].kind, grade.student) for grade in with_slip)
        kinds = sorted(students, key=lambda kind: (-len(students[kind]), kind))
        return {kind: students[kind] for kind in kinds}

    @cached_property
    def table(self) -> str:
        """``grades.csv``."""
        return exports.grades_csv(self)

    @cached_property
    def summary(self) -> str:
        """The text for a terminal: the class, students, flags, and open decisions.

        Each student has a row.
        """
        offers = find_offers(self)
        reasons = grouped((offer.reason, self._people(offer)) for offer in offers)
        open_flags = [offer.flag for offer in offers]
        return (
            environment()
            .get_template("class.txt.jinja")
            .render(class_grades=self, reasons=reasons, open_flags=open_flags)
        )

    def _people(self, offer: Offer) -> str:
        """Return the students of a line for the desk."""
        return BETWEEN.join(map(self.label, offer.people))

    @cached_property
    def bench(self) -> str:
        """The scatter that constancy is compared with; "" for the usual one."""
        stations = sorted(self.scatters, key=yardsticks.in_order)
        scatters = [self.scatters[station] for station in stations]
        lines = [scatter.words for scatter in scatters if scatter.factor > 1]
        if not lines:
            return ""
        words = "; ".join(lines)
        return f"{words}: φ̇ψ̇ is judged by that"

    @property
    def without_station(self) -> str:
        """Ask for the stations if the logs without one have several values of I_zz."""
        with_log = [grade for grade in self.grades if grade.own]
        missing = sum(grade.station is None for grade in with_log)
        reference = self.references.get("all")
        if not missing or reference is None or not reference.is_vague:
            return ""
        logs = count_text(missing, "log")
        why = f"{logs} without a station, and I_zz of the class has several values"
        return f"{why}: ask for the stations, and write them into {DESK}"

    @property
    def mean(self) -> float | None:
        """Mean of the points; None if nobody is graded."""
        if not self.totals:
            return None
        return round(statistics.fmean(self.totals), 4)

    @property
    def median(self) -> float | None:
        """Median of the points; None if nobody is graded."""
        return statistics.median(self.totals) if self.totals else None

    @cached_property
    def sections(self) -> list[SectionFigures]:
        """The points of each section and of each grader."""
        return list(section_figures(self))

    @cached_property
    def ids(self) -> Mapping[str, Mapping[str, str]]:
        """The ids of each student on platforms."""
        return {item.student: item.ids for item in self.submissions.items}

    @cached_property
    def names(self) -> Mapping[str, str]:
        """The shown name of each student."""
        return {grade.student: grade.name for grade in self.grades}

    def without_names(self) -> ClassGrades:
        """Return the class with ids instead of names."""
        grades = [replace(grade, name=grade.student) for grade in self.grades]
        return replace(
            self,
            grades=grades,
            desk=self.desk.without_names(),
            roster=self.roster.without_names(),
            submissions=replace(self.submissions, diagnostics=()),
        )

    def label(self, student: str) -> str:
        """Return the name of a student, with the key if it is not in the name."""
        name = self.names.get(student, student)
        if student in name:
            return name
        return f"{name} ({student})"

    @cached_property
    def groups(self) -> list[list[str]]:
        """The students who work together, each group sorted."""
        groups: list[set[str]] = []
        for some in [*self.partners, *self.desk.partners]:
            joined = [group for group in groups if group & some]
            groups = [group for group in groups if not group & some]
            groups.append(set(some).union(*joined))
        return sorted(sorted(group & self.names.keys()) for group in groups)

    @cached_property
    def flags_of(self) -> Mapping[str, list[Flag]]:
        """The flags of each flagged student."""
        return grouped(
            (student, flag) for flag in self.flags for student in flag.students
        )

    def criteria(self) -> Iterator[exports.CriterionFigures]:
        """Yield the results of the class in each criterion of the rubric."""
        for at, criterion in enumerate(self.rubric.criteria):
            points = [grade.marks[at].points for grade in self.grades]
            judged = [value for value in points if value is not None]
            full = sum(value >= criterion.points for value in judged)
            none = sum(value <= 0 for value in judged)
            mean = None
            if judged:
                mean = round(statistics.fmean(judged), 4)
            yield exports.CriterionFigures(
                criterion.id,
                criterion.title,
                criterion.points,
                len(judged),
                full,
                none,
                mean,
            )
