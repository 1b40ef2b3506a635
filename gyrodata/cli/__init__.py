"""The commands: the only place that prints, writes and exits. Heavy modules are imported inside them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated

import typer

from gyrodata import __version__
from gyrodata.cli.analyze_command import analyze
from gyrodata.cli.check_command import check, template
from gyrodata.cli.grade_command import autograde, grade
from gyrodata.cli.options import example_of
from gyrodata.cli.predict_command import predict
from gyrodata.cli.simulate_command import simulate
from gyrodata.cli.terminal import Door, write_out
from gyrodata.cli.tool_commands import benchmark, explain, schema, selfcheck
from gyrodata.diagnostics import NO_UNLOADED_RUN

app = typer.Typer(
    name="gyro",
    cls=Door,
    help="From a gyroscope lab's log to its moment of inertia, with an uncertainty that can be trusted.",
    no_args_is_help=True,
    add_completion=True,
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


def _add(command: Callable[..., None], short: str, *example: str) -> None:
    """Add a command, with its line in ``gyro --help``."""
    app.command(short_help=short, epilog=example_of(*example))(command)


_add(analyze, "Fit I_zz to a log, and write figures and a report.",
     "gyro analyze sample_data/air_gyroscope.csv --no-report")  # fmt: skip
_add(check, "Say what is wrong with a log, and what it still lacks.", "gyro check sample_data/air_gyroscope.csv")
_add(template, "Print a blank log to fill in.",
     "gyro template --weights 20g,40g,60g --position 15cm", "--spins 200,400,600rpm > log.csv")  # fmt: skip
_add(explain, "Say what a diagnostic means, and what to do.", f"gyro explain {NO_UNLOADED_RUN}")
_add(grade, "Grade a class, with feedback for everybody.", "gyro grade sample_data/class")
app.command(hidden=True)(autograde)
app.add_typer(predict, name="predict", short_help="Say what theory predicts for given numbers.")
_add(simulate, "Print a log from a known truth.",
     'gyro simulate --inertia "4.44e-3 kg m^2" --weights 20g,40g,60g',
     "--position 15cm --spins 200,400,600rpm --turns 1", "--seed 1 > log.csv")  # fmt: skip
_add(selfcheck, "Simulate this very lab: do its intervals hold the truth?",
     "gyro selfcheck sample_data/air_gyroscope.csv --labs 1000")  # fmt: skip
_add(benchmark, "Chart speed against accuracy, and where methods break.", "gyro benchmark --quick --out charts")
_add(schema, "Print the JSON Schema of the outputs, or all diagnostics.", "gyro schema --diagnostics")
