"""The metadata of Gradescope: submitters and times.

An export holds YAML written by Ruby, with symbols for keys, and can have many megabytes of results and histories that
nobody asks for here: only the lines that are asked for are parsed. A running autograder finds JSON.

Formats: gradescope-autograders.readthedocs.io, and exports as public tools read them (``[':submitters'][0][':sid']``).
"""

from __future__ import annotations

import base64
import re
from datetime import datetime
from typing import Any, Literal

import msgspec
from msgspec import Struct

LIVE, EXPORT = "submission_metadata.json", "submission_metadata.yml"  # of a running autograder, and of an export
LARGEST = 100_000_000  # bytes of a metadata file that are read


class Submitter(Struct, frozen=True, rename=lambda name: f":{name}"):
    """One of those who hand something in together, as an export has them."""

    name: str = ""
    sid: str = ""
    email: str = ""

    @property
    def key(self) -> str:
        """Return the permanent key of a student: the student number, else the address or name."""
        return self.sid or self.email or self.name


class Metadata(Struct, frozen=True):
    """The metadata of one submission."""

    submitters: tuple[Submitter, ...]  # several for a group
    submitted: str | None = None  # ISO 8601 with its offset
    late_seconds: float | None = None  # since the due date [s], negative before it; None where none is told
    attempt: int = 1
    number: str = ""  # Gradescope's, of the submission


_ENTRY = re.compile(r"submission_([0-9A-Za-z]+)")
_WANTED = re.compile(r"^(?:\S.*|  :(?:submitters|created_at):.*(?:\n(?:   .*|  - .*|[ \t]*$))*)", re.MULTILINE)
"""Heads of submissions, and of what is told of each the parts that are asked for."""


class _Entry(Struct, rename=lambda name: f":{name}"):
    """The entry of a submission in an export."""

    submitters: list[Submitter] | Literal[""] = ""
    created_at: str = ""


def read_export(data: bytes) -> dict[str, Metadata]:
    """Read ``submission_metadata.yml``, by the submission's folder; ValueError where it is none."""
    text = "\n".join(_WANTED.findall(data.decode("utf-8-sig", "replace")))
    try:
        table = msgspec.convert(_load(text), dict[str, _Entry])
    except (RecursionError, msgspec.ValidationError) as error:
        raise ValueError(f"it is no such list: {error}") from None
    found = {}
    for folder, entry in table.items():
        if match := _ENTRY.fullmatch(folder):
            submitters = tuple(one for one in entry.submitters or [] if one.key)
            found[folder] = Metadata(submitters, _ruby_time(entry.created_at), number=match[1])
    if not found:
        raise ValueError("it lists no submission")
    return found


def _load(text: str) -> Any:
    """Read YAML with a text for every scalar, an empty one for nothing."""
    import yaml

    loader: Any = getattr(yaml, "CBaseLoader", yaml.BaseLoader)  # the one in C is ten times as fast
    texts: Any = type("Texts", (loader,), {})
    texts.add_implicit_resolver("!nothing", re.compile("~|null"), ["~", "n"])
    texts.add_constructor("!nothing", lambda *_: "")
    texts.add_constructor("!binary", lambda _, node: base64.b64decode(node.value).decode("utf-8", "replace"))
    try:
        return yaml.load(text, Loader=texts)
    except (yaml.YAMLError, ValueError) as error:
        why = getattr(error, "problem", None) or getattr(error, "reason", None) or "it is no YAML"
        raise ValueError(why) from None


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
    """``submission_metadata.json`` as far as it is asked for."""

    id: str | int = ""
    created_at: datetime | None = None
    users: list[_User] = []
    assignment: _Assignment | None = None
    previous_submissions: list[dict[str, Any]] = []


def read_live(data: bytes) -> Metadata:
    """Read ``submission_metadata.json`` of a running autograder; ValueError where it is none.

    Gives: Lateness from the time of submission and the due date (the student's own, where there is one), never from the
    clock; earlier submissions that failed on the platform's side (``autograder_error``) count as no attempt.
    """
    try:
        live = msgspec.json.decode(data.removeprefix(b"\xef\xbb\xbf"), type=_Live)
        own = [user.assignment.due_date for user in live.users if user.assignment and user.assignment.due_date]
        due = max(own) if own else live.assignment and live.assignment.due_date
        late = (live.created_at - due).total_seconds() if live.created_at and due else None
    except (msgspec.DecodeError, TypeError, RecursionError) as error:
        raise ValueError(f"it is no such JSON: {error}") from None
    submitters = tuple(Submitter(user.name or "", str(user.sid or ""), user.email or "") for user in live.users)
    attempts = sum(not one.get("autograder_error") for one in live.previous_submissions)
    stamp = live.created_at.isoformat(timespec="seconds") if live.created_at else None
    return Metadata(submitters, stamp, late, attempts + 1, str(live.id))
