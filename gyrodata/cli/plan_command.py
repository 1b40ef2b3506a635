"""``gyro plan``: which runs reduce the uncertainty most, before and during the lab."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gyrodata.cli.new_table import RunToFill, log_to_fill_in, write_table
from gyrodata.cli.options import (
    ConfigOption,
    FormatOption,
    MappingOption,
    SettingsOption,
    list_option,
    quantity,
    read,
)
from gyrodata.cli.terminal import columns, tell, write_answer

if TYPE_CHECKING:
    from gyrodata.readings import Readings
    from gyrodata.results import Analysis
    from gyrodata.trials.plan import Plan, PlannedRun


def _part_of(text: str) -> float:
    """Read "0.5%" or "0.5" as a part of I_zz [1]."""
    percent = text.removesuffix("%")
    return quantity("--goal", percent, "number", "above zero") / 100


def plan(
    *,
    log: Annotated[
        str | None,
        typer.Argument(
            metavar="[LOG]",
            help="The log so far; without one, the lab before it begins.",
        ),
    ] = None,
    weights: Annotated[
        Any,
        list_option(
            "--weights",
            "mass",
            "above zero",
            words="Masses of the weights. Default: those of the log.",
        ),
    ] = None,
    positions: Annotated[
        Any,
        list_option(
            "--positions",
            "length",
            "above zero",
            words="Positions on the rod. Default: those of the log.",
        ),
    ] = None,
    spins: Annotated[
        Any,
        list_option(
            "--spins",
            "rate",
            "above zero",
            words="Spins. Default: slow, middle and fast, as in the log.",
        ),
    ] = None,
    turns: Annotated[
        Any,
        list_option(
            "--turns",
            "number",
            "above zero",
            "NUMBERS",
            words="Numbers of turns that you can time.",
        ),
    ] = "1",
    minutes: Annotated[
        float, typer.Option("--minutes", min=0.0, help="Lab time that is left.")
    ] = 30.0,
    goal: Annotated[
        Any,
        typer.Option(
            "--goal",
            metavar="PERCENT",
            parser=_part_of,
            help="u of I_zz in % at which the plan ends, such as 0.5%.",
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", "-o", metavar="FILE", help="Write the runs as a log to fill in."
        ),
    ] = None,
    form: FormatOption = "text",
    settings: SettingsOption = None,
    mapping: MappingOption = None,
    config: ConfigOption = None,
) -> None:
    r"""List the runs that reduce u of I_zz most for each minute of lab time.

    With a LOG, gyro plans the runs that come next. Without one, it plans a lab with a
    typical ball. Each run is added to the lab as the fit predicts it, and the larger lab
    is fitted. --out writes a table to fill in, with the expected times; add its runs to
    the log.

    Example:  gyro plan demo.csv \
                --spins 200,400,600rpm \
                --minutes 20 --goal 0.5%
    """
    from gyrodata.trials.plan import Limits, plan_lab, plan_log

    limits = Limits(
        masses=weights or (),
        positions=positions or (),
        spins=spins or (),
        turns=turns,
        minutes=minutes,
        goal=goal,
    )
    if log is None:
        planned = plan_lab(limits)
    else:
        analysis = _analyzed(read([log], settings, mapping, config))
        planned = plan_log(analysis.lab, limits)
    if out != Path("-"):
        write_answer(form, planned.to_dict(), plan_text(planned, minutes))
    if out is not None:
        runs = map(_to_fill_in, (*planned.first, *planned.runs))
        write_table(out, log_to_fill_in(runs))


def _analyzed(readings: Readings) -> Analysis:
    """Analyze a log, and name the doubts about its answer."""
    from gyrodata.analysis import analyze_readings

    analysis = analyze_readings(readings)
    for doubt in analysis.doubts:
        tell(f"{analysis.name}: first find the cause of this: {doubt.words}")
    return analysis


# --- text ---


def plan_text(plan: Plan, minutes: float) -> str:
    """Write a plan as text: its runs, what it reaches, and what limits u then."""
    lines = []
    if plan.now is not None:
        lines += [
            f"u of I_zz is {_percent(plan.now)} now.",
            "The next run, the best for its time first:",
            *_table(plan.choices),
            "",
        ]
    if plan.minutes > minutes:
        lines.append(
            f"The first runs of a lab, which take more than {minutes:g} minutes:"
        )
    else:
        lines.append(f"A plan for {minutes:g} minutes, in this order:")
    runs = (*plan.first, *plan.runs)
    lines += _table(runs) if runs else [f"  No run: {plan.end}."]
    u = _percent(plan.u)
    lines += ["", f"Then u of I_zz is {u}, after {plan.minutes:.0f} minutes."]
    if plan.goal is not None and plan.u > plan.goal:
        lines.append(f"The goal of {_percent(plan.goal)} is not reached: {plan.end}.")
    elif plan.runs:
        lines.append(f"The plan ends here: {plan.end}.")
    lines.append(f"The largest uncertainty is then: {plan.limit}.")
    for role, example in plan.left_out.items():
        lines.append(f"Left out: runs of a doubtful {role}, such as {example}.")
    if plan.others:
        lines += ["", "What else would then reduce u:"]
    for other in plan.others:
        lines.append(f"  {other.words}: u {_percent(other.u)}")
    lines.append("")
    return "\n".join(lines)


def _table(runs: Sequence[PlannedRun]) -> list[str]:
    """Write runs in columns."""
    rows = [["load", "spin [rpm]", "turns", "time [s]", "minutes", "u then"]]
    for run in runs:
        time = f"{run.time:.1f}"
        minutes = f"{run.minutes:.1f}"
        rows.append(
            [_load(run), _rpm(run), _turns(run), time, minutes, _percent(run.u)]
        )
    return [f"  {line}" for line in columns()(rows)]


def _load(run: PlannedRun) -> str:
    if not run.mass:
        return "no weight"
    return f"{1e3 * run.mass:.4g} g at {100 * run.position:.4g} cm"


def _rpm(run: PlannedRun) -> str:
    from gyrodata.physics import RPM

    return f"{run.spin / RPM:.0f}"


def _turns(run: PlannedRun) -> str:
    """Write the turns; a run without a weight is watched for its time."""
    from gyrodata.judging.tables import turn_words

    return turn_words(run.turns).split(" ")[0] if run.mass else "as it comes"


def _percent(part: float) -> str:
    return f"{100 * part:.2g} %"


def _to_fill_in(run: PlannedRun) -> RunToFill:
    """Return the row of a run in a log to fill in; its note says what to aim at."""
    turns = ""
    time = "watch it for 3 minutes"
    if run.mass:
        turns = _turns(run)
        time = f"about {run.time:.1f} s"
    note = f"aim at {_rpm(run)} rpm ({time})"
    return RunToFill(run.mass, run.position, turns, note)
