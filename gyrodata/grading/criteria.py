"""The criteria: what each finds in one student's log and report, and the points for it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from sys import intern
from typing import TYPE_CHECKING

from msgspec import Struct
from msgspec.structs import force_setattr

from gyrodata.diagnostics import NOTE_MAY_CHANGE_READING
from gyrodata.errors import Diagnostic
from gyrodata.fitting import chi2_tail, times_stated
from gyrodata.grading.rubric import ASKS, KINDS, Criterion
from gyrodata.grading.slips import Slip
from gyrodata.grading.yardsticks import COARSEST, BenchScatter, OwnRuns, OwnValue, Reference, fit_words
from gyrodata.readings import Reported
from gyrodata.reporting.values import count_text, factor_text, inertia_range_text, inertia_text, p_text

if TYPE_CHECKING:
    from gyrodata.results import Analysis

Detail = Mapping[str, float | str | None]


class Mark(Struct, frozen=True):
    """The result of one criterion."""

    criterion: str  # its id
    title: str
    check: str  # kind of criterion
    points: float | None  # two decimals; None where it could not be judged
    out_of: float
    reason: str  # what was found, to the student
    detail: Detail  # the numbers behind it
    rule: str  # what earns all points and what none; "" where that was not what decided

    def __post_init__(self) -> None:
        # A class keeps one copy of the words that its marks share.
        for name in ("criterion", "title", "check", "reason", "rule"):
            force_setattr(self, name, intern(getattr(self, name)))

    @property
    def waits(self) -> bool:
        """True where only a person, or a reference, is missing: the other points stand."""
        return self.points is None and (self.check == "manual" or "value" in self.detail)


class Evidence(Struct, frozen=True, kw_only=True):
    """Everything that the criteria look at."""

    analysis: Analysis
    lacks: list[Diagnostic]  # what the procedure asks for, and the log has not
    own: OwnRuns
    reported: Reported | None  # I_zz as reported, its value in SI; None where there is none
    absent_is_zero: bool  # True where a report that is not there costs its points; else a person must look
    matched: OwnValue | None = None  # the accepted fit that the report comes nearest to, after correcting a mistake
    d: float | None = None  # how far from it, as reported [u]
    slips: tuple[Slip, ...] = ()
    carries: bool  # True if own_data charges for a common mistake, so that the reference judges the corrected value
    files: tuple[str, ...] = ()  # all that was handed in
    bench: tuple[str, ...]  # uncertainties that the log has from the rubric, each in words

    @property
    def factor(self) -> float:
        """The factor of a common mistake on I_zz; 1 without one."""
        return self.slips[0].factor if self.slips else 1.0


def judge(criterion: Criterion, evidence: Evidence) -> Mark:
    """Judge one criterion; a "reference" mark has no points yet: see `judge_reference`."""
    if KINDS[criterion.check].of_report:
        if evidence.reported is None or evidence.reported.value is None:
            return mark(criterion, 0.0 if evidence.absent_is_zero else None, _absent_words(evidence.reported), {})
        # A known slip has cost its points already.
        value = evidence.reported.value / (evidence.factor if evidence.carries else 1.0)
        if criterion.gate is not None and not criterion.gate[0] <= abs(value) <= criterion.gate[1]:
            low, high = (inertia_text(end, None) for end in criterion.gate)
            reason = (
                f"{inertia_text(evidence.reported.value, None)} is not between {low} and {high}: nothing on a lab "
                "bench has such a moment of inertia, so nothing can be built on it"
            )
            return mark(criterion, 0.0, reason, {"value": evidence.reported.value})
    return _JUDGES[criterion.check](criterion, evidence)


def _absent_words(reported: Reported | None) -> str:
    """Return why a value to judge is missing."""
    if reported is None:
        return "no reported I_zz was found; it is a line of the log: # reported_inertia: 4.4e-3 ± 0.1e-3 kg m^2"
    return f"the reported I_zz cannot be read: {reported.problem or 'it is no number'}"


def mark(criterion: Criterion, share: float | None, reason: str, detail: Detail) -> Mark:
    """Make a mark from a share of the points, from 0 to 1; None where it could not be judged."""
    points = None if share is None else round(share * criterion.points, 2)
    applied = criterion.curve.variable in detail and "slip_cost" not in detail
    rule = criterion.told if applied else ""
    return Mark(criterion.id, criterion.title, criterion.check, points, criterion.points, reason, detail, rule)


# --- the log ------------------------------------------------------------------------------------------------


def _log(criterion: Criterion, evidence: Evidence) -> Mark:
    read = (*evidence.analysis.readings.diagnostics, *evidence.analysis.measurements.diagnostics)
    # A note costs nothing: who writes down what went wrong does as they should.
    doubted = [one for one in read if one.severity == "warning" and one.code != NOTE_MAY_CHANGE_READING]
    runs = count_text(len(evidence.analysis.run_table), "run")
    if doubted:
        reason = f"{runs}, with {count_text(len(doubted), 'thing')} to put right: {_listed(doubted)}"
    else:
        reason = f"{runs} read without warnings"
    return mark(criterion, criterion.curve.share(len(doubted)), reason, {"warnings": float(len(doubted))})


def _procedure(criterion: Criterion, evidence: Evidence) -> Mark:
    codes = {ASKS[ask] for ask in criterion.asks}
    missing = [diagnostic for diagnostic in evidence.lacks if diagnostic.code in codes]
    reason = _listed(missing) if missing else "nothing required is missing"
    return mark(criterion, criterion.curve.share(len(missing)), reason, {"missing": float(len(missing))})


def _constancy(criterion: Criterion, evidence: Evidence) -> Mark:
    groups = [group for group in evidence.analysis.torques if group.torque and group.product.spread is not None]
    if not groups:
        return mark(criterion, 0.0, "no torque has two runs, so nothing shows whether φ̇ψ̇ is constant", {})
    spread = max((group.product.spread or 0.0) / abs(group.product.value) for group in groups)
    if any(one.startswith(_OF_SCATTER) for one in evidence.bench):
        words = "the uncertainties that the rubric gives your bench"
    else:
        words = "the uncertainties that your log states" if times_stated(evidence.analysis.measurements) else USUAL
    return _scatter_mark(criterion, spread, scatter_of(evidence.analysis), words)


_OF_SCATTER = ("u_time ", "u_spin ", "u_turns ", "u_angle ", "u_precession")
USUAL = "the usual uncertainties of such readings"


def scatter_of(analysis: Analysis) -> tuple[tuple[float, int], ...]:
    """Give χ² of φ̇ψ̇ within each torque, and its degrees of freedom."""
    groups = [group for group in analysis.torques if group.torque and group.product.spread is not None]
    return tuple((group.product.chi2, group.runs - 1) for group in groups if group.product.chi2 is not None)


def _scatter_mark(
    criterion: Criterion, spread: float, told: Sequence[tuple[float, int]], words: str, factor: float = 1.0
) -> Mark:
    """Judge the scatter of φ̇ψ̇, with uncertainties that are the given factor larger than those of χ²."""
    chances = [chi2_tail(chi2 / factor**2, dof) for chi2, dof in told]
    # The least of k chances, as the chance of one so small among k (Šidák).
    p = -math.expm1(len(chances) * math.log1p(-min(min(chances), 1 - 1e-15))) if chances else 1.0
    by_p = criterion.curve.variable == "p"
    share = criterion.curve.share(p if by_p else spread)
    reason = f"φ̇ψ̇ scatters by {100 * spread:.2g} % at most within a torque"
    if by_p:
        reason += f", which {'agrees with' if share == 1 else 'is more than'} {words} ({p_text(p)})"
    return mark(criterion, share, reason, {"p": p, "spread": spread, "factor": factor})


def judge_scatter(criterion: Criterion, before: Mark, told: Sequence[tuple[float, int]], scatter: BenchScatter) -> Mark:
    """Judge constancy by how far the class scatters, where a log states no uncertainties."""
    spread = before.detail.get("spread")
    if not told or not isinstance(spread, float) or before.detail.get("factor") == scatter.factor:
        return before
    words = f"{USUAL}, {scatter.factor:.2g} times as large: {scatter.words}" if scatter.factor > 1 else USUAL
    return _scatter_mark(criterion, spread, told, words, scatter.factor)


def _listed(diagnostics: list[Diagnostic], most: int = 3) -> str:
    told = [f"{d.cell or f'line {d.line}'}: {d.message}" if d.line else d.message for d in diagnostics[:most]]
    return "; ".join(told) + (f"; and {len(diagnostics) - most} more" if len(diagnostics) > most else "")


PICTURES = (".png", ".jpg", ".jpeg", ".gif", ".svg", ".webp", ".heic", ".tif", ".tiff", ".pdf")  # may contain a plot


def _files(criterion: Criterion, evidence: Evidence) -> Mark:
    pictures = sum(name.lower().endswith(PICTURES) for name in evidence.files)
    found = count_text(pictures, "file")
    reason = f"{found} with room for a plot" if pictures else "no picture and no PDF that could show a plot"
    return mark(criterion, criterion.curve.share(pictures), reason, {"files": float(pictures)})


def _manual(criterion: Criterion, evidence: Evidence) -> Mark:
    return mark(criterion, None, "a person gives these points", {})


# --- the report ---------------------------------------------------------------------------------------------


def _own_data(criterion: Criterion, evidence: Evidence) -> Mark:
    reported, matched = _given(evidence)
    d = evidence.slips[0].distance if evidence.slips else evidence.d or 0.0
    said = f"you report {inertia_text(reported, evidence.reported.u if evidence.reported else None)}"
    own = f"{inertia_text(matched.value, matched.u)} ({fit_words(matched.name)})"
    times = factor_text(reported / matched.value)
    percent, carried = (100 * abs(one / matched.value - 1) for one in (reported, reported / evidence.factor))
    in_percent = criterion.curve.variable == "percent"
    share = criterion.curve.share(percent if in_percent else evidence.d or 0.0)
    detail = {"d": evidence.d, "d_carried": d, "own": matched.value, "matched": matched.name}
    if in_percent:
        detail["percent"] = percent
    if evidence.slips:
        detail["slip"] = evidence.slips[0].kind
        less = criterion.curve.share(carried if in_percent else d) - criterion.slip / (criterion.points or 1.0)
        if less > share:
            share, detail["slip_cost"] = less, criterion.slip
        words = " or ".join(slip.words for slip in evidence.slips)
        reason = f"{said}, {times} what your runs give, {own}: one common mistake would explain this: {words}"
    elif d == 0:
        reason = f"{said}, and so do your runs: {own}"
    else:
        reason = f"{said}; your runs give {own}{f', {d:.2g} u away' if d <= 30 else f': yours is {times} that'}"
    return mark(criterion, share, reason, detail)


def _reference(criterion: Criterion, evidence: Evidence) -> Mark:
    reported, matched = _given(evidence)
    factor = evidence.factor if evidence.carries else 1.0
    value = reported / factor
    # Not the reported u: a ± as wide as one likes would agree with everything.
    u = max(evidence.analysis.inertia.u or 0.0, matched.u or 0.0)
    # Nor a u without end: runs that say nothing of I_zz would go with any value.
    u = min(u, COARSEST * abs(value))
    return mark(criterion, None, "the reference is not known yet", {"value": value, "u": u, "slip": factor})


def judge_reference(criterion: Criterion, pending: Mark, reference: Reference | None) -> Mark:
    """Give the points of a "reference" criterion once the reference is known, if there is a value to compare."""
    value, u = pending.detail.get("value"), pending.detail.get("u")
    if not isinstance(value, float) or not isinstance(u, float):
        return pending
    if reference is None:
        reason = "the rubric has no reference for this station; the station, or these points, can be given by hand"
        return mark(criterion, None, reason, pending.detail)
    width = math.hypot(u, reference.u) or abs(reference.inertia) * 1e-9
    zeta = abs(value - reference.inertia) / width
    undone = ", after correcting the mistake," if pending.detail.get("slip") != 1.0 else ""
    detail = {**pending.detail, "reference": reference.inertia, "u_reference": reference.u, "z": zeta}
    size, far = zeta, f"{zeta:.2g} standard uncertaint{'y' if f'{zeta:.2g}' == '1' else 'ies'}"
    in_percent = criterion.curve.variable == "percent"
    if in_percent:
        size = 100 * abs(value / reference.inertia - 1)
        far, detail = f"{size:.2g} %", {**detail, "percent": size}
    reason = f"{inertia_text(value, None)}{undone} is {far} from {reference.words}"
    return mark(criterion, criterion.curve.share(size), reason, detail)


def _uncertainty(criterion: Criterion, evidence: Evidence) -> Mark:
    assert evidence.reported is not None
    if criterion.curve.variable == "stated":
        stated = float(evidence.reported.u is not None)
        reason = f'"{evidence.reported.text}" {"states" if stated else "does not state"} an uncertainty'
        return mark(criterion, criterion.curve.share(stated), reason, {"stated": stated})
    if evidence.reported.u is None:
        return mark(criterion, 0.0, "no uncertainty is reported; write it behind the value: 4.4e-3 ± 0.1e-3 kg m^2", {})
    u = evidence.reported.u / abs(evidence.factor)
    known = [own.u for own in evidence.own.values if own.u]
    known += [slip.u / abs(slip.factor) for slip in evidence.slips[:1] if slip.u]
    known = known or [evidence.own.yardstick * abs(evidence.own.values[0].value)]
    low, high = min(known), max(known)
    ratio = 1.0 if low <= u <= high else u / low if u < low else u / high
    undone = f", {inertia_range_text(u, u)} after correcting the mistake," if evidence.slips else ""
    reason = f"± {inertia_range_text(evidence.reported.u, evidence.reported.u)}{undone}"
    whole = inertia_range_text(low, high)
    if ratio == 1:
        reason += f" agrees with your runs, whose fits give {whole}"
    else:
        side, end = ("large", "largest") if ratio > 1 else ("small", "smallest")
        verdict = "a little" if criterion.curve.share(ratio) == 1 else "too"
        reason += f" is {verdict} {side}: {factor_text(ratio)} the {end} that the fits of your runs give, {whole}"
        mean = next((own.u for own in evidence.own.values if own.name == "mean_of_ratios"), None)
        runs = sum(1 for run in evidence.analysis.run_table if run.torque and not run.left_out)
        if mean and abs(u / (mean * math.sqrt(runs)) - 1) < 0.1:
            reason += "; it is the scatter of single runs, and that of their mean is √n times smaller"
    return mark(criterion, criterion.curve.share(ratio), reason, {"ratio": ratio, "u": u, "u_low": low, "u_high": high})


def _units(criterion: Criterion, evidence: Evidence) -> Mark:
    reported = evidence.reported
    assert reported is not None
    faults = [reported.problem] if reported.problem else []
    u_digits = reported.u_digits or 0
    if reported.u and reported.u_step:
        # ± 0.102 with k = 2 is u = 0.051.
        u_digits = min(u_digits, math.floor(math.log10(reported.u / reported.u_step) + 1e-9) + 1)
    if u_digits > 2:
        faults.append(f"the uncertainty has {u_digits} digits: one or two say all that is known")
    low, high = _last_place(reported.step, reported.value, reported.digits)
    if reported.step and reported.u_step and reported.u:
        # A ± that was divided by its k has as many digits as it had, and its place is where u has its first at least.
        u_low, u_high = _last_place(reported.u_step, reported.u, reported.u_digits)
        u_low = min(u_low, 10.0 ** math.floor(math.log10(reported.u)))
        if max(low, u_low) > 1.26 * min(high, u_high):
            which = "finer" if high < u_low else "coarser"
            faults.append(
                f"the value's last digit is {which} than that of its uncertainty: round both to the same place"
            )
    elif reported.step and not reported.u_step:
        u = reported.u or evidence.own.yardstick * abs(reported.value or 0.0)
        if high < u / 150:
            faults.append("the value has more digits than its uncertainty lets it have")
    reason = "; ".join(faults) if faults else f'"{reported.text}" has its unit, and as many digits as it should'
    return mark(criterion, criterion.curve.share(len(faults)), reason, {"faults": float(len(faults))})


def _last_place(step: float | None, value: float | None, digits: int | None) -> tuple[float, float]:
    """Give the finest and the coarsest that a last digit can stand for: zeros before the point may only fill up."""
    if not step or not value or not digits:
        return step or 0.0, step or 0.0
    steps = math.floor(math.log10(abs(value) / step) + 1e-9)
    return step, step * 10.0 ** max(0, steps + 1 - digits)


def _given(evidence: Evidence) -> tuple[float, OwnValue]:
    """Always present if a value is reported."""
    assert evidence.reported is not None
    assert evidence.reported.value is not None
    assert evidence.matched is not None
    return evidence.reported.value, evidence.matched


_JUDGES: dict[str, Callable[[Criterion, Evidence], Mark]] = {
    "log": _log,
    "procedure": _procedure,
    "own_data": _own_data,
    "reference": _reference,
    "uncertainty": _uncertainty,
    "units": _units,
    "constancy": _constancy,
    "files": _files,
    "manual": _manual,
}
