"""What the answer hangs on: I_zz as it would be if one thing were otherwise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from gyrodata import fitting
from gyrodata.comparisons.runs import load_words
from gyrodata.comparisons.torques import Torque
from gyrodata.fitting import Estimate, FitResult, Otherwise
from gyrodata.measurements import Measurements, torque_groups

LATE = 0.1
"""So late or early the hand is taken to be [s]."""

CASES = (
    ("u_time_twice", "times twice as uncertain", Otherwise(times=2.0)),
    ("hand_late", f"times {LATE:g} s too long", Otherwise(bias=LATE)),
    ("hand_early", f"times {LATE:g} s too short", Otherwise(bias=-LATE)),
    # A Cauchy so narrow is none, and one as wide as the torque leaves M0 to the runs.
    ("balanced", "M0 = 0, balanced", Otherwise(balance=1e-6)),
    ("balance_free", "M0 from the runs alone", Otherwise(balance=1.0)),
)
"""Name, words and what is otherwise."""


@dataclass(frozen=True, slots=True)
class Sensitivity:
    """I_zz if one thing were otherwise."""

    name: str
    """"u_time_twice", "hand_late", "hand_early", "balanced", "balance_free" or "without"."""
    words: str
    """What is otherwise: "without 20 g at 15 cm"."""
    inertia: Estimate | None
    """[kg*m^2]; None where the runs then have no answer: an interval that would hold zero."""
    deviation: float | None
    """Its distance from I_zz in standard uncertainties of that."""


def list_sensitivity(
    measured: Measurements, fit: FitResult, torques: Sequence[Torque], kept: Sequence[int]
) -> tuple[Sensitivity, ...]:
    """Work out what the answer hangs on: the hand, the balance, and each weight."""
    asked = {
        "hand_late": bool(fit.timing_bias.u),
        "hand_early": bool(fit.timing_bias.u),
        "u_time_twice": measured.timed,
    }
    cases = [one for one in CASES if asked.get(one[0], True)]
    told = fitting.fit_otherwise(measured, fit, [case for _, _, case in cases])
    rows = [_row(name, words, fit, inertia) for (name, words, _), inertia in zip(cases, told, strict=True)]
    if len(torques) > 1:
        groups = torque_groups(measured)
        rows += [
            _row("without", f"without {_load(measured, group)}", fit, torque.without)
            for group, torque in zip(groups, torques, strict=True)
            if torque.without is not None and set(group) & set(kept)
        ]
    return tuple(rows)


def _load(measured: Measurements, group: Sequence[int]) -> str:
    return load_words(measured, group[0]) if measured.torque[group[0]] else "the unloaded runs"


def _row(name: str, words: str, fit: FitResult, inertia: Estimate | None) -> Sensitivity:
    if inertia is None or not (inertia.interval_95 or (inertia.value - 2 * (inertia.u or 0.0), 0.0))[0] > 0:
        return Sensitivity(name, words, None, None)
    answer = fit.inertia
    return Sensitivity(name, words, inertia, (inertia.value - answer.value) / answer.u if answer.u else None)
