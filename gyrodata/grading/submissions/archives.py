"""A class on disk: a folder or a zip, listed with care and read file by file; gyro never unpacks anything.

A zip comes from strangers. Its members are read directly from it, each up to a limit, so that a path that leads out of
the folder, or ten gigabytes of zeros, can do no harm. A zip with such a member is refused, because no platform writes
one.
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
from collections.abc import Mapping
from contextlib import suppress
from functools import lru_cache
from pathlib import Path, PurePosixPath

from msgspec import Struct

from gyrodata import diagnostics
from gyrodata.errors import Diagnostic, InputError, shown
from gyrodata.readings import MAX_BYTES
from gyrodata.reporting.values import size_text

MOST_FILES = 100_000  # files in one class: a thousand students with a hundred files each
MOST_LEVELS, MOST_INNER = 2, 50_000_000  # levels of zips in a submission, and bytes of each
MOST_DIRECTORY_BYTES = 32_000_000  # of the table of contents of a zip; an entry has about a hundred

TABLES = (".csv", ".tsv")  # endings of tables
LOGS = (*TABLES, ".txt", ".dat", ".xlsx", ".log", ".md")  # endings of logs
TEXTS = (".txt", ".md", ".html", ".htm", ".text", ".toml", ".docx", ".xlsx", ".tex")  # of files with the answer


class Listing(Struct, frozen=True):
    """The files of a class."""

    root: Path  # the folder or zip
    sizes: Mapping[str, int]  # name below `root`, parts joined by ``/``, to stated size [byte]; sorted by name
    folders: tuple[str, ...] = ()  # names below `root`, each with a ``/`` at its end; sorted
    diagnostics: tuple[Diagnostic, ...] = ()  # files that are left out


# Files that macOS, Windows and editors add: ``__MACOSX/``, ``._lab.csv``, ``~$lab.xlsx``.
_STREWN = re.compile(r"(?:^|/)(?:__MACOSX/|\.[^/]*(?:/|$)|~\$[^/]*$|(?:thumbs\.db|desktop\.ini)$)", re.IGNORECASE)


def ending(name: str) -> str:
    """Return the ending of a file in small letters, without ``.gz``."""
    return PurePosixPath(name.lower().removesuffix(".gz")).suffix


def is_log(name: str) -> bool:
    """Return whether a file may be a log, by its ending."""
    return ending(name) in LOGS


def _refusal(code: str, root: Path, message: str, hint: str = "") -> InputError:
    return InputError.of(code, f'"{root.name}" {message}', hint, root.name)


def _check_number(root: Path, number: int) -> None:
    if number > MOST_FILES:
        message = f"contains more than {MOST_FILES} files, too many for a class"
        raise _refusal(diagnostics.TOO_MANY_FILES, root, message, "give the folder or zip of one assignment")


def list_files(root: Path) -> Listing:
    """List the files of a class, without files that operating systems add. Raises InputError."""
    code = diagnostics.CLASS_IS_NO_FOLDER_OR_ZIP
    try:
        if root.is_dir():
            return _list_folder(root)
        if not root.exists():
            raise _refusal(code, root, "is not there: no folder or zip", "check its name")
        if ending(root.name) in (*LOGS, *TEXTS):  # a workbook is a zip as well
            one = f"to see what is read in one hand-in, run: gyro check --hand-in {shlex.quote(str(root))}"
            hint = f"give the folder or zip of the class; {one}"
            raise _refusal(code, root, "is one file, not the folder or zip of a class", hint)
        if zipfile.is_zipfile(root):
            return _opened(*_identity(root))[2]
        with root.open("rb") as file:
            if file.read(4) == b"PK\x03\x04":
                raise _refusal(diagnostics.ZIP_DAMAGED, root, "is damaged: its end is missing", "download it again")
        hint = "give the folder of the class or the zip as it was downloaded; unpack a .rar, .7z or .tar.gz first"
        raise _refusal(code, root, "is neither a folder nor a zip", hint)
    except OSError as error:
        raise _refusal(code, root, f"cannot be read: {error.strerror or error}") from None


def read_file(root: Path, name: str, most: int = MAX_BYTES) -> bytes:
    """Read one file of a class, of at most `most` bytes; ``//`` follows a zip in the class. Raises InputError."""
    outer, _, inner = name.rpartition("//")
    try:
        if outer or (root.is_file() and not Path(name).is_absolute()):
            archive, members, _ = _contents(root, outer) if outer else _opened(*_identity(root))
            name = inner
            if name not in members:
                raise FileNotFoundError("it is no longer there")
            if members[name].flag_bits & 0x1:
                raise OSError("it is encrypted")
            if members[name].compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
                # The others unpack a whole block at a time, however large.
                raise OSError("it is packed in a way that no platform uses")
            with archive.open(members[name]) as file:
                data = file.read(most + 1)
        elif (root / name).is_symlink() or not (root / name).is_file():
            raise FileNotFoundError("it is no longer there")
        else:
            with (root / name).open("rb") as plain:
                data = plain.read(most + 1)
        if len(data) <= most:
            return data
        why = f"it is larger than {size_text(most)}"
    except OSError as error:
        why = error.strerror or str(error)
    except (zipfile.BadZipFile, zlib.error, EOFError, RuntimeError, ValueError) as error:
        why = f"it is damaged in the zip ({error})"
    name = name.rpartition("/")[2]
    raise InputError.of(diagnostics.SUBMITTED_FILE_CANNOT_BE_READ, f'"{name}" cannot be read: {why}', file=name)


def _list_folder(root: Path) -> Listing:
    sizes: dict[str, int] = {}
    folders: list[str] = []
    left_out: list[tuple[str, str]] = []

    def closed(error: OSError) -> None:
        if Path(error.filename) == root:
            raise error
        words = f'"{Path(error.filename).relative_to(root).as_posix()}/" cannot be opened and is left out'
        hint = "give yourself the right to read it, such as with chmod -R u+rX"
        left_out.append((f"{words}: {error.strerror}", hint))

    for path, inner, files in os.walk(root, onerror=closed):
        below = os.path.relpath(path, root).replace(os.sep, "/") + "/" if path != str(root) else ""
        folders.append(below)
        inner[:] = [name for name in inner if not _STREWN.search(f"{below}{name}/")]
        for name in (f"{below}{name}" for name in (*inner, *files) if not _STREWN.search(f"{below}{name}")):
            state = os.lstat(root / name)
            if stat.S_ISLNK(state.st_mode):
                # It may lead to the files of another student, or of the grader.
                hint = "put a copy of what it leads to in its place, if it belongs there"
                left_out.append((f'"{name}" is a link and is left out', hint))
            elif stat.S_ISREG(state.st_mode):
                sizes[name] = state.st_size
        _check_number(root, len(folders) + len(sizes))
    notes = tuple(Diagnostic.of(diagnostics.FILE_LEFT_OUT, *words, root.name) for words in sorted(left_out))
    return Listing(root, dict(sorted(sizes.items())), tuple(sorted(folders)[1:]), notes)


def _identity(root: Path) -> tuple[Path, int, int, int]:
    """Identify an archive for `_opened`; processes must not share one open file."""
    state = root.stat()
    return root, state.st_mtime_ns, state.st_size, os.getpid()


@lru_cache(maxsize=2)
def _opened(
    root: Path, changed: int, size: int, process: int
) -> tuple[zipfile.ZipFile, dict[str, zipfile.ZipInfo], Listing]:
    """Open a zip with a safe table of contents, and list it."""
    with root.open("rb") as file:
        file.seek(max(0, size - MOST_DIRECTORY_BYTES))
        # The entries are counted before anything is built from them.
        _check_number(root, file.read().count(b"PK\x01\x02"))
    return _contents(root)


def list_inner(root: Path, name: str, depth: int = 1) -> dict[str, int]:
    """List the files of a zip in a submission, and of zips in it, by names for `read_file`. Raises InputError."""
    found: dict[str, int] = {}
    for inner, size in _contents(root, name)[2].sizes.items():
        whole = f"{name}//{inner}"
        if inner.lower().endswith(".zip") and depth < MOST_LEVELS:
            found |= list_inner(root, whole, depth + 1)
        else:
            found[whole] = size
    return found


def _contents(root: Path, name: str = "") -> tuple[zipfile.ZipFile, dict[str, zipfile.ZipInfo], Listing]:
    """Open the zip of a class, or a zip in the class, and list it."""
    source, place = (io.BytesIO(read_file(root, name, MOST_INNER)), Path(name)) if name else (root, root)
    try:
        archive = zipfile.ZipFile(source)
    except (zipfile.BadZipFile, NotImplementedError, ValueError, struct.error) as error:
        raise _refusal(diagnostics.ZIP_DAMAGED, place, f"is damaged: {error}", "download it again") from None
    _check_number(place, len(archive.infolist()))
    files: dict[str, zipfile.ZipInfo] = {}
    folders, twice = set(), set()
    for info in archive.infolist():
        inner = "/".join(part for part in _safe_name(place, info).split("/") if part not in ("", "."))
        if _STREWN.search(f"{inner}/" if info.is_dir() else inner):
            continue
        if info.is_dir():
            folders.add(f"{inner}/")
        elif inner:
            twice |= {inner} & files.keys()
            files[inner] = info
    notes = []
    for inner in sorted(twice):
        message, hint = f'the zip contains "{inner}" twice; the later one is read', "take one of the two out of the zip"
        notes.append(Diagnostic.of(diagnostics.FILE_LEFT_OUT, message, hint, root.name))
    sizes = {inner: info.file_size for inner, info in sorted(files.items())}
    return archive, files, Listing(root, sizes, tuple(sorted(folders)), tuple(notes))


def _safe_name(root: Path, info: zipfile.ZipInfo) -> str:
    """Decode a name, as UTF-8 if possible, because macOS does not mark UTF-8; refuse a name that leads elsewhere."""
    name = info.orig_filename
    if not info.flag_bits & 0x800:
        with suppress(UnicodeError):
            name = name.encode("cp437").decode("utf-8")
    name = name.replace("\\", "/")
    why = 'leads out of its folder with ".."' if ".." in name.split("/") else ""
    why = why or ("is an absolute path" if re.match(r"/|[A-Za-z]:", name) else "")
    why = why or ("is a link" if stat.S_ISLNK(info.external_attr >> 16) else "")
    if why := why or ("contains a NUL" if "\x00" in name else ""):
        hint = "no platform writes such a zip; ask who made it, and take that file out"
        raise _refusal(diagnostics.ZIP_NOT_SAFE, root, f'is not read: "{shown(name)[:100]}" {why}', hint)
    return name
