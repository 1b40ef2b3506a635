"""Give blank cells the value above, and ask for cells whose value is not known."""

from __future__ import annotations

from collections.abc import Mapping

from msgspec import Struct
from msgspec.structs import replace

from gyrodata.readings import layout, roles
from gyrodata.readings.lablog import UNKNOWN, Column, Faults, Place, Reading, Text

Values = tuple[float | None, ...]
"""Values of a column [SI unit of its role]."""


class Loads(Struct, frozen=True):
    """The loads of each row, as far as they were read."""

    mass: Values = ()
    force: Values = ()
    torque: Values = ()

    @classmethod
    def of(cls, columns: Mapping[str, Column]) -> Loads:
        """Return the loads in the columns that were read."""
        names = [role for role in ("mass", "force", "torque") if role in columns]
        return cls(**{role: columns[role].values for role in names})

    def pulls_nothing(self, row: int) -> bool:
        """Return whether one of the loads is 0 in a row."""
        loads = (self.mass, self.force, self.torque)
        return any(values[row] == 0 for values in loads if values)

    def differs(self, row: int, other: int) -> bool:
        """Return whether another weight hangs in another row."""
        values = self.mass or self.force
        return bool(values) and values[row] != values[other]


class Filler:
    """Completes the columns of a table in which not every cell is filled."""

    def __init__(
        self, table: layout.Layout, loads: Loads, is_run: list[bool], faults: Faults
    ) -> None:
        self.table = table
        self.loads = loads
        self.is_run = is_run
        self.faults = faults

    def complete(self, column: Column, at: int, is_constant: bool) -> Column:
        """Return a column with blank cells filled.

        Report the cells of runs that contain "?" or "n/a"; those of other rows are
        blank. Without a weight no position is needed. `is_constant`: a value of the
        whole log is in the blank cells already.
        """
        readings = list(column.readings)
        for i, reading in enumerate(readings):
            if reading.text not in UNKNOWN:
                continue
            if self.is_run[i] and not self._needs_no_value(column, i):
                cell = self.table.grid.cell(self.table.rows[i], at)
                self.faults.add("unknown_cell", cell, role=column.role)
            else:
                readings[i] = Reading()
        column = replace(column, readings=tuple(readings))
        return column if is_constant else self._fill_down(column, at)

    def _needs_no_value(self, column: Column, row: int) -> bool:
        """Return whether a column is one of loads, and nothing pulls in a row."""
        return column.role in roles.LOADS and self.loads.pulls_nothing(row)

    def _fill_down(self, column: Column, at: int) -> Column:
        """Give blank cells the value above.

        Never upwards, across a run without a weight, or from its turns.

        A position is valid for another weight only if the log states no other one. A
        cell such as "?" is not blank.
        """
        above = self._values_above(column)
        filled = self._runs_filled(column, above)
        early = self._runs_above_first(column)
        if self._is_measured_each_time(column.role, len(filled)):
            # A blank cell was forgotten.
            above = {i: j for i, j in above.items() if i not in filled}
            early = [*early, *filled] if early else []
            filled = []
        typed = [i for i, reading in enumerate(column.readings) if reading.text]
        if early:
            self._report("below_first_row", column, early, column.cell(typed[0]))
        if filled:
            place = self.table.grid.place_of(self.table.rows[filled[0]].spot(at))
            self._report("filled_down", column, filled, place)
        return column.select([above.get(i, i) for i in range(len(column.readings))])

    def _report(
        self, name: str, column: Column, rows: list[int], place: Text | Place | None
    ) -> None:
        lines = [self.table.rows[i].line for i in rows]
        self.faults.add(name, place, role=column.role, lines=lines)

    def _runs_above_first(self, column: Column) -> list[int]:
        """Return the runs above the first value; one without a weight needs no load."""
        above: list[int] = []
        for i, reading in enumerate(column.readings):
            if reading.text:
                return above
            if self.is_run[i] and not self._needs_no_value(column, i):
                above.append(i)
        return []

    def _values_above(self, column: Column) -> dict[int, int]:
        """Return the row with the valid value above each blank cell, by its row."""
        above: dict[int, int] = {}
        last = None
        for i, reading in enumerate(column.readings):
            if reading.text:
                last = i
            elif self._needs_no_value(column, i):
                last = None
            elif last is not None and self._is_valid_below(column, last, i):
                above[i] = last
        return above

    def _runs_filled(self, column: Column, above: dict[int, int]) -> list[int]:
        """Return the runs that take a value from above.

        An unreadable value above is reported once: the blank cells below it lack
        nothing.
        """
        values = column.values
        return [i for i, j in above.items() if self.is_run[i] and values[j] is not None]

    def _is_valid_below(self, column: Column, last: int, row: int) -> bool:
        """Return whether the value of a row may be that of a row below."""
        if column.role == "position":
            several = sum(value is not None for value in column.values) > 1
            return not (several and self.loads.differs(last, row))
        if column.role in roles.COUNTS and self.loads.pulls_nothing(last):
            return self.loads.pulls_nothing(row)  # without a weight it turns less
        return True

    def _is_measured_each_time(self, role: str, blank: int) -> bool:
        """Return whether nearly every run has its own value, so none is filled down."""
        runs = sum(self.is_run)
        if role == "mass":
            return 8 * blank < runs
        if role in roles.COUNTS and runs == 2:
            return True  # two runs show no pattern
        is_reading = roles.BY_NAME[role].part in ("spin", "count")
        return is_reading and 2 * blank < runs
