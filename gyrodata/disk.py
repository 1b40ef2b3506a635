"""Files written whole or not at all, through no link, and by one gyro at a time in a folder.

After a power cut, a file that is written with `sync` is as it was or as it is to be. Others may be torn then; they are
those that the same command makes again. A sync costs 5 ms to 20 ms, so that not every page has one.
"""

from __future__ import annotations

import os
import re
import shutil
import sys
import zlib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

from gyrodata.diagnostics import FOLDER_IN_USE
from gyrodata.errors import InputError

LONGEST = 255  # bytes of a name, on nearly every file system

LOCK = ".gyro-lock"  # next to the output, while a process writes

_FLAGS = os.O_CREAT | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)


@contextmanager
def telling(folder: Path, code: str) -> Iterator[None]:
    """Make an error in words, of this code, of what the system says when a folder is written to."""
    try:
        yield
    except OSError as error:
        message = f'"{folder}" cannot be written: {error.strerror or error}'
        raise InputError.of(code, message, "make room there, or choose another folder with --out") from None


def _unfinished(path: Path) -> Path:
    """Name what is not yet whole; the same each time, so that the next run writes over what a killed one left."""
    return path.with_name(f".gyro-{zlib.crc32(os.fsencode(path.name)):08x}.part")


def make_folder(folder: Path, private: bool = False) -> None:
    """Make a folder and those around it; a private one is its owner's alone, one that is there stays as it is."""
    if private:
        folder.parent.mkdir(parents=True, exist_ok=True)
    folder.mkdir(0o700 if private else 0o777, parents=True, exist_ok=True)


@contextmanager
def new_file(path: Path, private: bool = False, sync: bool = False) -> Iterator[IO[bytes]]:
    """Give a file to write to, which takes its place once it is whole; until then what is there stays.

    The mode of what is there is kept; else a private file is its owner's alone. OSError if the file cannot be written,
    InputError if another gyro writes the same.
    """
    make_folder(path.parent, private)
    unfinished = _unfinished(path)
    number = os.open(unfinished, os.O_RDWR | _FLAGS, 0o600 if private else 0o666)
    with os.fdopen(number, "wb") as file:
        _take(number, path)
        try:
            os.ftruncate(number, 0)
            _keep_mode(path, unfinished)
            yield file
            file.flush()
            if sync:
                os.fsync(number)
        except BaseException:
            with suppress(OSError):
                unfinished.unlink()
            raise
    try:
        unfinished.replace(path)
    except OSError:
        with suppress(OSError):
            unfinished.unlink()
        raise
    if sync and os.name == "posix":
        folder = os.open(path.parent, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)


def _keep_mode(path: Path, new: Path) -> None:
    """Give a new file the mode of the one whose place it takes."""
    if path.is_file() and not path.is_symlink():
        new.chmod(path.stat().st_mode & 0o777)


def write_whole(path: Path, parts: Iterable[bytes], private: bool = False, sync: bool = False) -> None:
    """Write a file, whole or not at all, as `new_file` does."""
    with new_file(path, private, sync) as file:
        file.writelines(parts)


def write_folder(folder: Path, contents: Mapping[str, bytes]) -> None:
    """Write files into a folder once all of them are whole; until then what is there stays, and others' files do.

    OSError if they cannot be written; InputError if another gyro is at work.
    """
    there = folder.exists()
    try:
        with alone_in(folder):
            unfinished = _unfinished(folder / "new")
            try:
                for name, data in contents.items():
                    write_whole(unfinished / name, [data])
                    _keep_mode(folder / name, unfinished / name)
                # To rename takes no room on a disk.
                for name in contents:
                    (unfinished / name).replace(folder / name)
            finally:
                shutil.rmtree(unfinished, ignore_errors=True)
    except OSError:
        if not there:
            with suppress(OSError):
                folder.rmdir()
        raise


def add_to(path: Path, data: bytes) -> None:
    """Write at the end of a private file, which is made if it is not there."""
    with os.fdopen(os.open(path, os.O_WRONLY | os.O_APPEND | _FLAGS, 0o600), "wb") as file:
        file.write(data)


def files_like(folder: Path, pattern: str) -> list[Path]:
    """List what is called so in a folder, if it is there; OSError if it cannot be read: a glob would be silent."""
    try:
        return [path for path in sorted(folder.iterdir()) if path.match(pattern)]
    except FileNotFoundError:
        return []


# --- one at a time ------------------------------------------------------------------------------------------


@contextmanager
def alone_in(folder: Path, private: bool = False) -> Iterator[None]:
    """Be the only gyro that writes into a folder, which is made if it is not there.

    The system takes a lock away with its process, however that ends. OSError if nothing can be written; InputError if
    another gyro is at work.
    """
    make_folder(folder, private)
    path = folder / LOCK
    number = os.open(path, os.O_RDWR | _FLAGS, 0o666)
    try:
        _take(number, path)
        try:
            yield
        finally:
            with suppress(OSError):
                path.unlink()  # before the lock is gone; Windows wants that the other way round
    finally:
        os.close(number)
        if os.name == "nt":
            with suppress(OSError):
                path.unlink()


def _take(number: int, path: Path) -> None:
    """Lock an open file; refuse if another process has it, or has taken it away since it was opened here."""
    free = True
    try:
        if sys.platform == "win32":
            import msvcrt

            msvcrt.locking(number, msvcrt.LK_NBLCK, 1)
        else:
            import fcntl

            fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
            free = os.fstat(number).st_nlink > 0
    except (BlockingIOError, PermissionError):
        free = False
    except (ImportError, OSError):
        pass  # a file system without locks: everybody is let in
    if not free:
        message = f'another gyro is at work here: "{path.parent}"'
        hint = "wait until it is done, then run it again; or choose another folder with --out"
        raise InputError.of(FOLDER_IN_USE, message, hint)


# --- names --------------------------------------------------------------------------------------------------


_FORBIDDEN = re.compile(r'[<>:"/\\|?*\x00-\x1f\x7f]|[. ]$')
_DEVICE = re.compile(r"(?i)(?:con|prn|aux|nul|com[0-9¹²³]|lpt[0-9¹²³]) *(?:\.|$)")


def file_name(name: str, room: int = 0) -> str:
    """Give a name of a file or folder that every system can write, and that is nobody else's.

    Characters that Windows forbids become a _, its devices get one; with `room` [byte] for what follows it is at most
    255 bytes long. A name that is changed ends in a digest of what it was.
    """
    told = _FORBIDDEN.sub("_", name) or "_"
    if _DEVICE.match(told):
        told = f"_{told}"
    if told == name and len(os.fsencode(name)) + room <= LONGEST:
        return name
    import hashlib  # not needed by every command

    digest = f"-{hashlib.sha256(os.fsencode(name)).hexdigest()[:8]}"
    return os.fsencode(told)[: LONGEST - room - len(digest)].decode("utf-8", "ignore").rstrip() + digest
