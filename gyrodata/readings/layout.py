"""Where titles, headers, units, runs, means and notes stand; and several tables that become one.

A sheet is read as a teaching assistant reads it: what is no run is left out, what a caption says holds for the runs
below it, and one line for each says so.
"""

from __future__ import annotations

import math
import re
from functools import lru_cache
from itertools import pairwise

from msgspec import Struct, field
from msgspec.structs import replace

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
from gyrodata.readings.source import Grid, Row
from gyrodata.units import kinds_of

_HINT = "the first row names the columns, such as: mass [g], position [cm], spin [rpm], time [s], turns"
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
    combined: frozenset[int] = frozenset()
    """Columns whose readings are in other columns too, and which are not used themselves."""


class _Table(Struct):
    """One of the tables of a sheet."""

    head: Row
    cells: list[Text]
    headers: list[Header]
    rows: list[Row] = field(default_factory=list)
    given: dict[str, tuple[str, tuple[int, int]]] = field(default_factory=dict)
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
    for table in tables:
        if _is_parted(table.cells, table.headers, faults) or _repeats_a_header(table.cells, faults):
            return None
        if _is_parted_count(table, faults):
            return None
    tables = _only_runs(tables, grid, faults)
    layout = _join(tables, grid, faults)
    if layout is None:
        return None
    if not layout.rows:
        faults.add(
            HEADER_WITHOUT_RUNS, "there is a header, but not one run below it", "write one row for each timed run"
        )
        return None
    return None if _is_time_series(layout, faults) else layout


def is_number(text: str) -> bool:
    """Tell whether a cell begins like a number."""
    return text[:1].isdigit() or (text[:1] in "+-−.,(" and text[1:2].isdigit())


def _numbers(row: Row) -> int:
    count = 0
    for text in row.texts:
        if is_number(text) and not parse_header(text).roles and not re.match(r"[1-9](?:st|nd|rd|th|ª|º)\b", text):
            count += 1
    return count


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
    if _has_values_of_blocks(grid, faults):
        return None
    first = next((at for at, row in enumerate(rows[:_TITLES_LOOKED_AT]) if _is_head(row)), None)
    if first is None:
        if _is_transposed(grid, faults):
            return None
        # No header is known by its names: it is the first row of several cells, or one as wide as the runs below it.
        several = [at for at, row in enumerate(rows[:_TITLES_LOOKED_AT]) if len(_filled(row)) > 1 and not _pairs(row)]
        first = next(iter(several), 0)
        run = next((at for at in several if 2 * _numbers(rows[at]) > len(rows[at].texts)), 0)
        if run and len(rows[first].texts) < len(rows[run].texts):
            first = next((at for at in several if at < run and len(rows[at].texts) == len(rows[run].texts)), first)
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


_ROW_A_RUN = (
    "write one row for each time, with its mass, position, spin and turns; the first row names the columns: mass [g], "
    "position [cm], spin [rpm], time [s], turns"
)


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


class _SheetReader:
    """Goes down the rows of a sheet, and knows what each of them is: parts them into tables, each with its caption."""

    def __init__(self, grid: Grid) -> None:
        self.grid = grid
        self.tables: list[_Table] = []
        self.captions: list[Row] = []
        """Rows of words that no runs have followed yet."""
        self.words: list[tuple[Row, int]] = []
        """Rows that only say something, and where in them it stands."""
        self.summaries: list[Row] = []
        self.taken_out: list[int] = []
        self.said: dict[int, str] = {}
        """What was taken from a caption, by its line."""

    def begin(self, head: Row) -> None:
        """Begin a table with its header row."""
        above = self.summaries[-1:]
        if above and above[0].line == head.line - 1 and len(_filled(above[0])) == 1:
            self.captions.append(self.summaries.pop())  # "Mean values" right above it is its title
        cells = [self.grid.cell(head, at) for at in range(len(head.texts))]
        self.tables.append(_Table(head, cells, [parse_header(cell.text) for cell in cells]))
        self.fresh = True  # units or a second row of names may still come

    def take(self, row: Row) -> None:
        """Take the next row for what it is."""
        table = self.tables[-1]
        texts = row.texts
        plain = not self.fresh and not self.captions and 3 <= len(texts) <= len(table.cells) and is_number(texts[0])
        if plain and 2 * sum(map(is_number, texts)) > len(texts):
            table.rows.append(row)  # nearly every row; what follows finds the same
            return
        if _is_head(row):
            if self.fresh and not table.rows and not self.captions:
                self.tables.pop()  # a row of names above the header
                self.words.append((table.head, _filled(table.head)[0]))
            self.begin(row)
        elif self.fresh and _is_unit_row(row):
            table.headers = _with_units(table.headers, row)
            self.fresh = False
        elif self.fresh and (names := _names_below(table, row)):
            # A header merged over the last columns leaves its row shorter than the row of names.
            more = len(names) - len(table.cells)
            table.cells = table.cells + [replace(table.cells[-1], text="")] * more
            table.headers = table.headers + [parse_header("")] * more
            table.headers = [
                parse_header(name) if name else header for name, header in zip(names, table.headers, strict=True)
            ]
            table.cells = [replace(cell, text=name or cell.text) for name, cell in zip(names, table.cells, strict=True)]
        elif row.texts[0] == "#":
            self.taken_out.append(row.line)  # a # that a spreadsheet put into a cell of its own
        elif _is_summary(row, table):
            self.summaries.append(row)
        elif _is_words(row, table) or _is_caption(row, table):
            self.captions.append(row)
        else:
            self._take_run(row)

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
            self.words.append((row, remarks[0]))
            row = Row(row.line, row.texts[:width], None if row.origin is None else row.origin[:width])
        table.rows.append(row)

    def _read_captions(self, table: _Table, run: Row) -> dict[str, tuple[str, tuple[int, int]]]:
        """Find what the rows of words above a run say of what its columns lack; fill what is blank in the run."""
        found: dict[str, tuple[str, tuple[int, int]]] = {}
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
                    found[role] = (text, divmod(row.spot(at), _PER_LINE))
                    said.append(f"{role} {text}")
                elif role in blank:
                    # "moved to 10.0 cm": what is above holds no longer.
                    run.texts[blank[role]] = text
                    said.append(f"{role} {text}")
            if said:
                self.said[row.line] = ", ".join(said)
            else:
                self.words.append((row, _filled(row)[0]))
        self.captions = []
        return found

    def tell(self, faults: Faults) -> None:
        """Say what was left out, and what was taken from a caption."""
        self._drop_unnamed_means()
        self.words += [(row, _filled(row)[0]) for row in self.captions]
        self.words = [(row, at) for row, at in self.words if not altered_role(", ".join(filter(None, row.texts[at:])))]
        if self.words:
            words = sorted(self.words, key=lambda item: item[0].line)
            texts = listing([_quoted(row.texts[at]) for row, at in words], 4)
            lines = span(sorted({row.line for row, _ in words}))
            cell = self.grid.cell(*words[0])
            hint = "put # before the line to keep it as a remark; what it says of the runs goes into a column"
            if origin := next((said for row, _ in words if (said := origin_in(" ".join(row.texts)))), ""):
                length = {"surface": "ball_diameter: 10.16 cm", "tip": "rod_length: 25.0 cm"}[origin]
                hint = f'if positions count from the {origin}, write "# position_from: {origin}" and "# {length}" above'
            faults.add(ROW_IS_ONLY_A_TITLE, f"{lines}: {texts} says nothing of runs, and is left out", hint, cell)
        if self.taken_out:
            cell = self.grid.cell(Row(self.taken_out[0], ["#"]), 0)
            faults.add(ROW_TAKEN_OUT, f"{span(self.taken_out)}: begins with # and is left out", "", cell)
        if self.summaries:
            texts = listing([f'"{next(filter(None, row.texts))}"' for row in self.summaries], 4)
            lines = span([row.line for row in self.summaries])
            cell = self.grid.cell(self.summaries[0], _filled(self.summaries[0])[0])
            faults.add(SUMMARY_LEFT_OUT, f"{lines}: no run, but worked out from runs ({texts}): left out", "", cell)
        for line, text in self.said.items():
            row = next(row for row in self.grid.rows if row.line == line)
            message = f"line {line} says it for the runs below it: {text}"
            faults.add(CAPTION_READ, message, "", self.grid.cell(row, _filled(row)[0]))

    def _drop_unnamed_means(self) -> None:
        """Find the row of means that nobody has named."""
        for table in self.tables:
            times = [at for at, header in enumerate(table.headers) if "time" in header.roles]
            if len(table.rows) < 3 or not times:
                continue
            *runs, last = table.rows
            filled = [len(row.texts) - row.texts.count("") for row in table.rows]
            if filled[-1] < min(filled[:-1]) and all(_is_mean(runs, last, at) for at in times):
                self.summaries.append(table.rows.pop())


def _quoted(text: str) -> str:
    """A text in quotes, cut short where it is long."""
    return f'"{text}"' if len(text) <= 38 else f'"{text[:36]}…"'


def _is_mean(runs: list[Row], last: Row, at: int) -> bool:
    try:
        values = [to_float(row.texts[at]) for row in (*runs, last)]
    except (ValueError, IndexError):
        return False
    mean = math.fsum(values[:-1]) / len(runs)
    return abs(values[-1] - mean) < 1e-3 * abs(mean)


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


_PER_LINE = Row(1, []).spot(0)
_TIMES = r"(?:[0-9]{1,2}\s*[x×*·]\s*)?"
_PLUS_MINUS = rf"(?:\s*(?:±|\+/-|\+-)\s*{NUMBER})?"
_QUANTITY = rf"(?<![\w.,])({_TIMES}{NUMBER}{_PLUS_MINUS})\s*([^\W\d_][\w/^*·]*)"
_SAID_KINDS = {"mass": "mass", "length": "position", "rate": "spin"}


_BALL_FIRST = re.compile(
    r"(?i)\W*(?:(?:the|our|a|steel|stahl|die|la|le|bola de|boule d')\s*)*"
    r"(?:ball|sphere|globe|rod|stick|shaft|dis[ck]|wheel|rotor|kugel|stab|stange|scheibe|boule|sphère|tige|disque|шар|"
    r"стержень|диск|bola|esfera|varilla|kula|pręt|haste)\b(?!.*(?:weight|added|gewicht|masselotte|pesa|груз|ciężar))"
)
"""A line that begins with the ball or the rod, and names no weight."""
_SEVERAL_WEIGHTS = re.compile(
    r"(?i)(?<![\w.,])(?:[2-9]|two|three|four|zwei|drei|vier|deux|trois|dos|tres|два|три|dwa|trzy)\s+(?:[^\W\d]+\s+)?"
    r"(?:weights|masses|washers|nuts|gewichte|massen|poids|pesas|masas|груза|ciężarki|of them)|[0-9]\s*k?g\s*\+\s*[0-9]"
)
_MOVED = {"moved", "shifted", "changed", "set"}
_NOT_TIMED = re.compile(
    r"(?i)tacho|of (?:the )?(?:ball|spin|sphere|dis[ck]|wheel|rotor)\b|der kugel|de la (?:boule|bola)|шара|ротора|"
    r"\bwait|gewartet|warten|attend|esper|before the|\bnot\b|n't\b|\bnicht|\bpas\b|\bне\b|"
    r"start\w*\W+(?:\w+\W+){0,2}after"
)
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
        at = filled.pop(0)
        header = parse_header(row.texts[at].rstrip(" :="))
        if len(header.roles) != 1 or header.roles[0] in TEXTS or is_number(row.texts[at]) or not filled:
            return []
        value = filled.pop(0)
        text = row.texts[value]
        if not is_number(text):
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
    width = len(table.headers)
    texts = [row.texts[at] for at in filled]
    if any(text in BLANKS or (is_number(text) and not re.search(_SENTENCE, text)) for text in texts) or width < 2:
        return False
    if len(filled) == 1 and len(row.texts[filled[0]]) < 2:
        return False
    for at in filled:
        kinds = {kind_of_role(role) for role in table.headers[at].roles} if at < width else set()
        if "sign" in kinds or ("text" in kinds and at > 0):
            return False
    return True


def _is_caption(row: Row, table: _Table) -> bool:
    """Find "Mass (g)", "20.1", or "20.1 g" in a row that says nothing but what the table has no column for."""
    if _pairs(row):
        return True
    if len(_filled(row)) >= len(table.cells):
        return False
    found = _said(row)
    numbers = [at for at in _filled(row) if is_number(row.texts[at])]
    lacking = _lacking(table)
    return bool(found) and {at for *_, at in found} >= set(numbers) and all(role in lacking for role, *_ in found)


def _is_summary(row: Row, table: _Table) -> bool:
    """Find a row of means, deviations or sums by its first word."""
    at = _filled(row)[0]
    text = row.texts[at]
    if is_number(text) or (at < len(table.headers) and "note" in table.headers[at].roles):
        return False
    first = re.split(r"[\s_:,;(=]+", text.strip())[0]
    return bool({squeeze(first).lower(), squeeze(re.sub(r"[()=:]", "", text)).lower()} & SUMMARY_WORDS) and not (
        parse_header(text).roles and len(_filled(row)) == 1
    )


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
    cells = table.cells + [replace(table.cells[-1], text="")] * max(len(row.texts) - width, 0)
    names = [""] * len(cells)
    parent = -1
    groups: dict[int, list[int]] = {}
    for at, cell in enumerate(cells):
        parent = at if cell.text else parent
        if at < len(row.texts) and row.texts[at]:
            groups.setdefault(parent, []).append(at)
    for over, below in groups.items():
        if below[0] != over or len(below) < 2:
            return []
        name, unit = split_unit(table.cells[over].text)
        for number, at in enumerate(below, 1):
            text = row.texts[at]
            if is_number(text) and text.rstrip(".") != str(number):
                return []
            own = parse_header(text)
            whole = text if own.roles and own.unit else f"{name} {text.rstrip('.')}" + (f" [{unit}]" if unit else "")
            if not parse_header(whole).roles:
                return []
            names[at] = whole
    return names


# Blocks that stand side by side ------------------------------------------------------------------------------------

_ASSIGNMENT = r".{0,30}=\s*[-+]?[0-9].*"
_COPY = re.compile(r"\.[0-9]{1,2}$")
_RUN = re.compile(r"(?i)\s+run\s?#\s?([0-9]{1,3})$")
"""What a data logger writes behind the names of each run's columns."""


def _names(row: Row) -> list[str]:
    return [name for text in row.texts if (name := squeeze(_COPY.sub("", text)))]


def _has_values_of_blocks(grid: Grid, faults: Faults) -> bool:
    """Find "m=335 g" and "m=273 g" in one row, above names that repeat."""
    for row, below in zip(grid.rows[:_TITLES_LOOKED_AT], grid.rows[1:], strict=False):
        assigned = sum("=" in text and bool(re.fullmatch(_ASSIGNMENT, text)) for text in row.texts)
        if assigned > 1 and _cycle(_names(below)):
            _refuse_side_by_side(grid, row, faults)
            return True
    return False


def _refuse_side_by_side(grid: Grid, row: Row, faults: Faults) -> None:
    shown = listing([text for text in row.texts if text])
    hint = "put the blocks below each other, with a column for what differs (such as mass [g])"
    faults.add(BLOCKS_SIDE_BY_SIDE, f"blocks stand side by side: {shown}", hint, grid.cell(row, 0))


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
        _refuse_side_by_side(grid, head, faults)
        return None
    parts = []
    for block in blocks:
        part = []
        for row in rows:
            texts = [row.texts[at] if at < len(row.texts) else "" for at in block]
            while texts and not texts[-1]:
                texts.pop()
            if row is head:
                texts = [_COPY.sub("", _RUN.sub("", text)) for text in texts]
            if texts:
                part.append(Row(row.line, texts, tuple((row.line, at) for at in block[: len(texts)])))
        parts.append(part)
    return parts


def _cycle(names: list[str]) -> int:
    """Give the length of the block of two or more names that repeats, or 0."""
    for period in range(2, len(names) // 2 + 1):
        if len(set(names[:period])) == period and all(
            name == names[i % period] for i, name in enumerate(names[: len(names) // period * period])
        ):
            return period
    return 0


# Several tables become one -----------------------------------------------------------------------------------------


def _only_runs(tables: list[_Table], grid: Grid, faults: Faults) -> list[_Table]:
    """Leave out tables of results, of means, and copies of runs that stand above."""
    timed = [table for table in tables if _is_timed(table)]
    if not timed or len(tables) == 1:
        return tables
    kept: list[_Table] = []
    # Tables by the parts of a run that they tell, and what was typed of the parts that others tell as well.
    alike: dict[frozenset[str], list[_Table]] = {}
    seen: dict[tuple[frozenset[str], frozenset[str]], tuple[int, set[tuple[str, ...]]]] = {}
    for table in tables:
        why = ""
        if not _is_timed(table):
            why = "holds no times of runs"
        elif kept and _is_of_means(table) and not _is_of_means(kept[0]):
            why = "holds means"
        else:
            fresh, parts = table.rows, _parts(table)
            for kind, others in alike.items():
                common = parts & kind
                if common.intersection(TIMINGS):
                    count, prints = seen.get((kind, common), (0, set()))
                    prints.update(_fingerprint(other, row, common) for other in others[count:] for row in other.rows)
                    seen[kind, common] = len(others), prints
                    fresh = [row for row in fresh if _fingerprint(table, row, common) not in prints]
            repeated = len(table.rows) - len(fresh)
            if kept and repeated > 1:
                why = f"repeats {repeated} runs that stand above"
                table.rows = fresh
            if table.rows:
                kept.append(table)
                alike.setdefault(parts, []).append(table)
        if why:
            what = f'the table below line {table.cells[0].line} ("{table.cells[0].text[:40]}", …)'
            faults.add(TABLE_LEFT_OUT, f"{what} {why}: left out", "", table.cells[0])
    return kept


def _is_timed(table: _Table) -> bool:
    return bool(table.roles.intersection(TIMINGS)) or any(turns_in(cell.text) for cell in table.cells)


def _is_of_means(table: _Table) -> bool:
    timings = [header for header in table.headers if set(header.roles).intersection(TIMINGS)]
    return is_of_means(table.title) or (bool(timings) and all(is_of_means(header.text) for header in timings))


@lru_cache(maxsize=4096)
def is_of_means(header: str) -> bool:
    """Tell whether a column holds means, by its name."""
    return any(squeeze(word).lower() in MEAN_WORDS for word in re.split(r"[\s_,;()\[\]\-]+", header))


def _parts(table: _Table) -> frozenset[str]:
    """Name the parts of a run that a table has columns for, or a caption."""
    named = {header.roles[0] for header in table.headers if header.roles and header.roles[0] in BY_NAME}
    return frozenset(role for role in named if BY_NAME[role].part) | frozenset(table.given)


def _fingerprint(table: _Table, row: Row, among: frozenset[str]) -> tuple[str, ...]:
    """Give what was typed of some parts of a run, which no two runs have in common."""
    parts = {role: text for role, (text, _) in table.given.items() if role in among}
    for at, header in enumerate(table.headers):
        role = header.roles[0] if header.roles else ""
        if at < len(row.texts) and role in among:
            parts[f"{role} {header.number or ''}"] = row.texts[at]
    return tuple(sorted(f"{role.strip()} {text}" for role, text in parts.items()))


def _join(tables: list[_Table], grid: Grid, faults: Faults) -> Layout | None:
    """Make one table of all of them; None, with a diagnostic, where they do not go together."""
    first = tables[0]
    if len(tables) == 1 and not first.given:
        return Layout(grid, first.cells, first.headers, first.rows)
    cells, headers = list(first.cells), list(first.headers)
    wanted = _wanted(first)
    rows: list[Row] = []
    for table in tables:
        lost = _wanted_but_lost(wanted, table)
        if lost:
            sample = BY_NAME[lost].sample
            above = f'in the line above it, such as "{lost} {sample}", or ' if sample else ""
            hint = f"write what holds for its runs {above}as a column; or put # before its lines if they are no runs"
            message = f"the table below line {table.head.line} has no {lost}, and the first table has one"
            faults.add(BLOCKS_STACKED, message, hint, grid.cell(table.head, _filled(table.head)[0]))
            return None
        places = _place_columns(table, cells, headers, grid, faults)
        if places is None:
            return None
        if not _begins_whole(table, faults, table.head is not first.head, grid):
            return None
        for role in table.given:
            if not any(header.roles == (role,) for header in headers):
                line, at = table.given[role][1]
                place = grid.cell(Row(line, [""] * (at + 1)), at)
                cells.append(replace(place, text=role))
                headers.append(Header(role, (role,), None, ""))
        given = {
            at: table.given[h.roles[0]]
            for at, h in enumerate(headers)
            if len(h.roles) == 1 and h.roles[0] in table.given
        }
        rows += [_moved(row, places, given, len(cells)) for row in table.rows]
    rows = [_moved(row, range(len(row.texts)), {}, len(cells)) for row in rows]
    if len(tables) > 1:
        lines = ", ".join(span([row.line for row in table.rows]) for table in tables)
        faults.add(TABLES_JOINED, f"{len(tables)} tables are read as one: {lines}", "", first.cells[0])
    return Layout(grid, cells, headers, rows)


def _wanted(table: _Table) -> set[str]:
    """Name the parts of a run that a table tells of."""
    return {
        BY_NAME[role].part if BY_NAME[role].part in ("spin", "count", "timing") else role
        for role in table.roles
        if role in BY_NAME and BY_NAME[role].part
    }


def _wanted_but_lost(wanted: set[str], table: _Table) -> str:
    """Name what a table lacks of what the first one tells; "" if nothing."""
    there = _wanted(table)
    names = {"count": "turns", "timing": "time"}
    for part in sorted(wanted - there):
        if part == "torque" or (part == "count" and any(turns_in(cell.text) for cell in table.cells)):
            continue
        return names.get(part, part)
    return ""


def _place_columns(
    table: _Table, cells: list[Text], headers: list[Header], grid: Grid, faults: Faults
) -> list[int] | None:
    """Find the column of the whole for each column of a table; new ones are added."""
    places: list[int] = []
    for at, (cell, header) in enumerate(zip(table.cells, table.headers, strict=True)):
        if at < len(cells) and cells[at] == cell:
            places.append(at)
            continue
        same = [k for k, other in enumerate(cells) if cell.text and squeeze(other.text) == squeeze(cell.text)]
        same += [
            k
            for k, other in enumerate(headers)
            if len(header.roles) == 1 and replace(other, text=header.text) == header
        ]
        same += [
            k
            for k, other in enumerate(headers)
            if len(header.roles) == 1 and other.roles == header.roles and other.number == header.number
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


def _begins_whole(table: _Table, faults: Faults, is_later: bool, grid: Grid) -> bool:
    """Refuse a later table whose first row leaves blank what stands further down: nothing above it holds for it."""
    for at, header in enumerate(table.headers if is_later and table.rows else ()):
        texts = [row.texts[at] if at < len(row.texts) else "" for row in table.rows]
        fills = len(header.roles) == 1 and header.roles[0] in FILLED_DOWN and header.roles[0] not in table.given
        if fills and not texts[0] and header.roles[0] != "position":
            message = f"{header.roles[0]} is blank in line {table.rows[0].line}, the first row of its table"
            hint = "write each value in the first row that it belongs to"
            faults.add(BLOCKS_STACKED, message, hint, table.cells[at])
            return False
    return True


def _moved(row: Row, places: list[int] | range, given: dict[int, tuple[str, tuple[int, int]]], width: int) -> Row:
    """Put the cells of a row where the columns of the whole are, with what its caption gives."""
    texts = [""] * (width + len(row.texts))
    origin = [(row.line, 0)] * len(texts)
    natural = row.origin or tuple((row.line, at) for at in range(len(row.texts)))
    for at, text in enumerate(row.texts):
        place = places[at] if at < len(places) else width + at - len(places)
        texts[place], origin[place] = text, natural[at]
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
    for at, header in enumerate(layout.headers):
        if "time" not in header.roles or len(layout.rows) < _LEAST_OF_A_SERIES:
            continue
        try:
            times = [to_float(fold_number(row.texts[at])) for row in layout.rows[:2000]]
        except (ValueError, IndexError):
            continue
        steps = [later - earlier for earlier, later in pairwise(times)]
        usual = sorted(steps)[len(steps) // 2]
        even = sum(0.5 * usual <= step <= 1.5 * usual for step in steps) >= 0.9 * len(steps)
        if min(steps) >= 0 and usual > 0 and even:
            message = f"the {len(layout.rows)} times go up evenly: this is a time series, and one row a run is read"
            hint = (
                "work out the spin and the time of some turns of each run from it, and write one row for each run: "
                "mass [g], position [cm], spin [rpm], time [s], turns"
            )
            faults.add(TIME_SERIES, message, hint, layout.cells[at])
            return True
    return False


def _is_transposed(grid: Grid, faults: Faults) -> bool:
    rows = grid.rows[:20]
    named = [
        row
        for row in rows
        if len(row.texts) > 1
        and parse_header(row.texts[0]).roles
        and all(is_number(text) or text in BLANKS for text in row.texts[1:])
    ]
    if not named or named[0] is not rows[0] or _numbers(rows[0]) == 0 or len(named) * 2 < len(rows):
        return False
    names = listing([row.texts[0] for row in named])
    hint = "turn it: one column for each quantity, one row for each run (in a spreadsheet: Paste special, Transpose)"
    message = f"the names stand at the side ({names}): the table is transposed"
    faults.add(TABLE_TRANSPOSED, message, hint, grid.cell(rows[0], 0))
    return True


def _is_parted(head: list[Text], headers: list[Header], faults: Faults) -> bool:
    """Find ``m, g`` that became two cells, which shifts every column behind it."""
    for cell, unit, header in zip(head, head[1:], headers, strict=False):
        alone = bool(kinds_of(unit.text)) and not parse_header(unit.text).roles
        if alone and header.roles and header.unit is None:
            message = f'"{unit.text}" stands alone in its cell: is it the unit of "{cell.text}"?'
            faults.add(
                HEADER_PARTED_BY_COMMA, message, f'write "{cell.text} [{unit.text}]", or put the header in quotes', unit
            )
            return True
    return False


def _is_parted_count(table: _Table, faults: Faults) -> bool:
    """Find ``period [s], 5 turns`` that became two cells: the rows have none for the turns."""
    width = max((len(row.texts) for row in table.rows), default=len(table.cells))
    if not 0 < width < len(table.cells):
        return False
    before = table.headers[width - 1]
    for cell, header in zip(table.cells[width:], table.headers[width:], strict=True):
        # A time whose cells are all blank is another fault.
        if (turns := turns_in(cell.text)) and (header.unit is None or before.unit is None):
            message = f'"{cell.text}" has no cell in any row: the header has {len(table.cells)} cells, the rows {width}'
            hint = (
                f'write one name without a comma for "{table.cells[width - 1].text}", as "time for {turns} turns [s]"'
            )
            faults.add(HEADER_PARTED_BY_COMMA, message, hint, cell)
            return True
    return False


def _repeats_a_header(head: list[Text], faults: Faults) -> bool:
    seen: set[str] = set()
    found = False
    for cell in head:
        key = " ".join(cell.text.split())
        if key and key in seen:
            hint = "name repeats of one time time_1, time_2, …; rename or remove the other columns"
            faults.add(HEADER_STANDS_TWICE, f'two columns are called "{cell.text[:60]}"', hint, cell)
            found = True
        seen.add(key)
    return found
