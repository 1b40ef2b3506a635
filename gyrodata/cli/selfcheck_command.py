"""``gyro selfcheck``: this lab, simulated many times."""

from __future__ import annotations

from typing import Annotated

import typer

from gyrodata.cli.options import ConfigOption, MappingOption, PlainFormat, SettingsOption, pairs
from gyrodata.cli.terminal import progress_bar, source_of, write_out


def selfcheck(
    log: Annotated[str, typer.Argument(metavar="LOG", help="CSV log; - is standard input.")],
    labs: Annotated[int, typer.Option("--labs", min=1, max=1_000_000, help="How many labs to simulate.")] = 4000,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of the random numbers.")] = 1,
    form: Annotated[PlainFormat, typer.Option("--format", "-f", help="Form of the output.")] = "text",
    settings: SettingsOption = None,
    mapping: MappingOption = None,
    config: ConfigOption = None,
) -> None:
    """Simulate this very lab many times, and count how often the quoted intervals hold the truth.

    The lab's design, its fitted values as the truth and its stated uncertainties make new readings; the
    recommended fit and those of the textbook are applied to each. Where the runs of the log scatter otherwise than
    stated, the output says so, and has a second table of labs that scatter as this one does.
    """
    import time

    from gyrodata import reporting
    from gyrodata.analysis import analyze_readings
    from gyrodata.measurements import select
    from gyrodata.readings import read_log
    from gyrodata.selfcheck import selfcheck as simulate

    given = pairs(settings, "--set"), pairs(mapping, "--map")
    readings = read_log(**source_of(log), settings=given[0], mapping=given[1], config=config)
    analysis = analyze_readings(readings)
    tilted = any(effect.effect == "tilt" and effect.kept for effect in analysis.effects)
    kept = [i for i, run in enumerate(analysis.run_table) if not run.left_out]
    measured = select(analysis.measurements, kept)
    done = simulate(measured, time.perf_counter, labs, seed=seed, tilted=tilted, progress=progress_bar(labs))
    write_out(reporting.json_text(done.to_dict()) if form == "json" else done.to_text() + "\n")
