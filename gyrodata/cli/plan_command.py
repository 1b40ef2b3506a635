"""``gyro plan``: which runs reduce the uncertainty most, before and during the lab."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gyrodata.base.disk import telling, write_whole
from gyrodata.cli import options
from gyrodata.cli.terminal import (
    columns,
    refuse,
    tell,
    write_out,
    write_text,
)

if TYPE_CHECKING:
    from gyrodata.readings import Readings
    from gyrodata.trials.plan import Limits, Plan, PlannedRun

HEADER = "mass [g],position [cm],spin [rpm],time [s],turns,precession_sense,note"


def plan(
    log: Annotated[str | None, typer.Argument(metavar="[LOG]")] = None,
    weights: Annotated[
        str | None, typer.Option("--weights", metavar="QUANTITIES")
    ] = None,
    positions: Annotated[
        str | None, typer.Option("--positions", metavar="QUANTITIES")
    ] = None,
    spins: Annotated[str | None, typer.Option("--spins", metavar="QUANTITIES")] = None,
    turns: Annotated[str, typer.Option("--turns", metavar="NUMBERS")] = "1",
    minutes: Annotated[float, typer.Option("--minutes", min=0.0)] = 30.0,
    goal: Annotated[str | None, typer.Option("--goal", metavar="PERCENT")] = None,
    out: Annotated[Path | None, typer.Option("--out", "-o", metavar="FILE")] = None,
    form: options.FormatOption = "text",
    settings: options.SettingsOption = None,
    mapping: options.MappingOption = None,
    config: options.ConfigOption = None,
) -> None:
    """List the runs that reduce u of I_zz most for each minute of lab time.

    With a LOG, gyro plans the runs that come next. Without one, it plans a lab with a
    typical ball. Each run is added to the lab as the fit predicts it, and the larger lab
    is fitted. --out writes a table to fill in, with the expected times.
    """
    from gyrodata.reporting.data import json_text
    from gyrodata.trials import plan as planning

    limits = planning.Limits(
        masses=_values("--weights", weights, "mass"),
        positions=_values("--positions", positions, "length"),
        spins=_values("--spins", spins, "rate"),
        turns=_values("--turns", turns, "number"),
        minutes=minutes,
        goal=_goal(goal),
    )
    if log is None:
        planned = planning.plan_lab(limits)
    else:
        planned = _plan_log(options.read([log], settings, mapping, config), limits)
    if form == "json":
        write_out(json_text(planned.to_dict()))
    else:
        write_text(plan_text(planned, minutes))
    if out is not None:
        _write_table(out, planned)


def _values(option: str, text: str | None, kind: str) -> tuple[float, ...]:
    """Read the values of an option; none if it is not given."""
    items = [] if text is None else options.with_units(text)
    values = [options.quantity(option, item, kind, "above zero") for item in items]
    return tuple(values)


def _goal(text: str | None) -> float | None:
    """Read "0.5%" or "0.5" as a part of I_zz [1]."""
    if text is None:
        return None
    percent = text.strip().removesuffix("%")
    return options.quantity("--goal", percent, "number", "above zero") / 100


def _plan_log(readings: Readings, limits: Limits) -> Plan:
    """Plan the next runs of a log, and name the doubts about its answer."""
    from gyrodata.analysis import analyze_readings
    from gyrodata.trials.plan import plan_log

    analysis = analyze_readings(readings)
    for doubt in analysis.doubts:
        tell(f"{analysis.name}: first find the cause of this: {doubt.words}")
    return plan_log(analysis.lab, limits)


# --- text ---


def plan_text(plan: Plan, minutes: float) -> str:
    """Write a plan as text."""
    blocks = []
    if plan.now is not None:
        now = f"u of I_zz is {_percent(plan.now)} now."
        blocks += [[now, "The next run, the best for its time first:"]]
        blocks[-1] += _table(plan.choices)
    runs = (*plan.first, *plan.runs)
    title = f"A plan for {minutes:g} minutes, in this order:"
    if plan.minutes > minutes:
        title = f"The first runs of a lab, which take more than {minutes:g} minutes:"
    blocks.append([title, *_table(runs)] if runs else [_nothing(plan)])
    blocks.append(_result(plan))
    if plan.others:
        lines = [f"  {other.words}: u {_percent(other.u)}" for other in plan.others]
        blocks.append(["What else would then reduce u:", *lines])
    return "\n\n".join("\n".join(lines) for lines in blocks) + "\n"


def _nothing(plan: Plan) -> str:
    """Say why a plan contains no run."""
    if plan.goal is not None and plan.u <= plan.goal:
        return "No run is needed: the goal is reached."
    return "No run that fits into the time reduces u by more than 1 %."


def _result(plan: Plan) -> list[str]:
    """Say what the plan reaches, and what limits u then."""
    lines = [f"Then u of I_zz is {_percent(plan.u)}, after {plan.minutes:.0f} minutes."]
    if plan.goal is not None and plan.u > plan.goal:
        lines.append(
            f"The goal of {_percent(plan.goal)} is not reached within these limits."
        )
    lines.append(f"The largest uncertainty is then: {plan.limit}.")
    return lines


def _table(runs: Sequence[PlannedRun]) -> list[str]:
    """Write runs in columns."""
    heads = ["load", "spin [rpm]", "turns", "time [s]", "minutes", "u then"]
    rows = [
        [
            _load(run),
            _rpm(run),
            _turns(run),
            f"{run.time:.1f}",
            f"{run.minutes:.1f}",
            _percent(run.u),
        ]
        for run in runs
    ]
    return [f"  {line}" for line in columns()([heads, *rows])]


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


# --- the table to fill in ---


def _write_table(out: Path, plan: Plan) -> None:
    """Write the runs of a plan as a log to fill in."""
    if out.exists():
        refuse("template_exists", out=out)
    lines = [HEADER]
    for run in (*plan.first, *plan.runs):
        aim = f"aim at {_rpm(run)} rpm"
        if run.mass:
            load = f"{1e3 * run.mass:.6g},{100 * run.position:.6g}"
            note = f"{aim} (about {run.time:.1f} s)"
            lines.append(f"{load},,,{_turns(run)},,{note}")
        else:
            lines.append(
                f"0,,,,,,no weight on the rod (watch it for 3 minutes and {aim})"
            )
    with telling(out):
        write_whole(out, ["".join(f"{line}\n" for line in lines).encode()])
    tell(f"table to fill in: {out}")
