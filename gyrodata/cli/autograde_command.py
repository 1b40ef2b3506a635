"""``gyro autograde``: what an autograder of Gradescope runs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from typer import Argument

from gyrodata.base.disk import telling, write_whole
from gyrodata.cli.options import read_bytes


def autograde(
    root: Annotated[
        Path, Argument(metavar="ROOT", help="Folder of the autograder.")
    ] = Path("/autograder"),
) -> None:
    """Grade the one submission that a running autograder of Gradescope has.

    Called by its run_autograder.
    """
    from gyrodata.grading.exports.gradescope import grade_autograder
    from gyrodata.grading.rubric import read_rubric

    rubric = root / "source" / "rubric.toml"
    graded = grade_autograder(root, read_rubric(read_bytes(rubric), rubric.name))
    with telling(root, "grades_not_written"):
        write_whole(root / "results" / "results.json", [graded.encode()])
