"""Choose the log among the files of one student, without a guess between two logs."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Literal, NamedTuple

from gyrodata import readings
from gyrodata.base.errors import GyroError
from gyrodata.base.workers import reads_file
from gyrodata.grading.submissions.answers import version_of
from gyrodata.grading.submissions.archives import (
    LOGS,
    REPORTS,
    SHEETS,
    TABLES,
    WORKBOOKS,
    ending,
    place_of,
)
from gyrodata.grading.submissions.documents import as_log

Attempts = Literal["newest", "oldest"]

NO_LOG = ("no log", "no files")
"""First words of a note if there is no file that may be a log."""
_CUT = "is damaged, such as a file that was not uploaded to its end"


class Choice(NamedTuple):
    """The log among the files of one student, or why there is none.

    Of "ann/lab.csv" and "ann/lab_v2.csv":
    ("ann/lab_v2.csv", "lab_v2.csv is the newest; left aside: lab.csv").
    Of "ann/report.pdf": ("", "no log: only report.pdf").
    """

    name: str  # below the class; "" without a log
    why: str  # how it was chosen; "" if no other file may be the log


def choose_log(
    files: Mapping[str, str], read: Callable[[str], bytes], attempts: Attempts
) -> Choice:
    """Choose the log among the files of one student.

    A table (.csv, .tsv) is the log if it is the only one, or if their names say which
    version is the latest. Else the files that read as a log are compared.

    Parameters
    ----------
    files : mapping
        The names that the student gave, by the names below the class.
    read : callable
        Reads a file.
    attempts : {"newest", "oldest"}
        Which of several versions of a file is the log.
    """
    rivals = _with_endings(files, TABLES)
    chosen, how = _latest(rivals, attempts), f"the {attempts}"
    if not chosen:
        candidates = rivals or _with_endings(files, (*LOGS, *REPORTS))
        with_columns = _read_as_logs(candidates, read)
        chosen, how = _choose_by_content(with_columns, files, attempts)
        rivals = {name: files[name] for name in with_columns}
    if not chosen:
        return Choice("", how)
    damage = _damage_of(chosen, files[chosen], read)
    if damage:
        return Choice("", damage)
    file = files[chosen]
    aside = sorted({*rivals.values()} - {file})
    words = f"{file} is {how}; left aside: {readings.listing(aside)}"
    return Choice(chosen, words if aside else "")


def _damage_of(name: str, own: str, read: Callable[[str], bytes]) -> str:
    """Say why a file that can be opened is no log; "" if it may be one."""
    file = own.rpartition("/")[2]
    with suppress(GyroError):
        data = read(name)
        if not data:
            return f"{file} is empty"
        is_workbook = ending(file) in WORKBOOKS
        if is_workbook and not zipfile.is_zipfile(io.BytesIO(data)):
            return f"{file} {_CUT}; hand it in again"
    return ""


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
) -> Choice:
    """Choose among the files that can be analysed, else among those with a column.

    Else choose among all tables and workbooks.
    """
    logs = {name: files[name] for name, is_ok in with_columns.items() if is_ok}
    like = {name: files[name] for name in with_columns}
    sheets = _with_endings(files, SHEETS)
    several = "several files and none of them reads as a log"
    for pool, how, why in (
        (logs, "read as the log", "several files that read as logs"),
        (like, "most like a log", several),
        (sheets, "most like a log", several),
    ):
        if latest := _latest(pool, attempts):
            return Choice(latest, how if len(pool) == 1 else "the latest by its name")
        if pool:
            return Choice("", f"{why}: {readings.listing(sorted(pool.values()))}")
    if not files:
        return Choice("", "no files")
    names = sorted(name.rpartition("/")[2] for name in files.values())
    return Choice("", f"no log: only {readings.listing(names)}")


def _latest(files: Mapping[str, str], attempts: Attempts) -> str:
    """Return the latest of the versions of one file, such as "lab.csv", "lab_v2.csv".

    It is the only file of one; "" for files with different names.
    """
    versions = {version_of(own): name for name, own in files.items()}
    bases = {base for _, base in versions}
    if len(versions) < len(files) or len(bases) != 1:
        return ""
    last = min if attempts == "oldest" else max
    return versions[last(versions)]
