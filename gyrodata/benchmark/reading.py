"""What the charts say, in words: what to use when, every number from the benchmark itself."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from gyrodata.benchmark.breakdowns import Breakdown
from gyrodata.benchmark.effort import Effort
from gyrodata.benchmark.maps import MapPair
from gyrodata.benchmark.motion import BATCH, MotionPanel, MotionPoint
from gyrodata.benchmark.results import Benchmark
from gyrodata.benchmark.trials import HONEST, Trial, TrialPanel
from gyrodata.benchmark.upright import METHODS, Passage


def reading(benchmark: Benchmark, effort: Effort, seed: int) -> str:
    """Say what the charts show.

    Parameters
    ----------
    benchmark : Benchmark
    effort : Effort
        That it was run with.
    seed : int

    Returns
    -------
    str
        Markdown.
    """
    read = (
        f"Read from `gyro benchmark`, seed {seed}, {effort.labs} labs a scene. Times are of this machine: take ratios."
    )
    breaks = [
        *_roots(benchmark.roots),
        *_integrators(benchmark.integrators),
        _upright(benchmark.passages),
        *_breakdowns(benchmark.breakdowns),
    ]
    parts = [
        ["# What to use when", "", read],
        _motion(benchmark.motion),
        _trials(benchmark.trials),
        ["## Where methods break", "", *breaks],
    ]
    return "\n\n".join("\n".join(part) for part in parts) + "\n"


# --- motion -------------------------------------------------------------------------------------------------


def _motion(panels: Sequence[MotionPanel]) -> list[str]:
    rows = [
        (
            panel.title, _percent(panel.u), panel.winner.method, panel.ladder,
            f"{panel.ladder_point.error / panel.u:.2g} u", f"{_level(panel).error / panel.u:.2g} u",
        )
        for panel in panels
    ]  # fmt: skip
    below = [panel for panel in panels if panel.ladder_point.error < panel.bound]
    lines = ["## Motion: `motion.png`", ""]
    lines += _table(
        ("scene", "u of I_zz", "cheapest that does no harm", "the ladder takes", "its error", "eq. (9)"), rows
    )
    lines += ["", _holds(len(below), len(panels), "The ladder's choice is off by less than 0.3 u", "scene")]
    lines += _exceptions([panel.title for panel in panels if panel not in below])
    exact = [_of(panel, "exact") for panel in panels if _of(panel, "exact")]
    if exact:
        slowest = max(points[0].seconds for points in exact)
        lines.append(f"- The exact motion costs {_time(slowest)} a top at most (in arrays of {BATCH}).")
        lines += [
            f"- {what} that does no harm costs {ratio} times as much{use}."
            for what, ratio, use in (
                ("Splitting", _times(panels, "splitting"), ""),
                ("An integrator of scipy, one top at a time,", _times(panels, "integrator"), "; it is for drag"),
            )
            if ratio
        ]
    return lines


def _level(panel: MotionPanel) -> MotionPoint:
    """Eq. (9) with the mean spin that the tool takes."""
    return next(point for point in panel.points if point.method == "eq. (9)")


def _of(panel: MotionPanel, family: str) -> list[MotionPoint]:
    return [point for point in panel.points if point.family == family]


def _times(panels: Iterable[MotionPanel], family: str) -> str:
    """Cost of the cheapest harmless method of a family over that of the exact motion, scene by scene; "" for none."""
    ratios = [
        min(harmless) / _of(panel, "exact")[0].seconds
        for panel in panels
        if _of(panel, "exact")
        and (harmless := [point.seconds for point in _of(panel, family) if point.error < panel.bound])
    ]
    if not ratios:
        return ""
    low, high = f"{min(ratios):.2g}", f"{max(ratios):.2g}"
    return _plain(float(low)) if low == high else f"{_plain(float(low))} to {_plain(float(high))}"


# --- estimators ---------------------------------------------------------------------------------------------


def _trials(panels: Sequence[TrialPanel]) -> list[str]:
    *panels, one_side = panels
    usual = ("M on P, origin", "York, origin")
    rows = [
        (panel.scene.title, _score(panel.recommended), _rival(panel), *(_score(panel.of(name)) for name in usual))
        for panel in panels
    ]
    doubt = math.sqrt(0.95 * 0.05 / panels[0].labs)
    header = ("scene", "recommended", "best other with an honest interval", *usual)
    wins = [panel for panel in panels if panel.best is panel.recommended]
    told = f"RMSE of I_zz, and how often the 95 % interval holds the truth (known to ± {_percent(doubt)})."
    lines = ["## Estimators: `estimators.png`", "", told, "", *_table(header, rows), ""]
    what = (
        "The recommended fit has the smallest RMSE, or none is truly smaller, among those that hold the truth in "
        f"{100 * HONEST:g} % and more, as far as so many labs tell"
    )
    lines.append(_holds(len(wins), len(panels), what, "scene"))
    others = [(panel.scene.title, panel.best) for panel in panels if panel not in wins]
    lines += _exceptions([f"{title} ({best.estimator if best else 'none of them'})" for title, best in others])
    lines.append(f"- One fit of {_time(panels[0].recommended.seconds)} is the price.")
    best, mine = one_side.best, one_side.recommended
    if best is not None and best is not mine:
        lines.append(
            f"- With weights on one side only and a ball in perfect balance, {best.estimator} is better: RMSE "
            f"{_percent(best.rmse)} against {_percent(mine.rmse)}. It takes for granted that no torque is left over, "
            "which the recommended fit has to find out; with weights on both sides the difference is gone."
        )
    return lines


def _score(trial: Trial) -> str:
    return f"{_percent(trial.rmse)}, {100 * trial.coverage:.1f} %"


def _rival(panel: TrialPanel) -> str:
    """Best of the others whose interval is honest."""
    others = [trial for trial in panel.trials if trial.honest and trial.estimator != "recommended"]
    if not others:
        return "none"
    best = min(others, key=lambda trial: trial.rmse)
    return f"{best.estimator}: {_score(best)}"


# --- breaks -------------------------------------------------------------------------------------------------


def _roots(pairs: Sequence[MapPair]) -> list[str]:
    tilt, level = pairs
    none_left = max(
        float(power) for power, right in zip(level.y, level.fails.digits, strict=True) if np.nanmedian(right) < 1
    )
    without = 100 * float(np.mean(np.isnan(tilt.holds.digits)))
    tilted = (
        f"- Tilted rod (`stability_steady.png`): {tilt.fails.method} has {_median(tilt.fails.digits)} correct digits "
        f"in the median, {tilt.holds.method} never less than {_least(tilt.holds.digits)}. With the rod up and the spin "
        f"too low, {without:.0f} % of the map, there is no steady precession."
    )
    nearly = (
        f"- Nearly level rod: the root by (−b + √D)/2a has no digit left from cosθ = 10^{none_left:.0f} on; "
        f"2c/(b + √D) has {_least(level.holds.digits)} everywhere."
    )
    return [tilted, nearly]


def _integrators(pairs: Sequence[MapPair]) -> list[str]:
    return [
        (
            f"- {_capital(pair.fails.method)} (`stability_integrators.png`): correct digits "
            f"{_median(pair.fails.digits)} in the median, {_least(pair.fails.digits)} at worst; {pair.holds.method}: "
            f"{_median(pair.holds.digits)} and {_least(pair.holds.digits)}."
        )
        for pair in pairs
    ]


def _upright(passages: Sequence[Passage]) -> str:
    def worst(method: str) -> str:
        return f"{max(p.error for p in passages if p.method == method and p.error is not None):.0e}"

    def slower(method: str) -> str:
        counts = [p.evaluations for p in passages if p.method == method and p.evaluations and p.closest]
        return f"{max(counts) / min(counts):.2g}"

    dead = [p.method for p in passages if p.closest == 0 and p.error is None]
    return (
        f"- Near the vertical (`stability_upright.png`): the motion {METHODS[1]} is off by up to {worst(METHODS[1])}; "
        f"{METHODS[0]} take up to {slower(METHODS[0])} times as many evaluations as they need elsewhere; {METHODS[2]} "
        f"stay at {worst(METHODS[2])} and the same cost. Started at the vertical, no answer from: {_listed(dead)}."
    )


def _breakdowns(breakdowns: Sequence[Breakdown]) -> list[str]:
    lines = []
    for case in dict.fromkeys(one.case for one in breakdowns):
        silent = [one.estimator for one in breakdowns if one.case == case and one.verdict == "nonsense"]
        if silent:
            lines.append(f"- {_capital(case)}: nonsense without a word from {_listed(silent)}.")
    mine = [one for one in breakdowns if one.estimator == "recommended"]
    held = sum(one.verdict == "holds" for one in mine)
    lines.append(f"- The recommended fit holds in {held} of {len(mine)} such cases (`stability_estimators.png`).")
    return lines


# --- words --------------------------------------------------------------------------------------------------


def _table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    return [f"| {' | '.join(row)} |" for row in (header, ["---"] * len(header), *rows)]


def _holds(count: int, whole: int, what: str, noun: str) -> str:
    every = f"every {noun}" if count == whole else f"{count} of {whole} {noun}s"
    return f"- {what}, in {every}."


def _exceptions(names: Sequence[str]) -> list[str]:
    return [f"- Not in: {_listed(names)}."] if names else []


def _listed(names: Sequence[str]) -> str:
    return "; ".join(names)


def _capital(text: str) -> str:
    return text[0].upper() + text[1:]


def _least(digits: object) -> str:
    return f"{np.nanmin(np.asarray(digits, dtype=float)):.0f}"


def _median(digits: object) -> str:
    return f"{np.nanmedian(np.asarray(digits, dtype=float)):.0f}"


def _percent(part: float) -> str:
    return f"{100 * part:.2g} %"


def _plain(value: float) -> str:
    return f"{value:,.0f}".replace(",", " ") if value >= 10 else f"{value:g}"


def _time(seconds: float) -> str:
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if seconds >= 0.995 * size:
            return f"{seconds / size:.2g} {unit}" if seconds < 99.5 * size else f"{seconds / size:.0f} {unit}"
    return f"{seconds / 1e-9:.2g} ns"
