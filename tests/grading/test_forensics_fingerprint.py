"""The fingerprint of a log: the same for the same table however typed, small, and exact in JSON."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from grading.students import RPM, Course, Row, honest_log, print_of, text
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec import convert, to_builtins

from gyrodata.grading import Fingerprint, fingerprint, flag_class
from gyrodata.grading.forensics.logs import MOST_ROWS
from gyrodata.measurements import measure
from gyrodata.readings import read_log

SAMPLES = Path(__file__).parents[2] / "sample_data"
ROWS = honest_log(np.random.default_rng(1), Course(), 0)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**31), st.integers(1, 3), st.integers(0, 3))
def test_json_takes_it_there_and_back_exactly(seed: int, repeats: int, decimals: int) -> None:
    course = Course(repeats=repeats, decimals=decimals)
    one = print_of(text(honest_log(np.random.default_rng(seed), course, 0)))
    assert convert(json.loads(json.dumps(to_builtins(one))), Fingerprint) == one


def test_it_is_small() -> None:
    assert len(json.dumps(to_builtins(print_of(text(ROWS))))) < 1500


def test_of_a_huge_log_it_keeps_some_rows() -> None:
    rows = honest_log(np.random.default_rng(1), Course(repeats=100), 0)
    one = print_of(text(rows))
    assert len(one.time) == len(one.lines) == len(one.spin_step) == MOST_ROWS
    assert one.torque == tuple(sorted(one.torque))


def with_torques(rows: list[Row]) -> str:
    lines = [f"{float(m) * 1e-3 * 9.803 * float(x) * 1e-2!r},{s},{t},{f}" for m, x, s, t, f in rows]
    return "\n".join(["torque [N*m],spin [rpm],time [s],turns", *lines]) + "\n"


REWRITTEN: dict[str, Callable[[list[Row]], str]] = {
    "rows turned round": lambda rows: text(rows[::-1]),
    "other units": lambda rows: text(
        [(f"{float(m) / 1000}", f"{float(x) / 100:.3f}", s, t, f) for m, x, s, t, f in rows],
        "mass [kg],position [m],spin [rpm],time [s],turns",
    ),
    "weights as one torque": with_torques,
}


def values(one: Fingerprint) -> np.ndarray:
    return np.array([one.torque, one.spin, one.time, one.turns])


@pytest.mark.parametrize("how", REWRITTEN)
def test_order_and_units_are_gone(how: str) -> None:
    one, other = print_of(text(ROWS)), print_of(REWRITTEN[how](ROWS))
    np.testing.assert_allclose(values(other), values(one), rtol=1e-8)


def test_the_last_digit_typed_is_kept_in_si() -> None:
    one = print_of("# g: 9.803 m/s^2\nmass [g],position [cm],spin [rpm],time [s],turns\n20,15,206.5,7.06,1/3\n")
    assert one.spin_step == pytest.approx((0.1 * RPM,))
    assert one.time_step == (0.01,)
    periods = "# g: 9.803 m/s^2\nmass [g],position [cm],spin_start [rpm],spin_end [rpm],precession rate [rad/s]\n"
    rate = print_of(periods + "20,15,210,200,0.30\n")
    assert not rate.by_hand
    assert rate.time_step == pytest.approx((0.01 * 2 * np.pi / 0.3**2,), rel=1e-6)
    assert rate.spin_step == pytest.approx((205 * RPM / 200,), rel=1e-2)


def test_published_and_sample_logs_are_not_flagged() -> None:
    prints = {}
    for path in sorted(SAMPLES.glob("*.csv")):
        readings = read_log(path)
        prints[path.stem] = fingerprint(readings, measure(readings))
    assert len(prints) > 2
    assert flag_class(prints) == ()
