"""The nouns of the reader: a place in a file, one role's column of readings, the whole log, and its faults."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import cached_property, lru_cache
from itertools import groupby
from typing import Literal, NamedTuple

from msgspec import Struct, field
from msgspec.structs import replace

from gyrodata import diagnostics, quantities, vocabulary
from gyrodata.errors import Diagnostic, InputError
from gyrodata.quantities import CellError as CellError
from gyrodata.quantities import read_cell as read_cell
from gyrodata.quantities import to_float
from gyrodata.readings.roles import BY_NAME, kind_of_role, name_roles, turns_in, words_of_turns
from gyrodata.units import KINDS, LIMITS, SI, Uncertainty, kinds_of

MOST_OF_ONE_CODE = 100
"""Diagnostics of one code that are shown; a column of text for numbers has as many faults as rows."""


class Place(NamedTuple):
    """A place in a file, counted as in an editor."""

    line: int
    """1-based."""
    column: int
    """1-based, in characters."""


class Text(Struct, frozen=True):
    """One cell as it is in the file."""

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
    """As written, or ``# spin`` or ``--set spin`` if one value is valid for the whole log."""
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
        """Return the place of a reading; None for a value from an option or a simulation."""
        if self.spots[run] < 0:
            return self.given
        return self.find(self.spots[run]) if self.find is not None and self.readings[run].text else None


class Readings(Struct, frozen=True, dict=True):
    """The content of a log: one row for each timed run.

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
    spin_down : tuple of tuple
        Each fall of the spin that was measured: spin at the start and at the end [rad/s], and the time [s].
    falling_mass : tuple of float
        A mass on a thread that turns the disk: mass [kg], radius [m], height [m], time [s], mass that balances the
        friction [kg]; empty if the log has none.
    tachometer : str or None
        "follows" the rod, or "still"; None if the log does not say.
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
    spin_down: tuple[tuple[float, float, float], ...] = ()
    falling_mass: tuple[float, ...] = ()
    tachometer: str | None = None
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


BLANKS = frozenset({"", "-", "–", "—", "−", "--", "~", "‐", "‑", "n/a", "N/A", "n.a.", "#N/A", "NA"})
"""What is written if nothing was measured."""
SPOKEN = ("mass", "turns", "spin_turns")
"""Roles whose numbers are also said in words."""
_NO_WEIGHT = frozenset(vocabulary.words("no_weight").split())
_TURN_BEHIND = rf"(?i)(.*?)\s*(?:of\s+)?(?:an?\s+)?(?:{vocabulary.words('turn', '|')})\w*\.?"


@lru_cache(maxsize=4096)
def said_otherwise(text: str, role: str) -> str:
    """Give the number that a cell says in another way: "none" of a mass, "one third" or "120°" of turns."""
    if role == "mass":
        return "0 g" if re.sub(r"[\s.\-]+", "", text).lower() in _NO_WEIGHT else ""
    if fraction := fraction_of_date(text):
        return fraction
    match = re.fullmatch(_TURN_BEHIND, text)
    bare = match[1] if match else text
    if words := words_of_turns(bare, whole=True):
        return words
    if bare != text and (bare == "" or quantities.take_apart(bare) is not None):
        return bare or "1"
    written = quantities.take_apart(text)
    angle = written is not None and written.spread is None and kinds_of(written.unit or "") == {"angle"}
    return turns_in(text) if angle else ""


def fraction_of_date(text: str) -> str:
    """Undo what a spreadsheet makes of 1/3 and 2/3: "3-Jan", "01. Mrz", "2026-01-03 00:00:00"; "" if it is none."""
    pair = quantities.date_pair(text)
    if pair is None or not (min(pair) == 1 or sorted(pair) == [2, 3]) or max(pair) > 12:
        return ""
    return f"{min(pair)}/{max(pair)}"


def rounded_turns(text: str) -> tuple[str, float]:
    """Find the part of a turn that 0.33 or 0.7 was rounded from, and half of what the rounding leaves open; "", 0 else.

    The screws of the ball are a third of a turn apart; a twelfth is what a run without a weight takes.
    """
    # Whole turns, however many, are meant as written.
    if not quantities.PLAIN.fullmatch(text) or quantities.last_place(text) >= 0:
        return "", 0.0
    value, step = to_float(text), float(f"1e{quantities.last_place(text)}")
    twelfths = round(value * 12)
    # Quarters have few digits: they are meant as written. 2/3 cut off at 0.66 is wrong by nearly a whole step.
    if twelfths % 3 == 0 or abs(value - twelfths / 12) >= step:
        return "", 0.0
    return str(Fraction(twelfths, 12)), step / math.sqrt(3)


@lru_cache(maxsize=16384)
def check_value(role: str, value: float) -> tuple[str, str]:
    """Say what is wrong with a number that cannot be, and what to type; two empty texts if nothing is."""
    known, kind = BY_NAME.get(role), kind_of_role(role)
    steep = abs(value) >= math.pi / 2
    broken = {"above zero": value <= 0, "not zero": value == 0, "not below zero": value < 0, "below 90 degrees": steep}
    if known and broken.get(known.bound):
        return f"must be {known.bound}", known.bound_hint
    low, high = LIMITS.get(kind, (0.0, math.inf))
    if value == 0 or low <= abs(value) <= high:
        return "", ""
    fault = f"is too {'large' if abs(value) > high else 'small'} for {KINDS[kind].words} in a lab"
    return fault, f"is its unit the one written? Read are {low:g} to {high:g} {SI[kind]}".rstrip()


PREFIX = "reported_"
REPORTED_KINDS = {"inertia": "inertia", "imbalance": "torque", "timing_bias": "time", "exponent": "number"}
"""Kind of quantity of what is read of a lab's report."""

Fault = Literal["unreadable", "no unit", "wrong unit", "given twice"]
_FAULTS: dict[str, Fault] = {diagnostics.UNIT_MISSING: "no unit", diagnostics.UNIT_UNKNOWN: "wrong unit"}
_HUGE = 1e30
"""A number above this, or below one over it, is not a quantity of a lab [SI]."""


class Reported(Struct, frozen=True):
    """One value that a student reports, as far as it can be read.

    Attributes
    ----------
    key : str
        What it is: ``inertia``, ``imbalance``, …
    text : str
        As written.
    value : float or None
        [SI unit of its kind]; if its unit is missing, or is one of another kind, the number taken as SI: the unit is
        judged by itself. None if it cannot be read.
    u : float or None
        Its standard uncertainty [SI unit of its kind], that is what is stated divided by a k written behind it; None
        if none is stated.
    digits : int or None
        Significant digits of the value; zeros at its end count behind the point, where they say something.
    u_digits : int or None
        Those of the uncertainty.
    step : float or None
        One step of the value's last digit [SI unit of its kind].
    u_step : float or None
        One step of the uncertainty's last digit [SI unit of its kind]; None if it is stated in %.
    fault : {"unreadable", "no unit", "wrong unit", "given twice"} or None
        What is wrong, in a word.
    problem : str or None
        What is wrong, in a sentence; None exactly if `fault` is.
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


def canonical_key(key: str) -> str:
    """Name what is reported: ``reported_I_zz`` and ``reported_moment_of_inertia`` are ``inertia``."""
    bare = key[len(PREFIX) :] if key.lower().startswith(PREFIX) else key
    return "inertia" if name_roles(bare)[0] == ("inertia",) else bare.lower()


def read_reported(key: str, text: str, line: int | None = None, ask: bool = True) -> Reported:
    """Read one reported value: ``4.4e-3 ± 0.1e-3 kg m^2``, ``(4.4 ± 0.1) × 10⁻³ kg m²`` or ``4.4(1) g m^2``."""
    read = Reported(canonical_key(key), text.strip(), line=line)
    kind = REPORTED_KINDS[read.key]
    bare = re.sub(quantities.IN_FRONT, "", read.text)
    written = quantities.take_apart(bare)
    try:
        quantity = read_cell(bare, kind, None, ask)
    except CellError as error:
        fault = _FAULTS.get(error.code, "unreadable")
        read = replace(read, fault=fault, problem=f'"{read.text[:60]}" {error}')
        if written is None or fault == "unreadable":
            return read
        spread_unit = "%" if written.spread_unit == "%" else None
        quantity = quantities.in_si(replace(written, unit=SI[kind], spread_unit=spread_unit), kind)
    u = quantity.uncertainty and quantity.uncertainty.at(quantity.value)
    if any(not 1 / _HUGE <= abs(size) <= _HUGE for size in (quantity.value, u) if size):
        return replace(read, fault="unreadable", problem=f'"{read.text[:60]}" is far from anything in a lab')
    read = replace(read, value=quantity.value, u=u, step=quantity.step, u_step=quantity.u_step)
    if written is None or quantity.step is None:
        return read  # a fraction has no digits that could be counted
    return replace(read, digits=_digits(written.number), u_digits=written.spread and _digits(written.spread))


def _digits(number: str) -> int:
    """Count significant digits, those of ``0.0044`` as of ``4.4e-3``; zeros before the point may only fill up."""
    mantissa = re.split("[eE]", number)[0]
    digits = re.sub("[^0-9]", "", mantissa).lstrip("0")
    return len(digits if re.search("[.,]", mantissa) else digits.rstrip("0")) or 1


def find_in_row(texts: Sequence[str]) -> tuple[int, str] | None:
    """Find I_zz in a row of a table, "I_zz", "4.4e-3 ± 0.1e-3 kg m^2" or both in one cell: where, and the value."""
    for at, text in enumerate(texts):
        name, _, value = text.replace("=", ":").partition(":")
        value = (value or " ".join(texts[at + 1 :])).strip()
        named = text[:1].isalpha() and value and canonical_key(name.strip()) == "inertia"
        if named and read_reported("inertia", value).fault is None:
            return at, value
    return None
