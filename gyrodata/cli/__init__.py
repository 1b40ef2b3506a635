"""The commands: the only place that prints, writes and exits. Heavy modules are imported inside them."""

from __future__ import annotations

from typing import Annotated

import typer

from gyrodata import __version__
from gyrodata.cli.analyze import analyze
from gyrodata.cli.benchmark import benchmark
from gyrodata.cli.check import check
from gyrodata.cli.contracts import schema, template
from gyrodata.cli.grade import autograde, grade
from gyrodata.cli.predict import predict
from gyrodata.cli.selfcheck import selfcheck
from gyrodata.cli.simulate import simulate
from gyrodata.cli.terminal import Door, write_out

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


app.command(epilog="Example:  gyro analyze sample_data/air_gyroscope.csv --no-report")(analyze)
app.command(epilog="Example:  gyro check sample_data/air_gyroscope.csv")(check)
app.command(epilog="Example:  gyro template --weights 20g,40g,60g --position 15cm --spins 200,400,600rpm > log.csv")(
    template
)
app.command(epilog="Example:  gyro grade sample_data/class")(grade)
app.command(hidden=True)(autograde)
app.add_typer(predict, name="predict")
app.command(
    epilog='Example:  gyro simulate --inertia "4.44e-3 kg m^2" --weights 20g,40g,60g --position 15cm '
    "--spins 200,400,600rpm --turns 1 --seed 1 > log.csv"
)(simulate)
app.command(epilog="Example:  gyro selfcheck sample_data/air_gyroscope.csv --labs 1000")(selfcheck)
app.command(epilog="Example:  gyro benchmark --quick --out charts")(benchmark)
app.command(epilog="Example:  gyro schema --diagnostics")(schema)
