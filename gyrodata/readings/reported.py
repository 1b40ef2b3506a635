"""Read what a student reports in a log, such as ``# reported_inertia: 4.4(1) g m^2``, for grading."""

from __future__ import annotations

import re
from typing import Literal

from msgspec import Struct
from msgspec.structs import replace

from gyrodata import diagnostics, quantities
from gyrodata.readings import roles
from gyrodata.units import SI, UnitError

KINDS = {"inertia": "inertia", "imbalance": "torque", "timing_bias": "time", "exponent": "number"}
"""Kind of quantity of each value that can be reported."""

Fault = Literal["unreadable", "no unit", "wrong unit", "given twice"]
_FAULTS: dict[str, Fault] = {diagnostics.UNIT_MISSING: "no unit", diagnostics.UNIT_UNKNOWN: "wrong unit"}


class Reported(Struct, frozen=True):
    """One value that a student reports, as far as it can be read.

    Attributes
    ----------
    key : str
        ``inertia``, ``imbalance``, ``timing_bias`` or ``exponent``.
    text : str
        As written.
    value : float or None
        [SI unit of its kind]; None if it cannot be read. If the unit is missing or wrong, the number is taken as SI.
    u : float or None
        Standard uncertainty [SI unit of its kind], after a division by a written k; None if none is written.
    digits : int or None
        Significant digits of the value; zeros at its end count only behind the decimal point.
    u_digits : int or None
        Significant digits of the uncertainty.
    step : float or None
        One step of the value's last digit [SI unit of its kind].
    u_step : float or None
        One step of the uncertainty's last digit [SI unit of its kind]; None if it is written in %.
    fault : {"unreadable", "no unit", "wrong unit", "given twice"} or None
        What is wrong, in a word.
    problem : str or None
        What is wrong, in a sentence; None exactly if `fault` is None.
    line : int or None
        Its line in its file, 1-based.
    """

    key: str
    text: str
    value: float | None = None
    u: float | None = None
    digits: int | None = None
    u_digits: int | None = None
    step: float | None = None
    u_step: float | None = None
    fault: Fault | None = None
    problem: str | None = None
    line: int | None = None


def read_reported(key: str, text: str, line: int | None = None, ask: bool = True) -> Reported:
    """Read one reported value: ``4.4e-3 ± 0.1e-3 kg m^2``, ``(4.4 ± 0.1) × 10⁻³ kg m²`` or ``4.4(1) g m^2``."""
    read = Reported(roles.reported_key(key), text.strip(), line=line)
    kind = KINDS[read.key]
    bare = re.sub(quantities.IN_FRONT, "", read.text)
    written = quantities.take_apart(bare)
    try:
        quantity = quantities.read_cell(bare, kind, None, ask)
    except UnitError as error:
        fault = _FAULTS.get(error.code, "unreadable")
        read = replace(read, fault=fault, problem=f'"{read.text[:60]}" {error}')
        if written is None or fault == "unreadable":
            return read
        spread_unit = "%" if written.spread_unit == "%" else None
        quantity = quantities.in_si(replace(written, unit=SI[kind], spread_unit=spread_unit), kind)
    u = quantity.uncertainty and quantity.uncertainty.at(quantity.value)
    if any(not 1e-30 <= abs(size) <= 1e30 for size in (quantity.value, u) if size):
        return replace(read, fault="unreadable", problem=f'"{read.text[:60]}" is far from anything in a lab')
    read = replace(read, value=quantity.value, u=u, step=quantity.step, u_step=quantity.u_step)
    if written is None or quantity.step is None:
        return read  # a fraction has no digits that could be counted
    return replace(read, digits=_digits(written.number), u_digits=written.spread and _digits(written.spread))


def _digits(number: str) -> int:
    """Count significant digits: ``0.0044`` has as many as ``4.4e-3``; zeros before the point may only fill up."""
    digits = re.sub("[^0-9.,]", "", re.split("[eE]", number)[0]).lstrip("0.,")
    return len(re.sub("[.,]", "", digits) if re.search("[.,]", number) else digits.rstrip("0")) or 1
