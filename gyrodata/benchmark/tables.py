"""The charts' numbers as CSV, all digits."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Sequence

from gyrodata.benchmark.breakdowns import Breakdown
from gyrodata.benchmark.maps import MapPair
from gyrodata.benchmark.motion import MotionPanel
from gyrodata.benchmark.results import Benchmark
from gyrodata.benchmark.trials import TrialPanel
from gyrodata.benchmark.upright import Passage

Cell = str | float | int | bool | None


def csv_tables(benchmark: Benchmark) -> dict[str, str]:
    """Write each chart's numbers as a table.

    Parameters
    ----------
    benchmark : Benchmark

    Returns
    -------
    dict of str to str
        CSV by the name of the chart, units in the headers; a cell is empty where there is no number.
    """
    return {
        "motion": _motion(benchmark.motion),
        "estimators": _trials(benchmark.trials),
        "stability_steady": _maps(benchmark.roots),
        "stability_integrators": _maps(benchmark.integrators),
        "stability_upright": _passages(benchmark.passages),
        "stability_estimators": _breakdowns(benchmark.breakdowns),
    }


def _motion(panels: Iterable[MotionPanel]) -> str:
    header = (
        "scene", "method", "setting", "time per top [s]", "relative error of I_zz", "relative u of I_zz",
        "relative error that does no harm", "cheapest that does no harm", "taken by the ladder",
    )  # fmt: skip
    rows = [
        (
            panel.scene, point.method, point.setting, point.seconds, point.error, panel.u, panel.bound,
            point == panel.winner, point.method == panel.ladder,
        )
        for panel in panels
        for point in panel.points
    ]  # fmt: skip
    return _table(header, rows)


def _trials(panels: Iterable[TrialPanel]) -> str:
    header = (
        "scene", "labs", "estimator", "time per fit [s]", "relative RMSE of I_zz", "relative bias of I_zz",
        "coverage of the 95 % interval", "mean half of the interval over I_zz", "truly better than recommended",
        "labs without an answer",
    )  # fmt: skip
    rows = [
        (
            panel.scene.name, panel.labs, trial.estimator, trial.seconds, trial.rmse, trial.bias, trial.coverage,
            trial.half, trial.better, trial.failed,
        )
        for panel in panels
        for trial in panel.trials
    ]  # fmt: skip
    return _table(header, rows)


def _maps(pairs: Iterable[MapPair]) -> str:
    rows: list[Sequence[Cell]] = [
        (pair.name, one.method, float(x), pair.y_label, float(y), float(one.digits[i, j]))
        for pair in pairs
        for one in (pair.fails, pair.holds)
        for i, y in enumerate(pair.y)
        for j, x in enumerate(pair.x)
    ]
    return _table(("map", "method", "spin [rpm]", "y is", "y", "correct digits"), rows)


def _passages(passages: Iterable[Passage]) -> str:
    rows = [(one.method, one.closest, one.error, one.evaluations) for one in passages]
    return _table(("method", "smallest angle from the vertical [rad]", "error of e3", "evaluations"), rows)


def _breakdowns(breakdowns: Iterable[Breakdown]) -> str:
    header = (
        "case", "estimator", "verdict", "median relative error of I_zz", "coverage of the 95 % interval",
        "draws in which it said so",
    )  # fmt: skip
    rows = [(one.case, one.estimator, one.verdict, one.error, one.coverage, one.told) for one in breakdowns]
    return _table(header, rows)


def _table(header: Sequence[str], rows: Iterable[Sequence[Cell]]) -> str:
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(header)
    writer.writerows([_cell(value) for value in row] for row in rows)
    return out.getvalue()


def _cell(value: Cell) -> str:
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(value) if isinstance(value, float) else str(value)
