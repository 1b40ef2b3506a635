"""Read a line with several constants, such as those of the ball."""

from __future__ import annotations

import re

from gyrodata.quantities import numerals
from gyrodata.quantities.units import kinds_of
from gyrodata.readings import roles
from gyrodata.readings.names import (
    DIAMETER,
    SPHERE,
    from_centre,
    name_roles,
    origin_in,
    words_of,
)
from gyrodata.readings.turns import AND

_END_OF_PART = rf"[,;]\s+|\s(?:{'|'.join(AND)})\s+"


def constants_in(line: str) -> list[tuple[str, str]]:
    """Read "ball mass 4.3 kg, diameter: 101.6 mm" as keys and values.

    The result is empty if a part of the line is not a constant: what the line says is
    not certain then.
    """
    constants: dict[str, str] = {}
    # "ball: m = 4.3 kg, d = 101.6 mm" is about nothing else.
    title, _, _ = line.replace("(", ":").partition(":")
    is_of_ball = SPHERE.is_in(title) and len(words_of(title.strip(" #"))) == 1
    content = line.strip()
    parts = re.split(_END_OF_PART, content)
    for part in parts:
        name = part.rstrip(")").partition(next(filter(str.isdecimal, part), "\0"))[0]
        text = part.removeprefix(name).removesuffix(")")
        key = _constant_named(name.strip(" :=(_"), is_of_ball)
        written = numerals.take_apart(text) if key else None
        unit = written.unit if written else ""
        if unit and roles.kind_of_role(key) in kinds_of(unit):
            constants[key] = text
    return list(constants.items()) if len(constants) == len(parts) else []


def _constant_named(name: str, is_of_ball: bool) -> str:
    """Return the key of "rod length", "diameter" or "Masse der Kugel"; else ""."""
    key = "_".join(words_of(name)).lower()
    if key in roles.CONSTANTS:
        return key
    if origin_in(name) or from_centre(name):
        return ""  # a sentence about positions
    bare = SPHERE.without(name).strip(" :(_")
    is_of_ball |= bare != name
    if is_of_ball and "mass" in name_roles(bare)[0]:
        return "ball_mass"
    is_diameter = DIAMETER.is_in(bare) or (is_of_ball and bare in ("d", "D"))
    # The diameter of the weight is another one.
    is_certain = is_of_ball or " " not in bare
    return "ball_diameter" if is_diameter and is_certain else ""
