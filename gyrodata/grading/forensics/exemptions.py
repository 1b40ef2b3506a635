"""Whose logs may be alike: partners who hand in the same data, and staff."""

from __future__ import annotations

import csv
import difflib
import os
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from gyrodata.diagnostics import PARTNER_ALONE, PARTNER_UNKNOWN, PARTNERS_CANNOT_BE_READ
from gyrodata.errors import Diagnostic, InputError

LARGEST_FILE = 1_000_000
"""Bytes of a file of partners that are read at most."""

LONGEST_LINE = 100_000
"""Characters in one of its lines at most."""

STAFF = "staff:"
"""Begins a line of people whose logs are compared with nobody's."""


@dataclass(frozen=True, slots=True)
class Exemptions:
    """Who is not to be flagged."""

    groups: tuple[frozenset[str], ...] = ()
    """Students who hand in the same data, by key; one may be in several groups."""
    staff: frozenset[str] = frozenset()
    """Keys of those who are left out of all comparisons."""
    diagnostics: tuple[Diagnostic, ...] = ()

    def partners(self, number: Mapping[str, int]) -> dict[int, frozenset[int]]:
        """Give the logs that may be like each log, as numbers."""
        partners: dict[int, frozenset[int]] = {}
        for group in self.groups:
            members = frozenset(number[key] for key in group if key in number)
            for member in members:
                partners[member] = partners.get(member, frozenset()) | members - {member}
        return partners


def read_exemptions(source: str | os.PathLike[str] | bytes, students: Mapping[str, str]) -> Exemptions:
    """Read who works together: one group a line, names parted by commas, semicolons or tabs.

    `source`: The file, such as ``alice, bob`` and ``staff: carol`` in two lines; what follows ``#`` at the start of a
    line is a remark. `students`: Every name by which a student may be called there, with the student's key. Case does
    not matter. Gives: With a warning for each name that is nobody's.
    """
    name, text = _read(source)
    known = {_folded(alias): key for alias, key in students.items()}
    groups: list[frozenset[str]] = []
    staff: set[str] = set()
    found: list[Diagnostic] = []
    for number, line in enumerate(map(str.strip, text.split("\n")), 1):
        if not line or line.startswith("#"):
            continue
        is_staff = line.lower().startswith(STAFF)
        cells = _cells(line[len(STAFF) :] if is_staff else line)
        members = set()
        for cell in cells:
            key = known.get(_folded(cell))
            if key is None:
                found.append(_nobody(name, number, line, cell, students))
            else:
                members.add(key)
        if is_staff:
            staff |= members
        elif len(members) > 1:
            groups.append(frozenset(members))
        elif len(cells) < 2:
            message = f'"{line[:60]}" names one student only'
            found.append(
                Diagnostic(
                    PARTNER_ALONE, "warning", message, "write the partners in one line: alice, bob", name, number
                )
            )
    return Exemptions(tuple(groups), frozenset(staff), tuple(found))


def _read(source: str | os.PathLike[str] | bytes) -> tuple[str, str]:
    """Name and text of the file."""
    name = "partners" if isinstance(source, bytes) else Path(source).name
    hint = "one group of partners a line: alice, bob"
    try:
        if isinstance(source, bytes):
            data = source
        else:
            with Path(source).open("rb") as file:
                data = file.read(LARGEST_FILE + 1)
        if len(data) > LARGEST_FILE:
            raise ValueError(f"it is larger than {LARGEST_FILE // 1_000_000} MB")
        if b"\0" in data:
            raise ValueError("it is no text")
        text = data.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
        if max(map(len, text.split("\n"))) > LONGEST_LINE:
            raise ValueError(f"a line is longer than {LONGEST_LINE} characters")
    except (OSError, ValueError) as error:
        reason = "it is no text in UTF-8" if isinstance(error, UnicodeDecodeError) else str(error)
        if isinstance(error, OSError) and error.strerror:
            reason = error.strerror
        message = f"the file of partners cannot be read: {reason}"
        raise InputError([Diagnostic(PARTNERS_CANNOT_BE_READ, "error", message, hint, name)]) from None
    return name, text


def _cells(line: str) -> list[str]:
    """Part a line; names with commas stand in quotes, or between semicolons or tabs."""
    delimiter = next((mark for mark in "\t;" if mark in line), ",")
    row = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])
    return [cell.strip() for cell in row if cell.strip()]


def _folded(name: str) -> str:
    return unicodedata.normalize("NFC", name.strip()).casefold()


def _nobody(name: str, number: int, line: str, cell: str, students: Mapping[str, str]) -> Diagnostic:
    close = difflib.get_close_matches(cell, students, n=1)
    hint = f"did you mean {close[0]}?" if close else "write the key of a student as the grades have it"
    message = f'"{cell[:60]}" is nobody in this class'
    column = max(line.find(cell), 0) + 1
    return Diagnostic(PARTNER_UNKNOWN, "warning", message, hint, name, number, column, line, len(cell))
