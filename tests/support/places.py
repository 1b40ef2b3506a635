"""Where the files are that tests read."""

from __future__ import annotations

from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "gyrodata"
SAMPLES = ROOT / "sample_data"
TESTS = ROOT / "tests"
DATA = TESTS / "data"
ACCEPTANCE = TESTS / "acceptance"
