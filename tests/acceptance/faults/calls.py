"""Every call to the system counted, and one of them, or all from one on, made to fail;
or the process ended there.
"""

import _posixsubprocess
import builtins
import errno
import io
import os
import signal
from collections.abc import Callable
from multiprocessing import reduction
from typing import Any

WAYS = ("ENOSPC", "EACCES", "EIO", "kill")
"""What becomes of a call: an error, or the end of the process in the middle of it."""
_NAMED = (
    "open",
    "mkdir",
    "replace",
    "rename",
    "unlink",
    "rmdir",
    "scandir",
    "listdir",
    "fsync",
    "pipe",
    "dup",
    "fork",
)
_WRITING = {"create", "mkdir", "replace", "rename", "fsync", "write"}


class Calls:
    """Counts the calls of this process, and lets the n-th fail; `lasting`: and all that
    write from there on.
    """

    def __init__(self, at: int = 0, way: str = "EIO", lasting: bool = False) -> None:
        self.at, self.way, self.lasting = at, way, lasting
        self.seen: list[str] = []

    def step(
        self,
        what: str,
        about: object = None,
        before: Callable[[], object] = lambda: None,
    ) -> None:
        """Count a call; if it is the one, do `before`, which is the half of it, and
        fail.
        """
        self.seen.append(f"{what} {about}")
        later = (
            self.lasting and self.at and len(self.seen) > self.at and what in _WRITING
        )
        if len(self.seen) != self.at and not later:
            return
        before()
        if self.way == "kill":
            os.kill(os.getpid(), signal.SIGKILL)
        code = getattr(errno, self.way)
        raise OSError(code, os.strerror(code))

    def install(self) -> None:
        """Count from now on, in a process that ends soon, for nothing is put back.

        Pipes between processes are left alone: they break with a process, and give no
        error while both live."""
        for place, name in [
            *((os, name) for name in _NAMED),
            (_posixsubprocess, "fork_exec"),
            (reduction, "sendfds"),
        ]:
            setattr(place, name, self._counted(name, getattr(place, name)))
        calls, real = self, io.open

        class Raw(io.FileIO):
            def readinto(self, buffer: Any) -> int | None:
                calls.step("read")
                return super().readinto(buffer)

            def readall(self) -> bytes:
                calls.step("read")
                return super().readall()

            def write(self, data: Any) -> int | None:
                calls.step(
                    "write",
                    None,
                    lambda: io.FileIO.write(self, bytes(data)[: len(data) // 2]),
                )
                return super().write(data)

        def opened(
            file: Any,
            mode: str = "r",
            buffering: int = -1,
            encoding: str | None = None,
            errors: str | None = None,
            newline: str | None = None,
            closefd: bool = True,
            opener: Any = None,
        ) -> Any:
            if "site-packages" in str(file):  # fonts and code of libraries
                return real(
                    file, mode, buffering, encoding, errors, newline, closefd, opener
                )
            if not isinstance(file, int):
                calls.step("open", file)
            raw = Raw(file, mode.replace("b", "").replace("t", ""), closefd, opener)
            if buffering == 0:
                return raw
            kind: Any = (
                io.BufferedRandom
                if "+" in mode
                else io.BufferedReader
                if "r" in mode
                else io.BufferedWriter
            )
            return (
                kind(raw)
                if "b" in mode
                else io.TextIOWrapper(kind(raw), encoding, errors, newline)
            )

        io.open = builtins.open = opened  # type: ignore[assignment]

    def _counted(self, name: str, call: Callable[..., Any]) -> Callable[..., Any]:
        def counted(*given: Any, **named: Any) -> Any:
            makes = name == "open" and given[1:] and given[1] & os.O_CREAT
            self.step("create" if makes else name, next(iter(given), None))
            return call(*given, **named)

        return counted
