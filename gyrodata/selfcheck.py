"""Is the answer to be trusted? This very lab, simulated many times, with the answers known.

The lab's own design, its fitted values as the truth and its own stated uncertainties make new readings; the
recommended fit and those of the textbook are applied to each. How often the true I_zz lies in the interval
they quote is what their uncertainty is worth.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from typing import Any, Literal

import numpy as np

from gyrodata import physics
from gyrodata.fitting import TEXTBOOK, fit, fit_many, torques_differ, transverse_inertia
from gyrodata.measurements import Measurements
from gyrodata.physics import Floats

_CHUNK = 500
"""Labs simulated at a time."""

Answer = tuple[Floats, Floats]
"""I_zz and its quoted standard uncertainty of each lab [kg*m^2], shape (labs,) each."""


@dataclass(frozen=True, slots=True)
class Performance:
    """What one way to fit makes of the simulated labs; None where it gives no answer or no uncertainty."""

    name: str
    """"recommended", "through_origin", "with_constant" or "mean_of_ratios"."""
    bias: float | None
    """Mean of I_zz over the true one, minus 1 [1]."""
    rmse: float | None
    """Root mean square of the same [1]."""
    coverage_68: float | None
    """Part of the labs whose value ± u holds the true I_zz; 0.683 if u is honest."""
    coverage_95: float | None
    """The same for value ± 2u; 0.954 if u is honest."""
    mean_u: float | None
    """Mean quoted standard uncertainty over the true I_zz [1]."""
    time_us: float
    """Time for one lab [µs]."""


@dataclass(frozen=True)
class SelfCheck:
    """A lab's fits, tried out on simulated labs like it."""

    labs: int
    """How many were simulated."""
    estimators: tuple[Performance, ...]
    schema: Literal["gyro.selfcheck/1"] = "gyro.selfcheck/1"

    def to_dict(self) -> dict[str, Any]:
        """Give it as the JSON contract has it."""
        estimators = [asdict(estimator) for estimator in self.estimators]
        return {"schema": self.schema, "labs": self.labs, "estimators": estimators}

    def to_text(self) -> str:
        """Give it as a table."""
        lines = [
            f"{self.labs} simulated labs like this one; all in % of the true I_zz",
            "",
            f"{'fit':<16}{'bias':>9}{'rmse':>9}{'quoted u':>10}{'± u holds':>11}{'± 2u holds':>12}{'µs a lab':>10}",
        ]
        for one in self.estimators:
            cells = (
                (one.bias, "+.3f", 9), (one.rmse, ".3f", 9), (one.mean_u, ".3f", 10),
                (one.coverage_68, ".1f", 11), (one.coverage_95, ".1f", 12),
            )  # fmt: skip
            told = "".join(f"{'-' if v is None else format(100 * v, how):>{wide}}" for v, how, wide in cells)
            lines.append(f"{one.name.replace('_', ' '):<16}{told}{one.time_us:>10.1f}")
        lines.append(f"{'an honest u':<16}{'':>28}{68.3:>11}{95.4:>12}")
        return "\n".join(lines)


def selfcheck(
    measured: Measurements,
    clock: Callable[[], float],
    labs: int = 4000,
    seed: int = 1,
    tilted: bool = False,
    progress: Callable[[int], None] | None = None,
) -> SelfCheck:
    """Simulate a lab many times and see what its fits are worth.

    `measured` has only the runs that have a say; `clock` gives seconds, as `time.perf_counter`; `progress` is told how
    many labs are done. True readings are those of the log, true I_zz and M0 the fitted ones; the timing bias is
    drawn from its prior, every error from its source.
    """
    if labs < 1:
        raise ValueError(f"{labs} labs say nothing; pass 1 or more")
    found = fit(measured, tilted)
    truth = found.inertia.value
    design = replace(measured, sense=found.sense)

    def recommended(readings: dict[str, Floats]) -> Answer:
        return _recommended(measured, readings, tilted)

    fits = {"recommended": recommended, **{name: _textbook(name) for name in TEXTBOOK}}
    answers: dict[str, list[Answer]] = {name: [] for name in fits}
    seconds = dict.fromkeys(fits, 0.0)
    done = 0
    for readings in _simulate(design, truth, found.imbalance.value, tilted, labs, seed):
        for name, apply in fits.items():
            begun = clock()
            answers[name].append(apply(readings))
            seconds[name] += clock() - begun
        done += len(readings["time"])
        if progress is not None:
            progress(done)
    whole = {name: np.concatenate(parts, axis=1) for name, parts in answers.items()}
    judged = (_judge(name, both[0], both[1], truth, 1e6 * seconds[name] / labs) for name, both in whole.items())
    return SelfCheck(labs, tuple(judged))


def _judge(name: str, values: Floats, u: Floats, truth: float, time_us: float) -> Performance:
    """Compare the answers of one way to fit with the truth."""
    off = values / truth - 1
    if not np.isfinite(off).all():
        return Performance(name, None, None, None, None, None, time_us)
    bias, rmse = float(off.mean()), math.sqrt(float(np.mean(off**2)))
    if not np.isfinite(u).all():
        return Performance(name, bias, rmse, None, None, None, time_us)
    one, two = (float(np.mean(np.abs(off) * truth <= k * u)) for k in (1, 2))
    return Performance(name, bias, rmse, one, two, float(u.mean() / truth), time_us)


# --- the simulated labs -------------------------------------------------------------------------------------


def _simulate(
    design: Measurements, inertia: float, imbalance: float, tilted: bool, labs: int, seed: int
) -> Iterator[dict[str, Floats]]:
    """Draw labs in portions: readings by quantity, shape (labs, n), with "torque" that follows from them."""
    random = np.random.default_rng(seed)
    for begin in range(0, labs, _CHUNK):
        size = min(_CHUNK, labs - begin)
        residual = np.full(size, imbalance)
        bias = design.timing_bias_u * random.standard_normal(size)
        yield _draw(design, inertia, residual[:, None], bias[:, None], tilted, random)


def _draw(
    design: Measurements, inertia: float, imbalance: Floats, bias: Floats, tilted: bool, random: np.random.Generator
) -> dict[str, Floats]:
    """Draw true times and put each source's errors on the readings; a group draws once."""
    across = transverse_inertia(design) if tilted else 0.0
    pitch = design.pitch if tilted else 0.0
    rate = np.abs(
        physics.precession_rate(design.torque + imbalance, design.sense * design.spin, inertia, across, pitch)
    )
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
    }
    readings = {name: np.broadcast_to(value, (size, len(design.runs))).copy() for name, value in truth.items()}
    for source in design.sources:
        if source.quantity not in readings:
            continue
        groups = np.array(source.groups)
        drawn = random.standard_normal((size, groups.max(initial=0) + 1))[:, groups] * (groups >= 0)
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


def _recommended(measured: Measurements, readings: dict[str, Floats], tilted: bool) -> Answer:
    """All labs at once where the design allows it, else one by one."""
    if measured.sense.all():
        ends = fit_many(measured, readings, tilted).inertia
        return ends[:, 2], (ends[:, 3] - ends[:, 1]) / 2
    torque = _applied(readings)
    results = []
    for i in range(len(torque)):
        names = ("time", "spin", "turns", "mass", "position", "force", "pitch")
        one = {name: readings[name][i] for name in names}
        lab = replace(measured, **one, given_torque=readings["torque"][i], torque=torque[i], g=readings["g"][i, 0])
        results.append(fit(lab, tilted).inertia)
    return np.array([r.value for r in results]), np.array([math.nan if r.u is None else r.u for r in results])


def _product_and_torque(readings: dict[str, Floats]) -> tuple[Floats, Floats]:
    """φ̇ψ̇ with the torque's sign and the torque, as a textbook plots them, shape (labs, n)."""
    torque = _applied(readings)
    product = 2 * np.pi * readings["turns"] / readings["time"] * readings["spin"]
    return np.where(torque < 0, -product, product), torque


def _textbook(name: str) -> Callable[[dict[str, Floats]], Answer]:
    """Give a fit of the textbook as a function of the readings; one with a constant needs torques that differ."""

    def apply(readings: dict[str, Floats]) -> Answer:
        product, torque = _product_and_torque(readings)
        if name == "with_constant" and not torques_differ(torque[0]):
            return np.full(len(torque), math.nan), np.full(len(torque), math.nan)
        return TEXTBOOK[name](product, torque)

    return apply
