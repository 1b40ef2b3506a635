"""One header: which roles it may name, the unit it carries, and an uncertainty if it holds one."""

from __future__ import annotations

import difflib
import re
import unicodedata
from collections.abc import Collection
from fractions import Fraction
from functools import lru_cache

from msgspec import Struct
from msgspec.structs import replace

from gyrodata import vocabulary
from gyrodata.readings.roles import (
    CENTRE_WORDS,
    END_WORDS,
    NAMES,
    NOISE_WORDS,
    ROLES,
    START_WORDS,
    SYMBOLS,
    THEORY_WORDS,
    TRIAL_WORDS,
    UNCERTAINTIES,
    UNSURE_WORDS,
    kind_of_role,
    squeeze,
)
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
_BRACKET = re.compile(r"(.*?)\s*(?:\[([^\[\]]*)\]|\(([^()]*(?:\([^()]*\)[^()]*)?)\))\s*")
_INDEX = re.compile(r"(.*?[^\W\d])[\s_\-.]*([1-9][0-9]?)")
_WIDE_BRACKETS = str.maketrans("（）［］【】", "()[][]")
_TOKENS = re.compile(r"[\s_,;()\[\]\-]+")
_IN_UNIT = re.compile(r"(.+?)\s+(?:in|en|em|w|в)\s+(\S.*)")


_PARTS = {
    "half": "1/2",
    "halbe": "1/2",
    "halben": "1/2",
    "demi": "1/2",
    "demitour": "1/2",
    "media": "1/2",
    "medio": "1/2",
    "meia": "1/2",
    "pół": "1/2",
    "пол": "1/2",
    "половина": "1/2",
    "third": "1/3",
    "thirds": "/3",
    "drittel": "/3",
    "tiers": "/3",
    "tercio": "1/3",
    "tercios": "/3",
    "terzo": "1/3",
    "terzi": "/3",
    "terço": "1/3",
    "terços": "/3",
    "треть": "1/3",
    "трети": "/3",
    "quarter": "1/4",
    "quarters": "/4",
    "one": "1",
    "full": "1",
    "whole": "1",
    "single": "1",
    "complete": "1",
    "eine": "1",
    "einer": "1",
    "ganze": "1",
    "volle": "1",
    "un": "1",
    "entier": "1",
    "один": "1",
    "полный": "1",
    "una": "1",
    "completa": "1",
    "uma": "1",
    "jeden": "1",
    "jednego": "1",
    "ett": "1",
    "één": "1",
    "jednoho": "1",
    "egy": "1",
    "bir": "1",
    "yhden": "1",
    "μιας": "1",
    "pełny": "1",
    "two": "2",
    "four": "4",
    "five": "5",
    "six": "6",
    "seven": "7",
    "eight": "8",
    "nine": "9",
    "ten": "10",
    "zwei": "2",
    "deux": "2",
    "dos": "2",
    "due": "2",
    "dois": "2",
    "две": "2",
    "три": "3",
    "three": "3",
    "ein": "1",
}
"""Words of a count of turns."""
_FILLERS = ("of", "a", "an", "the", "de", "einer")
AND = ("and", "&", "und", "et", "y", "e", "и")
"""Words between two numbers of one count: "one and a half"."""
_AND_A_HALF = rf"\w*\s+(?:{'|'.join(AND)})\s+(?:an?\s+)?(?:half|halbe?|demie?|medi[ao]|mezz[ao]|meia)\b"
_TURN = (
    r"(?:turn|rev|rotation|revolution|cycle|circle|lap|rounds?\b|Umdreh|Umlauf|Umläuf|Drehung|Runde|tour|оборот|об\b|"
    r"vuelta|volta|giro\b|obrót|obrot|okrąż|omwentel|varv|otáč|otoč|fordul|kierro|περιστροφ|圈|转|回転)"
)
_PERIOD = r"(?:period|périod|período|okres|период|周期)"
_COUNTED = (
    r"(?i)(?<![0-9.,/])([0-9]{1,2}(?:[.,][0-9])?|[0-9]{1,2}\s*[/⁄]\s*[0-9]{1,2})\s*"
    r"(?:(?:of|de|d'|precession|full|complete|a|an|one|the|einer|eine)\s+){0,3}" + _TURN
)
_MIXED = rf"(?i)(?:^|\(|([^\W\d]+)[\s_]+)([1-9][0-9]?)\s+([1-9]/[2-9])\s*(?:of\s+)?(?:an?\s+)?{_TURN}"
_FOR = ("for", "of", "für", "pour", "de", "per", "para", "por")
_ALONE = r"(?i)(?:t|T|time|Zeit|temps|tiempo|tempo|czas|время)[\s_(]*([1-9]\s*/\s*[2-9])\)?"
_ANGLE = r"(?<![0-9.,])([1-9][0-9]{1,3})\s*(?:°|º|˚|deg\b|degrees)"
_OF_THE_SPIN = r"(?i)spin|wheel|dis[ck]|rotor|ball|Kugel|Eigen|rotation propre|ротор|собств|шара"


@lru_cache(maxsize=4096)
def turns_in(header: str) -> str:
    """Find the turns that a header or a caption states in so many words: "1/3", "1", "2.5"; "" if it states none."""
    if len(header) > MAX_HEADER:
        return ""
    plain = "".join(f" {unicodedata.normalize('NFKC', c)}" if unicodedata.category(c) == "No" else c for c in header)
    if re.search(_TURN + _AND_A_HALF, plain, re.IGNORECASE):
        return ""  # no count is read of "1 tour et demi"
    if re.search(r"[0-9]", plain):
        if mixed := re.search(_MIXED, plain):
            # "Time 1 1/3 turn" may be the first of several.
            return str(int(mixed[2]) + Fraction(mixed[3])) if not mixed[1] or mixed[1].lower() in _FOR else ""
        if (match := re.search(_COUNTED, plain)) or (match := re.match(_ALONE, plain)):
            return match[1].replace(" ", "").replace(",", ".").replace("⁄", "/")
        if match := re.match(r"([1-9][0-9]?)\s*[·*×]?\s*T(?!\w)", plain):
            return match[1]  # "10T (s)"
        match = re.search(_ANGLE, plain)
        if match and (part := Fraction(int(match[1]), 360)).denominator in (1, 2, 3, 4, 6, 12):
            return str(part)
    if re.search(_TURN, plain, re.IGNORECASE):
        return words_of_turns(re.split(_TURN, plain, flags=re.IGNORECASE)[0])
    if re.search(_PERIOD, plain, re.IGNORECASE):
        said = words_of_turns(re.split(_PERIOD, plain, flags=re.IGNORECASE)[0])
        return "" if said == "1" else said
    return ""


def part_counted(header: str) -> Fraction:
    """Find the part of a turn that a column of counts counts by its header, as "half turns" or "turns (half)"; or 1."""
    inside = re.search(r"\(([^()]*)\)$", header.strip())
    said = turns_in(header) or (words_of_turns(inside[1], whole=True) if inside else "")
    part = Fraction(said) if said and not re.search(r"/0+$", said) else Fraction(1)
    return part if 0 < part < 1 else Fraction(1)


def words_of_turns(text: str, whole: bool = False) -> str:
    """Read the last words before "turn": "one third of a" is 1/3, "zwei" 2, "one and a half" 3/2; "" for no number.

    With `whole` nothing else may stand before them, as in a cell, and digits count: "5 half" is 5/2.
    """
    tokens = [token.lower() for token in _TOKENS.split(text) if token]
    while tokens and tokens[-1] in (*_FILLERS, "one", "precession") and len(tokens) > 1:
        if tokens[-1] == "one" and tokens[-2] not in ("of", "third", "thirds"):
            break
        tokens.pop()
    if whole and tokens in (["drittel"], ["tiers"]):
        return "1/3"
    part = _PARTS.get(tokens.pop(), "") if tokens else ""
    if part.startswith("/"):
        over = _PARTS.get(tokens[-1], tokens[-1]) if tokens else ""
        part = over + part if over.isdecimal() else ""
        tokens = tokens[:-1]
    if not part:
        return "1" if not whole and re.search(r"(?i)\bone(?: precession)?\s*$", text) else ""
    number = Fraction(part)
    before = list(tokens)
    while before and before[-1] in _FILLERS:
        before.pop()
    mixed = bool(before) and before[-1] in AND
    count = before[-1 - mixed] if len(before) > mixed else ""
    if mixed or count.isdecimal() or _PARTS.get(count, "").isdecimal():
        count = _PARTS.get(count, count)
        # The digit of a header may number a trial, and not count parts of a turn.
        if not count.isdecimal() or (not whole and before[-1 - mixed].isdecimal()):
            return ""
        number = number + int(count) if mixed else number * int(count)
        tokens = before[: -1 - mixed]
    return "" if whole and not set(tokens) <= set(_FILLERS) else str(number)


def counts_weights(header: Header) -> bool:
    """Tell whether a column counts the weights that hang on the rod, as "number of weights" does."""
    words = r"(?i)\b(?:weights|washers|nuts|gewichte|massestücke|poids|pesas|pesos|грузов|ciężarków)\b"
    return header.unit is None and not header.roles and bool(re.search(words, header.text))


_ORIGIN = tuple((origin, vocabulary.words(origin, "|")) for origin in ("surface", "tip"))


def origin_in(header: str) -> str:
    """Find that a position counts from the surface of the ball or from the tip of the rod; "" if it does not say so."""
    if len(header) > MAX_HEADER or re.search(r"cent(?:re|er)|mittel|Mitte|центр|środk", header, re.IGNORECASE):
        return ""
    return next((origin for origin, words in _ORIGIN if re.search(words, header, re.IGNORECASE)), "")


def clock_word(header: str) -> str:
    """Know "start (s)" and "t stop", two readings of a running clock: "start", "stop" or ""."""
    words = {squeeze(word).lower() for word in re.split(r"[\W_]+", header)}
    return "start" if words & START_WORDS else "stop" if words & END_WORDS else ""


def from_centre(header: str) -> bool:
    """Tell whether a header says that a length counts from the centre, as "x from centre" does."""
    if any(re.search(words, header, re.IGNORECASE) for _, words in _ORIGIN):
        return False
    tokens = {squeeze(token).lower() for token in re.split(r"[\W_]+", header)}
    return not tokens.isdisjoint(CENTRE_WORDS) or any(word in header for word in CENTRE_WORDS if word > "\u2e80")


def is_of_the_spin(header: str) -> bool:
    """Tell whether a header says that what is timed are turns of the ball."""
    return bool(re.search(_OF_THE_SPIN, header)) and not re.search(r"pr[äeéê][cz][eé]?[sc]|прецес", header.lower())


@lru_cache(maxsize=4096)
def parse_header(text: str) -> Header:
    """Understand one header as far as it goes by itself."""
    if len(text) > MAX_HEADER:
        return Header(text, (), None, "")
    spread, rest = "", text.translate(_WIDE_BRACKETS)
    if "±" in text or "+/-" in text or "+-" in text:
        match = re.search(_SPREAD, rest)
        if match:
            spread = f"{match[1]} {match[2].strip()}".strip()
            rest = f"{rest[: match.start()].strip()} {rest[match.end() :].strip()}".strip(" ,;")
    name, unit = split_unit(rest)
    if unit is None and spread and kinds_of(spread.partition(" ")[2]):
        unit = spread.partition(" ")[2]
    roles, index = name_roles(name)
    if not roles and unit is not None and "time" in kinds_of(unit) and (repeat := _repeat(name)):
        roles, index = ("time",), repeat
    if not roles and unit is not None and "length" in kinds_of(unit) and (origin_in(name) or from_centre(name)):
        roles = ("position",)
    if any(squeeze(token).lower() in THEORY_WORDS for token in _TOKENS.split(text)):
        roles, index = (), None  # worked out, not measured
    if unit and ":" in unit and re.fullmatch(r"[a-zA-Z:.]+", unit):
        unit = "s"  # "mm:ss.cc": how its cells are written, and they say so themselves
    if unit is not None:
        swept = kinds_of(unit) == {"angle"} and name.strip().lower() in _SWEPT
        roles = ("angle",) if swept else _fitting(roles, unit, name.strip())
    else:
        # A bare "N" counts turns: the other readings would need a unit.
        bare = tuple(role for role in roles if kind_of_role(role) in ("number", "text", "sign"))
        roles = bare or roles
    return Header(text, roles, unit, spread, index)


_SWEPT = ("rotation", "precession", "drehung", "präzession", "précession", "прецессия")
"""What is an angle where it is in degrees, and a rate else."""
_ORDINAL = r"(?:#|№|n[or]?[°º.]?)?([1-9][0-9]?)(?:st|nd|rd|th|er|re|ème|e|ª|º|[.)])?"


def _repeat(name: str) -> int | None:
    """Read "Trial 2" and "2nd measurement" above times: the number of a repeat; None if it is none."""
    tokens = [token for token in _TOKENS.split(re.sub(r"(?<=[^\W\d])(?=[0-9])", " ", name)) if token]
    numbers = [match for token in tokens if (match := re.fullmatch(_ORDINAL, token.lower()))]
    words = [token for token in tokens if not re.fullmatch(_ORDINAL, token.lower())]
    known = all(squeeze(word).lower() in TRIAL_WORDS or "time" in name_roles(word)[0] for word in words)
    return int(numbers[0][1]) if len(numbers) == 1 and known else None


def with_unit(header: Header, unit: str) -> Header:
    """Give a header the unit of the row below it."""
    roles, index = name_roles(header.text)
    return replace(header, roles=_fitting(roles, unit, header.text), unit=unit, number=index)


def _fitting(roles: tuple[str, ...], unit: str, name: str) -> tuple[str, ...]:
    """Keep the roles that the unit can measure; all of them if it fits none, so that the unit is at fault."""
    kinds = kinds_of(unit)
    if kinds == {"rate"} and roles == ("turns",):
        return ("spin",)  # "Rotations (rpm)"
    if kinds == {"force"} and roles == ("mass",):
        return ("force",)  # "Weight (N)"
    kept = tuple(role for role in roles if kind_of_role(role) in kinds or (unit == "%" and role[:2] == "u_"))
    if "time" in kinds and not kept and "/" in unit and any(role.startswith("spin") for role in roles):
        # "spin [s/rev]" is a period under another name.
        return tuple(role.replace("spin", "spin_period", 1) for role in roles if role.startswith("spin"))
    # A symbol says less than a unit: "D (s)" is not a torque.
    return kept if len(name) == 1 and kinds else kept or roles


def split_unit(text: str) -> tuple[str, str | None]:
    """Part a header into its name and its unit."""
    match = _BRACKET.fullmatch(text)
    if match:
        name, square, round_ = match.groups()
        inside = (square if square is not None else round_).strip()
        is_unit = _is_unit_of(name, inside, kinds_of(inside))
        if inside and not is_unit and all(squeeze(word).lower() in NOISE_WORDS for word in inside.split()):
            return split_unit(name)  # "RPM (measured)"
        if square is not None or is_unit or (kinds_of(inside) and not name_roles(name)[0]):
            return name.rstrip(" /,;"), inside or None
        if name_roles(text)[0] or not name_roles(name)[0]:
            return text, None  # "czas (t)": a symbol, not a unit
        return (name, inside) if inside else (name, None)
    # Before a slash U is no uncertainty: "Drehzahl U/min".
    if match := re.fullmatch(r"(.*\w)\s+(U ?/ ?(?:min|s|sec))", text):
        return match[1], match[2]
    left, _, right = text.rpartition("_")
    if any(kind_of_role(role) in kinds_of(right) for role in name_roles(left)[0]):
        return left, right  # "period_s" is not "periods"
    if name_roles(text)[0]:
        return text, None
    return _split_loose(text)


def _split_loose(text: str) -> tuple[str, str | None]:
    """Part ``m, кг``, ``t / s``, ``Zeit in s``, ``mass_g``, ``time s``; a rate unit alone is the spin's."""
    if kinds_of(text) == {"rate"} and name_roles(text.partition("/")[0].strip())[0] == ("turns",):
        return "spin", text  # "Rev/min"
    match = _IN_UNIT.fullmatch(text)
    if match and _is_unit_of(match[1], match[2], kinds_of(match[2])):
        return match[1], match[2]
    left, found, right = text.rpartition(" / ")
    if found and not name_roles(left)[0] and kinds_of(right) and not kinds_of(text):
        return left.strip(), right.strip()  # a name that is not known; its end is no part of the unit
    for separator, last in ((",", True), (";", True), ("/", False)):
        left, found, right = text.rpartition(separator) if last else text.partition(separator)
        left, right = left.strip(), right.strip()
        if found and left and right and _is_unit_of(left, right, kinds_of(right)):
            return left, right
    for left, right in _cuts(text):
        if _is_unit_of(left, right, kinds_of(right)) and right not in ("h", "t", "r", "U", "об"):
            return left, right
    if kinds_of(text) == {"rate"}:
        return "spin", text
    small = [token for token in text.split() if squeeze(token).lower() in START_WORDS | END_WORDS | NOISE_WORDS]
    rest = " ".join(token for token in text.split() if token not in small)
    if small and kinds_of(rest) == {"rate"}:
        return f"spin {' '.join(small)}", rest  # "RPM before"
    left, found, right = text.rpartition(",")
    if found and name_roles(left.strip())[0] and right.strip():
        return left.strip(), right.strip()  # an unknown unit, to be told so
    return text, None


def _cuts(text: str) -> list[tuple[str, str]]:
    """Cut at each blank and underscore, the shortest name first so that "rad s^-1" stays whole."""
    places = [m.start() for m in re.finditer(r"[\s_]", text)]
    return [(text[:i].strip(" _"), text[i:].strip(" _")) for i in places if text[:i].strip(" _")]


def _is_unit_of(name: str, unit: str, kinds: Collection[str]) -> bool:
    roles = name_roles(name)[0] or name_roles(name.rstrip(" /,;"))[0]
    if not roles and "length" in kinds and from_centre(name):
        return True
    if not roles or not (kinds or unit == "%"):
        return False
    return any(kind_of_role(role) in kinds or (unit == "%" and role[:2] == "u_") for role in roles) or bool(
        kinds and not SYMBOLS.get(squeeze(unit))
    )


@lru_cache(maxsize=4096)
def name_roles(name: str) -> tuple[tuple[str, ...], int | None]:
    """Find the roles that a name without a unit may mean, and the number of a repeat."""
    if len(name) > MAX_HEADER:
        return (), None
    roles = _plain_roles(name) or _unsure_roles(name)
    if roles:
        return roles, None
    match = _INDEX.fullmatch(name.strip())
    if match and "time" in _plain_roles(match[1]):
        return ("time",), int(match[2])
    return (), None


def _plain_roles(name: str) -> tuple[str, ...]:
    symbol = squeeze(name)
    if symbol in SYMBOLS:
        return SYMBOLS[symbol]
    lower = symbol.lower()
    if lower in NAMES:
        return NAMES[lower]
    if lower.startswith("u") and name.lower().replace(" ", "_").replace("-", "_") in UNCERTAINTIES:
        return (name.lower().replace(" ", "_").replace("-", "_"),)
    if len(lower) == 1 and lower in SYMBOLS:
        return SYMBOLS[lower]
    return _piecewise_roles(name) or _modified_roles(name)


def _piecewise_roles(name: str) -> tuple[str, ...]:
    """Read "Mass, m" and "czas (t)": a word with its symbol; what both mean is meant."""
    pieces = [piece for piece in re.split(r"[,;()]+", name) if piece.strip()]
    if len(pieces) < 2:
        return ()
    found = [_plain_roles(piece.strip()) for piece in pieces]
    common = found[0]
    for roles in found[1:]:
        if roles:
            common = tuple(role for role in common if role in roles)
    unknown = [
        piece
        for piece, roles in zip(pieces, found, strict=True)
        if not roles and squeeze(piece).lower() not in NOISE_WORDS
    ]
    return () if unknown else common


def _modified_roles(name: str) -> tuple[str, ...]:
    """Read "initial spin", "mean period", "spin before": a known name between small words."""
    tokens = [token for token in _TOKENS.split(name) if token]
    if not 2 <= len(tokens) <= 8:
        return ()
    for cut in range(1, min(3, len(tokens))):
        symbol = squeeze(" ".join(tokens[-cut:]))
        if symbol in SYMBOLS and len(symbol.removesuffix("dot")) < 4 and len(squeeze(tokens[0])) > 2:
            word = _plain_roles(" ".join(tokens[:-cut]))  # "Mass m", "Tiempo de giro inicial T Gi"
            both = tuple(role for role in word if role in SYMBOLS[symbol])
            if both:
                return both
    lower = [squeeze(token).lower() for token in tokens]
    start = any(token in START_WORDS for token in lower)
    end = any(token in END_WORDS for token in lower)
    named = [t for t, low in zip(tokens, lower, strict=True) if low not in START_WORDS | END_WORDS]
    left = [t for t in named if squeeze(t).lower() not in NOISE_WORDS]
    if not left or len(left) == len(tokens) or (start and end):
        return ()
    key = squeeze(" ".join(left))
    # Small words may belong to a name: "tiempo de giro".
    roles = SYMBOLS.get(key) or NAMES.get(key.lower()) or NAMES.get(squeeze(" ".join(named)).lower(), ())
    if not (start or end):
        return roles
    suffix = "_start" if start else "_end"
    return tuple(role + suffix for role in roles if role + suffix in ROLES)


def _unsure_roles(name: str) -> tuple[str, ...]:
    """Read "σ_M", "Δt", "u(m)", "err time" as the uncertainty of what follows."""
    bare = name.strip()
    match = re.fullmatch(r"(?:[σδΔ∆ε]|u(?=[\s_(])|s(?=\())[\s_]*\(?(.+?)\)?", bare)
    if match:
        roles = tuple(f"u_{role}" for role in _plain_roles(match[1]) if f"u_{role}" in UNCERTAINTIES)
        if bare[0] in "Δ∆":
            # Δt may be an error, or simply the time that went by; so is ΔT, and not the time of one turn.
            went_by = ("time" if role == "precession_period" else role for role in _plain_roles(match[1]))
            roles += tuple(dict.fromkeys(went_by))
        return roles
    tokens = [token for token in _TOKENS.split(bare) if token]
    left = [token for token in tokens if squeeze(token).lower() not in UNSURE_WORDS]
    if left and len(left) < len(tokens):
        roles = _plain_roles(" ".join(left))
        return tuple(f"u_{role}" for role in roles if f"u_{role}" in UNCERTAINTIES)
    return ()


def unit_for(text: str, kind: str) -> str | None:
    """Find the unit in a header whose name is not known, once ``--map`` has told what it measures."""
    for separator in (",", ";", "/", "_", " "):
        _, found, right = text.rpartition(separator)
        if found and kind in kinds_of(right.strip()):
            return right.strip()
    return None


def suggest_role(header: str) -> str:
    """Propose the role whose name a header nearly is; "" if it is near to none."""
    name, _ = split_unit(header)
    loose = re.sub(r"[\[(].*", "", name).strip()
    for key in (squeeze(loose).lower(), squeeze(re.split(r"[\s_]", loose or " ")[0]).lower()):
        close = difflib.get_close_matches(key, NAMES, n=1, cutoff=0.75) if len(key) > 2 else []
        if close:
            return NAMES[close[0]][0]
    match = _INDEX.fullmatch(loose)  # "T_P_1"
    roles = name_roles(match[1])[0] if match else ()
    return roles[0] if roles else ""
