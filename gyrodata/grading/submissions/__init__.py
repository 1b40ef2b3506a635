"""Who handed in what: a folder or zip of a class becomes `Submission`s, one for each student or group.

Only names and metadata are read here; a log is read when it is graded, one at a time, straight from where it is.
"""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path, PurePosixPath
from typing import Literal

from msgspec import Struct
from msgspec.structs import replace

from gyrodata.diagnostics import (
    FILE_NOT_FOUND,
    FILES_OF_NO_STUDENT,
    GRADESCOPE_METADATA_CANNOT_BE_READ,
    NO_SUBMISSION,
    ONE_OF_SEVERAL_GRADED,
)
from gyrodata.errors import Diagnostic, GyroError, InputError
from gyrodata.grading.platforms import NAMED, PLATFORMS, Autograder
from gyrodata.grading.submissions.archives import Listing, list_files, read_file, size_text
from gyrodata.grading.submissions.metadata import LARGEST, Metadata, MetadataError, read_export, read_live
from gyrodata.grading.submissions.names import (
    ParsedName,
    name_all,
    people_by_receipts,
    read_own_name,
    read_pattern,
    shown,
    whose_names,
)
from gyrodata.grading.submissions.student_files import Answers, choose_files, read_answers
from gyrodata.readings import Readings, listing, read_log

__all__ = [
    "Answers",
    "Attempts",
    "Submission",
    "Submissions",
    "find_submissions",
    "list_files",
    "read_answers",
    "read_file",
    "shown",
    "size_text",
    "submission_of",
]

Attempts = Literal["newest", "oldest"]


_MOST_RECEIPT = 200_000
_MOST_REPORT = 1_000_000


class Submission(Struct, frozen=True, dict=True):
    """What one student, or one group, handed in."""

    # key, unique in the class and the same from one download to the next: the platform's number, else the name
    # of the folder or file
    student: str
    name: str  # as to be shown
    # what platforms know the student by: ``canvas``, ``moodle``, ``username``, ``sid``, ``email``,
    # ``gradescope`` (the number of the submission), ``folder``
    ids: Mapping[str, str]
    source: Path  # folder or zip of the class
    members: tuple[str, ...] = ()  # all files, as names below `source`
    log_name: str | None = None  # the one that is graded, as a name below `source`
    log_file: str | None = None  # the same as the student named it
    report_names: tuple[str, ...] = ()  # other texts in which an answer may stand, as names below `source`
    late: bool = False  # marked late by the platform, or handed in after the due date that it tells
    # time after the due date [s], 0 before it; None where the platform tells no due date
    late_seconds: float | None = None
    submitted: str | None = None  # when, ISO 8601; from marks and metadata, never from the clock
    attempt: int = 1  # 1 for the first
    members_of_group: tuple[str, ...] = ()  # keys of all in the group, where the platform tells them
    problem: str | None = None  # why there is nothing to grade; None where there is a log
    # name of a file (without its ending) or folder under which the platform takes feedback back
    feedback_stem: str = ""

    def log(self) -> bytes:
        """Read the log."""
        if self.log_name is None:
            raise InputError.of(NO_SUBMISSION, f"{self.name}: {self.problem}")
        return read_file(self.source, self.log_name)

    def reports(self) -> Iterator[tuple[str, bytes]]:
        """Read the other texts in which an answer may stand, with names to show; one that cannot be read is empty."""
        for name in self.report_names:
            try:
                yield shown(name.rpartition("/")[2]), read_file(self.source, name, _MOST_REPORT)
            except GyroError:
                continue

    def read(self) -> tuple[Readings, Answers]:
        """Read the log, and what is reported: whatever grades, or tells what would be graded, reads them here."""
        name = PurePosixPath(self.log_file or self.log_name or "log").name
        readings = read_log(self.log(), name=name)
        return readings, read_answers(readings, self.reports())

    def feedback_name(self, ending: str) -> str:
        """Name a feedback file, below the zip that is handed back, so that the platform gives it to this student.

        `ending`: ``.html``, ``.md``, .
        """
        in_folder = self.ids.get("folder") == shown(self.feedback_stem)
        return f"{self.feedback_stem}/feedback{ending}" if in_folder else f"{self.feedback_stem}{ending}"

    @cached_property
    def digest(self) -> str:
        """SHA-256 of all that a grade depends on: names and bytes of the log and of texts, lateness, the problem."""
        told = [self.log_file, self.late, self.late_seconds, self.submitted, self.problem]
        digest = hashlib.sha256(repr(told).encode("utf-8", "replace"))
        try:
            data = self.log()
        except GyroError as error:
            data = str(error).encode("utf-8", "replace")
        digest.update(hashlib.sha256(data).digest())
        for name, data in self.reports():
            digest.update(name.encode("utf-8", "replace") + hashlib.sha256(data).digest())
        return digest.hexdigest()


class Submissions(Struct, frozen=True):
    """A class."""

    lms: str  # whose names they are: ``canvas``, ``moodle``, ``blackboard``, ``gradescope``, ``folder`` or ``pattern``
    items: tuple[Submission, ...]  # sorted by `Submission.student`
    diagnostics: tuple[Diagnostic, ...] = ()  # what was left aside, and what could not be read

    @property
    def aliases(self) -> dict[str, str]:
        """Every name by which a student may be called, with the student's key; a key goes before others' names."""
        names = {name: item.student for item in self.items for name in (item.name, *item.ids.values())}
        return names | {item.student: item.student for item in self.items}


def find_submissions(
    path: str | Path, lms: str = "auto", pattern: str | None = None, attempts: Attempts = "newest"
) -> Submissions:
    r"""Find the submissions of a class.

    Parameters
    ----------
    path : str or Path
        A folder with a folder or file for each student, what a platform hands out, or its zip.
    lms : str
        Whose names the files have, of `PLATFORMS`; "auto" finds out.
    pattern : str, optional
        A regular expression of one's own instead, such as ``(?P<student>\w+)_lab\.csv``.
    attempts : {"newest", "oldest"}
        Which of several attempts is graded.

    Returns
    -------
    Submissions
        One for each student or group.
    """
    own = None if pattern is None else read_pattern(pattern)
    if lms != "auto" and lms not in PLATFORMS:
        hint = f"write one of: auto, folder, {', '.join(NAMED)}"
        raise InputError.of(NO_SUBMISSION, f'there is no --lms "{lms}"', hint)
    root = Path(path)
    for name, platform in PLATFORMS.items():
        if own is None and platform.autograder is not None and lms in ("auto", name):
            live = lms == name or (root / platform.autograder.metadata).is_file()
            if live and (root / platform.autograder.submission).is_dir():
                return _running_autograder(root, name, platform.autograder, attempts)
    files = list_files(root)
    below = ""
    if own is not None:
        seen = "pattern"
        named = {name: read_own_name(name, own) for name in files.sizes}
    else:
        seen, below = whose_names(list(files.sizes), files.folders, lms, root.is_file())
        named = name_all(list(files.sizes), seen, below)
    finder = _Finder(files, seen, attempts)
    items = finder.find(named, _empty_handed(files, below) if seen == "folder" else ())
    if not items:
        raise _nothing_found(files, lms, pattern)
    return Submissions(seen, items, tuple(finder.told))


def submission_of(paths: Sequence[Path]) -> tuple[Submission, tuple[Diagnostic, ...]]:
    """Take files, or one folder or zip, as what one student hands in; say what is left aside."""
    first = paths[0]
    diagnostics: tuple[Diagnostic, ...] = ()
    if any(path.is_dir() or path.suffix.lower() == ".zip" for path in paths):
        if len(paths) > 1:
            hint = "give the files that are handed in together, or the one folder or zip that they are in"
            raise InputError.of(NO_SUBMISSION, f"{len(paths)} are given, and not all of them are files", hint)
        files = list_files(first)
        root, sizes, diagnostics = files.root, files.sizes, files.diagnostics
        own = {name: shown(name) for name in sizes}
    else:
        root = Path.cwd()
        for path in paths:
            if not path.is_file():
                raise InputError.of(FILE_NOT_FOUND, f"there is no file {str(path)!r}", "check its name and its folder")
        # A name that is whole is found below any folder.
        resolved = {str(path.resolve()): path for path in paths}
        sizes = {name: path.stat().st_size for name, path in resolved.items()}
        own = {name: shown(path.name) for name, path in resolved.items()}
    choice = choose_files(own, sizes, lambda name: read_file(root, name))
    if choice.note:
        diagnostics = (*diagnostics, Diagnostic.of(ONE_OF_SEVERAL_GRADED, choice.note))
    made = Submission(
        first.name, first.name, {}, root, tuple(sorted(own)), choice.log, own[choice.log] if choice.log else None,
        tuple(choice.reports(own)), problem=choice.problem, feedback_stem=first.stem,
    )  # fmt: skip
    return made, diagnostics


def _running_autograder(root: Path, lms: str, layout: Autograder, attempts: Attempts) -> Submissions:
    """Find the one submission that a running autograder has beside its metadata."""
    stem = layout.submission
    files = list_files(root / stem)
    finder = _Finder(files, lms, attempts)
    one = ParsedName(stem, stem, {}, "", stem)
    finder.read_metadata(root, layout.metadata, lambda data: {stem: read_live(data)})
    items = finder.find({name: replace(one, file=name) for name in files.sizes}, ())
    if not items:
        who = _person(one, finder.metadata.get(one.stem))
        items = (Submission(who.student, who.name, who.ids, files.root, problem="no files", feedback_stem=one.stem),)
    return Submissions(lms, items, tuple(finder.told))


def _empty_handed(files: Listing, below: str) -> tuple[str, ...]:
    """Name the students whose folder holds nothing."""
    inner = [folder.removeprefix(below) for folder in files.folders if folder.startswith(below)]
    return tuple(shown(folder.rstrip("/")) for folder in inner if folder.count("/") == 1)


def _nothing_found(files: Listing, lms: str, pattern: str | None) -> InputError:
    root = files.root.name
    if not files.sizes:
        hint = "give the folder or zip of the class"
        return InputError.of(NO_SUBMISSION, f'"{root}" holds no files', hint, root)
    one = shown(min(files.sizes))
    if pattern is not None:
        message = f'--pattern "{pattern}" fits no file of "{root}"'
        return InputError.of(NO_SUBMISSION, message, f"make it fit such a name: {one}", root)
    message = f'"{root}" holds no submission as {"a platform" if lms == "auto" else lms} names them; one file is: {one}'
    sample = PLATFORMS["folder" if lms == "auto" else lms].sample
    without = "" if lms == "auto" else f"leave --lms {lms} out, or "
    hint = f"{without}name them such as {sample}, or give a --pattern"
    return InputError.of(NO_SUBMISSION, message, hint, root)


# --- from files to submissions ------------------------------------------------------------------------------


class _Finder:
    """Gathers the files of each student."""

    def __init__(self, files: Listing, lms: str, attempts: Attempts) -> None:
        self.files = files
        self.lms = lms
        self.platform = PLATFORMS.get(lms)
        self.oldest = attempts == "oldest"
        self.told = list(files.diagnostics)
        self.metadata: Mapping[str, Metadata] = {}

    def find(self, named: Mapping[str, ParsedName | None], empty_handed: tuple[str, ...]) -> tuple[Submission, ...]:
        """Make the submissions of those who handed in files, and of those whose folder is empty."""
        fitting = {name: what for name, what in named.items() if what is not None}
        self._tell_left_out([name for name, what in named.items() if what is None])
        if self.platform is not None and self.platform.receipts:
            who = people_by_receipts(self.lms, fitting, lambda name: read_file(self.files.root, name, _MOST_RECEIPT))
            fitting = {
                name: replace(what, student=who[name][0], name=who[name][1], ids={"username": who[name][0]})
                for name, what in fitting.items()
            }
        if self.platform is not None and self.platform.metadata:
            export = [n for n in named.keys() - fitting.keys() if n.rpartition("/")[2] == self.platform.metadata]
            if export:
                self.read_metadata(self.files.root, min(export), read_export)
            fitting = {name: _person(what, self.metadata.get(what.stem)) for name, what in fitting.items()}
        people: dict[str, dict[str, ParsedName]] = {}
        for name, what in fitting.items():
            people.setdefault(what.student, {})[name] = what
        items = [self._submission(student, files) for student, files in people.items()]
        items += [
            Submission(name, name, {"folder": name}, self.files.root, problem="no files", feedback_stem=name)
            for name in empty_handed
            if name not in people
        ]
        return _with_unlike_names(sorted(items, key=lambda item: item.student))

    def _tell(self, code: str, message: str, hint: str = "") -> None:
        self.told.append(Diagnostic.of(code, message, hint, self.files.root.name))

    def _tell_left_out(self, names: list[str]) -> None:
        known = {one.metadata for one in PLATFORMS.values()}
        known |= {one.autograder.metadata for one in PLATFORMS.values() if one.autograder is not None}
        names = sorted(shown(name) for name in names if name.rpartition("/")[2] not in known)
        if names:
            count = "1 file is" if len(names) == 1 else f"{len(names)} files are"
            message = f"{count} of no student and left aside: {listing(names, 5)}"
            hint = "change --pattern so that it fits these as well, or rename them"
            if self.platform is not None:
                hint = f"rename them, if they count: {self.lms} names files such as {self.platform.sample}"
            self._tell(FILES_OF_NO_STUDENT, message, hint)

    def _submission(self, student: str, named: Mapping[str, ParsedName]) -> Submission:
        """Make the submission of one student, of the attempt that counts."""
        stamps = sorted({(what.submitted or "", what.attempt or 0) for what in named.values()})
        stamp = stamps[0 if self.oldest else -1]
        files = {name: what for name, what in named.items() if (what.submitted or "", what.attempt or 0) == stamp}
        first = next(iter(files.values()))
        if len(stamps) > 1:
            which = "oldest" if self.oldest else "newest"
            self._tell(ONE_OF_SEVERAL_GRADED, f"{first.name} has {len(stamps)} attempts; the {which} is graded")
        own = {name: what.file for name, what in files.items() if what.file}
        choice = choose_files(own, self.files.sizes, lambda name: read_file(self.files.root, name), self.oldest)
        if choice.note:
            self._tell(ONE_OF_SEVERAL_GRADED, f"{first.name}: {choice.note}")
        graded = files[choice.log] if choice.log else first
        told = self.metadata.get(first.stem, Metadata(()))
        late = told.late_seconds
        return Submission(
            student,
            first.name,
            graded.ids,
            self.files.root,
            tuple(sorted(own)),
            choice.log,
            own[choice.log] if choice.log else None,
            tuple(sorted([*choice.reports(own), *(name for name, what in files.items() if not what.file)])),
            any(what.late for what in files.values()) or (late is not None and late > 0),
            None if late is None else max(0.0, late),
            told.submitted or first.submitted,
            max(told.attempt, first.attempt or 1, stamps.index(stamp) + 1),
            tuple(sorted(one.key for one in told.submitters)) if len(told.submitters) > 1 else (),
            choice.problem,
            graded.stem,
        )

    def read_metadata(self, root: Path, name: str, read: Callable[[bytes], Mapping[str, Metadata]]) -> None:
        """Read a metadata file, by the folder of each submission."""
        try:
            self.metadata = read(read_file(root, name, LARGEST))
        except (GyroError, MetadataError) as error:
            hint = "names and times are not known; students are named by their submission's number"
            file = name.rpartition("/")[2]
            self._tell(GRADESCOPE_METADATA_CANNOT_BE_READ, f"{file} cannot be read: {error}", hint)


def _person(what: ParsedName, about: Metadata | None) -> ParsedName:
    """Name a submission by those who handed it in; in a group, by all of them."""
    if about is None or not about.submitters:
        return what
    people = sorted(about.submitters, key=lambda one: one.key)
    first = people[0]
    ids = {"gradescope": about.number, "sid": first.sid, "email": first.email, "folder": what.stem}
    key = "+".join(shown(one.key) for one in people)
    name = ", ".join(shown(one.name) or shown(one.key) for one in people)
    told = {kind: value for kind, value in ids.items() if value}
    return replace(what, student=key, name=name, ids=told, submitted=about.submitted)


def _with_unlike_names(items: list[Submission]) -> tuple[Submission, ...]:
    """Put the key behind names that several students have, as all have on a page that is marked blind."""
    counts = Counter(item.name for item in items)
    return tuple(
        replace(item, name=f"{item.name} ({item.student})") if counts[item.name] > 1 else item for item in items
    )
