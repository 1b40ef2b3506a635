"""Analyse each log once, and draw it once, although several commands and formats show
its analysis.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from unittest.mock import patch

from gyrodata import analysis
from gyrodata.base.errors import LogError
from gyrodata.readings import Readings
from gyrodata.reporting import page
from gyrodata.reporting.figures import Form
from gyrodata.results import Analysis, Options


@contextmanager
def analyzed_once() -> Iterator[None]:
    """Keep the analyses of logs with the same bytes, name and options, and their figures.

    Only for logs that are read without settings, of which an analysis does not know all.
    """
    analyze = analysis.analyze_readings
    known: dict[tuple[str, str, str], Analysis | LogError] = {}

    def analyze_once(readings: Readings, options: Options | None = None) -> Analysis:
        options = options or Options()
        key = readings.name, readings.sha256, repr(options)
        if key not in known:
            try:
                known[key] = analyze(readings, options)
            except LogError as error:
                known[key] = error
        kept = known[key]
        if isinstance(kept, LogError):
            raise kept
        return kept

    with patch.object(analysis, "analyze_readings", analyze_once), drawn_once():
        yield


@contextmanager
def drawn_once() -> Iterator[None]:
    """Keep the figures of an analysis, if all of them could be drawn.

    Those of a log are the same for all settings: for tests that do not look at them.
    """
    render = page.render
    known: dict[tuple[object, ...], dict[Form, dict[str, bytes]]] = {}

    def render_once(
        analysis: Analysis,
        forms: Sequence[Form],
        style: str = "screen",
        *,
        faults: dict[str, str] | None = None,
    ) -> dict[Form, dict[str, bytes]]:
        options = repr(analysis.options)
        key = analysis.name, analysis.sha256, options, tuple(forms), style
        if key not in known:
            drawn = render(analysis, forms, style, faults=faults)
            if faults:
                return drawn
            known[key] = drawn
        return known[key]

    with patch.object(page, "render", render_once):
        yield
