"""A class on disk: a folder or a zip, listed with care and read file by file.

Gyro never unpacks anything.

A zip comes from strangers. Its members are read directly from it, each up to a limit,
so that a path that leads out of the folder, or ten gigabytes of zeros, can do no harm.
A zip with such a member is refused, because no platform writes one.
"""

from __future__ import annotations

import io
import os
import re
import shlex
import stat
import struct
import zipfile
import zlib
from contextlib import suppress
from functools import lru_cache
from pathlib import Path, PurePosixPath
from typing import IO

from msgspec import Struct

from gyrodata.base.errors import Diagnostic, InputError, shown
from gyrodata.readings import MAX_BYTES

MOST_FILES = (
    100_000  # files in one class: a thousand students with a hundred files each
)
MOST_LEVELS, MOST_INNER = (
    2,
    50_000_000,
)  # levels of zips in a submission, and bytes of each

TABLES = (".csv", ".tsv")  # endings of tables
WORKBOOKS = (".xlsx", ".ods")
PDF = ".pdf"
SHEETS = (*TABLES, *WORKBOOKS)
LOGS = (*TABLES, *WORKBOOKS, ".txt", ".dat", ".log", ".md")  # endings of logs
# Endings of files that are a log if it is a table in them.
REPORTS = (
    ".tex",
    ".docx",
    ".odt",
    ".html",
    ".htm",
    ".ipynb",
    ".py",
    ".r",
    ".m",
    ".json",
    PDF,
    "",
)
# Endings of files with the answer.
TEXTS = (*TABLES, *WORKBOOKS, ".txt", ".md", ".text", ".toml", *REPORTS)


def place_of(name: str) -> str:
    """Describe a file by its name: "lab.csv", or "lab.csv in lab.zip"."""
    parts = [shown(part.rpartition("/")[2])[:100] for part in name.split("//")]
    return " in ".join(reversed(parts))


class Listing(Struct, frozen=True):
    """The files of a class."""

    root: Path  # the folder or zip
    names: tuple[str, ...]  # below `root`, parts joined by ``/``, sorted
    folders: tuple[
        str, ...
    ] = ()  # names below `root`, each with a ``/`` at its end; sorted
    diagnostics: tuple[Diagnostic, ...] = ()  # files that are left out


# Files that macOS, Windows and editors add: ``__MACOSX/``, ``._lab.csv``,
# ``~$lab.xlsx``.
_STREWN = re.compile(
    r"(?:^|/)(?:__MACOSX/|\.[^/]*(?:/|$)|~\$[^/]*$|(?:thumbs\.db|desktop\.ini)$)",
    re.IGNORECASE,
)


@lru_cache(maxsize=1024)
def ending(name: str) -> str:
    """Return the ending of a file in small letters, without ``.gz``."""
    return PurePosixPath(name.lower().removesuffix(".gz")).suffix


def _refusal(root: Path, message: str, **values: str) -> InputError:
    return InputError.named(message, root.name, root=root.name, **values)


def list_files(root: Path) -> Listing:
    """List the files of a class, without those of operating systems."""
    try:
        if root.is_dir():
            return _list_folder(root)
        if not root.exists():
            raise _refusal(root, "class_not_there")
        # A workbook is a zip as well.
        if ending(root.name) in {*LOGS, *TEXTS} - {""}:
            here = Path.cwd()
            near = root
            if root.is_relative_to(here):
                near = root.relative_to(here)
            raise _refusal(root, "class_is_one_file", path=shlex.quote(str(near)))
        with root.open("rb") as file:
            is_zip = file.read(2) == b"PK"
        if not is_zip:
            raise _refusal(root, "class_is_no_zip")
        return _opened(root)[2]
    except OSError as error:
        why = error.strerror or str(error)
        raise _refusal(root, "class_unreadable", why=why) from None


def read_file(root: Path, name: str, most: int = MAX_BYTES) -> bytes:
    """Read one file of a class, of at most `most` bytes.

    ``//`` follows a zip in the class. Raises InputError.
    """
    try:
        with open_file(root, name) as file:
            data = file.read(most + 1)
        if len(data) <= most:
            return data
        why = f"it is larger than {most / 1e6:g} MB"
    except OSError as error:
        why = error.strerror or str(error)
    except (
        zipfile.BadZipFile,
        zlib.error,
        EOFError,
        RuntimeError,
        ValueError,
    ) as error:
        why = f"it is damaged in the zip ({error})"
    inner = name.rpartition("//")[2]
    name = inner.rpartition("/")[2]
    raise InputError.named("file_of_class_unreadable", name, name=name, why=why)


def open_file(root: Path, name: str) -> IO[bytes]:
    """Open a file of a class, or one in a zip; raise OSError if it cannot be read."""
    outer, _, inner = name.rpartition("//")
    plain = root / name
    if not outer and plain.is_file() and not plain.is_symlink():
        return plain.open("rb")
    if not outer and (not root.is_file() or Path(name).is_absolute()):
        raise FileNotFoundError("it is no longer there")
    archive, members, _ = _opened(root, outer)
    member = members.get(inner)
    if member is None:
        raise FileNotFoundError("it is no longer there")
    # Other ways than these two unpack a whole block at a time, however large.
    if member.flag_bits & 0x1 or member.compress_type not in _PACKED:
        raise OSError("it is encrypted, or packed in a way that no platform uses")
    return archive.open(member)


def _list_folder(root: Path) -> Listing:
    errors: list[OSError] = []
    modes, folders = _modes_below(root, errors)
    notes = [_note_on_folder(root, error) for error in errors]
    paths = []
    for name, mode in modes.items():
        if stat.S_ISLNK(mode):
            # It may lead to the files of another student, or of the grader.
            notes.append(Diagnostic.named("link_left_out", root.name, name=name))
        elif stat.S_ISREG(mode) and not _STREWN.search(name):
            paths.append(name)
    notes.sort(key=lambda note: note.message)
    return Listing(root, tuple(sorted(paths)), tuple(sorted(folders)[1:]), tuple(notes))


def _modes_below(root: Path, errors: list[OSError]) -> tuple[dict[str, int], list[str]]:
    """Return the mode of each file, link and folder by its name, and all folders.

    The root is the first folder, with the name "". `errors`: Receives the errors of
    folders that cannot be opened.
    """
    modes: dict[str, int] = {}
    folders: list[str] = []
    for path, inner, files in os.walk(root, onerror=errors.append):
        below = Path(path).relative_to(root).as_posix() + "/"
        below = below.removeprefix("./")
        folders.append(below)
        inner[:] = [name for name in inner if not _STREWN.search(f"{below}{name}/")]
        for name in (*inner, *files):
            modes[f"{below}{name}"] = Path(path, name).lstat().st_mode
        if len(modes) > MOST_FILES:
            raise _refusal(root, "class_too_large", most=str(MOST_FILES))
    return modes, folders


def _note_on_folder(root: Path, error: OSError) -> Diagnostic:
    """Say why a folder is left out; raise the error if it is about the whole class."""
    if Path(error.filename) == root:
        raise error
    name = Path(error.filename).relative_to(root).as_posix()
    return Diagnostic.named("folder_left_out", root.name, name=name, why=error.strerror)


_PACKED = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
_Contents = tuple[zipfile.ZipFile, dict[str, zipfile.ZipInfo], Listing]


def _opened(root: Path, name: str = "") -> _Contents:
    """Open the zip of a class, or a zip in the class, and list it."""
    state = (root if root.is_file() else root / name.partition("//")[0]).stat()
    # Opened again if the file changes; processes must not share one open file.
    return _contents(root, name, state.st_mtime_ns, state.st_size, os.getpid())


def list_inner(root: Path, name: str, depth: int = 1) -> list[str]:
    """List the files of a zip in a submission, and of zips in it.

    Of "ann/all.zip" with lab.csv and more.zip: "ann/all.zip//lab.csv", and
    "ann/all.zip//more.zip//report.txt" for a file in the inner one. Raises InputError.
    """
    members = list[str]()
    for whole in (f"{name}//{inner}" for inner in _opened(root, name)[2].names):
        packed = whole.lower().endswith(".zip") and depth < MOST_LEVELS
        members += list_inner(root, whole, depth + 1) if packed else [whole]
        if len(members) > MOST_FILES:
            raise _refusal(Path(name), "class_too_large", most=str(MOST_FILES))
    return members


@lru_cache(maxsize=2)
def _contents(root: Path, name: str, *_: int) -> _Contents:
    place = Path(name) if name else root
    archive = _archive(root, name, place)
    files: dict[str, zipfile.ZipInfo] = {}
    folders = set()
    twice = set()
    for info in archive.infolist():
        parts = _safe_name(place, info).split("/")
        inner = "/".join(part for part in parts if part not in ("", "."))
        if _STREWN.search(f"{inner}/" if info.is_dir() else inner):
            continue
        if info.is_dir():
            folders.add(f"{inner}/")
        elif inner:
            twice |= {inner} & files.keys()
            files[inner] = info
    notes = [
        Diagnostic.named("file_twice_in_zip", root.name, name=inner)
        for inner in sorted(twice)
    ]
    names = tuple(sorted(files))
    listing = Listing(root, names, tuple(sorted(folders)), tuple(notes))
    return archive, files, listing


def _archive(root: Path, name: str, place: Path) -> zipfile.ZipFile:
    """Open a zip, or a zip in it; refuse one that is damaged or has too many files."""
    source = io.BytesIO(read_file(root, name, MOST_INNER)) if name else root
    try:
        archive = zipfile.ZipFile(source)
    except (zipfile.BadZipFile, NotImplementedError, ValueError, struct.error) as error:
        raise _refusal(place, "zip_damaged", why=str(error)) from None
    if len(archive.infolist()) > MOST_FILES:
        raise _refusal(place, "class_too_large", most=str(MOST_FILES))
    return archive


def _safe_name(root: Path, info: zipfile.ZipInfo) -> str:
    """Decode a name, as UTF-8 if possible, because macOS does not mark UTF-8.

    Refuse a name that leads elsewhere.
    """
    name = info.orig_filename
    if not info.flag_bits & 0x800:
        with suppress(UnicodeError):
            name = name.encode("cp437").decode("utf-8")
    name = name.replace("\\", "/")
    reasons = {
        'leads out of its folder with ".."': ".." in name.split("/"),
        "is an absolute path": name.startswith("/") or name[1:2] == ":",
        "is a link": stat.S_ISLNK(info.external_attr >> 16),
        "contains a NUL": "\x00" in name,
    }
    for why, is_unsafe in reasons.items():
        if is_unsafe:
            raise _refusal(root, "zip_not_safe", name=shown(name)[:100], why=why)
    return name
