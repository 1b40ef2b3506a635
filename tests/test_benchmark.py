"""The benchmark: what it measures, draws and says, with a clock that ticks once a look."""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace
from scipy import stats
from typer.testing import CliRunner

from gyrodata import benchmark as room
from gyrodata.benchmark import BATCH, Benchmark, Effort, run_benchmark
from gyrodata.benchmark.estimators import ESTIMATORS, STUDENTS, one_lab, stated_errors
from gyrodata.benchmark.motion_cost import LADDER, SCENES
from gyrodata.benchmark.orders import find_orders
from gyrodata.benchmark.stability import INERTIA
from gyrodata.benchmark.trials import CASES, LabScene, apply_all, judge
from gyrodata.benchmark.trials import SCENES as LABS
from gyrodata.cli import app

TINY = Effort(
    tolerances={"DOP853": (1e-4, 1e-6), "Tsit5": (1e-4,), "LSODA": (1e-4,)}, tightest=1e-9,
    steps_per_nutation=(4.0, 16.0, 64.0, 128.0), budget=0.04, repeats=1, precessions=3, labs=10, grid=2, fine_grid=12,
    swings=1, draws=8, curve_labs=6,
)  # fmt: skip
EQUAL_TORQUES = {"one torque", "identical runs", "one run"}
CHARTS = (
    "motion", "motion_harder", "motion_order", "motion_drift", "estimators", "stability_steady",
    "stability_integrators", "stability_upright", "stability_estimators", "stability_fits", "stability_cosine",
)  # fmt: skip


def ticking() -> Callable[[], float]:
    """A clock on which 1/1024 s passes between two looks: a difference without rounding."""
    ticks = itertools.count()
    return lambda: next(ticks) / 1024


@pytest.fixture(scope="module")
def done() -> Benchmark:
    return run_benchmark(TINY, ticking(), progress=lambda _: None, wall=ticking())


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


def test_each_integrator_has_the_order_that_it_is_known_for(done: Benchmark) -> None:
    tolerances = {"RK45": (1e-6, 1e-8), "Tsit5": (1e-6, 1e-8), "DOP853": (1e-6, 1e-9)}
    orders = find_orders(replace(TINY, tolerances=tolerances, steps_per_nutation=(64.0, 256.0, 512.0)))
    known = {"splitting strang": 2, "splitting aba84": 4, "RK4": 4, "implicit midpoint": 2, "RKMK4": 4, "RK45": 5,
             "Tsit5": 5, "DOP853": 8}  # fmt: skip
    assert {order.method: order.order for order in orders} == pytest.approx(known, rel=0.2)
    assert (done.orders[-1].method, done.orders[-1].order) == ("LSODA", None), "it chooses its order"


def scene(name: str) -> LabScene:
    return next(one for one in LABS if one.name == name)


def tried(names: Sequence[str], name: str, labs: int) -> list[Any]:
    """Judge some estimators by labs of one scene."""
    return list(judge(apply_all({one: ESTIMATORS[one] for one in names}, scene(name).draw(labs, 3))))


class TestTrials:
    def test_every_estimator_is_tried_in_every_scene(self, done: Benchmark) -> None:
        assert [panel.scene.name for panel in done.trials] == [one.name for one in LABS]
        for panel in done.trials:
            assert [trial.estimator for trial in panel.trials] == list(ESTIMATORS)
            assert (panel.recommended.failed, panel.recommended.ratio) == (0, 1)

    def test_the_recommended_fit_reaches_the_bound(self) -> None:
        for one in LABS:
            if not one.as_stated:
                continue
            labs = one.draw(80, 3)
            (mine,) = judge(apply_all({"recommended": ESTIMATORS["recommended"]}, labs))
            assert mine.honest, one.title
            assert mine.rmse - 2 * mine.rmse_u < 1.1 * one.bound(), one.title

    def test_the_full_covariance_with_the_hand_s_bias_ties(self) -> None:
        names = ("full cov., constant", "full cov., iterated", "York, constant", "York, origin", "recommended")
        full, iterated, york, origin, mine = tried(names, "usual", 400)
        assert (full.honest, full.ties) == (True, True)
        assert (iterated.honest, iterated.ties) == (True, True)
        assert mine.coverage > york.coverage
        assert origin.coverage < 0.3, "M0 is not 0"
        # One that knows that the ball is balanced is closer, where it is.
        (known, _) = tried(("full cov., origin", "recommended"), "balanced", 400)
        assert (known.honest, known.better) == (True, True)

    @pytest.mark.parametrize("name", ["tenfold", "tails", "miscount"])
    def test_of_a_wrong_log_only_the_recommended_fit_is_honest(self, name: str) -> None:
        full, mine = tried(("full cov., constant", "recommended"), name, 60)
        assert mine.coverage > 0.85
        assert full.coverage < 0.92
        assert mine.rmse < full.rmse

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


class TestStability:
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


def test_the_command_writes_every_chart_and_the_reading(
    done: Benchmark, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(room, "run_benchmark", lambda *_, **__: done)
    result = CliRunner().invoke(app, ["benchmark", "--quick", "--seed", "5", "--out", str(tmp_path)])
    assert result.exit_code == 0
    forms = {f"{name}.{form}" for name in (*CHARTS, "estimators_scenes") for form in ("png", "svg")}
    forms |= {f"{name}.csv" for name in CHARTS if name != "motion_harder"}
    assert {path.name for path in tmp_path.iterdir()} == forms | {"reading.md"}
    assert (tmp_path / "reading.md").read_text(encoding="utf-8") == result.stdout
    rows = dict(re.findall(r"\| (level and|tilted 45).*? \| ([\d.]+ % \| .*?) \|", result.stdout))
    assert rows == {"level and": "0.91 % | eq. (9)", "tilted 45": "2.1 % | eq. (8)"}
    assert max(path.stat().st_size for path in tmp_path.glob("*.png")) < 150_000, "small enough for a README"
