"""Read the values that a student reports, for grading."""

from __future__ import annotations

from msgspec.structs import replace

from gyrodata.base import diagnostics
from gyrodata.quantities import notation, numerals, units
from gyrodata.quantities.notation import Quantity
from gyrodata.quantities.units import UnitError
from gyrodata.readings.lablog import Fault, Reported
from gyrodata.readings.names import reported_key

REPORTABLE = {
    "inertia": "inertia",
    "imbalance": "torque",
    "timing_bias": "time",
    "exponent": "number",
}
"""Kind of quantity of each value that can be reported."""

_LATEX = {
    "$": "",
    r"\times": "×",
    r"\cdot": "·",
    r"\pm": "±",
    r"\,": " ",
    "^{": "^",
    "}": "",
}
_FAULTS: dict[str, Fault] = {
    diagnostics.UNIT_MISSING: "no unit",
    diagnostics.UNIT_UNKNOWN: "wrong unit",
}
_LARGEST = 1e30
"""Larger values, and smaller ones than its inverse, are far from anything in a lab."""


def read_reported(
    key: str, text: str, line: int | None = None, ask: bool = True
) -> Reported:
    """Read one reported value.

    Examples are ``4.4e-3 ± 0.1e-3 kg m^2``, ``(4.4 ± 0.1) × 10⁻³ kg m²`` and ``4.4(1) g
    m^2``.
    """
    read = Reported(reported_key(key), text.strip(), line=line)
    kind = REPORTABLE[read.key]
    bare = numerals.without_name(read.text)
    for latex, sign in _LATEX.items():
        bare = bare.replace(latex, sign)
    try:
        quantity = notation.read_cell(bare, kind, None, ask)
    except UnitError as error:
        fault = _fault_of(error, bare)
        read = replace(read, fault=fault, problem=f"{_quoted(read)} {error}")
        si = None if fault == "unreadable" else _as_if_in_si(bare, kind)
        if si is None:
            return read
        quantity = si
    return _with_value(read, quantity, bare)


def _quoted(read: Reported) -> str:
    return f'"{read.text[:60]}"'


def _fault_of(error: UnitError, text: str) -> Fault:
    """Name what is wrong; an unknown unit may contain a power of ten."""
    if "is not known" in str(error):
        written = numerals.take_apart(text)
        unit = (written.unit or "") if written else ""
        if not units.kinds_of(unit.partition(" ")[0]):
            return "unreadable"
    return _FAULTS.get(error.code, "unreadable")


def _as_if_in_si(text: str, kind: str) -> Quantity | None:
    """Read the number of a text as one in SI units; None without a number."""
    written = numerals.take_apart(text)
    if written is None:
        return None
    spread_unit = "%" if written.spread_unit == "%" else None
    written = replace(written, unit=units.SI[kind], spread_unit=spread_unit)
    return notation.in_si(written, kind)


def _with_value(read: Reported, quantity: Quantity, text: str) -> Reported:
    """Return a report with its value, its uncertainty and their digits."""
    u = quantity.uncertainty and quantity.uncertainty.at(quantity.value)
    sizes = [abs(size) for size in (quantity.value, u) if size]
    if sizes and not 1 / _LARGEST <= min(sizes) <= max(sizes) <= _LARGEST:
        problem = f"{_quoted(read)} is far from anything in a lab"
        return replace(read, fault="unreadable", problem=problem)
    read = replace(
        read, value=quantity.value, u=u, step=quantity.step, u_step=quantity.u_step
    )
    written = numerals.take_apart(text)
    if written is None or quantity.step is None:
        return read  # a fraction has no digits that could be counted
    u_digits = _digits(written.spread) if written.spread else None
    return replace(read, digits=_digits(written.number), u_digits=u_digits)


def _digits(number: str) -> int:
    """Count significant digits: ``0.0044`` has as many as ``4.4e-3``.

    Zeros before the point may only fill up.
    """
    mantissa = number.lower().partition("e")[0].replace(",", ".")
    bare = mantissa.lstrip("+-")
    digits = bare.lstrip("0.")
    if "." in mantissa:
        return len(digits.replace(".", "")) or 1
    return len(digits.rstrip("0")) or 1
