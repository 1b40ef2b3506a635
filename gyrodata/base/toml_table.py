"""Read a TOML file into records by msgspec.

Report the first fault with its line, and what to write instead.
"""

from __future__ import annotations

import difflib
import json
import re
import tomllib
from collections.abc import Iterable
from functools import reduce
from typing import Annotated, Any, TypeVar

from msgspec import Meta, ValidationError, convert
from msgspec.json import schema

from gyrodata.base.diagnostics import CRITERION_KIND_UNKNOWN, RUBRIC_KEY_UNKNOWN
from gyrodata.base.diagnostics import RUBRIC_VALUE_CANNOT_BE_USED as UNUSABLE
from gyrodata.base.errors import Diagnostic, InputError

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

    def __init__(
        self, message: str, hint: str = "", code: str = UNUSABLE, path: Path | str = ()
    ) -> None:
        super().__init__(message)
        self.hint, self.code, self.path = (
            hint,
            code,
            (path,) if isinstance(path, str) else path,
        )


def unfit(name: str, path: Path | str = (), /, **values: object) -> UnfitError:
    """Fill in a message of a file `messages.toml`."""
    found = Diagnostic.named(name, **values)
    return UnfitError(found.message, found.hint, found.code, path)


class TomlFile:
    """A TOML file: its values, and its text, in which the line of a fault is found.

    `code` and `hint` are the diagnostic of a file that is not TOML, and what to write.
    Raises InputError.
    """

    def __init__(self, data: bytes, name: str, code: str, hint: str) -> None:
        self.name, self.text = (
            name,
            data.decode("utf-8-sig", "surrogateescape").replace("\r\n", "\n"),
        )
        if bad := re.search("[\udc80-\udcff]", self.text):
            line = self.text.count("\n", 0, bad.start()) + 1
            raise self._error(
                code, "is not UTF-8", "save it as UTF-8 in your editor", line
            )
        try:
            self.values: Any = tomllib.loads(self.text)
        except (
            ValueError,
            RecursionError,
        ) as error:  # a number of more than 4300 digits is a ValueError
            found = re.search(r"line (\d+), column (\d+)", str(error))
            place = map(int, found.groups()) if found else [self.text.count("\n") + 1]
            raise self._error(
                code,
                f"this is not TOML: {str(error).partition(' (at ')[0]}",
                hint,
                *place,
            ) from None

    def record(self, kind: type[Record], path: Path = ()) -> Record:
        """Read the table at `path` into a record; raise InputError with the first fault."""
        try:
            return convert(self._value(path), kind)
        except ValidationError as error:
            raise self._explained(error, kind, path) from None

    def _value(self, path: Path) -> Any:
        return reduce(lambda value, part: value[part], path, self.values)

    def _explained(self, error: ValidationError, kind: type, path: Path) -> InputError:
        """Make an error that shows what is wrong and what to write.

        The words come from msgspec and from the JSON Schema of the record.
        """
        message, _, place = str(error).partition(" - at `$")
        for number, key in re.findall(r"\[(\d+|\.\.\.)\]|\.(\w+)", place):
            if (
                number == "..."
            ):  # some key of a table of texts: the first one without a text
                texts = self._value(path)
                path = (
                    *path,
                    min(
                        texts,
                        key=lambda one: (
                            isinstance(texts[one], str),
                            isinstance(texts[one], dict),
                        ),
                    ),
                )
            else:
                path = (*path, int(number) if number else key)
        if isinstance(cause := error.__cause__, UnfitError):
            return self.fault(cause.code, (*path, *cause.path), str(cause), cause.hint)
        value, known = self._value(path), samples_of(kind)
        keys = [part for part in path if isinstance(part, str)]
        if found := re.fullmatch(r"Object missing required field `(.+)`", message):
            return self.fault(
                UNUSABLE,
                path,
                f'"{found[1]}" is missing',
                _how([*keys, found[1]], known),
            )
        if found := re.fullmatch(r"Object contains unknown field `(.+)`", message):
            # A key that is there already is not proposed: it would then be there twice.
            hint = nearest(
                found[1], [one for one in known if one not in value], "take it out"
            )
            where = f" in [{'.'.join(keys)}]" if path else ""
            return self.fault(
                RUBRIC_KEY_UNKNOWN,
                (*path, found[1]),
                f'"{found[1][:60]}" is not known{where}',
                hint,
            )
        key, hint = (
            (keys or [""])[-1],
            _how(keys, known) if place else getattr(kind, "HINT", ""),
        )
        if isinstance(value, str) and message.startswith("Invalid enum"):
            words = [json.loads(word) for word in known[key]]
            hint = nearest(value, words[0] if isinstance(words[0], list) else words)
        code = (
            CRITERION_KIND_UNKNOWN
            if key == "check" and isinstance(value, str)
            else UNUSABLE
        )
        shown = json.dumps(value, default=str, ensure_ascii=False)
        return self.fault(code, path, f"{key} = {shown[:60]} cannot be used", hint)

    def fault(self, code: str, path: Path, message: str, hint: str = "") -> InputError:
        """Make the error of the key at `path`.

        If the key has no line of its own, it is the error of the nearest table around
        it that has a line.
        """
        spot, start = (1, 1, 1), 0
        for name, number in zip(path, (*path, 0)[1:], strict=True):
            rest, word = self.text[start:], re.escape(str(name))
            own = re.split(r"\n(?=[ \t]*\[)", rest, maxsplit=1)[0]
            marks = list(
                re.finditer(
                    rf"(?m)^([ \t]*)(\[++[^\]#\n]*(?<![\w-]){word}(?![\w-])[^\]\n]*\]+)",
                    rest,
                )
            )
            marks = marks or list(
                re.finditer(rf"(?m)^([ \t]*)([\"']?{word}[\"']?)(?=[ \t]*=)", own)
            )
            if marks and isinstance(name, str):
                # After the name of an array of tables, the number of the table follows.
                mark = marks[
                    min(number if isinstance(number, int) else 0, len(marks) - 1)
                ]
                start += mark.start()
                spot = (
                    self.text.count("\n", 0, start) + 1,
                    len(mark[1]) + 1,
                    len(mark[2]),
                )
        return self._error(code, message, hint, *spot)

    def _error(
        self,
        code: str,
        message: str,
        hint: str,
        line: int,
        column: int = 1,
        width: int = 1,
    ) -> InputError:
        excerpt = self.text.split("\n")[line - 1]
        return InputError(
            [
                Diagnostic(
                    code,
                    "error",
                    message,
                    hint,
                    self.name,
                    line,
                    column,
                    excerpt,
                    width,
                )
            ]
        )


def nearest(word: str, known: Iterable[str], otherwise: str = "") -> str:
    """Propose the known word that is probably meant.

    Else say what to do `otherwise`, or list all words.
    """
    close = difflib.get_close_matches(word.lower(), list(known), n=1)
    return (
        f"did you mean {close[0]}?"
        if close
        else otherwise or f"known here: {', '.join(known)}"
    )


def samples_of(kind: type) -> dict[str, list[str]]:
    """Return the words or examples that can be written for each key.

    The keys are those of a record and of all records in it.

    A table has its head without a name: "[]", or "[[]]" if there may be several.
    """
    found: dict[str, list[str]] = {}
    for table in schema(kind)["$defs"].values():
        for key, shape in table.get("properties", {}).items():
            for part in (shape, *shape.get("anyOf", ())):
                items, samples = (
                    part.get("items", {}),
                    part.get("enum", part.get("examples", ())),
                )
                if "enum" in items:
                    samples = [items["enum"]]
                samples = [json.dumps(sample) for sample in samples]
                if "$ref" in part or "$ref" in items or part.get("type") == "object":
                    samples = ["[[]]" if items else "[]"]
                found[key] = list(dict.fromkeys([*found.get(key, ()), *samples]))
    return found


def _how(keys: list[str], known: dict[str, list[str]]) -> str:
    """Write how to write the last of the keys that lead to it."""
    key = keys[-1]
    samples = known.get(key, ['"class"'] if key == "from" else [])
    if not samples:
        return f"write {key} as a text in quotation marks, with its unit if it has one"
    if samples[0] in ("[]", "[[]]"):
        return f"write a table, headed {samples[0].replace('[]', '[' + '.'.join(keys) + ']')}"
    # Times have no quotation marks.
    return re.sub(
        r'"(\d{4}-\d\d-\d\dT.*?)"', r"\1", f"write {key} = {' or '.join(samples)}"
    )
