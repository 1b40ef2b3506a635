"""Where titles, headers, units, runs, means and notes stand; and several tables that become one.

A sheet is read as a teaching assistant reads it: what is no run is left out, what a caption says holds for the runs
below it, and one line for each says so.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from functools import lru_cache
from itertools import pairwise

from msgspec import Struct, field
from msgspec.structs import replace

from gyrodata import vocabulary
from gyrodata.diagnostics import (
    BLOCKS_SIDE_BY_SIDE,
    BLOCKS_STACKED,
    CAPTION_READ,
    HEADER_PARTED_BY_COMMA,
    HEADER_STANDS_TWICE,
    HEADER_WITHOUT_RUNS,
    NO_HEADER_ROW,
    ROW_IS_ONLY_A_TITLE,
    ROW_TAKEN_OUT,
    SUMMARY_LEFT_OUT,
    TABLE_LEFT_OUT,
    TABLE_TRANSPOSED,
    TABLES_JOINED,
    TIME_SERIES,
)
from gyrodata.quantities import NUMBER, fold_number, to_float
from gyrodata.readings.cells import BLANKS
from gyrodata.readings.headers import Header, counts_weights, origin_in, parse_header, split_unit, turns_in, with_unit
from gyrodata.readings.lablog import Faults, Text, listing, span
from gyrodata.readings.roles import (
    BY_NAME,
    FILLED_DOWN,
    MEAN_WORDS,
    NOT_THE_WEIGHT,
    SUMMARY_WORDS,
    TEXTS,
    TIMINGS,
    altered_role,
    kind_of_role,
    squeeze,
)
from gyrodata.readings.source import MAX_COLUMNS, Grid, Row
from gyrodata.units import kinds_of

_NAMES = "mass [g], position [cm], spin [rpm], time [s], turns"
_HINT = f"the first row names the columns, such as: {_NAMES}"
_ROW_A_RUN = f"write one row for each time, with its mass, position, spin and turns; {_HINT}"
_TITLES_LOOKED_AT = 60
"""Rows in which the header is looked for."""


class Layout(Struct, frozen=True):
    """A table of runs: its headers, and the rows below them."""

    grid: Grid
    """For the places of cells."""
    cells: list[Text]
    """The header row."""
    headers: list[Header]
    """What each of them says, with the unit of a second header row."""
    rows: list[Row]


_Said = tuple[str, tuple[int, int]]
"""What a caption says: its text, and its line and cell."""


class _Table(Struct):
    """One of the tables of a sheet."""

    head: Row
    cells: list[Text]
    headers: list[Header]
    rows: list[Row] = field(default_factory=list)
    given: dict[str, _Said] = field(default_factory=dict)
    """What its caption says of its runs: text and origin by role."""
    title: str = ""
    """All words that stand above it."""

    @property
    def roles(self) -> set[str]:
        """All that its headers may mean, and what its caption gives."""
        return {role for header in self.headers for role in header.roles} | set(self.given)


def find_layout(grid: Grid, faults: Faults) -> Layout | None:
    """Find the header and the rows; None, with diagnostics, where there is no such table."""
    if not grid.rows:
        faults.add(NO_HEADER_ROW, "there is no table in this log", _HINT)
        return None
    first = _find_head(grid, faults)
    parts = None if first is None else _part_columns(grid, grid.rows[first:], faults)
    if parts is None:
        return None
    reader = _SheetReader(grid)
    reader.captions = grid.rows[:first]
    for part in parts:
        reader.begin(part[0])
        for row in part[1:]:
            reader.take(row)
    reader.tell(faults)
    tables = [table for table in reader.tables if table.rows] or reader.tables[:1]
    if any(_is_wrong_head(table, faults) for table in tables):
        return None
    layout = _join(_only_runs(tables, faults), grid, faults)
    if layout is None:
        return None
    if not layout.rows:
        hint = "write one row for each timed run"
        faults.add(HEADER_WITHOUT_RUNS, "there is a header, but not one run below it", hint)
        return None
    return None if _is_time_series(layout, faults) else layout


def is_number(text: str) -> bool:
    """Tell whether a cell begins like a number."""
    return text[:1].isdigit() or (text[:1] in "+-−.,(" and text[1:2].isdigit())


def _numbers(row: Row) -> int:
    return sum(
        is_number(text) and not parse_header(text).roles and not re.match(r"[1-9](?:st|nd|rd|th|ª|º)\b", text)
        for text in row.texts
    )


def _filled(row: Row) -> list[int]:
    return [at for at, text in enumerate(row.texts) if text]


def _is_head(row: Row) -> bool:
    """Tell a header by two names, one of them that of a quantity."""
    headers = list(map(parse_header, filter(None, row.texts)))
    named = [header.roles for header in headers if header.roles]
    physical = any(not TEXTS.intersection(found) for found in named)
    return len(named) > 1 and physical and _numbers(row) * 2 < len(headers) and not _is_unit_row(row)


# One sheet after the other -----------------------------------------------------------------------------------------


def _find_head(grid: Grid, faults: Faults) -> int | None:
    """Find the row of the first header; None, with diagnostics, where there is none."""
    rows = grid.rows
    first = next((at for at, row in enumerate(rows[:_TITLES_LOOKED_AT]) if _is_head(row)), None)
    if first is None:
        if _is_transposed(grid, faults):
            return None
        # No header is known by its names: it is the first row as wide as most rows.
        several = [at for at, row in enumerate(rows[:_TITLES_LOOKED_AT]) if len(_filled(row)) > 1 and not _pairs(row)]
        width = Counter(len(rows[at].texts) for at in several).most_common(1)
        first = next((at for at in several if len(rows[at].texts) == width[0][0]), 0)
        if shape := _shape_without_head(rows[first:]):
            faults.add(NO_HEADER_ROW, shape, _ROW_A_RUN, grid.cell(rows[first], 0))
            return None
    head = rows[first]
    numbers = _numbers(head)
    if numbers and numbers * 2 >= len(_filled(head)):
        hint = _HINT
        if any(comment.text.count(grid.delimiter) == len(head.texts) - 1 for comment in grid.comments):
            hint = "take the # away from the line with the names of the columns"
        faults.add(NO_HEADER_ROW, "there is no header row: the first row holds numbers", hint, grid.cell(head, 0))
        return None
    if early := next((row for row in rows[:first] if _numbers(row) > 2 and not _pairs(row)), None):
        hint = "put the header above all runs, or # before the line if it is no run"
        message = f"line {early.line} holds numbers, and stands above the header in line {head.line}"
        faults.add(NO_HEADER_ROW, message, hint, grid.cell(early, 0))
        return None
    return first


def _shape_without_head(rows: list[Row]) -> str:
    """Say that a table without a header is a list of each quantity, or a cross table; "" if it is neither."""
    named = (re.match(r"([^\d:=]+?)\s*[:=]\s*[\[(]*[-+.\d]", row.texts[0]) for row in rows)
    lists = [name[1] for name in named if name and parse_header(name[1]).roles]
    if len(set(lists)) > 1 and 2 * len(lists) > len(rows):
        return f"each line lists the values of one quantity: {listing(lists)}"
    corner, *values = (re.sub(r".*=", "", text).strip() for text in rows[0].texts)
    cross = len(rows) > 1 < len(values) and not is_number(corner) and all(map(is_number, values))
    if cross and all(is_number(row.texts[0]) and 2 * _numbers(row) > len(row.texts) for row in rows[1:]):
        return f"this is a cross table: its first row holds the values {listing(values)}, and no names of columns"
    return ""


_LEFT_OUT = {
    ROW_IS_ONLY_A_TITLE: "{} says nothing of runs, and is left out",
    ROW_TAKEN_OUT: "begins with # or is struck out, and is left out",
    SUMMARY_LEFT_OUT: "no run, but worked out from runs ({}): left out",
}


class _SheetReader:
    """Goes down the rows of a sheet, and knows what each of them is: parts them into tables, each with its caption."""

    def __init__(self, grid: Grid) -> None:
        self.grid = grid
        self.tables: list[_Table] = []
        self.captions: list[Row] = []
        """Rows of words that no runs have followed yet."""
        self.left_out: list[tuple[str, Row, int]] = []
        """Rows that are no runs: why, and where in them it stands."""
        self.said: list[tuple[Row, str]] = []
        """What was taken from each caption."""

    def begin(self, head: Row) -> None:
        """Begin a table with its header row."""
        code, above, at = self.left_out[-1] if self.left_out else ("", head, 0)
        if code == SUMMARY_LEFT_OUT and above.line == head.line - 1 and _filled(above) == [at]:
            self.captions.append(above)  # "Mean values" right above it is its title
            self.left_out.pop()
        cells = [self.grid.cell(head, at) for at in range(len(head.texts))]
        self.tables.append(_Table(head, cells, [parse_header(cell.text) for cell in cells]))
        self.fresh = True  # units or a second row of names may still come

    def take(self, row: Row) -> None:
        """Take the next row for what it is."""
        table = self.tables[-1]
        if _is_head(row):
            if self.fresh and not table.rows and not self.captions:
                self.tables.pop()  # a row of names above the header
                self._leave_out(ROW_IS_ONLY_A_TITLE, table.head)
            self.begin(row)
        elif self.fresh and _is_unit_row(row):
            table.headers = _with_units(table.headers, row)
            self.fresh = False
        elif self.fresh and (names := _names_below(table, row)):
            # A header merged over the last columns leaves its row shorter than the row of names.
            more = len(names) - len(table.cells)
            table.cells = table.cells + [replace(table.cells[-1], text="")] * more
            table.headers = table.headers + [parse_header("")] * more
            for at, name in enumerate(names):
                if name:
                    table.headers[at] = parse_header(name)
                    table.cells[at] = replace(table.cells[at], text=name)
        elif row.texts[0] == "#":
            self._leave_out(ROW_TAKEN_OUT, row)  # a # that a spreadsheet put into a cell of its own
        elif _is_summary(row, table):
            self._leave_out(SUMMARY_LEFT_OUT, row)
        elif _is_words(row, table) or _is_caption(row, table):
            self.captions.append(row)
        else:
            self._take_run(row)

    def _leave_out(self, code: str, row: Row) -> None:
        if code != ROW_IS_ONLY_A_TITLE or not altered_role(", ".join(filter(None, row.texts))):
            self.left_out.append((code, row, _filled(row)[0]))

    def _take_run(self, row: Row) -> None:
        table = self.tables[-1]
        title = " ".join(text for row in self.captions for text in row.texts)
        given = self._read_captions(table, row)
        if given and table.rows:
            table = _Table(table.head, table.cells, table.headers)
            self.tables.append(table)
        table.given |= given
        table.title = f"{table.title} {title}"
        self.fresh = False
        width = len(table.cells)
        remarks = [at for at in range(width, len(row.texts)) if row.texts[at]]
        if remarks and not any(is_number(row.texts[at]) for at in remarks):
            if not altered_role(", ".join(row.texts[at] for at in remarks)):
                self.left_out.append((ROW_IS_ONLY_A_TITLE, row, remarks[0]))
            row = Row(row.line, row.texts[:width], None if row.origin is None else row.origin[:width])
        table.rows.append(row)

    def _read_captions(self, table: _Table, run: Row) -> dict[str, _Said]:
        """Find what the rows of words above a run say of what its columns lack; fill what is blank in the run."""
        found: dict[str, _Said] = {}
        lacking = _lacking(table)
        blank = {
            header.roles[0]: at
            for at, header in enumerate(table.headers)
            if len(header.roles) == 1 and at < len(run.texts) and run.texts[at] in BLANKS and table.rows
        }
        for row in self.captions:
            said = []
            for role, text, at in _pairs(row) or _said(row):
                if role in lacking:
                    found[role] = (text, divmod(row.spot(at), MAX_COLUMNS))
                elif role in blank:
                    run.texts[blank[role]] = text  # "moved to 10.0 cm": what is above holds no longer
                else:
                    continue
                said.append(f"{role} {text}")
            if said:
                self.said.append((row, ", ".join(said)))
            else:
                self._leave_out(ROW_IS_ONLY_A_TITLE, row)
        self.captions = []
        return found

    def tell(self, faults: Faults) -> None:
        """Say what was left out, and what was taken from a caption."""
        for row in self.captions:
            self._leave_out(ROW_IS_ONLY_A_TITLE, row)
        for table in self.tables:
            if _ends_with_means(table):
                self._leave_out(SUMMARY_LEFT_OUT, table.rows.pop())
        # "A = 20.1 g" is the legend of a column that contains A.
        names = {text for table in self.tables for row in table.rows for text in row.texts}
        legends = (re.match(r"(.+?)\s*[=:]", row.texts[at]) for _, row, at in self.left_out)
        self.left_out = [
            one for one, legend in zip(self.left_out, legends, strict=True) if not legend or legend[1] not in names
        ]
        for code, template in _LEFT_OUT.items():
            rows = sorted(((row, at) for why, row, at in self.left_out if why == code), key=lambda one: one[0].line)
            if not rows:
                continue
            texts = [row.texts[at] for row, at in rows]
            shown = listing([f'"{text}"' if len(text) <= 38 else f'"{text[:36]}…"' for text in texts], 4)
            hint = ""
            if code == ROW_IS_ONLY_A_TITLE:
                hint = "put # before the line to keep it as a remark; what it says of the runs goes into a column"
            if hint and (origin := next(filter(None, (origin_in(" ".join(row.texts)) for row, _ in rows)), "")):
                length = {"surface": "ball_diameter: 10.16 cm", "tip": "rod_length: 25.0 cm"}[origin]
                hint = f'if positions count from the {origin}, write "# position_from: {origin}" and "# {length}" above'
            message = f"{span(sorted({row.line for row, _ in rows}))}: {template.format(shown)}"
            faults.add(code, message, hint, self.grid.cell(*rows[0]))
        for row, text in self.said:
            message = f"line {row.line} says it for the runs below it: {text}"
            faults.add(CAPTION_READ, message, "", self.grid.cell(row, _filled(row)[0]))


def _ends_with_means(table: _Table) -> bool:
    """Find a last row that has fewer cells than the runs, and the mean of their times: a mean that has no name."""
    times = [at for at, header in enumerate(table.headers) if "time" in header.roles]
    if len(table.rows) < 3 or not times:
        return False
    *runs, last = (len(_filled(row)) for row in table.rows)
    try:
        columns = [[to_float(row.texts[at]) for row in table.rows] for at in times]
    except (ValueError, IndexError):
        return False
    means = ((math.fsum(values[:-1]) / len(runs), values[-1]) for values in columns)
    return last < min(runs) and all(abs(value - mean) < 1e-3 * abs(mean) for mean, value in means)


def _lacking(table: _Table) -> set[str]:
    """Name what a caption may say of a table: what no column of it holds."""
    there = {role for header in table.headers for role in header.roles}
    lacking = {"mass", "position", "turns"} - there
    if there & {"torque", "angle"}:
        lacking -= {"mass", "position"} if "torque" in there else {"turns"}
    if "force" in there or any(map(counts_weights, table.headers)):
        lacking -= {"mass"}
    if not any(role.startswith("spin") for role in there):
        lacking.add("spin")
    if any(turns_in(cell.text) for cell in table.cells) or there.intersection(TIMINGS[1:]):
        lacking -= {"turns"}
    return lacking


_TIMES = r"(?:[0-9]{1,2}\s*[x×*·]\s*)?"
_PLUS_MINUS = rf"(?:\s*(?:±|\+/-|\+-)\s*{NUMBER})?"
_QUANTITY = rf"(?<![\w.,])({_TIMES}{NUMBER}{_PLUS_MINUS})\s*([^\W\d_][\w/^*·]*)"
_SAID_KINDS = {"mass": "mass", "length": "position", "rate": "spin"}


def _any_of(key: str) -> str:
    return f"(?:{vocabulary.words(key, '|')})"


_BALL_FIRST = re.compile(rf"(?i)\W*(?:{_any_of('article')}\s*)*{_any_of('ball')}\b(?!.*{_any_of('weight_added')})")
"""A line that begins with the ball or the rod, and names no weight."""
_SEVERAL_WEIGHTS = re.compile(
    rf"(?i)(?<![\w.,])(?:[2-9]|{_any_of('several')})\s+(?:[^\W\d]+\s+)?{_any_of('several_weights')}|[0-9]\s*k?g\s*\+\s*[0-9]"
)
_MOVED = set(vocabulary.words("moved").split())
_NOT_TIMED = re.compile(rf"(?i){_any_of('not_timed')}")
"""Words of a sentence whose turns are no turns that were timed, or may be none."""


def _said(row: Row) -> list[tuple[str, str, int]]:
    """Read "Weight 1: 20.1 g at 14.8 cm": role, text and cell of each quantity; none of which two are told."""
    found: dict[str, list[tuple[str, str, int]]] = {}
    whole = " ".join(filter(None, row.texts))
    # "Steel ball, m = 4.28 kg" tells of no weight on the rod, and "2 weights of 20 g" of no single one.
    of_the_ball = bool(_BALL_FIRST.match(whole))
    several = bool(_SEVERAL_WEIGHTS.search(whole))
    for at in _filled(row):
        text = row.texts[at]
        end = 0
        for match in re.finditer(_QUANTITY, text):
            before = {squeeze(word).lower() for word in re.split(r"[\s,;:()=]+", text[end : match.start()])}
            after = {squeeze(word).lower() for word in text[match.end() :].split()[:1]}
            end = match.end()
            kinds = kinds_of(match[2])
            role = next((_SAID_KINDS[kind] for kind in _SAID_KINDS if kind in kinds), "")
            if role == "position" and origin_in(text):
                continue  # it does not count from the centre of the ball: a column can say so
            if (role == "mass" and several) or (role in ("mass", "position") and of_the_ball):
                continue
            if before & _MOVED:
                before.discard("to")
            if role and not (before | after) & NOT_THE_WEIGHT:
                found.setdefault(role, []).append((role, f"{match[1]} {match[2]}", at))
        if (turns := turns_in(text)) and not _NOT_TIMED.search(whole):
            found.setdefault("turns", []).append(("turns", turns, at))
    return [items[0] for items in found.values() if len({text for _, text, _ in items}) == 1]


def _pairs(row: Row) -> list[tuple[str, str, int]]:
    """Read "Mass (g)", "20.1" and "Mass", "20.1", "g": names with their values, and nothing else in the row."""
    filled = _filled(row)
    found = []
    while filled:
        header = parse_header(row.texts[filled.pop(0)].rstrip(" :="))
        value = filled.pop(0) if filled else -1
        text = row.texts[value]
        if len(header.roles) != 1 or header.roles[0] in TEXTS or is_number(header.text) or not is_number(text):
            return []
        unit = header.unit or ""
        if filled and not unit and kinds_of(row.texts[filled[0]]) and not is_number(row.texts[filled[0]]):
            unit = row.texts[filled.pop(0)]
        bare = text[-1:].isdigit() or text[-1:] in ".,)"
        found.append((header.roles[0], f"{text} {unit}".strip() if bare else text, value))
    return found


_SENTENCE = r"[^\W\d_]{3,}\W+[^\W\d_]{3,}"
"""Two words: "2 reflective strips" is no number with its unit."""


def _is_words(row: Row, table: _Table) -> bool:
    """Find a title or a note: no number in it, and not only a remark on a run."""
    filled = _filled(row)
    texts = [row.texts[at] for at in filled]
    if any(text in BLANKS or (is_number(text) and not re.search(_SENTENCE, text)) for text in texts):
        return False
    if len("".join(texts)) < 2 or len(table.headers) < 2:
        return False
    kinds = [(at, kind_of_role(role)) for at in filled if at < len(table.headers) for role in table.headers[at].roles]
    return not any(kind == "sign" or (kind == "text" and at > 0) for at, kind in kinds)


def _is_caption(row: Row, table: _Table) -> bool:
    """Find "Mass (g)", "20.1", or "20.1 g" in a row that says nothing but what the table has no column for."""
    found = _said(row) if len(_filled(row)) < len(table.cells) else []
    said, roles = {at for *_, at in found}, {role for role, *_ in found}
    numbers = {at for at in _filled(row) if is_number(row.texts[at])}
    return bool(_pairs(row) or (found and said >= numbers and roles <= _lacking(table)))


def _is_summary(row: Row, table: _Table) -> bool:
    """Find a row of means, deviations or sums by its first word."""
    at = _filled(row)[0]
    text = row.texts[at]
    if is_number(text) or (at < len(table.headers) and "note" in table.headers[at].roles):
        return False
    words = re.split(r"[\s_:,;(=]+", text.strip())[0], re.sub(r"[()=:]", "", text)
    is_title = parse_header(text).roles and len(_filled(row)) == 1
    return not is_title and not SUMMARY_WORDS.isdisjoint(squeeze(word).lower() for word in words)


def _bare(text: str) -> str:
    return text[1:-1].strip() if text[:1] + text[-1:] in ("[]", "()") else text


def _is_unit_row(row: Row) -> bool:
    units = False
    for text in row.texts:
        bare = _bare(text)
        if is_number(text) and not (kinds_of(bare) and any(letter.isalpha() for letter in bare)):
            return False
        if kinds_of(bare) or bare == "%":
            units = True
        elif text and bare not in BLANKS and bare == text:
            return False
    return units


def _with_units(headers: list[Header], row: Row) -> list[Header]:
    out = list(headers)
    for index, text in enumerate(row.texts[: len(headers)]):
        bare = _bare(text)
        if bare not in BLANKS and headers[index].unit is None:
            # Minutes and seconds stand below one "time".
            split = bare == "s" and not headers[index].text and index and out[index - 1].unit == "min"
            out[index] = with_unit(headers[index - split], bare)
    return out


def _names_below(table: _Table, row: Row) -> list[str]:
    """Read a second row of names below merged cells: "Time (s)" over 1, 2, 3; none if it is no such row."""
    width = len(table.cells)
    filled = _filled(row)
    # As many as a header may be merged over at the end of its row.
    if len(filled) < 2 or filled[-1] >= width + 8:
        return []
    names = [""] * max(width, len(row.texts))
    heads = [at for at, cell in enumerate(table.cells) if cell.text]
    for over, end in pairwise([*heads, len(names)]):
        below = [at for at in filled if over <= at < end]
        if below and (below[0] != over or len(below) < 2):
            return []
        name, unit = split_unit(table.cells[over].text)
        for number, at in enumerate(below, 1):
            text = row.texts[at].rstrip(".")
            own = parse_header(row.texts[at])
            whole = f"{name} {text}" + (f" [{unit}]" if unit else "")
            names[at] = row.texts[at] if own.roles and own.unit else whole
            if (is_number(text) and text != str(number)) or not parse_header(names[at]).roles:
                return []
    return names if heads and filled[0] >= heads[0] else []


# Blocks that stand side by side ------------------------------------------------------------------------------------

_COPY = re.compile(r"\.[0-9]{1,2}$")
_RUN = re.compile(r"(?i)\s+run\s?#\s?([0-9]{1,3})$")
"""What a data logger writes behind the names of each run's columns."""


def _names(row: Row) -> list[str]:
    return [name for text in row.texts if (name := squeeze(_COPY.sub("", text)))]


def _part_columns(grid: Grid, rows: list[Row], faults: Faults) -> list[list[Row]] | None:
    """Put whole tables that stand side by side below each other; None, with a diagnostic, if they lack something."""
    head = rows[0]
    period = _cycle(_names(head))
    runs = [match[1] if (match := _RUN.search(text)) else "" for text in head.texts]
    if len(set(runs) - {""}) > 1:
        # What has no number is the same in each of them.
        blocks = [[at for at, run in enumerate(runs) if run in ("", one)] for one in dict.fromkeys(runs) if one]
    elif period:
        starts = [*_filled(head)[::period], len(head.texts)]
        blocks = [list(range(start, end)) for start, end in pairwise(starts)]
    else:
        return [rows]
    roles = {role for at in blocks[0] for role in parse_header(_RUN.sub("", head.texts[at])).roles}
    if not (roles & {"mass", "torque", "force"} and roles.intersection(TIMINGS)):
        shown = listing([text for text in head.texts if text])
        hint = "put the blocks below each other, with a column for what differs (such as mass [g])"
        faults.add(BLOCKS_SIDE_BY_SIDE, f"blocks stand side by side: {shown}", hint, grid.cell(head, 0))
        return None
    parts = []
    for block in blocks:
        part = []
        for row in rows:
            texts = [row.texts[at] if at < len(row.texts) else "" for at in block]
            texts = [_COPY.sub("", _RUN.sub("", text)) for text in texts] if row is head else texts
            if any(texts):
                end = max(at for at, text in enumerate(texts, 1) if text)
                part.append(Row(row.line, texts[:end], tuple((row.line, at) for at in block[:end])))
        parts.append(part)
    return parts


def _cycle(names: list[str]) -> int:
    """Give the length of the block of two or more names that repeats, or 0."""
    for period in range(2, len(names) // 2 + 1):
        block, blocks = names[:period], len(names) // period
        if len(set(block)) == period and names[: period * blocks] == block * blocks:
            return period
    return 0


# Several tables become one -----------------------------------------------------------------------------------------


def _only_runs(tables: list[_Table], faults: Faults) -> list[_Table]:
    """Leave out tables of results and of means."""
    kept: list[_Table] = []
    for table in tables if any(map(_is_timed, tables)) else ():
        if not _is_timed(table):
            why = "holds no times of runs"
        elif kept and _is_of_means(table) and not _is_of_means(kept[0]):
            why = "holds means"
        else:
            kept.append(table)
            continue
        what = f'the table below line {table.cells[0].line} ("{table.cells[0].text[:40]}", …)'
        faults.add(TABLE_LEFT_OUT, f"{what} {why}: left out", "", table.cells[0])
    return kept or tables


def _is_timed(table: _Table) -> bool:
    return bool(table.roles.intersection(TIMINGS)) or any(turns_in(cell.text) for cell in table.cells)


def _is_of_means(table: _Table) -> bool:
    timings = [header for header in table.headers if set(header.roles).intersection(TIMINGS)]
    return is_of_means(table.title) or (bool(timings) and all(is_of_means(header.text) for header in timings))


@lru_cache(maxsize=4096)
def is_of_means(header: str) -> bool:
    """Tell whether a column holds means, by its name."""
    return any(squeeze(word).lower() in MEAN_WORDS for word in re.split(r"[\s_,;()\[\]\-]+", header))


def _join(tables: list[_Table], grid: Grid, faults: Faults) -> Layout | None:
    """Make one table of all of them; None, with a diagnostic, where they do not go together."""
    first = tables[0]
    if len(tables) == 1 and not first.given:
        return Layout(grid, first.cells, first.headers, first.rows)
    cells, headers = list(first.cells), list(first.headers)
    wanted = _wanted(first)
    moved: list[tuple[_Table, list[int], dict[int, _Said]]] = []
    for table in tables:
        lost = [] if any(turns_in(cell.text) for cell in table.cells) else ["count"]
        lost = sorted(part for part in wanted - _wanted(table) if part in lost or part not in ("count", "torque"))
        if lost:
            name = {"count": "turns", "timing": "time"}.get(lost[0], lost[0])
            sample = BY_NAME[name].sample
            above = f'in the line above it, such as "{name} {sample}", or ' if sample else ""
            hint = f"write what holds for its runs {above}as a column; or put # before its lines if they are no runs"
            message = f"the table below line {table.head.line} has no {name}, and the first table has one"
            faults.add(BLOCKS_STACKED, message, hint, grid.cell(table.head, _filled(table.head)[0]))
            return None
        places = _place_columns(table, cells, headers, faults)
        if places is None or (table.head is not first.head and not _begins_whole(table, faults)):
            return None
        given: dict[int, _Said] = {}
        for role, (text, (line, at)) in table.given.items():
            same = [k for k, header in enumerate(headers) if header.roles == (role,)]
            if not same:
                same = [len(cells)]
                cells.append(replace(grid.cell(Row(line, [""] * (at + 1)), at), text=role))
                headers.append(Header(role, (role,), None, ""))
            given |= dict.fromkeys(same, (text, (line, at)))
        moved.append((table, places, given))
    rows = [[_moved(row, places, given, len(cells)) for row in table.rows] for table, places, given in moved]
    common = set.intersection(*({*places, *given} for _, places, given in moved))
    if (repeated := _repeated(rows, common, headers)) is not None:
        message = f"the table below line {tables[repeated].head.line} repeats runs that stand above"
        hint = "a run counts once: delete this table, or put # before its lines (in a workbook, strike its rows out)"
        faults.add(BLOCKS_STACKED, message, hint, tables[repeated].cells[0])
        return None
    if len(tables) > 1:
        lines = ", ".join(span([row.line for row in table.rows]) for table in tables)
        faults.add(TABLES_JOINED, f"{len(tables)} tables are read as one: {lines}", "", first.cells[0])
    return Layout(grid, cells, headers, [row for part in rows for row in part])


def _repeated(tables: list[list[Row]], common: set[int], headers: list[Header]) -> int | None:
    """Find a table of which several rows hold all the same as rows of tables above, in the columns of all tables."""
    roles = {at: headers[at].roles[0] for at in sorted(common) if headers[at].roles}
    told = [at for at, role in roles.items() if role in BY_NAME and BY_NAME[role].part]
    if not any(roles[at] in TIMINGS for at in told):
        return None
    seen: set[tuple[str, ...]] = set()
    for number, rows in enumerate(tables):
        prints = [tuple(row.texts[at] if at < len(row.texts) else "" for at in told) for row in rows]
        if sum(one in seen for one in prints) > 1:
            return number
        seen.update(prints)
    return None


def _wanted(table: _Table) -> set[str]:
    """Name the parts of a run that a table tells of."""
    return {
        BY_NAME[role].part if BY_NAME[role].part in ("spin", "count", "timing") else role
        for role in table.roles
        if role in BY_NAME and BY_NAME[role].part
    }


def _place_columns(table: _Table, cells: list[Text], headers: list[Header], faults: Faults) -> list[int] | None:
    """Find the column of the whole for each column of a table; new ones are added."""
    places: list[int] = []
    for at, (cell, header) in enumerate(zip(table.cells, table.headers, strict=True)):
        if at < len(cells) and cells[at] == cell:
            places.append(at)
            continue
        alone = len(header.roles) == 1
        same = [k for k, other in enumerate(cells) if cell.text and squeeze(other.text) == squeeze(cell.text)]
        same += [
            k
            for k, other in enumerate(headers)
            if alone and (other.roles, other.number) == (header.roles, header.number)
        ]
        place = next((k for k in same if k not in places), None)
        if place is None:
            place = len(cells)
            cells.append(cell)
            headers.append(header)
        elif headers[place].unit != header.unit and header.roles:
            message = f'the table below line {cell.line} has "{cell.text}" where the first has "{cells[place].text}"'
            hint = f'give the columns of all tables the same units: write "{cells[place].text}" and its numbers'
            faults.add(BLOCKS_STACKED, message, hint, cell)
            return None
        places.append(place)
    return places


def _begins_whole(table: _Table, faults: Faults) -> bool:
    """Refuse a later table whose first row leaves blank what stands further down: nothing above it holds for it."""
    for at, header in enumerate(table.headers):
        role = header.roles[0] if len(header.roles) == 1 else ""
        filled = at < len(table.rows[0].texts) and table.rows[0].texts[at]
        if role in FILLED_DOWN and role not in table.given and not filled and role != "position":
            message = f"{role} is blank in line {table.rows[0].line}, the first row of its table"
            hint = "write each value in the first row that it belongs to"
            faults.add(BLOCKS_STACKED, message, hint, table.cells[at])
            return False
    return True


def _moved(row: Row, places: list[int], given: dict[int, _Said], width: int) -> Row:
    """Put the cells of a row where the columns of the whole are, with what its caption gives."""
    texts = [""] * (width + len(row.texts))
    origin = [(row.line, 0)] * len(texts)
    for at, text in enumerate(row.texts):
        place = places[at] if at < len(places) else width + at - len(places)
        texts[place], origin[place] = text, row.origin[at] if row.origin else (row.line, at)
    for place, (text, where) in given.items():
        texts[place], origin[place] = text, where
    end = max((at + 1 for at, text in enumerate(texts) if text), default=0)
    return Row(row.line, texts[:end], tuple(origin[:end]))


# What is no log of runs --------------------------------------------------------------------------------------------

_LEAST_OF_A_SERIES = 30


def _is_time_series(layout: Layout, faults: Faults) -> bool:
    """Find a sensor's record: many times that go up evenly, and no weights and turns beside them."""
    roles = {role for header in layout.headers for role in header.roles}
    if roles & {"mass", "force", "torque"} and roles & {"turns", "angle"}:
        return False
    for at, header in enumerate(layout.headers if len(layout.rows) >= _LEAST_OF_A_SERIES else ()):
        try:
            times = [to_float(fold_number(row.texts[at])) for row in layout.rows[:2000] if "time" in header.roles]
        except (ValueError, IndexError):
            continue
        steps = [later - earlier for earlier, later in pairwise(times)]
        usual = sorted(steps)[len(steps) // 2] if steps else 0.0
        if usual > 0 and min(steps) >= 0 and sum(abs(step / usual - 1) <= 0.5 for step in steps) >= 0.9 * len(steps):
            message = f"the {len(layout.rows)} times go up evenly: this is a time series, and one row a run is read"
            hint = "work out the spin and the time of some turns of each run from it, and write one row for each run: "
            faults.add(TIME_SERIES, message, hint + _NAMES, layout.cells[at])
            return True
    return False


def _is_transposed(grid: Grid, faults: Faults) -> bool:
    rows = grid.rows[:20]
    sides = [
        row.texts[0]
        for row in rows
        if row.texts[1:] and all(is_number(text) or text in BLANKS for text in row.texts[1:])
    ]
    named = [text for text in sides if parse_header(text).roles]
    if not named or named[0] != rows[0].texts[0] or _numbers(rows[0]) == 0 or len(named) * 2 < len(rows):
        return False
    hint = "turn it: one column for each quantity, one row for each run (in a spreadsheet: Paste special, Transpose)"
    message = f"the names stand at the side ({listing(named)}): the table is transposed"
    faults.add(TABLE_TRANSPOSED, message, hint, grid.cell(rows[0], 0))
    return True


def _is_wrong_head(table: _Table, faults: Faults) -> bool:
    """Find a header that a comma parted, which shifts the columns behind it, and two columns of one name."""
    cells, headers = table.cells, table.headers
    for (cell, unit), header in zip(pairwise(cells), headers, strict=False):
        if header.roles and header.unit is None and kinds_of(unit.text) and not parse_header(unit.text).roles:
            message = f'"{unit.text}" stands alone in its cell: is it the unit of "{cell.text}"?'
            hint = f'write "{cell.text} [{unit.text}]", or put the header in quotes'
            faults.add(HEADER_PARTED_BY_COMMA, message, hint, unit)
            return True
    names = [" ".join(cell.text.split()) for cell in cells]
    twice = [cell for at, cell in enumerate(cells) if names[at] and names[at] in names[:at]]
    for cell in twice:
        hint = "name repeats of one time time_1, time_2, …; rename or remove the other columns"
        faults.add(HEADER_STANDS_TWICE, f'two columns are called "{cell.text[:60]}"', hint, cell)
    if twice:
        return True
    width = max((len(row.texts) for row in table.rows), default=len(cells))
    for cell, header in zip(cells[width:], headers[width:], strict=True) if width else ():
        # "period [s], 5 turns"; a time whose cells are all blank is another fault.
        if (turns := turns_in(cell.text)) and (header.unit is None or headers[width - 1].unit is None):
            message = f'"{cell.text}" has no cell in any row: the header has {len(cells)} cells, the rows {width}'
            hint = f'write one name without a comma for "{cells[width - 1].text}", as "time for {turns} turns [s]"'
            faults.add(HEADER_PARTED_BY_COMMA, message, hint, cell)
            return True
    return False
