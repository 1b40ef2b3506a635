"""Choose the log among the files of one student, without a guess between two logs."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Literal

from msgspec import Struct

from gyrodata import readings
from gyrodata.base.errors import GyroError, InputError
from gyrodata.base.workers import reads_file
from gyrodata.grading.submissions.answers import version_of
from gyrodata.grading.submissions.archives import (
    LOGS,
    REPORTS,
    SHEETS,
    TABLES,
    TEXTS,
    WORKBOOKS,
    ending,
    place_of,
)
from gyrodata.grading.submissions.documents import as_log

Attempts = Literal["newest", "oldest"]

NO_LOG = ("no log", "no files")
"""First words of a note if there is no file that may be a log."""


class LogChoice(Struct, frozen=True):
    """The log among the files of one student, or why there is none."""

    name: str | None
    """Name below the class; None if there is no log."""
    note: str = ""
    """How the log was chosen among several files, or why there is none."""


class _ReadFiles(Struct, frozen=True):
    """The files of one student, read as logs."""

    logs: Mapping[str, readings.Readings]
    """Those that can be analysed; of equal files the first."""
    with_columns: tuple[str, ...]
    """Those that have a column of a log, readable or not."""


def choose_log(
    files: Mapping[str, str], read: Callable[[str], bytes], attempts: Attempts
) -> LogChoice:
    """Choose the log among the files of one student.

    Parameters
    ----------
    files : mapping
        The names that the student gave, by the names below the class.
    read : callable
        Reads a file.
    attempts : {"newest", "oldest"}
        Which of several versions of a file is the log.
    """
    candidates = _candidates(files)
    chosen = _latest(candidates, attempts)
    how = f"the {attempts}"
    rivals = candidates
    has_table = any(ending(own) in TABLES for own in candidates.values())
    if not chosen or not has_table:
        read_files = _read_as_logs(candidates, read)
        chosen, how = _choose_by_content(read_files, files, attempts)
        rivals = _rivals(candidates, read_files)
    if not chosen:
        return LogChoice(None, how)
    damage = _damage(candidates[chosen].rpartition("/")[2], chosen, read)
    if damage:
        return LogChoice(None, damage)
    aside = sorted(candidates[name] for name in rivals if name != chosen)
    if not aside:
        return LogChoice(chosen)
    words = f"{candidates[chosen]} is {how}; left aside: {readings.listing(aside)}"
    return LogChoice(chosen, words)


def _candidates(files: Mapping[str, str]) -> dict[str, str]:
    """Return the tables among the files; else the texts and reports."""
    tables = {name: own for name, own in files.items() if ending(own) in TABLES}
    if tables:
        return tables
    return {
        name: own for name, own in files.items() if ending(own) in (*LOGS, *REPORTS)
    }


def _rivals(candidates: Mapping[str, str], read_files: _ReadFiles) -> dict[str, str]:
    """Return the candidates that may have been meant as the log."""
    return {
        name: own
        for name, own in candidates.items()
        if name in read_files.logs or ending(own) not in TEXTS
    }


def _read_as_logs(
    candidates: Mapping[str, str], read: Callable[[str], bytes]
) -> _ReadFiles:
    """Read every candidate as a log."""
    logs: dict[str, readings.Readings] = {}
    with_columns: dict[bytes, str] = {}
    for name, own in candidates.items():
        reads_file(place_of(name))
        file = own.rpartition("/")[2]
        with suppress(GyroError):
            data = as_log(file, read(name))
            log = readings.read_log(data, name=file)
            if not log.columns or data in with_columns:
                continue
            with_columns[data] = name
            if log.ok:
                logs[name] = log
    return _ReadFiles(logs, tuple(with_columns.values()))


def _choose_by_content(
    read_files: _ReadFiles, files: Mapping[str, str], attempts: Attempts
) -> tuple[str, str]:
    """Return the log and how it was chosen; or "" and why there is no log."""
    logs = read_files.logs
    if len(logs) == 1:
        return next(iter(logs)), "read as the log"
    if logs:
        of_logs = {name: files[name] for name in logs}
        latest = _latest(of_logs, attempts)
        names = readings.listing(sorted(of_logs.values()))
        how = "the latest by its name" if latest else "several files that read as logs"
        return latest, how if latest else f"{how}: {names}"
    return _choose_unreadable(read_files, files)


def _choose_unreadable(
    read_files: _ReadFiles, files: Mapping[str, str]
) -> tuple[str, str]:
    """Do the work of `_choose_by_content` if no file can be analysed."""
    if len(read_files.with_columns) == 1:
        return read_files.with_columns[0], "most like a log"
    tables = {name: own for name, own in files.items() if ending(own) in SHEETS}
    if len(tables) == 1:
        return next(iter(tables)), "most like a log"
    if tables:
        names = readings.listing(sorted(tables.values()))
        return "", f"several files and none of them reads as a log: {names}"
    if not files:
        return "", "no files"
    names = readings.listing(sorted(name.rpartition("/")[2] for name in files.values()))
    return "", f"no log: only {names}"


def _latest(files: Mapping[str, str], attempts: Attempts) -> str:
    """Return the file that is called the latest version; "" without versions."""
    versions = {name: version_of(own) for name, own in files.items()}
    ranks = {name: rank for name, (rank, _) in versions.items()}
    bases = {base for _, base in versions.values()}
    if len(set(ranks.values())) < len(files) or len(bases) != 1:
        return ""
    last = min if attempts == "oldest" else max
    return last(ranks, key=lambda name: ranks[name])


def _damage(file: str, name: str, read: Callable[[str], bytes]) -> str:
    """Return why a file cannot be a log whatever it contains, or "".

    Why it cannot be read is said when it is graded.
    """
    with suppress(InputError):
        data = read(name)
        if not data:
            return f"{file} is empty"
        if ending(file) in WORKBOOKS and not zipfile.is_zipfile(io.BytesIO(data)):
            return (
                f"{file} is damaged, such as a file that was not uploaded to its end; "
                f"hand it in again"
            )
    return ""
