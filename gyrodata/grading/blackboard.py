"""Blackboard's receipts and user names: a file's own name cannot tell where a user name with a ``_`` begins."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from os.path import commonprefix

from gyrodata.errors import GyroError
from gyrodata.grading.patterns import shown

_ATTEMPT = re.compile(r"(?P<who>[^/]*)_attempt_\d{4}(?:-\d\d){5}")
_FIRST_LINE = re.compile(r"[^:\n]{1,40}:\s*([^\n]*\S)\s*\(([^()\s]+)\)\s*(?:\n|$)")


def is_receipt(name: str) -> bool:
    """Tell Blackboard's own note on an attempt, which is no student's file."""
    file = name.rpartition("/")[2]
    match = _ATTEMPT.match(file)
    return match is not None and file[match.end() :] == ".txt"


def people(names: Iterable[str], read: Callable[[str], bytes]) -> dict[str, tuple[str, str]]:
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
