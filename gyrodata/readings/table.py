"""From cells to columns of readings: units, fill-down, uncertainties, one row for each run."""

from __future__ import annotations

import math
import re
from collections import Counter
from functools import partial

from msgspec.structs import replace

from gyrodata import diagnostics as codes
from gyrodata.quantities import NUMBER, CellError, Quantity, fold_number, parse_uncertainty, read_cell, to_float
from gyrodata.readings import lablog, roles
from gyrodata.readings.columns import TWO_READINGS, Choice, Chosen
from gyrodata.readings.lablog import BLANKS, Column, Faults, Place, Reading, Readings, Text, span
from gyrodata.readings.layout import Layout, is_number
from gyrodata.readings.roles import TEXTS, kind_of_role
from gyrodata.readings.settings import Settings
from gyrodata.readings.source import MAX_COLUMNS, decimal_signs, find_place
from gyrodata.units import DISPLAY, KINDS, Uncertainty, UnitError, parse_unit

_BLANK = Reading()
_THOUSANDS = re.compile(r"[-+]?[1-9][0-9]{0,2}[.,][0-9]{3}")
_CLOCK = re.compile(r"(?:[0-9]{1,2}:)?[0-9]{1,3}:[0-9]{2}")
_SMALL_DOUBT = 0.002
"""Doubt about rounded turns, as a share of them, that no run notices."""
_ORIGINS = {
    "surface": ("ball_diameter", 0.5, "10.16 cm", "the diameter of your ball"),
    "tip": ("rod_length", 1.0, "25.0 cm", "the length from the centre of the ball to the tip of the rod"),
}
"""The length between the centre of the ball and the place where positions begin: key, share of it, sample, words."""
_COUNTS = {"turns": "time", "spin_turns": "spin_time"}
"""Turns that the header of a time may state."""
_PULLS = ("mass", "force", "torque")
_CONSTANT = -1
"""Spot of the value that holds for the whole log."""


class TableReader:
    """Reads every cell of the columns chosen."""

    def __init__(self, layout: Layout, choice: Choice, settings: Settings, faults: Faults) -> None:
        self.layout, self.choice, self.settings, self.faults = layout, choice, settings, faults
        self.grid, self.rows = layout.grid, layout.rows
        self.texts = [[*row.texts, *[""] * (len(layout.cells) - len(row.texts))] for row in layout.rows]
        self.signs, self.expected_signs = decimal_signs(self.grid, by_delimiter=False), decimal_signs(self.grid)
        self.find = partial(find_place, self.grid.lines, self.grid.delimiter)
        self.replaced: set[int] = set()
        """Columns that an option replaces."""
        for given in (*settings.roles.values(), *settings.given_uncertainties.values()):
            if given.place is None and given.key in choice.used:
                columns = choice.used.pop(given.key)
                self.replaced |= {one.at for one in columns}
                message = f'{given.label} takes the place of the column "{columns[0].cell.text}"'
                faults.add(codes.OPTION_REPLACES_COLUMN, message)
        stating = [role for role in _COUNTS if any(one.turns for one in choice.used.get(_COUNTS[role], ()))]
        self.stating = {role: choice.used[_COUNTS[role]] for role in stating}
        """The times whose headers state their turns, by the role of these turns."""
        self.there = {*choice.used, *settings.roles, *self.stating} - TEXTS
        self.derived = roles.derived_roles(self.there)
        self.columns: dict[str, Column] = {}
        """One reading for each row of the table; the times are not among them."""
        self.floats: list[str] = []
        """Roles without a stated uncertainty that a DataFrame has as floats."""
        self.unmoved: set[int] = set()
        """Rows in which the rod did not move, without a weight."""

    def read(self, log: Readings) -> tuple[Readings, set[int]]:
        """Put the readings into a log; name the runs in which the rod did not move."""
        self._check_widths()
        times = self._read_times()
        is_run = self._find_runs([chosen for chosen, _ in times])
        self._read_columns(is_run)
        plan = [(i, *time) for i in range(len(self.rows)) for time in times if time[1].readings[i].text]
        rows = [i for i, *_ in plan] if times else [i for i, run in enumerate(is_run) if run]
        columns = {role: column.select(rows) for role, column in self.columns.items()}
        columns = {role: column for role, column in columns.items() if any(one is not None for one in column.values)}
        if times:
            readings = [column.readings[i] for i, _, column in plan]
            finest = min((reading.step for reading in readings if reading.step), default=None)
            readings = [replace(reading, step=finest) if reading.step else reading for reading in readings]
            spots = tuple(column.spots[i] for i, _, column in plan)
            columns = {"time": replace(times[0][1], readings=tuple(readings), spots=spots), **columns}
        self._add_constants(columns, rows)
        self._add_stated_turns(columns, [chosen for _, chosen, _ in plan], len(rows))
        self._warn_of_rounded_turns(columns.get("turns"))
        origin_u = self._count_from_centre(columns)
        self._note_unused(columns)
        others = [column.select(rows) for chosen in self.choice.others if (column := self._read_other(chosen))]
        unmoved, notes = {run for run, i in enumerate(rows) if i in self.unmoved}, self.choice.used.get("note")
        log = replace(
            log,
            runs=self._labels(rows),
            lines=tuple(self.rows[i].line for i in rows),
            notes=tuple(self.texts[i][notes[0].at] if notes else "" for i in rows),
            columns=columns,
            others=tuple(others),
            position_from=self.settings.position_from,
            origin_u=origin_u,
            unread=self._unread(columns, rows),
        )
        return log, unmoved

    def _texts(self, at: int) -> list[str]:
        return [row[at] for row in self.texts]

    def _note(self, chosen: Chosen, what: str) -> None:
        self.faults.add(codes.COLUMN_NOT_USED, f'the column "{chosen.cell.text}" {what}', "", chosen.cell)

    def _check_widths(self) -> None:
        width, notes = len(self.layout.cells), self.choice.used.get("note")
        noted = notes is not None and notes[0].at == width - 1
        for row in self.rows:
            count = len(row.texts)
            if count > width:
                message = f"this row has {count} cells, the header {width}"
                hint = 'put numbers with a decimal comma in quotes ("13,06"), or part the columns with ;'
                self.faults.add(codes.ROW_TOO_LONG, message, hint, self.grid.cell(row, width))
            elif noted and count == width and is_number(row.texts[-1]):
                # A decimal comma that parts a number shifts all that follows to the right.
                message = f'the note "{row.texts[-1]}" is a number: is there a decimal comma in this row?'
                hint = 'put such numbers in quotes ("13,06"); words after the number make it a note'
                self.faults.add(codes.NOTE_IS_ONLY_A_NUMBER, message, hint, self.grid.cell(row, count - 1))

    def _read_times(self) -> list[tuple[Chosen, Column]]:
        times = self.choice.used.get("time", [])
        periods = self.there.intersection(roles.ONE_TURN)
        if times and periods and self.there.isdisjoint(roles.COUNTS):
            # A time without turns is useless; its repeats would count one period several times.
            self._note(times[0], f"is not used: its turns are not given; {min(periods)} is read instead")
            return []
        return [(chosen, column) for chosen in times if (column := self._read_column(chosen)) is not None]

    def _find_runs(self, timed: list[Chosen]) -> list[bool]:
        """Tell which rows are timed runs, and name the others."""
        timed = timed or [self.choice.used[role][0] for role in roles.ONE_TURN if role in self.choice.used]
        texts = [self._texts(one.at) for one in timed] or [["some"] * len(self.rows)]
        is_run = [not BLANKS.issuperset(row) for row in zip(*texts, strict=True)]
        left_out = [row for row, run in zip(self.rows, is_run, strict=True) if not run]
        if left_out and any(is_run):
            message = f"{span([row.line for row in left_out])}: left out, because there is no time"
            self.faults.add(codes.ROW_WITHOUT_TIME, message, "", Place(left_out[0].line, 1))
        return is_run

    def _read_columns(self, is_run: list[bool]) -> None:
        """Read all columns of numbers but the times."""
        # The load is the first: it says where to fill, and whether the rod may stay.
        for role in sorted(self.choice.used, key=lambda role: role not in _PULLS):
            if role in roles.BY_NAME and role != "time" and role not in TEXTS:
                chosen, strict = self.choice.used[role][0], role not in self.derived
                column = self._read_column(chosen, strict)
                # A constant of the log is in the blank cells already.
                if column is not None and role in roles.FILLED_DOWN and role not in self.settings.roles:
                    faults = self.faults if strict else Faults(self.faults.name)
                    column = self._fill_down(column, chosen.at, is_run, faults)
                if column is not None:
                    self.columns[role] = column

    def _read_other(self, chosen: Chosen) -> Column | None:
        """Read a further column of a role for comparison."""
        role = chosen.role
        used = self.choice.used.get(role, [chosen])[0].header
        if role in TEXTS or role[:2] == "u_":
            self._note(chosen, f'is not used: {role} is read from "{used.text}"')
            return None
        if role == "time" and (used.unit, chosen.header.unit) == ("min", "s"):
            message = f'the minutes are in "{used.text}", and the seconds in another column'
            hint = 'write minutes and seconds in one column, such as 1:40.65 below "time [min:s]"'
            self.faults.add(codes.HEADER_STANDS_TWICE, message, hint, chosen.cell)
            return None
        column = self._read_column(chosen, strict=False)
        if column is not None and used is not chosen.header:
            self._note(chosen, f'is only compared: {role} is read from "{used.text}"')
        return column

    def _read_column(self, chosen: Chosen, strict: bool = True) -> Column | None:
        """Read one column, with the value of the whole log in blank cells; None if it cannot be used."""
        role, kind, given = chosen.role, kind_of_role(chosen.role), self.settings.roles.get(chosen.role)
        faults, unit = self.faults if strict else Faults(self.faults.name), chosen.header.unit
        texts: list[str] = []
        try:
            unit = parse_unit(unit, kind).text if unit else "" if kind in ("number", "sign") else None
            texts = self._meant_texts(chosen, unit, faults)
        except UnitError as error:
            ambiguous = error.reason == "ambiguous"
            self._refuse(codes.PER_SECOND_IS_AMBIGUOUS if ambiguous else codes.UNIT_UNKNOWN, chosen, error, faults)
        read = self._read_texts(chosen, texts, unit, faults) if texts else {}
        if not strict and faults.found:
            self._note(chosen, f"({role}) is not compared: {faults.found[0].message}")
        if not texts or (not strict and faults.found):
            return None
        spreads = self._spreads(role, chosen, unit, faults)
        spots = [row.spot(chosen.at) for row in self.rows]
        unit = unit or next((one.unit for one in read.values()), "")
        # A spreadsheet drops zeros at the end: the finest digit in the column shows how all were read.
        finest: dict[str, float] = {}
        for one in read.values():
            if one.step is not None:
                finest[one.unit] = min(one.step, finest.get(one.unit, math.inf))
        if strict and spots[0] % MAX_COLUMNS in self.grid.floats and KINDS[kind].si and None in spreads:
            finest = {}  # a float drops them too: 15.0 cm may be 15 or 15.00 cm
            self.floats.append(role)
        readings = []
        for i, (text, spread) in enumerate(zip(texts, spreads, strict=True)):
            if quantity := read.get(text):
                step = finest.get(quantity.unit) if quantity.step is not None else None
                readings.append(Reading(quantity.value, step, quantity.uncertainty or spread, text))
            elif text in BLANKS and given and role != "time":
                readings.append(given.reading(spread))
                spots[i] = _CONSTANT
            else:
                readings.append(_BLANK if text in BLANKS else Reading(text=text))
        place = given.place if given else None
        return Column(role, chosen.header.text, unit, tuple(readings), tuple(spots), place, self.find)

    def _refuse(self, code: str, chosen: Chosen, error: UnitError, faults: Faults, cell: Text | None = None) -> None:
        message = f'{chosen.role}, column "{chosen.cell.text}": {error}'
        faults.add(code, message, error.hint, cell or chosen.cell)

    def _ask_for_unit(self, chosen: Chosen, faults: Faults) -> None:
        kind, name = kind_of_role(chosen.role), chosen.header.text[:60]
        hint = f'write the header as "{name} [{DISPLAY[kind]}]" (or {KINDS[kind].examples})'
        message = f'the column "{name}" ({chosen.role}) has no unit'
        faults.add(codes.UNIT_MISSING, message, hint, chosen.cell.place, len(name))

    def _read_texts(self, chosen: Chosen, texts: list[str], unit: str | None, faults: Faults) -> dict[str, Quantity]:
        """Read each text of a column once, and report the wrong cells."""
        role, kind, at = chosen.role, kind_of_role(chosen.role), chosen.at
        read: dict[str, Quantity] = {}
        faulty: dict[str, tuple[str, str, str]] = {}
        for text in dict.fromkeys(texts):
            if text in BLANKS:
                continue
            # A comma or a point may part thousands if the table's other numbers have the other sign.
            ask = bool(_THOUSANDS.fullmatch(text))
            ask = ask and (self.expected_signs != {","} if "," in text else self.signs == {","})
            try:
                if ask:
                    read_cell(text.replace(".", ","), kind, unit, ask=True)
                meant = lablog.said_otherwise(text, role) if role in lablog.SPOKEN else ""
                read[text] = read_cell(meant or text, kind, unit, ask)
            except CellError as error:
                if error.code == codes.UNIT_MISSING:
                    self._ask_for_unit(chosen, faults)
                    break
                faulty[text] = error.code, f'{role} "{text[:60]}"{error.joint}{error}', error.hint
                continue
            fault, hint = lablog.check_value(role, read[text].value)
            if fault:
                faulty[text] = codes.NUMBER_IMPOSSIBLE, f'{role} "{text}" {fault}', hint
        if role in _COUNTS:
            read |= self._in_turns(chosen, read, faults)
        for i, (row, text) in enumerate(zip(self.rows, texts, strict=True)):
            pulls = [self.columns[one].values[i] for one in _PULLS if one in self.columns] if text in faulty else []
            if role in roles.COUNTS and text in read and read[text].value == 0 in pulls and "time" in self.there:
                self.unmoved.add(i)  # the rod did not move in a run without a weight
            elif text in faulty:
                faults.add(*faulty[text], self.grid.cell(row, at))
        if dates := [text for text in read if kind == "number" and lablog.fraction_of_date(text)]:
            message = "; ".join(f'{role} "{text}" is {lablog.fraction_of_date(text)}' for text in dates[:4])
            cell = self.grid.cell(self.rows[texts.index(dates[0])], at)
            self.faults.add(codes.DATE_IS_A_FRACTION, f"{message}: a spreadsheet made a date of it", "", cell)
        return read

    def _in_turns(self, chosen: Chosen, read: dict[str, Quantity], faults: Faults) -> dict[str, Quantity]:
        """Give the turns of numbers that count parts of a turn, as the header says."""
        part = roles.part_counted(chosen.header.text)
        # Fractions are turns already.
        if part == 1 or not read or any(one.value < 0 or one.value % 1 for one in read.values()):
            return {}
        counted = {text: str(int(one.value) * part) for text, one in read.items()}
        said = "; ".join(f"{text} is {turns}" for text, turns in list(counted.items())[:4])
        faults.add(codes.TURNS_IN_HEADER, f'"{chosen.cell.text}" counts parts of a turn: {said}', "", chosen.cell)
        return {text: read_cell(turns, "number", "") for text, turns in counted.items()}

    def _meant_texts(self, chosen: Chosen, unit: str | None, faults: Faults) -> list[str]:
        """Give the texts of a column, with the quantity in the place of a name, a dash or a stopwatch's colon."""
        texts = self._texts(chosen.at)
        if chosen.part:
            texts = [match[chosen.part] for text in texts if (match := TWO_READINGS.fullmatch(fold_number(text)))]
        if chosen.role == "mass":
            # A dash without a position means "no weight"; in many rows it means "as above".
            places = self.choice.used.get("position")
            positions = self._texts(places[0].at) if places else [""] * len(texts)
            dashed = [i for i, text in enumerate(texts) if text and {text, positions[i]} <= BLANKS]
            for i in dashed if 4 * len(dashed) <= len(texts) else ():
                texts[i] = "0"
        meant: dict[str, str] = {}
        if chosen.role in roles.LOADS:
            meant = self._legend(chosen, texts, faults)
        if unit == "s":
            meant = self._without_colons(chosen, texts, faults)
        return [meant.get(text, text) for text in texts]

    def _legend(self, chosen: Chosen, texts: list[str], faults: Faults) -> dict[str, str]:
        """Find the quantity that a line gives to "A": "A = 20.1 g", with no "+ 5 g" behind it."""
        meant = {}
        for name in sorted({text for text in texts if text[:1].isalpha() and len(text) <= 20})[:30]:
            stated = re.compile(rf"(?<![\w.]){re.escape(name)}\s*[=:]\s*({NUMBER}\s*[^\W\d_]+)\s*(?=[,;)]|$)")
            found = {match[1] for line in self.grid.lines for match in stated.finditer(line)}
            if len(found) == 1:
                meant[name] = found.pop()
        if meant:
            said = ", ".join(f"{name} is {text}" for name, text in meant.items())
            faults.add(codes.CAPTION_READ, f'in the column "{chosen.cell.text}", {said}', "", chosen.cell)
        return meant

    def _without_colons(self, chosen: Chosen, texts: list[str], faults: Faults) -> dict[str, str]:
        """Read 10:06 as 10.06 s if another row shows that it is not a clock time; below a header in s only, ask."""
        header = chosen.header.text
        meant = {text: ".".join(text.rsplit(":", 1)) for text in texts if re.fullmatch(_CLOCK, fold_number(text))}
        if stated := re.search(r"([a-z]+):[a-z]+(:[a-z]+)?", header.lower()):
            hours = stated[1].startswith("h")
            three = [text for text in meant if text.count(":") == 2 and stated[2]]
            return {text: text.removeprefix("00:") if hours else meant[text] for text in three}
        if not meant:
            return {}
        first, proof = next(iter(meant)), next((text for text in meant if int(text[-2:]) >= 60), "")
        if proof:
            message = f'"{proof}" is not minutes and seconds, so in "{header}" the last colon is a point: '
            faults.add(codes.COLONS_ARE_POINTS, f"{message}{first} is {meant[first]}", "", chosen.cell)
            return meant
        message = f'{chosen.role} "{first}" in a column in seconds can be {meant[first]} s or minutes and seconds'
        hint = f"if the last colon is a point, write {meant[first]}, and so in every row; "
        hint += f'if not, write the header as "{header.partition("[")[0].strip()} [min:s]"'
        faults.add(codes.COLON_BELOW_SECONDS, message, hint, self.grid.cell(self.rows[texts.index(first)], chosen.at))
        return meant

    def _spreads(self, role: str, chosen: Chosen | None, unit: str | None, faults: Faults) -> list[Uncertainty | None]:
        """Collect what the ``u_…`` column says of each reading, else the ± of the header, else the log's ``u_…``."""
        common, kind = roles.stated_u(role, self.settings.uncertainties), kind_of_role(role)
        if chosen is not None and chosen.header.spread:
            common = self._uncertainty(chosen, chosen.header.spread, kind, unit or "", faults)
        spreads = [common] * len(self.rows)
        key = next((key for key in roles.u_keys(role) if key in self.choice.used), None)
        if key is None:
            return spreads
        column, own_kind = self.choice.used[key][0], kind_of_role(key)
        own_unit = column.header.unit or (unit if own_kind == kind else None)
        if own_unit is None and own_kind != "number":
            self._ask_for_unit(column, faults)
            return spreads
        percent, own_unit = (" %", "") if own_unit == "%" else ("", own_unit or "")
        if self._uncertainty(column, f"0{percent}", own_kind, own_unit, faults) is None:
            return spreads
        for i, text in enumerate(self._texts(column.at)):
            if text not in BLANKS:
                u = self._uncertainty(column, text if "%" in text else text + percent, own_kind, own_unit, faults, i)
                spreads[i] = None if u is None else roles.as_u_of(role, key, u)
        return spreads

    def _uncertainty(
        self, column: Chosen, text: str, kind: str, unit: str, faults: Faults, row: int | None = None
    ) -> Uncertainty | None:
        try:
            return parse_uncertainty(text, kind, unit, ask=False)
        except UnitError as error:
            cell = column.cell if row is None else self.grid.cell(self.rows[row], column.at)
            self._refuse(codes.UNCERTAINTY_CANNOT_BE_READ, column, error, faults, cell)
            return None

    def _fill_down(self, column: Column, at: int, is_run: list[bool], faults: Faults) -> Column:
        """Give blank cells the value above; never across a run without a weight, never upwards."""
        role, readings, spots = column.role, list(column.readings), list(column.spots)
        mass = self.columns.get("mass") if role in roles.LOADS else None
        lines = [row.line for row in self.rows]
        above: dict[int, int] = {}
        early: list[int] = []
        first = last = None
        for i, reading in enumerate(readings):
            if reading.text:
                first, last = i if first is None else first, i
            elif mass is not None and mass.values[i] == 0:
                last = None
            elif last is not None:
                above[i] = last
            elif first is None and is_run[i]:
                early.append(i)
        # An unreadable value above is reported once: the blank cells below it lack nothing.
        filled = [i for i, j in above.items() if is_run[i] and column.values[j] is not None]
        if roles.BY_NAME[role].part in ("spin", "count") and 2 * len(filled) < sum(is_run):
            # If nearly every run has its own, a blank cell was forgotten.
            above = {i: j for i, j in above.items() if i not in filled}
            filled = []
        if early and first is not None:
            message = f"{role} is blank in {span([lines[i] for i in early])}, above its first value"
            hint = "write each value in the first row that it belongs to"
            faults.add(codes.VALUE_BELOW_ITS_FIRST_ROW, message, hint, self.grid.cell(self.rows[first], at))
        for i, j in above.items():
            readings[i], spots[i] = readings[j], spots[j]
        if filled:
            message = f"{role} is blank in {span([lines[i] for i in filled])}: the value above was taken"
            row = self.rows[filled[0]]
            place = self.grid.cell(row, at).place if at < len(row.texts) else Place(row.line, 1)
            faults.add(codes.BLANK_TAKES_VALUE_ABOVE, message, "", place)
        return replace(column, readings=tuple(readings), spots=tuple(spots))

    def _add_constants(self, columns: dict[str, Column], rows: list[int]) -> None:
        """Add the values for the whole log; report a line that a column replaces."""
        for role, given in self.settings.roles.items():
            column, unit = columns.get(role), given.cell.unit if given.cell else ""
            if column is None and rows:
                spreads = self._spreads(role, None, unit or None, self.faults)
                readings, spots = tuple(given.reading(spreads[i]) for i in rows), (_CONSTANT,) * len(rows)
                columns[role] = Column(role, given.label, unit, readings, spots, given.place)
            elif column and given.cell and _CONSTANT not in column.spots and {*column.values} != {given.cell.value}:
                message = f'"{given.label}: {given.text}" is not used: each run has its own in "{column.header}"'
                self.faults.add(codes.COLUMN_NOT_USED, message, "take the line or the column away", given.place)

    def _add_stated_turns(self, columns: dict[str, Column], timed: list[Chosen], count: int) -> None:
        """Give each time the turns that its header states; ask if a column gives others."""
        for role, many in self.stating.items():
            ones = timed if role == "turns" else many[:1] * count
            if not ones:
                continue
            read = {one.turns: read_cell(one.turns, "number", "").value for one in many if one.turns}
            u, line = roles.stated_u(role, self.settings.uncertainties), self.layout.cells[0].line
            readings = [Reading(read[one.turns], None, u, one.turns) if one.turns else _BLANK for one in ones]
            header = next(one.cell.text for one in many if one.turns)
            spots = tuple(line * MAX_COLUMNS + one.at for one in ones)
            given = columns.get(role) or (columns.get("angle") if role == "turns" else None)
            if given is None:
                columns[role] = Column(role, header, "", tuple(readings), spots, None, self.find)
                told = (f'{role} is {one.turns} by the header "{one.cell.text}"' for one in many if one.turns)
                self.faults.add(codes.TURNS_IN_HEADER, "; ".join(told), "", many[0].cell)
            elif role == "turns" and not given.header.startswith("--"):
                full = 2 * math.pi if given.role == "angle" else 1.0
                for run, (value, reading) in enumerate(zip(given.values, readings, strict=True)):
                    if value and reading.value and abs(value / full - reading.value) > 0.02 * reading.value:
                        said = f'"{given.header}" says {given.readings[run].text}'
                        message = f'"{ones[run].cell.text}" covers {reading.text} turns, and {said}'
                        hint = f"correct one of the two, or say which holds with --set turns={reading.text}"
                        self.faults.add(codes.TURNS_CONTRADICT_ANGLE, message, hint, given.place(run))
                        break

    def _warn_of_rounded_turns(self, turns: Column | None) -> None:
        """Warn of 0.33, which is not exactly a third."""
        texts = [reading.text if reading.u is None else "" for reading in turns.readings] if turns else []
        for text in dict.fromkeys(texts):
            meant, doubt = lablog.rounded_turns(text)
            if turns and meant and doubt > _SMALL_DOUBT * to_float(text):
                message = f'turns "{text}" is taken as {text} ± {doubt:.1g}: is it {meant}, rounded?'
                hint, place = f"write {meant} where {meant} is meant", turns.place(texts.index(text))
                self.faults.add(codes.TURNS_ROUNDED, message, hint, place, len(text))

    def _count_from_centre(self, columns: dict[str, Column]) -> float:
        """Make positions count from the centre of the ball, if the log says that they count from elsewhere.

        The function returns the standard uncertainty of the distance between the two [m].
        """
        position, stated = columns.get("position"), self.settings.position_from
        if position is None:
            return 0.0
        origin = stated or ("" if position.header.startswith(("#", "--")) else roles.origin_in(position.header))
        if origin in ("", "centre"):
            return 0.0
        self.settings.position_from = origin
        key, share, sample, what = _ORIGINS[origin]
        length = self.settings.constants.get(key)
        if length is None:
            message = f"positions count from the {origin}, and the torque needs them from the centre of the ball"
            hint = f'write "# {key}: {sample}" above the header, or --set {key}="{sample}", with {what}'
            hint += "" if stated else '; if they count from the centre: "# position_from: centre"'
            self.faults.add(codes.POSITION_ORIGIN_UNKNOWN, message, hint, position.place(0))
            return 0.0
        shift = share * length
        moved = list(position.readings)
        for run, value in enumerate(position.values):
            if value is not None:
                # A negative distance is on the counterweight's side.
                value = shift - value if origin == "tip" else value + math.copysign(shift, value)
                moved[run] = replace(moved[run], value=value)
        columns["position"] = replace(position, readings=tuple(moved))
        done = f"{100 * shift:.4g} cm is added to" if origin == "surface" else f"{100 * shift:.4g} cm less"
        message = f"positions count from the {origin}: {done} each, so that all count from the centre of the ball"
        self.faults.add(codes.POSITION_MOVED, message, "", position.place(0))
        u = self.settings.uncertainties.get(f"u_{key}")
        return share * (self.settings.steps[key] / math.sqrt(12) if u is None else u.at(length))

    def _note_unused(self, columns: dict[str, Column]) -> None:
        """Name each uncertainty that belongs to no reading, and the digits that a DataFrame does not contain."""
        heard = {key for role in columns for key in roles.u_keys(role)}
        for key, chosen in self.choice.used.items():
            if key[:2] == "u_" and key not in heard and not self.faults.has_error():
                base = key.removeprefix("u_")
                self._note(chosen[0], f"({key}) is not used: there is no {base} that it could belong to")
        if self.floats:
            message = (
                f"floats do not contain the digits that were read: no rounding error is in {', '.join(self.floats)}"
            )
            self.faults.add(codes.FLOATS_WITHOUT_DIGITS, message, "to keep the digits: pandas.read_csv(…, dtype=str)")

    def _unread(self, columns: dict[str, Column], rows: list[int]) -> tuple[tuple[str, tuple[str, ...]], ...]:
        """Collect the columns of which no reading is in the table, and no text."""
        there = {*columns, *TEXTS}
        used = {one.at for role, many in self.choice.used.items() if role in there or role[:2] == "u_" for one in many}
        used |= self.replaced.union(one.at for one in self.choice.others)
        heads = [(at, cell.text or f"column {at + 1}") for at, cell in enumerate(self.layout.cells) if at not in used]
        unread = [(head, tuple(self.texts[i][at] for i in rows)) for at, head in heads]
        return tuple((head, texts) for head, texts in unread if any(texts))

    def _labels(self, rows: list[int]) -> tuple[str, ...]:
        """Label the runs: the log's own labels or their order, with .1, .2 for repeats of one row."""
        column = self.choice.used.get("run")
        labels: dict[str, None] = {}
        for number, (i, times) in enumerate(Counter(rows).items(), 1):
            name = (self.texts[i][column[0].at] if column else "") or str(number)
            for k in range(1, times + 1):
                label = name if times == 1 else f"{name}.{k}"
                while label in labels:
                    label += f" (line {self.rows[i].line})"
                labels[label] = None
        return tuple(labels)
