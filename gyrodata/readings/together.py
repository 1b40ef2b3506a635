"""Several logs of one gyroscope, read as one log with a block for each."""

from __future__ import annotations

import hashlib
import math
from collections import ChainMap
from collections.abc import Iterator, Mapping, Sequence
from itertools import accumulate, chain
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
        A single one is returned as it is; several must be without errors.

    Returns
    -------
    Readings
        With the runs of all logs, in their order.

    Raises
    ------
    LogError
        If a log has errors, or if two logs contradict each other.
    """
    if len(logs) == 1:
        return logs[0]
    diagnostics = _without_errors(logs)
    lengths = [len(split_lines(log.source_text)) for log in logs]
    starts = [0, *accumulate(lengths)]
    files = tuple(zip(starts, logs, strict=False))
    blocks = _block_names(logs)
    digests = "".join(_all(logs, "sha256"))
    joined = replace(
        logs[0],
        name=" + ".join(_all(logs, "name")),
        sha256=hashlib.sha256(digests.encode()).hexdigest(),
        runs=_labels(_joined(logs, "runs"), blocks),
        lines=_lines(files),
        notes=_joined(logs, "notes"),
        screws=_joined(logs, "screws"),
        blocks=blocks,
        files=files,
        columns=_columns(files),
        others=(),
        constants=_merged(logs, "constants"),
        uncertainties=_uncertainties(logs),
        stated_at={},
        spin_down=_joined(logs, "spin_down"),
        position_from=_same(logs, "position_from"),
        origin_u=max(_all(logs, "origin_u")),
        metadata=_merged(logs, "metadata"),
        reported={},
        unmoved=None,
        unread=(),
        diagnostics=diagnostics,
        source_text="\n".join(_all(logs, "source_text")),
        sheets=tuple((start, log.name) for start, log in files),
        **{field: _same(logs, field) for field in _OF_BALANCE},
    )
    still = _all(logs, "unmoved")
    if None in still:
        return joined
    # A balance that was seen in all blocks.
    return _with_unmoved(joined, still)


def _without_errors(logs: Sequence[Readings]) -> tuple[Diagnostic, ...]:
    """Return the diagnostics of logs and of their contradictions; none is an error."""
    diagnostics = _joined(logs, "diagnostics")
    if not all(log.ok for log in logs):
        raise LogError(diagnostics)
    diagnostics = (*diagnostics, *_contradictions(logs))
    if any(note.severity == "error" for note in diagnostics):
        raise LogError(diagnostics)
    return diagnostics


def _with_unmoved(joined: Readings, still: Sequence[Readings]) -> Readings:
    """Add the runs in which the rod did not move, of all logs."""
    starts = [start for start, _ in joined.files]
    files = tuple(zip(starts, still, strict=True))
    unmoved = replace(
        joined,
        runs=_joined(still, "runs"),
        lines=_lines(files),
        notes=_joined(still, "notes"),
        screws=_joined(still, "screws"),
        blocks=(),
        columns=_columns(files),
    )
    return replace(joined, unmoved=unmoved)


def in_own_file(finding: Diagnostic, readings: Readings) -> Diagnostic:
    """Return a finding about joined logs with the place in the log that it is about."""
    if finding.file != readings.name or finding.line is None or not readings.files:
        return finding
    start, log = readings.files[readings.file_of(finding.line)]
    place = Place(finding.line - start, finding.column or 1)
    faults = Faults(log.name, log.source_text, log.sheets)
    return replace(finding, file=log.name, line=place.line, cell=faults.cell_of(place))


# Statements of the logs


def _contradictions(logs: Sequence[Readings]) -> list[Diagnostic]:
    """List what the logs say differently, and how they cannot be joined."""
    first = logs[0]
    notes: list[Diagnostic] = []
    for number, log in enumerate(logs[1:], 1):
        if log.sha256 in _all(logs[:number], "sha256"):
            notes.append(_say("log_given_twice", log))
        else:
            notes += _contradictions_of_two(first, log)
    return notes


def _contradictions_of_two(first: Readings, log: Readings) -> Iterator[Diagnostic]:
    """List what two logs say differently."""
    for key in sorted(first.constants.keys() & log.constants.keys()):
        if not math.isclose(first.constants[key], log.constants[key]):
            yield _compared("logs_contradict", first, log, key)
    for key in (*_MUST_AGREE, *_OF_BALANCE):
        if getattr(first, key) != getattr(log, key):
            name = "logs_contradict" if key in _MUST_AGREE else "logs_differ"
            yield _compared(name, first, log, key)
    yield from _unlike_columns(first, log)


def _unlike_columns(first: Readings, log: Readings) -> Iterator[Diagnostic]:
    """Yield an error if two logs have no common readings from which I_zz follows."""
    common = {*first.columns} & {*log.columns}
    lacking = roles.missing_roles(common, common)
    only = {*first.columns} ^ {*log.columns}
    lacking += sorted(only & {"transverse_inertia"})
    if lacking:
        columns = [", ".join(sorted(each.columns)) for each in (first, log)]
        values = {"other": first.name, "first": columns[0], "second": columns[1]}
        yield _say("logs_unlike", log, **values)


def _compared(name: str, first: Readings, log: Readings, key: str) -> Diagnostic:
    """Quote what two logs say of a key."""
    place, text = _line_of(log, key)
    _, other = _line_of(first, key)
    return _say(name, log, place, key=key, other=first.name, first=other, second=text)


def _line_of(log: Readings, key: str) -> tuple[Place | None, str]:
    """Return the line of a log that states a key, and its text."""
    for number, line in enumerate(split_lines(log.source_text), 1):
        small = line.lstrip("#; \t").lower().replace("-", " ")
        words = "_".join(small.split())
        behind = words.removeprefix(key)
        if behind == words:
            continue
        # "balance" is not the key of a line "balance_drift: …".
        if behind.startswith((":", "=", ",", ";")) or behind[1:2].isdigit():
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
    if field == "falling_mass":
        return ()
    return None


def _uncertainties(logs: Sequence[Readings]) -> Mapping[str, Uncertainty]:
    """Return the uncertainties that all logs state, and the widest of the hand."""
    same = dict(logs[0].uncertainties)
    for log in logs:
        stated = log.uncertainties
        same = {key: u for key, u in same.items() if stated.get(key) == u}
    usual = SOURCES["time_bias"].default
    hands = [log.uncertainties.get("u_time_bias", usual) for log in logs]
    widest = max(hands, key=lambda u: u.absolute)
    if widest == usual:
        return same
    return {**same, "u_time_bias": widest}


# Runs


def _block_names(logs: Sequence[Readings]) -> tuple[str, ...]:
    """Return the name of the block of each run: its log, and its day in the log."""
    stems = list(map(_stem, logs))
    if len(set(stems)) < len(stems):
        stems = [f"{log.name} ({number})" for number, log in enumerate(logs, 1)]
    names: list[str] = []
    for stem, log in zip(stems, logs, strict=True):
        of_blocks = [f"{stem} {block}" for block in log.blocks]
        names += of_blocks or [stem] * len(log.runs)
    return tuple(names)


def _stem(log: Readings) -> str:
    """Return the name of a file without its endings: "monday" of "monday.csv.gz"."""
    stem, _, _ = PurePath(log.name).name.partition(".")
    return stem or log.name


def _labels(runs: tuple[str, ...], blocks: tuple[str, ...]) -> tuple[str, ...]:
    """Return unique labels of all runs."""
    if len({*runs}) == len(runs):
        return runs
    pairs = zip(blocks, runs, strict=True)
    return tuple(f"{block} {run}" for block, run in pairs)


def _lines(files: Sequence[tuple[int, Readings]]) -> tuple[int, ...]:
    """Return the line of each run in the joined text."""
    lines: list[int] = []
    for start, log in files:
        lines.extend(line + start for line in log.lines)
    return tuple(lines)


def _all(logs: Sequence[Readings], field: str) -> list[Any]:
    """Return a field of each log."""
    return [getattr(log, field) for log in logs]


def _joined(logs: Sequence[Readings], field: str) -> tuple[Any, ...]:
    """Return the items of a field of all logs, one log after the other."""
    return tuple(chain.from_iterable(_all(logs, field)))


def _merged(logs: Sequence[Readings], field: str) -> dict[str, Any]:
    """Return what any of the logs states, the first one before the others."""
    return dict(ChainMap(*map(dict, _all(logs, field))))


def _columns(files: Sequence[tuple[int, Readings]]) -> dict[str, Column]:
    """Return the columns of all logs that are needed or possible in all of them."""
    columns = [log.columns for _, log in files]
    every_role = dict.fromkeys(chain.from_iterable(columns))
    used = _MAY_LACK.union(set(every_role).intersection(*columns))
    return {role: _column(role, files) for role in every_role if role in used}


def _column(role: str, files: Sequence[tuple[int, Readings]]) -> Column:
    """Return a column of all logs; blank cells for a log without it."""
    columns = []
    for _, log in files:
        count = len(log.runs)
        blank = _blank_column(role, count)
        columns.append(log.columns.get(role, blank))
    spots: list[int] = []
    for number, column in enumerate(columns):
        for spot in column.spots:
            # A value of a whole log is another reading in each log.
            moved = spot - number if spot < 0 else spot + number * _CELLS
            spots.append(moved)

    def find(spot: int) -> Place:
        number, cell = divmod(spot, _CELLS)
        place_of = columns[number].find
        assert place_of is not None
        place = place_of(cell)
        return Place(place.line + files[number][0], place.column)

    given = [log.columns[role] for _, log in files if role in log.columns]
    first = given[0]
    readings = tuple(chain.from_iterable(column.readings for column in columns))
    return replace(first, readings=readings, spots=tuple(spots), given=None, find=find)


def _blank_column(role: str, count: int) -> Column:
    """Return a column of a log that has none of its role."""
    readings = (Reading(),) * count
    spots = (-1,) * count
    return Column(role, "", "", readings, spots)
