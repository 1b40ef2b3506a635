"""The summary: what a person reads first."""

from __future__ import annotations

from collections.abc import Sequence

from gyrodata.analysis import Analysis
from gyrodata.fitting import Estimate
from gyrodata.reporting.values import (
    count_text,
    inertia_text,
    interval_text,
    number_text,
    percent_text,
    power_of_ten,
    torque_text,
)
from gyrodata.reporting.words import (
    EFFECT_NAMES,
    FIT_NAMES,
    MODEL_NAMES,
    SOURCE_NAMES,
    default_lines,
    difference_text,
    effect_verdict,
    goodness_text,
)


def summary(analysis: Analysis) -> str:
    """Write what a person reads first.

    Parameters
    ----------
    analysis : Analysis
        The result.

    Returns
    -------
    str
        Several lines, ending with a line end.
    """
    sections = [
        _headline(analysis),
        _answer(analysis),
        _fits_table(analysis),
        _budget_lines(analysis),
        _odd_lines(analysis),
        _effect_lines(analysis),
        default_lines(analysis),
        [f"next time: {advice}" for advice in analysis.advice],
    ]
    return "\n\n".join("\n".join(lines) for lines in sections if lines) + "\n"


def _headline(analysis: Analysis) -> list[str]:
    count = len(analysis.run_table)
    return [f"{analysis.name}: {count_text(count, 'run')}, {count_text(len(analysis.torques), 'torque')}"]


def _answer(analysis: Analysis) -> list[str]:
    inertia, imbalance, bias = analysis.inertia, analysis.imbalance, analysis.timing_bias
    lines = [f"  I_zz = {inertia_text(inertia.value, inertia.u)}"]
    if inertia.interval_95 is not None and inertia.k is not None:
        factor, power = power_of_ten(max(inertia.value, inertia.u or 0.0, key=abs))
        ends = interval_text(*inertia.interval_95, factor)
        how = f"u × k, k = {inertia.k:.2f}" if inertia.interval_by == "linear" else "by the profile of chi-square"
        lines.append(f"         95 % interval {ends}{' × ' + power if power else ''} kg·m² ({how})")
    lines.append(f"  residual torque M0 = {torque_text(imbalance.value, imbalance.u)} (torque at work = applied + M0)")
    if bias.u:
        lines.append(f"  timing bias b = {number_text(bias.value, bias.u)} s")
    lines.append(f"  {goodness_text(analysis)}")
    return lines


def _fits_table(analysis: Analysis) -> list[str]:
    factor, power = power_of_ten(max(analysis.inertia.value, analysis.inertia.u or 0.0, key=abs))
    rows = [("fit", f"I_zz [{power + ' ' if power else ''}kg·m²]", "M0 [mN·m]", "from recommended")]
    impossible = []
    for fit in analysis.fits:
        if fit.inertia is None:
            impossible.append(f"  {FIT_NAMES[fit.name]}: {fit.note}")
            continue
        constant = Estimate(-fit.constant.value, fit.constant.u) if fit.constant else None
        rows.append(
            (
                FIT_NAMES[fit.name],
                number_text(fit.inertia.value, fit.inertia.u, factor),
                number_text(constant.value, constant.u, 1e-3) if constant else "-",
                difference_text(analysis, fit),
            )
        )
    return [*columns(rows), *impossible]


def columns(rows: Sequence[Sequence[str]]) -> list[str]:
    """Set rows of cells in columns, two blanks in front and between.

    Parameters
    ----------
    rows : sequence of sequence of str
        All of one length.

    Returns
    -------
    list of str
        One line for each row.
    """
    widths = [max(len(cell) for cell in column) for column in zip(*rows, strict=True)]
    return [
        ("  " + "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True))).rstrip() for row in rows
    ]


def _budget_lines(analysis: Analysis) -> list[str]:
    """The sources that make up at least 1 % of the variance."""
    rows = [
        (
            SOURCE_NAMES.get(share.source, share.source),
            f"{100 * share.share:.0f} %",
            f"shared by {share.shared_by}" if share.shared else "each run its own",
        )
        for share in analysis.budget
        if share.share >= 0.01
    ]
    return ["where u² of I_zz comes from:", *columns(rows)] if rows else []


def _odd_lines(analysis: Analysis) -> list[str]:
    lines = [
        f"  run {run.run} (line {run.line}): {run.reason}{'; left out' if run.left_out else '; kept'}"
        for run in analysis.run_table
        if run.flagged
    ]
    return ["looks odd:", *lines] if lines else ["no run looks odd; none is left out"]


def _effect_lines(analysis: Analysis) -> list[str]:
    rows = [
        (
            EFFECT_NAMES.get(effect.effect, effect.effect),
            percent_text(effect.bias),
            "-" if effect.size is None else f"{effect.size:.2f} u" if effect.size < 10 else f"{effect.size:.0f} u",
            effect_verdict(effect),
        )
        for effect in analysis.effects
        if effect.bias is not None
    ]
    return [f"what leaving it out does to I_zz (model: {MODEL_NAMES[analysis.model.name]}):", *columns(rows)]
