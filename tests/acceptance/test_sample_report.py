"""The report in sample_data/, and the list of its figures in the gallery, are what the
code writes; ``python tests/renew.py`` writes them anew.
"""

from __future__ import annotations

from pathlib import Path

from documents import Steady
from make_sample_report import FILES, GALLERY, REPORT, gallery, make, said


def test_the_stored_report_is_what_the_command_writes(tmp_path: Path) -> None:
    made = tmp_path / "report"
    make(made)
    for folder in (REPORT, made):
        assert sorted(path.name for path in folder.iterdir()) == FILES
    for name in FILES:
        assert Steady(said(REPORT / name)) == Steady(said(made / name)), name


def test_the_gallery_shows_every_figure_of_the_report() -> None:
    assert GALLERY.read_text(encoding="utf-8") == gallery()
