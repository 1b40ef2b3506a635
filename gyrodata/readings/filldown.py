"""Merged cells: a blank setting takes the value above it, and the log says so."""

from __future__ import annotations

from dataclasses import dataclass

from gyrodata.errors import register
from gyrodata.readings.cells import Cell
from gyrodata.readings.choice import Chosen
from gyrodata.readings.grid import Text
from gyrodata.readings.log import Faults, Place, span
from gyrodata.units import Uncertainty

_LOG = "mass [g],position [cm],spin [rpm],time [s],turns\n"
_ROW = "20,15.0,406,13.06,1/3\n"
G217 = register("G217", "note", "blank cells take the value above", _LOG + _ROW + ",,598,19.2,1/3\n")
G218 = register("G218", "warning", "a blank spin that may be forgotten", _LOG + _ROW * 2 + "20,15.0,,13.1,1/3\n")
G219 = register("G219", "error", "a value below the first row it belongs to", _LOG + "," + _ROW[3:] + _ROW)

FILLED_DOWN = (
    "mass",
    "force",
    "torque",
    "position",
    "spin",
    "spin_start",
    "spin_end",
    "spin_period",
    "spin_period_start",
    "spin_period_end",
)


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
        faults.add(G219, message, hint, text.place, len(text.text))
    if filled:
        _say_filled(role, track, filled, rows, sum(is_run), faults)


def _say_filled(role: str, track: Track, filled: list[int], rows: list[list[Text]], runs: int, faults: Faults) -> None:
    lines = [rows[i][0].line for i in filled]
    row, at = rows[filled[0]], track.chosen.at
    place = row[at].place if at < len(row) else Place(lines[0], 1)
    if role.startswith("spin") and 2 * len(filled) < runs:
        message = f"{role} is blank in {span(lines)}, where nearly every run has its own"
        faults.add(G218, message, "the value above was taken; write it there if it was forgotten", place)
    else:
        faults.add(G217, f"{role} is blank in {span(lines)}: the value above was taken", "", place)
