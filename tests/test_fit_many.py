"""Many labs at once: the same answers as one at a time."""

from __future__ import annotations

import numpy as np
import pytest
from labs import INERTIA, G, lab
from msgspec.structs import replace

from gyrodata.fitting import fit, fit_as_stated, fit_many

QUANTITIES = ("time", "spin", "mass", "position")


@pytest.mark.parametrize("options", [{"repeats": 3}, {}, {"weights": (0.04,)}, {"positions": (0.15, -0.15)}])
def test_agrees_with_one_at_a_time(options: dict[str, object]) -> None:
    random = np.random.default_rng(9)
    labs = [lab(random, imbalance=1e-3, bias=0.03, **options) for _ in range(12)]  # type: ignore[arg-type]
    many = fit_many(labs[0], {name: np.array([getattr(one, name) for one in labs]) for name in QUANTITIES})
    for i, one in enumerate(map(fit, labs)):
        u = one.inertia.u
        assert u is not None
        # One is linear where its runs were adjusted at the widths found, the other at a guess of them.
        assert many.inertia[i, 2] == pytest.approx(one.inertia.value, abs=0.02 * u)
        assert many.inertia[i, [0, 4]] == pytest.approx(one.inertia.interval_95, abs=0.06 * u)
        assert (many.inertia[i, 3] - many.inertia[i, 1]) / 2 == pytest.approx(u, rel=0.02)


def test_what_it_cannot_take_is_named() -> None:
    measured = lab(np.random.default_rng(1))
    with pytest.raises(ValueError, match="shape"):
        fit_many(measured, {"time": measured.time})
    with pytest.raises(ValueError, match="sense"):
        fit_many(replace(measured, sense=0 * measured.sense), {"time": measured.time[None]})


@pytest.mark.parametrize("percent", [0, 1, 2, 3, 5, 10, 20])
@pytest.mark.parametrize("bias", [0.0, 0.05])
def test_covers_at_every_imbalance(percent: float, bias: float) -> None:
    imbalance = percent / 100 * 0.020 * G * 0.15  # of the lightest torque
    exact = lab(np.random.default_rng(0), noise=0.0, imbalance=imbalance, bias=bias)
    random = np.random.default_rng(int(percent) + int(1000 * bias))
    labs, count = 1500, len(exact.runs)
    weights = np.array(exact.sources[3].groups)
    scale, zero = random.standard_normal((2, labs, 1))
    many = fit_many(
        exact,
        {
            "time": exact.time + 0.14 * random.standard_normal((labs, count)),
            "spin": exact.spin * (1 + 0.001 * scale + 0.002 * random.standard_normal((labs, count))),
            "mass": exact.mass * (1 + 0.002 * random.standard_normal((labs, 3))[:, weights]),
            "position": exact.position + 0.0005 * zero + np.zeros(count),
        },
    )
    # 93 % is asked; three standard deviations of a binomial of 1500 below.
    inside = (many.inertia[:, 0] <= INERTIA) & (many.inertia[:, 4] >= INERTIA)
    assert np.mean(inside) > 0.93 - 0.02


@pytest.mark.parametrize("repeats", [1, 3])
def test_scatters_no_more_than_the_best_linear_estimator(repeats: int) -> None:
    # The standard deviation of the best one, with all variances known and M0 free.
    best = fit_as_stated(lab(np.random.default_rng(0), repeats=repeats, noise=0.0)).inertia.u
    random = np.random.default_rng(5)
    labs = [lab(random, repeats=repeats, bias=0.05 * random.standard_normal()) for _ in range(2500)]
    many = fit_many(labs[0], {name: np.array([getattr(one, name) for one in labs]) for name in QUANTITIES})
    # 2500 labs tell a scatter to 1.4 %.
    assert np.sqrt(np.mean((many.inertia[:, 2] - INERTIA) ** 2)) < 1.04 * best
