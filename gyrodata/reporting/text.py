"""Printed text: the summary of an analysis, the state of a lab in progress, and the findings of a check."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from gyrodata.diagnostics import OUTLIER, SINGLE_TORQUE, SPINS_TOO_CLOSE, TOO_FEW_RUNS
from gyrodata.errors import Diagnostic
from gyrodata.measurements import torque_groups
from gyrodata.reporting import values
from gyrodata.reporting.content import FAR, common_torque_scale, report, residual_torque
from gyrodata.reporting.phrases import visible
from gyrodata.reporting.tree import (
    Block,
    Cell,
    Head,
    Interval,
    Sentence,
    Table,
    cell_text,
    head_text,
    lines,
    load,
    sentence_text,
)
from gyrodata.results import NO_BALL, Analysis
from gyrodata.tables import Run

MORE = "More: gyro analyze LOG -v, or open the HTML report"

_OF_ONE_LOAD = {TOO_FEW_RUNS, SPINS_TOO_CLOSE}
"""Codes of what a single weight lacks."""

_TOLD_OTHERWISE = {OUTLIER, SINGLE_TORQUE}
"""Odd runs are told with the weight they belong to, and one torque is too few by another code."""


def summary(analysis: Analysis, verbose: bool = True, rest: str = MORE) -> str:
    """Write what a person reads first: a screen, and where the `rest` is told, or all that needs no picture."""
    whole = report(analysis)
    is_interval = any(isinstance(part, Interval) for part in whole.answer)
    meaning = "95 % interval" if is_interval else "± u, one standard uncertainty"
    answer = f"{sentence_text(whole.answer)}   ({meaning})"
    top = _indented([*map(sentence_text, whole.doubts), answer])
    blocks = [[f"{whole.name}: {sentence_text(whole.size)}", f"  {sentence_text(whole.read_as)}"]]
    if not verbose:
        blocks.append([*top, *_indented(sentence_text(line) for line in whole.brief), f"  {rest}"])
    for section in whole.sections if verbose else ():
        told = [line for block in section.blocks if not block.full for line in _block(block)]
        if told:
            blocks.append([*([section.title] if section.title else top), *_indented(told)])
    return visible("\n\n".join("\n".join(block) for block in blocks)) + "\n"


def _block(block: Block) -> list[str]:
    if isinstance(block, Table):
        return _table(block)
    return [sentence_text(line) for line in lines(block, short=True)]


def _table(table: Table) -> list[str]:
    """Set cells in columns, two blanks between."""
    told = [(i, head) for i, head in enumerate(table.heads) if not head.full]
    short = range(len(table.rows)) if table.short is None else table.short
    rows = [[head_text(head) for _, head in told]]
    rows += [[_cell(table.rows[i][j], head) for j, head in told] for i in short]
    return list(values.in_columns(rows))


def _cell(cell: Cell, head: Head) -> str:
    if cell is None:
        return "-" if head.scale else ""
    return cell_text(cell)


# --- during the lab ------------------------------------------------------------------------------------------


def watch_text(analysis: Analysis, lacking: Iterable[Diagnostic]) -> str:
    """Say how the lab stands, and what to do before the weight that is on the rod comes off.

    The answer; then the load of the log's last run, taken as the one on the rod; then the rest of what is lacking.
    """
    found = list(dict.fromkeys(d for d in (*analysis.diagnostics, *lacking) if d.severity != "note"))
    found = [d for d in found if d.code not in _TOLD_OTHERWISE]
    groups = list(torque_groups(analysis.measurements))
    group_of = {i: k for k, members in enumerate(groups) for i in members}
    members = groups[group_of[len(analysis.run_table) - 1]]
    whole, torque = report(analysis), common_torque_scale(analysis)

    def on_the_rod(index: int) -> str:
        return sentence_text(load(analysis, group_of[index], torque))

    loaded = [analysis.run_table[i] for i in members]
    here = [d for d in found if d.code in _OF_ONE_LOAD and d.line in {run.line for run in loaded}]
    elsewhere = [
        f"repeat {_place(run)}, with {on_the_rod(i)}: {run.reason}"
        for i, run in enumerate(analysis.run_table)
        if run.flagged and i not in members
    ]
    still_open = [*elsewhere, *(_advice(d) for d in found if d not in here)]
    inertia = analysis.inertia
    relative = f", u = {100 * inertia.u / abs(inertia.value):.2g} %" if inertia.u else ""
    blocks = [
        [
            f"{whole.name}: {sentence_text(whole.size)}",
            f"  {sentence_text(whole.read_as)}",
            *_indented(sentence_text(doubt) for doubt in whole.doubts),
            f"  {sentence_text(whole.answer)}{relative}",
            f"  {sentence_text(residual_torque(analysis, torque).sentence)}",
        ],
        [
            f"while {on_the_rod(len(analysis.run_table) - 1)} is on the rod:",
            *_indented(_with_this_load(analysis, loaded, here)),
        ],
        ["still to do:", *_indented(still_open)] if still_open else ["nothing else to do"],
    ]
    if not still_open and analysis.advice:
        blocks.append(["what would reduce u most:", *_indented(analysis.advice[:3])])
    return visible("\n\n".join("\n".join(block) for block in blocks)) + "\n"


def unfinished_text(name: str, errors: Sequence[Diagnostic]) -> str:
    """Say why a log cannot be analysed as it stands."""
    told = "".join(f"{diagnostic}\n" for diagnostic in errors if diagnostic.severity == "error")
    return visible(f"{name}: no answer yet\n\n{told}")


def _with_this_load(analysis: Analysis, loaded: Sequence[Run], here: Sequence[Diagnostic]) -> list[str]:
    """Return what to do before this load is removed: suspected outliers, runs far off, and missing runs."""
    odd = [f"repeat {_place(run)}: {run.reason}" for run in loaded if run.flagged]
    far = [
        f"repeat {_place(run)}: it is {abs(run.studentized_residual):.1f} u away from the other runs' prediction"
        for run in loaded
        if not run.flagged and run.studentized_residual is not None and abs(run.studentized_residual) > FAR
    ]
    todo = [*odd, *far, *map(_advice, here)]
    if todo:
        return todo
    done = f"{values.count_text(len(loaded), 'run')}, and nothing is missing"
    heaviest = max(loaded, key=lambda run: abs(run.influence))
    if not analysis.inertia.u or not heaviest.influence or len(loaded) < 2:
        return [done]
    share = abs(heaviest.influence) / analysis.inertia.u
    return [f"{done}; if you have time, repeat {_place(heaviest)}, which affects I_zz most, by {share:.1f} u"]


def _place(run: Run) -> str:
    return f"run {run.run} (line {run.line})"


def _advice(found: Diagnostic) -> str:
    return f"{found.message}; {found.hint}".replace("\n", "\n  ") if found.hint else found.message


def _indented(lines: Iterable[str]) -> list[str]:
    return [f"  {line}" for line in lines]


# --- what a check has found, and the table of codes ---------------------------------------------------------------


def check_text(
    name: str,
    runs: int | None,
    diagnostics: Sequence[Diagnostic],
    well: str = "complete",
    analysis: Analysis | None = None,
) -> str:
    """Write how the log was read, the doubts, what `gyro check` found, and a last line that sums it up.

    `well`: what the log is if nothing was found.
    """
    first: list[Sentence] = []
    doubts: tuple[Sentence, ...] = ()
    if analysis is not None:
        whole = report(analysis)
        doubts = whole.doubts
        first = [whole.read_as, *([(NO_BALL,)] if analysis.ball is None else ()), *doubts]
    top = "".join(f"{name}: {sentence_text(line)}\n" for line in first)
    counts = {severity: sum(d.severity == severity for d in diagnostics) for severity in ("error", "warning", "note")}
    told = ", ".join(values.count_text(count, severity) for severity, count in counts.items() if count)
    read = "" if runs is None else f"{values.count_text(runs, 'run')}, "
    told = ", ".join(filter(None, (values.count_text(len(doubts), "doubt") * bool(doubts), told)))
    clean = not (doubts or counts["error"] or counts["warning"])
    verdict = f"{well}{f' ({told})' if told else ''}" if clean else told
    return visible(top + "".join(f"{diagnostic}\n" for diagnostic in diagnostics) + f"{name}: {read}{verdict}\n")


def diagnostics_text(table: Sequence[Mapping[str, str]]) -> str:
    """Write the table of diagnostic codes, each with an example that raises it."""
    blocks = []
    for row in table:
        lines = (line.split("\t") for line in row["example"].rstrip("\n").splitlines())
        example = "\n".join(f"      {chr(9).join(map(visible, cells))}" for cells in lines)
        blocks.append(f"{row['code']}  {row['severity']:7}  {row['title']}\n{example}\n")
    return "\n".join(blocks)
