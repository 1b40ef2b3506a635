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

from gyrodata.quantities import Written, doubtful_comma, fold_number, in_si, last_place, take_apart, to_float
from gyrodata.readings.headers import name_roles
from gyrodata.units import SI, UnitError, examples, kinds_of, parse_unit

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


def read_reported(key: str, text: str, line: int | None = None, ask: bool = True) -> Reported:
    """Read one reported value: ``4.4e-3 ± 0.1e-3 kg m^2``, ``(4.4 ± 0.1) × 10⁻³ kg m²`` or ``4.4(1) g m^2``.

    Parameters
    ----------
    key : str
        What is reported, with ``reported_`` in front or without.
    text : str
        As written.
    line : int, optional
        Where it stands, 1-based.
    ask : bool
        Refuse a comma that may part thousands; if not, it is a decimal comma.

    Returns
    -------
    Reported
        Never raises: what is wrong is in `fault` and `problem`.
    """
    read = Reported(canonical_key(key), text.strip(), line=line)
    written = take_apart(read.text)
    if written is None:
        return replace(read, fault="unreadable", problem=f'"{read.text[:60]}" is not a number with its unit')
    spread = None if written.spread is None else to_float(written.spread)
    if not max(abs(written.value), abs(spread or 0.0)) <= _LARGEST:
        return replace(read, fault="unreadable", problem=f'"{read.text[:60]}" is too large for a number')
    read = replace(
        read,
        number=written.value,
        unit=written.unit and _as_written(written.unit, read.text),
        digits=None if written.step is None else _digits(written.number),
        u_digits=_digits(written.spread) if written.spread else None,
    )
    if spread is not None and spread < 0:
        return replace(read, fault="unreadable", problem="the uncertainty is negative")
    return _with_units(read, written, ask)


def _with_units(read: Reported, written: Written, ask: bool) -> Reported:
    """Bring the number and its uncertainty into SI."""
    kind = KINDS.get(read.key) or next((kind for kind in SI if kind in kinds_of(written.unit or "")), None)
    if kind is None and written.unit is not None:
        return read  # nothing that this tool knows; the text says it all
    kind = kind or "number"
    if ask and (ways := doubtful_comma(written, kind, SI[kind])):
        return replace(read, fault="unreadable", problem=f'"{read.text[:60]}" can mean {ways}')
    try:
        quantity = in_si(written, kind, SI[kind])
        factor = parse_unit(written.spread_unit or written.unit or SI[kind], kind).factor
    except UnitError as error:
        return replace(read, fault="wrong unit", problem=str(error))
    u_step = None
    if written.spread is not None and not written.percent:
        u_step = 10.0 ** last_place(written.spread) * factor
    u = None if quantity.uncertainty is None else quantity.uncertainty.at(quantity.value)
    read = replace(read, value=quantity.value, u=u, step=quantity.step, u_step=u_step)
    if written.unit is None and SI[kind]:
        problem = f'"{read.text[:60]}" has no unit: write one behind it, such as {examples(kind)}'
        return replace(read, fault="no unit", problem=problem)
    return read


def _as_written(unit: str, text: str) -> str:
    """Find how the student spelled a unit that was read in folded letters."""
    ends = [text, *re.split(r"±|\+\s?/\s?-|\+-", text)]
    return next((end[i:].strip() for end in ends for i in range(len(end)) if fold_number(end[i:]) == unit), unit)


def _digits(number: str) -> int:
    """Count significant digits, those of ``0.0044`` as of ``4.4e-3``."""
    mantissa = re.split("[eE]", number)[0]
    return len(re.sub("[^0-9]", "", mantissa).lstrip("0")) or 1
