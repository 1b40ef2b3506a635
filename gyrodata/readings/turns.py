"""How many turns of precession a header, a caption or a cell states."""

from __future__ import annotations

import re
import unicodedata
from fractions import Fraction
from functools import lru_cache

from gyrodata.quantities import units, vocabulary
from gyrodata.quantities.units import kinds_of
from gyrodata.readings.names import (
    MAX_HEADER,
    NAMES,
    PRECESSION,
    TOKENS,
    fold_name,
    word_set,
)

_NUMBER_OF = (
    r"(?i)(?<!\w)(?:number "
    r"of|nombre|numero|anzahl|número|aantal|antal|liczb\w|počet|cantidad|quantidade)"
)
_NOT_COUNTED = rf"{_NUMBER_OF}(?:\s+[^\W\d]+){{1,3}}\s*$"
AND, _FILLERS, _PARTS = (
    tuple(vocabulary.single_words(key)) for key in ("and", "filler", "part")
)
"""Words between two numbers of one count, "one and a half"; between a count and "turn";
and "part of" one turn."""
NUMBERS: dict[str, str] = {}
"""The number that a word says: "2", "1/2", or the denominator "/3"."""
for _number in vocabulary.numbers():
    NUMBERS |= dict.fromkeys(word_set(_number), _number)
SIGNS = "|".join(
    sorted((word for word in NUMBERS if chr(0x2E80) < word < chr(0xA000)), key=len)[
        ::-1
    ]
)
SIGNS = f"(?<!第)(?:{SIGNS})"
"""Numbers in languages without blanks between words."""
TURN = vocabulary.expression("turn")
MARK = "ꙮ"
"""Stands for a word for a turn, or for its beginning: a letter that no log contains."""
_ONE_TURN, DIVIDED = map(vocabulary.pattern, ("one_turn", "divided"))
_FULL_TURN = rf"{MARK}\w*\s+{vocabulary.pattern('full')}"
"""In "vuelta completa"."""
_PARTS_OF_ONE = {
    word: f"1{number}"[-3:]
    for word, number in NUMBERS.items()
    if "/" in number and len(word) > 2
}
_JOINED = rf"(?i)\b({'|'.join(_PARTS_OF_ONE)})(?={MARK})"
"""Joined words such as "Vierteldrehung"."""
_ONES = "|".join([*_FILLERS, *vocabulary.single_words("1")])
_AND_A_HALF = (
    rf"(?i){MARK}\w*\s+(?:{'|'.join(AND)})\s+(?:an?\s+)?(?:half|halbe?|demie?|medi[ao]"
    rf"|mezz[ao]|meia)\b"
)
_COUNTED = (
    r"(?i)(?<![0-9.,/第])([0-9]{1,2}(?:[.,][0-9])?|[0-9]{1,2}\s*[/⁄]\s*[0-9]{1,2})[\s-]*"
    rf"(?:(?:{_ONES}|d'|{PRECESSION})\s*){{0,3}}{MARK}(?!\w*/\w)"
)
_MIXED = (
    rf"(?i)(?:^|\(|([^\W\d]{{1,20}})[\s_]{{1,20}})([1-9][0-9]?)\s+([1-9]/[2-9])\s*"
    rf"(?:of\s+)?(?:an?\s+)?{MARK}"
)
_FOR = ("for", "of", "für", "pour", "de", "per", "para", "por")
_ANGLE = r"(?<![0-9.,])([1-9][0-9]{1,3})\s*([°º˚]|[^\W\d]+)"
_SIGNS_OF_TURNS = (TURN, _ANGLE, _ONE_TURN)
"""What a text contains that states turns."""


def mark_turns(text: str) -> str:
    """Write `MARK` for each word for a turn, so that other patterns are short."""
    return re.sub(TURN, MARK, text)


@lru_cache(maxsize=4096)
def turns_in(text: str) -> str:
    """Find the turns that a header or a caption states: "1/3", "1", "2.5".

    The function returns "" if it states none, or if they cannot be read.
    """
    if len(text) > MAX_HEADER or _states_no_turns(text):
        return ""
    plain = _in_plain_words(text)
    marked = mark_turns(plain)
    number = ""
    if MARK in marked:
        # "1/4 turn" for "Vierteldrehung"
        marked = re.sub(
            _JOINED, lambda word: f"{_PARTS_OF_ONE[word[1].lower()]} ", marked
        )
        counted = _count_of_turns(marked)
        if counted is not None:
            return counted
        number = _number_of_turns(marked)
    degrees = _part_in_degrees(plain)
    return degrees or number or _one_turn(plain, marked)


def _states_no_turns(text: str) -> bool:
    """Return whether a text is a number, a unit or a name: most texts are.

    The patterns of turns take 20 ms to compile.
    """
    if text.isalpha() and (kinds_of(text) or text.lower() in NAMES):
        return True  # "rpm", "revolutions"
    if not re.search(r"[^\W\d_]|[°º˚]", text):
        return True  # "20.3"
    return text.isascii() and not (
        _may_contain_number(text)
        and any(re.search(sign, text) for sign in _SIGNS_OF_TURNS)
    )


def _may_contain_number(text: str) -> bool:
    """Return whether an English text may contain a number, in digits or in words."""
    if re.search("[0-9]", text):
        return True
    small = text.lower()
    is_word = not NUMBERS.keys().isdisjoint(TOKENS.split(small))
    return is_word or any(
        part in small for part in (*_PARTS_OF_ONE, "voll", "once", "twice")
    )


def _one_turn(plain: str, marked: str) -> str:
    """Return "1" for "full turn" in one word or in another order; else ""."""
    is_full = MARK in marked and re.search(_FULL_TURN, marked)
    return "1" if is_full or re.search(_ONE_TURN, plain) else ""


def _in_plain_words(header: str) -> str:
    """Write a header in the usual words and numbers, without signs such as "⅓"."""
    plain = ""
    for letter in header:
        if unicodedata.category(letter) == "No":
            plain += " " + unicodedata.normalize("NFKC", letter)
        else:
            plain += letter
    for way, usual in vocabulary.WAYS["turns"]:
        plain = re.sub(way, usual, plain)
    return plain


def _count_of_turns(marked: str) -> str | None:
    """Return the number in digits next to a word for a turn.

    It is "" if the number cannot be read, and None if there is none.
    """
    if re.search(_AND_A_HALF, marked):
        return ""  # nothing here reads a number from "1 tour et demi"
    has_number = re.search(rf"[0-9]\s*(?:\w{{1,30}}+\s+)?{MARK}", marked)
    if has_number and re.search(DIVIDED, marked):
        return "1"  # "we timed 3 turns and divided"
    if mixed := re.search(_MIXED, marked):
        # "Time 1 1/3 turn" may be the first of several.
        is_number = not mixed[1] or mixed[1].lower() in _FOR
        if is_number:
            return str(int(mixed[2]) + Fraction(mixed[3]))
        return ""
    counted = re.search(_COUNTED, marked)
    if counted is None:
        return None
    return counted[1].replace(" ", "").replace(",", ".").replace("⁄", "/")


def _part_in_degrees(plain: str) -> str:
    """Return the part of a turn that an angle in whole degrees is: 1/3; else ""."""
    match = re.search(_ANGLE, plain)
    if match is None or kinds_of(match[2]) != {"angle"}:
        return ""
    if units.parse(match[2]).text != "deg":
        return ""
    part = Fraction(int(match[1]), 360)
    if part.denominator in (1, 2, 3, 4, 6, 12):
        return str(part)
    return ""


def _number_of_turns(marked: str) -> str:
    """Return the number in words in front of a word for a turn; else ""."""
    for turn in re.finditer(rf"{MARK}(?!\w*/\w)", marked):
        before = marked[: turn.start()]
        # "back at screw 1 (one turn)"
        number = words_of_turns(before.rpartition("(")[2]) or words_of_turns(before)
        if number and not (number == "1" and re.search(_NOT_COUNTED, before)):
            return number
    return ""


def is_of_turns(word: str) -> bool:
    """Return whether a word belongs to a count of turns: "full", "third", "turn"."""
    word = word.lower()
    if word in _FILLERS or word in NUMBERS or re.search(TURN, word):
        return True
    return bool(re.search(_ONE_TURN, word) or re.search(PRECESSION, word))


def words_of_turns(text: str, whole: bool = False) -> str:
    """Read the last words before "turn" as a number; else return "".

    For example, "one third of a" is 1/3, "zwei" is 2, and "one and a half" is 3/2.

    With `whole` the text contains nothing else, as in a cell, and digits count: "5
    half" is 5/2.
    """
    words = _number_words(text)
    if not words or words[-1] not in NUMBERS:
        return ""
    numbers = [NUMBERS.get(word, word) for word in words]
    part, rest = _last_part(numbers, whole)
    is_sum = "".join(rest[-1:]) in AND
    count, before = _last_count(rest[: len(rest) - is_sum])
    # The digit of a header may number a trial, and not count parts of a turn.
    is_trial = count and not whole and words[len(before)].isdecimal()
    is_inside = before and (whole or before[-1] in _PARTS)
    return "" if not part or is_trial or is_inside else _total(count, part, is_sum)


def _total(count: str, part: str, is_sum: bool) -> str:
    """Return 3/2 for "one and a half", and 2/3 for two parts of 1/3."""
    if count and is_sum:
        return str(int(count) + Fraction(part))
    return str(int(count or 1) * Fraction(part))


def _number_words(text: str) -> list[str]:
    """Return the words of a number, without small words in it and behind it."""
    spaced = re.sub(SIGNS, r" \g<0> ", text.lower())
    words = []
    for word in TOKENS.split(spaced):
        is_small = word in ("", *_FILLERS)
        if not is_small and not re.fullmatch(PRECESSION, word):
            has_digit = re.search("[0-9]", word)
            words.append(word if has_digit else fold_name(word))
    if len(words) < 2:
        return words
    before, last = words[-2:]
    is_small = NUMBERS.get(last) == "1" or last in _PARTS
    if is_small and "/" in NUMBERS.get(before, before):
        return words[:-1]  # "a third of one", "trzecia część"
    return words


def _last_part(numbers: list[str], whole: bool) -> tuple[str, list[str]]:
    """Return the last number, with the count of a denominator, and those before it.

    "two", "/3" is 2/3.
    """
    *rest, part = numbers
    if not part.startswith("/"):
        return part, rest
    if whole and not rest:
        return f"1{part}", []  # "Drittel" in a cell
    count, before = _last_count(rest)
    return count and count + part, before


def _last_count(numbers: list[str]) -> tuple[str, list[str]]:
    """Return a whole number at the end, or "", and the numbers before it."""
    if numbers and numbers[-1].isdecimal():
        return numbers[-1], numbers[:-1]
    return "", numbers
