"""The probabilities behind the flags: against other libraries, by simulation, and as a whole class feels them."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from grading.students import Course, honest_class, prints_of
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from gyrodata.grading.forensics import flag_class
from gyrodata.grading.forensics.copies import tails
from gyrodata.grading.forensics.logs import lay_out


@given(st.integers(1, 40), st.floats(1e-6, 0.5))
def test_equal_chances_agree_with_the_binomial_of_scipy(trials: int, chance: float) -> None:
    expected = stats.binom.sf(np.arange(trials + 1) - 1, trials, chance)
    np.testing.assert_allclose(tails(np.full((1, trials), chance))[0], expected, rtol=1e-9)


@given(st.lists(st.lists(st.floats(0, 1), min_size=5, max_size=5), min_size=1, max_size=4))
def test_unlike_chances_agree_with_a_sum_over_all_outcomes(chances: list[list[float]]) -> None:
    expected = np.zeros((len(chances), 6))
    for ways in itertools.product((0, 1), repeat=5):
        for row, log in zip(expected, chances, strict=True):
            row[: sum(ways) + 1] += math.prod(one if way else 1 - one for one, way in zip(log, ways, strict=True))
    np.testing.assert_allclose(tails(np.array(chances)), expected, rtol=1e-9, atol=1e-300)


def test_the_scatter_of_a_hand_is_recovered() -> None:
    course = Course(hand=(0.08, 0.08), repeats=3, rpm_decimals=1)
    found = lay_out(prints_of(honest_class(np.random.default_rng(4), course, 60)), (), {}).scatters
    squares = sum(one.squares for one in found if one)
    dof = sum(one.dof for one in found if one)
    assert dof == 60 * (27 - 4)
    # The tachometer's 0.2 % of some 13 s comes on top.
    assert 0.08 < math.sqrt(squares / dof) < math.hypot(0.08, 0.032)


def test_a_copy_is_found_among_logs_that_share_much_by_chance() -> None:
    random = np.random.default_rng(8)
    logs = honest_class(random, Course(), 120)
    for number, changed in enumerate((0, 2, 3, 6, 9)):
        rows, own = logs[f"s{number:05d}"], logs[f"s{number + 50:05d}"]
        # A few rows of one's own, and the others with times of one's own, as a copy that is to look like none.
        logs[f"s{number + 50:05d}"] = [
            mine if i < changed else (*one[:3], f"{float(one[3]) + 0.2 * random.standard_normal():.2f}", one[4])
            for i, (one, mine) in enumerate(zip(rows, own, strict=True))
        ]
    found = [flag.students for flag in flag_class(prints_of(logs))]
    assert found == [("s00000", "s00050"), ("s00001", "s00051"), ("s00002", "s00052")]


def test_the_scatter_is_what_least_squares_leave() -> None:
    random = np.random.default_rng(6)
    logs = honest_class(random, Course(rpm_decimals=1), 20)
    few = {
        name: [rows[i] for i in sorted(random.choice(9, 2 + at % 7, False))]
        for at, (name, rows) in enumerate(logs.items())
    }
    # One row at each weight: their slopes explain any bias.
    few["a"] = logs["s00000"][::3]
    prints = prints_of(few)
    found = lay_out(prints, (), {})
    for name, scatter in zip(found.keys, found.scatters, strict=True):
        torque, lever, time = (np.array(getattr(prints[name], of)) for of in ("torque", "spin", "time"))
        lever *= prints[name].turns
        design = np.column_stack([lever * (torque == one) for one in np.unique(torque)] + [np.ones(len(time))])
        solution, _, rank, _ = np.linalg.lstsq(design, time, rcond=1e-9)
        dof = len(time) - int(rank)
        assert (scatter.dof if scatter else 0) == dof
        if scatter:
            rounding = dof * np.mean(np.square(prints[name].time_step)) / 12
            assert scatter.squares - rounding == pytest.approx(np.sum((time - design @ solution) ** 2), rel=1e-9)
