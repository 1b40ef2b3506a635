"""Find titles, headers, units, runs, means and notes in a sheet, and join several tables.

A row of a sheet is a header, a row of units, a run, a summary or text. A sheet is read
as a teaching assistant reads it: rows that are not runs are left out, a caption is
valid for the runs below it, and a note says each of these things.
"""

from __future__ import annotations

import re
from bisect import bisect
from collections import Counter
from collections.abc import Collection, Iterable, Iterator
from itertools import accumulate, pairwise

from msgspec import Struct
from msgspec.structs import replace

from gyrodata.base.errors import InputError
from gyrodata.quantities import notation, vocabulary
from gyrodata.quantities.units import are_equal, kinds_of
from gyrodata.readings import roles
from gyrodata.readings.grid import (
    HEADERS_LOOKED_AT,
    Grid,
    Row,
    count_of_numbers,
    filled_at,
    find_place,
    is_bare,
    is_head,
    is_number,
    units_of_row,
)
from gyrodata.readings.lablog import BLANKS, Faults, Text, listing
from gyrodata.readings.roles import Header, parse_header, squeeze, turns_in
from gyrodata.readings.workbook import MAX_COLUMNS

NOT_USED = vocabulary.pattern("not_used")
"""Words of a note on a run that is not valid."""
_UNUSUAL = rf"[0-9]|{vocabulary.pattern('weights')}"


class Layout(Struct, frozen=True):
    """A table of runs: its headers, and the rows below them."""

    grid: Grid
    """For the places of cells."""
    cells: list[Text]
    """The header row."""
    headers: list[Header]
    """Content of each header, with the unit of a second header row."""
    rows: list[Row]
    """The runs; each row has at least as many cells as the header."""


_Column = tuple[Text, Header]
Given = dict[str, tuple[str, int]]
"""Content of captions: text and number of the cell by role."""


def texts_of(grid: Grid) -> list[str]:
    """Return the comments, and the rows without numbers."""
    return [text.text for text in places_of(grid)]


def places_of(grid: Grid) -> list[Text]:
    """Return the comments, and the rows without numbers, with their places."""
    rows = (row for row in grid.rows if not any(map(is_number, row.texts)))
    return [
        *grid.comments,
        *(Text(" ".join(row.texts), grid.cell(row, 0).place) for row in rows),
    ]


def find_layout(
    grid: Grid, faults: Faults, decided: Collection[str] = ()
) -> Layout | None:
    """Find the header and the rows; None, with diagnostics, if there is no such table.

    An option gives the roles in `decided`, or names the headers in it.
    """
    try:
        if not grid.rows:
            raise faults.refuse("no_table")
        if (
            not any(map(is_head, grid.rows))
            and max(len(row.texts) for row in grid.rows) == 1
        ):
            raise faults.refuse("no_delimiter", grid.cell(grid.rows[0], 0))
        if not any(map(is_head, grid.rows)):
            grid = _with_commented_header(grid)
        rows = grid.rows[:HEADERS_LOOKED_AT]
        # If no header is known by its names, it is the first row as wide as most rows.
        widths = Counter(
            len(row.texts) for row in rows if len(filled_at(row)) > 1
        ).most_common(1)
        head = next(filter(is_head, rows), None)
        head = head or next(
            (row for row in rows if widths and len(row.texts) == widths[0][0]), rows[0]
        )
        before = grid.rows[max(grid.rows.index(head) - 1, 0)]
        at = filled_at(before)[0]
        over, under = (
            parse_header(before.texts[at]),
            parse_header("".join(head.texts[at : at + 1])).roles,
        )
        if (
            before.line == head.line - 1
            and over.unit
            and {*over.roles} & {*roles.TIMINGS}
            and {*under} <= roles.TEXTS
        ):
            head = before  # "Time (s)" over "Trial 1", "Trial 2"
        if 2 * count_of_numbers(head.texts) >= max(1, len(filled_at(head))):
            raise faults.refuse("no_header_row", grid.cell(head, 0))
        # "turns:", "1", "", "1" is a caption of tables beside each other.
        above = [
            row for row in rows[: rows.index(head)] if not row.texts[0].endswith(":")
        ]
        bare = [(sum(map(is_bare, row.texts)), row) for row in above]
        if early := next(
            (
                row
                for count, row in bare
                if count > 2 and 2 * count > len(filled_at(row))
            ),
            None,
        ):
            raise faults.refuse(
                "numbers_above_header",
                grid.cell(early, 0),
                early=[early.line],
                line=[head.line],
            )
        _name_counter(grid, head, decided)
        if len(head.texts) > 2:
            _split_rows(grid.rows, len(head.texts))
        heads = [row for row in grid.rows if is_head(row)] or [head]
        if lacking := _lacking(
            [parse_header(text) for row in heads for text in row.texts], grid
        ):
            # A line behind # may give a quantity without a column: "# each time is for
            # one full turn".
            said = [(f"# {text.text}", text) for text in grid.comments]
            said += [
                (f"# {key}: {text.text}", text)
                for key, text in grid.metadata
                if not roles.is_key(key)
            ]
            captions = sorted(
                (Row(text.place.line, [words]) for words, text in said),
                key=lambda row: row.line,
            )
            there = {row.line for row in grid.rows}
            captions = _paragraphs([row for row in captions if row.line not in there])
            captions = [row for row in captions if lacking.intersection(said_in(row))]
            grid = replace(
                grid, rows=sorted([*grid.rows, *captions], key=lambda row: row.line)
            )
        sheet = _Sheet(grid, decided, faults)
        for words, names, rows in _blocks(grid.rows, grid.rows.index(head)):
            sheet.words += words
            sheet.begin(names)
            for row in rows:
                sheet.take(row)
        return sheet.finish()
    except InputError:
        return None


def _split_rows(rows: list[Row], width: int) -> None:
    """Split the rows that were typed with another delimiter than the header."""
    for row in rows:
        if len(row.texts) != 1:
            continue
        for sign in ",;\t":
            parts = row.texts[0].split(sign)
            if len(parts) == width and all(map(is_number, parts)):
                row.texts[:] = parts


def _with_commented_header(grid: Grid) -> Grid:
    """Split a header that is behind # or has another delimiter.

    This is done if the header then has as many names as the rows have cells.
    """
    width = Counter(len(row.texts) for row in grid.rows).most_common(1)[0][0]
    signs = (
        (r"\s{2,}", r"\s+", ",")
        if grid.delimiter == "\t"
        else (re.escape(grid.delimiter), ",")
    )
    texts = [*grid.comments, *(text for _, text in grid.metadata)]
    texts += [
        grid.cell(row, at)
        for row in grid.rows
        for at in filled_at(row)
        if len(filled_at(row)) == 1
    ]
    for text, sign in ((text, sign) for text in texts for sign in signs):
        row = Row(text.place.line, [cell.strip() for cell in re.split(sign, text.text)])
        if len(row.texts) == width and is_head(row):
            others = [one for one in grid.rows if one.line != row.line]
            return replace(grid, rows=sorted([*others, row], key=lambda row: row.line))
    return grid


def is_usual(grid: Grid) -> bool:
    """Return whether a table has one row of names above its runs.

    This row contains no numbers and no count of weights.
    """
    named = [
        row
        for row in grid.rows
        if len(filled_at(row)) > 1 and not any(map(is_number, row.texts))
    ]
    heads = list(filter(is_head, named))
    if (
        len(heads) != 1
        or len(named) != 1
        or any(roles.contains(_UNUSUAL, text) for text in heads[0].texts)
    ):
        return False
    if len(filled_at(heads[0])) > len(set(filter(None, heads[0].texts))):
        return False
    return names_quantities(heads[0])


def names_quantities(row: Row) -> bool:
    """Return whether most cells of a row name a quantity.

    Of a sentence that is split at its blanks, few do.
    """
    return 2 * sum(bool(parse_header(text).roles) for text in row.texts) > len(
        filled_at(row)
    )


def _name_counter(grid: Grid, head: Row, decided: Collection[str]) -> None:
    """Call a column such as "Lap" or "N" run if its cells are 1, 2, 3, ….

    They may repeat if a text states turns.
    """
    stated = any(map(turns_in, head.texts))
    for at, text in (
        (at, text) for at, text in enumerate(head.texts) if text not in decided
    ):
        is_turns = at == 0 and stated and parse_header(text).roles == ("turns",)
        if (
            is_turns
            or squeeze(text).lower() in roles.COUNTER_WORDS
            or re.fullmatch(r"[^\W\d]|(?i:count)", text)
        ):
            rows = (
                row.texts
                for row in grid.rows
                if row.line > head.line and count_of_numbers(row.texts) > 1
            )
            cells = [texts[at] for texts in rows if "".join(texts[at : at + 1])]
            numbers = [int(cell) if cell.isdigit() else 0 for cell in cells]
            counts = [
                1,
                *(1 if two == 1 else one + 1 for one, two in pairwise(numbers)),
            ]
            once = cells.count("1") == 1 or (
                not is_turns and any(map(turns_in, texts_of(grid)))
            )
            if len(cells) > 3 and max(numbers) > 1 and numbers == counts and once:
                head.texts[at] = "run"


# --- What a row is ---


_WORD = re.compile(r"[^\W\d_]{3}")
_SENTENCE = re.compile(r"[^\W\d_]{3}\W+[^\W\d_]{3}")
"""Two words: "2 reflective strips" is not a number with its unit."""


def _is_text(row: Row, headers: list[Header]) -> bool:
    """Return whether a row is a title or a note, but not a remark on a run.

    Or quantities without a column.
    """
    filled = filled_at(row)
    numbers = {
        at
        for at in filled
        if is_number(row.texts[at]) and not _SENTENCE.search(row.texts[at])
    }
    if numbers:
        said = said_in(row) if len(numbers) < 4 else {}
        places = {at for *_, at in said.values()}
        # "Part B: mass 40.3 g, r = 15.0 cm, 1/3 turn" is not a run of the table above.
        return (
            bool(said)
            and numbers <= places
            and (numbers < places or _lacking(headers).issuperset(said))
        )
    kinds = [
        (at, roles.kind_of_role(role))
        for at in filled
        if at < len(headers)
        for role in headers[at].roles
    ]
    remark = any(kind == "sign" or (kind == "text" and at > 0) for at, kind in kinds)
    return BLANKS.isdisjoint(row.texts[at] for at in filled) and not remark


def is_of_means(header: str) -> bool:
    """Return whether a column contains means, by its name."""
    return any(
        squeeze(word).lower() in roles.MEAN_WORDS
        for word in re.split(r"[\s_,;()\[\]\-]+", header)
    )


# --- What a caption says ---


_AMOUNT = r"(?:[0-9]{1,2}\s*[x×*·]\s*)?NUMBER(?:\([0-9]+\)|\s*(?:±|\+/-|\+-)\s*NUMBER)?"
_AMOUNT = _AMOUNT.replace("NUMBER", notation.NUMBER)
_UNIT = r"(?:1?/min|[^\W\d_][\w/^*·]*)"
QUANTITY = (
    rf"(?<![^\W\u2e80-\uffef])(?<![.,/])({_AMOUNT})\s*({_UNIT})(?!=)|"
    rf"(?<![uΔδσ])[\[(]({_UNIT})[\])]\W*({_AMOUNT})"
)
"""A number and its unit: "20.1 g", or "(g)" with "20.1" in the next cell."""
_MOVED = frozenset(vocabulary.words("moved").split())
SAID_KINDS = {"mass": "mass", "length": "position", "rate": "spin"}
_BALL, _WEIGHT, _NOT_TIMED = map(
    vocabulary.pattern, ("sphere", "weight_added", "not_timed")
)
_ON_ROD = rf"\b{vocabulary.pattern('on_rod')}\b"
"""Where a weight is: such words say that a mass is not that of the rod."""
_SAYS_NOTHING = (
    rf"(?i)^\W*(?:{vocabulary.pattern('article')}\s*)*{vocabulary.pattern('ball')}\b"
    rf"(?!.*{vocabulary.pattern('weight_added')})"
)
_SEVERAL_WEIGHTS = (
    rf"(?i)(?<![\w.,])(?:[2-9]|{vocabulary.pattern('several')})\s+"
    rf"(?:[^\W\d]+\s+)?{vocabulary.pattern('several_weights')}|[0-9]\s*k?g\s*\+\s*[0-9]"
)
"""Sentences whose quantities, or whose mass, are not those of a run: "Steel ball, m =
4.28 kg", "2 weights of 20 g"."""
_NAMES_OF_TIME = re.split(r"[\s,]+", vocabulary.words("time", ","))
TIME_WORDS = {squeeze(word).lower() for word in _NAMES_OF_TIME if len(word) > 2}
TIMED = (
    rf"\b{vocabulary.pattern('timed')}"
    rf"|{'|'.join(word for word in _NAMES_OF_TIME if word > chr(0x2E80))}"
)
"""Verbs of a measurement, and words for a time in languages without blanks between
words."""
_PART_IS = rf"{vocabulary.pattern('parts')}[^.;,\d]*="
"""What a part of a turn is: "three screws = once around"."""
_DEFINITION = (
    r"(?i)(?:[=:]|\b(?:is|are|ist|sind|est|es|è))\s*(?:360|2\s*(?:pi|π)"
    r"|[^\W\d]+\s*/\s*[0-9])|360\D{0,9}="
)
"""What a turn is: "one turn = 360 deg"; or what was calculated: "time of 1 turn = t/3".
"""


def _turns_stated(clause: str, whole: str, found: set[str]) -> str:
    """Return the turns that a clause of a line states for the times of runs.

    "" for a line about other turns.

    Such a clause names a time, or a mass of a run, or it contains hardly anything else.
    """
    turns, parts = turns_in(clause), set(re.findall(r"[1-9]\s*/\s*[2-9]", whole))
    if (
        not turns
        or len(parts) > 1
        or re.search(_DEFINITION, clause)
        or re.search(_PART_IS, whole)
    ):
        return ""
    words = {
        word
        for word in roles.squeezed_words(re.sub(QUANTITY, " ", clause))
        if not word.isdecimal()
    }
    # "Zeiten" and "times" are plurals.
    timed = any(
        word[:size] in TIME_WORDS
        for word in words
        for size in range(max(3, len(word) - 2), len(word) + 1)
    )
    if found & {"mass", "time"} or timed or re.search(TIMED, clause):
        return turns
    others = [
        word
        for word in words
        if len(word) > 2
        and not roles.is_of_turns(word)
        and not roles.name_roles(word)[0]
    ]
    return turns if len(others) < 2 else ""


def _is_open(text: str) -> bool:
    """Return whether the last line of a text is long and does not end like a sentence."""
    line = text.rstrip().rpartition("\n")[2]
    return (
        line[-1:] not in (*".:;!?。", "")
        and re.search(r"[^.:;!?。\s]", line[:-41]) is not None
    )


def _paragraphs(rows: list[Row]) -> list[Row]:
    """Join rows of text if a sentence goes on in the next line."""
    joined: list[Row] = []
    for row in rows:
        last = joined[-1] if joined else row
        goes_on = bool(re.match(r"#?\s*[a-zà-ÿа-яα-ω]", row.texts[0]))
        goes_on = goes_on and _is_open(" ".join(last.texts))
        # "t: one turn" is a line of its own.
        goes_on = (
            goes_on
            and not any(map(is_number, row.texts))
            and not re.match(r"#?\s*\w{1,12}\s*[:=]", row.texts[0])
        )
        # "we timed half a turn" needs no beginning.
        goes_on = goes_on and not (
            said_in(row) and (said_in(last) or re.search(TIMED, " ".join(row.texts)))
        )
        if (
            goes_on
            and last is not row
            and last.spot(len(last.texts) - 1) // MAX_COLUMNS == row.line - 1
        ):
            spots = tuple(
                one.spot(at) for one in (last, row) for at in range(len(one.texts))
            )
            joined[-1] = Row(
                last.line,
                [*last.texts, *(text.removeprefix("#") for text in row.texts)],
                spots,
            )
        else:
            joined.append(row)
    return joined


MAX_SENTENCES = 2_000
"""Characters of a row that is read as sentences; the time grows with the square of its
length."""
_CLAUSE_END = r"[,;.،；，。()]\s+"
SENTENCE_END = r"[.!?;]\s+(?=[A-ZÀ-ÞΑ-ΩА-ЯІЇ]|\w\s*=)|。"


def said_in(row: Row, with_time: bool = False) -> Given:
    """Read "Weight 1: 20.1 g at 14.8 cm": text and cell by role, without roles of two values."""
    filled = filled_at(row)
    if sum(len(row.texts[at]) for at in filled) > MAX_SENTENCES:
        return {}
    # "x = 15,5 cm" above a table with commas between the cells is one number.
    whole = "\0".join(row.texts[at] for at in filled)
    whole = whole.replace("**", "  ").replace("$", " ")
    whole = re.sub(r"([=:]\s*[0-9]+)\0(?=[0-9]{1,3}\s*[^\W\d])", r"\1,", whole).replace(
        "\0", " "
    )
    ends = list(accumulate(len(row.texts[at]) + 1 for at in filled))
    found: dict[str, dict[str, int]] = {}
    for start, stop in pairwise(
        [0, *(match.end() for match in re.finditer(SENTENCE_END, whole)), len(whole)]
    ):
        for role, text, place in _said_in_sentence(
            whole[start:stop], {end - start for end in ends}, with_time
        ):
            if (
                role == "turns"
                and len(set(filter(None, map(turns_in, re.split(_CLAUSE_END, whole)))))
                > 1
            ):
                continue  # "Runs 1-4: a quarter turn; runs 5-8: a full turn"
            found.setdefault(role, {}).setdefault(
                text, filled[min(bisect(ends, start + place), len(filled) - 1)]
            )
    for part in (
        *row.texts,
        *re.split(_CLAUSE_END, whole),
        *re.findall(r"(?<!\w)\w++=\S+", whole),
    ):
        name, *rest = re.split(r"(?:(?<!\s)\s+)?[:=：]\s*", part, maxsplit=1)
        name, *rest = (name, *rest) if rest else part.rsplit(maxsplit=1) or [""]
        if (
            rest
            and parse_header(name.lstrip("# ")).roles == ("turns",)
            and (turns := turns_in(f"{rest[0]} turns"))
        ):
            found["turns"] = {turns: filled[-1]}  # "Number of turns: 1/3", "turns 1"
    # "60 g (on the scale: 60.0 g)" is one mass.
    values = {
        role: {
            (w.value, w.unit) if (w := notation.take_apart(text)) else text
            for text in texts
        }
        for role, texts in found.items()
    }
    one = {role: texts for role, texts in found.items() if len(values[role]) == 1}
    return {
        role: max(texts.items(), key=lambda item: len(item[0]))
        for role, texts in one.items()
    }


def _said_in_sentence(
    whole: str, ends: set[int], with_time: bool
) -> Iterator[tuple[str, str, int]]:
    """Yield role, text and place of each quantity of a sentence whose cells have these ends."""
    found: list[tuple[str, str, int]] = []
    end = 0
    whole = re.sub(_ON_ROD, lambda words: " " * len(words[0]), whole)
    scanned = re.sub(
        r"[\[(]([^()\[\]]*)[\])]",
        lambda one: one[0] if kinds_of(one[1]) else f" {one[1]} ",
        whole,
    )
    for match in re.finditer(QUANTITY, scanned):
        after = re.split(r"[\s,;:.()=]+", whole[match.end() :].lstrip())[0]
        words = [*re.split(r"[\s,;:()=]+", whole[end : match.start()]), after]
        beside = {squeeze(word).lower() for word in words}
        beside -= {"to"} if beside & _MOVED else set()
        own = whole[end : match.end()]
        clause = own + (re.match(r"\s*\([^()]*\)", whole[match.end() :]) or [""])[0]
        behind = clause + (re.match(r"[^,;.()0-9]*", whole[match.end() :]) or [""])[0]
        end = match.end()
        number, unit = match[1] or match[4], match[2] or match[3]
        split = (
            match.start() in ends
            and number.isdigit()
            and whole[match.start() - 2].isdigit()
        )
        if split and not re.search("[0-9],[0-9]", whole):
            continue  # "Position 15,5 cm" may be split at its decimal comma
        kinds = SAID_KINDS | ({"time": "time"} if with_time else {})
        role = next(
            (role for kind, role in kinds.items() if kind in kinds_of(unit)), ""
        )
        if re.search(r"\b(?:[uUΔδσ]\s?\(\w+\)|u_\w+:.*)\W*$", whole[: match.start()]):
            continue  # "u(r) = 1 mm"
        if role == "position" and squeeze(after).lower() in roles.DIMENSION_WORDS:
            continue
        if role == "position" and roles.origin_in(whole):
            if roles.noted_origin(whole) and not (
                re.search(roles.DIAMETER, own) or roles.diameter_in(own)
            ):
                found.append(
                    (role, f"{number} {unit}", match.start(1 if match[1] else 4))
                )
            continue
        # Of "Rod weight at 16.0 cm", the rod is not meant.
        if re.search(rf"{_WEIGHT}\w*\s+(?:\w+\s+)?$", whole[: match.start()]):
            beside = {
                word
                for word in beside
                if not re.fullmatch(vocabulary.pattern("ball"), word)
            }
        of_the_ball = re.search(_BALL, clause) and not re.search(_WEIGHT, clause)
        if role and (
            roles.from_centre(behind)
            or not (of_the_ball or beside & roles.NOT_THE_WEIGHT)
        ):
            found.append((role, f"{number} {unit}", match.start(1 if match[1] else 4)))
    parts = (whole, *re.split(_CLAUSE_END, whole))
    if turns := next(
        filter(
            None,
            (
                _turns_stated(part, whole, {role for role, *_ in found})
                for part in parts
            ),
        ),
        "",
    ):
        found.append(("turns", turns, len(whole)))
    # "The tachometer said 616 rpm and the stopwatch 16.6 s" is a run.
    outside = re.sub(r"\([^()]*\)", "", whole)
    only_position = re.search(
        _NOT_TIMED, outside if turns_in(outside) else whole
    ) and not {"spin", "time"} <= {role for role, *_ in found}
    says_nothing, several = (
        re.search(_SAYS_NOTHING, whole) or only_position,
        re.search(_SEVERAL_WEIGHTS, whole),
    )
    if "?" in whole:
        return
    for one in found:
        # "Rod timed over a third of a turn"
        timed = (
            one[0] == "turns"
            and re.search(TIMED, whole)
            and not only_position
            and not roles.is_of_the_spin(whole)
        )
        is_of_run = (timed or not says_nothing) and not (several and one[0] != "turns")
        if is_of_run or (
            one[0] == "position"
            and (roles.from_centre(whole) or roles.noted_origin(whole))
        ):
            yield one


_UNITS_LISTED = rf"\W*{vocabulary.pattern('units')}\W"
_IN_A_UNIT = r"(?i)(.*)\b(?:in|en|em|w|в)\s+(\S.*)"


def _stated_units(text: str) -> dict[str, str]:
    """Return the unit of each kind of quantity that a text states.

    Examples are "masses in g, times in s" and "Units: g, cm, s".
    """
    found: dict[str, str] = {}
    listed = re.match(_UNITS_LISTED, text)
    text = text[listed.end() :] if listed else text
    for part in re.split(r"[,;.]\s*|\s(?:and|und|et|y|e|и|for|für|pour|para)\s", text):
        *names, unit = re.split(r"[\s:=()\[\]]+", part.strip(" :=()[]"))
        if match := re.fullmatch(_IN_A_UNIT, part):
            names = re.split(r"[\s:=()\[\]]+", match[1])
            unit = re.split(rf"\s{roles.FROM}\s", match[2])[0].strip(" ()[]:")
        words = {squeeze(name).lower() for name in names} - {""}
        of_another = bool(words & roles.NOT_THE_WEIGHT) and not roles.from_centre(part)
        if (
            of_another
            or not (listed or match)
            or (re.search("[0-9]", part) and not turns_in(part))
        ):
            continue
        forms = {
            word.removesuffix(end)
            for word in words
            for end in ("", "s", "es", "n", "en")
        }
        named = {
            roles.kind_of_role(role)
            for form in forms
            for role in roles.name_roles(form)[0]
        }
        kinds = kinds_of(unit) & {*SAID_KINDS, "time"}
        if len(kinds) == 1 and (kinds & (named | forms) or (listed and not words)):
            found[min(kinds)] = unit
    return found


def _lacking(headers: list[Header], grid: Grid | None = None) -> set[str]:
    """Return the roles that no column of a table contains.

    No "# key: value" line of the grid contains them either, so a caption may give them.
    """
    there = {role for header in headers for role in header.roles}
    # "mass without hanger [g]" is a mass, although gyro has to ask which.
    there |= {
        role for header in headers if not header.roles for role in roles.hinted(header)
    }
    there |= {key.lower() for key, _ in grid.metadata} if grid else set()
    if "angle" in there or any(turns_in(header.text) for header in headers):
        there.add("turns")
    if "torque" in there:
        there |= {"mass", "position"}
    if "mass" not in there and (
        "force" in there or any(map(roles.counts_weights, headers))
    ):
        there.add("mass")
    if any(
        header.roles and all(role.startswith("spin") for role in header.roles)
        for header in headers
    ):
        there.add("spin")
    # "gap [cm]" may be the position, and "disks [g]" the mass.
    unnamed = [kinds_of(header.unit or "") for header in headers if not header.roles]
    there |= {
        SAID_KINDS[kind]
        for kind in ("length", "mass")
        if any(kind in kinds for kinds in unnamed)
    }
    return {"mass", "position", "spin", "turns"} - there


def read_notes(grid: Grid, faults: Faults) -> str:
    """Return the origin of positions that a note states, or "".

    The function warns of every note that may say that a reading is not what is typed,
    such as "twice the real rpm".
    """
    notes = {text.text: text for text in grid.comments}
    for key, text in grid.metadata:
        if key.lower() in roles.TEXTS or not roles.is_key(key):
            notes[f"{key}: {text.text}"] = text
    origins, texts = list(map(roles.noted_origin, notes)), list(notes)
    for row in grid.rows:
        words = [at for at, text in enumerate(row.texts) if _WORD.search(text)]
        if words and not any(map(is_number, row.texts)):
            origins.append(roles.noted_origin(", ".join(row.texts)))
            texts += [", ".join(row.texts)] if not is_head(row) else []
        # The header "centre to inner face (cm)" is a position, and not that of the
        # middle of the weight.
        words = [
            at
            for at in words
            if not roles.parse_header(typed := row.texts[at]).roles
            or (
                roles.contains(roles.ALTERED["position"], typed)
                and not roles.origin_in(typed)
            )
        ]
        note = ", ".join(row.texts[at] for at in words)
        if words and note not in notes and roles.altered_role(note):
            notes[note] = grid.cell(row, words[0])
    for note, cell in notes.items():
        if role := roles.altered_role(note).replace("_", " "):
            faults.add("note", cell, note=note, role=role)
    origin = next(filter(None, origins), "")
    return (
        "both"
        if origin == "surface" and any(map(roles.noted_centre, texts))
        else origin
    )


# --- From row to row ---


_LEGENDS = r"[,;]\s+(?=\W*[^\W\d_]\w{0,7}\W?\s*[=:])"
_LEGEND = (
    r"\W*(?:([^\W\d_]{3,})\s+`)?([^\W\d_]\w{0,7})[`*]*\s*"
    r"(?:(?(1)|(?:[=:]|(?<=\s)(?:is|ist|est|è|es)\b))\s*([^\W\d].{3,90}))"
)


class _Sheet:
    """Goes down the rows of a sheet, and makes one table of all runs."""

    def __init__(self, grid: Grid, decided: Collection[str], faults: Faults) -> None:
        self.grid, self.decided, self.faults = grid, decided, faults
        self.columns: list[_Column] = []
        """Columns of all tables."""
        self.runs: list[tuple[Row, list[int], Given]] = []
        """Each run with the columns of its cells, and what its caption gives."""
        self.tables: list[int] = []
        """Number of the first run of each table."""
        self.words: list[Row] = []
        """Rows of text above the next run."""
        self.left_out: dict[str, list[tuple[Row, int]]] = {
            name: [] for name in ("title", "taken_out", "summary")
        }
        """Rows that are not runs, with the cell that shows it."""
        self.general: Given = {}
        """What captions say of all tables."""
        self.earlier: Given = {}
        """What captions gave last: a position or turns are valid until others are
        given."""
        self.said: list[tuple[Text, str, str]] = []
        """Each caption, whether its runs are below or above it, and what was read of
        it."""
        texts = [
            re.sub(
                r"^([^=:\0]*)\0(?=[^\0]*$)", r"\1: ", "\0".join(filter(None, row.texts))
            )
            for row in grid.rows
        ]
        texts = [text.replace("\0", ", ") for text in texts]
        texts += [
            *(comment.text for comment in grid.comments),
            *(f"{key}: {text.text}" for key, text in grid.metadata),
        ]
        self.legend: dict[str, str] = {}
        """What a line such as "d = distance from centre in cm" says of a short header.
        """
        for one in filter(
            None,
            (
                re.fullmatch(_LEGEND, part)
                for text in texts
                for part in re.split(_LEGENDS, text)
            ),
        ):
            words = re.split(r"[;.]\s", f"{one[1] or ''} {one[3]}".strip())[0].rstrip(
                " )"
            )
            if parse_header(words).unit or turns_in(words):
                self.legend[squeeze(one[2])] = words
        notes = [(text, text.text) for text in grid.comments]
        notes += [
            (text, f"{key}: {text.text}")
            for key, text in grid.metadata
            if not roles.is_key(key)
        ]
        for row, below in pairwise([*grid.rows, Row(0, [""])]):
            # The row above numbers is the header itself.
            if not any(map(is_number, row.texts + below.texts)):
                notes += [(grid.cell(row, at), row.texts[at]) for at in filled_at(row)]
        self.units: dict[str, str] = {}
        """Unit of each kind of quantity that a text states for all columns."""
        for cell, note in notes:
            if stated := _stated_units(note):
                self.units |= stated
                self.said.append(
                    (
                        cell,
                        "below",
                        ", ".join(f"{kind} in {unit}" for kind, unit in stated.items()),
                    )
                )
        names = [name for row in grid.rows if is_head(row) for name in row.texts]
        found = {role for name in names for role in parse_header(name).roles}
        self.any_timed = not found.isdisjoint(roles.TIMINGS) or any(
            map(turns_in, names)
        )
        self.only_means = False
        self.told: set[str] = set()
        """Parts of a run in the first table."""

    def begin(self, head: Row) -> None:
        """Begin a table with its header row."""
        self.head = head
        self.here = [
            (self.grid.cell(head, at), parse_header(text))
            for at, text in enumerate(head.texts)
        ]
        for at, text in enumerate(head.texts):
            # The mean of "rpm1" and "rpm2" is right for two readings, and for the spin
            # before and after.
            pair, third = (text.replace("1", digit, 1) for digit in "23")
            before = parse_header(text.replace("1", " start", 1))
            if (
                before.roles == ("spin_start",)
                and text != pair in head.texts
                and third not in head.texts
            ):
                after = parse_header(text.replace("1", " end", 1))
                for place, header in ((at, before), (head.texts.index(pair), after)):
                    self.here[place] = (
                        self.here[place][0],
                        replace(header, text=head.texts[place]),
                    )
                self.faults.add("numbered_spins", self.here[at][0], second=pair)
        for at, (cell, header) in enumerate(self.here):
            words = self.legend.get(
                squeeze(roles.split_unit(cell.text)[0] if header.unit else cell.text),
                "",
            )
            explained = parse_header(words)
            if (explained.unit and header.unit is None) or (
                explained.roles and not header.roles
            ):
                told = replace(
                    explained,
                    roles=explained.roles or header.roles,
                    unit=explained.unit or header.unit,
                )
                self.here[at] = replace(cell, text=words), told
            elif (
                words
                and "time" in kinds_of(header.unit or "")
                and turns_in(words)
                and not turns_in(cell.text)
            ):
                explained = parse_header(f"{words} [{header.unit}]")
                if "time" in explained.roles:
                    self.here[at] = replace(cell, text=words), explained
        spins = any("spin" in header.roles for _, header in self.here)
        for at, (cell, header) in enumerate(self.here if self.units else ()):
            named = (
                header.roles
                if spins
                else roles.name_roles(cell.text)[0] or header.roles
            )  # "n in rpm"
            kinds = self.units.keys() & set(map(roles.kind_of_role, named))
            unit = self.units[min(kinds)] if len(kinds) == 1 else ""
            if unit and header.unit is None:
                self.here[at] = (
                    cell,
                    replace(parse_header(f"{cell.text} [{unit}]"), text=cell.text),
                )
            elif (
                unit
                and kinds_of(header.unit) == kinds_of(unit)
                and not are_equal(header.unit or "", unit)
            ):
                self.faults.add(
                    "note", cell, note=f"{min(kinds)} in {unit}", role=header.roles[0]
                )
        for at, ((_, left), (cell, header)) in enumerate(pairwise(self.here), 1):
            name = roles.split_unit(cell.text)[0].strip()
            is_uncertainty = (
                name in ("±", "+/-", "+-")
                or squeeze(name).lower() in roles.UNSURE_WORDS
            )
            if len(left.roles) == 1 and is_uncertainty:
                # "±" or "error" belongs to the column on its left.
                header = replace(
                    header, roles=(f"u_{left.roles[0]}",), unit=header.unit or left.unit
                )
                self.here[at] = replace(cell, text=f"u({left.text})"), header
        times = {
            at: header
            for at, (_, header) in enumerate(self.here)
            if header.roles == ("time",)
        }
        if len({*times.values()}) < len(times):
            for number, at in enumerate(times, 1):
                self.here[at] = self.here[at][0], replace(times[at], number=number)
            self.faults.add("same_times", self.here[max(times)][0])
        self.named = list(self.here)
        beyond = len(head.texts)
        self.apart = not any(
            "".join(row.texts[beyond : beyond + 1]) for row in self.grid.rows
        )
        """Whether a blank column separates the table from what is on its right."""
        self.fresh, self.skipped, self.below_results = True, False, False
        self.places: list[int] = []
        self.given: Given = dict(self.general)

    def take(self, row: Row) -> None:
        """Read the next row."""
        headers = [header for _, header in self.here]
        if self.apart and len(row.texts) > len(headers):
            beside = [at for at in filled_at(row) if at >= len(headers)]
            self.left_out["title"].append((row, beside[0]))
            row = replace(row, texts=row.texts[: len(headers)])
            if not any(row.texts):
                return
        first = filled_at(row)[0]
        # A row of means, deviations or sums begins with such a word, which is not a
        # note on a run.
        start = (
            re.split(r"[\s_:,;(=]+", row.texts[first])[0],
            re.sub(r"[()=:]", "", row.texts[first]),
        )
        is_note = first < len(headers) and "note" in headers[first].roles
        names = [text for text in row.texts if not is_number(text)]
        names_result = any(
            "inertia" in kinds_of(parse_header(text).unit or text) for text in names
        )
        below = (
            self.fresh
            and (len(row.texts) > len(headers) or "" in self.head.texts)
            and self._names_below(row)
        )
        if is_head(row) and not (below and "" in self.head.texts):
            self.words += [
                self.head
            ] * self.fresh  # "time of one turn, x from the centre" above the names
            self.begin(row)
        elif self.fresh and (units := units_of_row(row.texts)):
            kinds = [
                (kinds_of(header.unit), set(map(roles.kind_of_role, header.roles)))
                for _, header in self.here
                if header.unit and header.roles
            ]
            if any(
                map(frozenset.isdisjoint, *zip(*kinds, strict=True)) if kinds else ()
            ):
                self.here = list(
                    self.named
                )  # the first row, such as "S, t, N", contains symbols
            self._take_units(units)
        elif below:
            self.here = below
        elif row.texts[0] == "#":
            self._leave_out(
                "taken_out", row
            )  # a # that a spreadsheet put into a cell of its own
        elif not is_note and not roles.SUMMARY_WORDS.isdisjoint(
            squeeze(word).lower() for word in start
        ):
            self._leave_out("summary", row)
            # "slope", "intercept" above numbers
            self.below_results |= (
                sum(squeeze(text).lower() in roles.SUMMARY_WORDS for text in row.texts)
                > 1
            )
        elif _is_text(row, headers):
            self.words.append(row)
            # "I_zz (kg m^2), uncertainty (kg m^2)": the numbers below are results.
            self.below_results = (
                bool(self.runs) and len(filled_at(row)) > 1 and names_result
            )
        elif any(
            re.search(NOT_USED, text) for text in row.texts if not is_number(text)
        ):
            self._leave_out("taken_out", row)
        elif not is_note and (
            self.below_results
            or names_result
            or (not is_bare(row.texts[first]) and self._is_result(row))
        ):
            self._leave_out("summary", row)
        else:
            self._take_run(row)

    def _take_units(self, units: list[str]) -> None:
        """Give the headers the units of a row of units."""
        for at, (unit, (cell, header)) in enumerate(
            zip(units, list(self.here), strict=False)
        ):
            if unit not in BLANKS and unit != "1" and header.unit is None:
                # Minutes and seconds are below one "time".
                text = (header if header.text or not at else self.here[at - 1][1]).text
                unit, *words = (
                    [unit] if kinds_of(unit) else re.split(r"[\s,]+", unit, maxsplit=1)
                )
                text = " ".join([text, *words])
                self.here[at] = (
                    replace(cell, text=text) if words else cell,
                    parse_header(f"{text} [{unit}]"),
                )
                self.here[at] = self.here[at][0], replace(self.here[at][1], text=text)

    def _is_result(self, row: Row) -> bool:
        """Return whether a row is a result, such as "u(I_zz)" or "2/5 m r²".

        Such a row begins with a text and has no time.
        """
        filled = filled_at(row)
        text, written = (
            row.texts[filled[0]],
            notation.take_apart(row.texts[filled[0]]),
        )
        timed = [
            at
            for at, (_, header) in enumerate(self.here)
            if set(header.roles).intersection(roles.TIMINGS)
            or "time" in kinds_of(header.unit or "")
        ]
        # "standard error" may be in the column of the times; "l2.3" is a time.
        label = (
            filled[0]
            if 2 * len(filled) < len(self.here) and _WORD.search(text)
            else None
        )
        untimed = bool(timed) and not any(
            row.texts[at : at + 1] > [""] for at in timed if at != label
        )
        no_quantity = written is None or bool(
            written.unit and not kinds_of(written.unit)
        )
        few = 3 * len(filled) < len(self.here)
        return (few and bool(re.search(r"(?m)%|^(?>.*?[^\W\d]).*\s", text))) or (
            bool(self.runs)
            and untimed
            and no_quantity
            and bool(re.search(r"[^\W\d_]|^\W+$", text))
        )

    def _leave_out(self, why: str, row: Row) -> None:
        self.left_out[why].append((row, filled_at(row)[0]))

    def _names_below(self, row: Row) -> list[_Column]:
        """Read a second row of names below merged cells: "Time (s)" over 1, 2, 3.

        None if it is not such a row.
        """
        # A header merged over the last columns leaves its row shorter.
        more = len(row.texts) - len(self.here)
        if any(
            is_bare(text) and re.search("[.,][0-9]|[0-9]{3}", text)
            for text in row.texts
        ):
            return []  # a run
        named = [
            *self.here,
            *[(replace(self.here[-1][0], text=""), parse_header(""))] * more,
        ]
        over = ""
        for at, text in enumerate(row.texts):
            over = named[at][0].text or over
            name, unit = roles.split_unit(over)
            if text and not (
                parse_header(text).unit and {*parse_header(text).roles} - roles.TEXTS
            ):
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
        typed = [
            (header, text)
            for (_, header), text in zip(self.here, row.texts, strict=False)
            if text
        ]
        there = {role for header, _ in typed for role in header.roles}
        self.given = {
            role: one for role, one in self.given.items() if role not in there
        }
        if self.words:
            # "moved to 10.0 cm" between the runs is valid for the blank cells below it,
            # until another value is typed.
            blank = set() if is_first else {"mass", "position"} - there
            lacking = blank | _lacking([header for _, header in self.here])
            if any(roles.are_turns(header, [text]) for header, text in typed):
                lacking.discard("turns")
            self.given |= self._read_captions(lacking)
            new = self.given.keys() - self.general.keys()
            kept = self.earlier.keys() & (
                lacking if new & {"mass", "position", "spin"} else lacking & {"turns"}
            )
            self.given = {role: self.earlier[role] for role in kept} | self.given
        self.earlier |= self.given
        if self.skipped:
            return
        remarks = [
            at for at in range(len(self.places), len(row.texts)) if row.texts[at]
        ]
        if remarks and not any(is_number(row.texts[at]) for at in remarks):
            self.left_out["title"].append((row, remarks[0]))
            row = Row(row.line, row.texts[: len(self.places)], row.origin)
        if is_first:
            lacking = _lacking([header for _, header in self.here]) & {
                "position",
                "turns",
            }
            self.given = {
                role: one for role, one in self.earlier.items() if role in lacking
            } | self.given
            there |= set(self.given)
            if not self.tables:
                self.told = there & {*roles.FILLED_DOWN, *roles.TIMINGS} - {"torque"}
            self.tables.append(len(self.runs))
            # A position is blank in a run without a weight.
            has_position = any("position" in header.roles for _, header in self.here)
            if lost := sorted(
                self.told - there - ({"position"} if has_position else set())
            ):
                line, lacks = [self.head.line], roles.BY_NAME[lost[0]]
                raise self.faults.refuse(
                    "lacks_in_first_row", self.here[0][0], line=line, lacks=lacks
                )
        self.runs.append((row, self.places, self.given))

    def _begin_runs(self) -> None:
        """Give the columns of a table their places among all columns.

        This is not done if the rows of the table are not runs.
        """
        names = [cell.text for cell, _ in self.here]
        # Next to a table of times, one of rates is calculated.
        timed = any("time" in header.roles for _, header in self.columns)
        wanted = {*roles.TIMINGS} - ({"precession_rate"} if timed else set())
        timings = [
            header.text
            for _, header in self.here
            if not wanted.isdisjoint(header.roles)
        ]
        title = " ".join(
            text for words in self.words for text in words.texts if text[:1] != "#"
        )
        means = (is_of_means(title) and not turns_in(title)) or (
            bool(timings) and all(map(is_of_means, timings))
        )
        untimed = self.any_timed and not timings and not any(map(turns_in, names))
        titles = [
            text for words in self.words for text in words.texts if len(text) < 60
        ]
        bad = any(
            re.search(vocabulary.pattern("not_measured"), text)
            and not re.search(TIMED, text)
            for text in titles
        )
        bad &= sum(map(is_head, self.grid.rows)) > 1
        if untimed or bad or (means and self.runs and not self.only_means):
            self.skipped = True
            if untimed:
                why = "untimed_table"
            elif bad:
                why = "table_not_measured"
            else:
                why = "table_of_means"
            self.faults.add(why, self.here[0][0], line=[self.head.line])
            return
        self.only_means = means if not self.runs else self.only_means
        for at, (cell, header) in enumerate(self.here):
            if cell.text and any(
                (cell.text, header) == (old.text, own) for old, own in self.here[:at]
            ):
                raise self.faults.refuse(
                    "same_spins" if header.roles == ("spin",) else "same_names", cell
                )
            place = len(self.columns)
            for k, (old_cell, old) in enumerate(self.columns):
                same = squeeze(old_cell.text) == squeeze(cell.text) != ""
                same |= len(old.roles) == 1 and (old.roles, old.number) == (
                    header.roles,
                    header.number,
                )
                if (
                    same
                    and turns_in(old_cell.text) == turns_in(cell.text)
                    and k not in self.places
                ):
                    place = min(place, k)
            if place == len(self.columns):
                self.columns.append((cell, header))
            elif self.columns[place][1].unit != header.unit and header.roles:
                raise self.faults.refuse(
                    "other_unit",
                    cell,
                    line=[cell.place.line],
                    first=self.columns[place][0].text,
                )
            self.places.append(place)

    def _read_captions(self, lacking: set[str], where: str = "below") -> Given:
        """Return what the rows of text above a run say of what is lacking in it.

        Above the first table the last row that says something is of this table; those
        before it are of all tables.
        """
        found: Given = {}
        lacking = lacking & _lacking([], self.grid)
        told_in = set(dict(self.faults.sheets))
        for row in _paragraphs(self.words):
            of_row = said_in(row)
            legends = (re.fullmatch(_LEGEND, text) for text in row.texts)
            is_legend = any(one and squeeze(one[2]) in self.legend for one in legends)
            if "turns" in of_row and "turns" not in self.decided and not is_legend:
                self._compare_with_headers(row, of_row["turns"][0])
            if said := {
                role: (text, row.spot(at))
                for role, (text, at) in of_row.items()
                if role in lacking
            }:
                told = ", ".join(f"{role} {text}" for role, (text, _) in said.items())
                self.said.append((self.grid.cell(row, filled_at(row)[0]), where, told))
                if not self.runs and found:
                    self.general = dict(found)
                two = [
                    role
                    for role, one in said.items()
                    if where == "above" and found.get(role, one)[0] != one[0]
                ]
                found = {
                    role: one for role, one in (found | said).items() if role not in two
                }
                lacking = lacking.difference(two)
                told_in |= {row.spot(at) // MAX_COLUMNS for at in range(len(row.texts))}
        for row in self.words:
            if row.line not in told_in and not row.texts[0].startswith("#"):
                self._leave_out("title", row)
        self.words = []
        return found

    def _compare_with_headers(self, caption: Row, turns: str) -> None:
        """Warn of each header of times that states other turns than a caption."""
        for cell, header in self.here:
            stated = turns_in(cell.text)
            of_others = roles.is_of_the_spin(cell.text) or header.roles == ("turns",)
            if turns and stated not in ("", turns) and not of_others:
                self.faults.add(
                    "turns_contradict_header",
                    cell,
                    header=cell.text,
                    turns=stated,
                    other=caption.texts[filled_at(caption)[0]],
                    says=turns,
                )

    def _compare_with_captions(self, turns: str, spot: int) -> None:
        """Warn of each row below the tables that states other turns than a caption."""
        for row in self.words:
            says = said_in(row).get("turns", ("", 0))[0]
            if says not in ("", turns):
                cell = self.grid.cell(row, filled_at(row)[0])
                caption = self.grid.lines[spot // MAX_COLUMNS - 1]
                self.faults.add(
                    "turns_contradict_header",
                    cell,
                    header=caption.strip(),
                    turns=turns,
                    other=cell.text,
                    says=says,
                )

    def finish(self) -> Layout:
        """Return all runs as one table.

        The function adds notes on everything that was left out, and on everything that
        was read from captions.
        """
        below: Given = {}
        if self.words:
            lacking = _lacking([header for _, header in self.columns]).difference(
                *(given for *_, given in self.runs)
            )
            cells_of = [
                dict(zip(places, row.texts, strict=False))
                for row, places, _ in self.runs
            ]
            for at, (_, header) in enumerate(self.columns):
                if roles.are_turns(header, [texts.get(at, "") for texts in cells_of]):
                    lacking.discard(
                        "turns"
                    )  # a column with an unknown name counts them
            above = {given["turns"] for *_, given in self.runs if "turns" in given}
            if len(above) == 1 and "turns" not in self.decided:
                [(turns, spot)] = above
                self._compare_with_captions(turns, spot)
            below = self._read_captions(lacking, "above")
        self.runs = [(row, places, below | given) for row, places, given in self.runs]
        for role, (_, spot) in {
            role: one for *_, given in self.runs for role, one in given.items()
        }.items():
            if not any(header.roles == (role,) for _, header in self.columns):
                place = find_place(self.grid.lines, self.grid.delimiter, spot)
                self.columns.append(
                    (Text(role, place), Header(role, (role,), None, ""))
                )
        headers = [header for _, header in self.columns]
        cells = [
            cell if cell.text else replace(cell, text=f"column {n}")
            for n, (cell, _) in enumerate(self.columns, 1)
        ]
        joined = []
        for row, places, given in self.runs:
            if not given and places == list(range(len(headers))):
                joined.append(
                    replace(
                        row, texts=[*row.texts, *[""] * (len(headers) - len(row.texts))]
                    )
                )
                continue
            # Each cell comes to the place of its column, with what the caption gives.
            texts = {
                [header.roles for header in headers].index((role,)): one
                for role, one in given.items()
            }
            typed = zip(
                [*places, *range(len(headers), len(headers) + len(row.texts))],
                row.texts,
                strict=False,
            )
            texts |= {
                place: (text, row.spot(at))
                for at, (place, text) in enumerate(typed)
                if text
            }
            filled = [
                texts.get(at, ("", row.spot(0)))
                for at in range(max([len(headers) - 1, *texts]) + 1)
            ]
            joined.append(
                Row(
                    row.line,
                    [text for text, _ in filled],
                    tuple(spot for _, spot in filled),
                )
            )
        parts = [
            joined[start:end] for start, end in pairwise([*self.tables, len(joined)])
        ]
        for part in parts:
            is_short = len(part) > 2 and len(filled_at(part[-1])) < min(
                len(filled_at(row)) for row in part[:-1]
            )
            is_apart = len(part) > 2 and part[-1].line > part[-2].line + 1
            of_all = is_short or (is_apart and _contains_means(part, headers, "spin"))
            if of_all and _contains_means(part, headers, "time"):
                self._leave_out("summary", part.pop())
        told_in = {cell.place.line for cell, *_ in self.said}
        for why, rows_left in self.left_out.items():
            if left := [one for one in rows_left if one[0].line not in told_in]:
                said, lines = (
                    listing([row.texts[at] for row, at in left], 4),
                    sorted({row.line for row, _ in left}),
                )
                self.faults.add(why, self.grid.cell(*left[0]), lines=lines, texts=said)
        for cell, where, told in self.said:
            self.faults.add(
                "caption", cell, line=[cell.place.line], where=where, said=told
            )
            self.faults.take_back("remark", [cell.place.line])
        if not self.runs:
            raise self.faults.refuse("no_runs")
        seen: set[tuple[str, ...]] = set()
        for part in parts:
            rows = [tuple(row.texts[: len(self.runs[0][1])]) for row in part]
            if sum(one in seen for one in rows) > 1:
                cell = self.grid.cell(part[0], filled_at(part[0])[0])
                raise self.faults.refuse("repeated_table", cell, line=[part[0].line])
            seen.update(rows)
        if len(parts) > 1:
            spans = ", ".join(
                self.faults.span(sorted({row.line for row in part})) for part in parts
            )
            self.faults.add("tables_joined", cells[0], count=len(parts), lines=spans)
        table = Layout(
            self.grid, cells, headers, [row for part in parts for row in part]
        )
        for at, ((cell, header), (behind, other)) in enumerate(
            pairwise(self.columns), 1
        ):
            # A header may be split at its own comma: "period [s], 5 turns".
            if (
                not cell.text
                or (header.unit and other.unit)
                or any(row.texts[at] for row in table.rows)
            ):
                continue
            if turns := turns_in(behind.text):
                raise self.faults.refuse(
                    "header_split", behind, header=cell.text, turns=turns
                )
        return table


def _contains_means(rows: list[Row], headers: list[Header], role: str) -> bool:
    """Return whether the last row contains the mean of each column of a role above it."""
    places = [at for at, header in enumerate(headers) if role in header.roles]
    try:
        columns = [[notation.to_float(row.texts[at]) for row in rows] for at in places]
    except (ValueError, IndexError):
        return False
    off = [
        abs(sum(above) - len(above) * last) / abs(sum(above) or 1)
        for *above, last in columns
    ]
    return max(off, default=1.0) < 1e-3


# --- Before the first run ---


_COPY = r"(?i)(?:\.|(?<!\s)\s+run\s?#?\s?)[0-9]{1,3}$"
"""What a spreadsheet or a data logger writes behind names that repeat."""


def _cut(row: Row, places: Iterable[int]) -> Row:
    cells = [at for at in places if at < len(row.texts)]
    return Row(row.line, [row.texts[at] for at in cells], tuple(map(row.spot, cells)))


def _blocks(rows: list[Row], first: int) -> list[tuple[list[Row], Row, list[Row]]]:
    """Put tables that are side by side below each other.

    The result contains the words above each table, its header and its rows.
    """
    head = rows[first]
    filled = filled_at(head)
    # A column on the left may number the rows of all tables.
    for left in (0, 1):
        names = "".join(
            f"{squeeze(re.sub(_COPY, '', head.texts[at]))}\n" for at in filled[left:]
        )
        if match := re.match(r"((?:.+\n){2,}?)\1+", names):
            break
    names_of_one = match[1].split() if match else []
    if len(names_of_one) < 2 or len(set(names_of_one)) < len(names_of_one):
        return [(rows[:first], head, rows[first + 1 :])]
    blocks: list[tuple[list[Row], Row, list[Row]]] = []
    last = max(
        (at for at, row in enumerate(rows) if any(map(is_number, row.texts))),
        default=first,
    )
    rows, notes = rows[: last + 1], rows[last + 1 :]
    starts = filled[left :: len(names_of_one)]
    titles = [
        row
        for row in rows[:first]
        if len(filled_at(row)) == 1 and filled_at(row)[0] <= starts[0]
    ]
    label_pattern = r"[^\d=]+" if starts[0] else r"[^\d=]+:"
    for start, end in pairwise([*starts, len(head.texts)]):
        words = [] if blocks else titles
        cut = [_cut(row, range(start, end)) for row in rows]
        for row, own in zip(rows[:first], cut, strict=False):
            if row not in titles and any(own.texts):
                # "mass:", "20 g", "", "40 g": the name at the side is valid for all.
                if start and re.fullmatch(label_pattern, row.texts[0]):
                    own = _cut(row, [0, *range(start, end)])
                words = [*words, own]
        own_head = replace(
            cut[first], texts=[re.sub(_COPY, "", text) for text in cut[first].texts]
        )
        blocks.append(
            (words, own_head, [row for row in cut[first + 1 :] if any(row.texts)])
        )
    blocks[-1][2].extend(notes)
    return blocks
