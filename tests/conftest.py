"""Which tests are slow: all in `acceptance`, and those elsewhere with the mark `slow`.

All tests together hold so many objects that looking for garbage among them takes longer
than a short test: what is there before the tests of a module is not looked at again.
"""

from __future__ import annotations

import gc
import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from places import ACCEPTANCE


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Do not even load the slow folder for `-m "not slow"`."""
    if config.option.markexpr == "not slow" and collection_path == ACCEPTANCE:
        return True
    return None


# As gyro does at its start: threads for small matrices wait for each other.
for library in ("OPENBLAS", "OMP", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")


def pytest_configure(config: pytest.Config) -> None:
    """Ignore warnings about logs: a filter in `pyproject.toml` would load numpy, which
    reads the number of threads, before it is set here.
    """
    # The mutants are collected without any filter.
    if config.getini("filterwarnings"):
        config.addinivalue_line("filterwarnings", "ignore::gyrodata.GyroWarning")


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[None]:
    """Collect without a search for garbage: nearly all of it stays."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()


def pytest_runtest_logstart(nodeid: str) -> None:
    """Freeze what is left before the first test of each module."""
    module = nodeid.partition("::")[0]
    if module not in SEEN:
        SEEN.add(module)
        gc.collect()
        gc.freeze()


OF_SAME_LOGS = {
    *("cli", "gates", "grading", "judging", "physics", "readings"),
    *("relations", "reporting", "tests", "trials"),
}
"""Folders whose tests analyse or grade the same log again and again. Tests of the fit
itself draw new labs, and looking whether they were fitted would cost them time."""


@pytest.fixture(scope="module", autouse=True)
def fits_are_kept(request: pytest.FixtureRequest) -> Iterator[None]:
    """Fit the same log once for all tests of `OF_SAME_LOGS`."""
    if request.path.parent.name not in OF_SAME_LOGS:
        yield
        return
    # Not all tests load the fit.
    from fitted_once import fitted_once

    with fitted_once():
        yield


@pytest.fixture(scope="session", autouse=True)
def templates_are_kept() -> Iterator[None]:
    """Compile the templates of pages once in a process."""
    from kept_templates import templates_kept

    with templates_kept():
        yield


SEEN: set[str] = set()
"""The modules of which a test was begun in this process."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if item.path.is_relative_to(ACCEPTANCE):
            item.add_marker(pytest.mark.slow)
