"""The commands: only this package prints and exits. Commands import heavy modules when they run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any

import typer
from msgspec import Struct

from gyrodata import __version__, diagnostics
from gyrodata.cli.options import example_of
from gyrodata.cli.terminal import Door, refuse, write_out


class _Kind(Struct, frozen=True):
    """The description of a command that is not loaded yet."""

    module: str
    short: str = ""
    """Its line in ``gyro --help``; empty for a command that is only for programs."""
    example: tuple[str, ...] = ()


_COMMANDS = {
    "analyze": _Kind(
        "analyze_command",
        "Fit I_zz to a log, and write figures and a report.",
        ("gyro analyze sample_data/air_gyroscope.csv",),
    ),
    "check": _Kind(
        "check_command",
        "Check a log while you can still repeat or add runs.",
        ("gyro check sample_data/air_gyroscope.csv",),
    ),
    "template": _Kind(
        "check_command",
        "Print a blank log to fill in.",
        ("gyro template --weights 20g,40g,60g", "--position 15cm --spins 200,400,600rpm", "> log.csv"),
    ),
    "explain": _Kind(
        "explain_command",
        "Explain a message code, a word or a key; or show a page.",
        (f"gyro explain {diagnostics.NO_UNLOADED_RUN}",),
    ),
    "grade": _Kind(
        "grade_command", "Grade a class, with feedback for each student.", ("gyro grade sample_data/class",)
    ),
    "autograde": _Kind("grade_command"),
    "simulate": _Kind(
        "simulate_command",
        "Print a simulated log of a known truth.",
        (
            'gyro simulate --inertia "4.44e-3 kg m^2"',
            "--weights 20g,40g,60g --position 15cm",
            "--spins 200,400,600rpm --turns 1",
            "--seed 1 > log.csv",
        ),
    ),
    "selfcheck": _Kind(
        "tool_commands",
        "Test by simulation if the intervals of a log are reliable.",
        ("gyro selfcheck sample_data/air_gyroscope.csv", "--labs 1000"),
    ),
    "benchmark": _Kind(
        "tool_commands",
        "Chart speed against accuracy, and failures of methods.",
        ("gyro benchmark --quick --out charts",),
    ),
    "schema": _Kind(
        "tool_commands",
        "Print JSON Schemas (outputs, a rubric), or all diagnostics.",
        ("gyro schema diagnostics",),
    ),
    "predict": _Kind("predict_command", "Predict precession and other motions from theory."),
}


_GROUPS = {
    "Your lab": ("analyze", "check", "template", "explain"),
    "A class": ("grade",),
    "Theory and simulation": ("predict", "simulate"),
    "Advanced": ("selfcheck", "schema", "benchmark"),
}
"""The commands as ``gyro --help`` lists them."""

_LOGS = (".csv", ".xlsx", ".ods", ".txt", ".tsv", ".gz")
_MEANT = {
    **dict.fromkeys(("fit", "plot", "report", "figures"), "gyro analyze LOG"),
    "version": "gyro --version",
    "docs": "gyro explain",
}
"""Commands that users may try, with the command that is meant."""


@cache
def _load(name: str) -> Any:
    """Import the module of a command, and return the command."""
    kind = _COMMANDS[name]
    found = getattr(import_module(f"gyrodata.cli.{kind.module}"), name)
    if not isinstance(found, typer.Typer):
        alone = typer.Typer(add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)
        epilog = example_of(*kind.example) if kind.example else None
        alone.command(name, short_help=kind.short, epilog=epilog, hidden=not kind.short)(found)
        found = alone
    command = typer.main.get_command(found)
    command.name, command.short_help = name, kind.short
    return command


class _OnDemand(Mapping[str, Any]):
    """The commands by name. Each is loaded when it is used, so that the start is fast."""

    def __getitem__(self, name: str) -> Any:
        if name not in _COMMANDS:
            raise KeyError(name)
        return _load(name)

    def __iter__(self) -> Iterator[str]:
        return iter(_COMMANDS)

    def __len__(self) -> int:
        return len(_COMMANDS)


class _Gyro(Door):
    """The command ``gyro``."""

    def __init__(self, **attributes: Any) -> None:
        super().__init__(**attributes | {"commands": _OnDemand()})

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """List the commands in ``gyro --help`` without loading them."""
        for title, names in _GROUPS.items():
            with formatter.section(title):
                formatter.write_dl([(name, _COMMANDS[name].short) for name in names])

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read "help analyze" as "analyze --help"."""
        return super().parse_args(ctx, [*args[1:], "--help"] if args[:1] == ["help"] else args)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Find a command; for a log or a known other word, name the command that is meant."""
        name = args[0]
        meant = _MEANT.get(name.lower(), f"gyro analyze {name}" if Path(name).suffix.lower() in _LOGS else "")
        if meant and name not in _COMMANDS:
            refuse(diagnostics.COMMAND_UNKNOWN, f'there is no command "{name}"', f"type: {meant}")
        return super().resolve_command(ctx, args)


app = typer.Typer(
    name="gyro",
    cls=_Gyro,
    help="Compute the moment of inertia of a gyroscope, with a realistic uncertainty, from the log of a lab.",
    # Plain help costs half the start-up time of a coloured one.
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


@app.callback(invoke_without_command=True)
def _gyro(
    version: Annotated[bool, typer.Option("--version", "-V", help="Show the version and exit.")] = False,
) -> None:
    if version:
        write_out(f"gyro {__version__}\n")
        raise typer.Exit
