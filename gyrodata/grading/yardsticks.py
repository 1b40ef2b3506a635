"""Compute the values with which a reported I_zz is compared.

They are fits of the student's own runs, values with known mistakes, and a reference.

There is more than one correct way to evaluate a student's runs: a line without or with
an intercept, the mean of M/(φ̇ψ̇), or the fit of gyro; with all runs, without outliers,
or without the unloaded run. Each is computed here, also with a mistake applied to the
readings. The reference is stated for each station or taken from the class, and so are
the uncertainties of the readings if a log does not state them.
"""

from __future__ import annotations

import itertools
import math
import re
import statistics
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, NamedTuple, TypeVar

import numpy as np
from msgspec import Meta, Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from gyrodata import fitting
from gyrodata.base.errors import Diagnostic, InputError, nearest
from gyrodata.grading.rubric_file import unfit
from gyrodata.judging.mistakes import Mistake, known_mistakes, list_mistakes
from gyrodata.measurements import Measurements
from gyrodata.measurements.checks import SIZES
from gyrodata.physics import RPM, Floats
from gyrodata.readings import (
    SHARED_UNCERTAINTIES,
    Column,
    Faults,
    Reading,
    Readings,
    read_reported,
    u_keys,
)
from gyrodata.readings.roles import CONSTANTS, UNCERTAINTIES
from gyrodata.readings.settings import Setting, read_settings
from gyrodata.reporting.values import inertia_text

if TYPE_CHECKING:
    from gyrodata.grading.submissions import Submission
    from gyrodata.grading.submissions.answers import Answers
    from gyrodata.results import FittedLog

Key = TypeVar("Key")
Log = TypeVar("Log")

TABLES: Mapping[str, Any] = tomllib.loads(
    Path(__file__).with_name("criteria.toml").read_text(encoding="utf-8")
)

FINEST, COARSEST = 0.005, 0.05
"""Smallest and largest u, as a share of I_zz, for the distance d. Two careful people
who round their intermediate results to three digits differ by up to 0.5 %; and if the
runs hardly determine I_zz, the arithmetic can still be correct."""


MOST_ROUNDING = 0.02
"""Largest error by rounding an answer that is forgiven, as a share of it: with fewer
digits, nobody can see whether the arithmetic is right."""


class OwnValue(Struct, frozen=True):
    """I_zz by one fit of the student's own runs."""

    # of `fits` in the tables, with ":all" or ":loaded" behind it if it uses other runs
    # than the analysis
    name: str
    value: float  # [kg*m^2]
    u: float | None  # standard uncertainty of this fit [kg*m^2]; None if it has none


def fit_words(name: str) -> str:
    """Describe a fit and its runs: "a line with an intercept, every run in it"."""
    fit, _, runs = name.partition(":")
    return str(TABLES["fits"][fit] + TABLES["runs"].get(runs, ""))


class OwnRuns(Struct, frozen=True, dict=True):
    """The n runs of one log, as the textbook fits need them."""

    product: Floats  # φ̇ψ̇ with the torque's sign [rad²/s²], shape (n,)
    torque: Floats  # [N*m], shape (n,)
    sets: tuple[tuple[str, NDArray[np.bool_]], ...]
    """Runs that are used, each shape (n,): "" for those of the analysis, "all",
    "loaded" for those with a weight."""
    accept: tuple[str, ...]  # fits that the course accepts
    recommended: OwnValue
    yardstick: float  # one unit of d, as a share of I_zz [1]

    def fits(
        self, product: Floats | float = 1.0, torque: Floats | float = 1.0
    ) -> list[OwnValue]:
        """Compute the accepted fits, with φ̇ψ̇ and M multiplied by these factors.

        The factors have the shape () or (n,).
        """
        fits = []
        for (suffix, used), name in itertools.product(self.sets, self.accept):
            if name == "recommended":
                fits += self._scaled(product, torque) if not suffix else []
            elif self._is_possible(name, suffix, used):
                x = (product * self.product)[used]
                y = (torque * self.torque)[used]
                with np.errstate(all="ignore"):
                    value, u = map(float, fitting.TEXTBOOK[name](x, y))
                known_u = u if math.isfinite(u) else None
                fits.append(OwnValue(f"{name}:{suffix}".rstrip(":"), value, known_u))
        return fits

    def _is_possible(self, name: str, suffix: str, used: NDArray[np.bool_]) -> bool:
        """Return whether a fit differs from others, and the runs determine it."""
        if name == "mean_of_ratios":
            return suffix != "loaded"
        return name != "with_constant" or fitting.torques_differ(self.torque[used])

    def _scaled(
        self, product: Floats | float, torque: Floats | float
    ) -> list[OwnValue]:
        """Scale the recommended fit, if the factor is the same in every run."""
        loaded = np.broadcast_to(torque, self.torque.shape)[self.torque != 0]
        if np.ndim(product) or np.ptp(loaded) > 1e-9 * abs(loaded[0]):
            return []
        factor = float(loaded[0] / product)
        best = self.recommended
        u = best.u and factor * best.u
        return [OwnValue("recommended", factor * best.value, u)]

    @cached_property
    def values(self) -> tuple[OwnValue, ...]:
        """Every accepted fit of the runs, without repeating equal values.

        If none of them is possible (an intercept, and one torque only), it is the
        recommended fit.
        """
        kept: list[OwnValue] = []
        for own in self.fits():
            is_new = not any(math.isclose(own.value, other.value) for other in kept)
            if is_new and math.isfinite(own.value) and own.value:
                kept.append(own)
        return tuple(kept) or (self.recommended,)


def own_runs(analysis: FittedLog, accept: Sequence[str]) -> OwnRuns:
    """Take the runs that a report is compared with from an analysis."""
    measured = analysis.measurements
    inertia = analysis.inertia
    kept = np.array([not run.left_out for run in analysis.run_table])
    all_runs = np.ones(len(kept), dtype=bool)
    others = {"all": all_runs, "loaded": kept & (measured.torque != 0)}
    sets = [("", kept)]
    for name, used in others.items():
        if not np.array_equal(used, kept):
            sets.append((name, used))
    product = analysis.fit.sense * np.abs(measured.product)
    best = OwnValue("recommended", inertia.value, inertia.u or None)
    u = _u_of_one_balance(analysis.fit)
    if analysis.readings.blocks:
        u = min(u, _u_of_one_day(analysis.readings))
    yardstick = min(max(u / abs(inertia.value), FINEST), COARSEST)
    return OwnRuns(
        product, measured.torque, tuple(sets), tuple(accept), best, yardstick
    )


def _u_of_one_balance(fit: fitting.FitResult) -> float:
    """Return u of I_zz if the balance does not differ between weights [kg*m^2].

    A balance that differs widens u, but does not make a wrong answer right.
    """
    u = fit.inertia.u or 0.0
    posterior = fit.posterior
    if posterior is None:
        return u
    least = posterior.level == posterior.level.min()
    weight = posterior.weight[least]
    mean = weight @ posterior.u[0, least] / weight.sum()
    return min(u, float(mean))


def _u_of_one_day(readings: Readings) -> float:
    """Return u of I_zz if the balance does not differ between days [kg*m^2]."""
    from gyrodata.analysis import fit_log
    from gyrodata.results import Options

    one_day = fit_log(replace(readings, blocks=()), Options())
    return _u_of_one_balance(one_day.fit)


def distance(reported: float, own: float, step: float, yardstick: float) -> float:
    """Return the distance of a reported value from a fit of the own runs [u].

    4.52e-3, with the step 0.01e-3, is 2.6 u from 4.40e-3 if u is 1 %: (0.12 - 0.005)
    over 0.044.

    `reported`, `own` [kg*m^2]. `step`: One step of the last digit reported [kg*m^2];
    half of it may be rounding, and is subtracted, but `MOST_ROUNDING` of the value at
    most. `yardstick`: u as a share of the value [1].
    """
    apart = abs(reported - own)
    size = max(abs(reported), abs(own))
    # A value that rounds to zero is not a value.
    half_step = step / 2 * (1 + 1e-9)
    most = MOST_ROUNDING * size
    rounding = min(half_step, most) if reported else 0.0
    if rounding > FINEST * size:
        # Rounding does not explain an answer that is much farther off, however few
        # digits it has.
        share = 3.0 - apart / most
        rounding *= min(1.0, max(0.0, share))
    unit = yardstick * abs(own)
    return max(0.0, apart - rounding) / unit


# --- known slips: a reported I_zz that would be right without one common mistake ---
#
# Each mistake is applied to the student's own readings, and the accepted fits are
# computed again. If the reported value then agrees, the mistake is named. Mistakes with
# nearly the same factor (no g: 9.81, rpm as rad/s: 9.55) explain it equally well, and
# all are named. No mistake is searched for if the runs explain the report. A mistake
# whose result is among the results of honest fits cannot be detected, and is not named.

FROM = 3.0  # no slip is searched for if an accepted fit is nearer than this [u]

WITHIN = 2.0  # largest distance from the report [u] at which a mistake explains it

SLIP_U = 0.01
"""Largest u, as a share, for the distance from a slip: with a larger one, many answers
agree by chance."""

# largest relative distance, even if u is larger: 60 instead of 57.3 are two slips
NEAREST = 0.015

# slips whose distances differ by less than this [u] explain the report equally well
AS_GOOD = 0.5

# common slips are compared more closely: an answer has the digits of one of them [u]
COMMON_AS_GOOD = 0.2

# slips whose factors differ by less than this share differ only by the units of the log
SAME = 1e-3

MOST = 3  # slips that are named


class Slip(Struct, frozen=True):
    """A known mistake that explains a reported value."""

    kind: str  # stable name: "rpm_as_rad_s"
    words: str  # the mistake in words
    check: str  # how to check it, in words
    factor: float  # reported value over the value of the same fit without the slip [1]
    # the accepted fit with the slip that agrees with the report, a name as in
    # `OwnValue`
    fit: str
    u: float | None
    """Standard uncertainty of this fit with the slip [kg*m^2]; a slip that differs
    between runs scatters the points."""
    distance: float  # of the report from that fit [u]


def find_slips(
    reported: float,
    step: float,
    own: OwnRuns,
    readings: Readings,
    measured: Measurements,
) -> list[Slip]:
    """Name the slips that explain a reported I_zz, the most likely first.

    Parameters
    ----------
    reported, step : float
        The value, and one step of its last digit [kg*m^2].
    own : OwnRuns
        The accepted fits of the student's own runs.
    readings, measured
        The log.

    Returns
    -------
    list of Slip
        Several if they explain it equally well; empty if the runs explain the report,
        or no known slip does.
    """
    honest = [
        distance(reported, own_fit.value, step, own.yardstick) for own_fit in own.values
    ]
    if min(honest) <= FROM:
        return []
    ranked = []
    for kind in possible_mistakes(own, readings, measured).values():
        fits = with_mistake(kind, own)
        fits.sort(key=lambda own_fit: abs(own_fit.value - reported))
        slips = (_slip(kind, fit, reported, step, own) for fit in fits)
        nearest_slip = next(filter(None, slips), None)
        if nearest_slip is not None:
            ranked.append((kind.rank, nearest_slip))
    return _most_likely(ranked)


Ranked = list[tuple[int, "Slip"]]
"""Slips with their ranks: 0 for a mistake that the units of the log suggest."""


def _slip(
    kind: Mistake, fit: OwnValue, reported: float, step: float, own: OwnRuns
) -> Slip | None:
    """Return a mistake if a fit with it explains the answer."""
    plain = {own_fit.name: own_fit.value for own_fit in own.values}
    if not fit.value or fit.name not in plain:
        return None
    yardstick = min(own.yardstick, SLIP_U)
    away = distance(reported, fit.value, step, yardstick)
    # A value among honest answers cannot be separated from them.
    reach = FROM * own.yardstick
    low = min(plain.values()) * (1 - reach)
    high = max(plain.values()) * (1 + reach)
    most = min(WITHIN, NEAREST / yardstick)
    if away > most or low <= fit.value <= high:
        return None
    factor = fit.value / plain[fit.name]
    away *= yardstick / own.yardstick
    return Slip(kind.kind, kind.words, kind.check, factor, fit.name, fit.u, away)


def _most_likely(ranked: Ranked) -> list[Slip]:
    """Return the slips that explain an answer equally well, the most likely first."""
    most = AS_GOOD + min((slip.distance for _, slip in ranked), default=0.0)
    ranked = [(rank, slip) for rank, slip in ranked if slip.distance <= most]
    ranked.sort(key=lambda item: (item[0], item[1].distance))
    common = [slip for rank, slip in ranked if rank == 0]
    named = [slip for rank, slip in ranked if _is_named(rank, slip, common)]
    return named[:MOST]


def _is_named(rank: int, slip: Slip, common: Sequence[Slip]) -> bool:
    """Return whether a slip is named; `common` is sorted by the distance."""
    if rank == 0:
        return slip.distance <= common[0].distance + COMMON_AS_GOOD
    # A mistake suggested by the log's units comes before one with only the same factor.
    ratios = (other.factor / slip.factor for other in common)
    return all(abs(ratio - 1) >= SAME for ratio in ratios)


def with_mistake(kind: Mistake, own: OwnRuns) -> list[OwnValue]:
    """Compute the accepted fits of runs with a mistake."""
    if kind.kind != "inverse_slope":
        return own.fits(kind.product, kind.torque)
    inverse = []
    for own_fit in own.values:
        value = own_fit.value
        u = own_fit.u and own_fit.u / value**2
        inverse.append(OwnValue(own_fit.name, 1 / value, u))
    return inverse


def possible_mistakes(
    own: OwnRuns, readings: Readings, measured: Measurements
) -> dict[str, Mistake]:
    """List every mistake that the arithmetic can contain for a log, by its kind."""
    possible = [
        mistake
        for mistake in list_mistakes(readings, measured, own.recommended.value)
        if mistake.words
    ]
    return {
        mistake.kind: mistake
        for mistake in (*possible, known_mistakes()["inverse_slope"])
    }


def corrected(readings: Readings, kind: Mistake) -> Readings:
    """Return a log without a mistake, and with a warning of it."""
    columns = dict(readings.columns)
    if kind.kind == "exchanged":
        spin = _changed(columns["time"], RPM, "rpm")
        time = _changed(columns["spin"], 1 / RPM, "s")
        columns["spin"] = replace(spin, role="spin")
        columns["time"] = replace(time, role="time")
    else:
        role, factor = _wrong_column(kind)
        roles = ("spin", "spin_start", "spin_end") if role == "spin" else (role,)
        meant = "" if role == "turns" else kind.meant
        for role in columns.keys() & roles:
            columns[role] = _changed(columns[role], factor, meant)
    warning = Diagnostic.named(
        "log_contradicts_answer", readings.name, what=kind.log, remedy=kind.remedy
    )
    diagnostics = (*readings.diagnostics, warning)
    return replace(readings, columns=columns, diagnostics=diagnostics)


def _wrong_column(kind: Mistake) -> tuple[str, Any]:
    """Return the role of the wrong column, and the factor that corrects it."""
    is_load_right = np.all(np.asarray(kind.torque) == 1)
    role = kind.column or ("turns" if is_load_right else "position")
    if role == "time":
        return role, kind.product
    is_of_product = role in ("spin", "turns")
    return role, 1 / (kind.product if is_of_product else kind.torque)


def _changed(column: Column, factor: Any, unit: str) -> Column:
    """Multiply the readings of a column; `unit`: the right one, or "" for the same."""
    factors = np.broadcast_to(factor, len(column.readings)).tolist()
    cells = map(_times, column.readings, factors)
    return replace(column, unit=unit or column.unit, readings=tuple(cells))


def _times(reading: Reading, factor: float) -> Reading:
    """Multiply a reading, its step and its uncertainty."""
    u = reading.u
    if u:
        u = replace(u, absolute=factor * u.absolute)
    value = reading.value and factor * reading.value
    step = reading.step and factor * reading.step
    return replace(reading, value=value, step=step, u=u)


def unusual(readings: Readings) -> int:
    """Count the quantities of a log with a very unusual reading."""
    count = 0
    for role in SIZES.keys() & readings.columns.keys():
        low, high = SIZES[role].usual
        values = readings.columns[role].values
        count += any(not low <= abs(value) <= high for value in values if value)
    return count


# --- references of stations ---


VAGUE = 0.25  # a reference with a larger u, as a share of it, is of several gyroscopes


class Reference(Struct, frozen=True, dict=True):
    """The value that a station's gyroscope should give."""

    inertia: float  # [kg*m^2]
    u: float  # standard uncertainty [kg*m^2]
    source: str  # its origin, in words

    @property
    def is_vague(self) -> bool:
        """Whether the logs behind it are of gyroscopes with several values."""
        return self.u > VAGUE * abs(self.inertia)

    @cached_property
    def words(self) -> str:
        """The value and its origin."""
        if self.is_vague:
            return f"no value, because the logs differ ({self.source})"
        value = inertia_text(self.inertia, self.u or None)
        return f"{value} ({self.source})"

    def zeta(self, value: float, u: float) -> float:
        """Return the distance of a value from the reference, over the u of both [1].

        The value and its u are in [kg*m^2].
        """
        u_of_both = math.hypot(u, self.u) or 1e-9 * abs(self.inertia)
        return abs(value - self.inertia) / u_of_both


def station_key(text: str) -> str:
    """Write the name of a station in one form: "Bench A" is "bench a"."""
    return " ".join(text.split()).casefold()


def of_station(table: Mapping[str, Log], station: str | None) -> Log | None:
    """Return the entry of a station, or else that of all stations."""
    return table.get(station or "all", table.get("all"))


def in_order(station: str) -> str:
    """Return a key that sorts stations by their numbers: "2" before "10"."""
    return re.sub(r"\d+", lambda number: number[0].zfill(9), station)


class Station(Struct, frozen=True, forbid_unknown_fields=True):
    """The reference of a station, as a rubric states it."""

    HINT: ClassVar = (
        "head the values of station 3 with [reference.3], those of all stations with "
        "[reference.all]"
    )
    inertia: Annotated[str, Meta(examples=["4.44e-3 kg m^2"])]
    u: Annotated[str, Meta(examples=["1 %"])]

    def __post_init__(self) -> None:
        self.reference("")

    def reference(self, source: str) -> Reference:
        """Return the values in SI; `source`: the origin in words."""
        read = read_reported("inertia", f"{self.inertia} ± {self.u}")
        if read.problem or read.u is None or not read.value or read.value < 0:
            problem = read.problem or f'"{read.text}" is not above zero'
            raise unfit("reference_unclear", "inertia", problem=problem)
        return Reference(read.value, read.u, source)


def by_station(
    logs: Iterable[tuple[str | None, Log]], enough: int
) -> dict[str, list[Log]]:
    """Group logs by stations with at least `enough` logs; "all" has every log.

    [("3", a), ("3", b), (None, c)] with 2 gives {"3": [a, b], "all": [a, b, c]}.
    """
    every = []
    named = []
    for station, log in logs:
        every.append(log)
        if station not in (None, "", "all"):
            named.append((station, log))
    groups = {"all": every} if every else {}
    groups |= {
        name: some for name, some in grouped(named).items() if len(some) >= enough
    }
    return dict(sorted(groups.items()))


def grouped(pairs: Iterable[tuple[Key, Log]]) -> dict[Key, list[Log]]:
    """Group people or logs: [(1, a), (2, b), (1, c)] gives {1: [a, c], 2: [b]}."""
    groups: dict[Key, list[Log]] = {}
    for key, log in pairs:
        groups.setdefault(key, []).append(log)
    return groups


# --- the bench: uncertainties and constants that a log does not state ---

APPARATUS = (*CONSTANTS, "weight_diameter", "transverse_inertia", "motion")
BENCH = (*UNCERTAINTIES, *APPARATUS)
"""Lines of a log that a rubric may contain, for logs without them."""


def check_bench(lines: Mapping[str, str]) -> None:
    """Read each value of ``[bench]`` as a line of a log is read.

    Raise UnfitError for one that cannot be used.
    """
    for key, text in lines.items():
        if key not in ("from", *BENCH):
            hint = nearest(key, BENCH, "take it out")
            raise unfit("bench_key_unknown", "bench", key, key=key, hint=hint)
        settings = []
        if key != "from":
            settings.append(Setting(key, text, key, None))
        try:
            read_settings([], [], settings, Faults(""), True)
        except InputError as error:
            fault = error.diagnostics[0]
            values = {"problem": fault.message, "hint": fault.hint}
            raise unfit("bench_value_unfit", "bench", key, **values) from None


class AtBench(NamedTuple):
    """A log with what the rubric says of its bench."""

    readings: Readings
    answers: Answers
    added: tuple[
        str, ...
    ]  # lines of ``[bench]`` for what the log does not state: "u_time 0.3 s"


def at_bench(submission: Submission, lines: Mapping[str, str]) -> AtBench:
    """Read a log, and complete it with the `lines` of ``[bench]``.

    The lines are used if the log does not state a value, or states it far over the
    usual.
    """
    readings, answers = submission.read()
    of_columns = {key for role in readings.columns for key in u_keys(role)}
    known = {*APPARATUS, *SHARED_UNCERTAINTIES, *of_columns}
    stated = _stated_in(readings)
    missing = {}
    for key, text in lines.items():
        names = (key, *u_keys(key.removeprefix("u_")))
        if key in known and stated.isdisjoint(names):
            missing[key] = " ".join(text.split())
    if missing:
        readings, answers = submission.read(missing)
    added = tuple(f"{key} {text}" for key, text in missing.items())
    return AtBench(readings, answers, added)


def _stated_in(readings: Readings) -> set[str]:
    """Return the keys of all values and uncertainties that a log states."""
    keys = {*readings.constants, *readings.columns, *readings.uncertainties}
    for role, column in readings.columns.items():
        keys.update(u_keys(role) if column.stated else ())
    if readings.motion:
        keys.add("motion")
    # g follows from the latitude, and a test of the balance is better than its usual
    # uncertainty.
    if "latitude" in readings.constants:
        keys.add("g")
    is_tested = readings.balance_tilt or readings.balance_drift
    if is_tested or readings.balanced is not None:
        keys.add("u_imbalance")
    return keys


ENOUGH = 8  # logs from which the scatter of a class is estimated

ROUGHEST = (
    3.0  # a larger factor of a log is reduced to this, because such a log may be wrong
)

PLAIN = 1.2  # a smaller factor is the usual scatter


class BenchScatter(Struct, frozen=True):
    """The scatter of the readings of a class or of a station."""

    factor: float  # over the usual scatter [1]; 1 if it is not larger
    logs: int  # number of logs that do not state the uncertainty of their times
    whose: str  # in words

    @property
    def words(self) -> str:
        """Describe the scatter."""
        logs = f"the {self.logs} logs of {self.whose}"
        return f"{logs} scatter {self.factor:.2g} times as much as usual"


def class_scatter(
    logs: Iterable[tuple[str | None, Sequence[tuple[float, int]]]],
) -> dict[str, BenchScatter]:
    """Return the scatter of each station with at least `ENOUGH` logs.

    The key "all" is for every other station.

    `logs`: For each log its station (or None), and χ² of φ̇ψ̇ within each torque by the
    usual uncertainties with its degrees of freedom, in any order. The factor is the
    root mean square over the logs; no log counts as more than `ROUGHEST`, so that a few
    wrong logs do not change the result for all.
    """
    reduced = []
    for station, log in logs:
        if log:
            chi2, dof = map(sum, zip(*log, strict=True))
            reduced.append((station, min(chi2 / dof, ROUGHEST**2)))
    scatters = {}
    for name, squares in by_station(reduced, ENOUGH).items():
        count = len(squares)
        factor = math.sqrt(statistics.fmean(squares))
        if count < ENOUGH or factor <= PLAIN:
            factor = 1.0
        whose = "the class" if name == "all" else f"station {name}"
        scatters[name] = BenchScatter(factor, count, whose)
    return scatters
