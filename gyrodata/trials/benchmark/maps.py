"""Maps of two quantities: where a common method fails, and what gyro does there.

Most maps count in simulated labs (`KINDS`). The maps of tilted rods, guided and
released, have one lab without errors of reading in each cell. Its times come from the
equations of motion as vectors, with no use of eqs. (8) and (9).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import Struct

from gyrodata import fitting, physics
from gyrodata.analysis import check_fit, fit_log
from gyrodata.base.errors import LogError
from gyrodata.judging import changes
from gyrodata.measurements import DEFAULT_TRANSVERSE_RATIO
from gyrodata.physics import RPM, Floats, models, motion
from gyrodata.quantities.units import Uncertainty
from gyrodata.readings import read_log
from gyrodata.results import Options
from gyrodata.trials.benchmark import fits
from gyrodata.trials.benchmark.fits import Answer, Row
from gyrodata.trials.benchmark.labs import LabScene, measured_lab, points_of
from gyrodata.trials.benchmark.motions import MASSES, POSITION, follow
from gyrodata.trials.benchmark.programs import line_with_intercept
from gyrodata.trials.coverage import draw
from gyrodata.trials.simulation import TYPICAL, Design, Truth, simulate
from gyrodata.trials.simulation.truth import Motion

if TYPE_CHECKING:
    import pandas as pd

LINE = "line with intercept"
GYRO = "gyro"
LEVEL = "eq. (9)"

SPINS = (25, 35, 50, 70, 100, 140, 200, 280, 400)
PITCHES = (-60, -45, -30, -15, 0, 15, 30, 45, 60, 75)
"""[rpm], [degrees]"""

HALF = 0.5
"""Part of the labs in which gyro warns, at its limit [1]."""


class MapKind(Struct, frozen=True):
    """Two quantities that are varied, and a number that shows if a method fails."""

    name: str
    title: str
    x_label: str
    y_label: str
    number: str
    """The column of the table with the number of a cell."""
    number_label: str
    good: tuple[float, float]
    """The numbers between which a method does not fail."""
    x: tuple[float, ...]
    y: tuple[float, ...]
    fit: Callable[[float, float, Sequence[int]], list[Row]]
    """Fits the labs of a cell, from x, y and their seeds, by two methods."""
    limit_label: str = "gyro warns in half of the labs"
    """Where gyro changes what it does: the contour 1 of the column "limit"."""
    letters: str = "w: gyro warns in half of the labs or more."
    """What the letters in the cells mean: the column "does"."""

    @property
    def is_exact(self) -> bool:
        """Whether a cell is one lab without errors of reading."""
        return self.number == "error"


# --- simulated labs ---


def of_balance(difference: float, weights: float) -> LabScene:
    """Return labs whose M0 depends on the weight, in % of the lightest torque."""
    masses = np.linspace(0.020, 0.060, int(weights)).tolist()
    return LabScene(
        design=Design(masses=tuple(masses)),
        noise={"u_mass": Uncertainty(difference / 100 * 0.020, 0.002)},
        stated={"u_mass": "0.2 %"},
    )


def of_torques(spread: float, torques: float) -> LabScene:
    """Return labs whose largest torque is `spread` times the smallest."""
    masses = np.linspace(0.060 / spread, 0.060, int(torques)).tolist()
    return LabScene(design=Design(masses=tuple(masses)))


def fit_labs(
    scene_of: Callable[[float, float], LabScene],
    x: float,
    y: float,
    seeds: Sequence[int],
) -> list[Row]:
    """Fit simulated labs of one cell by the line and by gyro."""
    scene = scene_of(x, y)
    rows: list[Row] = []
    for seed in seeds:
        log = scene.draw(seed)
        tasks: dict[str, Callable[[], Any]] = {
            LINE: partial(line_with_intercept, points_of(measured_lab(log))),
            GYRO: partial(fit_and_check, log),
        }
        rows += fits.timed_answers(tasks, scene.truth.inertia)
    return [{"x": x, "y": y, **row} for row in rows]


def fit_many_runs(runs: float, spin_u: float, seeds: Sequence[int]) -> list[Row]:
    """Fit labs of many runs by the line and by one fit of gyro; u of a spin is in %."""
    noise = {**TYPICAL, "u_spin": Uncertainty(0.0, spin_u / 100)}
    design = Design(repeats=int(runs) // 9)
    exact = measured_lab(simulate(Truth(imbalance=0.0), design, noise, None).log)
    fitted = fitting.fit(exact)
    rows: list[Row] = []
    for seed in seeds:
        random = np.random.default_rng(seed)
        lab = draw(exact, fitted, 1.0, False, random)
        tasks: dict[str, Callable[[], Any]] = {
            LINE: partial(line_with_intercept, points_of(lab)),
            GYRO: partial(fits.fit_once, lab),
        }
        rows += fits.timed_answers(tasks, fitted.inertia.value)
    return [{"x": runs, "y": spin_u, **row} for row in rows]


def fit_and_check(log: str) -> Answer:
    """Fit a log as gyro does; note if it warns."""
    fitted = check_fit(fit_log(read_log(log.encode()), Options()))
    warned = any(item.severity == "warning" for item in fitted.diagnostics)
    return fits.answer(fitted.fit.inertia, warned)


def number_cells(kind: MapKind, rows: pd.DataFrame) -> pd.DataFrame:
    """Compute the numbers of each cell from the answers for its labs."""
    table = fits.summary(rows, ["y", "x", "program"])
    by_gyro = table["program"] == GYRO
    warned = table["warned"].where(by_gyro, 0.0) >= HALF
    table["does"] = np.where(warned, "w", "")
    limit = table["warned"] / HALF
    if kind.name == "runs":
        limit = table["x"] / changes.MOST_RUNS
    table["limit"] = limit.where(by_gyro).bfill()
    return table


# --- tilted rods, by the equations of motion ---

DOES = {"horizontal": "9", "steady": "8", "released": "R"}
"""What a fit does, by the name of its model."""


def fit_tilted(
    start: Motion, rpm: float, degrees: float, _: Sequence[int]
) -> list[Row]:
    """Fit a lab of nine tilted rods by eq. (9) and by gyro.

    "error" is that of I_zz over its stated u; NaN without an answer.
    """
    spin = np.tile([0.95, 1.0, 1.05], 3) * rpm * RPM
    mass = np.repeat(MASSES, 3)
    pitch = math.radians(degrees)
    top = motion.Top(
        np.full(mass.shape, Truth().inertia),
        DEFAULT_TRANSVERSE_RATIO * Truth().inertia + mass * POSITION**2,
        mass * POSITION * physics.STANDARD_GRAVITY,
    )
    if start == "released":
        time, read, is_possible = follow_released(top, spin, pitch)
    else:
        time = 2 * np.pi / steady_rate(top, spin, pitch)
        read = spin
        is_possible = bool(np.isfinite(time).all())
    log = write_log(start, mass, read, time, degrees)
    rows = []
    # gyro does not know of the cup, which a falling rod hits.
    is_timed = bool(np.isfinite(time).all())
    methods = {
        LEVEL: (Options(model="horizontal"), is_possible),
        GYRO: (Options(), is_timed),
    }
    for program, (options, is_fitted) in methods.items():
        does = "x"
        error = math.nan
        limit = math.nan
        if is_fitted:
            does, error, limit = fit_by(log, options)
        if start == "released":
            limit = sag_limit(top, spin, pitch)
        cell = {"x": rpm, "y": degrees, "program": program, "error": error}
        rows.append({**cell, "does": does, "limit": limit})
    return rows


def sag_limit(top: motion.Top, spin: Floats, pitch: float) -> float:
    """Compute the sag by which gyro refuses a log, over the largest one [1]."""
    body = top.inertia, top.transverse_inertia
    sag = physics.greatest_sag(top.torque, spin, *body, pitch)
    return float(sag.max() / models.FALLEN)


def write_log(
    start: str, mass: Floats, spin: Floats, time: Floats, degrees: float
) -> str:
    """Write a log without errors of reading."""
    head = "mass [kg],spin [rad/s],time [s],pitch [deg],position [m],turns"
    columns = mass.tolist(), spin.tolist(), time.tolist()
    rows = [
        f"{load!r},{rate!r},{seconds!r},{degrees},{POSITION},1"
        for load, rate, seconds in zip(*columns, strict=True)
    ]
    return "\n".join(["# u_spin_delay: 0 s", f"# motion: {start}", head, *rows])


def fit_by(log: str, options: Options) -> tuple[str, float, float]:
    """Fit a log; return what the fit does, its error over its u, and the limit of gyro.

    The limit is the size of the effect by which gyro decides, over the largest one.
    """
    try:
        fitted = fit_log(read_log(log.encode()), options)
    except LogError:
        return "–", math.nan, math.nan
    inertia = fitted.fit.inertia
    error = (inertia.value - Truth().inertia) / (inertia.u or math.nan)
    limit = changes.size_of_model(fitted.lab, models.STEADY) / changes.DROP_ALL
    return DOES[fitted.model.name], error, limit


def follow_released(
    top: motion.Top, spin: Floats, pitch: float
) -> tuple[Floats, Floats, bool]:
    """Integrate the motion of rods that are released from rest.

    Return the time of a turn [s], the spin that a tachometer reads if it follows the
    rod [rad/s], and whether no rod hits the cup.
    """
    # Most rods turn once or a little more in this time.
    longest = 2.2 * np.pi / motion.mean_precession_rate(top, spin, pitch)
    start = motion.released(top, spin, pitch)
    parts, (x, y, z) = follow(top, start, longest, 0.0, 1e-6)
    azimuth = np.unwrap(np.arctan2(y, x))
    ends = [np.interp(2 * np.pi, angle, parts, right=np.nan) for angle in azimuth]
    rise = np.trapezoid(z, azimuth, axis=1) / longest
    sag = pitch - np.arcsin(z.min(axis=1))
    return longest * ends, spin - rise, bool(sag.max() < models.STEEP)


def steady_rate(top: motion.Top, spin: Floats, pitch: Any) -> Floats:
    """Find the slow rate at which a rod neither rises nor falls [rad/s]; NaN if none.

    The vertical acceleration comes from the equations of motion.
    """
    rates = np.geomspace(1e-3, 1e2, 400)
    rises = lift(top, rates[:, None], spin, pitch) > 0
    first = rises.argmax(axis=0)
    low = rates[np.maximum(first - 1, 0)]
    high = rates[first]
    rate = motion.find_crossing(lambda rate: lift(top, rate, spin, pitch), low, high)
    return np.where(rises.any(axis=0), rate, np.nan)


def lift(top: motion.Top, rate: Floats, spin: Floats, pitch: Any) -> Floats:
    """Compute I z̈ of e3 [N*m] for a rod that moves horizontally at a rate."""
    x = np.cos(pitch)
    z = np.sin(pitch)
    about_vertical = top.transverse_inertia * rate
    along = top.inertia * (spin + rate * z) - about_vertical * z
    momentum = along * x, 0.0, along * z + about_vertical
    _, dy, _, _, torque, _ = motion.vector_rates(top)(x, 0.0, z, *momentum)
    # I ż = (H × e3)_z, in which y and the y component of H are 0 now.
    return np.asarray(momentum[0] * dy - torque * x)


ERROR = "error of I_zz over its stated u"
HARMLESS = (-changes.DROP_ALL, changes.DROP_ALL)
SPIN_LABEL = "spin [rpm]"
PITCH_LABEL = "pitch of the rod [degrees]"

KINDS = (
    MapKind(
        name="tilt",
        title="guided rods",
        x_label=SPIN_LABEL,
        y_label=PITCH_LABEL,
        number="error",
        number_label=ERROR,
        good=HARMLESS,
        x=SPINS,
        y=PITCHES,
        fit=partial(fit_tilted, "steady"),
        limit_label="gyro changes from eq. (9) to eq. (8)",
        letters="9, 8: gyro uses eq. (9) or (8). x: no steady precession.",
    ),
    MapKind(
        name="released",
        title="rods that are released from rest",
        x_label=SPIN_LABEL,
        y_label=PITCH_LABEL,
        number="error",
        number_label=ERROR,
        good=HARMLESS,
        x=SPINS,
        y=PITCHES,
        fit=partial(fit_tilted, "released"),
        limit_label="gyro refuses a rod that falls so far",
        letters=(
            "9, R: gyro uses eq. (9) or the mean rate of a release. –: refused. "
            "x: hits the cup."
        ),
    ),
    MapKind(
        name="balance",
        title="M0 differs between the weights",
        x_label="difference of M0 between weights [% of a torque]",
        y_label="number of weights",
        number="coverage",
        number_label="coverage of the 95 % interval",
        good=(0.9, 1),
        x=(0, 2, 5, 10, 20),
        y=(2, 3, 4),
        fit=partial(fit_labs, of_balance),
    ),
    MapKind(
        name="torques",
        title="torques that are similar",
        x_label="largest torque over smallest torque",
        y_label="number of torques",
        number="length",
        number_label="stated 95 % interval over the needed one",
        good=(0.5, 2),
        x=(1, 1.02, 1.1, 1.5, 2, 4),
        y=(2, 3, 9),
        fit=partial(fit_labs, of_torques),
    ),
    MapKind(
        name="runs",
        title="many runs",
        x_label="number of runs",
        y_label="error of the spin [%]",
        number="bias",
        number_label="mean error over the stated u",
        good=(-1, 1),
        x=(9, 90, 900),
        y=(0.5, 2, 5),
        fit=fit_many_runs,
        limit_label='right of it gyro asks no "what would I_zz be if …?"',
    ),
)
