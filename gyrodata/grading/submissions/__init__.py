"""Read a folder or zip of a class into `Submission`s, one for each student or group.

Only names and metadata are read here. A log is read when it is graded, directly from its place.
"""

from __future__ import annotations

import hashlib
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property, partial
from pathlib import Path, PurePosixPath
from typing import Any

from msgspec import Struct
from msgspec.structs import replace

from gyrodata import diagnostics
from gyrodata.errors import Diagnostic, GyroError, InputError, shown
from gyrodata.grading.platforms import NAMED, PLATFORMS
from gyrodata.grading.submissions import metadata, student_files
from gyrodata.grading.submissions.archives import Listing, list_files, read_file
from gyrodata.grading.submissions.names import ParsedName, name_all, people_by_receipts
from gyrodata.readings import MAX_BYTES, Readings, listing, read_log

_REPORT = re.compile(r"-report(?:-\d+)?/$")  # name of a folder that ``gyro analyze`` writes
_MOST_RECEIPT = 200_000
_MOST_REPORT = 1_000_000


class Submission(Struct, frozen=True, dict=True):
    """The submission of one student or group."""

    # key, unique in the class and the same in each download: the number on the platform, else the name of the folder
    # or file
    student: str
    name: str  # to be shown
    # ids on platforms: ``canvas``, ``moodle``, ``username``, ``sid``, ``email``, ``gradescope`` (the number of the
    # submission), ``folder``
    ids: Mapping[str, str]
    source: Path  # folder or zip of the class
    members: tuple[str, ...] = ()  # all files, as names below `source`
    log_name: str | None = None  # the log, as a name below `source`
    log_file: str | None = None  # the name that the student gave the log
    report_names: tuple[str, ...] = ()  # other texts that may contain the answer, as names below `source`
    late: bool = False  # marked late by the platform, or submitted after its due date
    late_seconds: float | None = None  # time after the due date [s], 0 before it; None if it is not known
    submitted: str | None = None  # ISO 8601; from marks and metadata, never from the clock
    attempt: int = 1  # 1 for the first
    members_of_group: tuple[str, ...] = ()  # keys of all in the group, if the platform gives them
    problem: str | None = None  # why there is nothing to grade; None if there is a log
    feedback_stem: str = ""  # file (without ending) or folder under which the platform accepts feedback

    @cached_property
    def texts(self) -> Mapping[str, bytes | InputError]:
        """The log and the other texts, or why they cannot be read; each is read once."""
        most = dict.fromkeys(self.report_names, _MOST_REPORT) | ({self.log_name: MAX_BYTES} if self.log_name else {})
        found: dict[str, bytes | InputError] = {}
        for name, size in most.items():
            try:
                found[name] = read_file(self.source, name, size)
            except InputError as error:
                found[name] = error
        return found

    def log(self) -> bytes:
        """Return the log; raise InputError if it cannot be read."""
        if self.log_name is None:
            raise InputError.of(diagnostics.NO_SUBMISSION, f"{self.name}: {self.problem}")
        if isinstance(data := self.texts[self.log_name], InputError):
            raise data
        return data

    def reports(self) -> Iterator[tuple[str, bytes]]:
        """Give the other texts that may contain the answer, with names to show."""
        texts = ((shown(name.rpartition("/")[2]), self.texts[name]) for name in self.report_names)
        return ((name, data) for name, data in texts if isinstance(data, bytes))

    def read(self, settings: Mapping[str, str] = {}) -> tuple[Readings, student_files.Answers]:
        """Read the log and the reported value; `settings` as in `read_log`."""
        name = PurePosixPath(self.log_file or self.log_name or "").name
        readings = read_log(self.log(), name=name, settings=settings)
        answers = student_files.read_answers(readings, self.reports())
        unread = [one for data in self.texts.values() if isinstance(data, InputError) for one in data.diagnostics]
        return readings, replace(answers, diagnostics=(*answers.diagnostics, *unread))

    def feedback_name(self, ending: str) -> str:
        """Name a feedback file with this ending, such as ``.html``, in the zip that the platform accepts."""
        in_folder = self.ids.get("folder") == shown(self.feedback_stem)
        return f"{self.feedback_stem}/feedback{ending}" if in_folder else f"{self.feedback_stem}{ending}"

    @cached_property
    def digest(self) -> str:
        """SHA-256 of all that a grade depends on: names and bytes of log and texts, lateness, the problem."""
        about = [self.log_file, self.late, self.late_seconds, self.submitted, self.problem]
        digest = hashlib.sha256(repr(about).encode("utf-8", "replace"))
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

    lms: str  # the platform: ``canvas``, ``moodle``, ``blackboard``, ``gradescope``, ``folder``; or ``pattern``
    items: tuple[Submission, ...]  # sorted by `Submission.student`
    diagnostics: tuple[Diagnostic, ...] = ()  # files that are left out or cannot be read


def find_submissions(
    path: str | Path, lms: str = "auto", pattern: str | None = None, attempts: student_files.Attempts = "newest"
) -> Submissions:
    r"""Find the submissions of a class.

    Parameters
    ----------
    path : str or Path
        A folder with a folder or file for each student, or the folder or zip that a platform gives.
    lms : str
        The platform that named the files, of `PLATFORMS`; "auto" finds it.
    pattern : str, optional
        A regular expression for other names, such as ``(?P<student>\w+)_lab\.csv``.
    attempts : {"newest", "oldest"}
        Which of several attempts is graded.

    Returns
    -------
    Submissions
        One for each student or group.

    Raises
    ------
    InputError
        If the class cannot be read, or contains no submission.
    """
    if lms != "auto" and lms not in PLATFORMS:
        hint = f"write one of: auto, folder, {', '.join(NAMED)}"
        raise InputError.of(diagnostics.NO_SUBMISSION, f'there is no --lms "{lms}"', hint)
    root, notes = Path(path), list[Diagnostic]()
    about: Mapping[str, dict[str, Any]] = {}

    def note(code: str, message: str, hint: str = "") -> None:
        notes.append(Diagnostic.of(code, message, hint, root.name))

    running = lms == "gradescope" or (lms == "auto" and (root / metadata.LIVE).is_file())
    if pattern is None and running and (root / "submission").is_dir():
        # An autograder of Gradescope that runs has one submission next to its metadata.
        one = ParsedName("submission", "submission", {}, "", "submission")
        files, seen, empty, described = list_files(root / one.stem), "gradescope", [one], metadata.LIVE
        named: dict[str, ParsedName | None] = {name: replace(one, file=name) for name in files.sizes}
    else:
        files = _without_reports(list_files(root))
        seen, named, empty = name_all(files, lms, pattern, root.is_file())
        exports = [name for name, what in named.items() if not what and name.endswith(metadata.EXPORT)]
        described = min(exports, default="") if seen == "gradescope" else ""
    notes += files.diagnostics
    if described:
        try:
            data = read_file(root, described, metadata.LARGEST)
            live = described == metadata.LIVE
            about = {"submission": metadata.read_live(data, "submission")} if live else metadata.read_export(data)
        except (GyroError, ValueError) as error:
            hint = "names and times are not known; students are named by their submission's number"
            message = f"{described.rpartition('/')[2]} cannot be read: {error}"
            note(diagnostics.GRADESCOPE_METADATA_CANNOT_BE_READ, message, hint)
    about_class = (metadata.LIVE, metadata.EXPORT)
    if left := sorted(shown(name) for name, what in named.items() if not what and not name.endswith(about_class)):
        count = "1 file is" if len(left) == 1 else f"{len(left)} files are"
        hint = "change --pattern so that it fits these as well, or rename them"
        if seen in PLATFORMS:
            hint = f"rename them, if they count: {seen} names files such as {PLATFORMS[seen].sample}"
        message = f"{count} of no student and left aside: {listing(left, 5)}"
        note(diagnostics.FILES_OF_NO_STUDENT, message, hint)
    fitting = {name: what for name, what in named.items() if what is not None}
    if seen == "blackboard":
        fitting = people_by_receipts(fitting, partial(read_file, root, most=_MOST_RECEIPT))
    people: dict[str, dict[str, ParsedName]] = {}
    for name, what in (*fitting.items(), *(("", one) for one in empty)):
        what = replace(what, **about.get(what.stem, {}))
        if name or what.student not in people:
            people.setdefault(what.student, {})[name] = what
    items = []
    for student in sorted(people):
        stamps = sorted({(what.submitted or "", what.attempt or 0) for what in people[student].values()})
        stamp = stamps[0 if attempts == "oldest" else -1]
        attempt = {
            name: what for name, what in people[student].items() if (what.submitted or "", what.attempt or 0) == stamp
        }
        made, choice = _submission(files, attempt, attempts)
        if len(stamps) > 1:
            message = f"{made.name} has {len(stamps)} attempts; the {attempts} is graded"
            note(diagnostics.ONE_OF_SEVERAL_GRADED, message)
        if choice:
            note(diagnostics.ONE_OF_SEVERAL_GRADED, f"{made.name}: {choice}")
        items.append(replace(made, attempt=max(made.attempt, stamps.index(stamp) + 1)))
    if not items:
        raise _nothing_found(files, lms, pattern)
    # Students may share a name; in anonymous submissions all do.
    counts = Counter(item.name for item in items)
    items = [replace(one, name=f"{one.name} ({one.student})") if counts[one.name] > 1 else one for one in items]
    return Submissions(seen, tuple(items), tuple(notes))


def submission_of(paths: Sequence[Path]) -> tuple[Submission, tuple[Diagnostic, ...]]:
    """Read files, or one folder or zip, as the submission of one student; also return notes on files left out."""
    first = paths[0]
    if any(path.is_dir() or path.suffix.lower() == ".zip" for path in paths):
        if len(paths) > 1:
            hint = "give the files that are handed in together, or the one folder or zip that they are in"
            message = f"{len(paths)} are given, and not all of them are files"
            raise InputError.of(diagnostics.NO_SUBMISSION, message, hint)
        files = _without_reports(list_files(first))
        own = {name: shown(name) for name in files.sizes}
    else:
        for path in paths:
            if not path.is_file():
                message = f"there is no file {str(path)!r}"
                raise InputError.of(diagnostics.FILE_NOT_FOUND, message, "check its name and its folder")
        # An absolute name is found below any folder.
        own = {str(path.resolve()): shown(path.name) for path in paths}
        files = Listing(Path.cwd(), {name: Path(name).stat().st_size for name in own})
    one = ParsedName(first.name, first.name, {}, "", first.stem)
    made, choice = _submission(files, {"": one} | {name: replace(one, file=file) for name, file in own.items()})
    notes = [Diagnostic.of(diagnostics.ONE_OF_SEVERAL_GRADED, choice)] if choice else []
    return made, (*files.diagnostics, *notes)


def _without_reports(files: Listing) -> Listing:
    """Leave out the folders that ``gyro analyze`` wrote next to other files: their runs.csv reads as a log."""
    written = "results.json", "runs.csv"
    found = tuple(
        one for one in files.folders if _REPORT.search(one) and all(f"{one}{name}" in files.sizes for name in written)
    )
    others = [name for name in files.sizes if not name.startswith(found)]
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


def _submission(
    files: Listing, named: Mapping[str, ParsedName], attempts: student_files.Attempts = "newest"
) -> tuple[Submission, str]:
    """Make a submission of the files of one attempt, "" for no file; also return a note on the choice of the log."""
    first = next(iter(named.values()))
    own = {name: what.file for name, what in named.items() if what.file}
    log, words = student_files.choose_log(own, files.sizes, partial(read_file, files.root), attempts)
    graded = named[log] if log else first
    # A receipt of the platform is a text too.
    reports = {
        name for name, what in named.items() if not what.file or student_files.ending(what.file) in student_files.TEXTS
    }
    made = Submission(
        student=first.student,
        name=first.name,
        ids=graded.ids,
        source=files.root,
        members=tuple(sorted(own)),
        log_name=log,
        log_file=own[log] if log else None,
        report_names=tuple(sorted(reports - {log, ""})),
        late=any(what.late for what in named.values()) or (first.late_seconds or 0.0) > 0,
        late_seconds=None if first.late_seconds is None else max(0.0, first.late_seconds),
        submitted=first.submitted,
        attempt=first.attempt or 1,
        members_of_group=first.members,
        problem=None if log else words,
        feedback_stem=graded.stem,
    )
    return made, words if log else ""
