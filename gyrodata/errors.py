"""Diagnostics: what is wrong, the place, and what to type.

One `Diagnostic` is one fault at one place; one family of errors carries them to the only handler, in
`gyrodata.cli`. What each code means stands in `gyrodata.diagnostics`.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Collection, Iterable
from functools import lru_cache
from types import UnionType
from typing import Any, TypedDict

from msgspec import Struct, convert

from gyrodata.diagnostics import SEVERITIES, Severity

_TURNING = (0x61C, 0x200E, 0x200F, *range(0x2028, 0x202F), *range(0x2066, 0x206A))
"""Marks that turn the direction of a line, or break it: what follows would be read otherwise than it stands."""

PICTURES = {
    **{code: 0x2400 + code for code in range(32) if code != ord("\n")},
    **dict.fromkeys((*range(0x7F, 0xA0), *_TURNING), 0xFFFD),
}
"""Control characters as pictures of themselves, for `str.translate`: a log's text must not move a terminal's cursor."""


def printable(name: str) -> str:
    """Give a file name as it can be printed: a byte that is no UTF-8 becomes a question mark."""
    return name.encode("utf-8", "replace").decode("utf-8")


# Letters may need a joiner; nothing needs an override of the direction or a bell.
_JOINERS = "\u200c\u200d"


def shown(text: object) -> str:
    """Give a text as it can be printed: one line, composed letters, no control characters or marks that turn it."""
    return _shown(str(text))


# Every student's pages contain the titles of a rubric.
@lru_cache(maxsize=512)
def _shown(text: str) -> str:
    line = " ".join(printable(text).split())
    if line.isprintable() and unicodedata.is_normalized("NFC", line):
        return line
    kept = (one for one in line if one in _JOINERS or unicodedata.category(one) not in ("Cc", "Cf"))
    return " ".join(unicodedata.normalize("NFC", "".join(kept)).split())


class DiagnosticJson(TypedDict):
    """One fault, at one place, with what to do about it."""

    code: str
    """Stable code; ``gyro schema diagnostics`` lists them all."""
    severity: Severity
    """An error means that the log cannot be analysed as it is."""
    file: str
    line: int | None
    """From 1; null where the fault has no single place."""
    column: int | None
    """From 1, in characters."""
    message: str
    """What is wrong."""
    hint: str
    """What to type."""


class Diagnostic(Struct, frozen=True):
    """One fault, at one place, with what to do about it.

    Attributes
    ----------
    code : str
        Stable code, a key of `SEVERITIES`.
    severity : {"error", "warning", "note"}
        An error means that the log cannot be analysed as it stands.
    message : str
        What is wrong.
    hint : str
        What to type.
    file : str
        What the file is called: its path as it was given, if that is relative.
    line, column : int or None
        1-based, as an editor counts; None where the fault has no single place.
    excerpt : str
        The line as it stands in the file, or "".
    width : int
        Number of characters at fault, for the mark below the excerpt.
    doubt : str
        Why the answer must not be quoted, if this finding makes it so: "ball", "size", "contradiction", "exponent",
        "scatter" or "pattern"; else "".
    cell : str
        Cell of a workbook, such as "Sheet2!B5"; else "".
    """

    code: str
    severity: Severity
    message: str
    hint: str = ""
    file: str = ""
    line: int | None = None
    column: int | None = None
    excerpt: str = ""
    width: int = 1
    doubt: str = ""
    cell: str = ""

    @classmethod
    def of(cls, code: str, message: str, *about: Any, **more: Any) -> Diagnostic:
        """Make one of the severity that its code has; what follows the message is as in the record."""
        return cls(code, SEVERITIES[code], message, *about, **more)

    def to_dict(self) -> DiagnosticJson:
        """Give the diagnostic as it is in every JSON, without its excerpt."""
        return convert({name: getattr(self, name) for name in DiagnosticJson.__annotations__}, DiagnosticJson)

    def __str__(self) -> str:
        numbers = [str(n) for n in (self.line, self.column) if n is not None]
        where = ":".join(filter(None, [self.file, self.cell] if self.cell else [self.file, *numbers]))
        head = f"{self.severity} {self.code}: {self.message}"
        lines = [f"{where}: {head}" if where else head]
        if self.excerpt and self.column is not None:
            shown, before = _window(self.excerpt, self.column - 1)
            mark = " " * before + "^" * max(1, min(self.width, len(shown) - before))
            lines.append(f"   {shown}")
            hint, *more = self.hint.split("\n")
            lines += [f"   {mark}  {hint}".rstrip(), *(f"   {line}" for line in more)]
        elif self.hint:
            lines += [f"   {line}" for line in self.hint.split("\n")]
        return "\n".join(lines).translate(PICTURES)


def _window(excerpt: str, position: int, width: int = 96) -> tuple[str, int]:
    """Cut a long line to what stands around `position`; tabs become single blanks so that marks line up."""
    text = "".join(" " if character in "\t\r\n\v\f" else character for character in excerpt)
    start = 0 if position < width - 16 else position - width // 2
    cut = text[start : start + width]
    if start:
        cut = "…" + cut[1:]
    if start + width < len(text):
        cut = cut[:-1] + "…"
    return cut, min(max(position - start, 0), len(cut))


def insist_on_choice(name: str, value: object, choices: Collection[str]) -> None:
    """Refuse an argument of a function that is none of its choices, with the nearest of them (ValueError)."""
    if value not in choices:
        from difflib import get_close_matches

        near = get_close_matches(str(value).lower(), choices, n=1)
        meant = f"; did you mean {near[0]!r}?" if near else ""
        raise ValueError(f"{name} cannot be {value!r}; it is one of {', '.join(map(repr, choices))}{meant}")


def insist_on_type(name: str, value: object, kinds: type | UnionType, what: str) -> None:
    """Refuse an argument of a function that is of no type that it can be (TypeError)."""
    if not isinstance(value, kinds):
        raise TypeError(f"{name} is {what}, not {type(value).__name__} ({value!r:.60})")


class GyroError(Exception):
    """Base of all errors that a user can cause, with their diagnostics.

    Parameters
    ----------
    diagnostics : iterable of Diagnostic
        All faults found, at least one.
    """

    exit_code = 2

    def __init__(self, diagnostics: Iterable[Diagnostic]) -> None:
        self.diagnostics = tuple(diagnostics)
        super().__init__("\n".join(str(diagnostic) for diagnostic in self.diagnostics))

    def __reduce__(self) -> tuple[type[GyroError], tuple[tuple[Diagnostic, ...]]]:
        # Errors cross process borders when a class is graded in parallel.
        return type(self), (self.diagnostics,)


class InputError(GyroError):
    """The input is not a log that can be read at all, or an option makes no sense (exit code 2)."""

    @classmethod
    def of(cls, code: str, message: str, hint: str = "", file: str = "") -> InputError:
        """Make the error of one fault."""
        return cls([Diagnostic.of(code, message, hint, file)])


class LogError(GyroError):
    """The log was read, and is wrong or incomplete (exit code 1)."""

    exit_code = 1
