"""Find the log among the files of a student, without a guess between two, and the answer in any of the files."""

from __future__ import annotations

import html
import re
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from typing import Literal

from msgspec import Struct

from gyrodata import quantities, readings, units
from gyrodata.diagnostics import ANSWER_ELSEWHERE
from gyrodata.errors import Diagnostic, GyroError
from gyrodata.readings.roles import name_roles
from gyrodata.reporting.values import size_text

TABLES = (".csv", ".tsv")  # endings of tables
PERHAPS_TABLES = (".txt", ".dat", ".xlsx", ".log")  # endings of logs that are read if there is no table
TEXTS = (".txt", ".md", ".html", ".htm", ".text", ".toml")  # files that may contain the answer

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
        return Answers(log.reported["inertia"], (), log.name)
    found = [one for name, data in reports for one in _in_text(name, data)]
    if not found:
        return Answers()
    # If several places give one value, the place with u is taken.
    (place, first), *others = sorted(found, key=lambda one: (one[1].u is None, one[1].fault is not None))
    for other, reported in others:
        if (reported.value, reported.u or first.u) != (first.value, first.u):
            problem = f'two values are found: "{first.text}" in {place} and "{reported.text}" in {other}'
            first = readings.Reported("inertia", first.text, fault="given twice", problem=problem, line=first.line)
            break
    note = Diagnostic.of(ANSWER_ELSEWHERE, f'I_zz is read from {place}: "{first.text}"')
    return Answers(first, (note,), place.rpartition(", line ")[0])


def _in_text(name: str, data: bytes) -> list[tuple[str, readings.Reported]]:
    """Find I_zz in a report, each with its place in words."""
    try:
        text = readings.decode(data, readings.Faults(name))[0]
    except GyroError:
        return []
    if ending(name) in (".html", ".htm"):
        parted = re.sub(r"(?i)<(?:br|/?(?:p|div|li|tr|h\d|table|ul|ol))\b[^<>]*>", "\n", text)
        text = html.unescape(re.sub(r"<[^<>]*>", "", parted)).replace("\u00a0", " ")
        # Lines are counted as they are shown.
        text = re.sub(r"\s*\n\s*", "\n", text).strip()
    found = []
    for number, line in enumerate(readings.split_lines(text)[:_MOST_LINES], 1):
        # Without quotation marks around a value.
        if answer := _find_inertia(re.sub(r"(?<!\d)[\"']|[\"'](?!\d)", " ", line)):
            found.append((f"{name}, line {number}", readings.read_reported("inertia", answer, number)))
    return found


_ANSWER_FOLLOWS = r"(?i)(?:[=:≈|\t]|\bis\b)\s*(?=[-+(~≈\s]*[.\d]|(?:about|ca\.?|approx\S*)\s)"
_OF_OTHERS = r"(?i)theor|liter|manual|expect|nominal|refer|textbook|accept|true|given|simulat"
_CUTS = r"[,;.)|]?\s+|[.,;|]*$"
_PLAIN_WORDS = str.maketrans("_", " ", "{}*$`")


def _find_inertia(line: str) -> str:
    """Find I_zz in a line of a report, ``Our result: I_zz = 4.4e-3 ± 0.1e-3 kg m^2``; "" if there is none.

    The value needs its name in front and its unit behind; "I_zz" and "moment of inertia" do without the unit.
    """
    if len(line) > _LONGEST_LINE or not re.search(r"\d", line):
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
        if unit and units.kinds_of(unit[1]) and (plain := quantities.take_apart(whole)) and not plain.unit:
            whole = f"{whole} {unit[1]}"
        for cut in reversed(list(re.finditer(_CUTS, whole))):
            answer = whole[: cut.start()].rstrip(" *`$_")
            if readings.read_reported("inertia", answer).fault is None:
                return answer
        if len(name) > 1 and readings.read_reported("inertia", whole).fault == "no unit":
            return whole
    return ""
