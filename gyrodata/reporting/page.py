"""The report as one HTML page that needs nothing else."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from typing import Any, Literal, NamedTuple

from markupsafe import Markup

from gyrodata.measurements import torque_groups
from gyrodata.reporting.cited import Cited, typeset
from gyrodata.reporting.phrases import (
    EFFECT_NAMES,
    FIT_NAMES,
    MODEL_NAMES,
    SOURCE_NAMES,
    common_torque_scale,
    defaults_used,
    effect_verdict,
    option_text,
)
from gyrodata.reporting.values import (
    CENTIMETRE,
    NUMBER,
    PRODUCT,
    RPM,
    SECOND,
    Scale,
    inertia_scale,
    inertia_text,
    mass_scale,
)
from gyrodata.results import Analysis

AGREES = 2.0
"""Two numbers agree that lie no further apart than this many standard uncertainties of their difference."""

UNLIKELY = 0.05
"""A scatter with a smaller chance than this is more than the stated uncertainties explain."""

LONG = 25
"""A table with more rows than this may go over the edge of a printed page."""

_CONSTANT_UNITS = {"g": "m/s²", "ball_mass": "kg", "ball_diameter": "m"}

# The figures' markers in a square of 12 by 12.
_SHAPES = {
    "o": "M6 1.4a4.6 4.6 0 1 0 .01 0z",
    "s": "M1.8 1.8h8.4v8.4H1.8z",
    "^": "M6 1 11.2 10.6H.8z",
    "v": "M6 11 11.2 1.4H.8z",
    "<": "M1 6 10.6.8v10.4z",
    "D": "M6 .4 11.6 6 6 11.6.4 6z",
    "P": "M4.2 1h3.6v3.2H11v3.6H7.8V11H4.2V7.8H1V4.2h3.2z",
    "X": "M3.5 1 6 3.5 8.5 1 11 3.5 8.5 6 11 8.5 8.5 11 6 8.5 3.5 11 1 8.5 3.5 6 1 3.5z",
}


def report_page(
    analysis: Analysis,
    figures: Mapping[str, bytes],
    form: Literal["png", "svg"],
    alt: Mapping[str, str],
    looks: Sequence[tuple[str, str, str]],
) -> str:
    """Write the report as one HTML page that needs nothing else.

    `figures` are the files of "period", "product", "torque" and "residuals", `alt` what each shows in words, `looks`
    label, colour and marker of each torque in them. The page has no clock time and no folder's name; whatever comes
    from the log is escaped, and every number says where in results.json it stands.
    """
    from jinja2 import Environment, StrictUndefined

    # The template is used once: making it faster takes longer than using it.
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, lstrip_blocks=True, trim_blocks=True, optimized=False
    )
    environment.filters["typeset"] = typeset
    template = environment.from_string(_read("report.html.jinja"))
    return template.render(
        _page_content(analysis, looks),
        images=_data_uris(figures, form),
        alt=alt,
        style=Markup(_read("report.css")),
        script=Markup(_read("report.js")),
    )


def _read(name: str) -> str:
    from importlib.resources import files

    return files("gyrodata.reporting").joinpath(name).read_text("utf-8")


def _data_uris(figures: Mapping[str, bytes], form: Literal["png", "svg"]) -> dict[str, str]:
    kind = {"png": "image/png", "svg": "image/svg+xml"}[form]
    return {name: f"data:{kind};base64,{base64.b64encode(data).decode()}" for name, data in figures.items()}


def _page_content(analysis: Analysis, looks: Sequence[tuple[str, str, str]]) -> dict[str, Any]:
    """What the template needs besides figures: the analysis, and what writes its numbers."""
    cited = Cited(analysis.to_dict())
    torque = common_torque_scale(analysis)
    labels = [_label(cited, i, torque) for i in range(len(looks))]
    names = [_swatch(colour, marker) + label for (_, colour, marker), label in zip(looks, labels, strict=True)]
    flagged = [i for i, run in enumerate(analysis.run_table) if run.flagged]
    kept = analysis.options.keep_flagged
    return {
        "title": f"I_zz = {inertia_text(analysis.inertia.value, analysis.inertia.u)} – {analysis.name}",
        "a": analysis,
        "c": cited,
        "r": cited.document["result"],
        "document": cited.document,
        "names": names,
        "group_of": {i: g for g, group in enumerate(torque_groups(analysis.measurements)) for i in group},
        "flagged": flagged,
        "fate": lambda run: "left out" if run.left_out else "kept, as asked" if kept else "kept",
        "notes": analysis.readings.notes,
        "inertia": inertia_scale(analysis.inertia.value, analysis.inertia.u),
        "torque": torque,
        "product": PRODUCT,
        "second": SECOND,
        "plain": NUMBER,
        "rpm": RPM.size,
        # τ/ψ̇ in seconds for each 100 rpm.
        "per_100_rpm": 1 / (100 * RPM.size),
        "kilogram": Scale("kg", ""),
        "centimetre": CENTIMETRE,
        "agrees": lambda deviation: deviation is not None and abs(deviation) <= AGREES,
        "unlikely": UNLIKELY,
        "long": len(analysis.run_table) > LONG,
        "fit_strips": _fit_strips(analysis),
        "exponent_strips": _exponent_strips(analysis),
        "ball_strips": _ball_strips(analysis),
        "defaults": defaults_used(analysis),
        "options": [(key, option_text(value)) for key, value in vars(analysis.options).items()],
        "constants": [(key, _CONSTANT_UNITS[key]) for key in cited.at("constants")],
        "remarks": analysis.readings.metadata,
        "effect_verdict": effect_verdict,
        "fit_names": FIT_NAMES,
        "model_names": MODEL_NAMES,
        "effect_names": EFFECT_NAMES,
        "source_names": SOURCE_NAMES,
    }


def _label(cited: Cited, index: int, torque: Scale) -> Markup:
    """What stood on the rod, as in the figures: "20 g at 15 cm"; where that is not told, the torque."""
    place = f"torques.{index}"
    mass = cited.at(f"{place}.mass")
    if not cited.at(f"{place}.torque"):
        return Markup("no weight")
    if mass is None:
        return Markup('<span class="q">{} {}</span>').format(cited.reading(f"{place}.torque", torque.size), torque)
    scale = mass_scale(mass)
    at = cited.reading(f"{place}.position", CENTIMETRE.size)
    return Markup('<span class="q">{} {} at {} cm</span>').format(cited.reading(f"{place}.mass", scale.size), scale, at)


def _swatch(colour: str, marker: str) -> Markup:
    """Mark of a torque as the figures draw it."""
    return Markup('<svg class="mark" viewBox="0 0 12 12" aria-hidden="true"><path fill="{}" d="{}"/></svg>').format(
        colour, _SHAPES[marker]
    )


def _fit_strips(analysis: Analysis) -> list[Markup]:
    points = [None if fit.inertia is None else _Point(fit.inertia.value, fit.inertia.u) for fit in analysis.fits]
    value, u = analysis.inertia.value, analysis.inertia.u or 0.0
    return _draw_strips(points, (value - u, value + u))


def _exponent_strips(analysis: Analysis) -> list[Markup]:
    overall = analysis.exponent
    points = [None if law.exponent is None else _Point(law.exponent, law.u) for law in analysis.power_law]
    return _draw_strips([*points, _Point(overall.value, overall.u) if overall else None], (1.0, 1.0))


def _ball_strips(analysis: Analysis) -> list[Markup]:
    if analysis.ball is None:
        return []
    value, u = analysis.inertia.value, analysis.inertia.u
    solid = _Point(analysis.ball.inertia, analysis.ball.inertia_u)
    return _draw_strips([_Point(value, u), solid], (value - (u or 0.0), value + (u or 0.0)))


class _Point(NamedTuple):
    """One row's value."""

    value: float
    u: float | None
    """Standard uncertainty, same unit."""


def _draw_strips(points: Sequence[_Point | None], reference: tuple[float, float]) -> list[Markup]:
    """Draw small pictures for the cells of a table, a dot with its uncertainty on one axis for all rows.

    The ends of `reference` are a band behind all rows, or a line where they are equal. Screen readers do not see
    them: the table's cells say the same in numbers.
    """
    drawn = [point for point in points if point is not None]
    low = min([reference[0], *(point.value - (point.u or 0.0) for point in drawn)])
    high = max([reference[1], *(point.value + (point.u or 0.0) for point in drawn)])
    space = 0.05 * (high - low) or 1.0
    low, high = low - space, high + space

    def along(value: float) -> str:
        return f"{100 * (value - low) / (high - low):.1f}%"

    def span(kind: str, start: float, end: float) -> Markup:
        width = f"{100 * (end - start) / (high - low):.1f}%"
        return Markup('<i class="{}" style="left:{};width:{}"></i>').format(kind, along(start), width)

    def mark(kind: str, value: float) -> Markup:
        return Markup('<i class="{}" style="left:{}"></i>').format(kind, along(value))

    strips = []
    for point in points:
        parts = [span("ref", *reference) if reference[1] > reference[0] else mark("line", reference[0])]
        if point is not None:
            u = point.u or 0.0
            parts.append(span("bar", point.value - u, point.value + u))
            parts.append(mark("dot", point.value))
        strips.append(Markup('<span aria-hidden="true">{}</span>').format(Markup("").join(parts)))
    return strips
