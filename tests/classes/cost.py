"""What a class costs, and whether its bytes hang on how it was graded."""

from __future__ import annotations

import ast
import hashlib
import io
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
import tokenize
from collections.abc import Callable
from functools import cache
from pathlib import Path

from grading.classes import make_folder
from grading.reports import reported_line

import gyrodata
from classes.drawn import draw
from classes.number import Number

COMMAND = [sys.executable, "-m", "gyrodata", "grade"]


def make_class(root: Path, size: int, seed: int) -> Path:
    """Write an ordinary class."""
    students = [draw(i, seed + 9) for i in range(size)]
    return make_folder(root, {f"{one.stem}_lab.csv": one.log(reported_line(*one.answer())) for one in students})


def metered(cache: Path, *arguments: str | Path) -> dict[str, float]:
    """CPU seconds of ``gyro grade`` alone and with its processes, its byte code kept as where it is installed."""
    meter = [sys.executable, str(Path(__file__).parent / "metered.py"), *COMMAND, *map(str, arguments)]
    kept = {"PYTHONDONTWRITEBYTECODE": "", "PYTHONPYCACHEPREFIX": str(cache)}
    done = subprocess.run(meter, capture_output=True, text=True, check=True, env=os.environ | kept)
    used: dict[str, float] = json.loads(done.stdout)
    if used["code"] > 1:
        raise RuntimeError(done.stderr)
    return used


def additions() -> str:
    """Tell how fast the processor is just now: CPU time stretches where others use it too."""
    begun, total = time.process_time(), 0
    for i in range(5_000_000):
        total += i
    return f"5 million additions {time.process_time() - begun:.2f} s"


@cache
def measured(size: int, seed: int) -> tuple[dict[str, float], dict[str, float], dict[str, float]]:
    """Grade five times as many logs, again with nothing changed, and a class of four: what the start costs."""
    with tempfile.TemporaryDirectory() as folder:
        home = Path(folder)
        root, few = make_class(home / "class", 5 * size, seed), make_class(home / "few", 4, seed)
        options = ("--workers", "2", "--quiet")
        metered(home / "cache", few, "-o", home / "first", *options)
        fresh = metered(home / "cache", root, "-o", home / "grades", *options)
        again = metered(home / "cache", root, "-o", home / "grades", *options)
        start = metered(home / "cache", few, "-o", home / "few-grades", *options)
    return fresh, again, start


def fresh(part: str, high: float) -> Callable[[int, int], Number]:
    """Measure CPU a log [ms]; what a class of four takes, which is the start, is told beside it."""

    def measure(size: int, seed: int) -> Number:
        used, _, start = measured(size, seed)
        logs = 5 * size
        whole = f"with the start {1000 * used[part] / logs:.2f}; four logs {start[part]:.2f} s"
        told = f"{logs} logs, {whole}; {additions()}"
        return Number(1000 * (used[part] - start[part]) / (logs - 4), high=high, digits=".2f", told=told)

    return measure


def unchanged(size: int, seed: int) -> Number:
    """Measure CPU of a second run [s]."""
    _, again, start = measured(size, seed)
    told = f"{5 * size} logs, parent {again['alone']:.1f} s; four logs {start['all']:.1f} s"
    return Number(again["all"], high=0.8, digits=".1f", told=told)


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
        names = sorted(path.name for path in root.iterdir())
        journals = []
        for half in range(2):
            part = home / f"half{half}" / "class"
            part.mkdir(parents=True)
            for name in names[half::2]:
                shutil.copyfile(root / name, part / name)
            out = run(f"half {half}", of=part)
            journals.append((out / "journal.ndjson").read_bytes())
            del found[f"half {half}"]
        together = home / "out" / "together" / "grades"
        together.mkdir(parents=True)
        (together / "journal.ndjson").write_bytes(b"".join(journals))
        run("together")
    unlike = [name for name, digest in found.items() if digest != found["1 workers"]]
    return Number(len(unlike), high=0, of=len(found), told=f"unlike one worker: {', '.join(unlike)}" if unlike else "")


CELLS = {
    "CPU a log, fresh [ms]": fresh("all", 6.5),
    "CPU a log of the parent, fresh [ms]": fresh("alone", 0.6),
    "CPU again, nothing changed [s]": unchanged,
    "other bytes for other workers, kills, journals": same_bytes,
}


# --- lines --------------------------------------------------------------------------------------------------


def code_lines(text: str) -> int:
    """Count lines of code: no docstrings, no remarks, nothing empty."""
    quiet = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER}
    lines: set[int] = set()
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type not in quiet:
            lines.update(range(token.start[0], token.end[0] + 1))
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            lines.difference_update(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    return len(lines)


def lines_of_code(size: int, seed: int) -> Number:
    """Count those of the room."""
    room = Path(gyrodata.__file__).parent / "grading"
    counts = {path: code_lines(path.read_text(encoding="utf-8")) for path in room.rglob("*.py")}
    return Number(sum(counts.values()), high=4300, told=f"{len(counts)} files")
