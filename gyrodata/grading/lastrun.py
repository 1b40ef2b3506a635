"""The last run over a class: where nothing has changed since, nothing is read, judged, rendered or written again.

Its record is the last line of the journal: a digest of all that went in, one of all that came out, and what was said.
Whatever is edited, added or taken away, in the class or beside the grades, makes the run a whole one.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

from gyrodata import __version__
from gyrodata.diagnostics import GRADES_FOLDER_CANNOT_BE_WRITTEN
from gyrodata.disk import LOCK, add_line, telling

JOURNAL = "journal.ndjson"  # beside the grades

SCHEMA = "gyro.run/1"


def digest_of(asked: Mapping[str, object]) -> str:
    """Digest of what a run is asked for: its options by name, and every byte of the files and folders among them."""
    digest = hashlib.sha256(__version__.encode())
    for name, value in sorted(asked.items()):
        digest.update(f"\0{name}\0{value!r}".encode("utf-8", "surrogatepass"))
        for path in value if isinstance(value, list) else (value,):
            if isinstance(path, Path):
                _add(digest, path.resolve())
    return digest.hexdigest()


def find_unchanged(journal: Path, asked: str) -> dict[str, Any] | None:
    """Give what the last run said, if it was asked the same and all it wrote is as it was; else None."""
    try:
        told: dict[str, Any] = json.loads(_last_line(journal)[1])
        same = told["schema"] == SCHEMA and told["asked"] == asked and told["files"] == _state(journal)
    except (OSError, ValueError, KeyError, TypeError):
        return None
    return told["said"] if same else None


def keep_run(journal: Path, asked: str, said: Mapping[str, Any]) -> None:
    """Keep what a run said, behind all grades; the record of the one before goes."""
    line = json.dumps({"schema": SCHEMA, "asked": asked, "files": _state(journal), "said": said})
    with telling(journal.parent, GRADES_FOLDER_CANNOT_BE_WRITTEN):
        begin, last = _last_line(journal)
        add_line(journal, f"{line}\n".encode(), begin if is_run(last) else None)


_HEAD = f'{{"schema": "{SCHEMA}"'.encode()


def is_run(line: bytes) -> bool:
    """Tell whether a line of a journal is the record of a run, not a grade."""
    return line.startswith(_HEAD)


def _last_line(journal: Path) -> tuple[int, bytes]:
    """Find where the last line begins, and the line; the journal of a large class does not go into memory."""
    size = LARGE
    with journal.open("rb") as file:
        end = file.seek(0, os.SEEK_END)
        while True:
            start = file.seek(max(0, end - size))
            tail = file.read()
            begin = tail.rfind(b"\n", 0, max(len(tail) - 1, 0)) + 1
            if begin or not start:
                return start + begin, tail[begin:]
            size *= 2


def _state(journal: Path) -> str:
    """Digest of all files beside a journal."""
    digest = hashlib.sha256()
    _add(digest, journal.parent, (str(journal), str(journal.with_name(LOCK))))
    return digest.hexdigest()


def _add(digest: hashlib._Hash, path: Path, without: Collection[str] = ()) -> None:
    """Add the names and the bytes of a file, or of a folder with all that is in it."""
    digest.update(b"\0.\0")
    if path.is_file():
        digest.update(_content(path))
    for name, entry in _entries(str(path)):
        if entry.path in without:
            continue
        digest.update(f"\0{name}\0".encode("utf-8", "surrogatepass"))
        if entry.is_file():
            digest.update(_content(Path(entry.path)))


LARGE = 1 << 20  # bytes that are read at a time


def _content(path: Path) -> bytes:
    """Digest of a file: `hashlib.file_digest` costs more than most of these files."""
    digest = hashlib.sha256()
    with path.open("rb", buffering=0) as file:
        while part := file.read(LARGE):
            digest.update(part)
    return digest.digest()


def _entries(folder: str, below: str = "") -> Iterator[tuple[str, os.DirEntry[str]]]:
    """Go through all that is in a folder, in one order, by its name below the first; nothing where that is none."""
    try:
        with os.scandir(folder) as found:
            entries = sorted(found, key=lambda entry: entry.name)
    except OSError:
        return
    yield from ((f"{below}{entry.name}", entry) for entry in entries)
    for entry in entries:
        if entry.is_dir(follow_symlinks=False):
            yield from _entries(entry.path, f"{below}{entry.name}{os.sep}")
