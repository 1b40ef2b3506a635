"""An `Analysis` in words: the text summary, JSON, CSV, and the page.

Nothing is computed here that is not already in the result; values are rounded to their uncertainty (two digits)
by the `uncertainties` package.
"""

from __future__ import annotations

import base64
import csv
import io
import json
import math
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from gyrodata import __version__, physics
from gyrodata.analysis import CONVENTIONS, Analysis, envelope
from gyrodata.comparisons import NamedFit, Run, turn_words
from gyrodata.effects import DROP_ONE, Effect
from gyrodata.errors import Diagnostic
from gyrodata.fitting import Estimate

FIT_NAMES = {
    "recommended": "recommended",
    "through_origin": "through the origin",
    "with_constant": "with a constant",
}

MODEL_NAMES = {
    "horizontal": "eq. (9), a level rod",
    "steady": "eq. (8), a tilted rod",
    "released": "the mean rate of a rod let go from rest",
}

SOURCE_NAMES = {
    "time": "stopwatch",
    "time_bias": "hand's bias",
    "spin": "tachometer readings",
    "spin_scale": "tachometer scale",
    "mass": "each weight's mass",
    "mass_scale": "scale",
    "position": "position readings",
    "position_zero": "ruler's zero",
    "force": "force",
    "torque": "torque",
    "g": "g",
    "imbalance": "residual torque (prior)",
    "imbalance_sign": "unknown sense of the unloaded run",
    "balance_doubt": "doubt about the balance test",
    "precession_rate": "precession rate",
    "angle": "swept angle",
    "pitch": "pitch",
    "transverse_inertia": "transverse inertia",
    "nutation": "nutation at the last click",
    "release": "transverse inertia, in the nutation",
}

EFFECT_NAMES = {
    "imbalance": "imperfect balance",
    "timing_bias": "late or early hand",
    "spin_decay": "falling spin, plain mean of start and end",
    "decay_law": "law by which the spin falls",
    "tilt": "tilted rod, eq. (9) for eq. (8)",
    "release": "nutation after letting go",
    "earth": "the Earth's rotation",
}


# --- numbers ------------------------------------------------------------------------------------------------


def number_text(value: float, u: float | None, factor: float = 1.0) -> str:
    """Write a value rounded to its uncertainty: "4.44 ± 0.06".

    Parameters
    ----------
    value : float
        In its SI unit.
    u : float or None
        Standard uncertainty, same unit; None or 0 gives the value alone with four digits.
    factor : float
        Divide both by this first: 1e-3 for milli.

    Returns
    -------
    str
        u with two significant digits, the value to the same place (GUM 7.2.6).
    """
    if u is None or u == 0 or not math.isfinite(u):
        return f"{value / factor:.4g}"
    from uncertainties import ufloat

    return f"{ufloat(value / factor, u / factor):.2uP}".replace("±", " ± ").replace("×", " × ")


def power_of_ten(value: float) -> tuple[float, str]:
    """Find the power of ten that leaves one digit before the point, and write it.

    Parameters
    ----------
    value : float
        Any.

    Returns
    -------
    tuple of float and str
        (1e-3, "10⁻³"); (1.0, "") for values from 1 to 10 and for 0.
    """
    exponent = math.floor(math.log10(abs(value))) if value else 0
    if exponent == 0:
        return 1.0, ""
    digits = str(exponent).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return 10.0**exponent, f"10{digits}"


def inertia_text(value: float, u: float | None) -> str:
    """Write a moment of inertia: "(4.44 ± 0.06) × 10⁻³ kg·m²".

    Parameters
    ----------
    value, u : float
        [kg*m^2]

    Returns
    -------
    str
    """
    factor, power = power_of_ten(max(value, u or 0.0, key=abs))
    number = number_text(value, u, factor)
    if not power:
        return f"{number} kg·m²"
    return f"({number}) × {power} kg·m²" if "±" in number else f"{number} × {power} kg·m²"


def interval_text(low: float, high: float, factor: float = 1.0) -> str:
    """Write an interval with as many digits as its half-width needs: "4.32 to 4.56".

    Parameters
    ----------
    low, high : float
        Ends, in the SI unit.
    factor : float
        Divide both by this first.

    Returns
    -------
    str
    """
    low, high = low / factor, high / factor
    width = (high - low) / 2
    places = max(0, 1 - math.floor(math.log10(width))) if width > 0 else 4
    return f"{low:.{places}f} to {high:.{places}f}"


def torque_text(value: float, u: float | None = None) -> str:
    """Write a torque in mN·m.

    Parameters
    ----------
    value, u : float
        [N*m]

    Returns
    -------
    str
    """
    return f"{number_text(value, u, 1e-3)} mN·m"


def percent_text(value: float) -> str:
    """Write a relative size in per cent, signed, two digits: "+0.03 %".

    Parameters
    ----------
    value : float
        [1]

    Returns
    -------
    str
    """
    percent = 100 * value
    if percent == 0:
        return "0 %"
    if abs(percent) < 0.001:
        return "< 0.001 %"
    return f"{percent:+.2g} %" if abs(percent) < 100 else f"{percent:+.0f} %"


def p_text(p: float) -> str:
    """Write a probability: "p = 0.32", "p < 0.0001".

    Parameters
    ----------
    p : float
        From 0 to 1.

    Returns
    -------
    str
    """
    return "p < 0.0001" if p < 1e-4 else f"p = {p:.2g}"


def count_text(count: int, noun: str) -> str:
    """Write a count with its noun: "1 run", "9 runs".

    Parameters
    ----------
    count : int
        How many.
    noun : str
        Singular.

    Returns
    -------
    str
    """
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


# --- text ---------------------------------------------------------------------------------------------------


def summary(analysis: Analysis) -> str:
    """Write what a person reads first.

    Parameters
    ----------
    analysis : Analysis
        The result.

    Returns
    -------
    str
        Several lines, ending with a line end.
    """
    sections = [
        _headline(analysis),
        _answer(analysis),
        _fits_table(analysis),
        _budget_lines(analysis),
        _odd_lines(analysis),
        _effect_lines(analysis),
        _default_lines(analysis),
        [f"next time: {advice}" for advice in analysis.advice],
    ]
    return "\n\n".join("\n".join(lines) for lines in sections if lines) + "\n"


def _headline(analysis: Analysis) -> list[str]:
    count = len(analysis.run_table)
    return [f"{analysis.name}: {count_text(count, 'run')}, {count_text(len(analysis.torques), 'torque')}"]


def _answer(analysis: Analysis) -> list[str]:
    inertia, imbalance, bias = analysis.inertia, analysis.imbalance, analysis.timing_bias
    lines = [f"  I_zz = {inertia_text(inertia.value, inertia.u)}"]
    if inertia.interval_95 is not None and inertia.k is not None:
        factor, power = power_of_ten(max(inertia.value, inertia.u or 0.0, key=abs))
        ends = interval_text(*inertia.interval_95, factor)
        how = f"u × k, k = {inertia.k:.2f}" if inertia.interval_by == "linear" else "by the profile of chi-square"
        lines.append(f"         95 % interval {ends}{' × ' + power if power else ''} kg·m² ({how})")
    lines.append(f"  residual torque M0 = {torque_text(imbalance.value, imbalance.u)} (torque at work = applied + M0)")
    if bias.u:
        lines.append(f"  timing bias b = {number_text(bias.value, bias.u)} s")
    lines.append(f"  {goodness_text(analysis)}")
    return lines


def goodness_text(analysis: Analysis) -> str:
    """Write how well the runs go together.

    Parameters
    ----------
    analysis : Analysis
        The result.

    Returns
    -------
    str
        One sentence without a full stop.
    """
    fit = analysis.fit
    if analysis.p is None or analysis.birge is None:
        return "goodness: as many unknowns as runs, so nothing tells how well they fit"
    applied = "u multiplied by it, as asked" if analysis.birge_applied else "not applied"
    return (
        f"goodness: chi-square {fit.chi2:.3g} for {count_text(fit.dof, 'degree')} of freedom, {p_text(analysis.p)} "
        f"(Birge ratio {analysis.birge:.2f}, {applied})"
    )


def difference_text(analysis: Analysis, fit: NamedFit) -> str:
    """Say how far a fit lies from the recommended one, in its u and in per cent.

    Parameters
    ----------
    analysis : Analysis
        The result.
    fit : NamedFit
        One of its fits.

    Returns
    -------
    str
        "" for the recommended fit and for one that is not possible.
    """
    if fit.inertia is None or fit.name == "recommended" or not analysis.inertia.u:
        return ""
    difference = fit.inertia.value - analysis.inertia.value
    return f"{difference / analysis.inertia.u:+.1f} u ({percent_text(difference / analysis.inertia.value)})"


def _fits_table(analysis: Analysis) -> list[str]:
    factor, power = power_of_ten(max(analysis.inertia.value, analysis.inertia.u or 0.0, key=abs))
    rows = [("fit", f"I_zz [{power + ' ' if power else ''}kg·m²]", "M0 [mN·m]", "from recommended")]
    impossible = []
    for fit in analysis.fits:
        if fit.inertia is None:
            impossible.append(f"  {FIT_NAMES[fit.name]}: {fit.note}")
            continue
        constant = Estimate(-fit.constant.value, fit.constant.u) if fit.constant else None
        rows.append(
            (
                FIT_NAMES[fit.name],
                number_text(fit.inertia.value, fit.inertia.u, factor),
                number_text(constant.value, constant.u, 1e-3) if constant else "-",
                difference_text(analysis, fit),
            )
        )
    return [*columns(rows), *impossible]


def columns(rows: Sequence[Sequence[str]]) -> list[str]:
    """Set rows of cells in columns, two blanks in front and between.

    Parameters
    ----------
    rows : sequence of sequence of str
        All of one length.

    Returns
    -------
    list of str
        One line for each row.
    """
    widths = [max(len(cell) for cell in column) for column in zip(*rows, strict=True)]
    return [
        ("  " + "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True))).rstrip() for row in rows
    ]


def _budget_lines(analysis: Analysis) -> list[str]:
    """The sources that make up at least 1 % of the variance."""
    rows = [
        (
            SOURCE_NAMES.get(share.source, share.source),
            f"{100 * share.share:.0f} %",
            f"shared by {share.shared_by}" if share.shared else "each run its own",
        )
        for share in analysis.budget
        if share.share >= 0.01
    ]
    return ["where u² of I_zz comes from:", *columns(rows)] if rows else []


def _odd_lines(analysis: Analysis) -> list[str]:
    lines = [
        f"  run {run.run} (line {run.line}): {run.reason}{'; left out' if run.left_out else '; kept'}"
        for run in analysis.run_table
        if run.flagged
    ]
    return ["looks odd:", *lines] if lines else ["no run looks odd; none is left out"]


def effect_verdict(effect: Effect) -> str:
    """Say whether an effect is in the model: "in the model", "left out", or "left out, and not small".

    Parameters
    ----------
    effect : Effect
        One of an analysis' effects.

    Returns
    -------
    str
    """
    if effect.kept:
        return "in the model"
    return "left out, and not small" if (effect.size or 0.0) > DROP_ONE else "left out"


def _effect_lines(analysis: Analysis) -> list[str]:
    rows = [
        (
            EFFECT_NAMES.get(effect.effect, effect.effect),
            percent_text(effect.bias),
            "-" if effect.size is None else f"{effect.size:.1g} u" if effect.size < 10 else f"{effect.size:.0f} u",
            effect_verdict(effect),
        )
        for effect in analysis.effects
        if effect.bias is not None
    ]
    return [f"what leaving it out does to I_zz (model: {MODEL_NAMES[analysis.model.name]}):", *columns(rows)]


def _default_lines(analysis: Analysis) -> list[str]:
    used = [f"u_{s.name} {s.described}" for s in analysis.measurements.sources if s.default and s.described != "0"]
    if analysis.measurements.timed and "u_time_bias" not in analysis.readings.uncertainties:
        used.append("u_time_bias 0.05 s")
    if not used:
        return []
    return ["uncertainties not in the log, taken by default:", *(f"  {item}" for item in used)]


# --- JSON and CSV -------------------------------------------------------------------------------------------


def json_text(document: dict[str, Any], indent: int | None = 2) -> str:
    """Write a result as JSON, one line for ``indent=None``.

    Parameters
    ----------
    document : dict
        As `Analysis.to_dict` gives it.
    indent : int or None
        Blanks for each level.

    Returns
    -------
    str
        Ends with a line end. Not-a-number does not pass: it is a fault of the tool.
    """
    return json.dumps(document, indent=indent, allow_nan=False) + "\n"


def check_document(
    name: str, sha256: str | None, rows: int | None, clean: bool, diagnostics: Sequence[Diagnostic]
) -> dict[str, Any]:
    """Put what `gyro check` found into its JSON object (schema "gyro.check/1").

    Parameters
    ----------
    name : str
        Name of the log, without its folder.
    sha256 : str or None
        Of its bytes; None where it could not be read.
    rows : int or None
        Number of runs read.
    clean : bool
        True if nothing above a note was found.
    diagnostics : sequence of Diagnostic
        What was found.

    Returns
    -------
    dict
    """
    document = envelope(name, sha256, rows, {}, None, tuple(diagnostics))
    return {
        "schema": "gyro.check/1",
        "tool": document["tool"],
        "input": document["input"],
        "clean": clean,
        "diagnostics": document["diagnostics"],
    }


def check_text(name: str, runs: int | None, diagnostics: Sequence[Diagnostic]) -> str:
    """Write what `gyro check` found, and a last line that sums it up.

    Parameters
    ----------
    name : str
        Name of the log.
    runs : int or None
        Number of runs read; None where it could not be read.
    diagnostics : sequence of Diagnostic
        What was found.

    Returns
    -------
    str
    """
    counts = {severity: sum(d.severity == severity for d in diagnostics) for severity in ("error", "warning", "note")}
    told = ", ".join(count_text(count, severity) for severity, count in counts.items() if count)
    read = "" if runs is None else f"{count_text(runs, 'run')}, "
    clean = not counts["error"] and not counts["warning"]
    verdict = f"complete{f' ({told})' if told else ''}" if clean else told
    return "".join(f"{diagnostic}\n" for diagnostic in diagnostics) + f"{name}: {read}{verdict}\n"


def github_annotations(path: str, diagnostics: Sequence[Diagnostic]) -> str:
    """Write diagnostics as workflow commands, one a line.

    Parameters
    ----------
    path : str
        Path of the log as it was typed.
    diagnostics : sequence of Diagnostic
        What was found.

    Returns
    -------
    str
        ``::error file=…,line=…,col=…,title=…::message``; percent signs, line ends, and in properties commas and
        colons, are escaped as the format asks.
    """

    def escaped(text: str, more: str = "") -> str:
        for character in "%\r\n" + more:
            text = text.replace(character, f"%{ord(character):02X}")
        return text

    lines = []
    for d in diagnostics:
        kind = "notice" if d.severity == "note" else d.severity
        place = "".join(f",{key}={value}" for key, value in (("line", d.line), ("col", d.column)) if value is not None)
        message = escaped(f"{d.message}\n{d.hint}".strip())
        lines.append(f"::{kind} file={escaped(path, ',:')}{place},title={escaped(d.code, ',:')}::{message}\n")
    return "".join(lines)


def diagnostics_text(table: Sequence[Mapping[str, str]]) -> str:
    """Write the table of diagnostic codes, each with an example that raises it.

    Parameters
    ----------
    table : sequence of mapping
        Keys "code", "severity", "title", "example".

    Returns
    -------
    str
    """
    blocks = []
    for row in table:
        example = "\n".join(f"      {line}" for line in row["example"].rstrip("\n").splitlines())
        blocks.append(f"{row['code']}  {row['severity']:7}  {row['title']}\n{example}\n")
    return "\n".join(blocks)


RUN_UNITS = {
    "mass": "kg",
    "position": "m",
    "torque": "N*m",
    "spin": "rad/s",
    "time": "s",
    "precession_rate": "rad/s",
    "period": "s",
    "product": "rad^2/s^2",
    "inertia": "kg*m^2",
    "residual": "s",
    "residual_u": "s",
    "influence": "kg*m^2",
}


def runs_csv(analysis: Analysis) -> str:
    """Write one row for each run, SI units in the header.

    Parameters
    ----------
    analysis : Analysis
        The result.

    Returns
    -------
    str
    """
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    names = list(analysis.to_dict()["result"]["runs"][0])
    writer.writerow([f"{name} [{RUN_UNITS[name]}]" if name in RUN_UNITS else name for name in names])
    for run in analysis.run_table:
        writer.writerow([csv_cell(getattr(run, name)) for name in names])
    return out.getvalue()


def csv_cell(value: object) -> str:
    """Write one cell of a table that a spreadsheet may open: nothing for None, all digits of a number, a safe text."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return repr(value)
    text = str(value).replace("\r", " ")  # which the csv module leaves unquoted, and readers take for a row's end
    # A spreadsheet runs a cell that begins like this as a formula, in wide letters too.
    return f"'{text}" if text[:1] in tuple("=+-@\t\n＝＋－＠") else text


# --- the page -----------------------------------------------------------------------------------------------


def report_page(
    analysis: Analysis, figures: Mapping[str, bytes], form: Literal["png", "svg"], alt: Mapping[str, str]
) -> str:
    """Write the report as one HTML page that needs nothing else.

    Parameters
    ----------
    analysis : Analysis
        The result.
    figures : mapping of str to bytes
        File of each figure: "period", "product", "torque", "residuals".
    form : {"png", "svg"}
        What these files are.
    alt : mapping of str to str
        What each figure shows, in words.

    Returns
    -------
    str
        Without a clock time or a folder's name; whatever comes from the log is escaped.
    """
    from importlib.resources import files

    from jinja2 import Environment, StrictUndefined

    environment = Environment(autoescape=True, undefined=StrictUndefined, lstrip_blocks=True)
    template = environment.from_string(files("gyrodata").joinpath("report.html.jinja").read_text("utf-8"))
    return template.render(_page_content(analysis), images=_data_uris(figures, form), alt=alt)


def _data_uris(figures: Mapping[str, bytes], form: Literal["png", "svg"]) -> dict[str, str]:
    kind = {"png": "image/png", "svg": "image/svg+xml"}[form]
    return {name: f"data:{kind};base64,{base64.b64encode(data).decode()}" for name, data in figures.items()}


def _page_content(analysis: Analysis) -> dict[str, Any]:
    """What the template needs besides figures: the analysis, and the functions that write its numbers."""
    factor, ten = power_of_ten(max(analysis.inertia.value, analysis.inertia.u or 0.0, key=abs))
    kept = bool(analysis.options.get("keep_flagged"))
    exponents = [(law.exponent, law.u) for law in analysis.power_law if law.exponent is not None and law.u is not None]
    return {
        "a": analysis,
        "version": __version__,
        "factor": factor,
        "ten": ten,
        "goodness": goodness_text(analysis),
        "flagged": [run for run in analysis.run_table if run.flagged],
        "notes": analysis.readings.notes,
        "exponents": exponents,
        "agreeing": sum(abs(exponent - 1) <= 2 * u for exponent, u in exponents),
        "origin": next((f for f in analysis.fits if f.name == "through_origin" and f.inertia is not None), None),
        "ball": _ball(analysis),
        "conventions": list(CONVENTIONS.items()),
        "defaults": _default_lines(analysis)[1:],
        "options": [(key, _option_text(value)) for key, value in analysis.options.items()],
        "cells": _run_cells,
        "fate": lambda run: "left out" if run.left_out else "kept, as asked" if kept else "kept",
        "shown": _shown,
        "difference": lambda value: _minus(f"{value:+.1f}"),
        "fit_names": FIT_NAMES,
        "effect_names": EFFECT_NAMES,
        "source_names": SOURCE_NAMES,
        **{
            # Typeset: a real minus in front of a number.
            function.__name__: lambda *values, function=function: _minus(function(*values))
            for function in (
                count_text, difference_text, effect_verdict, inertia_text, interval_text, number_text, percent_text,
                torque_text,
            )
        },
    }  # fmt: skip


def _ball(analysis: Analysis) -> dict[str, float] | None:
    """The solid ball to compare with, where the log gives its mass and diameter."""
    constants = analysis.readings.constants
    if "ball_mass" not in constants or "ball_diameter" not in constants:
        return None
    mass, diameter = constants["ball_mass"], constants["ball_diameter"]
    return {"mass": mass, "diameter": diameter, "inertia": physics.solid_ball_inertia(mass, diameter)}


def _minus(text: str) -> str:
    return text.replace("-", "−")


def _shown(value: float | None, factor: float) -> str:
    """A reading, four digits and all those before the point."""
    if value is None:
        return "–"
    value /= factor
    return _minus(f"{value:.0f}" if 1e4 <= abs(value) < 1e9 else f"{value:.4g}")


def _run_cells(run: Run) -> list[tuple[str, str]]:
    """Value to sort by and text of each number of a run, in the order of the page's table."""
    plain = ((run.torque, 1e-3), (run.spin, math.pi / 30), (run.time, 1.0))
    after = ((run.period, 1.0), (run.product, 1.0))
    return [
        (str(run.line), str(run.line)),
        *((repr(value), _shown(value, factor)) for value, factor in plain),
        (repr(run.turns), turn_words(run.turns).split(" ")[0]),
        *((repr(value), _shown(value, factor)) for value, factor in after),
        (repr(run.residual), _minus(number_text(run.residual, run.residual_u))),
    ]


def _option_text(value: object) -> str:
    if isinstance(value, Mapping):
        return ", ".join(f"{key} = {item}" for key, item in value.items()) or "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return str(value)
