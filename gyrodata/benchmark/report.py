"""All of the benchmark: what is measured, in order, and how it is written down: as tables, and to be read."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Sequence

import numpy as np
from msgspec import Struct

from gyrodata.benchmark.effort import Clock, Effort, Progress
from gyrodata.benchmark.estimators import TAKE_BALANCE
from gyrodata.benchmark.fit_curves import FitCurve, follow_fits
from gyrodata.benchmark.motion_cost import BATCH, STEPPING, MotionPanel, run_motion
from gyrodata.benchmark.orders import Drift, Order, find_orders, watch_drift
from gyrodata.benchmark.stability import (
    METHODS,
    DigitCurve,
    DigitMap,
    MapPair,
    Passage,
    follow_cosines,
    map_integrators,
    map_roots,
    pass_upright,
)
from gyrodata.benchmark.timing import MOST_APART
from gyrodata.benchmark.trials import CHARTED, HONEST, TIE, Breakdown, Trial, TrialPanel, run_trials, try_breakdowns
from gyrodata.effects import DROP_ALL

Cell = str | float | int | bool | None


class Benchmark(Struct, frozen=True):
    """What was measured."""

    motion: list[MotionPanel]
    orders: list[Order]
    drifts: list[Drift]
    trials: list[TrialPanel]
    """All scenes; those of `CHARTED` with times."""
    roots: list[MapPair]
    integrators: list[MapPair]
    passages: list[Passage]
    breakdowns: list[Breakdown]
    curves: list[FitCurve]
    cosines: list[DigitCurve]
    machine: str = ""
    """What the times depend on, in a line; "" where nobody told."""


def run_benchmark(
    effort: Effort,
    clock: Clock,
    seed: int = 1,
    progress: Progress | None = None,
    wall: Clock | None = None,
    machine: str = "",
) -> Benchmark:
    """Measure speed, accuracy and stability; all but the times is the same on every run with the same seed.

    `clock` gives CPU time; `wall`, the time on the wall, tells where others had the processor.
    """

    def part(begin: float, end: float) -> Progress:
        return lambda done: None if progress is None else progress(begin + (end - begin) * done)

    return Benchmark(
        motion=run_motion(effort, clock, seed, part(0.0, 0.25), wall),
        orders=find_orders(effort),
        drifts=watch_drift(effort, part(0.25, 0.3)),
        trials=run_trials(effort, clock, seed, part(0.3, 0.5), wall),
        curves=follow_fits(effort, seed, part(0.5, 0.7)),
        roots=map_roots(effort),
        integrators=map_integrators(effort, part(0.7, 0.8)),
        passages=pass_upright(effort, part(0.8, 0.9)),
        breakdowns=try_breakdowns(effort, seed, part(0.9, 1.0)),
        cosines=follow_cosines(effort),
        machine=machine,
    )


# --- every number, all digits ---------------------------------------------------------------------------------


def csv_tables(benchmark: Benchmark) -> dict[str, str]:
    """Write each chart's numbers as CSV, by the chart's name; a cell is empty where there is no number."""
    points: list[Sequence[Cell]] = [
        (
            panel.scene, point.method, point.setting, point.tops, point.seconds, *point.timing.quartiles,
            point.timing.apart, point.evaluations, point.error, panel.u, panel.bound,
            point == panel.cheapest(point.tops), point.method == panel.ladder,
        )
        for panel in benchmark.motion
        for point in panel.points
    ]  # fmt: skip
    orders: list[Sequence[Cell]] = [
        (order.method, point.setting, point.evaluations, point.off, point.energy, order.order)
        for order in benchmark.orders
        for point in order.points
    ]
    drifts: list[Sequence[Cell]] = [
        (drift.method, drift.setting, drift.per_nutation, *map(float, row))
        for drift in benchmark.drifts
        for row in zip(drift.precessions, drift.energy, drift.length, drift.off, strict=True)
    ]
    trials = [
        (
            panel.scene.name, panel.labs, panel.bound, panel.bound_balanced, trial.estimator,
            *((trial.time.seconds, *trial.time.quartiles) if trial.time else (None,) * 3),
            *_scored(trial), trial.ratio, trial.ratio_u, trial.better, trial.failed,
        )
        for panel in benchmark.trials
        for trial in panel.trials
    ]  # fmt: skip
    curves = [
        (
            curve.name, curve.x_label, point.x, point.labs, point.bound, trial.estimator, *_scored(trial),
            point.fails(trial.estimator),
        )
        for curve in benchmark.curves
        for point in curve.points
        for trial in point.trials
    ]  # fmt: skip
    cosines: list[Sequence[Cell]] = [
        (one.end, one.method, *(float(value) for value in values))
        for one in benchmark.cosines
        for values in zip(one.away, one.middle, one.worst, strict=True)
    ]
    passages = [(one.method, one.closest, one.error, one.evaluations) for one in benchmark.passages]
    logs = [(b.case, b.draws, b.estimator, b.verdict, b.error, b.coverage, b.told) for b in benchmark.breakdowns]
    scores = (
        "relative RMSE of I_zz,its standard error,relative bias of I_zz,coverage of the 95 % interval,mean half of the "
        "interval over I_zz"
    )
    maps = "map,method,spin [rpm],y is,y,correct digits"
    return {
        "motion": _csv(
            "scene,method,setting,tops at once,CPU time per top [s],its lower quartile [s],its upper quartile [s],"
            "least wall time over least CPU time - 1,evaluations of the torque,relative error of I_zz,relative u of "
            "I_zz,relative error that does no harm,cheapest that does no harm,taken by the ladder",
            points,
        ),
        "motion_order": _csv(
            "method,setting,evaluations of the torque,distance of e3 from the true one,energy off over h m g,order",
            orders,
        ),
        "motion_drift": _csv(
            "method,setting,evaluations a nutation,precessions,energy off over h m g,length of e3 off,"
            "distance of e3 from the true one",
            drifts,
        ),
        "estimators": _csv(
            "scene,labs,Cramér–Rao bound,the same with M0 known,estimator,least time per fit [s],lower quartile [s],"
            f"upper quartile [s],{scores},RMSE over recommended,its standard error,truly better than recommended,labs "
            "without an answer",
            trials,
        ),
        "stability_steady": _csv(maps, _map_cells(benchmark.roots)),
        "stability_integrators": _csv(maps, _map_cells(benchmark.integrators)),
        "stability_upright": _csv("method,smallest angle from the vertical [rad],error of e3,evaluations", passages),
        "stability_estimators": _csv(
            "case,draws,estimator,verdict,median relative error of I_zz,coverage of the 95 % interval,draws in which "
            "it said so",
            logs,
        ),
        "stability_fits": _csv(f"curve,x is,x,labs,Cramér–Rao bound,estimator,{scores},fails", curves),
        "stability_cosine": _csv("end,formula,|cosθ| or 1 − cosθ,median of correct digits,least", cosines),
    }


def _scored(trial: Trial) -> Sequence[Cell]:
    return trial.rmse, trial.rmse_u, trial.bias, trial.coverage, trial.half


def _map_cells(pairs: Iterable[MapPair]) -> list[Sequence[Cell]]:
    return [
        (pair.name, one.method, float(x), pair.y_label, float(y), float(one.digits[i, j]))
        for pair in pairs
        for one in (pair.fails, pair.holds)
        for i, y in enumerate(pair.y)
        for j, x in enumerate(pair.x)
    ]


def _csv(header: str, rows: Iterable[Sequence[Cell]]) -> str:
    out = io.StringIO()
    out.write(header + "\n")
    csv.writer(out, lineterminator="\n").writerows([_cell(value) for value in row] for row in rows)
    return out.getvalue()


def _cell(value: Cell) -> str:
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(value) if isinstance(value, float) else str(value)


# --- to be read -----------------------------------------------------------------------------------------------


READING = """\
# What to use when

Read from `gyro benchmark`, seed {seed}, {labs} labs a scene. Times are of this machine: take ratios.
{machine}
## Motion: `motion.png`, `motion_harder.png`

u is the standard uncertainty of I_zz in a lab of nine runs. A method whose error is below {harmless:g} u does no \
harm; use the cheapest of these. The ladder of models is what `gyro analyze` chooses.

| scene | u of I_zz | cheapest for one top | cheapest for {batch} at once | the ladder takes | its error | eq. (9) |
| --- | --- | --- | --- | --- | --- | --- |
{models}

Cost of the exact motion, for one top alone and for one of {batch} at once, and how many times as much the cheapest of \
the other families costs that does no harm. All go through one top in Python's floats, and through {batch} in arrays. \
Times are CPU times, the least of {rounds} rounds in which all took turns. A ratio is the median of {more} closer \
rounds, in brackets its quartiles; it is not told where wall and CPU time differ by more than {apart:g} %. Only \
integrators know of drag.

| scene | tops | exact motion | splitting | fixed step | adaptive |
| --- | --- | --- | --- | --- | --- |
{costs}

How often a method asks for the torque is the same on every machine (`motion_order.png`): a top let go from rest at \
150 rpm, one turn about the vertical, and how far e3 then is from the true one. The order is the slope of the curve.

| method | order | evaluations for 10⁻³ | for 10⁻⁶ | for 10⁻⁹ |
| --- | --- | --- | --- | --- |
{orders}

For long motions take splitting (`motion_drift.png`): what is lost after {precessions} turns about the vertical, by \
methods that ask for the torque about equally often. Energy over h m g; | |e3| − 1 |; distance of e3.

| method | setting | evaluations a nutation | energy | length | distance |
| --- | --- | --- | --- | --- | --- |
{drifts}

## Estimators: `estimators_scenes.png`, `estimators.png`

RMSE of I_zz over the true one, and how often the 95 % interval holds the truth. An interval is honest if it holds the \
truth in {least:g} to {most:g} % of the labs, as far as so many labs tell; with less it is too sure, with more too \
wide. The bound is that of Cramér and Rao where nobody knows M0: the best possible fit reaches it. Two fits tie if \
their RMSE are within {tie:g} %, or as near as so many labs tell.

| scene | labs | bound | recommended: RMSE over bound | truth in interval | best other that is honest | its RMSE over \
recommended | so the recommended fit |
| --- | --- | --- | --- | --- | --- | --- | --- |
{scores}

How to read it: where the errors are as the log says, the full covariance with a constant is as close as the \
recommended fit, if all shared errors are in it, the hand's bias too. The recommended fit writes that matrix itself. \
Who takes M0 = 0 is closer where it is so, and wrong where it is not: compare "no imbalance" with "the usual lab". \
Where the log is wrong about its errors, see which others stay honest. One recommended fit takes {cost}.

## Where methods break

Correct digits, median and worst (`stability_steady.png`, `stability_integrators.png`). With the rod up and the spin \
too low there is no steady precession; the map is empty there.

| map | fails | digits | holds | digits | empty |
| --- | --- | --- | --- | --- | --- |
{digits}

Orbits that pass near the vertical (`stability_upright.png`): Euler angles divide by sinθ there; the vectors e3 and H \
divide by nothing.

| motion by | largest error | most evaluations over fewest | started at the vertical |
| --- | --- | --- | --- |
{passages}

The rate of eq. (8) as cosθ → 0 and cosθ → 1 (`stability_cosine.png`): least correct digits over the spins. What \
stands in the tool is 2c/(b + √D).

| formula | rod nearly level | rod nearly upright |
| --- | --- | --- |
{cosines}

Fits while labs become worse, one thing at a time (`stability_fits.png`). A fit fails where its interval is too sure, \
or its RMSE is over twice the bound; "–": nowhere.

| what becomes worse | range | fails first |
| --- | --- | --- |
{curves}

Logs that break fits (`stability_estimators.png`), {draws} of each kind. Nonsense without a word: far from the truth, \
with an interval that misses it, and no warning. Wide: the interval holds the truth and tells next to nothing, as it \
must where all torques are equal and the log does not say how well the ball is balanced.

| case | nonsense without a word from | recommended |
| --- | --- | --- |
{broken}
"""


def reading(benchmark: Benchmark, effort: Effort, seed: int) -> str:
    """Say in Markdown what to use when: how to read each chart, and its main numbers as a table."""
    maps = (*benchmark.roots, *benchmark.integrators)
    return READING.format(
        seed=seed,
        labs=effort.labs,
        machine=f"Measured on: {benchmark.machine}.\n" if benchmark.machine else "",
        harmless=DROP_ALL,
        models=_rows(map(_models, benchmark.motion)),
        batch=BATCH,
        costs=_rows(_exact_ratios(benchmark.motion)),
        rounds=effort.repeats,
        more=len(benchmark.motion[0].duels[0].exact.cpu),
        apart=100 * MOST_APART,
        orders=_rows(map(_order, benchmark.orders)),
        precessions=effort.precessions,
        drifts=_rows(map(_drift, benchmark.drifts)),
        least=100 * HONEST[0],
        most=100 * HONEST[1],
        tie=100 * (TIE - 1),
        scores=_rows(map(_scores, benchmark.trials)),
        cost=", ".join(_costs(benchmark.trials)),
        cosines=_rows(_least_digits(benchmark.cosines)),
        curves=_rows(map(_failures, benchmark.curves)),
        draws=effort.draws,
        digits=_rows(
            (pair.title, pair.fails.method, _digits(pair.fails), pair.holds.method, _digits(pair.holds), _empty(pair))
            for pair in maps
        ),
        passages=_rows(_near_vertical(benchmark.passages, method) for method in METHODS),
        broken=_rows(_broken_logs(benchmark.breakdowns)),
    )


def _rows(rows: Iterable[Sequence[str]]) -> str:
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def _models(panel: MotionPanel) -> Sequence[str]:
    level = next(point for point in panel.points if point.method == "eq. (9)")
    errors = (f"{point.error / panel.u:.2g} u" for point in (panel.ladder_point, level))
    winners = (panel.cheapest(tops) for tops in (1, BATCH))
    names = ("none" if winner is None else winner.method for winner in winners)
    return (panel.title, percent_text(panel.u), *names, panel.ladder, *errors)


def _exact_ratios(panels: Iterable[MotionPanel]) -> list[Sequence[str]]:
    """Of each scene without drag the cost of the exact motion, and of the families that go step by step over it."""
    rows: list[Sequence[str]] = []
    for panel in panels:
        for tops in dict.fromkeys(duel.tops for duel in panel.duels):
            duels = {duel.family: duel for duel in panel.duels if duel.tops == tops}
            exact = next(iter(duels.values())).exact
            ratios = [
                f"{duels[family].timing.over(exact)}: {duels[family].method}" if family in duels else "–"
                for family in STEPPING
            ]
            rows.append((panel.title, str(tops), time_text(exact.seconds), *ratios))
    return rows


def _order(order: Order) -> Sequence[str]:
    reached = (
        min((point.evaluations for point in order.points if point.off <= aim), default=None)
        for aim in (1e-3, 1e-6, 1e-9)
    )
    slope = "–" if order.order is None else f"{order.order:.1f}"
    return (order.method, slope, *("–" if count is None else str(count) for count in reached))


def _drift(drift: Drift) -> Sequence[str]:
    lost = (f"{float(part[-1]):.0e}" for part in (drift.energy, drift.length, drift.off))
    return (drift.method, drift.setting, f"{drift.per_nutation:.0f}", *lost)


def _scores(panel: TrialPanel) -> Sequence[str]:
    mine, other = panel.recommended, next(iter(panel.peers), None)
    return (
        panel.scene.title, str(panel.labs), percent_text(panel.bound),
        f"{mine.rmse / panel.bound:.2f} ± {mine.rmse_u / panel.bound:.2f}", f"{100 * mine.coverage:.1f} %",
        other.estimator if other else "none", f"{other.ratio:.2f} ± {other.ratio_u:.2f}" if other else "–",
        _outcome(panel),
    )  # fmt: skip


def _outcome(panel: TrialPanel) -> str:
    """What comes of the recommended fit beside the honest others, in words."""
    mine = panel.recommended
    if not mine.honest:
        return "is too sure" if mine.coverage < HONEST[0] else "is too wide"
    if not panel.peers:
        return "alone is honest"
    closer = [one.estimator for one in panel.peers if one.better]
    if closer:
        return f"is not the closest{': that takes M0 = 0' if closer[0] in TAKE_BALANCE else ''}"
    ties = sum(one.ties for one in panel.peers)
    return f"ties with {ties}" if ties else "is the closest of the honest"


def _costs(panels: Iterable[TrialPanel]) -> list[str]:
    """What a recommended fit takes, where it was timed."""
    timed = [(panel, panel.recommended.time) for panel in panels if panel.scene.name in CHARTED]
    return [f"{time_text(time.seconds)} ({panel.scene.title})" for panel, time in timed if time]


def _least_digits(curves: Sequence[DigitCurve]) -> list[Sequence[str]]:
    least = {(one.method, one.end): f"{one.worst.min():.0f}" for one in curves}
    return [
        (name, least[name, "level"], least[name, "vertical"]) for name in dict.fromkeys(one.method for one in curves)
    ]


def _failures(curve: FitCurve) -> Sequence[str]:
    """Where each fit fails first."""
    xs = [point.x for point in curve.points]
    begun = {name: curve.first_failure(name) for name in curve.estimators}
    told = "; ".join(f"{name}: {'–' if x is None else f'{x:g}'}" for name, x in begun.items())
    return (f"{curve.title}: {curve.x_label}", f"{xs[0]:g} to {xs[-1]:g}", told)


def _digits(one: DigitMap) -> str:
    return f"{np.nanmedian(one.digits):.0f}, {np.nanmin(one.digits):.0f}"


def _empty(pair: MapPair) -> str:
    return f"{100 * np.mean(np.isnan(pair.holds.digits)):.0f} %"


def _near_vertical(passages: Sequence[Passage], method: str) -> Sequence[str]:
    own = [one for one in passages if one.method == method]
    worst = max((one.error for one in own if one.error is not None), default=None)
    counts = [one.evaluations for one in own if one.evaluations and one.closest]
    answers = all(one.error is not None for one in own if one.closest == 0)
    return (
        method,
        "–" if worst is None else f"{worst:.0e}",
        f"{max(counts) / min(counts):.2g}" if counts else "–",
        "an answer" if answers else "no answer",
    )


def _broken_logs(breakdowns: Sequence[Breakdown]) -> list[Sequence[str]]:
    rows: list[Sequence[str]] = []
    for case in dict.fromkeys(one.case for one in breakdowns):
        verdicts = {one.estimator: one.verdict for one in breakdowns if one.case == case}
        silent = [estimator for estimator, verdict in verdicts.items() if verdict == "nonsense"]
        rows.append((case, "; ".join(silent) or "–", verdicts["recommended"]))
    return rows


def time_text(seconds: float) -> str:
    """Write a time with two digits: 10 µs."""
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if seconds >= 0.9995 * size:
            return f"{seconds / size:.2g} {unit}" if seconds < 99.5 * size else f"{seconds / size:.0f} {unit}"
    return f"{seconds / 1e-9:.2g} ns"


def percent_text(part: float) -> str:
    """Write a part in per cent with two digits."""
    return f"{100 * part:.2g} %" if part < 0.995 else f"{100 * part:.0f} %"
