"""The same columns with other headers, and beside columns that are no part of the
measurement.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from sheets import LANGUAGES

from relations.log_tables import (
    Heading,
    LogTable,
    Rewriting,
    named,
    separated,
    text_relation,
)

ROLES = ("mass", "position", "spin", "time", "turns")


def with_headers(
    table: LogTable, header: Callable[[Heading], str], delimiter: str = ","
) -> str:
    names = [header(heading) for heading in table.headings]
    return table.above + separated([names, *map(list, table.rows)], delimiter)


def styled(name: str, style: str, delimiter: str = ",") -> None:
    def rewritten(table: LogTable) -> Rewriting:
        def header(heading: Heading) -> str:
            return (
                style.format(heading.role.replace("_", " "), heading.unit)
                if heading.unit
                else heading.role
            )

        return Rewriting(with_headers(table, header, delimiter))

    named(f"headers {name}", rewritten)


styled("name (unit)", "{} ({})")
styled("name / unit", "{} / {}")
styled("name, unit", "{}, {}", ";")
styled("name in unit", "{} in {}")
styled("name[unit]", "{}[{}]")


@text_relation
def headers_name_unit_with_a_line_between(table: LogTable) -> str | None:
    """Units with signs are not written so."""
    if not all(heading.unit.isalpha() for heading in table.headings if heading.unit):
        return None
    return with_headers(
        table, lambda heading: f"{heading.role}_{heading.unit}".removesuffix("_")
    )


@text_relation
def headers_with_capitals(table: LogTable) -> str:
    return with_headers(
        table, lambda heading: str(heading._replace(role=heading.role.upper()))
    )


@text_relation
def headers_with_blanks_around(table: LogTable) -> str:
    return with_headers(table, lambda heading: f"  {heading}  ")


SYNONYMS = {
    "mass": "load",
    "position": "lever arm",
    "spin": "ball speed",
    "time": "stopwatch",
    "turns": "revolutions",
}


@text_relation
def headers_of_other_english_names(table: LogTable) -> str | None:
    if not {"spin", "time"} <= set(table.roles):
        return None
    return with_headers(
        table,
        lambda heading: str(
            heading._replace(role=SYNONYMS.get(heading.role, heading.role))
        ),
    )


def units_below(name: str, style: str) -> None:
    def rewritten(table: LogTable) -> Rewriting:
        units = [
            style.format(heading.unit) if heading.unit else ""
            for heading in table.headings
        ]
        return Rewriting(
            table.above + separated([table.roles, units, *map(list, table.rows)])
        )

    named(f"units in a row below the names, {name}", rewritten)


units_below("plain", "{}")
units_below("in brackets", "[{}]")


def in_language(code: str, header: str) -> None:
    names = dict(zip(ROLES, header.split(","), strict=True))
    units = {"mass": "g", "position": "cm", "spin": "rpm", "time": "s", "turns": ""}

    def rewritten(table: LogTable) -> Rewriting | None:
        local = [heading for heading in table.headings if heading.role in ROLES]
        if len(local) < 3 or any(
            heading.unit != units[heading.role] for heading in local
        ):
            return None
        return Rewriting(
            with_headers(table, lambda heading: names.get(heading.role, str(heading)))
        )

    named(f"headers in the language {code}", rewritten)


for code, (header, *_) in LANGUAGES.items():
    in_language(code, header)


# Columns that are no part of the measurement


def beside(
    name: str, heading: Heading, cell: Callable[[int], str], at: int = -1
) -> None:
    def rewritten(table: LogTable) -> Rewriting | None:
        if heading.role in table.roles:
            return None
        cells = map(cell, range(len(table.rows)))
        return Rewriting(table.with_column(heading, cells, at=at).text)

    named(name, rewritten)


def varying(first: float) -> Callable[[int], str]:
    return lambda at: f"{first + 0.1 * (at % 4):.1f}"


for heading, first in {
    Heading("battery", "V"): 1.5,
    Heading("field", "T"): 0.3,
    Heading("room", "K"): 295.0,
    Heading("temperature", "°C"): 21.4,
    Heading("current", "A"): 0.5,
    Heading("air", "bar"): 2.1,
    Heading("humidity", "%"): 41.0,
    Heading("photodiode", "V"): 0.2,
}.items():
    beside(f"with a column {heading}", heading, varying(first))
beside(
    "with a column battery [V] before the others",
    Heading("battery", "V"),
    varying(1.5),
    at=0,
)
beside(
    "with a column of notes",
    Heading("note"),
    lambda at: ("", "as before", "ball polished")[at % 3],
)
beside("with a blank column", Heading(""), lambda _: "")
beside(
    "with numbers of the rows before the others",
    Heading("run"),
    lambda at: str(at + 1),
    at=0,
)
beside("with the observer", Heading("observer"), lambda at: "AB"[at % 2])


@text_relation
def without_numbers_of_the_rows(table: LogTable) -> str | None:
    return table.without("run").text if "run" in table.roles else None


# Constants and columns


@text_relation
def column_of_one_value_as_a_constant(table: LogTable) -> str | None:
    for role in ("position", "turns", "mass", "pitch"):
        if role in table.roles and len(set(table.cells(role))) == 1:
            value = f"{table.cells(role)[0]} {table.unit(role)}".strip()
            return table.without(role).stating(**{role: value}).text
    return None


@text_relation
def constant_as_a_column(table: LogTable) -> str | None:
    for key, value in table.constants:
        if key in ("position", "mass", "turns"):
            number, _, unit = value.partition(" ")
            kept = tuple(pair for pair in table.constants if pair[0] != key)
            return (
                replace(table, constants=kept)
                .with_column(Heading(key, unit), [number] * len(table.rows))
                .text
            )
    return None
