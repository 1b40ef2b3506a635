"""A rod let go from rest, against its nutation integrated between the turning points."""

from __future__ import annotations

import math
from typing import NamedTuple

import mpmath
import numpy as np
import pytest
from biases import release_bias
from scipy.integrate import solve_ivp

from gyrodata import physics

INERTIA = 4.44e-3
RPM = math.pi / 30


class Nutation(NamedTuple):
    """From the level to the lowest point u1 and back, by the conserved energy and
    momenta.
    """

    torque: float
    spin: float
    across: float

    def period(self, what: str = "1") -> mpmath.mpf:
        """Integral over a nutation of 1, φ̇ or φ̇ cosθ: u = u1 cos²x takes the singular
        ends away.
        """
        own, across, torque = (
            mpmath.mpf(INERTIA) * self.spin,
            mpmath.mpf(self.across),
            mpmath.mpf(self.torque),
        )
        linear = own**2 / (2 * across * torque)
        # Where the energy leaves nothing for θ̇, cosθ.
        low = (linear - mpmath.sqrt(linear**2 + 4)) / 2

        def weight(x: mpmath.mpf) -> mpmath.mpf:
            u = low * mpmath.cos(x) ** 2
            time = 4 / mpmath.sqrt(2 * torque / across * (linear - low - u))
            if what == "1":
                return time
            rate = -own * u / (across * (1 - u * u))
            return time * (rate if what == "rate" else rate * u)

        return mpmath.quad(weight, [0, mpmath.pi / 2])

    def mean(self) -> float:
        return float(self.period("rate") / self.period())

    def mean_spin(self) -> float:
        """Mean of ψ̇ = ω3 − φ̇ cosθ, which a tachometer shows that follows the rod."""
        return self.spin - float(self.period("excess") / self.period())


def lab(grams: float, rpm: float, ratio: float) -> Nutation:
    return Nutation(1e-3 * grams * 9.8031 * 0.15, rpm * RPM, ratio * INERTIA)


@pytest.mark.parametrize(
    ("top", "exact", "closed"),
    [
        (lab(20, 200, 1.39), 0.0879, 0.0881),
        (lab(60, 200, 1.6), 1.02, 1.05),
        (lab(120, 200, 1.9), 5.16, 5.93),
    ],
)
def test_release_bias_in_digits(top: Nutation, exact: float, closed: float) -> None:
    assert 100 * (top.torque / (INERTIA * top.spin) / top.mean() - 1) == pytest.approx(
        exact, rel=6e-3
    )
    bias = 100 * release_bias(top.torque, top.spin, INERTIA, top.across)
    assert bias == pytest.approx(closed, rel=6e-3)


def test_click_error_is_the_wave_on_the_azimuth() -> None:
    # Largest lead of the azimuth over its mean, as a time, from the motion itself.
    top = lab(20, 400, 1.39)
    own = INERTIA * top.spin

    def motion(_: float, state: np.ndarray) -> list[float]:
        cos, sin = math.cos(state[0]), math.sin(state[0])
        rate = -own * cos / (top.across * sin**2)
        fall = (top.torque - own * rate + top.across * rate**2 * cos) * sin / top.across
        return [state[1], fall, rate]

    period = float(top.period())
    found = solve_ivp(
        motion,
        (0, period),
        [math.pi / 2, 0, 0],
        rtol=1e-10,
        atol=1e-12,
        max_step=period / 200,
    )
    lag = found.t - found.y[2] / (found.y[2][-1] / period)
    assert max(abs(lag)) == pytest.approx(
        physics.click_error(top.spin, INERTIA, top.across), rel=2e-3
    )
