"""What is run while calls fail, and what has to hold then: nothing torn, nothing lost, a message, and the next run."""

from __future__ import annotations

import io
import json
import os
import re
import shutil
import sys
import zipfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from multiprocessing import forkserver, resource_tracker
from pathlib import Path
from typing import Any

from classes.cost import make_class
from msgspec import Struct
from msgspec.structs import replace
from typer.testing import CliRunner

from faults.calls import Calls
from gyrodata.disk import LOCK

MINE = b"by hand\n"

REPORT = "log-report"

SAMPLE = Path(__file__).parent.parent.parent / "sample_data" / "air_gyroscope.csv"


class Done(Struct, frozen=True):
    """How a run ended."""

    code: int
    """As a shell has it: that of a process that was killed is negative."""
    told: str
    """On standard error."""
    shown: str
    """On standard output."""
    calls: list[str]


class Scene(Struct, frozen=True):
    """A command, the files that it finds, and the folder that it writes."""

    name: str
    words: tuple[str, ...]
    make: Callable[[Path], object]
    """Write what is there before."""
    folder: str = ""
    watched: bool = False


def run(scene: Scene, home: Path, calls: Calls) -> Done:
    """Run the command in a child of this process, which has loaded all code already."""
    out, err, seen = (home.with_name(f"{home.name}.{one}") for one in ("out", "err", "calls"))
    child = os.fork()
    if not child:
        code = 70
        try:
            code = _child(scene, home, calls, out, err)
        finally:
            with suppress(BaseException):
                os.close(os.open(seen, os.O_CREAT | os.O_WRONLY)) if calls.at else seen.write_text(
                    "\n".join(calls.seen), encoding="utf-8", errors="replace"
                )
            os._exit(code)
    _, status = os.waitpid(child, 0)
    told = [path.read_text("utf-8", "replace") if path.exists() else "" for path in (err, out, seen)]
    for path in (out, err, seen):
        path.unlink(missing_ok=True)
    return Done(os.waitstatus_to_exitcode(status), told[0], told[1], told[2].splitlines())


def _child(scene: Scene, home: Path, calls: Calls, out: Path, err: Path) -> int:
    from gyrodata.cli import app, watching

    os.chdir(home)
    for number, path in ((1, out), (2, err)):
        os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), number)
    sys.stderr = io.TextIOWrapper(io.FileIO(2, "w"), "utf-8", write_through=True)
    if scene.watched:
        watching.watch.__defaults__ = (_saves(home),)
    # Those that serve this process's parent are not its own.
    for server in (forkserver._forkserver, resource_tracker._resource_tracker):
        server.__init__()  # type: ignore[misc]
    calls.install()
    sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115 (counted too)
    sys.argv = ["gyro", *scene.words]
    try:
        app()
    except SystemExit as end:
        with suppress(OSError):
            sys.stdout.flush()
        return end.code if isinstance(end.code, int) else 0 if end.code is None else 1
    except BaseException:
        import traceback

        traceback.print_exc()
        return 1
    return 0


def warm_up(scene: Scene, room: Path) -> None:
    """Run the command here once: what it loads is there in every child, and no log is worked out twice."""
    import gyrodata.analysis
    import gyrodata.reporting
    from gyrodata.cli import app

    for module, name in ((gyrodata.analysis, "analyze_readings"), (gyrodata.reporting, "report_files")):
        if not hasattr(getattr(module, name), "known"):
            setattr(module, name, _remembered(getattr(module, name)))
    before = Path.cwd()
    shutil.copytree(room / "before", room / "warm")
    os.chdir(room / "warm")
    try:
        done = CliRunner().invoke(app, scene.words)
    finally:
        os.chdir(before)
    assert done.exit_code == 0, done.output
    shutil.rmtree(room / "warm")


def _remembered(call: Callable[..., Any]) -> Callable[..., Any]:
    """Give what was found before for the same log."""
    known: dict[str, Any] = {}

    def remembered(found: Any, *given: Any, **named: Any) -> Any:
        key = f"{found.sha256} {given} {named}"
        if key not in known:
            known[key] = call(found, *given, **named)
        return known[key]

    remembered.known = known  # type: ignore[attr-defined]
    return remembered


def _saves(home: Path) -> Callable[[float], None]:
    """Save the log anew between two looks, and press Ctrl-C after some more."""
    looks = 0
    other = SAMPLE.read_bytes().replace(b"13.06", b"13.16")
    write, real = os.write, os.open

    def sleep(_: float) -> None:
        nonlocal looks
        looks += 1
        if looks == 2:
            number = real(home / "log.csv", os.O_WRONLY | os.O_TRUNC)
            write(number, other)
            os.close(number)
        if looks == 8:
            raise KeyboardInterrupt

    return sleep


# --- what is there ------------------------------------------------------------------------------------------


def contents(folder: Path) -> dict[str, bytes]:
    """Every file below a folder."""
    paths = (path for path in folder.rglob("*") if path.is_file() and not path.is_symlink())
    return {path.relative_to(folder).as_posix(): _content(path) for path in sorted(paths)}


def _content(path: Path) -> bytes:
    """Give what a file holds; without the record of a run, which only spares the next one work."""
    data = path.read_bytes()
    if path.name != "journal.ndjson":
        return data
    return b"".join(line for line in data.splitlines(keepends=True) if not line.startswith(b'{"schema": "gyro.run/1"'))


def log_alone(home: Path) -> None:
    """Lay down one log."""
    home.mkdir()
    shutil.copy(SAMPLE, home / "log.csv")


def log_with_report(home: Path) -> None:
    """Lay down a log, the report of an earlier state of it, and a file of the student's own in it."""
    log_alone(home)
    for name in ("results.json", "report.html", "runs.csv", "torque.png"):
        (home / REPORT).mkdir(exist_ok=True)
        (home / REPORT / name).write_bytes(b"of yesterday")
    (home / REPORT / "mine.txt").write_bytes(MINE)


def class_alone(home: Path, size: int = 20) -> None:
    """Lay down a class."""
    home.mkdir()
    make_class(home / "class", size, 1)


SCENES = (
    Scene("analyze", ("analyze", "log.csv"), log_alone, REPORT),
    Scene("analyze again", ("analyze", "log.csv"), log_with_report, REPORT),
    Scene("analyze -o FILE", ("analyze", "log.csv", "-f", "json", "-o", "data/log.json"), log_alone, "data"),
    Scene("check", ("check", "log.csv"), log_alone),
    Scene("watch", ("analyze", "log.csv", "--watch"), log_alone, watched=True),
    Scene("grade", ("grade", "class", "-o", "grades", "--workers", "0"), class_alone, "grades"),
)


class Graded:
    """A class that was graded before: one log has changed since, and a person has changed the table and a page."""

    def __init__(self, home: Path, scene: Scene) -> None:
        self.home = home
        scene.make(home)
        done = run(scene, home, Calls())
        assert done.code == 0, done.told
        table = home / "grades" / "grades.csv"
        table.write_bytes(
            re.sub(rb"(?m)^([^,]+,[^,]+,graded,)[0-9.]+", rb"\g<1>3.21", table.read_bytes(), count=1) + b"," + MINE
        )
        page = next((home / "grades" / "feedback").glob("*.md"))
        page.write_bytes(MINE)
        log = sorted((home / "class").iterdir())[1]
        log.write_bytes(log.read_bytes() + b"# a line more\n")

    def __call__(self, home: Path) -> None:
        shutil.copytree(self.home, home)


NAMES = (*(scene.name for scene in SCENES), "grade again", "grade with workers")


def scene_of(name: str, room: Path, size: int = 20) -> Scene:
    """Give a scene by its name; `size`: students of a class."""
    known = {scene.name: scene for scene in SCENES}
    if name in known and name != "grade":
        return known[name]
    grade = replace(known["grade"], make=lambda home: class_alone(home, size))
    if name == "grade":
        return grade
    if name == "grade again":
        return Scene(name, grade.words, Graded(room / "graded", grade), grade.folder)
    return Scene(name, (*grade.words[:-1], "2"), grade.make, grade.folder)


# --- what has to hold ---------------------------------------------------------------------------------------


class Promise:
    """What a scene leaves behind without any fault, and what must not be otherwise with one."""

    def __init__(self, scene: Scene, room: Path) -> None:
        self.scene, self.room = scene, room
        before, after = room / "before", room / "after"
        scene.make(before)
        self.before = contents(before / scene.folder) if scene.folder else {}
        shutil.copytree(before, after)
        if not scene.watched:
            warm_up(scene, room)
        self.undisturbed = run(scene, after, Calls())
        assert self.undisturbed.code in (0, 130), self.undisturbed.told
        self.after = contents(after / scene.folder) if scene.folder else {}
        self.calls = self.undisturbed.calls
        # What a person wrote there.
        self.mine = {name: data for name, data in self.before.items() if MINE in data}

    def break_at(self, at: int, way: str, lasting: bool = False) -> list[str]:
        """Let the call fail, run the command again, and give what does not hold."""
        home = self.room / f"{at}-{way}"
        shutil.copytree(self.room / "before", home)
        where = f"{self.scene.name}, call {at} ({self._call(at)}), {way}{' from there on' if lasting else ''}"
        try:
            return [f"{where}: {wrong}" for wrong in self._wrong(home, at, way, lasting)]
        finally:
            shutil.rmtree(home)

    def _call(self, at: int) -> str:
        return self.calls[at - 1].replace(str(self.room), "") if at <= len(self.calls) else "?"

    def _wrong(self, home: Path, at: int, way: str, lasting: bool) -> Iterator[str]:
        scene = self.scene
        done = run(scene, home, Calls(at, way, lasting))
        found = contents(home / scene.folder) if scene.folder else {}
        if "Traceback" in done.told or "Exception ignored" in done.told:
            yield f"a traceback: {done.told[-400:]}"
        if way != "kill":
            yield from self._ends_in_words(done, found)
            rests = [name for name in found if ".gyro-" in name]
            if rests and not self._call(at).startswith(("unlink", "rmdir", "scandir", "open")):
                yield f"left behind: {rests}"
        if "error G603" in done.told and scene.folder == REPORT and not self._call(at).startswith("replace"):
            kept = {name: data for name, data in found.items() if ".gyro-" not in name}
            yield from (f"{name} is not as it was" for name in _differing(kept, self.before))
        for name, data in found.items():
            if data not in (self.before.get(name), self.after.get(name)) and not _whole(name, data):
                yield f"{name} is torn"
        yield from (f"{name} is lost" for name, data in self.mine.items() if data not in found.values())
        yield from (f"the grade of {student} is lost" for student in _graded(self.before) - _graded(found))
        again = run(scene, home, Calls())
        if again.code != self.undisturbed.code:
            yield f"the next run ends with {again.code}: {again.told[-300:]}"
        # What was published in between stays as what it is.
        now = {
            name: data
            for name, data in contents(home / scene.folder).items()
            if name in self.after or not name.startswith("published/")
        }
        if scene.folder and (wrongs := _differing(now, self.after)):
            yield f"after the next run these are not as they should be: {wrongs}"

    def _ends_in_words(self, done: Done, found: Mapping[str, bytes]) -> Iterator[str]:
        if done.code == self.undisturbed.code:
            # A lock that nobody holds any more does no harm; a log that was read once only is graded again.
            aside = (LOCK, "journal.ndjson", "grades.json")
            if self.scene.folder and (other := [name for name in _differing(found, self.after) if name not in aside]):
                yield f"exit code {done.code} with other files: {other}"
        elif done.code == 1:
            if "no feedback for" not in done.told and b",not graded," not in found.get("grades.csv", b""):
                yield f"exit code 1 says that a log is wrong: {done.told[-300:]}"
        elif done.code not in (2, 3):
            yield f"exit code {done.code}: {done.told[-300:]}"
        elif not re.search(r"error G\d{3}: ", done.told + done.shown):
            yield f"no message: {done.told[-300:]!r}"


_ENDS = {".html": b"</html>", ".png": b"IEND\xaeB`\x82", ".csv": b"\n", ".md": b"\n", ".txt": b"\n"}


def _whole(name: str, data: bytes) -> bool:
    """Tell whether a file is as it is meant to be by its end, or by what reads it; a journal may end in half a line."""
    ending = Path(name).suffix
    if ".gyro-" in name or ending == ".ndjson":
        return True
    try:
        if ending == ".json":
            json.loads(data)
            return True
        if ending == ".zip":
            return zipfile.ZipFile(io.BytesIO(data)).testzip() is None
    except (ValueError, zipfile.BadZipFile):
        return False
    return data.endswith((_ENDS[ending], _ENDS[ending] + b"\n"))


def _graded(found: Mapping[str, bytes]) -> set[str]:
    """Whose grade stands in the journal."""
    students = set()
    for line in found.get("journal.ndjson", b"").splitlines():
        with suppress(ValueError):
            students.add(json.loads(line).get("student"))
    return students - {None}


def _differing(one: Mapping[str, bytes], other: Mapping[str, bytes]) -> list[str]:
    return sorted(name for name in one.keys() | other.keys() if one.get(name) != other.get(name))
