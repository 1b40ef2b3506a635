"""The page: whole, self-contained, escaped, and saying what the result says."""

from __future__ import annotations

import html
import json
import re
import shutil
import subprocess
from html.parser import HTMLParser
from pathlib import Path

import pytest

from gyrodata import analyze, plotting, reporting
from gyrodata.analysis import Analysis

LOG = """# g: 9.803 m/s^2
# ball_mass: 4.10 kg
# ball_diameter: 10.16 cm
# group: <img src=x onerror=alert(1)>
run,mass [g],position [cm],spin [rpm],time [s],turns,note
1,20.00,15.0,206,20.4,1,
2,20.00,15.0,407,40.4,1,
<b>3,20.00,15.0,601,59.5,1,"<script>alert('x')</script> & more"
4,40.00,15.0,203,10.2,1,
5,40.00,15.0,405,20.1,1,
6,40.00,15.0,607,30.1,2,
7,60.00,15.0,201,6.8,1,
8,60.00,15.0,404,13.4,1,
9,60.00,15.0,603,20.0,1,
"""
PIXEL = dict.fromkeys(plotting.FIGURES, b"\x89PNG\r\n")
WORDS = {name: f"what {name} shows" for name in plotting.FIGURES}
VOID = {"meta", "img", "br", "hr", "input", "link"}


class Structure(HTMLParser):
    """Tags in order, with a check that every one is closed."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


@pytest.fixture(scope="module")
def analysis() -> Analysis:
    return analyze(LOG.encode(), name="log<1>.csv")


@pytest.fixture(scope="module")
def page(analysis: Analysis) -> str:
    return reporting.report_page(analysis, PIXEL, "png", WORDS)


def test_structure_is_sound(page: str) -> None:
    tags = Structure(page).tags
    assert [tag for tag, _ in tags].count("h1") == 1
    images = [attrs for tag, attrs in tags if tag == "img"]
    assert [image["alt"] for image in images] == [f"what {name} shows" for name in plotting.FIGURES]
    identities = [attrs["id"] for _, attrs in tags if "id" in attrs]
    assert len(set(identities)) == len(identities)
    assert all(attrs.get("scope") for tag, attrs in tags if tag == "th")


def test_nothing_from_outside(page: str) -> None:
    tags = Structure(page).tags
    for tag, attrs in tags:
        for key in ("src", "href"):
            assert attrs.get(key, "data:").startswith(("data:", "#")), tag
        assert not any(key.startswith("on") for key in attrs), tag
    assert not re.search(r"https?://|url\(|@import", page)


def test_text_of_the_log_stays_text(page: str) -> None:
    assert "<script>alert" not in page
    assert "<img src=x" not in page
    assert "<b>3" not in page
    assert "log<1>" not in page
    assert html.escape("<script>alert('x')</script> & more") in page.replace("&#39;", "&#x27;")


def test_order_of_the_page(page: str) -> None:
    headings = re.findall(r"<h[123][^>]*>(.*?)</h[123]>", page)
    starts = ["Gyroscope lab", "Three fits", "Question 3", "(a)", "(b)", "(c)", "(d)", "(e)", "Runs", "Effects",
              "Where the uncertainty", "Next time", "Diagnostics", "Conventions", "Provenance"]  # fmt: skip
    assert len(headings) == len(starts)
    assert all(heading.startswith(start) for heading, start in zip(headings, starts, strict=True))


def test_it_says_what_the_result_says(analysis: Analysis, page: str) -> None:
    text = html.unescape(re.sub(r"<[^>]+>", " ", page)).replace("−", "-")
    assert reporting.inertia_text(analysis.inertia.value, analysis.inertia.u) in text
    assert analysis.sha256 in text
    for advice in analysis.advice:
        assert advice in text
    for diagnostic in analysis.diagnostics:
        assert diagnostic.message.replace("−", "-") in text
    for effect in analysis.effects:
        assert effect.reason.replace("−", "-") in text
    for fit in analysis.fits:
        assert fit.note.replace("−", "-") in text
    for group in analysis.torques:
        assert reporting.number_text(group.product, group.product_u) in text
    rows = re.findall(r'<tr class="flagged">(.*?)</tr>', page, re.S)
    assert len(rows) == sum(run.flagged for run in analysis.run_table) == 1
    assert "fits 1 turn, not 2" in rows[0]


def test_the_ball_is_compared_where_the_log_gives_it(page: str) -> None:
    assert "2/5 m r² = 4.232 × 10⁻³ kg·m²" in page
    plain = analyze("\n".join(line for line in LOG.splitlines() if "ball" not in line).encode(), name="log.csv")
    assert "would be compared" in reporting.report_page(plain, PIXEL, "png", WORDS)


def test_same_log_same_page(analysis: Analysis, page: str) -> None:
    assert reporting.report_page(analyze(LOG.encode(), name="log<1>.csv"), PIXEL, "png", WORDS) == page


@pytest.mark.parametrize(
    "log",
    [
        "mass [g],position [cm],spin [rpm],time [s],turns\n50,15,400,16.0,1\n",
        "mass [g],position [cm],spin [rpm],time [s],turns\n50,15,400,16.0,1\n0,,400,300,1/3\n20,15,400,38,1\n",
        "torque [N*m],spin [rpm],time [s],turns\n0.05,400,24.0,1\n0.1,400,12.0,1\n",
    ],
)
def test_small_logs_have_a_page_too(log: str) -> None:
    result = analyze(log.encode(), name="log.csv")
    page = reporting.report_page(result, plotting.render(result, "svg"), "svg", WORDS)
    Structure(page)
    assert "data:image/svg+xml;base64," in page
    assert "nan" not in re.sub(r"base64,[^\"]*", "", page).lower().split()


CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
PROBE = """<script>
addEventListener("load", () => {
  const frame = document.querySelector("iframe"), page = frame.contentDocument;
  const table = page.querySelector("table.sortable");
  const read = () => [...table.tBodies[0].rows].map(r => r.cells[4].dataset.value);
  const button = table.tHead.rows[0].cells[4].querySelector("button");
  button.click(); const up = read(); button.click(); const down = read();
  const out = {wide: page.documentElement.scrollWidth, inner: frame.clientWidth, up, down,
               broken: [...page.images].filter(i => !i.naturalWidth).length};
  const place = document.createElement("pre");
  place.id = "out"; place.textContent = JSON.stringify(out); document.body.append(place);
});
</script>"""


@pytest.mark.skipif(CHROMIUM is None, reason="no chromium on this machine")
def test_in_a_browser(analysis: Analysis, tmp_path: Path) -> None:
    assert CHROMIUM is not None
    page = reporting.report_page(analysis, plotting.render(analysis), "png", WORDS)
    attribute = html.escape(page, quote=True)
    frame = f'<iframe style="width:360px;height:800px;border:0" srcdoc="{attribute}"></iframe>'
    (tmp_path / "probe.html").write_text(f"<!doctype html><meta charset=utf-8><body>{PROBE}{frame}</body>", "utf-8")
    run = subprocess.run(
        [CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking",
         f"--user-data-dir={tmp_path / 'profile'}", "--virtual-time-budget=5000", "--dump-dom",
         "--enable-logging=stderr", (tmp_path / "probe.html").as_uri()],
        capture_output=True, text=True, timeout=120, check=True,
    )  # fmt: skip
    found = re.search(r'<pre id="out">(.*?)</pre>', run.stdout, re.S)
    assert found, run.stderr[-2000:]
    out = json.loads(html.unescape(found[1]))
    assert out["wide"] <= out["inner"] == 360
    assert out["broken"] == 0
    assert [float(v) for v in out["up"]] == sorted(run.time for run in analysis.run_table)
    assert out["down"] == out["up"][::-1]
    assert "CONSOLE" not in run.stderr
