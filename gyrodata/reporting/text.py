"""Printed texts about an analysis, a lab in progress, and a check.

They are the summary of the analysis, the state of the lab, and the findings of the
check.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

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
    meaning = "" if is_wide(analysis.inertia) else "   (± u, one standard uncertainty)"
    top = [*map(plain, whole.doubts), f"{plain(whole.answer)}{meaning}"]
    if not verbose:
        lines = [*top, *map(plain, whole.brief), rest]
        return _joined([_first_lines(whole), _indented(lines)])
    blocks = [_first_lines(whole), _indented([*top, *_lines_of(whole.top)])]
    for section in whole.sections:
        if section.anchor == "diagnostics":
            break
        if section.blocks:
            blocks.append([section.title, *_indented(_lines_of(section.blocks))])
    return _joined(blocks)


def _lines_of(blocks: Iterable[Block]) -> list[str]:
    """Write blocks as lines."""
    return [line for block in blocks for line in _block(block)]


def _indented(lines: Iterable[str]) -> list[str]:
    return [f"  {line}" for line in lines]


def answer_line(analysis: Analysis) -> str:
    """Write the answer in one line, with a word of warning if it is doubted."""
    whole = report(analysis)
    words = "; do not rely on it" if whole.doubts else ""
    return f"{plain(whole.answer)}{words}"


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
    """Describe the lab so far, and what to do before the weight is removed.

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
    every = dict.fromkeys((*analysis.diagnostics, *lacking))
    findings = [
        finding
        for finding in every
        if finding.severity != "note" and finding.code not in _SAID_ELSEWHERE
    ]
    numbers = Numbers(analysis)
    groups = analysis.measurements.by_torque
    last = len(analysis.run_table) - 1
    [load] = [k for k, members in enumerate(groups) if last in members]
    loaded = [analysis.run_table[i] for i in groups[load]]
    lines = {run.line for run in loaded}
    here = [
        finding
        for finding in findings
        if finding.code in _OF_ONE_LOAD and finding.line in lines
    ]
    later = [_advice(finding) for finding in findings if finding not in here]
    still_open = [*_runs_to_repeat(numbers, loaded), *later]
    blocks = [
        _state(numbers),
        _listed(
            f"while {plain(numbers.load(load))} is on the rod:",
            _with_this_load(analysis, loaded, here),
        ),
    ]
    if still_open:
        blocks.append(_listed("still to do:", still_open))
    else:
        blocks.append(["nothing else to do"])
        if analysis.advice:
            blocks.append(_listed("what would reduce u most:", analysis.advice[:3]))
    return _joined(blocks)


def _listed(title: str, lines: Iterable[str]) -> list[str]:
    """Write a title, and lines below it."""
    return [title, *_indented(lines)]


def _state(numbers: Numbers) -> list[str]:
    """List the doubts, the answer and M0 of the runs so far."""
    analysis = numbers.analysis
    whole = report(analysis)
    inertia = analysis.inertia
    answer = plain(whole.answer)
    if inertia.u:
        answer += f", u = {100 * inertia.u / abs(inertia.value):.2g} %"
    doubts = map(plain, whole.doubts)
    m0 = plain(questions.residual_torque(numbers))
    return [*_first_lines(whole), *_indented([*doubts, answer, m0])]


def _runs_to_repeat(numbers: Numbers, loaded: Sequence[Run]) -> Iterator[str]:
    """Name the flagged runs of other loads."""
    analysis = numbers.analysis
    for load, members in enumerate(analysis.measurements.by_torque):
        for i in members:
            run = analysis.run_table[i]
            if run.flagged and run not in loaded:
                weight = plain(numbers.load(load))
                yield f"repeat {_place(run)}, with {weight}: {run.reason}"


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
