"""The Earth under the gyroscope, a force on its tip, and the wheel on the turntable."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.spatial.transform import Rotation

from gyrodata import physics

ITHACA = math.radians(42.5)
QUARTER = physics.SIDEREAL_DAY / 4


@pytest.mark.slow
@given(
    st.floats(-1.5, 1.5), st.floats(0, 6.28), st.floats(-1.5, 1.5), st.floats(0, 1e5)
)
def test_it_follows_a_star(
    latitude: float, azimuth: float, altitude: float, time: float
) -> None:
    """By the astronomers' triangle: the declination stays and the hour angle grows."""
    north = math.cos(altitude) * math.cos(azimuth)
    sine = math.sin(altitude) * math.sin(latitude) + north * math.cos(latitude)
    declination = math.asin(min(1.0, max(-1.0, sine)))
    hour = math.atan2(
        -math.sin(azimuth) * math.cos(altitude),
        math.sin(altitude) * math.cos(latitude) - north * math.sin(latitude),
    )
    later = hour + physics.EARTH_ROTATION * time
    up = math.sin(latitude) * math.sin(declination) + math.cos(latitude) * math.cos(
        declination
    ) * math.cos(later)
    east = -math.cos(declination) * math.sin(later)
    bearing, height = physics.balanced_direction(azimuth, altitude, latitude, time)
    assert math.sin(height) == pytest.approx(up, abs=1e-7)
    assert math.cos(height) * math.sin(bearing) == pytest.approx(east, abs=1e-7)
    assert 0 <= bearing <= 2 * math.pi


def test_a_rod_overhead_has_no_azimuth() -> None:
    azimuth, altitude = physics.balanced_direction(math.pi / 2, 0.0, 0.0, QUARTER)
    assert math.isnan(azimuth)
    assert altitude == pytest.approx(math.pi / 2, abs=1e-12)


@pytest.mark.parametrize(
    ("away", "known"), [(0.5e-12, False), (1.5e-12, True), (1e-9, True)]
)
def test_azimuth_is_unknown_only_within_1e_12_of_the_vertical(
    away: float, known: bool
) -> None:
    # On the equator a rod that points at the zenith moves west, Ω t from it.
    azimuth, _ = physics.balanced_direction(
        0.0, math.pi / 2, 0.0, away / physics.EARTH_ROTATION
    )
    assert math.isnan(azimuth) != known
    assert not known or azimuth == pytest.approx(1.5 * math.pi, abs=1e-3)


@pytest.mark.parametrize("rate", [0.3, -0.3, 0.05])
def test_the_earths_bias_from_a_turning_lab(rate: float) -> None:
    # Seen from the lab a fast top turns about φ̇ Z − Ω, from the true φ̇ of eq. (9).
    earth = physics.EARTH_ROTATION * np.array([0.0, math.cos(ITHACA), math.sin(ITHACA)])
    seen = math.copysign(
        float(np.linalg.norm(np.array([0.0, 0.0, rate]) - earth)), rate
    )
    turned = Rotation.from_rotvec(
        (np.array([0.0, 0.0, rate]) - earth) * 2 * math.pi / abs(seen)
    )
    np.testing.assert_allclose(turned.apply([1.0, 0, 0]), [1, 0, 0], atol=1e-12)
    assert rate - seen == pytest.approx(
        physics.EARTH_ROTATION * math.sin(ITHACA), rel=2e-3
    )


def test_normal_gravity_is_the_published_one() -> None:
    # WGS 84 (NIMA TR8350.2): equator and pole. GRS 80 (Moritz, J. Geod. 74, 128, 2000)
    # has 9.806199203 at 45 degrees, and is above it by 1.4e-6 at the equator and at the
    # pole.
    assert physics.normal_gravity(0.0) == pytest.approx(9.7803253359, rel=1e-12)
    assert physics.normal_gravity(np.radians([-90.0, 90.0])) == pytest.approx(
        [9.8321849378] * 2, rel=1e-10
    )
    assert physics.normal_gravity(np.radians(45.0)) == pytest.approx(
        9.806199203 - 1.4e-6, abs=1e-7
    )


def test_a_bored_ball_is_the_ball_less_the_bore_at_one_density() -> None:
    mass, diameter, bore, depth = 4.3, 0.1016, 0.02, 0.04
    density = mass / (
        4 / 3 * math.pi * (diameter / 2) ** 3 - math.pi * (bore / 2) ** 2 * depth
    )
    # By rings of the ball and of the bore: ∫ r² dm.
    rings, _ = quad(
        lambda r: 4 * math.pi * r**3 * math.sqrt(diameter**2 / 4 - r**2),
        0,
        diameter / 2,
        epsabs=0,
    )
    bored, _ = quad(lambda r: 2 * math.pi * r**3 * depth, 0, bore / 2, epsabs=0)
    assert physics.bored_ball_inertia(mass, diameter, bore, depth) == pytest.approx(
        density * (rings - bored), rel=1e-9
    )
    solid = physics.solid_ball_inertia(mass, diameter)
    assert physics.bored_ball_inertia(mass, diameter, 0.0, 0.0) == pytest.approx(
        solid, rel=1e-14
    )
    # A steel ball of four inches.
    assert solid == pytest.approx(4.44e-3, rel=2e-3)
    assert physics.cylinder_inertia(2.0, 0.4) == pytest.approx(0.04, rel=1e-15)
