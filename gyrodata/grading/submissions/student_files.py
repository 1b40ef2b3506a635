"""A student's files: which is the log, which holds the answers, never guessed where two will do; and what those say."""

from __future__ import annotations

import difflib
import html
import re
import tomllib
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from msgspec import Struct, field

from gyrodata.diagnostics import (
    ANSWER_ELSEWHERE,
    ANSWER_NOT_ASKED_FOR,
    ANSWERS_CANNOT_BE_READ,
    ANSWERS_CONTRADICT_LOG,
    ANSWERS_NO_TOML,
)
from gyrodata.errors import Diagnostic, GyroError
from gyrodata.grading.submissions.archives import size_text
from gyrodata.grading.toml_table import find_places
from gyrodata.readings import (
    MAX_BYTES,
    REPORTED_KINDS,
    Faults,
    Readings,
    Reported,
    canonical_key,
    decode,
    find_inertia,
    listing,
    one_inertia,
    read_log,
    read_reported,
    split_lines,
)

TABLES = (".csv", ".tsv")  # endings that say table
PERHAPS_TABLES = (".txt", ".dat", ".xlsx", ".log")  # endings of logs that are looked at where there is no table
ARCHIVES = (".zip", ".rar", ".7z", ".tar", ".tgz")

_ANSWERS = re.compile(r"(?:.*[-_. ])?answers(?:[-_ ]?\(?\d+\)?)?(?:\.toml|\.txt|\.toml\.txt)", re.IGNORECASE)
_COPY = re.compile(r"(?P<base>.+?)(?:-(?P<again>\d{1,2})| ?\((?P<copy>\d{1,2})\))(?P<ending>\.[^/]+)")


class Choice(Struct, frozen=True):
    """What was chosen of a student's files."""

    log: str | None  # names, as they were given
    answers: str | None
    problem: str | None = None  # why there is no log to grade
    note: str | None = None  # what whoever grades may want to know of the choice

    def reports(self, files: Mapping[str, str]) -> list[str]:
        """Name the other texts in which an answer may stand."""
        return [name for name, own in files.items() if name not in (self.log, self.answers) and is_report(own)]


def ending(name: str) -> str:
    """Give the ending of a file in small letters, without a ``.gz`` behind it."""
    bare = name.lower().removesuffix(".gz")
    dot = bare.rfind(".")
    return bare[dot:] if dot > bare.rfind("/") else ""


def is_answers(name: str) -> bool:
    """Tell whether a file holds reported values: ``answers.toml``, ``jdoe_answers.toml``, ``answers.toml.txt``."""
    return _ANSWERS.fullmatch(name.rpartition("/")[2]) is not None


def is_log(name: str) -> bool:
    """Tell whether a file may be a log, by its ending."""
    return ending(name) in (*TABLES, *PERHAPS_TABLES) and not is_answers(name)


def is_report(name: str) -> bool:
    """Tell whether a file is text in which an answer may stand, by its ending."""
    return ending(name) in (".txt", ".md", ".html", ".htm", ".text") and not is_answers(name)


def choose_files(
    files: Mapping[str, str], sizes: Mapping[str, int], read: Callable[[str], bytes], oldest: bool = False
) -> Choice:
    """Choose the log and the answers among one student's files.

    `sizes`: Sizes as stated [byte]. `read`: Gives the bytes of a file; asked only where several files may be the log.
    `oldest`: Of files handed in again (``lab.csv``, ``lab-1.csv``) the first instead of the last.
    """
    named = {name: own for name, own in files.items() if is_answers(own)}
    named = named or {name: own for name, own in files.items() if ending(own) == ".toml"}
    answers = _latest(named, oldest)
    note = _dropped(named, answers, oldest)
    tables = {name: own for name, own in files.items() if is_log(own) and ending(own) in TABLES}
    logs = tables or {name: own for name, own in files.items() if is_log(own)}
    if not logs:
        return Choice(None, answers, _nothing(list(files.values())), note)
    last = _latest(logs, oldest)
    if last is not None:
        problem = _unfit(files[last], sizes[last])
        note = _dropped(logs, last, oldest) or note
        return Choice(None if problem else last, answers, problem, note)
    return _among_several(logs, answers, sizes, read)


def _among_several(
    logs: Mapping[str, str], answers: str | None, sizes: Mapping[str, int], read: Callable[[str], bytes]
) -> Choice:
    """Look into files of different names: the one that reads as a log is the log."""
    contents: dict[bytes, str] = {}
    for name in logs:
        if not _unfit(logs[name], sizes[name]):
            try:
                contents.setdefault(read(name), name)
            except GyroError:
                continue
    fitting = [name for data, name in contents.items() if _reads(data, logs[name])]
    if len(fitting) == 1:
        others = listing(sorted(own for name, own in logs.items() if name != fitting[0]))
        return Choice(fitting[0], answers, note=f"{logs[fitting[0]]} is read as the log; left aside: {others}")
    shown = listing(sorted(logs.values()))
    why = "several files that read as logs" if fitting else "several files and none of them reads as a log"
    return Choice(None, answers, f"{why}: {shown}")


def _reads(data: bytes, name: str) -> bool:
    try:
        return read_log(data, name=name.rpartition("/")[2]).ok
    except GyroError:
        return False


def _latest(files: Mapping[str, str], oldest: bool) -> str | None:
    """Choose among files that are one file handed in again; None where they are not, or there are none.

    Canvas writes ``lab-1.csv`` for a second ``lab.csv``, browsers and Blackboard ``lab(1).csv``.
    """
    numbers: dict[str, int] = {}
    bases = set()
    for name, own in files.items():
        match = _COPY.fullmatch(own)
        if match and len(files) > 1:
            bases.add((match["base"] + match["ending"]).lower())
            numbers[name] = int(match["again"] or match["copy"])
        else:
            bases.add(own.lower())
            numbers[name] = 0
    if len(bases) != 1 or len(set(numbers.values())) != len(numbers):
        return None
    return (min if oldest else max)(numbers, key=numbers.__getitem__)


def _dropped(files: Mapping[str, str], taken: str | None, oldest: bool) -> str | None:
    if len(files) < 2:
        return None
    if taken is None:
        return f"none of {listing(sorted(files.values()))} is read: they are several"
    others = listing(sorted(own for name, own in files.items() if name != taken))
    return f"{files[taken]} is the {'oldest' if oldest else 'newest'}; left aside: {others}"


def _unfit(name: str, size: int) -> str | None:
    shown = name.rpartition("/")[2]
    if size > MAX_BYTES:
        return f"{shown} is {size_text(size)}; a log of more than {size_text(MAX_BYTES)} is not read"
    return f"{shown} is empty" if size == 0 else None


def _nothing(names: Sequence[str]) -> str:
    own = sorted(name.rpartition("/")[2] for name in names)
    if not own:
        return "no files"
    archives = [name for name in own if ending(name) in ARCHIVES]
    if archives:
        return f"no log: {listing(archives)} is an archive within the submission and is not opened; unpack it"
    return f"no log: only {listing(own)}"


# --- what a student reports: the ``# reported_…`` lines of the log and the answers, as one ------------------------


_FILE = "answers.toml"
_TABLES = ("reported", "answers")
_UNCERTAINTIES = ("u", "uncertainty", "error", "standard_uncertainty")
_MOST_LINES = 1000


class Answers(Struct, frozen=True):
    """What a student reports, from wherever it stands."""

    inertia: Reported | None = None  # I_zz [kg*m^2]; None where nothing is reported
    # all else by its key: ``imbalance`` [N*m], ``timing_bias`` [s], ``exponent`` [1], and what the student
    # added
    others: Mapping[str, Reported] = field(default_factory=dict)
    diagnostics: tuple[Diagnostic, ...] = ()  # what whoever grades should know of how it was read
    file: str = ""  # name of the one in which I_zz stands


def read_answers(readings: Readings | None, toml: bytes | None, reports: Iterable[tuple[str, bytes]] = ()) -> Answers:
    """Bring together what the log and the answers file report; the file wins, and a difference is told.

    `toml`: The answers file: ``inertia = "4.4e-3 ± 0.1e-3 kg m^2"`` for each value, or a table with ``value``, ``u``
    and ``unit``; at the top or in ``[reported]``. One that is no TOML is read line by line. `reports`: Names and bytes
    of other texts, in which I_zz is looked for where neither of the two has it. It never raises: a value that cannot be
    read says so itself.
    """
    found: dict[str, Reported] = dict(readings.reported) if readings is not None else {}
    told: list[Diagnostic] = []
    file = readings.name if readings is not None and "inertia" in found else ""
    if toml is not None:
        for key, reported in _read_file(toml, told).items():
            before = found.get(key)
            if before is not None and (before.value, before.u) != (reported.value, reported.u):
                message = f'{key} is "{before.text}" in the log and "{reported.text}" in {_FILE}; the latter is graded'
                told.append(Diagnostic.of(ANSWERS_CONTRADICT_LOG, message, "", _FILE, reported.line))
            found[key] = reported
            file = _FILE if key == "inertia" else file
    inertia = found.pop("inertia", None)
    elsewhere = (
        one_inertia([one for name, data in reports for one in _in_text(name, data)]) if inertia is None else None
    )
    if elsewhere:
        place, inertia = elsewhere
        file = place.rpartition(", line ")[0]
        told.append(Diagnostic.of(ANSWER_ELSEWHERE, f'I_zz is read from {place}: "{inertia.text}"'))
    return Answers(inertia, found, tuple(told), file)


def _in_text(name: str, data: bytes) -> list[tuple[str, Reported]]:
    """Find I_zz in a report, each with its place in words; tags of a page are left out."""
    try:
        text = decode(data, Faults(name))[0]
    except GyroError:
        return []
    if ending(name) in (".html", ".htm"):
        parted = re.sub(r"(?i)<(?:br|/?(?:p|div|li|tr|h\d|table|ul|ol))\b[^<>]*>", "\n", text)
        text = html.unescape(re.sub(r"<[^<>]*>", "", parted)).replace("\u00a0", " ")
        # Lines are counted as they are shown.
        text = re.sub(r"\s*\n\s*", "\n", text).strip()
    lines = list(enumerate(split_lines(text)[:_MOST_LINES], 1))
    found = [(number, answer) for number, line in lines if (answer := find_inertia(line))]
    return [(f"{name}, line {number}", read_reported("inertia", answer, number)) for number, answer in found]


def _read_file(data: bytes, told: list[Diagnostic]) -> dict[str, Reported]:
    try:
        text = decode(data, Faults(_FILE))[0]
    except GyroError as error:
        message = f"{_FILE} cannot be read: {error.diagnostics[0].message}"
        told.append(Diagnostic.of(ANSWERS_CANNOT_BE_READ, message, file=_FILE))
        return {}
    try:
        # Digits as they are typed: 4.40 is not 4.4.
        entries = _flat(tomllib.loads(text, parse_float=str), ())
        places = find_places("\n".join(split_lines(text)))
        lines = [next((places[path[:n]].line for n in (2, 1) if path[:n] in places), None) for path, _ in entries]
        values = [(path[-1], value, line) for (path, value), line in zip(entries, lines, strict=True)]
        values = values or _read_lines(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        message = f"{_FILE} is no TOML and is read line by line: {error}"
        hint = 'put each value in quotes: inertia = "4.4e-3 ± 0.1e-3 kg m^2"'
        told.append(Diagnostic.of(ANSWERS_NO_TOML, message, hint, _FILE))
        values = _read_lines(text)
    found: dict[str, Reported] = {}
    for key, value, line in values:
        reported = read_reported(key, value, line)
        _tell_misspelt(key, reported, told)
        found.setdefault(reported.key, reported)
    return found


def _flat(table: Mapping[str, Any], path: tuple[str, ...]) -> list[tuple[tuple[str, ...], str]]:
    """Give each answer as the text that it could have been written as."""
    found: list[tuple[tuple[str, ...], str]] = []
    for key, value in table.items():
        if isinstance(value, dict) and key.lower() in _TABLES and not path:
            found += _flat(value, (key,))
        elif isinstance(value, dict):
            parts = {name.lower(): str(part) for name, part in value.items()}
            spread = next((f" ± {parts[name]}" for name in _UNCERTAINTIES if name in parts), "")
            found.append(((*path, key), f"{parts.get('value', '')}{spread} {parts.get('unit', '')}".strip()))
        else:
            found.append(((*path, key), str(value)))
    return found


_LINE = re.compile(r"[#\s]*([^\W\d][\w .-]{0,60}?)\s*[:=]\s*(.+?)\s*")


def _read_lines(text: str) -> list[tuple[str, str, int | None]]:
    """Read ``inertia = 4.4e-3 ± 0.1e-3 kg m^2`` and ``inertia: …`` without quotes."""
    found: list[tuple[str, str, int | None]] = []
    for number, line in enumerate(split_lines(text)[:_MOST_LINES], 1):
        match = _LINE.fullmatch(line[:500])
        if match:
            value = match[2].partition(" #")[0].strip().strip("\"'").strip()
            found.append((re.sub(r"[\s.-]+", "_", match[1]), value, number))
    return found


def _tell_misspelt(key: str, reported: Reported, told: list[Diagnostic]) -> None:
    if reported.key in REPORTED_KINDS:
        return
    close = difflib.get_close_matches(canonical_key(key), REPORTED_KINDS, n=1, cutoff=0.75)
    if close:
        message = f'"{key}" is not asked for: was {close[0]} meant?'
        told.append(Diagnostic.of(ANSWER_NOT_ASKED_FOR, message, "", _FILE, reported.line))
