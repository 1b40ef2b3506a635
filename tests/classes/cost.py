"""Whether the bytes that a class gets depend on how it was graded."""

from __future__ import annotations

import hashlib
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from grading.classes import make_folder
from grading.reports import reported_line

from classes.drawn import draw
from classes.graded import Number

COMMAND = [sys.executable, "-m", "gyrodata", "grade"]


def make_class(root: Path, size: int, seed: int) -> Path:
    """Write an ordinary class."""
    students = [draw(i, seed + 9) for i in range(size)]
    return make_folder(root, {f"{one.stem}_lab.csv": one.log(reported_line(*one.answer())) for one in students})


def contents(folder: Path) -> str:
    """Digest of every file that is handed on; the journal keeps the order in which grades were made."""
    digest = hashlib.sha256()
    for path in sorted(folder.rglob("*")):
        if path.is_file() and path.name != "journal.ndjson":
            digest.update(f"{path.relative_to(folder)}\0".encode() + path.read_bytes())
    return digest.hexdigest()


def grade_killed(root: Path, out: Path, after: int, *options: str | Path) -> None:
    """Start grading, and kill it once so many grades are in its journal."""
    journal = out / "journal.ndjson"
    before = journal.read_bytes().count(b"\n") if journal.is_file() else 0
    command = [*COMMAND, root, "-o", out, "--workers", "2", "--quiet", *options]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        while process.poll() is None:
            if journal.is_file() and journal.read_bytes().count(b"\n") >= before + after:
                break
            time.sleep(0.002)
    finally:
        process.kill()
        process.wait()


def same_bytes(size: int, seed: int) -> Number:
    """Grade a class with 1, 2 and 4 workers, after a kill, and from two journals put together."""
    size = min(size, 60)
    with tempfile.TemporaryDirectory() as folder:
        home = Path(folder)
        root = make_class(home / "class", size, seed)
        found = {}

        def run(name: str, workers: int = 2, of: Path = root) -> Path:
            out = home / "out" / name / "grades"
            command = [*COMMAND, of, "-o", out, "--workers", str(workers), "--quiet"]
            subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=True)
            found[name] = contents(out)
            return out

        for workers in (1, 2, 4):
            run(f"{workers} workers", workers)
        grade_killed(root, home / "out" / "killed" / "grades", size // 3)
        run("killed")
        together = home / "out" / "together" / "grades" / "journal.ndjson"
        together.parent.mkdir(parents=True)
        for half in range(2):
            part = home / f"half{half}" / "class"
            part.mkdir(parents=True)
            for path in sorted(root.iterdir())[half::2]:
                shutil.copyfile(path, part / path.name)
            out = run(f"half {half}", of=part)
            del found[f"half {half}"]
            with together.open("ab") as file:
                file.write((out / "journal.ndjson").read_bytes())
        run("together")
    unlike = [name for name, digest in found.items() if digest != found["1 workers"]]
    return Number(len(unlike), high=0, of=len(found), told=f"unlike one worker: {', '.join(unlike)}" if unlike else "")
