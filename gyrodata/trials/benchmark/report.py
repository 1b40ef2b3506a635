"""Run all parts of the benchmark, and write the page and the tables.

The work is a list of jobs, which are done in several processes. Their answers do not
depend on their order.
"""

from __future__ import annotations

import itertools
import math
import platform
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from msgspec import Struct

from gyrodata.base.workers import Failed, in_workers
from gyrodata.physics import RPM
from gyrodata.reporting.data import templates
from gyrodata.results import FittedLog
from gyrodata.trials.benchmark import (
    fits,
    integrators,
    labs,
    maps,
    motions,
    programs,
)
from gyrodata.trials.benchmark.fits import Row
from gyrodata.trials.benchmark.labs import LabScene
from gyrodata.trials.benchmark.maps import GYRO, KINDS, MapKind
from gyrodata.trials.benchmark.motions import MotionScene
from gyrodata.trials.simulation import NOISE_KEYS, Listed, Truth

if TYPE_CHECKING:
    import pandas as pd

LONG = 4.0
"""A job with a larger cost is long [s]."""

LONGEST = 900.0
"""Largest time of one job [s]."""

BATCH = 20
"""Number of labs of a cell in one job."""


class Effort(Struct, frozen=True):
    """The size of a benchmark."""

    labs: int
    """Number of simulated labs behind each point of a chart."""
    budgets: Mapping[int, int]
    """Largest number of evaluations of an integrator, by the number of turns."""
    tolerances: tuple[float, ...]
    """Relative tolerances of the full motion [1]."""
    every: int
    """Every how many cells of a map are computed, in each direction."""
    processes: bool
    """Whether the cost of whole processes is measured."""


FULL = Effort(200, {1: 60_000, 100: 900_000}, (1e-2, 1e-3, 1e-4), 1, True)
"""Ten minutes on two processors."""

QUICK = Effort(4, {1: 3_000, 10: 8_000}, (1e-2,), 2, False)
"""A quarter of a minute on two processors."""


class Benchmark(Struct, frozen=True):
    """The results of all parts."""

    effort: Effort
    tables: Mapping[str, pd.DataFrame]
    """The numbers of each chart, by its name."""
    machine: str
    """Processor and versions in one line."""


Scene = tuple[LabScene, MotionScene]
"""A lab, for the fits and for the models of the motion."""


class Job(NamedTuple):
    """A part of the work."""

    table: str
    """The table of its rows."""
    cost: float
    """About its CPU time [s]."""
    work: Callable[[], list[Row]]


def list_jobs(effort: Effort, seed: int, own: Scene | None) -> Iterator[Job]:
    """List the jobs; the lab of a log takes the place of the usual one."""
    lab, rods = own or (labs.SCENES[0], motions.SCENES[0])
    seeds = labs.seeds(effort.labs, seed)
    for scene, each in itertools.product((lab, *labs.SCENES[1:]), seeds):
        yield Job("fits", 0.3, partial(fits.fit_lab, scene, each))
    if effort.processes:
        log = labs.SCENES[0].draw(seed)
        for name in (*programs.installed(), fits.GYRO):
            yield Job("process", 5.0, partial(fits.process_cost, name, log))
    for kind_of_rods in (rods, *motions.SCENES[1:]):
        settings = kind_of_rods, effort.tolerances, effort.labs, seed
        cost = 2 + 0.2 * effort.labs
        yield Job("motion", cost, partial(motions.compare, *settings))
    for (turns, most), method in itertools.product(
        effort.budgets.items(), integrators.NOMINAL
    ):
        curve = partial(integrators.measure_curve, method, turns, most)
        yield Job("integrators", 2e-5 * most, curve)
    for kind in KINDS:
        yield from jobs_of_map(kind, effort.every, seeds)


def jobs_of_map(kind: MapKind, every: int, seeds: list[int]) -> Iterator[Job]:
    """List the jobs of a map: some labs of one cell each."""
    for y, x in itertools.product(kind.y[::every], kind.x[::every]):
        for part in batches([] if kind.is_exact else seeds):
            cost = 0.04 * (len(part) or 10) * max(1, x / 200)
            yield Job(kind.name, cost, partial(kind.fit, x, y, part))


def batches(seeds: Sequence[int]) -> list[Sequence[int]]:
    """Divide the seeds of labs into jobs; there is at least one job."""
    starts = range(0, max(1, len(seeds)), BATCH)
    return [seeds[start : start + BATCH] for start in starts]


def run(
    effort: Effort,
    workers: int,
    seed: int = 1,
    own: Scene | None = None,
    progress: Callable[[int], None] | None = None,
) -> Benchmark:
    """Do all jobs; `progress` is called with the part that is done [%]."""
    jobs = list(list_jobs(effort, seed, own))
    whole = sum(job.cost for job in jobs)
    done = 0.0
    answers: dict[int, list[Row]] = {}
    # Long jobs begin first, so that no process waits for one at the end.
    for is_long in (True, False):
        tasks = {
            i: job.work for i, job in enumerate(jobs) if (job.cost > LONG) == is_long
        }
        for number, rows in answers_of(tasks, workers):
            answers[number] = rows
            done += jobs[number].cost
            if progress is not None:
                progress(round(100 * done / whole))
    rows = [(job.table, answers[number]) for number, job in enumerate(jobs)]
    return Benchmark(effort, tables_of(rows), describe_machine())


def tables_of(answers: Iterable[tuple[str, list[Row]]]) -> dict[str, pd.DataFrame]:
    """Gather the rows of the jobs, and compute the numbers of each chart."""
    import pandas as pd

    rows_of: dict[str, list[Row]] = {}
    for name, rows in answers:
        rows_of.setdefault(name, []).extend(rows)
    tables = {name: pd.DataFrame(rows) for name, rows in rows_of.items()}
    tables["fits"] = fits.summary(tables["fits"], ["scene", "program"])
    if "process" in tables:
        tables["fits"] = tables["fits"].merge(tables.pop("process"), "left")
    for kind in KINDS:
        if not kind.is_exact:
            tables[kind.name] = maps.number_cells(kind, tables[kind.name])
    return tables


def answers_of(
    tasks: Mapping[Any, Callable[[], Any]], workers: int
) -> Iterator[tuple[Any, Any]]:
    """Do tasks in several processes; yield the name and the answer of each."""
    for (name, _), answer in in_workers(do, [*tasks.items()], workers, LONGEST):
        if isinstance(answer, Failed):
            raise RuntimeError(f"the benchmark failed at {name}: {answer}")
        yield name, answer


def do(task: tuple[Any, Callable[[], Any]]) -> Any:
    """Do one task."""
    return task[1]()


def describe_machine() -> str:
    """Return the processor and the version of Python."""
    processor = platform.processor() or platform.machine()
    return f"{processor}, Python {platform.python_version()}"


def scene_of(log: FittedLog) -> Scene:
    """Return the lab of a log as a scene: its runs, its fitted values, its stated u."""
    measured = log.measurements
    fit = log.fit
    # A weight with the same torque, also if the log contains forces or torques.
    position = np.copysign(motions.POSITION, measured.torque)
    mass = measured.torque / position / measured.g
    columns = mass, position, measured.pitch, measured.spin, measured.turns
    noise = {
        key: u for key, u in log.readings.uncertainties.items() if key in NOISE_KEYS
    }
    truth = Truth(inertia=fit.inertia.value, imbalance=fit.residual_torque.value)
    design = Listed(runs=tuple(zip(*(each.tolist() for each in columns), strict=True)))
    rpm = np.quantile(measured.spin / RPM, [0, 0.5, 1]).round().astype(int).tolist()
    tilt = math.degrees(float(np.mean(measured.pitch)))
    push = (0.0, 0.0) if measured.motion == "released" else (0.0, 1.0)
    lab = LabScene("your log", design, noise, truth=truth)
    return lab, MotionScene("your log", tuple(rpm), tilt, push)


# --- titles, from the numbers ---


def titles(done: Benchmark) -> dict[str, str]:
    """Return the result of each chart in one or two sentences, by its name."""
    return {
        "fits": fits_title(done.tables["fits"]),
        "motion": motion_title(done.tables["motion"]),
        "integrators": curves_title(done.tables["integrators"]),
        **{kind.name: map_title(kind, done.tables[kind.name]) for kind in KINDS},
    }


def fits_title(scores: pd.DataFrame) -> str:
    """Say which programs are correct most often, and what the cheapest one costs."""
    is_correct = scores["coverage_low"].le(fits.STATED) & scores["coverage_high"].ge(
        fits.STATED
    )
    counts = is_correct.groupby(scores["program"], sort=False).sum()
    costs = scores.groupby("program", sort=False)["seconds"].mean()
    best = counts[counts == counts.max()].index
    cheapest = str(costs[best].idxmin())
    cost = float(costs[best].min())
    factor = float(f"{cost / costs.min():.1g}")
    return (
        f"The 95 % interval is correct in {counts.max()} of "
        f"{scores['scene'].nunique()} kinds of labs with {' and '.join(best)}.\n"
        f"The cheapest of them, {cheapest}, costs {1e3 * cost:.0f} ms a lab, "
        f"{factor:,.0f} times as much as {costs.idxmin()}"
    )


def motion_title(points: pd.DataFrame) -> str:
    """Name the cheapest model with a harmless error in each kind of lab."""
    words = [
        f"{scene}: {motions.cheapest(panel)}"
        for scene, panel in points.groupby("scene", sort=False)
    ]
    return "The cheapest model with a harmless error.\n" + "\n".join(words)


def curves_title(curves: pd.DataFrame) -> str:
    """Name the fastest integrator for a coarse and for a small error."""
    turns = curves["turns"].max()
    words = []
    for aim in (1e-2, 1e-6):
        good = curves[(curves["turns"] == turns) & (curves["error"] < aim)]
        if not good.empty:
            fastest = good.loc[good["seconds"].idxmin(), "method"]
            words.append(f"{fastest} for an error below {aim:g}")
    return (
        f"The fastest in time over {turns} turns:\n{', '.join(words)}.\n"
        f"Reference: elliptic integrals of the first and third kind (Carlson's forms)"
    )


def map_title(kind: MapKind, table: pd.DataFrame) -> str:
    """Say in how many cells each method fails, and in how many gyro gives no answer."""
    number = table[kind.number]
    fails = (number < kind.good[0]) | (number > kind.good[1])
    of_gyro = table[table["program"] == GYRO]
    words = []
    for program, rows in table[fails].groupby("program", sort=False):
        where = f" (up to {rows['x'].max():g} rpm)" if kind.is_exact else ""
        words.append(f"{program} fails in {len(rows)}{where}")
    failures = " and ".join(words) or "no method fails"
    title = f"{kind.title.capitalize()}: of {len(of_gyro)} cells\n{failures}"
    missing = of_gyro["does"].eq("–").sum()
    return f"{title}; it refuses {missing}" if missing else title


def page(done: Benchmark, own: str) -> str:
    """Write the page with all charts; `own` is the name of the reader's log, or ""."""
    scores = done.tables["fits"]
    template = templates(Path(__file__).parent).get_template("page.html.jinja")
    return template.render(
        done=done,
        own=own,
        titles=titles(done),
        labs=labs_text(done),
        scores=scores[scores["scene"] == scores["scene"].iloc[0]].to_dict("records"),
    )


def labs_text(done: Benchmark) -> str:
    """Say how many simulated labs are behind each point."""
    text = f"{done.effort.labs} simulated labs behind each point"
    return text if done.effort == FULL else f"Quick look: only {text}"


def csv_tables(done: Benchmark) -> dict[str, str]:
    """Write the numbers of each chart as CSV, by the name of the chart."""
    return {
        name: table.to_csv(index=False, lineterminator="\n")
        for name, table in done.tables.items()
    }
