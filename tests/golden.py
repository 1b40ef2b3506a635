"""Golden text: words to the letter, numbers as far as a processor and a release of numpy leave them alone."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from itertools import groupby
from typing import Any

import numpy as np
import pytest
from labs import G, lab, scenes
from msgspec.structs import replace
from sheets import HABITS, source
from sheets import lab as sheet

from gyrodata.diagnostics import CODES
from gyrodata.errors import GyroError
from gyrodata.fitting import (
    ChosenModel,
    Estimate,
    FitResult,
    NoFit,
    Otherwise,
    balance_scale,
    explaining_counts,
    fit,
    fit_as_stated,
    fit_otherwise,
    if_balanced,
    iterate_mean_rate,
    lightest_torque,
    refit,
    sample,
    screen,
    transverse_inertia,
)
from gyrodata.forecast import (
    design_of,
    expected_u,
    with_balance_test,
    with_better,
    with_both_signs,
    with_longer_times,
    with_unloaded_run,
)
from gyrodata.measurements import Measurements
from gyrodata.readings import Reading, read_log
from gyrodata.units import Uncertainty

NUMBER = re.compile(r"\d+(?:\.\d+)?(?:e[-+]?\d+)?")


class Steady:
    """A text that equals another of the same words and the same numbers, to ten digits; figures by their names."""

    def __init__(self, text: str) -> None:
        text = re.sub(r"data:image/png;base64,[A-Za-z0-9+/=]+", "FIGURE", text)
        self.words, self.numbers = NUMBER.sub("№", text), [float(number) for number in NUMBER.findall(text)]

    def __eq__(self, other: object) -> bool:
        # What is left where two numbers cancel has fewer digits.
        return (
            isinstance(other, Steady)
            and self.words == other.words
            and other.numbers == pytest.approx(self.numbers, rel=2e-10, abs=1e-12)
        )

    def __repr__(self) -> str:
        numbers = iter(self.numbers)
        return re.sub("№", lambda _: f"{next(numbers):.10g}", self.words)


def numbers(node: Any, place: str = "") -> dict[str, float]:
    """Every number of a JSON by its place, with the digits that no processor changes."""
    if isinstance(node, dict):
        parts = node.items()
    elif isinstance(node, list):
        parts = enumerate(node)
    else:
        return {place: float(f"{node:.8g}")} if isinstance(node, float) else {}
    return {at: value for key, part in parts for at, value in numbers(part, f"{place}.{key}".lstrip(".")).items()}


def every_log_as_read() -> str:
    """Tell what is read of every log that a student may type, and of the example of each diagnostic."""
    logs: dict[str, tuple[bytes, dict[str, Any]]] = {}
    for number, habit in enumerate(HABITS):
        typed = source(habit.make(sheet(number, habit.turns, habit.unloaded)))
        logs[habit.name] = typed, {"settings": habit.settings, "mapping": habit.mapping}
        if habit.asked:
            logs[f"{habit.name}, before it is asked about"] = typed, {}
    for code, known in CODES.items():
        if code[1] in "1235" and not known.example.startswith(("analyze ", "template ")):
            logs[code] = known.example.encode("latin-1" if code in ("G107", "G109") else "utf-8"), {}
    return "".join(f"{name}\n" + "".join(as_read(log, **given)) for name, (log, given) in logs.items())


def as_read(log: bytes, longest: int = 300, **given: Any) -> Iterator[str]:
    """Tell all that is read of a log, a line a thing: what is said of it, its runs, its columns, what holds for all."""
    try:
        readings = read_log(log, **given)
        said = readings.diagnostics
    except GyroError as error:
        readings, said = None, error.diagnostics
    yield from (f"  {d.code} {d.line}:{d.column}+{d.width} {d.message[:longest]} | {d.hint[:longest]}\n" for d in said)
    if readings is None:
        return
    yield f"  runs {' '.join(readings.runs)}, lines {' '.join(map(str, readings.lines))}\n"
    yield from (f"  note {note}\n" for note in readings.notes if note)
    for column in (*readings.columns.values(), *readings.others):
        places = [place for run in (0, -1) if column.spots and (place := column.place(run))]
        at = " to ".join(f"{place.line}:{place.column}" for place in places)
        cells = " ".join(f"{cell}x{len(list(same))}" for cell, same in groupby(map(_cell, column.readings)))
        yield f'  {column.role} "{column.header}" [{column.unit}] {at} {cells}\n'.replace("x1 ", " ")
    sizes = {key: _size(u) for key, u in readings.uncertainties.items()}
    reported = {key: f"{one.value} ± {one.u} {one.fault}" for key, one in readings.reported.items()}
    rest = {key: getattr(readings, key) for key in ("balance_tilt", "balance_drift", "motion", "balanced", "origin_u")}
    for key, value in {**readings.constants, **readings.metadata, **sizes, **reported, **rest}.items():
        if value not in (None, 0.0):
            yield f"  {key}: {value}\n"


def _cell(read: Reading) -> str:
    value = "-" if read.value is None else f"{read.value:.9g}"
    return value + (f"~{read.step:.3g}" if read.step else "") + (f"±{_size(read.u)}" if read.u else "")


def _size(u: Uncertainty) -> str:
    return f"{u.absolute:.6g}|{u.relative:.6g}"


def every_number_of_a_fit(name: str) -> dict[str, list[float]]:
    """Tell all that the fit of a scene of `labs` gives: rows of numbers of one unit, by their names."""
    measured = scenes()[name]
    released = measured.motion == "released"
    tilted = released or "tilted" in name or name == "the weight spins along"
    if released:
        measured = iterate_mean_rate(measured, ChosenModel(tilted=True, released=True, asked=False))
    stated, whole = fit_as_stated(measured, tilted), fit(measured, tilted)
    rows: dict[str, Any] = {}
    for way, result in (("as stated", stated), ("fit", whole)):
        rows |= {f"{way}: {key}": values for key, values in told_by(result).items()}
    if less := left_out(measured, tilted):
        rows["without the last"] = in_one(less.inertia)
        several = ("deviations", "influence", "response")
        rows |= {f"without the last: {each}": one_or_more(getattr(less, each)) for each in several}
    count = len(measured.runs)
    groups = [[], [0], [count - 1], [*range(count // 2)], [*range(count - 1)], [*range(count)]]
    for at, change in enumerate(whole.adjusted.without(groups)):
        rows[f"leaving out: {at}"] = change or ()
    cases = [Otherwise({"time": 0.5, "spin_scale": 3.0}), Otherwise({"mass": 0.2 + np.arange(count) / count})]
    cases += [Otherwise(balance=0.3), Otherwise(balance=1e-3)] + [Otherwise(bias=0.02)] * (measured.timing_bias_u > 0)
    for rough in (False, True):
        for at, one in enumerate(fit_otherwise(measured, whole, cases, rough)):
            rows[f"otherwise: {at}, {'rough' if rough else 'whole'}"] = in_one(one)
    rows["if balanced"] = in_one(if_balanced(measured, whole))
    odd, kept = screen(measured, tilted)
    rows["screen"] = [number for one in odd for number in (one.index, one.deviation, one.turns or 0.0, one.slip)]
    rows["screened"] = in_one(kept.inertia) if kept else ()
    rows["counts"] = [number for answer in explaining_counts(measured) for pair in answer.items() for number in pair]
    for way, balanced in (("as it is", False), ("balanced", True)):
        try:
            again = refit(whole, measured, tilted, balanced)
        except NoFit:
            continue
        rows[f"refit {way}"] = in_one(again.inertia)
        rows[f"refit {way}: M0"] = [*in_one(again.imbalance), lightest_torque(measured, np.ones(count))]
        rows[f"refit {way}: misfit"] = [again.chi2, again.dof, again.scatter, again.adjusted.kept.sum()]
    rows["scale of M0"] = balance_scale(measured, np.array([1e-3, 4e-3, 0.1]))
    design = design_of(measured, whole, tilted)
    changed = [design, with_longer_times(design, 3.0), with_better(design, "time"), with_balance_test(design)]
    if "torque" not in name and "force" not in name:
        changed += [with_unloaded_run(design), with_both_signs(design)]
    rows["expected u"] = expected_u(changed)
    rows["slowing"] = () if measured.slowing is None else measured.slowing
    rows["sample"] = one_or_more(sample(measured, np.ones(count)))
    rows["I"] = transverse_inertia(measured)
    return {key: [float(f"{number:.9g}") for number in np.ravel(values).tolist()] for key, values in rows.items()}


def slips() -> dict[str, list[Measurements]]:
    """Labs in which times go ever further off, a step a lab: where a run or a torque becomes odd tells a threshold."""

    def drawn(seed: int, noise: float, **options: Any) -> Measurements:
        return lab(np.random.default_rng(seed), noise=noise, **options)

    def late(measured: Measurements, which: Any, factors: Any) -> list[Measurements]:
        return [replace(measured, time=measured.time * np.where(which, factor, 1.0)) for factor in factors]

    four, many = np.arange(9) == 4, np.arange(12) == 7
    share, apart = drawn(9, 0.1), drawn(10, 0.3, repeats=2, u_time=0.05)
    apart = replace(apart, time=apart.time * np.repeat([1.02, 0.98, 1.01], 6))
    by_share = replace(share.sources[0], absolute=np.zeros(9), relative=np.full(9, 0.01)), *share.sources[1:]
    fours = drawn(11, 0.3, repeats=2, rpm=(200.0, 500.0), u_time=0.05)
    fours = replace(fours, time=fours.time * np.repeat([1.02, 0.98, 1.01], 4))
    at_four = np.isin(np.arange(9), (0, 3, 4, 8))
    time, spin, *rest = drawn(3, 0.1).sources
    widths = replace(spin, relative=np.where(at_four, 0.1, spin.relative))
    vague = replace(drawn(3, 0.1), sources=(time, widths, *rest))
    loose, exact = drawn(6, 4.0, repeats=2, rpm=(200.0, 500.0)), drawn(8, 0.0)
    found = {
        f"a tight lab {k}": late(drawn(4, 0.3), four, np.geomspace(0.15, 7, 30)[6 * k : 6 * k + 6]) for k in range(5)
    } | {
        "two turns": late(drawn(5, 0.3, turns=2.0), four, np.geomspace(0.4, 2, 12)),
        "a loose lab": late(loose, many, np.geomspace(1.0, 1.5, 6)),
        "a loose lab far off": late(loose, many, np.geomspace(1.6, 2.2, 6)),
        "four runs": late(drawn(7, 0.3, weights=(0.02, 0.06), rpm=(200.0, 500.0)), np.arange(4) == 1, (1.0, 1.3, 2.0)),
        "a second one hidden": [
            late(drawn(seed, 0.3, rpm=(200.0, 500.0)), True, [factors])[0]
            for seed, factors in (
                (30, (1, 1, 1.083, 1, 1, 1.189)),
                (36, (1, 0.94, 1.306, 1, 1, 1)),
                (98, (0.622, 1.219, 1, 1, 1, 1)),
            )
        ],
        "twelve turns and a half": late(drawn(4, 0.1, turns=12.0, u_spin=5e-4), four, [11.5 / 12, 12.5 / 12, 31 / 12]),
        "forty-one turns": late(drawn(4, 0.1, turns=40.0, u_spin=1e-4), four, [39 / 40, 41 / 40]),
        "uncertain as a share": late(replace(share, sources=by_share), four, np.geomspace(1, 1.6, 8)),
        "torques that disagree": late(apart, np.arange(18) == 8, np.linspace(1, 1.12, 7)),
        "three runs": late(drawn(7, 0.3, rpm=(400.0,)), np.arange(3) == 1, [2.0]),
        "three or six of nine": [
            *late(exact, np.arange(9) % 3 < 1, [1 + 0.1 * np.arange(9)]),
            *late(exact, np.arange(9) % 3 < 2, [1 + 0.1 * np.arange(9)]),
        ],
        "four of nine far from where they may well be": late(vague, at_four, np.linspace(1.09, 1.2, 4)),
        "never the same runs twice": [never_settled(seed) for seed in (2, 4, 31, 88, 100, 1297, 2453)],
        "a second one that is none": [loosely_drawn(seed) for seed in (450, 849, 1298, 2215)],
        "four of a torque that disagree": late(fours, many, np.linspace(1, 1.12, 7)),
    }
    designs = {
        "three torques": drawn(1, 0.1),
        "two torques": drawn(2, 0.1, weights=(0.02, 0.05)),
        "both sides": drawn(3, 0.1, positions=(0.15, -0.12), rpm=(300.0, 500.0)),
        "half turns": drawn(4, 0.1, turns=0.5),
        "with M0": drawn(5, 0.1, imbalance=9e-3),
        "with a large M0": drawn(5, 0.1, imbalance=1.1e-2),
    }
    for name, measured in designs.items():
        for which in ("least", "largest"):
            load = np.unique(measured.torque)[0 if which == "least" else -1]
            found[f"counts: {name}, {which}"] = late(measured, measured.torque == load, np.geomspace(0.28, 3.6, 45))
    # A level M0 of the half of the lightest torque, from none on.
    found["counts: ever more M0"] = [
        late(drawn(5, 0.02, imbalance=share * 0.02 * 0.15 * G), np.arange(9) < 3, [2.0])[0]
        for share in np.linspace(0.0, 0.5, 26)
    ]
    # Beyond three of the largest torques it is none, and counts are sought.
    found["counts: M0 of several times the torques"] = [
        drawn(5, 0.02, imbalance=share * 0.06 * 0.15 * G) for share in (2.8, 3.0, 3.1, 3.7, 4.2)
    ]
    found["counts: ever more noise"] = [late(drawn(5, noise), np.arange(9) < 3, [2.0])[0]
                                        for noise in np.geomspace(0.1, 12, 30)]  # fmt: skip
    weights = tuple(0.01 * k for k in range(2, 15))
    several = [drawn(6, 0.1, weights=weights[:number], rpm=(300.0,)) for number in (11, 12, 13)]
    found["counts: many torques"] = [late(one, one.torque == one.torque.min(), [2.0])[0] for one in several]
    return found


def never_settled(seed: int) -> Measurements:
    """Draw a lab in which with some runs left out others are odd, and so on round."""
    random = np.random.default_rng(seed)
    measured = lab(random, noise=0.3 * random.uniform(0.5, 3), repeats=1 + seed % 2)
    count = len(measured.runs)
    some, factor = random.integers(1, count // 3 + 2), np.ones(count)
    which = random.choice(count, some, replace=False)
    factor[which] *= 1 + random.uniform(0.02, 0.12, some) * random.choice([-1, 1], some)
    return replace(measured, time=measured.time * factor)


def loosely_drawn(seed: int) -> Measurements:
    """Draw a lab that scatters as it likes, and up to two runs of it far off."""
    random = np.random.default_rng(seed)
    rpm = (200.0, 400.0, 600.0) if seed % 2 else (200.0, 500.0)
    measured = lab(random, noise=random.uniform(0.3, 3), rpm=rpm)
    count = len(measured.runs)
    factor, some = np.ones(count), random.integers(0, 3)
    which = random.choice(count, some, replace=False)
    factor[which] *= 1 + random.uniform(0.02, 0.3, some) * random.choice([-1, 1], some)
    return replace(measured, time=measured.time * factor)


def every_slip_found(name: str) -> list[list[float]]:
    """Tell of each lab of one of `slips` which runs are odd, or which counts explain it."""
    rows = []
    for measured in slips()[name]:
        if name.startswith("counts"):
            row = [value for one in explaining_counts(measured) for pair in one.items() for value in pair]
        else:
            odd, result = screen(measured)
            row = [number for one in odd for number in (one.index, one.deviation, one.turns or 0.0, one.slip)]
            row.append(1e3 * result.inertia.value if result else 0.0)
        rows.append([float(f"{number:.9g}") for number in row])
    return rows


def quantity(measured: Any, name: str) -> Any:
    """Readings of a quantity; the name of a torque that is read is not that of the whole torque."""
    return measured.given_torque if name == "torque" else getattr(measured, name)


def left_out(measured: Any, tilted: bool) -> FitResult | None:
    """Fit without the last run; None where the others tell nothing."""
    try:
        return fit(measured, tilted, left_out=[len(measured.runs) - 1])
    except (NoFit, ValueError):
        return None


def told_by(result: FitResult) -> dict[str, Any]:
    """All numbers of a fit, those of one unit together."""
    adjusted, posterior = result.adjusted, result.posterior
    covariance = result.covariance
    told: dict[str, Any] = {name: in_one(getattr(result, name)) for name in ("inertia", "imbalance", "timing_bias")}
    # What is 0 but for rounding is nothing beside the two widths.
    pairs = [(i, j) for i in range(3) for j in range(i + 1)]
    told |= {f"covariance {i}{j}": [covariance[i, j], math.sqrt(covariance[i, i] * covariance[j, j])] for i, j in pairs}
    several = ("fitted_time", "time_u", "deviations", "influence", "response", "sense")
    told |= {name: one_or_more(getattr(result, name)) for name in several}
    told["widths"] = [result.balance_u, result.contradicted_balance or 0.0]
    told["chi2"] = [result.chi2, result.dof, adjusted.chi2, result.scatter, result.two_signs, adjusted.converged]
    told["shares, largest first"] = [share.share for share in result.budget]
    for share in result.budget:
        told[f"u from {share.source}"] = [share.u_inertia]
        told[f"share of {share.source}, {share.shared_by or 'alone' if not share.shared else 'shared'}"] = [share.share]
    told |= {name: one_or_more(getattr(adjusted, name)) for name in ("directions", "weighted", "own", "gain", "shared")}
    if posterior is not None:
        told |= {f"mean {k}": [mean, posterior.quantiles(3)[k, 3]] for k, mean in enumerate(posterior.middle())}
        told["evidence"] = [posterior.evidence, posterior.typical(posterior.factor)]
        told["width"] = [posterior.typical(posterior.width)]
    return told


def in_one(estimate: Estimate) -> list[float]:
    """An estimate with its u, and its interval where it has one."""
    return [estimate.value, estimate.u or 0.0, *(estimate.interval_95 or ())]


def one_or_more(values: Any) -> Any:
    """Numbers of all runs; of very many a few sums that none of them can leave."""
    values = np.ravel(values)
    return values if len(values) < 30 else values @ np.cos(np.outer(np.arange(len(values)), (0.0, 1.0, 2.5)))
