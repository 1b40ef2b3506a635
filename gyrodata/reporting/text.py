"""The summary: what a person reads first."""

from __future__ import annotations

from collections.abc import Sequence

from gyrodata.reporting.values import (
    SECOND,
    Writing,
    count_text,
    inertia_scale,
    inertia_text,
    interval_text,
    number_text,
    percent_text,
    value_text,
)
from gyrodata.reporting.words import (
    EFFECT_NAMES,
    FIT_NAMES,
    MODEL_NAMES,
    SOURCE_NAMES,
    common_torque_scale,
    default_lines,
    difference_text,
    effect_verdict,
    goodness_text,
    interval_kind,
    size_text,
    visible,
)
from gyrodata.results import Analysis


def summary(analysis: Analysis, writing: Writing = "plain") -> str:
    """Write what a person reads first.

    Parameters
    ----------
    analysis : Analysis
        The result.
    writing : {"plain", "short"}
        How values stand with their uncertainties.

    Returns
    -------
    str
        Several lines, ending with a line end.
    """
    sections = [
        _headline(analysis),
        _answer(analysis, writing),
        _fits_table(analysis, writing),
        _budget_lines(analysis),
        _odd_lines(analysis),
        _effect_lines(analysis),
        default_lines(analysis),
        [f"next time: {advice}" for advice in analysis.advice],
    ]
    return visible("\n\n".join("\n".join(lines) for lines in sections if lines)) + "\n"


def _headline(analysis: Analysis) -> list[str]:
    count = len(analysis.run_table)
    return [f"{analysis.name}: {count_text(count, 'run')}, {count_text(len(analysis.torques), 'torque')}"]


def _answer(analysis: Analysis, writing: Writing) -> list[str]:
    inertia, residual, bias = analysis.inertia, analysis.residual_torque, analysis.timing_bias
    lines = [f"  I_zz = {inertia_text(inertia.value, inertia.u, writing)}"]
    if inertia.interval_95 is not None:
        scale = inertia_scale(inertia.value, inertia.u)
        ends = interval_text(*inertia.interval_95, scale.size)
        lines.append(
            f"         95 % interval {ends}{' × ' if scale.exponent else ' '}{scale} ({interval_kind(inertia)})"
        )
    torque = value_text(residual.value, residual.u, common_torque_scale(analysis), writing)
    lines.append(f"  residual torque M0 = {torque} (torque at work = applied + M0)")
    if bias.u:
        lines.append(f"  timing bias b = {value_text(bias.value, bias.u, SECOND, writing)}")
    lines.append(f"  {goodness_text(analysis)}")
    return lines


def _fits_table(analysis: Analysis, writing: Writing) -> list[str]:
    scale, torque = inertia_scale(analysis.inertia.value, analysis.inertia.u), common_torque_scale(analysis)
    rows = [("fit", f"I_zz [{scale}]", f"M0 [{torque}]", "from recommended")]
    impossible = []
    for fit in analysis.fits:
        if fit.inertia is None:
            impossible.append(f"  {FIT_NAMES[fit.name]}: {fit.note}")
            continue
        rows.append(
            (
                FIT_NAMES[fit.name],
                number_text(fit.inertia.value, fit.inertia.u, scale.size, writing),
                number_text(-fit.constant.value, fit.constant.u, torque.size, writing) if fit.constant else "-",
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
            "-" if effect.size is None else size_text(effect.size),
            effect_verdict(effect),
        )
        for effect in analysis.effects
        if effect.bias is not None
    ]
    return [f"what leaving it out does to I_zz (model: {MODEL_NAMES[analysis.model.name]}):", *columns(rows)]
