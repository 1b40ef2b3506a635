"""Choose the log among the files of one student, without a guess between two logs."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Literal

from gyrodata import readings
from gyrodata.base.errors import GyroError
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
_CUT = "is damaged, such as a file that was not uploaded to its end"


def choose_log(
    files: Mapping[str, str], read: Callable[[str], bytes], attempts: Attempts
) -> tuple[str, str]:
    """Choose the log among the files of one student.

    Return its name below the class, and how it was chosen among several files; or "",
    and why there is no log.

    Parameters
    ----------
    files : mapping
        The names that the student gave, by the names below the class.
    read : callable
        Reads a file.
    attempts : {"newest", "oldest"}
        Which of several versions of a file is the log.
    """
    candidates = _with_endings(files, TABLES)
    chosen = _latest(candidates, attempts)
    how = f"the {attempts}"
    rivals = candidates
    if not chosen:
        candidates = candidates or _with_endings(files, (*LOGS, *REPORTS))
        with_columns = _read_as_logs(candidates, read)
        chosen, how = _choose_by_content(with_columns, files, attempts)
        others = {
            name: own for name, own in candidates.items() if ending(own) not in TEXTS
        }
        rivals = others | {
            name: files[name] for name in with_columns if with_columns[name]
        }
    if not chosen:
        return "", how
    with suppress(GyroError):
        file = files[chosen].rpartition("/")[2]
        data = read(chosen)
        if not data:
            return "", f"{file} is empty"
        if ending(file) in WORKBOOKS and not zipfile.is_zipfile(io.BytesIO(data)):
            return "", f"{file} {_CUT}; hand it in again"
    aside = sorted({*rivals.values()} - {files[chosen]})
    words = f"{files[chosen]} is {how}; left aside: {readings.listing(aside)}"
    return chosen, words * bool(aside)


def _with_endings(files: Mapping[str, str], endings: Sequence[str]) -> dict[str, str]:
    return {name: own for name, own in files.items() if ending(own) in endings}


def _read_as_logs(
    candidates: Mapping[str, str], read: Callable[[str], bytes]
) -> dict[str, bool]:
    """Return the files with a column of a log, and whether each can be analysed.

    Of equal files it is the first.
    """
    known = set[bytes]()
    with_columns = {}
    for name, own in candidates.items():
        reads_file(place_of(name))
        file = own.rpartition("/")[2]
        with suppress(GyroError):
            data = as_log(file, read(name))
            log = readings.read_log(data, name=file)
            if log.columns and data not in known:
                known.add(data)
                with_columns[name] = log.ok
    return with_columns


def _choose_by_content(
    with_columns: Mapping[str, bool], files: Mapping[str, str], attempts: Attempts
) -> tuple[str, str]:
    """Return the log and how it was chosen; or "" and why there is no log."""
    logs = {name: files[name] for name, is_ok in with_columns.items() if is_ok}
    like = {name: files[name] for name in with_columns}
    sheets = _with_endings(files, SHEETS)
    several = "several files and none of them reads as a log"
    for pool, how, why in (
        (logs, "read as the log", "several files that read as logs"),
        (like, "most like a log", several),
        (sheets, "most like a log", several),
    ):
        if len(pool) == 1:
            return next(iter(pool)), how
        if latest := _latest(pool, attempts):
            return latest, "the latest by its name"
        if pool:
            return "", f"{why}: {readings.listing(sorted(pool.values()))}"
    if not files:
        return "", "no files"
    names = sorted(name.rpartition("/")[2] for name in files.values())
    return "", f"no log: only {readings.listing(names)}"


def _latest(files: Mapping[str, str], attempts: Attempts) -> str:
    """Return the file that is called the latest version; "" without versions."""
    versions = {name: version_of(own) for name, own in files.items()}
    ranks = {name: rank for name, (rank, _) in versions.items()}
    bases = {base for _, base in versions.values()}
    if len(set(ranks.values())) < len(files) or len(bases) != 1:
        return ""
    last = min if attempts == "oldest" else max
    return last(ranks, key=lambda name: ranks[name])
