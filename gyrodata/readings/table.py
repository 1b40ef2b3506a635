"""Read a log: its cells in SI as columns of readings, and what it lacks."""

from __future__ import annotations

import itertools
import os
from collections import Counter
from collections.abc import Mapping
from typing import Any

from msgspec import Struct
from msgspec.structs import replace

from gyrodata.base.errors import insist_on_type
from gyrodata.quantities import units
from gyrodata.quantities.numerals import has_digit
from gyrodata.quantities.units import Uncertainty, UnitError
from gyrodata.readings import compared, layout, roles, sheet
from gyrodata.readings import source as sources
from gyrodata.readings.blocks import BLOCKS, NO_BLOCKS, find_blocks, only_day
from gyrodata.readings.cells import (
    CellReader,
    DecimalSigns,
    Uncertainties,
    ask_for_unit,
    fraction_of_date,
    meant_texts,
)
from gyrodata.readings.choice import choose
from gyrodata.readings.compared import CONSTANT, ask_which, compare_with_line, leave_out
from gyrodata.readings.completeness import check_completeness
from gyrodata.readings.conversion import value_text
from gyrodata.readings.filling import Filler, Loads
from gyrodata.readings.grid import decimal_signs, is_bare, is_number
from gyrodata.readings.lablog import (
    BLANKS,
    UNKNOWN,
    Column,
    Faults,
    Place,
    Reading,
    Readings,
    header_of,
    listing,
)
from gyrodata.readings.layout import Choice, Chosen, note_unused
from gyrodata.readings.notes import read_notes, warn_of_unused
from gyrodata.readings.positions import count_from_centre
from gyrodata.readings.roles import TEXTS, kind_of_role
from gyrodata.readings.settings import Setting, Settings, read_options, read_settings
from gyrodata.readings.suggestions import header_row
from gyrodata.readings.turns import turns_in
from gyrodata.readings.workbook import MAX_COLUMNS

LOADS = ("mass", "force", "torque")
_LAP = 0.15
"""Largest difference of laps that count as equal [1]."""


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
    _check_types(name, settings, mapping, config)
    texts = {key: value_text(value) for key, value in settings.items()}
    options = read_options(texts, mapping, config)
    grid, faults = sources.load(source, name)
    ask = decimal_signs(grid) != {","}
    values = read_settings(grid.metadata, grid.comments, options, faults, ask)
    values.origin = read_notes(grid, faults)
    stated_at = {key: item.place for key, item in values.uncertainty_settings.items()}
    log = Readings(
        faults.name,
        grid.sha256,
        source_text="\n".join(faults.lines),
        sheets=faults.sheets,
        constants=values.constants,
        uncertainties=values.uncertainties,
        reported=values.reported,
        metadata=values.metadata,
        stated_at=stated_at,
        **values.fields,
    )
    is_plain = layout.is_plain(grid)
    table = layout.plain_layout(grid) if is_plain else sheet.find_layout(grid, faults)
    if table is not None:
        log = _with_runs(log, table, values, mapping, faults)
    return replace(log, diagnostics=faults.all_findings())


def _check_types(name: Any, settings: Any, mapping: Any, config: Any) -> None:
    insist_on_type("name", name, str | None, "a text")
    insist_on_type("config", config, str | os.PathLike | None, "the path of a file")
    insist_on_type("settings", settings, Mapping, "a mapping from keys to values")
    insist_on_type("mapping", mapping, Mapping, "a mapping from roles to headers")
    for text in (*settings, *mapping, *mapping.values()):
        insist_on_type(
            "a key of settings or mapping, or a header,", text, str, "a text"
        )


def _with_runs(
    log: Readings,
    table: layout.Layout,
    values: Settings,
    mapping: Mapping[str, str],
    faults: Faults,
) -> Readings:
    """Return the log with the runs of its table, after all questions about them."""
    choice = choose(table, mapping, values, faults)
    log, unmoved = TableReader(table, choice, values, faults).read(log)
    if not log.runs and not faults.has_error():
        faults.add("no_timed_runs")
    else:
        if log.runs and len(unmoved) == len(log.runs):
            faults.add("no_torque")
        lost = set(choice.used).difference(log.columns) if faults.has_error() else set()
        check_completeness(log, choice, table, lost | values.unread, faults)
    _warn_of_units(log, table, faults)
    rows_of_text = table.sentences[len(table.grid.comments) :]
    if rows_of_text:
        warn_of_unused(rows_of_text, faults)
    moved = [run for run in range(len(log.runs)) if run not in unmoved]
    if unmoved and moved:
        return replace(log.select(moved), unmoved=log.select(sorted(unmoved)))
    return log


def _warn_of_units(log: Readings, table: layout.Layout, faults: Faults) -> None:
    """Warn of other units in sentences without a number, whose unit it may be."""
    words = [each for each in table.sentences if not has_digit(each.text)]
    if words:
        compared.warn_of_units(words, log.columns, faults)


# From cells to readings


class _Run(Struct, frozen=True):
    """One timed run: a row, and the column of its time."""

    row: int
    time: Chosen
    column: Column


class TableReader:
    """Reads every cell of the columns chosen."""

    def __init__(
        self,
        table: layout.Layout,
        choice: Choice,
        settings: Settings,
        faults: Faults,
    ) -> None:
        self.table = table
        self.choice = choice
        self.settings = settings
        self.faults = faults
        self.grid = table.grid
        self.rows = table.rows
        typed = decimal_signs(self.grid, by_delimiter=False)
        expected = decimal_signs(self.grid)
        self.signs = DecimalSigns(typed, expected)
        self.replaced: set[int] = set()
        """Columns that an option replaces."""
        for item in (*settings.roles.values(), *settings.uncertainty_settings.values()):
            if item.place is None and item.key in choice.used:
                self._replace(item)
        self.uncertainties = Uncertainties(table, choice.used, settings.uncertainties)
        self.there = {*choice.used, *settings.roles} - TEXTS
        if choice.states_turns():
            self.there.add("turns")
        self.derived = roles.derived_roles(self.there)
        self.columns: dict[str, Column] = {}
        """One reading for each row of the table, without the times."""
        self.floats: list[str] = []
        """Roles without a stated uncertainty that a DataFrame has as floats."""
        self.without_unit: list[CellReader] = []
        """Columns of which neither the header nor a cell has a unit."""
        self.untimed: list[int] = []
        """Lines of the rows without a time, which are not runs."""
        self.unmoved: set[int] = set()
        """Rows in which the rod did not move, without a weight."""

    def _replace(self, option: Setting) -> None:
        """Take the columns that an option replaces out of the choice."""
        columns = self.choice.used.pop(option.key)
        self.replaced |= {column.at for column in columns}
        header = columns[0].text
        self.faults.add("option_replaces", label=option.label, header=header)

    def read(self, log: Readings) -> tuple[Readings, set[int]]:
        """Return the log with its readings, and the runs whose rod did not move."""
        self._check_widths()
        times = self._read_times()
        is_run = self._are_runs([time for time, _ in times])
        self._read_columns(is_run)
        if self.without_unit:
            self._ask_for_units()
        count = len(self.rows)
        runs = _runs_of(times, count)
        rows = [run.row for run in runs]
        if not times:
            rows = list(itertools.compress(range(len(self.rows)), is_run))
        columns = self._columns_of(rows, times, runs)
        for role, setting in self.settings.roles.items():
            self._use_constant(role, setting, columns, rows)
        self._use_stated_turns(columns, runs)
        roles_of_blocks, blocks = self._blocks(rows, columns)
        sentences = self.table.statements
        origin, origin_u = count_from_centre(
            columns, self.settings, sentences, self.faults
        )
        others = self._read_others(rows) if self.choice.others else []
        if others:
            decided = self.derived | self.choice.mapped
            ask_which(columns, others, decided, self.faults)
        log = replace(
            log,
            runs=self._labels(rows),
            lines=tuple(self.rows[i].line for i in rows),
            untimed=tuple(self.untimed),
            notes=self._texts("note", rows),
            screws=self._texts("screw", rows),
            blocks=blocks,
            columns=columns,
            others=tuple(others),
            position_from=origin,
            origin_u=origin_u,
            unread=self._unread(columns, rows, {*BLOCKS} - roles_of_blocks),
        )
        return log, {run for run, i in enumerate(rows) if i in self.unmoved}

    # Rows and times

    def _check_widths(self) -> None:
        """Report the rows with more cells than headers, and notes that are numbers.

        A decimal comma that splits a number moves all that follows to the right.
        """
        width = len(self.table.cells)
        notes = self.choice.columns("note")
        is_noted = any(note.at == width - 1 for note in notes[:1])
        for row in self.rows:
            count = len(row.texts)
            last = row.texts[-1]
            if count > width:
                is_split = self.grid.delimiter == "," and "." not in "".join(row.texts)
                name = "row_too_long" if is_split else "row_without_header"
                cell = self.grid.cell(row, width)
                self.faults.add(name, cell, count=count, width=width)
            elif is_noted and is_number(last) and last.upper() == last.lower():
                self.faults.add("note_is_number", self.grid.cell(row, count - 1))

    def _read_times(self) -> list[tuple[Chosen, Column]]:
        """Read the columns of the stopwatch."""
        times = self.choice.times()
        periods = self.there.intersection(roles.ONE_TURN)
        if times and periods and self.there.isdisjoint(roles.COUNTS):
            # A time without turns is useless; its repeats would count one period
            # several times.
            instead = f"{min(periods)} is read instead"
            why = f"is not used: its turns are not given; {instead}"
            note_unused(times[0], why, self.faults)
            return []
        columns = [(time, self._read_column(time)) for time in times]
        read = [(time, column) for time, column in columns if column is not None]
        if self.choice.states_turns():
            self._ask_for_turns(times)
        elif len(read) > 1:
            self._ask_for_laps(read)
        return read

    def _ask_for_turns(self, times: list[Chosen]) -> None:
        """Ask for the turns of times if only other headers state theirs.

        "T1" next to "T1/3" and "T2/3" is the time of one turn, or a first time.
        """
        silent = [time for time in times if not time.turns]
        known = {*self.choice.used, *self.settings.roles}
        if not silent or known.intersection(roles.COUNTS):
            return
        headers = {}
        for time in silent:
            headers[time.at] = header_of("time for 1 turn", time.header.unit)
        row = header_row(self.table, headers, []) or headers[silent[0].at]
        self.choice.asked.add("turns")
        self.faults.add("time_without_turns", silent[0].cell, row=row)

    def _ask_for_laps(self, times: list[tuple[Chosen, Column]]) -> None:
        """Ask if the repeats are readings of a clock that ran on: 1, 2, 3 laps."""
        rows = zip(*(column.values for _, column in times), strict=True)
        complete = [row for row in rows if None not in row]
        if complete and all(map(_are_laps, complete)):
            first, _ = times[0]
            last, _ = times[-1]
            ratio = " : ".join(map(str, range(1, len(times) + 1)))
            values = {"ratio": ratio, "count": len(times), "last": last.text}
            self.faults.add("times_of_a_running_clock", first.cell, **values)

    def _are_runs(self, times: list[Chosen]) -> list[bool]:
        """Return whether each row is a timed run; report the others."""
        used = self.choice.used
        timed = times or [used[role][0] for role in roles.ONE_TURN if role in used]
        if not timed:
            return [True] * len(self.rows)
        rows = zip(*(column.texts for column in timed), strict=True)
        is_run = [any(map(str.isdigit, "".join(texts))) for texts in rows]
        if set(is_run) == {True, False}:
            pairs = zip(self.rows, is_run, strict=True)
            self.untimed = [row.line for row, is_timed in pairs if not is_timed]
            place = Place(self.untimed[0], 1)
            self.faults.add("row_without_time", place, lines=self.untimed)
        return is_run

    # Columns

    def _read_columns(self, is_run: list[bool]) -> None:
        """Read one reading for each row of each role.

        The loads are the first: they show which cells are filled down, and whether the
        rod may rest.
        """
        for role in sorted(self.choice.used, key=lambda role: role not in LOADS):
            if role not in roles.BY_NAME or role == "time" or role in TEXTS:
                continue
            chosen = self.choice.first(role)
            strict = role not in self.derived
            column = self._read_column(chosen, strict)
            if column is None:
                continue
            loads = Loads.of(self.columns)
            if role in roles.FILLED_DOWN and not _is_complete(column, loads):
                faults = self.faults if strict else Faults("")
                filler = Filler(self.table, loads, is_run, faults)
                is_constant = role in self.settings.roles
                column = filler.complete(column, chosen.at, is_constant)
            self.columns[role] = column

    def _read_column(self, chosen: Chosen, strict: bool = True) -> Column | None:
        """Read one column, with the value of the whole log in blank cells.

        None if it cannot be used. A column that is not `strict` is only compared: its
        faults are a note.
        """
        faults = self.faults if strict else Faults(self.faults.name)
        column = self._read_cells(chosen, strict, faults)
        if strict or not faults.diagnostics:
            return column
        why = f"({chosen.role}) is not compared: {faults.diagnostics[0].message}"
        note_unused(chosen, why, self.faults)
        return None

    def _read_cells(
        self, chosen: Chosen, strict: bool, faults: Faults
    ) -> Column | None:
        role = chosen.role
        try:
            unit = _unit_of(chosen)
        except UnitError as error:
            values = {"role": role, "header": chosen.text, "error": error}
            faults.add("unit", chosen.cell, code=error.code, **values)
            return None
        places = self.choice.columns("position")
        positions = places[0].texts if places else ()
        texts = meant_texts(chosen, unit, self.table, positions, faults)
        cells = CellReader(chosen, unit, self.signs, faults)
        cells.read_all(texts)
        if cells.wrong:
            self._report(cells, texts, faults)
        if dates := cells.fractions_of_dates():
            self._note_dates(cells, texts, dates[:4])
        spreads = self.uncertainties.of_role(role, chosen, unit, faults)
        if strict and None in spreads and self._is_of_floats(chosen):
            cells.finest.clear()  # a float drops zeros: 15.0 cm may be 15 or 15.00 cm
            self.floats.append(role)
        return self._column(cells, texts, spreads)

    def _column(
        self, cells: CellReader, texts: list[str], spreads: list[Uncertainty | None]
    ) -> Column:
        """Return one reading for each text; blanks get the value of the whole log."""
        role = cells.role
        at = cells.column.at
        setting = self.settings.roles.get(role)
        readings = [
            self._reading(cells, text, u)
            for text, u in zip(texts, spreads, strict=True)
        ]
        spots = [
            CONSTANT if self._takes_constant(role, text) else row.spot(at)
            for row, text in zip(self.rows, texts, strict=True)
        ]
        of_cells = next((quantity.unit for quantity in cells.read.values()), "")
        return Column(
            role,
            cells.column.header.text,
            cells.unit or of_cells,
            tuple(readings),
            tuple(spots),
            setting.place if setting else None,
            self.grid.place_of,
        )

    def _reading(self, cells: CellReader, text: str, u: Uncertainty | None) -> Reading:
        """Return the reading of one cell; `u` is used if the cell states none."""
        role = cells.role
        quantity = cells.read.get(text)
        if quantity is not None:
            known = quantity.step is not None
            step = cells.finest.get(quantity.unit) if known else None
            return Reading(quantity.value, step, quantity.uncertainty or u, text)
        if self._takes_constant(role, text):
            return self.settings.roles[role].reading(u)
        is_asked = role in roles.FILLED_DOWN and text in UNKNOWN
        return Reading(text=text if is_asked or text not in BLANKS else "")

    def _takes_constant(self, role: str, text: str) -> bool:
        """Return whether the value of the whole log is valid in a cell."""
        if text not in BLANKS or role == "time" or role not in self.settings.roles:
            return False
        return role not in roles.FILLED_DOWN or text not in UNKNOWN

    def _is_of_floats(self, chosen: Chosen) -> bool:
        """Return whether a DataFrame has floats in a column."""
        at = self.rows[0].spot(chosen.at) % MAX_COLUMNS
        return at in self.grid.floats and units.SI[kind_of_role(chosen.role)] != ""

    def _report(self, cells: CellReader, texts: list[str], faults: Faults) -> None:
        """Report the cells that cannot be read."""
        if cells.lacks_unit:
            if faults is self.faults:
                self.without_unit.append(cells)
            else:
                ask_for_unit(cells.column, faults)
            return
        loads = Loads.of(self.columns)
        for i, (row, text) in enumerate(zip(self.rows, texts, strict=True)):
            wrong = cells.wrong.get(text)
            if wrong is None:
                continue
            if self._may_rest(cells, text) and loads.pulls_nothing(i):
                self.unmoved.add(i)  # the rod did not move in a run without a weight
            elif len(row.texts) <= len(self.table.cells):
                values = {"role": cells.role, "fault": wrong.fault, "hint": wrong.hint}
                cell = self.table.cell_of(cells.column, i)
                faults.add("cell", cell, code=wrong.code, text=text, **values)

    def _note_dates(
        self, cells: CellReader, texts: list[str], dates: list[str]
    ) -> None:
        """Say which dates were read as fractions."""
        cell = self.table.cell_of(cells.column, texts.index(dates[0]))
        words = [f'{cells.role} "{text}" is {fraction_of_date(text)}' for text in dates]
        self.faults.add("date", cell, said="; ".join(words))

    def _may_rest(self, cells: CellReader, text: str) -> bool:
        """Return whether a text is the 0 turns of a timed run."""
        if cells.role not in roles.COUNTS or "time" not in self.there:
            return False
        return text in cells.read and cells.read[text].value == 0

    def _ask_for_units(self) -> None:
        """Ask for the units of all columns without one in one message."""
        lacking = sorted(self.without_unit, key=lambda cells: cells.column.at)
        for cells in lacking:
            header = cells.column.header.text.strip()
            usual = header_of(header, units.KINDS[cells.kind].shown)
            self.choice.corrected[cells.column.at] = usual
        row = header_row(self.table, self.choice.corrected, [])
        if len(lacking) > 1 and row:
            named = [f'"{cells.column.text}" ({cells.role})' for cells in lacking]
            names = listing(named)
            self.faults.add(
                "no_units", lacking[0].column.cell.place, names=names, row=row
            )
            return
        for cells in lacking:
            ask_for_unit(cells.column, self.faults)

    # Runs

    def _columns_of(
        self,
        rows: list[int],
        times: list[tuple[Chosen, Column]],
        runs: list[_Run],
    ) -> dict[str, Column]:
        """Return the columns with one reading for each run, the time first."""
        columns = self.columns
        if rows != [*range(len(self.rows))]:
            columns = {role: column.select(rows) for role, column in columns.items()}
        columns = {
            role: each for role, each in columns.items() if set(each.values) - {None}
        }
        if not times:
            return columns
        return {"time": _time_of(times[0][1], runs), **columns}

    def _use_constant(
        self, role: str, setting: Setting, columns: dict[str, Column], rows: list[int]
    ) -> None:
        """Add a value for the whole log, or compare it with a column."""
        if role in columns:
            compare_with_line(columns[role], setting, self.faults)
        elif rows:
            unit = setting.cell.unit if setting.cell else ""
            spreads = self.uncertainties.of_role(role, None, unit or None, self.faults)
            readings = tuple(setting.reading(spreads[i]) for i in rows)
            spots = (CONSTANT,) * len(rows)
            columns[role] = Column(
                role, setting.label, unit, readings, spots, setting.place
            )

    def _use_stated_turns(self, columns: dict[str, Column], runs: list[_Run]) -> None:
        """Use the turns that the headers of the times state, and compare all turns."""
        sentences = self.table.sentences
        faults = self.faults
        times = [run.time for run in runs]
        u = roles.stated_u("turns", self.settings.uncertainties)
        if any(time.turns for time in times):
            compared.use_turns_of_headers(columns, times, self.table, u, faults)
        if any(turns_in(sentence.text) for sentence in sentences):
            compared.compare_turns_with_texts(columns, self.table, faults)
        if "turns" in columns:
            self._compare_turns(columns["turns"], columns)

    def _compare_turns(self, turns: Column, columns: dict[str, Column]) -> None:
        """Compare the turns with what is usual, with the angle and with the runs."""
        faults = self.faults
        compared.warn_of_rounded_turns(turns, faults)
        if "angle" in columns:
            compared.compare_turns_with_angle(turns, columns["angle"], faults)
        if turns.values[:1] == (1.0,) and "turns" not in self.choice.mapped:
            compared.ask_if_runs_are_counted(turns, self.table.sentences, faults)

    def _read_others(self, rows: list[int]) -> list[Column]:
        """Read the further columns of a role for comparison."""
        others = []
        for chosen in self.choice.others:
            used = self.choice.used.get(chosen.role, [chosen])[0]
            if leave_out(chosen, used, self.faults):
                continue
            column = self._read_column(chosen, strict=False)
            if column is None:
                continue
            if used is not chosen:
                why = (
                    f'is only compared: {chosen.role} is read from "{used.header.text}"'
                )
                note_unused(chosen, why, self.faults)
            others.append(column.select(rows))
        return others

    def _unread(
        self, columns: Mapping[str, Column], rows: list[int], unused: set[str]
    ) -> tuple[tuple[str, tuple[str, ...]], ...]:
        """Return header and cells of the columns that were not read.

        Columns of texts in the roles `unused` are among them.
        """
        if self.floats:
            self.faults.add("floats", roles=", ".join(self.floats))
        used = self._places_read({*columns, *TEXTS} - unused)
        unread = []
        for at, cell in enumerate(self.table.cells):
            texts = tuple(self.rows[i].texts[at] for i in rows)
            if at not in used and any(texts):
                unread.append((cell.text, texts))
        return tuple(unread)

    def _places_read(self, read: set[str]) -> set[int]:
        """Return the numbers of the columns that were read, compared or replaced.

        A second column of a role is only compared, but a second text says something
        else than the first.
        """
        used = [each for each in self.choice.others if each.role in read - TEXTS]
        for role, columns in self.choice.used.items():
            if role in read or role.startswith("u_"):
                used += columns
        return self.replaced.union(column.at for column in used)

    def _texts(self, role: str, rows: list[int]) -> tuple[str, ...]:
        """Return the text of each run in the column of a role; "" without a column."""
        columns = self.choice.columns(role)
        return tuple(columns[0].texts[i] if columns else "" for i in rows)

    def _blocks(
        self, rows: list[int], columns: Mapping[str, Column]
    ) -> tuple[set[str], tuple[str, ...]]:
        """Return the roles of days and groups, and the block of each run.

        A column that is not used is noted. If all runs are of one day, this is a
        statement about the log.
        """
        texts = {role: self._texts(role, rows) for role in BLOCKS}
        role, blocks = find_blocks(texts, columns)
        read = {role}
        if "day" in self.choice.used and (day := only_day(texts["day"])):
            self.settings.metadata.setdefault("day", day)
            read.add("day")
        for other in {*BLOCKS}.intersection(self.choice.used) - read:
            column = self.choice.first(other)
            note_unused(column, f"is not used: {NO_BLOCKS}", self.faults)
        return read, blocks

    def _labels(self, rows: list[int]) -> tuple[str, ...]:
        """Return the label of each run.

        It is the log's own label or the number of the run, with .1, .2 for repeats of
        one row.
        """
        names = self.choice.columns("run")
        labels: dict[str, None] = {}
        for number, (i, times) in enumerate(Counter(rows).items(), 1):
            name = (names[0].texts[i] if names else "") or str(number)
            for repeat in range(1, times + 1):
                label = name if times == 1 else f"{name}.{repeat}"
                while label in labels:
                    label += f" (line {self.rows[i].line})"
                labels[label] = None
        return tuple(labels)


def _runs_of(times: list[tuple[Chosen, Column]], rows: int) -> list[_Run]:
    """Return the timed runs: one for each time in a row."""
    return [
        _Run(i, time, column)
        for i, (time, column) in itertools.product(range(rows), times)
        if column.readings[i].text
    ]


def _unit_of(column: Chosen) -> str | None:
    """Return the unit of a column, in a spelling that this tool reads.

    "" for numbers, and None if each cell has its own unit.
    """
    kind = kind_of_role(column.role)
    unit = column.header.unit
    typed = [text for text in column.texts if text not in BLANKS]
    if unit == "%" and kind == "number" and all(map(is_bare, typed)):
        return ""  # percent of a turn
    if unit:
        return units.parse_unit(unit, kind).text
    return "" if kind in ("number", "sign") else None


def _are_laps(times: tuple[float | None, ...]) -> bool:
    """Return whether the times of one row are 1, 2, 3, … times the first."""
    first = times[0] or 0.0
    laps = [(time or 0.0) / number for number, time in enumerate(times, 1)]
    return all(abs(lap - first) < _LAP * first for lap in laps)


def _is_complete(column: Column, loads: Loads) -> bool:
    """Return whether each run has its reading; one without a weight needs no load."""
    lacking = [i for i, reading in enumerate(column.readings) if not reading.text]
    if any(reading.text in UNKNOWN for reading in column.readings):
        return False
    is_load = column.role in roles.LOADS
    return not lacking or (is_load and all(map(loads.pulls_nothing, lacking)))


def _time_of(time: Column, runs: list[_Run]) -> Column:
    """Return the times of all runs, with the finest digit of all repeats."""
    readings = [run.column.readings[run.row] for run in runs]
    finest = min((reading.step for reading in readings if reading.step), default=None)
    readings = [
        replace(reading, step=finest) if reading.step else reading
        for reading in readings
    ]
    spots = tuple(run.column.spots[run.row] for run in runs)
    return replace(time, readings=tuple(readings), spots=spots)
