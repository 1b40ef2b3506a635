"""Numbers as text, rounded to their uncertainty (two digits) by the `uncertainties` package."""

from __future__ import annotations

import math


def number_text(value: float, u: float | None, factor: float = 1.0) -> str:
    """Write a value rounded to its uncertainty: "4.44 ± 0.06".

    Parameters
    ----------
    value : float
        In its SI unit.
    u : float or None
        Standard uncertainty, same unit; None or 0 gives the value alone with four digits.
    factor : float
        Divide both by this first: 1e-3 for milli.

    Returns
    -------
    str
        u with two significant digits, the value to the same place (GUM 7.2.6).
    """
    if u is None or u == 0 or not math.isfinite(u):
        return f"{value / factor:.4g}"
    from uncertainties import ufloat

    return f"{ufloat(value / factor, u / factor):.2uP}".replace("±", " ± ").replace("×", " × ")


def power_of_ten(value: float) -> tuple[float, str]:
    """Find the power of ten that leaves one digit before the point, and write it.

    Parameters
    ----------
    value : float
        Any.

    Returns
    -------
    tuple of float and str
        (1e-3, "10⁻³"); (1.0, "") for values from 1 to 10 and for 0.
    """
    exponent = math.floor(math.log10(abs(value))) if value else 0
    if exponent == 0:
        return 1.0, ""
    digits = str(exponent).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return 10.0**exponent, f"10{digits}"


def inertia_text(value: float, u: float | None) -> str:
    """Write a moment of inertia: "(4.44 ± 0.06) × 10⁻³ kg·m²".

    Parameters
    ----------
    value, u : float
        [kg*m^2]

    Returns
    -------
    str
    """
    factor, power = power_of_ten(max(value, u or 0.0, key=abs))
    number = number_text(value, u, factor)
    if not power:
        return f"{number} kg·m²"
    return f"({number}) × {power} kg·m²" if "±" in number else f"{number} × {power} kg·m²"


def interval_text(low: float, high: float, factor: float = 1.0) -> str:
    """Write an interval with as many digits as its half-width needs: "4.32 to 4.56".

    Parameters
    ----------
    low, high : float
        Ends, in the SI unit.
    factor : float
        Divide both by this first.

    Returns
    -------
    str
    """
    low, high = low / factor, high / factor
    width = (high - low) / 2
    places = max(0, 1 - math.floor(math.log10(width))) if width > 0 else 4
    return f"{low:.{places}f} to {high:.{places}f}"


def torque_text(value: float, u: float | None = None) -> str:
    """Write a torque in mN·m.

    Parameters
    ----------
    value, u : float
        [N*m]

    Returns
    -------
    str
    """
    return f"{number_text(value, u, 1e-3)} mN·m"


def percent_text(value: float) -> str:
    """Write a relative size in per cent, signed, two digits: "+0.03 %".

    Parameters
    ----------
    value : float
        [1]

    Returns
    -------
    str
    """
    percent = 100 * value
    if percent == 0:
        return "0 %"
    if abs(percent) < 0.001:
        return "< 0.001 %"
    return f"{percent:+.2g} %" if abs(percent) < 100 else f"{percent:+.0f} %"


def p_text(p: float) -> str:
    """Write a probability: "p = 0.32", "p < 0.0001".

    Parameters
    ----------
    p : float
        From 0 to 1.

    Returns
    -------
    str
    """
    return "p < 0.0001" if p < 1e-4 else f"p = {p:.2g}"


def count_text(count: int, noun: str) -> str:
    """Write a count with its noun: "1 run", "9 runs".

    Parameters
    ----------
    count : int
        How many.
    noun : str
        Singular.

    Returns
    -------
    str
    """
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
