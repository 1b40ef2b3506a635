"""Read what sentences say of runs: captions, notes, legends and lines of units.

A sentence may give a quantity of the runs below it, such as "Weight 1: 20.1 g at 14.8
cm", or the turns that each time covers.
"""

from __future__ import annotations

import re
from bisect import bisect
from collections.abc import Iterable, Iterator
from itertools import accumulate, pairwise

from msgspec import Struct

from gyrodata.quantities import numerals, vocabulary
from gyrodata.quantities.units import kinds_of
from gyrodata.readings import roles
from gyrodata.readings.grid import Grid, Row, filled_at, has_numbers, is_head
from gyrodata.readings.headers import is_of_the_spin, parse_header
from gyrodata.readings.lablog import Faults, Text
from gyrodata.readings.names import name_roles
from gyrodata.readings.origins import from_centre, origin_in
from gyrodata.readings.remarks import (
    ALTERED,
    WIDE,
    altered_role,
    noted_centre,
    noted_origin,
)
from gyrodata.readings.turns import is_of_turns, turns_in, words_of_turns
from gyrodata.readings.words import (
    DIMENSION_WORDS,
    NOT_THE_WEIGHT,
    Phrases,
    squeeze,
    squeezed_words,
)

Given = dict[str, tuple[str, int]]
"""Content of captions: text and number of the cell by role."""

MAX_SENTENCES = 2_000
"""Characters of a row that is read as sentences; the time grows with the square of its
length."""
_CLAUSE_END = r"[,;.،；，。()]\s+"
SENTENCE_END = r"[.!?;]\s+(?=[A-ZÀ-ÞΑ-ΩА-ЯІЇ]|\w\s*=)|。"
_WORD = re.compile(r"[^\W\d_]{3}")

_AMOUNT = (
    r"(?:[0-9]{1,2}\s*[x×*·]\s*)?NUMBER(?:\([0-9]+\)|\s*(?:±|\+/-|\+-)\s*NUMBER)?"
).replace("NUMBER", numerals.NUMBER)
_UNIT = r"(?:1?/min|[^\W\d_][\w/^*·]*)"
QUANTITY = re.compile(
    rf"(?<![^\W\u2e80-\uffef])(?<![.,/])({_AMOUNT})\s*({_UNIT})(?!=)|"
    rf"(?<![uΔδσ])[\[(]({_UNIT})[\])]\W*({_AMOUNT})"
)
"""A number and its unit: "20.1 g", or "(g)" with "20.1" in the next cell."""
SAID_KINDS = {"mass": "mass", "length": "position", "rate": "spin"}
"""Roles of the quantities in sentences, by their kind."""

_SPHERE, _NOT_TIMED, _WEIGHT_ADDED = map(
    Phrases, ("sphere", "not_timed", "weight_added")
)
_WEIGHT, _APPARATUS = _WEIGHT_ADDED.pattern, vocabulary.pattern("ball")
_ON_ROD = rf"\b{vocabulary.pattern('on_rod')}\b"
"""Where a weight is: such words say that a mass is not that of the rod."""
_OF_BALL = (
    rf"(?i)^\W*(?:{vocabulary.pattern('article')}\s*)*{_APPARATUS}\b(?!.*{_WEIGHT})"
)
_SEVERAL_WEIGHTS = (
    rf"(?i)(?<![\w.,])(?:[2-9]|{vocabulary.pattern('several')})\s+"
    rf"(?:[^\W\d]+\s+)?{vocabulary.pattern('several_weights')}|[0-9]\s*k?g\s*\+\s*[0-9]"
)
"""Sentences whose quantities, or whose mass, are not those of a run: "Steel ball, m =
4.28 kg", "2 weights of 20 g"."""
_MOVED = frozenset(vocabulary.words("moved").split())
_NAMES_OF_TIME = re.split(r"[\s,]+", vocabulary.words("time", ","))
TIME_WORDS = {squeeze(word).lower() for word in _NAMES_OF_TIME if len(word) > 2}
_SIGNS_OF_TIME = "|".join(word for word in _NAMES_OF_TIME if word > "\u2e80")
TIMED = rf"\b{vocabulary.pattern('timed')}|{_SIGNS_OF_TIME}"
"""Verbs of a measurement, and words for a time in languages without blanks between
words."""
_DEFINITION = (
    r"(?i)(?:[=:]|\b(?:is|are|ist|sind|est|es|è))\s*(?:360|2\s*(?:pi|π)"
    r"|[^\W\d]+\s*/\s*[0-9])|360\D{0,9}="
)
"""What a turn is: "one turn = 360 deg"; or what was calculated: "time of 1 turn = t/3".
"""
_UNCERTAINTY = re.compile(r"\b(?:[uUΔδσ]\s?\(\w+\)|u_\w+:.*)\W*$")
"""The name in front of an uncertainty: "u(r) = 1 mm"."""


# --- Sentences ---


def said_in(row: Row, with_time: bool = False) -> Given:
    """Read "Weight 1: 20.1 g at 14.8 cm": text and cell by role, without roles of two values."""
    filled = filled_at(row)
    if sum(len(row.texts[at]) for at in filled) > MAX_SENTENCES:
        return {}
    whole = _joined([row.texts[at] for at in filled])
    ends = list(accumulate(len(row.texts[at]) + 1 for at in filled))
    found: dict[str, dict[str, int]] = {}
    for start, sentence in _sentences(whole):
        for role, text, place in _statements(sentence, start, ends, with_time):
            cell = filled[min(bisect(ends, start + place), len(filled) - 1)]
            found.setdefault(role, {}).setdefault(text, cell)
    # "Runs 1-4: a quarter turn; runs 5-8: a full turn"
    if len(set(map(turns_in, _clauses(whole))) - {""}) > 1:
        found.pop("turns", None)
    if turns := _named_turns((*row.texts, *_clauses(whole), *_equations(whole))):
        found["turns"] = {turns: filled[-1]}
    return dict(_without_contradictions(found))


def _without_contradictions(
    found: dict[str, dict[str, int]],
) -> Iterator[tuple[str, tuple[str, int]]]:
    """Yield the longest text of each role, with its cell, if all its texts are equal."""
    for role, texts in found.items():
        if len(set(map(_value_of, texts))) == 1:
            longest = max(texts, key=len)
            yield role, (longest, texts[longest])


def _joined(cells: list[str]) -> str:
    """Join the cells of a sentence, without marks of emphasis."""
    whole = "\0".join(cells).replace("**", "  ").replace("$", " ")
    # "x = 15,5 cm" above a table with commas between the cells is one number.
    whole = re.sub(r"([=:]\s*[0-9]+)\0(?=[0-9]{1,3}\s*[^\W\d])", r"\1,", whole)
    return whole.replace("\0", " ")


def _clauses(sentence: str) -> list[str]:
    return re.split(_CLAUSE_END, sentence)


def _equations(sentence: str) -> list[str]:
    return re.findall(r"(?<!\w)\w++=\S+", sentence)


def _sentences(whole: str) -> Iterator[tuple[int, str]]:
    """Yield each sentence, with the place at which it begins."""
    ends = [match.end() for match in re.finditer(SENTENCE_END, whole)]
    for start, end in pairwise([0, *ends, len(whole)]):
        yield start, whole[start:end]


def _named_turns(parts: Iterable[str]) -> str:
    """Return the turns of "Number of turns: 1/3" and "turns 1"; "" if there are none."""
    named = ""
    for part in parts:
        name, *value = re.split(r"(?:(?<!\s)\s+)?[:=：]\s*", part, maxsplit=1)
        if not value:
            name, *value = part.rsplit(maxsplit=1) or [""]
        if value and parse_header(name.lstrip("# ")).roles == ("turns",):
            named = turns_in(f"{value[0]} turns") or named
    return named


def _value_of(text: str) -> object:
    """Return what two texts of one value share: "60 g (on the scale: 60.0 g)"."""
    written = numerals.take_apart(text)
    return (written.value, written.unit) if written else text


class _Quantity(Struct, frozen=True):
    """A quantity in a sentence."""

    role: str
    text: str
    place: int
    """Place of its number in the sentence."""
    sentence: str
    begin: int
    """End of the quantity in front of it."""
    start: int
    end: int

    @property
    def own(self) -> str:
        """Return the text from the quantity before to the end of this one."""
        return self.sentence[self.begin : self.end]

    @property
    def clause(self) -> str:
        """Return its own text, and brackets behind it."""
        return self.own + _first(r"\s*\([^()]*\)", self.sentence[self.end :])

    @property
    def with_words_behind(self) -> str:
        """Return its clause with the words that follow, up to a comma or a number."""
        return self.clause + _first(r"[^,;.()0-9]*", self.sentence[self.end :])

    @property
    def after(self) -> str:
        """Return the word behind it."""
        return re.split(r"[\s,;:.()=]+", self.sentence[self.end :].lstrip())[0]


def _statements(
    sentence: str, start: int, ends: list[int], with_time: bool
) -> Iterator[tuple[str, str, int]]:
    """Yield role, text and place of each quantity that a sentence gives for runs.

    Parameters
    ----------
    sentence : str
        One sentence of a row.
    start : int
        Place of the sentence in the row.
    ends : list of int
        Places in the row at which its cells end.
    with_time : bool
        Whether times are read too.
    """
    if "?" in sentence:
        return
    sentence = re.sub(_ON_ROD, lambda words: " " * len(words[0]), sentence)
    own_ends = {end - start for end in ends}
    used = list(_quantities_of_run(sentence, own_ends, with_time))
    names = {quantity.role for quantity in used}
    not_timed = _is_not_timed(sentence, names)
    if not_timed or not _is_about_runs(sentence):
        used = _positions(used, sentence)
    for quantity in used:
        yield quantity.role, quantity.text, quantity.place
    turns = "" if not_timed else _turns_of_sentence(sentence, names)
    if turns:
        yield "turns", turns, len(sentence)


def _is_about_runs(sentence: str) -> bool:
    """Return whether the quantities of a sentence may be those of a run."""
    several = re.search(_SEVERAL_WEIGHTS, sentence)
    return not several and re.search(_OF_BALL, sentence) is None


def _quantities_of_run(
    sentence: str, ends: set[int], with_time: bool
) -> Iterator[_Quantity]:
    for quantity in _quantities(sentence, ends):
        is_read = with_time or quantity.role != "time"
        if is_read and _is_of_weight(quantity, sentence):
            yield quantity


def _positions(quantities: list[_Quantity], sentence: str) -> list[_Quantity]:
    """Return the positions of a sentence that says from where they are measured."""
    if not from_centre(sentence) and not noted_origin(sentence):
        return []
    return [quantity for quantity in quantities if quantity.role == "position"]


def _is_timed(sentence: str) -> bool:
    """Return whether a sentence is about the time of a run: "Rod timed over a third"."""
    is_about_time = re.search(TIMED, sentence) is not None
    return is_about_time and not is_of_the_spin(sentence)


def _is_not_timed(sentence: str, names: set[str]) -> bool:
    """Return whether a sentence says where a weight is, and not how a run was timed."""
    if {"spin", "time"} <= names:
        return False  # "The tachometer said 616 rpm and the stopwatch 16.6 s"
    outside = re.sub(r"\([^()]*\)", "", sentence)
    return _NOT_TIMED.is_in(outside if turns_in(outside) else sentence)


def _quantities(sentence: str, ends: set[int]) -> Iterator[_Quantity]:
    """Yield the quantities of a sentence whose kind a run has."""
    end = 0
    for match in QUANTITY.finditer(_without_brackets(sentence)):
        begin, end = end, match.end()
        number, unit = match[1] or match[4], match[2] or match[3]
        kinds = kinds_of(unit)
        role = next((SAID_KINDS[kind] for kind in SAID_KINDS if kind in kinds), "")
        if not role and "time" in kinds:
            role = "time"
        if not role or _is_split(sentence, match.start(), number, ends):
            continue
        place = match.start(1 if match[1] else 4)
        text = f"{number} {unit}"
        yield _Quantity(role, text, place, sentence, begin, match.start(), end)


def _without_brackets(sentence: str) -> str:
    """Return a sentence without brackets, but with those of units."""
    return re.sub(
        r"[\[(]([^()\[\]]*)[\])]",
        lambda inside: inside[0] if kinds_of(inside[1]) else f" {inside[1]} ",
        sentence,
    )


def _first(pattern: str, text: str) -> str:
    match = re.match(pattern, text)
    return match[0] if match else ""


def _is_split(sentence: str, start: int, number: str, ends: set[int]) -> bool:
    """Return whether a number may be split at its decimal comma: "Position 15,5 cm"."""
    if start not in ends or not number.isdigit() or not sentence[start - 2].isdigit():
        return False
    return re.search("[0-9],[0-9]", sentence) is None


def _is_of_weight(quantity: _Quantity, sentence: str) -> bool:
    """Return whether a quantity is that of a run, and not that of the ball or of the rod."""
    if _UNCERTAINTY.search(sentence[: quantity.start]):
        return False
    if quantity.role == "position":
        if squeeze(quantity.after).lower() in DIMENSION_WORDS:
            return False
        if origin_in(sentence):
            return _is_from_origin(quantity, sentence)
    if from_centre(quantity.with_words_behind):
        return True
    clause = quantity.clause
    of_ball = _SPHERE.is_in(clause) and not _WEIGHT_ADDED.is_in(clause)
    return not of_ball and _words_beside(quantity).isdisjoint(NOT_THE_WEIGHT)


def _is_from_origin(quantity: _Quantity, sentence: str) -> bool:
    """Return whether a length is a position from the surface or the tip, and no diameter."""
    own = quantity.own
    return bool(noted_origin(sentence)) and not WIDE.is_in(own)


def _words_beside(quantity: _Quantity) -> set[str]:
    """Return the words in front of a quantity, and the word behind it."""
    before = quantity.sentence[: quantity.start]
    words = [*re.split(r"[\s,;:()=]+", before[quantity.begin :]), quantity.after]
    beside = {squeeze(word).lower() for word in words}
    if beside & _MOVED:
        beside.discard("to")
    # Of "Rod weight at 16.0 cm", the rod is not meant.
    if re.search(rf"{_WEIGHT}\w*\s+(?:\w+\s+)?$", before):
        return {word for word in beside if not re.fullmatch(_APPARATUS, word)}
    return beside


# --- Turns ---


def _turns_of_sentence(sentence: str, found: set[str]) -> str:
    """Return the turns that a sentence states for the times of runs; "" if there are none.

    `found` has the roles of the quantities in the sentence.
    """
    if re.search(_OF_BALL, sentence) and not _is_timed(sentence):
        return ""
    parts = set(re.findall(r"[1-9]\s*/\s*[2-9]", sentence))
    if len(parts) > 1 or any(map(_defines_part, _clauses(sentence))):
        return ""
    for clause in (sentence, *_clauses(sentence)):
        turns = turns_in(clause)
        if turns and not re.search(_DEFINITION, clause) and _is_about(clause, found):
            return turns
    return ""


def _defines_part(clause: str) -> bool:
    """Return whether a clause says what a part of a turn is: "one screw = 1/3 turn"."""
    name, _, value = clause.partition("=")
    words = squeezed_words(name) - {""}
    names_reading = any(map(_names_reading, words))
    return bool(turns_in(value)) and not names_reading and not _has_word_of_time(words)


def _names_reading(word: str) -> bool:
    """Return whether a word names a reading; a screw is a mark on the bench."""
    roles = name_roles(word)[0]
    return bool(roles) and roles != ("screw",)


def _is_about(clause: str, found: set[str]) -> bool:
    """Return whether a clause with turns is about the times of runs.

    Such a clause names a time, or a mass of a run, or it contains hardly anything else.
    """
    if found & {"mass", "time"} or re.search(TIMED, clause):
        return True
    words = squeezed_words(QUANTITY.sub(" ", clause))
    words = {word for word in words if not word.isdecimal()}
    if _has_word_of_time(words):
        return True
    others = [
        word
        for word in words
        if len(word) > 2 and not is_of_turns(word) and not _names_reading(word)
    ]
    return len(others) < 2


def _has_word_of_time(words: set[str]) -> bool:
    """Return whether a word is "time" in a language, perhaps in the plural, as "Zeiten"."""
    endings = (slice(None), slice(-1), slice(-2))
    return not TIME_WORDS.isdisjoint(word[part] for word in words for part in endings)


# --- Units and legends ---

# --- Notes ---


def legends_of(grid: Grid) -> dict[str, str]:
    """Return what lines such as "d = distance from centre in cm" say of short headers.

    A line counts if it gives a unit, turns, or the moment of a reading.
    """
    texts = [_with_colon(row) for row in grid.titles()]
    texts += [text.text for text in grid.comments]
    texts += [f"{key}: {text.text}" for key, text in grid.metadata]
    legends = {}
    for text in texts:
        for match in map(_LEGEND.fullmatch, re.split(_LEGENDS, text)):
            if match is None:
                continue
            words = re.split(r"[;.]\s", f"{match[1] or ''} {match[3]}".strip())[0]
            words = words.rstrip(" )")
            if _explains_column(words):
                legends[squeeze(match[2])] = words
    return legends


def _explains_column(words: str) -> bool:
    """Return whether words give a unit, turns, or the moment of a reading."""
    explained = parse_header(words)
    says_moment = explained.moment != "" and len(explained.roles) == 1
    return bool(explained.unit or turns_in(words)) or says_moment


def _with_colon(row: Row) -> str:
    """Join the cells of a row; two cells, "d" and "distance", get a colon."""
    first, *others = row.filled() or [""]
    if len(others) == 1 and "=" not in first and ":" not in first:
        return f"{first}: {others[0]}"
    return ", ".join([first, *others])


def is_legend(text: str, legends: dict[str, str]) -> bool:
    """Return whether a text explains one of these symbols."""
    match = _LEGEND.fullmatch(text)
    return match is not None and squeeze(match[2]) in legends


def texts_of(grid: Grid) -> list[str]:
    """Return the comments, and the rows without numbers."""
    return [text.text for text in places_of(grid)]


def places_of(grid: Grid) -> list[Text]:
    """Return the comments, and the rows without numbers, with their places."""
    rows = [row for row in grid.rows if not has_numbers(row)]
    texts = [Text(" ".join(row.texts), grid.cell(row, 0).place) for row in rows]
    return [*grid.comments, *texts]


def read_notes(grid: Grid, faults: Faults) -> str:
    """Return the origin of positions that a note states, or "".

    The function warns of every note that may say that a reading is not what is typed,
    such as "twice the real rpm".
    """
    notes = _notes_of(grid)
    rows = [row for row in grid.rows if _has_words(row) and not has_numbers(row)]
    titles = [", ".join(row.texts) for row in rows]
    origins = map(noted_origin, [*notes, *titles])
    origin = next(filter(None, origins), "")
    if origin == "surface" and _name_centre(notes, rows):
        origin = "both"
    for note, cell in _remarks_in(grid):
        notes.setdefault(note, cell)
    _warn_of_notes(notes, faults)
    return origin


def _notes_of(grid: Grid) -> dict[str, Text]:
    """Return the lines behind # that give no value, with their places."""
    notes = {text.text: text for text in grid.comments}
    for key, text in grid.metadata:
        if key.lower() in roles.TEXTS or not roles.is_key(key):
            notes[f"{key}: {text.text}"] = text
    return notes


def _name_centre(notes: Iterable[str], rows: list[Row]) -> bool:
    """Return whether a note, or a row that is no header, names the centre as origin."""
    others = [", ".join(row.texts) for row in rows if not is_head(row)]
    return any(map(noted_centre, [*notes, *others]))


def _has_words(row: Row) -> bool:
    return any(map(_WORD.search, row.texts))


def _warn_of_notes(notes: dict[str, Text], faults: Faults) -> None:
    for note, cell in notes.items():
        if role := altered_role(note).replace("_", " "):
            faults.add("note", cell, note=note, role=role)


def _remarks_in(grid: Grid) -> Iterator[tuple[str, Text]]:
    """Yield the notes that are in rows, with the first cell of each."""
    for row in grid.rows:
        is_header = is_head(row)
        texts = {
            at: text
            for at, text in enumerate(row.texts)
            if _WORD.search(text) and _is_remark(text, is_header)
        }
        if texts:
            yield ", ".join(texts.values()), grid.cell(row, min(texts))


def _is_remark(text: str, is_header: bool) -> bool:
    """Return whether a cell with words may be a note, and not the name of a reading.

    The header "centre to inner face (cm)" is a position, and not that of the middle of
    the weight.
    """
    names = parse_header(text).roles
    if not names:
        return not is_header and not words_of_turns(text, whole=True)
    return "position" in names and ALTERED.is_in(text) and not origin_in(text)


_LEGENDS = r"[,;]\s+(?=\W*[^\W\d_]\w{0,7}\W?\s*[=:])"


_LEGEND = re.compile(
    r"\W*(?:([^\W\d_]{3,})\s+`)?([^\W\d_]\w{0,7})[`*]*\s*"
    r"(?:(?(1)|(?:[=:]|(?<=\s)(?:is|ist|est|è|es)\b))\s*([^\W\d].{3,90}))"
)
"""A line such as "d = distance from centre in cm"."""
