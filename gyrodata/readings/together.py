"""Several logs of one gyroscope, read as one log with a block for each."""

from __future__ import annotations

import hashlib
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import accumulate
from pathlib import PurePath
from typing import Any

from msgspec.structs import replace

from gyrodata.base.errors import Diagnostic, LogError
from gyrodata.quantities.error_sources import SOURCES
from gyrodata.quantities.units import Uncertainty
from gyrodata.readings import roles
from gyrodata.readings.lablog import (
    Column,
    Faults,
    Place,
    Reading,
    Readings,
    split_lines,
)

_CELLS = 2**40
"""Difference of the numbers of equal cells in two logs, more than there are cells."""

_MUST_AGREE = ("motion", "tachometer")
"""Statements about all runs of a fit."""

_OF_BALANCE = ("balanced", "balance", "balance_tilt", "balance_drift", "falling_mass")
"""Statements that are used only if all logs have the same."""

_MAY_LACK = frozenset(
    ("pitch", "spin_sense", "precession_sense", "weight_diameter", "nutation_period")
)
"""Roles that a log need not have because another one has them."""


def read_together(logs: Sequence[Readings]) -> Readings:
    """Join logs of one gyroscope, each a block of its own.

    Parameters
    ----------
    logs : sequence of Readings
        At least two, without errors.

    Returns
    -------
    Readings
        With the runs of all logs, in their order.

    Raises
    ------
    LogError
        If a log has errors, or if two logs contradict each other.
    """
    found = [finding for log in logs for finding in log.diagnostics]
    if not all(log.ok for log in logs):
        raise LogError(found)
    notes = _contradictions(logs)
    if any(note.severity == "error" for note in notes):
        raise LogError([*found, *notes])
    starts = [0, *accumulate(len(split_lines(log.source_text)) for log in logs)]
    files = tuple(zip(starts, logs, strict=False))
    names = _names(logs)
    joined = replace(
        logs[0],
        name=" + ".join(log.name for log in logs),
        sha256=hashlib.sha256("".join(log.sha256 for log in logs).encode()).hexdigest(),
        runs=_labels(logs, names),
        lines=tuple(line + start for start, log in files for line in log.lines),
        notes=_all(logs, "notes"),
        screws=_all(logs, "screws"),
        blocks=tuple(
            name for log, each in zip(logs, names, strict=True) for name in each
        ),
        files=files,
        columns=_columns(files),
        others=(),
        constants={key: log.constants[key] for log in logs for key in log.constants},
        uncertainties=_uncertainties(logs),
        stated_at={},
        spin_down=_all(logs, "spin_down"),
        position_from=_same(logs, "position_from"),
        origin_u=max(log.origin_u for log in logs),
        metadata={key: log.metadata[key] for log in logs for key in log.metadata},
        reported={},
        unmoved=None,
        unread=(),
        diagnostics=(*found, *notes),
        source_text="\n".join(log.source_text for log in logs),
        sheets=tuple((start, log.name) for start, log in files),
        **{field: _same(logs, field) for field in _OF_BALANCE},
    )
    still = [log.unmoved for log in logs]
    if None not in still:
        # A balance that was seen in all blocks.
        return replace(joined, unmoved=_joined_unmoved(joined, still))
    return joined


def _joined_unmoved(joined: Readings, still: Sequence[Any]) -> Readings:
    """Return the runs in which the rod did not move, of all logs."""
    files = tuple(zip([start for start, _ in joined.files], still, strict=True))
    return replace(
        joined,
        runs=_all(still, "runs"),
        lines=tuple(line + start for start, log in files for line in log.lines),
        notes=_all(still, "notes"),
        screws=_all(still, "screws"),
        blocks=(),
        columns=_columns(files),
    )


def in_own_file(finding: Diagnostic, readings: Readings) -> Diagnostic:
    """Return a finding about joined logs with the place in the log that it is about."""
    if not readings.files or finding.file != readings.name or finding.line is None:
        return finding
    start, log = readings.files[readings.file_of(finding.line)]
    place = Place(finding.line - start, finding.column or 1)
    faults = Faults(log.name, log.source_text, log.sheets)
    return replace(finding, file=log.name, line=place.line, cell=faults.cell_of(place))


# What the logs say


def _contradictions(logs: Sequence[Readings]) -> list[Diagnostic]:
    """List what the logs say differently, and how they cannot be joined."""
    first = logs[0]
    notes: list[Diagnostic] = []
    for number, log in enumerate(logs[1:], start=1):
        if any(log.sha256 == other.sha256 for other in logs[:number]):
            notes.append(_say("log_given_twice", log))
            continue
        both = first.constants.keys() & log.constants.keys()
        values = first.constants
        differ = [key for key in sorted(both) if values[key] != log.constants[key]]
        differ += [key for key in _MUST_AGREE if _differ(first, log, key)]
        notes += [_compared("logs_contradict", first, log, key) for key in differ]
        notes += _unlike_columns(first, log)
        notes += [
            _compared("logs_differ", first, log, key)
            for key in _OF_BALANCE
            if _differ(first, log, key)
        ]
    return notes


def _differ(first: Readings, log: Readings, field: str) -> bool:
    return bool(getattr(first, field) != getattr(log, field))


def _unlike_columns(first: Readings, log: Readings) -> list[Diagnostic]:
    """Return an error if two logs have no common readings from which I_zz follows."""
    common = {*first.columns} & {*log.columns}
    lacking = roles.missing_roles(common, common, loaded=True)
    only = {*first.columns} ^ {*log.columns}
    lacking += sorted(only & {"transverse_inertia"})
    if not lacking:
        return []
    columns = [", ".join(sorted(each.columns)) for each in (first, log)]
    return [
        _say("logs_unlike", log, other=first.name, first=columns[0], second=columns[1])
    ]


def _compared(name: str, first: Readings, log: Readings, key: str) -> Diagnostic:
    """Quote what two logs say of a key."""
    place, text = _line_of(log, key)
    _, other = _line_of(first, key)
    return _say(name, log, place, key=key, other=first.name, first=other, second=text)


def _line_of(log: Readings, key: str) -> tuple[Place | None, str]:
    """Return the line of a log that states a key, and its text."""
    for number, line in enumerate(split_lines(log.source_text), start=1):
        if re.match(rf"\W*{key}\W", line, re.IGNORECASE):
            return Place(number, 1), f'"{line.strip()}"'
    return None, f'no line "# {key}"'


def _say(
    name: str, log: Readings, place: Place | None = None, /, **values: Any
) -> Diagnostic:
    return log.say(name, place, file=log.name, **values)


def _same(logs: Sequence[Readings], field: str) -> Any:
    """Return what all logs say in a field; its default if they differ."""
    first = getattr(logs[0], field)
    if all(getattr(log, field) == first for log in logs):
        return first
    return () if field == "falling_mass" else None


def _uncertainties(logs: Sequence[Readings]) -> Mapping[str, Uncertainty]:
    """Return the uncertainties that all logs state, and the widest of the hand."""
    first = logs[0].uncertainties
    same = {
        key: u
        for key, u in first.items()
        if all(log.uncertainties.get(key) == u for log in logs)
    }
    usual = SOURCES["time_bias"].default
    hands = [log.uncertainties.get("u_time_bias", usual) for log in logs]
    widest = max(hands, key=lambda u: u.absolute)
    return same if widest == usual else {**same, "u_time_bias": widest}


# Runs


def _names(logs: Sequence[Readings]) -> list[list[str]]:
    """Return the name of the block of each run, for each log."""
    stems = [PurePath(log.name).name.partition(".")[0] or log.name for log in logs]
    if len({*stems}) < len(stems):
        stems = [log.name for log in logs]
    counts = Counter(stems)
    names = []
    for number, (log, stem) in enumerate(zip(logs, stems, strict=True), start=1):
        name = stem if counts[stem] == 1 else f"{stem} ({number})"
        blocks = [f"{name} {block}" for block in log.blocks]
        names.append(blocks or [name] * len(log.runs))
    return names


def _labels(logs: Sequence[Readings], names: Sequence[list[str]]) -> tuple[str, ...]:
    """Return unique labels of all runs."""
    runs = list(_all(logs, "runs"))
    if len({*runs}) == len(runs):
        return tuple(runs)
    blocks = [name for each in names for name in each]
    return tuple(f"{block} {run}" for block, run in zip(blocks, runs, strict=True))


def _all(logs: Sequence[Readings], field: str) -> tuple[Any, ...]:
    """Return the items of a field of all logs, one log after the other."""
    return tuple(item for log in logs for item in getattr(log, field))


def _columns(files: Sequence[tuple[int, Readings]]) -> dict[str, Column]:
    """Return the columns of all logs that are needed or possible in all of them."""
    logs = [log for _, log in files]
    every_role = dict.fromkeys(role for log in logs for role in log.columns)
    used = [
        role
        for role in every_role
        if role in _MAY_LACK or all(role in log.columns for log in logs)
    ]
    return {role: _column(role, files) for role in used}


def _column(role: str, files: Sequence[tuple[int, Readings]]) -> Column:
    """Return a column of all logs; blank cells for a log without it."""
    readings: list[Reading] = []
    spots: list[int] = []
    for number, (_, log) in enumerate(files):
        column = log.columns.get(role)
        count = len(log.runs)
        readings += column.readings if column else [Reading()] * count
        shift = number * _CELLS
        each = column.spots if column else [-1] * count
        spots += [spot if spot < 0 else spot + shift for spot in each]
    first = next(log.columns[role] for _, log in files if role in log.columns)
    starts = [start for start, _ in files]
    finds = [
        log.columns[role].find if role in log.columns else None for _, log in files
    ]

    def find(spot: int) -> Place:
        number, cell = divmod(spot, _CELLS)
        place_of = finds[number]
        assert place_of is not None
        place = place_of(cell)
        return Place(place.line + starts[number], place.column)

    return replace(
        first, readings=tuple(readings), spots=tuple(spots), given=None, find=find
    )
