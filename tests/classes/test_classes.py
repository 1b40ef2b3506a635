"""The cells that hold, with small classes that are always the same; ``python tests/classes`` has all of them."""

from __future__ import annotations

import re
import runpy
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace

from classes.cells import careful, cells, slipped
from classes.disguises import DISGUISES, plant
from classes.drawn import draw
from classes.planted import OLD, named

CELLS = {cell.name: cell for cell in cells()}
SEED = 1

HOLDS = [
    (30, ["A careful: unjust loss", "A careful: loss for the bench's scatter", "A careful: slips or flags"]),
    (35, [f"B any right route: {what}" for what in ("unjust loss", "loss for the bench's scatter", "slips or flags")]),
    (80, [f"G other benches: {what}" for what in ("unjust loss", "loss for the bench's scatter", "slips or flags")]),
    (24, ["F typed in 12 ways: not graded or losing"]),
    (20, ["C told no format: not graded"]),
    (18, ["slips: kinds named right", "slips: logs named wrongly"]),
    (25, ["D every time changed: found", "D other copies: found", "D beside copies: false flags"]),
    (20, ["D honest, nominal spins too: false flags"]),
    (20, [name for name in CELLS if name.startswith("desk: ")]),
    (20, ["rubric in ten lines: points right"]),
]
"""Cells of one class each, and its size; a cell that comes to hold is one more name here."""


@pytest.mark.parametrize(("size", "names"), HOLDS, ids=[names[0] for _, names in HOLDS])
def test_what_must_hold_of_a_class(size: int, names: list[str]) -> None:
    for name in names:
        number = CELLS[name].measure(size, SEED)
        assert number.holds, f"{name}: {number.shown}, must hold {number.must_hold}: {number.told}"


def test_known_slips_are_named() -> None:
    found = [(kind, student) for kind, student in slipped(20, SEED) if kind in OLD]
    assert {kind for kind, _ in found} == set(OLD)
    assert [kind for kind, student in found if not named(kind, student)] == []


def test_the_same_seed_gives_the_same_class() -> None:
    one, same, other = draw(3, 1).log(), draw(3, 1).log(), draw(3, 2).log()
    assert one == same != other
    honest = [draw(i, 1) for i in range(20)]
    students, pairs = plant(honest, 1, 1)
    assert len({student.key for student in students}) == len(students) == 20 + len(DISGUISES)
    for pair in (pair for (pair,) in pairs.values()):
        source, copier = (student for student in students if student.key in pair)
        assert source.station == copier.station
        if pair not in pairs["exact"]:
            assert source.log() != copier.log()


def test_a_class_that_is_wronged_is_seen() -> None:
    made = careful(30, SEED)
    made = replace(made, document=_spoilt(made.document))
    assert made.unjust() == {"units": 1, "not graded": 1}
    assert made.accused() == 1


def _spoilt(document: Mapping[str, Any]) -> dict[str, Any]:
    """Take a point for the unit from the first, the grade from the second, and accuse the third."""
    students = {key: dict(student) for key, student in document["students"].items()}
    first, second, third = list(students.values())[:3]
    first["marks"] = [{**mark, "points": 1.0} if mark["check"] == "units" else mark for mark in first["marks"]]
    second["status"] = "not graded"
    return {**document, "students": students, "flags": [{"students": [third["student"]]}]}


def test_the_command_tells_what_is_measured_and_what_must_hold(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["classes", "--cell", "lines of code"])
    with pytest.raises(SystemExit) as done:
        runpy.run_path(str(Path(__file__).parent / "__main__.py"), run_name="__main__")
    head, line, last = capsys.readouterr().out.splitlines()
    assert head.split() == ["cell", "measured", "must", "hold", "holds"]
    count, holds = re.fullmatch(r"lines of code in grading +(\d+)  <= 4300 +(yes|NO) +\d+ files", line).groups()
    assert int(count) > 1000
    assert (holds == "yes") == (int(count) <= 4300) == (done.value.code == 0)
    assert last == f"1 cells, {done.value.code} do not hold"
