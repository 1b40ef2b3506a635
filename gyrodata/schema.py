"""The JSON Schema of the outputs and of a rubric, and the table of diagnostics, for programs and for people.

Each schema is made of the records that the output is made of: their annotations are the types, and the text below an
attribute is its description.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from inspect import getdoc, getsource
from typing import Any, Literal, get_args, get_type_hints

import msgspec
from msgspec import Struct

from gyrodata.coverage import SelfCheck
from gyrodata.diagnostics import SEVERITIES, explanations
from gyrodata.prediction import ANSWERS, SCHEMA
from gyrodata.results import AnalysisDocument, CheckDocument, Tool

_DIALECT = "https://json-schema.org/draft/2020-12/schema"


def analysis_schema() -> dict[str, Any]:
    """Give the JSON Schema (2020-12) of "gyro.analysis/2"."""
    return _schema("gyro.analysis/2", AnalysisDocument)


def check_schema() -> dict[str, Any]:
    """Give the JSON Schema (2020-12) of "gyro.check/1"."""
    return _schema("gyro.check/1", CheckDocument)


def selfcheck_schema() -> dict[str, Any]:
    """Give the JSON Schema (2020-12) of "gyro.selfcheck/1"."""
    return _schema("gyro.selfcheck/1", SelfCheck)


def grades_schema() -> dict[str, Any]:
    """Give the JSON Schema (2020-12) of "gyro.grades/1"."""
    from gyrodata.grading.exports.class_json import GradesDocument

    return _schema("gyro.grades/1", GradesDocument)


def rubric_schema() -> dict[str, Any]:
    """Give the JSON Schema (2020-12) of a rubric, "gyro.rubric/1", for editors of TOML."""
    from gyrodata.grading.rubric import rubric_shape

    return {"$schema": _DIALECT, "title": "gyro.rubric/1", **rubric_shape()}


class _Question(Struct):
    """The first keys of every prediction."""

    schema: Literal["gyro.prediction/2"]
    tool: Tool
    prediction: str
    options: Mapping[str, float | bool | None]
    notes: tuple[str, ...]


def predictions_schema() -> dict[str, Any]:
    """Give the JSON Schema (2020-12) of "gyro.prediction/2": a shape for each subcommand of ``gyro predict``.

    SI but for keys that end in a unit.
    """
    whole = _schema(SCHEMA, *ANSWERS.values(), _Question)
    # Each shape is the question and its answer in one object.
    whole["oneOf"].pop()
    question = whole["$defs"].pop("_Question")["properties"]
    for name, answer in ANSWERS.items():
        shape = whole["$defs"][answer.__name__]
        shape["properties"] = question | {"prediction": {"const": name}} | shape["properties"]
        shape["required"] = list(shape["properties"])
    return whole


def diagnostics_table() -> list[dict[str, str]]:
    """List every diagnostic in the order of the codes: "code", "severity", "title", "example"."""
    return [
        {"code": code, "severity": SEVERITIES[code], "title": entry.title, "example": entry.example}
        for code, entry in sorted(explanations().items())
    ]


def _schema(title: str, *records: type) -> dict[str, Any]:
    """Make the JSON Schema of an output that is one of some records; an output contains all keys of its records."""
    shapes, tables = msgspec.json.schema_components(records, ref_template="#/$defs/{name}")
    for record in {part for one in records for part in _records(one)}:
        table, texts = tables[record.__name__], _descriptions(record)
        table["description"] = " ".join((getdoc(record) or "").split("\n\n")[0].split())
        if issubclass(record, Struct):
            table["required"] = list(table["properties"])
        for key, shape in table["properties"].items():
            shape.pop("default", None)
            if key in texts:
                shape["description"] = texts[key]
    one_of = shapes[0] if len(shapes) == 1 else {"oneOf": list(shapes)}
    return {"$schema": _DIALECT, "title": title, **one_of, "$defs": tables}


def _records(kind: Any) -> Iterator[type]:
    """Find the records that a type is made of."""
    if isinstance(kind, type) and hasattr(kind, "__annotations__"):
        yield kind
    for part in get_type_hints(kind).values() if isinstance(kind, type) else get_args(kind):
        yield from _records(part)


def _descriptions(record: type) -> dict[str, str]:
    """Read the text below each attribute of a record."""
    source = "".join(getsource(one) for one in record.__mro__ if one.__module__.startswith("gyrodata"))
    texts = re.findall(r'^    (\w+): [^\n]*\n    """(.*?)"""$', source, re.MULTILINE | re.DOTALL)
    return {name: " ".join(text.split()) for name, text in texts}
