"""The same readings in another order, in other units, or as another quantity that means
the same.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction

from relations.log_tables import (
    Heading,
    LogTable,
    Rewriting,
    is_number,
    named,
    relation,
    shuffled,
    text_relation,
)

SPINS = ("spin", "spin_start", "spin_end")
THIRDS = {
    "1/3": ("0.33333333", "0.333", "120.000000", "one third", "⅓"),
    "2/3": ("0.66666667", "0.667", "240.000000", "two thirds", "⅔"),
}


# Order


def is_in_free_order(table: LogTable) -> bool:
    """Return whether the order means nothing: an unloaded run has the balance of the
    weight before it.
    """
    loads = {"mass", "force", "torque"}.intersection(table.roles)
    return not any("0" in table.cells(load) for load in loads)


@text_relation
def rows_in_reverse_order(table: LogTable) -> str | None:
    if not is_in_free_order(table):
        return None
    return replace(table, rows=table.rows[::-1]).text


@text_relation
def rows_shuffled(table: LogTable) -> str | None:
    if not is_in_free_order(table):
        return None
    return replace(table, rows=tuple(shuffled(table.rows))).text


def in_order_of(table: LogTable, role: str) -> LogTable:
    cells = [float(cell or 0) for cell in table.cells(role)]
    order = sorted(range(len(cells)), key=cells.__getitem__)
    return replace(table, rows=tuple(table.rows[at] for at in order))


@text_relation
def rows_in_order_of_spin(table: LogTable) -> str | None:
    if not is_in_free_order(table):
        return None
    role = next(role for role in SPINS if role in table.roles)
    return in_order_of(table, role).text


@text_relation
def columns_in_reverse_order(table: LogTable) -> str:
    columns = list(zip(table.headings, zip(*table.rows, strict=True), strict=True))
    return table.of_columns(columns[::-1]).text


@text_relation
def columns_shuffled(table: LogTable) -> str:
    columns = zip(table.headings, zip(*table.rows, strict=True), strict=True)
    return table.of_columns(shuffled(columns)).text


@text_relation
def constants_in_reverse_order(table: LogTable) -> str | None:
    return (
        replace(table, constants=table.constants[::-1]).text
        if len(table.constants) > 1
        else None
    )


# Units that differ by a power of ten: the digits stay the same


def shifted(cell: str, power: int) -> str:
    """Move the decimal point, with the same resolution: zeros that were not read go
    into the exponent.
    """
    mantissa, _, own = cell.partition("e")
    if own:
        return f"{mantissa}e{int(own) + power}"
    number = Decimal(cell).scaleb(power)
    return f"{number:f}" if number.as_tuple().exponent <= 0 else f"{cell}e{power}"


def by_powers_of_ten(role: str, unit: str, to: str, power: int) -> None:
    def rewritten(table: LogTable) -> Rewriting | None:
        if role not in table.roles or table.unit(role) != unit:
            return None
        cells = table.with_cells(role, lambda cell: shifted(cell, power)).cells(role)
        return Rewriting(
            table.with_column(Heading(role, to), cells, instead_of=role).text
        )

    named(f"{role} in {to}", rewritten)


by_powers_of_ten("position", "cm", "mm", 1)
by_powers_of_ten("position", "cm", "m", -2)
by_powers_of_ten("mass", "g", "kg", -3)
by_powers_of_ten("mass", "g", "mg", 3)
by_powers_of_ten("time", "s", "ms", 3)
by_powers_of_ten("torque", "mN*m", "N*m", -3)
by_powers_of_ten("transverse_inertia", "kg*m^2", "g*cm^2", 7)


# Other units: the numbers get so many digits, in both logs, that none of them is
# rounded


def exact(value: float) -> str:
    """Write a number with 14 digits."""
    decimals = 13 - math.floor(math.log10(abs(value))) if value else 0
    return f"{value:.{max(decimals, 0)}f}"


def with_more_digits(table: LogTable, *roles: str) -> LogTable:
    for role in roles:
        table = table.with_cells(
            role, lambda cell: exact(float(cell)) if is_number(cell) else cell
        )
    return table


def by_factor(
    name: str, roles: tuple[str, ...], unit: str, to: str, factor: float
) -> None:
    def rewritten(table: LogTable) -> Rewriting | None:
        used = [
            role for role in roles if role in table.roles and table.unit(role) == unit
        ]
        if not used:
            return None
        table = changed = with_more_digits(table, *used)
        for role in used:
            cells = [
                exact(float(cell) * factor) if cell else ""
                for cell in table.cells(role)
            ]
            changed = changed.with_column(Heading(role, to), cells, instead_of=role)
        return Rewriting(changed.text, same_as=table)

    named(name, rewritten)


WITH_U = (*SPINS, "u_spin")
by_factor("position in inches", ("position",), "cm", "in", 1 / 2.54)
by_factor("position in feet", ("position",), "cm", "ft", 1 / 30.48)
by_factor("mass in ounces", ("mass",), "g", "oz", 1 / 28.349523125)
by_factor("mass in pounds", ("mass",), "g", "lb", 1 / 453.59237)
by_factor("spin in Hz", WITH_U, "rpm", "Hz", 1 / 60)
by_factor("spin in rev/s", WITH_U, "rpm", "rev/s", 1 / 60)
by_factor("spin in rad/s", WITH_U, "rpm", "rad/s", math.pi / 30)
by_factor("spin in deg/s", WITH_U, "rpm", "deg/s", 6.0)
by_factor("time in min", ("time",), "s", "min", 1 / 60)
by_factor("angle in rad", ("angle",), "deg", "rad", math.pi / 180)
by_factor("pitch in rad", ("pitch",), "deg", "rad", math.pi / 180)
by_factor("rate in rpm", ("precession_rate",), "rad/s", "rpm", 30 / math.pi)
by_factor("rate in deg/s", ("precession_rate",), "rad/s", "deg/s", 180 / math.pi)
by_factor("torque in g*cm", ("torque",), "mN*m", "gf*cm", 1 / 0.0980665)


def as_period(role: str, period: str, seconds: float, unit: str, named_as: str) -> None:
    """Write rates as the time of one turn; `seconds` is the time of one turn at a rate
    of 1.
    """

    def rewritten(table: LogTable) -> Rewriting | None:
        used = [
            name
            for name in table.roles
            if name in (role, f"{role}_start", f"{role}_end")
        ]
        stated = {*table.roles, *dict(table.constants)}
        # An uncertainty of the rate is not one of the time of a turn.
        if not used or stated & {f"u_{name}" for name in used}:
            return None
        table = changed = with_more_digits(table, *used)
        for name in used:
            cells = [exact(seconds / float(cell)) for cell in table.cells(name)]
            heading = Heading(name.replace(role, period), unit)
            changed = changed.with_column(heading, cells, instead_of=name)
        return Rewriting(changed.text, same_as=table)

    named(named_as, rewritten)


as_period("spin", "spin_period", 60.0, "s", "spin in s per turn")
as_period("spin", "spin_period", 60e3, "ms", "spin in ms per turn")


@text_relation
def time_as_minutes_and_seconds(table: LogTable) -> str | None:
    if "time" not in table.roles or not all(
        "." in cell for cell in table.cells("time")
    ):
        return None

    def clock(cell: str) -> str:
        minutes, seconds = divmod(Decimal(cell), 60)
        return (
            f"{minutes:02f}:{seconds:05.2f}"
            if -seconds.as_tuple().exponent == 2
            else f"{minutes}:{seconds:04.1f}"
        )

    return table.with_column(
        Heading("time"), map(clock, table.cells("time")), instead_of="time"
    ).text


CONSTANTS_IN_OTHER_UNITS = {
    "ball_mass": ("kg", "g", 3),
    "ball_diameter": ("mm", "cm", -1),
    "position": ("cm", "m", -2),
    "mass": ("g", "kg", -3),
    "g": ("m/s^2", "cm/s^2", 2),
    "u_time": ("s", "ms", 3),
    "u_position": ("mm", "m", -3),
    "u_position_zero": ("m", "mm", 3),
    "u_time_bias": ("s", "ms", 3),
    "u_torque": ("mN*m", "N*m", -3),
}


@text_relation
def constants_in_other_units(table: LogTable) -> str | None:
    changed = table
    for key, value in table.constants:
        number, _, unit = value.partition(" ")
        own, other, power = CONSTANTS_IN_OTHER_UNITS.get(key, ("", "", 0))
        if own and unit == own:
            changed = changed.stating(**{key: f"{shifted(number, power)} {other}"})
    return None if changed == table else changed.text


def latitude_as(name: str, text: str) -> None:
    def rewritten(table: LogTable) -> Rewriting | None:
        stated = dict(table.constants)
        if "g" not in stated or "latitude" in stated:
            return None
        table = replace(
            table, constants=tuple(pair for pair in table.constants if pair[0] != "g")
        )
        return Rewriting(
            table.stating(latitude=text).text,
            same_as=table.stating(latitude="42.5 deg"),
        )

    named(f"latitude {name}", rewritten)


latitude_as("with a sign", "42.5°")
latitude_as("in rad", "0.74176493209759 rad")


# Turns


def thirds_as(
    name: str, kind: int, tolerance: tuple[float, float] = (1e-6, 1e-6)
) -> None:
    def rewritten(table: LogTable) -> Rewriting | None:
        if "turns" not in table.roles or not set(THIRDS).intersection(
            table.cells("turns")
        ):
            return None
        changed = table.with_cells(
            "turns", lambda cell: THIRDS[cell][kind] if cell in THIRDS else cell
        )
        return Rewriting(changed.text, tolerance=tolerance)

    named(f"thirds of a turn {name}", rewritten)


thirds_as("as 0.33333333", 0)
# 0.333 is less than 1/3 by 0.1 %. I_zz can change by more if whole turns are timed too,
# and u contains the rounding, half of a unit of the last digit, once for all such runs.
thirds_as("as 0.333", 1, (2e-3, 3e-2))
thirds_as("in words", 3)
thirds_as("as ⅓", 4)


def in_turns_as(name: str, unit: str, factor: float) -> None:
    def rewritten(table: LogTable) -> Rewriting | None:
        if "turns" not in table.roles or "u_turns" in table.roles:
            return None
        cells = [exact(float(Fraction(cell)) * factor) for cell in table.cells("turns")]
        return Rewriting(
            table.with_column(Heading("angle", unit), cells, instead_of="turns").text
        )

    named(f"turns in {name}", rewritten)


in_turns_as("deg", "deg", 360.0)
in_turns_as("rad", "rad", 2 * math.pi)


@text_relation
def turns_with_their_word_behind(table: LogTable) -> str | None:
    return (
        table.with_cells("turns", lambda cell: f"{cell} turn").text
        if "turns" in table.roles
        else None
    )


@relation
def angle_as_turns(table: LogTable) -> Rewriting | None:
    if "angle" not in table.roles or table.unit("angle") != "deg":
        return None
    cells = [str(Fraction(cell) / 360) for cell in table.cells("angle")]
    same = with_more_digits(table, "angle")
    return Rewriting(
        table.with_column(Heading("turns"), cells, instead_of="angle").text,
        same_as=same,
    )


# Other quantities that mean the same


@relation
def masses_doubled_and_positions_halved(table: LogTable) -> Rewriting | None:
    """The errors that runs share are stated as a part of the reading: only then do they
    mean the same.
    """
    if not {"mass", "position", "time"} <= set(table.roles):
        return None
    shares = {"u_mass": "0.2 %", "u_position": "0.1 %", "u_position_zero": "0.2 %"}
    table = with_more_digits(table, "mass", "position").stating(**shares)
    changed = table.with_cells("mass", lambda cell: exact(2 * float(cell)))
    return Rewriting(
        changed.with_cells("position", lambda cell: exact(float(cell) / 2)).text,
        same_as=table,
    )


@text_relation
def time_1_without_a_second_time(table: LogTable) -> str | None:
    if "time" not in table.roles:
        return None
    first = table.with_column(
        Heading("time_1", "s"), table.cells("time"), instead_of="time"
    )
    return first.with_column(Heading("time_2", "s"), [""] * len(table.rows)).text


@relation
def repeats_in_the_other_order(table: LogTable) -> Rewriting | None:
    if "time" not in table.roles:
        return None
    times = table.cells("time")
    later = [
        f"{Decimal(cell) + Decimal(at % 3 - 1) / 10}" for at, cell in enumerate(times)
    ]

    def repeats(first: list[str], second: list[str]) -> LogTable:
        one = table.with_column(Heading("time_1", "s"), first, instead_of="time")
        return one.with_column(Heading("time_2", "s"), second)

    return Rewriting(repeats(later, times).text, same_as=repeats(times, later))


def with_a_derived_column(
    heading: Heading, formula: Callable[[float, float], float], first: str, second: str
) -> None:
    def rewritten(table: LogTable) -> Rewriting | None:
        if (
            not {first, second, "time"} <= set(table.roles)
            or heading.role in table.roles
        ):
            return None
        pairs = zip(table.cells(first), table.cells(second), strict=True)
        numbers = [
            (float(Fraction(a)), float(Fraction(b))) if a and b else None
            for a, b in pairs
        ]
        cells = [f"{formula(*pair):.5g}" if pair else "" for pair in numbers]
        return Rewriting(table.with_column(heading, cells).text)

    named(f"with a column of the {heading}", rewritten)


with_a_derived_column(
    Heading("precession_period", "s"), lambda time, turns: time / turns, "time", "turns"
)
with_a_derived_column(
    Heading("precession_rate", "rad/s"),
    lambda time, turns: 2 * math.pi * turns / time,
    "time",
    "turns",
)
with_a_derived_column(
    Heading("torque", "N m"),
    lambda mass, arm: 9.803e-5 * mass * arm,
    "mass",
    "position",
)
