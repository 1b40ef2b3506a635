"""The benchmark: what it measures, draws and says, with a clock that ticks once a look."""

from __future__ import annotations

import csv
import io
import itertools
import os
import platform
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text
from msgspec.structs import replace
from scipy import stats
from typer.testing import CliRunner

from gyrodata import benchmark as room
from gyrodata import fitting, physics
from gyrodata.benchmark import (
    BATCH,
    CHARTED,
    FULL,
    METHODS,
    QUICK,
    Benchmark,
    CurvePoint,
    Effort,
    FitCurve,
    MotionPanel,
    MotionPoint,
    Trial,
    TrialPanel,
    csv_tables,
    reading,
    run_benchmark,
)
from gyrodata.benchmark.estimators import ESTIMATORS, READ, STUDENTS, one_lab, stated_errors, straight_line
from gyrodata.benchmark.motion_cost import FAMILIES, LADDER, SCENES
from gyrodata.benchmark.orders import WATCHED, find_orders
from gyrodata.benchmark.stability import ACROSS, INERTIA, TORQUE, digits, map_integrators
from gyrodata.benchmark.timing import Task, Timing, describe_machine, time_in_turns
from gyrodata.benchmark.trials import CASES, LabScene, apply_all, judge, run_trials, try_breakdowns
from gyrodata.benchmark.trials import SCENES as LABS
from gyrodata.cli import app
from gyrodata.physics import RPM
from gyrodata.plotting import draw_chart
from gyrodata.plotting.charts import STYLE, name_dots, save

ROOT = Path(__file__).parent.parent
TINY = Effort(
    tolerances={"DOP853": (1e-4, 1e-6), "Tsit5": (1e-4,), "LSODA": (1e-4,)},
    tightest=1e-9,
    steps_per_nutation=(4.0, 16.0, 64.0, 128.0),
    budget=0.04,
    repeats=1,
    precessions=3,
    labs=20,
    grid=2,
    fine_grid=12,
    swings=1,
    draws=8,
    curve_labs=24,
)
EQUAL_TORQUES = {"one torque", "identical runs", "one run"}
CHARTS = (
    "motion", "motion_harder", "motion_order", "motion_drift", "estimators", "stability_steady",
    "stability_integrators", "stability_upright", "stability_estimators", "stability_fits", "stability_cosine",
)  # fmt: skip


def ticking() -> Callable[[], float]:
    """A clock on which 1/1024 s passes between two looks: a difference without rounding."""
    ticks = itertools.count()
    return lambda: next(ticks) / 1024


def shown_texts(figure: Figure) -> list[Text]:
    """Every text that is drawn."""
    with rc_context(STYLE):
        FigureCanvasAgg(figure).draw()  # type: ignore[no-untyped-call]
    texts = (text for text in figure.findobj(Text) if isinstance(text, Text))
    return [text for text in texts if text.get_visible() and text.get_text()]


@pytest.fixture(scope="module")
def told() -> list[float]:
    return []


@pytest.fixture(scope="module")
def done(told: list[float]) -> Benchmark:
    return run_benchmark(TINY, ticking(), progress=told.append, wall=ticking())


class TestMotion:
    def test_the_choice_of_the_ladder_does_no_harm_in_any_scene(self, done: Benchmark) -> None:
        assert [panel.scene for panel in done.motion] == [scene.name for scene in SCENES]
        for panel in done.motion:
            assert panel.ladder_point.error < panel.bound, panel.title
            assert panel.ladder in LADDER.values()

    def test_each_scene_has_the_winner_that_its_physics_asks_for(self, done: Benchmark) -> None:
        # By the clock that ticks, both equations cost the same, and the first that does no harm wins.
        for tops in (1, BATCH):
            winners = {panel.scene: won.method for panel in done.motion if (won := panel.cheapest(tops))}
            assert winners == {
                "level": "eq. (9)", "tilted": "eq. (8)", "released": "mean rate", "steep": "eq. (8)",
                "decay": "eq. (9)",
            }  # fmt: skip

    def test_errors_are_those_of_the_closed_forms_of_bias(self, done: Benchmark) -> None:
        panels = {panel.scene: {point.method: point.error for point in panel.of(1)} for panel in done.motion}
        assert panels["level"]["eq. (9)"] < 1e-14
        assert panels["steep"]["eq. (9)"] == pytest.approx(0.08, abs=0.02)
        assert panels["steep"]["eq. (8)"] < 1e-14
        assert 5e-3 < panels["released"]["eq. (9)"] < 2e-2
        assert panels["decay"]["eq. (9), plain mean spin"] == pytest.approx(0.075, abs=0.01)
        assert panels["decay"]["eq. (9), spin at start"] == pytest.approx(0.31, abs=0.03)
        for scene in ("level", "tilted", "released", "steep"):
            assert panels[scene]["exact motion"] < 1e-7
            assert panels[scene]["DOP853"] < 1e-3
        assert panels["steep"]["splitting aba84"] < 1e-2 * panels["steep"]["splitting strang"]

    def test_every_method_goes_alone_and_in_a_stack(self, done: Benchmark) -> None:
        steep = next(panel for panel in done.motion if panel.scene == "steep")
        alone, stacked = ({point.method for point in steep.of(tops)} for tops in (1, BATCH))
        assert {*FAMILIES, *TINY.tolerances} < alone
        # It solves equations as large as the stack.
        assert alone - stacked == {"LSODA"}
        decay = next(panel for panel in done.motion if panel.scene == "decay")
        assert not any(point.family in ("exact", "splitting") for point in decay.points)

    def test_times_are_the_clock_s(self, done: Benchmark) -> None:
        points = {
            (panel.scene, point.method, point.tops): point
            for panel in reversed(done.motion)
            for point in reversed(panel.points)
        }
        # Ten calls between two looks; the exact motion takes one.
        assert points["level", "eq. (9)", 1].seconds == pytest.approx(1 / 1024 / 10)
        assert points["level", "eq. (9)", BATCH].seconds == pytest.approx(1 / 1024 / 10 / BATCH)
        assert points["level", "exact motion", 1].seconds == pytest.approx(1 / 1024)
        # A long run is timed on its beginning, by its evaluations.
        long = points["released", "DOP853", 1]
        assert long.evaluations is not None
        assert long.seconds * 1024 == pytest.approx(long.evaluations / 200, rel=0.3)
        short = points["steep", "splitting strang", 1]
        assert short.evaluations is not None
        assert short.evaluations < 200
        assert short.seconds * 1024 == pytest.approx(1, rel=0.5)

    def test_a_duel_is_between_the_cheapest_and_the_exact_motion(self, done: Benchmark) -> None:
        *scenes, decay = done.motion
        assert decay.duels == ()
        for panel in scenes:
            assert {(duel.tops, duel.family) for duel in panel.duels} > {
                (1, "splitting"),
                (1, "adaptive"),
                (BATCH, "splitting"),
            }
            for duel in panel.duels:
                # All took the time that they took before: by this clock none is luckier than the other.
                cheapest = panel.harmless(duel.tops, duel.family)[0]
                assert duel.method == f"{cheapest.method}, {cheapest.setting}"
                assert duel.timing.seconds == cheapest.seconds
                assert len(duel.timing.cpu) == len(duel.exact.cpu) == 3

    def test_the_cheapest_below_the_bound_wins_and_not_the_best(self) -> None:
        points = tuple(
            MotionPoint(name, "", "closed form", 1, Timing((seconds,), (seconds,)), error)
            for name, seconds, error in (("bad", 1e-9, 0.5), ("good", 1e-6, 1e-3), ("best", 1e-3, 1e-16))
        )
        panel = MotionPanel("", "", 0.01, points, "best")
        winner = panel.cheapest(1)
        assert winner is not None
        assert (winner.method, panel.ladder_point.method) == ("good", "best")
        assert panel.cheapest(BATCH) is None
        assert panel.harmless(1, "splitting") == []


class TestTiming:
    def test_the_least_counts_and_the_quartiles_are_told(self) -> None:
        timing = Timing((4.0, 2.0, 3.0, 9.0, 5.0), (4.0, 2.1, 3.0, 20.0, 6.0))
        assert timing.seconds == 2.0
        assert timing.quartiles == (3.0, 5.0)
        assert timing.apart == pytest.approx(0.05)

    def test_a_ratio_has_its_spread_from_round_to_round(self) -> None:
        one, other = (Timing(times, times) for times in ((1.0, 2.0, 4.0), (10.0, 30.0, 80.0)))
        # In each round 10, 15 and 20: a slow round is slow for both.
        assert other.over(one) == "15 (12 to 18)"

    @pytest.mark.parametrize(("wall", "told"), [(1.2, True), (1.4, False), (0.6, False)])
    def test_a_ratio_is_not_told_where_others_had_the_processor(self, wall: float, told: bool) -> None:
        quiet, other = Timing((1.0,), (1.0,)), Timing((1.0,), (wall,))
        for text in (quiet.over(other), other.over(quiet)):
            assert text.startswith("not told: wall and CPU time differ by ") is not told

    def test_tasks_take_turns(self) -> None:
        order: list[str] = []
        tasks = [Task(lambda: order.append("a"), calls=2, share=0.5), Task(lambda: order.append("b"))]
        timings = time_in_turns(tasks, 2, ticking(), ticking())
        assert "".join(order) == "aab" * 2
        assert [timing.seconds * 1024 for timing in timings] == [0.25, 1.0]
        assert [len(timing.cpu) for timing in timings] == [2, 2]

    def test_what_was_interrupted_is_tried_again(self) -> None:
        calls = itertools.count()
        # On the wall the first call takes twice as long.
        wall = iter([0.0, 2 / 1024, 5.0, 5.0 + 1 / 1024])
        (timing,) = time_in_turns([Task(lambda: next(calls))], 1, ticking(), lambda: next(wall), tries=4)
        assert next(calls) == 2
        assert timing.apart == 0.0

    def test_the_machine_is_told_in_a_line(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv("OMP_NUM_THREADS", "3")
        words = describe_machine()
        assert f"Python {platform.python_version()}, numpy {np.__version__}" in words
        assert "threads for linear algebra: 3" in words
        assert "\n" not in words


class TestIntegrators:
    def test_each_has_the_order_that_it_is_known_for(self, done: Benchmark) -> None:
        tolerances = {"RK45": (1e-6, 1e-8), "Tsit5": (1e-6, 1e-8), "DOP853": (1e-6, 1e-9)}
        orders = find_orders(replace(TINY, tolerances=tolerances, steps_per_nutation=(64.0, 256.0, 512.0)))
        known = {
            "splitting strang": 2, "splitting aba84": 4, "RK4": 4, "implicit midpoint": 2, "RKMK4": 4, "RK45": 5,
            "Tsit5": 5, "DOP853": 8,
        }  # fmt: skip
        assert {order.method for order in orders} == set(known)
        for order in orders:
            assert order.order == pytest.approx(known[order.method], rel=0.2), order.method
        assert done.orders[-1].method == "LSODA"
        assert done.orders[-1].order is None, "it chooses its order"

    def test_the_coarser_costs_less_and_is_worse(self, done: Benchmark) -> None:
        for order in done.orders:
            for rough, fine in itertools.pairwise(order.points):
                assert rough.evaluations < fine.evaluations
                assert rough.off > fine.off

    def test_splitting_keeps_what_the_others_lose(self, done: Benchmark) -> None:
        drifts = {drift.method: drift for drift in done.drifts}
        assert list(drifts) == [method for method, _ in WATCHED]
        for drift in drifts.values():
            assert drift.precessions[-1] == pytest.approx(TINY.precessions, rel=0.02)
            assert drift.per_nutation == pytest.approx(48, abs=12), drift.method
        for method in ("RK4", "DOP853"):
            assert drifts[method].length[-1] > 1e-5
            assert drifts[method].length[-1] > 5 * drifts[method].length[0]
        for method in ("splitting strang", "splitting aba84", "RKMK4", "implicit midpoint"):
            assert drifts[method].length.max() < 1e-13
        for method in ("splitting strang", "splitting aba84"):
            assert drifts[method].energy[-1] < 1.1 * drifts[method].energy[0]
        assert drifts["RKMK4"].energy[-1] > 5 * drifts["RKMK4"].energy[0]
        # It keeps the energy, and is late all the same.
        assert drifts["implicit midpoint"].energy.max() < 1e-12
        assert drifts["implicit midpoint"].off[-1] > 0.1
        assert drifts["splitting aba84"].off[-1] < 2e-3


def scene(name: str) -> LabScene:
    return next(one for one in LABS if one.name == name)


class TestTrials:
    def test_every_estimator_is_tried_in_every_scene_and_timed_in_four(self, done: Benchmark) -> None:
        assert [panel.scene.name for panel in done.trials] == [one.name for one in LABS]
        for panel in done.trials:
            assert [trial.estimator for trial in panel.trials] == list(ESTIMATORS)
            assert all((trial.time is not None) == (panel.scene.name in CHARTED) for trial in panel.trials)
            assert panel.recommended.failed == 0
            assert panel.recommended.ratio == 1

    def test_the_recommended_fit_reaches_the_bound_where_errors_are_as_stated(self) -> None:
        for one in LABS:
            if not one.as_stated:
                continue
            labs = one.draw(150, 3)
            (mine,) = judge(apply_all({"recommended": ESTIMATORS["recommended"]}, labs))
            assert mine.honest, one.title
            assert mine.rmse - 2 * mine.rmse_u < 1.1 * one.bound(), one.title

    def test_the_full_covariance_with_the_hand_s_bias_ties(self) -> None:
        names = ("full cov., constant", "full cov., iterated", "York, constant", "York, origin", "recommended")
        labs = scene("usual").draw(400, 3)
        full, iterated, york, origin, mine = judge(apply_all({name: ESTIMATORS[name] for name in names}, labs))
        for one in (full, iterated):
            assert one.honest
            assert one.ties
        assert mine.coverage > york.coverage
        assert origin.coverage < 0.3, "M0 is not 0"
        # One that knows that the ball is balanced is closer, where it is.
        labs = scene("balanced").draw(400, 3)
        known, mine = judge(apply_all({name: ESTIMATORS[name] for name in ("full cov., origin", "recommended")}, labs))
        assert known.honest
        assert known.better

    def test_where_the_log_is_wrong_the_recommended_fit_stays_honest_and_the_full_covariance_does_not(self) -> None:
        names = ("full cov., constant", "recommended")
        for name in ("threefold", "tenfold", "tails", "sighting", "miscount"):
            full, mine = judge(apply_all({n: ESTIMATORS[n] for n in names}, scene(name).draw(60, 3)))
            assert mine.coverage > 0.85, name
            assert full.coverage < 0.92, name
            assert mine.rmse < full.rmse, name

    def test_the_bound_is_that_of_the_errors_drawn(self) -> None:
        # The fit that knows all widths, of labs whose errors are small beside what they are errors of.
        for name in ("usual", "both sides", "threefold"):
            one = scene(name)
            labs = one.draw(1000, 2)
            errors = stated_errors(labs, {"time": one.hand})
            line = straight_line(labs.product, labs.torque, errors, intercept=True)
            rmse = float(np.sqrt(np.mean((line.slope / INERTIA - 1) ** 2)))
            assert rmse == pytest.approx(one.bound(), rel=0.08), name
        assert scene("usual").bound(balanced=True) < 0.7 * scene("usual").bound()
        # Fisher's information of a location of Student's t with 3 degrees of freedom is 2/3 of a normal one's.
        assert scene("tails").bound() > replace(scene("tails"), tails=None).bound()

    def test_the_best_is_the_recommended_one_unless_another_is_truly_better(self, done: Benchmark) -> None:
        panel = done.trials[0]
        mine = replace(panel.recommended, rmse=0.010, coverage=0.95, labs=4000)
        tied = replace(mine, estimator="other", rmse=0.0099, ratio=0.99, ratio_u=0.001)

        def among(*trials: Trial) -> TrialPanel:
            return replace(panel, trials=trials)

        assert among(tied, mine).best is mine
        assert among(tied, mine).outcome == "ties: other"
        better = replace(tied, rmse=0.009, ratio=0.9)
        assert among(better, mine).best is better
        assert among(better, mine).outcome == "closer: other"
        unsure = replace(better, ratio_u=0.1)
        assert among(unsure, mine).best is mine
        worse = replace(tied, ratio=1.2)
        assert among(worse, mine).outcome == "closest of honest"
        dishonest = replace(better, coverage=0.9)
        assert among(dishonest, mine).best is mine
        assert among(dishonest, mine).outcome == "alone honest"
        assert among(dishonest, replace(mine, coverage=0.9)).best is None
        assert among(replace(mine, coverage=0.9)).outcome == "too sure: 90.0 %"
        assert among(replace(mine, coverage=0.995)).outcome == "too wide: 99.5 %"

    @pytest.mark.parametrize(
        ("coverage", "labs", "honest"),
        [(0.93, 4000, True), (0.912, 4000, False), (0.91, 300, True), (0.985, 4000, False), (0.99, 300, True)],
    )
    def test_honest_is_as_far_as_the_labs_tell(self, coverage: float, labs: int, honest: bool) -> None:
        trial = Trial("", 0.0, 0.0, 0.0, coverage, 0.0, 1.0, 0.0, None, 0, labs)
        assert trial.honest is honest

    def test_same_seed_same_labs(self) -> None:
        first, again, other = (scene("usual").draw(3, seed).time for seed in (3, 3, 4))
        assert np.array_equal(first, again)
        assert not np.isclose(first, other).any()
        few = replace(TINY, labs=2)
        assert run_trials(few, ticking()) == run_trials(few, ticking())

    def test_times_are_the_clock_s(self, done: Benchmark) -> None:
        # Two logs between two looks.
        time = done.trials[0].recommended.time
        assert time is not None
        assert (time.seconds, *time.quartiles) == (1 / 2048,) * 3

    def test_labs_at_once_and_one_by_one_give_the_same(self) -> None:
        for name, estimate in ESTIMATORS.items():
            # Iterated with a wrong count it runs away, a stack for longer than a lab that is alone.
            labs = scene("usual" if name == "full cov., iterated" else "miscount").draw(12, 5)
            with np.errstate(all="ignore"):
                at_once = estimate(labs)
                single = [estimate(one_lab(labs, lab)) for lab in range(12)]
            rel = 1e-4 if name == "recommended" else 1e-8
            for end in ("value", "low", "high"):
                ends = [float(getattr(answer, end)) for answer in single]
                assert np.allclose(getattr(at_once, end), ends, rtol=rel, atol=1e-12, equal_nan=True), (name, end)

    def test_lines_are_those_of_the_public_fit(self) -> None:
        for name, intercept in itertools.product(("usual", "miscount"), (True, False)):
            labs = scene(name).draw(5, 6)
            for errors in (stated_errors(labs), stated_errors(labs).independent):
                lines = straight_line(labs.product, labs.torque, errors, intercept)
                for lab in range(5):
                    columns = np.vstack([errors.shared_product[lab].T, errors.shared_torque[lab].T]).reshape(2, -1, 9)
                    of_product, of_torque = (
                        np.diag(own[lab] ** 2) + part.T @ part
                        for own, part in zip((errors.product, errors.torque), columns, strict=True)
                    )
                    line = fitting.fit_line(labs.product[lab], labs.torque[lab], of_product, of_torque, None, intercept)
                    assert lines.slope[lab] == pytest.approx(line.slope, rel=1e-9)
                    assert lines.u[lab] == pytest.approx(line.u_slope, rel=1e-8)
                    assert lines.chi2[lab] == pytest.approx(line.chi2, rel=1e-8)

    def test_theil_and_sen_s_slope_is_scipy_s(self) -> None:
        labs = scene("usual").draw(4, 1)
        answer = ESTIMATORS["Theil–Sen"](labs)
        for lab in range(4):
            found = stats.theilslopes(labs.torque[lab], labs.product[lab], 0.95)
            assert (answer.value[lab], answer.low[lab], answer.high[lab]) == pytest.approx(
                (found.slope, found.low_slope, found.high_slope), rel=1e-12
            )

    def test_odr_is_that_of_odrpack(self) -> None:
        odrpack = pytest.importorskip("odrpack")
        lab = one_lab(scene("usual").draw(1, 2), 0)
        errors = stated_errors(lab).independent
        found = odrpack.odr_fit(
            lambda x, beta: beta[0] * x + beta[1], lab.product, lab.torque, np.array([INERTIA, 1e-3]),
            weight_x=errors.product**-2, weight_y=errors.torque**-2,
        )  # fmt: skip
        answer = ESTIMATORS["ODR, constant"](lab)
        assert float(answer.value) == pytest.approx(found.beta[0], rel=1e-5)
        assert float(answer.half) == pytest.approx(stats.t.ppf(0.975, 7) * found.sd_beta[0], rel=1e-2)

    def test_the_errors_are_those_drawn(self) -> None:
        # Against readings drawn from them: the spread of M and P over many labs of one design.
        labs = scene("usual").draw(600, 1)
        errors = stated_errors(one_lab(labs, 0))
        of_product, of_torque = (
            np.diag(own**2) + shared @ shared.T
            for own, shared in ((errors.product, errors.shared_product), (errors.torque, errors.shared_torque))
        )
        assert np.allclose(np.cov(labs.torque.T), of_torque, atol=0.2 * of_torque.max())
        product = np.cov(labs.product.T)
        assert np.allclose(np.sqrt(np.diag(product)), np.sqrt(np.diag(of_product)), rtol=0.15)
        # The hand is late in all runs: two runs of one weight that take the least time have it in common.
        assert product[6, 7] == pytest.approx(of_product[6, 7], rel=0.25)
        alone = errors.independent
        assert np.allclose(alone.product**2, np.diag(of_product))
        assert alone.shared_product.shape == (9, 0)

    def test_a_scene_draws_what_it_says(self) -> None:
        plain, worse = (scene(name).draw(400, 1) for name in ("third", "tenfold"))
        exact = scene("third").at_work()
        for labs, click in ((plain, 0.14 / 3), (worse, 1.4)):
            late = np.hypot(click, 0.08)
            assert (labs.time - exact.time).std() == pytest.approx(late, rel=0.1)
        wrong = scene("miscount").draw(50, 1).turns
        assert (np.sum(wrong != 1.0, axis=1) == 1).all()
        assert set(wrong[wrong != 1.0].tolist()) == {0.5, 2.0}
        assert set(READ) <= set(exact.__struct_fields__)


class TestCurves:
    def test_each_curve_is_of_its_labs(self, done: Benchmark) -> None:
        names = [curve.name for curve in done.curves]
        assert names == ["imbalance", "sharing", "runs", "miscounts", "click", "spins"]
        for curve in done.curves:
            for point in curve.points:
                assert {trial.estimator for trial in point.trials} == set(curve.estimators)
                assert all(trial.labs == point.labs <= TINY.curve_labs for trial in point.trials)

    def test_the_usual_fits_fail_where_they_are_said_to(self, done: Benchmark) -> None:
        curves = {curve.name: curve for curve in done.curves}
        assert curves["imbalance"].first_failure("full cov., origin") in (1.0, 2.0, 3.0)
        assert curves["miscounts"].first_failure("full cov., constant") == 1
        begun = curves["runs"].first_failure("full cov., constant")
        assert begun is not None
        assert 100 <= begun <= 1000, "errors taken at the measured points pull, the more the more runs there are"
        assert curves["click"].first_failure("full cov., constant") in (0.3, 0.5, 1.0)

    def test_the_recommended_fit_holds_up_to_a_third_of_wrong_counts(self, done: Benchmark) -> None:
        for curve in done.curves:
            begun = curve.first_failure("recommended")
            if curve.name == "miscounts":
                assert begun == 7, "a third of 18 runs is 6"
            else:
                assert begun is None or begun == 3000, curve.name

    def test_a_failure_is_one_beyond_chance(self) -> None:
        good = Trial("x", 0.01, 0.001, 0.0, 0.95, 0.0, 1.0, 0.0, None, 0, 100)

        def fails(trial: Trial) -> bool:
            return CurvePoint(1.0, 100, 0.01, (trial,)).fails("x")

        assert not fails(good)
        assert not fails(replace(good, coverage=0.88))
        assert fails(replace(good, coverage=0.85))
        assert not fails(replace(good, rmse=0.0215))
        assert fails(replace(good, rmse=0.023))
        curve = FitCurve("", "", "", "", ("x",), (CurvePoint(1.0, 100, 0.01, (good,)),))
        assert curve.first_failure("x") is None


class TestStability:
    def test_what_holds_holds_everywhere(self, done: Benchmark) -> None:
        tilt, level = done.roots
        assert np.nanmin(tilt.holds.digits) > 13
        assert np.nanmin(level.holds.digits) > 13
        assert np.nanmedian(tilt.fails.digits) < 4
        assert np.nanmin(level.fails.digits) == 0
        assert np.isnan(tilt.holds.digits).any(), "no steady precession somewhere"
        for pair in done.integrators:
            assert np.median(pair.holds.digits) > np.median(pair.fails.digits) + 2

    def test_the_region_without_steady_precession_is_that_of_the_least_spin(self, done: Benchmark) -> None:
        pitch, spin = np.meshgrid(np.radians(done.roots[0].y), done.roots[0].x * RPM, indexing="ij")
        none = spin < physics.least_spin(TORQUE, INERTIA, ACROSS, pitch)
        assert np.array_equal(np.isnan(done.roots[0].holds.digits), none)

    def test_along_the_cosine(self, done: Benchmark) -> None:
        worst = {(one.end, one.method): one.worst for one in done.cosines}
        own, exact = "eq. (8), 2c/(b + √D)", "the same, D in fractions"
        assert worst["level", own].min() > 15
        assert worst["level", "eq. (8), (−b + √D)/2a"].min() == 0
        # Where D vanishes half the digits go, whatever the formula, if D is rounded.
        assert 7 < worst["vertical", own].min() < 12
        assert worst["vertical", exact].min() > 15
        assert worst["vertical", "eq. (9)"].max() < 3

    def test_the_vertical(self, done: Benchmark) -> None:
        started = {one.method: one.error for one in done.passages if one.closest == 0}
        assert started[METHODS[0]] is None
        assert started[METHODS[1]] is None
        for method in METHODS[2:]:
            error = started[method]
            assert error is not None
            assert error < 1e-6

    def test_the_tool_is_never_silently_wrong(self, done: Benchmark) -> None:
        assert len(done.breakdowns) == len(CASES) * (len(STUDENTS) + 1)
        mine = [one for one in done.breakdowns if one.estimator == "recommended"]
        assert {one.verdict for one in mine} == {"holds", "wide"}
        # Equal torques do not tell the balance, and the logs do not state it.
        assert {one.case for one in mine if one.verdict == "wide"} == EQUAL_TORQUES
        silent = {one.case for one in done.breakdowns if one.verdict == "nonsense"}
        assert {"one torque", "sign lost", "wrong count"} <= silent
        # A run without a torque that ends at a mark sighted to a degree does not pull far, but every one pulls.
        pulled = {one.estimator: one for one in done.breakdowns if one.case == "run without torque"}
        for name in ("weighted, origin", "York, origin"):
            assert (pulled[name].verdict, pulled[name].coverage) == ("too sure", 0.0), name

    def test_same_seed_same_verdicts(self) -> None:
        few = replace(TINY, draws=1)
        assert try_breakdowns(few, seed=2) == try_breakdowns(few, seed=2)
        one, two = (map_integrators(replace(TINY, grid=2)) for _ in range(2))
        assert all(np.array_equal(a.fails.digits, b.fails.digits) for a, b in zip(one, two, strict=True))

    @pytest.mark.parametrize(
        ("error", "right"), [(1e-5, 5), (0.0, 16), (np.nan, 0), (np.inf, 0), (50.0, 0), (-0.01, 2)]
    )
    def test_digits(self, error: float, right: float) -> None:
        assert digits(error) == pytest.approx(right)


class TestWords:
    def test_every_number_of_the_charts_is_in_a_table(self, done: Benchmark) -> None:
        tables = {name: list(csv.DictReader(io.StringIO(text))) for name, text in csv_tables(done).items()}
        # All scenes of the motion are in one table.
        assert tuple(tables) == tuple(name for name in CHARTS if name != "motion_harder")
        assert len(tables["motion"]) == sum(len(panel.points) for panel in done.motion)
        assert float(tables["motion"][0]["CPU time per top [s]"]) == done.motion[0].points[0].seconds
        assert sum(row["cheapest that does no harm"] == "true" for row in tables["motion"]) == 2 * len(SCENES)
        assert len(tables["motion_order"]) == sum(len(order.points) for order in done.orders)
        assert len(tables["motion_drift"]) == sum(len(drift.precessions) for drift in done.drifts)
        assert len(tables["estimators"]) == len(LABS) * len(ESTIMATORS)
        assert float(tables["estimators"][3]["relative RMSE of I_zz"]) == done.trials[0].trials[3].rmse
        assert len(tables["stability_fits"]) == sum(len(c.points) * len(c.estimators) for c in done.curves)
        assert len(tables["stability_cosine"]) == 8 * TINY.fine_grid
        assert len(tables["stability_steady"]) == 4 * TINY.fine_grid**2
        assert len(tables["stability_estimators"]) == len(done.breakdowns)
        assert not any("nan" in text for text in csv_tables(done).values())

    def test_the_reading_says_what_to_use_when(self, done: Benchmark) -> None:
        text = reading(done, TINY, 1)
        for line in (
            "seed 1, 20 labs a scene",
            "| level and steady, 400 rpm | 0.92 % | eq. (9) | eq. (9) | eq. (9) |",
            "| tilted 45°, 100 rpm | 2.2 % | eq. (8) | eq. (8) | eq. (8) |",
            "| released from rest at 200 rpm | 500 | 2 µs | 4.8 (4.8 to 4.8): splitting strang, 4 steps a nutation | ",
            "| RK4 | 4.0 | ",
            "| LSODA | – | ",
            "| splitting aba84 | 8 steps a nutation | 40 | ",
            "error is below 0.3 u does no harm",
            "8 of each kind",
            "| number of runs: number of runs | 3 to 3000 | M on P, constant: ",
            "| eq. (8), (−b + √D)/2a | 0 |",
        ):
            assert line in text
        assert [line.split(" | ")[0] for line in text.splitlines() if line.endswith("| no answer |")] == [
            "| eqs. (7), Euler angles", "| reduced to θ"
        ]  # fmt: skip
        # Whether linregress stops there is scipy's.
        silent = r"numpy\.polyfit; (scipy linregress; )?Theil–Sen; M on P, constant; ODR, constant; York, constant"
        assert re.search(rf"^\| one torque \| {silent}", text, re.M)
        rows = dict.fromkeys(CASES, "holds") | dict.fromkeys(EQUAL_TORQUES, "wide")
        for case, verdict in rows.items():
            assert re.search(rf"^\| {case} \| .* \| {verdict} \|$", text, re.M), case
        assert "nan" not in text.replace("nonsense", "")

    def test_the_reading_tells_of_exceptions(self, done: Benchmark) -> None:
        first = done.motion[0]
        worse = replace(
            first, points=tuple(replace(point, error=0.003) for point in first.points[:2]) + first.points[2:]
        )
        panel = done.trials[0]
        mine = replace(panel.recommended, coverage=0.95)
        rival = replace(mine, estimator="York, origin", coverage=0.96, ratio=0.5, ratio_u=0.01)
        panels = [
            replace(panel, trials=trials)
            for trials in ((rival, mine), (mine,), (replace(rival, ratio=1.0), mine), (replace(mine, coverage=0.5),))
        ]
        text = reading(replace(done, motion=[worse, *done.motion[1:]], trials=panels), TINY, 1)
        assert "| level and steady, 400 rpm | 0.92 % | eq. (8) | eq. (8) | eq. (9) | 0.33 u | 0.33 u |" in text
        ends = [line.split(" | ")[5:] for line in text.splitlines() if line.startswith("| the usual lab |")]
        assert ends == [
            ["York, origin", "0.50 ± 0.01", "is not the closest: that takes M0 = 0 |"],
            ["none", "–", "alone is honest |"],
            ["York, origin", "1.00 ± 0.01", "ties with 1 |"],
            ["none", "–", "is too sure |"],
        ]

    def test_progress_goes_from_nothing_to_all(self, done: Benchmark, told: list[float]) -> None:
        assert done.motion
        assert told == sorted(told)
        assert told[-1] == 1.0
        assert len(told) > 20

    def test_quick_is_less_than_full(self) -> None:
        assert QUICK.labs < FULL.labs
        assert QUICK.grid < FULL.grid
        assert set(QUICK.tolerances["RK45"]) <= set(FULL.tolerances["RK45"])
        assert set(QUICK.steps_per_nutation) <= set(FULL.steps_per_nutation)


class TestFigures:
    def test_nothing_is_cut_off_and_every_method_is_named(self, done: Benchmark) -> None:
        drawn = (
            (
                "motion",
                [point.method for panel in done.motion[:3] for point in panel.points],
            ),
            ("motion_harder", [point.method for panel in done.motion[3:] for point in panel.points]),
            ("motion_order", ["splitting aba84: 4.0", "LSODA"]),
            ("motion_drift", [*(drift.method for drift in done.drifts), "8 steps a nutation: 40 evaluations"]),
            ("estimators", [name for name in ESTIMATORS if not name.startswith(("P on M", "ODR"))]),
            ("estimators_scenes", [*ESTIMATORS, *(one.title for one in LABS)]),
            ("stability_steady", ["fails: eq. (9)", "holds: eq. (8)"]),
            ("stability_integrators", ["fails: Euler, semi-implicit, 2 ms", "holds: splitting aba84, 10 ms"]),
            ("stability_upright", list(METHODS)),
            ("stability_estimators", [*STUDENTS, "recommended", "nonsense, silently"]),
            ("stability_fits", [*(curve.title for curve in done.curves), "full cov., iterated", "fails first here"]),
            ("stability_cosine", ["cosθ", "1 − cosθ", "the same, D in fractions"]),
        )
        assert {name for name, _ in drawn} == {*CHARTS, "estimators_scenes"}
        for chart, names in drawn:
            figure = draw_chart(replace(done, machine="a machine"), chart)
            texts = shown_texts(figure)
            for text in texts:
                box = text.get_window_extent()
                assert box.x0 > -1, text
                assert box.x1 < figure.bbox.width + 1, text
                assert box.y0 > -1, text
                assert box.y1 < figure.bbox.height + 1, text
            assert {*names, "a machine"} <= {text.get_text() for text in texts}

    def test_names_do_not_lie_on_one_another(self) -> None:
        figure = Figure(figsize=(5, 4), dpi=100)
        ax = figure.add_axes((0.1, 0.1, 0.8, 0.8))
        ax.set_xlim(0, 10)
        ax.set_ylim(0, 10)
        name_dots(ax, 5 + 0.1 * np.arange(6), np.full(6, 5.0), {i: f"point {i}" for i in range(6)})
        FigureCanvasAgg(figure).draw()  # type: ignore[no-untyped-call]
        # Without the lines to their points.
        boxes = [Text.get_window_extent(text) for text in ax.texts]
        for one, other in itertools.combinations(boxes, 2):
            assert not one.overlaps(other)


class TestCommand:
    def test_writes_every_chart_and_prints_the_reading(
        self, done: Benchmark, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        asked: list[tuple[Effort, int]] = []
        machines: list[str] = []

        def run(effort: Effort, clock: object, seed: int, progress: object, wall: object, machine: str) -> Benchmark:
            asked.append((effort, seed))
            machines.append(machine)
            return replace(done, machine=machine)

        monkeypatch.setattr(room, "run_benchmark", run)
        monkeypatch.chdir(tmp_path)
        result = CliRunner().invoke(app, ["benchmark", "--quick", "--seed", "5", "--out", "charts"])
        assert result.exit_code == 0
        assert asked == [(QUICK, 5)]
        pictures = (*CHARTS, "estimators_scenes")
        forms = {f"{name}.{form}" for name in pictures for form in ("png", "svg")}
        forms |= {f"{name}.csv" for name in CHARTS if name != "motion_harder"}
        assert {path.name for path in (tmp_path / "charts").iterdir()} == forms | {"reading.md"}
        assert (tmp_path / "charts" / "reading.md").read_text(encoding="utf-8") == result.stdout
        assert result.stderr == "charts: charts\n"
        sizes = [path.stat().st_size for path in (tmp_path / "charts").glob("*.png")]
        assert max(sizes) < 150_000, "small enough for a README"
        with rc_context(STYLE):
            same = replace(done, machine=machines[0])
            again = save(draw_chart(same, "motion"), "png"), save(draw_chart(same, "stability_upright"), "svg")
        for name, data in zip(("motion.png", "stability_upright.svg"), again, strict=True):
            assert (tmp_path / "charts" / name).read_bytes() == data, "the same for the same numbers"

    def test_a_folder_that_cannot_be_written_is_refused_at_once(self, tmp_path: Path) -> None:
        result = subprocess.run(
            [sys.executable, "-m", "gyrodata", "benchmark", "--out", os.devnull],
            cwd=tmp_path,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            capture_output=True,
            text=True,
            check=False,
            timeout=60,
        )
        assert result.returncode == 2
        assert "cannot be written" in result.stderr
        assert "Traceback" not in result.stderr
