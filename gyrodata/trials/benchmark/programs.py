"""Fits of one lab by other programs, each called as its manual shows.

A lab is a mapping of arrays of n numbers, in SI: ``angle`` (2π times the turns, times
the spin), ``time``, ``torque``, ``time_u`` (standard uncertainty of each time), and the
covariances ``product_cov`` of φ̇ψ̇ and ``torque_cov`` of the torque, of n rows. A fit
returns I_zz and the ends of its 95 % interval [kg*m^2].

``python programs.py NAME`` reads a lab from standard input. It imports nothing of
gyrodata, so that the cost of a whole process is that of the program.
"""

from __future__ import annotations

import pickle
import sys
from collections.abc import Callable, Mapping
from importlib.util import find_spec
from typing import Any

import numpy as np

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


def mean_of_ratios(lab: Lab) -> Answer:
    """Average M/(φ̇ψ̇)."""
    ratios = lab["torque"] / product(lab)
    count = len(ratios)
    return interval(ratios.mean(), ratios.std(ddof=1) / count**0.5, count - 1)


def line_with_intercept(lab: Lab) -> Answer:
    """Fit M to φ̇ψ̇ by a straight line."""
    if not np.ptp(lab["torque"]):
        raise ValueError("a line needs different torques")
    (slope, _), covariance = np.polyfit(product(lab), lab["torque"], 1, cov=True)
    return interval(slope, covariance[0, 0] ** 0.5, len(lab["torque"]) - 2)


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
    from lmfit import create_params, minimize

    inertia, residual = start(lab)
    parameters = create_params(inertia=inertia, residual=residual)

    def deviations(at: Any) -> Any:
        return (predicted_time(lab, **at.valuesdict()) - lab["time"]) / lab["time_u"]

    solution = minimize(deviations, parameters)
    fitted = solution.params["inertia"]
    return interval(fitted.value, fitted.stderr, solution.nfree)


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


def kafe2(lab: Lab) -> Answer:
    """Fit a line with all covariances of both variables."""
    import kafe2 as package

    def line(x: Any, inertia: float = 1.0, residual: float = 0.0) -> Any:
        return inertia * x + residual

    fit = package.XYFit([product(lab), lab["torque"]], line)
    # It takes the first step of a parameter from its first value.
    inertia, _ = start(lab)
    fit.set_parameter_values(inertia=inertia, residual=0.01 * min(lab["torque"]))
    fit.add_matrix_error("x", lab["product_cov"], "cov")
    fit.add_matrix_error("y", lab["torque_cov"], "cov")
    fit.do_fit()
    return interval(fit.parameter_values[0], fit.parameter_errors[0])


LINE = "line with intercept"

PROGRAMS: Mapping[str, Callable[[Lab], Answer]] = {
    "mean of ratios": mean_of_ratios,
    LINE: line_with_intercept,
    "scipy curve_fit": curve_fit,
    "lmfit": lmfit,
    "odrpack": odrpack,
    "iminuit": iminuit,
    "kafe2": kafe2,
}
"""The fit of each program, by its name in the charts."""

OPTIONAL = "lmfit", "odrpack", "iminuit", "kafe2"
"""Packages that need not be installed."""


def installed() -> dict[str, Callable[[Lab], Answer]]:
    """Return the fits of the programs that are installed, by name."""
    return {
        name: fit
        for name, fit in PROGRAMS.items()
        if name not in OPTIONAL or find_spec(name)
    }


if __name__ == "__main__":
    print(*PROGRAMS[sys.argv[1]](pickle.load(sys.stdin.buffer)))
