"""What a log in the making says during the lab: the answer so far, which run to repeat, and what is still missing."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from gyrodata.comparisons import Run
from gyrodata.errors import Diagnostic
from gyrodata.measurements import torque_groups
from gyrodata.reporting.values import Writing, count_text, inertia_text, reading_text, torque_scale, value_text
from gyrodata.reporting.words import common_torque_scale, visible
from gyrodata.results import Analysis

FAR = 2.0
"""From how many standard uncertainties on a run is worth repeating that does not yet look odd."""

_OF_ONE_LOAD = {"G452", "G453"}
"""Codes of what a single weight lacks."""

_TOLD_OTHERWISE = {"G410", "G414", "G457"}
"""Odd runs are told with the weight they belong to, and one torque is too few by another code."""


def watch_text(analysis: Analysis, lacking: Iterable[Diagnostic], writing: Writing = "plain") -> str:
    """Say how the lab stands, and what to do before the weight that is on the rod comes off.

    Parameters
    ----------
    analysis : Analysis
        Of the runs so far.
    lacking : iterable of Diagnostic
        What the log lacks against the procedure.
    writing : {"plain", "short"}
        How values stand with their uncertainties.

    Returns
    -------
    str
        The answer; then the load of the log's last run, taken as the one on the rod; then the rest.
    """
    found = list(dict.fromkeys(d for d in (*analysis.diagnostics, *lacking) if d.severity != "note"))
    found = [d for d in found if d.code not in _TOLD_OTHERWISE]
    members = next(g for g in torque_groups(analysis.measurements) if len(analysis.run_table) - 1 in g)
    loaded = [analysis.run_table[i] for i in members]
    here = [d for d in found if d.code in _OF_ONE_LOAD and d.line in {run.line for run in loaded}]
    elsewhere = [
        f"repeat {_place(run)}, with {load_text(run)}: {run.reason}"
        for run in analysis.run_table
        if run.flagged and run not in loaded
    ]
    still_open = [*elsewhere, *(_advice(d) for d in found if d not in here)]
    blocks = [
        _answer(analysis, writing),
        [f"with {load_text(loaded[-1])} on the rod:", *_indented(_with_this_load(analysis, loaded, here))],
        ["still open:", *_indented(still_open)] if still_open else ["nothing else is open"],
    ]
    if not still_open and analysis.advice:
        blocks.append(["what would gain most:", *_indented(analysis.advice[:3])])
    return visible("\n\n".join("\n".join(block) for block in blocks)) + "\n"


def unfinished_text(name: str, errors: Sequence[Diagnostic]) -> str:
    """Say why a log cannot be analysed as it stands.

    Parameters
    ----------
    name : str
        Of the log.
    errors : sequence of Diagnostic
        Among them what stops the analysis.

    Returns
    -------
    str
    """
    told = "".join(f"{diagnostic}\n" for diagnostic in errors if diagnostic.severity == "error")
    return visible(f"{name}: no answer yet\n\n{told}")


def load_text(run: Run) -> str:
    """Name what is on the rod as the log does: "40 g at 15 cm".

    Parameters
    ----------
    run : Run
        One run.

    Returns
    -------
    str
    """
    if run.torque == 0:
        return "no weight"
    if run.mass is not None and run.position is not None:
        return f"{reading_text(run.mass, 1e-3)} g at {reading_text(run.position, 1e-2)} cm"
    return f"a torque of {value_text(run.torque, None, torque_scale(abs(run.torque)))}"


def _answer(analysis: Analysis, writing: Writing) -> list[str]:
    runs, torques = count_text(len(analysis.run_table), "run"), count_text(len(analysis.torques), "torque")
    inertia, residual = analysis.inertia, analysis.residual_torque
    relative = f", u = {100 * inertia.u / abs(inertia.value):.2g} %" if inertia.u else ""
    return [
        f"{analysis.name}: {runs}, {torques}",
        f"  I_zz = {inertia_text(inertia.value, inertia.u, writing)}{relative}",
        f"  M0 = {value_text(residual.value, residual.u, common_torque_scale(analysis), writing)}",
    ]


def _with_this_load(analysis: Analysis, loaded: Sequence[Run], here: Sequence[Diagnostic]) -> list[str]:
    """What to do before this load comes off: the odd runs, those that are far off, and what is missing."""
    odd = [f"repeat {_place(run)}: {run.reason}" for run in loaded if run.flagged]
    far = [
        f"repeat {_place(run)}: {abs(run.studentized_residual):.1f} u from what the other runs say"
        for run in loaded
        if not run.flagged and run.studentized_residual is not None and abs(run.studentized_residual) > FAR
    ]
    todo = [*odd, *far, *map(_advice, here)]
    if todo:
        return todo
    done = f"{count_text(len(loaded), 'run')}, and nothing is missing"
    heaviest = max(loaded, key=lambda run: abs(run.influence))
    if not analysis.inertia.u or not heaviest.influence or len(loaded) < 2:
        return [done]
    share = abs(heaviest.influence) / analysis.inertia.u
    return [f"{done}; if there is time, repeat {_place(heaviest)}, which moves I_zz most, by {share:.1f} u"]


def _place(run: Run) -> str:
    return f"run {run.run} (line {run.line})"


def _advice(found: Diagnostic) -> str:
    return f"{found.message}; {found.hint}" if found.hint else found.message


def _indented(lines: Iterable[str]) -> list[str]:
    return [f"  {line}" for line in lines]
