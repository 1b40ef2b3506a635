"""Read the uncertainty of each reading of a column."""

from __future__ import annotations

from collections.abc import Mapping

from msgspec import Struct

from gyrodata.quantities import notation, units
from gyrodata.quantities.units import Uncertainty, UnitError
from gyrodata.readings import layout, roles
from gyrodata.readings.chosen import Chosen
from gyrodata.readings.lablog import BLANKS, Faults, Text
from gyrodata.readings.roles import kind_of_role


class Uncertainties(Struct, frozen=True):
    """The ``u_…`` columns of a table, and the ``u_…`` of the log."""

    table: layout.Layout
    columns: Mapping[str, list[Chosen]]
    """Columns in use, by role."""
    of_log: Mapping[str, Uncertainty]
    """Uncertainty of each ``u_…`` that is valid for the whole log."""

    def of_role(
        self, role: str, column: Chosen | None, unit: str | None, faults: Faults
    ) -> list[Uncertainty | None]:
        """Return the u of each reading.

        It is that of its ``u_…`` column, else the ± of the header, else the ``u_…`` of
        the log.
        """
        common = roles.stated_u(role, self.of_log)
        if column is not None and column.header.spread:
            common = _read(column, column.header.spread, unit or "", faults)
        spreads = [common] * len(self.table.rows)
        keys = [key for key in roles.u_keys(role) if key in self.columns]
        if keys:
            own = self.columns[keys[0]][0]
            unit = _own_unit(own, role, unit)
            self._read_column(own, role, unit, spreads, faults)
        return spreads

    def _read_column(
        self,
        column: Chosen,
        role: str,
        unit: str | None,
        spreads: list[Uncertainty | None],
        faults: Faults,
    ) -> None:
        """Replace the uncertainties of the readings that have their own in a column."""
        if unit is None and kind_of_role(column.role) != "number":
            _ask_for_unit(column, faults)
            return
        percent = " %" if unit == "%" else ""
        unit = "" if percent else unit or ""
        if _read(column, f"0{percent}", unit, faults) is None:
            return
        for i, text in enumerate(column.texts):
            if text in BLANKS:
                continue
            cell = self.table.grid.cell(self.table.rows[i], column.at)
            typed = text if "%" in text else text + percent
            u = _read(column, typed, unit, faults, cell)
            spreads[i] = None if u is None else roles.as_u_of(role, column.role, u)


def _own_unit(column: Chosen, role: str, unit: str | None) -> str | None:
    """Return the unit of a ``u_…`` column: its own, or else that of its readings."""
    is_same_kind = kind_of_role(column.role) == kind_of_role(role)
    return column.header.unit or (unit if is_same_kind else None)


def _read(
    column: Chosen,
    text: str,
    unit: str,
    faults: Faults,
    cell: Text | None = None,
) -> Uncertainty | None:
    """Read one uncertainty; None, with an error at its cell or header, if that fails."""
    try:
        kind = kind_of_role(column.role)
        return notation.parse_uncertainty(text, kind, unit, ask=False)
    except UnitError as error:
        values = {"role": column.role, "header": column.text, "error": error}
        faults.add("uncertainty", cell or column.cell, **values)
        return None


def _ask_for_unit(column: Chosen, faults: Faults) -> None:
    kind = units.KINDS[kind_of_role(column.role)]
    values = {"text": column.header.text[:60], "role": column.role, "kind": kind}
    faults.add("no_unit", column.cell.place, units=kind.examples, **values)
