"""Write sample_data/air_gyroscope-report/, and the list of its figures in the gallery of
the site, anew; ``python tests/make_sample_report.py``.

A file that says the same as before is kept, because another release of matplotlib moves
the texts and lines of a figure a little.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from pathlib import Path

from gyrodata.reporting.figures import FIGURES

ROOT = Path(__file__).parent.parent
LOG = ROOT / "sample_data" / "air_gyroscope.csv"
REPORT = ROOT / "sample_data" / "air_gyroscope-report"
GALLERY = ROOT / ".github" / "site" / "gallery.md"
PICTURES = [f"{name}.svg" for name in FIGURES]
FILES = sorted([*PICTURES, "report.html", "results.json", "runs.csv"])


def make(folder: Path) -> None:
    """Write the report that ``gyro analyze sample_data/air_gyroscope.csv`` writes into
    a folder.
    """
    command = [
        sys.executable,
        "-m",
        "gyrodata",
        "analyze",
        str(LOG),
        "--out",
        str(folder),
        "--quiet",
    ]
    subprocess.run(command, cwd=ROOT, stdout=subprocess.DEVNULL, check=True)


def said(path: Path) -> str:
    """Return what a file of the report says: a figure its texts, with the number of its
    marks and lines, and a page its text without the figures in it.
    """
    text = path.read_text(encoding="utf-8")
    if path.suffix != ".svg":
        return re.sub(r'"data:[^"]*"', '""', text)
    parts = re.findall(r"<text[^>]*>(.*?)</text>", text)
    return "\n".join([*parts, f"{text.count('<use')} {text.count('<path')}"])


def gallery() -> str:
    """Return the page of the gallery with every figure of the report."""
    text = GALLERY.read_text(encoding="utf-8")
    shown = [
        f"![{figure.caption.partition('. ')[0]}]"
        f"(../../sample_data/air_gyroscope-report/{name}.svg)\n\n"
        for name, figure in FIGURES.items()
    ]
    return re.sub(r"(!\[[^\n]*\n\n)+", lambda _: "".join(shown), text, count=1)


def renew() -> None:
    """Write the files of the report that say something else now, and the gallery."""
    with tempfile.TemporaryDirectory() as folder:
        make(Path(folder, "report"))
        for name in FILES:
            new, old = Path(folder, "report", name), REPORT / name
            if not old.exists() or said(new) != said(old):
                old.write_bytes(new.read_bytes())
    for old in REPORT.iterdir():
        if old.name not in FILES:
            old.unlink()
    GALLERY.write_text(gallery(), encoding="utf-8")


if __name__ == "__main__":
    renew()
