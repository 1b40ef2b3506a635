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
    **dict.fromkeys(("rod_diameter", "disk_diameter"), "length"),
    **dict.fromkeys(("ball_mass", "rod_mass", "disk_mass"), "mass"),
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
    return {role.name for role in TABLE if any(roles.issuperset(readings.split()) for readings in role.derived_from)}


_MARKS = str.maketrans(dict.fromkeys("_-.:'’<>|^", "") | {"ł": "l", "ϕ": "φ", "ı": "i", "ß": "ss"})


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
    """Tell whether a word is one that stands in headers, or a unit."""
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
