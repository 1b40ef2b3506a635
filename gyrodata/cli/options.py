"""Options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from gyrodata.cli.terminal import refuse
from gyrodata.diagnostics import OPTION_IS_NO_PAIR

PlainFormat = Literal["text", "json"]
"""Text for people or JSON for programs."""

SettingsOption = Annotated[
    list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help='A constant: --set g="9.803 m/s^2".')
]
MappingOption = Annotated[
    list[str] | None, typer.Option("--map", metavar="ROLE=HEADER", help='Name a column: --map time="T (s)".')
]
ConfigOption = Annotated[Path | None, typer.Option("--config", help="TOML file with constants.")]


def example_of(*lines: str) -> str:
    """Write the end of a command's help; what stands on one line stays there."""
    return "\b\nExample:  " + " \\\n            ".join(lines)


def pairs(given: list[str] | None, option: str) -> dict[str, str]:
    """Split KEY=VALUE options; the last of one key wins."""
    pairs: dict[str, str] = {}
    for item in given or []:
        key, equals, value = item.partition("=")
        if not equals or not key.strip() or not value.strip():
            example = "turns=1/3" if option == "--set" else 'time="T (s)"'
            refuse(
                OPTION_IS_NO_PAIR, f"{option} {item!r} is not of the form KEY=VALUE", f"for example {option} {example}"
            )
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
