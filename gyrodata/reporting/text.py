"""Printed texts about an analysis, a lab in progress, and a check.

They are the summary of the analysis, the state of the lab, and the findings of the
check.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence

from gyrodata.base.diagnostics import (
    OUTLIER,
    SINGLE_TORQUE,
    SPINS_TOO_CLOSE,
    TOO_FEW_RUNS,
)
from gyrodata.base.errors import PICTURES, Diagnostic
from gyrodata.judging.tables import Run
from gyrodata.reporting import questions, values
from gyrodata.reporting.content import FAR, report
from gyrodata.reporting.elements import (
    NOTHING,
    Block,
    Numbers,
    Picture,
    Report,
    Table,
    plain,
)
from gyrodata.results import NO_BALL, Analysis, is_wide

MORE = "More: gyro analyze LOG -v, or open the HTML report"

_OF_ONE_LOAD = {TOO_FEW_RUNS, SPINS_TOO_CLOSE}
"""Codes of missing runs of a single weight."""

_SAID_ELSEWHERE = {OUTLIER, SINGLE_TORQUE}
"""Codes that repeat what is said of the runs of a weight, or of the number of torques.
"""


def summary(analysis: Analysis, verbose: bool = True, rest: str = MORE) -> str:
    """Write the answer and what a screen has room for, or the full report.

    Parameters
    ----------
    analysis : Analysis
    verbose : bool
        True for the full report: everything up to the diagnostics, which are printed
        elsewhere, but no figures.
    rest : str
        Last line of the short form, which says where the rest is.

    Returns
    -------
    str
    """
    whole = report(analysis)
    top = [
        *map(plain, whole.doubts),
        plain(whole.answer)
        + "   (± u, one standard uncertainty)" * (not is_wide(analysis.inertia)),
    ]
    top += (
        [line for block in whole.top for line in _block(block)]
        if verbose
        else [*map(plain, whole.brief), rest]
    )
    blocks = [_first_lines(whole), [f"  {line}" for line in top]]
    for one in itertools.takewhile(
        lambda one: one.anchor != "diagnostics", whole.sections if verbose else ()
    ):
        blocks += [
            [
                one.title,
                *(f"  {line}" for block in one.blocks for line in _block(block)),
            ]
        ] * bool(one.blocks)
    return _joined(blocks)


def _joined(blocks: Iterable[Iterable[str]]) -> str:
    return "\n\n".join("\n".join(block) for block in blocks).translate(PICTURES) + "\n"


def _first_lines(whole: Report) -> list[str]:
    return [f"{whole.name}: {plain(whole.size)}", f"  {plain(whole.read_as)}"]


def _block(block: Block) -> list[str]:
    if isinstance(block, Picture):
        return []
    if isinstance(block, Table):
        used = [i for i, head in enumerate(block.heads) if not head.page_only]
        rows = [
            ["-" if row[i] == NOTHING else plain(row[i]) for i in used]
            for row in block.rows
        ]
        return list(values.in_columns([[str(block.heads[i]) for i in used], *rows]))
    return [plain(line) for line in block.sentences]


# --- during the lab ---


def watch_text(analysis: Analysis, lacking: Iterable[Diagnostic]) -> str:
    """Describe the state of the lab, and what to do before the weight is removed from the rod.

    Parameters
    ----------
    analysis : Analysis
        Of the runs so far; the load of the last run is on the rod.
    lacking : iterable of Diagnostic
        What the log lacks.

    Returns
    -------
    str
        The answer, then what to do with this load, then the rest.
    """
    found = list(
        dict.fromkeys(
            d for d in (*analysis.diagnostics, *lacking) if d.severity != "note"
        )
    )
    found = [d for d in found if d.code not in _SAID_ELSEWHERE]
    n = Numbers(analysis)
    runs = analysis.run_table
    groups = analysis.measurements.by_torque
    group_of = {i: k for k, members in enumerate(groups) for i in members}
    members = groups[group_of[len(runs) - 1]]
    lines = {runs[i].line for i in members}
    here = [d for d in found if d.code in _OF_ONE_LOAD and d.line in lines]
    still_open = [
        f"repeat {_place(run)}, with {plain(n.load(group_of[i]))}: {run.reason}"
        for i, run in enumerate(runs)
        if run.flagged and i not in members
    ]
    still_open += [_advice(d) for d in found if d not in here]
    whole = report(analysis)
    inertia = analysis.inertia
    relative = (
        f", u = {100 * inertia.u / abs(inertia.value):.2g} %" if inertia.u else ""
    )
    state = [
        *map(plain, whole.doubts),
        f"{plain(whole.answer)}{relative}",
        plain(questions.residual_torque(n)),
    ]
    blocks = [
        [*_first_lines(whole), *(f"  {line}" for line in state)],
        [f"while {plain(n.load(group_of[len(runs) - 1]))} is on the rod:"],
        ["still to do:", *(f"  {line}" for line in still_open)]
        if still_open
        else ["nothing else to do"],
    ]
    blocks[1] += [
        f"  {line}"
        for line in _with_this_load(analysis, [runs[i] for i in members], here)
    ]
    if not still_open and analysis.advice:
        blocks.append(
            [
                "what would reduce u most:",
                *(f"  {line}" for line in analysis.advice[:3]),
            ]
        )
    return _joined(blocks)


def unfinished_text(name: str, errors: Sequence[Diagnostic]) -> str:
    """Say why a log cannot be analysed yet, with all warnings: one may be the cause."""
    said = [diagnostic for diagnostic in errors if diagnostic.severity != "note"]
    found = "".join(f"{diagnostic}\n" for diagnostic in said)
    return f"{name}: no answer yet\n\n{found}".translate(PICTURES)


def _with_this_load(
    analysis: Analysis, loaded: Sequence[Run], here: Sequence[Diagnostic]
) -> list[str]:
    """List what to do before this load is removed.

    The list is about suspected outliers, runs that are far off, and missing runs.
    """
    todo = [f"repeat {_place(run)}: {run.reason}" for run in loaded if run.flagged]
    for run in loaded:
        far = abs(run.studentized_residual or 0.0)
        if not run.flagged and far > FAR:
            todo.append(
                f"repeat {_place(run)}: it is {far:.1f} u away from the other runs' prediction"
            )
    todo += map(_advice, here)
    if todo:
        return todo
    done = f"{values.count_text(len(loaded), 'run')}, and nothing is missing"
    heaviest = max(loaded, key=lambda run: abs(run.influence))
    if not analysis.inertia.u or not heaviest.influence or len(loaded) < 2:
        return [done]
    share = abs(heaviest.influence) / analysis.inertia.u
    return [
        (
            f"{done}; if you have time, repeat {_place(heaviest)}, which affects I_zz "
            f"most, by {share:.1f} u"
        )
    ]


def _place(run: Run) -> str:
    return f"run {run.run} (line {run.line})"


def _advice(found: Diagnostic) -> str:
    return (
        f"{found.message}; {found.hint}".replace("\n", "\n  ")
        if found.hint
        else found.message
    )


# --- what a check has found, and the table of codes ---


def check_text(
    name: str,
    runs: int | None,
    diagnostics: Sequence[Diagnostic],
    well: str = "complete",
    analysis: Analysis | None = None,
) -> str:
    """Write what ``gyro check`` found.

    Parameters
    ----------
    name : str
        Of the log.
    runs : int, optional
        Number of runs, if the log was read.
    diagnostics : sequence of Diagnostic
    well : str
        The verdict if nothing was found.
    analysis : Analysis, optional
        Its reading of a run and its doubts come first.

    Returns
    -------
    str
        The last line is the verdict.
    """
    lines = []
    parts = []
    if analysis is not None:
        whole = report(analysis)
        lines = [
            plain(whole.read_as),
            *([NO_BALL] if analysis.ball is None else ()),
            *map(plain, whole.doubts),
        ]
        parts = [values.count_text(len(whole.doubts), "doubt")] if whole.doubts else []
    clean = not parts and all(d.severity == "note" for d in diagnostics)
    for severity in ("error", "warning", "note"):
        if count := sum(d.severity == severity for d in diagnostics):
            parts.append(values.count_text(count, severity))
    verdict = ", ".join(parts)
    if clean:
        verdict = f"{well} ({verdict})" if verdict else well
    read = "" if runs is None else f"{values.count_text(runs, 'run')}, "
    text = "".join(f"{name}: {line}\n" for line in lines) + "".join(
        f"{diagnostic}\n" for diagnostic in diagnostics
    )
    return f"{text}{name}: {read}{verdict}\n".translate(PICTURES)


def diagnostics_text(table: Sequence[Mapping[str, str]]) -> str:
    """Write the table of diagnostic codes, each with an example that raises it."""
    blocks = []
    for row in table:
        lines = row["example"].rstrip("\n").splitlines()
        # A tab in an example stays a tab.
        example = "\n".join(
            f"      {line.translate({**PICTURES, 9: chr(9)})}" for line in lines
        )
        blocks.append(
            f"{row['code']}  {row['severity']:7}  {row['title']}\n{example}\n"
        )
    return "\n".join(blocks)
