"""The submission of one student or group, with its log and its answer.

The log is chosen without a guess between two logs, and the answer may be in any file.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path, PurePosixPath

from msgspec import Struct
from msgspec.structs import replace

from gyrodata import readings
from gyrodata.base.errors import Diagnostic, GyroError, InputError, shown
from gyrodata.base.workers import reads_file
from gyrodata.grading.submissions.answers import (
    Answers,
    read_answers,
)
from gyrodata.grading.submissions.archives import TABLES, ending, place_of, read_file
from gyrodata.grading.submissions.documents import (
    Document,
    as_log,
    hides_cells,
    read_document,
)
from gyrodata.grading.submissions.log_choice import Attempts
from gyrodata.readings.captions import statements_in
from gyrodata.readings.conversion import workbook_text
from gyrodata.readings.grid import Row
from gyrodata.readings.notes import noted_origin

_MOST_REPORT = 30_000_000  # bytes


class Submission(Struct, frozen=True, dict=True):
    """The submission of one student or group.

    First it is only listed: `parts` contains its files, each as a submission that says
    what the name of this file says; nothing is open. Then it is in one of three states:

    * `log_name` is the log, which can be graded (`choose`);
    * `problem` says why there is no log to grade (`choose`);
    * `problem` and `lost` say why this run could not open the files (`unread`): the
      next run tries again.
    """

    # key, unique in the class and the same in each download: the number on the
    # platform, else the name of the folder or file
    student: str
    name: str  # to be shown
    # ids on platforms: ``canvas``, ``moodle``, ``username``, ``sid``, ``email``,
    # ``gradescope`` (the number of the submission), ``folder``
    ids: Mapping[str, str]
    source: Path  # folder or zip of the class
    members: tuple[str, ...] = ()  # all files, as names below `source`
    log_name: str | None = None  # the log, as a name below `source`
    log_file: str | None = None  # the name that the student gave the log
    report_names: tuple[
        str, ...
    ] = ()  # other texts that may contain the answer, as names below `source`
    late: bool = False  # marked late by the platform, or submitted after its due date
    late_seconds: float | None = (
        None  # time after the due date [s]; None if it is not known
    )
    submitted: str | None = (
        None  # ISO 8601; from marks and metadata, never from the clock
    )
    members_of_group: tuple[
        str, ...
    ] = ()  # keys of all in the group, if the platform gives them
    problem: str | None = None  # why there is nothing to grade; None if there is a log
    lost: str = ""  # why this run could not open the files; "" if it could
    # file (without ending) or folder under which the platform accepts feedback; "" for
    # a student who handed in nothing: the platform accepts none
    feedback_stem: str = ""
    # the files by their names below `source`, until the log is chosen among them; then
    # none
    parts: Mapping[str, Submission] = {}
    attempts: Attempts = "newest"  # which of several versions of a file is the log
    known_digest: str = ""  # the `digest`, if it is known without reading the files
    log_digest: str = ""  # of the log alone, if it is known
    original_digest: str = ""  # with the student's own log, if a person corrected it
    partner: str = ""  # as `partners_in` returns it; only of a submission without a log
    log_of: str = ""  # the partner or group whose log it is; "" for an own log
    shares_answer: bool = False  # the answer in such a log is that of the student too

    @cached_property
    def texts(self) -> Mapping[str, bytes | InputError]:
        """The log and the other texts, or why they cannot be read."""
        texts: dict[str, bytes | InputError] = {}
        for name in filter(None, (*self.report_names, self.log_name)):
            most = readings.MAX_BYTES if name == self.log_name else _MOST_REPORT
            reads_file(place_of(name))
            try:
                texts[name] = read_file(self.source, name, most)
            except InputError as error:
                texts[name] = error
        return texts

    def log(self) -> bytes:
        """Return the log; raise InputError if it cannot be read."""
        if self.log_name is None:
            raise InputError.named(
                "nothing_handed_in", why=f"{self.name}: {self.problem}"
            )
        if isinstance(data := self.texts[self.log_name], InputError):
            raise data
        reads_file(place_of(self.log_name))
        return as_log(self.log_file or self.log_name, data)

    def reports(self) -> Iterator[tuple[str, bytes]]:
        """Give the other texts that may contain the answer, with names to show."""
        for name in self.report_names:
            if isinstance(data := self.texts[name], bytes):
                reads_file(place_of(name))
                yield shown(name.rpartition("/")[2]), data
        reads_file("")

    @cached_property
    def documents(self) -> tuple[Document, ...]:
        """The other texts that may contain the answer; each is read once."""
        return tuple(read_document(*report) for report in self.reports())

    def read(
        self, settings: Mapping[str, str] = {}
    ) -> tuple[readings.Readings, Answers]:
        """Read the log and the reported value; `settings` as in `read_log`.

        The value may be in any row of the log, if no line of the log and no other text
        reports it.
        """
        name = PurePosixPath(self.log_file or self.log_name or "").name
        data = self.log()
        log = readings.read_log(data, name=name, settings=settings)
        completed = None
        if log.columns:
            completed = self._completed(data, log, settings)
        reads_file(place_of(self.log_name or ""))
        if completed is not None:
            data, log = completed
        return log, self._answers(log, name, data)

    def _completed(
        self, data: bytes, log: readings.Readings, settings: Mapping[str, str]
    ) -> tuple[bytes, readings.Readings] | None:
        """Read the log again with what another text says about it.

        Such a text is "all times are for 1/3 turn", or "from the surface of the ball".
        The result is None if no text helps; else the log contains a note with the texts.
        """
        remarks = []
        for document in self.documents:
            remarks += [line for line in document.lines if _is_about_log(line, log.ok)]
        if not remarks:
            return None
        decode = workbook_text if data[:2] == b"PK" else readings.decode
        text = decode(data, readings.Faults(log.name))[0]
        notes = "".join(f"\n# {line}" for line in remarks)
        more = f"{text}{notes}".encode()
        again = readings.read_log(more, name=log.name, settings=settings)
        # A log whose positions count from the surface is refused rather than read as if
        # they did not.
        is_better = log.ok or again.ok or _errors(again) < _errors(log)
        if not is_better:
            return None
        quoted = readings.listing(remarks, 4)
        note = Diagnostic.named("read_elsewhere", log.name, quoted=quoted)
        return more, replace(again, diagnostics=(*again.diagnostics, note))

    def _answers(self, log: readings.Readings, name: str, data: bytes) -> Answers:
        """Return the reported value, and which texts cannot be read."""
        answers = Answers()
        if self.log_of:
            answers = read_answers(None, self.documents)
        # The answer in the log of a partner is that of the partner.
        if answers.inertia is None and (self.shares_answer or not self.log_of):
            answers = self._answers_with_log(log, name, data)
        # All that follows is about the log, also when it is analysed.
        reads_file(place_of(self.log_name or ""))
        unread = list(answers.unread)
        for text in self.texts.values():
            if isinstance(text, InputError):
                unread += text.diagnostics
        return replace(answers, unread=tuple(unread))

    def _answers_with_log(
        self, log: readings.Readings, name: str, data: bytes
    ) -> Answers:
        """Return the value that the log or another text reports."""
        if hides_cells(name, data):
            # A text leaves out whatever nobody sees.
            return read_answers(None, [*self.documents, (name, self.log())])
        return read_answers(log, self.documents)

    @property
    def files_to_read(self) -> list[str]:
        """The files for a person to look into.

        They are the texts besides the log; or the log that is graded, and not an
        earlier one; or all files.
        """
        others = [name for name in self.members if name != self.log_name]
        texts = [name for name in others if ending(name) not in TABLES]
        if texts or self.log_name is None:
            return texts or others
        return [self.log_name] if self.log_name in self.members else others

    @property
    def feedback_name(self) -> str:
        """Name of a feedback file, without ending, for the platform."""
        in_folder = self.ids.get("folder") == shown(self.feedback_stem)
        return f"{self.feedback_stem}/feedback" if in_folder else self.feedback_stem

    @cached_property
    def digest(self) -> str:
        """SHA-256 of everything on which a grade depends.

        It covers the names and bytes of the log and the texts, the lateness, and the
        problem.
        """
        if self.known_digest:
            return self.known_digest
        handed_in = [self.late, self.late_seconds, self.submitted, self.problem]
        about = repr([self.log_file, *handed_in])
        try:
            data = self.log()
        except GyroError as error:
            data = str(error).encode("utf-8", "replace")
        parts = [(about, data), *self.reports()]
        digest = hashlib.sha256()
        for name, data in parts:
            digest.update(name.encode("utf-8", "replace"))
            digest.update(hashlib.sha256(data).digest())
        return digest.hexdigest()


class Submissions(Struct, frozen=True):
    """A class."""

    # the platform: ``canvas``, ``moodle``, ``blackboard``, ``gradescope``, ``folder``
    lms: str
    items: tuple[Submission, ...]  # sorted by `Submission.student`
    diagnostics: tuple[
        Diagnostic, ...
    ] = ()  # files that are left out or cannot be read


def _is_about_log(line: str, complete: bool) -> bool:
    """Return whether a line of another text may say what a log lacks.

    A complete log only lacks the place from which its positions count.
    """
    if noted_origin(line) == "surface":
        return True
    return not complete and bool(statements_in(Row(1, [line])))


def _errors(log: readings.Readings) -> int:
    return sum(diagnostic.severity == "error" for diagnostic in log.diagnostics)
