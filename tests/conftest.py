"""Which tests are slow: all in `acceptance`, and those elsewhere with the mark `slow`."""

from __future__ import annotations

import pytest
from places import ACCEPTANCE


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if item.path.is_relative_to(ACCEPTANCE):
            item.add_marker(pytest.mark.slow)
