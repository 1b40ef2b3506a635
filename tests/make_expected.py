"""Write the golden texts anew after a change that was meant; read the difference before it is kept."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import partial
from pathlib import Path

from corners import CORNERS, whole
from golden import every_log_as_read, every_number_of_a_fit, every_slip_found, numbers, slips
from labs import scenes

import gyrodata
from gyrodata import plotting, reporting
from gyrodata.procedure import check_log
from gyrodata.reporting import watch_text

EXPECTED = Path(__file__).parent / "expected"


def lines_of(rows: Mapping[str, object]) -> str:
    """JSON with a row a line."""
    return "{\n" + ",\n".join(f"  {json.dumps(key)}: {json.dumps(row)}" for key, row in rows.items()) + "\n}"


if __name__ == "__main__":
    samples = Path(__file__).parent.parent / "sample_data"
    for path in sorted(samples.glob("*.csv")):
        text = reporting.summary(gyrodata.analyze(path))
        (EXPECTED / f"{path.stem}.txt").write_text(text, encoding="utf-8")
    analysis = gyrodata.analyze(samples / "air_gyroscope.csv")
    alt = {name: plotting.alt_text(analysis, name) for name in plotting.FIGURES}
    forms = {
        "md": partial(reporting.markdown_report, alt=alt),
        "tex": reporting.latex_report,
        "csv": reporting.runs_csv,
    }
    for ending, write in forms.items():
        (EXPECTED / f"air_gyroscope.{ending}").write_text(write(analysis), encoding="utf-8")
    half_way = gyrodata.analyze(EXPECTED / "half_way.csv")
    (EXPECTED / "half_way.txt").write_text(watch_text(half_way, check_log(half_way.readings)[1]), encoding="utf-8")
    for path in sorted((EXPECTED / "numbers").glob("*.csv")):
        found = numbers(gyrodata.analyze(path).to_dict()["result"])
        lines = ",\n".join(f"  {json.dumps(place)}: {value}" for place, value in found.items())
        path.with_suffix(".json").write_text(f"{{\n{lines}\n}}\n", encoding="utf-8")
    (EXPECTED / "as_read.txt").write_text(every_log_as_read(), encoding="utf-8")
    fits = {name: lines_of(every_number_of_a_fit(name)) for name in scenes()}
    kept = ",\n".join(f'"{name}": {told}' for name, told in fits.items())
    (EXPECTED / "fits.json").write_text(f"{{\n{kept}\n}}\n", encoding="utf-8")
    found = {name: every_slip_found(name) for name in slips()}
    (EXPECTED / "slips.json").write_text(lines_of(found) + "\n", encoding="utf-8")
    CORNERS.write_text(whole(CORNERS.read_text(encoding="utf-8")), encoding="utf-8")
