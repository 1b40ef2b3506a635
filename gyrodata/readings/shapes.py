"""Make one row for each run of tables in other shapes.

The tables are transposed, crossed, in sentences, or with counted weights.
"""

from __future__ import annotations

import re
from itertools import groupby, pairwise, takewhile

from msgspec.structs import replace

from gyrodata.quantities import notation, vocabulary
from gyrodata.quantities.units import UnitError, kinds_of
from gyrodata.readings import layout, roles
from gyrodata.readings.grid import (
    HEADERS_LOOKED_AT,
    Grid,
    Row,
    filled_at,
    is_bare,
    is_head,
    is_number,
)
from gyrodata.readings.lablog import Fall, Faults, listing
from gyrodata.readings.layout import (
    SAID_KINDS,
    said_in,
)
from gyrodata.readings.roles import parse_header, squeeze
from gyrodata.readings.workbook import MAX_COLUMNS


def reshape(grid: Grid, faults: Faults) -> tuple[Grid, tuple[Fall, ...]]:
    """Return the table with one row for each run, if its shape is another one.

    Parameters
    ----------
    grid : Grid
        What was read. The function replaces counts of weights by masses in place.
    faults : Faults
        Receives a note on each change.

    Returns
    -------
    Grid
        The same one if the table has the usual shape.
    tuple of Fall
        What a second table, of time and spin, says of the spin-down; empty if there is
        none.
    """
    grid = _uncrossed(_stacked(grid, faults), faults)
    _weigh(grid, faults)
    heads = [row for row in grid.rows if is_head(row)]
    if not heads and (blocks := _turned_blocks(grid, faults)):
        return _split_spin_down(replace(grid, rows=blocks))
    if not any(map(layout.names_quantities, heads)) and (
        sentences := _rows_of_sentences(grid)
    ):
        return _split_spin_down(replace(grid, rows=sentences))
    return _split_spin_down(grid if heads else _turned_into_table(grid, faults))


_ONE_WEIGHT = re.sub(r"([sne])(?=\||$)", r"\1?", vocabulary.words("weights", "|"))
_MASS = rf"({notation.NUMBER}\s*k?g)\b"
_MASS_OF_ONE = (
    rf"(?i)\b(?:{vocabulary.words('each', '|')})\W+(?:\w+\W+)?"
    rf"(?:{_ONE_WEIGHT})\b[^0-9;]{{0,20}}?{_MASS}"
    rf"|(?<![0-9]){_MASS}\s*(?:{vocabulary.words('each', '|')})\b"
)
_IN_HEADER = (
    rf"(?i)(?:[\[(]\s*|(?<!\s)\s+)?(?:\b(?:{vocabulary.words('with').replace(' ', '|')}"
    rf"|[mMxr])\s*(?:[=:]\s*)?)?"
    rf"(?<![\w.,/])({notation.NUMBER})\s*([^\W\d_][^\s,;)\]]*)\s*[\])]?"
)
"""A quantity in a header, with its brackets and small words: "(20 g)", "with 20 g", "m
= 20 g"."""
_CORNER = r"(?:(?<!\s)\s+)?(?:\\|↓|→|\||\s/\s|\bvs\b)\s*"
"""Marks between the names of rows and columns in the corner of a table."""


def _uncrossed(grid: Grid, faults: Faults) -> Grid:
    """Make a row of each cell of a table of times whose header contains a quantity of each run.

    Such headers are "20 g" and "40 g"; "time (s) with 20 g"; or 20 and 40 below "mass
    (g)", or behind it.
    """
    for index, head in enumerate(grid.rows[:HEADERS_LOOKED_AT]):
        groups: dict[tuple[str, str], dict[int, str]] = {}
        for at in filled_at(head):
            match = re.search(_IN_HEADER, head.texts[at])
            role = next(
                (
                    role
                    for kind, role in SAID_KINDS.items()
                    if match and kind in kinds_of(match[2])
                ),
                "",
            )
            if match and role:
                name = (
                    f"{head.texts[at][: match.start()].strip()} "
                    f"{head.texts[at][match.end() :].strip()}"
                ).strip()
                groups.setdefault((role, name), {})[at] = f"{match[1]} {match[2]}"
        bare = {
            at: head.texts[at] for at in filled_at(head)[1:] if is_bare(head.texts[at])
        }
        above = [text for text in grid.rows[index - 1].texts if text] if index else []
        above = re.split(_CORNER, head.texts[0])[1:] or above
        if (
            len(bare) > 1
            and not groups
            and len(above) == 1
            and parse_header(above[0]).unit
        ):
            groups = {(role, above[0]): bare for role in parse_header(above[0]).roles}
        if len(groups) != 1 or len(set(*map(dict.values, groups.values()))) < 2:
            continue
        [((role, name), cells)] = groups.items()
        below = list(
            takewhile(
                lambda row: any(map(is_number, row.texts[1:])), grid.rows[index + 1 :]
            )
        )
        texts = [
            text
            for row in (*grid.rows[index::-1], *grid.rows[index + 1 + len(below) :])
            for text in row.texts
        ]
        texts = [name, *(text.text for text in grid.comments), *texts]
        parts = [
            part for text in texts for part in (*re.split(r"[,;:.]\s+", text), text)
        ]
        timed = [
            part
            for part in parts
            if not {*parse_header(part).roles}.isdisjoint(roles.TIMINGS)
        ]
        time = max(
            timed, key=lambda part: parse_header(part).unit is not None, default=""
        )
        # The label of a row may contain its quantities: "200 rpm".
        cornered = not head.texts[0] or head.texts[0] == time
        labels = [
            said_in(Row(row.line, row.texts[:1])) if row.texts[0] else {}
            for row in below
            if cornered
        ]
        of_label = list(labels[0]) if labels else []
        others = [
            at
            for at in filled_at(head)
            if at not in cells and not (at == 0 and cornered)
        ]
        names = [*of_label, *(re.split(_CORNER, head.texts[at])[0] for at in others)]
        named = {found for text in names for found in parse_header(text).roles}
        if (
            not time
            or role in named
            or named.isdisjoint(roles.ROLES)
            or any(list(one) != of_label for one in labels)
        ):
            continue
        spots = tuple(
            map(head.spot, (*[0] * len(of_label), *others, min(cells), min(cells)))
        )
        rows = [Row(head.line, [*names, name if cells is bare else role, time], spots)]
        for number, row in enumerate(below):
            texts = [*row.texts, *[""] * (max(cells) + 1 - len(row.texts))]
            label = [text for text, _ in labels[number].values()] if labels else []
            for at, quantity in (
                (at, quantity) for at, quantity in cells.items() if texts[at]
            ):
                spots = (
                    *[row.spot(0)] * len(label),
                    *map(row.spot, others),
                    head.spot(at),
                    row.spot(at),
                )
                rows.append(
                    Row(
                        row.line,
                        [
                            *label,
                            *(texts[other] for other in others),
                            quantity,
                            texts[at],
                        ],
                        spots,
                    )
                )
        faults.add(
            "crossed",
            grid.cell(head, min(cells)),
            line=[head.line],
            role=role,
            time=time,
        )
        start = index - (cells is bare and above[0] in grid.rows[index - 1].texts)
        rest = grid.rows[index + 1 + len(below) :]
        return _uncrossed(
            replace(grid, rows=[*grid.rows[:start], *rows, *rest]), faults
        )
    return grid


_NUMBER_OF_RUN = r"(?:(?<![\s_#])[\s_#]+)?[1-9][0-9]?(?=\s*(?:[\[(].*)?$)"


def _stacked(grid: Grid, faults: Faults) -> Grid:
    """Make a row for each run of a table with several runs in a row.

    An example is "mass, rpm 1, time 1, rpm 2, time 2".
    """
    for index, head in enumerate(grid.rows[:HEADERS_LOOKED_AT]):
        names = [re.sub(_NUMBER_OF_RUN, "", text) for text in head.texts]
        places: dict[str, list[int]] = {}
        for at in filled_at(head):
            places.setdefault(squeeze(names[at]).lower(), []).append(at)
        several = [of_name for of_name in places.values() if len(of_name) > 1]
        shared = [of_name[0] for of_name in places.values() if len(of_name) == 1]
        of_all = {role for at in shared for role in parse_header(names[at]).roles} - {
            "run"
        }
        found = {
            role
            for of_name in several
            for role in parse_header(names[of_name[0]]).roles
        }
        is_wide = (
            "spin" in found
            and not found.isdisjoint(roles.TIMINGS)
            and len(set(map(len, several))) == 1
        )
        if not is_wide or not of_all or len(several) < 2:
            continue
        if any(
            max(one) > min(other) for one, other in pairwise(zip(*several, strict=True))
        ):
            continue  # "n1, n2, t1, t2" has the spin before and after
        below = list(
            takewhile(
                lambda row: any(map(is_number, row.texts[1:])), grid.rows[index + 1 :]
            )
        )
        groups = [(*shared, *group) for group in zip(*several, strict=True)]
        rows = [
            Row(
                head.line,
                [names[at] for at in groups[0]],
                tuple(map(head.spot, groups[0])),
            )
        ]
        for row in below:
            texts = [*row.texts, *[""] * (len(head.texts) - len(row.texts))]
            rows += [
                Row(row.line, [texts[at] for at in group], tuple(map(row.spot, group)))
                for group in groups
                if any(texts[at] for at in group[len(shared) :])
            ]
        faults.add(
            "stacked",
            grid.cell(head, min(several[0])),
            line=[head.line],
            count=len(groups),
        )
        return replace(
            grid, rows=[*grid.rows[:index], *rows, *grid.rows[index + 1 + len(below) :]]
        )
    return grid


def _weigh(grid: Grid, faults: Faults) -> None:
    """Replace a count of weights by their mass.

    A text must state the mass of one weight, such as "one washer = 8.3 g".
    """
    heads = [row for row in grid.rows if is_head(row)]
    named = ((head, at) for head in heads for at in filled_at(head))
    counting = [
        (head, at)
        for head, at in named
        if roles.counts_weights(parse_header(head.texts[at]))
    ]
    texts = [
        *(text.text for text in grid.comments),
        *(" ".join(row.texts) for row in grid.rows),
    ]
    masses = {
        match[1] or match[2]
        for text in texts
        if counting
        for match in re.finditer(_MASS_OF_ONE, text)
    }
    if len(masses) != 1:
        return
    for head, at in counting:
        cells = [
            row
            for row in grid.rows
            if row is not head and row.texts[at : at + 1] and row.texts[at].isdecimal()
        ]
        said = f"1 of {head.texts[at]} is {min(masses)}"
        faults.add("name_explained", grid.cell(head, at), said=said)
        head.texts[at] = "mass"
        for row in cells:
            row.texts[at] = (
                f"{row.texts[at]} x {min(masses)}" if row.texts[at] != "0" else "0 g"
            )


def _turned_blocks(grid: Grid, faults: Faults) -> list[Row]:
    """Turn each of several tables with the same names at the side, below their captions.

    None if there are not two.
    """
    parts = groupby(
        grid.rows,
        lambda row: (
            sum(map(is_bare, row.texts[1:])) > 1 and not is_number(row.texts[0])
        ),
    )
    blocks = [(is_table, list(rows)) for is_table, rows in parts]
    if (
        sum(
            is_table and is_head(Row(0, [row.texts[0] for row in rows]))
            for is_table, rows in blocks
        )
        < 2
    ):
        return []
    turned = [
        _turned_into_table(replace(grid, rows=of), faults).rows if is_table else of
        for is_table, of in blocks
    ]
    return [row for rows in turned for row in rows]


def _turned_into_table(grid: Grid, faults: Faults) -> Grid:
    """Make a table of one whose names are at the side; a single value is valid for all runs."""
    width = max(len(row.texts) for row in grid.rows)
    of_one_cell = (row for row in grid.rows if len(filled_at(row)) == 1)
    said = [
        row for row in of_one_cell if said_in(row) or " " in "".join(row.texts).strip()
    ]
    of_table = [row for row in grid.rows if row not in said]
    side = min((filled_at(row)[0] for row in of_table), default=0)
    names = Row(0, [row.texts[side] for row in of_table])
    if not is_head(names):
        return grid
    faults.add("turned", grid.cell(of_table[0], side), names=listing(names.texts, 3))
    rows = []
    for at in range(side, width):
        places = [
            (row, side + 1 if at > side and len(row.texts) == side + 2 < width else at)
            for row in of_table
        ]
        texts = ["".join(row.texts[k : k + 1]) for row, k in places]
        rows.append(
            Row(of_table[0].line, texts, tuple(row.spot(k) for row, k in places))
        )
    return replace(grid, rows=[*said, *(row for row in rows if any(row.texts))])


_SENTENCE_ROLES = ("mass", "position", "spin", "turns", "time")


def _rows_of_sentences(grid: Grid) -> list[Row]:
    """Make a table of lines that contain quantities.

    An example is "20.1 g, 400 rpm: one turn took 12.3 s". There may also be one line
    for each quantity.

    A line with a spin and a time is a run. Other lines are captions of the runs below
    them.
    """
    parts: list[tuple[int, str, layout.Given]] = []
    block: list[tuple[int, str, layout.Given]] = []
    # The commas of "215,392,582" separate cells.
    lines = [
        re.sub(
            r"(?<![0-9.])[0-9.]++(?:,[0-9.]++){2,}",
            lambda cells: cells[0].replace(",", " "),
            line,
        )
        for line in grid.lines[grid.rows[0].line - 1 : grid.rows[-1].line]
    ]
    runs_in_lines = (
        (number, one)
        for number, line in enumerate(lines, grid.rows[0].line)
        for one in _runs_in(line)
    )
    for number, line in (*runs_in_lines, (grid.rows[-1].line + 1, "")):
        said = said_in(
            Row(number, [re.sub(r"^\s*\(?[0-9]{1,2}[.):、]\s+", "", line)]),
            with_time=True,
        )
        matches = re.finditer(layout.QUANTITY, line)
        spins = [
            match[0] for match in matches if kinds_of(match[2] or match[3]) == {"rate"}
        ]
        if len(spins) == 2 and "time" in said:
            said |= {
                "spin_start": (spins[0], 0),
                "spin_end": (spins[1], 0),
                "spin": ("", 0),
            }
        if {"spin", "time"} <= said.keys() and "turns" not in said:
            part = roles.words_of_turns(
                re.split("[0-9]", line)[-1].rstrip(" .;,)")
            )  # "9.97 s for a third"
            said |= {"turns": (part, 0)} if "/" in part else {}
        if line.lstrip().startswith("#") and {"spin", "time"} <= said.keys():
            continue  # a run that was taken out
        if said:
            block.append((number, line, said))
            continue
        names = [name for *_, one in block for name in one]
        if len(set(names)) == len(names) and {"spin", "time"} <= set(names):
            block = [
                (
                    block[0][0],
                    "",
                    {name: item for *_, one in block for name, item in one.items()},
                )
            ]
        parts += [*block, (number, line, {})] if line.strip() else block
        block = []
    runs = [said for *_, said in parts if {"spin", "time"} <= said.keys()]
    if len(runs) < 2:
        return []
    there = [
        role
        for role in _SENTENCE_ROLES
        if any(said.get(role, ("",))[0] for said in runs)
    ]
    there += sorted(
        {role for said in runs for role in said if role.startswith(("time_", "spin_"))}
    )
    rows: list[Row] = []
    begun = False
    for number, text, said in parts:
        words, is_run = " ".join(text.split()), {"spin", "time"} <= said.keys()
        if not is_run or re.search(layout.NOT_USED, words):
            rows.append(Row(number, ["#", words] if is_run else [words]))
            begun &= is_run
            continue
        rows += [] if begun else [Row(number, list(there))]
        begun = True
        spots = (number * MAX_COLUMNS,) * len(there)
        rows.append(Row(number, [said.get(role, ("", 0))[0] for role in there], spots))
    return rows


def _runs_in(line: str) -> list[str]:
    """Split a line of several runs: "M1 = 40 g: (184 rpm; 9.0 s), (390 rpm.

    19.3 s)" is a caption and two runs.
    """
    found = [
        (match.start(), kinds_of(match[2] or match[3]))
        for match in re.finditer(layout.QUANTITY, line)
    ]
    places = {
        kind: [at for at, kinds in found if kind in kinds] for kind in ("rate", "time")
    }
    spins, times = places["rate"], places["time"]
    first, other = (spins, times) if spins[:1] < times[:1] else (times, spins)
    if len(spins) < 2 or sorted(spins + times) != [
        at for pair in zip(first, other, strict=False) for at in pair
    ]:
        return [line]
    return [
        line[: first[0]],
        *(line[start:end] for start, end in pairwise([*first, len(line)])),
    ]


def _split_spin_down(grid: Grid) -> tuple[Grid, tuple[Fall, ...]]:
    """Take a table of time and spin out of a log.

    The table has at least three rows, and the log contains another table as well.

    Returns
    -------
    Grid
        The other rows.
    tuple of Fall
        Empty if there is no such table.
    """
    heads = [
        at
        for at, row in enumerate(grid.rows)
        if len(filled_at(row)) > 1 and not any(map(is_number, row.texts))
    ]
    if len(heads) < 2:
        return grid, ()
    for at in heads:
        headers = {
            place: parse_header(grid.rows[at].texts[place])
            for place in filled_at(grid.rows[at])
        }
        columns = {
            header.roles: (place, header.unit) for place, header in headers.items()
        }
        last = next(
            (
                n
                for n in range(at + 1, len(grid.rows))
                if n in heads or filled_at(grid.rows[n]) != list(headers)
            ),
            None,
        )
        rows = grid.rows[at + 1 : last]
        if len(headers) != 2 or set(columns) != {("time",), ("spin",)} or len(rows) < 3:
            continue
        try:
            times, spins = (
                [
                    abs(notation.read_cell(row.texts[place], kind, unit).value)
                    for row in rows
                ]
                for (place, unit), kind in (
                    (columns[("time",)], "time"),
                    (columns[("spin",)], "rate"),
                )
            )
        except UnitError:
            continue
        # In a table of runs with one weight, a faster spin has a longer time.
        if sorted(set(times)) != times or spins[-1] >= spins[0]:
            continue
        # Three long falls: the noise of the readings then does not matter.
        ends = [*range(0, len(times) - 1, -(-(len(times) - 1) // 3)), len(times) - 1]
        falls = [(spins[a], spins[b], times[b] - times[a]) for a, b in pairwise(ends)]
        # A title of one cell, or the name of a sheet, belongs to the table.
        first = at - 1 if at and len(filled_at(grid.rows[at - 1])) == 1 else at
        return replace(
            grid, rows=grid.rows[:first] + grid.rows[at + 1 + len(rows) :]
        ), tuple(falls)
    return grid, ()
