"""The door: ``gyro`` and ``python -m gyrodata``."""

from __future__ import annotations

import gc
import os
import sys


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
    # What a start makes stays: to look through it for rubbish all the time takes a twentieth of a run.
    gc.set_threshold(100_000)
    from gyrodata.cli import app

    app()


if __name__ == "__main__":
    main()
