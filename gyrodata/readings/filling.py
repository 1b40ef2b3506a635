"""Give blank cells the value above, and ask for cells whose value is not known."""

from __future__ import annotations

from collections.abc import Mapping

from msgspec import Struct, field
from msgspec.structs import replace

from gyrodata.readings import layout, roles
from gyrodata.readings.lablog import UNKNOWN, Column, Faults, Reading
from gyrodata.readings.source import Row

Values = tuple[float | None, ...]
"""Values of a column [SI unit of its role]."""


class Loads(Struct, frozen=True):
    """What pulls in each row, as far as it was read."""

    mass: Values = ()
    force: Values = ()
    torque: Values = ()

    @classmethod
    def of(cls, columns: Mapping[str, Column]) -> Loads:
        """Return the loads in the columns that were read."""
        names = [role for role in ("mass", "force", "torque") if role in columns]
        return cls(**{role: columns[role].values for role in names})

    def is_without_weight(self, row: int) -> bool:
        """Return whether the mass in a row is 0."""
        return bool(self.mass) and self.mass[row] == 0

    def is_unloaded(self, row: int) -> bool:
        """Return whether the first load that was read is 0 in a row."""
        values = self.mass or self.force or self.torque
        return bool(values) and values[row] == 0

    def pulls_nothing(self, row: int) -> bool:
        """Return whether one of the loads is 0 in a row."""
        loads = (self.mass, self.force, self.torque)
        return any(values[row] == 0 for values in loads if values)

    def differs(self, row: int, other: int) -> bool:
        """Return whether another weight hangs in another row."""
        values = self.mass or self.force
        return bool(values) and values[row] != values[other]


class _Blanks(Struct):
    """The blank cells of a column."""

    above: dict[int, int] = field(default_factory=dict)
    """Row with the valid value above, by row."""
    early: list[int] = field(default_factory=list)
    """Runs above the first value."""


def fill_down(
    column: Column,
    table: layout.Layout,
    at: int,
    loads: Loads,
    is_run: list[bool],
    faults: Faults,
) -> Column:
    """Give blank cells the value above.

    Never upwards, across a run without a weight, or from its turns.

    A position is valid for another weight only if the log states no other one. A cell
    such as "?" is not blank.
    """
    typed = [i for i, reading in enumerate(column.readings) if reading.text]
    if len(typed) == len(column.readings):
        return column
    blanks = _find_blanks(column, loads, is_run, table.grid.dittos)
    # An unreadable value above is reported once: the blank cells below it lack nothing.
    filled = [
        i for i, j in blanks.above.items() if is_run[i] and column.values[j] is not None
    ]
    own = [i for i in filled if _has_other_readings(table.rows[i])]
    if _is_measured_each_time(column.role, len(filled), len(own), sum(is_run)):
        # A blank cell was forgotten.
        blanks.above = {i: j for i, j in blanks.above.items() if i not in filled}
        blanks.early = sorted([*blanks.early, *filled]) if blanks.early else []
        filled = []
    if blanks.early and typed:
        cell = table.grid.cell(table.rows[typed[0]], at)
        lines = [table.rows[i].line for i in blanks.early]
        faults.add("below_first_row", cell, role=column.role, lines=lines)
    if filled:
        place = table.grid.cell(table.rows[filled[0]], at).place
        lines = [table.rows[i].line for i in filled]
        faults.add("filled_down", place, role=column.role, lines=lines)
    sources = [blanks.above.get(i, i) for i in range(len(column.readings))]
    return column.select(sources)


def _find_blanks(
    column: Column, loads: Loads, is_run: list[bool], dittos: set[int]
) -> _Blanks:
    """Find the value that is valid in each blank cell."""
    blanks = _Blanks()
    several = sum(value is not None for value in column.values) > 1
    moves = column.role == "position" and several
    begun, last = False, None
    for i, reading in enumerate(column.readings):
        if reading.text:
            begun, last = True, i
        elif column.role in roles.LOADS and loads.is_without_weight(i):
            last = None
        elif last is not None:
            is_other = moves and column.spots[i] not in dittos
            if is_other and loads.differs(last, i):
                continue  # where the new weight hung is not known
            if not _turns_end(column.role, loads, last, i):
                blanks.above[i] = last
        elif not begun and is_run[i]:
            blanks.early.append(i)
    return blanks


def _turns_end(role: str, loads: Loads, last: int, row: int) -> bool:
    """Return whether turns are those of a run without a weight, in which the rod turns less."""
    if role not in roles.COUNTS:
        return False
    return loads.is_without_weight(last) and not loads.is_without_weight(row)


def _has_other_readings(row: Row) -> bool:
    """Return whether a row does more than repeat a time."""
    return len(layout.filled_at(row)) > 2


def _is_measured_each_time(role: str, blank: int, own: int, runs: int) -> bool:
    """Return whether nearly every run has its own value, so that none is filled down.

    `own` of the blank cells are in rows with other readings. Two runs show no pattern.
    """
    if role == "mass":
        return 8 * blank < runs
    if role in roles.COUNTS and runs == 2 and own:
        return True
    return roles.BY_NAME[role].part in ("spin", "count") and 2 * blank < runs


def ask_for_unknown(
    column: Column,
    table: layout.Layout,
    at: int,
    loads: Loads,
    is_run: list[bool],
    faults: Faults,
) -> Column:
    """Report the cells of runs that contain "?" or "n/a".

    Return the column, with such cells of other rows blank. Without a weight no position
    is needed.
    """
    readings = list(column.readings)
    for i, reading in enumerate(readings):
        if reading.text not in UNKNOWN:
            continue
        is_needed = column.role not in roles.LOADS or not loads.is_unloaded(i)
        if is_run[i] and is_needed:
            cell = table.grid.cell(table.rows[i], at)
            faults.add("unknown_cell", cell, role=column.role)
        else:
            readings[i] = Reading()
    return replace(column, readings=tuple(readings))
