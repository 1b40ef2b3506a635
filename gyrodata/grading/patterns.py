"""How platforms name what they hand out: one table of patterns, and a pattern of one's own.

Canvas: `lib/content_zipper.rb` of instructure/canvas-lms. Moodle: `mod/assign/classes/downloader.php` and
`feedback/file/importziplib.php` of moodle/moodle; names are parsed from the number, for a name may hold anything
but an underscore. Blackboard and Gradescope: as their downloads are, neither publishes its source.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from datetime import datetime

from gyrodata.errors import Diagnostic, InputError, printable, register

G706 = register("G706", "error", "--pattern cannot be used", "grade class --pattern '(\\w+)_lab.csv'")


@dataclass(frozen=True, slots=True)
class Named:
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


def fit(name: str, lms: str) -> Named | None:
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
        raise InputError([Diagnostic(G706, "error", f'--pattern "{text}": {error.msg}{place}', hint)]) from None
    if "student" not in pattern.groupindex:
        message = f'--pattern "{text}" does not say which part is the student'
        raise InputError([Diagnostic(G706, "error", message, hint)])
    return pattern


def fit_own(name: str, pattern: re.Pattern[str]) -> Named | None:
    """Read a name by a pattern of the user's own, which may fit anywhere in it; None if it does not."""
    match = pattern.search(name)
    if match is None or not match["student"]:
        return None
    groups = {key: value for key, value in match.groupdict().items() if value}
    student = shown(groups["student"])
    number = groups.get("attempt", "")
    return Named(
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


def _named(name: str, match: re.Match[str]) -> Named:
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
    return Named(
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
