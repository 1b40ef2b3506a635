"""Models of the motion: cost against error of I_zz, each with what a user can know.

A lab has nine runs of one turn, three weights at three spins. The hand pushes the rod
with a part of the rate of steady precession, each rod is up to 2 degrees off its tilt,
and the air film slows the spin by a time constant that nobody knows better than within
a factor of 2; so no model is exact. A user reads the spin once, at the midpoint of the
run, and the pitch to 1 degree. The other errors of readings are u of the lab.

Each model predicts the azimuth that the rod sweeps in the time of the turn. To first
order, its ratio to the true azimuth is the ratio of I_zz with this model to the true
I_zz. The runs have the weights of the recommended fit.
"""

from __future__ import annotations

import math
import time
import timeit
from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata import fitting, physics
from gyrodata.judging import changes
from gyrodata.physics import RPM, Floats, models, motion
from gyrodata.quantities.error_sources import DECAY_SPREAD, DECAY_TIME
from gyrodata.trials.benchmark.fits import cheapest
from gyrodata.trials.benchmark.labs import LabScene, measured_lab
from gyrodata.trials.simulation import TYPICAL, Design, Runs, Truth, happen, simulate
from gyrodata.trials.simulation.truth import top_of

if TYPE_CHECKING:
    import pandas as pd

OFF_TILT = math.radians(2)
PITCH_U = math.radians(1)
"""Largest difference of a rod from its tilt, and standard uncertainty with which a
student reads its pitch [rad]."""

TOLERANCE = 1e-3
"""Relative tolerance of the full motion."""

REPEATS = 5
"""Number of times that a model is timed."""

CLOSER = 1e-6
"""Relative tolerance of the true motion."""

FULL = "full motion"
KNOWN = "full motion, if push and drag were known"


def at_rpm(*rpm: float, degrees: float = 0.0) -> Design:
    """Return the usual weights at some spins, and at a pitch."""
    spins = RPM * np.array(rpm)
    return Design(spins=tuple(spins), pitches=(math.radians(degrees),))


SCENES = (
    LabScene("as the sheet asks"),
    LabScene("rod 30° up", at_rpm(100, 200, 300, degrees=30.0), push=(0.7, 1.0)),
    LabScene("no push", at_rpm(100, 150, 250), push=(0.0, 0.0)),
    LabScene("slow spins", at_rpm(60, 100, 150)),
)


class Rods(Struct, frozen=True):
    """What is known of n runs of about one turn; arrays of shape (n,)."""

    top: motion.Top
    spin: Floats
    """At the midpoint [rad/s]."""
    pitch: Floats
    """[rad]"""
    time: Floats
    """Duration of each run [s]."""
    push: Floats | float
    """Over the rate of steady precession [1]."""
    decay: Floats | float
    """Time constant of the spin [s]."""


def rods_of(
    truth: Truth, runs: Runs, push: Floats | float, decay: Floats | float = math.inf
) -> Rods:
    """Return the rods of simulated runs."""
    return Rods(top_of(truth, runs), runs.spin, runs.pitch, runs.time, push, decay)


def draw_labs(scene: LabScene, runs: Runs, count: int, seed: int) -> tuple[Rods, Rods]:
    """Simulate labs with the loads and spins of some runs, each for one turn.

    Runs without a weight are left out, because they take hours for a turn.

    Return the truth, and what users know and assume.
    """
    random = np.random.default_rng(seed)
    columns = np.array([runs.mass, np.abs(runs.position), runs.pitch, runs.spin])
    loaded = columns[:, runs.mass > 0]
    mass, position, pitch, spin = np.tile(loaded, count)
    # The phase of the nutation at the end of a run is random.
    spin = spin * random.uniform(0.95, 1.05, spin.shape)
    pitch = pitch + random.uniform(-OFF_TILT, OFF_TILT, spin.shape)
    pushes = random.uniform(*scene.push, spin.shape)
    decay = DECAY_TIME * np.exp(DECAY_SPREAD * random.standard_normal(count))
    settings = np.array([mass, position, pitch, spin, np.ones(len(spin))]).T
    truth = Truth(scene.truth.inertia)
    turns = happen(truth, Design(runs=settings.tolist()))
    rods = rods_of(truth, turns, pushes, np.repeat(decay, loaded.shape[1]))
    read = pitch + PITCH_U * random.standard_normal(spin.shape)
    # A log says if nobody pushed; the size of a push is unknown.
    push = models.PART_RELEASED if any(scene.push) else 0.0
    return rods, replace(rods, pitch=read, push=push, decay=DECAY_TIME)


# --- the models: the azimuth that a rod sweeps in its time [rad], shape (n,) ---


def level(rods: Rods) -> Any:
    """Use eq. (9), which does not know the pitch."""
    return rods.time * rods.top.torque / (rods.top.inertia * rods.spin)


def tilted(rods: Rods) -> Any:
    """Use eq. (8)."""
    top = rods.top
    return rods.time * physics.precession_rate(
        top.torque, rods.spin, top.inertia, top.transverse_inertia, rods.pitch
    )


def release(rods: Rods, part: float = 1.0) -> Any:
    """Use a part of the effect of a release from rest on the mean rate."""
    steady = tilted(rods)
    mean = rods.time * motion.mean_precession_rate(rods.top, rods.spin, rods.pitch)
    return steady / (1 + part * (steady / mean - 1))


def full_motion(rods: Rods, tolerance: float = TOLERANCE) -> Any:
    """Integrate eqs. (7) as vectors, with push and drag."""
    from scipy.integrate import solve_ivp

    first = rods.spin * np.exp(rods.time / rods.decay / 2)
    start = motion.released(rods.top, first, rods.pitch)
    rows = np.concatenate([start.axis.T, start.momentum.T])
    # A rod without a push need not be able to precess steadily.
    if np.any(rods.push):
        steady = motion.steady(rods.top, first, rods.pitch)
        rows[3:] += np.multiply(rods.push, (steady.momentum - start.momentum).T)
    # All rods together, each in parts of its own time.
    drag = rods.top.inertia / rods.decay
    rates = motion.vector_rates(rods.top, drag, rods.time)
    done = solve_ivp(
        lambda _, row: np.ravel(rates(row.reshape(rows.shape))),
        (0, 1),
        rows.ravel(),
        "DOP853",
        rtol=tolerance,
        atol=1e-3 * tolerance,
    )
    x, y, *_ = done.y[:, -1].reshape(rows.shape)
    # Add whole turns: the azimuth is near one turn.
    return np.pi + np.mod(np.arctan2(y, x) - np.pi, 2 * np.pi)


MODELS: Mapping[str, Callable[[Rods], Any]] = {
    "eq. (9)": level,
    "eq. (8)": tilted,
    "released from rest": release,
    "half of a release": partial(release, part=models.PART_RELEASED),
    FULL: full_motion,
    KNOWN: full_motion,
}


# --- the comparison ---


def compare(scene: LabScene, labs: int, seed: int) -> list[dict[str, Any]]:
    """Measure every model in one kind of lab.

    The error of a row is the median of |error of I_zz| over the labs, over u, and
    "error_low" and "error_high" are its quartiles. The cost is that of one lab.
    """
    noise = {**TYPICAL, **scene.noise}
    lab = simulate(scene.truth, scene.design, noise, seed=None)
    is_tilted = bool(lab.runs.pitch.any())
    fit = fitting.fit(measured_lab(lab.log), fitting.AS_STATED, tilted=is_tilted)
    u = fitting.relative_u(fit.inertia)
    response = fit.response[lab.runs.mass > 0]
    rpm = lab.runs.spin / RPM
    true, known = draw_labs(scene, lab.runs, labs, seed)
    _, timed = draw_labs(scene, lab.runs, 1, seed)
    azimuth = full_motion(true, CLOSER)
    rows = []
    for method, model in MODELS.items():
        predicted = model(true if method == KNOWN else known)
        # Other work only makes a call longer.
        timer = timeit.Timer(partial(model, timed), timer=time.process_time)
        seconds = min(timer.repeat(REPEATS, number=1))
        errors = (predicted / azimuth - 1).reshape(labs, -1) @ response
        low, middle, high = np.quantile(np.abs(errors) / u, [0.25, 0.5, 0.75]).tolist()
        rows.append(
            {
                "scene": f"{scene.title}, {rpm.min():.0f} to {rpm.max():.0f} rpm",
                "method": method,
                "labs": labs,
                "seconds": seconds,
                "error": middle,
                "error_low": low,
                "error_high": high,
            }
        )
    return rows


def title(points: pd.DataFrame) -> str:
    """Name the cheapest model with a harmless error in each kind of lab.

    The error is harmless in three of four labs. A model that knows what no user knows
    does not count.
    """
    is_harmless = points["error_high"] < changes.DROP_ALL
    is_usable = points["method"] != KNOWN
    head = (
        "The cheapest model whose error is harmless in 3 of 4 labs (bar below the line)"
    )
    return "\n".join([head, *cheapest(points, is_harmless & is_usable)])
