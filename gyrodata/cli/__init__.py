"""The commands of ``gyro``: only this package prints and exits.

The words of a command line go in; text, files and an exit code come out. Nothing here
computes a result: the commands call the rooms below, and import them late, so that the
start is fast.
"""

from __future__ import annotations

from collections import UserDict
from functools import cache, partial
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any

import typer

from gyrodata.base.version import __version__
from gyrodata.cli.documentation import COMMANDS, GROUPS
from gyrodata.cli.terminal import Command, Door, write_out

_MEANT = {
    "sample": "demo",
    "new": "template",
    "fit": "analyze",
    "plot": "analyze",
    "report": "analyze",
    "analyse": "analyze",
    "docs": "explain",
    "version": "--version",
}
"""Words that users may type, with the command that they mean."""

_LOGS = (".csv", ".xlsx", ".ods", ".txt", ".tsv", ".gz")


@cache
def _load(name: str) -> Any:
    """Import the module of a command, and return the command."""
    module = import_module(f"gyrodata.cli.{name}_command")
    command = getattr(module, name)
    if not isinstance(command, typer.Typer):
        alone = typer.Typer(add_completion=False, rich_markup_mode=None)
        alone.command(name, hidden=name not in COMMANDS, cls=Command)(command)
        command = alone
    loaded = _described(typer.main.get_command(command))
    loaded.short_help = COMMANDS.get(name, "")
    return loaded


def _described(command: Any) -> Any:
    """Show the examples of a docstring below the options, each in its own line."""
    command.help, _, example = command.help.partition("\n\nExample:")
    command.short_help = command.help.partition("\n")[0]
    if example:
        # Lines are not wrapped after this sign.
        command.epilog = f"\b\nExample:{example}"
    for below in getattr(command, "commands", {}).values():
        _described(below)
    for param in command.params:
        if param.param_type_name == "argument":
            # Typer writes the Python type behind the name: "LOG <list[str]>".
            param.display_type_rich = lambda ctx: None
    return command


class _OnDemand(UserDict[str, Any]):
    """The commands by name. Each is loaded when it is used: the start is fast."""

    def __getitem__(self, name: str) -> Any:
        load = self.data[name]
        return load()


class _Gyro(Door):
    """The command ``gyro``."""

    def __init__(self, **attributes: Any) -> None:
        # Only programs call "autograde".
        names = (*COMMANDS, "autograde")
        commands = _OnDemand({name: partial(_load, name) for name in names})
        super().__init__(**attributes | {"commands": commands})

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """List the commands in ``gyro --help`` without loading them."""
        for title, group in GROUPS.items():
            with formatter.section(title):
                formatter.write_dl(list(group.items()))

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
    suggest_commands=False,
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
    """Compute the moment of inertia of a gyroscope from the log of a lab.

    gyro states a realistic uncertainty.
    """
    if version:
        write_out(f"gyro {__version__}\n")
        raise typer.Exit
