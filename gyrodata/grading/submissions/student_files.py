"""Find the log among a student's files, without a guess between two, and the answer in any of them."""

from __future__ import annotations

import html
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from typing import Literal

from msgspec import Struct

from gyrodata.diagnostics import ANSWER_ELSEWHERE
from gyrodata.errors import Diagnostic, GyroError
from gyrodata.quantities import take_apart
from gyrodata.readings import (
    MAX_BYTES,
    Faults,
    Readings,
    Reported,
    decode,
    listing,
    read_log,
    read_reported,
    split_lines,
)
from gyrodata.readings.roles import name_roles
from gyrodata.reporting.values import size_text
from gyrodata.units import kinds_of

TABLES = (".csv", ".tsv")  # endings that say table
PERHAPS_TABLES = (".txt", ".dat", ".xlsx", ".log")  # endings of logs that are read if there is no table
TEXTS = (".txt", ".md", ".html", ".htm", ".text", ".toml")  # in which an answer may stand
ARCHIVES = (".zip", ".rar", ".7z", ".tar", ".tgz")

Attempts = Literal["newest", "oldest"]

_COPY = re.compile(r"(?P<base>.+?)(?:-(?P<again>\d{1,2})| ?\((?P<copy>\d{1,2})\))(?P<ending>\.[^/]+)")


class Choice(Struct, frozen=True):
    """The chosen files of a student."""

    log: str | None  # its name, as it was given
    problem: str | None = None  # why there is no log to grade
    note: str | None = None  # what whoever grades may want to know of the choice


def ending(name: str) -> str:
    """Give the ending of a file in small letters, without a ``.gz`` behind it."""
    bare = name.lower().removesuffix(".gz")
    dot = bare.rfind(".")
    return bare[dot:] if dot > bare.rfind("/") else ""


def is_log(name: str) -> bool:
    """Tell whether a file may be a log, by its ending."""
    return ending(name) in (*TABLES, *PERHAPS_TABLES)


def choose_files(
    files: Mapping[str, str], sizes: Mapping[str, int], read: Callable[[str], bytes], attempts: Attempts
) -> Choice:
    """Choose the log among one student's files.

    `sizes`: Sizes as stated [byte]. `read`: Gives the bytes of a file; asked only where several files may be the log.
    `attempts`: Which of files handed in again (``lab.csv``, ``lab-1.csv``).
    """
    tables = {name: own for name, own in files.items() if ending(own) in TABLES}
    logs = tables or {name: own for name, own in files.items() if is_log(own)}
    if not logs:
        return Choice(None, _nothing(list(files.values())))
    chosen, how = _latest(logs, attempts), f"the {attempts}"
    if chosen is None:
        # Of files of different names the one that reads as a log is the log.
        fitting: dict[bytes, str] = {}
        for name, own in logs.items():
            with suppress(GyroError):
                data = b"" if _unfit(own, sizes[name]) else read(name)
                if data and data not in fitting and read_log(data, name=own.rpartition("/")[2]).ok:
                    fitting[data] = name
        if len(fitting) != 1:
            why = "several files that read as logs" if fitting else "several files and none of them reads as a log"
            return Choice(None, f"{why}: {listing(sorted(logs.values()))}")
        chosen, how = *fitting.values(), "read as the log"
    others = listing(sorted(own for name, own in logs.items() if name != chosen))
    note = f"{logs[chosen]} is {how}; left aside: {others}" if len(logs) > 1 else None
    problem = _unfit(logs[chosen], sizes[chosen])
    return Choice(None if problem else chosen, problem, note)


def _latest(files: Mapping[str, str], attempts: Attempts) -> str | None:
    """Choose among files that are one file handed in again; None where they are not.

    Canvas writes ``lab-1.csv`` for a second ``lab.csv``, browsers and Blackboard ``lab(1).csv``.
    """
    numbers: dict[int, str] = {}
    bases = set()
    for name, own in files.items():
        match = _COPY.fullmatch(own) if len(files) > 1 else None
        bases.add((match["base"] + match["ending"] if match else own).lower())
        numbers[int(match["again"] or match["copy"]) if match else 0] = name
    one_file = len(bases) == 1 and len(numbers) == len(files)
    return numbers[(min if attempts == "oldest" else max)(numbers)] if one_file else None


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


# --- what a student reports: a line of the log, or of another text -----------------------------------------------


_MOST_LINES = 1000


class Answers(Struct, frozen=True):
    """Return the reported value of a student, from any of the files."""

    inertia: Reported | None = None  # I_zz [kg*m^2]; None where nothing is reported
    diagnostics: tuple[Diagnostic, ...] = ()  # what whoever grades should know of how it was read
    file: str = ""  # name of the one in which I_zz stands


def read_answers(readings: Readings | None, reports: Iterable[tuple[str, bytes]] = ()) -> Answers:
    """Find what the log reports, or another text where the log has nothing.

    `reports`: Names and bytes of the other texts. It never raises: a value that cannot be read says so itself.
    """
    if readings is not None and "inertia" in readings.reported:
        return Answers(readings.reported["inertia"], (), readings.name)
    found = _one_inertia([one for name, data in reports for one in _in_text(name, data)])
    if not found:
        return Answers()
    place, inertia = found
    told = Diagnostic.of(ANSWER_ELSEWHERE, f'I_zz is read from {place}: "{inertia.text}"')
    return Answers(inertia, (told,), place.rpartition(", line ")[0])


def _in_text(name: str, data: bytes) -> list[tuple[str, Reported]]:
    """Find I_zz in a report, each with its place in words; tags of a page and quotes around a value are left out."""
    try:
        text = decode(data, Faults(name))[0]
    except GyroError:
        return []
    if ending(name) in (".html", ".htm"):
        parted = re.sub(r"(?i)<(?:br|/?(?:p|div|li|tr|h\d|table|ul|ol))\b[^<>]*>", "\n", text)
        text = html.unescape(re.sub(r"<[^<>]*>", "", parted)).replace("\u00a0", " ")
        # Lines are counted as they are shown.
        text = re.sub(r"\s*\n\s*", "\n", text).strip()
    lines = (re.sub(r"(?<!\d)[\"']|[\"'](?!\d)", " ", line) for line in split_lines(text)[:_MOST_LINES])
    found = [(number, answer) for number, line in enumerate(lines, 1) if (answer := _find_inertia(line))]
    return [(f"{name}, line {number}", read_reported("inertia", answer, number)) for number, answer in found]


_ANSWER_FOLLOWS = r"(?i)(?:[=:≈|\t]|\bis\b)\s*(?=[-+(~≈\s]*[.\d]|(?:about|ca\.?|approx\S*)\s)"
_OF_OTHERS = r"(?i)theor|liter|manual|expect|nominal|refer|textbook|accept|true|given|simulat"
_CUTS = r"[,;.)|]?\s+|[.,;|]*$"
_LONGEST_ANSWER = 300
_PLAIN_WORDS = str.maketrans("_", " ", "{}*$`")


def _find_inertia(line: str) -> str:
    """Find I_zz in a line of a report, ``Our result: I_zz = 4.4e-3 ± 0.1e-3 kg m^2``; "" where there is none.

    Its name must stand before it, and its unit behind it; "I_zz" and "moment of inertia" alone do without.
    """
    if len(line) > _LONGEST_ANSWER or not re.search(r"\d", line):
        return ""
    for mark in re.finditer(_ANSWER_FOLLOWS, line):
        before, rest = line[: mark.start()], line[mark.end() :]
        if re.search(_OF_OTHERS, before):
            return ""
        if unit := re.search(r"[\[(]([^\])]*)[\])][\s*_`$]*$", before):
            before = before[: unit.start()]
        words = re.findall(r"[^\W\d][\w'’]*", before.translate(_PLAIN_WORDS))
        names = (" ".join(words[-count:]) for count in (3, 2, 1) if len(words) >= count)
        name, roles = next(((name, roles) for name in names if (roles := name_roles(name)[0])), ("", ()))
        if roles != ("inertia",):
            continue
        whole = rest.strip(" \t*_`$|")
        if unit and kinds_of(unit[1]) and (plain := take_apart(whole)) and not plain.unit:
            whole = f"{whole} {unit[1]}"
        for cut in reversed(list(re.finditer(_CUTS, whole))):
            answer = whole[: cut.start()].rstrip(" *`$_")
            if read_reported("inertia", answer).fault is None:
                return answer
        if len(name) > 1 and read_reported("inertia", whole).fault == "no unit":
            return whole
    return ""


def _one_inertia(found: list[tuple[str, Reported]]) -> tuple[str, Reported] | None:
    """Take what all places of a report, each named, give for I_zz; two that differ are no answer."""
    # The one that says most of it, where several give one value.
    places = sorted(found, key=lambda one: (one[1].u is None, one[1].fault is not None))
    if not places:
        return None
    place, first = places[0]
    for other, reported in places[1:]:
        if (reported.value, reported.u or first.u) != (first.value, first.u):
            problem = f'two values are found: "{first.text}" in {place} and "{reported.text}" in {other}'
            return place, Reported("inertia", first.text, fault="given twice", problem=problem, line=first.line)
    return place, first
