"""What people write instead of the plain log: the same runs, so the same I_zz, or a
question.

Each was once read as something else: half turns as whole ones, the number of a run as
its turns."""

from __future__ import annotations

import itertools
import math
import tomllib
from typing import Any

import numpy as np
import pytest
from places import DATA
from simulated_labs import analyze_briefly as analyze

from gyrodata import LogError
from gyrodata.readings import read_log

TRUTH = 4.4e-3
G = 9.803
CELLS = tomllib.loads((DATA / "odd_cells.toml").read_text(encoding="utf-8"))


def log(template: str, turns: float = 1.0, slower: float = 1.0) -> bytes:
    """Write the line with a * for each of nine runs, with its number, mass [g], spin
    [rpm] and time [s].
    """
    random = np.random.default_rng(5)
    head, star, row = template.partition("\n*")
    lines = [f"# g: {G} m/s^2", head]
    for number, (mass, spin) in enumerate(
        itertools.product((20.1, 40.3, 60.2), (212, 398, 604)) if star else (), 1
    ):
        one = 2 * math.pi * TRUTH * spin * math.pi / 30 / (mass * 1e-3 * G * 0.148)
        time = slower * turns * one + 0.05 * random.standard_normal()
        told = {"number": number, "mass": mass, "spin": spin, "time": time}
        lines.append(
            row.format_map(told | {"minutes": time // 60, "seconds": time % 60})
        )
    return ("\n".join(lines) + "\n").encode()


@pytest.mark.slow
@pytest.mark.parametrize(
    "case", CELLS["meant"], ids=lambda case: case["log"].partition("\n*")[0]
)
def test_it_is_read_as_it_is_meant(case: dict[str, Any]) -> None:
    analysis = analyze(log(case["log"], case["turns"]))
    assert analysis.inertia.value == pytest.approx(
        TRUTH, abs=3 * (analysis.inertia.u or 0.0)
    )
    assert 0 < (analysis.inertia.u or 0.0) < 0.03 * TRUTH
    assert [run.turns for run in analysis.run_table] == pytest.approx(
        [case["turns"]] * 9
    )


@pytest.mark.slow
@pytest.mark.parametrize("case", CELLS["asked"], ids=lambda case: case["says"])
def test_what_may_mean_two_things_is_asked_about(case: dict[str, str]) -> None:
    told = read_log(log(case["log"])).diagnostics
    assert any(
        case["says"] in one.message + one.hint
        for one in told
        if one.code == case["code"]
    )


def test_a_time_given_as_an_option_does_not_take_the_turns_of_the_header() -> None:
    template = (
        "mass [g],position [cm],spin [rpm],time for 5 turns [s]\n"
        "*{mass},14.8,{spin},{time:.2f}"
    )
    told = read_log(log(template), settings={"time": "20 s"}).diagnostics
    assert [one.code for one in told] == ["G304", "G301"]


HEAD = "mass [g],position [cm],spin [rpm],time [s],"
PLAIN = f"{HEAD}turns\n*{{mass}},14.8,{{spin}},{{time:.2f}},1"
ONCE = log(PLAIN).decode()


def test_a_position_between_the_runs_is_that_of_the_runs_below() -> None:
    below = log(PLAIN, slower=14.8 / 10.0).decode().split("\n", 2)[2]
    analysis = analyze(
        f"{ONCE}moved the weight to 10.0 cm\n{below.replace(',14.8,', ',,')}".encode()
    )
    assert [run.position for run in analysis.run_table] == pytest.approx(
        [0.148] * 9 + [0.1] * 9
    )
    assert analysis.inertia.value == pytest.approx(TRUTH, rel=0.03)


def test_runs_copied_below_with_a_column_more_are_refused() -> None:
    head, *rows = ONCE.splitlines()[1:]
    copy = "\n".join(
        [f"{head},period [s]", *(f"{row},{row.split(',')[3]}" for row in rows)]
    )
    with pytest.raises(LogError, match=r'the table below line 13 has "period \[s\]"'):
        analyze(f"{ONCE}\n{copy}\n".encode())


def test_a_line_that_every_run_overrules_is_named() -> None:
    analysis = analyze(f"# turns: 2\n{ONCE}".encode())
    (told,) = (one for one in analysis.diagnostics if one.code == "G220")
    assert told.message == '"# turns: 2" is not used: each run has its own in "turns"'
    assert told.line == 1


def test_a_time_of_a_phone_as_it_is_asked_for_is_the_time_itself() -> None:
    with pytest.raises(LogError, match=r"00:20:13"):
        analyze(f"{HEAD}turns\n20.1,14.8,212,00:20:13,1\n".encode())
    for unit, time, seconds in (
        ("[s]", "00:20.13", 20.13),
        ("[min:s]", "20:13", 1213.0),
    ):
        head = HEAD.replace("time [s]", f"time {unit}")
        column = read_log(f"{head}turns\n20.1,14.8,212,{time},1\n".encode()).columns[
            "time"
        ]
        assert column.values == (pytest.approx(seconds, rel=1e-12),)
