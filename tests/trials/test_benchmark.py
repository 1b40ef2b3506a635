"""The benchmark: what it measures, draws and says, with a clock that ticks once a look."""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from gyrodata.cli import app
from gyrodata.trials import benchmark as room
from gyrodata.trials.benchmark import Benchmark, Effort, cheapest, run_benchmark
from gyrodata.trials.benchmark.estimators import (
    ESTIMATORS,
    SCENES,
    Trial,
    TrialPanel,
    covariances,
    draw_labs,
)
from gyrodata.trials.benchmark.motions import METHODS, MODELS

# All tests use the same benchmark, which takes more than a moment.
pytestmark = pytest.mark.slow

TINY = Effort(motion_labs=4, turns=16, evaluations=8_000, labs=40, repeats=1)
CHARTS = ("motion", "motion_order", "estimators", "failures")


def ticking() -> Callable[[], float]:
    """A clock on which 1/1024 s passes between two looks: a difference without
    rounding.
    """
    ticks = itertools.count()
    return lambda: next(ticks) / 1024


@pytest.fixture(scope="module")
def done() -> Benchmark:
    return run_benchmark(TINY, ticking(), progress=lambda _: None, machine="a machine")


def test_each_lab_has_the_model_that_its_physics_asks_for(done: Benchmark) -> None:
    good = {
        panel.scene.name: next(
            point.method for point in panel.points if point.error < panel.bound
        )
        for panel in done.motion
    }
    assert good == {
        "usual": "eq. (9)",
        "tilted": "eq. (8)",
        "released": "mean rate of a release",
        "slow": "full motion",
    }
    for panel in done.motion:
        assert panel.winner.error < panel.bound == pytest.approx(0.3 * panel.u)
        # No model is exact by construction.
        assert min(point.error for point in panel.points[: len(MODELS)]) > 1e-5


def test_each_integrator_has_the_order_that_it_is_known_for(done: Benchmark) -> None:
    one = {order.method: order for order in done.orders if order.turns == 1}
    assert {name: order.order for name, order in one.items()} == pytest.approx(
        METHODS, rel=0.2
    )
    assert all(order.evaluations(1e-3) for order in one.values())
    # Over many turns splitting is the cheapest for coarse errors only.
    (strang, (_, least)), (high, (most, _)) = cheapest(done.orders, TINY.turns).items()
    assert (strang, high) == ("splitting strang", "DOP853")
    assert 3e-6 < least < 1e-4 > most


def test_evaluations_are_interpolated(done: Benchmark) -> None:
    (order,) = (
        order for order in done.orders if (order.method, order.turns) == ("RK4", 1)
    )
    for before, after in itertools.pairwise(order.points[2:]):
        between = order.evaluations((before.off * after.off) ** 0.5)
        assert between == pytest.approx(
            (before.evaluations * after.evaluations) ** 0.5, rel=1e-12
        )


def trial_of(panel: TrialPanel, name: str) -> Trial:
    return panel.trials[[*ESTIMATORS].index(name)]


def test_only_the_recommended_fit_is_honest_in_all_labs(done: Benchmark) -> None:
    assert [panel.scene for panel in done.trials] == [*SCENES]
    honest = {
        name
        for name in ESTIMATORS
        if all(trial_of(panel, name).honest for panel in done.trials)
    }
    assert honest == {"recommended fit"}


def test_the_full_covariance_with_the_hand_s_bias_ties(done: Benchmark) -> None:
    (usual, full, mine), (_, wrong, right), _ = (
        [
            trial_of(panel, name)
            for name in (
                "line through the origin",
                "line, full covariance",
                "recommended fit",
            )
        ]
        for panel in done.trials
    )
    assert full.honest
    assert full.rmse == pytest.approx(mine.rmse, rel=0.1)
    assert usual.coverage < 0.6, "M0 is not 0"
    assert wrong.coverage < 0.8 < right.coverage
    assert right.rmse < wrong.rmse


def test_york_s_line_is_that_of_odrpack() -> None:
    odrpack = pytest.importorskip("odrpack")
    (lab,) = draw_labs(SCENES[0], 1, 2)
    product, torque = (np.diag(covariance) for covariance in covariances(lab))
    found = odrpack.odr_fit(
        lambda x, beta: beta[0] * x + beta[1],
        lab.product,
        lab.torque,
        np.array([4e-3, 1e-3]),
        weight_x=1 / product,
        weight_y=1 / torque,
    )
    assert ESTIMATORS["York's line"](lab)[0] == pytest.approx(found.beta[0], rel=1e-5)


def test_each_failure_has_a_solution(done: Benchmark) -> None:
    assert len(done.failures) == 9
    for one in done.failures:
        if one.measure == "relative error":
            assert one.wrong > 0.05, one.case
            assert one.right < 1e-9, one.case
        else:
            assert one.wrong < 0.85 <= one.right, one.case


def test_the_command_writes_every_chart_and_the_reading(
    done: Benchmark, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(room, "run_benchmark", lambda *_: done)
    result = CliRunner().invoke(app, ["benchmark", "--quick", "--out", str(tmp_path)])
    assert result.exit_code == 0
    expected = {f"{name}.{form}" for name in CHARTS for form in ("png", "svg", "csv")}
    assert {path.name for path in tmp_path.iterdir()} == expected | {"reading.md"}
    assert (tmp_path / "reading.md").read_text(encoding="utf-8") == result.stdout
    winners = re.findall(
        r"^\| [^|]+ rpm \| [\d.]+ % \| ([^|]+) \|", result.stdout, re.MULTILINE
    )
    assert winners == [panel.winner.method for panel in done.motion]
    assert max(path.stat().st_size for path in tmp_path.glob("*.png")) < 150_000, (
        "small enough for a README"
    )
