"""The record of a header, and what its words say.

`headers` parses the usual headers into this record, and `unusual_headers` the others.
"""

from __future__ import annotations

import re
from typing import Literal

from msgspec import Struct

from gyrodata.quantities.units import kinds_of
from gyrodata.readings.names import name_roles
from gyrodata.readings.origins import Origin
from gyrodata.readings.remarks import altered_role
from gyrodata.readings.roles import kind_of_role
from gyrodata.readings.words import (
    END_WORDS,
    PRECESSION,
    SPINNING,
    START_WORDS,
    squeezed_words,
)

OF_TURNS = frozenset({"angle", "number"})
"""Kinds that a unit of turns can measure."""


class Header(Struct, frozen=True):
    """The content of a header."""

    text: str
    roles: tuple[str, ...] = ()
    """Roles that the header may name."""
    unit: str | None = None
    """Unit text as written, known or not; None if there is none."""
    spread: str = ""
    """Text of a ±, with its unit if it has one; or ""."""
    number: int | None = None
    """Number of a repeat: ``time_2`` is 2."""
    name: str = ""
    """The text without its unit, its ± and the signs around them."""
    turns: str = ""
    """Turns that the text states: "1/3", "1", "2.5"; or ""."""
    origin: Origin = ""
    """Where the text says that a position counts from."""
    moment: Literal["", "start", "end"] = ""
    """Part of a run to which the reading belongs, if the text says so."""
    is_of_means: bool = False
    """Whether the text says that the values are means."""
    is_of_the_spin: bool = False
    """Whether the text says that the ball turns, and not the rod."""


def hinted(header: Header) -> set[str]:
    """Return the roles that one word of a header names.

    The unit of the header can measure them, or the header says that the reading is
    "without" something.
    """
    if header.unit is None:
        return {altered_role(header.text)}
    words = re.findall(r"[^\W\d_]{2,}", header.text)
    return {
        role
        for word in words
        for role in name_roles(word)[0]
        if measures(header.unit, role)
    }


def measures(unit: str, role: str) -> bool:
    """Return whether a role, or the uncertainty of one, can have a unit."""
    return kind_of_role(role) in kinds_of(unit) or (
        unit == "%" and role.startswith("u_")
    )


def moment_in(header: str) -> Literal["", "start", "end"]:
    """Return the part of a run that a header names, as "start (s)" and "t stop" do."""
    words = squeezed_words(header)
    if words & START_WORDS:
        return "start"
    return "end" if words & END_WORDS else ""


def is_of_the_spin(header: str) -> bool:
    """Return whether a header says that turns of the ball are timed."""
    return SPINNING.is_in(header) and not re.search(PRECESSION, header)
