"""From cells to columns of readings: units, fill-down, uncertainties, one row for each run."""

from __future__ import annotations

import math
from dataclasses import dataclass

from gyrodata.diagnostics import (
    COLUMN_NOT_USED,
    NOTE_IS_ONLY_A_NUMBER,
    NUMBER_IMPOSSIBLE,
    OPTION_REPLACES_COLUMN,
    PER_SECOND_IS_AMBIGUOUS,
    ROW_TOO_LONG,
    ROW_WITHOUT_TIME,
    UNIT_MISSING,
    UNIT_UNKNOWN,
)
from gyrodata.readings.cells import Cell, CellError, check_value, is_blank, read_cell
from gyrodata.readings.columns import Choice, Chosen
from gyrodata.readings.grid import Text
from gyrodata.readings.lablog import Column, Faults, Place, span
from gyrodata.readings.layout import Layout, is_number
from gyrodata.readings.roles import FILLED_DOWN, derived_roles, kind_of_role
from gyrodata.readings.settings import Given, Settings
from gyrodata.readings.tracks import Track, common_spread, fill_down, read_spreads
from gyrodata.units import (
    DISPLAY,
    Uncertainty,
    UnitError,
    examples,
    parse_unit,
)

_LOG = "mass [g],position [cm],spin [rpm],time [s],turns\n"
_ROW = "20,15.0,406,13.06,1/3\n"


@dataclass(frozen=True)
class Table:
    """The runs of a log."""

    runs: tuple[str, ...]
    lines: tuple[int, ...]
    notes: tuple[str, ...]
    columns: dict[str, Column]
    others: tuple[Column, ...]


def build(layout: Layout, choice: Choice, settings: Settings, faults: Faults) -> Table:
    """Read every cell of the columns chosen."""
    return _Builder(layout, choice, settings, faults).build()


class _Builder:
    def __init__(self, layout: Layout, choice: Choice, settings: Settings, faults: Faults) -> None:
        self.choice, self.settings, self.faults = choice, settings, faults
        self.width = len(layout.cells)
        self.rows = layout.rows
        self.replaced: set[str] = set()
        for role, given in settings.roles.items():
            if given.place is None and role in choice.used:
                self.replaced.add(role)
                self._note_replaced(given)
        for key, given in settings.given_uncertainties.items():
            if given.place is None and key in choice.used:
                self._note_replaced(given)
                del choice.used[key]
        there = (set(choice.used) | set(settings.roles)) - {"run", "note"}
        self.derived = derived_roles(there)
        self.derived |= {f"u_{role}" for role in self.derived}

    def _note_replaced(self, given: Given) -> None:
        header = self.choice.used[given.key][0].header.text
        self.faults.add(OPTION_REPLACES_COLUMN, f'{given.label} takes the place of the column "{header}"')

    def build(self) -> Table:
        self._check_widths()
        times = self._time_tracks()
        is_run = self._run_rows(times)
        rows = [i for i, run in enumerate(is_run) if run]
        tracks: dict[str, Track] = {}
        for role in sorted(self.choice.used, key=lambda r: r != "mass"):  # what it weighs says where to fill
            if role in ("time", "run", "note") or role[:2] == "u_":
                continue
            if role in self.replaced:
                continue
            strict = role not in self.derived
            faults = self.faults if strict else Faults(self.faults.name)
            track = self._track(role, self.choice.used[role][0], strict)
            if track is not None:
                # A constant of the log would stand in the blank cells.
                if role in FILLED_DOWN and role not in self.settings.roles:
                    fill_down(role, track, tracks.get("mass"), self.rows, is_run, faults)
                tracks[role] = track
        plan = [(i, k) for i in rows for k, time in enumerate(times or [None]) if time is None or time.cells[i]]
        columns: dict[str, Column] = {}
        if times:
            columns["time"] = self._time_column(times, plan)
        for role, track in tracks.items():
            column = self._column(role, track, [i for i, _ in plan])
            if any(value is not None for value in column.values):
                columns[role] = column
        for role, given in self.settings.roles.items():
            if role not in columns and plan:
                columns[role] = _constant_column(role, given, len(plan), self.settings.uncertainties.get(f"u_{role}"))
        others = [self._other(chosen, [i for i, _ in plan]) for chosen in self.choice.others]
        labels = self._labels(plan)
        notes = self.choice.used.get("note")
        return Table(
            labels,
            tuple(self.rows[i][0].line for i, _ in plan),
            tuple(self._text(i, notes[0].at) if notes else "" for i, _ in plan),
            columns,
            tuple(other for other in others if other is not None),
        )

    def _text(self, row: int, at: int) -> str:
        return self.rows[row][at].text if at < len(self.rows[row]) else ""

    def _check_widths(self) -> None:
        notes = self.choice.used.get("note")
        for row in self.rows:
            if len(row) > self.width:
                cell = row[self.width]
                message = f"this row has {len(row)} cells, the header {self.width}"
                hint = 'put numbers with a decimal comma in quotes ("13,06"), or part the columns with ;'
                self.faults.add(ROW_TOO_LONG, message, hint, cell.place, len(cell.text))
            elif notes and notes[0].at == self.width - 1 == len(row) - 1 and is_number(row[-1].text):
                # A decimal comma that parts a number shifts all that follows to the right.
                message = f'the note "{row[-1].text}" is a number: is there a decimal comma in this row?'
                hint = 'put such numbers in quotes ("13,06"); words after the number make it a note'
                self.faults.add(NOTE_IS_ONLY_A_NUMBER, message, hint, row[-1].place, len(row[-1].text))

    def _run_rows(self, times: list[Track]) -> list[bool]:
        """Tell which rows are timed runs, and name the others."""
        if times:
            is_run = [any(track.texts[i] is not None for track in times) for i in range(len(self.rows))]
        else:
            keys = [c[0].at for r in ("precession_period", "precession_rate") if (c := self.choice.used.get(r))]
            is_run = [not keys or any(not is_blank(self._text(i, at)) for at in keys) for i in range(len(self.rows))]
        left_out = [i for i, run in enumerate(is_run) if not run]
        if left_out and any(is_run):
            lines = [self.rows[i][0].line for i in left_out]
            cell = next((c for c in self.rows[left_out[0]] if c.text), self.rows[left_out[0]][0])
            what = "has no time and is no run" if len(lines) == 1 else "have no time and are no runs"
            self.faults.add(ROW_WITHOUT_TIME, f"{span(lines)} {what}: left out", "", cell.place, len(cell.text))
        return is_run

    def _time_tracks(self) -> list[Track]:
        if "time" in self.replaced:
            return []
        there = set(self.choice.used) | set(self.settings.roles)
        periods = there & {"precession_period", "precession_rate"}
        if periods and "time" in self.choice.used and not there & {"turns", "angle"}:
            # A time whose turns nobody tells says nothing; its repeats would count one period several times.
            cell = self.choice.used["time"][0].cell
            message = f'the column "{cell.text}" is not used: its turns are not given; {min(periods)} is read instead'
            self.faults.add(COLUMN_NOT_USED, message, "", cell.place, len(cell.text))
            return []
        tracks = [self._track("time", chosen, True) for chosen in self.choice.used.get("time", [])]
        return [track for track in tracks if track is not None]

    def _track(self, role: str, chosen: Chosen, strict: bool) -> Track | None:
        """Read one column; None if it is only compared and cannot be read."""
        kind = kind_of_role(role)
        faults = self.faults if strict else Faults(self.faults.name)
        try:
            unit = parse_unit(chosen.header.unit, kind).text if chosen.header.unit else None
        except UnitError as error:
            self._refuse_unit(role, chosen, error, strict)
            return None
        if unit is None and kind in ("number", "sign"):
            unit = ""
        cells: list[Cell | None] = []
        texts: list[Text | None] = []
        bare: Text | None = None
        for row in self.rows:
            text = row[chosen.at] if chosen.at < len(row) else None
            cell = None
            if text is None or is_blank(text.text):
                text = None
            else:
                try:
                    cell = read_cell(text.text, kind, unit)
                except CellError as error:
                    if error.code == UNIT_MISSING:
                        bare = bare or text
                    else:
                        message = f'{role} "{text.text[:60]}"{error.joint}{error}'
                        faults.add(error.code, message, error.hint, text.place, len(text.text))
                else:
                    fault, hint = check_value(role, cell.value)
                    if fault:
                        faults.add(NUMBER_IMPOSSIBLE, f'{role} "{text.text}" {fault}', hint, text.place, len(text.text))
            cells.append(cell)
            texts.append(text)
        if bare is not None:
            self._ask_for_unit(role, chosen, faults)
        if not strict and faults.found:
            self._note_unused(role, chosen, faults.found[0].message)
            return None
        used = next((cell.unit for cell in cells if cell is not None), unit or "")
        return Track(
            chosen, unit or used, cells, texts, list(range(len(cells))), self._spreads(role, chosen, unit, strict)
        )

    def _refuse_unit(self, role: str, chosen: Chosen, error: UnitError, strict: bool) -> None:
        if not strict:
            self._note_unused(role, chosen, str(error))
            return
        code = PER_SECOND_IS_AMBIGUOUS if error.reason == "ambiguous" else UNIT_UNKNOWN
        cell = chosen.cell
        self.faults.add(code, f'{role}, column "{cell.text}": {error}', error.hint, cell.place, len(cell.text))

    def _ask_for_unit(self, role: str, chosen: Chosen, faults: Faults) -> None:
        kind = kind_of_role(role)
        name = chosen.header.text[:60]
        hint = f'write the header as "{name} [{DISPLAY[kind]}]" (or {examples(kind)})'
        faults.add(UNIT_MISSING, f'the column "{name}" ({role}) has no unit', hint, chosen.cell.place, len(name))

    def _note_unused(self, role: str, chosen: Chosen, why: str) -> None:
        cell = chosen.cell
        message = f'the column "{cell.text}" ({role}) is not compared: {why}'
        self.faults.add(COLUMN_NOT_USED, message, "", cell.place, len(cell.text))

    def _spreads(self, role: str, chosen: Chosen, unit: str | None, strict: bool) -> list[Uncertainty | None]:
        """Collect what the header and the ``u_…`` column say of each reading; of a derived one without a word."""
        faults = self.faults if strict else Faults(self.faults.name)
        common = common_spread(role, chosen, unit, self.settings, faults)
        spreads: list[Uncertainty | None] = [common] * len(self.rows)
        column = self.choice.used.get(f"u_{role}")
        if column is None and role in ("spin_start", "spin_end"):
            column = self.choice.used.get("u_spin")
        if column is None:
            return spreads
        if column[0].header.unit is None and unit is None and kind_of_role(role) != "number":
            self._ask_for_unit(f"u_{role}", column[0], faults)
            return spreads
        read_spreads(role, column[0], spreads, unit, self.rows, faults)
        return spreads

    def _column(self, role: str, track: Track, rows: list[int]) -> Column:
        """Put a track's rows in the order of the runs, with the constant of the log in blank cells."""
        # A spreadsheet drops zeros at the end: the finest digit anywhere tells how all were read.
        finest: dict[str, float] = {}
        for cell in track.cells:
            if cell is not None and cell.step is not None:
                finest[cell.unit] = min(cell.step, finest.get(cell.unit, math.inf))
        given = self.settings.roles.get(role)
        values: list[float | None] = []
        resolutions: list[float | None] = []
        spreads: list[Uncertainty | None] = []
        ids: list[int] = []
        places: list[Place | None] = []
        texts: list[str] = []
        for i in rows:
            cell, text = track.cells[i], track.texts[i]
            if cell is not None and text is not None:
                values.append(cell.value)
                resolutions.append(None if cell.step is None else finest[cell.unit])
                spreads.append(cell.uncertainty or track.spreads[i])
                ids.append(track.ids[i])
                places.append(text.place)
                texts.append(text.text)
                continue
            if cell is None and text is None and given is not None and given.cell is not None:
                values.append(given.cell.value)
                resolutions.append(given.cell.step)
                spreads.append(given.cell.uncertainty or track.spreads[i])
                ids.append(len(self.rows))
                places.append(given.place)
                texts.append(given.text)
                continue
            values.append(None)
            resolutions.append(None)
            spreads.append(None)
            ids.append(track.ids[i])
            places.append(text.place if text else None)
            texts.append(text.text if text else "")
        order = {old: new for new, old in enumerate(dict.fromkeys(ids))}
        return Column(
            role,
            track.chosen.header.text,
            track.unit,
            tuple(values),
            tuple(resolutions),
            tuple(spreads),
            tuple(order[i] for i in ids),
            tuple(places),
            tuple(texts),
        )

    def _time_column(self, times: list[Track], plan: list[tuple[int, int]]) -> Column:
        """Make one column of all stopwatch readings; each is a reading of its own."""
        parts = [self._column("time", track, list(range(len(self.rows)))) for track in times]
        finest = min((r for part in parts for r in part.resolutions if r), default=None)
        return Column(
            "time",
            parts[0].header,
            parts[0].unit,
            tuple(parts[k].values[i] for i, k in plan),
            tuple(None if parts[k].resolutions[i] is None else finest for i, k in plan),
            tuple(parts[k].uncertainties[i] for i, k in plan),
            tuple(range(len(plan))),
            tuple(parts[k].places[i] for i, k in plan),
            tuple(parts[k].texts[i] for i, k in plan),
        )

    def _other(self, chosen: Chosen, rows: list[int]) -> Column | None:
        if kind_of_role(chosen.role) == "text" or chosen.role[:2] == "u_":
            used = self.choice.used[chosen.role][0].header.text
            message = f'the column "{chosen.cell.text}" is not used: {chosen.role} is read from "{used}"'
            self.faults.add(COLUMN_NOT_USED, message, "", chosen.cell.place, len(chosen.cell.text))
            return None
        track = self._track(chosen.role, chosen, False)
        if track is None:
            return None
        if chosen.role != "inertia":
            used = self.choice.used[chosen.role][0].header.text
            message = f'the column "{chosen.cell.text}" is only compared: {chosen.role} is read from "{used}"'
            self.faults.add(COLUMN_NOT_USED, message, "", chosen.cell.place, len(chosen.cell.text))
        return self._column(chosen.role, track, rows)

    def _labels(self, plan: list[tuple[int, int]]) -> tuple[str, ...]:
        """Label the runs: the log's own labels or their order, with .1, .2 for repeats of one row."""
        repeats: dict[int, int] = {}
        for i, _ in plan:
            repeats[i] = repeats.get(i, 0) + 1
        column = self.choice.used.get("run")
        names = {i: (self._text(i, column[0].at) if column else "") or str(n) for n, i in enumerate(repeats, 1)}
        labels: list[str] = []
        seen: set[str] = set()
        count: dict[int, int] = {}
        for i, _ in plan:
            count[i] = count.get(i, 0) + 1
            label = names[i] if repeats[i] == 1 else f"{names[i]}.{count[i]}"
            while label in seen:
                label += f" (line {self.rows[i][0].line})"
            seen.add(label)
            labels.append(label)
        return tuple(labels)


def _constant_column(role: str, given: Given, runs: int, common: Uncertainty | None) -> Column:
    assert given.cell is not None
    cell = given.cell
    return Column(
        role,
        given.label,
        cell.unit,
        (cell.value,) * runs,
        (cell.step,) * runs,
        (cell.uncertainty or common,) * runs,
        (0,) * runs,
        (given.place,) * runs,
        (given.text,) * runs,
    )
