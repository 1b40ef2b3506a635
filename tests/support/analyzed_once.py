"""Analyse each log once, although several commands and formats show its analysis."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from unittest.mock import patch

from gyrodata import analysis
from gyrodata.base.errors import LogError
from gyrodata.readings import Readings
from gyrodata.results import Analysis, Options


@contextmanager
def analyzed_once() -> Iterator[None]:
    """Keep the analyses of logs with the same bytes, name and options.

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

    with patch.object(analysis, "analyze_readings", analyze_once):
        yield
