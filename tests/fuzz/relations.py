"""What has to hold of any log, whatever is in it: an answer that can be believed, or words."""

from __future__ import annotations

import json
import math
import re
import warnings
from functools import lru_cache
from typing import Any

import jsonschema

from gyrodata import reporting, schema
from gyrodata.analysis import analyze_readings
from gyrodata.diagnostics import CODES
from gyrodata.errors import GyroError
from gyrodata.procedure import check_log
from gyrodata.readings import read_log
from gyrodata.results import Analysis, Options

FACTOR = 3.0
"""No answer is further than this from both lines of the textbook, unless the log holds what explains it."""


@lru_cache(maxsize=1)
def _schema() -> Any:
    return jsonschema.Draft202012Validator(schema.analysis_schema())


def try_log(data: bytes, model: str = "auto", thorough: bool = True) -> Analysis | None:
    """Analyse and check a log, write it in every form, and hold the answer against what must be.

    Parameters
    ----------
    data : bytes
        A log, or what somebody takes for one.
    model : str
        As for `gyrodata.analyze`.
    thorough : bool
        Whether `check`, the slower forms and the schema are tried too.

    Returns
    -------
    Analysis or None
        None where the log was refused, in words.

    Raises
    ------
    AssertionError
        If something does not hold.
    Exception
        Any other fault of the tool.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            readings = read_log(data)
        except GyroError as error:
            in_words(error)
            return None
        if readings.ok and thorough:
            for found in check_log(readings)[1]:
                assert found.message
                str(found)
        try:
            analysis = analyze_readings(readings, Options(model=model))
        except GyroError as error:
            in_words(error)
            return None
        text = reporting.json_text(analysis.to_dict())
        assert reporting.summary(analysis)
        assert reporting.runs_csv(analysis).count("\n") >= len(analysis.run_table)
        if thorough:
            assert reporting.markdown_report(analysis)
            assert reporting.latex_report(analysis)
            _schema().validate(json.loads(text))
    _believable(analysis)
    return analysis


def in_words(error: GyroError) -> None:
    """See that a refusal says what is wrong."""
    assert any(found.severity == "error" for found in error.diagnostics)
    for found in error.diagnostics:
        assert found.severity == CODES[found.code].severity
        assert found.message
        # The reader's messages repeat what stands in a cell.
        assert found.code < "G4" or not re.search(r"\bnan\b|\binf\b", found.message + found.hint)


def _believable(analysis: Analysis) -> None:
    inertia, u = analysis.inertia.value, analysis.inertia.u
    assert math.isfinite(inertia)
    assert inertia > 0
    assert u is None or (math.isfinite(u) and u >= 0)
    assert analysis.fit.adjusted.converged
    lines = [fit.inertia.value for fit in analysis.fits[1:] if fit.inertia is not None]
    near = [line for line in lines if line > 0 and 1 / FACTOR < inertia / line < FACTOR]
    assert near or explained(analysis), f"I_zz = {inertia:.3g} ± {u}, lines {lines}"


def explained(analysis: Analysis) -> bool:
    """Whether the log holds a reason why the plain lines of the textbook are far off: its tilt, or an odd run kept."""
    return analysis.model.name != "horizontal" or any(run.flagged and not run.left_out for run in analysis.run_table)
