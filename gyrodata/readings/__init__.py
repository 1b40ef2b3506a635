"""The reader: a lab log from CSV, standard input, a workbook or a DataFrame becomes `Readings` in SI.

Strict about meaning, generous about form: nothing is guessed that would change the answer, and every fault is
told in one pass, with its place and what to type.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from msgspec.structs import asdict, replace

from gyrodata import diagnostics as codes
from gyrodata.errors import insist_on_type
from gyrodata.quantities import CellError, read_cell
from gyrodata.readings.columns import check_meaning, choose, note_unplaced, warn_of_notes
from gyrodata.readings.lablog import (
    MOST_OF_ONE_CODE,
    Column,
    Faults,
    Place,
    Reading,
    Readings,
    Reported,
    check_value,
    listing,
    read_reported,
    rounded_turns,
    split_lines,
)
from gyrodata.readings.layout import Layout, find_layout
from gyrodata.readings.roles import (
    SHARED_UNCERTAINTIES,
    as_u_of,
    kind_of_role,
    parse_header,
    stated_u,
    to_display,
    u_keys,
)
from gyrodata.readings.settings import Settings, read_options, read_settings, read_uncertainty, warn_of_lost_keys
from gyrodata.readings.source import MAX_BYTES, MAX_ROWS, decimal_signs, decode, is_frame, load, value_text
from gyrodata.readings.spin_down import split_table
from gyrodata.readings.table import TableReader
from gyrodata.readings.writing import blank_log, fixed_log, write_log
from gyrodata.units import Uncertainty

if TYPE_CHECKING:
    from gyrodata.readings.source import Source


_NOTHING: Mapping[str, str] = MappingProxyType({})


def read_log(
    source: Source,
    *,
    name: str | None = None,
    settings: Mapping[str, Any] = _NOTHING,
    mapping: Mapping[str, str] = _NOTHING,
    config: str | os.PathLike[str] | None = None,
) -> Readings:
    """Read a lab log.

    Parameters
    ----------
    source : path, "-", bytes, open file, DataFrame, or str of several lines
        The log; ``-`` is standard input.
    name : str, optional
        Name to show instead of the source's own.
    settings : mapping
        ``--set``: what holds for the whole log, such as ``{"turns": "1", "g": "9.803 m/s^2"}``; text, a quantity of
        pint or a number of uncertainties.
    mapping : mapping of str to str
        ``--map``: role to header as written.
    config : path, optional
        TOML file with more settings; they win over `settings`.

    Returns
    -------
    Readings
        With all diagnostics. Where none is an error, every run has a time with its turns or angle (or a
        precession period or rate), a spin (or what gives one), and a load (mass and position, force and
        position, or torque).

    Raises
    ------
    InputError
        The source is no readable log at all, or an option makes no sense.
    TypeError
        An argument is nothing that it can be.
    """
    known = isinstance(source, str | os.PathLike | bytes | bytearray | memoryview) or hasattr(source, "read")
    if not known and not is_frame(source):
        what = f"{type(source).__name__} ({source!r:.60})"
        raise TypeError(f"a log is a path, its text or bytes, an open file or a DataFrame, not {what}")
    insist_on_type("name", name, str | None, "the name to call the log by")
    for argument, options in (("settings", settings), ("mapping", mapping)):
        insist_on_type(argument, options, Mapping, "a mapping, such as a dict")
    for text in (*settings, *mapping, *mapping.values()):
        insist_on_type("a key of settings or mapping, or a header", text, str, "a text")
    insist_on_type("config", config, str | os.PathLike | None, "the path of a TOML file")
    stated = read_options(settings, mapping, config)
    grid, faults = load(source, name)
    given = read_settings(grid.metadata, stated, faults, ask=decimal_signs(grid) != {","})
    warn_of_lost_keys(grid.comments, faults)
    warn_of_notes(grid, faults)
    grid, falls = split_table(grid)
    given.spin_down = (*given.spin_down, *falls)
    whole = {key: value for key, value in asdict(given).items() if key in Readings.__struct_fields__}
    whole["stated_at"] = {key: item.place for key, item in given.given_uncertainties.items()}
    log = Readings(faults.name, grid.sha256, (), (), (), {}, **whole, source_text="\n".join(faults.lines))
    if layout := find_layout(grid, faults):
        log = _read_table(layout, mapping, given, faults, log)
    return replace(log, diagnostics=faults.all_told())


def _read_table(layout: Layout, mapping: Mapping[str, str], given: Settings, faults: Faults, log: Readings) -> Readings:
    """Read the runs, and say what they lack."""
    choice = choose(layout, mapping, given, faults)
    log, unmoved = TableReader(layout, choice, given, faults).read(log)
    if not log.runs and not faults.has_error():
        hint = "a row without a time is no run: fill the times in"
        faults.add(codes.HEADER_WITHOUT_RUNS, "there is not one run with a time in this log", hint)
        return log
    if log.runs and len(unmoved) == len(log.runs):
        hint = "add runs with a weight: mass and position"
        faults.add(codes.NO_TORQUE, "no run has a torque, and the rod never moved", hint)
    unread = {role for role in choice.used if role not in log.columns} if faults.has_error() else set()
    check_meaning(log, choice, unread | given.unread, faults, is_told="precession_period" in mapping)
    if not any(diagnostic.code == codes.QUANTITY_MISSING for diagnostic in faults.found):
        note_unplaced(choice, faults)
    moved = [run for run in range(len(log.runs)) if run not in unmoved]
    if unmoved and moved:
        return replace(log.select(moved), unmoved=log.select(sorted(unmoved)))
    return log


def with_uncertainties(readings: Readings, given: Mapping[str, Uncertainty]) -> tuple[Readings, set[str]]:
    """Add uncertainties, by the keys of their lines, where a log states nothing of its own; give the keys of those."""
    stated = readings.uncertainties.keys()
    known = {key: u for key, u in given.items() if stated.isdisjoint(u_keys(key.removeprefix("u_")))}
    if readings.balance_tilt or readings.balance_drift or readings.balanced is not None:
        known.pop("u_imbalance", None)
    columns = dict(readings.columns)
    shared = {key: u for key, u in known.items() if key in SHARED_UNCERTAINTIES}
    used = set(shared)
    by_period = [columns[role] for role in ("precession_period", "precession_rate") if role in columns]
    for role, column in readings.columns.items():
        u = stated_u(role, known)
        elsewhere = role == "time" and any(len(one.stated) == len(one.readings) for one in by_period)
        if u is not None and not column.stated and not elsewhere:
            columns[role] = replace(column, readings=tuple(replace(reading, u=u) for reading in column.readings))
            used |= {next(key for key in u_keys(role) if key in known)}
    return replace(readings, columns=columns, uncertainties={**readings.uncertainties, **shared}), used
