"""Maps of two quantities: where a common method fails, and what gyro does there.

Most maps count in simulated labs. The maps of tilted rods, guided and released, have one
lab without errors of reading in each cell. Its times come from the equations of motion
as vectors.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata import physics
from gyrodata.analysis import check_fit, fit_log
from gyrodata.base.errors import InputError
from gyrodata.judging import changes
from gyrodata.physics import models
from gyrodata.quantities.units import Uncertainty
from gyrodata.readings import read_log
from gyrodata.results import Options
from gyrodata.trials.benchmark import fits, motions
from gyrodata.trials.benchmark.fits import Answer
from gyrodata.trials.benchmark.labs import LabScene, measured_lab, points_of
from gyrodata.trials.benchmark.programs import LINE, PROGRAMS
from gyrodata.trials.simulation import (
    Design,
    Motion,
    Runs,
    Truth,
    happen,
    true_readings,
)

if TYPE_CHECKING:
    import pandas as pd

GYRO = "gyro"
LEVEL = "eq. (9)"

MOST_RUNS = 200_000
"""Largest number of runs in all labs of a cell."""

HALF = 0.5
"""Part of the labs in which a method reacts, at the limit that a map shows [1]."""


class MapKind(Struct, frozen=True):
    """Two quantities that are varied, and a number that shows if a method fails."""

    name: str
    x_label: str
    y_label: str
    number: str
    """The column of the table with the number of a cell."""
    number_label: str
    good: tuple[float, float]
    """The numbers between which a method does not fail."""
    x: tuple[float, ...]
    y: tuple[float, ...]
    fit: Callable[[float, float, Sequence[int]], list[dict[str, Any]]]
    """Fits the labs of a cell, from x, y and their seeds, by two methods."""
    reactions: str = "gyro warns in most labs"
    """What it means that a method reacts."""

    def is_bad(self, numbers: Any) -> Any:
        """Return in which cells a method fails; not where it gives no answer."""
        low, high = self.good
        return (numbers < low) | (numbers > high)

    def title(self, table: pd.DataFrame) -> str:
        """Say in how many cells each method fails."""
        words = []
        for method, cells in table.groupby("method", sort=False):
            bad = self.is_bad(cells[self.number]).sum()
            words.append(f"{method} fails in {bad} of {len(cells)} cells")
        return "\n".join(words)


# --- simulated labs ---


def of_balance(difference: float, weights: float) -> LabScene:
    """Return labs whose M0 depends on the weight, in % of the lightest torque."""
    masses = np.linspace(0.020, 0.060, int(weights))
    return LabScene(
        design=Design(masses=tuple(masses)),
        noise={"u_mass": Uncertainty(difference / 100 * 0.020, 0.002)},
        stated={"u_mass": "0.2 %"},
    )


def of_torques(spread: float, torques: float) -> LabScene:
    """Return labs whose largest torque is `spread` times the smallest."""
    masses = np.linspace(0.060 / spread, 0.060, int(torques))
    return LabScene(design=Design(masses=tuple(masses)))


def of_runs(runs: float, spin_u: float) -> LabScene:
    """Return balanced labs of many runs; u of a spin is in %."""
    noise = {"u_spin": Uncertainty(0.0, spin_u / 100)}
    return LabScene(design=Design(repeats=int(runs) // 9), noise=noise, imbalance=0.0)


def fit_labs(
    scene_of: Callable[[float, float], LabScene],
    x: float,
    y: float,
    seeds: Sequence[int],
) -> list[dict[str, Any]]:
    """Fit simulated labs of one cell by the line and by gyro.

    There are fewer labs if each of them has very many runs.
    """
    scene = scene_of(x, y)
    most = MOST_RUNS // (9 * scene.design.repeats)
    rows: list[dict[str, Any]] = []
    for seed in seeds[:most]:
        log = scene.draw(seed)
        tasks: dict[str, Callable[[], Any]] = {
            LINE: partial(PROGRAMS[LINE], points_of(measured_lab(log))),
            GYRO: partial(fit_and_check, log),
        }
        rows += fits.timed_answers(tasks, scene.truth.inertia, x=x, y=y)
    return rows


def fit_and_check(log: str) -> Answer:
    """Fit a log as gyro does; it reacts by a warning, or asks no questions."""
    fitted = check_fit(fit_log(read_log(log.encode()), Options()))
    warned = any(item.severity == "warning" for item in fitted.diagnostics)
    is_long = len(fitted.measurements.runs) > changes.MOST_RUNS
    return fits.answer(fitted.fit.inertia, warned or is_long)


# --- tilted rods, by the equations of motion ---


def fit_tilted(
    start: Motion, rpm: float, degrees: float, _: Sequence[int]
) -> list[dict[str, Any]]:
    """Fit a lab of nine tilted rods by eq. (9) and by gyro.

    Eq. (9) "reacts" if a rod touches the cup, which neither method knows.
    """
    truth = Truth(motion=start)
    design = motions.at_rpm(0.95 * rpm, rpm, 1.05 * rpm, degrees=degrees)
    touches = False
    # Without steady precession the log is empty, and every method refuses it.
    log = ""
    with suppress(InputError):
        runs = happen(truth, design)
        rods = motions.rods_of(truth, runs, push=float(start == "steady"))
        # The time that the rod really needs for one turn.
        time = runs.time * 2 * np.pi / motions.full_motion(rods, motions.CLOSER)
        log = write_log(truth, replace(runs, time=time), degrees)
        touches = start == "released" and sags_into_cup(rods)
    tasks = {
        LEVEL: partial(fit_by, "horizontal", log, touches),
        GYRO: partial(fit_by, "auto", log),
    }
    return fits.timed_answers(tasks, truth.inertia, x=rpm, y=degrees)


def sags_into_cup(rods: motions.Rods) -> bool:
    """Return whether a rod that is released touches the cup."""
    top = rods.top
    sag = physics.sag_size(
        top.torque, rods.spin, top.inertia, top.transverse_inertia, rods.pitch
    )
    return bool(sag.max() > models.STEEP)


def fit_by(model: models.ModelName, log: str, touches: bool = False) -> Answer:
    """Fit a log by a model; the reaction is that gyro does not use eq. (9)."""
    fitted = fit_log(read_log(log.encode()), Options(model=model))
    other = fitted.model.name != "horizontal"
    return fits.answer(fitted.fit.inertia, touches or other)


def write_log(truth: Truth, runs: Runs, degrees: float) -> str:
    """Write a log without errors of reading, which does not state I."""
    import pandas as pd

    readings = true_readings(truth, runs)
    columns = {
        "mass [kg]": readings["mass"],
        "spin [rad/s]": readings["spin"],
        "time [s]": readings["time"],
        "pitch [deg]": degrees,
        "position [m]": readings["position"],
        "turns": 1,
    }
    table = pd.DataFrame(columns).to_csv(index=False)
    return f"# u_spin_delay: 0 s\n# motion: {truth.motion}\n{table}"


TILTED = MapKind(
    name="tilt",
    x_label="spin [rpm]",
    y_label="pitch of a guided rod [degrees]",
    number="bias",
    number_label="error of I_zz over its stated u",
    good=(-changes.DROP_ALL, changes.DROP_ALL),
    x=(25, 35, 50, 70, 100, 140, 200, 280, 400),
    y=(-60, -45, -30, -15, 0, 15, 30, 45, 60, 75),
    fit=partial(fit_tilted, "steady"),
    reactions="gyro uses eq. (8)",
)

KINDS = (
    TILTED,
    replace(
        TILTED,
        name="released",
        y_label="pitch of a rod that is released [degrees]",
        fit=partial(fit_tilted, "released"),
        # The phase of the nutation at the end of a turn is a random error.
        good=(-1, 1),
        reactions="a rod touches the cup (left), gyro uses the mean rate of a release, "
        "up to a sag of 52° (right)",
    ),
    MapKind(
        name="balance",
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
        x_label="number of runs",
        y_label="error of the spin [%]",
        number="bias",
        number_label="mean error over the stated u",
        good=(-1, 1),
        x=(9, 90, 900, 30_000),
        y=(0.5, 2, 5),
        fit=partial(fit_labs, of_runs),
        reactions='gyro asks no "what would I_zz be if …?"',
    ),
)
