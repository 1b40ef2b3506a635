"""Logs without any slip, of any length and order, whose truth is known: the answer
holds it, or there is none.
"""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
from simulated_labs import analyze_briefly

from gyrodata.base.errors import LogError

RPM = math.pi / 30
INERTIA = 4.44e-3
G = 9.803


def draw_clean(seed: int, most: int = 3000) -> str:
    """Draw a log of 3 to `most` runs, its weights in any order, every error as the
    defaults say.
    """
    random = np.random.default_rng(seed)
    runs, kinds = (
        int(np.exp(random.uniform(math.log(3), math.log(most)))),
        int(random.integers(2, 8)),
    )
    masses = np.linspace(20, 20 + 20 * random.uniform(0.5, 1.5) * (kinds - 1), kinds)
    orders = (
        np.arange(runs) % kinds,
        np.arange(runs) * kinds // runs,
        random.integers(0, kinds, runs),
        np.arange(runs) // int(random.integers(1, 12)) % kinds,
    )
    which = orders[random.integers(4)]
    # One torque alone tells M0 from I_zz by what is assumed of it.
    which[:2] = 0, kinds - 1
    # Errors that runs share, none so far out that one log in ten thousand is off by 5 u
    # by chance.
    shared = np.clip(random.standard_normal(kinds + 3), -3.5, 3.5)
    true_mass, arm = masses * (1 + 0.002 * shared[3:]), 150 + 0.5 * shared[0]
    bias, tachometer = 0.05 * shared[1], 1 + 0.001 * shared[2]
    side = random.choice((-1, 1), runs) if random.random() < 0.2 else np.ones(runs)
    spins = (
        random.choice((200.0, 400.0, 600.0), runs)
        if random.random() < 0.3
        else random.uniform(180, 620, runs)
    )
    counts = np.array(["1/3", "2/3", "1"])[
        random.integers(0, 3, runs if random.random() < 0.5 else 1)
    ]
    counts = np.broadcast_to(counts, runs)
    turns = np.array([float(Fraction(str(count))) for count in counts])
    # The arm's error turns its sign with the weight: one ruler, one zero.
    position = np.where(side > 0, arm, -300 + arm) * 1e-3
    torque = true_mass[which] * 1e-3 * G * position + random.choice(
        (0.0, 0.5e-3, -2e-3)
    )
    time = (
        2 * np.pi * turns * INERTIA * spins * RPM / np.abs(torque)
        + bias
        + 0.14 * random.standard_normal(runs)
    )
    read = spins * tachometer * (1 + 0.002 * random.standard_normal(runs))
    rows = zip(masses[which], 15 * side, read, time, counts, strict=True)
    lines = [f"{m:.2f},{x:.2f},{s:.2f},{t:.2f},{count}" for m, x, s, t, count in rows]
    return (
        f"# g: {G} m/s^2\nmass [g],position [cm],spin [rpm],time [s],turns\n"
        + "\n".join(lines)
        + "\n"
    )


def try_clean(seed: int, most: int = 3000) -> str:
    """Analyse one; the answer has to hold the truth within 5 u, or to be refused in
    words.
    """
    text = draw_clean(seed, most)
    try:
        lab = analyze_briefly(text.encode())
    except LogError as error:
        return f"refused {error.diagnostics[-1].code}"
    assert lab.inertia.u is not None
    off = (lab.inertia.value - INERTIA) / lab.inertia.u
    assert abs(off) < 5, (
        f"{len(lab.run_table)} runs: {lab.inertia.value:.4g} ± {lab.inertia.u:.2g}, {off:.1f} u off"
    )
    return "answered"
