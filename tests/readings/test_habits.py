"""What people write instead of the plain log: the same runs, so the same I_zz, or a question.

Each was once read as something else: half turns as whole ones, the number of a run as its turns.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable

import numpy as np
import pytest

from gyrodata import LogError, analyze
from gyrodata.readings import read_log

TRUTH = 4.4e-3
G = 9.803
Row = Callable[[int, float, float, float], str]


def log(head: str, row: Row, turns: float = 1.0, slower: float = 1.0) -> bytes:
    """Nine runs: `row` writes the number of a run, its mass [g], its spin [rpm] and its time [s]."""
    random = np.random.default_rng(5)
    lines = [f"# g: {G} m/s^2", head]
    for number, (mass, spin) in enumerate([(m, s) for m in (20.1, 40.3, 60.2) for s in (212, 398, 604)], 1):
        one = 2 * math.pi * TRUTH * spin * math.pi / 30 / (mass * 1e-3 * G * 0.148)
        lines.append(row(number, mass, spin, slower * turns * one + 0.05 * random.standard_normal()))
    return ("\n".join(lines) + "\n").encode()


def plain(*, turns: str, mass: str = "", spin: str = "") -> Row:
    return lambda _, m, s, t: f"{mass or m},14.8,{spin or s},{t:.2f},{turns}"


HEAD = "mass [g],position [cm],spin [rpm],time [s],"
NO_COUNT = "mass [g],position [cm],spin [rpm],"


def only(_: int, mass: float, spin: float, time: float) -> str:
    return f"{mass},14.8,{spin},{time:.2f}"


def inches(_: int, mass: float, spin: float, time: float) -> str:
    return f"{mass},{14.8 / 2.54:.3f},{spin},{time:.2f},3"


def numbered(number: int, mass: float, spin: float, time: float) -> str:
    return f"{number},{mass},14.8,{spin},{time:.2f},2"


def parted(_: int, mass: float, spin: float, time: float) -> str:
    """Minutes and seconds, each in its column."""
    return f"{mass},14.8,{spin},{time // 60:.0f},{time % 60:.1f},9"


@pytest.mark.parametrize(
    ("head", "row", "turns"),
    [
        (HEAD + "half turns", plain(turns="2"), 1),
        *((HEAD + "turns", plain(turns=cell), turns) for cell, turns in {
            "4 et demi": 4.5, "5 and a half turns": 5.5, "two thirds of a turn": 2 / 3,
        }.items()),
        *((NO_COUNT + header, only, turns) for header, turns in {
            "Time (1 1/2 turns) [s]": 1.5, "four and a half turns (s)": 4.5,
        }.items()),
        # What numbers the runs is no count of turns, and no mass.
        *((f"{name},{HEAD}turns", numbered, 2) for name in ("n", "m")),
        ("mass（g）,arm (in),spin（rpm）,time（s）,turns", inches, 3),
        (HEAD + "rotation [deg]", plain(turns="720"), 2),
        # Minutes and seconds in two columns, also below one name.
        (NO_COUNT + "t (min),t (s),turns", parted, 9),
        ("mass,position,spin,time,,turns\ng,cm,rpm,min,s,", parted, 9),
    ],
)  # fmt: skip
def test_it_is_read_as_it_is_meant(head: str, row: Row, turns: float) -> None:
    analysis = analyze(log(head, row, turns))
    assert analysis.inertia.value == pytest.approx(TRUTH, abs=3 * (analysis.inertia.u or 0.0))
    assert 0 < (analysis.inertia.u or 0.0) < 0.02 * TRUTH
    assert [run.turns for run in analysis.run_table] == pytest.approx([turns] * 9)


@pytest.mark.parametrize(
    ("head", "row", "code", "words"),
    [
        (HEAD + "turns", lambda _, m, s, t: f"{m},14.8,{s + 4}/{s - 4},{t:.2f},1", "G203",
         "write them in two columns, spin_start [rpm] and spin_end [rpm]"),
        (HEAD + "turns", lambda _, m, s, t: f"{m},14.8,{s},1m6.5s,1", "G203", "write it as 01:06.5"),
        (HEAD + "turns", plain(turns="1", mass="20. Jan"), "G204", "did you mean 20.1?"),
        (NO_COUNT + "Time for 5 half turns (s)", only, "G301", "(s)\" --set turns=…?"),
        # Sentences above the table, and a header that its own comma parts.
        ("Waited 3 turns before the stopwatch was started\n" + HEAD[:-1], only, "G301", "add a column turns"),
        ("Steel ball, m = 4.28 kg, r = 5.08 cm\nmass [g],spin [rpm],time [s],turns",
         lambda _, m, s, t: f"{m},{s},{t:.2f},1", "G301", "add a column position [cm]"),
        ("2 weights of 20.15 g\nposition [cm],spin [rpm],time [s],turns", lambda _, m, s, t: f"14.8,{s},{t:.2f},1",
         "G301", "add a column mass [g]"),
        (NO_COUNT + "precession period [s], 5 turns", only, "G232", 'as "time for 5 turns [s]"'),
        (NO_COUNT + "time for 1/3 turn [s]", lambda _, m, s, t: f"{m},14.8,{s},", "G202", "fill the times in"),
    ],
)  # fmt: skip
def test_what_may_mean_two_things_is_asked_about(head: str, row: Row, code: str, words: str) -> None:
    with pytest.raises(LogError) as told:
        analyze(log(head, row))
    assert words in next(one.hint for one in told.value.diagnostics if one.code == code)


@pytest.mark.parametrize(
    ("head", "turns"),
    [
        (NO_COUNT + "time for 5 turns [s]", 5),
        ("All times for 3 turns\n" + HEAD[:-1], 3),
        ("Ball 2, weight 20 g steps, 1/3 turn\n" + HEAD[:-1], 1 / 3),
    ],
)
def test_what_is_asked_for_gives_the_answer(head: str, turns: float) -> None:
    assert analyze(log(head, only, turns)).inertia.value == pytest.approx(TRUTH, rel=0.03)


ONCE = log(HEAD + "turns", plain(turns="1")).decode()


def test_a_position_between_the_runs_is_that_of_the_runs_below() -> None:
    below = log(HEAD + "turns", plain(turns="1"), slower=14.8 / 10.0).decode().split("\n", 2)[2]
    analysis = analyze(f"{ONCE}moved the weight to 10.0 cm\n{below.replace(',14.8,', ',,')}".encode())
    assert [run.position for run in analysis.run_table] == pytest.approx([0.148] * 9 + [0.1] * 9)
    assert analysis.inertia.value == pytest.approx(TRUTH, rel=0.03)


def test_positions_from_the_surface_are_stated_as_the_hint_says() -> None:
    title = "Distances measured from the surface of the ball, diameter 101.6 mm"
    said = f"{title}\n{ONCE.replace(',14.8,', ',9.72,')}"
    hint = next(one.hint for one in analyze(said.encode()).diagnostics if one.code == "G214")
    lines = re.findall('"(# .*?)"', hint)
    assert lines == ["# position_from: surface", "# ball_diameter: 10.16 cm"]
    assert analyze("\n".join([*lines, said]).encode()).inertia.value == pytest.approx(TRUTH, rel=0.03)


def test_runs_copied_below_with_a_column_more_count_once() -> None:
    head, *rows = ONCE.splitlines()[1:]
    copy = "\n".join([f"{head},period [s]", *(f"{row},{row.split(',')[3]}" for row in rows)])
    twice = analyze(f"{ONCE}\n{copy}\n".encode())
    assert (len(twice.run_table), twice.inertia) == (9, analyze(ONCE.encode()).inertia)
    assert "repeats 9 runs that stand above: left out" in next(d.message for d in twice.diagnostics if d.code == "G143")


def test_a_line_that_every_run_overrules_is_named() -> None:
    analysis = analyze(f"# turns: 2\n{ONCE}".encode())
    (told,) = (one for one in analysis.diagnostics if one.code == "G220")
    assert told.message == '"# turns: 2" is not used: each run has its own in the column "turns"'
    assert told.line == 1


def test_a_time_of_a_phone_as_it_is_asked_for_is_the_time_itself() -> None:
    with pytest.raises(LogError, match=r"00:20:13"):
        analyze(f"{HEAD}turns\n20.1,14.8,212,00:20:13,1\n".encode())
    for unit, time, seconds in (("[s]", "00:20.13", 20.13), ("[h:min:s]", "00:20:13", 1213.0)):
        head = HEAD.replace("time [s]", f"time {unit}")
        column = read_log(f"{head}turns\n20.1,14.8,212,{time},1\n".encode()).columns["time"]
        assert column.values == (pytest.approx(seconds, rel=1e-12),)
