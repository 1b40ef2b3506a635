"""The next runs: the promised u is reached, and the choice is near the best."""

from __future__ import annotations

import itertools
import json
import math
import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from places import SAMPLES
from schemas import assert_valid
from simulated_labs import analyze_briefly
from typer.testing import CliRunner, Result

import gyrodata
from gyrodata.base.errors import GyroError
from gyrodata.cli import app
from gyrodata.judging.changes import Lab
from gyrodata.physics import RPM
from gyrodata.trials.plan import Limits, Plan, plan_lab, plan_log
from gyrodata.trials.simulation import TYPICAL, Design, Truth, simulate

SAMPLE = SAMPLES / "air_gyroscope.csv"
pytestmark = pytest.mark.filterwarnings("ignore::gyrodata.GyroWarning")


def run(*words: str | Path) -> Result:
    return CliRunner().invoke(app, ["plan", *map(str, words)], prog_name="gyro")


def setting(mass: float, rpm: float, turns: float = 1.0) -> tuple[float, ...]:
    return mass, 0.15 if mass else 0.0, 0.0, rpm * RPM, turns


LAB = [setting(mass, rpm) for mass in (0.02, 0.04, 0.06) for rpm in (200, 400, 600)]


def relative_u(log: str) -> float:
    inertia = analyze_briefly(log.encode()).inertia
    return (inertia.u or 0.0) / inertia.value


@cache
def sample_lab() -> Lab:
    return analyze_briefly(SAMPLE).lab


@cache
def usual_plan() -> Plan:
    return plan_log(sample_lab(), Limits())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("extra", "limits"),
    [
        (setting(0.02, 600), Limits((0.02,), (0.15,), (600 * RPM,))),
        (setting(0.06, 600, 2), Limits((0.06,), (0.15,), (600 * RPM,), (2.0,))),
        (setting(0.0, 400, 1 / 12), Limits(spins=(400 * RPM,))),
    ],
)
def test_the_promised_u_is_reached(extra: tuple[float, ...], limits: Limits) -> None:
    ratios = []
    truth = Truth(imbalance=6e-4)
    for seed in range(3):
        log = simulate(truth, Design(runs=(*LAB, extra)), TYPICAL, seed).log
        before = log[: log[:-1].rindex("\n") + 1]
        lab = analyze_briefly(before.encode()).lab
        choices = plan_log(lab, limits).choices
        [choice] = [one for one in choices if abs(one.mass - extra[0]) < 1e-3][:1]
        ratios.append(relative_u(log) / choice.u)
    assert 0.9 < np.median(ratios) < 1.1


@pytest.mark.slow
def test_the_first_choice_is_near_the_best_single_run() -> None:
    for seed in range(2):
        log = simulate(
            Truth(imbalance=6e-4), Design(runs=tuple(LAB)), TYPICAL, seed
        ).log
        plan = plan_log(analyze_briefly(log.encode()).lab, Limits())
        best = min(choice.u for choice in plan.choices)
        assert plan.choices[0].u < 1.1 * best
        assert plan.runs[0].mass == plan.choices[0].mass


def test_every_run_of_a_plan_reduces_u_and_the_time_is_kept() -> None:
    lab = sample_lab()
    for minutes in (0.0, 12.0):
        plan = plan_log(lab, Limits(minutes=minutes))
        assert plan.minutes <= minutes
        steps = [plan.now, *(planned.u for planned in plan.runs)]
        assert all(after < before for before, after in itertools.pairwise(steps))
        assert plan.u == steps[-1]


def test_a_goal_ends_the_plan_or_names_what_limits_u() -> None:
    near = run(SAMPLE, "--goal", "0.6%")
    assert near.exit_code == 0
    assert "is not reached" not in near.stdout
    far = run(SAMPLE, "--goal", "0.01%")
    assert "The goal of 0.01 % is not reached: a plan has at most 20" in far.stdout
    assert "The largest uncertainty is then: " in far.stdout
    assert "No run: the goal is reached." in run(SAMPLE, "--goal", "5").stdout


def test_a_plan_goes_on_to_a_goal_while_time_is_left() -> None:
    lab, usual = sample_lab(), usual_plan()
    assert usual.end == "no other run reduces u by more than 1 %"
    assert usual.minutes < 25
    # Its last runs gain less than 1 % each.
    goal = 0.97 * usual.u
    reached = plan_log(lab, Limits(goal=goal))
    assert reached.end == "the goal is reached"
    assert usual.minutes < reached.minutes <= 30
    assert reached.u <= goal < reached.runs[-2].u
    short = plan_log(lab, Limits(goal=goal, minutes=usual.minutes))
    assert (short.end, short.u > goal) == (
        "no other run fits into the time",
        True,
    )
    far = plan_log(lab, Limits(goal=goal / 10, minutes=math.inf))
    assert far.end == "a plan has at most 20 runs"


@pytest.mark.parametrize("minutes", [0.0, 5.0, 30.0])
def test_a_goal_that_is_reached_needs_no_run(minutes: float) -> None:
    plan = plan_log(sample_lab(), Limits(goal=0.05, minutes=minutes))
    assert (plan.runs, plan.end) == ((), "the goal is reached")
    # What the next run would be is still an answer.
    assert plan.choices == usual_plan().choices


def loads(plan: Plan) -> set[tuple[float, float]]:
    return {
        (round(choice.mass, 3), round(choice.position, 3))
        for choice in (*plan.choices, *plan.runs)
        if choice.mass
    }


def test_positions_alone_are_those_of_the_weights_of_the_log() -> None:
    lab = sample_lab()
    plan = plan_log(lab, Limits(positions=(0.1, 0.2)))
    assert {position for _, position in loads(plan)} <= {0.1, 0.2}
    assert {mass for mass, _ in loads(plan)} <= {0.02, 0.04, 0.06}
    # A second arm helps.
    assert plan.u < usual_plan().u
    both = plan_log(lab, Limits(masses=(0.03,), positions=(0.1,)))
    assert loads(both) == {(0.03, 0.1)}


@pytest.mark.parametrize("head", ["torque [mN m]", "force [N]"])
def test_a_log_of_torques_refuses_weights(head: str) -> None:
    position = {"torque [mN m]": "", "force [N]": ",position [cm]"}[head]
    rows = ["# motion: steady", f"{head},spin [rpm],time [s],turns{position}"]
    for torque, rpm in itertools.product((30, 60, 90), (200, 400, 600)):
        time = 2 * np.pi * 4.44e-3 * rpm * RPM / (torque / 1000)
        size = f"{torque},{rpm},{time:.2f},1"
        if position:
            size = f"{torque / 1000 / 0.15:.4f},{rpm},{time:.2f},1,15"
        rows.append(size)
    lab = analyze_briefly("\n".join(rows).encode()).lab
    assert plan_log(lab, Limits(minutes=5.0)).choices
    for limits in (Limits(positions=(0.1,)), Limits(masses=(0.02,))):
        with pytest.raises(GyroError, match="no masses"):
            plan_log(lab, limits)


def test_runs_that_check_would_doubt_are_left_out() -> None:
    plan = plan_lab(Limits(masses=(0.02, 0.5, 60.0), positions=(0.15, 0.3, 15.0)))
    assert {*plan.left_out} == {"mass", "position", "time"}
    assert plan.left_out["mass"].startswith("60000.0 g at ")
    assert plan.first
    for planned in (*plan.first, *plan.choices, *plan.runs):
        assert planned.time >= 6
        assert planned.mass <= 5
        assert planned.position <= 1
    assert plan_lab(Limits()).left_out == {}
    # More turns can be timed.
    parts = plan_lab(Limits(turns=(1 / 12, 1.0)))
    assert (parts.first[0].turns, [*parts.left_out]) == (1.0, ["time"])
    heavy = Limits(masses=(0.5,), positions=(0.3,), turns=(20.0,))
    assert plan_lab(heavy).first


@pytest.mark.parametrize(
    "words",
    [
        ("--weights", "60kg"),
        ("--positions", "15m"),
        ("--weights", "500g", "--positions", "30cm"),
        ("--turns", "1/100"),
        (SAMPLE, "--positions", "15m"),
        (SAMPLE, "--weights", "60kg"),
    ],
)
def test_a_plan_without_a_possible_run_is_refused(words: tuple[str, ...]) -> None:
    result = run(*words)
    assert (result.exit_code, result.stdout) == (2, "")
    assert "no run can be planned" in result.stderr
    assert "--turns" in result.stderr


def test_repeated_values_count_once() -> None:
    usual = (0.02, 0.04), (0.1, 0.15), (20.0, 40.0), (1.0, 2.0)
    once = plan_lab(Limits(*usual))
    for number, values in enumerate(usual):
        repeated = Limits(*usual[:number], values * 3, *usual[number + 1 :])
        assert plan_lab(repeated) == once
    lab = sample_lab()
    all_repeated = Limits(*[values * 3 for values in usual], minutes=5.0)
    short = Limits(*usual, minutes=5.0)
    planned = plan_log(lab, short)
    assert len(planned.runs) > 0
    assert plan_log(lab, all_repeated) == planned


def test_a_time_that_is_too_short_is_not_promised() -> None:
    before = run("--minutes", "0").stdout
    assert before.startswith(
        "The first runs of a lab, which take more than 0 minutes:\n"
    )
    assert "A plan for 9 minutes" in run("--minutes", "9").stdout
    during = run(SAMPLE, "--minutes", "1").stdout
    assert "No run: no other run fits into the time." in during


def test_before_the_lab_each_weight_comes_first() -> None:
    plan = plan_lab(Limits(masses=(0.03, 0.05), positions=(0.12,)))
    assert [planned.mass for planned in plan.first] == [0.03, 0.05]
    assert plan.now is None
    assert plan.u < plan.first[-1].u
    assert {planned.mass for planned in plan.runs} <= {0.0, 0.03, 0.05}


def test_json_is_as_its_schema_says() -> None:
    document = json.loads(run(SAMPLE, "--format", "json").stdout)
    assert_valid(document, "plan")
    assert document["schema"] == "gyro.plan/1"


def filled_in(table: str) -> list[str]:
    """Fill in the spin and the time that the note of each run names."""
    header, *lines = [line for line in table.splitlines() if line[0] != "#"]
    columns = {name: at for at, name in enumerate(header.split(","))}
    rows = [header]
    for line in lines:
        cells = line.split(",")
        spin, time = re.fullmatch(
            r"aim at (\d+) rpm \((?:about (\S+) s|watch it for 3 minutes)\)", cells[-1]
        ).groups()
        cells[columns["spin [rpm]"]] = f"{float(spin):.1f}"
        cells[columns["time [s]"]] = f"{float(time or 120):.2f}"
        if time is None:
            cells[columns["turns"]] = "0"
        rows.append(",".join(cells))
    return rows


def test_the_table_can_be_filled_in_and_analysed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run("--weights", "30g,60g", "--out", "runs.csv").exit_code == 0
    again = run("--out", "runs.csv")
    assert again.exit_code == 2
    rows = filled_in(Path("runs.csv").read_text(encoding="utf-8"))
    assert any(row.startswith("0,") for row in rows)
    lab = gyrodata.analyze("\n".join(rows).encode())
    assert lab.inertia.value == pytest.approx(Truth().inertia, rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("more", [[], ["--weights", "30g,50g", "--positions", "10cm"]])
def test_planned_runs_are_analysed_together_with_the_log(
    more: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("log.csv").write_bytes(SAMPLE.read_bytes())
    before = gyrodata.analyze("log.csv")
    assert run("log.csv", "--minutes", "15", "--out", "plan.csv", *more).exit_code == 0
    rows = filled_in(Path("plan.csv").read_text(encoding="utf-8"))
    Path("plan.csv").write_text("\n".join(rows), encoding="utf-8")
    lab = gyrodata.analyze([Path("log.csv"), Path("plan.csv")], together=True)
    assert len(lab.run_table) >= len(before.run_table) + len(rows) - 2
    assert lab.inertia.value == pytest.approx(before.inertia.value, rel=0.01)
    assert lab.inertia.u < before.inertia.u
    if not more:
        # A planned run has the weight of the log.
        assert {run.mass for run in lab.run_table if run.mass} == {
            run.mass for run in before.run_table if run.mass
        }


def test_a_wrong_option_says_what_to_type() -> None:
    assert "write one behind it: g, kg" in run("--weights", "30").stderr
    assert run("--goal", "much").exit_code == 2
    assert run("missing.csv").exit_code == 2


def test_a_doubt_comes_before_the_plan(tmp_path: Path) -> None:
    sample = SAMPLE.read_text(encoding="utf-8")
    wrong = re.sub("(?m)^# ball_mass: .*", "# ball_mass: 8 kg", sample)
    assert wrong != sample
    (tmp_path / "log.csv").write_text(wrong, encoding="utf-8")
    assert "first find the cause of this: " in run(tmp_path / "log.csv").stderr
