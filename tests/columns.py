"""Looks into a column of readings, for the tests of the reader."""

from __future__ import annotations

from typing import Any

from gyrodata.readings import Column


def of(column: Column, field: str) -> tuple[Any, ...]:
    """One field of each reading."""
    return tuple(getattr(reading, field) for reading in column.readings)


def shared(column: Column) -> tuple[int, ...]:
    """Which runs share a reading, numbered in order of appearance."""
    numbers: dict[int, int] = {}
    return tuple(numbers.setdefault(spot, len(numbers)) for spot in column.spots)
