"""A class through ``gyro grade``, as it is used."""

import json
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from grading.classes import make_folder
from typer.testing import CliRunner, Result

from gyrodata.cli import app


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
        done = gyro("grade", root, "--format", "json", "--workers", "0", "--quiet", *arguments)
    assert done.exit_code <= 1, done.output
    document: dict[str, Any] = json.loads(done.stdout)
    document["students"] = {student["student"]: student for student in document["students"]}
    return document
