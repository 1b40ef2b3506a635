"""A TOML file read into records: all faults at once, each with its line and what to write instead.

msgspec stops at the first fault and does not know its line, so that it is given each key by itself.
"""

from __future__ import annotations

import datetime as dt
import difflib
import json
import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from types import NoneType
from typing import Annotated, Any, Literal, NamedTuple, get_args, get_origin

from msgspec import Meta, Struct, ValidationError, convert
from msgspec.json import schema
from msgspec.structs import fields

from gyrodata.diagnostics import (
    CRITERION_KIND_UNKNOWN,
    RUBRIC_KEY_UNKNOWN,
    RUBRIC_VALUE_CANNOT_BE_USED,
)
from gyrodata.errors import Diagnostic, InputError

Text = Annotated[str, Meta(pattern=r"\S", examples=["a text"])]
Number = Annotated[float, Meta(ge=0, lt=1e9, examples=[2])]


class UnfitError(ValueError):
    """A value that cannot be used, or a table whose values do not go together."""

    def __init__(self, message: str, hint: str = "", code: str = RUBRIC_VALUE_CANNOT_BE_USED, key: str = "") -> None:
        super().__init__(message)
        self.hint, self.code, self.key = hint, code, key


class Faults:
    """The faults of one file, with where each stands."""

    def __init__(self, name: str, text: str) -> None:
        self.name = name
        self.lines = text.split("\n")
        self.places: dict[Path, Spot] = {}
        self.found: list[Diagnostic] = []

    def add(self, code: str, path: Path, message: str, hint: str = "") -> None:
        """Note a fault of the key at `path`, or of the nearest table above it that has a place of its own."""
        while path and path not in self.places:
            path = path[:-1]
        line, column, width = self.places.get(path, (None, None, 1))
        excerpt = self.lines[line - 1].rstrip("\r") if line and line <= len(self.lines) else ""
        self.found.append(Diagnostic.of(code, message, hint, self.name, line, column, excerpt, width))

    def stop_if_any(self) -> None:
        """Raise what was found, in the order of the file, if anything was."""
        if self.found:
            raise InputError(sorted(self.found, key=lambda d: (d.line or 0, d.column or 0)))


def read_toml(data: bytes, name: str, code: str, hint: str) -> tuple[dict[str, Any], Faults]:
    """Read a TOML file: its values, and what notes the faults in them.

    `code`, `hint`: Diagnostic of a file that is no TOML, and what to write.
    """
    try:
        text = data.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise InputError(
            [Diagnostic.of(code, "is not UTF-8", "save it as UTF-8 in your editor", name, line, 1)]
        ) from None
    faults = Faults(name, text)
    try:
        values = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # a number of more than 4300 digits is a ValueError
        message, _, place = str(error).partition(" (at ")
        at = [int(number) for number in re.findall(r"\d+", place)]
        faults.places[()] = Spot(at[0], at[1], 1) if at else Spot(len(faults.lines), len(faults.lines[-1]) + 1, 1)
        faults.add(code, (), f"this is not TOML: {message}", hint)
        faults.stop_if_any()
        raise
    faults.places = find_places(text)
    return values, faults


# --- values by their types: what `convert` takes, records, and types that have `RAW`, which it takes, and `read` --


def read_record(
    kinds: Sequence[Any], values: Mapping[str, Any], faults: Faults, path: Path = (), points: Any = None
) -> Any:
    """Read a table into the record whose tag it has, each key by itself; None where it has a fault.

    A record with `OTHERS` takes every other key as a table of that kind. `points`: Of the table above.
    """
    before, about = len(faults.found), {"points": points, **values}
    tag = kinds[0].__struct_config__.tag_field
    tags = {one.__struct_config__.tag: one for one in kinds}
    meant = [one for name, one in tags.items() if tag is None or name == values.get(tag)]
    if not meant:
        said = values.get(tag)
        code = CRITERION_KIND_UNKNOWN if isinstance(said, str) else RUBRIC_VALUE_CANNOT_BE_USED
        hint = nearest(str(said), tags) if tag in values else f"write {tag} = {' or '.join(map(json.dumps, tags))}"
        faults.add(code, (*path, tag), f'there is no {tag} "{said}"' if tag in values else f'"{tag}" is missing', hint)
    known = {field.encode_name: field for one in meant or kinds for field in fields(one) if field.name != "others"}
    taken: dict[str, Any] = {}
    for key, field in known.items():
        # What a type of its own reads by default is written as in the file.
        if key in values or (hasattr(_plain(field.type), "read") and isinstance(field.default, str)):
            taken[field.name] = _value(field.type, values.get(key, field.default), faults, (*path, key), about)
        elif field.required:
            faults.add(RUBRIC_VALUE_CANNOT_BE_USED, path, f'"{key}" is missing', _how(key, field.type))
    others = {key: value for key, value in values.items() if key not in known and key != tag}
    if rest := getattr(kinds[0], "OTHERS", None):
        taken["others"] = {key: _value(rest, value, faults, (*path, key), about) for key, value in others.items()}
    elif others:
        # A key that is there already is no proposal: it would then stand twice.
        free = [key for key in (*known, tag) if key and key not in values]
        where = f" in [{_head(path)}]" if path else ""
        for key in others:
            hint = nearest(key, free).replace("known", "take it out; known")
            faults.add(RUBRIC_KEY_UNKNOWN, (*path, key), f'"{key[:60]}" is not known{where}', hint)
    if len(faults.found) > before:
        return None
    try:
        return meant[0](**taken)
    except UnfitError as error:
        faults.add(error.code, (*path, error.key), str(error), error.hint)
        return None


def _value(kind: Any, value: Any, faults: Faults, path: Path, about: Mapping[str, Any]) -> Any:
    """Read what a key has; None where it cannot be used."""
    plain, key, points = _plain(kind), str(path[-1]), about["points"]
    several = get_origin(plain) is tuple
    inner = _plain(get_args(plain)[0]) if several else plain
    tables = [one for one in get_args(inner) or (inner,) if isinstance(one, type) and issubclass(one, Struct)]
    told, hint = value, ""
    if tables:
        listed = value if several else [value]
        if isinstance(listed, list) and listed and all(isinstance(one, dict) for one in listed):
            paths = [(*path, at) for at in range(len(listed))] if several else [path]
            read = [read_record(tables, one, faults, at, points) for one, at in zip(listed, paths, strict=True)]
            return tuple(read) if several else read[0]
        head = f"[{_head(path)}]"
        hint = getattr(tables[0], "HINT", f"write a table, headed {f'[{head}]' if several else head}")
    else:
        try:
            raw = convert(value, getattr(plain, "RAW", kind))
            return plain.read(raw, key, about) if hasattr(plain, "read") else raw
        except UnfitError as error:
            faults.add(error.code, path, str(error), error.hint or _how(key, kind))
            return None
        except ValidationError:
            words = get_args(inner) if get_origin(inner) is Literal else ()
            strange = [one for one in (value if isinstance(value, list) else [value]) if one not in words]
            if len(words) > 1 and strange:
                told, hint = strange[0], nearest(str(strange[0]), words)
    if not isinstance(told, dt.date | dt.time):
        told = json.dumps(told, default=str, ensure_ascii=False)
    faults.add(RUBRIC_VALUE_CANNOT_BE_USED, path, f"{key} = {str(told)[:60]} cannot be used", hint or _how(key, kind))
    return None


def nearest(word: str, known: Iterable[str]) -> str:
    """Propose the known word that is meant, or list them all."""
    close = difflib.get_close_matches(word.lower(), list(known), n=1, cutoff=0.6)
    return f"did you mean {close[0]}?" if close else f"known here: {', '.join(known)}"


def _plain(kind: Any) -> Any:
    """Take from a type what is said about it, and that it may be None."""
    while get_origin(kind) is Annotated or NoneType in get_args(kind):
        kind = get_args(kind)[0]
    return kind


def _how(key: str, kind: Any) -> str:
    """Say what to write: the words, or the examples, of the type's JSON Schema."""
    shape = schema_of(_plain(kind))
    parts = (schema_of(kind), shape, *shape.get("anyOf", ()))
    samples = [json.dumps(one) for part in parts for one in part.get("enum", part.get("examples", ()))]
    if words := (shape.get("items") or {}).get("enum"):
        samples = [json.dumps(words)]
    told = f"write {key} = {' or '.join(samples)}" if samples else f"write a table, headed [[{key}]]"
    return told.replace('"', "") if _plain(kind) is dt.datetime else told


def schema_of(kind: Any) -> dict[str, Any]:
    """Give the JSON Schema of a type."""
    return schema(kind, schema_hook=lambda one: schema(one.RAW))  # type: ignore[attr-defined]


def _head(path: Path) -> str:
    return ".".join(part for part in path if isinstance(part, str))


# --- where the keys stand: `tomllib` gives values without their lines ---------------------------------------


Path = tuple[str | int, ...]
"""Keys from the top; an array of tables has the number of the table, from 0, after its name."""

_LITERAL = re.compile(r"\"{3}.*?\"{3,5}|'{3}.*?'{3,5}|\"(?:\\.|[^\"\\\n])*\"|'[^'\n]*'|#[^\n]*", re.DOTALL)


class Spot(NamedTuple):
    """Where something stands, counted as an editor counts."""

    line: int
    column: int
    width: int


def find_places(text: str) -> dict[Path, Spot]:
    """Find every table and key of a TOML file; of an inline table the table, not its keys."""
    places: dict[Path, Spot] = {}
    count: dict[Path, int] = {}
    table: Path = ()
    begin = end = depth = 0
    number = 1
    # A statement ends with its line, or where the brackets of a value of several lines are closed.
    for line in _LITERAL.sub(lambda found: "#" * len(found[0]), text).split("\n"):
        if depth <= 0:
            number += text.count("\n", begin, end)
            begin, depth = end, 0
        end += len(line) + 1
        depth += len(re.findall(r"[\[{]", line)) - len(re.findall(r"[\]}]", line))
        if depth > 0:
            continue
        value: Any = None
        with suppress(tomllib.TOMLDecodeError):
            value = tomllib.loads(text[begin:end])
        if not value:
            continue
        first = text[begin:end].partition("\n")[0]
        mark = re.match(r"(\s*)(\[+.*?\]+|.*?(?=\s*=))", first)
        assert mark is not None
        spot = Spot(number, len(mark[1]) + 1, len(mark[2]))
        is_head = mark[2].startswith("[")
        path: Path = () if is_head else table
        while value and isinstance(value, dict):
            key, value = next(iter(value.items()))
            path = (*path, key)
            if is_head and isinstance(value, list):
                count[path] = count.get(path, -1) + 1
                path, value = (*path, count[path]), value[0]
            elif is_head and path in count:
                path = (*path, count[path])
            elif not is_head:
                places.setdefault(path, spot)
        if is_head:
            table = path
            places[path] = spot
    return places
