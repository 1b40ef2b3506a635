"""Five hundred logs at random in each run, what every log must keep to, and every log that ever broke the tool.

Each run draws other logs. A failure tells its seed: ``python tests/fuzz --seed S --only`` repeats it, and
``python tests/fuzz --count 100000`` tries many more.
"""

from __future__ import annotations

import secrets
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

import gyrodata
from fuzz.clean import draw_clean, try_clean
from fuzz.doors import DOORS, try_reader
from fuzz.grammar import Lab, draw_input, draw_lab, write
from fuzz.relations import try_log
from gyrodata.errors import LogError
from gyrodata.readings import read_log, write_log

CORPUS = sorted((Path(__file__).parent / "corpus").glob("*.csv"))
PARTS = 20


def seeds(count: int) -> range:
    """Seeds that no run before had."""
    first = secrets.randbelow(2**31)
    return range(first, first + count)


def told(attempt: Callable[[int], object], seed: int, clean: str = "") -> object:
    """Try a seed; a failure says how to repeat it."""
    try:
        return attempt(seed)
    except Exception as error:
        pytest.fail(f"python tests/fuzz --seed {seed} --only{clean}: {type(error).__name__}: {error}")


@pytest.mark.parametrize("part", range(PARTS))
def test_any_log_has_an_answer_that_can_be_believed_or_words(part: int) -> None:
    answered = sum(
        told(lambda s: try_log(*draw_input(s), thorough=s % 10 == 0), seed) is not None for seed in seeds(500 // PARTS)
    )
    # Else it would be the reader alone that is tried.
    assert answered > 5


@pytest.mark.parametrize("part", range(4))
def test_a_clean_log_of_any_length_and_order_holds_the_truth(part: int) -> None:
    ends = [told(try_clean, seed, " --clean") for seed in seeds(15)]
    assert set(ends) == {"answered"}


@pytest.mark.parametrize("path", CORPUS, ids=lambda path: path.name)
def test_what_once_broke_it(path: Path) -> None:
    try_reader(path.read_bytes())
    for model in ("auto", "released"):
        try_log(path.read_bytes(), model)


def test_the_corpus_is_there() -> None:
    assert len(CORPUS) >= 10


class TestRelations:
    """The same lab written in another way has the same answer."""

    @staticmethod
    def lab(random: np.random.Generator) -> Lab:
        """Draw a lab without a slip, that states nothing unusual."""
        while True:
            lab = draw_lab(random, int(random.choice((4, 6, 9, 12, 18))))
            if "mass" in lab.columns and len(set(lab.columns["mass"]) - {0.0}) > 1:
                return replace(lab, keys=(("g", "9.803 m/s^2"),))

    @staticmethod
    def answer(text: str) -> tuple[float, float]:
        """I_zz and its u, or the codes of the refusal as numbers."""
        try:
            found = gyrodata.analyze(text.encode()).inertia
        except LogError as error:
            return tuple(float(d.code[1:]) for d in error.diagnostics if d.severity == "error")[:2] or (0.0, 0.0)
        assert found.u is not None
        return found.value, found.u

    @pytest.mark.parametrize("seed", range(25))
    def test_other_units(self, seed: int) -> None:
        random = np.random.default_rng(seed)
        lab = self.lab(random)
        assert self.answer(write(lab, random, 13)) == pytest.approx(self.answer(write(lab, None, 13)), rel=1e-7)

    @pytest.mark.parametrize("seed", range(25))
    def test_other_order(self, seed: int) -> None:
        random = np.random.default_rng(seed)
        lab = self.lab(random)
        order = random.permutation(len(lab.counts))
        columns = {name: [values[i] for i in order] for name, values in lab.columns.items()}
        mixed = replace(lab, columns=columns, counts=[lab.counts[i] for i in order])
        assert self.answer(write(mixed)) == pytest.approx(self.answer(write(lab)), rel=1e-7)

    @pytest.mark.parametrize("seed", range(25))
    def test_ten_times_the_torque(self, seed: int) -> None:
        lab = self.lab(np.random.default_rng(seed))
        heavier = replace(lab, columns={**lab.columns, "mass": [10 * value for value in lab.columns["mass"]]})
        found, expected = self.answer(write(heavier, digits=13)), self.answer(write(lab, digits=13))
        refused = expected[0] > 100
        assert found == pytest.approx(expected if refused else tuple(10 * x for x in expected), rel=1e-6)

    @pytest.mark.parametrize("seed", range(25))
    def test_written_by_the_tool_itself(self, seed: int) -> None:
        lab = self.lab(np.random.default_rng(seed))
        again = write_log(read_log(write(lab).encode()))
        assert self.answer(again) == pytest.approx(self.answer(write(lab)), rel=1e-9)

    def test_a_clean_log_is_drawn_anew_from_its_seed(self) -> None:
        assert draw_clean(7) == draw_clean(7) != draw_clean(8)


@pytest.mark.parametrize("door", DOORS)
def test_every_other_door_takes_an_input_or_refuses_it_in_words(door: str) -> None:
    # The same in every run: what a random one finds is tried by the command, and kept as a case of its own.
    ends = {told(DOORS[door], seed, f" --door {door}") for seed in range(40, 70)}
    assert "taken" in ends <= {"taken", "refused"}
