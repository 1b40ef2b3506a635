"""The last run over a class: where nothing has changed since, nothing is read, judged, rendered or written again.

Its record is the last line of the journal: a digest of all that went in, one of all that came out, and what was said.
Whatever is edited, added or taken away, in the class or beside the grades, makes the run a whole one.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections import deque
from collections.abc import Collection, Mapping
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
                digest.update(_content(path.resolve()).encode())
    return digest.hexdigest()


def find_unchanged(journal: Path, asked: str) -> dict[str, Any] | None:
    """Give what the last run said, if it was asked the same and all it wrote is as it was; else None."""
    try:
        told: dict[str, Any] = json.loads(_last_line(journal)[1])
        same = told["schema"] == SCHEMA and told["asked"] == asked
        return told["said"] if same and told["files"] == _content(journal.parent, (JOURNAL, LOCK)) else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def keep_run(journal: Path, asked: str, said: Mapping[str, Any]) -> None:
    """Keep what a run said, behind all grades; the record of the one before goes."""
    files = _content(journal.parent, (JOURNAL, LOCK))
    line = json.dumps({"schema": SCHEMA, "asked": asked, "files": files, "said": said})
    with telling(journal.parent, GRADES_FOLDER_CANNOT_BE_WRITTEN):
        begin, last = _last_line(journal)
        add_line(journal, f"{line}\n".encode(), begin if is_run(last) else None)


def is_run(line: bytes) -> bool:
    """Tell whether a line of a journal is the record of a run, not a grade."""
    return line.startswith(f'{{"schema": "{SCHEMA}"'.encode())


def _last_line(journal: Path) -> tuple[int, bytes]:
    """Find where the last line begins, and the line; the journal of a large class does not go into memory."""
    with journal.open("rb") as file:
        last = next(iter(deque(file, 1)), b"")
        return file.tell() - len(last), last


def _content(path: Path, without: Collection[str] = ()) -> str:
    """Digest of the names and the bytes of a file, or of a folder with all that is in it but what is called so.

    Texts for paths, and plain reads: both are done for every file of a class, and cost half of what `Path` and
    `hashlib.file_digest` do.
    """
    digest, home = hashlib.sha256(), str(path)
    below = [(folder, name) for folder, folders, files in os.walk(home) for name in (*folders, *files)]
    for one in [home, *sorted(f"{folder}{os.sep}{name}" for folder, name in below if name not in without)]:
        digest.update(f"\0{one[len(home) :]}\0".encode("utf-8", "surrogatepass"))
        if os.path.isfile(one):  # noqa: PTH113
            part = hashlib.sha256()
            with open(one, "rb", buffering=0) as file:  # noqa: PTH123
                while data := file.read(1 << 20):
                    part.update(data)
            digest.update(part.digest())
    return digest.hexdigest()
