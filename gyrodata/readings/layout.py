"""Find titles, headers, units, runs, means and notes in a sheet, and join several tables.

A row of a sheet is a header, a row of units, a run, a summary or text. A sheet is read as a teaching assistant reads
it: what is not a run is left out, what a caption says holds for the runs below it, and one line for each says so.
"""

from __future__ import annotations

import re
from bisect import bisect
from collections import Counter
from collections.abc import Collection
from decimal import Decimal, DecimalException
from functools import lru_cache
from itertools import accumulate, pairwise
from statistics import fmean

from msgspec import Struct
from msgspec.structs import replace

from gyrodata import diagnostics as codes
from gyrodata import vocabulary
from gyrodata.quantities import NUMBER, PLAIN, fold_number, to_float
from gyrodata.readings import roles
from gyrodata.readings.lablog import BLANKS, PREFIX, Faults, Text, listing, span
from gyrodata.readings.roles import TEXTS, Header, kind_of_role, parse_header, squeeze, turns_in
from gyrodata.readings.source import MAX_COLUMNS, Grid, Row, find_place
from gyrodata.units import kinds_of

_HINT = (
    "write one row for each run (in a spreadsheet, Paste special, Transpose turns a table), and above them the names "
    "of the columns, without # before them, such as: mass [g], position [cm], spin [rpm], time [s], turns"
)
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


_Column = tuple[Text, Header]
_Given = dict[str, tuple[str, int]]
"""What captions say of runs: text and number of the cell by role."""


class _TableError(Exception):
    """Rows that are not one table of runs: code, message, hint and cell."""


def find_layout(grid: Grid, faults: Faults) -> Layout | None:
    """Find the header and the rows; None, with diagnostics, if there is no such table."""
    try:
        if not grid.rows:
            raise _TableError(codes.NO_HEADER_ROW, "there is no table in this log", _HINT)
        is_table = any(map(_is_head, grid.rows))
        sentences = [] if is_table else _rows_of_sentences(grid)
        if sentences:
            grid = replace(grid, rows=sentences)
        elif not is_table and _is_head(names := Row(0, [row.texts[0] for row in grid.rows])):
            message = f"the names are at the side ({listing(names.texts, 3)}): the table is read from top to bottom"
            faults.add(codes.TABLE_IS_TURNED, message, "", grid.cell(grid.rows[0], 0))
            grid = _turned(grid)
        elif max(len(row.texts) for row in grid.rows) == 1:
            hint = "put a comma, a semicolon or a tab between the columns"
            message = "no delimiter between the columns was found"
            raise _TableError(codes.NO_DELIMITER, message, hint, grid.cell(grid.rows[0], 0))
        head = grid.rows[_find_head(grid)]
        grid = _with_captions(grid, head)
        sheet = _Sheet(grid, faults)
        sheet.any_timed = any(_is_timed(row.texts) for row in grid.rows if _is_head(row))
        for words, names, rows in _blocks(grid.rows, grid.rows.index(head)):
            sheet.words += words
            sheet.begin(names)
            for row in rows:
                sheet.take(row)
        return sheet.finish()
    except _TableError as fault:
        faults.add(*fault.args)
        return None


def _with_captions(grid: Grid, head: Row) -> Grid:
    """Add the lines behind # that say what no column and no key says, such as "# each time is for one full turn"."""
    said = [(f"# {text.text}", text.line) for text in grid.comments]
    said += [
        (f"# {key}: {text.text}", text.line)
        for key, text in grid.metadata
        if key.lower() not in roles.KEYS and not key.lower().startswith(PREFIX)
    ]
    heads = [row for row in grid.rows if _is_head(row)] or [head]
    lacking = _lacking([parse_header(text) for row in heads for text in row.texts]) - _stated(grid)
    there = {row.line for row in grid.rows}
    captions = [Row(line, [text]) for text, line in said if line not in there]
    captions = [row for row in captions if lacking.intersection(_said(row))]
    return replace(grid, rows=sorted([*grid.rows, *captions], key=lambda row: row.line))


def _stated(grid: Grid) -> set[str]:
    """Name what lines such as "# turns: 1" say, which a caption does not change."""
    keys = {key.lower() for key, _ in grid.metadata}
    return keys | ({"turns"} if keys.intersection(("angle", *roles.ONE_TURN)) else set())


_SENTENCE_ROLES = ("mass", "position", "spin", "turns", "time")


def _rows_of_sentences(grid: Grid) -> list[Row]:
    """Make a table of lines such as "20.1 g, 400 rpm: one turn took 12.3 s", or of one line for each quantity.

    A line with a spin and a time is a run. Other lines are captions of the runs below them.
    """
    parts: list[tuple[int, str, dict[str, tuple[str, int]]]] = []
    block: list[tuple[int, str, dict[str, tuple[str, int]]]] = []
    for index in range(grid.rows[0].line - 1, grid.rows[-1].line + 1):
        line = grid.lines[index] if index < len(grid.lines) else ""
        said = _said(Row(index + 1, [re.sub(r"^\s*\(?[0-9]{1,2}[.):、]\s+", "", line)]), with_time=True)
        if line.lstrip().startswith("#") and {"spin", "time"} <= said.keys():
            continue  # a run that was taken out
        if said:
            block.append((index + 1, line, said))
            continue
        names = [name for *_, one in block for name in one]
        if len(set(names)) == len(names) and {"spin", "time"} <= set(names):
            block = [(block[0][0], "", {name: item for *_, one in block for name, item in one.items()})]
        parts += block
        block = []
        if line.strip():
            parts.append((index + 1, line, {}))
    runs = [said for *_, said in parts if {"spin", "time"} <= said.keys()]
    there = [role for role in _SENTENCE_ROLES if any(role in said for said in runs)]
    rows: list[Row] = []
    for number, text, said in parts if len(runs) > 1 else ():
        if not {"spin", "time"} <= said.keys():
            rows.append(Row(number, [text.strip()]))
            continue
        if not rows or len(rows[-1].texts) == 1:
            rows.append(Row(number, list(there)))
        spots = (number * MAX_COLUMNS,) * len(there)
        rows.append(Row(number, [said.get(role, ("", 0))[0] for role in there], spots))
    return rows


def _turned(grid: Grid) -> Grid:
    """Transpose a sheet; a single value next to its name is valid for all runs."""
    width = max(len(row.texts) for row in grid.rows)
    alone = [len(row.texts) == 2 < width for row in grid.rows]
    rows = []
    for at in range(width):
        places = [1 if at and one else at for one in alone]
        cells = [
            (row.texts[k] if k < len(row.texts) else "", row.spot(k)) for row, k in zip(grid.rows, places, strict=True)
        ]
        rows.append(Row(grid.rows[0].line, [text for text, _ in cells], tuple(spot for _, spot in cells)))
    return replace(grid, rows=rows)


# What a row is ----------------------------------------------------------------------------------------------------


def is_number(text: str) -> bool:
    """Tell whether a cell begins like a number."""
    return text[:1].isdigit() or (text[:1] in "+-−.,(" and text[1:2].isdigit())


def _numbers(row: Row) -> int:
    return sum(is_number(text) and not parse_header(text).roles for text in row.texts)


def _filled(row: Row) -> list[int]:
    return [at for at, text in enumerate(row.texts) if text]


def _is_head(row: Row) -> bool:
    """Tell a header by two names, one of them that of a quantity."""
    headers = list(map(parse_header, filter(None, row.texts)))
    named = [header.roles for header in headers if header.roles]
    physical = any(not TEXTS.intersection(found) for found in named)
    return len(named) > 1 and physical and _numbers(row) * 2 < len(headers) and not _units(row)


def _units(row: Row) -> list[str]:
    """Read a row of units, in brackets or not; none if it is no such row."""
    units = [text[1:-1].strip() if text[:1] + text[-1:] in ("[]", "()") else text for text in row.texts]
    is_unit = [unit == "%" or bool(kinds_of(unit) and not PLAIN.fullmatch(unit)) for unit in units]
    others = [pair for pair, known in zip(zip(units, row.texts, strict=True), is_unit, strict=True) if not known]
    return units if any(is_unit) and all(unit in BLANKS or unit != text for unit, text in others) else []


def _is_summary(row: Row, headers: list[Header]) -> bool:
    """Find a row of means, deviations or sums by its first word, which is not a note on a run."""
    at = _filled(row)[0]
    text = row.texts[at]
    words = re.split(r"[\s_:,;(=]+", text)[0], re.sub(r"[()=:]", "", text)
    is_note = at < len(headers) and "note" in headers[at].roles
    return not is_note and not roles.SUMMARY_WORDS.isdisjoint(squeeze(word).lower() for word in words)


_SENTENCE = r"[^\W\d_]{3,}\W+[^\W\d_]{3,}"
"""Two words: "2 reflective strips" is not a number with its unit."""


def _is_text(row: Row, headers: list[Header]) -> bool:
    """Return whether a row is a title or a note, but not a remark on a run; or quantities without a column."""
    filled = _filled(row)
    texts = [row.texts[at] for at in filled]
    numbers = {at for at in filled if is_number(row.texts[at]) and not re.search(_SENTENCE, row.texts[at])}
    if numbers:
        said = _said(row) if len(numbers) < 4 else {}
        return bool(said) and numbers <= {at for *_, at in said.values()} and _lacking(headers).issuperset(said)
    kinds = [(at, kind_of_role(role)) for at in filled if at < len(headers) for role in headers[at].roles]
    remark = any(kind == "sign" or (kind == "text" and at > 0) for at, kind in kinds)
    return BLANKS.isdisjoint(texts) and not remark


@lru_cache(maxsize=4096)
def is_of_means(header: str) -> bool:
    """Return whether a column contains means, by its name."""
    return any(squeeze(word).lower() in roles.MEAN_WORDS for word in re.split(r"[\s_,;()\[\]\-]+", header))


def _is_timed(names: list[str]) -> bool:
    return any(turns_in(name) or set(parse_header(name).roles).intersection(roles.TIMINGS) for name in names)


# What a caption says -----------------------------------------------------------------------------------------------


def _any_of(key: str) -> str:
    return f"(?:{vocabulary.words(key, '|')})"


_AMOUNT = rf"(?:[0-9]{{1,2}}\s*[x×*·]\s*)?{NUMBER}(?:\([0-9]+\)|\s*(?:±|\+/-|\+-)\s*{NUMBER})?"
_UNIT = r"[^\W\d_][\w/^*·]*"
_QUANTITY = rf"(?<![^\W\u2e80-\uffef])(?<![.,])({_AMOUNT})\s*({_UNIT})|[\[(]({_UNIT})[\])]\W*({_AMOUNT})"
"""A number and its unit: "20.1 g", or "(g)" with "20.1" in the next cell."""
_MOVED = frozenset(vocabulary.words("moved").split())
_SAID_KINDS = {"mass": "mass", "length": "position", "rate": "spin"}
_BALL, _WEIGHT = (f"(?i){vocabulary.words(key, '|')}" for key in ("sphere", "weight_added"))
_SAYS_NOTHING = re.compile(
    rf"(?i)^\W*(?:{_any_of('article')}\s*)*{_any_of('ball')}\b(?!.*{_any_of('weight_added')})"
    rf"|(?<![\w.,])(?:[2-9]|{_any_of('several')})\s+(?:[^\W\d]+\s+)?{_any_of('several_weights')}|[0-9]\s*k?g\s*\+\s*[0-9]"
)
"""Lines whose quantities hold for no run: "Steel ball, m = 4.28 kg", "2 weights of 20 g", "wait 2 turns"."""


_TIME_WORDS = {squeeze(word).lower() for word in re.split(r"[\s,]+", vocabulary.words("time", ",")) if len(word) > 2}
_TIMED = rf"(?i)\b(?:{vocabulary.words('timed', '|')})|{'|'.join(word for word in _TIME_WORDS if word > chr(0x2E80))}"
"""Verbs of a measurement, and words for a time in languages without blanks between words."""
_DEFINITION = r"(?i)(?:[=:]|\b(?:is|are|ist|sind|est|es|è))\s*(?:360|2\s*(?:pi|π))|360\D{0,9}="
"""What a turn is: "one turn = 360 deg"."""


def _turns_stated(whole: str, found: Collection[str]) -> str:
    """Return the turns that a line states for the times of runs; "" for a line about other turns.

    Such a line names a time, or a mass of a run, or it contains hardly anything else.
    """
    turns, parts = turns_in(whole), set(re.findall(r"[1-9]\s*/\s*[2-9]", whole))
    if not turns or len(parts) > 1 or re.search(_DEFINITION, whole):
        return ""
    words = {word for word in roles.squeezed_words(re.sub(_QUANTITY, " ", whole)) if not word.isdecimal()}
    # "Zeiten" and "times" are plurals.
    timed = any(word[:size] in _TIME_WORDS for word in words for size in range(max(3, len(word) - 2), len(word) + 1))
    if "mass" in found or timed or re.search(_TIMED, whole):
        return turns
    others = [word for word in words if len(word) > 2 and not roles.is_of_turns(word) and not roles.name_roles(word)[0]]
    return turns if len(others) < 2 else ""


def _said(row: Row, with_time: bool = False) -> dict[str, tuple[str, int]]:
    """Read "Weight 1: 20.1 g at 14.8 cm": text and cell of each quantity by role; none of which two are told."""
    filled = _filled(row)
    # "x = 15,5 cm" above a table whose cells are parted by commas is one number.
    whole = "\0".join(row.texts[at] for at in filled)
    whole = re.sub(r"([=:]\s*[0-9]+)\0(?=[0-9]{1,3}\s*[^\W\d])", r"\1,", whole).replace("\0", " ")
    found: dict[str, dict[str, int]] = {}
    ends = list(accumulate(len(row.texts[at]) + 1 for at in filled))
    end = 0
    scanned = re.sub(r"[\[(]([^()\[\]]*)[\])]", lambda one: one[0] if kinds_of(one[1]) else f" {one[1]} ", whole)
    for match in re.finditer(_QUANTITY, scanned):
        words = re.split(r"[\s,;:()=]+", whole[end : match.start()]) + whole[match.end() :].split()[:1]
        beside = {squeeze(word).lower() for word in words}
        beside -= {"to"} if beside & _MOVED else set()
        clause = whole[end : match.end()] + (re.match(r"\s*\([^()]*\)", whole[match.end() :]) or [""])[0]
        end = match.end()
        number, unit = match[1] or match[4], match[2] or match[3]
        if match.start() in ends and number.isdigit() and whole[match.start() - 2].isdigit():
            continue  # "Position 15,5 cm" may be parted at its decimal comma
        kinds = _SAID_KINDS | ({"time": "time"} if with_time else {})
        role = next((role for kind, role in kinds.items() if kind in kinds_of(unit)), "")
        role = "" if role == "position" and roles.origin_in(whole) else role
        of_the_ball = re.search(_BALL, clause) and not roles.from_centre(clause) and not re.search(_WEIGHT, clause)
        if role and (roles.from_centre(clause) or not (of_the_ball or beside & roles.NOT_THE_WEIGHT)):
            at = filled[bisect(ends, match.start(1 if match[1] else 4))]
            found.setdefault(role, {}).setdefault(f"{number} {unit}", at)
    turns = _turns_stated(whole, found)
    for part in (*row.texts, *re.split(r"[,;،；，]\s+", whole)):
        name, *rest = re.split(r"\s*[:=：]\s*", part, maxsplit=1)
        name, *rest = (name, *rest) if rest else part.rsplit(maxsplit=1) or [""]
        if rest and parse_header(name).roles == ("turns",):  # "Number of turns: 1/3", "turns 1"
            turns = turns_in(f"{rest[0]} turns")
    if turns:
        found["turns"] = {turns: filled[-1]}
    found = {} if _SAYS_NOTHING.search(whole) else found
    if re.search(f"(?i){_any_of('not_timed')}", whole):
        found = {role: items for role, items in found.items() if role == "position" and roles.from_centre(whole)}
    return {role: item for role, items in found.items() for item in items.items() if len(items) == 1}


def _lacking(headers: list[Header]) -> set[str]:
    """Name what a caption may say of a table: what no column of it contains."""
    there = {role for header in headers for role in header.roles}
    if there & {"angle", *roles.TIMINGS[1:]} or any(turns_in(header.text) for header in headers):
        there.add("turns")
    if "torque" in there:
        there |= {"mass", "position"}
    if "force" in there or any(map(roles.counts_weights, headers)):
        there.add("mass")
    if any(role.startswith("spin") for role in there):
        there.add("spin")
    return {"mass", "position", "spin", "turns"} - there


# From row to row ---------------------------------------------------------------------------------------------------

_LEFT_OUT = {
    codes.ROW_IS_ONLY_A_TITLE: "text, not a run",
    codes.ROW_TAKEN_OUT: "taken out with # or by striking it out",
    codes.SUMMARY_LEFT_OUT: "worked out from runs, not a run",
}


class _Sheet:
    """Goes down the rows of a sheet, and makes one table of all runs."""

    def __init__(self, grid: Grid, faults: Faults) -> None:
        self.grid, self.faults = grid, faults
        self.columns: list[_Column] = []
        """Those of all tables."""
        self.runs: list[tuple[Row, list[int], _Given]] = []
        """Each with the columns of its cells, and what its caption gives."""
        self.tables: list[int] = []
        """Number of the first run of each table."""
        self.words: list[Row] = []
        """Rows of text that no run has followed yet."""
        self.left_out: dict[str, list[tuple[Row, int]]] = {code: [] for code in _LEFT_OUT}
        """Rows that are no runs, with the cell that says so."""
        self.general: _Given = {}
        """What captions say of all tables."""
        self.said: list[tuple[str, Text]] = []
        """What was read of each caption."""
        self.any_timed = self.only_means = False
        self.told: set[str] = set()
        """Parts of a run that the first table gives."""

    def begin(self, head: Row) -> None:
        """Begin a table with its header row."""
        self.head = head
        self.here = [(self.grid.cell(head, at), parse_header(text)) for at, text in enumerate(head.texts)]
        for at, ((_, left), (cell, header)) in enumerate(pairwise(self.here), 1):
            sign = squeeze(roles.split_unit(cell.text)[0]).lower()
            if len(left.roles) == 1 and (sign in roles.UNSURE_WORDS or sign in ("±", "+/-", "+-")):
                # "±" or "error" belongs to the column on its left.
                unit = header.unit or left.unit
                self.here[at] = (
                    replace(cell, text=f"u({left.text})"),
                    replace(header, roles=(f"u_{left.roles[0]}",), unit=unit),
                )
        self.fresh, self.skipped = True, False
        self.places: list[int] = []
        self.given: _Given = dict(self.general)

    def take(self, row: Row) -> None:
        """Take the next row for what it is."""
        headers = [header for _, header in self.here]
        if _is_head(row):
            if self.fresh and not self.words:
                self._leave_out(codes.ROW_IS_ONLY_A_TITLE, self.head)  # a row of names above the header
            self.begin(row)
        elif self.fresh and (units := _units(row)):
            for at, (unit, header) in enumerate(zip(units, headers, strict=False)):
                if unit not in BLANKS and header.unit is None:
                    # Minutes and seconds are below one "time".
                    named = roles.with_unit(header if header.text or not at else headers[at - 1], unit)
                    self.here[at] = self.here[at][0], named
        elif self.fresh and (below := self._names_below(row)):
            self.here = below
        elif row.texts[0] == "#":
            self._leave_out(codes.ROW_TAKEN_OUT, row)  # a # that a spreadsheet put into a cell of its own
        elif _is_summary(row, headers):
            self._leave_out(codes.SUMMARY_LEFT_OUT, row)
        elif _is_text(row, headers):
            self.words.append(row)
        else:
            self._take_run(row)

    def _leave_out(self, code: str, row: Row) -> None:
        self.left_out[code].append((row, _filled(row)[0]))

    def _names_below(self, row: Row) -> list[_Column]:
        """Read a second row of names below merged cells: "Time (s)" over 1, 2, 3; none if it is no such row."""
        # A header merged over the last columns leaves its row shorter.
        more = len(row.texts) - len(self.here)
        if more <= 0 and all(cell.text for cell, _ in self.here):
            return []
        named = [*self.here, *[(replace(self.here[-1][0], text=""), parse_header(""))] * more]
        over = ""
        for at, text in enumerate(row.texts):
            over = named[at][0].text or over
            name, unit = roles.split_unit(over)
            if turns_in(over) and (number := re.search("[1-9]", text)):
                named[at] = (replace(named[at][0], text=f"{name} {number[0]} [{unit}]"), parse_header(over))
                continue  # "1st, 2nd, 3rd" below "Time of one turn (s)"
            if text and not (parse_header(text).roles and parse_header(text).unit):
                text = f"{name} {text.rstrip('.')}" + (f" [{unit}]" if unit else "")
            if text and not parse_header(text).roles:
                return []
            if text:
                named[at] = replace(named[at][0], text=text), parse_header(text)
        return named

    def _take_run(self, row: Row) -> None:
        is_first, self.fresh = self.fresh, False
        if is_first:
            self._begin_runs()
        typed = {role for (_, header), text in zip(self.here, row.texts, strict=False) if text for role in header.roles}
        self.given = {role: one for role, one in self.given.items() if role not in typed}
        if self.words:
            # "moved to 10.0 cm" between the runs is valid for the blank cells below it, until another value is typed.
            blank = set() if is_first else {"mass", "position"} - typed
            lacking = blank | _lacking([header for _, header in self.here])
            if any(
                roles.are_turns(header, [text]) for (_, header), text in zip(self.here, row.texts, strict=False) if text
            ):
                lacking.discard("turns")
            self.given |= self._read_captions(lacking)
        if self.skipped:
            return
        width = len(self.places)
        remarks = [at for at in range(width, len(row.texts)) if row.texts[at]]
        if remarks and not any(is_number(row.texts[at]) for at in remarks):
            self.left_out[codes.ROW_IS_ONLY_A_TITLE].append((row, remarks[0]))
            row = Row(row.line, row.texts[:width], row.origin)
        if is_first:
            self._check_first(row)
        self.runs.append((row, self.places, self.given))

    def _begin_runs(self) -> None:
        """Give the columns of a table their places among all columns, unless its rows are no runs."""
        names = [cell.text for cell, _ in self.here]
        timings = [header.text for _, header in self.here if set(header.roles).intersection(roles.TIMINGS)]
        title = " ".join(text for words in self.words for text in words.texts if text[:1] != "#")
        means = is_of_means(title) or (bool(timings) and all(map(is_of_means, timings)))
        untimed = self.any_timed and not _is_timed(names)
        if untimed or (means and self.runs and not self.only_means):
            self.skipped = True
            why = "has no times of runs" if untimed else "contains means"
            message = f'the table below line {self.head.line} ("{names[0][:40]}", …) {why}: left out'
            self.faults.add(codes.TABLE_LEFT_OUT, message, "", self.here[0][0])
            return
        self.only_means = means if not self.runs else self.only_means
        for at, (cell, header) in enumerate(self.here):
            if cell.text and cell.text in names[:at]:
                hint = "name repeats of one time time_1, time_2, …; rename or remove the other columns"
                raise _TableError(codes.HEADER_STANDS_TWICE, f'two columns are called "{cell.text[:60]}"', hint, cell)
            free = [k for k in range(len(self.columns)) if k not in self.places]
            place = next((k for k in free if _is_same(self.columns[k], (cell, header))), len(self.columns))
            if place == len(self.columns):
                self.columns.append((cell, header))
            elif self.columns[place][1].unit != header.unit and header.roles:
                first = self.columns[place][0].text
                message = f'the table below line {cell.line} has "{cell.text}", and the first has "{first}"'
                hint = f'give the columns of all tables the same units: write "{first}" and its numbers'
                raise _TableError(codes.BLOCKS_STACKED, message, hint, cell)
            self.places.append(place)

    def _check_first(self, row: Row) -> None:
        """Refuse a later table if its first row lacks a quantity of the first table."""
        headers = [header for (_, header), text in zip(self.here, row.texts, strict=False) if text]
        told = {role for header in headers for role in header.roles} | set(self.given)
        if not self.tables:
            self.told = told & {*roles.FILLED_DOWN, *roles.TIMINGS} - {"torque"}
        self.tables.append(len(self.runs))
        if any("position" in header.roles for _, header in self.here):
            told.add("position")  # blank in a run without a weight
        if lost := sorted(self.told - told):
            message = (
                f"the table below line {self.head.line} has no {lost[0]} in its first row; the first table has one"
            )
            hint = (
                f'write it there, or in the line above the table, such as "{lost[0]} {roles.BY_NAME[lost[0]].sample}"; '
            )
            hint += "or put # before its lines if they are no runs"
            raise _TableError(codes.BLOCKS_STACKED, message, hint, self.here[0][0])

    def _read_captions(self, lacking: set[str], where: str = "below") -> _Given:
        """Find what the rows of text above a run say of what is lacking in it.

        Above the first table the last row that says something is of this table; those before it are of all tables.
        """
        found: _Given = {}
        lacking = lacking - _stated(self.grid)
        for row in self.words:
            if said := {role: (text, row.spot(at)) for role, (text, at) in _said(row).items() if role in lacking}:
                told = ", ".join(f"{role} {text}" for role, (text, _) in said.items())
                message = f"line {row.line} says it for the runs {where} it: {told}"
                self.said.append((message, self.grid.cell(row, _filled(row)[0])))
                if not self.runs and found:
                    self.general = dict(found)
                found |= said
            elif not row.texts[0].startswith("#"):
                self._leave_out(codes.ROW_IS_ONLY_A_TITLE, row)
        self.words = []
        return found

    def finish(self) -> Layout:
        """Give all runs as one table, and say what was left out."""
        lacking = _lacking([header for _, header in self.columns]).difference(*(given for *_, given in self.runs))
        below = self._read_captions(lacking, "above")
        self.runs = [(row, places, below | given) for row, places, given in self.runs]
        for role, (_, spot) in {role: one for *_, given in self.runs for role, one in given.items()}.items():
            if not any(header.roles == (role,) for _, header in self.columns):
                place = find_place(self.grid.lines, self.grid.delimiter, spot)
                self.columns.append((Text(role, *place), Header(role, (role,), None, "")))
        headers = [header for _, header in self.columns]
        moved = [_moved(row, places, given, headers) for row, places, given in self.runs]
        parts = [moved[start:end] for start, end in pairwise([*self.tables, len(moved)])]
        for part in parts:
            if _ends_with_means(part, headers):
                self._leave_out(codes.SUMMARY_LEFT_OUT, part.pop())
        self._tell()
        if not self.runs:
            hint = "write one row for each timed run"
            raise _TableError(codes.HEADER_WITHOUT_RUNS, "there is a header, but not one run below it", hint)
        seen: set[tuple[str, ...]] = set()
        for part in parts:
            texts = [tuple(row.texts[: len(self.runs[0][1])]) for row in part]
            if sum(one in seen for one in texts) > 1:
                message = f"the table with line {part[0].line} repeats runs that stand above"
                hint = "a run counts once: delete this table, or put # before its lines"
                raise _TableError(codes.BLOCKS_STACKED, message, hint, self.grid.cell(part[0], _filled(part[0])[0]))
            seen.update(texts)
        if len(parts) > 1:
            lines = ", ".join(span([row.line for row in part]) for part in parts)
            message = f"{len(parts)} tables are read as one: {lines}"
            self.faults.add(codes.TABLES_JOINED, message, "", self.columns[0][0])
        rows = [row for part in parts for row in part]
        self._check_columns(rows)
        return _with_differences(Layout(self.grid, [cell for cell, _ in self.columns], headers, rows), self.faults)

    def _tell(self) -> None:
        """Say which rows were left out, and what was read of captions."""
        for code, left in self.left_out.items():
            if left:
                lines = span(sorted({row.line for row, _ in left}))
                message = f"{lines} left out ({_LEFT_OUT[code]}): {listing([row.texts[at] for row, at in left], 4)}"
                hint = "put # before the line to keep it as a remark; what it says of the runs goes into a column"
                hint = hint if code == codes.ROW_IS_ONLY_A_TITLE else ""
                for origin in filter(None, (roles.origin_in(" ".join(row.texts)) for row, _ in left)):
                    length = {"surface": "ball_diameter: 10.16 cm", "tip": "rod_length: 25.0 cm"}[origin]
                    hint = f'if positions count from the {origin}: "# position_from: {origin}" and "# {length}" above'
                self.faults.add(code, message, hint, self.grid.cell(*left[0]))
        for message, cell in self.said:
            self.faults.add(codes.CAPTION_READ, message, "", cell)

    def _check_columns(self, rows: list[Row]) -> None:
        """Refuse a header that its own comma parts: "period [s], 5 turns"."""
        for at, ((cell, header), (behind, other)) in enumerate(pairwise(self.columns), 1):
            turns = turns_in(behind.text) if cell.text and (header.unit is None or other.unit is None) else ""
            if turns and not any(row.texts[at : at + 1] for row in rows):
                message = f'"{behind.text}" stands alone in its cell: is it a part of "{cell.text}"?'
                hint = f'write one name without a comma, as "time for {turns} turns [s]"'
                raise _TableError(codes.HEADER_PARTED_BY_COMMA, message, hint, behind)


def _is_same(one: _Column, other: _Column) -> bool:
    """Tell whether columns of two tables have the same name, or mean the same."""
    named = squeeze(one[0].text) == squeeze(other[0].text) != ""
    return named or (len(one[1].roles) == 1 and (one[1].roles, one[1].number) == (other[1].roles, other[1].number))


def _moved(row: Row, places: list[int], given: _Given, headers: list[Header]) -> Row:
    """Put the cells of a row where the columns of the whole are, with what its caption gives."""
    width = len(headers)
    if not given and places == list(range(width)):
        return row
    named = [header.roles for header in headers]
    cells = {named.index((role,)): one for role, one in given.items()}
    places = [*places, *range(width, width + len(row.texts))]
    cells |= {
        place: (text, row.spot(at)) for at, (place, text) in enumerate(zip(places, row.texts, strict=False)) if text
    }
    filled = [cells.get(at, ("", row.spot(0))) for at in range(max(cells, default=-1) + 1)]
    return Row(row.line, [text for text, _ in filled], tuple(spot for _, spot in filled))


def _ends_with_means(rows: list[Row], headers: list[Header]) -> bool:
    """Find a last row that has fewer cells than the runs, and the mean of their times: a mean that has no name."""
    times = [at for at, header in enumerate(headers) if "time" in header.roles]
    if len(rows) < 3 or not times or len(_filled(rows[-1])) >= min(len(_filled(row)) for row in rows[:-1]):
        return False
    try:
        columns = [[to_float(row.texts[at]) for row in rows] for at in times]
    except (ValueError, IndexError):
        return False
    return all(abs(fmean(runs) - last) < 1e-3 * abs(fmean(runs)) for *runs, last in columns)


# Before the first run ----------------------------------------------------------------------------------------------


def _find_head(grid: Grid) -> int:
    """Find the row of the first header."""
    rows = grid.rows[:_TITLES_LOOKED_AT]
    first = next((at for at, row in enumerate(rows) if _is_head(row)), None)
    if first is None:
        # No header is known by its names: it is the first row as wide as most rows.
        width = Counter(len(row.texts) for row in rows if len(_filled(row)) > 1).most_common(1)
        first = next((at for at, row in enumerate(rows) if width and len(row.texts) == width[0][0]), 0)
    head, numbers = rows[first], _numbers(rows[first])
    if numbers and 2 * numbers >= len(_filled(head)):
        message = "there is no header row: the first row contains numbers"
        raise _TableError(codes.NO_HEADER_ROW, message, _HINT, grid.cell(head, 0))
    if early := next((row for row in rows[:first] if _numbers(row) > 2), None):
        hint = "put the header above all runs, or # before the line if it is no run"
        message = f"line {early.line} contains numbers, and stands above the header in line {head.line}"
        raise _TableError(codes.NO_HEADER_ROW, message, hint, grid.cell(early, 0))
    return first


_COPY = re.compile(r"(?i)(?:\.|\s+run\s?#?\s?)[0-9]{1,3}$")
"""What a spreadsheet or a data logger writes behind names that repeat."""


def _blocks(rows: list[Row], first: int) -> list[tuple[list[Row], Row, list[Row]]]:
    """Put whole tables that stand side by side below each other: the words above each, its header, its rows."""
    head = rows[first]
    names = "".join(f"{squeeze(_COPY.sub('', text))}\n" for text in head.texts if text)
    match = re.match(r"((?:.+\n){2,}?)\1+", names)
    names_of_one = match[1].split() if match else []
    if len(names_of_one) < 2 or len(set(names_of_one)) < len(names_of_one):
        return [(rows[:first], head, rows[first + 1 :])]
    blocks = []
    for start, end in pairwise([*_filled(head)[:: len(names_of_one)], len(head.texts)]):
        cut = [
            Row(row.line, row.texts[start:end], tuple(row.spot(at) for at in range(start, end)))
            if any(row.texts[start:end])
            else Row(row.line, [])
            for row in rows
        ]
        words, below = ([row for row in part if row.texts] for part in (cut[:first], cut[first + 1 :]))
        blocks.append((words, replace(cut[first], texts=[_COPY.sub("", text) for text in cut[first].texts]), below))
    return blocks


# Quantities that two columns give ----------------------------------------------------------------------------------


def _with_differences(layout: Layout, faults: Faults) -> Layout:
    """Add the time between the start and the stop of a running clock, and the period of a ball whose turns are timed.

    The columns "spin_turns" with "spin_time_start" and "spin_time_end" are the usual ones for a large disk.
    """
    there = {role for header in layout.headers for role in header.roles}
    names = {squeeze(roles.split_unit(header.text)[0]).lower(): at for at, header in enumerate(layout.headers)}
    free = [at for at, one in enumerate(layout.headers) if one.unit in (None, "s") and not one.roles]
    clocks = {roles.clock_word(layout.headers[at].text): at for at in free}
    made: list[tuple[str, int, int | None]] = []
    stated = {key.lower(): text.text for key, text in layout.grid.metadata}
    if there.isdisjoint(roles.TIMINGS) and {"start", "stop"} <= clocks.keys():
        made.append(("time [s]", clocks["stop"], clocks["start"]))
    if {"spintimestart", "spintimeend"} <= names.keys() and ("spin_turns" in there or "spin_turns" in stated):
        # A line for the whole log serves as well as a column.
        counts = next((at for at, header in enumerate(layout.headers) if "spin_turns" in header.roles), None)
        made += [(f"spin_period_{end} [s]", names[f"spintime{end}"], counts) for end in ("start", "end")]
    for name, one, other in made:
        sign = "minus" if name == "time [s]" else "over"
        try:
            others = [stated["spin_turns"] if other is None else row.texts[other] for row in layout.rows]
            pairs = [(_seconds(row.texts[one]), _seconds(text)) for row, text in zip(layout.rows, others, strict=True)]
            texts = [f"{a - b:f}" if sign == "minus" else f"{a / b:.7g}" for a, b in pairs]
        except (DecimalException, IndexError):
            return layout
        if any(text.startswith("-") for text in texts):
            return layout
        divisor = "spin_turns" if other is None else layout.cells[other].text
        message = f'"{layout.cells[one].text}" {sign} "{divisor}" is read as {name}'
        faults.add(codes.HEADER_READ_AS, message, "if it is not, write that column yourself", layout.cells[one])
        width = len(layout.cells)
        rows = [
            Row(
                row.line,
                [*row.texts, *[""] * (width - len(row.texts)), text],
                (*map(row.spot, range(width)), row.spot(one)),
            )
            for row, text in zip(layout.rows, texts, strict=True)
        ]
        header = replace(parse_header(name), text=layout.headers[one].text)
        layout = replace(layout, cells=[*layout.cells, layout.cells[one]], headers=[*layout.headers, header], rows=rows)
    return layout


def _seconds(text: str) -> Decimal:
    """Read the hands of a clock, "12:01:10.25" or "1:10", or a plain number."""
    parts = fold_number(text).replace(",", ".").split(":")
    return sum((Decimal(part) * 60**at for at, part in enumerate(reversed(parts))), Decimal())
