"""Remarks that say that a reading is not what is typed."""

from __future__ import annotations

import re

from gyrodata.quantities import vocabulary
from gyrodata.quantities.units import kinds_of
from gyrodata.readings.names import NAMES, squeeze
from gyrodata.readings.roles import BY_NAME

_HANGER, _HALF = (f"(?:{vocabulary.words(key, '|')})" for key in ("hanger", "half"))
_ALTERED, _USUAL, CORRECTED = (
    rf"(?i)(?<!\w)(?:{vocabulary.words(key, '|')}){end}".replace(
        "HANGER", _HANGER
    ).replace("HALF", _HALF)
    for key, end in (("altered", r"(?!\w)"), ("usual", ""), ("corrected", ""))
)
"""Patterns of a note that says that a reading is not what is typed; of usual notes; and
of notes that correct it."""
ALTERED = {
    role: vocabulary.pattern(f"altered_{role}")
    for role in ("spin", "turns", "mass", "position")
}
"""Patterns of notes that say this of one role, in words that do not name it."""


def altered_role(note: str) -> str:
    """Find the reading that a note says is twice, half, without or minus something.

    "" if there is none.
    """
    if re.search(CORRECTED, note):
        return ""
    for role, words in ALTERED.items():
        if re.search(words, note):
            return role
    if not re.search(_ALTERED, note):
        return ""
    for clause in re.split(r"[.;!?]\s", re.sub(_USUAL, "…", note)):
        if not re.search(_ALTERED, clause):
            continue
        for word in re.findall(r"[\w/]+", clause):
            for role in _roles_of_word(word):
                if BY_NAME[role].part and role != "torque":
                    return role
    return ""


def _roles_of_word(word: str) -> tuple[str, ...]:
    """Look up a word of a note: a name, perhaps in the plural, a unit, or a hanger."""
    if re.fullmatch(_HANGER, word, re.IGNORECASE):
        return ("mass",)
    if kinds_of(word) == {"rate"}:
        return ("spin",)
    if len(word) <= 2:
        return ()
    singular = re.sub(r"e?[ns]$", "", word)
    named = NAMES.get(squeeze(word).lower())
    return named or NAMES.get(squeeze(singular).lower(), ())
