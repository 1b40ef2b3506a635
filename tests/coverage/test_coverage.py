"""The most telling cells of the table, with fewer labs; ``python tests/coverage`` has all of them.

The labs are always the same, so that a cell fails only if the fit changes. Hand and balance are misstated as in the
published logs: there the plain fit, whose intervals this table is to tell from true ones, holds the truth in half of
them.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest
from msgspec.structs import replace

sys.path.insert(0, str(Path(__file__).parent))

from cells import CHANCE, NINE, STATED, Number, cells, plain, template_order
from drawn_labs import ARM

CELLS = {cell.name: cell for cell in cells()}
LABS = 160

TELLING = [
    "9 runs, all as stated, u_time silent",
    "9 runs, hand 0.5 s, stated",
    "27 runs, hand t3 x 0.3 s, stated",
    "27 runs, hand 1 s x T/mean, silent",
    "3 runs, hand 0.5 s, silent",
    "9 runs, length, hand 0.5 s, 0.14 s stated / who states 0.5 s",
    "27 runs, length, hand 0.05 s, old widths / plain",
    "9 runs, length as stated, old widths, silent / plain",
    "9 runs, M0 20 %",
    "100/120/140 g, M0 10 %",
    "100/120/140 g, length, M0 Cauchy 2.5 % / plain",
    "9 runs, balance test 0.2 deg, false x 30",
    "27 runs, hand late by 0.11 +- 0.04 s",
    "9 runs, thirds, sighting 3 deg",
    "9 runs, tau 300 s, spin read 2 s late",
    "9 runs, dry friction, fall 30 %",
    "9 runs, u with a tighter true test / with the one before",
]
mixed_order = pytest.mark.skipif(template_order()[:9] == NINE.runs, reason="the template lists weights in rising order")
DRIFTING = [
    pytest.param("9 runs, balance drifting by +2 %, the template's order", marks=mixed_order),
    pytest.param("9 runs, balance drifting by -2 %, the template's order: bias in u", marks=mixed_order),
]


CLOSE = [
    "27 runs, thirds, tau 300 s, spin read 2 s late",
    "9 runs, length as stated, new defaults / plain, old widths",
    "100/120/140 g, M0 20 %",
]


@pytest.mark.parametrize("name", CLOSE)
def test_what_hardly_holds_is_looked_at_in_many_labs(name: str) -> None:
    number = CELLS[name].judge(1500)
    assert number.short < CHANCE, f"{number.value:{number.digits}} for {number.asked}"


@pytest.mark.parametrize("name", TELLING + DRIFTING)
def test_the_interval_holds_what_it_promises(name: str) -> None:
    number = CELLS[name].judge(LABS)
    assert number.short < CHANCE, f"{number.value:{number.digits}} for {number.asked}"


PAGE = (Path(__file__).parents[2] / "gyrodata" / "docs" / "statistics.md").read_text(encoding="utf-8")
SHOWN = re.findall(r"^\| (.*) \| ([\d.]+) % \| ([\d.]+) % \|$", PAGE.split("<!-- coverage -->")[1], re.MULTILINE)


@pytest.mark.parametrize(("name", "covers", "length"), SHOWN)
def test_the_page_shows_what_the_table_tells(name: str, covers: str, length: str) -> None:
    labs = int(re.findall(r"of (\d+) labs each", " ".join(PAGE.split()))[0])
    # Another machine may round one lab in or out.
    assert CELLS[name].judge(labs).value == pytest.approx(float(covers), abs=0.3)
    assert float(re.findall(r"length ([\d.]+) %", CELLS[name].told(labs))[0]) == pytest.approx(float(length), abs=0.02)


def test_the_page_says_what_a_lab_of_the_table_is() -> None:
    masses, spins = NINE.masses, NINE.spins
    told = (
        f"{masses[0]}, {masses[1]} and {masses[2]} g at {100 * ARM:g} cm, and spins from {spins[0]} to {spins[-1]} rpm"
    )
    assert told in " ".join(PAGE.split())
    assert f"the log states {NINE.hand:g} s" in PAGE


def test_the_table_sees_an_interval_that_is_not_true() -> None:
    far = plain(replace(NINE, hand=0.5), LABS, STATED)
    assert far.covers < 0.75
    assert Number(100 * far.covers, 92, error=2).short > CHANCE


def test_the_command_tells_what_holds(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    import runpy

    monkeypatch.setattr(sys, "argv", ["coverage", "--labs", "40", "--cell", "9 runs, length as stated, old"])
    with pytest.raises(SystemExit) as done:
        runpy.run_path(str(Path(__file__).parent / "__main__.py"), run_name="__main__")
    assert done.value.code == 0
    assert "<= 1.080       holds" in (told := capsys.readouterr().out)
    assert told.splitlines()[-1] == "2 cells of 40 labs, 0 failed"
