"""The files of a report, made in memory: figures, page, data, and a document if one is asked for."""

from __future__ import annotations

from typing import Literal

from gyrodata import plotting
from gyrodata.reporting.data import json_text, runs_csv
from gyrodata.reporting.latex import latex_report
from gyrodata.reporting.markdown import markdown_report
from gyrodata.reporting.page import report_page
from gyrodata.results import Analysis


def report_files(
    analysis: Analysis, figures: plotting.Form = "png", style: str = "screen", document: str = ""
) -> dict[str, bytes]:
    """Make every file of the report, so that an error leaves no half of it behind.

    Parameters
    ----------
    analysis : Analysis
    figures : {"png", "svg", "pdf"}
        File type of the figures.
    style : {"screen", "slides", "print"}
        Of the figures.
    document : str
        Name of a document that ends in .md or .tex, if there is one.

    Returns
    -------
    dict of str to bytes
        The contents by name of the file.
    """
    shown, kinds = shown_form(figures), {figures}
    if document:
        # Markdown shows no PDF, and LaTeX includes no SVG.
        kinds.add(shown if document.endswith(".md") else "pdf" if figures == "svg" else figures)
    drawn = {one: plotting.render(analysis, one, style) for one in {shown, *kinds}}
    alt = alternatives(analysis)
    texts = {
        "report.html": report_page(analysis, drawn[shown], shown, alt, plotting.list_looks(analysis)),
        "results.json": json_text(analysis.to_dict()),
        "runs.csv": runs_csv(analysis),
    }
    if document:
        is_markdown = document.endswith(".md")
        texts[document] = markdown_report(analysis, f"{{}}.{shown}", alt) if is_markdown else latex_report(analysis)
    files = {f"{name}.{one}": data for one in sorted(kinds) for name, data in drawn[one].items()}
    return files | {name: text.encode() for name, text in texts.items()}


def shown_form(figures: plotting.Form) -> Literal["png", "svg"]:
    """Choose what a browser and a reader of Markdown show: no PDF."""
    return "png" if figures == "png" else "svg"


def alternatives(analysis: Analysis) -> dict[str, str]:
    """Describe each figure in words."""
    return {name: plotting.alt_text(analysis, name) for name in plotting.FIGURES}
