"""Write files completely or not at all, by one gyro at a time in a folder.

After a power cut, a file that was written with `sync` is either old or new. Other files
may be damaged then; the same command writes them again. A sync takes 5 ms to 20 ms, too
long for every page.
"""

from __future__ import annotations

import errno
import os
import re
import sys
import zlib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import IO

from gyrodata.base.errors import InputError

LONGEST = 255  # bytes of a name, on nearly every file system

LOCK = ".gyro-lock"  # next to the output while a process writes

_FLAGS = os.O_CREAT | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)


@contextmanager
def telling(folder: Path, name: str = "report_not_written") -> Iterator[None]:
    """Turn an OSError of writing into a folder into an InputError with this message."""
    try:
        yield
    except OSError as error:
        room = "make room there, or " if error.errno == errno.ENOSPC else ""
        why = error.strerror or error
        raise InputError.named(name, folder=folder, why=why, room=room) from None


def _make_folder(folder: Path, private: bool) -> None:
    if not folder.is_dir():
        folder.parent.mkdir(parents=True, exist_ok=True)
        folder.mkdir(0o700 if private else 0o777, exist_ok=True)


@contextmanager
def new_file(
    path: Path, private: bool = False, sync: bool = False
) -> Iterator[IO[bytes]]:
    """Give a file to write to, which replaces the file at `path` once it is complete.

    The mode of the old file is kept; a new private file can be read by its owner only.
    Raises OSError if the file cannot be written, InputError if another gyro writes the
    same file.
    """
    _make_folder(path.parent, private)
    # Always the same name, so that a run replaces what a killed one left.
    name_sum = zlib.crc32(os.fsencode(path.name))
    unfinished = path.with_name(f".gyro-{name_sum:08x}.part")
    mode = 0o600 if private else 0o666
    number = os.open(unfinished, os.O_RDWR | _FLAGS, mode)
    try:
        with os.fdopen(number, "wb") as file:
            _lock(number, path)
            os.ftruncate(number, 0)
            if path.is_file() and not path.is_symlink():
                unfinished.chmod(path.stat().st_mode & 0o777)
            yield file
            file.flush()
            if sync:
                os.fsync(number)
        unfinished.replace(path)
    except BaseException as error:
        if not isinstance(error, InputError):  # then the file is another gyro's
            with suppress(OSError):
                unfinished.unlink()
        raise


def write_whole(
    path: Path, parts: Iterable[bytes], private: bool = False, sync: bool = False
) -> None:
    """Write a file, completely or not at all, as `new_file` does."""
    with new_file(path, private, sync) as file:
        file.writelines(parts)


def write_folder(folder: Path, contents: Mapping[str, bytes]) -> None:
    """Write files into a folder once all of them are complete.

    Until then the old files stay, and other files always.

    Raises OSError if they cannot be written, InputError if another gyro writes into the
    folder.
    """
    try:
        with alone_in(folder), ExitStack() as files:
            for name, content in contents.items():
                file = files.enter_context(new_file(folder / name))
                file.write(content)
                file.flush()  # to close and to rename it takes no room on a disk
    except OSError:
        with suppress(OSError):
            folder.rmdir()  # if it is empty
        raise


def add_to(path: Path, content: bytes) -> None:
    """Write at the end of a private file; make the file if there is none."""
    number = os.open(path, os.O_WRONLY | os.O_APPEND | _FLAGS, 0o600)
    with os.fdopen(number, "wb") as file:
        file.write(content)


@contextmanager
def alone_in(folder: Path, private: bool = False) -> Iterator[None]:
    """Be the only gyro that writes into a folder; make the folder if there is none.

    The system removes a lock when its process ends. Raises OSError if nothing can be
    written, InputError if another gyro writes there.
    """
    _make_folder(folder, private)
    path = folder / LOCK
    number = os.open(path, os.O_RDWR | _FLAGS, 0o666)
    with os.fdopen(number, "wb"):
        _lock(number, path)
        try:
            yield
        finally:
            with suppress(OSError):
                path.unlink()  # while it is locked; Windows needs the other order
    if os.name == "nt":
        with suppress(OSError):
            path.unlink()


def _lock(number: int, path: Path) -> None:
    """Lock an open file.

    Refuse if another process has locked it, or has removed it since it was opened.
    """
    try:
        if sys.platform == "win32":
            import msvcrt

            msvcrt.locking(number, msvcrt.LK_NBLCK, 1)
        else:
            import fcntl

            fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if not os.fstat(number).st_nlink:
                raise PermissionError("the file is gone")
    except (BlockingIOError, PermissionError):
        raise InputError.named("folder_in_use", folder=path.parent) from None
    except (ImportError, OSError):
        pass  # a file system without locks


_FORBIDDEN = re.compile(r'[<>:"/\\|?*\x00-\x1f\x7f]|[. ]$')
_DEVICE = re.compile(r"(?i)^(?:con|prn|aux|nul|com[0-9¹²³]|lpt[0-9¹²³]) *(?:\.|$)")


def file_name(name: str, room: int = 0) -> str:
    """Return a name that every system can write; different names stay different.

    Characters that Windows forbids become a _, and its device names get one in front.
    The name has at most 255 bytes with `room` bytes for an ending. A changed name ends
    in a digest of the original.
    """
    allowed = _FORBIDDEN.sub("_", name) or "_"
    safe = _DEVICE.sub(r"_\g<0>", allowed)
    original = os.fsencode(name)
    if safe == name and len(original) + room <= LONGEST:
        return name
    import hashlib  # not needed by every command

    digest = hashlib.sha256(original).hexdigest()[:8]
    ending = f"-{digest}"
    longest = LONGEST - room - len(ending)
    kept = os.fsencode(safe)[:longest]
    return kept.decode("utf-8", "ignore").rstrip() + ending
