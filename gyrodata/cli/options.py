"""Options that several commands share, and options that are quantities."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Sequence
from os.path import relpath
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer
from msgspec import Struct

from gyrodata.base.diagnostics import UNIT_MISSING
from gyrodata.cli.terminal import Log, named_logs, refuse, source_of, tell

if TYPE_CHECKING:
    from gyrodata.readings import Readings
    from gyrodata.results import Input

FormatOption = Annotated[
    Literal["text", "json"], typer.Option("--format", "-f", help="Form of the output.")
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
        help="TOML file with constants. Default: gyro.toml next to the log, or above "
        "it.",
    ),
]


def pairs(texts: list[str] | None, option: str) -> dict[str, str]:
    """Split KEY=VALUE options; a key with two values is refused."""
    values: dict[str, str] = {}
    for item in texts or []:
        key, _, value = (part.strip() for part in item.partition("="))
        if not (key and value):
            refuse("option_not_a_pair", option=option, item=item)
        if values.setdefault(key, value) != value:
            refuse("option_given_twice", option=option, key=key)
    return dict(sorted(values.items()))


class Reader(Struct, frozen=True):
    """Reads logs with the constants and headers that the options of a command give."""

    settings: dict[str, str]
    mapping: dict[str, str]
    config: Path | None
    quiet: bool = False

    @classmethod
    def of_options(
        cls,
        settings: list[str] | None,
        mapping: list[str] | None,
        config: Path | None,
        quiet: bool = False,
    ) -> Reader:
        """Return the reader for the options --set, --map and --config."""
        return cls(pairs(settings, "--set"), pairs(mapping, "--map"), config, quiet)

    def constants_of(self, log: str) -> Path | None:
        """Return the TOML file with constants for a log; None if there is none.

        It is the file of --config, else that of the variable GYRO_CONFIG, else the next
        gyro.toml in the folder of the log or above it.
        """
        if self.config is not None:
            return self.config
        return settings_file(None if log == "-" else Path(log).parent)

    def read(self, logs: Sequence[Log]) -> Readings:
        """Read logs of one gyroscope, several as one."""
        from gyrodata.readings.together import read_together

        return read_together([self._read_log(log) for log in logs])

    def _read_log(self, log: Log) -> Readings:
        from gyrodata.readings import read_log

        constants = self.constants_of(log.path)
        if constants != self.config and not self.quiet:
            tell(f"constants of the apparatus: {constants}")
        return read_log(
            source_of(log),
            name=log.name,
            settings=self.settings,
            mapping=self.mapping,
            config=constants,
        )


def read_bytes(path: Path) -> bytes:
    """Read the file of an option."""
    try:
        return path.read_bytes()
    except OSError as error:
        refuse("option_file_not_read", path=path, why=error.strerror or error)


def input_of(name: str, readings: Readings | None) -> Input:
    """Describe a log, which may be unreadable, for the JSON."""
    from gyrodata.results import Input

    if readings is None:
        return Input(name, None, None)
    return Input(name, readings.sha256, len(readings.runs))


def read(
    logs: Sequence[str],
    settings: list[str] | None = None,
    mapping: list[str] | None = None,
    config: Path | None = None,
) -> Readings:
    """Read the logs of a command with the values of its options, as one log."""
    return Reader.of_options(settings, mapping, config).read(named_logs(logs))


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
            return Path(relpath(settings))
        if place == Path.home() or (place / ".git").exists():
            break
    return None


def stem_of(log: Path) -> str:
    """Return the name of a log without its ending: "lab" of lab.csv.gz."""
    name = "stdin" if log == Path("-") else log.name.removesuffix(".gz")
    return Path(name).stem


def with_units(items: str) -> list[str]:
    """Split "200,400,600rpm" at the commas or semicolons.

    An item without a unit has the unit of the next item with one.
    """
    unit = ""
    complete = []
    for item in reversed(items.replace(";", ",").split(",")):
        number = re.sub(r"[^\d.]*$", "", item.strip())
        unit = item.strip()[len(number) :].strip() or unit
        complete.append(f"{number} {unit}".strip())
    return complete[::-1]


def quantity_option(option: str, kind: str, bound: str = "", *, words: str) -> Any:
    """Return an option whose value is a number with a unit [SI unit of the kind]."""
    return typer.Option(
        option,
        metavar="QUANTITY",
        parser=lambda text: quantity(option, text, kind, bound),
        help=words,
    )


def list_option(
    option: str,
    kind: str,
    bound: str = "",
    metavar: str = "QUANTITIES",
    *,
    words: str,
) -> Any:
    """Return an option whose value is a tuple of numbers [SI unit of the kind]."""

    def parse(text: str) -> tuple[float, ...]:
        items = with_units(text)
        return tuple([quantity(option, item, kind, bound) for item in items])

    return typer.Option(option, metavar=metavar, parser=parse, help=words)


def quantity(option: str, text: str, kind: str, bound: str = "") -> float:
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
    from gyrodata.quantities.notation import parse_quantity
    from gyrodata.quantities.units import DISPLAY, LIMITS, SI, UnitError

    try:
        value = parse_quantity(text, kind)
    except UnitError as error:
        hint = error.hint
        if error.code == UNIT_MISSING:
            hint = f'write {option} "{text.strip()} {DISPLAY[kind]}"; or {hint}'
        refuse("option_not_a_quantity", option=option, error=error, hint=hint)
    shown = f'{option} "{text.strip()[:40]}"'
    low, high = LIMITS[kind]
    size = abs(value)
    broken = {
        "above zero": value <= 0,
        "other than zero": value == 0,
        "zero or above": value < 0,
        "below 90 degrees": size >= math.pi / 2,
        "from -90 to 90 degrees": size > math.pi / 2,
    }
    if bound and broken[bound]:
        refuse("option_impossible", shown=shown, bound=bound)
    # No angle is too small: the pitch of a level rod may be nearly zero.
    is_small = 0 < size < low and kind != "angle"
    if is_small or size > high:
        limits = f"from {low:g} to {high:g} {SI[kind]}".rstrip()
        refuse("option_impossible", shown=shown, bound=limits)
    return value
