"""Choose the role of each column of a table."""

from __future__ import annotations

import re
from collections.abc import Mapping
from itertools import chain
from operator import attrgetter

from msgspec.structs import replace

from gyrodata.quantities.units import DISPLAY, kinds_of
from gyrodata.readings import layout, roles, unnamed
from gyrodata.readings.cells import part_counted
from gyrodata.readings.headers import (
    are_turns,
    can_measure,
    may_number,
    unused_words,
)
from gyrodata.readings.lablog import Faults, header_of, listing
from gyrodata.readings.layout import Choice, Chosen, columns_of, note_unused
from gyrodata.readings.names import TOKENS, Header, squeeze
from gyrodata.readings.roles import can_be_found_by_unit, kind_of_role, missing_roles
from gyrodata.readings.settings import Settings

_TIMES = ((), ("time",), ("precession_period",))
"""Roles of a header that may be a time of stated turns."""
_BALL_TURNS = 5
"""This many turns may be those of the ball, if nothing else gives the spin."""


def choose(
    table: layout.Layout, mapping: Mapping[str, str], settings: Settings, faults: Faults
) -> Choice:
    """Give each column its role.

    Each step needs the roles that the steps before it have given, and the certain ones
    come first: columns that the user names with --map; headers that name one role;
    times whose header states its turns, which may be those of the ball as long as no
    other column gives the spin; headers of several roles of which one is left; and last
    columns of which only the cells or the unit show what they contain. At the end a
    reading of the spin gets the moment that the other columns leave to it.
    """
    choice = Choice({*settings.roles}, mapped={*mapping})
    columns = columns_of(table)
    if mapping:
        columns = _serve_mapped(columns, mapping, choice, faults)
    columns = _with_counts(columns, choice)
    several = _serve_by_name(columns, choice)
    stating = list(filter(_states_turns, columns))
    if stating:
        _serve_stating(stating, table, choice)
    if several:
        _eliminate(several, choice, faults)
    if choice.unplaced:
        unnamed.place_columns(choice, faults)
    if "spin" in choice.used:
        _ask_for_moments(choice, faults)
    if choice.there & {"spin_start", "spin_end"}:
        _name_moment_of_spin(choice, faults)
    _ask_about_unused_words(choice, faults)
    if choice.unplaced and "mass" in choice.there:
        unnamed.warn_of_unused_masses(choice, faults)
    choice.unplaced.sort(key=attrgetter("at"))
    for repeats in choice.used.values():
        repeats.sort(key=attrgetter("number"))
    return choice


# --map


def _serve_mapped(
    columns: list[Chosen], mapping: Mapping[str, str], choice: Choice, faults: Faults
) -> list[Chosen]:
    """Use the columns that ``--map`` names; return the others."""
    mapped: dict[int, Chosen] = {}
    for key, header in mapping.items():
        column = _column_called(header, key, columns, faults)
        if column.at in mapped:
            first = mapped[column.at].role
            raise faults.refuse("mapped_twice", header=header, first=first, second=key)
        number = key.removeprefix("time_")
        role = key if number == key else "time"
        unit = _unit_for(role, column.header)
        chosen = replace(column, header=replace(column.header, unit=unit), role=role)
        if role == "time":
            repeat = None if number == key else int(number)
            chosen = replace(chosen, number=repeat, turns=column.header.turns)
        mapped[column.at] = chosen
        choice.serve(chosen)
    return [column for column in columns if column.at not in mapped]


def _column_called(
    header: str, key: str, columns: list[Chosen], faults: Faults
) -> Chosen:
    """Return the column with a header as written, or else in other letters."""
    named = [column for column in columns if column.text]
    exact = [column for column in named if column.text == header.strip()]
    same = [column for column in named if squeeze(column.text) == squeeze(header)]
    if same:
        return (exact or same)[0]
    headers = listing([f'"{column.text}"' for column in named], 40)
    raise faults.refuse(
        "mapped_header_unknown", role=key, header=header, headers=headers
    )


def _unit_for(role: str, header: Header) -> str | None:
    """Return the unit of a header for a role: its own, or an end that can be one."""
    kind = kind_of_role(role)
    unit = header.unit
    if kind == "text":
        return None
    if unit:
        kinds = kinds_of(unit)
        if unit == "%" or not kinds or kind in kinds:
            return unit
    words = header.text.replace("/", " ")
    parts = TOKENS.split(words)
    ends = [end for end in parts[1:] if kind in kinds_of(end)]
    if ends:
        return ends[-1]
    return unit or header.spread.partition(" ")[2] or None


# By name


def _with_counts(columns: list[Chosen], choice: Choice) -> list[Chosen]:
    """Let "rotation" or "precession" count turns, if nothing else counts them."""
    timed = any(
        "time" in column.kinds or column.header.roles == ("time",) for column in columns
    )
    counted = choice.gives_turns() or any(
        column.header.turns or column.header.roles in (("turns",), ("angle",))
        for column in columns
    )
    if counted or not timed:
        return columns
    return list(map(_with_count, columns))


def _with_count(column: Chosen) -> Chosen:
    header = column.header
    if header.unit is not None or "precession_rate" not in header.roles:
        return column
    names = _counted_by_cells(column) or ("turns", "angle", *header.roles)
    return replace(column, header=replace(header, roles=names))


def _counted_by_cells(column: Chosen) -> tuple[str, ...]:
    """Return what the cells of a "rotation" or "precession" count, if they show it.

    It is an angle above "120°", and turns above "2/3" or "one third".
    """
    texts = column.filled()
    marks = [text.lstrip("0123456789., ") for text in texts]
    if texts and all(kinds_of(mark) == {"angle"} for mark in marks):
        return ("angle",)
    nameless = replace(column.header, roles=(), text="")
    return ("turns",) if are_turns(nameless, texts) else ()


def _states_turns(column: Chosen) -> bool:
    """Return whether a column contains times of turns that its header states."""
    header = column.header
    if not header.turns:
        return False
    if header.unit is not None:
        return header.roles in _TIMES and "time" in column.kinds
    return header.roles == ("time",)


def _serve_by_name(columns: list[Chosen], choice: Choice) -> list[Chosen]:
    """Use the columns that name one role; return those that name several."""
    several: list[Chosen] = []
    for column in _in_order_of_trust(columns):
        header = column.header
        if _states_turns(column):
            continue
        if not can_measure(header) and _unit_says_otherwise(column, choice):
            choice.unplaced.append(column)
        elif len(header.roles) == 1:
            choice.serve(replace(column, role=header.roles[0], number=header.number))
        elif header.roles:
            several.append(column)
        elif header.text or any(column.texts):
            choice.unplaced.append(column)
    return several


def _in_order_of_trust(columns: list[Chosen]) -> list[Chosen]:
    """Sort columns so that the better one of two columns of a role comes first.

    A unit that does not fit the name comes after one that fits; numbers of weights or
    holes ("Weight" above 1, 2 next to "mass [g]") after readings; means after the
    readings of which they are the mean; a bare letter, which may number runs, after a
    name; and a distance from the surface after one from the centre.
    """
    with_unit = {
        other.header.roles for other in columns if other.header.unit is not None
    }

    def doubts(column: Chosen) -> tuple[bool, ...]:
        header = column.header
        return (
            bool(header.unit) and not can_measure(header),
            header.unit is None and header.roles in with_unit,
            header.is_of_means,
            may_number(header),
            header.origin in ("surface", "tip"),
        )

    return sorted(columns, key=doubts)


# By stated turns


def _serve_stating(columns: list[Chosen], table: layout.Layout, choice: Choice) -> None:
    """Use the columns that state their turns.

    For example, "Time for 1/3 rev (s)" is a time of the precession, or of the ball.
    """
    rates = [header for header in table.headers if header.kinds == {"rate"}]
    spin_is_known = bool(rates) or choice.gives_spin()
    for column in _in_order_of_trust(columns):
        turns = column.header.turns
        is_of_ball = turns.isdigit() and int(turns) >= _BALL_TURNS
        if column.header.is_of_the_spin or (is_of_ball and not spin_is_known):
            choice.unplaced.append(column)
            continue
        number = None if column.header.is_of_means else choice.next_repeat()
        choice.serve(replace(column, role="time", number=number, turns=turns))


# By elimination


def _eliminate(several: list[Chosen], choice: Choice, faults: Faults) -> None:
    """Decide headers of several roles if only one role is left.

    Ask about the rest if they are needed.
    """
    while decided := [column for column in several if len(_left(column, choice)) == 1]:
        column = decided[0]
        several = [other for other in several if other is not column]
        choice.serve(replace(column, role=_left(column, choice)[0]))
    missing = missing_roles(choice.there, choice.there)
    lacking: set[str] = {roles.BY_NAME[role].part for role in missing}
    parts_of_times = {"timing", "count"}
    if lacking & parts_of_times:
        lacking |= parts_of_times
    for column in several:
        _ask_or_leave_out(column, lacking, choice, faults)


def _ask_or_leave_out(
    column: Chosen, lacking: set[str], choice: Choice, faults: Faults
) -> None:
    """Ask for the role of a column if it may be needed; else say that it is unused."""
    left = _left(column, choice)
    if not any(_may_be_needed(role, lacking) for role in left):
        fits = " and ".join(column.header.roles)
        note_unused(column, f"is not used: it fits {fits}", faults)
        return
    counts = choice.columns("turns")
    without = f' (and take "{counts[0].text}" out)' if counts else ""
    ends = {role: without if role in roles.ONE_TURN else "" for role in left}
    ways = [f'--map {role}="{column.text}"{ends[role]}' for role in left]
    unit = column.header.unit
    usual = {role: unit or DISPLAY[kind_of_role(role)] for role in left}
    headers = [f'"{header_of(role, usual[role])}"{ends[role]}' for role in left]
    choice.asked.update(left)
    fits = " and ".join(left)
    way = " or ".join(ways)
    header = " or ".join(headers)
    faults.add("two_roles", column.cell, roles=fits, ways=way, headers=header)


def _may_be_needed(role: str, lacking: set[str]) -> bool:
    """Return whether a role is an uncertainty, or that of a part that is lacking."""
    return role.startswith("u_") or roles.BY_NAME[role].part in lacking


def _left(column: Chosen, choice: Choice) -> list[str]:
    """Return the roles that a header may still have."""
    there = set(choice.there)
    if choice.states_turns():
        there.add("turns")
    names = column.header.roles
    if _may_be_mean_time(column, there, choice):
        return []
    if key := _uncertainty_of_symbol(column, choice):
        return [key]
    left = [role for role in names if _is_open(role, there, choice)]
    left = _without_second_motion(left, there, choice)
    # A quantity that follows from the readings is not needed, if the header can be
    # another one.
    derived = roles.derived_roles(there)
    return [role for role in left if role not in derived] or left


def _may_be_mean_time(column: Chosen, there: set[str], choice: Choice) -> bool:
    """Return whether "T" may be the mean of times, next to times without turns."""
    is_period = column.header.roles == ("time", "precession_period")
    return is_period and "time" in choice.used and there.isdisjoint(roles.COUNTS)


def _without_second_motion(
    left: list[str], there: set[str], choice: Choice
) -> list[str]:
    """Decide between the spin and the precession, if only one of them is left.

    "rotation" next to "period" is the spin; next to "before" and "after" it is not.
    """
    if "spin" not in left or there.isdisjoint(roles.TIMINGS):
        return left
    closed = ("spin",) if choice.gives_spin() else roles.TIMINGS
    return [role for role in left if role not in closed]


def _uncertainty_of_symbol(column: Chosen, choice: Choice) -> str:
    """Return the uncertainty of the role of its symbol here: "σ_T" next to "T"."""
    symbol = _last_word(column)
    for role, used in choice.used.items():
        is_open = f"u_{role}" in column.header.roles
        if is_open and _last_word(used[0]) == symbol:
            return f"u_{role}"
    return ""


def _last_word(column: Chosen) -> str:
    """Return the symbol at the end of a name: "T" of "σ_T" and of "Period T"."""
    words = list(filter(None, TOKENS.split(column.header.name)))
    return words[-1] if words else ""


def _is_open(role: str, there: set[str], choice: Choice) -> bool:
    """Return whether no column has a role; an uncertainty needs one of its reading."""
    if role in there:
        return False
    return not role.startswith("u_") or role.removeprefix("u_") in choice.used


# Readings of the spin


def _ask_for_moments(choice: Choice, faults: Faults) -> None:
    """Ask about "rpm 1" and "rpm 2": they may be readings before and after each run."""
    first = choice.first("spin")
    for other in (*choice.others, *choice.unplaced):
        has_stem = other.header.name[:-1] == first.header.name[:-1] != ""
        is_alike = has_stem or other.text[:-1] == first.text[:-1]
        # Readings before and after a run have one unit.
        is_alike = is_alike and other.header.unit == first.header.unit
        if is_alike and "rate" in (other.kinds or first.kinds):
            faults.add("two_spins", first.cell, second=other.text)


def _name_moment_of_spin(choice: Choice, faults: Faults) -> None:
    """Find the moment of a spin that the columns next to it decide.

    A spin before the run without one after it is that of the whole run, and a spin next
    to one after the run was read before it.
    """
    first = choice.columns("spin")
    before = choice.columns("spin_start")
    after = choice.columns("spin_end")
    every_role = set(chain.from_iterable(roles.SPIN_SETS))
    if before and choice.there.isdisjoint(every_role - {"spin_start"}):
        choice.rename("spin_start", "spin")
        faults.add("only_spin_before", before[0].cell)
    elif first and after and not before:
        choice.rename("spin", "spin_start")
        faults.add("spin_then_end", first[0].cell, end=after[0].text)


# Words without a use


def _ask_about_unused_words(choice: Choice, faults: Faults) -> None:
    """Ask about a number, the ball or the tip in a header, if no rule has used it.

    What --map names is decided, but not how often a time contains it: "T/2", "three".
    """
    for role, columns in choice.used.items():
        if role in roles.TEXTS or role.startswith("u_"):
            continue
        for column in columns:
            words = " ".join(unused_words(column.header))
            if words and _may_change(column, role in choice.mapped):
                named = header_of(role, column.header.unit)
                spoken = role.replace("_", " ")
                faults.add(
                    "words_not_used", column.cell, words=words, named=named, role=spoken
                )


def _may_change(column: Chosen, is_mapped: bool) -> bool:
    """Return whether words of a header may change the meaning of its column."""
    if _uses_words(column):
        return False
    return column.role in _TIMED or not is_mapped


_TIMED = (*roles.TIMINGS, "spin_period", "spin_period_start", "spin_period_end")
"""Roles of times: a header may name a part, or several, of what they measure."""


_MULTIPLE = r"[2-9]\s?[x×*·]|[x×*·/]\s?[2-9]"


def _uses_words(column: Chosen) -> bool:
    """Return whether the words say that the ball turns, or which part is counted."""
    if column.role.startswith("spin"):
        is_multiple = re.search(_MULTIPLE, column.header.name) is not None
        return column.role not in _TIMED and not is_multiple
    return column.role in roles.COUNTS and part_counted(column.header) != ""


def _unit_says_otherwise(column: Chosen, choice: Choice) -> bool:
    """Return whether a column has the unit of a missing role, and not of its own name.

    The unit says more than the word: "Masa (s)" is a time in Malay.
    """
    if len(column.header.roles) != 1 or not column.kinds:
        return False
    return any(
        kind_of_role(role.name) in column.kinds
        for role in roles.TABLE
        if can_be_found_by_unit(role, choice.there)
    )
