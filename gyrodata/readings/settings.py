"""Read the values for the whole log: ``# key: value`` lines, --set and --config."""

from __future__ import annotations

import difflib
import math
import os
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import msgspec
from msgspec import Struct
from msgspec.structs import replace

from gyrodata.base.errors import InputError
from gyrodata.quantities import notation, numerals, units, vocabulary
from gyrodata.quantities.units import Uncertainty, UnitError, kinds_of
from gyrodata.readings import roles
from gyrodata.readings.lablog import (
    BLANKS,
    Faults,
    Place,
    Reading,
    Reported,
    Text,
    listing,
)
from gyrodata.readings.names import (
    behind_from,
    exact_roles,
    from_centre,
    name_roles,
    numbered,
    reported_key,
)
from gyrodata.readings.reported import REPORTABLE, read_reported
from gyrodata.readings.turns import turns_in


class Setting(Struct, frozen=True):
    """One value for the whole log."""

    key: str
    text: str
    label: str
    """How it was given: ``# spin``, ``--set spin``, ``gyro.toml: spin``."""
    place: Place | None
    """None for an option."""
    cell: notation.Quantity | None = None
    """The value of a role or constant."""

    def reading(self, u: Uncertainty | None) -> Reading:
        """Return the value as the reading of a run.

        `u` is used if it has no uncertainty of its own.
        """
        assert self.cell is not None
        u = self.cell.uncertainty or u
        return Reading(self.cell.value, self.cell.step, u, self.text)


class Settings(Struct):
    """All values for the whole log."""

    roles: dict[str, Setting] = {}
    constants: dict[str, float] = {}
    uncertainties: dict[str, Uncertainty] = {}
    uncertainty_settings: dict[str, Setting] = {}
    fields: dict[str, Any] = {}
    """Other fields of `Readings`, such as ``motion`` and ``spin_down``."""
    steps: dict[str, float] = {}
    """One step of the last digit of each constant [SI unit]."""
    metadata: dict[str, str] = {}
    reported: dict[str, Reported] = {}
    unread: set[str] = set()
    """Roles whose value could not be read; there is a fault for each."""
    origin: str = ""
    """Point from which positions count, if a note says so."""


# Options

COURSE = "course"
"""The remark of a log that a file of settings may contain too: the report shows it."""


def read_options(
    settings: Mapping[str, str],
    mapping: Mapping[str, str],
    config: str | os.PathLike[str] | None,
) -> list[Setting]:
    """Check the names of all options before the log is read.

    Return the values of ``--set`` and ``--config``.
    """
    options = [] if config is None else _read_config(config)
    for key, text in settings.items():
        options.append(Setting(key.strip(), text.strip(), f"--set {key}", None))
    faults = Faults("")
    keys = [key for key in roles.KEYS if key not in roles.TEXTS] + [COURSE]
    for item in options:
        if item.key not in keys:
            hint = _did_you_mean(item.key, keys)
            faults.add("option_unknown", what=item.label, hint=hint)
    mapped = [*roles.ROLES, *roles.UNCERTAINTIES]
    for role in mapping:
        if role not in mapped and not _is_repeat(role):
            hint = _did_you_mean(role, mapped)
            faults.add("mapped_role_unknown", what=f"--map {role}=…", hint=hint)
    if faults.has_error():
        raise InputError(faults.diagnostics)
    return options


def _is_repeat(role: str) -> bool:
    """Return whether a role is that of a repeat: time_1 to time_99."""
    number = role.removeprefix("time_")
    return number != role and number.isdecimal() and 0 < int(number) < 100


def _read_config(path: str | os.PathLike[str]) -> list[Setting]:
    """Read a TOML file of settings."""
    try:
        with Path(path).open("rb") as file:
            text = file.read(1_000_000).decode("utf-8-sig")
        table = msgspec.toml.decode(text, type=dict[str, str | int | float | bool])
    except (OSError, ValueError, RecursionError) as error:
        why = getattr(error, "strerror", None) or error
        raise Faults("").refuse("config", path=str(path), why=why) from None
    name = Path(path).name
    words = {True: "yes", False: "no"}
    options = []
    for key, value in table.items():
        written = words[value] if isinstance(value, bool) else str(value)
        options.append(Setting(key, written, f"{name}: {key}", None))
    return options


def _did_you_mean(name: str, known: list[str]) -> str:
    close = difflib.get_close_matches(name.lower(), known, n=3, cutoff=0.6)
    roles_of_name, _ = name_roles(name)
    close = close or [role for role in roles_of_name if role in known]
    if close:
        return f"did you mean {' or '.join(close)}?"
    return f"known are: {listing(known, 99)}"


# Lines of the log


def read_settings(
    metadata: Sequence[tuple[str, Text]],
    comments: Sequence[Text],
    options: Sequence[Setting],
    faults: Faults,
    ask: bool,
) -> Settings:
    """Read all ``# key: value`` lines and options.

    Lines replace the values of a file, and ``--set`` replaces both.

    With `ask`, a comma that may separate thousands is an error; without, it is a
    decimal comma as in the table.
    """
    lines = _Lines(Settings(), faults, ask)
    for key, text in metadata:
        lines.take(key, text)
    for comment in comments:
        # "# spin 400 rpm" without a colon; also with a unit such as "g m^2"
        key, _, value = comment.text.partition(" ")
        units_of_value = value.split()[1:]
        is_short = len(units_of_value) < 2 or units_of_value[1:] in (["m^2"], ["m²"])
        if is_short and value.strip().lstrip("+-")[:1].isdecimal():
            _warn_of_remark(key, value.strip(), comment, faults)
    remarks = lines.settings.metadata.items()
    remarks_with_text = {key.lower() for key, text in remarks if text}
    in_log = {*lines.texts, *(remarks_with_text & {COURSE})}
    for item in options:
        # The log itself knows its lab better than the file of the bench.
        if item.key not in in_log or item.label.startswith("--set"):
            _enter(lines.settings, item, True, faults)
    return lines.settings


class _Lines:
    """The lines of a log, read one after the other."""

    def __init__(self, settings: Settings, faults: Faults, ask: bool) -> None:
        self.settings = settings
        self.faults = faults
        self.ask = ask
        self.texts: dict[str, Text] = {}
        """First text of each key."""

    def take(self, key: str, text: Text) -> None:
        """Read one line: a report, an answer, a value or a remark."""
        known = key.lower()
        if _is_report(key, text.text):
            self.report(key, text)
        elif known in roles.KEYS and not _is_remark(known, text.text):
            self.enter(known, text)
        elif known != "station" or not self.is_other(known, text):
            self.settings.metadata[key] = text.text
            is_short = len(key) <= 30 and len(self.settings.metadata) < 200
            if text.text and known not in roles.KEYS and is_short:
                _warn_of_remark(key, text.text, text, self.faults)

    def enter(self, key: str, text: Text) -> None:
        """Enter the value of a key; ask if it is given twice."""
        if key == "spin_down":
            self.texts.setdefault(key, text)
        elif self.is_other(key, text):
            return
        setting = Setting(key, text.text, f"# {key}", text.place)
        _enter(self.settings, setting, self.ask, self.faults)

    def is_other(self, key: str, text: Text) -> bool:
        """Return whether a key already has another text; if so, ask which is right."""
        first = self.texts.setdefault(key, text)
        if first.text == text.text:
            return False
        lines = {"first": first.place.line, "second": text.place.line}
        self.faults.add("key_given_twice", text, key=key, **lines)
        return True

    def report(self, key: str, text: Text) -> None:
        """Keep a reported value.

        A fault in it is only a note for its writer, because it is graded elsewhere.
        """
        name = reported_key(key)
        before = self.settings.reported.get(name)
        is_repeated = before is not None and before.text == text.text
        if text.text in BLANKS or is_repeated:
            return
        read = read_reported(key, text.text, text.place.line, self.ask)
        if before is not None:
            lines = f"lines {before.line} and {text.place.line}"
            problem = f"{before.key} is reported twice, in {lines}, with two values"
            read = Reported(before.key, before.text, line=before.line)
            read = replace(read, fault="given twice", problem=problem)
        self.settings.reported[name] = read
        if read.problem:
            self.faults.add("reported_value", text, name=name, problem=read.problem)


def _is_report(key: str, text: str) -> bool:
    """Return whether a line is "# reported_…: …", or gives I_zz.

    "I = 3" may be a current, and "I_zz: see the report" is not an answer.
    """
    if key.lower().startswith(roles.REPORTED):
        return reported_key(key) in REPORTABLE
    if reported_key(key) != "inertia":
        return False
    read = read_reported(key, text)
    return read.fault is None or (len(key) > 1 and read.value is not None)


def _is_remark(key: str, text: str) -> bool:
    """Return whether a line with a known key is blank, a sentence or a time of day."""
    if not text or key in roles.TEXTS or (key == "time" and ":" in text):
        return True
    has_number = any(map(str.isdigit, text))
    return key in roles.ROLES and len(text.split()) > 3 and not has_number


_KNOWN = (*roles.KEYS, *(f"{roles.REPORTED}{name}" for name in REPORTABLE))


def _readings_named(key: str) -> list[str]:
    """Return the readings that a key names, perhaps with a number: "m1"."""
    stem, _ = numbered(key)
    named = name_roles(key)[0] if "_" in key else exact_roles(stem)
    return [role for role in named if roles.kind_of_role(role) != "text"]


def _warn_of_remark(key: str, value: str, text: Text, faults: Faults) -> None:
    """Warn of a remark that is nearly a ``# key: value`` line.

    Examples are "# u_positon: 1 mm" and "# m1 = 47 g".
    """
    # The nearest key has the same first letter, and is nearly the same.
    small = key.lower()
    known = [other for other in _KNOWN if other[0] == small[0] and len(key) > 2]
    close = difflib.get_close_matches(small, known, n=1, cutoff=0.8)
    if not close and value[:1].isdigit():
        close = _readings_named(key)
    if not close or turns_in(f"{key} {value}"):  # "# timed 2 turns each run"
        return
    written = key if text.text == value else text.text
    if close[0] in roles.ROLES:
        # Of "14.8 cm from centre" the value is meant.
        words = value.split()
        is_bare = numerals.PLAIN.fullmatch(words[0]) is not None
        if words[0][-1:].isalnum():
            value = " ".join(words[: 1 + is_bare])
    faults.add("remark", text, written=written, meant=f"{close[0]}: {value}")


# Values

YES_OR_NO: dict[str, bool | None] = {"": None}
YES_OR_NO |= dict.fromkeys(vocabulary.single_words("yes"), True)
YES_OR_NO |= dict.fromkeys(vocabulary.single_words("no"), False)
ON_EARTH = 9.7, 9.9
"""g [m/s^2] is between these in every lab: 9.76 on the highest mountains, 9.83 at the
poles."""
OF_NOTHING = {"u_time_bias": "0.1 s", "u_spin_delay": "1 s", "u_imbalance": "0.3 mN*m"}
"""Uncertainties of quantities with the expected value 0, with a sample: they cannot be
a share."""
_MOST_RISE = 1.02
"""A spin may seem to rise by this factor because of its rounding."""


def _enter(settings: Settings, item: Setting, ask: bool, faults: Faults) -> None:
    """Enter one value; an option that cannot be read is refused at once."""
    try:
        _read_value(settings, item, ask, faults)
    except UnitError as error:
        hint = error.hint or notation.how_to_write(roles.kind_of_role(item.key))
        values = {"label": item.label, "text": item.text, "error": error, "hint": hint}
        if item.place is None:
            raise Faults(faults.name).refuse("option_value", **values) from None
        settings.unread |= {item.key} & set(roles.ROLES)
        faults.add("key_value", item.place, **values)


def _read_value(settings: Settings, item: Setting, ask: bool, faults: Faults) -> None:
    """Read the value of a key, by what kind of key it is."""
    key = item.key
    text = item.text.strip()
    line = vocabulary.LINES.get(key, {})
    if key == COURSE:
        settings.metadata[key] = text
    elif key == "spin_down":
        # Several lines are several falls.
        parts = filter(None, map(str.strip, text.split(";")))
        falls = [_read_several(key, part) for part in parts]
        settings.fields[key] = (*settings.fields.get(key, ()), *falls)
    elif "sample" in line:
        settings.fields[key] = _read_several(key, text)
    elif line:
        _enter_word(settings, key, text, line)
    elif key in roles.UNCERTAINTIES:
        settings.uncertainties[key] = _read_uncertainty(key, text, ask)
        settings.uncertainty_settings[key] = item
    elif key == "latitude":
        settings.constants[key] = _read_latitude(text, ask)
    elif key in roles.CONSTANTS:
        _enter_constant(settings, item, text, ask, faults)
    else:
        cell = _read_role(key, text, ask)
        settings.roles[key] = replace(item, cell=cell)


OF_REPORT = ("question_numbers", "worksheet")
"""Keys that change the report only."""


def _enter_word(
    settings: Settings, key: str, text: str, line: Mapping[str, Any]
) -> None:
    words = line.get("words") or YES_OR_NO
    if text.lower() not in words:
        raise UnitError("is none of the words that can be read here", line["hint"])
    value = words[text.lower()]
    if key in OF_REPORT:
        settings.metadata[key] = "yes" if value else "no"
    else:
        settings.fields[key] = value


def _read_uncertainty(key: str, text: str, ask: bool) -> Uncertainty:
    try:
        u = notation.parse_uncertainty(text, roles.kind_of_role(key), doubt_comma=ask)
    except UnitError as error:
        raise UnitError(f"is not an uncertainty: {error}", error.hint) from None
    if key.endswith("_scale") and u.absolute:
        hint = 'the error of a whole scale is in %, such as "0.1 %"'
        raise UnitError("is not a share", hint)
    if key in OF_NOTHING and u.relative:
        hint = f'write it with its unit: "{OF_NOTHING[key]}"'
        raise UnitError("is a share of what is not read", hint)
    return u


def _read_latitude(text: str, ask: bool) -> float:
    """Read a latitude [rad]: "52.5 deg"; it is negative in the south."""
    value = notation.read_cell(text, "angle", "deg", ask).value
    if abs(value) > math.pi / 2:
        raise UnitError("is not a latitude", 'write it like "52.5 deg"')
    return value


def _enter_constant(
    settings: Settings, item: Setting, text: str, ask: bool, faults: Faults
) -> None:
    """Enter a constant with its digits; g is in m/s² if it has no unit."""
    key = item.key
    written = numerals.take_apart(text) if key == "g" else None
    bare = written is not None and not written.unit
    unit = "m/s^2" if bare else None
    cell = notation.read_cell(text, roles.kind_of_role(key), unit, ask)
    low, high, sample = _USUAL.get(key, (0.0, math.inf, ""))
    if not (low <= cell.value <= high and cell.value > 0):
        raise _unusual(key, cell.value, low, high, sample)
    _check(key, cell.value)
    if bare:
        faults.add("g_without_unit", item.place, text=item.text)
    settings.constants[key] = cell.value
    settings.steps[key] = cell.step or 0.0
    if cell.uncertainty is not None:
        settings.uncertainties.setdefault(f"u_{key}", cell.uncertainty)


_USUAL = {
    "g": (*ON_EARTH, "9.81 m/s^2"),
    "ball_mass": (0.02, 200.0, "4.3 kg"),
    "ball_diameter": (0.01, 0.5, "101.6 mm"),
}
"""Ranges of constants [SI unit], with a sample; other values are errors."""


def _unusual(key: str, value: float, low: float, high: float, sample: str) -> UnitError:
    """Return the error for a value of g, or for a ball, that no lab has."""
    if not sample:
        return UnitError("is not above zero")
    unit = units.SI[roles.kind_of_role(key)]
    likely = [value * factor for factor in (1000, 0.001)]
    fitting = [other for other in likely if low <= other <= high]
    if fitting:
        sample = f"{fitting[0]:.6g} {unit}"
    fault = f"is {value:.4g} {unit}; usual are {low:g} to {high:g} {unit}"
    return UnitError(fault, f'write its unit, such as "# {key}: {sample}"')


def _read_role(key: str, text: str, ask: bool) -> notation.Quantity:
    """Read one reading that is valid for all runs."""
    if key == "position" and from_centre(text):
        start, _ = [*behind_from(text), (len(text), "")][0]
        text = text[:start].strip()
    if key in roles.COUNTS and numerals.take_apart(text) is None:
        text = turns_in(f"{text} turns") or text  # "three", "one third"
    cell = notation.read_cell(text, roles.kind_of_role(key), None, ask)
    _check(key, cell.value)
    return cell


def _check(role: str, value: float) -> None:
    fault, hint = roles.check_value(role, value)
    if fault:
        raise UnitError(fault, hint)


# Lines of several quantities


def form_of(key: str) -> tuple[str, list[str]]:
    """Return how a line of several quantities is written, and their kinds.

    The text has {} in the place of each quantity.
    """
    sample = vocabulary.LINES[key]["sample"]
    form = sample
    kinds: list[str] = []
    for number, unit in pairwise(sample.replace(",", "").split()):
        if numerals.PLAIN.fullmatch(number):
            form = form.replace(f"{number} {unit}", "{}", 1)
            kinds.extend(kinds_of(unit))
    return form, kinds


def _read_several(key: str, text: str) -> tuple[float, ...]:
    """Read the quantities of one line [SI], such as angle, time and spin of a drift."""
    if key == "falling_mass" and "friction" not in text:
        text += ", friction 0 g"
    form, kinds = form_of(key)
    hint = f'write it like "{vocabulary.LINES[key]["sample"]}"'
    parts: list[str] = []
    rest = " ".join(text.split())
    for separator in form.strip("{}").split("{}"):
        part, _, rest = rest.partition(separator)
        parts.append(part)
    parts.append(rest)
    if not all(parts):
        raise UnitError("is not understood", hint)
    try:
        numbers = tuple(map(notation.parse_quantity, parts, kinds))
    except UnitError as error:
        raise UnitError(f"is not understood: {error}", error.hint or hint) from None
    if key == "falling_mass":
        _check_falling_mass(numbers, hint)
        return numbers
    for kind, number in zip(kinds, numbers, strict=True):
        _check_in_line(kind, number, hint)
    return _fall(numbers) if key == "spin_down" else numbers


def _check_falling_mass(numbers: tuple[float, ...], hint: str) -> None:
    mass, *others, friction = numbers
    is_possible = min(mass, *others) > 0 and 0 <= friction < mass
    if not is_possible:
        raise UnitError("contains a value that is impossible", hint)


def _check_in_line(kind: str, number: float, hint: str) -> None:
    role = "spin" if kind == "rate" else kind
    if kind == "angle" and number == 0:
        return
    size = number if kind == "time" else abs(number)
    fault, _ = roles.check_value(role, size)
    if fault:
        raise UnitError(fault, hint)


def _fall(numbers: tuple[float, ...]) -> tuple[float, float, float]:
    """Return the spin at the start and at the end of a fall, and its time."""
    start = abs(numbers[0])
    end = abs(numbers[1])
    seconds = numbers[2]
    if end > _MOST_RISE * start:
        hint = "exchange start and end if they are swapped"
        raise UnitError("says that the spin rises", hint)
    return start, end, seconds
