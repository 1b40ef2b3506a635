"""Run all parts of the benchmark, and write tables and a text.

The words of the text are in `reading.md`.
"""

from __future__ import annotations

import csv
import io
import platform
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import asdict

from gyrodata.judging.changes import DROP_ALL
from gyrodata.trials.benchmark.estimators import HONEST, Trial, TrialPanel, run_trials
from gyrodata.trials.benchmark.failures import Failure, find_failures
from gyrodata.trials.benchmark.motions import (
    AIMS,
    Clock,
    Effort,
    MotionPanel,
    Order,
    cheapest,
    find_orders,
    run_motion,
)


class Benchmark(Struct, frozen=True):
    """The results of all parts."""

    motion: list[MotionPanel]
    orders: list[Order]
    """First for one turn, then for many turns."""
    trials: list[TrialPanel]
    failures: list[Failure]
    machine: str = ""
    """Processor and versions in one line."""


def run_benchmark(
    effort: Effort,
    clock: Clock,
    seed: int = 1,
    progress: Callable[[int], None] | None = None,
    machine: str = "",
) -> Benchmark:
    """Run all parts; `progress` is called with the percentage that is done."""
    show = progress or (lambda _percent: None)
    motion = run_motion(effort, clock, seed)
    show(30)
    orders = find_orders(effort, clock)
    show(55)
    trials = run_trials(effort, clock, seed)
    show(90)
    return Benchmark(
        motion, orders, trials, find_failures(effort, clock, seed), machine
    )


def describe_machine() -> str:
    """Return the processor and versions in one line."""
    import scipy

    try:
        lines = (
            Path("/proc/cpuinfo")
            .read_text(encoding="utf-8", errors="replace")
            .splitlines()
        )
    except OSError:
        lines = []
    named = (
        line.partition(":")[2].strip()
        for line in lines
        if line.startswith("model name")
    )
    processor = next(named, "") or platform.processor() or platform.machine()
    return (
        f"{processor}; Python {platform.python_version()}, numpy {np.__version__}, "
        f"scipy {scipy.__version__}"
    )


# --- tables ---


def csv_tables(benchmark: Benchmark) -> dict[str, str]:
    """Write the numbers of each chart as CSV, by the name of the chart.

    The columns are attributes of the results.
    """
    tables: dict[str, list[dict[str, Any]]] = {
        "motion": [
            {
                "scene": panel.scene.name,
                **asdict(point),
                "u": panel.u,
                "harmless": point.error < panel.bound,
            }
            for panel in benchmark.motion
            for point in panel.points
        ],
        "motion_order": [
            {
                "method": order.method,
                "turns": order.turns,
                "order": order.order,
                **asdict(point),
            }
            for order in benchmark.orders
            for point in order.points
        ],
        "estimators": [
            {"scene": panel.scene.name, **asdict(trial)}
            for panel in benchmark.trials
            for trial in panel.trials
        ],
        "failures": [asdict(failure) for failure in benchmark.failures],
    }
    texts = {}
    for name, rows in tables.items():
        out = io.StringIO()
        csv.writer(out, lineterminator="\n").writerows(
            [rows[0], *(row.values() for row in rows)]
        )
        texts[name] = out.getvalue()
    return texts


# --- text ---


def reading(benchmark: Benchmark, effort: Effort, seed: int) -> str:
    """Write the text in Markdown: the best method of each part, and the main numbers."""
    text = Path(__file__).with_name("reading.md").read_text(encoding="utf-8")
    fewest = []
    for turns in (1, effort.turns):
        ranges = cheapest(benchmark.orders, turns).items()
        parts = (
            f"{name} from {power(most)} to {power(least)}"
            for name, (most, least) in ranges
        )
        fewest.append(f"* {turns} turn{'s' * (turns > 1)}: {', then '.join(parts)}")
    return text.format(
        seed=seed,
        labs=effort.labs,
        machine=benchmark.machine,
        harmless=DROP_ALL,
        winners="; ".join(
            f"{panel.scene.title}: {panel.winner.method}" for panel in benchmark.motion
        ).capitalize(),
        models=_rows(map(_model, benchmark.motion)),
        orders=_rows(map(_order, benchmark.orders)),
        fewest="\n".join(fewest),
        least=100 * HONEST[0],
        most=100 * HONEST[1],
        scenes=" | ".join(panel.scene.title for panel in benchmark.trials),
        scores=_rows(
            map(_score, zip(*(panel.trials for panel in benchmark.trials), strict=True))
        ),
        failures=_rows(
            (
                f.case,
                f.fails,
                _measure(f, f.wrong),
                f.solution,
                _measure(f, f.right),
                f.why,
            )
            for f in benchmark.failures
        ),
    )


def _rows(rows: Iterable[Sequence[str]]) -> str:
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def _model(panel: MotionPanel) -> Sequence[str]:
    level = panel.points[0]
    winner = panel.winner
    errors = [f"{point.error / panel.u:.2g} u" for point in (winner, level)]
    return (
        panel.scene.heading,
        percent_text(panel.u),
        winner.method,
        errors[0],
        time_text(winner.seconds),
        errors[1],
    )


def _order(order: Order) -> Sequence[str]:
    needed = [order.evaluations(aim) for aim in AIMS]
    counts = (
        "–" if count is None else f"{float(f'{count:.2g}'):,.0f}" for count in needed
    )
    slope = "–" if order.order is None else f"{order.order:.1f}"
    return (
        str(order.turns),
        order.method,
        slope,
        *counts,
        time_text(min(point.seconds for point in order.points)),
    )


def _score(trials: Sequence[Trial]) -> Sequence[str]:
    """Return the row of one fit in all kinds of labs."""
    cells = (
        f"{percent_text(one.rmse)}, {100 * one.coverage:.0f} %{', honest' * one.honest}"
        for one in trials
    )
    return (trials[0].estimator, *cells, time_text(max(one.seconds for one in trials)))


def _measure(failure: Failure, value: float) -> str:
    """Write an error, or a coverage in percent."""
    return f"{100 * value:.0f} %" if failure.measure == "coverage" else power(value)


def power(value: float) -> str:
    """Write a small number with one digit: 2e-5."""
    return f"{value:.0e}".replace("e-0", "e-").replace("e+00", "")


def time_text(seconds: float) -> str:
    """Write a time with two digits: 10 µs."""
    units = (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6), ("ns", 1e-9))
    unit, size = next((one for one in units if seconds >= 0.995 * one[1]), units[-1])
    return f"{float(f'{seconds / size:.2g}'):g} {unit}"


def percent_text(part: float) -> str:
    """Write a fraction in percent with two digits."""
    return f"{float(f'{100 * part:.2g}'):g} %"
