"""A lab's fits tried out on labs like it: what an honest uncertainty covers, and what the textbook's does."""

from __future__ import annotations

import itertools
import json
from pathlib import Path

import numpy as np
import pytest
from labs import lab
from msgspec.structs import replace
from typer.testing import CliRunner

from gyrodata.cli import app
from gyrodata.coverage import Performance, SelfCheck, selfcheck
from gyrodata.measurements import Measurements


def check(measured: Measurements, labs: int = 400, **options: object) -> tuple[SelfCheck, dict[str, Performance]]:
    done = selfcheck(measured, itertools.count().__next__, labs, **options)  # type: ignore[arg-type]
    return done, {one.name: one for one in done.estimators}


@pytest.mark.parametrize("repeats", [1, 3])
@pytest.mark.parametrize("imbalance", [0.0, 6e-3])
def test_the_recommended_fit_is_honest_and_the_textbook_is_not(repeats: int, imbalance: float) -> None:
    measured = lab(np.random.default_rng(0), noise=0.0, repeats=repeats, imbalance=imbalance)
    _, by_name = check(measured, seed=2)
    best = by_name["recommended"]
    assert best.coverage_68 == pytest.approx(0.683, abs=0.07)  # three standard deviations of a binomial of 400
    assert best.coverage_95 == pytest.approx(0.954, abs=0.032)
    assert best.bias == pytest.approx(0, abs=0.002)
    assert best.mean_u == pytest.approx(best.rmse, rel=0.12)
    for name in ("through_origin", "with_constant", "mean_of_ratios"):
        assert by_name[name].coverage_95 < 0.9


def test_a_log_with_more_scatter_is_also_tried_with_its_own() -> None:
    measured = lab(np.random.default_rng(3), repeats=3, u_time=0.5)
    boasting = replace(
        measured,
        sources=(replace(measured.sources[0], absolute=np.full(27, 0.14), default=False), *measured.sources[1:]),
    )
    done, stated = check(boasting, 300, seed=2)
    assert done.scatter == pytest.approx(0.5 / 0.14, rel=0.4)
    assert done.estimators_with_scatter is not None
    seen = {one.name: one for one in done.estimators_with_scatter}
    assert seen["recommended"].coverage_95 == pytest.approx(0.95, abs=0.04)
    assert seen["recommended"].rmse > 1.5 * stated["recommended"].rmse
    assert f"this log's scatter is {done.scatter:.2g} times what is stated" in done.to_text().splitlines()[0]
    assert done.to_text().count("\nrecommended ") == 2
    agreeing, _ = check(replace(measured, sources=(replace(boasting.sources[0], absolute=np.full(27, 0.5)),
                                                   *measured.sources[1:])), 10)  # fmt: skip
    assert agreeing.estimators_with_scatter is None
    assert "agrees" in agreeing.to_text().splitlines()[0]
    assert agreeing.to_text().count("\nrecommended ") == 1


def test_same_seed_same_labs_and_the_contract() -> None:
    measured = lab(np.random.default_rng(2))
    told: list[int] = []
    first, _ = check(measured, 100, seed=3, progress=told.append)
    again, _ = check(measured, 100, seed=3)
    assert first == again
    assert told == [50, 100]
    assert first != check(measured, 100, seed=4)[0]
    out = json.loads(json.dumps(first.to_dict(), allow_nan=False))
    assert out["labs"] == 100
    assert set(out["estimators"][0]) == {
        "name", "bias", "rmse", "coverage_68", "coverage_95", "mean_u", "time_us", "refused",
    }  # fmt: skip
    assert "recommended" in first.to_text()


def test_salort_log_is_covered_and_no_lab_is_refused() -> None:
    log = str(Path(__file__).parent.parent / "sample_data" / "salort_one_torque.csv")
    done = CliRunner().invoke(app, ["selfcheck", log, "--labs", "120", "--format", "json"])
    found = json.loads(done.stdout)
    for table in ("estimators", "estimators_with_scatter"):
        (one,) = [one for one in found[table] if one["name"] == "recommended"]
        assert one["coverage_95"] > 0.9
        assert abs(one["bias"]) < 0.15
        assert one["mean_u"] > 0
        assert one["refused"] == 0


def test_one_torque_a_balance_test_and_an_unknown_sense() -> None:
    random = np.random.default_rng(2)
    # With one torque the fitted M0 is none, and the interval allows for one: it nearly always holds such labs.
    _, alone = check(lab(random, weights=(0.04,)), 300)
    assert alone["recommended"].coverage_95 > 0.94
    assert alone["recommended"].mean_u > 2 * alone["recommended"].rmse
    tested = replace(lab(random, noise=0.0), imbalance_u=lambda inertia: 2e-4, imbalance_from="u_imbalance")
    _, balanced = check(tested, 100)
    assert balanced["recommended"].coverage_95 > 0.88
    _, unsensed = check(lab(random, unloaded=True, sensed=False, imbalance=5e-4), 100)
    assert unsensed["recommended"].coverage_95 > 0.88
