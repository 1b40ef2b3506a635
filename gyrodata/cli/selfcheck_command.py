"""``gyro selfcheck``: how often the intervals of a lab contain the true value."""

from __future__ import annotations

from typing import Annotated

import typer

from gyrodata.cli.options import (
    ConfigOption,
    FormatOption,
    MappingOption,
    SettingsOption,
    read,
)
from gyrodata.cli.terminal import progress_bar, write_answer


def selfcheck(
    *,
    logs: Annotated[
        list[str],
        typer.Argument(
            metavar="LOG",
            help="Log: CSV, text or workbook; - is stdin. Several are days of one "
            "gyroscope.",
        ),
    ],
    labs: Annotated[
        int,
        typer.Option("--labs", min=1, max=1000000, help="Number of simulated labs."),
    ] = 1000,
    seed: Annotated[
        int, typer.Option("--seed", min=0, help="Seed of the random numbers.")
    ] = 1,
    form: FormatOption = "text",
    settings: SettingsOption = None,
    mapping: MappingOption = None,
    config: ConfigOption = None,
) -> None:
    r"""Simulate this lab many times, and count the intervals with the true value.

    gyro simulates new readings from the design of the lab, its fitted values as the
    truth, and its stated uncertainties. Each day of a lab has its own M0 and hand; each
    of several logs is a day. gyro applies the recommended fit and those of the textbook
    to each lab. If the runs scatter more or less than stated, a second table shows labs
    with this scatter.

    Example:  gyro selfcheck demo.csv \
                --labs 1000
    """
    from gyrodata.analysis import analyze_readings
    from gyrodata.trials.coverage import selfcheck as simulate

    analysis = analyze_readings(read(logs, settings, mapping, config))
    with progress_bar(labs, "simulated labs") as progress:
        done = simulate(analysis, labs, seed, progress)
    write_answer(form, done.to_dict(), f"{done}\n")
