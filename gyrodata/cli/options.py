"""Options that several commands share, and options that are quantities."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from gyrodata.cli.terminal import names_of, refuse, source_of, tell

if TYPE_CHECKING:
    from gyrodata.readings import Readings

PlainFormat = Literal["text", "json"]
"""Text for people or JSON for programs."""

FormatOption = Annotated[
    PlainFormat, typer.Option("--format", "-f", help="Form of the output.")
]
SettingsOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="KEY=VALUE", help='A constant: --set g="9.803 m/s^2".'
    ),
]
MappingOption = Annotated[
    list[str] | None,
    typer.Option(
        "--map", metavar="ROLE=HEADER", help='Name a column: --map time="T (s)".'
    ),
]
ConfigOption = Annotated[
    Path | None,
    typer.Option(
        "--config",
        help="TOML file with constants. Default: gyro.toml next to the log, or above it.",
    ),
]

Bound = Literal[
    "",
    "above zero",
    "other than zero",
    "zero or above",
    "below 90 degrees",
    "from -90 to 90 degrees",
]


def pairs(texts: list[str] | None, option: str) -> dict[str, str]:
    """Split KEY=VALUE options; the last value of a key is used."""
    values: dict[str, str] = {}
    if texts is None:
        return values
    for item in texts:
        key, _, value = (part.strip() for part in item.partition("="))
        if not key or not value:
            example, form = (
                ("turns=1/3", "KEY=VALUE")
                if option == "--set"
                else ('time="T (s)"', "ROLE=HEADER")
            )
            refuse(
                "option_not_a_pair",
                option=option,
                item=item,
                form=form,
                example=example,
            )
        values[key] = value
    return values


def read(
    logs: Sequence[str],
    settings: list[str] | None = None,
    mapping: list[str] | None = None,
    config: Path | None = None,
) -> Readings:
    """Read the logs of a command with the values of its options, as one log."""
    from gyrodata.readings import read_log
    from gyrodata.readings.together import read_together

    readings = [
        read_log(
            **source_of(log, name),
            settings=pairs(settings, "--set"),
            mapping=pairs(mapping, "--map"),
            config=constants_of(log, config),
        )
        for log, name in zip(logs, names_of(logs), strict=True)
    ]
    return read_together(readings)


def constants_of(log: str, config: Path | None, quiet: bool = False) -> Path | None:
    """Return the TOML file with constants for a log; None if there is none.

    It is the file of --config, else that of the variable GYRO_CONFIG, else the next
    gyro.toml in the folder of the log or above it.
    """
    if config is not None:
        return config
    near = settings_file(None if log == "-" else Path(log).parent)
    if near is not None and not quiet:
        tell(f"constants of the apparatus: {near.as_posix()}")
    return near


def settings_file(folder: Path | None) -> Path | None:
    """Return the file of GYRO_CONFIG, else the next gyro.toml; None if there is none.

    The search ends at the home folder and at the top of a repository. There is none for
    a log from standard input.
    """
    if named := os.environ.get("GYRO_CONFIG"):
        return Path(named)
    if folder is None:
        return None
    start = folder.absolute()
    for place in (start, *start.parents):
        settings = place / "gyro.toml"
        if settings.is_file():
            return Path(os.path.relpath(settings))
        if place == Path.home() or (place / ".git").exists():
            break
    return None


def with_units(items: str) -> list[str]:
    """Split "200,400,600rpm" at the commas.

    An item without a unit has the unit of the next item with one.
    """
    unit = ""
    complete = []
    for item in reversed([item.strip() for item in items.split(",") if item.strip()]):
        number = re.split(r"[^\d.]*$", item)[0]
        unit = item[len(number) :].strip() or unit
        complete.append(f"{number} {unit}".strip())
    return complete[::-1]


def quantity(option: str, text: str, kind: str, bound: Bound = "") -> float:
    """Read the number and unit of an option.

    Parameters
    ----------
    option : str
        Its name, for messages.
    text : str
        Its value, such as "400 rpm".
    kind : str
        Kind of quantity, a key of `units.KINDS`.
    bound : str
        What the value has to be.

    Returns
    -------
    float
        The value [SI unit of the kind].

    Raises
    ------
    InputError
        If there is no such number, or no laboratory has such a value.
    """
    from gyrodata.quantities import notation, units

    shown = f'{option} "{text.strip()[:40]}"'
    try:
        value = notation.parse_quantity(text, kind)
    except units.UnitError as error:
        if re.fullmatch(r"\s*[-+]?\d++\.?\d*\s*", text):
            refuse(
                "option_without_unit",
                shown=shown,
                option=option,
                meant=f"{text.strip()} {units.DISPLAY[kind]}",
            )
        refuse("option_not_a_quantity", option=option, error=error, hint=error.hint)
    broken = {
        "above zero": value <= 0,
        "other than zero": value == 0,
        "zero or above": value < 0,
        "below 90 degrees": abs(value) >= math.pi / 2,
        "from -90 to 90 degrees": abs(value) > math.pi / 2,
    }
    if broken.get(bound):
        refuse("option_impossible", shown=shown, bound=bound)
    low, high = units.LIMITS[kind]
    # No angle is too small: the pitch of a level rod may be nearly zero.
    if abs(value) > high or (0 < abs(value) < low and kind != "angle"):
        size = "large" if abs(value) > high else "small"
        unit = f" {units.SI[kind]}".rstrip()
        refuse(
            "option_too_large",
            shown=shown,
            size=size,
            kind=units.KINDS[kind].words,
            low=low,
            high=high,
            unit=unit,
        )
    return value
