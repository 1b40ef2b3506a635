"""The report as one HTML page that needs nothing else."""

from __future__ import annotations

import base64
import math
from collections.abc import Mapping
from typing import Any, Literal

from gyrodata import __version__, physics
from gyrodata.analysis import CONVENTIONS, Analysis
from gyrodata.comparisons import Run, turn_words
from gyrodata.reporting.values import (
    count_text,
    inertia_text,
    interval_text,
    number_text,
    percent_text,
    power_of_ten,
    torque_text,
)
from gyrodata.reporting.words import (
    EFFECT_NAMES,
    FIT_NAMES,
    SOURCE_NAMES,
    default_lines,
    difference_text,
    effect_verdict,
    goodness_text,
)


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
    template = environment.from_string(files("gyrodata.reporting").joinpath("report.html.jinja").read_text("utf-8"))
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
        "defaults": default_lines(analysis)[1:],
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
