"""One header: which roles it may name, the unit it carries, and an uncertainty if it holds one.

A header is read in steps: take off a ±, take off the unit, then look the name up. A name that is not known as a whole
is looked up again without the small words around it: "mean", "of the", "initial", "uncertainty".
"""

from __future__ import annotations

import difflib
import re
import unicodedata
from collections.abc import Sequence
from fractions import Fraction
from functools import lru_cache

from msgspec import Struct
from msgspec.structs import replace

from gyrodata import vocabulary
from gyrodata.quantities import fold_number
from gyrodata.readings import roles
from gyrodata.readings.roles import NAMES, SYMBOLS, kind_of_role, squeeze, squeezed_words
from gyrodata.units import kinds_of

MAX_HEADER = 200
"""Characters in a header that are looked at: the work on a longer one grows with their cube, and it names nothing."""


class Header(Struct, frozen=True):
    """What a header says."""

    text: str
    roles: tuple[str, ...]
    """Roles it may name; none if it names none."""
    unit: str | None
    """Unit text as written, known or not; None if there is none."""
    spread: str
    """Text of a ±, with its unit if it has one; or ""."""
    number: int | None = None
    """Number of a repeat: ``time_2`` is 2."""


_SPREAD = r"[\[(]?\s*(?:±|\+/-|\+-)\s*([0-9]+(?:[.,][0-9]+)?)\s*([^\])\[(,;]*)[\])]?"
_BRACKET = r"(.*?)\s*(?:\[([^\[\]]*)\]|\(([^()]*(?:\([^()]*\)[^()]*)?)\))\s*"
_INDEX = r"(.*?[^\W\d])[\s_\-.]*([1-9][0-9]?)"
_WIDE_BRACKETS = str.maketrans("（）［］【】", "()[][]")
_TOKENS = re.compile(r"[\s_,;()\[\]\-]+")
_ORDINAL = r"(?:#|№|n[or]?[°º.]?)?([1-9][0-9]?)(?:st|nd|rd|th|er|re|ème|e|ª|º|[.)])?"
_SMALL_WORDS = roles.START_WORDS | roles.END_WORDS | roles.NOISE_WORDS
_AFFIXES = ((roles.START_WORDS, "", "_start"), (roles.END_WORDS, "", "_end"), (roles.UNSURE_WORDS, "u_", ""))
"""Words that change a role, with what they put before and behind its name."""
_SWEPT = ("rotation", "precession", "drehung", "präzession", "précession", "прецессия")
"""What is an angle where it is in degrees, and a rate else."""


@lru_cache(maxsize=4096)
def parse_header(text: str) -> Header:
    """Understand one header as far as it goes by itself."""
    if len(text) > MAX_HEADER:
        return Header(text, (), None, "")
    spread, rest = "", text.translate(_WIDE_BRACKETS)
    if match := re.search(_SPREAD, rest):
        spread = f"{match[1]} {match[2].strip()}".strip()
        rest = f"{rest[: match.start()].strip()} {rest[match.end() :].strip()}".strip(" ,;")
    name, unit = split_unit(rest)
    if unit is None and kinds_of(spread.partition(" ")[2]):
        unit = spread.partition(" ")[2]
    if unit and re.fullmatch(r"[a-zA-Z.]+:[a-zA-Z:.]+", unit):
        unit = "s"  # "mm:ss.cc": how its cells are written, and they say so themselves
    if not roles.THEORY_WORDS.isdisjoint(squeeze(token).lower() for token in _TOKENS.split(text)):
        return Header(text, (), unit, spread)  # worked out, not measured
    found, number = name_roles(name)
    kinds = kinds_of(unit or "")
    if not found and "time" in kinds and (number := _repeat(name)):
        found = ("time",)
    elif not found and "length" in kinds and (origin_in(name) or from_centre(name)):
        found = ("position",)
    return Header(text, _fitting(found, unit, name.strip()), unit, spread, number)


def with_unit(header: Header, unit: str) -> Header:
    """Give a header the unit of the row below it."""
    return replace(parse_header(f"{header.text} [{unit}]"), text=header.text)


def _fitting(found: tuple[str, ...], unit: str | None, name: str) -> tuple[str, ...]:
    """Keep the roles that the unit can measure; all of them if it fits none, so that the unit is at fault."""
    if unit is None:
        # A bare "N" counts turns: the other readings would need a unit.
        return tuple(role for role in found if kind_of_role(role) in ("number", "text", "sign")) or found
    kinds = kinds_of(unit)
    if kinds == {"angle"} and name.lower() in _SWEPT:
        return ("angle",)
    if kinds == {"rate"} and found == ("turns",):
        return ("spin",)  # "Rotations (rpm)"
    if kinds == {"force"} and found == ("mass",):
        return ("force",)  # "Weight (N)"
    kept = tuple(role for role in found if _measures(unit, role))
    if "time" in kinds and "/" in unit and not kept:
        # "spin [s/rev]" is a period under another name.
        kept = tuple(role.replace("spin", "spin_period", 1) for role in found if role.startswith("spin"))
    # A symbol says less than a unit: "D (s)" is not a torque.
    return kept if len(name) == 1 and kinds else kept or found


def _measures(unit: str, role: str) -> bool:
    return kind_of_role(role) in kinds_of(unit) or (unit == "%" and role.startswith("u_"))


def _repeat(name: str) -> int | None:
    """Read "Trial 2" and "2nd measurement" above times: the number of a repeat; None if it is none."""
    tokens = [token for token in _TOKENS.split(re.sub(r"(?<=[^\W\d])(?=[0-9])", " ", name)) if token]
    numbers = [match[1] for token in tokens if (match := re.fullmatch(_ORDINAL, token.lower()))]
    words = [token for token in tokens if not re.fullmatch(_ORDINAL, token.lower())]
    known = all(squeeze(word).lower() in roles.TRIAL_WORDS or "time" in name_roles(word)[0] for word in words)
    return int(numbers[0]) if len(numbers) == 1 and known else None


def split_unit(text: str) -> tuple[str, str | None]:
    """Part a header into its name and its unit: "m [g]", "t / s", "Zeit in s", "mass_g"; a rate alone is the spin's."""
    if match := re.fullmatch(_BRACKET, text):
        name, square, round_ = match.groups()
        inside = (round_ if square is None else square).strip()
        is_unit = _is_unit_of(name, inside)
        if inside and not is_unit and all(squeeze(word).lower() in roles.NOISE_WORDS for word in inside.split()):
            return split_unit(name)  # "RPM (measured)"
        said = name_roles(text)[0] if name_roles(name)[0] else not kinds_of(inside)
        if square is None and not is_unit and said:
            return text, None  # "czas (t)": a symbol, not a unit
        return name.rstrip(" /,;"), inside or None
    if match := re.fullmatch(r"(\w+?)_(rad|deg|rev)_(s|min)", text):
        return match[1], f"{match[2]}/{match[3]}"
    name, _, unit = text.rpartition("_")
    if any(kind_of_role(role) in kinds_of(unit) for role in name_roles(name)[0]):
        return name, unit  # "period_s" is not "periods"
    if name_roles(text)[0]:
        return text, None
    small = [token for token in text.split() if squeeze(token).lower() in _SMALL_WORDS]
    rest = " ".join(token for token in text.split() if token not in small)
    is_rate = kinds_of(rest) == {"rate"}
    # The shortest name comes first, so that "rad s^-1" stays whole; before a slash U is no uncertainty.
    parts = [
        (text[: match.start()].strip(" _/,;"), text[match.end() :].strip(" _").lstrip("/ "))
        for separator in (r"\s+(?:in|en|em|w|в)\s+", r"[\s_]+", r"[,;]", "/")
        for match in re.finditer(separator, text)
    ]
    # "时间 t/s" is a time in s, and not one in turns per second.
    for strict in (True, False):
        for name, unit in parts:
            fits = any(_measures(unit, role) for role in name_roles(name)[0])
            is_name = not is_rate or name_roles(name)[0] != ("turns",)
            if (
                is_name
                and unit not in ("h", "t", "r", "U", "об")
                and (fits or (not strict and _is_unit_of(name, unit)))
            ):
                return name, unit
    if is_rate:
        return " ".join(("spin", *small)), rest  # "Rev/min", "RPM before"
    name, _, unit = text.rpartition(" / ")
    if name and kinds_of(unit):
        return name.strip(), unit.strip()
    name, _, unit = text.rpartition(",")
    if name_roles(name)[0] and unit.strip():
        return name.strip(), unit.strip()  # an unknown unit, to be told so
    return text, None


def _is_unit_of(name: str, unit: str) -> bool:
    found, kinds = name_roles(name.rstrip(" /,;"))[0], kinds_of(unit)
    if not found:
        return "length" in kinds and from_centre(name)
    return any(_measures(unit, role) for role in found) or bool(kinds and not SYMBOLS.get(squeeze(unit)))


@lru_cache(maxsize=4096)
def name_roles(name: str) -> tuple[tuple[str, ...], int | None]:
    """Find the roles that a name without a unit may mean, and the number of a repeat."""
    if len(name) > MAX_HEADER:
        return (), None
    if found := _known(name) or _modified(name):
        return found, None
    match = re.fullmatch(_INDEX, name.strip())
    if match and "time" in (_known(match[1]) or _modified(match[1])):
        return ("time",), int(match[2])
    return (), None


def _known(name: str) -> tuple[str, ...]:
    """Look up a symbol or a name, as it is."""
    symbol, key = squeeze(name), re.sub(r"[\s-]", "_", name.lower())
    one_letter = SYMBOLS.get(symbol.lower(), ()) if len(symbol) == 1 else ()
    return SYMBOLS.get(symbol) or NAMES.get(symbol.lower()) or ((key,) if key in roles.UNCERTAINTIES else one_letter)


def _modified(name: str) -> tuple[str, ...]:
    """Look up "initial spin", "mean period", "error of T", "Mass, m": a known name between small words."""
    tokens = [token for token in _TOKENS.split(name) if token]
    if not 2 <= len(tokens) <= 8:
        return ()
    # "Mass m", "Tiempo de giro inicial T Gi", "m (mass)": what both mean is meant.
    for words, letters in ((tokens[:-1], tokens[-1:]), (tokens[:-2], tokens[-2:]), (tokens[1:], tokens[:1])):
        word, symbol = " ".join(words), SYMBOLS.get(squeeze(" ".join(letters)), ())
        both = tuple(role for role in symbol and (_known(word) or _modified(word)) if role in symbol)
        # A word of Chinese or Japanese may have two signs.
        if both and (len(squeeze(words[0])) > 2 or words[0] > "\u2e80"):
            return both
    lower = [squeeze(token).lower() for token in tokens]
    affixes = [affix for affix in _AFFIXES if not affix[0].isdisjoint(lower)]
    small = {word for words, _, _ in affixes for word in words}
    # Small words may belong to a name: "tiempo de giro".
    named = " ".join(token for token, low in zip(tokens, lower, strict=True) if low not in small)
    left = " ".join(token for token in named.split() if squeeze(token).lower() not in roles.NOISE_WORDS)
    before, after = "".join(one for _, one, _ in affixes), "".join(one for _, _, one in affixes)
    modified = (f"{before}{role}{after}" for role in (_known(left) or _known(named) if left else ()))
    return tuple(role for role in modified if role in roles.ROLES or role in roles.UNCERTAINTIES)


def suggest_role(header: str) -> str:
    """Propose the role whose name a header nearly is; "" if it is near to none."""
    name = re.split(r"[\[(]", split_unit(header)[0])[0].strip()
    key = squeeze(name).lower()
    if len(key) > 2 and (close := difflib.get_close_matches(key, NAMES, n=1, cutoff=0.75)):
        return NAMES[close[0]][0]
    match = re.fullmatch(_INDEX, name)  # "T_P_1"
    return next(iter(name_roles(match[1])[0]), "") if match else ""


AND, _FILLERS = (tuple(vocabulary.words(key).split()) for key in ("and", "filler"))
"""Words between two numbers of one count, "one and a half"; and words between a count and "turn"."""
_NUMBERS = dict(number.split("=") for number in vocabulary.words("number").split())
_TURN, _PERIOD = (f"(?i:{vocabulary.words(key, '|')})" for key in ("turn", "period"))
_AND_A_HALF = rf"(?i){_TURN}\w*\s+(?:{'|'.join(AND)})\s+(?:an?\s+)?(?:half|halbe?|demie?|medi[ao]|mezz[ao]|meia)\b"
_COUNTED = (
    r"(?i)(?<![0-9.,/])([0-9]{1,2}(?:[.,][0-9])?|[0-9]{1,2}\s*[/⁄]\s*[0-9]{1,2})\s*"
    rf"(?:(?:of|de|d'|precession|full|complete|an?|one|the|einer?)\s+){{0,3}}{_TURN}"
)
_MIXED = rf"(?i)(?:^|\(|([^\W\d]+)[\s_]+)([1-9][0-9]?)\s+([1-9]/[2-9])\s*(?:of\s+)?(?:an?\s+)?{_TURN}"
_FOR = ("for", "of", "für", "pour", "de", "per", "para", "por")
_ALONE = r"(?i)(?:t|time|Zeit|temps|tiempo|tempo|czas|время)[\s_(]*([1-9]\s*/\s*[2-9])\)?"
_PERIODS = r"([1-9][0-9]?)\s*[·*×]?\s*T(?!\w)"
_ANGLE = r"(?<![0-9.,])([1-9][0-9]{1,3})\s*(?:°|º|˚|deg\b|degrees)"


@lru_cache(maxsize=4096)
def turns_in(header: str) -> str:
    """Find the turns that a header or a caption states in so many words: "1/3", "1", "2.5"; "" if it states none."""
    plain = "".join(f" {unicodedata.normalize('NFKC', c)}" if unicodedata.category(c) == "No" else c for c in header)
    if len(header) > MAX_HEADER or re.search(_AND_A_HALF, plain):
        return ""  # no count is read of "1 tour et demi"
    if mixed := re.search(_MIXED, plain):
        # "Time 1 1/3 turn" may be the first of several.
        return str(int(mixed[2]) + Fraction(mixed[3])) if not mixed[1] or mixed[1].lower() in _FOR else ""
    if match := re.search(_COUNTED, plain) or re.match(_ALONE, plain) or re.match(_PERIODS, plain):
        return match[1].replace(" ", "").replace(",", ".").replace("⁄", "/")
    match = re.search(_ANGLE, plain)
    if match and (part := Fraction(int(match[1]), 360)).denominator in (1, 2, 3, 4, 6, 12):
        return str(part)
    if re.search(_TURN, plain):
        return words_of_turns(re.split(_TURN, plain)[0])
    said = words_of_turns(re.split(_PERIOD, plain)[0]) if re.search(_PERIOD, plain) else ""
    return "" if said == "1" else said


def part_counted(header: str) -> Fraction:
    """Find the part of a turn that a column of counts counts by its header, as "half turns"; or 1."""
    said = turns_in(header) or words_of_turns(header)  # "turns (half)"
    return Fraction(said) if re.fullmatch("1/[2-9]|2/3|3/4", said) else Fraction(1)


def words_of_turns(text: str, whole: bool = False) -> str:
    """Read the last words before "turn": "one third of a" is 1/3, "zwei" 2, "one and a half" 3/2; "" for no number.

    With `whole` nothing else may stand before them, as in a cell, and digits count: "5 half" is 5/2.
    """
    words = [word for word in _TOKENS.split(text.lower()) if word and word not in (*_FILLERS, "precession")]
    numbers = [_NUMBERS.get(word, word) for word in words]
    if numbers[-1:] == ["1"] and "/" in "".join(numbers[-2:-1]):
        del words[-1], numbers[-1]  # "a third of one"
    if not words or words[-1] not in _NUMBERS:
        return ""
    *before, part = numbers
    if part.startswith("/"):
        count = before.pop() if before and before[-1].isdecimal() else ""
        part = (count or ("" if before or not whole else "1")) + part  # "Drittel" alone in a cell
    mixed = before[-1:] != [] and before[-1] in AND
    before = before[: len(before) - mixed]
    count = before.pop() if before and before[-1].isdecimal() else ""
    # The digit of a header may number a trial, and not count parts of a turn.
    trial = bool(count) and not whole and words[len(before)].isdecimal()
    if part.startswith("/") or trial or (mixed and not count) or (whole and before):
        return ""
    number = Fraction(part)
    return str(number + int(count) if mixed else number * int(count or 1))


_TURNS = r"(?:[1-9]\s+)?[1-9][0-9]?\s*/\s*(?:[2-9]|12)"
_COUNT = r"[1-9][0-9]?(?:[.,](?:0+|25|5|50|75|3{2,}|6+7?))?|[0.]*[.,](?:25|5|50|75|3{2,}|6+7?)"


def are_turns(header: Header, texts: Sequence[str]) -> bool:
    """Tell whether the cells of a column count turns, though its name is not known: "how far" above 1/3, 2/3, 1.

    Fractions and words such as "one third" are enough; counts need a word for a turn in the name as well.
    """
    texts = [text for text in map(fold_number, texts) if text]
    parts = [bool(re.fullmatch(_TURNS, text) or words_of_turns(text, whole=True) or turns_in(text)) for text in texts]
    counts = [part or bool(re.fullmatch(_COUNT, text)) for part, text in zip(parts, texts, strict=True)]
    unknown = not header.roles and header.unit is None
    # "thirds of a turn" above 3 is something else.
    named = bool(re.search(_TURN, header.text)) and _NUMBERS.keys().isdisjoint(_TOKENS.split(header.text.lower()))
    return unknown and bool(texts) and all(counts) and (any(parts) or named)


def counts_weights(header: Header) -> bool:
    """Tell whether a column counts the weights that hang on the rod, as "number of weights" does."""
    words = vocabulary.words("weights", "|")
    return header.unit is None and not header.roles and bool(re.search(rf"(?i)\b(?:{words})\b", header.text))


_ORIGIN = tuple((origin, f"(?i){vocabulary.words(origin, '|')}") for origin in ("surface", "tip"))


def origin_in(header: str) -> str:
    """Find that a position counts from the surface of the ball or from the tip of the rod; "" if it does not say so."""
    if len(header) > MAX_HEADER or re.search(r"(?i)cent(?:re|er)|mittel|Mitte|центр|środk", header):
        return ""
    return next((origin for origin, words in _ORIGIN if re.search(words, header)), "")


def from_centre(header: str) -> bool:
    """Tell whether a header says that a length counts from the centre, as "x from centre" does."""
    if any(re.search(words, header) for _, words in _ORIGIN):
        return False
    # Chinese and Japanese have no blanks between words.
    return not roles.CENTRE_WORDS.isdisjoint(squeezed_words(header)) or any(
        w in header for w in roles.CENTRE_WORDS if w > "\u2e80"
    )


def clock_word(header: str) -> str:
    """Know "start (s)" and "t stop", two readings of a running clock: "start", "stop" or ""."""
    words = squeezed_words(header)
    return "start" if words & roles.START_WORDS else "stop" if words & roles.END_WORDS else ""


def is_of_the_spin(header: str) -> bool:
    """Tell whether a header says that what is timed are turns of the ball."""
    spins = re.search(r"(?i)spin|wheel|dis[ck]|rotor|ball|Kugel|Eigen|rotation propre|ротор|собств|шара", header)
    return bool(spins) and not re.search(r"pr[äeéê][cz][eé]?[sc]|прецес", header.lower())
