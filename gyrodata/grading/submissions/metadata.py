"""What Gradescope tells beside the files: who submitted and when.

An export holds ``submission_metadata.yml``, written by Ruby with symbols for keys; a running autograder finds
``submission_metadata.json``. The first can have many megabytes of results and histories that nobody asks for here,
so that it is gone through line by line for its four keys; a general YAML parser would build all of it.

Formats: gradescope-autograders.readthedocs.io, and exports as public tools read them (``[':submitters'][0][':sid']``).
"""

from __future__ import annotations

import base64
import io
import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Any

EXPORT = "submission_metadata.yml"
LIVE = "submission_metadata.json"
LARGEST = 100_000_000
"""Bytes of a metadata file that are read."""


class MetadataError(ValueError):
    """A metadata file that cannot be read; the message says what and where."""


@dataclass(frozen=True, slots=True)
class Submitter:
    """One of those who hand something in together."""

    name: str = ""
    sid: str = ""
    email: str = ""

    @property
    def key(self) -> str:
        """What stays the same from one submission to the next: the student number, else the address or name."""
        return self.sid or self.email or self.name


@dataclass(frozen=True, slots=True)
class Metadata:
    """What is told of one submission.

    Attributes
    ----------
    submitters : tuple of Submitter
        Several for a group.
    submitted : str or None
        Time of submission, ISO 8601 with its offset.
    late_seconds : float or None
        Time since the due date [s], negative before it; None where no due date is told.
    attempt : int
        1 for the first.
    number : str
        Gradescope's number of the submission.
    """

    submitters: tuple[Submitter, ...]
    submitted: str | None = None
    late_seconds: float | None = None
    attempt: int = 1
    number: str = ""


_ENTRY = re.compile(r"(submission_([0-9A-Za-z]+)):\s*$")
_KEY = re.compile(r"(?P<indent> *)(?P<dash>- )?:(?P<key>\w+):(?:\s+(?P<value>.*))?$")
_ANCHOR = re.compile(r"&(\w+)\s+(.*)")


def read_export(data: bytes) -> dict[str, Metadata]:
    """Read ``submission_metadata.yml``.

    Gives: By the submission's folder.
    """
    found: dict[str, Metadata] = {}
    folder, people, submitted, inside = "", [], None, ""  # type: str, list[dict[str, str]], str | None, str
    anchors: dict[str, str] = {}
    number = ""

    def close() -> None:
        if folder:
            submitters = tuple(Submitter(**person) for person in people if any(person.values()))
            found[folder] = Metadata(submitters, submitted, number=number)

    lines = enumerate(io.TextIOWrapper(io.BytesIO(data), "utf-8-sig", "replace"), start=1)
    for at, ended in lines:
        line = ended.rstrip("\n")
        entry = _ENTRY.match(line)
        if entry:
            close()
            folder, people, submitted, inside, number = entry[1], [], None, "", entry[2]
            continue
        if line[:1] not in (" ", "", "#", "-") and not line.startswith(("---", "...")):
            raise MetadataError(f'line {at}, "{line[:40]}", is not of the form that Gradescope writes')
        match = _KEY.match(line)
        if not match or not folder:
            continue
        if len(match["indent"]) == 2 and not match["dash"]:
            inside = match["key"]
            if inside == "created_at":
                submitted = _ruby_time(_scalar(match["value"] or "", lines, anchors, at))
        elif inside == "submitters" and len(match["indent"]) + len(match["dash"] or "") in (4, 6):
            if match["dash"]:
                people.append({})
            if people and match["key"] in ("name", "sid", "email"):
                people[-1][match["key"]] = _scalar(match["value"] or "", lines, anchors, at)
    close()
    if not found:
        raise MetadataError("it lists no submission")
    return found


def _scalar(text: str, lines: Iterator[tuple[int, str]], anchors: dict[str, str], at: int) -> str:
    """Read one value in any of the ways that Ruby writes a short text."""
    text = text.strip()
    anchor = _ANCHOR.match(text)
    if anchor:
        anchors[anchor[1]] = value = _scalar(anchor[2], lines, anchors, at)
        return value
    if text.startswith("*"):
        return anchors.get(text[1:], "")
    if text in ("", "~", "null", "''", '""'):
        return ""
    if text.startswith("!binary"):
        rest = text.removeprefix("!binary").strip()
        coded = next(lines, (0, ""))[1] if rest.startswith("|") else rest.strip("\"'")
        return base64.b64decode(coded.strip() + "==").decode("utf-8", "replace")
    if text[0] in "|>":
        return next(lines, (0, ""))[1].strip()
    if text[0] not in "\"'":
        return text
    if len(text) < 2 or text[-1] != text[0]:
        raise MetadataError(f"line {at}: a quoted text goes on in the next line")
    return text[1:-1].replace("''", "'") if text[0] == "'" else _unescaped(text[1:-1])


_ESCAPE = re.compile(r"\\(?:x([0-9a-fA-F]{2})|u([0-9a-fA-F]{4})|U([0-9a-fA-F]{8})|(.))")


def _unescaped(text: str) -> str:
    """Undo YAML's escapes in a text in double quotes (YAML 1.1, 5.7)."""
    plain = dict(zip("0abtnvfreN_LP", "\0\a\b\t\n\v\f\r\x1b\x85\xa0\u2028\u2029", strict=True))

    def one(match: re.Match[str]) -> str:
        digits = match[1] or match[2] or match[3]
        if digits:
            code = int(digits, 16)
            return chr(code) if code < 0x110000 else "\ufffd"
        return plain.get(match[4], match[4])

    return _ESCAPE.sub(one, text)


def _ruby_time(text: str) -> str | None:
    """Turn ``2026-03-09 14:05:59.123456789 -08:00`` (or ``Z``) into ISO 8601 to the second."""
    match = re.match(r"(\d{4}-\d\d-\d\d)[ T](\d\d:\d\d:\d\d)(?:\.\d+)?\s*(Z|[-+]\d\d:?\d\d)?$", text)
    if match is None:
        return None
    zone = match[3] or ""
    try:
        return datetime.fromisoformat(f"{match[1]}T{match[2]}{zone}").isoformat()
    except ValueError:
        return None


def read_live(data: bytes) -> Metadata:
    """Read ``submission_metadata.json`` of a running autograder.

    Gives: Lateness from the time of submission and the due date (the student's own, where there is one), never from the
    clock; earlier submissions that failed on the platform's side (``autograder_error``) count as no attempt.
    """
    try:
        table: Any = json.loads(data.decode("utf-8-sig"))
    except (ValueError, RecursionError) as error:
        raise MetadataError(f"it is no JSON: {error}") from None
    if not isinstance(table, dict):
        raise MetadataError("it is no JSON object")
    users = [user for user in _list(table.get("users")) if isinstance(user, dict)]
    submitters = tuple(
        Submitter(_text(user.get("name")), _text(user.get("sid")), _text(user.get("email"))) for user in users
    )
    submitted = _time(table.get("created_at"))
    dues = [_time(_table(user.get("assignment")).get("due_date")) for user in users]
    own = [due for due in dues if due is not None]
    due = max(own) if own else _time(_table(table.get("assignment")).get("due_date"))
    late = None
    if submitted is not None and due is not None and (submitted.tzinfo is None) == (due.tzinfo is None):
        late = (submitted - due).total_seconds()
    earlier = [_table(one) for one in _list(table.get("previous_submissions"))]
    attempts = sum(1 for one in earlier if one.get("autograder_error") is not True)
    stamp = submitted.isoformat(timespec="seconds") if submitted else None
    return Metadata(submitters, stamp, late, attempts + 1, _text(table.get("id")))


def _list(value: Any) -> list[Any]:
    return value if isinstance(value, list) else []


def _table(value: Any) -> Mapping[str, Any]:
    return value if isinstance(value, dict) else {}


def _text(value: Any) -> str:
    return str(value) if isinstance(value, str | int) and not isinstance(value, bool) else ""


def _time(value: Any) -> datetime | None:
    try:
        return datetime.fromisoformat(value) if isinstance(value, str) else None
    except ValueError:
        return None
