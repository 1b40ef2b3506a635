"""What notes say: where positions count from, and readings that are not as typed."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable, Iterator

from gyrodata.base import diagnostics
from gyrodata.quantities import numerals, vocabulary
from gyrodata.quantities.units import kinds_of
from gyrodata.readings import roles
from gyrodata.readings.grid import Grid, Row, filled_at, has_numbers, is_head
from gyrodata.readings.headers import parse_header
from gyrodata.readings.lablog import Faults, Text
from gyrodata.readings.names import (
    DIAMETER,
    FIRST_SIGN,
    LETTERS,
    NAMES,
    ORIGINS,
    ROD,
    SPHERE,
    TOKENS,
    Phrases,
    behind_from,
    exact_roles,
    fold_name,
    from_centre,
    name_roles,
    names_centre,
    origin_in,
    reported_key,
    squeeze,
    without_weight,
)
from gyrodata.readings.roles import BY_NAME
from gyrodata.readings.turns import (
    NUMBERS,
    TURN,
    separate_signs,
    turns_in,
    words_of_turns,
)

ALTERED, CORRECTED = map(Phrases, ("altered", "corrected"))
"""Words that say that a reading is not what is typed, and that it is corrected."""
_SIGNS = rf"\+(?![/-])|[2-9]\s*=\s*(?:\w+\s+)?{TURN}"
"""Signs that say the same: "position + R", "4 = full turn"."""
_AMOUNT = re.compile(rf"(?<![0-9.,]){numerals.NUMBER}\s*([^\W\d_]+|%)")
_ROLE_OF_UNIT = {
    frozenset({"mass"}): "mass",
    frozenset({"length"}): "position",
    frozenset({"time"}): "time",
    frozenset({"rate"}): "spin",
}
_TIMES = [name for name, named in NAMES.items() if "time" in named and name.isalpha()]
_HALF_TURN = (
    rf"(?i:(?:{'|'.join(map(re.escape, vocabulary.single_words('1/2')))})\W+"
    rf"(?:\w{{1,3}}\W+)?(?:{TURN}|{'|'.join(_TIMES)}))"
)
"""A number of turns, which other rules read; or "half time", the middle of a run."""


_PERIODS = tuple([name for name in NAMES if "precession_period" in NAMES[name]])
_STEMS = tuple([name[:-1] for name in _PERIODS if len(name) > 4 or name > FIRST_SIGN])
"""Names of a period without their last letter, which can be inflected."""
_A_PERIOD = re.compile("|".join(_STEMS))


_DIGITS = frozenset("23456789")


def _names_part_of_period(note: str) -> bool:
    """Return whether a note names a number of periods other than one: "pół okresu"."""
    squeezed = " ".join(map(squeeze, TOKENS.split(separate_signs(note))))
    # "halvperioder" is "halv perioder".
    spaced = _A_PERIOD.sub(r" \g<0>", squeezed)
    words = spaced.split()
    for at, word in enumerate(words):
        if not word.startswith(_STEMS):
            continue
        before = words[max(0, at - 3) : at]
        numbers = {NUMBERS.get(part, "1") for part in before}
        has_digit = not _DIGITS.isdisjoint(before[-1:])
        if not numbers <= {"1"} or (has_digit and word not in _PERIODS):
            return True
    return False


def altered_role(note: str) -> str:
    """Return the first reading that, by a note, is not what is typed; else ""."""
    return next(iter(altered_readings(note)), "")


def altered_readings(note: str) -> list[str]:
    """List the readings that may not be what is typed, because a note says so.

    Such a note contains a word such as "twice" or "hanger", or a sum. The list contains
    "readings" if the note does not name one, and is empty if it says nothing like that.
    """
    bare = re.sub(_HALF_TURN, "…", note) if ALTERED.is_in(note) else note
    is_altered = ALTERED.is_in(bare)
    if not (is_altered or turns_in(note)) and _A_PERIOD.search(fold_name(note)):
        is_altered = _names_part_of_period(bare)
    if not is_altered and not re.search(_SIGNS, bare):
        return []
    if CORRECTED.is_in(ALTERED.without(bare, "…")):
        return []
    return _named_readings(bare) or ["readings"] * is_altered


def _named_readings(note: str) -> list[str]:
    """List the readings that a note names; else the one whose amount it states."""
    words = _NAME.findall(note)
    meanings = map(_roles_of_word, words)
    named = itertools.chain.from_iterable(meanings)
    of_runs = [role for role in named if role != "torque" and BY_NAME[role].part]
    units = [unit for unit in _AMOUNT.findall(note) if unit != "%"]
    if units and not of_runs:
        of_runs = list(filter(None, [_ROLE_OF_UNIT.get(kinds_of(units[0]))]))
    return list(dict.fromkeys(of_runs))


def _roles_of_word(word: str) -> tuple[str, ...]:
    """Look up a word of a note: a name, perhaps a plural, or a unit of the spin."""
    if kinds_of(word) == {"rate"}:
        return ("spin",)
    if len(word) <= 2:
        return ()
    names = [NAMES.get(fold_name(form), ()) for form in _forms(word)]
    return next(filter(None, names), ())


_NAME = re.compile(r"[\w/]+")


def _forms(word: str) -> list[str]:
    """Return a word, and what it is without the ends of a plural or an article."""
    return [word.removesuffix(end) for end in ("", "s", "n", "es", "en", "e", "et")]


_SURFACE_NOTE = Phrases("surface_note")


def noted_origin(note: str) -> str:
    """Return the origin of positions in a note; else "".

    An example is "x is measured from the surface of the ball".
    """
    if _SURFACE_NOTE.is_in(note):
        return "" if names_centre(without_weight(note)) else "surface"
    if not any(words.is_in(note) for _, words in ORIGINS):
        return ""
    return _origin_of_position(note)


def _origin_of_position(note: str) -> str:
    """Return the origin that a note names, if it is about positions."""
    bare = without_weight(note)
    origin = origin_in(bare)
    if not origin or _explains_position(bare):
        return origin
    places = behind_from(bare)
    if not any(origin_in(words) for _, words in places):
        return ""
    start, _ = places[0]
    starts_with_from = not any(map(str.isalnum, bare[:start]))  # "* from the tip"
    is_position = starts_with_from or bare != note or _names_position(bare)
    return origin if is_position else ""


def noted_centre(note: str) -> bool:
    """Return whether a note says that positions count from the centre of the ball."""
    bare = without_weight(note)
    is_of_position = _names_position(bare) and behind_from(bare) != []
    return is_of_position and from_centre(bare)


def _explains_position(note: str) -> bool:
    """Return whether a note explains its first word: "x: from the surface of …"."""
    signs = note.replace("=", ":").replace(",", ":")
    symbol, is_explained, _ = signs.partition(":")
    name = symbol.strip(" *#(-")
    return is_explained != "" and "position" in exact_roles(name)


def _names_position(note: str) -> bool:
    """Return whether a note names the position or the weight, perhaps in the plural."""
    letters = LETTERS.findall(note)
    forms = map(_forms, letters)
    words = itertools.chain.from_iterable(forms)
    return any({"position", "mass"}.intersection(name_roles(word)[0]) for word in words)


def _calls_position_diameter(note: str) -> bool:
    """Return whether a note says such as "r is really the diameter"."""
    for clause in filter(DIAMETER.is_in, note.replace(";", ",").split(",")):
        words = LETTERS.findall(clause)
        names = any("position" in exact_roles(word) for word in words)
        if names and not (SPHERE.is_in(clause) or ROD.is_in(clause)):
            return True
    return False


def read_notes(grid: Grid, faults: Faults) -> str:
    """Return the origin of positions that a note states, or "".

    The function warns of every note that may say that a reading is not what is typed,
    such as "twice the real rpm".
    """
    notes = _notes_of(grid)
    rows = [row for row in grid.rows if any(map(_has_words, row.texts))]
    titles = [", ".join(row.texts) for row in rows if not has_numbers(row)]
    origins = map(noted_origin, [*notes, *titles])
    origin = next(filter(None, origins), "")
    if origin == "surface" and _name_centre(notes, rows):
        origin = "both"
    for note, cell in _remarks_in(rows, grid):
        notes.setdefault(note, cell)
    _warn_of_notes(notes, grid, faults)
    return origin


def _notes_of(grid: Grid) -> dict[str, Text]:
    """Return the lines behind # that give no value, with their places."""
    notes = {text.text: text for text in grid.comments}
    for key, text in grid.metadata:
        if key.lower() in roles.TEXTS or not roles.is_key(key):
            notes[f"{key}: {text.text}"] = text
    return notes


def _name_centre(notes: Iterable[str], rows: list[Row]) -> bool:
    """Return whether a note, or a row of text, names the centre as origin."""
    others = [", ".join(row.texts) for row in rows if not is_head(row)]
    return any(map(noted_centre, [*notes, *others]))


def _has_words(text: str) -> bool:
    """Return whether a text contains two words, one of them of three letters."""
    words = [word for word in text.split() if any(map(str.isalnum, word))]
    long_words = [word for word in LETTERS.findall(text) if len(word) > 2]
    # There are no blanks between words in some languages.
    return max(long_words, default="") > FIRST_SIGN or (
        len(words) > 1 and long_words != []
    )


def _warn_of_notes(notes: dict[str, Text], grid: Grid, faults: Faults) -> None:
    """Warn of notes; one on the turns of each time is answered by a line with them."""
    counts = {text.text for key, text in grid.metadata if key.lower() == "turns"}
    for note, cell in notes.items():
        named = altered_readings(note)
        if not named and _calls_position_diameter(note):
            named = ["position"]
        if not named or (named[0] in roles.TIMINGS and turns_in(note) in counts):
            continue
        faults.add("note", cell, note=note, role=_in_words(named))


def _in_words(named: list[str]) -> str:
    return " or the ".join(named).replace("_", " ")


def warn_of_unused(sentences: Iterable[Text], faults: Faults) -> None:
    """Warn of each sentence that names a reading and an amount, if nothing used it.

    If another message is about the line of a sentence, gyro used it, or asks about it
    already.
    """
    left_out = diagnostics.message("title").code
    lines = {fault.line for fault in faults.diagnostics if fault.code != left_out}
    for sentence in sentences:
        note = sentence.text
        named = _named_readings(note)
        is_used = sentence.place.line in lines or _is_understood(note)
        if named and not is_used and _has_amount(note):
            faults.add("note_not_used", sentence, note=note, role=_in_words(named))


def _is_understood(note: str) -> bool:
    """Return whether other rules read a note, or it says that readings are corrected.

    A sentence such as "I_zz = (4.40 ± 0.05)e-3 kg m^2" is the answer.
    """
    words = re.findall(r"\w{2,}", note)
    if any(reported_key(word) == "inertia" for word in words):
        return True
    is_place = from_centre(note) or noted_origin(note) != ""
    return is_place or turns_in(note) != "" or CORRECTED.is_in(note)


def _has_amount(note: str) -> bool:
    """Return whether a note contains a number with a unit, or a percentage."""
    units = _AMOUNT.findall(note)
    return any(unit == "%" or kinds_of(unit) for unit in units)


def _remarks_in(rows: list[Row], grid: Grid) -> Iterator[tuple[str, Text]]:
    """Yield the notes that are in rows, with the first cell of each."""
    for row in rows:
        is_header = is_head(row)
        places = [
            at for at, text in enumerate(row.texts) if _is_remark(text, is_header)
        ]
        if not places:
            continue
        if not is_header and not has_numbers(row):
            places = filled_at(row)  # a sentence with commas
        note = ", ".join(row.texts[at] for at in places)
        yield note, grid.cell(row, places[0])


def _is_remark(text: str, is_header: bool) -> bool:
    """Return whether a cell may be a note, and not the name of a reading.

    The header "centre to inner face (cm)" is a position, and not that of the middle of
    the weight.
    """
    if not _has_words(text):
        return False
    names = parse_header(text).roles
    if not names:
        return not is_header and not words_of_turns(text, whole=True)
    return "position" in names and ALTERED.is_in(text) and not origin_in(text)
