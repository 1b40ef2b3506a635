"""The last run over a class: where nothing has changed since, nothing is read, judged, rendered or written again.

Its record is the last line of the journal: a digest of all that went in, one of all that came out, and what was said.
Whatever is edited, added or taken away, in the class or beside the grades, makes the run a whole one.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from gyrodata import __version__
from gyrodata.diagnostics import GRADES_FOLDER_CANNOT_BE_WRITTEN
from gyrodata.disk import LOCK, add_line, content_digest, last_line, open_end, telling

JOURNAL = "journal.ndjson"  # beside the grades

SCHEMA = "gyro.run/1"


def digest_of(asked: Mapping[str, object]) -> str:
    """Digest of what a run is asked for: its options by name, and every byte of the files and folders among them."""
    digest = hashlib.sha256(__version__.encode())
    for name, value in sorted(asked.items()):
        digest.update(f"\0{name}\0{value!r}".encode("utf-8", "surrogatepass"))
        for path in value if isinstance(value, list) else (value,):
            if isinstance(path, Path):
                digest.update(content_digest(path.resolve()).encode())
    return digest.hexdigest()


def find_unchanged(journal: Path, asked: str) -> dict[str, Any] | None:
    """Give what the last run said, if it was asked the same and all it wrote is as it was; else None."""
    try:
        told: dict[str, Any] = json.loads(last_line(journal)[1])
        same = told["schema"] == SCHEMA and told["asked"] == asked
        return told["said"] if same and told["files"] == content_digest(journal.parent, (JOURNAL, LOCK)) else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def keep_run(journal: Path, asked: str, said: Mapping[str, Any]) -> None:
    """Keep what a run said, behind all grades; the record of the one before goes."""
    told = {"schema": SCHEMA, "asked": asked, "files": content_digest(journal.parent, (JOURNAL, LOCK)), "said": said}
    with telling(journal.parent, GRADES_FOLDER_CANNOT_BE_WRITTEN):
        begin, last = last_line(journal)
        with open_end(journal) as file:
            if is_run(last):
                file.truncate(begin)
            add_line(file, f"{json.dumps(told)}\n".encode())


def is_run(line: bytes) -> bool:
    """Tell whether a line of a journal is the record of a run, not a grade."""
    return line.startswith(f'{{"schema": "{SCHEMA}"'.encode())
