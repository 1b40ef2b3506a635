"""The commands: only this package prints and exits, and it imports modules late."""

from __future__ import annotations

import tomllib
from collections import UserDict
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any

import typer
from msgspec import Struct, convert

from gyrodata.base.version import __version__
from gyrodata.cli.terminal import Door, write_out


class _Kind(Struct, frozen=True):
    """The description of a command that is not loaded yet."""

    module: str = ""
    short: str = ""
    """Its line in ``gyro --help``; empty for a command that is only for programs."""
    example: tuple[str, ...] = ()
    """The lines of commands to copy."""
    also: str = ""
    """Words that users may type instead of its name."""
    options: dict[str, str] = {}
    """Help of the options and arguments by their names in the module."""
    commands: dict[str, _Kind] = {}
    """Commands below it."""


_GROUPS = convert(
    tomllib.loads(
        Path(__file__).with_name("commands.toml").read_text(encoding="utf-8")
    ),
    dict[str, dict[str, _Kind]],
)
"""The commands as ``gyro --help`` lists them."""

_COMMANDS = {name: kind for group in _GROUPS.values() for name, kind in group.items()}
_COMMANDS["autograde"] = _Kind("grade_command")

_LOGS = (".csv", ".xlsx", ".ods", ".txt", ".tsv", ".gz")
_MEANT = {
    word: name for name, kind in _COMMANDS.items() for word in kind.also.split()
} | {"version": "--version"}
"""Words that users may type, with the command that they mean."""


@cache
def _load(name: str) -> Any:
    """Import the module of a command, and return the command."""
    kind = _COMMANDS[name]
    command = getattr(import_module(f"gyrodata.cli.{kind.module}"), name)
    if not isinstance(command, typer.Typer):
        alone = typer.Typer(
            add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False
        )
        alone.command(name, hidden=not kind.short)(command)
        command = alone
    return _described(typer.main.get_command(command), name, kind)


def _described(command: Any, name: str, kind: _Kind) -> Any:
    """Give a command, its options and its subcommands the texts of `commands.toml`."""
    command.name = name
    command.short_help = kind.short
    if kind.example:
        # The lines are not wrapped after this sign.
        command.epilog = "\b\nExample:  " + "\n          ".join(kind.example)
    for below, its_kind in kind.commands.items():
        _described(command.commands[below], below, its_kind)
    for param in command.params:
        param.help = kind.options.get(param.name, param.help)
        if param.param_type_name == "argument":
            # Typer writes the Python type behind the name: "LOG <list[str]>".
            param.display_type_rich = lambda ctx: None
    return command


class _OnDemand(UserDict[str, Any]):
    """The commands by name. Each is loaded when it is used: the start is fast."""

    def __getitem__(self, name: str) -> Any:
        return _load(name)


class _Gyro(Door):
    """The command ``gyro``."""

    def __init__(self, **attributes: Any) -> None:
        super().__init__(**attributes | {"commands": _OnDemand(_COMMANDS)})

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """List the commands in ``gyro --help`` without loading them."""
        for title, group in _GROUPS.items():
            with formatter.section(title):
                formatter.write_dl([(name, kind.short) for name, kind in group.items()])

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read "help analyze" as "analyze --help", "log.csv" as "analyze log.csv"."""
        if args[:1] == ["help"]:
            args = [*args[1:], "--help"]
        first = args[0].lower() if args else ""
        if first in _MEANT:
            args = [_MEANT[first], *args[1:]]
        elif _is_log(first) or (first.startswith("-") and any(map(_is_log, args))):
            args = ["analyze", *args]
        return super().parse_args(ctx, args)


def _is_log(word: str) -> bool:
    return word == "-" or Path(word).suffix.lower() in _LOGS


app = typer.Typer(
    name="gyro",
    cls=_Gyro,
    help=(
        "Compute the moment of inertia of a gyroscope, with a realistic uncertainty, "
        "from the log of a lab."
    ),
    # Plain help costs half the start-up time of a coloured one.
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


@app.callback(invoke_without_command=True)
def _gyro(
    version: Annotated[
        bool, typer.Option("--version", "-V", help="Show the version and exit.")
    ] = False,
) -> None:
    if version:
        write_out(f"gyro {__version__}\n")
        raise typer.Exit
