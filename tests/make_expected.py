"""Write the golden texts anew after a change that was meant; read the difference before it is kept."""

from __future__ import annotations

from pathlib import Path

import gyrodata
from gyrodata import reporting

EXPECTED = Path(__file__).parent / "expected"

if __name__ == "__main__":
    for path in sorted((Path(__file__).parent.parent / "sample_data").glob("*.csv")):
        text = reporting.summary(gyrodata.analyze(path))
        (EXPECTED / f"{path.stem}.txt").write_text(text, encoding="utf-8")
