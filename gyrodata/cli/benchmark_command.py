"""``gyro benchmark``: speed against accuracy, charted, and where methods break."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from gyrodata.cli.terminal import progress_bar, write_folder, write_out


def benchmark(
    out: Annotated[
        Path, typer.Option("--out", "-o", help="Folder for the charts; made if it is not there.")
    ] = Path("gyro-benchmark"),
    quick: Annotated[bool, typer.Option("--quick", help="Fewer labs and points: less than a minute.")] = False,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of the random numbers.")] = 1,
) -> None:  # fmt: skip
    """Chart speed against accuracy on this machine, and map where methods break.

    Motion models and integrators, estimators, and maps of stability: each as PNG, SVG and CSV, and a short text that
    reads the charts, which is printed too. It takes some minutes, with --quick less than one.
    """
    import time

    from gyrodata.benchmark import FULL, QUICK, csv_tables, reading, run_benchmark
    from gyrodata.plotting import render_benchmark

    effort = QUICK if quick else FULL
    show = progress_bar(100)
    # A folder that cannot be written is better known before the minutes than after them.
    write_folder(out, {})
    done = run_benchmark(effort, time.perf_counter, seed, None if show is None else lambda part: show(int(100 * part)))
    words = reading(done, effort, seed)
    tables = {f"{name}.csv": table.encode() for name, table in csv_tables(done).items()}
    write_folder(out, {**render_benchmark(done), **tables, "reading.md": words.encode()})
    write_out(words)
    typer.echo(f"charts: {out}", err=True)
