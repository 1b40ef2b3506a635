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
from contextlib import suppress
from functools import lru_cache
from pathlib import Path

from msgspec import Struct

from gyrodata import diagnostics
from gyrodata.errors import Diagnostic, InputError
from gyrodata.readings import MAX_BYTES
from gyrodata.reporting.values import size_text

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
        if root.is_file() and zipfile.is_zipfile(root):
            return _opened(*_identity(root))[2]
        if root.is_file():
            with root.open("rb") as file:
                if file.read(4) == b"PK\x03\x04":
                    raise _refusal(diagnostics.ZIP_DAMAGED, root, "is damaged: its end is missing", "download it again")
        if not root.exists():
            raise _refusal(
                diagnostics.CLASS_IS_NO_FOLDER_OR_ZIP, root, "is not there: no folder or zip", "check its name"
            )
        hint = "give the folder of the class or the zip as it was downloaded; unpack a .rar, .7z or .tar.gz first"
        raise _refusal(diagnostics.CLASS_IS_NO_FOLDER_OR_ZIP, root, "is neither a folder nor a zip", hint)
    except OSError as error:
        raise _refusal(
            diagnostics.CLASS_IS_NO_FOLDER_OR_ZIP, root, f"cannot be read: {error.strerror or error}"
        ) from None


def read_file(root: Path, name: str, most: int = MAX_BYTES) -> bytes:
    """Read one file of a class."""
    shown = name.rpartition("/")[2]
    try:
        data = _read_member(root, name, most) if root.is_file() else _read_plain(root / name, most)
        if len(data) <= most:
            return data
        why = f"it is larger than {size_text(most)}"
    except OSError as error:
        why = error.strerror or str(error)
    except (zipfile.BadZipFile, zlib.error, EOFError, RuntimeError, ValueError) as error:
        why = f"it is damaged in the zip ({error})"
    raise InputError.of(diagnostics.SUBMITTED_FILE_CANNOT_BE_READ, f'"{shown}" cannot be read: {why}', file=shown)


# Files that macOS, Windows and editors leave: ``__MACOSX/``, ``._lab.csv``, ``~$lab.xlsx``.
_STREWN = re.compile(r"(?:^|/)(?:__MACOSX/|\.[^/]*(?:/|$)|~\$[^/]*$|(?:thumbs\.db|desktop\.ini)$)", re.IGNORECASE)


def _refusal(code: str, root: Path, message: str, hint: str = "") -> InputError:
    return InputError.of(code, f'"{root.name}" {message}', hint, root.name)


def _too_many(root: Path) -> InputError:
    hint = "give the folder or zip of one assignment"
    return _refusal(diagnostics.TOO_MANY_FILES, root, f"holds more than {MOST_FILES} files: no class has so many", hint)


# --- folders ------------------------------------------------------------------------------------------------


def _list_folder(root: Path) -> Listing:
    sizes: dict[str, int] = {}
    left_out: list[tuple[str, str]] = []
    folders: list[str] = []
    seen = 0

    def closed(error: OSError) -> None:
        if Path(error.filename) == root:
            raise error
        below = Path(error.filename).relative_to(root).as_posix()
        words = f'"{below}/" cannot be opened and is left out: {error.strerror}'
        left_out.append((words, "give yourself the right to read it, such as with chmod -R u+rX"))

    for path, inner, files in os.walk(root, onerror=closed):
        below = os.path.relpath(path, root).replace(os.sep, "/") + "/" if path != str(root) else ""
        folders.append(below)
        seen += len(inner) + len(files)
        if seen > MOST_FILES:
            raise _too_many(root)
        inner[:] = [name for name in inner if not _STREWN.search(f"{below}{name}/")]
        for name in (f"{below}{name}" for name in (*inner, *files)):
            state = os.lstat(root / name)
            if _STREWN.search(name):
                continue
            if stat.S_ISLNK(state.st_mode):
                # It may lead to the files of another student, or of the grader.
                hint = "put a copy of what it leads to in its place, if it belongs there"
                left_out.append((f'"{name}" is a link and is left out', hint))
            elif stat.S_ISREG(state.st_mode):
                sizes[name] = state.st_size
    told = tuple(Diagnostic.of(diagnostics.FILE_LEFT_OUT, *words, root.name) for words in sorted(left_out))
    return Listing(root, dict(sorted(sizes.items())), tuple(sorted(folders)[1:]), told)


def _read_plain(path: Path, most: int) -> bytes:
    if path.is_symlink() or not path.is_file():
        raise FileNotFoundError("it is no longer there")
    with path.open("rb") as file:
        return file.read(most + 1)


# --- zips ---------------------------------------------------------------------------------------------------


def _read_member(root: Path, name: str, most: int) -> bytes:
    archive, files, _ = _opened(*_identity(root))
    info = files.get(name)
    if info is None:
        raise FileNotFoundError("it is no longer there")
    if info.flag_bits & 0x1:
        raise OSError("it is encrypted")
    if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        # The others unpack a block at a time, however large.
        raise OSError("it is packed in a way that no platform uses")
    with archive.open(info) as file:
        return file.read(most + 1)


def _identity(root: Path) -> tuple[Path, int, int, int]:
    """Know an archive again; a process of its own has its own, for two must not share one place in a file."""
    state = root.stat()
    return root, state.st_mtime_ns, state.st_size, os.getpid()


@lru_cache(maxsize=2)
def _opened(
    root: Path, changed: int, size: int, process: int
) -> tuple[zipfile.ZipFile, dict[str, zipfile.ZipInfo], Listing]:
    """Open a zip whose table of contents is safe, and list it."""
    with root.open("rb") as file:
        file.seek(max(0, size - MOST_DIRECTORY_BYTES))
        # The entries are counted before anything is built from them.
        if file.read().count(b"PK\x01\x02") > MOST_FILES:
            raise _too_many(root)
    try:
        archive = zipfile.ZipFile(root)
    except (zipfile.BadZipFile, NotImplementedError, ValueError, struct.error) as error:
        raise _refusal(diagnostics.ZIP_DAMAGED, root, f"is damaged: {error}", "download it again") from None
    files: dict[str, zipfile.ZipInfo] = {}
    folders: set[str] = set()
    told: dict[str, Diagnostic] = {}
    for info in archive.infolist():
        whole = _safe_name(root, info)
        name = "/".join(part for part in whole.split("/") if part not in ("", "."))
        if _STREWN.search(f"{name}/" if info.is_dir() else name):
            continue
        if info.is_dir():
            folders.add(f"{name}/")
        elif name:
            if name in files:
                message, hint = (
                    f'the zip holds "{name}" twice; the later one is read',
                    "take one of the two out of the zip",
                )
                told[name] = Diagnostic.of(diagnostics.FILE_LEFT_OUT, message, hint, root.name)
            files[name] = info
    sizes = {name: info.file_size for name, info in sorted(files.items())}
    return archive, files, Listing(root, sizes, tuple(sorted(folders)), tuple(told[name] for name in sorted(told)))


def _safe_name(root: Path, info: zipfile.ZipInfo) -> str:
    """Decode a name: UTF-8 where it is marked or fits, for macOS does not mark it; refuse one that leads elsewhere."""
    name = info.orig_filename
    if not info.flag_bits & 0x800:
        with suppress(UnicodeError):
            name = name.encode("cp437").decode("utf-8")
    name = name.replace("\\", "/")
    unsafe = {
        'leads out of its folder with ".."': ".." in name.split("/"),
        "is an absolute path": name.startswith("/") or re.match(r"[A-Za-z]:", name),
        "holds a NUL": "\x00" in name,
        "is a link": stat.S_ISLNK(info.external_attr >> 16),
    }
    for why in (why for why, found in unsafe.items() if found):
        shown = "".join(c if c.isprintable() else "\ufffd" for c in name)[:100]
        hint = "no platform writes such a zip; ask who made it, and take that file out"
        raise _refusal(diagnostics.ZIP_NOT_SAFE, root, f'is not read: "{shown}" {why}', hint)
    return name
