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

from gyrodata import fitting
from gyrodata.fitting import AS_STATED, relative_u
from gyrodata.judging.changes import DROP_ALL
from gyrodata.physics import RPM, Floats, motion, precession_rate
from gyrodata.physics.models import PART_RELEASED
from gyrodata.physics.motion import Top, mean_precession_rate, vector_rates
from gyrodata.quantities.error_sources import DECAY_SPREAD, DECAY_TIME
from gyrodata.trials.benchmark.fits import cheapest
from gyrodata.trials.benchmark.labs import LabScene, measured_lab
from gyrodata.trials.simulation import TYPICAL, Design, Runs, Truth, happen, simulate

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

    top: Top
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
    top = Top(truth.inertia, runs.transverse_inertia, runs.torque)
    return Rods(top, runs.spin, runs.pitch, runs.time, push, decay)


def draw_labs(scene: LabScene, runs: Runs, count: int, seed: int) -> tuple[Rods, Rods]:
    """Simulate labs with the loads and spins of some runs, each for one turn.

    Runs without a weight are left out, because they take hours for a turn.

    Return the truth, and what users know and assume.
    """
    random = np.random.default_rng(seed)
    distance = np.abs(runs.position)
    columns = np.array([runs.mass, distance, runs.pitch, runs.spin])
    loaded = columns[:, runs.mass > 0]
    mass, position, pitch, spin = np.tile(loaded, count)
    # The phase of the nutation at the end of a run is random.
    spin = spin * random.uniform(0.95, 1.05, spin.shape)
    pitch = pitch + random.uniform(-OFF_TILT, OFF_TILT, spin.shape)
    pushes = random.uniform(*scene.push, spin.shape)
    decay = DECAY_TIME * np.exp(DECAY_SPREAD * random.standard_normal(count))
    turns = np.ones(len(spin))
    settings = np.array([mass, position, pitch, spin, turns]).T
    truth = Truth(scene.truth.inertia)
    turned = happen(truth, Design(runs=settings.tolist()))
    decays = np.repeat(decay, loaded.shape[1])
    rods = rods_of(truth, turned, pushes, decays)
    read = pitch + PITCH_U * random.standard_normal(spin.shape)
    # A log says if nobody pushed; the size of a push is unknown.
    push = PART_RELEASED if any(scene.push) else 0.0
    return rods, replace(rods, pitch=read, push=push, decay=DECAY_TIME)


# --- the models: the azimuth that a rod sweeps in its time [rad], shape (n,) ---


def level(rods: Rods) -> Any:
    """Use eq. (9), which does not know the pitch."""
    top = rods.top
    return rods.time * top.torque / (top.inertia * rods.spin)


def tilted(rods: Rods) -> Any:
    """Use eq. (8)."""
    top = rods.top
    across = top.transverse_inertia
    rate = precession_rate(top.torque, rods.spin, top.inertia, across, rods.pitch)
    return rods.time * rate


def release(rods: Rods, part: float = 1.0) -> Any:
    """Use a part of the effect of a release from rest on the mean rate."""
    steady = tilted(rods)
    mean_rate = mean_precession_rate(rods.top, rods.spin, rods.pitch)
    released = rods.time * mean_rate
    effect = steady / released - 1
    return steady / (1 + part * effect)


def full_motion(rods: Rods, tolerance: float = TOLERANCE) -> Any:
    """Integrate eqs. (7) as vectors, with push and drag."""
    from scipy.integrate import solve_ivp

    top = rods.top
    rise = np.exp(rods.time / rods.decay / 2)
    first = rods.spin * rise
    start = motion.released(top, first, rods.pitch)
    rows = np.concatenate([start.axis.T, start.momentum.T])
    # A rod without a push need not be able to precess steadily.
    if np.any(rods.push):
        steady = motion.steady(top, first, rods.pitch)
        of_precession = steady.momentum - start.momentum
        rows[3:] += np.multiply(rods.push, of_precession.T)
    # All rods together, each in parts of its own time.
    drag = top.inertia / rods.decay
    rates = vector_rates(top, drag, rods.time)
    solution = solve_ivp(
        lambda _, row: np.ravel(rates(*row.reshape(rows.shape))),
        (0, 1),
        rows.ravel(),
        "DOP853",
        rtol=tolerance,
        atol=1e-3 * tolerance,
    )
    end = solution.y[:, -1]
    x, y, *_ = end.reshape(rows.shape)
    # Add whole turns: the azimuth is near one turn.
    bearing = np.arctan2(y, x)
    return np.pi + np.mod(bearing - np.pi, 2 * np.pi)


MODELS: Mapping[str, Callable[[Rods], Any]] = {
    "eq. (9)": level,
    "eq. (8)": tilted,
    "released from rest": release,
    "half of a release": partial(release, part=PART_RELEASED),
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
    runs = lab.runs
    is_tilted = bool(runs.pitch.any())
    fit = fitting.fit(measured_lab(lab.log), AS_STATED, tilted=is_tilted)
    u = relative_u(fit.inertia)
    response = fit.response[runs.mass > 0]
    rpm = runs.spin / RPM
    true, known = draw_labs(scene, runs, labs, seed)
    _, timed = draw_labs(scene, runs, 1, seed)
    azimuth = full_motion(true, CLOSER)
    rows = []
    for method, model in MODELS.items():
        predicted = model(true if method == KNOWN else known)
        # Other work only makes a call longer.
        timer = timeit.Timer(partial(model, timed), timer=time.process_time)
        seconds = min(timer.repeat(REPEATS, number=1))
        ratios = predicted / azimuth
        errors = (ratios - 1).reshape(labs, -1) @ response
        relative = errors / u
        sizes = np.abs(relative)
        low, middle, high = np.quantile(sizes, [0.25, 0.5, 0.75]).tolist()
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
    is_harmless = points["error_high"] < DROP_ALL
    is_usable = points["method"] != KNOWN
    head = (
        "The cheapest model whose error is harmless in 3 of 4 labs (bar below the line)"
    )
    return "\n".join([head, *cheapest(points, is_harmless & is_usable)])
