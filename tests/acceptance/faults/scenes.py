"""What is run while calls fail or it is killed: nothing may be torn or lost, and the
next run makes it whole.
"""

import contextlib
import io
import json
import os
import random
import re
import shutil
import subprocess
import sys
import time
import traceback
import zipfile
from collections.abc import Callable, Iterator
from contextlib import suppress
from multiprocessing import forkserver, resource_tracker
from pathlib import Path
from typing import NamedTuple

from places import SAMPLES
from processes import started
from typer.testing import CliRunner

from faults.calls import Calls
from gyrodata.cli import app

MINE = b"by hand\n"
LATER = (".gyro-lock", "journal.ndjson", "grades.json")
"""What may differ after a call that failed: the next run writes it."""
ENDS = {
    ".html": b"</html>",
    ".png": b"IEND\xaeB`\x82",
    ".csv": b"\n",
    ".md": b"\n",
    ".txt": b"\n",
}
GRADE = ("grade", "class", "-o", "grades", "--workers", "0", "--exit-zero")


class Done(NamedTuple):
    """How a run ended: its exit code, negative if it was killed, what it said, and its
    calls.
    """

    code: int
    told: str
    calls: list[str]


def run(words: tuple[str, ...], home: Path, calls: Calls) -> Done:
    """Run a command in a child of this process, which has loaded all code already."""
    told, seen = (
        home.with_name(f"{home.name}.told"),
        home.with_name(f"{home.name}.calls"),
    )
    child = os.fork()
    if not child:
        code = 70
        try:
            code = _child(words, home, calls, told)
        finally:
            with suppress(BaseException):
                os.close(
                    os.open(seen, os.O_CREAT | os.O_WRONLY)
                ) if calls.at else seen.write_text(
                    "\n".join(calls.seen), encoding="utf-8", errors="replace"
                )
            os._exit(code)
    _, status = os.waitpid(child, 0)
    texts = [
        path.read_text("utf-8", "replace") if path.exists() else ""
        for path in (told, seen)
    ]
    return Done(os.waitstatus_to_exitcode(status), texts[0], texts[1].splitlines())


def _child(words: tuple[str, ...], home: Path, calls: Calls, told: Path) -> int:
    os.chdir(home)
    told.write_bytes(b"")
    for number in (1, 2):
        os.dup2(os.open(told, os.O_WRONLY | os.O_APPEND), number)
    sys.stderr = io.TextIOWrapper(io.FileIO(2, "w"), "utf-8", write_through=True)
    # The servers of this process's parent are not its own.
    for server in (forkserver._forkserver, resource_tracker._resource_tracker):
        server.__init__()  # type: ignore[misc]
    calls.install()
    sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115 (counted too)
    sys.argv = ["gyro", *words]
    try:
        app()
    except SystemExit as end:
        with suppress(OSError):
            sys.stdout.flush()
        return end.code if isinstance(end.code, int) else 0 if end.code is None else 1
    except BaseException:
        traceback.print_exc()
        return 1
    return 0


def contents(folder: Path) -> dict[str, bytes]:
    """Every file below a folder."""
    paths = sorted(
        path for path in folder.rglob("*") if path.is_file() and not path.is_symlink()
    )
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in paths}


def a_log(home: Path) -> None:
    """Write one log, and the report of an earlier state of it with a file of the
    student's own.
    """
    (home / "log-report").mkdir(parents=True)
    shutil.copy(SAMPLES / "air_gyroscope.csv", home / "log.csv")
    for name, data in (
        ("results.json", b"of yesterday"),
        ("torque.svg", b"of yesterday"),
        ("mine.txt", MINE),
    ):
        (home / "log-report" / name).write_bytes(data)


def a_class(home: Path, size: int = 4) -> None:
    """Write a class."""
    (home / "class").mkdir(parents=True)
    for path in sorted((SAMPLES / "class").glob("*.csv"))[:size]:
        shutil.copy(path, home / "class")


def a_graded_class(home: Path) -> None:
    """Write a class that was graded; one log has changed since, and a person has
    changed the table and a page.
    """
    a_class(home)
    done = run(GRADE, home, Calls())
    assert done.code == 0, done.told
    table = home / "grades" / "grades.csv"
    table.write_bytes(
        re.sub(
            rb"(?m)^([^,]+,[^,]+,graded,)[0-9.]+",
            rb"\g<1>3.21",
            table.read_bytes(),
            count=1,
        )
        + MINE
    )
    next((home / "grades" / "feedback").glob("*.md")).write_bytes(MINE)
    log = min((home / "class").iterdir())
    log.write_bytes(log.read_bytes() + b"# a line more\n")


SCENES: dict[str, tuple[tuple[str, ...], Callable[[Path], None], str]] = {
    "analyze again": (("analyze", "log.csv"), a_log, "log-report"),
    "analyze -o FILE": (
        ("analyze", "log.csv", "-f", "json", "-o", "data/log.json"),
        a_log,
        "data",
    ),
    "grade again": (GRADE, a_graded_class, "grades"),
    "grade with workers": ((*GRADE, "--workers", "2"), a_class, "grades"),
}
"""A command, what is there before, and the folder that it writes."""


class Promise:
    """What a scene leaves behind without any fault, and what must be the same with one."""

    def __init__(self, name: str, room: Path) -> None:
        self.room = room
        self.words, make, self.folder = SCENES[name]
        make(room / "before")
        # The first run is in this process: each child then has the code and fonts that
        # it loads.
        shutil.copytree(room / "before", room / "first")
        with contextlib.chdir(room / "first"):
            assert CliRunner().invoke(app, self.words).exit_code == 0
        shutil.copytree(room / "before", room / "after")
        undisturbed = run(self.words, room / "after", Calls())
        assert undisturbed.code == 0, undisturbed.told
        self.before, self.after = (
            self._found(room / "before"),
            self._found(room / "after"),
        )
        self.calls = undisturbed.calls

    def _found(self, home: Path) -> dict[str, bytes]:
        return contents(home / self.folder)

    def break_at(self, at: int, way: str, lasting: bool = False) -> list[str]:
        """Let a call fail, run the command again, and give what is wrong."""
        home = self.room / f"{at}-{way}"
        shutil.copytree(self.room / "before", home)
        call = (
            self.calls[at - 1].replace(str(self.room), "")
            if at <= len(self.calls)
            else "?"
        )
        wrong = [
            f"call {at} ({call}), {way}: {told}"
            for told in self._wrong(home, call, Calls(at, way, lasting))
        ]
        shutil.rmtree(home)
        return wrong

    def _wrong(self, home: Path, call: str, calls: Calls) -> Iterator[str]:
        done = run(self.words, home, calls)
        found = self._found(home)
        if "Traceback" in done.told or "Exception ignored" in done.told:
            yield f"a traceback: {done.told[-400:]}"
        if calls.way != "kill":
            # A log that cannot be read is not graded, with the reason.
            if done.code == 0 and not re.search(
                "no feedback for|cannot be read: ", done.told
            ):
                if other := [
                    name for name in differing(found, self.after) if name not in LATER
                ]:
                    yield f"exit code 0 with other files: {other}"
            elif done.code not in (0, 1, 2, 3):
                yield f"exit code {done.code}: {done.told[-300:]}"
            elif not re.search(
                r"error G\d{3}: |no feedback for|cannot be read: ", done.told
            ):
                yield f"no message: {done.told[-300:]!r}"
            rests = [name for name in found if ".gyro-" in name]
            if rests and not call.startswith(("unlink", "rmdir", "scandir", "open")):
                yield f"left behind: {rests}"
        for name, data in found.items():
            if data not in (self.before.get(name), self.after.get(name)) and not whole(
                name, data
            ):
                yield f"{name} is torn"
        mine = [data for data in self.before.values() if MINE in data]
        yield from (
            "what a person wrote is lost" for data in mine if data not in found.values()
        )
        again = run(self.words, home, Calls())
        if again.code:
            yield f"the next run ends with {again.code}: {again.told[-300:]}"
        now = {
            name: data
            for name, data in self._found(home).items()
            if not name.startswith("published/")
        }
        if wrong := differing(
            now,
            {
                name: self.after[name]
                for name in self.after
                if name in now or "/" not in name
            },
        ):
            yield f"after the next run these are not as they should be: {wrong}"


def whole(name: str, data: bytes) -> bool:
    """Whether a file ends as it must; a journal may end in half a line."""
    ending = Path(name).suffix
    if ".gyro-" in name or ending == ".ndjson":
        return True
    if ending == ".json":
        with suppress(ValueError):
            return bool(json.loads(data))
        return False
    if ending == ".zip":
        return zipfile.is_zipfile(io.BytesIO(data))
    return data.endswith((ENDS[ending], ENDS[ending] + b"\n"))


def differing(one: dict[str, bytes], other: dict[str, bytes]) -> list[str]:
    return sorted(
        name for name in one.keys() | other.keys() if one.get(name) != other.get(name)
    )


def start(home: Path) -> contextlib.AbstractContextManager[subprocess.Popen[bytes]]:
    """Start to grade the class of a folder with two workers."""
    line = [sys.executable, "-m", "gyrodata", *GRADE, "--workers", "2"]
    env = {**os.environ, "PYTHONPATH": str(SAMPLES.parent)}
    return started(
        line, cwd=home, env=env, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
    )


def try_kills(room: Path, count: int, seed: int, size: int = 20) -> Iterator[str]:
    """Kill runs with workers, so many in all, and give what is wrong after the next
    run.
    """
    draw = random.Random(seed)
    a_class(room / "whole", size)
    begun = time.perf_counter()
    with start(room / "whole") as driver:
        told = driver.communicate()[1]
    assert driver.returncode == 0, told
    took, whole = time.perf_counter() - begun, contents(room / "whole" / "grades")
    for number in range(count):
        home = room / f"{number}"
        shutil.copytree(room / "whole" / "class", home / "class")
        wait = draw.uniform(0.1, took)
        where = f"kill {number} after {wait:.2f} s"
        with start(home) as driver:
            time.sleep(wait)
            driver.kill()
            driver.communicate()
        with start(home) as again:
            told = again.communicate()[1].decode("utf-8", "replace")
        if again.returncode != 0:
            yield f"{where}: the next run ends with {again.returncode}: {told[-300:]}"
        if wrong := differing(contents(home / "grades"), whole):
            yield f"{where}: after the next run these are not as they should be: {wrong}"
        shutil.rmtree(home)
