"""The roles: what a column of a log can measure, one record each; and the other keys that a log can give.

A new role is one record of `TABLE` here, with its names in `vocabulary.toml`; readers, hints, fill-down and the blank
log follow it.
"""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Mapping
from functools import cache, lru_cache
from typing import Literal

from msgspec import Struct

from gyrodata import vocabulary
from gyrodata.error_sources import SOURCES
from gyrodata.units import DISPLAY, Uncertainty, fold_letters, from_si, kinds_of


class Role(Struct, frozen=True):
    """What a column can measure."""

    name: str
    kind: str
    """Kind of quantity, a key of `gyrodata.units.SI`."""
    symbols: str = ""
    """Symbols that mean this role only, parted by blanks; case matters ("m" is no "M")."""
    bound: Literal["", "above zero", "not zero", "not below zero", "below 90 degrees"] = ""
    """What its values are held to."""
    bound_hint: str = ""
    """What to type where a value is not."""
    fills_down: bool = False
    """Whether a blank cell takes the value above it, as in merged cells."""
    sample: str = ""
    """Value to propose where it is missing."""
    meaning: str = ""
    """What it is, in words."""
    instead: str = ""
    """What serves instead, for hints."""
    derived_from: tuple[tuple[str, ...], ...] = ()
    """Sets of roles; where all of one set are there, this role is only compared."""
    part: Literal["", "load", "spin", "count", "timing"] = ""
    """Which part of a run it gives: what turns the rod, how fast the ball spins, how far and how long it went."""
    u_of: str = ""
    """Role whose ``u_…`` holds for it as well, where it has none of its own."""


TABLE: tuple[Role, ...] = (
    Role(
        "mass",
        "mass",
        symbols="m",
        bound="not below zero",
        bound_hint="a weight on the counterweight side has a negative position",
        fills_down=True,
        sample="20 g",
        meaning="the added weight",
        instead=" (a torque [N*m] column, or force [N], serves instead)",
        part="load",
    ),
    Role(
        "position",
        "length",
        symbols="x X r R l L d",
        fills_down=True,
        sample="15 cm",
        meaning="from the centre of the ball to the middle of the weight",
        part="load",
    ),
    Role(
        "torque",
        "torque",
        symbols="D Γ",
        fills_down=True,
        derived_from=(("position", "mass"), ("position", "force")),
        part="load",
    ),
    Role(
        "force",
        "force",
        symbols="F",
        fills_down=True,
        part="load",
    ),
    Role(
        "spin",
        "rate",
        symbols="ω w ν f ψdot ωs ωS",
        bound="not zero",
        fills_down=True,
        sample="400 rpm",
        meaning="how fast the ball spins",
        instead=" (spin_start and spin_end, or spin_period [s], serve instead)",
        derived_from=(("spin_start", "spin_end"),),
        part="spin",
    ),
    Role("spin_start", "rate", bound="not zero", fills_down=True, sample="410 rpm", part="spin", u_of="spin"),
    Role(
        "spin_end",
        "rate",
        symbols="n2 f2",
        bound="not zero",
        fills_down=True,
        sample="390 rpm",
        part="spin",
        u_of="spin",
    ),
    Role(
        "spin_period",
        "time",
        symbols="Ts TG Tspin tR TR",
        bound="above zero",
        fills_down=True,
        derived_from=(("spin",), ("spin_start", "spin_end")),
        part="spin",
    ),
    Role(
        "spin_period_start",
        "time",
        symbols="TGi",
        bound="above zero",
        fills_down=True,
        sample="0.14 s",
        derived_from=(("spin",), ("spin_start", "spin_end")),
        part="spin",
    ),
    Role(
        "spin_period_end",
        "time",
        symbols="TGf",
        bound="above zero",
        fills_down=True,
        sample="0.16 s",
        derived_from=(("spin",), ("spin_start", "spin_end")),
        part="spin",
    ),
    Role(
        "spin_time",
        "time",
        bound="above zero",
        fills_down=True,
        sample="1.5 s",
        meaning="the time of several turns of the ball",
        derived_from=(("spin",), ("spin_start", "spin_end"), ("spin_period",)),
        part="spin",
    ),
    Role(
        "spin_turns",
        "number",
        bound="above zero",
        fills_down=True,
        sample="10",
        meaning="how many turns of the ball spin_time covers",
        derived_from=(("spin",), ("spin_start", "spin_end"), ("spin_period",)),
        part="spin",
    ),
    Role(
        "time",
        "time",
        symbols="t NT nT",
        bound="above zero",
        bound_hint="a run that was not timed is left blank",
        meaning="the stopwatch time of each run",
        instead=" (precession_period [s] or precession_rate [rad/s] serves instead)",
        part="timing",
    ),
    Role(
        "turns",
        "number",
        symbols="Noб Np NP",
        bound="above zero",
        bound_hint="write the turns that were timed, such as 1/3; if the run was not timed, put # before its line",
        fills_down=True,
        sample="1",
        meaning="how many turns each time covers",
        instead=' (or the swept angle: a column angle [deg], "# angle: 120 deg", --set angle="120 deg")',
        part="count",
        u_of="angle",
    ),
    Role(
        "angle",
        "angle",
        symbols="φ",
        bound="above zero",
        fills_down=True,
        part="count",
        u_of="turns",
    ),
    Role(
        "precession_period",
        "time",
        symbols="Tp TP TΩ",
        bound="above zero",
        derived_from=(("time", "turns"), ("time", "angle")),
        part="timing",
    ),
    Role(
        "precession_rate",
        "rate",
        symbols="Ω Ωp ΩP ωp ωP wp φdot",
        bound="not zero",
        derived_from=(("time", "turns"), ("time", "angle")),
        part="timing",
    ),
    Role(
        "pitch",
        "angle",
        bound="below 90 degrees",
    ),
    Role(
        "spin_sense",
        "sign",
    ),
    Role(
        "precession_sense",
        "sign",
    ),
    Role(
        "weight_diameter",
        "length",
        bound="above zero",
        fills_down=True,
        meaning="how wide the added weight is, across the rod",
    ),
    Role(
        "transverse_inertia",
        "inertia",
        bound="above zero",
        fills_down=True,
    ),
    Role(
        "inertia",
        "inertia",
        symbols="I J Izz Iz I0 I3 Jz",
        derived_from=((),),
    ),
    Role(
        "run",
        "text",
        symbols="№ # No Nr nr",
    ),
    Role(
        "note",
        "text",
    ),
)

SHARED_SYMBOLS = {
    "M": "torque mass",
    "n": "turns spin",
    "N": "turns spin",
    "T": "time precession_period",
    "tP": "time precession_period",
    "tp": "time precession_period",
    "τ": "precession_period torque",
    # Some number the states before and after, some the two rotations.
    "ω0": "spin_start spin",
    "w0": "spin_start spin",
    "n0": "spin_start spin",
    "f0": "spin_start spin",
    "ω1": "spin_start spin_end precession_rate",
    "w1": "spin_start spin_end precession_rate",
    "n1": "spin_start spin_end",
    "f1": "spin_start spin_end",
    "ω2": "spin_end precession_rate",
    "w2": "spin_end precession_rate",
}
"""Symbols of several roles, which a unit or the other columns tell apart."""

SHARED_NAMES = tuple(dict.fromkeys(key for section in vocabulary.LANGUAGES.values() for key in section if " " in key))
"""Roles that share names, as they are written in the vocabulary."""

BY_NAME: dict[str, Role] = {role.name: role for role in TABLE}
ROLES = tuple(BY_NAME)
FILLED_DOWN = frozenset(role.name for role in TABLE if role.fills_down)
TEXTS = frozenset(role.name for role in TABLE if role.kind == "text")
LOADS, COUNTS, TIMINGS = (
    tuple(role.name for role in TABLE if role.part == part) for part in ("load", "count", "timing")
)
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
    "ball_diameter": "length",
    "ball_mass": "mass",
    "rod_length": "length",
    "bore_diameter": "length",
    "bore_depth": "length",
    "rod_mass": "mass",
    "rod_diameter": "length",
    "disk_mass": "mass",
    "disk_diameter": "length",
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

UNCERTAINTIES = (
    *(f"u_{role.name}" for role in TABLE if role.kind not in ("sign", "text")),
    *SHARED_UNCERTAINTIES,
)
BALANCE = ("balance_tilt", "balance_drift")
MOTION = "motion"
MOTIONS = ("steady", "released")
"""How the rod was started: led along until it precesses steadily, or let go from rest."""
BALANCED = "balanced"
YES_OR_NO = dict.fromkeys(vocabulary.words("yes").split(), True) | dict.fromkeys(vocabulary.words("no").split(), False)
"""Whether the ball is balanced, in the languages of the headers."""
POSITION_FROM = "position_from"
ORIGINS = {"centre": "centre", "center": "centre", "surface": "surface", "tip": "tip"}
"""Where positions count from."""
KEYS = (*ROLES, *CONSTANTS, *UNCERTAINTIES, *BALANCE, MOTION, BALANCED, POSITION_FROM)
"""Everything that ``# key: value``, ``--set`` and ``--config`` can give."""


def kind_of_role(role: str) -> str:
    """Give the kind of quantity of a role, a constant or a ``u_…`` key (KeyError if there is none)."""
    if role in SHARED_UNCERTAINTIES:
        return SHARED_UNCERTAINTIES[role]
    base = role.removeprefix("u_")
    return CONSTANTS[base] if base in CONSTANTS else BY_NAME[base].kind


def u_keys(role: str) -> tuple[str, ...]:
    """Give the ``u_…`` that hold for a role, its own first."""
    shared = BY_NAME[role].u_of if role in BY_NAME else ""
    return (f"u_{role}", f"u_{shared}") if shared else (f"u_{role}",)


def as_u_of(role: str, key: str, u: Uncertainty) -> Uncertainty:
    """Give what a ``u_…`` key says in the unit of a role that it holds for: an angle is a share of a turn."""
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
    return {role.name for role in TABLE if role.derived_from and any(map(roles.issuperset, role.derived_from))}


@lru_cache(maxsize=8192)
def squeeze(text: str) -> str:
    """Keep the letters of a name: look-alikes folded, accents, blanks, ``_``, ``-`` and dots gone; case stays."""
    folded = fold_letters(text)
    return _bare(folded if folded.isascii() else _without_accents(folded))


def _without_accents(folded: str) -> str:
    # A dot above means a rate ("φ̇"); other accents come and go with the keyboard.
    decomposed = unicodedata.normalize("NFD", folded).replace("\u0307", "dot")
    folded = (
        "".join([c for c in decomposed if c < "\u0300" or unicodedata.category(c) != "Mn"])
        .replace("ł", "l")
        .replace("ϕ", "φ")
    )
    return folded.replace("ı", "i").replace("ß", "ss")


_MARKS = dict.fromkeys(map(ord, "_-.:'’<>|^"))


def _bare(folded: str) -> str:
    return "".join(folded.translate(_MARKS).split())


def _squeezed(text: str, delimiter: str | None = None) -> list[str]:
    """Squeeze many names at once, in lower case: this is done at every start."""
    names = _without_accents(fold_letters(text)).translate(_MARKS).lower().split(delimiter)
    return ["".join(name.split()) for name in names]


def _words(key: str) -> set[str]:
    return set(_squeezed(vocabulary.words(key)))


START_WORDS, END_WORDS, NOISE_WORDS, UNSURE_WORDS = map(_words, ("start", "end", "noise", "unsure"))
THEORY_WORDS = _words("theory")
"""Words for what was worked out and not measured."""
TRIAL_WORDS = _words("trial")
"""Words that number the repeats of one setting."""
CENTRE_WORDS = _words("centre")
"""Words for the centre of the ball."""
MEAN_WORDS = _words("mean")
SUMMARY_WORDS = MEAN_WORDS | _words("summary")
"""Words for a mean, and for all that stands below a table and is no run."""
NOT_THE_WEIGHT = _words("not_the_weight")
"""Words beside a quantity in a title that is no added weight, no place of it, and no spin that was read."""

NAMES: dict[str, tuple[str, ...]] = {}
"""Roles by squeezed lower-case name."""
for _roles in (*(role.name for role in TABLE), *SHARED_NAMES):
    for _name in filter(None, _squeezed(vocabulary.words(_roles, ","), ",")):
        NAMES.setdefault(_name, tuple(_roles.split()))
for _role in ROLES:
    NAMES[squeeze(_role).lower()] = (_role,)

SYMBOLS: dict[str, tuple[str, ...]] = {
    squeeze(symbol): (role.name,) for role in TABLE for symbol in role.symbols.split()
} | {squeeze(symbol): tuple(roles.split()) for symbol, roles in SHARED_SYMBOLS.items()}
"""Roles by squeezed symbol; case matters."""


@cache
def _all_words() -> frozenset[str]:
    """Every word that stands in headers."""
    lists = " ".join(" ".join(section.values()) for section in vocabulary.LANGUAGES.values())
    return frozenset(_squeezed(lists.replace(",", " ")))


def is_word(text: str) -> bool:
    """Tell whether a word is one that stands in headers, or a unit."""
    return squeeze(text).lower() in _all_words() or bool(kinds_of(text))


_HANGER = (
    r"(?:hanger|holder|hook|pan|carrier|Halter|Halterung|Haken|Teller|Aufhäng\w+|crochet|gancho|portapesas|крюч\w+|"
    r"подвес\w*|держател\w+)"
)
_ALTERED = (
    r"(?i)(?<!\w)(?:twice|double[ds]?|half|halved|minus|wrong\w*|"
    r"not (?:yet |been )?(?:included|subtracted|added|corrected)|"
    rf"(?:add|subtract|deduct)(?= [0-9])|(?:without|plus|excluding|excl\.?) (?:(?:the|a|an|its|weight) )?{_HANGER}|"
    r"doppelt\w*|verdoppelt|zweimal|halbe?[rns]?|hälfte|halbiert|abzüglich|falsch\w*|"
    r"(?:noch )?nicht (?:enthalten|abgezogen|mitgerechnet|mitgewogen|inbegriffen|korrigiert)|"
    rf"ohne (?:d(?:en|ie|as) )?{_HANGER}|"
    r"deux fois|moitié|faux|fausses?|(?:non|pas) (?:inclus|compris|soustrait|déduit|corrigé)e?s?|"
    rf"sans (?:le |la )?(?:support|{_HANGER})|"
    r"dobles?|dos veces|mitad|incorrect[oa]s?|equivocad[oa]s?|erróne[oa]s?|no (?:inclu\w+|restad\w+|corregid\w+)|"
    rf"sin (?:el |la )?(?:soporte|{_HANGER})|"
    rf"вдвое|удвоен\w*|дважды|в два раза|половин\w*|минус|неверн\w*|неправильн\w*|без {_HANGER}|"
    r"не (?:вычтен|учтен|учтён|включен|включён|исправлен)\w*)(?!\w)"
)
"""Words of a note that may say that a reading is not what is typed."""
_HALF = r"(?:half|halbe?[rns]?|hälfte|moitié|mitad|половин\w*)"
_USUAL = (
    rf"(?i)(?<!\w)(?:at|after|to|until|first|second|other|one|an?|zur|à la|a la|в|на) {_HALF}|{_HALF}[ -]an? \w+|"
    rf"{_HALF}[ -]?(?:\w{{1,3}} ){{0,2}}(?:turn|rev|rot|round|circle|cycle|lap|period|prec|way|time|zeit|hour|min|sec|"
    r"runs|rows|weights|readings|range|spread|width|div|small|last|least|digit|step|"
    r"Umdr|Uml|Dreh|Rund|Stund|tour|temps|périod|vuelta|tiempo|оборот|времен|период)\w*|"
    r"double[- ](?:check|click|sided|pan|beam)\w*|(?:nothing|not) wrong|(?:plus|or|/) ?minus|minus (?:side|sign|means)|"
    r"(?<!\w)(?:measur|weigh|timed|timing|check|repeat|tak|took|did|done|read(?!ing)|tr[iy]|ran|run|record|hung|spun|"
    r"releas|mesur|pes|medi|изм|взвеш)\w*(?: [\w']+){0,3} (?:twice|deux fois|dos veces|дважды|в два раза)"
    r"(?! (?:the|as|its|what|of|too|th(?:is|at)|real|true))|each twice|"
    r"twice (?:at|with|for|in|on|and|each|per|a|measured|timed|weighed|checked)(?!\w)|"
    r"(?:doppelt|zweimal) ge(?!zählt)\w+|zweimal (?:je|pro|bei)|"
    r"(?<!\w)(?:this|some|next|last|by the|the same|two|three|2|3) times?(?!\w)"
)
"""Usual in this lab: half a turn, half time, what was measured twice; and times that are no readings."""
_CORRECTED = (
    r"(?i)(?<!not )(?<!be )(?<!yet )(?<!\w)corrected|already \w+ed(?!\w)|(?<!nicht )korrigiert|"
    r"(?<!non )(?<!pas )corrigé|(?<!no )corregid|(?<!не )исправлен"
)


def altered_role(note: str) -> str:
    """Find the reading that a note says is twice, half, without or minus something; "" if it says so of none."""
    if not re.search(_ALTERED, note) or re.search(_CORRECTED, note):
        return ""
    for clause in re.split(r"[.;!?]\s", re.sub(_USUAL, "…", note)):
        for match in re.finditer(_ALTERED, clause):
            before, after = (re.findall(r"[\w/]+", part) for part in (clause[: match.start()], clause[match.end() :]))
            words = (*match[0].split(), *before[-5:], *after[:5])
            if role := next(filter(None, map(_role_of_word, words)), ""):
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
