"""Every cell keeps its bound for a small class that is always the same; ``python
tests/acceptance/classes`` has larger ones.
"""

import pytest

from classes.class_cells import CELLS

SIZES = {
    "A ": 6,
    "B ": 7,
    "G ": 12,
    "D every": 9,
    "D other": 9,
    "D beside": 9,
    "D honest": 5,
}
"""Size of the class for the cells whose names begin so."""


@pytest.mark.parametrize("start", SIZES)
def test_each_cell_of_a_small_class_keeps_its_bound(start: str) -> None:
    for name in (name for name in CELLS if name.startswith(start)):
        number = CELLS[name](SIZES[start], 1)
        assert number.holds, (
            f"{name}: {number.value} of {number.of}, {number.bound}: {number.told}"
        )
