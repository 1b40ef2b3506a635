"""What Gradescope tells beside the files: who submitted and when.

An export holds YAML written by Ruby, with symbols for keys, and can have many megabytes of results and histories that
nobody asks for here: only the lines that are asked for are parsed. A running autograder finds JSON.

Formats: gradescope-autograders.readthedocs.io, and exports as public tools read them (``[':submitters'][0][':sid']``).
"""

from __future__ import annotations

import base64
import json
import re
from collections.abc import Mapping
from datetime import datetime
from typing import Any

from msgspec import Struct

LARGEST = 100_000_000  # bytes of a metadata file that are read


class MetadataError(ValueError):
    """A metadata file that cannot be read; the message says what and where."""


class Submitter(Struct, frozen=True):
    """One of those who hand something in together."""

    name: str = ""
    sid: str = ""
    email: str = ""

    @property
    def key(self) -> str:
        """What stays the same from one submission to the next: the student number, else the address or name."""
        return self.sid or self.email or self.name


class Metadata(Struct, frozen=True):
    """What is told of one submission."""

    submitters: tuple[Submitter, ...]  # several for a group
    submitted: str | None = None  # ISO 8601 with its offset
    late_seconds: float | None = None  # since the due date [s], negative before it; None where none is told
    attempt: int = 1
    number: str = ""  # Gradescope's, of the submission


_ENTRY = re.compile(r"submission_([0-9A-Za-z]+)")
_WANTED = re.compile(r"^(?:\S.*|  :(?:submitters|created_at):.*(?:\n(?:   .*|  - .*|[ \t]*$))*)", re.MULTILINE)
"""Heads of submissions, and of what is told of each the parts that are asked for."""


def read_export(data: bytes) -> dict[str, Metadata]:
    """Read ``submission_metadata.yml``, by the submission's folder."""
    try:
        table = _load("\n".join(_WANTED.findall(data.decode("utf-8-sig", "replace"))))
    except RecursionError:
        raise MetadataError("its tables are nested too deep") from None
    found = {}
    for folder, entry in _table(table).items():
        if match := _ENTRY.fullmatch(folder):
            about = _table(entry)
            people = [_table(one) for one in _list(about.get(":submitters"))]
            parts = [[_text(one.get(key)) for key in (":name", ":sid", ":email")] for one in people]
            submitters = tuple(Submitter(*one) for one in parts if any(one))
            found[folder] = Metadata(submitters, _ruby_time(_text(about.get(":created_at"))), number=match[1])
    if not found:
        raise MetadataError("it lists no submission")
    return found


def _load(text: str) -> Any:
    """Read YAML with a text for every scalar."""
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
        raise MetadataError(why) from None


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
