"""The journal of a class: a line for each grade as soon as it is there, and what it rests on.

A run that is stopped at any point has lost nothing that was done, and the next one grades only what has changed,
and can say why.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Collection, Iterable, Iterator, Mapping
from io import FileIO
from pathlib import Path
from typing import Literal

from msgspec import Struct, field
from msgspec.structs import asdict

from gyrodata import __version__
from gyrodata.diagnostics import GRADES_FOLDER_CANNOT_BE_WRITTEN, JOURNAL_LINES_LOST
from gyrodata.disk import add_line, open_end, telling, write_whole
from gyrodata.errors import Diagnostic
from gyrodata.grading.grade import Grade, from_json
from gyrodata.grading.lastrun import is_run
from gyrodata.grading.rubric import Rubric
from gyrodata.grading.submissions import Submission


class Basis(Struct, frozen=True):
    """What a grade rests on; where all of it is the same, so is the grade."""

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
    """Why the run itself lost it (a time limit, a process that died), so that it is tried again; "" for a grade that
    holds."""
    figures: Mapping[str, str] = field(default_factory=dict)
    """What each figure that was drawn shows, in words, by its name."""
    seen: Mapping[str, str] = field(default_factory=dict)
    """Digest of the submission that each line of the desk was written for."""

    def to_line(self, grade: str = "") -> str:
        """Write it as one line of JSON; `grade`: The grade as `Grade.to_json` has it, where that is at hand."""
        content = {"student": self.grade.student, **asdict(self)}
        del content["grade"]
        head = json.dumps(content, allow_nan=False, separators=(",", ":"))
        return f'{head[:-1]},"grade":{grade or self.grade.to_json()}}}\n'


def basis_of(item: Submission, rubric: Rubric, reported: str) -> Basis:
    """Say what the grade of a submission rests on; `reported`: what a person typed in for it."""
    counts_files = any(criterion.check == "files" for criterion in rubric.criteria)
    told = repr((item.digest, item.name, sorted(item.ids.items()), *(item.members if counts_files else ())))
    handed_in = hashlib.sha256(told.encode("utf-8", "replace")).hexdigest()
    return Basis(handed_in, rubric.judged, rubric.digest, __version__, reported)


def why_again(before: Entry, basis: Basis) -> str:
    """Say why a submission is graded again; "" where the grade of the journal holds."""
    for part in ("submission", "rubric", "reference", "desk"):
        if getattr(before, part) != getattr(basis, part):
            return f"the {part} changed"
    if before.tool != basis.tool:
        return f"gyrodata changed from {before.tool} to {basis.tool}"
    return f"lost last time: {before.lost}" if before.lost else ""


class Journal:
    """The file."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.file: FileIO | None = None  # where lines were added
        self.damaged = 0
        self.outdated = False  # True where lines are out of order or double, as after a run that was killed
        self.places: dict[str, tuple[int, int]] = {}  # where the line of each student begins, and its length [byte]

    def read(self) -> Iterator[Entry]:
        """Go through it line by line; a line that was torn by a power cut is left out.

        Gives: The last one of a student holds.
        """
        self.damaged, self.outdated, self.places, at, last = 0, False, {}, 0, ""
        with telling(self.path.parent, GRADES_FOLDER_CANNOT_BE_WRITTEN):
            try:
                file = self.path.open("rb")
            except FileNotFoundError:
                return
            with file:
                for line in file:
                    at += len(line)
                    if is_run(line):
                        continue
                    try:
                        entry = from_json(line, Entry)
                    except (ValueError, RecursionError):
                        self.damaged += 1
                    else:
                        # Of two lines of one student the second is no later in the order.
                        self.outdated |= entry.grade.student <= last
                        last = entry.grade.student
                        self.places[last] = at - len(line), len(line)
                        yield entry

    def torn(self) -> Diagnostic:
        """Say that lines could not be read."""
        count = "1 line" if self.damaged == 1 else f"{self.damaged} lines"
        message = f"{count} of the journal cannot be read; what stood there was graded again"
        return Diagnostic.of(JOURNAL_LINES_LOST, message, file=self.path.name)

    def add(self, entry: Entry, grade: str = "") -> None:
        """Write a line at the end, whole, at once; `grade` as `Entry.to_line` has it."""
        line = entry.to_line(grade).encode()
        with telling(self.path.parent, GRADES_FOLDER_CANNOT_BE_WRITTEN):
            self.file = self.file or open_end(self.path)
            self.places[entry.grade.student] = add_line(self.file, line), len(line)

    def close(self) -> None:
        """Close the file, where lines were added."""
        if self.file is not None:
            self.file.close()
            self.file = None

    __del__ = close

    def replace(self, entries: Iterable[Entry], changed: Collection[str] = ()) -> None:
        """Write it anew, a line for each entry, the old one where the student is not among the changed.

        The old file stays until the new one is whole.
        """
        self.close()
        with telling(self.path.parent, GRADES_FOLDER_CANNOT_BE_WRITTEN):
            write_whole(self.path, self._lines(entries, changed), private=True, sync=True)

    def _lines(self, entries: Iterable[Entry], changed: Collection[str]) -> Iterator[bytes]:
        with self.path.open("rb") as file:
            for entry in entries:
                student = entry.grade.student
                if student in changed or student not in self.places:
                    yield entry.to_line().encode()
                else:
                    at, length = self.places[student]
                    file.seek(at)
                    yield file.read(length).rstrip(b"\n") + b"\n"
