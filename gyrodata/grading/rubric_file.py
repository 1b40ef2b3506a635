"""Read the TOML of a rubric into records by msgspec.

msgspec says what is wrong; this module adds the line of the fault, and what to write
instead.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from functools import reduce
from operator import getitem
from typing import Annotated, Any, TypeVar

from msgspec import Meta, ValidationError, convert
from msgspec.json import schema

from gyrodata.base.errors import Diagnostic, nearest
from gyrodata.base.toml_text import error_at, read_toml

Record = TypeVar("Record")

Text = Annotated[str, Meta(pattern=r"\S", examples=["a text"])]
Number = Annotated[float, Meta(ge=0, lt=1e9, examples=[2])]

Path = tuple[str | int, ...]
"""Keys from the top; after the name of an array of tables, the number of the table,
from 0."""


class UnfitError(ValueError):
    """A value that cannot be used, or values that contradict each other.

    `path` leads there from the record.
    """

    def __init__(self, diagnostic: Diagnostic, path: Path = ()) -> None:
        super().__init__(diagnostic.message)
        self.diagnostic = diagnostic
        self.path = path


def unfit(message: str, /, *path: str | int, **values: object) -> UnfitError:
    """Fill in a message about the key at `path`."""
    return UnfitError(Diagnostic.named(message, **values), path)


class TomlFile:
    """A TOML file: its values, and its text, in which the line of a fault is found.

    Raises InputError.
    """

    def __init__(self, data: bytes, name: str) -> None:
        self.name = name
        self.text, self.values = read_toml(
            data, name, "rubric_not_utf8", "rubric_no_toml"
        )

    def record(self, kind: type[Record], path: Path = ()) -> Record:
        """Read the table at `path` into a record, or raise InputError."""
        values: Any = self.values
        try:
            return convert(reduce(getitem, path, values), kind)
        except ValidationError as error:
            fault, place = _explained(error, kind, path, values)
            spot = _spot(self.text, place)
            raise error_at(fault, self.name, self.text, spot) from None


def _explained(
    error: ValidationError, kind: type, path: Path, values: Any
) -> tuple[Diagnostic, Path]:
    """Say what is wrong and what to write, and where.

    The words come from msgspec and from the JSON Schema of the record.
    """
    message, _, place = str(error).partition(" - at `$")
    path = (*path, *_keys(place))
    cause = error.__cause__
    if isinstance(cause, UnfitError):
        return cause.diagnostic, (*path, *cause.path)
    value = reduce(getitem, path, values)
    what, _, field = message.rstrip("`").partition(" field `")
    names = [part for part in (*path, field) if part and isinstance(part, str)]
    head, key = ["", "", *names][-2:]
    samples = samples_of(kind, head)
    if what == "Object contains unknown":
        # A key that is there already is not proposed: it would then be there twice.
        free = [sample for sample in samples if sample not in value]
        hint = nearest(field, free, "take it out")
        fault = Diagnostic.named("rubric_key_unknown", key=field, hint=hint)
        return fault, (*path, field)
    if field:
        how = _how(key, samples)
        return Diagnostic.named("rubric_key_missing", key=field, how=how), path
    word = value if what.startswith("Invalid enum") else None
    how = _how(key, samples, word) if place else getattr(kind, "HINT", "")
    shown = json.dumps(value, default=str, ensure_ascii=False)
    values = {"key": key, "value": shown, "hint": how}
    return Diagnostic.named("rubric_value_unusable", **values), path


def _how(key: str, samples: Mapping[str, list[Any]], word: object = None) -> str:
    """Say how to write a key, or which word is meant by another `word`."""
    known = samples.get(key, [])
    if isinstance(word, str):
        words = known[0] if isinstance(known[0], list) else known
        return nearest(word, words)
    if known:
        examples = " or ".join(map(json.dumps, known))
        return f"write {key} = {examples}"
    return "see how it is written: gyro grade --print-rubric full"


def _keys(place: str) -> Iterator[str | int]:
    """Yield the keys of a place as msgspec writes it: ``.criterion[0].points``.

    The keys of a table of texts are not known: they end the place.
    """
    known = place.partition("[...]")[0]
    for number, key in re.findall(r"\[(\d+)\]|\.(\w+)", known):
        yield int(number) if number else key


def _spot(text: str, path: Path) -> tuple[int, int, int]:
    """Find the line, the column and the width of the key at `path`.

    If the key has no line of its own, they are those of the nearest table around it
    that has a line.
    """
    spot = (1, 1, 1)
    start = 0
    for name, number in zip(path, (*path, 0)[1:], strict=True):
        marks = []
        if isinstance(name, str):
            marks = _marks(text[start:], name)
        if marks:
            # After the name of an array of tables, the number of the table follows.
            index = number if isinstance(number, int) else 0
            last = len(marks) - 1
            mark = marks[min(index, last)]
            start += mark.start()
            line = text.count("\n", 0, start) + 1
            column = len(mark[1]) + 1
            spot = line, column, len(mark[2])
    return spot


def _marks(text: str, name: str) -> list[re.Match[str]]:
    """Find the heads with a name, or else the lines of the first table with it."""
    word = re.escape(name)
    head = rf"(?m)^([ \t]*)(\[++[^\]#\n]*(?<![\w-]){word}(?![\w-])[^\]\n]*\]+)"
    key = rf"(?m)^([ \t]*)([\"']?{word}[\"']?)(?=[ \t]*=)"
    own = re.split(r"\n(?=[ \t]*\[)", text, maxsplit=1)[0]
    return [*re.finditer(head, text)] or [*re.finditer(key, own)]


def samples_of(kind: type, head: str) -> dict[str, list[Any]]:
    """Return the words or examples that can be written for each key of a table.

    `head`: The key of the table in a record, such as "late"; else that of the record.
    """
    samples: dict[str, list[Any]] = {}
    for key, shape in _keys_below(kind, head).items():
        known = []
        for part in (shape, *shape.get("anyOf", ())):
            known += part.get("enum", part.get("examples", ()))
        words = shape.get("items", {}).get("enum")
        samples[key] = known + ([words] if words else [])
    return samples


def _keys_below(kind: type, head: str) -> Mapping[str, Any]:
    """Return the keys of the table that follows `head`, by the JSON Schema."""
    tables = schema(kind)["$defs"]
    name = kind.__name__
    for table in tables.values():
        place = json.dumps(table["properties"].get(head))
        _, is_table, rest = place.partition('"#/$defs/')
        if is_table:
            name = rest.partition('"')[0]
    keys: Mapping[str, Any] = tables[name]["properties"]
    return keys
