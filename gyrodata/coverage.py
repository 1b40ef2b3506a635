"""Is the answer to be trusted? This very lab, simulated many times, with the answers known.

The lab's own design, its fitted values as the truth and its own stated uncertainties make new readings; the
recommended fit and those of the textbook are applied to each. How often the true I_zz lies in the interval
they quote is what their uncertainty is worth. Labs with the stated uncertainties cannot show what becomes of the
intervals where those are wrong: where the log's own runs scatter otherwise, labs that scatter so are simulated too.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from typing import Any, Literal

import numpy as np
from msgspec import Struct, to_builtins
from msgspec.structs import replace

from gyrodata import physics
from gyrodata.errors import insist_on_type
from gyrodata.fitting import TEXTBOOK, FitResult, NoFit, fit, torques_differ, transverse_inertia
from gyrodata.measurements import Measurements
from gyrodata.physics import Floats

_CHUNK = 50
"""Labs simulated at a time: progress is shown after each."""

DOUBTED = 0.025
"""The log's scatter is not what is stated where the chance that it is no larger, or no smaller, is below this."""


class Performance(Struct, frozen=True):
    """What one way to fit makes of the simulated labs that it answers; None if it gives no answer or no uncertainty."""

    name: str
    """"recommended", "through_origin", "with_constant" or "mean_of_ratios"."""
    bias: float | None
    """Mean of I_zz over the true one, minus 1 [1]."""
    rmse: float | None
    """Root mean square of the same [1]."""
    coverage_68: float | None
    """Part of the labs whose 68.3 % interval holds the true I_zz: between the quantiles for the recommended fit, value
    ± u for the others; 0.683 if it is honest."""
    coverage_95: float | None
    """The same for the 95 % interval of the recommended fit, 0.950 if it is honest, and for value ± 2u of the others,
    0.954."""
    mean_u: float | None
    """Mean quoted standard uncertainty over the true I_zz [1]."""
    time_us: float
    """Time for one lab [µs]."""
    refused: int = 0
    """Labs without an answer, which no other number here counts: the fit is refused, or a time is not above zero."""


class SelfCheck(Struct, frozen=True):
    """A lab's fits, tried out on simulated labs like it."""

    labs: int
    """How many were simulated."""
    estimators: tuple[Performance, ...]
    """In labs with the uncertainties as stated, or as assumed where the log states none."""
    scatter: float
    """Factor on the errors that each run has alone, as the log's own runs show it [1]."""
    estimators_with_scatter: tuple[Performance, ...] | None
    """In labs whose runs scatter as this log's do; null where that is as stated."""
    schema: Literal["gyro.selfcheck/1"] = "gyro.selfcheck/1"

    def to_dict(self) -> dict[str, Any]:
        """Give it as the JSON contract has it."""
        return {"schema": self.schema, **to_builtins(self)}

    def to_text(self) -> str:
        """Give it as a table, or as two where the log does not scatter as stated."""
        labs = f"{self.labs} simulated labs like this one"
        if self.estimators_with_scatter is None:
            first = "this log's scatter agrees with what is stated"
            return "\n".join([first, "", *_table(f"{labs}, as stated", self.estimators), "", _LEGEND])
        return "\n".join(
            [
                f"this log's scatter is {self.scatter:.2g} times what is stated: trust the first table",
                "",
                *_table(f"{labs}, with the scatter of this log", self.estimators_with_scatter),
                "",
                *_table(f"{labs}, if the scatter were as stated", self.estimators),
                "",
                _LEGEND,
            ]
        )


_LEGEND = "68 % and 95 %: the recommended fit's own intervals; of the others ± u and ± 2u (honest: 95.4)"


def _table(title: str, estimators: tuple[Performance, ...]) -> list[str]:
    lines = [
        f"{title}; all in % of the true I_zz",
        f"{'fit':<16}{'bias':>9}{'rmse':>9}{'quoted u':>10}{'68 % holds':>12}{'95 % holds':>12}{'µs a lab':>10}",
    ]
    for one in estimators:
        cells = (
            (one.bias, "+.3f", 9), (one.rmse, ".3f", 9), (one.mean_u, ".3f", 10),
            (one.coverage_68, ".1f", 12), (one.coverage_95, ".1f", 12),
        )  # fmt: skip
        told = "".join(f"{'-' if v is None else format(100 * v, how):>{wide}}" for v, how, wide in cells)
        lines.append(f"{one.name.replace('_', ' '):<16}{told}{one.time_us:>10.1f}")
    lines.append(f"{'honest':<16}{'':>28}{68.3:>12}{'95.0':>12}")
    lines += [
        f"{one.name.replace('_', ' ')}: {one.refused} of the labs have no answer (the fit is refused, or a simulated "
        "time is not above zero); the numbers are those of the others"
        for one in estimators
        if one.refused and (one.rmse is not None or one.name == "recommended")
    ]
    return lines


def selfcheck(
    measured: Measurements,
    clock: Callable[[], float] = time.process_time,
    labs: int = 1000,
    seed: int = 1,
    tilted: bool = False,
    progress: Callable[[int], None] | None = None,
) -> SelfCheck:
    """Simulate a lab many times and see what its fits are worth, as ``gyro selfcheck`` does.

    Parameters
    ----------
    measured : Measurements
        The n runs that have a say, such as ``lab.measurements``.
    clock : callable
        Gives seconds [s].
    labs : int
        How many are simulated.
    seed : int
        Of the random numbers.
    tilted : bool
        Eq. (8) with each run's pitch, not eq. (9).
    progress : callable, optional
        Told how many labs of a table are done.

    Returns
    -------
    SelfCheck

    Raises
    ------
    ValueError, TypeError
        If there is nothing to simulate.

    Notes
    -----
    True readings are those of the log, true I_zz and M0 the fitted ones; the timing bias is drawn from its prior, every
    error from its source. Labs without an answer are counted in `Performance.refused`.
    """
    insist_on_type("measured", measured, Measurements, "what was measured: lab.measurements")
    insist_on_type("labs", labs, int, "a number of labs")
    if labs < 1:
        raise ValueError(f"{labs} labs say nothing; pass 1 or more")
    found = fit(measured, tilted=tilted)

    def tried(scatter: float) -> tuple[Performance, ...]:
        return _tried(measured, found, scatter, tilted, labs, seed, clock, progress)

    return SelfCheck(labs, tried(1.0), found.scatter, tried(found.scatter) if _doubted(found) else None)


def _doubted(found: FitResult) -> bool:
    """Whether the runs deny that their scatter is as stated."""
    assert found.posterior is not None
    larger = float(found.posterior.weight[found.posterior.factor > 1].sum())
    return min(larger, 1 - larger) < DOUBTED


def _tried(
    measured: Measurements,
    found: FitResult,
    scatter: float,
    tilted: bool,
    labs: int,
    seed: int,
    clock: Callable[[], float],
    progress: Callable[[int], None] | None,
) -> tuple[Performance, ...]:
    """Apply every fit to labs whose runs scatter so many times as stated."""
    truth = found.inertia.value
    design = replace(measured, sense=found.sense, slowing=None)

    def recommended(readings: dict[str, Floats]) -> Floats:
        return _recommended(measured, readings, tilted)

    fits = {"recommended": recommended, **{name: _textbook(name) for name in TEXTBOOK}}
    answers: dict[str, list[Floats]] = {name: [] for name in fits}
    seconds = dict.fromkeys(fits, 0.0)
    done = 0
    for readings in _simulate(design, truth, found.residual_torque.value, scatter, tilted, labs, seed):
        done += len(readings["time"])
        possible = (readings["time"] > 0).all(axis=1)
        for name, apply in fits.items():
            ends = np.full((len(readings["time"]), 5), math.nan)
            begun = clock()
            if possible.any():
                ends[possible] = apply({quantity: values[possible] for quantity, values in readings.items()})
            seconds[name] += clock() - begun
            answers[name].append(ends)
        if progress is not None:
            progress(done)
    return tuple(
        _judge(name, np.concatenate(parts), truth, 1e6 * seconds[name] / labs) for name, parts in answers.items()
    )


def _judge(name: str, ends: Floats, truth: float, time_us: float) -> Performance:
    """Compare the answers of one way to fit, five ends of intervals a lab, with the truth."""
    answered = ends[np.isfinite(ends[:, 2])]
    refused = len(ends) - len(answered)
    if not len(answered):
        return Performance(name, None, None, None, None, None, time_us, refused)
    off = answered[:, 2] / truth - 1
    bias, rmse = float(off.mean()), math.sqrt(float(np.mean(off**2)))
    if not np.isfinite(answered).all():
        return Performance(name, bias, rmse, None, None, None, time_us, refused)
    one, two = (float(np.mean((answered[:, i] <= truth) & (truth <= answered[:, -1 - i]))) for i in (1, 0))
    mean_u = float((answered[:, 3] - answered[:, 1]).mean() / 2 / truth)
    return Performance(name, bias, rmse, one, two, mean_u, time_us, refused)


# --- the simulated labs -------------------------------------------------------------------------------------


def _simulate(
    design: Measurements, inertia: float, imbalance: float, scatter: float, tilted: bool, labs: int, seed: int
) -> Iterator[dict[str, Floats]]:
    """Draw labs in portions: readings by quantity, shape (labs, n), with "torque" that follows from them."""
    random = np.random.default_rng(seed)
    for begin in range(0, labs, _CHUNK):
        size = min(_CHUNK, labs - begin)
        residual = np.full(size, imbalance)
        bias = design.timing_bias_u * random.standard_normal(size)
        yield _draw(design, inertia, residual[:, None], bias[:, None], scatter, tilted, random)


def _draw(
    design: Measurements,
    inertia: float,
    imbalance: Floats,
    bias: Floats,
    scatter: float,
    tilted: bool,
    random: np.random.Generator,
) -> dict[str, Floats]:
    """Draw true times and put each source's errors on the readings; a group draws once."""
    across = transverse_inertia(design) if tilted else 0.0
    pitch = design.pitch if tilted else 0.0
    # The weight spins along.
    whole = inertia + design.added
    rate = np.abs(physics.precession_rate(design.torque + imbalance, design.sense * design.spin, whole, across, pitch))
    size = len(imbalance)
    truth = {
        "time": 2 * np.pi * design.turns / rate,
        "spin": design.spin,
        "turns": design.turns,
        "mass": design.mass,
        "position": design.position,
        "force": design.force,
        "torque": design.given_torque,
        "g": np.full(len(design.runs), design.g),
        "pitch": design.pitch,
        "added": np.broadcast_to(design.added, len(design.runs)),
    }
    readings = {name: np.broadcast_to(value, (size, len(design.runs))).copy() for name, value in truth.items()}
    for source in design.sources:
        if source.quantity not in readings:
            continue
        groups = source.groups
        drawn = random.standard_normal((size, groups.max(initial=0) + 1))[:, groups] * (groups >= 0)
        # As in the fit, what a run shares with no other is its own.
        runs = np.bincount(groups[groups >= 0], minlength=groups.max(initial=0) + 1)[groups]
        drawn *= np.where(runs == 1, scatter, 1.0)
        # Errors are in proportion to the true value, and several add up.
        readings[source.quantity] += (source.absolute + source.relative * truth[source.quantity]) * drawn
    readings["time"] += bias
    return readings


def _applied(readings: dict[str, Floats]) -> Floats:
    """Torque as a student works it out from the readings [N*m], shape (labs, n)."""
    mass, position, force = (readings[name] for name in ("mass", "position", "force"))
    if not np.isnan(mass).all():
        return mass * position * readings["g"]
    return readings["torque"] if np.isnan(force).all() else force * position


# --- the fits -----------------------------------------------------------------------------------------------


def _recommended(measured: Measurements, readings: dict[str, Floats], tilted: bool) -> Floats:
    """Quantiles of the recommended fit of each lab, shape (labs, 5); NaN if the fit is refused."""
    torque = _applied(readings)
    ends = np.full((len(torque), 5), math.nan)
    for i in range(len(torque)):
        names = ("time", "spin", "turns", "mass", "position", "force", "pitch", "added")
        one = {name: readings[name][i] for name in names}
        lab = replace(
            measured, **one, given_torque=readings["torque"][i], torque=torque[i], g=readings["g"][i, 0], slowing=None
        )
        try:
            posterior = fit(lab, tilted=tilted).posterior
        except NoFit:
            continue
        assert posterior is not None
        ends[i] = posterior.quantiles()[0]
    return ends


def _product_and_torque(readings: dict[str, Floats]) -> tuple[Floats, Floats]:
    """φ̇ψ̇ with the torque's sign and the torque, as a textbook plots them, shape (labs, n)."""
    torque = _applied(readings)
    product = 2 * np.pi * readings["turns"] / readings["time"] * readings["spin"]
    return np.where(torque < 0, -product, product), torque


def _textbook(name: str) -> Callable[[dict[str, Floats]], Floats]:
    """Give a fit of the textbook as a function of the readings: value −2u, −u, 0, +u and +2u, shape (labs, 5).

    One with a constant needs torques that differ.
    """

    def apply(readings: dict[str, Floats]) -> Floats:
        product, torque = _product_and_torque(readings)
        if name == "with_constant" and not torques_differ(torque[0]):
            return np.full((len(torque), 5), math.nan)
        value, u = TEXTBOOK[name](product, torque)
        steps = np.arange(-2, 3)
        # What has no u has a value.
        return value[:, None] + np.where(steps == 0, 0.0, steps * u[:, None])

    return apply
