"""A shelf: what a class needs again but need not be held in memory, for a class may be large."""

from __future__ import annotations

import pickle
import tempfile
import weakref
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TypeVar

from gyrodata.errors import Diagnostic, InputError, register

Thing = TypeVar("Thing")

G768 = register(
    "G768", "error", "there is no room for temporary files", "grade class, with a temporary folder that is full"
)


class Shelf(Mapping[str, Thing]):
    """Things by key, in a temporary file that nobody else sees; each look makes the thing anew.

    Raises
    ------
    InputError
        There is no room for it; so do `put` and every look.
    """

    def __init__(self) -> None:
        with _room():
            self._file = tempfile.TemporaryFile(prefix="gyro-")  # noqa: SIM115 (closed with the shelf)
        weakref.finalize(self, self._file.close)
        self._places: dict[str, int] = {}
        self._end = 0

    def put(self, key: str, thing: Thing) -> None:
        """Put a thing on it, in the place of what had its key before."""
        data = pickle.dumps(thing, pickle.HIGHEST_PROTOCOL)
        with _room():
            self._file.seek(self._end)
            self._file.write(data)
        self._places[key] = self._end
        self._end += len(data)

    def __getitem__(self, key: str) -> Thing:
        place = self._places[key]
        with _room():
            self._file.seek(place)  # what still waits to be written is written here
            thing: Thing = pickle.load(self._file)
        return thing

    def __contains__(self, key: object) -> bool:
        return key in self._places

    def __iter__(self) -> Iterator[str]:
        return iter(self._places)

    def __len__(self) -> int:
        return len(self._places)


@contextmanager
def _room() -> Iterator[None]:
    try:
        yield
    except OSError as error:
        message = f"there is no room for temporary files: {error.strerror or error}"
        hint = "make room, or name another folder for them in the variable TMPDIR"
        raise InputError([Diagnostic(G768, "error", message, hint)]) from None
