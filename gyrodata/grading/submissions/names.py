"""Find the student of each file of a class.

The names that platforms give and their metadata determine the student.

`platforms.toml` describes how the platforms name files; a folder for each student
needs no such name. Gradescope adds metadata with submitters and times: a running
autograder finds JSON; an export contains YAML written by Ruby, with symbols for keys
and many megabytes of results and histories, of which only the lines with submitters and
times are parsed.

Formats of names. Canvas: lib/content_zipper.rb, lib/gradebook_importer.rb and
lib/gradebook_exporter.rb of instructure/canvas-lms. Moodle:
mod/assign/classes/downloader.php, feedback/file/importziplib.php,
feedback/offline/importgradeslib.php and locallib.php of moodle/moodle. Blackboard and
Gradescope do not publish their source: these names are from downloads. Formats of
metadata: gradescope-autograders.readthedocs.io, and exports as public tools read them
(``[':submitters'][0][':sid']``).
"""

from __future__ import annotations

import base64
import re
import unicodedata
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from datetime import datetime
from importlib.resources import files as package_files
from os.path import commonprefix
from pathlib import Path
from typing import Any, Literal

import msgspec
from msgspec import Struct
from msgspec.structs import replace

from gyrodata.base.errors import printable, shown
from gyrodata.grading.submissions.archives import LOGS, Listing, ending
from gyrodata.grading.submissions.submission import Submission

# of a running autograder, and of an export
LIVE, EXPORT = "submission_metadata.json", "submission_metadata.yml"
LARGEST = 100_000_000  # bytes of a metadata file that are read


class Platform(Struct, frozen=True):
    """How one platform names the files of a class."""

    sample: str  # name of one file, for messages
    names: tuple[str, ...] = ()  # regular expressions of a whole name

    def match(self, name: str) -> re.Match[str] | None:
        """Match the name of a file below the class.

        None if the platform does not write such names.
        """
        for pattern in self.names:
            match = re.fullmatch(pattern, name, re.DOTALL)
            if match is not None:
                return match
        return None


_TEXT = package_files("gyrodata.grading").joinpath("platforms.toml").read_bytes()
PLATFORMS = msgspec.toml.decode(_TEXT, type=dict[str, Platform])
"""All platforms by name; "folder" has no names of its own."""

NAMED = tuple(name for name, platform in PLATFORMS.items() if platform.names)
"""The platforms that are known by their names."""

Named = dict[str, Submission | None]
"""By the name of each file, what it says of the submission; None for a file of no
student."""

_IDS = (
    "moodle",
    "canvas",
    "canvas_anonymous",
    "username",
    "brightspace",
    "gradescope",
    "email",
)

_GROUPS = (*_IDS, "student", "name", "stem", "late", "stamp", "file", "beside")
"""What a name may say; a pattern of a platform has some of these groups. `beside` is a file
that the platform adds to the folder of a student, such as its time; it is not read."""

_NO_SUBMISSION = (
    ".md",
    ".json",
    ".ndjson",
    ".html",
    ".py",
    ".yml",
    ".yaml",
    ".ini",
    ".sh",
)
"""Endings of files in a flat folder that are not submissions."""


def name_all(files: Listing, lms: str) -> tuple[str, Named]:
    """Find out which platform named the files, and read each name.

    "doejane_9876_5432_lab.csv" gives "canvas", and by this name a submission of the
    student "9876", called "doejane", with the file "lab.csv". `lms` is a platform or
    "auto". The names that are returned include folders in which a student has no file.
    """
    outer = _only_folder(files)
    if lms == "folder":
        return "folder", _name_by_folders(files, outer)
    for below in dict.fromkeys(("", outer)):
        inner = {name: name.removeprefix(below) for name in files.names}
        platform: str | None = lms
        if lms == "auto":
            platform = _platform_of([*inner.values()])
        if platform is None:
            continue
        named = _read_names(PLATFORMS[platform], inner, files.root)
        if lms == "auto" or any(named.values()):
            return platform, _with_user_names(platform, named)
    if lms in NAMED:
        return lms, dict.fromkeys(files.names)
    return "folder", _name_by_folders(files, outer)


def _read_names(platform: Platform, inner: Mapping[str, str], root: Path) -> Named:
    """Read the name of each file as a platform writes it.

    `inner`: The names without the folder of the class, by the whole names.
    """
    named: Named = {}
    for name, rest in inner.items():
        match = platform.match(rest)
        part = None
        if match:
            part = _take_apart(match, root)
            # What the platform adds only shows that the student has a folder.
            name = name.removesuffix(match.groupdict("").get("beside", ""))
        named[name] = part
    return named


def _only_folder(files: Listing) -> str:
    """Return the folder that contains all files, with a ``/`` at its end, or ""."""
    paths = (*files.names, *files.folders)
    firsts = {name.partition("/")[0] for name in paths}
    are_below = all("/" in name for name in files.names)
    if len(firsts) != 1 or not are_below:
        return ""
    return f"{firsts.pop()}/"


def _platform_of(names: Sequence[str]) -> str | None:
    """Return the platform that wrote at least half of the known names.

    An export of Gradescope is known by its metadata.
    """
    if EXPORT in names:
        return "gradescope"
    counts = dict.fromkeys(NAMED, 0)
    for name in names:
        known = (platform for platform in NAMED if PLATFORMS[platform].match(name))
        platform = next(known, None)
        if platform is not None:
            counts[platform] += 1
    most = max(NAMED, key=counts.__getitem__)
    least = max(len(names), 1) / 2
    return most if counts[most] >= least else None


def _name_by_folders(files: Listing, outer: str) -> Named:
    """Name a class with a folder for each student, or with a file for each.

    `outer` is the only folder, or "". It is that of the class if it contains logs of
    several students, else that of its only student.
    """
    below = outer if _contains_several_students(files, outer) else ""
    inner = {name: name.removeprefix(below) for name in files.names}
    folders = _folders_below(files, below)
    logs = [own for own in inner.values() if ending(own) in LOGS]
    all_names = [*inner.values(), *folders.values()]
    in_folders = any("/" in own for own in logs or all_names)
    if in_folders:
        inner |= {name: own for name, own in folders.items() if own.count("/") == 1}
    students = _students_of_folders(inner.values())
    return {
        name: _of_folder(own, in_folders, files.root, students)
        for name, own in inner.items()
    }


def _students_of_folders(names: Iterable[str]) -> dict[str, str]:
    """Return the key of the student of each folder.

    Folders that differ by blanks or by letters that nobody sees are of different
    students. The folder that has exactly the name that is shown keeps it.
    """
    folders = {_composed_folder(name) for name in names}
    students: dict[str, str] = {}
    counts = Counter[str]()
    for folder in sorted(folders, key=lambda folder: (folder != shown(folder), folder)):
        student = shown(folder) or "_"
        counts[student] += 1
        number = counts[student]
        students[folder] = f"{student} ({number})" if number > 1 else student
    return students


def _composed_folder(name: str) -> str:
    """Return the first folder of a name, with composed letters."""
    return unicodedata.normalize("NFC", name.partition("/")[0])


def _folders_below(files: Listing, outer: str) -> dict[str, str]:
    """Return the names of folders without the outer one, by their whole names."""
    return {
        folder: folder.removeprefix(outer)
        for folder in files.folders
        if folder.startswith(outer) and folder != outer
    }


def _contains_several_students(files: Listing, outer: str) -> bool:
    """Return whether the only folder contains logs of several students.

    A zip usually contains the folder that was packed, so that its files count too.
    """
    is_packed = files.root.is_file()
    students = set()
    for name in files.names:
        own = name.removeprefix(outer)
        if ending(name) not in LOGS:
            continue
        if "/" in own:
            students.add(own.partition("/")[0])
        elif is_packed:
            students.add(_flat_key(own))
    return len(students) > 1


def _take_apart(match: re.Match[str], root: Path) -> Submission:
    """Read the groups of a match."""
    groups = dict.fromkeys(_GROUPS, "") | match.groupdict("")
    stem = groups["stem"]
    ids = {kind: shown(groups[kind]) for kind in _IDS if groups[kind]}
    key = shown(groups["student"]) or next(iter(ids.values()))
    if groups["canvas_anonymous"]:
        key = f"anon_{key}"
    person = shown(groups["name"]) or key
    if person == "Participant":
        # In anonymous submissions, Moodle calls everybody so.
        person = f"Participant {key}"
    if stem:
        ids["folder"] = shown(stem)
    submission = Submission(key, person, ids, root, late=bool(groups["late"]))
    return replace(
        submission,
        submitted=_time_of_stamp(groups["stamp"]),
        log_file=groups["file"] or None,
        feedback_stem=printable(stem or _without_ending(match.string)),
    )


def _without_ending(path: str) -> str:
    """Return the name of a file without its ending, both of "lab.csv.gz"."""
    file = path.rpartition("/")[2]
    packed = file.removesuffix(".gz").removesuffix(".GZ")
    stem, _, _ = packed.rpartition(".")
    return stem or file


def _with_user_names(platform: str, named: Named) -> Named:
    """Call each student of Blackboard by the user name, which may contain a ``_``.

    It follows the name of the assignment, with which all files begin.
    """
    if platform != "blackboard":
        return named
    owners = {part.student for part in named.values() if part}
    # These are not paths, but names whose beginning is equal.
    shared = ""
    if len(owners) > 1:
        shared = commonprefix([*owners])  # noqa: RUF071
    at = shared.rfind("_") + 1
    for name, part in named.items():
        if part is not None:
            user = part.student[at:] if at else part.name
            ids = {"username": user}
            named[name] = replace(part, student=user, name=user, ids=ids)
    return named


def _time_of_stamp(stamp: str) -> str | None:
    """Return the time in a name: of Canvas, or "Mar 9, 2026 205 PM" of Brightspace."""
    with_zero = re.sub(r"(?<= )(?=\d{3} [AP]M)", "0", stamp)
    for form in ("%b %d, %Y %I%M %p", "%B %d, %Y %I%M %p"):
        with suppress(ValueError):
            return datetime.strptime(with_zero, form).isoformat()
    return re.sub(r"(.{10})-(..)-(..)-(..)", r"\1T\2:\3:\4", stamp) or None


def _of_folder(
    name: str, in_folders: bool, root: Path, students: Mapping[str, str]
) -> Submission | None:
    """Read the name of a student's folder, or of a student's file."""
    _, slash, rest = name.partition("/")
    is_below = bool(slash)
    is_other = not is_below and ending(name) in _NO_SUBMISSION
    if is_below != in_folders or is_other:
        return None
    student = students[_composed_folder(name)] if is_below else _flat_key(name)
    file = rest if is_below else name
    ids = {"folder": student}
    return Submission(student, student, ids, root, log_file=file, feedback_stem=student)


def different(names: Mapping[str, str], others: Iterable[str] = ()) -> dict[str, str]:
    """Return names by keys; the key is added to a name that another one has too.

    {"7": "Jane Doe", "8": "Jane Doe"} becomes
    {"7": "Jane Doe (7)", "8": "Jane Doe (8)"}. `others`: More names.
    """
    counts = Counter([*names.values(), *others])
    shown_names = {}
    for key, name in names.items():
        is_shared = name and counts[name] > 1
        shown_names[key] = f"{name} ({key})" if is_shared else name
    return shown_names


_COPY_AND_ENDING = re.compile(
    r"(?i)(?: ?\([0-9]{1,2}\))?(?:\.toml\.txt|\.[^.]+(?:\.gz)?)$"
)


def _flat_key(name: str) -> str:
    """Return the key of a student with a file.

    It is ``jdoe`` for ``jdoe.csv``, ``jdoe (1).csv`` and ``jdoe_answers.toml``.
    """
    key = _COPY_AND_ENDING.sub("", name) or name
    for word in ("answers", "report"):
        is_behind = key.lower().endswith(word) and key[-len(word) - 1 :][:1] in "-_. "
        if is_behind and len(key) > len(word) + 1:
            key = key[: -len(word) - 1]
            break
    return shown(key) or "_"


# --- the metadata of Gradescope: submitters and times, as fields of `Submission` ---


class _Person(Struct):
    name: str | None = None
    sid: str | int | None = None
    email: str | None = None
    assignment: dict[str, Any] | None = None


class _Entry(Struct):
    """One submission; an export says less of it than a running autograder."""

    submitters: list[_Person] | Literal[""] = ""
    created_at: str | None = None
    id: str | int = ""
    users: list[_Person] = []
    assignment: dict[str, Any] | None = None

    def about(self, folder: str, number: str) -> dict[str, Any]:
        """Give what is said of the submission.

        A student is known by number, else by address or name.
        """
        people = self._people()
        keys = sorted(people)
        time = _time(self.created_at)
        stamp = time and time.isoformat(timespec="seconds")
        about: dict[str, Any] = {"submitted": stamp}
        if not keys:
            return about
        first = people[keys[0]]
        sid = str(first.sid or "")
        email = first.email or ""
        ids = {"gradescope": number, "sid": sid, "email": email, "folder": folder}
        about["student"] = "+".join(map(shown, keys))
        about["name"] = ", ".join(shown(people[key].name or key) for key in keys)
        about["ids"] = {kind: value for kind, value in ids.items() if value}
        about["members_of_group"] = tuple(keys) if len(keys) > 1 else ()
        return about

    def _people(self) -> dict[str, _Person]:
        """Return the students by number, else by address or name."""
        users = self.submitters or self.users
        people = {}
        for user in users:
            key = user.sid or user.email or user.name
            if key:
                people[str(key)] = user
        return people


def _time(text: str | None) -> datetime | None:
    """Read a time of ISO 8601, or as Ruby writes it."""
    joined = text or ""
    for zone in "-+Z":
        joined = joined.replace(f" {zone}", zone)
    with suppress(ValueError):
        return datetime.fromisoformat(joined)
    return None


_WANTED = re.compile(
    r"^(?:\S.*|  :(?:submitters|created_at):.*(?:\n(?:   .*|  - .*|[ \t]*$))*)",
    re.MULTILINE,
)
"""The first line of each submission, and its parts with submitters and time."""


def _text_of_binary(_: Any, node: Any) -> str:
    return base64.b64decode(node.value).decode("utf-8", "replace")


def read_export(data: bytes) -> dict[str, dict[str, Any]]:
    """Read ``submission_metadata.yml``, by the folder of each submission.

    ValueError if it is not such a file.
    """
    import yaml

    # Every scalar is a text, and nothing is an empty one. The loader in C is ten times
    # as fast.
    loader: Any = type("Texts", (getattr(yaml, "CBaseLoader", yaml.BaseLoader),), {})
    loader.add_implicit_resolver("!nothing", re.compile("~|null"), ["~", "n"])
    loader.add_constructor("!nothing", lambda *_: "")
    loader.add_constructor("!binary", _text_of_binary)
    text = "\n".join(_WANTED.findall(data.decode("utf-8-sig", "replace")))
    try:
        # Ruby writes a colon in front of each key.
        text = re.sub(r"(?m)^( +(?:- )?):(?=\w+:)", r"\1", text)
        values = yaml.load(text, Loader=loader)
        entries = msgspec.convert(values, dict[str, _Entry])
    except (
        RecursionError,
        msgspec.ValidationError,
        yaml.YAMLError,
        ValueError,
    ) as error:
        why = getattr(error, "problem", None) or getattr(error, "reason", None) or error
        raise ValueError(f"this is not the metadata of an export: {why}") from None
    about = {}
    for folder, entry in entries.items():
        start, _, key = folder.partition("submission_")
        if not start and key.isalnum() and key.isascii():
            about[folder] = entry.about(folder, key)
    if not about:
        raise ValueError("it lists no submission")
    return about


def read_live(data: bytes) -> dict[str, Any]:
    """Read ``submission_metadata.json`` of a running autograder.

    ValueError if it is not such a file.

    Lateness follows from the time of submission and the due date of the student, never
    from the clock.
    """
    try:
        live = msgspec.json.decode(data.removeprefix(b"\xef\xbb\xbf"), type=_Entry)
        assignments = (*(user.assignment for user in live.users), live.assignment)
        dues = [_time((assignment or {}).get("due_date")) for assignment in assignments]
        due = max(filter(None, dues[:-1]), default=dues[-1])
        time = _time(live.created_at)
        late = None
        if time and due:
            late = (time - due).total_seconds()
    except (msgspec.DecodeError, TypeError, RecursionError) as error:
        raise ValueError(f"this is not the metadata of a submission: {error}") from None
    return live.about("submission", str(live.id)) | {"late_seconds": late}
