"""Options that are quantities: a number with its unit."""

from __future__ import annotations

from gyrodata.cli.terminal import refuse
from gyrodata.errors import register

G621 = register(
    "G621",
    "error",
    "an option is not a number with a unit that fits",
    'predict tip --force 0.5N --length 20cm --inertia "4.44e-3 kg m^2" --spin 400',
)
G622 = register(
    "G622",
    "error",
    "an option's number cannot be",
    'predict tip --force 0.5N --length 20cm --inertia "-4.44e-3 kg m^2" --spin 400rpm',
)


def quantity(option: str, text: str, kind: str, *, positive: bool = False, nonzero: bool = False) -> float:
    """Read an option's number with its unit, and see that it can be.

    Parameters
    ----------
    option : str
        Its name, as typed: ``--spin``.
    text : str
        As typed.
    kind : str
        Kind of quantity, a key of `gyrodata.units.SI`.
    positive, nonzero : bool
        Refuse what is not above zero, or zero.

    Returns
    -------
    float
        [SI unit of `kind`]

    Raises
    ------
    InputError
        It cannot be read, has no unit or one that does not fit, or is a size that no lab has.
    """
    from gyrodata.quantities import parse_quantity
    from gyrodata.units import DISPLAY, LIMITS, SI, UnitError, kind_in_words

    try:
        value = parse_quantity(text, kind)
    except UnitError as error:
        message = f'{option} "{text.strip()[:40]}" has no unit' if _bare(text) else f"{option}: {error}"
        refuse(G621, message, f'write {option} "{text.strip()} {DISPLAY[kind]}"' if _bare(text) else error.hint)
    low, high = LIMITS[kind]
    if (positive and value <= 0) or (nonzero and value == 0):
        refuse(G622, f'{option} "{text.strip()[:40]}" is {_fault(value)}', f"{kind_in_words(kind)} {_need(positive)}")
    if value and not low <= abs(value) <= high:
        size = "large" if abs(value) > high else "small"
        message = f'{option} "{text.strip()[:40]}" is too {size} for {kind_in_words(kind)} in a lab'
        refuse(G622, message, f"is its unit the one written? Read are {low:g} to {high:g} {SI[kind]}")
    return value


def _bare(text: str) -> bool:
    """Tell whether it is a finite number and nothing else."""
    try:
        return abs(float(text)) < float("inf")
    except ValueError:
        return False


def _fault(value: float) -> str:
    return "below zero" if value < 0 else "zero"


def _need(positive: bool) -> str:
    return "above zero is needed" if positive else "other than zero is needed"
