"""Processes that a test starts beside itself: they hear Ctrl-C, and they end with the
test in any case.
"""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Any


@contextmanager
def started(
    command: list[str | Path], *, hears_control_c: bool = True, **options: Any
) -> Iterator[subprocess.Popen[Any]]:
    """Start a process in a group of its own, and end the whole group at the end.

    A process inherits that SIGINT is ignored, for example if the tests run in the
    background of a shell. Then Ctrl-C would not reach it, so the signal is set anew.
    """
    action = signal.SIG_DFL if hears_control_c else signal.SIG_IGN
    with subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        process_group=0,
        preexec_fn=partial(signal.signal, signal.SIGINT, action),
        **options,
    ) as process:
        try:
            yield process
        finally:
            # Workers may be left in the group if the first process has ended.
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
