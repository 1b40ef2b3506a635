"""Judge the criteria, with one function for each kind.

Each function returns a mark with the points and the reason.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Mapping, Sequence
from pathlib import PurePosixPath
from typing import TYPE_CHECKING

from msgspec import Struct, convert

from gyrodata.base import diagnostics
from gyrodata.base.errors import Diagnostic, shown
from gyrodata.fitting import chi2_tail, times_stated
from gyrodata.grading.yardsticks import (
    COARSEST,
    TABLES,
    BenchScatter,
    OwnRuns,
    OwnValue,
    Reference,
    Slip,
    fit_words,
)
from gyrodata.readings import Reported, listing
from gyrodata.reporting.values import (
    count_text,
    factor_text,
    inertia_range_text,
    inertia_text,
    p_text,
)

if TYPE_CHECKING:
    from gyrodata.grading.rubric import Criterion, Rubric
    from gyrodata.results import FittedLog

Detail = Mapping[str, float | str | None]
Scatters = Sequence[tuple[float, int]]
"""χ² of φ̇ψ̇ within each torque, and its degrees of freedom."""


class Mark(Struct, frozen=True):
    """The result of one criterion."""

    criterion: str  # its id
    title: str
    check: str  # kind of criterion
    points: float | None  # two decimals; None if the criterion could not be judged
    out_of: float
    reason: str  # what was found, to the student
    detail: Detail  # the numbers that the points follow from
    rule: str  # what earns all points and what earns none; "" if something else decided

    @property
    def waits(self) -> bool:
        """True if only a person or a reference is missing for the points."""
        can_be_given = self.check == "manual" or "value" in self.detail
        return self.points is None and can_be_given


class Evidence(Struct, frozen=True):
    """Everything that the criteria look at."""

    rubric: Rubric
    analysis: FittedLog
    lacks: list[Diagnostic]  # requirements of the procedure that the log does not meet
    own: OwnRuns
    reported: (
        Reported | None
    )  # I_zz as reported, its value in SI; None if there is none
    files: tuple[str, ...]  # names of all submitted files
    bench: tuple[
        str, ...
    ]  # uncertainties that the log has from the rubric, each in words
    matched: OwnValue | None = (
        None  # the accepted fit nearest to the report, after correcting a mistake
    )
    d: float = math.nan  # distance of the report, as reported, from that fit [u]
    slips: tuple[Slip, ...] = ()
    from_cells: bool = (
        False  # the report is in a workbook, whose numbers lose zeros at their ends
    )
    unread: tuple[str, ...] = ()  # in words, each file that cannot be read

    @property
    def factor(self) -> float:
        """The factor of a common mistake on I_zz; 1 without one."""
        return self.slips[0].factor if self.slips else 1.0

    @property
    def answer(self) -> tuple[Reported, float, OwnValue]:
        """The report, its value [kg*m^2], and the nearest fit, if there is a value."""
        assert (  # noqa: PT018
            self.reported is not None
            and self.reported.value is not None
            and self.matched is not None
        )
        return self.reported, self.reported.value, self.matched


def points_of(deduction: str | float, whole: float) -> float:
    """Read a deduction from `whole` points: "25 %" of 20 is 5, and 2 is 2."""
    if not isinstance(deduction, str):
        return deduction
    percent = float(deduction.rstrip(" %"))
    return percent / 100 * whole


def judge(criterion: Criterion, evidence: Evidence) -> Mark:
    """Judge one criterion; `judge_reference` gives the points of a reference."""
    reported = evidence.reported
    is_of_report = criterion.check in ("own_data", "reference", "uncertainty", "units")
    if is_of_report and evidence.matched is None:
        is_zero = reported is None and evidence.rubric.no_report == "zero"
        share = 0.0 if is_zero else None
        files = listing([PurePosixPath(file).name for file in evidence.files])
        reason = (
            f"no I_zz is reported: none is found in {shown(files)}; add a line to the "
            f"log: # reported_inertia: 4.4e-3 ± 0.1e-3 kg m^2"
        )
        if reported:
            problem = reported.problem or "it is not a number"
            reason = f"the reported I_zz cannot be read: {problem}"
        return mark(criterion, "; ".join([reason, *evidence.unread]), {}, share)
    return JUDGES[criterion.check](criterion, evidence)


def mark_by_rule(criterion: Criterion, reason: str, detail: Detail) -> Mark:
    """Return a mark with the share of the points that the conditions give.

    `detail` contains their variable: with full = "d <= 1" and zero = "d >= 3",
    {"d": 2.0} gives half of the points.
    """
    number = float(detail[criterion.curve.variable] or 0.0)
    return mark(criterion, reason, detail, criterion.curve.share(number))


def mark(
    criterion: Criterion, reason: str, detail: Detail, share: float | None
) -> Mark:
    """Return a mark with a share of the points, from 0 to 1.

    None if the criterion could not be judged.
    """
    points = None
    if share is not None:
        points = round(share * criterion.points, 2)
    is_by_rule = criterion.curve.variable in detail and "slip_cost" not in detail
    rule = criterion.rule if is_by_rule else ""
    return Mark(
        criterion.id,
        criterion.title,
        criterion.check,
        points,
        criterion.points,
        reason,
        detail,
        rule,
    )


# --- the log ---


def _log(criterion: Criterion, evidence: Evidence) -> Mark:
    read = (
        *evidence.analysis.readings.diagnostics,
        *evidence.analysis.measurements.diagnostics,
    )
    # A note costs nothing: students who write down what went wrong do the right thing.
    warnings = [diagnostic for diagnostic in read if diagnostic.severity == "warning"]
    no_doubt = diagnostics.NOTE_MAY_CHANGE_READING
    doubted = [warning for warning in warnings if warning.code != no_doubt]
    content = " read without warnings"
    if doubted:
        things = count_text(len(doubted), "thing")
        content = f", with {things} to correct: {_listed(doubted)}"
    runs = count_text(len(evidence.analysis.run_table), "run")
    reason = f"{runs}{content}"
    return mark_by_rule(criterion, reason, {"warnings": float(len(doubted))})


def _procedure(criterion: Criterion, evidence: Evidence) -> Mark:
    asked = {ASKS[ask] for ask in criterion.asks}
    missing = [lack for lack in evidence.lacks if lack.code in asked]
    reason = _listed(missing) or "nothing required is missing"
    return mark_by_rule(criterion, reason, {"missing": float(len(missing))})


MOST_LISTED = 3  # warnings, or requirements, that a reason quotes


def _listed(diagnostics: list[Diagnostic]) -> str:
    lines = []
    for diagnostic in diagnostics[:MOST_LISTED]:
        place = diagnostic.cell or f"line {diagnostic.line}"
        message = diagnostic.message
        lines.append(f"{place}: {message}" if diagnostic.line else message)
    left = len(diagnostics) - MOST_LISTED
    if left > 0:
        lines.append(f"and {left} more")
    return "; ".join(lines)


USUAL = "the usual uncertainties of such readings"
UNUSUAL = 0.05
"""A scatter with a smaller probability is not said to agree with the uncertainties."""


def scatter_of(analysis: FittedLog) -> tuple[tuple[float, int], ...]:
    """Return χ² of φ̇ψ̇ within each torque, and its degrees of freedom."""
    loaded = [group for group in analysis.torques if group.torque]
    both = [(group.product.chi2, group.runs - 1) for group in loaded]
    return tuple((chi2, dof) for chi2, dof in both if chi2 is not None)


def spread_of(analysis: FittedLog) -> float | None:
    """Return the largest standard deviation of φ̇ψ̇ at one torque over its mean.

    None if no torque has two runs.
    """
    largest = None
    for group in analysis.torques:
        product = group.product
        if group.torque and product.spread is not None:
            relative = product.spread / abs(product.value)
            largest = max(largest or 0.0, relative)
    return largest


def _constancy(criterion: Criterion, evidence: Evidence) -> Mark:
    spread = spread_of(evidence.analysis)
    if spread is None:
        reason = "no torque has two runs, so the log cannot show whether φ̇ψ̇ is constant"
        return mark(criterion, reason, {}, 0.0)
    words = USUAL
    if times_stated(evidence.analysis.measurements):
        words = "the uncertainties that your log states"
    if any(line.startswith(_OF_PRODUCT) for line in evidence.bench):
        words = "the uncertainties that the rubric gives your bench"
    return _scatter_mark(criterion, spread, scatter_of(evidence.analysis), words, 1.0)


_OF_PRODUCT = ("u_time ", "u_spin ", "u_turns ", "u_angle ", "u_precession")
"""Beginnings of lines with an uncertainty of φ̇ψ̇."""


def _scatter_mark(
    criterion: Criterion, spread: float, scatters: Scatters, words: str, factor: float
) -> Mark:
    """Judge the scatter of φ̇ψ̇, with uncertainties `factor` times as large."""
    variance = factor**2
    chances = [chi2_tail(chi2 / variance, dof) for chi2, dof in scatters]
    # The smallest of k probabilities, corrected for the number of torques (Šidák).
    p = 1.0
    if chances:
        smallest = min(*chances, 1 - 1e-15)
        p = -math.expm1(len(chances) * math.log1p(-smallest))
    reason = f"φ̇ψ̇ scatters by {100 * spread:.2g} % at most within a torque"
    if criterion.curve.variable == "p":
        agrees = "agrees with"
        if p < UNUSUAL:
            agrees = "is more than"
        if p < UNUSUAL and criterion.curve.share(p) == 1:
            agrees = "is not clearly more than"
        reason += f", which {agrees} {words} ({p_text(p)})"
    return mark_by_rule(criterion, reason, {"p": p, "spread": spread, "factor": factor})


def judge_scatter(
    criterion: Criterion, before: Mark, scatters: Scatters, scatter: BenchScatter
) -> Mark:
    """Judge constancy by the scatter of the class, for logs without uncertainties."""
    spread = before.detail.get("spread")
    is_judged = before.detail.get("factor") == scatter.factor
    if not scatters or not isinstance(spread, float) or is_judged:
        return before
    words = USUAL
    if scatter.factor > 1:
        words += f", {scatter.factor:.2g} times as large: {scatter.words}"
    return _scatter_mark(criterion, spread, scatters, words, scatter.factor)


PICTURES = (
    ".png",
    ".jpg",
    ".jpeg",
    ".gif",
    ".svg",
    ".webp",
    ".heic",
    ".tif",
    ".tiff",
    ".pdf",
)  # may contain a plot


def _files(criterion: Criterion, evidence: Evidence) -> Mark:
    pictures = sum(name.lower().endswith(PICTURES) for name in evidence.files)
    reason = "no picture and no PDF that could show a plot"
    if pictures:
        reason = f"{count_text(pictures, 'file')} that may show a plot"
    return mark_by_rule(criterion, reason, {"files": float(pictures)})


# --- the report ---


def _away(
    criterion: Criterion, evidence: Evidence, is_corrected: bool = False
) -> float:
    """Return the distance of the report from the student's own runs.

    The distance has the form that a condition of the rubric uses. `is_corrected`: That
    of the report after correcting its mistake.
    """
    _, value, matched = evidence.answer
    factor = evidence.factor if is_corrected else 1.0
    if criterion.curve.variable == "percent":
        corrected = value / factor
        percent = 100 * (corrected / matched.value - 1)
        return abs(percent)
    if is_corrected and evidence.slips:
        return evidence.slips[0].distance
    return evidence.d


def _own_data(criterion: Criterion, evidence: Evidence) -> Mark:
    reported, value, matched = evidence.answer
    reported_words = f"you report {inertia_text(value, reported.u)}"
    own_value = inertia_text(matched.value, matched.u)
    own = f"{own_value} ({fit_words(matched.name)})"
    times = factor_text(value / matched.value)
    d = evidence.d
    if evidence.slips:
        d = evidence.slips[0].distance
    number = _away(criterion, evidence)
    detail: dict[str, float | str | None] = {
        "d": evidence.d,
        "d_carried": d,
        "own": matched.value,
    }
    detail |= {"matched": matched.name, criterion.curve.variable: number}
    share = criterion.curve.share(number)
    if evidence.slips:
        detail["slip"] = evidence.slips[0].kind
        cost = points_of(criterion.slip or 0.0, criterion.points)
        carried = criterion.curve.share(_away(criterion, evidence, is_corrected=True))
        less = carried - cost / (criterion.points or 1.0)
        if less > share:
            share = less
            detail["slip_cost"] = cost
        words = "; or ".join(slip.words for slip in evidence.slips)
        either = "a common mistake"
        if len(evidence.slips) > 1:
            either = "either of these"
        reason = f"{reported_words}, {times} what your runs give, {own}: "
        reason += f"{either} would explain this: {words}"
    elif d == 0:
        reason = f"{reported_words}, which agrees with your runs: {own}"
    else:
        far = f", {d:.2g} u away" if d <= 30 else f": yours is {times} that"
        reason = f"{reported_words}; your runs give {own}{far}"
    return mark(criterion, reason, detail, share)


def _reference(criterion: Criterion, evidence: Evidence) -> Mark:
    _, reported, matched = evidence.answer
    # The corrected value is judged if own_data charges for the mistake.
    criteria = evidence.rubric.criteria
    charging = [other for other in criteria if other.check == "own_data"]
    factor = evidence.factor if charging else 1.0
    value = reported / factor
    # The reported u is not used: a very large ± would agree with everything. For the
    # same reason u has a maximum: runs that say nothing about I_zz would agree with any
    # value.
    u_of_runs = max(evidence.analysis.inertia.u or 0.0, matched.u or 0.0)
    u = min(u_of_runs, COARSEST * abs(value))
    detail: dict[str, float | str | None] = {"value": value, "u": u, "slip": factor}
    shares = (other.curve.share(_away(other, evidence)) for other in charging)
    if not evidence.slips and min(shares, default=1.0) < 1:
        # A mistake without a name costs the points of own_data alone: the measurement
        # may still be right.
        detail["own"] = matched.value
    return mark(criterion, "the reference is not known yet", detail, None)


NO_STATION = "the log names no station (# station: 3), or too few logs are of it"


def judge_reference(
    criterion: Criterion, pending: Mark, reference: Reference | None
) -> Mark:
    """Give the points of a "reference" criterion when the reference is known.

    `pending`: As `judge` returned it, with {"value": 4.5e-3, "u": 0.05e-3, …}; it stays
    as it is without a value. A reference of 4.4e-3 with u = 0 is 2 u away: the reason
    is "4.5… is 2 standard uncertainties from …", and z = 2 gives the points.
    """
    value = pending.detail.get("value")
    u = pending.detail.get("u")
    if not isinstance(value, float) or not isinstance(u, float):
        return pending
    if reference is None:
        reason = (
            "the rubric has no reference for this station; the station, or these "
            "points, can be given by hand"
        )
        return mark(criterion, reason, pending.detail, None)
    undone = ""
    if pending.detail.get("slip") != 1.0:
        undone = ", after correcting the mistake,"
    own = pending.detail.get("own")
    zeta = reference.zeta(value, u)
    if isinstance(own, float) and reference.zeta(own, u) < zeta:
        value = own
        zeta = reference.zeta(own, u)
        undone = ", which your runs give,"
    words = f"{inertia_text(value, None)}{undone}"
    detail = {
        **pending.detail,
        "reference": reference.inertia,
        "u_reference": reference.u,
        "z": zeta,
    }
    number = f"{zeta:.2g}"
    far = f"{number} standard uncertaint{'y' if number == '1' else 'ies'}"
    if criterion.curve.variable == "percent":
        percent = 100 * abs(value / reference.inertia - 1)
        detail["percent"] = percent
        two_digits = float(f"{percent:.2g}")
        far = f"{two_digits:g} %"
    reason = f"{words} is {far} from {reference.words}"
    if reference.is_vague:
        reason = f"{words} has no reference: {NO_STATION}"
    return mark_by_rule(criterion, reason, detail)


# relative difference of an uncertainty that is rounded to one digit, from another
# computation
ROUNDED = 0.3
TWO_DIGITS = 0.05
"""Relative difference of an uncertainty that is rounded to two digits."""


def _uncertainty(criterion: Criterion, evidence: Evidence) -> Mark:
    reported = evidence.answer[0]
    if criterion.curve.variable == "stated":
        is_stated = reported.u is not None
        verb = "states" if is_stated else "does not state"
        reason = f'"{reported.text}" {verb} an uncertainty'
        return mark_by_rule(criterion, reason, {"stated": float(is_stated)})
    if reported.u is None:
        reason = "no uncertainty is reported; write it after the value: "
        reason += "4.4e-3 ± 0.1e-3 kg m^2"
        return mark(criterion, reason, {}, 0.0)
    u = reported.u / abs(evidence.factor)
    low, high = _u_of_fits(evidence)
    ratio = min(u / low, max(1.0, u / high))
    spread = _spread_of_weights(evidence.analysis)
    is_of_weights = abs(u - spread) < ROUNDED * spread
    if is_of_weights or abs(ratio - 1) < TWO_DIGITS:
        ratio = 1.0
    whole = inertia_range_text(low, high)
    reason = f"± {inertia_range_text(reported.u, reported.u)}"
    if evidence.slips:
        reason += f", {inertia_range_text(u, u)} after correcting the mistake,"
    if ratio == 1:
        reason += f" agrees with your runs, whose fits give {whole}"
    else:
        side, end = ("large", "largest") if ratio > 1 else ("small", "smallest")
        is_accepted = criterion.curve.share(ratio) == 1
        verdict = "a little" if is_accepted else "too"
        reason += f" is {verdict} {side}: {factor_text(ratio)} the {end} that the fits"
        reason += f" of your runs give, {whole}"
    detail = {"ratio": ratio, "u": u, "u_low": low, "u_high": high}
    return mark_by_rule(criterion, reason, detail)


def _u_of_fits(evidence: Evidence) -> tuple[float, float]:
    """Return the smallest and the largest u of the accepted fits [kg*m^2]."""
    own = evidence.own
    known = [value.u for value in own.values if value.u]
    for slip in evidence.slips[:1]:
        # A mistake that differs between runs may scatter the points so much that u says
        # nothing.
        u = (slip.u or 0.0) / abs(slip.factor)
        if 0 < u < abs(own.values[0].value):
            known.append(u)
    if not known:
        known.append(own.yardstick * abs(own.values[0].value))
    return min(known), max(known)


def _spread_of_weights(analysis: FittedLog) -> float:
    """Return u of the mean of one I_zz for each weight [kg*m^2], which may be small.

    Students also take this mean.
    """
    loaded = [group for group in analysis.torques if group.torque]
    each = [abs(group.torque / group.product.value) for group in loaded]
    if len(each) < 2:
        return 0.0
    return statistics.stdev(each) / math.sqrt(len(each))


def _units(criterion: Criterion, evidence: Evidence) -> Mark:
    reported, value, _ = evidence.answer
    if not value:
        reason = f'"{reported.text}" rounds the value to zero: it has no digit'
        return mark(criterion, reason, {"faults": 2.0}, 0.0)
    u_digits = _digits_of_u(reported)
    # A formula in a cell has all digits of the computer; its student has typed none of
    # them.
    formula = evidence.from_cells and u_digits > 10
    faults = [reported.problem] if reported.problem else []
    if u_digits > 2 and not formula:
        faults.append(f"the uncertainty has {u_digits} digits; one or two are enough")
    if fault := _fault_of_last_digit(evidence):
        faults.append(fault)
    digits = "the right number of digits"
    if formula:
        digits = "its digits are those of a formula"
    reason = "; ".join(faults) or f'"{reported.text}" has its unit and {digits}'
    return mark_by_rule(criterion, reason, {"faults": float(len(faults))})


def _digits_of_u(reported: Reported) -> int:
    """Return the digits of the uncertainty; ± 0.102 with k = 2 is u = 0.051."""
    digits = reported.u_digits or 0
    if not reported.u or not reported.u_step:
        return digits
    steps = math.log10(reported.u / reported.u_step) + 1e-9
    return min(digits, math.floor(steps) + 1)


def _fault_of_last_digit(evidence: Evidence) -> str:
    """Say that the last digit of the value does not fit its uncertainty, or ""."""
    reported, value, _ = evidence.answer
    if not reported.step:
        return ""
    low, high = _last_place(reported.step, value, reported.digits)
    if not reported.u_step:
        u = reported.u or evidence.own.yardstick * abs(value)
        if high < u / 150:
            return "the value has more digits than its uncertainty justifies"
        return ""
    if not reported.u:
        return ""
    # A ± that was divided by its k has as many digits as before; its last place is at
    # most that of the first digit of u.
    u_low, u_high = _last_place(reported.u_step, reported.u, reported.u_digits)
    u_low = min(u_low, 10.0 ** math.floor(math.log10(reported.u)))
    if evidence.from_cells:
        # A cell does not show the zeros at its end.
        low = low / 100
        u_low = u_low / 10
    if max(low, u_low) <= 1.26 * min(high, u_high):
        return ""
    which = "finer" if high < u_low else "coarser"
    return (
        f"the value's last digit is {which} than that of its uncertainty: round both to "
        f"the same place"
    )


def _last_place(
    step: float | None, value: float | None, digits: int | None
) -> tuple[float, float]:
    """Return the smallest and the largest possible step of the last digit.

    The two can differ, because zeros before the point may only be placeholders.
    """
    if not step or not value or not digits:
        return step or 0.0, step or 0.0
    places = math.log10(abs(value) / step) + 1e-9
    placeholders = max(0, math.floor(places) + 1 - digits)
    return step, step * 10.0**placeholders


# --- all criteria ---


class Kind(Struct, frozen=True):
    """The fields that criteria with one check share, as in `criteria.toml`."""

    title: str  # what students read, if the rubric has no title
    full: str  # condition for all points, if the rubric has none
    zero: str  # condition for no points, if the rubric has none
    # keys of such a criterion besides id, check, points and title
    keys: tuple[str, ...] = ("full", "zero")
    variables: tuple[str, ...] = ()  # others that its conditions may contain


KINDS = convert(TABLES["kinds"], dict[str, Kind])
"""By the word after check in a rubric."""
MEANINGS: Mapping[str, str] = TABLES["meanings"]
"""Meaning of each variable in a condition, for students."""
ASKS: Mapping[str, str] = TABLES["asks"]
"""Requirements that a procedure criterion may contain, and the diagnostic of a log that
does not meet them."""

JUDGES: Mapping[str, Callable[[Criterion, Evidence], Mark]] = {
    "log": _log,
    "procedure": _procedure,
    "own_data": _own_data,
    "reference": _reference,
    "uncertainty": _uncertainty,
    "units": _units,
    "constancy": _constancy,
    "files": _files,
    "manual": lambda criterion, evidence: mark(
        criterion, "a person gives these points", {}, None
    ),
}
