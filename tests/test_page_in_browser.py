"""The page in a real browser: no error, no request, no scrolling sideways on a phone, sorting, whole prints."""

from __future__ import annotations

import io
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from browser import browse, look_at, needs_browser
from pages import LOG, make_page
from PIL import Image

from gyrodata import analyze, plotting
from gyrodata.results import Analysis

PDFTOPPM = shutil.which("pdftoppm")
pytestmark = needs_browser

# Looks at the page inside a frame as wide as a small phone.
PROBE = """<script>
addEventListener("load", () => {
  const frame = document.querySelector("iframe"), view = frame.contentWindow, page = frame.contentDocument;
  const table = page.querySelector("table.sortable"), heads = [...table.tHead.rows[0].cells];
  const sort = i => {
    heads[i].querySelector("button").click();
    return [[...table.tBodies[0].rows].map(r => r.cells[i].textContent), heads.map(h => h.getAttribute("aria-sort"))];
  };
  const button = heads[4].querySelector("button");
  button.focus();
  const out = {
    wide: page.documentElement.scrollWidth, inner: frame.clientWidth,
    figures: [...page.querySelectorAll("figure img")].map(i => i.getBoundingClientRect().width),
    broken: [...page.images].filter(i => !i.naturalWidth).length,
    requests: view.performance.getEntriesByType("resource").map(r => r.name).filter(n => !n.startsWith("data:")),
    focused: page.activeElement === button, outline: view.getComputedStyle(button).outlineStyle,
    heads: heads.map(h => h.textContent),
    up: sort(4), down: sort(4), names: sort(0),
    beyond: [...page.querySelectorAll("p *, li *, dd *, h1 *, h2 *, h3 *")]
      .filter(e => e.getBoundingClientRect().right > frame.clientWidth).map(e => e.textContent),
  };
  const place = document.createElement("pre");
  place.id = "out"; place.textContent = JSON.stringify(out); document.body.append(place);
});
</script>"""


@pytest.fixture(scope="module")
def analysis() -> Analysis:
    return analyze(LOG.encode(), name="log<1>.csv")


def test_on_a_phone(analysis: Analysis, tmp_path: Path) -> None:
    out = look_at(tmp_path, make_page(analysis, plotting.render(analysis)), 360, PROBE)
    assert out["broken"] == 0
    # From edge to edge: only so are their letters large enough.
    assert min(out["figures"]) > 340
    assert out["requests"] == []
    assert out["focused"]

    times = [f"{run.time:.4g}" for run in sorted(analysis.run_table, key=lambda run: run.time)]
    assert out["heads"][4] == "time [s]"
    assert out["up"] == [times, [None] * 4 + ["ascending"] + [None] * 5]
    assert out["down"] == [times[::-1], [None] * 4 + ["descending"] + [None] * 5]
    assert out["names"][0] == ["<b>3", "1", "2", "4", "5", "6", "7", "8", "9", "10"]


def magenta(name: str) -> bytes:
    """A figure that a page of print can be searched for: one colour, 660 by 420."""
    file = io.BytesIO()
    Image.new("RGB", (660, 420), (255, 0, 200 + 10 * plotting.FIGURES.index(name))).save(file, "png")
    return file.getvalue()


@pytest.mark.skipif(PDFTOPPM is None, reason="no pdftoppm on this machine")
def test_print_has_whole_figures(analysis: Analysis, tmp_path: Path) -> None:
    page = make_page(analysis, {name: magenta(name) for name in plotting.FIGURES})
    file = tmp_path / "page.html"
    file.write_text(page, "utf-8")
    browse(tmp_path, file, f"--print-to-pdf={tmp_path / 'page.pdf'}", "--no-pdf-header-footer")
    subprocess.run([str(PDFTOPPM), "-r", "60", "-png", tmp_path / "page.pdf", tmp_path / "sheet"], check=True)
    shades = []
    for sheet in sorted(tmp_path.glob("sheet*.png")):
        with Image.open(sheet) as image:
            dots = np.asarray(image.convert("RGB")).astype(int)
        ink = (dots[..., 0] > 240) & (dots[..., 1] < 60) & (dots[..., 2] > 180)
        for shade in sorted({int(v) for v in dots[ink][:, 2] if v % 10 == 0}):
            rows, columns = np.nonzero(ink & (np.abs(dots[..., 2] - shade) < 4))
            shades.append(shade)
            assert (np.ptp(columns) + 1) / (np.ptp(rows) + 1) == pytest.approx(660 / 420, rel=0.02)
            assert (np.ptp(columns) + 1) / 60 > 4.5, "inches"
    assert shades == [200, 210, 220, 230]
