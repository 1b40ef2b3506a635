"""Logs at random, other ones in each run: what every log must keep to, and every log
that ever broke the tool.

A failure shows its seed: ``python tests/acceptance/fuzz --seed S --only`` repeats it;
``--count 100000`` tries many more."""

from __future__ import annotations

import secrets
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from gates.fuzzed import attempt
from msgspec.structs import replace
from simulated_labs import analyze_briefly

import gyrodata
from fuzz.clean import try_clean
from fuzz.doors import DOORS, try_reader
from fuzz.grammar import Lab, draw_lab, write
from gyrodata.base.errors import GyroError, LogError
from gyrodata.readings import read_log, write_log

CORPUS = sorted((Path(__file__).parent / "corpus").glob("*.csv"))


def tried(way: Callable[[int], object], seed: int, door: str) -> object:
    """Try a seed; a failure says how to repeat it."""
    try:
        return way(seed)
    except Exception as error:
        pytest.fail(
            f"python tests/acceptance/fuzz --seed {seed} --only --door {door}: "
            f"{type(error).__name__}: {error}"
        )


def seeds(count: int) -> range:
    """Seeds that no run before had."""
    first = secrets.randbelow(2**31)
    return range(first, first + count)


def test_any_log_has_an_answer_that_can_be_believed_or_words() -> None:
    answered = 0
    for seed in seeds(40):
        end, wrong, _ = tried(attempt, seed, "analysis")  # type: ignore[misc]
        assert not wrong, seed
        answered += end == "answered"
        if answered == 3:
            break
    assert answered > 0, "else only the reader is tried"


def test_clean_log_of_any_length_and_order_contains_the_truth() -> None:
    # `python tests/acceptance/fuzz` draws longer ones.
    try_short = partial(try_clean, most=100)
    assert {tried(try_short, seed, "clean") for seed in seeds(3)} == {"answered"}


@pytest.mark.parametrize("path", CORPUS, ids=lambda path: path.name)
@pytest.mark.parametrize("model", ["auto", "released"])
def test_log_that_once_broke_the_tool_ends_in_words(path: Path, model: str) -> None:
    if model == "auto":
        try_reader(path.read_bytes())
    try:
        # The other model of motion changes the fit; what a report shows, only once.
        analyze = gyrodata.analyze if model == "auto" else analyze_briefly
        u = analyze(path.read_bytes(), model=model).inertia.u or 0.0  # type: ignore[arg-type]
    except GyroError as error:
        u = float(not error.diagnostics)
    assert 0 <= u < 1


def draw(random: np.random.Generator) -> Lab:
    """Draw a lab without a slip, that states nothing unusual."""
    while True:
        lab = draw_lab(random, int(random.choice((4, 6, 9, 12, 18))))
        if "mass" in lab.columns and len(set(lab.columns["mass"]) - {0.0}) > 1:
            return replace(lab, keys=(("g", "9.803 m/s^2"),))


def answer(text: str) -> tuple[float, float]:
    """I_zz and its u, or the codes of the refusal as numbers."""
    try:
        found = analyze_briefly(text.encode()).inertia
    except LogError as error:
        return tuple(
            float(d.code[1:]) for d in error.diagnostics if d.severity == "error"
        )[:2] or (0.0, 0.0)
    assert found.u is not None
    return found.value, found.u


def written_anew(lab: Lab, way: str, random: np.random.Generator) -> str:
    """Write the same lab in another way."""
    if way == "in other units":
        return write(lab, random, 13)
    if way == "by the tool":
        return write_log(read_log(write(lab, None, 13).encode()))
    if way == "with ten times the torque":
        return write(
            replace(
                lab,
                columns={**lab.columns, "mass": [10 * m for m in lab.columns["mass"]]},
            ),
            None,
            13,
        )
    order = random.permutation(len(lab.counts))
    columns = {name: [values[i] for i in order] for name, values in lab.columns.items()}
    return write(
        replace(lab, columns=columns, counts=[lab.counts[i] for i in order]), None, 13
    )


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(
    "way",
    ["in other units", "by the tool", "with ten times the torque", "in another order"],
)
def test_same_lab_written_in_another_way_has_the_same_answer(
    way: str, seed: int
) -> None:
    random = np.random.default_rng(seed)
    lab = draw(random)
    again = answer(written_anew(lab, way, random))
    expected = answer(write(lab, None, 13))
    factor = 10 if way == "with ten times the torque" and expected[0] < 100 else 1
    assert again == pytest.approx(tuple(factor * x for x in expected), rel=1e-6)


@pytest.mark.parametrize("door", DOORS)
def test_door_takes_an_input_or_refuses_it_in_words(door: str) -> None:
    # The same in every run; `python tests/acceptance/fuzz` tries random ones.
    ends = {tried(DOORS[door], seed, door) for seed in range(40, 48)}
    assert "taken" in ends <= {"taken", "refused"}
