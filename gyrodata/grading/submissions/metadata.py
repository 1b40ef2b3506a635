"""The metadata of Gradescope: submitters and times, as fields of `Submission`.

An export contains YAML written by Ruby, with symbols for keys and many megabytes of results and histories. Only the
lines with submitters and times are parsed. A running autograder finds JSON.

Formats: gradescope-autograders.readthedocs.io, and exports as public tools read them (``[':submitters'][0][':sid']``).
"""

from __future__ import annotations

import base64
import re
from collections.abc import Sequence
from datetime import datetime
from typing import Any, Literal

import msgspec
from msgspec import Struct

from gyrodata.errors import shown

LIVE, EXPORT = "submission_metadata.json", "submission_metadata.yml"  # of a running autograder, and of an export
LARGEST = 100_000_000  # bytes of a metadata file that are read


class _Person(Struct, rename=lambda name: f":{name}"):
    name: str = ""
    sid: str = ""
    email: str = ""


def _about(folder: str, number: str, people: Sequence[_Person], submitted: str | None) -> dict[str, Any]:
    """Give what the metadata says of a submission; a student is known by number, else by address or name."""
    keys = {one.sid or one.email or one.name: one for one in people}
    keys.pop("", None)
    about: dict[str, Any] = {"submitted": submitted}
    if keys:
        first = keys[min(keys)]
        ids = {"gradescope": number, "sid": first.sid, "email": first.email, "folder": folder}
        about["student"] = "+".join(map(shown, sorted(keys)))
        about["name"] = ", ".join(shown(keys[key].name) or shown(key) for key in sorted(keys))
        about["ids"] = {kind: value for kind, value in ids.items() if value}
        about["members_of_group"] = tuple(sorted(keys)) if len(keys) > 1 else ()
    return about


class _Entry(Struct, rename=lambda name: f":{name}"):
    submitters: list[_Person] | Literal[""] = ""
    created_at: str = ""


_WANTED = re.compile(r"^(?:\S.*|  :(?:submitters|created_at):.*(?:\n(?:   .*|  - .*|[ \t]*$))*)", re.MULTILINE)
"""The first line of each submission, and its parts with submitters and time."""


def read_export(data: bytes) -> dict[str, dict[str, Any]]:
    """Read ``submission_metadata.yml``, by the folder of each submission; ValueError if it is not such a file."""
    import yaml

    # Every scalar is a text, and nothing is an empty one. The loader in C is ten times as fast.
    loader: Any = type("Texts", (getattr(yaml, "CBaseLoader", yaml.BaseLoader),), {})
    loader.add_implicit_resolver("!nothing", re.compile("~|null"), ["~", "n"])
    loader.add_constructor("!nothing", lambda *_: "")
    loader.add_constructor("!binary", lambda _, node: base64.b64decode(node.value).decode("utf-8", "replace"))
    found = {}
    try:
        values = yaml.load("\n".join(_WANTED.findall(data.decode("utf-8-sig", "replace"))), Loader=loader)
        for folder, entry in msgspec.convert(values, dict[str, _Entry]).items():
            if match := re.fullmatch(r"submission_([0-9A-Za-z]+)", folder):
                found[folder] = _about(folder, match[1], entry.submitters or [], _ruby_time(entry.created_at))
    except (RecursionError, msgspec.ValidationError, yaml.YAMLError, ValueError) as error:
        why = getattr(error, "problem", None) or getattr(error, "reason", None) or error
        raise ValueError(f"this is not the metadata of an export: {why}") from None
    if not found:
        raise ValueError("it lists no submission")
    return found


def _ruby_time(text: str) -> str | None:
    """Turn ``2026-03-09 14:05:59.123456789 -08:00`` (or ``Z``) into ISO 8601 to the second."""
    try:
        return datetime.fromisoformat(re.sub(" (?=[-+Z])", "", text)).isoformat(timespec="seconds")
    except ValueError:
        return None


class _Assignment(Struct):
    due_date: datetime | None = None


class _User(Struct):
    name: str | None = None
    sid: str | int | None = None
    email: str | None = None
    assignment: _Assignment | None = None


class _Live(Struct):
    id: str | int = ""
    created_at: datetime | None = None
    users: list[_User] = []
    assignment: _Assignment | None = None
    previous_submissions: list[dict[str, Any]] = []


def read_live(data: bytes) -> dict[str, dict[str, Any]]:
    """Read ``submission_metadata.json`` of a running autograder; ValueError if it is not such a file.

    Lateness follows from the time of submission and the due date of the student, never from the clock. An earlier
    submission that failed on the side of the platform (``autograder_error``) is not an attempt.
    """
    try:
        live = msgspec.json.decode(data.removeprefix(b"\xef\xbb\xbf"), type=_Live)
        own = [user.assignment.due_date for user in live.users if user.assignment and user.assignment.due_date]
        due = max(own) if own else live.assignment and live.assignment.due_date
        late = (live.created_at - due).total_seconds() if live.created_at and due else None
    except (msgspec.DecodeError, TypeError, RecursionError) as error:
        raise ValueError(f"this is not the metadata of a submission: {error}") from None
    people = [_Person(user.name or "", str(user.sid or ""), user.email or "") for user in live.users]
    stamp = live.created_at.isoformat(timespec="seconds") if live.created_at else None
    attempt = 1 + sum(not one.get("autograder_error") for one in live.previous_submissions)
    about = _about("submission", str(live.id), people, stamp)
    return {"submission": about | {"late_seconds": late, "attempt": attempt}}
