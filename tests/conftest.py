"""Which tests are slow: all in `acceptance`, and those elsewhere with the mark `slow`."""

from __future__ import annotations

from pathlib import Path

import pytest
from places import ACCEPTANCE


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Do not even load the slow folder for `-m "not slow"`."""
    if config.option.markexpr == "not slow" and collection_path == ACCEPTANCE:
        return True
    return None


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if item.path.is_relative_to(ACCEPTANCE):
            item.add_marker(pytest.mark.slow)
