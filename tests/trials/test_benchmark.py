"""The benchmark: what it measures, draws and says."""

from __future__ import annotations

import io
import math
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from msgspec.structs import replace
from typer.testing import CliRunner

import gyrodata
from gyrodata import fitting, physics
from gyrodata.cli import app
from gyrodata.measurements import Measurements
from gyrodata.physics import RPM, motion
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
from gyrodata.trials.benchmark.report import Benchmark
from gyrodata.trials.simulation import Truth

# All tests use the same benchmark, which takes more than a moment.
pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
LOG = ROOT / "sample_data" / "air_gyroscope.csv"
TINY = replace(report.QUICK, labs=2, budgets={1: 2_500})
SPARSE = replace(TINY, every=3)
"""With fewer cells of each map, which are too few for a chart."""
CHARTS = ["fits", "motion", "integrators", *(kind.name for kind in maps.KINDS)]


@pytest.fixture(scope="module")
def done() -> Benchmark:
    return report.run(TINY, 0)


# --- programs ---


def lab() -> tuple[Measurements, dict[str, Any]]:
    measured = labs.measured_lab(labs.SCENES[0].draw(2))
    return measured, labs.lab_of(measured)


def test_a_line_with_an_intercept_is_that_of_gyro() -> None:
    measured, given = lab()
    value, low, high = programs.line_with_intercept(given)
    usual = fitting.TEXTBOOK["with_constant"](measured.product, measured.torque)
    assert value == pytest.approx(float(usual[0]), rel=2e-3)
    # Student's factor for seven degrees of freedom.
    assert (high - low) / 2 == pytest.approx(2.3646 * float(usual[1]), rel=0.02)


@pytest.mark.parametrize("name", programs.PROGRAMS)
def test_a_program_finds_the_inertia_of_exact_readings(name: str) -> None:
    package, fit = programs.PROGRAMS[name]
    pytest.importorskip(package)
    _, given = lab()
    time = 2 * np.pi * Truth().inertia * np.array(given["spin"]) / given["torque"]
    value, low, high = fit({**given, "time": time.tolist()})
    # kafe2 stops when it is near.
    allowed = 2e-3 if name == "kafe2" else 2e-5
    assert value == pytest.approx(Truth().inertia, rel=allowed)
    assert low * (1 - 1e-9) <= Truth().inertia <= high * (1 + 1e-9)


def test_the_full_covariance_with_the_hand_s_bias_ties() -> None:
    truth, covered, of_gyro, errors = Truth().inertia, 0, 0, []
    seeds = labs.seeds(60, 1)
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


def answers(values: Any, half: float) -> pd.DataFrame:
    columns = {"value": values, "low": values - half, "high": values + half}
    return pd.DataFrame({**columns, "warned": False, "seconds": 0.1})


def test_a_score_counts_the_labs_whose_interval_contains_the_truth() -> None:
    values = np.linspace(0.9, 1.1, 200)
    values[:20] = math.nan
    score = fits.score(answers(values, 0.11))
    assert (score["coverage"], score["refused"]) == (0.9, 20)
    # Wilson's interval of 190 of 200, R: prop.test(190, 200, correct = FALSE).
    assert fits.wilson(0.95, 200) == pytest.approx((0.91042, 0.97261), abs=1e-4)
    assert (score["coverage_low"], score["coverage_high"]) == fits.wilson(0.9, 200)


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


def test_no_ordinary_point_knows_what_no_user_knows() -> None:
    true, known = motions.draw_labs(motions.SCENES[0], 20, 1)
    assert known.push == physics.models.PART_RELEASED
    assert np.ndim(known.decay) == 0
    off = known.pitch - true.pitch
    assert np.std(off) == pytest.approx(motions.PITCH_U, rel=0.2)


def test_eq_9_is_harmless_in_a_usual_lab() -> None:
    panel = pd.DataFrame(motions.compare(motions.SCENES[0], (1e-2,), 12, 1))
    assert {*panel["labs"]} == {12}
    level = panel.iloc[0]
    assert (level["method"], level["error_high"] < 0.3) == ("eq. (9)", True)
    # The times of this machine do not decide the test.
    panel["seconds"] = np.arange(len(panel))
    assert motions.cheapest(panel) == "eq. (9)"
    known = panel[panel["method"] == motions.KNOWN]
    assert known["error"].iloc[0] < 0.02


def test_a_model_that_knows_everything_is_never_the_cheapest() -> None:
    panel = pd.DataFrame(
        [{"method": motions.KNOWN, "error_high": 0.0, "seconds": 1e-9}]
    )
    assert motions.cheapest(panel) == "none"


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


def test_steady_precession_by_the_motion_is_that_of_eq_8() -> None:
    pitch, spin = (
        part.ravel()
        for part in np.meshgrid(
            np.radians([-40, 0, 30, 60]), RPM * np.array([30, 60, 300])
        )
    )
    top = integrators.TOP
    rate = maps.steady_rate(top, spin, pitch)
    known = physics.precession_rate(
        top.torque, spin, top.inertia, top.transverse_inertia, pitch
    )
    assert rate == pytest.approx(known, rel=1e-9, nan_ok=True)
    assert np.isnan(rate).any()


def test_the_turn_of_a_released_rod_is_that_of_the_closed_form() -> None:
    one, spin = integrators.TOP, RPM * np.array([90.0, 120.0, 180.0])
    fields = one.inertia, one.transverse_inertia, one.torque
    top = motion.Top(*(np.full(3, value) for value in fields))
    time, read, is_possible = maps.follow_released(top, spin, math.radians(20))
    known = motion.time_to_turn(top, spin, math.radians(20), 2 * np.pi)
    assert time == pytest.approx(known, rel=2e-3)
    excess = motion.spin_excess(top, spin, math.radians(20))
    assert read == pytest.approx(spin - excess, rel=2e-3)
    assert is_possible
    assert not maps.follow_released(top, spin / 3, 0.0)[2]


def does(name: str, rpm: float, pitch: float) -> dict[str, Any]:
    (kind,) = [kind for kind in maps.KINDS if kind.name == name]
    return {row["program"]: row for row in kind.fit(rpm, pitch, ())}


@pytest.mark.parametrize(
    ("name", "rpm", "pitch", "model"),
    [
        ("tilt", 400, 0, "9"),
        ("tilt", 100, 45, "8"),
        ("tilt", 25, 60, "x"),
        ("released", 60, -30, "R"),
        ("released", 50, 45, "–"),
    ],
)
def test_gyro_does_what_the_map_of_tilted_rods_draws(
    name: str, rpm: float, pitch: float, model: str
) -> None:
    cell = does(name, rpm, pitch)
    assert cell["gyro"]["does"] == model
    assert math.isnan(cell["gyro"]["error"]) == (model in "x–")
    if model == "8":
        assert abs(cell["gyro"]["error"]) < 0.3 < abs(cell["eq. (9)"]["error"])
        assert cell["eq. (9)"]["limit"] > 1


# --- the whole ---


def test_each_chart_has_its_numbers_and_its_title(done: Benchmark) -> None:
    assert [*report.titles(done)] == CHARTS
    tables = {
        name: pd.read_csv(io.StringIO(text))
        for name, text in report.csv_tables(done).items()
    }
    assert {*CHARTS} == {*tables}
    assert len(tables["fits"]) == 3 * len(programs.installed()) + 6
    for name in ("fits", "motion", "balance", "torques", "runs"):
        assert {*tables[name]["labs"]} == {2}


def test_the_title_of_the_fits_follows_from_the_coverage(done: Benchmark) -> None:
    scores = done.tables["fits"]
    is_gyro = scores["program"].str.startswith("gyro")
    right = scores.assign(
        coverage_low=0.9,
        coverage_high=np.where(is_gyro, 1.0, 0.94),
        seconds=np.where(scores["program"] == fits.GYRO, 0.5, 0.01),
    )
    title = report.fits_title(right)
    assert "in 3 of 3 kinds of labs with gyro, one fit and gyro analyze" in title
    assert "The cheapest of them, gyro, one fit, costs 10 ms" in title
    wrong = right.assign(coverage_high=0.5)
    assert "correct in 0 of 3 kinds of labs" in report.fits_title(wrong)


def test_the_same_seed_gives_the_same_numbers() -> None:
    first, again = report.run(SPARSE, 0), report.run(SPARSE, 2)
    for name, table in first.tables.items():
        columns = [column for column in table if column not in ("seconds", "process")]
        pd.testing.assert_frame_equal(table[columns], again.tables[name][columns])


def test_the_lab_of_a_log_is_a_scene() -> None:
    analysis = gyrodata.analyze(LOG)
    own, rods = report.scene_of(analysis)
    measured = labs.measured_lab(own.draw(1))
    assert len(measured.runs) == len(analysis.measurements.runs)
    assert sorted(measured.turns) == sorted(analysis.measurements.turns)
    assert own.truth.inertia == analysis.fit.inertia.value
    assert rods.rpm[0] == pytest.approx(analysis.measurements.spin.min() / RPM, abs=1)
    jobs = list(report.list_jobs(TINY, 1, (own, rods)))
    assert {row["scene"] for row in jobs[0].work()} == {"your log"}
    (motion_job,) = [job for job in jobs if "your log" in str(job.work.args)][-1:]
    assert motion_job.work()[0]["scene"] == rods.heading


def test_the_command_writes_a_page_with_every_chart(
    done: Benchmark, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(report, "run", lambda *_: done)
    words = ["benchmark", str(LOG), "--quick", "--out", str(tmp_path)]
    result = CliRunner().invoke(app, words)
    assert result.exit_code == 0, result.output
    names = {path.name for path in tmp_path.iterdir()}
    assert {f"{name}.{form}" for name in CHARTS for form in ("png", "csv")} <= names
    page = (tmp_path / "benchmark.html").read_text(encoding="utf-8")
    assert {*re.findall(r'src="(.*?)"', page)} == {f"{name}.png" for name in CHARTS}
    assert {*re.findall(r'href="(.*?)"', page)} <= names
    assert "What this means for air_gyroscope.csv" in page
    assert all(title in result.stdout for title in report.titles(done).values())


def test_a_quick_picture_says_how_many_labs_it_has(done: Benchmark) -> None:
    assert report.labs_text(done).startswith("Quick look: only 2 simulated labs")
    full = replace(done, effort=report.FULL)
    assert report.labs_text(full).startswith("200 simulated labs")
    assert charts.draw("runs", "title", done) != charts.draw("runs", "title", full)
