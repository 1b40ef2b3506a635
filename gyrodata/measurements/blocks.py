"""Days or groups of one lab: what changes between them, and what they share.

A block is a day, a group of students, or a file that is analysed with others. Each
block has its own M0, hand and placed positions. I_zz, the ruler, the scale and the
tachometer are those of all blocks, unless the log says otherwise.

The values of K blocks are independent and have the same prior. So their mean has a
prior of 1/√K of its width, and K − 1 differences (orthonormal contrasts) have the width
itself: the fit has its M0 and b for the mean, and a `Source` for each contrast.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec.structs import replace

from gyrodata.measurements.sources import Source, list_sources, number_groups
from gyrodata.physics import Floats, Integers
from gyrodata.quantities.error_sources import SOURCES
from gyrodata.readings import Readings

if TYPE_CHECKING:
    from gyrodata.measurements.measured import Measurements

BALANCE_CHANGE = "balance_change"
"""Name of the difference of M0 between weights."""

ESTIMATED = "estimated from the runs"
"""Default of such a difference, in words."""

DAY_BALANCE = "residual_torque"
DAY_BIAS = "time_bias"
"""Names of the differences of M0 and of b between blocks, as in the budget."""

PLACED = ("position", "position_set")
"""Errors that a weight has until it is set again: they are new on another day."""

INSTRUMENTS = {"position_zero": "ruler", "mass": "scale", "mass_scale": "scale"}
"""Errors of an instrument, with the line "# ruler: 2" that names another one."""

EACH_DAY = "each day"
"""What the line of an instrument says if it was another one in each block."""


def share_of_mean(block: Integers) -> float:
    """Return the width of the mean of all blocks over that of a single one [1]."""
    return 1 / math.sqrt(max(len({*block.tolist()}), 1))


def contrasts(block: Integers) -> Floats:
    """Return orthonormal contrasts between the K blocks of n runs, shape (K − 1, n).

    They are the contrasts of Helmert: each block with the mean of those before it.
    """
    numbers = sorted({*block.tolist()})
    of_run = np.searchsorted(numbers, block)
    before = np.arange(1, len(numbers))[:, None]
    sizes = np.where(of_run == before, before, -(of_run < before).astype(float))
    return np.asarray(sizes / np.sqrt(before * (before + 1)))


def contrast_sources(
    name: str, quantity: Any, block: Integers, width: float, shared_by: str = ""
) -> Iterator[Source]:
    """List the differences of a quantity between blocks, each of a width [SI]."""
    nothing = np.zeros(len(block))
    everyone = np.zeros(len(block), dtype=int)
    for contrast in contrasts(block):
        yield Source(
            name,
            quantity,
            everyone,
            width * contrast,
            nothing,
            shared_by,
            usual=ESTIMATED,
        )


def balance_sources(measured: Measurements, width: float, level: float) -> list[Source]:
    """List the differences of M0 and of b that the fit estimates.

    M0 of each day has the prior width `width` [N*m], and differs between weights by
    `level` [N*m].
    """
    block = measured.day
    bias = measured.timing_bias_u
    by_hand = SOURCES["time_bias"].shared_by
    nothing = np.zeros(len(block))
    of_weights = Source(
        BALANCE_CHANGE,
        "balance",
        measured.balance_groups,
        nothing + level,
        nothing,
        "runs with the same weight",
        usual=ESTIMATED,
    )
    return [
        of_weights,
        *contrast_sources(DAY_BALANCE, "balance", block, width, "all runs"),
        *contrast_sources(DAY_BIAS, "time", block, bias, by_hand),
    ]


def sources_of(readings: Readings, measured: Measurements) -> tuple[Source, ...]:
    """List the sources of error of a log, by what its blocks share.

    The uncertainties that a file states are those of its runs.
    """
    if measured.one_block:
        return tuple(list_sources(readings, measured))
    of_file = np.array([readings.file_of(line) for line in readings.lines])
    stated = [_stated_in(file, readings, measured) for file in _files(readings)]
    names = dict.fromkeys(chain.from_iterable(stated))
    sources = []
    for name in names:
        versions = [by_name.get(name) for by_name in stated]
        sources.append(_merged(versions, of_file))
    return tuple([_divided(each, readings, of_file, measured) for each in sources])


def _files(readings: Readings) -> list[Readings]:
    """Return the logs of which a log consists."""
    return [log for _, log in readings.files] or [readings]


def _stated_in(
    file: Readings, readings: Readings, measured: Measurements
) -> dict[str, Source]:
    """Return the sources by name, with the uncertainties that one file states."""
    as_stated = replace(
        readings,
        uncertainties=file.uncertainties,
        position_set=file.position_set,
        origin_u=file.origin_u,
    )
    return {source.name: source for source in list_sources(as_stated, measured)}


def _merged(versions: list[Source | None], of_file: Integers) -> Source:
    """Merge what each file states of one source; None: the file has no such error.

    Files that state the same share the error. Two statements are about two instruments:
    then each file has its own error, with the size that it states.
    """
    known = [version for version in versions if version]
    first = known[0]
    sizes = _sizes(first)
    is_alike = all(np.array_equal(sizes, _sizes(other)) for other in known)
    if is_alike and len(known) == len(versions):
        return first
    whole = np.zeros_like(sizes)
    whole[2] = -1
    for number, version in enumerate(versions):
        if version:
            runs = of_file == number
            whole[:, runs] = _sizes(version)[:, runs]
    absolute, relative, groups = whole
    keys = zip(of_file.tolist(), groups.tolist(), strict=True)
    return replace(
        first,
        absolute=absolute,
        relative=relative,
        groups=number_groups([*keys], groups >= 0),
        default=any(source.default for source in known),
    )


def _sizes(source: Source) -> Floats:
    """Return the absolute and relative error and the group of each run, shape (3, n)."""
    return np.array([source.absolute, source.relative, source.groups])


def _divided(
    source: Source, readings: Readings, of_file: Integers, measured: Measurements
) -> Source:
    """Return a source whose groups end with the day, or with the instrument."""
    if source.name in PLACED:
        keys = measured.day.tolist()
    elif source.name in INSTRUMENTS:
        keys = _instruments(INSTRUMENTS[source.name], readings, of_file, measured)
    else:
        return source
    pairs = list(zip(keys, source.groups.tolist(), strict=True))
    return replace(source, groups=number_groups(pairs, source.groups >= 0))


def _instruments(
    key: str, readings: Readings, of_file: Integers, measured: Measurements
) -> list[Any]:
    """Return the ruler or scale of each run, as the lines of its file name it."""
    labels = [
        log.metadata.get(key, log.metadata.get(key.title(), "")).strip().lower()
        for log in _files(readings)
    ]
    pairs = zip(of_file.tolist(), measured.day.tolist(), strict=True)
    return [
        (labels[file], block if labels[file] == EACH_DAY else -1)
        for file, block in pairs
    ]
