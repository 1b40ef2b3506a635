"""The nutation of a rod let go from rest, of any size and at any tilt, against eqs. (7)
integrated.
"""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from gyrodata import physics
from gyrodata.physics.motion import Nutation, Top, nutation

INERTIA, RPM = 4.44e-3, math.pi / 30


def integrated(top: Top, spin: float, pitch: float) -> Nutation:
    """From rest to the next turning point, half a nutation, by θ and φ and the means of
    both.
    """
    own, start = top.inertia * spin, math.pi / 2 - pitch
    upwards = own * math.cos(start)

    def motion(_: float, state: NDArray[np.float64]) -> list[float]:
        theta, fall, *_sums = state
        cos, sin = math.cos(theta), math.sin(theta)
        rate = (upwards - own * cos) / (top.transverse_inertia * sin**2)
        pull = (
            (top.torque - own * rate + top.transverse_inertia * rate**2 * cos)
            * sin
            / top.transverse_inertia
        )
        return [fall, pull, rate, theta - start, rate * sin]

    def turns(_: float, state: NDArray[np.float64]) -> float:
        return float(state[1])

    turns.terminal, turns.direction = True, -np.sign(top.torque)  # type: ignore[attr-defined]
    done = solve_ivp(
        motion,
        (0, 9),
        [start, 0, 0, 0, 0],
        method="DOP853",
        rtol=1e-12,
        atol=1e-14,
        events=turns,
        dense_output=True,
    )
    half = done.t[-1]
    theta, _, turned, sagged, aside = done.y[:, -1]
    times = np.linspace(0, half, 2001)
    lead = np.abs(done.sol(times)[2] / (turned / half) - times).max()
    return Nutation(2 * half, sagged / half, theta - start, aside / half, lead)


@pytest.mark.slow
def test_forty_random_tilted_rods() -> None:
    draw = np.random.default_rng(40)
    for _ in range(40):
        spin = (
            draw.choice([-1, 1])
            * RPM
            * math.exp(draw.uniform(math.log(30), math.log(600)))
        )
        torque = draw.choice([-1, 1]) * draw.uniform(0.02, 0.12)
        top, pitch = (
            Top(
                inertia=INERTIA,
                transverse_inertia=INERTIA * draw.uniform(0.6, 2),
                torque=torque,
            ),
            math.radians(draw.uniform(-85, 85)),
        )
        found, expected = nutation(top, spin, pitch), integrated(top, spin, pitch)
        for name in ("period", "mean_sag", "greatest_sag", "sideways"):
            assert getattr(found, name) == pytest.approx(
                getattr(expected, name), rel=1e-8
            ), (name, top, spin, pitch)
        # As near as a grid of 2000 comes to a largest value.
        assert found.lead == pytest.approx(expected.lead, rel=2e-6)


@pytest.mark.parametrize("pitch", [-60.0, -10.0, 0.0, 25.0, 80.0])
@pytest.mark.parametrize("torque", [0.03, 0.6, -0.06, 1e-9])
def test_the_greatest_sag_is_that_of_the_energy(pitch: float, torque: float) -> None:
    across, spin, angle = 1.6 * INERTIA, 200 * RPM, math.radians(pitch)
    found = nutation(
        Top(inertia=INERTIA, transverse_inertia=across, torque=torque), spin, angle
    ).greatest_sag
    with mpmath.workdps(40):
        up, load = mpmath.sin(mpmath.mpf(angle)), 2 * mpmath.mpf(across) * torque
        linear = (mpmath.mpf(INERTIA) * spin) ** 2 / load - 2 * up
        root = mpmath.sqrt(linear**2 + 4 * (1 - up**2))
        expected = mpmath.mpf(angle) - mpmath.asin(
            up - (root * mpmath.sign(load) - linear) / 2
        )
    assert found == pytest.approx(float(expected), rel=1e-13)


@pytest.mark.parametrize("pitch", [-1.2, 0.0, 0.7])
def test_a_small_one_has_the_closed_forms(pitch: float) -> None:
    torque, spin, across = 1e-5, 400 * RPM, 1.5 * INERTIA
    found = nutation(
        Top(inertia=INERTIA, transverse_inertia=across, torque=torque), spin, pitch
    )
    delta = across * torque / (INERTIA * spin) ** 2
    rate = physics.precession_rate(torque, spin, INERTIA, across, pitch)
    along = rate * math.sin(pitch)
    small = math.hypot(
        INERTIA * (spin + along) / across - 2 * along, rate * math.cos(pitch)
    )
    click = physics.click_error(spin, INERTIA, across)
    sag, sideways = delta * math.cos(pitch), rate * math.cos(pitch)
    expected = (2 * math.pi / small, sag, 2 * sag, sideways, click)
    names = ("period", "mean_sag", "greatest_sag", "sideways", "lead")
    assert [getattr(found, name) for name in names] == pytest.approx(
        expected, rel=10 * delta
    )


@pytest.mark.parametrize(
    "short", [3.0, 1.0, 0.6, 0.3, 0.15, 0.07, 0.03, 1e-2, 3e-3, 1e-3, 1e-4, 1e-6]
)
def test_the_period_of_a_pendulum_near_upright_is_k_of_jacobi(short: float) -> None:
    # K of 1 − m = sin²(short/2), which a start so near the upright still tells; from
    # 1e-5 on the start is rounded.
    pitch = math.pi / 2 - short
    with mpmath.workdps(40):
        away = mpmath.pi / 2 - mpmath.mpf(pitch)
        period = (
            2
            * mpmath.ellipk(mpmath.cos(away / 2) ** 2)
            * mpmath.sqrt(mpmath.mpf(6e-3) / mpmath.mpf(0.05))
        )
    found = nutation(
        Top(inertia=INERTIA, transverse_inertia=6e-3, torque=0.05), 0.0, pitch
    ).period
    assert found == pytest.approx(float(period), rel=2e-15 + 2e-17 / short)
