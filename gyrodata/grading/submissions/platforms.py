"""Platforms and their names: what each writes, whose names a class has, and a pattern of one's own.

Canvas: `lib/content_zipper.rb` of instructure/canvas-lms. Moodle: `mod/assign/classes/downloader.php` and
`feedback/file/importziplib.php` of moodle/moodle; names are parsed from the number, for a name may hold anything
but an underscore. Blackboard and Gradescope: as their downloads are, neither publishes its source.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from datetime import datetime
from os.path import commonprefix

from gyrodata.diagnostics import PATTERN_CANNOT_BE_USED
from gyrodata.errors import Diagnostic, GyroError, InputError, printable
from gyrodata.grading.submissions.metadata import EXPORT
from gyrodata.grading.submissions.student_files import ending, is_answers, is_log


@dataclass(frozen=True, slots=True)
class ParsedName:
    """What the name of one file says.

    Attributes
    ----------
    student : str
        Key of the student or group.
    name : str
        As to be shown.
    ids : mapping of str to str
        The platform's own: ``canvas``, ``moodle``, ``username``, …
    file : str
        As the student named it, folders in the submission included; "" for a receipt of the platform.
    stem : str
        Name under which the platform takes a feedback file back.
    late : bool
        Marked late by the platform.
    submitted : str or None
        Time stamp, ISO 8601 where it is a date.
    attempt : int or None
        Number, where the name holds one.
    """

    student: str
    name: str
    ids: Mapping[str, str]
    file: str
    stem: str
    late: bool = False
    submitted: str | None = None
    attempt: int | None = None


@dataclass(frozen=True, slots=True)
class Pattern:
    """One shape of name, with the groups ``name``, ``late``, ``stamp``, ``file`` and the platform's ids."""

    lms: str
    shape: re.Pattern[str]


_IDS = ("moodle", "canvas", "anonymous", "username", "gradescope")

# A name that fits several is taken for the first.
PATTERNS: tuple[Pattern, ...] = tuple(
    Pattern(lms, re.compile(shape, re.DOTALL))
    for lms, shape in (
        ("moodle", r"(?P<stem>(?P<name>[^/]*?)_(?P<moodle>\d+)_assignsubmission_[a-z]+_?)/(?P<file>.+)"),
        ("moodle", r"(?P<name>[^/]*?)_(?P<moodle>\d+)_assignsubmission_[a-z]+_(?P<file>[^/]+)"),
        ("blackboard", r"[^/]*_(?P<username>[^_/]+)_attempt_(?P<stamp>\d{4}(?:-\d\d){5})(?:_(?P<file>[^/]+)|\.txt)"),
        ("gradescope", r"(?P<stem>submission_(?P<gradescope>\d+))/(?P<file>.+)"),
        ("canvas", r"(?P<late>LATE_)?anon_(?P<anonymous>[0-9A-Za-z]+)_(?P<attachment>\d+)_(?P<file>[^/]+)"),
        ("canvas", r"(?P<late>LATE_)?anon_(?P<anonymous>[0-9A-Za-z]+)_(?P<file>(?:text|link)\.html)"),
        ("canvas", r"(?P<name>[^/]*?)(?P<late>_LATE|_late)?_(?P<canvas>\d+)_(?P<attachment>\d+)_(?P<file>[^/]+)"),
        ("canvas", r"(?P<name>[^/]*?)(?P<late>_LATE|_late)?_(?P<canvas>\d+)_(?P<file>(?:text|link)\.html)"),
    )
)
"""All shapes of all platforms; matched against the whole name of a file below the class."""

PLATFORMS: tuple[str, ...] = tuple(dict.fromkeys(pattern.lms for pattern in PATTERNS))

SAMPLES: Mapping[str, str] = {
    "moodle": "Jane Doe_1234567_assignsubmission_file/lab.csv",
    "blackboard": "Gyroscope lab_jdoe_attempt_2026-03-09-14-05-59_lab.csv",
    "gradescope": "submission_123456789/lab.csv beside submission_metadata.yml",
    "canvas": "doejane_9876_5432_lab.csv",
    "folder": "jdoe/lab.csv or jdoe.csv",
}
"""One name of each, for messages."""


def fit(name: str, lms: str) -> ParsedName | None:
    """Read a name as one platform writes it; None if it does not.

    `name`: Of a file, below the class, parts joined by ``/``.
    """
    for pattern in PATTERNS:
        match = pattern.shape.fullmatch(name) if pattern.lms == lms else None
        if match:
            return _named(name, match)
    return None


def recognise(names: Iterable[str]) -> str | None:
    """Tell which platform wrote most of the names, at least half of them; None if none did."""
    counts = dict.fromkeys(PLATFORMS, 0)
    total = 0
    for name in names:
        total += 1
        lms = next((pattern.lms for pattern in PATTERNS if pattern.shape.fullmatch(name)), None)
        if lms is not None:
            counts[lms] += 1
    best = max(PLATFORMS, key=lambda lms: counts[lms])
    return best if counts[best] and counts[best] * 2 >= total else None


def read_pattern(text: str) -> re.Pattern[str]:
    """Check a pattern of the user's own.

    `text`: A regular expression that finds ``(?P<student>…)`` in the name of each file below the class, and if it can
    ``name``, ``file``, ``late``, ``submitted``, ``attempt``, ``username``, ``email``.
    """
    hint = r"write it like --pattern '(?P<student>\w+)_lab\.csv'"
    try:
        pattern = re.compile(text)
    except re.error as error:
        place = f" at character {error.pos + 1}" if error.pos is not None else ""
        raise InputError(
            [Diagnostic(PATTERN_CANNOT_BE_USED, "error", f'--pattern "{text}": {error.msg}{place}', hint)]
        ) from None
    if "student" not in pattern.groupindex:
        message = f'--pattern "{text}" does not say which part is the student'
        raise InputError([Diagnostic(PATTERN_CANNOT_BE_USED, "error", message, hint)])
    return pattern


def fit_own(name: str, pattern: re.Pattern[str]) -> ParsedName | None:
    """Read a name by a pattern of the user's own, which may fit anywhere in it; None if it does not."""
    match = pattern.search(name)
    if match is None or not match["student"]:
        return None
    groups = {key: value for key, value in match.groupdict().items() if value}
    student = shown(groups["student"])
    number = groups.get("attempt", "")
    return ParsedName(
        student,
        shown(groups.get("name", "")) or student,
        {key: shown(groups[key]) for key in ("username", "email") if key in groups},
        groups.get("file", name.rpartition("/")[2]),
        student.replace("/", "_"),
        "late" in groups,
        groups.get("submitted"),
        int(number) if number.isascii() and number.isdigit() else None,
    )


def shown(text: str) -> str:
    """Give a name as it can be printed: composed letters, without control characters or marks that turn a line."""
    turning = (" " if unicodedata.category(c) in ("Cc", "Zl", "Zp") or c in _TURNING else c for c in printable(text))
    kept = "".join(turning)
    return " ".join(unicodedata.normalize("NFC", kept).split())


_TURNING = "\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069"


def _named(name: str, match: re.Match[str]) -> ParsedName:
    groups = match.groupdict()
    kind = next(key for key in _IDS if groups.get(key))
    number = shown(groups[kind])
    person = shown(groups.get("name") or "")
    if kind == "anonymous":
        person = number = f"anon_{number}"
    elif kind == "moodle" and person == "Participant":
        person = f"Participant {number}"
    ids = {"canvas_anonymous" if kind == "anonymous" else kind: groups[kind]}
    if "stem" in groups:
        ids["folder"] = shown(groups["stem"])
    return ParsedName(
        number,
        person or number,
        ids,
        groups.get("file") or "",
        printable(groups.get("stem") or _stem(name.rpartition("/")[2])),
        bool(groups.get("late")),
        _iso(groups.get("stamp")),
    )


def _stem(file: str) -> str:
    """Leave the ending away, both of ``lab.csv.gz``."""
    return re.sub(r"(?:\.[^.]+)(?:\.gz)?$", "", file, flags=re.IGNORECASE) or file


def _iso(stamp: str | None) -> str | None:
    """Turn Blackboard's ``2026-03-09-14-05-59`` into ISO 8601; the zone is the server's and is not told."""
    try:
        return datetime.strptime(stamp or "", "%Y-%m-%d-%H-%M-%S").isoformat()
    except ValueError:
        return None


# --- whose names the files of a class have ------------------------------------------------------------------


_NO_SUBMISSION = (".md", ".json", ".ndjson", ".html", ".py", ".yml", ".yaml", ".ini", ".sh")
"""Endings of what stands beside the files of a flat folder and is no student's."""


def whose_names(names: list[str], folders: tuple[str, ...], lms: str, packed: bool) -> tuple[str, str]:
    """Tell whose names they are and below which folder they stand.

    `names`: All files of the class, parts joined by ``/``. `folders`: All its folders, each with a ``/`` at its end.
    `lms`: ``auto``, ``folder`` or one of `PLATFORMS`. `packed`: Whether it is a zip, which as a rule holds the folder
    that was packed. Gives: ``folder`` or one of `PLATFORMS`; and the folder around all files, with a ``/`` at its end,
    or "".
    """
    outer = _outer_folder([*names, *folders])
    for below in ("", outer) if outer else ("",):
        inner = [name.removeprefix(below) for name in names]
        seen = "gradescope" if EXPORT in inner else recognise(inner)
        if lms == "auto" and seen:
            return seen, below
        if lms in PLATFORMS and any(fit(name, lms) for name in inner):
            return lms, below
    if lms in PLATFORMS:
        return lms, ""
    return "folder", _class_folder(names, outer, packed)


def _outer_folder(names: list[str]) -> str:
    """Find the folder that all files stand in."""
    firsts = {name.partition("/")[0] for name in names}
    return f"{firsts.pop()}/" if len(firsts) == 1 and all("/" in name for name in names) else ""


def _class_folder(names: list[str], outer: str, packed: bool) -> str:
    """Tell a folder around the class from the folder of its only student: the class's holds the logs of several."""
    logs = [name.removeprefix(outer) for name in names if is_log(name)]
    people = {name.partition("/")[0] for name in logs if "/" in name}
    if packed:
        people |= {_flat_key(name) for name in logs if "/" not in name}
    return outer if len(people) > 1 else ""


def name_all(names: list[str], lms: str, below: str) -> dict[str, ParsedName | None]:
    """Read each name as `whose_names` found; None for a file of no student."""
    inner = {name: name.removeprefix(below) for name in names}
    if lms == "folder":
        nested = {"/" in own for own in inner.values() if is_log(own)} or {"/" in own for own in inner.values()}
        in_folders = True in nested
        return {name: _fit_folder(own, in_folders) for name, own in inner.items()}
    return {name: fit(own, lms) for name, own in inner.items()}


def _fit_folder(name: str, in_folders: bool) -> ParsedName | None:
    """Read a name of a class with a folder, or where there are none with a file, for each student."""
    first, slash, rest = name.partition("/")
    if in_folders:
        student = shown(first) or "_"
        return ParsedName(student, student, {"folder": student}, rest, student) if slash else None
    if slash or ending(name) in _NO_SUBMISSION:
        return None
    student = _flat_key(name)
    return ParsedName(student, student, {"folder": student}, name, student)


def _flat_key(name: str) -> str:
    """Key of a student with a file of their own: ``jdoe`` of ``jdoe.csv``, ``jdoe (1).csv``, ``jdoe_answers.toml``."""
    stem = re.sub(r"(?i)(?:\.toml\.txt|\.[^.]+(?:\.gz)?)$", "", name) or name
    if is_answers(name):
        stem = re.sub(r"(?i)[-_. ]?answers$", "", stem) or stem
    return shown(re.sub(r" ?\([0-9]{1,2}\)$", "", stem)) or "_"


# --- Blackboard: a file's own name cannot tell where a user name with a _ begins ----------------------------


_ATTEMPT = re.compile(r"(?P<who>[^/]*)_attempt_\d{4}(?:-\d\d){5}")
_FIRST_LINE = re.compile(r"[^:\n]{1,40}:\s*([^\n]*\S)\s*\(([^()\s]+)\)\s*(?:\n|$)")


def is_receipt(name: str) -> bool:
    """Tell Blackboard's own note on an attempt, which is no student's file."""
    file = name.rpartition("/")[2]
    match = _ATTEMPT.match(file)
    return match is not None and file[match.end() :] == ".txt"


def blackboard_people(names: Iterable[str], read: Callable[[str], bytes]) -> dict[str, tuple[str, str]]:
    """Tell who handed in each file.

    A receipt begins with "Name: Jane Doe (jdoe)", in the language of the site. Where there is none, the user name is
    what follows the assignment's name, which all files share.

    Gives: From file to user name and full name.
    """
    owners = {name: match["who"] for name in names if (match := _ATTEMPT.match(name.rpartition("/")[2]))}
    told: dict[str, tuple[str, str]] = {}
    for name, owner in owners.items():
        if is_receipt(name):
            person = _read_receipt(owner, name, read)
            if person:
                told[owner] = person
    distinct = set(owners.values())
    prefix = commonprefix(sorted(distinct)) if len(distinct) > 1 else ""  # noqa: RUF071 (these are no paths)
    shared = prefix.rpartition("_")[0]
    return {name: told.get(owner) or _guessed(owner, shared) for name, owner in owners.items()}


def _guessed(owner: str, shared: str) -> tuple[str, str]:
    user = owner.removeprefix(f"{shared}_") if shared else owner.rpartition("_")[2]
    return shown(user), shown(user)


def _read_receipt(owner: str, name: str, read: Callable[[str], bytes]) -> tuple[str, str] | None:
    try:
        head = read(name).decode("utf-8-sig", "replace").replace("\r", "\n")
    except GyroError:
        return None
    match = _FIRST_LINE.match(head)
    # A receipt is text that anybody can write: the user name must be the one in the file's name.
    if match and owner.endswith(f"_{match[2]}"):
        return shown(match[2]), shown(match[1])
    return None
