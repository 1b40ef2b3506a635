"""Fits of one lab by other programs, each called as its manual shows.

A lab is a mapping of arrays of n numbers, in SI: ``angle`` (2π times the turns, times
the spin), ``time``, ``torque``, ``time_u`` (standard uncertainty of each time), and the
covariances ``product_cov`` of φ̇ψ̇ and ``torque_cov`` of the torque, of n rows. A fit
returns I_zz and the ends of its 95 % interval [kg*m^2].
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from importlib.util import find_spec
from typing import Any

import numpy as np

from gyrodata import fitting

NORMAL_95 = 1.959964
"""Half of a 95 % interval over u, for a normal distribution."""

Answer = tuple[float, float, float]
"""I_zz and the ends of its 95 % interval [kg*m^2]."""

Lab = Mapping[str, Any]


def product(lab: Lab) -> Any:
    """Compute φ̇ψ̇ of each run [rad²/s²], shape (n,)."""
    return lab["angle"] / lab["time"]


def predicted_time(lab: Lab, inertia: float, residual: float) -> Any:
    """Compute the time of each run by eq. (9) [s], shape (n,), from I_zz and M0."""
    return lab["angle"] * inertia / (lab["torque"] + residual)


def start(lab: Lab) -> list[float]:
    """Return first values of I_zz [kg*m^2] and M0 [N*m]."""
    return [float(np.median(lab["torque"] / product(lab))), 0.0]


def interval(value: Any, u: Any, free: int | None = None) -> Answer:
    """Return the 95 % interval of a value; Student's factor for u from the scatter."""
    factor = NORMAL_95
    if free is not None:
        from scipy.special import stdtrit

        factor = float(stdtrit(free, 0.975))
    return float(value), float(value - factor * u), float(value + factor * u)


def textbook(lab: Lab, name: str, unknowns: int) -> Answer:
    """Average M/(φ̇ψ̇), or fit M to φ̇ψ̇ by a straight line."""
    if name == "with_constant" and not fitting.torques_differ(lab["torque"]):
        raise ValueError("a line needs different torques")
    value, u = fitting.TEXTBOOK[name](product(lab), lab["torque"])
    return interval(value, u, len(lab["torque"]) - unknowns)


def curve_fit(lab: Lab) -> Answer:
    """Fit the times with their stated u."""
    from scipy.optimize import curve_fit as fit

    (value, _), covariance = fit(
        lambda _, inertia, residual: predicted_time(lab, inertia, residual),
        lab["torque"],
        lab["time"],
        p0=start(lab),
        sigma=lab["time_u"],
        absolute_sigma=True,
    )
    return interval(value, covariance[0, 0] ** 0.5)


def odrpack(lab: Lab) -> Answer:
    """Fit M to φ̇ψ̇ with errors of both, which are independent."""
    from odrpack import odr_fit

    solution = odr_fit(
        lambda x, beta: beta[0] * x + beta[1],
        product(lab),
        lab["torque"],
        np.array(start(lab)),
        weight_x=1 / np.diag(lab["product_cov"]),
        weight_y=1 / np.diag(lab["torque_cov"]),
    )
    return interval(solution.beta[0], solution.sd_beta[0], len(lab["torque"]) - 2)


def lmfit(lab: Lab) -> Answer:
    """Fit the times with u, scaled by the scatter, as is the default."""
    from lmfit import Parameters, minimize

    parameters = Parameters()
    for name, value in zip(("inertia", "residual"), start(lab), strict=True):
        parameters.add(name, value=value)

    def deviations(at: Any) -> Any:
        return (predicted_time(lab, **at.valuesdict()) - lab["time"]) / lab["time_u"]

    solution = minimize(deviations, parameters)
    inertia = solution.params["inertia"]
    return interval(inertia.value, inertia.stderr, solution.nfree)


def iminuit(lab: Lab) -> Answer:
    """Minimise chi-square of the times with all covariances, and use MINOS."""
    from iminuit import Minuit

    # Relative errors of φ̇ψ̇ and of M are relative errors of the time.
    relative = lab["product_cov"] / np.outer(product(lab), product(lab))
    relative += lab["torque_cov"] / np.outer(lab["torque"], lab["torque"])
    inverse = np.linalg.inv(relative * np.outer(lab["time"], lab["time"]))

    def chi_square(inertia: float, residual: float) -> float:
        off = lab["time"] - predicted_time(lab, inertia, residual)
        return float(off @ inverse @ off)

    minuit = Minuit(chi_square, *start(lab))
    minuit.errordef = Minuit.LEAST_SQUARES
    minuit.migrad()
    minuit.minos("inertia", cl=0.95)
    value = minuit.values["inertia"]
    errors = minuit.merrors["inertia"]
    return value, value + errors.lower, value + errors.upper


LINE = "line with intercept"

PROGRAMS: Mapping[str, Callable[[Lab], Answer]] = {
    "mean of ratios": partial(textbook, name="mean_of_ratios", unknowns=1),
    LINE: partial(textbook, name="with_constant", unknowns=2),
    "scipy curve_fit": curve_fit,
    "lmfit": lmfit,
    "odrpack": odrpack,
    "iminuit": iminuit,
}
"""The fit of each program, by its name in the charts."""

OPTIONAL = "lmfit", "odrpack", "iminuit"
"""Packages that need not be installed."""


def installed() -> dict[str, Callable[[Lab], Answer]]:
    """Return the fits of the programs that are installed, by name."""
    missing = [name for name in OPTIONAL if find_spec(name) is None]
    return {name: fit for name, fit in PROGRAMS.items() if name not in missing}
