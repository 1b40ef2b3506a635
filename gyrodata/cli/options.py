"""Options that several commands share, and those that are quantities: a number with its unit."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from gyrodata.cli.terminal import refuse
from gyrodata.diagnostics import OPTION_IS_NO_PAIR, OPTION_IS_NO_QUANTITY, OPTION_NUMBER_IMPOSSIBLE

PlainFormat = Literal["text", "json"]
"""Text for people or JSON for programs."""

SettingsOption = Annotated[
    list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help='A constant: --set g="9.803 m/s^2".')
]
MappingOption = Annotated[
    list[str] | None, typer.Option("--map", metavar="ROLE=HEADER", help='Name a column: --map time="T (s)".')
]
StdinOption = Annotated[
    str, typer.Option("--stdin-filename", metavar="NAME", help="Name of a log from standard input.")
]
ConfigOption = Annotated[Path | None, typer.Option("--config", help="TOML file with constants.")]


def example_of(*lines: str) -> str:
    """Write the end of a command's help, without wrapping its lines."""
    return "\b\nExample:  " + " \\\n            ".join(lines)


def pairs(given: list[str] | None, option: str) -> dict[str, str]:
    """Split KEY=VALUE options; the last of one key wins."""
    pairs: dict[str, str] = {}
    for item in given or []:
        key, equals, value = item.partition("=")
        twin = next((one for one in pairs if one != key.strip() and one.casefold() == key.strip().casefold()), None)
        if twin is not None:
            hint = f"leave one of them out: keys are written in small letters, such as {twin.lower()}"
            refuse(OPTION_IS_NO_PAIR, f"{option} has {twin} and {key.strip()}, which differ by capitals only", hint)
        if not equals or not key.strip() or not value.strip():
            example, form = ("turns=1/3", "KEY=VALUE") if option == "--set" else ('time="T (s)"', "ROLE=HEADER")
            hint = f"write both, with = between them: {option} {example}"
            refuse(OPTION_IS_NO_PAIR, f"{option} {item!r} is not of the form {form}", hint)
        pairs[key.strip()] = value.strip()
    return pairs


def with_units(items: str) -> list[str]:
    """Split "200,400,600rpm" at the commas; an item without a unit has the unit of the next that has one."""
    unit, complete = "", []
    for item in reversed([item.strip() for item in items.split(",") if item.strip()]):
        number = item.rstrip("".join(sorted({c for c in item if not c.isdigit() and c != "."})))
        unit = item[len(number) :].strip() or unit
        complete.append(f"{number} {unit}".strip())
    return complete[::-1]


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
            f'{option} "{text.strip()[:40]}" is {"below zero" if value < 0 else "zero"}',
            f"{KINDS[kind].words} {'above' if positive else 'other than'} zero is needed",
        )
    # No angle is too small: a rod may be level but for the last digit.
    if abs(value) > high or (0 < abs(value) < low and kind != "angle"):
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
