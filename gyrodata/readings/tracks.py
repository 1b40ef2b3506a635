"""One column's readings by row of the file: blanks that take the value above, and the uncertainty of each."""

from __future__ import annotations

from dataclasses import dataclass

from gyrodata.diagnostics import (
    BLANK_SPIN,
    BLANK_TAKES_VALUE_ABOVE,
    UNCERTAINTY_CANNOT_BE_READ,
    UNIT_UNKNOWN,
    VALUE_BELOW_ITS_FIRST_ROW,
)
from gyrodata.quantities import parse_uncertainty
from gyrodata.readings.cells import Cell, is_blank
from gyrodata.readings.columns import Chosen
from gyrodata.readings.grid import Text
from gyrodata.readings.lablog import Faults, Place, span
from gyrodata.readings.roles import kind_of_role
from gyrodata.readings.settings import Settings
from gyrodata.units import Uncertainty, UnitError

_LOG = "mass [g],position [cm],spin [rpm],time [s],turns\n"
_ROW = "20,15.0,406,13.06,1/3\n"


@dataclass
class Track:
    """One role's readings by row of the file, before rows become runs."""

    chosen: Chosen
    unit: str
    cells: list[Cell | None]
    texts: list[Text | None]
    ids: list[int]
    spreads: list[Uncertainty | None]


def fill_down(
    role: str, track: Track, mass: Track | None, rows: list[list[Text]], is_run: list[bool], faults: Faults
) -> None:
    """Give blank cells the value above; never across a run without a weight, never upwards.

    Parameters
    ----------
    role : str
        One of `FILLED_DOWN`.
    track : Track
        Its readings, changed in place.
    mass : Track or None
        The weights, already filled.
    rows : list of list of Text
        The rows of the file, for their lines.
    is_run : list of bool
        Which rows are timed runs.
    faults : Faults
        Takes the note, or the fault where a value stands below the first row it belongs to.
    """
    last: int | None = None
    filled: list[int] = []
    early: list[int] = []
    loads = role in ("position", "torque", "force") and mass is not None
    for i, cell in enumerate(track.cells):
        if track.texts[i] is not None:
            last = i
        elif loads and mass is not None and (weight := mass.cells[i]) is not None and weight.value == 0:
            last = None
        elif last is None:
            early += [i] if is_run[i] else []
        elif cell is None:
            # A value above that could not be read has been told of once: the blank cells below it lack nothing.
            track.cells[i], track.texts[i] = track.cells[last], track.texts[last]
            track.ids[i], track.spreads[i] = track.ids[last], track.spreads[last]
            filled += [i] if is_run[i] and track.cells[last] is not None else []
    first = next((i for i, text in enumerate(track.texts) if text is not None), -1)
    early = [i for i in early if i < first]
    if early:
        text = track.texts[first]
        assert text is not None
        message = f"{role} is blank in {span([rows[i][0].line for i in early])}, above its first value"
        hint = "write each value in the first row that it belongs to"
        faults.add(VALUE_BELOW_ITS_FIRST_ROW, message, hint, text.place, len(text.text))
    if filled:
        _say_filled(role, track, filled, rows, sum(is_run), faults)


def _say_filled(role: str, track: Track, filled: list[int], rows: list[list[Text]], runs: int, faults: Faults) -> None:
    lines = [rows[i][0].line for i in filled]
    row, at = rows[filled[0]], track.chosen.at
    place = row[at].place if at < len(row) else Place(lines[0], 1)
    if role.startswith("spin") and 2 * len(filled) < runs:
        message = f"{role} is blank in {span(lines)}, where nearly every run has its own"
        faults.add(BLANK_SPIN, message, "the value above was taken; write it there if it was forgotten", place)
    else:
        faults.add(BLANK_TAKES_VALUE_ABOVE, f"{role} is blank in {span(lines)}: the value above was taken", "", place)


_WITH_U = "mass [g],position [cm],spin [rpm],time [s],turns,u_time [s]\n"


def common_spread(
    role: str, chosen: Chosen, unit: str | None, settings: Settings, faults: Faults
) -> Uncertainty | None:
    """Give the uncertainty that holds for a whole column: the ± of its header, else the log's ``u_…``.

    Parameters
    ----------
    role : str
        What the column measures.
    chosen : Chosen
        The column.
    unit : str or None
        Unit of the column, for a ± that has none of its own.
    settings : Settings
        What holds for the whole log.
    faults : Faults
        Takes a ± that cannot be read.

    Returns
    -------
    Uncertainty or None
        [SI unit of the role]
    """
    common = settings.uncertainties.get(f"u_{role}")
    if common is None and role in ("spin_start", "spin_end"):
        common = settings.uncertainties.get("u_spin")
    if chosen.header.spread:
        try:
            return parse_uncertainty(chosen.header.spread, kind_of_role(role), unit or "")
        except UnitError as error:
            cell = chosen.cell
            faults.add(
                UNCERTAINTY_CANNOT_BE_READ,
                f'{role}, column "{cell.text}": {error}',
                error.hint,
                cell.place,
                len(cell.text),
            )
    return common


def read_spreads(
    role: str,
    column: Chosen,
    spreads: list[Uncertainty | None],
    unit: str | None,
    rows: list[list[Text]],
    faults: Faults,
) -> None:
    """Read a ``u_…`` column; its blank cells keep what holds for the whole column of readings.

    Parameters
    ----------
    role : str
        What the readings measure.
    column : Chosen
        The column of their uncertainties.
    spreads : list of Uncertainty or None
        One for each row [SI unit of the role], changed in place.
    unit : str or None
        Unit of the readings; it holds for their uncertainties where those have none of their own.
    rows : list of list of Text
        The rows of the file.
    faults : Faults
        Takes what cannot be read.
    """
    kind = kind_of_role(role)
    own = column.header.unit or unit or ""
    try:
        parse_uncertainty("0 %" if own == "%" else "0", kind, own)
    except UnitError as error:
        cell = column.cell
        faults.add(UNIT_UNKNOWN, f'u_{role}, column "{cell.text}": {error}', error.hint, cell.place, len(cell.text))
        return
    for i, row in enumerate(rows):
        text = row[column.at] if column.at < len(row) else None
        if text is None or is_blank(text.text):
            continue
        try:
            if own == "%" and "%" not in text.text:
                spreads[i] = parse_uncertainty(text.text + " %", kind, ask=False)
            else:
                spreads[i] = parse_uncertainty(text.text, kind, own, ask=False)
        except UnitError as error:
            faults.add(
                UNCERTAINTY_CANNOT_BE_READ,
                f'u_{role} "{text.text[:60]}": {error}',
                error.hint,
                text.place,
                len(text.text),
            )
