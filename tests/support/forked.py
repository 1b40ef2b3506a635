"""Commands and scripts in a fork of the process of the tests, which has loaded the code
already: a new process needs half a second for that.

Exit codes, streams, the folder and the environment are those of a process. What begins
before the code is loaded is not tested by a fork: a test of the start, of a pipe or of a
signal needs a new process.
"""

from __future__ import annotations

import io
import os
import runpy
import subprocess
import sys
import tempfile
import traceback
import warnings
from collections.abc import Callable, Mapping
from pathlib import Path

from gyrodata.__main__ import main

QUIET = (
    DeprecationWarning,
    PendingDeprecationWarning,
    ImportWarning,
    ResourceWarning,
)
"""Warnings that Python ignores without options."""


def run_gyro(
    words: list[str],
    folder: Path,
    environment: Mapping[str, str] | None = None,
    begin: Callable[[], object] = lambda: None,
) -> subprocess.CompletedProcess[str]:
    """Run a command of gyro; `begin` is called first in the new process."""
    # The tests of the command line load the same: the next fork has it.
    import gyrodata.cli  # noqa: F401

    return _run(main, ["gyro", *words], folder, environment, begin)


def run_script(
    script: Path, folder: Path, environment: Mapping[str, str] | None = None
) -> subprocess.CompletedProcess[str]:
    """Run a script of Python."""

    def execute() -> None:
        sys.path.insert(0, str(script.parent))
        runpy.run_path(str(script), run_name="__main__")

    return _run(execute, [str(script)], folder, environment, lambda: None)


def _run(
    call: Callable[[], object],
    argv: list[str],
    folder: Path,
    environment: Mapping[str, str] | None,
    begin: Callable[[], object],
) -> subprocess.CompletedProcess[str]:
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as errors:
        child = os.fork()
        if not child:
            code = 70
            # Whatever happens, the fork does not go on with the tests.
            try:
                _become(argv, folder, environment, (out.fileno(), errors.fileno()))
                code = _exit_code(call, begin)
            finally:
                os._exit(code)
        _, status = os.waitpid(child, 0)
        shown = [_text(stream) for stream in (out, errors)]
    return subprocess.CompletedProcess(
        argv, os.waitstatus_to_exitcode(status), shown[0], shown[1]
    )


def _text(stream: io.BufferedIOBase) -> str:
    stream.seek(0)
    return stream.read().decode("utf-8", "replace")


def _become(
    argv: list[str],
    folder: Path,
    environment: Mapping[str, str] | None,
    streams: tuple[int, int],
) -> None:
    """Set what a new process has: streams, arguments, folder, environment, warnings."""
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    for number, stream in enumerate(streams, 1):
        os.dup2(stream, number)
    sys.stdin = open(0, encoding="utf-8", closefd=False)  # noqa: SIM115
    sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
    sys.stderr = io.TextIOWrapper(
        io.FileIO(2, "w", closefd=False),
        "utf-8",
        "backslashreplace",
        write_through=True,
    )
    sys.argv = argv
    os.chdir(folder)
    if environment is not None:
        os.environ.clear()
        os.environ.update(environment)
    warnings.resetwarnings()
    for category in QUIET:
        warnings.simplefilter("ignore", category)


def _exit_code(call: Callable[[], object], begin: Callable[[], object]) -> int:
    """Call a function, and return the exit code that its process would have."""
    code: object = None
    try:
        begin()
        call()
    except SystemExit as end:
        code = end.code
    except BaseException:
        traceback.print_exc()
        code = 1
    sys.stdout.flush()
    sys.stderr.flush()
    if isinstance(code, str):
        print(code, file=sys.stderr)
        return 1
    return int(code or 0)  # type: ignore[call-overload]
