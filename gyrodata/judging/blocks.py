"""The days or groups of one lab: each alone, and whether they agree.

Both are fits of a changed log: of the runs of one block, and of all runs with one I_zz
for each block.
"""

from __future__ import annotations

import math
from contextlib import suppress

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata import fitting
from gyrodata.fitting import Estimate, FitResult
from gyrodata.judging.changes import Lab
from gyrodata.measurements import DAY_BALANCE, contrast_sources, select
from gyrodata.physics import Floats

DAY_INERTIA = "day_inertia"
"""Name of the difference of I_zz between blocks, which their comparison supposes."""

NOT_DETERMINED = "the runs of this block do not determine I_zz alone"

DISAGREE = 0.01
"""Blocks disagree if their differences are less probable than this."""


class Block(Struct, frozen=True):
    """The runs of one day or group."""

    name: str
    """As written in the column, or the name of the file."""
    runs: int
    """Number of its runs in the fit."""
    inertia: Estimate | None
    """I_zz from these runs alone [kg*m^2]; null if they do not determine it."""
    inertia_reason: str | None
    """Why it is null."""
    residual_torque: Estimate
    """M0 of this block in the fit of all runs [N*m]."""


class BlockAgreement(Struct, frozen=True):
    """Whether one I_zz is right for all blocks."""

    chi2: float
    """χ² of the differences of I_zz between the blocks; errors that blocks share do not
    count."""
    dof: int
    """Number of the blocks with a weight, minus one."""
    p: float
    """Probability of a χ² at least as large if I_zz is the same in all blocks."""


def list_blocks(lab: Lab) -> tuple[Block, ...]:
    """List the blocks of a log in their order; none if it has only one."""
    measured = lab.measured
    if measured.one_block:
        return ()
    covariance = _covariance(lab.fit)
    blocks = []
    for number, name in enumerate(measured.block_names):
        runs = np.flatnonzero(measured.day == number).tolist()
        left_out = [place for place, run in enumerate(runs) if run in lab.left_out]
        alone = _fit_alone(lab, runs, left_out)
        reason = None if alone else NOT_DETERMINED
        m0 = _residual_torque(lab.fit, covariance, runs[0])
        kept = len(runs) - len(left_out)
        blocks.append(Block(name, kept, alone, reason, m0))
    return tuple(blocks)


def _fit_alone(lab: Lab, runs: list[int], left_out: list[int]) -> Estimate | None:
    """Return I_zz from some of the runs; None if they do not determine it."""
    alone = select(lab.measured, runs)
    if len(runs) == len(left_out) or not np.delete(alone.torque, left_out).any():
        return None
    with suppress(fitting.NoFit):
        fit = fitting.fit(alone, tilted=lab.motion.tilted, left_out=left_out)
        low, _ = fit.inertia.interval_95 or (0.0, 0.0)
        return fit.inertia if low > 0 else None
    return None


def _residual_torque(fit: FitResult, covariance: Floats, run: int) -> Estimate:
    """Return M0 of the block of a run."""
    adjusted = fit.adjusted
    problem = adjusted.problem
    # How M0 of this block changes with the unknowns and with the shared errors.
    share = np.zeros(adjusted.rows.shape[1])
    share[1] = adjusted.scale[1]
    of_balance = problem.owned_by(DAY_BALANCE)
    share[3:][of_balance] = -problem.absolute[problem.owners[of_balance], run]
    u = math.sqrt(share @ covariance @ share)
    mean = fit.residual_torque
    # The mean has the tails of the prior, which are not in the covariance.
    wider = (mean.u or 0.0) / math.sqrt(fit.covariance[1, 1])
    return Estimate(float(fit.balances[run]), u * wider, mean.unit)


def _covariance(fit: FitResult) -> Floats:
    """Return the covariance of the unknowns and of the shared errors, as scaled."""
    rows = fit.adjusted.rows
    prior = np.eye(rows.shape[1])
    # I_zz has no prior.
    prior[0, 0] = 0.0
    return np.asarray(np.linalg.inv(rows.T @ rows + prior))


def compare_blocks(lab: Lab) -> BlockAgreement | None:
    """Test whether the blocks have one I_zz; None if they cannot be compared."""
    measured = lab.measured
    is_loaded = measured.torque != 0
    is_loaded[list(lab.left_out)] = False
    compared = sorted({*measured.day[is_loaded].tolist()})
    if len(compared) < 2:
        return None
    # A block without a weight does not determine I_zz: it has the one of another block.
    is_compared = np.isin(measured.day, compared)
    block = np.where(is_compared, measured.day, compared[0])
    # I_zz of each block may differ by any amount.
    own = contrast_sources(DAY_INERTIA, "added", block, lab.fit.inertia.value)
    changed = replace(measured, sources=(*measured.sources, *own))
    with suppress(fitting.NoFit):
        fit = fitting.fit(changed, tilted=lab.motion.tilted, left_out=lab.left_out)
        return _agreement(fit)
    return None


def _agreement(fit: FitResult) -> BlockAgreement:
    """Test whether the differences of I_zz between blocks are zero."""
    of_inertia = fit.adjusted.problem.owned_by(DAY_INERTIA)
    differences = fit.adjusted.shared[of_inertia]
    covariance = _covariance(fit)[3:, 3:][np.ix_(of_inertia, of_inertia)]
    # As for I_zz, the widths of the errors are not certain.
    wider = (fit.inertia.u or 0.0) ** 2 / fit.covariance[0, 0]
    chi2 = float(differences @ np.linalg.solve(wider * covariance, differences))
    dof = len(differences)
    return BlockAgreement(chi2, dof, fitting.chi2_tail(chi2, dof))
