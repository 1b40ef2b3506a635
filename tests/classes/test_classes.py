"""Every cell keeps its bound for a small class that is always the same; ``python tests/classes`` has larger ones."""

import copy

import pytest

from classes.cells import CELLS, canvas, careful, grade, judge

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
