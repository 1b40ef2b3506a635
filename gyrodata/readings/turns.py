"""How many turns of precession a header, a caption or a cell states."""

from __future__ import annotations

import re
import unicodedata
from fractions import Fraction
from functools import lru_cache

from gyrodata.quantities import units, vocabulary
from gyrodata.quantities.units import kinds_of
from gyrodata.readings.names import NAMES
from gyrodata.readings.words import (
    MAX_HEADER,
    PRECESSION,
    TOKENS,
    squeeze,
    squeezed_names,
)

_NUMBER_OF = (
    r"(?i)(?<!\w)(?:number "
    r"of|nombre|numero|anzahl|número|aantal|antal|liczb\w|počet|cantidad|quantidade)"
)
_NOT_COUNTED = rf"{_NUMBER_OF}(?:\s+[^\W\d]+){{1,3}}\s*$"
AND, _FILLERS, _PARTS = (
    tuple(vocabulary.words(key).split()) for key in ("and", "filler", "part")
)
"""Words between two numbers of one count, "one and a half"; between a count and "turn";
and "part of" one turn."""
NUMBERS = dict(
    number.split("=")
    for number in squeezed_names(",".join(vocabulary.words("number").split()))
)
_SIGNS = "|".join(
    sorted((word for word in NUMBERS if chr(0x2E80) < word < chr(0xA000)), key=len)[
        ::-1
    ]
)
_SIGNS = f"(?<!第)(?:{_SIGNS})"
"""Numbers in languages without blanks between words."""
TURN, _PERIOD, _ONE_TURN, _DIVIDED = map(
    vocabulary.pattern, ("turn", "period", "one_turn", "divided")
)
_PARTS_OF_ONE = {
    word: f"1{number}"[-3:]
    for word, number in NUMBERS.items()
    if "/" in number and len(word) > 2
}
_JOINED = rf"(?i)\b({'|'.join(_PARTS_OF_ONE)})(?={TURN})"
"""Joined words such as "Vierteldrehung"."""
_ONES = "|".join([*_FILLERS, *re.findall(r"(\S+)=1(?!\S)", vocabulary.words("number"))])
_AND_A_HALF = (
    rf"(?i){TURN}\w*\s+(?:{'|'.join(AND)})\s+(?:an?\s+)?(?:half|halbe?|demie?|medi[ao]"
    rf"|mezz[ao]|meia)\b"
)
_COUNTED = (
    r"(?i)(?<![0-9.,/第])([0-9]{1,2}(?:[.,][0-9])?|[0-9]{1,2}\s*[/⁄]\s*[0-9]{1,2})\s*"
    rf"(?:(?:{_ONES}|d'|{PRECESSION})\s*){{0,3}}{TURN}(?!\w*/\w)"
)
_MIXED = (
    rf"(?i)(?:^|\(|([^\W\d]{{1,20}})[\s_]{{1,20}})([1-9][0-9]?)\s+([1-9]/[2-9])\s*"
    rf"(?:of\s+)?(?:an?\s+)?{TURN}"
)
_FOR = ("for", "of", "für", "pour", "de", "per", "para", "por")
_ALONE = (
    r"(?i)(?:t|time|Zeit|temps|tiempo|tempo|czas|время)[\s_(]*([1-9]\s*/\s*[2-9])\)?"
)
_PERIODS = r"([1-9][0-9]?)\s*[·*×]?\s*T(?!\w)"
_ANGLE = r"(?<![0-9.,])([1-9][0-9]{1,3})\s*([°º˚]|[^\W\d]+)"


@lru_cache(maxsize=4096)
def turns_in(header: str) -> str:
    """Find the turns that a header or a caption states: "1/3", "1", "2.5"; "" if it states none."""
    # Nearly all texts are units, numbers and known names, and the patterns below take
    # 20 ms to compile.
    if header.isalpha() and (kinds_of(header) or header.lower() in NAMES):
        return ""  # "rpm", "revolutions"
    if len(header) > MAX_HEADER or not re.search(r"[^\W\d_]|[°º˚]", header):
        return ""  # "20.3"
    plain = _in_plain_words(header)
    # Most texts name no turn: they need few of the patterns.
    names_turn = re.search(TURN, plain) is not None
    counted = _count_of_turns(plain) if names_turn else None
    if counted is not None:
        return counted
    if match := re.match(_ALONE, plain) or re.match(_PERIODS, plain):
        return _in_digits(match[1])
    if part := _part_in_degrees(plain):
        return part
    if names_turn and (number := _number_of_turns(plain)):
        return number
    if re.search(_ONE_TURN, plain):
        return "1"
    if not re.search(_PERIOD, plain):
        return ""
    number = words_of_turns(re.split(_PERIOD, plain)[0])
    return "" if number == "1" else number


def _in_plain_words(header: str) -> str:
    """Write a header without joined words such as "Vierteldrehung", and without "⅓"."""
    plain = "".join(
        f" {unicodedata.normalize('NFKC', c)}" if unicodedata.category(c) == "No" else c
        for c in header
    )
    for way, usual in vocabulary.WAYS["turns"]:
        plain = re.sub(way, usual, plain)
    if re.search(TURN, plain):
        plain = re.sub(
            _JOINED, lambda joined: f"{_PARTS_OF_ONE[joined[1].lower()]} ", plain
        )
    return plain


def _count_of_turns(plain: str) -> str | None:
    """Return the number in digits next to a word for a turn.

    It is "" if the number cannot be read, and None if there is none.
    """
    if re.search(_AND_A_HALF, plain):
        return ""  # nothing here reads a number from "1 tour et demi"
    if re.search(_DIVIDED, plain) and re.search(
        rf"[0-9]\s*(?:\w{{1,30}}+\s+)?(?:{TURN})", plain
    ):
        return "1"  # "we timed 3 turns and divided"
    if mixed := re.search(_MIXED, plain):
        # "Time 1 1/3 turn" may be the first of several.
        is_number = not mixed[1] or mixed[1].lower() in _FOR
        return str(int(mixed[2]) + Fraction(mixed[3])) if is_number else ""
    counted = re.search(_COUNTED, plain)
    return _in_digits(counted[1]) if counted else None


def _in_digits(number: str) -> str:
    return number.replace(" ", "").replace(",", ".").replace("⁄", "/")


def _part_in_degrees(plain: str) -> str:
    """Return the part of a turn that an angle of whole degrees is, such as 1/3; else ""."""
    match = re.search(_ANGLE, plain)
    if match is None or kinds_of(match[2]) != {"angle"}:
        return ""
    if units.parse(match[2]).text != "deg":
        return ""
    part = Fraction(int(match[1]), 360)
    return str(part) if part.denominator in (1, 2, 3, 4, 6, 12) else ""


def _number_of_turns(plain: str) -> str:
    """Return the number in words in front of a word for a turn; else ""."""
    for turn in re.finditer(rf"{TURN}(?!\w*/\w)", plain):
        before = plain[: turn.start()]
        # "back at screw 1 (one turn)"
        number = words_of_turns(before.rpartition("(")[2]) or words_of_turns(before)
        if number and not (number == "1" and re.search(_NOT_COUNTED, before)):
            return number
    return ""


def is_of_turns(word: str) -> bool:
    """Return whether a word belongs to a count of turns: "full", "third", "turn", "precession"."""
    return (
        word in _FILLERS
        or word in NUMBERS
        or bool(re.search(f"{TURN}|{_ONE_TURN}|{PRECESSION}", word))
    )


def words_of_turns(text: str, whole: bool = False) -> str:
    """Read the last words before "turn" as a number; else return "".

    For example, "one third of a" is 1/3, "zwei" is 2, and "one and a half" is 3/2.

    With `whole` the text contains nothing else, as in a cell, and digits count: "5
    half" is 5/2.
    """
    tokens = filter(None, TOKENS.split(re.sub(_SIGNS, r" \g<0> ", text.lower())))
    words = [
        word
        for word in tokens
        if word not in _FILLERS and not re.fullmatch(PRECESSION, word)
    ]
    words = [
        word if re.search("[0-9]", word) else squeeze(word).lower() for word in words
    ]
    numbers = [NUMBERS.get(word, word) for word in words]
    if numbers[-1:] == ["1"] and "/" in "".join(numbers[-2:-1]):
        del words[-1], numbers[-1]  # "a third of one"
    if len(words) > 1 and words[-1] in _PARTS and "/" in numbers[-2]:
        del words[-1], numbers[-1]  # "trzecia część"
    if not words or words[-1] not in NUMBERS:
        return ""
    *before, part = numbers
    if part.startswith("/"):
        count = before.pop() if before and before[-1].isdecimal() else ""
        part = (
            count or ("" if before or not whole else "1")
        ) + part  # "Drittel" alone in a cell
    mixed = before[-1:] != [] and before[-1] in AND
    before = before[: len(before) - mixed]
    count = before.pop() if before and before[-1].isdecimal() else ""
    # The digit of a header may number a trial, and not count parts of a turn.
    if before and before[-1] in _PARTS:
        return ""
    trial = bool(count) and not whole and words[len(before)].isdecimal()
    if part.startswith("/") or trial or (whole and before):
        return ""
    number = Fraction(part)
    return str(number + int(count) if mixed and count else number * int(count or 1))
