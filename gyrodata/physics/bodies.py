"""Moments of inertia from mass and size."""

from __future__ import annotations


def solid_ball_inertia(mass: float, diameter: float) -> float:
    """Moment of inertia of a homogeneous ball about any axis through its centre, 2/5 m r².

    Parameters
    ----------
    mass : float
        [kg].
    diameter : float
        [m].

    Returns
    -------
    float
        [kg*m^2].
    """
    return 0.4 * mass * (diameter / 2) ** 2
