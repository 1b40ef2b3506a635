"""Make positions count from the centre of the ball."""

from __future__ import annotations

import math

from msgspec.structs import replace

from gyrodata.quantities.notation import read_cell
from gyrodata.readings import roles
from gyrodata.readings.captions import quoted, statements_in
from gyrodata.readings.grid import Row
from gyrodata.readings.lablog import Column, Faults, Reading, Text
from gyrodata.readings.names import SPHERE, from_centre, origin_in
from gyrodata.readings.settings import Settings

_ARM_DIFFERS = 0.05
"""Difference of an arm in a note from all positions that is reported, as a share."""


def count_from_centre(
    columns: dict[str, Column],
    settings: Settings,
    sentences: list[Text],
    faults: Faults,
) -> float:
    """Make positions count from the centre, if the log says that they do not.

    Return the standard uncertainty of the distance between both places [m].
    """
    position = columns.get("position")
    if position is None:
        return 0.0
    arms = [sentence for sentence in sentences if from_centre(sentence.text)]
    if arms:
        _report_other_arms(position, arms, faults)
    origin = _origin_of(position, settings)
    if origin == "both":
        faults.add("two_origins", position.place(0))
    if origin in ("", "centre", "both"):
        return 0.0
    return _count_from_other_place(columns, origin, settings, sentences, faults)


def _count_from_other_place(
    columns: dict[str, Column],
    origin: str,
    settings: Settings,
    sentences: list[Text],
    faults: Faults,
) -> float:
    """Make positions from the surface or the tip count from the centre."""
    position = columns["position"]
    is_line = settings.fields.get("position_from") is not None
    settings.fields["position_from"] = origin
    key, share, unknown = roles.ORIGIN_LENGTHS[origin]
    length = settings.constants.get(key)
    if length is None:
        centre = '; if they count from the centre: "# position_from: centre"'
        of_ball = [text for text in sentences if SPHERE.is_in(text.text)]
        quotation = quoted({"length"}, of_ball)
        otherwise = quotation if is_line else quotation + centre
        faults.add(unknown, position.place(0), otherwise=otherwise)
        return 0.0
    shift = share * length
    moved = [_from_centre(reading, origin, shift) for reading in position.readings]
    columns["position"] = replace(position, readings=tuple(moved))
    amount = f"{100 * shift:.4g} cm"
    done = f"{amount} is added to" if origin == "surface" else f"{amount} less"
    faults.add("moved", position.place(0), origin=origin, done=done)
    u = settings.uncertainties.get(f"u_{key}")
    if u is None:
        return share * (settings.steps[key] / math.sqrt(12))
    return share * u.at(length)


def _origin_of(position: Column, settings: Settings) -> str:
    """Return from where positions count: by a line, the header, or a note.

    "both" if a note contradicts the header or another note.
    """
    if stated := settings.fields.get("position_from"):
        return str(stated)
    is_option = position.header.startswith(("#", "--"))
    header = "" if is_option else position.header
    of_header = origin_in(header)
    if not of_header and settings.origin and from_centre(header):
        of_header = "centre"
    if (settings.origin, of_header) == ("surface", "centre"):
        return "both"
    return of_header or settings.origin


def _report_other_arms(position: Column, sentences: list[Text], faults: Faults) -> None:
    """Report each sentence with a distance from the centre that no run has."""
    for sentence in sentences:
        row = Row(1, [sentence.text])
        statements = statements_in(row)
        if "position" not in statements:
            continue
        text, _ = statements["position"]
        arm = read_cell(text, "length", None).value
        gaps = [abs(arm - (value or 0.0)) for value in position.values]
        if min(gaps) > _ARM_DIFFERS * arm:
            faults.add("note", sentence, note=sentence.text, role="position")


def _from_centre(reading: Reading, origin: str, shift: float) -> Reading:
    """Return a position from the centre; `shift` is the distance of both places [m]."""
    value = reading.value
    if value is None:
        return reading
    if origin == "tip":
        return replace(reading, value=shift - value)
    # A negative distance is on the counterweight's side.
    return replace(reading, value=value + math.copysign(shift, value))
