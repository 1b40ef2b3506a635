"""The JSON Schema of each output and of a rubric.

Each schema is made from the records of the output: their annotations are the types, and
the text below an attribute is its description.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from inspect import getdoc, getsource
from typing import Any, get_args, get_type_hints

import msgspec
from msgspec import Struct

from gyrodata.grading.exports import GradesDocument
from gyrodata.grading.rubric import rubric_shape
from gyrodata.physics.prediction import Earth, Platform, Precession, Tip, Twist
from gyrodata.results import AnalysisDocument, CheckDocument
from gyrodata.trials.coverage import SelfCheck
from gyrodata.trials.plan import Plan

DOCUMENTS: dict[str, tuple[type, ...]] = {
    "analysis": (AnalysisDocument,),
    "check": (CheckDocument,),
    "grades": (GradesDocument,),
    "plan": (Plan,),
    "predictions": (Earth, Platform, Tip, Precession, Twist),
    "selfcheck": (SelfCheck,),
}
"""Records of each output; an output is one of its records."""


def json_schema(name: str) -> dict[str, Any]:
    """Return a JSON Schema (2020-12).

    Parameters
    ----------
    name : str
        A key of `DOCUMENTS`, or "rubric".
    """
    dialect = "https://json-schema.org/draft/2020-12/schema"
    if name == "rubric":
        return {"$schema": dialect, "title": "gyro.rubric/1", **rubric_shape()}
    records = DOCUMENTS[name]
    (title,) = get_args(get_type_hints(records[0])["schema"])
    shapes, tables = msgspec.json.schema_components(
        records, ref_template="#/$defs/{name}"
    )
    for record in {part for record_type in records for part in _records(record_type)}:
        table = tables[record.__name__]
        texts = _descriptions(record)
        table["description"] = " ".join((getdoc(record) or "").split("\n\n")[0].split())
        if issubclass(record, Struct):
            # An output contains all keys of its records.
            table["required"] = list(table["properties"])
        for key, shape in table["properties"].items():
            shape.pop("default", None)
            if key in texts:
                shape["description"] = texts[key]
    one_of = shapes[0] if len(shapes) == 1 else {"oneOf": list(shapes)}
    return {"$schema": dialect, "title": title, **one_of, "$defs": tables}


def _records(kind: Any) -> Iterator[type]:
    """Find the records that are parts of a type."""
    if isinstance(kind, type) and hasattr(kind, "__annotations__"):
        yield kind
    is_class = isinstance(kind, type)
    parts = [*get_type_hints(kind).values()] if is_class else get_args(kind)
    for part in parts:
        yield from _records(part)


def _descriptions(record: type) -> dict[str, str]:
    """Read the text below each attribute of a record."""
    source = "".join(
        getsource(record_type)
        for record_type in record.__mro__
        if record_type.__module__.startswith("gyrodata")
    )
    texts = re.findall(
        r'^    (\w+): [^\n]*\n    """(.*?)"""$', source, re.MULTILINE | re.DOTALL
    )
    return {name: " ".join(text.split()) for name, text in texts}
