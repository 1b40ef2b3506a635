"""A class through ``gyro grade``, as it is used."""

from __future__ import annotations

import csv
import json
import math
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from grading.classes import make_folder
from msgspec import Struct
from typer.testing import CliRunner, Result

from classes.typed import Files
from gyrodata.cli import app


class Number(Struct, frozen=True):
    """What was measured; None for what is not there to be measured."""

    value: float | None
    low: float = -math.inf
    high: float = math.inf
    of: int | None = None
    """Out of how many."""
    digits: str = ".0f"
    told: str = ""
    """What else there is to tell."""

    @property
    def shown(self) -> str:
        if self.value is None:
            return "not there"
        return f"{self.value:{self.digits}}" + ("" if self.of is None else f" of {self.of}")

    @property
    def must_hold(self) -> str:
        if math.isinf(self.low) and math.isinf(self.high):
            return "-"
        return f"<= {self.high:{self.digits}}" if math.isinf(self.low) else f">= {self.low:{self.digits}}"

    @property
    def holds(self) -> bool:
        return self.value is not None and self.low <= self.value <= self.high


def gyro(*arguments: str | Path) -> Result:
    """Run the command line; a traceback is raised."""
    done = CliRunner().invoke(app, [str(argument) for argument in arguments], prog_name="gyro")
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    return done


def grade(files: Mapping[str, str | bytes], *arguments: str | Path) -> dict[str, Any]:
    """Grade a class of these files: the document of the grades, its students by key."""
    with tempfile.TemporaryDirectory() as folder:
        root = make_folder(Path(folder) / "class", files)
        done = gyro("grade", root, "--format", "json", "--workers", "1", "--quiet", *arguments)
    if done.exit_code > 1:
        raise RuntimeError(done.output)
    document: dict[str, Any] = json.loads(done.stdout)
    document["students"] = {student["student"]: student for student in document["students"]}
    return document


def lost(student: Mapping[str, Any]) -> dict[str, float]:
    """Points that a student did not get, by criterion; those that nobody judged are left out."""
    return {
        mark["criterion"]: mark["out_of"] - mark["points"]
        for mark in student["marks"]
        if mark.get("points") is not None
    }


def total(student: Mapping[str, Any]) -> float:
    """Points, with none for one that is not graded."""
    return float(student["points"] or 0.0)


@contextmanager
def on_disk(files: Files) -> Iterator[tuple[Path, Path]]:
    """Write a class, and name the folder for its grades."""
    with tempfile.TemporaryDirectory() as folder:
        yield make_folder(Path(folder) / "class", files), Path(folder) / "grades"


def rows_of(path: Path) -> dict[str, dict[str, str]]:
    """Read a table by student; nothing where there is none."""
    if not path.is_file():
        return {}
    with path.open(encoding="utf-8-sig", newline="") as table:
        return {row["student"]: row for row in csv.DictReader(table)}
