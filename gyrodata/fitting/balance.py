"""What a balance test in a log is worth: a test may be false, and nobody knows how often.

Before the runs are looked at it is true with some chance, or M0 is some ten, thirty or more times larger than it
says. Each of these is weighed by how well it goes with what the runs alone say of M0 (Bayes). The answer leans on the
test more than its uncertainty does, which has to hold where the test is false: an interval that every true test
makes much shorter does not cover where the runs cannot tell a false one from a true one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gyrodata.physics import Floats

TRUSTED, DOUBTED = 0.8, 0.2
"""How likely a test is true before the runs are looked at [1]: for the answer, and for its uncertainty."""

FALSE = ((10.0, 3.0, 0.2), (-10.0, 3.0, 0.2), (30.0, 10.0, 0.2), (-30.0, 10.0, 0.2), (0.0, 60.0, 0.2))
"""Where M0 is if it is not: about so many widths of the test [1], give or take so many [1], with this chance [1]."""

FARTHEST = max(width for _, width, _ in FALSE)
"""Twice so many widths of the test away [1] it is nowhere among these."""

CONTRADICTED = 1 / 3
"""Where true is this many times as likely as false, or less, the runs contradict the test."""


@dataclass(frozen=True, slots=True)
class Weighed:
    """An answer with a balance test that may be false."""

    mean: Floats
    """I_zz [kg*m^2], M0 [N*m], …, shape (k,)."""
    covariance: Floats
    """Of these, shape (k, k)."""
    odds: float
    """How many times likelier what the runs say is if the test is true [1]."""

    @property
    def contradicted(self) -> bool:
        """Whether the runs contradict the test."""
        return self.odds < CONTRADICTED

    @property
    def sure(self) -> bool:
        """Whether the runs leave no doubt that the test is true."""
        return DOUBTED * self.odds > 999 * (1 - DOUBTED)


def weigh(mean: Floats, covariance: Floats, tested: float) -> Weighed:
    """Put together what the runs alone say and what a balance test says.

    Parameters
    ----------
    mean : ndarray, shape (k,)
        Unknowns by the runs alone: I_zz [kg*m^2], M0 [N*m], …
    covariance : ndarray, shape (k, k)
        Theirs.
    tested : float
        Standard uncertainty to which the test tells M0 [N*m].

    Returns
    -------
    Weighed
    """
    if abs(mean[1]) > 2 * math.hypot(math.sqrt(covariance[1, 1]), FARTHEST * tested):
        return Weighed(mean, covariance, 0.0)
    centres = tested * np.array([0.0, *(centre for centre, _, _ in FALSE)])
    widths = tested * np.array([1.0, *(width for _, width, _ in FALSE)])
    chances = np.array([chance for _, _, chance in FALSE])
    # M0 is normal about each centre; all else follows it as its covariance says.
    variances = covariance[1, 1] + widths**2
    gain = covariance[:, 1] / variances[:, None]
    means = mean + gain * (centres - mean[1])[:, None]
    likelihood = np.exp(-0.5 * (mean[1] - centres) ** 2 / variances) / np.sqrt(variances)
    false = likelihood[1:] * chances
    odds = float(likelihood[0] / max(false.sum(), 1e-300 * likelihood[0]))

    def shares(trust: float) -> Floats:
        share = np.concatenate([[trust * likelihood[0]], (1 - trust) * false])
        share /= share.sum()
        return share

    answer = shares(TRUSTED) @ means
    share, off = shares(DOUBTED), means - answer
    spread = covariance - np.einsum("i,i,ij,ik->jk", share, variances, gain, gain)
    spread += np.einsum("i,ij,ik->jk", share, off, off)
    if odds < 1:
        # A test that the runs speak against makes nothing surer.
        alone, now = np.diag(covariance), np.diag(spread)
        widen = np.sqrt(np.divide(alone, now, out=np.ones_like(now), where=now < alone))
        spread *= widen[:, None] * widen
    return Weighed(answer, spread, odds)
