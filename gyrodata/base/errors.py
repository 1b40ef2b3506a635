"""Diagnostics: what is wrong, where, what to type; and errors that contain them.

The only handler of these errors is in `gyrodata.cli`. `gyrodata.base.diagnostics`
reads the messages.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Collection, Iterable
from types import UnionType
from typing import Any, TypedDict

from msgspec import Struct, convert

from gyrodata.base.diagnostics import Severity, message

_TURNING = (0x61C, 0x200E, 0x200F, *range(0x2028, 0x202F), *range(0x2066, 0x206A))
"""Characters that reverse the direction of a line, or break it."""

PICTURES = {code: 0x2400 + code for code in range(32) if chr(code) != "\n"}
PICTURES |= dict.fromkeys((*range(0x7F, 0xA0), *_TURNING), 0xFFFD)
"""Pictures of control characters, for `str.translate`: a log's text must not move the
cursor of a terminal."""


def printable(name: str) -> str:
    """Return a file name that can be printed: a byte that is not UTF-8 becomes "?"."""
    return name.encode("utf-8", "replace").decode("utf-8")


def count_text(count: int, noun: str) -> str:
    """Write a count with its noun: "1 run", "9 runs"."""
    if count == 1:
        return f"{count} {noun}"
    return f"{count} {noun}s"


def shown(text: object) -> str:
    """Return a text for one line: composed letters, no control characters."""
    line = " ".join(printable(str(text)).split())
    if line.isprintable() and unicodedata.is_normalized("NFC", line):
        return line
    kept = ""
    for letter in line:
        is_control = unicodedata.category(letter) in ("Cc", "Cf")
        # Some scripts need the two joiners.
        if letter in "\u200c\u200d" or not is_control:
            kept += letter
    composed = unicodedata.normalize("NFC", kept)
    return " ".join(composed.split())


class DiagnosticJson(TypedDict):
    """One fault at one place, with its remedy."""

    code: str
    """Stable code; ``gyro schema diagnostics`` lists all codes."""
    severity: Severity
    """An error means that the log cannot be analysed as it is."""
    file: str
    line: int | None
    """From 1; null if the fault has no single place."""
    column: int | None
    """From 1, in characters."""
    message: str
    """What is wrong."""
    hint: str
    """What to type."""


class Diagnostic(Struct, frozen=True):
    """One fault at one place, with its remedy.

    Attributes
    ----------
    code : str
        Stable code, a key of `explanations`.
    severity : {"error", "warning", "note"}
        An error means that the log cannot be analysed as it is.
    message : str
        What is wrong.
    hint : str
        What to type.
    file : str
        Name of the file: its path as it was given, if that is relative.
    line, column : int or None
        From 1, as in an editor; None if the fault has no single place.
    excerpt : str
        The line of the file, or "".
    width : int
        Number of wrong characters, for the mark below the excerpt.
    doubt : str
        Kind of doubt if the answer must not be quoted: "ball", "size", "note",
        "contradiction", "exponent" or "scatter"; else "".
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
    def named(
        cls, name: str, file: str = "", line: int | None = None, /, **values: Any
    ) -> Diagnostic:
        """Fill in a message of a file `messages.toml`."""
        about = message(name)
        text = about.text.format(**values)
        hint = about.hint.format(**values)
        return cls(about.code, about.severity, text, hint, file, line)

    def to_dict(self) -> DiagnosticJson:
        """Return the diagnostic as it is in JSON, without its excerpt."""
        names = DiagnosticJson.__annotations__
        values = {name: getattr(self, name) for name in names}
        return convert(values, DiagnosticJson)

    def __str__(self) -> str:
        numbers = [str(n) for n in (self.line, self.column) if n is not None]
        place = [self.cell] if self.cell else numbers
        where = ":".join(filter(None, [self.file, *place]))
        head = f"{self.severity} {self.code}: {self.message}"
        first = f"{where}: {head}" if where else head
        below = self.hint.split("\n") if self.hint else []
        if self.excerpt and self.column is not None:
            window, before = _window(self.excerpt, self.column - 1)
            width = min(self.width, len(window) - before)
            mark = " " * before + "^" * max(1, width)
            hint, *more = below or [""]
            below = [window, f"{mark}  {hint}".rstrip(), *more]
        lines = [first, *(f"   {line}" for line in below)]
        return "\n".join(lines).translate(PICTURES)


def _window(excerpt: str, position: int, width: int = 96) -> tuple[str, int]:
    """Cut a long line to the part around `position`, and return its place there.

    A tab becomes one blank, so that the mark is below its place.
    """
    text = excerpt.translate(dict.fromkeys(map(ord, "\t\r\n\v\f"), " "))
    start = 0 if position < width - 16 else position - width // 2
    end = start + width
    cut = text[start:end]
    if start:
        cut = "…" + cut[1:]
    if end < len(text):
        cut = cut[:-1] + "…"
    before = max(position - start, 0)
    return cut, min(before, len(cut))


def insist_on_choice(name: str, value: object, choices: Collection[str]) -> None:
    """Raise a ValueError if an argument of a function is not one of its choices.

    It names the nearest choice.
    """
    if value not in choices:
        from difflib import get_close_matches

        near = get_close_matches(str(value).lower(), choices, n=1)
        meant = f"; did you mean {near[0]!r}?" if near else ""
        listed = ", ".join(map(repr, choices))
        raise ValueError(f"{name} cannot be {value!r}; it is one of {listed}{meant}")


def insist_on_type(
    name: str, value: object, kinds: type | UnionType, what: str
) -> None:
    """Raise a TypeError if an argument of a function has another type."""
    if not isinstance(value, kinds):
        kind = type(value).__name__
        raise TypeError(f"{name} is {what}, not {kind} ({value!r:.60})")


def nearest(word: str, known: Iterable[str], otherwise: str = "") -> str:
    """Propose the known word that is probably meant.

    Else say what to do `otherwise`, or list all words.
    """
    from difflib import get_close_matches

    words = list(known)
    close = get_close_matches(word.lower(), words, n=1)
    if close:
        return f"did you mean {close[0]}?"
    return otherwise or f"known here: {', '.join(words)}"


class GyroError(Exception):
    """Base of all errors that a user can cause.

    Parameters
    ----------
    diagnostics : iterable of Diagnostic
        All faults found, at least one.
    """

    exit_code = 2

    def __init__(self, diagnostics: Iterable[Diagnostic]) -> None:
        self.diagnostics = tuple(diagnostics)
        text = "\n".join(map(str, self.diagnostics))
        super().__init__(text)

    def __reduce__(self) -> tuple[type[GyroError], tuple[tuple[Diagnostic, ...]]]:
        # Worker processes send their errors to the main process.
        return type(self), (self.diagnostics,)


class InputError(GyroError):
    """The input is not a log, or an option is wrong (exit code 2)."""

    @classmethod
    def named(cls, name: str, file: str = "", /, **values: Any) -> InputError:
        """Make an error of one message of a file `messages.toml`."""
        return cls([Diagnostic.named(name, file, **values)])


class LogError(GyroError):
    """The log was read, but it is wrong or incomplete (exit code 1)."""

    exit_code = 1
