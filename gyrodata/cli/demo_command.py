"""``gyro demo``: a sample log, copied here and analyzed."""

from __future__ import annotations

from pathlib import Path

from gyrodata.cli.analyze_command import OpenOption, analyze
from gyrodata.cli.documentation import FOLDER
from gyrodata.cli.new_table import write_new
from gyrodata.cli.terminal import tell


def demo(opened: OpenOption = False) -> None:
    """Write a sample log, demo.csv, into this folder, and analyze it.

    The log contains ten runs with an air gyroscope.

    Example:  gyro demo
    """
    log = Path("demo.csv")
    write_new(log, (FOLDER / log).read_bytes())
    tell(
        "change a number in demo.csv, then type: gyro check demo.csv",
        "for your own log: gyro template --out log.xlsx",
        "for a guide: gyro explain first-timer",
    )
    analyze(logs=[log.name], opened=opened)
