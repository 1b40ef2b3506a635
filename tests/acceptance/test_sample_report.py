"""The report in sample_data/ is what the code writes; ``python
tests/make_sample_report.py`` writes it anew.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from documents import Steady
from make_sample_report import REPORT, make
from PIL import Image

FIGURES = ["period.png", "product.png", "residuals.png", "torque.png"]


def dots(path: Path) -> np.ndarray:
    with Image.open(path) as image:
        return np.asarray(image.convert("RGB"), dtype=float)


def test_the_stored_report_is_what_the_command_writes(tmp_path: Path) -> None:
    make(tmp_path / "report")
    names = sorted([*FIGURES, "report.html", "results.json", "runs.csv"])
    for folder in (REPORT, tmp_path / "report"):
        assert sorted(path.name for path in folder.iterdir()) == names
    for name in set(names) - set(FIGURES):
        kept, made = (
            Steady((folder / name).read_text("utf-8"))
            for folder in (REPORT, tmp_path / "report")
        )
        assert kept == made, name
    for name in FIGURES:
        kept, made = (dots(folder / name) for folder in (REPORT, tmp_path / "report"))
        assert kept.shape == made.shape
        # Another release of matplotlib or of the font library moves edges by a part of
        # a dot. A dot everywhere makes 3.
        assert np.abs(kept - made).mean() < 3, name
