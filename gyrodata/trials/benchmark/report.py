"""Run all parts of the benchmark, and write the page, the pictures and the tables.

The work is a list of jobs, which are done in several processes. Their answers do not
depend on their order.
"""

from __future__ import annotations

import itertools
import operator
import textwrap
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import Struct

from gyrodata.base.workers import Failed, in_workers
from gyrodata.judging.changes import DROP_ALL
from gyrodata.reporting import figures
from gyrodata.reporting.data import templates
from gyrodata.trials.benchmark import (
    charts,
    fits,
    integrators,
    labs,
    maps,
    motions,
    programs,
)

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

LONGEST = 900.0
"""Largest time of one job [s]."""

SEED = 1
"""Seed of the random numbers."""


class Effort(Struct, frozen=True):
    """The size of a benchmark."""

    labs: int
    """Number of simulated labs behind each point of a chart."""
    budgets: Mapping[int, int]
    """Largest number of evaluations of an integrator, by the number of turns."""
    every: int
    """Every how many cells of a map are computed, in each direction."""
    processes: bool
    """Whether the cost of whole processes is measured."""


FULL = Effort(200, {1: 60_000, 100: 900_000}, 1, True)
"""Ten minutes on two processors."""

QUICK = Effort(6, {1: 3_000, 10: 8_000}, 2, False)
"""A quarter of a minute on two processors."""


class Picture(Struct, frozen=True):
    """A picture of the benchmark, with its numbers."""

    title: Callable[[pd.DataFrame], str]
    """Says what the numbers show."""
    draw: Callable[[Figure, pd.DataFrame], None]
    height: float
    """[inch]"""


PICTURES: Mapping[str, Picture] = {
    "fits": Picture(
        fits.title,
        partial(
            charts.draw_points,
            views=[("seconds", "error"), ("seconds", "coverage"), ("process", "error")],
            error="relative error, 68 % are closer",
            levels={"coverage": fits.STATED},
        ),
        8.4,
    ),
    "motion": Picture(
        motions.title,
        partial(
            charts.draw_points,
            views=[("seconds", "error")],
            error="error of I_zz over u (bar: half of the labs)",
            levels={"error": DROP_ALL},
        ),
        5.2,
    ),
    "integrators": Picture(
        integrators.title,
        partial(
            charts.draw_points,
            views=[("evaluations", "error"), ("seconds", "error")],
            error="error of the rod's direction (true: elliptic integrals)",
        ),
        7.2,
    ),
    **{
        kind.name: Picture(
            kind.title, partial(charts.draw_map, kind=kind), 2.6 + 0.3 * len(kind.y)
        )
        for kind in maps.KINDS
    },
}


def list_jobs(
    effort: Effort, own: labs.LabScene | None
) -> Iterator[tuple[str, Callable[[], list[dict[str, Any]]]]]:
    """List the jobs with the names of their tables, the long ones first."""
    lab = own or labs.SCENES[0]
    random = np.random.default_rng(SEED)
    seeds = random.integers(2**31, size=effort.labs).tolist()
    for method, turns in itertools.product(integrators.NOMINAL, effort.budgets):
        most = effort.budgets[turns]
        yield "integrators", partial(integrators.measure_curve, method, turns, most)
    for scene in (lab, *motions.SCENES[1:]):
        yield "motion", partial(motions.compare, scene, effort.labs, SEED)
    for kind in maps.KINDS:
        cells = itertools.product(kind.y[:: effort.every], kind.x[:: effort.every])
        for y, x in cells:
            yield kind.name, partial(kind.fit, x, y, seeds)
    for name in (*programs.installed(), fits.GYRO) * effort.processes:
        yield "process", partial(fits.process_cost, name, lab.draw(SEED))
    for kind_of_lab, each in itertools.product((lab, *labs.SCENES[1:]), seeds):
        yield "fits", partial(fits.fit_lab, kind_of_lab, each)


def run(
    effort: Effort,
    workers: int,
    own: labs.LabScene | None = None,
    progress: Callable[[int], None] | None = None,
) -> dict[str, pd.DataFrame]:
    """Do all jobs; return the numbers of each picture.

    `own` takes the place of the usual lab, and `progress` is called with the part of the
    jobs that is done [%].
    """
    import pandas as pd

    names, jobs = zip(*list_jobs(effort, own), strict=True)
    rows_of: defaultdict[str, list[dict[str, Any]]] = defaultdict(list)
    for name, rows in zip(names, answers_of(jobs, workers, progress), strict=True):
        rows_of[name] += rows
    tables = {name: pd.DataFrame(rows) for name, rows in rows_of.items()}
    tables["fits"] = fits.summary(tables["fits"], "scene")
    if "process" in tables:
        tables["fits"] = tables["fits"].merge(tables.pop("process"), "left")
    for kind in maps.KINDS:
        tables[kind.name] = fits.summary(tables[kind.name], "y", "x")
    return tables


def answers_of(
    jobs: Sequence[Callable[[], Any]],
    workers: int,
    progress: Callable[[int], None] | None = None,
) -> list[Any]:
    """Do jobs in several processes; return their answers in the order of the jobs."""
    answers: dict[Callable[[], Any], Any] = {}
    for job, answer in in_workers(operator.call, jobs, workers, LONGEST):
        if isinstance(answer, Failed):
            raise RuntimeError(f"the benchmark failed: {answer}")
        answers[job] = answer
        if progress is not None:
            progress(100 * len(answers) // len(jobs))
    return [answers[job] for job in jobs]


# --- the files ---


def titles(tables: Mapping[str, pd.DataFrame]) -> dict[str, str]:
    """Return what each picture shows, by its name."""
    return {name: picture.title(tables[name]) for name, picture in PICTURES.items()}


def files(
    tables: Mapping[str, pd.DataFrame], own: str, workers: int
) -> dict[str, bytes]:
    """Return the page, the pictures and the tables; `own` is the name of a log, or ""."""
    drawn = answers_of([partial(draw, name, tables) for name in PICTURES], workers)
    data = {f"{name}.png": png for name, png in zip(PICTURES, drawn, strict=True)}
    for name, table in tables.items():
        data[f"{name}.csv"] = table.to_csv(index=False).encode()
    return data | {"benchmark.html": page(tables, own).encode()}


def draw(name: str, tables: Mapping[str, pd.DataFrame]) -> bytes:
    """Draw a picture, and return the bytes of its PNG."""
    from matplotlib.figure import Figure

    picture = PICTURES[name]
    table = tables[name]
    lines = [*picture.title(table).splitlines(), labs_text(table)]
    title = "\n".join([textwrap.fill(line, charts.LETTERS) for line in lines if line])
    with figures.own_style(charts.STYLE):
        figure = Figure((9.0, picture.height), dpi=80, layout="constrained")
        figure.suptitle(title, x=0.01, ha="left", fontsize=9.5)
        picture.draw(figure, table)
        return figures.save(figure, "png", 9)


def labs_text(table: pd.DataFrame) -> str:
    """Say how many simulated labs are behind each number; "" of a single lab."""
    counts = sorted({*table.get("labs", [1])})
    if counts == [1]:
        return ""
    text = f"{' or '.join(map(str, counts))} simulated labs behind each number"
    if counts[-1] >= FULL.labs:
        return text
    return f"Quick look: only {text}, so methods can fail by chance"


def page(tables: Mapping[str, pd.DataFrame], own: str) -> str:
    """Write the page with all pictures."""
    scores = tables["fits"]
    template = templates(Path(__file__).parent).get_template("page.html.jinja")
    return template.render(
        own=own,
        titles=titles(tables),
        labs=labs_text(scores),
        scores=scores[scores["scene"] == scores["scene"].iloc[0]].to_dict("records"),
    )
