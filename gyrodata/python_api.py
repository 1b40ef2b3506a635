"""The functions of ``import gyrodata`` that read logs.

They do the same as the functions of `analysis` and `readings`. In addition, they warn
about the diagnostics of a log, and write remedies in the syntax of Python instead of
options of the command.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import ParamSpec, TypeVar

from msgspec.structs import astuple, replace

from gyrodata import analysis, readings
from gyrodata.errors import Diagnostic, GyroError

P = ParamSpec("P")
R = TypeVar("R", analysis.Analysis, readings.Readings)

_ARGUMENTS = {"set": "settings", "map": "mapping", "config": "config"}
_PAIR = r"""--(set|map) (\w+)=("[^"]*"|'[^']*'|[^\s;,?)]+)"""
_OTHERS = {f"--{option}": argument for option, argument in _ARGUMENTS.items()} | {
    "--keep-flagged": "keep_flagged=True",
    "gyro analyze --format csv prints that table": "the attribute runs contains that table",
}


class GyroWarning(UserWarning):
    """A warning about a log, one for each code of its warnings, as `gyro analyze` prints them.

    ``warnings.simplefilter("ignore", gyrodata.GyroWarning)`` hides these warnings.
    """


class PythonDiagnostic(Diagnostic, frozen=True):
    """A diagnostic that prints its remedy in the syntax of Python."""

    def __str__(self) -> str:
        return in_python(super().__str__())


def in_python(text: str) -> str:
    """Replace options such as ``--set g=9.8`` by arguments such as ``settings={"g": "9.8"}``."""

    def arguments(found: re.Match[str]) -> str:
        given: dict[str, list[str]] = {}
        for option, key, value in re.findall(_PAIR, found[0]):
            value = value.strip("\"'")
            given.setdefault(_ARGUMENTS[option], []).append(f'"{key}": "{value}"')
        return ", ".join(
            f"{name}={{{', '.join(pairs)}}}" for name, pairs in given.items()
        )

    text = re.sub(f"{_PAIR}(?: {_PAIR})*", arguments, text)
    text = re.sub(
        r"--(set|map|config) (\w+)(?=:)",
        lambda found: f'{_ARGUMENTS[found[1]]}["{found[2]}"]',
        text,
    )
    text = re.sub(r"--model (\w+)", r'model="\1"', text)
    for option, argument in _OTHERS.items():
        text = text.replace(option, argument)
    return text


def _with_warnings(function: Callable[P, R]) -> Callable[P, R]:
    """Let a function warn about the diagnostics of its log, with remedies in the syntax of Python, also in errors."""

    @wraps(function)
    def called(*args: P.args, **kwargs: P.kwargs) -> R:
        try:
            result = function(*args, **kwargs)
        except GyroError as error:
            raise type(error)(
                PythonDiagnostic(*astuple(one)) for one in error.diagnostics
            ) from None
        told = [PythonDiagnostic(*astuple(one)) for one in result.diagnostics]
        warned = [one for one in told if one.severity == "warning"]
        for code in dict.fromkeys([one.code for one in warned]):
            first, *others = [one for one in warned if one.code == code]
            more = (
                f"\n   and {len(others)} more, see the attribute diagnostics"
                if others
                else ""
            )
            warnings.warn(f"{first}{more}", GyroWarning, stacklevel=2)
        return replace(result, diagnostics=tuple(told))

    return called


analyze = _with_warnings(analysis.analyze)
read_log = _with_warnings(readings.read_log)


def sample() -> Path:
    """Return the path of a log that is part of the package: ten runs, simulated with I_zz = 4.44e-3 kg·m².

    Returns
    -------
    Path

    Examples
    --------
    >>> import gyrodata
    >>> lab = gyrodata.analyze(gyrodata.sample())
    >>> print(lab.inertia)
    0.004429±0.000034 kg·m²
    """
    return Path(__file__).with_name("docs") / "demo.csv"
