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
) -> tuple[str | None, float]:
    """Make positions count from the centre, if the log says that they do not.

    Return the place from which they were measured, None if the log names none, and the
    standard uncertainty of its distance from the centre [m].
    """
    stated = settings.fields.get("position_from")
    position = columns.get("position")
    if position is None:
        return stated, 0.0
    arms = [sentence for sentence in sentences if from_centre(sentence.text)]
    if arms:
        _report_other_arms(position, arms, faults)
    origin = stated or _origin_of(position, settings.origin)
    if origin == "both":
        faults.add("two_origins", position.place(0))
    if origin not in roles.ORIGIN_LENGTHS:
        return stated, 0.0
    key, _, unknown = roles.ORIGIN_LENGTHS[origin]
    if key in settings.constants:
        return origin, _move_to_centre(columns, origin, settings, faults)
    otherwise = _otherwise(sentences, is_stated=stated is not None)
    faults.add(unknown, position.place(0), otherwise=otherwise)
    return origin, 0.0


def _move_to_centre(
    columns: dict[str, Column], origin: str, settings: Settings, faults: Faults
) -> float:
    """Make positions from the surface or the tip count from the centre.

    Return the standard uncertainty of the distance between both places [m].
    """
    position = columns["position"]
    key, share, _ = roles.ORIGIN_LENGTHS[origin]
    length = settings.constants[key]
    shift = share * length
    moved = [_from_centre(reading, origin, shift) for reading in position.readings]
    columns["position"] = replace(position, readings=tuple(moved))
    amount = f"{100 * shift:.4g} cm"
    done = f"{amount} is added to" if origin == "surface" else f"{amount} less"
    faults.add("moved", position.place(0), origin=origin, done=done)
    return share * _u_of_length(key, settings)


def _u_of_length(key: str, settings: Settings) -> float:
    """Return the stated uncertainty of a length, or that of its last digit [m]."""
    u = settings.uncertainties.get(f"u_{key}")
    if u is None:
        return settings.steps[key] / math.sqrt(12)
    return u.at(settings.constants[key])


def _otherwise(sentences: list[Text], is_stated: bool) -> str:
    """Return the rest of the question for a length: what the log says of the ball."""
    of_ball = [text for text in sentences if SPHERE.is_in(text.text)]
    quotation = quoted({"length"}, of_ball)
    if is_stated:
        return quotation
    return f'{quotation}; if they count from the centre: "# position_from: centre"'


def _origin_of(position: Column, noted: str) -> str:
    """Return from where positions count by their header, or else by a note.

    "both" if the header says the centre, and the note the surface.
    """
    is_option = position.header.startswith(("#", "--"))
    header = "" if is_option else position.header
    of_header = origin_in(header)
    if of_header:
        return of_header
    if from_centre(header):
        return "both" if noted == "surface" else "centre"
    return noted


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
