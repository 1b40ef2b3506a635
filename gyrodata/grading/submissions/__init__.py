"""Read a folder or zip of a class into `Submission`s, one for each student or group.

`list_submissions` reads only names and the metadata of the platform. `choose` opens the
files of one student, and can take any time and memory if they are made to: a class is
graded in workers, where both are limited.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Collection, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from msgspec.structs import replace

from gyrodata.base.errors import Diagnostic, GyroError, InputError, shown
from gyrodata.base.workers import reads_file
from gyrodata.grading.submissions import names
from gyrodata.grading.submissions.archives import (
    SHEETS,
    TEXTS,
    Listing,
    ending,
    list_files,
    list_inner,
    place_of,
    read_file,
)
from gyrodata.grading.submissions.log_choice import Attempts, choose_log
from gyrodata.grading.submissions.submission import Submission, Submissions
from gyrodata.readings import listing
from gyrodata.readings.names import squeezed_words

__all__ = [
    "Submission",
    "Submissions",
    "choose",
    "list_submissions",
    "submission_of",
    "unread",
]


def list_submissions(
    path: str | Path,
    lms: str = "auto",
    attempts: Attempts = "newest",
) -> Submissions:
    """List the submissions of a class by the names of their files.

    Parameters
    ----------
    path : str or Path
        A folder with a folder or file for each student, or the folder or zip that a
        platform gives.
    lms : str
        The platform that named the files, of `names.PLATFORMS`; "auto" finds it.
    attempts : {"newest", "oldest"}
        Which of several attempts is graded.

    Returns
    -------
    Submissions
        One for each student or group, with its files; `choose` finds the log among
        them.

    Raises
    ------
    InputError
        If the class cannot be read, or contains no submission.
    """
    if lms != "auto" and lms not in names.PLATFORMS:
        raise InputError.named("unknown_lms", lms=lms, known=", ".join(names.NAMED))
    root = Path(path)
    files = _without_reports(list_files(root))
    platform, owners = names.name_all(files, lms)
    of_nobody = [name for name, owner in owners.items() if owner is None]
    about, notes = _read_metadata(root, platform, of_nobody)
    notes = [*files.diagnostics, *notes]
    notes += _files_of_no_student(root, platform, of_nobody)
    items = []
    for parts in _by_student(owners, about):
        item, attempts_made = _join_attempt(files.root, parts, attempts)
        items += _members_of_group(item) if platform == "folder" else [item]
        if attempts_made > 1:
            values = {"name": item.name, "count": attempts_made, "which": attempts}
            notes.append(Diagnostic.named("newest_of_attempts", root.name, **values))
    if not items:
        raise _no_submission(root, files, lms)
    return Submissions(platform, _with_different_names(items), tuple(notes))


def _read_metadata(
    root: Path, platform: str, of_nobody: Sequence[str]
) -> tuple[Mapping[str, dict[str, Any]], list[Diagnostic]]:
    """Return what Gradescope says about each submission, by its `feedback_stem`."""
    # A student may hand in a file with this name.
    exports = [name for name in of_nobody if name.endswith(names.EXPORT)]
    if platform != "gradescope" or not exports:
        return {}, []
    export = min(exports)
    try:
        return names.read_export(read_file(root, export, names.LARGEST)), []
    except (GyroError, ValueError) as error:
        name = export.rpartition("/")[2]
        note = Diagnostic.named("metadata_unreadable", root.name, name=name, why=error)
        return {}, [note]


def _files_of_no_student(
    root: Path, platform: str, of_nobody: Sequence[str]
) -> list[Diagnostic]:
    """Name the files whose names say no student."""
    expected = (names.EXPORT, "/", "index.html")
    left = [shown(name) for name in of_nobody if not name.endswith(expected)]
    if not left:
        return []
    values = {
        "count": "1 file is" if len(left) == 1 else f"{len(left)} files are",
        "names": listing(sorted(left), 5),
        "lms": platform,
        "sample": names.PLATFORMS[platform].sample,
    }
    return [Diagnostic.named("files_of_no_student", root.name, **values)]


def _by_student(
    owners: names.Named, about: Mapping[str, dict[str, Any]]
) -> list[dict[str, Submission]]:
    """Return the files of each student, with the metadata of the platform."""
    people: dict[str, dict[str, Submission]] = {}
    for name, owner in owners.items():
        if owner is not None:
            described = replace(owner, **about.get(owner.feedback_stem, {}))
            people.setdefault(described.student, {})[name] = described
    return [people[student] for student in sorted(people)]


def _join_attempt(
    root: Path, parts: Mapping[str, Submission], attempts: Attempts
) -> tuple[Submission, int]:
    """Join the files of one attempt; also return the number of attempts."""
    stamps = {name: part.submitted or "" for name, part in parts.items()}
    different = {stamps[name] for name in parts if name[-1] != "/"} or {""}
    stamp = min(different) if attempts == "oldest" else max(different)
    of_attempt = {name: parts[name] for name in parts if stamps[name] == stamp}
    return _joined(root, of_attempt or parts, attempts), len(different)


_JOINING = r"[+&]|(?<=[\s_])and(?=[\s_])"


def _names_in(name: str) -> list[str]:
    """Split the name of a folder: "ann+bob", "ann and bob"."""
    names = [part.strip("_ \t") for part in re.split(_JOINING, name)]
    return list(filter(None, names))


def _members_of_group(item: Submission) -> list[Submission]:
    """Split a folder such as "ann+bob" that has a report of each and one log.

    Each member has the own report, and all files that are of no single member. Any other
    folder is one submission.
    """
    members = _names_in(item.student)
    files = {name: part.log_file for name, part in item.parts.items() if part.log_file}
    logs = {name for name, file in files.items() if ending(file) in SHEETS}
    own = {member: _files_of(member, members, files) for member in members}
    if len(members) < 2 or len(logs) != 1 or not all(own.values()):
        return [item]
    shared = (files.keys() - set().union(*own.values())) | logs
    return [_member(item, member, some | shared) for member, some in own.items()]


def _files_of(
    member: str, members: Sequence[str], files: Mapping[str, str]
) -> set[str]:
    """Return the files whose names contain the name of one member of a group alone."""
    of_member = set()
    for name, file in files.items():
        words = squeezed_words(file)
        named = [student for student in members if squeezed_words(student) <= words]
        if named == [member]:
            of_member.add(name)
    return of_member


def _member(group: Submission, name: str, files: Collection[str]) -> Submission:
    """Return the submission of a member of a group, with some of its files."""
    key = f"{group.student}/{name}"
    ids = {"folder": key, "username": name}
    parts = {file: group.parts[file] for file in sorted(files)}
    member = replace(group, student=key, name=name, ids=ids, feedback_stem=key)
    return replace(member, log_of=group.student, shares_answer=True, parts=parts)


def _no_submission(root: Path, files: Listing, lms: str) -> GyroError:
    """Return the error of a class without a submission."""
    if not files.names:
        return InputError.named("class_empty", root.name, root=root.name)
    named_by, platform = lms, lms
    if lms == "auto":
        named_by, platform = "a platform", "folder"
    sample = names.PLATFORMS[platform].sample
    values = {"root": root.name, "lms": named_by, "sample": sample}
    first = shown(files.names[0])
    return InputError.named("no_submission", root.name, one=first, **values)


def _with_different_names(items: list[Submission]) -> tuple[Submission, ...]:
    """Add the key of a student to a name that several have.

    In anonymous submissions, all have the same name.
    """
    named = names.different({item.student: item.name for item in items})
    return tuple(replace(item, name=named[item.student]) for item in items)


def submission_of(
    paths: Sequence[Path], about: Mapping[str, Any] = {}
) -> tuple[Submission, tuple[Diagnostic, ...]]:
    """Read files, or one folder or zip, as the submission of one student.

    Also return notes on files left out. `about`: What a platform says about it.
    """
    files, own = _files_handed_in(paths)
    first = paths[0]
    submission = Submission(
        first.name, first.name, {}, files.root, feedback_stem=first.stem
    )
    submission = replace(submission, **about)
    parts = {"/": submission}
    for name, file in own.items():
        parts[name] = replace(submission, log_file=file)
    made, choice = choose(_joined(files.root, parts, "newest"))
    notes = []
    if choice:
        notes.append(Diagnostic.named("one_of_logs", choice=choice))
    return made, (*files.diagnostics, *notes)


def _files_handed_in(paths: Sequence[Path]) -> tuple[Listing, dict[str, str]]:
    """List files, or those of one folder or zip, with the names to be shown."""
    is_whole = [path.is_dir() or path.suffix.lower() == ".zip" for path in paths]
    if any(is_whole) and len(paths) > 1:
        raise InputError.named("not_all_files", count=len(paths))
    for path in paths:
        if not path.exists():
            hint = "check its name and its folder"
            raise InputError.named("file_not_found", path=str(path), hint=hint)
    if is_whole[0]:
        files = _without_reports(list_files(paths[0]))
        return files, {name: shown(name) for name in files.names}
    # An absolute name is found below any folder.
    own = {str(path.resolve()): shown(path.name) for path in paths}
    return Listing(Path.cwd(), tuple(own)), own


def _without_reports(files: Listing) -> Listing:
    """Leave out folders of ``gyro analyze``: their runs.csv reads as a log."""
    known = {*files.names}
    reports = tuple(
        folder
        for folder in files.folders
        if {f"{folder}results.json", f"{folder}runs.csv"} <= known
    )
    if not reports:
        return files
    listed = listing([shown(report) for report in reports], 5)
    note = Diagnostic.named("report_left_aside", files.root.name, names=listed)
    left = tuple(name for name in files.names if not name.startswith(reports))
    folders = tuple(name for name in files.folders if not name.startswith(reports))
    return Listing(files.root, left, folders, (*files.diagnostics, note))


def _joined(
    root: Path, parts: Mapping[str, Submission], attempts: Attempts
) -> Submission:
    """Join the files of one attempt into a submission, and open none."""
    first = next(iter(parts.values()))
    is_marked = any(part.late for part in parts.values())
    late = is_marked or (first.late_seconds or 0.0) > 0
    seconds = first.late_seconds
    if seconds is not None:
        seconds = max(0.0, seconds)
    made = replace(first, source=root, log_file=None, late=late, late_seconds=seconds)
    return replace(made, parts=parts, attempts=attempts)


def choose(item: Submission) -> tuple[Submission, str]:
    """Open the files of a listed submission and choose the log among them.

    Also return how it was chosen among several files, as in `Choice.why`, or "". A log
    that is given already, such as one that a person corrected, is kept. Without a log,
    the submission has a `problem`, such as "no log: only report.pdf".
    """
    if not item.parts:
        return item, ""
    own, damage = _with_inner_files(item)
    name, note = choose_log(own, partial(read_file, item.source), item.attempts)
    # What the platform says about the file of the log is true for the submission.
    outer = name.partition("//")[0] or next(iter(item.parts))
    named = item.parts[outer]
    texts = _texts(item.parts, own, name)
    made = replace(item, ids=named.ids, feedback_stem=named.feedback_stem)
    members = tuple(sorted(own))
    made = replace(made, members=members, report_names=texts, parts={}, problem=None)
    if item.log_name is not None:
        return made, ""
    if name:
        return replace(made, log_name=name, log_file=own[name]), note
    return replace(made, problem=f"{note}; {damage}" if damage else note), ""


def _with_inner_files(item: Submission) -> tuple[dict[str, str], str]:
    """Return the files of a submission and those in its archives.

    Also return why an archive cannot be opened, or "".
    """
    own = {name: part.log_file for name, part in item.parts.items() if part.log_file}
    damage = ""
    for name, file in list(own.items()):
        if ending(file) != ".zip":
            continue
        reads_file(place_of(name))
        try:
            for whole in list_inner(item.source, name):
                inner = whole[len(name) + 2 :].replace("//", "/")
                own[whole] = f"{file}/{inner}"
        except InputError as error:
            damage = error.diagnostics[0].message
    return own, damage


def _texts(
    parts: Mapping[str, Submission], own: Mapping[str, str], log: str
) -> tuple[str, ...]:
    """Return the texts that may contain the answer.

    A receipt of the platform is a text without a name that the student gave.
    """
    texts = []
    for name in sorted({*parts, *own} - {log}):
        kind = ending(own.get(name, "a.txt"))
        if name[-1] != "/" and kind in TEXTS:
            texts.append(name)
    return tuple(texts)


def unread(item: Submission, why: str) -> Submission:
    """Return a listed submission whose files cannot be opened, with the reason."""
    members = tuple(sorted(name for name, part in item.parts.items() if part.log_file))
    digest = hashlib.sha256(repr(members).encode("utf-8", "replace")).hexdigest()
    item = replace(item, problem=why, lost=why)
    return replace(item, parts={}, members=members, known_digest=digest)
