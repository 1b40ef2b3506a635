"""From cells to columns of readings: units, fill-down, uncertainties, one row for each run."""

from __future__ import annotations

import math
import re
from collections import Counter
from functools import partial

from msgspec import Struct
from msgspec.structs import replace

from gyrodata import diagnostics as codes
from gyrodata.quantities import NUMBER, Quantity, fold_number, parse_uncertainty, to_float
from gyrodata.readings import cells, roles
from gyrodata.readings.cells import BLANKS, CellError, read_cell
from gyrodata.readings.columns import Choice, Chosen
from gyrodata.readings.headers import origin_in, part_counted, split_unit
from gyrodata.readings.lablog import TOLD_BLANK, Column, Faults, Place, Reading, Readings, span
from gyrodata.readings.layout import Layout, is_number
from gyrodata.readings.roles import TEXTS, kind_of_role, stated_u, u_keys
from gyrodata.readings.settings import Given, Settings
from gyrodata.readings.source import MAX_COLUMNS, Row, decimal_signs, find_place
from gyrodata.units import DISPLAY, KINDS, Uncertainty, UnitError, kinds_of, parse_unit

_BLANK = Reading()
_THOUSANDS = re.compile(r"[-+]?[1-9][0-9]{0,2}[.,][0-9]{3}")
_COLONS = re.compile(r"(?:([0-9]{1,2}):)?([0-9]{1,3}):([0-9]{2})")
"""A time without a point: minutes and seconds, or what a stopwatch shows of seconds and hundredths."""
_Clocks = dict[str, tuple[str, ...]]
"""Hours, minutes and seconds of each text, as written."""
_SMALL_DOUBT = 0.002
"""Doubt about rounded turns, as a share of them, that no run notices."""
_ORIGINS = {
    "surface": ("ball_diameter", 0.5, "10.16 cm", "the diameter of your ball"),
    "tip": ("rod_length", 1.0, "25.0 cm", "the length from the centre of the ball to the tip of the rod"),
}
"""What tells how far from the centre of the ball positions begin: key, share of it, sample, words."""
_ONE = ("1", "1/2", "1/3", "1/4", "2/3", "3/4")
_COUNTED = {"time": "turns", "spin_time": "spin_turns"}
_PULLS = ("mass", "force", "torque")
_LONGEST_LEGEND = 30
"""Names of weights or places that are looked up in the lines of a log."""
_CONSTANT = -1
"""Spot of the value that holds for the whole log."""


class _Track(Struct, frozen=True):
    """One role's readings by row of the file, before rows become runs."""

    chosen: Chosen
    unit: str
    readings: list[Reading]
    """Without a text where the cell is blank."""
    spots: list[int]
    spreads: list[Uncertainty | None]
    """What holds for a value of the whole log that stands in a blank cell."""


class Builder:
    """Reads every cell of the columns chosen."""

    def __init__(self, layout: Layout, choice: Choice, settings: Settings, faults: Faults) -> None:
        self.layout, self.choice, self.settings, self.faults = layout, choice, settings, faults
        self.grid, self.rows, self.width = layout.grid, layout.rows, len(layout.cells)
        self.signs, self.expected_signs = decimal_signs(self.grid, by_delimiter=False), decimal_signs(self.grid)
        self.find = partial(find_place, self.grid.lines, self.grid.delimiter)
        self.replaced: set[str] = set()
        self.floats: dict[str, str] = {}
        """Last digit of each role without a stated uncertainty that a DataFrame has as floats; "" if it is unknown."""
        self.tracks: dict[str, _Track] = {}
        self.unmoved: set[int] = set()
        for given in (*settings.roles.values(), *settings.given_uncertainties.values()):
            if given.place is None and given.key in choice.used:
                self.replaced.add(given.key)
                message = f'{given.label} takes the place of the column "{choice.used[given.key][0].header.text}"'
                faults.add(codes.OPTION_REPLACES_COLUMN, message)
        stating = [(counts, one) for role, counts in _COUNTED.items() for one in choice.used.get(role, [])]
        self.stating = [(counts, one) for counts, one in stating if one.turns and one.role not in self.replaced]
        """The times whose header states their turns, with the role of these turns."""
        self.there = (set(choice.used) | set(settings.roles)) - TEXTS | {counts for counts, _ in self.stating}
        self.derived = roles.derived_roles(self.there)

    def build(self, log: Readings) -> tuple[Readings, set[int]]:
        """Put the readings into a log; name the runs in which the rod did not move."""
        self._check_widths()
        times = self._time_tracks()
        is_run = self._run_rows(times)
        self._read_tracks(is_run)
        plan = [(i, time) for i in range(len(self.rows)) for time in times if time.readings[i].text]
        rows = [i for i, _ in plan] if times else [i for i, run in enumerate(is_run) if run]
        columns = {"time": self._time_column(times, plan)} if times else {}
        for role, track in self.tracks.items():
            column = self._column(track, rows)
            if any(reading.value is not None for reading in column.readings):
                columns[role] = column
                self._note_overruled(column)
        for role, given in self.settings.roles.items():
            if role not in columns and rows:
                columns[role] = self._constant_column(given, rows)
        if rows and self.stating:
            self._add_stated_turns(columns, [time.chosen for _, time in plan], len(rows))
        self._warn_of_rounded_turns(columns.get("turns"))
        origin_u = self._count_from_centre(columns)
        self._note_unheard(columns)
        self._note_floats()
        others = [self._other(chosen, rows) for chosen in self.choice.others]
        notes = self.choice.used.get("note")
        log = replace(
            log,
            runs=self._labels(rows),
            lines=tuple(self.rows[i].line for i in rows),
            notes=tuple(self._text(i, notes[0].at) if notes else "" for i in rows),
            columns=columns,
            others=tuple(other for other in others if other is not None),
            position_from=self.settings.position_from,
            origin_u=origin_u,
            unread=self._unread(columns, rows),
        )
        return log, {run for run, i in enumerate(rows) if i in self.unmoved}

    def _read_tracks(self, is_run: list[bool]) -> None:
        """Read all columns of numbers but the times."""
        # What it weighs says where to fill, and whether the rod may stay.
        load = next((role for role in _PULLS if role in self.choice.used), "")
        for role in sorted(self.choice.used, key=lambda r: r != load):
            if role == "time" or role in TEXTS or role[:2] == "u_" or role in self.replaced:
                continue
            strict = role not in self.derived
            if (track := self._track(self.choice.used[role][0], strict)) is None:
                continue
            # A constant of the log would stand in the blank cells.
            if role in roles.FILLED_DOWN and role not in self.settings.roles:
                self._fill_down(track, is_run, self.faults if strict else Faults(self.faults.name))
            self.tracks[role] = track

    def _unread(self, columns: dict[str, Column], rows: list[int]) -> tuple[tuple[str, tuple[str, ...]], ...]:
        """Collect the columns of which no reading is in the table, and no text."""
        there = {*columns, *TEXTS}
        used = {one.at for role, many in self.choice.used.items() if role in there or role[:2] == "u_" for one in many}
        used |= {one.at for one in self.choice.others} | self.layout.combined
        heads = [(at, cell.text or f"column {at + 1}") for at, cell in enumerate(self.layout.cells) if at not in used]
        unread = [(head, tuple(self._text(i, at) for i in rows)) for at, head in heads]
        return tuple((head, texts) for head, texts in unread if any(texts))

    def _note_overruled(self, column: Column) -> None:
        """Name a line of the log whose value no run has, for each has its own in a column."""
        given = self.settings.roles.get(column.role)
        if given is None or given.place is None or given.cell is None or _CONSTANT in column.spots:
            return
        if any(value != given.cell.value for value in column.values):
            message = f'"{given.label}: {given.text}" is not used: each run has its own in the column "{column.header}"'
            self.faults.add(codes.COLUMN_NOT_USED, message, "take the line or the column away", given.place)

    def _constant_column(self, given: Given, rows: list[int]) -> Column:
        unit = given.cell.unit if given.cell else ""
        spreads = self._spreads(given.key, None, unit or None, self.faults)
        readings = tuple(given.reading(spreads[i]) for i in rows)
        return Column(given.key, given.label, unit, readings, (_CONSTANT,) * len(rows), given.place)

    def _add_stated_turns(self, columns: dict[str, Column], timed: list[Chosen], count: int) -> None:
        """Give each time the turns that its header states, where no column and no option gives them."""
        told = [
            f'"{one.cell.text}" covers {one.turns} turn{"s" * (one.turns not in _ONE)}'
            for counts, one in self.stating
            if counts not in columns and not (counts == "turns" and "angle" in columns)
        ]
        if given := columns.get("turns") or columns.get("angle"):
            self._compare_stated(given, timed)
        elif any(one.turns for one in timed):
            columns["turns"] = self._stated_column("turns", timed)
        spun = next((one for counts, one in self.stating if counts == "spin_turns"), None)
        if spun is not None and "spin_turns" not in columns:
            columns["spin_turns"] = self._stated_column("spin_turns", [spun] * count)
        if told:
            self.faults.add(codes.TURNS_IN_HEADER, "; ".join(told), "", self.stating[0][1].cell)

    def _stated_column(self, role: str, chosen: list[Chosen]) -> Column:
        spread, head = stated_u(role, self.settings.uncertainties), Row(self.layout.cells[0].line, [])
        told = {one.turns: read_cell(one.turns, "number", "").value for one in chosen if one.turns}
        readings = [Reading(told[one.turns], None, spread, one.turns) if one.turns else _BLANK for one in chosen]
        header = next(one.cell.text for one in chosen if one.turns)
        return Column(role, header, "", tuple(readings), tuple(head.spot(one.at) for one in chosen), None, self.find)

    def _compare_stated(self, given: Column, timed: list[Chosen]) -> None:
        """Ask, where a header states other turns than stand in their column."""
        full = 1.0 if given.role == "turns" else 2 * math.pi
        for run, one in enumerate(timed):
            value = given.values[run]
            if not one.turns or value is None or given.header.startswith("--"):
                continue
            stated = read_cell(one.turns, "number", "").value
            if abs(value / full - stated) > 0.02 * stated:
                message = f'"{one.cell.text}" covers {one.turns} turns, and "{given.header}" says '
                hint = f"correct one of the two, or say which holds with --set turns={one.turns}"
                place = given.place(run)
                self.faults.add(codes.TURNS_CONTRADICT_ANGLE, message + given.readings[run].text, hint, place)
                return

    def _warn_of_rounded_turns(self, turns: Column | None) -> None:
        """Warn of 0.33, which is no third."""
        texts = [reading.text if reading.u is None else "" for reading in turns.readings] if turns else []
        for text in dict.fromkeys(texts):
            meant, doubt = cells.rounded_turns(text)
            if turns and meant and doubt > _SMALL_DOUBT * to_float(text):
                message = f'turns "{text}" is taken as {text} ± {doubt:.1g}: is it {meant}, rounded?'
                hint, place = f"write {meant} where {meant} is meant", turns.place(texts.index(text))
                self.faults.add(codes.TURNS_ROUNDED, message, hint, place, len(text))

    def _count_from_centre(self, columns: dict[str, Column]) -> float:
        """Make positions count from the centre of the ball, where the log says that they count from elsewhere.

        Gives the standard uncertainty of the distance between the two [m].
        """
        position, stated = columns.get("position"), self.settings.position_from
        if position is None:
            return 0.0
        in_header = "" if position.header.startswith(("#", "--")) else origin_in(position.header)
        origin = stated or in_header
        if origin in ("", "centre"):
            return 0.0
        self.settings.position_from = origin
        key, share, sample, what = _ORIGINS[origin]
        length = self.settings.constants.get(key)
        if length is None:
            who = f'"{position.header}" counts' if in_header else "the positions count"
            message = f"{who} from the {origin}, and the torque needs the distance from the centre of the ball"
            hint = f'write "# {key}: {sample}" above the header, or --set {key}="{sample}", with {what}'
            hint += "" if stated else '; if it counts from the centre: "# position_from: centre"'
            self.faults.add(codes.POSITION_ORIGIN_UNKNOWN, message, hint, position.place(0))
            return 0.0
        shift = share * length
        moved = []
        for reading in position.readings:
            value = reading.value
            if value is not None:
                # A negative distance is on the counterweight's side.
                value = shift - value if origin == "tip" else value + math.copysign(shift, value)
            moved.append(replace(reading, value=value))
        columns["position"] = replace(position, readings=tuple(moved))
        done = f"{100 * shift:.4g} cm is added to" if origin == "surface" else f"{100 * shift:.4g} cm less"
        message = f"positions count from the {origin}: {done} each, so that all count from the centre of the ball"
        self.faults.add(codes.POSITION_MOVED, message, "", position.place(0))
        u = self.settings.uncertainties.get(f"u_{key}")
        return share * (self.settings.steps[key] / math.sqrt(12) if u is None else u.at(length))

    def _note_unheard(self, columns: dict[str, Column]) -> None:
        """Name every ``u_…`` column that no readings take their uncertainty from."""
        heard = {key for role in columns for key in u_keys(role)} | self.replaced
        for key, chosen in self.choice.used.items():
            if key[:2] == "u_" and key not in heard and not self.faults.has_error():
                base = key.removeprefix("u_")
                self._note(chosen[0], f"({key}) is not used: there is no {base} that it could belong to")

    def _note_floats(self) -> None:
        """Say which digits are taken as read, where a DataFrame does not contain them."""
        unknown = [role for role, step in self.floats.items() if not step]
        told = [f"{role} is taken as read to {step}" for role, step in self.floats.items() if step]
        told += [f"no rounding error is included for {', '.join(unknown)}"] if unknown else []
        if told:
            message = f"floats do not contain the digits that were read: {'; '.join(told)}"
            self.faults.add(codes.FLOATS_WITHOUT_DIGITS, message, "to keep the digits: pandas.read_csv(…, dtype=str)")

    def _text(self, row: int, at: int) -> str:
        texts = self.rows[row].texts
        return texts[at] if at < len(texts) else ""

    def _texts(self, at: int) -> list[str]:
        return [self._text(i, at) for i in range(len(self.rows))]

    def _check_widths(self) -> None:
        notes = self.choice.used.get("note")
        noted = notes is not None and notes[0].at == self.width - 1
        for row in self.rows:
            count = len(row.texts)
            if count > self.width:
                message = f"this row has {count} cells, the header {self.width}"
                hint = 'put numbers with a decimal comma in quotes ("13,06"), or part the columns with ;'
                self.faults.add(codes.ROW_TOO_LONG, message, hint, self.grid.cell(row, self.width))
            elif noted and count == self.width and is_number(row.texts[-1]):
                # A decimal comma that parts a number shifts all that follows to the right.
                message = f'the note "{row.texts[-1]}" is a number: is there a decimal comma in this row?'
                hint = 'put such numbers in quotes ("13,06"); words after the number make it a note'
                self.faults.add(codes.NOTE_IS_ONLY_A_NUMBER, message, hint, self.grid.cell(row, count - 1))

    def _run_rows(self, times: list[_Track]) -> list[bool]:
        """Tell which rows are timed runs, and name the others."""
        timed = [time.chosen for time in times]
        timed = timed or [self.choice.used[role][0] for role in roles.ONE_TURN if role in self.choice.used]
        cells_of_times = [self._texts(one.at) for one in timed] or [["some"] * len(self.rows)]
        is_run = [not BLANKS.issuperset(texts) for texts in zip(*cells_of_times, strict=True)]
        left_out = [row for row, run in zip(self.rows, is_run, strict=True) if not run]
        if left_out and any(is_run):
            first = left_out[0]
            cell = self.grid.cell(first, next(at for at, text in enumerate(first.texts) if text))
            what = "has no time and is no run" if len(left_out) == 1 else "have no time and are no runs"
            self.faults.add(
                codes.ROW_WITHOUT_TIME, f"{span([row.line for row in left_out])} {what}: left out", "", cell
            )
        return is_run

    def _time_tracks(self) -> list[_Track]:
        times = [] if "time" in self.replaced else self.choice.used.get("time", [])
        periods = self.there.intersection(roles.ONE_TURN)
        if times and periods and self.there.isdisjoint(roles.COUNTS):
            # A time whose turns nobody tells says nothing; its repeats would count one period several times.
            self._note(times[0], f"is not used: its turns are not given; {min(periods)} is read instead")
            return []
        return [track for chosen in times if (track := self._track(chosen, True)) is not None]

    def _note(self, chosen: Chosen, what: str) -> None:
        self.faults.add(codes.COLUMN_NOT_USED, f'the column "{chosen.cell.text}" {what}', "", chosen.cell)

    def _track(self, chosen: Chosen, strict: bool) -> _Track | None:
        """Read one column; None if it is only compared and cannot be read."""
        role, at, kind = chosen.role, chosen.at, kind_of_role(chosen.role)
        faults = self.faults if strict else Faults(self.faults.name)
        try:
            unit = parse_unit(chosen.header.unit, kind).text if chosen.header.unit else None
        except UnitError as error:
            if strict:
                code = codes.PER_SECOND_IS_AMBIGUOUS if error.reason == "ambiguous" else codes.UNIT_UNKNOWN
                self._refuse(code, chosen, error, faults)
            else:
                self._note(chosen, f"({role}) is not compared: {error}")
            return None
        if unit is None and kind in ("number", "sign"):
            unit = ""
        texts = self._with_no_weight(self._texts(at)) if role == "mass" else self._texts(at)
        if role in roles.LOADS:
            texts = self._with_legend(chosen, texts, faults)
        if kind == "time" and unit == "s":
            texts = self._with_colons(chosen, texts, faults)
        read = self._read_texts(chosen, texts, unit, faults)
        if not strict and faults.found:
            self._note(chosen, f"({role}) is not compared: {faults.found[0].message}")
            return None
        spreads = self._spreads(role, chosen, unit, faults if strict else Faults(faults.name))
        spots = [row.spot(at) for row in self.rows]
        used = next((value.unit for value in read.values()), "")
        if strict and read and spots[0] % MAX_COLUMNS in self.grid.floats:
            read, finest = _with_steps_of_floats(read)
            if KINDS[kind].si and None in spreads:
                self.floats[role] = f"{finest / parse_unit(used, kind).factor:.3g} {used}" if finest else ""
        return _Track(chosen, unit or used, _make_readings(texts, read, spreads), spots, spreads)

    def _refuse(self, code: str, chosen: Chosen, error: UnitError, faults: Faults) -> None:
        hint, unit = error.hint, chosen.header.unit or ""
        if chosen.role == "mass" and "force" in kinds_of(unit):
            hint = f'a weight in newtons is a force: write the header as "force [{unit}]"'
        faults.add(code, f'{chosen.role}, column "{chosen.cell.text}": {error}', hint, chosen.cell)

    def _read_texts(self, chosen: Chosen, texts: list[str], unit: str | None, faults: Faults) -> dict[str, Quantity]:
        """Read each text of a column once, and tell in which cells it is wrong."""
        role, kind, at = chosen.role, kind_of_role(chosen.role), chosen.at
        read: dict[str, Quantity] = {}
        faulty: dict[str, tuple[str, str, str]] = {}
        bare = False
        for text in dict.fromkeys(texts):
            if text in BLANKS:
                continue
            try:
                meant = cells.said_otherwise(text, role) if role in cells.SPOKEN else ""
                if doubtful := self._is_doubtful(text):
                    read_cell(text.replace(".", ","), kind, unit, ask=True)
                read[text] = read_cell(meant or text, kind, unit, doubtful)
            except CellError as error:
                bare = bare or error.code == codes.UNIT_MISSING
                if error.code != codes.UNIT_MISSING:
                    faulty[text] = error.code, f'{role} "{text[:60]}"{error.joint}{error}', error.hint
                continue
            fault, hint = cells.check_value(role, read[text].value)
            if fault:
                faulty[text] = codes.NUMBER_IMPOSSIBLE, f'{role} "{text}" {fault}', hint
        if role in _COUNTED.values():
            read |= self._in_turns(chosen, read, faults)
        for i, (row, text) in enumerate(zip(self.rows, texts, strict=True)):
            if text in faulty and not (role in roles.COUNTS and text in read and self._stays(i, read[text].value)):
                faults.add(*faulty[text], self.grid.cell(row, at))
        if dates := [text for text in read if kind == "number" and cells.fraction_of_date(text)]:
            message = "; ".join(f'{role} "{text}" is {cells.fraction_of_date(text)}' for text in dates[:4])
            cell = self.grid.cell(self.rows[texts.index(dates[0])], at)
            self.faults.add(codes.DATE_IS_A_FRACTION, f"{message}: a spreadsheet made a date of it", "", cell)
        if bare:
            self._ask_for_unit(chosen, faults)
        return read

    def _in_turns(self, chosen: Chosen, read: dict[str, Quantity], faults: Faults) -> dict[str, Quantity]:
        """Give the turns of numbers that count parts of a turn, as the header says."""
        part = part_counted(chosen.header.text)
        # What stands there in turns already, as 1/2 and 3/2, is left as it is.
        if part == 1 or not read or any(one.value < 0 or one.value % 1 for one in read.values()):
            return {}
        counted = {text: str(int(one.value) * part) for text, one in read.items()}
        said = "; ".join(f"{text} is {turns}" for text, turns in list(counted.items())[:4])
        faults.add(codes.TURNS_IN_HEADER, f'"{chosen.cell.text}" counts parts of a turn: {said}', "", chosen.cell)
        return {text: read_cell(turns, "number", "") for text, turns in counted.items()}

    def _stays(self, row: int, turns: float) -> bool:
        """Tell whether a row says that the rod did not move in a run without a weight."""
        pulls = [self.tracks[role].readings[row].value for role in _PULLS if role in self.tracks]
        stays = turns == 0 and "time" in self.there and 0 in pulls
        self.unmoved |= {row} if stays else set()
        return stays

    def _with_no_weight(self, texts: list[str]) -> list[str]:
        """Read a dash without a position as no weight; in many rows it says "as above"."""
        places = self.choice.used.get("position")
        positions = self._texts(places[0].at) if places else [""] * len(texts)
        dashed = [t != "" and t in BLANKS and at in BLANKS for t, at in zip(texts, positions, strict=True)]
        few = 4 * sum(dashed) <= len(texts)
        return ["0" if few and dash else text for text, dash in zip(texts, dashed, strict=True)]

    def _with_legend(self, chosen: Chosen, texts: list[str], faults: Faults) -> list[str]:
        """Put in the place of "A" the quantity that a line gives it: "A = 20.1 g", and no "+ 5 g" after it."""
        meant = {}
        names = dict.fromkeys(text for text in texts if text[:1].isalpha() and len(text) <= 20)
        for name in list(names)[:_LONGEST_LEGEND]:
            stated = re.compile(rf"(?<![\w.]){re.escape(name)}\s*[=:]\s*({NUMBER}\s*[^\W\d_]+)\s*(?=[,;)]|$)")
            found = {match[1] for line in self.grid.lines for match in stated.finditer(line)}
            if len(found) == 1:
                meant[name] = found.pop()
        if meant:
            said = ", ".join(f"{name} is {text}" for name, text in meant.items())
            faults.add(codes.CAPTION_READ, f'in the column "{chosen.cell.text}", {said}', "", chosen.cell)
        return [meant.get(text, text) for text in texts]

    def _with_colons(self, chosen: Chosen, texts: list[str], faults: Faults) -> list[str]:
        """Read 10:06 as the header or another row says: 10 min 6 s, or 10.06 s; below a header in s alone, ask."""
        parts = {text: match.groups() for text in texts if (match := _COLONS.fullmatch(fold_number(text)))}
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
        return self._as_points(chosen, texts, parts, faults)

    def _as_points(self, chosen: Chosen, texts: list[str], parts: _Clocks, faults: Faults) -> list[str]:
        """Read the last colon as a point; ask whether it is one, unless another row proves it."""
        meant = {text: ".".join(fold_number(text).rsplit(":", 1)) for text in parts}
        pointed = [meant.get(text, text) for text in texts]
        first = next(iter(parts))
        every = (text for one in self.choice.used.get(chosen.role, []) for text in self._texts(one.at))
        proof = next((text for text in every if (match := _COLONS.fullmatch(text)) and int(match[3]) >= 60), "")
        if proof:
            message = f'"{proof}" is not minutes and seconds, so in "{chosen.cell.text}" the last colon is a point: '
            message += ", ".join(f"{text} is {meant[text]}" for text in dict.fromkeys((first, proof)) if text in meant)
            faults.add(codes.COLONS_ARE_POINTS, message, "", chosen.cell)
            return pointed
        hours, minutes, seconds = parts[first]
        short = f"{meant[first]} s" if not hours else f"{int(hours)} min {int(minutes)}.{seconds} s"
        long = f"{int(hours)} h {int(minutes)} min" if hours else f"{int(minutes)} min"
        message = f'{chosen.role} "{first}" in a column in seconds can be {short} or {long} {int(seconds)} s'
        name, form = split_unit(chosen.header.text)[0], "h:min:s" if hours else "min:s"
        hint = f"if it is {short}, write {meant[first]}, and so in every row; "
        hint += f'if not, write the header as "{name} [{form}]"'
        cell = self.grid.cell(self.rows[texts.index(first)], chosen.at)
        faults.add(codes.COLON_BELOW_SECONDS, message, hint, cell)
        return pointed

    def _is_doubtful(self, text: str) -> bool:
        """Tell whether a comma or a point may part thousands: the table's other numbers have the other sign."""
        if not _THOUSANDS.fullmatch(text):
            return False
        return self.expected_signs != {","} if "," in text else self.signs == {","}

    def _ask_for_unit(self, chosen: Chosen, faults: Faults) -> None:
        kind, name = kind_of_role(chosen.role), chosen.header.text[:60]
        hint = f'write the header as "{name} [{DISPLAY[kind]}]" (or {KINDS[kind].examples})'
        message = f'the column "{name}" ({chosen.role}) has no unit'
        faults.add(codes.UNIT_MISSING, message, hint, chosen.cell.place, len(name))

    def _spreads(self, role: str, chosen: Chosen | None, unit: str | None, faults: Faults) -> list[Uncertainty | None]:
        """Collect what the ``u_…`` column says of each reading, else the ± of the header, else the log's ``u_…``."""
        common = stated_u(role, self.settings.uncertainties)
        if chosen is not None and chosen.header.spread:
            try:
                common = parse_uncertainty(chosen.header.spread, kind_of_role(role), unit or "")
            except UnitError as error:
                self._refuse(codes.UNCERTAINTY_CANNOT_BE_READ, chosen, error, faults)
        spreads = [common] * len(self.rows)
        key = next((key for key in u_keys(role) if key in self.choice.used and key not in self.replaced), None)
        if key is None:
            return spreads
        column, kind = self.choice.used[key][0], kind_of_role(key)
        fitting = unit if kind == kind_of_role(role) else None
        if column.header.unit is None and fitting is None and kind != "number":
            self._ask_for_unit(column, faults)
            return spreads
        unit = column.header.unit or fitting or ""
        percent, unit = (" %", "") if unit == "%" else ("", unit)
        try:
            parse_uncertainty(f"0{percent}", kind, unit)
        except UnitError as error:
            self._refuse(codes.UNIT_UNKNOWN, column, error, faults)
            return spreads
        for i, text in enumerate(self._texts(column.at)):
            try:
                if text not in BLANKS:
                    spread = parse_uncertainty(text if "%" in text else text + percent, kind, unit, ask=False)
                    spreads[i] = roles.as_u_of(role, key, spread)
            except UnitError as error:
                cell = self.grid.cell(self.rows[i], column.at)
                faults.add(codes.UNCERTAINTY_CANNOT_BE_READ, f'{key} "{text[:60]}": {error}', error.hint, cell)
        return spreads

    def _fill_down(self, track: _Track, is_run: list[bool], faults: Faults) -> None:
        """Give blank cells the value above; never across a run without a weight, never upwards."""
        role, readings, mass = track.chosen.role, track.readings, self.tracks.get("mass")
        blank = {i for i, reading in enumerate(readings) if not reading.text}
        weights = mass.readings if mass is not None and role in roles.LOADS and role != "mass" else []
        without = {i for i in blank if weights and weights[i].value == 0}
        first = next((i for i in range(len(readings)) if i not in blank), 0)
        above: dict[int, int] = {}
        last: int | None = None
        for i in range(first, len(readings)):
            if i not in blank:
                last = i
            elif i in without:
                last = None
            elif last is not None:
                above[i] = last
        # A value above that could not be read has been told of once: the blank cells below it lack nothing.
        filled = [i for i in above if is_run[i] and readings[above[i]].value is not None]
        part = roles.BY_NAME[role].part
        if part in ("spin", "count") and 2 * len(filled) < sum(is_run):
            # Where nearly every run has its own, a blank cell was forgotten.
            if filled and part == "spin":
                self._tell_blank(track, filled, faults)
            above = {i: j for i, j in above.items() if i not in filled}
            filled = []
        if early := [i for i in range(first) if is_run[i] and i not in without]:
            message = f"{role} is blank in {self._span(early)}, above its first value"
            cell = self.grid.cell(self.rows[first], track.chosen.at)
            hint = "write each value in the first row that it belongs to"
            faults.add(codes.VALUE_BELOW_ITS_FIRST_ROW, message, hint, cell)
        for i, j in above.items():
            readings[i], track.spots[i] = readings[j], track.spots[j]
        if filled:
            row, at = self.rows[filled[0]], track.chosen.at
            place = self.grid.cell(row, at).place if at < len(row.texts) else Place(row.line, 1)
            message = f"{role} is blank in {self._span(filled)}: the value above was taken"
            faults.add(codes.BLANK_TAKES_VALUE_ABOVE, message, "", place)

    def _tell_blank(self, track: _Track, blank: list[int], faults: Faults) -> None:
        message = f"{track.chosen.role} is blank in {self._span(blank)}, where nearly every run has its own"
        hint = "write what was read there, once more if it is the one above; or put # before the line of the run"
        faults.add(codes.BLANK_SPIN, message, hint, Place(self.rows[blank[0]].line, 1))
        for i in blank:
            track.readings[i] = Reading(text=TOLD_BLANK)  # what has been told of lacks nothing

    def _span(self, rows: list[int]) -> str:
        return span([self.rows[i].line for i in rows])

    def _column(self, track: _Track, rows: list[int]) -> Column:
        """Put a track's rows in the order of the runs, with the value of the whole log in blank cells."""
        readings, spots = [track.readings[i] for i in rows], [track.spots[i] for i in rows]
        given = self.settings.roles.get(track.chosen.role)
        for k, i in enumerate(rows if given else ()):
            if given and not readings[k].text:
                readings[k], spots[k] = given.reading(track.spreads[i]), _CONSTANT
        header, place = track.chosen.header.text, given.place if given else None
        return Column(track.chosen.role, header, track.unit, tuple(readings), tuple(spots), place, self.find)

    def _time_column(self, times: list[_Track], plan: list[tuple[int, _Track]]) -> Column:
        """Make one column of all stopwatch readings; each is a reading of its own."""
        readings = [time.readings[i] for i, time in plan]
        finest = min((reading.step for reading in readings if reading.step), default=None)
        readings = [replace(reading, step=finest) if reading.step else reading for reading in readings]
        spots = tuple(time.spots[i] for i, time in plan)
        return replace(self._column(times[0], []), readings=tuple(readings), spots=spots)

    def _other(self, chosen: Chosen, rows: list[int]) -> Column | None:
        role = chosen.role
        used = self.choice.used[role][0].header if role in self.choice.used else None
        if used and (role in TEXTS or role[:2] == "u_"):
            self._note(chosen, f'is not used: {role} is read from "{used.text}"')
            return None
        if used and role == "time" and (used.unit, chosen.header.unit) == ("min", "s"):
            message = f'the minutes are in "{used.text}", and the seconds in another column'
            hint = 'write minutes and seconds in one column, such as 1:40.65 below "time [min:s]"'
            self.faults.add(codes.HEADER_STANDS_TWICE, message, hint, chosen.cell)
            return None
        track = self._track(chosen, False)
        if track is None:
            return None
        if role != "inertia" and used:
            self._note(chosen, f'is only compared: {role} is read from "{used.text}"')
        return self._column(track, rows)

    def _labels(self, rows: list[int]) -> tuple[str, ...]:
        """Label the runs: the log's own labels or their order, with .1, .2 for repeats of one row."""
        column = self.choice.used.get("run")
        labels: dict[str, None] = {}
        for number, (i, times) in enumerate(Counter(rows).items(), 1):
            name = (self._text(i, column[0].at) if column else "") or str(number)
            for k in range(1, times + 1):
                label = name if times == 1 else f"{name}.{k}"
                while label in labels:
                    label += f" (line {self.rows[i].line})"
                labels[label] = None
        return tuple(labels)


def _with_steps_of_floats(read: dict[str, Quantity]) -> tuple[dict[str, Quantity], float]:
    """Take the finest digit of a column of floats as the last one that was read; none (0) if it cannot have been.

    A float drops zeros at its end: 15.0 cm may be 15 or 15.00 cm, and nobody reads 0.15 m to 0.01 m.
    """
    finest = min((cell.step for cell in read.values() if cell.step is not None), default=0.0)
    whole = all(re.fullmatch(r"-?[0-9]+(?:\.0)?(?: .*)?", text) for text in read)
    if whole or finest > 0.02 * max(abs(cell.value) for cell in read.values()):
        return {text: replace(cell, step=None) for text, cell in read.items()}, 0.0
    return read, finest


def _make_readings(texts: list[str], read: dict[str, Quantity], spreads: list[Uncertainty | None]) -> list[Reading]:
    """Make one reading for each row."""
    # A spreadsheet drops zeros at the end: the finest digit anywhere tells how all were read.
    finest: dict[str, float] = {}
    for cell in read.values():
        if cell.step is not None:
            finest[cell.unit] = min(cell.step, finest.get(cell.unit, math.inf))
    readings = []
    for text, spread in zip(texts, spreads, strict=True):
        if one := read.get(text):
            step = None if one.step is None else finest[one.unit]
            readings.append(Reading(one.value, step, one.uncertainty or spread, text))
        else:
            readings.append(_BLANK if text in BLANKS else Reading(text=text))
    return readings
