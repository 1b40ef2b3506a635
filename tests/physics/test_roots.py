"""Formulas that fail: eq. (9) for a tilted rod, and the plain mean of a falling spin."""

from __future__ import annotations

import math
from decimal import Decimal

import numpy as np
import pytest
from biases import tilt_bias

from gyrodata import physics
from gyrodata.physics import RPM

INERTIA, ACROSS, TORQUE, SPIN = 4.44e-3, 7.12e-3, 0.0882, 400 * RPM


def test_eq_9_fails_for_a_tilted_rod_and_so_does_the_cosine_of_its_pitch() -> None:
    pitch, spin = math.radians(45), 100 * RPM
    rate = physics.precession_rate(TORQUE, spin, INERTIA, ACROSS, pitch)
    plain = TORQUE / (rate * spin)
    mistaken = TORQUE * math.cos(pitch) / (rate * spin)
    assert plain / INERTIA - 1 == pytest.approx(-0.08, abs=0.02)
    assert mistaken / INERTIA - 1 == pytest.approx(-0.35, abs=0.02)
    corrected = plain / (1 + tilt_bias(rate, spin, pitch, INERTIA, ACROSS))
    assert corrected == pytest.approx(INERTIA, rel=1e-14)


def test_the_plain_mean_of_a_spin_that_halves_is_8_percent_off() -> None:
    harmonic = physics.harmonic_mean_spin(SPIN, SPIN / 2)
    assert 0.75 * SPIN / harmonic - 1 == pytest.approx(0.082, abs=0.001)
    # One over the spin, averaged over a viscous fall in a million steps.
    times = (np.arange(1_000_000) + 0.5) / 1_000_000
    assert harmonic == pytest.approx(1 / np.mean(1 / (SPIN * 0.5**times)), rel=1e-10)


def textbook_root(pitch: float) -> float:
    """Compute the slow rate of eq. (8) by (−b + √D)/2a [rad/s]."""
    a, b = (INERTIA - ACROSS) * math.sin(pitch), INERTIA * SPIN
    return (-b + math.sqrt(b * b + 4 * a * TORQUE)) / (2 * a)


def true_rate(pitch: float) -> float:
    """Compute the slow rate of eq. (8) with 28 digits [rad/s]; cosθ is the same as above."""
    a = (Decimal(INERTIA) - Decimal(ACROSS)) * Decimal(math.sin(pitch))
    b = Decimal(INERTIA) * Decimal(SPIN)
    root = (b * b + 4 * a * Decimal(TORQUE)).sqrt()
    return float(2 * Decimal(TORQUE) / (b + root))


def test_the_textbook_root_loses_its_digits_as_the_rod_becomes_level() -> None:
    pitches = np.arcsin(10.0 ** -np.arange(1, 17))
    true = np.array([true_rate(pitch) for pitch in pitches])
    rate = physics.precession_rate(TORQUE, SPIN, INERTIA, ACROSS, pitches)
    assert rate == pytest.approx(true, rel=1e-15)
    lost = [
        abs(textbook_root(pitch) / one - 1)
        for pitch, one in zip(pitches, true, strict=True)
    ]
    assert lost[0] < 1e-12
    assert lost[8] > 1e-8
    assert lost[-1] == 1
