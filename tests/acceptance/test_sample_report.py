"""The report in sample_data/ is what the code writes; ``python
tests/make_sample_report.py`` writes it anew.
"""

from __future__ import annotations

import re
from pathlib import Path

from documents import Steady
from make_sample_report import REPORT, make

FIGURES = ["period.svg", "product.svg", "residuals.svg", "torque.svg"]


def texts(path: Path) -> str:
    """The texts of a figure, and the number of its marks and lines.

    Another release of matplotlib moves them a little.
    """
    drawing = path.read_text("utf-8")
    parts = re.findall(r"<text[^>]*>(.*?)</text>", drawing)
    return "\n".join([*parts, f"{drawing.count('<use')} {drawing.count('<path')}"])


def page(path: Path) -> str:
    """A text without the figures in it."""
    return re.sub(r'"data:[^"]*"', '""', path.read_text("utf-8"))


def test_the_stored_report_is_what_the_command_writes(tmp_path: Path) -> None:
    make(tmp_path / "report")
    names = sorted([*FIGURES, "report.html", "results.json", "runs.csv"])
    for folder in (REPORT, tmp_path / "report"):
        assert sorted(path.name for path in folder.iterdir()) == names
    for name in names:
        content = texts if name in FIGURES else page
        kept, made = (
            Steady(content(folder / name)) for folder in (REPORT, tmp_path / "report")
        )
        assert kept == made, name
