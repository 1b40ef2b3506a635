"""Tasks side by side: each ends as if it were alone, and calls that are alike are answered as one."""

from __future__ import annotations

import json
import random
import threading
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
from golden import slips
from hypothesis import given
from hypothesis import strategies as st
from labs import scenes
from sheets import HABITS, lab, source

from gyrodata import analyze
from gyrodata.comparisons import look_for_patterns
from gyrodata.errors import GyroError
from gyrodata.fitting import NoFit, fit, screen
from gyrodata.measurements import Measurements
from gyrodata.plotting import render
from gyrodata.stacks import in_step, side_by_side, stacked


class Asked:
    """A function of one number, and which numbers it was asked for together."""

    def __init__(self, alike: Callable[[int], Any] = lambda number: "all") -> None:
        self.stacks: list[list[int]] = []
        self.square = stacked(alike)(self._answer)

    def _answer(self, calls: Sequence[tuple[int]]) -> list[int | Exception]:
        self.stacks.append([number for (number,) in calls])
        if any(number == 13 for (number,) in calls):
            raise ArithmeticError("thirteen")
        return [ValueError("seven") if number == 7 else number * number for (number,) in calls]

    def told(self, number: int) -> object:
        """Its square, or why there is none."""
        try:
            return self.square(number)
        except (ValueError, ArithmeticError) as error:
            return str(error)


class TestCalls:
    def test_calls_of_one_kind_are_one(self) -> None:
        asked = Asked()
        assert side_by_side(asked.square, [3, 1, 2]) == [9, 1, 4]
        assert asked.stacks == [[3, 1, 2]]

    def test_calls_of_other_kinds_are_others(self) -> None:
        asked = Asked(lambda number: number % 2)
        assert side_by_side(asked.square, [1, 2, 3, 4]) == [1, 4, 9, 16]
        assert sorted(asked.stacks) == [[1, 3], [2, 4]]

    def test_a_call_that_goes_with_no_other_is_answered_alone(self) -> None:
        asked = Asked(lambda number: None if number > 2 else "small")
        assert side_by_side(asked.square, [1, 4, 2, 3]) == [1, 16, 4, 9]
        assert sorted(asked.stacks) == [[1, 2], [3], [4]]

    def test_of_two_functions_each_has_its_own_calls(self) -> None:
        first, second = Asked(), Asked()

        def work(number: int) -> int:
            return first.square(number) if number % 2 else second.square(number)

        assert side_by_side(work, [1, 2, 3]) == [1, 4, 9]
        assert (first.stacks, second.stacks) == ([[1, 3]], [[2]])

    def test_who_is_behind_comes_up_with_the_others(self) -> None:
        early, late = Asked(), Asked()

        def work(number: int) -> int:
            for _ in range(number):
                early.square(1)
            return late.square(number)

        assert side_by_side(work, [1, 1, 3, 1]) == [1, 1, 9, 1]
        assert [len(stack) for stack in early.stacks] == [4, 1, 1]
        assert [sorted(stack) for stack in late.stacks] == [[1, 1, 1, 3]]

    def test_a_task_may_end_without_a_call(self) -> None:
        asked = Asked()
        assert side_by_side(lambda number: asked.square(number) if number > 1 else 0, [1, 2, 3]) == [0, 4, 9]
        assert asked.stacks == [[2, 3]]

    def test_nothing_is_nothing(self) -> None:
        assert side_by_side(Asked().square, []) == []

    def test_in_a_task_beside_others_another_thread_asks_for_itself(self) -> None:
        asked, told = Asked(), []

        def work(number: int) -> int:
            thread = threading.Thread(target=lambda: told.append(asked.square(10 * number)))
            thread.start()
            thread.join()
            return asked.square(number)

        assert side_by_side(work, [1, 2]) == [1, 4]
        assert sorted(told) == [100, 400]
        assert asked.stacks == [[10], [20], [1, 2]]

    def test_what_is_set_in_one_task_is_not_set_in_another(self) -> None:
        asked = Asked()

        def work(number: int) -> str:
            with np.errstate(over="raise" if number == 1 else "ignore"):
                asked.square(number)
                return np.geterr()["over"]

        assert side_by_side(work, [1, 2]) == ["raise", "ignore"]
        assert np.geterr()["over"] == "warn"

    @given(st.lists(st.lists(st.integers(14, 30), max_size=4), max_size=7))
    def test_every_task_gets_its_own_answers(self, tasks: list[list[int]]) -> None:
        asked = Asked(lambda number: number % 3)

        def work(numbers: list[int]) -> list[int]:
            return [asked.square(number) for number in numbers]

        assert side_by_side(work, tasks) == [[number * number for number in numbers] for numbers in tasks]


class TestFaults:
    def test_an_answer_that_is_an_exception_is_raised_where_it_was_asked_for(self) -> None:
        asked = Asked()
        with pytest.raises(ValueError, match="seven"):
            asked.square(7)
        assert side_by_side(asked.told, [6, 7, 8]) == [36, "seven", 64]
        assert asked.stacks[1:] == [[6, 7, 8]]

    def test_what_breaks_on_one_call_breaks_on_no_other(self) -> None:
        asked = Asked()
        assert side_by_side(asked.told, [12, 13, 14]) == [144, "thirteen", 196]
        assert asked.stacks == [[12, 13, 14], [12], [13], [14]]

    def test_a_task_that_breaks_is_heard_of(self) -> None:
        asked = Asked()
        with pytest.raises(ArithmeticError, match="thirteen"):
            side_by_side(asked.square, [1, 13])
        assert asked.square(3) == 9


class TestInStep:
    def test_all_begin_it_before_one_goes_on(self) -> None:
        told = []

        @in_step
        def begin(number: int, *, sign: int = 1) -> int:
            told.append(f"begins {number}")
            return sign * number

        def work(number: int) -> int:
            told.append(f"before {number}")
            found = begin(number, sign=-1)
            told.append(f"after {number}")
            return found

        assert side_by_side(work, [1, 2]) == [-1, -2]
        assert told == ["before 1", "before 2", "begins 1", "after 1", "begins 2", "after 2"]

    def test_alone_it_is_called(self) -> None:
        assert in_step(lambda number: number + 1)(1) == 2


# --- the logs of a class, to the last bit -------------------------------------------------------------------


def every_number(measured: Measurements) -> object:
    """Everything that a fit of some runs gives, to the last bit; or why there is none."""
    try:
        odd, _ = screen(measured)
        result = fit(measured, False, [one.index for one in odd if one.slip])
    except (NoFit, ValueError) as error:
        return str(error)
    assert result.posterior is not None
    adjusted, posterior = result.adjusted, result.posterior
    arrays = (
        result.covariance, result.deviations, result.influence, result.fitted_time, result.time_u, result.response,
        adjusted.shared, adjusted.gain, adjusted.rows, adjusted.orthogonal, adjusted.directions,
        posterior.weight, posterior.mean, posterior.u, posterior.factor, posterior.width,
    )  # fmt: skip
    told = (result.inertia, result.imbalance, result.timing_bias, result.budget, result.chi2, posterior.evidence)
    return repr((odd, told, look_for_patterns(measured, result))), [
        np.ascontiguousarray(one).tobytes() for one in arrays
    ]


def test_a_fit_is_the_same_to_the_last_bit_whoever_is_beside_it() -> None:
    logs = [measured for labs in slips().values() for measured in labs[::4]]
    logs += [measured for measured in scenes().values() if measured.sense.all()]
    alone = [every_number(measured) for measured in logs]
    order = random.Random(7).sample(range(len(logs)), len(logs))
    for begun in range(0, len(order), 24):
        some = order[begun : begun + 24]
        beside = side_by_side(every_number, [logs[at] for at in some])
        assert [at for at, found in zip(some, beside, strict=True) if found != alone[at]] == []


def test_so_is_all_that_is_said_of_a_log() -> None:
    def told(log: bytes) -> str:
        try:
            return json.dumps(analyze(log, name="log.csv").to_dict())
        except GyroError as error:
            return str(error.diagnostics)

    # Those of each habit twice, with other readings, so that there is something to stack.
    logs = [source(habit.make(lab(seed, habit.turns, habit.unloaded))) for habit in HABITS[::3] for seed in (1, 2)]
    assert side_by_side(told, logs) == [told(log) for log in logs]


def test_so_are_its_figures() -> None:
    def drawn(seed: int) -> dict[str, bytes]:
        # Beside others it is drawn between their fits.
        log = source(HABITS[0].make(lab(seed, HABITS[0].turns, HABITS[0].unloaded)))
        analysis = analyze(log, name="log.csv")
        return render(analysis, "png", names=("torque", "residuals")) if seed < 3 else {}

    assert side_by_side(drawn, [1, 2, 3]) == [drawn(seed) for seed in (1, 2, 3)]
