"""Read what sentences say of runs: captions, and notes on turns.

A sentence may give a quantity of the runs below it, such as "Weight 1: 20.1 g at 14.8
cm", or the turns that each time covers.
"""

from __future__ import annotations

import re
from bisect import bisect
from collections.abc import Iterable, Iterator
from itertools import accumulate, chain, filterfalse, pairwise

from gyrodata.quantities import numerals
from gyrodata.quantities.units import kinds_of
from gyrodata.readings.grid import Row, filled_at
from gyrodata.readings.headers import parse_header
from gyrodata.readings.lablog import Text
from gyrodata.readings.names import (
    BESIDE,
    CENTRE_WORDS,
    LETTERS,
    MAX_HEADER,
    PRECESSION,
    ROD,
    SMALL_WORDS,
    TRIAL_WORDS,
    Phrases,
    fold_name,
    from_centre,
    is_of_the_spin,
    name_roles,
    origin_in,
    word_set,
    words_of,
)
from gyrodata.readings.notes import altered_role
from gyrodata.readings.turns import is_of_turns, turns_in

Statements = dict[str, tuple[str, int]]
"""Content of captions: text and number of the cell by role."""

MAX_SENTENCES = 2_000
"""Characters of a row that is read as sentences; the time grows with the square of its
length."""
_CLAUSE_END = r"[,;.،；，。()]\s+"
SENTENCE_END = r"[.!?;]\s+(?=[A-ZÀ-ÞΑ-ΩА-ЯІЇ]|\w\s*=)|。"

_AMOUNT = (
    r"(?:[0-9]{1,2}\s*[x×*·]\s*)?NUMBER(?:\([0-9]+\)|\s*(?:±|\+/-|\+-)\s*NUMBER)?"
).replace("NUMBER", numerals.NUMBER)
_UNIT = r"(?:1?/min|[^\W\d_][\w/^*·]*)"
QUANTITY = re.compile(
    rf"(?<![^\W\u2e80-\uffef])(?<![.,/])({_AMOUNT})\s*({_UNIT})(?!=)|"
    rf"(?<![uΔδσ])[\[(]({_UNIT})[\])]\W*({_AMOUNT})"
)
"""A number and its unit: "20.1 g", or "(g)" with "20.1" in the next cell."""
ROLE_OF_KIND = {"mass": "mass", "length": "position", "rate": "spin", "time": "time"}
"""Roles of the quantities in sentences, by their kind."""

_TIMED = Phrases("timed")
"""Verbs of a measurement."""
_SMALL = (SMALL_WORDS | CENTRE_WORDS | TRIAL_WORDS | word_set("caption")).union(
    *BESIDE.values()
)
"""Words next to a quantity of a run that do not say of what it is."""
_NUMBERED = r"(?<=[^\W\d])\s?#?[1-9][0-9]?(?=\W*$|\s*[:=,])|=\s*[0-9/]+(?=\s)"
"""The number of a weight or a run: "Weight 1:", "m1 ="; and "turns=1"."""
_ROLES_BESIDE = frozenset({"mass", "position", "spin", "time", "turns", "run", "note"})


# --- Sentences ---


def statements_in(row: Row) -> Statements:
    """Read text and cell by role: "Weight 1: 20.1 g at 14.8 cm".

    A role with two values is left out.
    """
    filled = filled_at(row)
    cells = row.filled()
    if sum(map(len, cells)) > MAX_SENTENCES:
        return {}
    whole = _joined(cells)
    ends = list(accumulate(len(cell) + 1 for cell in cells))
    texts_by_role: dict[str, dict[str, int]] = {}
    for start, sentence in _sentences(whole):
        for role, text, place in _statements(sentence, start, ends):
            number = bisect(ends, start + place)
            cell = filled[min(number, len(filled) - 1)]
            texts_by_role.setdefault(role, {}).setdefault(text, cell)
    # "Runs 1-4: a quarter turn; runs 5-8: a full turn"
    clauses = _clauses(whole)
    stated = set(map(turns_in, clauses))
    stated.discard("")
    if len(stated) > 1:
        texts_by_role.pop("turns", None)
    if turns := _named_turns((*row.texts, *clauses)):
        texts_by_role["turns"] = {turns: filled[-1]}
    return dict(_without_contradictions(texts_by_role))


def _without_contradictions(
    texts_by_role: dict[str, dict[str, int]],
) -> Iterator[tuple[str, tuple[str, int]]]:
    """Yield the longest text of each role and its cell, if all its texts are equal."""
    for role, texts in texts_by_role.items():
        values = set(map(_value_of, texts))
        if len(values) == 1:
            longest = max(texts, key=len)
            yield role, (longest, texts[longest])


def _joined(cells: list[str]) -> str:
    """Join the cells of a sentence, without marks of emphasis."""
    return " ".join(cells).replace("**", "  ").replace("$", " ")


def _clauses(sentence: str) -> list[str]:
    return re.split(_CLAUSE_END, sentence)


def _sentences(whole: str) -> Iterator[tuple[int, str]]:
    """Yield each sentence, with the place at which it begins."""
    ends = [match.end() for match in re.finditer(SENTENCE_END, whole)]
    for start, end in pairwise([0, *ends, len(whole)]):
        yield start, whole[start:end]


def _named_turns(parts: Iterable[str]) -> str:
    """Return the turns of "Number of turns: 1/3" and "turns 1"; "" if there is none."""
    named = ""
    for part in parts:
        text = part[:MAX_HEADER]
        ends = [at for at, sign in enumerate(text) if sign in ":=：0123456789"]
        end = min(ends, default=len(text))
        value = text[end:].lstrip(":=：").strip()
        name = text[:end].strip("# ")
        names = parse_header(name).roles
        if value and names == ("turns",):
            named = turns_in(f"{value} turns") or named
        elif value and names == ("angle",) and PRECESSION.is_in(name):
            named = turns_in(value) or named
    return named


def _value_of(text: str) -> object:
    """Return what two texts of one value share: "60 g (on the scale: 60.0 g)"."""
    written = numerals.take_apart(text)
    if written:
        return written.value, written.unit
    return text


def _statements(
    sentence: str, start: int, ends: list[int]
) -> Iterator[tuple[str, str, int]]:
    """Yield role, text and place of each quantity that a sentence gives for runs.

    A quantity is that of a run if all words next to it are known: those of "Ball, 4.28
    kg" and "2 weights of 20 g" are not.

    Parameters
    ----------
    sentence : str
        One sentence of a row.
    start : int
        Place of the sentence in the row.
    ends : list of int
        Places in the row at which its cells end.
    """
    if "?" in sentence:
        return
    yield from _quantities(sentence, [end - start for end in ends])
    turns = _turns_of_sentence(sentence)
    if turns:
        yield "turns", turns, len(sentence)


def _quantities(sentence: str, ends: list[int]) -> Iterator[tuple[str, str, int]]:
    """Yield role, text and place of each quantity, until the first of no run."""
    bare = _without_brackets(sentence)
    end = 0
    for match in QUANTITY.finditer(bare):
        number = match[1] or match[4]
        unit = match[2] or match[3]
        start = match.start()
        before = bare[end:start]
        kinds = kinds_of(unit)
        if kinds:
            end = match.end()
        role = ROLE_OF_KIND.get(min(kinds, default=""), "")
        if not role or _is_split(sentence, start, number, ends):
            continue
        cell_end = next((at for at in ends if at > end), None)
        cell = bare[end:cell_end]
        behind = cell.removeprefix(f" {unit}").translate(_ENDS).partition(".")[0]
        if not _is_of_run(role, before, behind):
            break  # what follows may be of the ball too
        yield role, f"{number} {unit}", match.start(1 if match[1] else 4)


_ENDS = str.maketrans(",;()0123456789", "." * 14)
"""Signs behind which the words next to a quantity end."""


def _without_brackets(sentence: str) -> str:
    """Return a sentence without brackets, but with those of units."""
    return re.sub(r"[\[(]([^()\[\]]*)[\])]", _content_unless_unit, sentence)


def _content_unless_unit(brackets: re.Match[str]) -> str:
    content = brackets[1]
    if kinds_of(content):
        return brackets[0]
    return f" {content} "


def _is_split(sentence: str, start: int, number: str, ends: list[int]) -> bool:
    """Return whether a number may be split at its decimal comma: "Position 15,5 cm"."""
    if start not in ends or not number.isdigit():
        return False
    parts = sentence.split(",")
    has_commas = any(a[-1:].isdigit() and b[:1].isdigit() for a, b in pairwise(parts))
    return sentence[start - 2].isdigit() and not has_commas


def _is_of_run(role: str, before: str, behind: str) -> bool:
    """Return whether a quantity between some words is that of a run.

    A position may say from where it counts.
    """
    if re.search(r"[uUΔδσ]\s?\(\w+\)\W*$|u_\w+:.*$", before):
        return False  # an uncertainty
    if role == "position" and (from_centre(behind) or origin_in(behind)):
        behind = ""
    first_words = " ".join(LETTERS.findall(behind)[:2])
    if _TIMED.is_in(first_words) and not altered_role(behind):
        behind = ""  # "50 g (measured on the balance)"
    if turns_in(behind):
        behind = ""
    before = re.sub(_NUMBERED, " ", before)
    words = f"{before} {behind}"
    return "+" not in words and all(map(_is_known, filter(None, words_of(words))))


def _is_known(word: str) -> bool:
    """Return whether a word is a small one, or names a reading of a run."""
    if fold_name(word) in _SMALL or _TIMED.is_in(word):
        return not word.isdigit()
    names, _ = name_roles(word)
    return not _ROLES_BESIDE.isdisjoint(names)


def quoted(kinds: set[str], sentences: Iterable[Text]) -> str:
    """Quote the sentences with a quantity of one of some kinds, for a hint."""
    texts = []
    for sentence in sentences:
        quantities = QUANTITY.finditer(sentence.text)
        units = [match[2] or match[3] for match in quantities]
        is_of_kind = any(map(kinds.intersection, map(kinds_of, units)))
        if is_of_kind or ("number" in kinds and turns_in(sentence.text)):
            texts.append(f'"{sentence.text}"')
    return f"; the log says {', '.join(texts[:3])}" if texts else ""


# --- Turns ---


def turns_stated(sentences: Iterable[Text]) -> set[str]:
    """Return all numbers of turns that some sentences state."""
    clauses = chain.from_iterable(_clauses(sentence.text) for sentence in sentences)
    return set(map(turns_in, filterfalse(is_of_the_spin, clauses))) - {""}


def _is_of_turns_of_rod(word: str) -> bool:
    """Return whether a word may stand in a sentence about the turns of the rod."""
    return _is_known(word) or is_of_turns(word) or ROD.is_in(word)


def _turns_of_sentence(sentence: str) -> str:
    """Return the turns that a sentence states for runs; "" if there are none."""
    sentence = numerals.fold_number(sentence)
    if _is_calculation(sentence):
        return ""
    # Words behind a comma may change the turns: "one turn, added together".
    for clause in (sentence, *re.split(r"[;.()；。]\s+", sentence)):
        if turns := turns_in(clause):
            bare = QUANTITY.sub(" ", clause)
            words = LETTERS.findall(bare)
            if all(map(_is_of_turns_of_rod, words)):
                return turns
    return ""


def _is_calculation(sentence: str) -> bool:
    """Return whether a sentence has two fractions, or a sign of a formula: "t/3"."""
    pieces = sentence.split("/")
    parts = map(str.strip, pieces)
    ends = [(above[-1:], below[:1]) for above, below in pairwise(parts)]
    fractions = {end for end in ends if end[1].isdigit()}
    has_letter = any(above.isalpha() for above, _ in fractions)
    return "=" in sentence or has_letter or len(fractions) > 1
