"""The nouns of the reader.

They are a place in a file, a column of readings, the whole log, its faults, reports and
settings.

Reports are the results of a student, such as ``# reported_inertia: 4.4(1) g m^2``.
Settings are values for the whole log: ``# key: value`` lines, ``--set`` and
``--config``.
"""

from __future__ import annotations

import difflib
import math
import os
import re
from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import cached_property, lru_cache, partial, reduce
from itertools import groupby
from pathlib import Path
from typing import Any, Literal, NamedTuple

import msgspec
from msgspec import Struct, field
from msgspec.structs import replace

from gyrodata.base import diagnostics
from gyrodata.base.errors import Diagnostic, InputError
from gyrodata.quantities import notation, units, vocabulary
from gyrodata.quantities.units import Uncertainty, UnitError, kinds_of
from gyrodata.readings import roles

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
        return tuple(
            [
                (i, reading.u)
                for i, reading in enumerate(self.readings)
                if reading.u is not None
            ]
        )

    def select(self, rows: Sequence[int]) -> Column:
        """Return a column with some of the readings."""
        readings, spots = (
            tuple([self.readings[i] for i in rows]),
            tuple([self.spots[i] for i in rows]),
        )
        return replace(self, readings=readings, spots=spots)

    def place(self, run: int) -> Place | None:
        """Return the place of a reading; None for a value from an option or a simulation."""
        if self.spots[run] < 0:
            return self.given
        return (
            self.find(self.spots[run])
            if self.find is not None and self.readings[run].text
            else None
        )

    def cell(self, run: int) -> Text | None:
        """Return the cell of a reading; None for a value from an option or a simulation."""
        return (
            Text(self.readings[run].text, place) if (place := self.place(run)) else None
        )


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
    notes : tuple of str
        Free text of each run.
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
    notes: tuple[str, ...] = ()
    columns: Mapping[str, Column] = field(default_factory=dict)
    others: tuple[Column, ...] = ()
    constants: Mapping[str, float] = field(default_factory=dict)
    uncertainties: Mapping[str, Uncertainty] = field(default_factory=dict)
    stated_at: Mapping[str, Place | None] = field(default_factory=dict)
    balance_tilt: tuple[float, float] | None = None
    balance_drift: tuple[float, float, float] | None = None
    spin_down: tuple[Fall, ...] = ()
    falling_mass: tuple[float, ...] = ()
    tachometer: str | None = None
    motion: str | None = None
    balanced: bool | None = None
    balance: str | None = None
    position_from: str | None = None
    origin_u: float = 0.0
    metadata: Mapping[str, str] = field(default_factory=dict)
    reported: Mapping[str, Reported] = field(default_factory=dict)
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
        unread = tuple(
            (header, tuple(texts[i] for i in runs)) for header, texts in self.unread
        )
        labels, lines, notes = (
            tuple(texts[i] for i in runs)
            for texts in (self.runs, self.lines, self.notes)
        )
        return replace(
            self,
            runs=labels,
            lines=lines,
            notes=notes,
            columns=columns,
            others=others,
            unread=unread,
        )

    @property
    def ok(self) -> bool:
        """Whether no error was found, so that every run has what the analysis needs."""
        return all(diagnostic.severity != "error" for diagnostic in self.diagnostics)

    def place(self, run: int) -> Place | None:
        """Return the place of a run's time, period or rate."""
        return next(
            self.columns[role].place(run)
            for role in roles.TIMINGS
            if role in self.columns
        )

    def say(
        self, name: str, place: Text | Place | None = None, /, **values: Any
    ) -> Diagnostic:
        """Fill in a message of a file `messages.toml` about a place of this log."""
        return self._faults.message(name, place, **values)

    @cached_property
    def _faults(self) -> Faults:
        return Faults(self.name, self.source_text, self.sheets)


def split_lines(text: str) -> list[str]:
    """Split a text at the three line ends that editors know (`str.splitlines` knows ten)."""
    return text.replace("\r\n", "\n").replace("\r", "\n").split("\n")


class Faults:
    """The faults found so far in one log, in the order in which they were found."""

    def __init__(
        self, name: str, text: str = "", sheets: tuple[tuple[int, str], ...] = ()
    ) -> None:
        self.name, self.sheets = name, sheets
        self.lines = split_lines(text) if text else []
        self.found: list[Diagnostic] = []
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
        code, text = (
            values.get("code") or about.code,
            str(values.get("text", "")),
        )
        where, text = (
            (place.place, place.text) if isinstance(place, Text) else (place, text)
        )
        values = {
            key: self.span(value) if isinstance(value, list) else value
            for key, value in values.items()
        }
        words, hint = (
            words.format(cell=text, **values) for words in (about.text, about.hint)
        )
        if where is None:
            return Diagnostic(
                code, about.severity, words, hint, self.name, doubt=about.doubt
            )
        excerpt = (
            self.lines[where.line - 1] if 0 < where.line <= len(self.lines) else ""
        )
        sheet, row = self._row(where.line)
        high, low = divmod(excerpt[: where.column - 1].count("\t"), 26)
        cell = (
            f"{sheet}!{chr(64 + high) * (high > 0)}{chr(65 + low)}{row}"
            if sheet and row
            else sheet
        )
        return Diagnostic(
            code,
            about.severity,
            words,
            hint,
            self.name,
            *where,
            excerpt,
            max(1, len(text)),
            about.doubt,
            cell,
        )

    def add(
        self, name: str, place: Text | Place | None = None, /, **values: Any
    ) -> None:
        """Add a message with its values.

        Of one code, only the first `MOST_OF_ONE_CODE` are made and kept.
        """
        code = values.get("code") or diagnostics.message(name).code
        self._count[code] += 1
        if self._count[code] <= MOST_OF_ONE_CODE:
            self.found.append(self.message(name, place, **values))

    def take_back(self, name: str, lines: Collection[int]) -> None:
        """Remove the messages of one kind about some lines."""
        code = diagnostics.message(name).code
        self.found = [
            one for one in self.found if one.code != code or one.line not in lines
        ]

    def refuse(
        self, name: str, place: Text | Place | None = None, /, **values: Any
    ) -> InputError:
        """Return the error to raise for an input that is not a log.

        The error also contains everything that was found before.
        """
        self.add(name, place, **values)
        return InputError(self.found)

    def _row(self, line: int) -> tuple[str, int]:
        """Return the sheet and the row of a line; without a workbook, no sheet and the line."""
        sheets = [one for one in self.sheets if one[0] <= line]
        return (sheets[-1][1], line - sheets[-1][0]) if sheets else ("", line)

    def span(self, lines: list[int]) -> str:
        """Return line numbers in short form: ``lines 3-5, 7``.

        If there are several sheets, ``rows Sheet2!3-5``.
        """
        if len(lines) == 1 and self._row(lines[0])[1] == 0:
            return f"the sheet {self._row(lines[0])[0]}"  # its name is a caption
        parts = []
        for _, group in groupby(enumerate(lines), lambda item: item[1] - item[0]):
            block = [self._row(line) for _, line in group]
            sheet = f"{block[0][0]}!" if len(self.sheets) > 1 else ""
            parts.append(
                sheet + "-".join(dict.fromkeys((str(block[0][1]), str(block[-1][1]))))
            )
        word = "row" if len(self.sheets) > 1 else "line"
        return f"{word if len(lines) == 1 else word + 's'} {listing(parts)}"

    def all_told(self) -> tuple[Diagnostic, ...]:
        """Return what was found, and how many more there are of each code."""
        more = {
            code: count - MOST_OF_ONE_CODE
            for code, count in self._count.items()
            if count > MOST_OF_ONE_CODE
        }
        severities = {one.code: one.severity for one in self.found}
        told = [
            Diagnostic(
                code,
                severities[code],
                f"{n} more of this kind are not shown",
                file=self.name,
            )
            for code, n in more.items()
        ]
        return (*self.found, *told)

    def has_error(self) -> bool:
        """Return whether a fault found so far stops the analysis."""
        return "error" in [diagnostic.severity for diagnostic in self.found]


def listing(items: list[str] | tuple[str, ...], most: int = 12) -> str:
    """Join texts for a message; long lists and long texts are shortened."""
    shown = [item if len(item) <= 40 else item[:39] + "…" for item in items[:most]]
    more = f" and {len(items) - most} more" if len(items) > most else ""
    return ", ".join(shown) + more


def header_of(role: str, unit: str) -> str:
    """Return the header of a column: ``mass [g]``, ``turns``."""
    return f"{role} [{unit}]" if unit else role


UNKNOWN = frozenset({"n/a", "N/A", "n.a.", "#N/A", "NA", "?"})
"""What students write for a value that they do not know."""
BLANKS = frozenset({"", "-", "–", "—", "−", "--", "~", "‐", "‑"}) | UNKNOWN
"""What students write if nothing was measured."""


# What a student reports, for grading
# ------------------------------------------------------------------------------

REPORTABLE = {
    "inertia": "inertia",
    "imbalance": "torque",
    "timing_bias": "time",
    "exponent": "number",
}
"""Kind of quantity of each value that can be reported."""

_Report = Literal["unreadable", "no unit", "wrong unit", "given twice"]
_LATEX = (
    ("$", ""),
    (r"\times", "×"),
    (r"\cdot", "·"),
    (r"\pm", "±"),
    (r"\,", " "),
    ("^{", "^"),
    ("}", ""),
)
_FAULTS: dict[str, _Report] = {
    diagnostics.UNIT_MISSING: "no unit",
    diagnostics.UNIT_UNKNOWN: "wrong unit",
}


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
    fault: _Report | None = None
    problem: str | None = None
    line: int | None = None


def read_reported(
    key: str, text: str, line: int | None = None, ask: bool = True
) -> Reported:
    """Read one reported value.

    Examples are ``4.4e-3 ± 0.1e-3 kg m^2``, ``(4.4 ± 0.1) × 10⁻³ kg m²`` and ``4.4(1) g
    m^2``.
    """
    read = Reported(roles.reported_key(key), text.strip(), line=line)
    kind = REPORTABLE[read.key]
    bare = reduce(
        lambda so_far, pair: so_far.replace(*pair),
        _LATEX,
        re.sub(notation.IN_FRONT, "", read.text),
    )
    written = notation.take_apart(bare)
    try:
        quantity = notation.read_cell(bare, kind, None, ask)
    except UnitError as error:
        fault = _FAULTS.get(error.code, "unreadable")
        if "is not known" in str(error) and not (
            written and units.kinds_of((written.unit or "").partition(" ")[0])
        ):
            fault = "unreadable"  # an unknown unit may contain a power of ten
        read = replace(read, fault=fault, problem=f'"{read.text[:60]}" {error}')
        if written is None or fault == "unreadable":
            return read
        spread_unit = "%" if written.spread_unit == "%" else None
        quantity = notation.in_si(
            replace(written, unit=units.SI[kind], spread_unit=spread_unit), kind
        )
    u = quantity.uncertainty and quantity.uncertainty.at(quantity.value)
    if any(not 1e-30 <= abs(size) <= 1e30 for size in (quantity.value, u) if size):
        return replace(
            read,
            fault="unreadable",
            problem=f'"{read.text[:60]}" is far from anything in a lab',
        )
    read = replace(
        read, value=quantity.value, u=u, step=quantity.step, u_step=quantity.u_step
    )
    if written is None or quantity.step is None:
        return read  # a fraction has no digits that could be counted
    return replace(
        read,
        digits=_digits(written.number),
        u_digits=written.spread and _digits(written.spread),
    )


def _digits(number: str) -> int:
    """Count significant digits: ``0.0044`` has as many as ``4.4e-3``.

    Zeros before the point may only fill up.
    """
    digits = re.sub("[^0-9.,]", "", re.split("[eE]", number)[0]).lstrip("0.,")
    return (
        len(
            re.sub("[.,]", "", digits)
            if re.search("[.,]", number)
            else digits.rstrip("0")
        )
        or 1
    )


# Values for the whole log
# -----------------------------------------------------------------------------------------


class Given(Struct, frozen=True):
    """One value for the whole log."""

    key: str
    text: str
    label: str
    """How it was given: ``# spin``, ``--set spin``, ``--config spin``."""
    place: Place | None
    """None for an option."""
    cell: notation.Quantity | None = None
    """The value of a role or constant."""

    def reading(self, u: Uncertainty | None) -> Reading:
        """Return the value as the reading of a run.

        `u` is used if it has no uncertainty of its own.
        """
        assert self.cell is not None
        return Reading(
            self.cell.value, self.cell.step, self.cell.uncertainty or u, self.text
        )


class Settings(Struct):
    """All values for the whole log."""

    roles: dict[str, Given] = field(default_factory=dict)
    constants: dict[str, float] = field(default_factory=dict)
    uncertainties: dict[str, Uncertainty] = field(default_factory=dict)
    given_uncertainties: dict[str, Given] = field(default_factory=dict)
    fields: dict[str, Any] = field(default_factory=dict)
    """Other fields of `Readings`, such as ``motion`` and ``spin_down``."""
    steps: dict[str, float] = field(default_factory=dict)
    """One step of the last digit of each constant [SI unit]."""
    metadata: dict[str, str] = field(default_factory=dict)
    reported: dict[str, Reported] = field(default_factory=dict)
    unread: set[str] = field(default_factory=set)
    """Roles whose value could not be read; there is a fault for each."""
    origin: str = ""
    """Point from which positions count, if a note says so."""


def read_options(
    settings: Mapping[str, str],
    mapping: Mapping[str, str],
    config: str | os.PathLike[str] | None,
) -> list[Given]:
    """Check the names of all options before the log is read.

    Return the values of ``--set`` and ``--config``.
    """
    faults, table = Faults(""), {}
    if config is not None:
        try:
            with Path(config).open("rb") as file:
                table = msgspec.toml.decode(
                    file.read(1_000_000).decode("utf-8-sig"),
                    type=dict[str, str | int | float],
                )
        except (OSError, ValueError, RecursionError) as error:
            raise faults.refuse(
                "config",
                path=str(config),
                why=getattr(error, "strerror", None) or error,
            ) from None
    given = [
        Given(key, str(value), f"--config {key}", None) for key, value in table.items()
    ]
    given += [
        Given(key.strip(), text.strip(), f"--set {key}", None)
        for key, text in settings.items()
    ]
    keys = [key for key in roles.KEYS if key not in roles.TEXTS]
    mapped = [*roles.ROLES, *roles.UNCERTAINTIES]
    names = [("option_unknown", item.label, item.key, keys) for item in given]
    names += [
        ("mapped_role_unknown", f"--map {role}=…", role, mapped) for role in mapping
    ]
    for fault, what, name, known in names:
        if name not in known and not (
            known is mapped and re.fullmatch(r"time_[1-9][0-9]?", name)
        ):
            close = difflib.get_close_matches(name.lower(), known, n=3, cutoff=0.6)
            close = close or [
                role for role in roles.name_roles(name)[0] if role in known
            ]
            hint = (
                f"did you mean {' or '.join(close)}?"
                if close
                else f"known are: {listing(known, 99)}"
            )
            faults.add(fault, what=what, hint=hint)
    if faults.has_error():
        raise InputError(faults.found)
    return given


def read_settings(
    metadata: Sequence[tuple[str, Text]],
    comments: Sequence[Text],
    options: Sequence[Given],
    faults: Faults,
    ask: bool,
) -> Settings:
    """Read all ``# key: value`` lines and options.

    Lines replace the values of a file, and ``--set`` replaces both.

    With `ask`, a comma that may separate thousands is an error; without, it is a
    decimal comma as in the table.
    """
    settings = Settings()
    seen: dict[str, Text] = {}
    answers: list[tuple[str, Text]] = []
    for key, text in metadata:
        known = key.lower()
        if known == "ball_radius":
            known, text = "ball_diameter", replace(text, text=f"2 x {text.text}")
        if (
            known == "time"
            and ":" not in text.text
            and (turns := roles.turns_in(text.text))
        ):
            known, text = "turns", replace(text, text=turns)  # "# time = 3 turns"
        # A line with the name of a quantity may be blank, the hour of the day, or a
        # sentence.
        says_nothing = not text.text or (known == "time" and ":" in text.text)
        says_nothing |= (
            known in roles.ROLES
            and len(text.text.split()) > 3
            and not re.search(r"\d", text.text)
        )
        result, (name, _, value) = roles.reported_key(key), text.text.partition("=")
        if known.startswith(roles.REPORTED) and result in REPORTABLE:
            _enter_reported(settings, key, text, faults, ask)
        elif result == "inertia":
            answers.append((key, text))
        elif known not in roles.KEYS and roles.reported_key(name.strip()) == "inertia":
            answers.append(
                (name.strip(), replace(text, text=value.strip()))
            )  # "# Result: I_zz = …"
        elif known not in roles.KEYS or known in roles.TEXTS or says_nothing:
            settings.metadata[key] = text.text
            if (
                text.text
                and known not in roles.KEYS
                and len(key) <= 30
                and len(settings.metadata) < 200
            ):
                _warn_of_remark(key, text.text, text, faults)
        elif known in seen and seen[known].text != text.text and known != "spin_down":
            faults.add(
                "key_given_twice",
                text,
                key=known,
                first=seen[known].place.line,
                second=text.place.line,
            )
        else:
            seen[known] = text
            _enter(
                settings, Given(known, text.text, f"# {known}", text.place), ask, faults
            )
    for comment in comments:
        if match := re.fullmatch(
            r"(\w+)\s+([-+]?[0-9].*)", comment.text
        ):  # "# spin 400 rpm" without a colon
            _warn_of_remark(match[1], match[2], comment, faults)
    # "# I_zz = …" is an answer too, if no "# reported_inertia: …" is.
    if "inertia" not in settings.reported:
        for key, text in answers:
            # "I = 3" may be a current, and "I_zz: see the report" is not an answer.
            read = read_reported(key, text.text)
            if read.fault is None or (len(key) > 1 and read.value is not None):
                _enter_reported(settings, key, text, faults, ask)
            else:
                settings.metadata[key] = text.text
    for item in options:
        # The log itself knows its lab better than the file of the bench.
        if item.key not in seen or not item.label.startswith("--config"):
            _enter(settings, item, True, faults)
    return settings


def _enter_reported(
    settings: Settings, key: str, text: Text, faults: Faults, ask: bool
) -> None:
    """Keep a reported value.

    A fault in it is only a note for its writer, because it is graded elsewhere.
    """
    name = roles.reported_key(key)
    before = settings.reported.get(name)
    if text.text in BLANKS or (before is not None and before.text == text.text):
        return
    read = read_reported(key, text.text, text.place.line, ask)
    if before is not None:
        problem = (
            f"{name} is reported twice, in lines {before.line} and {text.place.line}, "
            f"with two values"
        )
        read = Reported(
            name, before.text, fault="given twice", problem=problem, line=before.line
        )
    settings.reported[name] = read
    if read.problem:
        faults.add("reported_value", text, name=name, problem=read.problem)


_KNOWN = (*roles.KEYS, *(f"{roles.REPORTED}{name}" for name in REPORTABLE))
# A class writes the same remarks a thousand times.
_nearest_key = lru_cache(maxsize=1024)(
    partial(difflib.get_close_matches, possibilities=_KNOWN, n=1, cutoff=0.8)
)


def _warn_of_remark(key: str, value: str, text: Text, faults: Faults) -> None:
    """Warn of a remark that is nearly a ``# key: value`` line.

    Examples are "# u_positon: 1 mm" and "# m1 = 47 g".
    """
    close = _nearest_key(key.lower()) if len(key) > 2 else []
    if not close and value[:1].isdigit():
        names = (key, re.sub(r"_?[0-9]{1,2}$", "", key))
        close = [
            one
            for name in names
            for one in roles.name_roles(name)[0]
            if roles.kind_of_role(one) != "text"
        ]
    if close and not roles.turns_in(f"{key} {value}"):  # "# timed 2 turns each run"
        # Of "14.8 cm from centre" the value is meant.
        match = (
            re.match(rf"{notation.NUMBER}\s*\S*", value)
            if close[0] in roles.ROLES
            else None
        )
        written = text.text if text.text != value else key
        faults.add(
            "remark",
            text,
            written=written,
            meant=f"{close[0]}: {match[0] if match else value}",
        )


YES_OR_NO: dict[str, bool | None] = {"": None}
YES_OR_NO |= {
    word: said == "yes"
    for said in ("yes", "no")
    for word in vocabulary.words(said).split()
}
ON_EARTH = 9.7, 9.9
"""g [m/s^2] is between these in every lab: 9.76 on the highest mountains, 9.83 at the
poles."""


def form_of(key: str) -> tuple[str, list[str]]:
    """Return how a line of several quantities is written, and their kinds.

    The text has {} in the place of each quantity.
    """
    sample, quantity = vocabulary.LINES[key]["sample"], r"(?<![0-9.])[0-9.]+ (\w+)"
    return re.sub(quantity, "{}", sample), [
        kind for [kind] in map(kinds_of, re.findall(quantity, sample))
    ]


def _read_several(key: str, text: str) -> tuple[float, ...]:
    """Read the quantities of one line [SI], such as the angle, the time and the spin of a drift."""
    text += ", friction 0 g" if key == "falling_mass" and "friction" not in text else ""
    (form, kinds), hint = (
        form_of(key),
        f'write it like "{vocabulary.LINES[key]["sample"]}"',
    )
    parts, rest = list[str](), " ".join(text.split())
    for separator in form.strip("{}").split("{}"):
        part, _, rest = rest.partition(separator)
        parts.append(part)
    parts.append(rest)
    if not all(parts):
        raise UnitError("is not understood", hint)
    try:
        numbers = tuple(map(notation.parse_quantity, parts, kinds))
    except UnitError as error:
        raise UnitError(f"is not understood: {error}", error.hint or hint) from None
    if key == "falling_mass":
        if min(numbers[:4]) <= 0 or not 0 <= numbers[4] < numbers[0]:
            raise UnitError("contains a value that is impossible", hint)
        return numbers
    for kind, number in zip(kinds, numbers, strict=True):
        role, size = (
            "spin" if kind == "rate" else kind,
            number if kind == "time" else abs(number),
        )
        if (fault := roles.check_value(role, size)[0]) and (number or kind != "angle"):
            raise UnitError(fault, hint)
    if key != "spin_down":
        return numbers
    start, end, seconds = abs(numbers[0]), abs(numbers[1]), numbers[2]
    if end > 1.02 * start:
        raise UnitError(
            "says that the spin rises", "exchange start and end if they are swapped"
        )
    return start, end, seconds


OF_NOTHING = {"u_time_bias": "0.1 s", "u_spin_delay": "1 s", "u_imbalance": "0.3 mN*m"}
"""Uncertainties of quantities with the expected value 0, with a sample: they cannot be
a share."""


def _enter(settings: Settings, item: Given, ask: bool, faults: Faults) -> None:
    """Enter one value; an option that cannot be read is refused at once."""
    key, text, line = item.key, item.text.strip(), vocabulary.LINES.get(item.key, {})
    if key == "position" and roles.from_centre(text):
        text = re.split(
            r"(?<!\s)\s+(?:from|to|von|zur?|bis|du|au|desde|al?|dal?|от|od|do)\b", text
        )[0]
    try:
        if key == "spin_down":
            falls = (
                _read_several(key, part.strip())
                for part in text.split(";")
                if part.strip()
            )
            # Several lines are several falls.
            settings.fields[key] = (*settings.fields.get(key, ()), *falls)
        elif "sample" in line:
            settings.fields[key] = _read_several(key, text)
        elif line:
            words = line.get("words") or YES_OR_NO
            if text.lower() not in words:
                raise UnitError(
                    "is none of the words that can be read here", line["hint"]
                )
            if key == "question_numbers":
                settings.metadata[key] = "yes" if words[text.lower()] else "no"
            else:
                settings.fields[key] = words[text.lower()]
        elif key in roles.UNCERTAINTIES:
            try:
                u = notation.parse_uncertainty(text, roles.kind_of_role(key), ask=ask)
            except UnitError as error:
                raise UnitError(f"is not an uncertainty: {error}", error.hint) from None
            if key.endswith("_scale") and u.absolute:
                raise UnitError(
                    "is not a share",
                    'the error of a whole scale is in %, such as "0.1 %"',
                )
            if key in OF_NOTHING and u.relative:
                raise UnitError(
                    "is a share of what is not read",
                    f'write it with its unit: "{OF_NOTHING[key]}"',
                )
            settings.uncertainties[key], settings.given_uncertainties[key] = u, item
        elif key == "latitude":
            match = re.fullmatch(r"(.*[^\s])\s*([NSns])", text)
            value = notation.read_cell(
                match[1] if match else text, "angle", "deg", ask
            ).value
            if abs(value) > math.pi / 2 or (match and value < 0):
                raise UnitError(
                    "is not a latitude",
                    'write it like "52.5 deg", from -90 at the south pole to 90 deg',
                )
            settings.constants[key] = -value if match and match[2] in "Ss" else value
        else:
            if key in roles.COUNTS and notation.take_apart(text) is None:
                text = roles.turns_in(f"{text} turns") or text  # "three", "one third"
            # g is in m/s² if it has no unit.
            written = notation.take_apart(text) if key == "g" else None
            bare = written is not None and not written.unit
            cell = notation.read_cell(
                text, roles.kind_of_role(key), "m/s^2" if bare else None, ask
            )
            if key == "g" and not ON_EARTH[0] <= cell.value <= ON_EARTH[1]:
                message = (
                    f"is {cell.value:.4g} m/s²; on Earth g is between {ON_EARTH[0]} "
                    f"and {ON_EARTH[1]} m/s²"
                )
                raise UnitError(
                    message,
                    'write the value of your place with its unit, such as "9.81 m/s^2"',
                )
            fault, hint = roles.check_value(key, cell.value)
            if key in roles.CONSTANTS and not cell.value > 0:
                fault, hint = "is not above zero", ""
            if fault:
                raise UnitError(fault, hint)
            if bare:
                faults.add("g_without_unit", item.place, text=item.text)
            if key in roles.CONSTANTS:
                settings.constants[key], settings.steps[key] = (
                    cell.value,
                    cell.step or 0.0,
                )
                if cell.uncertainty is not None:
                    settings.uncertainties.setdefault(f"u_{key}", cell.uncertainty)
            else:
                settings.roles[key] = replace(item, cell=cell)
    except UnitError as error:
        hint = error.hint or notation.how_to_write(roles.kind_of_role(key))
        values: dict[str, Any] = {
            "label": item.label,
            "text": item.text,
            "error": error,
            "hint": hint,
        }
        if item.place is None:
            raise Faults(faults.name).refuse("option_value", **values) from None
        settings.unread |= {key} & set(roles.ROLES)
        faults.add("key_value", item.place, **values)
