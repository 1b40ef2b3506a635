"""A real browser, where there is one: it opens a page, prints it, or looks at it in a
frame as wide as a phone.
"""

from __future__ import annotations

import html
import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

CHROMIUM = (
    shutil.which("chromium")
    or shutil.which("chromium-browser")
    or shutil.which("google-chrome")
)
needs_browser = pytest.mark.skipif(
    CHROMIUM is None, reason="no chromium on this machine"
)


def browse(folder: Path, file: Path, *options: str) -> subprocess.CompletedProcess[str]:
    assert CHROMIUM is not None
    return subprocess.run(
        [
            CHROMIUM,
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-background-networking",
            f"--user-data-dir={folder / 'profile'}",
            "--enable-logging=stderr",
            *options,
            file.as_uri(),
        ],
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )


def look_at(folder: Path, page: str, width: int, script: str) -> dict[str, Any]:
    """Give what a script beside a page in a frame of `width` pixels puts into ``<pre
    id="out">``.
    """
    frame = (
        f'<iframe style="width:{width}px;height:800px;border:0" '
        f'srcdoc="{html.escape(page)}"></iframe>'
    )
    probe = folder / "probe.html"
    probe.write_text(
        f"<!doctype html><meta charset=utf-8><body>{script}{frame}</body>", "utf-8"
    )
    run = browse(folder, probe, "--virtual-time-budget=5000", "--dump-dom")
    found = re.search(r'<pre id="out">(.*?)</pre>', run.stdout, re.DOTALL)
    assert found, run.stderr[-2000:]
    assert "CONSOLE" not in run.stderr
    out: dict[str, Any] = json.loads(html.unescape(found[1]))
    assert out["wide"] <= out["inner"] == width
    assert out["beyond"] == []
    return out
