"""Which of a student's files is the log, and which holds the answers; never guessed where two will do."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from gyrodata.errors import GyroError
from gyrodata.grading.submissions.archives import size_text
from gyrodata.readings import MAX_BYTES, listing, read_log

TABLES = (".csv", ".tsv")
"""Endings that say table."""
PERHAPS_TABLES = (".txt", ".dat", ".xlsx", ".log")
"""Endings of logs that are looked at where there is no table."""
ARCHIVES = (".zip", ".rar", ".7z", ".tar", ".tgz")

_ANSWERS = re.compile(r"(?:.*[-_. ])?answers(?:[-_ ]?\(?\d+\)?)?(?:\.toml|\.txt|\.toml\.txt)", re.IGNORECASE)
_COPY = re.compile(r"(?P<base>.+?)(?:-(?P<again>\d{1,2})| ?\((?P<copy>\d{1,2})\))(?P<ending>\.[^/]+)")


@dataclass(frozen=True, slots=True)
class Choice:
    """What was chosen of a student's files.

    Attributes
    ----------
    log, answers : str or None
        Names, as they were given.
    problem : str or None
        Why there is no log to grade.
    note : str or None
        What whoever grades may want to know of the choice.
    """

    log: str | None
    answers: str | None
    problem: str | None = None
    note: str | None = None


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
