"""What each figure shows, in words, for who cannot see it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gyrodata.plotting.scene import Scene, as_number, gather, mean_text, run_name, torque_unit, with_u
from gyrodata.results import Analysis


def alt_text(analysis: Analysis, name: str) -> str:
    """Say what a figure shows, for who cannot see it.

    Parameters
    ----------
    analysis : Analysis
        What `analyze` gives.
    name : str
        One of `FIGURES`.

    Returns
    -------
    str
        What is seen first, then the figure's main numbers with their units; plain text.
    """
    scene = gather(analysis)
    words = {"period": _period_words, "product": _product_words, "torque": _torque_words, "residuals": _residual_words}
    odd = [run_name(scene.names[i]) + ", left out" * bool(scene.left_out[i]) for i in np.flatnonzero(scene.hollow)]
    hollow = f" Drawn hollow: {_listed(odd)}." if odd else ""
    return words[name](analysis, scene) + hollow


def _listed(items: Sequence[str], most: int = 4) -> str:
    return "; ".join(items[:most]) + (f"; and {len(items) - most} more" if len(items) > most else "")


def _period_words(analysis: Analysis, scene: Scene) -> str:
    told = []
    for group in scene.groups:
        members = sorted((i for i in group.members if not scene.hollow[i]), key=lambda i: scene.spin[i])
        if not members:
            continue
        first, last = members[0], members[-1]
        at = f"{group.label}: {as_number(scene.period[first])} s at {as_number(scene.spin[first])} rpm"
        to = f" to {as_number(scene.period[last])} s at {as_number(scene.spin[last])} rpm"
        told.append(at + (to if last != first else ""))
    law = analysis.exponent
    grows = f", growing as the spin to the power {with_u(law.value, law.u)}" if law else ""
    return (
        f"Precession period against spin, {_count(len(scene.names), 'run')} at {_count(len(scene.groups), 'torque')}"
        f"{grows}; a line through zero for each torque, steeper for the smaller one. {_listed(told)}."
    )


def _product_words(analysis: Analysis, scene: Scene) -> str:
    told = [f"{group.label}: {mean_text(group)} rad²/s²" for group in scene.groups]
    same = analysis.constancy
    level = f"; the runs scatter by {100 * same.scatter:.2g} % about them" if same else ""
    return f"Precession rate times spin against spin: a level line for each torque{level}. {_listed(told)}."


def _torque_words(_: Analysis, scene: Scene) -> str:
    unit, factor = torque_unit(float(np.abs(scene.torque).max()))
    low, high = factor * float(scene.torque.min()), factor * float(scene.torque.max())
    reach = f"from {as_number(low)} to {as_number(high)}" if high > low else f"of {as_number(high)}"
    return (
        f"Torque {reach} {unit} against precession rate times spin: a straight line of slope I_zz = "
        f"{scene.inertia_text}, which crosses zero product at {as_number(-factor * scene.imbalance)} {unit}, with its "
        "95 % band; dashed, the line through the origin."
    )


def _residual_words(_: Analysis, scene: Scene) -> str:
    kept = np.abs(np.nan_to_num(scene.deviations[~scene.left_out]))
    return (
        f"Each run's time minus what the other runs predict: {int(np.sum(kept <= 2))} of {_count(len(kept), 'run')} in "
        f"the fit lie within ± 2 standard uncertainties, the farthest at {as_number(float(kept.max(initial=0.0)))}. "
        "In the order of the log."
    )


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" + ("" if number == 1 else "s")
