"""The roles: what a column of a log can measure, one record each; and the other keys that a log can give.

A new role is one record of `TABLE` here, with its names in `vocabulary.toml`; readers, hints, fill-down and the blank
log follow it.
"""

from __future__ import annotations

import difflib
import math
import re
import unicodedata
from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import cache, lru_cache
from typing import Literal

from msgspec import Struct
from msgspec.structs import replace

from gyrodata import vocabulary
from gyrodata.error_sources import SOURCES
from gyrodata.quantities import fold_number
from gyrodata.units import DISPLAY, Uncertainty, fold_letters, from_si, kinds_of


class Role(Struct, frozen=True):
    """A quantity that a column can measure."""

    name: str
    kind: str
    """Kind of quantity, a key of `gyrodata.units.SI`."""
    part: Literal["", "load", "spin", "count", "timing"] = ""
    """Which part of a run it gives: what turns the rod, how fast the ball spins, how far and how long it went."""
    bound: Literal["", "above zero", "not zero", "not below zero", "below 90 degrees"] = ""
    """What its values must be."""
    bound_hint: str = ""
    """What to type where a value is outside the bound."""
    sample: str = ""
    """Value to propose where it is missing."""
    meaning: str = ""
    """What it is, in words."""
    instead: str = ""
    """What can replace it, for hints."""
    derived_from: tuple[str, ...] = ()
    """Sets of roles, each separated by blanks; where all of one set are there, this role is only compared."""
    u_of: str = ""
    """Role whose ``u_…`` holds for it as well, where it has none of its own."""


_LOADED = ("position mass", "position force")
_SPUN = ("spin", "spin_start spin_end")
_TIMED = ("time turns", "time angle")

TABLE: tuple[Role, ...] = (
    Role("mass", "mass", "load", "not below zero", sample="20 g", meaning="the added weight",
         bound_hint="a weight on the counterweight side has a negative position",
         instead=" (a torque [N*m] column, or force [N], serves instead)"),
    Role("position", "length", "load", sample="15 cm", meaning="from the ball's centre to the middle of the weight"),
    Role("torque", "torque", "load", derived_from=_LOADED),
    Role("force", "force", "load"),
    Role("spin", "rate", "spin", "not zero", sample="400 rpm", meaning="how fast the ball spins",
         instead=" (spin_start and spin_end, or spin_period [s], serve instead)", derived_from=_SPUN[1:]),
    Role("spin_start", "rate", "spin", "not zero", sample="410 rpm", u_of="spin"),
    Role("spin_end", "rate", "spin", "not zero", sample="390 rpm", u_of="spin"),
    Role("spin_period", "time", "spin", "above zero", derived_from=_SPUN),
    Role("spin_period_start", "time", "spin", "above zero", sample="0.14 s", derived_from=_SPUN),
    Role("spin_period_end", "time", "spin", "above zero", sample="0.16 s", derived_from=_SPUN),
    Role("spin_time", "time", "spin", "above zero", sample="1.5 s",
         meaning="the time of several turns of the ball", derived_from=(*_SPUN, "spin_period")),
    Role("spin_turns", "number", "spin", "above zero", sample="10",
         meaning="how many turns of the ball spin_time covers", derived_from=(*_SPUN, "spin_period")),
    Role("time", "time", "timing", "above zero", meaning="the stopwatch time of each run",
         bound_hint="a run that was not timed is left blank",
         instead=" (precession_period [s] or precession_rate [rad/s] serves instead)"),
    Role("turns", "number", "count", "above zero", sample="1", meaning="how many turns each time covers",
         bound_hint="write the turns that were timed, such as 1/3; if the run was not timed, put # before its line",
         instead=' (or the angle: a column angle [deg], "# angle: 120 deg", --set angle="120 deg")', u_of="angle"),
    Role("angle", "angle", "count", "above zero", u_of="turns"),
    Role("precession_period", "time", "timing", "above zero", derived_from=_TIMED),
    Role("precession_rate", "rate", "timing", "not zero", derived_from=_TIMED),
    Role("pitch", "angle", bound="below 90 degrees"),
    Role("spin_sense", "sign"),
    Role("precession_sense", "sign"),
    Role("weight_diameter", "length", bound="above zero", meaning="how wide the added weight is, across the rod"),
    Role("transverse_inertia", "inertia", bound="above zero"),
    Role("nutation_period", "time", bound="above zero", meaning="the period of the nutation"),
    Role("inertia", "inertia", derived_from=("",)),
    Role("run", "text"),
    Role("note", "text"),
)  # fmt: skip

SHARED_NAMES = tuple(dict.fromkeys(key for section in vocabulary.LANGUAGES.values() for key in section if " " in key))
"""Roles that share names, as they are written in the vocabulary."""

BY_NAME: dict[str, Role] = {role.name: role for role in TABLE}
ROLES = tuple(BY_NAME)
FILLED_DOWN = {r.name for r in TABLE if r.part in ("load", "spin", "count")} | {"weight_diameter", "transverse_inertia"}
"""Roles where a blank cell takes the value above it, as in merged cells."""
TEXTS = frozenset(role.name for role in TABLE if role.kind == "text")
LOADS, COUNTS, TIMINGS = (tuple(r.name for r in TABLE if r.part == part) for part in ("load", "count", "timing"))
"""Roles by the part of a run that they give; of several timings that are there, the first is used."""
ONE_TURN = TIMINGS[1:]
"""Timings of one whole turn, which need no count."""
SPIN_SETS = (
    ("spin",),
    ("spin_start", "spin_end"),
    ("spin_period",),
    ("spin_period_start", "spin_period_end"),
    ("spin_time", "spin_turns"),
)
"""Each of these tells a run's spin; of several that are there, the first is used."""

CONSTANTS = {
    "g": "acceleration",
    "latitude": "angle",
    **dict.fromkeys(("ball_diameter", "rod_length", "bore_diameter", "bore_depth"), "length"),
    **dict.fromkeys(("rod_diameter", "disk_diameter", "hoop_diameter"), "length"),
    **dict.fromkeys(("ball_mass", "rod_mass", "disk_mass", "hoop_mass"), "mass"),
}
"""Kinds of the constants of a log that are no role."""

SHARED_UNCERTAINTIES = {
    **{f"u_{key}": source.kind for key, source in SOURCES.items() if source.kind},
    "u_imbalance": "torque",
    "u_ball_mass": "mass",
    "u_ball_diameter": "length",
    "u_rod_length": "length",
}
"""Kinds of the uncertainties that belong to no role of their own name."""

UNCERTAINTIES = (*(f"u_{role.name}" for role in TABLE if role.kind not in ("sign", "text")), *SHARED_UNCERTAINTIES)
BALANCE = ("balance_tilt", "balance_drift")
SPIN_DOWN = "spin_down"
FALLING_MASS = "falling_mass"
TACHOMETER = "tachometer"
TACHOMETERS = ("follows", "still")
"""How the tachometer was held: it follows the rod, or it stands still."""
MOTION = "motion"
MOTIONS = ("steady", "released")
"""How the rod was started: led along until it precesses steadily, or let go from rest."""
BALANCED = "balanced"
YES_OR_NO = dict.fromkeys(vocabulary.words("yes").split(), True) | dict.fromkeys(vocabulary.words("no").split(), False)
"""Whether the ball is balanced, in the languages of the headers."""
POSITION_FROM = "position_from"
ORIGINS = {"centre": "centre", "center": "centre", "surface": "surface", "tip": "tip"}
"""Where positions count from."""
KEYS = (
    *ROLES,
    *CONSTANTS,
    *UNCERTAINTIES,
    *BALANCE,
    SPIN_DOWN,
    FALLING_MASS,
    TACHOMETER,
    MOTION,
    BALANCED,
    POSITION_FROM,
)
"""Everything that ``# key: value``, ``--set`` and ``--config`` can give."""


def kind_of_role(role: str) -> str:
    """Give the kind of quantity of a role, a constant or a ``u_…`` key (KeyError if there is none)."""
    if role in SHARED_UNCERTAINTIES:
        return SHARED_UNCERTAINTIES[role]
    base = role.removeprefix("u_")
    return CONSTANTS[base] if base in CONSTANTS else BY_NAME[base].kind


def u_keys(role: str) -> tuple[str, ...]:
    """Return the ``u_…`` keys of a role, its own first."""
    shared = BY_NAME[role].u_of if role in BY_NAME else ""
    return (f"u_{role}", f"u_{shared}") if shared else (f"u_{role}",)


def as_u_of(role: str, key: str, u: Uncertainty) -> Uncertainty:
    """Convert the uncertainty of a ``u_…`` key to the unit of a role: an angle is a share of a turn."""
    kinds = kind_of_role(role), kind_of_role(key)
    if kinds[0] == kinds[1]:
        return u
    per_turn = 1 / (2 * math.pi) if kinds[0] == "number" else 2 * math.pi
    return Uncertainty(u.absolute * per_turn, u.relative)


def stated_u(role: str, stated: Mapping[str, Uncertainty]) -> Uncertainty | None:
    """Give what a log states for every reading of a role; None if it does not."""
    return next((as_u_of(role, key, stated[key]) for key in u_keys(role) if key in stated), None)


def to_display(value: float, role: str) -> tuple[float, str]:
    """Give a value of a role in the unit it is usually shown in, with that unit (``g``, ``cm``, ``rpm``, …)."""
    kind = kind_of_role(role)
    return from_si(value, DISPLAY[kind], kind), DISPLAY[kind]


def derived_roles(roles: set[str]) -> set[str]:
    """Give the roles that are only compared, because the readings they derive from are there."""
    return {role.name for role in TABLE if any(roles.issuperset(readings.split()) for readings in role.derived_from)}


_MARKS = str.maketrans(dict.fromkeys("_-.:'’<>|^$*`\\{}", "") | {"ł": "l", "ϕ": "φ", "ı": "i", "ß": "ss"})


@lru_cache(maxsize=8192)
def squeeze(text: str) -> str:
    """Keep the letters of a name: look-alikes folded, accents, blanks, ``_``, ``-`` and dots gone; case stays."""
    # A dot above means a rate ("φ̇"); other accents come and go with the keyboard.
    letters = unicodedata.normalize("NFD", fold_letters(text)).replace("\u0307", "dot")
    return "".join("".join(c for c in letters if unicodedata.category(c) != "Mn").translate(_MARKS).split())


def squeezed_words(text: str) -> set[str]:
    """Squeeze each word of a text, in small letters."""
    return {squeeze(word).lower() for word in re.split(r"[\W_]+", text)}


def _words(key: str) -> set[str]:
    return {squeeze(word).lower() for word in vocabulary.words(key).split()}


START_WORDS, END_WORDS, NOISE_WORDS, UNSURE_WORDS = map(_words, ("start", "end", "noise", "unsure"))
THEORY_WORDS = _words("theory")
"""Words for what was worked out and not measured."""
TRIAL_WORDS = _words("trial")
"""Words that number the repeats of one setting."""
CENTRE_WORDS = _words("centre")
"""Words for the centre of the ball."""
PRECESSION = f"(?i:(?:{vocabulary.words('precession', '|')})[^\\W\\d_]*\\.?)"
MEAN_WORDS = _words("mean")
SUMMARY_WORDS = MEAN_WORDS | _words("summary")
"""Words for a mean, and for all that stands below a table and is no run."""
NOT_THE_WEIGHT = _words("not_the_weight")
"""Words beside a quantity in a title that is no added weight, no place of it, and no spin that was read."""

NAMES: dict[str, tuple[str, ...]] = {squeeze(role).lower(): (role,) for role in ROLES}
"""Roles by squeezed lower-case name."""
for _roles in (*ROLES, *SHARED_NAMES):
    for _name in vocabulary.words(_roles, ",").split(","):
        NAMES.setdefault(squeeze(_name).lower(), tuple(_roles.split()))
del NAMES[""]

SYMBOLS: dict[str, tuple[str, ...]] = {
    squeeze(symbol): tuple(roles.split()) for roles, symbols in vocabulary.SYMBOLS.items() for symbol in symbols.split()
}
"""Roles by squeezed symbol; case matters."""


@cache
def _all_words() -> frozenset[str]:
    lists = (text for section in vocabulary.LANGUAGES.values() for text in section.values())
    return frozenset(squeeze(word).lower() for word in " ".join(lists).replace(",", " ").split())


def is_word(text: str) -> bool:
    """Return whether a word is a word of headers, or a unit."""
    return squeeze(text).lower() in _all_words() or bool(kinds_of(text))


_HANGER, _HALF = (f"(?:{vocabulary.words(key, '|')})" for key in ("hanger", "half"))
_ALTERED, _USUAL, _CORRECTED = (
    rf"(?i)(?<!\w)(?:{vocabulary.words(key, '|')}){end}".replace("HANGER", _HANGER).replace("HALF", _HALF)
    for key, end in (("altered", r"(?!\w)"), ("usual", ""), ("corrected", ""))
)
"""Words of a note that say that a reading is not what is typed; what is usual in this lab; and what takes it back."""


def altered_role(note: str) -> str:
    """Find the reading that a note says is twice, half, without or minus something; "" if it says so of none."""
    for clause in re.split(r"[.;!?]\s", re.sub(_USUAL, "…", note)) if not re.search(_CORRECTED, note) else ():
        for match in re.finditer(_ALTERED, clause):
            before, after = (re.findall(r"[\w/]+", part) for part in (clause[: match.start()], clause[match.end() :]))
            for word in (*match[0].split(), *before[-5:], *after[:5]):
                if role := _role_of_word(word):
                    return role
    return ""


def _role_of_word(word: str) -> str:
    """Give the role that a word of a sentence names: "spin" of "rpm" and "Drehzahlen"; "" if it names none."""
    if kinds_of(word) == {"rate"}:
        return "spin"
    if re.fullmatch(_HANGER, word, re.IGNORECASE):
        return "mass"
    for one in (word, re.sub(r"(?:e?n|e?s)$", "", word)) if len(word) > 2 else ():
        for role in NAMES.get(squeeze(one).lower(), ()):
            if BY_NAME[role].part and role != "torque":
                return role
    return ""


MAX_HEADER = 200
"""Characters in a header that are looked at: the work on a longer one grows with their cube, and it names nothing."""


class Header(Struct, frozen=True):
    """The content of a header."""

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
_SMALL_WORDS = START_WORDS | END_WORDS | NOISE_WORDS
_AFFIXES = ((START_WORDS, "", "_start"), (END_WORDS, "", "_end"), (UNSURE_WORDS, "u_", ""))
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
    if not THEORY_WORDS.isdisjoint(squeeze(token).lower() for token in _TOKENS.split(text)):
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
    known = all(squeeze(word).lower() in TRIAL_WORDS or "time" in name_roles(word)[0] for word in words)
    return int(numbers[0]) if len(numbers) == 1 and known else None


def split_unit(text: str) -> tuple[str, str | None]:
    """Part a header into its name and its unit: "m [g]", "t / s", "Zeit in s", "mass_g"; a rate alone is the spin's."""
    if match := re.fullmatch(_BRACKET, text):
        name, square, round_ = match.groups()
        inside = (round_ if square is None else square).strip()
        is_unit = _is_unit_of(name, inside)
        if inside and not is_unit and all(squeeze(word).lower() in NOISE_WORDS for word in inside.split()):
            return split_unit(name)  # "RPM (measured)"
        words = re.split(r"[\s,;]+", inside, maxsplit=1)
        if len(words) > 1 and not kinds_of(inside) and _is_unit_of(f"{name} {words[1]}", words[0]):
            return name if name_roles(name)[0] else f"{name} {words[1]}", words[0]  # "a (cm, from centre)"
        if not is_unit and name_roles(name)[0] == ("position",) and from_centre(inside):
            return split_unit(name)  # "Position (from the centre)"
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
        return ("spin", text) if kinds_of(text) == {"rate"} else (text, None)
    small = [token for token in text.split() if squeeze(token).lower() in _SMALL_WORDS]
    rest = " ".join(token for token in text.split() if token not in small)
    is_rate = kinds_of(rest) == {"rate"}
    # The shortest name comes first, so that "rad s^-1" stays whole; before a slash U is not an uncertainty.
    parts = [
        (text[: match.start()].strip(" _/,;"), text[match.end() :].strip(" _").lstrip("/ "))
        for separator in (r"\s+(?:in|en|em|w|в)\s+", r"[\s_]+", r"[,;]", "/")
        for match in re.finditer(separator, text)
    ]
    # "时间 t/s" is a time in s, and not one in turns per second.
    for strict in (True, False):
        for name, unit in parts:
            fits = any(_measures(unit, role) for role in name_roles(name)[0])
            fits = fits or ("time" in kinds_of(unit) and bool(turns_in(name)))  # "time for 1 turn / s"
            is_name = not is_rate or name_roles(name)[0] != ("turns",)
            if (
                is_name
                and unit not in ("h", "t", "r", "U", "об")
                and (fits or (not strict and _is_unit_of(name, unit)))
            ):
                return name, unit
    if is_rate:
        return " ".join(("spin", *small)), rest  # "Rev/min", "RPM before"
    if kinds_of(text) == {"angle"}:
        return "", text
    name, _, unit = text.rpartition(" / ")
    if name and kinds_of(unit):
        return name.strip(), unit.strip()
    name, _, unit = text.rpartition(",")
    if name_roles(name)[0] and unit.strip():
        return name.strip(), unit.strip()  # an unknown unit, which is reported
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
    return SYMBOLS.get(symbol) or NAMES.get(symbol.lower()) or ((key,) if key in UNCERTAINTIES else one_letter)


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
    left = " ".join(token for token in named.split() if squeeze(token).lower() not in NOISE_WORDS)
    before, after = "".join(one for _, one, _ in affixes), "".join(one for _, _, one in affixes)
    modified = (f"{before}{role}{after}" for role in (_known(left) or _known(named) if left else ()))
    if found := tuple(role for role in modified if role in ROLES or role in UNCERTAINTIES):
        return found
    # "Period of precession" in any order of its words; "precession" alone is a name.
    bare = " ".join(word for word in left.split() if not re.fullmatch(PRECESSION, word))
    found = _known(bare) if bare not in ("", left) else ()
    return tuple(role for role in found if BY_NAME[role].part in ("count", "timing"))


def suggest_role(header: str) -> str:
    """Propose the role whose name a header nearly is; "" if it is near to none."""
    name = re.split(r"[\[(]", split_unit(header)[0])[0].strip()
    key = squeeze(name).lower()
    if len(key) > 2 and (close := difflib.get_close_matches(key, NAMES, n=1, cutoff=0.75)):
        return NAMES[close[0]][0]
    match = re.fullmatch(_INDEX, name)  # "T_P_1"
    return next(iter(name_roles(match[1])[0]), "") if match else ""


AND, _FILLERS, _PARTS = (tuple(vocabulary.words(key).split()) for key in ("and", "filler", "part"))
"""Words between two numbers of one count, "one and a half"; between a count and "turn"; and "part of" one turn."""
_NUMBERS = {squeeze(word).lower(): count for word, _, count in
            (number.partition("=") for number in vocabulary.words("number").split())}  # fmt: skip
_SIGNS = "|".join(sorted((word for word in _NUMBERS if chr(0x2E80) < word < chr(0xA000)), key=len)[::-1])
_SIGNS = f"(?<!第)(?:{_SIGNS})"
"""Numbers in languages without blanks between words."""
_TURN, _PERIOD, _ONE_TURN = (f"(?i:{vocabulary.words(key, '|')})" for key in ("turn", "period", "one_turn"))
_ONES = "|".join([*_FILLERS, *re.findall(r"(\S+)=1(?!\S)", vocabulary.words("number"))])
_AND_A_HALF = rf"(?i){_TURN}\w*\s+(?:{'|'.join(AND)})\s+(?:an?\s+)?(?:half|halbe?|demie?|medi[ao]|mezz[ao]|meia)\b"
_COUNTED = (
    r"(?i)(?<![0-9.,/第])([0-9]{1,2}(?:[.,][0-9])?|[0-9]{1,2}\s*[/⁄]\s*[0-9]{1,2})\s*"
    rf"(?:(?:{_ONES}|d'|{PRECESSION})\s*){{0,3}}{_TURN}(?!\w*/\w)"
)
_MIXED = rf"(?i)(?:^|\(|([^\W\d]+)[\s_]+)([1-9][0-9]?)\s+([1-9]/[2-9])\s*(?:of\s+)?(?:an?\s+)?{_TURN}"
_FOR = ("for", "of", "für", "pour", "de", "per", "para", "por")
_ALONE = r"(?i)(?:t|time|Zeit|temps|tiempo|tempo|czas|время)[\s_(]*([1-9]\s*/\s*[2-9])\)?"
_PERIODS = r"([1-9][0-9]?)\s*[·*×]?\s*T(?!\w)"
_ANGLE = r"(?<![0-9.,])([1-9][0-9]{1,3})\s*(?:°|º|˚|deg\b|degrees)"


@lru_cache(maxsize=4096)
def turns_in(header: str) -> str:
    """Find the turns that a header or a caption states: "1/3", "1", "2.5"; "" if it states none."""
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
    for turn in re.finditer(rf"{_TURN}(?!\w*/\w)", plain):
        if said := words_of_turns(plain[: turn.start()]):
            return said
    if re.search(_ONE_TURN, plain):
        return "1"
    said = words_of_turns(re.split(_PERIOD, plain)[0]) if re.search(_PERIOD, plain) else ""
    return "" if said == "1" else said


def is_of_turns(word: str) -> bool:
    """Return whether a word belongs to a count of turns: "full", "third", "turn", "precession"."""
    return word in _FILLERS or word in _NUMBERS or bool(re.search(f"{_TURN}|{_ONE_TURN}|{PRECESSION}", word))


def part_counted(header: str) -> Fraction:
    """Find the part of a turn that a column of counts counts by its header, as "half turns"; or 1."""
    said = turns_in(header) or words_of_turns(header)  # "turns (half)"
    return Fraction(said) if re.fullmatch("1/[2-9]|2/3|3/4", said) else Fraction(1)


def words_of_turns(text: str, whole: bool = False) -> str:
    """Read the last words before "turn": "one third of a" is 1/3, "zwei" 2, "one and a half" 3/2; "" for no number.

    With `whole` nothing else may stand before them, as in a cell, and digits count: "5 half" is 5/2.
    """
    tokens = filter(None, _TOKENS.split(re.sub(_SIGNS, r" \g<0> ", text.lower())))
    words = [word for word in tokens if word not in _FILLERS and not re.fullmatch(PRECESSION, word)]
    words = [word if re.search("[0-9]", word) else squeeze(word).lower() for word in words]
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
    if before and before[-1] in _PARTS:
        return ""
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
    # The languages of Asia join small words to others, or have no blanks.
    joined = squeeze(header)
    return not CENTRE_WORDS.isdisjoint(squeezed_words(header)) or any(w in joined for w in CENTRE_WORDS if w > "\u0590")


def clock_word(header: str) -> str:
    """Know "start (s)" and "t stop", two readings of a running clock: "start", "stop" or ""."""
    words = squeezed_words(header)
    return "start" if words & START_WORDS else "stop" if words & END_WORDS else ""


def is_of_the_spin(header: str) -> bool:
    """Tell whether a header says that what is timed are turns of the ball."""
    return bool(re.search(f"(?i){vocabulary.words('spinning', '|')}", header)) and not re.search(PRECESSION, header)
