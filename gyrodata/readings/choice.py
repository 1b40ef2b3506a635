"""Choose the role of each column of a table.

The role comes from --map, from the name, from elimination, or from the cells or the
unit.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping
from decimal import Decimal, DecimalException
from operator import attrgetter, itemgetter

from msgspec import Struct, field
from msgspec.structs import replace

from gyrodata.quantities import units, vocabulary
from gyrodata.quantities.notation import PLAIN, fold_number, to_float
from gyrodata.quantities.units import DISPLAY, kinds_of
from gyrodata.readings import captions, layout, roles
from gyrodata.readings.grid import Row
from gyrodata.readings.lablog import Faults, Settings, Text, header_of, listing
from gyrodata.readings.roles import (
    Header,
    kind_of_role,
    parse_header,
    squeeze,
    turns_in,
)

TWO_READINGS = (
    r"([0-9]+(?:[.,][0-9]+)?)\s*(?:-|->|→|/|to|bis|à|до)\s*([0-9]+(?:[.,][0-9]+)?)"
)
_OTHER_THINGS = (
    roles.NOT_THE_WEIGHT
    | roles.THEORY_WORDS
    | roles.UNSURE_WORDS
    | roles.SUMMARY_WORDS
    | roles.SCALE_WORDS
)
_PART_OF_TURN = vocabulary.pattern("parts")
"""Words for a part of a turn."""
_OF_TILT = vocabulary.pattern("tilted")
"""Words for an angle that the rod does not sweep."""


_PERIOD_SYMBOL = r"(?:[^\w(]*[0-9]\S*\s+)?T(?![^\W\d_])"
"""A header that begins with the usual symbol of a period, "T1 [s]", or "1st T [s]"."""


MOST_TURNS = 50
"""Larger numbers below "n" are not turns."""


class Chosen(Struct, frozen=True):
    """A column with its role."""

    at: int
    """Number of the column, from 0."""
    cell: Text
    header: Header
    role: str
    number: int | None = None
    """Number of a repeat (``time_2``: 2)."""
    turns: str = ""
    """Turns of each time, if the header states them: "1/3"."""
    part: int = 0
    """Number of the reading, from 1, if each cell has two; else 0."""


class Choice(Struct):
    """The column of each role."""

    there: set[str]
    """Roles that have a column, or one value for the whole log."""
    used: dict[str, list[Chosen]] = field(default_factory=dict)
    """One column for each role; several for repeats of the time."""
    others: list[Chosen] = field(default_factory=list)
    """Further columns of a role, and ``inertia``."""
    unplaced: list[Text] = field(default_factory=list)
    """Headers that name no role."""
    asked: set[str] = field(default_factory=set)
    """Roles that a header may mean, if the log's author has to decide."""

    def serve(self, chosen: Chosen) -> None:
        """Use a column for its role, or put it with the others."""
        present = self.used.get(chosen.role, [])
        is_repeat = chosen.number is not None and {None, chosen.number}.isdisjoint(
            one.number for one in present
        )
        if chosen.role == "inertia" or (present and not is_repeat):
            self.others.append(chosen)
        else:
            self.used[chosen.role] = [*present, chosen]
            self.there.add(chosen.role)


def choose(
    table: layout.Layout, mapping: Mapping[str, str], settings: Settings, faults: Faults
) -> Choice:
    """Give each column its role.

    The role comes from --map, from the name, from the turns that the column states,
    from elimination, or from the unit.
    """
    choice = Choice(set(settings.roles))
    mapped = _mapped(table, mapping, faults) if mapping else {}
    for chosen in mapped.values():
        choice.serve(chosen)
    columns = [
        Chosen(at, table.cells[at], header, "")
        for at, header in enumerate(table.headers)
        if at not in mapped
    ]
    named = {
        squeeze(roles.split_unit(header.text)[0]): header.roles
        for header in table.headers
    }
    several: list[Chosen] = []
    stating: list[Chosen] = []
    # A unit that does not fit the name comes after one that fits, means after the
    # readings of which they are the mean, a bare letter, which may number runs, after a
    # name, and a distance from the surface after one from the centre.
    letters = {one.at for one in columns if may_number(one.header)}
    with_unit = {one.header.roles for one in columns if one.header.unit is not None}

    before_or_after = roles.START_WORDS | roles.END_WORDS
    later = []
    for one in columns:
        is_number = (
            one.header.unit is None and one.header.roles in with_unit
        )  # "Weight" above 1, 2 next to "mass [g]"
        text = one.cell.text
        unfit = bool(one.header.unit) and not roles.can_measure(one.header)
        later.append(
            (
                unfit,
                is_number,
                layout.is_of_means(text),
                one.at in letters,
                roles.origin_in(text) > "",
            )
        )
    typed: list[Chosen] = []
    """The columns, with the units of their cells."""
    for _, column in sorted(zip(later, columns, strict=True), key=itemgetter(0)):
        header = column.header
        texts = [row.texts[column.at] for row in table.rows]
        name = squeeze(roles.split_unit(header.text)[0])
        if not header.roles and name and name[0] in "Δδσε":  # "ΔT" next to "T"
            found = tuple(
                f"u_{role}"
                for role in named.get(name[1:], ())
                if f"u_{role}" in roles.UNCERTAINTIES
            )
            column = replace(column, header=replace(header, roles=found))
        typed.append(column)
        header = column.header
        found = header.roles
        is_time = found in (
            (),
            ("time",),
            ("precession_period",),
        ) and "time" in kinds_of(header.unit or "")
        # "Time for one turn" or "1 turn takes" above "20.3 s"
        in_time = any(texts) and all(
            "time" in kinds_of(text.lstrip("0123456789., ")) for text in texts if text
        )
        is_time |= header.unit is None and (
            found == ("time",) or (not found and in_time)
        )
        if (
            not found
            and kinds_of(header.unit or "") == {"rate"}
            and name.lower() in before_or_after
        ):
            found = (
                "spin_start" if name.lower() in roles.START_WORDS else "spin_end",
            )  # "Before (rpm)"
        numbers = [
            to_float(text)
            for text in texts
            if name in ("n", "N") and PLAIN.fullmatch(text)
        ]
        if found == ("turns",) and min(numbers, default=0) > MOST_TURNS:
            found = ("spin",)  # whose unit is missing
        if (
            found == ("precession_rate",)
            and header.unit is None
            and all(map(turns_in, filter(None, texts)))
        ):
            found = ("turns",)  # "precession" above "1/2 turn"
        if is_time and turns_in(header.text):
            stating.append(column)
        elif len(found) == 1:
            choice.serve(replace(column, role=found[0], number=header.number))
        elif found:
            several.append(column)
        elif header.text or any(texts):
            choice.unplaced.append(column.cell)
    if stating or mapped:
        _serve_stating(stating, table, choice)
    times = choice.used.get("time", [])
    periods = [
        one
        for one in times
        if re.match(_PERIOD_SYMBOL, one.cell.text) and one.number and not one.turns
    ]
    uncounted = choice.there.isdisjoint((*roles.COUNTS, *roles.ONE_TURN))
    if periods == times != [] and uncounted and not _told_of_parts(table):
        choice.used["time"] = [
            replace(one, turns="1") for one in times
        ]  # "T1 [s]", "T2 [s]"
        faults.add("period_of_one_turn", times[0].cell)
    if several:
        _eliminate(table, several, choice, faults)
    if choice.unplaced:
        _place_by_cells_and_unit(
            sorted(typed, key=attrgetter("at")), table, choice, faults
        )
    for one in [*choice.used.get("spin", []), *choice.used.get("time", [])]:
        pairs = [
            re.fullmatch(TWO_READINGS, fold_number(row.texts[one.at]))
            for row in table.rows
        ]
        apart = (
            abs(to_float(pair[1]) / (to_float(pair[2]) or math.inf) - 1) if pair else 1
            for pair in pairs
        )
        if max(apart, default=1) < 0.2:
            is_spin = one.role == "spin"
            what = (
                "the spin at the start and at the end"
                if is_spin
                else "two times of one setting"
            )
            faults.add("two_readings", one.cell, what=what)
            choice.used[one.role] = [
                other for other in choice.used.pop(one.role) if other is not one
            ]
            choice.there.discard("spin" if is_spin else "")
            for part, role in enumerate(
                ("spin_start", "spin_end") if is_spin else ("time", "time"), 1
            ):
                choice.serve(
                    replace(one, role=role, part=part, number=None if is_spin else part)
                )
            choice.used = {role: many for role, many in choice.used.items() if many}
    before = choice.used.get("spin_start", [])
    if before and choice.there.isdisjoint(
        {role for one in roles.SPIN_SETS for role in one} - {"spin_start"}
    ):
        choice.used["spin"] = [
            replace(one, role="spin") for one in choice.used.pop("spin_start")
        ]
        choice.there = choice.there - {"spin_start"} | {"spin"}
        faults.add("only_spin_before", before[0].cell)
    first, after = choice.used.get("spin", []), choice.used.get("spin_end", [])
    if first and after and not before:
        choice.used["spin_start"] = [
            replace(one, role="spin_start") for one in choice.used.pop("spin")
        ]
        choice.there = choice.there - {"spin"} | {"spin_start"}
        faults.add("spin_then_end", first[0].cell, end=after[0].cell.text)
    if choice.unplaced and "mass" in choice.there:
        _warn_of_unused_masses(columns, table, choice, faults)
    choice.unplaced.sort(key=attrgetter("place"))
    for repeats in choice.used.values():
        repeats.sort(key=attrgetter("number"))
    return choice


def _warn_of_unused_masses(
    columns: list[Chosen], table: layout.Layout, choice: Choice, faults: Faults
) -> None:
    """Warn of each column without a place that counts weights or contains masses."""
    masses = [
        row.texts[choice.used["mass"][0].at] if "mass" in choice.used else ""
        for row in table.rows
    ]
    for column in columns:
        cells = [row.texts[column.at] for row in table.rows]
        # If each number has its own mass, this is the mass of all weights.
        whole = (
            len(set(zip(cells, masses, strict=True)))
            == len(set(cells))
            == len(set(masses))
            > 1
        )
        counts = roles.counts_weights(column.header) and not (
            whole or {*cells} <= {"", "1"}
        )
        header = column.cell.text
        weighs = (
            "mass" in kinds_of(column.header.unit or "")
            and header != column.header.unit
        )
        weighs &= roles.NOT_THE_WEIGHT.isdisjoint(roles.squeezed_words(header))
        if column.cell in choice.unplaced and (counts or weighs):
            faults.add("mass_unused", column.cell, header=header)


def _serve_stating(stating: list[Chosen], table: layout.Layout, choice: Choice) -> None:
    """Use the columns that state their turns.

    For example, "Time for 1/3 rev (s)" is a time of the precession, or of the ball.
    """
    rates = any(kinds_of(header.unit or "") == {"rate"} for header in table.headers)
    spins = rates or any(choice.there.issuperset(one) for one in roles.SPIN_SETS)
    for column in stating:
        turns, of_the_spin = (
            turns_in(column.cell.text),
            roles.is_of_the_spin(column.cell.text),
        )
        if (
            of_the_spin
            and not roles.clock_word(column.cell.text)
            and "spin_time" not in choice.used
        ):
            choice.serve(replace(column, role="spin_time", turns=turns))
        elif of_the_spin or (not spins and turns.isdigit() and int(turns) >= 5):
            choice.unplaced.append(column.cell)  # ten turns may be the ball's
        else:
            numbers = {one.number for one in choice.used.get("time", [])}
            free = [
                number for number in range(1, len(numbers) + 2) if number not in numbers
            ]
            number = None if layout.is_of_means(column.cell.text) else free[0]
            choice.serve(replace(column, role="time", number=number, turns=turns))
    times = choice.used.get("time", [])
    said, others = (
        {one.turns for one in times if one.turns},
        [one.number for one in times if not one.turns],
    )
    if said and others and "turns" not in choice.there:
        # "t1 of one turn, t2, t3" are repeats; of "T1/3, T2/3, T1" the last is one
        # turn.
        is_part = others == [1] and all("/" in turns for turns in said)
        turns = ""
        if is_part:
            turns = "1"
        elif len(said) == 1:
            turns = "".join(said)
        choice.used["time"] = [replace(one, turns=one.turns or turns) for one in times]


def _mapped(
    table: layout.Layout, mapping: Mapping[str, str], faults: Faults
) -> dict[int, Chosen]:
    """Find the columns that ``--map`` names."""
    found: dict[int, Chosen] = {}
    texts = [cell.text for cell in table.cells]
    for key, wanted in mapping.items():
        same = [
            at
            for at, text in enumerate(texts)
            if text and squeeze(text) == squeeze(wanted)
        ]
        if not same:
            headers = listing([f'"{text}"' for text in texts if text], 40)
            raise faults.refuse(
                "mapped_header_unknown", role=key, header=wanted, headers=headers
            )
        at = next((at for at in same if texts[at] == wanted.strip()), same[0])
        if at in found:
            raise faults.refuse(
                "mapped_twice", header=wanted, first=found[at].role, second=key
            )
        role, number = (
            ("time", int(key[5:])) if key.startswith("time_") else (key, None)
        )
        header, kind = table.headers[at], kind_of_role(role)
        ends = (
            header.text.rpartition(mark)[2].strip()
            for mark in ",;/_ "
            if mark in header.text
        )
        unit = header.unit or next(
            (end for end in ends if kind in kinds_of(end)),
            header.spread.partition(" ")[2],
        )
        header = replace(header, unit=None if kind == "text" else unit or None)
        found[at] = Chosen(
            at,
            table.cells[at],
            header,
            role,
            number,
            turns_in(header.text) if role == "time" else "",
        )
    return found


def _eliminate(
    table: layout.Layout, several: list[Chosen], choice: Choice, faults: Faults
) -> None:
    """Decide headers of several roles if only one role is left.

    Ask about the rest if they are needed.
    """
    counts = choice.used.get("turns", [])
    counted = {row.texts[one.at] for row in table.rows for one in counts}
    for column in list(several):
        # "T" can only be the time of one turn if no turns are counted, or each time
        # covers one.
        known = {"time", "precession_period", "angle"} & choice.there
        single = counted <= {"", "1"} and ("turns" not in choice.there or counts)
        if (
            column.header.roles == ("time", "precession_period")
            and single
            and not known
            and not _told_of_parts(table)
        ):
            several.remove(column)
            choice.serve(replace(column, role="precession_period"))
            faults.add("period_of_one_turn", column.cell)
    while decided := [column for column in several if len(_left(column, choice)) == 1]:
        several.remove(decided[0])
        choice.serve(replace(decided[0], role=_left(decided[0], choice)[0]))
    lacking = {
        roles.BY_NAME[role].part
        for role in missing_roles(choice.there, choice.there, loaded=True)
    }
    lacking |= {"timing", "count"} if lacking & {"timing", "count"} else set()
    for column in several:
        left, cell = _left(column, choice), column.cell
        if any(
            role[:2] == "u_" or roles.BY_NAME[role].part in lacking for role in left
        ):
            without = f' (and take "{counts[0].cell.text}" out)' if counts else ""
            ends = {role: without * (role in roles.ONE_TURN) for role in left}
            names = {
                role: header_of(role, column.header.unit or DISPLAY[kind_of_role(role)])
                for role in left
            }
            headers = (f'"{names[role]}"{ends[role]}' for role in left)
            ways = " or ".join(
                f'--map {role}="{cell.text}"{ends[role]}' for role in left
            )
            choice.asked.update(left)
            faults.add(
                "two_roles",
                cell,
                roles=" and ".join(left),
                ways=ways,
                headers=" or ".join(headers),
            )
        else:
            faults.add(
                "not_used",
                cell,
                why=f"is not used: it fits {' and '.join(column.header.roles)}",
            )


def _told_of_parts(table: layout.Layout) -> bool:
    """Return whether a note is about a number of turns that is not one.

    An example is "T is the time from one mark to the next".
    """
    cells = (
        text
        for row in table.grid.rows
        for text in row.texts
        if re.search(r"[^\W\d_]{3}", text)
    )
    notes = (*captions.texts_of(table.grid), *cells)
    return any(
        re.search(_PART_OF_TURN, note) or turns_in(note) not in ("", "0", "1")
        for note in notes
    )


def _left(column: Chosen, choice: Choice) -> list[str]:
    """Return the roles that a header may still have."""
    found, there = column.header.roles, choice.there
    if any(one.turns for one in choice.used.get("time", ())):
        there = there | {"turns"}
    if (
        found == ("time", "precession_period")
        and "time" in choice.used
        and there.isdisjoint(roles.COUNTS)
    ):
        # next to a time without turns, "T" may be the mean of such times as well
        return []
    # An uncertainty belongs to the role that its symbol has, "σ_T" to "T"; else to a
    # role that has a column.
    bases = tuple(role.removeprefix("u_") for role in found)
    for used in choice.used.values():
        if bases != found and used[0].header.roles == bases and used[0].role in bases:
            return [f"u_{used[0].role}"]
    open_roles = [
        role
        for role in found
        if role not in there and (role[:2] != "u_" or role[2:] in choice.used)
    ]
    if not there.isdisjoint(roles.TIMINGS) and "spin" in open_roles:
        # "rotation" and "period": the first is the spin; next to "before" and "after",
        # "Omega" is not.
        done = any(there.issuperset(one) for one in roles.SPIN_SETS)
        open_roles = [
            role
            for role in open_roles
            if role not in (("spin",) if done else roles.TIMINGS)
        ]
    # A quantity that follows from the readings is not needed, if the header can be
    # another one.
    return [
        role for role in open_roles if role not in roles.derived_roles(there)
    ] or open_roles


def _place_turns_by_cells(
    columns: list[Chosen], table: layout.Layout, choice: Choice, faults: Faults
) -> None:
    """Read the only column without a place that can contain turns or an angle."""
    fits: list[Chosen] = []
    for column in columns:
        if column.cell not in choice.unplaced:
            continue
        texts = [row.texts[column.at] for row in table.rows]
        is_angle = kinds_of(column.header.unit or "") == {"angle"} and not re.search(
            _OF_TILT, column.header.text
        )
        is_angle = is_angle and any(
            not re.fullmatch(r"90(?:\.0*)?", text) for text in texts
        )  # a level rod
        in_turns = roles.counts_turns(column.header) and not _says_little(column.header)
        in_turns &= not roles.is_of_the_spin(column.header.text)
        if is_angle or in_turns or roles.are_turns(column.header, texts):
            fits.append(replace(column, role="angle" if is_angle else "turns"))
    if len(fits) == 1:
        counting = fits[0]
        choice.serve(counting)
        choice.unplaced.remove(counting.cell)
        faults.add("read_by_cells", counting.cell, role=counting.role)


def _place_by_cells_and_unit(
    columns: list[Chosen], table: layout.Layout, choice: Choice, faults: Faults
) -> None:
    """Give the missing role to a column without a known name.

    The cells or the unit of this column must fit, and those of no other column.
    """
    counted = not choice.there.isdisjoint((*roles.COUNTS, *roles.ONE_TURN))
    counted |= any(one.turns for one in choice.used.get("time", ()))
    if not counted:
        _place_turns_by_cells(columns, table, choice, faults)
    there = choice.there | choice.asked
    for role, present in (
        (one.name, one.by_unit_without) for one in roles.TABLE if one.by_unit_without
    ):
        kind = kind_of_role(role)
        fit = [
            one
            for one in columns
            if one.cell in choice.unplaced and kind in kinds_of(one.header.unit or "")
        ]
        fit = [
            one
            for one in fit
            if not _says_little(one.header)
            or roles.suggest_role(one.header.text) == role
        ]
        fit = (
            [column for column in fit if not roles.clock_word(column.cell.text)]
            if len(fit) > 1
            else fit
        )
        if (
            not fit
            or not there.isdisjoint(present)
            or (role == "time" and there.isdisjoint(roles.COUNTS))
        ):
            continue
        text = fit[0].cell.text
        if len(fit) > 1:
            # "Alice's time" and "Bob's time", or "time Alice" and "time Bob", are two
            # readings of one time.
            common = set.intersection(
                *(
                    roles.squeezed_words(roles.split_unit(one.cell.text)[0])
                    for one in fit
                )
            )
            other = role != "time" or not any(
                "time" in roles.name_roles(word)[0] for word in common
            )
        else:
            # "T/2 (s)", "Weight #1 (g)" and "σt (s)" say something else.
            words = roles.squeezed_words(roles.split_unit(text)[0])
            words -= {
                word
                for word in words
                if role == "spin" and re.search(roles.SPINNING, word)
            }
            other = bool(
                words & _OTHER_THINGS or re.match(r"[^\[^]*[0-9]|[σε]\w", text)
            )
            other |= role == "mass" and roles.is_part_of_mass(text)
            # Behind an unknown name, "g" may be its unit.
            bare = [
                one.at
                for one in columns
                if one.cell in choice.unplaced and one.header.unit is None
            ]
            other |= text == fit[0].header.unit and fit[0].at - 1 in bare
            other |= role == "spin" and bool(re.search(roles.PRECESSION, text))
            if role == "position":  # "length is from the centre" says it
                name = rf"(?i)\b{re.escape(roles.split_unit(text)[0].strip())}\b"
                notes = filter(roles.from_centre, captions.texts_of(table.grid))
                other &= not any(re.search(name, note) for note in notes)
        for number, one in enumerate(fit if not other else (), 1):
            choice.serve(
                replace(one, role=role, number=number if len(fit) > 1 else None)
            )
            choice.unplaced.remove(one.cell)
            faults.add(
                "read_by_unit", one.cell, role=role, kind=units.KINDS[kind].words
            )


def may_number(header: Header) -> bool:
    """Return whether a column such as "n" or "count" may number the runs."""
    return header.unit is None and bool(re.fullmatch(r".|(?i:count)", header.text))


def _says_little(header: Header) -> bool:
    """Return whether only a one-letter unit says what a column with an unknown name contains.

    A header that is nothing but a unit, such as "g" next to "cm" and "rpm", has no
    other meaning.
    """
    named = roles.split_unit(header.text)[0].strip() != ""
    return named and header.unit is not None and roles.is_one_letter(header.unit)


def missing_roles(there: set[str], columns: Collection[str], loaded: bool) -> list[str]:
    """Name what a run lacks, or the whole log.

    Of several roles that serve, one that the log has a column of.
    """
    missing: list[str] = []
    if "torque" not in there and loaded:
        load = next(
            (role for role in ("mass", "force", "torque") if role in columns), "mass"
        )
        missing += [load] if there.isdisjoint(("mass", "force")) else []
        missing += ["position"] if "position" not in there and load != "torque" else []
    if not any(there.issuperset(one) for one in roles.SPIN_SETS):
        begun = (
            one for one in roles.SPIN_SETS if not (there | set(columns)).isdisjoint(one)
        )
        missing += [role for role in next(begun, ("spin",)) if role not in there]
    if there.isdisjoint(roles.ONE_TURN):
        whole = [
            role for role in roles.ONE_TURN if role in columns and "time" not in columns
        ]
        missing += (whole[:1] or ["time"]) if "time" not in there else []
        if there.isdisjoint(roles.COUNTS) and not whole:
            missing.append(
                next((role for role in roles.COUNTS if role in columns), "turns")
            )
    return missing


# Quantities that two columns give
# ----------------------------------------------------------------------------------


def with_differences(table: layout.Layout, faults: Faults) -> layout.Layout:
    """Add the times and the periods that follow from other columns.

    A time is the time between the start and the stop of a running clock. A period is
    that of a ball whose turns are timed.

    The columns "spin_turns" with "spin_time_start" and "spin_time_end" are usual for a
    large disk.
    """
    there = {role for header in table.headers for role in header.roles}
    is_plain = (
        len(there) == sum(len(header.roles) for header in table.headers)
        and "spin_turns" not in there
    )
    if is_plain and not there.isdisjoint(roles.TIMINGS):
        return table
    names = {
        squeeze(roles.split_unit(header.text)[0]).lower(): at
        for at, header in enumerate(table.headers)
    }
    free = {
        at: one
        for at, one in enumerate(table.headers)
        if one.unit in (None, "s") and not one.roles
    }
    # Frames of a video are not times.
    free = {
        at: one
        for at, one in free.items()
        if one.unit or any(":" in row.texts[at] for row in table.rows)
    }
    clocks = {roles.clock_word(one.text): at for at, one in free.items()}
    made: list[tuple[str, int, str, list[str]]] = []
    stated = {key.lower(): text.text for key, text in table.grid.metadata}
    if there.isdisjoint(roles.TIMINGS) and {"start", "stop"} <= clocks.keys():
        first = clocks["start"]
        made.append(
            (
                "time [s]",
                clocks["stop"],
                table.cells[first].text,
                [row.texts[first] for row in table.rows],
            )
        )
    counts = next(
        (at for at, header in enumerate(table.headers) if "spin_turns" in header.roles),
        None,
    )
    for word, end in (("start", "start"), ("stop", "end")):
        if (at := names.get(f"spintime{end}")) is not None and (
            counts is not None or "spin_turns" in stated
        ):
            # Instead of a column, a line may give the number of turns for the whole
            # log.
            texts = [
                stated["spin_turns"] if counts is None else row.texts[counts]
                for row in table.rows
            ]
            second = "spin_turns" if counts is None else table.cells[counts].text
            made.append((f"spin_period_{end} [s]", at, second, texts))
        for at, header in enumerate(table.headers):
            # "Time of 10 rotations of the disk, before [s]"
            of_spin = roles.clock_word(header.text) == word and roles.is_of_the_spin(
                header.text
            )
            if of_spin and (turns := turns_in(header.text)):
                made.append(
                    (f"spin_period_{end} [s]", at, turns, [turns] * len(table.rows))
                )
    for name, one, second, others in made:
        sign = "minus" if name == "time [s]" else "over"
        try:
            pairs = [
                (_seconds(row.texts[one]), _seconds(text))
                for row, text in zip(table.rows, others, strict=True)
            ]
            texts = [
                f"{a - b:f}" if sign == "minus" else f"{a / b:.7g}" for a, b in pairs
            ]
        except (DecimalException, IndexError):
            return table
        if any(text.startswith("-") for text in texts):
            return table
        faults.add("read_as", table.cells[one], sign=sign, second=second, name=name)
        width, rows = len(table.cells), []
        for row, text in zip(table.rows, texts, strict=True):
            cells = [*row.texts[:width], text]
            rows.append(
                Row(row.line, cells, (*map(row.spot, range(width)), row.spot(one)))
            )
        header = replace(parse_header(name), text=table.headers[one].text)
        table = layout.Layout(
            table.grid, [*table.cells, table.cells[one]], [*table.headers, header], rows
        )
    return table


def _seconds(text: str) -> Decimal:
    """Read the time of a clock, "12:01:10.25" or "1:10", or a plain number."""
    parts = fold_number(text.partition(" (")[0]).replace(",", ".").split(":")
    return sum(
        (Decimal(part) * 60**at for at, part in enumerate(reversed(parts))), Decimal()
    )


def name_missing(role: str, missing: list[str], choice: Choice) -> tuple[str, str]:
    """Return what is missing, and every way to add it.

    First a guess from the headers that name no role.
    """
    unit, known = units.DISPLAY[kind_of_role(role)], roles.BY_NAME[role]
    sample = known.sample or f"1 {unit}"
    quoted = f'"{sample}"' if " " in sample else sample
    named = header_of(role, unit)
    hint = f"add a column {named}"
    hint += (
        f'; or a line "# {role}: {sample}"; or --set {role}={quoted}'
        if role != "time"
        else ""
    )
    hint += (
        f"; or --map {role}=HEADER to name the column that contains it{known.instead}"
    )
    texts = [cell.text for cell in choice.unplaced]
    message = f"{role} is missing{f' ({known.meaning})' if known.meaning else ''}"
    if texts and role == missing[0]:
        message += f"; headers that could not be placed: {listing(texts)}"
    if role == "spin" and (rate := choice.used.get("precession_rate")):
        # The lab sheet calls the spin so too.
        header = rate[0].header.text
        return (
            message,
            (
                f'is it "{header}", which is read as the rate of the precession? --map '
                f'spin="{header}"; {hint}'
            ),
        )
    if role == "turns" and "time" in missing:
        return message, hint
    blank = [one for one in texts if re.fullmatch("column [0-9]+", one)]
    fitting = []
    likely_roles = [role, "force"] if role == "mass" else [role]
    for likely in likely_roles:
        kind = kind_of_role(likely)
        fitting += [
            (likely, one)
            for one in texts
            if kind in kinds_of(roles.parse_header(one).unit or "")
        ]
    headers = [
        header
        for header in texts
        if len(header) <= roles.MAX_HEADER and header not in blank
    ]
    timed = [
        header
        for header in headers
        if "time" in kinds_of(roles.parse_header(header).unit or "")
    ]
    told = {
        one: turns_in(one) or "…"
        for one in timed
        if turns_in(one) or re.search(r"(?i)(?<!\w)[0-9]|half", one)
    }
    of_the_rod = [one for one in told if not roles.is_of_the_spin(one)]
    whole = [
        header for header in timed if roles.suggest_role(header) == "precession_period"
    ]
    counts = [
        header for header in headers if roles.counts_weights(roles.parse_header(header))
    ]
    close = [
        one
        for one in headers
        if roles.suggest_role(one) == role and (role != "turns" or one not in timed)
    ]
    if (
        role in ("mass", "spin")
        and len(headers) == len(missing) == 1
        and roles.parse_header(headers[0]).unit is None
    ):
        close = headers
    if role in ("time", "turns") and len(of_the_rod) == 1:
        hint = f'is it --map time="{of_the_rod[0]}" --set turns={told[of_the_rod[0]]}? {hint}'
    elif role == "time" and whole:
        hint = f'is it --map precession_period="{whole[0]}", the time of one whole turn? {hint}'
    elif role == "mass" and (
        parts := [header for header in texts if roles.is_part_of_mass(header)]
    ):
        hint = (
            f'"{parts[0]}" is a part of the mass: write all that hangs on the rod, as '
            f"20.3 or 2 x 10.15; {hint}"
        )
    elif role == "mass" and counts:
        ways = "write their mass instead, in a column mass [g], as 40.3 or 2 x 20.15"
        hint = f'"{counts[0]}" counts weights: {ways}; {hint}'
    elif role == "spin" and (turned := [one for one in told if one not in of_the_rod]):
        hint = (
            f'is it "{turned[0]}"? divide by the turns, and write spin_period [s] (or '
            f"_start, _end); {hint}"
        )
    elif role == "position" and (
        across := [header for header in texts if re.search(roles.WIDE, header)]
    ):
        hint = (
            f'"{across[0]}" is a diameter: write half of each number in a column '
            f"position [cm]; {hint}"
        )
    elif role == "position" and close and re.search(roles.SPHERE, close[0]):
        ways = (
            'from its surface, write also the lines "# position_from: surface" and "# '
            'ball_diameter: 10.16 cm"'
        )
        hint = (
            f'"{close[0]}": if it counts from the centre of the ball, write "{named}" '
            f"instead; if {ways}; {hint}"
        )
    elif close:
        hint = (
            f'is it "{close[0]}"? Write "{named}" '
            f"instead{f', if it is in {unit}' if '[' in named else ''}; {hint}"
        )
    elif len(fitting) == 1 and role != "turns":
        likely, header = fitting[0]
        hint = f'is it --map {likely}="{header}"? {hint}'
    elif blank:
        hint = f'is it {" or ".join(blank)}, without a name? Write "{named}" above it; {hint}'
    return message, hint
