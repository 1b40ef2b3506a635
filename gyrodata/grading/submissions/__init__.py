"""Read a folder or zip of a class into `Submission`s, one for each student or group.

`list_submissions` reads only names and the metadata of the platform. `choose` opens the
files of one student, and can take any time and memory if they are made to: a class is
graded in workers, where both are limited.
"""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from msgspec.structs import replace

from gyrodata.base.errors import Diagnostic, GyroError, InputError, shown
from gyrodata.base.workers import reads_file
from gyrodata.grading.submissions import names, submission
from gyrodata.grading.submissions.archives import (
    TEXTS,
    Listing,
    ending,
    list_files,
    list_inner,
    read_file,
    sizes_of,
)
from gyrodata.grading.submissions.submission import Submission, Submissions
from gyrodata.readings import Faults, listing

__all__ = [
    "Submission",
    "Submissions",
    "choose",
    "find_submissions",
    "list_submissions",
    "submission_of",
    "unread",
]


def find_submissions(
    path: str | Path,
    lms: str = "auto",
    pattern: str | None = None,
    attempts: submission.Attempts = "newest",
) -> Submissions:
    """Find the submissions of a class as `list_submissions` does.

    The log of each submission is chosen in this process.
    """
    listed = list_submissions(path, lms, pattern, attempts)
    chosen = [choose(item) for item in listed.items]
    notes = [note for _, some in chosen for note in some]
    return replace(
        listed,
        items=tuple(item for item, _ in chosen),
        diagnostics=(*listed.diagnostics, *notes),
    )


def list_submissions(
    path: str | Path,
    lms: str = "auto",
    pattern: str | None = None,
    attempts: submission.Attempts = "newest",
) -> Submissions:
    r"""List the submissions of a class by the names of their files.

    Parameters
    ----------
    path : str or Path
        A folder with a folder or file for each student, or the folder or zip that a
        platform gives.
    lms : str
        The platform that named the files, of `names.PLATFORMS`; "auto" finds it.
    pattern : str, optional
        A regular expression for other names, such as ``(?P<student>\w+)_lab\.csv``.
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
        raise Faults("").refuse("unknown_lms", lms=lms, known=", ".join(names.NAMED))
    root = Path(path)
    about: Mapping[str, dict[str, Any]] = {}
    note = Faults(root.name).message
    running = lms == "gradescope" or (lms == "auto" and (root / names.LIVE).is_file())
    if pattern is None and running and (root / "submission").is_dir():
        # An autograder of Gradescope that runs has one submission next to its metadata.
        one = Submission(
            "submission",
            "submission",
            {},
            root / "submission",
            feedback_stem="submission",
        )
        files, seen, described = list_files(one.source), "gradescope", names.LIVE
        named: names.Named = {
            **{name: replace(one, log_file=name) for name in files.names},
            "submission/": one,
        }
    else:
        files = _without_reports(list_files(root))
        seen, named = names.name_all(files, lms, pattern)
        exports = [
            name
            for name, part in named.items()
            if not part and name.endswith(names.EXPORT)
        ]
        described = min(exports, default="") if seen == "gradescope" else ""
    notes = list(files.diagnostics)
    if described:
        try:
            data = read_file(root, described, names.LARGEST)
            about = (
                names.read_live(data)
                if described == names.LIVE
                else names.read_export(data)
            )
        except (GyroError, ValueError) as error:
            notes.append(
                note(
                    "metadata_unreadable", name=described.rpartition("/")[2], why=error
                )
            )
    no_files = (
        names.LIVE,
        names.EXPORT,
        "/",
        *(["index.html"] if seen == "brightspace" else []),
    )
    if left := sorted(
        shown(name)
        for name, part in named.items()
        if not part and not name.endswith(no_files)
    ):
        count = "1 file is" if len(left) == 1 else f"{len(left)} files are"
        hint = "change --pattern so that it fits these as well, or rename them"
        if seen in names.PLATFORMS:
            hint = (
                f"rename them, if they count: {seen} names files such as "
                f"{names.PLATFORMS[seen].sample}"
            )
        notes.append(
            note("files_of_no_student", count=count, names=listing(left, 5), hint=hint)
        )
    people: dict[str, dict[str, Submission]] = {}
    for name, part in named.items():
        if part is not None:
            part = replace(part, **about.get(part.feedback_stem, {}))
            people.setdefault(part.student, {})[name] = part
    items = []
    for student in sorted(people):
        parts = people[student]
        stamps = sorted(
            {part.submitted or "" for name, part in parts.items() if name[-1] != "/"}
        )
        stamp = (stamps or [""])[0 if attempts == "oldest" else -1]
        parts = {
            name: part
            for name, part in parts.items()
            if (part.submitted or "") == stamp
        } or parts
        made = _joined(files.root, parts, attempts)
        if len(stamps) > 1:
            notes.append(
                note(
                    "newest_of_attempts",
                    name=made.name,
                    count=len(stamps),
                    which=attempts,
                )
            )
        items.append(made)
    if not items:
        message = "pattern_fits_nothing" if pattern is not None else "no_submission"
        by, known = ("a platform", "folder") if lms == "auto" else (lms, lms)
        first, sample = (
            shown(next(iter(files.names), "")),
            names.PLATFORMS[known].sample,
        )
        values = {
            "root": root.name,
            "one": first,
            "pattern": pattern,
            "lms": by,
            "sample": sample,
        }
        raise Faults(root.name).refuse(
            message if files.names else "class_empty", **values
        )
    # Students may share a name; in anonymous submissions all do.
    counts = Counter(item.name for item in items)
    items = [
        replace(one, name=f"{one.name} ({one.student})")
        if counts[one.name] > 1
        else one
        for one in items
    ]
    return Submissions(seen, tuple(items), tuple(notes))


def submission_of(paths: Sequence[Path]) -> tuple[Submission, tuple[Diagnostic, ...]]:
    """Read files, or one folder or zip, as the submission of one student.

    Also return notes on files left out.
    """
    first = paths[0]
    if any(path.is_dir() or path.suffix.lower() == ".zip" for path in paths):
        if len(paths) > 1:
            raise Faults("").refuse("not_all_files", count=len(paths))
        files = _without_reports(list_files(first))
        own = {name: shown(name) for name in files.names}
    else:
        for path in paths:
            if not path.is_file():
                raise Faults("").refuse(
                    "file_not_found",
                    path=str(path),
                    hint="check its name and its folder",
                )
        # An absolute name is found below any folder.
        own = {str(path.resolve()): shown(path.name) for path in paths}
        files = Listing(Path.cwd(), tuple(own))
    one = Submission(first.name, first.name, {}, files.root, feedback_stem=first.stem)
    parts = {"/": one} | {
        name: replace(one, log_file=file) for name, file in own.items()
    }
    made, choice = _choose(_joined(files.root, parts, "newest"))
    notes = [Faults("").message("one_of_logs", choice=choice)] if choice else []
    return made, (*files.diagnostics, *notes)


def _without_reports(files: Listing) -> Listing:
    """Leave out the folders that ``gyro analyze`` wrote: their runs.csv reads as a log."""
    reports = tuple(
        one
        for one in files.folders
        if {f"{one}results.json", f"{one}runs.csv"} <= {*files.names}
    )
    if not reports:
        return files
    note = Faults(files.root.name).message(
        "report_left_aside", names=listing([shown(one) for one in reports], 5)
    )
    left = tuple(name for name in files.names if not name.startswith(reports))
    folders = tuple(one for one in files.folders if not one.startswith(reports))
    return Listing(files.root, left, folders, (*files.diagnostics, note))


def _joined(
    root: Path, parts: Mapping[str, Submission], attempts: submission.Attempts
) -> Submission:
    """Join the files of one attempt into a submission of which no file is opened yet."""
    first = next(iter(parts.values()))
    late = any(part.late for part in parts.values()) or (first.late_seconds or 0.0) > 0
    seconds = None if first.late_seconds is None else max(0.0, first.late_seconds)
    made = replace(first, source=root, log_file=None, late=late, late_seconds=seconds)
    return replace(made, parts=parts, attempts=attempts)


def choose(item: Submission) -> tuple[Submission, list[Diagnostic]]:
    """Open the files of a listed submission and choose the log among them.

    Also return a note on the choice.

    A log that is given already, such as one that a person corrected, is kept.
    """
    made, choice = _choose(item)
    note = Faults(item.source.name).message
    return made, [
        note("one_of_logs", choice=f"{made.name}: {choice}")
    ] if choice else []


def _choose(item: Submission) -> tuple[Submission, str]:
    """Do the work of `choose`; the note is a text, or ""."""
    if not item.parts:
        return item, ""
    root, parts = item.source, item.parts
    own = {name: part.log_file for name, part in parts.items() if part.log_file}
    damaged = ""
    for name, file in list(own.items()):
        if ending(file) == ".zip":
            reads_file(submission.place_of(name))
            try:
                inner = list_inner(root, name)
                own |= {
                    whole: f"{file}/{whole[len(name) + 2 :].replace('//', '/')}"
                    for whole in inner
                }
            except InputError as error:
                damaged = error.diagnostics[0].message
    log, words = submission.choose_log(own, partial(read_file, root), item.attempts)
    named = parts[log.partition("//")[0] if log else next(iter(parts))]
    # A receipt of the platform is a text without a name that the student gave.
    texts = {
        name
        for name in {**parts, **own}
        if name[-1] != "/" and ending(own.get(name, "a.txt")) in TEXTS
    }
    problem = None
    if not log:
        problem = f"{words}; {damaged}" if damaged else words
    made = replace(
        item,
        ids=named.ids,
        feedback_stem=named.feedback_stem,
        parts={},
        problem=problem,
    )
    made = replace(
        made, members=tuple(sorted(own)), report_names=tuple(sorted(texts - {log}))
    )
    if item.log_name is not None:
        return replace(made, problem=None), ""
    return replace(
        made, log_name=log, log_file=own[log] if log else None
    ), words if log else ""


def unread(item: Submission, why: str) -> Submission:
    """Return a listed submission whose files cannot be opened, with the reason."""
    members = tuple(sorted(name for name, part in item.parts.items() if part.log_file))
    # Another file of the same name usually has another size.
    about = repr(sizes_of(item.source, members))
    digest = hashlib.sha256(about.encode("utf-8", "replace")).hexdigest()
    return replace(item, parts={}, members=members, problem=why, known_digest=digest)
