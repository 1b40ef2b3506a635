"""The room's records: none can be written to once it is there, and what each is where nothing is told."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Iterator

import msgspec

from gyrodata import grading

WRITTEN_TO = ("_Assignment", "_Entry", "_Live", "_User", "Sheet")
"""What is read of a file and taken apart at once, and a sheet, which is filled."""


def records() -> Iterator[type[msgspec.Struct]]:
    for module in pkgutil.walk_packages(grading.__path__, "gyrodata.grading."):
        for value in vars(importlib.import_module(module.name)).values():
            if isinstance(value, type) and issubclass(value, msgspec.Struct) and value.__module__ == module.name:
                yield value


def test_no_record_can_be_written_to() -> None:
    assert sorted({one.__name__ for one in records() if not one.__struct_config__.frozen}) == sorted(WRITTEN_TO)


def test_what_a_person_writes_is_held_to_the_keys_that_are_known() -> None:
    assert {one.__name__ for one in records() if one.__struct_config__.forbid_unknown_fields} == {
        "BenchTable", "LateException", "LateRule", "References", "Source", "Station", "Tier", "_File",
    }  # fmt: skip


def test_a_submission_is_in_time_and_the_first_where_nothing_is_told() -> None:
    told = {}
    for one in records():
        for name, default in zip(one.__struct_fields__[::-1], one.__struct_defaults__[::-1], strict=False):
            if isinstance(default, int | float):
                told[f"{one.__name__}.{name}"] = default
    assert told == {
        "ClassGrades.lost": False, "GradingOptions.keep": True, "GradingOptions.limit": 30, "GradingOptions.workers": 1,
        "LateException.waive": False, "Metadata.attempt": 1, "ParsedName.late": False, "Submission.attempt": 1,
        "Submission.late": False,
    }  # fmt: skip
