"""The files of a report, made in memory: figures, page, data, and a document where one is asked for."""

from __future__ import annotations

from typing import Literal

from gyrodata import plotting
from gyrodata.reporting.data import json_text, runs_csv
from gyrodata.reporting.latex import latex_report
from gyrodata.reporting.markdown import markdown_report
from gyrodata.reporting.page import report_page
from gyrodata.results import Analysis


def report_files(
    analysis: Analysis,
    figures: plotting.Form = "png",
    style: str = "screen",
    document: str = "",
) -> dict[str, bytes]:
    """Make every file of the report, by name, so that a fault half-way leaves nothing behind.

    `document`: name of one that ends in .md or .tex, if there is to be one.
    """
    markdown = document.endswith(".md")
    shown = shown_form(figures)
    # Markdown shows no PDF either, and LaTeX includes no SVG.
    beside: plotting.Form = shown if markdown else "pdf" if figures == "svg" else figures
    kinds = sorted({figures, beside} if document else {figures})
    drawn = {one: plotting.render(analysis, one, style) for one in {shown, *kinds}}
    looks = plotting.list_looks(analysis)
    words = alternatives(analysis)
    contents = {f"{name}.{one}": data for one in kinds for name, data in drawn[one].items()}
    if markdown:
        contents[document] = markdown_report(analysis, f"{{}}.{shown}", words).encode()
    elif document:
        contents[document] = latex_report(analysis).encode()
    contents["report.html"] = report_page(analysis, drawn[shown], shown, words, looks).encode()
    contents["results.json"] = json_text(analysis.to_dict()).encode()
    contents["runs.csv"] = runs_csv(analysis).encode()
    return contents


def shown_form(figures: plotting.Form) -> Literal["png", "svg"]:
    """Choose what a browser and a reader of Markdown show: no PDF."""
    return "png" if figures == "png" else "svg"


def alternatives(analysis: Analysis) -> dict[str, str]:
    """Say in words what each figure shows."""
    return {name: plotting.alt_text(analysis, name) for name in plotting.FIGURES}
