"""``flags.csv``: what honest work hardly ever shows, a row for each, with how often it would."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable
from typing import TYPE_CHECKING

from gyrodata.reporting import csv_cell

if TYPE_CHECKING:
    from gyrodata.grading.forensics import Flag


def flags_csv(flags: Iterable[Flag]) -> str:
    """Write the flags of a class.

    Gives: CSV; a text that a spreadsheet would run as a formula has a ' in front.
    """
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(["kind", "students", "earlier logs", "expected by chance in this class", "p", "evidence"])
    for flag in flags:
        numbers = (float(f"{flag.expected:.3g}"), float(f"{flag.p:.3g}"))
        cells = (flag.kind, ", ".join(flag.students), ", ".join(flag.previous), *numbers, flag.evidence)
        writer.writerow([csv_cell(cell) for cell in cells])
    return out.getvalue()
