"""An ordinary rubric, as somebody writes it who has read the help and the printed one."""

from __future__ import annotations

import tempfile
from pathlib import Path

from grading.reports import reported_line

from classes import typed
from classes.drawn import draw
from classes.graded import Number, grade

ORDINARY = """schema = 1
points = 15
criterion = [
  { id = "completeness", check = "procedure", points = 5 },
  { id = "inertia", check = "reference", points = 5, full = "percent <= 5", zero = "percent >= 10" },
  { id = "uncertainty", check = "uncertainty", points = 3, full = "stated >= 1", zero = "stated <= 0" },
  { id = "plot", check = "files", points = 2, full = "files >= 1", zero = "files <= 0" },
]
[reference]
from = "class"
"""
"""Completeness 5, within 5 % of the reference 5, uncertainty stated 3, plot 2."""


def ordinary(size: int, seed: int) -> Number:
    """Give the rubric students of whom one has all, and each other lacks one thing."""
    students = [draw(i, seed + 8) for i in range(8)]
    files: typed.Files = {}
    expected = {}
    for i, student in enumerate(students):
        value, u = student.answer()
        far, silent, no_plot = i == 5, i == 6, i == 7
        answer = reported_line(value * (1.25 if far else 1), None if silent else u)
        files[f"{student.stem}_lab.csv"] = student.log(answer)
        if not no_plot:
            files[f"{student.stem}_plot.png"] = b"\x89PNG\r\n\x1a\n"
        expected[student.key] = 15.0 - 5 * far - 3 * silent - 2 * no_plot
    lines = len(ORDINARY.splitlines())
    with tempfile.TemporaryDirectory() as folder:
        rubric = Path(folder) / "rubric.toml"
        rubric.write_text(ORDINARY, encoding="utf-8")
        try:
            got = grade(files, "--rubric", rubric)["students"]
        except RuntimeError as refused:
            why = next((line for line in str(refused).splitlines() if "G7" in line), "")
            return Number(None, low=len(expected), of=len(expected), told=f"{lines} lines: {why.strip()[:110]}")
    right = sum(got[key]["points"] == points for key, points in expected.items())
    return Number(right, low=len(expected), of=len(expected), told=f"{lines} lines")
