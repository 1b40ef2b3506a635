"""From cells to columns of readings: units, fill-down, uncertainties, one row for each run."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Mapping
from functools import cached_property, partial

from msgspec import Struct
from msgspec.structs import replace

from gyrodata.diagnostics import (
    BLANK_SPIN,
    BLANK_TAKES_VALUE_ABOVE,
    COLON_BELOW_SECONDS,
    COLONS_ARE_POINTS,
    COLUMN_NOT_USED,
    DATE_IS_A_FRACTION,
    FLOATS_WITHOUT_DIGITS,
    NOTE_IS_ONLY_A_NUMBER,
    NUMBER_IMPOSSIBLE,
    OPTION_REPLACES_COLUMN,
    PER_SECOND_IS_AMBIGUOUS,
    POSITION_MOVED,
    POSITION_ORIGIN_UNKNOWN,
    ROW_TOO_LONG,
    ROW_WITHOUT_TIME,
    TURNS_CONTRADICT_ANGLE,
    TURNS_IN_HEADER,
    TURNS_ROUNDED,
    UNCERTAINTY_CANNOT_BE_READ,
    UNIT_MISSING,
    UNIT_UNKNOWN,
    VALUE_BELOW_ITS_FIRST_ROW,
)
from gyrodata.quantities import Quantity, fold_number, parse_uncertainty, to_float
from gyrodata.readings.cells import (
    BLANKS,
    SPOKEN,
    CellError,
    check_value,
    fraction_of_date,
    read_cell,
    rounded_turns,
    said_otherwise,
)
from gyrodata.readings.columns import Choice, Chosen
from gyrodata.readings.headers import origin_in, part_counted, split_unit
from gyrodata.readings.lablog import TOLD_BLANK, Column, Faults, Place, Reading, span
from gyrodata.readings.layout import Layout, is_number
from gyrodata.readings.roles import (
    BY_NAME,
    COUNTS,
    FILLED_DOWN,
    LOADS,
    ONE_TURN,
    TEXTS,
    as_u_of,
    derived_roles,
    kind_of_role,
    stated_u,
    u_keys,
)
from gyrodata.readings.settings import Given, Settings
from gyrodata.readings.source import MAX_COLUMNS, Row, decimal_signs, find_place
from gyrodata.units import DISPLAY, KINDS, Uncertainty, UnitError, kinds_of, parse_unit

_BLANK = Reading()
_THOUSANDS = re.compile(r"[-+]?[1-9][0-9]{0,2}[.,][0-9]{3}")
_COLONS = re.compile(r"(?:([0-9]{1,2}):)?([0-9]{1,3}):([0-9]{2})")
"""A time without a point: minutes and seconds, or what a stopwatch shows of seconds and hundredths."""
_SMALL_DOUBT = 0.002
"""Doubt about rounded turns, as a share of them, that no run notices."""
_ORIGINS = {
    "surface": ("ball_diameter", 0.5, "10.16 cm", "the diameter of your ball"),
    "tip": ("rod_length", 1.0, "25.0 cm", "the length from the centre of the ball to the tip of the rod"),
}
"""What tells how far from the centre of the ball positions begin: key, share of it, sample, words."""
_ONE = ("1", "1/2", "1/3", "1/4", "2/3", "3/4")
_PULLS = ("mass", "force", "torque")
_CONSTANT = -1
"""Spot of the value that holds for the whole log."""


class Table(Struct, frozen=True):
    """The runs of a log."""

    runs: tuple[str, ...]
    lines: tuple[int, ...]
    notes: tuple[str, ...]
    columns: dict[str, Column]
    others: tuple[Column, ...]
    position_from: str | None = None
    origin_u: float = 0.0
    """Standard uncertainty of the distance from there to the centre of the ball [m]."""
    unmoved: tuple[int, ...] = ()
    """The runs without a weight in which the rod did not move: 0 turns."""
    unread: tuple[tuple[str, tuple[str, ...]], ...] = ()
    """Header and cells of each column that was not understood, as they are written."""


class _Track(Struct, frozen=True):
    """One role's readings by row of the file, before rows become runs."""

    chosen: Chosen
    unit: str
    readings: list[Reading]
    """Without a text where the cell is blank."""
    spots: list[int]
    spreads: list[Uncertainty | None]
    """What holds for a value of the whole log that stands in a blank cell."""


def build(layout: Layout, choice: Choice, settings: Settings, faults: Faults) -> Table:
    """Read every cell of the columns chosen."""
    return _Builder(layout, choice, settings, faults).build()


class _Builder:
    def __init__(self, layout: Layout, choice: Choice, settings: Settings, faults: Faults) -> None:
        self.choice, self.settings, self.faults = choice, settings, faults
        self.grid, self.rows, self.width = layout.grid, layout.rows, len(layout.cells)
        self.cells, self.combined = layout.cells, layout.combined
        self.head = Row(layout.cells[0].line, [])
        self.find = partial(find_place, self.grid.lines, self.grid.delimiter)
        self.replaced: set[str] = set()
        self.floats: dict[str, str] = {}
        """Last digit of each role without a stated uncertainty that a DataFrame has as floats; "" if it is unknown."""
        self.tracks: dict[str, _Track] = {}
        self.unmoved: set[int] = set()
        for role, given in settings.roles.items():
            if given.place is None and role in choice.used:
                self.replaced.add(role)
                self._note_replaced(given)
        for key, given in settings.given_uncertainties.items():
            if given.place is None and key in choice.used:
                self._note_replaced(given)
                del choice.used[key]
        self.there = (set(choice.used) | set(settings.roles)) - TEXTS
        if any(chosen.turns for chosen in choice.used.get("time", [])):
            self.there.add("turns")
        if any(chosen.turns for chosen in choice.used.get("spin_time", [])):
            self.there.add("spin_turns")
        self.derived = derived_roles(self.there)
        self.derived |= {f"u_{role}" for role in self.derived}

    def _note_replaced(self, given: Given) -> None:
        header = self.choice.used[given.key][0].header.text
        self.faults.add(OPTION_REPLACES_COLUMN, f'{given.label} takes the place of the column "{header}"')

    def build(self) -> Table:
        self._check_widths()
        times = self._time_tracks()
        is_run = self._run_rows(times)
        tracks = self.tracks
        # What it weighs says where to fill, and whether the rod may stay.
        load = next((role for role in _PULLS if role in self.choice.used), "")
        for role in sorted(self.choice.used, key=lambda r: r != load):
            if role == "time" or role in TEXTS or role[:2] == "u_" or role in self.replaced:
                continue
            strict = role not in self.derived
            track = self._track(role, self.choice.used[role][0], strict)
            if track is not None:
                # A constant of the log would stand in the blank cells.
                if role in FILLED_DOWN and role not in self.settings.roles:
                    faults = self.faults if strict else Faults(self.faults.name)
                    self._fill_down(role, track, tracks.get("mass"), is_run, faults)
                tracks[role] = track
        rows = [i for i, run in enumerate(is_run) if run]
        plan = [(i, k) for k, time in enumerate(times) for i in rows if time.readings[i].text]
        plan = sorted(plan) if times else [(i, 0) for i in rows]
        rows = [i for i, _ in plan]
        columns: dict[str, Column] = {}
        if times:
            columns["time"] = self._time_column(times, plan)
        for role, track in tracks.items():
            column = self._column(role, track, rows)
            if any(reading.value is not None for reading in column.readings):
                columns[role] = column
                self._note_overruled(role, column)
        for role, given in self.settings.roles.items():
            if role not in columns and plan:
                columns[role] = self._constant_column(role, given, rows)
        self._add_stated_turns(columns, times, plan)
        self._warn_of_rounded_turns(columns.get("turns"))
        position_from, origin_u = self._count_from_centre(columns)
        self._note_unheard(columns)
        self._note_floats()
        others = [self._other(chosen, rows) for chosen in self.choice.others]
        labels = self._labels(rows)
        notes = self.choice.used.get("note")
        return Table(
            labels,
            tuple(self.rows[i].line for i in rows),
            tuple(self._text(i, notes[0].at) if notes else "" for i in rows),
            columns,
            tuple(other for other in others if other is not None),
            position_from,
            origin_u,
            tuple(k for k, i in enumerate(rows) if i in self.unmoved),
            self._unread(columns, rows),
        )

    def _unread(self, columns: dict[str, Column], rows: list[int]) -> tuple[tuple[str, tuple[str, ...]], ...]:
        """Collect the columns of which no reading is in the table, and no text."""
        used = {one.at for role, many in self.choice.used.items() if role in {*columns, *TEXTS} for one in many}
        used |= {one.at for one in self.choice.others} | self.combined
        us = {one.at for role, many in self.choice.used.items() if role[:2] == "u_" for one in many}
        unread = [(at, tuple([self._text(i, at) for i in rows])) for at in range(self.width) if at not in used | us]
        return tuple((self.cells[at].text or f"column {at + 1}", texts) for at, texts in unread if any(texts))

    def _note_overruled(self, role: str, column: Column) -> None:
        """Name a line of the log whose value no run has, for each has its own in a column."""
        given = self.settings.roles.get(role)
        if given is None or given.place is None or given.cell is None or _CONSTANT in column.spots:
            return
        if any(reading.value != given.cell.value for reading in column.readings):
            message = f'"{given.label}: {given.text}" is not used: each run has its own in the column "{column.header}"'
            self.faults.add(COLUMN_NOT_USED, message, "take the line or the column away", given.place)

    def _constant_column(self, role: str, given: Given, rows: list[int]) -> Column:
        unit = given.cell.unit if given.cell else ""
        spreads = self._spreads(role, None, unit or None, self.faults)
        readings = tuple(given.reading(spreads[i]) for i in rows)
        return Column(role, given.label, unit, readings, (_CONSTANT,) * len(rows), given.place)

    def _add_stated_turns(self, columns: dict[str, Column], times: list[_Track], plan: list[tuple[int, int]]) -> None:
        """Give each time the turns that its header states, where no column and no option gives them."""
        stating = [(role, chosen) for role in ("time", "spin_time") for chosen in self.choice.used.get(role, [])]
        stating = [(role, chosen) for role, chosen in stating if chosen.turns]
        told = []
        for role, chosen in stating:
            counts = "turns" if role == "time" else "spin_turns"
            given = columns.get(counts) or columns.get("angle") if role == "time" else columns.get(counts)
            if given is None or given.header == chosen.cell.text:
                told.append(f'"{chosen.cell.text}" covers {chosen.turns} turn{"s" * (chosen.turns not in _ONE)}')
        if not stating or not plan:
            return
        if "turns" in columns or "angle" in columns:
            self._compare_stated(columns, times, plan)
        elif any(role == "time" for role, _ in stating):
            columns["turns"] = self._stated_column("turns", [times[k].chosen for _, k in plan])
        spun = next((chosen for role, chosen in stating if role == "spin_time"), None)
        if spun is not None and "spin_turns" not in columns:
            columns["spin_turns"] = self._stated_column("spin_turns", [spun] * len(plan))
        if told:
            self.faults.add(TURNS_IN_HEADER, "; ".join(told), "", stating[0][1].cell)

    def _warn_of_rounded_turns(self, turns: Column | None) -> None:
        """Warn of 0.33, which is no third."""
        for run, text in enumerate(dict.fromkeys(r.text for r in turns.readings if r.u is None) if turns else ()):
            meant, doubt = rounded_turns(text)
            if turns is not None and meant and doubt > _SMALL_DOUBT * to_float(text):
                run = [reading.text for reading in turns.readings].index(text)
                message = f'turns "{text}" is taken as {text} ± {doubt:.1g}: is it {meant}, rounded?'
                self.faults.add(
                    TURNS_ROUNDED, message, f"write {meant} where {meant} is meant", turns.place(run), len(text)
                )

    def _count_from_centre(self, columns: dict[str, Column]) -> tuple[str | None, float]:
        """Make positions count from the centre of the ball, where the log says that they count from elsewhere."""
        position, stated = columns.get("position"), self.settings.position_from
        if position is None:
            return stated, 0.0
        in_header = "" if position.header.startswith(("#", "--")) else origin_in(position.header)
        origin = stated or in_header
        if origin in ("", "centre"):
            return stated, 0.0
        key, share, sample, what = _ORIGINS[origin]
        length = self.settings.constants.get(key)
        if length is None:
            who = f'"{position.header}" counts' if in_header else "the positions count"
            message = f"{who} from the {origin}, and the torque needs the distance from the centre of the ball"
            hint = f'write "# {key}: {sample}" above the header, or --set {key}="{sample}", with {what}'
            if not stated:
                hint += '; if it counts from the centre: "# position_from: centre"'
            self.faults.add(POSITION_ORIGIN_UNKNOWN, message, hint, position.place(0))
            return origin, 0.0
        shift = share * length
        u = self.settings.uncertainties.get(f"u_{key}")
        readings = tuple(
            reading if reading.value is None else replace(reading, value=_from_centre(reading.value, origin, shift))
            for reading in position.readings
        )
        columns["position"] = replace(position, readings=readings)
        done = f"{100 * shift:.4g} cm is added to" if origin == "surface" else f"{100 * shift:.4g} cm less"
        message = f"positions count from the {origin}: {done} each, so that all count from the centre of the ball"
        self.faults.add(POSITION_MOVED, message, "", position.place(0))
        rounding = self.settings.steps[key] / math.sqrt(12)
        return origin, share * (rounding if u is None else u.at(length))

    def _stated_column(self, role: str, chosen: list[Chosen]) -> Column:
        spread = stated_u(role, self.settings.uncertainties)
        readings, spots = [], []
        for one in chosen:
            read = read_cell(one.turns, "number", "") if one.turns else None
            readings.append(_BLANK if read is None else Reading(read.value, None, spread, one.turns))
            spots.append(self.head.spot(one.at))
        header = next(one.cell.text for one in chosen if one.turns)
        return Column(role, header, "", tuple(readings), tuple(spots), None, self.find)

    def _compare_stated(self, columns: dict[str, Column], times: list[_Track], plan: list[tuple[int, int]]) -> None:
        """Ask, where a header states other turns than stand in their column."""
        counts = columns.get("turns") or columns["angle"]
        full = 1.0 if counts.role == "turns" else 2 * math.pi
        for run, (_, k) in enumerate(plan if times else []):
            turns, value = times[k].chosen.turns, counts.readings[run].value
            if turns and value is not None and not counts.header.startswith("--"):
                stated = read_cell(turns, "number", "").value
                if abs(value / full - stated) > 0.02 * stated:
                    cell = times[k].chosen.cell
                    message = (
                        f'"{cell.text}" covers {turns} turns, and "{counts.header}" says {counts.readings[run].text}'
                    )
                    hint = f"correct one of the two, or say which holds with --set turns={turns}"
                    self.faults.add(TURNS_CONTRADICT_ANGLE, message, hint, counts.place(run))
                    return

    def _note_unheard(self, columns: Mapping[str, Column]) -> None:
        """Name every ``u_…`` column that no readings take their uncertainty from."""
        told = {key for role in columns for key in u_keys(role)}
        for key, chosen in self.choice.used.items():
            if key[:2] == "u_" and key not in told and not self.faults.has_error():
                cell, base = chosen[0].cell, key.removeprefix("u_")
                message = f'the column "{cell.text}" ({key}) is not used: there is no {base} that it could belong to'
                self.faults.add(COLUMN_NOT_USED, message, "", cell)

    def _note_floats(self) -> None:
        """Say which digits are taken as read, where a DataFrame does not contain them."""
        unknown = [role for role, step in self.floats.items() if not step]
        told = [f"{role} is taken as read to {step}" for role, step in self.floats.items() if step]
        told += [f"no rounding error is included for {', '.join(unknown)}"] if unknown else []
        if told:
            message = f"floats do not contain the digits that were read: {'; '.join(told)}"
            self.faults.add(FLOATS_WITHOUT_DIGITS, message, "to keep the digits: pandas.read_csv(…, dtype=str)")

    def _text(self, row: int, at: int) -> str:
        texts = self.rows[row].texts
        return texts[at] if at < len(texts) else ""

    def _check_widths(self) -> None:
        notes = self.choice.used.get("note")
        noted = notes is not None and notes[0].at == self.width - 1
        for row in self.rows:
            cells = len(row.texts)
            if cells > self.width:
                message = f"this row has {cells} cells, the header {self.width}"
                hint = 'put numbers with a decimal comma in quotes ("13,06"), or part the columns with ;'
                self.faults.add(ROW_TOO_LONG, message, hint, self.grid.cell(row, self.width))
            elif noted and cells == self.width and is_number(row.texts[-1]):
                # A decimal comma that parts a number shifts all that follows to the right.
                message = f'the note "{row.texts[-1]}" is a number: is there a decimal comma in this row?'
                hint = 'put such numbers in quotes ("13,06"); words after the number make it a note'
                self.faults.add(NOTE_IS_ONLY_A_NUMBER, message, hint, self.grid.cell(row, cells - 1))

    def _run_rows(self, times: list[_Track]) -> list[bool]:
        """Tell which rows are timed runs, and name the others."""
        every = range(len(self.rows))
        if times:
            is_run = [any(track.readings[i].text for track in times) for i in every]
        else:
            keys = [c[0].at for r in ONE_TURN if (c := self.choice.used.get(r))]
            is_run = [not keys or any(self._text(i, at) not in BLANKS for at in keys) for i in every]
        left_out = [row for row, run in zip(self.rows, is_run, strict=True) if not run]
        if left_out and any(is_run):
            first = left_out[0]
            cell = self.grid.cell(first, next(at for at, text in enumerate(first.texts) if text))
            what = "has no time and is no run" if len(left_out) == 1 else "have no time and are no runs"
            message = f"{span([row.line for row in left_out])} {what}: left out"
            self.faults.add(ROW_WITHOUT_TIME, message, "", cell)
        return is_run

    def _time_tracks(self) -> list[_Track]:
        if "time" in self.replaced:
            return []
        periods = self.there.intersection(ONE_TURN)
        if periods and "time" in self.choice.used and self.there.isdisjoint(COUNTS):
            # A time whose turns nobody tells says nothing; its repeats would count one period several times.
            cell = self.choice.used["time"][0].cell
            message = f'the column "{cell.text}" is not used: its turns are not given; {min(periods)} is read instead'
            self.faults.add(COLUMN_NOT_USED, message, "", cell)
            return []
        tracks = [self._track("time", chosen, True) for chosen in self.choice.used.get("time", [])]
        return [track for track in tracks if track is not None]

    def _track(self, role: str, chosen: Chosen, strict: bool) -> _Track | None:
        """Read one column; None if it is only compared and cannot be read."""
        kind = kind_of_role(role)
        faults = self.faults if strict else Faults(self.faults.name)
        try:
            unit = parse_unit(chosen.header.unit, kind).text if chosen.header.unit else None
        except UnitError as error:
            if strict:
                code = PER_SECOND_IS_AMBIGUOUS if error.reason == "ambiguous" else UNIT_UNKNOWN
                hint = error.hint
                if role == "mass" and "force" in kinds_of(chosen.header.unit or ""):
                    hint = f'a weight in newtons is a force: write the header as "force [{chosen.header.unit}]"'
                faults.add(code, f'{role}, column "{chosen.cell.text}": {error}', hint, chosen.cell)
            else:
                self._note_unused(role, chosen, str(error))
            return None
        if unit is None and kind in ("number", "sign"):
            unit = ""
        at = chosen.at
        texts = [row.texts[at] if at < len(row.texts) else "" for row in self.rows]
        if role == "mass":
            texts = self._with_no_weight(texts)
        if role == "time" and unit == "min":
            texts = self._with_seconds(chosen, texts)
        if kind == "time" and unit == "s":
            texts = self._with_colons(role, chosen, texts, faults)
        # Most texts of a long log stand in several rows; each is read once.
        cells: dict[str, Quantity] = {}
        faulty: dict[str, tuple[str, str, str]] = {}
        bare = False
        for text in dict.fromkeys(texts):
            if text in BLANKS:
                continue
            try:
                meant = said_otherwise(text, role) if role in SPOKEN else ""
                if doubtful := self._is_doubtful(text):
                    read_cell(text.replace(".", ","), kind, unit, ask=True)
                cells[text] = cell = read_cell(meant or text, kind, unit, doubtful)
            except CellError as error:
                if error.code == UNIT_MISSING:
                    bare = True
                else:
                    faulty[text] = error.code, f'{role} "{text[:60]}"{error.joint}{error}', error.hint
                continue
            fault, hint = check_value(role, cell.value)
            if fault:
                faulty[text] = NUMBER_IMPOSSIBLE, f'{role} "{text}" {fault}', hint
        part = part_counted(chosen.header.text) if role in ("turns", "spin_turns") else 1
        # What stands there in turns already, as 1/2 and 3/2, is left as it is.
        if (
            part != 1
            and cells
            and all((cell.value >= 1 or cell.value == 0) and cell.value % 1 == 0 for cell in cells.values())
        ):
            counted = {text: str(int(cell.value) * part) for text, cell in cells.items()}
            cells = {text: read_cell(turns, kind, unit) for text, turns in counted.items()}
            said = "; ".join(f"{text} is {turns}" for text, turns in list(counted.items())[:4])
            faults.add(TURNS_IN_HEADER, f'"{chosen.cell.text}" counts parts of a turn: {said}', "", chosen.cell)
        for i, (row, text) in enumerate(zip(self.rows, texts, strict=True)) if faulty else ():
            if text in faulty and not (role in COUNTS and text in cells and self._stays(i, cells[text].value)):
                faults.add(*faulty[text], self.grid.cell(row, at))
        if dates := [text for text in cells if kind == "number" and fraction_of_date(text)]:
            row = next(row for row, text in zip(self.rows, texts, strict=True) if text == dates[0])
            message = "; ".join(f'{role} "{text}" is {fraction_of_date(text)}' for text in dates[:4])
            self.faults.add(
                DATE_IS_A_FRACTION, f"{message}: a spreadsheet made a date of it", "", self.grid.cell(row, at)
            )
        if bare:
            self._ask_for_unit(role, chosen, faults)
        if not strict and faults.found:
            self._note_unused(role, chosen, faults.found[0].message)
            return None
        spreads = self._spreads(role, chosen, unit, faults if strict else Faults(faults.name))
        spots = [row.spot(at) if row.origin else row.line * MAX_COLUMNS + at for row in self.rows]
        used = next((cell.unit for cell in cells.values()), "")
        if strict and cells and spots[0] % MAX_COLUMNS in self.grid.floats:
            cells, finest = _with_steps_of_floats(cells)
            if KINDS[kind].si and None in spreads:
                self.floats[role] = f"{finest / parse_unit(used, kind).factor:.3g} {used}" if finest else ""
        return _Track(chosen, unit or used, _make_readings(texts, cells, spreads), spots, spreads)

    def _stays(self, row: int, turns: float) -> bool:
        """Tell whether a row says that the rod did not move in a run without a weight."""
        pulls = [self.tracks[role].readings[row].value for role in _PULLS if role in self.tracks]
        stays = turns == 0 and "time" in self.there and 0 in pulls
        self.unmoved |= {row} if stays else set()
        return stays

    def _with_no_weight(self, texts: list[str]) -> list[str]:
        """Read a dash without a position as no weight; in many rows it says "as above"."""
        places = self.choice.used.get("position")
        dashes = [
            i
            for i, text in enumerate(texts)
            if text and text in BLANKS and (places is None or self._text(i, places[0].at) in BLANKS)
        ]
        few = 4 * len(dashes) <= len(texts)
        return ["0" if few and i in dashes else text for i, text in enumerate(texts)] if dashes else texts

    def _with_seconds(self, chosen: Chosen, minutes: list[str]) -> list[str]:
        """Put whole minutes together with the seconds in the column behind them: 1 and 40.65 are 1:40.65."""
        beside = next((one for one in self.choice.others if (one.at, one.role) == (chosen.at + 1, "time")), None)
        if beside is None or beside.header.unit != "s":
            return minutes
        seconds = [self._text(i, beside.at) for i in range(len(self.rows))]
        if not all(
            re.fullmatch(r"[0-9]{0,3} [0-5]?[0-9](?:[.,][0-9]*)?| ", f"{m} {s}")
            for m, s in zip(minutes, seconds, strict=True)
        ):
            return minutes
        self.choice.others.remove(beside)
        return [
            f"{m or 0}:{'0' * (len(re.split('[.,]', s)[0]) < 2)}{s}" if s else ""
            for m, s in zip(minutes, seconds, strict=True)
        ]

    def _with_colons(self, role: str, chosen: Chosen, texts: list[str], faults: Faults) -> list[str]:
        """Read 10:06 as the header or another row says: 10 min 6 s, or 10.06 s; below a header in s alone, ask."""
        clocks = (text for text in texts if ":" in text or not text.isascii())
        parts = {text: match.groups() for text in clocks if (match := _COLONS.fullmatch(fold_number(text)))}
        if not parts:
            return texts
        stated = re.search(r"([a-z]+):[a-z]+(:[a-z]+)?", chosen.header.text.lower())
        if not (stated and stated[2]) and all(h and int(h) and s == "00" for h, _, s in parts.values()):
            # A spreadsheet made hours of 10:06, and wrote it as 10:06:00.
            texts = [text.removesuffix(":00") if text in parts else text for text in texts]
            parts = {text.removesuffix(":00"): ("", h, m) for text, (h, m, _) in parts.items()}
        if stated:
            meant = {}
            if stated[2] and stated[1][0] == "h":
                meant = {t: f"{60 * int(h) + int(m)}:{s}" for t, (h, m, s) in parts.items() if h and int(m) < 60}
            elif stated[2]:
                meant = {t: f"{h}:{m}.{s}" for t, (h, m, s) in parts.items() if h}
            return [meant.get(text, text) for text in texts]
        meant = {text: ".".join(fold_number(text).rsplit(":", 1)) for text in parts}
        pointed = [meant.get(text, text) for text in texts]
        first = next(iter(parts))
        every = (self._text(i, one.at) for one in self.choice.used.get(role, []) for i in range(len(self.rows)))
        proof = next((text for text in every if (cell := _COLONS.fullmatch(text)) and int(cell[3]) >= 60), "")
        if proof:
            message = f'"{proof}" is not minutes and seconds, so in "{chosen.cell.text}" the last colon is a point: '
            message += ", ".join(f"{text} is {meant[text]}" for text in dict.fromkeys((first, proof)) if text in meant)
            faults.add(COLONS_ARE_POINTS, message, "", chosen.cell)
            return pointed
        hours, minutes, seconds = parts[first]
        short = f"{meant[first]} s" if not hours else f"{int(hours)} min {int(minutes)}.{seconds} s"
        long = f"{int(hours)} h {int(minutes)} min" if hours else f"{int(minutes)} min"
        message = f'{role} "{first}" in a column in seconds can be {short} or {long} {int(seconds)} s'
        name, form = split_unit(chosen.header.text)[0], "h:min:s" if hours else "min:s"
        hint = f"if it is {short}, write {meant[first]}, and so in every row; "
        hint += f'if not, write the header as "{name} [{form}]"'
        faults.add(COLON_BELOW_SECONDS, message, hint, self.grid.cell(self.rows[texts.index(first)], chosen.at))
        return pointed

    def _is_doubtful(self, text: str) -> bool:
        """Tell whether a comma or a point may part thousands: the table's other numbers have the other sign."""
        if not _THOUSANDS.fullmatch(text):
            return False
        seen, expected = self._decimal_signs
        return expected != {","} if "," in text else seen == {","}

    @cached_property
    def _decimal_signs(self) -> tuple[set[str], set[str]]:
        """The table's decimal signs as its numbers have them, and as its delimiter lets one expect them."""
        return decimal_signs(self.grid, by_delimiter=False), decimal_signs(self.grid)

    def _ask_for_unit(self, role: str, chosen: Chosen, faults: Faults) -> None:
        kind = kind_of_role(role)
        name = chosen.header.text[:60]
        hint = f'write the header as "{name} [{DISPLAY[kind]}]" (or {KINDS[kind].examples})'
        faults.add(UNIT_MISSING, f'the column "{name}" ({role}) has no unit', hint, chosen.cell.place, len(name))

    def _note_unused(self, role: str, chosen: Chosen, why: str) -> None:
        message = f'the column "{chosen.cell.text}" ({role}) is not compared: {why}'
        self.faults.add(COLUMN_NOT_USED, message, "", chosen.cell)

    def _spreads(self, role: str, chosen: Chosen | None, unit: str | None, faults: Faults) -> list[Uncertainty | None]:
        """Collect what the ``u_…`` column says of each reading, else the ± of the header, else the log's ``u_…``."""
        common = stated_u(role, self.settings.uncertainties)
        if chosen is not None and chosen.header.spread:
            try:
                common = parse_uncertainty(chosen.header.spread, kind_of_role(role), unit or "")
            except UnitError as error:
                message = f'{role}, column "{chosen.cell.text}": {error}'
                faults.add(UNCERTAINTY_CANNOT_BE_READ, message, error.hint, chosen.cell)
        spreads: list[Uncertainty | None] = [common] * len(self.rows)
        key = next((key for key in u_keys(role) if key in self.choice.used), None)
        if key is None:
            return spreads
        column = self.choice.used[key][0]
        fitting = unit if kind_of_role(key) == kind_of_role(role) else None
        if column.header.unit is None and fitting is None and kind_of_role(key) != "number":
            self._ask_for_unit(key, column, faults)
        else:
            self._read_spreads(role, key, spreads, column.header.unit or fitting or "", faults)
        return spreads

    def _read_spreads(self, role: str, key: str, spreads: list[Uncertainty | None], unit: str, faults: Faults) -> None:
        """Read a ``u_…`` column; its blank cells keep what holds for the whole column of readings."""
        kind, column = kind_of_role(key), self.choice.used[key][0]
        try:
            parse_uncertainty("0 %" if unit == "%" else "0", kind, unit)
        except UnitError as error:
            faults.add(UNIT_UNKNOWN, f'{key}, column "{column.cell.text}": {error}', error.hint, column.cell)
            return
        for i, row in enumerate(self.rows):
            text = self._text(i, column.at)
            if text in BLANKS:
                continue
            try:
                if unit == "%" and "%" not in text:
                    spread = parse_uncertainty(text + " %", kind, ask=False)
                else:
                    spread = parse_uncertainty(text, kind, unit, ask=False)
                spreads[i] = as_u_of(role, key, spread)
            except UnitError as error:
                message = f'{key} "{text[:60]}": {error}'
                faults.add(UNCERTAINTY_CANNOT_BE_READ, message, error.hint, self.grid.cell(row, column.at))

    def _fill_down(self, role: str, track: _Track, mass: _Track | None, is_run: list[bool], faults: Faults) -> None:
        """Give blank cells the value above; never across a run without a weight, never upwards."""
        if all(reading.text for reading in track.readings):
            return
        last: int | None = None
        filled: list[int] = []
        early: list[int] = []
        weights = mass.readings if role in LOADS and role != "mass" and mass is not None else None
        for i, reading in enumerate(track.readings):
            if reading.text:
                last = i
            elif weights is not None and weights[i].value == 0:
                last = None
            elif last is None:
                early += [i] if is_run[i] else []
            else:
                # A value above that could not be read has been told of once: the blank cells below it lack nothing.
                track.readings[i], track.spots[i] = track.readings[last], track.spots[last]
                filled += [i] if is_run[i] and track.readings[last].value is not None else []
        first = next((i for i, reading in enumerate(track.readings) if reading.text), -1)
        early = [i for i in early if i < first]
        if filled and (BY_NAME[role].part in ("spin", "count")) and 2 * len(filled) < sum(is_run):
            # Where nearly every run has its own, a blank cell was forgotten.
            for i in filled:
                track.readings[i] = _BLANK
            if BY_NAME[role].part == "spin":
                self._tell_forgotten(role, track, filled, faults)
            filled = []
        if early:
            message = f"{role} is blank in {span([self.rows[i].line for i in early])}, above its first value"
            hint = "write each value in the first row that it belongs to"
            cell = self.grid.cell(self.rows[first], track.chosen.at)
            faults.add(VALUE_BELOW_ITS_FIRST_ROW, message, hint, cell)
        if filled:
            self._tell_filled(role, track.chosen.at, filled, faults)

    def _tell_forgotten(self, role: str, track: _Track, blank: list[int], faults: Faults) -> None:
        row = self.rows[blank[0]]
        message = f"{role} is blank in {span([self.rows[i].line for i in blank])}, where nearly every run has its own"
        hint = "write what was read there, once more if it is the one above; or put # before the line of the run"
        faults.add(BLANK_SPIN, message, hint, Place(row.line, 1))
        for i in blank:
            track.readings[i] = Reading(text=TOLD_BLANK)  # what has been told of lacks nothing

    def _tell_filled(self, role: str, at: int, filled: list[int], faults: Faults) -> None:
        lines = [self.rows[i].line for i in filled]
        row = self.rows[filled[0]]
        place = self.grid.cell(row, at).place if at < len(row.texts) else Place(row.line, 1)
        faults.add(BLANK_TAKES_VALUE_ABOVE, f"{role} is blank in {span(lines)}: the value above was taken", "", place)

    def _column(self, role: str, track: _Track, rows: list[int]) -> Column:
        """Put a track's rows in the order of the runs, with the value of the whole log in blank cells."""
        readings = [track.readings[i] for i in rows]
        spots = [track.spots[i] for i in rows]
        given = self.settings.roles.get(role)
        if given is not None:
            for k, reading in enumerate(readings):
                if not reading.text:
                    readings[k], spots[k] = given.reading(track.spreads[rows[k]]), _CONSTANT
        place = None if given is None else given.place
        header = track.chosen.header.text
        return Column(role, header, track.unit, tuple(readings), tuple(spots), place, self.find)

    def _time_column(self, times: list[_Track], plan: list[tuple[int, int]]) -> Column:
        """Make one column of all stopwatch readings; each is a reading of its own."""
        parts = [self._column("time", track, list(range(len(self.rows)))) for track in times]
        steps = {reading.step for part in parts for reading in part.readings if reading.step}
        finest = min(steps, default=None)
        readings = [parts[k].readings[i] for i, k in plan]
        if len(steps) > 1:
            readings = [replace(reading, step=finest) if reading.step else reading for reading in readings]
        return replace(parts[0], readings=tuple(readings), spots=tuple(parts[k].spots[i] for i, k in plan))

    def _other(self, chosen: Chosen, rows: list[int]) -> Column | None:
        cell, role = chosen.cell, chosen.role
        if role in TEXTS or role[:2] == "u_":
            used = self.choice.used[role][0].header.text
            message = f'the column "{cell.text}" is not used: {role} is read from "{used}"'
            self.faults.add(COLUMN_NOT_USED, message, "", cell)
            return None
        track = self._track(role, chosen, False)
        if track is None:
            return None
        if role != "inertia":
            used = self.choice.used[role][0].header.text
            message = f'the column "{cell.text}" is only compared: {role} is read from "{used}"'
            self.faults.add(COLUMN_NOT_USED, message, "", cell)
        return self._column(role, track, rows)

    def _labels(self, rows: list[int]) -> tuple[str, ...]:
        """Label the runs: the log's own labels or their order, with .1, .2 for repeats of one row."""
        repeats = Counter(rows)
        column = self.choice.used.get("run")
        labels: dict[str, None] = {}
        for number, (i, times) in enumerate(repeats.items(), 1):
            name = (self._text(i, column[0].at) if column else "") or str(number)
            for label in [name] if times == 1 else [f"{name}.{k}" for k in range(1, times + 1)]:
                while label in labels:
                    label += f" (line {self.rows[i].line})"
                labels[label] = None
        return tuple(labels)


def _from_centre(position: float, origin: str, shift: float) -> float:
    """Give the distance from the centre of the ball [m]; a negative one is on the counterweight's side."""
    if origin == "tip":
        return shift - position
    return position + math.copysign(shift, position)


def _with_steps_of_floats(cells: dict[str, Quantity]) -> tuple[dict[str, Quantity], float]:
    """Take the finest digit of a column of floats as the last one that was read; none (0) if it cannot have been.

    A float drops zeros at its end: 15.0 cm may be 15 or 15.00 cm, and nobody reads 0.15 m to 0.01 m.
    """
    finest = min((cell.step for cell in cells.values() if cell.step is not None), default=0.0)
    whole = all(re.fullmatch(r"-?[0-9]+(?:\.0)?(?: .*)?", text) for text in cells)
    if whole or finest > 0.02 * max(abs(cell.value) for cell in cells.values()):
        return {text: replace(cell, step=None) for text, cell in cells.items()}, 0.0
    return cells, finest


def _make_readings(texts: list[str], cells: dict[str, Quantity], spreads: list[Uncertainty | None]) -> list[Reading]:
    """Make one reading for each row; equal ones are one object."""
    # A spreadsheet drops zeros at the end: the finest digit anywhere tells how all were read.
    finest: dict[str, float] = {}
    for cell in cells.values():
        if cell.step is not None:
            finest[cell.unit] = min(cell.step, finest.get(cell.unit, math.inf))
    made: dict[tuple[str, int], Reading] = {}
    readings = []
    for text, spread in zip(texts, spreads, strict=True):
        # Rows without a u of their own share one.
        key = text, id(spread)
        if key not in made:
            read = cells.get(text)
            if read is None:
                made[key] = _BLANK if text in BLANKS else Reading(text=text)
            else:
                step = None if read.step is None else finest[read.unit]
                made[key] = Reading(read.value, step, read.uncertainty or spread, text)
        readings.append(made[key])
    return readings
