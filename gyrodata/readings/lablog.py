"""The nouns of the reader: a place in a file, one role's column of readings, the whole log, and its faults."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType
from typing import NamedTuple

from gyrodata.diagnostics import CODES
from gyrodata.errors import Diagnostic, InputError
from gyrodata.readings.reported import Reported
from gyrodata.units import Uncertainty

MOST_OF_ONE_CODE = 100
"""Diagnostics of one code that are shown; a column of text for numbers has as many faults as rows."""


class Place(NamedTuple):
    """Where something stands in a file, counted as an editor counts."""

    line: int
    """1-based."""
    column: int
    """1-based, in characters."""


@dataclass(frozen=True, slots=True)
class Column:
    """One role's readings in SI, one for each of the n runs.

    Attributes
    ----------
    role : str
        Canonical name: ``mass``, ``spin``, ``time``, … (repeats ``time_1``, ``time_2`` have become runs).
    header : str
        As written, or ``# spin`` or ``--set spin`` where one value holds for the whole log.
    unit : str
        Unit as understood, in a spelling that this tool reads back; "" for numbers.
    values : tuple of float or None
        [SI unit of the role]; None where nothing was measured.
    resolutions : tuple of float or None
        One step of the last digit typed anywhere in the column [SI unit of the role]; None where the number is
        exact (a fraction, a plain 0) or its digits are unknown.
    uncertainties : tuple of Uncertainty or None
        What the log says of this reading: its own ±, else its ``u_…`` column, else the header's ±, else the
        ``u_…`` constant.
    readings : tuple of int
        Identity: runs with equal numbers share one reading (filled down, constant, or repeats of one setting).
    places : tuple of Place or None
        Where it stands; None for what an option gave.
    texts : tuple of str
        As typed.
    """

    role: str
    header: str
    unit: str
    values: tuple[float | None, ...]
    resolutions: tuple[float | None, ...]
    uncertainties: tuple[Uncertainty | None, ...]
    readings: tuple[int, ...]
    places: tuple[Place | None, ...]
    texts: tuple[str, ...]


_NOTHING: Mapping[str, str] = MappingProxyType({})


@dataclass(frozen=True)
class Readings:
    """What a log says: one row for each timed run.

    Attributes
    ----------
    name : str
        File name without its folder; ``<stdin>`` for standard input, ``<table>`` for a DataFrame.
    sha256 : str
        Of the bytes read.
    runs : tuple of str
        Labels, unique: ``3``, or ``3.1`` and ``3.2`` for the repeats ``time_1`` and ``time_2`` of one row.
    lines : tuple of int
        Line in the file of each run.
    notes : tuple of str
        Free text of each run.
    columns : mapping of str to Column
        The column used for each role.
    others : tuple of Column
        Further columns of a role that is filled already, and derived ones (``inertia``); for comparison only.
    constants : mapping of str to float
        ``g``, ``ball_diameter``, ``ball_mass`` [SI]; only those given.
    uncertainties : mapping of str to Uncertainty
        Every ``u_…`` given for the whole log.
    balance_tilt : tuple of float or None
        Rod released unspun: angle [rad], time [s].
    balance_drift : tuple of float or None
        Rod released spun, without a weight: angle [rad], time [s], spin [rad/s].
    motion : str or None
        "released" from rest, or "steady"; None where the log does not say.
    metadata : mapping of str to str
        All other ``# key: value`` lines, as written.
    reported : mapping of str to Reported
        What the student reports in ``# reported_KEY: value ± u unit`` lines, for whoever grades it.
    diagnostics : tuple of Diagnostic
        All faults found; with an error among them, `columns` may lack what the analysis needs.
    source_text : str
        The decoded text, for excerpts.
    """

    name: str
    sha256: str
    runs: tuple[str, ...]
    lines: tuple[int, ...]
    notes: tuple[str, ...]
    columns: Mapping[str, Column]
    others: tuple[Column, ...] = ()
    constants: Mapping[str, float] = field(default_factory=dict)
    uncertainties: Mapping[str, Uncertainty] = field(default_factory=dict)
    balance_tilt: tuple[float, float] | None = None
    balance_drift: tuple[float, float, float] | None = None
    motion: str | None = None
    metadata: Mapping[str, str] = field(default_factory=dict)
    reported: Mapping[str, Reported] = field(default_factory=dict)
    diagnostics: tuple[Diagnostic, ...] = ()
    source_text: str = field(default="", repr=False, compare=False)

    @property
    def ok(self) -> bool:
        """Whether no error was found, so that every run has what the analysis needs."""
        return all(diagnostic.severity != "error" for diagnostic in self.diagnostics)

    def diagnose(
        self, code: str, message: str, hint: str = "", place: Place | None = None, width: int = 1
    ) -> Diagnostic:
        """Make a diagnostic of a place of this log, with the excerpt of its line.

        Parameters
        ----------
        code : str
            One of `gyrodata.diagnostics`; it brings the severity.
        message, hint : str
            What is wrong, and what to type.
        place : Place or None
            Where; None where the fault has no single place.
        width : int
            Number of characters at fault.
        """
        return make_diagnostic(self.name, self._lines, code, message, hint, place, width)

    @cached_property
    def _lines(self) -> list[str]:
        return split_lines(self.source_text)


def split_lines(text: str) -> list[str]:
    """Split at the three line ends an editor knows, and at nothing else (`str.splitlines` knows ten)."""
    if "\r" in text:
        text = text.replace("\r\n", "\n").replace("\r", "\n")
    return text.split("\n")


def make_diagnostic(
    name: str,
    lines: list[str],
    code: str,
    message: str,
    hint: str = "",
    place: Place | None = None,
    width: int = 1,
) -> Diagnostic:
    """Make a diagnostic with the severity of its code and the excerpt of its line."""
    if place is None:
        return Diagnostic(code, CODES[code].severity, message, hint, name)
    excerpt = lines[place.line - 1] if 0 < place.line <= len(lines) else ""
    severity = CODES[code].severity
    return Diagnostic(code, severity, message, hint, name, place.line, place.column, excerpt, width)


class Faults:
    """The faults found so far in one log, in the order in which they were found.

    Parameters
    ----------
    name : str
        Shown name of the log.
    text : str
        The decoded text, for excerpts.
    """

    def __init__(self, name: str, text: str = "") -> None:
        self.name = name
        self.lines = split_lines(text) if text else []
        self.found: list[Diagnostic] = []
        self._count: dict[str, int] = {}

    def add(self, code: str, message: str, hint: str = "", place: Place | None = None, width: int = 1) -> None:
        """Note one fault down; arguments as in `Readings.diagnose`. Of one code, the first `MOST_OF_ONE_CODE` only."""
        self._count[code] = self._count.get(code, 0) + 1
        if self._count[code] > MOST_OF_ONE_CODE:
            return
        self.found.append(make_diagnostic(self.name, self.lines, code, message, hint, place, max(1, width)))

    def refuse(self, code: str, message: str, hint: str = "", place: Place | None = None, width: int = 1) -> InputError:
        """Give the error to raise for an input that is no log at all, with what was found before it."""
        self.add(code, message, hint, place, width)
        return InputError(self.found)

    def all_told(self) -> tuple[Diagnostic, ...]:
        """Give what was found, and how much more of it there is."""
        more = [
            make_diagnostic(self.name, self.lines, code, f"{count - MOST_OF_ONE_CODE} more of this kind are not shown")
            for code, count in self._count.items()
            if count > MOST_OF_ONE_CODE
        ]
        return (*self.found, *more)

    def has_error(self) -> bool:
        """Whether anything found so far stops the analysis."""
        return any(diagnostic.severity == "error" for diagnostic in self.found)


def listing(items: list[str] | tuple[str, ...], most: int = 12) -> str:
    """Join for a message, cutting long lists and long items short."""
    shown = [item if len(item) <= 40 else item[:39] + "…" for item in items[:most]]
    more = f" and {len(items) - most} more" if len(items) > most else ""
    return ", ".join(shown) + more


def span(lines: list[int]) -> str:
    """Write line numbers shortly: ``lines 3-5, 7``."""
    parts: list[str] = []
    start = previous = lines[0]
    for line in [*lines[1:], -1]:
        if line == previous + 1:
            previous = line
            continue
        parts.append(str(start) if start == previous else f"{start}-{previous}")
        start = previous = line
    word = "line" if len(lines) == 1 else "lines"
    return f"{word} {listing(parts)}"
