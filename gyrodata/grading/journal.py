"""The journal of a class: a line for each grade as soon as it is there, and what it rests on.

A run that is stopped at any point has lost nothing that was done, and the next one grades only what has changed,
and can say why.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Literal

from msgspec import Struct, field

from gyrodata import __version__
from gyrodata.diagnostics import GRADES_FOLDER_CANNOT_BE_WRITTEN, JOURNAL_LINES_LOST
from gyrodata.disk import add_to, telling, write_whole
from gyrodata.errors import Diagnostic
from gyrodata.grading.grade import Grade, from_json, to_json
from gyrodata.grading.rubric import Rubric
from gyrodata.grading.submissions import Submission

JOURNAL = "journal.ndjson"  # next to the grades


class Basis(Struct, frozen=True):
    """The inputs of a grade; if they are the same, so is the grade."""

    submission: str  # digest of what was handed in, by whom, and when
    rubric: str  # digest of all in the rubric but its references
    reference: str  # digest of all in it
    tool: str  # version of gyrodata
    desk: str = ""  # what a person typed in for what was handed in


class Entry(Basis, frozen=True, kw_only=True):
    """One line: a grade before the class as a whole was looked at, and what it rests on."""

    schema: Literal["gyro.journal/1"] = "gyro.journal/1"
    grade: Grade
    lost: str = ""
    """Why the run itself lost the grade (a time limit, a process that died), so that it is tried again; else ""."""
    figures: Mapping[str, str] = field(default_factory=dict)
    """What each figure that was drawn shows, in words, by its name."""
    seen: Mapping[str, str] = field(default_factory=dict)
    """Digest of the submission that each line of the desk was written for."""

    def why_again(self, basis: Basis) -> str:
        """Say why the submission is graded again if its grade now rests on `basis`; "" if this grade is still right."""
        for part in ("submission", "rubric", "reference", "desk"):
            if getattr(self, part) != getattr(basis, part):
                return f"the {part} changed"
        if self.tool != basis.tool:
            return f"gyrodata changed from {self.tool} to {basis.tool}"
        return f"lost last time: {self.lost}" if self.lost else ""


def basis_of(item: Submission, rubric: Rubric, reported: str) -> Basis:
    """Say what the grade of a submission rests on; `reported`: what a person typed in for it."""
    counts_files = any(criterion.check == "files" for criterion in rubric.criteria)
    told = repr((item.digest, item.name, sorted(item.ids.items()), *(item.members if counts_files else ())))
    handed_in = hashlib.sha256(told.encode("utf-8", "replace")).hexdigest()
    return Basis(handed_in, rubric.judged, rubric.digest, __version__, reported)


class Journal:
    """The file."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.damaged = 0  # lines that cannot be read, as after a power cut
        self.lines = 0  # all lines; a run that was stopped may leave two of one student
        self.torn = False  # the last line has no end

    def read(self) -> dict[str, Entry]:
        """Give the entries by student; of several the last one counts."""
        entries: dict[str, Entry] = {}
        with telling(self.path.parent, GRADES_FOLDER_CANNOT_BE_WRITTEN):
            try:
                data = self.path.read_bytes()
            except FileNotFoundError:
                return {}
        self.torn = data != b"" and not data.endswith(b"\n")
        lines = data.splitlines()
        self.lines = len(lines)
        for line in lines:
            try:
                entry = from_json(line, Entry)
            except (ValueError, RecursionError):
                self.damaged += 1
            else:
                entries[entry.grade.student] = entry
        return entries

    def lost_lines(self) -> Diagnostic:
        """Say that lines could not be read."""
        count = "1 line" if self.damaged == 1 else f"{self.damaged} lines"
        message = f"{count} of the journal cannot be read; what was there was graded again"
        return Diagnostic.of(JOURNAL_LINES_LOST, message, file=self.path.name)

    def add(self, entry: Entry) -> None:
        """Write a line at the end, at once."""
        with telling(self.path.parent, GRADES_FOLDER_CANNOT_BE_WRITTEN):
            add_to(self.path, b"\n" * self.torn + _line(entry))
        self.torn = False

    def replace(self, entries: Iterable[Entry]) -> None:
        """Replace the journal, one line for each entry; the old file stays until the new one is complete."""
        with telling(self.path.parent, GRADES_FOLDER_CANNOT_BE_WRITTEN):
            write_whole(self.path, map(_line, entries), private=True, sync=True)


def _line(entry: Entry) -> bytes:
    return f"{to_json(entry)}\n".encode()
