"""What a log says of the uncertainty of each reading: in the header, in a ``u_…`` column, for the whole log."""

from __future__ import annotations

from gyrodata.errors import register
from gyrodata.quantities import parse_uncertainty
from gyrodata.readings.cells import G205, is_blank
from gyrodata.readings.choice import Chosen
from gyrodata.readings.grid import Text
from gyrodata.readings.log import Faults
from gyrodata.readings.settings import Settings
from gyrodata.units import Uncertainty, UnitError, kind_of_role

_LOG = "mass [g],position [cm],spin [rpm],time [s],turns,u_time [s]\n"
G227 = register("G227", "error", "an uncertainty that cannot be read", _LOG + "20,15.0,560,13.06,1/3,little\n")


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
            faults.add(G227, f'{role}, column "{cell.text}": {error}', error.hint, cell.place, len(cell.text))
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
        faults.add(G205, f'u_{role}, column "{cell.text}": {error}', error.hint, cell.place, len(cell.text))
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
            faults.add(G227, f'u_{role} "{text.text[:60]}": {error}', error.hint, text.place, len(text.text))
