"""The submission of one student or group: its log, chosen without a guess between two, and the answer in any file."""

from __future__ import annotations

import hashlib
import html
import io
import re
import zipfile
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cached_property
from pathlib import Path, PurePosixPath
from typing import Literal

from msgspec import Struct
from msgspec.structs import replace

from gyrodata import diagnostics, quantities, readings, units
from gyrodata.errors import Diagnostic, GyroError, InputError, shown
from gyrodata.grading.submissions.archives import read_file
from gyrodata.readings.roles import name_roles
from gyrodata.readings.source import sheet_rows
from gyrodata.reporting.values import size_text

_MOST_REPORT = 30_000_000  # bytes


class Submission(Struct, frozen=True, dict=True):
    """The submission of one student or group; or one file of it, as far as its name describes it."""

    # key, unique in the class and the same in each download: the number on the platform, else the name of the folder
    # or file
    student: str
    name: str  # to be shown
    # ids on platforms: ``canvas``, ``moodle``, ``username``, ``sid``, ``email``, ``gradescope`` (the number of the
    # submission), ``folder``
    ids: Mapping[str, str]
    source: Path  # folder or zip of the class
    members: tuple[str, ...] = ()  # all files, as names below `source`
    log_name: str | None = None  # the log, as a name below `source`
    log_file: str | None = None  # the name that the student gave the log
    report_names: tuple[str, ...] = ()  # other texts that may contain the answer, as names below `source`
    late: bool = False  # marked late by the platform, or submitted after its due date
    late_seconds: float | None = None  # time after the due date [s]; None if it is not known
    submitted: str | None = None  # ISO 8601; from marks and metadata, never from the clock
    attempt: int = 1  # 1 for the first
    members_of_group: tuple[str, ...] = ()  # keys of all in the group, if the platform gives them
    problem: str | None = None  # why there is nothing to grade; None if there is a log
    feedback_stem: str = ""  # file (without ending) or folder under which the platform accepts feedback

    @cached_property
    def texts(self) -> Mapping[str, bytes | InputError]:
        """The log and the other texts, or why they cannot be read; each is read once."""
        found: dict[str, bytes | InputError] = {}
        for name in filter(None, (*self.report_names, self.log_name)):
            try:
                found[name] = read_file(
                    self.source, name, readings.MAX_BYTES if name == self.log_name else _MOST_REPORT
                )
            except InputError as error:
                found[name] = error
        return found

    def log(self) -> bytes:
        """Return the log; raise InputError if it cannot be read."""
        if self.log_name is None:
            raise InputError.of(diagnostics.NO_SUBMISSION, f"{self.name}: {self.problem}")
        if isinstance(data := self.texts[self.log_name], InputError):
            raise data
        return data

    def reports(self) -> Iterator[tuple[str, bytes]]:
        """Give the other texts that may contain the answer, with names to show."""
        texts = ((shown(name.rpartition("/")[2]), self.texts[name]) for name in self.report_names)
        return ((name, data) for name, data in texts if isinstance(data, bytes))

    def read(self, settings: Mapping[str, str] = {}) -> tuple[readings.Readings, Answers]:
        """Read the log and the reported value; `settings` as in `read_log`.

        The value may be in any row of the log, if no line of the log and no other text reports it.
        """
        name = PurePosixPath(self.log_file or self.log_name or "").name
        log = readings.read_log(self.log(), name=name, settings=settings)
        answers = read_answers(log, self.reports())
        if answers.inertia is None:
            # Lines that begin with a # are read already.
            data = self.log() if self.log()[:2] == b"PK" else re.sub(rb"(?m)^#.*", b"", self.log())
            answers = read_answers(None, [(name, data)])
        unread = [one for data in self.texts.values() if isinstance(data, InputError) for one in data.diagnostics]
        return log, replace(answers, diagnostics=(*answers.diagnostics, *unread))

    @property
    def beside_log(self) -> list[str]:
        """The files for a person to look into: all but the log, or the log if it is the only one."""
        return [name for name in self.members if name != self.log_name] or list(self.members)

    @property
    def feedback_name(self) -> str:
        """Name of a feedback file, without ending, in the zip that the platform accepts."""
        in_folder = self.ids.get("folder") == shown(self.feedback_stem)
        return f"{self.feedback_stem}/feedback" if in_folder else self.feedback_stem

    @cached_property
    def digest(self) -> str:
        """SHA-256 of all that a grade depends on: names and bytes of log and texts, lateness, the problem."""
        about = [self.log_file, self.late, self.late_seconds, self.submitted, self.problem]
        digest = hashlib.sha256(repr(about).encode("utf-8", "replace"))
        try:
            data = self.log()
        except GyroError as error:
            data = str(error).encode("utf-8", "replace")
        digest.update(hashlib.sha256(data).digest())
        for name, data in self.reports():
            digest.update(name.encode("utf-8", "replace") + hashlib.sha256(data).digest())
        return digest.hexdigest()


class Submissions(Struct, frozen=True):
    """A class."""

    lms: str  # the platform: ``canvas``, ``moodle``, ``blackboard``, ``gradescope``, ``folder``; or ``pattern``
    items: tuple[Submission, ...]  # sorted by `Submission.student`
    diagnostics: tuple[Diagnostic, ...] = ()  # files that are left out or cannot be read


# --- the log among the files of a student --------------------------------------------------------------------


TABLES = (".csv", ".tsv")  # endings of tables
PERHAPS_TABLES = (".txt", ".dat", ".xlsx", ".log", ".md")  # endings of logs that are read if there is no table
# Endings of files that may contain the answer.
TEXTS = (".txt", ".md", ".html", ".htm", ".text", ".toml", ".docx", ".xlsx", ".tex")

Attempts = Literal["newest", "oldest"]

# Canvas writes ``lab-1.csv`` for a second ``lab.csv``, browsers and Blackboard write ``lab(1).csv``.
_COPY = re.compile(r"(?P<base>.+?)(?:-(?P<again>\d{1,2})| ?\((?P<copy>\d{1,2})\))(?P<ending>\.[^/]+)")


def ending(name: str) -> str:
    """Return the ending of a file in small letters, without ``.gz``."""
    bare = name.lower().removesuffix(".gz")
    dot = bare.rfind(".")
    return bare[dot:] if dot > bare.rfind("/") else ""


def is_log(name: str) -> bool:
    """Return whether a file may be a log, by its ending."""
    return ending(name) in (*TABLES, *PERHAPS_TABLES)


def is_text(name: str) -> bool:
    """Return whether a file may contain the answer, by its ending."""
    return ending(name) in TEXTS


def choose_log(
    files: Mapping[str, str], sizes: Mapping[str, int], read: Callable[[str], bytes], attempts: Attempts
) -> tuple[str | None, str]:
    """Choose the log among the files of one student.

    Parameters
    ----------
    files : mapping
        The names that the student gave, by the names below the class.
    sizes : mapping
        Stated sizes [byte].
    read : callable
        Reads a file; it is only called if several files may be the log.
    attempts : {"newest", "oldest"}
        Which of several versions of a file is the log.

    Returns
    -------
    tuple
        The log, and a note on the choice or ""; or None, and why there is no log.
    """
    tables = {name: own for name, own in files.items() if ending(own) in TABLES}
    logs = tables or {name: own for name, own in files.items() if is_log(own)}
    if not logs:
        names = sorted(name.rpartition("/")[2] for name in files.values())
        return None, f"no log: only {readings.listing(names)}" if names else "no files"
    numbers: dict[int, str] = {}
    bases = set()
    for name, own in logs.items():
        match = _COPY.fullmatch(own) if len(logs) > 1 else None
        bases.add((match["base"] + match["ending"] if match else own).lower())
        numbers[int(match["again"] or match["copy"]) if match else 0] = name
    if len(bases) == 1 and len(numbers) == len(logs):
        chosen, how = numbers[(min if attempts == "oldest" else max)(numbers)], f"the {attempts}"
    else:
        # If the names differ, the log is the only file that can be read as one.
        fitting: dict[bytes, str] = {}
        for name, own in logs.items():
            with suppress(GyroError):
                data = b"" if _unfit(own, sizes[name]) else read(name)
                if data and data not in fitting and readings.read_log(data, name=own.rpartition("/")[2]).ok:
                    fitting[data] = name
        if len(fitting) != 1:
            why = "several files that read as logs" if fitting else "several files and none of them reads as a log"
            return None, f"{why}: {readings.listing(sorted(logs.values()))}"
        (chosen,), how = fitting.values(), "read as the log"
    if problem := _unfit(logs[chosen], sizes[chosen]):
        return None, problem
    others = readings.listing(sorted(own for name, own in logs.items() if name != chosen))
    return chosen, f"{logs[chosen]} is {how}; left aside: {others}" if len(logs) > 1 else ""


def _unfit(name: str, size: int) -> str:
    """Say why a file cannot be a log, by its size; "" if it can be one."""
    name, most = name.rpartition("/")[2], readings.MAX_BYTES
    if size > most:
        return f"{name} is {size_text(size)}; a log of more than {size_text(most)} is not read"
    return f"{name} is empty" if size == 0 else ""


# --- the reported value: in a line of the log, or of another text ------------------------------------------------


_MOST_LINES, _LONGEST_LINE = 1000, 300


class Answers(Struct, frozen=True):
    """The value that a student reports, from any of the files."""

    inertia: readings.Reported | None = None  # I_zz [kg*m^2]; None if nothing is reported
    diagnostics: tuple[Diagnostic, ...] = ()  # notes on how it was read
    file: str = ""  # name of the file with I_zz


def read_answers(log: readings.Readings | None, reports: Iterable[tuple[str, bytes]] = ()) -> Answers:
    """Find the value that the log reports, or another text if the log reports none.

    `reports` are names and bytes of the other texts. Never raises: a value that cannot be read has a fault.
    """
    if log is not None and "inertia" in log.reported:
        return Answers(_with_u_below(log.reported["inertia"], readings.split_lines(log.source_text)), (), log.name)
    found = [one for name, data in reports for one in _in_text(name, data)]
    if not found:
        return Answers()
    if any(one.u is not None for _, one in found):
        # A value with an uncertainty is the result; the others are steps on the way.
        found = [(place, one) for place, one in found if one.u is not None]
    (place, first), *others = sorted(found, key=lambda one: one[1].fault is not None)
    for other, reported in others:
        if (reported.value, reported.u) != (first.value, first.u):
            problem = f'two values are found: "{first.text}" in {place} and "{reported.text}" in {other}'
            first = readings.Reported("inertia", first.text, fault="given twice", problem=problem, line=first.line)
            break
    note = Diagnostic.of(diagnostics.ANSWER_ELSEWHERE, f'I_zz is read from {place}: "{first.text}"')
    return Answers(first, (note,), place.rpartition(", line ")[0])


def _in_text(name: str, data: bytes) -> list[tuple[str, readings.Reported]]:
    """Find I_zz in a report, each with its place in words."""
    try:
        if ending(name) == ".docx":
            text = _read_docx(data)
        elif ending(name) == ".xlsx":
            rows = (row[:30] for sheet in sheet_rows(data).values() for row in sheet[:_MOST_LINES])
            text = "\n".join(" | ".join(str(cell) for cell in row if cell is not None) for row in rows)
        else:
            text = readings.decode(data, readings.Faults(name))[0]
    except (GyroError, zipfile.BadZipFile, zlib.error, KeyError, OSError, RuntimeError, ValueError):
        return []
    if ending(name) in (".html", ".htm", ".docx"):
        parted = re.sub(r"(?i)<(?:br|/?(?:p|div|li|tr|h\d|table|ul|ol))\b[^<>]*>", "\n", text)
        text = html.unescape(re.sub(r"<[^<>]*>", "", parted)).replace("\u00a0", " ")
        # Lines are counted as they are shown.
        text = re.sub(r"\s*\n\s*", "\n", text).strip()
    lines = readings.split_lines(text)[:_MOST_LINES]
    # Without quotation marks around a value.
    bare = (re.sub(r"(?<!\d)[\"']|[\"'](?!\d)", " ", line) for line in lines)
    return [
        (f"{name}, line {number}", _with_u_below(readings.read_reported("inertia", one, number), lines))
        for number, line in enumerate(bare, 1)
        for one in _find_inertia(line)
    ]


def _with_u_below(read: readings.Reported, lines: Sequence[str]) -> readings.Reported:
    """Add the uncertainty that is in the line below an answer, such as ``u = 0.1e-3 kg m^2``."""
    at = read.line or len(lines)
    below = re.match(_U_BELOW, lines[at]) if read.u is None and at < len(lines) else None
    if below is None:
        return read
    both = readings.read_reported("inertia", " ".join(re.split(r"[\s|]+", f"{read.text} ± {below[1]}")), read.line)
    return both if both.fault is None and both.value == read.value else read


def _read_docx(data: bytes) -> str:
    """Read the text of a Word document as HTML; the cells of a table are separated by ``|``."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive, archive.open("word/document.xml") as file:
        text = file.read(readings.MAX_BYTES).decode("utf-8", "replace")
    text = re.sub(r"</w:p>\s*</w:tc>|<w:tab\b[^<>]*>", " | ", text)
    return re.sub(r"</w:p>|<w:br\b[^<>]*>", "<br>", text)


_LATEX = (
    (r"\\(SI|qty)\{([^{}]*\\pm[^{}]*?)\s*e(-?\d+)\}", r"\\\1{(\2)e\3}"),
    (r"\\(?:SI|qty)\{([^{}]*)\}\{([^{}]*)\}", r"\1 \2"),
    (r"\\kilo\s*\\gram\b", "kg "),
    (r"\\met(?:er|re)\b", " m"),
    (r"\\squared\b", "^2"),
    (r"\\pm(?![a-zA-Z])", "±"),
    (r"\\(?:times|cdot)(?![a-zA-Z])", "·"),
    (r"\\approx(?![a-zA-Z])", "≈"),
    (r"\\(?:begin|end)\{[^{}]*\}|\\[a-zA-Z]+|\\[^a-zA-Z]|[~&$`{}]|\*\*", " "),
    (r"\^\s*\(?\s*([-−]?\d+)(?:\s*\))?", r"^\1"),
    (r"\s+(?=\^)|(?<=_)\s+|(?<=\s)\s+", ""),
)
"""Patterns that turn LaTeX into plain text."""

_UNIT = r"(?i)g[\s·*.⋅/-]{0,3}[cm]?m|n[\s·*.⋅]*m"
_START = r"(?<![\w.,^(+\-−±/])\(?[-+−]?\(?(?:\d|[.,]\d)"
_RESULT = r"(?i)\b(?:results?|answer|ergebnis|résultat|resultado|risultato)[\s:=≈|*_]*$"
_OF_OTHERS = (
    r"(?i)theor|liter|manual|expect|nominal|refer|textbook|accept|true|given|simulat|compar|erwart|attendu"
    r"|\b(?:rod|disk|disc|weights?|stange|scheibe|tige|disque|without|ohne|sans)\b|transvers|differ|decreas|increas"
    r"|(?:uncertainty|errors?) (?:of|in)\b|unsicherheit|incertitude|\bu\s*\(|[Δδσ]"
)
"""Words of values that are not the answer."""

_U_BELOW = (
    r"(?i)[\s|]*(?:u|Δ|δ|σ|delta|sigma|s\.?d\.?|unc\w*|errors?|unsicherheit|incertitude)"
    r"(?:\s*(?:of|in|von|de)?[\s(_]*(?:I|J|I_?zz|inertia)\)?)?\s*[=:|][\s=|]*(\d.*)"
)
"""A line below the answer that contains its uncertainty."""

_CUTS = r"[,;.)|]?\s+|[.,;|]*$"


def _find_inertia(line: str) -> list[str]:
    """Find the values of I_zz in a line of a report, such as ``Our result: I_zz = 4.4e-3 ± 0.1e-3 kg m^2``.

    A value needs its unit, and the name of I_zz or the word "result" in the same sentence in front of it. If some
    values have a ±, only these are returned.
    """
    if len(line) > _LONGEST_LINE or not re.search(r"\d", line):
        return []
    plain = line
    for pattern, text in _LATEX:
        plain = re.sub(pattern, text, plain)
    found, end = list[str](), 0
    for start in (match.start() for match in re.finditer(_START, plain)):
        if start < end or not re.search(_UNIT, plain[start:]):
            continue
        rest = plain[start : start + 120]
        cuts = (rest[: cut.start()].strip(" |_") for cut in reversed(list(re.finditer(_CUTS, rest))))
        answer = next((one for one in cuts if readings.read_reported("inertia", one).fault is None), "")
        if not answer:
            continue
        before = re.split(r"[.;!?]\s", plain[end:start])[-1]
        end = start + len(answer)
        after = re.split(r"[.,;]", plain[end:])[0]
        if re.search(r"(?<![\w.,])\d\S*\s+$", before):
            continue  # two numbers after one name: a person must look
        if not re.search(_OF_OTHERS, before) and not re.search(_OF_OTHERS, after) and _names_inertia(before):
            found.append(answer)
    if not found and (answer := _without_unit(line)):
        return [answer]
    return [one for one in found if readings.read_reported("inertia", one).u] or found


def _names_inertia(text: str) -> bool:
    """Return whether the words in front of a value name I_zz; a single letter must be next to the value."""
    if re.search(_RESULT, text):
        return True
    # Without brackets, and without a verb at the end.
    text = re.sub(r"[\[(][^\])]*[\])]|(?i:\b(?:is|ist|est|es|equals)\W*$)", " ", text)
    words = re.findall(r"[^\W\d_][\w'’]*", text)
    names = [" ".join(words[at : at + count]) for at in range(len(words)) for count in (1, 2, 3)]
    return any(name_roles(name)[0] == ("inertia",) for name in (*(one for one in names if len(one) > 1), *words[-1:]))


_ANSWER_FOLLOWS = r"(?i)(?:[=:≈|\t]|\bis\b)\s*(?=[-+(~≈\s]*[.\d]|(?:about|ca\.?|approx\S*)\s)"
_PLAIN_WORDS = str.maketrans("_", " ", "{}*$`")


def _without_unit(line: str) -> str:
    """Find a value directly behind its name, if the unit is missing, or in brackets behind the name; "" for none."""
    for mark in re.finditer(_ANSWER_FOLLOWS, line):
        before, rest = line[: mark.start()], line[mark.end() :].strip(" \t*_`$|")
        if re.search(_OF_OTHERS, before):
            return ""
        unit = re.search(r"[\[(]([^\])]*)[\])][\s*_`$]*$", before)
        words = re.findall(r"[^\W\d][\w'’]*", before[: unit.start() if unit else None].translate(_PLAIN_WORDS))
        names = (" ".join(words[-count:]) for count in (3, 2, 1) if len(words) >= count)
        name = next((name for name in names if name_roles(name)[0]), "")
        if not name or name_roles(name)[0] != ("inertia",):
            continue
        if unit and units.kinds_of(unit[1]) and (plain := quantities.take_apart(rest)) and not plain.unit:
            rest = f"{rest} {unit[1]}"
        fault = readings.read_reported("inertia", rest).fault
        if fault is None or (len(name) > 1 and fault == "no unit"):
            return rest
    return ""
