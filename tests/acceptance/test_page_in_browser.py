"""The page in a real browser: no error, no request, no scrolling sideways on a phone,
sorting.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from browser import look_at, needs_browser
from pages import LOG, make_page

from gyrodata import analyze
from gyrodata.reporting.figures import render
from gyrodata.results import Analysis

pytestmark = needs_browser

# Looks at the page inside a frame as wide as a small phone.
PROBE = """<script>
addEventListener("load", () => {
  const frame = document.querySelector("iframe");
  const view = frame.contentWindow, page = frame.contentDocument;
  const table = page.querySelector("table.sortable"), heads = [...table.tHead.rows[0].cells];
  const sort = i => {
    heads[i].querySelector("button").click();
    const cells = [...table.tBodies[0].rows].map(r => r.cells[i].textContent);
    return [cells, heads.map(h => h.getAttribute("aria-sort"))];
  };
  const button = heads[4].querySelector("button");
  button.focus();
  const out = {
    wide: page.documentElement.scrollWidth, inner: frame.clientWidth,
    figures: [...page.querySelectorAll("figure img")].map(i => i.getBoundingClientRect().width),
    broken: [...page.images].filter(i => !i.naturalWidth).length,
    requests: view.performance.getEntriesByType("resource")
      .map(r => r.name).filter(n => !n.startsWith("data:")),
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
    out = look_at(
        tmp_path, make_page(analysis, render(analysis, ["svg"])["svg"]), 360, PROBE
    )
    assert out["broken"] == 0
    # From edge to edge: only so are their letters large enough.
    assert min(out["figures"]) > 340
    assert out["requests"] == []
    assert out["focused"]

    times = [
        f"{run.time:.1f}"
        for run in sorted(analysis.run_table, key=lambda run: run.time)
    ]
    assert out["heads"][4] == "time [s]"
    assert out["up"] == [times, [None] * 4 + ["ascending"] + [None] * 5]
    assert out["down"] == [times[::-1], [None] * 4 + ["descending"] + [None] * 5]
    assert out["names"][0] == ["<b>3", "1", "2", "4", "5", "6", "7", "8", "9", "10"]
