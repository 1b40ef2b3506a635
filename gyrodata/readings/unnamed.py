"""Find the role of columns without a known name, by their cells or their unit."""

from __future__ import annotations

import difflib
from operator import attrgetter

from msgspec.structs import replace

from gyrodata.quantities import units
from gyrodata.quantities.numerals import has_digit
from gyrodata.readings import roles
from gyrodata.readings.cells import part_counted
from gyrodata.readings.grid import is_bare
from gyrodata.readings.headers import (
    are_turns,
    counts_turns,
    counts_weights,
    is_one_letter,
    parse_header,
)
from gyrodata.readings.lablog import Faults
from gyrodata.readings.layout import Choice, Chosen, hinted
from gyrodata.readings.names import (
    DISC_WORDS,
    NAMES,
    NOT_THE_WEIGHT,
    PRECESSION,
    SCALE_WORDS,
    SPINNING,
    SUMMARY_WORDS,
    THEORY_WORDS,
    TOKENS,
    UNSURE_WORDS,
    Header,
    Phrases,
    fold_name,
    name_roles,
    numbered,
    squeezed_words,
)
from gyrodata.readings.notes import altered_role
from gyrodata.readings.roles import can_be_found_by_unit, kind_of_role
from gyrodata.readings.unusual_headers import split_unit, unusual_header

_OTHER_THINGS = NOT_THE_WEIGHT | THEORY_WORDS | UNSURE_WORDS | SUMMARY_WORDS
_OF_TILT = Phrases("tilted")
"""Words for an angle that the rod does not sweep."""
_LEVEL = ("90", "90.", "90.0", "90.00")
"""Angle of a level rod from the vertical [deg]."""
OF_DIFFERENCES = ("δ", "∆", "±", "delta", "+/-")
"""Beginnings of the names of differences and of uncertainties, in small letters."""


def place_columns(choice: Choice, faults: Faults) -> None:
    """Give each missing role to the only column without a name that can have it."""
    for column in _unplaced(choice):
        _place_uncertainty(column, choice)
    if not choice.gives_turns() and not choice.states_turns():
        _place_turns(choice, faults)
    there = choice.there | choice.asked
    for role in roles.TABLE:
        if can_be_found_by_unit(role, there):
            _place_by_unit(role.name, choice, faults)


def _unplaced(choice: Choice) -> list[Chosen]:
    return sorted(choice.unplaced, key=attrgetter("at"))


# Uncertainties, by the column to their left

_SIGNS_OF_U = UNSURE_WORDS | set(map(fold_name, ("±", "+/-", "+-")))


def _place_uncertainty(column: Chosen, choice: Choice) -> None:
    """Read "± (g)", "error (g)" and "dm (g)" next to "m (g)" as its uncertainty."""
    sign, _, unit = column.text.replace("[", " [").replace("(", " (").partition(" ")
    for measured in map(choice.first, list(choice.used)):
        if measured.at != column.at - 1:
            continue
        name = measured.header.name
        if sign == f"d{name}" or fold_name(sign) in _SIGNS_OF_U:
            header = parse_header(f"u {name} {unit}")
            role = f"u_{measured.role}"
            if role in header.roles and header.kinds & measured.kinds:
                choice.place(replace(column, header=header), role)


# Turns, by cells


def _place_turns(choice: Choice, faults: Faults) -> None:
    """Read the only column that can contain turns or an angle."""
    unplaced = _unplaced(choice)
    angles = list(filter(_is_angle, unplaced))
    counts = list(filter(_counts_turns, unplaced))
    fitting = {column.at: column for column in (*angles, *counts)}
    if len(fitting) != 1:
        return
    [column] = fitting.values()
    role = "angle" if angles else "turns"
    choice.place(column, role)
    faults.add("read_by_cells", column.cell, role=role)


def _is_angle(column: Chosen) -> bool:
    """Return whether a column contains angles, and not those of a level rod."""
    if column.kinds != {"angle"} or _OF_TILT.is_in(column.header.text):
        return False
    return not set(column.texts).issubset(_LEVEL)


def _counts_turns(column: Chosen) -> bool:
    """Return whether the unit, the cells or a part in the name are those of turns."""
    header = column.header
    if are_turns(header, column.texts) or _counts_parts(column):
        return True
    by_unit = counts_turns(header) and not _has_one_letter_unit(header)
    return by_unit and not header.is_of_the_spin


def _counts_parts(column: Chosen) -> bool:
    """Return whether a column counts thirds, halves or percent of a turn."""
    header = column.header
    if header.roles or header.unit not in (None, "%") or not part_counted(header):
        return False
    texts = column.filled()
    return bool(texts) and all(map(is_bare, texts))


# By unit


def _place_by_unit(role: str, choice: Choice, faults: Faults) -> None:
    """Give a role to the only column with a fitting unit."""
    fitting = _fitting(role, choice)
    if len(fitting) != 1:
        return
    [column] = fitting
    if _name_adds_nothing(role, column, choice):
        choice.place(column, role)
        kind = units.KINDS[kind_of_role(role)].words
        faults.add("read_by_unit", column.cell, role=role, kind=kind)


def _fitting(role: str, choice: Choice) -> list[Chosen]:
    """Return the columns without a name whose unit fits a role.

    The start of a clock, or its stop, is not a reading.
    """
    kind = kind_of_role(role)
    of_kind = [column for column in _unplaced(choice) if kind in column.kinds]
    readings = [column for column in of_kind if not column.header.moment]
    return [column for column in readings if _unit_suffices(role, column.header)]


def _unit_suffices(role: str, header: Header) -> bool:
    if header.text.lower().startswith(OF_DIFFERENCES):
        return False
    if not _has_one_letter_unit(header) or suggest_role(header.text) == role:
        return True
    symbol = TOKENS.split(header.name)[0]  # "m" of "m_added (g)"
    return role in name_roles(symbol)[0]


def _has_one_letter_unit(header: Header) -> bool:
    """Return whether only a one-letter unit says what an unknown column contains.

    A header that is nothing but a unit, such as "g" next to "cm" and "rpm", has no
    other meaning.
    """
    named = header.name.strip() != ""
    return named and header.unit is not None and is_one_letter(header.unit)


def _name_adds_nothing(role: str, column: Chosen, choice: Choice) -> bool:
    """Return whether the name of a column says nothing that its unit does not say."""
    if _is_unit_of_column_before(column, choice) or _names_a_part(role, column.text):
        return False
    name = column.header.name
    words = squeezed_words(name)
    if role == "spin":
        words = {word for word in words if not SPINNING.is_in(word)}
    if role == "position" and words & SCALE_WORDS:
        return False  # a ruler may have its zero at another place
    if role == "mass" and len(set(column.filled())) > 1:
        words -= DISC_WORDS  # a rotor has one mass
    return words.isdisjoint(_OTHER_THINGS)


def _names_a_part(role: str, header: str) -> bool:
    """Return whether a header says a part or another thing than a role."""
    if role == "spin" and PRECESSION.is_in(header):
        return True
    # "mass of one weight", "mass without hanger"
    is_part = _OF_ONE.is_in(header) or altered_role(header) == "mass"
    if role == "mass" and is_part:
        return True
    # The name of "T/2 (s)", "Weight #1 (g)" or "σt (s)" says more than its unit.
    name, _, _ = header.partition("[")
    return has_digit(name.partition("^")[0]) or header[:1] in ("σ", "ε")


def _is_unit_of_column_before(column: Chosen, choice: Choice) -> bool:
    """Return whether "g" may be the unit of the unknown name to its left."""
    if column.text != column.header.unit:
        return False
    bare = [other.at for other in choice.unplaced if other.header.unit is None]
    return column.at - 1 in bare


# Columns that are left


def warn_of_unused_masses(choice: Choice, faults: Faults) -> None:
    """Warn of each column without a place that counts weights or contains masses."""
    columns = choice.columns("mass")
    masses = columns[0].texts if columns else ()
    for column in _unplaced(choice):
        if _may_be_of_mass(column, masses):
            faults.add("mass_unused", column.cell, header=column.text)


def _may_be_of_mass(column: Chosen, masses: tuple[str, ...]) -> bool:
    if "mass" in column.kinds and column.text != column.header.unit:
        words = squeezed_words(column.text)
        is_difference = column.text.lower().startswith(OF_DIFFERENCES)
        return not is_difference and words.isdisjoint(NOT_THE_WEIGHT | UNSURE_WORDS)
    are_all_one = set(column.texts) <= {"", "1"}
    if are_all_one or not counts_weights(column.header):
        return False
    return not _differ_together(column.texts, masses)


def _differ_together(counts: tuple[str, ...], masses: tuple[str, ...]) -> bool:
    """Return whether each number of weights has its own mass: that of all weights."""
    pairs = set(zip(counts, masses, strict=False))
    return len(pairs) == len(set(counts)) == len(set(masses)) > 1


def suggest_role(header: str) -> str:
    """Return the role whose name is nearly that of a header; "" if there is none."""
    name = split_unit(header)[0].replace("[", "(").partition("(")[0].strip()
    key = fold_name(name)
    close = difflib.get_close_matches(key, NAMES, n=1, cutoff=0.75)
    if close and len(key) > 2:
        return NAMES[close[0]][0]
    stem, number = numbered(name)  # "T_P_1"
    roles = name_roles(stem)[0] if number else hinted(unusual_header(header))
    return min(roles, default="")


_OF_ONE = Phrases("of_one")
"""Words for one of several weights."""
