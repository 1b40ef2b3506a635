"""Write the golden feedback anew after a change that was meant; read the difference before it is kept."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path

import pytest
from grading import alike, handed, judged, whole_class
from msgspec import convert

from gyrodata.grading import Grade, feedback_html, feedback_markdown

EXPECTED = Path(__file__).parent / "expected"

if __name__ == "__main__":
    for path in sorted(EXPECTED.glob("*.json")):
        grade = convert(json.loads(path.read_text(encoding="utf-8")), Grade)
        path.with_suffix(".md").write_text(feedback_markdown(grade), encoding="utf-8")
        path.with_suffix(".html").write_text(feedback_html(grade), encoding="utf-8")
    with tempfile.TemporaryDirectory() as folder:
        (EXPECTED / "judged.txt").write_text("".join(judged.judged(Path(folder))), encoding="utf-8")
        (EXPECTED / "classes.txt").write_text("".join(handed.classes(Path(folder))), encoding="utf-8")
        for name, tell in {"at_first": whole_class.at_first, "decided_on": whole_class.decided_on}.items():
            (EXPECTED / f"{name}.txt").write_text("".join(tell(Path(folder) / name)), encoding="utf-8")
        (EXPECTED / "handed_back.txt").write_text("".join(judged.handed_back(Path(folder))), encoding="utf-8")
        (EXPECTED / "settled.txt").write_text("".join(judged.classes(Path(folder))), encoding="utf-8")
    (EXPECTED / "sheets.txt").write_text("".join(handed.sheets()), encoding="utf-8")
    (EXPECTED / "desks.txt").write_text("".join(handed.desks()), encoding="utf-8")
    with pytest.MonkeyPatch.context() as patched:
        found = alike.told(lambda name, value: patched.setattr(f"gyrodata.grading.forensics.{name}", value))
        (EXPECTED / "alike.txt").write_text("".join(found), encoding="utf-8")
