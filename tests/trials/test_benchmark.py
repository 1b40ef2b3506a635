"""The benchmark: what it measures, draws and says."""

from __future__ import annotations

import itertools
import math
import re
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from msgspec.structs import replace
from typer.testing import CliRunner

import gyrodata
from gyrodata import fitting, physics
from gyrodata.cli import app
from gyrodata.measurements import Measurements
from gyrodata.physics import RPM
from gyrodata.reporting import figures
from gyrodata.trials.benchmark import (
    charts,
    fits,
    integrators,
    labs,
    maps,
    motions,
    programs,
    report,
)
from gyrodata.trials.simulation import Motion, Runs, Truth, happen

# All tests use the same benchmark, which takes more than a moment.
pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
LOG = ROOT / "sample_data" / "air_gyroscope.csv"
TINY = replace(report.QUICK, labs=2, budgets={1: 1_000, 2: 1_000}, every=1)
SMALL = [replace(kind, x=kind.x[:2], y=kind.y[:2]) for kind in maps.KINDS]
"""Maps of which TINY computes four cells."""
MAPS = {kind.name: kind for kind in maps.KINDS}
CHARTS = ["fits", "motion", "integrators", *MAPS]


@pytest.fixture(scope="module", autouse=True)
def times_are_measured_once() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(motions, "REPEATS", 1)
        yield


@pytest.fixture(scope="module")
def done() -> Mapping[str, pd.DataFrame]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(maps, "KINDS", SMALL)
        return report.run(TINY, 0)


@pytest.fixture(scope="module")
def written(
    done: Mapping[str, pd.DataFrame], tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, str]:
    """Return the folder that the command writes, and its messages."""
    folder = tmp_path_factory.mktemp("benchmark")
    words = ["benchmark", str(LOG), "--quick", "--out", str(folder)]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(report, "run", lambda *_: done)
        # This process has loaded what draws.
        patch.setattr("gyrodata.base.workers.count_workers", lambda: 0)
        result = CliRunner().invoke(app, words)
    assert result.exit_code == 0, result.output
    return folder, result.stderr


# --- programs ---


def lab() -> tuple[Measurements, dict[str, Any]]:
    measured = labs.measured_lab(labs.SCENES[0].draw(2))
    return measured, labs.lab_of(measured)


def test_a_line_with_an_intercept_has_student_s_interval() -> None:
    measured, given = lab()
    value, low, high = programs.PROGRAMS[programs.LINE](given)
    usual = fitting.TEXTBOOK["with_constant"](measured.product, measured.torque)
    assert value == pytest.approx(float(usual[0]), rel=2e-3)
    # Student's factor for seven degrees of freedom.
    assert (high - low) / 2 == pytest.approx(2.3646 * float(usual[1]), rel=0.02)


def test_a_line_with_an_intercept_needs_different_torques() -> None:
    _, given = lab()
    with pytest.raises(ValueError, match="different torques"):
        programs.PROGRAMS[programs.LINE]({**given, "torque": np.full(9, 0.03)})


@pytest.mark.parametrize("name", programs.PROGRAMS)
def test_a_program_finds_the_inertia_of_exact_readings(name: str) -> None:
    if name in programs.OPTIONAL:
        pytest.importorskip(name)
    _, given = lab()
    time = Truth().inertia * given["angle"] / given["torque"]
    value, low, high = programs.PROGRAMS[name]({**given, "time": time})
    # kafe2 stops when it is near.
    allowed = 2e-3 if name == "kafe2" else 2e-5
    assert value == pytest.approx(Truth().inertia, rel=allowed)
    assert low * (1 - 1e-9) <= Truth().inertia <= high * (1 + 1e-9)


def test_the_full_covariance_with_the_hand_s_bias_ties() -> None:
    truth, covered, of_gyro, errors = Truth().inertia, 0, 0, []
    seeds = range(60)
    for seed in seeds:
        measured = labs.measured_lab(labs.SCENES[0].draw(seed))
        given = labs.lab_of(measured)
        line = fitting.fit_line(
            programs.product(given),
            given["torque"],
            given["product_cov"],
            given["torque_cov"],
        )
        covered += abs(line.slope - truth) <= 1.96 * line.u_slope
        value, low, high, _ = fits.fit_once(measured)
        of_gyro += low <= truth <= high
        errors.append((line.slope / truth - 1, value / truth - 1))
    assert min(covered, of_gyro) >= 0.88 * len(seeds)
    full, mine = np.sqrt(np.mean(np.square(errors), axis=0))
    assert full == pytest.approx(mine, rel=0.15)


def test_a_program_runs_without_gyrodata(tmp_path: Path) -> None:
    code = (
        f"import runpy, sys; runpy.run_path({programs.__file__!r}); print(*sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True
    )
    assert "numpy" in done.stdout
    assert "gyrodata" not in done.stdout


@pytest.mark.parametrize("name", [programs.LINE, fits.GYRO])
def test_a_whole_process_costs_more_than_its_fit(name: str) -> None:
    log = labs.SCENES[0].draw(2)
    [row] = fits.process_cost(name, log)
    warm = {row["method"]: row["seconds"] for row in fits.fit_lab(labs.SCENES[0], 2)}
    assert row["method"] == name
    assert row["process"] > warm[name]


def answers(values: Any, half: float) -> pd.DataFrame:
    columns = {"value": values, "low": values - half, "high": values + half}
    return pd.DataFrame({**columns, "reacts": False, "seconds": 0.1})


def test_a_score_counts_the_labs_whose_interval_contains_the_truth() -> None:
    values = np.linspace(0.9, 1.1, 200)
    values[:20] = math.nan
    score = fits.score(answers(values, 0.11))
    assert (score["coverage"], score["refused"]) == (0.9, 20)
    # Wilson's interval of 190 of 200, R: prop.test(190, 200, correct = FALSE).
    values = np.where(np.arange(200) < 10, 0.9, 1.0)
    score = fits.score(answers(values, 0.05))
    ends = score["coverage_low"], score["coverage_high"]
    assert ends == pytest.approx((0.91042, 0.97261), abs=1e-4)


def test_the_interval_of_an_error_contains_the_true_quantile() -> None:
    random = np.random.default_rng(1)
    inside = []
    for _ in range(100):
        score = fits.score(answers(1 + 0.01 * random.standard_normal(200), 0.02))
        low, high = score["error_low"], score["error_high"]
        assert low <= score["error"] <= high
        # 68 % of normal numbers are closer to zero than this.
        inside.append(low <= 0.0099446 <= high)
    # Three standard deviations of a binomial of 100 below 0.95.
    assert 0.88 < np.mean(inside) < 1


def test_the_colour_of_an_error_is_its_coverage() -> None:
    score = fits.score(answers(1 + np.linspace(-0.01, 0.01, 200), 0.0095))
    names = ["mean of ratios", "gyro"]
    rows = pd.DataFrame([{"scene": "a", "method": name, **score} for name in names])
    rows[["coverage", "seconds"]] = [[0.4, 0.013], [0.95, 0.02]]
    with figures.own_style(charts.STYLE):
        figure = Figure()
        charts.draw_points(figure, rows, [("seconds", "error")], "error")
    panel, bar = figure.axes
    colours = [part.get_array() for part in panel.collections]
    assert [part.tolist() for part in colours if part is not None] == [[0.4], [0.95]]
    assert bar.get_ylabel() == charts.LABELS["coverage"]
    _, words = panel.get_legend_handles_labels()
    assert words == names
    # The error bar of the point is that of its table.
    ends = [line.get_segments()[0][:, 1] for line in bars(panel)]
    assert ends[0] == pytest.approx([score["error_low"], score["error_high"]])


def bars(panel: Any) -> list[Any]:
    return [part for part in panel.collections if isinstance(part, LineCollection)]


def test_the_statistics_of_a_map_are_what_they_are_called() -> None:
    values = 1 + 0.01 * np.random.default_rng(1).standard_normal(4000)
    right = fits.score(answers(values, 0.0196))
    assert right["coverage"] == pytest.approx(0.95, abs=0.01)
    assert right["length"] == pytest.approx(1, abs=0.05)
    assert right["error"] == pytest.approx(0.01, rel=0.05)
    assert fits.score(answers(values + 0.02, 0.0196))["bias"] == pytest.approx(
        2, abs=0.1
    )


def test_labs_are_as_messy_as_their_scene_says() -> None:
    sheet, messy, disagree = labs.SCENES
    logs = [messy.draw(seed) for seed in range(40)]
    assert 4 <= sum(",1/2," in log for log in logs) <= 16
    assert all(log.count(",1/2,") <= 1 for log in logs)
    assert all("# u_time: 0.14 s" in log for log in logs)
    assert sheet.draw(1) == sheet.draw(1)
    weights = [labs.measured_lab(disagree.draw(seed)).mass for seed in range(20)]
    # One gram for each weight, not for each run.
    assert np.std([mass[0] for mass in weights]) == pytest.approx(1e-3, rel=0.5)
    assert all(mass[0] == mass[2] != mass[3] for mass in weights)


# --- motion ---


def usual_runs() -> Runs:
    return happen(Truth(), labs.SCENES[0].design)


def test_no_ordinary_point_knows_what_no_user_knows() -> None:
    true, known = motions.draw_labs(motions.SCENES[0], usual_runs(), 20, 1)
    assert known.push == physics.models.PART_RELEASED
    assert np.ndim(known.decay) == 0
    off = known.pitch - true.pitch
    assert np.std(off) == pytest.approx(motions.PITCH_U, rel=0.2)


def test_eq_9_is_harmless_in_a_usual_lab(done: Mapping[str, pd.DataFrame]) -> None:
    motion = done["motion"]
    panel = motion[motion["scene"] == motion["scene"].iloc[0]].copy()
    assert {*panel["labs"]} == {2}
    level = panel.iloc[0]
    assert (level["method"], level["error_high"] < 0.3) == ("eq. (9)", True)
    # The times of this machine do not decide the test.
    panel["seconds"] = np.arange(1.0, len(panel) + 1)
    lab = "as the sheet asks, 200 to 600 rpm"
    assert motions.title(panel).splitlines()[1:] == [f"{lab}: eq. (9), 1000 ms"]
    known = panel[panel["method"] == motions.KNOWN]
    assert known["error"].iloc[0] < 0.02


def test_a_model_that_knows_everything_is_never_the_cheapest() -> None:
    point = {"scene": "a", "method": motions.KNOWN, "error_high": 0.0, "seconds": 1e-9}
    assert motions.title(pd.DataFrame([point])).endswith("\na: none")


# --- integrators ---


def test_the_reference_is_that_of_elliptic_integrals() -> None:
    mpmath = pytest.importorskip("mpmath")
    top, spin = integrators.TOP, integrators.SPIN
    pull = 2 * top.torque / top.transverse_inertia
    about = top.inertia * spin / top.transverse_inertia
    sunk = -(about**2) / pull / 2 + math.sqrt((about**2 / pull / 2) ** 2 + 1)
    third = mpmath.ellippi(sunk, -(sunk**2)) - mpmath.ellippi(-sunk, -(sunk**2))
    azimuth = 17 * about * math.sqrt(sunk / pull) * float(third)
    _, axis = integrators.reference(1)
    assert math.atan2(axis[1], axis[0]) == pytest.approx(azimuth % (2 * math.pi))
    assert axis[2] == pytest.approx(-sunk)


@pytest.mark.parametrize("method", integrators.NOMINAL)
def test_an_integrator_has_its_nominal_order(method: str) -> None:
    curve = pd.DataFrame(integrators.measure_curve(method, 1, 12_000))
    allowed = 0.10 if method in integrators.ADAPTIVE else 0.05
    nominal = integrators.NOMINAL[method]
    assert integrators.fitted_order(curve) == pytest.approx(nominal, rel=allowed)


# --- maps ---


def cell(kind: maps.MapKind, x: float, y: float) -> pd.DataFrame:
    return fits.summary(pd.DataFrame(kind.fit(x, y, ())), "y", "x")


@pytest.mark.parametrize(
    ("rpm", "pitch", "is_tilted"), [(400, 0, False), (100, 45, True), (25, 60, None)]
)
def test_gyro_does_what_the_map_of_tilted_rods_draws(
    rpm: float, pitch: float, is_tilted: bool | None
) -> None:
    kind = MAPS["tilt"]
    table = cell(kind, rpm, pitch)
    by_level, by_gyro = table["bias"]
    if is_tilted is None:
        assert table["refused"].tolist() == [1, 1]
        return
    assert abs(by_gyro) < 0.3
    assert table["reacts"].tolist() == [False, is_tilted]
    assert (abs(by_level) > 0.3) == is_tilted
    assert kind.is_bad(table["bias"]).tolist() == [is_tilted, False]


@pytest.mark.parametrize(
    ("rpm", "pitch", "fails", "touches", "reacts"),
    [
        (400, 0, False, False, False),
        (140, 75, False, False, True),
        (70, -30, True, False, True),
        (50, 0, True, True, None),
        (50, 60, True, True, None),
    ],
)
def test_gyro_does_what_the_map_of_released_rods_draws(
    rpm: float, pitch: float, fails: bool, touches: bool, reacts: bool | None
) -> None:
    kind = MAPS["released"]
    level, gyro = cell(kind, rpm, pitch).to_dict("records")
    assert kind.is_bad(level["bias"]) == fails
    assert level["reacts"] == touches
    if reacts is None:
        assert gyro["refused"] == 1
        return
    assert gyro["reacts"] == reacts
    assert abs(gyro["bias"]) < 0.5


def test_gyro_refuses_released_rods_near_the_cup_only() -> None:
    kind = MAPS["released"]
    for rpm, pitch in itertools.product(kind.x[::4], (-30, 30)):
        level, gyro = cell(kind, rpm, pitch).to_dict("records")
        assert level["refused"] == 0
        if gyro["refused"]:
            assert level["reacts"]
        elif not level["reacts"]:
            assert abs(gyro["bias"]) < 1


@pytest.mark.parametrize(
    ("start", "rpm", "degrees"),
    [
        ("released", 40.0, -40.0),
        ("released", 60.0, 0.0),
        ("released", 300.0, 30.0),
        ("released", 150.0, 60.0),
        ("steady", 60.0, -40.0),
        ("steady", 300.0, -40.0),
        ("steady", 60.0, 30.0),
    ],
)
def test_a_rod_of_the_map_turns_once_in_its_time(
    start: Motion, rpm: float, degrees: float
) -> None:
    truth = Truth(motion=start)
    runs = happen(truth, motions.at_rpm(rpm, degrees=degrees))
    rods = motions.rods_of(truth, runs, push=float(start == "steady"))
    turned = motions.full_motion(rods, motions.CLOSER)
    assert turned == pytest.approx(2 * np.pi, rel=1e-5)


def test_labs_of_many_runs_are_fewer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(maps, "measured_lab", lambda log: None)
    monkeypatch.setattr(maps, "points_of", lambda lab: None)
    monkeypatch.setattr(maps.LabScene, "draw", lambda scene, seed: "")
    monkeypatch.setattr(fits, "timed_answers", lambda *words, **where: [{}])
    kind = MAPS["runs"]
    counts = [len(kind.fit(x, 2, range(200))) for x in kind.x]
    assert counts == [200, 200, 200, 6]
    assert max(kind.x) == 30_000
    jobs: Any = report.list_jobs(report.QUICK, None)
    assert max(job.args[1] for name, job in jobs if name == "runs") == 900


def test_a_map_counts_the_cells_where_a_method_fails() -> None:
    balance = MAPS["balance"]
    cells = {"x": [0, 5, 0, 5], "method": ["line", "line", "gyro", "gyro"]}
    table = pd.DataFrame({**cells, "coverage": [0.95, 0.4, 0.95, math.nan]})
    assert balance.title(table).splitlines() == [
        "line fails in 1 of 2 cells",
        "gyro fails in 0 of 2 cells",
    ]


# --- the whole ---


def test_each_chart_has_its_numbers_and_its_title(
    done: Mapping[str, pd.DataFrame], written: tuple[Path, str]
) -> None:
    assert [*report.titles(done)] == CHARTS
    folder, _ = written
    tables = {name: pd.read_csv(folder / f"{name}.csv") for name in CHARTS}
    assert len([*folder.iterdir()]) == 2 * len(CHARTS) + 1
    assert len(tables["fits"]) == 3 * len(programs.installed()) + 6
    for name in ("fits", "motion", "balance", "torques", "runs"):
        assert {*tables[name]["labs"]} == {2}


def test_the_title_of_the_fits_follows_from_the_coverage(
    done: Mapping[str, pd.DataFrame],
) -> None:
    scores = done["fits"]
    is_gyro = scores["method"].str.contains("gyro")
    right = scores.assign(
        coverage_low=0.9,
        coverage_high=np.where(is_gyro, 1.0, 0.94),
        seconds=np.where(scores["method"] == fits.GYRO, 0.5, 0.01),
    )
    title = fits.title(right)
    assert "in 3 of 3 kinds of labs: one fit of gyro and gyro analyze" in title
    assert "as the sheet asks: one fit of gyro, 10 ms" in title
    assert title.count("one fit of gyro, 10 ms") == 3
    wrong = right.assign(coverage_high=0.5)
    assert "in 0 of 3 kinds of labs: no program" in fits.title(wrong)


def test_the_same_seed_gives_the_same_numbers(
    done: Mapping[str, pd.DataFrame], monkeypatch: pytest.MonkeyPatch
) -> None:
    """In workers too, and without the jobs before: the last job of each table."""
    monkeypatch.setattr(maps, "KINDS", SMALL)
    jobs = dict(report.list_jobs(TINY, None))
    # The other lab of this kind belongs to the same row.
    *_, other, _ = report.list_jobs(TINY, None)
    monkeypatch.setattr(report, "list_jobs", lambda *_: [other, *jobs.items()])
    again = report.run(TINY, 2)
    assert again.keys() == done.keys()
    for name, table in again.items():
        columns = [column for column in table if column != "seconds"]
        last = done[name].tail(len(table)).reset_index(drop=True)
        pd.testing.assert_frame_equal(last[columns], table[columns], check_dtype=False)


def test_the_lab_of_a_log_is_a_scene() -> None:
    analysis = gyrodata.analyze(LOG)
    own = labs.scene_of(analysis)
    measured = labs.measured_lab(own.draw(1))
    assert len(measured.runs) == len(analysis.measurements.runs)
    assert sorted(measured.turns) == sorted(analysis.measurements.turns)
    assert own.truth.inertia == analysis.fit.inertia.value
    by_log = [
        row["scene"]
        for name, job in report.list_jobs(replace(TINY, labs=1), own)
        if name in ("fits", "motion") and "your log" in str(job.args)
        for row in job()
    ]
    rpm = analysis.measurements.spin / RPM
    motion = f"your log, {rpm.min():.0f} to {rpm.max():.0f} rpm"
    assert {*by_log} == {"your log", motion}


def test_the_command_writes_a_page_with_every_chart(
    done: Mapping[str, pd.DataFrame], written: tuple[Path, str]
) -> None:
    folder, messages = written
    names = {path.name for path in folder.iterdir()}
    assert {f"{name}.{form}" for name in CHARTS for form in ("png", "csv")} <= names
    page = (folder / "benchmark.html").read_text(encoding="utf-8")
    assert {*re.findall(r'src="(.*?)"', page)} == {f"{name}.png" for name in CHARTS}
    assert {*re.findall(r'href="(.*?)"', page)} <= names
    assert "What this means for air_gyroscope.csv" in page
    assert "page: " in messages


def test_a_quick_picture_says_how_many_labs_it_has(
    done: Mapping[str, pd.DataFrame],
) -> None:
    few = done["runs"]
    assert report.labs_text(few).startswith("Quick look: only 2 simulated labs")
    many = few.assign(labs=200)
    assert report.labs_text(many) == "200 simulated labs behind each number"
    assert report.draw("runs", done) != report.draw("runs", {**done, "runs": many})
    many.loc[0, "labs"] = 10
    text = "10 or 200 simulated labs behind each number"
    assert report.labs_text(many) == text
