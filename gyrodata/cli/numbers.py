"""Options that are quantities: a number with its unit."""

from __future__ import annotations

from gyrodata.cli.terminal import refuse
from gyrodata.diagnostics import OPTION_IS_NO_QUANTITY, OPTION_NUMBER_IMPOSSIBLE


def quantity(option: str, text: str, kind: str, *, positive: bool = False, nonzero: bool = False) -> float:
    """Read an option's number with its unit, in the SI unit of its kind, and refuse what no lab has."""
    from gyrodata.quantities import parse_quantity
    from gyrodata.units import DISPLAY, KINDS, LIMITS, SI, UnitError

    try:
        value = parse_quantity(text, kind)
    except UnitError as error:
        message = f'{option} "{text.strip()[:40]}" has no unit' if _bare(text) else f"{option}: {error}"
        refuse(
            OPTION_IS_NO_QUANTITY,
            message,
            f'write {option} "{text.strip()} {DISPLAY[kind]}"' if _bare(text) else error.hint,
        )
    low, high = LIMITS[kind]
    if (positive and value <= 0) or (nonzero and value == 0):
        refuse(
            OPTION_NUMBER_IMPOSSIBLE,
            f'{option} "{text.strip()[:40]}" is {_fault(value)}',
            f"{KINDS[kind].words} {_need(positive)}",
        )
    if value and not low <= abs(value) <= high:
        size = "large" if abs(value) > high else "small"
        message = f'{option} "{text.strip()[:40]}" is too {size} for {KINDS[kind].words} in a lab'
        refuse(
            OPTION_NUMBER_IMPOSSIBLE, message, f"is its unit the one written? Read are {low:g} to {high:g} {SI[kind]}"
        )
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
