"""The same table in another layout, with texts around it, or with cells that point to
others.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from relations.log_tables import (
    LogTable,
    Rewriting,
    named,
    relation,
    separated,
    text_relation,
)


def by_mass(table: LogTable) -> dict[str, LogTable]:
    """Give the runs of each weight, without the column of the mass."""
    masses = list(dict.fromkeys(table.cells("mass"))) if "mass" in table.roles else []
    rows = zip(table.cells("mass"), table.rows, strict=True) if masses else []
    pairs = list(rows)
    parts = {mass: tuple(row for own, row in pairs if own == mass) for mass in masses}
    return {
        mass: replace(table, rows=part).without("mass") for mass, part in parts.items()
    }


# Texts around the table


@text_relation
def constants_below_the_table(table: LogTable) -> str:
    return separated(table.grid) + table.above


@text_relation
def constants_between_the_rows(table: LogTable) -> str:
    head, *rows = separated(table.grid).splitlines(keepends=True)
    return head + "".join(rows[:2]) + table.above + "".join(rows[2:])


@text_relation
def constants_in_cells_without_a_hash(table: LogTable) -> str | None:
    return (
        separated([[*pair] for pair in table.constants] + table.grid)
        if table.constants
        else None
    )


@text_relation
def constants_with_a_colon_and_without_a_hash(table: LogTable) -> str | None:
    return (
        table.above.replace("# ", "") + separated(table.grid)
        if table.constants
        else None
    )


@text_relation
def constants_with_an_equals_sign(table: LogTable) -> str | None:
    lines = "".join(f"# {key} = {value}\n" for key, value in table.constants)
    return lines + separated(table.grid) if lines else None


@relation
def constants_as_options(table: LogTable) -> Rewriting | None:
    settings = {key: value for key, value in table.constants if key != "station"}
    return Rewriting(separated(table.grid), settings=settings) if settings else None


@text_relation
def titles_above(table: LogTable) -> str:
    return "Gyroscope lab\nMeasurements on Tuesday\n\n" + table.text


@text_relation
def blank_lines_between_the_rows(table: LogTable) -> str:
    head, *rows = separated(table.grid).splitlines()
    return table.above + "\n" + "\n\n".join([head, *rows]) + "\n\n\n"


@text_relation
def remarks_between_the_rows(table: LogTable) -> str:
    head, *rows = separated(table.grid).splitlines()
    return table.above + head + "\n" + "\n# the fan was off\n".join(rows) + "\n"


@text_relation
def header_repeated_below_the_rows(table: LogTable) -> str:
    head, *rows = separated(table.grid).splitlines()
    return table.above + "\n".join([head, *rows[:3], head, *rows[3:]]) + "\n"


def with_a_summary(name: str) -> None:
    def rewritten(table: LogTable) -> Rewriting | None:
        if "time" not in table.roles or "run" in table.roles:
            return None
        times = [float(cell) for cell in table.cells("time")]
        mean = f"{sum(times) / len(times):.3f}"
        row = [mean if role == "time" else "" for role in table.roles]
        return Rewriting(table.above + separated([*table.grid, [name, *row[1:]]]))

    named(f"with a last row {name}", rewritten)


with_a_summary("Mean")
with_a_summary("Average")


# Cells that point to others


def filled_down(table: LogTable, mark: str, *roles: str) -> LogTable | None:
    """Write a mark in place of each cell that is the same as the one above."""
    changed = table
    for role in roles:
        if role in table.roles and "" not in table.cells(role):
            cells = table.cells(role)
            marked = [
                mark if at and cell == cells[at - 1] else cell
                for at, cell in enumerate(cells)
            ]
            changed = changed.with_column(
                table.headings[table.roles.index(role)], marked, instead_of=role
            )
    return None if changed == table else changed


@text_relation
def blank_cells_below_a_mass(table: LogTable) -> str | None:
    changed = filled_down(table, "", "mass")
    return changed.text if changed else None


@text_relation
def blank_cells_below_a_position(table: LogTable) -> str | None:
    changed = filled_down(table, "", "position")
    return changed.text if changed else None


def in_cells(heading_with_unit: bool) -> Callable[[LogTable], str]:
    def rewritten(table: LogTable) -> str:
        changed = table
        for heading in table.headings:
            if heading.unit and not heading.role.startswith("u_"):
                cells = [
                    f"{cell} {heading.unit}".strip() if cell else ""
                    for cell in table.cells(heading.role)
                ]
                own = heading if heading_with_unit else heading._replace(unit="")
                changed = changed.with_column(own, cells, instead_of=heading.role)
        return changed.text

    return rewritten


named(
    "units in the cells",
    lambda table: Rewriting(in_cells(heading_with_unit=False)(table)),
)
named(
    "units in the cells and in the headers",
    lambda table: Rewriting(in_cells(heading_with_unit=True)(table)),
)


# Several tables


def in_parts(count: int) -> None:
    def rewritten(table: LogTable) -> Rewriting:
        size = -(-len(table.rows) // count)
        parts = [table.rows[at : at + size] for at in range(0, len(table.rows), size)]
        texts = [separated([table.grid[0], *map(list, part)]) for part in parts]
        return Rewriting(table.above + "\n".join(texts))

    named(f"in {count} tables", rewritten)


in_parts(2)
in_parts(3)


@text_relation
def one_table_for_each_weight(table: LogTable) -> str | None:
    parts = by_mass(table)
    if len(parts) < 2 or "0" in parts:
        return None
    return table.above + "\n".join(
        f"Weight: {mass} g\n{separated(part.grid)}" for mass, part in parts.items()
    )


@text_relation
def blank_column_and_row_before_the_table(table: LogTable) -> str:
    return table.above + separated(
        [[""] * (len(table.headings) + 1), *(["", *row] for row in table.grid)]
    )


@text_relation
def rows_that_a_note_excludes(table: LogTable) -> str | None:
    if "time" not in table.roles or "note" in table.roles:
        return None
    at = table.roles.index("time")
    odd = list(table.rows[0])
    odd[at] = f"{2.2 * float(odd[at]):.2f}"
    if "run" in table.roles:
        odd[table.roles.index("run")] = str(len(table.rows) + 1)
    head, *rows = [[*row, ""] for row in table.grid]
    head[-1] = "note"
    return table.above + separated([head, *rows[:4], [*odd, "do not use"], *rows[4:]])
