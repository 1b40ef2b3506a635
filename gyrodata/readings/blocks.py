"""The day or the group of each run, from a column of texts."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from gyrodata.readings.lablog import BLANKS, Column, Readings
from gyrodata.readings.names import exact_roles
from gyrodata.readings.roles import LOADS

BLOCKS = ("day", "group")
"""Roles of a column that says to which block a run belongs; the first one is used."""

NO_BLOCKS = "its cells do not divide the runs into days or groups"
"""Why a column of one of these roles is not used."""

_CLOCK = re.compile(r"(?i)(^|T|(?<!\s)\s+)\d{1,2}:\d\d(:\d\d)?(\s?[ap]m)?$")
"""A time of the day behind a date."""


def find_blocks(
    texts: Mapping[str, Sequence[str]], columns: Mapping[str, Column]
) -> tuple[str, tuple[str, ...]]:
    """Return the role that divides the runs into blocks, and the block of each run.

    `texts` contains the cells of the columns of these roles. Without blocks, the
    results are empty.
    """
    for role in BLOCKS:
        names = _names(texts[role])
        is_divided = 1 < len({*names}) < len(names)
        if not is_divided or "" in names:
            continue
        # A group that is a weight in all its runs numbers the weights.
        if role == "day" or not _are_weights(names, columns):
            return role, names
    return "", ()


def only_day(texts: Sequence[str]) -> str:
    """Return the day of a column in which all runs are of one day, or ""."""
    names = {*_names(texts)}
    if len(names) == 1:
        return names.pop()
    return ""


def day_of(readings: Readings) -> str:
    """Return the day that a line or a column gives for a whole log, or ""."""
    for key, text in readings.metadata.items():
        words = key.replace("_", " ")
        if "day" in exact_roles(words):
            return _without_clock(text)
    return ""


def _without_clock(text: str) -> str:
    return _CLOCK.sub("", text).strip()


def _names(texts: Sequence[str]) -> tuple[str, ...]:
    """Return the block of each cell, as it was typed first.

    A blank cell belongs to the block above, and a time of the day does not belong to a
    date.
    """
    typed: dict[str, str] = {}
    names: list[str] = []
    for text in texts:
        name = _without_clock(text)
        if text in BLANKS:
            name = names[-1] if names else ""
        names.append(typed.setdefault(name.casefold(), name))
    return tuple(names)


def _are_weights(names: Sequence[str], columns: Mapping[str, Column]) -> bool:
    """Return whether each block has one load, and each load is in one block."""
    values = [columns[role].values for role in LOADS if role in columns]
    loads = list(zip(*values, strict=True)) or [()] * len(names)
    pairs = {*zip(names, loads, strict=True)}
    return len(pairs) == len({*names}) == len({*loads})
