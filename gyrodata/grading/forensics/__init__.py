"""Flags, never verdicts: what in a class's logs honest work hardly ever shows, with how often it would.

A fingerprint of each log is kept (`logs`), and all are compared at once (`flag_class`):

* rows in common, in any order, unit and rounding (`copies`);
* the same spins at the same weights, whatever became of the times (`copies`);
* scatter below what a hand can do (`flags`).

Every threshold follows from one number, `ALLOWED`: the flags of one kind that a class of honest students gets by
chance. Every flag says how many as strong as itself chance makes.
"""

from __future__ import annotations

import csv
import difflib
import os
import unicodedata
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import MappingProxyType

from msgspec import Struct
from msgspec.structs import replace

from gyrodata.diagnostics import PARTNER_ALONE, PARTNER_UNKNOWN, PARTNERS_CANNOT_BE_READ
from gyrodata.errors import Diagnostic, InputError
from gyrodata.grading.forensics.copies import Beside, flag_copies, put_beside
from gyrodata.grading.forensics.flags import ALLOWED, KINDS, Flag, flag_scatter
from gyrodata.grading.forensics.logs import Fingerprint, fingerprint, lay_out

__all__ = [
    "ALLOWED",
    "KINDS",
    "LARGEST_FILE",
    "LONGEST_LINE",
    "Beside",
    "Exemptions",
    "Fingerprint",
    "Flag",
    "fingerprint",
    "flag_class",
    "put_beside",
    "read_exemptions",
]

_NOTHING: Mapping[str, Fingerprint] = MappingProxyType({})


def flag_class(
    prints: Mapping[str, Fingerprint],
    exempt: Exemptions | None = None,
    previous: Mapping[str, Fingerprint] = _NOTHING,
) -> tuple[Flag, ...]:
    """Find what is odd in a class's logs.

    `prints`: One log of each student, by the student's key. `exempt`:
    Partners, whose logs may be alike, and staff, whose logs are left out. `previous`: Earlier logs and published
    examples, by a key of their own; compared with the class's, not with each other. Gives: By kind, in the order of
    `KINDS`, then by students. Logs that one kind joins are not joined again by the next, and many copies of one log are
    one flag.
    """
    exempt = exempt or Exemptions()
    judged = [student for student in sorted(prints) if student not in exempt.staff]
    logs = lay_out(judged, prints, exempt.groups, previous)
    flags = flag_scatter(logs) + (flag_copies(logs) if logs.pairs > 0 else [])
    return tuple(sorted(flags, key=lambda flag: (KINDS.index(flag.kind), flag.students, flag.previous)))


# --- whose logs may be alike: partners who hand in the same data, and staff ------------------------------


LARGEST_FILE = 1_000_000  # bytes of a file of partners that are read at most

LONGEST_LINE = 100_000  # characters in one of its lines at most

STAFF = "staff:"  # begins a line of people whose logs are compared with nobody's


class Exemptions(Struct, frozen=True):
    """Who is not to be flagged."""

    groups: tuple[frozenset[str], ...] = ()  # students who hand in the same data, by key; one may be in several groups
    staff: frozenset[str] = frozenset()  # keys of those who are left out of all comparisons
    diagnostics: tuple[Diagnostic, ...] = ()

    def joined(self, groups: Iterable[frozenset[str]]) -> Exemptions:
        """Give the same with more students who hand in the same data."""
        return replace(self, groups=(*self.groups, *groups))


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
            hint = "write the partners in one line: alice, bob"
            found.append(Diagnostic.of(PARTNER_ALONE, message, hint, name, number))
    return Exemptions(tuple(groups), frozenset(staff), tuple(found))


def _read(source: str | os.PathLike[str] | bytes) -> tuple[str, str]:
    """Name and text of the file."""
    name = "partners" if isinstance(source, bytes) else Path(source).name
    hint = "give a text file with one group of partners a line: alice, bob"
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
        if isinstance(error, FileNotFoundError | NotADirectoryError):
            hint = "check its name"
        message = f"the file of partners cannot be read: {reason}"
        raise InputError.of(PARTNERS_CANNOT_BE_READ, message, hint, name) from None
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
    return Diagnostic.of(PARTNER_UNKNOWN, message, hint, name, number, column, line, len(cell))
