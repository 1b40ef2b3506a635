"""Names of files: what each says, whose names a class has, and a pattern of one's own."""

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
from gyrodata.grading.submissions.metadata import EXPORT
from gyrodata.grading.submissions.student_files import ending, is_log


class ParsedName(Struct, frozen=True):
    """The information in the name of one file."""

    student: str  # key of the student or group
    name: str  # as to be shown
    ids: Mapping[str, str]  # the platform's own: "canvas", "moodle", "username", …
    file: str  # as the student named it, folders in the submission included; "" for a receipt of the platform
    stem: str  # name under which the platform takes a feedback file back
    late: bool = False  # marked late by the platform
    submitted: str | None = None  # time stamp, ISO 8601 where it is a date
    attempt: int | None = None  # number, if the name contains one
    late_seconds: float | None = None  # time after the due date [s], negative before it; None where none is told
    members: tuple[str, ...] = ()  # keys of all in a group


_IDS = ("moodle", "canvas", "canvas_anonymous", "username", "gradescope", "email")


def _match(name: str, lms: str) -> re.Match[str] | None:
    return next(filter(None, (shape.fullmatch(name) for shape in PLATFORMS[lms].shapes)), None)


def read_pattern(text: str) -> re.Pattern[str]:
    """Check a pattern of the user's own: a group ``student``, and any of the others that `read_own_name` looks at."""
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


def read_own_name(name: str, pattern: re.Pattern[str]) -> ParsedName | None:
    """Read a name by a pattern of the user's own, which may fit anywhere in it; None if it does not."""
    match = pattern.search(name)
    return _take_apart(match) if match is not None and match["student"] else None


def read_name(name: str, lms: str) -> ParsedName | None:
    """Read a name below the class as one platform writes it; None if it does not."""
    match = _match(name, lms)
    return None if match is None else _take_apart(match)


def _take_apart(match: re.Match[str]) -> ParsedName:
    """Say what the groups of a match are; the file of a pattern of the user's own needs none."""
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
        # Moodle calls everybody so where nobody is named.
        f"{person} {key}" if person == "Participant" else person or key,
        ids,
        groups.get("file", file if kind == "student" else ""),
        key.replace("/", "_") if kind == "student" else printable(groups.get("stem") or stem),
        "late" in groups,
        groups.get("submitted") or stamp or None,
        int(number) if number.isascii() and number.isdigit() else None,
    )


# --- whose names the files of a class have ------------------------------------------------------------------


_NO_SUBMISSION = (".md", ".json", ".ndjson", ".html", ".py", ".yml", ".yaml", ".ini", ".sh")
"""Endings of what stands beside the files of a flat folder and is no student's."""


def whose_names(names: list[str], folders: tuple[str, ...], lms: str, packed: bool) -> tuple[str, str]:
    """Tell whose names they are and below which folder, with a ``/`` at its end, they stand.

    A zip (`packed`) as a rule holds the folder that was packed.
    """
    firsts = {name.partition("/")[0] for name in (*names, *folders)}
    outer = f"{firsts.pop()}/" if len(firsts) == 1 and all("/" in name for name in names) else ""
    for below in dict.fromkeys(("", outer)):
        inner = [name.removeprefix(below) for name in names]
        # Return the platform of most of the names, at least half of them.
        counts = Counter(next((lms for lms in NAMED if _match(name, lms)), None) for name in inner)
        seen = "gradescope" if EXPORT in inner else max(NAMED, key=counts.__getitem__)
        if lms == "auto" and (EXPORT in inner or counts[seen] * 2 >= max(counts.total(), 1)):
            return seen, below
        if lms in NAMED and any(read_name(name, lms) for name in inner):
            return lms, below
    if lms in NAMED:
        return lms, ""
    return "folder", _class_folder(names, outer, packed)


def _class_folder(names: list[str], outer: str, packed: bool) -> str:
    """Return whether a folder is that of the class, with logs of several students, or of its only student."""
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
    return {name: read_name(own, lms) for name, own in inner.items()}


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
    stem = re.sub(r" ?\([0-9]{1,2}\)$", "", stem)
    return shown(re.sub(r"(?i)[-_. ](?:answers|report)$", "", stem) or stem) or "_"


# --- whose a file is where its own name cannot tell: Blackboard's, with a _ in a user name -------------------


_FIRST_LINE = re.compile(r"[^:\n]{1,40}:\s*([^\n]*\S)\s*\(([^()\s]+)\)\s*(?:\n|$)")


def people_by_receipts(named: Mapping[str, ParsedName], read: Callable[[str], bytes]) -> dict[str, ParsedName]:
    """Tell who handed in each file, and so who has which user name and full name.

    A receipt begins with "Name: Jane Doe (jdoe)", in the language of the site. Where there is none, the user name is
    what follows the assignment's name, which all files share.
    """
    (shape,) = PLATFORMS["blackboard"].shapes
    matches = {name: match for name in named if (match := shape.fullmatch(name.rpartition("/")[2]))}
    owners = {name: match["owner"] for name, match in matches.items()}
    told: dict[str, tuple[str, str]] = {}
    for name in (name for name, match in matches.items() if not match["file"]):
        with suppress(GyroError):
            line = _FIRST_LINE.match(read(name).decode("utf-8-sig", "replace").replace("\r", "\n"))
            # A receipt is text that anybody can write: the user name must be the one in the file's name.
            if line and owners[name].endswith(f"_{line[2]}"):
                told[owners[name]] = shown(line[2]), shown(line[1])
    distinct = set(owners.values())
    prefix = commonprefix(sorted(distinct)) if len(distinct) > 1 else ""  # noqa: RUF071 (these are no paths)
    shared = prefix.rpartition("_")[0]
    for owner in distinct - told.keys():
        user = shown(owner.removeprefix(f"{shared}_") if shared else owner.rpartition("_")[2])
        told[owner] = user, user
    people = {}
    for name, owner in owners.items():
        user, full = told[owner]
        people[name] = replace(named[name], student=user, name=full, ids={"username": user})
    return people
