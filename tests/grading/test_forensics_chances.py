"""The probabilities behind the flags: against other libraries, by simulation, and as a whole class feels them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from grading.students import Course, honest_class, honest_log, print_of, prints_of, text
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from gyrodata.fitting import chi2_tail
from gyrodata.grading.forensics import copies, flag_class
from gyrodata.grading.forensics.copies import Chances, binomial_tails
from gyrodata.grading.forensics.flags import ALLOWED, chi2_lower_tail
from gyrodata.grading.forensics.logs import measure_scatter


@pytest.mark.parametrize("dof", [1, 2, 5, 9, 24, 190])
@pytest.mark.parametrize("share", [1e-6, 0.01, 0.3, 1.0, 2.0])
def test_the_lower_tail_of_chi_square_agrees_with_scipy(dof: int, share: float) -> None:
    assert chi2_lower_tail(share * dof, dof) == pytest.approx(stats.chi2.cdf(share * dof, dof), rel=1e-10)


def test_the_two_tails_of_chi_square_add_up() -> None:
    assert chi2_lower_tail(7.3, 6) + chi2_tail(7.3, 6) == pytest.approx(1, abs=1e-14)
    assert chi2_lower_tail(0, 6) == 0


@given(st.integers(1, 40), st.floats(1e-6, 0.5))
def test_binomial_tails_agree_with_scipy(trials: int, chance: float) -> None:
    tails = binomial_tails(trials, chance)
    expected = stats.binom.sf(np.arange(trials + 1) - 1, trials, chance)
    np.testing.assert_allclose(tails, expected, rtol=1e-9)


@given(st.dictionaries(st.tuples(st.integers(1, 12), st.floats(1e-3, 0.5)), st.integers(1, 10_000), min_size=1))
def test_the_pairs_expected_below_a_rank_are_those_that_chance_brings_there(
    counted: dict[tuple[int, float], int],
) -> None:
    chances = Chances(counted, 0.5)
    compared, chance = min(counted)
    p = binomial_tails(compared, chance)[compared]
    rank = p * chances.share(compared)
    brought = 0.0
    for (rows, single), pairs in counted.items():
        reached = [tail for tail in binomial_tails(rows, single)[1:] if tail * chances.share(rows) <= rank * (1 + 1e-9)]
        brought += 0.5 * pairs * max(reached, default=0.0)
    assert chances.expected(compared, p) == pytest.approx(brought + p, rel=1e-6)


def test_a_rank_that_is_passed_expects_more_than_allowed() -> None:
    chances = Chances({(9, 0.05): 10_000}, 0.5)
    tails = binomial_tails(9, 0.05)
    flagged = [k for k in range(1, 10) if chances.expected(9, tails[k]) <= ALLOWED]
    assert flagged == [6, 7, 8, 9]
    assert all(tails[k] * chances.share(9) <= chances.last_rank for k in flagged)


def test_the_scatter_of_a_hand_is_recovered() -> None:
    course = Course(hand=(0.08, 0.08), repeats=3, rpm_decimals=1)
    random = np.random.default_rng(4)
    found = [measure_scatter(print_of(text(honest_log(random, course, i)))) for i in range(60)]
    squares = sum(one.squares for one in found if one)
    dof = sum(one.dof for one in found if one)
    assert dof == 60 * (27 - 4)
    # The tachometer's 0.2 % of some 13 s comes on top.
    assert 0.08 < math.sqrt(squares / dof) < math.hypot(0.08, 0.032)


def test_bends_and_slips_only_make_the_scatter_larger() -> None:
    rows = honest_log(np.random.default_rng(4), Course(), 0)
    slip = [*rows[:4], (*rows[4][:4], "1/3"), *rows[5:]]
    one, other = (measure_scatter(print_of(text(log))) for log in (rows, slip))
    assert one is not None
    assert other is not None
    assert other.squares > one.squares


def test_the_short_way_through_a_large_class_finds_what_the_whole_way_finds(monkeypatch: pytest.MonkeyPatch) -> None:
    random = np.random.default_rng(8)
    logs = honest_class(random, Course(), 120)
    for number, changed in enumerate((0, 2, 3, 6, 9)):
        rows, own = logs[f"s{number:05d}"], logs[f"s{number + 50:05d}"]
        # A few rows of one's own, and the others with times of one's own, as a copy that is to look like none.
        logs[f"s{number + 50:05d}"] = [
            mine if i < changed else (*one[:3], f"{float(one[3]) + 0.2 * random.standard_normal():.2f}", one[4])
            for i, (one, mine) in enumerate(zip(rows, own, strict=True))
        ]
    prints = prints_of(logs)
    whole = flag_class(prints)
    monkeypatch.setattr(copies, "LARGE", 0)
    assert flag_class(prints) == whole
    found = [flag.students for flag in whole if flag.kind == "same spins"]
    assert found == [("s00000", "s00050"), ("s00001", "s00051"), ("s00002", "s00052")]
