"""Read a log: its cells in SI as columns of readings, and what it lacks."""

from __future__ import annotations

import contextlib
import itertools
import math
import os
import re
from collections import Counter
from collections.abc import Collection, Mapping
from fractions import Fraction
from functools import lru_cache, partial
from typing import Any

from msgspec.structs import replace

from gyrodata.base import diagnostics
from gyrodata.quantities import notation, units, vocabulary
from gyrodata.quantities.notation import Quantity, fold_number, read_cell, to_float
from gyrodata.quantities.units import Uncertainty, UnitError, kinds_of
from gyrodata.readings import captions, lablog, layout, roles, shapes
from gyrodata.readings import choice as choices
from gyrodata.readings import grid as grids
from gyrodata.readings import source as sources
from gyrodata.readings.choice import Choice, Chosen
from gyrodata.readings.conversion import value_text
from gyrodata.readings.lablog import (
    BLANKS,
    UNKNOWN,
    Column,
    Faults,
    Place,
    Reading,
    Readings,
    Settings,
    Text,
    listing,
)
from gyrodata.readings.roles import TEXTS, kind_of_role, turns_in
from gyrodata.readings.workbook import MAX_COLUMNS

_THOUSANDS = re.compile(r"[-+]?[1-9][0-9]{0,2}[.,][0-9]{3}")
_FRACTION = re.compile(rf"{notation.NUMBER}|[1-9]/[1-9]")
"""A number, or a fraction such as 1/3."""
_CLOCK = re.compile(r"(?:[0-9]{1,2}:)?[0-9]{1,3}:[0-9]{2}")
_SMALL_DOUBT = 0.002
"""Error of rounded turns, as a share of them, that is too small for a warning."""
_LAP = 0.15
"""Largest difference of laps that count as equal [1]."""
_SAME = 0.01
"""Largest difference of two columns of one quantity that makes no difference to the
answer, as a share."""
_PLUS, _ARM = (
    rf"(?:(?<!\s)\s+)?{notation.PLUS}\s*",
    r"(?<![\d.,])(?:[1-9][\d.,]*\s?[cmсм][mм]|0[.,]\d+\s?[mм])\b",
)
"""Between two weights that hang together, and a length that may be an arm."""
_COUNTS = {"turns": "time", "spin_turns": "spin_time"}
"""Turns that the header of a time may state."""
_PULLS = ("mass", "force", "torque")
_CONSTANT = -1
"""Number of the cell of a value that is valid for the whole log."""


def read_log(
    source: sources.Source,
    *,
    name: str | None = None,
    settings: Mapping[str, Any] = {},
    mapping: Mapping[str, str] = {},
    config: str | os.PathLike[str] | None = None,
) -> Readings:
    """Read a lab log.

    Parameters
    ----------
    source : path, "-", bytes, open file, DataFrame, or str of several lines
        The log; ``-`` is standard input.
    name : str, optional
        Name to show instead of the source's own.
    settings : mapping
        ``--set``: values for the whole log, such as ``{"turns": "1", "g": "9.803
        m/s^2"}``; text, a quantity of pint or a number of uncertainties.
    mapping : mapping of str to str
        ``--map``: role to header as written.
    config : path, optional
        TOML file with more settings; `settings` replace them.

    Returns
    -------
    Readings
        With all diagnostics. If none is an error, every run has a time with its turns
        or angle (or a precession period or rate), a spin (or what gives one), and a
        load (mass and position, force and position, or torque).

    Raises
    ------
    InputError
        The source is not a readable log at all, or an option is wrong.
    TypeError
        An argument has a wrong type.
    """
    checked: dict[str, tuple[object, Any]] = {
        "name": (name, str | None),
        "config": (config, str | os.PathLike | None),
    }
    checked |= {"settings": (settings, Mapping), "mapping": (mapping, Mapping)}
    for what, (value, kinds) in checked.items():
        if not isinstance(value, kinds):
            raise TypeError(f"{what} cannot be {type(value).__name__} ({value!r:.60})")
    for text in (*settings, *mapping, *mapping.values()):
        if not isinstance(text, str):
            raise TypeError(
                f"a key of settings or mapping, or a header, cannot be {type(text).__name__}"
            )
    options = lablog.read_options(
        {key: value_text(value) for key, value in settings.items()},
        mapping,
        config,
    )
    grid, faults = sources.load(source, name)
    ask = grids.decimal_signs(grid) != {","}
    given = lablog.read_settings(grid.metadata, grid.comments, options, faults, ask)
    given.origin = captions.read_notes(grid, faults)
    grid, falls = shapes.reshape(grid, faults)
    given.fields["spin_down"] = (*given.fields.get("spin_down", ()), *falls)
    log = Readings(
        faults.name,
        grid.sha256,
        source_text="\n".join(faults.lines),
        sheets=faults.sheets,
        **given.fields,
    )
    log = replace(
        log,
        constants=given.constants,
        uncertainties=given.uncertainties,
        reported=given.reported,
    )
    stated_at = {key: item.place for key, item in given.given_uncertainties.items()}
    log = replace(log, metadata=given.metadata, stated_at=stated_at)
    decided = {
        *mapping.values(),
        *(key for key, item in given.roles.items() if item.place is None),
    }
    found = layout.find_layout(grid, faults, decided)
    if found is None:
        return replace(log, diagnostics=faults.all_told())
    found = choices.with_differences(found, faults)
    chosen = choices.choose(found, mapping, given, faults)
    log, unmoved = TableReader(found, chosen, given, faults, mapping).read(log)
    if not log.runs and not faults.has_error():
        faults.add("no_timed_runs")
    else:
        if log.runs and len(unmoved) == len(log.runs):
            faults.add("no_torque")
        unread = (
            {role for role in chosen.used if role not in log.columns}
            if faults.has_error()
            else set()
        )
        check_meaning(
            log,
            chosen,
            unread | given.unread,
            faults,
            is_told="precession_period" in mapping,
        )
    moved = [run for run in range(len(log.runs)) if run not in unmoved]
    if unmoved and moved:
        log = replace(log.select(moved), unmoved=log.select(sorted(unmoved)))
    return replace(log, diagnostics=faults.all_told())


# From cells to readings
# -------------------------------------------------------------------------------------------


_NO_WEIGHT = frozenset(vocabulary.words("no_weight").split())
_TURN = vocabulary.pattern("turn")
_TURN_BEHIND = rf"(?i)(.*?)(?:(?<!\s)\s+)?(?:of\s+)?(?:an?\s+)?{_TURN}\w*\.?"


@lru_cache(maxsize=4096)
def said_otherwise(text: str, role: str) -> str:
    """Return the number that a cell writes in words; else "".

    Examples are "none" of a mass, and "one third" or "120°" of turns.
    """
    if role == "mass":
        return "0 g" if re.sub(r"[\s.\-]+", "", text).lower() in _NO_WEIGHT else ""
    if fraction := fraction_of_date(text):
        return fraction
    match = re.search(_TURN, text) and re.fullmatch(_TURN_BEHIND, text)
    bare = match[1] if match else text
    if words := roles.words_of_turns(bare, whole=True):
        return words
    if bare != text and (bare == "" or notation.take_apart(bare) is not None):
        return bare or "1"
    written = notation.take_apart(text)
    angle = (
        written is not None
        and written.spread is None
        and kinds_of(written.unit or "") == {"angle"}
    )
    return turns_in(text) if angle else ""


def fraction_of_date(text: str) -> str:
    """Return the fraction of which a spreadsheet made a date: 1/3 for "3-Jan" and "01.

    Mrz"; "" for other texts.
    """
    pair = notation.date_pair(text)
    if pair is None or not (min(pair) == 1 or sorted(pair) == [2, 3]) or max(pair) > 12:
        return ""
    return f"{min(pair)}/{max(pair)}"


def rounded_turns(text: str) -> tuple[str, float]:
    """Return the fraction that was rounded to 0.33 or 0.7.

    The function also returns half of the rounding's width. The result is ("", 0) for
    other numbers.

    The screws of the ball are a third of a turn apart; a run without a weight takes a
    twelfth.
    """
    # Whole turns, however many, are meant as written.
    if not notation.PLAIN.fullmatch(text) or notation.last_place(text) >= 0:
        return "", 0.0
    value, step = to_float(text), float(f"1e{notation.last_place(text)}")
    twelfths = round(value * 12)
    # Quarters have few digits: they are meant as written. 2/3 cut off at 0.66 is wrong
    # by nearly a whole step.
    if twelfths % 3 == 0 or abs(value - twelfths / 12) >= step:
        return "", 0.0
    return str(Fraction(twelfths, 12)), step / math.sqrt(3)


def _differ(used: Reading, other: Reading) -> bool:
    """Return whether two readings of one quantity differ clearly.

    The difference is larger than their last digits and larger than a percent.
    """
    if used.value is None or other.value is None:
        return False
    # A whole number of turns is exact.
    steps = [reading.step or 0.0 for reading in (used, other)]
    digits = sum(step for step in steps if step < 1)
    gap = abs(abs(used.value) - abs(other.value))
    return gap > max(_SAME * abs(used.value), digits)


class TableReader:
    """Reads every cell of the columns chosen."""

    def __init__(
        self,
        table: layout.Layout,
        choice: Choice,
        settings: Settings,
        faults: Faults,
        mapped: Collection[str] = (),
    ) -> None:
        self.table, self.choice, self.settings, self.faults = (
            table,
            choice,
            settings,
            faults,
        )
        self.mapped = {*mapped}
        """Roles whose columns --map names."""
        self.grid, self.rows = table.grid, table.rows
        self.signs = grids.decimal_signs(self.grid, by_delimiter=False)
        self.expected_signs = self.signs or grids.decimal_signs(self.grid)
        self.find = partial(grids.find_place, self.grid.lines, self.grid.delimiter)
        self.replaced: set[int] = set()
        """Columns that an option replaces."""
        for given in (*settings.roles.values(), *settings.given_uncertainties.values()):
            if given.place is None and given.key in choice.used:
                columns = choice.used.pop(given.key)
                self.replaced |= {one.at for one in columns}
                faults.add(
                    "option_replaces", label=given.label, header=columns[0].cell.text
                )
        times = {role: choice.used.get(time, []) for role, time in _COUNTS.items()}
        self.stating = {
            role: many for role, many in times.items() if any(one.turns for one in many)
        }
        """The times whose headers state their turns, by the role of these turns."""
        self.there = {*choice.used, *settings.roles, *self.stating} - TEXTS
        self.derived = roles.derived_roles(self.there)
        self.columns: dict[str, Column] = {}
        """One reading for each row of the table, without the times."""
        self.floats: list[str] = []
        """Roles without a stated uncertainty that a DataFrame has as floats."""
        self.unmoved: set[int] = set()
        """Rows in which the rod did not move, without a weight."""

    def read(self, log: Readings) -> tuple[Readings, set[int]]:
        """Return the log with its readings, and the runs in which the rod did not move."""
        times, is_run = self._read_times()
        # The load is the first: it shows which cells are filled down, and whether the
        # rod may rest.
        for role in sorted(self.choice.used, key=_PULLS.__contains__, reverse=True):
            if role not in roles.BY_NAME or role == "time" or role in TEXTS:
                continue
            chosen, strict = self.choice.used[role][0], role not in self.derived
            if column := self._read_column(chosen, strict):
                if role in roles.FILLED_DOWN:
                    column = self._ask_for_unknown(
                        column, chosen.at, is_run, self.faults if strict else Faults("")
                    )
                # A constant of the log is in the blank cells already.
                filled = role in roles.FILLED_DOWN and role not in self.settings.roles
                self.columns[role] = (
                    self._fill_down(column, chosen.at, is_run, strict)
                    if filled
                    else column
                )
        plan = [
            (i, *time)
            for i in range(len(self.rows))
            for time in times
            if time[1].readings[i].text
        ]
        rows = (
            [i for i, *_ in plan]
            if times
            else [i for i, run in enumerate(is_run) if run]
        )
        all_rows = rows == [*range(len(self.rows))]
        columns = (
            self.columns
            if all_rows
            else {role: column.select(rows) for role, column in self.columns.items()}
        )
        columns = {
            role: column
            for role, column in columns.items()
            if any(one is not None for one in column.values)
        }
        if times:
            readings = [column.readings[i] for i, _, column in plan]
            finest = min(
                (reading.step for reading in readings if reading.step), default=None
            )
            readings = [
                replace(reading, step=finest) if reading.step else reading
                for reading in readings
            ]
            spots = tuple(column.spots[i] for i, _, column in plan)
            columns = {
                "time": replace(times[0][1], readings=tuple(readings), spots=spots),
                **columns,
            }
        for role, given in self.settings.roles.items():
            self._add_constant(role, given, columns, rows)
        self._add_stated_turns(columns, [chosen for _, chosen, _ in plan], len(rows))
        origin_u = self._count_from_centre(columns)
        others = [
            column.select(rows)
            for chosen in self.choice.others
            if (column := self._read_other(chosen))
        ]
        self._ask_which(columns, others)
        notes, lines = (
            self.choice.used.get("note"),
            tuple(self.rows[i].line for i in rows),
        )
        texts = tuple(self.rows[i].texts[notes[0].at] if notes else "" for i in rows)
        log = replace(
            log,
            runs=self._labels(rows),
            lines=lines,
            notes=texts,
            columns=columns,
            others=tuple(others),
        )
        origin = self.settings.fields.get("position_from")
        log = replace(
            log,
            position_from=origin,
            origin_u=origin_u,
            unread=self._note_unused(columns, rows),
        )
        return log, {run for run, i in enumerate(rows) if i in self.unmoved}

    def _read_times(self) -> tuple[list[tuple[Chosen, Column]], list[bool]]:
        """Check the lengths of the rows and read the times.

        Return them, and whether each row is a timed run.
        """
        width, notes = len(self.table.cells), self.choice.used.get("note")
        noted = notes is not None and notes[0].at == width - 1
        for row in self.rows:
            count = len(row.texts)
            if count > width:
                split = self.grid.delimiter == "," and "." not in "".join(row.texts)
                name = "row_too_long" if split else "row_without_header"
                self.faults.add(
                    name, self.grid.cell(row, width), count=count, width=width
                )
            elif (
                noted
                and grids.is_number(row.texts[-1])
                and not re.search(r"[^\W\d]", row.texts[-1])
            ):
                # A decimal comma that splits a number moves all that follows to the
                # right.
                self.faults.add("note_is_number", self.grid.cell(row, count - 1))
        used, times = self.choice.used, self.choice.used.get("time", [])
        periods = self.there.intersection(roles.ONE_TURN)
        if times and periods and self.there.isdisjoint(roles.COUNTS):
            # A time without turns is useless; its repeats would count one period
            # several times.
            why = (
                f"is not used: its turns are not given; {min(periods)} is read instead"
            )
            self.faults.add("not_used", times[0].cell, why=why)
            times = []
        read = [
            (chosen, column)
            for chosen in times
            if (column := self._read_column(chosen)) is not None
        ]
        counted = [1 + at for at, (one, _) in enumerate(read) if not one.turns]
        rows = [
            row
            for row in zip(*(column.values for _, column in read), strict=True)
            if None not in row
        ]
        laps = [
            (value / count, row[0])
            for row in rows
            for value, count in zip(row, counted, strict=False)
        ]
        if (
            len(counted) == len(read) > 1
            and laps
            and all(abs(lap - first) < _LAP * first for lap, first in laps)
        ):
            values = {
                "ratio": " : ".join(map(str, counted)),
                "count": len(counted),
                "last": read[-1][0].cell.text,
            }
            self.faults.add("times_of_a_running_clock", read[0][0].cell, **values)
        timed = [one for one, _ in read] or [
            used[role][0] for role in roles.ONE_TURN if role in used
        ]
        is_run = [
            not timed or any(re.search("[0-9]", row.texts[one.at]) for one in timed)
            for row in self.rows
        ]
        left_out = [row for row, run in zip(self.rows, is_run, strict=True) if not run]
        if left_out and any(is_run):
            lines = [row.line for row in left_out]
            self.faults.add("row_without_time", Place(lines[0], 1), lines=lines)
        return read, is_run

    def _read_other(self, chosen: Chosen) -> Column | None:
        """Read a further column of a role for comparison."""
        role = chosen.role
        used = self.choice.used.get(role, [chosen])[0].header
        if (
            role in TEXTS
            or role[:2] == "u_"
            or (role == "position" and roles.origin_in(chosen.header.text))
        ):
            self.faults.add(
                "not_used",
                chosen.cell,
                why=f'is not used: {role} is read from "{used.text}"',
            )
            return None
        if role == "time" and (used.unit, chosen.header.unit) == ("min", "s"):
            self.faults.add("minutes_and_seconds", chosen.cell, header=used.text)
            return None
        column = self._read_column(chosen, strict=False)
        if column is not None and used is not chosen.header:
            self.faults.add(
                "not_used",
                chosen.cell,
                why=f'is only compared: {role} is read from "{used.text}"',
            )
        return column

    def _ask_which(self, columns: Mapping[str, Column], others: list[Column]) -> None:
        """Ask which of two columns contains a quantity, if the answer depends on it."""
        for other in others:
            used = columns.get(other.role)
            if (
                used is None
                or other.role in self.derived | self.mapped
                or not roles.BY_NAME[other.role].part
            ):
                continue
            if _CONSTANT in used.spots or layout.is_of_means(other.header):
                continue
            header = roles.parse_header(other.header)
            by_clock = (
                other.role == "time"
                and header.unit is None
                and roles.parse_header(used.header).unit
            )
            if choices.may_number(header) or by_clock:
                # "n" may number the runs, and "Time" next to "time [s]" may be that of
                # the day
                continue
            pairs = zip(used.readings, other.readings, strict=True)
            run = next((run for run, pair in enumerate(pairs) if _differ(*pair)), None)
            if run is not None:
                values = {
                    "role": other.role,
                    "used": used.header,
                    "other": other.header,
                }
                values |= {
                    "says": used.readings[run].text,
                    "otherwise": other.readings[run].text,
                }
                self.faults.add("two_columns", other.cell(run), **values)

    def _read_column(self, chosen: Chosen, strict: bool = True) -> Column | None:
        """Read one column, with the value of the whole log in blank cells.

        None if it cannot be used.
        """
        role, kind, given = (
            chosen.role,
            kind_of_role(chosen.role),
            self.settings.roles.get(chosen.role),
        )
        faults, unit = (
            self.faults if strict else Faults(self.faults.name),
            chosen.header.unit,
        )
        texts: list[str] = []
        try:
            if unit:
                unit = units.parse_unit(unit, kind).text
            elif kind in ("number", "sign"):
                unit = ""
            else:
                unit = None
            texts = self._meant_texts(chosen, unit, faults)
        except UnitError as error:
            faults.add(
                "unit",
                chosen.cell,
                code=error.code,
                role=role,
                header=chosen.cell.text,
                error=error,
            )
        read = self._read_texts(chosen, texts, unit, faults) if texts else {}
        if not strict and faults.found:
            self.faults.add(
                "not_used",
                chosen.cell,
                why=f"({role}) is not compared: {faults.found[0].message}",
            )
        if not texts or (not strict and faults.found):
            return None
        spreads = self._spreads(role, chosen, unit, faults)
        spots = [row.spot(chosen.at) for row in self.rows]
        unit = unit or next((one.unit for one in read.values()), "")
        # A spreadsheet drops zeros at the end: the finest digit in the column shows how
        # all were read.
        finest: dict[str, float] = {}
        for one in read.values():
            if one.step is not None:
                finest[one.unit] = min(one.step, finest.get(one.unit, math.inf))
        if (
            strict
            and spots[0] % MAX_COLUMNS in self.grid.floats
            and units.SI[kind]
            and None in spreads
        ):
            finest = {}  # a float drops them too: 15.0 cm may be 15 or 15.00 cm
            self.floats.append(role)
        readings = []
        for i, (text, spread) in enumerate(zip(texts, spreads, strict=True)):
            if quantity := read.get(text):
                step = finest.get(quantity.unit) if quantity.step is not None else None
                readings.append(
                    Reading(quantity.value, step, quantity.uncertainty or spread, text)
                )
            elif role in roles.FILLED_DOWN and text in UNKNOWN:
                readings.append(Reading(text=text))
            elif text in BLANKS and given and role != "time":
                readings.append(given.reading(spread))
                spots[i] = _CONSTANT
            else:
                readings.append(Reading(text="" if text in BLANKS else text))
        place = given.place if given else None
        return Column(
            role,
            chosen.header.text,
            unit,
            tuple(readings),
            tuple(spots),
            place,
            self.find,
        )

    def _meant_texts(
        self, chosen: Chosen, unit: str | None, faults: Faults
    ) -> list[str]:
        """Return the texts of a column, as the quantities that they mean.

        The quantity replaces a name, a dash or a stopwatch's colon.
        """
        texts = [row.texts[chosen.at] for row in self.rows]
        if chosen.role in roles.TIMINGS and any(map(grids.is_number, texts)):
            texts = [
                text if re.search("[0-9]", text) else "" for text in texts
            ]  # "aborted"
        if chosen.part:
            pairs = (
                re.fullmatch(choices.TWO_READINGS, fold_number(text)) for text in texts
            )
            return [pair[chosen.part] for pair in pairs if pair]
        if chosen.role == "mass":
            # A dash without a position means "no weight"; in many rows it means "as
            # above".
            places = self.choice.used.get("position")
            positions = [row.texts[places[0].at] if places else "" for row in self.rows]
            places_blank = [position in BLANKS for position in positions]
            dashes = BLANKS - UNKNOWN - {""}
            dashed = [
                i for i, text in enumerate(texts) if text in dashes and places_blank[i]
            ]
            if 4 * len(dashed) > len(texts):
                dashed = []
            for i in dashed:
                texts[i] = "0"
        meant: dict[str, str] = {}
        # A line such as "A = 20.1 g", with no "+ 5 g" behind it, explains the name A.
        named = texts if chosen.role in roles.LOADS else ()
        parts = {
            part for text in named for part in (text, *re.split(_PLUS, text))
        }  # "A+B": both hang there
        names = {part for part in parts if part[:1].isalpha() and len(part) <= 20}
        if (
            chosen.role in ("mass", "position")
            and unit is None
            and all(re.fullmatch("[1-9]?", text) for text in texts)
        ):
            names = {*texts} - {
                ""
            }  # "Weight 1: 20.1 g" for 1 below "Weight", "hole 2 = 14.0 cm"
        for name in sorted(names)[:30]:
            owner = (
                rf"{re.escape(chosen.header.text)}\s*(?:n[or]\.?|#)?\s*"
                if name.isdigit()
                else ""
            )
            behind = rf"\s*(?:[,;)\"]|\.\s|$)|\s{{2}}|\t|\s+\(?{roles.FROM}\b"
            quantity = rf"({notation.NUMBER}\s*[^\W\d_]+)(?={behind})"
            stated = rf"(?i:(?<![\w.]){owner})(?<![\w.]){re.escape(name)}\s*[=:,;\t]\s*{quantity}"
            stated = rf"(?:{stated}|#{name}\s+{quantity})" if name.isdigit() else stated
            found = {
                match[match.lastindex or 0]
                for line in self.grid.lines
                for match in re.finditer(stated, line)
            }
            unit_of = ""
            # A table of the weights: "disc, mass / g" above "small, 19.7".
            for label, number in (
                filter(None, row.texts)
                for row in self.grid.rows
                if len(grids.filled_at(row)) == 2
            ):
                if not grids.is_number(number):
                    unit_of = roles.parse_header(number).unit or ""
                elif label == name and kind_of_role(chosen.role) in kinds_of(unit_of):
                    found.add(f"{number} {unit_of}")
            if len(found) == 1:
                meant[name] = found.pop()
        if meant:
            faults.add(
                "name_explained",
                chosen.cell,
                said=", ".join(f"{one} is {text}" for one, text in meant.items()),
            )
            lines = enumerate(self.grid.lines, 1)
            self.faults.take_back(
                "remark",
                {
                    n
                    for n, line in lines
                    if any(text in line for text in meant.values())
                },
            )
        if unit in ("s", None) and any(re.search("[:：]", text) for text in texts):
            meant = self._without_colons(chosen, texts, faults)
        return [
            " + ".join(meant.get(one, one) for one in re.split(_PLUS, text))
            if meant
            else text
            for text in texts
        ]

    def _without_colons(
        self, chosen: Chosen, texts: list[str], faults: Faults
    ) -> dict[str, str]:
        """Read 10:06 as 10.06 s if another row shows that it is not a clock time.

        Below a header in s only, ask.
        """
        header = chosen.header.text
        meant = {
            text: ".".join(text.rsplit(":", 1))
            for text in texts
            if _CLOCK.fullmatch(fold_number(text))
        }
        if stated := re.search(r"(?<![a-z])([a-z]+):[a-z]+(:[a-z]+)?", header.lower()):
            hours = stated[1].startswith("h")
            three = [text for text in meant if text.count(":") == 2 and stated[2]]
            return {
                text: text.removeprefix("00:") if hours else meant[text]
                for text in three
            }
        if not meant:
            return {}
        first, proof = (
            next(iter(meant)),
            next((text for text in meant if int(text[-2:]) >= 60), ""),
        )
        if proof:
            faults.add(
                "colons_are_points",
                chosen.cell,
                proof=proof,
                header=header,
                first=first,
                meant=meant[first],
            )
            return meant
        if chosen.header.unit is None:
            return {}
        cell, name = (
            self.grid.cell(self.rows[texts.index(first)], chosen.at),
            header.partition("[")[0].strip(),
        )
        faults.add(
            "colon", cell, role=chosen.role, first=first, meant=meant[first], name=name
        )
        return meant

    def _read_texts(
        self, chosen: Chosen, texts: list[str], unit: str | None, faults: Faults
    ) -> dict[str, Quantity]:
        """Read each text of a column once, and report the wrong cells."""
        role, kind, at = chosen.role, kind_of_role(chosen.role), chosen.at
        read: dict[str, Quantity] = {}
        faulty: dict[str, tuple[str, UnitError | str, str]] = {}
        for text in dict.fromkeys(texts):
            if text in BLANKS:
                continue
            # A comma or a point may separate thousands if the table's other numbers
            # have the other sign.
            ask = bool(_THOUSANDS.fullmatch(text))
            ask = ask and (
                self.expected_signs != {","} if "," in text else self.signs == {","}
            )
            try:
                if ask:
                    read_cell(text.replace(".", ","), kind, unit, ask=True)
                is_word = role in (
                    "mass",
                    "turns",
                    "spin_turns",
                ) and not _FRACTION.fullmatch(text)
                meant = said_otherwise(text, role) if is_word else ""
                read[text] = read_cell(meant or text, kind, unit, ask)
            except UnitError as error:
                # "8.83 (maybe late)"
                remark = re.fullmatch(
                    r"([-+]?[.,]?[0-9][^()]*?)(?:(?<!\s)\s+)?\([^\W\d][^()\d=±%]*\)",
                    text,
                )
                if (
                    remark
                    and not turns_in(text)
                    and not roles.altered_role(f"{role}: {text}")
                ):
                    with contextlib.suppress(UnitError):
                        read[text] = read_cell(remark[1], kind, unit, ask)
                        continue
                if error.code == diagnostics.UNIT_MISSING:
                    known = f"{units.KINDS[kind].examples}{', N for a weight' * (role == 'mass')}"
                    values = {
                        "text": chosen.header.text[:60],
                        "role": role,
                        "kind": units.KINDS[kind],
                        "units": known,
                    }
                    numbered = role in ("mass", "position") and all(
                        re.fullmatch("[0-9]?", text) for text in texts
                    )
                    faults.add(
                        "no_unit_but_numbers" if numbered else "no_unit",
                        chosen.cell.place,
                        **values,
                    )
                    break
                missed = "; or put # before the line of a run that was not measured"
                faulty[text] = (
                    error.code,
                    error,
                    error.hint + missed * (re.search(r"\d", text) is None),
                )
                continue
            fault, hint = roles.check_value(role, read[text].value)
            if fault:
                faulty[text] = diagnostics.NUMBER_IMPOSSIBLE, fault, hint
        said = (
            (turns_in(chosen.header.text) or roles.words_of_turns(chosen.header.text))
            if role in _COUNTS
            else ""
        )
        # Below "half turns" or "turns (half)" a whole number counts halves; fractions
        # are turns already.
        if (
            read
            and re.fullmatch("1/[2-9]|2/3|3/4", said)
            and all(one.value in range(10**6) for one in read.values())
        ):
            counted = {
                text: str(int(one.value) * Fraction(said)) for text, one in read.items()
            }
            shown = "; ".join(
                f"{text} is {turns}" for text, turns in list(counted.items())[:4]
            )
            faults.add("parts_of_turns", chosen.cell, said=shown)
            read |= {
                text: read_cell(turns, "number", "") for text, turns in counted.items()
            }
        large = [
            text
            for text, one in read.items()
            if role == "turns" and one.value > choices.MOST_TURNS
        ]
        angles = [
            text for text in large if read[text].value % 15 == 0 and text.isdecimal()
        ]
        if len(large) == len(read) and angles != large:
            angles = []
        for text in angles:
            part = Fraction(int(text), 360)
            hint = (
                f'if it is in degrees, write {part}, or the header as "angle [deg]"; '
                f"else {text}.0"
            )
            faulty[text] = (
                diagnostics.NUMBER_IMPOSSIBLE,
                "looks like an angle, and not like a number of turns",
                hint,
            )
        for i, (row, text) in enumerate(zip(self.rows, texts, strict=True)):
            pulls = (
                [self.columns[one].values[i] for one in _PULLS if one in self.columns]
                if text in faulty
                else []
            )
            if (
                role in roles.COUNTS
                and text in read
                and read[text].value == 0 in pulls
                and "time" in self.there
            ):
                self.unmoved.add(i)  # the rod did not move in a run without a weight
            elif text in faulty and len(row.texts) <= len(self.table.cells):
                code, wrong, hint = faulty[text]
                faults.add(
                    "cell",
                    self.grid.cell(row, at),
                    code=code,
                    role=role,
                    text=text,
                    fault=wrong,
                    hint=hint,
                )
        unclear = [
            text for text in read if kind == "number" and not _FRACTION.fullmatch(text)
        ]
        if dates := [text for text in unclear if fraction_of_date(text)]:
            said = "; ".join(
                f'{role} "{text}" is {fraction_of_date(text)}' for text in dates[:4]
            )
            self.faults.add(
                "date", self.grid.cell(self.rows[texts.index(dates[0])], at), said=said
            )
        return read

    def _spreads(
        self, role: str, chosen: Chosen | None, unit: str | None, faults: Faults
    ) -> list[Uncertainty | None]:
        """Return the u of each reading.

        It is that of its ``u_…`` column, else the ± of the header, else the ``u_…`` of
        the log.
        """
        common, kind = (
            roles.stated_u(role, self.settings.uncertainties),
            kind_of_role(role),
        )
        if chosen is not None and chosen.header.spread:
            common = self._uncertainty(
                chosen, chosen.header.spread, kind, unit or "", faults
            )
        spreads = [common] * len(self.rows)
        key = next((key for key in roles.u_keys(role) if key in self.choice.used), None)
        if key is None:
            return spreads
        column, own_kind = self.choice.used[key][0], kind_of_role(key)
        own_unit = column.header.unit or (unit if own_kind == kind else None)
        if own_unit is None and own_kind != "number":
            text, about = column.header.text[:60], units.KINDS[own_kind]
            faults.add(
                "no_unit",
                column.cell.place,
                text=text,
                role=key,
                kind=about,
                units=about.examples,
            )
            return spreads
        percent, own_unit = (" %", "") if own_unit == "%" else ("", own_unit or "")
        if self._uncertainty(column, f"0{percent}", own_kind, own_unit, faults) is None:
            return spreads
        for i, text in enumerate(row.texts[column.at] for row in self.rows):
            if text not in BLANKS:
                u = self._uncertainty(
                    column,
                    text if "%" in text else text + percent,
                    own_kind,
                    own_unit,
                    faults,
                    i,
                )
                spreads[i] = None if u is None else roles.as_u_of(role, key, u)
        return spreads

    def _uncertainty(
        self,
        column: Chosen,
        text: str,
        kind: str,
        unit: str,
        faults: Faults,
        row: int | None = None,
    ) -> Uncertainty | None:
        try:
            return notation.parse_uncertainty(text, kind, unit, ask=False)
        except UnitError as error:
            cell = (
                column.cell
                if row is None
                else self.grid.cell(self.rows[row], column.at)
            )
            faults.add(
                "uncertainty",
                cell,
                role=column.role,
                header=column.cell.text,
                error=error,
            )
            return None

    def _fill_down(
        self, column: Column, at: int, is_run: list[bool], strict: bool
    ) -> Column:
        """Give blank cells the value above.

        Never upwards, across a run without a weight, or from its turns.

        A position is valid for another weight only if the log states no other one. A
        cell such as "?" is not blank.
        """
        role, spots = column.role, list(column.spots)
        weights = self.columns["mass"].values if "mass" in self.columns else None
        lines, faults = (
            [row.line for row in self.rows],
            self.faults if strict else Faults(""),
        )
        readings = list(column.readings)
        loads = next(
            (
                self.columns[name].values
                for name in ("mass", "force")
                if name in self.columns
            ),
            None,
        )
        dittos = self.grid.dittos
        of_weight = (
            role == "position"
            and sum(reading.value is not None for reading in readings) > 1
        )
        above: dict[int, int] = {}
        early: list[int] = []
        first = last = None
        for i, reading in enumerate(readings):
            if reading.text:
                first, last = i if first is None else first, i
            elif weights and role in roles.LOADS and weights[i] == 0:
                last = None
            elif (
                last is not None
                and of_weight
                and loads
                and loads[last] != loads[i]
                and spots[i] not in dittos
            ):
                pass  # where the new weight hung is not known
            elif last is not None and not (
                weights and role in roles.COUNTS and weights[last] == 0 != weights[i]
            ):
                above[i] = last  # but without a weight the rod turns less
            elif first is None and is_run[i]:
                early.append(i)
        # An unreadable value above is reported once: the blank cells below it lack
        # nothing.
        filled = [
            i for i, j in above.items() if is_run[i] and column.values[j] is not None
        ]
        each = roles.BY_NAME[role].part in ("spin", "count") and 2 * len(filled) < sum(
            is_run
        )
        # The second of two runs shows no pattern, unless it only repeats a time.
        own = [i for i in filled if sum(map(bool, self.rows[i].texts)) > 2]
        each |= role in roles.COUNTS and bool(own) and sum(is_run) == 2
        if each or (role == "mass" and 8 * len(filled) < sum(is_run)):
            # If nearly every run has its own, a blank cell was forgotten.
            above = {i: j for i, j in above.items() if i not in filled}
            early, filled = early and sorted([*early, *filled]), []
        if early and first is not None:
            cell = self.grid.cell(self.rows[first], at)
            faults.add(
                "below_first_row", cell, role=role, lines=[lines[i] for i in early]
            )
        for i, j in above.items():
            readings[i], spots[i] = readings[j], spots[j]
        if filled:
            place = self.grid.cell(self.rows[filled[0]], at).place
            faults.add(
                "filled_down", place, role=role, lines=[lines[i] for i in filled]
            )
        return replace(column, readings=tuple(readings), spots=tuple(spots))

    def _ask_for_unknown(
        self, column: Column, at: int, is_run: list[bool], faults: Faults
    ) -> Column:
        """Report the cells of runs that contain "?" or "n/a".

        Return the column, with such cells of other rows blank.

        Without a weight no position is needed.
        """
        readings, role = list(column.readings), column.role
        loads = next(
            (self.columns[name].values for name in _PULLS if name in self.columns), None
        )
        for i, reading in enumerate(readings):
            if reading.text not in UNKNOWN:
                continue
            if is_run[i] and not (loads and role in roles.LOADS and loads[i] == 0):
                faults.add("unknown_cell", self.grid.cell(self.rows[i], at), role=role)
            else:
                readings[i] = Reading()
        return replace(column, readings=tuple(readings))

    def _add_constant(
        self,
        role: str,
        given: lablog.Given,
        columns: dict[str, Column],
        rows: list[int],
    ) -> None:
        """Add a value for the whole log, or report that a column replaces it."""
        column, unit = columns.get(role), given.cell.unit if given.cell else ""
        if column is None and rows:
            spreads = self._spreads(role, None, unit or None, self.faults)
            readings, spots = (
                tuple(given.reading(spreads[i]) for i in rows),
                (_CONSTANT,) * len(rows),
            )
            columns[role] = Column(
                role, given.label, unit, readings, spots, given.place
            )
        elif column and given.cell and _CONSTANT not in column.spots:
            self._compare_with_line(column, given)

    def _compare_with_line(self, column: Column, given: lablog.Given) -> None:
        """Ask which is right, if a line of the log gives another value than a whole column.

        A column with the name of the quantity itself replaces a line, and so does any
        column for a file of the bench.
        """
        stated = given.reading(None)
        run = next(
            (
                run
                for run, reading in enumerate(column.readings)
                if _differ(stated, reading)
            ),
            None,
        )
        if run is None:
            return
        name = roles.squeeze(roles.split_unit(column.header)[0]).lower()
        is_named = name == roles.squeeze(column.role)
        if given.place is None or is_named or not roles.BY_NAME[column.role].part:
            self.faults.add(
                "line_not_used", given.place, given=given, header=column.header
            )
            return
        values = {"role": column.role, "given": given, "header": column.header}
        self.faults.add(
            "line_and_column",
            column.cell(run),
            **values,
            says=column.readings[run].text,
        )

    def _compare_with_texts(self, counted: Column) -> None:
        """Report each line that states turns with which no cell agrees.

        It is an error if the column may number the runs.
        """
        heads = [cell.text for cell in self.table.cells]
        places = {text.text: text for text in captions.places_of(self.grid)}
        texts = [text for text in places if not all(head in text for head in heads)]
        texts = list(filter(turns_in, texts))
        timed = [
            re.search(captions.TIMED, text)
            or "turns" in captions.said_in(grids.Row(1, [text]))
            or not captions.TIME_WORDS.isdisjoint(
                word.rstrip("s") for word in roles.squeezed_words(text)
            )
            for text in texts
        ]
        # A run without a weight has 0 turns.
        lines = {
            text: said
            for text in itertools.compress(texts, timed)
            if (said := turns_in(text)) != "0"
        }
        is_counter, role = (
            roles.squeeze(counted.header).lower() in roles.COUNTER_WORDS,
            "number of turns",
        )
        if is_counter and (given := self.settings.roles.get("turns")):
            lines[f"{given.label}: {given.text}"] = given.text
        values, full = (
            [value or 0.0 for value in counted.values],
            2 * math.pi if counted.role == "angle" else 1.0,
        )
        if counted.role == "precession_period":
            values, role = [1.0], "time"
        for line, said in lines.items():
            count = self._count(said, places.get(line))
            if count is None or any(
                abs(value / full - count) < 0.02 for value in values
            ):
                continue
            if is_counter:
                told = {
                    "line": line,
                    "turns": said,
                    "header": counted.header,
                    "says": counted.readings[0].text,
                }
                self.faults.add("turns_contradict_line", counted.place(0), **told)
            else:
                self.faults.add("note", note=line, role=role)

    def _count(self, turns: str, cell: Text | None) -> float | None:
        """Read the turns that a line or a header states.

        None, with an error, for an impossible number.
        """
        try:
            count = read_cell(turns, "number", "").value
            fault, hint = roles.check_value("turns", count)
        except UnitError as error:
            count, fault, hint = 0.0, str(error), error.hint
        if not fault:
            return count
        self.faults.add("stated_turns", cell, turns=turns, fault=fault, hint=hint)
        return None

    def _add_stated_turns(
        self, columns: dict[str, Column], timed: list[Chosen], count: int
    ) -> None:
        """Give each time the turns that its header states.

        Report other turns of a column, and rounded turns.
        """
        for role, many in self.stating.items():
            ones = timed if role == "turns" else many[:1] * count
            if not ones:
                continue
            stated = {
                one.turns: self._count(one.turns, one.cell) for one in many if one.turns
            }
            read = {
                turns: count for turns, count in stated.items() if count is not None
            }
            if len(read) < len(stated):
                continue
            u, line = (
                roles.stated_u(role, self.settings.uncertainties),
                self.table.cells[0].place.line,
            )
            readings = [
                Reading(read[one.turns], None, u, one.turns) if one.turns else Reading()
                for one in ones
            ]
            header = next(one.cell.text for one in many if one.turns)
            spots = tuple(line * MAX_COLUMNS + one.at for one in ones)
            given = columns.get(role) or (
                columns.get("angle") if role == "turns" else None
            )
            if given is None:
                columns[role] = Column(
                    role, header, "", tuple(readings), spots, None, self.find
                )
                told = (
                    f'{role} is {one.turns} by the header "{one.cell.text}"'
                    for one in many
                    if one.turns
                )
                self.faults.add("turns_in_header", many[0].cell, said="; ".join(told))
            elif role == "turns" and not given.header.startswith("--"):
                full = 2 * math.pi if given.role == "angle" else 1.0
                for run, (value, reading) in enumerate(
                    zip(given.values, readings, strict=True)
                ):
                    if (
                        value
                        and reading.value
                        and abs(value / full - reading.value) > 0.02 * reading.value
                    ):
                        values = {
                            "header": ones[run].cell.text,
                            "turns": reading.text,
                            "other": given.header,
                        }
                        says = given.readings[run].text
                        self.faults.add(
                            "turns_contradict_header",
                            given.place(run),
                            says=says,
                            **values,
                        )
                        break
        turns = columns.get("turns")
        counted = next(
            (
                columns[role]
                for role in ("turns", "angle", "precession_period")
                if role in columns
            ),
            None,
        )
        if counted and not counted.header.startswith("--"):
            self._compare_with_texts(counted)
        counts = turns.readings if turns else ()
        texts = [reading.text if reading.u is None else "" for reading in counts]
        for text in dict.fromkeys(text for text in texts if re.search("[.,]", text)):
            meant, doubt = rounded_turns(text)
            if (
                turns and meant and doubt > _SMALL_DOUBT * to_float(text)
            ):  # 0.33 is not exactly a third
                self.faults.add(
                    "rounded",
                    turns.place(texts.index(text)),
                    text=text,
                    doubt=doubt,
                    meant=meant,
                )

    def _count_from_centre(self, columns: dict[str, Column]) -> float:
        """Make positions count from the centre of the ball.

        This is done if the log says that they count from another place.

        The function returns the standard uncertainty of the distance between the two
        [m]. It reports a text that gives another position.
        """
        position, stated = (
            columns.get("position"),
            self.settings.fields.get("position_from"),
        )
        if position is None:
            return 0.0
        for text in captions.texts_of(self.grid):
            of_arm = re.search(_ARM, text) and roles.from_centre(text)
            said = (
                captions.said_in(grids.Row(1, [text])).get("position")
                if of_arm
                else None
            )
            arm = read_cell(said[0], "length", None).value if said else 0.0
            agrees = any(
                abs(arm - (value or 0.0)) <= 0.05 * arm for value in position.values
            )
            is_head = arm and any(
                text == " ".join(row.texts)
                for row in self.grid.rows
                if grids.is_head(row)
            )
            if arm and not (
                agrees
                or roles.altered_role(text)
                or re.search(roles.CORRECTED, text)
                or is_head
            ):
                self.faults.add("note", note=text, role="position")
        named = "" if position.header.startswith(("#", "--")) else position.header
        noted = self.settings.origin
        of_header = roles.origin_in(named) or (
            "centre" if noted and roles.from_centre(named) else ""
        )
        if not stated and (noted, of_header) in (("both", ""), ("surface", "centre")):
            self.faults.add("two_origins", position.place(0))
            return 0.0
        origin = stated or of_header or noted
        if origin in ("", "centre"):
            return 0.0
        self.settings.fields["position_from"] = origin
        key, share, unknown = roles.ORIGIN_LENGTHS[origin]
        if origin == "surface" and key not in self.settings.constants:
            self._read_diameter()
        length = self.settings.constants.get(key)
        if length is None:
            otherwise = (
                ""
                if stated
                else '; if they count from the centre: "# position_from: centre"'
            )
            self.faults.add(unknown, position.place(0), otherwise=otherwise)
            return 0.0
        shift = share * length
        moved = list(position.readings)
        for run, value in enumerate(position.values):
            if value is not None:
                # A negative distance is on the counterweight's side.
                value = (
                    shift - value
                    if origin == "tip"
                    else value + math.copysign(shift, value)
                )
                moved[run] = replace(moved[run], value=value)
        columns["position"] = replace(position, readings=tuple(moved))
        done = (
            f"{100 * shift:.4g} cm is added to"
            if origin == "surface"
            else f"{100 * shift:.4g} cm less"
        )
        self.faults.add("moved", position.place(0), origin=origin, done=done)
        u = self.settings.uncertainties.get(f"u_{key}")
        return share * (
            self.settings.steps[key] / math.sqrt(12) if u is None else u.at(length)
        )

    def _read_diameter(self) -> None:
        """Read the diameter of the ball from a sentence such as "(ball diameter 101.6 mm)"."""
        rows = [
            (self.grid.cell(row, grids.filled_at(row)[0]), " ".join(row.texts))
            for row in self.grid.rows
        ]
        cells = [replace(cell, text=text) for cell, text in rows if " " in text]
        keys = (
            replace(cell, text=f"{key.replace('_', ' ')}: {cell.text}")
            for key, cell in self.grid.metadata
        )
        for cell in (*self.grid.comments, *cells, *keys):
            found = [
                one
                for part in re.split(captions.SENTENCE_END, cell.text)
                if (one := roles.diameter_in(part))
            ]
            try:
                quantity = read_cell(found[0], "length", None) if found else None
            except UnitError:
                quantity = None
            if quantity:
                self.settings.constants["ball_diameter"] = quantity.value
                self.settings.steps["ball_diameter"] = quantity.step or 0.0
                line = [cell.place.line]
                self.faults.add(
                    "line_read_as_key",
                    cell,
                    line=line,
                    key="ball_diameter",
                    value=found[0],
                )
                return

    def _note_unused(
        self, columns: dict[str, Column], rows: list[int]
    ) -> tuple[tuple[str, tuple[str, ...]], ...]:
        """Name each uncertainty without a reading.

        Return header and cells of the columns that were not read.
        """
        heard = {key for role in columns for key in roles.u_keys(role)}
        for key, chosen in self.choice.used.items():
            if key[:2] == "u_" and key not in heard and not self.faults.has_error():
                why = f"({key}) is not used: there is no {key[2:]} that it could belong to"
                self.faults.add("not_used", chosen[0].cell, why=why)
        if self.floats:
            self.faults.add("floats", roles=", ".join(self.floats))
        there = {*columns, *TEXTS}
        used = {
            one.at
            for role, many in self.choice.used.items()
            if role in there or role[:2] == "u_"
            for one in many
        }
        # A second column of a role is only compared, but a second text says something
        # else than the first.
        others = [
            one
            for one in self.choice.others
            if one.role in there and one.role not in TEXTS
        ]
        used |= self.replaced.union(one.at for one in others)
        heads = [
            (at, cell.text)
            for at, cell in enumerate(self.table.cells)
            if at not in used
        ]
        unread = [
            (head, tuple(self.rows[i].texts[at] for i in rows)) for at, head in heads
        ]
        return tuple((head, texts) for head, texts in unread if any(texts))

    def _labels(self, rows: list[int]) -> tuple[str, ...]:
        """Return the label of each run.

        It is the log's own label or the number of the run, with .1, .2 for repeats of
        one row.
        """
        column = self.choice.used.get("run")
        labels: dict[str, None] = {}
        for number, (i, times) in enumerate(Counter(rows).items(), 1):
            name = (self.rows[i].texts[column[0].at] if column else "") or str(number)
            for k in range(1, times + 1):
                label = name if times == 1 else f"{name}.{k}"
                while label in labels:
                    label += f" (line {self.rows[i].line})"
                labels[label] = None
        return tuple(labels)


# What is missing or contradicts itself
# ----------------------------------------------------------------------------


def check_meaning(
    log: Readings, choice: Choice, unread: set[str], faults: Faults, is_told: bool
) -> None:
    """Add a fault for everything that is missing or contradicts itself.

    `is_told`: --map names the period.
    """
    said = any(
        diagnostic.code == diagnostics.VALUE_BELOW_ITS_FIRST_ROW
        for diagnostic in faults.found
    )
    there, mass = set(log.columns) | unread, log.columns.get("mass")
    loaded = (
        mass is None or "force" in there or any(value != 0 for value in mass.values)
    )
    missing = [
        role
        for role in choices.missing_roles(there, log.columns, loaded)
        if role not in choice.asked
    ]
    if "precession_period" in choice.asked and "turns" in missing:
        missing.remove("turns")  # needed or not, by what is answered
    told = [choices.name_missing(role, missing, choice) for role in missing]
    if len(told) >= SEVERAL:
        told = [
            (
                "; ".join(message for message, _ in told),
                "\n".join(hint for _, hint in told),
            )
        ]
    for message, hint in told:
        faults.add("missing", message=message, hint=hint)
    unread = unread | choice.asked
    if (
        not missing
        and not any(
            kind_of_role(role) != "text" and role[:2] != "u_" for role in unread
        )
        and not said
    ):
        columns, lacking = log.columns, dict[str, list[int]]()
        # A run with every cell filled lacks nothing. A cell that could not be read is
        # reported already.
        blanks = (
            run
            for column in columns.values()
            for run, cell in enumerate(column.readings)
            if not cell.text
        )
        for run in sorted(set(blanks)):
            typed = {
                role for role, column in columns.items() if column.readings[run].text
            }
            for role in choices.missing_roles(
                typed, columns, mass is None or mass.values[run] != 0
            ):
                lacking.setdefault(role, []).append(run)
        for role, runs in lacking.items():
            lines = list(dict.fromkeys(log.lines[run] for run in runs))
            name = "run_lacks_turns" if role in roles.COUNTS else "run_lacks"
            faults.add(name, Place(lines[0], 1), lines=lines, role=role)
    turns, angle = log.columns.get("turns"), log.columns.get("angle")
    for run, (count, swept) in enumerate(
        zip(turns.readings, angle.readings, strict=True) if turns and angle else ()
    ):
        full = 2 * math.pi * (count.value or 0.0)
        if (
            full
            and swept.value
            and abs(swept.value - full)
            > max(swept.step or 0.0, 0.01 * abs(swept.value))
        ):
            place, degrees = angle.place(run) if angle else None, math.degrees(full)
            faults.add(
                "turns_contradict_angle",
                place,
                run=log.runs[run],
                turns=count,
                degrees=degrees,
                swept=swept,
            )
    if not is_told and "precession_period" in log.columns:
        _check_period(log.columns, faults)
    if choice.unplaced and not missing:
        texts = [cell.text for cell in choice.unplaced]
        faults.add(
            "headers_unknown" if len(texts) > 1 else "header_unknown",
            headers=listing(texts),
        )


SEVERAL = 4
"""This many missing quantities are reported together."""


def _check_period(columns: Mapping[str, Column], faults: Faults) -> None:
    """Ask if a period may not be the time of one turn: the error in I_zz would be large."""
    period, time = columns["precession_period"], columns.get("time")
    counted = columns.get("turns") or columns.get("angle")
    if counted is None or (time is not None and time.header == period.header):
        return
    full = 1.0 if counted.role == "turns" else 2 * math.pi
    turned = [
        abs(value) / full if value is not None else None for value in counted.values
    ]
    if time is None:
        if any(value is not None and abs(value - 1) >= 1e-3 for value in turned):
            place = next(
                filter(None, map(counted.place, range(len(turned)))), period.place(0)
            )
            faults.add(
                "turns_for_one_period",
                place,
                header=period.header,
                counted=counted.role,
            )
        return
    exchanged = [
        abs(value / seconds - count) < 0.02 * count
        for seconds, value, count in zip(
            time.values, period.values, turned, strict=True
        )
        if seconds and value and count and not 0.8 < count < 1.25
    ]
    if 2 * sum(exchanged) > len(exchanged):
        faults.add("exchanged", period.cell(0), period=period.header, time=time.header)
