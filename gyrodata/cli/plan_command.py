"""``gyro plan``: which runs reduce the uncertainty most, before and during the lab."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from msgspec.structs import replace

from gyrodata.cli import options
from gyrodata.cli.new_table import write_table
from gyrodata.cli.terminal import columns, tell, write_answer

if TYPE_CHECKING:
    from gyrodata.readings import Column, Readings
    from gyrodata.results import Analysis, FittedLog
    from gyrodata.trials.plan import Plan, PlannedRun

HEADER = "mass [g],position [cm],spin [rpm],time [s],turns,precession_sense"


def _part_of(text: str) -> float:
    """Read "0.5%" or "0.5" as a part of I_zz [1]."""
    percent = text.strip().removesuffix("%")
    return options.quantity("--goal", percent, "number", "above zero") / 100


def plan(
    log: Annotated[
        str | None,
        typer.Argument(
            metavar="[LOG]",
            help="The log so far; without one, the lab before it begins.",
        ),
    ] = None,
    weights: Annotated[
        Any,
        options.list_option(
            "--weights",
            "mass",
            "above zero",
            words="Masses of the weights. Default: those of the log.",
        ),
    ] = None,
    positions: Annotated[
        Any,
        options.list_option(
            "--positions",
            "length",
            "above zero",
            words="Positions on the rod. Default: those of the log.",
        ),
    ] = None,
    spins: Annotated[
        Any,
        options.list_option(
            "--spins",
            "rate",
            "above zero",
            words="Spins. Default: slow, middle and fast, as in the log.",
        ),
    ] = None,
    turns: Annotated[
        Any,
        options.list_option(
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
    form: options.FormatOption = "text",
    settings: options.SettingsOption = None,
    mapping: options.MappingOption = None,
    config: options.ConfigOption = None,
) -> None:
    r"""List the runs that reduce u of I_zz most for each minute of lab time.

    With a LOG, gyro plans the runs that come next. Without one, it plans a lab with a
    typical ball. Each run is added to the lab as the fit predicts it, and the larger lab
    is fitted. --out writes a table to fill in, with the expected times.

    Example:  gyro plan demo.csv \
                --spins 200,400,600rpm \
                --minutes 20 --goal 0.5%
    """
    from gyrodata.trials import plan as planning

    limits = planning.Limits(
        masses=weights or (),
        positions=positions or (),
        spins=spins or (),
        turns=turns,
        minutes=minutes,
        goal=goal,
    )
    fitted = None
    if log is None:
        planned = planning.plan_lab(limits)
    else:
        fitted = _analyzed(options.read([log], settings, mapping, config))
        planned = planning.plan_log(fitted.lab, limits)
    if out != Path("-"):
        write_answer(form, planned.to_dict(), plan_text(planned, minutes))
    if out is not None:
        write_table(out, _log_to_fill_in(planned, fitted))


def _analyzed(readings: Readings) -> Analysis:
    """Analyze a log, and name the doubts about its answer."""
    from gyrodata.analysis import analyze_readings

    analysis = analyze_readings(readings)
    for doubt in analysis.doubts:
        tell(f"{analysis.name}: first find the cause of this: {doubt.words}")
    return analysis


# --- text ---


def plan_text(plan: Plan, minutes: float) -> str:
    """Write a plan as text."""
    lines = []
    if plan.now is not None:
        lines += [f"u of I_zz is {_percent(plan.now)} now."]
        lines += ["The next run, the best for its time first:"]
        lines += [*_table(plan.choices), ""]
    title = f"A plan for {minutes:g} minutes, in this order:"
    if plan.minutes > minutes:
        title = f"The first runs of a lab, which take more than {minutes:g} minutes:"
    runs = (*plan.first, *plan.runs)
    lines += [title, *_table(runs)] if runs else [f"No run: {plan.end}."]
    lines += ["", *_result(plan)]
    if plan.others:
        lines += ["", "What else would then reduce u:"]
        lines += [f"  {other.words}: u {_percent(other.u)}" for other in plan.others]
    return "\n".join(lines) + "\n"


def _result(plan: Plan) -> list[str]:
    """Say what the plan reaches, and what limits u then."""
    lines = [f"Then u of I_zz is {_percent(plan.u)}, after {plan.minutes:.0f} minutes."]
    if plan.goal is not None and plan.u > plan.goal:
        lines.append(f"The goal of {_percent(plan.goal)} is not reached: {plan.end}.")
    elif plan.runs:
        lines.append(f"The plan ends here: {plan.end}.")
    lines.append(f"The largest uncertainty is then: {plan.limit}.")
    for role, example in plan.left_out.items():
        lines.append(f"Left out: runs of a doubtful {role}, such as {example}.")
    return lines


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


def _log_to_fill_in(plan: Plan, log: FittedLog | None) -> str:
    """Write the runs of a plan as a log to fill in, in the columns of the log so far.

    What to aim at is in a line above each run.
    """
    runs = (*plan.first, *plan.runs)
    rows = _in_columns_of(log, runs) if log else []
    rows = rows or [HEADER, *map(_usual_row, runs)]
    lines = rows[:1]
    for run, row in zip(runs, rows[1:], strict=True):
        time = f"about {run.time:.1f} s" if run.mass else "watch it for 3 minutes"
        lines += [f"# aim at {_rpm(run)} rpm ({time})", row]
    return "\n".join(lines) + "\n"


def _usual_row(run: PlannedRun) -> str:
    """Write a run in the columns of `HEADER`; spin and time are blank."""
    if not run.mass:
        return "0,,,,,"
    return f"{1e3 * run.mass:.6g},{100 * run.position:.6g},,,{_turns(run)},"


def _in_columns_of(log: FittedLog, runs: Sequence[PlannedRun]) -> list[str]:
    """Write runs in the columns of a log: the header, and a row for each run.

    The list is empty if the log has no columns for the load, or counts positions from
    another point than the centre of the ball.
    """
    import numpy as np

    from gyrodata.judging.procedure import SENSE, rows_to_add
    from gyrodata.measurements import select

    there = log.readings.columns
    if not {"mass", "position"} <= there.keys() or log.readings.position_from:
        return []
    values = np.array([(run.mass, run.position, run.turns) for run in runs]).T
    planned = select(log.measurements, [0] * len(runs))
    planned = replace(planned, mass=values[0], position=values[1], turns=values[2])
    mark, rows = rows_to_add(log.readings, planned, range(len(runs)))
    if not rows:
        return []
    columns = {column.header: column for column in there.values()}
    known = zip(log.measurements.mass, log.measurements.position, strict=True)
    like = {load: run for run, load in enumerate(known)}
    for run, cells in zip(runs, rows[2:], strict=True):
        number = like.get((run.mass, run.position))
        for at, header in enumerate(rows[0]):
            cells[at] = _cell(columns.get(header), run, number, cells[at])
    blank, sense = ("", "") if SENSE in there else (mark, SENSE)
    header, _, *lines = [mark.join(cells) + blank for cells in rows]
    return [header + sense, *lines]


def _cell(column: Column | None, run: PlannedRun, like: int | None, text: str) -> str:
    """Return a cell of a planned run; what is measured in the run is blank.

    `like` is a run of the log with the same load, whose cells have the digits of the log.
    """
    from gyrodata.readings.roles import COUNTS, LOADS

    role = column.role if column else ""
    if column and role in LOADS and like is not None:
        return column.readings[like].text
    # Without a weight, nobody knows how far the rod will turn.
    return text if role in LOADS or (role in COUNTS and run.mass) else ""
