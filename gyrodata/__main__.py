"""The entry point of ``gyro`` and of ``python -m gyrodata``."""

from __future__ import annotations

import atexit
import gc
import os
import sys
from contextlib import suppress


def main() -> None:
    """Run the command line."""
    # A log has a few dozen rows: more threads only slow down the start.
    for library in ("OPENBLAS", "OMP", "MKL"):
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")
    # Figures are written to files: no setting of a window can prevent them.
    os.environ["MPLBACKEND"] = "agg"
    # Objects from the start are never freed: searching them for garbage takes 5 % of a
    # run.
    gc.set_threshold(1_000_000)
    from gyrodata.cli import app

    app()


def command() -> None:
    """Run the command ``gyro``, and end the process at once.

    The objects are not freed one by one, because this would take 10 % of a run.
    """
    try:
        main()
    except SystemExit as ended:
        if not isinstance(ended.code, int | None):
            raise
        atexit._run_exitfuncs()
        for stream in (sys.stdout, sys.stderr):
            with suppress(OSError, ValueError):
                stream.flush()
        os._exit(ended.code or 0)


if __name__ == "__main__":
    command()
