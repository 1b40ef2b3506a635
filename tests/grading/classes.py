"""Classes on disk, as platforms hand them out, for the tests."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from msgspec.structs import replace

from gyrodata.base.errors import Diagnostic
from gyrodata.grading.submissions import Submissions, choose, list_submissions

LOG = (
    "mass [g],position [cm],spin [rpm],time [s],turns\n20,15.0,406,13.06,1/3\n"
    "40,15.0,406,6.53,1/3\n"
)
"""A log that reads."""


def make_folder(root: Path, files: Mapping[str, str | bytes]) -> Path:
    """Write files below a folder; a name that ends in ``/`` makes an empty folder."""
    root.mkdir(parents=True, exist_ok=True)
    for name, content in files.items():
        path = root / name
        if name.endswith("/"):
            path.mkdir(parents=True)
            continue
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content.encode() if isinstance(content, str) else content)
    return root


def packed(
    files: Mapping[str, str | bytes], method: int = zipfile.ZIP_DEFLATED
) -> bytes:
    """Pack them into a zip."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", method) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return out.getvalue()


def make_zip(path: Path, files: Mapping[str, str | bytes]) -> Path:
    """Write the same as a zip."""
    path.write_bytes(packed(files))
    return path


def find_submissions(path: str | Path, **options: Any) -> Submissions:
    """List the submissions of a class, and choose the log of each in this process."""
    listed = list_submissions(path, **options)
    chosen = [choose(item) for item in listed.items]
    notes = [
        Diagnostic.named("one_of_logs", listed.items[0].source.name, choice=choice)
        for _, choice in chosen
        if choice
    ]
    items = tuple(item for item, _ in chosen)
    return replace(listed, items=items, diagnostics=(*listed.diagnostics, *notes))
