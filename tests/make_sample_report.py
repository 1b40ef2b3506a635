"""Write sample_data/air_gyroscope-report/ anew; ``python tests/make_sample_report.py``."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parent.parent
LOG = ROOT / "sample_data" / "air_gyroscope.csv"
REPORT = ROOT / "sample_data" / "air_gyroscope-report"


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


if __name__ == "__main__":
    make(REPORT)
