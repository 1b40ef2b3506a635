"""Ask for everything that a log lacks, and report what contradicts itself."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import chain

from msgspec.structs import replace

from gyrodata.base import diagnostics
from gyrodata.readings import layout, roles
from gyrodata.readings.compared import counted_turns, turns_of
from gyrodata.readings.lablog import Column, Faults, Place, Readings, listing
from gyrodata.readings.layout import Choice
from gyrodata.readings.roles import kind_of_role, missing_roles
from gyrodata.readings.suggestions import ask_for

_WHOLE = 1e-3
"""Difference from one turn that is not due to rounding."""
_SAME_TURNS = 0.02


def check_completeness(
    log: Readings,
    choice: Choice,
    table: layout.Layout,
    unread: set[str],
    faults: Faults,
) -> None:
    """Add a fault for everything that is missing or contradicts itself.

    `unread` are the roles that are there, and that could not be read.
    """
    _set_lonely_apart(log, choice)
    missing = _missing_from_log(log, choice, unread)
    if missing:
        ask_for(missing, choice, table, faults)
    elif not _is_uncertain(unread | choice.asked, faults):
        _report_runs_that_lack(log, faults)
    if "precession_period" in log.columns.keys() - choice.mapped:
        _check_period(log.columns, faults)
    idle = [column.text for column in choice.unplaced]
    if idle and not missing:
        plural = "s" if len(idle) > 1 else ""
        faults.add("headers_unknown", s=plural, headers=listing(idle))


def _set_lonely_apart(log: Readings, choice: Choice) -> None:
    """Put uncertainties without a reading to the columns without a role."""
    known = set(chain.from_iterable(map(roles.u_keys, log.columns)))
    choice.unplaced += [
        columns[0]
        for key, columns in choice.used.items()
        if key.startswith("u_") and key not in known
    ]


def _missing_from_log(log: Readings, choice: Choice, unread: set[str]) -> list[str]:
    there = unread.union(log.columns)
    mass = log.columns.get("mass")
    loaded = (
        mass is None or "force" in there or any(value != 0 for value in mass.values)
    )
    needless = set(choice.asked)
    if "precession_period" in choice.asked:
        needless.add("turns")  # needed or not, by what is answered
    missing = missing_roles(there, log.columns, loaded)
    return [role for role in missing if role not in needless]


def _is_uncertain(unread: set[str], faults: Faults) -> bool:
    """Return whether blank cells may be due to a fault that is reported already."""
    codes = {fault.code for fault in faults.diagnostics}
    if diagnostics.VALUE_BELOW_ITS_FIRST_ROW in codes:
        return True
    readings = [role for role in unread if not role.startswith("u_")]
    return any(kind_of_role(role) != "text" for role in readings)


def _report_runs_that_lack(log: Readings, faults: Faults) -> None:
    """Report the runs without a quantity that the log has for others."""
    lines: dict[str, list[int]] = {}
    columns = log.columns
    mass = columns.get("mass")
    for run, line in enumerate(log.lines):
        typed = {role for role, column in columns.items() if column.readings[run].text}
        loaded = mass is None or mass.values[run] != 0
        if len(typed) < len(columns):
            for role in missing_roles(typed, columns, loaded):
                lines.setdefault(role, []).append(line)
    for role, of_role in lines.items():
        name = "run_lacks_turns" if role in roles.COUNTS else "run_lacks"
        unique = list(dict.fromkeys(of_role))
        faults.add(name, Place(unique[0], 1), lines=unique, role=role)


def without_wrong_runs(log: Readings) -> Readings | None:
    """Return a log without the runs whose cells cannot be read, and without messages.

    None if more is wrong: a header, a line for the whole log, or what all runs need.
    """
    wrong = {fault.line for fault in log.diagnostics if fault.severity == "error"}
    are_of_runs = wrong <= set(log.lines)
    if not are_of_runs or missing_roles(set(log.columns), log.columns):
        return None
    complete = [run for run, line in enumerate(log.lines) if line not in wrong]
    for column in log.columns.values():
        complete = [run for run in complete if column.values[run] is not None]
    return replace(log.select(complete), diagnostics=()) if complete else None


# Contradictions


def _check_period(columns: Mapping[str, Column], faults: Faults) -> None:
    """Ask if a period may not be the time of one turn: I_zz would be very wrong."""
    period = columns["precession_period"]
    time = columns.get("time")
    counted = counted_turns(columns)
    if counted is None:
        return
    if time is None:
        _ask_for_counted_turns(period, counted, faults)
    elif time.header != period.header and _are_exchanged(time, period, counted):
        faults.add("exchanged", period.cell(0), period=period.header, time=time.header)


def _ask_for_counted_turns(period: Column, counted: Column, faults: Faults) -> None:
    """Ask if the time of one turn has another number of turns."""
    known = filter(None, turns_of(counted))
    if all(abs(abs(turns) - 1) < _WHOLE for turns in known):
        return
    places = filter(None, map(counted.place, range(len(counted.readings))))
    place = next(places, period.place(0))
    faults.add(
        "turns_for_one_period", place, header=period.header, counted=counted.role
    )


def _are_exchanged(time: Column, period: Column, counted: Column) -> bool:
    """Return whether most periods are the turns times the time."""
    runs = zip(time.values, period.values, turns_of(counted), strict=True)
    exchanged = []
    for seconds, value, turns in runs:
        count = abs(turns)
        if seconds and value and count and not 0.8 < count < 1.25:
            gap = abs(value / seconds - count)
            exchanged.append(gap < _SAME_TURNS * count)
    return 2 * sum(exchanged) > len(exchanged)
