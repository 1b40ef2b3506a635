"""A lab's fits tried out on labs like it: what an honest uncertainty covers, and what
the textbook's does.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from analyzed_once import analyzed_once
from gates.drawn_logs import Bench, draw, write
from places import SAMPLES
from typer.testing import CliRunner

import gyrodata
from gyrodata.cli import app

SALORT = SAMPLES / "salort_one_torque.csv"
STEADY = "# motion: steady\n"
"""A silent log is fitted for other motions too, which takes much longer."""


def selfcheck(log: str, labs: int, *options: str) -> str:
    done = CliRunner().invoke(
        app, ["selfcheck", "-", "--labs", str(labs), *options], input=log
    )
    assert done.exit_code == 0, done.output
    return done.stdout


def fits(log: str, labs: int) -> dict[str, dict[str, Any]]:
    """Performance of each fit by its name."""
    return {
        one["name"]: one
        for one in json.loads(selfcheck(log, labs, "--format", "json"))["estimators"]
    }


def test_no_simulated_lab_is_refused() -> None:
    lab = gyrodata.analyze(SAMPLES / "air_gyroscope.csv")
    with pytest.raises(ValueError, match="labs must be at least 1"):
        gyrodata.selfcheck(lab, labs=0)


@pytest.mark.slow
@pytest.mark.parametrize(
    "bench", [Bench(hand=0.12), Bench(repeats=3, imbalance=0.2, hand=0.13)], ids=str
)
def test_the_recommended_fit_is_honest_and_the_textbook_is_not(bench: Bench) -> None:
    by_name = fits(write(draw(bench, 3), f"{STEADY}# u_time: 0.14 s"), 100)
    best = by_name["recommended"]
    # Three standard deviations of a binomial of 100.
    assert best["coverage_68"] == pytest.approx(0.683, abs=0.14)
    assert best["coverage_95"] == pytest.approx(0.954, abs=0.063)
    # M0 is up to a fifth of the lightest torque.
    assert best["bias"] == pytest.approx(0, abs=0.003)
    # u also contains a balance that may differ between weights; here it does not.
    assert 0.8 < best["mean_u"] / best["rmse"] < 1.4
    for name in ("through_origin", "with_constant", "mean_of_ratios"):
        assert by_name[name]["coverage_95"] < 0.9


@pytest.mark.slow
def test_a_log_with_more_scatter_is_also_tried_with_its_own() -> None:
    log = write(draw(Bench(repeats=3, hand=0.5), 3), f"{STEADY}# u_time: 0.14 s")
    with analyzed_once():
        found = json.loads(selfcheck(log, 24, "--format", "json"))
        text = selfcheck(log, 2)
    assert found["scatter"] == pytest.approx(0.5 / 0.14, rel=0.4)
    stated, own = (
        found[table][0] for table in ("estimators", "estimators_with_scatter")
    )
    assert (stated["name"], own["name"]) == ("recommended", "recommended")
    assert own["coverage_95"] == pytest.approx(0.95, abs=0.05)
    assert own["rmse"] > 1.4 * stated["rmse"]
    assert (
        f"this log scatters {found['scatter']:.2g} times as much as stated"
        in text.splitlines()[0]
    )
    assert text.count("\nrecommended ") == 2
    agreeing = selfcheck(log.replace("0.14 s", "0.5 s"), 2)
    assert "scatters as stated" in agreeing.splitlines()[0]
    assert agreeing.count("\nrecommended ") == 1


@pytest.mark.slow
def test_salort_log_is_covered_and_no_lab_is_refused() -> None:
    found = json.loads(
        selfcheck(SALORT.read_text(encoding="utf-8"), 60, "--format", "json")
    )
    for best in (found["estimators"][0], found["estimators_with_scatter"][0]):
        assert (best["name"], best["refused"]) == ("recommended", 0)
        assert best["coverage_95"] > 0.9
        assert abs(best["bias"]) < 0.15
        assert best["mean_u"] > 0


ONE = write(draw(Bench(masses=(40,)), 2), STEADY)
TESTED = write(draw(Bench(imbalance=0.01), 2), f"{STEADY}# u_imbalance: 2e-4 N*m")
UNSENSED = write(draw(Bench(imbalance=0.02), 2), STEADY) + "0,,400,1100,1/12\n"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("log", "least"),
    [(ONE, 0.94), (TESTED, 0.88), (UNSENSED, 0.88)],
    ids=["one torque", "balance test", "unknown sense"],
)
def test_an_unusual_lab_is_covered_too(log: str, least: float) -> None:
    assert fits(log, 60)["recommended"]["coverage_95"] > least


@pytest.mark.slow
def test_each_day_is_simulated_with_its_own_balance(tmp_path: Path) -> None:
    days = {
        f"{seed}.csv": gyrodata.simulate(gyrodata.Truth(imbalance=m0), seed=seed).log
        for seed, m0 in ((3, 3e-3), (4, -3e-4))
    }
    for name, log in days.items():
        (tmp_path / name).write_text(log, encoding="utf-8")
    paths = [str(tmp_path / name) for name in days]
    words = ["selfcheck", *paths, "--labs", "30", "--format", "json"]
    by_files = json.loads(CliRunner().invoke(app, words).stdout)["estimators"]
    assert by_files[0]["coverage_95"] >= 0.88
    # One line through the origin does not know of the two balances.
    assert by_files[1]["coverage_95"] < 0.6
    monday, friday = (log.splitlines() for log in days.values())
    head = [line for line in monday[1:] if line.startswith("#")]
    start = len(head) + 1
    rows = [f"{row},monday" for row in monday[start + 1 :]]
    rows += [f"{row},friday" for row in friday[start + 1 :]]
    log = "\n".join([*head, f"{monday[start]},day", *rows])
    by_column = fits(log, 30)["recommended"]
    times = {"time_us": 0.0}
    assert {**by_column, **times} == pytest.approx({**by_files[0], **times})


def test_a_notebook_shows_the_table_as_html() -> None:
    lab = gyrodata.analyze(SALORT)
    check = gyrodata.selfcheck(lab, labs=2)
    page = check._repr_html_()
    assert page.startswith("<pre")
    assert "recommended" in page
    assert "<" not in page[4:-6]
