"""Steps of the lab procedure that are missing in a log, with reasons in numbers.

The procedure: at least three weights, each with at least three well-spread spins; one
run without a weight; times over 6 s; the spin at start and end if it falls much.
Students should check this before they leave the lab.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence

import numpy as np

from gyrodata.base.errors import Diagnostic, count_text
from gyrodata.judging import changes
from gyrodata.judging.tables import load_words
from gyrodata.measurements import Measurements
from gyrodata.measurements.checks import derived_values, unit_size
from gyrodata.measurements.sources import timing_column
from gyrodata.physics import RPM, Floats
from gyrodata.quantities.numerals import PLAIN
from gyrodata.readings import Column, Readings
from gyrodata.readings.lablog import split_lines
from gyrodata.readings.roles import missing_roles

SHORT = 6.0
"""A time below this [s] is short: the usual error of a hand, 0.14 s, is over 2 % of it.
"""

SPREAD = 1.8
"""The spins of a weight are well spread if the largest is at least this many times the
smallest: 302 to 599 rpm is what a student gets who wants a factor of 2."""

FALL = 0.10
"""If the spin falls by more than this part, the decay law matters."""


PROCEDURE = ("G451", "G452", "G453", "G454", "G455", "G456")
"""Steps of the procedure, each as the diagnostic that reports a missing step."""

ADVICE = {*PROCEDURE, "G407", "G414", "G418", "G426"}
"""Diagnostics about better measurements; the answer is correct without them."""


def what_lacks(
    readings: Readings,
    measured: Measurements,
    lab: changes.Lab | None,
    asked: Collection[str] = PROCEDURE,
) -> list[Diagnostic]:
    """List the missing steps among those asked for.

    Without a fit, only those that need none.
    """
    left_out = lab.left_out if lab else ()
    findings = list(_weights_and_spins(readings, measured, left_out))
    if lab and "G454" in asked:
        findings += _unloaded(readings, lab)
    findings += _times_and_falls(readings, measured)
    return [finding for finding in findings if finding.code in asked]


def _weights_and_spins(
    readings: Readings, measured: Measurements, left_out: Collection[int]
) -> Iterator[Diagnostic]:
    """Ask for three weights, and for three spins of each that are far enough apart.

    A weight of which all runs are left out is perhaps misread: more runs with it are
    not needed.
    """
    groups = measured.by_weight
    if len(groups) < 3:
        torques = [1e3 * measured.torque[group[0]] for group in groups]
        values = " and ".join([f"{torque:.3g}" for torque in torques])
        count = count_text(len(groups), "torque")
        yield readings.say("too_few_weights", torques=count, values=values)
    for group in groups:
        spins = np.sort(measured.spin[group])
        lacking = 3 - len(group)
        is_doubted = {*group} <= {*left_out}
        if is_doubted or (lacking <= 0 and spins[-1] >= SPREAD * spins[0]):
            continue
        name = load_words(measured, group[0])
        place = readings.place(max(group))
        have = spins / RPM
        if lacking > 0:
            runs = count_text(len(group), "run")
            more = count_text(lacking, "run")
            yield readings.say("too_few_runs", place, load=name, runs=runs, more=more)
        else:
            low, high = have[0], have[-1]
            yield readings.say("spins_too_close", place, load=name, low=low, high=high)


def _unloaded(readings: Readings, lab: changes.Lab) -> Iterator[Diagnostic]:
    """Ask for a run without a weight, if u of I_zz would be smaller with one."""
    signs = set(np.sign(lab.measured.torque).tolist())
    if 0.0 in signs or len(signs) > 1 or readings.unmoved:
        return
    for _, now, then in changes.gains(lab, "unloaded_run"):
        rows = _with_unloaded_run(readings, lab) or OTHER_ROWS
        yield readings.say("no_unloaded_run", now=now, then=then, rows=rows)


SENSE = "precession_sense"

OTHER_ROWS = f"""\
mass [g],position [cm],spin [rpm],time [s],turns,{SENSE}
20.00,15.0,400,39.7,1,ccw
0,,400,180,1/20,ccw"""
"""Rows to copy if those of the log cannot be written as lines."""


def _with_unloaded_run(readings: Readings, lab: changes.Lab) -> str:
    """Write the header, the first run and one without a weight, with directions."""
    [change] = changes.CHANGES["unloaded_run"](lab)
    mark, rows = rows_to_add(readings, change.measured, [-1])
    if SENSE not in readings.columns:
        for cells, text in zip(rows, (SENSE, "ccw", "ccw"), strict=False):
            cells.append(text)
    elif rows:
        at = rows[0].index(readings.columns[SENSE].header)
        rows[-1][at] = "ccw"
    return "\n".join([mark.join(cells) for cells in rows])


def rows_to_add(
    readings: Readings, measured: Measurements, runs: Sequence[int]
) -> tuple[str, list[list[str]]]:
    """Write runs in the columns of a log.

    Parameters
    ----------
    readings : Readings
        The log.
    measured : Measurements
        Its runs and more, such as those of a plan.
    runs : sequence of int
        Indices of the runs to write, in `measured`.

    Returns
    -------
    mark : str
        The sign between the cells of the log.
    rows : list of list of str
        The cells of the header, of the first run as typed, and of `runs`; empty if a run
        is not one line of the log, or has readings that do not follow from `measured`.
    """
    timing = timing_column(readings.columns)
    mark, headers, first = _first_rows(readings, timing.header)
    columns: dict[str, Column] = {}
    values: dict[str, Floats] = {}
    derived = derived_values(measured)
    for column in (*readings.columns.values(), timing):
        role = column.role.removesuffix("_start").removesuffix("_end")
        if column.header in headers and role in derived:
            columns[column.header] = column
            values[column.header] = np.nan_to_num(derived[role])
    there = {"position", *[column.role for column in columns.values()]}
    if missing_roles(there, there, loaded=True) or len(first) != len({*headers}):
        return mark, []
    has_commas = mark != "," and re.search(r"[0-9],[0-9]", mark.join(first))
    decimal_mark = "," if has_commas else "."
    rows = [headers, first]
    for run in runs:
        cells = dict.fromkeys(headers, "")
        for header, column in columns.items():
            text = _cell_text(column, values[header][run])
            cells[header] = text.replace(".", decimal_mark)
        rows.append([*cells.values()])
    return mark, rows


def _first_rows(readings: Readings, title: str) -> tuple[str, list[str], list[str]]:
    """Return the sign between the cells of a log, its header, and its first run.

    The header is the first line that contains `title`.
    """
    lines = split_lines(readings.source_text)
    header = next((line for line in lines if title in line), "")
    mark = max(";\t,", key=header.count)
    first = "".join(lines[readings.lines[0] - 1 : readings.lines[0]])
    return mark, [cell.strip(' "') for cell in header.split(mark)], first.split(mark)


def _cell_text(column: Column, value: float) -> str:
    """Write a value [SI unit] like the first cell of a column, with three digits."""
    number = float(f"{value / unit_size(column):.3g}")
    first = column.readings[0].text
    if PLAIN.fullmatch(first) or column.role == "turns":
        return f"{number:g}"
    return f"{number:g} {column.unit}"


def _times_and_falls(
    readings: Readings, measured: Measurements
) -> Iterator[Diagnostic]:
    """Ask for longer times, and for shorter ones if the spin falls much."""
    short = np.flatnonzero(measured.time < SHORT)
    if measured.timed and len(short):
        worst = int(short[np.argmin(measured.time[short])])
        time = measured.time[worst]
        place = readings.place(worst)
        times = count_text(len(short), "time")
        runs = measured.run_words(short)
        percent = 100 * 0.14 / time
        values = {"limit": SHORT, "time": time, "percent": percent}
        yield readings.say("times_too_short", place, times=times, runs=runs, **values)
    if measured.spin_start is None or measured.spin_end is None:
        return
    fall = 1 - measured.spin_end / measured.spin_start
    far = np.flatnonzero(fall > FALL)
    if len(far):
        worst = int(far[np.argmax(fall[far])])
        most = 100 * fall[worst]
        run = measured.runs[worst]
        place = readings.place(worst)
        runs = measured.run_words(far)
        yield readings.say("spin_falls_too_much", place, runs=runs, most=most, run=run)
