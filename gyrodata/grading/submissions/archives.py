"""A class on disk: a folder or a zip, listed with care and read file by file; nothing is ever unpacked.

A zip comes from strangers. Its members are read straight from it, each up to a limit, so that a path that leads
elsewhere or ten gigabytes of zeros have nowhere to go; one that tries is refused all the same, for no platform
writes such a zip.
"""

from __future__ import annotations

import os
import re
import stat
import struct
import zipfile
import zlib
from collections.abc import Mapping
from functools import lru_cache
from itertools import islice
from pathlib import Path
from typing import NamedTuple

from msgspec import Struct

from gyrodata.diagnostics import (
    CLASS_IS_NO_FOLDER_OR_ZIP,
    FILE_LEFT_OUT,
    SUBMITTED_FILE_CANNOT_BE_READ,
    TOO_MANY_FILES,
    ZIP_DAMAGED,
    ZIP_NOT_SAFE,
)
from gyrodata.errors import Diagnostic, InputError
from gyrodata.readings import MAX_BYTES

MOST_FILES = 100_000  # files in one class: a thousand students with a hundred files each
MOST_DIRECTORY_BYTES = 32_000_000  # of the table of contents of a zip that are looked at; an entry has some hundred


class Listing(Struct, frozen=True):
    """The files of a class."""

    root: Path  # the folder or zip
    sizes: Mapping[str, int]  # name below `root`, parts joined by ``/``, to size [byte] as stated; sorted by name
    folders: tuple[str, ...] = ()  # names below `root`, each with a ``/`` at its end; sorted
    diagnostics: tuple[Diagnostic, ...] = ()  # what was left out


def list_files(root: Path) -> Listing:
    """List the files of a class without what operating systems strew in."""
    try:
        if root.is_dir():
            return _list_folder(root)
        if not root.exists():
            raise _refusal(CLASS_IS_NO_FOLDER_OR_ZIP, root, f'there is no folder or zip "{root}"', "check its name")
        if not root.is_file() or not zipfile.is_zipfile(root):
            if root.is_file() and _begins_as_zip(root):
                raise _refusal(ZIP_DAMAGED, root, f'"{root.name}" is damaged: its end is missing', "download it again")
            hint = "give the folder of the class or the zip as it was downloaded; unpack a .rar, .7z or .tar.gz first"
            raise _refusal(CLASS_IS_NO_FOLDER_OR_ZIP, root, f'"{root.name}" is neither a folder nor a zip', hint)
        return _list_zip(root)
    except OSError as error:
        raise _refusal(CLASS_IS_NO_FOLDER_OR_ZIP, root, f'"{root}" cannot be read: {error.strerror or error}') from None


def read_file(root: Path, name: str, most: int = MAX_BYTES) -> bytes:
    """Read one file of a class."""
    try:
        data = _read_member(root, name, most) if root.is_file() else _read_plain(root / name, most)
    except KeyError:
        raise _unreadable(name, "it is no longer there") from None
    except OSError as error:
        raise _unreadable(name, error.strerror or str(error)) from None
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError) as error:
        raise _unreadable(name, f"it is damaged in the zip ({error})") from None
    if len(data) > most:
        raise _unreadable(name, f"it is larger than {size_text(most)}")
    return data


def size_text(size: int) -> str:
    """Write a size in bytes as people say it."""
    for unit, scale in (("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if size >= scale:
            return f"{size / scale:.3g} {unit}"
    return f"{size} bytes"


_STREWN = re.compile(r"(?:^|/)(?:__MACOSX/|\.[^/]*(?:/|$)|~\$[^/]*$|(?:thumbs\.db|desktop\.ini)$)", re.IGNORECASE)


def is_strewn(name: str) -> bool:
    """Tell what macOS, Windows and editors leave behind (``__MACOSX/``, ``._lab.csv``, ``~$lab.xlsx``)."""
    return _STREWN.search(name) is not None


def _refusal(code: str, root: Path, message: str, hint: str = "") -> InputError:
    return InputError.of(code, message, hint, root.name)


def _unreadable(name: str, why: str) -> InputError:
    shown = name.rpartition("/")[2]
    return InputError.of(SUBMITTED_FILE_CANNOT_BE_READ, f'"{shown}" cannot be read: {why}', file=shown)


# --- folders ------------------------------------------------------------------------------------------------


def _list_folder(root: Path) -> Listing:
    sizes: dict[str, int] = {}
    left_out: list[tuple[str, str]] = []
    waiting = [""]
    folders: list[str] = []
    seen = 0
    while waiting:
        below = waiting.pop()
        folders.append(below)
        for entry in _entries(root, below, left_out):
            name = f"{below}{entry.name}"
            seen += 1
            if seen > MOST_FILES:
                raise _too_many(root)
            if is_strewn(f"{name}/" if entry.is_dir(follow_symlinks=False) else name):
                continue
            if entry.is_symlink():
                # It may lead to the files of another student, or of the grader.
                hint = "put a copy of what it leads to in its place, if it belongs there"
                left_out.append((f'"{name}" is a link and is left out', hint))
            elif entry.is_dir(follow_symlinks=False):
                waiting.append(f"{name}/")
            elif entry.is_file(follow_symlinks=False):
                sizes[name] = entry.stat(follow_symlinks=False).st_size
    told = tuple(Diagnostic.of(FILE_LEFT_OUT, *words, root.name) for words in sorted(left_out))
    return Listing(root, dict(sorted(sizes.items())), tuple(sorted(folders)[1:]), told)


def _entries(root: Path, below: str, left_out: list[tuple[str, str]]) -> list[os.DirEntry[str]]:
    try:
        with os.scandir(root / below) as entries:
            return list(islice(entries, MOST_FILES + 1))
    except OSError as error:
        if not below:
            raise
        words = f'"{below}" cannot be opened and is left out: {error.strerror}'
        left_out.append((words, "give yourself the right to read it, such as with chmod -R u+rX"))
        return []


def _read_plain(path: Path, most: int) -> bytes:
    if path.is_symlink() or not path.is_file():
        raise KeyError(path.name)
    with path.open("rb") as file:
        return file.read(most + 1)


def _too_many(root: Path) -> InputError:
    hint = "give the folder or zip of one assignment"
    return _refusal(
        TOO_MANY_FILES, root, f'"{root.name}" holds more than {MOST_FILES} files: no class has so many', hint
    )


# --- zips ---------------------------------------------------------------------------------------------------


class _Archive(NamedTuple):
    """An open zip."""

    zip: zipfile.ZipFile
    files: dict[str, zipfile.ZipInfo]
    folders: tuple[str, ...]
    told: tuple[Diagnostic, ...]


def _begins_as_zip(root: Path) -> bool:
    with root.open("rb") as file:
        return file.read(4) == b"PK\x03\x04"


def _list_zip(root: Path) -> Listing:
    archive = _opened(*_identity(root))
    sizes = {name: info.file_size for name, info in sorted(archive.files.items())}
    return Listing(root, sizes, archive.folders, archive.told)


def _read_member(root: Path, name: str, most: int) -> bytes:
    archive = _opened(*_identity(root))
    info = archive.files[name]
    if info.flag_bits & 0x1:
        raise _unreadable(name, "it is encrypted")
    if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        # The others unpack a block at a time, however large.
        raise _unreadable(name, "it is packed in a way that no platform uses")
    with archive.zip.open(info) as file:
        return file.read(most + 1)


def _identity(root: Path) -> tuple[Path, int, int, int]:
    """Know an archive again; a process of its own has its own, for two must not share one place in a file."""
    state = root.stat()
    return root, state.st_mtime_ns, state.st_size, os.getpid()


@lru_cache(maxsize=2)
def _opened(root: Path, changed: int, size: int, process: int) -> _Archive:
    """Open a zip whose table of contents is safe."""
    _refuse_millions(root)
    try:
        archive = zipfile.ZipFile(root)
    except (zipfile.BadZipFile, NotImplementedError, ValueError, struct.error) as error:
        raise _refusal(ZIP_DAMAGED, root, f'"{root.name}" is damaged: {error}', "download it again") from None
    files: dict[str, zipfile.ZipInfo] = {}
    folders: set[str] = set()
    twice: set[str] = set()
    for info in archive.infolist():
        _refuse_unsafe(root, info)
        name = "/".join(part for part in _name(info).split("/") if part not in ("", "."))
        if is_strewn(f"{name}/" if info.is_dir() else name):
            continue
        if info.is_dir():
            folders.add(f"{name}/")
        elif name:
            twice |= {name} & files.keys()
            files[name] = info
    told = [
        Diagnostic.of(
            FILE_LEFT_OUT,
            f'the zip holds "{name}" twice; the later one is read',
            "take one of the two out of the zip",
            root.name,
        )
        for name in sorted(twice)
    ]
    return _Archive(archive, files, tuple(sorted(folders)), tuple(told))


def _name(info: zipfile.ZipInfo) -> str:
    """Decode a name: UTF-8 where it is marked or fits, for macOS does not mark it."""
    name = info.orig_filename
    if not info.flag_bits & 0x800:
        try:
            name = name.encode("cp437").decode("utf-8")
        except UnicodeError:
            name = info.orig_filename
    return name.replace("\\", "/")


def _refuse_unsafe(root: Path, info: zipfile.ZipInfo) -> None:
    name = _name(info)
    why = ""
    if ".." in name.split("/"):
        why = 'leads out of its folder with ".."'
    elif name.startswith("/") or re.match(r"[A-Za-z]:", name):
        why = "is an absolute path"
    elif "\x00" in name:
        why = "holds a NUL"
    elif stat.S_ISLNK(info.external_attr >> 16):
        why = "is a link"
    if why:
        shown = "".join(c if c.isprintable() else "\ufffd" for c in name)[:100]
        hint = "no platform writes such a zip; ask who made it, and take that file out"
        raise _refusal(ZIP_NOT_SAFE, root, f'"{root.name}" is not read: "{shown}" {why}', hint)


def _refuse_millions(root: Path) -> None:
    """Count the entries in the table of contents, at the end of a zip, before anything is built from them."""
    with root.open("rb") as file:
        file.seek(max(0, file.seek(0, os.SEEK_END) - MOST_DIRECTORY_BYTES))
        if file.read().count(b"PK\x01\x02") > MOST_FILES:
            raise _too_many(root)
