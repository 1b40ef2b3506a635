"""Files as a database writes them: whole or not at all, through no link, and by one gyro at a time in a folder.

What holds after a power cut: a file that is written with `sync` is as it was or as it is to be. Others may be torn
then; they are those that the same command makes again. A sync costs 5 ms to 20 ms, so that not every page has one.
"""

from __future__ import annotations

import os
import re
import shutil
import stat
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

from gyrodata.diagnostics import FOLDER_IN_USE
from gyrodata.errors import InputError

LONGEST = 255  # bytes of a name, on nearly every file system

LOCK = ".gyro-lock"  # beside what is written, as long as somebody writes

_UNFINISHED = re.compile(r"\.gyro-[0-9a-f]{16}\.part")

_NEW = os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
_NO_LINK = getattr(os, "O_NOFOLLOW", 0)


def _unfinished(folder: Path) -> Path:
    """Name what is not yet whole, as nobody can foresee who would plant a link there."""
    return folder / f".gyro-{os.urandom(8).hex()}.part"


@contextmanager
def telling(folder: Path, code: str) -> Iterator[None]:
    """Make an error in words, of this code, of what the system says when a folder is written to."""
    try:
        yield
    except OSError as error:
        message = f'"{folder}" cannot be written: {error.strerror or error}'
        raise InputError.of(code, message, "make room there, or choose another folder with --out") from None


@contextmanager
def new_file(path: Path, private: bool = False, sync: bool = False) -> Iterator[IO[bytes]]:
    """Give a file to write to, which takes its place once it is whole; until then what stands there stays.

    The mode of what stands there is kept; else a private file is its owner's alone. OSError if it cannot be.
    """
    unfinished = _unfinished(path.parent)
    number = _create(unfinished, private)
    try:
        with os.fdopen(number, "wb") as file:
            _taken(number)  # so that nobody takes it for a rest
            _keep_mode(path, number)
            yield file
            file.flush()
            if sync:
                os.fsync(number)
            if os.name != "nt":
                unfinished.replace(path)
        if os.name == "nt":
            unfinished.replace(path)  # not while it is open
    except BaseException:
        with suppress(OSError):
            unfinished.unlink()
        raise
    if sync:
        _sync_folder(path.parent)


def write_whole(path: Path, parts: Iterable[bytes], private: bool = False, sync: bool = False) -> None:
    """Write a file, whole or not at all, as `new_file` does."""
    with new_file(path, private, sync) as file:
        file.writelines(parts)


def write_changed(path: Path, data: bytes, private: bool = False, sync: bool = False) -> bytes | None:
    """Write a file, whole or not at all, unless it is so already: to look costs a tenth of writing over a file.

    Gives: What stood there instead; None for nothing, or the same.
    """
    try:
        before = path.read_bytes()
    except OSError:
        before = None  # not there, or worse: writing tells
    if before == data:
        return None
    write_whole(path, [data], private, sync)
    return before


def write_folder(folder: Path, contents: Mapping[str, bytes]) -> None:
    """Write files into a folder once all of them are whole; until then what is there stays, and others' files do.

    OSError if they cannot be; InputError where another gyro is at work.
    """
    there = folder.exists()
    try:
        with alone_in(folder):
            unfinished = _unfinished(folder)
            unfinished.mkdir()
            try:
                for name, data in contents.items():
                    number = _create(unfinished / name, False)
                    with os.fdopen(number, "wb") as file:
                        _keep_mode(folder / name, number)
                        file.write(data)
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
    flags = os.O_WRONLY | os.O_APPEND | os.O_CREAT | _NO_LINK | getattr(os, "O_BINARY", 0)
    with os.fdopen(os.open(path, flags, 0o600), "wb") as file:
        file.write(data)


def _create(path: Path, private: bool) -> int:
    """Make a file that is not there yet, and the folder for it; give its descriptor."""
    mode = 0o600 if private else 0o666
    try:
        return os.open(path, os.O_WRONLY | _NEW | _NO_LINK, mode)
    except FileNotFoundError:
        make_folder(path.parent, private)
        return os.open(path, os.O_WRONLY | _NEW | _NO_LINK, mode)


def make_folder(folder: Path, private: bool = False) -> None:
    """Make a folder and those around it; a private one is its owner's alone, one that is there stays as it is."""
    if private:
        folder.parent.mkdir(parents=True, exist_ok=True)
    folder.mkdir(0o700 if private else 0o777, parents=True, exist_ok=True)


def _keep_mode(path: Path, number: int) -> None:
    """Give an open file the mode of the one whose place it takes."""
    if hasattr(os, "fchmod"):
        with suppress(OSError):
            mode = path.lstat().st_mode
            if stat.S_ISREG(mode):
                os.fchmod(number, stat.S_IMODE(mode))


def _sync_folder(folder: Path) -> None:
    """See that the names in a folder outlast a power cut, where the system lets a folder be opened."""
    if os.name == "posix":
        number = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(number)
        finally:
            os.close(number)


# --- one at a time ------------------------------------------------------------------------------------------


@contextmanager
def alone_in(folder: Path, ours: bool = False) -> Iterator[None]:
    """Be the only gyro that writes into a folder, which is made if it is not there; a killed one's rests go.

    `ours`: all below the folder is gyro's and private. The system lets a lock go with its process, however that ends.
    OSError if nothing can be written; InputError if another gyro is at work.
    """
    make_folder(folder, ours)
    number = _lock(folder)
    try:
        clear(folder, ours)
        yield
        clear(folder, ours)  # of a worker that was killed
    finally:
        # Gone before it is let go; Windows wants that the other way round.
        with suppress(OSError):
            (folder / LOCK).unlink()
        os.close(number)
        if os.name == "nt":
            with suppress(OSError):
                (folder / LOCK).unlink()


def _lock(folder: Path) -> int:
    """Lock a folder by a file in it; give the descriptor that holds the lock."""
    path = folder / LOCK
    while True:
        try:
            number = os.open(path, os.O_RDWR | os.O_CREAT | _NO_LINK, 0o666)
        except PermissionError:
            number = os.open(path, os.O_RDONLY | _NO_LINK)  # another's, who was killed
        try:
            if not _taken(number):
                message = f'another gyro is at work here: "{folder}"'
                hint = "wait until it is done, then run it again; or choose another folder with --out"
                raise InputError.of(FOLDER_IN_USE, message, hint)
            # Whoever had it may have taken the file away after it was opened here.
            with suppress(FileNotFoundError):
                if os.path.samestat(os.fstat(number), path.lstat()):
                    return number
        except BaseException:
            os.close(number)
            raise
        os.close(number)


def _taken(number: int) -> bool:
    """Take a lock; False if another process has it. Where there are no locks, everybody is let in."""
    if sys.platform == "win32":
        import msvcrt

        try:
            msvcrt.locking(number, msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        return True
    try:
        import fcntl

        fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except (ImportError, OSError):
        return True
    return True


def clear(folder: Path, below: bool = False) -> None:
    """Take away what killed processes never finished in a folder, and in those below it."""
    with suppress(OSError), os.scandir(folder) as found:
        for entry in found:
            deep = entry.is_dir(follow_symlinks=False)
            if _UNFINISHED.fullmatch(entry.name):
                if deep:
                    shutil.rmtree(entry.path, ignore_errors=True)
                else:
                    _remove(Path(entry.path))
            elif deep and below:
                clear(Path(entry.path), below)


def _remove(path: Path) -> None:
    """Remove a file that nobody is writing any more."""
    with suppress(OSError):
        number = os.open(path, os.O_RDONLY | _NO_LINK)
        try:
            left = _taken(number)
        finally:
            os.close(number)
        if left:
            path.unlink()


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


# --- what is there ------------------------------------------------------------------------------------------


def files_like(folder: Path, pattern: str) -> list[Path]:
    """List what is called so in a folder, if it is there; OSError where it cannot be read, where a glob is silent."""
    try:
        return [path for path in sorted(folder.iterdir()) if path.match(pattern)]
    except FileNotFoundError:
        return []
