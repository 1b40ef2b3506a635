"""The results of one log: `Analysis`, and the records of its JSON.

`to_json` turns a record into JSON, and `schema` makes the JSON Schema of the same records: a field that is added here
is emitted and declared.
"""

from __future__ import annotations

import json
import os
from base64 import b64encode
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args

import msgspec
import numpy as np
from msgspec import Struct, field
from msgspec.structs import asdict

from gyrodata import __version__
from gyrodata.changes import Lab
from gyrodata.disk import write_folder
from gyrodata.effects import Effect, Sensitivity
from gyrodata.errors import Diagnostic, DiagnosticJson
from gyrodata.fitting import ChosenModel, Estimate, FitResult, Model, Outlier, Share
from gyrodata.measurements import Measurements
from gyrodata.patterns import Pattern
from gyrodata.readings import Readings
from gyrodata.tables import Ball, Constancy, Exponent, NamedFit, PowerLaw, Run, Torque

if TYPE_CHECKING:
    import pandas as pd

DOF_REASON = (
    "u and the interval are quantiles of the posterior distribution, which holds the doubt about the widths too"
)


def _above(room: str) -> Any:
    """Give a module of a room above this one: it is loaded when somebody looks, not when a result is made."""
    return import_module(f"gyrodata.{room}")


CONVENTIONS: dict[str, str] = msgspec.json.decode(Path(__file__).with_name("conventions.json").read_bytes())
"""Which convention each number follows."""


class Options(Struct, frozen=True):
    """The options of the analysis."""

    set: Mapping[str, str] = field(default_factory=dict)
    """Constants given beside the log."""
    map: Mapping[str, str] = field(default_factory=dict)
    """Headers of roles given beside the log."""
    config: str | None = None
    """Name of the TOML file with the same, without its folder."""
    model: Model = "auto"
    keep_flagged: bool = False
    worksheet: bool = False
    """Whether the report asks questions instead of giving conclusions."""


DoubtKind = Literal["ball", "size", "contradiction", "exponent", "scatter", "pattern"]

DOUBTS: tuple[DoubtKind, ...] = get_args(DoubtKind)
"""Kinds of doubt, the most serious first."""


class Doubt(Struct, frozen=True):
    """A reason not to quote the answer, which not even its u contains."""

    kind: DoubtKind
    words: str
    """What is wrong."""
    remedy: str
    """Where to look for the cause."""


class Result(Estimate, frozen=True, kw_only=True):
    """A value with its standard uncertainty u (k = 1) and its 95 % interval; see `CONVENTIONS`."""

    k: float | None
    dof: float | None
    """Degrees of freedom; null, see dof_reason."""
    expanded_u: float | None
    """k·u, half the 95 % interval."""
    relative_u: float | None
    """u over the value [1]."""
    level: float
    """Of the interval [1]."""
    dof_reason: str | None

    @property
    def ufloat(self) -> Any:
        """Value and u as a number of `uncertainties`, that of one quantity alone; see `Analysis.ufloats`."""
        from uncertainties import ufloat

        return ufloat(self.value, self.u or 0.0)

    def to_pint(self, registry: Any) -> Any:
        """Give the quantity of pint.

        Parameters
        ----------
        registry : pint.UnitRegistry
            Your own, so that the quantity can be compared with yours.

        Returns
        -------
        pint.Quantity
            Its magnitude is a number of `uncertainties`.
        """
        return registry.Quantity(self.ufloat, self.unit)

    def __float__(self) -> float:
        return self.value

    def __format__(self, form: str) -> str:
        """Write it as `uncertainties` does, its unit behind it: ``f"{lab.inertia:.2u}"``."""
        return f"{self.ufloat:{form}} {self.unit}" if form else str(self)

    def __str__(self) -> str:
        return f"{self.ufloat:.2uP} {self.unit}".replace("*", "·").replace("^2", "²")


NO_BALL = (
    "Not checked against the ball: add # ball_mass and # ball_diameter; without them gyro cannot detect "
    "a wrong unit in a whole column"
)
"""In place of the comparison with the ball."""


class Analysis(Struct, frozen=True, eq=False):
    """Everything that is said of one log; SI units. Two of them are equal where their JSON is."""

    name: str
    sha256: str
    options: Options
    readings: Readings
    measurements: Measurements
    fit: FitResult
    model: ChosenModel
    """The model that the runs were fitted with."""
    outliers: tuple[Outlier, ...]
    """Runs that look odd, left out or not."""
    inertia: Result
    """I_zz [kg*m^2]."""
    residual_torque: Result
    """M0 [N*m]: the torque is m g x + M0."""
    timing_bias: Result
    """b [s]"""
    if_balanced: Estimate | None
    """I_zz of a log with one torque, if the ball is balanced [kg*m^2]; None where torques differ."""
    doubts: tuple[Doubt, ...]
    """Why the answer is not to be quoted as it stands."""
    p: float | None
    """Probability of a chi-square at least as large; None without degrees of freedom."""
    birge: float | None
    """√(chi-square/dof)."""
    fits: tuple[NamedFit, ...]
    budget: tuple[Share, ...]
    sensitivity: tuple[Sensitivity, ...]
    effects: tuple[Effect, ...]
    power_law: tuple[PowerLaw, ...]
    exponent: Exponent | None
    """None where no torque has runs at different spins."""
    constancy: Constancy | None
    """None where no torque has two runs."""
    ball: Ball | None
    """None where the log does not give the ball's mass and diameter."""
    torques: tuple[Torque, ...]
    run_table: tuple[Run, ...]
    patterns: tuple[Pattern, ...]
    """What was looked for in the residuals, the least likely first."""
    advice: tuple[str, ...]
    diagnostics: tuple[Diagnostic, ...] = field(default=())

    @property
    def lab(self) -> Lab:
        """The log and its fit, from which `changes` start."""
        left_out = tuple(i for i, run in enumerate(self.run_table) if run.left_out)
        return Lab(self.readings, self.measurements, self.fit, self.model, left_out)

    @property
    def runs_disagree(self) -> bool:
        """Whether the runs contradict each other, or the line; a wrong column or ball is another doubt."""
        return any(doubt.kind not in ("ball", "size") for doubt in self.doubts)

    @property
    def angular_momentum(self) -> Estimate:
        """I_zz ψ̇ along the rod at the fastest spin [kg*m^2/s], with the standard uncertainty of I_zz."""
        spin = max(run.spin for run in self.run_table)
        return Estimate(self.inertia.value * spin, (self.inertia.u or 0.0) * spin, "kg*m^2/s")

    @property
    def centre_of_mass(self) -> Estimate | None:
        """Its distance M0/(m g) from the centre of the ball [m]; None if the log does not give the ball's mass."""
        m0, weight = self.residual_torque, self.readings.constants.get("ball_mass", 0.0) * self.measurements.g
        return Estimate(m0.value / weight, (m0.u or 0.0) / weight, "m") if weight else None

    @property
    def runs(self) -> pd.DataFrame:
        """One row for each run, SI units, as a DataFrame."""
        import pandas as pd

        return pd.DataFrame([asdict(run) for run in self.run_table])

    def ufloats(self) -> dict[str, Any]:
        """Give I_zz [kg*m^2], M0 [N*m] and b [s] as numbers of `uncertainties` that know how they are correlated.

        Returns
        -------
        dict of str to uncertainties.UFloat
            By their names in the JSON: "inertia", "residual_torque", "timing_bias".
        """
        from uncertainties import correlated_values

        told = {"inertia": self.inertia, "residual_torque": self.residual_torque, "timing_bias": self.timing_bias}
        # The fit gives their correlation, with the reported u.
        u = np.array([one.u or 0.0 for one in told.values()])
        own = np.sqrt(np.diag(self.fit.covariance))
        share = np.divide(u, own, out=np.zeros_like(u), where=own > 0)
        together = self.fit.covariance * share[:, None] * share
        return dict(zip(told, correlated_values([one.value for one in told.values()], together), strict=True))

    def __eq__(self, other: object) -> bool:
        return self.to_dict() == other.to_dict() if isinstance(other, Analysis) else NotImplemented

    def __hash__(self) -> int:
        return hash((self.name, self.sha256, self.inertia.value))

    def __repr__(self) -> str:
        told = f"{len(self.run_table)} runs, {len(self.diagnostics)} things to look at"
        return f"<Analysis of {self.name[:200]}: I_zz = {self.inertia}; {told}>"

    def __str__(self) -> str:
        return str(_above("reporting.text").summary(self, verbose=False, rest="More: .report(FOLDER)"))

    def plot(self, name: str = "torque", ax: Any = None) -> Any:
        """Draw one of the figures of the report.

        Parameters
        ----------
        name : {"period", "product", "torque", "residuals"}
            Period [s] against spin [rpm]; φ̇ψ̇ [rad²/s²] against spin [rpm]; torque against φ̇ψ̇ [rad²/s²]; what each time
            is off by, in its standard uncertainty.
        ax : matplotlib.axes.Axes, optional
            What to draw on; ``ax.legend()`` names the torques. If none are given: a new figure with its legend.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        TypeError, ValueError
            If `ax` is no axes, or there is no such figure.
        """
        return _above("plotting").plot_on(self, name, ax)

    def report(self, folder: str | os.PathLike[str]) -> Path:
        """Write the page, the figures and the data of ``gyro analyze`` into a folder.

        Parameters
        ----------
        folder : path
            It is made if it is not there; other files in it stay.

        Returns
        -------
        Path
            Of the page, report.html.
        """
        target = Path(folder)
        write_folder(target, _above("reporting.files").report_files(self))
        return target / "report.html"

    def _repr_html_(self) -> str:
        from html import escape

        figure = b64encode(_above("plotting").render(self, "png", names=("torque",))["torque"]).decode()
        told = escape(str(self))
        found = "".join(f"<li>{escape(f'{one.severity} {one.code}: {one.message}')}</li>" for one in self.diagnostics)
        words = escape(_above("plotting").alt_text(self, "torque"))
        picture = f'<img src="data:image/png;base64,{figure}" alt="{words}" style="max-width: 36em">'
        return f'<pre style="white-space: pre-wrap">{told}</pre>{picture}' + (f"<ul>{found}</ul>" if found else "")

    def _repr_markdown_(self) -> str:
        return str(_above("reporting.markdown").markdown_report(self))

    def to_dict(self) -> dict[str, Any]:
        """Give the analysis as the JSON contract has it (schema "gyro.analysis/2")."""
        fit, measured = self.fit, self.measurements
        no_p = "no degrees of freedom: as many unknowns as runs" if self.p is None else None
        told: dict[str, Any] = {
            "goodness": Goodness(fit.chi2, fit.dof, self.p, self.birge, fit.scatter, measured.time_u, no_p),
            "constants": {"g": measured.g, **self.readings.constants},
            "model": self.model.name,
            "ball_reason": NO_BALL if self.ball is None else None,
            "runs": self.run_table,
            "uncertainties": tuple(
                StatedUncertainty(one.name, one.shared_by, one.default, one.described) for one in measured.sources
            ),
            "conventions": CONVENTIONS,
        }
        told |= {name: getattr(self, name) for name in AnalysisResult.__struct_fields__ if name not in told}
        whole = AnalysisDocument(
            input=Input(self.name, self.sha256, len(self.run_table)),
            options=self.options,
            result=AnalysisResult(**told),
            diagnostics=tuple(one.to_dict() for one in self.diagnostics),
        )
        return to_json(whole)


# --- the JSON ------------------------------------------------------------------------------------------------


class Tool(Struct, frozen=True):
    """The tool and its version."""

    name: Literal["gyrodata"] = "gyrodata"
    version: str = __version__


class Input(Struct, eq=False):
    """The log."""

    name: str
    """Its path as it was given; of an absolute one what the logs of one call do not share."""
    sha256: str | None
    """Of its bytes; null where it could not be read."""
    rows: int | None
    """Number of runs read."""


class Goodness(Struct, eq=False):
    """How well the runs go together."""

    chi2: float
    dof: int
    p: float | None
    """Probability of a chi-square at least as large."""
    birge: float | None
    """√(chi2/dof)."""
    scatter: float
    """Factor on the errors that each run has alone, as the runs have it; u holds it."""
    time_u: float | None
    """Standard uncertainty of every time [s], before that factor; null where it is not the same for all runs."""
    reason: str | None
    """Why p is null."""


class StatedUncertainty(Struct, eq=False):
    """One uncertainty of the readings."""

    source: str
    shared_by: str
    """Runs that have this error in common; "" where every run has its own."""
    default: bool
    """True where the log does not state it."""
    text: str
    """What it is, in words: "0.2 %"."""


class AnalysisResult(Struct, eq=False):
    """All quantities are SI."""

    inertia: Result
    """I_zz."""
    residual_torque: Result
    """M0: the torque at work is the applied torque plus M0."""
    timing_bias: Result
    """b: a stopwatch's reading is the true time plus b."""
    if_balanced: Estimate | None
    """I_zz of a log with one torque, if the ball is balanced [kg*m^2]; null where torques differ."""
    doubts: tuple[Doubt, ...]
    """Why the answer is not to be quoted as it stands, the weightiest reason first; empty where nothing is wrong."""
    goodness: Goodness
    fits: tuple[NamedFit, ...]
    budget: tuple[Share, ...]
    """What each source of uncertainty contributes to u of I_zz."""
    sensitivity: tuple[Sensitivity, ...]
    """What I_zz would be if one thing were otherwise."""
    constants: Mapping[str, float]
    """By name: g, and the ball's mass and diameter where the log gives them."""
    model: Literal["horizontal", "steady", "released"]
    effects: tuple[Effect, ...]
    """The size of every simplification in this log."""
    power_law: tuple[PowerLaw, ...]
    exponent: Exponent | None
    constancy: Constancy | None
    ball: Ball | None
    ball_reason: str | None
    """Why there is no comparison; null if there is one."""
    angular_momentum: Estimate
    """I_zz ψ̇ along the rod at the fastest spin [kg*m^2/s], with the standard uncertainty of I_zz."""
    centre_of_mass: Estimate | None
    """Its distance M0/(m g) from the centre of the ball, along the rod towards the weight [m]; null without m."""
    torques: tuple[Torque, ...]
    runs: tuple[Run, ...]
    patterns: tuple[Pattern, ...]
    """What was looked for in the residuals, the least likely first; empty for fewer than two degrees of freedom."""
    uncertainties: tuple[StatedUncertainty, ...]
    advice: tuple[str, ...]
    """What would make the next lab better."""
    conventions: Mapping[str, str]
    """Which convention each number follows, by its key."""


class AnalysisDocument(Struct, eq=False, kw_only=True):
    """What ``gyro analyze --format json`` says of one log."""

    schema: Literal["gyro.analysis/2"] = "gyro.analysis/2"
    tool: Tool = Tool()
    input: Input
    options: Options
    result: AnalysisResult | None
    """null when the log cannot be analysed; the diagnostics say why."""
    diagnostics: tuple[DiagnosticJson, ...]


class HandIn(Struct, eq=False):
    """What ``gyro check --hand-in`` reads as a grader will."""

    text: str | None
    """I_zz as written; null where none is found."""
    inertia: float | None
    """[kg*m^2]; null where it cannot be read, or two differ."""
    u: float | None
    """Standard uncertainty [kg*m^2]; null where none is found."""
    file: str | None
    """Where it stands, …"""
    line: int | None
    """… and in which line."""
    station: str | None
    """The station that the log names."""


class CheckDocument(Struct, eq=False, kw_only=True):
    """What ``gyro check --format json`` says of one log."""

    schema: Literal["gyro.check/1"] = "gyro.check/1"
    tool: Tool = Tool()
    input: Input
    clean: bool
    """True if there is no doubt, and no diagnostic above a note."""
    doubts: tuple[Doubt, ...]
    """Why the answer of ``gyro analyze`` is not to be relied on."""
    diagnostics: tuple[DiagnosticJson, ...]
    hand_in: HandIn | None
    """null without --hand-in."""


def encode(record: Any) -> bytes:
    """Write a record as JSON on one line; a NaN becomes null."""
    try:
        return msgspec.json.encode(record)
    except UnicodeEncodeError:
        # Half of a surrogate, as of a file's name in another coding, has to be escaped.
        return json.dumps(msgspec.to_builtins(record), allow_nan=False).encode()


def to_json(record: Struct) -> dict[str, Any]:
    """Turn a record into the object that its JSON is, with lists for tuples."""
    made: dict[str, Any] = json.loads(encode(record))
    return made
