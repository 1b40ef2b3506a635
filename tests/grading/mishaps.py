"""Work that goes wrong in every way that work can."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

import numpy as np


def work(task: str) -> str:
    """Do what the task says; "fine" is fine."""
    what, _, detail = task.partition(" ")
    if what == "hang":
        while True:
            pass
    if what == "sleep":
        time.sleep(float(detail))
    if what == "exit":
        os._exit(3)
    if what == "kill":
        os.kill(os.getpid(), signal.SIGKILL)
    if what == "memory":
        np.ones(10**12)
    if what == "deep":
        return work(task)
    if what == "raise":
        raise KeyError(detail)
    if what == "once":  # dies the first time only
        mark = Path(detail)
        if not mark.exists():
            mark.touch()
            os._exit(1)
    return f"{task} done"
