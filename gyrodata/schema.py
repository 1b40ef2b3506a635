"""The JSON Schema of the outputs, and the table of diagnostics, for programs and for people."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gyrodata.errors import CODES

_DIALECT = "https://json-schema.org/draft/2020-12/schema"

_NUMBER: dict[str, Any] = {"type": "number"}
_COUNT: dict[str, Any] = {"type": "integer"}
_MAYBE: dict[str, Any] = {"type": ["number", "null"]}
_TEXT: dict[str, Any] = {"type": "string"}
_FLAG: dict[str, Any] = {"type": "boolean"}


def _object(properties: Mapping[str, Any], **more: Any) -> dict[str, Any]:
    return {"type": "object", "properties": dict(properties), "required": list(properties), **more}


def _list(items: Mapping[str, Any]) -> dict[str, Any]:
    return {"type": "array", "items": dict(items)}


def _or_null(schema: Mapping[str, Any]) -> dict[str, Any]:
    return {"anyOf": [dict(schema), {"type": "null"}]}


_RESULT = _object(
    {
        "value": _NUMBER,
        "u": _MAYBE,
        "unit": _TEXT,
        "interval_95": _or_null({"type": "array", "items": _NUMBER, "minItems": 2, "maxItems": 2}),
        "k": _MAYBE,
        "dof": _MAYBE,
        "relative_u": _MAYBE,
    },
    description="value ± k·u is the 95 % interval; dof null: infinite, see dof_reason",
)
_ESTIMATE = _object({"value": _NUMBER, "u": _MAYBE, "unit": _TEXT})
_DIAGNOSTIC = _object(
    {
        "code": _TEXT,
        "severity": {"enum": ["error", "warning", "note"]},
        "file": _TEXT,
        "line": {"type": ["integer", "null"]},
        "column": {"type": ["integer", "null"]},
        "message": _TEXT,
        "hint": _TEXT,
    }
)
_RUN = _object(
    {
        "run": _TEXT,
        "line": {"type": "integer"},
        "mass": _MAYBE,
        "position": _MAYBE,
        "torque": _NUMBER,
        "spin": _NUMBER,
        "time": _NUMBER,
        "turns": _NUMBER,
        "precession_rate": _NUMBER,
        "period": _NUMBER,
        "product": _NUMBER,
        "inertia": _MAYBE,
        "residual": _NUMBER,
        "residual_u": _NUMBER,
        "deviation": _MAYBE,
        "flagged": _FLAG,
        "left_out": _FLAG,
        "reason": _TEXT,
    }
)
_HEAD = {
    "tool": _object({"name": {"const": "gyrodata"}, "version": _TEXT}),
    "input": _object({"name": _TEXT, "sha256": {"type": ["string", "null"]}, "rows": {"type": ["integer", "null"]}}),
}


def analysis_schema() -> dict[str, Any]:
    """Give the JSON Schema (2020-12) of "gyro.analysis/1".

    Returns
    -------
    dict
        All quantities are SI. New keys may be added within a schema number; none is renamed or taken away.
    """
    result = _object(
        {
            "inertia": _RESULT,
            "imbalance": _RESULT,
            "timing_bias": _RESULT,
            "goodness": _object({"chi2": _NUMBER, "dof": {"type": "integer"}, "p": _MAYBE, "birge": _MAYBE}),
            "fits": _list(
                _object(
                    {
                        "name": _TEXT,
                        "inertia": _or_null(_ESTIMATE),
                        "constant": _or_null(_ESTIMATE),
                        "note": _TEXT,
                        "difference": _MAYBE,
                        "deviation": _MAYBE,
                    }
                )
            ),
            "budget": _list(_object({"source": _TEXT, "shared": _FLAG, "u_inertia": _NUMBER, "share": _NUMBER})),
            "constants": {"type": "object", "additionalProperties": _NUMBER},
            "model": {"enum": ["horizontal", "steady", "released"]},
            "effects": _list(
                _object({"effect": _TEXT, "bias": _MAYBE, "size": _MAYBE, "kept": _FLAG, "reason": _TEXT})
            ),
            "power_law": _list(_object({"torque": _NUMBER, "exponent": _MAYBE, "u": _MAYBE, "reason": _TEXT})),
            "exponent": _or_null(
                _object({"value": _NUMBER, "u": _NUMBER, "deviation": _NUMBER, "torques": {"type": "integer"}})
            ),
            "constancy": _or_null(
                _object(
                    {
                        "scatter": _NUMBER,
                        "expected": _NUMBER,
                        "chi2": _NUMBER,
                        "dof": {"type": "integer"},
                        "p": _NUMBER,
                    }
                )
            ),
            "ball": _or_null(
                _object(
                    {
                        "mass": _NUMBER,
                        "mass_u": _MAYBE,
                        "diameter": _NUMBER,
                        "diameter_u": _MAYBE,
                        "inertia": _NUMBER,
                        "inertia_u": _MAYBE,
                        "difference": _NUMBER,
                        "difference_u": _MAYBE,
                        "relative": _NUMBER,
                        "deviation": _MAYBE,
                    }
                )
            ),
            "torques": _list(
                _object(
                    {
                        "mass": _MAYBE,
                        "position": _MAYBE,
                        "torque": _NUMBER,
                        "runs": {"type": "integer"},
                        "product": _object({"value": _NUMBER, "u": _NUMBER, "spread": _MAYBE}),
                        "period_per_spin": _object({"value": _NUMBER, "u": _NUMBER}),
                    }
                )
            ),
            "runs": _list(_RUN),
            "advice": _list(_TEXT),
        }
    )
    return _document("gyro.analysis/1", {"options": {"type": "object"}, "result": _or_null(result)})


def check_schema() -> dict[str, Any]:
    """Give the JSON Schema (2020-12) of "gyro.check/1".

    Returns
    -------
    dict
    """
    return _document("gyro.check/1", {"clean": _FLAG})


_DETAIL: dict[str, Any] = {"type": "object", "additionalProperties": {"type": ["number", "string", "null"]}}
_MARK = _object(
    {
        "criterion": _TEXT,
        "title": _TEXT,
        "check": _TEXT,
        "points": _MAYBE,
        "out_of": _NUMBER,
        "reason": _TEXT,
        "detail": _DETAIL,
        "rule": _TEXT,
    },
    description="points null: it could not be judged, which is no zero",
)
_SLIP = _object(
    {
        "kind": _TEXT,
        "words": _TEXT,
        "check": _TEXT,
        "factor": _NUMBER,
        "fit": _TEXT,
        "u": _MAYBE,
        "distance": _NUMBER,
    }
)
_OWN = {"type": "object", "additionalProperties": _object({"value": _NUMBER, "u": _MAYBE})}
_NAMES: dict[str, Any] = {"type": "object", "additionalProperties": _TEXT}
_MAYBE_TEXT: dict[str, Any] = {"type": ["string", "null"]}
_STUDENT = _object(
    {
        "student": _TEXT,
        "name": _TEXT,
        "status": {"enum": ["graded", "not graded"]},
        "why": _MAYBE_TEXT,
        "points": _MAYBE,
        "out_of": _NUMBER,
        "marks": _list(_MARK),
        "slips": _list(_SLIP),
        "look": _list(_TEXT),
        "station": _MAYBE_TEXT,
        "reported": {
            "type": "object",
            "properties": {"text": _TEXT, "value": _MAYBE, "u": _MAYBE, "line": {"type": ["integer", "null"]}},
        },
        "own": _OWN,
        "inertia": _MAYBE,
        "inertia_u": _MAYBE,
        "matched": _MAYBE_TEXT,
        "d": _MAYBE,
        "z": _MAYBE,
        "late_seconds": _MAYBE,
        "late_deduction": _NUMBER,
        "late_reason": _TEXT,
        "diagnostics": _list(_DIAGNOSTIC),
        "rubric": _TEXT,
        "digest": _TEXT,
        "flags": _list(_TEXT),
        "ids": _NAMES,
    },
    description='a line of --format ndjson is such an object, with "schema": "gyro.grade/1" and "tool"',
)
_CRITERION = _object(
    {
        "id": _TEXT,
        "title": _TEXT,
        "out_of": _NUMBER,
        "judged": _COUNT,
        "full": _COUNT,
        "none": _COUNT,
        "mean": _MAYBE,
    }
)
_FLAGGED = _object(
    {
        "kind": _TEXT,
        "students": _list(_TEXT),
        "previous": _list(_TEXT),
        "evidence": _TEXT,
        "p": _NUMBER,
        "expected": _NUMBER,
    },
    description="expected: how many such flags chance makes in an honest class of this size",
)
_CHANGE = _object(
    {
        "student": _TEXT,
        "name": _TEXT,
        "from": _MAYBE_TEXT,
        "to": _MAYBE_TEXT,
        "parts": _list(_object({"column": _TEXT, "from": _TEXT, "to": _TEXT})),
    }
)


def grades_schema() -> dict[str, Any]:
    """Give the JSON Schema (2020-12) of "gyro.grades/1".

    Returns
    -------
    dict
        All quantities are SI, times seconds.
    """
    whole = _object(
        {
            "schema": {"const": "gyro.grades/1"},
            "tool": _HEAD["tool"],
            "input": _object(
                {"name": _TEXT, "lms": _TEXT, "submissions": _COUNT, "rubric": _TEXT, "rubric_sha256": _TEXT}
            ),
            "title": _TEXT,
            "out_of": _NUMBER,
            "summary": _object({"graded": _COUNT, "not_graded": _COUNT, "mean": _MAYBE, "median": _MAYBE}),
            "criteria": _list(_CRITERION),
            "references": {
                "type": "object",
                "additionalProperties": _object({"inertia": _NUMBER, "u": _NUMBER, "source": _TEXT}),
            },
            "slips": {"type": "object", "additionalProperties": _list(_TEXT)},
            "flags": _list(_FLAGGED),
            "changes": _or_null(_list(_CHANGE)),
            "diagnostics": _list(_DIAGNOSTIC),
            "students": _list(_STUDENT),
        }
    )
    return {"$schema": _DIALECT, "title": "gyro.grades/1", **whole}


_DIRECTION = _object(
    {
        "hours": _NUMBER,
        "sidereal_hours": _NUMBER,
        "azimuth_deg": _MAYBE,
        "altitude_deg": _NUMBER,
        "reason": _TEXT,
    }
)
_PREDICTIONS: dict[str, dict[str, Any]] = {
    "precession": {
        **dict.fromkeys(("slow", "fast", "horizontal", "period"), _MAYBE),
        "exists": _FLAG,
        "critical_spin": _NUMBER,
        "reason": _TEXT,
        "released": _object(
            {
                **dict.fromkeys(("mean_rate", "sag", "nutation_rate", "click_error_s"), _MAYBE),
                "greatest_sag": _NUMBER,
                "reason": _TEXT,
            }
        ),
        "sleeping": _object({"stable": _FLAG, "critical_spin": _NUMBER, "growth_rate": _NUMBER}),
    },
    "earth": {"sidereal_day_hours": _NUMBER, "north": _list(_DIRECTION), "east": _list(_DIRECTION)},
    "platform": {
        "rate": _NUMBER,
        "period": _MAYBE,
        **dict.fromkeys(("momentum_before", "momentum_after", "momentum_platform"), _NUMBER),
        "reason": _TEXT,
    },
    "tip": {**dict.fromkeys(("speed", "turning_rate", "torque", "angle_deg"), _NUMBER), "direction": _TEXT},
}


def predictions_schema() -> dict[str, Any]:
    """Give the JSON Schema (2020-12) of "gyro.prediction/1".

    Returns
    -------
    dict
        One shape for each subcommand of ``gyro predict``; SI but for keys that end in a unit.
    """
    shapes = [
        _object(
            {
                "schema": {"const": "gyro.prediction/1"},
                "tool": _HEAD["tool"],
                "prediction": {"const": name},
                "options": {"type": "object"},
                "notes": _list(_TEXT),
                **answer,
            }
        )
        for name, answer in _PREDICTIONS.items()
    ]
    return {"$schema": _DIALECT, "title": "gyro.prediction/1", "oneOf": shapes}


def _document(name: str, more: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "$schema": _DIALECT,
        "title": name,
        **_object({"schema": {"const": name}, **_HEAD, **more, "diagnostics": _list(_DIAGNOSTIC)}),
    }


def diagnostics_table() -> list[dict[str, str]]:
    """List every diagnostic code with its severity, title and an example that raises it.

    Returns
    -------
    list of dict
        Keys "code", "severity", "title", "example", in the order of the codes.
    """
    return [
        {"code": code, "severity": entry.severity, "title": entry.title, "example": entry.example}
        for code, entry in sorted(CODES.items())
    ]
