"""Where in a grid the header, the units and the runs stand; and what is no table of runs at all."""

from __future__ import annotations

import re
from dataclasses import dataclass

from gyrodata.diagnostics import (
    BLOCKS_SIDE_BY_SIDE,
    BLOCKS_STACKED,
    HEADER_PARTED_BY_COMMA,
    HEADER_STANDS_TWICE,
    HEADER_WITHOUT_RUNS,
    NO_HEADER_ROW,
    ROW_IS_ONLY_A_TITLE,
    TABLE_TRANSPOSED,
)
from gyrodata.readings.cells import is_blank
from gyrodata.readings.grid import Grid, Text
from gyrodata.readings.headers import Header, parse_header, with_unit
from gyrodata.readings.lablog import Faults, listing
from gyrodata.readings.roles import squeeze
from gyrodata.units import kinds_of

_LOG = "mass [g],position [cm],spin [rpm],time [s],turns\n"
_ROW = "20,15.0,406,13.06,1/3\n"
_HINT = "the first row names the columns, such as: mass [g], position [cm], spin [rpm], time [s], turns"


@dataclass(frozen=True)
class Layout:
    """A table of runs: its headers, and the rows below them."""

    cells: list[Text]
    """The header row."""
    headers: list[Header]
    """What each of them says, with the unit of a second header row."""
    rows: list[list[Text]]


def find_layout(grid: Grid, faults: Faults) -> Layout | None:
    """Find the header and the rows; None, with diagnostics, where there is no such table."""
    rows = grid.rows
    if not rows:
        faults.add(NO_HEADER_ROW, "there is no table in this log", _HINT)
        return None
    for check in (_is_transposed, _stands_side_by_side, _starts_with_title):
        if check(rows, faults):
            return None
    head = rows[0]
    headers = [parse_header(cell.text) for cell in head]
    if _numbers(head) and _numbers(head) * 2 >= sum(1 for cell in head if cell.text):
        hint = _HINT
        if any(comment.text.count(grid.delimiter) == len(head) - 1 for comment in grid.comments):
            hint = "take the # away from the line with the names of the columns"
        faults.add(
            NO_HEADER_ROW, "there is no header row: the first row holds numbers", hint, head[0].place, len(head[0].text)
        )
        return None
    body = rows[1:]
    if body and _is_unit_row(body[0]):
        headers = _with_units(headers, body[0])
        body = body[1:]
    if (
        _is_parted(head, headers, faults)
        or _repeats_a_header(head, faults)
        or _is_stacked(body, len(head), headers, faults)
    ):
        return None
    if not body:
        faults.add(
            HEADER_WITHOUT_RUNS, "there is a header, but not one run below it", "write one row for each timed run"
        )
        return None
    return Layout(head, headers, body)


def is_number(text: str) -> bool:
    """Tell whether a cell begins like a number."""
    return text[:1].isdigit() or (text[:1] in "+-−.,(" and text[1:2].isdigit())


def _numbers(row: list[Text]) -> int:
    return sum(is_number(cell.text) and not parse_header(cell.text).roles for cell in row)


def _is_transposed(rows: list[list[Text]], faults: Faults) -> bool:
    named = [
        row
        for row in rows[:20]
        if len(row) > 1
        and parse_header(row[0].text).roles
        and all(is_number(c.text) or is_blank(c.text) for c in row[1:])
    ]
    if not named or named[0] is not rows[0] or _numbers(rows[0]) == 0 or len(named) * 2 < len(rows[:20]):
        return False
    cell = rows[0][0]
    names = listing([row[0].text for row in named])
    hint = "turn it: one column for each quantity, one row for each run (in a spreadsheet: Paste special, Transpose)"
    faults.add(
        TABLE_TRANSPOSED,
        f"the names stand at the side ({names}): the table is transposed",
        hint,
        cell.place,
        len(cell.text),
    )
    return True


_ASSIGNMENT = re.compile(r".{0,30}=\s*[-+]?[0-9].*")
_COPY = re.compile(r"\.[0-9]{1,2}$")


def _stands_side_by_side(rows: list[list[Text]], faults: Faults) -> bool:
    for row in rows[:3]:
        if _numbers(row):
            break
        names = [squeeze(_COPY.sub("", cell.text)) for cell in row]
        cell = row[0]
        if sum(bool(_ASSIGNMENT.fullmatch(c.text)) for c in row) > 1 or _cycle([n for n in names if n]):
            shown = listing([c.text for c in row if c.text])
            hint = "put the blocks below each other, with a column for what differs (such as mass [g])"
            faults.add(
                BLOCKS_SIDE_BY_SIDE, f"blocks stand side by side: {shown}", hint, cell.place, max(1, len(cell.text))
            )
            return True
    return False


def _cycle(names: list[str]) -> int:
    """Give the length of the block of two or more names that repeats, or 0."""
    for period in range(2, len(names) // 2 + 1):
        if len(set(names[:period])) == period and all(
            name == names[i % period] for i, name in enumerate(names[: len(names) // period * period])
        ):
            return period
    return 0


def _starts_with_title(rows: list[list[Text]], faults: Faults) -> bool:
    filled = [cell for cell in rows[0] if cell.text]
    if len(filled) != 1 or len(rows) < 2 or sum(1 for c in rows[1] if c.text) < 2:
        return False
    cell = filled[0]
    if parse_header(cell.text).roles and not parse_header(rows[1][0].text).roles:
        return False
    _add_title(cell, faults)
    return True


def _add_title(cell: Text, faults: Faults) -> None:
    hint = "put a # before the line, or take it out; what it says of the runs goes into a column"
    faults.add(ROW_IS_ONLY_A_TITLE, f'line {cell.line} holds only "{cell.text[:60]}"', hint, cell.place, len(cell.text))


def _bare(text: str) -> str:
    return text[1:-1].strip() if text[:1] + text[-1:] in ("[]", "()") else text


def _is_unit_row(row: list[Text]) -> bool:
    units = 0
    for cell in row:
        bare = _bare(cell.text)
        if is_number(cell.text) and not (kinds_of(bare) and any(letter.isalpha() for letter in bare)):
            return False
        if kinds_of(bare) or bare == "%":
            units += 1
        elif cell.text and not is_blank(bare) and bare == cell.text:
            return False
    return units > 0


def _with_units(headers: list[Header], row: list[Text]) -> list[Header]:
    out = list(headers)
    for index, cell in enumerate(row[: len(headers)]):
        bare = _bare(cell.text)
        if not is_blank(bare) and headers[index].unit is None:
            out[index] = with_unit(headers[index], bare)
    return out


def _is_parted(head: list[Text], headers: list[Header], faults: Faults) -> bool:
    """Find ``m, g`` that became two cells, which shifts every column behind it."""
    for cell, unit, header in zip(head, head[1:], headers, strict=False):
        alone = bool(kinds_of(unit.text)) and not parse_header(unit.text).roles
        if alone and header.roles and header.unit is None:
            message = f'"{unit.text}" stands alone in its cell: is it the unit of "{cell.text}"?'
            hint = f'write "{cell.text} [{unit.text}]", or put the header in quotes'
            faults.add(HEADER_PARTED_BY_COMMA, message, hint, unit.place, len(unit.text))
            return True
    return False


def _repeats_a_header(head: list[Text], faults: Faults) -> bool:
    seen: dict[str, Text] = {}
    found = False
    for cell in head:
        key = " ".join(cell.text.split())
        if key and key in seen:
            hint = "name repeats of one time time_1, time_2, …; rename or remove the other columns"
            message = f'two columns are called "{cell.text[:60]}"'
            faults.add(HEADER_STANDS_TWICE, message, hint, cell.place, len(cell.text))
            found = True
        seen.setdefault(key, cell)
    return found


def _is_stacked(body: list[list[Text]], width: int, headers: list[Header], faults: Faults) -> bool:
    """Find a second header, or a title, among the runs."""
    for row in body:
        filled = [cell for cell in row if cell.text]
        if any(is_number(cell.text) or is_blank(cell.text) for cell in filled):
            continue
        named = [cell for cell in filled if parse_header(cell.text).roles]
        if len(named) > 1:
            hint = "keep one header row; what differs between the blocks goes into a column"
            faults.add(
                BLOCKS_STACKED, f"a second header row in line {row[0].line}: blocks are stacked", hint, named[0].place
            )
            return True
        at = row.index(filled[0])
        text_column = at < width and set(headers[at].roles) & {"run", "note"}
        if len(filled) == 1 and width > 1 and len(filled[0].text) > 1 and (at == 0 or not text_column):
            if at < width and headers[at].roles and headers[at].roles[0].endswith("_sense"):
                continue
            _add_title(filled[0], faults)
            return True
    return False
