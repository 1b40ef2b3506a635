"""What holds for the whole log: ``# key: value`` lines, ``--set``, ``--config``; and ``--map``."""

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
from gyrodata.errors import InputError
from gyrodata.quantities import Quantity, how_to_write, parse_quantity, parse_uncertainty, take_apart, to_float
from gyrodata.readings import cells, roles
from gyrodata.readings.cells import PREFIX, CellError, Reported, read_cell
from gyrodata.readings.headers import name_roles, origin_in
from gyrodata.readings.lablog import Faults, Place, Reading, Text, listing
from gyrodata.readings.roles import KEYS, ROLES, TEXTS, kind_of_role
from gyrodata.readings.source import value_text
from gyrodata.units import Uncertainty, UnitError

_REMARKS_LOOKED_AT = 200


class Given(Struct, frozen=True):
    """One value that holds for the whole log."""

    key: str
    text: str
    label: str
    """How it was given: ``# spin``, ``--set spin``, ``--config spin``."""
    place: Place | None
    """None for an option."""
    cell: Quantity | None = None
    """The value of a role or constant."""

    def reading(self, u: Uncertainty | None) -> Reading:
        """Give it as the reading of a run; `u` holds where it does not say its own."""
        assert self.cell is not None
        return Reading(self.cell.value, self.cell.step, self.cell.uncertainty or u, self.text)


class Settings(Struct):
    """All that holds for the whole log."""

    roles: dict[str, Given] = field(default_factory=dict)
    constants: dict[str, float] = field(default_factory=dict)
    uncertainties: dict[str, Uncertainty] = field(default_factory=dict)
    given_uncertainties: dict[str, Given] = field(default_factory=dict)
    balance_tilt: tuple[float, float] | None = None
    balance_drift: tuple[float, float, float] | None = None
    motion: str | None = None
    balanced: bool | None = None
    position_from: str | None = None
    steps: dict[str, float] = field(default_factory=dict)
    """One step of the last digit of each constant [SI unit]."""
    metadata: dict[str, str] = field(default_factory=dict)
    reported: dict[str, Reported] = field(default_factory=dict)
    unread: set[str] = field(default_factory=set)
    """Roles whose value could not be read, which has been said."""


def read_options(
    settings: Mapping[str, Any], mapping: Mapping[str, str], config: str | os.PathLike[str] | None
) -> list[Given]:
    """Check the options before the log is read; give what ``--set`` and ``--config`` say."""
    faults = Faults("")
    texts = ((key.strip(), value_text(value).strip()) for key, value in settings.items())
    given = [Given(key, text, f"--set {key}", None) for key, text in texts]
    if config is not None:
        given += [Given(key, text, f"--config {key}", None) for key, text in _read_config(Path(config), faults).items()]
    known = [key for key in KEYS if key not in TEXTS]
    for item in given:
        if item.key not in known:
            hint = _close(item.key, known) or f"keys are: {', '.join(known)}"
            faults.add(codes.OPTION_KEY_UNKNOWN, f"{item.label}: there is no such key", hint)
    mapped = (*ROLES, *roles.UNCERTAINTIES)
    for role in mapping:
        if role not in mapped and not re.fullmatch(r"time_[1-9][0-9]?", role):
            hint = _close(role, mapped) or f"roles are: {listing(list(ROLES), 60)}"
            faults.add(codes.MAPPED_ROLE_UNKNOWN, f"--map {role}=…: there is no such role", hint)
    if faults.has_error():
        raise InputError(faults.found)
    return given


def _close(key: str, known: list[str] | tuple[str, ...]) -> str:
    close = difflib.get_close_matches(key.lower(), known, n=3, cutoff=0.6)
    if not close:
        close = [role for role in name_roles(key)[0] if role in known]
    return f"did you mean {' or '.join(close)}?" if close else ""


def _read_config(path: Path, faults: Faults) -> dict[str, str]:
    import tomllib

    try:
        with path.open("rb") as file:
            table = tomllib.loads(file.read(1_000_000).decode("utf-8-sig"))
    except (OSError, ValueError, RecursionError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        missing = isinstance(error, FileNotFoundError | NotADirectoryError)
        hint = "check its name" if missing else 'give a text file with lines such as g = "9.803 m/s^2"'
        message = f"--config {str(path)!r} cannot be read: {reason}"
        raise faults.refuse(codes.CONFIG_CANNOT_BE_READ, message, hint) from None
    for key, value in table.items():
        if isinstance(value, str | int | float) and not isinstance(value, bool):
            continue
        message, hint = "not a number or a text", f'write {key} = "{str(value).lower()}"'
        if isinstance(value, dict | list):
            message = f"a table or a list, {message}"
            hint = f'write one value: {key} = "{value[0] if isinstance(value, list) and value else "…"}"'
        if isinstance(value, dict):
            hint = "write its keys at the top, without a [head]; columns are named with --map role=HEADER"
        raise faults.refuse(codes.OPTION_VALUE_CANNOT_BE_READ, f"--config {key}: {message}", hint)
    return {key: str(value) for key, value in table.items()}


def read_settings(metadata: list[tuple[str, Text]], options: list[Given], faults: Faults, ask: bool) -> Settings:
    """Understand all ``# key: value`` lines and options, the later ones over the earlier.

    With `ask`, a comma that may part thousands is refused; without, the table tells that it is a decimal comma.
    """
    settings = Settings()
    seen: dict[str, Text] = {}
    remarked: list[tuple[str, Reported]] = []
    for key, text in metadata:
        known = key.lower()
        if known.startswith(PREFIX):
            _enter_reported(settings, key, text, faults, ask)
        elif (known not in KEYS or known == "inertia") and (answer := cells.find_inertia(f"{key}: {text.text}")):
            remarked.append((f"line {text.line}", cells.read_reported("inertia", answer, text.line, ask)))
            settings.metadata[key] = text.text
        elif known not in KEYS or known in TEXTS:
            settings.metadata[key] = text.text
            _warn_if_misspelt(settings, key, text, faults)
        elif (known == "time" and ":" in text.text) or not text.text:
            # The hour of the day, not a stopwatch; or a line of a template that was left blank.
            settings.metadata[key] = text.text
        elif known in seen and seen[known].text != text.text:
            message = f"{known} is given twice, in lines {seen[known].line} and {text.line}"
            faults.add(codes.KEY_GIVEN_TWICE, message, "keep one, or write it as a column", text)
        else:
            seen[known] = text
            try:
                _enter(settings, Given(known, text.text, f"# {known}", text.place), ask, faults)
            except CellError as error:
                settings.unread |= {known} & set(ROLES)
                message = f'{known} "{text.text[:60]}"{error.joint}{error}'
                faults.add(codes.KEY_VALUE_CANNOT_BE_READ, message, error.hint, text)
    # "# I_zz = …" is an answer too, where no "# reported_inertia: …" is.
    if "inertia" not in settings.reported and (one := cells.one_inertia(remarked)):
        settings.reported["inertia"] = one[1]
    for item in options:
        try:
            _enter(settings, item, True, faults)
        except CellError as error:
            bare = not error.hint and str(error).startswith("is not a number")
            hint = how_to_write(kind_of_role(item.key)) if bare else error.hint
            message = f'{item.label}: "{item.text[:60]}"{error.joint}{error}'
            raise Faults(faults.name).refuse(codes.OPTION_VALUE_CANNOT_BE_READ, message, hint) from None
    return settings


def _enter_reported(settings: Settings, key: str, text: Text, faults: Faults, ask: bool) -> None:
    """Keep a reported value; what is wrong with it is for whoever grades it, and only a note to its writer."""
    name = cells.canonical_key(key)
    before = settings.reported.get(name)
    if text.text in cells.BLANKS or (before is not None and before.text == text.text):
        return
    known = cells.REPORTED_KINDS
    if name not in known and (close := difflib.get_close_matches(name, known, n=1, cutoff=0.75)):
        message, hint = f'"# {key}" is no value that is asked for', f'did you mean "# {PREFIX}{close[0]}: {text.text}"?'
        faults.add(codes.KEY_NEARLY_KNOWN, message, hint, text)
    reported = cells.read_reported(key, text.text, text.line, ask)
    if before is not None:
        problem = f"{name} is reported twice, in lines {before.line} and {text.line}, with two values"
        reported = Reported(name, before.text, fault="given twice", problem=problem, line=before.line)
    settings.reported[name] = reported
    if reported.problem:
        hint = "write it like 4.40e-3 ± 0.05e-3 kg m^2" if name == "inertia" else ""
        faults.add(codes.REPORTED_VALUE_CANNOT_BE_READ, f"{PREFIX}{name}: {reported.problem}", hint, text)


def warn_of_lost_keys(comments: list[Text], faults: Faults) -> None:
    """Find "# spin 400 rpm", which lacks the colon and so says nothing."""
    for comment in comments:
        match = re.fullmatch(r"(\w+)\s+([-+]?[0-9].*)", comment.text)
        if match and (match[1].lower() in KEYS or match[1].lower().startswith(PREFIX)):
            message = f'"# {comment.text[:60]}" is kept as a remark; nothing is read from it'
            hint = f'did you mean "# {match[1].lower()}: {match[2][:60]}"?'
            faults.add(codes.KEY_NEARLY_KNOWN, message, hint, Place(comment.line, comment.column), len(comment.text))


def _warn_if_misspelt(settings: Settings, key: str, text: Text, faults: Faults) -> None:
    if key.lower() in TEXTS or len(key) > 30 or len(settings.metadata) > _REMARKS_LOOKED_AT:
        return
    close = _nearest(key.lower())
    if not close and text.text[:1].isdigit():
        names = (key, re.sub(r"_?[0-9]{1,2}$", "", key))  # "# m1 = 47 g"
        close = [role for name in names for role in name_roles(name)[0] if kind_of_role(role) != "text"]
    if close:
        message = f'"# {key}" is kept as a remark; nothing is read from it'
        hint = f'did you mean "# {close[0]}: {_value_at_start(close[0], text.text)}"?'
        if close[0] == "position" and (origin := origin_in(text.text)):
            hint += f' And "# position_from: {origin}"'
        faults.add(codes.KEY_NEARLY_KNOWN, message, hint, text)


def _value_at_start(role: str, text: str) -> str:
    """Give the part of "15.2 cm from centre" that is a value of a role; the whole text if no part is."""
    words = text.split() if role in ROLES and role not in TEXTS else []
    for count in range(len(words), 0, -1):
        try:
            read_cell(part := " ".join(words[:count]), kind_of_role(role), None)
        except CellError:
            continue
        return part
    return text


@lru_cache(maxsize=1024)
def _nearest(key: str) -> list[str]:
    # Kept, because a class writes the same remarks a thousand times.
    return difflib.get_close_matches(key, KEYS, n=1, cutoff=0.8) if len(key) > 2 else []


_NOWHERE = "is no place that positions count from"
_STARTS = {word: word for word in roles.MOTIONS}
_WORDS: dict[str, tuple[Mapping[str, str | bool | None], str, str]] = {
    "motion": (_STARTS, "is no way to start the rod", 'write "released" (let go from rest) or "steady"'),
    "balanced": (roles.YES_OR_NO | {"": None}, "is neither yes nor no", 'write "yes" (balanced as in step 2) or "no"'),
    "position_from": (roles.ORIGINS, _NOWHERE, 'write "centre" (of the ball), "surface" or "tip"'),
}
"""Keys of words: what each word means, and what to say to any other."""


def _enter(settings: Settings, item: Given, ask: bool, faults: Faults) -> None:
    """Understand one value and enter it."""
    key, word = item.key, item.text.strip().lower()
    if key in roles.BALANCE:
        _enter_balance(settings, item)
    elif key in _WORDS:
        words, fault, hint = _WORDS[key]
        if word not in words:
            raise CellError(fault, hint)
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
        _refuse_beyond(key, cell.value)
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
    """Read g; refuse what it is nowhere on Earth, with the line to write in its place."""
    low, high = ON_EARTH
    written = take_apart(item.text)
    bare = written is not None and not written.unit
    cell = read_cell(item.text, "acceleration", "m/s^2" if bare else None, ask)
    if low <= cell.value <= high:
        if bare:
            message = f'g "{item.text}" has no unit, and is read as {item.text} m/s²'
            hint = f"write {_line_of_g(item, f'{item.text} m/s^2')}"
            faults.add(codes.G_WITHOUT_UNIT, message, hint, item.place, len(item.text))
        return cell
    # 981 m/s^2, 9.81 cm/s^2 and 9810 have the digits of g, with another unit or without its point.
    digits = re.sub("[^0-9]", "", written.number if written else "").lstrip("0")
    meant = f"{digits[:1]}.{digits[1:]}" if digits[1:] else "0"
    known = low <= to_float(meant) <= high
    message = f"is {cell.value:.4g} m/s²; on Earth g is between {low} and {high} m/s²"
    line = _line_of_g(item, f"{meant if known else 9.81} m/s^2")
    raise CellError(message, f"write {line}" if known else f"write the value of your place, such as {line}")


def _line_of_g(item: Given, value: str) -> str:
    """Write g as it is to be typed where it was given."""
    if item.label.startswith("#"):
        return f"# g: {value}"
    return f'g = "{value}"' if item.label.startswith("--config") else f'--set g="{value}"'


def read_uncertainty(key: str, text: str, ask: bool = True) -> Uncertainty:
    """Understand what one ``u_…`` says for a whole log."""
    try:
        uncertainty = parse_uncertainty(text, kind_of_role(key), ask=ask)
    except UnitError as error:
        raise CellError(f"is no uncertainty: {error}", error.hint) from None
    if key.endswith("_scale") and uncertainty.absolute:
        raise CellError("is not a share", 'the error of a whole scale is in %, such as "0.1 %"')
    if key in OF_NOTHING and uncertainty.relative:
        raise CellError("is a share of what is not read", f'write it with its unit, such as "{OF_NOTHING[key]}"')
    return uncertainty


OF_NOTHING = {"u_time_bias": "0.1 s", "u_spin_delay": "1 s", "u_imbalance": "0.3 mN*m"}
"""Uncertainties of what is 0 for all that is known, with a sample; a share of that says nothing."""


def _read_latitude(text: str, ask: bool) -> float:
    """Read degrees, negative or with an S behind them in the south."""
    match = re.fullmatch(r"(.*[^\s])\s*([NSns])", text)
    value = read_cell(match[1] if match else text, "angle", "deg", ask).value
    if abs(value) > math.pi / 2 or (match and value < 0):
        raise CellError("is no latitude", 'write it like "52.5 deg", from -90 at the south pole to 90 deg')
    return -value if match and match[2] in "Ss" else value


def _refuse_beyond(key: str, value: float) -> None:
    fault, hint = cells.check_value(key, value)
    if fault:
        raise CellError(fault, hint)


def _enter_balance(settings: Settings, item: Given) -> None:
    drift = item.key == "balance_drift"
    pattern = r"(.+?)\s+in\s+(.+?)\s+at\s+(.+)" if drift else r"(.+?)\s+in\s+(.+)"
    sample = 'write it like "5 deg in 60 s at 400 rpm"' if drift else 'write it like "3 deg in 10 s"'
    match = re.fullmatch(pattern, item.text.strip())
    if match is None:
        raise CellError("is not understood", sample)
    try:
        numbers = tuple(map(parse_quantity, match.groups(), ("angle", "time", "rate")))
    except UnitError as error:
        raise CellError(f"is not understood: {error}", error.hint or sample) from None
    if numbers[1] <= 0 or (drift and numbers[2] == 0):
        raise CellError("needs a time and a spin above zero", sample)
    for role, number in zip(("angle", "time", "spin"), numbers, strict=False):
        if number:
            _refuse_beyond(role, abs(number))
    setattr(settings, item.key, numbers)
