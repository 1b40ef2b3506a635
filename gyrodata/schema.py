"""The JSON Schema of the outputs and of a rubric, and the table of diagnostics, for programs and for people.

What is emitted from records (`results`, `selfcheck`) is declared from the same records: their annotations give the
types, and the text below an attribute its description.
"""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections.abc import Mapping
from itertools import pairwise
from types import MappingProxyType, NoneType, UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

from msgspec import Struct

from gyrodata.coverage import SelfCheck
from gyrodata.diagnostics import CODES
from gyrodata.errors import Diagnostic
from gyrodata.prediction import ANSWERS, SCHEMA
from gyrodata.results import AnalysisDocument, CheckDocument, Tool

_DIALECT = "https://json-schema.org/draft/2020-12/schema"


def analysis_schema() -> dict[str, Any]:
    """Give the JSON Schema (2020-12) of "gyro.analysis/2"."""
    return _document("gyro.analysis/2", _type(AnalysisDocument))


def check_schema() -> dict[str, Any]:
    """Give the JSON Schema (2020-12) of "gyro.check/1"."""
    return _document("gyro.check/1", _type(CheckDocument))


def selfcheck_schema() -> dict[str, Any]:
    """Give the JSON Schema (2020-12) of "gyro.selfcheck/1"."""
    return _document("gyro.selfcheck/1", _type(SelfCheck))


def _document(name: str, schema: Mapping[str, Any]) -> dict[str, Any]:
    return {"$schema": _DIALECT, "title": name, **schema}


# --- from types ----------------------------------------------------------------------------------------------

_NAMES: dict[Any, str] = {str: "string", float: "number", int: "integer", bool: "boolean", NoneType: "null"}


def _type(hint: Any) -> dict[str, Any]:
    """Give the schema of an annotation."""
    if hint in _NAMES:
        return {"type": _NAMES[hint]}
    if isinstance(hint, type) and issubclass(hint, Struct):
        return _record(hint)
    origin, args = get_origin(hint), get_args(hint)
    if origin is Literal:
        return {"enum": list(args)} if len(args) > 1 else {"const": args[0]}
    if origin in (Union, UnionType):
        parts = [_type(one) for one in args]
        plain = all(list(part) == ["type"] for part in parts)
        return {"type": [part["type"] for part in parts]} if plain else {"anyOf": parts}
    if origin is tuple and args[-1] is Ellipsis:
        return _list(_type(args[0]))
    if origin is tuple:
        return _list(_type(args[0])) | {"minItems": len(args), "maxItems": len(args)}
    if origin is Mapping:
        return {"type": "object", "additionalProperties": _type(args[1])}
    raise TypeError(f"{hint} has no JSON")


def _record(record: Any) -> dict[str, Any]:
    """Give the schema of a record."""
    hints, told = get_type_hints(record), _descriptions(record)
    # A diagnostic's excerpt is for people.
    names = Diagnostic("", "note", "").to_dict() if record is Diagnostic else record.__struct_fields__
    properties = {name: _type(hints[name]) | ({"description": told[name]} if name in told else {}) for name in names}
    return _object(properties, description=(record.__doc__ or "").split("\n\n", maxsplit=1)[0])


def _properties(record: Any, by_hand: Mapping[str, Any] = MappingProxyType({})) -> dict[str, Any]:
    """Give the schema of each field of a record, without a description; None by hand leaves a field out."""
    hints, names = get_type_hints(record), zip(record.__struct_fields__, record.__struct_encode_fields__, strict=True)
    found = {key: by_hand[name] if name in by_hand else _type(hints[name]) for name, key in names}
    return {key: schema for key, schema in found.items() if schema is not None}


def _descriptions(record: type) -> dict[str, str]:
    """Give the text that stands below each attribute."""
    (body,) = ast.parse(textwrap.dedent(inspect.getsource(record))).body
    assert isinstance(body, ast.ClassDef)
    return {
        one.target.id: " ".join(inspect.cleandoc(text.value.value).split())
        for one, text in pairwise(body.body)
        if isinstance(one, ast.AnnAssign)
        and isinstance(one.target, ast.Name)
        and isinstance(text, ast.Expr)
        and isinstance(text.value, ast.Constant)
        and isinstance(text.value.value, str)
    }


def _object(properties: Mapping[str, Any], **more: Any) -> dict[str, Any]:
    return {"type": "object", "properties": dict(properties), "required": list(properties), **more}


def _list(items: Mapping[str, Any]) -> dict[str, Any]:
    return {"type": "array", "items": dict(items)}


def _or_null(schema: Mapping[str, Any]) -> dict[str, Any]:
    return {"anyOf": [dict(schema), {"type": "null"}]}


# --- by hand: what higher rooms emit --------------------------------------------------------------------------------

_NUMBER = _type(float)
_COUNT = _type(int)
_MAYBE = _type(float | None)
_TEXT = _type(str)
_MAYBE_TEXT = _type(str | None)
_TOOL = _type(Tool)
_DIAGNOSTIC = _type(Diagnostic)
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
    """Give the JSON Schema (2020-12) of "gyro.grades/1": all quantities are SI, times seconds."""
    from gyrodata.grading import BenchScatter, CriterionFigures, Decision, Grade, Mark, Slip

    not_told = {"type": "object", "maxProperties": 0, "description": "nothing is reported"}
    by_hand = {
        "marks": _list(_object(_properties(Mark), description="points null: it could not be judged, which is no zero")),
        "slips": _list(_object(_properties(Slip))),
        "by_hand": _list(_object(_properties(Decision))),
        "reported": {
            "anyOf": [_object({"text": _TEXT, "value": _MAYBE, "u": _MAYBE, "line": _type(int | None)}), not_told]
        },
        "own": {"type": "object", "additionalProperties": _object({"value": _NUMBER, "u": _MAYBE})},
        "diagnostics": _list(_DIAGNOSTIC),
        # These two are told once for the class, and kept in the journal.
        "title": None,
        "fingerprint": None,
    }
    student = _properties(Grade, by_hand) | {"flags": _list(_TEXT), "ids": _type(Mapping[str, str])}
    whole = _object(
        {
            "schema": {"const": "gyro.grades/1"},
            "tool": _TOOL,
            "input": _object(
                {"name": _TEXT, "lms": _TEXT, "submissions": _COUNT, "rubric": _TEXT, "rubric_sha256": _TEXT}
            ),
            "title": _TEXT,
            "out_of": _NUMBER,
            "summary": _object({"graded": _COUNT, "not_graded": _COUNT, "mean": _MAYBE, "median": _MAYBE}),
            "criteria": _list(_object(_properties(CriterionFigures))),
            "references": {
                "type": "object",
                "additionalProperties": _object({"inertia": _NUMBER, "u": _NUMBER, "source": _TEXT}),
            },
            "scatters": {"type": "object", "additionalProperties": _object(_properties(BenchScatter))},
            "absent": _list(_object(dict.fromkeys(("student", "name", "section"), _TEXT))),
            "slips": {"type": "object", "additionalProperties": _list(_TEXT)},
            "flags": _list(_FLAGGED),
            "changes": _or_null(_list(_CHANGE)),
            "diagnostics": _list(_DIAGNOSTIC),
            "students": _list(
                _object(
                    student,
                    description='a line of --format ndjson is such an object, with "schema": "gyro.grade/1" and "tool"',
                )
            ),
        }
    )
    return _document("gyro.grades/1", whole)


def rubric_schema() -> dict[str, Any]:
    """Give the JSON Schema (2020-12) of a rubric, "gyro.rubric/1", for editors of TOML."""
    from gyrodata.grading import rubric_shape

    return _document("gyro.rubric/1", rubric_shape())


def predictions_schema() -> dict[str, Any]:
    """Give the JSON Schema (2020-12) of "gyro.prediction/2": a shape for each subcommand of ``gyro predict``.

    SI but for keys that end in a unit.
    """
    shapes = [
        _object(
            {
                "schema": {"const": SCHEMA},
                "tool": _TOOL,
                "prediction": {"const": name},
                "options": _type(Mapping[str, float | bool | None]),
                "notes": _list(_TEXT),
                **_record(answer)["properties"],
            },
            description=answer.__doc__.split("\n\n", maxsplit=1)[0] if answer.__doc__ else "",
        )
        for name, answer in ANSWERS.items()
    ]
    return _document(SCHEMA, {"oneOf": shapes})


def diagnostics_table() -> list[dict[str, str]]:
    """List every diagnostic in the order of the codes: "code", "severity", "title", "example"."""
    return [
        {"code": code, "severity": entry.severity, "title": entry.title, "example": entry.example}
        for code, entry in sorted(CODES.items())
    ]
