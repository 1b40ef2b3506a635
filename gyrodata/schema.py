"""The JSON Schema of the outputs, and the table of diagnostics, for programs and for people."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gyrodata.errors import CODES

_NUMBER: dict[str, Any] = {"type": "number"}
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


def _document(name: str, more: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
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
