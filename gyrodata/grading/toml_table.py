"""A TOML file read key by key: all faults at once, each with its line and what to write instead.

Validators made from types (msgspec, pydantic) stop at the first fault or do not know its line. What is asked for, and
how, is the file's JSON Schema: each table notes it as it is read.
"""

from __future__ import annotations

import datetime as dt
import difflib
import math
import re
import tomllib
from bisect import bisect_right
from collections.abc import Sequence
from typing import Any, NamedTuple

from gyrodata.diagnostics import RUBRIC_KEY_UNKNOWN, RUBRIC_NO_TOML, RUBRIC_VALUE_CANNOT_BE_USED
from gyrodata.errors import Diagnostic, InputError
from gyrodata.quantities import parse_uncertainty
from gyrodata.units import UnitError

LARGEST = 1_000_000  # bytes of a rubric that are read

Shape = dict[str, Any]
"""JSON Schema of a value."""

_TYPES = {
    str: "string",
    int: "number",
    float: "number",
    bool: "boolean",
    list: "array",
    dict: "object",
    dt.datetime: "string",  # JSON has no times: editors of TOML take them for texts
}


class Faults:
    """The faults of one TOML file, with where each stands."""

    def __init__(self, name: str, text: str) -> None:
        self.name = name
        self.lines = text.split("\n")
        self.places: dict[Path, Spot] = {}
        self.found: list[Diagnostic] = []

    def add(self, code: str, path: Path, message: str, hint: str = "") -> None:
        """Note a fault of the key at `path`, or of the nearest table above it that has a place of its own."""
        while path and path not in self.places:
            path = path[:-1]
        self.add_at(code, self.places.get(path), message, hint)

    def add_at(self, code: str, spot: Spot | None, message: str, hint: str = "") -> None:
        """Note a fault at a place."""
        line, column, width = spot or (None, None, 1)
        excerpt = self.lines[line - 1].rstrip("\r") if line and line <= len(self.lines) else ""
        self.found.append(Diagnostic.of(code, message, hint, self.name, line, column, excerpt, width))

    def stop_if_any(self) -> None:
        """Raise what was found, in the order of the file, if anything was."""
        if self.found:
            raise InputError(sorted(self.found, key=lambda d: (d.line or 0, d.column or 0)))


class Table:
    """One table of the file; every key is asked for once, and `done` names those that were not."""

    def __init__(self, values: dict[str, Any], path: Path, faults: Faults) -> None:
        self.values = values
        self.path = path
        self.faults = faults
        self.asked: dict[str, Shape] = {}
        self.shape: Shape = {
            "type": "object",
            "properties": self.asked,
            "required": [],
            "additionalProperties": False,
        }
        """JSON Schema of the table, whole once it is read."""

    def wrong(self, key: str, message: str, hint: str, code: str = RUBRIC_VALUE_CANNOT_BE_USED) -> None:
        """Note a fault of one key."""
        self.faults.add(code, (*self.path, key), message, hint)

    def take(self, key: str, kinds: tuple[type, ...], sample: str, required: bool = False) -> Any:
        """Give the value of a key if it is of one of some types, else None and a fault."""
        types = list(dict.fromkeys(_TYPES[kind] for kind in kinds))
        self.asked[key] = {"type": types[0] if len(types) == 1 else types, "description": f"{key} = {sample}"}
        if required:
            self.shape["required"].append(key)
        if key not in self.values:
            if required:
                self.faults.add(
                    RUBRIC_VALUE_CANNOT_BE_USED, self.path, f'"{key}" is missing', f"write {key} = {sample}"
                )
            return None
        value = self.values[key]
        if not isinstance(value, kinds) or (isinstance(value, bool) and bool not in kinds):
            self.wrong(key, f"{key} = {_shown(value)} cannot be used", f"write {key} = {sample}")
            return None
        return value

    def text(self, key: str, sample: str, required: bool = False) -> str | None:
        """Give a text that is not empty."""
        value: str | None = self.take(key, (str,), sample, required)
        self.asked[key]["pattern"] = r"\S"
        if value is not None and not value.strip():
            self.wrong(key, f"{key} is empty", f"write {key} = {sample}")
            return None
        return value

    def time(self, key: str, sample: str) -> dt.datetime | None:
        """Give a time, with its zone or without."""
        value: dt.datetime | None = self.take(key, (dt.datetime,), sample)
        self.asked[key]["pattern"] = r"^\d{4}-\d\d-\d\d[Tt ]\d\d:\d\d"
        return value

    def number(self, key: str, sample: str, required: bool = False) -> float | None:
        """Give a finite number, not below 0."""
        value = self.take(key, (int, float), sample, required)
        self.asked[key] |= {"minimum": 0, "exclusiveMaximum": 1e9}
        if value is None:
            return None
        if not 0 <= value < 1e9:
            self.wrong(key, f"{key} = {str(value)[:40]} is out of range", f"write {key} = {sample}")
            return None
        return float(value)

    def choices(self, key: str, known: Sequence[str], default: tuple[str, ...]) -> tuple[str, ...]:
        """Give a list of words out of the known ones."""
        sample = "[" + ", ".join(f'"{word}"' for word in known) + "]"
        value = self.take(key, (list,), sample)
        self.asked[key] |= {"items": {"enum": list(known)}, "minItems": 1}
        if value is None:
            return default
        for word in value:
            if word not in known:
                self.wrong(key, f"{key}: {_shown(word)} is not known", nearest(str(word), known))
        if not value:
            self.wrong(key, f"{key} is empty", f"write {key} = {sample}")
        return tuple(dict.fromkeys(str(word) for word in value))

    def choice(self, key: str, known: Sequence[str], default: str) -> str:
        """Give one word out of the known ones."""
        value = self.text(key, " or ".join(f'"{word}"' for word in known))
        self.asked[key]["enum"] = list(known)
        if value is None:
            return default
        if value not in known:
            self.wrong(key, f'{key} = "{value}" is not known', nearest(value, known))
        return value

    def deduction(self, key: str, whole: float, default: float, required: bool = False) -> float:
        """Give points: those of "10 %" of a whole, or a number of points."""
        value = self.take(key, (str, int, float), '"10 %" or a number of points', required)
        self.asked[key] |= {"minimum": 0, "pattern": r"%\s*$"}
        if value is None:
            return default
        if isinstance(value, str):
            try:
                share = parse_uncertainty(value, "number").relative if value.strip().endswith("%") else math.nan
            except UnitError:
                share = math.nan
            if math.isnan(share):
                self.wrong(key, f'{key} = "{value[:40]}" cannot be used', f'write {key} = "10 %" or {key} = 2')
                return default
            value = share * whole
        if not 0 <= value <= whole:
            taken = f"{value:g}" if abs(value) < 1e9 else str(value)[:40]
            self.wrong(key, f"{key} takes off {taken} of {whole:g} points", f'write at most {key} = "100 %"')
            return default
        return float(value)

    def table(self, key: str) -> Table | None:
        """Give a table below this one."""
        value = self.take(key, (dict,), f"… as a table [{'.'.join(str(part) for part in (*self.path, key))}]")
        if value is None:
            return None
        table = Table(value, (*self.path, key), self.faults)
        self.asked[key] = table.shape
        return table

    def tables(self, key: str) -> list[Table]:
        """Give an array of tables below this one."""
        name = ".".join(str(part) for part in (*self.path, key))
        value = self.take(key, (list,), f"… as tables [[{name}]]")
        if value is None:
            return []
        if not all(isinstance(item, dict) for item in value):
            self.wrong(key, f"{key} is no list of tables", f"write each as a table of its own, headed [[{name}]]")
            return []
        tables = [Table(item, (*self.path, key, i), self.faults) for i, item in enumerate(value)]
        shapes = [table.shape for table in tables]
        self.asked[key]["items"] = {"oneOf": shapes} if len(shapes) > 1 else shapes[0] if shapes else {"type": "object"}
        return tables

    def done(self) -> None:
        """Name the keys that nothing asked for."""
        for key in self.values:
            if key not in self.asked:
                where = f" in [{'.'.join(str(p) for p in self.path if isinstance(p, str))}]" if self.path else ""
                # A key that is there already is no proposal: it would then stand twice.
                free = [one for one in self.asked if one not in self.values]
                close = difflib.get_close_matches(key.lower(), free, n=1, cutoff=0.6)
                hint = f"did you mean {close[0]}?" if close else f"take it out; known here: {', '.join(self.asked)}"
                self.wrong(key, f'"{key[:60]}" is not known{where}', hint, RUBRIC_KEY_UNKNOWN)


def read_toml(data: bytes, name: str) -> Table:
    """Read a TOML file."""
    if len(data) > LARGEST:
        message = f"a rubric of {len(data)} bytes; at most {LARGEST} are read"
        raise InputError.of(RUBRIC_NO_TOML, message, "give the file of the rubric", name)
    try:
        text = data.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        hint = "save it as UTF-8 in your editor"
        raise InputError([Diagnostic.of(RUBRIC_NO_TOML, "is not UTF-8", hint, name, line, 1)]) from None
    faults = Faults(name, text)
    try:
        values = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        faults.add_at(
            RUBRIC_NO_TOML, _spot_of(str(error), faults.lines), _without_place(str(error)), _syntax_hint(str(error))
        )
        faults.stop_if_any()
        raise
    faults.places = find_places(text)
    return Table(values, (), faults)


def nearest(word: str, known: Sequence[str]) -> str:
    """Propose the known word that is meant, or list them all."""
    close = difflib.get_close_matches(word.lower(), known, n=1, cutoff=0.6)
    return f"did you mean {close[0]}?" if close else f"known here: {', '.join(known)}"


def _shown(value: object) -> str:
    if isinstance(value, str):
        return f'"{value[:60]}"'
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, list):
        return "a list"
    return value.isoformat() if isinstance(value, dt.date | dt.time) else str(value)[:60]


_WHERE = re.compile(r" \(at (?:line (\d+), column (\d+)|end of document)\)")


def _spot_of(message: str, lines: list[str]) -> Spot:
    match = _WHERE.search(message)
    if match is None or match[1] is None:
        return Spot(len(lines), len(lines[-1]) + 1, 1)
    return Spot(int(match[1]), int(match[2]), 1)


def _without_place(message: str) -> str:
    return "this is not TOML: " + _WHERE.sub("", message)


def _syntax_hint(message: str) -> str:
    if "overwrite" in message.lower() or "twice" in message.lower():
        return "the same key stands twice: keep one, or head each criterion with [[criterion]]"
    if "Invalid value" in message or "Unterminated string" in message:
        return 'a text stands in quotation marks, a number does not: id = "log", points = 2'
    return "a line is KEY = VALUE, a table's head is [NAME] or [[criterion]], a remark begins with #"


# --- where the keys stand: `tomllib` gives values without their lines ---------------------------------------


Path = tuple[str | int, ...]
"""Keys from the top; an array of tables has the number of the table, from 0, after its name."""

_PART = r"(?:\"[^\"\n]*\"|'[^'\n]*'|[\w-]+)"
_DOTTED = rf"{_PART}(?:[ \t]*\.[ \t]*{_PART})*"
_LINE = re.compile(rf"[ \t]*(?:(\[\[?)[ \t]*({_DOTTED})[ \t]*\]{{1,2}}|({_DOTTED})[ \t]*=)?")
_LIST = re.compile(r"[ \t]*\[")
_TOKEN = re.compile(
    r"\"{3}.*?\"{3,5}|'{3}.*?'{3,5}|\"(?:\\.|[^\"\\\n])*\"|'[^'\n]*'|#[^\n]*|[\[\]{}\n]|([\w-]+)[ \t]*=", re.DOTALL
)


class Spot(NamedTuple):
    """Where something stands, counted as an editor counts."""

    line: int
    column: int
    width: int


def find_places(text: str) -> dict[Path, Spot]:
    """Find every table and key of a TOML file; of an inline table the table, not its keys, but in a list of them."""
    places: dict[Path, Spot] = {}
    count: dict[Path, int] = {}
    begins = [0, *(match.end() for match in re.finditer("\n", text))]

    def spot(start: int, end: int) -> Spot:
        line = bisect_right(begins, start)
        return Spot(line, start - begins[line - 1] + 1, end - start)

    table: Path = ()
    at = 0
    while at < len(text):
        match = _LINE.match(text, at)
        assert match is not None
        at = match.end()
        if match[1]:
            table = _resolve(_split(match[2]), count)
            if match[1] == "[[":
                count[table] = count.get(table, -1) + 1
                table = (*table, count[table])
            places[table] = spot(match.start(1), at)
        parts = _split(match[3] or "")
        for length in range(1, len(parts) + 1):
            places.setdefault((*table, *parts[:length]), spot(*match.span(3)))
        # To the end of the line, or of a value that goes on over lines.
        in_list = parts and _LIST.match(text, at)
        depth, index = 0, -1
        for token in _TOKEN.finditer(text, at):
            at = token.end()
            depth += (token[0] in "[{") - (token[0] in "]}")
            if token[0] == "\n" and depth <= 0:
                break
            if in_list and depth == 2 and token[0] == "{":
                index += 1
                places[*table, *parts, index] = spot(*token.span())
            elif in_list and depth == 2 and token[1] and index >= 0:
                places[*table, *parts, index, token[1]] = spot(*token.span(1))
        else:
            break
    return places


def _split(dotted: str) -> Path:
    return tuple(part.strip("\"'") for part in re.findall(_PART, dotted))


def _resolve(path: Path, count: dict[Path, int]) -> Path:
    """Give ``[late.x]`` below ``[[late]]`` the number of its table."""
    resolved: Path = ()
    for part in path[:-1]:
        resolved = (*resolved, part)
        if resolved in count:
            resolved = (*resolved, count[resolved])
    return (*resolved, path[-1])
