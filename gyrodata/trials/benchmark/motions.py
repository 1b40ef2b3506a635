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
from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata import fitting, physics
from gyrodata.judging import changes
from gyrodata.measurements import DEFAULT_TRANSVERSE_RATIO
from gyrodata.physics import RPM, Floats, models, motion
from gyrodata.quantities.error_sources import DECAY_SPREAD, DECAY_TIME
from gyrodata.trials.benchmark.labs import measured_lab
from gyrodata.trials.simulation import TYPICAL, Design, Truth, simulate

if TYPE_CHECKING:
    import pandas as pd

MASSES = (0.020, 0.040, 0.060)
POSITION = 0.15
"""[kg], [m]"""

OFF_TILT = math.radians(2)
PITCH_U = math.radians(1)
"""Largest difference of a rod from its tilt, and standard uncertainty with which a
student reads its pitch [rad]."""

CLOSER = 1e-3
"""Relative tolerance of the true motion, over the smallest of the others."""

REPEATS = 5
"""Number of times that a duration is measured."""

FULL = "full motion"
KNOWN = "full motion, if push and drag were known"

LONG = 0.1
"""Time after which a measurement is not repeated [s]."""


class MotionScene(Struct, frozen=True):
    """A kind of lab."""

    title: str
    rpm: tuple[int, int, int]
    """Spins [rpm]."""
    tilt: float = 0.0
    """Mean pitch [degrees]."""
    push: tuple[float, float] = (0.0, 1.0)
    """Smallest and largest push of the hand, over the rate of steady precession [1]."""

    @property
    def heading(self) -> str:
        """The title with the range of spins."""
        return f"{self.title}, {self.rpm[0]} to {self.rpm[-1]} rpm"


SCENES = (
    MotionScene("as the sheet asks", (200, 400, 600)),
    MotionScene("rod 30° up", (100, 200, 300), tilt=30.0, push=(0.7, 1.0)),
    MotionScene("no push", (100, 150, 250), push=(0.0, 0.0)),
    MotionScene("slow spins", (60, 100, 150)),
)


class Rods(Struct, frozen=True):
    """What is known of n runs; arrays of shape (n,)."""

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


def draw_labs(scene: MotionScene, count: int, seed: int) -> tuple[Rods, Rods]:
    """Simulate labs of nine runs; return the truth, and what users know and assume."""
    random = np.random.default_rng(seed)
    load, rpm = (part.ravel() for part in np.meshgrid(MASSES, scene.rpm, indexing="ij"))
    mass = np.tile(load, count)
    spin = np.tile(RPM * rpm, count)
    # The phase of the nutation at the end of a run is random.
    spin = spin * random.uniform(0.95, 1.05, spin.shape)
    pitch = np.radians(scene.tilt) + random.uniform(-OFF_TILT, OFF_TILT, spin.shape)
    pushes = random.uniform(*scene.push, spin.shape)
    decay = DECAY_TIME * np.exp(DECAY_SPREAD * random.standard_normal(count))
    inertia = np.full(spin.shape, Truth().inertia)
    across = DEFAULT_TRANSVERSE_RATIO * inertia + mass * POSITION**2
    torque = physics.torque(mass, POSITION, physics.STANDARD_GRAVITY)
    rate = physics.precession_rate(torque, spin, inertia, across, pitch)
    top = motion.Top(inertia, across, torque)
    true = Rods(top, spin, pitch, 2 * np.pi / rate, pushes, np.repeat(decay, len(load)))
    read = pitch + PITCH_U * random.standard_normal(spin.shape)
    # A log says if nobody pushed; the size of a push is unknown.
    push = models.PART_RELEASED if any(scene.push) else 0.0
    known = replace(true, pitch=read, push=push, decay=DECAY_TIME)
    return true, known


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


def release(rods: Rods) -> Any:
    """Use the mean rate of a rod that is released from rest."""
    return rods.time * motion.mean_precession_rate(rods.top, rods.spin, rods.pitch)


def half_release(rods: Rods) -> Any:
    """Use the part of the effect of a release that gyro assumes."""
    steady = tilted(rods)
    slowing = steady / release(rods) - 1
    return steady / (1 + models.PART_RELEASED * slowing)


def full_motion(rods: Rods, tolerance: float) -> Any:
    """Integrate eqs. (7) as vectors, with push and drag."""
    first = rods.spin * np.exp(rods.time / rods.decay / 2)
    start = motion.released(rods.top, first, rods.pitch)
    steady = motion.steady(rods.top, first, rods.pitch)
    pushed = np.multiply(rods.push, (steady.momentum - start.momentum).T).T
    start = replace(start, momentum=start.momentum + pushed)
    drag = rods.top.inertia / rods.decay
    _, axis = follow(rods.top, start, rods.time, drag, tolerance)
    # Add whole turns: the azimuth is near one turn.
    return np.pi + np.mod(np.arctan2(axis[1], axis[0])[:, -1] - np.pi, 2 * np.pi)


def follow(
    top: motion.Top, start: motion.State, time: Floats, drag: Any, tolerance: float
) -> tuple[Floats, Floats]:
    """Integrate the motion of n rods together, each for its own time [s].

    Return the parts of the time [1], shape (m,), and e3, shape (3, n, m).
    """
    from scipy.integrate import solve_ivp

    rates = motion.vector_rates(top, drag, time)
    rows = np.concatenate([start.axis.T, start.momentum.T])
    done = solve_ivp(
        lambda _, row: np.ravel(rates(*row.reshape(rows.shape))),
        (0, 1),
        rows.ravel(),
        "DOP853",
        rtol=tolerance,
        atol=1e-3 * tolerance,
    )
    return done.t, done.y.reshape(*rows.shape, -1)[:3]


MODELS: Mapping[str, Callable[[Rods], Any]] = {
    "eq. (9)": level,
    "eq. (8)": tilted,
    "released from rest": release,
    "half of a release": half_release,
}


# --- the comparison ---


def compare(
    scene: MotionScene, tolerances: tuple[float, ...], labs: int, seed: int
) -> list[dict[str, Any]]:
    """Measure every model in one kind of lab; the full motion with relative tolerances.

    The error of a row is the median of |error of I_zz| over the labs, over u, and
    "error_low" and "error_high" are its quartiles.
    """
    true, known = draw_labs(scene, labs, seed)
    one_true, one_known = draw_labs(scene, 1, seed)
    azimuth = full_motion(true, CLOSER * min(tolerances))
    fit, chosen = typical_fit(scene)
    u = fitting.relative_u(fit.inertia)
    tasks: list[Any] = [
        (name, "", model, known, one_known) for name, model in MODELS.items()
    ]
    for tolerance in tolerances:
        setting = f"{tolerance:.0e}"
        model = partial(full_motion, tolerance=tolerance)
        tasks.append((FULL, setting, model, known, one_known))
        tasks.append((KNOWN, setting, model, true, one_true))
    rows = []
    for method, setting, model, rods, lab in tasks:
        runs = (model(rods) / azimuth - 1).reshape(labs, -1)
        error = np.abs(runs @ fit.response) / u
        low, middle, high = np.quantile(error, [0.25, 0.5, 0.75]).tolist()
        rows.append(
            {
                "scene": scene.heading,
                "method": method,
                "chosen": chosen,
                "u": u,
                "rtol": setting,
                "seconds": fastest(partial(model, lab)),
                "error": middle,
                "error_low": low,
                "error_high": high,
                "labs": labs,
            }
        )
    return rows


def cheapest(panel: pd.DataFrame) -> str:
    """Return the cheapest model whose error is harmless in three of four labs.

    A model that knows what no user knows does not count; "none" if there is no other.
    """
    good = panel[(panel["error_high"] < changes.DROP_ALL) & (panel["method"] != KNOWN)]
    if len(good):
        return str(good.sort_values("seconds").iloc[0]["method"])
    return "none"


def typical_fit(scene: MotionScene) -> tuple[fitting.FitResult, str]:
    """Fit a log of such a lab without errors; return the model that gyro chooses too.

    The log does not say how the rods were started, unless nobody pushed them.
    """
    spins = tuple(RPM * rpm for rpm in scene.rpm)
    pitch = math.radians(scene.tilt)
    design = Design(masses=MASSES, positions=(POSITION,), spins=spins, pitches=(pitch,))
    start = "" if any(scene.push) else "# motion: released\n"
    log = simulate(Truth(), design, TYPICAL, None).log
    measured = measured_lab(log.replace("# motion: steady\n", start))
    chosen = changes.choose_model(measured)
    words = " and ".join(model.words for model in chosen.models) or chosen.words
    # A log without errors has less scatter than a real one; with the stated widths it
    # is usual.
    residual = fitting.fit(measured, tilted=chosen.tilted).widths.residual_torque
    usual = fitting.Widths(1.0, residual)
    return fitting.fit(measured, usual, tilted=chosen.tilted), words


def fastest(task: Callable[[], object]) -> float:
    """Measure the shortest CPU time of a task [s]: other work only makes it longer."""
    times: list[float] = []
    while len(times) < REPEATS and sum(times) < LONG:
        begun = time.process_time()
        task()
        times.append(time.process_time() - begun)
    return max(min(times), 1e-9)
