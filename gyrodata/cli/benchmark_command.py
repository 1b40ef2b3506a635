"""``gyro benchmark``: charts of speed against accuracy."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from gyrodata.base.disk import telling, write_folder
from gyrodata.cli.options import read
from gyrodata.cli.terminal import named_logs, progress_bar, tell


def benchmark(
    *,
    log: Annotated[
        str | None,
        typer.Argument(
            metavar="[LOG]", help="Log whose lab takes the place of the usual one."
        ),
    ] = None,
    out: Annotated[
        Path,
        typer.Option(
            "--out", "-o", help="Folder for the page, the pictures and the tables."
        ),
    ] = Path("gyro-benchmark"),
    quick: Annotated[
        bool,
        typer.Option(
            "--quick", help="A quick look with few labs: a quarter of a minute."
        ),
    ] = False,
) -> None:
    """Chart cost against error on this machine, and map where methods fail.

    The charts compare programs that fit a lab, models of the motion and integrators. The
    maps show for two quantities each where a common method fails, and what gyro does
    there. With a LOG, its lab takes the place of the usual one. gyro writes one page,
    benchmark.html, with the pictures as PNG and their numbers as CSV. It takes up to ten
    minutes on two processors, with --quick a quarter of a minute.

    Example:  gyro benchmark --quick --out charts
    """
    from gyrodata.analysis import fit_log
    from gyrodata.base.workers import count_workers
    from gyrodata.results import Options
    from gyrodata.trials.benchmark.labs import scene_of
    from gyrodata.trials.benchmark.report import FULL, QUICK, files, run

    own = None
    if log is not None:
        own = scene_of(fit_log(read([log]), Options()))
    # Test first that the folder can be written, because the benchmark takes minutes.
    with telling(out):
        write_folder(out, {})
    effort = QUICK if quick else FULL
    workers = count_workers()
    with progress_bar(100, "per cent") as progress:
        tables = run(effort, workers, own, progress)
    name = named_logs([log])[0].name if log else ""
    pages = files(tables, name, workers)
    with telling(out):
        write_folder(out, pages)
    tell(f"page: {out / 'benchmark.html'}")
