"""The report in sample_data/ is what the code writes; ``python tests/make_sample_report.py`` writes it anew."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from documents import Steady
from make_sample_report import REPORT, make
from PIL import Image

FIGURES = ["period.png", "product.png", "residuals.png", "torque.png"]


@pytest.fixture(scope="module")
def fresh(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sample") / "report"
    make(folder)
    return folder


def dots(path: Path) -> np.ndarray:
    with Image.open(path) as image:
        return np.asarray(image.convert("RGB"), dtype=float)


def test_the_same_files(fresh: Path) -> None:
    names = sorted(path.name for path in REPORT.iterdir())
    assert names == sorted([*FIGURES, "report.html", "results.json", "runs.csv"])
    assert names == sorted(path.name for path in fresh.iterdir())
    assert sum(path.stat().st_size for path in REPORT.iterdir()) < 400_000


@pytest.mark.parametrize("name", ["results.json", "runs.csv", "report.html"])
def test_the_same_numbers_and_words(name: str, fresh: Path) -> None:
    kept, made = ((folder / name).read_text(encoding="utf-8") for folder in (REPORT, fresh))
    assert Steady(kept) == Steady(made)


@pytest.mark.parametrize("name", FIGURES)
def test_the_same_figures(name: str, fresh: Path) -> None:
    kept, made = (dots(folder / name) for folder in (REPORT, fresh))
    assert kept.shape == made.shape
    # Another release of matplotlib or of the font library moves edges by a part of a dot.
    # A dot everywhere makes 3.
    assert np.abs(kept - made).mean() < 3


def test_the_page_holds_the_figures_beside_it() -> None:
    import base64

    page = (REPORT / "report.html").read_text(encoding="utf-8")
    shown = [base64.b64decode(text) for text in re.findall(r"data:image/png;base64,([A-Za-z0-9+/=]+)", page)]
    assert sorted(shown) == sorted((REPORT / name).read_bytes() for name in FIGURES)
