"""The tail of the chi-square distribution, without scipy."""

from __future__ import annotations

import math


def chi2_tail(chi2: float, dof: int) -> float:
    """Probability of a chi-square at least this large.

    Parameters
    ----------
    chi2 : float
        Sum of squares, ≥ 0.
    dof : int
        Degrees of freedom, ≥ 1.

    Returns
    -------
    float
        Q(dof/2, chi2/2), the regularised upper incomplete gamma function (DLMF 8.2.4).

    Notes
    -----
    For a whole or half argument it is a finite sum (DLMF 8.4.10 and 8.8.2), so twenty lines save the quarter
    of a second that importing scipy for it would cost at every start.
    """
    half = chi2 / 2
    if half <= 0:
        return 1.0
    odd = dof % 2
    total = math.erfc(math.sqrt(half)) if odd else 0.0
    # Q(a + 1, x) = Q(a, x) + x^a e^-x / Γ(a + 1), in logarithms because e^-x alone underflows.
    for step in range((dof - odd) // 2):
        order = step + odd / 2
        total += math.exp(order * math.log(half) - half - math.lgamma(order + 1))
    return min(total, 1.0)
