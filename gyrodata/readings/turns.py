"""How many turns of precession a header, a caption or a cell states."""

from __future__ import annotations

import re
import unicodedata
from fractions import Fraction
from functools import lru_cache

from gyrodata.quantities import units, vocabulary
from gyrodata.quantities.numerals import has_digit
from gyrodata.quantities.units import kinds_of
from gyrodata.readings.names import (
    MAX_HEADER,
    NAMES,
    PRECESSION,
    TOKENS,
    Phrases,
    fold_name,
    word_set,
)

_NUMBER_OF = {
    *("number", "nombre", "numero", "anzahl", "aantal", "antal", "liczba", "pocet"),
    *("cantidad", "quantidade"),
}
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
_ONE_TURN, DIVIDED, _FULL = map(Phrases, ("one_turn", "divided", "full"))
"""Phrases such as "Vollkreis", "divided by", and the second word of "vuelta completa".
"""
_PARTS_OF_ONE = {
    word: f"1{number}"[-3:]
    for word, number in NUMBERS.items()
    if "/" in number and len(word) > 2
}
_ONES = "|".join([*_FILLERS, *vocabulary.single_words("1")])
_COUNTED = (
    r"(?i)(?<![0-9.,/第])([0-9]{1,2}(?:[.,][0-9])?|[0-9]{1,2}\s*[/⁄]\s*[0-9]{1,2})[\s-]*"
    rf"(?:(?:{_ONES}|d'|{PRECESSION.pattern}[^\W\d_]*\.?)\s*){{0,3}}"
    rf"{MARK}(?!\w*/\w)"
)
_MIXED = (
    rf"(?i)(?:^|\(|([^\W\d]{{1,20}})[\s_]{{1,20}})([1-9][0-9]?)\s+([1-9]/[2-9])\s*"
    rf"(?:of\s+)?(?:an?\s+)?{MARK}"
)
_FOR = ("for", "of", "für", "pour", "de", "per", "para", "por")
_ANGLE = r"(?<![0-9.,])([1-9][0-9]{1,3})\s*([°º˚]|[^\W\d]+)"


def mark_turns(text: str) -> str:
    """Write `MARK` for each word for a turn, so that other patterns are short."""
    return re.sub(TURN, MARK, text)


def names_turns(text: str) -> bool:
    """Return whether a text contains a word for a turn."""
    return MARK in mark_turns(text)


def separate_signs(text: str) -> str:
    """Return a text in small letters, with blanks around signs of numbers."""
    return re.sub(SIGNS, r" \g<0> ", text.lower())


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
        counted = _count_of_turns(marked)
        if counted is not None:
            return counted
        number = _number_of_turns(marked)
    degrees = _part_in_degrees(plain)
    return degrees or number or _one_turn(plain, marked)


def _states_no_turns(text: str) -> bool:
    """Return whether a text is a number, a unit or a name: most texts are."""
    if text.isalpha() and (kinds_of(text) or text.lower() in NAMES):
        return True  # "rpm", "revolutions"
    if not any(map(str.isalpha, text)) and _DEGREES.isdisjoint(text):
        return True  # "20.3"
    return text.isascii() and not _may_contain_number(text)


_DEGREES = frozenset("°˚")


def _may_contain_number(text: str) -> bool:
    """Return whether an English text may contain a number, in digits or in words."""
    if has_digit(text):
        return True
    small = text.lower()
    is_word = not NUMBERS.keys().isdisjoint(TOKENS.split(small))
    return is_word or any(
        part in small for part in (*_PARTS_OF_ONE, "voll", "once", "twice")
    )


def _one_turn(plain: str, marked: str) -> str:
    """Return "1" for "full turn" in one word or in another order; else ""."""
    is_full = any(_FULL.is_in(" ".join(words[:2])) for words in _words_behind(marked))
    return "1" if is_full or _ONE_TURN.is_in(plain) else ""


def _words_behind(marked: str) -> list[list[str]]:
    """Return the words behind each word for a turn."""
    return [TOKENS.split(behind)[1:] for behind in marked.split(MARK)[1:]]


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
    if any(map(_begins_with_half, _words_behind(marked))):
        return ""  # nothing here reads a number from "1 tour et demi"
    if has_digit(marked) and DIVIDED.is_in(marked):
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


def _begins_with_half(words: list[str]) -> bool:
    """Return whether some words begin with "and a half"."""
    names = map(fold_name, words[1:3])
    return "".join(words[:1]) in AND and "1/2" in map(NUMBERS.get, names)


def _part_in_degrees(plain: str) -> str:
    """Return the part of a turn that an angle in whole degrees is: 1/3; else ""."""
    match = re.search(_ANGLE, plain)
    if match is None or kinds_of(match[2]) != {"angle"}:
        return ""
    unit = units.parse(match[2])
    if unit.text != "deg":
        return ""
    degrees = int(match[1])
    part = Fraction(degrees, 360)
    if part.denominator in (1, 2, 3, 4, 6, 12):
        return str(part)
    return ""


def _number_of_turns(marked: str) -> str:
    """Return the number in words in front of a word for a turn; else ""."""
    before, *parts = marked.split(MARK)
    for behind in parts:
        end, slash, unit = behind.partition("/")
        is_rate = slash and unit[:1].isalpha() and (not end or end.isalpha())
        number = "" if is_rate else _number_before_turn(before)
        if number:
            return number
        before = f"{before}{MARK}{behind}"
    return ""


def _number_before_turn(before: str) -> str:
    """Return the number that the words before a word for a turn say; else ""."""
    words = [fold_name(word) for word in TOKENS.split(before) if word]
    is_joined = before[-1:].isalpha() and words[-1] in _PARTS_OF_ONE
    if is_joined and not has_digit("".join(words[-2:-1])):
        return _PARTS_OF_ONE[words[-1]]  # "Vierteldrehung"
    # "back at screw 1 (one turn)"
    number = words_of_turns(before.rpartition("(")[2]) or words_of_turns(before)
    is_name = number == "1" and not _NUMBER_OF.isdisjoint(words[-4:])
    return "" if is_name else number  # "number of full turns"


def is_of_turns(word: str) -> bool:
    """Return whether a word belongs to a count of turns: "full", "third", "turn"."""
    word = word.lower()
    if word in _FILLERS or fold_name(word) in NUMBERS or names_turns(word):
        return True
    return _ONE_TURN.is_in(word) or PRECESSION.is_in(word)


def words_of_turns(text: str, whole: bool = False) -> str:
    """Read the last words before "turn" as a number; else return "".

    For example, "one third of a" is 1/3, "zwei" is 2, and "one and a half" is 3/2.

    With `whole` the text contains nothing else, as in a cell, and digits count: "5
    half" is 5/2.
    """
    words = _number_words(text)
    if not words or words[-1] not in NUMBERS:
        return ""
    # "one and a half" is ["1", "and", "1/2"]: part "1/2", a sum, count "1", no more.
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
    words = []
    for word in TOKENS.split(separate_signs(text)):
        is_small = word in ("", *_FILLERS)
        if not is_small and not PRECESSION.is_in(word):
            words.append(word if has_digit(word) else fold_name(word))
    if len(words) < 2:
        return words
    before, last = words[-2:]
    is_small = NUMBERS.get(last) == "1" or last in _PARTS
    if is_small and "/" in NUMBERS.get(before, before):
        return words[:-1]  # "a third of one", "trzecia część"
    return words


def _last_part(numbers: list[str], whole: bool) -> tuple[str, list[str]]:
    """Return the last number, with the count of a denominator, and those before it.

    Of ["1", "and", "1/2"] it is "1/2" with ["1", "and"], and of ["2", "/3"], which are
    "two thirds", it is "2/3" with [].
    """
    *rest, part = numbers
    if not part.startswith("/"):
        return part, rest
    if whole and not rest:
        return f"1{part}", []  # "Drittel" in a cell
    count, before = _last_count(rest)
    return count and count + part, before


def _last_count(numbers: list[str]) -> tuple[str, list[str]]:
    """Return a whole number at the end, or "", and the numbers before it.

    Of ["1", "and", "2"] it is "2" with ["1", "and"].
    """
    if numbers and numbers[-1].isdecimal():
        return numbers[-1], numbers[:-1]
    return "", numbers
