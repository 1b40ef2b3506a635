"""Is an output as its schema says? A schema is made from the source once."""

from __future__ import annotations

from functools import cache
from typing import Any

import jsonschema

from gyrodata.cli import schema


def assert_valid(document: Any, name: str) -> None:
    """See that an output is as the schema of its name says."""
    _validator(name).validate(document)


@cache
def _validator(name: str) -> jsonschema.Draft202012Validator:
    declared = schema.json_schema(name)
    jsonschema.Draft202012Validator.check_schema(declared)
    return jsonschema.Draft202012Validator(declared)
