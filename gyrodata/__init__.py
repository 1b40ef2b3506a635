"""From a gyroscope lab's log to its moment of inertia, with an uncertainty that can be trusted.

``analyze`` is the front door: a path, standard input, text or a DataFrame in, an `Analysis` out.
The names below are loaded when they are first used, so that ``gyro --help`` starts at once.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from gyrodata.analysis import analyze
    from gyrodata.errors import Diagnostic, GyroError, InputError, LogError
    from gyrodata.fitting import LineFit, fit_line
    from gyrodata.readings import Readings, read_log
    from gyrodata.results import Analysis

__all__ = [
    "Analysis",
    "Diagnostic",
    "GyroError",
    "InputError",
    "LineFit",
    "LogError",
    "Readings",
    "__version__",
    "analyze",
    "fit_line",
    "read_log",
]

_HOMES = {
    "Analysis": "results",
    "analyze": "analysis",
    "Diagnostic": "errors",
    "GyroError": "errors",
    "InputError": "errors",
    "LineFit": "fitting",
    "fit_line": "fitting",
    "LogError": "errors",
    "Readings": "readings",
    "read_log": "readings",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'gyrodata' has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(f"gyrodata.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
