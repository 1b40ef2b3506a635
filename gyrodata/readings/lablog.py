"""The nouns of the reader: a place in a file, one role's column of readings, the whole log, and its faults."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from itertools import groupby
from typing import NamedTuple

from msgspec import Struct, field
from msgspec.structs import replace

from gyrodata.errors import Diagnostic, InputError
from gyrodata.readings.cells import Reported
from gyrodata.units import Uncertainty

MOST_OF_ONE_CODE = 100
"""Diagnostics of one code that are shown; a column of text for numbers has as many faults as rows."""


class Place(NamedTuple):
    """Where something stands in a file, counted as an editor counts."""

    line: int
    """1-based."""
    column: int
    """1-based, in characters."""


class Text(Struct, frozen=True):
    """One cell as it stands in the file."""

    text: str
    """Without quotes and without blanks around it."""
    line: int
    column: int
    """Of its first character, 1-based."""

    @property
    def place(self) -> Place:
        """Line and column."""
        return Place(self.line, self.column)


_Where = Text | Place | None


class Reading(Struct, frozen=True):
    """One number as it was read; cells of a column that say the same may be one object."""

    value: float | None = None
    """[SI unit of the role]; None where nothing was measured."""
    step: float | None = None
    """One step of the last digit typed anywhere in the column [SI unit of the role]; None where the number is exact
    (a fraction, a plain 0) or its digits are unknown."""
    u: Uncertainty | None = None
    """What the log says of it: its own ±, else its ``u_…`` column, else the header's ±, else the ``u_…`` constant."""
    text: str = ""
    """As typed."""


class Column(Struct, frozen=True, dict=True):
    """One role's readings in SI, one for each of the n runs."""

    role: str
    """Canonical name: ``mass``, ``spin``, ``time``, … (repeats ``time_1``, ``time_2`` have become runs)."""
    header: str
    """As written, or ``# spin`` or ``--set spin`` where one value holds for the whole log."""
    unit: str
    """Unit as understood, in a spelling that this tool reads back; "" for numbers."""
    readings: tuple[Reading, ...]
    spots: tuple[int, ...]
    """Identity: runs with equal numbers share one reading (filled down, constant, or repeats of one setting). It is
    that of its cell in the file, −1 for the value that holds for the whole log."""
    given: Place | None = None
    """Where that value stands; None for what an option gave."""
    find: Callable[[int], Place] | None = None
    """Where the cell of an identity stands: hardly any is ever asked for."""

    @cached_property
    def values(self) -> tuple[float | None, ...]:
        """Values alone [SI unit of the role]."""
        return tuple([reading.value for reading in self.readings])

    @cached_property
    def steps(self) -> tuple[float, ...]:
        """Steps of the last digits [SI unit of the role]; 0 where a number is exact or its digits are unknown."""
        return tuple([reading.step or 0.0 for reading in self.readings])

    @cached_property
    def stated(self) -> tuple[tuple[int, Uncertainty], ...]:
        """Run and uncertainty of each reading of which the log says one."""
        return tuple([(i, reading.u) for i, reading in enumerate(self.readings) if reading.u is not None])

    def select(self, rows: Sequence[int]) -> Column:
        """Give some of the readings."""
        return replace(
            self, readings=tuple([self.readings[i] for i in rows]), spots=tuple([self.spots[i] for i in rows])
        )

    def place(self, run: int) -> Place | None:
        """Where a reading stands; None for what an option gave, or a simulation."""
        if self.spots[run] < 0:
            return self.given
        return self.find(self.spots[run]) if self.find is not None and self.readings[run].text else None


class Readings(Struct, frozen=True, dict=True):
    """What a log says: one row for each timed run.

    Attributes
    ----------
    name : str
        What the log is called; ``<stdin>`` for standard input, ``<table>`` for a DataFrame.
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
        ``g``, ``latitude``, ``ball_diameter``, ``ball_mass``, ``rod_length`` [SI]; only those given.
    uncertainties : mapping of str to Uncertainty
        Every ``u_…`` given for the whole log.
    stated_at : mapping of str to Place or None
        Where each ``u_…`` line stands; None for an option.
    balance_tilt : tuple of float or None
        Rod released unspun: angle [rad], time [s].
    balance_drift : tuple of float or None
        Rod released spun, without a weight: angle [rad], time [s], spin [rad/s].
    motion : str or None
        "released" from rest, or "steady"; None where the log does not say.
    balanced : bool or None
        Whether the ball is balanced; None where the log does not say.
    position_from : str or None
        "surface" of the ball or "tip" of the rod, where the positions as typed count from there; None or "centre"
        where they count from the centre of the ball. Those in `columns` always count from the centre.
    origin_u : float
        Standard uncertainty of the distance between that place and the centre [m].
    metadata : mapping of str to str
        All other ``# key: value`` lines, as written.
    reported : mapping of str to Reported
        What the student reports in ``# reported_KEY: value ± u unit`` lines, for whoever grades it.
    unmoved : Readings or None
        The runs without a weight in which the rod did not move (0 turns), which are in no other field.
    unread : tuple of (str, tuple of str)
        Header and cells, as written, of each column that was not understood.
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
    stated_at: Mapping[str, Place | None] = field(default_factory=dict)
    balance_tilt: tuple[float, float] | None = None
    balance_drift: tuple[float, float, float] | None = None
    motion: str | None = None
    balanced: bool | None = None
    position_from: str | None = None
    origin_u: float = 0.0
    metadata: Mapping[str, str] = field(default_factory=dict)
    reported: Mapping[str, Reported] = field(default_factory=dict)
    unmoved: Readings | None = None
    unread: tuple[tuple[str, tuple[str, ...]], ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()
    source_text: str = ""

    def __repr__(self) -> str:
        return f"<Readings of {self.name[:200]}: {len(self.runs)} runs, {len(self.diagnostics)} things to look at>"

    def select(self, runs: Sequence[int]) -> Readings:
        """Give some of the runs."""
        return replace(
            self,
            runs=tuple(self.runs[i] for i in runs),
            lines=tuple(self.lines[i] for i in runs),
            notes=tuple(self.notes[i] for i in runs),
            columns={role: column.select(runs) for role, column in self.columns.items()},
            others=tuple(column.select(runs) for column in self.others),
            unread=tuple((header, tuple(texts[i] for i in runs)) for header, texts in self.unread),
        )

    @property
    def ok(self) -> bool:
        """Whether no error was found, so that every run has what the analysis needs."""
        return all(diagnostic.severity != "error" for diagnostic in self.diagnostics)

    def diagnose(
        self, code: str, message: str, hint: str = "", place: Place | None = None, width: int = 1, doubt: str = ""
    ) -> Diagnostic:
        """Make a diagnostic of a place of this log, with the excerpt of its line."""
        return replace(self._faults.make(code, message, hint, place, width), doubt=doubt)

    @cached_property
    def _faults(self) -> Faults:
        return Faults(self.name, self.source_text)


def split_lines(text: str) -> list[str]:
    """Split at the three line ends an editor knows, and at nothing else (`str.splitlines` knows ten)."""
    if "\r" in text:
        text = text.replace("\r\n", "\n").replace("\r", "\n")
    return text.split("\n")


class Faults:
    """The faults found so far in one log, in the order in which they were found."""

    def __init__(self, name: str, text: str = "") -> None:
        self.name = name
        self.lines = split_lines(text) if text else []
        self.found: list[Diagnostic] = []
        self._count: Counter[str] = Counter()

    def make(self, code: str, message: str, hint: str = "", place: Place | None = None, width: int = 1) -> Diagnostic:
        """Make a diagnostic with the severity of its code and the excerpt of its line."""
        if place is None:
            return Diagnostic.of(code, message, hint, self.name)
        excerpt = self.lines[place.line - 1] if 0 < place.line <= len(self.lines) else ""
        return Diagnostic.of(code, message, hint, self.name, *place, excerpt, width)

    def add(self, code: str, message: str, hint: str = "", place: _Where = None, width: int | None = None) -> None:
        """Note one fault down, all of a cell or at a place; of one code, the first `MOST_OF_ONE_CODE` only."""
        self._count[code] += 1
        if self._count[code] > MOST_OF_ONE_CODE:
            return
        if isinstance(place, Text):
            width = len(place.text) if width is None else width
            place = place.place
        self.found.append(self.make(code, message, hint, place, max(1, width or 1)))

    def refuse(
        self, code: str, message: str, hint: str = "", place: _Where = None, width: int | None = None
    ) -> InputError:
        """Give the error to raise for an input that is no log at all, with what was found before it."""
        self.add(code, message, hint, place, width)
        return InputError(self.found)

    def all_told(self) -> tuple[Diagnostic, ...]:
        """Give what was found, and how much more of it there is."""
        more = [
            self.make(code, f"{count - MOST_OF_ONE_CODE} more of this kind are not shown")
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


def header_of(role: str, unit: str) -> str:
    """Write the header of a column: ``mass [g]``, ``turns``."""
    return f"{role} [{unit}]" if unit else role


def span(lines: list[int]) -> str:
    """Write line numbers shortly: ``lines 3-5, 7``."""
    parts = []
    for _, group in groupby(enumerate(lines), lambda item: item[1] - item[0]):
        block = [line for _, line in group]
        parts.append(f"{block[0]}-{block[-1]}" if len(block) > 1 else str(block[0]))
    return f"{'line' if len(lines) == 1 else 'lines'} {listing(parts)}"
