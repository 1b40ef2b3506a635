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
            kind = kind_of_role(role)
            common = _read(column, column.header.spread, kind, unit or "", faults)
        spreads = [common] * len(self.table.rows)
        keys = [key for key in roles.u_keys(role) if key in self.columns]
        if keys:
            self._read_column(keys[0], role, unit, spreads, faults)
        return spreads

    def _read_column(
        self,
        key: str,
        role: str,
        unit: str | None,
        spreads: list[Uncertainty | None],
        faults: Faults,
    ) -> None:
        """Replace the uncertainties of the readings that have their own in a column."""
        column, kind = self.columns[key][0], kind_of_role(key)
        own_unit = column.header.unit or (unit if kind == kind_of_role(role) else None)
        if own_unit is None and kind != "number":
            _ask_for_unit(column, key, faults)
            return
        percent = " %" if own_unit == "%" else ""
        own_unit = "" if percent else own_unit or ""
        if _read(column, f"0{percent}", kind, own_unit, faults) is None:
            return
        for i, text in enumerate(column.texts):
            if text in BLANKS:
                continue
            cell = self.table.grid.cell(self.table.rows[i], column.at)
            typed = text if "%" in text else text + percent
            u = _read(column, typed, kind, own_unit, faults, cell)
            spreads[i] = None if u is None else roles.as_u_of(role, key, u)


def _read(
    column: Chosen,
    text: str,
    kind: str,
    unit: str,
    faults: Faults,
    cell: Text | None = None,
) -> Uncertainty | None:
    """Read one uncertainty; None, with an error at its cell or header, if that fails."""
    try:
        return notation.parse_uncertainty(text, kind, unit, ask=False)
    except UnitError as error:
        values = {"role": column.role, "header": column.text, "error": error}
        faults.add("uncertainty", cell or column.cell, **values)
        return None


def _ask_for_unit(column: Chosen, key: str, faults: Faults) -> None:
    kind = units.KINDS[kind_of_role(key)]
    values = {"text": column.header.text[:60], "role": key, "kind": kind}
    faults.add("no_unit", column.cell.place, units=kind.examples, **values)
