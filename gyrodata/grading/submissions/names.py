"""The names of the files of a class: which student each file is from, by platform or by a pattern of the user."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Mapping
from contextlib import suppress
from os.path import commonprefix

from msgspec import Struct
from msgspec.structs import replace

from gyrodata.diagnostics import PATTERN_CANNOT_BE_USED
from gyrodata.errors import GyroError, InputError, printable, shown
from gyrodata.grading.platforms import NAMED, PLATFORMS
from gyrodata.grading.submissions.archives import Listing
from gyrodata.grading.submissions.metadata import EXPORT
from gyrodata.grading.submissions.student_files import ending, is_log


class ParsedName(Struct, frozen=True):
    """The information in the name of one file."""

    student: str  # key of the student or group
    name: str  # to be shown
    ids: Mapping[str, str]  # of the platform: "canvas", "moodle", "username", …
    file: str  # name that the student gave, with folders in the submission; "" for a receipt of the platform
    stem: str  # name under which the platform accepts a feedback file
    late: bool = False  # marked late by the platform
    submitted: str | None = None  # time stamp, ISO 8601 if it is a date
    attempt: int | None = None  # number, if the name contains one
    late_seconds: float | None = None  # time after the due date [s], negative before it; None if unknown
    members: tuple[str, ...] = ()  # keys of all in a group


Named = dict[str, ParsedName | None]

_IDS = ("moodle", "canvas", "canvas_anonymous", "username", "gradescope", "email")

_NO_SUBMISSION = (".md", ".json", ".ndjson", ".html", ".py", ".yml", ".yaml", ".ini", ".sh")
"""Endings of files in a flat folder that are no student's."""


def name_all(files: Listing, lms: str, pattern: str | None, packed: bool) -> tuple[str, Named, list[ParsedName]]:
    """Find out which platform named the files, and read each name.

    Parameters
    ----------
    files : Listing
        The class.
    lms : str
        A platform, or "auto".
    pattern : str or None
        A regular expression of the user instead.
    packed : bool
        True for a zip, which usually contains the folder that was packed.

    Returns
    -------
    tuple
        The platform; what each name says, None for a file of no student; and students with an empty folder.
    """
    names = list(files.sizes)
    if pattern is not None:
        own = _read_pattern(pattern)
        matches = {name: own.search(name) for name in names}
        return (
            "pattern",
            {name: _take_apart(one) if one and one["student"] else None for name, one in matches.items()},
            [],
        )
    firsts = {name.partition("/")[0] for name in (*names, *files.folders)}
    outer = f"{firsts.pop()}/" if len(firsts) == 1 and all("/" in name for name in names) else ""
    for below in dict.fromkeys(("", outer)) if lms != "folder" else ():
        inner = {name: name.removeprefix(below) for name in names}
        counts = Counter(next((one for one in NAMED if PLATFORMS[one].match(name)), None) for name in inner.values())
        seen, exported = lms, EXPORT in inner.values()
        if lms == "auto":
            seen = "gradescope" if exported else max(NAMED, key=counts.__getitem__)
        found = {
            name: match and _take_apart(match)
            for name, match in ((n, PLATFORMS[seen].match(o)) for n, o in inner.items())
        }
        if any(found.values()) if lms != "auto" else exported or counts[seen] * 2 >= max(counts.total(), 1):
            return seen, found, []
    if lms in NAMED:
        return lms, dict.fromkeys(names), []
    # The only folder is that of the class if it contains logs of several students, else that of its only student.
    logs = [name.removeprefix(outer) for name in names if is_log(name)]
    people = {name.partition("/")[0] if "/" in name else _flat_key(name) for name in logs if "/" in name or packed}
    below = outer if len(people) > 1 else ""
    inner = {name: name.removeprefix(below) for name in names}
    in_folders = any("/" in own for own in [one for one in inner.values() if is_log(one)] or inner.values())
    folders = [one.removeprefix(below) for one in files.folders if one.startswith(below)]
    students = [shown(one.rstrip("/")) for one in folders if one.count("/") == 1]
    empty = [ParsedName(student, student, {"folder": student}, "", student) for student in students]
    return "folder", {name: _of_folder(own, in_folders) for name, own in inner.items()}, empty


def _read_pattern(text: str) -> re.Pattern[str]:
    """Check a regular expression of the user: it needs a group ``student``, and may have others of `_take_apart`."""
    hint = r"write it like --pattern '(?P<student>\w+)_lab\.csv'"
    try:
        pattern = re.compile(text)
    except re.error as error:
        place = f" at character {error.pos + 1}" if error.pos is not None else ""
        raise InputError.of(PATTERN_CANNOT_BE_USED, f'--pattern "{text}": {error.msg}{place}', hint) from None
    if "student" not in pattern.groupindex:
        message = f'--pattern "{text}" does not say which part is the student'
        raise InputError.of(PATTERN_CANNOT_BE_USED, message, hint)
    return pattern


def _take_apart(match: re.Match[str]) -> ParsedName:
    """Read the groups of a match; in a pattern of the user, the file needs no group."""
    groups = {kind: text for kind, text in match.groupdict().items() if text}
    kind = next(kind for kind in ("student", *_IDS) if kind in groups)
    key = f"anon_{shown(groups[kind])}" if kind == "canvas_anonymous" else shown(groups[kind])
    person = shown(groups.get("name", ""))
    ids = {one: shown(groups[one]) for one in _IDS if one in groups}
    if "stem" in groups:
        ids["folder"] = shown(groups["stem"])
    file = match.string.rpartition("/")[2]
    # Without its ending, both of "lab.csv.gz".
    stem = re.sub(r"(?i)(?:\.[^.]+)(?:\.gz)?$", "", file) or file
    number = groups.get("attempt", "")
    stamp = re.sub(r"(.{10})-(..)-(..)-(..)", r"\1T\2:\3:\4", groups.get("stamp", ""))
    return ParsedName(
        key,
        # In anonymous submissions, Moodle calls everybody so.
        f"{person} {key}" if person == "Participant" else person or key,
        ids,
        groups.get("file", file if kind == "student" else ""),
        key.replace("/", "_") if kind == "student" else printable(groups.get("stem") or stem),
        "late" in groups,
        groups.get("submitted") or stamp or None,
        int(number) if number.isascii() and number.isdigit() else None,
    )


def _of_folder(name: str, in_folders: bool) -> ParsedName | None:
    """Read a name of a class with a folder for each student, or with a file for each."""
    first, slash, rest = name.partition("/")
    if bool(slash) != in_folders or (not slash and ending(name) in _NO_SUBMISSION):
        return None
    student = (shown(first) or "_") if slash else _flat_key(name)
    return ParsedName(student, student, {"folder": student}, rest or name, student)


def _flat_key(name: str) -> str:
    """Return the key of a student with a file: ``jdoe`` of ``jdoe.csv``, ``jdoe (1).csv``, ``jdoe_answers.toml``."""
    stem = re.sub(r"(?i)(?:\.toml\.txt|\.[^.]+(?:\.gz)?)$", "", name) or name
    stem = re.sub(r" ?\([0-9]{1,2}\)$", "", stem)
    return shown(re.sub(r"(?i)[-_. ](?:answers|report)$", "", stem) or stem) or "_"


_FIRST_LINE = re.compile(r"[^:\n]{1,40}:\s*([^\n]*\S)\s*\(([^()\s]+)\)\s*(?:\n|$)")


def people_by_receipts(named: Mapping[str, ParsedName], read: Callable[[str], bytes]) -> dict[str, ParsedName]:
    """Find the user name and the full name of each student in names of Blackboard, where user names may contain a _.

    A receipt begins with "Name: Jane Doe (jdoe)", in the language of the site. Without a receipt, the user name is
    behind the name of the assignment, which all files share.
    """
    matches = {name: PLATFORMS["blackboard"].match(name.rpartition("/")[2]) for name in named}
    owners = {name: match["owner"] for name, match in matches.items() if match}
    known: dict[str, tuple[str, str]] = {}
    for name, owner in owners.items():
        with suppress(GyroError):
            text = "" if named[name].file else read(name).decode("utf-8-sig", "replace").replace("\r", "\n")
            line = _FIRST_LINE.match(text)
            # Anybody can write such a text: the user name must be the one in the name of the file.
            if line and owner.endswith(f"_{line[2]}"):
                known[owner] = shown(line[2]), shown(line[1])
    distinct = set(owners.values())
    prefix = commonprefix(sorted(distinct)) if len(distinct) > 1 else ""  # noqa: RUF071 (these are no paths)
    shared = prefix.rpartition("_")[0]
    people = {}
    for name, owner in owners.items():
        user = shown(owner.removeprefix(f"{shared}_") if shared else owner.rpartition("_")[2])
        user, full = known.get(owner, (user, user))
        people[name] = replace(named[name], student=user, name=full, ids={"username": user})
    return people
