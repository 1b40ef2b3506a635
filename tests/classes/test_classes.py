"""Every cell keeps its bound for a small class that is always the same; ``python tests/classes`` has larger ones."""

from __future__ import annotations

import copy
import runpy
import sys
from pathlib import Path

import pytest

from classes.cells import CELLS, canvas, careful, judge, slipped
from classes.disguises import DISGUISES, plant
from classes.drawn import draw
from classes.graded import grade
from classes.planted import OLD, named

SIZES = {
    "A ": 30, "B ": 35, "G ": 80, "F ": 24, "C ": 20, "mistakes": 18, "D every": 25, "D other": 25,
    "D beside": 25, "D honest": 20,
}  # fmt: skip
"""Size of the class for the cells whose names begin so."""


@pytest.mark.parametrize("start", SIZES)
def test_each_cell_of_a_small_class_keeps_its_bound(start: str) -> None:
    for name in (name for name in CELLS if name.startswith(start)):
        number = CELLS[name](SIZES[start], 1)
        assert number.holds, f"{name}: {number.value} of {number.of}, {number.bound}: {number.told}"


def test_known_mistakes_are_named() -> None:
    found = [(kind, student) for kind, student in slipped(20, 1) if kind in OLD]
    assert {kind for kind, _ in found} == set(OLD)
    assert [kind for kind, student in found if not named(kind, student)] == []


def test_same_seed_gives_the_same_class_and_other_copies() -> None:
    assert draw(3, 1).log() == draw(3, 1).log() != draw(3, 2).log()
    students, pairs = plant([draw(i, 1) for i in range(20)], 1, 1)
    assert len({student.key for student in students}) == len(students) == 20 + len(DISGUISES)
    for (pair,) in pairs.values():
        source, copier = (student for student in students if student.key in pair)
        assert source.station == copier.station
        assert (source.log() == copier.log()) == (pair in pairs["exact"])


def test_class_that_is_wronged_is_counted() -> None:
    """The first loses a point for the unit, the second is not graded, the third is accused."""
    logs = careful(12, 1)
    document = copy.deepcopy(grade(canvas(logs)))
    first, second, third = list(document["students"].values())[:3]
    next(mark for mark in first["marks"] if mark["check"] == "units")["points"] = 1.0
    second["status"] = "not graded"
    document["flags"] = [{"students": [third["student"]]}]
    unjust, _, accused = judge(list(logs), document)
    assert (unjust.value, accused.value) == (2, 1)
    assert unjust.told.startswith("1 units, 1 not graded")


def test_command_prints_a_line_for_each_cell(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["classes", "--cell", "A careful: unjust", "--students", "25"])
    with pytest.raises(SystemExit) as done:
        runpy.run_path(str(Path(__file__).parent / "__main__.py"), run_name="__main__")
    line, last = capsys.readouterr().out.splitlines()
    assert line.split()[4:10] == ["0", "of", "25", "<=", "0", "yes"]
    assert (last, done.value.code) == ("1 cells, 0 beyond their bounds", 0)
