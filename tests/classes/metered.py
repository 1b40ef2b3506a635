"""``python tests/classes/metered.py COMMAND…`` prints the CPU seconds of a command alone, and with all that it starts.

And the most memory that the command itself has held [MB].

A server of processes outlives who asked for it, and its time is in nobody's account but that of a parent that takes it
in: this process does (Linux only).
"""

from __future__ import annotations

import ctypes
import json
import os
import resource
import subprocess
import sys
from pathlib import Path

PR_SET_CHILD_SUBREAPER = 36


def main() -> None:
    """Run the command to its end, and that of all that it started."""
    if ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0) != 0:
        raise OSError("this system does not give orphans to a process that asks for them")
    process = subprocess.Popen(sys.argv[1:], stdout=subprocess.DEVNULL)
    # While it is ended and not yet reaped, the system still tells its own time from that of its children.
    os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)
    fields = Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
    alone = (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    _, status, own = os.wait4(process.pid, 0)
    code = process.returncode = os.waitstatus_to_exitcode(status)
    try:
        while True:
            os.wait()
    except ChildProcessError:
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(
        json.dumps({"code": code, "alone": alone, "all": used.ru_utime + used.ru_stime, "peak": own.ru_maxrss / 1024})
    )


if __name__ == "__main__":
    main()
