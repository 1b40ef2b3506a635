"""Every cell holds for a small class that is always the same; ``python tests/classes`` has larger ones."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path

import pytest
from msgspec.structs import replace

from classes.cells import careful, cells, slipped
from classes.disguises import DISGUISES, plant
from classes.drawn import draw
from classes.planted import OLD, named

CELLS = {cell.name: cell for cell in cells()}
SEED = 1
SIZES = {
    "A ": 30, "B ": 35, "G ": 80, "F ": 24, "C ": 20, "slips": 18, "D every": 25, "D other": 25, "D beside": 25,
    "D honest": 20, "desk": 20, "rubric": 20,
}  # fmt: skip
"""Size of the class for the cells whose names begin so."""


@pytest.mark.parametrize("start", SIZES)
def test_each_cell_with_a_size_keeps_its_bound(start: str) -> None:
    for name, cell in CELLS.items():
        if name.startswith(start):
            number = cell.measure(SIZES[start], SEED)
            assert number.holds, f"{name}: {number.shown}, must hold {number.must_hold}: {number.told}"


def test_known_slips_are_named() -> None:
    found = [(kind, student) for kind, student in slipped(20, SEED) if kind in OLD]
    assert {kind for kind, _ in found} == set(OLD)
    assert [kind for kind, student in found if not named(kind, student)] == []


def test_same_seed_gives_the_same_class_and_other_copies() -> None:
    one, same, other = draw(3, 1).log(), draw(3, 1).log(), draw(3, 2).log()
    assert one == same != other
    students, pairs = plant([draw(i, 1) for i in range(20)], 1, 1)
    assert len({student.key for student in students}) == len(students) == 20 + len(DISGUISES)
    for pair in (pair for (pair,) in pairs.values()):
        source, copier = (student for student in students if student.key in pair)
        assert source.station == copier.station
        assert (source.log() == copier.log()) == (pair in pairs["exact"])


def test_class_that_is_wronged_is_counted() -> None:
    """The first loses a point for the unit, the second is not graded, the third is accused."""
    made = careful(30, SEED)
    students = {key: dict(student) for key, student in made.document["students"].items()}
    first, second, third = list(students.values())[:3]
    first["marks"] = [{**mark, "points": 1.0} if mark["check"] == "units" else mark for mark in first["marks"]]
    second["status"] = "not graded"
    spoilt = {**made.document, "students": students, "flags": [{"students": [third["student"]]}]}
    made = replace(made, document=spoilt)
    assert made.unjust() == {"units": 1, "not graded": 1}
    assert made.accused() == 1


def test_command_prints_a_line_for_each_cell(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["classes", "--cell", "rubric in", "--students", "20"])
    with pytest.raises(SystemExit) as done:
        runpy.run_path(str(Path(__file__).parent / "__main__.py"), run_name="__main__")
    head, line, last = capsys.readouterr().out.splitlines()
    assert head.split() == ["cell", "measured", "must", "hold", "holds"]
    assert line.split()[6:12] == ["8", "of", "8", ">=", "8", "yes"]
    assert (last, done.value.code) == ("1 cells, 0 do not hold", 0)
