"""The submission of one student or group, with its log and its answer.

The log is chosen without a guess between two logs, and the answer may be in any file.
"""

from __future__ import annotations

import hashlib
import io
import re
import zipfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from functools import cached_property
from pathlib import Path, PurePosixPath
from typing import Literal

from msgspec import Struct
from msgspec.structs import replace

from gyrodata import fitting, readings
from gyrodata.base.errors import Diagnostic, GyroError, InputError, shown
from gyrodata.base.workers import reads_file
from gyrodata.grading.submissions.answers import (
    Answers,
    read_answers,
    version_of,
)
from gyrodata.grading.submissions.archives import (
    LOGS,
    REPORTS,
    TABLES,
    TEXTS,
    WORKBOOKS,
    ending,
    read_file,
)
from gyrodata.grading.submissions.documents import (
    Document,
    as_log,
    read_document,
    unseen_in,
)
from gyrodata.measurements import measure
from gyrodata.readings.captions import said_in
from gyrodata.readings.conversion import workbook_text
from gyrodata.readings.grid import Row
from gyrodata.readings.remarks import noted_origin

_MOST_REPORT = 30_000_000  # bytes
# largest relative distance of a reported I_zz from that of the log, if turns that are
# not stated are one
_NEAR = 0.1


Attempts = Literal["newest", "oldest"]


class Submission(Struct, frozen=True, dict=True):
    """The submission of one student or group.

    Or one file of it, as far as its name describes it.
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
    feedback_stem: str = (
        ""  # file (without ending) or folder under which the platform accepts feedback
    )
    # the files by their names below `source`, until the log is chosen among them; then
    # none
    parts: Mapping[str, Submission] = {}
    attempts: Attempts = "newest"  # which of several versions of a file is the log
    known_digest: str = ""  # the `digest`, if it is known without reading the files

    @cached_property
    def texts(self) -> Mapping[str, bytes | InputError]:
        """The log and the other texts, or why they cannot be read; each is read once."""
        found: dict[str, bytes | InputError] = {}
        for name in filter(None, (*self.report_names, self.log_name)):
            most = readings.MAX_BYTES if name == self.log_name else _MOST_REPORT
            reads_file(place_of(name))
            try:
                found[name] = read_file(self.source, name, most)
            except InputError as error:
                found[name] = error
        return found

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
                yield shown(name.rpartition("/")[2]), data

    @cached_property
    def documents(self) -> tuple[Document, ...]:
        """The other texts that may contain the answer; each is read once."""
        found = []
        for name in self.report_names:
            if isinstance(data := self.texts[name], bytes):
                reads_file(place_of(name))
                found.append(read_document(shown(name.rpartition("/")[2]), data))
        reads_file("")
        return tuple(found)

    def read(
        self, settings: Mapping[str, str] = {}
    ) -> tuple[readings.Readings, Answers]:
        """Read the log and the reported value; `settings` as in `read_log`.

        The value may be in any row of the log, if no line of the log and no other text
        reports it.
        """
        name, notes = (
            PurePosixPath(self.log_file or self.log_name or "").name,
            list[Diagnostic](),
        )
        log = readings.read_log(data := self.log(), name=name, settings=settings)
        # Another text may say what the log lacks: "all times are for 1/3 turn", "from
        # the surface of the ball".
        lines = (
            (line for one in self.documents for line in one.lines)
            if log.columns
            else ()
        )
        said = [
            line
            for line in lines
            if (not log.ok and said_in(Row(1, [line])))
            or noted_origin(line) == "surface"
        ]
        reads_file(place_of(self.log_name or ""))
        if said:
            text = (workbook_text if data[:2] == b"PK" else readings.decode)(
                data, readings.Faults(name)
            )[0]
            more = (text + "".join(f"\n# {line}" for line in said)).encode()
            again = readings.read_log(more, name=name, settings=settings)
            errors = [
                sum(one.severity == "error" for one in found.diagnostics)
                for found in (again, log)
            ]
            # A log whose positions count from the surface is refused rather than read
            # as if they did not.
            if log.ok or again.ok or errors[0] < errors[1]:
                data, log = more, again
                notes.append(
                    Diagnostic.named(
                        "read_elsewhere", name, said=readings.listing(said, 4)
                    )
                )
        answers = read_answers(log, self.documents, unseen_in(name, data))
        # All that follows is about the log, also when it is analysed.
        reads_file(place_of(self.log_name or ""))
        if answers.inertia is None:
            own = read_answers(None, [(name, self.log())])
            answers = replace(own, unread=answers.unread)
        if (
            not log.ok
            and "time" in log.columns
            and answers.inertia
            and answers.inertia.value
        ):
            again = readings.read_log(
                data, name=name, settings={**settings, "turns": "1"}
            )
            if (
                again.ok
                and abs(
                    fitting.rough_inertia(measure(again)) / answers.inertia.value - 1
                )
                < _NEAR
            ):
                log = again
                notes.append(Diagnostic.named("turns_by_answer", name))
        log = replace(log, diagnostics=(*log.diagnostics, *notes)) if notes else log
        unread = [
            one
            for data in self.texts.values()
            if isinstance(data, InputError)
            for one in data.diagnostics
        ]
        return log, replace(answers, unread=(*answers.unread, *unread))

    @property
    def beside_log(self) -> list[str]:
        """The files for a person to look into.

        They are all files except the log, or the log if it is the only file.
        """
        return [name for name in self.members if name != self.log_name] or list(
            self.members
        )

    @property
    def feedback_name(self) -> str:
        """Name of a feedback file, without ending, in the zip that the platform accepts."""
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
        about = repr(
            [self.log_file, self.late, self.late_seconds, self.submitted, self.problem]
        )
        try:
            data = self.log()
        except GyroError as error:
            data = str(error).encode("utf-8", "replace")
        parts = [(about, data), *self.reports()]
        named = (
            name.encode("utf-8", "replace") + hashlib.sha256(data).digest()
            for name, data in parts
        )
        return hashlib.sha256(b"".join(named)).hexdigest()


class Submissions(Struct, frozen=True):
    """A class."""

    # the platform: ``canvas``, ``moodle``, ``blackboard``, ``gradescope``, ``folder``;
    # or ``pattern``
    lms: str
    items: tuple[Submission, ...]  # sorted by `Submission.student`
    diagnostics: tuple[
        Diagnostic, ...
    ] = ()  # files that are left out or cannot be read


def place_of(name: str) -> str:
    """Describe a file by its name below the class: "lab.csv", or "lab.csv in lab.zip"."""
    parts = [shown(part.rpartition("/")[2])[:100] for part in name.split("//")]
    return " in ".join(reversed(parts))


# --- the log among the files of a student ---


Logs = Mapping[str, readings.Readings]

# Canvas writes ``lab-1.csv`` for a second ``lab.csv``, browsers and Blackboard write
# ``lab(1).csv``.
_COPY = re.compile(r"(?P<base>.+?)(?:-| ?\()(?P<number>\d{1,2})\)?(?P<ending>\.[^/]+)")


def choose_log(
    files: Mapping[str, str], read: Callable[[str], bytes], attempts: Attempts
) -> tuple[str | None, str]:
    """Choose the log among the files of one student.

    Parameters
    ----------
    files : mapping
        The names that the student gave, by the names below the class.
    read : callable
        Reads a file.
    attempts : {"newest", "oldest"}
        Which of several versions of a file is the log.

    Returns
    -------
    tuple
        The log, and a note on the choice or ""; or None, and why there is no log.
    """
    tables = {name: own for name, own in files.items() if ending(own) in TABLES}
    plain = tables or {name: own for name, own in files.items() if ending(own) in LOGS}
    logs = tables or {
        name: own for name, own in files.items() if ending(own) in (*LOGS, *REPORTS)
    }
    copies = {name: _COPY.fullmatch(own) for name, own in logs.items()}
    bases = {
        match["base"] + match["ending"] if match else logs[name]
        for name, match in copies.items()
    }
    numbers = {
        int(match["number"]) if match else 0: name for name, match in copies.items()
    }
    best = min if attempts == "oldest" else max
    left, how = logs, f"the {attempts}"
    if (
        len({base.lower() for base in bases}) == 1
        and len(numbers) == len(logs)
        and (tables or len(logs) > 1)
    ):
        chosen = numbers[best(numbers)]
    else:
        # If the names differ, the log is the only file that can be read as one.
        fitting, tried, texts = (
            dict[str, readings.Readings](),
            dict[bytes, str](),
            list[tuple[str, bytes]](),
        )
        nearly: list[str] = []  # with columns of a log
        for name, own in logs.items():
            reads_file(place_of(name))
            with suppress(GyroError):
                texts.append((own.rpartition("/")[2], read(name)))
                log = readings.read_log(data := as_log(*texts[-1]), name=texts[-1][0])
                if log.columns and tried.setdefault(data, name) == name:
                    nearly.append(name)
                    fitting |= {name: log} if log.ok else {}
        chosen, how = (
            (*fitting, "read as the log")
            if len(fitting) == 1
            else _latest(fitting, files, best)
        )
        left = {
            name: own
            for name, own in logs.items()
            if name in fitting or ending(own) not in TEXTS
        }
        if fitting and not chosen:
            return (
                None,
                (
                    f"several files that read as logs: "
                    f"{readings.listing(sorted(files[one] for one in fitting))}"
                ),
            )
        if not fitting:
            if not tried and (answer := read_answers(None, _named(texts))).inertia:
                return None, f"no log; {answer.file} has the answer"
            if len(plain) > 1 and len(nearly) != 1:
                names = sorted(plain.values())
                return (
                    None,
                    f"several files and none of them reads as a log: {readings.listing(names)}",
                )
            chosen = nearly[0] if len(nearly) == 1 else next(iter(plain), "")
    if not chosen:
        names = sorted(name.rpartition("/")[2] for name in files.values())
        return None, f"no log: only {readings.listing(names)}" if names else "no files"
    name = logs[chosen].rpartition("/")[2]
    with suppress(InputError):  # why it cannot be read is told when it is graded
        if not (data := read(chosen)):
            return None, f"{name} is empty"
        if ending(name) in WORKBOOKS and not zipfile.is_zipfile(io.BytesIO(data)):
            return (
                None,
                (
                    f"{name} is damaged, such as a file that was not uploaded to its "
                    f"end; hand it in again"
                ),
            )
    others = sorted(own for name, own in left.items() if name != chosen)
    return (
        chosen,
        f"{logs[chosen]} is {how}; left aside: {readings.listing(others)}"
        if others
        else "",
    )


def _named(texts: Iterable[tuple[str, bytes]]) -> Iterator[tuple[str, bytes]]:
    """Give texts one by one, and note the name of each while it is read."""
    for name, data in texts:
        reads_file(shown(name)[:100])
        yield name, data
    reads_file("")


def _latest(
    logs: Logs, files: Mapping[str, str], best: Callable[..., str]
) -> tuple[str, str]:
    """Choose among versions of a log by words in their names.

    If the names do not help, the version with all rows is chosen. The result is "" if
    there is no such version.
    """
    versions = {name: version_of(files[name]) for name in logs}
    ranks = {name: rank for name, (rank, _) in versions.items()}
    bases = {base for _, base in versions.values()} - {""}
    if 0 < len(logs) == len(set(ranks.values())) and len(bases) <= 1:
        return best(ranks, key=lambda name: ranks[name]), "the latest by its name"
    columns = {
        name: [column.values for _, column in sorted(log.columns.items())]
        for name, log in logs.items()
    }
    rows = {name: set(zip(*some, strict=True)) for name, some in columns.items()}
    whole = [name for name in rows if all(rows[name] >= some for some in rows.values())]
    answers = {
        name: logs[name].reported["inertia"].text
        for name in whole
        if "inertia" in logs[name].reported
    }
    return (
        ([*answers, *whole][0], "the one with all rows")
        if whole and len({*answers.values()}) < 2
        else ("", "")
    )
