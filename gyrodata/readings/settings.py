"""Values for the whole log: ``# key: value`` lines, ``--set``, ``--config``; and ``--map``."""

from __future__ import annotations

import difflib
import math
import os
import re
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from msgspec import Struct, field
from msgspec.structs import replace

from gyrodata import diagnostics as codes
from gyrodata import quantities
from gyrodata.errors import InputError
from gyrodata.quantities import CellError, Quantity, read_cell
from gyrodata.readings import lablog, roles
from gyrodata.readings.lablog import Faults, Place, Reading, Text, listing
from gyrodata.readings.roles import TEXTS, kind_of_role
from gyrodata.readings.source import value_text
from gyrodata.readings.spin_down import Fall, read_spin_down
from gyrodata.units import Uncertainty, UnitError

_REMARKS_LOOKED_AT = 200
_REPORTED = tuple(f"{lablog.PREFIX}{name}" for name in lablog.REPORTED_KINDS)


class Given(Struct, frozen=True):
    """One value for the whole log."""

    key: str
    text: str
    label: str
    """How it was given: ``# spin``, ``--set spin``, ``--config spin``."""
    place: Place | None
    """None for an option."""
    cell: Quantity | None = None
    """The value of a role or constant."""

    def reading(self, u: Uncertainty | None) -> Reading:
        """Return it as the reading of a run; `u` is used if it has no uncertainty of its own."""
        assert self.cell is not None
        return Reading(self.cell.value, self.cell.step, self.cell.uncertainty or u, self.text)


class Settings(Struct):
    """All values for the whole log."""

    roles: dict[str, Given] = field(default_factory=dict)
    constants: dict[str, float] = field(default_factory=dict)
    uncertainties: dict[str, Uncertainty] = field(default_factory=dict)
    given_uncertainties: dict[str, Given] = field(default_factory=dict)
    balance_tilt: tuple[float, ...] | None = None
    balance_drift: tuple[float, ...] | None = None
    spin_down: tuple[Fall, ...] = ()
    falling_mass: tuple[float, ...] = ()
    tachometer: str | None = None
    motion: str | None = None
    balanced: bool | None = None
    position_from: str | None = None
    steps: dict[str, float] = field(default_factory=dict)
    """One step of the last digit of each constant [SI unit]."""
    metadata: dict[str, str] = field(default_factory=dict)
    reported: dict[str, lablog.Reported] = field(default_factory=dict)
    unread: set[str] = field(default_factory=set)
    """Roles whose value could not be read, which has been said."""


def read_options(
    settings: Mapping[str, Any], mapping: Mapping[str, str], config: str | os.PathLike[str] | None
) -> list[Given]:
    """Check the options before the log is read; give what ``--set`` and ``--config`` say."""
    faults = Faults("")
    given = [Given(key.strip(), value_text(value).strip(), f"--set {key}", None) for key, value in settings.items()]
    table = {} if config is None else _read_config(Path(config), faults)
    given += [Given(key, text, f"--config {key}", None) for key, text in table.items()]
    keys = [key for key in roles.KEYS if key not in TEXTS]
    mapped = [*roles.ROLES, *roles.UNCERTAINTIES]
    names = [(codes.OPTION_KEY_UNKNOWN, f"{item.label}: there is no such key", item.key, keys) for item in given]
    names += [(codes.MAPPED_ROLE_UNKNOWN, f"--map {role}=…: there is no such role", role, mapped) for role in mapping]
    for code, message, name, known in names:
        if name in known or (known is mapped and re.fullmatch(r"time_[1-9][0-9]?", name)):
            continue
        close = difflib.get_close_matches(name.lower(), known, n=3, cutoff=0.6)
        close = close or [role for role in roles.name_roles(name)[0] if role in known]
        faults.add(
            code, message, f"did you mean {' or '.join(close)}?" if close else f"known are: {listing(known, 99)}"
        )
    if faults.has_error():
        raise InputError(faults.found)
    return given


def _read_config(path: Path, faults: Faults) -> dict[str, str]:
    import tomllib

    try:
        with path.open("rb") as file:
            table = tomllib.loads(file.read(1_000_000).decode("utf-8-sig"))
    except (OSError, ValueError, RecursionError) as error:
        message = f"--config {str(path)!r} cannot be read: {getattr(error, 'strerror', None) or error}"
        hint = 'check its name; it is a text file with lines such as g = "9.803 m/s^2"'
        raise faults.refuse(codes.CONFIG_CANNOT_BE_READ, message, hint) from None
    for key, value in table.items():
        if not isinstance(value, str | int | float) or isinstance(value, bool):
            one = value[0] if isinstance(value, list) and value else "…" if isinstance(value, dict) else value
            hint = f'write one value in quotes at the top, without a [head]: {key} = "{str(one).lower()}"'
            message = f"--config {key}: this is neither a number nor a text"
            raise faults.refuse(codes.OPTION_VALUE_CANNOT_BE_READ, message, hint)
    return {key: str(value) for key, value in table.items()}


def read_settings(metadata: list[tuple[str, Text]], options: list[Given], faults: Faults, ask: bool) -> Settings:
    """Understand all ``# key: value`` lines and options, the later ones over the earlier.

    With `ask`, a comma that may part thousands is refused; without, the table tells that it is a decimal comma.
    """
    settings = Settings()
    seen: dict[str, Text] = {}
    answers: list[tuple[str, Text]] = []
    for key, text in metadata:
        known = key.lower()
        if known == "ball_radius":
            known, text = "ball_diameter", replace(text, text=f"2 x {text.text}")
        reported, (name, _, value) = lablog.canonical_key(key), text.text.partition("=")
        if known.startswith(lablog.PREFIX) and reported in lablog.REPORTED_KINDS:
            _enter_reported(settings, key, text, faults, ask)
        elif reported == "inertia":
            answers.append((key, text))
        elif known not in roles.KEYS and lablog.canonical_key(name.strip()) == "inertia":
            answers.append((name.strip(), replace(text, text=value.strip())))  # "# Result: I_zz = …"
        elif known not in roles.KEYS or known in TEXTS:
            settings.metadata[key] = text.text
            _warn_if_misspelt(settings, key, text, faults)
        elif (known == "time" and ":" in text.text) or not text.text:
            # The hour of the day, not a stopwatch; or a line of a template that was left blank.
            settings.metadata[key] = text.text
        elif known in seen and seen[known].text != text.text and known != roles.SPIN_DOWN:
            message = f"{known} is given twice, in lines {seen[known].line} and {text.line}"
            faults.add(codes.KEY_GIVEN_TWICE, message, "keep one, or write it as a column", text)
        else:
            seen[known] = text
            _enter(settings, Given(known, text.text, f"# {known}", text.place), ask, faults)
    # "# I_zz = …" is an answer too, if no "# reported_inertia: …" is.
    for key, text in answers if "inertia" not in settings.reported else ():
        read = lablog.read_reported(key, text.text)
        # "I = 3" may be a current, and "I_zz: see the report" is no answer.
        if read.fault is None or (len(key) > 1 and read.value is not None):
            _enter_reported(settings, key, text, faults, ask)
        else:
            settings.metadata[key] = text.text
    for item in options:
        _enter(settings, item, True, faults)
    return settings


def _enter_reported(settings: Settings, key: str, text: Text, faults: Faults, ask: bool) -> None:
    """Keep a reported value; what is wrong with it is for whoever grades it, and only a note to its writer."""
    name = lablog.canonical_key(key)
    before = settings.reported.get(name)
    if text.text in lablog.BLANKS or (before is not None and before.text == text.text):
        return
    reported = lablog.read_reported(key, text.text, text.line, ask)
    if before is not None:
        problem = f"{name} is reported twice, in lines {before.line} and {text.line}, with two values"
        reported = lablog.Reported(name, before.text, fault="given twice", problem=problem, line=before.line)
    settings.reported[name] = reported
    if reported.problem:
        hint = "write value, uncertainty and unit; I_zz like 4.40e-3 ± 0.05e-3 kg m^2"
        message = f"{lablog.PREFIX}{name}: {reported.problem}"
        faults.add(codes.REPORTED_VALUE_CANNOT_BE_READ, message, hint, text)


def _add_remark(written: str, meant: str, text: Text, faults: Faults) -> None:
    message = f'"# {written[:60]}" is kept as a remark; nothing is read from it'
    faults.add(codes.KEY_NEARLY_KNOWN, message, f'did you mean "# {meant[:90]}"?', text)


def warn_of_lost_keys(comments: list[Text], faults: Faults) -> None:
    """Find "# spin 400 rpm", which lacks the colon and so says nothing."""
    for comment in comments:
        match = re.fullmatch(r"(\w+)\s+([-+]?[0-9].*)", comment.text)
        if match and match[1].lower() in (*roles.KEYS, *_REPORTED):
            _add_remark(comment.text, f"{match[1].lower()}: {match[2]}", comment, faults)


def _warn_if_misspelt(settings: Settings, key: str, text: Text, faults: Faults) -> None:
    if key.lower() in TEXTS or len(key) > 30 or len(settings.metadata) > _REMARKS_LOOKED_AT:
        return
    close = _nearest(key.lower())
    if not close and text.text[:1].isdigit():
        names = (key, re.sub(r"_?[0-9]{1,2}$", "", key))  # "# m1 = 47 g"
        close = [role for name in names for role in roles.name_roles(name)[0] if kind_of_role(role) != "text"]
    if close:
        # Of "14.8 cm from centre" the value is meant.
        value = re.match(rf"{quantities.NUMBER}\s*\S*", text.text) if close[0] in roles.ROLES else None
        _add_remark(key, f"{close[0]}: {value[0] if value else text.text}", text, faults)


@lru_cache(maxsize=1024)
def _nearest(key: str) -> list[str]:
    # Kept, because a class writes the same remarks a thousand times.
    return difflib.get_close_matches(key, (*roles.KEYS, *_REPORTED), n=1, cutoff=0.8) if len(key) > 2 else []


_WORDS: dict[str, tuple[Mapping[str, str | bool | None], str]] = {
    "tachometer": (
        {word: word for word in roles.TACHOMETERS},
        'write "follows" (it was turned with the rod) or "still" (it was held in one place)',
    ),
    "motion": ({word: word for word in roles.MOTIONS}, 'write "released" (let go from rest) or "steady"'),
    "balanced": (roles.YES_OR_NO | {"": None}, 'write "yes" (balanced as in step 2) or "no"'),
    "position_from": (roles.ORIGINS, 'write "centre" (of the ball), "surface" or "tip"'),
}
"""Keys of words: what each word means, and what to say to any other."""


def _enter(settings: Settings, item: Given, ask: bool, faults: Faults) -> None:
    """Enter one value; an option that cannot be read is refused at once."""
    try:
        _understand(settings, item, ask, faults)
    except CellError as error:
        message = f'{item.label}: "{item.text[:60]}" {error}'
        hint = error.hint or quantities.how_to_write(kind_of_role(item.key))
        if item.place is None:
            raise Faults(faults.name).refuse(codes.OPTION_VALUE_CANNOT_BE_READ, message, hint) from None
        settings.unread |= {item.key} & set(roles.ROLES)
        faults.add(codes.KEY_VALUE_CANNOT_BE_READ, message, hint, item.place, len(item.text))


def _understand(settings: Settings, item: Given, ask: bool, faults: Faults) -> None:
    key, word = item.key, item.text.strip().lower()
    if key in roles.BALANCE:
        setattr(settings, key, _read_balance(item))
    elif key == roles.SPIN_DOWN:
        # Several lines are several falls.
        settings.spin_down = (*settings.spin_down, *read_spin_down(item.text))
    elif key == roles.FALLING_MASS:
        settings.falling_mass = _read_falling_mass(item)
    elif key in _WORDS:
        words, hint = _WORDS[key]
        if word not in words:
            raise CellError("is none of the words that can be read here", hint)
        setattr(settings, key, words[word])
    elif key in roles.UNCERTAINTIES:
        settings.uncertainties[key] = read_uncertainty(key, item.text, ask)
        settings.given_uncertainties[key] = item
    elif key == "latitude":
        settings.constants[key] = _read_latitude(item.text.strip(), ask)
    else:
        cell = _read_g(item, ask, faults) if key == "g" else read_cell(item.text, kind_of_role(key), None, ask)
        if key in roles.CONSTANTS and not cell.value > 0:
            raise CellError("is not above zero")
        fault, hint = lablog.check_value(key, cell.value)
        if fault:
            raise CellError(fault, hint)
        if key not in roles.CONSTANTS:
            settings.roles[key] = replace(item, cell=cell)
            return
        settings.constants[key] = cell.value
        settings.steps[key] = cell.step or 0.0
        if cell.uncertainty is not None:
            settings.uncertainties.setdefault(f"u_{key}", cell.uncertainty)


ON_EARTH = 9.7, 9.9
"""g [m/s^2] is between these at every place where a lab can be: 9.76 on the highest mountains, 9.83 at the poles."""


def _read_g(item: Given, ask: bool, faults: Faults) -> Quantity:
    """Read g, in m/s² if it has no unit; refuse what it is nowhere on Earth."""
    written = quantities.take_apart(item.text)
    bare = written is not None and not written.unit
    cell = read_cell(item.text, "acceleration", "m/s^2" if bare else None, ask)
    low, high = ON_EARTH
    if not low <= cell.value <= high:
        message = f"is {cell.value:.4g} m/s²; on Earth g is between {low} and {high} m/s²"
        raise CellError(message, 'write the value of your place with its unit, such as "9.81 m/s^2"')
    if bare:
        message = f'g "{item.text}" has no unit, and is read as {item.text} m/s²'
        faults.add(codes.G_WITHOUT_UNIT, message, f'write "{item.text} m/s^2"', item.place, len(item.text))
    return cell


OF_NOTHING = {"u_time_bias": "0.1 s", "u_spin_delay": "1 s", "u_imbalance": "0.3 mN*m"}
"""Uncertainties of what is 0 for all that is known, with a sample; a share of that says nothing."""


def read_uncertainty(key: str, text: str, ask: bool = True) -> Uncertainty:
    """Understand what one ``u_…`` says for a whole log."""
    try:
        uncertainty = quantities.parse_uncertainty(text, kind_of_role(key), ask=ask)
    except UnitError as error:
        raise CellError(f"is not an uncertainty: {error}", error.hint) from None
    if key.endswith("_scale") and uncertainty.absolute:
        raise CellError("is not a share", 'the error of a whole scale is in %, such as "0.1 %"')
    if key in OF_NOTHING and uncertainty.relative:
        raise CellError("is a share of what is not read", f'write it with its unit, such as "{OF_NOTHING[key]}"')
    return uncertainty


def _read_latitude(text: str, ask: bool) -> float:
    """Read degrees, negative or with an S behind them in the south."""
    match = re.fullmatch(r"(.*[^\s])\s*([NSns])", text)
    value = read_cell(match[1] if match else text, "angle", "deg", ask).value
    if abs(value) > math.pi / 2 or (match and value < 0):
        raise CellError("is not a latitude", 'write it like "52.5 deg", from -90 at the south pole to 90 deg')
    return -value if match and match[2] in "Ss" else value


_BALANCE = {
    "balance_tilt": (r"(.+?)\s+in\s+(.+)", "3 deg in 10 s"),
    "balance_drift": (r"(.+?)\s+in\s+(.+?)\s+at\s+(.+)", "5 deg in 60 s at 400 rpm"),
}
"""How the tests of the balance are written, with a sample."""


def _read_falling_mass(item: Given) -> tuple[float, ...]:
    """Read mass [kg], radius [m], height [m], time [s], and the mass that balances the friction [kg]."""
    match = re.fullmatch(r"(.+?) at (.+?), (.+?) in (.+?)(?:, friction (.+))?", item.text.strip())
    hint = 'write it like "50 g at 25 mm, 80 cm in 7.5 s, friction 5 g"'
    if match is None:
        raise CellError("is not understood", hint)
    texts = [text or "0 g" for text in match.groups()]
    try:
        numbers = tuple(map(quantities.parse_quantity, texts, ("mass", "length", "length", "time", "mass")))
    except UnitError as error:
        raise CellError(f"is not understood: {error}", error.hint or hint) from None
    if min(numbers[:4]) <= 0 or not 0 <= numbers[4] < numbers[0]:
        raise CellError("contains a value that is impossible", hint)
    return numbers


def _read_balance(item: Given) -> tuple[float, ...]:
    """Read an angle, the time in which it was turned, and of a drift the spin [rad, s, rad/s]."""
    pattern, sample = _BALANCE[item.key]
    match, hint = re.fullmatch(pattern, item.text.strip()), f'write it like "{sample}"'
    if match is None:
        raise CellError("is not understood", hint)
    try:
        numbers = tuple(map(quantities.parse_quantity, match.groups(), ("angle", "time", "rate")))
    except UnitError as error:
        raise CellError(f"is not understood: {error}", error.hint or hint) from None
    for role, number in zip(("angle", "time", "spin"), numbers, strict=False):
        fault, _ = lablog.check_value(role, number if role == "time" or number == 0 else abs(number))
        if fault and (number or role != "angle"):
            raise CellError(fault, hint)
    return numbers
