"""The nouns of the reader.

They are a place in a file, a column of readings, the whole log, its faults, reports and
settings.

Reports are the results of a student, such as ``# reported_inertia: 4.4(1) g m^2``.
Settings are values for the whole log: ``# key: value`` lines, ``--set`` and
``--config``.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from itertools import groupby
from typing import Any, Literal, NamedTuple, TypeVar

from msgspec import Struct
from msgspec.structs import replace

from gyrodata.base import diagnostics
from gyrodata.base.errors import Diagnostic, InputError
from gyrodata.quantities.units import Uncertainty
from gyrodata.readings import roles

_T = TypeVar("_T")
MOST_OF_ONE_CODE = 100
"""Diagnostics of one code that are shown; a column of text for numbers has as many
faults as rows."""


class Place(NamedTuple):
    """A place in a file, counted as in an editor."""

    line: int
    """1-based."""
    column: int
    """1-based, in characters."""


class Text(Struct, frozen=True):
    """One cell of a file."""

    text: str
    """Without quotes and without blanks around it."""
    place: Place
    """Place of its first character."""


class Reading(Struct, frozen=True):
    """One number as it was read; equal cells of a column may be one object."""

    value: float | None = None
    """[SI unit of the role]; None if nothing was measured."""
    step: float | None = None
    """One step of the last digit typed anywhere in the column [SI unit of the role];
    None if the number is exact (a fraction, a plain 0) or its digits are unknown."""
    u: Uncertainty | None = None
    """Stated uncertainty: its own ±, else its ``u_…`` column, else the header's ±, else
    the ``u_…`` of the log."""
    text: str = ""
    """As typed."""


class Column(Struct, frozen=True, dict=True):
    """The readings of one role in SI, one for each of the n runs."""

    role: str
    """Canonical name: ``mass``, ``spin``, ``time``, … (the repeats ``time_1``,
    ``time_2`` are runs here)."""
    header: str
    """As written, or ``# spin`` or ``--set spin`` if one value is valid for the whole
    log."""
    unit: str
    """Unit, in a spelling that this tool reads; "" for numbers."""
    readings: tuple[Reading, ...]
    spots: tuple[int, ...]
    """Number of each reading's cell in the file; −1 for the value of the whole log.
    Runs with equal numbers share one reading (filled down, constant, or repeats of one
    setting)."""
    given: Place | None = None
    """Place of the value of the whole log; None for an option."""
    find: Callable[[int], Place] | None = None
    """Function that returns the place of a numbered cell: hardly any place is ever
    needed."""

    @cached_property
    def values(self) -> tuple[float | None, ...]:
        """Values alone [SI unit of the role]."""
        return tuple([reading.value for reading in self.readings])

    @cached_property
    def steps(self) -> tuple[float, ...]:
        """Steps of the last digits [SI unit of the role].

        0 if a number is exact or its digits are unknown.
        """
        return tuple([reading.step or 0.0 for reading in self.readings])

    @cached_property
    def stated(self) -> tuple[tuple[int, Uncertainty], ...]:
        """Run and uncertainty of each reading with a stated uncertainty."""
        pairs = enumerate(reading.u for reading in self.readings)
        return tuple([(i, u) for i, u in pairs if u is not None])

    def select(self, rows: Sequence[int]) -> Column:
        """Return a column with some of the readings."""
        readings = _at(self.readings, rows)
        return replace(self, readings=readings, spots=_at(self.spots, rows))

    def place(self, run: int) -> Place | None:
        """Return the place of a reading; None for an option or a simulation."""
        if self.spots[run] < 0:
            return self.given
        if self.find is None or not self.readings[run].text:
            return None
        return self.find(self.spots[run])

    def cell(self, run: int) -> Text | None:
        """Return the cell of a reading; None for an option or a simulation."""
        place = self.place(run)
        return Text(self.readings[run].text, place) if place else None


Fall = tuple[float, float, float]
"""Spin at the start and at the end [rad/s], and the time between both [s]."""


class Readings(Struct, frozen=True, dict=True):
    """The content of a log: one row for each timed run.

    Attributes
    ----------
    name : str
        Name of the log; ``<stdin>`` for standard input, ``<table>`` for a DataFrame.
    sha256 : str
        Hash of the bytes read.
    runs : tuple of str
        Labels, unique: ``3``, or ``3.1`` and ``3.2`` for the repeats ``time_1`` and
        ``time_2`` of one row.
    lines : tuple of int
        Line in the file of each run.
    untimed : tuple of int
        Line of each row that is not a run because it has no time.
    notes : tuple of str
        Free text of each run.
    blocks : tuple of str
        The day or the group of each run; empty if all runs are of one.
    files : tuple of (int, Readings)
        The logs of which this one consists, and the line before the first one of each;
        empty if it is one log.
    screws : tuple of str
        The screw at which a part of a turn began in each run; "" if the log does not
        say.
    columns : mapping of str to Column
        The column used for each role.
    others : tuple of Column
        Further columns of a role, and derived ones (``inertia``); they are only
        compared.
    constants : mapping of str to float
        ``g``, ``latitude``, ``ball_diameter``, ``ball_mass``, ``rod_length`` [SI]; only
        those given.
    uncertainties : mapping of str to Uncertainty
        Every ``u_…`` given for the whole log.
    stated_at : mapping of str to Place or None
        Place of each ``u_…`` line; None for an option.
    balance_tilt : tuple of float or None
        Rod released without spin: angle [rad], time [s].
    balance_drift : tuple of float or None
        Rod released with spin, without a weight: angle [rad], time [s], spin [rad/s].
    spin_down : tuple of tuple
        Each fall of the spin that was measured: spin at the start and at the end
        [rad/s], and the time [s].
    falling_mass : tuple of float
        A mass on a thread that turns the disk: mass [kg], radius [m], height [m], time
        [s], mass that balances the friction [kg]; empty if the log has none.
    tachometer : str or None
        "follows" the rod, or "still"; None if the log does not say.
    motion : str or None
        "released" from rest, or "steady"; None if the log does not say.
    balanced : bool or None
        Whether the ball is balanced; None if the log does not say.
    balance : str or None
        Whether somebody "touched" the balance between two weights, or it was
        "untouched"; None if the log does not say.
    position_set : str or None
        "each weight" or "each run" if the weight was put at its position again for it;
        else None or "once".
    position_from : str or None
        "surface" of the ball or "tip" of the rod, if the positions as typed count from
        there; else None or "centre". The positions in `columns` always count from the
        centre.
    origin_u : float
        Standard uncertainty of the distance between that place and the centre [m].
    metadata : mapping of str to str
        All other ``# key: value`` lines, as written.
    reported : mapping of str to Reported
        The results that the student reports in lines such as ``# reported_inertia``,
        for grading.
    unmoved : Readings or None
        The runs without a weight in which the rod did not move (0 turns); no other
        field contains them.
    unread : tuple of (str, tuple of str)
        Header and cells, as written, of each column that was not understood.
    diagnostics : tuple of Diagnostic
        All faults found; if one is an error, `columns` may lack what the analysis
        needs.
    source_text : str
        The decoded text, for excerpts.
    sheets : tuple of (int, str)
        Line above the first row in that text, and name, of each sheet of a workbook.
    """

    name: str
    sha256: str
    runs: tuple[str, ...] = ()
    lines: tuple[int, ...] = ()
    untimed: tuple[int, ...] = ()
    notes: tuple[str, ...] = ()
    screws: tuple[str, ...] = ()
    blocks: tuple[str, ...] = ()
    files: tuple[tuple[int, Readings], ...] = ()
    columns: Mapping[str, Column] = {}
    others: tuple[Column, ...] = ()
    constants: Mapping[str, float] = {}
    uncertainties: Mapping[str, Uncertainty] = {}
    stated_at: Mapping[str, Place | None] = {}
    balance_tilt: tuple[float, float] | None = None
    balance_drift: tuple[float, float, float] | None = None
    spin_down: tuple[Fall, ...] = ()
    falling_mass: tuple[float, ...] = ()
    tachometer: str | None = None
    motion: str | None = None
    balanced: bool | None = None
    balance: str | None = None
    position_set: str | None = None
    position_from: str | None = None
    origin_u: float = 0.0
    metadata: Mapping[str, str] = {}
    reported: Mapping[str, Reported] = {}
    unmoved: Readings | None = None
    unread: tuple[tuple[str, tuple[str, ...]], ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()
    source_text: str = ""
    sheets: tuple[tuple[int, str], ...] = ()

    def __repr__(self) -> str:
        return (
            f"<Readings of {self.name[:200]}: {len(self.runs)} runs, "
            f"{len(self.diagnostics)} things to look at>"
        )

    def select(self, runs: Sequence[int]) -> Readings:
        """Return a log with some of the runs."""
        columns = {role: column.select(runs) for role, column in self.columns.items()}
        others = tuple(column.select(runs) for column in self.others)
        return replace(
            self,
            runs=_at(self.runs, runs),
            lines=_at(self.lines, runs),
            notes=_at(self.notes, runs),
            screws=_at(self.screws, runs),
            blocks=_at(self.blocks, runs) if self.blocks else (),
            columns=columns,
            others=others,
            unread=tuple((header, _at(texts, runs)) for header, texts in self.unread),
        )

    def file_of(self, line: int) -> int:
        """Return the number of the log to which a line belongs, of several logs."""
        starts = [start for start, _ in self.files]
        return max(bisect_left(starts, line) - 1, 0)

    @property
    def ok(self) -> bool:
        """Whether no error was found, so that every run has what the analysis needs."""
        return all(diagnostic.severity != "error" for diagnostic in self.diagnostics)

    def place(self, run: int) -> Place | None:
        """Return the place of a run's time, period or rate."""
        timings = [role for role in roles.TIMINGS if role in self.columns]
        return self.columns[timings[0]].place(run)

    def say(
        self, name: str, place: Text | Place | None = None, /, **values: Any
    ) -> Diagnostic:
        """Fill in a message of a file `messages.toml` about a place of this log."""
        return self._faults.message(name, place, **values)

    @cached_property
    def _faults(self) -> Faults:
        return Faults(self.name, self.source_text, self.sheets)


def _at(values: tuple[_T, ...], runs: Sequence[int]) -> tuple[_T, ...]:
    return tuple([values[run] for run in runs])


def split_lines(text: str) -> list[str]:
    """Split a text at the three line ends of editors (`str.splitlines` knows ten)."""
    return text.replace("\r\n", "\n").replace("\r", "\n").split("\n")


class Faults:
    """The faults found so far in one log, in the order in which they were found."""

    def __init__(
        self, name: str, text: str = "", sheets: tuple[tuple[int, str], ...] = ()
    ) -> None:
        self.name = name
        self.sheets = sheets
        self.lines = split_lines(text) if text else []
        self.diagnostics: list[Diagnostic] = []
        self._count: Counter[str] = Counter()

    def message(
        self, name: str, place: Text | Place | None = None, /, **values: Any
    ) -> Diagnostic:
        """Fill in a message of a file `messages.toml`.

        The mark below the line is as wide as a cell, or as the value `text`; a value
        `code` replaces the usual code. A list is one of line numbers, and {cell} is the
        text of the cell.
        """
        about = diagnostics.message(name)
        code = values.get("code") or about.code
        text = str(values.get("text", ""))
        where = place.place if isinstance(place, Text) else place
        if isinstance(place, Text):
            text = place.text
        for key, value in values.items():
            if isinstance(value, list):
                values[key] = self.span(value)
        words = about.text.format(cell=text, **values)
        hint = about.hint.format(cell=text, **values)
        if where is None:
            return Diagnostic(
                code, about.severity, words, hint, self.name, doubt=about.doubt
            )
        excerpt = self._excerpt(where.line)
        cell = self.cell_of(where)
        about_place = (*where, excerpt, max(1, len(text)), about.doubt, cell)
        return Diagnostic(code, about.severity, words, hint, self.name, *about_place)

    def add(
        self, name: str, place: Text | Place | None = None, /, **values: Any
    ) -> None:
        """Add a message with its values.

        Of one code, only the first `MOST_OF_ONE_CODE` are made and kept.
        """
        code = values.get("code") or diagnostics.message(name).code
        self._count[code] += 1
        if self._count[code] <= MOST_OF_ONE_CODE:
            self.diagnostics.append(self.message(name, place, **values))

    def refuse(
        self, name: str, place: Text | Place | None = None, /, **values: Any
    ) -> InputError:
        """Return the error to raise for an input that is not a log.

        The error also contains everything that was found before.
        """
        self.add(name, place, **values)
        return InputError(self.diagnostics)

    def take_back(self, name: str, line: int) -> None:
        """Remove the messages of one kind about a line."""
        code = diagnostics.message(name).code
        self.diagnostics = [
            fault
            for fault in self.diagnostics
            if (fault.code, fault.line) != (code, line)
        ]

    def _excerpt(self, line: int) -> str:
        if 0 < line <= len(self.lines):
            return self.lines[line - 1]
        return ""

    def cell_of(self, place: Place) -> str:
        """Return the cell of a place in a workbook: "Sheet2!B5"; else ""."""
        cell, row = self._row(place.line)
        if not (cell and row):
            return cell
        before = self._excerpt(place.line)[: place.column - 1]
        high, low = divmod(before.count("\t"), 26)
        letter = chr(64 + high) if high else ""
        return f"{cell}!{letter}{chr(65 + low)}{row}"

    def _row(self, line: int) -> tuple[str, int]:
        """Return the sheet, "" without a workbook, and the row of a line in it."""
        sheets = [sheet for sheet in self.sheets if sheet[0] <= line]
        if sheets:
            start, title = sheets[-1]
            return title, line - start
        return "", line

    def span(self, lines: list[int]) -> str:
        """Return line numbers in short form: ``lines 3-5, 7``.

        If there are several sheets, ``rows Sheet2!3-5``.
        """
        if len(lines) == 1:
            sheet, row = self._row(lines[0])
            if row == 0:
                return f"the sheet {sheet}"  # its name is a caption
        parts = []
        for _, group in groupby(enumerate(lines), lambda item: item[1] - item[0]):
            block = [self._row(line) for _, line in group]
            title, first = block[0]
            sheet = f"{title}!" if len(self.sheets) > 1 else ""
            _, last = block[-1]
            numbers = f"{first}" if last == first else f"{first}-{last}"
            parts.append(sheet + numbers)
        word = "row" if len(self.sheets) > 1 else "line"
        if len(lines) > 1:
            word += "s"
        return f"{word} {listing(parts)}"

    def all_findings(self) -> tuple[Diagnostic, ...]:
        """Return what was found; equal messages about cells are one message."""
        messages = {fault.message for fault in self.diagnostics}
        if len(messages) == self._count.total():
            return tuple(self.diagnostics)
        return (*self._without_repeats(), *self._not_shown())

    def _without_repeats(self) -> Iterator[Diagnostic]:
        """Yield what was found, with the lines of all cells of the same message."""
        equal: dict[str | int, list[Diagnostic]] = {}
        for number, fault in enumerate(self.diagnostics):
            is_of_cell = fault.code == diagnostics.CELL_IS_NO_NUMBER
            key = fault.message if is_of_cell else number
            equal.setdefault(key, []).append(fault)
        for first, *others in equal.values():
            lines = [other.line or 0 for other in others]
            more = f", also in {self.span(lines)}" * bool(lines)
            yield replace(first, message=first.message + more)

    def _not_shown(self) -> Iterator[Diagnostic]:
        """Yield how many more messages there are of each code."""
        severities = {fault.code: fault.severity for fault in self.diagnostics}
        for code, count in self._count.items():
            if count > MOST_OF_ONE_CODE:
                text = f"{count - MOST_OF_ONE_CODE} more of this kind are not shown"
                yield Diagnostic(code, severities[code], text, file=self.name)

    def has_error(self) -> bool:
        """Return whether a fault found so far stops the analysis."""
        return "error" in [diagnostic.severity for diagnostic in self.diagnostics]


def _shortened(text: str) -> str:
    if len(text) <= 40:
        return text
    return text[:39] + "…"


def listing(items: list[str] | tuple[str, ...], most: int = 12) -> str:
    """Join texts for a message; long lists and long texts are shortened."""
    text = ", ".join(map(_shortened, items[:most]))
    if len(items) > most:
        text += f" and {len(items) - most} more"
    return text


def header_of(role: str, unit: str | None = None) -> str:
    """Return the header of a column: ``mass [g]``, ``turns``."""
    return f"{role} [{unit}]" if unit else role


UNKNOWN = frozenset(
    {"n/a", "N/A", "n.a.", "#N/A", "NA", "?", "″", "〃", '"', "idem", "ditto"}
)
"""What students write for a value that they do not know, or for the one above."""
BLANKS = frozenset({"", "-", "–", "—", "−", "--", "~", "‐", "‑"}) | UNKNOWN
"""What students write if nothing was measured."""


# Results that a student reports, for grading

Fault = Literal["unreadable", "no unit", "wrong unit", "given twice"]


class Reported(Struct, frozen=True):
    """One value that a student reports, as far as it can be read.

    Attributes
    ----------
    key : str
        ``inertia``, ``imbalance``, ``timing_bias`` or ``exponent``.
    text : str
        As written.
    value : float or None
        [SI unit of its kind]; None if it cannot be read. If the unit is missing or
        wrong, the number is taken as SI.
    u : float or None
        Standard uncertainty [SI unit of its kind], after a division by a written k;
        None if none is written.
    digits : int or None
        Significant digits of the value; zeros at its end count only behind the decimal
        point.
    u_digits : int or None
        Significant digits of the uncertainty.
    step : float or None
        One step of the value's last digit [SI unit of its kind].
    u_step : float or None
        One step of the uncertainty's last digit [SI unit of its kind]; None if it is
        written in %.
    fault : {"unreadable", "no unit", "wrong unit", "given twice"} or None
        What is wrong, in a word.
    problem : str or None
        What is wrong, in a sentence; None exactly if `fault` is None.
    line : int or None
        Its line in its file, 1-based.
    """

    key: str
    text: str
    value: float | None = None
    u: float | None = None
    digits: int | None = None
    u_digits: int | None = None
    step: float | None = None
    u_step: float | None = None
    fault: Fault | None = None
    problem: str | None = None
    line: int | None = None
