"""Turn a gyroscope lab's log into its moment of inertia, with a realistic uncertainty.

`analyze` reads a log (a path, an open file, text or a DataFrame) and returns an
`Analysis`. The names below are loaded when they are first used, so that ``gyro --help``
starts at once.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from gyrodata.base.version import __version__ as __version__

if TYPE_CHECKING:
    from gyrodata.api import Analysis, GyroWarning, analyze, read_log, sample
    from gyrodata.base.errors import Diagnostic, GyroError, InputError, LogError
    from gyrodata.fitting import LineFit, fit_line
    from gyrodata.grading.classroom import ClassGrades, grade
    from gyrodata.readings import Readings, Uncertainty
    from gyrodata.results import Result
    from gyrodata.trials.coverage import SelfCheck, selfcheck
    from gyrodata.trials.simulation import Design, Simulation, Truth, simulate

_HOMES = {
    "Analysis": "api",
    "ClassGrades": "grading.classroom",
    "Design": "trials.simulation",
    "Diagnostic": "base.errors",
    "GyroError": "base.errors",
    "GyroWarning": "api",
    "InputError": "base.errors",
    "LineFit": "fitting",
    "LogError": "base.errors",
    "Readings": "readings",
    "Result": "results",
    "SelfCheck": "trials.coverage",
    "Simulation": "trials.simulation",
    "Truth": "trials.simulation",
    "Uncertainty": "readings",
    "analyze": "api",
    "fit_line": "fitting",
    "grade": "grading.classroom",
    "read_log": "api",
    "sample": "api",
    "selfcheck": "trials.coverage",
    "simulate": "trials.simulation",
}

__all__ = [
    "Analysis",
    "ClassGrades",
    "Design",
    "Diagnostic",
    "GyroError",
    "GyroWarning",
    "InputError",
    "LineFit",
    "LogError",
    "Readings",
    "Result",
    "SelfCheck",
    "Simulation",
    "Truth",
    "Uncertainty",
    "__version__",
    "analyze",
    "fit_line",
    "grade",
    "read_log",
    "sample",
    "selfcheck",
    "simulate",
]


# Hidden from type checkers: with it they would accept any attribute name.
if not TYPE_CHECKING:

    def __getattr__(name):
        if name not in _HOMES:
            raise AttributeError(f"module 'gyrodata' has no attribute {name!r}")
        from importlib import import_module

        return getattr(import_module(f"gyrodata.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
