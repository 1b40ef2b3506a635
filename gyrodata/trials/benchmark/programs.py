"""Fits of one lab by other programs, each called as its manual shows.

A lab is a mapping of lists of n numbers, in SI: ``time``, ``spin``, ``turns``,
``torque``, ``time_u`` (standard uncertainty of each time), and the covariances
``product_cov`` of φ̇ψ̇ and ``torque_cov`` of the torque, of n rows. A fit returns I_zz
and the ends of its 95 % interval [kg*m^2].

``python programs.py NAME`` reads a lab as JSON from standard input. It imports nothing
of gyrodata, so that the cost of a whole process is that of the program.
"""

from __future__ import annotations

import json
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
    turns, time, spin = (np.array(lab[key]) for key in ("turns", "time", "spin"))
    return 2 * np.pi * turns / time * spin


def predicted_time(lab: Lab) -> Callable[..., Any]:
    """Return eq. (9) as the time of each run [s], a function of I_zz and M0."""
    angle = 2 * np.pi * np.array(lab["turns"]) * np.array(lab["spin"])
    torque = np.array(lab["torque"])
    return lambda inertia, residual: angle * inertia / (torque + residual)


def start(lab: Lab) -> float:
    """Return a first value of I_zz [kg*m^2]."""
    return float(np.median(np.array(lab["torque"]) / product(lab)))


def interval(value: float, u: float, free: int | None = None) -> Answer:
    """Return the 95 % interval of a value; Student's factor for u from the scatter."""
    factor = NORMAL_95
    if free is not None:
        from scipy.special import stdtrit

        factor = float(stdtrit(free, 0.975))
    return float(value), float(value - factor * u), float(value + factor * u)


def mean_of_ratios(lab: Lab) -> Answer:
    """Average M/(φ̇ψ̇)."""
    ratios = np.array(lab["torque"]) / product(lab)
    count = len(ratios)
    return interval(ratios.mean(), ratios.std(ddof=1) / count**0.5, count - 1)


def line_with_intercept(lab: Lab) -> Answer:
    """Fit M to φ̇ψ̇ by a straight line."""
    (slope, _), covariance = np.polyfit(product(lab), lab["torque"], 1, cov=True)
    return interval(slope, covariance[0, 0] ** 0.5, len(lab["torque"]) - 2)


def curve_fit(lab: Lab) -> Answer:
    """Fit the times with their stated u."""
    from scipy.optimize import curve_fit as fit

    model = predicted_time(lab)
    (value, _), covariance = fit(
        lambda _, inertia, residual: model(inertia, residual),
        lab["torque"],
        lab["time"],
        p0=[start(lab), 0.0],
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
        np.array(lab["torque"]),
        np.array([start(lab), 0.0]),
        weight_x=1 / np.diag(lab["product_cov"]),
        weight_y=1 / np.diag(lab["torque_cov"]),
    )
    return interval(solution.beta[0], solution.sd_beta[0], len(lab["torque"]) - 2)


def lmfit(lab: Lab) -> Answer:
    """Fit the times with u, scaled by the scatter, as is the default."""
    from lmfit import Parameters, minimize

    model = predicted_time(lab)
    parameters = Parameters()
    parameters.add("inertia", value=start(lab))
    parameters.add("residual", value=0.0)
    observed = np.array(lab["time"])
    u = np.array(lab["time_u"])
    solution = minimize(
        lambda at: (model(at["inertia"].value, at["residual"].value) - observed) / u,
        parameters,
    )
    inertia = solution.params["inertia"]
    return interval(inertia.value, inertia.stderr, solution.nfree)


def iminuit(lab: Lab) -> Answer:
    """Minimise chi-square of the times with all covariances, and use MINOS."""
    from iminuit import Minuit

    model = predicted_time(lab)
    observed = np.array(lab["time"])
    # Relative errors of φ̇ψ̇ and of M are relative errors of the time.
    relative = np.array(lab["product_cov"]) / np.outer(product(lab), product(lab))
    relative += np.array(lab["torque_cov"]) / np.outer(lab["torque"], lab["torque"])
    inverse = np.linalg.inv(relative * np.outer(observed, observed))

    def chi_square(inertia: float, residual: float) -> float:
        off = observed - model(inertia, residual)
        return float(off @ inverse @ off)

    minuit = Minuit(chi_square, inertia=start(lab), residual=0.0)
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
    fit.set_parameter_values(inertia=start(lab), residual=0.01 * min(lab["torque"]))
    fit.add_matrix_error("x", np.array(lab["product_cov"]), "cov")
    fit.add_matrix_error("y", np.array(lab["torque_cov"]), "cov")
    fit.do_fit()
    return interval(fit.parameter_values[0], fit.parameter_errors[0])


PROGRAMS: Mapping[str, tuple[str, Callable[[Lab], Answer]]] = {
    "mean of ratios": ("numpy", mean_of_ratios),
    "line with intercept": ("numpy", line_with_intercept),
    "scipy curve_fit": ("scipy", curve_fit),
    "lmfit": ("lmfit", lmfit),
    "odrpack": ("odrpack", odrpack),
    "iminuit": ("iminuit", iminuit),
    "kafe2": ("kafe2", kafe2),
}
"""The package and the fit of each program, by its name in the charts."""


def installed() -> dict[str, Callable[[Lab], Answer]]:
    """Return the fits of the programs that are installed, by name."""
    return {
        name: fit for name, (package, fit) in PROGRAMS.items() if find_spec(package)
    }


if __name__ == "__main__":
    print(*installed()[sys.argv[1]](json.load(sys.stdin)))
