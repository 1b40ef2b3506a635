"""What the constant means: I_zz beside that of a solid ball."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from gyrodata import physics
from gyrodata.fitting import Estimate
from gyrodata.units import Uncertainty


@dataclass(frozen=True, slots=True)
class Ball:
    """The solid ball that the log describes, and how the measured I_zz compares with it."""

    mass: float
    """[kg]"""
    mass_u: float | None
    """Standard uncertainty [kg]; None where the log does not state it: taken as exact."""
    diameter: float
    """[m]"""
    diameter_u: float | None
    """Standard uncertainty [m]; None where the log does not state it: taken as exact."""
    inertia: float
    """2/5 m r² [kg*m^2]."""
    inertia_u: float | None
    """Its standard uncertainty [kg*m^2]; None where neither mass nor diameter has one."""
    difference: float
    """I_zz minus 2/5 m r² [kg*m^2]."""
    difference_u: float | None
    """Standard uncertainty of the difference [kg*m^2]."""
    relative: float
    """I_zz over 2/5 m r², minus 1."""
    deviation: float | None
    """The difference in its standard uncertainties."""


def compare_with_ball(
    inertia: Estimate, constants: Mapping[str, float], uncertainties: Mapping[str, Uncertainty]
) -> Ball | None:
    """Compare I_zz with 2/5 m r² of a ball.

    Parameters
    ----------
    inertia : Estimate
        I_zz [kg*m^2].
    constants : mapping of str to float
        "ball_mass" [kg] and "ball_diameter" [m].
    uncertainties : mapping of str to Uncertainty
        "u_ball_mass" and "u_ball_diameter", where they are stated.

    Returns
    -------
    Ball or None
        None where mass or diameter is missing.
    """
    if "ball_mass" not in constants or "ball_diameter" not in constants:
        return None
    mass, diameter = constants["ball_mass"], constants["ball_diameter"]
    stated = [uncertainties.get("u_ball_mass"), uncertainties.get("u_ball_diameter")]
    mass_u, diameter_u = (
        given.at(value) if given else None for given, value in zip(stated, (mass, diameter), strict=True)
    )
    solid = physics.solid_ball_inertia(mass, diameter)
    solid_u = None
    if mass_u is not None or diameter_u is not None:
        # 2/5 m (d/2)² grows as m and as d².
        solid_u = solid * math.hypot((mass_u or 0.0) / mass, 2 * (diameter_u or 0.0) / diameter)
    difference = inertia.value - solid
    difference_u = None if inertia.u is None else math.hypot(inertia.u, solid_u or 0.0)
    return Ball(
        mass=mass,
        mass_u=mass_u,
        diameter=diameter,
        diameter_u=diameter_u,
        inertia=solid,
        inertia_u=solid_u,
        difference=difference,
        difference_u=difference_u,
        relative=inertia.value / solid - 1,
        deviation=difference / difference_u if difference_u else None,
    )
