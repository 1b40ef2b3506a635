"""What a student reports: ``# reported_inertia: 4.4e-3 ± 0.1e-3 kg m^2``, read for whoever grades it.

A reported value is an answer, not a reading. A malformed one is no fault of the log: what is wrong with it is kept
beside what can still be read of it.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Literal

from gyrodata.errors import register
from gyrodata.readings.headers import name_roles
from gyrodata.units import SI, UnitError, examples, fold_letters, kinds_of, parse_unit

G308 = register(
    "G308",
    "note",
    "a reported value that cannot be read as it stands",
    "# reported_inertia: 4.4e-3\nmass [g],position [cm],spin [rpm],time [s],turns\n20,15.0,406,13.06,1/3\n",
)

PREFIX = "reported_"
KINDS: Mapping[str, str] = MappingProxyType(
    {"inertia": "inertia", "imbalance": "torque", "timing_bias": "time", "exponent": "number"}
)
"""Kind of quantity of what a lab's report usually states; of anything else, the unit written tells it."""

Fault = Literal["unreadable", "no unit", "wrong unit", "given twice"]


@dataclass(frozen=True, slots=True)
class Reported:
    """One value that a student reports, as far as it can be read.

    Attributes
    ----------
    key : str
        What it is: ``inertia``, ``imbalance``, …
    text : str
        As written.
    value : float or None
        [SI unit of its kind]; where no unit is written, the number taken as SI. None where the number or its unit
        cannot be read.
    u : float or None
        Its standard uncertainty [SI unit of its kind], that is what is stated divided by a k written behind it; None
        where none is stated.
    number : float or None
        The number as written, before any unit.
    unit : str or None
        As written; None where there is none.
    digits : int or None
        Significant digits of the value, zeros at its end included.
    u_digits : int or None
        Those of the uncertainty.
    step : float or None
        One step of the value's last digit [SI unit of its kind].
    u_step : float or None
        One step of the uncertainty's last digit [SI unit of its kind]; None where it is stated in %.
    fault : {"unreadable", "no unit", "wrong unit", "given twice"} or None
        What is wrong, in a word.
    problem : str or None
        What is wrong, in a sentence; None exactly where `fault` is.
    line : int or None
        Where it stands in its file, 1-based.
    """

    key: str
    text: str
    value: float | None = None
    u: float | None = None
    number: float | None = None
    unit: str | None = None
    digits: int | None = None
    u_digits: int | None = None
    step: float | None = None
    u_step: float | None = None
    fault: Fault | None = None
    problem: str | None = None
    line: int | None = None


_NUMBER = r"[-+]?(?:[0-9]+(?:[.,][0-9]*)?|[.,][0-9]+)(?:[eE][-+]?[0-9]{1,3})?"
_UNIT = r"(?:1/)?[^\d\s.,;:+±()%\-][^±;%]*?"
_PLUS_MINUS = re.compile(rf"({_NUMBER})\s*({_UNIT})?\s*±\s*({_NUMBER})\s*(%|{_UNIT})?")
_IN_BRACKETS = re.compile(rf"\(\s*({_NUMBER})\s*±\s*({_NUMBER})\s*\)\s*(e[-+]?[0-9]{{1,3}})?\s*(%|{_UNIT})?")
_CONCISE = re.compile(rf"({_NUMBER})\(({_NUMBER})\)(e[-+]?[0-9]{{1,3}})?\s*({_UNIT})?")
_ALONE = re.compile(rf"({_NUMBER})\s*({_UNIT})?")
_MINUS = str.maketrans({"−": "-", "–": "-", "‐": "-", "‑": "-"})
_SIGN_PAIR = re.compile(r"\+\s?/\s?-|\+-|\\pm")
_POWER_OF_TEN = re.compile(
    r"\s*(?:[×x*·⋅∙]\s*10\s*(?:\^|\*\*)?|(?<=[\s)])10\s*(?:\^|\*\*))\s*[({]?([-+]?[0-9]{1,3})[)}]?(?![0-9.,])"
)
_SHARED_POWER = re.compile(rf"({_NUMBER})\s*±\s*({_NUMBER})(?=\s*[×x*·⋅∙]\s*10)")
_NAME = re.compile(r"^[^\W\d][\w ]{0,30}=\s*")
_COVERAGE = re.compile(r"\s*[(,;]?\s*k\s*=\s*([1-9](?:[.,][0-9]+)?)\s*\)?$")
_UNIT_IN_BRACKETS = re.compile(r"(?<=[\d\s)])[\[(]\s*([^\W\d][^()\[\]±]*?)\s*[\])]$")
_LONGEST = 200
_LARGEST = 1e100


def canonical_key(key: str) -> str:
    """Name what is reported: ``reported_I_zz`` and ``reported_moment_of_inertia`` are ``inertia``.

    Parameters
    ----------
    key : str
        As written, with ``reported_`` in front or without.
    """
    bare = key[len(PREFIX) :] if key.lower().startswith(PREFIX) else key
    if name_roles(bare)[0] == ("inertia",) or name_roles(bare.replace("_", " "))[0] == ("inertia",):
        return "inertia"
    return bare.lower()


def read_reported(key: str, text: str, line: int | None = None) -> Reported:
    """Read one reported value: ``4.4e-3 ± 0.1e-3 kg m^2``, ``(4.4 ± 0.1) × 10⁻³ kg m²`` or ``4.4(1) g m^2``.

    Parameters
    ----------
    key : str
        What is reported, with ``reported_`` in front or without.
    text : str
        As written.
    line : int, optional
        Where it stands, 1-based.

    Returns
    -------
    Reported
        Never raises: what is wrong is in `fault` and `problem`.
    """
    read = Reported(canonical_key(key), text.strip(), line=line)
    coverage = _COVERAGE.search(read.text[:_LONGEST])
    parts = _parts(read.text[: coverage.start()] if coverage else read.text)
    if parts is None:
        return replace(read, fault="unreadable", problem=f'"{read.text[:60]}" is not a number with its unit')
    number, spread, unit, spread_unit = parts
    value, u = _float(number), _float(spread) if spread else None
    if not max(abs(value), abs(u or 0.0)) <= _LARGEST:
        return replace(read, fault="unreadable", problem=f'"{read.text[:60]}" is too large for a number')
    read = replace(
        read,
        number=value,
        unit=unit and _as_written(unit, read.text),
        digits=_digits(number),
        u_digits=_digits(spread) if spread else None,
    )
    if u is not None and u < 0:
        return replace(read, fault="unreadable", problem="the uncertainty is negative")
    read = _with_units(read, number, spread, unit, spread_unit)
    if coverage and read.u is not None:
        read = replace(read, u=read.u / _float(coverage[1]))
    return read


def _with_units(read: Reported, number: str, spread: str | None, unit: str | None, spread_unit: str | None) -> Reported:
    """Bring the number and its uncertainty into SI."""
    assert read.number is not None
    kind = KINDS.get(read.key) or next((kind for kind in SI if kind in kinds_of(unit or "")), None)
    if kind is None and unit is not None:
        return read  # nothing that this tool knows; the text says it all
    kind = kind or "number"
    try:
        factor = _factor(unit, kind)
        u_factor = factor if spread_unit in (None, "%", unit) else _factor(spread_unit, kind)
    except UnitError as error:
        return replace(read, fault="wrong unit", problem=str(error))
    u = u_step = None
    if spread is not None and spread_unit == "%":
        u = abs(read.number) * _float(spread) / 100 * factor
    elif spread is not None:
        u, u_step = _float(spread) * u_factor, _step(spread) * u_factor
    read = replace(read, value=read.number * factor, u=u, step=_step(number) * factor, u_step=u_step)
    if unit is None and SI[kind]:
        problem = f'"{read.text[:60]}" has no unit: write one behind it, such as {examples(kind)}'
        return replace(read, fault="no unit", problem=problem)
    return read


def _factor(unit: str | None, kind: str) -> float:
    return 1.0 if unit is None else parse_unit(unit, kind).factor


def _parts(text: str) -> tuple[str, str | None, str | None, str | None] | None:
    """Take a text apart: number, uncertainty, unit, and the uncertainty's own unit or %."""
    if len(text) > _LONGEST:
        return None
    plain = _SIGN_PAIR.sub("±", _folded(text))
    plain = _UNIT_IN_BRACKETS.sub(r" \1", _NAME.sub("", plain, count=1))
    # "4.4 ± 0.1 × 10^-3" means that power of both.
    plain = _POWER_OF_TEN.sub(r"e\1", _SHARED_POWER.sub(r"(\1 ± \2)", plain, count=1))
    match = _IN_BRACKETS.fullmatch(plain)
    if match:
        number, spread, power, unit = match.groups()
        return _scaled(number, power), _scaled(spread, power), None if unit == "%" else unit, None
    match = _PLUS_MINUS.fullmatch(plain)
    if match:
        number, first, spread, last = match.groups()
        return number, spread, first or (None if last == "%" else last), last
    match = _CONCISE.fullmatch(plain)
    if match:
        number, spread, power, unit = match.groups()
        number = _scaled(number, power)
        # A whole number in the bracket counts in the last digits.
        spread = f"{spread}e{_last_place(number)}" if spread.isdigit() else _scaled(spread, power)
        return number, spread, unit, None
    match = _ALONE.fullmatch(plain)
    return (match[1], None, match[2], None) if match else None


def _folded(text: str) -> str:
    return fold_letters(text).translate(_MINUS).strip()


def _as_written(unit: str, text: str) -> str:
    """Find how the student spelled a unit that was read in folded letters."""
    ends = [text, *re.split(r"±|\+\s?/\s?-|\+-", text)]
    return next((end[i:].strip() for end in ends for i in range(len(end)) if _folded(end[i:]) == unit), unit)


def _scaled(number: str, power: str | None) -> str:
    """Give a number the power of ten that stands behind its bracket."""
    return f"{number}{power}" if power and "e" not in number.lower() else number


def _float(number: str) -> float:
    return float(number.replace(",", "."))


def _digits(number: str) -> int:
    """Count significant digits, those of ``0.0044`` as of ``4.4e-3``."""
    mantissa = re.split("[eE]", number)[0]
    return len(re.sub("[^0-9]", "", mantissa).lstrip("0")) or 1


def _step(number: str) -> float:
    """Give the size of one step of the last digit."""
    return float(f"1e{_last_place(number)}")


def _last_place(number: str) -> int:
    """Give the power of ten of the last digit."""
    mantissa, _, exponent = number.lower().replace(",", ".").partition("e")
    return int(exponent or 0) - len(mantissa.partition(".")[2])
