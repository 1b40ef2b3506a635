"""Read a folder or zip of a class into `Submission`s, one for each student or group.

Only names and metadata are read here; a log is read when it is graded, one at a time, straight from where it is.
"""

from __future__ import annotations

import hashlib
import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property, partial
from pathlib import Path, PurePosixPath

from msgspec import Struct
from msgspec.structs import replace

from gyrodata import diagnostics
from gyrodata.errors import Diagnostic, GyroError, InputError, shown
from gyrodata.grading.platforms import NAMED, PLATFORMS
from gyrodata.grading.submissions.archives import Listing, list_files, read_file
from gyrodata.grading.submissions.metadata import EXPORT, LARGEST, LIVE, Metadata, read_export, read_live
from gyrodata.grading.submissions.names import (
    ParsedName,
    name_all,
    people_by_receipts,
    read_own_name,
    read_pattern,
    whose_names,
)
from gyrodata.grading.submissions.student_files import TEXTS, Answers, Attempts, choose_files, ending, read_answers
from gyrodata.readings import MAX_BYTES, Readings, listing, read_log

_REPORT = re.compile(r"-report(?:-\d+)?/$")  # how ``gyro analyze`` names a folder
_MOST_RECEIPT = 200_000
_MOST_REPORT = 1_000_000


class Submission(Struct, frozen=True, dict=True):
    """The submission of one student or group."""

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
    # time after the due date [s], 0 before it; None if the platform gives no due date
    late_seconds: float | None = None
    submitted: str | None = None  # when, ISO 8601; from marks and metadata, never from the clock
    attempt: int = 1  # 1 for the first
    members_of_group: tuple[str, ...] = ()  # keys of all in the group, if the platform gives them
    problem: str | None = None  # why there is nothing to grade; None where there is a log
    # name of a file (without its ending) or folder under which the platform takes feedback back
    feedback_stem: str = ""

    @cached_property
    def texts(self) -> Mapping[str, bytes | InputError]:
        """The log and the other texts, or why they cannot be read; once, for the digest and for what is judged."""
        most = dict.fromkeys(self.report_names, _MOST_REPORT) | ({self.log_name: MAX_BYTES} if self.log_name else {})
        return {name: _read(self.source, name, size) for name, size in most.items()}

    def log(self) -> bytes:
        """Give the log."""
        if self.log_name is None:
            raise InputError.of(diagnostics.NO_SUBMISSION, f"{self.name}: {self.problem}")
        if isinstance(data := self.texts[self.log_name], InputError):
            raise data
        return data

    def reports(self) -> Iterator[tuple[str, bytes]]:
        """Give the other texts in which an answer may stand, with names to show."""
        texts = ((shown(name.rpartition("/")[2]), self.texts[name]) for name in self.report_names)
        return ((name, data) for name, data in texts if isinstance(data, bytes))

    @property
    def unread(self) -> list[Diagnostic]:
        """Say what cannot be read."""
        return [one for data in self.texts.values() if isinstance(data, InputError) for one in data.diagnostics]

    def read(self, settings: Mapping[str, str] = {}) -> tuple[Readings, Answers]:
        """Read the log and the reported value, for grading and for its preview.

        `settings`: As `read_log` has them.
        """
        name = PurePosixPath(self.log_file or self.log_name or "").name
        readings = read_log(self.log(), name=name, settings=settings)
        answers = read_answers(readings, self.reports())
        return readings, replace(answers, diagnostics=(*answers.diagnostics, *self.unread))

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


def _read(source: Path, name: str, most: int) -> bytes | InputError:
    """Read a file, or say why it cannot be."""
    try:
        return read_file(source, name, most)
    except InputError as error:
        return error


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
        raise InputError.of(diagnostics.NO_SUBMISSION, f'there is no --lms "{lms}"', hint)
    root = Path(path)
    live = lms == "gradescope" or (lms == "auto" and (root / LIVE).is_file())
    if own is None and live and (root / "submission").is_dir():
        return _running_autograder(root, attempts)
    files = _without_reports(list_files(root))
    empty: list[ParsedName] = []
    if own is not None:
        seen = "pattern"
        named = {name: read_own_name(name, own) for name in files.sizes}
    else:
        seen, below = whose_names(list(files.sizes), files.folders, lms, root.is_file())
        named = name_all(list(files.sizes), seen, below)
        if seen == "folder":
            inner = [folder.removeprefix(below) for folder in files.folders if folder.startswith(below)]
            students = [shown(folder.rstrip("/")) for folder in inner if folder.count("/") == 1]
            empty = [ParsedName(student, student, {"folder": student}, "", student) for student in students]
    finder = _Finder(files, seen, attempts)
    items = finder.find(named, empty)
    if not items:
        raise _nothing_found(files, lms, pattern)
    return Submissions(seen, items, tuple(finder.told))


def submission_of(paths: Sequence[Path]) -> tuple[Submission, tuple[Diagnostic, ...]]:
    """Take files, or one folder or zip, as what one student hands in; say what is left aside."""
    first = paths[0]
    if any(path.is_dir() or path.suffix.lower() == ".zip" for path in paths):
        if len(paths) > 1:
            hint = "give the files that are handed in together, or the one folder or zip that they are in"
            raise InputError.of(
                diagnostics.NO_SUBMISSION, f"{len(paths)} are given, and not all of them are files", hint
            )
        files = _without_reports(list_files(first))
        own = {name: shown(name) for name in files.sizes}
    else:
        for path in paths:
            if not path.is_file():
                raise InputError.of(
                    diagnostics.FILE_NOT_FOUND, f"there is no file {str(path)!r}", "check its name and its folder"
                )
        # A name that is whole is found below any folder.
        own = {str(path.resolve()): shown(path.name) for path in paths}
        files = Listing(Path.cwd(), {name: Path(name).stat().st_size for name in own})
    one = ParsedName(first.name, first.name, {}, "", first.stem)
    made, note = _submission(files, {"": one} | {name: replace(one, file=file) for name, file in own.items()})
    told = [Diagnostic.of(diagnostics.ONE_OF_SEVERAL_GRADED, note)] if note else []
    return made, (*files.diagnostics, *told)


def _running_autograder(root: Path, attempts: Attempts) -> Submissions:
    """Find the submission that an autograder of Gradescope has next to its metadata."""
    one = ParsedName("submission", "submission", {}, "", "submission")
    files = list_files(root / one.stem)
    finder = _Finder(files, "gradescope", attempts)
    finder.read_metadata(root, LIVE, lambda data: {one.stem: read_live(data)})
    items = finder.find({name: replace(one, file=name) for name in files.sizes}, [one])
    return Submissions("gradescope", items, tuple(finder.told))


def _without_reports(files: Listing) -> Listing:
    """Leave out the folders that ``gyro analyze`` wrote next to other files: their runs.csv reads as a log."""
    written = "results.json", "runs.csv"
    found = [
        one for one in files.folders if _REPORT.search(one) and all(f"{one}{name}" in files.sizes for name in written)
    ]
    others = [name for name in files.sizes if not name.startswith(tuple(found))]
    # A student may have handed in nothing else.
    left = tuple(one for one in found if any(name.startswith(one[: one[:-1].rfind("/") + 1]) for name in others))
    if not left:
        return files
    message = f"left aside, because gyro analyze wrote it: {listing([shown(one) for one in left], 5)}"
    return replace(
        files,
        sizes={name: size for name, size in files.sizes.items() if not name.startswith(left)},
        folders=tuple(folder for folder in files.folders if not folder.startswith(left)),
        diagnostics=(*files.diagnostics, Diagnostic.of(diagnostics.FILES_OF_NO_STUDENT, message, "", files.root.name)),
    )


def _nothing_found(files: Listing, lms: str, pattern: str | None) -> InputError:
    root, one, auto = files.root.name, shown(min(files.sizes, default="")), lms == "auto"
    message = f'"{root}" holds no submission as {"a platform" if auto else lms} names them; one file is: {one}'
    hint = f"name them such as {PLATFORMS['folder' if auto else lms].sample}, or give a --pattern"
    if not auto:
        hint = f"leave --lms {lms} out, or {hint}"
    if pattern is not None:
        message, hint = f'--pattern "{pattern}" fits no file of "{root}"', f"make it fit such a name: {one}"
    if not files.sizes:
        message, hint = f'"{root}" holds no files', "give the folder or zip of the class"
    return InputError.of(diagnostics.NO_SUBMISSION, message, hint, root)


# --- from files to submissions ------------------------------------------------------------------------------


class _Finder:
    """Gathers the files of each student."""

    def __init__(self, files: Listing, lms: str, attempts: Attempts) -> None:
        self.files = files
        self.lms = lms
        self.attempts: Attempts = attempts
        self.told = list(files.diagnostics)
        self.metadata: Mapping[str, Metadata] = {}

    def find(self, named: Mapping[str, ParsedName | None], empty: Sequence[ParsedName]) -> tuple[Submission, ...]:
        """Make the submissions of those who handed in files, and of those who may have handed in nothing."""
        fitting = {name: what for name, what in named.items() if what is not None}
        self._tell_left_out([name for name, what in named.items() if what is None])
        if self.lms == "blackboard":
            fitting = people_by_receipts(fitting, partial(read_file, self.files.root, most=_MOST_RECEIPT))
        export = [name for name in named.keys() - fitting.keys() if name.rpartition("/")[2] == EXPORT]
        if export and self.lms == "gradescope":
            self.read_metadata(self.files.root, min(export), read_export)
        people: dict[str, dict[str, ParsedName]] = {}
        for name, what in fitting.items():
            told = self._with_metadata(what)
            people.setdefault(told.student, {})[name] = told
        for what in map(self._with_metadata, empty):
            people.setdefault(what.student, {"": what})
        items = sorted(map(self._counted, people.values()), key=lambda item: item.student)
        # As all have on a page that is marked blind.
        counts = Counter(item.name for item in items)
        return tuple(
            replace(item, name=f"{item.name} ({item.student})") if counts[item.name] > 1 else item for item in items
        )

    def _tell(self, code: str, message: str, hint: str = "") -> None:
        self.told.append(Diagnostic.of(code, message, hint, self.files.root.name))

    def _tell_left_out(self, names: list[str]) -> None:
        names = sorted(shown(name) for name in names if name.rpartition("/")[2] not in (LIVE, EXPORT))
        if names:
            count = "1 file is" if len(names) == 1 else f"{len(names)} files are"
            message = f"{count} of no student and left aside: {listing(names, 5)}"
            hint = "change --pattern so that it fits these as well, or rename them"
            if self.lms in PLATFORMS:
                hint = f"rename them, if they count: {self.lms} names files such as {PLATFORMS[self.lms].sample}"
            self._tell(diagnostics.FILES_OF_NO_STUDENT, message, hint)

    def _counted(self, named: Mapping[str, ParsedName]) -> Submission:
        """Make the submission of one student, of the attempt that counts."""
        stamps = sorted({(what.submitted or "", what.attempt or 0) for what in named.values()})
        stamp = stamps[0 if self.attempts == "oldest" else -1]
        files = {name: what for name, what in named.items() if (what.submitted or "", what.attempt or 0) == stamp}
        made, note = _submission(self.files, files, self.attempts)
        if len(stamps) > 1:
            self._tell(
                diagnostics.ONE_OF_SEVERAL_GRADED,
                f"{made.name} has {len(stamps)} attempts; the {self.attempts} is graded",
            )
        if note:
            self._tell(diagnostics.ONE_OF_SEVERAL_GRADED, f"{made.name}: {note}")
        return replace(made, attempt=max(made.attempt, stamps.index(stamp) + 1))

    def read_metadata(self, root: Path, name: str, read: Callable[[bytes], Mapping[str, Metadata]]) -> None:
        """Read a metadata file, by the folder of each submission."""
        try:
            self.metadata = read(read_file(root, name, LARGEST))
        except (GyroError, ValueError) as error:
            hint = "names and times are not known; students are named by their submission's number"
            file = name.rpartition("/")[2]
            self._tell(diagnostics.GRADESCOPE_METADATA_CANNOT_BE_READ, f"{file} cannot be read: {error}", hint)

    def _with_metadata(self, what: ParsedName) -> ParsedName:
        """Add the time and the members of a submission to a name."""
        about = self.metadata.get(what.stem)
        if about is None:
            return what
        what = replace(what, submitted=about.submitted, attempt=about.attempt, late_seconds=about.late_seconds)
        if not about.submitters:
            return what
        people = sorted(about.submitters, key=lambda one: one.key)
        ids = {"gradescope": about.number, "sid": people[0].sid, "email": people[0].email, "folder": what.stem}
        return replace(
            what,
            student="+".join(shown(one.key) for one in people),
            name=", ".join(shown(one.name) or shown(one.key) for one in people),
            ids={kind: value for kind, value in ids.items() if value},
            members=tuple(one.key for one in people) if len(people) > 1 else (),
        )


def _submission(
    files: Listing, named: Mapping[str, ParsedName], attempts: Attempts = "newest"
) -> tuple[Submission, str | None]:
    """Make a submission of one attempt's files, "" for none; say what is to be known of which is the log."""
    first = next(iter(named.values()))
    own = {name: what.file for name, what in named.items() if what.file}
    choice = choose_files(own, files.sizes, partial(read_file, files.root), attempts)
    graded = named[choice.log] if choice.log else first
    # A receipt of the platform is a text too.
    reports = [name for name, what in named.items() if not what.file or ending(what.file) in TEXTS]
    late = first.late_seconds
    made = Submission(
        first.student,
        first.name,
        graded.ids,
        files.root,
        tuple(sorted(own)),
        choice.log,
        own[choice.log] if choice.log else None,
        tuple(sorted({*reports} - {choice.log, ""})),
        any(what.late for what in named.values()) or (late is not None and late > 0),
        None if late is None else max(0.0, late),
        first.submitted,
        first.attempt or 1,
        first.members,
        choice.problem,
        graded.stem,
    )
    return made, choice.note
