"""The interface of Python: what ``import gyrodata`` gives to a user.

`analyze` and `read_log` do the same as the functions of `gyrodata.analysis` and
`gyrodata.readings`. In addition, they warn about the diagnostics of a log, and write
remedies in the syntax of Python instead of options of the command. `Analysis` adds to
the data of an analysis what draws it, prints it, and simulates its lab.
"""

from __future__ import annotations

import os
import re
import warnings
from base64 import b64encode
from collections.abc import Callable, Iterable
from functools import wraps
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, ParamSpec, TypeVar

from msgspec.structs import astuple, replace

from gyrodata import analysis, readings, results
from gyrodata.base.disk import write_folder
from gyrodata.base.errors import Diagnostic, GyroError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from gyrodata.trials.coverage import SelfCheck

P = ParamSpec("P")
R = TypeVar("R", results.Analysis, readings.Readings)
S = TypeVar("S", "Analysis", readings.Readings)

_ARGUMENTS = {"set": "settings", "map": "mapping", "config": "config"}
# "--set g=9.8" or "--map mass='my weight'": an option, a key and a value.
_PAIR = r"""--(set|map) (\w+)=("[^"]*"|'[^']*'|[^\s;,?)]*[^\s;,?).])"""
_OTHERS = {f"--{option}": argument for option, argument in _ARGUMENTS.items()} | {
    "--keep-flagged": "keep_flagged=True",
    "gyro analyze --format csv prints that table": (
        "the attribute runs contains that table"
    ),
}


class GyroWarning(UserWarning):
    """A warning about a log, one for each code, as `gyro analyze` prints them.

    ``warnings.simplefilter("ignore", gyrodata.GyroWarning)`` hides these warnings.
    """


class PythonDiagnostic(Diagnostic, frozen=True):
    """A diagnostic that prints its remedy in the syntax of Python.

    Its attributes contain the texts of the command line, as the JSON does.
    """

    def __str__(self) -> str:
        return in_python(super().__str__())


def in_python(text: str) -> str:
    """Replace options of the command line by arguments of `analyze`.

    ======================== ==========================
    command line             Python
    ======================== ==========================
    --set g=9.8 --set u=0.2  settings={"g": "9.8", …}
    --set latitude: …        settings["latitude"]: …
    --set                    settings
    --model steady           model="steady"
    ======================== ==========================

    Examples
    --------
    >>> in_python("--set g=9.8 --set u_time=0.2, or --map mass=weight.")
    'settings={"g": "9.8", "u_time": "0.2"}, or mapping={"mass": "weight"}.'
    >>> in_python("--set latitude: not known; --model steady")
    'settings["latitude"]: not known; model="steady"'
    """
    # In the order of the table: the first lines contain the third one.
    text = re.sub(f"{_PAIR}(?: {_PAIR})*", _arguments, text)
    text = re.sub(r"--(set|map|config) (\w+)(?=:)", _item, text)
    text = re.sub(r"--model (\w+)", r'model="\1"', text)
    for option, argument in _OTHERS.items():
        text = text.replace(option, argument)
    return text


def _item(option: re.Match[str]) -> str:
    """Write an option and its key as an item of an argument."""
    return f'{_ARGUMENTS[option[1]]}["{option[2]}"]'


def _arguments(options: re.Match[str]) -> str:
    """Write neighbouring options as arguments, with one mapping for each argument."""
    pairs: dict[str, list[str]] = {}
    for option, key, value in re.findall(_PAIR, options[0]):
        unquoted = value[1:-1] if value[0] in "\"'" else value
        escaped = unquoted.replace("\\", r"\\").replace('"', r"\"")
        pairs.setdefault(option, []).append(f'"{key}": "{escaped}"')
    arguments = []
    for option, pairs_of_option in pairs.items():
        mapping = ", ".join(pairs_of_option)
        arguments.append(f"{_ARGUMENTS[option]}={{{mapping}}}")
    return ", ".join(arguments)


class Analysis(results.Analysis, frozen=True, eq=False):
    """The complete result of a log, in SI units; two are equal if their JSON is equal.

    It adds to the attributes of `gyrodata.results.Analysis` what draws the result,
    prints it, and simulates its lab. Each method is one call of a function below, so
    that the class is a list of what users can do.
    """

    def __str__(self) -> str:
        return summary(self)

    def summary(self) -> str:
        """Return the answer and the findings as text, as ``print(lab)`` shows them."""
        return summary(self)

    def selfcheck(self, labs: int = 1000, seed: int = 1) -> SelfCheck:
        """Simulate this lab many times and count how often its intervals contain I_zz.

        See `gyrodata.selfcheck`.
        """
        return selfcheck(self, labs, seed)

    def plot(self, name: str = "torque", ax: Axes | None = None) -> Axes:
        """Draw one of the figures of the report.

        Parameters
        ----------
        name : {"period", "product", "torque", "residuals", \
                "days"}
            Period [s] against spin [rpm]; φ̇ψ̇ [rad²/s²] against spin [rpm]; torque
            against φ̇ψ̇ [rad²/s²]; the difference of each time and its prediction [u];
            or, of several days, the torque minus I_zz φ̇ψ̇ in the colour of each.
        ax : matplotlib.axes.Axes, optional
            Axes to draw on; ``ax.legend()`` names the torques. None: a new figure with
            its legend.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        TypeError, ValueError
            If `ax` is not an ``Axes``, or if the name is unknown.
        """
        return plot(self, name, ax)

    def report(self, folder: str | os.PathLike[str]) -> Path:
        """Write the page, the figures and the data of ``gyro analyze`` into a folder.

        Parameters
        ----------
        folder : path
            The folder is created if it does not exist; other files in it are not
            changed.

        Returns
        -------
        Path
            The path of report.html.
        """
        return report(self, folder)

    def _repr_html_(self) -> str:
        return notebook_html(self)

    def _repr_markdown_(self) -> str:
        return markdown(self)


def summary(analysis: results.Analysis) -> str:
    """Return the answer and the findings as text, with remedies for Python."""
    from gyrodata.reporting import text

    words = text.summary(analysis, verbose=False, rest="More: .report(FOLDER)")
    return in_python(words.rstrip("\n"))


def selfcheck(analysis: results.Analysis, labs: int = 1000, seed: int = 1) -> SelfCheck:
    """Simulate a lab many times; see `gyrodata.selfcheck`."""
    from gyrodata.trials import coverage

    return coverage.selfcheck(analysis, labs, seed)


def plot(
    analysis: results.Analysis, name: str = "torque", ax: Axes | None = None
) -> Axes:
    """Draw one of the figures of the report; see `Analysis.plot`."""
    from gyrodata.reporting import figures

    return figures.plot_on(analysis, name, ax)


def report(analysis: results.Analysis, folder: str | os.PathLike[str]) -> Path:
    """Write the report into a folder, and return the path of report.html."""
    from gyrodata.reporting.page import report_files

    target = Path(folder)
    write_folder(target, report_files(analysis))
    return target / "report.html"


def markdown(analysis: results.Analysis) -> str:
    """Return the report as Markdown."""
    from gyrodata.reporting.markdown import markdown_report

    return markdown_report(analysis)


def notebook_html(analysis: results.Analysis) -> str:
    """Return what a notebook shows: the answer, a figure, the findings."""
    from gyrodata.reporting import figures

    answer = escape(summary(analysis))
    parts = [f'<pre style="white-space: pre-wrap">{answer}</pre>']
    words = escape(figures.alternatives(analysis)["torque"])
    # With `faults`, a figure that cannot be drawn is left out without an error.
    drawn = figures.render(analysis, ["svg"], names=("torque",), faults={})["svg"]
    if "torque" in drawn:
        image = b64encode(drawn["torque"]).decode()
        source = f"data:image/svg+xml;base64,{image}"
        parts.append(f'<img src="{source}" alt="{words}" style="max-width: 36em">')
    else:
        parts.append(f"<p>{words}</p>")
    for finding in analysis.diagnostics:
        text = escape(f"{finding.severity} {finding.code}: {finding.message}")
        parts.append(f"<p>{text}</p>")
    return "".join(parts)


def warn(diagnostics: Iterable[Diagnostic]) -> None:
    """Warn once for each code of the warnings of a log."""
    by_code: dict[str, list[Diagnostic]] = {}
    for diagnostic in diagnostics:
        if diagnostic.severity == "warning":
            by_code.setdefault(diagnostic.code, []).append(diagnostic)
    for first, *others in by_code.values():
        text = str(first)
        if others:
            text += f"\n   and {len(others)} more, see the attribute diagnostics"
        warnings.warn(text, GyroWarning, stacklevel=3)


def _with_warnings(
    function: Callable[P, R], as_result: Callable[[R, tuple[Diagnostic, ...]], S]
) -> Callable[P, S]:
    """Let a function warn about the diagnostics of its log, with remedies for Python.

    `as_result` makes the result of the new function from that of the old one and from
    the diagnostics. The diagnostics of an error get remedies for Python too.
    """

    @wraps(function)
    def called(*args: P.args, **kwargs: P.kwargs) -> S:
        try:
            result = function(*args, **kwargs)
        except GyroError as error:
            raise type(error)(_for_python(error.diagnostics)) from None
        diagnostics = _for_python(result.diagnostics)
        warn(diagnostics)
        return as_result(result, diagnostics)

    return called


def _for_python(diagnostics: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    return tuple(PythonDiagnostic(*astuple(diagnostic)) for diagnostic in diagnostics)


def _as_analysis(
    analysis: results.Analysis, diagnostics: tuple[Diagnostic, ...]
) -> Analysis:
    fields = {name: getattr(analysis, name) for name in analysis.__struct_fields__}
    return Analysis(**fields | {"diagnostics": diagnostics})


def _as_readings(
    log: readings.Readings, diagnostics: tuple[Diagnostic, ...]
) -> readings.Readings:
    return replace(log, diagnostics=diagnostics)


analyze = _with_warnings(analysis.analyze, _as_analysis)
read_log = _with_warnings(readings.read_log, _as_readings)


def sample() -> Path:
    """Return the path of a simulated log in the package, with I_zz = 4.44e-3 kg·m².

    The log contains ten runs.

    Returns
    -------
    Path

    Examples
    --------
    >>> import gyrodata
    >>> lab = gyrodata.analyze(gyrodata.sample())
    >>> print(lab.inertia)
    0.004416±0.000033 kg·m²
    """
    return Path(__file__).with_name("docs") / "demo.csv"
