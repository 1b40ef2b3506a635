"""The door: ``gyro`` and ``python -m gyrodata``."""

from __future__ import annotations

import atexit
import gc
import os
import sys
from contextlib import suppress


def main() -> None:
    """Run the command line; ``gyro --version`` answers before anything is loaded."""
    if sys.argv[1:] in (["--version"], ["-V"]) and sys.stdout is not None:
        from gyrodata import __version__

        try:
            print(f"gyro {__version__}", flush=True)
        except OSError:
            # The command line below has the words for it.
            pass
        else:
            return
    # A log is a few dozen rows: more threads only cost start-up time and heat.
    for library in ("OPENBLAS", "OMP", "MKL"):
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")
    # Objects made at the start stay: looking through them for garbage takes a twentieth of a run.
    gc.set_threshold(100_000)
    from gyrodata.cli import app

    app()


def command() -> None:
    """Be the command ``gyro``: a process that ends once its exit handlers have run.

    To take all that was loaded and made apart, object by object, takes a tenth of a run.
    """
    try:
        main()
    except SystemExit as ended:
        if not isinstance(ended.code, int | None):
            raise
        atexit._run_exitfuncs()
        with suppress(OSError, ValueError):
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(ended.code or 0)
        raise


if __name__ == "__main__":
    command()
