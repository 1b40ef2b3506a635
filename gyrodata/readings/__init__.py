"""The reader: a lab log from CSV, standard input, a workbook or a DataFrame becomes `Readings` in SI.

The reader accepts many forms, but it never guesses what would change the answer. It reports every fault in one pass,
with its place and what to type.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from msgspec.structs import replace

from gyrodata.readings import choice, lablog, layout, table
from gyrodata.readings import source as sources
from gyrodata.readings.lablog import Column, Faults, Place, Reading, Readings, Reported, listing, read_reported
from gyrodata.readings.roles import SHARED_UNCERTAINTIES, as_u_of, check_value, kind_of_role, to_display, u_keys
from gyrodata.readings.source import MAX_BYTES, MAX_ROWS, decode, value_text
from gyrodata.readings.table import rounded_turns
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
        ``--set``: values for the whole log, such as ``{"turns": "1", "g": "9.803 m/s^2"}``; text, a quantity of
        pint or a number of uncertainties.
    mapping : mapping of str to str
        ``--map``: role to header as written.
    config : path, optional
        TOML file with more settings; `settings` replace them.

    Returns
    -------
    Readings
        With all diagnostics. If none is an error, every run has a time with its turns or angle (or a
        precession period or rate), a spin (or what gives one), and a load (mass and position, force and
        position, or torque).

    Raises
    ------
    InputError
        The source is not a readable log at all, or an option is wrong.
    TypeError
        An argument has a wrong type.
    """
    checked: dict[str, tuple[object, Any]] = {"name": (name, str | None), "config": (config, str | os.PathLike | None)}
    checked |= {"settings": (settings, Mapping), "mapping": (mapping, Mapping)}
    for what, (value, kinds) in checked.items():
        if not isinstance(value, kinds):
            raise TypeError(f"{what} cannot be {type(value).__name__} ({value!r:.60})")
    for text in (*settings, *mapping, *mapping.values()):
        if not isinstance(text, str):
            raise TypeError(f"a key of settings or mapping, or a header, cannot be {type(text).__name__}")
    options = lablog.read_options({key: value_text(value) for key, value in settings.items()}, mapping, config)
    grid, faults = sources.load(source, name)
    ask = sources.decimal_signs(grid) != {","}
    given = lablog.read_settings(grid.metadata, grid.comments, options, faults, ask)
    given.origin = table.read_notes(grid, faults)
    grid, falls = layout.split_spin_down(grid)
    given.fields["spin_down"] = (*given.fields.get("spin_down", ()), *falls)
    log = Readings(faults.name, grid.sha256, source_text="\n".join(faults.lines), sheets=faults.sheets, **given.fields)
    log = replace(log, constants=given.constants, uncertainties=given.uncertainties, reported=given.reported)
    stated_at = {key: item.place for key, item in given.given_uncertainties.items()}
    log = replace(log, metadata=given.metadata, stated_at=stated_at)
    found = layout.find_layout(grid, faults)
    if found is None:
        return replace(log, diagnostics=faults.all_told())
    chosen = choice.choose(found, mapping, given, faults)
    log, unmoved = table.TableReader(found, chosen, given, faults).read(log)
    if not log.runs and not faults.has_error():
        faults.add("no_timed_runs")
    else:
        if log.runs and len(unmoved) == len(log.runs):
            faults.add("no_torque")
        unread = {role for role in chosen.used if role not in log.columns} if faults.has_error() else set()
        table.check_meaning(log, chosen, unread | given.unread, faults, is_told="precession_period" in mapping)
    moved = [run for run in range(len(log.runs)) if run not in unmoved]
    if unmoved and moved:
        log = replace(log.select(moved), unmoved=log.select(sorted(unmoved)))
    return replace(log, diagnostics=faults.all_told())
