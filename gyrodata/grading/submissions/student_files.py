"""Find the log among the files of a student, without a guess between two, and the answer in any of the files."""

from __future__ import annotations

import html
import io
import re
import zipfile
import zlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from typing import Literal

from msgspec import Struct

from gyrodata import quantities, readings, units
from gyrodata.diagnostics import ANSWER_ELSEWHERE
from gyrodata.errors import Diagnostic, GyroError
from gyrodata.readings.roles import name_roles
from gyrodata.readings.source import sheet_rows
from gyrodata.reporting.values import size_text

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
    note = Diagnostic.of(ANSWER_ELSEWHERE, f'I_zz is read from {place}: "{first.text}"')
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
