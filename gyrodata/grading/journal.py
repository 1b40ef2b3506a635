"""The journal of a class: a line for each grade as soon as it is made, with its inputs.

A run that is stopped at any point loses no grade. The next run grades only what has changed, and can say why.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Literal

from msgspec import Struct, field

from gyrodata import __version__
from gyrodata.diagnostics import GRADES_FOLDER_CANNOT_BE_WRITTEN
from gyrodata.disk import add_to, telling, write_whole
from gyrodata.grading.grade import Grade, from_json, to_json
from gyrodata.grading.rubric import Rubric
from gyrodata.grading.submissions import Submission

JOURNAL = "journal.ndjson"  # in the folder of the grades


class Entry(Struct, frozen=True, kw_only=True):
    """One line: a grade before the class as a whole was compared, and the inputs of the grade."""

    submission: str  # digest of the files, of the student, and of the time
    rubric: str  # digest of the rubric without its references
    reference: str  # digest of the whole rubric
    tool: str  # version of gyrodata
    desk: str = ""  # the value that a person typed in for the submission
    schema: Literal["gyro.journal/1"] = "gyro.journal/1"
    grade: Grade
    lost: str = ""
    """Why the run lost the grade (a time limit, a process that died), so that it is tried again; else ""."""
    figures: Mapping[str, str] = field(default_factory=dict)
    """What each figure shows, in words, by the name of the figure."""
    seen: Mapping[str, str] = field(default_factory=dict)
    """For each line of the desk, the digest of the submission for which it was written."""

    def why_again(self, inputs: Mapping[str, str]) -> str:
        """Say why the submission is graded again with these inputs; "" if the grade is still right."""
        for name, value in inputs.items():
            if (before := getattr(self, name)) != value:
                return f"gyrodata changed from {before} to {value}" if name == "tool" else f"the {name} changed"
        return f"lost last time: {self.lost}" if self.lost else ""


def inputs_of(item: Submission, rubric: Rubric, reported: str) -> dict[str, str]:
    """Give the inputs of a grade, as fields of `Entry`; `reported` is what a person typed in."""
    counts_files = any(criterion.check == "files" for criterion in rubric.criteria)
    text = repr((item.digest, item.name, sorted(item.ids.items()), *(item.members if counts_files else ())))
    digest = hashlib.sha256(text.encode("utf-8", "replace")).hexdigest()
    return {
        "submission": digest,
        "rubric": rubric.judged,
        "reference": rubric.digest,
        "desk": reported,
        "tool": __version__,
    }


class Journal:
    """The file."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.damaged = 0  # lines that cannot be read, as after a power cut
        self.lines = 0  # a run that was stopped may leave two lines of one student
        self.torn = False  # the last line has no end

    def read(self) -> dict[str, Entry]:
        """Return the entries by student; of several the last one counts."""
        entries: dict[str, Entry] = {}
        with telling(self.path.parent, GRADES_FOLDER_CANNOT_BE_WRITTEN):
            data = self.path.read_bytes() if self.path.exists() else b""
        self.torn, lines = data[-1:] not in (b"", b"\n"), data.splitlines()
        self.lines = len(lines)
        for line in lines:
            try:
                entry = from_json(line, Entry)
                entries[entry.grade.student] = entry
            except (ValueError, RecursionError):
                self.damaged += 1
        return entries

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
